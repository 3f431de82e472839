"""The extents of curves in each axis: of arcs in closed form, of NURBS by successively divided hulls.

A coordinate of a helix about the axis n is x(θ) = c + r ρ cos(θ − φ) + b θ with ρ cos φ = e1 and ρ sin φ = e2. So
dx/dθ = 0 where sin(θ − φ) = b/(r ρ). These are two families of angles a turn apart. From turn to turn x changes by 2πb, so the
first and the last angle of each family hold the extrema; where the radius grows slightly, Newton's method finishes.

A piece of a rational B-spline with positive weights lies in the hull of its Bézier points. The points of [a, b] are its
polar form at (a, …, a, b, …, b) (L. Piegl, W. Tiller, The NURBS Book, section 5.3; L. Ramshaw, Blossoms are polar
forms, 1989). The hull closes in on the piece with the square of its length, so pieces whose hull reaches further than
the curve is known to reach are halved until none does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary, nurbs
from cncgen.geometry.arcs import Spirals
from cncgen.geometry.tables import NurbsTable

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: How closely the reach of a NURBS is found, as a part of the size of its hull.
_ACCURACY = 1e-12

#: Halvings of a piece at most.
_MAX_HALVINGS = 40


def arc_extents(arcs: Spirals) -> tuple[Floats, Floats]:
    """Return the lowest and highest coordinates along arcs, each of shape (m, axes)."""
    m = len(arcs.sweep)
    which = np.arange(m)
    ends = arcs.evaluate(np.tile(which, 2), np.concatenate([np.zeros(m), arcs.sweep]), 0)[0]
    ends = ends.reshape(2, m, -1)
    low, high = ends.min(axis=0), ends.max(axis=0)
    for column in range(3):
        across = np.hypot(arcs.e1[:, column], arcs.e2[:, column]) * arcs.radius
        phase = elementary.arctan2(arcs.e2[:, column], arcs.e1[:, column])
        turning = np.flatnonzero(across > np.abs(arcs.rise[:, column]))
        lean = elementary.arcsin(arcs.rise[turning, column] / across[turning])
        for base in (phase[turning] + lean, phase[turning] + np.pi - lean):
            first = np.mod(base, 2.0 * np.pi)
            sweep = arcs.sweep[turning]
            turns = np.floor((sweep - first) / (2.0 * np.pi))
            for angle in (first, first + 2.0 * np.pi * turns):
                there = (angle >= 0.0) & (angle <= sweep)
                rows = turning[there]
                x = arcs.evaluate(rows, _stationary(arcs, rows, angle[there], column), 0)[0, :, column]
                np.minimum.at(low[:, column], rows, x)
                np.maximum.at(high[:, column], rows, x)
    return low, high


def _stationary(arcs: Spirals, rows: Ints, angle: Floats, column: int) -> Floats:
    """Return the angles near `angle` where a coordinate stands still; places there are on the arc in any case."""
    for _ in range(3):
        _, slope, bend = arcs.evaluate(rows, angle, 2)[:, :, column]
        step = np.divide(slope, bend, out=np.zeros_like(slope), where=bend != 0)
        angle = np.clip(angle - step, 0.0, arcs.sweep[rows])
    return angle


def hulls(table: NurbsTable) -> tuple[Floats, Floats]:
    """Return the lowest and highest coordinates of the control points of each curve, each of shape (curves, axes)."""
    first = table.point_offset[:-1]
    points = table.control_points
    return np.minimum.reduceat(points, first, axis=0), np.maximum.reduceat(points, first, axis=0)


def nurbs_extents(table: NurbsTable, curve: int) -> tuple[Floats, Floats]:
    """Return the lowest and highest coordinates along one curve, each of shape (axes,)."""
    one = nurbs.take(table, [curve])
    degree, knots = int(one.degree[0]), one.knots
    homogeneous = np.column_stack([one.control_points * one.weights[:, None], one.weights])
    span = np.flatnonzero(np.diff(knots) > 0)
    span = span[(span >= degree) & (span < len(knots) - degree - 1)]
    a, b = knots[span], knots[span + 1]
    accuracy = _ACCURACY * np.maximum(np.abs(one.control_points).max(axis=0), 1.0)
    low, high = np.full((2, one.control_points.shape[1]), np.inf)
    high = -high
    for _ in range(_MAX_HALVINGS):
        points = _bezier_points(homogeneous, knots, degree, span, a, b)
        on_curve = points[:, [0, -1]].reshape(-1, points.shape[2])
        low, high = np.minimum(low, on_curve.min(axis=0)), np.maximum(high, on_curve.max(axis=0))
        beyond = (points.max(axis=1) > high + accuracy) | (points.min(axis=1) < low - accuracy)
        open_ = beyond.any(axis=1)
        if not open_.any():
            break
        span, a, b = span[open_], a[open_], b[open_]
        middle = 0.5 * (a + b)
        span, a, b = np.tile(span, 2), np.concatenate([a, middle]), np.concatenate([middle, b])
    return low, high


def _bezier_points(
    homogeneous: Floats, knots: Floats, degree: int, span: Ints, a: Floats, b: Floats
) -> Floats:
    """Return the Bézier points of pieces [a, b] within knot spans, shape (pieces, degree + 1, axes).

    The polar form of a span is de Boor's scheme with another argument at each level (Ramshaw 1989).
    """
    index = span[:, None] + np.arange(-degree, 1)
    points = []
    for j in range(degree + 1):
        level = homogeneous[index]
        for r in range(1, degree + 1):
            u = (a if r <= degree - j else b)[:, None]
            left = knots[index[:, r:]]
            right = knots[index[:, r:] + degree + 1 - r]
            share = ((u - left) / (right - left))[:, :, None]
            level = (1.0 - share) * level[:, :-1] + share * level[:, 1:]
        points.append(level[:, 0])
    corner = np.stack(points, axis=1)
    return corner[:, :, :-1] / corner[:, :, -1:]
