# cython: infer_types=True
"""Scan bytes of G-code into columns: the fast lane of blocks that are nothing but letter-number words and comments.

The scanner never judges: a line that it does not take for certain (an expression, an O-word, ``%``, a nested or open
comment, a number of more digits than a double holds exactly) stops it, and the grammar reads that line instead. It is here because
it takes a quarter of the time of the tables; that a plain block means the same in both, the build (`TERMINALS`) and tests on random
blocks hold.
"""

import cython
from cython.cimports.cncgen.kernels.decimals import Numbers

#: The terminals of the grammars that are read here, as they stand there: where one changes, no tables are made until this does too.
TERMINALS = {
    "WORD": ("[a-mp-z@^$][+-]?([0-9]+\\.?[0-9]*|\\.[0-9]+)",),
    "LINE_NUMBER": ("n[0-9]+(\\.[0-9]*)?",),
    "DELETE": ("/", "\\/[1-9]?"),
    "COMMENT": (
        "\\([^()\n]*\\)|;[^\n]*",
        "\\([^()\n]*(\\([^()\n]*(\\([^()\n]*\\)[^()\n]*)*\\)[^()\n]*)*\\)|\\([^)\n]*\\)|;[^\n]*",
    ),
}

#: Why `scan` came back.
END = 0
FULL = 1
OTHER = 2

#: Flags of a block.
SLASH = 1
COMMENT = 2
ACTIVE = 4
NUMBERED = 8

#: The same as numbers of C.
_FULL = cython.declare(cython.int, FULL)
_OTHER = cython.declare(cython.int, OTHER)
_SLASH = cython.declare(cython.int, SLASH)
_COMMENT = cython.declare(cython.int, COMMENT)
_ACTIVE = cython.declare(cython.int, ACTIVE)
_NUMBERED = cython.declare(cython.int, NUMBERED)

#: Kinds of bytes where a word may begin; O-words and all that is not named here are the grammar's.
_WORD = cython.declare(cython.int, 1)
_BLANK = cython.declare(cython.int, 2)
_LINE_END = cython.declare(cython.int, 3)
_PARENTHESIS = cython.declare(cython.int, 4)
_SEMICOLON = cython.declare(cython.int, 5)
_DELETE = cython.declare(cython.int, 6)
_LINE_NUMBER = cython.declare(cython.int, 7)
_KIND = cython.declare(cython.schar[256])


@cython.cfunc
def _fill_tables() -> cython.void:
    """Fill the table of bytes, once."""
    c: cython.int
    for c in range(256):
        _KIND[c] = 0
    for c in b"abcdefghijklmpqrstuvwxyzABCDEFGHIJKLMPQRSTUVWXYZ":
        _KIND[c] = _WORD
    for c in b" \t\r":
        _KIND[c] = _BLANK
    for c in b"nN":
        _KIND[c] = _LINE_NUMBER
    _KIND[10] = _LINE_END
    _KIND[40] = _PARENTHESIS
    _KIND[59] = _SEMICOLON
    _KIND[47] = _DELETE


_fill_tables()

#: The offset after a comment, -1 where it does not close in its line or holds another; and whether it does something.
_Remark = cython.struct(after=cython.Py_ssize_t, active=cython.bint)

