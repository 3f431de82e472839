"""A path: lines, arcs, helices and NURBS one after the other, as functions of one coordinate s.

The coordinate is arc length in X Y Z on a row that moves them, else in U V W, else the Euclidean norm of the rotary
axes' motion (rad). So ds/dt is the programmed feed (Kramer et al. (2000), section 2.1.2.5). If a line moves the first of these groups
much less than a later one, it is measured over the later one: otherwise the rounding of s would show as steps of the other axes. Rows
are those of a toolpath, as plain columns.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cncgen.geometry import elementary
from cncgen.geometry import nurbs as splines
from cncgen.geometry.arcs import Spirals, spirals
from cncgen.geometry.columns import max_over_axes, norm, total
from cncgen.geometry.tables import ArcTable, Floats, Ints, NurbsTable, ranges
from cncgen.kernels import arc_length, path_derivatives
from cncgen.units import ROTARY_LETTERS

#: Kind of a row; the values of `cncgen.toolpath.record.Kind`.
LINE, ARC, NURBS, EVENT = range(4)

#: mm or rad: a row that moves X Y Z (U V W) by less counts as not moving them when its path coordinate is chosen.
STANDSTILL = 1e-9
#: Path coordinates that differ by less than this many units in the last place of the largest are the same; and the multiple of
#: that up to which breakpoints are one, and a row has no length.
_ROUNDINGS, _SAME_PLACE = 4.0, 2.0
#: A line that moves X Y Z (U V W) by less than this part of what U V W or rotary axes move by, mm or rad, is measured over
#: those: 0.17 µm a degree. Coordinates of 1 m carry 1e-13 mm of rounding, which is then below the ninth decimal of a degree.
_NEGLIGIBLE = 1e-2

#: |dC/du| may vanish where it is below the first part of its mean over the curve; it does where, besides, the cell of the
#: arc-length table is shorter than the second part of the curve.
_SMALL_SPEED, _TINY_CELL = 1e-4, 1e-9
#: At a place where |dC/du| vanishes derivatives are taken beside it: by these parts of the curve's length, for the first
#: derivative and from the second on, far enough to keep their digits.
_BESIDE = ((1, 1e-10), (2, 1e-8))
#: Rounding of the derivatives of a curve by its parameter, as a part of the sizes that are added up; and the largest part of a
#: bend that may be rounding: with more of it derivatives are taken beside the place.
_DERIVATIVE_ROUNDING, _ROUNDING_PART = 2.0**-46, 1e-3
#: C' vanishes on a tiny cell if its largest size there is more than this multiple of its mean.
_VANISHING_RATIO = 1.7


@dataclass(frozen=True, slots=True)
class Jumps:
    """Jumps from left to right at the breakpoints inside a path, `n` of them.

    Attributes:
        s: Shape (n,), path coordinate.
        before, after: Shape (n,): rows on the left and on the right.
        tangent, second, third: Shape (n, axes): change of dx/ds, d²x/ds², d³x/ds³.
    """

    s: Floats
    before: Ints
    after: Ints
    tangent: Floats
    second: Floats
    third: Floats


def metric_columns(axes: str) -> tuple[slice, slice, slice]:
    """Return the columns of X Y Z, of U V W and of the rotary axes among `axes` (in the order XYZABCUVW)."""
    rotary = sum(letter in ROTARY_LETTERS for letter in axes)
    return slice(0, 3), slice(3 + rotary, len(axes)), slice(3, 3 + rotary)


class Path:
    """A path of `n` rows, evaluated at path coordinates s.

    Attributes:
        axes: Letters of the columns, X Y Z first.
        row_s: Shape (n + 1,): s at the start of each row, and the end. EVENT rows have length 0.
        row_length: Shape (n,): length of each row, computed by itself (not as a difference of `row_s`, which is rounded); 0
            where it is nothing but rounding.
        feed_length: Shape (n,): the length along which the feed of each row is meant. It differs from `row_length` for lines
            that are measured over other axes than the feed is meant for (`per_feed`).
    """

    def __init__(
        self,
        axes: str,
        start: ArrayLike,
        kind: ArrayLike,
        end: ArrayLike,
        curve: ArrayLike,
        arcs: ArcTable,
        nurbs: NurbsTable,
        s_start: float = 0.0,
    ) -> None:
        """Measure the rows.

        Args:
            axes: Letters of the columns, a subsequence of ``XYZABCUVW`` with X Y Z.
            start: Shape (axes,), where the first row starts.
            kind: Shape (n,): `LINE`, `ARC`, `NURBS` or `EVENT`.
            end: Shape (n, axes).
            curve: Shape (n,): index into `arcs` or `nurbs`.
            arcs, nurbs: The curves.
            s_start: Path coordinate of the start.
        """
        self.axes = axes
        self.kind: NDArray[np.int8] = np.ascontiguousarray(kind, np.int8)
        self.end: Floats = np.ascontiguousarray(end, float).reshape(len(self.kind), len(axes))
        self.start: Floats = np.asarray(start, float)
        self.starts: Floats = np.concatenate([self.start[None, :], self.end])[:-1]
        self._curve: Ints = np.asarray(curve, np.int64)
        self._nurbs_rows = np.flatnonzero(self.kind == NURBS)
        self._arc_rows = np.flatnonzero(self.kind == ARC)
        self._delta: Floats = np.where((self.kind == LINE)[:, None], self.end - self.starts, 0.0)
        self._low, self._high = self._metric(nurbs)
        used = self._arc_rows
        self._arcs: Spirals = spirals(
            ArcTable(*(column[self._curve[used]] for column in (arcs.centre, arcs.normal, arcs.sweep))),
            self.starts[used],
            self.end[used],
        )
        chosen = self._curve[self._nurbs_rows]
        table = nurbs if np.array_equal(chosen, np.arange(len(nurbs))) else splines.take(nurbs, chosen)
        self._nurbs: splines.Lengths = self._measured(table)
        lags = self._nurbs_rows[self._lagging()]
        if lags.size:
            self._low[lags], self._high[lags] = 0, len(self.axes)
            self._nurbs = self._measured(table)
        # Rows of the path -> rows of the tables made above.
        self._item: Ints = np.zeros(len(self.kind), np.int64)
        self._item[self._arc_rows] = np.arange(len(self._arc_rows))
        self._item[self._nurbs_rows] = np.arange(len(self._nurbs_rows))
        self.feed_length: Floats = self._row_lengths()
        self.row_length: Floats = self.feed_length
        if self._measure_by_faster():
            self.row_length = self._row_lengths()
            # A row that moves by less than a standstill has its feed along the axes that measure it.
            self.feed_length = np.where(self.feed_length > 0.0, self.feed_length, self.row_length)
        self._drop_unresolved(s_start)
        self.row_s: Floats = s_start + np.concatenate([[0.0], np.cumsum(self.row_length)])

    def _metric(self, nurbs: NurbsTable) -> tuple[Ints, Ints]:
        """Return first and last column over which each row is measured."""
        _, uvw, rotary = metric_columns(self.axes)
        moves = np.abs(self._delta)
        rows, chosen = self._nurbs_rows, self._curve[self._nurbs_rows]
        if rows.size:
            first, last = nurbs.point_offset[:-1], nurbs.point_offset[1:]
            sizes = np.repeat(first, last - first)
            away = np.abs(nurbs.control_points - nurbs.control_points[sizes])
            moves[rows] = np.maximum.reduceat(away, first, axis=0)[chosen]
        moves[self._arc_rows, :3] = 1.0
        low, high = np.zeros(len(moves), np.int64), np.full(len(moves), 3, np.int64)
        still = max_over_axes(moves[:, :3]) <= STANDSTILL
        for group in (rotary, uvw):
            if group.stop > group.start:
                here = still & (max_over_axes(moves[:, group]) > STANDSTILL)
                low[here], high[here] = group.start, group.stop
        if rows.size and len(self.axes) > 3:
            # A curve that halts in these columns while another axis goes on is measured over all of them.
            halts = _halting(nurbs, low[rows], high[rows], chosen)
            low[rows[halts]], high[rows[halts]] = 0, len(self.axes)
        return low, high

    def _measured(self, table: NurbsTable) -> splines.Lengths:
        return splines.lengths(table, self._low[self._nurbs_rows], self._high[self._nurbs_rows])

    def _lagging(self) -> Ints:
        """Return the NURBS that turn back, or nearly halt, in the axes they are measured over while another axis goes on.

        Where C' vanishes, cells of the table of lengths are short: so it is enough to look at the starts of cells.
        """
        if len(self.axes) == 3 or not self._nurbs_rows.size:
            return self._nurbs_rows[:0]
        found = self._nurbs
        item = np.repeat(np.arange(len(found.total)), np.diff(found.offset))
        first = splines.evaluate(found.table, item, found.cells[:, 0], 1)[1]
        slow = _metric_norm(first, found.low[item], found.high[item]) < _NEGLIGIBLE * np.linalg.norm(
            first, axis=1
        )
        return np.unique(item[slow])

    def _measure_by_faster(self) -> bool:
        """Measure lines by U V W or rotary axes where what they are measured by is next to nothing beside; tell whether any is."""
        _, uvw, rotary = metric_columns(self.axes)
        some = False
        for group in (uvw, rotary):
            if group.stop > group.start:
                other = np.linalg.norm(self._delta[:, group], axis=1)
                slight = _metric_norm(self._delta, self._low, self._high) < _NEGLIGIBLE * other
                self._low[slight], self._high[slight] = group.start, group.stop
                some = some or bool(slight.any())
        return some

    def _row_lengths(self) -> Floats:
        length = np.zeros(len(self.kind))
        lines = np.flatnonzero(self.kind == LINE)
        column = np.arange(len(self.axes))
        within = (column >= self._low[lines, None]) & (column < self._high[lines, None])
        length[lines] = norm(np.where(within, self._delta[lines], 0.0))
        length[self._arc_rows] = self._arcs.length
        length[self._nurbs_rows] = self._nurbs.total
        return length

    def _drop_unresolved(self, s_start: float) -> None:
        """Set the length of rows to 0 where it is nothing but rounding of their ends, or of s, so that they are doubled points.

        Such a row comes from increments that add up to a point except for rounding, and then that point itself. It has no
        direction, and its ends are one place.
        """
        ends = max_over_axes(np.abs(self.end))
        size = np.maximum(ends, max(abs(s_start), abs(s_start + float(self.row_length.sum()))))
        lost = self.row_length <= _SAME_PLACE * _ROUNDINGS * np.spacing(size)
        self.row_length[lost] = 0.0
        self.feed_length[lost] = 0.0

    @property
    def length(self) -> float:
        """Length of the path in its coordinate."""
        return float(self.row_s[-1] - self.row_s[0])

    @property
    def measured_by(self) -> NDArray[np.int8]:
        """Shape (n,): over which of `metric_columns` each row's coordinate is, 0 for X Y Z; 3 for all of them."""
        out = np.full(len(self.kind), 3, np.int8)
        for number, group in reversed(list(enumerate(metric_columns(self.axes)))):
            out[(self._low == group.start) & (self._high == group.stop)] = number
        return out

    @property
    def moves_xyz(self) -> NDArray[np.bool_]:
        """Shape (n,): whether a row's coordinate is arc length in X Y Z alone (or the row has no length)."""
        return self.measured_by == 0

    @property
    def turns(self) -> NDArray[np.bool_]:
        """Shape (n,): whether a row's coordinate is the angle of rotary axes instead of a length."""
        return self.measured_by == 2

    @property
    def per_feed(self) -> Floats:
        """Shape (n,): factor from the feed of each row to ds/dt: 1, except where `feed_length` is not `row_length`."""
        one = np.ones(len(self.kind))
        return np.divide(
            self.row_length, self.feed_length, out=one, where=self.feed_length != self.row_length
        )

    def __len__(self) -> int:
        return len(self.kind)

    @cached_property
    def _snap(self) -> float:
        """Rounding of a path coordinate: s that differ by less are the same."""
        return _ROUNDINGS * float(np.spacing(np.abs(self.row_s[[0, -1]]).max()))

    def row_of(self, s: ArrayLike, side: int = 1) -> Ints:
        """Return the row at each s, shape (n,).

        At the end of a row: the next one that moves for `side` 1, the last one that moved for −1. Outside the path,
        the first or the last row that moves.

        Raises:
            ValueError: If the path has no rows.
        """
        at = np.ascontiguousarray(np.atleast_1d(np.asarray(s, float)))
        out = np.empty(at.shape, np.int64)
        path_derivatives.rows(self._columns, at, side, out)
        return out

    @cached_property
    def _moving(self) -> tuple[int, int]:
        """The first and the last row that moves."""
        if not len(self):
            raise ValueError("a path without rows has no points to evaluate")
        moving = np.flatnonzero(np.diff(self.row_s) > 0)
        return (int(moving[0]), int(moving[-1])) if moving.size else (0, len(self) - 1)

    def parameter(self, row: ArrayLike, s: ArrayLike, side: int = 1) -> Floats:
        """Return each row's own parameter at s: 0 … 1 on a line, the angle (rad) on an arc, u on a NURBS.

        Args:
            row: Shape (n,) or a number for all.
            s: Shape (n,), path coordinate, held within the row.
            side: Where a NURBS stands still at s: 1 for the end of that stretch, −1 for its start.
        """
        at = np.atleast_1d(np.asarray(s, float))
        rows = np.broadcast_to(np.asarray(row, np.int64), at.shape)
        return self.parameter_after(rows, at - self.row_s[rows], side)

    def parameter_after(self, rows: Ints, distance: Floats, side: int = 1) -> Floats:
        """Return each row's own parameter at a distance in s (mm or rad) from its start, shape (n,); see `parameter`."""
        length = self.row_length[rows]
        local = np.minimum(np.clip(distance, 0.0, None), length)
        out = np.divide(local, length, out=np.zeros_like(local), where=length > 0)
        for kind, pick in self._curved(rows):
            item = self._item[rows[pick]]
            if kind == ARC:
                out[pick] = self._arcs.angle_at(item, local[pick])
            else:
                out[pick] = self._nurbs.parameter(item, local[pick], side, self._snap)
        return out

    def coordinate(self, row: ArrayLike, parameter: ArrayLike) -> Floats:
        """Return s at each row's own parameter: the inverse of `parameter`, shape (n,)."""
        u = np.atleast_1d(np.asarray(parameter, float))
        rows = np.broadcast_to(np.asarray(row, np.int64), u.shape)
        out = u * (self.row_s[rows + 1] - self.row_s[rows])
        for kind, pick in self._curved(rows):
            table = self._arcs.length_to if kind == ARC else self._nurbs.at
            out[pick] = table(self._item[rows[pick]], u[pick])
        return self.row_s[rows] + out

    def _curved(self, rows: Ints) -> list[tuple[int, Ints]]:
        """Return which of the rows are arcs and which NURBS, without missing kinds."""
        kinds = self.kind[rows]
        there = [(ARC, self._arc_rows), (NURBS, self._nurbs_rows)]
        picks = [(kind, np.flatnonzero(kinds == kind)) for kind, some in there if some.size]
        return [(kind, pick) for kind, pick in picks if pick.size]

    def evaluate_parameter(
        self, row: ArrayLike, parameter: ArrayLike, order: int = 0, side: int = 1
    ) -> Floats:
        """Return position and derivatives with respect to each row's own parameter, shape (order + 1, n, axes)."""
        u = np.atleast_1d(np.asarray(parameter, float))
        rows = np.broadcast_to(np.asarray(row, np.int64), u.shape)
        curved = self._curved(rows)
        if len(curved) == 1 and len(curved[0][1]) == len(rows):
            return self._evaluate_kind(curved[0][0], rows, u, order, side)
        out = np.zeros((order + 1, len(u), len(self.axes)))
        delta = self._delta[rows]
        # From the nearer end, so that both ends are met to the bit.
        out[0] = np.where(
            (u < 0.5)[:, None],
            self.starts[rows] + u[:, None] * delta,
            self.end[rows] - (1.0 - u)[:, None] * delta,
        )
        if order > 0:
            out[1] = delta
        for kind, pick in curved:
            out[:, pick] = self._evaluate_kind(kind, rows[pick], u[pick], order, side)
        return out

    def _evaluate_kind(self, kind: int, rows: Ints, u: Floats, order: int, side: int) -> Floats:
        """Evaluate rows that are all arcs or all NURBS."""
        if kind == ARC:
            return self._arcs.evaluate(self._item[rows], u, order)
        return splines.evaluate(self._nurbs.table, self._item[rows], u, order, side)

    def evaluate(self, s: ArrayLike, order: int = 0, side: int = 1) -> Floats:
        """Return position and derivatives with respect to s.

        Args:
            s: Shape (n,), any order; a coordinate outside the path is taken as its end.
            order: 0 to 3.
            side: At a breakpoint: 1 for the derivatives on its right, −1 for those on its left.

        Returns:
            Shape (order + 1, n, axes): x, dx/ds, d²x/ds², d³x/ds³. With g = ds/du = |C'| over the row's measured axes,
            x' = C'/g, x'' = (C'' − x' g')/g², x''' = (C''' − 3 x'' g g' − x' g'')/g³ (docs/arc-length.md).
            Where C' vanishes (a cusp, coinciding control points) the derivatives are those beside it, on the
            chosen side (the first by 1e-10 of the curve's length, further ones by 1e-8); on a row of length 0 they are 0.

        Raises:
            ValueError: If the path has no rows, or `order` is not 0 to 3.
        """
        if not 0 <= order <= 3:
            raise ValueError(f"order must be 0 to 3, not {order}")
        at = np.ascontiguousarray(np.atleast_1d(np.asarray(s, float)))
        rows, slow = np.empty((2, len(at)), np.int64)
        u = np.empty(len(at))
        out = np.empty((order + 1, len(at), len(self.axes)))
        found = path_derivatives.evaluate(self._columns, at, side, order, rows, u, slow, out)
        if len(self._arc_rows):
            arcs = np.flatnonzero(self.kind[rows] == ARC)
            if arcs.size:
                out[:, arcs] = self._evaluate_arcs(rows[arcs], at[arcs], order)
        if found:
            self._beside_singular(out, self._singular(slow[:found], rows, at, u, side), rows, u, side)
        return out

    def _evaluate_arcs(self, rows: Ints, s: Floats, order: int) -> Floats:
        """Return positions on arcs at path coordinates, and derivatives with respect to these."""
        item = self._item[rows]
        distance = np.clip(s - self.row_s[rows], 0.0, self.row_length[rows])
        out = self._arcs.evaluate(item, self._arcs.angle_at(item, distance), order)
        if order > 0:
            path_derivatives.by_length(self._low[rows], self._high[rows], out)
        return out

    @cached_property
    def _columns(self) -> path_derivatives.Rows:
        """The path as the kernel takes it."""
        return path_derivatives.Rows(
            self.row_s,
            self.row_length,
            self.kind,
            self._item,
            self.starts,
            self.end,
            *self._moving,
            self._snap,
            splines.columns(self._nurbs.table),
            self._nurbs.low,
            self._nurbs.high,
            self._nurbs.offset,
            self._nurbs.cells,
            self._nurbs.total,
            self._along,
            _SMALL_SPEED,
        )

    @cached_property
    def _along(self) -> Floats:
        """Shape (control points, axes): dx/ds of spans of NURBS on a straight line, see `splines.directions`; 0 of others."""
        table = self._nurbs.table
        way = splines.directions(table)
        points = np.diff(table.point_offset)
        low, high = np.repeat(self._nurbs.low, points), np.repeat(self._nurbs.high, points)
        length = _metric_norm(way, low, high)[:, None]
        return np.divide(way, length, out=np.zeros_like(way), where=length > 0.0)

    def _singular(self, slow: Ints, rows: Ints, s: Floats, u: Floats, side: int) -> Ints:
        """Return at which of the places where |C'| is small it vanishes, or leaves of the further derivatives by s only rounding.

        Cells of the table of lengths are short there. They are, too, where a curve goes round a sharp bend, as it does beside
        a control point of large weight: derivatives are what they are there, and others a little beside.
        """
        item = self._item[rows[slow]]
        brief = self._nurbs.cell_length(item, u[slow], side) <= _TINY_CELL * self._nurbs.total[item]
        slow, item = slow[brief], item[brief]
        if not slow.size:
            return slow
        beside = _BESIDE[1][1] * self._nurbs.total[item]
        first, last = (np.searchsorted(self._cusps, s[slow] + way) for way in (-beside, beside))
        return slow[(first < last) | self._rounded(item, u[slow], side)]

    @cached_property
    def _cusps(self) -> Floats:
        """The s, ascending, of the tiny cells of NURBS in which C' vanishes, as far as can be told.

        With |C'| ~ |u − u₀| or a higher power of it, |C'| at an end of such a cell times its width in u is at least twice its
        length; where C' is small and does not vanish, it is about the length.
        """
        found = self._nurbs
        flagged = np.cumsum(found.begins & arc_length.CUSP != 0)
        item = np.repeat(np.arange(len(found.total)), np.diff(found.offset))
        # Flags begin and end rows of tiny cells by turns, anew in each curve.
        before = np.concatenate([[0], flagged])[found.offset[:-1]]
        tiny = np.flatnonzero((flagged - before[item]) % 2 == 1)
        start, s, length, width = found.cells[tiny, :4].T
        item = item[tiny]
        # Start and width may add up to the float beyond a knot.
        end = np.minimum(np.append(found.cells[1:, 0], np.inf)[tiny], start + width)
        end = np.where(tiny + 1 == found.offset[item + 1], start + width, end)
        speed = [
            _metric_norm(
                splines.evaluate(found.table, item, u, 1, side)[1], found.low[item], found.high[item]
            )
            for u, side in ((start, 1), (end, -1))
        ]
        vanishes = np.maximum(*speed) * width >= _VANISHING_RATIO * length
        return self.row_s[self._nurbs_rows[item]][vanishes] + s[vanishes]

    def _rounded(self, item: Ints, u: Floats, side: int) -> NDArray[np.bool_]:
        """Tell at which parameters of NURBS d²x/ds² or d³x/ds³ is rounding rather than a bend.

        The k-th derivative by u is known to a part of L (p/w)^k, L the length of the curve, p its degree and w the width
        of the span, and that by s to the same divided by |C'|^k. A bend of radius R has 1/R and 1/R² of them.
        """
        table = self._nurbs.table
        values = splines.evaluate(table, item, u, 3, side)
        low, high = self._nurbs.low[item], self._nurbs.high[item]
        speed = _metric_norm(values[1], low, high)
        path_derivatives.by_length(low, high, values)
        p = table.degree[item]
        knot = splines.spans(table, item, u, side) - table.point_offset[item] + table.knot_offset[item] + p
        width, total = table.knots[knot + 1] - table.knots[knot], self._nurbs.total[item]
        second, third = (np.abs(values[order]).max(axis=1) for order in (2, 3))
        bend = np.maximum(second, np.sqrt(third))
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            by_s = p / (width * speed)
            return ~(
                _DERIVATIVE_ROUNDING * total * by_s**2 * np.maximum(1.0, by_s / bend) <= _ROUNDING_PART * bend
            )

    def _beside_singular(self, out: Floats, pick: Ints, rows: Ints, u: Floats, side: int) -> None:
        """Replace derivatives by s where C' vanishes by those a little beside, or within where the curve ends.

        Spans on straight lines have theirs: the way of the line, forth or back.
        """
        order, item = len(out) - 1, self._item[rows[pick]]
        total = self._nurbs.total[item]
        at = self._nurbs.at(item, u[pick])
        for first_order, part in _BESIDE[:order]:
            step = side * part * total
            beside = np.where((at + step < 0.0) | (at + step > total), at - step, at + step)
            there = self._nurbs.parameter(item, beside)
            values = splines.evaluate(self._nurbs.table, item, there, order, side)
            path_derivatives.by_length(self._low[rows[pick]], self._high[rows[pick]], values)
            out[first_order:, pick] = values[first_order:]
        along = self._along[splines.spans(self._nurbs.table, item, there, side)]
        straight = np.any(along != 0.0, axis=1)
        forth = np.sign(np.sum(out[1, pick] * along, axis=1))
        out[1, pick] = np.where(straight[:, None], forth[:, None] * along, out[1, pick])
        out[2:, pick] = np.where(straight[:, None], 0.0, out[2:, pick])

    def curvature(self, s: ArrayLike, side: int = 1) -> Floats:
        """Return the curvature in X Y Z (1/mm) at each s, shape (n,)."""
        _, x1, x2 = self.evaluate(s, 2, side)
        return curvature_of(x1[:, :3], x2[:, :3])

    def curvature_after(self, rows: Ints, distance: Floats) -> Floats:
        """Return the curvature in X Y Z (1/mm) of rows at distances from their starts, shape (n,)."""
        _, x1, x2 = self.evaluate_parameter(rows, self.parameter_after(rows, distance), 2)
        return curvature_of(x1[:, :3], x2[:, :3])

    @cached_property
    def _breakpoints(self) -> Floats:
        return self._borders(arc_length.KNOT | arc_length.CUSP)

    def _borders(self, begins: int) -> Floats:
        """Return, ascending, the s of the ends of rows and of what begins with cells of NURBS rows, see `Lengths`."""
        there = np.flatnonzero(self._nurbs.begins & begins)
        item = np.searchsorted(self._nurbs.offset, there, side="right") - 1
        inner = self.row_s[self._nurbs_rows[item]] + self._nurbs.cells[there, 1]
        # Places that differ by rounding are one place; the ends of rows are kept as they are, else one would hide the next.
        alike = _SAME_PLACE * self._snap
        after = np.searchsorted(self.row_s, inner)
        inner = inner[
            (inner - self.row_s[after - 1] > alike)
            & (self.row_s[np.minimum(after, len(self))] - inner > alike)
        ]
        found = np.unique(np.concatenate([self.row_s, inner]))
        return found[np.concatenate([[True], np.diff(found) > alike])]

    def breakpoints(self) -> Floats:
        """Return, ascending, the s of the ends of rows, of NURBS knots and of cusps: where derivatives may jump."""
        return self._breakpoints

    def sample_borders(self) -> Floats:
        """Return, ascending, the s of the breakpoints and of the panels of NURBS rows.

        Panels are short where a curve changes fast (docs/arc-length.md). A larger or smaller copy of a curve has the same.
        """
        return self._borders(arc_length.PANEL | arc_length.KNOT | arc_length.CUSP)

    def turning_points(self) -> Floats:
        """Return, ascending, the s within arcs at which the turn leaves one of X Y Z standing: there it begins to go back."""
        if not len(self._arc_rows):
            return np.zeros(0)
        item, angle = self._arcs.turning_points()
        return np.sort(self.row_s[self._arc_rows[item]] + self._arcs.length_to(item, angle))

    def panels(self, rows: Ints) -> tuple[Ints, Floats, Floats]:
        """Return the panels of NURBS rows: which of `rows` each belongs to, its distance from their start, its length.

        A panel is a stretch of a knot span that a polynomial of low degree carries, see `sample_borders`.
        """
        item = self._item[rows]
        first = self._nurbs.offset[item]
        count = self._nurbs.offset[item + 1] - first
        of, index = ranges(first, count)
        there = self._nurbs.begins[index] & arc_length.PANEL != 0
        of = of[there]
        begin = self._nurbs.cells[index[there], 1]
        end = np.append(begin[1:], 0.0)
        last = np.diff(of, append=len(rows)) > 0
        end[last] = self._nurbs.total[item[of[last]]]
        return of, begin, end - begin

    def jumps(self) -> Jumps:
        """Return the changes at the breakpoints inside the path."""
        s = self._breakpoints[1:-1]
        if not len(s):
            nothing = np.zeros((0, len(self.axes)))
            rows = np.zeros(0, np.int64)
            return Jumps(s, rows, rows, nothing, nothing, nothing)
        left, right = self.evaluate(s, 3, -1), self.evaluate(s, 3, 1)
        _, tangent, second, third = right - left
        return Jumps(s, self.row_of(s, -1), self.row_of(s, 1), tangent, second, third)


