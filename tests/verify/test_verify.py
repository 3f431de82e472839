"""The judge: motions with closed forms pass, and each kind of fault is found where it is."""

from __future__ import annotations

import importlib.util
import itertools
from dataclasses import replace
from pathlib import Path as FilePath
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cncgen
from cncgen import pipeline
from cncgen.diagnostics import Severity, UsageError
from cncgen.geometry.tables import ArcTable, NurbsTable
from cncgen.machine import Machine, load_machine
from cncgen.toolpath.record import Kind, PathMode
from cncgen.verify import Verdict, verify
from cncgen.verify.flatten import CHORD_MM, flatten
from cncgen.verify.limits import AxisJudge

spec = importlib.util.spec_from_file_location("verify_fixtures", FilePath(__file__).parent / "conftest.py")
assert spec is not None
assert spec.loader is not None
make: ModuleType = importlib.util.module_from_spec(spec)
spec.loader.exec_module(make)


def codes(verdict: Verdict) -> list[str]:
    return [d.code for d in verdict.breaches]


def line_motion(length: float = 10.0, time_s: float = 0.5) -> np.ndarray:
    s = make.smooth(length, time_s)
    return np.column_stack([s, np.zeros_like(s), np.zeros_like(s)])


def test_a_line_with_closed_form_peaks() -> None:
    """v = 2L/T = 40, a = 2πL/T² = 251.3, j = 4π²L/T³ = 3158.3; differences at 1 ms come within 0.1 % and below."""
    verdict = verify(make.stream(line_motion()), [make.polyline([0, 0, 0], [10, 0, 0])], make.machine())
    assert verdict.holds, codes(verdict)
    found = {p.order: p.value for p in verdict.peaks if p.axis == "X"}
    assert found["velocity"] == pytest.approx(40.0, rel=1e-3)
    assert found["acceleration"] == pytest.approx(2 * np.pi * 10 / 0.25, rel=1e-3)
    assert found["jerk"] == pytest.approx(4 * np.pi**2 * 10 / 0.125, rel=1e-2)
    assert verdict.setpoints_to_path_mm < 1e-9
    assert verdict.path_to_setpoints_mm < 1e-9


@pytest.mark.parametrize(
    ("limits", "code"),
    [
        ({"velocity": 39.9}, "verify-velocity"),
        ({"acceleration": 251.0}, "verify-acceleration"),
        ({"jerk": 3140.0}, "verify-jerk"),
    ],
)
def test_each_limit_is_found_just_below_the_peak(limits: dict[str, float], code: str) -> None:
    verdict = verify(
        make.stream(line_motion()), [make.polyline([0, 0, 0], [10, 0, 0])], make.machine(**limits)
    )
    assert codes(verdict) == [code]
    breach = next(iter(verdict.breaches))
    assert breach.values["axis"] == "X"
    assert breach.values["line"] == 1
    assert 0.0 <= breach.values["t_s"] <= 0.5


def test_velocity_breach_is_placed_at_its_time() -> None:
    verdict = verify(
        make.stream(line_motion()), [make.polyline([0, 0, 0], [10, 0, 0])], make.machine(velocity=39.9)
    )
    assert next(iter(verdict.breaches)).values["t_s"] == pytest.approx(0.25, abs=2e-3)


def test_a_start_that_is_no_rest_is_found() -> None:
    moving = np.column_stack([np.linspace(0, 10, 201), np.zeros(201), np.zeros(201)])
    verdict = verify(make.stream(moving), [make.polyline([0, 0, 0], [10, 0, 0])], make.machine())
    assert set(codes(verdict)) == {"verify-acceleration", "verify-jerk"}
    assert next(iter(verdict.breaches)).values["t_s"] in (0.0, 0.2)


