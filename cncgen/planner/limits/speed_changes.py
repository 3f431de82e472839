"""Jerk-limited changes of speed: time and length of a ramp of the acceleration, a phase at its limit, and a ramp back.

A change by Δ takes 2 √(Δ/J) where the acceleration does not reach its limit, Δ < A²/J, and Δ/A + A/J where it does
(Biagiotti and Melchiorri, *Trajectory Planning for Automatic Machines and Robots*, 2008, section 3.4). The kernel
`cncgen.kernels.seven_phase` lays such changes out from joint to joint.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary

Floats = NDArray[np.float64]


def change_time(change: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """Return the least time of a change of speed between two states without acceleration, s.

    Args:
        change: Size of the change, mm/s, of any shape.
        acceleration, jerk: Limits along the path, mm/s² and mm/s³, of that shape.
    """
    ramps = acceleration**2 / jerk
    out: Floats = np.where(
        change < ramps, 2.0 * np.sqrt(change / jerk), change / acceleration + acceleration / jerk
    )
    return out


def rise_time(change: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """Return how long the acceleration grows in a change of speed, s: the first of its phases. Arguments as in `change_time`."""
    return np.minimum(acceleration / jerk, np.sqrt(change / jerk))


def peak_speed(length: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """Return the largest speed on a straight line from rest to rest, mm/s: that whose two changes of speed take the length.

    It is (L²J/4)^(1/3) where the acceleration does not reach its limit, and (√((A/J)² + 4 L/A) − A/J) A/2 where it does.

    Args:
        length: L, mm, of any shape.
        acceleration, jerk: Limits along the line, mm/s² and mm/s³, of that shape.
    """
    ramp = acceleration / jerk
    short = elementary.cbrt(0.25 * length**2 * jerk)
    long = 0.5 * acceleration * (np.sqrt(ramp**2 + 4.0 * length / acceleration) - ramp)
    out: Floats = np.where(short <= acceleration * ramp, short, long)
    return out
