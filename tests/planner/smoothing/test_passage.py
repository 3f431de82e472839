"""The way through a rounded corner that chords hold, by closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from cncgen.planner.rows import chord_speed
from cncgen.planner.smoothing.passage import REACH, STEPS, Way, bends, response, turned

PERIOD, CHORD = 0.004, 0.001


def way(bend: np.ndarray, length: float = 0.05, acceleration: float = 1000.0, jerk: float = 5e4) -> Way:
    one = np.ones(1)
    return Way(
        bend[:, None], length * one, one, CHORD * one, acceleration * one, jerk * one, 80.0 * one, PERIOD
    )


@pytest.mark.parametrize("bend", [15.0, 100.0, 400.0, 900.0, 3000.0])
def test_what_chords_hold_in_the_middle_alone_is_a_change_of_speed_on_a_line(bend: float) -> None:
    """From v without acceleration to V in Δ/A + A/J, by the mean of both speeds: Δ (Δ/A + A/J)/(2 V) against going on at V.

    Where v is slow beside what full jerk reaches on one step, more time is told, never less: such a corner is a stop.
    """
    each = way(np.append(bend, np.zeros(STEPS)))
    change = 80.0 - float(each.slowest()[0])
    expected = change * (change / 1000.0 + 1000.0 / 5e4) / (2.0 * 80.0)
    assert each.lost()[0] >= (1.0 - 1e-3) * expected
    if change < 78.0:
        assert each.lost()[0] == pytest.approx(expected, rel=0.02)


def test_what_chords_hold_all_along_takes_the_time_of_that_speed() -> None:
    """A bend of one curvature over 3 L, and the change of speed beyond it, with next to no acceleration before."""
    each = way(np.full(STEPS + 1, 400.0))
    v = float(chord_speed(np.array([400.0]), CHORD, PERIOD)[0])
    change = 80.0 - v
    after = change * (change / 1000.0 + 1000.0 / 5e4) / (2.0 * 80.0)
    assert each.lost()[0] == pytest.approx(REACH * 0.05 * (1.0 / v - 1.0 / 80.0) + after, rel=1e-9)


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