def test_travel() -> None:
    motion = line_motion() + np.array([495.0, 0, 0])
    verdict = verify(make.stream(motion), [make.polyline([495, 0, 0], [505, 0, 0])], make.machine())
    assert codes(verdict) == ["verify-travel"]
    assert next(iter(verdict.breaches)).values["value"] == pytest.approx(505.0)


@given(offset=st.floats(0.002, 0.05), radius=st.floats(1.0, 200.0))
def test_distance_of_a_circle_with_an_offset_radius(offset: float, radius: float) -> None:
    """Setpoints on radius r + d are d from the circle, and the circle is d from them."""
    angle = make.smooth(2 * np.pi, 4.0)
    ring = (radius + offset) * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    wide = make.machine(1e9, 1e9, 1e12)
    verdict = verify(make.stream(ring), [make.circle(radius, tolerance=0.01)], wide)
    chord = (radius + offset) * (1 - np.cos(np.diff(angle).max() / 2))
    assert verdict.setpoints_to_path_mm == pytest.approx(offset, abs=chord + 2e-6)
    assert verdict.path_to_setpoints_mm == pytest.approx(offset, abs=chord + 2e-6)
    assert ("verify-distance" in codes(verdict)) == (verdict.setpoints_to_path_mm > 0.01 * 1.001 + 2e-6)


def test_chords_are_judged_and_not_samples_alone() -> None:
    """Every sample on the circle, chords 0.0613 mm inside: R (1 − cos(π/90))."""
    angle = np.linspace(0, 2 * np.pi, 91)
    ring = 100 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    verdict = verify(make.stream(ring), [make.circle(100.0)], make.machine(1e9, 1e9, 1e12))
    assert set(codes(verdict)) == {"verify-distance", "verify-coverage"}
    sagitta = 100 * (1 - np.cos(np.pi / 90))
    assert verdict.setpoints_to_path_mm == pytest.approx(sagitta, rel=1e-3)
    assert verdict.path_to_setpoints_mm == pytest.approx(sagitta, rel=1e-3)


def test_a_path_left_out_is_found() -> None:
    """A drill stroke of 5 mm that the setpoints leave out: every sample is on the path, and the path is not covered."""
    program = make.polyline([0, 0, 0], [5, 0, 0], [5, 0, -5], [5, 0, 0], [10, 0, 0])
    verdict = verify(make.stream(line_motion()), [program], make.machine())
    assert codes(verdict) == ["verify-coverage"]
    breach = next(iter(verdict.breaches))
    assert breach.values["value"] == pytest.approx(5.0, abs=1e-6)
    assert breach.values["line"] in (2, 3)


def test_there_and_back_again_is_followed_branch_by_branch() -> None:
    out = line_motion()
    verdict = verify(
        make.stream(np.concatenate([out, out[::-1]])),
        [make.polyline([0, 0, 0], [10, 0, 0], [0, 0, 0])],
        make.machine(),
    )
    assert verdict.holds, codes(verdict)
    half = verify(make.stream(out), [make.polyline([0, 0, 0], [10, 0, 0], [0, 0, 0])], make.machine())
    assert codes(half) == ["verify-coverage"]
    turned = verify(make.stream(out[::-1]), [make.polyline([0, 0, 0], [10, 0, 0])], make.machine())
    assert "verify-distance" in codes(turned)


@given(st.floats(0.3, 3.0), st.floats(0.01, 0.05))
def test_a_tip_between_two_samples_makes_no_distance(time_s: float, tolerance: float) -> None:
    """There and back with the tip passed between two samples: nothing is off the path but the tip itself."""
    out = make.smooth(10.0, time_s)
    out = out[out < 10 - 0.2 * tolerance]
    back = out[::-1] - 0.3 * tolerance
    s = np.concatenate([out, back[back > 0], [0.0]])
    motion = np.column_stack([s, 0 * s, 0 * s])
    program = make.polyline([0, 0, 0], [10, 0, 0], [0, 0, 0], tolerance=tolerance)
    verdict = verify(make.stream(motion), [program], make.machine(1e9, 1e12, 1e15))
    assert verdict.holds, codes(verdict)
    assert verdict.setpoints_to_path_mm <= 0.02 * tolerance + 2e-6


