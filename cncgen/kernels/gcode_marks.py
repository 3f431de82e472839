"""The lines of a text that O-words and jumps of macros may lead to, and the nearest one of a label: for the kernel `gcode_run` and for
`cncgen.gcode.flow.o_words`, which defines the O-words."""

import cython
from cython.cimports.cncgen.kernels.gcode_codes import (
    BEHIND, KEYWORD, LEADS, LINE, MARK_ABOVE, MARK_BELOW, MARK_WIDTH, OFFSET, O_DO, O_ENDSUB, O_IF, O_SUB, O_WHILE,
)  # fmt: skip

from cncgen.kernels.gcode_codes import KEYWORDS, LITERALS, LOOKS

#: Keywords as bits, by keyword from IF on: those that it looks for above, and below.
_ABOVE = cython.declare(cython.uint[15])
_BELOW = cython.declare(cython.uint[15])

_NOTHING: list = []


def bits_of(keywords) -> int:
    """Return keywords as bits, that of IF first."""
    return sum(1 << (LITERALS[keyword] - LITERALS["if"]) for keyword in keywords)


for _keyword, _number in KEYWORDS.items():
    _ABOVE[_number - O_IF], _BELOW[_number - O_IF] = map(bits_of, LOOKS.get(_keyword, ((), ())))


