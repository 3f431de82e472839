"""What the chords between setpoints may add where the tolerance is not much wider than they are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.record import Machine
from cncgen.planner.paths import path_of
from cncgen.planner.rows import across, chord_speed
from cncgen.planner.smoothing.runs import axis_scale
from cncgen.toolpath.record import PathMode, Toolpath

Floats = NDArray[np.float64]

#: Room for chords, by what v² κ T²/8 says of them: where curvature changes within a period they are longer by some per cent.
_ROOM = 1.03


def chord_within(machine: Machine, axes: str) -> float:
    """Return by how much the chord of a period may leave a path without corners, mm: the tolerance, or what is possible.

    Over a chord of the duration T a motion x(t) is at most max |d²x/dt²| T²/8 away, and its second derivative at most the
    root of the sum of the squares of the axes' acceleration limits. With rotary axes the tolerance counts: how much of a
    distance they make is a matter of units.

    Args:
        machine: Limits, period, chord tolerance.
        axes: Letters of the program's axes.
    """
    given = machine.chord_tolerance_mm
    if (axis_scale(axes) != 1.0).any():
        return given
    limits = [machine.axes[letter].max_acceleration for letter in axes if letter in machine.axes]
    return min(given, float(np.linalg.norm(limits)) * machine.period_s**2 / 8.0)


def fit_tolerance(tolerance: Floats, chord_mm: float) -> Floats:
    """Return what a smoothed curve may leave its path by, so that the chords between setpoints have room: half at least."""
    out: Floats = np.maximum(tolerance - _ROOM * chord_mm, 0.5 * tolerance)
    return out


def chord_left(tolerance: Floats, chord_mm: float) -> Floats:
    """Return what chords may take beside a curve that is smoothed by `fit_tolerance`, mm.

    That is their tolerance δ; where P is below 2 δ only max(P, δ) − P/2.
    """
    rest = (np.maximum(tolerance, chord_mm) - fit_tolerance(tolerance, chord_mm)) / _ROOM
    return np.where(_narrow(tolerance, chord_mm), np.minimum(rest, chord_mm), chord_mm)


def _narrow(tolerance: Floats, chord_mm: float) -> NDArray[np.bool_]:
    out: NDArray[np.bool_] = tolerance < 2.0 * _ROOM * chord_mm
    return out


def chord_speed_within(
    toolpath: Toolpath, chord_mm: float, period_s: float
) -> Callable[[Floats], Floats] | None:
    """Return the speed along a smoothed toolpath at which smoothing and chords together keep its tolerance.

    Args:
        toolpath: A stretch, smoothed by `fit_tolerance`.
        chord_mm: δ.
        period_s: Time between setpoints.

    Returns:
        Takes path coordinates, shape (n,), and gives mm/s; infinite where δ itself is what bounds. None: everywhere.
    """
    narrow = (toolpath.path_mode == PathMode.CONTINUOUS) & _narrow(toolpath.tolerance, chord_mm)
    if not narrow.any():
        return None
    left = chord_left(toolpath.tolerance, chord_mm)
    path, scale = path_of(toolpath), axis_scale(toolpath.axes)

    def speed(s: Floats) -> Floats:
        row = path.row_of(s, 1)
        _, x1, x2 = path.evaluate(s, 2) * scale
        top = chord_speed(across(x1, x2), left[row], period_s)
        return np.where(narrow[row], top, np.inf)

    return speed
