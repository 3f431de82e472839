"""Checks of a program before it is planned: that the machine has its axes and reaches every place of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from cncgen.diagnostics import CncgenError, Diagnostic, Diagnostics, NoPlanError, ProgramError
from cncgen.machine.record import Machine
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import MOST_ROWS
from cncgen.planner.travel import Travel, moved
from cncgen.toolpath.gate import beyond_numbers
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath


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
    travel = Travel(machine)
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
            travel.add(chunk)
            _endless(chunk, machine, found)
        started = True
        if not (found.has_errors or travel.is_left):
            yield _with_tolerance(chunk, machine, options)
    travel.tell(found)
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
    """Fill in the tolerances; of rows whose tip rotary axes carry, the part that the axes may use.

    Axes that are off by e (X Y Z by mm, rotary axes by degrees that count g mm each) move the tip by |e| (1 + (lever pi / (180 g))²)^½ mm at
    most (Cauchy and Schwarz).
    """
    if options.path_tolerance_mm is not None:
        tolerance = np.full(len(chunk), options.path_tolerance_mm)
    else:
        tolerance = np.where(np.isnan(chunk.tolerance), machine.path_tolerance_mm, chunk.tolerance)
    continuous = chunk.path_mode == PathMode.CONTINUOUS
    if chunk.lever is not None:
        tolerance = tolerance / np.hypot(1.0, np.radians(chunk.lever) / machine.degree_mm)
    tolerance = np.where(continuous, tolerance, chunk.tolerance)
    return replace(chunk, tolerance=tolerance, lever=None, degree_mm=machine.degree_mm)


def _missing_axes(chunk: Toolpath, machine: Machine, known: set[str]) -> list[Diagnostic]:
    """Name the axes that move and that the machine lacks, but those `known` already, which become all."""
    found: list[Diagnostic] = []
    lacking = [letter for letter in chunk.axes if letter not in machine.axes and letter not in known]
    if not lacking:
        return found
    moves = moved(chunk)
    for letter in lacking:
        rows = np.flatnonzero(moves[:, chunk.axes.index(letter)])
        if len(rows):
            known.add(letter)
            found.append(
                Diagnostic(
                    "axis-missing",
                    f"the program moves axis {letter}, which machine {machine.name} does not have",
                    span=chunk.span(rows[0]),
                    hint=f"its axes are {' '.join(machine.axes)}; choose another machine with --machine",
                )
            )
    return found


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
                span=chunk.span(row),
                hint="look at its feed, its length and, of an arc, its number of turns",
                values={"time_s": float(seconds[row])},
            )
        )
