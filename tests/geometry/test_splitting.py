"""Curves cut at parameters keep their shape."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.geometry import nurbs
from cncgen.geometry.splitting import split


@given(st.integers(0, 2**32 - 1), st.integers(1, 5), st.integers(1, 3))
def test_the_parts_are_the_curve(seed: int, degree: int, cuts: int) -> None:
    rng = np.random.default_rng(seed)
    count = degree + 1 + int(rng.integers(0, 6))
    inner = np.sort(rng.choice([0.25, 0.5, 0.75, *rng.uniform(0, 1, 4)], count - degree - 1))
    # A knot may be there up to full multiplicity.
    keep = np.ones(len(inner), bool)
    for k in range(degree, len(inner)):
        keep[k] = inner[k] != inner[k - degree]
    inner = inner[keep]
    count = degree + 1 + len(inner)
    knots = np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])
    table = nurbs.single(degree, knots, rng.normal(size=(count, 3)), rng.uniform(0.5, 2.0, count))
    at = np.sort(rng.choice([0.1, 0.25, 0.5, 0.75, 0.9], cuts, replace=False))
    parts = split(table, 0, at)
    nurbs.check(parts)
    assert len(parts) == cuts + 1
    bounds = np.concatenate([[0.0], at, [1.0]])
    np.testing.assert_allclose(np.stack(nurbs.parameter_range(parts)), [bounds[:-1], bounds[1:]])
    for k in range(cuts + 1):
        u = np.linspace(bounds[k], bounds[k + 1], 20)[1:-1]
        whole, part = nurbs.evaluate(table, 0, u, 2), nurbs.evaluate(parts, k, u, 2)
        np.testing.assert_allclose(part, whole, rtol=1e-8, atol=1e-8 * (1 + np.abs(whole).max()))


def test_unclamped_ends_stay_as_they_are() -> None:
    table = nurbs.single(2, np.arange(8.0), np.random.default_rng(1).normal(size=(5, 2)))
    parts = split(table, 0, np.array([3.5]))
    u = np.linspace(2.0, 5.0, 31)
    which = (u > 3.5).astype(int)
    assert nurbs.evaluate(parts, which, u)[0] == pytest.approx(nurbs.evaluate(table, 0, u)[0], abs=1e-12)
