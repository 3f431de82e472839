"""Gains for a stated bandwidth and damping.

Placement follows from the closed loops: P round 1/(s(τs + 1)) is τs² + s + Kv, so Kv = 1/(4ζ²τ); PD round the torque-mode
motor is τs² + (1 + Kd Kc)s + Kp Kc Ke, so Kp = ωn²τ/(Kc Ke) and Kd = (2ζωnτ − 1)/Kc (Yeh and Sun 2008, after eq. 2.5); two
masses are taken for one rigid one of inertia J; the cascade of Tsai 2010 (section 4.1) has a velocity loop of stated bandwidth and damping inside a position loop of stated
bandwidth. Cross coupling is placed by its contour loop W G: the bandwidth is where |W G| = 1, and the damping stands for
the phase margin that a second-order loop of that damping has. The task frame's gains are Kp = ω², Kd = 2ζω.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine import servo_schema
from cncgen.machine.record import Servo
from cncgen.servo.controllers.ccc import MODULUS, contour_loop, keeps, own_gain
from cncgen.servo.controllers.hinf_servo import BoundCheck, check, controller_of, norm_of
from cncgen.servo.loop import AxisLoop
from cncgen.servo.models import control_period
from cncgen.servo.named_schemes import Settings, h_infinity_servos
from cncgen.servo.tuning.analysis import axis_open_loop
from cncgen.units import DEGREE, is_rotary

Floats = NDArray[np.float64]

#: Bandwidth of the velocity loop as a multiple of the position loop's (Tsai 2010: 80 and 40 Hz).
VELOCITY_RATIO = 2.0

#: Beyond these no axis goes, and numbers overflow.
MAX_BANDWIDTH_HZ, MAX_DAMPING = 1e6, 1e3


def placed(servo: Servo, letter: str, bandwidth_hz: float, damping: float) -> Servo:
    """Return a servo with gains for a bandwidth (Hz) and damping; all other entries stay.

    Of ``first-order`` the damping decides where the lag allows less than the bandwidth. ``pd-plus``, ``two-mass`` and
    ``plant`` (PD round g/(s(τs + 1))) take the bandwidth as their natural frequency.

    Raises:
        UsageError: The model has no gains to place, or the asked values cannot be had (``tune-place``).
    """
    values = servo_schema.resolve(servo, letter)
    if servo.model not in _PLACED:
        raise UsageError(
            Diagnostic(
                "tune-place",
                f"axis {letter}: gains of the model {servo.model} are not placed",
                hint=f"placed are those of {', '.join(_PLACED)}",
            )
        )
    if not (0.0 < bandwidth_hz <= MAX_BANDWIDTH_HZ and 0.0 < damping <= MAX_DAMPING):
        message = (
            f"bandwidth and damping must be positive, and at most {MAX_BANDWIDTH_HZ:g} Hz and {MAX_DAMPING:g}"
        )
        raise UsageError(Diagnostic("tune-place", message))
    try:
        found = _PLACED[servo.model](values, 2.0 * math.pi * bandwidth_hz, damping)
    except ArithmeticError as error:
        message = f"axis {letter}: {bandwidth_hz:g} Hz at damping {damping:g} needs gains beyond the range of numbers"
        raise UsageError(Diagnostic("tune-place", message)) from error
    if any(value < 0.0 for value in found.values()):
        text = ", ".join(f"{k} = {v:.4g}" for k, v in found.items())
        raise UsageError(
            Diagnostic("tune-place", f"axis {letter}: {bandwidth_hz:g} Hz at damping {damping:g} needs {text}",
                       hint="the drive alone is faster or better damped than that; ask for more bandwidth")
        )  # fmt: skip
    if is_rotary(letter):
        found = {k.replace("_mm", "_deg"): v * DEGREE if k.endswith("_mm") else v for k, v in found.items()}
    chosen = {"controller": "pid"} if servo.model == "plant" else {}
    return Servo(servo.model, {**servo.parameters, **found, **chosen})


def check_stable(servo: Servo, letter: str, period_s: float, bandwidth_hz: float) -> None:
    """Raise UsageError (``tune-place``) where placed gains, meant for continuous time, are unstable as they are sampled."""
    loop = axis_open_loop(servo, letter, period_s)
    if not loop.stable:
        raise UsageError(
            Diagnostic(
                "tune-place",
                f"axis {letter}: gains for {bandwidth_hz:g} Hz are unstable at a control period of {loop.period:g} s"
                f" (a pole at |z| = {loop.largest_pole:.3f})",
                hint="ask for less bandwidth, or shorten control_period_s; an integral gain stays as it is given",
            )
        )


def _place_first_order(p: Mapping[str, Any], omega: float, damping: float) -> dict[str, float]:
    lag = p["time_constant_s"]
    by_damping = 1.0 / (4.0 * damping**2 * lag) if lag > 0.0 else math.inf
    # |G| = 1/√2 of Kv/(τs² + s + Kv): Kv⁴… solved for Kv at ω: (Kv − τω²)² + ω² = 2 Kv².
    by_bandwidth = -lag * omega**2 + math.sqrt(2.0 * (lag * omega**2) ** 2 + omega**2)
    return {"position_gain_1_s": min(by_damping, by_bandwidth)}


def _place_pd_plus(p: Mapping[str, Any], omega: float, damping: float) -> dict[str, float]:
    tau, kc, ke = p["time_constant_s"], p["velocity_gain_rad_s_volt"], p["counts_per_rad"]
    return {
        "position_gain_volt_count": omega**2 * tau / (kc * ke),
        "derivative_gain_volt_s_rad": (2.0 * damping * omega * tau - 1.0) / kc,
    }


def _place_cascade(p: Mapping[str, Any], omega: float, damping: float) -> dict[str, float]:
    pole = p["velocity_pole_1_s"]
    velocity = VELOCITY_RATIO * omega

    def inner(natural: float) -> float:
        """|velocity loop| at its bandwidth: (g s + g/Ti)/(s² + (a + g) s + g/Ti)."""
        g, stiff = 2.0 * damping * natural - pole, natural**2
        s = 1j * velocity
        return abs((g * s + stiff) / (s**2 + (pole + g) * s + stiff))

    natural = _root(lambda w: inner(w) - math.sqrt(0.5), 1e-3 * velocity, velocity)
    gain = 2.0 * damping * natural - pole
    rate = natural**2 / gain if gain else 0.0

    def outer(position: float) -> float:
        changed = {**p, "velocity_gain_1_s": gain, "integral_rate_1_s": rate, "position_gain_1_s": position,
                   "feedforward_gain": 0.0}  # fmt: skip
        loop = servo_schema.closed_loop(Servo("pi-p-feedforward", changed))
        return float(abs(np.polyval(loop.numerator, 1j * omega) / np.polyval(loop.denominator, 1j * omega)))

    position = _root(lambda k: outer(k) - math.sqrt(0.5), 1e-4 * omega, omega)
    return {"velocity_gain_1_s": gain, "integral_rate_1_s": rate, "position_gain_1_s": position}


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the first sign change of a function from below zero, by steps and bisection."""
    grid = np.geomspace(low, high, 200)
    values = [function(float(x)) for x in grid]
    for a, b, fa, fb in zip(grid, grid[1:], values, values[1:], strict=False):
        if fa < 0.0 <= fb:
            low, high = float(a), float(b)
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if function(middle) < 0.0 else (low, middle)
            return high
    raise UsageError(Diagnostic("tune-place", "no gain gives that bandwidth"))


