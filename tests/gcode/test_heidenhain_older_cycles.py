"""Older cycles of Heidenhain: 230 faces in rows, 210 to 215 finish pockets, studs and slots; worked out by hand, tool 1 has the radius 4."""

from __future__ import annotations

import math
from typing import Any

import pytest

PLAIN = "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S1000 F350\n"
END = "\nCYCL CALL\n9 END PGM T MM\n"
LEVELS = " Q200=+2 ~\n Q201=-10 ~\n Q207=+500 ~\n Q202=+5 ~\n Q206=+150 ~\n Q203=+0 ~\n Q204=+50 ~\n Q216=+50 ~\n Q217=+40"

FACE = (
    "CYCL DEF 230 MULTIPASS MILLNG ~\n Q225=+10 ~\n Q226=+12 ~\n Q227=+2.5 ~\n Q218={length} ~\n Q219=+28 ~\n Q240={rows} ~\n"
    " Q206=+150 ~\n Q207=+500 ~\n Q209=+200 ~\n Q200=+2"
)


@pytest.mark.parametrize(
    ("length", "rows", "expected"),
    [
        # Rows at 12 + 4, and 12 + 28 - 4, and in the middle; the tool is 4 beyond both ends.
        (150, 3, [(6, 16, 2.5, 150), (164, 16, 2.5, 500), (164, 26, 2.5, 200), (6, 26, 2.5, 500), (6, 36, 2.5, 200), (164, 36, 2.5, 500)]),
        # A length below 0 goes to the left; one row lies in the middle.
        (-150, 1, [(14, 26, 2.5, 150), (-144, 26, 2.5, 500)]),
    ],
)  # fmt: skip
def test_face(moves: Any, length: float, rows: int, expected: list[Any]) -> None:
    found = moves(PLAIN + FACE.format(length=length, rows=rows) + END)
    x, y = expected[0][:2]
    assert found[:2] == [(x, y, 0, 0), (x, y, 4.5, 0)]
    assert found[2:-1] == expected
    assert found[-1] == (*expected[-1][:2], 4.5, 0)


def _around(loop: list[tuple[float, float]], place: tuple[float, float]) -> list[Any]:
    """The two levels: down at the place, around, back to the place."""
    return [
        move
        for z in (-5, -10)
        for move in ((*place, z, 150), *((x, y, z, 500) for x, y in loop), (*place, z, 500))
    ]


POCKET = "CYCL DEF 212 POCKET FINISHING ~\n Q218=+40 ~\n Q219=+30 ~\n Q220=+5 ~\n Q221=+2 ~\n" + LEVELS
STUD = "CYCL DEF 213 STUD FINISHING ~\n Q218=+40 ~\n Q219=+20 ~\n Q220=+0 ~\n Q221=+2 ~\n" + LEVELS
CIRCLE = "CYCL DEF {cycle} C. FINISHING ~\n Q222={blank} ~\n Q223=+30 ~\n" + LEVELS
R11 = [(50, 29), (61, 40), (50, 51), (39, 40), (50, 29)]
R19 = [(69, 40), (50, 21), (31, 40), (50, 59), (69, 40)]


@pytest.mark.parametrize(
    ("body", "place", "loop"),
    [
        # 36 by 26 less the tool: half lengths 16 and 11, corners 5 - 4; down 2 + 4 from the tool's path, counter-clockwise.
        (POCKET, (50, 35), [(50, 29), (65, 29), (66, 30), (66, 50), (65, 51), (35, 51), (34, 50), (34, 30), (35, 29), (50, 29)]),
        # Beside a stud of 40 by 20, at 3.5 radii: 50 + 20 + 14; clockwise, corners rounded by the tool.
        (STUD, (84, 40), [(74, 40), (74, 30), (70, 26), (30, 26), (26, 30), (26, 50), (30, 54), (70, 54), (74, 50), (74, 40)]),
        (CIRCLE.format(cycle=214, blank=28), (50, 34), R11),
        # Without a blank the tool goes down in the middle.
        (CIRCLE.format(cycle=214, blank=0), (50, 40), R11),
        (CIRCLE.format(cycle=215, blank=34), (79, 40), R19),
    ],
)  # fmt: skip
def test_finishing(
    moves: Any, body: str, place: tuple[float, float], loop: list[tuple[float, float]]
) -> None:
    found = moves(PLAIN + body + END)
    before = [(0, 0, 50, 0), (50, 40, 50, 0), (*place, 50, 0), (*place, 2, 0)]
    expected = [*before, *_around(loop, place), (*place, 50, 0), (50, 40, 50, 0)]
    # What does not move is not there: the middle where the tool goes down in it.
    assert found == [move for k, move in enumerate(expected) if k == 0 or move[:3] != expected[k - 1][:3]]


