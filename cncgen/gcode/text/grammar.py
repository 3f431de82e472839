"""One block of text to `Parsed` by the tables of the grammar, or a `BlockError` that says what was expected.

The kernel `gcode_parse` reads the line into instructions; here they become values.
"""

from __future__ import annotations

import re

from cncgen.gcode.block import OUTPUT, PROGRAM, Flow, Parsed, Value, program_names
from cncgen.gcode.errors import BlockError
from cncgen.gcode.state.predefined import asks_state
from cncgen.gcode.text import expressions
from cncgen.gcode.text.parsers import parser
from cncgen.gcode.text.syntax_hints import hint_for, missing_number, number_hint
from cncgen.kernels import gcode_parse

#: Names of the grammar's tokens in messages.
_NAMES = {
    "WORD": "a word",
    "LETTER": "a word",
    "NAMED": "a word",
    "BSPLINE": "a word",
    "CORNER": "a word",
    "NUMBER": "a number",
    "NAME": "a name <…>",
    "COMMENT": "a comment",
    "MESSAGE": "a comment",
    "I_FUNCTION": "a word",
    "OUTPUT": "an output command",
    "FUNCTION": "a function",
    "ATAN": "a function",
    "EXISTS": "a function",
    "LOGIC": "an operator",
    "RELATION": "an operator",
    "TIMES": "an operator",
    "POWER": "an operator",
    "SIGN": "an operator",
    "PLUS": "a sign",
    "MINUS": "a sign",
    "KEYWORD": "an O-word's keyword",
    "HASH": "#",
    "EQUAL": "=",
    "LSQB": "[",
    "RSQB": "]",
    "SLASH": "/",
    "COMMA": "a comma",
    "OVER": "/[",
    "DELETE": "/",
    "LINE_NUMBER": "a line number N",
    "O": "an O-word",
    "O_NAME": "an O-word",
    "O_NUMBER": "an O-word",
    **dict.fromkeys(("IF", "GOTO", "GO", "WHILE", "WH", "DO", "END", "EN"), "a jump or loop of a macro"),
    **dict.fromkeys(("ATN", "POW"), "a function"),
    "$END": "the end of the block",
}
#: Keywords that stand behind a condition.
_FOLLOWERS = {"GOTO", "THEN", "DO"}
#: Tokens that never stand within brackets (a comma does in ATAN alone).
_OUTSIDE = (
    "WORD",
    "LETTER",
    "NAMED",
    "BSPLINE",
    "CORNER",
    "COMMENT",
    "MESSAGE",
    "I_FUNCTION",
    "OUTPUT",
    "KEYWORD",
    "EQUAL",
    "COMMA",
    "$END",
)
_KEYWORD = re.compile(r"[A-Za-z]+")
#: A command to grbl: ``$H``, ``$110=500``, ``$J=G91 X1``, and those of one character.
_TO_GRBL = re.compile(r"\s*(?:\$(?:[$#GgIiNnCcHhXx]\s*(?:;|\Z)|[0-9]+\s*=|[Jj]\s*=)|[?~!]\s*(?:;|\Z))")
#: Outside comments, capital letters mean the same as small ones (of ASCII: no other character is a letter here), and blanks nothing.
_BARE = {**{c: c + 32 for c in range(ord("A"), ord("Z") + 1)}, **dict.fromkeys(b" \t\r")}
_PIECE = re.compile(r"\([^)]*\)?|;.*|[ \t\r]+")


def normalise(text: str) -> str:
    """Return the block without blanks and in lower case, comments as they are."""

    if "(" not in text and ";" not in text:
        return text.translate(_BARE)
    parts = []
    place = 0
    for match in _PIECE.finditer(text):
        piece = match.group()
        parts.append(text[place : match.start()].translate(_BARE))
        parts.append(piece if piece[0] in "(;" else "")
        place = match.end()
    parts.append(text[place:].translate(_BARE))
    return "".join(parts)


_OPERATIONS = {number: name for name, number in gcode_parse.OPERATIONS.items()}
_LITERALS = {number: text for text, number in gcode_parse.LITERALS.items() if "[" not in text}


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
    if reader.error >= 0:
        raise syntax_error(data, reader)
    parsed = _Values(reader, data, expressions.FANUC if dialect == "fanuc" else expressions.LINUXCNC).parsed()
    parsed.deletable = bool(reader.flags & gcode_parse.DELETED)
    if reader.flags & gcode_parse.NUMBERED:
        parsed.number = normalise(data[reader.number_begin : reader.number_end].decode())[1:]
    return parsed


