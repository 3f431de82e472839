"""Scan bytes of G-code into columns: the fast lane of blocks that are nothing but letter-number words and comments.

The scanner never judges: a line that it does not take for certain (an expression, an O-word, ``%``, a nested or open
comment, a number of more digits than a double holds exactly) stops it, and the grammar reads that line instead.
"""

import cython

#: Why `scan` came back.
END = 0
FULL = 1
OTHER = 2

#: Flags of a block.
SLASH = 1
COMMENT = 2
ACTIVE = 4
NUMBERED = 8

_POWERS = [10.0**k for k in range(23)]


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _letter_of(c: cython.int) -> cython.int:
    """Lower-case letter of a word, or 0; N, O and what is no letter are none."""
    if 65 <= c <= 90:
        c += 32
    if 97 <= c <= 122 and c != 110 and c != 111:
        return c
    return 0


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _is_active(initial: cython.int, length: cython.int) -> cython.bint:
    """Tell by first letter and length whether a comment's keyword may be one that does something.

    ABORT, DEBUG, PRINT, START, MSG, LOG, LOGOPEN, LOGAPPEND.
    """
    if length == 5:
        return initial == 97 or initial == 100 or initial == 112 or initial == 115
    if initial == 108:
        return length == 3 or length == 7 or length == 9
    return initial == 109 and length == 3


def scan(
    text: cython.const[cython.uchar][::1],
    offset: cython.Py_ssize_t,
    line: cython.longlong,
    block_line: cython.longlong[::1],
    block_offset: cython.longlong[::1],
    block_flags: cython.uchar[::1],
    word_end: cython.longlong[::1],
    letters: cython.uchar[::1],
    values: cython.double[::1],
) -> tuple:
    """Read plain blocks from `offset` on until a column is full, the text ends or a line is not plain.

    Args:
        text: The whole program.
        offset: Where a line begins.
        line: Its number, from 1.
        block_line, block_offset, block_flags: Filled, a block each (lines without words or comment are left out).
        word_end: Filled; words of block b are ``letters[word_end[b-1]:word_end[b]]`` (from 0 for the first).
        letters: Filled with lower-case letters (bytes); N is only a flag.
        values: Filled with the numbers, the doubles nearest to their decimal text.

    Returns:
        Blocks read, words read, offset and line of the first line not read, and why: `END`, `FULL`, `OTHER`.
    """
    powers = cython.declare(cython.double[23])
    k: cython.int
    for k in range(23):
        powers[k] = _POWERS[k]
    length: cython.Py_ssize_t = text.shape[0]
    block_room: cython.Py_ssize_t = block_line.shape[0]
    word_room: cython.Py_ssize_t = letters.shape[0]
    blocks: cython.Py_ssize_t = 0
    words: cython.Py_ssize_t = 0
    i: cython.Py_ssize_t = offset
    begin: cython.Py_ssize_t
    first: cython.Py_ssize_t
    c: cython.int
    letter: cython.int
    flags: cython.int
    digits: cython.int
    decimals: cython.int
    negative: cython.bint
    dotted: cython.bint
    phase: cython.int
    run: cython.int
    initial: cython.int = 0
    plain: cython.bint
    mantissa: cython.ulonglong
    number: cython.double
    while True:
        if i >= length:
            return blocks, words, i, line, END
        if blocks >= block_room:
            return blocks, words, i, line, FULL
        begin = i
        first = words
        flags = 0
        plain = True
        while True:
            # Between words: blanks, the end of the line, a comment, a slash, a letter.
            while i < length and (text[i] == 32 or text[i] == 9 or text[i] == 13):
                i += 1
            c = cython.cast(cython.int, text[i]) if i < length else 10
            if c == 10:
                break
            if c == 40:  # (
                i += 1
                # "(MSG," and its kin: blanks, letters, blanks, a comma.
                phase = 0
                run = 0
                while i < length:
                    c = cython.cast(cython.int, text[i])
                    if c == 41 or c == 40 or c == 10:
                        break
                    if phase < 3:
                        if (c | 32) >= 97 and (c | 32) <= 122 and phase < 2:
                            if phase == 0:
                                initial = c | 32
                                phase = 1
                            run += 1
                        elif c <= 32 or c >= 128:
                            if phase == 1:
                                phase = 2
                        else:
                            if c == 44 and phase > 0 and _is_active(initial, run):
                                flags |= ACTIVE
                            phase = 3
                    i += 1
                if phase > 0 and phase < 3 and initial == 108 and run == 8:  # (LOGCLOSE)
                    flags |= ACTIVE
                if i >= length or text[i] != 41:
                    plain = False
                    break
                i += 1
                flags |= COMMENT
                continue
            if c == 59:  # ; and what follows it is never passed on
                while i < length and text[i] != 10:
                    i += 1
                flags |= COMMENT
                break
            if c == 47 and flags == 0 and words == first:  # /
                flags |= SLASH
                i += 1
                continue
            letter = _letter_of(c)
            if letter == 0:
                if (c == 78 or c == 110) and words == first and (flags & ~SLASH) == 0:
                    flags |= NUMBERED
                else:
                    plain = False
                    break
            i += 1
            # The number: sign, digits with at most one point, blanks anywhere.
            negative = False
            dotted = False
            mantissa = 0
            digits = 0
            decimals = 0
            while i < length and (text[i] == 32 or text[i] == 9):
                i += 1
            if i < length and (text[i] == 43 or text[i] == 45) and letter != 0:
                negative = text[i] == 45
                i += 1
            while i < length:
                c = cython.cast(cython.int, text[i])
                if 48 <= c <= 57:
                    mantissa = mantissa * 10 + cython.cast(cython.ulonglong, c - 48)
                    digits += 1
                    if dotted:
                        decimals += 1
                    if digits > 18:
                        break
                elif c == 46 and not dotted:
                    dotted = True
                elif c != 32 and c != 9:
                    break
                i += 1
            if digits == 0 or digits > 18 or mantissa > 9007199254740992:
                plain = False
                break
            if letter == 0:
                continue
            if words >= word_room:
                if blocks == 0:
                    plain = False
                    break
                return blocks, first, begin, line, FULL
            number = cython.cast(cython.double, mantissa)
            if decimals > 0:
                number /= powers[decimals]
            letters[words] = letter
            values[words] = -number if negative else number
            words += 1
        if not plain:
            return blocks, first, begin, line, OTHER
        if words > first or flags & COMMENT:
            block_line[blocks] = line
            block_offset[blocks] = begin
            block_flags[blocks] = flags
            word_end[blocks] = words
            blocks += 1
        i += 1
        line += 1


