"""The stream: rows come in chunk by chunk, runs are fitted window by window, and all other rows pass unchanged."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, NoPlanError
from cncgen.geometry.corridor import (
    END_DERIVATIVES,
    END_POINT,
    END_TANGENT,
    OVERLAP,
    CorridorError,
    Seam,
    Spline,
    fit,
    split,
)
from cncgen.geometry.path import LINE, Path
from cncgen.geometry.pieces import ARC_SHARE, Pieces, RowPieces, pieces_of
from cncgen.machine.record import Machine
from cncgen.planner.limits.axis_limits import axis_scale
from cncgen.planner.limits.speeds import Feeds
from cncgen.planner.smoothing.ends import opened
from cncgen.planner.smoothing.output import FittedRun, rows_of
from cncgen.planner.smoothing.runs import TANGENT, Classes, classify
from cncgen.planner.smoothing.stretches import SAME, Stretches
from cncgen.planner.smoothing.tolerance_split import Chords, chord_room
from cncgen.toolpath.record import Kind, PathMode, Toolpath
from cncgen.toolpath.slicing import between, chosen, join

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Rows that are fitted at a time, and the parts, as they are programmed, that a row of them has at most on average.
WINDOW, _PARTS = 2048, 8
#: Rows that are looked at first, and that are fitted first; then twice as many each time, up to `WINDOW`: the first setpoints wait for
#: few rows.
_FIRST, _FIRST_FITTED = 128, 256
#: Rows after which a run is ended where it stands, if they made too few knots to go on from.
_LONGEST_WINDOW = 32 * WINDOW


def smooth(chunks: Iterable[Toolpath], machine: Machine | None = None) -> Iterator[Toolpath]:
    """Smooth a toolpath.

    Runs of LINE and ARC rows under G64, and the ends of NURBS rows that meet their neighbours in corners, become NURBS
    rows of degree 4 that stay within the tolerance of their rows: the distance over all axes, one degree counted as one
    millimetre (`axis_scale`), is at most P. G61, G61.1, the rest of NURBS rows, rows that are not
    measured by X Y Z, corners of more than 166°, and places where rapids and feeds meet or the axes rest are met exactly; so is the path
    where its tolerance is 0 or not known.

    Args:
        chunks: Consecutive stretches of one program, tolerances filled in.
        machine: Its chords between setpoints have a part of the tolerance, half of P at most, and tolerances that its setpoints
            cannot show are 0 (`tolerance_split`). Without one, setpoints are not planned for.

    Yields:
        Consecutive stretches of the smoothed program, none empty; `Toolpath.chord_room` is what smoothing leaves of
        the tolerance.

    Raises:
        NoPlanError: If a run could not be fitted (a fault of the method, not of the program; see docs/smoothing.md).
    """
    smoother = _Smoother(machine)
    gathered: list[tuple[Toolpath, Bools]] = []
    count, size = 0, _FIRST
    for chunk, free in opened(each for each in chunks if len(each)):
        first = 0
        while first < len(chunk):
            stop = min(first + size - count, len(chunk))
            gathered.append((between(chunk, first, stop), free[first:stop]))
            count, first = count + stop - first, stop
            if count == size:
                yield from smoother.take(gathered, last=False)
                gathered, count, size = [], 0, min(2 * size, WINDOW)
    yield from smoother.take(gathered, last=True)


class _Smoother:
    """The rows that are not yet handed on.

    Attributes:
        machine: See `smooth`.
        pending: Rows that wait: the rest of a run that is being fitted, or of one whose end has not been seen.
        seam: Where the curve of the run at the front goes on from, or None at its start.
        before: dx/ds at the end of the last motion handed on exactly, scaled; None after a rest and at the start.
        window: Rows that are fitted at a time, if a run has as many.
        chords: Those of the machine, once the axes are known.
    """

    def __init__(self, machine: Machine | None) -> None:
        self.machine = machine
        self.pending: tuple[Toolpath, Bools] | None = None
        self.seam: Seam | None = None
        self.before: Floats | None = None
        self.window = _FIRST_FITTED
        self.chords = Chords()

    def take(self, chunks: list[tuple[Toolpath, Bools]], last: bool) -> Iterator[Toolpath]:
        """Add rows, of which some NURBS may be smoothed, and yield what has become final, as one toolpath."""
        parts = ([self.pending] if self.pending is not None else []) + chunks
        if not parts:
            return
        here, free = join([part for part, _ in parts]), np.concatenate([each for _, each in parts])
        stretches = Stretches.of(here)
        if not last:
            # How far the last row goes on is not known yet.
            stretches = stretches.but_last()
        if self.machine is not None:
            self.chords = Chords.of(self.machine, here.axes)
        looked = _Looked.of(stretches, free[stretches.first[:-1]], self.chords, self.seam is not None)
        count = len(stretches.rows)
        borders = np.append(np.flatnonzero(looked.classes.parts), count)
        done = _Done(stretches, self.chords.most_mm)
        at = 0
        for n, first in enumerate(borders[:-1]):
            stop, closed = int(borders[n + 1]), bool(last or borders[n + 1] < count)
            at = self._group(looked, int(first), stop, closed, done)
            if at < stop:
                break
        rest = int(stretches.first[at])
        self.pending = (between(here, rest, len(here)), free[rest:]) if rest < len(here) else None
        handed = done.toolpath()
        if handed is not None:
            yield handed

    def _group(self, looked: _Looked, first: int, stop: int, closed: bool, done: _Done) -> int:
        """Hand on the final part of the rows first … stop, which are one run or not a run; return the begin of the rest."""
        stretches, classes = looked.stretches, looked.classes
        moving = first + np.flatnonzero(classes.fits[first:stop])
        if self.seam is None and len(moving) < 2:
            if moving.size and not closed:
                return first
            self._pass(stretches.rows, classes, first, stop, done)
            return stop
        if self.seam is None and moving[0] > first:
            self._pass(stretches.rows, classes, first, int(moving[0]), done)
        first = int(moving[0])
        size = self.window
        while True:
            most = min(_PARTS * size, _LONGEST_WINDOW)
            window = moving[: min(size, stretches.within(moving, most))]
            final = closed and len(window) == len(moving)
            if not closed and len(window) == len(moving):
                return first
            longest = size >= _LONGEST_WINDOW or (most == _LONGEST_WINDOW and len(window) < size)
            rest = self._fit(looked, window, final or longest, done)
            if rest is None:
                size *= 2
                continue
            self.window = size = min(2 * self.window, WINDOW)
            if final or rest > moving[-1]:
                break
            moving = moving[np.searchsorted(moving, rest) :]
            first = rest
        tail = int(moving[-1]) + 1
        if tail < stop:
            self._pass(stretches.rows, classes, tail, stop, done)
        return stop

    def _pass(self, rows: Toolpath, classes: Classes, first: int, stop: int, done: _Done) -> None:
        """Hand on rows as they are."""
        done.rows_as_they_are(first, stop)
        for k in range(stop - 1, first - 1, -1):
            if not classes.idle[k]:
                self.before = None if rows.kind[k] == Kind.EVENT else classes.leave[k]
                break

    def _fit(self, looked: _Looked, window: Ints, final: bool, done: _Done) -> int | None:
        """Fit a window of the run at the front; return the row from which to go on, None if it needs more rows."""
        stretches, classes, rows = looked.stretches, looked.classes, looked.stretches.rows
        first = int(np.searchsorted(looked.fitted, window[0]))
        among = slice(first, first + len(window))
        given, pieces = looked.given[among], looked.pieces.joined(among.start, among.stop)
        row_t = pieces.row_t
        head = _end(self.before, classes.entry[window[0]])
        tail = 0
        if final:
            after = _next_entry(classes, rows, int(window[-1]) + 1)
            tail = _end(after, classes.leave[window[-1]])
        try:
            spline = fit(pieces, _cuts(rows, window, row_t), head, tail, self.seam)
        except CorridorError as fault:
            raise _no_curve(rows, window, fault) from fault
        off = _deviation(pieces, spline, given) + stretches.off[window]
        room = chord_room(rows.tolerance[window], off, self.chords.most_mm)
        if final:
            upto, rest, self.seam = int(window[-1]) + 1, int(window[-1]) + 1, None
            self.before = classes.leave[window[-1]]
        else:
            if spline.spans < 3 * OVERLAP:
                return None
            span = spline.spans - OVERLAP
            at = spline.knots[4 + span]
            k = min(int(np.searchsorted(row_t, at, side="right")) - 1, len(window) - 1)
            rest = upto = int(window[k])
            spline, self.seam = split(spline, span, float(row_t[k]))
        part, part_t, of = stretches.parts_of(window, row_t)
        done.add(FittedRun(spline, part, part_t, of, room), slice(part[0], stretches.first[upto]))
        return rest


@dataclass(frozen=True, slots=True)
class _Looked:
    """Rows that are looked at together, m of them; k are fitted.

    Attributes:
        stretches, classes: The rows, and how each is treated.
        fitted: Shape (k,): those that are fitted with others.
        given: Shape (k,), mm: by how much a curve may leave each.
        pieces: Of these.
    """

    stretches: Stretches
    classes: Classes
    fitted: Ints
    given: Floats
    pieces: RowPieces

    @classmethod
    def of(cls, stretches: Stretches, free: Bools, chords: Chords, goes_on: bool) -> _Looked:
        """Look at rows, of which some NURBS are `free` to be smoothed; whether the first run of them goes on from a seam."""
        rows, path, scale = (
            stretches.rows,
            stretches.rows.path,
            axis_scale(stretches.rows.axes, stretches.rows.degree_mm),
        )
        classes = classify(rows, path, scale, free, chords)
        run = np.cumsum(classes.parts) - 1
        several = np.bincount(run, classes.fits) > 1
        several[:1] |= goes_on
        fitted = np.flatnonzero(classes.fits & several[run])
        given = (
            chords.fit_tolerance(rows.tolerance[fitted], *_pace(rows, path, fitted)) - stretches.off[fitted]
        )
        return cls(stretches, classes, fitted, given, pieces_of(path, given, scale, fitted))


class _Done:
    """The rows to hand on, as they are or in place of others."""

    def __init__(self, stretches: Stretches, chord_mm: float) -> None:
        self._stretches = stretches
        self._chord_mm = chord_mm
        self._exact, self._inside = np.zeros((2, len(stretches.parts)), bool)
        self._runs: list[FittedRun] = []

    def rows_as_they_are(self, first: int, stop: int) -> None:
        """Take the rows first … stop of the input."""
        begin = self._stretches.first
        self._exact[begin[first] : begin[stop]] = True

    def add(self, run: FittedRun, events: slice) -> None:
        """Take a curve for rows, and the events among some of the parts of the input."""
        self._runs.append(run)
        self._inside[events] = self._stretches.parts.kind[events] == Kind.EVENT

    def toolpath(self) -> Toolpath | None:
        """Return all of them in their order; None for none."""
        parts = self._stretches.parts
        rows = np.flatnonzero(self._exact | self._inside)
        passed = chosen(parts, rows, parts.start)
        off = np.where(self._exact, self._stretches.part_off(), 0.0)[rows]
        # Chords need not share the tolerance with smoothing there, but with arcs that are equal except for rounding.
        met = self._exact[rows] & (passed.path_mode == PathMode.CONTINUOUS) & (off == 0.0)
        passed = replace(
            passed,
            path_mode=np.where(met, PathMode.EXACT_PATH, passed.path_mode).astype(np.int8),
            chord_room=np.where(
                off > 0.0, chord_room(passed.tolerance, off, self._chord_mm), passed.tolerance
            ),
        )
        if not self._runs:
            return passed if len(rows) else None
        made, of = rows_of(self._runs, parts, axis_scale(parts.axes, parts.degree_mm))
        both, source = join([made, passed]), np.concatenate([of, rows])
        order = np.argsort(source, kind="stable")
        out = chosen(both, order, parts.starts[rows[0]] if source[order[0]] != of[0] else made.start)
        # Where an event happens within a run, the curve is not where the program was.
        moved = np.maximum.accumulate(np.where(self._inside[source[order]], 0, np.arange(len(order))))
        return replace(out, end=out.end[moved])


def _pace(rows: Toolpath, path: Path, at: Ints) -> tuple[Floats, Floats]:
    """Return the curvature of rows in their middles, and their feeds, shape (n,) each, 1/mm and mm/s."""
    bend, curves = np.zeros(len(at)), np.flatnonzero(path.kind[at] != LINE)
    bend[curves] = path.curvature_after(at[curves], 0.5 * path.row_length[at[curves]])
    return bend, Feeds.of(rows).speed[at]


def _deviation(pieces: Pieces, spline: Spline, given: Floats) -> Floats:
    """Return a bound of the distance of the spline from each row, shape (rows,), mm."""
    out: Floats = np.maximum.reduceat(spline.deviation, np.flatnonzero(np.diff(pieces.row, prepend=-1)))
    return out + ARC_SHARE * given


def _cuts(rows: Toolpath, window: Ints, row_t: Floats) -> Floats:
    """Where the spline must have a knot: at changes of feed, and where rows of another kind stand between."""
    a, b = window[:-1], window[1:]
    one, two = rows.feed[a], rows.feed[b]
    # Speeds computed from a time are equal except for rounding.
    feed = (np.abs(one - two) > SAME * np.maximum(one, two)) | (rows.feed_mode[a] != rows.feed_mode[b])
    return row_t[1:-1][feed | (b > a + 1)]


def _end(beside: Floats | None, own: Floats) -> int:
    """Return what a curve has in common with its row where that meets a neighbour.

    Args:
        beside, own: The directions of both there, shape (axes,); None where the axes rest.
    """
    if beside is None:
        return END_POINT
    if np.linalg.norm(beside - own) < TANGENT:
        return END_DERIVATIVES
    # Where the path turns back the acceleration goes on, from one direction to its opposite.
    return END_TANGENT if np.linalg.norm(beside + own) < TANGENT else END_POINT


def _next_entry(classes: Classes, rows: Toolpath, first: int) -> Floats | None:
    """Return dx/ds at the start of the next motion, None where the axes rest before it or nothing comes."""
    for k in range(first, len(rows)):
        if not classes.idle[k]:
            return None if rows.kind[k] == Kind.EVENT else classes.entry[k]
    return None


def _no_curve(rows: Toolpath, window: Ints, fault: CorridorError) -> NoPlanError:
    """Return the error of a run without a smooth curve, with its lines."""
    first, last = int(rows.line[window[0]]), int(rows.line[window[-1]])
    return NoPlanError(
        Diagnostic(
            "smoothing",
            f"lines {first} to {last}: {fault}",
            span=rows.span(window[0]),
            hint="G61 before these lines follows them exactly; please report the program",
        )
    )
