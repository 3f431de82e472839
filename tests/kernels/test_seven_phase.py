"""Look-ahead and profiles against a slow reference, the laws of motion, and compiled against plain Python."""

from __future__ import annotations

from math import exp
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from cncgen.kernels import seven_phase
from tests.kernels.plain import uncompiled

K = 1.0 / (1.0 - exp(-4.0))
BELL, LINEAR, EXPONENTIAL = 0, 1, 2


PLAIN = uncompiled("seven_phase")


def ramp(kind: int, v1: float, v2: float, acc: float, jerk: float) -> float:
    """Distance from v1 to v2 by integrating the speed of the ramp over time: slow and obvious."""
    low, delta, up = min(v1, v2), abs(v2 - v1), v2 > v1
    if delta == 0.0:
        return 0.0
    if kind == BELL:
        rise = min(acc / jerk, (delta / jerk) ** 0.5)
        total = 2.0 * rise if delta <= acc**2 / jerk else delta / acc + acc / jerk
        return 0.5 * (v1 + v2) * total  # the acceleration is symmetric in time
    if kind == LINEAR:
        return 0.5 * (v1 + v2) * delta / acc
    total = 4.0 * K * delta / acc
    start, sign = (low, 1.0) if up else (low + delta, -1.0)
    return quad(lambda t: start + sign * delta * K * (1.0 - exp(-4.0 * t / total)), 0.0, total)[0]


def reach(kind: int, low: float, length: float, acc: float, jerk: float, up: bool) -> float:
    """Highest speed that the length allows, by bisection over the distance."""
    a, b = low, low + 2.0 * (acc * length) ** 0.5 + acc * length + 1.0
    for _ in range(100):
        middle = 0.5 * (a + b)
        ends = (low, middle) if up else (middle, low)
        a, b = (middle, b) if ramp(kind, *ends, acc, jerk) <= length else (a, middle)
    return a


def passes(
    kind: int, length: np.ndarray, acc: np.ndarray, jerk: np.ndarray, cap: np.ndarray, start: float
) -> np.ndarray:
    """Look ahead as the docstring says, with the slow reach."""
    v = cap.copy()
    for i in range(len(length) - 1, -1, -1):
        v[i] = min(cap[i], reach(kind, v[i + 1], length[i], acc[i], jerk[i], up=False))
    v[0] = min(v[0], start)
    for i in range(len(length)):
        v[i + 1] = min(v[i + 1], reach(kind, v[i], length[i], acc[i], jerk[i], up=True))
    return v


segments = st.lists(
    st.tuples(st.floats(1e-6, 30.0), st.floats(100.0, 5e3), st.floats(1e4, 1e6), st.floats(0.0, 150.0)),
    min_size=1,
    max_size=8,
)


@pytest.mark.parametrize("kind", [BELL, LINEAR, EXPONENTIAL])
@settings(max_examples=25, deadline=None, derandomize=True)
@given(segments, st.floats(0.0, 50.0), st.sampled_from([0.0, 20.0, 150.0]))
def test_look_ahead_is_the_slow_one(
    kind: int, rows: list[tuple[float, ...]], start: float, end: float
) -> None:
    """Closed inverses of the ramps against bisection over integrated ramps; to rest or on to what follows."""
    length, acc, jerk, caps = (np.array(column) for column in zip(*rows, strict=True))
    cap = np.append(caps, end)
    v = np.zeros(len(cap))
    v[0] = start
    seven_phase.look_ahead(kind, length, acc, jerk, cap, v)
    np.testing.assert_allclose(v, passes(kind, length, acc, jerk, cap, start), rtol=1e-7, atol=1e-7)


