"""Matching setpoints with the path: against a dense reference, and what it says of faults: place, size, end."""

from __future__ import annotations

import itertools
import tracemalloc
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from cncgen.kernels import free_space
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.stream import SetpointStream
from cncgen.verify import Verdict, matching, verify
from cncgen.verify.flatten import FlatPath
from cncgen.verify.matching import Matching
from cncgen.verify.window import MatchWindow
from tests.kernels.plain import uncompiled
from tests.verify import conftest as make

Floats = NDArray[np.float64]


def matched(points: Floats, line: Floats, tolerance: float, block: int = 10**6) -> Matching:
    """Match points with a polyline of one tolerance."""
    count = len(line) - 1
    piece = FlatPath("XY", line, np.arange(1, count + 1), np.full(count, tolerance), np.zeros(count))
    out = Matching(MatchWindow(iter([piece])))
    for first in range(0, len(points), block):
        out.feed(points[first : first + block])
    out.finish()
    return out


def dense(points: Floats, spacing: float) -> Floats:
    """Return places on a polyline at most `spacing` apart."""
    out = [points[:1]]
    for a, b in itertools.pairwise(points):
        parts = max(int(np.ceil(np.linalg.norm(b - a) / spacing)), 1)
        out.append(a + (np.arange(1, parts + 1) / parts)[:, None] * (b - a))
    return np.concatenate(out)


def frechet(one: Floats, two: Floats, spacing: float) -> float:
    """Return the discrete Fréchet distance of dense places (Eiter and Mannila, 1994): the continuous one + spacing at most."""
    a, b = dense(one, spacing), dense(two, spacing)
    gap = np.linalg.norm(a[:, None] - b[None], axis=2)
    best = np.maximum.accumulate(gap[0])
    for row in gap[1:]:
        before = np.minimum(best, np.concatenate([[np.inf], best[:-1]]))
        best = np.maximum(before, row)
        for j in range(1, len(best)):
            best[j] = max(row[j], min(before[j], best[j - 1]))
    return float(best[-1])


