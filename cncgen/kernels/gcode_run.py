"""Run lines of G-code as `gcode_parse` has compiled them: expressions, parameters and settings, O-words, blocks into columns.

A line is parsed once, by the tables of the grammar, and kept as instructions; loops and calls run those. Like `gcode_scan` this
judges nothing. A line that it does not take for certain is left to the interpreter, which knows the whole language and every
error: a value that the machine's state enters, an unknown name, a division by zero, any code but those of plain motions.

    offset of a line ──► row of `gcode_lines.Lines` ──► instructions ─┬► words: a block in the columns
       ▲                                                           ├► settings, done at the end of the line
       └──── row of the line that an O-word leads to ◄─────────────┴► an O-word, by `gcode_marks`
"""

import cython
from cython.cimports.cncgen.kernels.gcode_arithmetic import function_of, joined
from cython.cimports.cncgen.kernels.gcode_codes import (
    AFTER, ANGLE_OF, ARC_TANGENT, AT, AT_NEXT, AT_PREVIOUS, BEHIND, BINARY, CODE, COMMENT, COMPUTED_LABEL, DELETED, ELEMENT, END,
    FIRST_CONSTANT, FLOW, FUNCTION, GOTO, JUMP, KEYWORD, LINE, MARK, MARKS, MARK_ABOVE, MARK_BELOW, NAME, NAMED, NEGATIVE, NUMBER, NUMBERED,
    NUMBER_OF_LINE, OFFSET, O_CALL, O_ELSEIF, O_ENDSUB, O_IF, O_REPEAT, O_RETURN, O_SUB, O_WHILE, PARAMETER, PAST_NEXT, PROGRAM, REFUSED, ROUND,
    SET, SET_ELEMENT, SET_NAMED, SET_STORED, SET_VARIABLE, STAY, STORED, THEN, WHILE_DO, WORD,
)  # fmt: skip
from cython.cimports.cncgen.kernels.gcode_frames import Frame
from cython.cimports.cncgen.kernels.gcode_lines import Code
from cython.cimports.cncgen.kernels.gcode_marks import Marks
from cython.cimports.cncgen.kernels.gcode_rows import Rows
from cython.cimports.cncgen.kernels.gcode_store import Store
from cython.cimports.cncgen.kernels.language_store import LanguageStore
from cython.cimports.libc.math import fabs, floor, isfinite

from cncgen.kernels.gcode_codes import LOOKS, MACRO_PARAMETERS
from cncgen.kernels.gcode_marks import bits_of

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

#: Local numbered parameters of a subroutine and of a macro, from #1 on; units of work of a call with its parameters, and without
#: (`budget.CALL`).
_LOCALS = cython.declare(cython.int, 30)
_MACRO_LOCALS = cython.declare(cython.int, 33)
_CALL_UNITS = cython.declare(cython.int, 12)
_PLAIN_CALL_UNITS = cython.declare(cython.int, 4)
#: G65 by its number, M98 and M99; the largest number of a program, and most rounds of a call.
_MACRO = cython.declare(cython.int, 65)
_PROGRAM = cython.declare(cython.int, 98)
_BACK = cython.declare(cython.int, 99)
_MOST_NUMBER = cython.declare(cython.double, 9999.0)
#: By letter, from A on, the parameter that it sets beside G65.
_ARGUMENT = cython.declare(cython.uchar[26])
_k: cython.int
for _k in range(26):
    _ARGUMENT[_k] = MACRO_PARAMETERS.get(chr(97 + _k), 0)
#: The marks that an IF which does not hold looks for.
_BRANCHES = cython.declare(cython.uint, bits_of(LOOKS["if"][1]))
#: Lines that are not run here.
_LEFT_OUT = cython.declare(cython.int, DELETED | REFUSED)
_NAN = cython.declare(cython.double, float("nan"))
#: Kinds of lines: uncertain, a block or settings, a program called by its number or its end; else the number of its keyword.
_UNCERTAIN = cython.declare(cython.int, -1)
_PLAIN = cython.declare(cython.int, 0)
_CALLS = cython.declare(cython.int, 999)
#: Kinds of lines with a jump of a language: this, and the jump.
_JUMPS = cython.declare(cython.int, 1000)


