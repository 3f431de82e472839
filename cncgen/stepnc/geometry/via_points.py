"""Polylines with VIA_ARC_POINTs (ISO 10303-238 from edition 2): arcs through a point between two others."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Entity
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline

Floats = NDArray[np.float64]


def polyline_with_via_points(entity: Entity, points: Floats, via: NDArray[np.bool_]) -> list[Piece]:
    """Return lines between ordinary points and arcs through via points.

    An arc goes from the point before a via point through it to the point after. Two via points in a row make the full
    circle through them that comes back to the point before.

    Args:
        entity: The polyline, for diagnostics.
        points: Shape (n, 3), mm.
        via: Shape (n,), which of them are via points.

    Raises:
        Skip: where via points stand at an end, three in a row, or on a line.
    """
    if via[0] or via[-1]:
        raise entity.fault("stepnc-geometry", "a via point stands at an end of the polyline")
    pieces: list[Piece] = []
    line = [points[0]]
    k = 1
    while k < len(points):
        if not via[k]:
            line.append(points[k])
            k += 1
            continue
        if len(line) > 1:
            pieces.append(Polyline(np.stack(line)))
        start = line[-1]
        full = via[k + 1]
        if full and via[k + 2]:
            raise entity.fault("stepnc-geometry", "three via points follow one another")
        end = points[k + 1]
        pieces.append(_arc(entity, start, points[k], end, bool(full)))
        line = [start if full else end]
        k += 2
    if len(line) > 1:
        pieces.append(Polyline(np.stack(line)))
    return pieces


def _arc(entity: Entity, start: Floats, middle: Floats, end: Floats, full: bool) -> Arc:
    """Return the arc from start through middle to end, or the full circle through them."""
    a, b = middle - start, end - start
    normal = np.cross(a, b)
    area = float(elementary.length(normal))
    if area <= 1e-12 * max(float(elementary.product(a, a)), float(elementary.product(b, b)), 1e-30):
        raise entity.fault("stepnc-geometry", "the points of an arc lie on one line")
    centre = start + (
        np.cross(normal, a) * (elementary.product(b, b)) + np.cross(b, normal) * (elementary.product(a, a))
    ) / (2 * area**2)
    normal = normal / area
    if full:
        return Arc(start, start, centre, normal, 2 * math.pi)
    u, w = start - centre, end - centre
    sweep = math.atan2(elementary.product(normal, np.cross(u, w)), elementary.product(u, w)) % (2 * math.pi)
    return Arc(start, end, centre, normal, sweep)
