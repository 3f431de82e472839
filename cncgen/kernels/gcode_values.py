"""Compute lines of G-code on the spot: expressions, parameters and settings, straight from the bytes to numbers.

What `descent` reads into functions of the parameters, which pay where a line runs again and again, is computed here
while it is read. Like `gcode_scan` it judges nothing: a line that it does not take for certain (a value that the
machine's state enters, an unknown name, a division by zero, any code but those of plain motions) is left untouched, and
the interpreter reads it, which knows the whole language and every error.

The language is LinuxCNC's (``grammars/gcode.lark``); what operators and functions mean stands in `cncgen.gcode.expressions`.
"""

import cython
from cython.cimports.libc.math import (
    acos,
    asin,
    atan2,
    ceil,
    cos,
    exp,
    fabs,
    floor,
    fmod,
    isfinite,
    log,
    pow,
    sin,
    sqrt,
    tan,
)

#: Flags of a block (`gcode_scan`).
_COMMENT = cython.declare(cython.int, 2)
_NUMBERED = cython.declare(cython.int, 8)

#: Equal in comparisons, and whole as the number of a parameter (`expressions.EQUAL`).
_EQUAL = cython.declare(cython.double, 1e-4)
#: Larger numbers in words are faults (`block.LARGEST`).
_LARGEST = cython.declare(cython.double, 1e9)
#: Parameters below this are plain storage; the others belong to the machine.
_STORED = cython.declare(cython.int, 5000)
#: Brackets and parameters of parameters within one another (`grammar.MAX_NESTING`).
_DEPTH = cython.declare(cython.int, 60)
#: Digits of a number that is read here: its integer and its power of ten are doubles without error.
_DIGITS = cython.declare(cython.int, 15)

#: pi / 180 in two halves of 26 bits and what is left of it, and what splits a number so (2^27 + 1).
_DEGREE = cython.declare(cython.double, 0.017453292519943295)
_SPLIT = cython.declare(cython.double, 134217729.0)
_DEGREE_HIGH = cython.declare(cython.double, 0.01745329238474369)
_DEGREE_LOW = cython.declare(cython.double, 1.3519960498364902e-10)
_DEGREE_REST = cython.declare(cython.double, 2.9486522708701687e-19)
_PER_RADIAN = cython.declare(cython.double, 57.29577951308232)
#: Degrees beyond which an angle is none (its sine would be noise); tangents beyond the other are left as they are.
LARGEST_ANGLE = 1e12
_LARGEST_ANGLE = cython.declare(cython.double, LARGEST_ANGLE)
_STEEP = cython.declare(cython.double, 1e6)
#: Letters of words that are taken, as bits (A is bit 0): not D E H N O T, which tools, parameters and jumps hang on.
_LETTERS = cython.declare(cython.uint, 0)
#: Letters that may stand more than once in a block: G and M.
_CODES = cython.declare(cython.uint, 1 << 6 | 1 << 12)
#: G and M codes that are taken: none that reads or sets a parameter, or leads elsewhere.
_G_TAKEN = cython.declare(cython.uchar[100])
_M_TAKEN = cython.declare(cython.uchar[10])

_LEVEL_LOGIC = cython.declare(cython.int, 1)
_LEVEL_RELATION = cython.declare(cython.int, 2)
_LEVEL_SUM = cython.declare(cython.int, 3)
_LEVEL_PRODUCT = cython.declare(cython.int, 4)
_LEVEL_POWER = cython.declare(cython.int, 5)

#: Operators: what `_Operator.name` says.
_ADD = cython.declare(cython.int, 1)
_SUBTRACT = cython.declare(cython.int, 2)
_MULTIPLY = cython.declare(cython.int, 3)
_DIVIDE = cython.declare(cython.int, 4)
_MODULO = cython.declare(cython.int, 5)
_POWER = cython.declare(cython.int, 6)
_AND = cython.declare(cython.int, 7)
_OR = cython.declare(cython.int, 8)
_XOR = cython.declare(cython.int, 9)
_EQ = cython.declare(cython.int, 10)
_NE = cython.declare(cython.int, 11)
_GT = cython.declare(cython.int, 12)
_GE = cython.declare(cython.int, 13)
_LT = cython.declare(cython.int, 14)
_LE = cython.declare(cython.int, 15)

