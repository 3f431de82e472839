"""The servo model ``plant``: any transfer function under PID, a ratio or an H-infinity design; viscous friction everywhere."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import cont2discrete, dlsim, dlti

from cncgen.diagnostics import UsageError
from cncgen.machine import servo_schema
from cncgen.machine.reading import servos_from_toml
from cncgen.machine.record import Servo
from cncgen.servo.controllers import hinf_servo
from cncgen.servo.models import axis_loop
from cncgen.servo.tuning.placement import designed_h_infinity

from .bench import profile, run

T = 0.001
COMMAND = np.concatenate([np.linspace(0, 5, 80), 5 + 2 * np.sin(np.linspace(0, 9, 150)), np.full(60, 5.8)])


def plant_servo(numerator, denominator, **more):
    return Servo("plant", {"numerator": list(numerator), "denominator": list(denominator), **more})


def followed(servo, command=COMMAND):
    return run(command[:, None], {"X": servo}, axes="X").position[:, 0]


def held(derivative, law, state, command=COMMAND, delay=0, parts=1):
    """Rows of states under a sampled law whose output waits `delay` periods."""
    states, memory, queue = [np.asarray(state, float)], None, [0.0] * delay
    for r in command[:-1]:
        u, memory = law(memory, r, states[-1])
        queue.append(u)
        now = queue.pop(0)
        span = solve_ivp(lambda t, x, now=now: derivative(x, now), (0, T), states[-1], rtol=1e-11, atol=1e-13)
        states.append(span.y[:, -1])
    return np.array(states)


def close(ours, reference):
    assert np.abs(ours - reference).max() <= 1e-6 * np.abs(reference).max()


PI = {"position_gain_1_mm": 0.6, "integral_gain_1_mm_s": 25.0}


def pi_law(memory, r, x):
    integral = memory or 0.0
    return 0.6 * (r - x[0]) + integral, integral + 25.0 * T * (r - x[0])


@pytest.mark.parametrize("delay", [0, 3])
def test_a_ratio_in_s_with_dead_time_and_viscous_friction(delay):
    """y'' = 900 u(t − D) − 40 y' − 900 y − 900 c y'."""
    servo = plant_servo([900.0], [1.0, 40.0, 900.0], delay_s=delay * T, viscous_s_mm=0.02, **PI)
    states = held(
        lambda x, u: [x[1], 900.0 * u - 40.0 * x[1] - 900.0 * x[0] - 900.0 * 0.02 * x[1]],
        pi_law,
        [0, 0],
        delay=delay,
    )
    close(followed(servo), states[:, 0])


def test_a_ratio_in_z_is_scipys():
    numerator, denominator, _ = cont2discrete(([900.0], [1.0, 40.0, 900.0]), T)
    servo = plant_servo(np.squeeze(numerator)[1:], denominator, sample_time_s=T, delay_s=2 * T, **PI)
    same = plant_servo([900.0], [1.0, 40.0, 900.0], delay_s=2 * T, **PI)
    assert followed(servo) == pytest.approx(followed(same), abs=1e-8)
    with pytest.raises(UsageError, match="whole number of its sample times"):
        axis_loop(plant_servo([1.0], [1.0, -0.5], sample_time_s=T, delay_s=0.0005, **PI), "X", T)


def test_a_controller_given_as_a_ratio_is_tustins():
    """Lead–lag on a resonance, beside scipy: bilinear controller, held plant, their loop closed by dlsim."""
    control = ([3.0, 60.0], [1.0, 0.5])
    servo = plant_servo(
        [900.0], [1.0, 40.0, 900.0], controller="ratio", controller_numerator=control[0],
        controller_denominator=control[1],
    )  # fmt: skip
    kn, kd, _ = cont2discrete(control, T, method="bilinear")
    gn, gd, _ = cont2discrete(([900.0], [1.0, 40.0, 900.0]), T)
    above = np.polymul(np.squeeze(kn), np.squeeze(gn))
    below = np.polyadd(np.polymul(kd, gd), above)
    _, check = dlsim(dlti(above, below, dt=1), COMMAND)
    assert followed(servo) == pytest.approx(check[:, 0], abs=1e-7)
    assert np.sort_complex(axis_loop(servo, "X", T).poles()) == pytest.approx(
        np.sort_complex(np.roots(below)), abs=1e-8
    )


def test_the_closed_loop_in_s_is_the_limit_of_the_sampled_one():
    servo = plant_servo([900.0], [1.0, 40.0, 900.0], viscous_s_mm=0.02, **PI)
    loop = servo_schema.closed_loop(servo)
    poles = np.log(np.sort_complex(axis_loop(servo, "X", 1e-5).poles()).astype(complex)[-3:]) / 1e-5
    assert np.sort_complex(poles) == pytest.approx(np.sort_complex(np.roots(loop.denominator)), rel=2e-3)


def test_friction_with_a_dead_time_sticks_where_the_force_is_too_small():
    """A double integrator with friction: the drive comes three periods late, and nothing moves before it exceeds friction."""
    servo = plant_servo([1000.0], [1.0, 10.0, 0.0], delay_s=3 * T, coulomb=0.5, position_gain_1_mm=2.0)
    step = np.full(400, 0.2)
    step[0] = 0.0
    assert np.abs(followed(servo, step)).max() == 0.0  # 2 · 0.2 V < 0.5 V
    step[1:] = 0.3
    moved = followed(servo, step)
    # The step comes at sample 1, the drive at 4; what is seen at 5 is half of 1000 (0.6 − 0.5) T².
    assert np.abs(moved[:5]).max() == 0.0
    assert moved[5] == pytest.approx(0.5 * 1000 * 0.1 * T**2, rel=0.01)
    with pytest.raises(UsageError, match="whole number of control periods"):
        axis_loop(plant_servo([1.0], [1.0, 1.0, 0.0], delay_s=0.0005, coulomb=0.1, **PI), "X", T)


VISCOUS = (
    ("dyna-1007", "viscous_share", 0.3, lambda p: [1.0 + 0.3]),
    (
        "die-bonder",
        "viscous_volt_s_rad",
        2e-4,
        lambda p: [1.0 + (p["derivative_gain_volt_s_rad"] + 2e-4) * 2506.17],
    ),
    ("xy-table", "viscous_1_s", 15.0, lambda p: None),
)


@pytest.mark.parametrize(("name", "key", "value", "drag"), VISCOUS)
def test_viscous_friction_is_in_the_poles_of_every_model(name, key, value, drag):
    base = profile(name)["X"]
    values = {k: v for k, v in base.parameters.items() if "coulomb" not in k and "saturation" not in k}
    servo = Servo(base.model, {**values, key: value})
    loop = servo_schema.closed_loop(servo)
    period = 1e-5
    sampled = axis_loop(Servo(base.model, {**servo.parameters, "control_period_s": period}), "X", period)
    poles = np.log(sampled.poles()[np.abs(sampled.poles()) > 0.5].astype(complex)) / period
    wanted = np.roots(loop.denominator)
    assert np.sort_complex(poles)[-len(wanted) :] == pytest.approx(np.sort_complex(wanted), rel=1e-2)
    if drag(values):
        assert loop.denominator[1] == pytest.approx(drag(values)[0])
    elif name == "xy-table":
        plain = servo_schema.closed_loop(Servo(base.model, values))
        assert loop.denominator[1] - plain.denominator[1] == pytest.approx(15.0)


def test_viscous_friction_without_a_lag_is_a_gain():
    servo = Servo("first-order", {"position_gain_1_s": 50.0, "viscous_share": 0.25})
    plain = Servo("first-order", {"position_gain_1_s": 40.0})
    assert followed(servo) == pytest.approx(followed(plain), abs=1e-12)


def test_every_imperfection_acts_on_a_plant():
    base = {"numerator": [900.0], "denominator": [1.0, 40.0, 900.0], **PI}
    clean = run(COMMAND[:, None], {"X": Servo("plant", base)}, axes="X")
    for key, value in (
        ("saturation", 5.0),
        ("coulomb", 0.2),
        ("backlash_mm", 0.01),
        ("encoder_resolution_mm", 0.01),
        ("noise_rms_mm", 0.01),
    ):
        runs = [
            run(COMMAND[:, None], {"X": Servo("plant", {**base, key: value})}, axes="X") for _ in range(2)
        ]
        assert np.abs(runs[0].position - clean.position).max() > 1e-4, key
        assert np.array_equal(runs[0].position, runs[1].position), key
    assert runs[0].force_unit == ("V",)


def test_the_flexure_stage_keeps_its_bounds_and_rises_in_a_tenth_of_a_second():
    """The appended paper's figures: a step of 20 µm rises within 0.1 s and ends within 1 µm, for every payload."""
    for letter, servo in profile("flexure-stage").items():
        made, gamma, found = designed_h_infinity(servo, letter, T)
        assert found.holds
        assert found.plants == 9
        assert 0.1 < gamma < 1.0
        values = servo_schema.resolve(made, letter)
        for above, below in hinf_servo.family(values):
            # The design is the nominal one; the plant alone changes.
            control = hinf_servo.controller_of(values, 0.0005)
            loop = hinf_servo.close_loop(
                hinf_servo.plants.transfer_function(np.array(above), np.array(below)), control, 0.0005
            )
            a, b, _ = loop.transition()
            x, rows = np.zeros(len(a)), []
            for _ in range(1600):
                rows.append(20.0 * float(loop.output @ x))
                x = a @ x + b
            rows = np.array(rows)
            assert (np.argmax(rows > 18.0) - np.argmax(rows > 2.0)) * 0.0005 <= 0.1
            assert abs(rows[-1] - 20.0) < 1.0


