"""SINUMERIK: milling cycles leave nothing within their walls, and GMODE, DMODE, AMODE of programs that are made at the control.

What a cycle must clear is known in closed form: where the tool's disc fits between the walls. Digits are those of the manual (840D sl,
"Programming cycles externally", POCKET3, POCKET4).
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cncgen.toolpath.record import FeedMode, Kind

Run = Callable[..., Any]
TOOL = "$TC_DP6[1,1]={}\nT1 D1 M6\nS1000 M3\n"


def cut(run: Run, cycle: str, radius: float) -> np.ndarray:
    """Return places of the tool's middle, close to each other, on its cutting moves in the plane."""
    out = run(f"{TOOL.format(radius)}{cycle}\nM30", dialect="sinumerik")
    assert out.errors == []
    rows = np.flatnonzero(
        (out.path.kind != Kind.EVENT) & (out.path.feed_mode != FeedMode.RAPID) & (out.path.end[:, 2] < 0.0)
    )
    begins = out.path.path.row_s
    places = []
    for row in rows:
        s = np.linspace(begins[row], begins[row + 1], 2 + int((begins[row + 1] - begins[row]) / 0.02))
        points = out.path.path.evaluate(s)[0]
        places.append(points[:, 0] + 1j * points[:, 1])
    return np.concatenate(places)


def left(places: np.ndarray, wanted: np.ndarray, radius: float) -> float:
    """Return how far the worst of the places that must be cut is from the tool's disc."""
    worst = max(float(np.abs(places - w).min()) for w in wanted)
    return worst - radius


def rectangle(
    length: float, width: float, corner: float, angle: float = 0.0, middle: complex = 0j
) -> np.ndarray:
    """Return places of a rectangle with rounded corners, 0.5 apart."""
    x, y = np.meshgrid(
        np.arange(-length / 2, length / 2 + 1e-9, 0.5), np.arange(-width / 2, width / 2 + 1e-9, 0.5)
    )
    off = np.hypot(
        np.maximum(np.abs(x) - length / 2 + corner, 0.0), np.maximum(np.abs(y) - width / 2 + corner, 0.0)
    )
    return middle + (x + 1j * y)[off <= corner + 1e-9] * cmath.rect(1.0, math.radians(angle))


@pytest.mark.parametrize("step", ["", "8", "9.9", "4"])
@pytest.mark.parametrize(("length", "width"), [(50, 40), (50, 30), (36, 36), (60, 11), (80, 27)])
def test_nothing_is_left_in_a_rectangle(run: Run, length: float, width: float, step: str) -> None:
    """Loops 8 apart left a strip in the middle of 50 x 40, and slivers at the corners of the loops."""
    places = cut(run, f"POCKET3(10,0,1,-5,{length},{width},5,3,-2,20,5,0,0,500,100,0,11,{step})", 5.0)
    assert left(places, rectangle(length, width, 5.0, 20.0, 3 - 2j), 5.0) < 0.01


@pytest.mark.parametrize("step", [9, 25])
@pytest.mark.parametrize("radius", [6, 11, 17.5, 30])
def test_nothing_is_left_in_a_circle(run: Run, radius: float, step: float) -> None:
    """Loops lie at most the tool's diameter apart."""
    places = cut(run, f"POCKET4(10,0,1,-5,{radius},0,0,5,0,0,500,100,0,11,{step})", 5.0)
    wanted = rectangle(2 * radius, 2 * radius, 0.0)
    assert left(places, wanted[np.abs(wanted) <= radius], 5.0) < 0.01


@pytest.mark.parametrize("width", [10, 14, 20, 26])
def test_nothing_is_left_in_slots(run: Run, width: float) -> None:
    """A slot straight along X from 20 on, and one on the circle of 50 over 60 degrees."""
    places = cut(run, f"SLOT1(10,0,1,-5,,1,60,{width},0,0,20,0,,100,500,5,2,0,1)", 5.0)
    assert left(places, rectangle(60, width, width / 2, 0.0, 50 + 0j), 5.0) < 0.01
    places = cut(run, f"SLOT2(10,0,1,-5,,1,60,{width},0,0,50,-30,,100,500,5,2,0,1)", 5.0)
    r, t = np.meshgrid(
        np.arange(50 - width / 2, 50 + width / 2 + 1e-9, 0.5), np.radians(np.arange(-30, 30.1, 0.5))
    )
    assert left(places, (r * np.exp(1j * t)).ravel(), 5.0) < 0.01


