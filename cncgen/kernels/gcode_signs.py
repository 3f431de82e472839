"""The different lines of a text in which signs of a dialect are looked for: mostly coordinates tell lines of a program apart, and
no sign hangs on what they are.
"""

import cython

#: Letters of coordinates, as bits (A is bit 0).
_COORDINATES = cython.declare(cython.uint, sum(1 << (ord(letter) - 65) for letter in "XYZIJK"))


#: A number of a text: its end, whether it has a point, and whether something other than its value counts.
_Number = cython.struct(to=cython.Py_ssize_t, dotted=cython.bint, alike=cython.bint)
#: A line: its end in the text, and its length as it is kept.
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
def _kept(text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, line: cython.uchar[::1]) -> _Line:
    """Write the line at a place as it is kept."""
    size: cython.Py_ssize_t = len(text)
    used: cython.Py_ssize_t = 0
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
            letter = c if c == 70 or _COORDINATES >> (c - 65) & 1 or (78 <= c <= 79 and used == 1) else 0
        elif c != 32 and c != 9 and c != 43 and c != 45:
            letter = 0
        inside += (c == 91) - (c == 93)
        # Behind a bracket, a blank or an operator stands a number by itself.
        operand = inside > 0 and (c == 91 or c == 32 or c == 42 or c == 43 or c == 45 or c == 47)
    return _Line(to=at, used=used)


def different_lines(text: cython.const[cython.uchar][::1], stand: list | None = None) -> tuple:
    """Return the lines of a text in capitals, each once in the order of the first ones, their numbers and how often each stands there.

    Each line of `text` stands for so many as `stand` says, for one without that.
    A coordinate with a decimal point is written ``1.``, and a feed of at least 1, the whole number of a line and that of an O-word as 1;
    in brackets any number but that of a parameter.
    """
    size: cython.Py_ssize_t = len(text)
    store = bytearray(size + 1)
    line: cython.uchar[::1] = store
    places: dict = {}
    numbers: list = []
    counts: list = []
    number: cython.longlong = 0
    place: cython.Py_ssize_t
    i: cython.Py_ssize_t = 0
    kept: _Line
    while i < size:
        number += 1
        kept = _kept(text, i, line)
        i = kept.to + 1
        key = bytes(store[: kept.used])
        found = places.get(key)
        if found is None:
            places[key] = len(numbers)
            numbers.append(number)
            counts.append(stand[number - 1] if stand is not None else 1)
        else:
            place = found
            counts[place] += stand[number - 1] if stand is not None else 1
    return b"\n".join(places), numbers, counts


def unit_place(
    text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, tens: cython.int
) -> cython.Py_ssize_t:
    """Return the first place from `at` on of G with so many tens and 0 or 1 behind it (G20, g71), as units are written; -1 for none."""
    i: cython.Py_ssize_t
    for i in range(max(at, 0), text.shape[0] - 2):
        if text[i + 2] | 1 == 49 and text[i + 1] == 48 + tens and text[i] | 32 == 103:
            return i
    return -1
