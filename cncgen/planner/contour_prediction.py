"""The contour error that servo loops will make of a planned motion (Tsai 2010, section IV, eqs 9 to 18).

Each axis is its closed loop G from setpoint to position. The bilinear transform gives G(z) (eq. 10), from it the
error of the axis for its speed (eqs 11 to 16), a recursive filter that runs along the plan; the part of the errors
that is normal to the path is the contour error (eq. 18). Derivation and figures: docs/ild.md.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import comb

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.kernels import filters
from cncgen.machine.record import Machine, Servo
from cncgen.machine.servo_schema import TransferFunction, closed_loop
from cncgen.planner.motion import motion_at
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Trajectory

Floats = NDArray[np.float64]

#: Share of a loop's impulse response (sum of absolute values) that counts as its memory.
_MEMORY = 0.9


def bilinear(coefficients: Floats, degree: int, period_s: float) -> Floats:
    """Substitute s = (2/T)(1 − z⁻¹)/(1 + z⁻¹) (A. Tustin, Journal of the IEE 94, part IIA (1947) 130) and multiply by (T(1 + z⁻¹))^degree.

    Args:
        coefficients: Shape (m + 1,), of a polynomial of s, highest power first, m <= degree.
        degree: Degree of the system that the polynomial belongs to.
        period_s: T.

    Returns:
        Shape (degree + 1,): coefficients of z⁰, z⁻¹, …; for the degree 4 the c_i and d_i of appendix A-2.
    """
    total = np.zeros(degree + 1)
    for power, coefficient in enumerate(reversed(coefficients)):
        minus = np.array([(-1.0) ** i * comb(power, i) for i in range(power + 1)])
        plus = np.array([float(comb(degree - power, i)) for i in range(degree - power + 1)])
        total += coefficient * 2.0**power * period_s ** (degree - power) * np.convolve(minus, plus)
    return total


def error_filter(numerator: Floats, denominator: Floats, period_s: float) -> tuple[Floats, Floats]:
    """Return the filter from an axis's speed to its following error E = R − Y, E/V = T/2 · (1 + z⁻¹)/(1 − z⁻¹) · (c − d)/c (eq. 15, appendix A-3).

    A loop without a steady-state error has (c − d)(1) = 0; that factor 1 − z⁻¹ is divided out, which leaves the same ratio without the
    integrator of eq. 15, whose rounding would drift.

    Args:
        numerator, denominator: The closed loop Y/R in s, highest power first; that of eq. 9 has shapes (3,) and (5,).
        period_s: T.

    Returns:
        Coefficients b, a of z⁰, z⁻¹, …, shape (degree + 1,) each, a_0 = 1; E in mm of V in mm/s.

    Raises:
        ValueError: The closed loop has no unit gain at rest.
    """
    reduced, c = _reduced(numerator, denominator, period_s)
    b = 0.5 * period_s * np.convolve(reduced, [1.0, 1.0]) if len(reduced) else np.zeros(1)
    return b / c[0], c / c[0]


def increment_filter(numerator: Floats, denominator: Floats, period_s: float) -> tuple[Floats, Floats]:
    """Return the filter from increments of an axis's reference to its following error (eqs 10 and 11); arguments, shapes and errors as of `error_filter`.

    E/R = (c − d)/c, divided by the increments' 1 − z⁻¹; b_degree = 0.
    """
    reduced, c = _reduced(numerator, denominator, period_s)
    return np.append(reduced, 0.0) / c[0], c / c[0]


def _reduced(numerator: Floats, denominator: Floats, period_s: float) -> tuple[Floats, Floats]:
    """Return (c − d)/(1 − z⁻¹) and c of eq. 10, shapes (degree,) and (degree + 1,); raise `ValueError` where the gain at rest is not 1."""
    degree = len(denominator) - 1
    c = bilinear(denominator, degree, period_s)
    d = bilinear(numerator, degree, period_s)
    if abs(np.sum(c - d)) > 1e-6 * abs(np.sum(c)):
        raise ValueError("the closed loop does not come to rest where it is sent (its gain at rest is not 1)")
    return np.cumsum(c - d)[:-1], c


def static_coefficients(numerator: Floats, denominator: Floats) -> tuple[float, float]:
    """Return (E/V in s, contour error per centripetal acceleration in s²) of a loop in the steady state.

    With E/R = 1 − G = e1 s + e2 s² + … a circle traced at ω is larger by |G(jω)| = 1 + (e2 + e1²/2) ω² + O(ω⁴), so to
    second order the path runs outside (or, where that is negative, inside) by |e2 + e1²/2| v²κ.

    Args:
        numerator, denominator: G in s, highest power first, of any lengths, with G(0) = 1.
    """
    difference = np.polysub(denominator, numerator)[::-1]
    low = denominator[::-1]
    padded = np.concatenate([difference, np.zeros(3)])
    first = padded[1] / low[0]
    second = (padded[2] - first * (low[1] if len(low) > 1 else 0.0)) / low[0]
    return float(first), float(abs(second + 0.5 * first**2))


@dataclass(slots=True)
class ErrorFilters:
    """Filters of some axes, from what moves each to its following error.

    Attributes:
        coefficients: b and a of each (`error_filter`, `increment_filter`).
        states: Their running states.
    """

    coefficients: list[tuple[Floats, Floats]]
    states: list[Floats]

    def run(self, inputs: Floats) -> Floats:
        """Return the following errors of further samples, mm; shape (n, axes) as the inputs; the states move on."""
        out = np.empty((len(self.states), len(inputs)))
        for (b, a), state, column, errors in zip(self.coefficients, self.states, inputs.T, out, strict=True):
            filters.recursive(b, a, np.ascontiguousarray(column), errors, state)
        return np.ascontiguousarray(out.T)

    def snapshot(self) -> list[Floats]:
        """Return a copy of the states."""
        return [state.copy() for state in self.states]

    def restore(self, states: list[Floats]) -> None:
        """Go on from a snapshot."""
        for mine, state in zip(self.states, states, strict=True):
            mine[:] = state

    def memory(self) -> int:
        """Return the number of samples in which the slowest filter gives most of its answer to a pulse."""
        before, pulse = self.snapshot(), np.zeros((400, len(self.states)))
        pulse[:1] = 1.0
        answers = np.cumsum(np.abs(self.run(pulse)), axis=0).T
        self.restore(before)
        return max(
            [1, *(int(np.searchsorted(each, _MEMORY * each[-1])) for each in answers if each[-1] > 0.0)]
        )


@dataclass(slots=True)
class ContourPrediction:
    """Predicts the contour error along a plan, sample by sample.

    Attributes:
        letters: The axes among X Y Z, in that order.
        loops: Their filters, from speeds (eq. 15).
        per_centripetal_s2: Static contour error per v²κ, the largest over the axes (2.845e-5 s² on the XY table).
    """

    letters: str
    loops: ErrorFilters
    per_centripetal_s2: float

    def run(self, tangent: Floats, speed: Floats) -> tuple[Floats, Floats]:
        """Return the predicted errors of further samples across and along the path (eqs 16 to 18, in space).

        Args:
            tangent: Shape (n, axes), unit, of the path at each sample: t_x, t_y …
            speed: Shape (n,), mm/s along the path: V.

        Returns:
            Shape (n,) each, mm: the contour error, which is the length of the part of E normal to the tangent (in the
            plane |−t_y E_x + t_x E_y|); and E along the tangent, positive where the axes lag.
        """
        error = self.loops.run(tangent * speed[:, None])
        along = np.einsum("ij,ij->i", error, tangent)
        normal = error - along[:, None] * tangent
        return np.sqrt(np.einsum("ij,ij->i", normal, normal)), along


def prediction(machine: Machine, options: PlanOptions, letters: str) -> ContourPrediction:
    """Set up the prediction (Tsai 2010, eqs 9 to 15) for some of the axes X Y Z.

    Raises:
        UsageError: An axis has no servo data, or a model whose error cannot be predicted; every such axis is named.
    """

    def made(loop: TransferFunction) -> tuple[Floats, Floats]:
        if loop.delay_s:
            raise ValueError("its loop has a dead time")
        return error_filter(loop.numerator, loop.denominator, machine.period_s)

    fault = Diagnostic(
        "contour-prediction",
        "the contour error of axis {} cannot be predicted",
        hint="give servo data with --axis-params, or leave max_contour_error_mm out of the machine",
    )
    loops, coefficients = predictions(machine, options, letters, made, fault)
    return ContourPrediction(letters, loops, max((curve for _, curve in coefficients), default=0.0))


def predictions(
    machine: Machine,
    options: PlanOptions,
    letters: str,
    made: Callable[[TransferFunction], tuple[Floats, Floats]],
    fault: Diagnostic,
) -> tuple[ErrorFilters, list[tuple[float, float]]]:
    """Return the filters of axes at rest, and the `static_coefficients` of their loops.

    Args:
        machine, options: Where the servo data stand.
        letters: The axes.
        made: Returns the filter of a closed loop; raises ValueError where there is none.
        fault: The message for an axis without one, `{}` standing for its letter; the reason follows.

    Raises:
        UsageError: An axis has no servo data, or no filter; every such axis is named.
    """
    loops = ErrorFilters([], [])
    coefficients: list[tuple[float, float]] = []
    faults: list[Diagnostic] = []
    for letter in letters:
        servo = servo_of(machine, options, letter)
        try:
            if servo is None:
                raise ValueError("it has no servo data")
            loop = closed_loop(servo, letter)
            b, a = made(loop)
        except ValueError as problem:
            faults.append(replace(fault, message=f"{fault.message.format(letter)}: {problem}"))
            continue
        loops.coefficients.append((b, a))
        loops.states.append(np.zeros(len(a) - 1))
        coefficients.append(static_coefficients(loop.numerator, loop.denominator))
    if faults:
        raise UsageError(faults)
    return loops, coefficients


def servo_of(machine: Machine, options: PlanOptions, letter: str) -> Servo | None:
    """Return the servo data of an axis: those of the options, else the machine's."""
    if options.servos is not None and letter in options.servos:
        return options.servos[letter]
    axis = machine.axes.get(letter)
    return axis.servo if axis else None


