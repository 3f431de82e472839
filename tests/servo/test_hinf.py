"""Mixed-sensitivity design: its norm on a grid is the one it states, loops are stable, bounds hold for all plants."""

import numpy as np
import pytest
from scipy.signal import cont2discrete

from cncgen.machine.servo_schema import resolve
from cncgen.servo.controllers import hinf
from cncgen.servo.controllers.hinf_servo import check, controller_of, family
from cncgen.servo.discretise import ramped
from cncgen.servo.plants import companion

from .bench import profile


def stage(frequency=25.0, damping=0.05, gain=1.0):
    """A piezo stage: one resonance."""
    w = 2 * np.pi * frequency
    return [gain * w**2], [1.0, 2 * damping * w, w**2]


W1, WT = hinf.performance_weight(20.0), hinf.robustness_weight(40.0)
GRID = np.geomspace(1e-2, 1e5, 4000)
FAMILY = [stage(f, d, g) for f in (22.5, 25.0, 27.5) for d in (0.04, 0.08) for g in (0.9, 1.1)]


def value(ratio):
    return np.polyval(ratio[0], 1j * GRID) / np.polyval(ratio[1], 1j * GRID)


def closed(controller, plant):
    """Return the closed loop from setpoint to position."""
    a, b, c, _ = companion(np.array(plant[0], float), np.array(plant[1], float))
    top = np.hstack([a, np.outer(b, controller.c[0])])
    bottom = np.hstack([-np.outer(controller.b[:, 0], c), controller.a])
    inputs = np.concatenate([np.zeros(len(a)), controller.b[:, 0]])[:, None]
    output = np.concatenate([c, np.zeros(len(controller.a))])[None]
    return hinf.StateSpace(np.vstack([top, bottom]), inputs, output)


def stable(controller, plant):
    return np.linalg.eigvals(closed(controller, plant).a).real.max() < 0.0


@pytest.fixture(scope="module")
def design():
    return hinf.mixed_sensitivity(stage(), W1, WT, 0.05)


def test_the_norm_is_what_it_says(design):
    k, g = design.controller.response(GRID), value(stage())
    s = 1.0 / (1.0 + k * g)
    norm = np.sqrt(abs(value(W1) * s) ** 2 + abs(value(WT) * g * k * s) ** 2 + abs(0.05 * k * s) ** 2).max()
    assert norm <= design.gamma * 1.001
    assert norm >= 0.9 * design.gamma
    assert stable(design.controller, stage())


def test_a_right_half_plane_zero_bounds_the_norm():
    """No controller beats a bound from interpolation: W1 S at a right-half-plane zero z gives γ ≥ |W1(z)|."""
    zero = 40.0
    plant = ([-1.0, zero], [1.0, 60.0, 900.0])
    found = hinf.mixed_sensitivity(plant, W1, WT, 0.05)
    assert found.gamma >= abs(np.polyval(W1[0], zero) / np.polyval(W1[1], zero))


def test_bounds_hold_for_every_plant_before_and_after_reshaping(design):
    """The appended paper's eqs 4 and 5: |S| below α = 1/|W1| and |T| below a peak, for every plant of the family."""
    for controller in (design.controller, hinf.rolled_off(design.controller, 3000.0)):
        k = controller.response(GRID)
        for plant in FAMILY:
            loop = k * value(plant)
            assert stable(controller, plant)
            assert np.abs(value(W1) / (1.0 + loop)).max() < 1.0
            assert np.abs(loop / (1.0 + loop)).max() < 1.5
    high = [
        abs(c.response(np.array([2e4]))[0])
        for c in (design.controller, hinf.rolled_off(design.controller, 3000.0))
    ]
    assert high[1] < 0.2 * high[0]


def test_a_step_of_20_um_rises_in_a_tenth_of_a_second_within_a_micrometre(design):
    """The appended paper's figures for its stage."""
    loop = closed(design.controller, stage())
    phi, start, end = ramped(loop.a, loop.b, 1e-4)
    x, rows = np.zeros(len(loop.a)), []
    for _ in range(6000):
        rows.append(20.0 * float(loop.c[0] @ x))
        x = phi @ x + (start + end)[:, 0]
    rows = np.array(rows)
    rise = (np.argmax(rows > 18.0) - np.argmax(rows > 2.0)) * 1e-4
    assert rise <= 0.1
    assert abs(rows[-1] - 20.0) < 1.0


def test_conditions_are_checked():
    with pytest.raises(ValueError, match="positive"):
        hinf.mixed_sensitivity(stage(), W1, WT, 0.0)
    with pytest.raises(ValueError, match="strictly proper"):
        hinf.mixed_sensitivity(([1.0, 1.0], [1.0, 2.0]), W1, WT, 0.1)


def test_the_check_of_bounds_is_the_worst_of_all_plants():
    """|S| and |T| of each plant of the family, held by scipy, with the sampled controller: the largest at each frequency."""
    values = resolve(profile("flexure-stage")["X"], "X")
    period = 0.0005
    controller = controller_of(values, period)
    found = check(values, controller, period, count=60)
    z = np.exp(1j * found.frequency * period)
    order = np.eye(len(controller.a))
    law = np.array(
        [
            controller.d_setpoint
            + controller.c @ np.linalg.solve(x * order - controller.a, controller.b_setpoint)
            for x in z
        ]
    )
    worst_s, worst_t = np.zeros(60), np.zeros(60)
    for above, below in family(values):
        up, down, _ = cont2discrete((above, below), period, "zoh")
        response = law * np.polyval(np.squeeze(up), z) / np.polyval(down, z)
        worst_s = np.maximum(worst_s, np.abs(1.0 / (1.0 + response)))
        worst_t = np.maximum(worst_t, np.abs(response / (1.0 + response)))
    assert values["delay_s"] == 0.0
    assert found.plants == 9
    assert found.sensitivity == pytest.approx(worst_s, rel=1e-5)
    assert found.complementary == pytest.approx(worst_t, rel=1e-5)
    assert found.holds
    assert found.allowed.max() == values["sensitivity_peak"]
    weight = hinf.performance_weight(
        values["sensitivity_bandwidth_rad_s"], values["sensitivity_peak"], values["sensitivity_offset"]
    )
    w1 = np.abs(np.polyval(weight[0], 1j * found.frequency) / np.polyval(weight[1], 1j * found.frequency))
    assert found.allowed == pytest.approx(np.minimum(1.0 / w1, values["sensitivity_peak"]))
