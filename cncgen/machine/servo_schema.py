"""Servo tables of a machine file: their faults, their values in internal units, and their closed loops.

`faults` names every fault of an ``[axes.*.servo]`` table, `resolve` gives the values in internal units (mm, rad, s) with the defaults
filled in, and `closed_loop` the transfer function from setpoint to position, with which a planner predicts errors. The keys of each
model stand in `cncgen.machine.servo_parameters`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cncgen.arguments import is_number
from cncgen.machine.record import Servo
from cncgen.machine.servo_parameters import MAX_DEGREE, MODELS, Parameter
from cncgen.units import DEGREE, file_unit, is_rotary

Floats = NDArray[np.float64]


def faults(table: Mapping[str, Any], letter: str) -> Iterator[tuple[str, str, str]]:
    """Yield every fault of a ``[axes.*.servo]`` table: diagnostic code, key and message.

    Args:
        table: The table as tomllib gives it, with its ``model``.
        letter: Letter of the axis; a rotary one has ``deg`` in its keys.
    """
    name = table.get("model")
    model = MODELS.get(name) if isinstance(name, str) else None
    if model is None:
        yield "machine-value", "model", f"must be one of {', '.join(MODELS)}; is {name!r}"
        return
    known = {p.key(letter): p for p in model.parameters}
    for key in table:
        if key != "model" and key not in known:
            yield "machine-key", key, f"is not a key of the model {name}; {_nearest(key, known)}"
    for key, parameter in known.items():
        if key not in table:
            if parameter.required:
                yield "machine-missing", key, f"missing ({parameter.about})"
            continue
        said = parameter.fault(table[key])
        if said:
            yield "machine-value", key, said
    if name == "transfer-function":
        yield from _faults_of_degrees(table)
    if name == "plant":
        yield from _faults_of_degrees(table, strictly=True)
        yield from _faults_of_degrees(table, prefix="controller_")
        yield from _faults_of_controller(table, letter)


def _faults_of_degrees(
    table: Mapping[str, Any], prefix: str = "", strictly: bool = False
) -> Iterator[tuple[str, str, str]]:
    polynomials = [table.get(f"{prefix}numerator"), table.get(f"{prefix}denominator")]
    if not all(isinstance(v, list) and any(v) and all(map(is_number, v)) for v in polynomials):
        return
    degrees = [len(_leading(np.asarray(v, float))) - 1 for v in polynomials]
    if degrees[0] > degrees[1]:
        message = f"has degree {degrees[0]}, above the denominator's {degrees[1]}"
        yield "machine-value", f"{prefix}numerator", message
    elif strictly and degrees[0] == degrees[1]:
        yield (
            "machine-value",
            f"{prefix}numerator",
            f"has the denominator's degree {degrees[1]}; a plant has a lower one",
        )
    if degrees[1] > MAX_DEGREE:
        yield "machine-value", f"{prefix}denominator", f"has degree {degrees[1]}; {MAX_DEGREE} is the most"


def _faults_of_controller(table: Mapping[str, Any], letter: str) -> Iterator[tuple[str, str, str]]:
    """Yield the missing keys of the chosen controller of a ``plant``."""
    unit = file_unit(letter)
    choice = str(table.get("controller", "pid"))
    needed = {
        "ratio": ("controller_numerator", "controller_denominator"),
        "h-infinity": ("sensitivity_bandwidth_rad_s", "robustness_crossover_rad_s"),
    }.get(choice, ())
    for key in needed:
        if key not in table:
            yield "machine-missing", key, f"missing (the controller is {choice})"
    gains = [f"position_gain_1_{unit}", f"integral_gain_1_{unit}_s"]
    if choice == "pid" and not any(table.get(key) for key in gains):
        yield "machine-missing", gains[0], f"missing (PID needs it or {gains[1]})"
    if table.get("sample_time_s") is not None:
        if choice == "h-infinity":
            yield (
                "machine-value",
                "controller",
                "h-infinity is designed on a plant in s, and sample_time_s says z",
            )
        if table.get("control_period_s", table["sample_time_s"]) != table["sample_time_s"]:
            yield "machine-value", "control_period_s", "must be the sample_time_s of a plant in z"


def _nearest(key: str, known: Mapping[str, Parameter]) -> str:
    import difflib

    near = difflib.get_close_matches(key, list(known), n=1)
    return f"did you mean {near[0]}?" if near else f"known keys: {', '.join(known)}"


def resolve(servo: Servo, letter: str) -> dict[str, Any]:
    """Return every parameter of a model in inside units (mm, rad, s) by the key of a linear axis.

    Values that the file leaves out have their defaults. For a rotary axis ``deg`` becomes rad and the names still
    say ``mm``: code that computes with them need not know which kind of axis it is.
    """
    values: dict[str, Any] = {}
    for parameter in MODELS[servo.model].parameters:
        value = servo.parameters.get(parameter.key(letter), parameter.default)
        if value is not None and parameter.kind in ("number", "numbers"):  # TOML's integers may have any size
            value = [float(v) for v in value] if parameter.kind == "numbers" else float(value)
        if value is not None and parameter.power and is_rotary(letter):
            factor = DEGREE**parameter.power
            value = [v * factor for v in value] if parameter.kind == "numbers" else value * factor
        values[parameter.symbol] = value
    return values


def force_unit(servo: Servo, letter: str) -> str:
    """Return the unit of a model's driving force: ``V``, ``N·m``, ``mm/s`` …; inside units (rad for rotary axes)."""
    if servo.model == "plant":
        return str(resolve(servo, letter)["drive_unit"])
    return MODELS[servo.model].force_unit.format(l="rad" if is_rotary(letter) else "mm")


