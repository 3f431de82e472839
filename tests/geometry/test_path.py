"""Paths: rows of every kind by one coordinate, derivatives by arc length, breakpoints, what is degenerate."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cncgen.geometry import nurbs
from cncgen.geometry import path as rows
from cncgen.geometry.path import ARC, EVENT, LINE, NURBS, Path
from cncgen.geometry.tables import ArcTable, NurbsTable, empty_arcs, empty_nurbs
from cncgen.toolpath.record import Kind
from tests.geometry.curves import curves, path_of_curve, program_curve


def lines(points: list, axes: str = "XYZ", kind: list | None = None) -> Path:
    """Path of lines through points (or of the kinds given)."""
    n = len(points) - 1
    kinds = kind or [LINE] * n
    return Path(axes, points[0], kinds, points[1:], [-1] * n, empty_arcs(), empty_nurbs(len(axes)))


def one_arc(start: list, end: list, centre: list, normal: list, sweep: float, axes: str = "XYZ") -> Path:
    table = ArcTable(np.array([centre], float), np.array([normal], float), np.array([sweep], float))
    return Path(axes, start, [ARC], [end], [0], table, empty_nurbs(len(axes)))


def assert_derivatives(path: Path, s: np.ndarray, step: float = 1e-4, tolerance: float = 1e-6) -> None:
    """Each derivative is the central difference of the one before it."""
    for order in (1, 2, 3):
        ahead, behind = path.evaluate(s + step, order - 1)[-1], path.evaluate(s - step, order - 1)[-1]
        given = path.evaluate(s, order)[order]
        np.testing.assert_allclose(
            (ahead - behind) / (2 * step), given, atol=tolerance * (1 + np.abs(given).max())
        )


def test_kinds_are_those_of_the_toolpath() -> None:
    assert (Kind.LINE, Kind.ARC, Kind.NURBS, Kind.EVENT) == (rows.LINE, rows.ARC, rows.NURBS, rows.EVENT)


def test_lines_meet_their_ends_to_the_bit() -> None:
    path = lines([[0.1, 0.2, 0.3], [3.1, 4.2, 0.3], [3.1, 4.2, 12.3]])
    assert path.length == pytest.approx(17.0)
    np.testing.assert_array_equal(path.evaluate(path.row_s)[0], np.vstack([path.start, path.end]))
    left, right = path.evaluate([5.0], 1, -1)[1], path.evaluate([5.0], 1, 1)[1]
    np.testing.assert_allclose(left, [[0.6, 0.8, 0]], atol=1e-15)
    np.testing.assert_allclose(right, [[0, 0, 1]], atol=1e-15)


def test_a_row_that_rounding_made_has_no_length_and_hides_no_corner() -> None:
    """0.1 + 0.2 and then 0.3 are 6e-17 apart: both rows beside it meet there, in the turn between them."""
    path = lines([[0, 0, 0], [0.1 + 0.2, 0, 0], [0.3, 0, 0], [0.3, 5, 0]])
    assert path.row_length[1] == 0.0
    assert path.row_s[1] == path.row_s[2]
    jumps = path.jumps()
    np.testing.assert_array_equal(jumps.s, path.row_s[1:2])
    np.testing.assert_allclose(jumps.tangent, [[-1, 1, 0]], atol=1e-15)
    assert (jumps.before[0], jumps.after[0]) == (0, 2)


def test_coordinate_is_xyz_else_uvw_else_rotary() -> None:
    path = lines(
        [[0, 0, 0, 0, 0, 0], [3, 4, 0, 1, 1, 7], [3, 4, 0, 2, 1, 10], [3, 4, 0, 5, 5, 10]], axes="XYZACU"
    )
    np.testing.assert_allclose(np.diff(path.row_s), [5.0, 3.0, 5.0])
    np.testing.assert_allclose(path.evaluate([2.5], 1)[1], [[0.6, 0.8, 0, 0.2, 0.2, 1.4]])


def test_a_line_that_hardly_moves_xyz_is_measured_over_what_moves() -> None:
    """10⁻⁷ mm beside a radian, 10⁻⁷ mm beside 4 mm of U, and 0.02 mm beside a radian, which is enough."""
    path = lines(
        [[0, 0, 0, 0, 0], [1e-7, 0, 0, 1, 0], [2e-7, 0, 0, 1, 4], [0.02 + 2e-7, 0, 0, 2, 4]], axes="XYZAU"
    )
    np.testing.assert_allclose(path.row_length, [1.0, 4.0, 0.02])
    np.testing.assert_allclose(path.feed_length, [1e-7, 1e-7, 0.02])
    np.testing.assert_allclose(path.per_feed, [1e7, 4e7, 1.0])
    assert path.turns.tolist() == [True, False, False]
    assert path.moves_xyz.tolist() == [False, False, True]


def test_helix_has_closed_form_derivatives() -> None:
    """x = r (cos θ, sin θ), z = h θ/2π: ds/dθ = √(r² + (h/2π)²), curvature r / (ds/dθ)²."""
    r, h = 3.0, 2.0
    path = one_arc([r, 0, 0, 0], [r, 0, 2 * h, 8], [0, 0, 0], [0, 0, 1], 4 * np.pi, "XYZA")
    g = np.hypot(r, h / (2 * np.pi))
    assert path.length == pytest.approx(4 * np.pi * g, rel=1e-15)
    s = np.linspace(0.1, path.length - 0.1, 50)
    x, x1, x2, x3 = path.evaluate(s, 3)
    angle = s / g
    c, d = np.cos(angle), np.sin(angle)
    np.testing.assert_allclose(
        x, np.stack([r * c, r * d, h * angle / (2 * np.pi), 8 * s / path.length], 1), atol=1e-13
    )
    np.testing.assert_allclose(x1[:, :2], np.stack([-d, c], 1) * r / g, atol=1e-14)
    np.testing.assert_allclose(x2, np.stack([-c, -d, 0 * c, 0 * c], 1) * r / g**2, atol=1e-14)
    np.testing.assert_allclose(x3, np.stack([d, -c, 0 * c, 0 * c], 1) * r / g**3, atol=1e-14)
    np.testing.assert_allclose(path.curvature(s), r / g**2, rtol=1e-12)


@pytest.mark.parametrize(
    ("end", "sweep"),
    [
        ([10.0, 0.0, 4.0], 6 * np.pi),
        ([-3.0, 9.6, 0.0], 2 * np.pi + np.arctan2(9.6, -3.0)),
        ([0, 10, 0], np.pi / 2),
    ],
)
def test_turning_points_are_where_an_axis_begins_to_go_back(end: list[float], sweep: float) -> None:
    """They are where coordinates of places close together change from rising to falling; the ends of an arc are none."""
    path = one_arc([10, 0, 0], end, [0, 0, 0], [0, 0, 1], sweep)
    s = np.linspace(0.0, path.length, 400_001)
    rises = np.diff(path.evaluate(s, 0)[0][:, :2], axis=0) > 0
    expected = np.sort(np.concatenate([s[1:-1][rises[1:, i] != rises[:-1, i]] for i in range(2)]))
    expected = expected[(expected > s[2]) & (expected < s[-3])]
    assert path.turning_points() == pytest.approx(expected, abs=2.0 * s[1])


def test_arc_with_radii_that_differ_by_a_tolerance_has_exact_speed() -> None:
    path = one_arc([10, 0, 0], [0, 10.01, 0], [0, 0, 0], [0, 0, 1], np.pi / 2)
    theta = np.linspace(0, np.pi / 2, 20001)
    radius = 10 + 0.01 * theta / (np.pi / 2)
    polygon = np.stack([radius * np.cos(theta), radius * np.sin(theta)], 1)
    assert path.length == pytest.approx(np.sum(np.linalg.norm(np.diff(polygon, axis=0), axis=1)), abs=1e-7)
    np.testing.assert_allclose(path.evaluate([path.length])[0], [[0, 10.01, 0]], atol=1e-13)
    s = np.linspace(0.01, path.length - 0.01, 40)
    np.testing.assert_allclose(np.linalg.norm(path.evaluate(s, 1)[1], axis=1), 1.0, atol=1e-14)
    np.testing.assert_allclose(path.coordinate(0, path.parameter(0, s)), s, atol=1e-12)
    assert_derivatives(path, s)


def test_arc_from_its_centre_spirals_out() -> None:
    path = one_arc([0, 0, 0], [0, 2, 0], [0, 0, 0], [0, 0, 1], np.pi / 2)
    np.testing.assert_allclose(path.evaluate([0, path.length])[0], [[0, 0, 0], [0, 2, 0]], atol=1e-14)


@given(curves(max_degree=6))
@settings(max_examples=25)
def test_speed_along_a_nurbs_is_one(table: NurbsTable) -> None:
    path = path_of_curve(table)
    # Closer to a place where C' vanishes nothing can be said of a derivative.
    s = np.linspace(0.02, 0.98, 60) * path.length
    x1 = path.evaluate(s, 1)[1]
    np.testing.assert_allclose(np.linalg.norm(x1, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(path.coordinate(0, path.parameter(0, s)), s, atol=1e-9)


def test_travel_per_period_on_the_butterfly_is_what_was_asked() -> None:
    """0.1 mm a period: true arc length between samples within 1e-6 of it (issue: 1e-4 %)."""
    path = path_of_curve(program_curve("butterfly"))
    s = np.arange(0, path.length, 0.1)
    u = path.parameter(0, s)
    measured = path._nurbs.at(np.zeros(len(u), np.int64), u)
    assert np.abs(np.diff(measured) / 0.1 - 1).max() < 1e-6 * 0.01


def test_derivatives_on_the_butterfly() -> None:
    path = path_of_curve(program_curve("butterfly"))
    s = np.linspace(1, path.length - 1, 500)
    s = s[np.abs(s[:, None] - path.breakpoints()).min(axis=1) > 2e-3]
    s = s[path.curvature(s) < 1.0]
    assert_derivatives(path, s, step=1e-4, tolerance=1e-6)


def test_breakpoints_are_ends_and_knots_and_jumps_are_there() -> None:
    """A line, then a cubic with a knot: the third derivative jumps at the knot, the tangent at the joint."""
    table = nurbs.single(
        3, [0, 0, 0, 0, 1, 2, 2, 2, 2], [[1, 0, 0], [1, 1, 0], [2, 2, 0], [3, 3, 0], [4, 0, 0]]
    )
    path = Path("XYZ", [0, 0, 0], [LINE, NURBS], [[1, 0, 0], [4, 0, 0]], [-1, 0], empty_arcs(), table)
    s = path.breakpoints()
    assert len(s) == 4
    np.testing.assert_array_equal(s[[0, 1, 3]], path.row_s)
    assert path.parameter(1, s[2:3])[0] == 1.0
    jumps = path.jumps()
    np.testing.assert_allclose(jumps.tangent[0], [-1, 1, 0], atol=1e-12)
    np.testing.assert_allclose(jumps.tangent[1], 0, atol=1e-12)
    np.testing.assert_allclose(jumps.second[1], 0, atol=1e-12)
    assert np.abs(jumps.third[1]).max() > 0.1
    assert list(jumps.before) == [0, 1]
    assert list(jumps.after) == [1, 1]


def test_rows_that_do_not_move() -> None:
    """Zero-length lines and events in the middle and at the ends: no NaN, no row of theirs is ever found."""
    points = [[0, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0], [2, 1, 0], [2, 1, 0]]
    path = lines(points, kind=[LINE, LINE, EVENT, LINE, LINE, EVENT])
    s = np.linspace(-0.5, path.length + 0.5, 41)
    for side in (-1, 1):
        assert set(path.row_of(s, side)) == {1, 4}
        values = path.evaluate(s, 3, side)
        assert np.isfinite(values).all()
        np.testing.assert_allclose(np.linalg.norm(values[1], axis=1), 1.0)
    assert path.row_of([1.0], -1)[0] == 1
    assert path.row_of([1.0], 1)[0] == 4


def test_path_that_does_not_move_at_all() -> None:
    path = lines([[1, 2, 3], [1, 2, 3]])
    values = path.evaluate([0.0, 1.0], 3)
    np.testing.assert_array_equal(values[0], [[1, 2, 3], [1, 2, 3]])
    assert not values[1:].any()
    assert path.length == 0.0
    assert len(path.jumps().s) == 0


def test_path_without_rows_is_refused() -> None:
    with pytest.raises(ValueError, match="without rows"):
        lines([[0, 0, 0]]).evaluate([0.0])


def test_nurbs_of_one_point() -> None:
    path = path_of_curve(nurbs.single(3, [0] * 4 + [1] * 4, np.ones((4, 3))))
    assert path.length == 0.0
    values = path.evaluate([0.0], 3)
    np.testing.assert_array_equal(values[0], [[1, 1, 1]])
    assert np.isfinite(values).all()


@pytest.mark.parametrize("knots", [(0.084983, 0.371331), (0.25, 0.5), (0.1, 0.8)])
def test_each_side_of_a_knot_is_its_own_span(knots: tuple[float, float]) -> None:
    """A polyline that turns back: 0.084983 + (0.371331 - 0.084983) is the float beyond 0.371331, in the next span."""
    points = [[0, 0, 0], [3, 4, 0], [6, 0, 0], [3, 4, 0]]
    path = path_of_curve(nurbs.single(1, [0, 0, *knots, 1, 1], points, [1.0] * 4))
    np.testing.assert_allclose(path.row_s[-1], 15.0)
    jumps = path.jumps()
    np.testing.assert_allclose(jumps.s, [5.0, 10.0])
    np.testing.assert_allclose(jumps.tangent, [[0, -1.6, 0], [-1.2, 1.6, 0]], atol=1e-12)


def test_cusp_is_a_breakpoint_with_a_tangent_on_each_side() -> None:
    """(t², t³) for t = −1 … 1 as a Bézier curve: at the origin the tangent turns back."""
    table = nurbs.single(3, [-1] * 4 + [1] * 4, [[1, -1, 0], [-1 / 3, 1, 0], [-1 / 3, -1, 0], [1, 1, 0]])
    path = path_of_curve(table)
    middle = path.length / 2
    assert np.abs(path.breakpoints() - middle).min() < 1e-9
    np.testing.assert_allclose(path.evaluate([middle - 1e-7], 1)[1], [[-1, 0, 0]], atol=1e-2)
    np.testing.assert_allclose(path.evaluate([middle + 1e-7], 1)[1], [[1, 0, 0]], atol=1e-2)
    assert np.isfinite(path.evaluate(np.linspace(0, path.length, 1001), 3)).all()
    exact = (13**1.5 - 8) / 27 * 2
    assert path.length == pytest.approx(exact, abs=1e-9)


def test_cusps_of_many_curves_stand_where_each_of_them_stops() -> None:
    """Of curves end to end those that stop: (t², t³) of two sizes, at a knot where three points are one, at a start that is one.

    A sharp bend beside a point of large weight and a plain curve have none. Places of (t², t³) are (13√13 − 8)/27 of its size
    from each end, that of the knot is the length of its first span.
    """
    cusp = np.array([[1, -1, 0], [-1 / 3, 1, 0], [-1 / 3, -1, 0], [1, 1, 0]])
    flat = [0.0] * 4 + [1.0] * 4
    plain = nurbs.single(3, flat, [[0, 0, 0], [5, 5, 0], [10, -5, 0], [15, 5, 0]])
    bend = nurbs.single(
        2,
        [0, 0, 0, 1, 2, 3, 3, 3],
        [[0, 0, 0], [5, 5, 0], [10, 0, 0], [15, 5, 0], [20, 0, 0]],
        [1, 1e3, 1e-3, 1, 1],
    )
    halves = [[0, 0, 0], [5, 5, 0], [10, 5, 0], [10, 5, 0], [10, 5, 0], [5, -5, 0], [0, -9, 0]]
    knot = nurbs.single(3, [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2], halves)
    start = nurbs.single(3, flat, [[0, 0, 0], [0, 0, 0], [10, -5, 0], [15, 5, 0]])
    tables = [nurbs.single(3, flat, cusp), bend, knot, plain, nurbs.single(3, flat, 10.0 * cusp), start, bend]
    moved, ends, at = [], [], np.zeros(3)
    for table in tables:
        points = table.control_points - table.control_points[0] + at
        moved.append(nurbs.single(int(table.degree[0]), table.knots, points, table.weights))
        at = points[-1]
        ends.append(at)
    n = len(tables)
    path = Path(
        "XYZ",
        np.zeros(3),
        [NURBS] * n,
        np.array(ends),
        list(range(n)),
        empty_arcs(),
        nurbs.concatenate(moved),
    )
    half = (13**1.5 - 8) / 27
    first = nurbs.lengths(nurbs.single(3, flat, halves[:4])).total[0]
    want = path.row_s[[0, 2, 4, 5]] + [half, first, 10.0 * half, 0.0]
    found = path._cusps
    assert (np.diff(found) >= 0.0).all()
    assert np.abs(found[:, None] - want).min(axis=1) == pytest.approx(np.zeros(len(found)), abs=1e-8)
    assert np.abs(found[:, None] - want).min(axis=0) == pytest.approx(np.zeros(len(want)), abs=1e-8)


@pytest.mark.parametrize(
    ("points", "weights"),
    [
        ([[0, 0, 0], [5, 5, 0], [10, 0, 0], [15, 5, 0], [20, 0, 0]], [1, 1e3, 1e-3, 1, 1]),
        # Beside the knot a cell is tiny, though |C'| does not vanish on it.
        (
            [
                [-8.251, -7.486, 0],
                [-0.446, -2.5, 0],
                [-7.934, 2.426, 0],
                [0.235, 2.376, 0],
                [-7.776, -9.174, 0],
                [9.07, -8.86, 0],
            ],
            [1, 1e-3, 1e3, 1e3, 0.1, 1],
        ),
    ],
)
def test_derivatives_in_a_sharp_bend_are_those_of_the_bend(
    points: list[list[float]], weights: list[float]
) -> None:
    """Beside a control point of large weight |C'| is 1e-5 of its mean: x' changes by the integral of x'', x'' by the next one's."""
    inner = len(points) - 2
    path = path_of_curve(
        nurbs.single(2, [0, 0, *range(inner + 1), inner, inner], points, [float(w) for w in weights])
    )
    knot = float(path.coordinate(0, 1.0)[0])
    for side in (-1, 1):
        s = knot + side * np.geomspace(1e-9, 1e-6, 4001)
        _, *x = path.evaluate(s, 3, side)
        for one, other in itertools.pairwise(x):
            change = np.sum(0.5 * (other[1:] + other[:-1]) * np.diff(s)[:, None], axis=0)
            np.testing.assert_allclose(change, one[-1] - one[0], atol=1e-3 * np.abs(one).max())


