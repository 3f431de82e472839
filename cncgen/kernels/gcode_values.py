"""Compute lines of G-code on the spot: expressions, parameters and settings, straight from the bytes to numbers.

The grammar reads expressions into functions of the parameters, which pay where a line runs again and again; here they are
computed while they are read. Like `gcode_scan` it judges nothing. A line that it does not take for certain is left to the
interpreter, which knows the whole language and every error: a value that the machine's state enters, an unknown name, a
division by zero, any code but those of plain motions.

The language is LinuxCNC's (``grammars/gcode.lark``); `cncgen.gcode.text.expressions` defines operators and functions.
"""

import cython
from cython.cimports.libc.math import fabs, floor, isfinite

if cython.compiled:
    from cython.cimports.cncgen.kernels.gcode_arithmetic import arc_tangent, function_of, joined, operator_at
else:
    from cncgen.kernels.gcode_arithmetic import arc_tangent, function_of, joined, operator_at
from cncgen.kernels.gcode_marks import AFTER, ARGUMENTS, KEYWORD, KEYWORDS, LABEL, LINE, OFFSET, OTHER, TARGET

#: Flags of a block (`gcode_scan`).
_COMMENT = cython.declare(cython.int, 2)
_NUMBERED = cython.declare(cython.int, 8)

#: How far from a whole number the number of a parameter may be (`expressions.EQUAL`).
_WHOLE = cython.declare(cython.double, 1e-4)
#: Larger numbers in words are faults (`block.LARGEST`).
_LARGEST = cython.declare(cython.double, 1e9)
#: Parameters below this are plain storage; the others belong to the machine.
_STORED = cython.declare(cython.int, 5000)
#: Brackets and parameters of parameters within one another (`grammar.MAX_NESTING`).
_DEPTH = cython.declare(cython.int, 60)
#: Digits of a number that is read here: its integer and its power of ten are doubles without error.
_DIGITS = cython.declare(cython.int, 15)

#: Letters of words that are taken, as bits (A is bit 0): not D E H N O T, which tools, parameters and jumps hang on.
_LETTERS = cython.declare(cython.uint, 0)
#: Letters that may stand more than once in a block: G and M.
_CODES = cython.declare(cython.uint, 1 << 6 | 1 << 12)
#: G and M codes that are taken: none that reads or sets a parameter, or leads elsewhere.
_G_TAKEN = cython.declare(cython.uchar[100])
_M_TAKEN = cython.declare(cython.uchar[10])

#: How tight the operators bind that bind the least (`gcode_arithmetic`).
_LOGIC = cython.declare(cython.int, 1)
#: Letters of a function of two arguments, ATAN, five bits each; every name is this short.
_ATAN = cython.declare(cython.uint, 1 << 15 | 20 << 10 | 1 << 5 | 14)
_LONGEST = cython.declare(cython.int, 6)

#: Lines after which a jump back ends a run, so that rows are taken away and endless loops seen.
PAUSE = 1024
_PAUSE = cython.declare(cython.Py_ssize_t, PAUSE)
#: Local numbered parameters of a subroutine, from #1 on, and units of work of a call (`budget.CALL`).
_LOCALS = cython.declare(cython.int, 30)
_CALL_UNITS = cython.declare(cython.int, 12)
#: Where an O-word of a branch or loop leads (`Frame.lead`).
STAY, AT_NEXT, PAST_NEXT, AT_PREVIOUS, PAST_PREVIOUS = range(5)
_STAY = cython.declare(cython.int, STAY)
_AT_NEXT = cython.declare(cython.int, AT_NEXT)
_PAST_NEXT = cython.declare(cython.int, PAST_NEXT)
_AT_PREVIOUS = cython.declare(cython.int, AT_PREVIOUS)
_PAST_PREVIOUS = cython.declare(cython.int, PAST_PREVIOUS)
#: Columns of a row of `gcode_marks`, and its keywords.
_OFFSET = cython.declare(cython.int, OFFSET)
_LINE = cython.declare(cython.int, LINE)
_ARGUMENTS = cython.declare(cython.int, ARGUMENTS)
_AFTER = cython.declare(cython.int, AFTER)
_KEYWORD = cython.declare(cython.int, KEYWORD)
_LABEL = cython.declare(cython.int, LABEL)
_TARGET = cython.declare(cython.int, TARGET)
_OTHER = cython.declare(cython.int, OTHER)
_IF = cython.declare(cython.int, KEYWORDS["if"])
_WHILE = cython.declare(cython.int, KEYWORDS["while"])
_REPEAT = cython.declare(cython.int, KEYWORDS["repeat"])
_DO = cython.declare(cython.int, KEYWORDS["do"])
_ELSEIF = cython.declare(cython.int, KEYWORDS["elseif"])
_ELSE = cython.declare(cython.int, KEYWORDS["else"])
_ENDIF = cython.declare(cython.int, KEYWORDS["endif"])
_ENDWHILE = cython.declare(cython.int, KEYWORDS["endwhile"])
_ENDREPEAT = cython.declare(cython.int, KEYWORDS["endrepeat"])
_BREAK = cython.declare(cython.int, KEYWORDS["break"])
_CONTINUE = cython.declare(cython.int, KEYWORDS["continue"])
_SUB = cython.declare(cython.int, KEYWORDS["sub"])
_ENDSUB = cython.declare(cython.int, KEYWORDS["endsub"])
_RETURN = cython.declare(cython.int, KEYWORDS["return"])
_CALL = cython.declare(cython.int, KEYWORDS["call"])


