"""Exact profile pieces against numerical integration, their inverse, and compiled against plain Python."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cncgen.kernels import profile
from tests.kernels.plain import uncompiled

RNG = np.random.default_rng(3)


def one(tau: float, v: float, a: float, j: float, c: float, kernel: ModuleType = profile) -> np.ndarray:
    """Evaluate one piece that begins at t = 0, s = 0 after τ: s, s', s'', s'''."""
    state = np.zeros((1, 4))
    columns = [np.array([x]) for x in (v, a, j, c)]
    kernel.evaluate(
        np.array([tau]), np.array([0.0, tau]), np.array([0.0, np.inf]), *columns, state, np.zeros(1, np.int64)
    )
    return state[0]


@pytest.mark.parametrize("c", [0.0, 1e-12, -1e-12, 24.9, 25.1, -24.9, -25.1, 4e3, -4e3])
def test_piece_is_the_solution_of_its_equation(c: float) -> None:
    """s''' = j + c s' integrated to tight tolerance; 25 τ² = 1/4 is where series and closed form meet."""
    tau, v, a, j = 0.1, 40.0, 300.0, -2e3
    exact = solve_ivp(
        lambda _, y: [y[1], y[2], j + c * y[1]], (0.0, tau), [0.0, v, a], rtol=1e-13, atol=1e-13
    ).y[:, -1]
    found = one(tau, v, a, j, c)
    np.testing.assert_allclose(found[:3], exact, rtol=1e-9)
    assert found[3] == pytest.approx(j + c * found[1], rel=1e-12)


def test_constant_jerk_is_the_cubic() -> None:
    """With c = 0 the distance is vτ + aτ²/2 + jτ³/6, to the last digits."""
    found = one(0.5, 3.0, 5.0, 7.0, 0.0)
    np.testing.assert_allclose(found, [1.5 + 0.625 + 7.0 / 48.0, 3 + 2.5 + 0.875, 8.5, 7.0], rtol=1e-15)


def chained(n: int = 60) -> tuple[np.ndarray, ...]:
    """Return t, s, v, a, j, c of pieces of every kind, s continuous."""
    tau = RNG.uniform(1e-3, 0.05, n)
    v, a = RNG.uniform(1.0, 100.0, n), RNG.uniform(-10.0, 500.0, n)
    j, c = RNG.uniform(0.0, 5e4, n), RNG.choice([0.0, 1e-9, 50.0, -50.0, 4e3], n)
    v[7], a[7], j[7], c[7] = 0.0, 0.0, 0.0, 0.0
    s = np.concatenate([[0.0], np.cumsum([one(*piece)[0] for piece in zip(tau, v, a, j, c, strict=True)])])
    return np.concatenate([[0.0], np.cumsum(tau)]), s, v, a, j, c


def test_inverse_returns_the_times() -> None:
    """`invert` finds the time of every place; at the wait (piece 7) it finds the wait's end."""
    t, s, v, a, j, c = chained()
    at = np.sort(RNG.uniform(0.0, t[-1], 2000))
    state, piece = np.zeros((len(at), 4)), np.zeros(len(at), np.int64)
    profile.evaluate(at, t, s, v, a, j, c, state, piece)
    time = np.zeros(len(at))
    profile.invert(np.ascontiguousarray(state[:, 0]), t, s, v, a, j, c, np.zeros(4), time)
    moving = piece != 7
    np.testing.assert_allclose(time[moving], at[moving], atol=1e-12)
    assert np.all(time[~moving] == t[8])


def test_ends_are_kept() -> None:
    """A time outside is moved to the nearest end, and no place lies beyond its piece's end."""
    t, s, v, a, j, c = chained(20)
    state, piece = np.zeros((4, 4)), np.zeros(4, np.int64)
    profile.evaluate(np.array([-1.0, 0.0, t[-1], t[-1] + 1.0]), t, s, v, a, j, c, state, piece)
    assert state[:2, 0].tolist() == [0.0, 0.0]
    np.testing.assert_allclose(state[2:, 0], s[-1], rtol=1e-15)
    assert (state[:, 0] <= s[-1]).all()
    assert piece.tolist() == [0, 0, 19, 19]


def test_places_outside_are_at_the_ends() -> None:
    """A place before the start or beyond the end, by rounding, is left at the first and the last time."""
    t, s, v, a, j, c = chained(9)
    time = np.zeros(4)
    profile.invert(np.array([s[0] - 1e-9, s[0], s[-1], s[-1] + 1e-9]), t, s, v, a, j, c, np.zeros(4), time)
    assert time == pytest.approx([0.0, 0.0, t[-1], t[-1]], abs=1e-12)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    st.floats(0.0, 0.1),
    st.floats(0.0, 200.0),
    st.floats(-2e3, 2e3),
    st.floats(-5e4, 5e4),
    st.floats(-5e3, 5e3),
)
def test_compiled_and_plain_agree(tau: float, v: float, a: float, j: float, c: float) -> None:
    """The same source compiled and interpreted gives the same numbers."""
    np.testing.assert_allclose(one(tau, v, a, j, c), one(tau, v, a, j, c, PLAIN), rtol=1e-13, atol=1e-12)


PLAIN = uncompiled("profile")
