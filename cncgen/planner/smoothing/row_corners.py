"""The corners between rows that may be smoothed (`RowCorners`), and the limits of the machine that pass them (`Drive`).

`stream` makes both; `tolerance_estimate` and `rounding_decision` take them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.record import Machine
from cncgen.planner.limits.axis_limits import axis_scale
from cncgen.planner.smoothing.tolerance_split import chord_within

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: Largest |x''| L and |x'''| L² of a turn by 1 that is smoothed with the length L (docs/smoothing.md).
BEND, TWIST = 1.0 / 3.0, 0.1475
#: Limit of an axis that the machine lacks: never reached, yet finite, as infinity times a direction of 0 is no number.
_FREE = 1e15


@dataclass(frozen=True, slots=True)
class Drive:
    """The limits of a machine by which corners are passed.

    Attributes:
        velocity, acceleration, jerk: Shape (axes,), limits as mm (`axis_scale`).
        rotary: Shape (axes,), axes whose unit is no length.
        period_s: Time between setpoints.
        chord_mm: Largest distance of the chords between them.
        reserve_mm: The most that they can take of the tolerance where the path is smoothed (`chord_within`).
    """

    velocity: Floats
    acceleration: Floats
    jerk: Floats
    rotary: Bools
    period_s: float
    chord_mm: float
    reserve_mm: float

    @classmethod
    def of(cls, machine: Machine, axes: str) -> Drive:
        """Return that of a machine for the axes of a program."""
        scale = axis_scale(axes)
        limits = [machine.axes.get(letter) for letter in axes]
        table = [(a.max_velocity, a.max_acceleration, a.max_jerk) if a else (_FREE,) * 3 for a in limits]
        velocity, acceleration, jerk = np.array(table).T * scale
        reserve = chord_within(machine, axes)
        rotary = scale != 1.0
        return cls(
            velocity, acceleration, jerk, rotary, machine.period_s, machine.chord_tolerance_mm, reserve
        )


@dataclass(frozen=True, slots=True)
class RowCorners:
    """The n places where consecutive rows that may be smoothed meet.

    Attributes:
        leave, entry: Shape (n, axes): dx/ds before and after, scaled.
        length, feed: Shape (2, n), mm and mm/s: of the row before and of the row after.
        tolerance: Shape (n,), P, mm.
        joined: Shape (n,): whether the two rows are in one run.
        bend: Shape (2, n), 1/mm: largest curvature of the row before and of the row after.
    """

    leave: Floats
    entry: Floats
    length: Floats
    feed: Floats
    tolerance: Floats
    joined: Bools
    bend: Floats
