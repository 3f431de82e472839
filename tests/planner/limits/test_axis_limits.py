"""What jumps of the path cost, and what speed they leave, beside setpoints that are differenced and beside closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import cncgen
from cncgen.machine import Axis, load
from cncgen.planner.least_time.speed_caps import SpeedCap
from cncgen.planner.limits.axis_limits import AxisLimits, along_path, resolution, speed_within
from cncgen.planner.record import Limit

#: Speed of the motion over a jump, mm/s.
SPEED = 20.0


@pytest.fixture
def bounds() -> AxisLimits:
    """Limits of `generic-mill` for X Y Z at a period of 2 ms."""
    return AxisLimits.of(replace(load("generic-mill"), period_s=0.002), "XYZ")


def largest_difference(bend: int, order: int, period: float) -> float:
    """Return the largest difference of setpoints of x(s) = s₊^bend at 20 mm/s, over all phases of the sampling.

    s₊^1 is a step of the tangent by 1, s₊²/2 one of the curvature by 1.
    """
    phases = np.linspace(0.0, 1.0, 2001)[:, None]
    s = SPEED * period * (np.arange(-6, 7) + phases)
    x = np.maximum(s, 0.0) ** bend / math.factorial(bend)
    return float(np.abs(np.diff(x, order, axis=1)).max() / period**order)


@pytest.mark.parametrize(("kind", "bend"), [("turn", 1), ("bend", 2)])
def test_a_jump_takes_what_differences_of_setpoints_show(bounds: AxisLimits, kind: str, bend: int) -> None:
    """The weaker of jerk and acceleration for a turn: its second difference is |Δ| v/T too."""
    step = np.array([[0.3, -0.2, 0.0]])
    none = np.zeros_like(step)
    linear, square = bounds.jump(*((step, none) if kind == "turn" else (none, step)))
    taken = (linear * SPEED + square * SPEED**2)[0]
    third = np.abs(step[0]) * largest_difference(bend, 3, bounds.period_s) / bounds.jerk
    second = np.abs(step[0]) * largest_difference(bend, 2, bounds.period_s) / bounds.acceleration
    expected = np.maximum(third, second) if kind == "turn" else third
    assert taken == pytest.approx(expected, rel=1e-6)


def test_the_speed_at_a_jump_is_the_root_for_the_worst_axis() -> None:
    """Of 2 v + 3 v² = 0.75 by the quadratic formula; v = 0.75/4 without the square, √(0.75/9) without the linear term."""
    linear = np.array([[2.0, 0.1], [4.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    square = np.array([[3.0, 0.1], [0.0, 0.0], [0.0, 9.0], [0.0, 0.0]])
    expected = [(-2.0 + math.sqrt(4.0 + 4.0 * 3.0 * 0.75)) / 6.0, 0.75 / 4.0, math.sqrt(0.75 / 9.0), np.inf]
    assert speed_within(linear, square, 0.75) == pytest.approx(expected, rel=1e-14)


def test_a_speed_keeps_its_digits_where_the_square_is_next_to_nothing() -> None:
    """v = share/linear (1 − share square/linear²) to first order; the textbook root would lose 8 digits here."""
    v = speed_within(np.array([[1.0]]), np.array([[1e-10]]), 0.75)
    assert v[0] == pytest.approx(0.75 * (1.0 - 0.75e-10), rel=1e-15)


def test_what_is_seen_of_a_bend_is_a_part_of_the_way_in_a_period(bounds: AxisLimits) -> None:
    """J T³/50 and A T²/200 (docs/least-time.md) of the weakest axis that moves, and the chord tolerance at most."""
    along_x = np.array([[1.0, 0.0, 0.0]])
    jerk, acceleration = bounds.jerk[0], bounds.acceleration[0]
    expected = min(jerk * bounds.period_s**3 / 50.0, acceleration * bounds.period_s**2 / 200.0)
    assert expected < bounds.chord_mm
    assert resolution(bounds, along_x)[0] == pytest.approx(expected, rel=1e-12)
    slow = replace(bounds, period_s=1.0)
    assert resolution(slow, along_x)[0] == bounds.chord_mm


def test_the_limit_along_a_path_is_that_of_the_axis_it_asks_most_of() -> None:
    """Along (0.6, 0.8) with limits 300 and 200: the least of 300/0.6 and 200/0.8; where nothing moves there is none."""
    limit = np.array([300.0, 200.0])
    assert along_path(limit, np.array([[0.6, 0.8], [0.0, 0.0]])) == pytest.approx([250.0, np.inf])
    # On two sides of a place the larger part of each axis counts.
    assert along_path(limit, np.array([[0.6, 0.8]]), np.array([[-1.0, 0.0]])) == pytest.approx([250.0])


def test_a_cap_is_that_of_the_moving_end_beside_a_rest() -> None:
    """v = 10 s: at the rest at s = 0 the cap is 0, and no bound of the interval that leaves it."""
    cap = SpeedCap(lambda s, x: 10.0 * s, Limit.CONTOUR_ERROR)
    s = np.array([0.0, 1.0, 3.0])
    x = np.zeros((3, 2, 3, 2))
    q = cap.on_intervals(s, x, np.array([True, False]), np.array([False, False]))
    assert q[0] == pytest.approx([100.0] * 3, rel=1e-5)
    assert q[1] == pytest.approx([100.0, 400.0, 900.0], rel=1e-5)
    assert cap.lower(s, x[:, :, 0], np.full(3, 400.0)).tolist() == [0.0, 100.0, 400.0]


def test_a_jerk_without_limit_takes_the_time_of_the_acceleration() -> None:
    """Lines whose feed rises from one to the next by u to v take d/v + (v − u)²/(2 A v) each, and V/(2 A) to stop.

    What a ramp of the acceleration within a period adds is less than the period. With nodes as close as the ramps of such a
    jerk there were 5.7 million.
    """
    feeds = [300.0 + 7.0 * line for line in range(1, 40)]
    lines = "".join(f"G1 X{0.5 * n} A{3.0 * n} F{feed}\n" for n, feed in enumerate(feeds, 1))
    A = 1000.0 / 6.0  # of X, that turns A by 6 deg/mm at 1000 deg/s²
    turning = Axis("A", np.pi, np.radians(1000.0), 1e13)
    machine = replace(load("xy-table"), axes={"X": Axis("X", 500.0, 3000.0, 1e15), "A": turning})
    setpoints = cncgen.sample(
        cncgen.plan(cncgen.read_text(f"G21 G90 G64 P0.01\n{lines}M2\n"), machine)
    ).collect()
    v = np.array(feeds) / 60.0
    u = np.append(0.0, v[:-1])
    least = float((0.5 / v + (v - u) ** 2 / (2.0 * A * v)).sum() + v[-1] / (2.0 * A))
    assert setpoints.time_s[-1] == pytest.approx(least, abs=len(v) * machine.period_s / 10.0)
