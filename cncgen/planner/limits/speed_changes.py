"""Jerk-limited changes of speed: time and length of a ramp of the acceleration, a phase at its limit, and a ramp back.

A change by Δ takes 2 √(Δ/J) where the acceleration does not reach its limit, Δ < A²/J, and Δ/A + A/J where it does
(Biagiotti and Melchiorri, *Trajectory Planning for Automatic Machines and Robots*, 2008, section 3.4). The kernel
`cncgen.kernels.seven_phase` lays such changes out from joint to joint.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
