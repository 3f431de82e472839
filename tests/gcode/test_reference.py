"""The list of codes: complete, alike in the docs, and every code stands in a test or a program."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cncgen.gcode.reference import DIALECTS, codes, markdown, rows

ROOT = Path(__file__).resolve().parent.parent.parent


def test_the_docs_hold_the_table() -> None:
    """Where this fails: paste `cncgen.gcode.reference.markdown()` at the end of docs/language.md."""
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


def test_dwells_by_dialect(run: Any) -> None:
    assert run("G4 P0.5\nM2").path.events[0].dwell_s == 0.5
    assert run("G04 P500\nM30", dialect="fanuc").path.events[0].dwell_s == 0.5
    assert run("G04 X0.5\nM30", dialect="fanuc").path.events[0].dwell_s == 0.5
    assert run("G04\nM30", dialect="fanuc").errors == [("dwell-time", 1, 1)]


def test_feed_modes_said_again(run: Any) -> None:
    text = "F100\nG94\nG1 X1\nM30"
    assert run(text).errors == [("feed-missing", 3, 1)]
    assert run(text, dialect="fanuc").errors == []
