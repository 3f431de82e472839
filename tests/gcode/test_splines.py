"""G5, G5.1, G5.2 and G6.2 become B-splines exactly: checked point by point against their definitions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from cncgen.toolpath.record import FeedMode, Kind, Toolpath


def curve(path: Toolpath, u: np.ndarray) -> np.ndarray:
    """Evaluate the first curve at parameters in [0, 1] of its range, by scipy in homogeneous coordinates."""
    table = path.nurbs
    degree = int(table.degree[0])
    points = table.control_points[: table.point_offset[1], :3]
    weights = table.weights[: table.point_offset[1], None]
    knots = table.knots[: table.knot_offset[1]]
    low, high = knots[degree], knots[-degree - 1]
    homogeneous = BSpline(knots, np.hstack([points * weights, weights]), degree)(low + u * (high - low))
    return homogeneous[:, :3] / homogeneous[:, 3:]


U = np.linspace(0.0, 1.0, 41)
number = st.floats(-50, 50).map(lambda x: round(x, 3))


@given(number, number, number, number, number, number)
def test_g5_is_the_bezier_curve_of_its_four_points(
    x: float, y: float, i: float, j: float, p: float, q: float
) -> None:
    import io

    from cncgen.gcode import read

    text = f"(START, X1 Y2)\nG5 X{x} Y{y} I{i} J{j} P{p} Q{q} F100\nM2"
    (path,) = read(io.BytesIO(text.encode()), "t").chunks()
    a, d = np.array([1.0, 2.0]), np.array([x, y])
    b, c = np.add(a, (i, j)), np.add(d, (p, q))
    t = U[:, None]
    bezier = (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d
    np.testing.assert_allclose(curve(path, U)[:, :2], bezier, atol=1e-9)


def test_g5_goes_on_smoothly(run: Any) -> None:
    out = run("G5 X1 Y1 I0 J3 P0 Q-3 F100\nG5 X2 Y2 P0 Q-3\nM2")
    assert out.errors == []
    table = out.path.nurbs
    assert table.control_points[5, :2].tolist() == [1.0, 4.0]


def test_g5_1_is_the_parabola(run: Any) -> None:
    """A parabola through (-2, 4), (0, 0), (2, 4): the sample of LinuxCNC's manual."""
    out = run("(START, X-2 Y4)\nG5.1 X2 I2 J-8 F100\nM2")
    assert out.errors == []
    points = curve(out.path, U)
    np.testing.assert_allclose(points[:, 1], points[:, 0] ** 2, atol=1e-12)


def test_g5_2_has_uniform_knots_and_its_weights(run: Any) -> None:
    out = run("F10\nG5.2 P1 L3\nX0 Y1 P1\nX2 Y2 P1\nX2 Y0 P1\nX0 Y0 P2\nG5.3\nM2")
    assert out.errors == []
    assert out.path.kind.tolist() == [Kind.NURBS, Kind.EVENT]
    assert out.path.nurbs.degree.tolist() == [2]
    assert out.path.nurbs.knots.tolist() == [0, 0, 0, 1, 2, 3, 3, 3]
    assert out.path.nurbs.weights.tolist() == [1, 1, 1, 1, 2]
    assert out.path.nurbs.control_points[-1, :2].tolist() == [0, 0]


@pytest.mark.parametrize(
    "spline",
    [
        "G5 X10 Y0 I5 J10 P-5 Q10 F6",
        "G5.1 X10 Y0 I5 J10 F6",
        "G5.2 P1 L3 F12\nX5 Y5 P1 F8\nX10 Y0 P1 F6\nG5.3",
        "BSPLINE X3 Y3 F6\nX5 Y5\nX10 Y0",
    ],
)
def test_splines_in_inverse_time_take_their_part_of_a_minute(run: Any, spline: str) -> None:
    """F6 under G93 is a sixth of a minute, as of a line: 0.1 motions a second; of several blocks the last one says it."""
    out = run(f"G93\n{spline}\nG1 X0 F30\nG94 G1 X1 F60\nM2")
    assert out.errors == []
    rows = out.path.kind != Kind.EVENT
    assert out.path.kind[rows].tolist() == [Kind.NURBS, Kind.LINE, Kind.LINE]
    inverse = FeedMode.INVERSE_TIME
    assert out.path.feed_mode[rows].tolist() == [inverse, inverse, FeedMode.SPEED]
    np.testing.assert_allclose(out.path.feed[rows], [0.1, 0.5, 1.0])


