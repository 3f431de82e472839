"""Read lines of G-code by the tables of their grammar (``grammars/lalr.py``) into small programs for `gcode_run`.

One pass over the bytes of a line: a DFA finds the tokens that the parser's state allows, the LALR automaton shifts and reduces
them, and each rule's action (`gcode_codes.ACTIONS`) writes instructions to `Parser.code`. Nothing is judged: where the grammar has no
token the line is refused, and the place and the parser's stack show the expected tokens.

    NUMBER k       push constant k of the line       WORD letter     pop a value: a word of the block
    STORED k       push the numbered parameter k     SET             pop value and number: a parameter is to be set
    PARAMETER      pop a number, push its parameter  SET_NAMED       the same, of a name
    NAME k         push k, the number of a name      COMMENT, MESSAGE    followed by its place in the line and its length
    NAMED k        push the named parameter          THEN            pop a value: 0 ends the line
    EXISTS, EXISTS_NAMED                             FLOW keyword    jump, loop or call with so many values (and the label)
    NEGATIVE, BINARY operator, FUNCTION name         END
    ARC_TANGENT, SLOPE, INCREMENTS

An instruction is one number, ``operation + 256 * operand``. FLOW is followed by the count of its values.
"""

from mmap import mmap

import cython

from cncgen.kernels.gcode_codes import (
    ARGUMENTS,
    CODE_NUMBERS,
    COMPUTED,
    LITERALS,
    MAX_LINE,
    MOST,
    OPERATIONS,
    REFUSED,
)

if cython.compiled:
    from cython.cimports.cncgen.kernels.gcode_shapes import Shapes
else:
    from cncgen.kernels.gcode_shapes import Shapes

_END = cython.declare(cython.int, OPERATIONS["END"])
_NUMBER = cython.declare(cython.int, OPERATIONS["NUMBER"])
_WORD = cython.declare(cython.int, OPERATIONS["WORD"])
_STORED = cython.declare(cython.int, OPERATIONS["STORED"])
_BINARY = cython.declare(cython.int, OPERATIONS["BINARY"])
_SET = cython.declare(cython.int, OPERATIONS["SET"])
_PARAMETER = cython.declare(cython.int, OPERATIONS["PARAMETER"])
_NAMED = cython.declare(cython.int, OPERATIONS["NAMED"])
_NAME = cython.declare(cython.int, OPERATIONS["NAME"])
_SET_NAMED = cython.declare(cython.int, OPERATIONS["SET_NAMED"])
_NEGATIVE = cython.declare(cython.int, OPERATIONS["NEGATIVE"])
_FUNCTION = cython.declare(cython.int, OPERATIONS["FUNCTION"])
_ARC_TANGENT = cython.declare(cython.int, OPERATIONS["ARC_TANGENT"])
_SLOPE = cython.declare(cython.int, OPERATIONS["SLOPE"])
_EXISTS = cython.declare(cython.int, OPERATIONS["EXISTS"])
_EXISTS_NAMED = cython.declare(cython.int, OPERATIONS["EXISTS_NAMED"])
_COMMENT = cython.declare(cython.int, OPERATIONS["COMMENT"])
_MESSAGE = cython.declare(cython.int, OPERATIONS["MESSAGE"])
_FLOW = cython.declare(cython.int, OPERATIONS["FLOW"])
_THEN = cython.declare(cython.int, OPERATIONS["THEN"])
_INCREMENTS = cython.declare(cython.int, OPERATIONS["INCREMENTS"])
_OUTPUT = cython.declare(cython.int, OPERATIONS["OUTPUT"])

#: Keywords and operators that actions name.
_MINUS = cython.declare(cython.int, LITERALS["-"])
_POWER = cython.declare(cython.int, LITERALS["**"])
_CALL = cython.declare(cython.int, LITERALS["call"])
_COMPUTED = cython.declare(cython.uint, COMPUTED)
_CODE_NUMBERS = cython.declare(cython.int, CODE_NUMBERS)
_ARGUMENTS = cython.declare(cython.int, ARGUMENTS)
#: Bits of words, of axes, and of X and Y.
_WORDS = cython.declare(cython.ulonglong, (1 << 32) - 1)
_AXES = cython.declare(cython.ulonglong, sum(1 << (ord(letter) - 97) for letter in "xyzabcuvw"))
_POLAR = cython.declare(cython.uint, 1 << 23 | 1 << 24)
_PROGRAM = cython.declare(cython.int, LITERALS["program"])
_GOTO = cython.declare(cython.int, LITERALS["goto"])
_WHILE_DO = cython.declare(cython.int, LITERALS["while-do"])
_END_DO = cython.declare(cython.int, LITERALS["end-do"])
#: Number of BSPLINE of Siemens among the G codes (`cncgen.gcode.block`).
_BSPLINE = cython.declare(cython.double, 1060.0)

