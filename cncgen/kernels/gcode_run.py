"""Run lines of G-code as `gcode_parse` has compiled them: expressions, parameters and settings, O-words, blocks into columns.

A line is parsed once, by the tables of the grammar, and kept as instructions; loops and calls run those. Like `gcode_scan` this
judges nothing. A line that it does not take for certain is left to the interpreter, which knows the whole language and every
error: a value that the machine's state enters, an unknown name, a division by zero, any code but those of plain motions.

    offset of a line ──► row of `gcode_lines.Lines` ──► instructions ─┬► words: a block in the columns
       ▲                                                           ├► settings, done at the end of the line
       └──── row of the line that an O-word leads to ◄─────────────┴► an O-word, by the rows of `gcode_marks`
"""

import cython
from cython.cimports.cncgen.kernels.gcode_arithmetic import function_of, joined
from cython.cimports.cncgen.kernels.gcode_codes import (
    AFTER, ANGLE_OF, ARC_TANGENT, AT, AT_NEXT, AT_PREVIOUS, BEHIND, BINARY, CODE, COMMENT, COUNTS, DELETED, ELEMENT, END, FIRST_CONSTANT, FLOW, FOLLOWING,
    FUNCTION, GOTO, HERE, JUMP, KEYWORD, LABEL, LINE, MARK, MARKS, NAME, NAMED, NEGATIVE, NUMBER, NUMBERED, NUMBER_OF_LINE, OFFSET, OTHER,
    O_CALL, O_ELSEIF, O_ENDSUB, O_IF, O_REPEAT, O_RETURN, O_SUB, O_WHILE, PARAMETER, PROGRAM, REFUSED, ROW, SET, SET_ELEMENT, SET_NAMED, SET_STORED,
    SET_VARIABLE, STAY, STORED, TARGET, THEN, WHILE_DO, WORD,
)  # fmt: skip
from cython.cimports.cncgen.kernels.gcode_frames import Frame
from cython.cimports.cncgen.kernels.language_store import LanguageStore
from cython.cimports.libc.math import fabs, floor, isfinite

from cncgen.kernels.gcode_lines import Lines, zeros

#: Flags of a block (`gcode_scan`).
_COMMENT = cython.declare(cython.int, 2)
_NUMBERED_BLOCK = cython.declare(cython.int, 8)

#: How far from a whole number the number of a parameter may be (`flow.o_words`).
_WHOLE = cython.declare(cython.double, 1e-4)
#: Larger numbers in words are faults (`block.LARGEST`).
_LARGEST = cython.declare(cython.double, 1e9)
#: Values that wait for an operator, and settings of a line.
_STACK = cython.declare(cython.int, 100)
_MOST_SETTINGS = cython.declare(cython.int, 40)
#: Lines that are kept, and those that are compiled together, at most.
_KEPT = cython.declare(cython.Py_ssize_t, 262_144)
_TOGETHER = cython.declare(cython.Py_ssize_t, 64)
_SHORT = cython.declare(cython.Py_ssize_t, 1024)

#: Letters of words that are taken, as bits (A is bit 0): not D E H N O T, which tools, parameters and jumps hang on.
_LETTERS = cython.declare(cython.uint, sum(1 << (ord(letter) - 97) for letter in "abcfgijklmpqrsuvwxyz"))
#: Codes beyond are not taken.
_MOST_CODE = cython.declare(cython.int, 100)

#: Local numbered parameters of a subroutine, from #1 on, and units of work of a call (`budget.CALL`).
_LOCALS = cython.declare(cython.int, 30)
_CALL_UNITS = cython.declare(cython.int, 12)
#: Lines that are not run here.
_LEFT_OUT = cython.declare(cython.int, DELETED | REFUSED)
#: Kinds of lines: uncertain, a block or settings; else the number of its keyword.
_UNCERTAIN = cython.declare(cython.int, -1)
_PLAIN = cython.declare(cython.int, 0)
#: Kinds of lines with a jump of a language: this, and the jump.
_JUMPS = cython.declare(cython.int, 1000)
#: The sort of names that cannot be set; 0 and 1 are those of the call in progress and of all.
_RESERVED = cython.declare(cython.int, 2)


