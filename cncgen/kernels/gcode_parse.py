"""Read lines of G-code by the tables of their grammar (``grammars/lalr.py``) into small programs for `gcode_run`.

One pass over the bytes of a line: a DFA finds the tokens that the parser's state allows, the LALR automaton shifts and reduces
them, and each rule's action (`ACTIONS`) writes instructions to `Parser.code`. Nothing is judged: where the grammar has no
token the line is refused, and the place and the parser's stack tell what was expected.

    NUMBER k       push constants[k]                 WORD letter     pop a value: a word of the block
    STORED k       push the numbered parameter k     SET             pop value and number: a parameter is to be set
    PARAMETER      pop a number, push its parameter  SET_NAMED       the same, of a name
    NAME k         push k, the number of a name      COMMENT, MESSAGE    followed by its place in the line and its length
    NAMED k        push the named parameter          THEN            pop a value: 0 ends the line
    EXISTS, EXISTS_NAMED                             FLOW keyword    jump, loop or call with so many values (and the label)
    NEGATIVE, BINARY operator, FUNCTION name         STATEMENT k     what a dialect executes itself, with so many values
    ARC_TANGENT, SLOPE, INCREMENTS                   TEXT            text of a statement: place and length
                                                     END

An instruction is one number, ``operation + 256 * operand``. FLOW and STATEMENT are followed by the count of their values.
"""

from mmap import mmap

import cython

#: Work of the kernel where a rule (by its alias, else by its name) is reduced.
ACTIONS = {
    "number": 1,
    "name": 2,
    "parameter": 3,
    "exists": 4,
    "negative": 5,
    "unary": 6,
    "binary": 7,
    "function": 8,
    "arc_tangent": 9,
    "slope": 10,
    "power_of": 11,
    "plain_word": 12,
    "word": 13,
    "word_of_function": 14,
    "bspline": 15,
    "corner": 13,
    "setting": 16,
    "comment": 17,
    "message": 18,
    "numbered_label": 19,
    "named_label": 20,
    "o_word": 21,
    "program_number": 22,
    "if_goto": 23,
    "goto": 24,
    "while_do": 25,
    "end_do": 26,
    "then": 27,
    "output": 28,
    # Rules that leave what their parts have left.
    "start": 0,
    "content": 0,
    "flow": 0,
    "if_then": 0,
    "named_call": 0,
    "bracket": 0,
    "computed_label": 0,
}
#: Names of the literals of terminals: operators, functions, keywords, letters of words of more than one.
LITERALS = {
    "and": 1,
    "or": 2,
    "xor": 3,
    "eq": 4,
    "ne": 5,
    "gt": 6,
    "ge": 7,
    "lt": 8,
    "le": 9,
    "+": 10,
    "-": 11,
    "*": 12,
    "/": 13,
    "mod": 14,
    "**": 15,
    "abs": 20,
    "acos": 21,
    "asin": 22,
    "cos": 23,
    "exp": 24,
    "fix": 25,
    "fup": 26,
    "ln": 27,
    "round": 28,
    "sin": 29,
    "sqrt": 30,
    "tan": 31,
    "bin": 32,
    "bcd": 33,
    "sqr": 34,
    "rnd": 35,
    "ifix[": 25,
    "ifup[": 26,
    "sub": 40,
    "endsub": 41,
    "call": 42,
    "return": 43,
    "if": 44,
    "elseif": 45,
    "else": 46,
    "endif": 47,
    "while": 48,
    "endwhile": 49,
    "do": 50,
    "repeat": 51,
    "endrepeat": 52,
    "break": 53,
    "continue": 54,
    "program": 55,
    "goto": 56,
    "while-do": 57,
    "end-do": 58,
    "pw=": 128,
    "pl=": 129,
    "sd=": 130,
    ",c": 131,
    ",r": 132,
    ",a": 133,
}
#: Operations.
OPERATIONS = {
    "END": 0,
    "NUMBER": 1,
    "WORD": 2,
    "STORED": 3,
    "BINARY": 4,
    "SET": 5,
    "PARAMETER": 6,
    "NAMED": 7,
    "NAME": 8,
    "SET_NAMED": 9,
    "NEGATIVE": 10,
    "FUNCTION": 11,
    "ARC_TANGENT": 12,
    "SLOPE": 13,
    "EXISTS": 14,
    "EXISTS_NAMED": 15,
    "COMMENT": 16,
    "MESSAGE": 17,
    "FLOW": 18,
    "THEN": 19,
    "INCREMENTS": 20,
    "STATEMENT": 21,
    "TEXT": 22,
    "OUTPUT": 23,
}
#: Bit of `Parser.named`, behind those of A to Z: a G or M number is computed.
COMPUTED = 1 << 26
#: Codes that `Parser.named` tells apart, in tenths: those of G, then those of M.
CODE_NUMBERS = 4000
#: Of its `calls`: the words beside the program's number are arguments and name no axis.
ARGUMENTS = 128
#: Longest line, and numbers and instructions that the lines kept may have together.
MAX_LINE = 65_536
#: Marks of a line, beside its code.
DELETED = 1
NUMBERED = 2

