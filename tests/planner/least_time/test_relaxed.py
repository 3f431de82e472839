"""A limit that is relaxed never makes a motion longer: curves and polylines on which it once did."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from scipy.optimize import brentq

import cncgen
from cncgen.machine.record import Axis, Machine
from cncgen.planner.limits.axis_limits import JUMP_SHARE

#: Velocity, acceleration and jerk of X Y Z; the axis whose acceleration is relaxed; control points and weights; knots.
WEAK_X_AND_Z = (
    {"X": (29.0, 300.0, 489.0), "Y": (967.0, 10000.0, 16305.0), "Z": (29.0, 300.0, 489.0)},
    "Z",
    [(0, 0, 0, 1), (-6, -5, -1.2, 1), (10, 12, -1, 0.5), (2, -3, 0.2, 0.5)],
    [0, 0, 0, 0],
)
HIGH_JERK = (
    {"X": (6.64188, 8.85027, 30000.0), "Y": (221.396, 295.009, 1e6), "Z": (221.396, 295.009, 1e6)},
    "Z",
    [(0, 0, 0, 0.5), (-11, -10, 1.8, 2), (-3, -12, 2.8, 1), (5, 11, 3, 0.5), (-13, -7, 0.6, 1), (12, 13, -1.4, 1), (7, 0, 2.8, 1), (-5, 15, 3, 1)],
    [0, 0, 0, 0, 0.1, 0.8, 0.9, 0.9],
)  # fmt: skip


def curve(points: list, knots: list[float], feed: float) -> str:
    """Return a cubic NURBS of G61."""
    rows = [f"K{k} X{x} Y{y} Z{z} R{r}" for k, (x, y, z, r) in zip(knots, points, strict=True)]
    rows[0] += f" F{feed}"
    return "\n".join(["G21 G90 G61", f"G6.2 P4 {rows[0]}", *rows[1:], *["K1"] * 4, "M2", ""])


def seconds(limits: dict[str, tuple[float, float, float]], points: list, knots: list[float]) -> float:
    """Return the least time of a cubic NURBS of G61."""
    axes = {letter: Axis(letter, *values) for letter, values in limits.items()}
    return duration(curve(points, knots, 3453), Machine("weak", MappingProxyType(axes)))


#: A turn of the radius 40 nm where nodes stand some nm apart, as near as setpoints of 2 ms tell them apart.
NEARLY_A_CUSP = (
    [(0, 0, 0, 1), (-7.61443983301025, -1.592005242571496, 0, 1), (3.51222244616141, -8.931183759192187, 0, 1), (14.91500271496438, 6.706446165301617, 0, 2), (5.402441888283846, -4.81712024622578, 0, 2), (9.745334739092993, 10.869707760039613, 0, 2)],
    [0, 0, 0, 0, 0.524193532156534, 0.854325750041333],
)  # fmt: skip


def test_more_jerk_takes_no_more_time_where_a_curve_turns_as_good_as_at_once() -> None:
    """What lies between such nodes passed the jerk of the weak axis whatever the speed: stops around took 4 % more."""
    points, knots = NEARLY_A_CUSP
    times = []
    for factor in (1.0, 20.2, 30.0, 49.995):
        axes = {
            a: Axis(a, 415.75, 2314.6583, 57878.356 * k) for a, k in (("X", 1.0), ("Y", factor), ("Z", 1.0))
        }
        machine = Machine("weak", MappingProxyType(axes), period_s=2e-3, chord_tolerance_mm=0.010869871)
        times.append(duration(curve(points, knots, 7698.515), machine))
    assert times[1] <= times[0] * (1.0 + 1e-3)
    assert max(times[2:]) <= times[1] * (1.0 + 1e-3)


@pytest.mark.parametrize("case", [WEAK_X_AND_Z, HIGH_JERK])
@pytest.mark.parametrize("factor", [1.25, 1.5, 3.0])
def test_more_acceleration_takes_no_more_time(case: tuple, factor: float) -> None:
    """The interval beside a rest was too long where jerk binds (1.7 %); a window found no start, and stopped (0.8 %)."""
    limits, letter, points, knots = case
    velocity, acceleration, jerk = limits[letter]
    relaxed = {**limits, letter: (velocity, factor * acceleration, jerk)}
    assert seconds(relaxed, points, knots) <= seconds(limits, points, knots) * (1.0 + 1e-3)


def polyline(turns: np.ndarray, lengths: np.ndarray, mode: str = "G61") -> str:
    """Return lines in X Y, each with its length, that turn by so many radians one after the other."""
    angle = np.cumsum(turns)
    points = np.cumsum(lengths[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1), axis=0)
    return "\n".join(["G21 G90 F60000", mode, *(f"G1 X{x:.9f} Y{y:.9f}" for x, y in points), "M2", ""])


def plane(period_s: float, velocity: float, acceleration: float, jerk: float) -> Machine:
    """Return two axes that are alike."""
    axes = {letter: Axis(letter, velocity, acceleration, jerk) for letter in "XY"}
    return replace(Machine("plane", MappingProxyType(axes)), period_s=period_s)


def duration(text: str, machine: Machine) -> float:
    return float(list(cncgen.plan(cncgen.read_text(text), machine))[-1].profile.t[-1])


@pytest.mark.parametrize("period_s", [1e-3, 4e-3])
@pytest.mark.parametrize("seed", [0, 1])
def test_more_acceleration_takes_no_more_time_on_lines_that_hardly_turn(period_s: float, seed: int) -> None:
    """The interval beside a rest did not mind that a corner near by is passed slowly: up to 3.8 % longer."""
    rng = np.random.default_rng(seed)
    text = polyline(
        rng.normal(0.0, (0.03, 0.2)[seed], 10), np.exp(rng.uniform(np.log(0.5), np.log(20.0), 10))
    )
    times = [duration(text, plane(period_s, 250.0, acceleration, 5e4)) for acceleration in (2590, 4242, 5e4)]
    assert times[1] <= times[0] * (1.0 + 1e-3)
    assert times[2] <= min(times) * (1.0 + 1e-3)


def test_more_velocity_takes_no_more_time_on_short_lines() -> None:
    """A corner was taken to be passed as fast as it may alone, with the corners around too slow for that: 0.5 % longer."""
    text = polyline(np.random.default_rng(1).normal(0.0, 0.04, 200), np.full(200, 0.4))
    one, other = (duration(text, plane(0.004, velocity, 3000.0, 5e4)) for velocity in (36.84, 71.69))
    assert other <= one * (1.0 + 1e-3)


def test_a_jump_that_does_not_hold_the_speed_is_no_stop() -> None:
    """Arcs of 0.62 mm one against the other at 2 ms: chords hold 15 mm/s, at which the jump takes a tenth of the jerk.

    The jump alone would allow less than 5 A T, below which all that holds the speed was a stop: 3.6 % longer with more A.
    """
    text = "G21 G90 G61 F4000\nG1 X1\nG2 X2 Y-1 J-1\nG3 X3 Y-2 I1\nG2 X4 Y-3 J-1\nM2\n"
    machine = replace(plane(0.002, 23.4, 5000.0, 2.8e6), chord_tolerance_mm=2e-4)
    times = [duration(text, replace(machine, axes=_faster(machine, factor))) for factor in (1.0, 1.5, 2.0)]
    assert times[2] <= times[1] <= times[0] * (1.0 + 1e-3)


@pytest.mark.parametrize("what", ["jerk", "feed"])
def test_a_jump_that_begins_to_hold_the_speed_is_no_stop_as_long_as_it_leaves_some(what: str) -> None:
    """Arcs and lines whose jumps allow 2 J T² or 3 A T: stops in them took 26 % longer with more feed, 1.5 % with more J."""
    if what == "feed":
        rows = "G1 X0.364\n" + "".join(
            f"G{2 + k % 2} X{0.364 + 0.3552 * (k + 1):.9f} Y{-0.2844 * (k + 1):.9f} R0.364\n"
            for k in range(4)
        )
        machine = replace(plane(0.004, 199.0, 3704.5, 719e3), chord_tolerance_mm=0.054)
        times = [duration(f"G21 G90 G61 F{feed}\n{rows}M2\n", machine) for feed in (1368, 1610, 2257)]
    else:
        text = polyline(0.23 * np.array([0, *[1, -1] * 4]), np.full(9, 3.15)).replace("F60000", "F400.5")
        machine = replace(plane(0.002, 11.4, 234.3, 64e3), chord_tolerance_mm=0.07)
        faster = [Axis("X", 11.4, 234.3, 64e3 * k) for k in (1, 3, 10)]
        times = [
            duration(
                text,
                replace(
                    machine, axes=MappingProxyType({"X": x, "Y": replace(x, letter="Y", max_jerk=1.9e6)})
                ),
            )
            for x in faster
        ]
    assert times[1] <= times[0] * (1.0 + 1e-3)
    assert times[2] <= times[1] * (1.0 + 1e-3)


def test_more_jerk_takes_no_more_time_on_short_lines_whose_corners_chords_hold() -> None:
    """Nine lines of 13 to 27 µm at 0.19 ms, a period and a half each: slow corners were stops within 0.47 J T³ of a rest.

    Chords leave the corners 50 to 260 mm/s, at which no jump takes more than a twentieth of the jerk. 1.5 times the jerk of X took 5.6 %
    more, as more of them came to lie so near to a rest, and passing them takes 0.7 of what full jerk needs from stop to stop.
    """
    points = np.array([[0, 0], [22, 0.94], [37, -5.16], [62, -18.16], [78, -30.16], [93, -38.96], [112, -52.96], [139, -59.66], [161, -62.16], [183, -64.16]])  # fmt: skip
    text = "G21 G90 G61 F280000\n" + "".join(f"G1 X{x:.6f} Y{y:.6f}\n" for x, y in 1e-3 * points[1:]) + "M2\n"
    x, y = Axis("X", 3920.0, 6.15e6, 2.32e10), Axis("Y", 2560.0, 4.01e6, 1.52e10)
    machine = replace(plane(0.00019, 1.0, 1.0, 1.0), chord_tolerance_mm=1e-3)
    times = []
    for factor in (1.0, 1.5):
        faster = {"X": replace(x, max_jerk=factor * x.max_jerk), "Y": y}
        times.append(duration(text, replace(machine, axes=MappingProxyType(faster))))
    ways = np.abs(1e-3 * np.diff(points, axis=0))
    # A way of L takes (32 L/J)^(1/3) by full jerk alone.
    stops = np.cbrt(32.0 * (ways / (x.max_jerk, y.max_jerk)).max(axis=1)).sum()
    assert times[0] <= 0.7 * stops
    assert times[1] <= times[0] * (1.0 + 1e-3)


def _faster(machine: Machine, factor: float) -> MappingProxyType[str, Axis]:
    """Return the axes with so much more acceleration."""
    axes = machine.axes.items()
    return MappingProxyType(
        {a: replace(axis, max_acceleration=factor * axis.max_acceleration) for a, axis in axes}
    )


def _missing(top: float, ends: tuple[float, float], length: float, jerk: float) -> float:
    """Return by how much the way by full jerk from one speed to the top and on to another is longer than a length."""
    return sum((v + top) * np.sqrt((top - v) / jerk) for v in ends) - length


def test_lines_with_slow_corners_take_hardly_more_than_the_closed_form() -> None:
    """From v to w jerk alone needs 2 √((w − v)/J), on a way of (v + w) √((w − v)/J).

    Nine lines of 10 mm that turn by ±0.5°: the corners are passed at the speed v that three quarters of the jerk allow,
    which are missing for one and a half periods on either side.
    """
    jerk, period, length, turn = 3594.0, 1e-3, 10.0, np.radians(0.5)
    corner = JUMP_SHARE * jerk * period**2 / np.sin(turn)
    least = 0.0
    for one, other, count in ((corner, corner, 7), (0.0, corner, 2)):
        top = brentq(_missing, corner, 1e3, args=((one, other), length, jerk))
        least += count * sum(2.0 * np.sqrt((top - v) / jerk) for v in (one, other))
    text = polyline(np.radians(0.5) * np.array([0, *[1, -1] * 4]), np.full(9, length))
    assert least < duration(text, plane(period, 250.0, 2500.0, jerk)) <= 1.011 * least
