"""Corners within G64 P are rounded, and take no longer than passed as they are, or than stops."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from cncgen import pipeline
from cncgen.machine import load
from cncgen.machine.record import Axis, Machine
from cncgen.planner.smoothing import smooth
from cncgen.toolpath.record import Kind, PathMode
from cncgen.toolpath.slicing import between, join
from tests.planner.smoothing.programs import toolpath

PERIOD, JERK = 0.001, 5e4
CORNER = [[10, 0, 0], [10, 10, 0]]


def machine(**jerk: float) -> Machine:
    axes = {letter: Axis(letter, 200.0, 2000.0, jerk.get(letter, JERK)) for letter in "XYZA"}
    return Machine("here", axes, period_s=PERIOD, chord_tolerance_mm=0.001)


def seconds(text: str, where: Machine) -> float:
    """Return the time of a plan along the path that is chosen: these rules choose for it, and estimate its time."""
    return float(list(pipeline.plan(pipeline.read_text(text), where))[-1].profile.t[-1])


def test_corners_within_an_unseen_tolerance_are_met_exactly() -> None:
    rows = toolpath([0, 0, 0], CORNER, tolerance=5e-6)
    (exact,) = smooth([rows], machine())
    assert exact.kind.tolist() == [Kind.LINE, Kind.LINE]
    # Chords share no tolerance with what is not smoothed.
    assert exact.path_mode.tolist() == [PathMode.EXACT_PATH] * 2
    (as_asked,) = smooth([rows])
    assert (as_asked.kind == Kind.NURBS).all()


@pytest.mark.parametrize("size", [1.0, 9.50948])
def test_points_of_a_star_that_turn_back_take_no_longer_than_stops(size: float) -> None:
    """Turns of 144°, P of 3 µm at 4 ms: rounded as far as that allows they took 0.19 and 0.58 % longer."""
    axes = {letter: Axis(letter, 66.95, 978.6, 1e6) for letter in "XY"}
    where = Machine("slow", axes, period_s=0.004, chord_tolerance_mm=0.001)
    angle = 0.8 * np.pi * np.arange(1, 6)
    star = "".join(f"X{size * (np.cos(a) - 1.0):.9f} Y{size * np.sin(a):.9f}\n" for a in angle)
    rounded, stopped = (seconds(f"{mode} G1 F3610\n{star}M2\n", where) for mode in ("G64 P0.003", "G61.1"))
    assert rounded <= 1.001 * stopped


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


@pytest.mark.parametrize(("p", "kinds"), [(1e-5, {Kind.LINE, Kind.NURBS}), (1e-3, {Kind.NURBS})])
def test_corners_do_not_depend_on_how_rows_arrive(p: float, kinds: set[Kind]) -> None:
    """How a row goes on at its other end counts, and so does what went before it: one row at a time and all at once."""
    rng = np.random.default_rng(5)
    heading = np.cumsum(rng.choice([-2.0, -1.0, -0.05, 0.04, 1.5], 300))
    way = np.exp(rng.uniform(np.log(0.02), np.log(5.0), 300))
    ends = np.cumsum(way[:, None] * np.stack([np.cos(heading), np.sin(heading), 0.0 * way], axis=1), axis=0)
    rows = toolpath([0, 0, 0], ends.tolist(), tolerance=p)
    whole = join(list(smooth([rows], machine())))
    single = join(list(smooth((between(rows, k, k + 1) for k in range(300)), machine())))
    assert kinds == set(whole.kind.tolist())
    np.testing.assert_array_equal(whole.kind, single.kind)
    np.testing.assert_array_equal(whole.end, single.end)


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
