"""Corners of which an estimate does not tell whether to pass them: both ways are planned, within a bound on the work."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import pytest

import cncgen
from cncgen.machine.record import Axis, Machine
from cncgen.planner.least_time import corner_trials

#: Lines at 0.39 ms, of which one is 140 nm long, and passed corners on both sides of it.
SHORT_LINES = (
    {"X": (5.32, 1371.0, 1.38e6), "Y": (6.515, 271.1, 272900.0), "Z": (49.88, 12850.0, 1.294e7)},
    0.00039,
    4.19e-5,
    """G1 X0.001076600 Y-0.001962678 Z0.002889300 F60.3345447
G1 X0.001077245 Y-0.001962885 Z0.002889700
G1 X0.001162445 Y-0.001838992 Z0.002799259
G4 P0.010000
G1 X0.001157620 Y-0.001837787 Z0.002801635 F118.9799534
G1 Y-0.001552592 Z0.002481689
""",
    "G20",
)
#: A NURBS of 30 µm at 1.2 ms, whose knots are corners.
KNOTS = (
    {"X": (6.305, 9470.0, 1.763e7), "Y": (0.7144, 1073.0, 1.998e6), "Z": (108.3, 162700.0, 3.029e8)},
    0.0012,
    0.001,
    """G1 X-0.004966 Y-0.000787 Z-0.003861 F133.1927582
G6.2 P3 K0.0 X-0.004966 Y-0.000787 Z-0.003861 R1 F6405779.1235152
K0.0 X0.005231 Y0.004813 Z-0.010658 R1
K0.0 X-0.003614 Y0.003549 Z-0.006009 R1
K0.031402035 X-0.003614 Y0.003549 Z-0.006009 R1
K0.075901625 X-0.006069 Y-0.002415 Z-0.007024 R1
K0.310083837 X-0.006069 Y-0.002415 Z-0.007024 R1
K0.347514606 X-0.006831 Y0.008242 Z0.014245 R1
K0.769246499 X-0.006831 Y0.008242 Z0.014245 R1
K1.0
K1.0
K1.0
G1 X-0.006833 Y0.008246 Z0.014247 F6405779.1235152
""",
    "G21",
)


@pytest.mark.parametrize("case", [SHORT_LINES, KNOTS])
def test_passing_corners_takes_no_longer_than_stops(case: tuple) -> None:
    """By the estimate alone these took 0.8 and 2.4 % more with corners passed than with a stop at each."""
    limits, period, chord, moves, units = case
    machine = Machine(
        "corners",
        MappingProxyType({letter: Axis(letter, *each) for letter, each in limits.items()}),
        period_s=period,
        chord_tolerance_mm=chord,
    )
    passed, stopped = (
        _seconds(f"{units} G17 G90 G94 {mode}\n{moves}M2\n", machine) for mode in ("G61", "G61.1")
    )
    assert passed <= 1.001 * stopped


def test_a_polygon_of_lines_of_some_periods_takes_no_longer_than_with_stops() -> None:
    """60 corners at 10 ms, which chords of 0.1 µm hold: with trials of the first of them alone it took 0.8 % more."""
    axes = {letter: Axis(letter, 100.0, 1000.0, 5e4) for letter in "XY"}
    machine = Machine("coarse", axes, period_s=0.01, chord_tolerance_mm=1e-4)
    at = 2.0 * np.pi * np.arange(1, 61) / 60.0
    rows = "".join(f"X{10.0 * np.cos(a) - 10.0:.6f} Y{10.0 * np.sin(a):.6f}\n" for a in at)
    passed, stopped = (_seconds(f"G21 G90 {mode} G1 F6000\n{rows}M2\n", machine) for mode in ("G61", "G61.1"))
    assert passed <= 1.001 * stopped


@pytest.mark.parametrize("seed", range(5))
def test_a_path_and_its_reverse_are_tried_in_the_same_pieces(seed: int) -> None:
    """Of 1200 nodes at most, one after the other, parted at stops; once they were cut from the start on."""
    draw = np.random.default_rng(seed)
    node = np.unique(np.concatenate([[0, 9001], draw.integers(1, 9001, 200)]))
    stop = draw.random(len(node)) < 0.5
    stop[[0, -1]] = True
    pieces = corner_trials.trial_pieces(node, stop)
    back = corner_trials.trial_pieces(9001 - node[::-1], stop[::-1])
    assert [(9001 - end, 9001 - start) for start, end in back[::-1]] == pieces
    assert [start for start, _ in pieces] == [0, *(end for _, end in pieces[:-1])]
    assert max(end - start for start, end in pieces) <= corner_trials.SIZE


def test_trials_cost_a_bounded_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """2100 corners, each in doubt or nearly: what is tried is a few pieces, however long the program is."""
    tried = []
    plan = corner_trials.plan_trial

    def counted(piece: object, *rest: object) -> None:
        tried.append(piece)
        plan(piece, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(corner_trials, "plan_trial", counted)
    turn = np.cumsum(np.random.default_rng(5).uniform(-0.05, 0.05, 2100))
    x, y = np.cumsum(np.cos(turn)), np.cumsum(np.sin(turn))
    rows = "\n".join(f"G1 X{a:.5f} Y{b:.5f}" for a, b in zip(x, y, strict=True))
    _seconds(f"G21 G90 G61 F6000\n{rows}\nM2\n", cncgen.load_machine("generic-mill"))
    assert 0 < len(tried) <= corner_trials.MOST / corner_trials.EACH + 10


def _seconds(text: str, machine: Machine) -> float:
    return max(
        float(part.profile.t[-1]) for part in cncgen.plan(cncgen.read_text(text, "corners.nc"), machine)
    )
