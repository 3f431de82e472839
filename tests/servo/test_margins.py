"""Margins of the sampled loops of all shipped profiles beside a Bode computation that shares nothing with ours.

Plants are discretised by scipy (zero-order hold), controllers are written down in z from their pages, and the crossings are
found by bisection.
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.signal import cont2discrete

from cncgen.cli.app import run
from cncgen.machine import load_machine, profile_names
from cncgen.machine.record import Servo
from cncgen.machine.servo_schema import resolve
from cncgen.report.tuned import margin_text
from cncgen.servo.models import plant_and_controller
from cncgen.servo.simulate import simulate
from cncgen.servo.summary import summarize
from cncgen.servo.tuning.analysis import _transition_by_a_drive, axis_open_loop, worst_margins
from cncgen.servo.tuning.search import search
from cncgen.servo.uncertainty import Perturbation, perturbed

from .bench import circle, profile, stream


def held_plant(numerator, denominator, period):
    """z ↦ P(z) of a plant whose input is held."""
    above, below, _ = cont2discrete((numerator, denominator), period, "zoh")
    return lambda z: np.polyval(above[0], z) / np.polyval(below, z)


def first_order(p, period):
    plant = held_plant([1.0], [p["time_constant_s"], 1.0, 0.0], period)
    return lambda z: p["position_gain_1_s"] * plant(z)


def pd_plus(p, period):
    motor = p["velocity_gain_rad_s_volt"] * p["counts_per_rad"]  # counts/s a volt
    plant = held_plant([motor], [p["time_constant_s"], 1.0, 0.0], period)
    kp, kd = p["position_gain_volt_count"], p["derivative_gain_volt_s_rad"] / p["counts_per_rad"]
    return lambda z: (kp + kd * (1.0 - 1.0 / z) / period) * plant(z)


def cascade(p, period):
    """PI velocity loop in a P position loop, its integral by backward differences, and one period of computing."""
    pole, gain = p["velocity_pole_1_s"], p["velocity_gain_1_s"]
    speed, position = held_plant([1.0], [1.0, pole], period), held_plant([1.0], [1.0, pole, 0.0], period)
    integral = lambda z: 1.0 + p["integral_rate_1_s"] * period / (1.0 - 1.0 / z)  # noqa: E731
    return lambda z: gain * integral(z) * (speed(z) + p["position_gain_1_s"] * position(z)) / z


def integral_control(p, period):
    plant = held_plant(p["numerator"], p["denominator"], period)
    return lambda z: p["integral_gain_1_mm_s"] * period / (z - 1.0) * plant(z)


LOOPS = {
    "first-order": first_order,
    "pd-plus": pd_plus,
    "pi-p-feedforward": cascade,
    "plant": integral_control,
}


def crossings(function, grid):
    values = function(grid)
    return [
        brentq(function, grid[i], grid[i + 1], xtol=1e-10) for i in np.flatnonzero(np.diff(np.sign(values)))
    ]


def margins_of(loop, period):
    """Gain margin in dB and phase margin in degrees: at real crossings of the negative real axis, and of the unit circle."""
    grid = np.geomspace(0.1, 0.99999 * math.pi / period, 40_000)
    at = lambda w: loop(np.exp(1j * np.asarray(w) * period))  # noqa: E731
    turns = [w for w in crossings(lambda w: at(w).imag, grid) if at(w).real < 0.0]
    gains = [-20.0 * math.log10(abs(at(w))) for w in turns]
    phases = [math.degrees(np.angle(-at(w))) for w in crossings(lambda w: np.abs(at(w)) - 1.0, grid)]
    return min((g for g in gains if g > 0.0), default=math.inf), min(phases, key=abs, default=math.inf)


AXES = [(name, letter) for name in profile_names() for letter in load_machine(name).axes]


@pytest.mark.parametrize(("name", "letter"), AXES)
def test_margins_equal_an_independent_bode_computation(name, letter):
    machine = load_machine(name)
    servo = machine.axes[letter].servo
    p = resolve(servo, letter)
    period = p["control_period_s"] or machine.period_s
    gain, phase = margins_of(LOOPS[servo.model](p, period), period)
    found = axis_open_loop(servo, letter, machine.period_s).margins()
    assert 20.0 * math.log10(found.gain) == pytest.approx(gain, abs=0.1)
    assert found.phase_deg == pytest.approx(phase, abs=0.5)
    assert math.isfinite(gain)
    assert math.isfinite(phase)


@pytest.mark.parametrize("gain", [400.0, 4000.0])
def test_the_poles_of_a_sampled_cascade_are_those_of_its_open_loop(gain):
    """1 + L(z) is the closed loop's polynomial over the open one's, whatever z: L is this file's own."""
    machine = load_machine("xy-table")
    servo = machine.axes["X"].servo
    servo = Servo(servo.model, {**servo.parameters, "velocity_gain_1_s": gain})
    p = resolve(servo, "X")
    period = p["control_period_s"]
    plant, controller = plant_and_controller(servo, "X", period)
    closed = np.linalg.eigvals(_transition_by_a_drive(plant, controller, period))
    # The plant's poles, the integral's, the feedforward filter's, and one period of computing.
    filtered = 1.0 / (1.0 + p["feedforward_filter_rad_s"] * period)
    open_poles = np.array([1.0, math.exp(-p["velocity_pole_1_s"] * period), 1.0, filtered, 0.0])
    for z in (1.3 + 0.2j, -0.4 + 0.9j, 2.0):
        both = np.prod(z - closed) / np.prod(z - open_poles)
        assert both == pytest.approx(1.0 + cascade(p, period)(z), rel=1e-9)
    assert (axis_open_loop(servo, "X", period).largest_pole < 1.0) == (gain < 1000.0)