@cython.cclass
class Computer:
    """A place in a text, and the columns that its lines go to. O-words are followed once `follow` has given their rows, jumps and loops of
    macros where `leads` tells their lines.

    Args:
        text: The text.
        parser: A `gcode_parse.Parser` that nobody else uses, of LinuxCNC's grammar or FANUC's.
        numbers: Numbered parameters by number, an array of doubles, read and set.
        named: Global parameters by name, read and set.
        reserved: Names that cannot be set.
        columns: The columns of `gcode_scan.scan`: line, offset, flags, ends of the words, letters, values.
        waits: Tells whether a block with a code, a letter and a whole number, may wait.
        pause: Lines after which a jump back ends a run.
        language: What lines of SINUMERIK and Heidenhain read, set at once, and jump by; G-code has none.
        storage: Parameters below this are plain storage; the others belong to the machine.
        meant: The operators and functions of the dialect by those of the grammar, where they differ (0: of the interpreter alone).
        frames: The calls in progress, the innermost last.
        leads: Of macros, returns offset and number of the line that GOTO, DO or END leads to, by offset and number of its line, keyword and
            value; None where there is none.

    Attributes:
        blocks: How many blocks stand in the columns; whoever takes them sets it to 0.
        line: Number of the first line not read.
        lines, units: How many lines the last run read, and units of work that its calls were beside them.
        meets: Whether the last run ended at an O-word of a text whose rows are not given.
        back: The O-word, by offset and line, whose jump back ended the last run, or None; `away`, where it led to in another text.
        reached, reached_line: The first line that was never reached outside of calls.
        since: Lines read since that line, or since whoever looks set it to 0.
        ran, ran_line: The line that was read last.
    """

    text: cython.const[cython.uchar][::1]
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
    marks: cython.longlong[:, ::1]
    argument: cython.double[::1]
    target: cython.longlong[::1]
    set_to: cython.double[::1]
    store = cython.declare(object)
    named = cython.declare(dict)
    local = cython.declare(dict)
    reserved = cython.declare(frozenset)
    names = cython.declare(list)
    sorts = cython.declare(bytearray)
    waits = cython.declare(object)
    pause = cython.declare(cython.Py_ssize_t)
    at_once = cython.declare(cython.bint)
    language = cython.declare(LanguageStore, visibility="public")
    counter = cython.declare(cython.int)
    meant = cython.declare(cython.int[128])
    storage = cython.declare(cython.int)
    leads = cython.declare(object)
    taken = cython.declare(cython.uchar[200])
    entries = cython.declare(dict)
    blocks = cython.declare(cython.Py_ssize_t, visibility="public")
    line = cython.declare(cython.longlong, visibility="public")
    lines = cython.declare(cython.Py_ssize_t, visibility="public")
    units = cython.declare(cython.Py_ssize_t, visibility="public")
    meets = cython.declare(cython.bint, visibility="public")
    back = cython.declare(object, visibility="public")
    away = cython.declare(object, visibility="public")
    reached = cython.declare(cython.Py_ssize_t, visibility="public")
    reached_line = cython.declare(cython.longlong, visibility="public")
    since = cython.declare(cython.Py_ssize_t, visibility="public")
    ran = cython.declare(cython.Py_ssize_t, visibility="public")
    ran_line = cython.declare(cython.longlong, visibility="public")
    parameters = cython.declare(object)
    frames = cython.declare(list)
    outermost = cython.declare(object)
    deepest = cython.declare(cython.Py_ssize_t)
    source = cython.declare(cython.longlong)
    labels = cython.declare(list)
    count = cython.declare(cython.Py_ssize_t)
    used = cython.declare(cython.Py_ssize_t)
    last = cython.declare(cython.Py_ssize_t)
    ahead = cython.declare(cython.Py_ssize_t)
    thrown = cython.declare(cython.Py_ssize_t)
    words = cython.declare(cython.Py_ssize_t)
    given = cython.declare(cython.uint)
    flags = cython.declare(cython.int)
    settings = cython.declare(cython.int)
    holds = cython.declare(cython.bint)
    arguments = cython.declare(cython.int)
    next = cython.declare(cython.Py_ssize_t)

    def __init__(
        self, text, parser, numbers, named, reserved, columns, waits, pause, language=None, storage=0, meant=None, frames=None, leads=None
    ):  # fmt: skip
        if not cython.compiled:
            self.taken, self.meant = [0] * (2 * _MOST_CODE), [0] * 128
        for k in range(128):
            self.meant[k] = k
        for operation, number in (meant or {}).items():
            self.meant[operation] = number
        self.storage, self.leads = storage, leads
        self.waits, self.pause = waits, pause
        self.at_once = language is not None
        self.language = language if self.at_once else LanguageStore(numbers, 1, ())
        self.ran = self.ran_line = 0
        self.text = text
        self.code, self.constants, self.names = parser.code, parser.constants, parser.names
        self.language.names = parser.names
        self.numbers = numbers
        self.named = named
        self.local = {}
        self.reserved = reserved
        self.sorts = bytearray()
        self.block_line, self.block_offset, self.block_flags = columns[:3]
        self.word_end, self.letters, self.values = columns[3:]
        self.kept = zeros(8 * ROW * _KEPT).cast("q", [_KEPT, ROW])
        self.store = Lines(parser, text, self.kept)
        self.argument = memoryview(bytearray(8 * _STACK)).cast("d")
        self.target = memoryview(bytearray(8 * _MOST_SETTINGS)).cast("q")
        self.set_to = memoryview(bytearray(8 * _MOST_SETTINGS)).cast("d")
        self.frames = [] if frames is None else frames
        self.labels = []
        self.blocks = self.count = 0
        self.ahead = 1
        self.thrown = 0
        self.reached = self.reached_line = self.since = 0
        self.line = 1
        self._forget()

    def find_marks(self):
        """Return the O-words of the text."""
        # Most programs have none.
        from cncgen.kernels.gcode_marks import Marks

        self._forget()
        found = Marks(self.store, self.text.shape[0])
        self.used = found.used
        return found

    def follow(self, marks, parameters, outermost, deepest, source):
        """Follow O-words from now on.

        Args:
            marks: Those of `find_marks`.
            parameters: The parameters; `local` are the named ones of the call in progress.
            outermost: The record of the main program below the calls in progress.
            deepest: How many calls may be in progress.
            source: Number of the text.
        """
        self.marks, self.count, self.labels = marks.rows, marks.count, marks.labels
        self.parameters, self.outermost = parameters, outermost
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
        top: cython.bint
        r: cython.Py_ssize_t
        after: cython.Py_ssize_t
        self.local = local
        self.lines = self.units = 0
        self.meets = False
        self.back = self.away = None
        r = self._row(offset, line)
        while r >= 0 and self.blocks < self.block_line.shape[0] and self.lines < most:
            offset, line, after = self.kept[r, AT], self.kept[r, NUMBER_OF_LINE], self.kept[r, AFTER]
            self.last = r
            self.words = self.word_end[self.blocks - 1] if self.blocks > 0 else 0
            keyword = self._execute(r)
            if keyword < 0:
                if self.at_once:
                    self.language.undo()
                break
            top = len(self.frames) == 0 and self.language.depth == 0
            if keyword == _PLAIN:
                self._end_block(r)
                self.lines += 1
                self.next = self._following(r)
            else:
                self.meets = self.count == 0 and keyword <= O_CALL
                if not (
                    self._jump(r, keyword - _JUMPS)
                    if keyword >= _JUMPS
                    else (self._flow(r, keyword) if keyword <= O_CALL else self._lead(r, keyword))
                ):
                    break
                self.lines += 1
                if top and after > self.reached:
                    self.reached, self.reached_line = after, line + 1
                    self.since = -self.lines
                if self.away is not None:
                    break
            self.ran, self.ran_line = offset, line
            if self.next < 0:
                # The end of the text.
                offset, line = -1 - self.next, line + 1
            else:
                if (
                    keyword != _PLAIN
                    and self.kept[self.next, AT] <= offset
                    and self.since + self.lines >= self.pause * (1 + (self.language.depth > 0))
                ):
                    self.back = (offset, line)
                offset, line = self.kept[self.next, AT], self.kept[self.next, NUMBER_OF_LINE]
            r = self.next
            if offset > self.reached and len(self.frames) == 0 and self.language.depth == 0:
                self.reached, self.reached_line = offset, line
                self.since = -self.lines
            if self.back is not None:
                break
        self.since += self.lines
        self.line = line
        return offset

    # Lines that are kept.

    @cython.cfunc
    def _forget(self) -> cython.void:
        """Throw all lines away."""
        m: cython.Py_ssize_t
        self.used = self.last = 0
        self.thrown += 1
        self.entries, self.language.ways = {}, {}
        self.store.forget()
        for m in range(self.count):
            self.marks[m, HERE] = self.marks[m, BEHIND] = -1

    @cython.cfunc
    def _row(self, offset: cython.Py_ssize_t, line: cython.longlong) -> cython.Py_ssize_t:
        """Return the row of a line, which is compiled where it is not kept; below 0 (less its offset) at the end of the text."""
        following: cython.Py_ssize_t
        if offset >= self.text.shape[0]:
            return -1 - offset
        if self.last < self.used:
            following = self.kept[self.last, FOLLOWING]
            if following >= 0 and self.kept[following, AT] == offset:
                return following
        found = self.entries.get(offset)
        if found is None:
            self.ahead = 1
            found = self._compiled(offset, line, 0)
            self.entries[offset] = found
        return found

    @cython.cfunc
    def _compiled(
        self, offset: cython.Py_ssize_t, line: cython.longlong, m: cython.Py_ssize_t
    ) -> cython.Py_ssize_t:
        """Compile lines from one on, the more the longer lines follow one another; return its row.

        `m` is the mark that is likely to be the next one.
        """
        first: cython.Py_ssize_t = self.used
        end: cython.Py_ssize_t = self.text.shape[0]
        if self.count > 0:
            if (
                m >= self.count
                or self.marks[m, OFFSET] < offset
                or (m > 0 and self.marks[m - 1, OFFSET] >= offset)
            ):
                m = self._mark_behind(offset)
            if m < self.count and self.marks[m, HERE] >= 0:
                # Lines of O-words are compiled when they are found.
                if self.marks[m, OFFSET] == offset:
                    return self.marks[m, HERE]
                end = self.marks[m, OFFSET]
        if (
            first == _KEPT
            or not self.store.code.room()
            or (self.count == 0 and self.language.leads is None and first > _SHORT)
        ):
            # Without jumps, no line comes again.
            self._forget()
            first = 0
        self.used = self.store.compile(offset, line, first, min(first + self.ahead, _KEPT), end)
        self.ahead = min(2 * self.ahead, _TOGETHER)
        return first

    @cython.cfunc
    @cython.inline
    def _following(self, r: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Return the row of the line behind that of a row; below 0 at the end of the text."""
        found: cython.Py_ssize_t = self.kept[r, FOLLOWING]
        return found if found >= 0 else self._led_on(r)

    @cython.cfunc
    def _led_on(self, r: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Do the same where it is not known yet."""
        offset: cython.Py_ssize_t = self.kept[r, AFTER]
        thrown: cython.Py_ssize_t = self.thrown
        found: cython.Py_ssize_t
        if offset >= self.text.shape[0]:
            return -1 - offset
        found = self._compiled(offset, self.kept[r, NUMBER_OF_LINE] + 1, self.kept[r, MARK] + 1)
        if thrown == self.thrown:
            self.kept[r, FOLLOWING] = found
        return found

    # Instructions.

    @cython.cfunc
    def _execute(self, r: cython.Py_ssize_t) -> cython.int:
        """Run the instructions of a row: words go behind those in the columns, settings and the values of an O-word wait.

        Returns the keyword of an O-word, `_PLAIN` or `_UNCERTAIN`.
        """
        stack = cython.declare(cython.double[100])
        depth: cython.int = 0
        at: cython.Py_ssize_t = self.kept[r, CODE]
        constants: cython.Py_ssize_t = self.kept[r, FIRST_CONSTANT]
        operation: cython.int
        operand: cython.int
        k: cython.int
        self.given = 0
        self.settings = self.language.settings = 0
        self.flags = _NUMBERED_BLOCK if self.kept[r, MARKS] & NUMBERED else 0
        if self.kept[r, MARKS] & _LEFT_OUT:
            return _UNCERTAIN
        while True:
            operation, operand = self.code[at] & 255, self.code[at] >> 8
            at += 1
            if operation == NUMBER:
                if depth == _STACK:
                    return _UNCERTAIN
                stack[depth] = self.constants[constants + operand]
                depth += 1
            elif operation == WORD:
                depth -= 1
                if not self._word(operand, stack[depth]):
                    return _UNCERTAIN
            elif operation == BINARY:
                depth -= 1
                stack[depth - 1] = joined(self.meant[operand], stack[depth - 1], stack[depth])
                if stack[depth - 1] != stack[depth - 1]:
                    return _UNCERTAIN
            elif operation == STORED:
                if depth == _STACK:
                    return _UNCERTAIN
                stack[depth] = self.numbers[operand]
                if stack[depth] != stack[depth]:
                    # It is vacant.
                    return _UNCERTAIN
                depth += 1
            elif operation == END:
                return _PLAIN
            elif operation == SET or operation == SET_NAMED:
                depth -= 2
                if not self._set_later(operation == SET_NAMED, stack[depth], stack[depth + 1]):
                    return _UNCERTAIN
            elif operation == SET_STORED:
                depth -= 1
                if not self.language.set(operand, stack[depth]):
                    return _UNCERTAIN
            elif operation == FUNCTION:
                stack[depth - 1] = function_of(self.meant[operand], stack[depth - 1])
                if not isfinite(stack[depth - 1]):
                    return _UNCERTAIN
            elif operation == NAMED or operation == NAME:
                if depth == _STACK or (operation == NAMED and not self._has(operand)):
                    return _UNCERTAIN
                stack[depth] = self.language.found if operation == NAMED else operand
                depth += 1
            elif operation == COMMENT:
                self.flags |= _COMMENT
                at += 1
            elif operation == NEGATIVE:
                stack[depth - 1] = -stack[depth - 1]
            elif operation == PARAMETER:
                k = self._index(stack[depth - 1])
                if k < 0:
                    return _UNCERTAIN
                stack[depth - 1] = self.numbers[k]
                if stack[depth - 1] != stack[depth - 1]:
                    return _UNCERTAIN
            elif operation == SET_VARIABLE:
                depth -= 1
                if not self.language.set_variable(operand, stack[depth]):
                    return _UNCERTAIN
            elif operation == ELEMENT:
                if not self.language.has_element(operand, stack[depth - 1]):
                    return _UNCERTAIN
                stack[depth - 1] = self.language.found
            elif operation == SET_ELEMENT:
                depth -= 2
                if not self.language.set_element(operand, stack[depth], stack[depth + 1]):
                    return _UNCERTAIN
            elif operation == JUMP:
                if self.language.leads is None:
                    return _UNCERTAIN
                if operand == COUNTS:
                    self.counter = self.code[at]
                for k in range(depth):
                    self.argument[k] = stack[k]
                return _JUMPS + operand
            elif operation == ARC_TANGENT:
                depth -= 1
                stack[depth - 1] = joined(self.meant[ANGLE_OF], stack[depth - 1], stack[depth])
            elif operation == FLOW and self.leads is not None:
                # Settings before a jump act before its values are read.
                if operand <= PROGRAM or self.settings or self._has_words():
                    return _UNCERTAIN
                self.holds = depth == 1 or stack[0] != 0.0
                self.argument[0] = stack[depth - 1]
                return operand
            elif operation == THEN and self.leads is not None:
                depth -= 1
                if stack[depth] == 0.0:
                    return _PLAIN
            elif operation == FLOW and operand <= O_CALL:
                self.arguments = self.code[at]
                depth -= self.arguments
                for k in range(self.arguments):
                    self.argument[k] = stack[depth + k]
                return operand
            else:
                return _UNCERTAIN

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
        if not bit & _LETTERS or bit & self.given or not -_LARGEST <= value <= _LARGEST:
            return False
        if letter == 103 or letter == 109:
            if not 0.0 <= value < _MOST_CODE or value != floor(value):
                return False
            if not self._waits(letter, cython.cast(cython.int, value)):
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
        return self.words > (self.word_end[self.blocks - 1] if self.blocks > 0 else 0)

    @cython.cfunc
    def _end_block(self, r: cython.Py_ssize_t) -> cython.void:
        """Do the settings of a line, and make a block of its words."""
        k: cython.int
        for k in range(0 if self.at_once else self.settings):
            if self.target[k] >= 0:
                self.numbers[self.target[k]] = self.set_to[k]
            else:
                name = self.names[-1 - self.target[k]]
                (self.named if self.sorts[-1 - self.target[k]] else self.local)[name] = self.set_to[k]
        if self._has_words() or self.flags & _COMMENT:
            self.block_line[self.blocks] = self.kept[r, NUMBER_OF_LINE]
            self.block_offset[self.blocks] = self.kept[r, AT]
            self.block_flags[self.blocks] = self.flags
            self.word_end[self.blocks] = self.words
            self.blocks += 1

    # Parameters.

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _index(self, value: cython.double) -> cython.int:
        """Return the number of a parameter; -1 unless it is plain storage."""
        whole: cython.double = floor(value + 0.5)
        if self.at_once:
            return self.language.index(value)
        if fabs(value - whole) > _WHOLE or not 0.0 < whole < self.storage:
            return -1
        return cython.cast(cython.int, whole)

    @cython.cfunc
    def _sort(self, k: cython.int) -> cython.int:
        """Return of which sort a name is."""
        while len(self.sorts) <= k:
            name: str = self.names[len(self.sorts)]
            sort = _RESERVED if name in self.reserved else name.startswith("_")
            self.sorts.append(sort)
        return self.sorts[k]

    @cython.cfunc
    def _has(self, k: cython.int) -> cython.bint:
        """Take the value of a named parameter as `language.found`; tell whether it has one.

        Parameters that tell the machine's state are not stored, so they are not found.
        """
        if self.at_once:
            return self.language.has(k)
        value = (self.named if self._sort(k) else self.local).get(self.names[k])
        if value is None:
            return False
        self.language.found = value
        return True

    @cython.cfunc
    def _set_later(self, named: cython.bint, target: cython.double, value: cython.double) -> cython.bint:
        """Keep a setting for the end of the line; tell whether it can be done."""
        k: cython.int
        if self.settings == _MOST_SETTINGS:
            return False
        if named:
            k = cython.cast(cython.int, target)
            if self._sort(k) == _RESERVED:
                return False
            self.target[self.settings] = -1 - k
        else:
            k = self._index(target)
            if k < 0 or self.at_once:
                return k >= 0 and self.language.set(k, value)
            self.target[self.settings] = k
        self.set_to[self.settings] = value
        self.settings += 1
        return True

    @cython.cfunc
    def _jump(self, r: cython.Py_ssize_t, jump: cython.int) -> cython.bint:
        """Follow the jump of a row to the `next` line; tell whether it is certain where that is."""
        line: cython.longlong = self.kept[r, NUMBER_OF_LINE]
        goes: cython.int = self.language.goes(r, line, jump, self.counter, self.argument[0], self.argument[1])
        if goes > 0:
            self.next = self._row(self.language.way[2], self.language.way[3])
        elif goes == 0:
            self.next = self._following(r)
        return goes >= 0

    @cython.cfunc
    def _lead(self, r: cython.Py_ssize_t, keyword: cython.int) -> cython.bint:
        """Follow GOTO, DO or END of a macro to the `next` line; tell whether there is one."""
        if keyword == GOTO and not self.holds:
            self.next = self._following(r)
            return True
        key = (r, self.argument[0])
        way = self.language.ways.get(key)
        if way is None:
            way = self.leads(self.kept[r, AT], self.kept[r, NUMBER_OF_LINE], keyword, self.argument[0])
            if way is None:
                return False
            self.language.ways[key] = way
        self.next = self._following(r) if keyword == WHILE_DO and self.holds else self._row(way[0], way[1])
        return True

    # O-words.

    @cython.cfunc
    def _flow(self, r: cython.Py_ssize_t, keyword: cython.int) -> cython.bint:
        """Follow the O-word of a row to the `next` line; tell whether it is certain where that is.

        `flow.o_words` defines the O-words; here they are followed by the rows that they lead to.
        """
        target: cython.longlong
        value: cython.double = self.argument[0] if self.arguments else 0.0
        way: cython.int
        m: cython.Py_ssize_t = self.kept[r, MARK]
        if m < 0:
            m = self.kept[r, MARK] = self._mark_behind(self.kept[r, AT])
        if m >= self.count or self.marks[m, OFFSET] != self.kept[r, AT]:
            return False
        target = self.marks[m, TARGET]
        if target < 0 and not (keyword == O_WHILE and self.marks[m, OTHER] >= 0):
            return False
        if keyword == O_CALL:
            return self._call(r, m)
        if self.arguments > 1:
            return False
        if keyword == O_ENDSUB or keyword == O_RETURN:
            return self._leave(m, keyword == O_RETURN)
        if (self.arguments == 1) != (
            keyword == O_IF or keyword == O_ELSEIF or keyword == O_WHILE or keyword == O_REPEAT
        ):
            return False
        if keyword == O_SUB:
            self.next = self._behind(target)
            return True
        frame: Frame = self.frames[len(self.frames) - 1] if self.frames else self.outermost
        label = self.labels[self.marks[m, LABEL]]
        if keyword == O_WHILE:
            # The foot of a loop that DO began, or the head of one.
            if frame.doing is not None and label in frame.doing:
                target = self.marks[m, OTHER]
            elif self.marks[m, OTHER] >= 0:
                return False
            if target < 0:
                return False
        elif keyword == O_REPEAT and not frame.repeats(label):
            if value != floor(value) or not fabs(value) <= _LARGEST:
                return False
        way = frame.lead(keyword, label, value)
        if way == STAY:
            self.next = self._behind(m)
        elif keyword == O_IF:
            return self._branch(target)
        elif way == AT_NEXT or way == AT_PREVIOUS:
            self.next = self._at(target)
        else:
            self.next = self._behind(target)
        return True

    @cython.cfunc
    def _branch(self, target: cython.longlong) -> cython.bint:
        """Go into the first branch behind an IF that does not hold whose condition does."""
        while self.marks[target, KEYWORD] == O_ELSEIF:
            if self._execute(self._at(target)) != O_ELSEIF or self.arguments != 1:
                return False
            if self.argument[0] != 0.0:
                break
            target = self.marks[target, OTHER]
            if target < 0:
                return False
        self.next = self._behind(target)
        return True

    @cython.cfunc
    def _call(self, r: cython.Py_ssize_t, m: cython.Py_ssize_t) -> cython.bint:
        """Begin a call of a subroutine of this text."""
        k: cython.Py_ssize_t
        if self.arguments > _LOCALS or len(self.frames) >= self.deepest:
            return False
        frame: Frame = Frame(self.labels[self.marks[m, LABEL]], self.local)
        frame.source, frame.offset, frame.line = (
            self.source,
            self.kept[r, AFTER],
            self.kept[r, NUMBER_OF_LINE] + 1,
        )
        frame.row = r
        frame.keep(self.numbers, _LOCALS)
        self.frames.append(frame)
        for k in range(_LOCALS):
            self.numbers[k + 1] = self.argument[k] if k < self.arguments else 0.0
        self.parameters.local = self.local = {}
        self.units += _CALL_UNITS
        self.next = self._behind(self.marks[m, TARGET])
        return True

    @cython.cfunc
    def _leave(self, m: cython.Py_ssize_t, anywhere: cython.bint) -> cython.bint:
        """End the innermost call, where nothing but its caller's parameters is to be put back."""
        given: cython.bint = self.arguments > 0
        if not self.frames:
            return False
        frame: Frame = self.frames[len(self.frames) - 1]
        if frame.again is not None or frame.restore or frame.count != _LOCALS:
            return False
        if not anywhere and frame.label != self.labels[self.marks[m, LABEL]]:
            return False
        self.frames.pop()
        frame.put_back(self.numbers)
        self.parameters.local = self.local = frame.named
        self.named["_value"] = self.argument[0] if given else 0.0
        self.named["_value_returned"] = 1.0 if given else 0.0
        if frame.source != self.source:
            self.away = frame.back
        elif 0 <= frame.row < self.used and self.kept[frame.row, AFTER] == frame.offset:
            self.next = self._following(frame.row)
        else:
            self.next = self._row(frame.offset, frame.line)
        return True

    @cython.cfunc
    @cython.exceptval(check=False)
    def _mark_behind(self, offset: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Return the first mark at `offset` or behind it."""
        low: cython.Py_ssize_t = 0
        high: cython.Py_ssize_t = self.count
        middle: cython.Py_ssize_t
        while low < high:
            middle = (low + high) // 2
            if self.marks[middle, OFFSET] < offset:
                low = middle + 1
            else:
                high = middle
        return low

    @cython.cfunc
    def _at(self, m: cython.longlong) -> cython.Py_ssize_t:
        """Return the row of the line of a mark."""
        if self.marks[m, HERE] < 0:
            self.marks[m, HERE] = self._row(self.marks[m, OFFSET], self.marks[m, LINE])
        return self.marks[m, HERE]

    @cython.cfunc
    def _behind(self, m: cython.longlong) -> cython.Py_ssize_t:
        """Return the row of the line behind that of a mark; below 0 at the end of the text."""
        r: cython.Py_ssize_t
        if self.marks[m, BEHIND] < 0:
            r = self._following(self._at(m))
            self.marks[m, BEHIND] = r
        return self.marks[m, BEHIND]
