# cython: infer_types=True
"""Rows of numbers to decimal text and back, for csv, jsonl and hal output and for the reader of setpoint files.

Writing. A number is printed with nine decimals (or none), correctly rounded: the decimal nearest to the double's
exact value, ties to the even digit, as C's printf and Python's format do. Split |x| = i + f, i integer and 0 <= f < 1
(both exact). The digits after the point are f 10⁹ rounded. The product in doubles errs by less than 1e-7, so its
rounding is right unless it falls within 1e-6 of a half; then `_rounds_up` decides exactly: f is cut into pieces of
31 bits (f = f1 + f2 + f3), and since 10⁹ = 2⁹ 5⁹ needs 21 bits, f1 10⁹ and f2 10⁹ are exact doubles; f3, nonzero only
for f < 2⁻¹⁰, is exact too as long as f >= 2⁻⁴², and below that nothing is near a half.

Reading. A decimal of at most 15 digits is an integer m <= 2⁵³ over 10ᵏ with k <= 22, both exact, so m / 10ᵏ is the
correctly rounded double (Clinger 1990, "How to read floating point numbers accurately"). A row with anything else in
it (an exponent, more digits, a word) is left to the caller.
"""

import cython
from cython.cimports.libc.math import fabs, floor

#: Bytes that a number may need: sign, 16 digits, point, nine digits.
MAX_WIDTH = 27

#: Numbers must be smaller than this to be written (2⁵³: above it a double has no digits after the point).
MAX_VALUE = 9007199254740992.0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _rounds_up(f: cython.double, q: cython.double) -> cython.bint:
    """Tell whether f 10⁹, which lies within 1e-6 of q + 1/2, rounds to q + 1 (ties to even); exact."""
    f1: cython.double = floor(f * 2147483648.0) / 2147483648.0
    rest: cython.double = f - f1
    f2: cython.double = floor(rest * 4611686018427387904.0) / 4611686018427387904.0
    f3: cython.double = rest - f2
    d: cython.double = ((f1 * 1e9 - q) - 0.5 + f2 * 1e9) + f3 * 1e9
    if d != 0.0:
        return d > 0.0
    return q - 2.0 * floor(q / 2.0) != 0.0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _put_integer(out: cython.uchar[::1], at: cython.Py_ssize_t, value: cython.ulonglong) -> cython.Py_ssize_t:
    """Write a non-negative integer; return the place after it."""
    width: cython.Py_ssize_t = 1
    rest: cython.ulonglong = value
    while rest >= 10:
        rest //= 10
        width += 1
    rest = value
    for k in range(at + width - 1, at - 1, -1):
        out[k] = 48 + rest % 10
        rest //= 10
    return at + width


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _put_number(
    out: cython.uchar[::1], at: cython.Py_ssize_t, x: cython.double, decimals: cython.int
) -> cython.Py_ssize_t:
    """Write a number with nine decimals or none; return the place after it. A rounded zero has no sign."""
    size: cython.double = fabs(x)
    whole: cython.double = floor(size)
    f: cython.double = size - whole
    digits: cython.double = 0.0
    if decimals == 0:
        if f > 0.5 or (f == 0.5 and whole - 2.0 * floor(whole / 2.0) != 0.0):
            whole += 1.0
    else:
        scaled = f * 1e9
        digits = floor(scaled)
        if fabs(scaled - digits - 0.5) < 1e-6:
            if _rounds_up(f, digits):
                digits += 1.0
        elif scaled - digits > 0.5:
            digits += 1.0
        if digits >= 1e9:
            digits -= 1e9
            whole += 1.0
    if x < 0.0 and (whole > 0.0 or digits > 0.0):
        out[at] = 45
        at += 1
    at = _put_integer(out, at, cython.cast(cython.ulonglong, whole))
    if decimals > 0:
        out[at] = 46
        rest = cython.cast(cython.ulonglong, digits)
        for k in range(at + 9, at, -1):
            out[k] = 48 + rest % 10
            rest //= 10
        at += 10
    return at


