"""Frequency responses of sampled loops, their margins, and their ratios of polynomials in z."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.loop import AxisLoop

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def ratio_in_z(loop: AxisLoop, parts: int = 1) -> tuple[Floats, Floats]:
    """Return (numerator, denominator) of a linear loop from setpoint to position, highest power of z first.

    C (zI − A)⁻¹ (B0 + z B1) + D of the loop's transition; the numerator has the denominator's length.

    Args:
        loop: The loop.
        parts: Control periods a setpoint, between which setpoints are interpolated linearly; z is a setpoint's shift.
    """
    a, start, end = _over_setpoint(loop, parts)
    below = np.real(np.poly(a))
    above = _numerator(a, start, loop.output, below) + loop.feedthrough * below
    if end.any():
        above = above + np.append(_numerator(a, end, loop.output, below)[1:], 0.0)
    return above, below


def _over_setpoint(loop: AxisLoop, parts: int) -> tuple[Floats, Floats, Floats]:
    """Return (A, B0, B1) over a setpoint's period of that many control periods."""
    a, b0, b1 = loop.transition()
    total, start, end = np.eye(len(a)), np.zeros(len(a)), np.zeros(len(a))
    for m in range(parts):
        first, last = m / parts, (m + 1) / parts
        total, start, end = (
            a @ total,
            a @ start + b0 * (1.0 - first) + b1 * (1.0 - last),
            a @ end + b0 * first + b1 * last,
        )
    return total, start, end


def _numerator(a: Floats, b: Floats, c: Floats, below: Floats) -> Floats:
    """Return C adj(zI − A) B = det(zI − A + B C) − det(zI − A)."""
    return np.real(np.poly(a - np.outer(b, c))) - below


def response_to_drive(loop: AxisLoop, frequencies: Floats) -> Complexes:
    """Return the response of the measured position to what is added to the drive's input, the loop being closed.

    Args:
        loop: The loop.
        frequencies: Shape (n,), rad/s, up to π over the control period.

    Returns:
        Shape (n,), mm (or rad) a unit of drive input.
    """
    a, _, _ = loop.transition()
    b = loop.inputs[1 if loop.sampled else 0, 0, 2]
    return _response(a, b, loop.encoder, frequencies, loop.period)


def response_to_setpoint(loop: AxisLoop, frequencies: Floats) -> Complexes:
    """Return the response of the position to the setpoint, the loop being closed, at frequencies in rad/s; shape (n,) both."""
    a, start, end = loop.transition()
    z = np.exp(1j * np.asarray(frequencies) * loop.period)
    plain = _response(a, start, loop.output, frequencies, loop.period)
    ahead = _response(a, end, loop.output, frequencies, loop.period) if end.any() else 0.0
    return plain + z * ahead + loop.feedthrough


def open_loop(loop: AxisLoop, frequencies: Floats) -> Complexes:
    """Return L(e^jωT) of a sampled loop, broken at the drive's input: −(drive asked for)/(drive given), shape (n,).

    For a continuous controller the flow under a held drive is exact only for the plant; use `continuous_open_loop`.
    """
    if not loop.sampled:
        raise ValueError("the loop's controller is continuous")
    a = loop.phi[1, 0] @ loop.jump
    return -_response(a, loop.inputs[1, 0, 2], loop.law, frequencies, loop.period)


def _response(a: Floats, b: Floats, c: Floats, frequencies: Floats, period: float) -> Complexes:
    z = np.exp(1j * np.asarray(frequencies, float) * period)
    systems = z[:, None, None] * np.eye(len(a)) - a
    states = np.linalg.solve(systems, np.broadcast_to(b[:, None], (len(z), len(b), 1)))[:, :, 0]
    return states @ c.astype(complex)


@dataclass(frozen=True, slots=True)
class Margins:
    """Stability margins of an open loop (K. J. Åström and R. M. Murray, Feedback Systems (2008), section 9.3).

    Attributes:
        gain: Factor that the gain may grow by; inf where the phase never reaches −180°.
        phase_deg: Phase left where the magnitude is 1; inf where it never is.
        modulus: Smallest distance to −1: 1/max |S|.
        crossover_rad_s: Where the magnitude is 1 (the last time), or 0.
    """

    gain: float
    phase_deg: float
    modulus: float
    crossover_rad_s: float


def margins(response: Complexes, frequencies: Floats) -> Margins:
    """Return the margins of L(jω), shape (n,), given at rising frequencies (rad/s), interpolated between them.

    Gain margin g_m, phase margin φ_m and the distance s_m of L from −1 (K. J. Åström and R. M. Murray (2008), section 9.3).
    """
    size, phase = np.abs(response), np.unwrap(np.angle(response))
    phase -= 2 * math.pi * round((phase[0] + math.pi / 2) / (2 * math.pi))
    log = np.log(np.maximum(size, 1e-300))
    falls = np.flatnonzero((log[:-1] > 0) & (log[1:] <= 0))
    turns = np.flatnonzero((phase[:-1] > -math.pi) != (phase[1:] > -math.pi))
    share = [log[i] / (log[i] - log[i + 1]) for i in falls]
    phases = [phase[i] + s * (phase[i + 1] - phase[i]) for i, s in zip(falls, share, strict=True)]
    last = frequencies[falls[-1]] + share[-1] * np.diff(frequencies)[falls[-1]] if len(falls) else 0.0
    gains = []
    for i in turns:
        s = (phase[i] + math.pi) / (phase[i] - phase[i + 1])
        gains.append(math.exp(-(log[i] + s * (log[i + 1] - log[i]))))
    return Margins(
        min((g for g in gains if g > 1.0), default=math.inf),
        min((math.degrees(p) + 180.0 for p in phases), default=math.inf),
        float(np.abs(1.0 + response).min()),
        float(last),
    )
