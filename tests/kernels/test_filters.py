"""The recursive filter against scipy's, in one go and in parts, compiled and as plain Python."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from cncgen.kernels import filters
from tests.kernels.plain import uncompiled

RNG = np.random.default_rng(5)


@pytest.mark.parametrize("order", [0, 1, 4])
def test_filter_is_scipys(order: int) -> None:
    """Σ a y = Σ b x with stable poles, against `scipy.signal.lfilter`."""
    b = RNG.normal(size=order + 1)
    a = np.poly(RNG.uniform(-0.9, 0.9, order)) if order else np.ones(1)
    x = RNG.normal(size=500)
    y, state = np.zeros(500), np.zeros(order)
    filters.recursive(b, a, x, y, state)
    np.testing.assert_allclose(y, lfilter(b, a, x), rtol=1e-10, atol=1e-10)


def test_parts_go_on_where_the_last_one_ended() -> None:
    """Two halves with one state are the whole, to the bit; plain Python gives the same."""
    b, a = np.array([0.2, 0.1, 0.3]), np.array([1.0, -1.2, 0.5])
    x = RNG.normal(size=100)
    whole, halves, plain = np.zeros(100), np.zeros(100), np.zeros(100)
    filters.recursive(b, a, x, whole, np.zeros(2))
    state = np.zeros(2)
    filters.recursive(b, a, x[:37], halves[:37], state)
    filters.recursive(b, a, x[37:], halves[37:], state)
    assert (halves == whole).all()
    uncompiled("filters").recursive(b, a, x, plain, np.zeros(2))
    np.testing.assert_allclose(plain, whole, rtol=1e-14)


def test_a_filter_may_write_over_what_it_reads() -> None:
    x = np.random.default_rng(4).normal(size=50)
    b, a = np.array([1.0, 0.0, 0.0]), np.array([1.0, -0.7, 0.2])
    expected = lfilter(b, a, x)
    filters.recursive(b, a, x, x, np.zeros(2))
    np.testing.assert_allclose(x, expected, rtol=1e-13)
