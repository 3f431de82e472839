"""Borders of blocks: nothing that the program asks for, and no limit, is lost where one block of rows ends."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cncgen.machine import Machine, load
from cncgen.pipeline import read_text
from cncgen.planner import PlanOptions, plan
from cncgen.planner.least_time import block_planning
from cncgen.setpoints import sample
from tests.planner.judging import used

#: What a line counts as in blocks, control points.
LINE = 4
MODES = ("G61", "G61.1", "G64 P0.01")


def moved(text: str, machine: Machine, rows: int) -> np.ndarray:
    """Return the setpoints of a program, shape (n, 3), planned in blocks of so many rows."""
    with pytest.MonkeyPatch.context() as patch:
        for size in ("FIRST", "MOST"):
            patch.setattr(block_planning, size, LINE * rows)
        trajectories = plan(read_text(text).chunks(), machine, PlanOptions(feedrate="optimal"))
        return np.concatenate([chunk.position for chunk in sample(trajectories, machine)])


@pytest.mark.parametrize("rest", ["", "G4 P0.01", "M3 S100", "M0"])
@pytest.mark.parametrize("rows", [1, 2, 3, 4])
def test_a_stop_on_a_straight_line_is_one_whichever_block_asks_for_it(rest: str, rows: int) -> None:
    machine = load("generic-mill")
    mode = "G61" if rest else "G61.1"
    steps = [f"G1 X{i}" for i in range(1, 7)]
    text = "\n".join(["G21 G90 " + mode, "F6000", *steps[:3], rest, *steps[3:], "M2"]) + "\n"
    x = moved(text, machine, rows)
    assert used(x, machine) <= 1.001
    # In one block the line is in closed form; cut, it is a spline.
    whole = len(moved(text, machine, 100))
    assert whole - 1 <= len(x) <= 1.1 * whole


word = st.one_of(
    st.tuples(st.just("G1"), st.sampled_from((1e-3, 0.02, 0.3, 4.0)), st.integers(-4, 4)),
    st.tuples(st.sampled_from(("G2", "G3")), st.sampled_from((0.02, 0.3, 4.0)), st.integers(-4, 4)),
    st.tuples(st.sampled_from(("G4 P0.003", "M3 S100", "M7", *MODES)), st.just(0.0), st.just(0)),
)


def program(words: list[tuple[str, float, int]]) -> str:
    """Return lines, half circles, dwells, events and changes of the path mode, in increments."""
    out = ["G21 G91 F6000"]
    for code, size, turn in words:
        way = f" X{size * np.cos(0.4 * turn):.6f} Y{size * np.sin(0.4 * turn):.6f}" if size else ""
        centre = (
            f" I{size * np.cos(0.4 * turn) / 2:.7f} J{size * np.sin(0.4 * turn) / 2:.7f}"
            if code in ("G2", "G3")
            else ""
        )
        out.append(code + way + centre)
    return "\n".join([*out, "M2"]) + "\n"


@settings(max_examples=15)
@given(st.lists(word, min_size=3, max_size=20), st.integers(1, 6))
def test_limits_hold_however_the_program_is_cut_into_blocks(
    words: list[tuple[str, float, int]], rows: int
) -> None:
    machine = load("generic-mill")
    text = program(words)
    x = moved(text, machine, rows)
    assert used(x, machine) <= 1.001
    whole = moved(text, machine, 10_000)
    assert used(whole, machine) <= 1.001
    # What a block does not know is how far the next rest is, which nodes depend on.
    assert len(x) <= 1.1 * len(whole) + 3


def test_rests_close_together_need_no_nodes_far_from_them() -> None:
    machine = load("generic-mill")
    # In blocks of two, the second begins in motion; a rest follows after 20 mm, and another 20 µm further on.
    lines = ["G2 X50 I25 J0", "G2 X100 I25 J0", "G1 Y-20", "G1 X100.02", "G1 Y-19.9", "G1 X100"]
    text = "\n".join(["G21 G90 G61 F6000", *lines, "M2", ""])

    def pieces(rows: int) -> int:
        with pytest.MonkeyPatch.context() as patch:
            for size in ("FIRST", "MOST"):
                patch.setattr(block_planning, size, LINE * rows)
            return sum(len(t.profile.t) for t in plan(read_text(text).chunks(), machine, PlanOptions()))

    assert pieces(2) < 2 * pieces(100)


def test_what_stands_after_the_last_block_stands_when_it_has_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    for size in ("FIRST", "MOST"):
        monkeypatch.setattr(block_planning, size, 2 * LINE)
    text = "G21 G90 G61 F600\nG1 X10\nG1 X20\nM9\nG4 P0.5\nM2\n"
    parts = list(plan(read_text(text).chunks(), load("generic-mill"), PlanOptions()))
    ends = [part.profile.t[-1] for part in parts]
    assert len(parts) > 1
    assert ends[0] > 2.0
    assert parts[1].profile.t[0] == ends[0]
    assert ends[-1] == pytest.approx(ends[0] + 0.5)
    assert all(t >= ends[0] for part in parts[1:] for t, _, _ in part.events)
