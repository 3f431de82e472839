"""Step limiting that keeps the drives out of saturation (Yeh and Sun 2008)."""

from __future__ import annotations

from collections.abc import Iterator

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine.record import Machine
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Trajectory


def limit_reactive(
    trajectories: Iterator[Trajectory], machine: Machine, options: PlanOptions
) -> Iterator[Trajectory]:
    """Return the trajectories with their steps limited; `off` and `predictive` (the planner's own) change nothing."""
    if options.saturation != "reactive":
        return trajectories
    raise UsageError(Diagnostic("option-value", "saturation reactive is not available yet"))