def curve(rng: np.random.Generator, kind: int) -> Floats:
    """Return a small nasty polyline: a walk, loops, a cusp, a path gone back over, a doubled circle, steps on the spot."""
    t = np.linspace(0, 1, int(rng.integers(5, 30)))
    if kind == 0:
        return np.cumsum(rng.normal(size=(len(t), 2)) * 0.4, axis=0)
    if kind == 1:
        return np.column_stack([2 * t + 0.6 * np.sin(12 * t), 0.6 * np.cos(12 * t)])
    if kind == 2:
        return np.column_stack([(2 * t - 1) ** 2, (2 * t - 1) ** 3])
    if kind == 3:
        walk = np.cumsum(rng.normal(size=(len(t), 2)) * 0.3, axis=0)
        return np.concatenate([walk, walk[::-1], walk[: len(t) // 2]])
    if kind == 4:
        return np.column_stack([np.cos(4 * np.pi * t), np.sin(4 * np.pi * t)])
    return np.repeat(rng.normal(size=(6, 2)), 3, axis=0)


@given(st.integers(0, 5), st.integers(0, 10**6), st.floats(0.0, 0.4), st.booleans())
def test_the_decision_is_that_of_the_dense_reference(kind: int, seed: int, off: float, cut: bool) -> None:
    """Hold where the reference says so by more than its spacing, and break where it says that; the same in blocks."""
    rng = np.random.default_rng(seed)
    line = curve(rng, kind)
    points = dense(line, 0.25) if not cut else line[rng.random(len(line)) < 0.7]
    if len(points) < 2:
        return
    points = points + rng.uniform(-off, off, points.shape)
    spacing = 0.05
    true = frechet(points, line, spacing)
    for tolerance in (0.02, 0.5 * true, true - 1.2 * spacing, 1.2 * true, 1.0):
        if tolerance < 0.01 or abs(tolerance - true + 0.5 * spacing) < 0.6 * spacing:
            continue
        found = matched(points, line, tolerance)
        assert (not found.faults) == (tolerance >= true), (true, tolerance)
        if found.faults:
            # With the widest leash that was needed all of both can be gone along: no size is understated.
            assert max(fault.leash for fault in found.faults) >= true - 1.2 * spacing
        else:
            assert max(found.out.largest, found.back.largest) <= tolerance * 1.001 + 1e-5
        parts = matched(points, line, tolerance, block=3)
        assert parts.faults == found.faults
        assert (parts.out.value, parts.out.over) == (found.out.value, found.out.over)
        assert parts.back.largest == found.back.largest


@given(st.integers(0, 5), st.integers(0, 10**6), st.floats(0.001, 0.3))
def test_compiled_as_uncompiled(kind: int, seed: int, allowed: float) -> None:
    rng = np.random.default_rng(seed)
    line = curve(rng, kind)
    points = dense(line, 0.3) + rng.uniform(-0.1, 0.1, (1, 2))
    m = len(line) - 1
    limit = allowed * rng.uniform(0.5, 2.0, m)
    results = []
    for kernel in (free_space, uncompiled("free_space")):
        distance, at, during = np.full(m + 1, np.inf), np.zeros(m + 1, np.int64), np.full((m + 1, 2), -1)
        space = kernel.FreeSpace(line, limit, True, distance, at, during, np.empty((4, m)))
        space.enter(0, [0.0], [0.0])
        away, segment = np.zeros(len(points)), np.zeros(len(points), np.int64)
        end = space.run(points, 0, len(points) - 1, 1.0, 0, 0, away, segment)
        dead = end[0]
        end = end + space.run(points, dead, len(points) - 1, 8.0, dead, 0, away, segment)
        results.append((end, space.reached(), space.cells, distance, at, during, away, segment))
    for ours, other in zip(*results, strict=True):
        if isinstance(ours, np.ndarray):
            np.testing.assert_array_equal(ours, other)
        else:
            assert ours == other


def judged(position: Floats, program: object, **options: float) -> Verdict:
    return verify(make.stream(position), [program], make.machine(1e9, 1e13, 1e17), **options)


def codes(verdict: Verdict) -> set[str]:
    return {item.code.removeprefix("verify-") for item in verdict.breaches}


def circle(radius: float, turns: float, count: int) -> Floats:
    angle = np.linspace(0, 2 * np.pi * turns, count)
    return radius * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])


@pytest.mark.parametrize("radius", [0.003, 0.009, 0.05])
def test_a_loop_not_much_larger_than_the_tolerance(radius: float) -> None:
    """Radius 9 µm, P 1.7 µm: the places 20 tolerances ahead are a lap away, and must not be taken for the next ones."""
    for turns in (1, 3):
        program = make.circle(radius, turns=turns, tolerance=0.0017)
        verdict = judged(circle(radius + 0.001, turns, 60 * turns), program)
        assert codes(verdict) == set()
        assert verdict.setpoints_to_path_mm == pytest.approx(0.001, abs=1e-4)


@pytest.mark.parametrize("turns", [1, 2, 4])
def test_a_lap_left_out_or_too_many(turns: int) -> None:
    """Every place is near the other, and a lap is missing or too many: only their order tells."""
    verdict = judged(circle(5.0, turns, 900), make.circle(5.0, turns=3.0, tolerance=0.3))
    assert codes(verdict) & {"order", "coverage", "distance"}
    assert max(item.values["value"] for item in verdict.breaches) >= 4.9
    assert judged(circle(5.0, 3, 900), make.circle(5.0, turns=3.0, tolerance=0.3)).holds


def test_a_way_back_left_out() -> None:
    """10 forward, 5 back, 10 forward, and the motion goes straight: half the way back is the least leash."""
    program = make.polyline([0, 0, 0], [10, 0, 0], [5, 0, 0], [15, 0, 0])
    x = np.linspace(0, 15, 1501)
    verdict = judged(np.column_stack([x, 0 * x, 0 * x]), program)
    for breach in verdict.breaches:
        assert breach.values["value"] == pytest.approx(2.5, rel=2e-3)
        assert breach.values["line"] in (1, 2, 3)
        assert 0.7 <= breach.values["t_s"] <= 1.3
    assert not verdict.holds


@pytest.mark.parametrize("count", [1, 2, 7, 50])
@pytest.mark.parametrize("at", [3, 410, 949])
def test_one_axis_off_by_a_little_more_than_the_tolerance(count: int, at: int) -> None:
    """1.2 P on `count` samples: so far, so many, there, on that line, and no more than that."""
    x = np.linspace(0, 20, 1001)
    position = np.column_stack([x, 0 * x, 0 * x])
    position[at : at + count, 1] += 0.012
    program = make.polyline([0, 0, 0], [8, 0, 0], [20, 0, 0])
    verdict = judged(position, program)
    (breach,) = verdict.breaches
    assert breach.code == "verify-distance"
    assert breach.values["value"] == pytest.approx(0.012, rel=2e-3)
    assert breach.values["samples"] == count
    assert breach.values["first_t_s"] == pytest.approx(0.001 * at, abs=1e-9)
    assert 0.001 * at <= breach.values["t_s"] <= 0.001 * (at + count)
    assert breach.values["line"] == (1 if at < 400 else 2)


def test_a_corner_cut_is_measured_at_the_corner() -> None:
    """The corner is √2 · 0.5 from a chamfer of 1 mm, whatever the tolerance below that."""
    position = np.concatenate([dense(np.array([[0.0, 0, 0], [9, 0, 0], [10, 1, 0], [10, 10, 0]]), 0.05)])
    for tolerance in (0.001, 0.01, 0.3):
        verdict = judged(position, make.polyline([0, 0, 0], [10, 0, 0], [10, 10, 0], tolerance=tolerance))
        found = {item.code: item.values for item in verdict.breaches}
        assert found["verify-coverage"]["value"] == pytest.approx(np.sqrt(0.5), rel=2e-3)
        assert found["verify-coverage"]["t_s"] == pytest.approx(0.194, abs=0.003)
        # The middle of the chamfer is half a millimetre from either leg.
        assert found["verify-distance"]["value"] == pytest.approx(0.5, rel=2e-3)


def test_two_faults_are_two() -> None:
    """The second one is found though the first one was passed with a wide leash."""
    x = np.linspace(0, 20, 1001)
    position = np.column_stack([x, 0 * x, 0 * x])
    position[200:240, 1] = 3.0
    position[700:705, 2] = 0.02
    piece = FlatPath(
        "XYZ", np.array([[0.0, 0, 0], [20.0, 0, 0]]), np.ones(1, np.int64), np.full(1, 0.01), np.zeros(1)
    )
    found = Matching(MatchWindow(iter([piece]), longest=0.1))
    found.feed(position)
    found.finish()
    # The middle of the chord to the first moved sample is off by 1.5 mm, and by no more than the tolerance.
    assert [fault.time for fault in found.faults] == [199.5, 700.0]
    assert [fault.leash for fault in found.faults] == pytest.approx([3.0, 0.02], rel=2e-3)
    assert found.out.over == 45


def test_setpoints_of_another_program_end_as_lost() -> None:
    """A wide tangle: a way past is not looked for without end, and that is said."""
    rng = np.random.default_rng(5)
    line = np.cumsum(rng.normal(size=(4000, 2)), axis=0)
    points = np.cumsum(rng.normal(size=(4000, 2)), axis=0)
    before = matching.PATIENCE
    matching.PATIENCE = 300_000
    try:
        found = matched(points, line, 0.01)
    finally:
        matching.PATIENCE = before
    assert found.lost
    assert found.faults[-1].leash > 0.01


def tolerances_side_by_side(wide: float, narrow: float) -> object:
    first = make.polyline([0, 0, 0], [10, 0, 0], tolerance=wide)
    second = make.polyline([10, 0, 0], [20, 0, 0], tolerance=narrow)
    return [first, second]


@pytest.mark.parametrize(("wide", "narrow"), [(0.1, 0.01), (0.01, 0.1)])
def test_tolerances_change_at_a_vertex(wide: float, narrow: float) -> None:
    """0.05 mm off is within 0.1 and beyond 0.01; where they meet the wider one counts, and no further."""
    x = np.linspace(0, 20, 401)
    y = np.where(x < 9.99, 0.05, 0.0) if wide > narrow else np.where(x > 10.01, 0.05, 0.0)
    position = np.column_stack([x, y, 0 * x])
    toolpaths = tolerances_side_by_side(wide, narrow)
    assert "distance" not in codes(verify(make.stream(position), toolpaths, make.machine(1e9, 1e13, 1e17)))
    late = np.where(x <= 11.0, 0.05, 0.0) if wide > narrow else np.where(x >= 9.0, 0.05, 0.0)
    moved = np.column_stack([x, late, 0 * x])
    assert "distance" in codes(verify(make.stream(moved), toolpaths, make.machine(1e9, 1e13, 1e17)))


def test_rounding_that_is_told_counts_for_distances_too() -> None:
    """Positions of 1 µm are up to 0.71 µm off in the plane: with a tolerance of 0.5 µm that breaks nothing."""
    angle = make.smooth(2 * np.pi, 1.0)
    ring = np.round(10 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]), 3)
    program = make.circle(10.0, tolerance=0.0005)
    machine = make.machine(1e9, 1e13, 1e17)
    tight = type(machine)(machine.name, machine.axes, chord_tolerance_mm=0.0005)
    assert not verify(make.stream(ring), [program], tight).holds
    assert verify(make.stream(ring), [program], tight, resolution=0.001).holds


