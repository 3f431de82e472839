"""B-splines: knots of the special forms, evaluation, cutting out a range, conics as rational curves."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cncgen.stepnc.geometry.pieces import Nurbs

Floats = NDArray[np.float64]


def bezier_knots(points: int, degree: int) -> Floats:
    """Return the knots of a piecewise Bézier curve: every inner knot `degree` times (ISO 10303-42, 4.4.36)."""
    spans = (points - 1) // degree
    inner = np.repeat(np.arange(1, spans), degree)
    return np.concatenate([np.zeros(degree + 1), inner, np.full(degree + 1, spans)]).astype(float)


def uniform_knots(points: int, degree: int) -> Floats:
    """Return the knots of a UNIFORM_CURVE: one after the other, its ends not clamped (ISO 10303-42, 4.4.34)."""
    return np.arange(points + degree + 1, dtype=float) - degree


def quasi_uniform_knots(points: int, degree: int) -> Floats:
    """Return the knots of a QUASI_UNIFORM_CURVE: uniform within, clamped at both ends (ISO 10303-42, 4.4.35)."""
    last = points - degree
    return np.concatenate([np.zeros(degree), np.arange(last + 1), np.full(degree, last)]).astype(float)


def evaluate(curve: Nurbs, parameters: Floats) -> Floats:
    """Return points, shape (n, 3), by de Boor's algorithm in homogeneous coordinates, all parameters at once."""
    p, knots = curve.degree, curve.knots
    homogeneous = np.concatenate([curve.control * curve.weights[:, None], curve.weights[:, None]], axis=1)
    span = np.clip(np.searchsorted(knots, parameters, side="right") - 1, p, len(knots) - p - 2)
    d = homogeneous[span[:, None] - p + np.arange(p + 1)[None, :]]
    for r in range(1, p + 1):
        for j in range(p, r - 1, -1):
            low = knots[span - p + j]
            width = knots[span + 1 + j - r] - low
            alpha = np.where(width > 0, (parameters - low) / np.where(width > 0, width, 1.0), 0.0)
            d[:, j] = (1.0 - alpha)[:, None] * d[:, j - 1] + alpha[:, None] * d[:, j]
    return d[:, p, :3] / d[:, p, 3:]


def _insert(homogeneous: Floats, knots: Floats, degree: int, u: float) -> tuple[Floats, Floats]:
    """Insert a knot once (W. Boehm, 1980)."""
    k = int(np.searchsorted(knots, u, side="right")) - 1
    k = min(max(k, degree), len(homogeneous) - 1)
    i = np.arange(k - degree + 1, k + 1)
    width = knots[i + degree] - knots[i]
    alpha = np.where(width > 0, (u - knots[i]) / np.where(width > 0, width, 1.0), 0.0)[:, None]
    middle = alpha * homogeneous[i] + (1.0 - alpha) * homogeneous[i - 1]
    points = np.concatenate([homogeneous[: k - degree + 1], middle, homogeneous[k:]])
    return points, np.insert(knots, k + 1, u)


def cut(curve: Nurbs, begin: float, end: float) -> Nurbs:
    """Return the part of a curve from parameter `begin` to `end` (begin < end, within the curve), clamped."""
    p, knots = curve.degree, curve.knots
    homogeneous = np.concatenate([curve.control * curve.weights[:, None], curve.weights[:, None]], axis=1)
    for u in (begin, end):
        for _ in range(p - int(np.count_nonzero(knots == u))):
            homogeneous, knots = _insert(homogeneous, knots, p, u)
    first = int(np.searchsorted(knots, begin, side="right")) - p
    last = int(np.searchsorted(knots, end, side="left")) + p
    inside = knots[first:last]
    new_knots = np.concatenate([[begin], inside, [end]])
    points = homogeneous[first - 1 : first - 1 + len(new_knots) - p - 1]
    return Nurbs(p, points[:, :3] / points[:, 3:], points[:, 3], new_knots)


def clamped(curve: Nurbs) -> Nurbs:
    """Return the same curve with its end points as first and last control points."""
    p, knots = curve.degree, curve.knots
    if knots[0] == knots[p] and knots[-1] == knots[-p - 1]:
        return curve
    return cut(curve, float(knots[p]), float(knots[-p - 1]))


def ellipse_arc(centre: Floats, major: Floats, minor: Floats, begin: float, sweep: float) -> Nurbs:
    """Return centre + major cos t + minor sin t, t from `begin` by `sweep` rad, as a rational quadratic.

    Arcs of a quarter turn or less, one knot span each, their middle points weighted by the cosine of half their angle
    (L. Piegl and W. Tiller, The NURBS Book (1997), Algorithm A7.1; the knots here are whole numbers).

    Args:
        centre: Shape (3,), mm.
        major, minor: Shape (3,): the conjugate half diameters.
        begin: rad.
        sweep: rad, not 0, at most a full turn either way.
    """
    count = max(1, math.ceil(abs(sweep) / (math.pi / 2) - 1e-9))
    half = sweep / count / 2
    angles = begin + half * np.arange(2 * count + 1)
    scale = np.where(np.arange(2 * count + 1) % 2 == 1, 1.0 / math.cos(half), 1.0)
    flat = np.cos(angles)[:, None] * major + np.sin(angles)[:, None] * minor
    weights = np.where(np.arange(2 * count + 1) % 2 == 1, math.cos(half), 1.0)
    inner = np.repeat(np.arange(1, count), 2)
    knots = np.concatenate([np.zeros(3), inner, np.full(3, count)]).astype(float)
    return Nurbs(2, centre + scale[:, None] * flat, weights, knots)


def nearest_parameter(curve: Nurbs, point: Floats) -> tuple[float, float]:
    """Return the parameter of the point of a curve nearest to `point`, and its distance (mm)."""
    low, high = float(curve.knots[curve.degree]), float(curve.knots[-curve.degree - 1])
    u = np.linspace(low, high, 20 * len(curve.control) + 1)
    for _ in range(60):
        distance = np.linalg.norm(evaluate(curve, u) - point, axis=1)
        k = int(np.argmin(distance))
        step = (u[-1] - u[0]) / (len(u) - 1)
        if step <= 1e-13 * max(abs(low), abs(high), 1.0):
            break
        u = np.linspace(max(low, u[k] - step), min(high, u[k] + step), 21)
    return float(u[k]), float(distance[k])
