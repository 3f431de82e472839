# cython: infer_types=True
"""Lines that are kept as instructions, by their shape: their text without numbers, ``g# x[# + # * sin[#]]`` of ``G1 X[5 + 3.2 * SIN[30]]``.

To the tables of a grammar all digits are one, and it does not matter how many stand together (``lalr.py`` sees to that). So lines of
one shape have the same instructions, and push other numbers. The first line of a shape is read by the tables (`gcode_parse.Parser`), and
of those that follow the numbers alone, which takes a sixth of the time. Lines come in turns, mostly: a line is compared with the shape
that followed the last one's before, and others are found by a sum over their shape.
"""

from mmap import mmap

import cython
from cython.cimports.cncgen.kernels.decimals import Numbers, is_blank
from cython.cimports.cncgen.kernels.gcode_codes import (
    AFTER, AT, CODE, COMPUTED_LABEL, END, FIRST_CONSTANT, FOLLOWING, GOTO, LETTERS, MARK, MARKS, MAX_LINE, NAME,
    NEGATIVE, NUMBER, NUMBER_OF_LINE, O_CALL, O_RETURN, REFUSED, ROW, SAYS,
    SHAPE_CODE, SHAPE_DIGIT, SHAPE_DOTTED, SHAPE_LENGTH, SHAPE_LINE_END, SHAPE_MARKS, SHAPE_NEXT, SHAPE_PLACE, SHAPE_POINT_FIRST,
    SHAPE_ROW, SHAPE_SUM, SHAPE_UNKNOWN, SHAPE_WHOLE,
)  # fmt: skip
from cython.cimports.cncgen.kernels.grammar_tables import Tables
from cython.cimports.libc.math import copysign, fabs

#: Symbols of a line on the stack, at most: each byte of the longest line, with nothing before it.
_DEEPEST = cython.declare(cython.Py_ssize_t, 131_100)
#: Longest line, shapes, and bytes of them that are kept.
_LONGEST = cython.declare(cython.Py_ssize_t, 240)
_SHAPES = cython.declare(cython.Py_ssize_t, 512)
_STORE = cython.declare(cython.Py_ssize_t, 1 << 16)
#: Sums have 32 bits.
_ALL = cython.declare(cython.uint, 0xFFFFFFFF)
#: The character that stands for any blank.
_BLANK = cython.declare(cython.int, 32)
#: By byte: its kind in a shape; small letters and signs stand for themselves.
_FOLD = cython.declare(cython.uchar[256])
#: The same with digits as they stand.
_PLAIN = cython.declare(cython.uchar[256])


@cython.cfunc
def _fill_tables() -> cython.void:
    """Fill the tables of bytes, once."""
    c: cython.int
    for c in range(256):
        # Comments and bytes beyond ASCII are not taken.
        _FOLD[c] = c if 32 < c < 127 and c != 40 and c != 41 and c != 59 else SHAPE_UNKNOWN
    for c in range(65, 91):
        _FOLD[c] = c + 32
    for c in b" \t\r":
        _FOLD[c] = _BLANK
    _FOLD[10] = SHAPE_LINE_END
    for c in range(256):
        _PLAIN[c] = _FOLD[c]
    for c in b"0123456789.":
        _FOLD[c] = SHAPE_DIGIT


_fill_tables()

_NAN = cython.declare(cython.double, float("nan"))


def zeros(size):
    """Return a buffer; pages of it that are not filled take no time.

    Raises:
        MemoryError: There is not enough.
    """
    try:
        return memoryview(mmap(-1, size))
    except OSError as error:
        raise MemoryError from error


