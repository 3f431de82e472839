"""CYCLE90 of SINUMERIK mills threads: motions worked out by hand from the Programming Guide, Cycles; tool 1 has the radius 4."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

#: RTP RFP SDIS DP DPR, then the diameters, lead, feed, sense, kind and middle.
INSIDE = "G17 G90 G0 X0 Y0 Z20 S500 M3 T1 D1 F100\nM6\nCYCLE90(10,0,1,-11,,{outer},{core},{lead},200,{sense},{kind},50,40)\nM30\n"
#: The manual's way beyond a thread of M16: 2 / 4 (2 4 + 8 - 4) / 16 inside, 2 / 4 (2 4 + 8 + 4) / 16 outside.
BEYOND_INSIDE, BEYOND_OUTSIDE = 0.375, 0.625


@pytest.fixture
def rows(run: Any, tmp_path: Any) -> Any:
    """Return the path of a program, with tool 1."""
    table = tmp_path / "tool.tbl"
    table.write_text("T1 P1 D8\n")
    return lambda text: run(text, dialect="sinumerik", tool_table=table)


def test_inside(moves: Any) -> None:
    """From 0.625 to -11 are 5.8125 turns at the lead 2; they end at 292.5 degrees counter-clockwise, 4 from the middle."""
    found = moves(INSIDE.format(outer=16, core=13, lead=2, sense=3, kind=0), dialect="sinumerik", units="mm")
    angle = math.radians(360 * 5.8125)
    end = (pytest.approx(50 + 4 * math.cos(angle)), pytest.approx(40 + 4 * math.sin(angle)))
    assert found[1:] == [
        (0, 0, 10, 0), (50, 40, 10, 0), (50, 40, 1, 0), (54, 40, 1 - BEYOND_INSIDE, 200), (*end, -11, 200),
        (50, 40, -11 - BEYOND_INSIDE, 200), (50, 40, 10, 0),
    ]  # fmt: skip


@pytest.mark.parametrize(("sense", "side"), [(2, 1), (3, -1)])
def test_outside(moves: Any, sense: int, side: int) -> None:
    """At the core's 13 / 2 + 4, from the first quadrant clockwise, from the fourth counter-clockwise, on a quarter of a circle."""
    text = INSIDE.format(outer=16, core=13, lead=2, sense=sense, kind=1)
    found = moves(text, dialect="sinumerik", units="mm")
    turns = (12 - BEYOND_OUTSIDE) / 2
    spoke = complex(math.cos(2 * math.pi * turns), -side * math.sin(2 * math.pi * turns))
    end = 50 + 40j + 10.5 * spoke
    # Off into the sense in which it goes: 14.5 along the spoke and 4 beside it.
    off = 50 + 40j + spoke * (14.5 - side * 4j)
    assert found[1:] == [
        (0, 0, 10, 0), (64.5, 40 + side * 4, 10, 0), (64.5, 40 + side * 4, 1, 0), (60.5, 40, 1 - BEYOND_OUTSIDE, 200),
        (pytest.approx(end.real), pytest.approx(end.imag), -11, 200),
        (pytest.approx(off.real), pytest.approx(off.imag), -11 - BEYOND_OUTSIDE, 200),
        (pytest.approx(off.real), pytest.approx(off.imag), 10, 0),
    ]  # fmt: skip


def test_the_manuals_example(calls: Any) -> None:
    """An inside thread at X60 Y50, M60 with the lead 2, from its variables; tool 5 is 20 wide."""
    text = (
        "DEF REAL RTP=48, RFP=40, SDIS=5, DP=0, DPR=40, DIATH=60, KDIAM=50\nDEF REAL PIT=2, FFR=500, CPA=60,CPO=50\n"
        "DEF INT CDIR=2, TYPTH=0\nN10 G90 G0 G17 X0 Y0 Z80 S200 M3\nN20 T5 D1\nN25 $TC_DP6[5,1]=10\n"
        "N30 CYCLE90(RTP, RFP, SDIS, DP, DPR, DIATH, KDIAM, PIT, FFR, CDIR, TYPTH, CPA, CPO)\nN40 G0 G90 Z100\nN50 M02\n"
    )
    arcs = [call for call in calls(text, dialect="sinumerik") if call.startswith("ARC_FEED")]
    assert [call.split("(")[1][:44] for call in arcs] == [
        "80.0000, 50.0000, 70.0000, 50.0000, -1, 44.6",
        "50.0000, 32.6795, 60.0000, 50.0000, -23, 0.0",
        "60.0000, 50.0000, 55.0000, 41.3397, -1, -0.3",
    ]


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ({"core": 7}, "cycle-tool"),
        ({"outer": 8}, "cycle-tool"),
        ({"outer": 12}, "cycle-tool"),
        ({"lead": 0}, "cycle-tool"),
        ({"lead": 0.0001}, "cycle-tool"),
        ({"sense": 4}, "cycle-tool"),
        ({"kind": 2}, "cycle-tool"),
        ({"kind": 1, "core": 0}, "cycle-tool"),
    ],
)
def test_what_is_wrong(rows: Any, words: dict[str, float], code: str) -> None:
    values = {"outer": 16, "core": 13, "lead": 2, "sense": 2, "kind": 0, **words}
    assert [e[0] for e in rows(INSIDE.format(**values)).errors] == [code]


