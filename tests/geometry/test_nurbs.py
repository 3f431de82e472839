"""Rational B-splines: against scipy's BSpline, closed forms, and the uncompiled kernels."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from cncgen.geometry import nurbs
from cncgen.geometry.tables import NurbsTable
from cncgen.kernels import arc_length, bspline
from tests.geometry.curves import curves, program_curve
from tests.kernels.plain import uncompiled


def reference(table: NurbsTable, u: np.ndarray, order: int) -> np.ndarray:
    """Derivatives by scipy's BSpline of numerator and denominator, then Leibniz' rule term by term."""
    points = table.control_points * table.weights[:, None]
    top = BSpline(table.knots, points, int(table.degree[0]))
    bottom = BSpline(table.knots, table.weights, int(table.degree[0]))
    a = [top(u, k) for k in range(order + 1)]
    w = [bottom(u, k)[:, None] for k in range(order + 1)]
    out = [a[0] / w[0]]
    for k in range(1, order + 1):
        rest = sum(
            binomial * w[i] * out[k - i] for i, binomial in zip(range(1, k + 1), PASCAL[k], strict=True)
        )
        out.append((a[k] - rest) / w[0])
    return np.array(out)


PASCAL = {1: [1], 2: [2, 1], 3: [3, 3, 1]}


@given(curves(), st.integers(0, 1000))
def test_derivatives_equal_scipys_to_1e_12(table: NurbsTable, seed: int) -> None:
    first, last = table.knots[0], table.knots[-1]
    u = np.random.default_rng(seed).uniform(first, last, 40)
    u = u[np.abs(u[:, None] - table.knots).min(axis=1) > 1e-9]
    ours, theirs = nurbs.evaluate(table, 0, u, 3), reference(table, u, 3)
    for k in range(4):
        # Relative to the largest value: a derivative that passes through zero has no relative error of its own.
        assert np.abs(ours[k] - theirs[k]).max(initial=0) <= 1e-12 * max(
            np.abs(theirs[k]).max(initial=0), 1e-3
        )


def test_quarter_circle_of_degree_two_is_a_circle() -> None:
    table = nurbs.single(2, [0, 0, 0, 1, 1, 1], [[1, 0, 0], [1, 1, 0], [0, 1, 0]], [1, np.sqrt(0.5), 1])
    x, x1 = nurbs.evaluate(table, 0, np.linspace(0, 1, 33), 1)
    np.testing.assert_allclose(np.linalg.norm(x, axis=1), 1.0, atol=3e-16)
    np.testing.assert_allclose(np.sum(x * x1, axis=1), 0.0, atol=1e-15)
    assert nurbs.lengths(table).total[0] == pytest.approx(np.pi / 2, abs=1e-12)


def test_side_chooses_the_span_at_a_knot() -> None:
    """A polyline as a spline of degree 1: left and right slope at the vertex."""
    table = nurbs.single(1, [0, 0, 1, 2, 2], [[0, 0, 0], [1, 0, 0], [1, 3, 0]])
    np.testing.assert_array_equal(nurbs.evaluate(table, 0, [1.0], 1, side=-1)[1], [[1, 0, 0]])
    np.testing.assert_array_equal(nurbs.evaluate(table, 0, [1.0], 1, side=1)[1], [[0, 3, 0]])
    np.testing.assert_array_equal(nurbs.evaluate(table, 0, [2.0], 1, side=1)[1], [[0, 3, 0]])
    np.testing.assert_array_equal(nurbs.evaluate(table, 0, [0.0], 1, side=-1)[1], [[1, 0, 0]])


def test_order_beyond_the_degree_is_zero_and_beyond_three_is_refused() -> None:
    table = nurbs.single(1, [0, 0, 1, 1], [[0, 0, 0], [1, 2, 3]])
    assert not nurbs.evaluate(table, 0, [0.25, 0.75], 3)[2:].any()
    with pytest.raises(ValueError, match="order"):
        nurbs.evaluate(table, 0, [0.5], 4)


@pytest.mark.parametrize(
    ("degree", "knots", "points", "weights", "message"),
    [
        (2, [0, 0, 1, 1], [[0, 0, 0], [1, 1, 1]], None, "points"),
        (1, [0, 1, 0, 1], [[0, 0, 0], [1, 1, 1]], None, "decrease"),
        (1, [0, 0, 1, 1], [[0, 0, 0], [1, 1, 1]], [1, 0], "positive"),
        (1, [0, 0, 1, 1], [[0, 0, np.nan], [1, 1, 1]], None, "finite"),
    ],
)
def test_what_is_no_curve_is_refused(
    degree: int, knots: list, points: list, weights: list, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        nurbs.single(degree, knots, points, weights)


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        ("degree", 0, "degree"),
        ("weights", -1.0, "positive"),
        ("knots", 5.0, "decrease"),
        ("control_points", np.inf, "finite"),
    ],
)
def test_one_curve_among_others_that_is_none_is_refused(column: str, value: float, message: str) -> None:
    """Two curves, of which the first has a fault."""
    one = nurbs.single(1, [0, 0, 1, 1], [[0, 0, 0], [1, 1, 1]])
    both = nurbs.concatenate([one, one])
    broken = getattr(both, column).copy()
    broken[1 if column == "knots" else 0] = value
    with pytest.raises(ValueError, match=message):
        nurbs.check(replace(both, **{column: broken}))


@given(st.lists(curves(), min_size=1, max_size=4), st.integers(0, 2**16))
@settings(max_examples=20)
def test_tables_joined_and_picked_keep_their_curves(tables: list[NurbsTable], seed: int) -> None:
    both = nurbs.concatenate(tables)
    nurbs.check(both)
    order = np.random.default_rng(seed).integers(0, len(tables), 6)
    picked = nurbs.take(both, order)
    nurbs.check(picked)
    for place, c in enumerate(order):
        u = np.linspace(tables[c].knots[0], tables[c].knots[-1], 7)
        np.testing.assert_array_equal(nurbs.evaluate(picked, place, u, 2), nurbs.evaluate(tables[c], 0, u, 2))


def test_length_of_the_butterfly() -> None:
    """382.856583 mm, by scipy.integrate.quad over each span (and printed so in the literature's data)."""
    from scipy.integrate import quad

    table = program_curve("butterfly")
    spans = np.unique(table.knots)

    def speed(u: float) -> float:
        return float(np.linalg.norm(reference(table, np.array([u]), 1)[1]))

    pieces = [
        quad(speed, a, b, epsabs=1e-11, epsrel=1e-13, limit=200)[0] for a, b in itertools.pairwise(spans)
    ]
    total = nurbs.lengths(table).total[0]
    assert total == pytest.approx(sum(pieces), abs=1e-9)
    assert total == pytest.approx(382.856583, abs=1e-6)


@given(curves(max_degree=5), st.sampled_from([25.4, 1e-3, 1e3 / 7.0]))
def test_panels_of_a_larger_copy_are_those_of_the_curve(table: NurbsTable, scale: float) -> None:
    """A plan's nodes hang on panels: cells, as short as rounding allows, may differ."""
    found = []
    for size in (1.0, scale):
        copy = nurbs.single(int(table.degree[0]), table.knots, size * table.control_points, table.weights)
        measured = nurbs.lengths(copy)
        begins = measured.begins & arc_length.PANEL != 0
        found.append(measured.cells[begins, :2] / [1.0, size])
    np.testing.assert_allclose(found[0], found[1], rtol=0.0, atol=1e-9)


@given(curves(max_degree=5))
def test_panels_of_the_reverse_are_those_of_the_curve(table: NurbsTable) -> None:
    """A plan's nodes hang on panels, and times of a path and of its reverse on the nodes."""
    # Binary fractions, whose differences are exact.
    knots = np.round(table.knots * 1024.0) / 1024.0
    degree = int(table.degree[0])
    curve = nurbs.single(degree, knots, table.control_points, table.weights)
    back = nurbs.single(degree, knots[-1] - knots[::-1], table.control_points[::-1], table.weights[::-1])
    found = []
    for each in (curve, back):
        measured = nurbs.lengths(each)
        begins = measured.begins & arc_length.PANEL != 0
        found.append(np.append(measured.cells[begins, 0], knots[-1]))
    np.testing.assert_allclose(found[0], knots[-1] - found[1][::-1], rtol=0.0, atol=1e-9)


def test_panels_carry_the_speed_as_a_polynomial_of_degree_four() -> None:
    """|C'| between the nodes of a panel, by the recurrence, against the polynomial through five of its values."""
    table = program_curve("butterfly")
    measured = nurbs.lengths(table)
    at = np.flatnonzero(measured.begins & arc_length.PANEL)
    u = measured.cells[at, 0]
    ends = np.append(u[1:], table.knots[-1])
    x = np.polynomial.chebyshev.chebpts1(5)
    look = np.linspace(-0.95, 0.95, 9)
    worst = []
    for a, b in zip(u, ends, strict=True):
        places = np.concatenate([x, look]) * 0.5 * (b - a) + 0.5 * (a + b)
        speed = np.linalg.norm(nurbs.evaluate(table, 0, places, 1)[1], axis=1)
        through = np.polynomial.Polynomial.fit(x, speed[:5], 4)
        worst.append(np.abs(through(look) - speed[5:]).max() / speed.mean())
    assert 1e-9 < max(worst) < 1e-7
    assert len(at) < len(measured.cells)


@given(curves(max_degree=5), st.integers(0, 1000))
def test_parameter_at_a_length_gives_that_length(table: NurbsTable, seed: int) -> None:
    measured = nurbs.lengths(table)
    s = np.sort(np.random.default_rng(seed).uniform(0, measured.total[0], 50))
    curve = np.zeros(len(s), np.int64)
    u = measured.parameter(curve, s)
    assert np.all(np.diff(u) >= 0)
    np.testing.assert_allclose(measured.at(curve, u), s, atol=1e-9)


def test_kernels_run_uncompiled_alike() -> None:
    table = program_curve("star")
    low, high = np.array([0]), np.array([3])
    results = []
    plain = uncompiled("bspline"), uncompiled("arc_length")
    for bsplines, lengths in ((bspline, arc_length), plain):
        curves = nurbs.columns(table)
        offset, cells = np.zeros(2, np.int64), np.zeros((2000, lengths.CELL_COLUMNS))
        begins = np.zeros(2000, np.int8)
        assert lengths.cells(0, 1e-8, low, high, curves, offset, cells, begins) == 1
        s = np.linspace(0, 200, 30)
        curve = np.zeros(30, np.int64)
        u, back, out = np.zeros(30), np.zeros(30), np.zeros((4, 30, 3))
        lengths.invert(curve, s, 1, 1e-12, offset, cells, u)
        lengths.lengths(curve, u, low, high, curves, offset, cells, back)
        bsplines.evaluate(curve, u, -1, 3, curves, out)
        results.append((offset, cells[: offset[1]], begins, u, back, out))
    for ours, theirs in zip(*results, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9)
