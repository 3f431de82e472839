"""The instructions of one line of G-code (`gcode_parse`, `language_code`): values on a stack, words into the columns, settings that wait.

Nothing is judged. A line that is not taken for certain is left to the interpreter, which knows the whole language and every error: a
value that the machine's state enters, an unknown name, a division by zero, any code but those of plain motions.
"""

import cython
from cython.cimports.cncgen.kernels.gcode_arithmetic import function_of, joined
from cython.cimports.cncgen.kernels.gcode_codes import (
    ANGLE_OF, ARC_TANGENT, AT, BINARY, CALLS_MACRO, CALLS_PROGRAM, CODE, COMMENT, DELETED, END, FIRST_CONSTANT, FLOW, FUNCTION,
    JUMP, LANGUAGE_JUMP, MARKS, MOST_VALUE, NAME, NAMED, NEGATIVE, NUMBER, NUMBERED, NUMBERED_CALL, NUMBER_OF_LINE, O_CALL,
    PARAMETER, PLAIN_LINE, PROGRAM, REFUSED, ROUND, SET, SET_ELEMENT, SET_NAMED, SET_STORED, SET_VARIABLE, STORED, THEN, UNCERTAIN, WHILE_DO,
    WORD,
)  # fmt: skip
from cython.cimports.cncgen.kernels.gcode_rows import Rows
from cython.cimports.cncgen.kernels.language_store import LanguageStore
from cython.cimports.libc.math import isfinite

#: Flags of a block (`gcode_scan`).
_COMMENT = cython.declare(cython.int, 2)
_NUMBERED_BLOCK = cython.declare(cython.int, 8)
#: Larger numbers in words are faults (`block.LARGEST`).
_LARGEST = cython.declare(cython.double, 1e9)
#: Values that wait for an operator.
_STACK = cython.declare(cython.int, 100)
#: Letters of words that are taken, as bits (A is bit 0): not D E H N O T, which tools, parameters and jumps hang on.
_LETTERS = cython.declare(cython.uint, sum(1 << (ord(letter) - 97) for letter in "abcfgijklmpqrsuvwxyz"))
#: Codes beyond are not taken.
_MOST_CODE = cython.declare(cython.int, 100)
_NAN = cython.declare(cython.double, float("nan"))
#: Lines that are not run here.
_LEFT_OUT = cython.declare(cython.int, DELETED | REFUSED)


