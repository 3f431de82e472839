"""Speeds along the path: those that the program asks for, those at which a bend may be passed, and how long a change of speed takes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import along_path
from cncgen.planner.record import Limit
from cncgen.toolpath.record import FeedMode, Kind, Toolpath

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Feeds:
    """Speed that the program asks of each row, mm/s (infinite: none), and the `Limit` that it stands for."""

    speed: Floats
    limit: NDArray[np.int8]

    @classmethod
    def of(cls, toolpath: Toolpath) -> Feeds:
        """G94: the feed; G93: the row's length by its time; rapids: none."""
        path, inverse = toolpath.path, toolpath.feed_mode == FeedMode.INVERSE_TIME
        rapid = (toolpath.feed_mode == FeedMode.RAPID) | (toolpath.kind == Kind.EVENT)
        speed = toolpath.feed * np.where(inverse, np.diff(path.row_s), path.per_feed)
        limit = np.where(rapid, Limit.VELOCITY, Limit.FEED).astype(np.int8)
        return cls(np.where(rapid, np.inf, speed), limit)


def programmed_speed(rows: Toolpath) -> Floats:
    """Return the speed along the path that the program asks for on each row, mm/s, shape (rows,); 0 in a rapid or an event."""
    feed = Feeds.of(rows).speed
    return np.where(np.isfinite(feed) & (feed > 0), feed, 0.0)


def chord_speed(curvature: Floats, tolerance_mm: Floats | float, period_s: float) -> Floats:
    """Return the speed, mm/s, whose chord over a period stays within the tolerance of the arc (Tsai 2010, eq. 24).

    Of curvatures of any shape, 1/mm, and a tolerance for all or each; infinite where the path is straight.

    V_af = (2/T_s) √(ρ² − (ρ − δ)²) = (2/T_s) √(2δ/κ − δ²) with ρ = 1/κ. Where ρ is below δ, and the formula soon has no
    root, it is (2/T_s) √(δ/κ): no point of a way of V T_s is further than V T_s/2 < δ from its nearer end. With rotary axes,
    where |x'| = g and κ stands for |x''| across x', the chord is kept by (2/T_s) √(2δ/κ − (δ/g)²) and by (2/T_s) δ/g, of
    which the larger one is never below that, whatever g.
    """
    bend = np.ascontiguousarray(curvature, float)
    out = np.empty(bend.shape)
    tolerance = np.ascontiguousarray(np.broadcast_to(tolerance_mm, bend.shape), float)
    along_path.chord_speed(bend.ravel(), tolerance.ravel(), period_s, out.ravel())
    return out


def curvature_speed(curvature: Floats, feed_mm_s: float | Floats, kbar_per_mm: float) -> Floats:
    """Return V_cf = κ̄ V_max / (κ + κ̄) (Tsai 2010, eq. 25), mm/s, of curvatures κ (1/mm), shape (n,): half the feed at κ = κ̄."""
    return kbar_per_mm * feed_mm_s / (curvature + kbar_per_mm)


def change_time(change: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """Return the least time of a jerk-limited change of speed between two states without acceleration, s.

    A change by Δ is a ramp of the acceleration, a phase at its limit, and a ramp back. It takes 2 √(Δ/J) where the acceleration does
    not reach its limit, Δ < A²/J, and Δ/A + A/J where it does (Biagiotti and Melchiorri, *Trajectory Planning for Automatic Machines
    and Robots*, 2008, section 3.4). The kernel `cncgen.kernels.seven_phase` lays such changes out from joint to joint.

    Args:
        change: Size of the change, mm/s, of any shape.
        acceleration, jerk: Limits along the path, mm/s² and mm/s³, of that shape.
    """
    ramps = acceleration**2 / jerk
    out: Floats = np.where(
        change < ramps, 2.0 * np.sqrt(change / jerk), change / acceleration + acceleration / jerk
    )
    return out