grid = st.lists(st.tuples(*[st.integers(-2, 2)] * 3), min_size=2, max_size=12)


@given(grid, st.integers(2, 30), st.floats(0.001, 0.2), st.integers(0, 99))
def test_setpoints_on_the_path_are_on_it_however_it_turns(
    corners: list[tuple[int, int, int]], steps: int, tolerance: float, seed: int
) -> None:
    """Random paths that cross, touch and go back over themselves, with the rounding of nine decimals."""
    if all(corner == corners[0] for corner in corners):
        return
    points = [np.array(corner, float) for corner in corners]
    parts = [np.linspace(a, b, steps, endpoint=False) for a, b in itertools.pairwise(points)]
    motion = np.concatenate([*parts, points[-1:]])
    motion += np.random.default_rng(seed).uniform(-5e-10, 5e-10, motion.shape)
    program = make.polyline(*[list(map(float, corner)) for corner in corners], tolerance=tolerance)
    verdict = verify(make.stream(motion), [program], make.machine(1e9, 1e12, 1e15))
    assert verdict.holds, codes(verdict)
    assert verdict.setpoints_to_path_mm <= 0.02 * tolerance + 2e-6
    assert verdict.path_to_setpoints_mm <= 0.02 * tolerance + 2e-6


@given(grid, st.integers(0, 10), st.integers(5, 30))
def test_a_leg_left_out_is_always_found(corners: list[tuple[int, int, int]], leg: int, steps: int) -> None:
    """Leave out the corner at the end of a leg: the path is not covered, unless the corner is on the way anyway."""
    points = [np.array(corner, float) for corner in corners]
    index = 1 + leg % max(len(points) - 1, 1)
    if index >= len(points) - 1:
        return
    a, b, c = points[index - 1], points[index], points[index + 1]
    off = np.linalg.norm(b - a - np.clip((b - a) @ (c - a) / max((c - a) @ (c - a), 1e-9), 0, 1) * (c - a))
    if off < 0.1:
        return
    kept = [p for k, p in enumerate(points) if k != index]
    parts = [np.linspace(p, q, steps, endpoint=False) for p, q in itertools.pairwise(kept)]
    motion = np.concatenate([*parts, kept[-1:]])
    program = make.polyline(*[list(map(float, corner)) for corner in corners], tolerance=0.01)
    verdict = verify(make.stream(motion), [program], make.machine(1e9, 1e12, 1e15))
    assert "verify-coverage" in codes(verdict)


def test_an_early_end_is_found() -> None:
    motion = line_motion(9.0)
    verdict = verify(make.stream(motion), [make.polyline([0, 0, 0], [10, 0, 0])], make.machine())
    assert codes(verdict) == ["verify-coverage"]
    assert verdict.path_to_setpoints_mm == pytest.approx(1.0, abs=1e-6)


def test_a_corner_cut_within_and_beyond_its_tolerance() -> None:
    """A chamfer with legs c passes c / √2 from the corner."""
    for leg, good in ((0.012, True), (0.016, False)):
        corner = np.array([[0, 0, 0], [5 - leg, 0, 0], [5, leg, 0], [5, 5, 0]])
        steps = [np.linspace(a, b, 50, endpoint=False) for a, b in itertools.pairwise(corner)]
        motion = np.concatenate([*steps, corner[-1:]])
        wide = make.machine(1e9, 1e12, 1e15)
        verdict = verify(make.stream(motion), [make.polyline([0, 0, 0], [5, 0, 0], [5, 5, 0])], wide)
        assert verdict.path_to_setpoints_mm == pytest.approx(leg / np.sqrt(2), rel=1e-6)
        assert verdict.holds == good