def laid_out(
    kind: int, rows: list[tuple[float, ...]], kernel: ModuleType = seven_phase
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Look ahead from rest to rest and lay out the pieces; return pieces, offsets and joint speeds."""
    length, acc, jerk, caps = (np.array(column) for column in zip(*rows, strict=True))
    n = len(length)
    top = np.full(n, 160.0)
    cap = np.append(caps, 0.0)
    cap[0] = 0.0
    v = np.zeros(n + 1)
    kernel.look_ahead(kind, length, acc, jerk, cap, v)
    table, offset = np.zeros((7 * n, 7)), np.zeros(n + 1, np.int64)
    count = kernel.build(kind, length, acc, jerk, top, v, table, offset)
    return table[:count], offset, v


@pytest.mark.parametrize("kind", [BELL, LINEAR, EXPONENTIAL])
@settings(max_examples=30, deadline=None, derandomize=True)
@given(segments)
def test_profiles_obey_their_limits(kind: int, rows: list[tuple[float, ...]]) -> None:
    """Lengths add up; speed is continuous and within the joints' and the top; A and J hold; a = 0 at joints (bell)."""
    pieces, offset, v = laid_out(kind, rows)
    for i, (length, acc, jerk, _) in enumerate(rows):
        part = pieces[offset[i] : offset[i + 1]]
        assert part[:, 6].sum() == pytest.approx(length, rel=1e-9, abs=1e-12)
        speed = v[i]
        for tau, v0, a0, j0, c, _phase, _length in part:
            assert v0 == pytest.approx(speed, rel=1e-7, abs=1e-6)
            assert abs(a0) <= acc * (1 + 1e-9)
            assert v0 <= 160.0 * (1 + 1e-9)
            if c == 0.0:
                assert abs(j0) <= (jerk if kind == BELL else 0.0) * (1 + 1e-9)
                assert abs(a0 + j0 * tau) <= acc * (1 + 1e-6)
                speed = v0 + a0 * tau + 0.5 * j0 * tau**2
            else:
                # v = v0 + (a0/λ)(1 − e^(−λτ)), λ = √c
                speed = v0 + a0 / c**0.5 * (1.0 - exp(-(c**0.5) * tau))
        assert speed == pytest.approx(v[i + 1], rel=1e-6, abs=1e-5)


@pytest.mark.parametrize("kind", [BELL, LINEAR, EXPONENTIAL])
def test_each_piece_is_as_long_as_its_speed_takes_it(kind: int) -> None:
    """Lengths of pieces by integrating v'' = j + c v over each; over a whole ramp what is wrong in one could cancel."""
    pieces, _, _ = laid_out(kind, [(30.0, 2e3, 5e4, 80.0), (0.3, 900.0, 2e4, 5.0), (40.0, 2e3, 5e4, 90.0)])
    assert len(pieces) > 6
    for tau, v, a, j, c, _phase, length in pieces:
        exact = solve_ivp(
            lambda _, y, j=j, c=c: [y[1], y[2], j + c * y[1]], (0.0, tau), [0.0, v, a], rtol=1e-12, atol=1e-12
        )
        assert length == pytest.approx(exact.y[0, -1], rel=1e-9)


def test_a_slow_feed_is_kept_all_along() -> None:
    """At a top of 0.5 mm/s ramps of 2 √(F/J) either side, each F √(F/J) long: T = L/F + 2 √(F/J)."""
    top, jerk = 0.5, 5e4
    table, offset = np.zeros((7, 7)), np.zeros(2, np.int64)
    count = seven_phase.build(
        BELL, np.array([10.0]), np.array([2e3]), np.array([jerk]), np.array([top]), np.zeros(2), table, offset
    )
    assert table[:count, 0].sum() == pytest.approx(10.0 / top + 2.0 * (top / jerk) ** 0.5, rel=1e-12)
    assert table[:count, 6].sum() == pytest.approx(10.0, rel=1e-12)


def test_a_segment_too_short_for_its_own_ramp_is_passed_at_the_mean() -> None:
    """Joints that differ by rounding alone, on a length that no ramp fits into: one piece, of its length, at their mean."""
    v = np.array([50.0, 50.0 * (1.0 + 4e-16), 50.0])
    length = np.array([1e-15, 2.0])
    table, offset = np.zeros((14, 7)), np.zeros(3, np.int64)
    one = np.ones(2)
    seven_phase.build(BELL, length, 2e3 * one, 5e4 * one, 60.0 * one, v, table, offset)
    assert offset[1] == 1
    tau, speed, *rest, carried = table[0]
    assert (speed, rest) == (pytest.approx(50.0), [0.0] * 4)
    assert tau == pytest.approx(1e-15 / 50.0)
    assert carried == pytest.approx(1e-15)


def test_long_medium_short() -> None:
    """Closed forms: rest to rest over L with A²/J = 125: cruise; peak below the top; jerk alone."""
    acc, jerk, top = 2500.0, 5e4, 160.0
    one = lambda length: laid_out(BELL, [(length, acc, jerk, 0.0)])[0]  # noqa: E731
    long = one(100.0)
    assert len(long) == 7
    # T = L/F + F/A + A/J
    assert long[:, 0].sum() == pytest.approx(100.0 / top + top / acc + acc / jerk, rel=1e-12)
    medium = one(16.0)
    # v (v/A + A/J) = L: both ramps fill the length.
    peak = 0.5 * acc * (-acc / jerk + ((acc / jerk) ** 2 + 4.0 * 16.0 / acc) ** 0.5)
    assert medium[:, 1].max() == pytest.approx(peak, rel=1e-9)
    short = one(0.1)
    # Four phases of jerk: T = 4 (L/(2J))^(1/3)
    assert short[:, 0].sum() == pytest.approx(4.0 * (0.1 / (2.0 * jerk)) ** (1.0 / 3.0), rel=1e-9)
    assert set(short[:, 5]) <= {0.0, 2.0}


@pytest.mark.parametrize("kind", [BELL, LINEAR, EXPONENTIAL])
def test_compiled_and_plain_agree(kind: int) -> None:
    """The same source compiled and interpreted lays out the same pieces."""
    rows = [(10.0, 2e3, 5e4, 80.0), (1e-7, 2e3, 5e4, 80.0), (0.3, 500.0, 1e4, 5.0), (40.0, 2e3, 5e4, 90.0)]
    compiled, interpreted = laid_out(kind, rows), laid_out(kind, rows, PLAIN)
    for a, b in zip(compiled, interpreted, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12)
