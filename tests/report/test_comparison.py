"""The comparison of strategies and interpolators: its figures against closed forms and the stages themselves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cncgen.machine import Servo, load
from cncgen.pipeline import read, read_text
from cncgen.planner import PlanOptions, plan
from cncgen.planner.interpolators import STEPPERS
from cncgen.report.comparison import compare_interpolators, compare_strategies, moving_axes
from cncgen.setpoints import sample
from cncgen.toolpath.record import Toolpath


def chunks_of(text: str) -> list[Toolpath]:
    """Read G-code."""
    return list(read_text(text).chunks())


def test_strategies_side_by_side(programs: Path) -> None:
    """On the trident: ild within 10 µm and its limits along the path; the baselines are faster and far less true."""
    chunks = list(read(programs / "trident.nc").chunks())
    adaptive, curvature, ild = compare_strategies(
        chunks, load("xy-table"), PlanOptions(), ["adaptive", "curvature", "ild"]
    )
    assert [f.feedrate for f in (adaptive, curvature, ild)] == ["adaptive", "curvature", "ild"]
    assert ild.contour_max_mm is not None
    assert ild.contour_max_mm <= 0.010
    assert adaptive.time_s < curvature.time_s < ild.time_s
    # Tsai 2010: 90.65 % and 69.04 % less than adaptive and curvature; at least that much here.
    assert ild.contour_max_mm < (1 - 0.9065) * adaptive.contour_max_mm
    assert ild.contour_max_mm < (1 - 0.6904) * curvature.contour_max_mm
    assert abs(ild.predicted_max_mm - ild.contour_max_mm) < 0.003
    assert ild.acceleration_of_limit < 1.01
    assert adaptive.jerk_of_limit > 100.0


def test_peaks_are_third_differences_with_rest_around() -> None:
    """A line at 100 mm/s by `constant`: the step start is a second difference v/T and a third one v/T²."""
    chunks = chunks_of("G21 G90 G1 X50 F6000\nM2\n")
    (found,) = compare_strategies(chunks, load("xy-table"), PlanOptions(), ["constant"])
    assert found.time_s == pytest.approx(0.5)
    assert found.acceleration == pytest.approx(100.0 / 1e-3, rel=1e-6)
    assert found.jerk == pytest.approx(100.0 / 1e-6, rel=1e-6)
    assert found.acceleration_of_limit == pytest.approx(1e5 / 2450.0, rel=1e-6)


def test_a_stop_out_of_motion_shows_its_overshoot() -> None:
    """At v = 100 mm/s the axis lags v/Kv behind the last setpoint; then τ y'' + y' + Kv y = 0 passes it, y the way beyond."""
    gain, lag, speed = 80.0, 0.02, 100.0
    servo = Servo("first-order", {"position_gain_1_s": gain, "time_constant_s": lag})
    machine = load("xy-table")
    # The loop's own period delays it: short, so that the closed form, which has none, holds.
    machine = replace(
        machine, period_s=1e-4, axes={k: replace(a, servo=servo) for k, a in machine.axes.items()}
    )
    (found,) = compare_strategies(
        chunks_of("G21 G90 G1 X50 F6000\nM2\n"), machine, PlanOptions(), ["constant"]
    )
    fade, turn = 0.5 / lag, np.sqrt(gain / lag - 0.25 / lag**2)
    t = np.linspace(0.0, 0.1, 10_001)
    begin = -speed / gain
    beyond = np.exp(-fade * t) * (begin * np.cos(turn * t) + (speed + fade * begin) / turn * np.sin(turn * t))
    assert found.contour_max_mm == pytest.approx(beyond.max(), rel=0.01)
    assert found.contour_rms_mm == pytest.approx(0.0, abs=1e-9)


def test_without_servo_data_the_errors_are_left_out() -> None:
    """None, not zero, where nothing can be simulated."""
    machine = load("xy-table")
    bare = replace(
        machine,
        axes={k: replace(a, servo=None) for k, a in machine.axes.items()},
        max_contour_error_mm=None,
    )
    (found,) = compare_strategies(chunks_of("G1 X5 F600\nM2\n"), bare, PlanOptions(), ["ild"])
    assert found.contour_max_mm is None
    assert found.predicted_max_mm is None
    assert found.time_s is not None


def test_a_strategy_that_fails_says_why() -> None:
    """ild with a bound and no servo data is a fault in its own row; the others have their figures."""
    machine = load("xy-table")
    bare = replace(machine, axes={k: replace(a, servo=None) for k, a in machine.axes.items()})
    constant, ild = compare_strategies(
        chunks_of("G1 X5 F600\nM2\n"), bare, PlanOptions(), ["constant", "ild"]
    )
    assert constant.fault is None
    assert ild.fault is not None
    assert ild.fault.code == "contour-prediction"
    assert ild.time_s is None