_END = cython.declare(cython.int, 0)
_NUMBER = cython.declare(cython.int, 1)
_WORD = cython.declare(cython.int, 2)
_STORED = cython.declare(cython.int, 3)
_BINARY = cython.declare(cython.int, 4)
_SET = cython.declare(cython.int, 5)
_PARAMETER = cython.declare(cython.int, 6)
_NAMED = cython.declare(cython.int, 7)
_NAME = cython.declare(cython.int, 8)
_SET_NAMED = cython.declare(cython.int, 9)
_NEGATIVE = cython.declare(cython.int, 10)
_FUNCTION = cython.declare(cython.int, 11)
_ARC_TANGENT = cython.declare(cython.int, 12)
_SLOPE = cython.declare(cython.int, 13)
_EXISTS = cython.declare(cython.int, 14)
_EXISTS_NAMED = cython.declare(cython.int, 15)
_COMMENT = cython.declare(cython.int, 16)
_MESSAGE = cython.declare(cython.int, 17)
_FLOW = cython.declare(cython.int, 18)
_THEN = cython.declare(cython.int, 19)
_INCREMENTS = cython.declare(cython.int, 20)
_STATEMENT = cython.declare(cython.int, 21)
_TEXT = cython.declare(cython.int, 22)
_OUTPUT = cython.declare(cython.int, 23)

#: Keywords and operators that actions name.
_MINUS = cython.declare(cython.int, 11)
_POWER = cython.declare(cython.int, 15)
_CALL = cython.declare(cython.int, 42)
_COMPUTED = cython.declare(cython.uint, COMPUTED)
_CODE_NUMBERS = cython.declare(cython.int, CODE_NUMBERS)
_ARGUMENTS = cython.declare(cython.int, ARGUMENTS)
#: Bits of words, of axes, and of X and Y.
_WORDS = cython.declare(cython.ulonglong, (1 << 32) - 1)
_AXES = cython.declare(cython.ulonglong, sum(1 << (ord(letter) - 97) for letter in "xyzabcuvw"))
_POLAR = cython.declare(cython.uint, 1 << 23 | 1 << 24)
_PROGRAM = cython.declare(cython.int, 55)
_GOTO = cython.declare(cython.int, 56)
_WHILE_DO = cython.declare(cython.int, 57)
_END_DO = cython.declare(cython.int, 58)
#: Number of BSPLINE of Siemens among the G codes (`cncgen.gcode.block`).
_BSPLINE = cython.declare(cython.double, 1060.0)

_POWERS = cython.declare(cython.double[23])
_DIGITS = cython.declare(cython.int, 18)
_EXACT = cython.declare(cython.ulonglong, 9007199254740992)
_DEPTH = cython.declare(cython.int, 70_000)
_k: cython.int
for _k in range(23):
    _POWERS[_k] = 10.0**_k

#: Letters whose numbers without a decimal point count in least increments, as bits (A is bit 0).
_LENGTHS = cython.declare(cython.uint, sum(1 << (ord(letter) - 97) for letter in "xyzabcuvwijkqr"))


