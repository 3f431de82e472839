# cython: infer_types=True
"""Decimal numbers and characters of programs; kernels that read text call these as C, by ``decimals.pxd``."""

import cython

_NAN = cython.declare(cython.double, float("nan"))
#: Digits that a mantissa of 64 bits holds, and the integer up to which doubles have no gaps.
_DIGITS = cython.declare(cython.int, 18)
_EXACT = cython.declare(cython.ulonglong, 9007199254740992)
#: Powers of ten that are doubles without error.
_POWERS = cython.declare(cython.double[23])
_power: cython.int
for _power in range(23):
    _POWERS[_power] = 10.0**_power


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def decimal(mantissa: cython.ulonglong, digits: cython.int, decimals: cython.int) -> cython.double:
    """Return the double nearest to a number of so many digits, of which `decimals` stand behind the point; NaN where that is not certain.

    It is certain of one digit to 18 whose integer is a double: that and the power of ten are doubles without error, so the quotient is
    rounded once (Clinger, "How to read floating point numbers accurately", 1990).
    """
    if digits == 0 or digits > _DIGITS or mantissa > _EXACT:
        return _NAN
    if decimals > 0:
        return cython.cast(cython.double, cython.cast(cython.longlong, mantissa)) / _POWERS[decimals]
    return cython.cast(cython.double, cython.cast(cython.longlong, mantissa))


@cython.final
@cython.cclass
class Numbers:
    """The numbers without a sign that stand in a text: digits with at most one point.

    Args:
        text: The text.
        comma: Whether a comma may stand for the point.
        blanks: Whether blanks may stand within a number, and are read with it.

    Attributes:
        value: The number that was read last, NaN where it is not certain.
        mantissa: Its digits as a whole number.
        decimals: How many of its digits stand behind the point, -1 without one.
    """

    def __init__(self, text, comma: bool, blanks: bool):
        self.text, self.comma, self.blanks = text, 44 if comma else 46, blanks
        self.value, self.decimals = _NAN, -1

    @cython.cfunc
    @cython.exceptval(check=False)
    def read(self, at: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Read the number at `at`, which ends at `end` at the latest; return the offset behind it."""
        whole: cython.Py_ssize_t
        self.mantissa, self.decimals = 0, -1
        after: cython.Py_ssize_t = self._digits(at, end)
        digits: cython.int = cython.cast(cython.int, after - at)
        if after < end and (self.text[after] == 46 or self.text[after] == self.comma):
            whole = after + 1
            after = self._digits(whole, end)
            self.decimals = cython.cast(cython.int, after - whole)
            digits += self.decimals
        if self.blanks and after < end and is_blank(self.text[after]):
            while after < end and is_blank(self.text[after]):
                after += 1
            # Behind most numbers stands a letter.
            if after < end and self.text[after] < 65:
                return self._go_on(after, end, digits)
        self.value = decimal(self.mantissa, digits, self.decimals)
        return after

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _digits(self, at: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Read digits into `mantissa`; return the offset behind them."""
        mantissa: cython.ulonglong = self.mantissa
        c: cython.int
        k: cython.Py_ssize_t = at
        while k < end:
            c = cython.cast(cython.int, self.text[k]) - 48
            if not 0 <= c <= 9:
                break
            mantissa = mantissa * 10 + cython.cast(cython.ulonglong, c)
            k += 1
        self.mantissa = mantissa
        return k

    @cython.cfunc
    @cython.exceptval(check=False)
    def _go_on(self, at: cython.Py_ssize_t, end: cython.Py_ssize_t, digits: cython.int) -> cython.Py_ssize_t:
        """Read on behind `digits` of a number, at a blank."""
        while at < end:
            c = self.text[at]
            after = self._digits(at, end)
            digits += after - at
            self.decimals += (after - at) * (self.decimals >= 0)
            if (c == 46 or c == self.comma) and self.decimals < 0:
                self.decimals = 0
            elif not (48 <= c <= 57 or is_blank(c)):
                break
            at = after if after > at else at + 1
        self.value = decimal(self.mantissa, digits, self.decimals)
        return at


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def is_blank(c: cython.int) -> cython.bint:
    """Tell whether a character is a blank."""
    return c == 32 or c == 9 or c == 13


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def is_of_name(c: cython.int) -> cython.bint:
    """Tell whether a character may stand in a name."""
    return 48 <= c <= 57 or 97 <= (c | 32) <= 122 or c == 95
