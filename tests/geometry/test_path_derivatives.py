"""The kernel of a path's derivatives beside a slow obvious reference and beside its plain source."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cncgen.geometry import nurbs
from cncgen.geometry import path as geometry
from cncgen.geometry.path import ARC, EVENT, LINE, NURBS, Path
from cncgen.geometry.tables import ArcTable, NurbsTable
from cncgen.kernels import path_derivatives
from tests.geometry.curves import path_of_curve, program_curve
from tests.kernels.plain import uncompiled


def random_curve(rng: np.random.Generator, start: np.ndarray) -> NurbsTable:
    degree = int(rng.integers(1, 6))
    count = degree + 1 + int(rng.integers(0, 4))
    inner = np.sort(rng.uniform(0.0, 1.0, count - degree - 1))
    points = start + np.cumsum(rng.normal(size=(count, len(start))), axis=0)
    points[0] = start
    knots = np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])
    return nurbs.single(degree, knots, points, rng.uniform(0.5, 2.0, count))


def random_path(seed: int, axes: str, count: int = 12) -> Path:
    """Lines, helices, NURBS, lines of no length and events, in random order."""
    rng = np.random.default_rng(seed)
    at = rng.normal(size=len(axes))
    start, kinds, ends, items = at, [], [], []
    centres, sweeps, tables = [], [], [random_curve(rng, at)]
    for kind in rng.choice([LINE, LINE, ARC, NURBS, NURBS, EVENT], count):
        end, item = at, -1
        if kind == LINE:
            end = at + rng.normal(size=len(axes)) * rng.choice([1.0, 0.0], p=[0.8, 0.2])
        elif kind == ARC:
            sweep = rng.uniform(0.1, 5.0)
            centre = at[:3] + np.array([*rng.normal(size=2), 0.0])
            out = at[:3] - centre
            end, item = at + rng.normal(size=len(axes)), len(sweeps)
            turn = np.array([[np.cos(sweep), -np.sin(sweep)], [np.sin(sweep), np.cos(sweep)]])
            end[:2] = centre[:2] + turn @ out[:2]
            centres.append(centre)
            sweeps.append(sweep)
        elif kind == NURBS:
            tables.append(random_curve(rng, at))
            end, item = tables[-1].control_points[-1], len(tables) - 1
        kinds.append(kind)
        ends.append(end)
        items.append(item)
        at = end
    arcs = ArcTable(
        np.array(centres).reshape(-1, 3), np.tile([0.0, 0.0, 1.0], (len(sweeps), 1)), np.array(sweeps)
    )
    return Path(axes, start, kinds, ends, items, arcs, nurbs.concatenate(tables))


def reference(path: Path, s: float, side: int) -> np.ndarray:
    """Derivatives at one place: those by the row's own parameter, turned into those by s as docs/nurbs.md writes them."""
    row = path.row_of(s, side)
    x, c1, c2, c3 = path.evaluate_parameter(row, path.parameter(row, s, side), 3, side)[:, 0]
    if path.kind[row[0]] == LINE:
        return np.array([x, c1 / path.row_length[row[0]], 0 * x, 0 * x])
    measured = np.arange(len(x)) < 3
    g = np.sqrt(np.sum(c1[measured] ** 2))
    g1 = c1[measured] @ c2[measured] / g
    g2 = (c2[measured] @ c2[measured] + c1[measured] @ c3[measured] - g1**2) / g
    x1 = c1 / g
    x2 = (c2 - x1 * g1) / g**2
    return np.array([x, x1, x2, (c3 - 3.0 * x2 * g * g1 - x1 * g2) / g**3])


@given(st.integers(0, 2**32 - 1), st.sampled_from(["XYZ", "XYZA"]), st.sampled_from([1, -1]))
@settings(max_examples=15, deadline=None)
def test_derivatives_are_those_of_the_formulas(seed: int, axes: str, side: int) -> None:
    path = random_path(seed, axes)
    if path.length == 0.0:
        return
    rng = np.random.default_rng(seed)
    s = np.concatenate([rng.uniform(-0.1, path.length + 0.1, 10), path.breakpoints()])
    found = path.evaluate(s, 3, side)
    for k, place in enumerate(s):
        expected = reference(path, place, side)
        size = np.abs(expected).max(axis=1, keepdims=True) + 1e-3
        assert np.all(np.abs(found[:, k] - expected) <= 1e-9 * size), (place, found[:, k], expected)
    for order in range(3):
        np.testing.assert_array_equal(path.evaluate(s, order, side), found[: order + 1])


