"""Jerk-limited changes of speed, beside the kernel that lays out their phases."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from cncgen.planner.ild.look_ahead import SegmentPieces, Segments, build
from cncgen.planner.limits.speeds import change_time

RNG = np.random.default_rng(20_261)


def drawn(n: int) -> tuple[np.ndarray, ...]:
    """Return sizes, accelerations and jerks over four decades each."""
    return tuple(10.0 ** RNG.uniform(low, low + 4.0, n) for low in (-1.0, 1.0, 2.0))


def pieces_of(length: float, top: float, acceleration: float, jerk: float) -> SegmentPieces:
    """Return the phases of a way from rest to rest, as `ild` and the lines of `optimal` have them."""
    one = [np.array([each]) for each in (length, top, acceleration, jerk)]
    return build(
        Segments(one[0], one[1], np.zeros(1, np.int8), *one[2:], np.full(2, np.inf)), np.zeros(2), "bell"
    )


def test_the_phases_of_a_change_add_up_to_it() -> None:
    """From rest to V and back cover f(V) V, f the time of a change; no phase exceeds a limit, and V is reached or not."""
    for length, acceleration, jerk in zip(*drawn(500), strict=True):
        peak = pieces_of(length, np.inf, acceleration, jerk).v.max()
        top = peak if RNG.random() < 0.5 else 0.3 * peak
        found = pieces_of(length, top, acceleration, jerk)
        change = change_time(top, acceleration, jerk)
        assert found.duration.sum() == pytest.approx(length / top + change, rel=1e-9)
        assert np.abs(found.a).max() <= acceleration * (1.0 + 1e-12)
        assert np.abs(found.j).max() <= jerk * (1.0 + 1e-12)


@pytest.mark.parametrize(("a", "j"), [(2000.0, 5e4), (50.0, 1e6), (1e9, 5e4)])
@pytest.mark.parametrize("way", [1e-3, 0.5, 40.0])
def test_the_speed_from_rest_to_rest(a: float, j: float, way: float) -> None:
    """Up to v and down again takes the way v (time up): the seven phases at their least."""

    def covered(v: float) -> float:
        ramp = v / a + a / j if v > a * a / j else 2.0 * np.sqrt(v / j)
        return v * ramp - way

    expected = brentq(covered, 1e-9, 1e9, xtol=1e-14, rtol=1e-14)
    assert pieces_of(way, np.inf, a, j).v.max() == pytest.approx(expected, rel=1e-9)