def test_a_program_that_only_waits_stands_still() -> None:
    """Its setpoints are one place; others leave it."""
    machine = cncgen.load_machine("xy-table")
    for text in ("G21\nG4 P0.02\nM2\n", "M3 S100\nM2\n"):
        points = cncgen.sample(cncgen.plan(cncgen.read_text(text), machine)).collect()
        still = make.stream(np.repeat(points.position, 5, axis=0), points.axes)
        verdict = pipeline.judge(still, cncgen.read_text(text), machine)
        assert verdict.holds
        assert verdict.path_to_setpoints_mm == verdict.setpoints_to_path_mm == 0.0
    moved = pipeline.judge(make.stream(line_motion()), cncgen.read_text(text), machine)
    assert "verify-distance" in codes(moved)
    assert moved.setpoints_to_path_mm == pytest.approx(10.0)


def test_a_corner_that_the_path_comes_back_to() -> None:
    """A chamfer on the first of two laps is nearer to a leg of the second one, which is not yet its turn."""
    corners = [[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0], [0, 0, 0], [10, 0, 0], [7, 7, 0]]
    cut = [[0, 0, 0], [9.99, 0, 0], [10, 0.01, 0], *corners[2:]]
    steps = [np.linspace(a, b, 200, endpoint=False) for a, b in itertools.pairwise(np.array(cut, float))]
    motion = np.concatenate([*steps, [corners[-1]]])
    program = make.polyline(*[list(map(float, corner)) for corner in corners])
    verdict = verify(make.stream(motion), [program], make.machine(1e9, 1e12, 1e15))
    assert verdict.holds
    # The middle of the chamfer is 5 µm from each leg.
    assert verdict.setpoints_to_path_mm == pytest.approx(0.005, rel=1e-9)


def test_tolerance_in_force_row_by_row() -> None:
    """0.02 mm off is within G64 P0.05 and beyond G61 (the chord tolerance of 1 µm)."""
    motion = line_motion() + np.array([0, 0.02, 0])
    wide = make.machine(1e9, 1e9, 1e12)
    loose = make.polyline([0, 0, 0], [10, 0, 0], tolerance=0.05)
    exact = make.polyline([0, 0, 0], [10, 0, 0], tolerance=0.05, mode=PathMode.EXACT_PATH)
    unsaid = make.polyline([0, 0, 0], [10, 0, 0], tolerance=np.nan)
    assert verify(make.stream(motion), [loose], wide).holds
    assert not verify(make.stream(motion), [exact], wide).holds
    assert not verify(make.stream(motion), [unsaid], wide).holds
    assert verify(make.stream(motion), [unsaid], wide, tolerance_mm=0.03).holds


def test_setpoints_where_no_machine_is_are_refused() -> None:
    """Their differences overflow: a velocity of inf would be told, beside warnings of numpy."""
    x = line_motion()
    x[50, 0] = 1e308
    with pytest.raises(UsageError, match=r"setpoints-range.*setpoint 50 of axis X is 1e\+308"):
        verify(make.stream(x), [make.polyline([0, 0, 0], [10, 0, 0])], make.machine())


def test_axes_that_do_not_match() -> None:
    program = make.polyline([0, 0, 0], [10, 0, 0])
    flat = make.stream(line_motion()[:, :2], "XY")
    assert verify(flat, [program], make.machine()).holds
    missing = verify(
        make.stream(line_motion()[:, :1], "X"), [make.polyline([0, 0, 0], [10, 3, 0])], make.machine()
    )
    assert "verify-axis" in codes(missing)
    only_x = Machine("x", {"X": make.machine().axes["X"]})
    tilted = line_motion() * [1, 0, 0] + np.column_stack([np.zeros(501), make.smooth(3, 0.5), np.zeros(501)])
    assert "verify-axis" in codes(verify(make.stream(tilted), [make.polyline([0, 0, 0], [10, 3, 0])], only_x))
    with pytest.raises(UsageError, match="none is common"):
        verify(make.stream(line_motion()[:, :1], "A"), [program], make.machine())
    with pytest.raises(UsageError, match="no path to follow"):
        verify(make.stream(line_motion()), [], make.machine())