@pytest.mark.parametrize("away", [0.0, 300.0, 1e5])
@pytest.mark.parametrize("size", [0.01, 1.0, 50.0])
def test_a_straight_curve_turns_back_where_it_does_wherever_it_stands(away: float, size: float) -> None:
    """x = 3t(2 − 5t + 4t²)·size, whose derivative vanishes at t = 1/2 and 1/3, far from the origin too."""
    points = np.array([[0, 0, 0], [2, 0, 0], [-1, 0, 0], [3, 0, 0]]) * size + away
    path = path_of_curve(nurbs.single(3, [0] * 4 + [1] * 4, points))
    jumps = path.jumps()
    turned = np.unique(np.round(path.evaluate(jumps.s[np.abs(jumps.tangent[:, 0]) > 1.9])[0][:, 0] - away, 9))
    np.testing.assert_allclose(np.abs(jumps.tangent[np.abs(jumps.tangent[:, 0]) > 0.1, 0]), 2.0, atol=1e-6)
    x = [3 * t * (2 - 5 * t + 4 * t * t) * size for t in (1 / 2, 1 / 3)]
    assert np.abs(turned[:, None] - x).min(axis=1) == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("way", [[1.0, 0.0, 0.0], [0.3, -1.7, 0.9]])
def test_a_curve_on_a_line_bends_nowhere(way: list[float]) -> None:
    """Its direction is that of the line, forth or back, to the last digit, and what bends it nothing: beside C' = 0 too."""
    points = 0.801752 + np.outer([0.0, 0.0, 0.0, -0.318, 0.6435, 1.1317, 1.6898], way)
    path = path_of_curve(nurbs.single(3, [0] * 4 + [0.037432, 0.746108, 0.746108] + [1] * 4, points))
    s = np.concatenate([np.linspace(0.0, path.length, 997), path.breakpoints()])
    for side in (-1, 1):
        _, x1, x2, x3 = path.evaluate(s, 3, side)
        np.testing.assert_allclose(
            np.abs(x1), np.tile(np.abs(way) / np.linalg.norm(way), (len(s), 1)), rtol=1e-14
        )
        assert not x2.any()
        assert not x3.any()
        assert set(np.sign(x1[:, 0])) == {-1.0, 1.0}


