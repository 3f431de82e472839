"""Where no window is solved: a stop where the motion crawls anyway, and at last a creep that holds every limit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cncgen
from cncgen.planner.least_time import problem, rolling_window
from cncgen.planner.least_time.mesh import SPLINE
from cncgen.planner.least_time.problem import Intervals, Solution, slopes, solve
from cncgen.planner.least_time.time_scaling import obstacle, time_scaled
from cncgen.setpoints import sample
from tests.planner.least_time.test_least_time_kernel import wave


def kinked(at: int, jerk: float) -> Intervals:
    """Return a wave of whose intervals one has an x''' as beside a cusp."""
    given = wave(40)
    x3 = given.x3.copy()
    x3[at, 1:] = jerk
    return replace(given, x3=x3)


def dense(given: Intervals, found: Solution) -> tuple[float, float]:
    """Return the largest parts of the limits of acceleration and jerk at 1001 places of intervals of constant jerk."""
    acceleration, jerk = [], []
    spline = np.flatnonzero(given.kind == SPLINE)
    before, after = slopes(given.h, found.q, np.where(given.kind == SPLINE, found.way, 0.5 * given.h))
    for k in spline:
        h, v, a, gain = given.h[k], np.sqrt(found.q[k, 0]), before[k], after[k] - before[k]
        # h = (v₀ + v₁) T/2 − (a₁ − a₀) T²/12.
        mean = 0.5 * (v + np.sqrt(found.q[k, 2]))
        time = min(x.real for x in np.roots([-gain / 12.0, mean, -h]) if x.real > 0.0)
        t = np.linspace(0.0, time, 1001)
        along = gain / time
        speed, slope = v + (a + 0.5 * along * t) * t, a + along * t
        u = (v + (0.5 * a + along * t / 6.0) * t) * t / h
        assert u[-1] == pytest.approx(1.0, rel=1e-9)
        assert speed[-1] ** 2 == pytest.approx(found.q[k, 2], rel=1e-9)
        for axis, (most, most_jerk) in enumerate(given.limits.T):
            x1, x2, x3 = (
                np.polyval(np.polyfit([0.0, 0.5, 1.0], x[k, :, axis], 2), u)
                for x in (given.x1, given.x2, given.x3)
            )
            acceleration.append(np.abs(x2 * speed**2 + x1 * slope).max() / most)
            jerk.append(np.abs((x3 * speed**2 + 3.0 * x2 * slope) * speed + x1 * along).max() / most_jerk)
    return max(acceleration), max(jerk)


@pytest.mark.parametrize("jerk", [0.0, 1e6, 1e14])
def test_a_creep_holds_every_limit(jerk: float) -> None:
    given = kinked(20, jerk)
    found = time_scaled(given)
    acceleration, jerks = dense(given, found)
    assert max(acceleration, jerks) <= 1.0
    # Of what holds it back it uses most.
    assert max(acceleration, jerks ** (2.0 / 3.0)) > 0.7
    assert (found.q.max(axis=1) <= given.top.min(axis=1)).all()


def test_where_ways_do_not_settle_q_is_made_of_parabolas_and_no_run_is_a_plan(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Pieces of constant jerk would not join there; tangents of a parabola meet in the middle."""
    given = kinked(20, 0.0)
    assert solve(given, None).converged
    monkeypatch.setattr(problem, "_JOINED", -1.0)
    assert not solve(given, None).converged
    spline = given.kind == SPLINE
    assert time_scaled(given).way[spline].tolist() == (0.5 * given.h[spline]).tolist()


def test_what_is_in_the_way_is_where_limits_are_passed_most_and_only_where_the_motion_crawls() -> None:
    given = kinked(20, 1e14)
    found = time_scaled(kinked(20, 0.0))
    # J T² of 50 mm/s³ a millisecond squared.
    slow = 0.9 * (50_000.0 * 1e-6) ** 2 / found.q[20].max()
    assert obstacle(given, replace(found, q=slow * found.q), 1e-3) == 21
    assert obstacle(given, replace(found, q=2.0 * slow * found.q), 1e-3) == 0
    before = replace(given, x3=np.ascontiguousarray(given.x3[:, ::-1]))
    assert obstacle(before, replace(found, q=slow * found.q), 1e-3) == 20


#: A conic that turns within a micrometre of its knot.
TIP = """G61
G6.2 P3 K0 X0 A0 R3.02665 F30000000
K0 X0.873815532 A0.117688724 R4.28043
K0 X0.108442135 A-0.421791397 R0.20135
K0.034844178 X0.482343985 A-1.825645560 R0.21945
K1
K1
K1
M2
"""


def test_it_stops_where_the_path_turns_not_an_interval_before() -> None:
    """The interval after such a stop was all of the turn, from rest: a hundred times the jerk of an axis took 1.71 times as long."""
    times = []
    for jerk in (5e10, 5e12):
        axes = {
            "X": cncgen.machine.Axis("X", 2e5, 2e7, 2e11),
            "A": cncgen.machine.Axis("A", *np.radians([3e4, 5e6, jerk])),
        }
        where = cncgen.Machine("fast", axes, period_s=1.9e-4, chord_tolerance_mm=0.001)
        *_, last = cncgen.plan(cncgen.read_text(TIP, "tip.nc"), where)
        times.append(last.profile.t[-1])
    assert times[1] <= 1.01 * times[0]


#: The end of a curve beside doubled control points is a cusp but for 10⁻⁸ mm.
CUSP = """G61
G1 X0.002441930795499035 A-0.12500621237171833 F38.9761274
G6.2 P4 K0 X0.002441930795499035 A-0.12500621237171833 R1 F38.9761274
K0.0 X0.002441930795499035 A-0.12500621237171833 R1
K0.0 X0.00419970069363239 A-0.12452534519825657 R1
K0.0 X0.002441930795499035 A-0.12500621237171833 R1
K0.260358700 X0.00014312216180170948 A-0.12465263441804306 R1
K0.260359700 X0.00014312216180170948 A-0.12465263441804306 R1
K1
K1
K1
K1
G1 X-0.0045644147717708635 A-0.12009792664617243
M2
"""


#: A machine of slow axes, one of them rotary, with setpoints every 4.1 ms.
SLOW = """name = "slow"
period_s = 0.0041
chord_tolerance_mm = 1e-05
path_tolerance_mm = 0.49
[axes.x]
max_velocity_mm_s = 0.9908
max_acceleration_mm_s2 = 10.91
max_jerk_mm_s3 = 2561.0
[axes.a]
max_velocity_deg_s = 1.967
max_acceleration_deg_s2 = 21.65
max_jerk_deg_s3 = 5086.0
"""


def test_a_cusp_that_no_window_passes_is_a_stop(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """It took windows of ever fewer intervals, again after each, where the speed is some µm/s."""
    tried: list[bool] = []
    solve = rolling_window.solve

    def counted(*given: object, **how: bool) -> Solution:
        solution = solve(*given, **how)
        tried.append(solution.converged)
        return solution

    monkeypatch.setattr(rolling_window, "solve", counted)
    (tmp_path / "slow.toml").write_text(SLOW)
    machine = cncgen.load_machine(tmp_path / "slow.toml")
    program = cncgen.read_text(CUSP)
    positions = np.concatenate([points.position for points in sample(cncgen.plan(program, machine), machine)])
    padded = np.pad(positions[:, [0, -1]], ((3, 3), (0, 0)), mode="edge")
    for k, limit in enumerate(("max_acceleration", "max_jerk"), start=2):
        rates = np.abs(np.diff(padded, k, axis=0)).max(axis=0) / machine.period_s**k
        assert (rates <= [1.001 * getattr(axis, limit) for axis in machine.axes.values()]).all()
    assert tried.count(False) <= 1 < tried.count(True)
