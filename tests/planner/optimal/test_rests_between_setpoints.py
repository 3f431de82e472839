"""At coarse periods a corner that is reached at rest between two setpoints would be cut: a setpoint falls on it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cncgen
from cncgen.machine import load
from cncgen.machine.record import Machine
from cncgen.planner.assembly import kept_for_setpoints
from cncgen.planner.record import Limit
from cncgen.report.line_times import LineTimes

HOLES = "G21 G90 G61 F12000\nG0 X5.013\nZ2.007\nG1 Z-0.5\nG4 P0.0005\nG0 X11.1\nZ1.3\nG1 Z0\nM2\n"
CORNERS = {"X": [5.013, 11.1], "Z": [2.007, -0.5, 1.3]}


def machine(period_s: float) -> Machine:
    return replace(load("generic-mill"), period_s=period_s)


@pytest.mark.parametrize("period_s", [0.008, 0.01, 0.02])
def test_setpoints_fall_on_rests_that_chords_would_cut(period_s: float) -> None:
    """With the jerk J a reversal between setpoints is cut by up to J T³/48: 0.5 µm at 8 ms, 1 µm at 10, 8 µm at 20."""
    mill = replace(machine(period_s), chord_tolerance_mm=1e-4)
    program = cncgen.read_text(HOLES)
    setpoints = cncgen.sample(cncgen.plan(program, mill)).collect()
    for letter, places in CORNERS.items():
        column = setpoints.position[:, setpoints.axes.index(letter)]
        for place in places:
            assert np.abs(column - place).min() < 1e-8
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
    missed = np.array([False, True, True, True, False])
    out = kept_for_setpoints(0.25, way, waits, missed, 1.0)
    assert out.tolist() == [0.0, 0.25, 0.75, 0.0, 0.0]


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
