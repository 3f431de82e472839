"""The summary of a plan: closed forms of motions at constant speed, and hand-made stages with known figures."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cncgen.diagnostics import Diagnostic
from cncgen.machine import load_machine
from cncgen.machine.record import Machine
from cncgen.pipeline import plan_with_summary, read_text
from cncgen.planner import PlanOptions
from cncgen.planner.record import Limit, Profile, SharpCorner, Trajectory
from cncgen.report import summary as summary_module
from cncgen.report.summary import Summary, _top_speeds, as_text
from cncgen.setpoints.record import Setpoints

ONE_LINE = "G21 G90 G61 F600\nG1 X10\nM2\n"


def summed(text: str, machine: str = "xy-table", feedrate: str = "constant") -> dict[str, Any]:
    """Plan a program to its end and return its summary."""
    stream, summary = plan_with_summary(read_text(text), machine, PlanOptions(feedrate=feedrate))
    stream.collect()
    return summary.as_json()


def one_line(machine: Machine | None = None) -> tuple[Summary, Trajectory]:
    """Return an empty summary of a line of 10 mm, and a trajectory that travels it in 1 s."""
    program = read_text(ONE_LINE)
    (toolpath,) = program.chunks()
    still = np.zeros(1)
    profile = Profile(
        np.array([0.0, 1.0]), np.array([0.0, 10.0]), still + 10.0, still, still, still,
        np.array([Limit.FEED], np.int8),
    )  # fmt: skip
    row_s = np.full(len(toolpath) + 1, 10.0)
    row_s[0] = 0.0
    return Summary(program, machine or load_machine("xy-table"), "mine"), Trajectory(toolpath, row_s, profile)


def finished(summary: Summary, *trajectories: Trajectory, rows: int = 1) -> dict[str, Any]:
    """Draw hand-made trajectories, and setpoints at rest, through a summary."""
    list(summary.over_trajectories(trajectories))
    list(summary.over_setpoints([Setpoints("X", 0.001, 0, np.zeros((rows, 1)))]))
    return summary.as_json()


#: Speed that Z of generic-mill comes to from rest to rest over a way of `d` mm: (d/2)^(2/3) J^(1/3), while it is below A²/J.
def _peak_mm_s(way_mm: float) -> float:
    return (0.5 * way_mm) ** (2.0 / 3.0) * 50_000.0 ** (1.0 / 3.0)


@pytest.mark.parametrize("feedrate", ["optimal", "ild"])
def test_threads_that_do_not_come_to_their_speed(feedrate: str) -> None:
    """1000 rev/min at 2 mm are 33.33 mm/s: a millimetre is too short for them, ten are not; a rigid tap's spindle follows."""
    text = "G21 G90 G61.1 S1000 M3\nG33 Z-10 K2\nG0 Z0\nG33 Z-1 K2\nG0 Z0\nG33.1 Z-1 K2\nM2\n"
    found = [d for d in summed(text, "generic-mill", feedrate)["diagnostics"] if d["code"] == "thread-speed"]
    assert [(d["line"], d["severity"]) for d in found] == [(4, "warning")]
    for d in found:
        assert d["values"]["pitch_mm"] == 2.0
        assert d["values"]["feed_mm_s"] == pytest.approx(100.0 / 3.0)
        assert d["values"]["reached_mm_s"] == pytest.approx(_peak_mm_s(1.0), rel=2e-3)


def test_whose_feed_it_is_where_rotary_axes_turn_along() -> None:
    """A turn of C under G93 takes 2 s along 10 mm: 5 mm/s are those of the slide, and the tool's on a turning part are others."""
    along = summed("G21 G90 G61 G93\nG1 X10 C90 F30\nM2\n", "generic-mill")
    assert along["feed_of"] == "slides"
    assert along["feed_mm_s"]["mean"] == pytest.approx(5.0)
    assert (
        "feed of the slides X (the tool's on the workpiece is another while rotary axes turn along)"
        in as_text(along)
    )
    after = summed("G21 G90 G61 G94 F600\nG1 X10\nG1 C90\nM2\n", "generic-mill")
    assert after["feed_of"] == "path"
    assert "feed: mean" in as_text(after)


