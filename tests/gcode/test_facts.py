"""Facts of the language stand once: forms of tokens in the grammars, what a code does in its row."""

from __future__ import annotations

import ast
import re._parser as regular  # type: ignore[import-not-found]
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
#: Languages with words of their own; `signs` are evidence of what a number is not, `syntax_hints` of wrong spellings.
ELSEWHERE = {"klartext", "sinumerik", "plain_language.py", "signs.py", "syntax_hints.py"}


def _alone(item: Any) -> Any:
    """Return the one part that an item of a regular expression repeats, or the item."""
    while str(item[0]).endswith("REPEAT") and len(item[1][2]) == 1:
        (item,) = item[1][2]
    return item


def _are_digits(item: Any) -> bool:
    if not str(item[0]).endswith("REPEAT"):
        return False
    kind, value = _alone(item)
    parts = {(str(a), str(b)) for a, b in value} if str(kind) == "IN" else set()
    return parts in ({("RANGE", "(48, 57)")}, {("CATEGORY", "CATEGORY_DIGIT")})


def _is_point(item: Any) -> bool:
    kind, value = _alone(item)
    return (str(kind) == "LITERAL" and value == ord(".")) or (
        str(kind) == "IN" and [(str(a), b) for a, b in value] == [("LITERAL", ord("."))]
    )


def _parts(value: Any) -> Iterator[Any]:
    if isinstance(value, regular.SubPattern):
        yield value
    elif isinstance(value, list | tuple):
        for part in value:
            yield from _parts(part)


def _spells_number(parsed: Any) -> bool:
    """Tell whether a parsed regular expression has a point beside any number of digits, however it is written."""
    items = list(parsed)
    if any(
        (_are_digits(a) and _is_point(b)) or (_is_point(a) and _are_digits(b)) for a, b in pairwise(items)
    ):
        return True
    return any(_spells_number(part) for item in items for part in _parts(item[1]))


def _spelt(text: str) -> bool:
    try:
        return _spells_number(regular.parse(text))
    except (regular.error, OverflowError):
        return False


def test_the_look_finds_any_spelling_of_a_number() -> None:
    for text in (
        *(terminals.FANUC[name] for name in ("NUMBER", "WORD", "LINE_NUMBER")),
        r"X(?:\d++[.]?+\d*)",
        r"[0-9]+(?:\.[0-9]+)?",
    ):
        assert _spelt(text), text
    assert not _spelt(r"[XYZ][ \t]*[-+.\d#\[]")


def test_numbers_are_spelt_in_the_grammars_alone() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{node.lineno}: {node.value!r}"
        for path in ROOT.rglob("*.py")
        if ELSEWHERE.isdisjoint(path.relative_to(ROOT).parts)
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str | bytes)
        if _spelt(node.value if isinstance(node.value, str) else node.value.decode("latin-1"))
    ]
    assert found == []


@pytest.mark.parametrize("dialect", [*BOTH, *LATHES])
def test_one_code_restores_each_mode(dialect: str) -> None:
    counts = Counter(row.restores for row in table(dialect).values() if row.restores[0])
    assert {pair: count for pair, count in counts.items() if count > 1} == {}
    if dialect == "linuxcnc":
        # F and S are words, which come back as such.
        assert {field for field, _ in counts} == {*Saved.__slots__, "overrides"} - {"feed", "speed"}
