"""Where chords hold short programs, no estimate tells which corners to round: the plan is the fastest of three that are made."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

import cncgen
from cncgen.diagnostics import Diagnostic, NoPlanError
from cncgen.machine.record import Axis, Machine
from cncgen.planner import PlanOptions, Trajectory
from cncgen.planner.least_time import plan_blocks, roundings, smooth_blocks
from cncgen.planner.limits.axis_limits import chord_reserve
from cncgen.toolpath.record import Kind, PathMode
from cncgen.toolpath.slicing import between

#: Facets of 3.4 µm on which chords of 0.02 µm hold the speed: the curve through them took 3.4 % longer than stops.
FACETS = """G21 G17 G90 G94
{mode}
G91
G1 X-0.0272918 Y0.0132171 Z-0.0335329 F139.2447197
G1 X0.0272918 Y-0.0132171 Z0.0335329 F139.2447197
G4 P0.012300
G1 X-0.0005756 Y-0.0009420 Z-0.0032647
G1 X-0.0002401 Y-0.0004682 Z-0.0033384
G1 X0.0001426 Y0.0000689 Z-0.0034230
G1 X0.0002429 Y0.0002134 Z-0.0034441
G1 X-0.0000228 Y-0.0001617 Z-0.0033867
G1 X-0.0004294 Y-0.0007360 Z-0.0032965
G1 X-0.0006260 Y-0.0010108 Z-0.0032547
G1 X-0.0004436 Y-0.0007557 Z-0.0032929
M2
"""
FINE = Machine(
    "fine",
    MappingProxyType(
        {
            "X": Axis("X", 3.11, 1158.0, 518400.0),
            "Y": Axis("Y", 1.58, 588.5, 263400.0),
            "Z": Axis("Z", 4.033, 1502.0, 672300.0),
        }
    ),
    period_s=0.0035,
    chord_tolerance_mm=2.16e-5,
    path_tolerance_mm=0.00104,
)


def program(text: str) -> cncgen.Program:
    """Return a program in LinuxCNC's dialect, whose G61.1 stops at all corners."""
    return cncgen.read_text(text, options=cncgen.ReadOptions(dialect="linuxcnc"))


def motion_s(text: str, machine: Machine) -> float:
    """Return what the summary tells of the time of motion."""
    chunks, summary = cncgen.plan_with_summary(program(text), machine, PlanOptions())
    for _ in chunks:
        pass
    return float(summary.as_json()["motion_time_s"])


def turns(seed: int) -> tuple[str, Machine]:
    """Return lines of 20 µm that turn a little, and a machine whose chords hold the speed on them for a third of the time."""
    turn = np.cumsum(np.random.default_rng(seed).uniform(-0.3, 0.3, 12))
    steps = 0.02 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    lines = "\n".join(f"G1 X{x:.6f} Y{y:.6f}" for x, y in steps)
    axes = {a: Axis(a, 200.0, 3000.0, 3e5) for a in "XY"}
    machine = Machine("coarse", MappingProxyType(axes), period_s=0.004, chord_tolerance_mm=3e-5)
    return f"G21 G90 G64 P0.001 F6000\nG91\n{lines}\nM2\n", machine


def test_facets_that_chords_hold_take_no_longer_than_stops() -> None:
    """Stops at all corners are within the limits; once 3.4 % longer."""
    assert motion_s(FACETS.format(mode="G64"), FINE) <= (1.0 + 1e-3) * motion_s(
        FACETS.format(mode="G61.1"), FINE
    )


@pytest.mark.parametrize("seed", range(4))
def test_no_way_to_round_takes_less(seed: int) -> None:
    """As estimated, no corner rounded, and all of them, each planned by itself: the first took up to 17 % longer than the best."""
    text, machine = turns(seed)
    chunks = list(program(text).chunks())
    exact = [replace(c, path_mode=np.full(len(c), PathMode.EXACT_PATH, np.int8)) for c in chunks]
    all_of_them = chord_reserve(machine, chunks[0].axes)
    ways = [
        smooth_blocks(chunks, machine),
        smooth_blocks(exact, machine),
        smooth_blocks(chunks, machine, all_of_them),
    ]
    least = min(moving_s(list(plan_blocks(way, machine))) for way in ways)
    assert motion_s(text, machine) <= (1.0 + 2e-4) * least