def predicted_errors(
    trajectories: Sequence[Trajectory], machine: Machine, options: PlanOptions
) -> Floats | None:
    """Return the contour error predicted at every tick of a plan (eqs 15 to 18), shape (ticks,), mm.

    None where an axis of X Y Z that the machine has cannot be predicted. At corners and ends only the part across the
    path is counted, as in the paper.
    """
    letters = "".join(letter for letter in "XYZ" if letter in machine.axes)
    try:
        model = prediction(machine, options, letters)
    except UsageError:
        return None
    found, first = [np.zeros(0)], 0.0
    for trajectory in trajectories:
        profile = trajectory.profile
        last = np.ceil(profile.t[-1] / machine.period_s - 1e-9)
        ticks = np.arange(first, last) * machine.period_s
        columns = [trajectory.toolpath.axes.index(letter) for letter in letters]
        if trajectory.cubics is not None:
            velocity = trajectory.cubics.at(ticks, 1)[1][:, columns]
            speed = np.sqrt((velocity**2).sum(axis=1))
            tangent = velocity / np.maximum(speed, 1e-12)[:, None]
        else:
            motion = motion_at(profile, ticks)
            tangent, speed = trajectory.toolpath.path.evaluate(motion.s, 1)[1][:, columns], motion.v
        found.append(model.run(tangent, speed)[0])
        first = last
    return np.concatenate(found)
