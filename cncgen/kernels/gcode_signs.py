"""The different lines of a text in which signs of a dialect are looked for: mostly coordinates tell lines of a program apart, and
no sign hangs on what they are.
"""

import cython

#: Letters of coordinates, as bits (A is bit 0).
_COORDINATES = cython.declare(cython.uint, sum(1 << (ord(letter) - 65) for letter in "XYZIJK"))


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _goes_on(c: cython.int) -> cython.bint:
    """Tell whether a byte is a blank or a letter."""
    return c == 32 or c == 9 or 97 <= (c | 32) <= 122


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
    used: cython.Py_ssize_t
    place: cython.Py_ssize_t
    to: cython.Py_ssize_t
    i: cython.Py_ssize_t = 0
    c: cython.int
    letter: cython.int
    inside: cython.int
    operand: cython.bint
    dotted: cython.bint
    large: cython.bint
    while i < size:
        number += 1
        used = 0
        letter = inside = 0
        operand = False
        while i < size and text[i] != 10:
            c = text[i]
            if 97 <= c <= 122:
                c -= 32
            if (letter != 0 or operand) and (48 <= c <= 57 or c == 46):
                to = i
                dotted = large = False
                while to < size and (48 <= text[to] <= 57 or (text[to] == 46 and not dotted)):
                    if text[to] == 46:
                        dotted = True
                    elif text[to] != 48 and not dotted:
                        large = True
                    to += 1
                if letter == 78 or letter == 79:
                    # N, and O with a keyword behind its number.
                    large = not dotted and (letter == 78 or (to < size and _goes_on(text[to])))
                if operand or (large if letter == 70 or letter == 78 or letter == 79 else dotted):
                    line[used] = 49
                    used += 1
                    if dotted and letter != 70:
                        line[used] = 46
                        used += 1
                    i = to
                    letter = 0
                    operand = False
                    continue
                letter = 0
            line[used] = c
            used += 1
            i += 1
            if 65 <= c <= 90:
                letter = c if c == 70 or _COORDINATES >> (c - 65) & 1 or (78 <= c <= 79 and used == 1) else 0
            elif c != 32 and c != 9 and c != 43 and c != 45:
                letter = 0
            if c == 91:
                inside += 1
            elif c == 93:
                inside -= 1
            # Behind a bracket, a blank or an operator stands a number by itself.
            operand = inside > 0 and (c == 91 or c == 32 or c == 42 or c == 43 or c == 45 or c == 47)
        i += 1
        key = bytes(store[:used])
        found = places.get(key)
        if found is None:
            places[key] = len(numbers)
            numbers.append(number)
            counts.append(stand[number - 1] if stand is not None else 1)
        else:
            place = found
            counts[place] += stand[number - 1] if stand is not None else 1
    return b"\n".join(places), numbers, counts
