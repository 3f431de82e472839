"""The O-words of a text, found in one pass: where each stands, its label and keyword, and the O-word that it leads to.

A row is made of each O-word whose label is written. Where the grammar refuses a line that may hold one, none
are made, as a row could lead to the wrong line. `gcode_run` follows the rows; `cncgen.gcode.flow.o_words` defines the O-words.
"""

import cython
from cython.cimports.cncgen.kernels.gcode_codes import (
    AT, BEHIND, CODE, COMPUTED_LABEL, FIRST_CONSTANT, HERE, KEYWORD, LABEL, LINE, MARK, MARKS, NUMBER_OF_LINE,
    OFFSET, OTHER, O_BREAK, O_CALL, O_CONTINUE, O_DO, O_ELSE, O_ELSEIF, O_ENDIF, O_ENDREPEAT, O_ENDSUB,
    O_ENDWHILE, O_IF, O_REPEAT, O_RETURN, O_SUB, O_WHILE, REFUSED, TARGET,
)  # fmt: skip
from cython.cimports.cncgen.kernels.gcode_lines import Code

from cncgen.kernels.gcode_lines import zeros

_WIDTH = 8
#: Bytes of a text that has room for one row to begin with, and rows then, at most; empty rows take no time.
_BYTES, _ROWS = 16, 65_536

#: Kinds of O-words that another one leads to: the next branch, ENDIF, ENDWHILE, ENDREPEAT, the end of a loop, ENDSUB; and the subroutine.
_BRANCH = cython.declare(cython.int, 0)
_END_OF_BRANCHES = cython.declare(cython.int, 1)
_END_OF_WHILE = cython.declare(cython.int, 2)
_END_OF_REPEAT = cython.declare(cython.int, 3)
_END_OF_LOOP = cython.declare(cython.int, 4)
_END_OF_SUB = cython.declare(cython.int, 5)
_SUBROUTINE = cython.declare(cython.int, 6)
#: By keyword from IF on: the kind that it leads to (-1 for none), and the kinds that it is, as bits.
_SOUGHT = cython.declare(cython.int[15])
_OFFERED = cython.declare(cython.int[15])


@cython.cfunc
def _fill_tables() -> cython.void:
    """Fill the tables of keywords, once."""
    k: cython.int
    for k in range(15):
        _SOUGHT[k], _OFFERED[k] = -1, 0
    _SOUGHT[O_IF - O_IF] = _BRANCH
    _SOUGHT[O_ELSE - O_IF] = _SOUGHT[O_ELSEIF - O_IF] = _END_OF_BRANCHES
    _SOUGHT[O_WHILE - O_IF], _SOUGHT[O_REPEAT - O_IF] = _END_OF_WHILE, _END_OF_REPEAT
    _SOUGHT[O_BREAK - O_IF] = _SOUGHT[O_CONTINUE - O_IF] = _END_OF_LOOP
    _OFFERED[O_ELSE - O_IF] = _OFFERED[O_ELSEIF - O_IF] = 1 << _BRANCH
    _OFFERED[O_ENDIF - O_IF] = 1 << _BRANCH | 1 << _END_OF_BRANCHES
    _OFFERED[O_WHILE - O_IF] = 1 << _END_OF_LOOP
    _OFFERED[O_ENDWHILE - O_IF] = 1 << _END_OF_LOOP | 1 << _END_OF_WHILE
    _OFFERED[O_ENDREPEAT - O_IF] = 1 << _END_OF_LOOP | 1 << _END_OF_REPEAT
    _OFFERED[O_ENDSUB - O_IF] = 1 << _END_OF_SUB


_fill_tables()


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _within(found: cython.longlong, border: cython.Py_ssize_t) -> cython.longlong:
    """Return a row that was found below, -1 where it is not within the border of the subroutine."""
    return found if found < border else -1


