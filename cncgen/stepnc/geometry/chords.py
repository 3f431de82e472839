"""Curves as chords: for tool axes that turn along a curve, and for readers of lines alone."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.geometry.pieces import Arc, Nurbs, Piece, Polyline
from cncgen.stepnc.geometry.splines import evaluate

Floats = NDArray[np.float64]

#: Largest distance of a chord from the curve, mm, where a tool axis is coupled to it.
CHORD = 1e-3
#: Largest turn of the tool axis between two points, rad: the rotary axes move linearly there.
AXIS_STEP = math.radians(0.5)
MAX_POINTS = 1_000_000


def polyline_of(piece: Piece, chord: float) -> Polyline:
    """Return a polyline no farther than `chord` mm from a piece, its ends exact."""
    if isinstance(piece, Polyline):
        return piece
    if isinstance(piece, Arc):
        radius = float(elementary.length(piece.start - piece.centre))
        step = 2 * math.acos(max(1.0 - chord / radius, 0.0)) if radius > chord else math.pi / 2
        count = min(max(2, math.ceil(piece.sweep / step)), MAX_POINTS)
        points = piece.points(np.linspace(0.0, 1.0, count + 1))
    else:
        points = evaluate(piece, _parameters(piece, chord))
    points[0], points[-1] = piece.start, piece.end
    return Polyline(points)


def _parameters(curve: Nurbs, chord: float) -> Floats:
    """Return parameters so close that the middle and quarters of every chord lie within the tolerance."""
    u = np.unique(curve.knots)
    u = np.unique(np.concatenate([u[:-1] + f * np.diff(u) for f in (0.0, 0.25, 0.5, 0.75)] + [u[-1:]]))
    for _ in range(30):
        a, b = evaluate(curve, u[:-1]), evaluate(curve, u[1:])
        worst = np.zeros(len(u) - 1)
        for f in (0.25, 0.5, 0.75):
            middle = evaluate(curve, u[:-1] + f * np.diff(u))
            along = b - a
            t = ((middle - a) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-300)
            off = np.linalg.norm(middle - a - np.clip(t, 0, 1)[:, None] * along, axis=1)
            worst = np.maximum(worst, off)
        coarse = worst > 0.8 * chord
        if not coarse.any() or len(u) > MAX_POINTS:
            break
        u = np.sort(np.concatenate([u, u[:-1][coarse] + 0.5 * np.diff(u)[coarse]]))
    return u


def with_axes(points: Floats, axes: Floats, counts: NDArray[np.int64] | None = None) -> tuple[Floats, Floats]:
    """Return points and tool axes with so many between them that the axis turns little from one to the next.

    Between two points the tip goes straight and the axis along the great circle.

    Args:
        points: Shape (n, 3), mm.
        axes: Shape (n, 3), unit vectors.
        counts: Into how many the way to the next point is cut, shape (n - 1,); None: so that the tool turns by no more
            than `AXIS_STEP`.
    """
    cosine = np.clip((axes[:-1] * axes[1:]).sum(axis=1), -1.0, 1.0)
    angle = elementary.arccos(cosine)
    if counts is None:
        counts = np.maximum(np.ceil(angle / AXIS_STEP).astype(np.int64), 1)
    if (counts == 1).all():
        return points, axes
    k = np.repeat(np.arange(len(counts)), counts)
    step = np.arange(len(k)) - np.repeat(np.cumsum(counts) - counts, counts)
    t = (step / counts[k])[:, None]
    between = points[k] + t * (points[k + 1] - points[k])
    turn = angle[k][:, None]
    safe = np.where(turn > 1e-9, np.sin(turn), 1.0)
    a = np.where(turn > 1e-9, np.sin((1 - t) * turn) / safe, 1 - t)
    b = np.where(turn > 1e-9, np.sin(t * turn) / safe, t)
    mixed = a * axes[k] + b * axes[k + 1]
    mixed /= np.linalg.norm(mixed, axis=1, keepdims=True)
    return np.concatenate([between, points[-1:]]), np.concatenate([mixed, axes[-1:]])


def couple(pieces: Sequence[Piece], axes: Sequence[Piece]) -> list[Polyline]:
    """Return pieces with the tool axes of a second curve, whose points are directions.

    A spline's knots parametrise its axis curve too, and an arc's angle; a polyline has one axis a point; else the axis
    goes linearly with the length from the first to the last direction (ISO 10303-238, 5.2.2.6.1).
    """
    if len(pieces) == 1 and len(axes) == 1:
        path, tilt = pieces[0], axes[0]
        if isinstance(path, Nurbs) and isinstance(tilt, Nurbs):
            return [_couple_splines(path, tilt)]
        if isinstance(path, Arc) and isinstance(tilt, Arc):
            points = polyline_of(path, CHORD).points
            return [Polyline(points, _unit(tilt.points(np.linspace(0.0, 1.0, len(points)))))]
        if isinstance(path, Polyline) and isinstance(tilt, Polyline) and len(path.points) == len(tilt.points):
            return [Polyline(path.points, _unit(tilt.points))]
    if len(pieces) == len(axes) > 1:
        return [q for p, a in zip(pieces, axes, strict=True) for q in couple([p], [a])]
    begin, end = axes[0].start, axes[-1].end
    lines = [polyline_of(p, CHORD).points for p in pieces]
    points = np.concatenate([lines[0]] + [x[1:] for x in lines[1:]])
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    t = (s / s[-1] if s[-1] > 0 else np.linspace(0, 1, len(s)))[:, None]
    return [Polyline(points, _unit((1 - t) * begin + t * end))]


def _couple_splines(path: Nurbs, tilt: Nurbs) -> Polyline:
    low, high = path.knots[0], path.knots[-1]
    u = _parameters(path, CHORD)

    def axes_at(parameters: Floats) -> Floats:
        v = tilt.knots[0] + (parameters - low) / (high - low) * (tilt.knots[-1] - tilt.knots[0])
        return _unit(evaluate(tilt, v))

    for _ in range(20):
        axes = axes_at(u)
        turn = elementary.arccos(np.clip((axes[:-1] * axes[1:]).sum(axis=1), -1.0, 1.0))
        coarse = turn > AXIS_STEP
        if not coarse.any() or len(u) > MAX_POINTS:
            break
        u = np.sort(np.concatenate([u, u[:-1][coarse] + 0.5 * np.diff(u)[coarse]]))
    return Polyline(evaluate(path, u), axes_at(u))


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)
