"""The lane of the grammar: one block of text to `Parsed`, or a `BlockError` that says what was expected."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from cncgen.gcode.block import BSPLINE, OUTPUT, Flow, Parsed, Value
from cncgen.gcode.errors import BlockError
from cncgen.gcode.text import expressions
from cncgen.gcode.text.syntax_hints import hint_for, missing_number, number_hint

#: Brackets, or parameters of parameters, within one another.
MAX_NESTING = 100
#: What people call the grammar's tokens.
_NAMES = {
    "WORD": "a word",
    "LETTER": "a word",
    "NAMED": "a word",
    "BSPLINE": "a word",
    "CORNER": "a word",
    "NUMBER": "a number",
    "NAME": "a name <…>",
    "COMMENT": "a comment",
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
    **dict.fromkeys(("IF", "GOTO", "WHILE", "DO", "END"), "a jump or loop of a macro"),
    **dict.fromkeys(("ATN", "POW"), "a function"),
    "$END": "the end of the block",
}
#: Keywords that stand behind a condition.
_FOLLOWERS = {"GOTO", "THEN", "DO"}
#: Tokens that never stand within brackets (a comma does in ATAN alone).
_OUTSIDE = ("WORD", "LETTER", "NAMED", "BSPLINE", "CORNER", "COMMENT", "KEYWORD", "EQUAL", "COMMA", "$END")
#: Words whose numbers without a decimal point count in least increments.
_LENGTHS = "xyzabcuvwijkqr"
#: The rules that FANUC's dialect has its own of, and those.
_FANUC_RULES = {
    "?assigned: signed": "?assigned: expression",
    "start: DELETE? LINE_NUMBER? _content": "start: DELETE? _content\n     | DELETE? LINE_NUMBER DELETE? _content",
    'DELETE: "/"': r"DELETE: /\/[1-9]?/",
    "O_NUMBER: /o[0-9]+/": "O_NUMBER: /[o:][0-9]+/",
    "O_NAME: /o<": "O_NAME: /o?<",
    "|bin|bcd/": "|bin|bcd|sqr|rnd/",
    "| BSPLINE ": "| CORNER signed -> corner\n     | BSPLINE ",
    "BSPLINE.3:": "CORNER.3: /,[cr]/\nBSPLINE.3:",
    '"atan"': '("atan" | "atn")',
    '| "exists"': '| "pow" "[" expression "," expression "]" -> power_of\n      | "exists"',
}
#: Output commands of FANUC's macros.
_OUTPUT = re.compile(
    r"\s*(?P<delete>(?:/[1-9]?\s*)?(?:N[0-9]+\s*(?:/[1-9]?\s*)?)?)(?P<keyword>POPEN|PCLOS|[BD]PRNT)(?![A-Z])",
    re.IGNORECASE,
)
#: What has no meaning outside comments: capital letters (of ASCII: no other character is a letter here) and blanks.
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


def column_of(text: str, index: int) -> int:
    """Return the 1-based column in `text` of a place in its normalised form."""
    left = index
    place = 0
    for match in _PIECE.finditer(text):
        plain = match.start() - place
        if left < plain:
            return place + left + 1
        left -= plain
        place = match.start()
        if match.group()[0] in "(;":
            kept = match.end() - match.start()
            if left < kept:
                return place + left + 1
            left -= kept
        place = match.end()
    return min(place + left, len(text.rstrip())) + 1


class _Reader:
    """Lark callbacks: the values of a rule's children to the value of the rule. Words come as (kind, value)."""

    arithmetic = expressions.LINUXCNC
    increments = False

    def plain_word(self, children: list[Any]) -> Any:
        token = children[0]
        return "word", (token[0], word_value(token[0], token[1:], self.increments))

    def word(self, children: list[Any]) -> Any:
        return "word", (str(children[0]), children[1])

    def bspline(self, children: list[Any]) -> Any:
        return "word", ("g", BSPLINE / 10.0)

    def corner(self, children: list[Any]) -> Any:
        return "word", (str(children[0]), children[1])

    def setting(self, children: list[Any]) -> Any:
        return "setting", (children[0], children[1])

    def comment(self, children: list[Any]) -> Any:
        return "comment", _said(children[0])

    def number(self, children: list[Any]) -> Value:
        return float(children[0])

    def name(self, children: list[Any]) -> str:
        return str(children[0][1:-1])

    def parameter(self, children: list[Any]) -> Value:
        return expressions.parameter(children[0])

    def exists(self, children: list[Any]) -> Value:
        return expressions.exists(children[0])

    def negative(self, children: list[Any]) -> Value:
        return expressions.negative(children[0])

    def unary(self, children: list[Any]) -> Value:
        return expressions.negative(children[1]) if children[0] == "-" else children[1]

    def binary(self, children: list[Any]) -> Value:
        return expressions.binary(str(children[1]), children[0], children[2], self.arithmetic)

    def function(self, children: list[Any]) -> Value:
        return expressions.unary(str(children[0]), children[1], self.arithmetic)

    def arc_tangent(self, children: list[Any]) -> Value:
        values = [child for child in children if child != "/["]
        return expressions.arc_tangent(values[0], values[1] if len(values) > 1 else None, self.arithmetic)

    def power_of(self, children: list[Any]) -> Value:
        return expressions.binary("**", children[0], children[1], self.arithmetic)

    def bracket(self, children: list[Any]) -> Value:
        return children[0]

    def o_label(self, children: list[Any]) -> Value | str:
        return o_label(children[0][children[0][0] != "<" :])

    def computed_label(self, children: list[Any]) -> Value:
        return children[0]

    def program_number(self, children: list[Any]) -> Any:
        return "flow", Flow("program", children[0])

    def o_word(self, children: list[Any]) -> Any:
        arguments = tuple(child for child in children[2:] if not isinstance(child, str))
        comments = [text for child in children[2:] if isinstance(child, str) for text in _said(child)]
        return "o_word", (Flow(str(children[1]), children[0], arguments), comments)

    def if_goto(self, children: list[Any]) -> Any:
        return "flow", Flow("goto", children[1], (children[0],))

    def if_then(self, children: list[Any]) -> Any:
        return "flow", Flow("then", None, (children[0],), _parsed(children[1:]))

    def goto(self, children: list[Any]) -> Any:
        return "flow", Flow("goto", children[0])

    def while_do(self, children: list[Any]) -> Any:
        condition = tuple(children[:-1])
        return "flow", Flow("while-do", float(children[-1]), condition)

    def end_do(self, children: list[Any]) -> Any:
        return "flow", Flow("end-do", float(children[0]))

    def start(self, children: list[Any]) -> Parsed:
        return _parsed(children)


