"""What would shorten a program: derivatives against closed forms and against differences of other steps."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cncgen.cli.app import run
from cncgen.machine import load
from cncgen.pipeline import read, why
from cncgen.planner import PlanOptions
from cncgen.report.shortening import (
    WHOLE,
    Case,
    SlopeKind,
    as_text,
    derivative,
    planned_times,
    quantities,
    waited_times,
)
from trials.shortening import ASKED, compared

Floats = NDArray[np.float64]


def test_a_long_line_at_its_feed_in_closed_form(tmp_path: Path) -> None:
    """L/F + F/A + A/J from rest to rest where F is reached, in seven phases (Biagiotti and Melchiorri (2008), 3.4)."""
    machine = load("xy-table")
    axis = machine.axes["X"]
    feed, jerk, acc = 100.0, axis.max_jerk, axis.max_acceleration
    (tmp_path / "a.nc").write_text("G21 G90 G61 F6000\nG1 X200\nM2\n")
    now, found = why(tmp_path / "a.nc", machine)
    worth = {each.name: each for each in found}
    # The feed is reached without full acceleration where F < A²/J: then the ramps take 2 √(F/J).
    assert feed < acc**2 / jerk
    assert now.cycle_s == pytest.approx(200 / feed + 2 * (feed / jerk) ** 0.5, abs=2e-3)
    by_feed = 0.1 * (200 / feed - (feed / jerk) ** 0.5)
    by_jerk = 0.1 * (feed / jerk) ** 0.5
    assert worth["feed"].derivative_s == pytest.approx(by_feed, rel=1e-3)
    assert worth["X jerk"].slope.bound < 5e-4 * now.cycle_s
    assert worth["X jerk"].slope.seconds == pytest.approx(by_jerk, abs=worth["X jerk"].slope.bound)
    saved = 2 * (feed / jerk) ** 0.5 * (1 - 1.1**-0.5)
    assert worth["X jerk"].saved_s == pytest.approx(saved, rel=1e-2)
    assert [each.name for each in found[:2]] == ["feed", "X jerk"]
    assert worth["X velocity"].saved_s == pytest.approx(0.0, abs=1e-6)


def test_a_derivative_is_that_of_a_polynomial_of_fourth_degree() -> None:
    """Nearly straight, five plans are enough; two more with a fourth power of 3 % of the slope."""
    for fourth, plans in ((0.0, 5), (6e-4, 7)):
        asked = set[int]()

        def saved(steps: int, fourth: float = fourth, asked: set[int] = asked) -> float:
            asked.add(steps)
            x = steps / WHOLE
            return 0.02 * x - 3e-3 * x**2 + 1e-4 * x**3 + fourth * x**4

        found = derivative(saved, 1e-9)
        assert found.derivative == pytest.approx(0.02, rel=1e-12)
        assert len(asked) == plans


@pytest.mark.parametrize(
    "odd",
    [
        pytest.param(lambda x: 2e-3 * abs(x), id="a kink"),
        pytest.param(lambda x: 1e-3 * (x > 0.2), id="a jump near by"),
        pytest.param(lambda x: 1e-3 * (x > 0.3), id="a jump further away"),
        pytest.param(lambda x: 8e-3 * max(x, 0.0) ** 2, id="a jump of the second derivative"),
    ],
)
def test_no_derivative_is_given_where_it_would_be_off(odd: Callable[[float], float]) -> None:
    assert derivative(lambda k: 0.02 * k / WHOLE, 1e-9).derivative == pytest.approx(0.02)
    assert derivative(lambda k: 0.02 * k / WHOLE + odd(k / WHOLE), 1e-9).derivative is None


def test_where_the_second_derivative_jumps_differences_of_2_to_5_percent_agree_to_2_percent() -> None:
    """x + 0.16 x² above the value alone: a difference of the steps ±h is 1 + 0.08 h."""
    found = derivative(lambda k: k / WHOLE + 0.16 * max(k / WHOLE, 0.0) ** 2, 1e-9)
    for step in (0.2, 0.35, 0.5):
        assert found.derivative == pytest.approx(1.0 + 0.08 * step, rel=0.02)


def test_a_slope_that_changes_within_5_percent_is_told_with_its_differences() -> None:
    """x + 0.5 x² above the value alone: a difference of the steps ±h is 1 + 0.25 h, which is 1.05 at 2 % and 1.125 at 5 %."""
    found = derivative(lambda k: k / WHOLE + 0.5 * max(k / WHOLE, 0.0) ** 2, 1e-9)
    assert found.kind is SlopeKind.BEND
    assert found.derivative is None
    assert found.seconds == pytest.approx(1.0875, rel=1e-6)
    assert found.bound == pytest.approx(0.0375, rel=1e-6)


def test_no_effect_is_told_with_what_plans_agree_to(tmp_path: Path) -> None:
    """On the rows 10⁻⁶ of the cycle; within a tolerance 10⁻⁴ of the time in which path and speed are planned together."""
    for mode, part in (("G61", 1e-6), ("G64 P0.05", 1e-4)):
        (tmp_path / "a.nc").write_text(f"G21 G90 {mode} F3000\nG1 X40\nX45 Y20\nX80 Y25\nM2\n")
        now, found = why(tmp_path / "a.nc", load("xy-table"))
        slope = {each.name: each for each in found}["X velocity"].slope
        assert slope.kind is SlopeKind.NO_EFFECT
        assert slope.bound == pytest.approx(part * now.cycle_s, rel=0.01)
        assert f"no effect: 10 % up or down changes nothing, to {slope.bound:.1g} s" in as_text(
            now, found, "part.nc"
        )


def test_one_plan_that_jumps_is_left_out() -> None:
    """Of a straight line with scatter of 0.1 %, one plan takes a tenth longer: by chance a trial of random programs met such plans."""
    rng = np.random.default_rng(11)
    for out in range(-16, 17):
        if out in (0, 16, -16):  # at the end a plan may be the first of several
            continue
        scatter = rng.normal(0.0, 1e-3, 65)
        found = derivative(
            lambda k, s=scatter, out=out: (
                k / WHOLE + s[k] - s[0] - 0.1 * (k == out) + 0.06 * (k / WHOLE) ** 3
            ),
            1e-9,
        )
        assert found.kind is SlopeKind.SMOOTH
        assert found.derivative == pytest.approx(1.0, rel=0.015)


def test_what_does_not_bind_changes_nothing_near_by() -> None:
    """Scatter that plans at ±2.5 % happen not to show."""
    scatter = np.random.default_rng(4).normal(0.0, 1e-5, 65)
    scatter[[0, 8, -8]] = 0.0
    found = derivative(lambda k: scatter[k] + 1e-4 * (k > 20) * k, 1e-9)
    assert found.kind is SlopeKind.SCATTER


def test_scatter_of_plans_is_within_the_bound_or_there_is_no_derivative() -> None:
    """Normal scatter of 0.1 to 3 % of the slope: those that are given are off by at most 2 %, and those of least scatter are given."""
    rng = np.random.default_rng(20)
    off, given = [], 0
    for spread in (1e-3, 3e-3, 1e-2, 3e-2):
        for _ in range(250):
            scatter = rng.normal(0.0, spread, 65)
            found = derivative(
                lambda k, scatter=scatter: k / WHOLE + scatter[k] - scatter[0], 1e-9
            ).derivative
            if found is not None:
                off.append(abs(found - 1.0))
                given += spread == 1e-3
    assert given == 250
    assert np.mean(np.array(off) < 0.02) > 0.99


def test_plans_are_doubled_where_fewer_are_not_sure() -> None:
    """Scatter of 0.7 % of the slope: most derivatives need all plans; a hopeless scatter of a third stops at nineteen."""
    rng = np.random.default_rng(5)
    asked: list[int] = []
    for spread in (7e-3, 0.3):
        counts = []
        for _ in range(60):
            scatter, places = rng.normal(0.0, spread, 65), set[int]()

            def saved(k: int, scatter: Floats = scatter, places: set[int] = places) -> float:
                places.add(k)
                return k / WHOLE + float(scatter[k] - scatter[0])

            derivative(saved, 1e-9)
            counts.append(len(places))
        asked.append(int(np.median(counts)))
    assert asked == [35, 19]


def test_what_stands_in_place_of_a_derivative_says_why() -> None:
    """A kink at the value; a limit that binds below 94 % alone; scatter of a tenth of the slope; smooth within 5 % alone."""
    rng = np.random.default_rng(3)

    def kind(saved: Callable[[float], float]) -> SlopeKind:
        return derivative(lambda k: saved(k / WHOLE), 1e-9).kind

    assert kind(lambda x: x + 0.5 * abs(x)) is SlopeKind.KINK
    assert kind(lambda x: min(x + 0.6, 0.0)) is SlopeKind.SLACK
    noisy = []
    for scatter in rng.normal(0.0, 0.1, (100, 65)):
        noisy.append(derivative(lambda k, s=scatter: k / WHOLE + s[k] - s[0], 1e-9))
    assert sum(each.kind is SlopeKind.SCATTER for each in noisy) > 95
    assert sum(abs(each.seconds - 1.0) < each.bound for each in noisy) > 95
    for odd in (lambda x: min(x, 0.6), lambda x: x + 0.05 * (x > 0.7)):
        near = derivative(lambda k, odd=odd: odd(k / WHOLE), 1e-9)
        assert near.kind is SlopeKind.SMOOTH
        assert near.derivative == pytest.approx(1.0)


def test_what_changes_nothing_has_the_derivative_zero() -> None:
    assert derivative(lambda k: 0.0, 1e-9).derivative == 0.0
    assert derivative(lambda k: 5e-11 * (abs(k) > 6) * k / WHOLE, 1e-9).derivative == 0.0


@pytest.mark.parametrize("seed", [2, 4])
def test_derivatives_agree_with_differences_of_other_plans(seed: int) -> None:
    """A small part of ``python -m trials.shortening``."""
    found = compared(seed)
    assert sum(each.slope.kind in (SlopeKind.SMOOTH, SlopeKind.ENOUGH) for each in found) >= 5
    wrong = [
        each for each in found if each.off > ASKED or not (each.true or each.slope.kind is SlopeKind.SMOOTH)
    ]
    assert [(each.name, each.slope, each.by_differences_s) for each in wrong] == []


def test_no_more_plans_are_made_where_the_error_is_a_small_part_of_the_cycle() -> None:
    """A kink, whose derivatives differ by D, and scatter a: four plans, and a bound of D/2 + 1.5 a, as the derivative may be either."""
    asked = set[int]()
    kink, scatter = 2e-3, 1e-4

    def saved(steps: int) -> float:
        asked.add(steps)
        return 0.02 * steps / WHOLE + kink * abs(steps) / WHOLE

    found = derivative(saved, 1e-9, scatter, 5e-3)
    assert asked == {0, 16, -16, 32, -32}
    assert found.kind is SlopeKind.ENOUGH
    assert found.derivative is None
    assert found.bound == pytest.approx(kink + 1.5 * scatter)
    assert derivative(saved, 1e-9, scatter, 1.7e-3).kind is SlopeKind.KINK


def test_events_that_take_another_time_need_no_plan(tmp_path: Path) -> None:
    """Beside plans: the motion of both is the same, to a period of each of three rests."""
    machine = load("generic-mill")
    (tmp_path / "a.nc").write_text("G21 G90 G64 P0.02 F3000\nT1 M6\nS6000 M3\nG1 X10\nY20\nT2 M6\nX0\nM2\n")
    program = read(tmp_path / "a.nc")
    case = Case(program.chunks, machine, PlanOptions())
    now = planned_times(case)
    waits = [each for each in quantities(case, "XYZ") if each.waits]
    assert {each.name for each in waits} == {
        f"times.{key}" for key in ("tool_change_s", "spindle_acceleration_rpm_s", "spindle_braking_rpm_s")
    }
    for quantity in waits:
        other = quantity.scaled(case, 1.1)
        one, two = waited_times(now, case, other), planned_times(other)
        assert abs(two.cycle_s - now.cycle_s) > 0.05
        assert one.cycle_s == pytest.approx(two.cycle_s, abs=3 * machine.period_s)
        for part in ("parts", "lines", "tools"):
            assert getattr(one, part) == pytest.approx(getattr(two, part), abs=3 * machine.period_s)


def test_a_rapid_at_45_degrees_has_no_derivative_to_one_axis(tmp_path: Path) -> None:
    """L/V + V/A + A/J at each axis's 1/√2 of the way: with more of X alone Y still binds, with less of X it binds itself."""
    (tmp_path / "a.nc").write_text("G21 G90 G61\nG0 X30 Y30\nG0 X0 Y0\nM2\n")
    now, found = why(tmp_path / "a.nc", load("xy-table"))
    worth = {each.name: each for each in found}
    first, opposite = worth["X jerk"].sides_s
    assert worth["X jerk"].derivative_s is None
    assert first == pytest.approx(0.0, abs=1e-5)
    assert opposite > 1e-3 * now.cycle_s
    assert worth["X jerk"].slope.kind is SlopeKind.KINK
    assert "0.0000 | " in as_text(now, found, "part.nc")
    assert "a | b: the time has a kink there" in as_text(now, found, "part.nc")