def test_a_straight_span_of_a_bent_curve_bends_nowhere() -> None:
    """Its last one turns back and ends in equal points, where rounding alone had made third derivatives of up to 1e4."""
    points = [[0, 0, 0], [0.3, 0.7, -0.2], [0.389, -1.402, -0.676], [-0.193, -1.183, -0.726]]
    points += [points[2], points[2]]
    weights = [0.3, 1.2, 0.9, 3.6, 0.6, 1.3]
    path = path_of_curve(nurbs.single(3, [0] * 4 + [0.4, 0.9] + [1] * 4, points, weights))
    line = np.subtract(points[2], points[3])
    begin = float(path.coordinate([0], [0.9])[0])
    assert np.linalg.norm(path.evaluate([0.5 * begin], 2)[2]) > 0.1
    s = np.concatenate([np.linspace(begin, path.length, 500), path.length - np.logspace(-12, -1, 100)])
    for side in (-1, 1):
        at = s[s > begin] if side < 0 else s
        _, x1, x2, x3 = path.evaluate(at, 3, side)
        way = np.tile(np.abs(line) / np.linalg.norm(line), (len(at), 1))
        np.testing.assert_allclose(np.abs(x1), way, rtol=1e-14)
        assert not x2.any()
        assert not x3.any()


def test_a_straight_curve_that_ends_in_equal_points_of_other_weights_stays_straight() -> None:
    """C' ~ (1 − u)² at its end, where differences of weighted points once left rounding alone: x''' of 1e13."""
    points = [[0, 0, 0], [9, 15, -0.4], [9, 15, -0.4], [9, 15, -0.4]]
    path = path_of_curve(nurbs.single(3, [0] * 4 + [1] * 4, points, [1.0, 0.5, 2.0, 1.0]))
    length = np.linalg.norm(points[1])
    s = length - np.array([3.0, 1e-3, 1e-6, 0.0])
    _, x1, x2, x3 = path.evaluate(s, 3, -1)
    np.testing.assert_allclose(x1, np.tile(points[1] / length, (4, 1)), atol=1e-9)
    assert np.abs(x2).max() < 1e-6
    assert np.abs(x3).max() < 1.0


