"""The parameters of each servo model: names, units, ranges; the keys of ``[axes.*.servo]`` in machine files.

A model is a drive with its controller. Keys carry their unit; ``{l}`` in a name stands for the axis's own length unit
(``mm``, or ``deg`` for a rotary axis). `cncgen.machine.servo_schema` checks tables and reads their values.

Models and their sources (the papers' symbols in brackets):

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
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from cncgen.arguments import is_number
from cncgen.units import file_unit

#: Highest degree of a transfer function's denominator.
MAX_DEGREE = 11
#: Numbers other than 0 are between the first and the second: no drive has others, and what is computed of these (powers
#: of gains, quotients) stays within doubles. Coefficients of polynomials are powers themselves.
MAGNITUDES = (1e-15, 1e15)
COEFFICIENTS = (1e-90, 1e90)


@dataclass(frozen=True, slots=True)
class Parameter:
    """One key of a servo table.

    Attributes:
        name: Key, with ``{l}`` for the length unit of the axis.
        about: Its meaning, with the paper's symbol.
        default: Value where the file says nothing; None: it has no effect (an optional limit, say).
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
        """Return the fault of a value, or ""."""
        if self.kind == "word":
            return "" if value in self.choices else f"must be one of {', '.join(self.choices)}; is {value!r}"
        if self.kind == "text":
            return "" if isinstance(value, str) and value.strip() else f"must be a text; is {value!r}"
        if self.kind == "flag":
            return "" if isinstance(value, bool) else f"must be true or false; is {value!r}"
        if self.kind == "numbers":
            return self._fault_of_list(value)
        if not is_number(value) or (self.kind == "integer" and value != int(value)):
            return f"must be {'an integer' if self.kind == 'integer' else 'a finite number'}; is {value!r}"
        if value < self.low or value > self.high or (self.open_low and value == self.low):
            return f"must be {self._range()}; is {value!r}"
        return _fault_of_magnitude(value, MAGNITUDES)

    def _range(self) -> str:
        sign = ">" if self.open_low else ">="
        upper = f" and <= {self.high:g}" if math.isfinite(self.high) else ""
        return f"{sign} {self.low:g}{upper}"

    @property
    def wanted(self) -> str:
        """Return the allowed values in words."""
        kinds = {
            "word": f"one of {', '.join(self.choices)}",
            "text": "a text",
            "flag": "true or false",
            "numbers": "a list of numbers, not all 0",
        }
        if self.kind in kinds:
            return kinds[self.kind]
        kind = "an integer" if self.kind == "integer" else "a number"
        return f"{kind} {self._range()}" if math.isfinite(self.low) else kind

    @staticmethod
    def _fault_of_list(value: Any) -> str:
        if not isinstance(value, (list, tuple)) or not value or not all(is_number(v) for v in value):
            return f"must be a list of finite numbers; is {value!r}"
        if not any(v != 0 for v in value):
            return "must not be all zero"
        return next(filter(None, (_fault_of_magnitude(v, COEFFICIENTS) for v in value)), "")


def _fault_of_magnitude(value: float, bounds: tuple[float, float]) -> str:
    """Return the fault of a number's size, or ""."""
    low, high = bounds
    if value == 0 or low <= abs(value) <= high:
        return ""
    return f"must be 0 or between {low:g} and {high:g} in size; is {value:g}"


def _positive(name: str, about: str, power: int = 0, **more: Any) -> Parameter:
    return Parameter(name, about, required=True, open_low=True, power=power, **more)


def _optional(name: str, about: str, power: int = 0, **more: Any) -> Parameter:
    return Parameter(name, about, open_low=True, power=power, **more)


#: Keys that every model with a plant may have besides.
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
        "viscous friction: the share of the speed that it takes off the velocity command",
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
