"""Matrix exponential, its balancing, and holds, beside scipy's."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm, matrix_balance
from scipy.signal import cont2discrete

from cncgen.servo.discretise import _balanced, exponential, held, ramped


@given(st.integers(1, 6), st.integers(0, 10**6), st.floats(-3, 3))
def test_exponential_is_scipys(order, seed, size):
    matrix = np.random.default_rng(seed).normal(size=(order, order)) * 10.0**size / order
    matrix -= np.eye(order) * max(np.linalg.eigvals(matrix).real.max(), 0.0)
    expected = expm(matrix)
    assert exponential(matrix) == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


def test_exponential_of_a_companion_form_with_coefficients_far_apart():
    """Four poles near 200/s: the last row of the companion form is 1e9, and balancing must keep the digits."""
    poles = np.array([-197.0 + 160.0j, -197.0 - 160.0j, -75.0, -500.0])
    a = np.eye(4, k=1)
    a[-1] = -np.poly(poles)[:0:-1].real
    result = exponential(a * 1e-3)
    assert np.sort(np.linalg.eigvals(result)) == pytest.approx(np.sort(np.exp(poles * 1e-3)), rel=1e-10)


@pytest.mark.parametrize(("hold", "ours"), [("zoh", held), ("foh", ramped)])
def test_holds_are_scipys(hold, ours):
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(4, 4)) * 30 - 40 * np.eye(4), rng.normal(size=(4, 2))
    expected = cont2discrete((a, b, np.eye(4), np.zeros((4, 2))), 0.01, hold)
    if hold == "zoh":
        phi, gamma = ours(a, b, 0.01)
        assert gamma == pytest.approx(expected[1], rel=1e-10)
    else:
        # scipy moves half of the ramp into its states: x' = x - Γ1 u, so B' = Γ0 + Φ Γ1 and D' = C Γ1.
        phi, start, end = ours(a, b, 0.01)
        assert start + phi @ end == pytest.approx(expected[1], rel=1e-10)
        assert end == pytest.approx(expected[3], rel=1e-10)
    assert phi == pytest.approx(expected[0], rel=1e-10)


@given(st.integers(2, 7), st.integers(0, 10**6))
def test_balancing_is_exact_and_as_good_as_scipys(order, seed):
    """D⁻¹ M D to the bit, D of powers of two; its norm within twice that of LAPACK's balancing, rows and columns alike."""
    rng = np.random.default_rng(seed)
    matrix = (
        rng.normal(size=(order, order))
        * 10.0 ** rng.uniform(-8, 8, (order, 1))
        / 10.0 ** rng.uniform(-8, 8, order)
    )
    balanced, scale = _balanced(matrix)
    assert (np.frexp(scale)[0] == 0.5).all()
    assert (scale[:, None] * balanced / scale == matrix).all()
    reference = matrix_balance(matrix, permute=False)[0]
    assert np.linalg.norm(balanced, 1) <= 2.0 * np.linalg.norm(reference, 1)
    off = np.abs(balanced) - np.diag(np.abs(np.diag(balanced)))
    ratio = off.sum(axis=0) / off.sum(axis=1)
    assert ((ratio > 0.45) & (ratio < 2.2)).all()


def test_balancing_leaves_a_state_that_nothing_couples_to():
    """A row or a column of zeros has no size to be brought to; the others are balanced all the same."""
    matrix = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 1e8], [1.0, 1e-8, 3.0]])
    balanced, scale = _balanced(matrix)
    assert scale[0] == 1.0
    assert abs(math.log2(balanced[1, 2] / balanced[2, 1])) <= 2.0
