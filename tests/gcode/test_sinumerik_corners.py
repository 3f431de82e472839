"""SINUMERIK: where RND, RNDM, CHR and CHF make a corner, make it smaller or leave it out (840D sl, Fundamentals, "Chamfer, rounding").

No corner is made where no line or arc in the plane follows, or too many blocks without a motion; too large ones are reduced.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

Run = Callable[..., Any]


def seen(run: Run, text: str) -> tuple[list[list[float]], list[str]]:
    """Return where the motions of a text lead in X Y Z, and the codes of what was said, after asserting that nothing was an error."""
    out = run(f"G0 X0 Y0\n{text}\nM30", dialect="sinumerik")
    assert out.errors == []
    ends = (np.round(out.path.end[out.path.kind != 3, :3], 6) + 0.0).tolist()
    return ends, [d.code for d in out.diagnostics if d.severity.value == "warning"]


@pytest.mark.parametrize("between", ["M8", "S500 M3\nF200\nM8", "R1=5\nM8", 'MSG("x")', "; remark\nF50"])
@pytest.mark.parametrize(("corner", "first", "second"), [("RND=2", 8, 2), ("CHR=3", 7, 3), ("RNDM=1", 9, 1)])
def test_blocks_without_a_motion_may_stand_between(
    run: Run, corner: str, first: float, second: float, between: str
) -> None:
    ends, said = seen(run, f"G1 X10 {corner} F100\n{between}\nY10")
    assert ends == [[first, 0, 0], [10, second, 0], [10, 10, 0]]
    assert said == []


def test_what_stands_between_acts_behind_the_corner(run: Run) -> None:
    """M8 belongs to the second block, before which the corner stands; the first motion and the corner keep their feed."""
    path = run("G0 X0 Y0\nG1 X10 RND=2 F100\nM8\nF200\nY10\nM30", dialect="sinumerik").path
    kinds, feeds = path.kind.tolist(), (path.feed * 60.0).round(6).tolist()
    assert kinds[:4] == [0, 1, 3, 0]
    assert [f for k, f in zip(kinds, feeds, strict=True) if k != 3] == [100, 100, 200]


@pytest.mark.parametrize(
    ("text", "ends", "code"),
    [
        ("G1 X10 RND=2 F100\nG0 Y10", [[10, 0, 0], [10, 10, 0]], "corner-next"),
        ("G1 X10 RND=2 F100\nM8\nM9\nM8\nM9\nY10", [[10, 0, 0], [10, 10, 0]], "corner-next"),
        ("G1 X10 RND=2 F100\nTRANS X5\nX5 Y10", [[10, 0, 0], [10, 10, 0]], "corner-next"),
        ("G1 X10 CHF=2 F100\nY10 Z5", [[10, 0, 0], [10, 10, 5]], "corner-plane"),
        # The last motion of a program is made too: it was lost.
        ("G1 X10 RND=2 F100", [[10, 0, 0]], "corner-next"),
        ("G1 X10 RND=2 F100\nR1=5", [[10, 0, 0]], "corner-next"),
        ("G1 X10 RND=2 F100\nM17", [[10, 0, 0]], "corner-next"),
        # A radius of 20 between 10 and 8 is 8 at most.
        ("G1 X10 RND=20 F100\nY8", [[2, 0, 0], [10, 8, 0]], "corner-size"),
        ("G1 X10 CHR=20 F100\nY12", [[10, 10, 0], [10, 12, 0]], "corner-size"),
    ],
)
def test_corners_that_cannot_be_are_left_out_or_smaller(
    run: Run, text: str, ends: list[list[float]], code: str
) -> None:
    found, said = seen(run, text)
    assert [e for k, e in enumerate(found) if k == 0 or e != found[k - 1]] == ends
    assert said == [code]


def test_rounding_of_all_corners_leaves_the_others_out_without_a_word(run: Run) -> None:
    """RNDM through a plunge and a traverse: it was refused at both."""
    ends, said = seen(run, "G1 X10 RNDM=2 F100\nY10\nZ-5\nY20\nX20\nG0 Z10\nRNDM=0\nG1 X30\nY30")
    assert ends == [
        [8, 0, 0],
        [10, 2, 0],
        [10, 10, 0],
        [10, 10, -5],
        [10, 18, -5],
        [12, 20, -5],
        [20, 20, -5],
        [20, 20, 10],
        [30, 20, 10],
        [30, 30, 10],
    ]
    assert said == []


def test_the_feed_of_a_tooth_is_multiplied_by_the_teeth(
    moves: Callable[..., list[tuple[float, ...]]],
) -> None:
    """0.1 mm x 4 teeth x 1000 rev/min."""
    text = "$TC_DPNT[1,1]=4\nT1 D1 M6\nG95 S1000 M3 FZ=0.1\nG1 X10\nM30"
    assert moves(text, dialect="sinumerik") == [(10, 0, 0, 400)]


def test_dwell_counts_turns_of_another_spindle(run: Run) -> None:
    """30 turns at 500 a minute are 3.6 s."""
    out = run("S1=100 M1=3\nS2=500 M2=3\nG4 S2=30\nM30", dialect="sinumerik")
    assert out.errors == []
    assert sum(e.dwell_s for e in out.path.events) == pytest.approx(3.6)


@pytest.mark.parametrize(("x", "speed"), [(86, 200.0 / (math.pi * 0.086)), (10, 2800.0)])
def test_dwell_counts_turns_at_a_constant_surface_speed(run: Run, x: float, speed: float) -> None:
    """200 m a minute around the diameter on which the tool stands, and at most LIMS."""
    out = run(f"G18 G90 G95 DIAMON\nG96 S200 LIMS=2800 M4\nG0 X{x} Z2\nG4 S2\nM30", dialect="sinumerik")
    assert out.errors == []
    assert sum(e.dwell_s for e in out.path.events) == pytest.approx(2 * 60.0 / speed)


@pytest.mark.parametrize(
    ("text", "code", "part"),
    [
        ("G94 FZ=0.1", "feed-missing", "is of G95"),
        ("G95 FZ=0.1", "feed-missing", "number of teeth of tool 0"),
        ("S2=0\nG4 S2=5", "spindle-stopped", "G4 S2"),
    ],
)
def test_faults(run: Run, text: str, code: str, part: str) -> None:
    error = next(d for d in run(f"{text}\nM30", dialect="sinumerik").diagnostics if d.severity == "error")
    assert error.code == code
    assert part in error.message


def test_an_arc_through_a_point_has_a_corner_as_any_arc(run: Run) -> None:
    """RND behind CIP was left out without a word: the fillet of radius r touches Y0 and the circle of 10 about (10, 0) from outside,
    so its centre is at (10 + sqrt((10 + r)² - r²), r). In space the corner is left out, with a warning."""
    ends, said = seen(run, "CIP X20 Y0 I1=10 J1=10 RND=2 F100\nG1 X40")
    reach = math.sqrt(140.0)
    assert ends[:2] == [
        [pytest.approx(10.0 + reach * 10.0 / 12.0, abs=1e-6), pytest.approx(20.0 / 12.0, abs=1e-6), 0],
        [pytest.approx(10.0 + reach, abs=1e-6), 0, 0],
    ]
    assert said == []
    ends, said = seen(run, "CIP X20 Y0 Z5 I1=10 J1=10 K1=7 RND=2 F100\nG1 X40")
    assert ends == [[20, 0, 5], [40, 0, 5]]
    assert said == ["corner-plane"]