def test_times_and_feeds_of_constant_speed() -> None:
    """20 mm at 10 mm/s and half a second of dwell; steps of speed ask v/T of acceleration and v/T² of jerk."""
    found = summed("G21 G90 G61 F600\nG1 X10\nG4 P0.5\nG1 X20\nM2\n")
    assert found["motion_time_s"] == pytest.approx(2.0, abs=1e-12)
    assert found["dwell_time_s"] == pytest.approx(0.5, abs=1e-12)
    assert found["path_length_mm"] == pytest.approx(20.0, abs=1e-12)
    assert found["feed_mm_s"] == pytest.approx({"mean": 10.0, "max": 10.0}, abs=1e-9)
    assert (found["motions"], found["samples"], found["period_s"]) == (2, 2501, 0.001)
    peak = found["peak"]["x"]
    assert peak["unit"] == "mm"
    assert peak["velocity"] == pytest.approx(10.0, rel=1e-6)
    assert peak["acceleration"] == pytest.approx(10.0 / 1e-3, rel=1e-6)
    assert peak["jerk"] == pytest.approx(10.0 / 1e-6, rel=1e-6)
    for name, limit in (("velocity", 250.0), ("acceleration", 2450.0), ("jerk", 50_000.0)):
        assert peak[f"{name}_of_limit"] == pytest.approx(peak[name] / limit, rel=1e-12)
    (remark,) = found["diagnostics"]
    assert remark["code"] == "plan-over-limits"
    assert "constant asks more" in remark["message"]
    assert "X acceleration 408.2 %, X jerk 2e+04 % of the limit" in remark["message"]
    assert "velocity" not in remark["message"]


def test_turning_is_no_length_and_its_time_is_not_that_of_the_feed() -> None:
    """10 mm in 1 s and 36° at 6°/s: the mean feed is that of the second alone."""
    found = summed("G21 G90 G61\nG1 X10 F600\nG1 A36 F360\nM2\n", "generic-mill")
    assert found["motion_time_s"] == pytest.approx(7.0, abs=1e-9)
    assert found["path_length_mm"] == pytest.approx(10.0, abs=1e-9)
    assert found["feed_mm_s"] == pytest.approx({"mean": 10.0, "max": 10.0}, abs=1e-9)
    assert found["peak"]["a"]["unit"] == "deg"
    assert found["peak"]["a"]["velocity"] == pytest.approx(6.0, rel=1e-6)
    # Without a millimetre there is no feed at all.
    assert summed("G1 A36 F360\nM2\n", "generic-mill")["feed_mm_s"] == {"mean": 0.0, "max": 0.0}


def test_only_events_are_dwells() -> None:
    """A wait that a strategy puts in for another reason than an event is time of the motion."""
    summary, trajectory = one_line()
    v, still = np.array([10.0, 0.0, 0.0, 10.0]), np.zeros(4)
    limit = np.array([Limit.FEED, Limit.STOP, Limit.SATURATION, Limit.STOP], np.int8)
    t, s = np.array([0.0, 0.5, 0.75, 1.25, 1.75]), np.array([0.0, 5.0, 5.0, 5.0, 10.0])
    found = finished(summary, replace(trajectory, profile=Profile(t, s, v, still, still, still, limit)))
    assert (found["motion_time_s"], found["dwell_time_s"]) == (1.5, 0.25)


def test_a_plan_within_its_limits_has_no_remark() -> None:
    assert summed(ONE_LINE, feedrate="optimal")["diagnostics"] == []


@pytest.mark.parametrize(("excess", "told"), [(3_900.0, False), (4_100.0, True)])
def test_what_rounding_makes_of_a_difference_is_no_broken_limit(excess: float, told: bool) -> None:
    """Setpoints rounded to 1e-9 mm err by 0.5e-9 (2/T)³ in jerk: 4000 mm/s³ every 0.1 ms, of a limit of 50000."""
    machine = replace(load_machine("xy-table"), period_s=1e-4)
    summary, _ = one_line(machine)
    # Acceleration in steps: on, off, on the other way, off; each step is one third difference of J T³.
    steps = np.repeat([0.0, 1.0, 0.0, -1.0, 0.0], [3, 40, 1, 40, 3]) * (50_000.0 + excess) * 1e-12
    position = np.cumsum(np.cumsum(steps))
    list(summary.over_setpoints([Setpoints("X", 1e-4, 0, position[:, None])]))
    assert summary.as_json()["peak"]["x"]["jerk"] == pytest.approx(50_000.0 + excess, rel=1e-6)
    assert [item.code for item in summary.remarks] == ["plan-over-limits" if told else "plan-rounding"]


def test_what_a_strategy_says_beside_is_handed_on() -> None:
    """Plain values go into the summary; arrays do not; corners beyond the listed ones are counted; remarks gathered."""
    summary, trajectory = one_line()
    corner = SharpCorner(2, (10.0, 20.0, 30.0), 5.0, Limit.CONTOUR_ERROR, 0.25)
    remark = Diagnostic("mine", "said")
    values = {"passes": 3, "kind": "k", "whole": True, "none": None, "shape": np.zeros(2),
              "corners_total": 7, "diagnostics": [remark]}  # fmt: skip
    found = finished(summary, replace(trajectory, corners=(corner,), values=values))
    assert {k: found[k] for k in ("passes", "kind", "whole", "none")} == {
        "passes": 3, "kind": "k", "whole": True, "none": None,
    }  # fmt: skip
    assert not {"shape", "corners_total"} & set(found)
    assert found["sharp_corner_count"] == 7
    # The axes that the program moves: X alone.
    assert found["sharp_corners"] == [
        {"line": 2, "position": {"x_mm": 10.0}, "feed_mm_s": 5.0, "limit": "contour_error", "t_s": 0.25}
    ]
    assert [item["code"] for item in found["diagnostics"]] == ["mine"]


