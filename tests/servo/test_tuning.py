"""Placed gains give the poles and bandwidths asked for; a search never ends worse than it began."""

import contextlib
import math
import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.machine import servo_schema
from cncgen.machine.record import Servo
from cncgen.servo import plants
from cncgen.servo.controllers import ccc
from cncgen.servo.controllers.tcf import loop_on_a_line
from cncgen.servo.named_schemes import Settings, scheme_maker
from cncgen.servo.simulate import own_scheme, simulate, simulate_scheme
from cncgen.servo.summary import summarize
from cncgen.servo.tuning.analysis import (
    OpenLoop,
    axis_open_loop,
    closed_bandwidth_hz,
    linear_loop,
    open_loops,
    open_response,
)
from cncgen.servo.tuning.placement import VELOCITY_RATIO, check_stable, phase_margin, placed, placed_settings
from cncgen.servo.tuning.search import _trials, search

from .bench import circle, profile, stream

ROOT = Path(__file__).resolve().parents[2]


def closed_gain(servo, hertz):
    loop = servo_schema.closed_loop(servo)
    s = 2j * math.pi * hertz
    return abs(np.polyval(loop.numerator, s) / np.polyval(loop.denominator, s))


def test_pd_plus_has_the_poles_asked_for():
    servo = placed(profile("die-bonder")["X"], "X", 80.0, 0.8)
    lag, drag, stiff = servo_schema.closed_loop(servo).denominator
    assert math.sqrt(stiff / lag) == pytest.approx(2 * math.pi * 80.0)
    assert drag / lag / (2 * math.sqrt(stiff / lag)) == pytest.approx(0.8)


def test_first_order_has_the_bandwidth_or_the_damping():
    slow = placed(profile("dyna-1007")["X"], "X", 5.0, 0.7)
    assert closed_gain(slow, 5.0) == pytest.approx(math.sqrt(0.5))
    damped = placed(profile("dyna-1007")["X"], "X", 200.0, 0.7)
    assert damped.parameters["position_gain_1_s"] == pytest.approx(1 / (4 * 0.49 * 0.0047))


def test_the_cascade_has_both_bandwidths():
    servo = placed(profile("xy-table")["X"], "X", 40.0, 1.0)
    plain = Servo(servo.model, {**servo.parameters, "feedforward_gain": 0.0})
    assert closed_gain(plain, 40.0) == pytest.approx(math.sqrt(0.5), rel=1e-6)
    p = servo.parameters
    g, stiff = p["velocity_gain_1_s"], p["velocity_gain_1_s"] * p["integral_rate_1_s"]
    s = 2j * math.pi * 40.0 * VELOCITY_RATIO
    assert abs((g * s + stiff) / (s**2 + (p["velocity_pole_1_s"] + g) * s + stiff)) == pytest.approx(
        math.sqrt(0.5)
    )
    damping = (p["velocity_pole_1_s"] + g) / (2 * math.sqrt(stiff))
    assert damping == pytest.approx(1.0)


def plant(**values):
    """A drive g/(s(τs + 1)) of 8 deg/s a volt and 20 ms, or another."""
    return Servo("plant", {"numerator": [8.0], "denominator": [0.02, 1.0, 0.0], **values})


def test_pd_gains_of_a_rotary_drive_are_a_degrees():
    """Kp g = ω² τ and 1 + Kd g = 2 ζ ω τ with all of them in degrees; the servo then has the PD controller."""
    p = placed(plant(controller="h-infinity", sensitivity_bandwidth_rad_s=50.0), "A", 15.0, 0.8).parameters
    omega = 2.0 * math.pi * 15.0
    assert p["position_gain_1_deg"] * 8.0 == pytest.approx(omega**2 * 0.02)
    assert 1.0 + p["derivative_gain_s_deg"] * 8.0 == pytest.approx(2.0 * 0.8 * omega * 0.02)
    assert p["controller"] == "pid"
    linear = placed(plant(), "X", 15.0, 0.8).parameters
    assert linear["position_gain_1_mm"] == pytest.approx(p["position_gain_1_deg"])


