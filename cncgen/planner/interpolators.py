"""Interpolators: how the position advances in a period where it is not by exact arc length."""

from __future__ import annotations

from collections.abc import Iterator

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine.record import Machine
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Trajectory


def retime(
    trajectories: Iterator[Trajectory], machine: Machine, options: PlanOptions
) -> Iterator[Trajectory]:
    """Return the trajectories as the interpolator of the options would travel them; `arclength` changes nothing."""
    if options.interpolator == "arclength":
        return trajectories
    raise UsageError(Diagnostic("option-value", f"interpolator {options.interpolator} is not available yet"))