def sizes(run: Run, cycle: str, radius: float = 5.0) -> tuple[float, ...]:
    """Return what a cycle cuts: least and greatest X and Y of the walls, and the depth."""
    out = run(f"{TOOL.format(radius)}{cycle}\nM30", dialect="sinumerik")
    assert out.errors == []
    places = cut(run, cycle, radius)
    ends = (
        places.real.min() - radius,
        places.real.max() + radius,
        places.imag.min() - radius,
        places.imag.max() + radius,
    )
    return tuple(round(float(x), 2) + 0.0 for x in (*ends, out.path.end[:, 2].min()))


@pytest.mark.parametrize(
    ("cycle", "expected"),
    [
        # As programGUIDE writes it: AMODE 111, the depth is a distance and the step in percent; AP1 AP2 AD belong to GMODE 2xxxx alone.
        (
            "POCKET3(100,0,1,20,50,40,5,10,0,0,20,0,0,500,100,0,21,80,8,3,15,10,2,0,1,2,11100,11,111)",
            (-15, 35, -20, 20, -20),
        ),
        (
            "POCKET3(100,-3,1,20,50,40,5,0,0,0,20,0,0,500,100,0,21,4,0,0,0,10,2,0,1,2,1100,11,1)",
            (-25, 25, -20, 20, -23),
        ),
        (
            "POCKET3(100,-3,1,-20,50,40,5,0,0,0,20,0,0,500,100,0,21,4,0,0,0,10,2,0,1,2,1100,11,2)",
            (-25, 25, -20, 20, -20),
        ),
        # The thousands of GMODE: the reference point is a corner.
        ("POCKET3(10,0,1,-5,50,40,5,0,0,0,5,0,0,500,100,0,11,4,,,,,,,,,2000,1,0)", (0, 50, 0, 40, -5)),
        ("POCKET3(10,0,1,-5,50,40,5,0,0,0,5,0,0,500,100,0,11,4,,,,,,,,,3000,1,0)", (-50, 0, 0, 40, -5)),
        ("POCKET3(10,0,1,-5,50,40,5,0,0,0,5,0,0,500,100,0,11,4,,,,,,,,,4000,1,0)", (0, 50, -40, 0, -5)),
        ("POCKET3(10,0,1,-5,50,40,5,0,0,0,5,0,0,500,100,0,11,4,,,,,,,,,5000,1,0)", (-50, 0, -40, 0, -5)),
        # The hundreds of DMODE: the size of POCKET4 is its diameter.
        (
            "POCKET4(100,0,1,20,30,0,0,20,0,0,500,100,0,21,80,9,15,10,2,0,1,2,10100,111,111)",
            (-15, 15, -15, 15, -20),
        ),
        (
            "POCKET4(100,0,1,-20,30,0,0,20,0,0,500,100,0,21,4,0,0,10,2,0,1,2,100,11,0)",
            (-30, 30, -30, 30, -20),
        ),
        # A slot beside X20, its depth a distance though DP is given too.
        (
            "SLOT1(10,0,1,-9,5,1,60,20,0,0,20,0,,100,500,5,2,0,11,,,,,,,0,1,2,100,1011,1)",
            (20, 80, -10, 10, -5),
        ),
        ("LONGHOLE(10,0,1,-5,9,1,60,0,0,20,0,,100,500,5,1,0,0,1,2)", (20, 80, -5, 5, -5)),
        # MCALL and no reference point: where the motion leads.
        ("F100\nMCALL POCKET4(100,0,1,-5,10,,,20,0,0,500,100,0,11)\nG0 X50 Y7\nMCALL", (40, 60, -3, 17, -5)),
        (
            "F100\nMCALL POCKET3(100,0,1,-5,30,20,5,,,0,20,0,0,500,100,0,11)\nG0 X50 Y7\nMCALL",
            (35, 65, -3, 17, -5),
        ),
    ],
)
def test_digits_say_what_parameters_mean(run: Run, cycle: str, expected: tuple[float, ...]) -> None:
    assert sizes(run, cycle) == expected


