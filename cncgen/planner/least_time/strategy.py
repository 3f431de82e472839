"""`optimal`: the least time within the limits, and within a bound of the contour error where one is asked for."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from cncgen.machine.record import Machine
from cncgen.planner.least_time.block_planning import PREFETCHED, plan_blocks, smooth_blocks
from cncgen.planner.least_time.prefetch import prefetch
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Trajectory
from cncgen.ranges import FEEDS
from cncgen.toolpath.record import Toolpath
from cncgen.units import to_file


def plan_least_time(
    chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions
) -> Iterator[Trajectory]:
    """Plan the least time, with the predicted contour error under ``options.max_contour_error_mm`` where that is given.

    Args:
        chunks: Consecutive stretches of one program; drawn in another thread.
        machine: Limits, period, chord tolerance, servo data.
        options: The bound, servo data that stand in for the machine's, effort. With the effort ``best``, exact interpolation, no
            saturation and no bound of the centripetal acceleration, path and speed are planned together where rows have a tolerance (`cncgen.planner.tube`).

    Yields:
        Trajectories, from rest to rest, as their speeds become final.

    Raises:
        UsageError: The error is bounded, and cannot be predicted: see `cncgen.planner.least_time.contour_bound.plan_bounded`.
        NoPlanError: No motion within the limits was found.
    """
    if options.max_contour_error_mm is None:
        along = options.effort == "fast" or options.interpolator != "arclength" or options.saturation != "off"
        if along or machine.max_centripetal_mm_s2 is not None:
            return plan_blocks(smooth_blocks(chunks, machine), machine)
        from cncgen.planner.tube import Programmed, chorded, cornered, improve

        fastest = math.hypot(*(axis.max_velocity * to_file(letter) for letter, axis in machine.axes.items()))
        program = Programmed(machine.chord_tolerance_mm, min(fastest, FEEDS[1]))
        blocks = smooth_blocks(
            chunks, machine, lambda steady: chorded(program.over(cornered(steady)), machine)
        )
        plan = plan_blocks(blocks, machine, coarse=True)
        # The search beside the plan that it starts from, and both beside sampling and writing.
        ahead = prefetch(plan, PREFETCHED)
        return prefetch(improve(ahead, program, machine, options.max_steps), PREFETCHED)
    from cncgen.planner.least_time.contour_bound import plan_bounded

    return plan_bounded(chunks, machine, options, options.max_contour_error_mm)