def test_plain_python_gives_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    results = []
    for kernel in (path_derivatives, uncompiled("path_derivatives")):
        monkeypatch.setattr(geometry, "path_derivatives", kernel)
        for seed in range(4):
            path = random_path(seed, "XYZB")
            s = np.sort(np.random.default_rng(seed).uniform(0.0, path.length, 40))
            results.append(path.evaluate(s, 3, 1 - 2 * (seed % 2)))
        curve = path_of_curve(program_curve("star"))
        results.append(curve.evaluate(np.linspace(0.0, curve.length, 30), 3))
    for ours, theirs in zip(results[:5], results[5:], strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-13, atol=1e-13)


def straight_or_not(rng: np.random.Generator) -> NurbsTable:
    """A curve on a line up to rounding, or with a point beside it, or of one point; some of its spans may lie on a line."""
    degree = int(rng.integers(1, 4))
    count = int(rng.integers(degree + 1, 9))
    way = rng.normal(size=(count, 1)) * rng.normal(size=3) * rng.choice([0.0, 1e-9, 1.0])
    points = 10.0 ** rng.uniform(-3, 3) + way
    points[int(rng.integers(count))] *= 1.0 + rng.choice([0.0, 1e-10])
    return nurbs.single(degree, np.arange(count + degree + 1.0), points)


def way_of_line(points: np.ndarray) -> np.ndarray:
    """The way from the first point to the furthest, if none is further from that line than 12 roundings: by exact fractions."""
    exact = [[Fraction(float(x)) for x in point] for point in points]
    away = [[x - x0 for x, x0 in zip(point, exact[0], strict=True)] for point in exact]
    furthest = max(range(len(away)), key=lambda k: sum(x * x for x in away[k]))
    line = away[furthest]
    if not any(line):
        return np.zeros(points.shape[1])
    m = max(range(len(line)), key=lambda d: abs(line[d]))
    beside = max(abs(x - one[m] / line[m] * y) for one in away for x, y in zip(one, line, strict=True))
    roundings = float(beside / Fraction(float(np.spacing(np.abs(points).max()))))
    assert not 5.0 < roundings < 19.0, "a case that rounding may decide either way"
    return (points[furthest] - points[0]) * (roundings <= 12.0)


def ways_of_spans(curve: NurbsTable) -> np.ndarray:
    """That of the whole curve for each control point, or else those of spans, in the rows where their points begin."""
    points, order = curve.control_points, int(curve.degree[0]) + 1
    whole = way_of_line(points)
    if whole.any() or np.ptp(points, axis=0).max() == 0.0:
        return np.tile(whole, (len(points), 1))
    out = np.zeros_like(points)
    for first in range(len(points) - order + 1):
        out[first] = way_of_line(points[first : first + order])
    return out


def test_the_ways_of_spans_on_a_line() -> None:
    rng = np.random.default_rng(3)
    curves = [straight_or_not(rng) for _ in range(300)]
    expected = [ways_of_spans(curve) for curve in curves]
    told = [(bool(way.any()), bool(way.any(axis=1).all())) for way in expected]
    assert all(told.count(kind) > 30 for kind in ((False, False), (True, False), (True, True)))
    table = nurbs.concatenate(curves)
    np.testing.assert_array_equal(nurbs.directions(table), np.concatenate(expected))
    slowly = np.zeros_like(table.control_points)
    uncompiled("bspline").directions(nurbs.columns(table), 12.0, slowly)
    np.testing.assert_array_equal(slowly, np.concatenate(expected))