def test_memory_does_not_grow_with_the_setpoints() -> None:
    """Four times the laps, as many chunks: the same peak (old: 110 bytes a sample)."""

    def peak(laps: int) -> int:
        def chunks() -> Iterator[Setpoints]:
            for lap in range(laps):
                position = circle(10.0, 1, 20_001)[1 if lap else 0 :]
                yield Setpoints("XYZ", 0.001, 20_000 * lap + (lap > 0), position)

        programs = [make.circle(10.0, turns=1.0) for _ in range(laps)]
        tracemalloc.start()
        try:
            verdict = verify(
                SetpointStream("laps", "XYZ", 0.001, chunks()), programs, make.machine(1e9, 1e13, 1e17)
            )
            assert verdict.holds
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    assert peak(12) < 1.2 * peak(3)


def test_long_lines_are_cut_as_they_are_come_to() -> None:
    """A metre, cut to a micrometre: a window never holds all of the million parts."""
    line, turns = np.array([[0.0, 0.0], [1000.0, 0.0], [1000.0, 5.0]]), np.array([0.0, 7.0])
    piece = FlatPath("XY", line, np.array([1, 2]), np.full(2, 0.001), turns)
    window = MatchWindow(iter([piece]), longest=1e-3)
    total, longest, waits = 0, 0.0, []
    while True:
        assert len(window) < 100_000
        longest = max(longest, float(np.linalg.norm(np.diff(window.points, axis=0), axis=1).max()))
        waits += [window.points[k + 1].tolist() for k in np.flatnonzero(window.wait_s)]
        total += len(window) - 1
        window.drop(len(window) - 1)
        if not window.extend():
            break
    # The segments of no length at start and end, and the one that is kept each time, are not counted.
    assert total == 1_005_000 + 1
    assert longest <= 1e-3 * (1 + 1e-9)
    assert waits[0] == [1000.0, 5.0]