def test_gains_that_a_drive_cannot_sample_are_refused(tmp_path, capfd):
    """A velocity loop of 400 Hz under an input that is a period of 0.5 ms late: its margins would be those of no stable loop."""
    call = ["tune", "-m", "xy-table", "--no-bode", "-o", str(tmp_path / "t.toml"), "--bandwidth", "200"]
    assert run(call) == 2
    assert (
        "error[tune-place]: axis X: gains for 200 Hz are unstable at a control period"
        in capfd.readouterr().err
    )
    assert not (tmp_path / "t.toml").exists()
    servo = load_machine("xy-table").axes["X"].servo
    hot = axis_open_loop(Servo(servo.model, {**servo.parameters, "velocity_gain_1_s": 4000.0}), "X", 0.001)
    assert margin_text(hot, False).startswith("X: UNSTABLE, a pole at |z| = ")


def test_a_target_that_is_missed_is_said(tmp_path, capfd):
    """P round a lag of 4.7 ms: damping 1 leaves 1/(4·4.7 ms) = 53/s, some 7 Hz, whatever bandwidth is asked for."""
    call = ["tune", "-m", "dyna-1007", "--no-bode", "-o", str(tmp_path / "t.toml"), "--bandwidth"]
    assert run([*call, "40"]) == 0
    said = capfd.readouterr().err
    assert "warning[tune-missed]: axis X: 40 Hz were asked for, and the closed loop reaches" in said
    assert " dB (a factor of " in said
    assert run([*call, "5"]) == 0
    assert "tune-missed" not in capfd.readouterr().err


def test_worst_margins_are_those_of_the_worst_machine():
    """One parameter alone is uncertain: the least margins are those at the end of its range, which draws come near to."""
    servos = {"X": Servo("first-order", {"position_gain_1_s": 100.0})}
    (worst,) = worst_margins("p", servos, "X", 0.001, None, Perturbation(0.2, 256))
    (end,) = (axis_open_loop(Servo("first-order", {"position_gain_1_s": 120.0}), "X", 0.001).margins(),)
    assert worst.gain == pytest.approx(end.gain, rel=0.01)
    assert worst.phase_deg == pytest.approx(end.phase_deg, abs=0.2)
    assert worst.unstable == 0
    hot = {"X": Servo("first-order", {"position_gain_1_s": 1900.0})}
    assert 0 < worst_margins("p", hot, "X", 0.001, None, Perturbation(0.2, 64))[0].unstable < 64


def test_gains_are_searched_for_the_worst_machine():
    """The error that the search states is the worst over the same draws, simulated here one by one."""
    rows, servos = circle(10.0, 60.0, turns=0.5), dict(profile("xy-table"))
    drawn = Perturbation(0.1, 4)
    found = search(tuple(stream(rows)), servos, sets=6, modulus=0.4, workers=1, perturbation=drawn)
    machines = [found.servos, *perturbed(found.servos, "XY", drawn)]
    errors = [summarize(simulate(stream(rows), one))["contour_error_rms_mm"] for one in machines]
    assert found.contour_rms_mm == pytest.approx(max(errors))
    assert found.contour_rms_mm <= found.start_rms_mm