def test_a_thread_upwards_is_not_read(rows: Any) -> None:
    text = INSIDE.format(outer=16, core=13, lead=2, sense=2, kind=0).replace("10,0,1,-11", "-20,0,1,-11")
    assert [e[0] for e in rows(text).errors] == ["cycle-depth"]


@pytest.mark.parametrize("remark", ["", 'MSG("OHNE M6") ; M6\n'])
def test_a_tool_that_t_changes_has_its_size_in_canon(calls: Any, tmp_path: Path, remark: str) -> None:
    """LinuxCNC's stand-alone interpreter keeps the tool before M61; that is no habit of SINUMERIK, whose T changes the tool at once.

    M6 in a remark changes no tool.
    """
    table = tmp_path / "tool.tbl"
    table.write_text("T1 P1 D8\n")
    text = remark + INSIDE.replace("\nM6\n", "\n").format(outer=16, core=13, lead=2, sense=3, kind=0)
    found = calls(text, dialect="sinumerik", tool_table=table)
    assert any(call.startswith("ARC_FEED(54.0000, 40.0000, 52.0000") for call in found)


#: CYCLE70: a lead of 3 from 2 to -10 is 4 turns; root at 10 inside and at 9 outside, tool 4.
PROFILE = "T1 D1 M6\nS500 M3\nCYCLE70(10,0,2,{depth},20,1,{left},3,1,{step},200,{kind},5,6,{angle},{vari},1,,,,100,1,{mode})\nM30\n"


def helices(rows: Any, **words: Any) -> list[tuple[complex, float, float, float]]:
    """Return of each helix where it begins in the plane, its radius, its heights, and its turn in degrees over one of height, signed."""
    values = {"depth": -10, "left": 0, "step": 2, "kind": 0, "angle": 0, "vari": 11, "mode": 0, **words}
    path = rows(PROFILE.format(**values)).path
    found = []
    for row in range(1, len(path)):
        start, end = path.starts[row], path.end[row]
        if path.kind[row] != 1 or abs(end[2] - start[2]) < 5:
            continue
        middle = 5 + 6j
        s = path.path.row_s[row] + path.path.row_length[row] * 1e-6
        x, y = path.path.evaluate([s])[0][0][:2]
        spoke = complex(*start[:2]) - middle
        sense = ((complex(x, y) - middle) / spoke).imag
        found.append((complex(*start[:2]), abs(spoke), (start[2], end[2]), math.copysign(1.0, sense)))
    return found  # type: ignore[return-value]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        # Downwards to the right is clockwise; upwards, or to the left, counter-clockwise; both clockwise.
        ({}, [(11 + 6j, 6, (2, -10), -1)]),
        ({"vari": 21}, [(11 + 6j, 6, (-10, 2), 1)]),
        ({"vari": 111}, [(11 + 6j, 6, (2, -10), 1)]),
        ({"vari": 121}, [(11 + 6j, 6, (-10, 2), -1)]),
        # From NSP on; DP as a distance.
        ({"angle": 90, "depth": 10, "mode": 1}, [(5 + 12j, 6, (2, -10), -1)]),
        # Passes of 0.45 down to the allowance of 0.1, then the last one alone.
        ({"left": 0.1, "step": 0.5}, [(10.45 + 6j, 5.45, (2, -10), -1), (10.9 + 6j, 5.9, (2, -10), -1)]),
        ({"left": 0.1, "step": 0.5, "vari": 12}, [(11 + 6j, 6, (2, -10), -1)]),
        ({"kind": 1}, [(18 + 6j, 13, (2, -10), -1)]),
        (
            {"kind": 1, "left": 0.1, "step": 0.5},
            [(18.55 + 6j, 13.55, (2, -10), -1), (18.1 + 6j, 13.1, (2, -10), -1)],
        ),
    ],
)
def test_threads_of_a_profile(rows: Any, words: dict[str, Any], expected: list[Any]) -> None:
    """A thread to the right goes up counter-clockwise, so down clockwise."""
    found = helices(rows, **words)
    assert [(s, t) for *_, s, t in found] == [(s, t) for *_, s, t in expected]
    for (begin, radius, *_), (place, wanted, *_) in zip(found, expected, strict=True):
        assert (begin, radius) == (pytest.approx(place), pytest.approx(wanted))


