"""Heidenhain: Q parameters that are read before anything sets them, and what other statements of newer controls do.

Q parameters are "globally effective for all programs stored in the TNC memory" (TNC 640, "Q parameters"): a program that reads one before it
sets it depends on the program that ran before.
"""

from __future__ import annotations

from typing import Any

import pytest

HEAD = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S500 F100\n"


def told(run: Any, lines: str) -> list[tuple[int, int, str]]:
    """Return line, column and first words of the warnings of unset parameters."""
    out = run(f"{HEAD}{lines}\n9 END PGM A MM\n", dialect="heidenhain")
    assert out.errors == []
    return [
        (d.span.line, d.span.column, d.message.partition(" read")[0])
        for d in out.diagnostics
        if d.code == "variable-assumed"
    ]


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ("2 L X+Q1 Y-Q2 R0 FMAX", [(3, 7, "Q1, Q2 are")]),
        ("2 L X+QL1 Y+QR2 FMAX\n3 Q3 = Q99 + Q1400 * Q1999 + QR2", [(3, 7, "QL1, QR2, Q99 and 2 more are")]),
        ("2 Q7 = Q7 + 1", [(3, 3, "Q7 is")]),
        # Read first, set behind: nothing but a program before can have set it.
        ("2 L X+Q1 FMAX\n3 Q1 = 5", [(3, 7, "Q1 is")]),
        # Set before, by a formula, a function, a cycle or a label that was called.
        ("2 Q1 = 5\n3 L X+Q1 FMAX", []),
        ("2 FN 18: SYSREAD Q1 = ID50 NR1 IDX1\n3 L X+Q1 FMAX", []),
        ("2 CALL LBL 1\n3 L X+Q1 FMAX\n4 L M30\n5 LBL 1\n6 Q1 = 5\n7 LBL 0", []),
        ("2 Q1 = 0\n3 LBL 1\n4 Q1 = Q1 + 1\n5 L X+Q1 FMAX\n6 CALL LBL 1 REP 2", []),
        # Parameters of the control and of cycles; names and comments.
        ("2 L X+Q108 FMAX ; Q5", []),
        ('2 CALL LBL "Q5"\n3 L M30\n4 LBL "Q5"\n5 LBL 0', []),
    ],
)
def test_parameters_that_nothing_sets_are_told(
    run: Any, lines: str, expected: list[tuple[int, int, str]]
) -> None:
    """They counted as 0 without a word."""
    assert told(run, lines) == expected


def test_q0_is_a_parameter(moves: Any) -> None:
    """Q0 to Q99 are the user's (TNC 7, "Variable types"); Q0 was refused."""
    text = f"{HEAD}2 Q0 = 4\n3 FN 1: Q1 = +Q0 + +1\n4 L X+Q0 Y+Q1 R0 FMAX\n9 END PGM A MM\n"
    assert moves(text, dialect="heidenhain")[-1][:2] == (4, 5)


@pytest.mark.parametrize("words", ["DR2:+0.05", "DR2+0.05", "DL+0.2 DR-1 DR2:+0.05"])
def test_the_oversize_of_a_corner_radius_may_have_a_colon(run: Any, words: str) -> None:
    """TNC 640, "Delta values": TOOL CALL 5.2 Z S2500 F350 DL+0.2 DR-1 DR2:+0.05."""
    out = run(
        f"0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S500 {words}\n2 L X+1 FMAX\n9 END PGM A MM\n",
        dialect="heidenhain",
    )
    assert out.errors == []


@pytest.mark.parametrize(
    ("select", "x"),
    [("PRESET SELECT #1", 4), ("PRESET SELECT #1 WP", 4), ("PRESET SELECT #1 KEEP TRANS", 14), ("PRESET SELECT #1 KEEP TRANS WP", 14)],
)  # fmt: skip
def test_preset_select_ends_shifts_but_where_it_keeps_them(moves: Any, select: str, x: float) -> None:
    """As cycle 247, which ends the shift of 10; KEEP TRANS keeps it."""
    text = f"{HEAD}2 TRANS DATUM AXIS X+10\n3 {select}\n4 L X+4 R0 FMAX\n9 END PGM A MM\n"
    assert moves(text, dialect="heidenhain")[-1][0] == x


def test_a_preset_by_name_is_refused(run: Any) -> None:
    out = run(f'{HEAD}2 PRESET SELECT "VICE"\n9 END PGM A MM\n', dialect="heidenhain")
    assert [(code, line) for code, line, _ in out.errors] == [("unsupported-block", 3)]


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ("N20 G00 G40 G90 X+Q1 Y+Q2 *", [(3, 19, "Q1, Q2 are")]),
        ("N20 D00 Q1 P01 +5 *\nN30 D01 Q2 P01 +Q1 P02 +Q3 *", [(4, 25, "Q3 is")]),
        ("N20 D00Q1 P01 +5 *\nN30 D09 P01 +Q1 P02 +0 P03 7 *\nN40 G98 L7 *", []),
        ("N20 L1,0 *\nN30 G00 X+Q1 M2 *\nN40 G98 L1 *\nN50 D00 Q1 P01 +5 *\nN60 G98 L0 *", []),
    ],
)
def test_they_are_told_in_din_iso(run: Any, lines: str, expected: list[tuple[int, int, str]]) -> None:
    out = run(f"%A G71 *\nN10 T1 G17 S500 *\n{lines}\nN99 %A G71 *\n", dialect="heidenhain")
    assert out.errors == []
    unset = [d for d in out.diagnostics if d.code == "variable-assumed"]
    assert [(d.span.line, d.span.column, d.message.partition(" read")[0]) for d in unset] == expected


def test_a_formula_in_several_lines_is_shown_as_it_stands(run: Any) -> None:
    """It stood in one line in messages, and its number was that of its first line."""
    lines = "2 Q1 = 5 + ~\n    3 * ~\n    Ü7 ; remark\n3 Q2 = Q1 + ~\n   Q8\n4 L X+Q1 Y+ FMAX"
    found = [d for d in run(f"{HEAD}{lines}\n9 END PGM A MM\n", dialect="heidenhain").diagnostics if d.span]
    assert [(d.code, d.span.line, d.span.column, d.excerpt) for d in found if d.code != "dialect"][1:] == [
        ("syntax", 5, 5, "    Ü7 ; remark"),
        ("syntax", 8, 13, "4 L X+Q1 Y+ FMAX"),
        ("variable-assumed", 7, 4, "   Q8"),
    ]
