"""Chamfers ,C and roundings ,R of FANUC: their points by hand, and what cannot be."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

HALF = math.sqrt(0.5)


def reached(out: Any, *axes: int) -> np.ndarray:
    """Return where the motions end, on X and Y or other axes (rows of kind 3 are events)."""
    return np.round(out.path.end[out.path.kind != 3][:, axes or (0, 1)], 6)


def ends(out: Any) -> list[list[float]]:
    """Return X and Y of the ends of the motions, after asserting that all went well."""
    assert out.errors == []
    return reached(out).tolist()


def run_corners(run: Any, text: str) -> list[list[float]]:
    return ends(run(f"G90 G17 F100\n{text}\nM30", dialect="fanuc"))


def test_a_chamfer_takes_its_size_off_both_moves(run: Any) -> None:
    assert run_corners(run, "G1 X50. ,C5.\nY30.") == [[45, 0], [50, 5], [50, 30]]
    assert run_corners(run, "G1 X50. ,C5.\nG91 X-30. Y30.") == [
        [45, 0],
        [pytest.approx(50 - 5 * HALF, abs=1e-6), pytest.approx(5 * HALF, abs=1e-6)],
        [20, 30],
    ]


def test_a_rounding_touches_both_moves(run: Any) -> None:
    out = run("F100 G1 X50. ,R10.\nY30.\nM30", dialect="fanuc")
    assert ends(out) == [[40, 0], [50, 10], [50, 30]]
    assert out.path.arcs.centre.tolist() == [[40.0, 10.0, 0.0]]


def test_corners_follow_one_another(run: Any) -> None:
    text = "G1 X50. ,C5.\nY50. ,R10.\nX0 ,R3.\nY20."
    expected = [[45, 0], [50, 5], [50, 40], [40, 50], [3, 50], [0, 47], [0, 20]]
    assert run_corners(run, text) == expected


def test_corners_beside_arcs(run: Any) -> None:
    """The rounding of radius 2 between the axis and a circle of 10 about (20, 0): centres 2 and 12 away from them."""
    points = run_corners(run, "G1 X10. ,R2.\nG2 X30. I10.")
    across = 20 - math.sqrt(12**2 - 2**2)
    assert points[0] == [pytest.approx(across, abs=1e-6), 0]
    assert points[1] == [
        pytest.approx(20 - 10 / 12 * (20 - across), abs=1e-6),
        pytest.approx(2 * 10 / 12, abs=1e-6),
    ]
    chamfer = run_corners(run, "G1 X10. ,C2.\nG2 X30. I10.")
    assert math.dist(chamfer[1], (10, 0)) == pytest.approx(2.0, abs=1e-6)
    assert math.dist(chamfer[1], (20, 0)) == pytest.approx(10.0, abs=1e-6)


def test_corners_stand_in_any_plane_and_take_parameters(run: Any) -> None:
    out = run("#1=2\nG18 F100 G1 X10 ,C[#1+1]\nZ10\nM30", dialect="fanuc")
    assert out.errors == []
    assert reached(out, 0, 2).tolist() == [[7, 0], [10, 3], [10, 10]]
    assert out.moving_axes == "XZ"


def test_cutter_compensation_goes_around_the_chamfer(run: Any) -> None:
    """Inside a corner of 90 degrees the path of the tool's centre has a chamfer shortened by 2 r tan(22.5 degrees)."""
    text = "G10 L12 P1 R2.\nG41 D1 G1 X0 Y10.\nX-50. ,C20.\nY-50.\nX-60.\nG40 X-90.\nM30"
    out = run(f"F100\n{text}", dialect="fanuc", tool_table=None)
    assert out.errors == []
    steps = np.linalg.norm(np.diff(reached(out), axis=0), axis=1)
    assert np.isclose(steps, 20 * math.sqrt(2) - 4 * math.tan(math.pi / 8)).any()


def test_moves_that_go_on_straight_have_no_corner(run: Any) -> None:
    assert run_corners(run, "G1 X10. ,C5.\nX20.") == [[10, 0], [20, 0]]
    assert run_corners(run, "G1 X10. ,C0\nY20.") == [[10, 0], [10, 20]]


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("G1 X10 ,C1\nM3\nY10", "corner-next", 2),
        ("G1 X10 ,C1\nG0 Y10", "corner-next", 2),
        ("G1 X10 ,C1", "corner-next", 2),
        ("G1 X10 ,C1\nZ10", "corner-plane", 2),
        ("G1 X10 ,C11\nY20", "corner-size", 2),
        ("G1 X10 ,R11\nY20", "corner-size", 2),
        ("G1 X10 ,R6\nY9 ,R4\nX0", "corner-size", 3),
        ("G1 X10 ,C-1\nY20", "corner-size", 2),
        ("G0 X10 ,C1\nG1 Y20", "corner-motion", 2),
        ("M8 ,C1\nG1 Y20", "corner-motion", 2),
    ],
)
def test_what_makes_no_corner_is_said(run: Any, text: str, code: str, line: int) -> None:
    out = run(f"F100\n{text}\nM30", dialect="fanuc")
    assert [(found, at) for found, at, _ in out.errors] == [(code, line)]


def test_a_motion_without_its_corner_is_there_all_the_same(run: Any) -> None:
    out = run("F100\nG1 X10 ,C11\nY20\nM30", dialect="fanuc")
    assert reached(out).tolist() == [[10, 0], [10, 20]]


def test_a_block_that_fails_leaves_no_corner_behind(run: Any) -> None:
    out = run("G93\nG1 X10 ,C1\nG0 Y20\nX30\nM30", dialect="fanuc")
    assert [code for code, _, _ in out.errors] == ["feed-missing"]
    assert reached(out).tolist() == [[0, 20], [30, 20]]


def test_the_dialect_is_told_by_them(run: Any) -> None:
    assert ends(run("G90 F100\nG1 X50 ,C5\nY30\nM30")) == [[45, 0], [50, 5], [50, 30]]