def word_value(letter: str, number: str, increments: bool) -> Value:
    """Return the value of a word; a length without a decimal point may count in least increments.

    Their size depends on the units in force.
    """
    value = float(number)
    if increments and letter in _LENGTHS and "." not in number:
        return lambda p: value * p.interpreter.increment()
    return value


def o_label(text: str) -> float | str:
    """Return the label of an O-word; ``o<100>`` is ``o100``."""
    name = text.strip("<>")
    return float(name) if name.isdecimal() else name


def _said(token: str) -> list[str]:
    """Return a comment without its parentheses; one behind a semicolon is never passed on."""
    return [token[1:-1]] if token[0] == "(" else []


def _parsed(children: list[Any]) -> Parsed:
    """Gather the items of a block."""
    parsed = Parsed()
    for child in children:
        if isinstance(child, tuple):
            kind, value = child
            if kind == "word":
                parsed.words.append(value)
            elif kind == "setting":
                parsed.settings.append(value)
            elif kind == "comment":
                parsed.comments += value
            elif kind == "o_word":
                parsed.flow, parsed.comments = value
            else:
                parsed.flow = value
        elif child.type == "DELETE":
            parsed.deletable = True
        elif child.type == "LINE_NUMBER":
            parsed.number = str(child[1:])
        else:
            parsed.comments += _said(child)
    return parsed


