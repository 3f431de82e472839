"""Read lines that are plain motions, by the tables of a grammar whose rules make values (``grammars/lalr.py``), into columns of words.

A line is taken if all of its terminals and rules are among those that mean a word and its number, a motion or a feed. The first other line
ends the run; `grammar_values` reads that one.
"""

import cython
from cython.cimports.cncgen.kernels.decimals import decimal, is_blank
from cython.cimports.cncgen.kernels.gcode_codes import MAX_LINE
from cython.cimports.cncgen.kernels.grammar_tables import Tables
from cython.cimports.libc.math import floor

#: The role of a terminal in a plain line: a word with its number, the name of a word, a sign, the number behind a name, a motion that is a
#: line, the words of a traverse and of a tool's feed, what only stands between them; 0 for what no plain line has.
ROLES = {"word": 1, "name": 2, "sign": 3, "number": 4, "line": 5, "fast": 6, "auto": 7, "between": 8}
_WORD = cython.declare(cython.int, 1)
_NAME = cython.declare(cython.int, 2)
_SIGN = cython.declare(cython.int, 3)
_NUMBER = cython.declare(cython.int, 4)
_LINE = cython.declare(cython.int, 5)
_FAST = cython.declare(cython.int, 6)
_AUTO = cython.declare(cython.int, 7)

#: States that a plain line puts on the stack, at most.
_DEEPEST = cython.declare(cython.int, 48)
#: Words of a line, at most.
_MOST_WORDS = cython.declare(cython.int, 32)
#: The letters of axes, as bits.
_AXES = cython.declare(cython.uint, sum(1 << (ord(letter) - 97) for letter in "xyzabcuvw"))
_FEED = cython.declare(cython.uint, 32)