def test_g6_2_circle_is_round(programs: Any) -> None:
    from cncgen.gcode import read

    (path,) = read(programs / "circle.nc", "circle.nc").chunks()
    np.testing.assert_allclose(np.linalg.norm(curve(path, U), axis=1), 10.0, rtol=1e-12)


def test_g6_2_row(run: Any) -> None:
    out = run("(START, X1)\nG6.2 P3 K0 X1 Y0 R1 F600\nK0 X5 Y5 R2\nK0 X9 Y0\nK1\nK1\nK1\nG1 X0\nM2")
    assert out.errors == []
    path = out.path
    assert path.kind.tolist() == [Kind.NURBS, Kind.LINE, Kind.EVENT]
    assert path.end[0].tolist() == [9, 0, 0]
    assert path.line.tolist()[:2] == [7, 8]
    np.testing.assert_allclose(path.feed[:2], 10.0)
    assert path.nurbs.knots.tolist() == [0, 0, 0, 1, 1, 1]
    assert path.nurbs.weights.tolist() == [1, 2, 1]


def test_g6_2_in_incremental_mode_adds_to_the_point_before(run: Any) -> None:
    text = "(START, X1)\nG91\nG6.2 P2 K0 X0 Y0 F60\nK0 X2 Y1\nK1 X2 Y1\nK2\nK2\nM2"
    out = run(text)
    assert out.errors == []
    assert out.path.nurbs.control_points[:, :2].tolist() == [[1, 0], [3, 1], [5, 2]]


def test_g6_2_in_inches_and_with_offsets(run: Any) -> None:
    text = "G20\nG92 X1\nG6.2 P2 K0 X1 Y0 F60\nK0 X2 Y1\nK1\nK1\nM2"
    out = run(text)
    assert out.errors == []
    np.testing.assert_allclose(out.path.nurbs.control_points[:, :2], [[0, 0], [25.4, 25.4]])


def test_both_spellings_are_one_code(run: Any) -> None:
    blocks = "P2 K0 X0 Y0 F60\nK0 X2 Y1\nK1\nK1\nM2"
    first, second = run("G06.2 " + blocks), run("G6.2 " + blocks)
    assert first.errors == second.errors == []
    assert first.path.nurbs.knots.tolist() == second.path.nurbs.knots.tolist()


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc"])
def test_a_broken_curve_says_one_thing(run: Any, dialect: str) -> None:
    """After its first fault a curve is read to its end without more faults, and the program goes on."""
    text = "G6.2 P3 K0 X5 Y0 F600\nK0 X5 Y5\nK0 X9 Y0\nK1\nK1\nK1\nG1 X0\nM2"
    assert [code for code, *_ in run(text, dialect=dialect).errors] == ["nurbs-first-point"]


def test_bspline_of_siemens(run: Any) -> None:
    """A uniform clamped B-spline through the polygon's ends; N50's G1 ends it."""
    text = "N10 G1 X0 Y0 F300\nN20 BSPLINE X10 Y20 PW=0.7 PL=1\nN30 X30 Y20\nN40 X40 Y0\nN50 G1 X50\nM2"
    out = run(text)
    assert out.errors == []
    path = out.path
    assert path.kind.tolist() == [Kind.NURBS, Kind.LINE, Kind.EVENT]
    assert path.nurbs.degree.tolist() == [3]
    assert path.nurbs.knots.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    assert path.nurbs.weights.tolist() == [1, 0.7, 1, 1]
    np.testing.assert_allclose(curve(path, U)[[0, -1], :2], [[0, 0], [40, 0]], atol=1e-12)
    assert path.line.tolist()[:2] == [4, 5]


def test_bspline_takes_interval_lengths_and_degree(run: Any) -> None:
    out = run("F300\nBSPLINE SD=2 X1 Y1\nX2 Y0 PL=2\nX3 Y1 PL=0.5\nM2")
    assert out.errors == []
    assert out.path.nurbs.knots.tolist() == [0, 0, 0, 2, 2.5, 2.5, 2.5]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("F9\nBSPLINE X1 Y1\nG1 X2\nM2", "nurbs-points"),
        ("F9\nBSPLINE X1 Y1 PW=4\nM2", "nurbs-weight"),
        ("F9\nBSPLINE X1 Y1 SD=5\nM2", "spline-order"),
        ("BSPLINE X1 Y1\nM2", "feed-missing"),
        ("G0 X1 PW=1\nM2", "unused-word"),
    ],
)
def test_faults_of_bspline(run: Any, text: str, code: str) -> None:
    assert code in [found for found, *_ in run(text).errors]