class TransferFunction(NamedTuple):
    """A ratio of polynomials in s: coefficients with the highest power first, and a dead time."""

    numerator: Floats
    denominator: Floats
    delay_s: float = 0.0


def closed_loop(servo: Servo, letter: str = "X") -> TransferFunction:
    """Return the closed loop from setpoint to position, linear and in continuous time.

    ``pi-p-feedforward`` gives Tsai 2010, eq. 9 with appendix A-1 (denominator normed to s⁴):
    a3 = a + bKvp + wn, a2 = a wn + bKvp(1/Ti + Kpp + wn), a1 = bKvp(Kpp/Ti + Kpp wn + wn/Ti),
    a0 = b0 = bKvp Kpp wn/Ti, b2 = bKvp(wn Kvff + Kpp), b1 = bKvp(Kpp wn + (wn Kvff + Kpp)/Ti).
    ``pd-plus`` cancels its own dynamics, so the ratio is 1 in continuous time; the rest of its error comes from
    sampling. Raises ValueError for a transfer function in z, which has no unique form in s.
    """
    p = resolve(servo, letter)
    return _CLOSED_LOOPS[servo.model](p)


def _leading(coefficients: Floats) -> Floats:
    """Drop leading zeros: the rest has the degree."""
    return coefficients[np.flatnonzero(coefficients)[0] :]


def _pi_p_closed(p: Mapping[str, Any]) -> TransferFunction:
    a = p["velocity_pole_1_s"] + p["viscous_1_s"]
    g, i = p["velocity_gain_1_s"], p["integral_rate_1_s"]
    k, w = p["position_gain_1_s"], p["feedforward_filter_rad_s"]
    forward = w * p["feedforward_gain"] + k
    a0 = g * k * w * i
    denominator = [1.0, a + g + w, a * w + g * (i + k + w), g * (k * i + k * w + w * i), a0]
    return TransferFunction(np.array([g * forward, g * (k * w + forward * i), a0]), np.array(denominator))


def _pd_plus_closed(p: Mapping[str, Any]) -> TransferFunction:
    gain = p["velocity_gain_rad_s_volt"]
    proportional = p["position_gain_volt_count"] * gain * p["counts_per_rad"]
    derivative, drag = p["derivative_gain_volt_s_rad"] * gain, p["viscous_volt_s_rad"] * gain
    known = np.array([p["time_constant_s"], 1.0 + derivative, proportional])
    numerator = known if p["feedforward"] else np.array([derivative, proportional])
    return TransferFunction(numerator, np.add(known, [0.0, drag, 0.0]))


