"""At coarse periods a corner that is reached at rest between two setpoints would be cut: one falls on it, or near it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cncgen
from cncgen.machine import load
from cncgen.machine.record import Machine
from cncgen.planner.assembly import Cuts, kept_for_setpoints
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


def test_waits_are_lengthened_up_to_the_next_setpoint() -> None:
    """Worked by hand, T = 1 s from t = 0.25: arrivals at 0.75 (to 1), 1.5 (a dwell of 0.75 has 2 in it), 3 (on time)."""
    way = np.array([0.0, 0.5, 1.0, 1.75, 2.0])
    waits = np.array([0.0, 0.0, 0.75, 0.0, 0.0])
    cuts = Cuts(np.array([1, 2, 3]), np.zeros(3), np.zeros((3, 2)), np.ones((3, 2)), np.ones((3, 2)))
    out = kept_for_setpoints(0.25, way, waits, cuts, 1.0)
    assert out.tolist() == [0.0, 0.25, 0.75, 0.0, 0.0]


@pytest.mark.parametrize("phase", [0.05, 0.3, 0.5, 0.6, 0.95])
@pytest.mark.parametrize("room", [1e-4, 1e-3, 0.01, 0.03])
def test_a_wait_ends_as_soon_as_the_chord_is_near_enough(phase: float, room: float) -> None:
    """T = 1 s, jerks of 1 and 2 mm/s³, A out of reach: a = τ³/6 before, b = τ³/3 after; a b/(a + b) by trying all waits."""
    cuts = Cuts(
        np.array([1]), np.array([room]), np.zeros((1, 2)), np.full((1, 2), 1e3), np.array([[1.0, 2.0]])
    )
    out = kept_for_setpoints(0.0, np.array([0.0, 3.0 + phase]), np.zeros(2), cuts, 1.0)
    waits = np.linspace(0.0, 1.0 - phase, 100_001)
    before, after = phase**3 / 6.0, (1.0 - phase - waits) ** 3 / 3.0
    assert out[1] == pytest.approx(waits[np.argmax(before * after <= room * (before + after))], abs=1e-4)


def test_a_corner_near_the_next_one_has_a_setpoint() -> None:
    """T = 1 s, with room enough: the rest at 1.5 s is followed by one at 2.2 s, within a period."""
    cuts = Cuts(np.array([1, 2]), np.full(2, 10.0), np.zeros((2, 2)), np.ones((2, 2)), np.ones((2, 2)))
    out = kept_for_setpoints(0.0, np.array([0.0, 1.5, 2.2]), np.zeros(3), cuts, 1.0)
    assert out.tolist() == [0.0, 0.5, 0.0]


def test_what_is_waited_for_a_setpoint_is_no_dwell_of_the_program() -> None:
    """It belongs to the line that ends there: only G4 dwells, half a millisecond at least, one period at most."""
    mill = replace(machine(0.02), chord_tolerance_mm=1e-4)
    lines = LineTimes()
    waits = {Limit.CHORD: 0.0, Limit.STOP: 0.0}
    for part in cncgen.plan(cncgen.read_text(HOLES), mill):
        lines.add(part)
        p = part.profile
        still = (p.v == 0) & (p.a == 0) & (p.j == 0) & (p.c == 0)
        for limit in waits:
            waits[limit] += float(np.diff(p.t)[still & (p.limit == limit)].sum())
        end = p.t[-1]
    assert waits[Limit.CHORD] > 0.02
    assert 0.0005 <= waits[Limit.STOP] < 0.0205
    # What a dwell is lengthened by is not told apart from it.
    assert lines.total_s == pytest.approx(end - waits[Limit.STOP] + 0.0005, abs=1e-9)
