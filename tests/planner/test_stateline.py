"""The stateline as an interpolator: it keeps the path, always ends, and holds by its rule."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.machine import Machine, load
from cncgen.machine.record import Servo
from cncgen.planner import PlanOptions, plan
from cncgen.planner.motion import motion_at
from cncgen.planner.stateline_interpolation import Stateline
from cncgen.report.comparison import compare_interpolators
from cncgen.toolpath.record import Toolpath

HELD = PlanOptions(feedrate="constant", interpolator="stateline")


def first_order(gain: float) -> PlanOptions:
    """Return options with loops Kv/(s + Kv) on both axes: their error is known in closed form."""
    servo = Servo("first-order", {"position_gain_1_s": gain})
    return replace(HELD, servos={"X": servo, "Y": servo})


def test_a_hold_at_a_corner_lasts_until_the_error_has_decayed(
    lines: Callable[..., Toolpath], table: Machine
) -> None:
    """Kv = 50/s at 100 mm/s lags by V/Kv = 2 mm; after the corner X may be off by δ: ln(2/0.05)/50 s = 73.8 ms of hold."""
    square = lines([(0, 0), (50, 0), (50, 50)])
    (plain,) = plan([square], table, replace(first_order(50.0), interpolator="arclength"))
    (done,) = plan([square], table, first_order(50.0))
    assert done.profile.t[-1] - plain.profile.t[-1] == pytest.approx(np.log(2.0 / 0.05) / 50.0, abs=2e-3)
    waits = np.flatnonzero(done.profile.waits)
    assert len(waits) >= 1
    assert done.profile.s[waits] == pytest.approx(50.0, abs=0.11)
    # The path is the plan's, and so is its order.
    ticks = np.arange(0.0, done.profile.t[-1], table.period_s)
    assert (np.diff(motion_at(done.profile, ticks).s) >= -1e-12).all()
    assert done.profile.s[-1] == plain.profile.s[-1]


def test_random_plans_always_end(lines: Callable[..., Toolpath], table: Machine) -> None:
    """40 random paths, gains and bounds; the waits end, and events keep their order."""
    rng = np.random.default_rng(23)
    for _ in range(40):
        points = np.cumsum(rng.normal(size=(rng.integers(2, 12), 2)) * rng.uniform(0.5, 5.0), axis=0)
        options = replace(first_order(rng.uniform(5.0, 300.0)), stateline_bound_mm=10.0 ** rng.uniform(-3, 0))
        path = lines([(0.0, 0.0), *map(tuple, points)])
        plain = list(plan([path], table, replace(options, interpolator="arclength")))
        done = list(plan([path], table, options))
        assert done[-1].profile.s[-1] == plain[-1].profile.s[-1]
        assert plain[-1].profile.t[-1] <= done[-1].profile.t[-1] < plain[-1].profile.t[-1] + 60.0


def test_blocks_of_setpoints_do_not_matter() -> None:
    """Setpoint by setpoint, and in blocks, the line is low for the same periods."""
    rng = np.random.default_rng(5)
    steps = rng.normal(size=(600, 2)) * 0.05
    ahead = np.roll(steps, -1, axis=0)
    machine, options = load("xy-table"), PlanOptions(stateline_bound_mm=0.02)
    whole = Stateline.of(machine, options, "XY").holds(steps, ahead)
    line = Stateline.of(machine, options, "XY")
    single = [int(line.holds(steps[k : k + 1], ahead[k : k + 1])[0]) for k in range(600)]
    assert whole.tolist() == single
    assert whole.any()


def test_compare_shows_path_error_time_and_contour_error(lines: Callable[..., Toolpath]) -> None:
    """On P loops the axes come 9 times nearer the corners than without the line, as paper 002 means it."""
    square = lines([(0, 0), (30, 0), (30, 20), (0, 20), (0, 0)])
    names = ["arclength", "stateline", "two-stage-linear", "two-stage-centred"]
    options = PlanOptions(feedrate="constant")
    exact, held, chords, centred = compare_interpolators([square], load("dyna-1007"), options, names)
    assert exact.path_error_mm == held.path_error_mm == 0.0
    assert exact.contour_max_mm is not None
    assert held.contour_max_mm is not None
    assert held.contour_max_mm < exact.contour_max_mm / 8.0
    assert exact.time_s < held.time_s < 1.1 * exact.time_s
    assert chords.path_error_mm is not None
    assert centred.path_error_mm is not None
    assert chords.demand is not None
    assert chords.path_error_mm > centred.path_error_mm > 0.1
    # Chords of 16 ms meet at angles: the speed of an axis jumps within a period.
    (jerk,) = [b["ratio"] for b in chords.demand.breaks if (b["axis"], b["limit"]) == ("X", "jerk")]
    assert jerk > 100.0
    assert chords.demand.effort is not None
    assert list(chords.demand.effort) == ["x", "y"]


def test_axes_without_servo_data_cannot_be_on_the_line(
    lines: Callable[..., Toolpath], table: Machine
) -> None:
    path = lines([(0, 0), (50, 0)])
    bare = replace(table, axes={k: replace(axis, servo=None) for k, axis in table.axes.items()})
    with pytest.raises(UsageError, match="stateline"):
        list(plan([path], bare, HELD))
    (found,) = compare_interpolators([path], bare, PlanOptions(feedrate="constant"), ["stateline"])
    assert found.fault is not None
    assert found.fault.code == "stateline"
