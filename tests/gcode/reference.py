"""Lark's own parser as the reference of the tables' kernel: a block as instructions, by either, and random blocks of a grammar."""

from __future__ import annotations

import random
import re
from functools import cache
from typing import Any

from cncgen.grammars import lalr
from lark import Lark, Token, Transformer
from lark.exceptions import UnexpectedInput

from cncgen.gcode.flow.running import Runner
from cncgen.gcode.text import grammar, parsers
from cncgen.kernels import gcode_codes, gcode_lines, gcode_parse

Instruction = tuple[Any, ...]
_OPERATIONS = {number: name for name, number in gcode_codes.OPERATIONS.items()}
_LITERALS = {number: text for text, number in gcode_codes.LITERALS.items() if "[" not in text}


class OneByOne(Runner):
    """A run in which every block goes through its handlers, none through arrays."""

    batches = False


def by_tables(text: str, dialect: str) -> tuple[list[Instruction], int] | int:
    """Return the instructions of a block and its flags, or the place where it is refused."""
    parser = grammar.parser(dialect, False)
    parser.used = parser.numbers = 0
    data = text.encode()
    parser.parse(memoryview(data), 0)
    if parser.error >= 0:
        return parser.error
    return instructions(parser, data, 0, 0), parser.flags & 3


def by_shapes(
    texts: list[str], parser: gcode_parse.Parser, kernel: Any = gcode_lines
) -> list[tuple[list[Instruction], int] | int]:
    """Return the same of lines that a parser keeps, one after the other, by their shapes; -1 where one is refused."""
    data = "\n".join(texts).encode()
    rows = memoryview(bytearray(8 * gcode_codes.ROW * (len(texts) + 1))).cast(
        "q", [len(texts) + 1, gcode_codes.ROW]
    )
    lines = kernel.Lines(parser, memoryview(data), rows)
    assert lines.compile(0, 1, 0, len(texts), len(data) + 1) == len(texts)
    found: list[tuple[list[Instruction], int] | int] = []
    for offset, _, at, after, _, marks, _, first in rows[: len(texts)].tolist():
        if marks & gcode_codes.REFUSED:
            found.append(-1)
        else:
            found.append((instructions(parser, data[offset:after], at, first), marks & 3))
    return found


def instructions(parser: gcode_parse.Parser, data: bytes, at: int, first: int) -> list[Instruction]:
    """Return the instructions that begin at `at`, of a line whose constants begin at `first`."""
    found: list[Instruction] = []
    code = parser.code
    while code[at]:
        name, operand = _OPERATIONS[code[at] & 255], code[at] >> 8
        at += 1
        if name == "NUMBER":
            found.append((name, parser.constants[first + operand]))
        elif name in ("NAME", "NAMED", "EXISTS_NAMED"):
            found.append((name, parser.names[operand]))
        elif name in ("COMMENT", "MESSAGE", "OUTPUT", "FLOW"):
            extra = code[at]
            at += 1
            if name == "FLOW":
                found.append((name, _LITERALS[operand], extra))
            else:
                found.append((name, data[operand : operand + extra].decode()))
        elif name == "WORD":
            found.append((name, grammar.letter_of(operand)))
        elif name in ("BINARY", "FUNCTION"):
            found.append((name, _LITERALS[operand]))
        elif name == "STORED":
            found.append((name, operand))
        else:
            found.append((name,))
    return found