class _Values:
    """Makes values of the instructions of a line."""

    def __init__(self, reader: gcode_parse.Parser, data: bytes, arithmetic: expressions.Arithmetic) -> None:
        self._reader = reader
        self._data = data
        self._arithmetic = arithmetic
        self._stack: list[Value | str] = []
        self._asks = False
        self._into = self._parsed = Parsed()

    def parsed(self) -> Parsed:
        """Return the block."""
        code, at = self._reader.code, 0
        while code[at]:
            operation, operand = _OPERATIONS[code[at] & 255], code[at] >> 8
            at += 1
            if operation in ("COMMENT", "MESSAGE", "OUTPUT"):
                self._comment(operation, operand, code[at])
                at += 1
            elif operation == "FLOW":
                self._flow(_LITERALS[operand], code[at])
                at += 1
            else:
                self._step(operation, operand)
        return self._parsed

    def _comment(self, operation: str, begin: int, length: int) -> None:
        text = self._data[begin : begin + length].decode("utf-8", "surrogateescape")
        if operation == "OUTPUT":
            self._into.comments.append(
                OUTPUT + _KEYWORD.sub(lambda match: match[0].upper(), text, count=1).strip()
            )
        elif text[0] == "(":
            self._parsed.comments.append(text[1:-1])
        elif text[0] != ";":
            name = normalise(text).lstrip("o").strip("<>")
            if name not in program_names:
                program_names.append(name)
            self._into.words.append((PROGRAM, float(program_names.index(name))))

    def _flow(self, keyword: str, count: int) -> None:
        values = (
            self._stack[len(self._stack) - count :] if keyword not in ("goto", "while-do", "end-do") else []
        )
        del self._stack[len(self._stack) - len(values) :]
        label = self._stack.pop()
        arguments = tuple(v for v in (*values, *self._stack) if not isinstance(v, str))
        self._parsed.flow = Flow(keyword, label, arguments, asks_state=self._asks)
        self._stack.clear()

    def _step(self, operation: str, operand: int) -> None:
        stack = self._stack
        if operation == "NUMBER":
            stack.append(self._reader.constants[operand])
        elif operation == "STORED":
            stack.append(expressions.parameter(float(operand)))
        elif operation == "NAME":
            stack.append(self._reader.names[operand])
        elif operation in ("NAMED", "PARAMETER"):
            target = self._reader.names[operand] if operation == "NAMED" else stack.pop()
            self._asks = self._asks or asks_state(target)
            stack.append(expressions.parameter(target))
        elif operation in ("EXISTS", "EXISTS_NAMED"):
            stack.append(
                expressions.exists(
                    self._reader.names[operand] if operation == "EXISTS_NAMED" else stack.pop()
                )
            )
        elif operation == "WORD":
            self._into.words.append((letter_of(operand), self._pop()))
        elif operation in ("SET", "SET_NAMED"):
            value = self._pop()
            self._into.settings.append((stack.pop(), value))
        elif operation == "THEN":
            self._into = Parsed()
            self._parsed.flow = Flow("then", None, (self._pop(),), self._into)
        else:
            stack.append(self._computed(operation, operand))

    def _computed(self, operation: str, operand: int) -> Value:
        arithmetic = self._arithmetic
        last = self._pop()
        if operation == "BINARY":
            return expressions.binary(_LITERALS[operand], self._pop(), last, arithmetic)
        if operation == "FUNCTION":
            return expressions.unary(_LITERALS[operand], last, arithmetic)
        if operation == "ARC_TANGENT":
            return expressions.arc_tangent(self._pop(), last, arithmetic)
        if operation == "SLOPE":
            return expressions.arc_tangent(last, None, arithmetic)
        if operation == "INCREMENTS":
            return expressions.increments(last)
        return expressions.negative(last)

    def _pop(self) -> Value:
        value = self._stack.pop()
        assert not isinstance(value, str)
        return value


def syntax_error(data: bytes, reader: gcode_parse.Parser) -> BlockError:
    """Say what stands where the last line, the text of `data`, was refused, and what could."""
    text, start = (
        data.decode("utf-8", "surrogateescape"),
        data[: reader.error].decode("utf-8", "surrogateescape"),
    )
    before, rest = normalise(start), normalise(text[len(start) :])
    column = len(start) + 1 if rest else len(text.rstrip()) + 1
    if rest.startswith(("(", ")")):
        return _comment_error(rest, column)
    if _TO_GRBL.match(text):
        message = f"{text.split(';')[0].strip()} is a command to grbl, not a block of a program"
        hint = (
            "leave it out; $H and $J move the machine" if re.match(r"\s*\$[hHjJ]", text) else "leave it out"
        )
        return BlockError("syntax", message, column=len(text) - len(text.lstrip()) + 1, hint=hint)
    letter = missing_number(before, rest)
    if letter:
        hint = number_hint(letter, before, rest)
        return BlockError("syntax", f"{letter} has no number", column=column, hint=hint)
    return BlockError(
        "syntax",
        f"{_found(rest)} where {_any_of(_expected_names(before, sorted(reader.expected())))} was expected",
        column=column,
        hint=hint_for(before, rest),
    )


def _comment_error(rest: str, column: int) -> BlockError:
    """Say what is wrong with the parenthesis that begins the rest of a block."""
    if rest.startswith(")"):
        return BlockError("syntax", "a ) with no comment to close", column=column)
    if "(" in rest[1 : rest.find(")")] and ")" in rest:
        return BlockError("nested-comment", "a comment in a comment", column=column)
    return BlockError("open-comment", "a comment ( without its )", column=column, hint="close it on its line")


def _found(rest: str) -> str:
    """Return what is called the first character of the rest of a block."""
    if not rest:
        return "the end of the block"
    first = rest[0]
    if ord(first) < 0x80:
        return f"'{first}'" if first.isprintable() else f"byte 0x{ord(first):02x}"
    import unicodedata

    shown = f"'{first}'" if first.isprintable() else "the character"
    return f"{shown} U+{ord(first):04X} ({unicodedata.name(first, 'without a name').lower()})"


def _expected_names(before: str, expected: list[str]) -> list[str]:
    """Return what people call the tokens that could stand behind the text before."""
    if before.count("[") > before.count("]"):
        # The parser's states do not tell how a value ends; tokens that cannot stand within brackets are left out.
        expected = [name for name in expected if name not in _OUTSIDE]
    if "O_NUMBER" not in expected:
        # Behind a word, the name of a program may stand there, which few blocks have.
        expected = [name for name in expected if name != "O_NAME"]
    named = {} if set(expected) <= _FOLLOWERS else _NAMES
    return list(dict.fromkeys(named.get(name, name) for name in expected))


def _any_of(names: list[str]) -> str:
    """Return "a, b or c"."""
    if len(names) < 2:
        return names[0] if names else "nothing more"
    return ", ".join(names[:-1]) + " or " + names[-1]
