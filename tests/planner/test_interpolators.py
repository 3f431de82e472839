"""Interpolators against their recurrences step by step, and against the fluctuations that are known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cncgen.machine import Machine
from cncgen.planner import PlanOptions, Trajectory, plan
from cncgen.planner.motion import motion_at, time_at
from cncgen.report.comparison import compare_interpolators
from cncgen.setpoints import sample
from cncgen.toolpath.record import Event, Toolpath

T = 1e-3


def drawn(
    chunks: list[Toolpath], machine: Machine, interpolator: str, feedrate: str = "ild"
) -> list[Trajectory]:
    """Plan and draw everything."""
    return list(plan(chunks, machine, PlanOptions(feedrate=feedrate, interpolator=interpolator)))


def recurrence(planned: Trajectory, order: int) -> np.ndarray:
    """Return the places of Yeh and Sun's eqs 3.2 (order 1) and 3.1 (order 2), one step after the other.

    The speed V(u) T is the distance that the plan travels in a period from where the tool is.
    """
    path, profile = planned.toolpath.path, planned.profile
    places, end = [0.0], float(profile.s[-1])
    while True:
        at = np.array([places[-1]])
        then = time_at(profile, at) + T
        if then[0] >= profile.t[-1]:
            return np.array(places)
        step = motion_at(profile, then).s - at
        u = path.parameter(0, at)
        _, c1, c2 = path.evaluate_parameter(0, u, 2)[:, 0]
        x = step / np.linalg.norm(c1)
        if order == 2:
            x = x - 0.5 * step**2 * (c1 @ c2) / np.linalg.norm(c1) ** 4
        places.append(min(float(path.coordinate(0, u + x)[0]), end))


@pytest.mark.parametrize("order", [1, 2])
def test_sweeps_solve_the_recurrence(
    order: int, program: Callable[..., list[Toolpath]], table: Machine
) -> None:
    """The vectorised sweeps give the places of the step-by-step recurrence on the butterfly."""
    chunks = program("butterfly.nc", 7000)[:1]
    (planned,) = drawn(chunks, table, "arclength")
    (stepped,) = drawn(chunks, table, f"taylor{order}")
    slow = recurrence(planned, order)
    fast = motion_at(stepped.profile, np.arange(len(slow)) * T).s
    np.testing.assert_allclose(fast, slow, atol=1e-9)


@pytest.mark.parametrize(("interpolator", "worst", "rms"), [("taylor1", 70.8, 2.36), ("taylor2", 56.9, 1.49)])
def test_constant_compare_interpolators(
    interpolator: str, worst: float, rms: float, program: Callable[..., list[Toolpath]], table: Machine
) -> None:
    """Butterfly at a constant 6000 mm/min: an independent study found 70.8 % and 56.9 % at the worst step."""
    (found,) = compare_interpolators(
        program("butterfly.nc", 6000), table, PlanOptions(feedrate="constant"), [interpolator]
    )
    assert 100 * found.max_part == pytest.approx(worst, abs=0.05)
    assert 100 * found.rms_part == pytest.approx(rms, abs=0.01)


@pytest.mark.parametrize("feed", [3500, 5000, 7000])
def test_arclength_travels_what_is_asked(
    feed: int, program: Callable[..., list[Toolpath]], table: Machine
) -> None:
    """Under 1e-4 % at the worst sample; Taylor's are orders of magnitude above it."""
    exact, first, second = compare_interpolators(
        program("butterfly.nc", feed), table, PlanOptions(feedrate="ild")
    )
    assert 100 * exact.max_part < 1e-4
    assert first.max_part > 0.02
    assert 0.001 < second.max_part < first.max_part


