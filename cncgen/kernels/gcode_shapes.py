"""Lines of G-code by their shape, which is their text without the numbers: ``g1x#[#+#*sin[#]]`` of ``G1 X[5 + 3.2 * SIN[30]]``.

To the tables of a grammar all digits are one, and it does not matter how many stand together (``lalr.py`` sees to that). So lines of
one shape have the same instructions, and push other numbers. `gcode_parse` reads the first line of a shape by the tables, and of
those that follow the numbers alone, which takes a sixth of the time.
"""

import cython
from cython.cimports.libc.math import copysign, fabs

#: Longest line, shapes, and bytes of them that are kept.
_LONGEST = cython.declare(cython.Py_ssize_t, 240)
_SHAPES = cython.declare(cython.Py_ssize_t, 512)
_STORE = cython.declare(cython.Py_ssize_t, 1 << 16)
#: Sums have 32 bits.
_ALL = cython.declare(cython.uint, 0xFFFFFFFF)
#: Columns of the table: sum of the shape, where it stands in the store (-1: nowhere) with the signs of its numbers behind it, its
#: length, and common data of its lines: the begin of their code, and their marks.
_SUM = cython.declare(cython.int, 0)
_PLACE = cython.declare(cython.int, 1)
_LENGTH = cython.declare(cython.int, 2)
_CODE = cython.declare(cython.int, 3)
_MARKS = cython.declare(cython.int, 4)
_WIDTH = 5

#: Kinds of bytes: those that stand for themselves in a shape as small letters, and these.
_UNKNOWN = cython.declare(cython.int, 0)
_BLANK = cython.declare(cython.int, 1)
_LINE_END = cython.declare(cython.int, 2)
_DIGIT = cython.declare(cython.int, 3)
#: Forms of numbers in a shape: 1, 1.5 and .5.
_WHOLE = cython.declare(cython.int, 4)
_DOTTED = cython.declare(cython.int, 5)
_POINT_FIRST = cython.declare(cython.int, 6)
_FOLD = cython.declare(cython.uchar[256])
_POWERS = cython.declare(cython.double[23])
#: Digits that a mantissa of 64 bits holds, and the integer up to which doubles have no gaps.
_DIGITS = cython.declare(cython.int, 18)
_EXACT = cython.declare(cython.ulonglong, 9007199254740992)


@cython.cfunc
def _fill_tables() -> cython.void:
    """Fill the tables of bytes and powers, once."""
    c: cython.int
    for c in range(256):
        # Comments and bytes beyond ASCII are not taken.
        _FOLD[c] = c if 32 < c < 127 and c != 40 and c != 41 and c != 59 else _UNKNOWN
    for c in range(65, 91):
        _FOLD[c] = c + 32
    for c in b"0123456789.":
        _FOLD[c] = _DIGIT
    for c in b" \t\r":
        _FOLD[c] = _BLANK
    _FOLD[10] = _LINE_END
    for c in range(23):
        _POWERS[c] = 10.0**c


_fill_tables()


#: A number, its form (0 where it is not certain), and the offset behind it.
_Number = cython.struct(value=cython.double, form=cython.int, after=cython.Py_ssize_t)


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _number(text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, size: cython.Py_ssize_t) -> _Number:
    """Read the number without a sign at `at`, with blanks anywhere in it."""
    mantissa: cython.ulonglong = 0
    digits: cython.int = 0
    decimals: cython.int = -1
    form: cython.int = _POINT_FIRST if text[at] == 46 else _WHOLE
    value: cython.double
    c: cython.int
    while at < size:
        c = text[at]
        if 48 <= c <= 57:
            mantissa = mantissa * 10 + cython.cast(cython.ulonglong, c - 48)
            digits += 1
        elif c == 46 and decimals < 0:
            # Digits up to here are none of the decimals.
            decimals = digits
        elif _FOLD[c] != _BLANK:
            break
        at += 1
    if digits == 0 or digits > _DIGITS or mantissa > _EXACT or (at < size and text[at] == 46):
        return _Number(value=0.0, form=0, after=at)
    value = cython.cast(cython.double, mantissa)
    if decimals >= 0:
        if form == _WHOLE:
            form = _DOTTED
        # Both are doubles without error, so the quotient is rounded once (Clinger, as in `part21_scan.points`).
        value /= _POWERS[digits - decimals]
    return _Number(value=value, form=form, after=at)


