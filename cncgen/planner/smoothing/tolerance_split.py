"""How smoothing and the chords between setpoints share a tolerance that is not much wider than the chords.

`stream` asks what it may use (`fit_tolerance`), `block_planning` at which speed what is left holds the chords (`chord_speed_within`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.limits.axis_limits import axis_scale
from cncgen.planner.limits.bend_speeds import across, chord_speed
from cncgen.toolpath.record import PathMode, Toolpath

Floats = NDArray[np.float64]

#: Room left to chords, as a multiple of v² κ T²/8: where curvature or speed changes within a period they are some per cent
#: further from the path. Where even that is too little, the plan is measured and slowed (`cncgen.planner.least_time.chord_refinement`).
ROOM = 1.03
#: Smoothing is left at least this part of the tolerance (of P, or of δ where that is more).
_LEAST = 0.03


def fit_tolerance(tolerance: Floats, chord_mm: float, need: Floats | float | None = None) -> Floats:
    """Return what a smoothed curve may leave its path by, so that the chords between setpoints have room.

    Where chords need all of it, next to nothing is left: speed goes with the root of their room, the smoothing length with that
    of P at best, and what it gains at joints is less.

    Args:
        tolerance: Shape (n,), P, mm.
        chord_mm: δ, the largest chord that there can be (`AxisLimits.chord_reserve_mm`).
        need: Shape (n,), mm: the chord to leave room for, δ at most; None for δ.
    """
    kept = ROOM * chord_mm if need is None else np.minimum(need, ROOM * chord_mm)
    both = np.maximum(tolerance, chord_mm)
    return np.clip(both - kept, np.minimum(_LEAST * both, tolerance), tolerance)


def chord_room(tolerance: Floats, deviation: Floats, chord_mm: float) -> Floats:
    """Return what is left of the tolerance, or of δ where that is more, beside a curve that leaves its path so far, mm."""
    return np.maximum(tolerance, chord_mm) - deviation


def chord_left(room: Floats, chord_mm: float) -> Floats:
    """Return the chord to which the room beside a curve holds the motion, mm: δ at most."""
    return np.where(_tight(room, chord_mm), room, chord_mm)


def _tight(room: Floats, chord_mm: float) -> NDArray[np.bool_]:
    # Where all of δ was left over, rounding must not take it away.
    out: NDArray[np.bool_] = room < (1.0 - 1e-9) * ROOM * chord_mm
    return out


def chord_speed_within(
    toolpath: Toolpath, chord_mm: float, period_s: float
) -> Callable[[Floats, Floats], Floats] | None:
    """Return the speed along a smoothed toolpath at which smoothing and chords together keep its tolerance.

    Args:
        toolpath: A stretch that is smoothed.
        chord_mm: δ.
        period_s: Time between setpoints.

    Returns:
        Takes path coordinates, shape (n,), ascending, and the path and its first two derivatives there, shape (≥ 3, n, axes);
        gives mm/s, infinite where δ itself is what bounds. None: everywhere.
    """
    narrow = (toolpath.path_mode == PathMode.CONTINUOUS) & _tight(toolpath.chord_tolerance, chord_mm)
    if not narrow.any():
        return None
    left = np.where(narrow, chord_left(toolpath.chord_tolerance, chord_mm), np.inf)
    scale = axis_scale(toolpath.axes)
    path = toolpath.path

    def speed(s: Floats, x: Floats) -> Floats:
        # The end of a row is the start of the next one.
        chord = np.minimum(left[path.row_of(s, -1)], left[path.row_of(s, 1)])
        return np.where(chord < np.inf, chord_speed(across(x[1], x[2], scale), chord, period_s), np.inf)

    return speed
