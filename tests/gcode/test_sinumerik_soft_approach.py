"""SINUMERIK: soft approach and retraction, by the manual's examples (840D sl, Fundamentals, "Smooth approach and retraction") and by hand.

With a tool of radius 7 left of a contour along X+ from (40, -10) on, the middle of the tool begins it at (40, -3). DISR=13 is the radius of
the middle's quadrant: its centre is (40, 10), and it begins at (27, 10).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cncgen.toolpath.record import FeedMode, Kind

Run = Callable[..., Any]
#: Where a motion leads, and its feed in mm a minute; 0 is a traverse.
Move = tuple[float, float, float, float]


def made(run: Run, text: str, radius: float = 7.0) -> list[Move]:
    """Return the motions of a text, after asserting that nothing was said."""
    out = run(f"$TC_DP6[1,1]={radius}\nT1 D1 M6\n{text}\nM30", dialect="sinumerik")
    assert [d.message for d in out.diagnostics if d.severity.value != "note"] == []
    path = out.path
    rows = np.flatnonzero(path.kind != Kind.EVENT)
    feeds = np.where(path.feed_mode[rows] == FeedMode.RAPID, 0.0, np.nan_to_num(path.feed[rows]) * 60.0)
    return [
        (*end, feed)
        for end, feed in zip(
            (path.end[rows, :3].round(6) + 0.0).tolist(), feeds.round(6).tolist(), strict=True
        )
    ]


def test_the_example_of_an_approach_in_the_plane(run: Run) -> None:
    """DISCL=AC(5) ends the fast infeed at Z5, FAD goes on to Z0, F is that of the arc."""
    text = "G0 X0 Y0 Z20\nG41 G341 G247 DISCL=AC(5) DISR=13 FAD=500 X40 Y-10 Z=0 F200\nG1 X50\nX60"
    assert made(run, text) == [
        (0, 0, 20, 0), (27, 10, 20, 0), (27, 10, 5, 0), (27, 10, 0, 500), (40, -3, 0, 200), (50, -3, 0, 200), (60, -3, 0, 200),
    ]  # fmt: skip


def test_the_example_with_an_allowance_and_a_retraction(run: Run) -> None:
    """The contour's first point stands in the next block, OFFN=5 makes the radius 12; the way up is a helix at the old feed, then F10000."""
    text = (
        "G0 X0 Y0 Z20 OFFN=5\nG41 G247 G341 Z0 DISCL=AC(7) DISR=10 F1500 FAD=200\nG1 X30 Y-10\nX40 Z2\nX50\n"
        "G248 G340 X70 Y0 Z20 DISCL=AC(6) DISR=5 G40 F10000\nX80 Y0"
    )
    assert made(run, text) == [
        (0, 0, 20, 0), (20, 12, 20, 0), (20, 12, 7, 0), (20, 12, 0, 200), (30, 2, 0, 1500), (40, 2, 2, 1500), (50, 2, 2, 1500),
        (55, 7, 6, 1500), (55, 7, 20, 10000), (70, 0, 20, 10000), (80, 0, 20, 10000),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("block", "way"),
    [
        # A line of DISR and the radius along the contour; G340 changes the height on it.
        ("G42 G147 DISCL=3 DISR=10 X20 Y20 Z0 F300", [(3, 13, 20, 0), (3, 13, 3, 0), (20, 13, 0, 300)]),
        ("G41 G347 DISCL=3 DISR=10 X20 Y20 Z0 F300", [(20, 47, 20, 0), (20, 47, 3, 0), (20, 27, 0, 300)]),
        ("G42 G247 DISCL=3 DISR=10 X20 Y20 Z0 F300", [(10, 3, 20, 0), (10, 3, 3, 0), (20, 13, 0, 300)]),
        # FAD is the feed of the helix too.
        ("G42 G247 DISCL=3 DISR=10 FAD=50 X20 Y20 Z0 F300", [(10, 3, 20, 0), (10, 3, 3, 0), (20, 13, 0, 50)]),
        # G141 and G142 choose the side, G143 that of the tool, which stands right of the contour; a path of 0 radius needs no tool.
        ("G247 G141 DISCL=3 DISR=10 X20 Y20 Z0 F300", [(10, 30, 20, 0), (10, 30, 3, 0), (20, 20, 0, 300)]),
        ("G247 G142 DISCL=3 DISR=10 X20 Y20 Z0 F300", [(10, 10, 20, 0), (10, 10, 3, 0), (20, 20, 0, 300)]),
        ("G247 G143 DISCL=3 DISR=10 X20 Y20 Z0 F300", [(10, 10, 20, 0), (10, 10, 3, 0), (20, 20, 0, 300)]),
        # From the other side: the quadrant of 10 of the middle lies right of (20, 27).
        (
            "G41 G142 G247 DISCL=3 DISR=10 X20 Y20 Z0 F300",
            [(10, 17, 20, 0), (10, 17, 3, 0), (20, 27, 0, 300)],
        ),
    ],
)
def test_approaches(run: Run, block: str, way: list[Move]) -> None:
    found = made(run, f"G0 X0 Y0 Z20\n{block}\nG1 X50")
    assert found[1:4] == way
    assert found[4][:2] == (50, way[2][1])


