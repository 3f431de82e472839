"""Rows that the program asks to take their time on next to no way: they take it, and what is around them loses none."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cncgen.machine import Axis, Machine, load
from cncgen.pipeline import read_text
from cncgen.planner import PlanOptions, plan
from cncgen.planner.least_time import block_planning
from cncgen.planner.least_time.crawling import crawling, paced
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.limits.speeds import Feeds
from cncgen.planner.motion import motion_at
from cncgen.planner.record import Trajectory
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import FeedMode, PathMode, Toolpath

MACHINE = load("generic-mill")
#: From rest to 10 mm/s and back at 50,000 mm/s³, which does not reach the acceleration limit: 2 √(v/J) more than L/v.
STOP = 2.0 * math.sqrt(10.0 / 5e4)


def planned(body: str, mode: str = "G61", machine: Machine = MACHINE) -> list[Trajectory]:
    return list(plan(read_text(f"G21 G90 {mode} G93\n{body}\nM2\n").chunks(), machine, PlanOptions()))


def time_of(body: str, mode: str = "G61") -> float:
    return float(planned(body, mode)[-1].profile.t[-1])


def rows_of(body: str) -> Toolpath:
    (chunk,) = [each for each in read_text(f"G21 G90 {body}\nM2\n").chunks() if len(each)]
    return replace(chunk, tolerance=np.where(np.isnan(chunk.tolerance), 0.01, chunk.tolerance))


@pytest.mark.parametrize("mode", ["G61", "G61.1", "G64 P0.01"])
@pytest.mark.parametrize("way", ["X{:.7f}", "X10 Y{:.7f}", "X10 A{:.7f}"])
@pytest.mark.parametrize("length", [1e-7, 1e-6, 1e-4, 5e-3])
def test_a_row_takes_its_programmed_time_however_short(mode: str, way: str, length: float) -> None:
    """A second of motion, a minute of next to none, a second: as long as each of them from rest to rest."""
    row = way.format(length + (10.0 if way[1] == "{" else 0.0))
    asked = 1.0 + 60.0 + 1.0
    assert time_of(f"G1 X10 F60\n{row} F1\nX20 F60", mode) == pytest.approx(asked + 2 * STOP, abs=1e-3)


@pytest.mark.parametrize(
    ("body", "asked"),
    [
        ("G1 X0.0000001 F1\nX10 F60", 61.0 + STOP),
        ("G1 X10 F60\nX10.0000001 F1", 61.0 + STOP),
        ("G1 X0.0000001 F1", 60.0),
        ("G1 X0.0000001 F1\nY0.0000001 F2", 90.0),
        ("G1 A10 F60\nA10.0000001 F1\nA10.0000002 F2\nX10 F60", 92.0 + 2.0 * math.sqrt(10.0 / 2e4) + STOP),
        ("G1 X10 F60\nY0.0000001 F1\nX10.0000001 F2\nY0.0000002 F3\nX20 F60", 112.0 + 2 * STOP),
        ("G1 X10 F60\nG94 X10.000001 F0.0001\nG93 X20 F60", 2.6 + 2 * STOP),
    ],
)
def test_such_rows_add_up_at_either_end_and_under_slow_feeds(body: str, asked: float) -> None:
    """What turns 10 degrees a second needs 2 √(v/J) more at 20,000 °/s³."""
    assert time_of(body) == pytest.approx(asked, abs=1e-3)


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_it_does_not_matter_at_which_row_a_block_ends(rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    body = "G1 X10 F60\nY0.0000001 F1\nX10.0000001 F2\nX20 Y0.001 F60\nX30 F60"
    whole = time_of(body)
    for size in ("FIRST", "MOST"):
        monkeypatch.setattr(block_planning, size, 4 * rows)
    assert time_of(body) == pytest.approx(whole, abs=0.01)


def test_lines_of_the_program_have_their_time() -> None:
    """The profile moves within the short row for a minute, so that time and place name its line."""
    profile = planned("G1 X10 F60\nX10.0000001 F1\nX20 F60")[0].profile
    inside = (profile.s[:-1] >= 10.0 - 1e-12) & (profile.s[1:] <= 10.0000001 + 1e-12)
    assert np.diff(profile.t)[inside].sum() == pytest.approx(60.0, abs=1e-3)


def test_a_way_within_rounding_takes_no_time() -> None:
    """0.1 + 0.2 − 0.2 is 0.1 but for its last digit: a doubled point, not a motion of a minute."""
    assert time_of("G1 X0.1 F60\nX[0.1+0.2-0.2] F1\nX1 F60") < 2.1


def test_setpoints_of_what_crawls_hold_the_limits() -> None:
    body = (
        "G1 X10 F60\n"
        + "\n".join(f"Y{0.0001 * k:.4f} A{0.01 * k:.2f} F20" for k in range(1, 4))
        + "\nX20 F60"
    )
    (part,) = planned(body)
    t = np.arange(-3, int(part.profile.t[-1] / 1e-3) + 4) * 1e-3
    x = part.toolpath.path.evaluate(motion_at(part.profile, np.clip(t, 0.0, None)).s, 0)[0]
    jerk = np.abs(np.diff(x, 3, axis=0)).max(axis=0) / 1e-9
    limit = [MACHINE.axes[letter].max_jerk for letter in part.toolpath.axes]
    assert np.all(jerk <= 1.001 * np.array(limit) + 1e-2)


@pytest.mark.parametrize("seed", [1, 3, 5])
def test_a_crawling_curve_turns_back_without_loss_where_rounding_parts_knots_from_cusps(seed: int) -> None:
    """It has no more to do than its way, told by its doubled control points, at the feed; about cusps it took up to 86 times that."""
    rng = np.random.default_rng(seed)
    turns = np.round(rng.uniform(-2e-4, 2e-4, size=21), 6)
    points = np.repeat(np.append(0.0, turns), 2)
    knots = [0.0] * 3 + np.sort(rng.uniform(size=len(points) - 3)).tolist()
    curve = "\n".join(f"K{k:.9f} X{x:.6f} R1" for k, x in zip(knots, points, strict=True)) + "\nK1" * 3
    program = f"G21 G90 G61 G94\nG1 X0 F0.01\nG6.2 P3 {curve}\nM2\n"
    read = read_text(program, options=ReadOptions(dialect="linuxcnc"))
    done = list(plan(read.chunks(), MACHINE, PlanOptions()))
    way = float(np.abs(np.diff(turns, prepend=0.0)).sum())
    assert done[-1].profile.t[-1] == pytest.approx(60.0 * way / 0.01, rel=2e-3)


@pytest.mark.parametrize("radius", [5e-3, 1e-2, 0.1])
def test_crawling_arcs_lose_nothing_at_their_ends(radius: float) -> None:
    """A thousandth of their time at most: setpoints every 10 ms tell 60 µm apart, and they took up to 19 % longer."""
    coarse = {letter: replace(MACHINE.axes[letter], max_acceleration=1e5, max_jerk=3e6) for letter in "XYZ"}
    machine = replace(MACHINE, axes=coarse, period_s=1e-2)
    arcs = "\n".join(f"G3 X{2 * k * radius:.3f} Y0 I{radius} J0" for k in (1, 2, 3))
    *_, last = plan(read_text(f"G21 G90 G61 F2.4\n{arcs}\nM2\n").chunks(), machine, PlanOptions())
    assert last.profile.t[-1] == pytest.approx(3.0 * np.pi * radius / 0.04, rel=1e-3)


def test_what_crawls_is_told_by_speed_and_time() -> None:
    """J T² is 0.05 mm/s, a fiftieth of it 0.06 mm/min; a row must last 2000 times √(v/J) to begin and end at rest."""
    chunk = rows_of("G61 G94 F0.059\nG1 X1\nF0.061 X2\nF0.03 X2.0002\nX2.00021")
    path = chunk.path
    found = crawling(path, Feeds.of(chunk).speed, AxisLimits.of(MACHINE, chunk.axes))
    # √(v/J) is 0.1 ms: in 2000 of them the last two rows come 0.1 µm far.
    assert found.tolist()[:4] == [True, False, True, False]
    assert not crawling(path, np.full(len(chunk), np.inf), AxisLimits.of(MACHINE, chunk.axes)).any()
    # Where jerk has no limit to speak of, acceleration tells: 0.03 mm/s is a hundredth of A T.
    stiff = replace(MACHINE, axes={k: replace(axis, max_jerk=1e9) for k, axis in MACHINE.axes.items()})
    quick = rows_of("G61 G94 F2\nG1 X1\nF4 X2\nF600 X20000")
    path = quick.path
    found = crawling(path, Feeds.of(quick).speed, AxisLimits.of(stiff, quick.axes))
    assert found.tolist()[:3] == [True, False, False]


def test_more_acceleration_meets_no_slow_rows_exactly() -> None:
    """A zigzag at 0.02 mm/s is cut within P. With three times the acceleration its rows crawl; met exactly they took 1.3 times as long."""
    rows = "\n".join(f"G1 X{0.08 * (k // 2 + k % 2):.2f} Y{0.05 * (k // 2 % 2):.2f}" for k in range(1, 9))
    program = f"G21 G90 G64 P0.064 F1.18\n{rows}\nM2\n"
    times = []
    for acceleration in (760.0, 2280.0):
        axes = {"X": Axis("X", 1.1, acceleration, 4.5e6), "Y": Axis("Y", 1.1, 760.0, 4.5e6)}
        machine = Machine("slow", axes, 0.00047, 0.001, 0.002)
        times.append(list(plan(read_text(program).chunks(), machine, PlanOptions()))[-1].profile.t[-1])
    assert times[1] <= 1.001 * times[0]


def test_rows_that_crawl_do_so_under_a_cap_too() -> None:
    """Bounded contour errors are planned again and again under caps of the speed (once half as long again)."""
    machine = load("xy-table")
    body = "G21 G90 G61 G93\nG1 X10 F60\nY0.0000001 F10\nX20 F60\nM2\n"
    times = [
        list(plan(read_text(body).chunks(), machine, PlanOptions(max_contour_error_mm=bound)))[-1].profile.t[
            -1
        ]
        for bound in (None, 0.01)
    ]
    assert times[0] == pytest.approx(8.0 + 2 * STOP, abs=1e-3)
    assert times[0] <= times[1] < times[0] + 0.05


def test_paced_rows_have_speeds_and_short_crawling_ones_are_met() -> None:
    chunk = rows_of("G64 P0.01 G93\nG1 X10 F60\nX10.001 F1\nX20 F30\nG94 X21 F600\nX22 F0.01")
    (out,) = paced([chunk], lambda axes: AxisLimits.of(MACHINE, axes))
    assert out.feed_mode[:5].tolist() == [FeedMode.SPEED, FeedMode.INVERSE_TIME, *[FeedMode.SPEED] * 3]
    np.testing.assert_allclose(out.feed[:5], [10.0, 1.0 / 60.0, 9.999 / 2.0, 10.0, 0.01 / 60.0], rtol=1e-12)
    # The last one is long beside the tolerance, and has its own part of every curve.
    met = out.path_mode == PathMode.EXACT_PATH
    assert met.tolist()[:5] == [False, True, False, False, False]
    quick = rows_of("G64 P0.01 G94\nG1 X10 F600\nX10.001")
    assert next(paced([quick], lambda axes: AxisLimits.of(MACHINE, axes))) is quick