@cython.cfunc
def _fill_tables() -> cython.void:
    """Fill the tables of letters and codes, once."""
    global _LETTERS
    c: cython.int
    for c in b"abcfgijklmpqrsuvwxyz":
        _LETTERS |= cython.cast(cython.uint, 1) << (c - 97)
    for c in range(100):
        _G_TAKEN[c] = c in (0, 1, 2, 3, 4, 33, 61, 64, 73, 80, 81, 82, 83, 85, 89, 90, 91, 93, 94, 98, 99)
    for c in range(10):
        _M_TAKEN[c] = c in (3, 4, 5, 7, 8, 9)


_fill_tables()


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _is_letter(c: cython.int) -> cython.bint:
    """Tell whether a byte is a letter."""
    return 97 <= (c | 32) <= 122


@cython.cclass
class Frame:
    """A call in progress.

    Attributes:
        back: The line that it goes back to: source, offset and number.
        label: Of the subroutine called.
        numbers, named: Local parameters of the caller, put back at the end; those by number are an array.
        values: Array of numbered parameters that each time begins with; None where those of the caller go on.
        again: Where a program called by its number begins, and how often it is still to run after this time; None for a subroutine.
        doing: Labels of DO loops under way, or None.
        left: Rounds left of REPEAT loops, by label, or None.
        saved, restore: Modal state that M70 or M73 kept here; whether the end of the call brings it back.
        modal: Whether G66 called it.
    """

    back = cython.declare(object, visibility="public")
    label = cython.declare(object, visibility="public")
    numbers = cython.declare(object, visibility="public")
    named = cython.declare(dict, visibility="public")
    values = cython.declare(object, visibility="public")
    again = cython.declare(object, visibility="public")
    doing = cython.declare(set, visibility="public")
    left = cython.declare(dict, visibility="public")
    saved = cython.declare(object, visibility="public")
    restore = cython.declare(cython.bint, visibility="public")
    modal = cython.declare(cython.bint, visibility="public")

    def __init__(self, back, label, numbers, named, values):
        self.back = back
        self.label = label
        self.numbers = numbers
        self.named = named
        self.values = values
        self.again = self.saved = self.doing = self.left = None
        self.restore = self.modal = False

    def __reduce__(self):
        """Return all that a call holds: whoever looks for a state that comes back compares what is pickled."""
        begun = (self.back, self.label, self.numbers, self.named, self.values)
        return Frame, begun, (self.again, self.doing, self.left, self.saved, self.restore, self.modal)

    @cython.ccall
    def repeats(self, label) -> cython.bint:
        """Tell whether REPEAT of a label goes round, so that its count is not asked for."""
        return self.left is not None and label in self.left

    @cython.ccall
    def lead(self, keyword: cython.longlong, label, value: cython.double) -> cython.int:
        """Return where an O-word of a branch or loop leads, and keep which loops go round.

        It leads on (`STAY`), or to or behind the O-word of its label that it looks for below or above (`AT_NEXT` …).

        A REPEAT that is met while it goes round, as CONTINUE of a loop around had left it, counts as the end of that round (seen on
        LinuxCNC's interpreter).

        Args:
            keyword: As in `gcode_marks.KEYWORDS`.
            label: Its label.
            value: The value of its condition, or the whole count of REPEAT; 0 where it has none.
        """
        rounds: cython.longlong
        if keyword == _IF:
            return _STAY if value != 0.0 else _PAST_NEXT
        if keyword == _WHILE:
            if self.doing is None or label not in self.doing:
                return _STAY if value != 0.0 else _PAST_NEXT
            if value != 0.0:
                return _PAST_PREVIOUS
            self.doing.discard(label)
        elif keyword == _ELSE or keyword == _ELSEIF:
            return _PAST_NEXT
        elif keyword == _ENDWHILE:
            return _AT_PREVIOUS
        elif keyword == _CONTINUE:
            return _AT_NEXT
        elif keyword == _DO:
            if self.doing is None:
                self.doing = set()
            self.doing.add(label)
        elif keyword == _REPEAT or keyword == _ENDREPEAT:
            rounds = self.left[label] - 1 if self.repeats(label) else cython.cast(cython.longlong, value)
            if rounds > 0:
                self.left = self.left or {}
                self.left[label] = rounds
            elif self.left is not None:
                self.left.pop(label, None)
            if (rounds > 0) != (keyword == _REPEAT):
                return _PAST_NEXT if keyword == _REPEAT else _PAST_PREVIOUS
        elif keyword == _BREAK:
            if self.doing is not None:
                self.doing.discard(label)
            if self.left is not None:
                self.left.pop(label, None)
            return _PAST_NEXT
        return _STAY


