# cython: infer_types=True
"""Read lines of languages whose rules make values, by the tables of their grammars, into the instructions that `gcode_run` runs.

A line is taken if it has words of motions and settings of R or Q parameters alone, by numbers, these parameters and their arithmetic. The
arguments of `LanguageCode` give the terminals and rules of a grammar that are read here; all others refuse the line, which `grammar_values`
reads then. Lines of one shape have one code (`gcode_lines`).
"""

import cython
from cython.cimports.cncgen.kernels.decimals import is_blank
from cython.cimports.cncgen.kernels.gcode_codes import (
    BINARY, CALLS, COUNTS, ELEMENT, FUNCTION, GOES, JUMP, LEAVES, LETTERS, NAME, NAMED, NEGATIVE, NUMBER, PARAMETER, REPEATS, SAYS, SET,
    SET_ELEMENT, SET_STORED, SET_VARIABLE, STORED, TURNS, UNLESS, WHEN, WORD, WORK_ARGUMENTS, WORK_CALL, WORK_COUNTS, WORK_ELEMENT,
    WORK_FAST, WORK_FUNCTION, WORK_GOES, WORK_LABEL, WORK_MOTION, WORK_NAMED, WORK_NUMBER, WORK_OPERATION, WORK_OPERATOR, WORK_PARAMETER,
    WORK_PI, WORK_RADIUS, WORK_REPEATS, WORK_SETTING, WORK_SIGN, WORK_TARGET, WORK_UNLESS, WORK_WHEN, WORK_WORD,
)  # fmt: skip
from cython.cimports.cncgen.kernels.gcode_lines import Code

from cncgen.kernels.gcode_codes import WORKS

#: The letters of axes, as bits.
_AXES = cython.declare(cython.uint, sum(1 << (ord(letter) - 97) for letter in "xyzabcuvw"))
_FEED = cython.declare(cython.uint, 32)
_PI_VALUE = cython.declare(cython.double, 3.141592653589793)
#: The name by which lines read the feed of the tool.
TOOL_FEED = "FAUTO"