@cython.ccall
@cython.exceptval(check=False)
def plain_value(
    text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> cython.double:
    """Return the number of a token: a sign, digits with at most one point or comma, blanks; NaN where it is not certain."""
    mantissa: cython.ulonglong = 0
    digits: cython.int = 0
    #: How many digits stand before the point, -1 without one.
    whole: cython.int = -1
    negative: cython.bint = False
    value: cython.double
    c: cython.int
    while at < end:
        c = text[at]
        if 48 <= c <= 57:
            mantissa = mantissa * 10 + cython.cast(cython.ulonglong, c - 48)
            digits += 1
        elif (c == 46 or c == 44) and whole < 0:
            whole = digits
        elif (c == 43 or c == 45) and digits == 0 and whole < 0:
            negative = c == 45
        elif not is_blank(c):
            digits = 0
            break
        at += 1
    value = decimal(mantissa, digits, digits - whole if whole >= 0 else 0)
    return -value if negative else value


@cython.final
@cython.cclass
class PlainReader(Tables):
    """The tables of a grammar, and which of its terminals and rules are those of plain lines.

    Args:
        tables: A module of tables (``grammars/tables_*.py``).
        roles: The role of each terminal of plain lines (`ROLES`), by its name.
        rules: The rules of plain lines that have a function, by alias or name.
        words, named: The letters of words, as one token and as a name with a number behind it.
        numbered: Whether lines begin with a number that is not of the grammar, comments neither, and each block is a line.
    """

    role: cython.int[::1]
    letters: cython.uchar[::1]
    values: cython.double[::1]
    words_of = cython.declare(cython.uint)
    named = cython.declare(cython.uint)
    numbered = cython.declare(cython.bint)
    words = cython.declare(cython.Py_ssize_t)
    begun = cython.declare(cython.Py_ssize_t)
    name = cython.declare(cython.int)
    minus = cython.declare(cython.bint)
    fast = cython.declare(cython.bint)
    straight = cython.declare(cython.bint)
    given = cython.declare(cython.uint)
    seen = cython.declare(cython.uint, visibility="public")
    auto = cython.declare(cython.double)

    def __init__(self, tables, roles, rules, words: str, named: str, numbered: bool):
        Tables.__init__(self, tables)
        missing = [name for name in roles if name not in tables.TERMINALS]
        missing += rules - {name for name, _, _ in tables.RULES}
        if missing:
            raise ValueError(f"the grammar has no {missing[0]}")
        self.role = memoryview(bytearray(4 * (self.end + 1))).cast("i")
        for k, name in enumerate(tables.TERMINALS):
            self.role[k] = ROLES[roles[name]] if name in roles else 0
        for k, (name, _, _) in enumerate(tables.RULES):
            self.silent[k] = not name or name in rules
        self.words_of = sum(1 << (ord(letter) - 97) for letter in words)
        self.named = sum(1 << (ord(letter) - 97) for letter in named)
        self.numbered = numbered
        self.seen = 0

    def scan(
        self,
        text: cython.const[cython.uchar][::1],
        offset: cython.Py_ssize_t,
        line: cython.longlong,
        most: cython.Py_ssize_t,
        auto: cython.double,
        block_line: cython.longlong[::1],
        block_offset: cython.longlong[::1],
        block_flags: cython.uchar[::1],
        word_end: cython.longlong[::1],
        letters: cython.uchar[::1],
        values: cython.double[::1],
    ) -> tuple:
        """Read plain lines from `offset` on until a column is full, the text ends or a line is not plain.

        `seen` has then a bit for each letter of the words, and from 26 on for each number of G.

        Args:
            text: The whole program.
            offset: Where a line begins.
            line: Its number, from 1.
            most: Lines that are read at most.
            auto: The feed that a word for the tool's feed means; such lines are not plain where it is not above 0.
            block_line, block_offset, block_flags, word_end, letters, values: Columns as those of `gcode_scan.scan`.

        Returns:
            Blocks read (lines with a word), lines read, offset of the first line not read.
        """
        blocks: cython.Py_ssize_t = 0
        lines: cython.Py_ssize_t = 0
        size: cython.Py_ssize_t = text.shape[0]
        words: cython.Py_ssize_t = 0
        stop: cython.Py_ssize_t
        seen: cython.uint = 0
        self.text, self.letters, self.values, self.auto, self.words = text, letters, values, auto, 0
        self.seen = 0
        while offset < size and lines < most and blocks < block_line.shape[0]:
            if self.words + _MOST_WORDS > letters.shape[0]:
                break
            stop = offset
            while stop < size and text[stop] != 10:
                stop += 1
            seen = self.seen
            if stop - offset > MAX_LINE or self._line(offset, stop) == 0:
                self.seen = seen
                self.words = words
                break
            if self.words > words:
                words = self.words
                block_line[blocks] = line
                block_offset[blocks] = offset
                block_flags[blocks] = 0
                word_end[blocks] = words
                blocks += 1
            offset = stop + 1
            lines += 1
            line += 1
        return blocks, lines, min(offset, size)

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _line(self, at: cython.Py_ssize_t, size: cython.Py_ssize_t) -> cython.int:
        """Read the line from `at` to `size`; tell whether it is plain."""
        if self.numbered:
            size = code_end(self.text, at, size)
            if size < 0:
                return 0
            at = behind_number(self.text, at, size)
            if at == size:
                return 1
            if at < 0:
                return 0
        self.begun = self.words
        self.given = 0
        self.name = 0
        self.minus = self.fast = self.straight = False
        if self.run(at, size) == 0:
            return 0
        if self.numbered:
            # A line without an axis is not one, and none is a traverse at a feed.
            if not self.straight or not self.given & _AXES or (self.fast and self.given & _FEED):
                return 0
            self._put(103, 0.0 if self.fast else 1.0)
        return 1

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _reduced(self, rule: cython.int, at: cython.Py_ssize_t) -> cython.int:
        """Refuse a rule that plain lines do not have."""
        return 0

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _shifted(self, kind: cython.int, at: cython.Py_ssize_t) -> cython.int:
        """Take a token; tell whether it is one of plain lines."""
        role: cython.int = self.role[kind]
        if role == 0 or self.depth > _DEEPEST or self.words - self.begun + 2 > _MOST_WORDS:
            return 0
        if role == _WORD:
            # It is no name of a number behind it (X1=5).
            self.name = 0
            return self.words_of >> ((self.text[at] | 32) - 97) & 1 and self._word(
                self.text[at] | 32, at + 1, False
            )
        if role == _NAME:
            self.name = self._name(at)
            self.minus = False
            return self.name != 0
        if role == _SIGN:
            self.minus = self.minus != (self.text[at] == 45)
        elif role == _NUMBER:
            if self.name == 0 or not self._word(self.name, at, self.minus):
                return 0
            self.name = 0
        elif role == _LINE:
            self.straight = self.taken == at + 1 and self.text[at] | 32 == 108
            return self.straight
        elif role == _FAST:
            self.fast = True
        elif role == _AUTO:
            if not self.auto > 0.0:
                return 0
            self._put(102, self.auto)
        return 1

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _name(self, at: cython.Py_ssize_t) -> cython.int:
        """Return the letter of a word by its name, 0 where it is not plain; that of SINUMERIK's CR is R."""
        letter: cython.int = self.text[at] | 32
        if self.taken == at + 2 and letter == 99 and self.text[at + 1] | 32 == 114:
            return 114
        if self.taken != at + 1 or not 97 <= letter <= 122 or not self.named >> (letter - 97) & 1:
            return 0
        return letter

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _word(self, letter: cython.int, at: cython.Py_ssize_t, minus: cython.bint) -> cython.bint:
        """Put a word with the number of the token from `at` on into the columns; tell whether it is certain."""
        value: cython.double = plain_value(self.text, at, self.taken)
        if value != value:
            return False
        if letter == 103:
            if not (value == 0.0 or value == 1.0 or value == 2.0 or value == 3.0):
                return False
            self.seen |= cython.cast(cython.uint, 1) << (26 + cython.cast(cython.int, value))
        if letter == 109 and not (3.0 <= value <= 9.0 and value != 6.0 and value == floor(value)):
            # Spindle and coolant alone are those of the interpreter.
            return False
        if letter == 114 and self.numbered:
            # R0 alone ends a compensation that is not in force.
            return self.taken == at + 1 and self.text[at] == 48
        self._put(letter, -value if minus else value)
        return True

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _put(self, letter: cython.int, value: cython.double) -> cython.void:
        """Put a word into the columns."""
        self.letters[self.words] = letter
        self.values[self.words] = value
        self.words += 1
        self.given |= cython.cast(cython.uint, 1) << (letter - 97)
        self.seen |= cython.cast(cython.uint, 1) << (letter - 97)


@cython.ccall
@cython.exceptval(check=False)
def code_end(
    text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, size: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """Return where the code of a numbered line ends, before its comment; -1 where the comment may go on in the next line (~)."""
    end: cython.Py_ssize_t = at
    while end < size and text[end] != 59:
        end += 1
    at = end
    while at < size:
        if text[at] == 126:
            return -1
        at += 1
    return end


@cython.ccall
@cython.exceptval(check=False)
def behind_number(
    text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, size: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """Return where a line's code begins behind its number, if it has one; -1 where that is not certain, as in one that is set in far."""
    begin: cython.Py_ssize_t = at
    named: cython.bint
    while at < size and is_blank(text[at]):
        at += 1
    if at == size:
        return size
    if at - begin > 3:
        return -1
    named = text[at] | 32 == 110
    at += named
    begin = at
    while at < size and 48 <= text[at] <= 57:
        at += 1
    if at == begin:
        return -1 if named else at
    if at < size and not is_blank(text[at]):
        return -1
    while at < size and is_blank(text[at]):
        at += 1
    return at
