"""Corners that setpoints pass faster as they are than rounded within a tolerance that they cannot see."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from cncgen import pipeline
from cncgen.machine import load
from cncgen.machine.record import Axis, Machine
from cncgen.planner.smoothing import smooth, worth
from cncgen.planner.smoothing.worth import Drive, worth_rounding
from cncgen.toolpath.record import Kind
from tests.planner.smoothing.programs import toolpath

PERIOD, JERK = 0.001, 5e4
CORNER = [[10, 0, 0], [10, 10, 0]]


def machine(**jerk: float) -> Machine:
    axes = {letter: Axis(letter, 200.0, 2000.0, jerk.get(letter, JERK)) for letter in "XYZA"}
    return Machine("here", axes, period_s=PERIOD, chord_tolerance_mm=0.001)


def test_the_response_of_a_turn() -> None:
    """h(t) = (1/π) ∫ cos ωt/(1 + ω⁶) dω and h'(t) are largest where the constants say (scipy's quadrature)."""

    def slope(t: float) -> float:
        return quad(lambda w: w * np.sin(w * t) / (1 + w**6), 0, 40, limit=400)[0] / np.pi

    assert quad(lambda w: 1 / (1 + w**6), 0, np.inf)[0] / np.pi == pytest.approx(worth._BEND, rel=1e-9)
    assert max(slope(t) for t in np.linspace(0.5, 2.5, 81)) == pytest.approx(worth._TWIST, rel=1e-3)


@pytest.mark.parametrize("turn", [0.001, 0.02, 0.1, 1.0])
def test_the_border_is_a_part_of_what_jerk_moves_in_a_period(turn: float) -> None:
    """L = 3 P/Δ, P half of what is given: v = (J L²/(0.1475 Δ))^(1/3) is 1.5 times 0.75 J T²/Δ, or 5 J T² where that is more."""
    drive = Drive.of(machine(), "XYZ")
    speed = JERK * PERIOD**2 * max(1.5 * 0.75 / turn, 5.0)
    border = 2.0 * turn / 3.0 * np.sqrt(speed**3 * 0.1475 * turn / JERK)
    given = np.array([0.9, 1.1]) * border
    leave = np.tile([1.0, 0.0, 0.0], (2, 1))
    entry = leave + np.array([0.0, turn, 0.0])
    assert worth_rounding(drive, leave, entry, given, np.full(2, 10.0)).tolist() == [False, True]
    # Rows shorter than the rounding are smoothed together.
    assert worth_rounding(drive, leave, entry, given, np.full(2, 1e-6)).all()


def test_corners_within_an_unseen_tolerance_are_met_exactly() -> None:
    rows = toolpath([0, 0, 0], CORNER, tolerance=5e-6)
    (exact,) = smooth([rows], 0.001, machine())
    assert exact.kind.tolist() == [Kind.LINE, Kind.LINE]
    (rounded,) = smooth([rows], 0.001, machine(X=100.0, Y=100.0))
    assert (rounded.kind == Kind.NURBS).all()
    (as_asked,) = smooth([rows], 0.001)
    assert (as_asked.kind == Kind.NURBS).all()


@pytest.mark.parametrize("p", [2e-6, 1e-5, 1e-4])
@pytest.mark.parametrize("rise", [0.06, 5.0])
def test_a_tolerance_that_is_not_seen_costs_no_time(p: float, rise: float) -> None:
    """Once a tolerance of a few nanometres took up to a tenth more than none."""
    rows = "".join(f"G1 X{7 * k} Y{rise * (k % 2)}\n" for k in range(1, 9))
    times = []
    for mode in ("G61", f"G64 P{p:.7f}"):
        program = pipeline.read_text(f"G21 G90 F9000 {mode}\n{rows}M2\n")
        times.append(list(pipeline.plan(program, machine()))[-1].profile.t[-1])
    assert times[1] <= 1.001 * times[0]


@pytest.mark.parametrize("ratio", [20.0, 60.0])
def test_corners_of_a_rotary_axis_cost_no_more_than_stops(ratio: float) -> None:
    """A turns by 20 (60) degrees a millimetre in one row and stands in the next: rounded within 2 µm they took 1 % more."""
    rng = np.random.default_rng(3)
    x = y = a = 0.0
    rows = []
    for _ in range(40):
        way, heading = rng.uniform(1.0, 8.0), rng.uniform(0.0, 6.28)
        x, y = x + way * np.cos(heading), y + way * np.sin(heading)
        a += float(rng.choice([-1, 0, 1])) * ratio * way
        rows.append(f"G1 X{x:.3f} Y{y:.3f} A{a:.3f}")
    seconds = []
    for mode in ("G64 P0.002", "G61"):
        text = "\n".join([f"G21 G90 {mode} F3000", *rows, "M2", ""])
        seconds.append(list(pipeline.plan(pipeline.read_text(text), load("generic-mill")))[-1].profile.t[-1])
    assert seconds[0] <= seconds[1]
