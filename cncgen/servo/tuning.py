"""Gains for a stated bandwidth and damping, or for the least contour error on a given motion within stability margins.

Placement follows from the closed loops: P round 1/(s(τs + 1)) is τs² + s + Kv, so Kv = 1/(4ζ²τ); PD round the torque-mode
motor is τs² + (1 + Kd Kc)s + Kp Kc Ke, so Kp = ωn²τ/(Kc Ke) and Kd = (2ζωnτ − 1)/Kc (Yeh and Sun 2008, after eq. 2.5); the
cascade of Tsai 2010 (section 4.1) has a velocity loop of stated bandwidth and damping inside a position loop of stated
bandwidth. Margins are those of the loop broken at the drive.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine import servo_schema
from cncgen.machine.record import Servo
from cncgen.servo.controllers.base import Controller
from cncgen.servo.frequency import Margins, margins, open_loop
from cncgen.servo.loop import close_loop
from cncgen.servo.models import control_period, plant_and_controller
from cncgen.servo.plants import Plant
from cncgen.servo.simulate import simulate
from cncgen.servo.summary import summarize
from cncgen.setpoints.record import Setpoints
from cncgen.units import is_rotary

Floats = NDArray[np.float64]

#: Bandwidth of the velocity loop as a multiple of the position loop's (Tsai 2010: 80 and 40 Hz).
VELOCITY_RATIO = 2.0


def placed(servo: Servo, letter: str, bandwidth_hz: float, damping: float) -> Servo:
    """Return a servo with gains for a bandwidth (Hz) and damping; what else it has stays.

    Of ``first-order`` the damping decides where the lag allows less than the bandwidth. ``pd-plus`` takes the bandwidth as
    its natural frequency.

    Raises:
        UsageError: The model has no gains to place, or the asked values cannot be had (``tune-place``).
    """
    values = servo_schema.resolve(servo, letter)
    if servo.model not in _PLACED:
        raise UsageError(
            Diagnostic("tune-place", f"axis {letter}: gains of the model {servo.model} are not placed")
        )
    if not (bandwidth_hz > 0.0 and damping > 0.0):
        raise UsageError(Diagnostic("tune-place", "bandwidth and damping must be positive"))
    found = _PLACED[servo.model](values, 2.0 * math.pi * bandwidth_hz, damping)
    if any(value < 0.0 for value in found.values()):
        text = ", ".join(f"{k} = {v:.4g}" for k, v in found.items())
        raise UsageError(
            Diagnostic("tune-place", f"axis {letter}: {bandwidth_hz:g} Hz at damping {damping:g} needs {text}",
                       hint="the drive alone is faster or better damped than that; ask for more bandwidth")
        )  # fmt: skip
    if is_rotary(letter):
        found = {k: v for k, v in found.items() if "_mm" not in k}
    return Servo(servo.model, {**servo.parameters, **found})


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


_PLACED = {
    "first-order": _place_first_order,
    "pd-plus": _place_pd_plus,
    "pi-p-feedforward": _place_cascade,
}


def open_response(servo: Servo, letter: str, period_s: float, frequencies: Floats) -> NDArray[np.complex128]:
    """Return the loop broken at the drive's input, at frequencies in rad/s.

    Raises:
        ValueError: The model is a closed loop as a whole.
    """
    period = control_period(servo, letter, period_s)
    plant, controller = plant_and_controller(servo, letter, period)
    if controller.continuous:
        return _continuous_response(plant, controller, frequencies)
    return open_loop(close_loop(plant.with_imperfections(coulomb=0.0), controller, period), frequencies)


def _continuous_response(plant: Plant, controller: Controller, frequencies: Floats) -> NDArray[np.complex128]:
    """Return −(law)(jωI − A)⁻¹ B with plant and controller in a row."""
    n, m = len(plant.a), len(controller.a)
    speed = np.zeros(n)
    if plant.velocity is not None:
        speed[plant.velocity] = 1.0
    a = np.zeros((n + m, n + m))
    a[:n, :n], a[n:, n:] = plant.a, controller.a
    a[n:, :n] = np.outer(controller.column("b_position"), plant.encoder)
    a[n:, :n] += np.outer(controller.column("b_velocity"), speed)
    law = np.concatenate(
        [controller.d_position * plant.encoder + controller.d_velocity * speed, controller.c]
    )
    b = np.concatenate([plant.b, np.zeros(m)]).astype(complex)
    systems = 1j * np.asarray(frequencies)[:, None, None] * np.eye(n + m) - a
    states = np.linalg.solve(systems, np.broadcast_to(b[:, None], (len(systems), n + m, 1)))[:, :, 0]
    return np.asarray(-(states @ law.astype(complex)), np.complex128)


def loop_margins(servo: Servo, letter: str, period_s: float) -> Margins:
    """Return the stability margins of an axis's loop."""
    period = control_period(servo, letter, period_s)
    frequencies = np.geomspace(0.1, 0.999 * math.pi / period, 3000)
    return margins(open_response(servo, letter, period_s, frequencies), frequencies)


