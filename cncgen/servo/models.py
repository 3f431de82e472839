"""From the servo table of a machine file to a closed loop."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine.record import Servo
from cncgen.machine.servo_schema import force_unit, resolve
from cncgen.servo import plants
from cncgen.servo.controller import Controller
from cncgen.servo.controllers.p import p
from cncgen.servo.controllers.pd_plus import pd_plus
from cncgen.servo.controllers.pi_p_feedforward import pi_p_feedforward
from cncgen.servo.controllers.pid import pid
from cncgen.servo.controllers.ratio import sampled
from cncgen.servo.loop import AxisLoop, close_loop, follow_transfer_function
from cncgen.servo.plants import Imperfections, Plant

Values = Mapping[str, Any]

#: Control periods that a setpoint may have: drives have some tens, current loops some hundreds.
MAX_CONTROL_PERIODS = 10_000


def control_period(servo: Servo, letter: str, period_s: float) -> float:
    """Return the control period that fits an axis to setpoints of `period_s`.

    Raises:
        UsageError: The setpoint period is not a whole multiple of the control period, or is one of very many (``servo-period``).
    """
    values = resolve(servo, letter)
    wanted = values.get("control_period_s") or values.get("sample_time_s") or period_s
    parts = period_s / wanted
    if round(parts) < 1 or abs(parts - round(parts)) > 1e-6:
        raise UsageError(
            Diagnostic(
                "servo-period",
                f"axis {letter}: the setpoint period {period_s:g} s must be a whole multiple of the control period {wanted:g} s",
                hint="give setpoints at a multiple of the control period, or change control_period_s",
                values={"axis": letter, "period_s": period_s, "control_period_s": wanted},
            )
        )
    if parts > MAX_CONTROL_PERIODS:
        raise UsageError(
            Diagnostic(
                "servo-period",
                f"axis {letter}: {parts:.3g} control periods of {wanted:g} s in a setpoint of {period_s:g} s; "
                f"at most {MAX_CONTROL_PERIODS} are simulated",
                hint="is control_period_s in seconds?",
                values={"axis": letter, "period_s": period_s, "control_period_s": wanted},
            )
        )
    return period_s / round(parts)


def axis_loop(servo: Servo, letter: str, period_s: float) -> AxisLoop:
    """Return the closed loop of an axis for setpoints every `period_s`.

    Raises:
        UsageError: The periods do not fit, or the model's values contradict each other (``servo-model``).
    """
    period = control_period(servo, letter, period_s)
    values = resolve(servo, letter)
    try:
        if servo.model == "transfer-function":
            return _given_loop(values, period)
        plant, controller = plant_and_controller(servo, letter, period)
        return close_loop(plant, controller, period)
    except ValueError as error:
        raise UsageError(Diagnostic("servo-model", f"axis {letter}, {servo.model}: {error}")) from error


def plant_and_controller(servo: Servo, letter: str, period_s: float) -> tuple[Plant, Controller]:
    """Return the parts of a model, for another controller on the same plant.

    Raises:
        ValueError: The model is a closed loop as a whole and has no plant of its own.
    """
    if servo.model not in _PARTS:
        raise ValueError(f"the model {servo.model} has no plant that another controller could drive")
    values = resolve(servo, letter)
    plant, controller = _PARTS[servo.model](values, period_s)
    if servo.knows is not None:
        _, controller = _PARTS[servo.model](resolve(servo.knows, letter), period_s)
    plant = plant.with_viscous(_VISCOUS[servo.model](values))
    imperfections = _imperfections(values, *_COULOMB_AND_BOUND[servo.model](values))
    unit = force_unit(servo, letter)
    return replace(plant, imperfections=imperfections, force_unit=unit), controller


def _imperfections(values: Values, coulomb: float, bound: float | None) -> Imperfections:
    return Imperfections(
        bound=math.inf if bound is None else bound,
        coulomb=coulomb,
        backlash=values["backlash_mm"],
        encoder_step=values["encoder_resolution_mm"],
        noise=values["noise_rms_mm"],
        seed=int(values["noise_seed"]),
        load_feedback=values["feedback"] == "load",
    )


def _first_order(values: Values, period: float) -> tuple[Plant, Controller]:
    lag = values["time_constant_s"]
    if lag > 0.0:
        return plants.velocity_loop(1.0, lag), p(values["position_gain_1_s"])
    # Without a lag the loop settles at once where friction leaves it: u = (1 + share) v.
    plant = plants.integrator(1.0 / (1.0 + values["viscous_share"]))
    return plant, p(values["position_gain_1_s"])


def _pd_plus(values: Values, period: float) -> tuple[Plant, Controller]:
    tau, gain, scale = (values[k] for k in ("time_constant_s", "velocity_gain_rad_s_volt", "counts_per_mm"))
    radian = scale / values["counts_per_rad"]
    forward = radian / gain if values["feedforward"] else 0.0
    plant = plants.velocity_loop(gain / radian, tau, "V")
    law = pd_plus(
        values["position_gain_volt_count"] * scale,
        values["derivative_gain_volt_s_rad"] * radian,
        forward,
        forward * tau,
        period,
    )
    return plant, law


def _pi_p(values: Values, period: float) -> tuple[Plant, Controller]:
    return plants.motor(values["velocity_pole_1_s"]), pi_p_feedforward(
        values["velocity_gain_1_s"],
        values["integral_rate_1_s"],
        values["position_gain_1_s"],
        values["feedforward_gain"],
        values["feedforward_filter_rad_s"],
    )


def _two_mass(values: Values, period: float) -> tuple[Plant, Controller]:
    plant = plants.two_mass(
        values["motor_inertia_kg_m2"],
        values["load_inertia_kg_m2"],
        values["stiffness_n_m_rad"],
        values["damping_n_m_s_rad"],
        values["motor_viscous_n_m_s_rad"],
        values["load_viscous_n_m_s_rad"],
        values["travel_mm_rad"],
        values["feedback"] == "load",
    )
    law = pid(
        values["position_gain_n_m_mm"],
        values["integral_gain_n_m_mm_s"],
        values["derivative_gain_n_m_s_mm"],
        period,
        values["derivative_filter_rad_s"],
    )
    return plant, law


def _plant(values: Values, period: float) -> tuple[Plant, Controller]:
    above, below = np.array(values["numerator"], float), np.array(values["denominator"], float)
    if values["sample_time_s"] is None:
        plant = plants.transfer_function(above, below, values["delay_s"])
    else:
        plant = plants.sampled_transfer_function(above, below, values["sample_time_s"], values["delay_s"])
    return plant, _CONTROLLERS[values["controller"]](values, period)


def _pid(values: Values, period: float) -> Controller:
    return pid(
        values["position_gain_1_mm"],
        values["integral_gain_1_mm_s"],
        values["derivative_gain_s_mm"],
        period,
        values["derivative_filter_rad_s"],
    )


def _ratio(values: Values, period: float) -> Controller:
    above = np.array(values["controller_numerator"], float)
    return sampled(*plants.companion(above, np.array(values["controller_denominator"], float)), period)


def _h_infinity(values: Values, period: float) -> Controller:
    from cncgen.servo.controllers.hinf_servo import controller_of

    return controller_of(values, period)


_CONTROLLERS: Mapping[str, Callable[[Values, float], Controller]] = {
    "pid": _pid,
    "ratio": _ratio,
    "h-infinity": _h_infinity,
}


def _given_loop(values: Values, period: float) -> AxisLoop:
    return follow_transfer_function(
        values["numerator"],
        values["denominator"],
        period,
        values["delay_s"],
        values["sample_time_s"] is not None,
        Imperfections(backlash=values["backlash_mm"]),
    )


_PARTS: Mapping[str, Callable[[Values, float], tuple[Plant, Controller]]] = {
    "first-order": _first_order,
    "pd-plus": _pd_plus,
    "pi-p-feedforward": _pi_p,
    "two-mass": _two_mass,
    "plant": _plant,
}
#: Viscous friction in drive input a mm/s, beside what the plant has.
_VISCOUS: Mapping[str, Callable[[Values], float]] = {
    "first-order": lambda v: v["viscous_share"] if v["time_constant_s"] > 0.0 else 0.0,
    "pd-plus": lambda v: v["viscous_volt_s_rad"] * v["counts_per_mm"] / v["counts_per_rad"],
    "pi-p-feedforward": lambda v: v["viscous_1_s"],
    "two-mass": lambda v: 0.0,
    "plant": lambda v: v["viscous_s_mm"],
}
#: Coulomb friction and bound of the drive, in its own unit.
_COULOMB_AND_BOUND: Mapping[str, Callable[[Values], tuple[float, float | None]]] = {
    "first-order": lambda v: (v["coulomb_lag_mm"] * v["position_gain_1_s"], v["saturation_mm_s"]),
    "pd-plus": lambda v: (v["coulomb_volt"], v["saturation_volt"]),
    "pi-p-feedforward": lambda v: (v["coulomb_mm_s2"], v["saturation_mm_s2"]),
    "two-mass": lambda v: (v["coulomb_n_m"], v["saturation_n_m"]),
    "plant": lambda v: (v["coulomb"], v["saturation"]),
}
