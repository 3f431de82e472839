"""RowCorners are rounded as far as that takes less time than to pass them as they are, or to stop."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from cncgen import pipeline
from cncgen.machine import load
from cncgen.machine.record import Axis, Machine
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.smoothing import rounding_decision, smooth, stream
from cncgen.planner.smoothing.rounding_decision import rounding
from cncgen.planner.smoothing.row_corners import BEND, TWIST, RowCorners
from cncgen.planner.smoothing.tolerance_estimate import chord_need
from cncgen.toolpath.record import Kind, PathMode
from cncgen.toolpath.slicing import between, join
from tests.planner.smoothing.programs import toolpath

PERIOD, JERK = 0.001, 5e4
CORNER = [[10, 0, 0], [10, 10, 0]]


def machine(**jerk: float) -> Machine:
    axes = {letter: Axis(letter, 200.0, 2000.0, jerk.get(letter, JERK)) for letter in "XYZA"}
    return Machine("here", axes, period_s=PERIOD, chord_tolerance_mm=0.001)


def corner(tolerance: float, turn: float = 1.0, length: float = 10.0, feed: float = 100.0) -> RowCorners:
    """Return one corner in the plane, beside rows of one length."""
    leave = np.array([[1.0, 0.0, 0.0]])
    entry = np.array([[np.cos(turn), np.sin(turn), 0.0]])
    rows = np.full((2, 1), length)
    feeds, straight = np.full((2, 1), feed), np.zeros((2, 1))
    return RowCorners(leave, entry, rows, feeds, np.array([tolerance]), np.ones(1, bool), straight)


def seconds(text: str, where: Machine) -> float:
    """Return the time of a plan along the path that is chosen: these rules choose for it, and estimate its time."""
    return float(list(pipeline.plan(pipeline.read_text(text), where, effort="fast"))[-1].profile.t[-1])


@pytest.mark.parametrize("s", [0.0, 0.3, 1.0, 2.5, 7.0])
def test_the_response_of_a_turn(s: float) -> None:
    """h(s) = (1/π) ∫ cos ωs/(1 + ω⁶) dω by scipy's quadrature."""
    integral = quad(lambda w: np.cos(w * s) / (1.0 + w**6), 0, 60, limit=800)[0] / np.pi
    assert rounding_decision.response(np.array([s]))[0] == pytest.approx(integral, abs=1e-9)


def test_what_is_largest_of_the_response() -> None:
    s = np.linspace(0.0, 6.0, 60_001)
    h = rounding_decision.response(s)
    assert h.max() == pytest.approx(BEND, rel=1e-9)
    assert np.abs(np.gradient(h, s)).max() == pytest.approx(TWIST, rel=1e-3)


def test_a_stop_costs_the_time_of_its_ramps_against_going_on() -> None:
    """v/a + a/j from rest to v on half the way that v covers: half of it is lost."""
    side = rounding_decision.CornerSide(*(np.array([x]) for x in (1000.0, 5e4, 100.0)))
    assert side.lost(np.zeros(1)) == pytest.approx(0.5 * (100.0 / 1000.0 + 1000.0 / 5e4))
    assert side.lost(np.array([100.0])) == 0.0
    assert side.crawled(np.array([2.0]), np.array([10.0])) == pytest.approx(2.0 / 10.0 - 2.0 / 100.0)


def test_what_setpoints_do_not_see_is_met_exactly() -> None:
    """P of a few nanometres: the way through the corner is slow, and no faster than none."""
    drive = AxisLimits.of(machine(), "XYZ").in_mm()
    given = [1e-6, 1e-5, 5e-3, 1e-2]
    met = [rounding(drive, corner(p))[0][0] == 0.0 for p in given]
    assert met == [True, True, False, False]


