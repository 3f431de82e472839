"""The O-words of a text, found in one pass: where each stands, its label and keyword, and the O-word that it leads to.

A row is made of each O-word whose label is written. Where the grammar refuses a line that may hold one, none
are made, as a row could lead to the wrong line. `gcode_run` follows the rows; `cncgen.gcode.flow.o_words` defines the O-words.
"""

import cython

from cncgen.kernels.gcode_codes import COMPUTED_LABEL, LITERALS, OPERATIONS, REFUSED

#: Columns of a row: byte offset and number of its line, the rows that `gcode_run` has of it and of the next line (-1 for none yet),
#: keyword, label, and the rows that it leads to (-1 where it leads nowhere for certain).
OFFSET, LINE, HERE, BEHIND, KEYWORD, LABEL, TARGET, OTHER = range(8)
WIDTH = 8
_OFFSET = cython.declare(cython.int, OFFSET)
_LINE = cython.declare(cython.int, LINE)
_HERE = cython.declare(cython.int, HERE)
_BEHIND = cython.declare(cython.int, BEHIND)
_KEYWORD = cython.declare(cython.int, KEYWORD)
_LABEL = cython.declare(cython.int, LABEL)
_TARGET = cython.declare(cython.int, TARGET)
_OTHER = cython.declare(cython.int, OTHER)

#: The keywords by their literals in the grammar; the first four begin something, and claim their label.
KEYWORDS = {name: number for name, number in LITERALS.items() if LITERALS["if"] <= number <= LITERALS["call"]}
_IF = cython.declare(cython.int, KEYWORDS["if"])
_WHILE = cython.declare(cython.int, KEYWORDS["while"])
_REPEAT = cython.declare(cython.int, KEYWORDS["repeat"])
_DO = cython.declare(cython.int, KEYWORDS["do"])
_ELSEIF = cython.declare(cython.int, KEYWORDS["elseif"])
_ELSE = cython.declare(cython.int, KEYWORDS["else"])
_ENDIF = cython.declare(cython.int, KEYWORDS["endif"])
_ENDWHILE = cython.declare(cython.int, KEYWORDS["endwhile"])
_ENDREPEAT = cython.declare(cython.int, KEYWORDS["endrepeat"])
_BREAK = cython.declare(cython.int, KEYWORDS["break"])
_CONTINUE = cython.declare(cython.int, KEYWORDS["continue"])
_SUB = cython.declare(cython.int, KEYWORDS["sub"])
_ENDSUB = cython.declare(cython.int, KEYWORDS["endsub"])
_RETURN = cython.declare(cython.int, KEYWORDS["return"])
_CALL = cython.declare(cython.int, KEYWORDS["call"])
_FLOW = cython.declare(cython.int, OPERATIONS["FLOW"])
_NAME = cython.declare(cython.int, OPERATIONS["NAME"])
_COMMENT = cython.declare(cython.int, OPERATIONS["COMMENT"])
_MESSAGE = cython.declare(cython.int, OPERATIONS["MESSAGE"])
_REFUSED = cython.declare(cython.int, REFUSED)
_COMPUTED_LABEL = cython.declare(cython.int, COMPUTED_LABEL)


