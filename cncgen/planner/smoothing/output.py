"""Rows of the toolpath that splines become: cut where the source row changes, so that feed and line stay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import nurbs
from cncgen.geometry.corridor import Spline
from cncgen.geometry.tables import NurbsTable, empty_arcs, ranges
from cncgen.kernels.smoothing import DEGREE
from cncgen.toolpath.record import FeedMode, Kind, Toolpath

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: The mean feed over a span that differs by less than this part from the row's own equals it except for rounding.
_SAME = 1e-6
#: Where in a span the row that it belongs to is looked up: after its middle by more than rounding, for spans are laid with their middles
#: at joints.
_MIDDLE = 0.5 + 1e-6
#: A chord between setpoints on a row of the result may reach over this many knot spans before and after it.
_AROUND = 2


@dataclass(frozen=True, slots=True)
class FittedRun:
    """A spline that stands for p rows, parts of k lines and curves.

    Attributes:
        spline: Its columns are scaled, its parameter is t.
        rows: Shape (p,), ascending: which rows of the toolpath these are.
        row_t: Shape (p + 1,): t at their ends.
        of: Shape (p,), ascending: which line or curve each row is part of.
        room: Shape (k,), mm: tolerance that the spline leaves on each of these.
    """

    spline: Spline
    rows: Ints
    row_t: Floats
    of: Ints
    room: Floats


@dataclass(frozen=True, slots=True)
class _RunRows:
    """The rows of runs one after the other. As each run has one end more than rows, those of run r begin r places later.

    Attributes:
        t: Shape (rows + runs,): t at the ends of rows.
        first: Shape (runs + 1,): the first row of each run, and the number of all.
        lift: Shape (runs,): by what to raise t of each run, so that it ascends over all of them.
        raised: Shape (rows + runs,): t so raised.
    """

    t: Floats
    first: Ints
    lift: Floats
    raised: Floats

    @classmethod
    def of(cls, runs: Sequence[FittedRun]) -> _RunRows:
        """Lay the rows of runs one after the other."""
        count = np.array([len(run.rows) for run in runs])
        low = np.array([min(run.row_t[0], run.spline.knots[4]) for run in runs])
        high = np.array([max(run.row_t[-1], run.spline.knots[-5]) for run in runs])
        lift = np.cumsum(high - low) - high
        t = np.concatenate([run.row_t for run in runs])
        return cls(t, _offsets(count), lift, t + np.repeat(lift, count + 1))

    def lengths(self) -> Floats:
        """Return how much t grows on each row, shape (rows,)."""
        return np.delete(np.diff(self.t), self.first[1:-1] + np.arange(len(self.first) - 2))

    def holding(self, place: Floats, run: Ints, side: Literal["left", "right"] = "right") -> Ints:
        """Return the rows that places of runs lie in, shape (n,); an end belongs to the row before it (`left`) or after it (`right`)."""
        at = np.searchsorted(self.raised, place + self.lift[run], side=side) - 1 - run
        out: Ints = np.clip(at, self.first[run], self.first[run + 1] - 1)
        return out

    def between(self, begin: Floats, end: Floats, run: Ints) -> tuple[Ints, Ints]:
        """Return of which stretch of a run each row is that stretches cover, and these rows: at least one each."""
        first = self.holding(begin, run)
        return ranges(first, np.maximum(self.holding(end, run, "left") + 1 - first, 1))

    def least(self, begin: Floats, end: Floats, run: Ints, value: Floats) -> Floats:
        """Return the least that rows have on stretches of runs, shape (n,), of a value a row."""
        of, row = self.between(begin, end, run)
        out: Floats = np.minimum.reduceat(value[row], np.searchsorted(of, np.arange(len(begin))))
        return out

    def taken(self, begin: Floats, end: Floats, run: Ints, pace: Floats) -> Floats:
        """Return how long stretches of runs take, shape (n,), where `pace` is the time that each row takes a mm."""
        of, row = self.between(begin, end, run)
        at = row + run[of]
        ways = np.minimum(end[of], self.t[at + 1]) - np.maximum(begin[of], self.t[at])
        out: Floats = np.add.reduceat(ways * pace[row], np.searchsorted(of, np.arange(len(begin))))
        return out


def rows_of(runs: Sequence[FittedRun], source: Toolpath, axes_scale: Floats) -> tuple[Toolpath, Ints]:
    """Return the rows of splines (docs/smoothing.md, Rows of the result), and which row of the source each comes from.

    Parts of one straight line have the values of the whole line.

    Args:
        runs: At least one, fitted to rows of the source.
        source: The rows as they are programmed.
        axes_scale: Shape (axes,): factors by which the columns of the splines were multiplied.
    """
    laid = _RunRows.of(runs)
    knots, at = (
        np.concatenate([each.spline.knots[cut] for each in runs]) for cut in (slice(None), slice(4, -4))
    )
    points = np.concatenate([each.spline.points for each in runs]) / axes_scale
    spans = _offsets(np.array([each.spline.spans for each in runs]))
    run = np.repeat(np.arange(len(runs)), np.diff(spans))
    span = np.arange(len(run)) + run
    owner = laid.holding(at[span] + _MIDDLE * (at[span + 1] - at[span]), run)
    first = np.flatnonzero(np.diff(owner, prepend=-1))
    stop = np.append(first[1:], len(owner))
    owner, run = owner[first], run[first]
    table = _pieces(knots, points, first, stop, run)
    moving = np.concatenate([each.rows for each in runs])
    rows = moving[owner]
    inverse = source.feed_mode[moving] == FeedMode.INVERSE_TIME
    feed = np.where(inverse, source.feed[moving] * laid.lengths(), source.feed[moving])
    begin, end = at[first + run], at[stop + run]
    mean = (end - begin) / laid.taken(begin, end, run, 1.0 / feed)
    columns = source.columns(rows) | {
        "kind": np.full(len(rows), Kind.NURBS, np.int8),
        "end": nurbs.evaluate(table, np.arange(len(first)), nurbs.parameter_range(table)[1], 0, side=-1)[0],
        # Knots at changes of feed lie at the ends of rows, except for rounding.
        "feed": np.where(np.abs(mean - feed[owner]) <= _SAME * feed[owner], feed[owner], mean),
        "feed_mode": np.where(inverse[owner], FeedMode.SPEED, source.feed_mode[rows]).astype(np.int8),
        "curve": np.arange(len(rows)),
        "chord_room": _room(runs, laid, at, spans, owner, first, stop),
    }
    start = points[0] if knots[0] == knots[4] else _start(table)
    return replace(source, start=start, arcs=empty_arcs(), nurbs=table, events=(), **columns), rows


def _room(
    runs: Sequence[FittedRun], laid: _RunRows, at: Floats, spans: Ints, owner: Ints, first: Ints, stop: Ints
) -> Floats:
    """Return the least tolerance that is left on the line or curve of each row, and around, shape (n,), mm.

    Args:
        runs, laid: The runs.
        at, spans: Shape (spans + runs,), t at the ends of spans; shape (runs + 1,), where the spans of each run begin.
        owner, first, stop: Shape (n,): the row that each comes from, and its spans.
    """
    line = _offsets(np.array([len(run.room) for run in runs]))
    whole = np.concatenate([run.of + line[n] for n, run in enumerate(runs)])[owner]
    begin = first[np.searchsorted(whole, whole)] - _AROUND
    end = stop[np.searchsorted(whole, whole, side="right") - 1] + _AROUND
    which = np.searchsorted(spans, first, side="right") - 1
    room = np.concatenate([run.room[run.of] for run in runs])
    begin, end = np.maximum(begin, spans[which]), np.minimum(end, spans[which + 1])
    return laid.least(at[begin + which], at[end + which], which, room)


def _offsets(count: Ints) -> Ints:
    """Return where each of so many things begins in a row of them, and where the last one ends."""
    return np.concatenate([[0], np.cumsum(count)])


def _start(table: NurbsTable) -> Floats:
    return nurbs.evaluate(table, 0, nurbs.parameter_range(table)[0][:1], 0)[0, 0]


def _pieces(knots: Floats, points: Floats, first: Ints, stop: Ints, run: Ints) -> NurbsTable:
    """Return the curves of spans ``first[n] … stop[n]`` of runs: slices of knots and control points, nothing to compute."""
    spans = stop - first

    def gather(extra: int) -> tuple[Ints, Ints]:
        return ranges(first + extra * run, spans + extra)[1], _offsets(spans + extra)

    which, point_offset = gather(DEGREE)
    at, knot_offset = gather(2 * DEGREE + 1)
    return NurbsTable(
        np.full(len(spans), DEGREE, np.int64),
        point_offset,
        knot_offset,
        np.ascontiguousarray(points[which]),
        np.ones(len(which)),
        knots[at],
    )
