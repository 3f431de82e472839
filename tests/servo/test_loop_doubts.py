"""Loops that nobody can mean are simulated and told. Poles and lags are those of the polynomials, in closed form."""

import warnings

import numpy as np
import pytest

from cncgen.machine import Servo, load
from cncgen.servo.loop_doubts import doubts
from cncgen.servo.models import axis_loop
from cncgen.servo.simulate import simulate
from cncgen.setpoints.record import Setpoints

RAMP = Setpoints("X", 0.001, 0, np.linspace(0.0, 1.0, 200)[:, None])


def told(model, **parameters):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        list(simulate(iter([RAMP]), {"X": Servo(model, parameters)}))
    return [w.message.diagnostic for w in caught]


def test_a_slowly_unstable_transfer_function_names_its_pole():
    """s² + 0.95 s − 0.05 = (s + 1)(s − 0.05): it grows by e in 20 s, too slowly to run away within a program."""
    (found,) = told("transfer-function", numerator=[-0.05], denominator=[1.0, 0.95, -0.05])
    assert (found.code, found.severity) == ("servo-unstable", "warning")
    assert found.values["pole_1_s"] == pytest.approx(0.05, rel=1e-6)
    assert "at +0.05 1/s grows by a factor of e every 20 s" in found.message


def test_an_unstable_pair_has_its_frequency():
    """s² − 2·0.1 s + 0.1² + (2π·3)²: 3 Hz."""
    last = 0.1**2 + (2.0 * np.pi * 3.0) ** 2
    (found,) = told("transfer-function", numerator=[last], denominator=[1.0, -0.2, last])
    assert found.values["pole_1_s"] == pytest.approx(0.1, rel=1e-6)
    assert found.values["pole_hz"] == pytest.approx(3.0, rel=1e-6)


def test_a_lag_of_seconds_is_told():
    """Under P control a ramp is followed 1/K behind."""
    (found,) = told("first-order", position_gain_1_s=0.2, time_constant_s=0.005)
    assert found.code == "servo-lag"
    assert found.values["lag_s"] == pytest.approx(5.0, rel=1e-3)


def test_an_axis_that_a_setpoint_does_not_move_lags():
    """s² τ + s + K of τ = 1e9 s hardly moves within the ramp: it is as late as the ramp is long, the last power of two of periods below 90 s.

    Its settled lag, 1/K = 33 ms, is reached after years.
    """
    (found,) = told("first-order", position_gain_1_s=30.0, time_constant_s=1e9)
    assert found.code == "servo-lag"
    assert found.values["lag_s"] == pytest.approx(2**16 * 1e-3, rel=1e-3)


def test_a_wrong_gain_is_told():
    (found,) = told("transfer-function", numerator=[50.0], denominator=[1.0, 100.0])
    assert found.code == "servo-gain"
    assert found.values["gain"] == pytest.approx(0.5)


@pytest.mark.parametrize("name", ["die-bonder", "dyna-1007", "flexure-stage", "xy-table"])
def test_machines_that_ship_have_no_doubts(name):
    for letter, axis in load(name).axes.items():
        assert list(doubts(axis_loop(axis.servo, letter, 0.001), letter)) == []