#: Bit of `axis_letters` for a call: M98, G65, G66, or an O-word with a name.
CALLS = 1 << 26


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _is_code(
    text: cython.const[cython.uchar][::1], i: cython.Py_ssize_t, tens: cython.int, units: cython.int
) -> cython.bint:
    """Tell whether the number at i is the code of those two digits."""
    length: cython.Py_ssize_t = text.shape[0]
    while i < length and (text[i] == 48 or text[i] == 32 or text[i] == 9):
        i += 1
    return (
        i + 1 < length
        and text[i] == tens
        and text[i + 1] == units
        and (i + 2 >= length or not (48 <= text[i + 2] <= 57 or text[i + 2] == 46))
    )


def axis_letters(text: cython.const[cython.uchar][::1]) -> int:
    """Return which of A to Z stand before a value outside comments, as bits (A is bit 0), and `CALLS`.

    A value begins with a digit, sign, point, ``#`` or ``[``; letters of function names and keywords (two letters in
    a row) and of ``#<names>`` do not count, nor do the arguments behind G65 and G66.
    """
    length: cython.Py_ssize_t = text.shape[0]
    i: cython.Py_ssize_t = 0
    c: cython.int
    found: cython.uint = 0
    letter: cython.int = -1
    run: cython.int = 0
    closing: cython.int
    while i < length:
        c = cython.cast(cython.int, text[i])
        if c == 40 or c == 59 or c == 60:  # a comment, or a name in <>
            if c == 60 and run == 1 and letter == 14:
                found |= CALLS
            closing = 41 if c == 40 else (10 if c == 59 else 62)
            while i < length and text[i] != closing and text[i] != 10:
                i += 1
            letter = -1
            run = 0
        elif (c | 32) >= 97 and (c | 32) <= 122:
            letter = (c | 32) - 97
            run += 1
        elif c != 32 and c != 9:
            if run == 1 and (48 <= c <= 57 or c == 45 or c == 43 or c == 46 or c == 35 or c == 91):
                found |= cython.cast(cython.uint, 1) << letter
                if letter == 12 and _is_code(text, i, 57, 56):
                    found |= CALLS
                elif letter == 6 and (_is_code(text, i, 54, 53) or _is_code(text, i, 54, 54)):
                    found |= CALLS
                    while i < length and text[i] != 10:
                        i += 1
            if c == 64 or c == 94:  # @ and ^ move X and Y
                found |= (1 << 23) | (1 << 24)
            letter = -1
            run = 0
        i += 1
    return found
