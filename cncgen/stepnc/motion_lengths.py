"""The length of motions, by which an inverse time feed (G93) becomes a speed along the path."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary, nurbs
from cncgen.toolpath.record import Kind, Toolpath

Floats = NDArray[np.float64]


def motion_length(toolpath: Toolpath, row: int, points: Floats) -> float:
    """Return the length of a motion in X Y Z, mm, or, where they stand still, what the rotary axes turn by, rad.

    Args:
        row: Of the motion.
        points: Shape (2, axes): where it begins and ends.
    """
    begin, end = points
    index = toolpath.curve[row : row + 1]
    if toolpath.kind[row] == Kind.NURBS:
        one = nurbs.take(toolpath.nurbs, index)
        return float(nurbs.lengths(one, np.zeros(1, np.int64), np.full(1, 3)).total[0])
    if toolpath.kind[row] == Kind.ARC:
        centre, normal = toolpath.arcs.centre[index[0]], toolpath.arcs.normal[index[0]]
        across = elementary.length(np.cross(normal, begin[:3] - centre)) * toolpath.arcs.sweep[index[0]]
        return math.hypot(across, elementary.product(end[:3] - begin[:3], normal))
    return float(elementary.length((end - begin)[:3]) or elementary.length((end - begin)[3:]))
