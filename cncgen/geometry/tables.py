"""Side tables of curves: many arcs or NURBS as a few flat arrays, instead of a million objects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def ranges(first: Ints, count: Ints) -> tuple[Ints, Ints]:
    """Return of which range each number is, and the numbers, shape (n,) each: `count` numbers from each of `first` on, in a row."""
    of = np.repeat(np.arange(len(count)), count)
    return of, np.arange(len(of)) + (first - np.cumsum(count) + count)[of]


@dataclass(frozen=True, slots=True)
class ArcTable:
    """Circular arcs and helices in space, `m` rows.

    The angle runs from the start point about `normal` (right-handed) by `sweep`. The motion along `normal` and in
    the other axes grows linearly with the angle (a helix); where the end radius differs from
    the start radius by the accepted tolerance, the radius too is linear in the angle.

    Attributes:
        centre: Shape (m, 3), mm, a point of the axis of rotation at the height of the start point.
        normal: Shape (m, 3), unit vectors.
        sweep: Shape (m,), rad, more than 2π for several turns; positive: `normal` gives the sense.
    """

    centre: Floats
    normal: Floats
    sweep: Floats

    def __len__(self) -> int:
        return len(self.sweep)


@dataclass(frozen=True, slots=True)
class NurbsTable:
    """Rational B-spline curves in all axes of the program, `m` of them, stored end to end.

    Curve `i` has degree ``degree[i]``, control points ``control_points[point_offset[i]:point_offset[i+1]]`` (weights
    alike) and knots ``knots[knot_offset[i]:knot_offset[i+1]]``; number of knots = number of points + degree + 1.
    Parameter range: from ``knots[degree]`` to ``knots[-degree-1]`` of that curve.

    Attributes:
        degree: Shape (m,).
        point_offset, knot_offset: Shape (m + 1,), starting with 0.
        control_points: Shape (sum of points, axes), mm or rad, not multiplied by the weights.
        weights: Shape (sum of points,), positive.
        knots: Shape (sum of knots,), non-decreasing within a curve.
    """

    degree: Ints
    point_offset: Ints
    knot_offset: Ints
    control_points: Floats
    weights: Floats
    knots: Floats

    def __len__(self) -> int:
        return len(self.degree)


def empty_arcs() -> ArcTable:
    """Return a table of no arcs."""
    return ArcTable(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


def empty_nurbs(axes: int) -> NurbsTable:
    """Return a table of no curves for that many axes."""
    zero = np.zeros(1, np.int64)
    return NurbsTable(np.zeros(0, np.int64), zero, zero, np.zeros((0, axes)), np.zeros(0), np.zeros(0))