def test_times_of_the_machine_are_exact(tmp_path: Path) -> None:
    table = {"tool_change_s": 4.0, "spindle_acceleration_rpm_s": 6000.0, "pockets": 20}
    machine = replace(load("xy-table"), settings={"times": table})
    (tmp_path / "a.nc").write_text("G21 G90 F3000\nT1 M6\nS6000 M3\nG1 X10\nT2 M6\nX0\nM2\n")
    now, found = why(tmp_path / "a.nc", machine)
    worth = {each.name: each for each in found}
    assert worth["times.tool_change_s"].saved_s == pytest.approx(0.8, abs=1e-9)
    assert "times.pockets" not in worth
    assert worth["times.tool_change_s"].value == "4 s"
    assert worth["times.spindle_acceleration_rpm_s"].value == "6000 rpm/s"
    # Up once, and down before the second change: (1 s + 1 s) (1 - 1/1.1).
    assert worth["times.spindle_acceleration_rpm_s"].saved_s == pytest.approx(2 - 2 / 1.1, abs=1e-9)
    assert sum(now.tools.values()) == pytest.approx(now.cycle_s, abs=1e-9)
    assert {*now.tools} == {"–", "1", "2"}
    assert worth["times.tool_change_s"].lines[0][2] == pytest.approx(0.4, abs=1e-9)


