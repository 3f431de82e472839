"""Where the path turns back on itself the motion has no speed, and keeps its acceleration: braking is the acceleration of the way back."""

from __future__ import annotations

import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cncgen import judge, plan, read_text, sample
from cncgen.machine import Machine, load
from cncgen.planner.least_time import block_planning, rolling_window
from cncgen.planner.least_time.mesh import ENTER, ENTER_BACK, LEAVE, LEAVE_BACK, LINE, SPLINE
from cncgen.planner.record import Trajectory
from tests.planner.judging import used

HEAD = "G21 G17 G90 G94 {mode} F60000\n"


def program(rows: str, mode: str) -> str:
    return HEAD.format(mode=mode) + rows + "M2\n"


def planned(rows: str, machine: Machine, mode: str = "G61", effort: str = "best") -> list[Trajectory]:
    return list(plan(read_text(program(rows, mode)), machine, effort=effort))


def positions(rows: str, machine: Machine, mode: str = "G61", effort: str = "best") -> np.ndarray:
    """Return the setpoints, which keep to the path and the limits by the judge of `verify`."""
    text = program(rows, mode)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        points = sample(plan(read_text(text), machine, effort=effort))
        assert not judge(points, read_text(text), machine).breaches
        return sample(plan(read_text(text), machine, effort=effort)).collect().position


def time(rows: str, machine: Machine, mode: str = "G61", effort: str = "best") -> float:
    return sum(float(part.profile.t[-1] - part.profile.t[0]) for part in planned(rows, machine, mode, effort))


