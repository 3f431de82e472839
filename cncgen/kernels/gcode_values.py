"""Compute lines of G-code on the spot: expressions, parameters and settings, straight from the bytes to numbers.

The grammar reads expressions into functions of the parameters, which pay where a line runs again and again; here they are
computed while they are read. Like `gcode_scan` it judges nothing. A line that it does not take for certain is left to the
interpreter, which knows the whole language and every error: a value that the machine's state enters, an unknown name, a
division by zero, any code but those of plain motions.

The language is LinuxCNC's (``grammars/gcode.lark``); `cncgen.gcode.text.expressions` defines operators and functions.
"""

import cython
from cython.cimports.libc.math import fabs, floor, isfinite

if cython.compiled:
    from cython.cimports.cncgen.kernels.gcode_arithmetic import arc_tangent, function_of, joined, operator_at
else:
    from cncgen.kernels.gcode_arithmetic import arc_tangent, function_of, joined, operator_at

#: Flags of a block (`gcode_scan`).
_COMMENT = cython.declare(cython.int, 2)
_NUMBERED = cython.declare(cython.int, 8)

#: How far from a whole number the number of a parameter may be (`expressions.EQUAL`).
_WHOLE = cython.declare(cython.double, 1e-4)
#: Larger numbers in words are faults (`block.LARGEST`).
_LARGEST = cython.declare(cython.double, 1e9)
#: Parameters below this are plain storage; the others belong to the machine.
_STORED = cython.declare(cython.int, 5000)
#: Brackets and parameters of parameters within one another (`grammar.MAX_NESTING`).
_DEPTH = cython.declare(cython.int, 60)
#: Digits of a number that is read here: its integer and its power of ten are doubles without error.
_DIGITS = cython.declare(cython.int, 15)

#: Letters of words that are taken, as bits (A is bit 0): not D E H N O T, which tools, parameters and jumps hang on.
_LETTERS = cython.declare(cython.uint, 0)
#: Letters that may stand more than once in a block: G and M.
_CODES = cython.declare(cython.uint, 1 << 6 | 1 << 12)
#: G and M codes that are taken: none that reads or sets a parameter, or leads elsewhere.
_G_TAKEN = cython.declare(cython.uchar[100])
_M_TAKEN = cython.declare(cython.uchar[10])

#: How tight the operators bind that bind the least (`gcode_arithmetic`).
_LOGIC = cython.declare(cython.int, 1)
#: Letters of a function of two arguments, ATAN, five bits each; longer names than this many letters are none.
_ATAN = cython.declare(cython.uint, 1 << 15 | 20 << 10 | 1 << 5 | 14)
_LONGEST = cython.declare(cython.int, 6)


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


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _is_letter(c: cython.int) -> cython.bint:
    """Tell whether a byte is a letter."""
    return 97 <= (c | 32) <= 122


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
            self._line_number()
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
    def _line_number(self) -> cython.void:
        """Go past an N word, whose number begins with a digit."""
        self.i += 1
        if 48 <= self._byte() <= 57:
            self._number()
        else:
            self.certain = False

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
            self._line_number()
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
        if not self.certain or fabs(value - whole) > _WHOLE or not 0.0 < whole < _STORED:
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
        # Parameters that tell the machine's state are not stored, so they are not found.
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
        value = self._expression(_LOGIC)
        self._take(93)
        return value

    @cython.cfunc
    def _expression(self, level: cython.int) -> cython.double:
        """Read operands and operators that bind at least so tight, from the left."""
        value: cython.double = self._signed()
        other: cython.double
        operator: cython.int = self._operator()
        while self.certain and operator >> 8 >= level:
            self.i += operator >> 4 & 15
            other = self._expression((operator >> 8) + 1)
            value = joined(operator, value, other)
            if value != value:
                self.certain = False
            operator = self._operator()
        return value

    @cython.cfunc
    @cython.exceptval(check=False)
    def _operator(self) -> cython.int:
        """Return the operator that stands here, 0 where none does (`gcode_arithmetic.operator_at`)."""
        c: cython.int = self._byte()
        i: cython.Py_ssize_t = self.i
        length: cython.Py_ssize_t = self.text.shape[0]
        if c == 10 or c == 93:
            return 0
        return operator_at(
            c,
            cython.cast(cython.int, self.text[i + 1]) if i + 1 < length else 10,
            cython.cast(cython.int, self.text[i + 2]) if i + 2 < length else 10,
        )

    @cython.cfunc
    def _function(self) -> cython.double:
        """Read a function and its argument."""
        name: cython.uint = 0
        letters: cython.int = 0
        value: cython.double
        c: cython.int = self._byte()
        while _is_letter(c) and letters < _LONGEST:
            name = (name << 5) | (c & 31)
            letters += 1
            self.i += 1
            c = cython.cast(cython.int, self.text[self.i]) if self.i < self.text.shape[0] else 10
        value = self._bracket()
        if not self.certain:
            return 0.0
        if name == _ATAN:
            self._take(47)
            return arc_tangent(value, self._bracket())
        value = function_of(name, value)
        if not isfinite(value):
            self.certain = False
        return value
