"""Every plant under its control, beside scipy's solve_ivp; poles of closed loops, beside theory."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cncgen.machine import servo_schema
from cncgen.machine.record import Servo
from cncgen.servo import plants
from cncgen.servo.controller import Controller
from cncgen.servo.controllers.p import p
from cncgen.servo.controllers.pd_plus import pd_plus
from cncgen.servo.controllers.pi_p_feedforward import pi_p_feedforward
from cncgen.servo.controllers.pid import pid
from cncgen.servo.loop import close_loop, follow_transfer_function
from cncgen.servo.scheme import Scheme

from .bench import profile, run, run_scheme

T = 0.001
#: A command with corners and curves, mm.
COMMAND = np.concatenate([np.linspace(0, 5, 80), 5 + 2 * np.sin(np.linspace(0, 9, 250)), np.full(90, 5.8)])


def integrated(derivative, law, memory, command, state, breaks=(0.0, 1.0), period=T):
    """A plant ẋ = derivative(t, x, u) under a sampled law u, memory = law(memory, r, x); rows of states at the samples."""
    states = [np.asarray(state, float)]
    for r in command[:-1]:
        u, memory = law(memory, r, states[-1])
        x = states[-1]
        for a, b in itertools.pairwise(breaks):
            span = solve_ivp(
                lambda t, x, u=u: derivative(t, x, u), (a * period, b * period), x, rtol=1e-11, atol=1e-13
            )
            x = span.y[:, -1]
        states.append(x)
    return np.array(states)


def one_axis(loop, command=COMMAND):
    return run_scheme(command[:, None], Scheme((loop,)), axes="X").position[:, 0]


def close(ours, reference):
    assert np.abs(ours - reference).max() <= 1e-6 * np.abs(reference).max()


def test_velocity_loop_under_p():
    loop = close_loop(plants.velocity_loop(1.0, 0.0047), p(90.0), T)
    states = integrated(
        lambda t, x, u: [x[1], (u - x[1]) / 0.0047],
        lambda m, r, x: (90.0 * (r - x[0]), m),
        None,
        COMMAND,
        [0, 0],
    )
    close(one_axis(loop), states[:, 0])


def test_torque_mode_motor_under_pd_plus():
    """Yeh and Sun's X axis, its law (3.3) in counts and rad/s as printed."""
    tau, kc, ke, kp, kd, scale = 0.31, 2506.17, 1591.5494, 0.0136, 0.03, 1000.0

    def law(memory, r, x):
        command, speed_before, position = memory
        target = r * scale
        wanted, actual = (target - command) / (T * ke), (x[1] - position) / (T * ke)
        u = (
            kp * (target - x[1])
            + kd * (wanted - actual)
            + wanted / kc
            + tau / kc * (wanted - speed_before) / T
        )
        return u, (target, wanted, x[1])

    states = integrated(
        lambda t, x, u: [(kc * u - x[0]) / tau, ke * x[0]], law, (0.0, 0.0, 0.0), COMMAND, [0, 0]
    )
    free = dict(profile("die-bonder")["X"].parameters)
    del free["saturation_volt"]
    ours = run(COMMAND[:, None], {"X": Servo("pd-plus", free)}, axes="X").position[:, 0]
    close(ours, states[:, 1] / scale)


def test_cascade_of_paper_003_with_ramps_between_setpoints():
    """Transcribed from the block diagram: Fig. 2 of Tsai 2010, with the setpoint straight between samples."""
    v = profile("xy-table")["X"].parameters
    a, g, i = v["velocity_pole_1_s"], v["velocity_gain_1_s"], v["integral_rate_1_s"]
    k, f, w = v["position_gain_1_s"], v["feedforward_gain"], v["feedforward_filter_rad_s"]

    def derivative(t, x, ramp):
        r = ramp[0] + (ramp[1] - ramp[0]) * t / T
        y, speed, integral, low = x
        command = k * (r - y) + f * w * (r - low)
        return [speed, g * (command - speed) + g * i * integral - a * speed, command - speed, w * (r - low)]

    pairs = list(zip(COMMAND, np.append(COMMAND[1:], COMMAND[-1]), strict=True))
    states = integrated(derivative, lambda m, r, x: (r, m), None, pairs, np.zeros(4))
    close(run(COMMAND[:, None], profile("xy-table"), axes="X").position[:, 0], states[:, 0])


