"""How smoothing and the chords between setpoints share a tolerance that is not much wider than the chords (docs/smoothing.md).

`stream` takes the part for smoothing from it (`Chords`), `block_planning` the speed at which the rest holds the chords
(`chord_speed_within`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.kernels import along_path
from cncgen.machine.record import Machine
from cncgen.planner.limits.axis_limits import JUMP_SHARE, AxisLimits, axis_scale, chord_reserve
from cncgen.toolpath.record import PathMode, Toolpath

Floats = NDArray[np.float64]

#: Room left to chords, as a multiple of v² κ T²/8: where curvature or speed changes within a period they are some per cent
#: further from the path. Where even that is too little, the plan is measured and slowed (`cncgen.planner.least_time.chord_refinement`).
ROOM = 1.03
#: Smoothing is left at least this part of the tolerance (of P, or of δ where that is more).
_LEAST = 0.03
#: The chord of a corner that is rounded within P and passed as fast as its jerk allows, as a multiple of P^⅓ (J T³)^⅔: 1.72/8, and a tenth.
#: Without this room, 16 random programs take 0.9 % longer on average, 14 % at most.
_AT_CORNERS = 1.1 * 1.72 / 8.0
#: Speed at which a rounded turn Δ is passed, times Δ, as a multiple of (J P²)^⅓: (9/0.1475)^⅓.
_ROUNDED = 3.94
#: A stop takes less time than a rounded corner that is passed at so many times the speed below which it takes less than another. Where
#: all corners are rounded (`Chords.unseen`), one of 112 random programs takes 8 % longer.
_SURELY = 1.5


@dataclass(frozen=True, slots=True)
class Chords:
    """The chords of a machine's setpoints.

    Attributes:
        most_mm: δ, the largest chord that there can be (`chord_reserve`).
        period_s: T; 0 where there are no setpoints.
        jerk: J of the strongest and of the weakest linear axis, mm/s³.
    """

    most_mm: float = 0.0
    period_s: float = 0.0
    jerk: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, machine: Machine, axes: str) -> Chords:
        """Return those of a machine over some axes."""
        drive = AxisLimits.of(machine, axes).in_mm()
        jerk = drive.jerk[~drive.rotary & np.isfinite(drive.jerk)]
        ends = (float(jerk.max()), float(jerk.min())) if len(jerk) else (np.inf, 0.0)
        return cls(chord_reserve(machine, axes), machine.period_s, ends)

    def unseen(self, tolerance: Floats, turn: Floats, length: Floats) -> NDArray[np.bool_]:
        """Tell which corners are passed faster as they are, or stopped in, than rounded, shape (n,) (docs/smoothing.md).

        Args:
            tolerance, turn: Shape (n,), P, mm, and |Δ| of unit vectors.
            length: Shape (n,), of the shorter row beside each, mm.
        """
        kept = elementary.power(np.maximum(JUMP_SHARE, _SURELY * turn) / _ROUNDED, 1.5)
        out: NDArray[np.bool_] = tolerance < kept * self.jerk[1] * self.period_s**3
        return out & ((turn * length > 8.0 * tolerance) | (tolerance < self.most_mm))

    def fit_tolerance(self, tolerance: Floats, curvature: Floats, feed: Floats) -> Floats:
        """Return what a smoothed curve may leave its path by, shape (n,), so that chords have the room that they need (docs/smoothing.md).

        Of P, mm, the curvature of the rows, 1/mm, and their feed, mm/s, shape (n,) each.
        """
        jerk, square = self.jerk[0], self.period_s**2
        at_corners = _AT_CORNERS * elementary.cbrt(tolerance * (jerk * self.period_s**3) ** 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            bent = np.minimum(feed**2 * curvature, elementary.cbrt(jerk**2 / curvature)) * square / 8.0
        need = np.maximum(at_corners, np.where(curvature > 0.0, bent, 0.0))
        kept = np.minimum(need, ROOM * self.most_mm)
        both = np.maximum(tolerance, self.most_mm)
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
    scale = axis_scale(toolpath.axes, toolpath.degree_mm)
    path = toolpath.path

    def speed(s: Floats, x: Floats) -> Floats:
        out = np.empty(len(s))
        x1, x2 = (np.ascontiguousarray(each) for each in x[1:3])
        # The end of a row is the start of the next one.
        along_path.chords_of_rows(x1, x2, scale, left, path.row_of(s, -1), path.row_of(s, 1), period_s, out)
        return out

    return speed
