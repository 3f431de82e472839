"""What nothing around lowers keeps all its digits, however long the way to it is."""

import numpy as np
import pytest

from cncgen.machine import load
from cncgen.planner.optimal.joints import _reached
from cncgen.planner.optimal.limits import Bounds, lowered


@pytest.mark.parametrize("seed", range(5))
def test_lowered_is_the_least_of_all_cones(seed: int) -> None:
    """At each place the least of all values there, each grown by the way to it (a double loop)."""
    rng = np.random.default_rng(seed)
    way = np.cumsum(rng.exponential(1.0, 60))
    values = rng.exponential(20.0, 60)
    expected = (values + np.abs(way[:, None] - way)).min(axis=1)
    assert lowered(values, way) == pytest.approx(expected, rel=1e-13)


def test_a_slow_joint_far_along_keeps_its_speed_to_the_last_digit() -> None:
    """Of 10⁻² mm/s behind curves of 10³ mm/s (once 3·10⁻⁶ of it was rounding, which units chose)."""
    bounds = Bounds.of(load("generic-mill"), "XYZ")
    s = np.arange(30.0)
    speed = np.where(np.arange(30) % 7 == 5, 0.010162709087104894, 1077.35002)
    direction = np.tile([0.6, 0.8, 0.0], (30, 1))
    found = _reached(bounds, s, speed, np.zeros(29, bool), direction)
    assert (found == speed).all()
