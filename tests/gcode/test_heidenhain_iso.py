"""Heidenhain's DIN/ISO: programs as its manuals have them (TNC 410 and iTNC 530, "DIN/ISO programming"), with motions worked out by hand."""

from __future__ import annotations

import io
import math
from typing import Any

import pytest

from cncgen.diagnostics import Diagnostics
from cncgen.gcode import check, read

HEAD = "%P G71 *\nN10 G30 G17 X+0 Y+0 Z-20 *\nN20 G31 G90 X+100 Y+100 Z+0 *\nN30 G99 T2 L+0 R+{radius} *\nN40 T2 G17 S4000 *\n"
#: "Linear movement and chamfers", with its way on and off along arcs (G26, G27).
LINEAR = (
    "N50 G00 G40 G90 Z+250 *\nN60 X-10 Y-10 *\nN70 G01 Z-5 F1000 M3 *\nN80 G01 G41 X+5 Y+5 F300 *\nN90 G26 R5 F150 *\nN100 Y+95 *\n"
    "N110 X+95 *\nN120 G24 R10 *\nN130 Y+5 *\nN140 G24 R20 *\nN150 X+5 *\nN160 G27 R5 F500 *\nN170 G40 X-20 Y-20 F1000 *\nN180 G00 Z+250 M2 *\n"
)


def program(body: str, radius: float = 5.0) -> str:
    return f"{HEAD.format(radius=radius)}{body}N99999 %P G71 *\n"


def places(found: Any) -> list[tuple[float, ...]]:
    return [tuple(round(value, 4) for value in move) for move in found]


def test_linear_movements_with_soft_ways_on_and_off(moves: Any) -> None:
    """Radius 10: on at (-5, 5) upwards by an arc of radius 5 of the tool's centre, off at (5, -5) to the left by one."""
    found = moves(program(LINEAR, 10))
    assert found[:3] == [(0, 0, 250, 0), (-10, -10, 250, 0), (-10, -10, -5, 1000)]
    assert found[4] == (-5, 5, -5, 150)
    # The line from (-10, -10) touches the circle of radius 5 about (-10, 5).
    assert math.hypot(found[3][0] + 10, found[3][1] - 5) == pytest.approx(5)
    way = complex(found[3][0] + 10, found[3][1] + 10)
    assert (way.conjugate() * complex(found[3][0] + 10, found[3][1] - 5)).real == pytest.approx(0, abs=1e-4)
    root = 10 * math.sqrt(0.5)
    at = [(-5, 95), (5, 105), (85, 105), (85 + root, 95 + root), (95 + root, 85 + root), (105, 85), (105, 25), (95 + root, 25 - root),
          (75 + root, 5 - root), (75, -5), (5, -5)]  # fmt: skip
    assert [move[:2] for move in found[5:16]] == [(pytest.approx(x), pytest.approx(y)) for x, y in at]
    assert math.hypot(found[16][0] - 5, found[16][1] + 10) == pytest.approx(5)
    assert found[16][3] == 500
    assert found[17] == (-20, -20, -5, 500)
    assert found[18] == (-20, -20, 250, 0)


def test_motions_say_what_the_plain_language_says(moves: Any) -> None:
    """G02 and G03 about I J or with R, G05 in the sense before, G06 tangentially, G10 to G16 in polar coordinates, G90 and G91 word by word."""
    iso = program(
        "N50 G00 G40 G90 X+10 Y+0 Z+5 *\nN55 G01 Z-1 F100 *\nN60 I+0 J+0 *\nN70 G03 X+0 Y+10 *\nN80 G05 X-10 Y+0 *\nN90 G02 X-20 Y+0 R+5 *\n"
        "N100 G01 G91 X-5 G90 Y+3 *\nN110 G06 X-30 Y+8 *\nN120 I-30 J+0 *\nN130 G11 R+20 H+90 *\nN140 G13 H+180 *\nN150 G12 G91 H-360 Z-2 *\n"
        "N160 G90 G10 R+30 H+0 *\nN170 G00 Z+50 M2 *\n"
    )
    plain = (
        "BEGIN PGM P MM\nTOOL DEF 2 L+0 R+5\nTOOL CALL 2 Z S4000\nL X+10 Y+0 Z+5 R0 FMAX\nL Z-1 F100\nCC X+0 Y+0\nC X+0 Y+10 DR+\nC X-10 Y+0 DR+\n"
        "CR X-20 Y+0 R+5 DR-\nL IX-5 Y+3\nCT X-30 Y+8\nCC X-30 Y+0\nLP PR+20 PA+90\nCP PA+180 DR+\nCP IPA-360 IZ-2 DR-\nLP PR+30 PA+0 FMAX\n"
        "L Z+50 FMAX M2\nEND PGM P MM\n"
    )
    assert moves(iso) == moves(plain)