SLOT = (
    "CYCL DEF 210 SLOT RECIP. PLNG ~\n Q215={kind} ~\n Q218=+60 ~\n Q219=+12 ~\n Q224={turn} ~\n Q338={infeed} ~\n"
    + LEVELS
)
#: To and fro along the middle, 2.5 deeper each way, at 10 once more; the ends are 30 - 6 from the middle.
PLUNGE = [(26, 40, 0, 500), (74, 40, -2.5, 500), (26, 40, -5, 500), (74, 40, -7.5, 500), (26, 40, -10, 500), (74, 40, -10, 500), (50, 40, -10, 500)]  # fmt: skip
#: Around, 6 - 4 beside the middle, from the left end.
SIDES = [(24, 40), (26, 38), (74, 38), (74, 42), (26, 42), (24, 40), (26, 40)]


@pytest.mark.parametrize(
    ("kind", "turn", "infeed", "expected"),
    [
        (1, 0, 0, PLUNGE),
        (0, 0, 0, [*PLUNGE, (26, 40, -10, 500), *[(*place, -10, 500) for place in SIDES]]),
        (2, 0, 6, [(26, 40, -6, 150), *[(*place, -6, 500) for place in SIDES], (26, 40, -10, 150), *[(*place, -10, 500) for place in SIDES]]),
        # Turned by 90 degrees, x - 50 is y - 40 and y - 40 is 50 - x.
        (1, 90, 0, [(50 - (y - 40), 40 + (x - 50), z, f) for x, y, z, f in PLUNGE]),
    ],
)  # fmt: skip
def test_slot(moves: Any, kind: int, turn: float, infeed: float, expected: list[Any]) -> None:
    found = moves(PLAIN + SLOT.format(kind=kind, turn=turn, infeed=infeed) + END)
    begin = expected[0][:2]
    assert found[:3] == [(0, 0, 50, 0), (*begin, 50, 0), (*begin, 2, 0)]
    assert found[3:-1] == expected
    assert found[-1] == (*expected[-1][:2], 50, 0)


def test_slot_of_a_control_without_q206(moves: Any, run: Any) -> None:
    """TNC 426 gives 210 the one feed Q207: the finisher goes down at it, not at the Q206 of the drilling before, and nothing is missing."""
    drill = "CYCL DEF 200 DRILLING ~\n Q200=2 ~\n Q201=-5 ~\n Q206=70 ~\n Q202=5 ~\n Q210=0 ~\n Q203=0 ~\n Q204=50 ~\n Q211=0\n"
    text = PLAIN + drill + SLOT.format(kind=2, turn=0, infeed=0).replace(" Q206=+150 ~\n", "") + END
    assert moves(text)[3] == (26, 40, -10, 500)
    assert "cycle-parameters" not in [d.code for d in run(text).diagnostics]


BOW = (
    "CYCL DEF 211 CIRCULAR SLOT ~\n Q215={kind} ~\n Q244=+80 ~\n Q219=+12 ~\n Q245=+0 ~\n Q248=+90 ~\n Q338=+0 ~\n"
    + LEVELS
)


def test_bow(moves: Any) -> None:
    """The middle line is a quarter of a circle of 40 about 50, 40; around at 42 and 38."""
    found = moves(PLAIN + BOW.format(kind=0) + END)
    half = 40 * math.sqrt(0.5)
    middle = (pytest.approx(50 + half), pytest.approx(40 + half))
    levels = (-2.5, -5, -7.5, -10, -10)
    plunge = [((50, 80) if k % 2 == 0 else (90, 40)) + (z, 500) for k, z in enumerate(levels)]
    around = [(92, 40), (50, 82), (50, 78), (88, 40), (92, 40), (90, 40)]
    assert found == [
        (0, 0, 50, 0), (90, 40, 50, 0), (90, 40, 2, 0), (90, 40, 0, 500), *plunge, (*middle, -10, 500), (90, 40, -10, 500),
        *[(*place, -10, 500) for place in around], (90, 40, 50, 0),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("body", "code"),
    [
        (FACE.format(length=150, rows=0), "cycle-infeed"),
        (FACE.format(length=150, rows=2).replace("Q206=+150", "Q206=+0"), "feed-missing"),
        (FACE.format(length=0, rows=2), "cycle-infeed"),
        (POCKET.replace("Q219=+30", "Q219=+7"), "cycle-tool"),
        (POCKET.replace("Q202=+5", "Q202=+.0001"), "cycle-infeed"),
        (STUD.replace("Q207=+500", "Q207=+0"), "feed-missing"),
        (SLOT.format(kind=0, turn=0, infeed=0).replace("Q218=+60", "Q218=+10"), "cycle-words"),
        (SLOT.format(kind=3, turn=0, infeed=0), "cycle-tool"),
        (SLOT.format(kind=0, turn=0, infeed=0).replace("Q219=+12", "Q219=+30"), "cycle-tool"),
        (BOW.format(kind=0).replace("Q248=+90", "Q248=+0"), "cycle-words"),
    ],
)
def test_what_is_wrong(run: Any, tmp_path: Any, body: str, code: str) -> None:
    table = tmp_path / "tool.tbl"
    table.write_text("T1 P1 D8\n")
    assert [e[0] for e in run(PLAIN + body + END, tool_table=table).errors] == [code]