@pytest.mark.parametrize(
    ("cycle", "expected"),
    [
        ("CYCLE76(10,0,1,,5,40,30,5,0,0,0,5,0,0,500,100,2,1,40,30,1,2,1100,1,1)", (-30, -25, 25, -5)),
        ("CYCLE76(10,0,1,-5,9,40,30,5,20,15,0,5,0,0,500,100,2,1,40,30,1,2,2100,1,2)", (10, 5, 55, -5)),
        ("CYCLE77(10,0,1,-5,9,40,0,0,5,0,0,500,100,2,1,40,1,2,1100,1,2)", (-30, -30, 30, -5)),
    ],
)
def test_digits_of_spigots(run: Run, cycle: str, expected: tuple[float, ...]) -> None:
    """A tool of 10 beside spigots of 40 x 30 and 40; where it comes from, beyond X+, is our own. GMODE 2xxx: from its corner at 20, 15."""
    found = sizes(run, cycle)
    assert (found[0], *found[2:]) == expected


def test_finishing_feed_and_floor_of_a_slot(moves: Callable[..., list[tuple[float, ...]]]) -> None:
    """FFP2 is the feed of VARI 2, FALD what VARI 1 leaves on the floor; the tool is 8 wide."""
    text = "T1 D1 M6\nS1000 M3\nSLOT1(10,0,1,-5,,1,60,20,0,0,20,0,,100,500,5,2,0.2,{},,300,,0.5)\nM30"
    rough, finish = (moves(text.format(vari), dialect="sinumerik") for vari in (1, 2))
    assert (min(m[2] for m in rough), {m[3] for m in rough}) == (-4.5, {0.0, 100.0, 500.0})
    assert (min(m[2] for m in finish), {m[3] for m in finish}) == (-5.0, {0.0, 100.0, 300.0})


@pytest.mark.parametrize(
    ("tail", "code", "part"),
    [
        ("21,4,8,3,15,10,2,0,1,2,20100,11,111", "not-read", "GMODE = 20100"),
        ("21,4,8,3,15,10,2,0,1,2,0,0,1", "not-read", "AP1, AP2, AD"),
        ("21,4,0,0,0,10,2,0,1,2,200,11,111", "not-read", "GMODE = 200"),
        ("21,4,0,0,0,10,2,0,1,2,6000,11,111", "not-read", "GMODE = 6000"),
        ("21,4,0,0,0,10,2,0,1,2,100,12,111", "cycle-plane", "DMODE = 12"),
        ("21,4,0,0,0,10,2,0,1,2,100,11,113", "not-read", "AMODE = 113"),
        ("5,4,0,0,0,10,2,0,1,2,100,11,111", "not-read", "VARI = 5"),
    ],
)
def test_digits_that_are_not_read(run: Run, tail: str, code: str, part: str) -> None:
    found = run(
        f"{TOOL.format(5)}POCKET3(100,0,1,20,50,40,5,0,0,0,5,0,0,500,100,0,{tail})\nM30", dialect="sinumerik"
    ).diagnostics
    error = next(d for d in found if d.severity == "error")
    assert error.code == code
    assert part in error.message


def test_finishing_goes_along_the_wall_and_over_the_floor(run: Run) -> None:
    """What VARI 1 has cleared is not cleared again: above the floor VARI 2 leads along the wall of 50 x 40 alone, and nothing is left of it."""
    cycle = "POCKET3(10,0,1,-9,50,40,5,0,0,0,3,0.5,0.5,500,100,0,{},8)"
    out = run(f"{TOOL.format(5.0)}{cycle.format(2)}\nM30", dialect="sinumerik")
    assert out.errors == []
    rows = (out.path.kind != Kind.EVENT) & (out.path.feed_mode != FeedMode.RAPID)
    for level in (-3.0, -6.0):
        loop = out.path.end[rows & (out.path.end[:, 2] == level), :2]
        # The way in, the wall, its four corners of no radius, and back: places farther in are passed, not milled around.
        assert np.abs(loop).max(0).tolist() == [20.0, 15.0]
        assert sum(abs(x) < 20.0 and abs(y) < 15.0 for x, y in loop) <= 2
    assert left(cut(run, cycle.format(2), 5.0), rectangle(50, 40, 5.0), 5.0) < 0.01
    rough, finish = (
        run(f"{TOOL.format(5.0)}{cycle.format(v)}\nM30", dialect="sinumerik").path.path.length for v in (1, 2)
    )
    assert finish < rough


