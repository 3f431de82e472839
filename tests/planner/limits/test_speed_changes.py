"""Jerk-limited changes of speed: by their phases added up, and beside the kernel that lays them out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from cncgen.planner.ild.look_ahead import Segments, build
from cncgen.planner.limits.speed_changes import change_time, peak_speed, rise_time

RNG = np.random.default_rng(20_261)


def drawn(n: int) -> tuple[np.ndarray, ...]:
    """Return sizes, accelerations and jerks over four decades each."""
    return tuple(10.0 ** RNG.uniform(low, low + 4.0, n) for low in (-1.0, 1.0, 2.0))


def test_the_phases_of_a_change_add_up_to_it() -> None:
    """Ramp, hold and ramp: the acceleration j t₁ for t₁ + t₂ on average makes Δ, and none exceeds a limit."""
    change, acceleration, jerk = drawn(500)
    rise, whole = rise_time(change, acceleration, jerk), change_time(change, acceleration, jerk)
    hold = whole - 2.0 * rise
    assert (hold >= -1e-9 * whole).all()
    np.testing.assert_allclose(jerk * rise * (rise + hold), change, rtol=1e-9)
    assert (jerk * rise <= acceleration * (1.0 + 1e-12)).all()
    both = (hold > 1e-9 * whole) & (jerk * rise < acceleration * (1.0 - 1e-9))
    assert not both.any()


def test_two_changes_to_the_peak_speed_take_the_length() -> None:
    """From rest to V and back cover f(V) V, f the time of a change."""
    length, acceleration, jerk = drawn(500)
    peak = peak_speed(length, acceleration, jerk)
    np.testing.assert_allclose(peak * change_time(peak, acceleration, jerk), length, rtol=1e-9)


def test_the_kernel_takes_as_long() -> None:
    """The seven phases of `ild`, whose top speed they may reach or not."""
    length, acceleration, jerk = drawn(200)
    top = np.where(RNG.random(200) < 0.5, 1e6, 0.3 * peak_speed(length, acceleration, jerk))
    reached = np.minimum(peak_speed(length, acceleration, jerk), top)
    expected = length / reached + change_time(reached, acceleration, jerk)
    for k in range(200):
        one = slice(k, k + 1)
        segment = Segments(
            length[one], top[one], np.zeros(1, np.int8), acceleration[one], jerk[one], np.full(2, np.inf)
        )
        pieces = build(segment, np.zeros(2), "bell")
        np.testing.assert_allclose(pieces.duration.sum(), expected[k], rtol=1e-6)


@pytest.mark.parametrize(("a", "j"), [(2000.0, 5e4), (50.0, 1e6), (1e9, 5e4)])
@pytest.mark.parametrize("way", [1e-3, 0.5, 40.0])
def test_the_speed_from_rest_to_rest(a: float, j: float, way: float) -> None:
    """Up to v and down again takes the way v (time up): the seven phases at their least."""

    def covered(v: float) -> float:
        ramp = v / a + a / j if v > a * a / j else 2.0 * np.sqrt(v / j)
        return v * ramp - way

    expected = brentq(covered, 1e-9, 1e9, xtol=1e-14, rtol=1e-14)
    assert peak_speed(np.array(way), np.array(a), np.array(j)) == pytest.approx(expected, rel=1e-9)
