"""Tool axes as angles of two rotary axes: a fork head that turns about Z (C) and tilts about Y (B).

X Y Z stay the position of the tool's tip in the workpiece (tool centre point programming, RTCP). The axis of the tool
is ``Rz(C) Ry(B) z = (cos C sin B, sin C sin B, cos B)``; of the two solutions (B, C) and (−B, C + π) the one nearer
to where the axes stand is taken, and where the tool is upright C stays.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Letters of the axes, in the order of the angles.
LETTERS = "BC"
#: sin B below which the tool is upright.
UPRIGHT = 1e-9


def angles_of(axis: Floats, before: tuple[float, float]) -> tuple[float, float]:
    """Return B and C, rad, for a tool axis, shape (3,), nearest to the angles `before`."""
    tilt = math.hypot(axis[0], axis[1])
    if tilt < UPRIGHT:
        return (0.0 if axis[2] > 0 else math.pi), before[1]
    b, c = math.atan2(tilt, axis[2]), math.atan2(axis[1], axis[0])
    both = [(b, _near(c, before[1])), (-b, _near(c + math.pi, before[1]))]
    return min(both, key=lambda s: abs(s[0] - before[0]) + abs(s[1] - before[1]))


def angles_along(axes: Floats, before: tuple[float, float]) -> Floats:
    """Return B and C, shape (n, 2), rad, for tool axes, shape (n, 3), each nearest to the one before it."""
    out = np.empty((len(axes), 2))
    for k, axis in enumerate(axes):
        before = angles_of(axis, before)
        out[k] = before
    return out


def _near(angle: float, reference: float) -> float:
    """Return the angle by whole turns nearest to a reference."""
    return angle + 2 * math.pi * round((reference - angle) / (2 * math.pi))
