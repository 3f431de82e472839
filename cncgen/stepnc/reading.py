"""Reading a STEP-NC file into a program, whichever of the two schemas it follows."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import nullcontext
from copy import copy
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Diagnostics, ProgramError, UsageError
from cncgen.files import reading_faults
from cncgen.geometry import elementary
from cncgen.machine.tool_table import read_tool_table
from cncgen.stepnc.ap238 import Ap238Reader
from cncgen.stepnc.entities import Skip
from cncgen.stepnc.execution.canon import Canon, Printer
from cncgen.stepnc.execution.columns import Columns, StepColumns
from cncgen.stepnc.execution.executor import ProgramExecutor
from cncgen.stepnc.execution.rotary_axes import RotaryAxes
from cncgen.stepnc.execution.technology import SpeedRules
from cncgen.stepnc.features import Bars, make_paths
from cncgen.stepnc.geometry.frames import Matrix
from cncgen.stepnc.iso14649 import Iso14649Reader
from cncgen.stepnc.model import Branching, Executable, Feature, ProgramStructure, Reader, Workingstep
from cncgen.stepnc.part21 import Exchange
from cncgen.stepnc.schema.check import check
from cncgen.stepnc.schema.short_names import SHORT_NAMES
from cncgen.stepnc.schema.tables import ap238_table, iso14649_table, supertypes
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import Program, Toolpath

#: Where the tool stands when a program begins and no comment says: high above, as NIST's interpreter has it.
START = (0.0, 0.0, 250.0)
#: Executables, elements of a feature and levels of them that are looked at for tilted frames.
MAX_WALK, MAX_ELEMENTS, MAX_NESTED = 10_000, 1000, 5
#: Bytes of a file; more is refused.
MAX_SIZE = 4 * 1024**3

_START = re.compile(r"\(\s*START\s*,([^)]*)\)", re.IGNORECASE)
_WORD = re.compile(r"([XYZ])\s*([+-]?(?:\d++\.?+\d*+|\.\d+)(?:E[+-]?\d+)?)", re.IGNORECASE)


class StepFile:
    """A file that is read and checked, ready to be executed (once or more).

    Attributes:
        exchange: Its instances.
        reader: Of ISO 14649 or AP238, by the entities that it holds.
        schema: ``iso14649`` or ``ap238``.
        diagnostics: Faults found so far.
        kinematics: Of the rotary axes, None where the program has none.
        lengths: Of the tool table by the tools' names, mm, None without one.
        start: Where the tool stands at the beginning, mm.
    """

    def __init__(
        self, source: str | os.PathLike[str] | BinaryIO | bytes, name: str, options: ReadOptions
    ) -> None:
        self.diagnostics = Diagnostics()
        self._content = _bytes_of(source, name)
        self.exchange = Exchange.load(self._content, name, self.diagnostics, SHORT_NAMES, supertypes())
        self.schema = schema_of(self.exchange)
        self.reader: Ap238Reader | Iso14649Reader
        if self.schema == "ap238":
            self.reader = Ap238Reader(self.exchange)
            check(self.exchange, ap238_table())
        else:
            self.reader = Iso14649Reader(self.exchange)
            check(self.exchange, iso14649_table())
        self._leaning = self.reader.needs_rotary() or (self.reader.may_lean() and _leans(self.reader))
        self.start = start_of(self.exchange.comments_before)
        self._read_with(options)

    def _read_with(self, options: ReadOptions) -> None:
        self.options = options
        self.kinematics = RotaryAxes.of(options.kinematics) if self._leaning else None
        table = options.tool_table
        self.lengths = None if table is None else read_tool_table(table).lengths(options.inch_tables)

    def reread(self, name: str, options: ReadOptions) -> StepFile:
        """Return the file as it is read with other options; after an error, which may be of its options, it is loaded again."""
        if self.diagnostics.has_errors:
            return StepFile(self._content, name, options)
        same = copy(self)
        same._read_with(options)
        return same

    @property
    def axes(self) -> str:
        """Return the letters of the program's axes."""
        return "XYZ" + (self.kinematics.letters if self.kinematics else "")

    def execute(self, canon: Canon) -> Iterator[None]:
        """Execute the program with a listener; yields after every toolpath."""
        rules = SpeedRules(
            self.schema == "iso14649" and self.options.speed_unit == "m/min",
            self.options.spindle_sign == "tool",
        )
        bars: Bars = {}
        executor = ProgramExecutor(
            reader=self.reader,
            exchange=self.exchange,
            canon=canon,
            start=self.start,
            kinematics=self.kinematics,
            make_paths=lambda step: make_paths(step, self.exchange, bars),
            max_steps=self.options.max_steps,
            rules=rules,
            lengths=self.lengths,
        )
        yield from executor.run()
        self.exchange.reporter.close()

    def line_of(self, ident: int) -> int:
        """Return the line of an entity."""
        return self.exchange.line(ident)


