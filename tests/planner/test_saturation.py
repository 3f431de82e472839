"""Reactive saturation: the paper's figures, the loop against a plain reference, and the simulated drives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import exp
from types import ModuleType

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.kernels import step_limit
from cncgen.machine import Machine
from cncgen.planner import PlanOptions, Trajectory, plan
from cncgen.planner.record import Limit
from cncgen.planner.saturation import pd_plus_axes
from cncgen.servo import simulate
from cncgen.setpoints import sample
from cncgen.toolpath.record import Event, Toolpath
from tests.kernels.plain import uncompiled

T = 1e-3
UNIFORM = PlanOptions(feedrate="constant", interpolator="uniform")


def drawn(chunks: list[Toolpath], machine: Machine, options: PlanOptions) -> list[Trajectory]:
    """Plan and draw everything."""
    return list(plan(chunks, machine, options))


def simulated(trajectories: list[Trajectory], machine: Machine) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return saturated flags, driving forces and following errors of the simulated axes."""
    servos = {k: axis.servo for k, axis in machine.axes.items() if axis.servo is not None}
    parts = list(simulate(sample(trajectories, machine, axes="XY"), servos))
    command, position = (np.concatenate([getattr(r, n) for r in parts]) for n in ("command", "position"))
    saturated, force = (np.concatenate([getattr(r, n) for r in parts]) for n in ("saturated", "force"))
    return saturated, force, command - position


def test_numbers_of_table_1(bonder: Machine) -> None:
    """S = 0.175739 and 0.0802726 V s/rad; from rest at 10 V the largest first step is 56.90 and 124.58 rad/s."""
    axes = pd_plus_axes(bonder, PlanOptions())
    assert axes["X"].gain == pytest.approx(0.175739, rel=1e-5)
    assert axes["Y"].gain == pytest.approx(0.0802726, rel=1e-5)
    assert 10.0 / axes["X"].gain == pytest.approx(56.90, abs=0.005)
    assert 10.0 / axes["Y"].gain == pytest.approx(124.58, abs=0.005)
    # In the pulse/ms of the paper's Fig. 6:
    assert 10.0 / axes["X"].gain * 1.5915494 == pytest.approx(90.56, abs=0.005)


def test_first_step_of_a_line(lines: Callable[..., Toolpath], bonder: Machine) -> None:
    """A step start far above the drive: the first period travels what 99.9 % of 10 V allow, no more and no less."""
    options = PlanOptions(feedrate="constant", saturation="reactive")
    (done,) = drawn([lines([(0, 0), (60, 0)], 300.0)], bonder, options)
    rows = np.concatenate([c.position for c in sample([done], bonder)])
    step = 0.999 * 10.0 / 0.175738808 * 1591.5494 / 1000.0 * T
    assert rows[1, 0] == pytest.approx(step, rel=1e-6)
    assert done.profile.limit[0] == Limit.SATURATION


def test_slow_motion_is_left_alone(lines: Callable[..., Toolpath], bonder: Machine) -> None:
    """Where no drive comes near its bound the setpoints are those of the plan, and no count is raised."""
    toolpath = lines([(0, 0), (5, 0), (5, 5)], 20.0, events={1: Event("dwell", rest=True, dwell_s=0.05)})
    options = PlanOptions(feedrate="ild")
    plain = drawn([toolpath], bonder, options)
    limited = drawn([toolpath], bonder, replace(options, saturation="reactive"))
    rows = [np.concatenate([c.position for c in sample(t, bonder)]) for t in (plain, limited)]
    n = min(len(r) for r in rows)
    np.testing.assert_allclose(rows[0][:n], rows[1][:n], atol=2e-4)
    assert limited[0].values["saturation"] == {"infeasible_ticks": 0, "saturated_ticks": 0}
    assert limited[0].events[0][0] == pytest.approx(plain[0].events[0][0], abs=1e-3)


@pytest.mark.parametrize("feed", [3000, 6000])
def test_start_that_saturates_is_cured(
    feed: int, program: Callable[..., list[Toolpath]], bonder: Machine
) -> None:
    """The path with two sharp corners, whose end is soft: 4 and 20 saturated samples without limiting, none with."""
    chunks = program("bonder.nc", feed)
    without = simulated(drawn(chunks, bonder, UNIFORM), bonder)
    limited = drawn(chunks, bonder, replace(UNIFORM, saturation="reactive"))
    saturated, force, error = simulated(limited, bonder)
    assert without[0].any(axis=1).sum() == {3000: 4, 6000: 20}[feed]
    assert not saturated.any()
    assert np.abs(force).max() < 10.0
    assert np.abs(error).max() < 0.5 * np.abs(without[2]).max()
    assert not any(t.values["diagnostics"] for t in limited)


