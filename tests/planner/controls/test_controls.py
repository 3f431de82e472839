"""Estimates of other controls beside closed forms, and beside times that LinuxCNC's own motion took."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cncgen.diagnostics import UsageError
from cncgen.machine import load_machine
from cncgen.pipeline import plan, plan_with_summary, read_text
from cncgen.planner import PlanOptions
from cncgen.planner.controls.rules import CONTROLS
from cncgen.planner.options import CONTROLS as NAMES
from cncgen.toolpath.reading import ReadOptions
from trials import linuxcnc_motion

#: Of both axes of xy-table.
ACCELERATION = 2450.0
PERIOD = 0.001


def time_as(control: str, text: str, chunk_rows: int = 16_384) -> float:
    """Return the seconds that a control takes by its rules."""
    program = read_text(text, options=ReadOptions(chunk_rows=chunk_rows))
    *_, last = plan(program, "xy-table", PlanOptions(control=control))
    return float(last.profile.t[-1])


def test_each_control_has_rules() -> None:
    assert tuple(CONTROLS) == NAMES


def test_exact_stop_is_a_trapezoid_a_block() -> None:
    square = "G21 G90 G64 P0.1 F3000\nG1 X10\nY10\nX0\nY0\nM2\n"
    assert time_as("exact-stop", square) == pytest.approx(4 * (10 / 50 + 50 / ACCELERATION), abs=1e-9)
    # Too short to come to speed: twice the way at half of its time.
    short = "G21 G90 F3000\nG1 X0.4\nM2\n"
    assert time_as("exact-stop", short) == pytest.approx(2 * math.sqrt(0.4 / ACCELERATION), abs=1e-9)


def test_exact_stop_on_an_arc_keeps_its_acceleration() -> None:
    """An arc of 2 mm at √(a R) = 70 mm/s; along the way the weakest axis gives a too."""
    arc = "G21 G90 G61.1 F60000\nG2 X4 Y0 I2\nM2\n"
    top = math.sqrt(ACCELERATION * 2.0)
    assert time_as("exact-stop", arc) == pytest.approx(2 * math.pi / top + top / ACCELERATION, rel=1e-6)


@pytest.mark.parametrize("turn", [20.0, 45.0, 90.0, 135.0])
def test_a_corner_of_grbl_has_its_junction_speed(turn: float) -> None:
    """Two lines of 50 mm at 100 mm/s: from 0 to F, to the corner's speed, to F, to 0, by the published formula."""
    x, y = 50 + 50 * math.cos(math.radians(turn)), 50 * math.sin(math.radians(turn))
    found = time_as("grbl", f"G21 G90 F6000\nG1 X50\nX{x:.9f} Y{y:.9f}\nM2\n")
    sine = math.sin(math.radians(180.0 - turn) / 2.0)
    # Towards the middle of the bend: (cos φ - 1, sin φ), as strong as its weaker axis.
    towards = np.array([math.cos(math.radians(turn)) - 1.0, math.sin(math.radians(turn))])
    strength = ACCELERATION / np.max(np.abs(towards) / np.linalg.norm(towards))
    corner = min(math.sqrt(strength * 0.01 * sine / (1.0 - sine)), 100.0)
    second = ACCELERATION / max(abs(math.cos(math.radians(turn))), abs(math.sin(math.radians(turn))))

    def change(v: float, w: float, a: float) -> tuple[float, float]:
        return abs(w - v) / a, abs(w**2 - v**2) / (2 * a)

    legs = 0.0
    for a, ends in ((ACCELERATION, (0.0, corner)), (second, (corner, 0.0))):
        changes = [change(v, 100.0, a) for v in ends]
        legs += sum(t for t, _ in changes) + (50.0 - sum(s for _, s in changes)) / 100.0
    assert found == pytest.approx(legs, rel=1e-6)


def test_grbl_sees_fifteen_blocks_ahead() -> None:
    """On a line of parts of 0.1 mm it must be able to stop within 15 of them: v² = 2 a 1.5 mm, and a 0.1 mm more amid a part."""
    text = "G21 G90 F60000\n" + "".join(f"G1 X{k / 10:.1f}\n" for k in range(1, 1001)) + "M2\n"
    stream, summary = plan_with_summary(read_text(text), "xy-table", PlanOptions(control="grbl"))
    for _ in stream.chunks:
        pass
    expected = math.sqrt(ACCELERATION * (2 * 1.5 + 0.1))
    assert summary.as_json()["feed_mm_s"]["max"] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("tolerance", [0.01, 0.1])
def test_a_corner_of_linuxcnc_is_an_arc(tolerance: float) -> None:
    """90°: P = R (√2 - 1), √(√¾ a R) on it; 3 periods for the stop at the end, 1 for slowing down to the corner.

    The last line keeps half of the acceleration.
    """
    radius = tolerance / (math.sqrt(2.0) - 1.0)
    corner = math.sqrt(math.sqrt(0.75) * ACCELERATION * radius)
    first, last = ACCELERATION, ACCELERATION / 2
    way = 2 * (50.0 - radius)
    changes = (100.0 / first, (100.0 - corner) / first, (100.0 - corner) / last, 100.0 / last)
    ways = (100.0**2 / first, (100.0**2 - corner**2) / first, (100.0**2 - corner**2) / last, 100.0**2 / last)
    expected = sum(changes) + (way - sum(ways) / 2) / 100.0 + radius * math.pi / 2 / corner + 4 * PERIOD
    text = f"G21 G90 G64 P{tolerance} F6000\nG1 X50\nY50\nM2\n"
    assert time_as("linuxcnc", text) == pytest.approx(expected, rel=1e-6)


