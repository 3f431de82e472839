"""Programs of Heidenhain's user's manuals ("Programming contours", iTNC 530 and TNC 426), with the motions that their drawings and rules give."""

from __future__ import annotations

import math
from typing import Any

import pytest

HEAD = "BLK FORM 0.1 Z X+0 Y+0 Z-20\nBLK FORM 0.2 X+100 Y+100 Z+0\nTOOL DEF 2 L+0 R+{radius}\nTOOL CALL 2 Z S4000\n"
END = "L Z+250 R0 F MAX M2"
LINEAR = (
    "L Z+250 R0 F MAX\nL X-10 Y-10 R0 F MAX\nL Z-5 R0 F1000 M3\nAPPR LT X+5 Y+5 LEN10 RL F300\nL Y+95\nL X+95\nCHF 10\nL Y+5\nCHF 20\n"
    "L X+5\nDEP LT LEN10 F1000\n"
)
CIRCULAR = (
    "L Z+250 R0 F MAX\nL X-10 Y-10 R0 F MAX\nL Z-5 R0 F1000 M3\nAPPR LCT X+5 Y+5 R5 RL F300\nL X+5 Y+85\nRND R10 F150\nL X+30 Y+85\n"
    "CR X+70 Y+95 R+30 DR-\nL X+95\nL X+95 Y+40\nCT X+40 Y+5\nL X+5\nDEP LCT X-20 Y-20 R5 F1000\n"
)
FULL = (
    "CC X+50 Y+50\nL Z+250 R0 F MAX\nL X-40 Y+50 R0 F MAX\nL Z-5 R0 F1000 M3\nAPPR LCT X+0 Y+50 R5 RL F300\nC X+0 DR-\n"
    "DEP LCT X-40 Y+50 R5 F1000\n"
)
POLAR = (
    "CC X+50 Y+50\nL Z+250 R0 F MAX\nLP PR+60 PA+180 R0 F MAX\nL Z-5 R0 F1000 M3\nAPPR PLCT PR+45 PA+180 R5 RL F250\nLP PA+120\nLP PA+60\n"
    "LP PA+0\nLP PA-60\nLP PA-120\nLP PA+180\nDEP PLCT PR+60 PA+180 R5 F1000\n"
)
HELIX = (
    "L Z+250 R0 F MAX\nL X+50 Y+50 R0 F MAX\nCC\nL Z-12.75 R0 F1000 M3\nAPPR PCT PR+32 PA-180 CCA180 R+2 RL F100\n"
    "CP IPA+3240 IZ+13.5 DR+ F200\nDEP CT CCA180 R+2\n"
)
TURNS = HELIX.replace("CP IPA+3240 IZ+13.5 DR+ F200", "LBL 1\nCP IPA+360 IZ+1.5 DR+ F200\nCALL LBL 1 REP 8")


def program(body: str, radius: float) -> str:
    """Return a program with its numbers."""
    lines = f"BEGIN PGM M MM\n{HEAD.format(radius=radius)}{body}{END}\nEND PGM M MM".split("\n")
    return "\n".join(f"{k} {line}" for k, line in enumerate(lines)) + "\n"


def test_linear_movements(moves: Any) -> None:
    """A square of 5 to 95, outside, radius 10: to 10 before the first point at the feed before, on at F300; off along the last side."""
    found = moves(program(LINEAR, 10))
    begin = [(0, 0, 250, 0), (-10, -10, 250, 0), (-10, -10, -5, 1000), (-5, -5, -5, 1000), (-5, 5, -5, 300)]
    assert found[:5] == begin
    root = 10 * math.sqrt(0.5)
    at = [(-5, 95), (5, 105), (85, 105), (85 + root, 95 + root), (95 + root, 85 + root), (105, 85), (105, 25), (95 + root, 25 - root),
          (75 + root, 5 - root), (75, -5), (5, -5)]  # fmt: skip
    assert [move[:2] for move in found[5:-2]] == [(pytest.approx(x), pytest.approx(y)) for x, y in at]
    assert found[-2:] == [(-5, -5, -5, 1000), (-5, -5, 250, 0)]