def test_moving_axes() -> None:
    """Axes that move, also where a full circle returns to its start."""
    assert moving_axes(chunks_of("G1 Y3 F100\nG2 J5 Y3\nM2\n")) == "XY"
    assert moving_axes(chunks_of("G1 Z3 F100\nM2\n")) == "Z"


def test_a_wait_is_no_fluctuation() -> None:
    """On lines parameter and length are proportional, so that no interpolator has any, and half a second of rest is none."""
    chunks = chunks_of("G21 G61.1\nG1 X10 F1200\nG4 P0.5003\nY10\nM2\n")
    found = compare_interpolators(
        chunks, load("xy-table"), PlanOptions(feedrate="ild"), ["arclength", *STEPPERS]
    )
    assert [one.time_s for one in found] == [found[0].time_s] * len(found)
    assert max(one.max_part for one in found) < 1e-9


def test_fluctuation_of_arclength_is_that_of_the_setpoints(programs: Path) -> None:
    """The figure against chords of the setpoints on a curve whose chords are its arcs to 1e-7: a slow heart."""
    machine = replace(load("xy-table"), max_contour_error_mm=None)
    chunks = list(read(programs / "heart.nc").chunks())
    options = PlanOptions(feedrate="constant")
    (found,) = compare_interpolators(chunks, machine, options, ["arclength"])
    x = np.concatenate([c.position for c in sample(plan(chunks, machine, options), machine)])
    chord = np.linalg.norm(np.diff(x, axis=0), axis=1)[:-2]
    assert found.max_part < 1e-6
    assert np.abs(chord / chord.max() - 1.0).max() < 1e-3


@pytest.mark.parametrize("name", ["taylor1", "taylor2"])
def test_fluctuation_of_taylor_is_that_of_its_setpoints(name: str, programs: Path) -> None:
    """At constant feed every whole period commands v T; travelled is the arc over the chord between two setpoints.

    An arc that turns by θ is as long as its chord times 1 + θ²/24, but for θ⁴ and the change of curvature.
    """
    machine = replace(load("xy-table"), max_contour_error_mm=None)
    chunks = list(read(programs / "heart.nc").chunks())
    options = PlanOptions(feedrate="constant", interpolator=name)
    (found,) = compare_interpolators(chunks, machine, options, [name])
    x = np.concatenate([c.position for c in sample(plan(chunks, machine, options), machine)])
    step = np.diff(x, axis=0)
    turn = np.gradient(np.unwrap(np.arctan2(step[:, 1], step[:, 0])))
    arc = np.linalg.norm(step, axis=1) * (1.0 + turn**2 / 24.0)
    (exact,) = plan(chunks, machine, PlanOptions(feedrate="constant"))
    whole = int(exact.profile.t[-1] / machine.period_s) - 1
    part = arc[:whole] / (5000.0 / 60.0 * machine.period_s) - 1.0
    assert found.max_part > 1e-4
    assert found.max_part == pytest.approx(np.abs(part).max(), rel=0.02)
    assert found.rms_part == pytest.approx(np.sqrt(np.mean(part**2)), rel=0.02)


def test_peaks_are_those_of_the_worst_axis_among_those_that_are_asked() -> None:
    """A slope of 4 in 3 at 100 mm/s: Y has the larger steps; a table with a tenth of X's jerk has X the nearer to its limit."""
    machine = load("xy-table")
    axes = dict(machine.axes)
    axes["X"] = replace(axes["X"], max_jerk=0.1 * axes["X"].max_jerk)
    chunks = chunks_of("G21 G90 G1 X30 Y40 F6000\nM2\n")
    slow = replace(machine, axes=axes)
    (found,) = compare_strategies(chunks, slow, PlanOptions(), ["constant"])
    assert found.acceleration == pytest.approx(80.0 / 1e-3, rel=1e-6)
    assert found.jerk == pytest.approx(80.0 / 1e-6, rel=1e-6)
    assert found.acceleration_of_limit == pytest.approx(80.0 / 1e-3 / 2450.0, rel=1e-6)
    assert found.jerk_of_limit == pytest.approx(60.0 / 1e-6 / 5000.0, rel=1e-6)
    (alone,) = compare_strategies(chunks, slow, PlanOptions(), ["constant"], axes="X")
    assert alone.acceleration == pytest.approx(60.0 / 1e-3, rel=1e-6)


def test_without_names_the_papers_strategies_and_ours() -> None:
    found = compare_strategies(chunks_of("G1 X5 F600\nM2\n"), load("xy-table"), PlanOptions())
    assert [one.feedrate for one in found] == ["adaptive", "curvature", "ild", "optimal"]


def test_nothing_that_moves_has_no_fluctuation() -> None:
    (found,) = compare_interpolators(
        chunks_of("G4 P0.5\nM2\n"), load("xy-table"), PlanOptions(feedrate="ild"), ["taylor1"]
    )
    assert (found.max_part, found.rms_part) == (0.0, 0.0)