@pytest.mark.parametrize("axes", [2, 3, 4, 9])
def test_a_line_is_straight_however_its_points_are_rounded(axes: int) -> None:
    """Points of lines between exact ends, each the nearest double, at both signs and with a part of -1 to 1."""
    rng = np.random.default_rng(axes)
    for _ in range(300):
        ends = rng.uniform(-1.0, 1.0, (2, axes)) * 10.0 ** rng.integers(-2, 4, (1, axes))
        parts = np.concatenate([[0.0, 1.0], rng.uniform(-1.0, 1.0, 5)])
        start, end = ([Fraction(float(x)) for x in point] for point in ends)
        points = [
            [float(a + Fraction(float(t)) * (b - a)) for a, b in zip(start, end, strict=True)] for t in parts
        ]
        ways = nurbs.directions(nurbs.single(3, np.arange(11.0), points))
        np.testing.assert_array_equal(ways, np.tile(ends[1] - ends[0], (7, 1)))


def test_the_span_of_a_parameter_begins_with_its_first_control_point() -> None:
    """Of two spans and of three, beside a knot and on either side of it, beyond the ends too."""
    points = np.random.default_rng(1).normal(size=(10, 3))
    short = nurbs.single(2, [0, 0, 0, 1, 2, 2, 2], points[:4])
    long = nurbs.single(2, [0, 0, 0, 1, 2, 2, 3, 3, 3], points[4:])
    table = nurbs.concatenate([short, long])
    curve, u = np.array([0, 0, 0, 1, 1, 1, 1]), np.array([-1.0, 1.0, 9.0, 0.5, 1.0, 2.0, 3.0])
    np.testing.assert_array_equal(nurbs.spans(table, curve, u), [0, 1, 1, 4, 5, 7, 7])
    np.testing.assert_array_equal(nurbs.spans(table, curve, u, -1), [0, 0, 1, 4, 4, 5, 7])
    slowly = np.zeros(len(u), np.int64)
    uncompiled("bspline").spans(curve, u, -1, nurbs.columns(table), slowly)
    np.testing.assert_array_equal(slowly, [0, 0, 1, 4, 4, 5, 7])


def test_a_place_that_is_no_number_has_no_position() -> None:
    path = random_path(5, "XYZ")
    assert np.isnan(path.evaluate([np.nan, 0.5 * path.length])[0, :1]).any()
    assert np.all(np.isfinite(path.evaluate([np.nan, 0.5 * path.length])[0, 1]))


@pytest.mark.parametrize("side", [1, -1])
def test_rows_are_found_in_any_order(side: int) -> None:
    path = random_path(7, "XYZ", 200)
    s = np.random.default_rng(8).permutation(np.concatenate([path.row_s, np.linspace(0.0, path.length, 300)]))
    rows, slow = np.zeros((2, len(s)), np.int64)
    path_derivatives.evaluate(
        path._columns, s, side, 0, rows, np.zeros(len(s)), slow, np.zeros((1, len(s), 3))
    )
    np.testing.assert_array_equal(rows, path.row_of(s, side))


@pytest.mark.parametrize("weight", [1e3, 1e5])
def test_places_beside_a_heavy_point_lie_where_their_coordinate_says(weight: float) -> None:
    """Second differences over 1 nm are x'' of the place but for rounding of the coordinate, by at most four of its units.

    |C'| is hundreds of times its mean there, and the rounding of the parameter as many times that: 12 and 160 units.
    """
    points = np.array([[0.0, 0.0, 0.0], [4.0, 8.0, 0.0], [9.0, -3.0, 0.0], [12.0, 5.0, 0.0]])
    curve = nurbs.single(3, np.repeat([0.0, 1.0], 4), points, np.array([1.0, weight, 1.0, 1.0]))
    path, way = path_of_curve(curve), 1e-6
    s = np.linspace(path.row_s[0], path.row_s[-1], 4001)[1:-1, None] + way * np.arange(-1, 2)
    x = path.evaluate(s.ravel(), 2).reshape(3, len(s), 3, 3)
    step = np.abs(np.diff(x[0], 2, axis=1)).max(axis=(1, 2))
    bend = 1.01 * way**2 * np.abs(x[2]).max(axis=(1, 2))
    assert (step - bend).max() <= 4.0 * np.spacing(path.row_s[-1])
