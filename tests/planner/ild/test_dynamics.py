"""The dynamics module: the predicted and the true contour error stay under the bound, at a price that is measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from cncgen.diagnostics import NoPlanError
from cncgen.machine import Machine
from cncgen.machine.record import Servo
from cncgen.planner import PlanOptions, Trajectory, plan
from cncgen.planner.ild import strategy
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


@pytest.mark.parametrize(("samples", "longer"), [(400, 1e-2), (2500, 1e-3)])
def test_windows_are_cut_in_time(
    lines: Callable[..., Toolpath],
    bounded_table: Machine,
    monkeypatch: pytest.MonkeyPatch,
    samples: int,
    longer: float,
) -> None:
    """A program that takes longer than a window's samples is planned in several windows.

    That costs nearly no time: less than a hundredth where a window is no more than a row of 0.5 s.
    """
    points = [(0.0, 0.0)]
    for k in range(20):
        points += [(10.0 * (k % 2 == 0), points[-1][1]), (10.0 * (k % 2 == 0), k + 1.0)]
    chunk = lines(points, 20.0)
    whole = list(plan([chunk], bounded_table, ILD))
    monkeypatch.setattr(strategy, "WINDOW_SAMPLES", samples)
    parts = list(plan([chunk], bounded_table, ILD))
    assert len(whole) == 1 < len(parts)
    assert sum(len(part.toolpath) for part in {id(p.toolpath): p for p in parts}.values()) == len(chunk)
    assert whole[-1].profile.t[-1] <= parts[-1].profile.t[-1] <= (1.0 + longer) * whole[-1].profile.t[-1]
    assert true_errors(parts, bounded_table).max() <= 0.010


def test_a_row_that_takes_too_long_is_named(lines: Callable[..., Toolpath], bounded_table: Machine) -> None:
    """100 mm at 10⁻³ mm/s are 10⁵ s, 10⁸ periods of a millisecond; a corner's window before it is planned."""
    slow = {k: replace(axis, max_velocity=1e-3) for k, axis in bounded_table.axes.items()}
    chunk = lines([(0.0, 0.0), (0.001, 0.0), (0.001, 100.0)], 20.0)
    with pytest.raises(
        NoPlanError, match=r"takes 1e\+05 s, which is more than 8388608 predictions"
    ) as caught:
        list(plan([chunk], replace(bounded_table, axes=slow), ILD))
    (fault,) = caught.value.diagnostics
    assert (fault.code, fault.span.line) == ("look-ahead-endless", int(chunk.line[1]))
