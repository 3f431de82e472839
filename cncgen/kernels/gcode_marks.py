"""The O-words of a text, found in one pass: where each stands, its label and keyword, and the O-word that it leads to.

A row is made of each O-word whose label is written. Where a line may hold one that is not read for certain, none
are made, as a row could lead to the wrong line. `gcode_values` follows the rows; `cncgen.gcode.flow.o_words` defines the O-words.
"""

import cython

#: Columns of a row: byte offset and number of its line, offsets of the text behind the keyword and of the next line, keyword,
#: label, and the rows that it leads to (-1 where it leads nowhere for certain).
OFFSET, LINE, ARGUMENTS, AFTER, KEYWORD, LABEL, TARGET, OTHER = range(8)
WIDTH = 8
_OFFSET = cython.declare(cython.int, OFFSET)
_LINE = cython.declare(cython.int, LINE)
_ARGUMENTS = cython.declare(cython.int, ARGUMENTS)
_AFTER = cython.declare(cython.int, AFTER)
_KEYWORD = cython.declare(cython.int, KEYWORD)
_LABEL = cython.declare(cython.int, LABEL)
_TARGET = cython.declare(cython.int, TARGET)
_OTHER = cython.declare(cython.int, OTHER)

#: The keywords; the first four begin something, and claim their label.
KEYWORDS = {
    name: number
    for number, name in enumerate(
        (
            *("if", "while", "repeat", "do", "elseif", "else", "endif", "endwhile", "endrepeat"),
            *("break", "continue", "sub", "endsub", "return", "call"),
        )
    )
}
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
#: Letters of the longest keyword; digits of a label that is read here.
_LONGEST = cython.declare(cython.int, 9)
_DIGITS = cython.declare(cython.int, 9)


def _packed(name):
    """Return the letters of a word as a number, five bits each."""
    code = 0
    for letter in name:
        code = code << 5 | (ord(letter) & 31)
    return code


#: The keywords by their letters.
_BY_LETTERS = {_packed(name): number for name, number in KEYWORDS.items()}