#: A line that was read: the offset of its end, the words in the columns then, its flags; and 0, or why it was left.
_Line = cython.struct(end=cython.Py_ssize_t, words=cython.Py_ssize_t, flags=cython.int, why=cython.int)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _line_end(text: cython.const[cython.uchar][::1], i: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return the offset of the end of the line."""
    while i < text.shape[0] and text[i] != 10:
        i += 1
    return i


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _past_blanks(text: cython.const[cython.uchar][::1], i: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return the offset after blanks."""
    while i < text.shape[0] and (text[i] == 32 or text[i] == 9):
        i += 1
    return i


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _is_letter(c: cython.int) -> cython.bint:
    """Tell whether a byte is a letter."""
    return 97 <= (c | 32) <= 122


@cython.cfunc
@cython.inline
@cython.nogil
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


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _past_unseen(text: cython.const[cython.uchar][::1], i: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return the offset after blanks, control characters and what is not ASCII, in the line."""
    while i < text.shape[0] and (text[i] <= 32 or text[i] >= 128) and text[i] != 10:
        i += 1
    return i


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _remark(text: cython.const[cython.uchar][::1], i: cython.Py_ssize_t) -> _Remark:
    """Read the comment whose parenthesis opens before i; ``(MSG,`` and its kin, and ``(LOGCLOSE)``, are active."""
    length: cython.Py_ssize_t = text.shape[0]
    active: cython.bint = False
    begin: cython.Py_ssize_t = _past_unseen(text, i)
    initial: cython.int
    run: cython.int
    i = begin
    while i < length and _is_letter(text[i]):
        i += 1
    if i > begin:
        initial = text[begin] | 32
        run = i - begin
        i = _past_unseen(text, i)
        if i < length and text[i] == 44:
            active = _is_active(initial, run)
        elif i < length and text[i] == 41:
            active = initial == 108 and run == 8
    while i < length and text[i] != 41 and text[i] != 40 and text[i] != 10:
        i += 1
    return _Remark(after=i + 1 if i < length and text[i] == 41 else -1, active=active)


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _line(
    text: cython.const[cython.uchar][::1],
    numbers: Numbers,
    i: cython.Py_ssize_t,
    first: cython.Py_ssize_t,
    letters: cython.uchar[::1],
    values: cython.double[::1],
) -> _Line:
    """Read the line at i, its words into the columns from `first` on."""
    words: cython.Py_ssize_t = first
    flags: cython.int = 0
    remark: _Remark
    value: cython.double
    while True:
        kind = _KIND[text[i]] if i < text.shape[0] else _LINE_END
        if kind == _WORD:
            if words >= letters.shape[0]:
                return _Line(end=i, words=words, flags=flags, why=_FULL)
            letters[words] = text[i] | 32
            i = _past_blanks(text, i + 1)
            sign = text[i] if i < text.shape[0] else 0
            i = numbers.read(i + (sign == 43 or sign == 45), text.shape[0])
            value = numbers.value
            if value != value:
                break
            values[words] = -value if sign == 45 else value
            words += 1
        elif kind == _LINE_END:
            return _Line(end=i, words=words, flags=flags, why=0)
        elif kind == _BLANK:
            i += 1
        elif kind == _PARENTHESIS:
            remark = _remark(text, i + 1)
            if remark.after < 0:
                break
            flags |= _COMMENT | _ACTIVE if remark.active else _COMMENT
            i = remark.after
        elif kind == _SEMICOLON:  # comments behind it are never passed on
            flags |= _COMMENT
            i = _line_end(text, i)
        elif kind == _DELETE and words == first and flags == 0:
            flags = _SLASH
            i += 1
        elif kind == _LINE_NUMBER and words == first and not flags & ~_SLASH:
            # A line number begins with a digit: N.5 is none.
            i = _past_blanks(text, i + 1)
            if i == text.shape[0] or not 48 <= text[i] <= 57:
                break
            i = numbers.read(i, text.shape[0])
            if numbers.value != numbers.value:
                break
            flags |= _NUMBERED
        else:
            break
    return _Line(end=i, words=words, flags=flags, why=_OTHER)


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
    blocks: cython.Py_ssize_t = 0
    words: cython.Py_ssize_t = 0
    i: cython.Py_ssize_t = offset
    numbers: Numbers = Numbers(text, False, True)
    found: _Line
    while i < text.shape[0]:
        if blocks >= block_line.shape[0]:
            return blocks, words, i, line, FULL
        found = _line(text, numbers, i, words, letters, values)
        if found.why == _FULL and blocks > 0:
            return blocks, words, i, line, FULL
        if found.why != 0:
            return blocks, words, i, line, OTHER
        if found.words > words or found.flags & _COMMENT:
            block_line[blocks] = line
            block_offset[blocks] = i
            block_flags[blocks] = found.flags
            word_end[blocks] = words = found.words
            blocks += 1
        i = found.end + 1
        line += 1
    return blocks, words, i, line, END
