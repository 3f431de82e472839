"""Tolerances hardly wider than the chords between setpoints: smoothing and chords share them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from cncgen import pipeline
from cncgen.machine.record import Axis, Machine
from cncgen.planner import PlanOptions, plan
from cncgen.planner.limits.axis_limits import chord_reserve
from cncgen.planner.smoothing import chord_speed_within, smooth
from cncgen.planner.smoothing.tolerance_split import Chords
from cncgen.toolpath.record import PathMode
from cncgen.toolpath.slicing import join
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


def machine(period_s: float, jerk: float = 4e6) -> Machine:
    """Return one that is so fast that the chords bound the speed."""
    axes = {letter: Axis(letter, 500.0, 20_000.0, jerk) for letter in "XYZ"}
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
    """Where the jerk lets chords be as long as they may, they have δ, and 3 % of P or δ is left to smoothing."""
    tolerance = np.array([1e-5, 0.0005, 0.001, 0.0015, 0.002, 0.01, 1.0])
    straight = np.zeros(len(tolerance))
    fit = Chords(CHORD, 0.004, (1e9, 1e9)).fit_tolerance(tolerance, straight, straight)
    np.testing.assert_allclose(fit[:4], [1e-5, 3e-5, 3e-5, 0.0015 - 1.03 * CHORD])
    # Chords are some per cent longer than the curvature at their middle says.
    np.testing.assert_allclose(fit[3:], tolerance[3:] - 1.03 * CHORD)


@pytest.mark.parametrize("turn", [0.3, 1.0, 1.4])
def test_the_chord_at_a_corner_is_that_of_its_speed(turn: float) -> None:
    """|x''| v² T²/8 with v³ = J L²/(0.1475 Δ), L = 3 P/Δ and |x''| = Δ/(3 L): Δ falls out, and a tenth is added."""
    jerk, period, p = 5e4, 0.002, np.array([0.01])
    length = 3.0 * p[0] / turn
    speed = np.cbrt(jerk * length**2 / (0.1475 * turn))
    chord = turn / (3.0 * length) * speed**2 * period**2 / 8.0
    fit = Chords(0.009, period, (jerk, jerk)).fit_tolerance(p, np.zeros(1), np.full(1, 500.0))
    assert p[0] - fit[0] == pytest.approx(1.1 * chord, rel=0.01)


@pytest.mark.parametrize("feed", [20.0, 5000.0])
def test_the_chord_on_a_curve_is_that_of_its_speed(feed: float) -> None:
    """R = 5 mm: v²/R by the feed, v = ∛(J R²) by jerk."""
    jerk, period = 5e4, 0.004
    fit = Chords(0.1, period, (jerk, jerk)).fit_tolerance(np.array([0.5]), np.array([0.2]), np.array([feed]))
    on_curve = min(feed, np.cbrt(jerk * 25.0)) ** 2 / 5.0 * period**2 / 8.0
    at_corner = 1.1 * 1.72 / 8.0 * np.cbrt(0.5 * (jerk * period**3) ** 2)
    assert 0.5 - fit[0] == pytest.approx(max(on_curve, at_corner), rel=1e-9)


def test_corners_are_met_exactly_within_what_setpoints_do_not_show() -> None:
    """Rounded within P a turn Δ is passed at 3.94 (J P²)^⅓/Δ; as it is, at ¾ J T²/Δ; facets that P covers are a curve."""
    jerk, period, turn = 5e4, 0.004, np.full(3, 0.4)
    equal = (0.75 * period**2 * jerk ** (2.0 / 3.0) / (9.0 / 0.1475) ** (1.0 / 3.0)) ** 1.5
    chords = Chords(1e-5, period, (jerk, jerk))
    met = chords.unseen(np.array([0.99, 1.01, 0.99]) * equal, turn, np.array([10.0, 10.0, 15.0 * equal]))
    assert met.tolist() == [True, False, False]


@pytest.mark.parametrize("tolerance", [0.0004, 0.001, 0.0015])
def test_the_speed_is_that_of_the_chord_that_is_left(tolerance: float) -> None:
    """v = (2/T) √(2 δ/κ − δ²) with what is left for δ; nothing where the chord tolerance itself is left, or under G61."""
    rows = facets(60, tolerance=tolerance)
    (made,) = smooth([rows], machine(0.004, 5e4))
    speed = chord_speed_within(made, CHORD, 0.004)
    assert speed is not None
    path = path_of(made)
    s = np.linspace(0.1, 0.9, 41) * path.length
    bend = np.linalg.norm(path.evaluate(s, 2)[2][:, :3], axis=1)
    left = made.chord_room[path.row_of(s, 1)]
    tight = left < 1.03 * CHORD
    assert tight.any()
    expected = 500.0 * np.sqrt(2 * left / bend - left**2)
    np.testing.assert_allclose(speed(s, path.evaluate(s, 2)), np.where(tight, expected, np.inf), rtol=1e-9)
    assert (
        chord_speed_within(replace(made, chord_room=0 * made.chord_room + 1.03 * CHORD), CHORD, 0.004) is None
    )
    assert chord_speed_within(facets(5, tolerance=0.001, path_mode=PathMode.EXACT_PATH), CHORD, 0.004) is None


@pytest.mark.parametrize(
    ("tolerance", "period"), [(0.0004, 0.001), (0.0006, 0.004), (0.0015, 0.004), (0.01, 0.004)]
)
def test_what_is_left_and_what_is_used_are_the_tolerance(tolerance: float, period: float) -> None:
    """Measured: no place of a row is further from the path than P, or δ where P is less, less the tolerance that it keeps."""
    rows = facets(200, tolerance=tolerance)
    made = join(list(smooth([rows], machine(period, 5e4))))
    path = path_of(made)
    s = np.linspace(0.0, path.length, 20_001)
    x = path.evaluate(s, 0)[0]
    corners = np.concatenate([rows.start[None], rows.end])
    away = np.full(len(s), np.inf)
    for a, b in pairwise(corners):
        part = np.clip((x - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        away = np.minimum(away, np.linalg.norm(x - a - part[:, None] * (b - a), axis=1))
    left = made.chord_room[path.row_of(s, 1)]
    assert (away + left <= max(tolerance, CHORD) * (1.0 + 1e-9)).all()
    # It is no wide margin either: somewhere what is used and what is left make nine tenths of the whole.
    assert (away + left).max() >= 0.9 * max(tolerance, CHORD)


def test_facets_whose_chords_are_most_of_the_tolerance_are_no_slower_than_as_they_are() -> None:
    """Facets of 0.2 mm at 4 ms within P = 0.4 δ: lengths that were tried at some corners took 18 % longer than none."""
    rows = facets(40, tolerance=0.4 * CHORD)
    exact = replace(rows, path_mode=np.full(len(rows), PathMode.EXACT_PATH, np.int8))
    one, other = (
        list(plan([each], machine(0.004), PlanOptions(feedrate="optimal")))[-1] for each in (rows, exact)
    )
    assert one.profile.t[-1] <= 1.001 * other.profile.t[-1]


@pytest.mark.parametrize(("shape", "p"), [("sharp", 0.003), ("sharp", 0.01), ("short", 0.003)])
def test_a_wider_chord_tolerance_takes_no_more_time(shape: str, p: float) -> None:
    """At 4 ms smoothing once gave up all that chords may take, and took up to 6 % longer with more of it."""
    turns = np.radians(90.0 if shape == "sharp" else 40.0) * np.arange(4 if shape == "sharp" else 9)
    size = 20.0 if shape == "sharp" else 2.0
    ends = size * np.cumsum(np.stack([np.cos(turns), np.sin(turns)], axis=1), axis=0)
    text = f"G21 G90 F6000 G64 P{p}\n" + "".join(f"G1 X{x:.4f} Y{y:.4f}\n" for x, y in ends) + "M2\n"
    axes = {letter: Axis(letter, 100.0, 1000.0, 5e4) for letter in "XYZ"}
    least = np.inf
    for chord in (3e-4, 1e-3, 3e-3, 1e-2, 3e-2):
        mill = Machine("mill", axes, period_s=0.004, chord_tolerance_mm=chord)
        time = list(pipeline.plan(pipeline.read_text(text), mill))[-1].profile.t[-1]
        assert time <= 1.001 * least
        least = min(least, time)


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
    assert chord_reserve(slow, "XYZ") == pytest.approx(np.sqrt(2.0) * 1000.0 * 1e-6 / 8.0)
    # With a rotary axis it is the tolerance, as where that is less.
    assert chord_reserve(slow, "XYZC") == slow.chord_tolerance_mm
    assert chord_reserve(machine(0.004), "XYZ") == CHORD


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
        times.append(list(pipeline.plan(program, machine(0.004), effort="fast"))[-1].profile.t[-1])
    assert times[0] == pytest.approx(times[1], rel=1e-12)


def seconds(text: str, where: Machine) -> float:
    """Return the time of the motion."""
    *_, last = pipeline.plan(pipeline.read_text(text), where)
    return float(last.profile.t[-1])


HALVES = "".join(f"G{2 + k % 2} X{2 * k + 2} Y0 I1 J0\n" for k in range(8))
STADIUM = "G1 X10\nG3 X10 Y2 I0 J1\nG1 X0\nG3 X0 Y0 I0 J-1\n"


@pytest.mark.parametrize("body", [HALVES, STADIUM], ids=["half circles", "stadium"])
@pytest.mark.parametrize(
    ("period_s", "chord_mm"), [(0.001, 1e-4), (0.004, 1e-3), (0.004, 1e-4), (0.01, 1e-3)]
)
@pytest.mark.parametrize("part", [1.0, 2.0, 30.0])
def test_arcs_that_chords_hold_take_no_longer_for_a_tolerance(
    body: str, period_s: float, chord_mm: float, part: float
) -> None:
    """P of δ, where smoothing had half of it, once took up to 36 % longer than the arcs as they are, and 29 % longer than stops."""
    axes = {letter: Axis(letter, 250.0, 2500.0, 5e4) for letter in "XYZ"}
    where = Machine("held", axes, period_s=period_s, chord_tolerance_mm=chord_mm)
    exact, stopped, rounded = (
        seconds(f"{mode} F4000\n{body}M2\n", where) for mode in ("G61", "G61.1", f"G64 P{part * chord_mm}")
    )
    assert rounded <= 1.001 * stopped
    assert rounded <= 1.045 * exact


def test_a_rotary_axis_that_stands_decides_nothing_about_arcs() -> None:
    """Its jerk is of another unit: where it counted, a slow one had arcs rounded that chords hold."""
    times = []
    for jerk in (1e4, 1e-2):
        axes = {letter: Axis(letter, 250.0, 2500.0, 5e4) for letter in "XYZ"} | {
            "A": Axis("A", 1.0, 1.0, jerk)
        }
        where = Machine("held", axes, period_s=0.004, chord_tolerance_mm=1e-4)
        text = f"G64 P0.0001 F4000\n{HALVES}G61 G1 A0.0001\nM2\n"
        chunks = list(pipeline.plan(pipeline.read_text(text), where, effort="fast"))
        times.append(chunks[-1].profile.t[0])
    assert times[1] == pytest.approx(times[0], rel=1e-3)
