# cython: infer_types=True
"""Read lines of G-code by the tables of their grammar (``grammars/lalr.py``) into small programs for `gcode_run`.

Each rule's action (`gcode_codes.ACTIONS`) writes instructions (`gcode_lines.Code`). Nothing is judged: where the grammar has no
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
from cython.cimports.cncgen.kernels.gcode_codes import (
    ARC_TANGENT, BINARY, COMMENT, COMPUTED_LABEL, DELETED, END_DO, EXISTS, EXISTS_NAMED, FLOW, FUNCTION, GOTO, INCREMENTS,
    LETTERS,
    MESSAGE, NAME, NAMED, NUMBER, NUMBERED, OUTPUT, PARAMETER, POWER, PROGRAM, RULE_ARC_TANGENT,
    RULE_BINARY, RULE_BRACKET, RULE_BSPLINE, RULE_COMMENT, RULE_COMPUTED_LABEL, RULE_END_DO, RULE_EXISTS, RULE_FUNCTION, RULE_GOTO,
    RULE_IF_GOTO, RULE_MESSAGE, RULE_NAME, RULE_NAMED_LABEL, RULE_NEGATIVE, RULE_NUMBER, RULE_NUMBERED_LABEL, RULE_OUTPUT,
    RULE_O_WORD, RULE_PARAMETER, RULE_PLAIN_WORD, RULE_POWER_OF, RULE_PROGRAM_NUMBER, RULE_SETTING, RULE_SLOPE, RULE_THEN,
    RULE_UNARY, RULE_WHILE_DO, RULE_WORD, RULE_WORD_OF_FUNCTION, SET, SET_NAMED, SLOPE, STORED, SUBTRACT, THEN, WHILE_DO, WORD,
)  # fmt: skip
from cython.cimports.cncgen.kernels.gcode_lines import Code

from cncgen.kernels.gcode_codes import ACTIONS
from cncgen.kernels.gcode_lines import zeros
from cncgen.kernels.grammar_tables import rows_of

#: Number of BSPLINE of Siemens among the G codes (`cncgen.gcode.block`).
_BSPLINE = cython.declare(cython.double, 1060.0)

#: Letters whose numbers without a decimal point count in least increments, as bits (A is bit 0).
_LENGTHS = cython.declare(cython.uint, sum(1 << (ord(letter) - 97) for letter in "xyzabcuvwijkqr"))


@cython.final
@cython.cclass
class Parser(Code):
    """The tables of a grammar of G-code, and what reads lines by them.

    Args:
        tables: A module of tables (``grammars/tables_*.py``).
        stored: Numbered parameters below this are plain storage.
        increments: Whether lengths without a decimal point count in least increments.
    """

    literal: cython.const[cython.short][::1]
    literals: cython.int[::1]
    delete = cython.declare(cython.int)
    line_word = cython.declare(cython.int)
    stored = cython.declare(cython.int)
    brackets = cython.declare(cython.int)
    increments = cython.declare(cython.bint)

    def __init__(self, tables, stored, increments=False):
        Code.__init__(self, tables, ACTIONS, 0)
        for k in range(len(tables.RULES)):
            self.silent[k] = self.made[k] == 0
        self.literal = rows_of(tables.LITERAL)[0]
        self.literals = zeros(4 * self.codes.shape[0]).cast("i")
        self.delete = self.terminals.index("DELETE") if "DELETE" in self.terminals else -1
        self.line_word = self.terminals.index("LINE_NUMBER") if "LINE_NUMBER" in self.terminals else -1
        self.stored = stored
        self.increments = increments
        self.shaped = tables.SHAPED and not increments

    @cython.cfunc
    def write(self, at: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.int:
        """Write the code of a line (`Code.write`)."""
        self.brackets = 0
        return self.run(at, end)

    @cython.cfunc
    def _shifted(self, kind: cython.int, at: cython.Py_ssize_t) -> cython.int:
        """Keep where a token stands, and its literal."""
        k: cython.int = self.depth + 1
        self.begins[k], self.ends[k], self.codes[k] = at, self.taken, self.used
        self.literals[k] = self.literal[self.ended]
        if kind == self.delete:
            self.flags |= DELETED
        elif kind == self.line_word:
            self.flags |= NUMBERED
            self.number_begin, self.number_end = at, self.taken
        return 1

    @cython.cfunc
    def _reduced(self, rule: cython.int, at: cython.Py_ssize_t) -> cython.int:
        """Write the code of a rule."""
        action: cython.int = self.made[rule]
        first: cython.int = self.depth - self.length[rule] + 1
        literal: cython.int = self.literals[first]
        if action == RULE_PLAIN_WORD:
            self._plain_word(self.begins[first], self.ends[first])
        elif action == RULE_NUMBER:
            self._push_number(self.begins[first], self.ends[first])
        elif action == RULE_BINARY:
            self.emit(BINARY, self.literals[first + 1])
        elif action == RULE_PARAMETER:
            self._parameter(first + 1)
        elif action == RULE_WORD:
            self.emit(WORD, literal if literal >= 128 else self.small(self.begins[first]))
        elif action == RULE_FUNCTION:
            self.emit(FUNCTION, literal)
        elif action == RULE_NEGATIVE or action == RULE_UNARY:
            if action == RULE_NEGATIVE or literal == SUBTRACT:
                self.negate(first + 1)
        elif action == RULE_NAME:
            self._name(self.begins[first] + 1, self.ends[first] - 1)
        elif action == RULE_SETTING:
            # A target that is a name has no instruction but that.
            self.emit(SET_NAMED if self.code[self.codes[first + 1]] & 255 == NAME else SET, 0)
        elif action == RULE_COMMENT or action == RULE_MESSAGE or action == RULE_OUTPUT:
            if action == RULE_COMMENT and self._is_nested(self.begins[first], self.ends[first]):
                # A remark may tell of it.
                action = RULE_MESSAGE
            self.emit(
                COMMENT if action == RULE_COMMENT else (MESSAGE if action == RULE_MESSAGE else OUTPUT),
                self.begins[first] - self.begin,
            )
            self._emit_number(self.ends[first] - self.begins[first])
        elif action == RULE_WORD_OF_FUNCTION:
            self.emit(FUNCTION, literal)
            self.emit(WORD, 105)
        elif action == RULE_BRACKET:
            self.brackets += 1
        else:
            return self._reduced_rarely(action, first)
        return 1

    @cython.cfunc
    def _reduced_rarely(self, action: cython.int, first: cython.int) -> cython.int:
        """Write the code of a rule that is not in most lines."""
        if action == RULE_ARC_TANGENT:
            self.emit(ARC_TANGENT, 0)
        elif action == RULE_SLOPE:
            self.emit(SLOPE, 0)
        elif action == RULE_POWER_OF:
            self.emit(BINARY, POWER)
        elif action == RULE_EXISTS:
            code = self.code[self.codes[first + 3]]
            if code & 255 == NAME:
                self.code[self.codes[first + 3]] = EXISTS_NAMED + (code & ~255)
            else:
                self.emit(EXISTS, 0)
        elif action == RULE_BSPLINE:
            self.alike = False
            self.push(_BSPLINE)
            self.emit(WORD, 103)
        elif action == RULE_NUMBERED_LABEL:
            self._push_number(self.begins[first] + 1, self.ends[first])
        elif action == RULE_NAMED_LABEL:
            self._named_label(self.begins[first], self.ends[first])
        elif action == RULE_O_WORD:
            self._flow(self.literals[first + 1])
        elif action == RULE_PROGRAM_NUMBER:
            self._flow(PROGRAM)
        elif action == RULE_IF_GOTO or action == RULE_GOTO:
            self._flow(GOTO)
        elif action == RULE_WHILE_DO or action == RULE_END_DO:
            self._push_number(self.begins[self.depth], self.ends[self.depth])
            self._flow(WHILE_DO if action == RULE_WHILE_DO else END_DO)
        elif action == RULE_THEN:
            self.emit(THEN, 0)
        elif action == RULE_COMPUTED_LABEL:
            self.flags |= COMPUTED_LABEL
        return 1

    @cython.cfunc
    @cython.exceptval(check=False)
    def _emit_number(self, number: cython.int) -> cython.void:
        """Write a number that belongs to the last instruction."""
        self.code[self.used] = number
        self.used += 1

    @cython.cfunc
    @cython.exceptval(check=False)
    def _flow(self, keyword: cython.int) -> cython.void:
        """Write a jump, loop or call with the values in brackets beside its label (or the line, or the number of the loop)."""
        self.flags |= keyword << LETTERS
        self.emit(FLOW, keyword)
        self._emit_number(self.brackets)

    @cython.cfunc
    def _plain_word(self, begin: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.int:
        """Write a letter with its number, which stand between two offsets."""
        letter: cython.int = self.small(begin)
        self._push_number(begin + 1, end)
        if (
            self.increments
            and 97 <= letter <= 122
            and _LENGTHS >> (letter - 97) & 1
            and not self._has(46, begin, end)
        ):
            self.emit(INCREMENTS, 0)
        self.emit(WORD, letter)
        return 1

    @cython.cfunc
    @cython.exceptval(check=False)
    def _is_nested(self, begin: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.bint:
        """Tell whether parentheses stand within the comment in parentheses between two offsets."""
        return self.text[begin] == 40 and self._has(40, begin + 1, end)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _has(self, byte: cython.int, begin: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.bint:
        """Tell whether a byte stands between two offsets."""
        for i in range(begin, end):
            if self.text[i] == byte:
                return True
        return False

    @cython.cfunc
    @cython.exceptval(check=False)
    def _parameter(self, k: cython.int) -> cython.void:
        """Write the instruction that reads the parameter whose number or name is on top."""
        code: cython.int = self.code[self.codes[k]]
        if code & 255 == NAME:
            self.code[self.codes[k]] = NAMED + (code & ~255)
            return
        if code & 255 == NUMBER and self.used == self.codes[k] + 1:
            value = self.constants[self.numbers - 1]
            # Which instruction it is hangs on the number, which behind a bracket is not of the shape.
            self.alike = self.alike and self.text[self.begins[k]] != 91
            if 0.0 < value < self.stored and value == cython.cast(cython.int, value):
                self.numbers -= 1
                self.used -= 1
                self.emit(STORED, cython.cast(cython.int, value))
                return
        self.emit(PARAMETER, 0)

    @cython.cfunc
    def _name(self, begin: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.int:
        """Write a name that stands between two offsets."""
        key: bytes = bytes(self.text[begin:end])
        found = self.numbered.get(key)
        if found is None:
            text: bytes = key.translate(None, b" \t\r").lower()
            try:
                name = text.decode("utf-8")
            except UnicodeDecodeError:
                name = text.decode("cp1252", "replace")
            found = self.numbered[key] = self.name_number(name)
        self.emit(NAME, found)
        return 1

    @cython.cfunc
    def _named_label(self, begin: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.int:
        """Write the name of an O-word: o<100> is o100."""
        while self.text[begin] != 60:
            begin += 1
        self._name(begin + 1, end - 1)
        name: str = self.names[self.code[self.used - 1] >> 8]
        if name.isdecimal():
            self.used -= 1
            self.alike = False
            self.push(float(name))
        return 1

    @cython.cfunc
    def _push_number(self, begin: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.int:
        """Write the number that stands between two offsets: the double nearest to its decimal text."""
        value: cython.double = self.number(begin, end)
        if value != value:
            text: bytes = bytes(self.text[begin:end])
            value = float(text.translate(None, b" \t\r"))
        return self.push(value)