@cython.cfunc
@cython.exceptval(check=False)
def _code_end(
    text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, size: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """Return where the code of a numbered line ends, before its comment; -1 where the comment may go on in the next line (~)."""
    end: cython.Py_ssize_t = at
    while end < size and text[end] != 59:
        end += 1
    at = end
    while at < size:
        if text[at] == 126:
            return -1
        at += 1
    return end


@cython.cfunc
@cython.exceptval(check=False)
def _behind_number(
    text: cython.const[cython.uchar][::1], at: cython.Py_ssize_t, size: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """Return where a line's code begins behind its number, if it has one; -1 where that is not certain, as in one that is set in far."""
    begin: cython.Py_ssize_t = at
    named: cython.bint
    while at < size and is_blank(text[at]):
        at += 1
    if at == size:
        return size
    if at - begin > 3:
        return -1
    named = text[at] | 32 == 110
    at += named
    begin = at
    while at < size and 48 <= text[at] <= 57:
        at += 1
    if at == begin:
        return -1 if named else at
    if at < size and not is_blank(text[at]):
        return -1
    while at < size and is_blank(text[at]):
        at += 1
    return at


@cython.final
@cython.cclass
class LanguageCode(Code):
    """The code of lines of a language; `flags` has `SAYS` and the letters of a line's words.

    Args:
        fixed: Letters whose digits are of the shape of a line, since they choose its code.
        tables: A module of tables (``grammars/tables_*.py``).
        terminals: The terminals of lines that are taken.
        leading: The terminals of jumps, and of what they lead to: of lines that are taken where jumps are followed.
        works: The work of each rule (`gcode_codes.WORKS`), by alias or name.
        words: Letters of words.
        parameter: The letter of parameters, a small one; `most` is the largest number of one, `least` the smallest.
        operators, functions: By their names, in capitals.
        values: Numbers that names stand for.
        headed: Whether a motion begins with L, and a line with a number that is not of the grammar.
    """

    known: cython.int[::1]
    operators = cython.declare(dict)
    functions = cython.declare(dict)
    letters = cython.declare(cython.uint)
    given = cython.declare(cython.uint)
    letter = cython.declare(cython.int)
    least = cython.declare(cython.longlong)
    most = cython.declare(cython.longlong)
    values = cython.declare(dict)
    variables = cython.declare(set)
    follows = cython.declare(cython.bint)
    goes = cython.declare(cython.bint)
    headed = cython.declare(cython.bint)
    fast = cython.declare(cython.bint)

    def __init__(
        self,
        fixed,
        tables,
        terminals,
        leading,
        works,
        words,
        parameter,
        least,
        most,
        operators,
        functions,
        values,
        headed,
    ):
        Code.__init__(self, tables, {name: WORKS[work] for name, work in works.items()}, -1)
        missing = sorted((terminals | leading) - set(tables.TERMINALS)) + sorted(
            works.keys() - {name for name, _, _ in tables.RULES}
        )
        if missing:
            raise ValueError(f"the grammar has no {missing[0]}")
        self.known = memoryview(bytearray(4 * (self.end + 1))).cast("i")
        for k, name in enumerate(tables.TERMINALS):
            self.known[k] = 1 if name in terminals else 2 if name in leading else 0
        for k, (name, _, parts) in enumerate(tables.RULES):
            if not name and -1 not in parts and (self.length[k] < 3 or parts[0] & 1 == 0):
                # A list, or a part that is passed on. A list of three symbols has commas: more than two arguments.
                self.made[k] = 0
            self.silent[k] = self.made[k] == 0 and self.length[k] == 1
        self.letters = sum(1 << (ord(letter) - 97) for letter in words)
        self.letter, self.least, self.most = ord(parameter), least, most
        self.operators, self.functions, self.values, self.headed = operators, functions, values, headed
        self.variables = set()
        self.follows = self.goes = False
        self.shaped = self.remarks = True
        self.fixed, self.comma = fixed, headed

    def follow(self):
        """Take lines with jumps, labels and variables from now on."""
        self.follows = True

    def define(self, names):
        """Take lines with variables of these names, and no others."""
        self.variables = names

    @cython.cfunc
    def write(self, at: cython.Py_ssize_t, end: cython.Py_ssize_t) -> cython.int:
        """Write the code of a line (`Code.write`)."""
        used: cython.int = self.used
        self.given = 0
        self.fast = self.goes = False
        if self.headed:
            end = _code_end(self.text, at, end)
            if end < 0:
                return 0
            at = _behind_number(self.text, at, end)
            if at < 0:
                return 0
        if at < end and self.run(at, end) == 0:
            return 0
        if self.goes:
            self.emit(JUMP, GOES)
        self.flags = cython.cast(cython.longlong, self.given) << LETTERS
        if self.used > used:
            self.flags |= SAYS
        return 1

    @cython.cfunc
    def _shifted(self, kind: cython.int, at: cython.Py_ssize_t) -> cython.int:
        """Keep where a token stands."""
        k: cython.int = self.depth + 1
        if not self.known[kind] or (self.known[kind] == 2 and not self.follows):
            return 0
        self.begins[k], self.ends[k], self.codes[k] = at, self.taken, self.used
        return 1

    @cython.cfunc
    def _reduced(self, rule: cython.int, at: cython.Py_ssize_t) -> cython.int:
        """Write the code of a rule."""
        work: cython.int = self.made[rule]
        count: cython.int = self.length[rule]
        k: cython.int = self.depth - count + 1
        taken: cython.int = 1
        if work < 0:
            return 0
        if count == 0:
            self.begins[k] = self.ends[k] = at
            self.codes[k] = self.used
            return 1
        if work == WORK_NUMBER:
            taken = self.push(self.number(self.begins[k], self.ends[k]))
        elif work == WORK_PARAMETER or work == WORK_ELEMENT:
            taken = self._parameter(k, count, work)
        elif work == WORK_SIGN:
            if self.text[self.begins[k]] == 45:
                self.negate(k + 1)
        elif work == WORK_OPERATOR:
            taken = self._operator(k + 1)
        elif work == WORK_FUNCTION:
            taken = self._function(k, 1)
        elif work == WORK_CALL:
            # The count of arguments stands where the brackets end.
            taken = self._function(k, cython.cast(cython.int, self.ends[k + 1]))
        elif work == WORK_ARGUMENTS:
            # ( value ), or ( value list ).
            self.ends[k] = count - 2
            return count == 3 or count == 4
        elif work == WORK_WORD:
            taken = self.push(self.number(self.begins[k] + 1, self.ends[k])) and self._put(
                self.text[self.begins[k]] | 32, True
            )
        elif work == WORK_NAMED:
            taken = (
                count == 2
                and self.ends[k] == self.begins[k] + 1
                and self._put(self.text[self.begins[k]] | 32, False)
            )
        elif work == WORK_TARGET:
            # That of an element ends below 0.
            if count != 1:
                self.ends[k] = 0 if self._is_parameter(k, 0) else -self.ends[k]
            return count == 1 or count == 4
        elif work == WORK_SETTING or work == WORK_OPERATION:
            taken = self._setting(k, count, work)
        else:
            taken = self._reduced_rarely(work, k, count)
        if count > 1:
            self.ends[k] = self.ends[k + count - 1]
        return taken

    @cython.cfunc
    def _reduced_rarely(self, work: cython.int, k: cython.int, count: cython.int) -> cython.int:
        """Write the code of a rule that a line has once, if at all."""
        if work == WORK_RADIUS:
            # R0 alone ends a compensation that is not in force.
            return (
                count == 2
                and self.ends[k + 1] == self.begins[k + 1] + 1
                and self.text[self.begins[k + 1]] == 48
            )
        if work == WORK_MOTION:
            return self._motion(k)
        if work == WORK_FAST:
            return self._fast(self.text[self.ends[k] - 1] | 32)
        if work == WORK_PI:
            self.alike = False
            return self.push(_PI_VALUE)
        return self._jumping(work, k, count) if work >= WORK_UNLESS else 1

    # The parts of a line.

    @cython.cfunc
    def _is_parameter(self, k: cython.int, digits: cython.int) -> cython.int:
        """Tell whether a token is the letter of parameters, with digits behind it or without."""
        long: cython.bint = self.ends[k] > self.begins[k] + 1
        return self.text[self.begins[k]] | 32 == self.letter and long == (digits > 0)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _index(self, k: cython.int) -> cython.longlong:
        """Return the number of a parameter, -1 where the token is none that is taken."""
        found: cython.longlong = 0
        if not self._is_parameter(k, 1) or self.ends[k] - self.begins[k] > 8:
            return -1
        for i in range(self.begins[k] + 1, self.ends[k]):
            if not 48 <= self.text[i] <= 57:
                return -1
            found = 10 * found + self.text[i] - 48
        return found if self.least <= found <= self.most else -1

    @cython.cfunc
    def _parameter(self, k: cython.int, count: cython.int, work: cython.int) -> cython.int:
        """Write the reading of a parameter: R5, R[…], -Q5."""
        if work == WORK_ELEMENT:
            if count == 1:
                return self._named(NAMED, k)
            if count != 4:
                return 0
            if not self._is_parameter(k, 0):
                return self._named(ELEMENT, k)
            self.emit(PARAMETER, 0)
            return 1
        index = self._index(k + count - 1)
        if index < 0:
            return 0
        self.emit(STORED, index)
        if count == 2 and self.text[self.begins[k]] == 45:
            self.emit(NEGATIVE, 0)
        return 1

    @cython.cfunc
    def _operator(self, k: cython.int) -> cython.int:
        """Write the operator that stands at a place of the stack."""
        name: bytes = bytes(self.text[self.begins[k] : self.ends[k]])
        number = self.operators.get(name.upper())
        if number is None:
            return 0
        self.emit(BINARY, number)
        return 1

    @cython.cfunc
    def _function(self, k: cython.int, count: cython.int) -> cython.int:
        """Write a function of so many values, whose name stands at a place of the stack."""
        name: bytes = bytes(self.text[self.begins[k] : self.ends[k]])
        number = self.functions.get((name.upper(), count))
        if number is None:
            return 0
        self.emit(FUNCTION if count == 1 else BINARY, number)
        return 1

    @cython.cfunc
    def _put(self, letter: cython.int, fixed: cython.bint) -> cython.int:
        """Write a word of the value on top; return 0 where it is not taken."""
        if not 97 <= letter <= 122 or not self.letters >> (letter - 97) & 1:
            return 0
        if letter == 103 or letter == 109:
            if self.numbers == self.base:
                return 0
            value = self.constants[self.numbers - 1]
            fixed = fixed or self.code[self.used - 1] & 255 == NUMBER
            if not fixed or not (
                value == 0.0
                or value == 1.0
                or value == 2.0
                or value == 3.0
                or (letter == 109 and 4.0 <= value <= 9.0 and value != 6.0)
            ):
                return 0
            if letter == 109 and (value < 3.0 or value != cython.cast(cython.int, value)):
                return 0
            # The digits of a code are of the shape of its line, and no number of it.
            self.numbers -= 1
            self.used -= 1
            self.emit(NAME, cython.cast(cython.int, value))
        return self._emit_word(letter)

    @cython.cfunc
    def _emit_word(self, letter: cython.int) -> cython.int:
        """Write a word of the value on top."""
        self.given |= cython.cast(cython.uint, 1) << (letter - 97)
        self.emit(WORD, letter)
        return 1

    @cython.cfunc
    def _fast(self, last: cython.int) -> cython.int:
        """Write what FMAX or FAUTO says, by its last letter."""
        if last == 120:
            self.fast = True
        elif last == 111:
            self.emit(NAMED, self.name_number(TOOL_FEED))
            self._emit_word(102)
        return last == 120 or last == 111

    @cython.cfunc
    def _setting(self, k: cython.int, count: cython.int, work: cython.int) -> cython.int:
        """Write a setting: R1=, R[…]=, X=, Q1 =, FN 0: Q1 =, FN 1: Q1 = a + b, FN 5: Q1 = SQRT a."""
        fn: cython.int
        if work == WORK_OPERATION or count == 5:
            if work == WORK_OPERATION and count == 7:
                fn = self.text[self.ends[k] - 1]
                # Each of FN 1 to FN 4 has its operator, which the grammar tells of FN 8 and FN 13 alone.
                if (
                    49 <= fn <= 52
                    and self.text[self.ends[k] - 2] != 49
                    and self.text[self.begins[k + 5]] | 32 != b"+-*d"[fn - 49] | 32
                ):
                    return 0
                if self._operator(k + 5) == 0:
                    return 0
            elif work == WORK_OPERATION and (count != 6 or self._function(k + 4, 1) == 0):
                return 0
            k += 2
        elif self.ends[k] == 0:
            self.emit(SET, 0)
            return 1
        elif self.ends[k] < 0:
            self.ends[k] = -self.ends[k]
            return self._named(SET_ELEMENT, k)
        index = self._index(k)
        if index >= 0:
            self.emit(SET_STORED, index)
            return 1
        if not self.headed and self.ends[k] != self.begins[k] + 1:
            if (
                self.ends[k] == self.begins[k] + 2
                and self.text[self.begins[k]] | 32 == 99
                and self.text[self.begins[k] + 1] | 32 == 114
            ):
                # CR is R of G-code.
                return self._emit_word(114)
            return self._named(SET_VARIABLE, k)
        if self.headed or self.text[self.begins[k]] | 32 == 103:
            return 0
        return self._put(self.text[self.begins[k]] | 32, False)

    @cython.cfunc
    def _named(self, operation: cython.int, k: cython.int) -> cython.int:
        """Write the reading or setting of a variable whose name stands at a place of the stack; a name may be that of a number."""
        token: bytes = bytes(self.text[self.begins[k] : self.ends[k]])
        name: str = token.decode().upper()
        # Digits of a name are no number that is pushed, and a constant is one that is not written.
        self.alike = self.alike and token == token.translate(None, b"0123456789") and name not in self.values
        if operation == NAMED and name in self.values:
            return self.push(self.values[name])
        if not self.follows and name not in self.variables:
            return 0
        self.emit(operation, self.name_number(name))
        return 1

    @cython.cfunc
    def _jumping(self, work: cython.int, k: cython.int, count: cython.int) -> cython.int:
        """Write a jump, or pass a label."""
        if work == WORK_LABEL:
            # LBL 0 ends a subprogram.
            if count > 1 and bytes(self.text[self.begins[k + 1] : self.ends[k + 1]]).strip(b'"') == b"0":
                self.emit(JUMP, LEAVES)
            return 1
        if work == WORK_GOES:
            self.goes = True
            return 1
        if work == WORK_WHEN:
            if count > 1 and self._operator(k + 4) == 0:
                return 0
            self.goes = False
        elif work == WORK_REPEATS and count == 3:
            self.emit(JUMP, CALLS)
            return 1
        elif work == WORK_REPEATS and (count != 4 or self.used != self.codes[k + 3] + 1):
            return 0
        elif work == WORK_COUNTS:
            self.emit(JUMP, COUNTS)
            if self.ends[k + 1] <= 0:
                return 0
            index = self._index(k + 1)
            if index < 0:
                return self._named(SET_VARIABLE, k + 1)
            self.emit(SET_STORED, index)
            return 1
        self.emit(
            JUMP,
            UNLESS
            if work == WORK_UNLESS
            else WHEN
            if work == WORK_WHEN
            else REPEATS
            if work == WORK_REPEATS
            else TURNS,
        )
        return 1

    @cython.cfunc
    def _motion(self, k: cython.int) -> cython.int:
        """Write the code of a motion: a line with an axis, of traverse or feed."""
        if (
            self.ends[k] != self.begins[k] + 1
            or self.text[self.begins[k]] | 32 != 108
            or not self.given & _AXES
            or (self.fast and self.given & _FEED)
        ):
            return 0
        self.emit(NAME, 0 if self.fast else 1)
        self.emit(WORD, 103)
        return 1
