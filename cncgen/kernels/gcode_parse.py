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

import cython
from cython.cimports.cncgen.kernels.decimals import decimal, is_blank
from cython.cimports.cncgen.kernels.gcode_codes import (
    ARC_TANGENT, BINARY, COMMENT, COMPUTED_LABEL, DELETED, END, END_DO, EXISTS, EXISTS_NAMED, FLOW, FUNCTION, GOTO, INCREMENTS,
    MAX_LINE, MESSAGE, NAME, NAMED, NEGATIVE, NUMBER, NUMBERED, OUTPUT, PARAMETER, POWER, PROGRAM, RULE_ARC_TANGENT,
    RULE_BINARY, RULE_BSPLINE, RULE_COMMENT, RULE_COMPUTED_LABEL, RULE_END_DO, RULE_EXISTS, RULE_FUNCTION, RULE_GOTO,
    RULE_IF_GOTO, RULE_MESSAGE, RULE_NAME, RULE_NAMED_LABEL, RULE_NEGATIVE, RULE_NUMBER, RULE_NUMBERED_LABEL, RULE_OUTPUT,
    RULE_O_WORD, RULE_PARAMETER, RULE_PLAIN_WORD, RULE_POWER_OF, RULE_PROGRAM_NUMBER, RULE_SETTING, RULE_SLOPE, RULE_THEN,
    RULE_UNARY, RULE_WHILE_DO, RULE_WORD, RULE_WORD_OF_FUNCTION, SET, SET_NAMED, SLOPE, STORED, SUBTRACT, THEN, WHILE_DO, WORD,
)  # fmt: skip
from cython.cimports.cncgen.kernels.gcode_lines import Code

from cncgen.kernels.gcode_lines import zeros

#: Number of BSPLINE of Siemens among the G codes (`cncgen.gcode.block`).
_BSPLINE = cython.declare(cython.double, 1060.0)

_DEPTH = cython.declare(cython.int, 70_000)

#: Letters whose numbers without a decimal point count in least increments, as bits (A is bit 0).
_LENGTHS = cython.declare(cython.uint, sum(1 << (ord(letter) - 97) for letter in "xyzabcuvwijkqr"))

#: A token: its terminal (-1 for none), the offset behind it, and the number of its literal (0 for none).
_Token = cython.struct(kind=cython.int, taken=cython.Py_ssize_t, literal=cython.int)


@cython.cfunc
def _fill(to: cython.short[::1], table) -> cython.void:
    """Copy a table of a generated module."""
    row: cython.const[cython.short][::1] = memoryview(table[1]).cast("h")
    k: cython.Py_ssize_t
    for k in range(row.shape[0]):
        to[k] = row[k]


