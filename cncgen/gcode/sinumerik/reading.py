"""One line of SINUMERIK to a statement."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cache, partial
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
_SYNCHRONOUS = re.compile(
    r"\s*(?:(?:IDS?\s*=\s*\w+\s*)?(?:WHENEVER|WHEN|EVERY|FROM)\b|(?:IDS?\s*=\s*\w+\s*)?DO\s+\S)"
)
_HEADER = re.compile(r"%_N_(\w+?)_(MPF|SPF)\b|;\$PATH")
#: Common names of the grammar's tokens.
_NAMES = {
    "PLAIN": "a word", "NAME": "a name", "PLAIN_NUMBER": "a number", "EXPONENT": "a number", "STRING": "a text", "EQUAL": "=",
    "LPAR": "(", "RPAR": ")", "LSQB": "[", "RSQB": "]", "COMMA": "a comma", "SIGN": "a sign", "TIMES": "an operator",
    "RELATION": "a comparison", "__ANON_0": "<<", "COLON": ":", "GOTO": "a jump", "GOTOS": "a jump", "TYPE": "a type", "$END": "the end of the block",
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
    if _SYNCHRONOUS.match(body):
        message = "a synchronous action, which acts while other blocks move, is not read"
        hint = "leave it out, or write what it does as blocks"
        raise BlockError("not-read", message, column=prefix.end() + 1, hint=hint)
    found = _parsed(body, prefix.end())
    head.kind, head.data = found[0], tuple(found[1:])
    head.items = found[1] if head.kind == "block" else []
    return head


def _parsed(body: str, before: int) -> tuple[Any, ...]:
    from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

    try:
        tree: tuple[Any, ...] = grammar().parse(body)
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
        hint = "a block of SINUMERIK is words (G1 X10), settings (X=R1*2, CR=5) and calls (CYCLE81(...))"
        if isinstance(error, UnexpectedToken) and error.token.type == "RELATION":
            hint = "AND and OR bind before comparisons: IF (R1==1) AND (R2==2)"
        raise BlockError(
            "syntax", f"{got} where one of these was expected: {wanted}", column=before + column, hint=hint
        ) from None  # fmt: skip


def _indexed(name: str, indices: list[Node]) -> Node:
    if re.fullmatch(r"R\d+", name) and not indices:
        return ("r", ("n", float(name[1:])))
    if name == "R" and len(indices) == 1:
        return ("r", indices[0])
    return ("var", name, tuple(indices))


def _given(children: Iterable[Any]) -> list[Any]:
    """Return the children that are there."""
    return [child for child in children if child is not None]


def _times(children: Iterable[Any]) -> Node:
    """Return how often a part is repeated."""
    return next((child[1] for child in children if isinstance(child, tuple)), ("n", 1.0))


def _case(value: Node, *children: Any) -> Any:
    single = len(children) == 1 and isinstance(children[0], tuple) and children[0][0] == "jump"
    return ("branch", value, children[0]) if single else ("case", value, children)


def _defined(name: str, *children: Any) -> Any:
    bounds = next((x[1] for x in children if isinstance(x, tuple) and x[0] == "bounds"), ())
    value = next((x for x in children if isinstance(x, tuple) and x[0] != "bounds"), None)
    return (str(name), bounds, value)


def _formal(*children: Any) -> Any:
    tokens = {getattr(x, "type", ""): str(x) for x in children if isinstance(x, str)}
    usual = (
        children[-1]
        if isinstance(children[-1], tuple) and children[-1][0] not in ("length", "extent")
        else None
    )
    return ("formal", tokens["TYPE"], tokens["NAME"], "VAR" in tokens, usual, ("extent",) in children)


def _proc(*children: Any) -> Any:
    name, *attributes = [str(x) for x in children if isinstance(x, str)]
    return ("proc", name, tuple(x for x in children if isinstance(x, tuple)), tuple(attributes))


#: Rules that are one word.
_ALONE = ("else_", "endif", "loop", "endloop", "endfor", "endwhile", "repeat")
#: The value of each rule of the grammar, of those of its children.
VALUES: dict[str, Callable[..., Any]] = {
    "start": lambda *c: c[0] if c else ("block", []),
    "block": lambda *c: ("block", list(c)),
    "word": lambda word: ("word", str(word[0]), ("n", float(word[1:]))),
    "setting": lambda target, value: ("set", *target, value),
    "polynomial": lambda target, *values: ("poly", target, values),
    "call": lambda name, arguments: ("call", str(name), arguments),
    "name": lambda name: ("name", str(name)),
    "text": lambda text: ("text", str(text)[1:-1]),
    "target": lambda name, *indices: (str(name), tuple(_given(indices))),
    "arguments": lambda *c: () if c == (None,) else c,
    "number": lambda number: ("n", float(str(number).replace("EX", "E"))),
    "string": lambda text: ("s", str(text)[1:-1]),
    "parameter": lambda name: _indexed(str(name), []),
    "variable": lambda name, *indices: _indexed(str(name), _given(indices)),
    "function": lambda name, arguments: ("fn", str(name), arguments),
    "negative": lambda a: ("un", "-", a),
    "signed": lambda sign, a: ("un", str(sign), a),
    "not__": lambda a: ("un", "NOT", a),
    "binary": lambda a, operator, b: ("bin", str(operator), a, b),
    "compare": lambda a, operator, b: ("bin", str(operator), a, b),
    "join": lambda a, b: ("bin", "<<", a, b),
    "chain": lambda a, b: ("bin", ":", a, b),
    "and__": lambda a, b: ("bin", "AND", a, b),
    "or_": lambda a, b: ("bin", "OR", a, b),
    "xor": lambda a, b: ("bin", "XOR", a, b),
    "bit_and": lambda a, b: ("bin", "B_AND", a, b),
    "bit_or": lambda a, b: ("bin", "B_OR", a, b),
    "bit_xor": lambda a, b: ("bin", "B_XOR", a, b),
    "bit_not": lambda a: ("fn", "B_NOT", (a,)),
    "jump": lambda goto, target: ("jump", str(goto), str(target).strip("\"'")),
    "begin": lambda goto: ("jump", str(goto), ""),
    "if_jump": lambda *c: ("if-jump", tuple(zip(c[::2], c[1::2], strict=True))),
    "if_": lambda condition: ("if", condition),
    "while_": lambda condition: ("while", condition),
    "until": lambda condition: ("until", condition),
    "for_": lambda name, first, last: ("for", name, first, last),
    "case": _case,
    "default": lambda jump: ("branch", None, jump),
    "label": str,
    "times": lambda value: ("times", value),
    "repeat_part": lambda *c: ("repeat-part", tuple(x for x in c if isinstance(x, str)), _times(c)),
    "repeat_block": lambda label, *c: ("repeat-block", label, _times(c)),
    "length": lambda number: ("length", float(number)),
    "bounds": lambda *c: ("bounds", c),
    "several": lambda *c: ("several", c),
    "defined": _defined,
    "def_": lambda kind, *c: ("def", str(kind), tuple(x for x in _given(c) if x[0] != "length")),
    "formal": _formal,
    "extent": lambda *_: ("extent",),
    "declared": lambda *_: None,
    "proc": _proc,
    "extern": lambda name, *_: ("extern", str(name)),
    **{rule: partial(tuple, (rule.rstrip("_"),)) for rule in _ALONE},
}


def _transformer() -> Any:
    """Return the functions for the values of the rules."""
    from lark import Transformer

    def method(rule: str) -> Callable[[Any, list[Any]], Any]:
        return lambda self, children: VALUES[rule](*children)

    return type("Reader", (Transformer,), {rule: method(rule) for rule in VALUES})()


@cache
def grammar() -> Any:
    """Build the parser, whose values are statements."""
    from lark import Lark

    return Lark.open_from_package(
        "cncgen.grammars", "sinumerik.lark", ("",), parser="lalr", lexer="contextual", transformer=_transformer(),
        maybe_placeholders=True,
    )  # fmt: skip