def test_cycles_labels_and_parameters(moves: Any) -> None:
    """Five holes: at 10, then two steps of Q2 = 10 in a label that is called twice and repeats its part once."""
    found = moves(
        program(
            "N50 D00 Q1 P01 +5 *\nN60 D03 Q2 P01 +Q1 P02 +2 *\nN70 G00 G40 G90 Z+50 M3 *\n"
            "N80 G201 REAMING Q200=2 Q201=-10 Q206=100 Q211=0 Q208=0 Q203=+0 Q204=2 *\nN90 X+10 Y+0 M99 *\nN100 L1,0 *\nN105 L1,0 *\n"
            "N110 D12 P01 +Q1 P02 +9 P03 7 *\nN120 G00 X+999 *\nN130 G98 L7 *\nN140 G00 Z+50 M2 *\n"
            "N150 G98 L1 *\nN155 G98 L2 *\nN160 G91 X+Q2 M99 *\nN165 L2,1 *\nN170 G90 G98 L0 *\n".replace(
                "N170 G90 G98 L0", "N169 G90 *\nN170 G98 L0"
            )
        )
    )
    bottoms = [move for move in found if move[2] == -10]
    assert bottoms == [(x, 0, -10, 100) for x in (10, 20, 30, 40, 50)]
    assert found[-1] == (50, 0, 50, 0)


@pytest.mark.parametrize("call", ["T2 G17 S500", "G17 T2 S500", "T2 G17 S500 F100", "T2 S500"])
def test_a_tool_call_with_its_axis_before_or_behind(moves: Any, call: str) -> None:
    text = program(
        f"N50 {call}*          ;the tool\nN60 G00 G40 G90 Z+5 M13*\n\n;--- next\nN70 X+1*\nN80 M30*\n"
    )
    assert moves(text) == [(0, 0, 5, 0), (1, 0, 5, 0)]


def test_old_cycles_frames_and_a_dwell(moves: Any) -> None:
    """G83 P: 8 deep in steps of 5 from the surface at 20 - 2 on, 0.6 ahead after the first; G54 shifts, G28 mirrors (a lone X moves along its axis alone), G73 turns, G72 scales."""
    found = moves(
        program(
            "N50 G00 G40 G90 X+0 Y+0 Z+20 M3 *\nN60 G83 P01 2 P02 -8 P03 5 P04 0 P05 100 *\nN70 G79 *\nN80 G04 F0.5 *\n"
            "N90 G54 X+100 Y+0 *\nN100 G00 X+1 Y+0 *\nN110 G73 G90 H+90 *\nN120 X+2 *\nN130 G73 H+0 *\nN140 G28 X *\nN150 X+3 *\nN160 G28 *\n"
            "N170 G72 F0.5 *\nN180 X+4 Y+2 *\nN190 G72 F1 *\nN200 G54 X+0 Y+0 *\nN210 X+5 Y+5 M2 *\n"
        )
    )
    assert places(found) == [
        (0, 0, 20, 0), (0, 0, 13, 100), (0, 0, 20, 0), (0, 0, 13.6, 0), (0, 0, 10, 100), (0, 0, 20, 0),
        (101, 0, 20, 0), (101, 2, 20, 0), (97, 2, 20, 0), (102, 1, 20, 0), (5, 5, 20, 0),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("N50 G00 G53 X+5 *\n", [("unsupported-block", 6)]),
        ("N50 G74 P01 2 P02 -20 P03 -5 P04 100 *\nN60 G79 *\n", [("cycle-words", 7)]),
        ("N50 G01 X+5 Y+5 F100 *\nN60 G26 R5 *\nN70 X+10 F100 *\n", [("approach-words", 6)]),
        ("N50 G27 R5 *\nN60 G01 G41 X+5 F100 *\n", [("approach-words", 7)]),
        ("N50 G02 F100 *\n", [("arc-end", 6)]),
        ("N50 G1.5 X+5 F100 *\n", [("unsupported-block", 6)]),
        ("N50 G03 X+5 Y+5 F100 *\n", [("pole-missing", 6)]),
        ("N50 D01 Q1 P01 +5 *\n", [("unsupported-block", 6)]),
        ("N50 L5,0 *\n", [("label-missing", 6)]),
        ("N50 G01 X+5 ?3 *\n", [("syntax", 6)]),
        ("N50 T1 G17 S500 X+5 *\n", [("unsupported-block", 6)]),
        ("N50 G18 T1 S500 *\n", [("unsupported-block", 6)]),
        ("N50 G01 IX+5 F100 *\n", [("syntax", 6)]),
        ("N50 D15 P01 5 *\n", [("unsupported-block", 6)]),
        # R+ and R- take no increments, as in plain language.
        ("N50 G01 G43 X+5 F100 *\nN60 G91 X+5 *\n", [("paraxial", 7)]),
    ],
)
def test_what_is_wrong_is_named(body: str, expected: list[tuple[str, int]]) -> None:
    found = Diagnostics()
    check(io.BytesIO(program(body + "N900 M2 *\n").encode()), "t.i", diagnostics=found)
    assert [(one.code, one.span.line) for one in found if one.severity == "error" and one.span] == expected