def test_a_thread_of_a_profile_has_its_lead(rows: Any) -> None:
    """Four turns at the radius 6 and the lead 3."""
    path = rows(PROFILE.format(depth=-10, left=0, step=2, kind=0, angle=0, vari=11, mode=0)).path
    assert max(path.path.row_length) == pytest.approx(4 * math.hypot(2 * math.pi * 6, 3))


@pytest.mark.parametrize(
    ("words", "part"),
    [
        ({"vari": 31}, "VARI = 31"),
        ({"vari": 13}, "VARI = 13"),
        ({"left": 1}, "allowance 1"),
        ({"kind": 2}, "TYPTH = 2"),
    ],
)
def test_faults_of_a_profile(run: Any, words: dict[str, Any], part: str) -> None:
    values = {"depth": -10, "left": 0, "step": 2, "kind": 0, "angle": 0, "vari": 11, "mode": 0, **words}
    text = "$TC_DP6[1,1]=4\n" + PROFILE.format(**values)
    error = next(d for d in run(text, dialect="sinumerik").diagnostics if d.severity == "error")
    assert error.code == "cycle-tool"
    assert part in error.message


def test_what_was_not_compared_with_a_manual_is_told(run: Any) -> None:
    """CYCLE70 was made without a word, though the order of its parameters is not certain."""
    text = PROFILE.format(depth=-10, left=0.5, step=1, kind=0, angle=0, vari=11, mode=0)
    found = run(text, dialect="sinumerik").diagnostics
    assert "cycle-parameters" in [d.code for d in found if d.severity == "warning"]


@pytest.mark.parametrize(
    ("block", "lead"),
    [
        ("Z-15 K2", 2.0),
        ("X60 Z-15 K2", 2.0 * math.hypot(10.0, 20.0) / 20.0),
        ("X60 Z-15 K2 I1", 2.0 * math.hypot(10.0, 20.0) / 20.0),
        ("X60 Z0 I2", 2.0 * math.hypot(10.0, 5.0) / 10.0),
        ("X60 I2", 2.0),
    ],
)
def test_the_lead_of_a_taper_is_along_its_axis(calls: Any, block: str, lead: float) -> None:
    """Fundamentals, 11/2006, p. 169: K is along Z, I along X; each revolution goes as much farther as the taper is longer (it went K along the taper)."""
    text = f"G18 DIAMON G90\nS500 M3\nG0 X40 Z5\nG33 {block}\nG0 X70\nM30\n"
    assert f"START_SPEED_FEED_SYNC({lead:f},0)" in calls(text, dialect="sinumerik")


def test_a_lead_along_an_axis_that_rests_is_an_error(run: Any) -> None:
    out = run("G18 DIAMON\nS500 M3\nG0 X40 Z5\nG33 X60 K2\nM30\n", dialect="sinumerik")
    assert out.errors == [("pitch-missing", 4, 9)]


@pytest.mark.parametrize(
    ("block", "depths"),
    [
        # n turns go 4 n + 0.2 n² / 2, of which 10 go 50; 5 n - 0.5 n² / 2, of which 4 go 16.
        ("G34 Z-50 K4 F0.2", [-4.1, -8.4, -12.9, -17.6, -22.5, -27.6, -32.9, -38.4, -44.1, -50]),
        ("G35 Z-16 K5 F0.5", [-4.75, -9, -12.75, -16]),
    ],
)
def test_a_lead_that_changes(run: Any, block: str, depths: list[float]) -> None:
    """F is the change of the lead a revolution, and no feed: G1 behind the thread has that of before."""
    out = run(f"G18 G95 S100 M3 DIAMON F0.3\nG0 X20 Z0\n{block}\nG1 X40\nM30\n", dialect="sinumerik")
    assert out.errors == []
    path = out.path
    moved = path.kind != 3
    assert path.end[moved][1:-1, 2].tolist() == pytest.approx(depths)
    leads = [*-np.diff([0.0, *depths]), 0.3]
    assert path.feed[moved][1:] * 60 / 100 == pytest.approx(leads)


@pytest.mark.parametrize(
    ("block", "says"),
    [("G34 Z-50 K4", "no change F"), ("G35 Z-50 K4 F0.2", "falls from 4 by 0.2 a turn to 0 after 40 of 50")],
)
def test_leads_that_cannot_change(run: Any, block: str, says: str) -> None:
    out = run(f"G18 G95 S100 M3 DIAMON\nG0 X20 Z0\n{block}\n", dialect="sinumerik")
    (fault,) = (d for d in out.diagnostics if d.severity == "error")
    assert fault.code == "pitch-missing"
    assert says in fault.message