def test_rounding_to_nine_decimals_breaks_nothing() -> None:
    """At 10 kHz the ninth decimal alone makes jerks of 2³ · 0.5e-9 / 1e-12 = 4000 mm/s³."""
    s = np.round(make.smooth(10.0, 0.5, 1e-4), 9)
    motion = np.column_stack([s, 0 * s, 0 * s])
    limits = make.machine(velocity=40.1, acceleration=252.0, jerk=3160.0)
    verdict = verify(make.stream(motion, period_s=1e-4), [make.polyline([0, 0, 0], [10, 0, 0])], limits)
    assert verdict.holds, codes(verdict)


def length(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def test_a_helix_is_flattened_to_its_chord() -> None:
    arcs = ArcTable(np.array([[1.0, 2.0, 0.0]]), np.array([[0.0, 0.0, -1.0]]), np.array([4 * np.pi]))
    program = make.toolpath([11.0, 2, 0], [(Kind.ARC, [11.0, 2, -3], 0)], arcs=arcs)
    (path,) = flatten([program], make.machine())
    centred = path.points - [1.0, 2.0, 0.0]
    np.testing.assert_allclose(np.hypot(centred[:, 0], centred[:, 1]), 10.0, atol=1e-12)
    np.testing.assert_allclose(np.diff(path.points[:, 2]), -3 / len(path), atol=1e-12)
    middle = 0.5 * (centred[1:] + centred[:-1])
    assert 10.0 - np.hypot(middle[:, 0], middle[:, 1]).min() <= CHORD_MM * 1.0001
    assert length(path.points) == pytest.approx(np.hypot(40 * np.pi, 3), rel=1e-6)
    # Clockwise: a little after the start the point is below the centre's height.
    assert centred[1, 1] < 0


def test_a_nurbs_circle_is_flattened_to_its_chord() -> None:
    """The seven-point quadratic circle of radius 10 (Piegl and Tiller, The NURBS Book, section 7.5)."""
    root = np.sqrt(3)
    control = 10 * np.array(
        [
            [0, -1, 0],
            [root, -1, 0],
            [root / 2, 0.5, 0],
            [0, 2, 0],
            [-root / 2, 0.5, 0],
            [-root, -1, 0],
            [0, -1, 0],
        ]
    )
    third = 1 / 3
    table = NurbsTable(
        np.array([2]),
        np.array([0, 7]),
        np.array([0, 10]),
        control,
        np.array([1, 0.5, 1, 0.5, 1, 0.5, 1.0]),
        np.array([0, 0, 0, third, third, 2 * third, 2 * third, 1, 1, 1]),
    )
    program = make.toolpath([0, -10, 0], [(Kind.NURBS, [0, -10, 0], 0)], nurbs=table)
    (path,) = flatten([program], make.machine())
    np.testing.assert_allclose(np.linalg.norm(path.points, axis=1), 10.0, atol=1e-12)
    middle = 0.5 * (path.points[1:] + path.points[:-1])
    assert 10.0 - np.linalg.norm(middle, axis=1).min() <= CHORD_MM * 1.01
    assert length(path.points) == pytest.approx(20 * np.pi, rel=1e-6)


def test_what_rounding_hides_is_said() -> None:
    """At 1 µs half a unit of the ninth decimal makes 8 · 0.5e-9 / 1e-18 = 4e9 mm/s³ of a third difference."""
    x = make.smooth(0.1, 0.04, 1e-6)
    position = np.column_stack([np.round(x, 9), np.zeros((len(x), 2))])
    verdict = verify(
        make.stream(position, period_s=1e-6), [make.polyline([0, 0, 0], [0.1, 0, 0])], make.machine()
    )
    notes = [item for item in verdict.breaches if item.severity == Severity.NOTE]
    assert {item.code for item in notes} == {"verify-rounding"}
    acceleration, jerk = (item.message for item in notes if item.values["axis"] == "X")
    assert "acceleration is not judged" in acceleration
    assert "2e+03 mm/s²" in acceleration
    assert "jerk is not judged" in jerk
    assert "4e+09 mm/s³" in jerk
    assert verdict.holds


def test_a_corner_cut_too_far_on_a_path_that_crosses_itself_is_no_other_branch() -> None:
    """Samples 0.05 mm apart on waves row above row, whose ends fall between two samples: chords cut by 25 µm at most.

    The rows cross each other hundreds of times; a place that is off by more than its tolerance must not be looked for
    on one of the rows to come.
    """
    k = np.arange(4000)
    points = np.column_stack([k % 200 * 0.05, 3.0 * np.sin(k / 7.0) + 0.0005 * k, 0.0 * k])
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    s = np.append(np.arange(0.0, lengths[-1], 0.05), lengths[-1])
    position = np.column_stack([np.interp(s, lengths, points[:, c]) for c in range(3)])
    path = make.polyline(*points.tolist(), tolerance=0.01)
    verdict = verify(make.stream(position), [path], make.machine(1e3, 1e9, 1e12))
    assert "verify-coverage" in {item.code for item in verdict.breaches}
    assert verdict.setpoints_to_path_mm <= 0.051
    assert verdict.path_to_setpoints_mm <= 0.051


def test_a_resolution_that_is_told_is_allowed_for() -> None:
    """Positions of 1 µm at 4 ms make up to 8 · 0.5e-3 / 0.004³ = 62500 mm/s³ of nothing."""
    x = np.round(make.smooth(100.0, 2.0, 0.004), 3)
    position = np.column_stack([x, np.zeros((len(x), 2))])
    path, limits = make.polyline([0, 0, 0], [100, 0, 0]), make.machine(101.0, 170.0, 70_000.0)

    def judged(resolution: float) -> Verdict:
        return verify(make.stream(position, period_s=0.004), [path], limits, resolution=resolution)

    assert not judged(1e-9).holds
    assert "3 decimals: --resolution 0.001" in next(iter(judged(1e-9).breaches)).hint
    assert judged(1e-3).holds


def test_where_one_axis_turns_back_on_a_curve_the_path_reaches_the_turn() -> None:
    """A goes 2 · 0.83 u (1 − u) + 0.2 u² and turns at u = 0.83/1.46, between places that the path is cut at to begin with."""
    text = "G21 G90 G61\nG6.2 P3 K0 A0 R1 F1000\nK0 A0.83 R1\nK0 A0.2 R1\nK1\nK1\nK1\nM2\n"
    machine = cncgen.load_machine("generic-mill")
    points = np.concatenate([each.points for each in flatten(cncgen.read_text(text).chunks(), machine)])
    assert points[:, 3].max() == pytest.approx(0.83**2 / 1.46, abs=1e-6)


def test_far_positions_may_have_the_rounding_of_doubles() -> None:
    """An axis stands midway between two ninth decimals, which a file writes in turn.

    At 1e6 mm doubles are 1.16e-10 mm apart, so the two decimals are read as 1.05e-9 mm apart: 4.19 mm/s³ at 1 ms, where the
    decimals alone explain 4.
    """
    axis = replace(load_machine("xy-table").axes["X"], max_jerk=1e-3)
    judge = AxisJudge(axis, 1e-3, 1e-9)
    position = np.tile([1e6, float("1000000.000000001")], 500)
    judge.feed(position, np.ones(1000, np.int64))
    assert [peak.broken for peak in judge.finish()[0]] == [0, 0, 0]
    judge = AxisJudge(axis, 1e-3, 1e-9)
    position[::2] -= 1e-9
    judge.feed(position, np.ones(1000, np.int64))
    assert judge.finish()[0][2].broken > 0
