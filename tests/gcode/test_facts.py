"""Facts of the language stand once: forms of tokens in the grammars, what a code does in its row."""

from __future__ import annotations

import ast
import re
import re._parser as regular  # type: ignore[import-not-found]
import warnings
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from cncgen.grammars import terminals

from cncgen.gcode.codes.saved import Saved
from cncgen.gcode.codes.table import BOTH, LATHES, table

ROOT = Path(__file__).resolve().parents[2] / "cncgen" / "gcode"
#: What spells tokens by itself, and why.
OWN = {
    "text/syntax_hints.py": "spellings that are wrong in the grammars",
    "sinks/printing.py": "the digits that rs274 prints of an N word, whose blanks it does not pass over",
}
_GROUPS = re.compile(
    r"(\\.|\[\^?\]?(?:\\.|[^\]\\])*\])|\((?:\?(?:P<\w+>|[aimsux-]*:|[aimsux]+\)|<?[=!]|>))?|\)(?:[*+?]|\{\d*,?\d*\})?[+?]?",
    re.S,
)
_DIGITS = frozenset("0123456789")


def _flat(text: str) -> str:
    """Return a regular expression without its groups, so that a part of one can be read as well."""
    return _GROUPS.sub(lambda match: match[1] or "", text)


def _repeats(item: Any) -> bool:
    return str(item[0]).endswith("REPEAT")


def _many(item: Any) -> bool:
    return _repeats(item) and str(item[1][1]) == "MAXREPEAT"


def _characters(item: Any) -> set[str]:
    """Return the characters of the one part that an item repeats, or of the item; none of a negative set."""
    while _repeats(item) and len(item[1][2]) == 1:
        (item,) = item[1][2]
    kind, value = str(item[0]), item[1]
    if kind == "LITERAL":
        return {chr(value)}
    found: set[str] = set()
    for part, of in value if kind == "IN" else ():
        if str(part) == "NEGATE":
            return set()
        if str(part) == "LITERAL":
            found.add(chr(of))
        elif str(part) == "RANGE":
            found.update(map(chr, range(of[0], min(of[1], 255) + 1)))
        else:
            found.update({"CATEGORY_DIGIT": "0123456789", "CATEGORY_SPACE": " \t"}.get(str(of), "_!"))
    return found


def _sequences(parsed: Any) -> Iterator[list[Any]]:
    yield list(parsed)
    for item in parsed:
        if str(item[0]) == "BRANCH":
            for branch in item[1][1]:
                yield from _sequences(branch)


def _letters(item: Any) -> set[str]:
    found = _characters(item)
    return {c.upper() for c in found} if all(c.isalpha() or c in "@^$" for c in found) else set()


def _is_comment(first: Any, second: Any) -> bool:
    rest = str(second[1][2][0][0]) if _many(second) else ""
    return _characters(first) in ({"("}, {";"}) and rest in ("IN", "NOT_LITERAL") and not _characters(second)


def _is_number(first: Any, second: Any) -> bool:
    """Tell whether a point stands beside any number of digits."""
    return any(
        _repeats(a) and _characters(a) == _DIGITS and "." in _characters(b) and _characters(b) <= set(".,")
        for a, b in ((first, second), (second, first))
    )


def _spelt(text: str) -> set[str]:
    """Return the kinds of tokens that a regular expression, or a part of one, spells however it is written."""
    if not any(part in text for part in ("\\d", "0-9", "[^")):
        return set()
    try:
        with warnings.catch_warnings(action="ignore"):
            parsed = regular.parse(_flat(text))
    except (regular.error, OverflowError):
        return set()
    found = set()
    for items in _sequences(parsed):
        if any(_many(i) and _DIGITS < _characters(i) <= _DIGITS | set(".,+-") for i in items):
            found.add("number")
        if any(_is_number(a, b) for a, b in pairwise(items)):
            found.add("number")
        solid = [i for i in items if not _characters(i) or not _characters(i) <= set(" \t\r")]
        if any(_is_comment(a, b) for a, b in pairwise(solid)):
            found.add("comment")
        for before, a, b, c in zip([None, *solid], solid, solid[1:], [*solid[2:], None], strict=False):
            digits = c if c and _characters(b) and _characters(b) <= set("+-") else b
            if _letters(a) == {"N"} and _characters(b) == _DIGITS and not (before and _letters(before)):
                found.add("N word")
            if len(_letters(a)) > 1 and _many(digits) and _characters(digits) == _DIGITS:
                found.add("word")
    return found


def test_the_look_finds_any_spelling() -> None:
    for grammar in (terminals.LINUXCNC, terminals.FANUC):
        assert "N word" in _spelt(grammar["LINE_NUMBER"])
        assert "comment" in _spelt(grammar["COMMENT"])
        assert {"word", "number"} <= _spelt(grammar["WORD"])
    for number in ("NUMBER", "SIGNED", "BEHIND_POINT"):
        assert "number" in _spelt(terminals.HEIDENHAIN[number])
    assert "N word" in _spelt(terminals.SINUMERIK["BLOCK_NUMBER"])
    for text in (r"X(?:\d++[.]?+\d*)", r"[0-9]+(?:\.[0-9]+)?", r"(?:Z[-+.\d]+", r"\d[\d.]*)"):
        assert "number" in _spelt(text), text
    for text in (r"^[ \t]*(?:[nN][ \t]*\d+)?", r"(?:N?[0-9]"):
        assert "N word" in _spelt(text), text
    assert "word" in _spelt(r"[XYZ]\s*[-+]?(\d+")
    assert _spelt(r"FN[ \t]*\d|[XYZ][ \t]*[-+.\d#\[]|G0?4P[1-9]\d") == set()


def test_tokens_are_spelt_in_the_grammars_alone() -> None:
    """Numbers, words, comments and N words: what else looks at a text takes its forms from ``terminals.py``."""
    found = [
        f"{path.relative_to(ROOT)}:{node.lineno}: {kinds} {node.value!r}"
        for path in ROOT.rglob("*.py")
        if str(path.relative_to(ROOT)) not in OWN
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str | bytes)
        if (kinds := _spelt(node.value if isinstance(node.value, str) else node.value.decode("latin-1")))
    ]
    assert found == []


@pytest.mark.parametrize("dialect", [*BOTH, *LATHES])
def test_one_code_restores_each_mode(dialect: str) -> None:
    counts = Counter(row.restores for row in table(dialect).values() if row.restores[0])
    assert {pair: count for pair, count in counts.items() if count > 1} == {}
    if dialect == "linuxcnc":
        # F and S are words, which come back as such.
        assert {field for field, _ in counts} == {*Saved.__slots__, "overrides"} - {"feed", "speed"}
