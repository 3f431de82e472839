"""`curvature`: the feed lowered with curvature (Tsai 2010, eq. 25)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cncgen.machine.record import Machine
from cncgen.planner.baselines.baseline import plan_by_curvature
from cncgen.planner.limits.bend_speeds import curvature_speed
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Limit, Trajectory
from cncgen.toolpath.record import Toolpath


def plan_curvature(
    chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions
) -> Iterator[Trajectory]:
    """Travel at V_cf = κ̄ V_max/(κ + κ̄) (Tsai 2010, eq. 25), κ̄ = `kbar_per_mm`; acceleration and jerk are not limited."""
    kbar = options.kbar_per_mm
    return plan_by_curvature(
        chunks, machine, lambda curvature, feed: curvature_speed(curvature, feed, kbar), Limit.CURVATURE
    )
