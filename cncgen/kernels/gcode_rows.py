"""The lines of a text that `gcode_run` has met, compiled and kept, and which line leads to which."""

import cython
from cython.cimports.cncgen.kernels.gcode_codes import (
    AFTER, AT, BEHIND, FOLLOWING, HERE, LINE, MARK, NUMBER_OF_LINE, OFFSET, ROW,
)  # fmt: skip

from cncgen.kernels.gcode_lines import Lines, zeros

#: Lines that are kept, and those that are compiled together, at most.
_KEPT = cython.declare(cython.Py_ssize_t, 262_144)
_TOGETHER = cython.declare(cython.Py_ssize_t, 64)
_SHORT = cython.declare(cython.Py_ssize_t, 1024)


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
        marks, count: The O-words (`gcode_marks`) that are followed, and how many they are.
        used: How many rows are in use.
        last: The row that was run last.
        again: Whether lines may come again.
    """

    def __init__(self, text, parser, ways: dict):
        self.text, self.ways = text, ways
        self.kept = zeros(8 * ROW * _KEPT).cast("q", [_KEPT, ROW])
        self.lines = Lines(parser, text, self.kept)
        self.count = self.thrown = 0
        self.ahead, self.again = 1, False
        self._forget()

    def find_marks(self):
        """Return the O-words of the text."""
        # Most programs have none.
        from cncgen.kernels.gcode_marks import Marks

        self._forget()
        found = Marks(self.lines, self.text.shape[0])
        self.used = found.used
        return found

    @cython.cfunc
    @cython.exceptval(check=True)
    def _forget(self) -> cython.void:
        """Throw all lines away."""
        m: cython.Py_ssize_t
        self.used = self.last = 0
        self.thrown += 1
        self.entries = {}
        self.ways.clear()
        self.lines.forget()
        for m in range(self.count):
            self.marks[m, HERE] = self.marks[m, BEHIND] = -1

    @cython.cfunc
    @cython.exceptval(-1)
    def at(self, offset: cython.Py_ssize_t, line: cython.longlong) -> cython.Py_ssize_t:
        """Return the row of a line, which is compiled where it is not kept."""
        following: cython.Py_ssize_t
        if offset >= self.text.shape[0]:
            return -1 - offset
        if self.last < self.used:
            following = self.kept[self.last, FOLLOWING]
            if following >= 0 and self.kept[following, AT] == offset:
                return following
        found = self.entries.get(offset)
        if found is None:
            self.ahead = 1
            found = self._compiled(offset, line, 0)
            self.entries[offset] = found
        return found

    @cython.cfunc
    @cython.exceptval(-1)
    def _compiled(
        self, offset: cython.Py_ssize_t, line: cython.longlong, m: cython.Py_ssize_t
    ) -> cython.Py_ssize_t:
        """Compile lines from one on, the more the longer lines follow one another; return its row.

        `m` is the mark that is likely to be the next one.
        """
        first: cython.Py_ssize_t = self.used
        end: cython.Py_ssize_t = self.text.shape[0]
        if self.count > 0:
            if (
                m >= self.count
                or self.marks[m, OFFSET] < offset
                or (m > 0 and self.marks[m - 1, OFFSET] >= offset)
            ):
                m = self._mark_behind(offset)
            if m < self.count and self.marks[m, HERE] >= 0:
                # Lines of O-words are compiled when they are found.
                if self.marks[m, OFFSET] == offset:
                    return self.marks[m, HERE]
                end = self.marks[m, OFFSET]
        if first == _KEPT or not self.lines.code.room() or (first > _SHORT and not self.again):
            self._forget()
            first = 0
        self.used = self.lines.compile(offset, line, first, min(first + self.ahead, _KEPT), end)
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
        found = self._compiled(offset, self.kept[r, NUMBER_OF_LINE] + 1, self.kept[r, MARK] + 1)
        if thrown == self.thrown:
            self.kept[r, FOLLOWING] = found
        return found

    # Rows of O-words.

    @cython.cfunc
    @cython.exceptval(-1)
    def mark_of(self, r: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Return the mark of a row; -1 where it has none."""
        m: cython.Py_ssize_t = self.kept[r, MARK]
        if m < 0:
            m = self.kept[r, MARK] = self._mark_behind(self.kept[r, AT])
        return m if m < self.count and self.marks[m, OFFSET] == self.kept[r, AT] else -1

    @cython.cfunc
    @cython.exceptval(check=False)
    def _mark_behind(self, offset: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Return the first mark at `offset` or behind it."""
        low: cython.Py_ssize_t = 0
        high: cython.Py_ssize_t = self.count
        middle: cython.Py_ssize_t
        while low < high:
            middle = (low + high) // 2
            if self.marks[middle, OFFSET] < offset:
                low = middle + 1
            else:
                high = middle
        return low

    @cython.cfunc
    @cython.exceptval(-1)
    def at_mark(self, m: cython.longlong) -> cython.Py_ssize_t:
        """Return the row of the line of a mark."""
        if self.marks[m, HERE] < 0:
            self.marks[m, HERE] = self.at(self.marks[m, OFFSET], self.marks[m, LINE])
        return self.marks[m, HERE]

    @cython.cfunc
    @cython.exceptval(-1)
    def behind_mark(self, m: cython.longlong) -> cython.Py_ssize_t:
        """Return the row of the line behind that of a mark."""
        r: cython.Py_ssize_t
        if self.marks[m, BEHIND] < 0:
            r = self.following(self.at_mark(m))
            self.marks[m, BEHIND] = r
        return self.marks[m, BEHIND]
