"""Sensitivities against closed forms: Ishigami's function, a linear function, a product."""

from __future__ import annotations

import numpy as np
import pytest

from cncgen.report.swept import Share, shares_text
from cncgen.sweep.designs import DESIGNS, design_size, unit_points
from cncgen.sweep.ranking import pareto_front, ranked
from cncgen.sweep.sensitivities import sensitivities

A, B = 7.0, 0.1
PI4 = np.pi**4
#: Variance of Ishigami's function and shares of it: Saltelli, Chan and Scott, Sensitivity Analysis (2000), table 2.2 for a = 7 and
#: b = 0.1; closed form in Sudret 2008, eqs 49 and 50.
VARIANCE = A**2 / 8 + B * PI4 / 5 + B**2 * PI4**2 / 18 + 0.5
ONE, TWO = 0.5 * (1 + B * PI4 / 5) ** 2 / VARIANCE, A**2 / 8 / VARIANCE
WITH_THREE = 8 * B**2 * PI4**2 / 225 / VARIANCE


def ishigami(u: np.ndarray) -> np.ndarray:
    """Return sin x1 + a sin² x2 + b x3⁴ sin x1 with x uniform from −π to π, shape (n,), of u uniform from 0 to 1, (n, 3)."""
    x1, x2, x3 = (np.pi * (2.0 * u - 1.0)).T
    return np.sin(x1) + A * np.sin(x2) ** 2 + B * x3**4 * np.sin(x1)


@pytest.mark.parametrize(
    ("design", "points", "tolerance"),
    [
        ("sobol", 1024, 1e-4),
        ("latin_hypercube", 1024, 1e-3),
        # A quasi-Monte Carlo mean of 4096 points; Saltelli et al. 2010, figure 4, has errors of this size.
        ("saltelli", 4096, 0.01),
        # Midpoints of 40 parts: the mean of x⁴ is short by (π/40)²·… ≈ 0.2 %, its square by twice that.
        ("grid", 0, 0.004),
    ],
)
def test_ishigami(design: str, points: int, tolerance: float) -> None:
    grid = [tuple((k + 0.5) / 40 for k in range(40))] * 3
    u = unit_points(design, points, 1, grid)
    assert len(u) == design_size(design, points, grid)
    found = sensitivities(design, u, [0, 0, 0], ["x1", "x2", "x3"], "y", ishigami(u))
    first = [share.first for share in found.shares]
    total = [share.total for share in found.shares]
    assert first == pytest.approx([ONE, TWO, 0.0], abs=tolerance)
    assert total == pytest.approx([ONE + WITH_THREE, TWO, WITH_THREE], abs=tolerance)
    assert found.rows == len(u)


def test_levels_of_lists_have_the_shares_of_their_variances() -> None:
    """y = a + b: shares are the variances of the levels, 2/3 of {-1, 0, 1} and 1 of {-1, 1}, over their sum."""
    u = unit_points("sobol", 256, 3, [(), ()])
    a = np.array([-1.0, 0.0, 1.0])[(u[:, 0] * 3).astype(int)]
    b = np.array([-1.0, 1.0])[(u[:, 1] * 2).astype(int)]
    found = sensitivities("sobol", u, [3, 2], ["a", "b"], "y", a + b)
    assert [share.total for share in found.shares] == pytest.approx([0.4, 0.6], abs=1e-9)
    assert found.explained == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("design", DESIGNS)
def test_failed_rows_are_left_out(design: str) -> None:
    """y = x1 + 2 x2 without every seventh row: shares 1/5 and 4/5 (variances of x and 2x)."""
    grid = [tuple((k + 0.5) / 16 for k in range(16))] * 2
    u = unit_points(design, 1024, 2, grid)
    y = u[:, 0] + 2.0 * u[:, 1]
    y[::7] = np.nan
    found = sensitivities(design, u, [0, 0], ["x1", "x2"], "y", y)
    assert [share.total for share in found.shares] == pytest.approx([0.2, 0.8], abs=0.05)
    assert found.rows < len(u)


@pytest.mark.parametrize("design", DESIGNS)
def test_what_does_not_vary_has_no_sensitivities(design: str) -> None:
    u = unit_points(design, 8, 1, [(0.25, 0.75)] * 2)
    found = sensitivities(design, u, [0, 0], ["a", "b"], "y", np.ones(len(u)))
    assert all(np.isnan(share.first) and np.isnan(share.total) for share in found.shares)


def test_more_points_of_a_sobol_sequence_begin_with_those_of_fewer() -> None:
    few, many = (unit_points("sobol", n, 5, [()] * 4) for n in (64, 256))
    assert (many[:64] == few).all()


def test_pareto_front_is_what_comparing_all_pairs_finds() -> None:
    random = np.random.default_rng(4)
    for _ in range(20):
        first, second = random.integers(0, 12, (2, 40)).astype(float)
        first[3] = np.nan
        beaten = [
            any(
                (first[j] <= first[i] and second[j] <= second[i])
                and (first[j] < first[i] or second[j] < second[i] or j < i)
                for j in range(40)
                if j != i
            )
            for i in range(40)
        ]
        expected = {i for i in range(40) if not beaten[i] and i != 3}
        found = pareto_front(first, second)
        assert set(found.tolist()) == expected
        assert (np.diff(first[found]) > 0).all()


def test_ranking_leaves_out_rows_without_a_figure() -> None:
    values = np.array([3.0, np.nan, 1.0, 2.0, 1.0])
    assert ranked(values).tolist() == [2, 4, 3, 0]
    assert ranked(values, largest=True).tolist() == [0, 3, 2, 4]


def test_an_expansion_that_predicts_nothing_gives_no_shares() -> None:
    """Noise alone: left out, each row is predicted worse than by the mean of the others."""
    shares = [Share("a", 0.99, 0.99), Share("b", 0.01, 0.01)]
    said = shares_text("error_mm", "expansion of degree 1", 16, -0.375, shares)
    assert (
        said
        == "error_mm: an expansion of degree 1 on 16 rows predicts none of its variance: draw more points\n"
    )
    assert "0.9900" in shares_text("error_mm", "expansion of degree 1", 16, 0.375, shares)
