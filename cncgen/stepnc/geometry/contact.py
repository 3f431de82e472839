"""From where a cutter touches a surface to where its tip is (cutter contact to cutter location).

A cutter of radius R with an edge rounded by r (a ball: r = R; square: r = 0) turns about the axis a and touches the
surface with normal n at the point p with the circle of its rounding:

    tip = p + r n + (R - r) e - r a,    e = the unit vector of n - (n . a) a

(e is 0 where the normal is the axis: a flat bottom touches with all of it, and its middle is taken).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.stepnc.execution.linearize import couple
from cncgen.stepnc.geometry.pieces import Piece, Polyline

Floats = NDArray[np.float64]


def tips(points: Floats, normals: Floats, axes: Floats, radius: float, edge: float) -> Floats:
    """Return the tips of a cutter, shape (n, 3), mm.

    Args:
        points: Where it touches, shape (n, 3), mm.
        normals: Of the surface there, out of the material, shape (n, 3), unit vectors.
        axes: From the tip to the spindle, shape (n, 3), unit vectors.
        radius: Of the cutter, mm.
        edge: Radius of its rounded edge, mm.
    """
    across = normals - (normals * axes).sum(axis=1, keepdims=True) * axes
    length = np.linalg.norm(across, axis=1, keepdims=True)
    outward = np.where(length > 1e-9, across / np.where(length > 1e-9, length, 1.0), 0.0)
    return points + edge * (normals - axes) + (radius - edge) * outward


def locations(
    contact: list[Piece],
    normals: list[Piece],
    axes: list[Piece] | None,
    upright: Floats,
    radius: float,
    edge: float,
) -> list[Piece]:
    """Return the path of the tip for a path of the contact point, in chords.

    Args:
        contact: The path of the contact point.
        normals: A curve whose points are the surface's normals along it; see `couple`.
        axes: Likewise of the tool axis, None where it stays `upright`.
        upright: Shape (3,), the direction of the tool.
        radius, edge: Of the cutter, mm.
    """
    out: list[Piece] = []
    for piece in couple(contact, normals):
        points, upright_all = piece.points, np.tile(upright, (len(piece.points), 1))
        tool = upright_all
        if axes is not None:
            (along,) = couple([Polyline(points)], axes)
            tool = upright_all if along.axes is None else along.axes
        directions = upright_all if piece.axes is None else piece.axes
        tip = tips(points, directions, tool, radius, edge)
        out.append(Polyline(tip, tool if axes is not None else None))
    return out
