"""`constant`: the programmed feed everywhere; the first baseline of the papers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cncgen.machine.record import Machine
from cncgen.planner.baselines.baseline import plan_by_curvature
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Limit, Trajectory
from cncgen.toolpath.record import Toolpath


def plan_constant(chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions) -> Iterator[Trajectory]:
    """Travel at the feed, or at the axes' velocity where that is lower; acceleration and jerk are not limited."""
    return plan_by_curvature(chunks, machine, lambda curvature, feed: feed, Limit.FEED)
