"""Read lines that are plain motions, by the tables of a grammar whose rules make values (``grammars/lalr.py``), into columns of words.

It finds the tokens and shifts and reduces as `grammar_values` does, and calls no function: a line is taken if all of its terminals and rules
are among those that mean a word and its number, a motion or a feed. The first other line ends the run; `grammar_values` reads that one.
"""

import cython
from cython.cimports.cncgen.kernels.gcode_codes import MAX_LINE
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
#: Powers of ten that are doubles without error; digits that 64 bits hold, and the integer up to which doubles have no gaps.
_POWERS = cython.declare(cython.double[23])
_DIGITS = cython.declare(cython.int, 18)
_EXACT = cython.declare(cython.ulonglong, 9007199254740992)
_power: cython.int
for _power in range(23):
    _POWERS[_power] = 10.0**_power

#: A number, and whether it is certain.
_Value = cython.struct(value=cython.double, certain=cython.bint)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _is_blank(c: cython.int) -> cython.bint:
    """Tell whether a byte is a blank."""
    return c == 32 or c == 9 or c == 13


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _is_of_name(c: cython.int) -> cython.bint:
    """Tell whether a byte may stand in a name."""
    return 48 <= c <= 57 or 97 <= (c | 32) <= 122 or c == 95


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _value(text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, end: cython.Py_ssize_t) -> _Value:
    """Return the number of a token: a sign, digits with at most one point or comma, blanks; none with an exponent is certain."""
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
            if digits > _DIGITS:
                return _Value(value=0.0, certain=False)
        elif (c == 46 or c == 44) and whole < 0:
            whole = digits
        elif (c == 43 or c == 45) and digits == 0 and whole < 0:
            negative = c == 45
        elif not _is_blank(c):
            return _Value(value=0.0, certain=False)
        at += 1
    value = cython.cast(cython.double, mantissa)
    if whole >= 0:
        # Both are doubles without error, so the quotient is rounded once (Clinger).
        value /= _POWERS[digits - whole]
    return _Value(value=-value if negative else value, certain=digits > 0 and mantissa <= _EXACT)