@cython.cclass
class Instructions:
    """The lines of a text that are kept, what they read and set, and the columns that their words go to.

    Args:
        text, parser, store, columns, waits, meant, frames: As `gcode_run.Computer` takes them.
        macros: Whether jumps and loops are those of macros.

    Attributes:
        blocks: How many blocks stand in the columns.
        first, words: Where the first word of the line goes, and where the next one.
        flags: Of the block of the line.
        given: The letters of its words, as bits.
        stack, depth: Values, and how many of them wait.
        called: The code by which the line calls a program or ends it; 0 for none.
        arguments: How many values an O-word has, on the stack from `depth` on.
        holds: Whether the condition of a macro's jump does.
        counter: The variable in which a jump of a language counts.
    """

    def __init__(self, text, parser, store, columns, waits, meant, frames, macros):
        if not cython.compiled:
            self.taken, self.meant, self.stack = [0] * (2 * _MOST_CODE), [0] * 128, [0.0] * _STACK
        for k in range(128):
            self.meant[k] = k
        for operation, number in (meant or {}).items():
            self.meant[operation] = number
        self.store, self.macros, self.calls = store, macros, False
        self.language = store if isinstance(store, LanguageStore) else None
        self.store.names = parser.names
        self.numbers = self.store.numbers
        self.waits = waits
        self.reader, self.code, self.constants = parser, parser.code, parser.constants
        self.rows = Rows(text, parser, self.store.ways)
        self.kept = self.rows.kept
        self.block_line, self.block_offset, self.block_flags = columns[:3]
        self.word_end, self.letters, self.values = columns[3:]
        self.frames = [] if frames is None else frames
        self.blocks = self.words = self.first = 0

    @cython.cfunc
    @cython.exceptval(-2, check=True)
    def execute(self, r: cython.Py_ssize_t) -> cython.int:
        """Run the instructions of a row: words go behind those in the columns, settings and the values of a jump wait.

        Returns the kind of the line: the keyword of its O-word or jump, `LANGUAGE_JUMP` and its jump, `NUMBERED_CALL` for a program called by
        its number or its end, else `PLAIN_LINE` or `UNCERTAIN`.
        """
        at: cython.Py_ssize_t = self.kept[r, CODE]
        first: cython.Py_ssize_t = self.kept[r, FIRST_CONSTANT]
        operation: cython.int
        operand: cython.int
        value: cython.double
        certain: cython.bint = not self.kept[r, MARKS] & _LEFT_OUT
        self.given = self.depth = self.called = self.store.settings = 0
        self.passed = self.rounded = False
        self.flags = _NUMBERED_BLOCK if self.kept[r, MARKS] & NUMBERED else 0
        while certain:
            operation, operand = self.code[at] & 255, self.code[at] >> 8
            at += 1
            if operation <= MOST_VALUE and operation != END:
                value = (
                    self.constants[first + operand]
                    if operation == NUMBER
                    else _value(self, operation, operand)
                )
                # A vacant variable has no value.
                certain = value == value and self.depth < _STACK
                if certain:
                    self.stack[self.depth] = value
                    self.depth += 1
            elif operation == WORD:
                certain = _word(self, operand, _pop(self))
            elif operation == END:
                return _end_of_line(self)
            elif operation == COMMENT:
                self.flags |= _COMMENT
                at += 1
            elif operation == FLOW and operand == PROGRAM and self.frames:
                # The number of the program that was called; words may stand behind it.
                self.passed, self.depth = True, 0
                at += 1
            elif operation == FLOW or operation == JUMP:
                return (
                    _flow_of(self, operand, at)
                    if operation == FLOW
                    else _jump_of(self, operand, self.code[at])
                )
            elif operation == THEN and self.macros:
                if _pop(self) == 0.0:
                    return PLAIN_LINE
            else:
                certain = _setting(self, operation, operand)
        return UNCERTAIN

    @cython.cfunc
    def end_block(self, r: cython.Py_ssize_t) -> cython.int:
        """Do the settings of a line, and make a block of its words."""
        if self.store.settings:
            self.store.end()
        if self.words > self.first or self.flags & _COMMENT:
            self.block_line[self.blocks] = self.kept[r, NUMBER_OF_LINE]
            self.block_offset[self.blocks] = self.kept[r, AT]
            self.block_flags[self.blocks] = self.flags
            self.word_end[self.blocks] = self.words
            self.blocks += 1
        return 0


@cython.cfunc
@cython.inline
@cython.exceptval(-1.0, check=True)
def _value(line: Instructions, operation: cython.int, operand: cython.int) -> cython.double:
    """Return a value, or what an operator or a function makes of the last ones; NaN where there is none."""
    last: cython.double
    if operation == BINARY:
        last = _pop(line)
        return joined(line.meant[operand], _pop(line), last)
    elif operation == STORED:
        return line.numbers[operand]
    elif operation == FUNCTION:
        # In a word, ROUND of a macro rounds to its least increment (the interpreter's).
        line.rounded = line.rounded or (line.macros and line.meant[operand] == ROUND)
        last = function_of(line.meant[operand], _pop(line))
        return last if isfinite(last) else _NAN
    elif operation == NEGATIVE:
        return -_pop(line)
    elif operation == ARC_TANGENT:
        last = _pop(line)
        return joined(line.meant[ANGLE_OF], _pop(line), last)
    elif operation == NAME:
        return operand
    elif operation == NAMED:
        return line.store.found if line.store.has(operand) else _NAN
    elif operation == PARAMETER:
        operand = line.store.index(_pop(line))
        return line.numbers[operand] if operand >= 0 else _NAN
    else:
        return line.store.found if line.language.has_element(operand, _pop(line)) else _NAN


