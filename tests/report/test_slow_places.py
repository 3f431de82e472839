"""Where time is lost: valleys of a speed that is made by hand, with known losses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cncgen.machine import load_machine
from cncgen.pipeline import plan, read_text
from cncgen.planner import PlanOptions
from cncgen.planner.motion import motion_at
from cncgen.planner.record import Limit, Profile, Trajectory
from cncgen.report.slow_places import KEPT, SlowPlaces
from cncgen.toolpath.record import FeedMode

#: Lines of 10 mm at 10 mm/s, one a row from line 2 on.
COUNT = 13


def trajectory(losses: list[float], rapid: bool = False) -> Trajectory:
    """Each row: half of it at 10 mm/s, half at 2 mm/s that takes the row's loss longer than the feed would."""
    word = "G0" if rapid else "G1"
    text = "G21 G90 F600\n" + "".join(f"{word} X{10 * (k + 1)}\n" for k in range(len(losses))) + "M2\n"
    (toolpath,) = read_text(text).chunks()
    pieces = 2 * len(losses)
    time = np.full(pieces, 0.5)
    time[1::2] += losses
    v = np.where(np.arange(pieces) % 2, 2.0, 10.0)
    limit = np.where(np.arange(pieces) % 2, Limit.JERK, Limit.FEED).astype(np.int8)
    zero = np.zeros(pieces)
    profile = Profile(
        np.concatenate([[0.0], np.cumsum(time)]), 5.0 * np.arange(pieces + 1.0), v, zero, zero, zero, limit
    )
    row_s = np.append(10.0 * np.arange(len(losses) + 1.0), 10.0 * len(losses))
    return Trajectory(toolpath, row_s[: len(toolpath) + 1], profile)


def test_the_worst_twenty_with_line_place_and_limit() -> None:
    losses = [0.1 + 0.01 * ((5 * k) % COUNT) for k in range(COUNT)]
    slow = SlowPlaces(500.0)
    slow.add(trajectory(losses))
    found = slow.worst()
    order = sorted(range(COUNT), key=lambda k: -losses[k])[:20]
    assert KEPT == 20
    assert [place.line for place in found] == [k + 2 for k in order]
    assert [place.lost_s for place in found] == pytest.approx([losses[k] for k in order], abs=1e-12)
    # Each row becomes slow in its middle.
    assert [place.s_mm for place in found] == [10.0 * k + 5.0 for k in order]
    # Lines of 10 mm along X: the length is the position.
    assert [place.position[0] for place in found] == pytest.approx([place.s_mm for place in found], abs=1e-9)
    assert {place.source for place in found} == {"program"}
    assert [place.t_s for place in found] == pytest.approx(
        [k + 0.5 + sum(losses[:k]) for k in order], abs=1e-12
    )
    assert {(place.feed_mm_s, place.limit) for place in found} == {(2.0, Limit.JERK)}


def test_rapids_lose_against_the_machine_s_own_speed() -> None:
    """10 mm at 100 mm/s would take 0.1 s; the row takes 1.2 s."""
    slow = SlowPlaces(100.0)
    slow.add(trajectory([0.2], rapid=True))
    (place,) = slow.worst()
    assert place.lost_s == pytest.approx(1.1, abs=1e-12)


def test_no_loss_is_no_place() -> None:
    slow = SlowPlaces(100.0)
    slow.add(trajectory([0.0, 0.0]))
    assert slow.worst() == []


def test_a_place_is_where_and_when_the_motion_is_as_slow_as_it_says() -> None:
    """Time, path and speed are those of one instant of the plan: rests, too, at both ends and in the corners."""
    program = read_text("G21 G90 G61 F6000\nG1 X40\nY20\nX0 Y20.5\nG2 X5 Y25.5 I5\nG1 X30\nM2\n")
    slow, plans = SlowPlaces(500.0), list(plan(program, "xy-table"))
    for each in plans:
        slow.add(each)
    found = sorted(slow.worst(), key=lambda place: place.t_s)
    (profile,) = (each.profile for each in plans)
    there = motion_at(profile, np.array([place.t_s for place in found]))
    assert there.v == pytest.approx([place.feed_mm_s for place in found], abs=1e-6)
    assert there.s == pytest.approx([place.s_mm for place in found], abs=1e-9)
    rests = sorted(place.s_mm for place in found if place.feed_mm_s < 1e-6)
    # From rest, after 40 and 60 mm, after a line of √(40² + ½²) mm, and, an arc of 5 mm and 25 mm later, the end.
    long = 60.0 + np.hypot(40.0, 0.5)
    assert rests == pytest.approx([0.0, 40.0, 60.0, long, long + 2.5 * np.pi + 25.0], abs=1e-6)