@pytest.mark.parametrize(("letter", "unit"), [("X", "mm"), ("A", "deg")])
def test_two_masses_on_a_stiff_spring_are_one(letter, unit):
    """Poles of the sampled loop as e^(sT), by its matrix exponential: a pair of natural frequency 2π 10 and damping 0.7."""
    masses = {"motor_inertia_kg_m2": 0.002, "load_inertia_kg_m2": 0.01, "stiffness_n_m_rad": 1e5}
    friction = {"damping_n_m_s_rad": 5.0, "load_viscous_n_m_s_rad": 0.02}
    gain = {f"travel_{unit}_rad": 1.6, f"position_gain_n_m_{unit}": 1.0}
    servo = placed(Servo("two-mass", {**masses, **friction, **gain}), letter, 10.0, 0.7)
    period = 2e-5
    poles = linear_loop(servo, letter, period).poles()
    s = np.log(poles[np.abs(poles) > 1e-9]) / period
    slow = s[(np.abs(s) < 100.0) & (np.abs(s) > 1e-6)]
    assert len(slow) == 2
    np.testing.assert_allclose(np.abs(slow), 2.0 * math.pi * 10.0, rtol=5e-3)
    np.testing.assert_allclose(-slow.real / np.abs(slow), 0.7, rtol=5e-3)


@pytest.mark.parametrize(
    ("servo", "hertz", "damping", "words"),
    [
        (
            Servo("transfer-function", {"numerator": [1.0], "denominator": [0.1, 1.0]}),
            10.0,
            1.0,
            "are not placed",
        ),
        (plant(numerator=[1.0, 8.0]), 10.0, 1.0, "for plants g/(s(τs + 1)) alone"),
        (plant(denominator=[0.02, 1.0, 5.0]), 10.0, 1.0, "for plants g/(s(τs + 1)) alone"),
        (plant(), 1.0, 1.0, "1 Hz at damping 1 needs position_gain_1_mm ="),
        (plant(), 2e6, 1.0, "at most 1e+06 Hz"),
        (plant(), 10.0, 0.0, "must be positive"),
    ],
)
def test_gains_that_cannot_be_placed(servo, hertz, damping, words):
    with pytest.raises(UsageError) as caught:
        placed(servo, "X", hertz, damping)
    assert words in str(caught.value)
    assert caught.value.diagnostics[0].code == "tune-place"


def test_placed_gains_that_sampling_makes_unstable_are_refused():
    """P control of an integrator has its pole at 1 − Kv T, which a Kv of 2π 400 takes to −1.51 at 1 ms."""
    servo = placed(Servo("first-order", {"position_gain_1_s": 1.0}), "X", 400.0, 1.0)
    assert servo.parameters["position_gain_1_s"] == pytest.approx(2.0 * math.pi * 400.0)
    with pytest.raises(UsageError, match=r"\|z\| = 1\.513"):
        check_stable(servo, "X", 0.001, 400.0)
    check_stable(placed(servo, "X", 300.0, 1.0), "X", 0.001, 300.0)


def test_open_loop_of_the_cascade_is_its_block_diagram():
    servo = profile("xy-table")["X"]
    p = servo.parameters
    w = np.array([10.0, 100.0, 900.0])
    s = 1j * w
    velocity = p["velocity_gain_1_s"] * (1 + p["integral_rate_1_s"] / s) / (s * (s + p["velocity_pole_1_s"]))
    fast = replace(servo, parameters={**p, "control_period_s": 1e-7})
    assert open_response(fast, "X", 0.001, w) == pytest.approx(
        velocity * (s + p["position_gain_1_s"]), rel=1e-3
    )
    assert axis_open_loop(servo, "X", 0.001).margins().phase_deg == pytest.approx(41.7, abs=0.2)
    assert len(axis_open_loop(servo, "X", 0.001).bode_table(rows=7).splitlines()) == 8


def test_cross_coupling_crosses_where_asked_with_the_phase_of_its_damping():
    loops = own_scheme(profile("dyna-1007"), "XY", 0.001).loops
    settings = placed_settings("ccc", loops, 35.0, 0.4)
    coupling = ccc.coupling_of(loops, settings.ccc_proportional, settings.ccc_integral_1_s)
    w = np.array([2 * math.pi * 35.0])
    response = [ccc.contour_loop(loop, coupling.proportional, coupling.integral, w)[0] for loop in loops]
    assert max(abs(r) for r in response) == pytest.approx(1.0, rel=1e-9)
    wanted = math.degrees(phase_margin(0.4))
    assert wanted == pytest.approx(43.12, abs=0.01)  # Ogata, Fig. 7-29: near 100 ζ
    found = [180.0 + math.degrees(np.angle(r)) for r in response]
    assert min(found) == pytest.approx(wanted, abs=0.01)
    with pytest.raises(UsageError, match="of phase there"):
        placed_settings("ccc", loops, 70.0, 0.7)
    with pytest.raises(UsageError, match="half the control frequency"):
        placed_settings("ccc", loops, 600.0, 0.7)


