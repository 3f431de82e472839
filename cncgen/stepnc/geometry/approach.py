"""Approach paths from a fixed point onto a contact path (AP_LIFT_PATH_ANGLE, AP_LIFT_PATH_TANGENT of ISO 14649-10).

A lift is the approach to the reversed path, reversed.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Entity
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline
from cncgen.stepnc.geometry.splines import evaluate

Floats = NDArray[np.float64]


def start_tangent(piece: Piece) -> Floats:
    """Return the unit direction, shape (3,), in which a piece begins."""
    if isinstance(piece, Polyline):
        steps = np.diff(piece.points, axis=0)
        long = np.flatnonzero(np.abs(steps).max(axis=1) > 1e-9)
        vector = steps[long[0]] if len(long) else np.array([1.0, 0.0, 0.0])
    elif isinstance(piece, Arc):
        rise = float(elementary.product(piece.end - piece.start, piece.normal))
        vector = np.cross(piece.normal, piece.start - piece.centre) * piece.sweep + rise * piece.normal
    else:
        low = float(piece.knots[piece.degree])
        step = (float(piece.knots[-piece.degree - 1]) - low) * 1e-6
        a, b = evaluate(piece, np.array([low, low + step]))
        vector = b - a
    return np.asarray(vector / elementary.length(vector))


def angled(
    entity: Entity, fix: Floats, toward: Floats | None, contact: Piece, angle: float, bend: float
) -> list[Piece]:
    """Return two lines: to a bend `bend` mm before the contact path, then onto it at `angle` rad from its direction.

    The last line lies in the plane of the path's first direction and the way from the fixed point.
    """
    goal, along = contact.start, start_tangent(contact)
    side = fix - goal
    if toward is not None:
        side = -toward
    across = side - (elementary.product(side, along)) * along
    if elementary.length(across) < 1e-9:
        return [Polyline(np.stack([fix, goal]))]
    across /= elementary.length(across)
    corner = goal + bend * (math.sin(angle) * across - math.cos(angle) * along)
    points = [fix, corner, goal] if elementary.length(corner - fix) > 1e-9 else [fix, goal]
    if not bend > 0:
        raise entity.fault("stepnc-geometry", f"benddist is {bend:g} mm, not positive")
    return [Polyline(np.stack(points))]


def tangential(
    entity: Entity, fix: Floats, toward: Floats | None, contact: Piece, radius: float
) -> list[Piece]:
    """Return a line and an arc of a radius, each going over into the next without a corner, onto the contact path.

    Raises:
        Skip: where the fixed point lies within the arc's circle.
    """
    goal, along = contact.start, start_tangent(contact)
    side = fix - goal
    across = side - (elementary.product(side, along)) * along
    if not radius > 0 or elementary.length(across) < 1e-9:
        raise entity.fault("stepnc-geometry", "no arc leads from the fixed point onto the path")
    across /= elementary.length(across)
    centre = goal + radius * across
    # In the plane of (along, across) about the centre the path is met at angle -90 degrees, turning against the clock.
    x, y = float(elementary.product(fix - centre, along)), float(elementary.product(fix - centre, across))
    distance = math.hypot(x, y)
    if distance < radius - 1e-9:
        text = f"the fixed point lies {distance:.4f} mm from the centre of the arc of {radius:g} mm"
        raise entity.fault("stepnc-geometry", text)
    begin = math.atan2(y, x) + math.acos(min(radius / distance, 1.0))
    touch = centre + radius * (math.cos(begin) * along + math.sin(begin) * across)
    sweep = (-math.pi / 2 - begin) % (2 * math.pi)
    pieces: list[Piece] = []
    if elementary.length(touch - fix) > 1e-9:
        pieces.append(Polyline(np.stack([fix, touch])))
    return [*pieces, Arc(touch, goal, centre, np.cross(along, across), sweep)]
