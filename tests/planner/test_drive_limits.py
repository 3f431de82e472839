"""Predictive saturation: the bound on the force by itself, and simulated drives under plans that obey it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from cncgen.diagnostics import NoPlanError, UsageError
from cncgen.machine import Machine
from cncgen.planner import PlanOptions, plan
from cncgen.planner.drive_limits import ForceGains, drivable
from cncgen.planner.least_time.replanning import by_block, speed_along
from cncgen.planner.record import Limit, Trajectory
from cncgen.planner.saturation import pd_plus_axes
from cncgen.servo import simulate
from cncgen.setpoints import sample
from cncgen.setpoints.record import Setpoints
from cncgen.toolpath.record import Toolpath

T = 1e-3
PREDICTIVE = PlanOptions(saturation="predictive")


def changed(machine: Machine, limits: dict[str, float] | None = None, **servo: Any) -> Machine:
    """Return the machine with other limits and servo parameters on all axes."""
    axes = {
        letter: replace(
            axis,
            **(limits or {}),
            servo=replace(axis.servo, parameters={**axis.servo.parameters, **servo}) if axis.servo else None,
        )
        for letter, axis in machine.axes.items()
    }
    return replace(machine, axes=MappingProxyType(axes))


def simulated(trajectories: list[Trajectory], machine: Machine) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return saturated flags, forces and following errors of the simulated axes, each (samples, axes)."""
    servos = {k: axis.servo for k, axis in machine.axes.items() if axis.servo is not None}
    parts = list(simulate(sample(iter(trajectories), machine, axes="XY"), servos, settle_s=0.1))
    command, position, saturated, force = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ("command", "position", "saturated", "force")
    )
    return saturated, force, command - position


@pytest.fixture
def two_corners(lines: Callable[..., Toolpath]) -> Toolpath:
    """Return a path with two right angles, at 300 mm/s."""
    return lines([(0, 0), (20, 0), (20, 20), (40, 20)], 300.0)


def test_steady_gains_are_those_of_the_law(bonder: Machine) -> None:
    """At constant speed the feedforward 1/K_c carries the motor. At a constant acceleration α the force held from tick
    k on raises ω by αT, u = (ω + αT/(1 − e^(−T/τ)))/K_c, and ω is αT/2 more than the speed of the step that ends there.
    """
    for letter, tau, kc in (("X", 0.31, 2506.17), ("Y", 0.135, 3156.23)):
        gains = ForceGains.of(pd_plus_axes(bonder, PREDICTIVE)[letter], bonder.period_s)
        rad_per_mm = 1000.0 / 1591.5494
        lag = T / (1.0 - np.exp(-T / tau)) + T / 2.0
        assert gains.velocity == pytest.approx(rad_per_mm / kc, rel=1e-6)
        assert gains.acceleration == pytest.approx(rad_per_mm * lag / kc, rel=1e-5)


@pytest.mark.parametrize("seed", range(4))
def test_no_motion_within_the_limits_asks_for_more(bonder: Machine, seed: int) -> None:
    """Random setpoints, jerk and acceleration switching at random rates (the loop's own among them), on the loop."""
    rng = np.random.default_rng(seed)
    period, n = bonder.period_s, 2000
    acceleration, jerk = 15_000.0, 6e6
    held = np.repeat(rng.choice([-1.0, 1.0], n), rng.integers(1, 12, n))[:n]
    goal, a = held * acceleration, np.zeros(n)
    for k in range(1, n):
        a[k] = a[k - 1] + np.clip(goal[k] - a[k - 1], -jerk * period, jerk * period)
    v = np.cumsum(a) * period
    position = np.stack([np.cumsum(v) * period] * 2, axis=1)
    servos = {k: axis.servo for k, axis in changed(bonder, saturation_volt=1000.0).axes.items()}
    points = Setpoints("XY", period, 0, position)
    force = np.concatenate([r.force for r in simulate([points], servos)])  # type: ignore[arg-type]
    for column, letter in enumerate("XY"):
        gains = ForceGains.of(pd_plus_axes(bonder, PREDICTIVE)[letter], period)
        most = gains.asked(float(np.abs(v).max()), acceleration, jerk)
        assert np.abs(force[:, column]).max() <= most
        assert np.abs(force[:, column]).max() >= 0.25 * most


