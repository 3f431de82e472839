"""What is asked of a program before it is planned: that the machine has its axes and reaches its end points."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from cncgen.diagnostics import Diagnostic, Diagnostics, ProgramError, Span
from cncgen.machine.record import Machine
from cncgen.planner.options import PlanOptions
from cncgen.toolpath.record import Kind, PathMode, Toolpath
from cncgen.units import file_unit, to_file


def checked(chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions) -> Iterator[Toolpath]:
    """Yield the chunks with their tolerances filled in (the option's, the program's, else the machine's).

    Raises:
        ProgramError: A chunk moves an axis that the machine lacks, or ends a motion outside its travel; every such
            fault of the chunk is named.
    """
    for chunk in chunks:
        if not len(chunk):
            continue
        found = Diagnostics()
        _missing_axes(chunk, machine, found)
        _beyond_travel(chunk, machine, found)
        if found.has_errors:
            raise ProgramError(found)
        yield _with_tolerance(chunk, machine, options)


def _with_tolerance(chunk: Toolpath, machine: Machine, options: PlanOptions) -> Toolpath:
    if options.path_tolerance_mm is not None:
        tolerance = np.full(len(chunk), options.path_tolerance_mm)
    else:
        tolerance = np.where(np.isnan(chunk.tolerance), machine.path_tolerance_mm, chunk.tolerance)
    continuous = chunk.path_mode == PathMode.CONTINUOUS
    return replace(chunk, tolerance=np.where(continuous, tolerance, chunk.tolerance))


def _missing_axes(chunk: Toolpath, machine: Machine, found: Diagnostics) -> None:
    moves = chunk.end != chunk.starts
    for column, letter in enumerate(chunk.axes):
        rows = np.flatnonzero(moves[:, column])
        if letter not in machine.axes and len(rows):
            found.add(
                Diagnostic(
                    "axis-missing",
                    f"the program moves axis {letter}, which machine {machine.name} does not have",
                    span=_span(chunk, int(rows[0])),
                    hint=f"its axes are {' '.join(machine.axes)}; choose another machine with --machine",
                )
            )


def _beyond_travel(chunk: Toolpath, machine: Machine, found: Diagnostics) -> None:
    moving = chunk.kind != Kind.EVENT
    for column, letter in enumerate(chunk.axes):
        axis = machine.axes.get(letter)
        if axis is None or axis.travel is None:
            continue
        low, high = axis.travel
        scale, unit = to_file(letter), file_unit(letter)
        position = chunk.end[:, column]
        for row in np.flatnonzero(moving & ((position < low) | (position > high))):
            found.add(
                Diagnostic(
                    "travel-exceeded",
                    f"axis {letter} is sent to {position[row] * scale:.4f} {unit}, "
                    f"beyond its travel of {low * scale:g} to {high * scale:g} {unit}",
                    span=_span(chunk, int(row)),
                )
            )


def _span(chunk: Toolpath, row: int) -> Span:
    return Span(chunk.sources[int(chunk.source[row])], int(chunk.line[row]))