def _first_order_closed(p: Mapping[str, Any]) -> TransferFunction:
    gain, tau = p["position_gain_1_s"], p["time_constant_s"]
    denominator: list[float] = [tau, 1.0 + p["viscous_share"], gain]
    return TransferFunction(np.array([gain]), np.array(denominator if tau else denominator[1:]))


def two_mass_plant(p: Mapping[str, Any]) -> tuple[Floats, Floats, Floats]:
    """Return (motor numerator, load numerator, denominator) of a two-mass plant, torque (N·m) to position (mm).

    J1 φ1'' = u − c1 φ1' − k(φ1 − φ2) − c(φ1' − φ2'), J2 φ2'' = k(φ1 − φ2) + c(φ1' − φ2') − c2 φ2'.
    """
    spring: Floats = np.array([p["damping_n_m_s_rad"], p["stiffness_n_m_rad"]])
    motor = np.polyadd([p["motor_inertia_kg_m2"], p["motor_viscous_n_m_s_rad"], 0.0], spring)
    load = np.polyadd([p["load_inertia_kg_m2"], p["load_viscous_n_m_s_rad"], 0.0], spring)
    denominator: Floats = np.polysub(np.polymul(motor, load), np.polymul(spring, spring))
    travel = p["travel_mm_rad"]
    return travel * load, travel * spring, denominator


def _two_mass_closed(p: Mapping[str, Any]) -> TransferFunction:
    motor, load, plant_denominator = two_mass_plant(p)
    measured = motor if p["feedback"] == "motor" else load
    control, below = pid_ratio(
        p["position_gain_n_m_mm"],
        p["integral_gain_n_m_mm_s"],
        p["derivative_gain_n_m_s_mm"],
        p["derivative_filter_rad_s"],
    )
    denominator = np.polyadd(np.polymul(below, plant_denominator), np.polymul(control, measured))
    numerator = np.asarray(np.polymul(control, load), np.float64)
    return TransferFunction(numerator, _leading(np.asarray(denominator, np.float64)))


def _plant_closed(p: Mapping[str, Any]) -> TransferFunction:
    if p["sample_time_s"] is not None or p["delay_s"] > 0.0:
        raise ValueError("a plant in z or with a dead time has no closed loop as a ratio in s")
    if p["controller"] == "h-infinity":
        raise ValueError("the closed loop of an H-infinity controller is not given as a ratio")
    above = np.array(p["numerator"], float)
    below = np.polyadd(p["denominator"], np.polymul([p["viscous_s_mm"], 0.0], above))
    if p["controller"] == "ratio":
        control = np.array(p["controller_numerator"], float), np.array(p["controller_denominator"], float)
    else:
        control = pid_ratio(
            p["position_gain_1_mm"],
            p["integral_gain_1_mm_s"],
            p["derivative_gain_s_mm"],
            p["derivative_filter_rad_s"],
        )
    numerator = np.polymul(above, control[0])
    denominator = np.polyadd(np.polymul(below, control[1]), numerator)
    return TransferFunction(
        _leading(np.asarray(numerator, np.float64)), _leading(np.asarray(denominator, np.float64))
    )


def pid_ratio(
    proportional: float, integral: float, derivative: float, corner: float | None
) -> tuple[Floats, Floats]:
    """Return Kp + Ki/s + Kd s/(s/corner + 1) as a ratio in its lowest terms; without `corner` the derivative has no low-pass."""
    lag = 1.0 / corner if corner else 0.0
    if integral == 0.0:
        return np.array([proportional * lag + derivative, proportional]), np.array([lag, 1.0])
    control = np.array([proportional * lag + derivative, proportional + integral * lag, integral])
    return control, np.array([lag, 1.0, 0.0])


def _given(p: Mapping[str, Any]) -> TransferFunction:
    if p["sample_time_s"] is not None:
        raise ValueError("a transfer function in z has no unique form in s")
    return TransferFunction(np.array(p["numerator"], float), np.array(p["denominator"], float), p["delay_s"])


_CLOSED_LOOPS = {
    "pi-p-feedforward": _pi_p_closed,
    "pd-plus": _pd_plus_closed,
    "first-order": _first_order_closed,
    "two-mass": _two_mass_closed,
    "plant": _plant_closed,
    "transfer-function": _given,
}
