"""Placed gains give the poles and bandwidths asked for; a search never ends worse than it began."""

import math

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.machine import servo_schema
from cncgen.machine.record import Servo
from cncgen.servo.simulate import simulate
from cncgen.servo.summary import summarize
from cncgen.servo.tuning import VELOCITY_RATIO, bode_table, loop_margins, open_response, placed, search

from .bench import circle, profile, stream


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


def test_open_loop_of_the_cascade_is_its_block_diagram():
    servo = profile("xy-table")["X"]
    p = servo.parameters
    w = np.array([10.0, 100.0, 900.0])
    s = 1j * w
    velocity = p["velocity_gain_1_s"] * (1 + p["integral_rate_1_s"] / s) / (s * (s + p["velocity_pole_1_s"]))
    assert open_response(servo, "X", 0.001, w) == pytest.approx(velocity * (s + p["position_gain_1_s"]))
    assert loop_margins(servo, "X", 0.001).phase_deg > 45.0
    assert len(bode_table(servo, "X", 0.001, rows=7).splitlines()) == 8


def test_a_search_finds_less_contour_error_within_the_margin():
    setpoints = list(stream(circle(10.0, 60.0)))
    servos = profile("xy-table")
    found = search(setpoints, servos, sets=40, modulus=0.6)
    again = search(setpoints, servos, sets=40, modulus=0.6, workers=1)
    assert found.contour_rms_mm < found.start_rms_mm
    assert found.contour_rms_mm == again.contour_rms_mm
    assert summarize(simulate(iter(setpoints), found.servos))["contour_error_rms_mm"] == found.contour_rms_mm
    assert all(loop_margins(found.servos[k], k, 0.001).modulus >= 0.59 for k in "XY")


def test_what_cannot_be_placed_is_said():
    ratio = Servo("transfer-function", {"numerator": [1.0], "denominator": [0.01, 1.0]})
    with pytest.raises(UsageError, match="not placed"):
        placed(ratio, "X", 10.0, 1.0)
    with pytest.raises(UsageError, match="faster or better damped"):
        placed(profile("die-bonder")["X"], "X", 0.1, 0.5)
    with pytest.raises(UsageError, match="tune-search"):
        search(list(stream(circle(10.0, 60.0)[:100])), {"X": ratio, "Y": ratio}, sets=2)
