"""CYCLE951 of SINUMERIK: levels, allowances and positions, worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

HEAD = "G18 DIAMON G95 F0.2 S1000 M3\nG0 X{x} Z5\n"
#: Parameters, and where the motions of the cycle end in Z and X (a radius): traverses with the feed 0, cuts with theirs, in mm a revolution.
JOBS: dict[str, tuple[float, str, list[tuple[float, float, float]]]] = {
    # A real program's call (a pulley): from 60 down to 40 in cuts of 4 at most, three of 3.333 above the allowance 0.2, Z0 to Z-30 with 0.1.
    "outside in front, roughed": (70, "60,0,40,-30,0,0,1,4,0.2,0.1,11,0,0,0,1,0.3,0,2,1111000", [
        (1.1, 30.2, 0), (1.1, 30.2 - 10 / 3, 0.3), (-29.9, 30.2 - 10 / 3, 0.3), (-28.9, 31.2 - 10 / 3, 0), (1.1, 31.2 - 10 / 3, 0),
        (1.1, 30.2 - 20 / 3, 0.3), (-29.9, 30.2 - 20 / 3, 0.3), (-28.9, 31.2 - 20 / 3, 0), (1.1, 31.2 - 20 / 3, 0),
        (1.1, 20.2, 0.3), (0.1, 20.2, 0.3), (-29.9, 20.2, 0.3), (-29.9, 30.2, 0.3), (-29.9, 31.2, 0), (1.1, 31.2, 0)]),
    "outside in front, finished": (70, "60,0,40,-30,0,0,1,1,0,0,21,0,0,0,1,0.1,0,2,1111000", [
        (1, 31, 0), (1, 20, 0), (0, 20, 0.1), (-30, 20, 0.1), (-30, 30, 0.1), (-30, 31, 0), (1, 31, 0)]),
    "along X": (70, "60,2,40,0,0,0,1,3,0,0,22,0,0,0,1,0.1,0,2,0", [
        (3, 31, 0), (0, 31, 0), (0, 30, 0.1), (0, 20, 0.1), (2, 20, 0.1), (3, 20, 0), (3, 31, 0)]),
    "inside in front, the end in Z a distance": (18, "20,1,30,-16,0,0,3,1,0,0,21,0,0,0,2,0,0,2,10", [
        (3, 8, 0), (3, 15, 0), (1, 15, 0.2), (-15, 15, 0.2), (-15, 10, 0.2), (-15, 8, 0), (3, 8, 0)]),
    "outside behind": (70, "60,-50,40,-20,0,0,0,1,0,0,21,0,0,0,1,0,0,2,0", [
        (-51, 31, 0), (-51, 20, 0), (-50, 20, 0.2), (-20, 20, 0.2), (-20, 30, 0.2), (-20, 31, 0), (-51, 31, 0)]),
}  # fmt: skip


@pytest.mark.parametrize("job", JOBS)
def test_a_corner_is_turned(run: Any, job: str) -> None:
    """840D sl, Operating Manual Turning, "Stock removal": the reference point is that of the blank, the end point that of the corner."""
    start, call, expected = JOBS[job]
    out = run(f"{HEAD.format(x=start)}CYCLE951({call})\nM30", dialect="sinumerik")
    assert out.errors == []
    moves = out.path.kind < 3
    fed = np.nan_to_num(out.path.feed[moves]) * 60.0 / 1000.0
    found = [
        (z, x, feed) for (x, _, z), feed in zip(out.path.end[moves, :3].tolist(), fed.tolist(), strict=True)
    ]
    assert found[1:] == [pytest.approx(place, abs=1e-9) for place in expected]


@pytest.mark.parametrize(
    ("call", "code"),
    [
        ("60,0,40,-30,0,0,3,4,0,0,11,0,0,0,1,0.3", "cycle-words"),
        ("60,0,40,30,0,0,1,4,0,0,11,0,0,0,1,0.3", "cycle-words"),
        ("60,0,40,-30,0,0,1,0,0,0,11,0,0,0,1,0.3", "cycle-words"),
        ("60,0,40,-30,0,0,1,4,0,0,11,1,0,0,1,0.3,1", "not-read"),
        ("60,0,40,-30,50,-10,1,4,0,0,11,0,0,0,1,0.3,2", "not-read"),
        ("60,0,40,-30,0,0,1,4,0,0,31,0,0,0,1,0.3", "not-read"),
        ("60,0,10,-30,0,0,1,4,0,0,11,0,0,0,1,0.3,0,2,1", "not-read"),
        ("60,0,40,20,0,0,0,4,0,0,12,0,0,0,1,0.3", "not-read"),
    ],
)
def test_a_corner_that_is_not_read_is_refused(run: Any, call: str, code: str) -> None:
    out = run(f"{HEAD.format(x=70)}CYCLE951({call})\nM30", dialect="sinumerik")
    assert [d.code for d in out.diagnostics if d.severity == "error"] == [code]
