"""Time by line: closed forms of a dwell and of constant speed, and sums that are the cycle time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cncgen.pipeline import plan, plan_with_summary, read, read_text
from cncgen.planner import PlanOptions
from cncgen.planner.record import Limit, Profile
from cncgen.report.line_times import LineTimes

PROGRAM = """G21 G90 G61 F600
G1 X10
G4 P0.5
G1 X20 Y1
G3 X30 Y1 I5
G3 X20 Y1 I-5
G64 P0.05
G1 X21
G1 X21 Y5
M2
"""


def gathered(text: str, feedrate: str) -> LineTimes:
    """Return the times of the lines of a program on a table."""
    times = LineTimes()
    for trajectory in plan(read_text(text), "xy-table", feedrate=feedrate):
        times.add(trajectory)
    return times


def test_constant_speed_takes_length_by_feed() -> None:
    """At a constant 10 mm/s every line takes its length / 10; the dwell its half second."""
    found = {item.line: item for item in gathered(PROGRAM.replace("G64 P0.05\n", ""), "constant").longest(20)}
    lengths = {2: 10.0, 4: np.hypot(10, 1), 5: 5 * np.pi, 6: 5 * np.pi, 7: 1.0, 8: 4.0}
    for line, length in lengths.items():
        assert found[line].length_mm == pytest.approx(length, abs=1e-9)
        assert found[line].time_s == pytest.approx(length / 10, abs=1e-9)
    assert (found[3].time_s, found[3].length_mm) == (0.5, 0.0)


@pytest.mark.parametrize("feedrate", ["optimal", "ild", "constant"])
def test_the_lines_add_up_to_the_cycle_time(feedrate: str) -> None:
    times = LineTimes()
    options = PlanOptions(feedrate=feedrate)
    stream, summary = plan_with_summary(read_text(PROGRAM), "xy-table", options, line_times=times)
    stream.collect()
    values = summary.as_json()
    assert times.total_s == pytest.approx(values["motion_time_s"] + values["dwell_time_s"], abs=1e-9)
    longest = times.longest(100)
    assert [item.time_s for item in longest] == sorted((item.time_s for item in longest), reverse=True)
    assert sum(item.length_mm for item in longest) == pytest.approx(values["path_length_mm"], abs=1e-9)


def test_a_real_part(programs: Path) -> None:
    times = LineTimes()
    stream, summary = plan_with_summary(read(programs / "bracket.nc"), "generic-mill", line_times=times)
    stream.collect()
    values = summary.as_json()
    standing = sum(values["cycle_time_split_s"][part] for part in ("tool", "spindle", "dwell"))
    assert times.total_s == pytest.approx(values["motion_time_s"] + standing, rel=1e-9)


def test_tool_changes_and_the_spindle_take_time_on_the_mill_that_ships() -> None:
    """Two changes of 4 s; 10,000 rpm at 6,000 rpm/s up and, for the second change, down; 6,000 rpm up and, by M5, down."""
    program = read_text("G21 G90 T1 M6 S10000 M3\nG1 X10 F600\nT2 M6\nS6000 M3\nG1 X0\nM5\nM2\n")
    stream, summary = plan_with_summary(program, "generic-mill")
    stream.collect()
    split = summary.as_json()["cycle_time_split_s"]
    assert split["tool"] + split["spindle"] == pytest.approx(2 * 4.0 + 2 * 10.0 / 6.0 + 2 * 1.0, abs=1e-9)
    assert split["dwell"] == 0.0


def test_lines_of_one_time_stand_in_the_order_of_the_program() -> None:
    """Four lines of a second each: the first two of them come first, and none of the events between them takes time."""
    times = gathered(
        "G21 G90 G61 F600\n" + "".join(f"M3 S{k}\nG1 X{10 * k}\n" for k in (1, 2, 3, 4)) + "M2\n", "constant"
    )
    assert times.lines == 4
    assert [item.line for item in times.longest(3)] == [3, 5, 7]


def test_a_wait_that_is_no_dwell_is_time_of_its_line() -> None:
    """A standing piece that a strategy puts in for another reason than an event is motion of the row; a dwell is not."""
    (whole,) = plan(read_text("G21 G90 G61 F600\nG1 X10\nX20\nM2\n"), "xy-table", feedrate="constant")
    for limit, waited in ((Limit.STOP, 0.0), (Limit.SATURATION, 0.25)):
        v, still = np.array([10.0, 0.0, 10.0]), np.zeros(3)
        profile = Profile(
            np.array([0.0, 0.5, 0.75, 2.25]), np.array([0.0, 5.0, 5.0, 20.0]), v, still, still, still,
            np.array([Limit.FEED, limit, Limit.FEED], np.int8),
        )  # fmt: skip
        times = LineTimes()
        times.add(replace(whole, profile=profile))
        found = {item.line: item.time_s for item in times.longest(5)}
        assert found == pytest.approx({2: 1.0 + waited, 3: 1.0})