def to_and_fro(count: int, length: float = 2.5) -> str:
    return f"G1 X{length}\nX0\n" * (count // 2)


def turning(machine: Machine, rows: str, mode: str = "G61") -> list[tuple[float, float]]:
    """Return the accelerations before and after each place amid the motion where its speed is 0."""
    out = []
    for part in planned(rows, machine, mode, "fast"):
        p = part.profile
        for k in np.flatnonzero(p.v == 0.0)[1:].tolist():
            out.append((float(p.a[k - 1] + p.j[k - 1] * (p.t[k] - p.t[k - 1])), float(p.a[k])))
    return out


@pytest.mark.parametrize("effort", ["best", "fast"])
def test_lines_to_and_fro_take_the_closed_form(effort: str) -> None:
    """On lines without end the jerk has one sign from tip to tip: L = J T³/12, so 84.34 ms for 2.5 mm and 5·10⁴ mm/s³."""
    machine = load("xy-table")
    more = time(to_and_fro(100), machine, effort=effort) - time(to_and_fro(60), machine, effort=effort)
    least = (12.0 * 2.5 / machine.axes["X"].max_jerk) ** (1.0 / 3.0)
    assert least <= more / 40.0 <= 1.003 * least


def test_a_long_way_and_back_takes_the_closed_form() -> None:
    """To 250 mm/s, along, and down again: the last ramp of the acceleration and the first one of the way back are left out."""
    machine = load("xy-table")
    axis, length = machine.axes["X"], 100.0
    v, a, j = axis.max_velocity, axis.max_acceleration, axis.max_jerk
    rise = v / a + a / j
    ramp, slower = a / j, v - 0.5 * a**2 / j
    fall = ramp + slower / a
    way = v * ramp - j * ramp**3 / 6.0 + 0.5 * slower**2 / a
    least = 2.0 * (rise + fall + (length - 0.5 * v * rise - way) / v)
    assert least <= time(f"G1 X{length}\nX0\n", machine) <= 1.001 * least


def test_the_acceleration_goes_on() -> None:
    machine = load("generic-mill")
    for rows in ("G1 Z-8\nG0 Z2\n", "G1 X3 Y4 Z5\nX0 Y0 Z0\n", "G2 X6 Y0 R3\nG3 X0 Y0 R3\n", "G1 A20\nA0\n"):
        (before, after), *rest = turning(machine, rows)
        assert not rest
        assert after > 0.0
        assert before == pytest.approx(-after, rel=1e-9)


@pytest.mark.parametrize(
    ("rows", "mode"),
    [
        ("G1 X20\nG4 P0.1\nX0\n", "G61"),
        ("G1 X20\nX0\n", "G61.1"),
        ("G1 X20\nX0 Y0.1\n", "G61"),
        ("G1 X20\nM0\nX0\n", "G61"),
        ("G95 S100 M3\nG33.1 Z-5 K1\n", "G61"),
    ],
)
def test_the_motion_rests_where_it_must(rows: str, mode: str) -> None:
    """At a dwell, an exact stop, a corner of another angle, a stop of the program, and where the spindle turns back."""
    found = turning(load("generic-mill"), rows, mode)
    assert found
    assert np.abs(found).max() < 1e-9


def test_setpoints_come_within_the_chord_tolerance_of_the_tip() -> None:
    """Half a period before it, a T²/8 + j T³/48 are left: at 2 ms, 2500 mm/s² and 1 µm the acceleration is bounded, at 4 ms there is none."""
    for period in (0.5e-3, 1e-3, 2e-3):
        machine = replace(load("xy-table"), period_s=period)
        ((_, after),) = turning(machine, "G1 X20\nX0\n")
        jerk = machine.axes["X"].max_jerk
        assert after * period**2 / 8.0 + jerk * period**3 / 48.0 <= 1.0001 * machine.chord_tolerance_mm
    assert after == pytest.approx(
        8.0 * machine.chord_tolerance_mm / period**2 - jerk * period / 6.0, rel=1e-3
    )
    machine = replace(machine, period_s=4e-3)
    assert turning(machine, "G1 X20\nX0\n") == [pytest.approx((0.0, 0.0), abs=1e-9)]
    far = []
    for start in np.linspace(19.0, 20.0, 37):
        x = positions(f"G0 X{start}\nG1 X40\nX0\n", replace(machine, period_s=1e-3))
        far.append(40.0 - x[:, 0].max())
    assert 0.1 * machine.chord_tolerance_mm < max(far) <= machine.chord_tolerance_mm


@pytest.mark.parametrize("length", [1e-7, 1e-5, 1e-3, 0.1])
def test_where_one_side_is_short_it_takes_no_longer_than_a_rest(length: float) -> None:
    """A short way reaches little acceleration, which must not stay so on the long one: behind 0.1 µm it took 9 ms longer."""
    machine = load("generic-mill")
    rows = f"G1 X{length:.7f} F100\nX0\nX1\n"
    assert time(rows, machine) <= time(rows, machine, "G61.1")


@pytest.mark.parametrize("effort", ["best", "fast"])
def test_windows_and_blocks_may_end_anywhere_beside_it(effort: str, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = load("generic-mill")
    rows = "".join(f"G1 X{1 + k % 7}\nX{-(k % 3)}\nG0 Z{k % 2}\nG1 Y{k % 5}\nY0\n" for k in range(60))
    whole = time(rows, machine, "G64 P0.01", effort)
    monkeypatch.setattr(rolling_window, "SIZE", 150)
    assert used(positions(rows, machine, "G64 P0.01", effort)[:, :3], machine) <= 1.001
    assert time(rows, machine, "G64 P0.01", effort) <= 1.005 * whole


@pytest.mark.parametrize("effort", ["best", "fast"])
def test_holes_take_less_time(effort: str) -> None:
    """The acceleration A is reached, so the hole takes A/J less: half of it before the tip, half behind."""
    machine = load("generic-mill")
    rows = "".join(f"G0 X{4 * k}\nG1 Z-20\nG0 Z2\n" for k in range(10))
    stops = time(rows.replace("G0 Z2", "G4 P0.0005\nG0 Z2"), machine, "G64 P0.01", effort) - 10 * 0.0005
    axis = machine.axes["Z"]
    saved = (stops - time(rows, machine, "G64 P0.01", effort)) / 10.0
    assert saved == pytest.approx(axis.max_acceleration / axis.max_jerk, rel=0.1)


@pytest.mark.parametrize(
    ("one", "other", "both"),
    [
        ((ENTER_BACK, True), (LEAVE_BACK, True), (ENTER_BACK, LEAVE_BACK)),
        ((ENTER_BACK, True), (SPLINE, False), (ENTER, LEAVE)),
        ((SPLINE, False), (LEAVE_BACK, True), (ENTER, LEAVE)),
        ((ENTER, True), (LEAVE_BACK, True), (ENTER, LEAVE)),
        ((LINE, True), (SPLINE, False), (LINE, LEAVE)),
        ((SPLINE, False), (LINE, True), (ENTER, LINE)),
        ((SPLINE, False), (SPLINE, False), (SPLINE, SPLINE)),
    ],
)
def test_both_sides_of_a_border_rest_or_turn_back_alike(
    one: tuple[int, bool], other: tuple[int, bool], both: tuple[int, int]
) -> None:
    """Each side is classified with the corners near by alone. Where they differ, the motion rests."""
    meshes = [
        SimpleNamespace(kind=np.array([kind], np.int8), stop=np.array([stop])) for kind, stop in (one, other)
    ]
    block_planning._rest_alike(*meshes)  # type: ignore[arg-type]
    assert [int(each.kind[0]) for each in meshes] == list(both)
    assert meshes[0].stop[0] == meshes[1].stop[0] == (both != (SPLINE, SPLINE))


def test_directions_that_are_not_quite_opposite_leave_a_step_of_acceleration() -> None:
    """Rows whose ends are rounded turn back by 180° but for Δ: a step Δ a of Y, of which a third difference has 3/4 Δ a/T at most.

    At 0.1 mrad that is next to nothing, and 3 mrad leave 0.02 J T · 4/3 to a, a sixth of what the axes allow: the motion rests. Between, the
    setpoints hold the limits at every phase, and a tip costs no more than a rest does.
    """
    machine = load("generic-mill")
    slope = [0.0, 1e-4, 1e-3, 3e-3]
    rows = ["".join(f"G1 X2.5\nX0 Y{2.5 * (k + 1) * turn:.7f}\n" for k in range(20)) for turn in slope]
    straight, slight, more, rest = (time(each, machine) for each in rows)
    assert slight <= 1.005 * straight
    assert straight < more < rest <= 1.001 * time(rows[3], machine, "G61.1")
    for each in rows[1:3]:
        for phase in np.linspace(0.0, 1.0, 8, endpoint=False):
            x = positions(f"G0 Z1\nG4 P{phase * machine.period_s:.9f}\n{each}", machine)
            assert used(x, machine) <= 1.001


@pytest.mark.parametrize("effort", ["best", "fast"])
def test_a_corner_elsewhere_on_the_row_does_not_turn_the_tip(effort: str) -> None:
    """Holes: the way out of one is rounded into the rapid to the next, and leaves the tip as the way into it ended.

    More tolerance takes no longer; where the smoothed way out left the tip by 10 µrad, the motion rested there, and took 5 % longer.
    """
    machine = load("generic-mill")
    rows = "".join(f"G0 X{4 * k} Z2\nG1 Z-6\nG0 Z2\n" for k in range(1, 12))
    took = [time(rows, machine, f"G64 P{tolerance}", effort) for tolerance in (0.005, 0.02, 0.05, 0.1, 0.3)]
    assert (np.diff(took) < 0.0).all()
