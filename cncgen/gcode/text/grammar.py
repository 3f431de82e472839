"""One block of text to `Parsed` by the tables of the grammar, or a `BlockError` with the expected words.

The kernel `gcode_parse` reads the line into instructions; here they become values.
"""

from __future__ import annotations

import re

from cncgen.gcode.block import OUTPUT, PROGRAM, Flow, Parsed, Value, named_program
from cncgen.gcode.text import expressions
from cncgen.gcode.text.normal_text import normalise
from cncgen.gcode.text.parsers import parser
from cncgen.kernels import gcode_codes, gcode_parse

_KEYWORD = re.compile(r"[A-Za-z]+")
_OPERATIONS = {number: name for name, number in gcode_codes.OPERATIONS.items()}
_LITERALS = {number: text for text, number in gcode_codes.LITERALS.items() if "[" not in text}


def letter_of(code: int) -> str:
    """Return the letter of a word; those of several letters have codes beyond ASCII."""
    return chr(code) if code < 128 else _LITERALS[code].rstrip("=")


def parse(text: str, dialect: str = "linuxcnc", increments: bool = False) -> Parsed:
    """Read one block; with `increments`, lengths without a decimal point are in the control's least increment.

    Raises:
        BlockError: Where it is no block; the column is that of `text`.
    """
    data = text.encode("utf-8", "surrogateescape")
    reader = parser(dialect, increments)
    reader.used = reader.numbers = 0
    reader.parse(memoryview(data), 0)
    if dialect == "fanuc" and (cut := reader.cut()):
        return parse(data[:cut].decode("utf-8", "surrogateescape"), dialect, increments)
    if reader.error >= 0:
        from cncgen.gcode.text.syntax_errors import is_passed, syntax_error

        if is_passed(text):
            return Parsed()
        raise syntax_error(data, reader)
    parsed = _Values(reader, data, expressions.FANUC if dialect == "fanuc" else expressions.LINUXCNC).parsed()
    parsed.deletable = bool(reader.flags & gcode_codes.DELETED)
    if reader.flags & gcode_codes.NUMBERED:
        parsed.number = normalise(data[reader.number_begin : reader.number_end].decode())[1:]
    return parsed


def cut_of(data: bytes) -> int:
    """Return where the slash of a block of FANUC's stands whose rest is passed over, of which a remark tells; else 0."""
    reader = parser("fanuc", False)
    reader.used = reader.numbers = 0
    reader.parse(memoryview(data), 0)
    return reader.cut()


#: Instructions that take values from the stack for good, and letters whose numbers count in increments of a length or an angle.
_TAKERS = frozenset(("WORD", "SET", "SET_NAMED", "THEN", "FLOW", "END"))
_LENGTHS = frozenset("xyzabcuvwijkqr")
#: Codes whose words are arguments.
_CALLS = frozenset((("g", 65.0), ("g", 66.0), ("g", 66.1)))


class _Values:
    """Makes values of the instructions of a line."""

    def __init__(self, reader: gcode_parse.Parser, data: bytes, arithmetic: expressions.Arithmetic) -> None:
        self._reader = reader
        self._data = data
        self._arithmetic = arithmetic
        self._stack: list[Value | str] = []
        self._at = 0
        self._into = self._parsed = Parsed()

    def parsed(self) -> Parsed:
        """Return the block."""
        code, at = self._reader.code, 0
        while code[at]:
            operation, operand = _OPERATIONS[code[at] & 255], code[at] >> 8
            at += 1
            self._at = at
            if operation in ("COMMENT", "MESSAGE", "OUTPUT"):
                self._comment(operation, operand, code[at])
                at += 1
            elif operation == "FLOW":
                self._flow(_LITERALS[operand], code[at])
                at += 1
            else:
                self._step(operation, operand)
        flow, into = self._parsed.flow, self._into
        if flow is not None and flow.then is into and not (into.words or into.settings):
            flow.then = into if flow.keyword == "then" else None
        return self._parsed

    def _comment(self, operation: str, begin: int, length: int) -> None:
        text = self._data[begin : begin + length].decode("utf-8", "surrogateescape")
        if operation == "OUTPUT":
            self._into.comments.append(
                OUTPUT + _KEYWORD.sub(lambda match: match[0].upper(), text, count=1).strip()
            )
        elif text[0] == "(":
            self._into.comments.append(text[1:-1])
        elif text[0] != ";":
            name = normalise(text).lstrip("o").strip("<>")
            self._into.words.append((PROGRAM, float(named_program(name))))

    def _flow(self, keyword: str, count: int) -> None:
        values = (
            self._stack[len(self._stack) - count :] if keyword not in ("goto", "while-do", "end-do") else []
        )
        del self._stack[len(self._stack) - len(values) :]
        label = self._stack.pop()
        arguments = tuple(v for v in (*values, *self._stack) if not isinstance(v, str))
        self._parsed.flow = flow = Flow(keyword, label, arguments)
        self._stack.clear()
        if keyword == "while-do":
            self._into = flow.then = Parsed()

    def _step(self, operation: str, operand: int) -> None:
        stack = self._stack
        if operation == "NUMBER":
            stack.append(self._reader.constants[operand])
        elif operation == "STORED":
            stack.append(expressions.parameter(float(operand), self._arithmetic))
        elif operation == "NAME":
            stack.append(self._reader.names[operand])
        elif operation in ("NAMED", "PARAMETER"):
            target = self._reader.names[operand] if operation == "NAMED" else stack.pop()
            stack.append(expressions.parameter(target, self._arithmetic))
        elif operation in ("EXISTS", "EXISTS_NAMED"):
            stack.append(
                expressions.exists(
                    self._reader.names[operand] if operation == "EXISTS_NAMED" else stack.pop(),
                    self._arithmetic,
                )
            )
        elif operation == "WORD":
            self._into.words.append((letter_of(operand), self._pop()))
        elif operation in ("SET", "SET_NAMED"):
            value = self._pop()
            self._into.settings.append((stack.pop(), value))
        elif operation == "THEN":
            then = Parsed()
            self._into.flow = Flow("then", None, (self._pop(),), then)
            self._into = then
        else:
            stack.append(self._computed(operation, operand))

    def _computed(self, operation: str, operand: int) -> Value:
        arithmetic = self._arithmetic
        last = self._pop()
        if operation == "BINARY":
            return expressions.binary(operand, self._pop(), last, arithmetic)
        if operation == "FUNCTION":
            if self._rounds_length(_LITERALS[operand]):
                return expressions.rounded_to_increment(last)
            return expressions.unary(operand, last, arithmetic)
        if operation == "ARC_TANGENT":
            return expressions.arc_tangent(self._pop(), last, arithmetic)
        if operation == "SLOPE":
            return expressions.arc_tangent(last, None, arithmetic)
        if operation == "INCREMENTS":
            return expressions.increments(last, arithmetic)
        return expressions.negative(last, arithmetic)

    def _rounds_length(self, name: str) -> bool:
        """Tell whether a function is FANUC's ROUND in a word of a length or an angle: the first instruction behind it that takes values.

        Arguments of macros are values of variables.
        """
        if (
            self._arithmetic is not expressions.FANUC
            or name not in ("round", "rnd")
            or not _CALLS.isdisjoint(self._into.words)
        ):
            return False
        code, at = self._reader.code, self._at
        while _OPERATIONS[code[at] & 255] not in _TAKERS:
            at += 1
        return _OPERATIONS[code[at] & 255] == "WORD" and letter_of(code[at] >> 8) in _LENGTHS

    def _pop(self) -> Value:
        value = self._stack.pop()
        assert not isinstance(value, str)
        return value
