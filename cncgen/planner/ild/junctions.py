"""Speeds at which the joint of two rows may be passed, from the limits of the axes within one period (docs/ild.md):

v |Δt_i| <= min(A_i T, J_i T²)  where the tangent turns,   v² |Δ(κn)_i| <= J_i T  where only the curvature jumps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.limits.axis_limits import AxisLimits

Floats = NDArray[np.float64]

#: Turn of the tangent below which two rows count as tangent: rounding of nine-digit coordinates, not a corner.
_TANGENT = 1e-6


def turned(turn: Floats) -> NDArray[np.bool_]:
    """Tell at which joints the tangent turns by more than rounding, shape (n,)."""
    return np.any(np.abs(turn) >= _TANGENT, axis=1)


def joint_speeds(turn: Floats, bend: Floats, limits: AxisLimits) -> Floats:
    """Return the highest speed at each joint.

    Args:
        turn, bend: Shape (n, axes), steps of dx/ds and d²x/ds² from the row before the joint to the row after it.
        limits: Limits of the axes, and T.

    Returns:
        Shape (n,), mm/s; infinite where nothing jumps.
    """
    jump = np.abs(bend)
    turn = np.abs(turn)
    turn[turn < _TANGENT] = 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        by_turn = np.where(turn > 0.0, limits.speed_step / turn, np.inf).min(axis=1, initial=np.inf)
        by_jump = np.where(jump > 0.0, np.sqrt(limits.jerk * limits.period_s / jump), np.inf)
    return np.minimum(by_turn, by_jump.min(axis=1, initial=np.inf))
