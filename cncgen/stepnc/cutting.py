"""A STEP-NC program for material removal: toolpaths with workingsteps as events, the raw piece, and the finished part."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from typing import BinaryIO

import numpy as np

from cncgen.diagnostics import Diagnostics, Severity
from cncgen.geometry import elementary
from cncgen.stepnc.entities import Skip
from cncgen.stepnc.execution.columns import StepColumns
from cncgen.stepnc.features.finished import Finished
from cncgen.stepnc.features.turned_part import TurnedPart
from cncgen.stepnc.geometry.frames import Matrix
from cncgen.stepnc.geometry.solids import Solid
from cncgen.stepnc.model import RawPiece, Workingstep
from cncgen.stepnc.reading import StepFile
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import Toolpath


@dataclass(slots=True)
class CutProgram:
    """A program to be cut.

    Attributes:
        axes: Letters of the axes.
        toolpaths: All of its motions.
        diagnostics: Of reading it.
        raw: Its raw pieces as they stand in the first setup, seen from the machine.
        part: The bounds of the finished part, in the workpiece's frame, None where the file has no shape of it.
        finished: The material of them that is to stay, None where a workingstep does not say.
        turned: The same of a program that turns alone.
        clampings: Of a program with several setups, by number: the frame of the raw pieces, seen from the machine, and what is to
            stay there. Empty where they are not the same in all setups.
        unlike: Of such a program, how its setups are unlike.
    """

    axes: str
    toolpaths: list[Toolpath] = field(default_factory=list)
    diagnostics: Diagnostics = field(default_factory=Diagnostics)
    raw: list[Solid] = field(default_factory=list)
    part: Solid | None = None
    finished: Finished | None = None
    turned: TurnedPart | None = None
    clampings: dict[int, tuple[Matrix, Finished | None]] = field(default_factory=dict)
    unlike: str = ""


def cut_program(
    source: str | os.PathLike[str] | BinaryIO | bytes, name: str = "-", options: ReadOptions | None = None
) -> CutProgram:
    """Read and execute a program for material removal.

    Raises:
        UsageError: where the file cannot be read.
    """
    options = options or ReadOptions()
    file = StepFile(source, name, options)
    columns = StepColumns(file.axes, name, file.line_of, options.tolerance_mm)
    out = CutProgram(file.axes, list(_chunks(file, columns, options.chunk_rows)), file.diagnostics)
    setups = _setups(columns.steps)
    out.raw = [piece.placed for piece in next(iter(setups.values()), _Setup()).pieces.values()]
    with suppress(Skip):
        parts = file.reader.parts()
        out.part = parts[0] if parts else None
        if len(parts) > 1:
            text = f"the file has the shapes of {len(parts)} parts; material that is to stay is that of the first"
            file.exchange.reporter.report("stepnc-several", text, severity=Severity.WARNING)
    out.finished = Finished.of(columns.steps, file.exchange)
    out.turned = TurnedPart.of(columns.steps, file.exchange)
    if any(setup.moved for setup in setups.values()):
        text = "a workpiece stands at two places in one setup; its raw piece is cut where it stands first"
        file.exchange.reporter.report("stepnc-workpiece", text, severity=Severity.WARNING)
    if len(setups) > 1:
        out.unlike = _unlike(list(setups.values()))
        if not out.unlike:
            frames = {n: next(iter(setup.pieces.values())).frame for n, setup in setups.items()}
            out.clampings = {n: (f, Finished.of(setups[n].steps, file.exchange)) for n, f in frames.items()}
    return out


@dataclass(slots=True)
class _Setup:
    """The workingsteps and raw pieces of a setup, these by the workpieces that they are; `moved`: one stands at two places."""

    steps: list[Workingstep] = field(default_factory=list)
    pieces: dict[int, RawPiece] = field(default_factory=dict)
    moved: bool = False


def _setups(steps: list[Workingstep]) -> dict[int, _Setup]:
    """Return the setups by number, in their order; 0 is that of a program which has one alone."""
    out: dict[int, _Setup] = {}
    several = any(step.setup is not None for step in steps)
    for step in steps:
        if several and step.setup is None:
            continue
        setup = out.setdefault(step.setup.number if step.setup is not None else 0, _Setup())
        setup.steps.append(step)
        for piece in step.pieces:
            setup.moved |= not setup.pieces.setdefault(piece.ident, piece).same(piece)
    return out


def _unlike(setups: list[_Setup]) -> str:
    """Return how the raw pieces of setups are unlike, so that none of them can be placed anew from one setup to the next."""
    first = setups[0]
    if not all(setup.pieces for setup in setups):
        return "the file does not say how its raw piece stands in each"
    if any(setup.pieces.keys() != first.pieces.keys() for setup in setups):
        names = [", ".join(f"#{i}" for i in keys) for keys in dict.fromkeys(tuple(s.pieces) for s in setups)]
        return f"they have different raw pieces, of the workpieces {' and '.join(names)}"
    moves = [
        elementary.product(s.pieces[i].frame, np.asarray(np.linalg.inv(first.pieces[i].frame)))
        for s in setups
        for i in first.pieces
    ]
    each = len(first.pieces)
    if not all(np.allclose(m, moves[k - k % each], atol=1e-9) for k, m in enumerate(moves)):
        return "they place their raw pieces otherwise to one another"
    return ""


def _chunks(file: StepFile, columns: StepColumns, rows: int) -> Iterator[Toolpath]:
    for _ in file.execute(columns):
        if columns.count >= rows:
            yield columns.take()
    yield columns.take()