@cython.cclass
class Marks:
    """The O-words of a text.

    Args:
        lines: The lines of the text (`gcode_lines.Lines`), by LinuxCNC's grammar.
        size: Bytes of the text.

    Attributes:
        rows, count: The rows, and how many there are.
        used: How many lines are kept.
        labels: The label of each number: the float of a number, or a name.
        certain: Whether all were read. `computed` tells whether there are labels that are computed, which have no rows.
    """

    code = cython.declare(Code)
    kept: cython.longlong[:, ::1]
    table: cython.longlong[:, ::1]
    lines = cython.declare(object)
    rows = cython.declare(object, visibility="public")
    count = cython.declare(cython.Py_ssize_t, visibility="public")
    used = cython.declare(cython.Py_ssize_t, visibility="public")
    labels = cython.declare(list, visibility="public")
    certain = cython.declare(cython.bint, visibility="public")
    computed = cython.declare(cython.bint, visibility="public")
    numbers = cython.declare(dict)

    def __init__(self, lines, size):
        self.lines, self.kept = lines, lines.rows
        self.code = lines.code
        self.count = self.used = 0
        self.labels = []
        self.numbers = {}
        self.certain = True
        self.computed = False
        self._make_room(max(64, min(size // _BYTES, _ROWS)))
        self._find(size)
        if self.certain:
            self._lead_back()
            self._lead_on()

    @cython.cfunc
    def _make_room(self, most: cython.Py_ssize_t) -> cython.void:
        """Make room for so many rows, and keep the present ones."""
        before = self.rows
        self.rows = zeros(8 * _WIDTH * most).cast("q", [most, _WIDTH])
        if before is not None:
            self.rows.cast("B")[: 8 * _WIDTH * self.count] = before.cast("B")[: 8 * _WIDTH * self.count]
        self.table = self.rows

    @cython.cfunc
    def _find(self, size: cython.Py_ssize_t) -> cython.void:
        """Find the lines with an O-word; half of the rows at most stay with them."""
        lines = self.lines
        most: cython.Py_ssize_t = self.kept.shape[0] // 2
        offset: cython.Py_ssize_t = 0
        line: cython.longlong = 1
        first: cython.Py_ssize_t
        m: cython.Py_ssize_t
        while offset < size and self.certain:
            first = self.used
            self.used, offset, line = lines.compile_o_words(offset, line, first, most)
            for m in range(first, self.used):
                self._read(m)
            if self.used == most or not self.code.room():
                self.used = 0
                lines.forget()
                for m in range(self.count):
                    self.table[m, HERE] = -1

    @cython.cfunc
    def _read(self, r: cython.Py_ssize_t) -> cython.void:
        """Make a row of a line that is kept where it is an O-word."""
        at: cython.Py_ssize_t = self.kept[r, CODE]
        keyword: cython.int
        if self.kept[r, MARKS] & REFUSED:
            # Whether it is one, nobody can tell.
            self.certain = False
            return
        keyword = self.code.keyword(at)
        if not 0 < keyword <= O_CALL:
            return
        if self.kept[r, MARKS] & COMPUTED_LABEL:
            self.computed = True
            return
        if self.count == self.table.shape[0]:
            self._make_room(2 * self.count)
        rows: cython.longlong[:, ::1] = self.table
        rows[self.count, OFFSET] = self.kept[r, AT]
        rows[self.count, LINE] = self.kept[r, NUMBER_OF_LINE]
        rows[self.count, KEYWORD] = keyword
        rows[self.count, LABEL] = self._number_of(self.code.label(at, self.kept[r, FIRST_CONSTANT]))
        rows[self.count, HERE] = r
        rows[self.count, BEHIND] = rows[self.count, TARGET] = rows[self.count, OTHER] = -1
        self.kept[r, MARK] = self.count
        self.count += 1

    @cython.cfunc
    def _number_of(self, label) -> cython.Py_ssize_t:
        """Return the number of a label."""
        number = self.numbers.get(label)
        if number is None:
            number = self.numbers[label] = len(self.labels)
            self.labels.append(label)
        return number

    @cython.cfunc
    def _lead_back(self) -> cython.void:
        """Lead each O-word to the last one before it, of its label and subroutine, that it goes with."""
        rows: cython.longlong[:, ::1] = self.table
        # By label, plus one: the last row of each keyword that begins something; the first one of the main program; the first one of
        # a subroutine, and which that is.
        last: cython.longlong[:, ::1] = self._by_label()
        begin: cython.Py_ssize_t = 0
        owner: cython.longlong = 0
        e: cython.Py_ssize_t
        label: cython.longlong
        keyword: cython.longlong
        opened: cython.longlong
        begun: cython.longlong
        place: cython.int
        for e in range(self.count):
            keyword, label = rows[e, KEYWORD], rows[e, LABEL]
            if keyword == O_SUB or keyword == O_ENDSUB:
                begin = e
                owner = label + 1 if keyword == O_SUB else 0
            elif keyword <= O_DO:
                if keyword == O_WHILE and last[label, O_DO - O_IF] > begin:
                    rows[e, OTHER] = last[label, O_DO - O_IF] - 1
                place = 5 if owner else 4
                if owner and last[label, 6] != owner:
                    last[label, 5], last[label, 6] = 0, owner
                if last[label, place] == 0:
                    last[label, place] = e + 1
                opened = last[label, place] - 1
                if opened != e and not (keyword == O_WHILE and rows[e, OTHER] == opened):
                    # Two begin with the same label: whether that is a fault hangs on whether both run. Neither is followed.
                    rows[e, OTHER] = rows[opened, OTHER] = -1
                    rows[e, TARGET] = rows[opened, TARGET] = -2
                last[label, keyword - O_IF] = e + 1
            else:
                begun = -1
                if keyword == O_ENDIF or keyword == O_ELSE or keyword == O_ELSEIF:
                    begun = last[label, 0]
                elif keyword == O_ENDWHILE:
                    begun = last[label, O_WHILE - O_IF]
                elif keyword == O_ENDREPEAT:
                    begun = last[label, O_REPEAT - O_IF]
                if begun >= 0:
                    rows[e, TARGET] = begun - 1 if begun > begin else -1

    @cython.cfunc
    def _lead_on(self) -> cython.void:
        """Lead each O-word to the next one of its label and subroutine that it goes with, CALL to its subroutine."""
        rows: cython.longlong[:, ::1] = self.table
        # By label, plus one: the next O-word of each kind.
        following: cython.longlong[:, ::1] = self._by_label()
        border: cython.Py_ssize_t = self.count
        e: cython.Py_ssize_t
        kind: cython.int
        label: cython.longlong
        keyword: cython.longlong
        for e in range(self.count - 1, -1, -1):
            keyword, label = rows[e, KEYWORD], rows[e, LABEL]
            kind = _SOUGHT[keyword - O_IF]
            if kind >= 0:
                self._lead_to(e, following[label, kind] - 1, border)
                if kind == _END_OF_BRANCHES:
                    rows[e, OTHER] = _within(following[label, _BRANCH] - 1, border)
            elif rows[e, TARGET] == -1 and (keyword == O_DO or keyword == O_ENDSUB or keyword == O_RETURN):
                rows[e, TARGET] = e
            if keyword == O_SUB:
                if border < self.count and rows[border, KEYWORD] == O_ENDSUB:
                    rows[e, OTHER] = border if rows[border, LABEL] == label else -1
                # The first one of its label counts, where its end stands below.
                following[label, _SUBROUTINE] = e + 1 if following[label, _END_OF_SUB] else 0
            if keyword == O_SUB or keyword == O_ENDSUB:
                border = e
            for kind in range(_SUBROUTINE):
                if _OFFERED[keyword - O_IF] >> kind & 1:
                    following[label, kind] = e + 1
        self._lead_to_subroutines(following)

    @cython.cfunc
    def _lead_to(
        self, e: cython.Py_ssize_t, found: cython.longlong, border: cython.Py_ssize_t
    ) -> cython.void:
        """Lead an O-word to the one found below, -1 for none, before the border of its subroutine."""
        keyword: cython.longlong = self.table[e, KEYWORD]
        # Neither one of two that begin with the same label, nor a branch without its IF, is followed.
        if keyword <= O_DO and self.table[e, TARGET] == -2:
            found = -1
        elif (keyword == O_ELSE or keyword == O_ELSEIF) and self.table[e, TARGET] < 0:
            found = -1
        self.table[e, TARGET] = _within(found, border)

    @cython.cfunc
    def _lead_to_subroutines(self, following: cython.longlong[:, ::1]) -> cython.void:
        """Lead CALL to its subroutine, and SUB behind it."""
        rows: cython.longlong[:, ::1] = self.table
        e: cython.Py_ssize_t
        for e in range(self.count):
            if rows[e, KEYWORD] == O_CALL:
                rows[e, TARGET] = following[rows[e, LABEL], _SUBROUTINE] - 1
            elif rows[e, KEYWORD] == O_SUB and following[rows[e, LABEL], _SUBROUTINE] - 1 == e:
                # A definition is skipped: the first one of its label, with no other one within it.
                rows[e, TARGET] = rows[e, OTHER]

    @cython.cfunc
    def _by_label(self):
        """Return a table with a row of zeros for each label."""
        count = max(1, len(self.labels))
        return memoryview(bytearray(8 * _WIDTH * count)).cast("q", [count, _WIDTH])