@cython.cclass
class Marks:
    """The O-words of a text.

    Args:
        parser: A `gcode_parse.Parser` of LinuxCNC's grammar that has taken a text and `kept`, the rows of its lines.

    Attributes:
        rows, count: The rows, and how many there are.
        used: How many lines are kept.
        labels: The label of each number: the float of a number, or a name.
        certain: Whether all were read. `computed` tells whether there are labels that are computed, which have no rows.
    """

    code: cython.const[cython.int][::1]
    constants: cython.const[cython.double][::1]
    kept: cython.longlong[:, ::1]
    table: cython.longlong[:, ::1]
    parser = cython.declare(object)
    store = cython.declare(object)
    rows = cython.declare(object, visibility="public")
    count = cython.declare(cython.Py_ssize_t, visibility="public")
    used = cython.declare(cython.Py_ssize_t, visibility="public")
    labels = cython.declare(list, visibility="public")
    certain = cython.declare(cython.bint, visibility="public")
    computed = cython.declare(cython.bint, visibility="public")
    numbers = cython.declare(dict)

    def __init__(self, parser, kept, size):
        self.code, self.constants, self.kept, self.parser = parser.code, parser.constants, kept, parser
        self.store = bytearray(8 * WIDTH * 64)
        self.count = self.used = 0
        self.labels = []
        self.numbers = {}
        self.certain = True
        self.computed = False
        self._grow()
        self._find(size)
        if self.certain:
            self._lead_back()
            self._lead_on()

    @cython.cfunc
    def _grow(self) -> cython.void:
        """Make room for twice as many rows."""
        self.store = self.store + bytes(len(self.store))
        self.rows = memoryview(self.store).cast("q", [len(self.store) // (8 * WIDTH), WIDTH])
        self.table = self.rows

    @cython.cfunc
    def _find(self, size: cython.Py_ssize_t) -> cython.void:
        """Find the lines with an O-word; half of the rows at most stay with them."""
        parser = self.parser
        most: cython.Py_ssize_t = self.kept.shape[0] // 2
        offset: cython.Py_ssize_t = 0
        line: cython.longlong = 1
        first: cython.Py_ssize_t
        m: cython.Py_ssize_t
        while offset < size and self.certain:
            first = self.used
            self.used, offset, line = parser.compile_o_words(offset, line, first, most)
            for m in range(first, self.used):
                self._read(m)
            if self.used == most or not parser.room():
                self.used = 0
                parser.forget()
                for m in range(self.count):
                    self.table[m, _HERE] = -1

    @cython.cfunc
    def _read(self, r: cython.Py_ssize_t) -> cython.void:
        """Make a row of a line that is kept where it is an O-word."""
        at: cython.Py_ssize_t = self.kept[r, 2]
        first: cython.int = self.code[at]
        if self.kept[r, 5] & _REFUSED:
            # Whether it is one, nobody can tell.
            self.certain = False
            return
        while self.code[at] != 0 and self.code[at] & 255 != _FLOW:
            at += 1 if self.code[at] & 255 != _COMMENT and self.code[at] & 255 != _MESSAGE else 2
        if self.code[at] == 0 or self.code[at] >> 8 > _CALL:
            return
        if self.kept[r, 5] & _COMPUTED_LABEL:
            self.computed = True
            return
        if self.count == self.table.shape[0]:
            self._grow()
        rows: cython.longlong[:, ::1] = self.table
        rows[self.count, _OFFSET] = self.kept[r, 0]
        rows[self.count, _LINE] = self.kept[r, 1]
        rows[self.count, _KEYWORD] = self.code[at] >> 8
        rows[self.count, _LABEL] = self._label(first, self.kept[r, 7])
        rows[self.count, _HERE] = r
        rows[self.count, _BEHIND] = rows[self.count, _TARGET] = rows[self.count, _OTHER] = -1
        self.kept[r, 6] = self.count
        self.count += 1

    @cython.cfunc
    def _label(self, first: cython.int, constants: cython.longlong) -> cython.Py_ssize_t:
        """Return the number of a label, which an instruction pushes; the constants of the line begin at `constants`."""
        label = (
            self.parser.names[first >> 8]
            if first & 255 == _NAME
            else self.constants[constants + (first >> 8)]
        )
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
        place: cython.int
        for e in range(self.count):
            keyword, label = rows[e, _KEYWORD], rows[e, _LABEL]
            if keyword == _SUB or keyword == _ENDSUB:
                begin = e
                owner = label + 1 if keyword == _SUB else 0
            elif keyword <= _DO:
                if keyword == _WHILE and last[label, _DO - _IF] > begin:
                    rows[e, _OTHER] = last[label, _DO - _IF] - 1
                place = 5 if owner else 4
                if owner and last[label, 6] != owner:
                    last[label, 5], last[label, 6] = 0, owner
                if last[label, place] == 0:
                    last[label, place] = e + 1
                opened = last[label, place] - 1
                if opened != e and not (keyword == _WHILE and rows[e, _OTHER] == opened):
                    # Two begin with the same label: whether that is a fault hangs on whether both run. Neither is followed.
                    rows[e, _OTHER] = rows[opened, _OTHER] = -1
                    rows[e, _TARGET] = rows[opened, _TARGET] = -2
                last[label, keyword - _IF] = e + 1
            elif keyword == _ENDIF or keyword == _ELSE or keyword == _ELSEIF:
                rows[e, _TARGET] = last[label, _IF - _IF] - 1 if last[label, _IF - _IF] > begin else -1
            elif keyword == _ENDWHILE:
                rows[e, _TARGET] = last[label, _WHILE - _IF] - 1 if last[label, _WHILE - _IF] > begin else -1
            elif keyword == _ENDREPEAT:
                rows[e, _TARGET] = (
                    last[label, _REPEAT - _IF] - 1 if last[label, _REPEAT - _IF] > begin else -1
                )

    @cython.cfunc
    def _lead_on(self) -> cython.void:
        """Lead each O-word to the next one of its label and subroutine that it goes with, CALL to its subroutine."""
        rows: cython.longlong[:, ::1] = self.table
        # By label, plus one: the next branch, ENDIF, ENDWHILE, ENDREPEAT, end of a loop, ENDSUB, and the subroutine.
        branch: cython.longlong[:, ::1] = self._by_label()
        border: cython.Py_ssize_t = self.count
        e: cython.Py_ssize_t
        label: cython.longlong
        keyword: cython.longlong
        found: cython.longlong
        kind: cython.int
        for e in range(self.count - 1, -1, -1):
            keyword, label = rows[e, _KEYWORD], rows[e, _LABEL]
            kind = -1
            if keyword == _IF:
                kind = 0
            elif keyword == _ELSE or keyword == _ELSEIF:
                kind = 1
                if branch[label, 0] and branch[label, 0] - 1 < border:
                    rows[e, _OTHER] = branch[label, 0] - 1
            elif keyword == _WHILE:
                kind = 2
            elif keyword == _REPEAT:
                kind = 3
            elif keyword == _BREAK or keyword == _CONTINUE:
                kind = 4
            elif rows[e, _TARGET] == -1 and (keyword == _DO or keyword == _ENDSUB or keyword == _RETURN):
                rows[e, _TARGET] = e
            if kind >= 0:
                found = branch[label, kind] - 1
                if found >= border:
                    found = -1
                if keyword <= _DO and rows[e, _TARGET] == -2:
                    found = -1
                elif (keyword == _ELSE or keyword == _ELSEIF) and rows[e, _TARGET] < 0:
                    found = -1
                rows[e, _TARGET] = found
            if keyword == _SUB and border < self.count and rows[border, _KEYWORD] == _ENDSUB:
                rows[e, _OTHER] = border if rows[border, _LABEL] == label else -1
            if keyword == _SUB or keyword == _ENDSUB:
                border = e
            if keyword == _SUB:
                # The first one of its label counts, where its end stands below.
                branch[label, 6] = e + 1 if branch[label, 5] else 0
            elif keyword == _ENDSUB:
                branch[label, 5] = e + 1
            elif keyword == _ELSEIF or keyword == _ELSE or keyword == _ENDIF:
                branch[label, 0] = e + 1
                if keyword == _ENDIF:
                    branch[label, 1] = e + 1
            elif keyword == _ENDWHILE or keyword == _ENDREPEAT or keyword == _WHILE:
                branch[label, 4] = e + 1
                if keyword == _ENDWHILE:
                    branch[label, 2] = e + 1
                elif keyword == _ENDREPEAT:
                    branch[label, 3] = e + 1
        for e in range(self.count):
            if rows[e, _KEYWORD] == _CALL:
                rows[e, _TARGET] = branch[rows[e, _LABEL], 6] - 1
            elif rows[e, _KEYWORD] == _SUB and branch[rows[e, _LABEL], 6] - 1 == e:
                # A definition is skipped: the first one of its label, with no other one within it.
                rows[e, _TARGET] = rows[e, _OTHER]

    @cython.cfunc
    def _by_label(self):
        """Return a table with a row of zeros for each label."""
        count = max(1, len(self.labels))
        return memoryview(bytearray(8 * WIDTH * count)).cast("q", [count, WIDTH])
