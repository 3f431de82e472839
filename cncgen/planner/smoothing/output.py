"""Rows of the toolpath that a spline becomes: cut where the source row changes, so that feed and line stay."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

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
#: A chord between setpoints on a row of the result may reach over this many knot spans before and after it.
_AROUND = 2


def rows_of(
    spline: Spline,
    row_t: Floats,
    source: Toolpath,
    moving: Ints,
    axes_scale: Floats,
    events: range,
    room: Floats,
    of: Ints,
) -> Toolpath:
    """Return the toolpath of a spline (docs/smoothing.md, Rows of the result); parts of one straight line have the values of the whole line.

    Args:
        spline: Fitted to the rows `moving` of `source`.
        row_t: Shape (rows + 1,): t of the spline at the ends of these rows.
        source, moving: Where the rows come from, and their indices, ascending.
        axes_scale: Shape (axes,): factors by which the columns of the spline were multiplied.
        events: Rows of `source` that may be events to be put in at their place.
        room: Shape (lines,), mm: tolerance that the spline leaves on each straight line or curve.
        of: Shape (rows,), ascending: which of these each row is part of.
    """
    knots, points = spline.knots, spline.points / axes_scale
    middle = 0.5 * (knots[4:-5] + knots[5:-4])
    owner = np.clip(np.searchsorted(row_t, middle, side="right") - 1, 0, len(moving) - 1)
    first = np.flatnonzero(np.diff(owner, prepend=-1))
    stop = np.append(first[1:], len(owner))
    table = _pieces(knots, points, first, stop)
    ends = nurbs.evaluate(table, np.arange(len(first)), nurbs.parameter_range(table)[1], 0, side=-1)[0]
    rows = moving[owner[first]]
    inverse = source.feed_mode[moving] == FeedMode.INVERSE_TIME
    feed = np.where(inverse, source.feed[moving] * np.diff(row_t), source.feed[moving])
    at = knots[4:-4]
    whole = of[owner[first]]
    begin, end = first[np.searchsorted(whole, whole)], stop[np.searchsorted(whole, whole, side="right") - 1]
    columns = source.columns(rows) | {
        "kind": np.full(len(rows), Kind.NURBS, np.int8),
        "end": ends,
        "feed": _mean(feed, row_t, owner[first], at[first], at[stop]),
        "feed_mode": np.where(inverse[owner[first]], FeedMode.SPEED, source.feed_mode[rows]).astype(np.int8),
        "curve": np.arange(len(rows)),
        "chord_room": _least(
            room[of], row_t, at[np.maximum(begin - _AROUND, 0)], at[np.minimum(end + _AROUND, len(at) - 1)]
        ),
    }
    start = points[0] if knots[0] == knots[4] else _start(table)
    made = replace(source, start=start, arcs=empty_arcs(), nurbs=table, events=(), **columns)
    inside = events.start + np.flatnonzero(source.kind[events.start : events.stop] == Kind.EVENT)
    return _with_events(made, rows, source, inside) if inside.size else made


def _least(room: Floats, row_t: Floats, begin: Floats, end: Floats) -> Floats:
    """Return the least that is left on the rows between places."""
    first = np.clip(np.searchsorted(row_t, begin, side="right") - 1, 0, len(room) - 1)
    last = np.clip(np.searchsorted(row_t, end, side="left"), first + 1, len(room))
    padded = np.append(room, np.inf)
    out: Floats = np.minimum.reduceat(padded, np.stack([first, last], axis=1).ravel())[::2]
    return out


def _mean(feed: Floats, row_t: Floats, owner: Ints, begin: Floats, end: Floats) -> Floats:
    """Return the feed that takes as long from `begin` to `end` as those of the rows between; the owner's where all agree."""
    time = np.concatenate([[0.0], np.cumsum(np.diff(row_t) / feed)])
    mean = (end - begin) / (np.interp(end, row_t, time) - np.interp(begin, row_t, time))
    own = feed[owner]
    # Knots at changes of feed lie at the ends of rows, except for rounding.
    return np.where(np.abs(mean - own) <= _SAME * own, own, mean)


def _start(table: NurbsTable) -> Floats:
    return nurbs.evaluate(table, 0, nurbs.parameter_range(table)[0][:1], 0)[0, 0]


def _pieces(knots: Floats, points: Floats, first: Ints, stop: Ints) -> NurbsTable:
    """Return the curves of spans ``first[n] … stop[n]``: slices of knots and control points, nothing to compute."""
    spans = stop - first

    def gather(extra: int) -> tuple[Ints, Ints]:
        offset = np.concatenate([[0], np.cumsum(spans + extra)]).astype(np.int64)
        return ranges(first, spans + extra)[1], offset

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


def _with_events(made: Toolpath, rows: Ints, source: Toolpath, inside: Ints) -> Toolpath:
    """Put event rows of the source in before the first row that came from a later one."""
    place = np.searchsorted(rows, inside)
    order = np.argsort(np.concatenate([np.arange(len(rows)) + 0.5, place]), kind="stable")
    where = np.concatenate([made.start[None, :], made.end])[place]

    theirs = source.columns(inside) | {"end": where, "curve": np.arange(len(inside))}
    theirs["chord_room"] = source.tolerance[inside]
    mine = made.columns(slice(None))
    both: dict[str, Any] = {name: np.concatenate([mine[name], theirs[name]])[order] for name in mine}
    return replace(made, events=tuple(source.events[k] for k in source.curve[inside]), **both)