@cache
def _lark(dialect: str, increments: bool) -> Any:
    """Build the parser whose values are those of a dialect."""
    from importlib import resources

    from lark import Lark, Transformer

    fanuc = dialect == "fanuc"
    arithmetic = expressions.FANUC if fanuc else expressions.LINUXCNC
    reader = type("Reader", (_Reader, Transformer), {"arithmetic": arithmetic, "increments": increments})
    text = resources.files("cncgen.grammars").joinpath("gcode.lark").read_text("utf-8")
    if fanuc:
        for rule, own in _FANUC_RULES.items():
            text = text.replace(rule, own)
    return Lark(text, parser="lalr", lexer="contextual", transformer=reader(), maybe_placeholders=False)


def parse(text: str, dialect: str = "linuxcnc", increments: bool = False) -> Parsed:
    """Read one block; with `increments`, lengths without a decimal point are in the control's least increment.

    Raises:
        BlockError: Where it is no block; the column is that of `text`.
    """
    from lark.exceptions import UnexpectedInput, VisitError

    output = output_command(text) if dialect == "fanuc" else None
    if output is not None:
        return output
    bare = normalise(text)
    check_nesting(text, bare)
    try:
        return _lark(dialect, increments).parse(bare)
    except UnexpectedInput as error:
        raise _syntax_error(text, bare, error) from None
    except VisitError as error:
        if isinstance(error.orig_exc, BlockError):
            raise error.orig_exc from None
        raise


def output_command(text: str) -> Parsed | None:
    """Return a block of FANUC that writes to a device, else None: what it says is no words, it is done as comments are."""
    match = _OUTPUT.match(text)
    if match is None:
        return None
    command = match["keyword"].upper() + text[match.end() :].strip()
    return Parsed(comments=[OUTPUT + command], deletable="/" in match["delete"])


def check_nesting(text: str, bare: str) -> None:
    """Raise where brackets, or parameters of parameters, stand within one another too deep to be computed.

    `bare` is the normalised form of `text`.
    """
    if len(bare) <= MAX_NESTING:
        return
    deep = bare.find("#" * (MAX_NESTING + 1))
    depth = 0
    for index, character in enumerate(bare):
        depth += (character == "[") - (character == "]")
        if depth > MAX_NESTING or index == deep:
            raise BlockError(
                "nesting",
                f"more than {MAX_NESTING} brackets or # stand within one another",
                column=column_of(text, index),
                hint="compute a part of it in a parameter of its own",
            )


def _syntax_error(text: str, bare: str, error: Any) -> BlockError:
    """Say what stands there and what could."""
    token = getattr(error, "token", None)
    index = error.pos_in_stream
    if index is None or (token is not None and token.type == "$END"):
        index = len(bare)
    before, rest = bare[:index], bare[index:]
    column = column_of(text, index)
    if rest.startswith(("(", ")")):
        return _comment_error(rest, column)
    letter = missing_number(before, rest)
    if letter:
        hint = number_hint(letter, before, rest)
        return BlockError("syntax", f"{letter} has no number", column=column, hint=hint)
    expected = getattr(error, "accepts", None) or getattr(error, "expected", None) or error.allowed or ()
    return BlockError(
        "syntax",
        f"{_found(rest)} where {_any_of(_expected_names(before, sorted(expected)))} was expected",
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
        # The parser's states do not tell how a value ends; what cannot stand within brackets is left out.
        expected = [name for name in expected if name not in _OUTSIDE]
    named = {} if set(expected) <= _FOLLOWERS else _NAMES
    return list(dict.fromkeys(named.get(name, name) for name in expected))


def _any_of(names: list[str]) -> str:
    """Return "a, b or c"."""
    if len(names) < 2:
        return names[0] if names else "nothing more"
    return ", ".join(names[:-1]) + " or " + names[-1]