def test_the_task_frames_loop_on_a_line_has_the_poles_asked_for():
    """1 + L = 0 at the poles of the sampled closed loop, which for a short period are those of s² + 2ζω s + ω²."""
    plant = plants.velocity_loop(1.0, 0.005)
    period, natural, damping = 1e-5, 120.0, 0.6
    pole = np.roots([1.0, 2 * damping * natural, natural**2])[0]
    loop = loop_on_a_line(plant, natural, damping, period, np.array([pole / 1j]))
    assert abs(1.0 + loop[0]) < 2e-3
    settings = placed_settings("tcf", (), 20.0, 0.7)
    names = [loop.name for loop in open_loops("tcf", profile("dyna-1007"), "XY", 0.001, settings)]
    assert names == [f"{k}, error {side} the path" for k in "XY" for side in ("along", "across")]


@pytest.mark.parametrize("controller", ["ccc", "tcf"])
def test_a_search_of_a_coupling_keeps_its_margins_on_any_number_of_processes(controller):
    setpoints = list(stream(circle(10.0, 60.0, turns=1.0)))
    servos = profile("dyna-1007")
    options = {"controller": controller, "sets": 24, "modulus": 0.5, "seed": 3}
    one, two = (search(setpoints, servos, workers=n, **options) for n in (1, 2))
    assert one.contour_rms_mm == two.contour_rms_mm <= one.start_rms_mm
    assert one.settings == two.settings
    least = min(loop.modulus() for loop in open_loops(controller, servos, "XY", 0.001, one.settings))
    assert least >= (0.25 if controller == "ccc" else 0.5)
    maker = scheme_maker(controller, one.servos, one.settings)
    again = summarize(simulate_scheme(iter(setpoints), maker))["contour_error_rms_mm"]
    assert again == one.contour_rms_mm


@pytest.mark.skipif(sys.platform != "linux", reason="the processes are forked where the trial is patched")
def test_a_process_that_is_ended_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """As the system ends one where memory runs out: this was an internal error."""
    here = os.getpid()
    monkeypatch.setattr(
        "cncgen.servo.tuning.search._Trials.contour_rms",
        lambda self, draw: 1.0 if os.getpid() == here else os._exit(9),
    )
    with pytest.raises(UsageError, match="ended from outside"):
        search(list(stream(circle(10.0, 60.0)[:100])), profile("dyna-1007"), sets=4, workers=2)