@cython.cclass
class Code(Tables):
    """The run of a grammar's tables over lines that writes instructions, and what stands of them: all that a text's lines have in common.

    Args:
        tables: A module of tables (``grammars/tables_*.py``).
        works: The work of each rule, by alias or name; `other` is that of all others.

    Attributes:
        text: The text of the line read last, which begins at `begin`.
        code, constants: Instructions, and the numbers that they push.
        used, numbers: How much of them is in use; whoever keeps a line begins the next one behind it. Those of a line are numbered
            from its first one on, `base`.
        names: Names of parameters, variables and labels by their number.
        flags: `DELETED`, `NUMBERED`, or `SAYS` and letters of words, of the line read last.
        number_begin, number_end: Where its N word stands.
        error: Offset where the grammar refused it, -1 where it did not.
        lines: How many lines were read.
        shaped: Whether lines of one shape have one code.
        fixed: Letters behind which digits are of the shape, beside #.
        comma: Whether a comma is a decimal sign.
        tokens: Reads the numbers of tokens.
        remarks: Whether a semicolon begins a comment that says nothing, unless it has a ~.
        alike: Whether the code of the line read last is that of its shape, where it was set before.
        made: The work of each rule.
        begins, ends, codes: By place on the stack: where the symbol begins and ends, and its code begins.
    """

    def __init__(self, tables, works: dict, other: int):
        Tables.__init__(self, tables)
        self.made = memoryview(bytearray(4 * len(tables.RULES))).cast("i")
        for k, (name, _, _) in enumerate(tables.RULES):
            self.made[k] = works.get(name, other)
        self.begins, self.ends = zeros(8 * _DEEPEST).cast("q"), zeros(8 * _DEEPEST).cast("q")
        self.codes = zeros(4 * _DEEPEST).cast("i")
        self.code = zeros(4 << 20).cast("i")
        self.constants = zeros(8 << 19).cast("d")
        self.names, self.numbered = [], {}
        self.used = self.numbers = self.base = self.lines = self.flags = 0
        self.begin = self.number_begin = self.number_end = 0
        self.error = -1
        self.tokens = Numbers(b"", True, True)
        self.shaped = self.alike = self.comma = self.remarks = False
        self.fixed = b""

    @cython.ccall
    @cython.exceptval(check=False)
    def room(self) -> cython.bint:
        """Tell whether another line has room for its code."""
        return (
            self.used + 4 * MAX_LINE < self.code.shape[0]
            and self.numbers + MAX_LINE < self.constants.shape[0]
        )

    def parse(self, text: cython.const[cython.uchar][::1], offset: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Read the line at `offset` of a text, as `read`."""
        self.text = text
        return self.read(offset)

    @cython.cfunc
    def read(self, offset: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Read the line at `offset` of `text`, its code into `code` from `used` on; return the offset of its end.

        `error` tells whether it is one of the grammar. Where it is, `used` and `numbers` stand behind its code.
        """
        used: cython.int = self.used
        end: cython.Py_ssize_t = offset
        # A line that is longer than any is refused there.
        most: cython.Py_ssize_t = offset + MAX_LINE
        while end < self.text.shape[0] and self.text[end] != 10:
            end += 1
        self.lines += 1
        self.begin = self.refused = offset
        self.base, self.flags, self.error = self.numbers, 0, -1
        if self.write(offset, min(end, most)) and end <= most:
            self.emit(END, 0)
            return end
        self.error = self.refused if end <= most else most
        self.used, self.numbers = used, self.base
        return end

    @cython.cfunc
    def write(self, at: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.int:
        """Write the code of the line between two offsets; return 0 where it is refused."""
        return self.run(at, end)

    @cython.cfunc
    @cython.exceptval(check=False)
    def emit(self, operation: cython.int, operand: cython.int) -> cython.void:
        """Write an instruction."""
        self.code[self.used] = operation + 256 * operand
        self.used += 1

    @cython.cfunc
    @cython.exceptval(check=False)
    def push(self, value: cython.double) -> cython.int:
        """Write the instruction that pushes a number; return 0 where that is NaN."""
        self.constants[self.numbers] = value
        self.code[self.used] = NUMBER + 256 * (self.numbers - self.base)
        self.numbers += 1
        self.used += 1
        return value == value

    @cython.cfunc
    @cython.exceptval(check=False)
    def negate(self, k: cython.int) -> cython.void:
        """Write the sign of the value of the symbol `k`, which is on top; that of a number is the number's."""
        last: cython.int = self.used - 1
        if self.code[last] & 255 == NUMBER and last == self.codes[k]:
            self.constants[self.numbers - 1] = -self.constants[self.numbers - 1]
        elif self.code[last] == NEGATIVE:
            self.used -= 1
        else:
            self.emit(NEGATIVE, 0)

    @cython.ccall
    def label(self, at: cython.Py_ssize_t, constants: cython.Py_ssize_t):
        """Return the written label of an O-word, a name or a number, which its first instruction pushes.

        Its code begins at `at`, the numbers that it pushes at `constants`.
        """
        operand: cython.int = self.code[at] >> 8
        return self.names[operand] if self.code[at] & 255 == NAME else self.constants[constants + operand]

    @cython.cfunc
    @cython.exceptval(check=False)
    def small(self, at: cython.Py_ssize_t) -> cython.int:
        """Return the byte at an offset, a letter as a small one."""
        c: cython.int = self.text[at]
        return c | 32 if 65 <= c <= 90 else c

    @cython.cfunc
    @cython.exceptval(check=False)
    def number(self, at: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.double:
        """Return the number of a token: signs, digits with at most one point or comma, blanks; NaN where it is not certain."""
        negative: cython.bint = False
        while at < end and (is_blank(self.text[at]) or self.text[at] == 43 or self.text[at] == 45):
            negative = negative or self.text[at] == 45
            at += 1
        self.tokens.text = self.text
        if self.tokens.read(at, end) < end:
            return _NAN
        return -self.tokens.value if negative else self.tokens.value

    @cython.cfunc
    def name_number(self, name: str) -> cython.int:
        """Return the number of a name."""
        found = self.numbered.get(name)
        if found is None:
            found = self.numbered[name] = len(self.names)
            self.names.append(name)
        return found

    @cython.ccall
    @cython.exceptval(check=False)
    def cut(self) -> cython.Py_ssize_t:
        """Return the offset of the slash that the last line was refused for behind its words, not within brackets; else 0."""
        inside: cython.Py_ssize_t = 0
        written: cython.bint = False
        if self.error < 0 or self.error >= self.text.shape[0] or self.text[self.error] != 47:
            return 0
        for at in range(self.begin, self.error):
            inside += (self.text[at] == 91) - (self.text[at] == 93)
            written = written or self.text[at] > 32
        return self.error if written and inside == 0 else 0


@cython.final
@cython.cclass
class Shapes:
    """The shapes of a text that are known, and the line that was looked at last; `row` is that of its shape, -1 for none.

    Args:
        text: The text.
        fixed, comma, remarks: As those of `Code`.
    """

    text: cython.const[cython.uchar][::1]
    fixed = cython.declare(cython.uchar[256])
    numbers = cython.declare(Numbers)
    remarks = cython.declare(cython.bint)
    form = cython.declare(cython.int)
    shape = cython.declare(cython.uchar[256])
    value = cython.declare(cython.double[256])
    sum = cython.declare(cython.uint)
    length = cython.declare(cython.Py_ssize_t)
    count = cython.declare(cython.Py_ssize_t)
    stored = cython.declare(cython.Py_ssize_t)
    row = cython.declare(cython.Py_ssize_t)
    store: cython.uchar[::1]
    table: cython.longlong[:, ::1]

    def __init__(self, text, fixed: bytes, comma: bool, remarks: bool):
        k: cython.int
        self.text = text
        if not cython.compiled:
            self.shape, self.value, self.fixed = bytearray(256), [0.0] * 256, bytearray(256)
        for k in range(256):
            self.fixed[k] = k == 35 or k in fixed
        self.numbers = Numbers(text, comma, False)
        self.remarks = remarks
        self.store = bytearray(_STORE)
        self.table = memoryview(bytearray(8 * SHAPE_ROW * _SHAPES)).cast("q", [_SHAPES, SHAPE_ROW])
        self.forget()

    @cython.cfunc
    @cython.exceptval(check=False)
    def forget(self) -> cython.void:
        """Forget all shapes."""
        self.sum = self.length = self.count = self.stored = 0
        self.row = -1
        for k in range(_SHAPES):
            self.table[k, SHAPE_PLACE] = -1

    @cython.cfunc
    @cython.exceptval(check=False)
    def match(self, at: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Take the numbers of the line at `at` where it has the shape that is expected; return the offset of its end, -1 where not."""
        row: cython.Py_ssize_t = self.table[self.row, SHAPE_NEXT] if self.row >= 0 else -1
        place: cython.Py_ssize_t = self.table[row, SHAPE_PLACE] if row >= 0 else -1
        if place < 0:
            return -1
        end: cython.Py_ssize_t = self.text.shape[0]
        size: cython.Py_ssize_t = min(end, at + _LONGEST)
        length: cython.Py_ssize_t = self.table[row, SHAPE_LENGTH]
        count: cython.Py_ssize_t = 0
        wanted: cython.int
        # No symbol is shorter than a byte, so that what is left need not be asked of at each.
        if size - at < length:
            return -1
        for k in range(place, place + length):
            wanted = self.store[k]
            if wanted > SHAPE_POINT_FIRST:
                if _PLAIN[self.text[at]] != wanted:
                    return -1
                at += 1
            else:
                at = self._number(at, size, count)
                if self.form != wanted or size - at < place + length - k - 1:
                    return -1
                count += self._is_pushed(place, k)
        if at < end and self.text[at] != 10:
            at = self._remark(at)
        if at >= 0:
            self.count, self.row = count, row
        return at

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _is_pushed(self, place: cython.Py_ssize_t, k: cython.Py_ssize_t) -> cython.bint:
        """Tell whether the number at `k` of the shape that is kept from `place` on is pushed: not that of the line, with N or without."""
        k -= 1
        while k >= place and self.store[k] == _BLANK:
            k -= 1
        return k >= place and self.store[k] != 110

    @cython.cfunc
    @cython.exceptval(check=False)
    def _remark(self, at: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Return the end of the comment at `at`; -1 where there is none that says nothing."""
        if not self.remarks or self.text[at] != 59:
            return -1
        while at < self.text.shape[0] and self.text[at] != 10:
            if self.text[at] == 126:
                return -1
            at += 1
        return at

    @cython.cfunc
    @cython.exceptval(check=False)
    def read(self, at: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Take shape and numbers of the line at `at`; return the offset of its end, -1 where they are not certain.

        Names and the numbers of parameters (#1) belong to the shape. That of the line, with N or without, is none that is pushed.
        """
        end: cython.Py_ssize_t = self.text.shape[0]
        size: cython.Py_ssize_t = min(end, at + _LONGEST)
        length: cython.Py_ssize_t = 0
        count: cython.Py_ssize_t = 0
        total: cython.uint = 0
        last: cython.int = 0
        named: cython.bint = False
        leads: cython.bint = False
        while at < size:
            c = _FOLD[self.text[at]]
            if c > SHAPE_POINT_FIRST:
                at += 1
                if c != _BLANK:
                    leads = last == 0
                    last = c
                if c | 2 == 62:
                    # A name begins with < and ends with >.
                    named = c == 60
            elif c == SHAPE_LINE_END:
                break
            elif c == SHAPE_UNKNOWN:
                at = self._remark(at)
                break
            elif named or (self.fixed[last] and not (last == 110 and leads)):
                c = self.text[at]
                at += 1
            else:
                at = self._number(at, size, count)
                c = self.form
                if c == 0:
                    return -1
                count += last != 110 and last != 0
                last = c
            total = total * 33 + c
            self.shape[length] = c
            length += 1
        if at < 0 or (at == size and at < end and self.text[at] != 10):
            return -1
        self.sum, self.length, self.count = total & _ALL, length, count
        return at

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _number(
        self, at: cython.Py_ssize_t, size: cython.Py_ssize_t, count: cython.Py_ssize_t
    ) -> cython.Py_ssize_t:
        """Take the number without a sign at `at` as the value `count`; return the offset behind it.

        `form` is 0 where it is not certain.
        """
        after: cython.Py_ssize_t = self.numbers.read(at, size)
        value: cython.double = self.numbers.value
        self.value[count] = value
        if value != value or (after < size and self.text[after] == 46):
            self.form = 0
        elif self.text[at] == 46:
            self.form = SHAPE_POINT_FIRST
        else:
            self.form = SHAPE_WHOLE if self.numbers.decimals < 0 else SHAPE_DOTTED
        return after

    @cython.cfunc
    @cython.exceptval(check=False)
    def find(self) -> cython.Py_ssize_t:
        """Return the row of the shape of the line; -1 where it is not known."""
        row: cython.Py_ssize_t = self.sum % _SHAPES
        place: cython.Py_ssize_t = self.table[row, SHAPE_PLACE]
        if (
            place < 0
            or self.table[row, SHAPE_SUM] != self.sum
            or self.table[row, SHAPE_LENGTH] != self.length
        ):
            return -1
        for k in range(self.length):
            if self.store[place + k] != self.shape[k]:
                return -1
        self._follow(row)
        return row

    @cython.cfunc
    @cython.exceptval(check=False)
    def _follow(self, row: cython.Py_ssize_t) -> cython.void:
        """Say that the line has the shape of a row, which is expected behind the last one's from now on."""
        if self.row >= 0:
            self.table[self.row, SHAPE_NEXT] = row
        self.row = row

    @cython.cfunc
    @cython.exceptval(check=False)
    def put(self, constants: cython.double[::1], first: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Write the numbers of the line, whose shape is known, as constants from `first` on; return how many."""
        signs: cython.Py_ssize_t = self.table[self.row, SHAPE_PLACE] + self.table[self.row, SHAPE_LENGTH]
        for k in range(self.count):
            constants[first + k] = -self.value[k] if self.store[signs + k] else self.value[k]
        return self.count

    @cython.cfunc
    @cython.exceptval(check=False)
    def keep(
        self,
        code: cython.longlong,
        marks: cython.longlong,
        constants: cython.double[::1],
        first: cython.Py_ssize_t,
        end: cython.Py_ssize_t,
    ) -> cython.void:
        """Keep the shape of the line, which the tables have read: where its code begins, its marks, and the constants that it pushes.

        It is not kept where the constants are not the numbers of the line, one by one.
        """
        row: cython.Py_ssize_t = self.sum % _SHAPES
        place: cython.Py_ssize_t = self.stored
        if end - first != self.count:
            return
        for k in range(self.count):
            if fabs(constants[first + k]) != self.value[k]:
                return
        if place + self.length + self.count > _STORE:
            self.stored = place = 0
            self.row = -1
            for k in range(_SHAPES):
                self.table[k, SHAPE_PLACE] = -1
        for k in range(self.length):
            self.store[place + k] = self.shape[k]
        for k in range(self.count):
            self.store[place + self.length + k] = copysign(1.0, constants[first + k]) < 0.0
        self.stored = place + self.length + self.count
        self.table[row, SHAPE_SUM], self.table[row, SHAPE_PLACE] = self.sum, place
        self.table[row, SHAPE_LENGTH], self.table[row, SHAPE_CODE], self.table[row, SHAPE_MARKS] = (
            self.length,
            code,
            marks,
        )
        # As long as nothing else is known, it is expected again.
        self.table[row, SHAPE_NEXT] = row
        self._follow(row)


@cython.final
@cython.cclass
class Lines:
    """The lines of a text that are kept, in rows of `gcode_codes.LINE_COLUMNS`. Lines of one shape have their code in common.

    Args:
        code: Reads lines, and holds the code of them all; nobody else uses it.
        text: The text.
        rows: The rows, filled; one without that, for the line that was read last.
    """

    code = cython.declare(Code, visibility="public")
    rows = cython.declare(cython.longlong[:, ::1], visibility="public")
    text: cython.const[cython.uchar][::1]
    shapes = cython.declare(Shapes)

    def __init__(self, code, text, rows=None):
        self.code, self.text = code, text
        self.rows = memoryview(bytearray(8 * ROW)).cast("q", [1, ROW]) if rows is None else rows
        self.code.text = text
        self.shapes = Shapes(text, code.fixed, code.comma, code.remarks)
        self.forget()

    @cython.ccall
    def forget(self):
        """Begin again with code, constants and shapes; rows that are kept are worth nothing from now on."""
        self.code.used = self.code.numbers = 0
        self.shapes.forget()

    def compile(
        self,
        offset: cython.Py_ssize_t,
        line: cython.longlong,
        first: cython.Py_ssize_t,
        last: cython.Py_ssize_t,
        end: cython.Py_ssize_t,
    ) -> cython.Py_ssize_t:
        """Keep lines from `offset` on, not beyond `end`, in rows from `first` to `last`, while there is room; return the next row."""
        r: cython.Py_ssize_t = first
        while r < last and offset < end and self.code.room():
            offset = self._keep(r, offset, line)
            self.rows[r, FOLLOWING] = r + 1
            line += 1
            r += 1
        if r > first:
            self.rows[r - 1, FOLLOWING] = -1
        return r

    def marked(self, o_words: cython.bint) -> list:
        """Find the lines that jumps may lead to or that look for one: with an O-word but CALL and RETURN, with the number of a program or a
        loop of a macro; and those that the grammar refuses.

        Args:
            o_words: Whether only lines with an O are asked for.

        Returns:
            Of each line its offset, its number, the number of the literal of its keyword (0 where it is refused), its label (None for one
            that is computed, and of macros), and the offset of the next line.
        """
        at: cython.Py_ssize_t = 0
        size: cython.Py_ssize_t = self.text.shape[0]
        line: cython.longlong = 0
        found: list = []
        while at < size:
            line += 1
            begin = at
            while o_words and at < size and self.text[at] != 10 and self.text[at] | 32 != 111:
                at += 1
            if o_words and (at == size or self.text[at] == 10):
                at += 1
                continue
            if not self.code.room():
                self.forget()
            self.code.numbers = 0
            at = self._keep(0, begin, line)
            if self.rows[0, MARKS] & REFUSED:
                found.append((begin, line, 0, None, at))
                continue
            keyword = self.rows[0, MARKS] >> LETTERS
            if keyword and keyword != O_CALL and keyword != O_RETURN and keyword != GOTO:
                written = keyword <= O_CALL and not self.rows[0, MARKS] & COMPUTED_LABEL
                label = self.code.label(self.rows[0, CODE], 0) if written else None
                found.append((begin, line, keyword, label, at))
        return found

    def taken_from(self, offset: cython.Py_ssize_t) -> tuple:
        """Read lines of a language from `offset` on, up to one that is refused, and keep none of them.

        Returns:
            How many lines, of which the first says something; where the next one begins; how many of them have words; how many lines stand
            before the last of these, and where it begins; the letters of all words, as bits from A on.
        """
        at: cython.Py_ssize_t = offset
        lines: cython.Py_ssize_t = 0
        blocks: cython.Py_ssize_t = 0
        last: cython.Py_ssize_t = 0
        last_at: cython.Py_ssize_t = offset
        seen: cython.longlong = 0
        self.code.text = self.text
        while at < self.text.shape[0]:
            self.code.used = self.code.numbers = 0
            begin = at
            at = self._keep(0, begin, 0)
            marks = self.rows[0, MARKS]
            if marks & REFUSED or (lines == 0 and not marks & SAYS):
                at = begin
                break
            if marks >> LETTERS:
                seen |= marks >> LETTERS
                blocks += 1
                last, last_at = lines, begin
            lines += 1
        return lines, min(at, self.text.shape[0]), blocks, last, last_at, seen

    @cython.cfunc
    def _keep(
        self, r: cython.Py_ssize_t, offset: cython.Py_ssize_t, line: cython.longlong
    ) -> cython.Py_ssize_t:
        """Keep a line in a row; return the offset of the next one."""
        first: cython.int = self.code.numbers
        begin: cython.int = self.code.used
        end: cython.Py_ssize_t = self.shapes.match(offset) if self.code.shaped else -1
        shape: cython.Py_ssize_t = self.shapes.row if end >= 0 else -1
        if end < 0 and self.code.shaped:
            end = self.shapes.read(offset)
            shape = self.shapes.find() if end >= 0 else -1
        self.rows[r, AT], self.rows[r, NUMBER_OF_LINE], self.rows[r, FIRST_CONSTANT] = offset, line, first
        self.rows[r, FOLLOWING] = self.rows[r, MARK] = -1
        if shape >= 0:
            self.rows[r, CODE] = self.shapes.table[shape, SHAPE_CODE]
            self.rows[r, MARKS] = self.shapes.table[shape, SHAPE_MARKS]
            self.code.numbers += self.shapes.put(self.code.constants, first)
        else:
            self.code.alike = end >= 0
            end = self.code.read(offset)
            self.rows[r, CODE] = begin
            self.rows[r, MARKS] = self.code.flags | (REFUSED if self.code.error >= 0 else 0)
            if self.code.alike and self.code.error < 0:
                self.shapes.keep(begin, self.code.flags, self.code.constants, first, self.code.numbers)
        self.rows[r, AFTER] = end + 1
        return end + 1
