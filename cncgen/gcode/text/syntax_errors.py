"""Names the text where the grammar refuses a block, and the words that were expected there."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from cncgen.gcode.errors import BlockError
from cncgen.gcode.text import signs
from cncgen.gcode.text.normal_text import normalise
from cncgen.gcode.text.syntax_hints import branch_fault, hint_for, missing_number, number_hint
from cncgen.kernels.gcode_parse import Parser
from cncgen.records import dataclass

_NAMES = {
    **dict.fromkeys(("WORD", "LETTER", "NAMED", "BSPLINE", "CORNER", "I_FUNCTION"), "a word"),
    **dict.fromkeys(("COMMENT", "MESSAGE"), "a comment"),
    **dict.fromkeys(("FUNCTION", "ATAN", "EXISTS", "ATN", "POW"), "a function"),
    **dict.fromkeys(("LOGIC", "BOTH", "EITHER", "RELATION", "TIMES", "POWER", "SIGN"), "an operator"),
    **dict.fromkeys(("PLUS", "MINUS"), "a sign"),
    **dict.fromkeys(("SLASH", "DELETE"), "/"),
    **dict.fromkeys(("O", "O_NAME", "O_NUMBER"), "an O-word"),
    **dict.fromkeys(("IF", "GOTO", "GO", "WHILE", "WH", "DO", "END", "EN"), "a jump or loop of a macro"),
    "NUMBER": "a number", "NAME": "a name <…>", "OUTPUT": "an output command", "KEYWORD": "an O-word's keyword", "HASH": "#",
    "EQUAL": "=", "LSQB": "[", "RSQB": "]", "LPAR": "(", "RPAR": ")", "COMMA": "a comma", "OVER": "/[", "LINE_NUMBER": "a line number N",
    "$END": "the end of the block",
}  # fmt: skip
#: Keywords that stand behind a condition.
_FOLLOWERS = {"GOTO", "THEN", "DO"}
#: Tokens that never stand within brackets (a comma does in ATAN alone).
_OUTSIDE = ("WORD", "LETTER", "NAMED", "BSPLINE", "CORNER", "COMMENT", "MESSAGE", "I_FUNCTION", "OUTPUT", "KEYWORD", "EQUAL", "COMMA", "$END")  # fmt: skip
_PASSED = tuple(re.compile(form, re.MULTILINE | re.IGNORECASE) for form in signs.PASSED)
#: A command to grbl that moves the machine: ``$J=G91 X1``.
_JOG = re.compile(r"\s*\$[Jj]\s*=")


@dataclass(frozen=True, slots=True)
class Language:
    """A language with blanks between its tokens: the names of its tokens in messages, and what its lines consist of."""

    names: Mapping[str, str]
    hint: str


_WORD = re.compile(r"\w+")


def refusal(text: str, at: int, expected: Sequence[str], language: Language, hint: str = "") -> BlockError:
    """Return the fault of a line of such a language that is refused at a place, where some tokens were expected."""
    # Blanks of other kinds, as texts from web pages have, are no blanks of the language: they are what is refused.
    rest = text[at:].lstrip(" \t\r")
    column = len(text) - len(rest) + 1
    if not rest or rest.startswith(";"):
        rest, column = "", at + 1
    word = _WORD.match(rest)
    shown = f"'{word[0]}'" if word and len(word[0]) < 40 and word[0].isascii() else _found(rest)
    names = sorted({language.names.get(name, _NAMES.get(name, name)) for name in expected})
    message = f"{shown} where {_any_of(names)} was expected"
    return BlockError("syntax", message, column=column, hint=hint or language.hint)


def is_passed(text: str) -> bool:
    """Tell whether a line is no block, and is passed over: a command to grbl that does not jog, to a simulator, or a
    message to the operator of Eding CNC or Marlin."""
    line = text.encode("utf-8", "surrogateescape")
    return any(form.match(line) for form in _PASSED)


def syntax_error(data: bytes, reader: Parser) -> BlockError:
    """Describe the text at which the last line of `data` was refused, and the expected words."""
    text = data.decode("utf-8", "surrogateescape")
    start = data[: reader.error].decode("utf-8", "surrogateescape")
    before, rest = normalise(start), normalise(text[len(start) :])
    column = len(start) + 1 if rest else len(text.rstrip()) + 1
    if rest.startswith(("(", ")")):
        return _comment_error(rest, column)
    if _JOG.match(text):
        message = f"{text.split(';')[0].strip()} jogs under grbl, and is no block of a program"
        return BlockError("syntax", message, column=len(text) - len(text.lstrip()) + 1, hint="leave it out")
    if fault := branch_fault(before, rest):
        return BlockError("syntax", fault[0], column=column, hint=fault[1])
    letter = missing_number(before, rest)
    if letter:
        hint = number_hint(letter, before, rest)
        return BlockError("syntax", f"{letter} has no number", column=column, hint=hint)
    message = (
        f"{_found(rest)} where {_any_of(_expected_names(before, sorted(reader.expected())))} was expected"
    )
    return BlockError("syntax", message, column=column, hint=hint_for(before, rest))


def _comment_error(rest: str, column: int) -> BlockError:
    """Describe the fault of the parenthesis that begins the rest of a block."""
    if rest.startswith(")"):
        return BlockError("syntax", "a ) with no comment to close", column=column)
    if "(" in rest[1 : rest.find(")")] and ")" in rest:
        return BlockError("nested-comment", "a comment begins within a comment", column=column)
    if ")" in rest:
        message, hint = (
            "a comment stands within a word or an expression",
            "comments stand before or behind a word",
        )
        return BlockError("syntax", message, column=column, hint=hint)
    return BlockError("open-comment", "a comment ( without its )", column=column, hint="close it on its line")


def _found(rest: str) -> str:
    """Return the name of the first character of the rest of a block."""
    if not rest:
        return "the end of the block"
    first = rest[0]
    if ord(first) < 0x80:
        return f"'{first}'" if first.isprintable() else f"byte 0x{ord(first):02x}"
    import unicodedata

    shown = f"'{first}'" if first.isprintable() else "the character"
    return f"{shown} U+{ord(first):04X} ({unicodedata.name(first, 'without a name').lower()})"


def _expected_names(before: str, expected: list[str]) -> list[str]:
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