def test_uniform_takes_equal_steps_of_the_parameter(
    program: Callable[..., list[Toolpath]], table: Machine
) -> None:
    """On the circle of 7 points every period has the same du, and the speed follows |C'|: 60 to 120 by 94 (Hsu 1999)."""
    chunks = program("circle.nc")
    (done, *_) = drawn(chunks, table, "uniform", "constant")
    path = done.toolpath.path
    ticks = np.arange(int(done.profile.t[-1] / T)) * T
    row = int(np.flatnonzero(done.toolpath.kind == 2)[0])
    u = path.parameter(row, motion_at(done.profile, ticks).s)
    np.testing.assert_allclose(np.diff(u), u[1] - u[0], rtol=1e-6)
    speed = np.diff(motion_at(done.profile, ticks).s) / T
    assert speed.max() / speed.min() == pytest.approx(120.0 / 60.1, rel=0.01)
    assert speed.mean() / speed.min() == pytest.approx(94.28 / 60.1, rel=0.01)


@pytest.mark.parametrize("interpolator", ["taylor1", "taylor2", "uniform"])
def test_lines_and_arcs_are_exact_anyway(
    interpolator: str,
    lines: Callable[..., Toolpath],
    arc: Callable[..., Toolpath],
    table: Machine,
) -> None:
    """Without a NURBS the setpoints are those of `arclength`."""
    for toolpath in (lines([(0, 0), (10, 3), (10, 20)]), arc(5.0, 4.0, 50.0)):
        positions = [
            np.concatenate([c.position for c in sample(drawn([toolpath], table, name), table)])
            for name in ("arclength", interpolator)
        ]
        np.testing.assert_allclose(positions[0], positions[1], atol=1e-12)


@pytest.mark.parametrize("interpolator", ["taylor1", "taylor2", "uniform"])
def test_whole_path_in_many_trajectories(
    interpolator: str,
    lines: Callable[..., Toolpath],
    nurbs: Callable[..., Toolpath],
    table: Machine,
) -> None:
    """Line, curve, dwell, line in chunks of their own: no gap in time or place, the end is reached, events keep up."""
    curve = nurbs([(10, 0), (15, 0), (22, 4), (20, 12), (10, 15), (5, 15)], 60.0)
    chunks = [
        lines([(0, 0), (10, 0)], 60.0),
        curve,
        lines([(5, 15), (0, 15)], 60.0, events={0: Event("dwell", rest=True, dwell_s=0.1)}),
    ]
    done = drawn(chunks, table, interpolator)
    for one, other in zip(done, done[1:], strict=False):  # noqa: RUF007
        assert other.profile.t[0] == pytest.approx(one.profile.t[-1], abs=1e-12)
    assert all((np.diff(t.profile.t) >= 0).all() and (np.diff(t.profile.s) >= -1e-12).all() for t in done)
    rows = np.concatenate([c.position for c in sample(done, table)])
    assert rows[-1].tolist() == [0.0, 15.0, 0.0]
    ((when, _, event),) = [e for t in done for e in t.events]
    k = int(when / T) + 5
    assert event.name == "dwell"
    assert (rows[k] == rows[k + 80]).all()
    np.testing.assert_allclose(rows[k], [5.0, 15.0, 0.0], atol=1e-12)
    plain = drawn(chunks, table, "arclength")
    assert done[-1].profile.t[-1] == pytest.approx(plain[-1].profile.t[-1], rel=0.01)


def test_coinciding_control_points_do_not_derail(nurbs: Callable[..., Toolpath], table: Machine) -> None:
    """Where C' vanishes the Taylor step has no meaning: the exact one is taken, and the end is reached."""
    curve = nurbs([(0, 0), (5, 0), (10, 0), (10, 0), (10, 0), (10, 5), (10, 10)], 50.0)
    for name in ("taylor1", "taylor2", "uniform"):
        done = drawn([curve], table, name)
        rows = np.concatenate([c.position for c in sample(done, table)])
        assert rows[-1].tolist() == [10.0, 10.0, 0.0]
        assert np.linalg.norm(np.diff(rows, axis=0), axis=1).sum() == pytest.approx(20.0, abs=0.02)