def test_a_curve_that_halts_at_a_knot_has_its_tangent_on_the_left_of_it_too() -> None:
    """Straight to (3, 4) with C' = 0 there, and on in X: the left tangent was 0 where the cell on the right is long."""
    points = [[0, 0, 0], [3, 4, 0], [3, 4, 0], [5, 4, 0], [7, 4, 0]]
    path = path_of_curve(nurbs.single(2, [0, 0, 0, 0.5, 0.5, 1, 1, 1], points))
    jumps = path.jumps()
    for tangent in jumps.tangent:
        np.testing.assert_allclose(tangent, [0.4, -0.8, 0.0], atol=1e-8)
    np.testing.assert_allclose(jumps.s, 5.0, atol=1e-9)


def test_curve_that_starts_with_coinciding_points_has_its_tangent() -> None:
    table = nurbs.single(3, [0] * 4 + [1] * 4, [[0, 0, 0], [0, 0, 0], [3, 0, 0], [3, 4, 0]])
    path = path_of_curve(table)
    np.testing.assert_allclose(path.evaluate([0.0], 1)[1], [[1, 0, 0]], atol=1e-5)


@pytest.mark.parametrize("size", [1e-7, 1e-3, 1.0])
def test_curve_that_turns_back_in_xyz_while_another_axis_turns(size: float) -> None:
    """x = 2u(1 − u)·size, a = u: by x alone da/dx was without bound in the middle. By both, ds² = dx² + da²."""
    points = [[0, 0, 0, 0], [size, 0, 0, 0.5], [0, 0, 0, 1]]
    path = path_of_curve(nurbs.single(2, [0] * 3 + [1] * 3, points), "XYZA")
    at, slope = 2.0 * size, np.hypot(1.0, 2.0 * size)
    assert path.length == pytest.approx(0.5 * (slope + np.arcsinh(at) / at), rel=1e-12)
    _, x1, x2 = path.evaluate(np.linspace(0.0, path.length, 101), 2)
    np.testing.assert_allclose(np.linalg.norm(x1, axis=1), 1.0, atol=1e-9)
    assert np.abs(x2).max() <= 4.0 * size * (1 + 1e-9)
    assert not path.moves_xyz.any()


