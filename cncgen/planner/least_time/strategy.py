"""`optimal`: the least time within the limits, and within a bound of the contour error where one is asked for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cncgen.machine.record import Machine
from cncgen.planner.least_time.roundings import plan_roundings
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Trajectory
from cncgen.toolpath.record import Toolpath


def plan_least_time(
    chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions
) -> Iterator[Trajectory]:
    """Plan the least time, with the predicted contour error under ``options.max_contour_error_mm`` where that is given.

    Args:
        chunks: Consecutive stretches of one program; drawn in another thread.
        machine: Limits, period, chord tolerance, servo data.
        options: The bound, servo data that stand in for the machine's, effort.

    Yields:
        Trajectories, from rest to rest, as their speeds become final.

    Raises:
        UsageError: The error is bounded, and cannot be predicted: see `cncgen.planner.least_time.contour_bound.plan_bounded`.
        NoPlanError: No motion within the limits was found.
    """
    if options.max_contour_error_mm is None:
        return plan_roundings(chunks, machine, options.effort)
    from cncgen.planner.least_time.contour_bound import plan_bounded

    return plan_bounded(chunks, machine, options, options.max_contour_error_mm)
