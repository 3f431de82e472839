"""One line of SINUMERIK to a statement."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from cncgen.gcode.errors import BlockError

#: An expression: ("n", value), ("s", text), ("r", index), ("var", name, indices), ("fn", name, arguments), ("un", sign, a),
#: ("bin", operator, a, b).
Node = tuple[Any, ...]
#: ("word", letter, node), ("set", name, indices, node), ("poly", indices, nodes), ("call", name, nodes), ("name", name),
#: ("text", string).
Item = tuple[Any, ...]

_STRING = re.compile(r'"[^"\n]*"?|;.*')
_PREFIX = re.compile(
    r"\s*(?P<skip>/\d?)?\s*(?:(?P<number>[N:]\d+)(?![A-Z0-9_]*\s*[:=])\s*)?(?:(?P<label>[A-Z_][A-Z0-9_]+)\s*:(?!=))?"
)
_PLAIN_LINE = re.compile(r"(?:\s*[A-Z][+-]?(?:\d++\.?+\d*+|\.\d+))+\s*\Z")
_PLAIN_WORD = re.compile(r"([A-Z])([+-]?[\d.]+)")
_HEADER = re.compile(r"%_N_(\w+?)_(MPF|SPF)\b|;\$PATH")
#: Common names of the grammar's tokens.
_NAMES = {
    "PLAIN": "a word", "NAME": "a name", "PLAIN_NUMBER": "a number", "EXPONENT": "a number", "STRING": "a text", "EQUAL": "=",
    "LPAR": "(", "RPAR": ")", "LSQB": "[", "RSQB": "]", "COMMA": "a comma", "SIGN": "a sign", "TIMES": "an operator",
    "RELATION": "a comparison", "GOTO": "a jump", "TYPE": "a type", "$END": "the end of the block",
}  # fmt: skip


@dataclass(slots=True)
class Statement:
    """A line: its kind (``block``, ``if``, ``for`` …), its data, and the parts before its block.

    Attributes:
        items: Of a block.
        number: Text of its block number (``N10``), or "".
        label: Name before a colon, or "".
        deletable: Whether it begins with ``/``.
    """

    kind: str = "block"
    items: list[Item] = field(default_factory=list)
    data: tuple[Any, ...] = ()
    number: str = ""
    label: str = ""
    deletable: bool = False


def capitals(text: str) -> str:
    """Return a line in capitals without its comment; texts in quotes stay as they are."""
    if '"' not in text and ";" not in text:
        return text.upper()
    parts, place = [], 0
    for match in _STRING.finditer(text):
        parts.append(text[place : match.start()].upper())
        parts.append("" if match[0][0] == ";" else match[0])
        place = match.end()
    parts.append(text[place:].upper())
    return "".join(parts)


def parse(text: str) -> Statement:
    """Read one line.

    Raises:
        BlockError: The line does not belong to the language; the column counts in `text`.
    """
    line = capitals(text).rstrip()
    prefix = _PREFIX.match(line)
    assert prefix
    head = Statement(
        number=prefix["number"] or "", label=prefix["label"] or "", deletable=bool(prefix["skip"])
    )
    body = line[prefix.end() :]
    if not body.strip() or _HEADER.match(line.lstrip()) or line.strip() == "%":
        return head
    if _PLAIN_LINE.match(body):
        head.items = [("word", m[1], ("n", float(m[2]))) for m in _PLAIN_WORD.finditer(body)]
        return head
    found = _parsed(body, prefix.end())
    head.kind, head.data = found[0], tuple(found[1:])
    head.items = found[1] if head.kind == "block" else []
    return head


def _parsed(body: str, before: int) -> tuple[Any, ...]:
    from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

    try:
        tree: tuple[Any, ...] = _lark().parse(body)
        return tree
    except UnexpectedInput as error:
        column = error.column if isinstance(error.column, int) and error.column > 0 else len(body) + 1
        expected: set[str] = set()
        got = "the end of the block"
        if isinstance(error, UnexpectedToken):
            got = f"'{error.token}'" if error.token else got
            expected = set(error.expected)
        elif isinstance(error, UnexpectedCharacters):
            got, expected = f"'{error.char}'", set(error.allowed or ())
        names = sorted({_NAMES.get(name, name.capitalize() if len(name) < 3 else name) for name in expected})
        wanted = ", ".join(names[:6]) if names else "something else"
        if got.startswith("'$END") or not str(getattr(error, "token", "x")):
            got, column = "the end of the block", len(body) + 1
        raise BlockError(
            "syntax", f"{got} where one of these was expected: {wanted}", column=before + column,
            hint="a block of SINUMERIK is words (G1 X10), settings (X=R1*2, CR=5) and calls (CYCLE81(...))",
        ) from None  # fmt: skip


def _indexed(name: str, indices: list[Node]) -> Node:
    if re.fullmatch(r"R\d+", name) and not indices:
        return ("r", ("n", float(name[1:])))
    if name == "R" and len(indices) == 1:
        return ("r", indices[0])
    return ("var", name, tuple(indices))


def _alone(kind: str) -> Any:
    """Return the method of a rule that is one word."""
    return lambda self, children: (kind,)


def _transformer() -> Any:
    from lark import Token, Transformer

    class Reader(Transformer[Any, Any]):
        """The values of a rule's children to the value of the rule."""

        def start(self, c: list[Any]) -> Any:
            return c[0] if c else ("block", [])

        def block(self, c: list[Any]) -> Any:
            return ("block", list(c))

        def word(self, c: list[Any]) -> Any:
            return ("word", str(c[0][0]), ("n", float(c[0][1:])))

        def setting(self, c: list[Any]) -> Any:
            return ("set", *c[0], c[1])

        def polynomial(self, c: list[Any]) -> Any:
            return ("poly", c[0], tuple(c[1:]))

        def call(self, c: list[Any]) -> Any:
            return ("call", str(c[0]), c[1])

        def name(self, c: list[Any]) -> Any:
            return ("name", str(c[0]))

        def text(self, c: list[Any]) -> Any:
            return ("text", str(c[0])[1:-1])

        def target(self, c: list[Any]) -> Any:
            return str(c[0]), tuple(n for n in c[1:] if n is not None)

        def arguments(self, c: list[Any]) -> Any:
            return () if len(c) == 1 and c[0] is None else tuple(c)

        def number(self, c: list[Any]) -> Any:
            return ("n", float(str(c[0]).replace("EX", "E")))

        def string(self, c: list[Any]) -> Any:
            return ("s", str(c[0])[1:-1])

        def parameter(self, c: list[Any]) -> Any:
            return _indexed(str(c[0]), [])

        def variable(self, c: list[Any]) -> Any:
            return _indexed(str(c[0]), [n for n in c[1:] if n is not None])

        def function(self, c: list[Any]) -> Any:
            return ("fn", str(c[0]), c[1])

        def negative(self, c: list[Any]) -> Any:
            return ("un", "-", c[0])

        def signed(self, c: list[Any]) -> Any:
            return ("un", str(c[0]), c[1])

        def not__(self, c: list[Any]) -> Any:
            return ("un", "NOT", c[0])

        def binary(self, c: list[Any]) -> Any:
            return ("bin", str(c[1]), c[0], c[2])

        compare = binary

        def join(self, c: list[Any]) -> Any:
            return ("bin", "<<", c[0], c[1])

        def chain(self, c: list[Any]) -> Any:
            return ("bin", ":", c[0], c[1])

        def and__(self, c: list[Any]) -> Any:
            return ("bin", "AND", c[0], c[1])

        def or_(self, c: list[Any]) -> Any:
            return ("bin", "OR", c[0], c[1])

        def xor(self, c: list[Any]) -> Any:
            return ("bin", "XOR", c[0], c[1])

        def jump(self, c: list[Any]) -> Any:
            target = str(c[1])
            return ("jump", str(c[0]), target.strip("\"'"))

        def if_jump(self, c: list[Any]) -> Any:
            return ("if-jump", tuple(zip(c[::2], c[1::2], strict=True)))

        def if_(self, c: list[Any]) -> Any:
            return ("if", c[0])

        def while_(self, c: list[Any]) -> Any:
            return ("while", c[0])

        def until(self, c: list[Any]) -> Any:
            return ("until", c[0])

        def for_(self, c: list[Any]) -> Any:
            return ("for", c[0], c[1], c[2])

        def case(self, c: list[Any]) -> Any:
            if len(c) == 2 and isinstance(c[1], tuple) and c[1][0] == "jump":
                return ("branch", c[0], c[1])
            return ("case", c[0], tuple(c[1:]))

        def default(self, c: list[Any]) -> Any:
            return ("branch", None, c[0])

        def label(self, c: list[Any]) -> str:
            return str(c[0])

        def times(self, c: list[Any]) -> Any:
            return ("times", c[0])

        def repeat_part(self, c: list[Any]) -> Any:
            names = [x for x in c if isinstance(x, str)]
            times = next((x[1] for x in c if isinstance(x, tuple)), ("n", 1.0))
            return ("repeat-part", tuple(names), times)

        def repeat_block(self, c: list[Any]) -> Any:
            times = next((x[1] for x in c if isinstance(x, tuple)), ("n", 1.0))
            return ("repeat-block", c[0], times)

        def length(self, c: list[Any]) -> Any:
            return ("length", float(c[0]))

        def bounds(self, c: list[Any]) -> Any:
            return ("bounds", tuple(c))

        def several(self, c: list[Any]) -> Any:
            return ("several", tuple(c))

        def defined(self, c: list[Any]) -> Any:
            bounds = next((x[1] for x in c[1:] if isinstance(x, tuple) and x[0] == "bounds"), ())
            value = next((x for x in c[1:] if isinstance(x, tuple) and x[0] != "bounds"), None)
            return (str(c[0]), bounds, value)

        def def_(self, c: list[Any]) -> Any:
            kind = str(c[0])
            return ("def", kind, tuple(x for x in c[1:] if x is not None and x[0] != "length"))

        def formal(self, c: list[Any]) -> Any:
            by_reference = any(isinstance(x, Token) and x.type == "VAR" for x in c)
            kind = next(str(x) for x in c if isinstance(x, Token) and x.type == "TYPE")
            name = next(str(x) for x in c if isinstance(x, Token) and x.type == "NAME")
            usual = c[-1] if isinstance(c[-1], tuple) and c[-1][0] not in ("length", "extent") else None
            return ("formal", kind, name, by_reference, usual, ("extent",) in c)

        def extent(self, c: list[Any]) -> Any:
            return ("extent",)

        def proc(self, c: list[Any]) -> Any:
            formals = tuple(x for x in c if isinstance(x, tuple) and x[0] == "formal")
            names = [str(x) for x in c if isinstance(x, Token)]
            return ("proc", names[0], formals, tuple(names[1:]))

        def extern(self, c: list[Any]) -> Any:
            return ("extern", str(c[0]))

    for word in ("else_", "endif", "loop", "endloop", "endfor", "endwhile", "repeat"):
        setattr(Reader, word, _alone(word.rstrip("_")))
    return Reader()


@cache
def _lark() -> Any:
    """Build the parser, whose values are statements."""
    from lark import Lark

    return Lark.open_from_package(
        "cncgen.grammars", "sinumerik.lark", ("",), parser="lalr", lexer="contextual", transformer=_transformer(),
        maybe_placeholders=True,
    )  # fmt: skip