def _rows(table):
    """Return a table of a generated module as a two-dimensional buffer."""
    width, data = table
    return memoryview(data).cast("h", [len(data) // 2 // width, width])


def _zeros(size):
    """Return a buffer; pages of it that are not filled take no time."""
    try:
        return memoryview(mmap(-1, size))
    except OSError as error:
        raise MemoryError from error


def _row(table):
    """Return a table of one row as a buffer."""
    return memoryview(table[1]).cast("h")


@cython.cclass
class Parser:
    """The tables of a grammar, and what reading lines with them leaves.

    Args:
        tables: A module of tables (``grammars/tables_*.py``).
        stored: Numbered parameters below this are plain storage.
        increments: Whether lengths without a decimal point count in least increments.

    Attributes:
        code, constants: Instructions, and the numbers that they push.
        used, numbers: How much of them is in use; whoever keeps a line begins the next one behind it.
        names: Names of parameters and labels by their number, small letters without blanks.
        flags: `DELETED`, `NUMBERED`, of the line read last.
        line_number: Where its N word begins and ends.
        error: Offset where the grammar refused it, -1 where it did not.
        lines: How many lines were read.
    """

    action: cython.const[cython.short][:, ::1]
    goto: cython.const[cython.short][:, ::1]
    again: cython.const[cython.short][:, ::1]
    move: cython.const[cython.short][:, ::1]
    token: cython.const[cython.short][:, ::1]
    length: cython.const[cython.short][::1]
    origin: cython.const[cython.short][::1]
    made: cython.const[cython.short][::1]
    classes: cython.const[cython.short][::1]
    mode: cython.const[cython.short][::1]
    literal: cython.const[cython.short][::1]
    kept: cython.const[cython.short][::1]
    text: cython.const[cython.uchar][::1]
    code = cython.declare(cython.int[::1], visibility="public")
    constants = cython.declare(cython.double[::1], visibility="public")
    symbol: cython.int[:, ::1]
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
    used = cython.declare(cython.int, visibility="public")
    numbers = cython.declare(cython.int, visibility="public")
    flags = cython.declare(cython.int, visibility="public")
    error = cython.declare(cython.Py_ssize_t, visibility="public")
    lines = cython.declare(cython.Py_ssize_t, visibility="public")
    number_begin = cython.declare(cython.Py_ssize_t, visibility="public")
    number_end = cython.declare(cython.Py_ssize_t, visibility="public")

    def __init__(self, tables, stored, increments=False):
        self.action = _rows(tables.ACTION)
        self.goto = _rows(tables.GOTO)
        self.length = _row(tables.LENGTH)
        self.origin = _row(tables.ORIGIN)
        self.made = _row(tables.MADE)
        self.again = _rows(tables.AGAIN)
        self.classes = _row(tables.CLASSES)
        self.move = _rows(tables.MOVE)
        self.token = _rows(tables.TOKEN)
        self.mode = _row(tables.MODE)
        self.literal = _row(tables.LITERAL)
        self.kept = _row(tables.KEPT)
        self.terminals = tables.TERMINALS
        self.start, self.accept = tables.START, tables.ACCEPT
        self.end = len(self.terminals) - 1
        self.delete = self.terminals.index("DELETE") if "DELETE" in self.terminals else -1
        self.line_word = self.terminals.index("LINE_NUMBER") if "LINE_NUMBER" in self.terminals else -1
        self.stored = stored
        self.increments = increments
        self.code = _zeros(4 << 20).cast("i")
        self.constants = _zeros(8 << 19).cast("d")
        self.symbol = _zeros(4 * 6 * _DEPTH).cast("i", [_DEPTH, 6])
        self.names = []
        self.numbered = {}
        self.used = self.numbers = self.lines = 0
        self.error = -1

    def room(self) -> bool:
        """Tell whether another line has room for its code."""
        return (
            self.used + 4 * MAX_LINE < self.code.shape[0]
            and self.numbers + MAX_LINE < self.constants.shape[0]
        )

    def name(self, key: bytes) -> int:
        """Return the number of a name, as it is written in the text."""
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
    def parse(self, text: cython.const[cython.uchar][::1], offset: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Read the line at `offset`, its code into `code` from `used` on; return the offset of its end.

        `error` tells whether it is one of the grammar. Where it is, `used` and `numbers` stand behind its code.
        """
        at: cython.Py_ssize_t = offset
        size: cython.Py_ssize_t = text.shape[0]
        to: cython.Py_ssize_t
        taken: cython.Py_ssize_t
        first: cython.int = self.used
        numbers: cython.int = self.numbers
        d: cython.int
        mode: cython.int
        kind: cython.int
        literal: cython.int
        step: cython.int
        state: cython.int = self.start
        self.text = text
        self.lines += 1
        self.begin = offset
        self.top = 0
        self.error = -1
        self.flags = 0
        self.depth = 0
        self.symbol[0, 0] = state
        while True:
            # Blanks before a token.
            while at < size and (text[at] == 32 or text[at] == 9 or text[at] == 13):
                at += 1
            if at >= size or text[at] == 10:
                kind, taken, literal = self.end, at, 0
            else:
                d, to, kind, taken, literal = 0, at, -1, at, 0
                mode = self.mode[state]
                while to < size and text[to] != 10:
                    step = self.move[d, self.classes[text[to]]]
                    if step < 0:
                        if text[to] == 32 or text[to] == 9 or text[to] == 13:
                            to += 1
                            continue
                        break
                    d = step
                    to += 1
                    if self.token[mode, d] >= 0:
                        kind, taken, literal = self.token[mode, d], to, self.literal[d]
                if kind < 0:
                    break
                if self.again[state, kind] >= 0:
                    # A word behind a word.
                    self.top += 1
                    self._push(at, taken, literal)
                    self._act(self.again[state, kind], 1)
                    self.top -= 1
                    at = taken
                    continue
            step = self._reduce(kind)
            if step == 0:
                break
            if kind == self.end:
                self._emit(_END, 0)
                return at
            if kind == self.delete:
                self.flags |= 1
            elif kind == self.line_word:
                self.flags |= 2
                self.number_begin, self.number_end = at, taken
            state = step - 1
            self.top += 1
            self.symbol[self.top, 0] = state
            self._push(at, taken, literal)
            self.symbol[self.top, 5] = kind
            at = taken
        self.error = at
        self.used, self.numbers = first, numbers
        while at < size and text[at] != 10:
            at += 1
        return at

    def named(
        self,
        text: cython.const[cython.uchar][::1],
        first: cython.int[::1],
        calls: cython.const[cython.uchar][::1],
    ) -> tuple:
        """Read all lines of a text and return what their words name; lines that the grammar refuses name nothing.

        Args:
            text: The program.
            first: Of length ``4 * CODE_NUMBERS``, zeros: filled with the line on which each code stands first, and in its second
                half with that on which it stands first in a block that names no axis.
            calls: Of half the length: of a code that calls a program, the letter (small) whose number names it, with `ARGUMENTS`
                where the block has its arguments; else 0.

        Returns:
            Letters of words as bits from A at bit 0 (``@`` and ``^`` are X and Y), with `COMPUTED`; the line of the first call,
            0 without one; and the numbers and names of the programs that are called.
        """
        at: cython.Py_ssize_t = 0
        line: cython.int = 0
        first_call: cython.int = 0
        call: cython.int
        found: cython.ulonglong = 0
        bits: cython.ulonglong
        programs: set = set()
        while at < text.shape[0]:
            line += 1
            self.used = self.numbers = 0
            at = self.parse(text, at) + 1
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
    @cython.inline
    @cython.exceptval(check=False)
    def _push(self, at: cython.Py_ssize_t, taken: cython.Py_ssize_t, literal: cython.int) -> cython.void:
        """Say of the symbol on top where its code, its text and its values begin."""
        self.symbol[self.top, 1] = self.used
        self.symbol[self.top, 2] = at - self.begin
        self.symbol[self.top, 3] = taken - self.begin
        self.symbol[self.top, 4] = self.depth << 8 | literal

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _reduce(self, kind: cython.int) -> cython.int:
        """Reduce until the terminal can be shifted (its action is returned), is the accepted end (1), or is refused (0)."""
        step: cython.int
        rule: cython.int
        count: cython.int
        state: cython.int
        while True:
            state = self.symbol[self.top, 0]
            if kind == self.end and state == self.accept:
                return 1
            step = self.action[state, kind]
            if step >= 0:
                return step
            rule = -step - 1
            count = self.length[rule]
            if self.made[rule] != 0:
                self._act(self.made[rule], count)
            self.top -= count
            state = self.goto[self.symbol[self.top, 0], self.origin[rule]]
            self.top += 1
            if count == 0:
                self._push(self.begin, self.begin, 0)
            self.symbol[self.top, 0] = state
            self.symbol[self.top, 5] = -1

    def _fits(self, kind: cython.int) -> bool:
        """Tell whether a terminal could stand where the last line was refused: its reductions lead to a shift."""
        stack: list = [self.symbol[k, 0] for k in range(self.top + 1)]
        state: cython.int = stack.pop()
        step: cython.int
        rule: cython.int
        while not (kind == self.end and state == self.accept):
            step = self.action[state, kind]
            if step >= 0:
                return step > 0
            rule = -step - 1
            stack.append(state)
            del stack[len(stack) - self.length[rule] :]
            state = stack[len(stack) - 1]
            state = self.goto[state, self.origin[rule]]
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
        """Write what pushes a number."""
        self.constants[self.numbers] = value
        self.code[self.used] = _NUMBER + 256 * self.numbers
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
            self._plain_word(first)
        elif action == 1:
            self._constant(self._number(self.symbol[first, 2], self.symbol[first, 3]))
        elif action == 7:
            self._emit(_BINARY, self.symbol[first + 1, 4] & 255)
            self.depth -= 1
        elif action == 3:
            self._parameter(first + 1)
        elif action == 13:
            literal = self.symbol[first, 4] & 255
            self._emit(_WORD, literal if literal >= 128 else self._letter(first))
            self.depth -= 1
        elif action == 8:
            self._emit(_FUNCTION, self.symbol[first, 4] & 255)
        elif action == 5 or action == 6:
            self._negative(first, action)
        elif action == 2:
            self._name(self.symbol[first, 2] + 1, self.symbol[first, 3] - 1)
        elif action == 16:
            # A target that is a name has no instruction but that.
            self._emit(_SET_NAMED if self.code[self.symbol[first + 1, 1]] & 255 == _NAME else _SET, 0)
            self.depth -= 2
        elif action == 17 or action == 18 or action == 28:
            self._remark(_COMMENT if action == 17 else (_MESSAGE if action == 18 else _OUTPUT), first)
        elif action == 14:
            self._emit(_FUNCTION, self.symbol[first, 4] & 255)
            self._emit(_WORD, 105)
            self.depth -= 1
        else:
            return self._act_rarely(action, first, count)
        return 0

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _act_rarely(self, action: cython.int, first: cython.int, count: cython.int) -> cython.int:
        """Write the code of a rule that is not in most lines."""
        if action < 0:
            self._statement(-action - 1, first, count)
        elif action == 9:
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
            self._constant(_BSPLINE)
            self._emit(_WORD, 103)
            self.depth -= 1
        elif action == 19:
            self._constant(self._number(self.symbol[first, 2] + 1, self.symbol[first, 3]))
        elif action == 20:
            self._named_label(first)
        elif action == 21:
            self._flow(self.symbol[first + 1, 4] & 255, self.depth - (self.symbol[first + 1, 4] >> 8))
        elif action == 22:
            self._flow(_PROGRAM, 0)
        elif action == 23 or action == 24:
            self._flow(_GOTO, 1 if action == 23 else 0)
        elif action == 25 or action == 26:
            self._constant(self._number(self.symbol[self.top, 2], self.symbol[self.top, 3]))
            self._flow(_WHILE_DO if action == 25 else _END_DO, self.depth - 1)
        elif action == 27:
            self._emit(_THEN, 0)
            self.depth -= 1
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
    @cython.exceptval(check=False)
    def _statement(self, number: cython.int, first: cython.int, count: cython.int) -> cython.void:
        """Write a statement of a dialect: the texts of its tokens, and how many values it has."""
        k: cython.int
        values: cython.int = self.depth - (self.symbol[first, 4] >> 8) if count > 0 else 0
        for k in range(first, first + count):
            if self.symbol[k, 5] >= 0 and self.kept[self.symbol[k, 5]]:
                self._emit(_TEXT, self.symbol[k, 2])
                self.code[self.used] = self.symbol[k, 3] - self.symbol[k, 2]
                self.used += 1
        self._emit(_STATEMENT, number)
        self.code[self.used] = values
        self.used += 1
        self.depth -= values

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _plain_word(self, k: cython.int) -> cython.int:
        """Write a letter with its number."""
        letter: cython.int = self._letter(k)
        self._constant(self._number(self.symbol[k, 2] + 1, self.symbol[k, 3]))
        if self.increments and 97 <= letter <= 122 and _LENGTHS >> (letter - 97) & 1 and not self._dotted(k):
            self._emit(_INCREMENTS, 0)
        self._emit(_WORD, letter)
        self.depth -= 1
        return 0

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _letter(self, k: cython.int) -> cython.int:
        """Return the first byte of a symbol, a letter as a small one."""
        c: cython.int = self.text[self.begin + self.symbol[k, 2]]
        return c | 32 if 65 <= c <= 90 else c

    @cython.cfunc
    @cython.exceptval(check=False)
    def _dotted(self, k: cython.int) -> cython.bint:
        """Tell whether the text of a symbol holds a decimal point."""
        i: cython.Py_ssize_t
        for i in range(self.begin + self.symbol[k, 2], self.begin + self.symbol[k, 3]):
            if self.text[i] == 46:
                return True
        return False

    @cython.cfunc
    @cython.exceptval(check=False)
    def _parameter(self, k: cython.int) -> cython.void:
        """Write what reads the parameter whose number or name is on top."""
        code: cython.int = self.code[self.symbol[k, 1]]
        value: cython.double
        if code & 255 == _NAME:
            self.code[self.symbol[k, 1]] = _NAMED + (code & ~255)
        elif code & 255 == _NUMBER and self.used == self.symbol[k, 1] + 1:
            value = self.constants[self.numbers - 1]
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
        """Write what tells whether there is a parameter."""
        code: cython.int = self.code[self.symbol[k, 1]]
        if code & 255 == _NAME:
            self.code[self.symbol[k, 1]] = _EXISTS_NAMED + (code & ~255)
        else:
            self._emit(_EXISTS, 0)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _negative(self, first: cython.int, action: cython.int) -> cython.void:
        """Write what turns the sign of the value on top, unless the sign is plus."""
        last: cython.int = self.used - 1
        if action == 6 and self.symbol[first, 4] & 255 != _MINUS:
            return
        if self.code[last] & 255 == _NUMBER and last == self.symbol[first + 1, 1]:
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
        begin: cython.int = self.symbol[k, 2]
        while self.text[self.begin + begin] != 60:
            begin += 1
        self._name(begin + 1, self.symbol[k, 3] - 1)
        name: str = self.names[self.code[self.used - 1] >> 8]
        if name.isdecimal():
            self.used -= 1
            self.depth -= 1
            self._constant(float(name))
        return 0

    @cython.cfunc
    @cython.exceptval(check=False)
    def _remark(self, operation: cython.int, k: cython.int) -> cython.void:
        """Write where a comment stands."""
        self._emit(operation, self.symbol[k, 2])
        self.code[self.used] = self.symbol[k, 3] - self.symbol[k, 2]
        self.used += 1

    @cython.cfunc
    @cython.exceptval(-1.0, check=True)
    def _number(self, begin: cython.int, end: cython.int) -> cython.double:
        """Return the number that stands between two places of the line: the double nearest to its decimal text."""
        mantissa: cython.ulonglong = 0
        digits: cython.int = 0
        decimals: cython.int = 0
        dotted: cython.bint = False
        negative: cython.bint = False
        value: cython.double
        c: cython.int
        i: cython.Py_ssize_t
        for i in range(self.begin + begin, self.begin + end):
            c = self.text[i]
            if 48 <= c <= 57:
                mantissa = mantissa * 10 + cython.cast(cython.ulonglong, c - 48)
                digits += 1
                decimals += dotted
                if digits > _DIGITS:
                    break
            elif c == 46:
                dotted = True
            elif c == 45:
                negative = True
        if digits > _DIGITS or mantissa > _EXACT:
            text: bytes = bytes(self.text[self.begin + begin : self.begin + end])
            return float(text.translate(None, b" \t\r"))
        value = cython.cast(cython.double, mantissa)
        if decimals > 0:
            # Both are doubles without error, so the quotient is rounded once (Clinger, as in `part21_scan.points`).
            value /= _POWERS[decimals]
        return -value if negative else value
