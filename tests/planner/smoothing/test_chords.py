"""Tolerances hardly wider than the chords between setpoints: smoothing and chords share them."""

from __future__ import annotations

import numpy as np
import pytest

from cncgen import pipeline
from cncgen.machine.record import Axis, Machine
from cncgen.planner.smoothing import chord_speed_within, smooth
from cncgen.planner.smoothing.chords import chord_within, fit_tolerance
from cncgen.toolpath.record import PathMode
from cncgen.verify import verify
from tests.planner.smoothing.programs import facets, path_of

PROGRAM = """G21 G17 G90 G94 F3000 G64 P{p}
G1 X-10
G2 X-10 Y0 I{r} J0
G1 Y10
G3 X-10.2 Y10.3 I0.05 J0.25
G1 X5
M2
"""
CHORD = 0.001


def machine(period_s: float) -> Machine:
    """Return one that is so fast that the chords bound the speed."""
    axes = {letter: Axis(letter, 500.0, 20_000.0, 4e6) for letter in "XYZ"}
    return Machine("fast", axes, period_s=period_s, chord_tolerance_mm=CHORD)


@pytest.mark.parametrize("p", [0.0005, 0.001, 0.0013, 0.002, 0.01])
@pytest.mark.parametrize("r", [0.3, 2.0])
def test_smoothing_and_chords_together_keep_the_tolerance(p: float, r: float) -> None:
    """P below twice the chord tolerance: once P/2 of the one and all of the other went over it by up to a sixth."""
    text = PROGRAM.format(p=p, r=r)
    where = machine(0.004)
    stream = pipeline.sample(pipeline.plan(pipeline.read_text(text), where))
    verdict = verify(stream, pipeline.read_text(text).chunks(), where, named="XY")
    assert not {item.code for item in verdict.breaches} & {
        "verify-distance",
        "verify-coverage",
        "verify-order",
    }
    assert verdict.setpoints_to_path_mm <= max(p, CHORD) * 1.001
    assert verdict.path_to_setpoints_mm <= max(p, CHORD) * 1.001


def test_the_parts_add_up_to_the_tolerance() -> None:
    tolerance = np.array([1e-5, 0.0005, 0.001, 0.0015, 0.002, 0.01, 1.0])
    fit = fit_tolerance(tolerance, CHORD)
    assert (fit >= 0.5 * tolerance).all()
    # Chords are some per cent longer than the curvature at their middle says.
    np.testing.assert_allclose(fit[5:], tolerance[5:] - 1.03 * CHORD)


@pytest.mark.parametrize(("tolerance", "left"), [(0.0004, 0.0008), (0.001, 0.0005), (0.0015, 0.00075)])
def test_the_speed_is_that_of_the_chord_that_is_left(tolerance: float, left: float) -> None:
    """v = (2/T) √(2 δ/κ − δ²) with what is left for δ; nothing where the chord tolerance itself is left, or under G61."""
    rows = facets(60, tolerance=tolerance)
    (made,) = smooth([rows], CHORD)
    speed = chord_speed_within(made, CHORD, 0.004)
    assert speed is not None
    s = np.linspace(0.1, 0.9, 9) * path_of(made).length
    bend = np.linalg.norm(path_of(made).evaluate(s, 2)[2][:, :3], axis=1)
    np.testing.assert_allclose(
        speed(s), 500.0 * np.sqrt(2 * left / 1.03 / bend - (left / 1.03) ** 2), rtol=1e-9
    )
    assert chord_speed_within(facets(5, tolerance=0.0021), CHORD, 0.004) is None
    # 0.01 − 0.009 is less than 0.001 by rounding.
    assert chord_speed_within(facets(5, tolerance=0.01), CHORD, 0.004) is None
    assert chord_speed_within(facets(5, tolerance=0.001, path_mode=PathMode.EXACT_PATH), CHORD, 0.004) is None


@pytest.mark.parametrize("p", [0.0008, 0.003])
def test_chords_are_those_of_rotary_axes_too(p: float) -> None:
    """X goes straight on, and A turns to and fro: one degree counts as a millimetre, in chords as in the tolerance."""
    text = f"G21 G17 G90 G94 F20000 G64 P{p}\n" + "".join(
        f"G1 X{0.4 * k} A{0.3 * (k % 3)}\n" for k in range(1, 40)
    )
    where = machine(0.01)
    turning = Axis("A", 50.0, 5000.0, 1e6)
    where = Machine("fast", {**where.axes, "A": turning}, period_s=0.01, chord_tolerance_mm=CHORD)
    stream = pipeline.sample(pipeline.plan(pipeline.read_text(text), where))
    verdict = verify(stream, pipeline.read_text(text).chunks(), where, named="XYZA")
    assert not {item.code for item in verdict.breaches} & {
        "verify-distance",
        "verify-coverage",
        "verify-order",
    }


def test_chords_are_no_longer_than_the_accelerations_let_them_be() -> None:
    """Under A on X and Y together, for a period, the parabola x = √2 A t²/2 is √2 A T²/8 from its chord."""
    slow = Machine("slow", {letter: Axis(letter, 500.0, 1000.0, 5e4) for letter in "XY"})
    assert chord_within(slow, "XYZ") == pytest.approx(np.sqrt(2.0) * 1000.0 * 1e-6 / 8.0)
    # With a rotary axis it is the tolerance, as where that is less.
    assert chord_within(slow, "XYZC") == slow.chord_tolerance_mm
    assert chord_within(machine(0.004), "XYZ") == CHORD


@pytest.mark.parametrize("chord", [0.001, 0.003, 0.01])
def test_more_room_for_chords_than_they_take_costs_nothing(chord: float) -> None:
    """At 1 ms and 1000 mm/s² chords take 0.2 µm: what they may take besides is left to smoothing, and P is kept."""
    text = PROGRAM.format(p=0.01, r=2.0)
    axes = {letter: Axis(letter, 100.0, 1000.0, 5e4) for letter in "XYZ"}
    times = []
    for tolerance in (0.0005, chord):
        mill = Machine("mill", axes, chord_tolerance_mm=tolerance)
        program = pipeline.read_text(text)
        setpoints = pipeline.sample(pipeline.plan(program, mill)).collect()
        verdict = pipeline.judge(setpoints, program, mill)
        assert max(verdict.setpoints_to_path_mm, verdict.path_to_setpoints_mm) <= 0.01
        times.append(setpoints.time_s[-1])
    assert times[1] <= times[0] * (1.0 + 1e-3)


def test_a_curve_that_is_met_exactly_shares_its_tolerance_with_nothing() -> None:
    """At P = δ what is smoothed has half of P each for itself and its chords; a NURBS in the program needs no smoothing."""
    curve = "K0 X0 Y0 R1 F30000\nK0 X5 Y9 R1\nK0 X10 Y-9 R1\nK0 X15 Y0 R1\nK1\nK1\nK1\nK1\nM2\n"
    times = []
    for mode in (f"G64 P{CHORD}", "G61"):
        program = pipeline.read_text(f"G21 G17 G90 G94 {mode}\nG6.2 P4 {curve}")
        times.append(list(pipeline.plan(program, machine(0.004)))[-1].profile.t[-1])
    assert times[0] == pytest.approx(times[1], rel=1e-12)