def bode_table(servo: Servo, letter: str, period_s: float, rows: int = 25) -> str:
    """Return frequency (Hz), magnitude (dB) and phase (°) of the open loop as lines of text."""
    top = 0.999 * math.pi / control_period(servo, letter, period_s)
    frequencies = np.geomspace(2.0 * math.pi * 0.1, top, rows)
    response = open_response(servo, letter, period_s, frequencies)
    phase = np.degrees(np.unwrap(np.angle(response)))
    phase -= 360.0 * round((phase[0] + 90.0) / 360.0)
    lines = ["  frequency Hz  magnitude dB  phase °"]
    for w, h, angle in zip(frequencies, response, phase, strict=True):
        lines.append(
            f"  {w / (2 * math.pi):12.4g}  {20 * math.log10(max(abs(h), 1e-300)):12.2f}  {angle:7.1f}"
        )
    return "\n".join(lines)


@dataclass(frozen=True, slots=True)
class Search:
    """The best gain set of a search: servos, its contour error (rms, mm), that of the start, sets tried and refused."""

    servos: Mapping[str, Servo]
    contour_rms_mm: float
    start_rms_mm: float
    tried: int
    refused: int


#: Gains that a search changes, by model.
_SEARCHED = {
    "first-order": ("position_gain_1_s",),
    "pd-plus": ("position_gain_volt_count", "derivative_gain_volt_s_rad"),
    "pi-p-feedforward": ("velocity_gain_1_s", "integral_rate_1_s", "position_gain_1_s"),
}


def search(
    setpoints: Sequence[Setpoints],
    servos: Mapping[str, Servo],
    *,
    sets: int = 1000,
    modulus: float = 0.5,
    spread: float = 2.0,
    seed: int = 0,
    workers: int = 2,
) -> Search:
    """Try random gain sets round the given ones and keep the one with the least rms contour error.

    Simulations run in threads, since the kernels release the interpreter.

    Args:
        setpoints: The motion.
        servos: Where the search starts; all axes' gains change independently, log-uniformly.
        sets: Gain sets.
        modulus: Sets whose loops come nearer to −1 than this are refused.
        spread: Gains change by up to this factor either way.
        seed: Of the draws.
        workers: Threads.

    Raises:
        UsageError: No axis has gains that can be searched (``tune-search``).
    """
    from concurrent.futures import ThreadPoolExecutor

    axes = [k for k in setpoints[0].axes if k in servos and servos[k].model in _SEARCHED]
    if not axes:
        raise UsageError(Diagnostic("tune-search", "no axis has a model whose gains can be searched"))
    names = [(letter, key) for letter in axes for key in _SEARCHED[servos[letter].model]]
    draws = np.random.default_rng(seed).uniform(-math.log(spread), math.log(spread), (sets, len(names)))
    period = setpoints[0].period_s

    def tried(draw: Floats) -> tuple[float, Mapping[str, Servo]]:
        changed = {k: dict(servo.parameters) for k, servo in servos.items()}
        for (letter, key), step in zip(names, draw, strict=True):
            changed[letter][key] *= math.exp(step)
        found = {k: Servo(servo.model, changed[k]) for k, servo in servos.items()}
        if any(loop_margins_at_least(found[k], k, period, modulus) is False for k in axes):
            return math.inf, found
        try:
            return float(summarize(simulate(iter(setpoints), found))["contour_error_rms_mm"]), found
        except UsageError:
            return math.inf, found

    start = tried(np.zeros(len(names)))
    with ThreadPoolExecutor(workers) as pool:
        results = list(pool.map(tried, draws))
    best = min([start, *results], key=lambda result: result[0])
    if not math.isfinite(best[0]):
        raise UsageError(
            Diagnostic("tune-search", f"none of {sets} gain sets keeps the modulus margin {modulus:g}")
        )
    return Search(best[1], best[0], start[0], sets, sum(not math.isfinite(r[0]) for r in results))


def loop_margins_at_least(servo: Servo, letter: str, period_s: float, modulus: float) -> bool:
    """Tell whether a loop is stable and keeps a distance from −1."""
    period = control_period(servo, letter, period_s)
    plant, controller = plant_and_controller(servo, letter, period)
    loop = close_loop(plant.with_imperfections(coulomb=0.0), controller, period)
    if np.abs(loop.poles()).max() >= 1.0:
        return False
    frequencies = np.geomspace(0.1, 0.999 * math.pi / period, 300)
    return float(np.abs(1.0 + open_response(servo, letter, period_s, frequencies)).min()) >= modulus