def test_curve_that_halts_in_xyz_while_another_axis_turns() -> None:
    points = [[0, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 1], [2, 0, 0, 1]]
    path = path_of_curve(nurbs.single(1, [0, 0, 1, 2, 3, 3], points), "XYZA")
    assert path.length == pytest.approx(3.0)
    np.testing.assert_allclose(path.evaluate([1.5])[0], [[1, 0, 0, 0.5]], atol=1e-12)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_order_of_the_places_does_not_matter(seed: int) -> None:
    random = np.random.default_rng(seed)
    path = path_of_curve(program_curve("trident"))
    s = random.uniform(0, path.length, 200)
    shuffled = path.evaluate(s, 3)
    order = np.argsort(s)
    np.testing.assert_array_equal(shuffled[:, order], path.evaluate(s[order], 3))


def test_a_rotary_move_below_a_standstill_has_its_feed_along_itself() -> None:
    """3·10⁻⁸ degrees beside a longer move: its feed was infinite, and the line longer by a tenth when it was cut."""
    ends = np.zeros((2, 4))
    ends[:, 3] = [0.1, 0.1 + 5e-10]
    path = Path("XYZA", np.zeros(4), [LINE] * 2, ends, [-1] * 2, empty_arcs(), empty_nurbs(4))
    np.testing.assert_allclose(path.row_length, [0.1, 5e-10], rtol=1e-6)
    np.testing.assert_array_equal(path.per_feed, [1.0, 1.0])