def test_a_faster_spindle_shortens_what_it_turns(tmp_path: Path) -> None:
    """A surface speed of 400 m/min at 10 mm asks for 6366 rpm: 40 mm at 0.3 mm a turn take 120 / (2000 rpm / 60), 4 s, and 4 s / 1.1."""
    machine = replace(load("xy-table"), settings={"times": {"spindle_max_rpm": 2000.0}})
    (tmp_path / "a.nc").write_text("G21 G90\nG96 S400 M3\nG95 F0.3\nG0 X10 Y0\nG1 Y40\nM2\n")
    now, found = why(tmp_path / "a.nc", machine)
    (worth,) = (each for each in found if each.name == "times.spindle_max_rpm")
    assert (worth.value, worth.change) == ("2000 rpm", 0.1)
    # What the ramps at both ends take more is 2√(V/J), less than 1 ms.
    assert now.parts["cutting"] == pytest.approx(4.0, abs=0.04)
    assert worth.saved_s == pytest.approx(4.0 - 4.0 / 1.1, abs=2e-3)
    assert worth.slope.seconds == pytest.approx(0.4, abs=2e-3)
    assert worth.lines[0][1] == 5


def test_tables_of_times_are_changed_as_a_whole(tmp_path: Path) -> None:
    """Two coolant codes of 0.3 s and 0.2 s, and a spindle that reaches 6000 rpm in 0.8 s and stands again after as much."""
    table = {"m_codes": {"M8": 0.3, "M9": 0.2}, "spindle_ramp": [[6000, 0.8], [12000, 2.1]]}
    machine = replace(load("xy-table"), settings={"times": table})
    (tmp_path / "a.nc").write_text("G21 G90 F3000\nS6000 M3 M8\nG1 X10\nM5 M9\nM2\n")
    _, found = why(tmp_path / "a.nc", machine)
    worth = {each.name: each for each in found}
    assert worth["times.m_codes"].derivative_s == pytest.approx(0.05, abs=1e-9)
    assert worth["times.spindle_ramp"].derivative_s == pytest.approx(0.16, abs=1e-9)
    assert worth["times.m_codes"].value == "M8 0.3, M9 0.2"
    assert worth["times.spindle_ramp"].value == "2.1 at 12000 rpm"


