"""The way through a rounded corner that chords hold, by closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from cncgen.planner.limits.bend_speeds import chord_speed
from cncgen.planner.smoothing.bend_time import REACH, STEPS, Way, bends, response, turned

PERIOD, CHORD = 0.004, 0.001


def way(bend: np.ndarray, length: float = 0.05, acceleration: float = 1000.0, jerk: float = 5e4) -> Way:
    one = np.ones(1)
    return Way(
        bend[:, None], length * one, one, CHORD * one, acceleration * one, jerk * one, 80.0 * one, PERIOD
    )


def changed(v: float, top: float, acceleration: float = 1000.0, jerk: float = 5e4) -> float:
    """Return what a change of speed loses: from v without acceleration to V in Δ/A + A/J, by the mean of both speeds."""
    change = top - v
    assert change > acceleration**2 / jerk
    return change * (change / acceleration + acceleration / jerk) / (2.0 * top)


@pytest.mark.parametrize("bend", [15.0, 100.0, 900.0, 3e4, 1e6, 1e8])
@pytest.mark.parametrize("beyond", [0.0, 0.0801])
def test_what_chords_hold_in_the_middle_alone_is_a_change_of_speed_on_a_line(
    bend: float, beyond: float
) -> None:
    """Whether chords hold nothing beside it, or a little less than V, which is not reached there: steps make no difference.

    The slower the middle is beside what full jerk reaches on one step, the more of the step's time was told twice.
    """
    each = way(np.append(bend, np.zeros(STEPS)))
    beside = way(np.append(bend, np.full(STEPS, beyond)))
    expected = changed(float(each.slowest()[0]), 80.0)
    for found in (each, beside):
        assert found.lost()[0] == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("v", [1e-4, 0.03, 2.0, 40.0])
@pytest.mark.parametrize("a", [0.0, 1.0, 400.0, 1000.0])
@pytest.mark.parametrize("length", [0.0, 1e-7, 1e-3, 0.4])
def test_the_time_of_a_step(v: float, a: float, length: float) -> None:
    """By the root of the way, which jerk makes until the acceleration is at its limit, and that from there on."""

    def covered(t: float) -> float:
        rise = min(t, (1000.0 - a) / 5e4)
        hold, reached = t - rise, v + a * rise + 0.5 * 5e4 * rise**2
        return v * rise + a * rise**2 / 2.0 + 5e4 * rise**3 / 6.0 + reached * hold + 500.0 * hold**2

    t, faster, grown = way(np.zeros(STEPS + 1)).step_time(*(np.array([x]) for x in (v, a, length)))
    expected = brentq(lambda t: covered(t) - length, 0.0, 1e4, xtol=1e-16, rtol=1e-14) if length else 0.0
    assert t[0] == pytest.approx(expected, rel=1e-7)
    assert grown[0] == pytest.approx(min(a + 5e4 * expected, 1000.0), rel=1e-7)
    slope = (covered(1.001 * expected) - covered(0.999 * expected)) / (0.002 * expected) if length else v
    assert faster[0] == pytest.approx(slope, rel=1e-5)


def test_what_chords_hold_all_along_takes_the_time_of_that_speed() -> None:
    """A bend of one curvature over 3 L, and the change of speed beyond it, with next to no acceleration before."""
    each = way(np.full(STEPS + 1, 400.0))
    v = float(chord_speed(np.array([400.0]), CHORD, PERIOD)[0])
    assert each.lost()[0] == pytest.approx(REACH * 0.05 * (1.0 / v - 1.0 / 80.0) + changed(v, 80.0), rel=1e-9)


def test_the_bend_of_a_right_angle() -> None:
    """In the middle all of x'' lies across x', |Δ| h(0); beside it the part that the cross product with x' tells."""
    leave, entry = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0]])
    found = bends(leave, entry)
    assert found.shape == (2, STEPS + 1, 1)
    np.testing.assert_allclose(found[0], found[1], rtol=1e-12)
    s = REACH * 5 / STEPS
    part = 0.5 + quad(lambda x: float(response(np.array([x]))[0]), 0.0, s)[0]
    along = np.array([1.0 - part, part])
    across = abs(along[0] * 1.0 + along[1] * 1.0) / np.hypot(*along)
    ratio = across * float(response(np.array([s]))[0]) / (np.sqrt(2.0) / 3.0)
    assert found[1, 5, 0] / found[1, 0, 0] == pytest.approx(ratio, rel=1e-9)
    assert turned(np.array([40.0]))[0] == pytest.approx(0.5, abs=1e-8)
