"""The lines of a text that `gcode_run` has met, compiled and kept, and which line leads to which."""

import cython
from cython.cimports.cncgen.kernels.gcode_codes import (
    AFTER, AT, FOLLOWING, NUMBER_OF_LINE, ROW,
)  # fmt: skip

from cncgen.kernels.gcode_lines import Lines, zeros

#: Lines that are kept, and those that are compiled together, at most.
_KEPT = cython.declare(cython.Py_ssize_t, 262_144)
_TOGETHER = cython.declare(cython.Py_ssize_t, 64)
_SHORT = cython.declare(cython.Py_ssize_t, 1024)
#: Lines that are found at once, by the last bits of their offsets.
_NEAR = cython.declare(cython.Py_ssize_t, 256)


@cython.final
@cython.cclass
class Rows:
    """Lines by row. A place behind the text is a number below 0: -1 less its offset.

    Args:
        text: The text.
        parser: Reads its lines, and holds their code; nobody else uses it.
        ways: Where jumps lead, by row; they are forgotten with the rows.

    Attributes:
        kept: The rows (`gcode_codes.LINE_COLUMNS`).
        used: How many rows are in use.
        last: The row that was run last.
        again: Whether lines may come again.
    """

    def __init__(self, text, parser, ways: dict):
        self.text, self.ways = text, ways
        self.kept = zeros(8 * ROW * _KEPT).cast("q", [_KEPT, ROW])
        self.lines = Lines(parser, text, self.kept)
        self.near = memoryview(bytearray(16 * _NEAR)).cast("q", [_NEAR, 2])
        self.thrown = 0
        self.ahead, self.again = 1, False
        self._forget()

    @cython.cfunc
    def _forget(self) -> cython.void:
        """Throw all lines away."""
        k: cython.Py_ssize_t
        self.used = self.last = 0
        self.thrown += 1
        for k in range(_NEAR):
            self.near[k, 0] = -1
        self.entries = {}
        self.ways.clear()
        self.lines.forget()

    @cython.cfunc
    @cython.exceptval(-1)
    def at(self, offset: cython.Py_ssize_t, line: cython.longlong) -> cython.Py_ssize_t:
        """Return the row of a line, which is compiled where it is not kept."""
        following: cython.Py_ssize_t
        k: cython.Py_ssize_t = offset & (_NEAR - 1)
        if self.near[k, 0] == offset:
            return self.near[k, 1]
        if offset >= self.text.shape[0]:
            return -1 - offset
        if self.last < self.used:
            following = self.kept[self.last, FOLLOWING]
            if following >= 0 and self.kept[following, AT] == offset:
                return following
        found = self.entries.get(offset)
        if found is None:
            self.ahead = 1
            found = self._compiled(offset, line)
            self.entries[offset] = found
        self.near[k, 0], self.near[k, 1] = offset, found
        return found

    @cython.cfunc
    @cython.exceptval(-1)
    def _compiled(self, offset: cython.Py_ssize_t, line: cython.longlong) -> cython.Py_ssize_t:
        """Compile lines from one on, the more the longer lines follow one another; return its row."""
        first: cython.Py_ssize_t = self.used
        if first == _KEPT or not self.lines.code.room() or (first > _SHORT and not self.again):
            self._forget()
            first = 0
        self.used = self.lines.compile(
            offset, line, first, min(first + self.ahead, _KEPT), self.text.shape[0]
        )
        self.ahead = min(2 * self.ahead, _TOGETHER)
        return first

    @cython.cfunc
    @cython.exceptval(-1)
    def following(self, r: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Return the row of the line behind that of a row."""
        offset: cython.Py_ssize_t = self.kept[r, AFTER]
        thrown: cython.Py_ssize_t = self.thrown
        found: cython.Py_ssize_t = self.kept[r, FOLLOWING]
        if found >= 0:
            return found
        if offset >= self.text.shape[0]:
            return -1 - offset
        found = self._compiled(offset, self.kept[r, NUMBER_OF_LINE] + 1)
        if thrown == self.thrown:
            self.kept[r, FOLLOWING] = found
        return found
