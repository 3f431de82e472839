"""Runs of plain blocks as columns from the scanner; any other line goes through the grammar."""

from __future__ import annotations

from array import array
from mmap import mmap

from cncgen.gcode.block import Block, gather
from cncgen.gcode.source import Source
from cncgen.gcode.text.labels import Cursor
from cncgen.grammars.terminals import FANUC
from cncgen.kernels import gcode_scan
from cncgen.records import dataclass, field

#: Blocks and words that a scan holds; more of them do not make it faster. Behind a jump, which throws away what was scanned, the
#: first scan has so few blocks.
BLOCKS, FEW_BLOCKS = 4_096, 16
WORDS = 8 * BLOCKS


def column(kind: str, count: int, width: int = 0) -> memoryview:
    """Return zeros as a buffer that kernels fill: `count` values (rows of `width` values) of a type of `array`.

    Reading needs only a few functions of arrays, so a check need not import numpy. Pages come as they are touched: those of a
    short program are few.

    Raises:
        MemoryError: There is not enough.
    """
    try:
        zeros = memoryview(mmap(-1, count * max(width, 1) * array(kind).itemsize))
    except OSError as error:
        raise MemoryError from error
    return zeros.cast(kind, [count, width]) if width else zeros.cast(kind)  # type: ignore[call-overload]


@dataclass(slots=True, eq=False, repr=False)
class PlainBlocks:
    """Columns of `gcode_scan.scan` and `gcode_run.Computer`, used again for each stretch; `count` blocks of a source."""

    line: memoryview = field(default_factory=lambda: column("q", BLOCKS))
    offset: memoryview = field(default_factory=lambda: column("q", BLOCKS))
    flags: memoryview = field(default_factory=lambda: column("B", BLOCKS))
    word_end: memoryview = field(default_factory=lambda: column("q", BLOCKS))
    letters: memoryview = field(default_factory=lambda: column("B", WORDS))
    values: memoryview = field(default_factory=lambda: column("d", WORDS))
    count: int = 0
    source: int = 0

    def columns(self) -> tuple[memoryview, ...]:
        """Return the columns in the order in which the kernels take them."""
        return self.line, self.offset, self.flags, self.word_end, self.letters, self.values

    def scan(self, source: Source, start: Cursor, most: int = BLOCKS) -> tuple[Cursor, int]:
        """Read so many plain blocks from a line on, at most; return the first one not read, and why it was not."""
        lines, *others = self.columns()
        self.count, _, offset, line, why = gcode_scan.scan(
            source.bytes, start.offset, start.line, lines[:most], *others
        )
        self.source = start.source
        return Cursor(start.source, offset, line), why

    def pairs(self, index: int) -> list[tuple[str, float]]:
        """Return letters and values of a block."""
        begin = self.word_end[index - 1] if index else 0
        end = self.word_end[index]
        return list(zip(str(self.letters[begin:end], "ascii"), self.values[begin:end].tolist(), strict=True))

    def cursor(self, index: int) -> Cursor:
        """Return where a block stands."""
        return Cursor(self.source, self.offset[index], self.line[index])

    def block(self, index: int, twice: list[str] | None = None) -> Block:
        """Return a block as a record (without its comment); `twice` is that of `gather`."""
        block = gather(self.pairs(index), twice)
        block.source, block.offset, block.line = self.source, self.offset[index], self.line[index]
        return block


def comment_of(text: str) -> str | None:
    """Return the text of a line in its last ``( )`` (a later one takes the place of an earlier one), or None.

    The text behind a semicolon is never passed on.
    """
    import re

    last = None
    for match in re.finditer(FANUC["COMMENT"], text):
        if match[0][0] == "(":
            last = match[0][1:-1]
    return last


def empty_block(here: Cursor) -> Block:
    """Return a block without words, as the place of diagnostics of its line."""
    source, offset, line = here
    return Block({}, (), (), None, source, line, offset)
