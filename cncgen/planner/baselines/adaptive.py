"""`adaptive`: the feed, or what the chord error allows (Yeh and Hsu 2002; Tsai 2010, eq. 24)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cncgen.machine.record import Machine
from cncgen.planner.baselines.baseline import plan_by_curvature
from cncgen.planner.limits.bend_speeds import chord_speed
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Limit, Trajectory
from cncgen.toolpath.record import Toolpath


def plan_adaptive(chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions) -> Iterator[Trajectory]:
    """Travel at min(V_max, V_af), V_af = (2/T_s) √(2δ/κ − δ²) (Tsai 2010, eq. 24); acceleration and jerk are not limited."""
    tolerance, period = machine.chord_tolerance_mm, machine.period_s
    return plan_by_curvature(
        chunks, machine, lambda curvature, feed: chord_speed(curvature, tolerance, period), Limit.CHORD
    )
