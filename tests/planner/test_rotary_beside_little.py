"""Rotary axes that turn while X Y Z hardly move: as fast as the axes allow, at the feed along X Y Z where that is slower."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cncgen.machine import load
from cncgen.pipeline import judge, plan, plan_with_summary, read_text, sample
from cncgen.units import DEGREE

MACHINE = load("generic-mill")
#: 90 degrees from rest to rest: jerk 20,000, acceleration 1000, velocity 180 degrees: d/v + v/a + a/j.
QUARTER = 90 / 180 + 180 / 1000 + 1000 / 20_000


def setpoints_of(body: str, feedrate: str) -> np.ndarray:
    planned = plan(read_text(f"G21 G90 G94 {body}\nM2\n"), MACHINE, feedrate=feedrate)
    return np.vstack([chunk.position for chunk in sample(planned)])


@pytest.mark.parametrize("mode", ["G61", "G64 P0.01"])
@pytest.mark.parametrize("length", ["0.000000002", "0.0000001", "0.00001", "0.01"])
def test_no_limit_is_passed_by_rounding_of_the_path_coordinate(length: str, mode: str) -> None:
    """Beside 10⁻⁷ mm a quarter turn once had 1.44 times its jerk: s is known to 10⁻¹⁴ mm, which was 10⁻⁵ degrees there."""
    away = f"{mode} F6000 (START, X30)\nG1 X30 Y{length} A90"
    turn = setpoints_of(away, "optimal")
    assert (len(turn) - 1) * 1e-3 == pytest.approx(QUARTER, abs=2e-3)
    angle = setpoints_of(
        f"{mode} F6000\nG1 X30 Y10\nG1 Y{float(length) + 10:.9f} A90\nG1 X60 Y10 A45", "optimal"
    )[:, -1]
    padded = np.concatenate([np.repeat(angle[:1], 3), angle, np.repeat(angle[-1:], 3)]) / DEGREE
    for order, limit in enumerate((180.0, 1000.0, 20_000.0), start=1):
        assert np.abs(np.diff(padded, order)).max() / 1e-3**order <= 1.001 * limit


@pytest.mark.parametrize("size", ["0.0000001", "0.001", "1", "10"])
def test_a_curve_that_turns_back_in_xyz_while_an_axis_turns_keeps_its_limits(size: str) -> None:
    """X goes there and back while A turns by 60 degrees: A once had up to 37 times its jerk where X turns."""
    curve = f"G6.2 P3 K0 X0 Y0 A0\nK0 X{size} Y0 A30\nK0 X0 Y0 A60\nK1\nK1\nK1"
    angle = setpoints_of(f"G61 F6000\n{curve}", "optimal")[:, -1] / DEGREE
    padded = np.concatenate([np.repeat(angle[:1], 3), angle, np.repeat(angle[-1:], 3)])
    for order, limit in enumerate((180.0, 1000.0, 20_000.0), start=1):
        assert np.abs(np.diff(padded, order)).max() / 1e-3**order <= 1.001 * limit
    assert len(angle) < 600


@pytest.mark.parametrize("feedrate", ["optimal", "ild", "constant"])
def test_the_feed_is_that_along_xyz(feedrate: str) -> None:
    """0.01 mm at 0.06 mm/min take ten seconds, whatever turns meanwhile; starting and stopping takes the turn v/a + a/j more."""
    rate = 90 / 10
    ramps = 0.0 if feedrate == "constant" else 2 * math.sqrt(rate / 20_000)
    positions = setpoints_of("G61 F0.06\nG1 X0.01 A90", feedrate)
    assert (len(positions) - 1) * 1e-3 == pytest.approx(10.0 + ramps, abs=2e-3)


def test_a_turn_is_no_length_in_the_summary() -> None:
    """The length of the path, and its mean feed, are millimetres: the turn has none."""
    program = read_text("G21 G90 G94 G61 F6000\nG1 X30\nG1 X30.0000001 A90\nM2\n")
    stream, seen = plan_with_summary(program, MACHINE)
    for _ in stream.chunks:
        pass
    assert seen.as_json()["path_length_mm"] == pytest.approx(30.0, abs=1e-6)
    assert seen.as_json()["feed_mm_s"]["max"] <= 100.0 * (1 + 1e-9)


@pytest.mark.parametrize(("effort", "before_s"), [("best", 0.913), ("fast", 1.365)])
def test_an_engraved_circle_does_not_stop_where_x_turns_back(effort: str, before_s: float) -> None:
    """On a cylinder of 20 mm, in 400 lines. Where A is fastest some move X by 0.3 µm in 0.09 degrees, and were met exactly: `before_s`."""
    k = 2.0 * math.pi / 400.0
    lines = "\n".join(
        f"X{2.0 * math.cos(k * i):.4f} A{math.degrees(0.1) * math.sin(k * i):.4f}" for i in range(401)
    )
    program = read_text(f"G21 G90 G94 G64 P0.005 G1 F1200\n{lines}\nM2\n")
    found = sample(plan(program, MACHINE, effort=effort)).collect()
    assert (len(found.position) - 1) * 1e-3 < 0.9 * before_s
    assert judge(found, program, MACHINE).holds


def test_lines_of_a_rotary_axis_alone_use_the_tolerance_and_keep_their_feed() -> None:
    """F is the speed of X, or that of A where it turns alone: 8.33 degrees/s. In the corner of both, which G61 rests in, each may move in the
    other's row."""
    program = read_text("G21 G90 G94 G64 P0.1\nG1 X10 F3000\nG1 A30 F500\nG1 X20 F3000\nM2\n")
    found, exact = (
        sample(plan(program, MACHINE, effort=effort), signals=["line"]).collect()
        for effort in ("best", "fast")
    )
    assert judge(found, program, MACHINE).holds
    assert len(found.position) < len(exact.position) - 60
    line = np.asarray(found.signals["line"])[1:]
    x, a = (np.abs(np.diff(found.position[:, k])) / 1e-3 for k in (0, -1))
    assert a[line == 3].max() / DEGREE <= 500 / 60 * (1 + 2e-4)
    assert max(x[line == k].max() for k in (2, 4)) <= 50.0 * (1 + 2e-4)


def test_a_rotary_axis_alone_has_its_time_on_its_lines() -> None:
    """There and back by A alone, 1 degree each way at 100 degrees/min: 0.6 s of each line; X Y Z, which stand, measured none of it."""
    program = read_text("G21 G90 G94 G64 P0.001\nG1 A-1 F100\nG1 A0 F100\nM2\n")
    found = sample(plan(program, MACHINE), signals=["line"]).collect()
    times = np.bincount(np.asarray(found.signals["line"], int))[2:4] * 1e-3
    assert times == pytest.approx([0.6, 0.6], abs=0.05)
    assert judge(found, program, MACHINE).holds
