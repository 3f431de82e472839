"""Planning: a toolpath and a machine become a trajectory, s(t) with the machine's limits held.

`plan` is the door: it checks what was asked, runs the feedrate strategy (`strategies`), retimes for an interpolator
other than the exact one (`interpolators`) and limits the steps where the drives would saturate (`saturation`). Each
of the three takes and yields `Trajectory`, chunk by chunk.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cncgen.machine.record import Machine
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Trajectory
from cncgen.toolpath.record import Toolpath

__all__ = ["PlanOptions", "Trajectory", "plan"]


def plan(
    chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions | None = None
) -> Iterator[Trajectory]:
    """Plan chunks of a toolpath on a machine.

    Args:
        chunks: Consecutive stretches of one program.
        machine: Limits, period and servo data.
        options: What is asked; by default the best strategy installed, exact interpolation, no saturation.

    Yields:
        `Trajectory` after `Trajectory`, without a gap in time or position, each as soon as it is final. What a stage
        has to say to the user stands in ``values["diagnostics"]``, a tuple of `Diagnostic`.

    Raises:
        UsageError: An option has an unknown value; servo data that it needs are missing.
        ProgramError: The program moves an axis that the machine does not have, or beyond its travel.
        NoPlanError: No plan exists within the limits.
    """
    from cncgen.planner import interpolators, saturation
    from cncgen.planner.checks import checked
    from cncgen.planner.strategies import strategy

    asked = options or PlanOptions()
    asked.check()
    planned = strategy(asked.feedrate)(checked(chunks, machine, asked), machine, asked)
    retimed = interpolators.retime(planned, machine, asked)
    return saturation.limit_reactive(retimed, machine, asked)