@cython.cfunc
@cython.inline
def _setting(line: Instructions, operation: cython.int, operand: cython.int) -> cython.bint:
    """Let what is to be set wait for the end of the line, its value the last one; tell whether the instruction is a setting that can be."""
    value: cython.double
    if operation == SET_STORED:
        return line.store.set(operand, _pop(line))
    if operation == SET_VARIABLE:
        return line.store.set_variable(operand, _pop(line))
    if operation != SET and operation != SET_NAMED and operation != SET_ELEMENT:
        return False
    value = _pop(line)
    if operation == SET_ELEMENT:
        return line.language.set_element(operand, _pop(line), value)
    if operation == SET_NAMED:
        return line.store.set_variable(cython.cast(cython.int, _pop(line)), value)
    operand = line.store.index(_pop(line))
    return operand >= 0 and line.store.set(operand, value)


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _pop(line: Instructions) -> cython.double:
    """Return the last value, which is taken."""
    line.depth -= 1
    return line.stack[line.depth]


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _jump_of(line: Instructions, jump: cython.int, counter: cython.int) -> cython.int:
    """Return the kind of a line with a jump of a language; its values are the first ones on the stack."""
    line.counter, line.depth = counter, 0
    return LANGUAGE_JUMP + jump if line.language.leads is not None else UNCERTAIN


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _flow_of(line: Instructions, keyword: cython.int, at: cython.Py_ssize_t) -> cython.int:
    """Return the keyword of an O-word or of a macro's jump; its values are those on the stack from `depth` on, their count at `at`."""
    if not line.macros:
        line.arguments = line.code[at]
        line.depth -= line.arguments
        return keyword if keyword <= O_CALL else UNCERTAIN
    # Settings before a jump act before its values are read.
    if (
        keyword <= PROGRAM
        or line.store.settings
        or line.words > line.first
        or (keyword == WHILE_DO and not _is_last(line, at + 1))
    ):
        return UNCERTAIN
    line.holds = line.depth == 1 or line.stack[0] != 0.0
    line.depth -= 1
    return keyword


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _is_last(line: Instructions, at: cython.Py_ssize_t) -> cython.bint:
    """Tell whether comments alone stand behind the head of a loop: other words are run line by line."""
    while line.code[at] & 255 == COMMENT:
        at += 2
    return line.code[at] == END


@cython.cfunc
@cython.inline
def _word(line: Instructions, letter: cython.int, value: cython.double) -> cython.bint:
    """Put a word into the columns; tell whether it is taken: a letter that no machine's table hangs on, once, its value in range."""
    bit: cython.uint
    code: cython.int
    if not 97 <= letter <= 122 or line.words >= line.letters.shape[0]:
        return False
    bit = cython.cast(cython.uint, 1) << (letter - 97)
    if (
        not (bit & _LETTERS or line.called == CALLS_MACRO)
        or bit & line.given
        or not -_LARGEST <= value <= _LARGEST
        or line.rounded
    ):
        return False
    if letter == 103 or letter == 109:
        code = cython.cast(cython.int, value)
        if not 0.0 <= value < _MOST_CODE or value != code or not _takes(line, letter, code):
            return False
    else:
        line.given |= bit
    line.letters[line.words] = letter
    line.values[line.words] = value
    line.words += 1
    return True


@cython.cfunc
@cython.inline
def _takes(line: Instructions, letter: cython.int, number: cython.int) -> cython.bint:
    """Tell whether a code calls a program or ends it, or its block may wait; of each code that is asked once."""
    place: cython.int = number if letter == 103 else _MOST_CODE + number
    if line.calls and (number == CALLS_MACRO and line.macros if letter == 103 else number >= CALLS_PROGRAM):
        line.called = number
        return True
    if line.taken[place] == 0:
        line.taken[place] = 2 if line.waits("G" if letter == 103 else "M", number) else 1
    return line.taken[place] == 2


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _end_of_line(line: Instructions) -> cython.int:
    """Return the kind of a line without a jump."""
    if line.passed and line.words == line.first and not line.store.settings:
        # A comment beside that number alone is not told.
        line.flags = 0
    return NUMBERED_CALL if line.called else PLAIN_LINE
