"""The parameters of each servo model: names, units, ranges; what a machine file may say under ``[axes.*.servo]``.

A model is a drive with its controller. Keys carry their unit; ``{l}`` in a name stands for the axis's own length
unit (``mm``, or ``deg`` for a rotary axis). `faults` names every fault of a table, `resolve` gives the
values in inside units (mm, rad, s) with the defaults filled in, and `closed_loop` the transfer function from
setpoint to position, which a planner predicts errors with.

Models and where they come from (the papers' symbols in brackets):

* ``pi-p-feedforward``: Tsai 2010, Fig. 2 and appendix A-1: plant b/(s(s + a)), PI velocity loop Kvp(1 + 1/(Ti s)),
  P position loop Kpp, velocity feedforward Kvff wn s/(s + wn).
* ``pd-plus``: Yeh and Sun 2008, eqs 2.1, 2.2, 2.12 and 3.3: torque-mode motor, PD control with feedforward.
* ``first-order``: Hsu 1999 (as fitted): P position loop round a first-order velocity loop with an integrator.
* ``two-mass``: motor and load joined by a spring, under PID control.
* ``plant``: any plant as a ratio of polynomials in s or z, with dead time, under PID control, a controller given as a
  ratio, or one designed by H-infinity mixed sensitivity (the flexible stage appended to Tsai 2010).
* ``transfer-function``: the closed loop as a whole as a ratio of polynomials, in s or in z, with a delay.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.record import Servo
from cncgen.units import DEGREE, file_unit, is_rotary

Floats = NDArray[np.float64]

#: Highest degree of a transfer function's denominator.
MAX_DEGREE = 11


@dataclass(frozen=True, slots=True)
class Parameter:
    """One key of a servo table.

    Attributes:
        name: Key, with ``{l}`` for the length unit of the axis.
        about: What it is, with the paper's symbol.
        default: Value where the file says nothing; None: there is no effect of it (an optional limit, say).
        required: True where the file must say it.
        low, high: Range; `open_low` leaves `low` itself out.
        power: Power of the length unit in the value's unit (1 for mm, −1 for counts/mm, 0 for none).
        choices: The words allowed, where the value is a word.
        kind: ``number``, ``integer``, ``word``, ``text``, ``flag`` or ``numbers`` (a list).
    """

    name: str
    about: str
    default: Any = None
    required: bool = False
    low: float = 0.0
    high: float = math.inf
    open_low: bool = False
    power: int = 0
    choices: tuple[str, ...] = ()
    kind: str = "number"

    def key(self, letter: str) -> str:
        """Return the key as a file of that axis writes it."""
        return self.name.format(l=file_unit(letter))

    @property
    def symbol(self) -> str:
        """Return the name under which `resolve` gives the value: the key of a linear axis."""
        return self.name.format(l="mm")

    def fault(self, value: Any) -> str:
        """Return what is wrong with a value, or ""."""
        if self.kind == "word":
            return "" if value in self.choices else f"must be one of {', '.join(self.choices)}; is {value!r}"
        if self.kind == "text":
            return "" if isinstance(value, str) and value.strip() else f"must be a text; is {value!r}"
        if self.kind == "flag":
            return "" if isinstance(value, bool) else f"must be true or false; is {value!r}"
        if self.kind == "numbers":
            return self._fault_of_list(value)
        if not _is_number(value) or (self.kind == "integer" and value != int(value)):
            return f"must be {'an integer' if self.kind == 'integer' else 'a finite number'}; is {value!r}"
        if value < self.low or value > self.high or (self.open_low and value == self.low):
            sign = ">" if self.open_low else ">="
            upper = f" and <= {self.high:g}" if math.isfinite(self.high) else ""
            return f"must be {sign} {self.low:g}{upper}; is {value!r}"
        return ""

    @staticmethod
    def _fault_of_list(value: Any) -> str:
        if not isinstance(value, (list, tuple)) or not value or not all(_is_number(v) for v in value):
            return f"must be a list of finite numbers; is {value!r}"
        return "" if any(v != 0 for v in value) else "must not be all zero"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _positive(name: str, about: str, power: int = 0, **more: Any) -> Parameter:
    return Parameter(name, about, required=True, open_low=True, power=power, **more)


def _optional(name: str, about: str, power: int = 0, **more: Any) -> Parameter:
    return Parameter(name, about, open_low=True, power=power, **more)


#: What every model with a plant may have beside.
_IMPERFECTIONS = (
    _optional("control_period_s", "period of the control loop; the setpoints' own where it is missing"),
    Parameter("backlash_{l}", "play between motor and load", 0.0, power=1),
    Parameter("encoder_resolution_{l}", "step of the measured position; 0: no quantisation", 0.0, power=1),
    Parameter("noise_rms_{l}", "standard deviation of the measurement noise", 0.0, power=1),
    Parameter("noise_seed", "seed of the noise", 0, kind="integer"),
    Parameter("feedback", "side of the backlash (or spring) the encoder is on", "motor", kind="word",
              choices=("motor", "load")),
)  # fmt: skip

_PI_P_FEEDFORWARD = (
    Parameter("velocity_pole_1_s", "a of the plant b/(s(s + a))", required=True),
    _positive("velocity_gain_1_s", "b Kvp: gain of the velocity loop"),
    Parameter("integral_rate_1_s", "1/Ti of the velocity loop", required=True),
    _positive("position_gain_1_s", "Kpp"),
    Parameter("feedforward_gain", "Kvff", required=True, high=10.0),
    _positive("feedforward_filter_rad_s", "wn: the low-pass on the feedforward"),
    _optional("saturation_{l}_s2", "largest acceleration that the drive gives (b times its voltage)", 1),
    Parameter("coulomb_{l}_s2", "Coulomb friction, as acceleration", 0.0, power=1),
    Parameter(
        "viscous_1_s",
        "viscous friction, as acceleration a unit of speed; the controller knows only of a",
        0.0,
    ),
    *_IMPERFECTIONS,
)

_PD_PLUS = (
    _positive("time_constant_s", "tau of the motor"),
    _positive("velocity_gain_rad_s_volt", "Kc: speed of the motor per volt"),
    _positive("counts_per_rad", "Ke: encoder counts a radian of the motor"),
    _positive("counts_per_{l}", "encoder counts a unit of travel", -1),
    _positive("position_gain_volt_count", "Kp"),
    _positive("derivative_gain_volt_s_rad", "Kd"),
    Parameter("feedforward", "the + of PD+: false leaves plain PD", True, kind="flag"),
    _optional("saturation_volt", "bound of the drive's input"),
    Parameter("coulomb_volt", "Coulomb friction, as input", 0.0),
    Parameter(
        "viscous_volt_s_rad",
        "viscous friction, as input a unit of motor speed; unknown to the controller",
        0.0,
    ),
    *_IMPERFECTIONS,
)

_FIRST_ORDER = (
    _positive("position_gain_1_s", "Kv: velocity per position error"),
    Parameter("time_constant_s", "lag of the velocity loop; 0: a pure integrator", 0.0),
    Parameter("coulomb_lag_{l}", "position error that Coulomb friction costs", 0.0, power=1),
    Parameter(
        "viscous_share",
        "viscous friction: what it takes off the velocity command, as a share of the speed",
        0.0,
    ),
    _optional("saturation_{l}_s", "bound of the velocity command", 1),
    *_IMPERFECTIONS,
)

_TWO_MASS = (
    _positive("motor_inertia_kg_m2", "J1"),
    _positive("load_inertia_kg_m2", "J2, at the motor shaft"),
    _positive("stiffness_n_m_rad", "k of the coupling"),
    Parameter("damping_n_m_s_rad", "c of the coupling", 0.0),
    Parameter("motor_viscous_n_m_s_rad", "viscous friction of the motor", 0.0),
    Parameter("load_viscous_n_m_s_rad", "viscous friction of the load", 0.0),
    _positive("travel_{l}_rad", "travel of the axis a radian of the motor", 1),
    _positive("position_gain_n_m_{l}", "Kp of the PID controller", -1),
    Parameter("integral_gain_n_m_{l}_s", "Ki", 0.0, power=-1),
    Parameter("derivative_gain_n_m_s_{l}", "Kd", 0.0, power=-1),
    _optional("derivative_filter_rad_s", "low-pass on the derivative"),
    _optional("saturation_n_m", "largest torque"),
    Parameter("coulomb_n_m", "Coulomb friction at the motor", 0.0),
    *_IMPERFECTIONS,
)

_PLANT = (
    Parameter("numerator", "of the plant, {l} per unit of drive input, highest power first", required=True, kind="numbers",
              power=1),
    Parameter("denominator", "of the plant, highest power first", required=True, kind="numbers"),
    _optional("sample_time_s", "given: the plant is in z, its input held for this period; missing: it is in s"),
    Parameter("delay_s", "dead time of the input", 0.0, high=1.0),
    Parameter("drive_unit", "unit of the drive input", "V", kind="text"),
    Parameter("controller", "which of the following is on", "pid", kind="word", choices=("pid", "ratio", "h-infinity")),
    Parameter("position_gain_1_{l}", "pid: Kp", 0.0, power=-1),
    Parameter("integral_gain_1_{l}_s", "pid: Ki", 0.0, power=-1),
    Parameter("derivative_gain_s_{l}", "pid: Kd", 0.0, power=-1),
    _optional("derivative_filter_rad_s", "pid: low-pass on the derivative"),
    Parameter("controller_numerator", "ratio: in s, drive input per {l} of error", kind="numbers", power=-1),
    Parameter("controller_denominator", "ratio: in s", kind="numbers"),
    _optional("sensitivity_bandwidth_rad_s", "h-infinity: below it |S| is to be small"),
    Parameter("sensitivity_peak", "h-infinity: largest |S|", 2.0, low=1.0, open_low=True),
    Parameter("sensitivity_offset", "h-infinity: |S| at rest", 1e-3, open_low=True, high=0.5),
    _optional("robustness_crossover_rad_s", "h-infinity: where the plant is unknown by its own size"),
    Parameter("control_weight", "h-infinity: weight of the drive input, as a share of the plant's gain at rest", 0.05,
              open_low=True),
    _optional("roll_off_rad_s", "h-infinity: one more pole, the reshaping at high frequencies"),
    Parameter("frequency_uncertainty", "h-infinity: the bounds hold for natural frequencies within this share", 0.1,
              high=0.9),
    Parameter("gain_uncertainty", "h-infinity: the bounds hold for gains within this share", 0.1, high=0.9),
    Parameter("complementary_peak", "h-infinity: bound of |T|, M_L", 1.5, low=1.0),
    _optional("saturation", "largest drive input"),
    Parameter("coulomb", "Coulomb friction, as drive input", 0.0),
    Parameter("viscous_s_{l}", "viscous friction, as drive input a unit of speed", 0.0, power=-1),
    *_IMPERFECTIONS,
)  # fmt: skip

_TRANSFER_FUNCTION = (
    Parameter("numerator", "coefficients, highest power first", required=True, kind="numbers"),
    Parameter("denominator", "coefficients, highest power first", required=True, kind="numbers"),
    _optional("sample_time_s", "given: the polynomials are in z at this period; missing: they are in s"),
    Parameter("delay_s", "dead time", 0.0, high=1.0),
    Parameter("backlash_{l}", "play at the output", 0.0, power=1),
)


@dataclass(frozen=True, slots=True)
class Model:
    """A servo model: its keys, and the unit of its driving force (as a response file states it)."""

    parameters: tuple[Parameter, ...]
    force_unit: str


#: The models by the word that ``model = "…"`` takes.
MODELS: Mapping[str, Model] = MappingProxyType(
    {
        "pi-p-feedforward": Model(_PI_P_FEEDFORWARD, "{l}/s²"),
        "pd-plus": Model(_PD_PLUS, "V"),
        "first-order": Model(_FIRST_ORDER, "{l}/s"),
        "two-mass": Model(_TWO_MASS, "N·m"),
        "plant": Model(_PLANT, ""),
        "transfer-function": Model(_TRANSFER_FUNCTION, "{l}"),
    }
)


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
            yield "machine-key", key, f"is no key of the model {name}; {_nearest(key, known)}"
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
    if not all(isinstance(v, list) and any(v) and all(map(_is_number, v)) for v in polynomials):
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
    """Yield what the chosen controller of a ``plant`` lacks."""
    unit = file_unit(letter)
    choice = table.get("controller", "pid")
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
    ``pd-plus`` cancels its own dynamics, so the ratio is 1 in continuous time; what remains of its error comes from
    sampling. Raises ValueError for a transfer function in z, which has no unique form in s.
    """
    p = resolve(servo, letter)
    return _CLOSED_LOOPS[servo.model](p)


def _leading(coefficients: Floats) -> Floats:
    """Drop leading zeros: the degree is what stands."""
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
    """Return Kp + Ki/s + Kd s/(s/corner + 1) as a ratio; without `corner` the derivative has no low-pass."""
    lag = 1.0 / corner if corner else 0.0
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