@cython.cclass
class Marks:
    """The O-words of a text.

    Args:
        data: The text, bytes or a map of a file; `text` is the same as a buffer.

    Attributes:
        rows, count: The rows, and how many there are.
        labels: The label of each number: the float of a number, or a name.
        certain: Whether all were read. `computed` tells whether there are labels that are computed, which have no rows.
    """

    data = cython.declare(object)
    text: cython.const[cython.uchar][::1]
    store = cython.declare(object)
    table: cython.longlong[:, ::1]
    rows = cython.declare(object, visibility="public")
    count = cython.declare(cython.Py_ssize_t, visibility="public")
    labels = cython.declare(list, visibility="public")
    certain = cython.declare(cython.bint, visibility="public")
    computed = cython.declare(cython.bint, visibility="public")
    numbers = cython.declare(dict)
    i = cython.declare(cython.Py_ssize_t)

    def __init__(self, data, text):
        self.data = data
        self.text = text
        self.store = bytearray(8 * WIDTH * 64)
        self.count = 0
        self.labels = []
        self.numbers = {}
        self.certain = True
        self.computed = False
        self.i = 0
        self._grow()
        self._find()
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
    def _find(self) -> cython.void:
        """Find the lines that begin with an O-word."""
        offset: cython.Py_ssize_t = 0
        line: cython.longlong = 1
        length: cython.Py_ssize_t = self.text.shape[0]
        while offset < length and self.certain:
            self.i = offset
            if self._begins():
                if self.count == self.table.shape[0]:
                    self._grow()
                self._read(offset, line)
            while self.i < length and self.text[self.i] != 10:
                self.i += 1
            offset = self.i + 1
            line += 1

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _byte(self) -> cython.int:
        """Go on to the next byte that is not blank and return it; a newline at the end of the text."""
        c: cython.int
        while self.i < self.text.shape[0]:
            c = cython.cast(cython.int, self.text[self.i])
            if c != 32 and c != 9 and c != 13:
                return c
            self.i += 1
        return 10

    @cython.cfunc
    @cython.exceptval(check=False)
    def _begins(self) -> cython.bint:
        """Go past the O that a line begins with, behind a slash and a line number; tell whether there is one."""
        c: cython.int = self._byte()
        if c == 47:
            self.i += 1
            c = self._byte()
            if 49 <= c <= 57:
                self.i += 1
                c = self._byte()
        if c | 32 == 110:
            self.i += 1
            c = self._byte()
            while 48 <= c <= 57 or c == 46:
                self.i += 1
                c = self._byte()
        if c | 32 == 111:
            self.i += 1
            return True
        if c == 58 or c == 60:
            self.certain = False
        return False

    @cython.cfunc
    def _read(self, offset: cython.Py_ssize_t, line: cython.longlong) -> cython.void:
        """Read label and keyword of the O-word here."""
        label: cython.Py_ssize_t
        letters: cython.int = 0
        name: cython.longlong = 0
        row: cython.longlong[:, ::1] = self.table
        c: cython.int = self._byte()
        if c == 91 or c == 35:
            self.computed = True
            return
        label = self._label()
        c = self._byte()
        if not self.certain or c == 10 or c == 40 or c == 59:
            return
        while 97 <= (c | 32) <= 122 and letters < _LONGEST:
            name = name << 5 | (c & 31)
            letters += 1
            self.i += 1
            c = cython.cast(cython.int, self.text[self.i]) if self.i < self.text.shape[0] else 10
        keyword = _BY_LETTERS.get(name)
        if keyword is None or 97 <= (c | 32) <= 122:
            self.certain = False
            return
        row[self.count, _OFFSET] = offset
        row[self.count, _LINE] = line
        row[self.count, _ARGUMENTS] = self.i
        row[self.count, _KEYWORD] = keyword
        row[self.count, _LABEL] = label
        row[self.count, _TARGET] = row[self.count, _OTHER] = -1
        while self.i < self.text.shape[0] and self.text[self.i] != 10:
            self.i += 1
        row[self.count, _AFTER] = self.i + 1
        self.count += 1

    @cython.cfunc
    def _label(self) -> cython.Py_ssize_t:
        """Read a written label; return its number."""
        begin: cython.Py_ssize_t
        value: cython.longlong = 0
        digits: cython.int = 0
        c: cython.int = self._byte()
        if c == 60:
            begin = self.i + 1
            while self.i < self.text.shape[0] and self.text[self.i] != 62 and self.text[self.i] != 10:
                self.i += 1
            key: bytes = self.data[begin : self.i]
            self.i += 1
            number = self.numbers.get(key)
            if number is not None:
                return number
            self.certain = key.isascii() and key.translate(None, b" \t_-.").isalnum()
            if not self.certain:
                return 0
            label = key.translate(None, b" \t").lower().decode("ascii")
            if label.isdecimal():
                label = float(label)
            self.numbers[key] = self._numbered(label)
            return self.numbers[key]
        else:
            while 48 <= c <= 57:
                value = value * 10 + (c - 48)
                digits += 1
                if digits > _DIGITS:
                    break
                self.i += 1
                c = cython.cast(cython.int, self.text[self.i]) if self.i < self.text.shape[0] else 10
            if digits == 0 or digits > _DIGITS:
                self.certain = False
                return 0
            label = cython.cast(cython.double, value)
        return self._numbered(label)

    @cython.cfunc
    def _numbered(self, label) -> cython.Py_ssize_t:
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
        # By label, plus one: the last row of each keyword that begins something.
        last: cython.longlong[:, ::1] = self._by_label()
        begin: cython.Py_ssize_t = 0
        owner: cython.longlong = -1
        e: cython.Py_ssize_t
        label: cython.longlong
        keyword: cython.longlong
        opened: cython.longlong
        first: dict = {}
        for e in range(self.count):
            keyword, label = rows[e, _KEYWORD], rows[e, _LABEL]
            if keyword == _SUB or keyword == _ENDSUB:
                begin = e
                owner = label if keyword == _SUB else -1
            elif keyword <= _DO:
                if keyword == _WHILE and last[label, _DO] > begin:
                    rows[e, _OTHER] = last[label, _DO] - 1
                key = (owner, label)
                opened = first.setdefault(key, e)
                if opened != e and not (keyword == _WHILE and rows[e, _OTHER] == opened):
                    # Two begin with the same label: whether that is a fault hangs on whether both run. Neither is followed.
                    rows[e, _OTHER] = rows[opened, _OTHER] = -1
                    rows[e, _TARGET] = rows[opened, _TARGET] = -2
                last[label, keyword] = e + 1
            elif keyword == _ENDIF or keyword == _ELSE or keyword == _ELSEIF:
                rows[e, _TARGET] = last[label, _IF] - 1 if last[label, _IF] > begin else -1
            elif keyword == _ENDWHILE:
                rows[e, _TARGET] = last[label, _WHILE] - 1 if last[label, _WHILE] > begin else -1
            elif keyword == _ENDREPEAT:
                rows[e, _TARGET] = last[label, _REPEAT] - 1 if last[label, _REPEAT] > begin else -1

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