def test_circular_movements(moves: Any) -> None:
    """R5 of APPR and DEP is the arc of the middle of a tool of radius 10: beside (5, 5) it is 5 from (-10, 5)."""
    found = moves(program(CIRCULAR, 10))
    assert found[4][:2] == (-5, 5)
    assert math.hypot(found[3][0] + 10, found[3][1] - 5) == pytest.approx(5)
    assert found[-4][:2] == (5, -5)
    assert math.hypot(found[-3][0] - 5, found[-3][1] + 10) == pytest.approx(5)
    assert found[-2] == (-20, -20, -5, 1000)


def test_a_full_circle_behind_an_approach(calls: Any) -> None:
    """C X+0 DR- is once around 50, 50: from beside its first point to there, at 50 and the radius of the tool, 12.5."""
    arcs = [call for call in calls(program(FULL, 12.5), inch_tables=False) if call.startswith("ARC_FEED")]
    assert [call.split("(")[1].split(",")[:5] for call in arcs][1] == [
        "-12.5000", " 50.0000", " 50.0000", " 50.0000", " -1",
    ]  # fmt: skip
    assert len(arcs) == 3


def test_polar_lines(moves: Any) -> None:
    """A hexagon of 45: the tool of radius 7.5 stays that far from its sides, and comes and goes in polar coordinates."""
    found = moves(program(POLAR, 7.5))
    around = found[4:-4]
    assert min(math.hypot(x - 50, y - 50) for x, y, _, _ in around) > 45 * math.cos(math.pi / 6) + 7.5
    (ax, ay), (bx, by) = found[4][:2], found[5][:2]
    side = abs((ax - 50) * (by - ay) - (ay - 50) * (bx - ax)) / math.hypot(bx - ax, by - ay)
    assert side == pytest.approx(45 * math.cos(math.pi / 6) + 7.5)
    assert found[-2] == (-10, 50, -5, 1000)


@pytest.mark.parametrize(("body", "rounds"), [(HELIX, [9]), (TURNS, [1] * 9)])
def test_a_helix(calls: Any, moves: Any, body: str, rounds: list[int]) -> None:
    """M64 x 1.5 inside: nine turns at 32 - 5 about 50, 50, up by 13.5; on and off in half circles of 2."""
    found = calls(program(body, 5), inch_tables=False)
    arcs = [call.split("(")[1].split(",") for call in found if call.startswith("ARC_FEED")]
    assert [[float(v) for v in arc[:4]] for arc in (arcs[0], arcs[-1])] == [
        [23, 50, 25, 50],
        [27, 50, 25, 50],
    ]
    assert [(float(arc[2]), float(arc[3]), int(arc[4])) for arc in arcs[1:-1]] == [
        (50, 50, n) for n in rounds
    ]
    assert [move[3] for move in moves(program(body, 5))[2:5]] == [1000, 1000, 100]


def test_a_circle_without_an_angle_is_a_whole_one(calls: Any) -> None:
    """CP DR+ alone goes around once: the pass along the floor of HEIDENHAIN's NC Solutions 11101, behind CP IPA+9000 DR+, 25 turns."""
    text = program("CC X+0 Y+0\nLP PR+2 PA+0 R0 FMAX\nCP IPA+9000 Z-30 DR+ F500\nCP DR+\n", 5)
    arcs = [
        call.split("(")[1].split(",")
        for call in calls(text, inch_tables=False)
        if call.startswith("ARC_FEED")
    ]
    assert [[float(v) for v in arc[:6]] for arc in arcs] == [[2, 0, 0, 0, 25, -30], [2, 0, 0, 0, 1, -30]]


def test_the_way_before_an_approach_is_a_traverse_behind_one(moves: Any) -> None:
    """ "If you programmed FMAX in the last positioning block before", the tool traverses to where the approach begins; not so with LCT."""
    text = program(
        "L Z-5 R0 F MAX\nL X-30 Y+0 F MAX\nAPPR LT X+0 Y+0 LEN10 RL F300\nL Y+95\nDEP LT LEN5\n", 2
    )
    assert moves(text)[2:4] == [(-2, -10, -5, 0), (-2, 0, -5, 300)]
    text = program("L Z-5 R0 F MAX\nL X-30 Y+0 F MAX\nAPPR LCT X+0 Y+0 R5 RL F300\nL Y+95\nDEP LT LEN5\n", 2)
    assert [move[3] for move in moves(text)[2:4]] == [300, 300]


