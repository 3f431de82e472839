"""The list of codes: complete, alike in the docs, and every code stands in a test or a program."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from cncgen import extensions
from cncgen.gcode.codes.reference import DIALECTS, codes, markdown, rows
from cncgen.gcode.codes.table import _MODULES, ALONE, OFFSET_NUMBERS, Codes

ROOT = Path(__file__).resolve().parent.parent.parent


def test_the_docs_hold_the_table() -> None:
    """Where this fails: paste `cncgen.gcode.codes.reference.markdown()` at the end of docs/language.md."""
    text = (ROOT / "docs" / "language.md").read_text("utf-8")
    assert text.endswith("## Codes\n\n" + markdown())


def test_every_code_has_a_line_of_help() -> None:
    for dialect in DIALECTS:
        for code in codes(dialect):
            assert code.help
            assert "\n" not in code.help
            assert code.dialects


def test_codes_are_listed_in_order() -> None:
    names = [name for name, *_ in rows() if name[0] == "G"]
    numbers = [float(name[1:]) for name in names]
    assert numbers == sorted(numbers)


def test_each_code_is_of_one_module() -> None:
    """Modules are imported until a code is found, so no later one may have it too; words by themselves are known."""
    found: set[tuple[str, str, int]] = set()
    for module in _MODULES:
        for code in import_module(f"cncgen.gcode.{module}").CODES:
            for dialect in code.dialects:
                key = dialect, code.letter, code.number
                assert key not in found
                found.add(key)
    assert {(letter, number) for _, letter, number in found if letter not in "GM"} == {
        (x, 0) for x in ALONE + OFFSET_NUMBERS
    }
    assert {(letter, number) for dialect, letter, number in found if dialect == "fanuc"} == set(
        Codes("fanuc")
    )


@pytest.mark.parametrize("dialect", extensions.DIALECTS)
def test_a_code_has_one_row_in_a_dialect(dialect: str) -> None:
    """Whichever code a program has first: modules are imported until it is found."""
    whole = Codes(dialect)
    assert all(Codes(dialect)[key] is whole[key] for key in list(whole))


def test_modules_are_imported_as_codes_need_them() -> None:
    """A table finds any code first, last and in any order, and says what there is not."""
    for wanted in (("G", 10), ("G", 720), ("F", 0), ("M", 20)):
        codes = Codes("linuxcnc")
        assert codes[wanted].number == wanted[1]
        assert codes.get(("G", 9990)) is None
        assert len(codes) == len(set(codes)) > 150


def test_dwells_by_dialect(run: Any) -> None:
    assert run("G4 P0.5\nM2").path.events[0].dwell_s == 0.5
    assert run("G04 P500\nM30", dialect="fanuc").path.events[0].dwell_s == 0.5
    assert run("G04 X0.5\nM30", dialect="fanuc").path.events[0].dwell_s == 0.5
    assert run("G04\nM2").errors == [("dwell-time", 1, 1)]
    stop = run("G21 G64 G1 X1 F9\nG04\nX2\nM30", dialect="fanuc")
    assert stop.errors == []
    assert [d.span.line for d in stop.diagnostics if d.code == "dwell-time" and d.span] == [2]
    assert [event.dwell_s for event in stop.path.events if event.name == "dwell" and event.rest] == [0.0]


def test_feed_modes_said_again(run: Any) -> None:
    text = "F100\nG94\nG1 X1\nM30"
    assert run(text).errors == [("feed-missing", 3, 1)]
    assert run(text, dialect="fanuc").errors == []
