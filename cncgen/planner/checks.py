"""Checks of a program before it is planned: that the machine has its axes and reaches every place of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import CncgenError, Diagnostic, Diagnostics, NoPlanError, ProgramError, Span
from cncgen.geometry.arcs import spirals
from cncgen.geometry.extents import arc_extents, hulls, nurbs_extents
from cncgen.geometry.tables import ArcTable
from cncgen.machine.record import Machine
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import MOST_ROWS
from cncgen.toolpath.gate import beyond_numbers
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath
from cncgen.units import file_unit, to_file

Floats = NDArray[np.float64]

#: A place is beyond the travel by more than this, mm or rad: the ninth decimal of a setpoint.
_ROUNDING = 1e-9


def checked(chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions) -> Iterator[Toolpath]:
    """Yield the chunks with their tolerances filled in (the option's, the program's, else the machine's).

    Those without a row are left out. If no others follow, a motion of zero length replaces them, so that a program without motion has
    a plan, the rest at its start. After a fault no more are yielded: the rest is read only to find the other faults.

    Raises:
        ProgramError: A chunk holds a number beyond the range of planning, or moves an axis that the machine lacks.
        NoPlanError: A chunk leaves the travel of an axis, at the end of a motion or along a curve. Either names all
            such faults of the program.
    """
    started = False
    empty: Toolpath | None = None
    found = Diagnostics()
    error: type[CncgenError] = NoPlanError
    missing: set[str] = set()
    for chunk in chunks:
        if not len(chunk):
            empty = empty or chunk
            continue
        beyond = list(beyond_numbers(chunk))
        unplanned = beyond + _missing_axes(chunk, machine, missing)
        found.extend(unplanned)
        if unplanned:
            error = ProgramError
        if not beyond:
            if not started:
                _start_beyond_travel(chunk, machine, found)
            _beyond_travel(chunk, machine, found)
            _endless(chunk, machine, found)
        started = True
        if not found.has_errors:
            yield _with_tolerance(chunk, machine, options)
    if found.has_errors:
        raise error(found)
    if empty is not None and not started:
        yield _standing(empty)


def _standing(empty: Toolpath) -> Toolpath:
    """Return one traverse from where a toolpath without rows starts to the same place; it stands on no line (0)."""
    row = np.zeros(1, np.int64)
    flag = row.astype(np.int8)
    none = np.full(1, np.nan)
    return replace(
        empty,
        kind=flag + np.int8(Kind.LINE),
        end=empty.start[None, :].copy(),
        feed=none,
        feed_mode=flag + np.int8(FeedMode.RAPID),
        path_mode=flag + np.int8(PathMode.EXACT_STOP),
        tolerance=none,
        curve=row - 1,
        line=row,
        source=row.astype(np.int16),
    )


def _with_tolerance(chunk: Toolpath, machine: Machine, options: PlanOptions) -> Toolpath:
    if options.path_tolerance_mm is not None:
        tolerance = np.full(len(chunk), options.path_tolerance_mm)
    else:
        tolerance = np.where(np.isnan(chunk.tolerance), machine.path_tolerance_mm, chunk.tolerance)
    continuous = chunk.path_mode == PathMode.CONTINUOUS
    return replace(chunk, tolerance=np.where(continuous, tolerance, chunk.tolerance))


def _missing_axes(chunk: Toolpath, machine: Machine, known: set[str]) -> list[Diagnostic]:
    """Name the axes that move and that the machine lacks, but those `known` already, which become all."""
    found = []
    moves = chunk.end != chunk.starts
    for column, letter in enumerate(chunk.axes):
        rows = np.flatnonzero(moves[:, column])
        if letter not in machine.axes and letter not in known and len(rows):
            known.add(letter)
            found.append(
                Diagnostic(
                    "axis-missing",
                    f"the program moves axis {letter}, which machine {machine.name} does not have",
                    span=_span(chunk, int(rows[0])),
                    hint=f"its axes are {' '.join(machine.axes)}; choose another machine with --machine",
                )
            )
    return found


def _travel(chunk: Toolpath, machine: Machine) -> tuple[Floats, Floats]:
    """Return the ends of the travel of each axis, each of shape (axes,); infinite without ends."""
    axes = [machine.axes.get(letter) for letter in chunk.axes]
    ends = [axis.travel if axis and axis.travel else (-np.inf, np.inf) for axis in axes]
    low, high = np.array(ends).T
    return low - _ROUNDING, high + _ROUNDING


def _start_beyond_travel(chunk: Toolpath, machine: Machine, found: Diagnostics) -> None:
    low, high = _travel(chunk, machine)
    start = chunk.start
    moves = (chunk.end != start).any(axis=0)
    for column in np.flatnonzero(moves & ((start < low) | (start > high))):
        hint = "say where the machine stands in a comment before the first motion: (START, X... Y...)"
        found.add(_beyond(chunk, machine, 0, int(column), float(start[column]), "starts at", hint))


def _beyond_travel(chunk: Toolpath, machine: Machine, found: Diagnostics) -> None:
    """Name the lines whose motions leave the travel: the furthest place of each, on each axis."""
    low, high = _travel(chunk, machine)
    if not np.isfinite([low, high]).any():
        return
    lowest, highest = _reach(chunk, low, high)
    under, over = low - lowest, highest - high
    beyond = np.maximum(under, over)
    outside = np.argwhere((beyond > 0.0) & (chunk.kind != Kind.EVENT)[:, None])
    # A loop runs a line many times.
    furthest: dict[tuple[int, int, int], tuple[int, int]] = {}
    for row, column in outside.tolist():
        key = int(chunk.source[row]), int(chunk.line[row]), column
        if key not in furthest or beyond[row, column] > beyond[furthest[key]]:
            furthest[key] = row, column
    for place in furthest.values():
        position = float(highest[place] if over[place] >= under[place] else lowest[place])
        verb = "is sent to" if position == chunk.end[place] else "reaches"
        found.add(_beyond(chunk, machine, *place, position, verb))


def _reach(chunk: Toolpath, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Return the lowest and highest coordinates of each row, each of shape (n, axes).

    Of lines the end alone (their start is the end before), of NURBS too where their hull stays between low and high.
    """
    lowest, highest = chunk.end.copy(), chunk.end.copy()
    rows = np.flatnonzero(chunk.kind == Kind.ARC)
    if len(rows):
        table, index = chunk.arcs, chunk.curve[rows]
        arcs = ArcTable(table.centre[index], table.normal[index], table.sweep[index])
        lowest[rows], highest[rows] = arc_extents(spirals(arcs, chunk.starts[rows], chunk.end[rows]))
    rows = np.flatnonzero(chunk.kind == Kind.NURBS)
    if len(rows):
        bottom, top = hulls(chunk.nurbs)
        leaves = np.any((bottom < low) | (top > high), axis=1)
        for row in rows[np.take(leaves, chunk.curve[rows])]:
            lowest[row], highest[row] = nurbs_extents(chunk.nurbs, int(chunk.curve[row]))
    return lowest, highest


def _endless(chunk: Toolpath, machine: Machine, found: Diagnostics) -> None:
    """Name the first line, arc or dwell that lasts longer than a stream may, before anything is made of it."""
    length = np.linalg.norm((chunk.end - chunk.starts)[:, :3], axis=1)
    rows = np.flatnonzero(chunk.kind == Kind.ARC)
    if len(rows):
        index, starts = chunk.curve[rows], chunk.starts[rows, :3]
        across = np.cross(starts - chunk.arcs.centre[index], chunk.arcs.normal[index])
        length[rows] = np.abs(chunk.arcs.sweep[index]) * np.linalg.norm(across, axis=1)
    fastest = sum(axis.max_velocity for axis in machine.axes.values())
    with np.errstate(divide="ignore", invalid="ignore"):
        by_feed = np.where(chunk.feed_mode == FeedMode.INVERSE_TIME, 1.0, length) / chunk.feed
    seconds = np.where(chunk.feed_mode == FeedMode.RAPID, length / fastest, by_feed)
    stands = chunk.kind == Kind.EVENT
    seconds[stands] = [chunk.events[index].wait_s for index in chunk.curve[stands]]
    longest = MOST_ROWS * machine.period_s
    # A row without a feed is named by the strategies that need one.
    endless = np.flatnonzero(~(seconds <= longest) & (stands | (chunk.feed != 0.0)))
    if len(endless):
        row = int(endless[0])
        found.add(
            Diagnostic(
                "motion-endless",
                f"{'the dwell' if stands[row] else f'the motion of {length[row]:.4g} mm'} takes {seconds[row]:.4g} s at least, more than {MOST_ROWS:.0e} setpoints "
                f"every {1e3 * machine.period_s:g} ms",
                span=_span(chunk, row),
                hint="look at its feed, its length and, of an arc, its number of turns",
                values={"time_s": float(seconds[row])},
            )
        )


def _beyond(
    chunk: Toolpath, machine: Machine, row: int, column: int, position: float, verb: str, hint: str = ""
) -> Diagnostic:
    letter = chunk.axes[column]
    travel = machine.axes[letter].travel or (-np.inf, np.inf)
    scale, unit = to_file(letter), file_unit(letter)
    low, high = (end * scale for end in travel)
    return Diagnostic(
        "travel-exceeded",
        f"axis {letter} {verb} {position * scale:.4f} {unit}, beyond its travel of {low:g} to {high:g} {unit}",
        span=_span(chunk, row),
        hint=hint,
        values={"axis": letter, "value": position * scale, "low": low, "high": high},
    )


def _span(chunk: Toolpath, row: int) -> Span:
    return Span(chunk.sources[int(chunk.source[row])], int(chunk.line[row]))