def _place_plant(p: Mapping[str, Any], omega: float, damping: float) -> dict[str, float]:
    """PD round g/(s(τs + 1)): τs² + (1 + Kd g)s + Kp g."""
    above, below = np.trim_zeros(np.array(p["numerator"], float), "f"), np.array(p["denominator"], float)
    if p["sample_time_s"] is not None or len(above) != 1 or len(below) != 3 or below[2] != 0.0:
        raise UsageError(
            Diagnostic("tune-place", "PD gains are placed for plants g/(s(τs + 1)) alone",
                       hint="for a plant that stands by itself design one: --controller h-infinity")
        )  # fmt: skip
    gain, drag = float(above[0]), float(below[1]) + p["viscous_s_mm"] * float(above[0])
    return {
        "position_gain_1_mm": omega**2 * float(below[0]) / gain,
        "derivative_gain_s_mm": (2.0 * damping * omega * float(below[0]) - drag) / gain,
    }


def _place_two_mass(p: Mapping[str, Any], omega: float, damping: float) -> dict[str, float]:
    """PD round both masses as one, Js² + (f + Kd r)s + Kp r with r the travel a radian; the spring is left to the margins."""
    inertia = p["motor_inertia_kg_m2"] + p["load_inertia_kg_m2"]
    viscous = p["motor_viscous_n_m_s_rad"] + p["load_viscous_n_m_s_rad"]
    travel = p["travel_mm_rad"]
    return {
        "position_gain_n_m_mm": omega**2 * inertia / travel,
        "derivative_gain_n_m_s_mm": (2.0 * damping * omega * inertia - viscous) / travel,
    }


_PLACED = {
    "plant": _place_plant,
    "two-mass": _place_two_mass,
    "first-order": _place_first_order,
    "pd-plus": _place_pd_plus,
    "pi-p-feedforward": _place_cascade,
}