@cython.final
@cython.cclass
class Shapes:
    """The shapes that are known, and the line that was looked at last."""

    def __init__(self):
        if not cython.compiled:
            self.shape, self.value = bytearray(256), [0.0] * 256
        self.store = bytearray(_STORE)
        self.table = memoryview(bytearray(8 * _WIDTH * _SHAPES)).cast("q", [_SHAPES, _WIDTH])
        self.forget()

    @cython.ccall
    @cython.exceptval(check=False)
    def forget(self) -> cython.void:
        """Forget all shapes."""
        k: cython.Py_ssize_t
        self.sum = self.length = self.count = self.stored = 0
        for k in range(_SHAPES):
            self.table[k, _PLACE] = -1

    @cython.ccall
    @cython.exceptval(check=False)
    def read(self, text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Take shape and numbers of the line at `at`; return the offset of its end, -1 where they are not certain.

        Names and the numbers of parameters (#1) belong to the shape. That of the line is none that is pushed.
        """
        size: cython.Py_ssize_t = min(text.shape[0], at + _LONGEST)
        length: cython.Py_ssize_t = 0
        count: cython.Py_ssize_t = 0
        total: cython.uint = 0
        last: cython.int = 0
        named: cython.bint = False
        number: _Number
        c: cython.int
        while at < size:
            c = _FOLD[text[at]]
            if c > _POINT_FIRST:
                at += 1
                last = c
                if c | 2 == 62:
                    # A name begins with < and ends with >.
                    named = c == 60
            elif c == _BLANK:
                at += 1
                continue
            elif c == _LINE_END:
                break
            elif c == _UNKNOWN:
                return -1
            elif named or last == 35:
                c = text[at]
                at += 1
            else:
                number = _number(text, at, size)
                if number.form == 0:
                    return -1
                c = number.form
                at = number.after
                if last != 110:
                    self.value[count] = number.value
                    count += 1
                last = c
            total = total * 33 + c
            self.shape[length] = c
            length += 1
        if at == size and at < text.shape[0] and text[at] != 10:
            return -1
        self.sum, self.length, self.count = total & _ALL, length, count
        return at

    @cython.ccall
    @cython.exceptval(check=False)
    def find(self) -> cython.Py_ssize_t:
        """Return the row of the shape of the line; -1 where it is not known."""
        row: cython.Py_ssize_t = self.sum % _SHAPES
        place: cython.Py_ssize_t = self.table[row, _PLACE]
        k: cython.Py_ssize_t
        if place < 0 or self.table[row, _SUM] != self.sum or self.table[row, _LENGTH] != self.length:
            return -1
        for k in range(self.length):
            if self.store[place + k] != self.shape[k]:
                return -1
        return row

    @cython.ccall
    @cython.exceptval(check=False)
    def put(
        self, row: cython.Py_ssize_t, constants: cython.double[::1], first: cython.Py_ssize_t
    ) -> cython.Py_ssize_t:
        """Write the numbers of the line, whose shape is that of a row, as constants from `first` on; return how many."""
        signs: cython.Py_ssize_t = self.table[row, _PLACE] + self.length
        k: cython.Py_ssize_t
        for k in range(self.count):
            constants[first + k] = -self.value[k] if self.store[signs + k] else self.value[k]
        return self.count

    @cython.ccall
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
        k: cython.Py_ssize_t
        if end - first != self.count:
            return
        for k in range(self.count):
            if fabs(constants[first + k]) != self.value[k]:
                return
        if place + self.length + self.count > _STORE:
            self.stored = place = 0
            for k in range(_SHAPES):
                self.table[k, _PLACE] = -1
        for k in range(self.length):
            self.store[place + k] = self.shape[k]
        for k in range(self.count):
            self.store[place + self.length + k] = copysign(1.0, constants[first + k]) < 0.0
        self.stored = place + self.length + self.count
        self.table[row, _SUM], self.table[row, _PLACE] = self.sum, place
        self.table[row, _LENGTH], self.table[row, _CODE], self.table[row, _MARKS] = self.length, code, marks