def test_more_bandwidth_than_the_uncertainty_allows_is_seen():
    servo = profile("flexure-stage")["X"]
    _, _, found = designed_h_infinity(servo, "X", T, 8.0)
    assert not found.holds
    with pytest.raises(UsageError, match="designed for the model plant"):
        designed_h_infinity(profile("dyna-1007")["X"], "X", T, 8.0)
    free = Servo("plant", {**servo.parameters, "denominator": [1.0, 10.0, 0.0]})
    with pytest.raises(UsageError, match="this one integrates"):
        designed_h_infinity(free, "X", T)


def test_the_sampled_design_is_the_continuous_one_at_low_frequencies():
    values = servo_schema.resolve(profile("flexure-stage")["X"], "X")
    slow, fast = (hinf_servo.check(values, hinf_servo.controller_of(values, p), p) for p in (0.001, 0.0001))
    w = fast.frequency < 60.0
    assert np.interp(fast.frequency[w], slow.frequency, slow.sensitivity) == pytest.approx(
        fast.sensitivity[w], rel=0.1
    )


TABLE = '[axes.x.servo]\nmodel = "plant"\n'


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("numerator = [1.0]\ndenominator = [1.0, 1.0]\n", "PID needs it"),
        ("numerator = [1.0, 0.0]\ndenominator = [1.0, 1.0]\nposition_gain_1_mm = 1.0\n", "a plant has a lower one"),
        ('numerator = [1.0]\ndenominator = [1.0, 1.0]\ncontroller = "ratio"\n', "controller_numerator: missing"),
        ('numerator = [1.0]\ndenominator = [1.0, 1.0]\ncontroller = "h-infinity"\n', "sensitivity_bandwidth_rad_s: missing"),
        ("numerator = [1.0]\ndenominator = [1.0, -0.5]\nsample_time_s = 0.001\ncontrol_period_s = 0.002\n"
         "position_gain_1_mm = 1.0\n", "must be the sample_time_s"),
        ("numerator = [1.0]\ndenominator = [1.0, 1.0]\nposition_gain_1_mm = 1.0\ndrive_unit = 5\n", "must be a text"),
    ],
)  # fmt: skip
def test_faults_of_a_plant_are_named(lines, message):
    with pytest.raises(UsageError, match=message):
        servos_from_toml((TABLE + lines).encode(), "m.toml")


def test_a_rotary_plant_is_the_linear_one_in_degrees():
    linear = plant_servo([900.0], [1.0, 40.0, 900.0], **PI)
    turning = Servo(
        "plant",
        {"numerator": [900.0], "denominator": [1.0, 40.0, 900.0], "position_gain_1_deg": 0.6,
         "integral_gain_1_deg_s": 25.0},
    )  # fmt: skip
    found = run(np.radians(COMMAND)[:, None], {"C": turning}, axes="C")
    assert found.position[:, 0] == pytest.approx(np.radians(followed(linear)), abs=1e-12)
    assert math.isclose(servo_schema.resolve(turning, "C")["numerator"][0], 900.0 * math.pi / 180.0)