@cython.final
@cython.cclass
class PlainReader:
    """The tables of a grammar, and which of its terminals and rules are those of plain lines.

    Args:
        tables: A module of tables (``grammars/tables_*.py``).
        roles: The role of each terminal of plain lines (`ROLES`), by its name.
        rules: The rules of plain lines that have a function, by alias or name.
        words, named: The letters of words, as one token and as a name with a number behind it.
        numbered: Whether lines begin with a number that is not of the grammar, comments neither, and each block is a line.
    """

    action: cython.const[cython.short][::1]
    goto: cython.const[cython.short][::1]
    move: cython.const[cython.short][::1]
    token: cython.const[cython.short][::1]
    mode: cython.const[cython.short][::1]
    classes: cython.const[cython.short][::1]
    origin: cython.const[cython.short][::1]
    length: cython.const[cython.short][::1]
    passed: cython.const[cython.short][::1]
    apart: cython.const[cython.short][::1]
    role: cython.int[::1]
    plain: cython.int[::1]
    letters: cython.uchar[::1]
    values: cython.double[::1]
    widths = cython.declare(cython.int[4])
    stack = cython.declare(cython.int[64])
    words_of = cython.declare(cython.uint)
    named = cython.declare(cython.uint)
    numbered = cython.declare(cython.bint)
    start = cython.declare(cython.int)
    accept = cython.declare(cython.int)
    end = cython.declare(cython.int)
    taken = cython.declare(cython.Py_ssize_t)
    words = cython.declare(cython.Py_ssize_t)
    given = cython.declare(cython.uint)
    seen = cython.declare(cython.uint, visibility="public")
    auto = cython.declare(cython.double)

    def __init__(self, tables, roles, rules, words: str, named: str, numbered: bool):
        if not cython.compiled:
            self.widths, self.stack = [0] * 4, [0] * 64
        self.action, self.widths[0] = _rows(tables.ACTION)
        self.goto, self.widths[1] = _rows(tables.GOTO)
        self.move, self.widths[2] = _rows(tables.MOVE)
        self.token, self.widths[3] = _rows(tables.TOKEN)
        self.mode, self.classes = _rows(tables.MODE)[0], _rows(tables.CLASSES)[0]
        self.passed, self.apart = _rows(tables.PASSED)[0], _rows(tables.APART)[0]
        self.origin, self.length = _rows(tables.ORIGIN)[0], _rows(tables.LENGTH)[0]
        self.end = len(tables.TERMINALS) - 1
        self.start, self.accept = tables.STARTS["start"]
        missing = [name for name in roles if name not in tables.TERMINALS]
        missing += rules - {name for name, _, _ in tables.RULES}
        if missing:
            raise ValueError(f"the grammar has no {missing[0]}")
        self.role = memoryview(bytearray(4 * (self.end + 1))).cast("i")
        for k, name in enumerate(tables.TERMINALS):
            self.role[k] = ROLES[roles[name]] if name in roles else 0
        self.plain = memoryview(bytearray(4 * len(tables.RULES))).cast("i")
        for k, (name, _, _) in enumerate(tables.RULES):
            self.plain[k] = not name or name in rules
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
        self.letters, self.values, self.auto, self.words = letters, values, auto, 0
        self.seen = 0
        while offset < size and lines < most and blocks < block_line.shape[0]:
            if self.words + _MOST_WORDS > letters.shape[0]:
                break
            stop = offset
            while stop < size and text[stop] != 10:
                stop += 1
            seen = self.seen
            if stop - offset > MAX_LINE or not self._line(text, offset, stop):
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
    @cython.exceptval(check=False)
    def _line(
        self, text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, size: cython.Py_ssize_t
    ) -> cython.bint:
        """Read the line from `at` to `size`; tell whether it is plain."""
        if self.numbered:
            size = _code_end(text, at, size)
            if size < 0:
                return False
            at = _behind_number(text, at, size)
            if at == size:
                return True
            if at < 0:
                return False
        return self._parse(text, at, size)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _parse(
        self, text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, size: cython.Py_ssize_t
    ) -> cython.bint:
        """Run the tables over a line."""
        kind: cython.int
        step: cython.int
        role: cython.int
        depth: cython.int = 0
        state: cython.int = self.start
        name: cython.int = 0
        minus: cython.bint = False
        fast: cython.bint = False
        straight: cython.bint = False
        first: cython.Py_ssize_t = self.words
        self.stack[0] = state
        self.given = 0
        while True:
            while at < size and _is_blank(text[at]):
                at += 1
            kind = self.end
            if at < size:
                kind = self._token(text, at, size, self.mode[state] * self.widths[3])
                if kind < 0:
                    return False
                if self.passed[kind]:
                    at = self.taken
                    continue
                if self.role[kind] == 0:
                    return False
            step = self.action[state * self.widths[0] + kind]
            while step < 0 and (kind != self.end or state != self.accept):
                if not self.plain[-step - 1]:
                    return False
                depth -= self.length[-step - 1]
                state = self.goto[self.stack[depth] * self.widths[1] + self.origin[-step - 1]]
                depth += 1
                self.stack[depth] = state
                step = self.action[state * self.widths[0] + kind]
            if kind == self.end and state == self.accept:
                break
            if step <= 0 or depth > _DEEPEST or self.words - first + 2 > _MOST_WORDS:
                return False
            state = step - 1
            depth += 1
            self.stack[depth] = state
            role = self.role[kind]
            if role == _WORD:
                if not self.words_of >> ((text[at] | 32) - 97) & 1:
                    return False
                if not self._word(text[at] | 32, text, at + 1, self.taken, False):
                    return False
                # It is no name of a number behind it (X1=5).
                name = 0
            elif role == _NAME:
                name = self._name(text, at)
                minus = False
                if name == 0:
                    return False
            elif role == _SIGN:
                minus = minus != (text[at] == 45)
            elif role == _NUMBER:
                if name == 0 or not self._word(name, text, at, self.taken, minus):
                    return False
                name = 0
            elif role == _LINE:
                straight = self.taken == at + 1 and text[at] | 32 == 108
                if not straight:
                    return False
            elif role == _FAST:
                fast = True
            elif role == _AUTO:
                if not self.auto > 0.0:
                    return False
                self._put(102, self.auto)
            at = self.taken
        if self.numbered:
            # A line without an axis is not one.
            if not straight or not self.given & _AXES:
                return False
            self._put(103, 0.0 if fast else 1.0)
        return True

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _name(self, text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t) -> cython.int:
        """Return the letter of a word by its name, 0 where it is not plain."""
        letter: cython.int = text[at] | 32
        if self.taken != at + 1 or not 97 <= letter <= 122 or not self.named >> (letter - 97) & 1:
            return 0
        return letter

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _word(
        self,
        letter: cython.int,
        text: cython.const[cython.uchar][::1],
        at: cython.Py_ssize_t,
        end: cython.Py_ssize_t,
        minus: cython.bint,
    ) -> cython.bint:
        """Put a word with the number from `at` to `end` into the columns; tell whether it is certain."""
        found: _Value = _value(text, at, end)
        if not found.certain:
            return False
        if letter == 103:
            if not (found.value == 0.0 or found.value == 1.0 or found.value == 2.0 or found.value == 3.0):
                return False
            self.seen |= cython.cast(cython.uint, 1) << (26 + cython.cast(cython.int, found.value))
        if letter == 109 and not (
            3.0 <= found.value <= 9.0 and found.value != 6.0 and found.value == floor(found.value)
        ):
            # Spindle and coolant alone are those of the interpreter.
            return False
        if letter == 114:
            # R0 alone ends a compensation that is not in force.
            return end == at + 1 and text[at] == 48
        self._put(letter, -found.value if minus else found.value)
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

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _token(
        self,
        text: cython.const[cython.uchar][::1],
        at: cython.Py_ssize_t,
        size: cython.Py_ssize_t,
        mode: cython.int,
    ) -> cython.int:
        """Return the terminal of the longest token at a place that a mode of the scanner has, -1 for none; `taken` is the place behind it."""
        found: cython.int = -1
        kind: cython.int
        d: cython.int = 0
        c: cython.int
        while at < size:
            c = text[at]
            d = self.move[d * self.widths[2] + self.classes[c if c < 128 else 128]]
            if d < 0:
                break
            at += 1
            kind = self.token[mode + d]
            # c is the last character of the token.
            if kind >= 0 and not (
                self.apart[kind] and _is_of_name(c) and at < size and _is_of_name(text[at])
            ):
                found = kind
                self.taken = at
        return found


#: The letters of axes, as bits.
_AXES = cython.declare(cython.uint, sum(1 << (ord(letter) - 97) for letter in "xyzabcuvw"))


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _code_end(
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


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _behind_number(
    text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, size: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """Return where a line's code begins behind its number, if it has one; -1 where that is not certain, as in one that is set in far."""
    begin: cython.Py_ssize_t = at
    named: cython.bint
    while at < size and _is_blank(text[at]):
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
    if at < size and not _is_blank(text[at]):
        return -1
    while at < size and _is_blank(text[at]):
        at += 1
    return at


def _rows(table):
    """Return the numbers of a table of a generated module, and how many columns it has."""
    return memoryview(table[1]).cast("h"), table[0]