#: An operator, how tight it binds (0: there is none) and the offset after it.
_Operator = cython.struct(name=cython.int, level=cython.int, after=cython.Py_ssize_t)

#: An angle in radians, and what its rounding left.
_Angle = cython.struct(value=cython.double, rest=cython.double)


@cython.cfunc
def _packed(name: bytes) -> cython.uint:
    """Return the letters of a word of at most six as a number."""
    code: cython.uint = 0
    c: cython.int
    for c in name:
        code = (code << 5) | (c & 31)
    return code


_ABS = cython.declare(cython.uint, _packed(b"abs"))
_ACOS = cython.declare(cython.uint, _packed(b"acos"))
_ASIN = cython.declare(cython.uint, _packed(b"asin"))
_ATAN = cython.declare(cython.uint, _packed(b"atan"))
_COS = cython.declare(cython.uint, _packed(b"cos"))
_EXP = cython.declare(cython.uint, _packed(b"exp"))
_FIX = cython.declare(cython.uint, _packed(b"fix"))
_FUP = cython.declare(cython.uint, _packed(b"fup"))
_LN = cython.declare(cython.uint, _packed(b"ln"))
_ROUND = cython.declare(cython.uint, _packed(b"round"))
_SIN = cython.declare(cython.uint, _packed(b"sin"))
_SQRT = cython.declare(cython.uint, _packed(b"sqrt"))
_TAN = cython.declare(cython.uint, _packed(b"tan"))


@cython.cfunc
def _fill_tables() -> cython.void:
    """Fill the tables of letters and codes, once."""
    global _LETTERS
    c: cython.int
    for c in b"abcfgijklmpqrsuvwxyz":
        _LETTERS |= cython.cast(cython.uint, 1) << (c - 97)
    for c in range(100):
        _G_TAKEN[c] = c in (0, 1, 2, 3, 4, 33, 61, 64, 73, 80, 81, 82, 83, 85, 89, 90, 91, 93, 94, 98, 99)
    for c in range(10):
        _M_TAKEN[c] = c in (3, 4, 5, 7, 8, 9)


_fill_tables()


# Angles.


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _radians(a: cython.double) -> _Angle:
    """Return an angle in degrees as radians and what their rounding left: Dekker's product (Numer. Math. 18, 1971).

    With the latter, SIN[30] is 0.5 and TAN[45] is 1, which FIX, FUP and EQ must see.
    """
    split: cython.double = _SPLIT * a
    high: cython.double = split - (split - a)
    low: cython.double = a - high
    angle: cython.double = a * _DEGREE
    rest: cython.double = high * _DEGREE_HIGH - angle
    rest = ((rest + high * _DEGREE_LOW) + low * _DEGREE_HIGH) + low * _DEGREE_LOW
    return _Angle(value=angle, rest=rest + a * _DEGREE_REST)


@cython.ccall
def sine(a: cython.double) -> cython.double:
    """Return the sine of an angle in degrees, within `LARGEST_ANGLE`."""
    angle: _Angle = _radians(a)
    return sin(angle.value) + angle.rest * cos(angle.value)


@cython.ccall
def cosine(a: cython.double) -> cython.double:
    """Return the cosine of an angle in degrees, within `LARGEST_ANGLE`."""
    angle: _Angle = _radians(a)
    return cos(angle.value) - angle.rest * sin(angle.value)


@cython.ccall
def tangent(a: cython.double) -> cython.double:
    """Return the tangent of an angle in degrees, within `LARGEST_ANGLE`."""
    angle: _Angle = _radians(a)
    value: cython.double = tan(angle.value)
    return value + angle.rest * (1.0 + value * value) if fabs(value) < _STEEP else value


