"""Two lanes from the text of a statement to values.

The grammar (``grammars/part21.lark``) is the language; it takes every construct and names an error. Lark builds some
10 MB a minute, so instances without comments go down a lane of one regular expression and a stack, twenty times
faster; all other instances go to the grammar. Both give the same values.
"""

from __future__ import annotations

import math
import re
import sys
from functools import cache
from typing import Any

from cncgen.stepnc.part21.strings import decode
from cncgen.stepnc.part21.values import (
    DERIVED,
    Binary,
    Constant,
    Enumeration,
    Record,
    Ref,
    Resource,
    Typed,
    Value,
    ValueRef,
)

#: Nested aggregates that a value may have; schemas of this world need four.
MAX_DEPTH = 64
#: Digits that a number may have.
MAX_DIGITS = 400

_BLANKS = " \t\r\n\f\v"
#: Tokens of a statement; other text comes as single characters, which nothing below takes.
_TOKENS = re.compile(
    r"""[ \t\r\n\f\v]*(
      \#[0-9]+
    | [+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[Ee][+-]?[0-9]+)?
    | '(?:[^']|'')*+'
    | \.[A-Za-z_][A-Za-z0-9_]*\.
    | !?[A-Za-z_][A-Za-z0-9_]*
    | "[0-9A-Fa-f]*"
    | .
    )""",
    re.VERBOSE | re.DOTALL,
).findall
_LETTERS = frozenset("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_!")


class SyntaxFault(Exception):
    """A statement against the syntax of Part 21: the fault, and its offset in the statement's text."""

    def __init__(self, message: str, offset: int, length: int = 1) -> None:
        super().__init__(message)
        self.message = message
        self.offset = offset
        self.length = length


def number(text: str) -> int | float:
    """Return the value of a number token.

    Raises:
        ValueError: where it has too many digits, or its double is not finite.
    """
    if len(text) > MAX_DIGITS:
        raise ValueError(f"a number of {len(text)} characters is longer than {MAX_DIGITS}")
    if "." not in text and text.lstrip("+-").isdigit():
        whole = int(text)
        if abs(whole) > sys.float_info.max:
            raise ValueError(f"a whole number of {len(text)} digits is beyond the range of a double")
        return whole
    value = float(text)
    if math.isinf(value):
        raise ValueError(f"{text} is beyond the range of a double")
    return value


def parse_body(text: str) -> tuple[Record, ...]:
    """Return the parts of an instance from the text after ``#id =``, up to the semicolon.

    Raises:
        SyntaxFault: naming the first error.
    """
    parts = quick_body(text)
    return parts if parts is not None else grammar_body(text)


def quick_body(text: str) -> tuple[Record, ...] | None:
    """Return what `grammar_body` would return, or None for what this lane leaves to the grammar: comments, errors."""
    try:
        items = _quick_items(text)
    except ValueError:
        return None
    return None if items is None else _parts(items)


def _quick_items(text: str) -> list[Value] | None:
    """Return the values of a text at its outermost level: an instance is one record, or one list of records.

    Raises:
        ValueError: where a number or a name is malformed.
    """
    items: list[Value] = []
    stack: list[tuple[list[Value], str | None]] = []
    expect_value = True  # a value, or a keyword, may come
    pending: str | None = None  # the keyword before a parenthesis
    for token in _TOKENS(text.strip(_BLANKS)):
        first = token[0]
        if first == ",":
            if expect_value or not stack:
                return None
            expect_value = True
        elif first == "(":
            if not expect_value or len(stack) >= MAX_DEPTH:
                return None
            stack.append((items, pending))
            items, pending = [], None
        elif pending is not None:
            return None
        elif first == ")":
            if not stack or (expect_value and items and not _in_complex(stack)):
                return None
            closed = items
            items, keyword = stack.pop()
            if not _close(items, closed, keyword, stack):
                return None
            # The parts of a complex instance follow each other without commas.
            expect_value = _in_complex(stack)
        elif not expect_value:
            return None
        elif first == "#":
            items.append(Ref(token[1:]))
            expect_value = False
        elif first in _LETTERS:
            pending = token.upper()
        else:
            items.append(_atom(first, token))
            expect_value = False
    return None if stack or pending is not None else items


def _atom(first: str, token: str) -> Value:
    """Return the value of a token other than a reference, a keyword or punctuation.

    Raises:
        ValueError: where the token is not a value.
    """
    if first == "'" and len(token) > 1:
        return decode(token[1:-1])
    if first == "$":
        return None
    if first == "*":
        return DERIVED
    if first == "." and token[-1] == "." and len(token) > 2:
        return Enumeration(token[1:-1].upper())
    if first == '"' and len(token) > 1:
        return Binary(token[1:-1].upper())
    return number(token)


def _in_complex(stack: list[tuple[list[Value], str | None]]) -> bool:
    """Tell whether the list being read is the outermost, bare one: the parts of a complex instance."""
    return len(stack) == 1 and stack[0][1] is None


def _close(
    items: list[Value], closed: list[Value], keyword: str | None, stack: list[tuple[list[Value], str | None]]
) -> bool:
    """Put what a closing parenthesis ends into the list around it; tell whether it may stand there."""
    if keyword is None:
        items.append(tuple(closed))
        return True
    if keyword == "!":
        return False
    if not stack or _in_complex(stack):
        items.append(Record(keyword, tuple(closed)))
        return True
    if len(closed) != 1 or keyword.startswith("!") or any(isinstance(c, Record) for c in closed):
        return False
    items.append(Typed(keyword, closed[0]))
    return True


