"""Open loops of axes and of control schemes, their margins, and Bode tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Severity
from cncgen.machine.record import Servo
from cncgen.servo.controller import Controller
from cncgen.servo.controllers.ccc import contour_loop
from cncgen.servo.controllers.tcf import loop_on_a_line
from cncgen.servo.discretise import held
from cncgen.servo.frequency import Margins, margins, open_loop, response_to_setpoint
from cncgen.servo.loop import AxisLoop, close_loop
from cncgen.servo.models import control_period, plant_and_controller
from cncgen.servo.named_schemes import Settings, cross_coupling, plain_servos, scheme_maker
from cncgen.servo.plants import Plant
from cncgen.servo.uncertainty import Perturbation, perturbed

Floats = NDArray[np.float64]

#: Frequencies of the margins of drawn machines.
DRAWN_FREQUENCIES = 1000
#: A bandwidth below this share of the requested one counts as missed.
MISSED = 0.95
Complexes = NDArray[np.complex128]


def open_response(servo: Servo, letter: str, period_s: float, frequencies: Floats) -> NDArray[np.complex128]:
    """Return the sampled loop broken at the drive's input, with its hold and its dead times, at frequencies in rad/s.

    A controller that the model has in continuous time is sampled as a drive does it: once a control period, with its integrals
    updated by the sample that it has just read (backward differences), and one period later at the drive.

    Raises:
        ValueError: The model is a closed loop as a whole.
    """
    period = control_period(servo, letter, period_s)
    plant, controller = plant_and_controller(servo, letter, period)
    if controller.continuous:
        return _sampled_by_a_drive(plant, controller, frequencies, period)
    return open_loop(close_loop(plant.with_imperfections(coulomb=0.0), controller, period), frequencies)


def _sampled_by_a_drive(
    plant: Plant, controller: Controller, frequencies: Floats, period: float
) -> NDArray[np.complex128]:
    """Return −z⁻¹ C(s) P(z) with s = (1 − z⁻¹)/T in the controller and the plant's input held over T; shape (n,)."""
    z: Complexes = np.asarray(np.exp(1j * np.asarray(frequencies, float) * period), np.complex128)
    phi, gamma = held(plant.a, plant.b[:, None], period)
    states = _resolvent(z, phi, gamma[:, 0])
    speed = np.zeros(len(plant.a))
    if plant.velocity is not None:
        speed[plant.velocity] = 1.0
    position, velocity = states @ plant.encoder.astype(complex), states @ speed.astype(complex)
    back = np.asarray((1.0 - 1.0 / z) / period, np.complex128)
    drive = controller.d_position * position + controller.d_velocity * velocity
    for name, seen in (("b_position", position), ("b_velocity", velocity)):
        memory = _resolvent(back, controller.a, controller.column(name))
        drive = drive + (memory @ controller.c.astype(complex)) * seen
    return np.asarray(-drive / z, np.complex128)


def largest_pole(servo: Servo, letter: str, period_s: float) -> float:
    """Return the largest |z| of an axis's poles over a control period, friction left out: from 1 on it is unstable.

    They are those of the loop that is simulated, and of a controller in continuous time also those that it has as a drive samples
    it (`open_response`).

    Raises:
        ValueError: The model is a closed loop as a whole.
    """
    period = control_period(servo, letter, period_s)
    plant, controller = plant_and_controller(servo, letter, period)
    plant = plant.with_imperfections(coulomb=0.0)
    transitions = [close_loop(plant, controller, period).transition()[0]]
    if controller.continuous:
        transitions.append(_transition_by_a_drive(plant, controller, period))
    return float(max(np.abs(np.linalg.eigvals(each)).max() for each in transitions))


def _transition_by_a_drive(plant: Plant, controller: Controller, period: float) -> Floats:
    """Return the transition of plant, controller and the drive's input of the last instant that `_sampled_by_a_drive` is open of."""
    phi, gamma = held(plant.a, plant.b[:, None], period)
    n, m = len(plant.a), len(controller.a)
    speed = np.zeros(n)
    if plant.velocity is not None:
        speed[plant.velocity] = 1.0
    read = np.outer(controller.column("b_position"), plant.encoder) + np.outer(
        controller.column("b_velocity"), speed
    )
    found = np.zeros((n + m + 1, n + m + 1))
    found[:n, :n], found[:n, n + m] = phi, gamma[:, 0]
    found[n : n + m, : n + m] = np.linalg.solve(
        np.eye(m) - period * controller.a, np.hstack([period * read, np.eye(m)])
    )
    found[n + m] = controller.c @ found[n : n + m]
    found[n + m, :n] += controller.d_position * plant.encoder + controller.d_velocity * speed
    return found


