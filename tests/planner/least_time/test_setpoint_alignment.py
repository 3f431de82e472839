"""At coarse periods a corner that is reached at rest between two setpoints would be cut: one falls on it, or near it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType

import numpy as np
import pytest

import cncgen
from cncgen.machine import load
from cncgen.machine.record import Axis, Machine
from cncgen.planner import PlanOptions, plan
from cncgen.planner.record import Limit
from cncgen.report.line_times import LineTimes

HOLES = "G21 G90 G61 F12000\nG0 X5.013\nZ2.007\nG1 Z-0.5\nG4 P0.0005\nG0 X11.1\nZ1.3\nG1 Z0\nM2\n"
CORNERS = {"X": [5.013, 11.1], "Z": [2.007, -0.5, 1.3]}


def machine(period_s: float) -> Machine:
    return replace(load("generic-mill"), period_s=period_s)


@pytest.mark.parametrize("period_s", [0.008, 0.01, 0.02])
def test_setpoints_come_as_near_to_rests_as_the_chord_tolerance(period_s: float) -> None:
    """With the jerk J a reversal between setpoints is cut by up to J T³/48: 0.5 µm at 8 ms, 1 µm at 10, 8 µm at 20."""
    mill = replace(machine(period_s), chord_tolerance_mm=1e-4)
    program = cncgen.read_text(HOLES)
    setpoints = cncgen.sample(cncgen.plan(program, mill)).collect()
    for letter, places in CORNERS.items():
        column = setpoints.position[:, setpoints.axes.index(letter)]
        for place in places:
            assert np.abs(column - place).min() < mill.chord_tolerance_mm
    assert cncgen.judge(setpoints, program, mill).holds


def test_no_time_is_spent_where_chords_cut_less_than_their_tolerance() -> None:
    """At 1 ms a reversal is cut by 1 nm: plans for two periods that short last the same time."""
    program = cncgen.read_text(HOLES)
    one, other = (list(cncgen.plan(program, machine(period)))[-1].profile.t[-1] for period in (0.001, 0.0011))
    assert one == pytest.approx(other, abs=1e-12)


#: Limits that jerk alone is felt of: legs up to some mm take 4 (L/(2 J))^(1/3), and leave a rest, as they reach one, by J t³/6.
JERK, MARGIN, PERIOD, CHORD = 1e5, 0.9993, 0.02, 1e-3
JERKY = Machine(
    "jerky",
    MappingProxyType({a: Axis(a, 1e4, 1e5, JERK) for a in "XY"}),
    period_s=PERIOD,
    chord_tolerance_mm=CHORD,
)


def motion_s(places: Sequence[tuple[float, float]]) -> float:
    """Return the time of lines with exact stops."""
    text = "\n".join(f"G1 X{x:.6f} Y{y:.6f}" for x, y in places)
    return end_s(f"G21 G90 G61.1 F1000000\n{text}\nM2\n", JERKY)


def end_s(text: str, mill: Machine) -> float:
    """Return when a plan ends."""
    program = cncgen.read_text(text, options=cncgen.ReadOptions(dialect="linuxcnc"))
    (*_, last) = plan(program.chunks(), mill, PlanOptions())
    return float(last.profile.t[-1])


def waited(legs: Sequence[float], cut: Callable[[float, float], float]) -> float:
    """Return the time of legs, each rest between them the shortest with a setpoint near enough, by trying 20,001 waits.

    Args:
        legs: Lengths, mm, that last a period at least.
        cut: How far the chord between setpoints so far, in mm, before and after a rest is from it.
    """

    def gone(t: float) -> float:
        return MARGIN * JERK * max(t, 0.0) ** 3 / 6.0

    t = 0.0
    for length in legs[:-1]:
        t += 4.0 * (length / (2.0 * MARGIN * JERK)) ** (1 / 3)
        since = t % PERIOD
        due = PERIOD - since
        waits = np.linspace(0.0, due, 20_001)
        t += next(wait for wait in waits if cut(gone(since), gone(due - wait)) <= CHORD)
    return t + 4.0 * (legs[-1] / (2.0 * MARGIN * JERK)) ** (1 / 3)


@pytest.mark.parametrize("seed", range(4))
def test_a_turn_back_waits_until_a_setpoint_is_within_the_tolerance_of_it(seed: int) -> None:
    """The nearer of both setpoints counts: what is beside the chord is on the path (once twice their harmonic mean counted)."""
    legs = np.random.default_rng(seed).uniform(0.3, 2.0, 12).round(6)
    x = np.cumsum(legs * (-1.0) ** np.arange(12))
    assert motion_s([(place, 0.0) for place in x]) == pytest.approx(waited(legs, min), abs=2e-4 * PERIOD)


@pytest.mark.parametrize("seed", range(4))
def test_a_right_angle_waits_until_its_chord_is_within_the_tolerance(seed: int) -> None:
    """The height of the triangle of both ways is a b/√(a² + b²)."""
    legs = np.random.default_rng(seed).uniform(0.3, 2.0, 12).round(6)
    places = [(legs[: 2 * k + 1 : 2].sum(), legs[1 : 2 * k : 2].sum()) for k in range(7)]
    stairs = [place for x, y in pairwise(places) for place in ((x[0], y[1]), y)]
    # From (legs[0], 0): the first leg is the second one of the stairs.
    stairs = [(legs[0], 0.0), *((x, y) for x, y in stairs)][:12]

    def height(a: float, b: float) -> float:
        return a * b / np.hypot(a, b) if a > 0.0 and b > 0.0 else 0.0

    assert motion_s(stairs) == pytest.approx(waited(legs, height), abs=2e-4 * PERIOD)


def test_waits_do_not_depend_on_where_blocks_and_windows_end() -> None:
    """3000 turns back, two blocks of rows and the windows in them: a setpoint is within (6 δ/J)^(1/3) of each, and no sooner."""
    legs = np.random.default_rng(5).uniform(0.3, 2.0, 3000).round(6)
    x = np.cumsum(legs * (-1.0) ** np.arange(3000))
    near, t = (6.0 * CHORD / (MARGIN * JERK)) ** (1 / 3), 0.0
    for lasts in 4.0 * (legs / (2.0 * MARGIN * JERK)) ** (1 / 3):
        since = t % PERIOD
        t += lasts + (max(PERIOD - since - near, 0.0) if since > near else 0.0)
    assert motion_s([(place, 0.0) for place in x]) == pytest.approx(t, abs=0.01 * PERIOD)


def test_what_a_chord_goes_over_within_the_tolerance_is_not_waited_for() -> None:
    """Back by 0.3 µm and on: the chord over both turns lies on the path (once a setpoint fell on the first)."""
    legs = [1.5, 3e-4, 1.5]
    expected = sum(4.0 * (length / (2.0 * MARGIN * JERK)) ** (1 / 3) for length in legs)
    assert motion_s([(1.5, 0.0), (1.4997, 0.0), (2.9997, 0.0)]) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_a_path_and_its_reverse_take_as_many_setpoints(seed: int) -> None:
    """The setpoints of one, backwards, are a motion of the other: whoever waits least differs by less than a period."""
    legs = 10.0 ** np.random.default_rng(seed).uniform(-4.0, 0.3, 40)
    x = np.cumsum(legs * (-1.0) ** np.arange(40)).round(6)
    x = np.concatenate([[0.0], x])
    there, back = (motion_s([(p - way[0], 0.0) for p in way[1:]]) for way in (x, x[::-1]))
    assert np.ceil(there / PERIOD) == np.ceil(back / PERIOD)


def plan_of(legs: np.ndarray) -> tuple[float, float]:
    """Return the time of turns back with exact stops, and of them what is waited before the first motion."""
    text = "\n".join(f"G1 X{x:.6f}" for x in np.cumsum(legs * (-1.0) ** np.arange(len(legs))))
    program = cncgen.read_text(
        f"G21 G90 G61.1 F1000000\n{text}\nM2\n", options=cncgen.ReadOptions(dialect="linuxcnc")
    )
    (*_, last) = done = list(plan(program.chunks(), JERKY, PlanOptions()))
    first = done[0].profile
    return float(last.profile.t[-1]), float(first.t[1]) if first.waits[0] else 0.0


@pytest.mark.parametrize("seed", range(8))
def test_a_short_path_and_its_reverse_take_as_long(seed: int) -> None:
    """Less than the hundredth that is asked; once up to a period of some twenty, 2.7 %, and a stand before the start is none of it."""
    legs = np.random.default_rng(seed).uniform(0.3, 2.0, 6).round(6)
    (there, stood), (back, waited_first) = plan_of(legs), plan_of(legs[::-1])
    assert max(stood, waited_first) < PERIOD
    assert back - waited_first == pytest.approx(there - stood, rel=2e-3)
    # No setpoint more than where the motion starts at once.
    least = waited(legs, min)
    assert np.ceil(there / PERIOD) == np.ceil(least / PERIOD)
    assert there - stood <= least + 1e-3 * PERIOD


def test_the_summary_counts_no_stand_before_the_first_motion() -> None:
    """Time of motion, and that of lines, is from when the axes leave to when they arrive, but for dwells."""
    mill = replace(machine(0.02), chord_tolerance_mm=1e-4)
    program = cncgen.read_text(HOLES.replace("G4 P0.0005\n", ""))
    first = next(iter(cncgen.plan(program, mill))).profile
    stood = float(first.t[1])
    assert first.waits[0]
    assert 0.0 < stood < mill.period_s
    chunks, summary = cncgen.plan_with_summary(program, mill, PlanOptions())
    assert list(chunks)[-1].time_s[-1] >= float(first.t[-1])
    assert summary.as_json()["motion_time_s"] == pytest.approx(float(first.t[-1]) - stood, abs=1e-12)
    assert summary.as_json()["dwell_time_s"] == 0.0


def test_what_is_waited_for_a_setpoint_is_no_dwell_of_the_program() -> None:
    """It belongs to the line that ends there: only G4 dwells, half a millisecond at least, one period at most."""
    mill = replace(machine(0.02), chord_tolerance_mm=1e-4)
    lines = LineTimes()
    waits, stood = {Limit.CHORD: 0.0, Limit.STOP: 0.0}, 0.0
    for part in cncgen.plan(cncgen.read_text(HOLES), mill):
        lines.add(part)
        p = part.profile
        still = (p.v == 0) & (p.a == 0) & (p.j == 0) & (p.c == 0)
        for limit in waits:
            waits[limit] += float(np.diff(p.t)[still & (p.limit == limit)].sum())
        stood += p.t[1] if still[0] and p.t[0] == 0.0 else 0.0
        end = p.t[-1]
    assert waits[Limit.CHORD] > 0.02
    assert 0.0005 <= waits[Limit.STOP] < 0.0205
    # What a dwell is lengthened by is not told apart from it.
    assert lines.total_s == pytest.approx(end - stood - waits[Limit.STOP] + 0.0005, abs=1e-9)