def _parts(items: list[Value]) -> tuple[Record, ...] | None:
    if len(items) != 1:
        return None
    parts = (items[0],) if isinstance(items[0], Record) else items[0]
    if type(parts) is not tuple or not parts:
        return None
    for part in parts:
        if type(part) is not Record or Record in map(type, part.parameters):
            return None
    return parts


def grammar_body(text: str) -> tuple[Record, ...]:
    """Return the parts of an instance by the grammar (slow; any construct).

    Raises:
        SyntaxFault: naming the first error.
    """
    prefix = "#0="
    result = parse_statement(prefix + text, "instance", shift=len(prefix))
    return result[1]


def parse_statement(text: str, start: str, shift: int = 0) -> Any:
    """Parse a statement without its semicolon by the rule `start` of the grammar.

    Args:
        text: The statement.
        start: ``instance``, ``header_entity``, ``data_head``, ``anchor`` or ``reference``.
        shift: Characters to subtract from the offset of an error.

    Raises:
        SyntaxFault: naming the first error.
    """
    from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken, VisitError

    depth = _depth(text)
    if depth > MAX_DEPTH:
        raise SyntaxFault(f"{depth} parentheses are open at once, more than {MAX_DEPTH}", 0)
    try:
        return _grammar().parse(text, start=start)
    except VisitError as error:
        raise SyntaxFault(str(error.orig_exc), 0) from None
    except ValueError as error:
        raise SyntaxFault(str(error), 0) from None
    except UnexpectedInput as error:
        position = error.pos_in_stream or 0
        allowed: Any = getattr(error, "accepts", None) or getattr(error, "expected", set())
        if isinstance(error, UnexpectedCharacters):
            found, allowed = f"{text[position]!r}", error.allowed or set()
        elif isinstance(error, UnexpectedToken) and error.token.type != "$END":
            found = f"{str(error.token)[:40]!r}"
        else:
            found, position = "the end of the statement", len(text)
        where = max(position - shift, 0)
        raise SyntaxFault(f"{found} where {_one_of(allowed)} is expected", where) from None


_TERMINALS = {
    "LPAR": "'('",
    "RPAR": "')'",
    "COMMA": "','",
    "EQUAL": "'='",
    "KEYWORD": "a keyword",
    "NUMBER": "a number",
    "STRING": "a string",
    "ENUMERATION": "an .ENUMERATION.",
    "BINARY": "a binary value",
    "NAME_OF_INSTANCE": "#id",
    "NAME_OF_VALUE": "@id",
    "CONSTANT": "a constant",
    "DOLLAR": "'$'",
    "STAR": "'*'",
    "RESOURCE": "<a resource>",
    "$END": "the end",
    "LBRACE": "'{'",
}


def _one_of(terminals: set[str]) -> str:
    names = sorted(
        {_TERMINALS.get(t, t) for t in terminals if t not in ("COMMENT",) and not t.startswith("__")}
    )
    if len(names) > 6:
        return "a value"
    return " or ".join(names) or "nothing"


def _depth(text: str) -> int:
    bare = re.sub(r"'(?:[^']|'')*+'", "", text)
    depth = deepest = 0
    for c in re.findall(r"[()]", bare):
        depth += 1 if c == "(" else -1
        deepest = max(deepest, depth)
    return deepest


@cache
def _grammar() -> Any:
    """Return the Lark parser that builds values while it parses."""
    from importlib.resources import files

    from lark import Lark, Transformer

    class Values(Transformer):
        """Values of `cncgen.stepnc.part21.values` from the rules of the grammar."""

        NAME_OF_INSTANCE = staticmethod(lambda t: Ref(t[1:]))
        NAME_OF_VALUE = staticmethod(lambda t: ValueRef(t[1:]))
        CONSTANT = staticmethod(lambda t: Constant(t.upper()))
        NUMBER = staticmethod(lambda t: number(str(t)))
        STRING = staticmethod(lambda t: decode(str(t[1:-1])))
        ENUMERATION = staticmethod(lambda t: Enumeration(t[1:-1].upper()))
        BINARY = staticmethod(lambda t: Binary(t[1:-1].upper()))
        RESOURCE = staticmethod(lambda t: Resource(t[1:-1]))
        list = complex = staticmethod(tuple)
        omitted = staticmethod(lambda c: None)
        derived = staticmethod(lambda c: DERIVED)
        header_entity = staticmethod(lambda c: c[0])
        anchor_item = staticmethod(lambda c: c[0])
        data_head = staticmethod(lambda c: c[0] if c else ())
        instance = staticmethod(lambda c: (c[0], c[1] if type(c[1]) is tuple else (c[1],)))
        anchor = staticmethod(lambda c: (c[0], c[1], tuple(c[2:])))
        reference = tag = staticmethod(tuple)

        def typed(self, children: Any) -> Typed:
            return Typed(str(children[0]).upper(), children[1])

        def record(self, children: Any) -> Record:
            return Record(str(children[0]).upper(), tuple(children[1:]))

    text = files("cncgen.grammars").joinpath("part21.lark").read_text(encoding="utf-8")
    starts = ["instance", "header_entity", "data_head", "anchor", "reference", "exchange_file"]
    return Lark(text, parser="lalr", start=starts, transformer=Values(), maybe_placeholders=False)