def placed_settings(
    controller: str, loops: Sequence[AxisLoop], bandwidth_hz: float, damping: float
) -> Settings:
    """Return the gains of a scheme that couples axes, for a bandwidth (Hz) and damping.

    Args:
        controller: ``ccc``, ``zpetc+ccc`` or ``tcf``.
        loops: The closed axes (of ``tcf`` their number and period do not matter).
        bandwidth_hz: Of ``ccc`` the crossover of the contour loop; of ``tcf`` the natural frequency of both errors.
        damping: Of both; of ``ccc`` it is the least phase margin, and more is left where the integral could not use it.

    Raises:
        UsageError: The axes' phase does not allow it (``tune-place``).
    """
    omega = 2.0 * math.pi * bandwidth_hz
    if controller == "tcf":
        return Settings(
            tcf_tangential_rad_s=omega,
            tcf_tangential_damping=damping,
            tcf_normal_rad_s=omega,
            tcf_normal_damping=damping,
        )
    return _place_cross_coupling(loops, omega, damping)


def phase_margin(damping: float) -> float:
    """Return the phase margin, rad, of ωn²/(s(s + 2ζωn)): atan(2ζ/√(√(1 + 4ζ⁴) − 2ζ²)) (Ogata, section 7-7)."""
    root = math.sqrt(math.sqrt(1.0 + 4.0 * damping**4) - 2.0 * damping**2)
    return math.atan2(2.0 * damping, root)


def _place_cross_coupling(loops: Sequence[AxisLoop], omega: float, damping: float) -> Settings:
    hertz = omega / (2.0 * math.pi)
    if omega >= math.pi / max(loop.period for loop in loops):
        raise UsageError(Diagnostic("tune-place", f"{hertz:g} Hz is beyond half the control frequency"))
    at = np.array([omega])
    values = np.array([contour_loop(loop, 1.0, 0.0, at)[0] for loop in loops])
    wanted, left = phase_margin(damping), math.pi + float(_lag(loops, omega).min())
    if left <= wanted:
        raise UsageError(
            Diagnostic(
                "tune-place",
                f"cross coupling at {hertz:g} Hz: the axes leave {math.degrees(left):.1f}° of phase there, and damping"
                f" {damping:g} needs {math.degrees(wanted):.1f}°",
                hint="ask for less bandwidth or damping",
            )
        )
    # P + I T z/(z − 1) lags by the rest; its size at the crossover, on the stronger axis, is 1/|G|.
    period = loops[0].period
    ratio = _integral_share(left - wanted, omega, period)
    z = np.exp(1j * omega * period)
    weight = abs(1.0 + ratio * period * z / (z - 1.0))
    proportional = 1.0 / float(np.abs(values).max()) / weight
    own = own_gain(loops)
    if not keeps(loops, proportional, proportional * ratio, 0.5 * MODULUS):
        raise UsageError(
            Diagnostic(
                "tune-place",
                f"cross coupling at {hertz:g} Hz and damping {damping:g}: the contour loop comes too near to −1",
                hint="ask for less bandwidth or more damping",
            )
        )
    return Settings(
        ccc_proportional=float(proportional / own), ccc_integral_1_s=float(proportional * ratio / own)
    )


def _lag(loops: Sequence[AxisLoop], omega: float) -> Floats:
    """Return the phase of each closed axis from drive to position at a frequency, followed up from low ones."""
    grid = np.geomspace(1e-2 * omega, omega, 200)
    return np.array([np.unwrap(np.angle(contour_loop(loop, 1.0, 0.0, grid)))[-1] for loop in loops])


def _integral_share(lag: float, omega: float, period: float) -> float:
    """Return I/P (1/s) such that 1 + (I/P) T z/(z − 1) lags by `lag` (below 90°) at ω; at most ω."""
    low, high = 0.0, omega
    z = np.exp(1j * omega * period)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if -np.angle(1.0 + middle * period * z / (z - 1.0)) < lag:
            low = middle
        else:
            high = middle
    return low


#: Crossover of the H-infinity design's uncertainty as a multiple of its bandwidth, at least.
ROBUSTNESS_RATIO = 2.0


def designed_h_infinity(
    servo: Servo, letter: str, period_s: float, bandwidth_hz: float | None = None
) -> tuple[Servo, float, BoundCheck]:
    """Return a servo (model ``plant``) under its H-infinity controller, the norm reached, and its bounds.

    Args:
        servo: The servo.
        letter: Its axis.
        period_s: Of the setpoints.
        bandwidth_hz: Below it |S| is to be small; None: as the table says.

    Raises:
        UsageError: The model is another one, or no controller exists (``tune-place``).
    """
    changed = dict(servo.parameters)
    if bandwidth_hz is not None:
        omega = 2.0 * math.pi * bandwidth_hz
        changed["sensitivity_bandwidth_rad_s"] = omega
        changed["robustness_crossover_rad_s"] = max(
            ROBUSTNESS_RATIO * omega, float(changed.get("robustness_crossover_rad_s", 0.0))
        )
    try:
        made = h_infinity_servos({letter: Servo(servo.model, changed)})[letter]
        values = servo_schema.resolve(made, letter)
        period = control_period(made, letter, period_s)
        found = check(values, controller_of(values, period), period)
        return made, norm_of(values), found
    except ValueError as error:
        raise UsageError(Diagnostic("tune-place", f"H-infinity: {error}")) from error
