"""Where lines of G-code lead that jump, loop or call: O-words, jumps of macros and of languages, programs by their number.

the line's row, its kind and values (`gcode_instructions`) ──► row of the next line, or its place in another text
"""

import cython
from cython.cimports.cncgen.kernels.gcode_codes import (
    AFTER, AT, AT_NEXT, AT_PREVIOUS, BEHIND, CALLS_MACRO, CODE, COMPUTED_LABEL, ENDS_PROGRAM, FIRST_CONSTANT, GOTO, KEYWORD, LANGUAGE_JUMP,
    LINE, MARK, MARKS, MARK_ABOVE, MARK_BELOW, NUMBERED_CALL, NUMBER_OF_LINE, OFFSET, O_CALL, O_ELSEIF, O_ENDSUB, O_IF, O_REPEAT, O_RETURN,
    O_SUB, O_WHILE, PAST_NEXT, STAY, WHILE_DO,
)  # fmt: skip
from cython.cimports.cncgen.kernels.gcode_frames import Frame
from cython.cimports.cncgen.kernels.gcode_instructions import Instructions
from cython.cimports.libc.math import fabs, floor

from cncgen.kernels.gcode_codes import LOOKS, MACRO_PARAMETERS
from cncgen.kernels.gcode_marks import bits_of

#: Larger counts of REPEAT are faults.
_LARGEST = cython.declare(cython.double, 1e9)
#: Local numbered parameters of a subroutine and of a macro, from #1 on; units of work of a call with its parameters, and without
#: (`budget.CALL`).
_LOCALS = cython.declare(cython.int, 30)
_MACRO_LOCALS = cython.declare(cython.int, 33)
_CALL_UNITS = cython.declare(cython.int, 12)
_PLAIN_CALL_UNITS = cython.declare(cython.int, 4)
#: The largest number of a program, and most rounds of a call.
_MOST_NUMBER = cython.declare(cython.double, 9999.0)
#: By letter, from A on, the parameter that it sets beside G65.
_ARGUMENT = cython.declare(cython.uchar[26])
_k: cython.int
for _k in range(26):
    _ARGUMENT[_k] = MACRO_PARAMETERS.get(chr(97 + _k), 0)
#: The marks that an IF which does not hold looks for.
_BRANCHES = cython.declare(cython.uint, bits_of(LOOKS["if"][1]))
_NAN = cython.declare(cython.double, float("nan"))


@cython.cclass
class Jumps(Instructions):
    """Lines whose jumps and calls are followed: O-words once `follow` was told how, those of macros where `leads` tells their lines.

    Args:
        leads, begins: As `gcode_run.Computer` takes them; the others are those of `Instructions`.

    Attributes:
        next, next_line: Row and number of the line that the last one leads to, the row that of a place behind the text (`gcode_rows`).
        away: Where it leads to in another text, or None.
        units: Units of work of the calls begun.
    """

    def __init__(self, text, parser, store, columns, waits, meant, frames, leads, begins):
        Instructions.__init__(self, text, parser, store, columns, waits, meant, frames, leads is not None)
        self.leads, self.begins = leads, begins
        self.find = self.marks = None

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

    @cython.cfunc
    def follow_line(self, r: cython.Py_ssize_t, kind: cython.int) -> cython.bint:
        """Follow the O-word, jump or call of a row, by its kind, to the `next` line; tell whether it is certain where that is."""
        if kind < 0:
            return False
        if kind == NUMBERED_CALL:
            return self._call_program(r) if self.called != ENDS_PROGRAM else self._end_program(r)
        if kind >= LANGUAGE_JUMP:
            return self._jump(r, kind - LANGUAGE_JUMP)
        return self._flow(r, kind) if kind <= O_CALL else self._lead(r, kind)

    @cython.cfunc
    @cython.final
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
    @cython.final
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

    @cython.cfunc
    @cython.final
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
    @cython.final
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
            self._go_to_mark(m, way == AT_NEXT or way == AT_PREVIOUS)
        return m >= 0

    @cython.cfunc
    @cython.final
    @cython.exceptval(-2, check=False)
    def _branch_that_holds(self, m: cython.Py_ssize_t, label) -> cython.Py_ssize_t:
        """Return the first branch from one on that is no ELSEIF or whose condition holds; -1 where that is not certain."""
        while m >= 0 and self.marks.rows[m, KEYWORD] == O_ELSEIF:
            offset: cython.longlong = self.marks.rows[m, OFFSET]
            if (
                self.execute(self.rows.at(offset, self.marks.rows[m, LINE])) != O_ELSEIF
                or self.arguments != 1
            ):
                return -1
            if self.stack[self.depth] != 0.0:
                break
            m = self.marks.nearest(offset, 1, label, _BRANCHES, False, None)
        return m

    @cython.cfunc
    @cython.final
    def _go_to_mark(self, m: cython.Py_ssize_t, at: cython.bint) -> cython.void:
        """Go `at` the line of a mark, or behind it."""
        self._go(self.marks.rows[m, OFFSET if at else BEHIND], self.marks.rows[m, LINE] + (not at))

    # Calls.

    @cython.cfunc
    @cython.final
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
        self._go_to_mark(m, False)
        return True

    @cython.cfunc
    @cython.final
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
    @cython.final
    def _call_program(self, r: cython.Py_ssize_t) -> cython.bint:
        """Follow M98 or G65, whose words stand behind those in the columns; tell whether it is certain where that leads."""
        first: cython.Py_ssize_t = self.first
        last: cython.Py_ssize_t = self.words
        number: cython.double = -1.0
        times: cython.double = 1.0
        macro: cython.bint = self.called == CALLS_MACRO
        k: cython.Py_ssize_t
        letter: cython.int
        before: cython.int = 0
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
            if 105 <= letter <= 107:
                # Of I, J and K out of order the interpreter tells.
                if letter < before:
                    return False
                before = letter
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
        self._end_call(r)
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
    @cython.final
    def _end_program(self, r: cython.Py_ssize_t) -> cython.bint:
        """Follow M99 by itself: end the program that was called, or its present round; tell whether it is certain where that leads."""
        if not self.frames or self.words > self.first + 1:
            return False
        frame: Frame = self.frames[len(self.frames) - 1]
        if frame.again is None or frame.restore or frame.modal:
            return False
        begin, left = frame.again
        if left > 0 and frame.values is not None:
            return False
        self._end_call(r)
        if left == 0:
            return self._return(frame, _NAN)
        frame.again = (begin, left - 1)
        self.units += _PLAIN_CALL_UNITS
        self._go_to_place(begin)
        return True

    @cython.cfunc
    @cython.final
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
    @cython.final
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

    @cython.cfunc
    @cython.final
    def _end_call(self, r: cython.Py_ssize_t) -> cython.void:
        """Do the settings of a line with a call, whose words are no block; its comment is a block, but beside G65."""
        self.words = self.first
        if self.called == CALLS_MACRO:
            self.flags = 0
        self.end_block(r)

    @cython.cfunc
    @cython.final
    def _go_to_place(self, place) -> cython.void:
        """Make a line of this text or another one the next."""
        if place[0] == self.source:
            self._go(place[1], place[2])
        else:
            self.away = place

    @cython.cfunc
    @cython.final
    def _go(self, offset: cython.Py_ssize_t, line: cython.longlong) -> cython.void:
        """Make a line the next one."""
        self.next, self.next_line = self.rows.at(offset, line), line