@cython.ccall
def arc_sine(a: cython.double) -> cython.double:
    """Return the angle in degrees whose sine is `a`, -1 to 1: a short number where its sine is `a` to the bit."""
    angle: cython.double = asin(a) * _PER_RADIAN
    short: cython.double = round(angle, 10)
    return short if sine(short) == a else angle


@cython.ccall
def arc_cosine(a: cython.double) -> cython.double:
    """Return the angle in degrees whose cosine is `a`, -1 to 1, as `arc_sine`."""
    angle: cython.double = acos(a) * _PER_RADIAN
    short: cython.double = round(angle, 10)
    return short if cosine(short) == a else angle


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _is_letter(c: cython.int) -> cython.bint:
    """Tell whether a byte is a letter."""
    return 97 <= (c | 32) <= 122


@cython.cfunc
@cython.exceptval(check=False)
def _operator_of_letters(
    c: cython.int, second: cython.int, third: cython.int, at: cython.Py_ssize_t
) -> _Operator:
    """Return the operator that these letters begin with, which stand at an offset; its level is 0 where there is none."""
    if c == 109 and second == 111 and third == 100:
        return _Operator(name=_MODULO, level=_LEVEL_PRODUCT, after=at + 3)
    if c == 97 and second == 110 and third == 100:
        return _Operator(name=_AND, level=_LEVEL_LOGIC, after=at + 3)
    if c == 120 and second == 111 and third == 114:
        return _Operator(name=_XOR, level=_LEVEL_LOGIC, after=at + 3)
    if c == 111 and second == 114:
        return _Operator(name=_OR, level=_LEVEL_LOGIC, after=at + 2)
    return _Operator(
        name=_relation(c, second), level=_LEVEL_RELATION if _relation(c, second) else 0, after=at + 2
    )


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _relation(c: cython.int, second: cython.int) -> cython.int:
    """Return the relation that two letters name, 0 where they name none."""
    if c == 101:
        return _EQ if second == 113 else 0
    if c == 110:
        return _NE if second == 101 else 0
    if c == 103:
        return _GT if second == 116 else (_GE if second == 101 else 0)
    if c == 108:
        return _LT if second == 116 else (_LE if second == 101 else 0)
    return 0