def write_rows(
    values: cython.double[:, ::1],
    decimals: cython.int[::1],
    literals: cython.uchar[::1],
    ends: cython.longlong[::1],
    out: cython.uchar[::1],
) -> cython.Py_ssize_t:
    """Write rows of numbers, each number after a literal of its column, each row closed by the last literal.

    Args:
        values: Shape (n, k), finite, |value| < `MAX_VALUE`.
        decimals: Shape (k,): 9 or 0 of each column.
        literals: The k + 1 literals end to end.
        ends: Shape (k + 1,): where each literal ends in `literals`.
        out: At least n (k `MAX_WIDTH` + length of the literals) bytes.

    Returns:
        How many bytes of `out` were written.
    """
    n: cython.Py_ssize_t = values.shape[0]
    columns: cython.Py_ssize_t = values.shape[1]
    at: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t
    literal: cython.Py_ssize_t
    with cython.nogil:
        for i in range(n):
            literal = 0
            for j in range(columns):
                for k in range(literal, ends[j]):
                    out[at] = literals[k]
                    at += 1
                literal = ends[j]
                at = _put_number(out, at, values[i, j], decimals[j])
            for k in range(literal, ends[columns]):
                out[at] = literals[k]
                at += 1
    return at


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _spaces(text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return the place after spaces and carriage returns."""
    while at < text.shape[0] and (text[at] == 32 or text[at] == 13):
        at += 1
    return at


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _read_number(
    text: cython.const[cython.uchar][::1],
    at: cython.Py_ssize_t,
    powers: cython.double[::1],
    out: cython.double[:, ::1],
    row: cython.Py_ssize_t,
    column: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """Read a plain decimal into ``out[row, column]``; return the place after it, -1 where no number stands."""
    size: cython.Py_ssize_t = text.shape[0]
    mantissa: cython.ulonglong = 0
    digits: cython.int = 0
    decimals: cython.int = 0
    point: cython.bint = False
    negative: cython.bint = False
    if at < size and (text[at] == 45 or text[at] == 43):
        negative = text[at] == 45
        at += 1
    while at < size:
        c = cython.cast(cython.int, text[at])
        if c == 46 and not point:
            point = True
        elif 48 <= c <= 57 and digits < 18:
            mantissa = mantissa * 10 + (c - 48)
            digits += 1
            decimals += point
        else:
            break
        at += 1
    if digits == 0 or mantissa > cython.cast(cython.ulonglong, 9007199254740992):
        return -1
    out[row, column] = mantissa / powers[decimals]
    if negative:
        out[row, column] = -out[row, column]
    return at


def read_rows(
    text: cython.const[cython.uchar][::1],
    start: cython.Py_ssize_t,
    row: cython.Py_ssize_t,
    powers: cython.double[::1],
    out: cython.double[:, ::1],
    state: cython.longlong[::1],
) -> cython.void:
    """Read rows ``number,number,…`` of whole lines from `start` into `out` from `row` on.

    Stops at the end of the text, when `out` is full, or at the start of a line other than a plain row of
    ``out.shape[1]`` decimals of at most 15 digits. Spaces beside a number and a carriage return at the end are
    passed over.

    Args:
        text: Whole lines, each ended by a line feed.
        start: Where the first line begins.
        row: First row of `out` to fill.
        powers: Shape (23,): 10⁰ to 10²².
        out: Shape (rows, columns).
        state: Shape (2,): receives the place where reading stopped and the row reached.
    """
    size: cython.Py_ssize_t = text.shape[0]
    rows: cython.Py_ssize_t = out.shape[0]
    columns: cython.Py_ssize_t = out.shape[1]
    line: cython.Py_ssize_t = start
    at: cython.Py_ssize_t = start
    with cython.nogil:
        while line < size and row < rows:
            at = line
            for column in range(columns):
                at = _read_number(text, _spaces(text, at), powers, out, row, column)
                if at < 0:
                    break
                at = _spaces(text, at)
                if at >= size or text[at] != (44 if column + 1 < columns else 10):
                    at = -1
                    break
                at += 1
            if at < 0:
                break
            row += 1
            line = at
    state[0] = line
    state[1] = row