def test_corners_are_counted_beyond_those_that_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(summary_module, "MAX_CORNERS", 3)
    summary, trajectory = one_line()
    corners = tuple(SharpCorner(k, (0.0,), 1.0, Limit.CORNER, 0.0) for k in range(2))
    found = finished(summary, *[replace(trajectory, corners=corners)] * 3)
    assert found["sharp_corner_count"] == 6
    assert [corner["line"] for corner in found["sharp_corners"]] == [0, 1, 0]


def test_corners_that_a_plan_counts_before_it_hands_them_on_are_counted_once() -> None:
    """Planned windows are handed on in parts: the first part has the number of them all, later ones have none."""
    summary, trajectory = one_line()
    corners = tuple(SharpCorner(k, (0.0,), 1.0, Limit.CORNER, 0.0) for k in range(5))
    first = replace(trajectory, corners=corners[:1], values={"corners_total": 5})
    found = finished(summary, first, replace(trajectory, corners=corners[1:]))
    assert found["sharp_corner_count"] == len(found["sharp_corners"]) == 5


def test_lengths_of_stretches_add_up_and_the_time_is_that_of_the_last() -> None:
    summary, trajectory = one_line()
    profile = trajectory.profile
    later = replace(trajectory, profile=replace(profile, t=profile.t + 1.0, v=0.5 * profile.v))
    found = finished(summary, trajectory, later)
    assert (found["motion_time_s"], found["path_length_mm"]) == (2.0, 20.0)
    assert found["feed_mm_s"] == {"mean": 10.0, "max": 10.0}


@given(st.floats(0.01, 5.0), st.floats(0.0, 50.0), st.floats(-40.0, 40.0), st.floats(-60.0, 60.0))
def test_the_largest_speed_of_a_piece(time: float, v: float, a: float, j: float) -> None:
    """v + a t + j t²/2 by dense samples, wherever it is not largest where the next piece begins."""
    t = np.linspace(0.0, time, 4001)
    speed = v + a * t + 0.5 * j * t**2
    between = abs(j) * (t[1] - t[0]) ** 2 / 8.0 + 1e-9
    assume(speed.max() > speed[-1] + between)
    one = np.ones(1)
    profile = Profile(
        np.array([0.0, time]), np.zeros(2), v * one, a * one, j * one, 0 * one, np.zeros(1, np.int8)
    )
    assert _top_speeds(profile)[0] == pytest.approx(speed.max(), abs=between)


def test_how_much_of_a_program_is_planned() -> None:
    """By the line that the plan has come to; a loop leads back, and then by the length of the path."""
    options = PlanOptions(feedrate="constant")
    lines = "".join(f"G1 X{k % 2} F6000\n" for k in range(400))
    stream, summary = plan_with_summary(read_text(f"G21 G90\n{lines}M2\n"), "generic-mill", options)
    assert summary.done() is None or summary.done() == 0.0
    for _ in stream.chunks:
        pass
    assert summary.done() == pytest.approx(402 / 404, abs=2 / 404)
    rounded = "".join(
        f"G1 X{50 * np.sin(0.01 * k):.4f} Y{50 * np.cos(0.0137 * k):.4f}\n" for k in range(3000)
    )
    stream, summary = plan_with_summary(
        read_text(f"G21 G90 G17 G64 P0.01\nF3000\n{rounded}M2\n"), "xy-table", PlanOptions()
    )
    for _ in stream.chunks:
        pass
    assert summary.done() == pytest.approx(1.0, abs=2 / 3000)
    loop = "G21 G91 F6000\no1 repeat [9000]\nG1 X1\nG1 X-1\no1 endrepeat\nM2\n"
    stream, summary = plan_with_summary(read_text(loop), "generic-mill", options)
    found = [(chunk.first + len(chunk) - 1, summary.done()) for chunk in stream.chunks]
    # At 0.1 mm a setpoint; the plan is ahead of the setpoints.
    assert all(done is not None and done >= row * 0.1 / 18000.0 - 1e-9 for row, done in found)
    assert found[0][1] == pytest.approx(0.91, abs=0.05)
    assert summary.done() == pytest.approx(1.0, abs=1e-9)


def test_a_motion_of_some_micrometres_is_told_in_its_digits() -> None:
    """40 µm at 1 µm/s: with two decimals the feed would be 0.01 or 0.00 mm/s, and every place X0.000."""
    program = read_text("G21 G90 G61\nG1 X0.00125 F0.06\nX0.0413\nM2\n")
    stream, summary = plan_with_summary(program, load_machine("flexure-stage"))
    for _ in stream:
        pass
    text = as_text(summary.as_json())
    assert "max 0.001 mm/s" in text
    assert re.search(r"0\.\d ms lost at line 3, X0\.041300", text)
    assert ": none" not in text
