"""Rational B-splines: derivatives at parameters and arc length, for many curves at once, over the kernel.

A curve is Σ N_i w_i P_i / Σ N_i w_i (L. Piegl and W. Tiller, The NURBS Book (1997), eq. 4.1), in the columns of a
`cncgen.geometry.tables.NurbsTable`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cncgen.geometry.tables import Floats, Ints, NurbsTable, ranges
from cncgen.kernels import arc_length, bspline

#: Units in the last place of the largest coordinate that a control point of a straight line may be beside it for rounding
#: alone: at most 11, as docs/nurbs.md derives.
_ROUNDINGS = 12.0

#: Part of the size of a curve that its lengths and the place of a parameter on it are known to.
ACCURACY = 2e-13


def single(
    degree: int, knots: ArrayLike, control_points: ArrayLike, weights: ArrayLike | None = None
) -> NurbsTable:
    """Return a table of one curve.

    Args:
        degree: Degree, 1 or more.
        knots: Shape (points + degree + 1,), non-decreasing.
        control_points: Shape (points, axes).
        weights: Shape (points,), positive; all 1 where None.

    Raises:
        ValueError: If shapes or values do not make a curve.
    """
    points = np.ascontiguousarray(control_points, float)
    w = np.ones(len(points)) if weights is None else np.ascontiguousarray(weights, float)
    table = NurbsTable(
        np.array([degree], np.int64),
        np.array([0, len(points)], np.int64),
        np.array([0, np.size(knots)], np.int64),
        points,
        w,
        np.ascontiguousarray(knots, float),
    )
    check(table)
    return table


def check(table: NurbsTable) -> None:
    """Raise ValueError where a table is not one of curves: counts, order of the knots, weights, numbers not finite."""
    points, knots = np.diff(table.point_offset), np.diff(table.knot_offset)
    if (
        np.any(table.degree < 1)
        or np.any(points < table.degree + 1)
        or np.any(knots != points + table.degree + 1)
    ):
        raise ValueError("a curve needs degree + 1 points at least, and points + degree + 1 knots")
    within = np.ones(len(table.knots), bool)
    within[table.knot_offset[:-1]] = False
    if np.any(np.diff(table.knots, prepend=0.0)[within] < 0):
        raise ValueError("knots must not decrease")
    if not np.all(table.weights > 0):
        raise ValueError("weights must be positive")
    if not (np.all(np.isfinite(table.control_points)) and np.all(np.isfinite(table.knots + 0.0))):
        raise ValueError("control points and knots must be finite")


def concatenate(tables: list[NurbsTable]) -> NurbsTable:
    """Return one table of the curves of several, in order; all with the same axes, at least one table."""

    def chained(offsets: list[Ints]) -> Ints:
        sizes = np.concatenate([np.diff(o) for o in offsets])
        return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)

    return NurbsTable(
        np.concatenate([t.degree for t in tables]),
        chained([t.point_offset for t in tables]),
        chained([t.knot_offset for t in tables]),
        np.concatenate([t.control_points for t in tables]),
        np.concatenate([t.weights for t in tables]),
        np.concatenate([t.knots for t in tables]),
    )


def take(table: NurbsTable, curves: ArrayLike) -> NurbsTable:
    """Return a table of the chosen curves, in the order of `curves` (indices, repeats allowed)."""
    index = np.asarray(curves, np.int64)

    def gather(offset: Ints) -> tuple[Ints, Ints]:
        sizes = offset[index + 1] - offset[index]
        new = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
        return ranges(offset[index], sizes)[1], new

    points, point_offset = gather(table.point_offset)
    knots, knot_offset = gather(table.knot_offset)
    return NurbsTable(
        table.degree[index],
        point_offset,
        knot_offset,
        np.ascontiguousarray(table.control_points[points]),
        table.weights[points],
        table.knots[knots],
    )


def parameter_range(table: NurbsTable) -> tuple[Floats, Floats]:
    """Return first and last parameter of each curve, each of shape (m,)."""
    return (
        table.knots[table.knot_offset[:-1] + table.degree],
        table.knots[table.knot_offset[1:] - table.degree - 1],
    )


def evaluate(table: NurbsTable, curve: ArrayLike, u: ArrayLike, order: int = 0, side: int = 1) -> Floats:
    """Return the derivatives of order 0 .. `order` at parameters of curves.

    Args:
        curve: Index into the table, shape (n,) or a number for all.
        u: Parameters, shape (n,). Outside the range of a curve its first or last span goes on.
        order: 0 to 3.
        side: At a knot: 1 for the derivatives on its right, −1 for those on its left.

    Returns:
        Shape (order + 1, n, axes): C, dC/du, … of the rational curve (The NURBS Book, eqs. 3.8 and 4.8).

    Raises:
        ValueError: If `order` is not 0 to 3.
    """
    if not 0 <= order <= 3:
        raise ValueError(f"order must be 0 to 3, not {order}")
    parameters = np.ascontiguousarray(np.atleast_1d(u), float)
    curves = np.ascontiguousarray(np.broadcast_to(np.asarray(curve, np.int64), parameters.shape))
    out = np.empty((order + 1, len(parameters), table.control_points.shape[1]))
    bspline.evaluate(curves, parameters, side, order, columns(table), out)
    return out


def directions(table: NurbsTable) -> Floats:
    """Return the ways of spans that lie on a straight line, shape (control points, axes): in the row of a span's first control
    point, from that one to the furthest of its own; those of a curve that lies on one line as a whole all have its way.

    Of other spans, whose control points leave that line by more than the rounding of their coordinates, it is 0. By the
    convex hull a span is where its control points are (The NURBS Book, section 4.2).
    """
    out = np.empty_like(table.control_points, float, order="C")
    bspline.directions(columns(table), _ROUNDINGS, out)
    return out


def spans(table: NurbsTable, curve: Ints, u: Floats, side: int = 1) -> Ints:
    """Return the first control points of the spans of curves at parameters, on a side of knots, shape (n,).

    A span is found by bisection (The NURBS Book, Algorithm A2.1), on either side of a knot.
    """
    out = np.empty(len(curve), np.int64)
    bspline.spans(
        np.ascontiguousarray(curve, np.int64), np.ascontiguousarray(u, float), side, columns(table), out
    )
    return out


def columns(table: NurbsTable) -> bspline.Curves:
    """Return the columns of a table as the kernels take them."""
    return bspline.Curves(
        table.degree,
        table.point_offset,
        table.knot_offset,
        np.ascontiguousarray(table.control_points, float),
        table.weights,
        table.knots,
    )


@dataclass(frozen=True, slots=True)
class Lengths:
    """Arc length of every curve of a table, and the way back from length to parameter.

    Attributes:
        table: The curves.
        low, high: Shape (m,): the columns of the control points over which length is measured.
        offset: Shape (m + 1,): the cells of curve c are rows ``offset[c]`` to ``offset[c + 1]``.
        cells: Shape (cells, 12), see `cncgen.kernels.arc_length.CELL_COLUMNS`.
        begins: Shape (cells,), int8: flags of rows and spans that begin there, bits of `cncgen.kernels.arc_length`.
        total: Shape (m,), mm or rad.
    """

    table: NurbsTable
    low: Ints
    high: Ints
    offset: Ints
    cells: Floats
    begins: NDArray[np.int8]
    total: Floats

    def parameter(self, curve: Ints, s: Floats, side: int = 1, snap: float = 0.0) -> Floats:
        """Return the parameters at arc lengths from the start of curves, shape (n,): one polynomial of degree 7 a cell.

        Args:
            curve: Shape (n,), int64, rows of the table.
            s: Shape (n,), mm or rad.
            side: Where the curve stands still at s: 1 for the end of that stretch, −1 for its start.
            snap: Places within this length (mm or rad) of a knot are at the knot.
        """
        out = np.empty(len(s))
        arc_length.invert(curve, np.ascontiguousarray(s), side, snap, self.offset, self.cells, out)
        return out

    def cell_length(self, curve: Ints, u: Floats, side: int = 1) -> Floats:
        """Return the lengths (mm or rad) of the cells at parameters `u` of curves, shape (n,); where two meet, on `side`.

        They are few, for each is looked for by itself.
        """
        out = np.empty(len(u))
        border: Literal["left", "right"] = "right" if side >= 0 else "left"
        for k, (c, at) in enumerate(zip(curve.tolist(), u.tolist(), strict=True)):
            mine = self.cells[self.offset[c] : self.offset[c + 1]]
            out[k] = mine[max(int(np.searchsorted(mine[:, 0], at, side=border)) - 1, 0), 2]
        return out

    def at(self, curve: Ints, u: Floats) -> Floats:
        """Return the arc lengths (mm or rad) from the start of curves to parameters `u`, shape (n,)."""
        out = np.empty(len(u))
        arc_length.lengths(
            curve,
            np.ascontiguousarray(u),
            self.low,
            self.high,
            columns(self.table),
            self.offset,
            self.cells,
            out,
        )
        return out


def lengths(table: NurbsTable, low: Ints | None = None, high: Ints | None = None) -> Lengths:
    """Measure every curve of a table by adaptive Gauss-Legendre quadrature (B. Guenter and R. Parent (1990)).

    The way back is a Hermite polynomial a cell, the feed correction polynomial of K. Erkorkmaz and Y. Altintas (2005);
    docs/arc-length.md has the differences.

    Args:
        low, high: Shape (m,): the columns over which to measure; all where None.
    """
    curves = len(table)
    first = np.zeros(curves, np.int64) if low is None else low
    last = np.full(curves, table.control_points.shape[1], np.int64) if high is None else high
    offset = np.zeros(curves + 1, np.int64)
    room = 4 * (len(table.knots) - int(np.sum(table.degree))) + 64 if curves else 0
    cells, begins = np.empty((room, arc_length.CELL_COLUMNS)), np.empty(room, np.int8)
    if not curves:
        return Lengths(table, first, last, offset, cells, begins, np.zeros(0))
    measured = columns(table)
    done = 0
    while True:
        done = arc_length.cells(done, ACCURACY, first, last, measured, offset, cells, begins)
        if done == curves:
            break
        # No room for curve `done`: older values are kept, in twice the room.
        cells, begins = np.concatenate([cells, np.empty_like(cells)]), np.tile(begins, 2)
    cells, begins = cells[: offset[-1]].copy(), begins[: offset[-1]].copy()
    total = np.zeros(curves)
    some = offset[1:] > offset[:-1]
    ends = offset[1:][some] - 1
    total[some] = cells[ends, 1] + cells[ends, 2]
    return Lengths(table, first, last, offset, cells, begins, total)