ZIGZAG = "".join(f"G1 X{2 * k + 1} Y{k % 2}\n" for k in range(10))
CIRCLE = "".join(
    f"G1 X{20 * math.sin(k / 40):.4f} Y{20 - 20 * math.cos(k / 40):.4f}\n" for k in range(1, 120)
)
#: Programs, and the seconds that LinuxCNC 2.9 took with the axes of xy-table (`trials.linuxcnc_motion`).
MEASURED = {
    "G64 P0.01 F6000\nG1 X50\nY50\n": 1.122,
    "G64 P0.1 F6000\nG1 X50\nY50\n": 1.113,
    "G64 P1 F6000\nG1 X50\nY50\n": 1.074,
    "G64 P0.1 F6000\nG1 X50\nX14.645 Y35.355\n": 1.101,
    "G64 P0.1 F6000\nG1 X20\nG3 X20 Y10 J5\nG1 X0\n": 0.621,
    "G61 F6000\nG1 X20\nG3 X20 Y4 J2\nG1 X0\n": 0.545,
    "G64 P0.1 F6000\nG1 X20\nG0 X40 Y5\nG1 X60\n": 0.707,
    "G61 F3000\nG1 X10\nG1 Y10\nG1 X0\nG1 Y0\n": 0.894,
    f"G64 P0.01 F6000\n{ZIGZAG}": 0.530,
    f"G64 P0.1 F6000\n{ZIGZAG}": 0.428,
    f"G64 P0.01 F6000\n{CIRCLE}": 0.669,
}


@pytest.mark.parametrize("text", MEASURED)
def test_estimates_beside_times_of_linuxcnc(text: str) -> None:
    assert time_as("linuxcnc", f"G21 G90 {text}M2\n") == pytest.approx(MEASURED[text], rel=0.016)


@pytest.mark.skipif(not linuxcnc_motion.available(), reason="LinuxCNC's motion is not installed")
def test_linuxcnc_itself_takes_the_time_of_the_estimate(tmp_path: Path) -> None:
    machine = load_machine("xy-table")
    program = tmp_path / "square.ngc"
    program.write_text("G21 G90 G61 F3000\nG1 X10\nG1 Y10\nG1 X0\nG1 Y0\nM2\n")
    try:
        theirs = linuxcnc_motion.run(program, machine, seconds=60).time_s
    except RuntimeError as error:
        pytest.skip(f"LinuxCNC does not run here: {str(error)[:200]}")
    assert linuxcnc_motion.estimated_s(program, machine) == pytest.approx(theirs, rel=0.02)


@settings(max_examples=20)
@given(
    st.sampled_from(NAMES),
    st.integers(1, 7),
    st.lists(
        st.tuples(st.integers(-30, 30), st.integers(-30, 30), st.sampled_from([0, 1, 1, 1])),
        min_size=2,
        max_size=12,
    ),
)
def test_chunks_change_nothing(control: str, rows: int, places: list[tuple[int, int, int]]) -> None:
    """But that LinuxCNC's lines are not made one over the border of two chunks; here no three are on a line."""
    text = "G21 G90 G64 P0.001 F6000\n" + "".join(
        f"G{kind} X{x + 0.1 * k * k:.3f} Y{y + 0.07 * k**3:.3f}\n" for k, (x, y, kind) in enumerate(places)
    )
    assert time_as(control, f"{text}M2\n", rows) == pytest.approx(time_as(control, f"{text}M2\n"), rel=1e-9)


@given(st.sampled_from(NAMES), st.integers(0, 10_000))
@settings(max_examples=20)
def test_positions_and_times_are_one_motion(control: str, seed: int) -> None:
    """The profile ends where the program ends; its pieces meet in place."""
    random = np.random.default_rng(seed)
    text = "G21 G90 G64 P0.05 F9000\n" + "".join(
        f"G1 X{x:.3f} Y{y:.3f}\n" for x, y in random.uniform(-5, 5, (30, 2))
    )
    for trajectory in plan(read_text(f"{text}G2 X9 Y0 R20\nM2\n"), "xy-table", PlanOptions(control=control)):
        p = trajectory.profile
        moved = p.v * np.diff(p.t) + 0.5 * p.a * np.diff(p.t) ** 2
        assert p.s[:-1] + moved == pytest.approx(p.s[1:], abs=1e-6)
        assert p.s[-1] == pytest.approx(trajectory.row_s[-1], abs=1e-9)


def test_other_options_of_planning_are_refused() -> None:
    options = PlanOptions(control="grbl", feedrate="ild")
    with pytest.raises(UsageError, match="grbl plans by its own rules"):
        options.check()
    with pytest.raises(UsageError, match="is not one of linuxcnc, grbl, exact-stop"):
        replace(options, control="haas").check()
