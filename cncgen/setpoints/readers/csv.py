"""CSV: a header that names ``t_s`` and the positions (``x_mm``, ``a_deg`` …), then rows of numbers.

Further columns are passed over, so that a file with signals, or a simulation's response, is read as well. Whole blocks
of lines go to the kernel; a line that it leaves (an exponent, many digits, a fault) is parsed in Python.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Span, UsageError, excerpt_of
from cncgen.files import STANDARD_INPUT, reading_faults, utf8_of
from cncgen.kernels import decimal_rows as kernel
from cncgen.setpoints.columns import POSITION_COLUMNS
from cncgen.setpoints.readers.blocks import FileBlock, RowFaults, warn_of_columns, warn_of_end

#: Bytes read at a time.
BLOCK_BYTES = 1 << 20
#: Longest line that is a row.
MAX_LINE = 1 << 20

_POWERS = 10.0 ** np.arange(23)


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the rows of a CSV file; it names its axes itself.

    Raises:
        UsageError: The header names no positions or no time, or an axis otherwise than `POSITION_COLUMNS`; a row has
            another number of columns, or a cell without a finite number (`RowFaults`).
    """
    lines = line_blocks(file, name)
    text = next(lines, b"")
    header, number = b"", 0
    while text and (not header or header.startswith(b"#")):
        head, _, text = text.partition(b"\n")
        header, number = head.strip(), number + 1
    if not header:
        hint = "did the command before the pipe end with an error?" if name == STANDARD_INPUT else ""
        raise UsageError(Diagnostic("setpoints-empty", f"{name} holds no setpoints: it is empty", hint=hint))
    table = _Table(name, header, number)
    faults = RowFaults(name)
    while text or (text := next(lines, b"")):
        matrix = table.parse(text, faults)
        text = b""
        if len(matrix) and not faults:
            yield table.block(matrix)
    faults.raise_any()


def line_blocks(file: BinaryIO, name: str) -> Iterator[bytes]:
    """Yield a file as blocks of whole lines, each line ended by a line feed (the last one too).

    Raises:
        UsageError: It cannot be read, or a line is longer than `MAX_LINE` bytes.
    """
    rest, decoder = b"", None
    while True:
        with reading_faults(name):
            # The bytes in a pipe are handed on at once; read() would wait for the whole block.
            piece = file.read1(BLOCK_BYTES) if hasattr(file, "read1") else file.read(BLOCK_BYTES)
        if not piece:
            break
        if decoder is None:
            decoder = utf8_of(piece)
        piece = decoder(piece)
        whole, feed, after = (rest + piece).rpartition(b"\n")
        rest = after
        if len(rest) > MAX_LINE:
            raise UsageError(Diagnostic("setpoints-line", f"{name}: a line is longer than {MAX_LINE} bytes"))
        if feed:
            yield whole + feed
    if rest:
        warn_of_end(rest, name)
        yield rest + b"\n"


def _header_fault(names: list[str], any_axis: bool) -> str:
    """Return the fault of the columns of a file, or ""."""
    twice = next((n for n in names if n in ("t_s", *POSITION_COLUMNS) and names.count(n) > 1), "")
    if twice:
        return f"names {twice} twice"
    if "t_s" not in names:
        cells = re.split(r"([;\t ])", names[0])
        if len(names) == 1 and "t_s" in cells and len(cells) > 1:
            sign = {"\t": "tabs", " ": "blanks"}.get(cells[1], "semicolons")
            return f"has {sign} between the columns, and a CSV file has commas"
        return "names no time t_s"
    return "" if any_axis else "names no axis position"


class _Table:
    """The columns of a CSV file, and how far it has been read."""

    def __init__(self, name: str, header: bytes, line: int) -> None:
        self.name, self.line = name, line
        names = [cell.strip().strip('"').lower() for cell in header.decode("utf-8-sig", "replace").split(",")]
        self.width = len(names)
        self.columns = [(POSITION_COLUMNS[n], k) for k, n in enumerate(names) if n in POSITION_COLUMNS]
        fault = _header_fault(names, bool(self.columns))
        if fault:
            excerpt, cut = excerpt_of(header.decode("utf-8", "replace"), 1)
            raise UsageError(
                Diagnostic(
                    "setpoints-header",
                    f"{name} is not a setpoint file: its first line {fault}",
                    span=Span(name, max(line, 1)),
                    excerpt=excerpt,
                    excerpt_offset=cut,
                    hint="the header is t_s, then the axes with their unit, by commas: t_s,x_mm,y_mm,a_deg; "
                    "--format names another format than csv (f64 and hal are not known by their content)",
                )
            )
        warn_of_columns(names, name)
        self.time = names.index("t_s")
        #: Columns that must hold numbers. Others may hold anything, as a state or a date.
        self.wanted = frozenset((self.time, *(k for _, k in self.columns)))
        self.axes = "".join(letter for letter, _ in self.columns)

    def block(self, matrix: NDArray[np.float64]) -> FileBlock:
        """Return the time and positions of rows."""
        return FileBlock(self.axes, matrix[:, self.time].copy(), matrix[:, [k for _, k in self.columns]])

    def parse(self, text: bytes, faults: RowFaults) -> NDArray[np.float64]:
        """Return the rows of a block of whole lines; add a diagnostic for each other line."""
        data = np.frombuffer(text, np.uint8)
        matrix = np.empty((text.count(b"\n"), self.width))
        state = np.zeros(2, np.int64)
        at, row = 0, 0
        while at < len(text):
            kernel.read_rows(data, at, row, _POWERS, matrix, state)
            at, done = int(state[0]), int(state[1])
            self.line += done - row
            row = done
            if at >= len(text):
                break
            end = text.index(b"\n", at)
            self.line += 1
            row += self._parse_line(text[at:end], matrix[row], faults)
            at = end + 1
        return matrix[:row]

    def _parse_line(self, line: bytes, out: NDArray[np.float64], faults: RowFaults) -> int:
        """Parse one line in Python; return the number of rows it gave, 0 or 1."""
        stripped = line.strip()
        if not stripped or stripped.startswith(b"#"):
            return 0
        cells = line.split(b",")
        if len(cells) != self.width:
            message = f"the row has {len(cells)} columns, the header {self.width}"
            faults.add(self._fault("setpoints-columns", message, line, 1, len(line)))
            return 0
        column = 1
        for k, cell in enumerate(cells):
            value = _number(cell)
            if not math.isfinite(value) and k in self.wanted:
                shown = cell.strip()[:40].decode("utf-8", "replace")
                message = f"{shown!r} is not a finite number"
                faults.add(self._fault("setpoints-number", message, line, column, len(cell)))
                return 0
            out[k] = value
            column += len(cell) + 1
        return 1

    def _fault(self, code: str, message: str, line: bytes, column: int, length: int) -> Diagnostic:
        start = max(0, column - 1 - 200)
        excerpt, cut = excerpt_of(line[start : start + 1000].decode("utf-8", "replace"), column - start)
        span = Span(self.name, self.line, column, max(1, length))
        return Diagnostic(code, message, span=span, excerpt=excerpt, excerpt_offset=start + cut)


def _number(cell: bytes) -> float:
    """Return a number, NaN for other text (also for Python's underscores between digits)."""
    if b"_" in cell:
        return math.nan
    try:
        return float(cell)
    except ValueError:
        return math.nan
