"""How much of the tolerance the chords between setpoints will need beside a smoothed path: an estimate from the corners alone.

The less they need, the more is left to smoothing (`stream`, `rounding_decision`). The tolerance is kept even if the estimate is wrong: the
speed of the plan is bounded by what smoothing has really left to the chords (`cncgen.planner.smoothing.tolerance_split`). Derivation:
docs/rounding.md.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.geometry.columns import min_over_axes
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.smoothing.row_corners import BEND, TWIST, RowCorners
from cncgen.planner.smoothing.tolerance_split import ROOM, fit_tolerance

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: If smoothing would gain less than this part of the tolerance, chords are left all that they could need.
_TRIFLE = 0.03
#: Fixed-point iterations in which the smoothing length and the chord that goes with it are found.
_ROUNDS = 3
#: A smoothed path leaves a turn Δ by L Δ/3 (docs/smoothing.md), so that L = 3 P/Δ.
_WAY = 3.0


def chord_need(drive: AxisLimits, corners: RowCorners) -> Floats:
    """Return the chord that setpoints will make at each corner as far as limits, feed and P let them, shape (n,), mm.

    The chord of a period takes |x''| v² T²/8. A turn Δ that is rounded by itself has |x''| = Δ/(3 L) with L = 3 P/Δ, and
    v is that of jerk, v³ = J L²/(0.1475 Δ), of acceleration, of the feed, or of the axes. Where rows are shorter than 3 L
    the curve behind them counts, of the curvature κ = Δ/ℓ, with v³ = J/κ². Never more than `AxisLimits.chord_reserve_mm`.

    Args:
        drive, corners: See there.
    """
    most = drive.chord_reserve_mm
    if not len(corners.tolerance) or ROOM * most <= _TRIFLE * corners.tolerance.min():
        return np.full(len(corners.tolerance), most)
    turn = corners.entry - corners.leave
    size = np.sqrt(np.einsum("ij,ij->i", turn, turn))
    apart = 0.5 * (corners.length[0] + corners.length[1])
    velocity, jerk = (_sum_of(limit, drive, corners) for limit in (drive.velocity, drive.jerk))
    top = np.minimum(corners.feed.max(axis=0), velocity)
    need = curve_need(drive, np.maximum(size / apart, corners.bend.max(axis=0)), top, jerk)
    least = fit_tolerance(corners.tolerance, most)
    alone = np.flatnonzero((size > 0.0) & (apart * size >= _WAY * least))
    if alone.size:
        bends = curve_need(drive, corners.bend.max(axis=0)[alone], top[alone], jerk[alone])
        need[alone] = np.maximum(bends, _turn_need(drive, corners, alone, np.abs(turn[alone]), size[alone]))
    return np.where(ROOM * (most - need) <= _TRIFLE * corners.tolerance, most, need)


def _turn_need(drive: AxisLimits, corners: RowCorners, at: Ints, turn: Floats, size: Floats) -> Floats:
    """Return the chord that is made at corners that are rounded by themselves, shape (k,), mm; see `chord_need`."""
    gain = np.maximum(np.abs(corners.leave[at]), np.abs(corners.entry[at]))
    with np.errstate(divide="ignore"):
        top = np.minimum(corners.feed[:, at].max(axis=0), min_over_axes(drive.velocity / gain))
        jerk, acceleration = (
            min_over_axes(limit / turn) * size for limit in (drive.jerk, drive.acceleration)
        )
    need = np.zeros(len(at))
    for _ in range(_ROUNDS):
        length = _WAY * fit_tolerance(corners.tolerance[at], drive.chord_reserve_mm, need) / size
        bend = BEND * size / length
        by_jerk = elementary.cbrt(jerk * length**2 / (TWIST * size)) ** 2 * bend
        push = np.minimum(np.minimum(by_jerk, acceleration), top**2 * bend)
        need = np.minimum(drive.chord_reserve_mm, push * drive.period_s**2 / 8.0)
    return need


def _sum_of(limit: Floats, drive: AxisLimits, corners: RowCorners) -> Floats:
    """Return the limit of all axes together at each corner, shape (n,): a rotary axis that stands there has no part in it."""
    counts = ~drive.rotary | (corners.leave != 0.0) | (corners.entry != 0.0)
    return np.sqrt(counts @ limit**2)


def curve_need(drive: AxisLimits, curvature: Floats, top: Floats, jerk: Floats) -> Floats:
    """Return the chord that setpoints make on curves, shape (n,), mm; see `chord_need`.

    Args:
        drive: See there.
        curvature, top, jerk: Shape (n,): κ, and the largest speed and jerk in space.
    """
    with np.errstate(divide="ignore"):
        push = np.minimum(
            np.where(curvature > 0.0, top**2 * curvature, 0.0), elementary.cbrt(jerk**2 / curvature)
        )
    out: Floats = np.minimum(drive.chord_reserve_mm, push * drive.period_s**2 / 8.0)
    return out