def test_the_contour_behind_an_approach_has_its_corners(moves: Any) -> None:
    """The first element behind APPR is no way to the contour: an inner corner lies where the offset paths cross."""
    text = program("L X-30 Y+0 F500\nAPPR LT X+0 Y+0 LEN10 RR F300\nL Y+50\nL X+40\nDEP LT LEN5\n", 2)
    assert (2, 48, 0, 300) in moves(text)


def test_repeats_that_a_parameter_counts(moves: Any) -> None:
    text = program("Q7 = 2\nLBL 1\nL IX+1 R0 F100\nCALL LBL 1 REP Q7\n", 2)
    assert [move[0] for move in moves(text)[:-1]] == [1, 2, 3]


def test_a_table_is_stronger_than_a_definition(run: Any, tmp_path: Any) -> None:
    table = tmp_path / "tools.tbl"
    table.write_text("T2 P2 D8\n")
    out = run(program("L X+10 RL F100\nL Y+10\n", 2), tool_table=table)
    assert [d.code for d in out.diagnostics if d.code == "tool-defined"] == ["tool-defined"]
    assert out.path.end[out.path.kind < 3][0, :2] == pytest.approx([6, 0])
    out = run(program("L X+10 RL F100\nL Y+10\n", 2))
    assert [d.code for d in out.diagnostics if d.code in ("tool-defined", "no-tool-table")] == []
    assert out.path.end[out.path.kind < 3][0, :2] == pytest.approx([8, 0])


def test_a_polar_arc_that_goes_on(moves: Any) -> None:
    """CTP ends 30 from the pole at 30 degrees (iTNC 530, "CTP"); it leaves 25 at 120 degrees along the line before."""
    text = program("CC X+40 Y+35\nL X+0 Y+35 F250\nLP PR+25 PA+120\nCTP PR+30 PA+30\n", 2)
    end = moves(text)[2]
    assert end[:2] == (pytest.approx(40 + 30 * math.cos(math.pi / 6)), pytest.approx(50))


def test_a_thread_is_cut_from_where_the_tool_is(moves: Any, run: Any) -> None:
    """18: to the depth at the pitch, where the spindle stops; ways on and off are the program's."""
    text = program(
        "L Z-5 R0 FMAX\nCYCL DEF 18.0 THREAD CUTTING\nCYCL DEF 18.1 DEPTH -20\nCYCL DEF 18.2 PITCH {}\nCYCL CALL\n",
        2,
    )
    assert moves(text.format("+1"))[:2] == [(0, 0, -5, 0), (0, 0, -25, 4000)]
    assert [e[0] for e in run(text.format("+0")).errors] == ["cycle-words"]


@pytest.mark.parametrize("number", [200, 203, 262])
def test_a_cycle_without_depth_is_not_made(run: Any, number: int) -> None:
    text = program(
        f"CYCL DEF {number} C ~\n Q200=2 ~\n Q201=+0 ~\n Q206=100 ~\n Q335=20 ~\n Q239=1\nL X+5 FMAX M99\n", 2
    )
    out = run(text)
    assert out.errors == []
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["cycle-parameters", "cycle-depth"]
    assert out.path.end[out.path.kind < 3][:, 2].max() == 250


@pytest.mark.parametrize("dialect", ["fanuc", "sinumerik"])
def test_a_move_beside_the_plane_may_come_before_the_entry(run: Any, tmp_path: Any, dialect: str) -> None:
    """G41, down, then to the contour: the entry is the first move of the plane; the tool has the radius 4."""
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 D8\n")
    side = "G41 D1" if dialect == "fanuc" else "G41"
    out = run(
        f"G17 G90\nT1 M6\nG0 X0 Y0 Z10\n{side}\nG1 Z-5 F100\nX10 Y10\nX30\nG40 X40\nM30\n",
        dialect=dialect,
        tool_table=table,
    )
    assert out.errors == []
    assert out.path.end[out.path.kind < 3][1:, :3].round(6).tolist() == [
        [0, 0, -5],
        [10, 14, -5],
        [30, 14, -5],
        [40, 10, -5],
    ]