def test_a_few_rows_take_no_longer_than_with_their_corners_met() -> None:
    """A line of 0.1 µm before a curve, which chords do not hold: with the first 13 mm fitted it took 0.17 % longer than with a stop."""
    curve = [(-6, -7), (-9, 13), (10, 0), (-12, -7), (-7, -10)]
    heights, knots, weights = (-0.4, -1, 2.6, 2.4, -0.6), (0, 0, 0, 0.5, 0.6), (0.5, 1, 1, 0.5, 0.5)
    rows = [
        f"K{k} X{x} Y{y} Z{z} R{w}" for (x, y), z, k, w in zip(curve, heights, knots, weights, strict=True)
    ]
    start = "X-0.000000093415 Y-0.000000035688 Z0.00000003"
    lines = ["G1 " + start, f"G6.2 P4 K0 {start} R0.5", *rows, *["K1"] * 4, "M2", ""]
    limits = {"X": (41.346, 467.5, 214188.0), "Y": (137.82, 1558.0, 713959.0), "Z": (4.1346, 46.75, 21418.8)}
    axes = {letter: Axis(letter, *each) for letter, each in limits.items()}
    machine = Machine("slow Z", MappingProxyType(axes), 1e-3, 1e-3, 0.1)
    times = [
        motion_s(f"G21 G90 G94 {mode} F36990\n" + "\n".join(lines), machine) for mode in ("G64 P0.1", "G61.1")
    ]
    assert times[0] <= times[1] * (1.0 + 1e-4)


def test_what_is_chosen_keeps_limits_and_tolerance() -> None:
    """By the judge of setpoints, which knows of no plan."""
    text = FACETS.format(mode="G64")
    setpoints = cncgen.sample(cncgen.plan(program(text), FINE)).collect()
    assert cncgen.judge(setpoints, program(text), FINE).holds


def moving_s(plan: list[Trajectory]) -> float:
    """Return the time of a motion without dwells, but for a stand before it starts."""
    first = plan[0].profile
    return float(plan[-1].profile.t[-1] - (first.t[1] if first.waits[0] else 0.0))


def profiles(plan: Iterator[Trajectory]) -> list[np.ndarray]:
    """Return the times of a plan's pieces."""
    return [part.profile.t for part in plan]


def test_a_program_that_is_not_short_has_one_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    """To the bit that of the corners as estimated, and made once, though chords hold it: its first setpoints wait for no other."""
    text, machine = turns(0)
    monkeypatch.setattr(roundings, "SHORT", 8)
    expected = profiles(plan_blocks(smooth_blocks(program(text).chunks(), machine), machine))
    made = []

    def counted(*given: Any) -> Iterator[Trajectory]:
        made.append(given)
        return plan_blocks(*given)

    monkeypatch.setattr(roundings, "plan_blocks", counted)
    found = profiles(roundings.plan_roundings(program(text).chunks(), machine))
    assert len(made) == 1
    assert all(np.array_equal(one, other) for one, other in zip(found, expected, strict=True))


@pytest.mark.parametrize("size", [1, 5, 100])
def test_whether_a_program_is_short_is_no_matter_of_parts(size: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twelve lines as one row each and in five parts, at a bound of twelve rows: three plans; once one of the parts, 5 % longer."""
    text, machine = turns(0)
    (rows,) = program(text).chunks()
    rows = between(rows, 0, 12)
    assert set(rows.kind) == {Kind.LINE}
    monkeypatch.setattr(roundings, "SHORT", len(rows))
    share = np.arange(1, 6)[:, None] / 5.0
    ends = np.concatenate([a + share * (b - a) for a, b in zip(rows.starts, rows.end, strict=True)])
    columns = ("kind", "feed", "feed_mode", "path_mode", "tolerance", "curve", "line", "source")
    parts = replace(rows, end=ends, **{name: np.repeat(getattr(rows, name), 5) for name in columns})
    cut = [between(parts, k, min(k + size, len(parts))) for k in range(0, len(parts), size)]
    seconds = [moving_s(list(roundings.plan_roundings(each, machine))) for each in ([rows], cut)]
    assert seconds[1] == pytest.approx(seconds[0], rel=1e-4)


def test_what_has_no_corners_is_planned_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A circle under G64 whose chords hold it all the way is the same curve however corners are rounded."""
    machine = turns(0)[1]
    made = []

    def counted(*given: Any) -> Iterator[Trajectory]:
        made.append(given)
        return plan_blocks(*given)

    monkeypatch.setattr(roundings, "plan_blocks", counted)
    chunks = program("G21 G91 G64 P0.001 F6000\nG2 X0 Y0 I1\nM2\n").chunks()
    moving, by_chord = roundings.plan_times(list(roundings.plan_roundings(chunks, machine)))
    assert by_chord > 0.5 * moving
    assert len(made) == 1


def test_a_rounding_that_has_no_plan_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first plan stays where the others fail."""
    text, machine = turns(0)
    chunks = list(program(text).chunks())
    first = profiles(plan_blocks(smooth_blocks(chunks, machine), machine))
    made = []

    def failing(*given: Any) -> Iterator[Trajectory]:
        made.append(given)
        if len(made) > 1:
            raise NoPlanError(Diagnostic("no-plan", "none"))
        return plan_blocks(*given)

    monkeypatch.setattr(roundings, "plan_blocks", failing)
    found = profiles(roundings.plan_roundings(chunks, machine))
    assert len(made) == 3
    assert all(np.array_equal(one, other) for one, other in zip(found, first, strict=True))
