"""How far curves reach: closed forms, and points laid along them very densely."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.geometry import nurbs
from cncgen.geometry.arcs import Spirals, spirals
from cncgen.geometry.extents import arc_extents, hulls, nurbs_extents
from cncgen.geometry.tables import ArcTable

#: A full turn laid out in this many steps misses an extremum by r (π/n)²/2 at most.
STEPS = 20_001


def arc(
    centre: list[float], normal: list[float], sweep: float, start: list[float], end: list[float]
) -> Spirals:
    """One arc with its points."""
    table = ArcTable(np.array([centre], float), np.array([normal], float), np.array([sweep]))
    return spirals(table, np.array([start], float), np.array([end], float))


def test_the_top_of_a_half_circle() -> None:
    """From (−5, 0) clockwise to (5, 0): the top is at y = 5, the ends are the lowest."""
    low, high = arc_extents(arc([0, 0, 0], [0, 0, -1], np.pi, [-5, 0, 0], [5, 0, 0]))
    np.testing.assert_allclose(low, [[-5, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(high, [[5, 5, 0]], atol=1e-12)


def test_a_quarter_has_no_extrema_but_its_ends() -> None:
    low, high = arc_extents(arc([0, 0, 0], [0, 0, 1], np.pi / 2, [5, 0, 0], [0, 5, 0]))
    np.testing.assert_allclose(low, [[0, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(high, [[5, 5, 0]], atol=1e-12)


def test_a_leaning_helix_of_several_turns() -> None:
    """About n = (1, 0, 1)/√2 a coordinate both turns and rises; x' = 0 in closed form, against dense points."""
    n = np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0)
    start = np.array([0.0, 4.0, 0.0])
    sweep = 5.3 * np.pi
    c, s = np.cos(sweep), np.sin(sweep)
    end = start * c + np.cross(n, start) * s + 7.0 * n
    one = arc([0, 0, 0], list(n), sweep, list(start), list(end))
    low, high = arc_extents(one)
    angle = np.linspace(0.0, sweep, STEPS)
    dense = one.evaluate(np.zeros(STEPS, np.int64), angle, 0)[0]
    np.testing.assert_allclose(low[0], dense.min(axis=0), atol=1e-6)
    np.testing.assert_allclose(high[0], dense.max(axis=0), atol=1e-6)
    assert (low[0] <= dense.min(axis=0) + 1e-12).all()
    assert (high[0] >= dense.max(axis=0) - 1e-12).all()


@given(
    st.floats(0.1, 20.0),
    st.floats(-3.0, 3.0),
    st.floats(0.1, 20.0),
    st.floats(-5.0, 5.0),
    st.floats(-0.05, 0.05),
)
def test_arcs_against_dense_points(
    radius: float, phase: float, sweep: float, rise: float, growth: float
) -> None:
    """Radii that differ by a little, any start, up to three turns."""
    last = radius * (1.0 + growth)
    start = [radius * np.cos(phase), radius * np.sin(phase), 0.0]
    end = [last * np.cos(phase + sweep), last * np.sin(phase + sweep), rise]
    one = arc([0, 0, 0], [0, 0, 1], sweep, start, end)
    low, high = arc_extents(one)
    dense = one.evaluate(np.zeros(STEPS, np.int64), np.linspace(0.0, sweep, STEPS), 0)[0]
    slack = radius * (sweep / STEPS) ** 2
    assert (low[0] <= dense.min(axis=0) + 1e-12).all()
    assert (high[0] >= dense.max(axis=0) - 1e-12).all()
    assert (low[0] >= dense.min(axis=0) - slack - 1e-12).all()
    assert (high[0] <= dense.max(axis=0) + slack + 1e-12).all()


@given(st.integers(0, 10**6), st.floats(0.1, 20.0), st.floats(-1.5, 1.5))
def test_helices_about_any_axis_against_dense_points(seed: int, sweep: float, rise: float) -> None:
    """A coordinate that turns as fast as it rises stands still nowhere or for long; ends and tops are found all the same."""
    steps, rng = 4001, np.random.default_rng(seed)
    n, start = rng.normal(size=(2, 3))
    n /= np.linalg.norm(n)
    start -= (start @ n) * n
    # Rise a radian in parts of the radius: below 1 some coordinates turn back, above 1 none of them need.
    whole = rise * np.linalg.norm(start) * sweep
    end = start * np.cos(sweep) + np.cross(n, start) * np.sin(sweep) + whole * n
    one = arc([0, 0, 0], list(n), sweep, list(start), list(end))
    low, high = arc_extents(one)
    dense = one.evaluate(np.zeros(steps, np.int64), np.linspace(0.0, sweep, steps), 0)[0]
    slack = np.linalg.norm(start) * (sweep / steps) ** 2 + 1e-12
    assert (low[0] <= dense.min(axis=0) + 1e-12).all()
    assert (high[0] >= dense.max(axis=0) - 1e-12).all()
    np.testing.assert_allclose(low[0], dense.min(axis=0), rtol=0.0, atol=slack)
    np.testing.assert_allclose(high[0], dense.max(axis=0), rtol=0.0, atol=slack)


def test_the_top_of_a_parabola_and_of_a_rational_half_circle() -> None:
    """Bézier (0,0) (1,2) (2,0): y = 4t(1 − t), its top is 1. A rational half circle of radius 1 reaches 1."""
    parabola = nurbs.single(2, [0, 0, 0, 1, 1, 1], [[0, 0, 0], [1, 2, 0], [2, 0, 0]])
    low, high = nurbs_extents(parabola, 0)
    np.testing.assert_allclose(low, [0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(high, [2, 1, 0], atol=1e-12)
    w = np.sqrt(0.5)
    circle = nurbs.single(
        2,
        [0, 0, 0, 1, 1, 2, 2, 2],
        [[1, 0, 0], [1, 1, 0], [0, 1, 0], [-1, 1, 0], [-1, 0, 0]],
        [1, w, 1, w, 1],
    )
    turned = np.array([[np.cos(0.3), np.sin(0.3), 0], [-np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]])
    both = nurbs.concatenate(
        [circle, nurbs.single(2, circle.knots, circle.control_points @ turned, circle.weights)]
    )
    np.testing.assert_allclose(nurbs_extents(both, 0)[1], [1, 1, 0], atol=1e-11)
    np.testing.assert_allclose(nurbs_extents(both, 1)[1][1], 1.0, atol=1e-11)
    assert hulls(both)[1][1, 1] > 1.2


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_random_curves_against_dense_points(degree: int) -> None:
    rng = np.random.default_rng(degree)
    n = degree + 7
    inner = np.sort(rng.choice(np.repeat(np.arange(1, 9), degree), 6, replace=False))  # some twice or more
    knots = np.concatenate([np.zeros(degree + 1), inner, np.full(degree + 1, 9.0)])
    table = nurbs.single(degree, knots, rng.normal(size=(n, 4)) * 10, rng.uniform(0.3, 3.0, n))
    low, high = nurbs_extents(table, 0)
    u = np.concatenate([np.linspace(0.0, 9.0, STEPS), inner])
    dense = nurbs.evaluate(table, 0, u)[0]
    assert (low <= dense.min(axis=0) + 1e-9).all()
    assert (high >= dense.max(axis=0) - 1e-9).all()
    np.testing.assert_allclose(low, dense.min(axis=0), atol=1e-4)
    np.testing.assert_allclose(high, dense.max(axis=0), atol=1e-4)