def test_braking_that_saturates_is_reported(program: Callable[..., list[Toolpath]], bonder: Machine) -> None:
    """At twice the speed the corner itself asks too much: fewer samples saturate, and the plan says how many."""
    chunks = program("bonder.nc", 12000)
    limited = drawn(chunks, bonder, replace(UNIFORM, saturation="reactive"))
    count = int(simulated(limited, bonder)[0].any(axis=1).sum())
    assert 0 < count < simulated(drawn(chunks, bonder, UNIFORM), bonder)[0].any(axis=1).sum() / 5
    (remark,) = [d for t in limited for d in t.values["diagnostics"]]
    assert remark.code == "drive-saturates"
    assert remark.values["saturated_ticks"] == count


def test_chunks_do_not_matter(lines: Callable[..., Toolpath], bonder: Machine) -> None:
    """A polyline in one chunk or in one a row: the same setpoints, and no gap between trajectories."""
    x = [(0, 0), (30, 0), (30, 30), (60, 30)]
    options = PlanOptions(feedrate="constant", saturation="reactive")
    whole = drawn([lines(x, 100.0)], bonder, options)
    parts = drawn([lines(p, 100.0) for p in pairwise(x)], bonder, options)
    rows = [np.concatenate([c.position for c in sample(t, bonder)]) for t in (whole, parts)]
    np.testing.assert_allclose(rows[0], rows[1], atol=1e-6)
    for one, other in pairwise(parts):
        assert other.profile.t[0] == one.profile.t[-1]


def test_servo_data_are_asked_for(lines: Callable[..., Toolpath], mill: Machine) -> None:
    """Every axis of the program that is no bounded PD+ axis is named; the mill's turning ones do not count."""
    with pytest.raises(UsageError) as caught:
        drawn([lines([(0, 0), (1, 0)])], mill, PlanOptions(saturation="reactive"))
    assert [d.message.split("axis ")[1][0] for d in caught.value.diagnostics] == ["X", "Y", "Z"]
    assert {d.code for d in caught.value.diagnostics} == {"saturation-model"}


def reference(steps: int, nominal: float, values: dict[str, float]) -> np.ndarray:
    """Limit steps along X as Yeh and Sun 2008 say, eqs 3.3 to 3.6 with the motor of eq. 2.1 integrated in small steps."""
    tau, kc, ke = values["time_constant_s"], values["velocity_gain_rad_s_volt"], values["counts_per_rad"]
    kp, kd, bound = values["position_gain_volt_count"], values["derivative_gain_volt_s_rad"], 9.99
    theta_d = theta_a = before_a = w = w_d = 0.0
    places = []
    for _ in range(steps):
        w_a = (theta_a - before_a) / (T * ke)
        v = kp * (theta_d - theta_a) - kd * w_a - tau / (kc * T) * w_d
        s = kp * ke * T + kd + 1.0 / kc + tau / (kc * T)
        w_new = min(nominal * 1000.0 / ke, (bound - v) / s)
        u = s * w_new + v
        theta_d, w_d, before_a = theta_d + w_new * T * ke, w_new, theta_a
        for _ in range(200):
            h = T / 200
            gone = exp(-h / tau)
            theta_a += ke * (tau * (1 - gone) * w + kc * (h - tau * (1 - gone)) * u)
            w = gone * w + (1 - gone) * kc * u
        places.append(theta_d / 1000.0)
    return np.array(places)


@pytest.mark.parametrize("kernel", [step_limit, uncompiled("step_limit")], ids=["compiled", "plain"])
def test_kernel_is_the_papers_loop(kernel: ModuleType, bonder: Machine) -> None:
    """On a straight line at 200 mm/s from a step start, against the loop written out with scalars."""
    axis = pd_plus_axes(bonder, PlanOptions())["X"]
    parts, periods, speed = 16, 60, 200.0
    s = speed * T / parts * np.arange(parts * (periods + 2) + 1)
    x, direction = s[:, None].copy(), np.ones((len(s), 1))
    steps, forces = np.zeros((40, 3)), np.zeros((40, 1, 4))
    table, state, work = np.array([axis.row]), np.zeros((1, 5)), np.zeros((1, 2))
    count = kernel.limit_steps(
        s, x, direction, float(parts), 0.0, float(parts * periods), T, table, state, work, steps, forces
    )
    assert count == 40
    values = dict(bonder.axes["X"].servo.parameters)
    np.testing.assert_allclose(steps[:, 1], reference(40, speed, values), rtol=1e-7)
    assert np.abs(forces[:, 0, 3]).max() <= 9.99 * (1 + 1e-6)
