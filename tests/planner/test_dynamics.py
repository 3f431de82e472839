"""The dynamics module: the predicted and the true contour error stay under the bound, at a price that is measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from cncgen.machine import Machine
from cncgen.machine.record import Servo
from cncgen.planner import PlanOptions, Trajectory, plan
from cncgen.planner.record import Limit
from cncgen.servo import simulate
from cncgen.setpoints import sample
from cncgen.toolpath.record import Toolpath

ILD = PlanOptions(feedrate="ild")


def true_errors(trajectories: list[Trajectory], machine: Machine) -> np.ndarray:
    """Contour errors of the simulated axes, with 50 ms of settling."""
    servos = {k: axis.servo for k, axis in machine.axes.items() if axis.servo is not None}
    response = simulate(sample(trajectories, machine, axes="XY"), servos, settle_s=0.05)
    return np.concatenate([r.contour_error_mm for r in response])


@pytest.mark.parametrize(
    ("name", "feed", "slow"),
    [
        ("butterfly.nc", 7000, 8.73),
        ("trident.nc", 7000, 5.3),
        ("star.nc", 6000, 5.0),
        ("heart.nc", 5000, 4.0),
    ],
)
def test_contour_error_is_held(
    name: str, feed: int, slow: float, program: Callable[..., list[Toolpath]], bounded_table: Machine
) -> None:
    """10 µm on the simulated table, ends included, in less time than a plan that slows whole segments takes.

    8.73 and 5.3 s are those of an independent study with pointwise caps; the others bound gross slowness.
    """
    trajectories = list(plan(program(name, feed), bounded_table, ILD))
    assert true_errors(trajectories, bounded_table).max() <= 0.010
    assert trajectories[-1].profile.t[-1] < slow
    assert not any(t.values["diagnostics"] for t in trajectories)


def test_bound_costs_nothing_where_it_does_not_bind(
    program: Callable[..., list[Toolpath]], table: Machine
) -> None:
    """A bound of 1 mm leaves the plan as it is; a tighter bound never makes it faster."""
    chunks = program("butterfly.nc", 7000)
    times = [
        list(plan(chunks, table, replace(ILD, max_contour_error_mm=bound)))[-1].profile.t[-1]
        for bound in (None, 1.0, 0.05, 0.02, 0.01)
    ]
    assert times[1] == pytest.approx(times[0], rel=1e-9)
    assert all(a <= b * (1 + 1e-6) for a, b in pairwise(times))


def test_error_is_held_in_windows(program: Callable[..., list[Toolpath]], bounded_table: Machine) -> None:
    """Many rows planned in small windows keep the bound across the windows' borders."""
    chunks = program("butterfly_g1.nc", 3000)
    trajectories = list(plan(chunks, bounded_table, replace(ILD, lookahead_rows=300)))
    assert true_errors(trajectories, bounded_table).max() <= 0.0105


def test_overshoot_of_a_corner_counts(lines: Callable[..., Toolpath], bounded_table: Machine) -> None:
    """A square of lines: the axes lag along the lines without leaving the path, but overshoot its corners."""
    square = lines([(0, 0), (30, 0), (30, 30), (0, 30), (0, 0)], 116.0)
    free = list(plan([square], replace(bounded_table, max_contour_error_mm=None), ILD))
    held = list(plan([square], bounded_table, ILD))
    assert true_errors(free, bounded_table).max() > 0.014
    assert true_errors(held, bounded_table).max() <= 0.0101
    assert Limit.CONTOUR_ERROR in held[0].profile.limit


def test_loops_that_never_agree_are_reported(lines: Callable[..., Toolpath], table: Machine) -> None:
    """Two first-order loops of different gain part on a diagonal at any speed worth having: said, not hidden."""
    servos = {
        "X": Servo("first-order", {"position_gain_1_s": 60.0}),
        "Y": Servo("first-order", {"position_gain_1_s": 30.0}),
    }
    options = replace(ILD, servos=servos, max_contour_error_mm=1e-6)
    trajectories = list(plan([lines([(0, 0), (3, 3)], 100.0)], table, options))
    found = [d for t in trajectories for d in t.values["diagnostics"]]
    assert [d.code for d in found] == ["contour-error"]
