"""Servo tables of a machine file: faults by name, values in inside units, closed loops as the papers print them."""

import math

import numpy as np
import pytest

from cncgen.machine import servo_schema
from cncgen.machine.record import Servo

XY_TABLE_X = {
    "velocity_pole_1_s": 36.4609,
    "velocity_gain_1_s": 346.592,
    "integral_rate_1_s": 146.167,
    "position_gain_1_s": 121.310,
    "feedforward_gain": 0.961191,
    "feedforward_filter_rad_s": 315.347,
}


def test_closed_loop_of_the_cascade_has_the_published_coefficients():
    """Tian, Meas. Sci. Rev. 25 (2025) 284 prints these four-digit coefficients for the X axis."""
    loop = servo_schema.closed_loop(Servo("pi-p-feedforward", XY_TABLE_X))
    assert loop.denominator == pytest.approx([1.0, 698.4, 2.135e5, 3.538e7, 1.938e9], rel=1e-5)
    assert loop.numerator == pytest.approx([1.471e5, 3.476e7, 1.938e9], rel=1e-5)


def test_closed_loop_of_the_cascade_is_the_block_diagram():
    """Compose plant, velocity PI, position P and feedforward as ratios at some frequencies, and compare."""
    p = XY_TABLE_X
    s = 1j * np.array([1.0, 30.0, 200.0, 900.0])
    velocity_pi = p["velocity_gain_1_s"] * (1 + p["integral_rate_1_s"] / s)
    forward = velocity_pi / (s * (s + p["velocity_pole_1_s"]))
    wn = p["feedforward_filter_rad_s"]
    command = p["position_gain_1_s"] + p["feedforward_gain"] * wn * s / (s + wn)
    expected = forward * command / (1 + forward * (s + p["position_gain_1_s"]))
    loop = servo_schema.closed_loop(Servo("pi-p-feedforward", p))
    assert np.polyval(loop.numerator, s) / np.polyval(loop.denominator, s) == pytest.approx(expected)


def test_closed_loop_of_pd_without_feedforward_has_the_poles_of_table_1():
    """Natural frequency and damping follow from Table 1 of Yeh and Sun: 418.3 rad/s and 0.294 on X."""
    values = {
        "time_constant_s": 0.31,
        "velocity_gain_rad_s_volt": 2506.17,
        "counts_per_rad": 1591.5494,
        "counts_per_mm": 1000.0,
        "position_gain_volt_count": 0.0136,
        "derivative_gain_volt_s_rad": 0.03,
        "feedforward": False,
    }
    loop = servo_schema.closed_loop(Servo("pd-plus", values))
    tau, damping, stiffness = loop.denominator
    natural = math.sqrt(stiffness / tau)
    assert natural == pytest.approx(418.3, abs=0.05)
    assert damping / tau / (2 * natural) == pytest.approx(0.294, abs=5e-4)


def test_two_mass_loop_is_rigid_at_low_frequency():
    """Far below the spring's resonance a two-mass axis is one inertia: compare with PID on 1/((J1 + J2) s²)."""
    values = {
        "motor_inertia_kg_m2": 1e-3,
        "load_inertia_kg_m2": 2e-3,
        "stiffness_n_m_rad": 1e7,
        "travel_mm_rad": 1.6,
        "position_gain_n_m_mm": 20.0,
        "derivative_gain_n_m_s_mm": 0.4,
    }
    loop = servo_schema.closed_loop(Servo("two-mass", values))
    s = 1j * np.array([5.0, 50.0])
    control = 20.0 + 0.4 * s
    rigid = 1.6 / (3e-3 * s**2)
    expected = control * rigid / (1 + control * rigid)
    got = np.polyval(loop.numerator, s) / np.polyval(loop.denominator, s)
    assert got == pytest.approx(expected, rel=1e-5)


def test_every_fault_of_a_table_is_named():
    table = {
        "model": "first-order",
        "position_gain_1_s": -1,
        "coulomb_lag_mm": "a",
        "position_gain": 3,
        "noise_seed": 1.5,
    }
    found = {(code, key) for code, key, _ in servo_schema.faults(table, "X")}
    assert found == {
        ("machine-value", "position_gain_1_s"),
        ("machine-value", "coulomb_lag_mm"),
        ("machine-key", "position_gain"),
        ("machine-value", "noise_seed"),
    }


@pytest.mark.parametrize("value", [math.nan, math.inf, True, "1", None, [1.0]])
def test_what_is_no_finite_number_is_a_fault(value):
    faults = list(servo_schema.faults({"model": "first-order", "position_gain_1_s": value}, "X"))
    assert [(code, key) for code, key, _ in faults] == [("machine-value", "position_gain_1_s")]


def test_missing_keys_and_unknown_models_are_named():
    assert {k for _, k, _ in servo_schema.faults({"model": "first-order"}, "X")} == {"position_gain_1_s"}
    [(code, key, message)] = servo_schema.faults({"model": "magic"}, "X")
    assert (code, key) == ("machine-value", "model")
    assert "pd-plus" in message


def test_a_rotary_axis_has_degrees_in_its_keys_and_radians_inside():
    table = {"model": "first-order", "position_gain_1_s": 50.0, "coulomb_lag_deg": 0.18}
    assert not list(servo_schema.faults(table, "A"))
    assert [k for _, k, _ in servo_schema.faults(table, "X")] == ["coulomb_lag_deg"]
    servo = Servo("first-order", {k: v for k, v in table.items() if k != "model"})
    values = servo_schema.resolve(servo, "A")
    assert values["coulomb_lag_mm"] == pytest.approx(math.radians(0.18))
    assert values["position_gain_1_s"] == 50.0
    assert servo_schema.force_unit(servo, "A") == "rad/s"


@pytest.mark.parametrize(
    ("numerator", "denominator", "keys"),
    [
        ([1.0], [1.0, 2.0], []),
        ([1.0, 0.0, 0.0], [1.0, 2.0], ["numerator"]),
        ([0.0, 0.0], [1.0], ["numerator"]),
        ([1.0], [1.0] * 13, ["denominator"]),
        ([1.0], [], ["denominator"]),
    ],
)
def test_polynomials_of_a_transfer_function(numerator, denominator, keys):
    table = {"model": "transfer-function", "numerator": numerator, "denominator": denominator}
    assert [k for _, k, _ in servo_schema.faults(table, "X")] == keys


def test_every_model_explains_each_of_its_keys_and_has_a_closed_loop():
    for name, model in servo_schema.MODELS.items():
        assert len({p.name for p in model.parameters}) == len(model.parameters)
        assert all(p.about for p in model.parameters), name


def test_a_transfer_function_in_z_has_no_continuous_form():
    servo = Servo(
        "transfer-function", {"numerator": [0.5], "denominator": [1.0, -0.5], "sample_time_s": 0.001}
    )
    with pytest.raises(ValueError, match="in z"):
        servo_schema.closed_loop(servo)