class _Postfix(Transformer):
    """Lark callbacks: the children of a rule to the instructions of the rule."""

    stored = 5000

    def __default__(self, data: Any, children: list[Any], meta: Any) -> Any:
        handler = getattr(self, str(data).rpartition("__")[2] or str(data), None)
        return handler(children) if handler else _joined(children)

    def number(self, c: list[Any]) -> Any:
        return [("NUMBER", float(c[0]))]

    def name(self, c: list[Any]) -> Any:
        return [("NAME", c[0][1:-1])]

    def parameter(self, c: list[Any]) -> Any:
        if c[0][0][0] == "NAME":
            return [("NAMED", c[0][0][1])]
        if (
            len(c[0]) == 1
            and c[0][0][0] == "NUMBER"
            and 0 < c[0][0][1] < self.stored
            and c[0][0][1].is_integer()
        ):
            return [("STORED", int(c[0][0][1]))]
        return [*c[0], ("PARAMETER",)]

    def exists(self, c: list[Any]) -> Any:
        return [("EXISTS_NAMED", c[0][0][1])] if c[0][0][0] == "NAME" else [*c[0], ("EXISTS",)]

    def negative(self, c: list[Any]) -> Any:
        if len(c[0]) == 1 and c[0][0][0] == "NUMBER":
            return [("NUMBER", -c[0][0][1])]
        return c[0][:-1] if c[0][-1] == ("NEGATIVE",) else [*c[0], ("NEGATIVE",)]

    def unary(self, c: list[Any]) -> Any:
        return self.negative(c[1:]) if c[0] == "-" else c[1]

    def binary(self, c: list[Any]) -> Any:
        return [*c[0], *c[2], ("BINARY", str(c[1]))]

    def power_of(self, c: list[Any]) -> Any:
        return [*c[0], *c[1], ("BINARY", "**")]

    def function(self, c: list[Any]) -> Any:
        return [*c[1], ("FUNCTION", str(c[0]))]

    def arc_tangent(self, c: list[Any]) -> Any:
        return [*_joined(c), ("ARC_TANGENT",)]

    def slope(self, c: list[Any]) -> Any:
        return [*c[0], ("SLOPE",)]

    def plain_word(self, c: list[Any]) -> Any:
        return [("NUMBER", float(c[0][1:])), ("WORD", c[0][0])]

    def word(self, c: list[Any]) -> Any:
        return [*c[1], ("WORD", str(c[0]).rstrip("="))]

    corner = word

    def word_of_function(self, c: list[Any]) -> Any:
        return [*c[1], ("FUNCTION", str(c[0])[1:-1]), ("WORD", "i")]

    def bspline(self, c: list[Any]) -> Any:
        return [("NUMBER", 1060.0), ("WORD", "g")]

    def setting(self, c: list[Any]) -> Any:
        return [*c[0], *c[1], ("SET_NAMED",) if c[0][0][0] == "NAME" else ("SET",)]

    def comment(self, c: list[Any]) -> Any:
        nested = c[0][0] == "(" in c[0][1:]
        return [("MESSAGE" if nested else "COMMENT", str(c[0]))]

    def message(self, c: list[Any]) -> Any:
        return [("MESSAGE", str(c[0]))]

    def output(self, c: list[Any]) -> Any:
        return [("OUTPUT", str(c[0]))]

    def numbered_label(self, c: list[Any]) -> Any:
        return [("NUMBER", float(c[0][1:]))]

    def named_label(self, c: list[Any]) -> Any:
        name = c[0][c[0].index("<") + 1 : -1]
        return [("NUMBER", float(name))] if name.isdecimal() else [("NAME", name)]

    def computed_label(self, c: list[Any]) -> Any:
        return _joined(c)

    def bracket(self, c: list[Any]) -> Any:
        return [("(",), *_joined(c)]

    def o_word(self, c: list[Any]) -> Any:
        count = sum(child[0] == ("(",) for child in c[2:])
        return [*_joined(c[:1]), *_unmarked(_joined(c[2:])), ("FLOW", str(c[1]), count)]

    def program_number(self, c: list[Any]) -> Any:
        return [*_joined(c), ("FLOW", "program", 0)]

    def if_goto(self, c: list[Any]) -> Any:
        return [*_unmarked(_joined(c)), ("FLOW", "goto", 1)]

    def goto(self, c: list[Any]) -> Any:
        return [*_joined(c), ("FLOW", "goto", 0)]

    def then(self, c: list[Any]) -> Any:
        return [*_unmarked(_joined(c)), ("THEN",)]

    def while_do(self, c: list[Any]) -> Any:
        return [*_unmarked(_joined(c[:-1])), ("NUMBER", float(c[-1])), ("FLOW", "while-do", len(c) - 1)]

    def end_do(self, c: list[Any]) -> Any:
        return [("NUMBER", float(c[0])), ("FLOW", "end-do", 0)]

    def start(self, c: list[Any]) -> Any:
        kinds = {getattr(t, "type", "").rpartition("__")[2] for t in c}
        flags = gcode_codes.DELETED * ("DELETE" in kinds) | gcode_codes.NUMBERED * ("LINE_NUMBER" in kinds)
        return _unmarked(_joined(c)), flags


def _joined(children: list[Any]) -> list[Instruction]:
    return [item for child in children if not isinstance(child, Token) for item in child]


def _unmarked(code: list[Instruction]) -> list[Instruction]:
    return [item for item in code if item != ("(",)]