@cython.final
@cython.cclass
class Parser(Code):
    """The tables of a grammar, and what reads lines by them.

    Args:
        tables: A module of tables (``grammars/tables_*.py``).
        stored: Numbered parameters below this are plain storage.
        increments: Whether lengths without a decimal point count in least increments.
    """

    action = cython.declare(cython.short[16_384])
    goto = cython.declare(cython.short[8192])
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
    symbol: cython.int[::1]
    terminals = cython.declare(tuple, visibility="public")
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
    first = cython.declare(cython.int)

    def __init__(self, tables, stored, increments=False):
        Code.__init__(self)
        self._take_tables(tables)
        self.terminals = tables.TERMINALS
        self.start, self.accept = tables.START, tables.ACCEPT
        self.end = len(self.terminals) - 1
        self.delete = self.terminals.index("DELETE") if "DELETE" in self.terminals else -1
        self.line_word = self.terminals.index("LINE_NUMBER") if "LINE_NUMBER" in self.terminals else -1
        self.stored = stored
        self.increments = increments
        self.shaped = tables.SHAPED and not increments
        self.symbol = zeros(4 * 8 * _DEPTH).cast("i")
        self.numbered = {}

    @cython.cfunc
    def _take_tables(self, tables) -> cython.void:
        """Copy the tables of a generated module, which are within these bounds (``lalr.MOST``)."""
        if not cython.compiled:
            from cncgen.kernels.gcode_codes import MOST

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

    def parse(self, text: cython.const[cython.uchar][::1], offset: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Read the line at `offset` of a text, as `read`."""
        self.text = text
        return self.read(offset)

    @cython.ccall
    @cython.exceptval(-1, check=False)
    def read(self, offset: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Read the line at `offset` of `text` (`Code.read`)."""
        at: cython.Py_ssize_t = offset
        # A line that is longer than any is refused there.
        size: cython.Py_ssize_t = min(self.text.shape[0], offset + MAX_LINE)
        used: cython.int = self.used
        step: cython.int
        state: cython.int = self.start
        token: _Token
        self._begin(offset)
        while True:
            while at < size and is_blank(self.text[at]):
                at += 1
            if at >= size or self.text[at] == 10:
                if at == size and at < self.text.shape[0] and self.text[at] != 10:
                    break
                token = _Token(kind=self.end, taken=at, literal=0)
            else:
                token = self._token(at, size, self.mode[state] << 9)
                if token.kind < 0:
                    break
                if self.again[state << 6 | token.kind] == RULE_PLAIN_WORD:
                    # A word behind a word.
                    self._plain_word(at, token.taken)
                    at = token.taken
                    continue
            step = self.action[state << 6 | token.kind]
            if step < 0:
                state = self._reduced(state, token.kind, step)
                step = self.action[state << 6 | token.kind]
            if token.kind == self.end:
                if state != self.accept:
                    break
                self._emit(END, 0)
                return at
            if step == 0:
                break
            state = self._shifted(step - 1, at, token)
            at = token.taken
        self.error = at
        self.used, self.numbers = used, self.first
        while at < self.text.shape[0] and self.text[at] != 10:
            at += 1
        return at

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _begin(self, offset: cython.Py_ssize_t) -> cython.void:
        """Begin with a line: nothing stands on the stack but the first state."""
        self.lines += 1
        self.begin = offset
        self.first = self.numbers
        self.top = self.flags = self.depth = 0
        self.error = -1
        self.symbol[0] = self.start

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _token(self, at: cython.Py_ssize_t, size: cython.Py_ssize_t, mode: cython.int) -> _Token:
        """Return the longest token at a place that a mode of the scanner has; blanks may stand anywhere in it."""
        d: cython.int = 0
        to: cython.Py_ssize_t = at
        taken: cython.Py_ssize_t = at
        step: cython.int
        while to < size:
            step = self.move[d << 6 | self.classes[self.text[to]]]
            if step >= 0:
                d = step
                taken = to + 1
            elif not is_blank(self.text[to]):
                break
            to += 1
        if self.token[mode | d] < 0:
            # The longest token of this state is shorter than those of others: "/" before "[", say.
            return self._shorter(at, taken, mode)
        return _Token(kind=self.token[mode | d], taken=taken, literal=self.literal[d])

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _shifted(self, state: cython.int, at: cython.Py_ssize_t, token: _Token) -> cython.int:
        """Put a token at `at` on the stack, with the state that it leads to, and return that."""
        if token.kind == self.delete:
            self.flags |= DELETED
        elif token.kind == self.line_word:
            self.flags |= NUMBERED
            self.number_begin, self.number_end = at, token.taken
        self.top += 1
        self.symbol[self.top << 3] = state
        self._push(at, token.taken, token.literal)
        return state

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

    @cython.cfunc
    @cython.exceptval(check=False)
    def _shorter(self, at: cython.Py_ssize_t, end: cython.Py_ssize_t, mode: cython.int) -> _Token:
        """Return the longest token of a mode that begins at `at` and ends before `end`."""
        d: cython.int = 0
        to: cython.Py_ssize_t
        found: _Token = _Token(kind=-1, taken=at, literal=0)
        for to in range(at, end):
            if not is_blank(self.text[to]):
                d = self.move[d << 6 | self.classes[self.text[to]]]
                if self.token[mode | d] >= 0:
                    found = _Token(kind=self.token[mode | d], taken=to + 1, literal=self.literal[d])
        return found

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
        self.code[self.used] = NUMBER + 256 * (self.numbers - self.first)
        self.numbers += 1
        self.used += 1
        self.depth += 1

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _act(self, action: cython.int, count: cython.int) -> cython.int:
        """Write the code of a rule of `count` symbols, which stand on top of the stack."""
        first: cython.int = self.top - count + 1
        literal: cython.int
        if action == RULE_PLAIN_WORD:
            self._plain_word(
                self.begin + self.symbol[first << 3 | 2], self.begin + self.symbol[first << 3 | 3]
            )
        elif action == RULE_NUMBER:
            self._push_number(first, 0)
        elif action == RULE_BINARY:
            self._emit(BINARY, self.symbol[(first + 1) << 3 | 4] & 255)
            self.depth -= 1
        elif action == RULE_PARAMETER:
            self._parameter(first + 1)
        elif action == RULE_WORD:
            literal = self.symbol[first << 3 | 4] & 255
            self._emit(WORD, literal if literal >= 128 else self._letter(first))
            self.depth -= 1
        elif action == RULE_FUNCTION:
            self._emit(FUNCTION, self.symbol[first << 3 | 4] & 255)
        elif action == RULE_NEGATIVE or action == RULE_UNARY:
            self._negative(first, action)
        elif action == RULE_NAME:
            self._name(self.symbol[first << 3 | 2] + 1, self.symbol[first << 3 | 3] - 1)
        elif action == RULE_SETTING:
            # A target that is a name has no instruction but that.
            self._emit(SET_NAMED if self.code[self.symbol[(first + 1) << 3 | 1]] & 255 == NAME else SET, 0)
            self.depth -= 2
        elif action == RULE_COMMENT or action == RULE_MESSAGE or action == RULE_OUTPUT:
            self._remark(
                COMMENT if action == RULE_COMMENT else (MESSAGE if action == RULE_MESSAGE else OUTPUT), first
            )
        elif action == RULE_WORD_OF_FUNCTION:
            self._emit(FUNCTION, self.symbol[first << 3 | 4] & 255)
            self._emit(WORD, 105)
            self.depth -= 1
        else:
            return self._act_rarely(action, first)
        return 0

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _act_rarely(self, action: cython.int, first: cython.int) -> cython.int:
        """Write the code of a rule that is not in most lines."""
        if action == RULE_ARC_TANGENT:
            self._emit(ARC_TANGENT, 0)
            self.depth -= 1
        elif action == RULE_SLOPE:
            self._emit(SLOPE, 0)
        elif action == RULE_POWER_OF:
            self._emit(BINARY, POWER)
            self.depth -= 1
        elif action == RULE_EXISTS:
            self._exists(first + 3)
        elif action == RULE_BSPLINE:
            self.alike = False
            self._constant(_BSPLINE)
            self._emit(WORD, 103)
            self.depth -= 1
        elif action == RULE_NUMBERED_LABEL:
            self._push_number(first, 1)
        elif action == RULE_NAMED_LABEL:
            self._named_label(first)
        elif action == RULE_O_WORD:
            self._flow(
                self.symbol[(first + 1) << 3 | 4] & 255, self.depth - (self.symbol[(first + 1) << 3 | 4] >> 8)
            )
        elif action == RULE_PROGRAM_NUMBER:
            self._flow(PROGRAM, 0)
        elif action == RULE_IF_GOTO or action == RULE_GOTO:
            self._flow(GOTO, 1 if action == RULE_IF_GOTO else 0)
        elif action == RULE_WHILE_DO or action == RULE_END_DO:
            self._push_number(self.top, 0)
            self._flow(WHILE_DO if action == RULE_WHILE_DO else END_DO, self.depth - 1)
        elif action == RULE_THEN:
            self._emit(THEN, 0)
            self.depth -= 1
        elif action == RULE_COMPUTED_LABEL:
            self.flags |= COMPUTED_LABEL
        return 0

    @cython.cfunc
    @cython.exceptval(check=False)
    def _flow(self, keyword: cython.int, count: cython.int) -> cython.void:
        """Write a jump, loop or call with `count` values beside its label (or the line, or the number of the loop)."""
        self._emit(FLOW, keyword)
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
            self._emit(INCREMENTS, 0)
        self._emit(WORD, letter)
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
        if code & 255 == NAME:
            self.code[self.symbol[k << 3 | 1]] = NAMED + (code & ~255)
        elif code & 255 == NUMBER and self.used == self.symbol[k << 3 | 1] + 1:
            value = self.constants[self.numbers - 1]
            # Which instruction it is hangs on the number, which behind a bracket is not of the shape.
            self.alike = self.alike and self.text[self.begin + self.symbol[k << 3 | 2]] != 91
            if 0.0 < value < self.stored and value == cython.cast(cython.int, value):
                self.numbers -= 1
                self.code[self.used - 1] = STORED + 256 * cython.cast(cython.int, value)
            else:
                self._emit(PARAMETER, 0)
        else:
            self._emit(PARAMETER, 0)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _exists(self, k: cython.int) -> cython.void:
        """Write the instruction that tests whether a parameter exists."""
        code: cython.int = self.code[self.symbol[k << 3 | 1]]
        if code & 255 == NAME:
            self.code[self.symbol[k << 3 | 1]] = EXISTS_NAMED + (code & ~255)
        else:
            self._emit(EXISTS, 0)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _negative(self, first: cython.int, action: cython.int) -> cython.void:
        """Write the instruction that negates the value on top, unless the sign is plus."""
        last: cython.int = self.used - 1
        if action == RULE_UNARY and self.symbol[first << 3 | 4] & 255 != SUBTRACT:
            return
        if self.code[last] & 255 == NUMBER and last == self.symbol[(first + 1) << 3 | 1]:
            self.constants[self.numbers - 1] = -self.constants[self.numbers - 1]
        elif self.code[last] == NEGATIVE:
            self.used -= 1
        else:
            self._emit(NEGATIVE, 0)

    @cython.cfunc
    @cython.exceptval(-1, check=False)
    def _name(self, begin: cython.int, end: cython.int) -> cython.int:
        """Write a name that stands between two places of the line."""
        key: bytes = bytes(self.text[self.begin + begin : self.begin + end])
        self._emit(NAME, self.name(key))
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
        digits: cython.int = 0
        decimals: cython.int = 0
        dotted: cython.bint = False
        negative: cython.bint = False
        value: cython.double
        c: cython.int
        i: cython.Py_ssize_t
        for i in range(begin, end):
            c = self.text[i]
            if 48 <= c <= 57:
                mantissa = mantissa * 10 + cython.cast(cython.ulonglong, c - 48)
                digits += 1
                decimals += dotted
            elif c == 46:
                dotted = True
            elif c == 45:
                negative = True
        value = decimal(mantissa, digits, decimals)
        if value != value:
            return self._long_number(begin, end)
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
