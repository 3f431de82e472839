"""Which corners are worth rounding: those that the rounded path passes faster than setpoints pass the corner itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.record import Machine
from cncgen.planner.smoothing.chords import chord_within, fit_tolerance
from cncgen.planner.smoothing.runs import axis_scale

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: Largest |x''| L and |x'''| L² of a turn by 1 that is smoothed with the length L (docs/smoothing.md).
_BEND, _TWIST = 1.0 / 3.0, 0.1475
#: Part of the jerk limit that a step of the tangent takes at most, and speed in J T² up to which a stop costs less, as in
#: `cncgen.planner.optimal`.
_SHARE, _STOP = 0.75, 5.0
#: Times the speed of the corner as it is that the rounded one has at least: it is held on the way through.
_GAIN = 1.5
#: Smoothing lengths that the rows beside a corner have at least, so that it is rounded by itself.
_ALONE = 3.0
#: Part of a turn that rotary axes make, from which the sides of the corner are not alike, and the part of L/v, both sides
#: together, that crawling costs there, as programs with such corners show.
_ROTARY, _CRAWL = 0.98, 0.5
#: A turn below which there is no corner.
_NONE = 1e-6


@dataclass(frozen=True, slots=True)
class Drive:
    """What an unrounded corner is passed by.

    Attributes:
        acceleration, jerk: Shape (axes,), limits as mm (`axis_scale`); infinite for axes that the machine lacks.
        rotary: Shape (axes,), which of them are rotary.
        period_s: Time between setpoints.
        chord_mm: Largest distance of the chords between them.
        reserve_mm: What is left to them of the tolerance where the path is smoothed.
    """

    acceleration: Floats
    jerk: Floats
    rotary: Bools
    period_s: float
    chord_mm: float
    reserve_mm: float

    @classmethod
    def of(cls, machine: Machine, axes: str) -> Drive:
        """Return that of a machine for the axes of a program."""
        limits = [machine.axes.get(letter) for letter in axes]
        scale = axis_scale(axes)
        acceleration = np.array([a.max_acceleration if a else np.inf for a in limits])
        jerk = np.array([a.max_jerk if a else np.inf for a in limits])
        return cls(
            acceleration * scale,
            jerk * scale,
            scale != 1.0,
            machine.period_s,
            machine.chord_tolerance_mm,
            chord_within(machine, axes),
        )


def _reached(drive: Drive, direction: Floats, room: Floats) -> Floats:
    """Return the acceleration along a row that is reached within its length from rest, shape (n,)."""
    acceleration = np.min(drive.acceleration / np.abs(direction), axis=1)
    jerk = np.min(drive.jerk / np.abs(direction), axis=1)
    return np.fmin(acceleration, np.cbrt(jerk**2 * room))


def worth_rounding(drive: Drive, leave: Floats, entry: Floats, tolerance: Floats, room: Floats) -> Bools:
    """Tell which corners to round within their tolerance, shape (n,); the others are passed as they are.

    Rounded with L = 3 P/|Δ| a turn Δ is passed at the speed at which its curvature and the change of that keep to the
    limits. Unrounded its step of the tangent shows in setpoints as v Δ/T² of jerk, v Δ/T of acceleration, and chords cut it
    by v T |Δ|/4; and a stop costs less than to crawl. The first is less where P is less than a few J T³: then setpoints hardly
    tell the two paths from each other.

    Args:
        drive: See there.
        leave, entry: Shape (n, axes): dx/ds before and after each corner, scaled.
        tolerance: Shape (n,), P, mm.
        room: Shape (n,), mm: length of the shorter row beside each corner; short ones are rounded together.
    """
    turn = entry - leave
    size = np.linalg.norm(turn, axis=1)
    period = drive.period_s
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        jerk = np.min(drive.jerk / np.abs(turn), axis=1)
        acceleration = np.min(drive.acceleration / np.abs(turn), axis=1)
        length = 3.0 * fit_tolerance(tolerance, drive.reserve_mm) / size
        rounded = np.fmin(np.cbrt(jerk * length**2 / _TWIST), np.sqrt(acceleration * length / _BEND))
        passed = np.minimum(_SHARE * jerk * period**2, acceleration * period)
        passed = np.minimum(passed, 4.0 * drive.chord_mm / (period * size))
        along = np.min(drive.jerk / np.maximum(np.abs(leave), np.abs(entry)), axis=1)
        enough = np.maximum(_GAIN * passed, _STOP * along * period**2)
        # Where rotary axes make the turn one side is slow, the other fast; on each crawling costs a part of L/v, a stop v/a.
        pace = sum(1.0 / _reached(drive, side, room) for side in (leave, entry))
        rotary = np.linalg.norm(turn[:, drive.rotary], axis=1) > _ROTARY * size
        enough = np.where(rotary, np.fmax(enough, np.sqrt(_CRAWL * length / pace)), enough)
        return (size < _NONE) | (rounded >= enough) | (room < _ALONE * length)
