"""Curves that are hard on digits: light and heavy weights, short spans, high degrees, knots of any multiplicity.

Derivatives are held against exact rational arithmetic, lengths against a quadrature of a speed that is computed without
a difference of alike numbers, and against a straight line.
"""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest

from cncgen.geometry import nurbs
from cncgen.geometry.tables import NurbsTable

BINOMIALS = ((1,), (1, 1), (1, 2, 1), (1, 3, 3, 1))


def random_curve(rng: np.random.Generator, knots: str, decades: float) -> NurbsTable:
    """A curve of 100 mm and degree 1 to 9 whose weights span that many decades either side of 1."""
    degree = int(rng.integers(1, 10))
    count = degree + 1 + int(rng.integers(0, 8))
    inner = count - degree - 1
    if knots == "short spans":
        within = np.cumsum(10.0 ** rng.uniform(-9, 0, inner + 1))
        within = within[:inner] / within[-1]
    else:
        within = np.sort(np.repeat(rng.uniform(0.0, 1.0, inner), rng.integers(1, degree + 1, inner))[:inner])
    return nurbs.single(
        degree,
        np.concatenate([np.zeros(degree + 1), within, np.ones(degree + 1)]),
        rng.normal(size=(count, 3)) * 50.0 + 1000.0,
        10.0 ** rng.uniform(-decades, decades, count),
    )


def exact(table: NurbsTable, u: float, side: int) -> list[list[float]]:
    """Position and three derivatives in rational arithmetic: de Boor's algorithm on the points of each derivative
    (The NURBS Book, eq. 3.8), then Leibniz' rule (eq. 4.8)."""
    degree, at = int(table.degree[0]), Fraction(u)
    knots = [Fraction(knot) for knot in table.knots.tolist()]
    spans = [i for i in range(degree, len(knots) - degree - 1) if knots[i] < knots[i + 1]]
    i = max([k for k in spans if knots[k] < at or (side > 0 and knots[k] == at)], default=spans[0])
    points = [
        [Fraction(w) * Fraction(x) for x in (*point, 1.0)]
        for point, w in zip(
            table.control_points[i - degree : i + 1].tolist(),
            table.weights[i - degree : i + 1].tolist(),
            strict=True,
        )
    ]
    above: list[list[Fraction]] = []
    for p in range(degree, degree - 4, -1):
        if p < 0:
            above.append([Fraction(0)] * 4)
            continue
        row = points
        for r in range(1, p + 1):
            shares = [
                (at - knots[i - p + j]) / (knots[i + 1 + j - r] - knots[i - p + j]) for j in range(r, p + 1)
            ]
            row = [
                [(1 - a) * x + a * y for x, y in zip(*pair, strict=True)]
                for a, pair in zip(shares, itertools.pairwise(row), strict=True)
            ]
        above.append(row[0])
        points = [
            [p * (y - x) / (knots[i + 1 + j] - knots[i + 1 + j - p]) for x, y in zip(*pair, strict=True)]
            for j, pair in enumerate(itertools.pairwise(points))
        ]
    found: list[list[Fraction]] = []
    for k in range(4):
        value = above[k][:3]
        for n in range(1, k + 1):
            share = BINOMIALS[k][n] * above[n][3]
            value = [a - share * b for a, b in zip(value, found[k - n], strict=True)]
        found.append([a / above[0][3] for a in value])
    return [[float(x) for x in value] for value in found]


@pytest.mark.parametrize(("decades", "closeness"), [(0.5, 2e-14), (3.0, 1e-12)])
@pytest.mark.parametrize("knots", ["short spans", "multiple"])
def test_derivatives_keep_their_digits(decades: float, closeness: float, knots: str) -> None:
    """Where a curve meets a point of a millionth of its neighbour's weight, a derivative has a millionth of the digits: heavy
    weights are tried between knots."""
    rng = np.random.default_rng(5)
    for _ in range(15):
        table = random_curve(rng, knots, decades)
        places = [*rng.uniform(0.0, 1.0, 2).tolist(), float(rng.choice(table.knots))][
            : 3 if decades < 1 else 2
        ]
        for side in (1, -1):
            ours = nurbs.evaluate(table, 0, places, 3, side)
            for n, u in enumerate(places):
                for k, value in enumerate(exact(table, u, side)):
                    size = np.abs(table.control_points).max() if k == 0 else np.abs(value).max()
                    assert np.abs(ours[k, n] - value).max() <= closeness * size