def _leans(reader: Reader) -> bool:
    """Tell whether a workingstep's frame leans: a feature that leans may stand upright in its setup, and the other way round.

    So many executables that it would take long count as leaning.
    """
    waiting = [inner for root in reader.roots() for inner in _inner(root)]
    met: dict[tuple[int, int], Any] = {}  # contexts are kept, so that their ids stay theirs
    while waiting and len(met) < MAX_WALK:
        ident, context = waiting.pop()
        if (ident, id(context)) in met:
            continue
        met[ident, id(context)] = context
        try:
            item = reader.executable(ident, context)
        except Skip:
            continue
        if isinstance(item, Workingstep):
            feature = item.feature if item.operation.paths is None else None
            if _tilts(item.frame, feature, 0):
                return True
        waiting += _inner(item)
    return bool(waiting)


def _tilts(frame: Matrix, feature: Feature | None, depth: int) -> bool:
    """Tell whether the Z of a frame leaves the machine's, or that of an element of the feature in it."""
    if frame[2, 2] < 1.0 - 1e-12:
        return True
    if feature is None or depth > MAX_NESTED:
        return False
    try:
        elements = feature.shape().elements
    except Skip:
        return False
    return any(_tilts(elementary.product(frame, e.placement), e, depth + 1) for e in elements[:MAX_ELEMENTS])


def _inner(item: Executable) -> list[tuple[int, Any]]:
    """Return the executables within one, each with its context."""
    if isinstance(item, ProgramStructure):
        return [(child, item.context) for child in item.children]
    if isinstance(item, Branching):
        return [(child, item.context) for child in (item.then, item.otherwise) if child is not None]
    return []


def schema_of(exchange: Exchange) -> str:
    """Return ``ap238`` or ``iso14649``: by the entities of the file, not by its header."""
    if len(
        exchange.rows_of_type(
            "MACHINING_TOOLPATH", "ACTION_PROPERTY", "MACHINING_WORKPLAN", "MACHINING_PROJECT"
        )
    ):
        return "ap238"
    return "iso14649"


def start_of(comments: str) -> NDArray[np.float64]:
    """Return the position that a comment ``(START, X… Y… Z…)`` before the data gives, else `START`."""
    found = _START.search(comments)
    position = np.array(START)
    if found:
        position = np.zeros(3)
        for letter, value in _WORD.findall(found[1]):
            position["XYZ".index(letter.upper())] = float(value)
    return position


def _blocks(source: BinaryIO) -> Iterator[bytes]:
    """Yield the content of a stream, up to a block more than `MAX_SIZE`."""
    size = 0
    while size <= MAX_SIZE and (block := source.read(1 << 20)):
        size += len(block)
        yield block