@pytest.mark.parametrize(
    ("tool", "said", "reach"), [(5.0, "cycle-tool", 5.0), (20.0, "", 20.0), (0.0, "tool-assumed", 25.0)]
)
@pytest.mark.parametrize(
    "cycle",
    [
        "CYCLE71(20,0,2,-2,0,0,100,120,0,2,40,0,0,500,31,0)",
        "CYCLE61(20,0,2,-2,0,0,100,120,2,40,0,500,31,0,1,0)",
    ],
)
def test_rows_that_leave_strips_are_told(run: Run, cycle: str, tool: float, said: str, reach: float) -> None:
    """Rows 40 apart leave strips behind a tool 10 wide; where no table gives the tool, it is one of 50, of which 40 is 80 %."""
    text = f"{TOOL.format(tool) if tool else 'T1 D1 M6' + chr(10)}{cycle}\nM30"
    out = run(text, dialect="sinumerik")
    assert out.errors == []
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == [said] * bool(said)
    assert out.path.end[:, 0].min() == -reach
    assert out.path.end[:, 0].max() == 100.0 + reach


@pytest.mark.parametrize(
    ("cycle", "rows"),
    [
        ("CYCLE61(20,0,2,-1,0,0,100,8,1,2,0,500,11,0,1,1)", [-3.0, -1.0, 1.0, 3.0]),
        ("CYCLE61(20,0,2,-1,0,0,100,-8,1,2,0,500,11,0,1,1)", [3.0, 1.0, -1.0, -3.0]),
        ("CYCLE71(20,0,2,-1,0,0,100,8,0,1,2,0,0,500,31,0)", [-3.0, -1.0, 1.0, 3.0]),
        ("CYCLE71(20,0,2,-1,0,0,8,100,0,1,2,0,0,500,41,0)", [-3.0, -1.0, 1.0, 3.0]),
    ],
)
def test_rows_narrower_than_the_radius_begin_beside_the_face(run: Run, cycle: str, rows: list[float]) -> None:
    """The k-th row of 2 clears up to 2 k with a tool of 5: its middle is at 2 k - 5, on whichever side; 1 and 3 were milled twice."""
    out = run(f"{TOOL.format(5.0)}{cycle}\nM30", dialect="sinumerik")
    assert out.errors == []
    across = 0 if "41,0)" in cycle else 1
    places = out.path.end[out.path.end[:, 2] == -1.0][:, across].tolist()
    assert list(dict.fromkeys(places)) == rows


ENGRAVED = "G17 G90 G94 S900 M3 F300\nG0 X0 Y0 Z50\nCYCLE60({})\nM30\n"


def test_text_is_engraved_along_a_line(run: Any) -> None:
    """I is a stroke of the height of capitals: two of them 6 high and 3 apart, from (10, 20) on along Y, 0.3 below RFP.

    Traverse to RTP and RFP + SDIS, FFD downwards, FFP1 along, up to SDIS between letters and to RTP at the end (from memory of the Programming Guide, Cycles).
    """
    out = run(ENGRAVED.format('"II",30,1,2,,0.3,10,20,90,0,0,6,3,80,400,0,1252'), dialect="sinumerik")
    assert out.errors == []
    assert sorted({d.code for d in out.diagnostics}) == ["cycle-parameters", "engraving-letters"]
    rows = out.path.kind < 3
    found = np.column_stack((out.path.end[rows, :3], out.path.feed[rows] * 60.0)).round(9)
    cuts = out.path.feed_mode[rows] != FeedMode.RAPID
    assert found[cuts].tolist() == [
        [10, 20, 0.7, 80], [4, 20, 0.7, 400], [10, 23, 0.7, 80], [4, 23, 0.7, 400],
    ]  # fmt: skip
    assert found[~cuts, :3].tolist() == [
        [0, 0, 50], [0, 0, 30], [10, 20, 30], [10, 20, 3], [4, 20, 3], [10, 23, 3], [4, 23, 3], [4, 23, 30],
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ('"",30,1,2,,0.3,10,20,90,0,0,6,3,80,400,0', "cycle-words"),
        (",30,1,2,,0.3,10,20,90,0,0,6,3,80,400,0", "cycle-words"),
        ('"<#,_VAR>",30,1,2,,0.3,10,20,90,0,0,6,3,80,400,0', "not-read"),
        ('"A",30,1,2,,0.3,10,20,90,0,0,6,3,80,400,10', "not-read"),
        ('"A",30,1,2,,0.3,10,20,90,0,0,0,3,80,400,0', "cycle-words"),
        ('"A",30,1,2,5,,10,20,90,0,0,6,3,80,400,0', "cycle-depth"),
    ],
)
def test_a_text_that_is_not_read_is_refused(run: Any, words: str, code: str) -> None:
    assert [found for found, *_ in run(ENGRAVED.format(words), dialect="sinumerik").errors] == [code]
