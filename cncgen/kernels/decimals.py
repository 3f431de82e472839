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
        return cython.cast(cython.double, mantissa) / _POWERS[decimals]
    return cython.cast(cython.double, mantissa)


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
