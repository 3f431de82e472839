"""The feedrate strategies by name; the module of each is imported when it is first asked for."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Iterator
from typing import Protocol

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine.record import Machine
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Trajectory
from cncgen.toolpath.record import Toolpath

#: Name -> (module, function), the default first.
_STRATEGIES = {
    "optimal": ("cncgen.planner.least_time.strategy", "plan_least_time"),
    "ild": ("cncgen.planner.ild.strategy", "plan_ild"),
    "constant": ("cncgen.planner.baselines.strategy", "plan_constant"),
    "adaptive": ("cncgen.planner.baselines.strategy", "plan_adaptive"),
    "curvature": ("cncgen.planner.baselines.strategy", "plan_curvature"),
}


class Strategy(Protocol):
    """A feedrate strategy: chunks of a toolpath in, stretches of planned motion out, as they become final."""

    def __call__(
        self, chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions
    ) -> Iterator[Trajectory]:
        """Plan the chunks on the machine."""
        ...


FEEDRATES = tuple(_STRATEGIES)


def strategy(name: str | None) -> Strategy:
    """Return the strategy of that name, the default for None; raise `UsageError` for any other name."""
    chosen = name or FEEDRATES[0]
    if chosen not in _STRATEGIES:
        raise UsageError(
            Diagnostic("option-value", f"feedrate = {chosen!r} is not one of {', '.join(FEEDRATES)}")
        )
    module, function = _STRATEGIES[chosen]
    found: Strategy = getattr(importlib.import_module(module), function)
    return found
