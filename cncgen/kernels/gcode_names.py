# cython: infer_types=True
"""The names in a text: letters, codes and called programs in its words, for the search of the axes that a program moves; and the
N words of its lines, which jumps lead to."""

import cython
from cython.cimports.cncgen.kernels.gcode_codes import (
    ARGUMENTS, CODE_NUMBERS, COMMENT, COMPUTED, FLOW, MESSAGE, NAME, NUMBER, NUMBERED, OUTPUT, O_CALL, WORD,
)  # fmt: skip
from cython.cimports.cncgen.kernels.gcode_lines import Code

#: Bits of words, of axes, and of X and Y.
_WORDS = cython.declare(cython.ulonglong, (1 << 32) - 1)
_AXES = cython.declare(cython.ulonglong, sum(1 << (ord(letter) - 97) for letter in "xyzabcuvw"))
_POLAR = cython.declare(cython.uint, 1 << 23 | 1 << 24)


def named(
    reader: Code,
    text: cython.const[cython.uchar][::1],
    first: cython.int[::1],
    calls: cython.const[cython.uchar][::1],
    slashes: cython.bint,
) -> tuple:
    """Read all lines of a text and return the names in their words; lines that the grammar refuses give none.

    Args:
        reader: A `gcode_parse.Parser` of the text's grammar.
        text: The program.
        first: Of length ``4 * CODE_NUMBERS``, zeros: filled with the line on which each code stands first, and in its second
            half with that on which it stands first in a block that names no axis.
        calls: Of half the length: of a code that calls a program, the letter (small) whose number names it, with `ARGUMENTS`
            where the block has its arguments; else 0.
        slashes: Whether blocks end at a slash within them (`Code.cut`).

    Returns:
        Letters of words as bits from A at bit 0 (``@`` and ``^`` are X and Y), with `COMPUTED`; the line of the first call,
        0 without one; and the numbers and names of the programs that are called.
    """
    at: cython.Py_ssize_t = 0
    line: cython.int = 0
    first_call: cython.int = 0
    call: cython.int
    found: cython.ulonglong = 0
    programs: set = set()
    reader.text = text
    while at < text.shape[0]:
        line += 1
        reader.used = reader.numbers = 0
        begin = at
        at = reader.read(at) + 1
        cut = reader.cut() if slashes else 0
        if cut > 0:
            reader.text = text[begin:cut]
            reader.read(0)
            reader.text = text
        if reader.error >= 0:
            continue
        bits = _words_named(reader, first, calls, line)
        call = bits >> 32
        bits &= _WORDS
        if bits & _AXES == 0:
            _words_named(reader, first[2 * CODE_NUMBERS :], calls, line)
        if call < ARGUMENTS:
            found |= bits
        if call:
            first_call = first_call if first_call else line
            _program_called(reader, call % ARGUMENTS, programs)
    return found, first_call, programs


@cython.cfunc
@cython.exceptval(check=False)
def _words_named(
    reader: Code, first: cython.int[::1], calls: cython.const[cython.uchar][::1], line: cython.int
) -> cython.ulonglong:
    """Return the letters of the line just read, as bits, and from bit 32 on what `calls` says of its code: 1 for an O-word."""
    at: cython.Py_ssize_t = 0
    literal: cython.bint = False
    call: cython.ulonglong = 0
    bits: cython.uint = 0
    place: cython.int
    operation: cython.int
    operand: cython.int
    while reader.code[at] != 0:
        operation, operand = reader.code[at] & 255, reader.code[at] >> 8
        if operation == WORD and (operand == 103 or operand == 109):
            place = _place(reader, at, operand) if literal else -2
            if place == -2:
                bits |= COMPUTED
            elif place >= 0:
                first[place] = first[place] if first[place] else line
                call = calls[place] if calls[place] else call
        elif operation == WORD and (operand == 64 or operand == 94):
            bits |= _POLAR
        elif operation == WORD and 97 <= operand <= 122:
            bits |= cython.cast(cython.uint, 1) << (operand - 97)
        elif operation == FLOW and operand == O_CALL:
            call = 1
        literal = operation == NUMBER
        at = _behind(reader, at)
    return bits | call << 32


@cython.cfunc
@cython.exceptval(check=False)
def _behind(reader: Code, at: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return where the instruction behind one stands; a number that belongs to it may follow it (`gcode_parse`)."""
    operation: cython.int = reader.code[at] & 255
    more: cython.bint = (
        operation == COMMENT or operation == MESSAGE or operation == OUTPUT or operation == FLOW
    )
    return at + 1 + more


@cython.cfunc
@cython.exceptval(check=False)
def _place(reader: Code, at: cython.Py_ssize_t, letter: cython.int) -> cython.int:
    """Return where the code whose word is the instruction `at` stands among `CODE_NUMBERS`; -1 if no code has its number."""
    tenths: cython.double = 10.0 * reader.constants[reader.code[at - 1] >> 8] + 0.5
    if not 0.0 <= tenths < CODE_NUMBERS:
        return -1
    return cython.cast(cython.int, tenths) + (CODE_NUMBERS if letter == 109 else 0)


@cython.cfunc
def _program_called(reader: Code, letter: cython.int, programs: set) -> cython.int:
    """Add the number or name of the program that the line just read calls, unless it is computed."""
    at: cython.Py_ssize_t = 0
    if letter == 1:
        if reader.code[0] & 255 == NAME or reader.code[0] & 255 == NUMBER:
            programs.add(reader.label(0, 0))
        return 0
    while reader.code[at] != 0:
        if reader.code[at] == WORD + 256 * letter and at > 0 and reader.code[at - 1] & 255 == NUMBER:
            programs.add(reader.constants[reader.code[at - 1] >> 8])
        at = _behind(reader, at)
    return 0


def numbered(reader: Code, text: cython.const[cython.uchar][::1]) -> list:
    """Read all lines of a text and return those with an N word: of each its offset, its number, and where its N word begins and ends."""
    at: cython.Py_ssize_t = 0
    line: cython.int = 0
    found: list = []
    reader.text = text
    while at < text.shape[0]:
        line += 1
        reader.used = reader.numbers = 0
        begin = at
        at = reader.read(at) + 1
        if reader.flags & NUMBERED:
            found.append((begin, line, reader.number_begin, reader.number_end))
    return found