#: A search whose processes each say that they try a gain set, and take ten minutes for it.
LONG_SEARCH = """
import os, signal, time
from cncgen.servo.tuning import search
from tests.servo.bench import circle, profile, stream

driver = os.getpid()
# Whoever runs the tests may ignore it, as shells do for what they run in the background.
signal.signal(signal.SIGINT, signal.default_int_handler)

def tried(*_):
    if os.getpid() != driver:
        os.write(1, b"tried\\n")
        time.sleep(600)
    return 1.0

search._Trials.contour_rms = tried
search.search(list(stream(circle(10.0, 60.0)[:100])), profile("dyna-1007"), sets=40, workers=2)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="processes are forked")
@pytest.mark.parametrize("name", ["SIGINT", "SIGKILL"])
def test_the_processes_of_a_search_end_with_it(name: str) -> None:
    """The end of their common standard output says that all have ended; after an interrupt they did all that they had in hand."""
    command = [sys.executable, "-c", LONG_SEARCH]
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=ROOT, start_new_session=True) as run:
        try:
            assert run.stdout is not None
            assert [run.stdout.readline() for _ in range(2)] == [b"tried\n"] * 2
            run.send_signal(getattr(signal, name))
            run.communicate(timeout=60)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(run.pid, signal.SIGKILL)


def test_a_search_finds_less_contour_error_within_the_margin():
    setpoints = list(stream(circle(10.0, 60.0)))
    servos = profile("xy-table")
    found = search(setpoints, servos, sets=40, modulus=0.6)
    again = search(setpoints, servos, sets=40, modulus=0.6, workers=1)
    assert found.contour_rms_mm < found.start_rms_mm
    assert found.contour_rms_mm == again.contour_rms_mm
    assert summarize(simulate(iter(setpoints), found.servos))["contour_error_rms_mm"] == found.contour_rms_mm
    assert all(axis_open_loop(found.servos[k], k, 0.001).margins().modulus >= 0.59 for k in "XY")


def test_a_trial_multiplies_the_gains_that_are_there_to_be_changed():
    """Each by e to its own entry of a draw; gains that are 0 or absent stay, and H-infinity has none to be changed."""
    setpoints = tuple(stream(circle(10.0, 60.0, turns=0.2)))
    pi = {
        "numerator": [1000.0],
        "denominator": [1.0, 10.0, 0.0],
        "position_gain_1_mm": 2.0,
        "integral_gain_1_mm_s": 3.0,
    }
    servos = {"X": Servo("plant", pi), "Y": Servo("plant", {**pi, "integral_gain_1_mm_s": 0.0})}
    trials = _trials(setpoints, servos, "p", Settings(), 0.5)
    assert trials.names == (
        ("X", "position_gain_1_mm"), ("X", "integral_gain_1_mm_s"), ("Y", "position_gain_1_mm"),
    )  # fmt: skip
    found, _ = trials.gains(np.log([2.0, 0.5, 3.0]))
    assert found["X"].parameters["position_gain_1_mm"] == pytest.approx(4.0)
    assert found["X"].parameters["integral_gain_1_mm_s"] == pytest.approx(1.5)
    assert found["Y"].parameters["position_gain_1_mm"] == pytest.approx(6.0)
    assert servos["X"].parameters["position_gain_1_mm"] == 2.0
    designed = {
        k: Servo("plant", {**servo.parameters, "controller": "h-infinity"})
        for k, servo in profile("flexure-stage").items()
    }
    with pytest.raises(UsageError, match="no axis has a model whose gains can be searched"):
        _trials(setpoints, designed, "p", Settings(), 0.5)


def test_what_cannot_be_placed_is_said():
    ratio = Servo("transfer-function", {"numerator": [1.0], "denominator": [0.01, 1.0]})
    with pytest.raises(UsageError, match="not placed"):
        placed(ratio, "X", 10.0, 1.0)
    with pytest.raises(UsageError, match="faster or better damped"):
        placed(profile("die-bonder")["X"], "X", 0.1, 0.5)
    with pytest.raises(UsageError, match="tune-search"):
        search(list(stream(circle(10.0, 60.0)[:100])), {"X": ratio, "Y": ratio}, sets=2)


def test_bandwidth_of_a_fast_sampled_loop():
    """G = k/(z − 1 + k) of an integrator under P, k = Kv T = 1/2: |G|² = 1/2 where 5/4 − cos ωT = 1/2; k = 0.9 falls nowhere."""
    for k, hertz in ((0.5, math.acos(0.75) / 0.002 / math.pi), (0.9, math.inf)):
        loop = linear_loop(Servo("first-order", {"position_gain_1_s": k / 0.001}), "X", 0.001)
        assert closed_bandwidth_hz(loop) == pytest.approx(hertz, rel=5e-3)


def test_a_bode_table_of_an_integrator_behind_a_dead_time():
    """ωc e^(−jωτ)/(jω): −90° − ωτ at every row, turned on beyond −180°, from 0.1 Hz to half the control frequency."""
    crossover, delay, period = 40.0, 0.004, 0.001
    loop = OpenLoop("X", period, lambda w: crossover * np.exp(-1j * w * delay) / (1j * w))
    rows = np.array([[float(cell) for cell in row.split()] for row in loop.bode_table(60).splitlines()[1:]])
    w = 2.0 * math.pi * rows[:, 0]
    assert rows[0, 0] == 0.1
    assert rows[-1, 0] == pytest.approx(0.4995 / period, rel=1e-3)
    assert rows[:, 1] == pytest.approx(20.0 * np.log10(crossover / w), abs=0.02)
    # The table's frequencies have four digits.
    assert rows[:, 2] == pytest.approx(-90.0 - np.degrees(w * delay), abs=0.5)
    # Of the turns that a phase may be counted from, the one that begins nearest −90°.
    for degrees, shown in ((100.0, -260.0), (80.0, 80.0), (-179.0, -179.0)):
        fixed = OpenLoop("X", period, lambda w, at=degrees: np.full(len(w), np.exp(1j * math.radians(at))))
        assert float(fixed.bode_table(3).splitlines()[1].split()[2]) == shown


def test_distance_of_a_contour_loop_from_minus_one():
    """|1 + W G| of P-controlled integrators, G = T/(z − 1 + Kv T) and W = P + I T z/(z − 1), on a grid ten times as fine."""
    period, proportional, integral = 0.001, 90.0, 900.0
    loops, least = [], math.inf
    for gain in (30.0, 80.0):
        loops.append(linear_loop(Servo("first-order", {"position_gain_1_s": gain}), "X", period))
        z = np.exp(1j * np.geomspace(0.1, math.pi / period, 6000) * period)
        weight = proportional + integral * period * z / (z - 1.0)
        least = min(least, np.abs(1.0 + weight * period / (z - 1.0 + gain * period)).min())
    assert 0.5 < least < 0.99
    assert ccc.contour_modulus(loops, proportional, integral) == pytest.approx(least, rel=1e-4)
