"""A STEP-NC program as material removal needs it: toolpaths with workingsteps as events, the raw piece, and what is to stay."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from cncgen.diagnostics import Diagnostics
from cncgen.stepnc.execution.columns import StepColumns
from cncgen.stepnc.features.finished import Finished
from cncgen.stepnc.geometry.solids import Solid
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
        finished: The material of them that is to stay, None where a workingstep does not say.
    """

    axes: str
    toolpaths: list[Toolpath] = field(default_factory=list)
    diagnostics: Diagnostics = field(default_factory=Diagnostics)
    raw: list[Solid] = field(default_factory=list)
    finished: Finished | None = None


def cut_program(
    source: Path | BinaryIO | bytes, name: str = "-", options: ReadOptions | None = None
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
    out.finished = Finished.of(columns.steps, file.exchange)
    return out


def _chunks(file: StepFile, columns: StepColumns, rows: int) -> Iterator[Toolpath]:
    for _ in file.execute(columns):
        if columns.count >= rows:
            yield columns.take()
    yield columns.take()