def test_share_of_acceleration_and_jerk() -> None:
    """To reach V with c A + h J = F soonest: V/A + A/J is least where its derivative along that line is 0."""
    gains = ForceGains(velocity=0.0, acceleration=1.0, jerk=0.1, pulse=10.0, friction=0.0)
    a, j = gains.within(8.0, 30.0, 100.0, 1000.0)
    assert a + 0.1 * j == pytest.approx(8.0)
    grid = np.linspace(0.01, 7.99, 200_001)
    left = 10.0 * (8.0 - grid)
    time = np.where(grid**2 / left < 30.0, 30.0 / grid + grid / left, 2.0 * np.sqrt(30.0 / left))
    assert 30.0 / a + a / j == pytest.approx(time.min(), rel=1e-4)
    # What is within the force stays; what one of them cannot use, the other has; where pulses are cheap, they lead.
    assert gains.within(8.0, 30.0, 2.0, 3.0) == (2.0, 3.0)
    assert gains.within(8.0, 30.0, 100.0, 1.0)[1] == 1.0
    assert gains.within(8.0, 30.0, 2.0, 1000.0) == (2.0, pytest.approx(60.0))
    assert replace(gains, pulse=1.01).within(8.0, 30.0, 100.0, 1000.0) == (8.0 / 1.01, 1000.0)


@pytest.mark.parametrize("feed_mm_min", [9000.0, 24000.0])
@pytest.mark.parametrize(
    "how",
    [
        {},
        {"feedrate": "constant", "interpolator": "uniform"},
        {"feedrate": "curvature", "interpolator": "taylor1"},
        {"feedrate": "ild"},
    ],
)
def test_bonder(
    program: Callable[..., list[Toolpath]], bonder: Machine, how: dict[str, str], feed_mm_min: float
) -> None:
    """Two corners in one curve, 1 µm a count: nothing saturates, every axis follows within 100 µm."""
    chunks = program("bonder.nc", feed_mm_min)
    done = list(plan(chunks, bonder, PlanOptions(saturation="predictive", **how)))
    saturated, _, error = simulated(done, bonder)
    assert not saturated.any()
    assert np.abs(error).max() <= 0.1


@pytest.mark.parametrize("how", [{"feedrate": "constant"}, {}])
def test_where_off_saturates_and_reactive_cannot_brake(
    two_corners: Toolpath, bonder: Machine, how: dict[str, str]
) -> None:
    """At 0.25 µm a count, with limits beyond the drives."""
    fine = changed(bonder, {"max_acceleration": 1e6, "max_jerk": 1e9}, counts_per_mm=4000.0)
    found = {}
    for mode in ("off", "reactive", "predictive"):
        done = list(plan([two_corners], fine, PlanOptions(saturation=mode, **how)))
        saturated, force, error = simulated(done, fine)
        found[mode] = int(saturated.any(axis=1).sum())
    assert found["off"] > 100
    assert found["reactive"] > 100
    assert found["predictive"] == 0
    assert np.abs(error).max() <= 0.1
    assert np.abs(force).max() > 2.5
    assert Limit.SATURATION in done[0].profile.limit


def test_friction_takes_its_part(two_corners: Toolpath, bonder: Machine) -> None:
    """Coulomb friction of 2 V beside the acceleration."""
    rough = changed(bonder, {"max_acceleration": 1e6, "max_jerk": 1e8}, coulomb_volt=2.0)
    done = list(plan([two_corners], rough, PREDICTIVE))
    assert not simulated(done, rough)[0].any()
    smooth = list(plan([two_corners], changed(rough, coulomb_volt=0.0), PREDICTIVE))
    assert done[-1].profile.t[-1] > smooth[-1].profile.t[-1]