def test_two_mass_under_pid():
    j1, j2, k, c, c1, c2, travel = 1e-3, 2e-3, 400.0, 0.02, 0.01, 0.005, 1.6
    plant = plants.two_mass(j1, j2, k, c, c1, c2, travel)
    kp, ki, kd = 3.0, 10.0, 0.05
    loop = close_loop(plant, pid(kp, ki, kd, T), T)

    def derivative(t, x, u):
        twist, rate = k * (x[0] - x[2]), c * (x[1] - x[3])
        return [x[1], (u - c1 * x[1] - twist - rate) / j1, x[3], (twist + rate - c2 * x[3]) / j2]

    def law(memory, r, x):
        total, before = memory
        error = r - x[0] * travel
        return kp * error + total + kd * (error - before) / T, (total + ki * T * error, error)

    states = integrated(derivative, law, (0.0, 0.0), COMMAND, np.zeros(4))
    close(one_axis(loop), states[:, 2] * travel)


def test_transfer_function_plant_with_dead_time_under_p():
    """40/(s (s + 50)) behind 2.4 periods of dead time: the input of three periods ago, then of two."""
    loop = close_loop(plants.transfer_function([2000.0], [1.0, 50.0, 0.0], 2.4 * T), p(0.5), T)
    queue = [0.0, 0.0, 0.0, 0.0]

    def law(memory, r, x):
        queue.insert(0, 0.5 * (r - x[0]))
        return (queue[3], queue[2]), memory

    def derivative(t, x, u):
        return [x[1], 2000.0 * (u[0] if t < 0.4 * T else u[1]) - 50.0 * x[1]]

    states = integrated(derivative, law, None, COMMAND, [0, 0], breaks=(0.0, 0.4, 1.0))
    close(one_axis(loop), states[:, 0])


@pytest.mark.parametrize("delay", [0.0, 0.3, 1.0, 2.7])
def test_closed_loop_given_as_a_ratio_with_dead_time(delay):
    """(s + 8)/(s + 3), Chen and Hsu: x' = −3 x + r, y = 5 x + r of a setpoint straight between its samples."""
    loop = follow_transfer_function([1.0, 8.0], [1.0, 3.0], T, delay * T)
    times = np.arange(len(COMMAND)) * T

    def setpoint(t):
        return np.interp(t - delay * T, times, COMMAND)

    x, states = 0.0, [0.0]
    kinks = sorted({0.0, delay % 1.0, 1.0})
    for start in times[:-1]:
        for a, b in itertools.pairwise(kinks):
            span = solve_ivp(
                lambda t, x: -3.0 * x + setpoint(t),
                (start + a * T, start + b * T),
                [x],
                rtol=1e-11,
                atol=1e-13,
            )
            x = span.y[0, -1]
        states.append(x)
    close(one_axis(loop), 5.0 * np.array(states) + setpoint(times))


@pytest.mark.parametrize("delay", [0.0, 0.3, 1.0, 2.7, 3.0 - 1e-12])
def test_a_plant_answers_a_step_after_its_dead_time(delay):
    """1/(s + 30) under a drive of 1 from the first period on: (1 − exp(−30 (t − T − d)))/30, parts of a period too."""
    plant = plants.transfer_function([1.0], [1.0, 30.0], delay * T)
    t = np.arange(60) * T
    expected = -np.expm1(-30.0 * np.maximum(t - T - delay * T, 0.0)) / 30.0
    response = one_axis(close_loop(plant, Controller(d_setpoint=1.0), T), np.sign(t))
    assert response == pytest.approx(expected, abs=1e-12)


def test_ratio_in_z_is_its_difference_equation():
    loop = follow_transfer_function([0.2, 0.1], [1.0, -0.9, 0.2], T, discrete=True)
    y = np.zeros(len(COMMAND))
    for k in range(1, len(y)):
        y[k] = (
            0.9 * y[k - 1] - 0.2 * y[k - 2] * (k > 1) + 0.2 * COMMAND[k - 1] + 0.1 * COMMAND[k - 2] * (k > 1)
        )
    assert one_axis(loop) == pytest.approx(y, abs=1e-12)


@pytest.mark.parametrize("coulomb", [0.5, 4.0])
def test_friction_is_that_of_an_event_driven_integration(coulomb):
    """Torque-mode motor under PD with Coulomb friction: slip and stick integrated piece by piece with event location."""
    tau, gain, kp, kd = 0.02, 30.0, 2.0, 0.05
    plant = plants.velocity_loop(gain, tau).with_imperfections(coulomb=coulomb)
    command = 3.0 * np.sin(np.arange(400) * 0.03)
    ours = one_axis(close_loop(plant, pd_plus(kp, kd, 0.0, 0.0, T), T), command)
    y, v, before, rows = 0.0, 0.0, (0.0, 0.0), []
    for r in command:
        rows.append(y)
        u = kp * (r - y) + kd * ((r - before[0]) - (y - before[1])) / T
        before, left = (r, y), T
        while left > 1e-15:
            if v == 0.0 and abs(u) <= coulomb:
                break
            sign = np.sign(v) if v else np.sign(u)
            goal = gain * (u - coulomb * sign)
            stop = tau * np.log(1 - v / goal) if v and goal * v < 0 else np.inf
            span = min(stop, left)
            decay = np.exp(-span / tau)
            y += goal * span + (v - goal) * tau * (1 - decay)
            v = 0.0 if stop <= left else goal + (v - goal) * decay
            left -= span
    assert np.abs(ours - rows).max() <= 1e-6 * np.abs(rows).max()


