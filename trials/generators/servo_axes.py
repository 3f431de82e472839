"""Random servo axes as real ones are: loops that a fitter would leave so, with friction, play, encoder steps, dead time."""

from __future__ import annotations

import math
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from cncgen.machine import Machine, Servo, load_machine
from cncgen.machine.record import Axis

#: What `drawn_axes` draws.
KINDS = (
    "P loop",
    "P loop, friction",
    "P loop, backlash, encoder",
    "P loop, weak drive",
    "two masses",
    "two masses, friction",
    "two masses, friction, backlash, encoder",
    "plant, dead time",
    "zero on the right, dead time",
    "velocity feedforward, friction",
)


def drawn_axes(draw: np.random.Generator, kind: str) -> tuple[Machine, dict[str, Servo]]:
    """Return a machine with limits of X and Y, and their servo data, which differ a little."""
    velocity, acceleration = _ten(draw, 80.0, 600.0), _ten(draw, 500.0, 8000.0)
    jerk = acceleration * _ten(draw, 10.0, 80.0)
    axes = {letter: Axis(letter, velocity, acceleration, jerk) for letter in "XY"}
    machine = replace(
        load_machine("xy-table"),
        axes=MappingProxyType(axes),
        period_s=float(draw.choice([0.5e-3, 1e-3, 2e-3])),
    )
    makes = {"P": _p_loop, "t": _two_masses, "p": _plant, "z": _zero, "v": _feedforward}
    model, values = makes[kind[0]](draw, machine.period_s)
    if "friction" in kind:
        values |= _friction(draw, model, values, velocity)
    if "backlash" in kind:
        values |= {
            "backlash_mm": _ten(draw, 5e-4, 1e-2),
            "encoder_resolution_mm": float(draw.choice([1e-4, 5e-4, 1e-3])),
        }
    if "weak" in kind:
        values["saturation_mm_s"] = 1.1 * velocity
    return machine, {letter: Servo(model, _varied(draw, model, values)) for letter in "XY"}


def _ten(draw: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(draw.uniform(math.log(low), math.log(high))))


def _p_loop(draw: np.random.Generator, period: float) -> tuple[str, dict[str, Any]]:
    gain = _ten(draw, 20.0, min(150.0, 0.2 / period))
    return "first-order", {"position_gain_1_s": gain, "time_constant_s": draw.uniform(0.05, 0.4) / gain}


def _two_masses(draw: np.random.Generator, period: float) -> tuple[str, dict[str, Any]]:
    """Return two masses with a resonance, under PID control of a sixth to a tenth of its frequency."""
    motor, load = _ten(draw, 5e-4, 5e-3), _ten(draw, 5e-4, 5e-3)
    resonance = 2.0 * math.pi * _ten(draw, 60.0, 0.12 / period)
    stiffness = resonance**2 * motor * load / (motor + load)
    band, total = resonance * draw.uniform(0.1, 0.16), motor + load
    travel = float(draw.choice([0.8, 1.6, 3.2]))
    values = {
        "motor_inertia_kg_m2": motor,
        "load_inertia_kg_m2": load,
        "stiffness_n_m_rad": stiffness,
        "damping_n_m_s_rad": 2.0 * draw.uniform(0.02, 0.1) * stiffness / resonance,
        "motor_viscous_n_m_s_rad": 0.05 * band * total,
        "travel_mm_rad": travel,
        "position_gain_n_m_mm": band**2 * total / travel,
        "derivative_gain_n_m_s_mm": 1.6 * band * total / travel,
        "integral_gain_n_m_mm_s": 0.1 * band**3 * total / travel,
    }
    return "two-mass", values


def _plant(draw: np.random.Generator, period: float) -> tuple[str, dict[str, Any]]:
    """Return an integrator with a lag and a dead time under a P controller."""
    delay = period * draw.uniform(0.3, 3.0)
    gain = draw.uniform(0.1, 0.25) / (delay + 2.0 * period)
    values = {
        "numerator": [1.0],
        "denominator": [draw.uniform(0.05, 0.3) / gain, 1.0, 0.0],
        "position_gain_1_mm": gain,
        "drive_unit": "mm/s",
        "delay_s": delay,
    }
    return "plant", values


def _zero(draw: np.random.Generator, period: float) -> tuple[str, dict[str, Any]]:
    """Return a closed loop with a zero on the right and a dead time."""
    zero, slow, fast = _ten(draw, 100.0, 600.0), _ten(draw, 30.0, 150.0), _ten(draw, 150.0, 400.0)
    denominator = [1.0 / (slow * fast), 1.0 / slow + 1.0 / fast, 1.0]
    return "transfer-function", {
        "numerator": [-1.0 / zero, 1.0],
        "denominator": denominator,
        "delay_s": period * draw.uniform(0.0, 3.0),
    }


def _feedforward(draw: np.random.Generator, period: float) -> tuple[str, dict[str, Any]]:
    """Return a cascade with velocity feedforward."""
    inner = draw.uniform(0.1, 0.25) / period
    values = {
        "velocity_pole_1_s": _ten(draw, 1.0, 30.0),
        "velocity_gain_1_s": inner,
        "integral_rate_1_s": inner * draw.uniform(0.05, 0.2),
        "position_gain_1_s": inner * draw.uniform(0.15, 0.3),
        "feedforward_gain": draw.uniform(0.7, 1.0),
        "feedforward_filter_rad_s": _ten(draw, 100.0, 1000.0),
    }
    return "pi-p-feedforward", values


def _friction(
    draw: np.random.Generator, model: str, values: dict[str, Any], velocity: float
) -> dict[str, Any]:
    if model == "first-order":
        return {"coulomb_lag_mm": _ten(draw, 2e-3, 5e-2), "viscous_share": draw.uniform(0.0, 0.05)}
    if model == "two-mass":
        return {"coulomb_n_m": _ten(draw, 0.02, 0.3)}
    return {"coulomb_mm_s2": _ten(draw, 20.0, 1000.0), "viscous_1_s": draw.uniform(0.0, 5.0)}


def _varied(draw: np.random.Generator, model: str, values: dict[str, Any]) -> dict[str, Any]:
    """Return values up to 5 % off, but for polynomials, encoder steps and travels."""
    exact = ("travel_mm_rad", "encoder_resolution_mm")
    return {
        key: value * draw.uniform(0.95, 1.05) if isinstance(value, float) and key not in exact else value
        for key, value in values.items()
    }