def _resolvent(points: Complexes, a: Floats, b: Floats) -> Complexes:
    """Return (p I − A)⁻¹ b at each point, shape (n, len(b))."""
    systems = points[:, None, None] * np.eye(len(a)) - a
    sides = np.broadcast_to(b.astype(complex)[:, None], (len(points), len(b), 1))
    return np.asarray(np.linalg.solve(systems, sides)[:, :, 0], np.complex128)


@dataclass(frozen=True, slots=True)
class OpenLoop:
    """A loop broken at one place.

    Attributes:
        name: Its name.
        period: Control period, s: its frequencies end at π/period.
        response: From frequencies in rad/s to L(jω).
        largest_pole: |z| of the closed loop's slowest pole; margins mean nothing from 1 on. 0: it is not known.
    """

    name: str
    period: float
    response: Callable[[Floats], Complexes]
    largest_pole: float = 0.0

    @property
    def stable(self) -> bool:
        """Tell whether the loop is stable once it is closed."""
        return self.largest_pole < 1.0

    def frequencies(self, count: int, low: float = 0.1) -> Floats:
        """Return frequencies from `low` to the loop's end, rad/s, evenly spaced by their logarithm."""
        return np.geomspace(low, 0.999 * math.pi / self.period, count)

    def margins(self, count: int = 3000) -> Margins:
        """Return its stability margins."""
        frequencies = self.frequencies(count)
        return margins(self.response(frequencies), frequencies)

    def modulus(self, count: int = 300) -> float:
        """Return its distance from −1."""
        return float(np.abs(1.0 + self.response(self.frequencies(count))).min())

    def bode_table(self, rows: int = 25) -> str:
        """Return frequency (Hz), magnitude (dB) and phase (°) as lines of text."""
        frequencies = self.frequencies(rows, 2.0 * math.pi * 0.1)
        response = self.response(frequencies)
        phase = np.degrees(np.unwrap(np.angle(response)))
        phase -= 360.0 * round((phase[0] + 90.0) / 360.0)
        lines = ["  frequency Hz  magnitude dB  phase °"]
        for w, h, angle in zip(frequencies, response, phase, strict=True):
            size = 20 * math.log10(max(abs(h), 1e-300))
            lines.append(f"  {w / (2 * math.pi):12.4g}  {size:12.2f}  {angle:7.1f}")
        return "\n".join(lines)


def axis_open_loop(servo: Servo, letter: str, period_s: float) -> OpenLoop:
    """Return the loop of an axis broken at its drive.

    Raises:
        ValueError: The model is a closed loop as a whole.
        UsageError: The periods do not fit.
    """
    period = control_period(servo, letter, period_s)
    pole = largest_pole(servo, letter, period_s)
    return OpenLoop(letter, period, lambda w: open_response(servo, letter, period_s, w), pole)


def open_loops(
    controller: str, servos: Mapping[str, Servo], axes: str, period_s: float, settings: Settings | None = None
) -> list[OpenLoop]:
    """Return every loop of a named scheme (`cncgen.servo.named_schemes`).

    ``p`` and ``zpetc`` have the axes' own. With ``ccc`` comes the contour loop W G where the path runs across each axis.
    ``tcf`` has none but its own: those of the error along and across a straight path along each axis.

    Raises:
        ValueError: The axes cannot be had under that scheme.
    """
    settings = settings or Settings()
    if controller == "tcf":
        return list(_task_frame_loops(servos, axes, period_s, settings))
    found = [axis_open_loop(servos[letter], letter, period_s) for letter in axes]
    if "ccc" not in controller:
        return found
    loops = [linear_loop(servos[letter], letter, period_s) for letter in axes]
    coupling = cross_coupling(loops, axes, settings)
    for letter, loop in zip(axes, loops, strict=True):
        found.append(_contour_loop(letter, loop, coupling.proportional, coupling.integral))
    return found


