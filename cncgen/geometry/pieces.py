"""Rows of lines, arcs and NURBS as cubic pieces by arc length: the input of a spline fit.

`pieces_of` cuts many rows at a time; `RowPieces.joined` lays those of one run after one another.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.geometry.columns import max_over_axes, norm
from cncgen.geometry.path import ARC, LINE, NURBS, Path
from cncgen.geometry.tables import Floats, Ints, ranges

#: Part of the tolerance that cubic pieces of an arc may miss it by.
ARC_SHARE = 1e-3
#: The same for those of a NURBS.
NURBS_SHARE = 1e-5
#: Turn of a cubic piece below which only rounding bends it.
_STRAIGHT = 1e-9


@dataclass(frozen=True, slots=True)
class Pieces:
    """Cubic pieces y(t), n of them, t being the path coordinate from the first one's start.

    Attributes:
        t: Shape (n + 1,).
        y: Shape (n, 4, axes): power coefficients in t − t[k], columns multiplied by their scale (all mm).
        bend: Shape (n,): bound of |y''|, 1/mm.
        tolerance: Shape (n,), mm: the tolerance less the pieces' own error.
        for_turn, for_step: Shape (n,), mm: smoothing lengths for the turn and the step of curvature behind each (`_joint_lengths`);
            those of the last one mean nothing.
        row: Shape (n,): the row that each came from, counted among those chosen.
        row_t: Shape (rows + 1,): t at the ends of these rows.
    """

    t: Floats
    y: Floats
    bend: Floats
    tolerance: Floats
    for_turn: Floats
    for_step: Floats
    row: Ints
    row_t: Floats


@dataclass(frozen=True, slots=True)
class RowPieces:
    """Cubic pieces of rows, n of them: as in `Pieces`, but each placed in its own row.

    Attributes:
        length: Shape (rows,), mm.
        at: Shape (n,): where each begins, from the start of its row, mm.
        y, bend, tolerance, for_turn, for_step, row: As in `Pieces`.
    """

    length: Floats
    at: Floats
    y: Floats
    bend: Floats
    tolerance: Floats
    for_turn: Floats
    for_step: Floats
    row: Ints

    def joined(self, first: int = 0, stop: int | None = None) -> Pieces:
        """Return those of the rows first … stop (all), each of which starts where the one before it ends."""
        row_t = np.concatenate([[0.0], np.cumsum(self.length[first:stop])])
        a, b = np.searchsorted(self.row, (first, first + len(row_t) - 1))
        row = self.row[a:b] - first
        t = np.append(row_t[row] + self.at[a:b], row_t[-1])
        of = slice(a, b)
        return Pieces(
            t, self.y[of], self.bend[of], self.tolerance[of], self.for_turn[of], self.for_step[of], row, row_t
        )


def pieces_of(path: Path, tolerance: Floats, scale: Floats, rows: Ints | None = None) -> RowPieces:
    """Cut rows of a path that move X Y Z, each of them longer than 0, into cubic pieces.

    A line is one piece. An arc is cut so that the cubic Hermite interpolant by its points and tangents misses it by at
    most `ARC_SHARE` of the tolerance: |x − y| ≤ h⁴ max|x''''| / 384 (C. de Boor, A Practical Guide to Splines, IV). A
    NURBS is cut at its knots, and between them until the interpolant misses it by `NURBS_SHARE` of the tolerance only.
    The second derivative, known to h² max|x''''| / 12, is then nearly its own where the curve itself goes on.

    Args:
        tolerance: Shape (rows,), mm, of the chosen rows.
        scale: Shape (axes,): mm an axis unit, 1 for linear axes.
        rows: The rows, ascending; all where None.
    """
    chosen = np.arange(len(path)) if rows is None else rows
    length = path.row_length[chosen]
    kind = path.kind[chosen]
    row, at, h = _cut(path, chosen, kind, length, tolerance)
    y = np.zeros((len(row), 4, len(path.axes)))
    start = path.starts[chosen]
    y[:, 0] = start[row]
    y[:, 1] = ((path.end[chosen] - start) / length[:, None])[row]
    bend = np.zeros(len(row))
    curved = np.flatnonzero(kind[row] != LINE)
    if curved.size:
        cubic = _hermite(path, chosen[row[curved]], at[curved], h[curved]) * scale
        y[curved] = cubic
        ends = 2.0 * cubic[:, 2], 2.0 * cubic[:, 2] + 6.0 * h[curved, None] * cubic[:, 3]
        # The second derivative of a cubic is linear.
        bend[curved] = np.maximum(*(norm(end) for end in ends))
    straight = kind[row] == LINE
    y[straight] *= scale
    share = np.select([kind == LINE, kind == ARC], [0.0, ARC_SHARE], NURBS_SHARE)
    left = ((1.0 - share) * tolerance)[row]
    return RowPieces(length, at, y, bend, left, *_joint_lengths(y, h, left), row)


def _cut(
    path: Path, chosen: Ints, kind: NDArray[np.int8], length: Floats, tolerance: Floats
) -> tuple[Ints, Floats, Floats]:
    """Return the row (counted among the chosen), the distance from its start, and the length of every piece."""
    count = np.ones(len(chosen), np.int64)
    arcs, curves = np.flatnonzero(kind == ARC), np.flatnonzero(kind == NURBS)
    if arcs.size:
        count[arcs] = _arc_counts(path, chosen[arcs], tolerance[arcs])
    row, number = ranges(np.zeros_like(count), count)
    h = (length / count)[row]
    at = number * h
    if curves.size:
        others = np.flatnonzero(kind[row] != NURBS)
        of, begin, width = _nurbs_cuts(path, chosen[curves], tolerance[curves])
        row = np.concatenate([row[others], curves[of]])
        at, h = np.concatenate([at[others], begin]), np.concatenate([h[others], width])
        order = np.lexsort((at, row))
        row, at, h = row[order], at[order], h[order]
    return row, at, h


def _nurbs_cuts(path: Path, rows: Ints, tolerance: Floats) -> tuple[Ints, Floats, Floats]:
    """Cut NURBS rows; see `_cut`."""
    of, begin, width = path.panels(rows)
    there = width > 0.0
    of, begin, width = of[there], begin[there], width[there]
    half = 0.5 * width
    c = np.moveaxis(_hermite(path, rows[of], begin, width), 1, 0)
    u = half[:, None]
    middle = path.evaluate_parameter(rows[of], path.parameter_after(rows[of], begin + half))[0]
    miss = norm(c[0] + u * (c[1] + u * (c[2] + u * c[3])) - middle)
    turn = width * path.curvature_after(rows[of], begin + half)
    count = np.ceil(np.maximum(elementary.power(miss / (NURBS_SHARE * tolerance[of]), 0.25), turn / 0.4))
    count = count.clip(1, 1000).astype(np.int64)
    inner = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    h = np.repeat(width / count, count)
    return np.repeat(of, count), np.repeat(begin, count) + inner * h, h


def _arc_counts(path: Path, arcs: Ints, tolerance: Floats) -> Ints:
    """Return into how many pieces to cut arcs."""
    length = path.row_length[arcs]
    looks = []
    # A spiral bends more at its inner end; radii differ by a tolerance, tiny arcs by more.
    for share in (0.0, 0.5, 1.0):
        _, x1, x2 = path.evaluate_parameter(arcs, path.parameter_after(arcs, share * length), 2)
        looks.append((norm(x1[:, :3]), norm(x2[:, :3])))
    # Derivatives by the angle: the fourth is as long as the second, the radius. A helix turns as often however little it bends.
    speed, radius = np.min([look[0] for look in looks], axis=0), np.max([look[1] for look in looks], axis=0)
    widest = speed * elementary.power(384.0 * ARC_SHARE * tolerance / radius, 0.25)
    # At least eight to a turn, for the bound is one of small angles.
    widest = np.minimum(widest, 0.8 * speed)
    return np.ceil(length / widest).astype(np.int64).clip(1, 1_000_000)


def _hermite(path: Path, row: Ints, s: Floats, h: Floats) -> Floats:
    """Cubic coefficients by point and tangent at both ends of s … s + h on rows, s from the start of each."""
    ends = []
    for at, side in ((s, 1), (s + h, -1)):
        u = path.parameter_after(row, at, side)
        x, x1 = path.evaluate_parameter(row, u, 1, side)
        ends.append((x, x1 / norm(x1[:, :3])[:, None]))
    (x0, d0), (x1, d1) = ends
    h = h[:, None]
    way = (x1 - x0) / h
    # Both less than rounding leaves of them on a straight piece, which is a line then, as if it had been written as one.
    bent = max_over_axes(np.maximum(np.abs(3 * way - 2 * d0 - d1), np.abs(d0 + d1 - 2 * way))) > _STRAIGHT
    c1 = np.where(bent[:, None], d0, way)
    c2 = np.where(bent[:, None], (3 * way - 2 * d0 - d1) / h, 0.0)
    c3 = np.where(bent[:, None], (d0 + d1 - 2 * way) / h**2, 0.0)
    return np.stack([x0, c1, c2, c3], 1)


def _joint_lengths(y: Floats, h: Floats, tolerance: Floats) -> tuple[Floats, Floats]:
    """Guess the smoothing lengths that the turn and the step of curvature behind each piece take, shape (n,), mm.

    A smoothing spline of order 3 and length L rounds a turn by Δx' off by L |Δx'| / 3, and a step of curvature Δx'' by
    about 0.14 L² |Δx''| (docs/smoothing.md). L is half as much again as what makes that the tolerance, for turns and
    steps in a row to and fro round each other off; where they do not, the fit shrinks it.

    Args:
        y, tolerance: As in `Pieces`.
        h: Shape (n,), mm: lengths of the pieces.
    """
    after, h = y[np.minimum(np.arange(1, len(y) + 1), len(y) - 1)], h[:, None]
    turn = after[:, 1] - (y[:, 1] + h * (2 * y[:, 2] + 3 * h * y[:, 3]))
    step = 2 * after[:, 2] - (2 * y[:, 2] + 6 * h * y[:, 3])
    within = np.minimum(tolerance, np.append(tolerance[1:], np.inf))
    by_turn = 4.0 * within / np.maximum(norm(turn), 1e-9 * within)
    by_step = np.sqrt(within / (0.067 * norm(step) + 1e-18 * within))
    return by_turn, by_step