@cython.final
@cython.cclass
class Marks:
    """The marked lines of a text, numbered in their order.

    Args:
        found: Of each line its offset, its number, that of its keyword, its label (a number, a name, or what computes it), and the offset of
            the next line.

    Attributes:
        labels: Their labels.
        count: How many they are.
        computes: Whether a label is computed, so that what stands nearest hangs on the run.
        certain: Whether marks lead to the same ones in each run: none is computed, and each SUB has its ENDSUB, with no other one before it.
    """

    def __init__(self, found: list):
        m: cython.Py_ssize_t = 0
        keyword: cython.longlong
        self.labels, self.written, self.computed, self.borders, self.subs = [], {}, [], [], {}
        self.count = len(found)
        size = max(1, self.count)
        self.rows = memoryview(bytearray(8 * MARK_WIDTH * size)).cast("q", [size, MARK_WIDTH])
        # By the label of the subroutine and its own, the first that begins a branch or loop.
        begun: dict = {}
        owner = None
        self.certain = True
        for offset, line, keyword, label, after in found:
            self.rows[m, OFFSET], self.rows[m, LINE], self.rows[m, BEHIND] = offset, line, after
            self.rows[m, KEYWORD], self.rows[m, LEADS] = keyword, -1
            self.labels.append(label)
            if callable(label):
                self.computed.append(m)
            else:
                self.written.setdefault(label, []).append(m)
            if keyword == O_SUB or keyword == O_ENDSUB:
                self.borders.append(m)
                self.certain = self.certain and (owner is None if keyword == O_SUB else label == owner)
                owner = label if keyword == O_SUB else None
                if keyword == O_SUB:
                    self.subs.setdefault(label, m)
            elif keyword <= O_DO:
                first = begun.setdefault((owner, label), m)
                if first != m and not (keyword == O_WHILE and self._ends(first)):
                    # Whether that is a fault hangs on whether both run.
                    self.rows[m, LEADS] = self.rows[first, LEADS] = 0
            m += 1
        self.computes = len(self.computed) > 0
        self.certain = self.certain and owner is None and not self.computes

    def _ends(self, begin: cython.Py_ssize_t) -> bool:
        """Tell whether the last mark may be the WHILE of the loop that begins at one."""
        count: cython.Py_ssize_t = len(self.borders)
        return self.rows[begin, KEYWORD] == O_DO and (count == 0 or self.borders[count - 1] < begin)

    def mark(self, m: cython.Py_ssize_t) -> tuple:
        """Return label, keyword, offset and number of a line, and the offset behind it."""
        return self.labels[m], *(self.rows[m, column] for column in (KEYWORD, OFFSET, LINE, BEHIND))

    @cython.ccall
    @cython.exceptval(check=False)
    def behind(self, offset: cython.longlong) -> cython.Py_ssize_t:
        """Return the first mark at an offset or behind it."""
        low: cython.Py_ssize_t = 0
        high: cython.Py_ssize_t = self.count
        middle: cython.Py_ssize_t
        while low < high:
            middle = (low + high) // 2
            if self.rows[middle, OFFSET] < offset:
                low = middle + 1
            else:
                high = middle
        return low

    @cython.ccall
    @cython.exceptval(-2, check=False)
    def nearest(
        self,
        offset: cython.longlong,
        way: cython.int,
        label,
        keywords: cython.uint,
        over_borders: cython.bint,
        resolve,
    ) -> cython.Py_ssize_t:
        """Return the nearest mark of a label with one of the keywords (`bits_of`), -1 for none.

        Args:
            offset: Behind this offset, `way` 1, or before it, `way` -1.
            way: As told.
            label: The label.
            keywords: The keywords.
            over_borders: Whether it may stand in another subroutine; else up to the next SUB or ENDSUB.
            resolve: Gives the present value of a label.
        """
        place: cython.Py_ssize_t = self.behind(offset + 1) if way > 0 else self.behind(offset) - 1
        last: cython.Py_ssize_t = -1 if over_borders else self.border(place, way)
        found: cython.Py_ssize_t
        other: cython.Py_ssize_t
        if last < 0:
            last = self.count - 1 if way > 0 else 0
        found = self._nearest_of(self.written.get(label, _NOTHING), place, last, way, keywords, label, None)
        if not self.computes:
            return found
        last = last if found < 0 else found
        other = self._nearest_of(self.computed, place, last, way, keywords, label, resolve)
        return found if other < 0 else other

    @cython.cfunc
    @cython.exceptval(-2, check=False)
    def _nearest_of(
        self,
        row: list,
        place: cython.Py_ssize_t,
        last: cython.Py_ssize_t,
        way: cython.int,
        keywords: cython.uint,
        label,
        resolve,
    ) -> cython.Py_ssize_t:
        """Return the first such mark of a row from a place on up to the last one that it may be."""
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t
        k = _at(row, place) if way > 0 else _at(row, place + 1) - 1
        while 0 <= k < len(row):
            m = row[k]
            if (m - last) * way > 0:
                break
            if keywords >> (self.rows[m, KEYWORD] - O_IF) & 1 and (
                resolve is None or resolve(self.labels[m]) == label
            ):
                return m
            k += way
        return -1

    @cython.ccall
    @cython.exceptval(-2, check=False)
    def border(self, m: cython.Py_ssize_t, way: cython.int) -> cython.Py_ssize_t:
        """Return the first SUB or ENDSUB from a mark on, in a way as `nearest` has; -1 for none."""
        k: cython.Py_ssize_t = _at(self.borders, m) if way > 0 else _at(self.borders, m + 1) - 1
        return self.borders[k] if 0 <= k < len(self.borders) else -1

    @cython.ccall
    @cython.exceptval(-2, check=False)
    def subroutine(self, label) -> cython.Py_ssize_t:
        """Return the SUB that a call leads to, -1 where that is not certain."""
        m: cython.Py_ssize_t = self.subs.get(label, -1)
        if m >= 0:
            self.leads(m)
        return m if m >= 0 and self.rows[m, MARK_BELOW] >= 0 else -1

    @cython.ccall
    def leads(self, m: cython.Py_ssize_t) -> cython.bint:
        """Tell whether it is certain where a mark leads: then its marks `MARK_BELOW` and `MARK_ABOVE` are known."""
        if self.rows[m, LEADS] < 0:
            self.rows[m, LEADS] = self._judge(m)
        return self.rows[m, LEADS] > 0

    @cython.cfunc
    def _judge(self, m: cython.Py_ssize_t) -> cython.bint:
        """Look for what a mark leads to."""
        offset: cython.longlong = self.rows[m, OFFSET]
        keyword: cython.longlong = self.rows[m, KEYWORD]
        label = self.labels[m]
        above: cython.uint = _ABOVE[keyword - O_IF]
        below: cython.uint = _BELOW[keyword - O_IF]
        self.rows[m, MARK_ABOVE] = self.nearest(offset, -1, label, above, False, None) if above else -1
        self.rows[m, MARK_BELOW] = self.nearest(offset, 1, label, below, False, None) if below else -1
        if keyword == O_SUB:
            # The first one of its label counts.
            return self.subs[label] == m
        if keyword == O_WHILE:
            return self.rows[m, MARK_ABOVE] >= 0 or self.rows[m, MARK_BELOW] >= 0
        return (not above or self.rows[m, MARK_ABOVE] >= 0) and (not below or self.rows[m, MARK_BELOW] >= 0)


@cython.cfunc
@cython.inline
def _at(row: list, m: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return the place of the first number of a row that is at least `m`."""
    low: cython.Py_ssize_t = 0
    high: cython.Py_ssize_t = len(row)
    middle: cython.Py_ssize_t
    while low < high:
        middle = (low + high) // 2
        if cython.cast(cython.Py_ssize_t, row[middle]) < m:
            low = middle + 1
        else:
            high = middle
    return low