_POWERS = cython.declare(cython.double[23])
_DIGITS = cython.declare(cython.int, 18)
_EXACT = cython.declare(cython.ulonglong, 9007199254740992)
_DEPTH = cython.declare(cython.int, 70_000)
_MOST = cython.declare(cython.Py_ssize_t, MAX_LINE)
_REFUSED = cython.declare(cython.int, REFUSED)
_k: cython.int
for _k in range(23):
    _POWERS[_k] = 10.0**_k

#: Letters whose numbers without a decimal point count in least increments, as bits (A is bit 0).
_LENGTHS = cython.declare(cython.uint, sum(1 << (ord(letter) - 97) for letter in "xyzabcuvwijkqr"))


def _zeros(size):
    """Return a buffer; pages of it that are not filled take no time."""
    try:
        return memoryview(mmap(-1, size))
    except OSError as error:
        raise MemoryError from error


@cython.cfunc
def _fill(to: cython.short[::1], table) -> cython.void:
    """Copy a table of a generated module."""
    row: cython.const[cython.short][::1] = memoryview(table[1]).cast("h")
    k: cython.Py_ssize_t
    for k in range(row.shape[0]):
        to[k] = row[k]


@cython.cclass
class Parser:
    """The tables of a grammar, and the results of reading lines with them.

    Args:
        tables: A module of tables (``grammars/tables_*.py``).
        stored: Numbered parameters below this are plain storage.
        increments: Whether lengths without a decimal point count in least increments.

    Attributes:
        code, constants: Instructions, and the numbers that they push.
        used, numbers: How much of them is in use; whoever keeps a line begins the next one behind it. Those of a line are numbered
            from its first one on.
        names: Names of parameters and labels by their number, small letters without blanks.
        flags: `DELETED`, `NUMBERED`, of the line read last.
        line_number: Where its N word begins and ends.
        error: Offset where the grammar refused it, -1 where it did not.
        lines: How many lines were read.
    """

    action = cython.declare(cython.short[16_384])
    goto = cython.declare(cython.short[8_192])
    to = cython.declare(cython.short[512])
    lead = cython.declare(cython.short[32_768])
    again = cython.declare(cython.short[16_384])
    move = cython.declare(cython.short[32_768])
    token = cython.declare(cython.short[32_768])
    length = cython.declare(cython.short[256])
    origin = cython.declare(cython.short[256])
    made = cython.declare(cython.short[256])
    classes = cython.declare(cython.short[256])
    mode = cython.declare(cython.short[256])
    literal = cython.declare(cython.short[512])
    text: cython.const[cython.uchar][::1]
    rows: cython.longlong[:, ::1]
    code = cython.declare(cython.int[::1], visibility="public")
    constants = cython.declare(cython.double[::1], visibility="public")
    symbol: cython.int[::1]
    terminals = cython.declare(tuple, visibility="public")
    names = cython.declare(list, visibility="public")
    numbered = cython.declare(dict)
    start = cython.declare(cython.int)
    accept = cython.declare(cython.int)
    end = cython.declare(cython.int)
    delete = cython.declare(cython.int)
    line_word = cython.declare(cython.int)
    stored = cython.declare(cython.int)
    top = cython.declare(cython.int)
    depth = cython.declare(cython.int)
    increments = cython.declare(cython.bint)
    begin = cython.declare(cython.Py_ssize_t)
    first = cython.declare(cython.int)
    shapes = cython.declare(Shapes)
    shaped = cython.declare(cython.bint)
    alike = cython.declare(cython.bint)
    used = cython.declare(cython.int, visibility="public")
    numbers = cython.declare(cython.int, visibility="public")
    flags = cython.declare(cython.int, visibility="public")
    error = cython.declare(cython.Py_ssize_t, visibility="public")
    lines = cython.declare(cython.Py_ssize_t, visibility="public")
    number_begin = cython.declare(cython.Py_ssize_t, visibility="public")
    number_end = cython.declare(cython.Py_ssize_t, visibility="public")

    def __init__(self, tables, stored, increments=False):
        self._take_tables(tables)
        self.terminals = tables.TERMINALS
        self.start, self.accept = tables.START, tables.ACCEPT
        self.end = len(self.terminals) - 1
        self.delete = self.terminals.index("DELETE") if "DELETE" in self.terminals else -1
        self.line_word = self.terminals.index("LINE_NUMBER") if "LINE_NUMBER" in self.terminals else -1
        self.stored = stored
        self.increments = increments
        # Whether lines of one shape have one code.
        self.shaped = tables.SHAPED and not increments
        self.alike = False
        self.code = _zeros(4 << 20).cast("i")
        self.constants = _zeros(8 << 19).cast("d")
        self.symbol = _zeros(4 * 8 * _DEPTH).cast("i")
        self.names = []
        self.numbered = {}
        self.used = self.numbers = self.lines = 0
        self.error = -1

    @cython.cfunc
    def _take_tables(self, tables) -> cython.void:
        """Copy the tables of a generated module, which are within these bounds (``lalr.MOST``)."""
        if not cython.compiled:
            for name, most in MOST.items():
                setattr(self, name, [0] * most)
        _fill(self.action, tables.ACTION)
        _fill(self.goto, tables.GOTO)
        _fill(self.lead, tables.LEAD)
        _fill(self.again, tables.AGAIN)
        _fill(self.move, tables.MOVE)
        _fill(self.token, tables.TOKEN)
        _fill(self.to, tables.TO)
        _fill(self.length, tables.LENGTH)
        _fill(self.origin, tables.ORIGIN)
        _fill(self.made, tables.MADE)
        _fill(self.classes, tables.CLASSES)
        _fill(self.mode, tables.MODE)
        _fill(self.literal, tables.LITERAL)

    @cython.ccall
    @cython.exceptval(check=False)
    def room(self) -> cython.bint:
        """Tell whether another line has room for its code."""
        return self.used + 4 * _MOST < self.code.shape[0] and self.numbers + _MOST < self.constants.shape[0]

    def name(self, key: bytes) -> int:
        """Return the number of a name in its written form."""
        found = self.numbered.get(key)
        if found is None:
            text = key.translate(None, b" \t\r").lower()
            try:
                name = text.decode("utf-8")
            except UnicodeDecodeError:
                name = text.decode("cp1252", "replace")
            try:
                found = self.names.index(name)
            except ValueError:
                found = len(self.names)
                self.names.append(name)
            self.numbered[key] = found
        return found

    def expected(self) -> list:
        """Return the names of the terminals that could stand where the last line was refused."""
        found = []
        for terminal in range(len(self.terminals)):
            if self._fits(terminal):
                found.append(self.terminals[terminal])
        return found

    @cython.ccall
    @cython.exceptval(check=False)
    def cut(self) -> cython.Py_ssize_t:
        """Return the offset of the slash that the last line was refused for behind its words, not within brackets; else 0."""
        at: cython.Py_ssize_t
        inside: cython.Py_ssize_t = 0
        written: cython.bint = False
        if self.error < 0 or self.error >= self.text.shape[0] or self.text[self.error] != 47:
            return 0
        for at in range(self.begin, self.error):
            inside += (self.text[at] == 91) - (self.text[at] == 93)
            written = written or self.text[at] > 32
        return self.error if written and inside == 0 else 0

    def parse(self, text: cython.const[cython.uchar][::1], offset: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Read the line at `offset` of a text, its code into `code` from `used` on; return the offset of its end.

        `error` tells whether it is one of the grammar. Where it is, `used` and `numbers` stand behind its code.
        """
        self.text = text
        return self._parse(offset)

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _parse(self, offset: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Do the same with `text`."""
        at: cython.Py_ssize_t = offset
        # A line that is longer than any is refused there.
        size: cython.Py_ssize_t = min(self.text.shape[0], offset + _MOST)
        to: cython.Py_ssize_t
        taken: cython.Py_ssize_t
        first: cython.int = self.used
        c: cython.int
        d: cython.int
        mode: cython.int
        kind: cython.int
        literal: cython.int
        step: cython.int
        state: cython.int = self.start
        self.lines += 1
        self.begin = offset
        self.first = self.numbers
        self.top = 0
        self.error = -1
        self.flags = 0
        self.depth = 0
        self.symbol[0] = state
        while True:
            # Blanks before a token.
            while at < size and (self.text[at] == 32 or self.text[at] == 9 or self.text[at] == 13):
                at += 1
            if at >= size or self.text[at] == 10:
                if at == size and at < self.text.shape[0] and self.text[at] != 10:
                    break
                kind, taken, literal = self.end, at, 0
            else:
                d, to, taken = 0, at, at
                mode = self.mode[state] << 9
                while to < size:
                    c = self.text[to]
                    step = self.move[d << 6 | self.classes[c]]
                    if step < 0:
                        if c == 32 or c == 9 or c == 13:
                            to += 1
                            continue
                        break
                    d = step
                    to += 1
                    taken = to
                if self.token[mode | d] < 0:
                    # The longest token of this state is shorter than those of others: "/" before "[", say.
                    d, taken = self._shorter(at, taken, mode)
                    if d < 0:
                        break
                kind, literal = self.token[mode | d], self.literal[d]
                step = self.again[state << 6 | kind]
                if step == 12:
                    # A word behind a word.
                    self._plain_word(at, taken)
                    at = taken
                    continue
            step = self.action[state << 6 | kind]
            if step < 0:
                state = self._reduced(state, kind, step)
                step = self.action[state << 6 | kind]
            if kind == self.end:
                if state != self.accept:
                    break
                self._emit(_END, 0)
                return at
            if step == 0:
                break
            if kind == self.delete:
                self.flags |= 1
            elif kind == self.line_word:
                self.flags |= 2
                self.number_begin, self.number_end = at, taken
            state = step - 1
            self.top += 1
            self.symbol[self.top << 3] = state
            self._push(at, taken, literal)
            at = taken
        self.error = at
        self.used, self.numbers = first, self.first
        while at < self.text.shape[0] and self.text[at] != 10:
            at += 1
        return at

    @cython.cfunc
    @cython.inline
    @cython.exceptval(-1, check=False)
    def _reduced(self, state: cython.int, kind: cython.int, step: cython.int) -> cython.int:
        """Reduce, by `step` first, until a token can be shifted, is the accepted end, or is refused; return the state."""
        rule: cython.int
        count: cython.int
        while step < 0 and (kind != self.end or state != self.accept):
            rule = -step - 1
            count = self.length[rule]
            if self.made[rule] != 0:
                self._act(self.made[rule], count)
            self.top -= count
            step = self.goto[self.symbol[self.top << 3] << 5 | self.origin[rule]]
            self.top += 1
            if count == 0:
                self._push(self.begin, self.begin, 0)
            state = self.lead[step << 6 | kind]
            self.symbol[self.top << 3] = state
            step = self.action[state << 6 | kind]
        return state

    def take(self, text: cython.const[cython.uchar][::1], rows: cython.longlong[:, ::1]) -> None:
        """Take a text whose lines are to be kept, and their rows.

        A row has `ROW` columns: offset and number of the line, where its code begins, offset of the next line, the row of that (-1 for
        none yet), marks (`DELETED`, `NUMBERED`, `REFUSED`, `COMPUTED_LABEL`), what whoever runs them keeps (-1), and where its
        constants begin. Lines of one shape have their code in common.
        """
        self.text = text
        self.rows = rows
        self.shapes = Shapes()
        self.forget()

    @cython.ccall
    def forget(self):
        """Begin again with code, constants and shapes; rows that are kept are worth nothing from now on."""
        self.used = self.numbers = 0
        self.shapes.forget()

    def compile(
        self,
        offset: cython.Py_ssize_t,
        line: cython.longlong,
        first: cython.Py_ssize_t,
        last: cython.Py_ssize_t,
        end: cython.Py_ssize_t,
    ) -> cython.Py_ssize_t:
        """Keep lines from `offset` on, not beyond `end`, in rows from `first` to `last`, while there is room; return the next row."""
        r: cython.Py_ssize_t = first
        while r < last and offset < end and self.room():
            offset = self._keep(r, offset, line)
            self.rows[r, 4] = r + 1
            line += 1
            r += 1
        if r > first:
            self.rows[r - 1, 4] = -1
        return r

    def compile_o_words(
        self,
        offset: cython.Py_ssize_t,
        line: cython.longlong,
        first: cython.Py_ssize_t,
        last: cython.Py_ssize_t,
    ) -> tuple:
        """Keep lines that hold an O: O-words, refused ones and some others. Return the next row, the offset and line that come next."""
        at: cython.Py_ssize_t = offset
        size: cython.Py_ssize_t = self.text.shape[0]
        r: cython.Py_ssize_t = first
        while at < size and r < last and self.room():
            if self.text[at] == 10:
                offset = at + 1
                line += 1
            elif self.text[at] | 32 == 111:
                at = self._keep(r, offset, line) - 1
                offset = at + 1
                line += 1
                r += 1
            at += 1
        return r, (offset if at < size else size), line

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _keep(
        self, r: cython.Py_ssize_t, offset: cython.Py_ssize_t, line: cython.longlong
    ) -> cython.Py_ssize_t:
        """Keep a line in a row; return the offset of the next one."""
        first: cython.int = self.numbers
        code: cython.int = self.used
        end: cython.Py_ssize_t = self.shapes.read(self.text, offset) if self.shaped else -1
        shape: cython.Py_ssize_t = self.shapes.find() if end >= 0 else -1
        self.rows[r, 0], self.rows[r, 1], self.rows[r, 7] = offset, line, first
        self.rows[r, 4] = self.rows[r, 6] = -1
        if shape >= 0:
            self.rows[r, 2], self.rows[r, 5] = self.shapes.table[shape, 3], self.shapes.table[shape, 4]
            self.numbers += self.shapes.put(shape, self.constants, first)
        else:
            self.alike = end >= 0
            end = self._parse(offset)
            self.rows[r, 2], self.rows[r, 5] = code, self.flags | (_REFUSED if self.error >= 0 else 0)
            if self.alike and self.error < 0:
                self.shapes.keep(code, self.flags, self.constants, first, self.numbers)
        self.rows[r, 3] = end + 1
        return end + 1

    def named(
        self,
        text: cython.const[cython.uchar][::1],
        first: cython.int[::1],
        calls: cython.const[cython.uchar][::1],
        slashes: cython.bint,
    ) -> tuple:
        """Read all lines of a text and return the names in their words; lines that the grammar refuses give none.

        Args:
            text: The program.
            first: Of length ``4 * CODE_NUMBERS``, zeros: filled with the line on which each code stands first, and in its second
                half with that on which it stands first in a block that names no axis.
            calls: Of half the length: of a code that calls a program, the letter (small) whose number names it, with `ARGUMENTS`
                where the block has its arguments; else 0.
            slashes: Whether blocks end at a slash within them (`cut`).

        Returns:
            Letters of words as bits from A at bit 0 (``@`` and ``^`` are X and Y), with `COMPUTED`; the line of the first call,
            0 without one; and the numbers and names of the programs that are called.
        """
        at: cython.Py_ssize_t = 0
        begin: cython.Py_ssize_t
        cut: cython.Py_ssize_t
        line: cython.int = 0
        first_call: cython.int = 0
        call: cython.int
        found: cython.ulonglong = 0
        bits: cython.ulonglong
        programs: set = set()
        self.text = text
        while at < text.shape[0]:
            line += 1
            self.used = self.numbers = 0
            begin = at
            at = self._parse(at) + 1
            cut = self.cut() if slashes else 0
            if cut > 0:
                self.text = text[begin:cut]
                self._parse(0)
                self.text = text
            if self.error >= 0:
                continue
            bits = self._words_named(first, calls, line)
            call = bits >> 32
            bits &= _WORDS
            if bits & _AXES == 0:
                self._words_named(first[2 * _CODE_NUMBERS :], calls, line)
            if call < _ARGUMENTS:
                found |= bits
            if call:
                first_call = first_call if first_call else line
                self._program_called(call % _ARGUMENTS, programs)
        return found, first_call, programs

    @cython.cfunc
    @cython.exceptval(check=False)
    def _words_named(
        self, first: cython.int[::1], calls: cython.const[cython.uchar][::1], line: cython.int
    ) -> cython.ulonglong:
        """Return the letters of the line just read, as bits, and from bit 32 on what `calls` says of its code: 1 for an O-word."""
        at: cython.int = 0
        literal: cython.bint = False
        call: cython.ulonglong = 0
        bits: cython.uint = 0
        place: cython.int
        operation: cython.int
        operand: cython.int
        while self.code[at] != 0:
            operation, operand = self.code[at] & 255, self.code[at] >> 8
            if operation == _WORD and (operand == 103 or operand == 109):
                place = self._place(at, operand) if literal else -2
                if place == -2:
                    bits |= _COMPUTED
                elif place >= 0:
                    first[place] = first[place] if first[place] else line
                    call = calls[place] if calls[place] else call
            elif operation == _WORD and (operand == 64 or operand == 94):
                bits |= _POLAR
            elif operation == _WORD and 97 <= operand <= 122:
                bits |= cython.cast(cython.uint, 1) << (operand - 97)
            elif operation == _FLOW and operand == _CALL:
                call = 1
            literal = operation == _NUMBER
            at += 1 if operation < _COMMENT or operation == _THEN or operation == _INCREMENTS else 2
        return bits | call << 32

    @cython.cfunc
    @cython.exceptval(check=False)
    def _place(self, at: cython.int, letter: cython.int) -> cython.int:
        """Return where the code whose word is the instruction `at` stands among `CODE_NUMBERS`; -1 if no code has its number."""
        tenths: cython.double = 10.0 * self.constants[self.code[at - 1] >> 8] + 0.5
        if not 0.0 <= tenths < _CODE_NUMBERS:
            return -1
        return cython.cast(cython.int, tenths) + (_CODE_NUMBERS if letter == 109 else 0)

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _program_called(self, letter: cython.int, programs: set) -> cython.int:
        """Add the number or name of the program that the line just read calls, unless it is computed."""
        at: cython.int = 0
        if letter == 1:
            if self.code[0] & 255 == _NAME:
                programs.add(self.names[self.code[0] >> 8])
            elif self.code[0] & 255 == _NUMBER:
                programs.add(self.constants[self.code[0] >> 8])
            return 0
        while self.code[at] != 0:
            if self.code[at] == _WORD + 256 * letter and at > 0 and self.code[at - 1] & 255 == _NUMBER:
                programs.add(self.constants[self.code[at - 1] >> 8])
            at += 1
        return 0

    # The automaton.

    @cython.cfunc
    def _shorter(
        self, at: cython.Py_ssize_t, end: cython.Py_ssize_t, mode: cython.int
    ) -> tuple[cython.int, cython.Py_ssize_t]:
        """Return the state of the scanner where the longest token of a mode that begins at `at` ends, -1 for none, and its end."""
        d: cython.int = 0
        last: cython.int = -1
        taken: cython.Py_ssize_t = at
        to: cython.Py_ssize_t
        for to in range(at, end):
            if self.text[to] != 32 and self.text[to] != 9 and self.text[to] != 13:
                d = self.move[d << 6 | self.classes[self.text[to]]]
                if self.token[mode | d] >= 0:
                    last, taken = d, to + 1
        return last, taken

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _push(self, at: cython.Py_ssize_t, taken: cython.Py_ssize_t, literal: cython.int) -> cython.void:
        """Say of the symbol on top where its code, its text and its values begin."""
        self.symbol[self.top << 3 | 1] = self.used
        self.symbol[self.top << 3 | 2] = at - self.begin
        self.symbol[self.top << 3 | 3] = taken - self.begin
        self.symbol[self.top << 3 | 4] = self.depth << 8 | literal

    def _fits(self, kind: cython.int) -> bool:
        """Tell whether a terminal could stand where the last line was refused: its reductions lead to a shift."""
        stack: list = [self.symbol[k << 3] for k in range(self.top + 1)]
        state: cython.int = stack.pop()
        step: cython.int
        rule: cython.int
        while not (kind == self.end and state == self.accept):
            step = self.action[state << 6 | kind]
            if step >= 0:
                return step > 0
            rule = -step - 1
            stack.append(state)
            del stack[len(stack) - self.length[rule] :]
            state = stack[len(stack) - 1]
            state = self.to[self.goto[state << 5 | self.origin[rule]]]
        return True

    # Actions.

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _emit(self, operation: cython.int, operand: cython.int) -> cython.void:
        """Write an instruction."""
        self.code[self.used] = operation + 256 * operand
        self.used += 1

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _constant(self, value: cython.double) -> cython.void:
        """Write the instruction that pushes a number."""
        self.constants[self.numbers] = value
        self.code[self.used] = _NUMBER + 256 * (self.numbers - self.first)
        self.numbers += 1
        self.used += 1
        self.depth += 1

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _act(self, action: cython.int, count: cython.int) -> cython.int:
        """Write the code of a rule of `count` symbols, which stand on top of the stack."""
        first: cython.int = self.top - count + 1
        literal: cython.int
        if action == 12:
            self._plain_word(
                self.begin + self.symbol[first << 3 | 2], self.begin + self.symbol[first << 3 | 3]
            )
        elif action == 1:
            self._push_number(first, 0)
        elif action == 7:
            self._emit(_BINARY, self.symbol[(first + 1) << 3 | 4] & 255)
            self.depth -= 1
        elif action == 3:
            self._parameter(first + 1)
        elif action == 13:
            literal = self.symbol[first << 3 | 4] & 255
            self._emit(_WORD, literal if literal >= 128 else self._letter(first))
            self.depth -= 1
        elif action == 8:
            self._emit(_FUNCTION, self.symbol[first << 3 | 4] & 255)
        elif action == 5 or action == 6:
            self._negative(first, action)
        elif action == 2:
            self._name(self.symbol[first << 3 | 2] + 1, self.symbol[first << 3 | 3] - 1)
        elif action == 16:
            # A target that is a name has no instruction but that.
            self._emit(_SET_NAMED if self.code[self.symbol[(first + 1) << 3 | 1]] & 255 == _NAME else _SET, 0)
            self.depth -= 2
        elif action == 17 or action == 18 or action == 28:
            self._remark(_COMMENT if action == 17 else (_MESSAGE if action == 18 else _OUTPUT), first)
        elif action == 14:
            self._emit(_FUNCTION, self.symbol[first << 3 | 4] & 255)
            self._emit(_WORD, 105)
            self.depth -= 1
        else:
            return self._act_rarely(action, first)
        return 0

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _act_rarely(self, action: cython.int, first: cython.int) -> cython.int:
        """Write the code of a rule that is not in most lines."""
        if action == 9:
            self._emit(_ARC_TANGENT, 0)
            self.depth -= 1
        elif action == 10:
            self._emit(_SLOPE, 0)
        elif action == 11:
            self._emit(_BINARY, _POWER)
            self.depth -= 1
        elif action == 4:
            self._exists(first + 3)
        elif action == 15:
            self.alike = False
            self._constant(_BSPLINE)
            self._emit(_WORD, 103)
            self.depth -= 1
        elif action == 19:
            self._push_number(first, 1)
        elif action == 20:
            self._named_label(first)
        elif action == 21:
            self._flow(
                self.symbol[(first + 1) << 3 | 4] & 255, self.depth - (self.symbol[(first + 1) << 3 | 4] >> 8)
            )
        elif action == 22:
            self._flow(_PROGRAM, 0)
        elif action == 23 or action == 24:
            self._flow(_GOTO, 1 if action == 23 else 0)
        elif action == 25 or action == 26:
            self._push_number(self.top, 0)
            self._flow(_WHILE_DO if action == 25 else _END_DO, self.depth - 1)
        elif action == 27:
            self._emit(_THEN, 0)
            self.depth -= 1
        elif action == 29:
            self.flags |= 8
        return 0

    @cython.cfunc
    @cython.exceptval(check=False)
    def _flow(self, keyword: cython.int, count: cython.int) -> cython.void:
        """Write a jump, loop or call with `count` values beside its label (or the line, or the number of the loop)."""
        self._emit(_FLOW, keyword)
        self._emit(count, 0)
        self.code[self.used - 1] = count
        self.depth = 0

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _plain_word(self, begin: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.int:
        """Write a letter with its number, which stand between two offsets."""
        letter: cython.int = self.text[begin]
        if 65 <= letter <= 90:
            letter |= 32
        self._constant(self._number(begin + 1, end))
        if (
            self.increments
            and 97 <= letter <= 122
            and _LENGTHS >> (letter - 97) & 1
            and not self._dotted(begin, end)
        ):
            self._emit(_INCREMENTS, 0)
        self._emit(_WORD, letter)
        self.depth -= 1
        return 0

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _letter(self, k: cython.int) -> cython.int:
        """Return the first byte of a symbol, a letter as a small one."""
        c: cython.int = self.text[self.begin + self.symbol[k << 3 | 2]]
        return c | 32 if 65 <= c <= 90 else c

    @cython.cfunc
    @cython.exceptval(check=False)
    def _dotted(self, begin: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.bint:
        """Tell whether the text between two offsets holds a decimal point."""
        i: cython.Py_ssize_t
        for i in range(begin, end):
            if self.text[i] == 46:
                return True
        return False

    @cython.cfunc
    @cython.exceptval(check=False)
    def _parameter(self, k: cython.int) -> cython.void:
        """Write the instruction that reads the parameter whose number or name is on top."""
        code: cython.int = self.code[self.symbol[k << 3 | 1]]
        value: cython.double
        if code & 255 == _NAME:
            self.code[self.symbol[k << 3 | 1]] = _NAMED + (code & ~255)
        elif code & 255 == _NUMBER and self.used == self.symbol[k << 3 | 1] + 1:
            value = self.constants[self.numbers - 1]
            # Which instruction it is hangs on the number, which behind a bracket is not of the shape.
            self.alike = self.alike and self.text[self.begin + self.symbol[k << 3 | 2]] != 91
            if 0.0 < value < self.stored and value == cython.cast(cython.int, value):
                self.numbers -= 1
                self.code[self.used - 1] = _STORED + 256 * cython.cast(cython.int, value)
            else:
                self._emit(_PARAMETER, 0)
        else:
            self._emit(_PARAMETER, 0)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _exists(self, k: cython.int) -> cython.void:
        """Write the instruction that tests whether a parameter exists."""
        code: cython.int = self.code[self.symbol[k << 3 | 1]]
        if code & 255 == _NAME:
            self.code[self.symbol[k << 3 | 1]] = _EXISTS_NAMED + (code & ~255)
        else:
            self._emit(_EXISTS, 0)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _negative(self, first: cython.int, action: cython.int) -> cython.void:
        """Write the instruction that negates the value on top, unless the sign is plus."""
        last: cython.int = self.used - 1
        if action == 6 and self.symbol[first << 3 | 4] & 255 != _MINUS:
            return
        if self.code[last] & 255 == _NUMBER and last == self.symbol[(first + 1) << 3 | 1]:
            self.constants[self.numbers - 1] = -self.constants[self.numbers - 1]
        elif self.code[last] == _NEGATIVE:
            self.used -= 1
        else:
            self._emit(_NEGATIVE, 0)

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _name(self, begin: cython.int, end: cython.int) -> cython.int:
        """Write a name that stands between two places of the line."""
        key: bytes = bytes(self.text[self.begin + begin : self.begin + end])
        self._emit(_NAME, self.name(key))
        self.depth += 1
        return 0

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _named_label(self, k: cython.int) -> cython.int:
        """Write the name of an O-word: o<100> is o100."""
        begin: cython.int = self.symbol[k << 3 | 2]
        while self.text[self.begin + begin] != 60:
            begin += 1
        self._name(begin + 1, self.symbol[k << 3 | 3] - 1)
        name: str = self.names[self.code[self.used - 1] >> 8]
        if name.isdecimal():
            self.used -= 1
            self.depth -= 1
            self.alike = False
            self._constant(float(name))
        return 0

    @cython.cfunc
    @cython.exceptval(check=False)
    def _remark(self, operation: cython.int, k: cython.int) -> cython.void:
        """Write where a comment stands."""
        self._emit(operation, self.symbol[k << 3 | 2])
        self.code[self.used] = self.symbol[k << 3 | 3] - self.symbol[k << 3 | 2]
        self.used += 1

    @cython.cfunc
    @cython.exceptval(-1.0, check=True)
    def _number(self, begin: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.double:
        """Return the number that stands between two offsets: the double nearest to its decimal text."""
        mantissa: cython.ulonglong = 0
        decimals: cython.int = 0
        dotted: cython.bint = False
        negative: cython.bint = False
        value: cython.double
        c: cython.int
        i: cython.Py_ssize_t
        if end - begin > _DIGITS:
            return self._long_number(begin, end)
        for i in range(begin, end):
            c = self.text[i]
            if 48 <= c <= 57:
                mantissa = mantissa * 10 + cython.cast(cython.ulonglong, c - 48)
                decimals += dotted
            elif c == 46:
                dotted = True
            elif c == 45:
                negative = True
        if mantissa > _EXACT:
            return self._long_number(begin, end)
        value = cython.cast(cython.double, mantissa)
        if decimals > 0:
            # Both are doubles without error, so the quotient is rounded once (Clinger, as in `part21_scan.points`).
            value /= _POWERS[decimals]
        return -value if negative else value

    @cython.cfunc
    @cython.exceptval(-1.0, check=True)
    def _long_number(self, begin: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.double:
        """Do the same for a number of any length."""
        text: bytes = bytes(self.text[begin:end])
        return float(text.translate(None, b" \t\r"))

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _push_number(self, k: cython.int, skip: cython.int) -> cython.int:
        """Write the number of a symbol, behind as many characters."""
        begin: cython.Py_ssize_t = self.begin + self.symbol[k << 3 | 2] + skip
        self._constant(self._number(begin, self.begin + self.symbol[k << 3 | 3]))
        return 0