@cython.cclass
class Computer:
    """A place in a text, and the columns that its lines go to.

    Args:
        data: The text, bytes or a map of a file; `text` is the same as a buffer.
        numbers: Numbered parameters by number, read and set.
        named: Global parameters by name, read and set.
        reserved: Names that cannot be set.
        block_line, block_offset, block_flags, word_end, letters, values: The columns of `gcode_scan.scan`.

    Attributes:
        blocks: How many blocks stand in the columns; whoever takes them sets it to 0.
        line: Number of the first line not read.
    """

    data = cython.declare(object)
    text: cython.const[cython.uchar][::1]
    block_line: cython.longlong[::1]
    block_offset: cython.longlong[::1]
    block_flags: cython.uchar[::1]
    word_end: cython.longlong[::1]
    letters: cython.uchar[::1]
    values: cython.double[::1]
    numbers = cython.declare(list)
    named = cython.declare(dict)
    local = cython.declare(dict)
    reserved = cython.declare(frozenset)
    names = cython.declare(dict)
    blocks = cython.declare(cython.Py_ssize_t, visibility="public")
    line = cython.declare(cython.longlong, visibility="public")
    i = cython.declare(cython.Py_ssize_t)
    depth = cython.declare(cython.int)
    certain = cython.declare(cython.bint)
    name = cython.declare(object)
    everywhere = cython.declare(cython.bint)
    settings = cython.declare(list)

    def __init__(self, data, text, numbers, named, reserved, columns):
        self.data = data
        self.text = text
        self.numbers = numbers
        self.named = named
        self.local = {}
        self.reserved = reserved
        self.names = {}
        self.block_line, self.block_offset, self.block_flags = columns[:3]
        self.word_end, self.letters, self.values = columns[3:]
        self.blocks = 0
        self.line = 1
        self.i = 0
        self.depth = 0
        self.certain = True
        self.name = None
        self.everywhere = False
        self.settings = []

    def run(self, offset: cython.Py_ssize_t, line: cython.longlong, local: dict) -> cython.Py_ssize_t:
        """Read lines from `offset` on until one is not certain, a column is full, or the text ends.

        Settings are done, blocks go to the columns, behind those that stand there. `local` are the named parameters of the
        subroutine in force. Returns the offset of the first line not read.
        """
        words: cython.Py_ssize_t = self.word_end[self.blocks - 1] if self.blocks > 0 else 0
        self.local = local
        while offset < self.text.shape[0] and self.blocks < self.block_line.shape[0]:
            self.i = offset
            self.certain = True
            self.depth = 0
            words = self._line(words, offset, line)
            if not self.certain:
                break
            offset = self.i + 1
            line += 1
        self.line = line
        return offset

    def o_word(self, offset: cython.Py_ssize_t, local: dict):
        """Return label, keyword, values and end of the line at `offset` where it holds an O-word and is certain, else None.

        A label is the float of a number, or a name.
        """
        self.local = local
        self.i = offset
        self.certain = True
        self.depth = 0
        begin: cython.Py_ssize_t
        if self._byte() | 32 == 110:
            self.i += 1
            self._number()
        if not self.certain or self._byte() | 32 != 111:
            return None
        self.i += 1
        label = self._label()
        self._byte()
        begin = self.i
        while self.i < self.text.shape[0] and _is_letter(self.text[self.i]):
            self.i += 1
        if not self.certain or self.i == begin:
            return None
        keyword = self.data[begin : self.i].lower().decode("ascii")
        arguments = []
        while self.certain and self._byte() == 91:
            arguments.append(self._bracket())
        self._remarks()
        if not self.certain or self._byte() != 10:
            return None
        return label, keyword, arguments, self.i

    # Text.

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _byte(self) -> cython.int:
        """Go on to what is no blank and return it; a newline at the end of the text."""
        c: cython.int
        while self.i < self.text.shape[0]:
            c = cython.cast(cython.int, self.text[self.i])
            if c != 32 and c != 9 and c != 13:
                return c
            self.i += 1
        return 10

    @cython.cfunc
    @cython.exceptval(check=False)
    def _take(self, c: cython.int) -> cython.void:
        """Go past a byte that must stand here."""
        if self._byte() == c:
            self.i += 1
        else:
            self.certain = False

    @cython.cfunc
    @cython.exceptval(check=False)
    def _remarks(self) -> cython.int:
        """Go past comments that do nothing; return the flag of a block that has one."""
        flags: cython.int = 0
        begin: cython.Py_ssize_t
        c: cython.int = self._byte()
        while self.certain and (c == 40 or c == 59):
            flags = _COMMENT
            self.i += 1
            if c == 59:
                while self.i < self.text.shape[0] and self.text[self.i] != 10:
                    self.i += 1
            else:
                # A keyword and a comma do something, and (LOGCLOSE).
                self._byte()
                begin = self.i
                while self.i < self.text.shape[0] and _is_letter(self.text[self.i]):
                    self.i += 1
                if (self.i > begin and self._byte() == 44) or self.i - begin == 8:
                    self.certain = False
                while self.i < self.text.shape[0] and self._is_remark(self.text[self.i]):
                    self.i += 1
                self._take(41)
            c = self._byte()
        return flags

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _is_remark(self, c: cython.int) -> cython.bint:
        """Tell whether a byte may stand in a comment that is read here."""
        return c != 40 and c != 41 and c != 10 and c < 128

    @cython.cfunc
    def _line(
        self, first: cython.Py_ssize_t, offset: cython.Py_ssize_t, line: cython.longlong
    ) -> cython.Py_ssize_t:
        """Read the line here, its words into the columns from `first` on; return where the next block's words go."""
        words: cython.Py_ssize_t = first
        flags: cython.int = 0
        given: cython.uint = 0
        bit: cython.uint
        value: cython.double
        c: cython.int = self._byte()
        if self.settings:
            self.settings.clear()
        if c | 32 == 110:
            self.i += 1
            self._number()
            flags = _NUMBERED
        while self.certain:
            c = self._byte()
            if _is_letter(c):
                self.i += 1
                bit = cython.cast(cython.uint, 1) << ((c | 32) - 97)
                value = self._signed()
                if not self._is_word(c | 32, bit & given, bit, value) or words >= self.letters.shape[0]:
                    self.certain = False
                    break
                given |= bit & ~_CODES
                self.letters[words] = c | 32
                self.values[words] = value
                words += 1
            elif c == 10:
                break
            elif c == 35:
                self.i += 1
                self._setting()
            elif c == 40 or c == 59:
                flags |= self._remarks()
            else:
                self.certain = False
        if not self.certain:
            return first
        self._set()
        if words > first or flags & _COMMENT:
            self.block_line[self.blocks] = line
            self.block_offset[self.blocks] = offset
            self.block_flags[self.blocks] = flags
            self.word_end[self.blocks] = words
            self.blocks += 1
        return words

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _is_word(
        self, letter: cython.int, twice: cython.uint, bit: cython.uint, value: cython.double
    ) -> cython.bint:
        """Tell whether a word is taken: a letter that no machine's table hangs on, once, its value in range."""
        if not bit & _LETTERS or twice or not -_LARGEST <= value <= _LARGEST:
            return False
        if letter == 103:
            return (
                0.0 <= value < 100.0
                and value == floor(value)
                and _G_TAKEN[cython.cast(cython.int, value)] != 0
            )
        if letter == 109:
            return (
                0.0 <= value < 10.0
                and value == floor(value)
                and _M_TAKEN[cython.cast(cython.int, value)] != 0
            )
        return True

    # Parameters.

    @cython.cfunc
    def _read_name(self) -> cython.void:
        """Read the rest of ``<name>`` into `name`: lower case, without blanks; and whether it is global."""
        begin: cython.Py_ssize_t
        self.everywhere = self._byte() == 95
        begin = self.i
        while self.i < self.text.shape[0] and self.text[self.i] != 62 and self.text[self.i] != 10:
            self.i += 1
        key: bytes = self.data[begin : self.i]
        self._take(62)
        name = self.names.get(key)
        if name is None and self.certain:
            self.certain = key.isascii() and b"(" not in key and b";" not in key
            if self.certain:
                name = self.names[key] = key.translate(None, b" \t\r").lower().decode("ascii")
        self.name = name

    @cython.cfunc
    def _label(self):
        """Read the label of an O-word."""
        c: cython.int = self._byte()
        if c == 60:
            self.i += 1
            self._read_name()
            name = self.name
            if self.certain and name.isdecimal():
                return float(name)
            return name
        label: cython.double = self._number() if 48 <= c <= 57 else self._value()
        if label != floor(label) or not fabs(label) < _LARGEST:
            self.certain = False
        return label

    @cython.cfunc
    @cython.exceptval(check=False)
    def _index(self) -> cython.int:
        """Read the number of a parameter behind its #; -1 where it is no plain storage."""
        value: cython.double
        whole: cython.double
        c: cython.int = self._byte()
        if not (c == 35 or c == 91 or c == 46 or 48 <= c <= 57):
            self.certain = False
            return -1
        value = self._value()
        whole = floor(value + 0.5)
        if not self.certain or fabs(value - whole) > _EQUAL or not 0.0 < whole < _STORED:
            self.certain = False
            return -1
        return cython.cast(cython.int, whole)

    @cython.cfunc
    def _parameter(self) -> cython.double:
        """Read a parameter behind its # and return its value."""
        index: cython.int
        if self._byte() != 60:
            index = self._index()
            return self.numbers[index] if self.certain else 0.0
        self.i += 1
        self._read_name()
        if not self.certain:
            return 0.0
        # What tells the machine's state is not stored, so it is not found.
        stored: dict = self.named if self.everywhere else self.local
        value = stored.get(self.name)
        if value is None:
            self.certain = False
            return 0.0
        return value

    @cython.cfunc
    def _setting(self) -> cython.void:
        """Read a setting behind its #; it is done at the end of the line."""
        target: object
        value: cython.double
        if self._byte() == 60:
            self.i += 1
            self._read_name()
            target = self.name
            if self.certain and target in self.reserved:
                self.certain = False
        else:
            target = self._index()
        if self.certain:
            self._take(61)
        if self.certain:
            value = self._signed()
            self.settings.append((target, value))

    @cython.cfunc
    def _set(self) -> cython.void:
        """Do the settings of the line."""
        for target, value in self.settings:
            if isinstance(target, str):
                (self.named if target.startswith("_") else self.local)[target] = value
            else:
                self.numbers[target] = value

    # Values.

    @cython.cfunc
    def _signed(self) -> cython.double:
        """Read a value behind any number of signs."""
        negative: cython.bint = False
        value: cython.double
        c: cython.int = self._byte()
        while c == 43 or c == 45:
            if c == 45:
                negative = not negative
            self.i += 1
            c = self._byte()
        value = self._value()
        return -value if negative else value

    @cython.cfunc
    def _value(self) -> cython.double:
        """Read a number, parameter, function or expression in brackets."""
        c: cython.int = self._byte()
        value: cython.double = 0.0
        if 48 <= c <= 57 or c == 46:
            return self._number()
        self.depth += 1
        if self.depth > _DEPTH:
            self.certain = False
        elif c == 35:
            self.i += 1
            value = self._parameter()
        elif c == 91:
            value = self._bracket()
        elif _is_letter(c):
            value = self._function()
        else:
            self.certain = False
        self.depth -= 1
        return value

    @cython.cfunc
    @cython.exceptval(check=False)
    def _number(self) -> cython.double:
        """Read digits with at most one point, and no blank among them."""
        mantissa: cython.longlong = 0
        digits: cython.int = 0
        scale: cython.double = 1.0
        dotted: cython.bint = False
        c: cython.int = self._byte()
        while 48 <= c <= 57 or (c == 46 and not dotted):
            if c == 46:
                dotted = True
            else:
                mantissa = mantissa * 10 + (c - 48)
                digits += 1
                if digits > _DIGITS:
                    break
                if dotted:
                    scale *= 10.0
            self.i += 1
            c = cython.cast(cython.int, self.text[self.i]) if self.i < self.text.shape[0] else 10
        if c == 32 or c == 9:
            c = self._byte()
        if digits == 0 or digits > _DIGITS or 48 <= c <= 57 or c == 46:
            self.certain = False
        # Both are doubles without error, so that the quotient is rounded once.
        return cython.cast(cython.double, mantissa) / scale

    @cython.cfunc
    def _bracket(self) -> cython.double:
        """Read an expression in brackets."""
        value: cython.double
        self._take(91)
        value = self._expression(_LEVEL_LOGIC)
        self._take(93)
        return value

    @cython.cfunc
    def _expression(self, level: cython.int) -> cython.double:
        """Read operands and operators that bind at least so tight, from the left."""
        value: cython.double = self._signed()
        other: cython.double
        found: _Operator = self._operator()
        while self.certain and found.level >= level:
            self.i = found.after
            other = self._expression(found.level + 1)
            value = self._joined(found.name, value, other)
            found = self._operator()
        return value

    @cython.cfunc
    @cython.exceptval(check=False)
    def _operator(self) -> _Operator:
        """Return the operator that stands here; its level is 0 where none does."""
        c: cython.int = self._byte()
        at: cython.Py_ssize_t = self.i
        second: cython.int = cython.cast(cython.int, self.text[at + 1]) if at + 1 < self.text.shape[0] else 10
        third: cython.int = cython.cast(cython.int, self.text[at + 2]) if at + 2 < self.text.shape[0] else 10
        if c == 43 or c == 45:
            return _Operator(name=_ADD if c == 43 else _SUBTRACT, level=_LEVEL_SUM, after=at + 1)
        if c == 47:
            return _Operator(name=_DIVIDE, level=_LEVEL_PRODUCT, after=at + 1)
        if c == 42:
            if second == 42:
                return _Operator(name=_POWER, level=_LEVEL_POWER, after=at + 2)
            return _Operator(name=_MULTIPLY, level=_LEVEL_PRODUCT, after=at + 1)
        if c == 10:
            return _Operator(name=0, level=0, after=at)
        return _operator_of_letters(c | 32, second | 32, third | 32, at)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _joined(self, name: cython.int, a: cython.double, b: cython.double) -> cython.double:
        """Return ``a name b``; not certain where it is a fault."""
        if name == _ADD:
            return a + b
        if name == _SUBTRACT:
            return a - b
        if name == _MULTIPLY:
            return a * b
        if name == _DIVIDE or name == _MODULO or name == _POWER:
            return self._divided(name, a, b)
        return 1.0 if self._holds(name, a, b) else 0.0

    @cython.cfunc
    @cython.exceptval(check=False)
    def _divided(self, name: cython.int, a: cython.double, b: cython.double) -> cython.double:
        """Return ``a / b``, ``a MOD b`` or ``a ** b``."""
        value: cython.double = 0.0
        if name == _POWER:
            if (a < 0.0 and b != floor(b)) or (a == 0.0 and b < 0.0):
                self.certain = False
            else:
                value = pow(a, b)
        elif b == 0.0:
            self.certain = False
        elif name == _DIVIDE:
            return a / b
        else:
            value = fmod(a, b)
            value = value + fabs(b) if value < 0.0 else value
        if not isfinite(value):
            self.certain = False
        return value

    @cython.cfunc
    @cython.exceptval(check=False)
    def _holds(self, name: cython.int, a: cython.double, b: cython.double) -> cython.bint:
        """Tell whether a relation or a connection of truth values holds."""
        if name == _LT:
            return a < b
        if name == _LE:
            return a <= b
        if name == _GT:
            return a > b
        if name == _GE:
            return a >= b
        if name == _EQ:
            return fabs(a - b) < _EQUAL
        if name == _NE:
            return not fabs(a - b) < _EQUAL
        if name == _AND:
            return a != 0.0 and b != 0.0
        if name == _OR:
            return a != 0.0 or b != 0.0
        return (a != 0.0) != (b != 0.0)

    @cython.cfunc
    def _function(self) -> cython.double:
        """Read a function and its argument."""
        code: cython.uint = 0
        letters: cython.int = 0
        a: cython.double
        b: cython.double
        while self.i < self.text.shape[0] and _is_letter(self.text[self.i]) and letters < 6:
            code = (code << 5) | (self.text[self.i] & 31)
            self.i += 1
            letters += 1
        a = self._bracket()
        if not self.certain:
            return 0.0
        if code == _ATAN:
            self._take(47)
            b = self._bracket()
            return atan2(a, b) * _PER_RADIAN
        return self._of(code, a)

    @cython.cfunc
    def _of(self, code: cython.uint, a: cython.double) -> cython.double:
        """Return a function's value; not certain where it has none, or there is no such function."""
        value: cython.double = 0.0
        if code == _ABS:
            value = fabs(a)
        elif code == _FIX:
            value = floor(a)
        elif code == _FUP:
            value = ceil(a)
        elif code == _ROUND:
            value = floor(fabs(a) + 0.5) * (-1.0 if a < 0.0 else 1.0)
        elif code == _SQRT and a >= 0.0:
            value = sqrt(a)
        elif code == _EXP:
            value = exp(a)
        elif code == _LN and a > 0.0:
            value = log(a)
        elif (code == _ASIN or code == _ACOS) and -1.0 <= a <= 1.0:
            value = arc_sine(a) if code == _ASIN else arc_cosine(a)
        elif not fabs(a) < _LARGEST_ANGLE:
            self.certain = False
        elif code == _SIN:
            value = sine(a)
        elif code == _COS:
            value = cosine(a)
        elif code == _TAN:
            value = tangent(a)
        else:
            self.certain = False
        if not isfinite(value):
            self.certain = False
        return value