def test_the_speed_is_what_the_limits_leave_of_the_turn() -> None:
    """L = 3 P/|Δ|, P less the room of chords; by jerk v³ 0.1475 Δ/L² = J, by acceleration v² Δ/(3 L) = A, by that room."""
    turn = np.array([1.0 - np.cos(1.0), np.sin(1.0)])
    drive = AxisLimits.of(machine(), "XYZ").in_mm()
    for tolerance in (0.01, 5.0):
        need = float(chord_need(drive, corner(tolerance))[0])
        kept = min(need, 1.03 * drive.chord_reserve_mm)
        length = 3.0 * (tolerance - kept) / np.linalg.norm(turn)
        by_jerk = np.cbrt(JERK * length**2 / (0.1475 * turn.max()))
        by_acceleration = np.sqrt(3.0 * 2000.0 * length / turn.max())
        chord = kept if kept < 1.03 * drive.chord_reserve_mm else drive.chord_reserve_mm
        by_chord = 2.0 / PERIOD * np.sqrt(2.0 * chord * 3.0 * length / np.linalg.norm(turn) - chord**2)
        assert by_chord > 0.99 * min(by_jerk, by_acceleration)
        _, speed = rounding(drive, corner(tolerance))
        assert speed[0] == pytest.approx(min(by_jerk, by_acceleration, by_chord), rel=1e-12)


def test_corners_within_an_unseen_tolerance_are_met_exactly() -> None:
    rows = toolpath([0, 0, 0], CORNER, tolerance=5e-6)
    (exact,) = smooth([rows], 0.001, machine())
    assert exact.kind.tolist() == [Kind.LINE, Kind.LINE]
    # Chords share no tolerance with what is not smoothed.
    assert exact.path_mode.tolist() == [PathMode.EXACT_PATH] * 2
    (as_asked,) = smooth([rows], 0.001)
    assert (as_asked.kind == Kind.NURBS).all()


def test_rows_that_a_tolerance_covers_are_rounded_together() -> None:
    short = corner(1e-5, length=1e-6)
    assert rounding(AxisLimits.of(machine(), "XYZ").in_mm(), short)[0].tolist() == [np.inf]


def seconds_with(length: float, text: str, where: Machine, monkeypatch: pytest.MonkeyPatch) -> float:
    """Return the time of a plan whose corners are all rounded with one smoothing length, 0 for none."""

    def forced(drive: AxisLimits, corners: RowCorners, *rest: Any) -> tuple[np.ndarray, np.ndarray]:
        _, speed = rounding(drive, corners, *rest)
        return np.full(len(speed), length), speed

    with monkeypatch.context() as each:
        each.setattr(stream, "rounding", forced)
        return seconds(text, where)


def corner_program(tolerance: float, turn: float) -> str:
    """Two lines of 30 mm."""
    end = 30.0 + 30.0 * np.cos(turn), 30.0 * np.sin(turn)
    return f"G64 P{tolerance} G1 F2400\nX30 Y0\nX{end[0]:.9f} Y{end[1]:.9f}\nM2\n"


def test_the_tolerance_is_used_as_far_as_chords_let_it_be_worth(monkeypatch: pytest.MonkeyPatch) -> None:
    """δ of 0.1 µm at 2 ms allows v² κ of 200 mm/s²: the speed grows with √L, the way with L, so more P is of no use.

    Of plans with lengths √2 apart, none takes 0.1 % less than the one that is chosen.
    """
    where = Machine("slow", machine().axes, period_s=0.002, chord_tolerance_mm=1e-4)
    drive, turn = AxisLimits.of(where, "XYZ").in_mm(), 2.4
    lengths = [rounding(drive, corner(p, turn, 30.0, 40.0))[0][0] for p in (0.03, 0.1, 0.3)]
    assert 0.0 < lengths[0] < 0.05
    assert lengths == pytest.approx([lengths[0]] * 3, rel=1e-12)
    text = corner_program(0.03, turn)
    tried = [
        seconds_with(length, text, where, monkeypatch) for length in 0.05 * 0.5 ** np.arange(0.0, 7.0, 0.5)
    ]
    assert max(tried) > 1.0005 * min(tried)
    assert seconds(text, where) <= 1.001 * min(tried)