def test_the_command_ranks_and_writes_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.nc").write_text("G21 G90 F3000\nG1 X10\nM2\n")
    assert run(["why", str(tmp_path / "a.nc"), "-m", "xy-table", "--summary", str(tmp_path / "s.json")]) == 0
    assert capsys.readouterr().out.splitlines()[3].startswith("| feed")
    values = json.loads((tmp_path / "s.json").read_text())
    saved = [each["saved_s"] for each in values["quantities"]]
    assert saved == sorted(saved, reverse=True)
    keys = "name value change derivative_s kind estimate_s bound_s sides_s saved_s lines tools"
    assert set(keys.split()) == set(values["quantities"][0])


def test_lines_of_called_files_are_named_with_their_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    called = "o<part> sub\nG1 X50 Y0\nG1 X50 Y50\nG1 X0 Y30\no<part> endsub\nM2\n"
    (tmp_path / "part.ngc").write_text(called)
    main = tmp_path / "main.ngc"
    main.write_text("G21 G90 G94 G61 F6000\nG0 X0 Y0\no<part> call\nG1 X0 Y0\nM2\n")
    assert run(["why", str(main), "-m", "xy-table"]) == 0
    feed = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("| feed"))
    # Two lines of the called file and one of the other have the same number.
    assert f" 3 of {tmp_path / 'part.ngc'}: " in feed