def curvature_of(first: Floats, second: Floats) -> Floats:
    """Return κ = |C' × C''| / |C'|³ (M. P. do Carmo (1976), section 1-5, exercise 12), shape (n,), 1/mm; 0 where C' is 0.

    Args:
        first, second: C' and C'' by any parameter, shape (n, 3).
    """
    speed = np.linalg.norm(first, axis=1)
    area = np.linalg.norm(np.cross(first, second), axis=1)
    return np.divide(area, elementary.power(speed, 3.0), out=np.zeros_like(area), where=speed > 0)


def _metric_norm(vectors: Floats, low: Ints, high: Ints) -> Floats:
    return np.sqrt(_metric_dot(vectors, vectors, low, high))


def _metric_dot(a: Floats, b: Floats, low: Ints, high: Ints) -> Floats:
    """Scalar product over columns low … high of each row."""
    if low.size and low.min() == low.max() and high.min() == high.max():
        span = slice(int(low[0]), int(high[0]))
        return np.einsum("ij,ij->i", a[:, span], b[:, span])
    column = np.arange(a.shape[1])
    return total(np.where((column >= low[:, None]) & (column < high[:, None]), a * b, 0.0))


def _halting(nurbs: NurbsTable, low: Ints, high: Ints, chosen: Ints) -> NDArray[np.bool_]:
    """Tell which of the chosen curves have a span whose control points coincide in columns low … high and move else."""
    first, last = np.zeros(len(nurbs), np.int64), np.full(len(nurbs), nurbs.control_points.shape[1])
    first[chosen], last[chosen] = low, high
    sizes = np.diff(nurbs.point_offset)
    curve = np.repeat(np.arange(len(nurbs)), sizes)[1:]
    moves = np.abs(np.diff(nurbs.control_points, axis=0)) > STANDSTILL
    column = np.arange(moves.shape[1])
    within = (column >= first[curve, None]) & (column < last[curve, None])
    # Step n leads to point n + 1; one that leads from curve to curve does not count as a halt.
    halt = ~np.any(moves & within, axis=1) & (np.arange(1, len(curve) + 1) != nurbs.point_offset[curve])
    halts = np.concatenate([[0], np.cumsum(halt)])
    moved = np.concatenate([[0], np.cumsum(moves.any(axis=1))])
    # The span that ends with point n + 1 has the p steps up to n.
    p = nurbs.degree[curve]
    local = np.arange(1, len(curve) + 1) - nurbs.point_offset[curve]
    end = np.flatnonzero(local >= p)
    start, stop = end + 1 - p[end], end + 1
    knot = nurbs.knot_offset[curve[end]] + local[end]
    bad = (halts[stop] - halts[start] == p[end]) & (moved[stop] > moved[start])
    bad &= nurbs.knots[knot] < nurbs.knots[knot + 1]
    out = np.zeros(len(nurbs), bool)
    out[curve[end[bad]]] = True
    return out[chosen]