def _contour_loop(letter: str, loop: AxisLoop, proportional: float, integral: float) -> OpenLoop:
    return OpenLoop(
        f"contour loop where the path runs across {letter}",
        loop.period,
        lambda w: contour_loop(loop, proportional, integral, w),
    )


def _task_frame_loops(
    servos: Mapping[str, Servo], axes: str, period_s: float, settings: Settings
) -> Iterator[OpenLoop]:
    scheme_maker("tcf", servos, settings)(axes, period_s)
    for letter in axes:
        period = control_period(servos[letter], letter, period_s)
        plant, _ = plant_and_controller(servos[letter], letter, period)
        for what, natural, damping in (
            ("along", settings.tcf_tangential_rad_s, settings.tcf_tangential_damping),
            ("across", settings.tcf_normal_rad_s, settings.tcf_normal_damping),
        ):
            yield OpenLoop(
                f"{letter}, error {what} the path",
                period,
                partial(loop_on_a_line, plant, natural, damping, period),
            )


@dataclass(frozen=True, slots=True)
class WorstMargins:
    """The least margins of a loop over drawn machines, and how many of them are unstable."""

    name: str
    gain: float
    phase_deg: float
    modulus: float
    draws: int
    unstable: int


def worst_margins(
    controller: str,
    servos: Mapping[str, Servo],
    axes: str,
    period_s: float,
    settings: Settings | None,
    perturbation: Perturbation,
) -> list[WorstMargins]:
    """Return the least margins of every loop of a scheme over drawn machines; the coupling keeps its gains.

    Raises:
        ValueError: As `open_loops`.
    """
    found: dict[str, list[Margins]] = {}
    unstable: dict[str, int] = {}
    for drawn in perturbed(servos, axes, perturbation):
        for loop in open_loops(controller, drawn, axes, period_s, settings):
            found.setdefault(loop.name, []).append(loop.margins(DRAWN_FREQUENCIES))
            unstable[loop.name] = unstable.get(loop.name, 0) + (not loop.stable)
    return [
        WorstMargins(
            name,
            min(m.gain for m in each),
            min(m.phase_deg for m in each),
            min(m.modulus for m in each),
            len(each),
            unstable[name],
        )
        for name, each in found.items()
    ]


def missed_targets(
    servos: Mapping[str, Servo], axes: str, period_s: float, bandwidth_hz: float, modulus: float
) -> Iterator[Diagnostic]:
    """Yield a warning for each axis whose sampled loop misses the bandwidth that it was placed for, or the modulus margin."""
    for letter in axes:
        plain = plain_servos({letter: servos[letter]})[letter]
        reached = closed_bandwidth_hz(linear_loop(plain, letter, period_s))
        margin = axis_open_loop(servos[letter], letter, period_s).modulus()
        missed = []
        if reached < MISSED * bandwidth_hz:
            missed.append(
                f"{bandwidth_hz:g} Hz were asked for, and the closed loop reaches {reached:.3g} Hz (-3 dB)"
            )
        if margin < modulus:
            missed.append(f"the modulus margin is {margin:.3f}, below {modulus:g}")
        if missed:
            yield Diagnostic(
                "tune-missed",
                f"axis {letter}: {'; '.join(missed)}",
                severity=Severity.WARNING,
                hint="ask for less bandwidth or damping, or shorten control_period_s; the drive's own lag bounds both",
                values={"axis": letter, "bandwidth_hz": reached, "modulus": margin},
            )


def linear_loop(servo: Servo, letter: str, period_s: float) -> AxisLoop:
    """Return the closed loop of an axis without its friction; raises ValueError where it is given as a whole."""
    period = control_period(servo, letter, period_s)
    plant, controller = plant_and_controller(servo, letter, period)
    return close_loop(plant.with_imperfections(coulomb=0.0), controller, period)


def closed_bandwidth_hz(loop: AxisLoop) -> float:
    """Return where the response from setpoint to position first falls to 1/√2 of its value at rest, Hz; inf if nowhere."""
    w = np.geomspace(0.1, 0.999 * math.pi / loop.period, 4000)
    size = np.abs(response_to_setpoint(loop, w))
    below = np.flatnonzero(size < math.sqrt(0.5) * size[0])
    return float(w[below[0]]) / (2.0 * math.pi) if len(below) else math.inf