@cython.cclass
class Computer:
    """A place in a text, and the columns that its lines go to. O-words are followed once `follow` was told how, jumps and loops of macros
    where `leads` tells their lines.

    Args:
        text: The text.
        parser: A `gcode_parse.Parser` that nobody else uses, of LinuxCNC's grammar or FANUC's; or the code of a language.
        store: Parameters, read and set: a `LanguageStore` for lines of SINUMERIK and Heidenhain, which jump by it.
        columns: The columns of `gcode_scan.scan`: line, offset, flags, ends of the words, letters, values.
        waits: Tells whether a block with a code, a letter and a whole number, may wait.
        pause: Lines after which a jump back ends a run.
        meant: The operators and functions of the dialect by those of the grammar, where they differ.
        frames: The calls in progress, the innermost last.
        leads: Of macros, returns offset and number of the line that GOTO, DO or END leads to, by offset and number of its line, keyword and
            value; None where there is none.
        begins: Returns the place where a program begins, by offset and number of the line that calls it, and its number; None where that
            is not certain.

    Attributes:
        calls: Whether M98, M99 and G65 of macros are followed.
        blocks: How many blocks stand in the columns; whoever takes them sets it to 0.
        line: Number of the first line not read.
        lines, units: How many lines the last run read, and units of work that its calls were beside them.
        back: The O-word, by offset and line, whose jump back ended the last run, or None; `away`, where it led to in another text.
        reached, reached_line: The first line that was never reached outside of calls.
        since: Lines read since that line, or since whoever looks set it to 0.
        ran, ran_line: The line that was read last.
    """

    code: cython.const[cython.int][::1]
    constants: cython.const[cython.double][::1]
    block_line: cython.longlong[::1]
    block_offset: cython.longlong[::1]
    block_flags: cython.uchar[::1]
    word_end: cython.longlong[::1]
    letters: cython.uchar[::1]
    values: cython.double[::1]
    numbers: cython.double[::1]
    kept: cython.longlong[:, ::1]
    reader = cython.declare(Code)
    marks = cython.declare(Marks)
    store = cython.declare(Store)
    language = cython.declare(LanguageStore, visibility="public")
    rows = cython.declare(Rows)
    stack = cython.declare(cython.double[100])
    depth = cython.declare(cython.int)
    waits = cython.declare(object)
    pause = cython.declare(cython.Py_ssize_t)
    counter = cython.declare(cython.int)
    meant = cython.declare(cython.int[128])
    leads = cython.declare(object)
    begins = cython.declare(object)
    calls = cython.declare(cython.bint, visibility="public")
    called = cython.declare(cython.int)
    taken = cython.declare(cython.uchar[200])
    blocks = cython.declare(cython.Py_ssize_t, visibility="public")
    line = cython.declare(cython.longlong, visibility="public")
    lines = cython.declare(cython.Py_ssize_t, visibility="public")
    units = cython.declare(cython.Py_ssize_t, visibility="public")
    back = cython.declare(object, visibility="public")
    away = cython.declare(object, visibility="public")
    reached = cython.declare(cython.Py_ssize_t, visibility="public")
    reached_line = cython.declare(cython.longlong, visibility="public")
    since = cython.declare(cython.Py_ssize_t, visibility="public")
    ran = cython.declare(cython.Py_ssize_t, visibility="public")
    ran_line = cython.declare(cython.longlong, visibility="public")
    frames = cython.declare(list)
    outermost = cython.declare(object)
    deepest = cython.declare(cython.Py_ssize_t)
    source = cython.declare(cython.longlong)
    find = cython.declare(object)
    words = cython.declare(cython.Py_ssize_t)
    given = cython.declare(cython.uint)
    flags = cython.declare(cython.int)
    holds = cython.declare(cython.bint)
    arguments = cython.declare(cython.int)
    next = cython.declare(cython.Py_ssize_t)
    next_line = cython.declare(cython.longlong)

    def __init__(
        self, text, parser, store, columns, waits, pause, meant=None, frames=None, leads=None, begins=None
    ):
        if not cython.compiled:
            self.taken, self.meant, self.stack = [0] * (2 * _MOST_CODE), [0] * 128, [0.0] * _STACK
        for k in range(128):
            self.meant[k] = k
        for operation, number in (meant or {}).items():
            self.meant[operation] = number
        self.store, self.leads, self.begins, self.calls = store, leads, begins, False
        self.language = store if isinstance(store, LanguageStore) else None
        self.store.names = parser.names
        self.numbers = self.store.numbers
        self.waits, self.pause = waits, pause
        self.reader, self.code, self.constants = parser, parser.code, parser.constants
        self.rows = Rows(text, parser, self.store.ways)
        self.kept = self.rows.kept
        self.block_line, self.block_offset, self.block_flags = columns[:3]
        self.word_end, self.letters, self.values = columns[3:]
        self.frames = [] if frames is None else frames
        self.find = self.marks = None
        self.blocks = self.ran = self.ran_line = 0
        self.reached = self.reached_line = self.since = 0
        self.line = 1

    @property
    def local(self):
        """The named parameters of the call in progress."""
        return self.store.local

    def follow(self, find, outermost, deepest, source):
        """Follow O-words from now on.

        Args:
            find: Returns the marks of the text (`gcode_marks.Marks`), which the first O-word asks for.
            outermost: The record of the main program below the calls in progress.
            deepest: How many calls may be in progress.
            source: Number of the text.
        """
        self.find, self.outermost = find, outermost
        self.deepest, self.source = deepest, source

    def run(
        self,
        offset: cython.Py_ssize_t,
        line: cython.longlong,
        local: dict,
        most: cython.Py_ssize_t = 1 << 62,
    ) -> cython.Py_ssize_t:
        """Run lines from `offset` on until one is not certain, a column is full, the text ends, or so many were run.

        Settings are done, blocks go to the columns, behind those that stand there. `local` are the named parameters of the
        subroutine in force. When `since` is `pause`, the next jump back ends the run. Returns the offset of the first line not read.
        """
        keyword: cython.int
        outside: cython.bint
        r: cython.Py_ssize_t
        after: cython.Py_ssize_t
        self.store.local = local
        self.lines = self.units = 0
        self.back = self.away = None
        self.rows.again = self.marks is not None or (
            self.language is not None and self.language.leads is not None
        )
        r = self.rows.at(offset, line)
        while r >= 0 and self.blocks < self.block_line.shape[0] and self.lines < most:
            offset, line, after = self.kept[r, AT], self.kept[r, NUMBER_OF_LINE], self.kept[r, AFTER]
            outside = self._is_outside()
            self.rows.last = r
            self.words = self._first_word()
            self.next_line = line + 1
            keyword = self._execute(r)
            if keyword == _PLAIN:
                self._end_block(r)
                self.next = self.rows.following(r)
            elif not self._follow(r, keyword):
                self.store.undo()
                break
            self.lines += 1
            if keyword != _PLAIN:
                if outside:
                    self._reach(after, line + 1)
                if self.away is not None:
                    break
            self.ran, self.ran_line = offset, line
            if self.next < 0:
                # The end of the text.
                offset, line = -1 - self.next, self.next_line
            else:
                if keyword != _PLAIN and self.kept[self.next, AT] <= offset and self._is_time():
                    self.back = (offset, line)
                offset, line = self.kept[self.next, AT], self.kept[self.next, NUMBER_OF_LINE]
            r = self.next
            if self._is_outside():
                self._reach(offset, line)
            if self.back is not None:
                break
        if self.store.returned:
            self.store.settle()
        self.since += self.lines
        self.line = line
        return offset

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _is_outside(self) -> cython.bint:
        """Tell whether no call is in progress."""
        return len(self.frames) == 0 and self.store.calls == 0

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _is_time(self) -> cython.bint:
        """Tell whether a jump back is to be looked at."""
        return self.since + self.lines >= self.pause * (1 + (self.store.calls > 0))

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _reach(self, offset: cython.Py_ssize_t, line: cython.longlong) -> cython.void:
        """Note a line that was never reached before."""
        if offset > self.reached:
            self.reached, self.reached_line = offset, line
            self.since = -self.lines

    # Instructions.

    @cython.cfunc
    def _execute(self, r: cython.Py_ssize_t) -> cython.int:
        """Run the instructions of a row: words go behind those in the columns, settings and the values of an O-word wait.

        Returns the keyword of an O-word, `_PLAIN` or `_UNCERTAIN`.
        """
        at: cython.Py_ssize_t = self.kept[r, CODE]
        constants: cython.Py_ssize_t = self.kept[r, FIRST_CONSTANT]
        operation: cython.int
        operand: cython.int
        certain: cython.bint = not self.kept[r, MARKS] & _LEFT_OUT
        passed: cython.bint = False
        self.given = self.depth = self.called = self.store.settings = 0
        self.flags = _NUMBERED_BLOCK if self.kept[r, MARKS] & NUMBERED else 0
        while certain:
            operation, operand = self.code[at] & 255, self.code[at] >> 8
            at += 1
            if operation == NUMBER:
                certain = self._push(self.constants[constants + operand])
            elif operation == WORD:
                certain = self._word(operand, self._pop())
            elif operation == BINARY:
                certain = self._join(operand)
            elif operation == STORED:
                certain = self._push(self.numbers[operand])
            elif operation == END:
                if passed and not (self._has_words() or self.store.settings):
                    # A comment beside that number alone is not told.
                    self.flags = 0
                return _CALLS if self.called else _PLAIN
            elif operation == SET:
                certain = self._set()
            elif operation == SET_STORED:
                certain = self.store.set(operand, self._pop())
            elif operation == FUNCTION:
                certain = not self._rounds_word(operand, at) and self._apply(operand)
            elif operation == NAME:
                certain = self._push(operand)
            elif operation == NAMED:
                certain = self.store.has(operand) and self._push(self.store.found)
            elif operation == SET_NAMED:
                certain = self._set_named()
            elif operation == SET_VARIABLE:
                certain = self.store.set_variable(operand, self._pop())
            elif operation == PARAMETER:
                certain = self._parameter()
            elif operation == ELEMENT:
                certain = self.language.has_element(operand, self._pop()) and self._push(self.store.found)
            elif operation == SET_ELEMENT:
                certain = self._set_element(operand)
            elif operation == NEGATIVE:
                certain = self._push(-self._pop())
            elif operation == ARC_TANGENT:
                certain = self._join(ANGLE_OF)
            elif operation == COMMENT:
                self.flags |= _COMMENT
                at += 1
            elif operation == THEN:
                certain = self.leads is not None
                if certain and self._pop() == 0.0:
                    return _PLAIN
            elif operation == JUMP:
                return self._jump_of(operand, self.code[at])
            elif operation == FLOW and operand == PROGRAM and self.frames:
                # The number of the program that was called; words may stand behind it.
                passed, self.depth = True, 0
                at += 1
            elif operation == FLOW:
                certain = operand != WHILE_DO or self._is_last(at + 1)
                if certain:
                    return self._keyword_of(operand, self.code[at])
            else:
                return _UNCERTAIN
        return _UNCERTAIN

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _push(self, value: cython.double) -> cython.bint:
        """Push a value; tell whether it is one (what is vacant is none) and there is room."""
        if value != value or self.depth == _STACK:
            return False
        self.stack[self.depth] = value
        self.depth += 1
        return True

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _pop(self) -> cython.double:
        """Return the last value, which is taken."""
        self.depth -= 1
        return self.stack[self.depth]

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _join(self, operator: cython.int) -> cython.bint:
        """Put the value of an operator in place of two values."""
        last: cython.double = self._pop()
        return self._push(joined(self.meant[operator], self._pop(), last))

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _apply(self, function: cython.int) -> cython.bint:
        """Put the value of a function in place of a value."""
        value: cython.double = function_of(self.meant[function], self._pop())
        return isfinite(value) and self._push(value)

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _rounds_word(self, function: cython.int, at: cython.Py_ssize_t) -> cython.bint:
        """Tell whether a function is ROUND of a macro in a word, which rounds to its least increment (the interpreter's).

        The first instruction from `at` on that takes values is the word's.
        """
        operation: cython.int
        if self.leads is None or self.meant[function] != ROUND:
            return False
        while True:
            operation = self.code[at] & 255
            if (
                operation == END
                or operation == WORD
                or operation == SET
                or operation == FLOW
                or operation == THEN
            ):
                return operation == WORD
            at += 1

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _parameter(self) -> cython.bint:
        """Put a parameter in place of its number."""
        k: cython.int = self.store.index(self._pop())
        return k >= 0 and self._push(self.numbers[k])

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _set(self) -> cython.bint:
        """Set the parameter whose number stands before a value."""
        value: cython.double = self._pop()
        k: cython.int = self.store.index(self._pop())
        return k >= 0 and self.store.set(k, value)

    @cython.cfunc
    @cython.inline
    def _set_named(self) -> cython.bint:
        """Set the parameter whose name stands before a value."""
        value: cython.double = self._pop()
        return self.store.set_variable(cython.cast(cython.int, self._pop()), value)

    @cython.cfunc
    @cython.inline
    def _set_element(self, k: cython.int) -> cython.bint:
        """Set the element of an array whose index stands before a value."""
        value: cython.double = self._pop()
        return self.language.set_element(k, self._pop(), value)

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _jump_of(self, jump: cython.int, counter: cython.int) -> cython.int:
        """Return the kind of a line with a jump of a language; its values are the first ones on the stack."""
        self.counter, self.depth = counter, 0
        return _JUMPS + jump if self.language.leads is not None else _UNCERTAIN

    @cython.cfunc
    @cython.exceptval(check=False)
    def _is_last(self, at: cython.Py_ssize_t) -> cython.bint:
        """Tell whether comments alone stand behind the head of a loop: other words are run line by line."""
        while self.code[at] & 255 == COMMENT:
            at += 2
        return self.code[at] == END

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _keyword_of(self, keyword: cython.int, arguments: cython.int) -> cython.int:
        """Return the keyword of an O-word or of a macro's jump; its values are those on the stack from `depth` on."""
        if self.leads is None:
            self.arguments = arguments
            self.depth -= arguments
            return keyword if keyword <= O_CALL else _UNCERTAIN
        # Settings before a jump act before its values are read.
        if keyword <= PROGRAM or self.store.settings or self._has_words():
            return _UNCERTAIN
        self.holds = self.depth == 1 or self.stack[0] != 0.0
        self.depth -= 1
        return keyword

    # Words.

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _calls(self, letter: cython.int, number: cython.int) -> cython.bint:
        """Take a code that calls a program or ends it; tell whether it is one, or may wait."""
        if not self.calls or not (
            (number == _MACRO and self.leads is not None) if letter == 103 else number >= _PROGRAM
        ):
            return self._waits(letter, number)
        self.called = number
        return True

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _waits(self, letter: cython.int, number: cython.int) -> cython.bint:
        """Tell whether a block with a code may wait; of each code it is asked once."""
        place: cython.int = number if letter == 103 else _MOST_CODE + number
        if self.taken[place] == 0:
            self.taken[place] = 2 if self.waits("G" if letter == 103 else "M", number) else 1
        return self.taken[place] == 2

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _word(self, letter: cython.int, value: cython.double) -> cython.bint:
        """Put a word into the columns; tell whether it is taken: a letter that no machine's table hangs on, once, its value in range."""
        bit: cython.uint
        if not 97 <= letter <= 122 or self.words >= self.letters.shape[0]:
            return False
        bit = cython.cast(cython.uint, 1) << (letter - 97)
        if (
            not (bit & _LETTERS or self.called == _MACRO)
            or bit & self.given
            or not -_LARGEST <= value <= _LARGEST
        ):
            return False
        if letter == 103 or letter == 109:
            if not 0.0 <= value < _MOST_CODE or value != floor(value):
                return False
            if not self._calls(letter, cython.cast(cython.int, value)):
                return False
        else:
            self.given |= bit
        self.letters[self.words] = letter
        self.values[self.words] = value
        self.words += 1
        return True

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _has_words(self) -> cython.bint:
        """Tell whether the line has given words."""
        return self.words > self._first_word()

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _first_word(self) -> cython.Py_ssize_t:
        """Return the place in the columns of the line's first word."""
        return self.word_end[self.blocks - 1] if self.blocks > 0 else 0

    @cython.cfunc
    def _end_block(self, r: cython.Py_ssize_t) -> cython.void:
        """Do the settings of a line, and make a block of its words."""
        if self.store.settings:
            self.store.end()
        if self._has_words() or self.flags & _COMMENT:
            self.block_line[self.blocks] = self.kept[r, NUMBER_OF_LINE]
            self.block_offset[self.blocks] = self.kept[r, AT]
            self.block_flags[self.blocks] = self.flags
            self.word_end[self.blocks] = self.words
            self.blocks += 1

    # Jumps.

    @cython.cfunc
    def _follow(self, r: cython.Py_ssize_t, keyword: cython.int) -> cython.bint:
        """Follow the O-word or jump of a row to the `next` line; tell whether it is certain where that is."""
        if keyword < 0:
            return False
        if keyword == _CALLS:
            return self._call_program(r) if self.called != _BACK else self._end_program(r)
        if keyword >= _JUMPS:
            return self._jump(r, keyword - _JUMPS)
        return self._flow(r, keyword) if keyword <= O_CALL else self._lead(r, keyword)

    @cython.cfunc
    def _jump(self, r: cython.Py_ssize_t, jump: cython.int) -> cython.bint:
        """Follow the jump of a language."""
        line: cython.longlong = self.kept[r, NUMBER_OF_LINE]
        goes: cython.int = self.language.goes(r, line, jump, self.counter, self.stack[0], self.stack[1])
        if goes > 0:
            self._go(self.language.way[2], self.language.way[3])
        elif goes == 0:
            self.next = self.rows.following(r)
        return goes >= 0

    @cython.cfunc
    def _go(self, offset: cython.Py_ssize_t, line: cython.longlong) -> cython.void:
        """Make a line the next one."""
        self.next, self.next_line = self.rows.at(offset, line), line

    @cython.cfunc
    def _lead(self, r: cython.Py_ssize_t, keyword: cython.int) -> cython.bint:
        """Follow GOTO, DO or END of a macro."""
        value: cython.double = self.stack[self.depth]
        if keyword == GOTO and not self.holds:
            self.next = self.rows.following(r)
            return True
        key = (r, value)
        way = self.store.ways.get(key)
        if way is None:
            way = self.leads(self.kept[r, AT], self.kept[r, NUMBER_OF_LINE], keyword, value)
            if way is None:
                return False
            self.store.ways[key] = way
        if keyword == WHILE_DO and self.holds:
            self.next = self.rows.following(r)
        else:
            self._go(way[0], way[1])
        return True

    # O-words.

    @cython.cfunc
    def _flow(self, r: cython.Py_ssize_t, keyword: cython.int) -> cython.bint:
        """Follow the O-word of a row to the `next` line; tell whether it is certain where that is.

        `flow.o_words` defines the O-words; here they are followed by the marks that they lead to.
        """
        if self.marks is None and self.find is not None:
            self.marks, self.rows.again = self.find(), True
        if self.marks is None or not self.marks.certain or self.kept[r, MARKS] & COMPUTED_LABEL:
            return False
        label = self.reader.label(self.kept[r, CODE], self.kept[r, FIRST_CONSTANT])
        if keyword == O_CALL:
            return self._call(r, label)
        if self.arguments != (
            keyword == O_IF or keyword == O_ELSEIF or keyword == O_WHILE or keyword == O_REPEAT
        ) and not (self.arguments == 1 and (keyword == O_ENDSUB or keyword == O_RETURN)):
            return False
        if keyword == O_ENDSUB or keyword == O_RETURN:
            return self._leave(label, keyword == O_RETURN)
        return self._branch(r, keyword, label)

    @cython.cfunc
    def _branch(self, r: cython.Py_ssize_t, keyword: cython.int, label) -> cython.bint:
        """Follow the O-word of a branch or loop, or SUB."""
        way: cython.int
        value: cython.double = self.stack[self.depth] if self.arguments else 0.0
        m: cython.Py_ssize_t = self.kept[r, MARK]
        if m < 0:
            m = self.kept[r, MARK] = self.marks.behind(self.kept[r, AT])
        if not self.marks.leads(m):
            return False
        frame: Frame = self.frames[len(self.frames) - 1] if self.frames else self.outermost
        if keyword == O_WHILE:
            # The foot of a loop that DO began, or the head of one.
            loops: cython.bint = frame.doing is not None and label in frame.doing
            if loops != (self.marks.rows[m, MARK_ABOVE] >= 0):
                return False
        elif keyword == O_REPEAT and not frame.repeats(label):
            if value != floor(value) or not fabs(value) <= _LARGEST:
                return False
        way = PAST_NEXT if keyword == O_SUB else frame.lead(keyword, label, value)
        if way == STAY:
            self.next = self.rows.following(r)
            return True
        m = self.marks.rows[m, MARK_BELOW if way == AT_NEXT or way == PAST_NEXT else MARK_ABOVE]
        if keyword == O_IF:
            m = self._branch_that_holds(m, label)
        if m >= 0:
            self._go_to(m, way == AT_NEXT or way == AT_PREVIOUS)
        return m >= 0

    @cython.cfunc
    def _branch_that_holds(self, m: cython.Py_ssize_t, label) -> cython.Py_ssize_t:
        """Return the first branch from one on that is no ELSEIF or whose condition holds; -1 where that is not certain."""
        while m >= 0 and self.marks.rows[m, KEYWORD] == O_ELSEIF:
            offset: cython.longlong = self.marks.rows[m, OFFSET]
            if (
                self._execute(self.rows.at(offset, self.marks.rows[m, LINE])) != O_ELSEIF
                or self.arguments != 1
            ):
                return -1
            if self.stack[self.depth] != 0.0:
                break
            m = self.marks.nearest(offset, 1, label, _BRANCHES, False, None)
        return m

    @cython.cfunc
    def _go_to(self, m: cython.Py_ssize_t, at: cython.bint) -> cython.void:
        """Go `at` the line of a mark, or behind it."""
        self._go(self.marks.rows[m, OFFSET if at else BEHIND], self.marks.rows[m, LINE] + (not at))

    @cython.cfunc
    def _call(self, r: cython.Py_ssize_t, label) -> cython.bint:
        """Begin a call of a subroutine of this text."""
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.marks.subroutine(label)
        if m < 0 or self.arguments > _LOCALS or len(self.frames) >= self.deepest:
            return False
        self._begin(r, label, _LOCALS)
        for k in range(self.arguments):
            self.numbers[k + 1] = self.stack[self.depth + k]
        for k in range(self.arguments, _LOCALS):
            self.numbers[k + 1] = 0.0
        self._go_to(m, False)
        return True

    @cython.cfunc
    def _begin(self, r: cython.Py_ssize_t, label, count: cython.int) -> Frame:
        """Begin a call from a row, with so many numbered parameters of its own."""
        frame: Frame = Frame(label, self.store.local)
        frame.source, frame.offset, frame.line = (
            self.source,
            self.kept[r, AFTER],
            self.kept[r, NUMBER_OF_LINE] + 1,
        )
        frame.row = r
        frame.keep(self.numbers, count)
        self.frames.append(frame)
        self.store.local = {}
        self.units += _CALL_UNITS if count else _PLAIN_CALL_UNITS
        return frame

    @cython.cfunc
    def _leave(self, label, anywhere: cython.bint) -> cython.bint:
        """End the innermost call, where nothing but its caller's parameters is to be put back."""
        if not self.frames:
            return False
        frame: Frame = self.frames[len(self.frames) - 1]
        if frame.again is not None or frame.restore or frame.count != _LOCALS:
            return False
        if not anywhere and frame.label != label:
            return False
        return self._return(frame, self.stack[self.depth] if self.arguments > 0 else _NAN)

    @cython.cfunc
    def _return(self, frame: Frame, result: cython.double) -> cython.bint:
        """End the innermost call, which gives a value, NaN for none."""
        self.frames.pop()
        frame.put_back(self.numbers)
        self.store.local = frame.named
        self.store.returned, self.store.result = True, result
        if frame.source != self.source:
            self.away = frame.back
        elif 0 <= frame.row < self.rows.used and self.kept[frame.row, AFTER] == frame.offset:
            self.next, self.next_line = self.rows.following(frame.row), frame.line
        else:
            self._go(frame.offset, frame.line)
        return True

    # Programs by their number.

    @cython.cfunc
    def _call_program(self, r: cython.Py_ssize_t) -> cython.bint:
        """Follow M98 or G65, whose words stand behind those in the columns; tell whether it is certain where that leads."""
        first: cython.Py_ssize_t = self._first_word()
        last: cython.Py_ssize_t = self.words
        number: cython.double = -1.0
        times: cython.double = 1.0
        macro: cython.bint = self.called == _MACRO
        letter: cython.int
        value: cython.double
        for k in range(first, last):
            letter, value = self.letters[k], self.values[k]
            if letter == 112:
                number = value
            elif letter == 108:
                times = value
            elif not (letter == (103 if macro else 109) and value == self.called) and not (
                macro and _ARGUMENT[letter - 97]
            ):
                return False
        if macro and self.letters[first] != 103:
            return False
        if not 0.0 <= number <= _MOST_NUMBER or number != floor(number) or len(self.frames) >= self.deepest:
            return False
        if not 1.0 <= times <= (1.0 if macro else _MOST_NUMBER) or times != floor(times):
            return False
        begin = self.store.ways.get(number)
        if begin is None:
            begin = self.begins(self.kept[r, AT], self.kept[r, NUMBER_OF_LINE], number)
            if begin is None:
                return False
            self.store.ways[number] = begin
        self._end_call(r, first)
        frame: Frame = self._begin(r, number, _MACRO_LOCALS if macro else 0)
        frame.again = (begin, cython.cast(cython.int, times) - 1)
        if macro:
            for k in range(_MACRO_LOCALS):
                self.numbers[k + 1] = _NAN
            for k in range(first, last):
                letter = _ARGUMENT[self.letters[k] - 97]
                if letter:
                    self.numbers[letter] = self.values[k]
        self._go_to_place(begin)
        return True

    @cython.cfunc
    def _end_program(self, r: cython.Py_ssize_t) -> cython.bint:
        """Follow M99 by itself: end the program that was called, or its present round; tell whether it is certain where that leads."""
        first: cython.Py_ssize_t = self._first_word()
        if not self.frames or self.words > first + 1:
            return False
        frame: Frame = self.frames[len(self.frames) - 1]
        if frame.again is None or frame.restore or frame.modal:
            return False
        begin, left = frame.again
        if left > 0 and frame.values is not None:
            return False
        self._end_call(r, first)
        if left == 0:
            return self._return(frame, _NAN)
        frame.again = (begin, left - 1)
        self.units += _PLAIN_CALL_UNITS
        self._go_to_place(begin)
        return True

    @cython.cfunc
    def _end_call(self, r: cython.Py_ssize_t, first: cython.Py_ssize_t) -> cython.void:
        """Do the settings of a line with a call, whose words are from `first` on; its comment is a block, but beside G65."""
        self.words = first
        if self.called == _MACRO:
            self.flags = 0
        self._end_block(r)

    @cython.cfunc
    def _go_to_place(self, place) -> cython.void:
        """Make a line of this text or another one the next."""
        if place[0] == self.source:
            self._go(place[1], place[2])
        else:
            self.away = place