def test_faults_name_their_place_in_the_text() -> None:
    found = Diagnostics()
    check(io.BytesIO(program("N50G01X+5 ?3*\nN60 M2*\n").encode()), "t.i", diagnostics=found)
    assert [(one.span.line, one.span.column) for one in found if one.severity == "error" and one.span] == [
        (6, 11)
    ]


def test_blanks_may_be_missing(moves: Any) -> None:
    """A hole of 10 at (5, 0), as with blanks."""
    body = "N50G00G40G90X+5Y+0Z+50M3*\nN60G201Q200=2 Q201=-10 Q206=100 Q211=0 Q208=0 Q203=+0 Q204=2*\nN70M99*\nN80M2*\n"
    assert [move[2] for move in moves(program(body))] == [50, 2, -10, 2]


def test_axes_of_polar_coordinates_and_cycles_have_columns() -> None:
    text = "%P G71 *\nN10 I+0 J+0 *\nN20 G10 R+5 H+0 *\nN30 G83 P01 2 P02 -8 P03 5 P04 0 P05 100 *\nN40 G79 *\nN50 M2 *\n"
    assert read(io.BytesIO(text.encode()), "t.i").moving_axes == "XYZ"


@pytest.mark.parametrize(
    ("iso", "plain", "across"),
    [
        # Half sizes 15 by 10 about (50, 40), less the radius 4: the tool's middle goes to 50 ± 11 and 40 ± 6.
        ("G75 P01 2 P02 -4 P03 -4 P04 100 P05 X+30 P06 Y+20 P07 275 P08 5",
         "4.1 SETUP 2,4.2 DEPTH -4,4.3 PECKG 4 F100,4.4 X+30,4.5 Y+20,4.6 F275 DR- RADIUS 5", (39, 61, 34, 46)),
        ("G76 P01 2 P02 -4 P03 -4 P04 100 P05 Y+30 P06 X+20 P07 275",
         "4.1 SETUP 2,4.2 DEPTH -4,4.3 PECKG 4 F100,4.4 Y+30,4.5 X+20,4.6 F275 DR+", (44, 56, 29, 51)),
        # Radius 20 - 4.
        ("G77 P01 2 P02 -4 P03 -4 P04 100 P05 20 P06 250", "5.1 SETUP 2,5.2 DEPTH -4,5.3 PECKG 4 F100,5.4 RADIUS 20,5.5 F250 DR-", (34, 66, 24, 56)),
        ("G78 P01 2 P02 -4 P03 -4 P04 100 P05 20 P06 250", "5.1 SETUP 2,5.2 DEPTH -4,5.3 PECKG 4 F100,5.4 RADIUS 20,5.5 F250 DR+", (34, 66, 24, 56)),
        # From the end at which the tool stands, 4 within it, to the left: 80 - 8 further; 12 wide.
        ("G74 P01 2 P02 -4 P03 -4 P04 100 P05 X-80 P06 Y+12 P07 275", "3.1 SETUP 2,3.2 DEPTH -4,3.3 PECKG 4 F100,3.4 X-80,3.5 Y+12,3.6 F275", (-22, 50, 38, 42)),
    ],
)  # fmt: skip
def test_slots_and_pockets_of_parts(
    moves: Any, iso: str, plain: str, across: tuple[float, float, float, float]
) -> None:
    """G74 is a slot, G75 and G76 a rectangular pocket clockwise and counter-clockwise, G77 and G78 a round one (TNC 426, "DIN/ISO", G
    functions): P04 is the feed downwards, the last two those along and of the corners. The same motions as cycles 3 to 5."""
    found = moves(program(f"N50 G00 G40 G90 X+50 Y+40 Z+2 M3 *\nN60 {iso} *\nN70 G79 *\nN80 Z+9 M2 *\n", 4))
    parts = "".join(f"CYCL DEF {part}\n" for part in plain.split(","))
    text = (
        f"BEGIN PGM P MM\nTOOL DEF 2 L+0 R+4\nTOOL CALL 2 Z S4000\nL X+50 Y+40 Z+2 R0 FMAX M3\nCYCL DEF {plain[0]}.0 OLD\n{parts}"
        "CYCL CALL\nL Z+9 FMAX M2\nEND PGM P MM\n"
    )
    assert found == moves(text)
    low = [move for move in found if move[2] == -4]
    assert (
        min(m[0] for m in low),
        max(m[0] for m in low),
        min(m[1] for m in low),
        max(m[1] for m in low),
    ) == pytest.approx(across)
    assert {move[3] for move in low} == {100, 275 if "275" in iso else 250}