def test_an_approach_to_an_arc(run: Run) -> None:
    """The arc about the origin begins at (20, 0) along Y+: a quadrant of 5 from the right comes from (25, -5)."""
    found = made(run, "G0 X40 Y0 Z5\nG247 G142 DISR=5 X20 Y0 Z0 F300\nG3 X0 Y20 I-20 J0")
    assert found[1:] == [(25, -5, 5, 0), (25, -5, 0, 0), (20, 0, 0, 300), (0, 20, 0, 300)]


def test_a_retraction_from_an_arc(run: Run) -> None:
    """It ends at (0, 20) along X-: a semicircle of 5 on the left ends at (0, 10)."""
    found = made(run, "G0 X20 Y0 Z0\nG3 X0 Y20 I-20 J0 F300\nG348 G141 G341 DISR=5 DISCL=2 Z9 FAD=60")
    assert found[2:] == [(0, 10, 0, 300), (0, 10, 2, 60), (0, 10, 9, 300)]


def test_motions_belong_to_the_block_of_the_approach(run: Run) -> None:
    out = run("G0 X0 Y0 Z20\nG247 G141 DISR=10 X20 Y20 Z0 F300\nG1 X50\nM30", dialect="sinumerik")
    assert out.path.line[out.path.kind != Kind.EVENT].tolist() == [1, 2, 2, 2, 3]
    assert out.path.path.length == pytest.approx(20 + math.hypot(10, 30) + 20 + 5 * math.pi + 30)


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("G247 DISR=10 X20 Y20 F100\nG1 X30", "G41 or G42"),
        ("G41 G247 X20 Y20 F100\nG1 X30", "DISR=0"),
        ("G41 G247 DISR=5 X20 Y20 F100", "not followed"),
        ("G41 G247 DISR=5 X20 Y20 F100\nTRANS X5", "not followed"),
        ("G41 G247 DISR=5 DISRP=5 X20 Y20 F100\nG1 X30", "DISRP"),
        ("G41 G142 G247 DISR=5 X20 Y20 F100\nG1 X30", "other side"),
        ("G41 G247 G147 DISR=5 X20 Y20 F100\nG1 X30", "beside another"),
        ("G248 G141 DISR=5 Z10 F100", "behind a motion"),
    ],
)
def test_faults(run: Run, text: str, part: str) -> None:
    found = run(f"$TC_DP6[1,1]=7\nT1 D1 M6\nG0 Z5\n{text}\nM30", dialect="sinumerik").diagnostics
    error = next(d for d in found if d.severity == "error")
    assert error.code == "soft-approach"
    assert part in error.message