def speed(table: NurbsTable, i: int, u: np.ndarray) -> np.ndarray:
    """|C'| on span i: C' = p w0 w1 (P1 - P0)/(w² ΔU) of the last two rational de Boor points, whose difference is a sum of
    differences of control points with positive shares (M. S. Floater, CAGD 9 (1992) 161, for Bézier curves)."""
    p, knots = int(table.degree[0]), table.knots
    w = [np.full_like(u, weight) for weight in table.weights[i - p : i + 1]]
    steps = list(np.diff(table.control_points[i - p : i + 1], axis=0)[:, None, :])
    for r in range(1, p):
        low = [knots[i - p + r + j] for j in range(p + 1 - r)]
        high = [knots[i + 1 + j] for j in range(p + 1 - r)]
        left = [(b - u) * w[j] for j, b in enumerate(high)]
        right = [(u - a) * w[j + 1] for j, a in enumerate(low)]
        total = [a + b for a, b in zip(left, right, strict=True)]
        steps = [
            (left[j] / total[j])[:, None] * steps[j] + (right[j + 1] / total[j + 1])[:, None] * steps[j + 1]
            for j in range(p - r)
        ]
        w = [total[j] / (high[j] - low[j]) for j in range(p + 1 - r)]
    width = knots[i + 1] - knots[i]
    weight = ((knots[i + 1] - u) * w[0] + (u - knots[i]) * w[1]) / width
    return p * w[0] * w[1] / weight**2 / width * np.linalg.norm(steps[0], axis=1)


def length(table: NurbsTable, end: float) -> float:
    """Length up to a parameter: halves until a Gauss rule of 16 points agrees with itself."""
    nodes, weights = np.polynomial.legendre.leggauss(16)
    size = np.ptp(table.control_points, axis=0).max()
    degree, total = int(table.degree[0]), 0.0

    def rule(i: int, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        u = 0.5 * (a + b)[:, None] + 0.5 * (b - a)[:, None] * nodes
        return speed(table, i, u.ravel()).reshape(u.shape) @ weights * 0.5 * (b - a)

    for i in range(degree, len(table.knots) - degree - 1):
        a, b = table.knots[i : i + 1], np.minimum(table.knots[i + 1 : i + 2], end)
        a, b = a[a < b], b[a < b]
        for _ in range(50):
            middle = 0.5 * (a + b)
            halves = rule(i, a, middle) + rule(i, middle, b)
            rough = np.abs(halves - rule(i, a, b)) > 1e-14 * size + 1e-13 * halves
            total += halves[~rough].sum()
            a, b = np.concatenate([a[rough], middle[rough]]), np.concatenate([middle[rough], b[rough]])
            if not len(a):
                break
    return total


@pytest.mark.parametrize("knots", ["short spans", "multiple"])
def test_lengths_are_right_to_1e_12_of_the_size(knots: str) -> None:
    """The table's parameter is held to 2e-13 and rounding (docs/arc-length.md)."""
    rng = np.random.default_rng(8)
    for _ in range(5):
        table = random_curve(rng, knots, 0.7)
        size = np.ptp(table.control_points, axis=0).max()
        measured = nurbs.lengths(table)
        assert measured.total[0] == pytest.approx(length(table, 1.0), rel=0.0, abs=1e-12 * size)
        u = float(rng.uniform(0.0, 1.0))
        s = measured.at(np.zeros(1, np.int64), np.array([u]))
        assert s[0] == pytest.approx(length(table, u), rel=0.0, abs=1e-12 * size)


@pytest.mark.parametrize("degree", [1, 3, 9])
def test_ten_thousand_points_on_a_line(degree: int) -> None:
    """Whatever its weights a curve whose control points go on along a line is the line: s is the way from its start."""
    rng = np.random.default_rng(degree)
    count = 10_000
    at = np.concatenate([[0.0], np.cumsum(rng.uniform(0.0, 0.2, count - 1))])
    direction = np.array([2.0, -1.0, 2.0]) / 3.0
    inner = np.sort(rng.uniform(0.0, 1.0, count - degree - 1))
    knots = np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])
    table = nurbs.single(degree, knots, at[:, None] * direction, 10.0 ** rng.uniform(-1.0, 1.0, count))
    measured = nurbs.lengths(table)
    assert measured.total[0] == pytest.approx(at[-1], rel=1e-13)
    s = np.sort(rng.uniform(0.0, at[-1], 1000))
    u = measured.parameter(np.zeros(1000, np.int64), s)
    np.testing.assert_allclose(nurbs.evaluate(table, 0, u)[0] @ direction, s, rtol=0.0, atol=1e-12 * at[-1])