@cython.cclass
class Computer:
    """A place in a text, and the columns that its lines go to. O-words are followed once `follow` has given their rows.

    Args:
        data: The text, bytes or a map of a file; `text` is the same as a buffer.
        numbers: Numbered parameters by number, an array of doubles, read and set.
        named: Global parameters by name, read and set.
        reserved: Names that cannot be set.
        block_line, block_offset, block_flags, word_end, letters, values: The columns of `gcode_scan.scan`.

    Attributes:
        blocks: How many blocks stand in the columns; whoever takes them sets it to 0.
        line: Number of the first line not read.
        lines, units: How many lines the last run read, and units of work that its calls were beside them.
        meets: Whether the last run ended at an O-word of a text whose rows are not given.
        back: The O-word, by offset and line, whose jump back ended the last run, or None; `away`, where it led to in another text.
        reached, reached_line: The first line that was never reached outside of calls.
        since: Lines read since that line, or since whoever looks set it to 0.
    """

    data = cython.declare(object)
    text: cython.const[cython.uchar][::1]
    block_line: cython.longlong[::1]
    block_offset: cython.longlong[::1]
    block_flags: cython.uchar[::1]
    word_end: cython.longlong[::1]
    letters: cython.uchar[::1]
    values: cython.double[::1]
    store = cython.declare(object)
    numbers: cython.double[::1]
    named = cython.declare(dict)
    local = cython.declare(dict)
    reserved = cython.declare(frozenset)
    names = cython.declare(dict)
    blocks = cython.declare(cython.Py_ssize_t, visibility="public")
    line = cython.declare(cython.longlong, visibility="public")
    i = cython.declare(cython.Py_ssize_t)
    depth = cython.declare(cython.int)
    certain = cython.declare(cython.bint)
    name = cython.declare(object)
    everywhere = cython.declare(cython.bint)
    settings = cython.declare(list)
    lines = cython.declare(cython.Py_ssize_t, visibility="public")
    units = cython.declare(cython.Py_ssize_t, visibility="public")
    meets = cython.declare(cython.bint, visibility="public")
    back = cython.declare(object, visibility="public")
    away = cython.declare(object, visibility="public")
    reached = cython.declare(cython.Py_ssize_t, visibility="public")
    reached_line = cython.declare(cython.longlong, visibility="public")
    since = cython.declare(cython.Py_ssize_t, visibility="public")
    parameters = cython.declare(object)
    frames = cython.declare(list)
    outermost = cython.declare(object)
    deepest = cython.declare(cython.Py_ssize_t)
    source = cython.declare(object)
    rows: cython.longlong[:, ::1]
    labels = cython.declare(list)
    count = cython.declare(cython.Py_ssize_t)
    row = cython.declare(cython.Py_ssize_t)
    next = cython.declare(cython.Py_ssize_t)
    next_line = cython.declare(cython.longlong)

    def __init__(self, data, text, numbers, named, reserved, columns):
        self.data = data
        self.text = text
        self.store = self.numbers = numbers
        self.named = named
        self.local = {}
        self.reserved = reserved
        self.names = {}
        self.block_line, self.block_offset, self.block_flags = columns[:3]
        self.word_end, self.letters, self.values = columns[3:]
        self.blocks = 0
        self.line = 1
        self.i = 0
        self.depth = 0
        self.certain = True
        self.name = None
        self.everywhere = False
        self.settings = []
        self.frames = []
        self.reached = self.reached_line = self.since = 0
        self.labels = []
        self.count = self.row = self.next = self.next_line = 0

    def follow(self, marks, parameters, frames, outermost, deepest, source):
        """Follow O-words from now on.

        Args:
            marks: `gcode_marks.Marks` of the text.
            parameters: Whose `local` are the named parameters of the call in progress.
            frames, outermost: The calls in progress, the innermost last, and the record of the main program below them.
            deepest: How many calls may be in progress.
            source: Number of the text.
        """
        self.rows, self.count, self.labels = marks.rows, marks.count, marks.labels
        self.parameters, self.frames, self.outermost = parameters, frames, outermost
        self.deepest, self.source = deepest, source

    def run(self, offset: cython.Py_ssize_t, line: cython.longlong, local: dict) -> cython.Py_ssize_t:
        """Read lines from `offset` on until one is not certain, a column is full, or the text ends.

        Settings are done, blocks go to the columns, behind those that stand there. `local` are the named parameters of the
        subroutine in force. When `since` is `PAUSE`, the next jump back ends the run. Returns the offset of the first line not read.
        """
        c: cython.int
        flags: cython.int
        top: cython.bint
        words: cython.Py_ssize_t = self.word_end[self.blocks - 1] if self.blocks > 0 else 0
        self.local = local
        self.lines = self.units = 0
        self.meets = False
        self.back = self.away = None
        while offset < self.text.shape[0] and self.blocks < self.block_line.shape[0]:
            self.i = offset
            self.certain = True
            self.depth = 0
            flags = 0
            top = len(self.frames) == 0
            c = self._byte()
            if c | 32 == 110:
                self._line_number()
                flags = _NUMBERED
                c = self._byte()
            if c | 32 == 111 and self.certain:
                self.meets = self.count == 0
                if not self._flow(offset, line):
                    break
                self.lines += 1
                if top and self.rows[self.row, _AFTER] > self.reached:
                    self.reached, self.reached_line = self.rows[self.row, _AFTER], line + 1
                    self.since = -self.lines
                if self.away is not None:
                    break
                if self.next <= offset and self.since + self.lines >= _PAUSE:
                    self.back = (offset, line)
                offset, line = self.next, self.next_line
            else:
                words = self._line(words, offset, line, flags)
                if not self.certain:
                    break
                self.lines += 1
                offset = self.i + 1
                line += 1
            if offset > self.reached and len(self.frames) == 0:
                self.reached, self.reached_line = offset, line
                self.since = -self.lines
            if self.back is not None:
                break
        self.since += self.lines
        self.line = line
        return offset

    def o_word(self, offset: cython.Py_ssize_t, local: dict):
        """Return label, keyword, values and end of the line at `offset` where it holds an O-word and is certain, else None.

        A label is the float of a number, or a name.
        """
        self.local = local
        self.i = offset
        self.certain = True
        self.depth = 0
        begin: cython.Py_ssize_t
        if self._byte() | 32 == 110:
            self._line_number()
        if not self.certain or self._byte() | 32 != 111:
            return None
        self.i += 1
        label = self._label()
        self._byte()
        begin = self.i
        while self.i < self.text.shape[0] and _is_letter(self.text[self.i]):
            self.i += 1
        if not self.certain or self.i == begin:
            return None
        keyword = self.data[begin : self.i].lower().decode("ascii")
        arguments = []
        while self.certain and self._byte() == 91:
            arguments.append(self._bracket())
        self._remarks()
        if not self.certain or self._byte() != 10:
            return None
        return label, keyword, arguments, self.i

    # Text.

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _byte(self) -> cython.int:
        """Go on to the next byte that is not blank and return it; a newline at the end of the text."""
        c: cython.int
        while self.i < self.text.shape[0]:
            c = cython.cast(cython.int, self.text[self.i])
            if c != 32 and c != 9 and c != 13:
                return c
            self.i += 1
        return 10

    @cython.cfunc
    @cython.exceptval(check=False)
    def _line_number(self) -> cython.void:
        """Go past an N word, whose number begins with a digit."""
        self.i += 1
        if 48 <= self._byte() <= 57:
            self._number()
        else:
            self.certain = False

    @cython.cfunc
    @cython.exceptval(check=False)
    def _take(self, c: cython.int) -> cython.void:
        """Go past a byte that must stand here."""
        if self._byte() == c:
            self.i += 1
        else:
            self.certain = False

    @cython.cfunc
    @cython.exceptval(check=False)
    def _remarks(self) -> cython.int:
        """Go past comments that do nothing; return the flag of a block that has one."""
        flags: cython.int = 0
        begin: cython.Py_ssize_t
        c: cython.int = self._byte()
        while self.certain and (c == 40 or c == 59):
            flags = _COMMENT
            self.i += 1
            if c == 59:
                while self.i < self.text.shape[0] and self.text[self.i] != 10:
                    self.i += 1
            else:
                # A keyword and a comma do something, and (LOGCLOSE).
                self._byte()
                begin = self.i
                while self.i < self.text.shape[0] and _is_letter(self.text[self.i]):
                    self.i += 1
                if (self.i > begin and self._byte() == 44) or self.i - begin == 8:
                    self.certain = False
                while self.i < self.text.shape[0] and self._is_remark(self.text[self.i]):
                    self.i += 1
                self._take(41)
            c = self._byte()
        return flags

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _is_remark(self, c: cython.int) -> cython.bint:
        """Tell whether a byte may stand in a comment that is read here."""
        return c != 40 and c != 41 and c != 10 and c < 128

    @cython.cfunc
    def _line(
        self,
        first: cython.Py_ssize_t,
        offset: cython.Py_ssize_t,
        line: cython.longlong,
        flags: cython.int,
    ) -> cython.Py_ssize_t:
        """Read the line here, its words into the columns from `first` on; return where the next block's words go."""
        words: cython.Py_ssize_t = first
        given: cython.uint = 0
        bit: cython.uint
        value: cython.double
        c: cython.int
        if self.settings:
            self.settings.clear()
        while self.certain:
            c = self._byte()
            if _is_letter(c):
                self.i += 1
                bit = cython.cast(cython.uint, 1) << ((c | 32) - 97)
                value = self._signed()
                if not self._is_word(c | 32, bit & given, bit, value) or words >= self.letters.shape[0]:
                    self.certain = False
                    break
                given |= bit & ~_CODES
                self.letters[words] = c | 32
                self.values[words] = value
                words += 1
            elif c == 10:
                break
            elif c == 35:
                self.i += 1
                self._setting()
            elif c == 40 or c == 59:
                flags |= self._remarks()
            else:
                self.certain = False
        if not self.certain:
            return first
        self._set()
        if words > first or flags & _COMMENT:
            self.block_line[self.blocks] = line
            self.block_offset[self.blocks] = offset
            self.block_flags[self.blocks] = flags
            self.word_end[self.blocks] = words
            self.blocks += 1
        return words

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _is_word(
        self, letter: cython.int, twice: cython.uint, bit: cython.uint, value: cython.double
    ) -> cython.bint:
        """Tell whether a word is taken: a letter that no machine's table hangs on, once, its value in range."""
        if not bit & _LETTERS or twice or not -_LARGEST <= value <= _LARGEST:
            return False
        if letter == 103:
            return (
                0.0 <= value < 100.0
                and value == floor(value)
                and _G_TAKEN[cython.cast(cython.int, value)] != 0
            )
        if letter == 109:
            return (
                0.0 <= value < 10.0
                and value == floor(value)
                and _M_TAKEN[cython.cast(cython.int, value)] != 0
            )
        return True

    # O-words.

    @cython.cfunc
    def _flow(self, offset: cython.Py_ssize_t, line: cython.longlong) -> cython.bint:
        """Follow the O-word of the line at `offset` to the next line; tell whether it is certain where that is.

        `flow.o_words` defines the O-words; here they are followed by the rows that they lead to.
        """
        keyword: cython.longlong
        target: cython.longlong
        value: cython.double = 0.0
        given: cython.bint
        way: cython.int
        m: cython.Py_ssize_t = self._row_of(offset)
        if m < 0:
            return False
        self.row = m
        keyword, target = self.rows[m, _KEYWORD], self.rows[m, _TARGET]
        if target < 0 and not (keyword == _WHILE and self.rows[m, _OTHER] >= 0):
            return False
        self.i = self.rows[m, _ARGUMENTS]
        if keyword == _CALL:
            return self._call(m, line)
        if keyword == _ENDSUB or keyword == _RETURN:
            return self._leave(m, keyword == _RETURN)
        given = self._byte() == 91
        if given:
            value = self._bracket()
        if not self._ends() or given != (
            keyword == _IF or keyword == _ELSEIF or keyword == _WHILE or keyword == _REPEAT
        ):
            return False
        if keyword == _SUB:
            self._behind(target, self.rows[target, _LINE])
            return True
        frame: Frame = self.frames[len(self.frames) - 1] if self.frames else self.outermost
        label = self.labels[self.rows[m, _LABEL]]
        if keyword == _WHILE:
            # The foot of a loop that DO began, or the head of one.
            if frame.doing is not None and label in frame.doing:
                target = self.rows[m, _OTHER]
            elif self.rows[m, _OTHER] >= 0:
                return False
            if target < 0:
                return False
        elif keyword == _REPEAT and not frame.repeats(label):
            if value != floor(value) or not fabs(value) <= _LARGEST:
                return False
        way = frame.lead(keyword, label, value)
        if way == _STAY:
            self._behind(m, line)
            return True
        if keyword == _IF:
            return self._branch(target)
        if way == _AT_NEXT or way == _AT_PREVIOUS:
            self._at(target)
        else:
            self._behind(target, self.rows[target, _LINE])
        return True

    @cython.cfunc
    def _branch(self, target: cython.longlong) -> cython.bint:
        """Go into the first branch behind an IF that does not hold whose condition does."""
        value: cython.double
        while self.rows[target, _KEYWORD] == _ELSEIF:
            self.i = self.rows[target, _ARGUMENTS]
            if self._byte() != 91:
                return False
            value = self._bracket()
            if not self._ends():
                return False
            if value != 0.0:
                break
            target = self.rows[target, _OTHER]
            if target < 0:
                return False
        self._behind(target, self.rows[target, _LINE])
        return True

    @cython.cfunc
    def _call(self, m: cython.Py_ssize_t, line: cython.longlong) -> cython.bint:
        """Begin a call of a subroutine of this text."""
        target: cython.longlong = self.rows[m, _TARGET]
        given: cython.Py_ssize_t = 0
        k: cython.Py_ssize_t
        argument = cython.declare(cython.double[30])
        while self.certain and self._byte() == 91:
            if given == _LOCALS:
                return False
            argument[given] = self._bracket()
            given += 1
        if not self._ends() or len(self.frames) >= self.deepest:
            return False
        callers = self.store[1 : _LOCALS + 1]
        label = self.labels[self.rows[m, _LABEL]]
        back = (self.source, self.rows[m, _AFTER], line + 1)
        # It runs once, so its first condition is not asked for again.
        self.frames.append(Frame(back, label, callers, self.local, callers))
        for k in range(_LOCALS):
            self.numbers[k + 1] = argument[k] if k < given else 0.0
        self.parameters.local = self.local = {}
        self.units += _CALL_UNITS
        self._behind(target, self.rows[target, _LINE])
        return True

    @cython.cfunc
    def _leave(self, m: cython.Py_ssize_t, anywhere: cython.bint) -> cython.bint:
        """End the innermost call, where nothing but its caller's parameters is to be put back."""
        value: cython.double = 0.0
        given: cython.bint = self._byte() == 91
        if given:
            value = self._bracket()
        if not self._ends() or not self.frames:
            return False
        frame: Frame = self.frames[len(self.frames) - 1]
        if frame.again is not None or frame.restore or frame.values is None:
            return False
        if not anywhere and frame.label != self.labels[self.rows[m, _LABEL]]:
            return False
        self.frames.pop()
        self.store[1 : _LOCALS + 1] = frame.numbers
        self.parameters.local = self.local = frame.named
        self.named["_value"] = value
        self.named["_value_returned"] = 1.0 if given else 0.0
        back = frame.back
        if back[0] == self.source:
            self.next, self.next_line = back[1], back[2]
        else:
            self.away = back
        return True

    @cython.cfunc
    @cython.exceptval(check=False)
    def _row_of(self, offset: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Return the row of the O-word of the line at `offset`, -1 where it has none: mostly the one behind the last."""
        low: cython.Py_ssize_t = self.row + 1
        high: cython.Py_ssize_t = self.count
        middle: cython.Py_ssize_t
        if low < high and self.rows[low, _OFFSET] == offset:
            return low
        low = 0
        while low < high:
            middle = (low + high) // 2
            if self.rows[middle, _OFFSET] < offset:
                low = middle + 1
            else:
                high = middle
        return low if low < self.count and self.rows[low, _OFFSET] == offset else -1

    @cython.cfunc
    @cython.exceptval(check=False)
    def _ends(self) -> cython.bint:
        """Tell whether nothing but comments stands in the rest of the line."""
        self._remarks()
        return self.certain and self._byte() == 10

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _at(self, m: cython.longlong) -> cython.void:
        """Go on at the line of a row."""
        self.next, self.next_line = self.rows[m, _OFFSET], self.rows[m, _LINE]

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _behind(self, m: cython.longlong, line: cython.longlong) -> cython.void:
        """Go on behind the line of a row."""
        self.next, self.next_line = self.rows[m, _AFTER], line + 1

    # Parameters.

    @cython.cfunc
    def _read_name(self) -> cython.void:
        """Read the rest of ``<name>`` into `name`: lower case, without blanks; and whether it is global."""
        begin: cython.Py_ssize_t
        self.everywhere = self._byte() == 95
        begin = self.i
        while self.i < self.text.shape[0] and self.text[self.i] != 62 and self.text[self.i] != 10:
            self.i += 1
        key: bytes = self.data[begin : self.i]
        self._take(62)
        name = self.names.get(key)
        if name is None and self.certain:
            self.certain = key.isascii() and b"(" not in key and b";" not in key
            if self.certain:
                name = self.names[key] = key.translate(None, b" \t\r").lower().decode("ascii")
        self.name = name

    @cython.cfunc
    def _label(self):
        """Read the label of an O-word."""
        c: cython.int = self._byte()
        if c == 60:
            self.i += 1
            self._read_name()
            name = self.name
            if self.certain and name.isdecimal():
                return float(name)
            return name
        label: cython.double = self._number() if 48 <= c <= 57 else self._value()
        if label != floor(label) or not fabs(label) < _LARGEST:
            self.certain = False
        return label

    @cython.cfunc
    @cython.exceptval(check=False)
    def _index(self) -> cython.int:
        """Read the number of a parameter behind its #; -1 unless it is plain storage."""
        value: cython.double
        whole: cython.double
        c: cython.int = self._byte()
        if not (c == 35 or c == 91 or c == 46 or 48 <= c <= 57):
            self.certain = False
            return -1
        value = self._value()
        whole = floor(value + 0.5)
        if not self.certain or fabs(value - whole) > _WHOLE or not 0.0 < whole < _STORED:
            self.certain = False
            return -1
        return cython.cast(cython.int, whole)

    @cython.cfunc
    def _parameter(self) -> cython.double:
        """Read a parameter behind its # and return its value."""
        index: cython.int
        if self._byte() != 60:
            index = self._index()
            return self.numbers[index] if self.certain else 0.0
        self.i += 1
        self._read_name()
        if not self.certain:
            return 0.0
        # Parameters that tell the machine's state are not stored, so they are not found.
        stored: dict = self.named if self.everywhere else self.local
        value = stored.get(self.name)
        if value is None:
            self.certain = False
            return 0.0
        return value

    @cython.cfunc
    def _setting(self) -> cython.void:
        """Read a setting behind its #; it is done at the end of the line."""
        target: object
        value: cython.double
        if self._byte() == 60:
            self.i += 1
            self._read_name()
            target = self.name
            if self.certain and target in self.reserved:
                self.certain = False
        else:
            target = self._index()
        if self.certain:
            self._take(61)
        if self.certain:
            value = self._signed()
            self.settings.append((target, value))

    @cython.cfunc
    def _set(self) -> cython.void:
        """Do the settings of the line."""
        for target, value in self.settings:
            if isinstance(target, str):
                (self.named if target.startswith("_") else self.local)[target] = value
            else:
                self.numbers[target] = value

    # Values.

    @cython.cfunc
    def _signed(self) -> cython.double:
        """Read a value behind any number of signs."""
        negative: cython.bint = False
        value: cython.double
        c: cython.int = self._byte()
        while c == 43 or c == 45:
            if c == 45:
                negative = not negative
            self.i += 1
            c = self._byte()
        value = self._value()
        return -value if negative else value

    @cython.cfunc
    def _value(self) -> cython.double:
        """Read a number, parameter, function or expression in brackets."""
        c: cython.int = self._byte()
        value: cython.double = 0.0
        if 48 <= c <= 57 or c == 46:
            return self._number()
        self.depth += 1
        if self.depth > _DEPTH:
            self.certain = False
        elif c == 35:
            self.i += 1
            value = self._parameter()
        elif c == 91:
            value = self._bracket()
        elif _is_letter(c):
            value = self._function()
        else:
            self.certain = False
        self.depth -= 1
        return value

    @cython.cfunc
    @cython.exceptval(check=False)
    def _number(self) -> cython.double:
        """Read digits with at most one point, and no blank among them."""
        mantissa: cython.longlong = 0
        digits: cython.int = 0
        scale: cython.double = 1.0
        dotted: cython.bint = False
        c: cython.int = self._byte()
        while 48 <= c <= 57 or (c == 46 and not dotted):
            if c == 46:
                dotted = True
            else:
                mantissa = mantissa * 10 + (c - 48)
                digits += 1
                if digits > _DIGITS:
                    break
                if dotted:
                    scale *= 10.0
            self.i += 1
            c = cython.cast(cython.int, self.text[self.i]) if self.i < self.text.shape[0] else 10
        if c == 32 or c == 9:
            c = self._byte()
        if digits == 0 or digits > _DIGITS or 48 <= c <= 57 or c == 46:
            self.certain = False
        # Both are doubles without error, so that the quotient is rounded once.
        return cython.cast(cython.double, mantissa) / scale

    @cython.cfunc
    def _bracket(self) -> cython.double:
        """Read an expression in brackets."""
        value: cython.double
        self._take(91)
        value = self._expression(_LOGIC)
        self._take(93)
        return value

    @cython.cfunc
    def _expression(self, level: cython.int) -> cython.double:
        """Read operands and operators that bind at least so tight, from the left."""
        value: cython.double = self._signed()
        other: cython.double
        operator: cython.int = self._operator()
        while self.certain and operator >> 8 >= level:
            self.i += operator >> 4 & 15
            other = self._expression((operator >> 8) + 1)
            value = joined(operator, value, other)
            if value != value:
                self.certain = False
            operator = self._operator()
        return value

    @cython.cfunc
    @cython.exceptval(check=False)
    def _operator(self) -> cython.int:
        """Return the operator that stands here, 0 where none does (`gcode_arithmetic.operator_at`)."""
        c: cython.int = self._byte()
        i: cython.Py_ssize_t = self.i
        length: cython.Py_ssize_t = self.text.shape[0]
        if c == 10 or c == 93:
            return 0
        return operator_at(
            c,
            cython.cast(cython.int, self.text[i + 1]) if i + 1 < length else 10,
            cython.cast(cython.int, self.text[i + 2]) if i + 2 < length else 10,
        )

    @cython.cfunc
    def _function(self) -> cython.double:
        """Read a function and its argument."""
        name: cython.uint = 0
        letters: cython.int = 0
        value: cython.double
        c: cython.int = self._byte()
        while _is_letter(c) and letters < _LONGEST:
            name = (name << 5) | (c & 31)
            letters += 1
            self.i += 1
            c = cython.cast(cython.int, self.text[self.i]) if self.i < self.text.shape[0] else 10
        value = self._bracket()
        if not self.certain:
            return 0.0
        if name == _ATAN:
            self._take(47)
            return arc_tangent(value, self._bracket())
        value = function_of(name, value)
        if not isfinite(value):
            self.certain = False
        return value
