"""Planning in threads: the plan is that of its chunks together, and nothing is left of one that ends early."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import numpy as np
import pytest

import cncgen
from cncgen.planner import plan
from cncgen.planner.least_time.block_planning import blocks
from cncgen.toolpath.record import Toolpath


def _chunks(rows: int) -> Iterator[Toolpath]:
    """A curve of 18000 short segments, in chunks."""
    turn = np.linspace(0.0, 120.0, 18001)
    points = np.stack([20.0 * np.cos(turn), 15.0 * np.sin(1.3 * turn)], axis=1).round(3)
    lines = "\n".join(f"X{x} Y{y}" for x, y in points)
    return blocks(cncgen.read_text(f"G21 G64 P0.01 G1 F3000\n{lines}\n").chunks(), 4 * rows, 4 * rows)


def _threads() -> int:
    return sum(thread.name == "prefetch" for thread in threading.enumerate())


def test_a_plan_does_not_depend_on_how_its_program_is_chunked() -> None:
    machine = cncgen.load_machine("generic-mill")
    one, two = ([each.profile for each in plan(_chunks(rows), machine)] for rows in (700, 100_000))
    assert len(one) == len(two) > 1
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a.t, b.t)
        np.testing.assert_array_equal(a.j, b.j)


def test_a_plan_that_is_dropped_half_way_leaves_no_thread() -> None:
    trajectories = iter(plan(_chunks(500), cncgen.load_machine("generic-mill")))
    next(trajectories)
    assert _threads() >= 1
    del trajectories
    assert _threads() == 0


def test_a_fault_of_reading_comes_through_all_threads() -> None:
    def broken() -> Iterator[Toolpath]:
        yield from _chunks(500)
        raise KeyError("after the last row")

    with pytest.raises(KeyError, match="after the last row"):
        list(plan(broken(), cncgen.load_machine("generic-mill")))
    assert _threads() == 0
