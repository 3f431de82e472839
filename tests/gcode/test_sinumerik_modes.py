"""SINUMERIK: modes of the path and of the spindle, and TRAORI on a machine with rotary axes, by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cncgen.machine.kinematics import Kinematics
from cncgen.toolpath.record import PathMode

#: A trunnion: A and C turn the part about points 100 below machine zero.
TABLES = Kinematics(0, (3, 5), (0.0, 0.0, -100.0))


@pytest.mark.parametrize(
    ("words", "mode", "tolerance"),
    [
        ("G60", PathMode.EXACT_STOP, None),
        ("G9", PathMode.EXACT_STOP, None),
        ("G64", PathMode.CONTINUOUS, None),
        # The path is left by half of ADIS, the way before a corner on which it is rounded; CTOL is the distance itself.
        ("G641 ADIS=0.5", PathMode.CONTINUOUS, 0.25),
        ("G642 CTOL=0.05", PathMode.CONTINUOUS, 0.05),
        ("G645 CTOL=0.02", PathMode.CONTINUOUS, 0.02),
        ("G642", PathMode.CONTINUOUS, None),
    ],
)
def test_modes_of_the_path(run: Any, words: str, mode: PathMode, tolerance: float | None) -> None:
    path = run(f"F100\n{words} G1 X5\nG1 Y5\nM30", dialect="sinumerik").path
    rows = np.flatnonzero(path.kind < 3)
    assert path.path_mode[rows[0]] == mode
    assert (
        path.tolerance[rows[0]] == pytest.approx(tolerance)
        if tolerance
        else np.isnan(path.tolerance[rows[0]])
    )
    # G9 is for its block alone.
    assert path.path_mode[rows[1]] == (PathMode.CONTINUOUS if words == "G9" else mode)


def test_the_first_spindle_by_its_index(moves: Any) -> None:
    """S1 and M1=3 are those of the spindle that G95 counts; S2 and M2=3 another's: 0.2 mm at 500 rev/min."""
    text = "S1=500 M1=3\nS2=9000 M2=3\nG95 F0.2\nG1 X1\nM30"
    assert moves(text, dialect="sinumerik") == [(1, 0, 0, 100)]


def test_traori_holds_the_tip_on_its_place(run: Any) -> None:
    """At C90 of the table the place (10, 0) is at (0, -10); at A90 the height of 100 over the centre leads to +Y."""
    out = run("G0 X10\nTRAORI\nG0 C90\nX20\nC0\nA90\nTRAFOOF\nM30", dialect="sinumerik", kinematics=TABLES)
    assert out.errors == []
    ends = out.path.end[out.path.kind < 3][:, :3]
    np.testing.assert_allclose(ends[[-4, -3, -1]], [[0, -10, 0], [0, -20, 0], [20, 100, -100]], atol=1e-6)


@pytest.mark.parametrize(
    ("text", "end"),
    [
        ("TRANS X10\nATRANS Y5\nG0 X1 Y1", (11, 6)),
        ("SCALE X2 Y2\nASCALE X3\nG0 X1 Y1", (6, 2)),
        # The mirror lies in the shifted frame, about its own zero.
        ("TRANS X10\nAMIRROR X0\nG0 X1 Y1", (9, 1)),
        ("ROT RPL=90\nATRANS X5\nG0 X1 Y2", (-2, 6)),
    ],
)
def test_frames_upon_frames(moves: Any, text: str, end: tuple[float, float]) -> None:
    assert moves(f"{text}\nM30", dialect="sinumerik")[-1][:2] == pytest.approx(end)


def test_g63_taps_at_its_feed_whatever_motion_is_in_force(calls: Any) -> None:
    """G63 was a traverse behind G0, which is in force again behind it (840D sl, Fundamentals, "Tapping with compensating chuck")."""
    found = calls("S200 M3\nG0 X0 Y0 Z2\nG63 Z-50 F250\nG63 Z3 M4\nX5\nM30", dialect="sinumerik")
    moves = [call.split(", 0.0000, 0.0000, 0.0000)")[0] for call in found if call.startswith("STRAIGHT")]
    assert moves == [
        "STRAIGHT_TRAVERSE(0.0000, 0.0000, 2.0000",
        "STRAIGHT_FEED(0.0000, 0.0000, -50.0000",
        "STRAIGHT_FEED(0.0000, 0.0000, 3.0000",
        "STRAIGHT_TRAVERSE(5.0000, 0.0000, 3.0000",
    ]


def test_a_traverse_of_axes_by_themselves_is_told(run: Any) -> None:
    """RTLIOF: "each axis traverses independently at its rapid traverse velocity" (Fundamentals); its way is no line."""
    out = run("RTLIOF\nG0 X10 Y20\nRTLION\nG0 X0\nM30", dialect="sinumerik")
    assert [(d.code, d.span.line) for d in out.diagnostics if d.code == "traverse-straight"] == [
        ("traverse-straight", 1)
    ]


@pytest.mark.parametrize("call", ['MSG("x")', "STOPRE", "CYCLE832(0.01,1,1)", "UP(1)"])
def test_words_beside_a_call_count(run: Any, call: str) -> None:
    """F, S and T beside a message, a cycle or a subprogram were lost without a word; what no one uses is an error, as in any block."""
    text = "F500 S100 M3\n{} F200 S300\nG1 X10\nM30\n%_N_UP_SPF\nPROC UP(REAL A)\nM17"
    out = run(text.format(call), dialect="sinumerik")
    assert out.errors == []
    line = out.path.kind == 0
    assert (out.path.feed[line] * 60.0).tolist() == pytest.approx([200.0])
    out = run(f"{call} RND=1\nM30\n%_N_UP_SPF\nPROC UP(REAL A)\nM17", dialect="sinumerik")
    assert out.errors == [("unused-word", 1, len(call) + 2)]


def test_a_cycle_begins_where_the_motion_of_its_block_ends(moves: Any) -> None:
    """It drilled where the block before had led, and the motion came after it; its F is that of the block."""
    found = moves("S100 M3\nG0 Z10\nG1 X15 CYCLE81(10,0,2,-5) F50\nM30", dialect="sinumerik")
    assert found == [(0, 0, 10, 0), (15, 0, 10, 50), (15, 0, 2, 0), (15, 0, -5, 50), (15, 0, 10, 0)]


@pytest.mark.parametrize(
    ("block", "code"),
    [
        ("G1 X20 PO[X]=(3) F100", "unused-word"),
        ("F100 M8 PO[X]=(3)", "unused-word"),
        ("POLY PO[X]=(20) X33 PO[Y]=(20,3) F100", "repeated-word"),
        ("POLY PO[X]=(20,1) AP=30 RP=3 F100", "repeated-word"),
    ],
)
def test_polynomials_that_nothing_uses(run: Any, block: str, code: str) -> None:
    """They, or the end beside them, were passed over without a word."""
    assert [fault[0] for fault in run(f"{block}\nM30", dialect="sinumerik").errors] == [code]


@pytest.mark.parametrize(
    ("frame", "errors"), [("ROT Z90", ["arc-tangent"]), ("MIRROR X0", ["arc-tangent"]), ("TRANS Z5", [])]
)
def test_no_direction_goes_over_into_turned_coordinates(run: Any, frame: str, errors: list[str]) -> None:
    """CT took the direction in the coordinates before for one of the new ones, without a word; a shift keeps it."""
    out = run(f"G0 X0 Y0\nG1 X10 F100\n{frame}\nCT X10 Y-20\nM30", dialect="sinumerik")
    assert [fault[0] for fault in out.errors] == errors
