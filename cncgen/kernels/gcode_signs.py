# cython: infer_types=True
"""The different lines of a text in which signs of a dialect are looked for: mostly coordinates tell lines of a program apart, and
no sign hangs on what they are.
"""

import cython

#: Letters of coordinates, as bits (A is bit 0).
_COORDINATES = cython.declare(cython.uint, sum(1 << (ord(letter) - 65) for letter in "XYZIJK"))
#: Sums of lines have 32 bits; places to find lines by them.
_ALL = cython.declare(cython.uint, 0xFFFFFFFF)
_SUMS = cython.declare(cython.uint, 4096)
#: Bytes of a line beyond which it is no block, and counts as empty: a sign looks for what follows anywhere in a line, from each place in it.
_LONGEST = cython.declare(cython.Py_ssize_t, 512)

#: A number of a text: its end, whether it has a point, and whether something other than its value counts.
_Number = cython.struct(to=cython.Py_ssize_t, dotted=cython.bint, alike=cython.bint)
#: A line: its end in the text, and the end of what is kept of it.
_Line = cython.struct(to=cython.Py_ssize_t, used=cython.Py_ssize_t)


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _number(
    text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, letter: cython.int, operand: cython.bint
) -> _Number:
    """Return the number at a place, behind a coordinate's letter, F, N or O, or as an operand."""
    to: cython.Py_ssize_t = at
    size: cython.Py_ssize_t = len(text)
    dotted: cython.bint = False
    large: cython.bint = False
    while to < size and (48 <= text[to] <= 57 or (text[to] == 46 and not dotted)):
        if text[to] == 46:
            dotted = True
        elif text[to] != 48 and not dotted:
            large = True
        to += 1
    if to == at + dotted:
        # A point alone is no number.
        return _Number(to=to, dotted=False, alike=False)
    if operand:
        return _Number(to=to, dotted=dotted and letter != 70, alike=True)
    if letter == 70:
        return _Number(to=to, dotted=False, alike=large)
    if letter == 78 or letter == 79:
        # N, and O with a keyword behind its number, which a blank or a letter begins.
        ends: cython.bint = letter == 78 or (
            to < size and (text[to] == 32 or text[to] == 9 or 97 <= (text[to] | 32) <= 122)
        )
        return _Number(to=to, dotted=False, alike=ends and not dotted)
    return _Number(to=to, dotted=dotted, alike=dotted)


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _kept(
    text: cython.const[cython.uchar][::1],
    at: cython.Py_ssize_t,
    line: cython.uchar[::1],
    used: cython.Py_ssize_t,
) -> _Line:
    """Write the line at a place as it is kept, from `used` on."""
    size: cython.Py_ssize_t = len(text)
    begin: cython.Py_ssize_t = used
    letter: cython.int = 0
    inside: cython.int = 0
    operand: cython.bint = False
    c: cython.int
    number: _Number
    while at < size and text[at] != 10:
        c = text[at]
        if 97 <= c <= 122:
            c -= 32
        if (letter != 0 or operand) and (48 <= c <= 57 or c == 46):
            number = _number(text, at, letter, operand)
            letter = 0
            if number.alike:
                line[used] = 49
                used += 1
                if number.dotted:
                    line[used] = 46
                    used += 1
                at = number.to
                operand = False
                continue
        line[used] = c
        used += 1
        at += 1
        if 65 <= c <= 90:
            letter = (
                c if c == 70 or _COORDINATES >> (c - 65) & 1 or (78 <= c <= 79 and used == begin + 1) else 0
            )
        elif c != 32 and c != 9 and c != 43 and c != 45:
            letter = 0
        inside += (c == 91) - (c == 93)
        # Behind a bracket, a blank or an operator stands a number by itself.
        operand = inside > 0 and (c == 91 or c == 32 or c == 42 or c == 43 or c == 45 or c == 47)
    line[used] = 10
    return _Line(to=at, used=used)


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _sum(
    line: cython.const[cython.uchar][::1], begin: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> cython.uint:
    """Return a sum of the bytes of a line, by which it is found."""
    total: cython.uint = 0
    for k in range(begin, end):
        total = (total * 33 + line[k]) & _ALL
    return total


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _same(
    line: cython.const[cython.uchar][::1], one: cython.Py_ssize_t, other: cython.Py_ssize_t
) -> cython.bint:
    """Tell whether two lines, each with its end, are the same."""
    while line[one] == line[other] and line[one] != 10:
        one += 1
        other += 1
    return line[one] == line[other]


def different_lines(text: cython.const[cython.uchar][::1], stand: list | None = None) -> tuple:
    """Return the lines of a text in capitals, each once in the order of the first ones, their numbers and how often each stands there.

    Each line of `text` stands for so many as `stand` says, for one without that.
    A coordinate with a decimal point is written ``1.``, and a feed of at least 1, the whole number of a line and that of an O-word as 1;
    in brackets any number but that of a parameter. Lines that are longer than any block are empty.
    """
    size: cython.Py_ssize_t = len(text)
    # The lines that differ, each with its end; where each begins, and the one before it of the same sum, from 1 on; the last of a sum.
    store = bytearray(size + 2)
    line: cython.uchar[::1] = store
    rows: cython.int[:, ::1] = memoryview(bytearray(8 * (size // 2 + 2))).cast("i", [size // 2 + 2, 2])
    last: cython.int[::1] = memoryview(bytearray(4 * _SUMS)).cast("i")
    numbers: list = []
    counts: list = []
    number: cython.longlong = 0
    used: cython.Py_ssize_t = 0
    count: cython.Py_ssize_t = 0
    i: cython.Py_ssize_t = 0
    row: cython.Py_ssize_t
    kept: _Line
    while i < size:
        number += 1
        kept = _kept(text, i, line, used)
        i = kept.to + 1
        if kept.used - used > _LONGEST:
            kept = _Line(to=kept.to, used=used)
            line[used] = 10
        slot = _sum(line, used, kept.used) % _SUMS
        row = last[slot]
        while row > 0 and not _same(line, rows[row - 1, 0], used):
            row = rows[row - 1, 1]
        if row > 0:
            counts[row - 1] += stand[number - 1] if stand is not None else 1
        else:
            rows[count, 0], rows[count, 1] = used, last[slot]
            count += 1
            last[slot] = count
            used = kept.used + 1
            numbers.append(number)
            counts.append(stand[number - 1] if stand is not None else 1)
    return bytes(store[: max(used - 1, 0)]), numbers, counts


def unit_place(
    text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, tens: cython.int
) -> cython.Py_ssize_t:
    """Return the first place from `at` on of G with so many tens and 0 or 1 behind it (G20, g71), as units are written; -1 for none."""
    for i in range(max(at, 0), text.shape[0] - 2):
        if text[i + 2] | 1 == 49 and text[i + 1] == 48 + tens and text[i] | 32 == 103:
            return i
    return -1