def _bytes_of(source: str | os.PathLike[str] | BinaryIO | bytes, name: str) -> bytes:
    if isinstance(source, bytes):
        return source
    with (
        reading_faults(name),
        open(source, "rb") if isinstance(source, str | os.PathLike) else nullcontext(source) as stream,
    ):
        # A stream that is asked for so many bytes at once would make room for all of them.
        data = b"".join(_blocks(stream))
    if len(data) > MAX_SIZE:
        raise UsageError(Diagnostic("file-size", f"the file is larger than {MAX_SIZE} bytes"))
    return data


def read(
    source: str | os.PathLike[str] | BinaryIO | bytes, name: str = "-", options: ReadOptions | None = None
) -> Program:
    """Read a STEP-NC program (ISO 14649 or AP238 in ISO 10303-21).

    The file is read and checked at once; motions are made as the chunks are drawn. Positions are machine coordinates:
    setup, workpiece and feature placements are applied. Rotary axes are there
    where a tool axis leaves the machine's Z: those of the machine where it says how they carry table or head, else B and
    C (see `execution.rotary_axes`).

    Args:
        source: A file or its bytes.
        name: How diagnostics call it.
        options: `tool_table`, `inch_tables`, `kinematics`, `workingsteps`, `speed_unit`, `spindle_sign`, `max_steps`, `chunk_rows` and
            `tolerance_mm` count.

    Raises:
        UsageError: where the file cannot be read.
    """
    return _program(StepFile(source, name, options or ReadOptions()), name)


def _program(file: StepFile, name: str) -> Program:
    """Return a file as a program."""
    options = file.options

    def chunks(_spindle: float = 1.0) -> Iterator[Toolpath]:
        collector = StepColumns if options.workingsteps else Columns
        columns = collector(file.axes, name, file.line_of, options.tolerance_mm)
        for _ in file.execute(columns):
            if columns.count >= options.chunk_rows:
                yield columns.take()
        yield columns.take()

    def reread(how: ReadOptions) -> Program:
        return _program(file.reread(name, how), name)

    return Program(name, "stepnc", file.axes, file.axes, chunks, file.diagnostics, options, reread)


def canon(
    source: str | os.PathLike[str] | BinaryIO | bytes,
    name: str = "-",
    options: ReadOptions | None = None,
    diagnostics: Diagnostics | None = None,
) -> Iterator[str]:
    """Yield the canonical machining functions that a program calls, a line each, as NIST's interpreters print them.

    Args:
        source, name, options: As for `read`.
        diagnostics: Filled with those of the program; without it, errors are raised when all has been printed.

    Raises:
        UsageError: where the file cannot be read.
        ProgramError: where the program has errors and `diagnostics` is not given.
    """
    options = options or ReadOptions()
    file = StepFile(source, name, options)
    printer = Printer(file.axes)
    for _ in file.execute(printer):
        yield from printer.take()
    yield from printer.take()
    if diagnostics is not None:
        diagnostics.extend(file.diagnostics)
    elif file.diagnostics.has_errors:
        raise ProgramError(file.diagnostics)


def entities_by_line(source: str | os.PathLike[str] | BinaryIO | bytes, name: str = "-") -> dict[int, str]:
    """Return ``#id KEYWORD`` of the instance that begins on each line (the first of several).

    Raises:
        UsageError: where the file cannot be read.
    """
    exchange = Exchange.load(_bytes_of(source, name), name, None, SHORT_NAMES, supertypes())
    lines = exchange.row_lines
    out: dict[int, str] = {}
    for row in exchange.instance_rows.tolist():
        begin, end = int(exchange.rows.bodies[row]), int(exchange.rows.ends[row])
        keyword = re.match(rb"\(?\s*([A-Za-z0-9_!]+)", exchange.data[begin : min(end, begin + 100)])
        parts = exchange.partial_entities(int(exchange.rows.ids[row]))
        word = parts[-1] if parts else keyword[1].decode().upper() if keyword else ""
        out.setdefault(int(lines[row]), f"#{exchange.rows.ids[row]} {word}")
    return out