@pytest.mark.parametrize("size", [1.0, 9.50948])
def test_points_of_a_star_that_turn_back_take_no_longer_than_stops(size: float) -> None:
    """Turns of 144°, P of 3 µm at 4 ms: rounded as far as that allows they took 0.19 and 0.58 % longer."""
    axes = {letter: Axis(letter, 66.95, 978.6, 1e6) for letter in "XY"}
    where = Machine("slow", axes, period_s=0.004, chord_tolerance_mm=0.001)
    angle = 0.8 * np.pi * np.arange(1, 6)
    star = "".join(f"X{size * (np.cos(a) - 1.0):.9f} Y{size * np.sin(a):.9f}\n" for a in angle)
    rounded, stopped = (seconds(f"{mode} G1 F3610\n{star}M2\n", where) for mode in ("G64 P0.003", "G61.1"))
    assert rounded <= 1.001 * stopped


@pytest.mark.parametrize(
    ("period", "p", "turn", "jerk"),
    [(0.004, 2e-3, 0.5, 6e4), (0.004, 1e-3, 1.0, 6e4), (0.01, 3e-3, 0.5, 2e4), (0.008, 1e-3, 2.0, 6e4)],
)
def test_a_corner_within_the_chord_tolerance_is_rounded_where_that_is_faster(
    period: float, p: float, turn: float, jerk: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """P = δ, two lines of 4 mm: of plans with lengths √2 apart, and with none, none takes 0.1 % less than what is chosen.

    With 0.4 L more to be passed at the speed that jerk allows, and half a way of a period, the first three were stops (1 to 2 %).
    """
    axes = {letter: Axis(letter, 100.0, 1000.0, jerk) for letter in "XY"}
    where = Machine("slow", axes, period_s=period, chord_tolerance_mm=p)
    text = f"G64 P{p} G1 F3000\nX4 Y0\nX{4 + 4 * np.cos(turn):.9f} Y{4 * np.sin(turn):.9f}\nM2\n"
    lengths = (0.0, *(3.0 * p / turn * 0.5 ** np.arange(0.0, 3.0, 0.5)))
    tried = [seconds_with(length, text, where, monkeypatch) for length in lengths]
    assert seconds(text, where) <= 1.001 * min(tried)


def test_what_is_passed_faster_than_it_is_rounded_is_met_exactly() -> None:
    """A turn of 0.18 at 10 ms and 9 mm/s, which chords of 7 µm allow at 16: no time is lost, so 0.5 µm of P are of no use."""
    drive = replace(
        AxisLimits.of(machine(), "XYZ").in_mm(), period_s=0.01, chord_mm=0.0073, chord_reserve_mm=0.0073
    )
    passed = rounding(drive, corner(5e-4, 0.18, 20.0, 9.0))[0]
    assert passed.tolist() == [0.0]


@pytest.mark.parametrize(("period", "chord"), [(0.004, 3e-4), (0.004, 5e-4), (0.004, 2e-3), (0.002, 1e-4)])
def test_what_chords_make_of_a_corner_is_estimated_as_plans_have_it(
    period: float, chord: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A zigzag of right angles rounded with lengths of 5 to 100 µm, against stops: what is chosen takes 0.25 % more than the best at most (stops, once chosen, 2 %)."""
    axes = {letter: Axis(letter, 100.0, 1000.0, 5e4) for letter in "XY"}
    where = Machine("slow", axes, period_s=period, chord_tolerance_mm=chord)
    text = "G64 P0.1 G1 F6000\n" + "".join(f"X{5 * k} Y{5 * (k % 2)}\n" for k in range(1, 5)) + "M2\n"
    lengths = (0.0, 0.005, 0.01, 0.02, 0.035, 0.05, 0.1)
    tried = [seconds_with(length, text, where, monkeypatch) for length in lengths]
    assert seconds(text, where) <= 1.0025 * min(tried)


@pytest.mark.parametrize("p", [2e-6, 1e-5, 1e-4])
@pytest.mark.parametrize("rise", [0.06, 5.0])
def test_a_tolerance_that_is_not_seen_costs_no_time(p: float, rise: float) -> None:
    """Once a tolerance of a few nanometres took up to a tenth more than none."""
    rows = "".join(f"G1 X{7 * k} Y{rise * (k % 2)}\n" for k in range(1, 9))
    times = [seconds(f"G21 G90 F9000 {mode}\n{rows}M2\n", machine()) for mode in ("G61", f"G64 P{p:.7f}")]
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
    given = ["\n".join([f"G21 G90 {mode} F3000", *rows, "M2", ""]) for mode in ("G64 P0.002", "G61.1")]
    one, other = (seconds(text, load("generic-mill")) for text in given)
    assert one <= other


def test_a_rotary_axis_that_hardly_changes_its_pace_is_no_reason_to_creep() -> None:
    """P of 0.6 µm, δ of 5: where the radius is less than δ/2 the chord formula once left 0.4 µm/s of 86 µm/s (7 % longer)."""
    axes = {letter: Axis(letter, 90.0, 4900.0, 76_000.0) for letter in "XYZ"}
    axes["A"] = Axis("A", 8.2, 445.0, 6911.0)
    where = Machine("fast", axes, period_s=0.001, chord_tolerance_mm=0.005)
    rows = "F29641\nG1 X0.549 A50.8\nG1 X-3.3 Y5.3 A562.1\nM2\n"
    one, other = (seconds(f"G21 G90 {mode} {rows}", where) for mode in ("G64 P0.000575", "G61.1"))
    assert one <= 1.001 * other


@pytest.mark.parametrize("angle", [40.0, 90.0, 144.0])
@pytest.mark.parametrize("chord", [1e-4, 1e-3])
def test_more_tolerance_takes_no_more_time(angle: float, chord: float) -> None:
    """At 4 ms and δ = 0.1 µm chords bound the speed: P of 0.1 mm once took up to twice as long as a stop at each corner."""
    where = Machine("slow", machine().axes, period_s=0.004, chord_tolerance_mm=chord)
    turns = np.radians(angle) * np.array([0, 1, 2, 1, 0])
    ends = np.cumsum(6.0 * np.stack([np.cos(turns), np.sin(turns)], axis=1), axis=0)
    rows = "".join(f"G1 X{x:.4f} Y{y:.4f}\n" for x, y in ends)
    modes = ["G61.1", *(f"G64 P{p}" for p in (0.001, 0.01, 0.1))]
    times = [seconds(f"G21 G90 F6000 {mode}\n{rows}M2\n", where) for mode in modes]
    assert all(later <= 1.001 * former for former, later in pairwise(times))


@pytest.mark.parametrize("p", [1.8e-4, 2.4e-4, 3.2e-4, 4.2e-4, 7.5e-4])
@pytest.mark.parametrize("chord", [3e-4, 1e-3, 1e-2])
def test_slow_corners_take_no_longer_than_stops(p: float, chord: float) -> None:
    """A zigzag at 4 ms whose rounded corners are slower than J T²: they took up to 0.5 % longer."""
    axes = {letter: Axis(letter, 100.0, 1000.0, 5e4) for letter in "XY"}
    where = Machine("slow", axes, period_s=0.004, chord_tolerance_mm=chord)
    rows = "".join(f"G1 X{5 * k} Y{5 * (k % 2)}\n" for k in range(1, 13))
    one, other = (seconds(f"G21 G90 F6000 {mode}\n{rows}M2\n", where) for mode in (f"G64 P{p}", "G61.1"))
    assert one <= 1.001 * other


@pytest.mark.parametrize(
    ("p", "kinds"), [(1e-5, {Kind.LINE, Kind.NURBS}), (2e-4, {Kind.LINE, Kind.NURBS}), (1e-3, {Kind.NURBS})]
)
def test_corners_do_not_depend_on_how_rows_arrive(p: float, kinds: set[Kind]) -> None:
    """How a row goes on at its other end counts, and so does what went before it: one row at a time and all at once."""
    rng = np.random.default_rng(5)
    heading = np.cumsum(rng.choice([-2.0, -1.0, -0.05, 0.04, 1.5], 300))
    way = np.exp(rng.uniform(np.log(0.02), np.log(5.0), 300))
    ends = np.cumsum(way[:, None] * np.stack([np.cos(heading), np.sin(heading), 0.0 * way], axis=1), axis=0)
    rows = toolpath([0, 0, 0], ends.tolist(), tolerance=p)
    whole = join(list(smooth([rows], None, machine())))
    single = join(list(smooth((between(rows, k, k + 1) for k in range(300)), None, machine())))
    assert kinds == set(whole.kind.tolist())
    np.testing.assert_array_equal(whole.kind, single.kind)
    np.testing.assert_array_equal(whole.end, single.end)


def test_what_bends_chords_is_across_the_path() -> None:
    """|x'' ∧ x'|/|x'| by minors, everywhere on the way: of two directions, and of one beside which an axis stops to turn."""
    rng = np.random.default_rng(2)
    leave, entry = rng.normal(size=(2, 40, 4))
    for side in (leave, entry):
        side[:, :3] /= np.linalg.norm(side[:, :3], axis=1)[:, None]
    leave[:, 3] *= np.repeat([0.0, 30.0], 20)
    entry[:20, 3] = 0.0
    s = np.linspace(-30.0, 30.0, 6001)
    h = rounding_decision.response(np.abs(s))
    part = (np.cumsum(h) - 0.5 * h) * (s[1] - s[0])
    i, j = np.triu_indices(4, 1)
    for k, found in enumerate(rounding_decision.largest_bend(leave, entry)):
        turn = entry[k] - leave[k]
        x1 = leave[k] + part[:, None] * turn
        if np.linalg.norm(x1, axis=1).min() < 0.3:
            continue  # a peak between the places that are looked at here
        minors = x1[:, i] * turn[j] - x1[:, j] * turn[i]
        exact = h * np.linalg.norm(minors, axis=1) / np.linalg.norm(x1, axis=1)
        assert 0.7 * exact.max() <= found <= 1.01 * exact.max()


@pytest.mark.parametrize("chord", [1e-4, 1e-3])
def test_short_rows_beside_long_ones_are_not_dragged_along(chord: float) -> None:
    """At 4 ms and δ = 0.1 µm a row of 26 µm between long ones was rounded with them within 0.1 mm: 18 % over stops."""
    ends = [(0.9485, -0.3167), (0.9255, -0.3037), (0.3029, -2.1124), (0.2201, -2.0936), (-0.3558, -1.7194)]
    ends.append((-0.0797, -2.6806))
    axes = {letter: Axis(letter, 228.65, 794.3, 265_000.0) for letter in "XYZ"}
    where = Machine("slow", axes, period_s=0.004, chord_tolerance_mm=chord)
    rows = "".join(f"G1 X{x} Y{y}\n" for x, y in ends)
    stops, wide = (seconds(f"G21 G90 F1708 {mode}\n{rows}M2\n", where) for mode in ("G61.1", "G64 P0.1"))
    assert wide <= 1.001 * stops


def test_what_is_worth_less_tolerance_is_not_given_up_with_more() -> None:
    """Where chords bound the speed the same smoothing lengths are tried whatever P is: more of it takes the same one."""
    where = Machine("slow", machine().axes, period_s=0.004, chord_tolerance_mm=1e-4)
    drive = AxisLimits.of(where, "XYZ").in_mm()
    lengths = [
        rounding(drive, corner(p, turn=2.4, length=30.0, feed=40.0))[0][0] for p in (0.01, 0.013, 0.1, 1.0)
    ]
    assert np.isfinite(lengths).all()
    np.testing.assert_allclose(lengths, lengths[0], rtol=1e-12)


def fast(limits: tuple[float, float, float], period: float, chord: float) -> Machine:
    axes = {letter: Axis(letter, *limits) for letter in "XYZ"}
    return Machine("fast", axes, period_s=period, chord_tolerance_mm=chord)


@pytest.mark.parametrize(
    ("limits", "period", "chord", "tolerance"),
    [((100.0, 2e6, 2e10), 5.4e-5, 1.41e-5, 0.0237), ((1e4, 5e8, 2e11), 8.1e-5, 1.03e-5, 4.9)],
)
@pytest.mark.parametrize("corners", [1, 4, 9])
def test_what_chords_hold_below_the_speed_from_stop_to_stop_is_not_rounded(
    limits: tuple[float, float, float], period: float, chord: float, tolerance: float, corners: int
) -> None:
    """Within P larger than the lines δ of 10 nm lets a curve be passed slower than lines from stop to stop: up to ten times."""
    turns = np.array([0.0, 1.2, 0.4, -0.9, 0.3, 1.5, 0.1, -1.1, 0.5, 1.3])[: corners + 1]
    way = np.array([25.0, 14.0, 31.0, 18.0, 22.0, 36.0, 17.0, 27.0, 33.0, 21.0])[: corners + 1] * 1e-3
    ends = np.cumsum(way[:, None] * np.stack([np.cos(turns), np.sin(turns)], axis=1), axis=0)
    rows = "".join(f"G1 X{x:.6f} Y{y:.6f}\n" for x, y in ends)
    where = fast(limits, period, chord)
    stops, wide = (
        seconds(f"G21 G90 F400000 {mode}\n{rows}M2\n", where) for mode in ("G61.1", f"G64 P{tolerance}")
    )
    assert wide <= 1.001 * stops


def test_a_wave_of_short_rows_that_chords_hold_is_not_rounded() -> None:
    """L of each turn alone was longer than the wave lets it be, and its bend too little: it took half as long again as stops."""
    x = [39, 74, 112, 142, 178, 202, 233, 264, 293, 323, 358, 387, 430, 462, 499]
    x += [531, 569, 608, 643, 676, 704, 733, 765, 791, 822, 854, 888, 926, 960, 993]
    y = [-51, -79, -111, -112, -94, -56, -17, 42, 92, 130, 145, 152, 134, 86, 44]
    y += [-1, -41, -71, -72, -65, -29, 20, 68, 118, 160, 181, 188, 168, 136, 90]
    rows = "".join(f"G1 X{1e-4 * a:.4f} Y{1e-4 * b:.4f}\n" for a, b in zip(x, y, strict=True))
    where = fast((1000.0, 2.6e6, 2.6e9), 1.7e-4, 1e-5)
    stops, wide = (
        seconds(f"G21 G90 F100000 {mode}\n{rows}M2\n", where) for mode in ("G61.1", "G64 P0.005906975")
    )
    assert wide <= 1.001 * stops


def test_the_bend_of_many_corners_is_that_of_the_curve_behind_them() -> None:
    """Facets of a circle, much shorter than L: the second difference of the polyline is 1/R, and of one corner Δ/(3 L)."""
    radius, turn, count = 5.0, 0.02, 400
    heading = turn * np.arange(count + 1)
    ways = np.stack([np.cos(heading), np.sin(heading), 0.0 * heading], axis=1)
    facet = 2.0 * radius * np.sin(0.5 * turn)
    chain = RowCorners(
        ways[:-1],
        ways[1:],
        np.full((2, count), facet),
        np.full((2, count), 100.0),
        np.full(count, 0.01),
        np.ones(count, bool),
        np.zeros((2, count)),
    )
    course = rounding_decision.CornerPolyline.of(chain, chain.joined)
    assert course.bend(np.array([200]), np.array([0.3]))[0] == pytest.approx(1.0 / radius, rel=0.01)
    one = corner(0.01, length=50.0)
    alone = rounding_decision.CornerPolyline.of(one, one.joined).bend(np.array([0]), np.array([0.3]))
    assert alone[0] == pytest.approx(2.0 * np.sin(0.5) / 0.9, rel=1e-9)


def test_a_way_between_turns_is_not_that_of_a_part() -> None:
    """Rows of 1, 2, 3, 4 and 5 mm that turn after the second and go straight on elsewhere; then with an end of the run."""
    length = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    still = np.zeros((4, 3))
    size = np.array([0.0, 0.5, 0.0, 1e-8])
    for joined, after in ((True, [2.0, 12.0, 9.0, 5.0]), (False, [2.0, 7.0, 4.0, 5.0])):
        corners = RowCorners(
            still,
            still,
            np.stack([length[:-1], length[1:]]),
            np.ones((2, 4)),
            np.ones(4),
            np.array([True, True, True, joined]),
            np.zeros((2, 4)),
        )
        ways = rounding_decision.ways_between_turns(corners, size)
        np.testing.assert_allclose(ways, [[1.0, 3.0, 3.0, 7.0], after])