def test_slow_feeds_are_feeds() -> None:
    """12 mm/min: the motion loses what it takes longer than its own feed, and not than the machine's rapid."""
    program = read_text("G21 G90 G61 F12\nG1 X0.1\nM2\n")
    slow = SlowPlaces(500.0)
    for each in plan(program, "xy-table"):
        slow.add(each)
    assert sum(place.lost_s for place in slow.worst()) < 0.02


def test_an_inverse_time_feed_asks_for_the_time_of_its_row() -> None:
    """10 mm in 1/0.5 s at G93 F30: the row of 3.2 s loses 1.2 s, whatever a speed of 0.5 would take."""
    whole = trajectory([2.2])
    inverse = replace(
        whole.toolpath,
        feed=np.full(len(whole.toolpath), 0.5),
        feed_mode=np.full(len(whole.toolpath), FeedMode.INVERSE_TIME, np.int8),
    )
    slow = SlowPlaces(500.0)
    slow.add(replace(whole, toolpath=inverse))
    (place,) = slow.worst()
    assert place.lost_s == pytest.approx(1.2, abs=1e-12)


@pytest.mark.parametrize("effort", ["best", "fast"])
def test_a_place_names_the_axis_whose_limit_holds_it_back(effort: str) -> None:
    """A line along one axis needs nothing of the others, so its ends are held by that axis; Y then has a tenth of X's jerk."""
    machine = load_machine("xy-table")
    slower = {**machine.axes, "Y": replace(machine.axes["Y"], max_jerk=machine.axes["X"].max_jerk / 10)}
    slow = SlowPlaces(500.0, slower)
    program = read_text("G21 G90 G61 F6000\nG1 X40\nY20\nX60 Y40\nM2\n")
    for each in plan(program, replace(machine, axes=slower), PlanOptions(effort=effort)):
        slow.add(each)
    found = sorted(slow.worst(), key=lambda place: place.t_s)
    # The first line does not move Y, so the place between it and the second is that of the second.
    assert [place.line for place in found[:2]] == [2, 3]
    assert [(place.axis, place.limit) for place in found] == [
        ("X", Limit.JERK),
        ("Y", Limit.JERK),
        ("Y", Limit.JERK),
        ("Y", Limit.JERK),
    ]


def test_a_limit_that_no_axis_comes_near_has_no_axis() -> None:
    """The hand-made trajectories stand still in jerk; a machine without axes has none to name."""
    for axes in ({}, load_machine("xy-table").axes):
        slow = SlowPlaces(500.0, axes)
        slow.add(trajectory([0.2]))
        assert [place.axis for place in slow.worst()] == [""]


def test_what_lies_between_two_limits_is_lost_to_them() -> None:
    """A row whose slow half is held by the jerk at its start, and at no limit while the jerk changes its sign."""
    one = trajectory([0.2])
    p = one.profile
    halves = {name: np.append(getattr(p, name), getattr(p, name)[-1]) for name in ("v", "a", "j", "c")}
    p = replace(
        p,
        t=np.array([0.0, p.t[1], p.t[1] + 0.3, p.t[2]]),
        s=np.array([0.0, p.s[1], p.s[1] + 2.0, p.s[2]]),
        limit=np.array([Limit.FEED, Limit.JERK, Limit.NONE], np.int8),
        **halves,
    )
    slow = SlowPlaces(500.0)
    slow.add(replace(one, profile=p))
    assert [place.limit for place in slow.worst()] == [Limit.JERK]
