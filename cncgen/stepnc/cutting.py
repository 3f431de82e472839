"""A STEP-NC program for material removal: toolpaths with workingsteps as events, the raw piece, and the finished part."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from typing import BinaryIO

from cncgen.diagnostics import Diagnostics, Severity
from cncgen.stepnc.entities import Skip
from cncgen.stepnc.execution.columns import StepColumns
from cncgen.stepnc.features.finished import Finished
from cncgen.stepnc.features.turned_part import TurnedPart
from cncgen.stepnc.geometry.frames import Matrix
from cncgen.stepnc.geometry.solids import Solid
from cncgen.stepnc.model import Workingstep
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
        raw: Its raw pieces, seen from the machine.
        part: The bounds of the finished part, in the workpiece's frame, None where the file has no shape of it.
        finished: The material of them that is to stay, None where a workingstep does not say.
        turned: The same of a program that turns alone.
        clampings: Of a program with several setups, by number: the frame of the raw piece, seen from the machine, and what is to
            stay there. Empty where a setup has no raw piece, or they have different ones.
    """

    axes: str
    toolpaths: list[Toolpath] = field(default_factory=list)
    diagnostics: Diagnostics = field(default_factory=Diagnostics)
    raw: list[Solid] = field(default_factory=list)
    part: Solid | None = None
    finished: Finished | None = None
    turned: TurnedPart | None = None
    clampings: dict[int, tuple[Matrix, Finished | None]] = field(default_factory=dict)


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
    for step in columns.steps:
        if step.raw is not None and not any(step.raw.same(r) for r in out.raw):
            out.raw.append(step.raw)
    with suppress(Skip):
        parts = file.reader.parts()
        out.part = parts[0] if parts else None
        if len(parts) > 1:
            text = f"the file has the shapes of {len(parts)} parts; material that is to stay is that of the first"
            file.exchange.reporter.report("stepnc-several", text, severity=Severity.WARNING)
    out.finished = Finished.of(columns.steps, file.exchange)
    out.turned = TurnedPart.of(columns.steps, file.exchange)
    out.clampings = _clampings(columns.steps, file)
    return out


def _clampings(steps: list[Workingstep], file: StepFile) -> dict[int, tuple[Matrix, Finished | None]]:
    """Return how the raw piece stands in each setup, and what the operations there leave."""
    by_number: dict[int, list[Workingstep]] = {}
    for step in steps:
        if step.setup is not None:
            by_number.setdefault(step.setup.number, []).append(step)
    out: dict[int, tuple[Matrix, Finished | None]] = {}
    sizes = set()
    for number, those in by_number.items():
        raws = [s.raw for s in those if s.raw is not None]
        if not raws or not all(raws[0].same(r) for r in raws):
            return {}
        raw = raws[0]
        sizes.add((raw.kind, raw.size))
        out[number] = raw.frame, Finished.of(those, file.exchange)
    return out if len(sizes) == 1 else {}


def _chunks(file: StepFile, columns: StepColumns, rows: int) -> Iterator[Toolpath]:
    for _ in file.execute(columns):
        if columns.count >= rows:
            yield columns.take()
    yield columns.take()