def test_poles_of_the_cascade_are_those_of_appendix_a_1():
    servo = profile("xy-table")["X"]
    v = dict(servo.parameters)
    controller = pi_p_feedforward(*(v[k] for k in (
        "velocity_gain_1_s", "integral_rate_1_s", "position_gain_1_s", "feedforward_gain", "feedforward_filter_rad_s")))  # fmt: skip
    loop = close_loop(plants.motor(v["velocity_pole_1_s"]), controller, T)
    expected = np.exp(np.roots(servo_schema.closed_loop(servo).denominator) * T)
    assert np.sort_complex(loop.poles()) == pytest.approx(np.sort_complex(expected), rel=1e-9)


def test_poles_of_sampled_p_control_are_those_of_the_closed_form():
    """P on 1/(s(τs+1)) held over T: z² − (1 + a − K g1) z + a + K g0, Åström and Wittenmark, table 2.1."""
    tau, gain = 0.0047, 90.0
    decay = np.exp(-T / tau)
    g1, g0 = T - tau * (1 - decay), tau * (1 - decay) - T * decay
    loop = close_loop(plants.velocity_loop(1.0, tau), p(gain), T)
    expected = np.roots([1.0, gain * g1 - 1.0 - decay, decay + gain * g0])
    assert np.sort_complex(loop.poles()) == pytest.approx(np.sort_complex(expected), rel=1e-10)


def test_poles_of_pd_plus_are_those_of_its_characteristic_equation():
    """Feedforward leaves poles alone: three of PD on the held motor, the rest at 0."""
    tau, gain, kp, kd = 0.31, 4000.0, 13.6, 0.019
    loop = close_loop(plants.velocity_loop(gain, tau), pd_plus(kp, kd, 0.3, 0.1, T), T)
    decay = np.exp(-T / tau)
    g1, g0 = gain * (T - tau * (1 - decay)), gain * (tau * (1 - decay) - T * decay)
    control = np.array([kp + kd / T, -kd / T])
    expected = np.roots(
        np.polyadd(np.polymul([1.0, 0.0], np.poly([1.0, decay])), np.polymul(control, [g1, g0]))
    )
    found = loop.poles()
    assert np.sort_complex(found[np.argsort(np.abs(found))[2:]]) == pytest.approx(
        np.sort_complex(expected), rel=1e-9
    )


def test_what_cannot_be_joined_is_said():
    with pytest.raises(ValueError, match="velocity"):
        close_loop(plants.integrator(), pi_p_feedforward(1, 1, 1, 1, 1), T)
    with pytest.raises(ValueError, match="dead time"):
        close_loop(
            plants.transfer_function([1.0], [1.0, 1.0, 0.0], 0.5 * T).with_imperfections(coulomb=1.0),
            p(1.0),
            T,
        )
    with pytest.raises(ValueError, match="more than 250 control periods"):
        follow_transfer_function([1.0], [0.01, 1.0], T, 0.9)
    with pytest.raises(ValueError, match="more than 250 control periods"):
        close_loop(plants.transfer_function([1.0], [1.0, 1.0, 0.0], 0.9), p(1.0), T)
    with pytest.raises(ValueError, match="lower degree"):
        plants.transfer_function([1.0, 1.0], [1.0, 2.0])
    with pytest.raises(ValueError, match="whole number"):
        follow_transfer_function([1.0], [1.0, -0.5], T, 0.5 * T, discrete=True)


@pytest.mark.timeout(30)
def test_an_axis_that_trembles_about_standing_ends_its_period():
    """Forces below the rounding of the states make friction change sides at every step; the period must end all the same."""
    values = {
        "motor_inertia_kg_m2": 6774.754967302561, "load_inertia_kg_m2": 58922.06771967757,
        "stiffness_n_m_rad": 0.01126152250025007, "load_viscous_n_m_s_rad": 0.002823230572085219,
        "travel_mm_rad": 0.0002608269795164493, "position_gain_n_m_mm": 1917.7368029085048,
        "derivative_gain_n_m_s_mm": 0.0006481325871104532, "coulomb_n_m": 0.0013937899367195458,
    }  # fmt: skip
    command = 5.0 * np.sin(9.0 * np.arange(300) * T)
    assert np.isfinite(run(command[:, None], {"X": Servo("two-mass", values)}, axes="X").position).all()