@cache
def _lark(dialect: str) -> Lark:
    path = lalr.HERE / lalr.GRAMMARS[dialect]
    return Lark.open(str(path), parser="lalr", lexer="contextual", maybe_placeholders=False)


def by_lark(text: str, dialect: str) -> tuple[list[Instruction], int] | int:
    """Return the same by Lark's parser; the text has no blanks and no capital letters."""
    try:
        tree = _lark(dialect).parse(text)
    except UnexpectedInput as error:
        token = getattr(error, "token", None)
        at = error.pos_in_stream
        return len(text) if at is None or (token is not None and token.type == "$END") else at
    postfix = _Postfix()
    postfix.stored = parsers.STORED[dialect]
    return postfix.transform(tree)


#: Examples of terminals.
_TERMINALS = {
    "DELETE": ["/"],
    "LINE_NUMBER": ["n10", "n7.5", "n0012"],
    "WORD": [
        "g1",
        "x-1.5",
        "y.25",
        "z+3.",
        "f100",
        "m3",
        "@5",
        "^90",
        "$1",
        "s1000",
        "x123456789.123456789123",
    ],
    "LETTER": list("gxyzijkfmp@^"),
    "NUMBER": ["0", "1", "2.5", ".5", "3.", "12", "0.125", "007", "31.0", "5420", "4999", "1000"],
    "NAME": ["<a>", "<_b>", "<100>"],
    "O_NUMBER": ["o100", "o1", "o0007"],
    "O_NAME": ["o<a>", "o<100>", "o<_b>"],
    "COMMENT": ["(note)", ";tail", "()", "(a,b)", "(logclosed)"],
    "MESSAGE": ["(msg,hi)", "(debug,#1)", "(logclose)", "(\u00a0print,x)"],
    "OUTPUT": ["popen", "dprnt[x#1[53]]"],
    "NAMED": ["pw=", "pl=", "sd="],
    "CORNER": [",c", ",r"],
    "SIGN": ["+", "-"],
    "I_FUNCTION": ["ifix[", "ifup["],
    "RETURN": ["m99", "m099"],
}


def random_block(dialect: str, dice: random.Random) -> str:
    """Return a random sentence of a grammar; one in five has a few characters changed."""
    out: list[str] = []
    waiting: list[Any] = [("start", False)]
    rules: dict[str, list[Any]] = _rules(dialect)
    while waiting:
        name, terminal = waiting.pop()
        if terminal:
            out.append(dice.choice(_examples(dialect, name)))
            continue
        choices = rules[name]
        # The shortest choices where it has grown long.
        if len(waiting) + len(out) > 25:
            fewest = min(len(r.expansion) for r in choices)
            choices = [r for r in choices if len(r.expansion) == fewest]
        rule = dice.choice(choices)
        waiting += reversed([(str(s.name), s.is_term) for s in rule.expansion])
        if len(out) > 200:
            break
    text = "".join(out)
    if dice.random() < 0.2:
        for _ in range(dice.randint(1, 3)):
            at = dice.randint(0, len(text))
            text = text[:at] + dice.choice("#[]-+=/<>(.oanx1;)") + text[at + dice.randint(0, 1) :]
    return text


def renumbered(text: str, dice: random.Random) -> str:
    """Return the block with other numbers of the same form."""

    def other(match: re.Match[str]) -> str:
        return "".join(dice.choices("0123456789", k=dice.choice([1, 1, 2, 5, dice.randint(1, 20)])))

    return re.sub("[0-9]+", other, text)


@cache
def _rules(dialect: str) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    for rule in _lark(dialect).rules:
        found.setdefault(str(rule.origin.name), []).append(rule)
    return found


@cache
def _examples(dialect: str, name: str) -> list[str]:
    own = _TERMINALS.get(name.rpartition("__")[2])
    if own:
        return own
    terminal = next(t for t in _lark(dialect).terminals if t.name == name)
    literals = (
        [terminal.pattern.value] if terminal.pattern.type == "str" else lalr._literals(terminal.pattern.value)
    )
    assert literals, name
    return literals


def spread(text: str, dice: random.Random) -> str:
    """Return the block with capitals and blanks where they mean nothing."""
    if any(c in text for c in ("(", ";", "<", "prnt", "popen", "pclos")):
        return text
    return "".join(
        dice.choice(["", "", "", " ", "\t"]) + (c.upper() if dice.random() < 0.5 else c) for c in text
    )