def test_nothing_changes_within_the_drives(two_corners: Toolpath, bonder: Machine) -> None:
    """The profile's own limits leave the drives room: `predictive` plans what `off` does."""
    one, other = (
        list(plan([two_corners], bonder, PlanOptions(saturation=mode))) for mode in ("off", "predictive")
    )
    assert one[-1].profile.t[-1] == other[-1].profile.t[-1]


def test_caps_stay_below_the_strategy(program: Callable[..., list[Toolpath]], bonder: Machine) -> None:
    """What is planned again is nowhere faster than the strategy was (but beside the stops, and by the nodes' spacing)."""
    how = PlanOptions(feedrate="constant", interpolator="uniform")
    first, second = (
        next(by_block(plan(program("bonder.nc"), bonder, replace(how, saturation=mode)))).profile
        for mode in ("off", "predictive")
    )
    s = np.linspace(1.0, 79.0, 4000)
    fast, slow = (speed_along(profile, 0.0)(s) for profile in (first, second))
    assert np.all(slow <= fast * 1.02 + 0.5)


def test_drives_that_cannot(bonder: Machine, mill: Machine) -> None:
    """Axes of another model are named; a drive that friction takes whole has no plan."""
    with pytest.raises(UsageError, match="predictive"):
        drivable(mill, PREDICTIVE)
    with pytest.raises(NoPlanError, match=r"friction of axis X takes .* of the 9.99 V"):
        drivable(changed(bonder, coulomb_volt=10.0), PREDICTIVE)
    with pytest.raises(NoPlanError, match="die away"):
        drivable(changed(bonder, derivative_gain_volt_s_rad=50.0), PREDICTIVE)


@pytest.mark.parametrize("volt", [0.33, 0.2, 0.02])
def test_a_drive_too_weak_for_the_largest_speed_is_planned_slower(
    two_corners: Toolpath, bonder: Machine, volt: float
) -> None:
    """500 mm/s take 0.317 V on X (1/K_c a rad/s): less is a lower speed, not a refusal, and that limit is named."""
    weak = changed(bonder, saturation_volt=volt)
    lowered = drivable(weak, PREDICTIVE)
    for letter, model in pd_plus_axes(weak, PREDICTIVE).items():
        axis, gains = lowered.axes[letter], ForceGains.of(model, T)
        asked = gains.asked(axis.max_velocity, axis.max_acceleration, axis.max_jerk)
        assert asked <= model.bound
        assert gains.velocity * axis.max_velocity <= 0.75 * model.bound
    done = list(plan([two_corners], weak, PREDICTIVE))
    saturated, force, _ = simulated(done, weak)
    assert not saturated.any()
    assert np.abs(force).max() > 0.4 * volt
    if volt < 0.2:
        assert Limit.SATURATION in done[0].profile.limit


@pytest.mark.parametrize("how", ["predictive", "reactive"])
def test_drives_of_axes_that_the_program_does_not_name_do_not_count(
    two_corners: Toolpath, bonder: Machine, how: str
) -> None:
    """A machine with a turning table, whose drive is hopeless, and a program in X and Y."""
    x = bonder.axes["X"]
    assert x.servo is not None
    parameters = {k: v for k, v in x.servo.parameters.items() if k != "counts_per_mm"}
    hopeless = {**parameters, "counts_per_deg": 1000.0, "saturation_volt": 1e-6}
    table = replace(x, letter="A", servo=replace(x.servo, parameters=hopeless))
    with_table = replace(bonder, axes=MappingProxyType({**bonder.axes, "A": table}))
    options = PlanOptions(saturation=how)
    one, other = (list(plan([two_corners], machine, options)) for machine in (bonder, with_table))
    assert one[-1].profile.t[-1] == other[-1].profile.t[-1]
    without = replace(table, servo=None)
    none = replace(bonder, axes=MappingProxyType({**bonder.axes, "A": without}))
    assert list(plan([two_corners], none, options))[-1].profile.t[-1] == one[-1].profile.t[-1]
