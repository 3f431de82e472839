"""The modified reference: the command that makes a closed loop's output the wanted one.

Source: S.-L. Chen and H.-S. Hsu, eqs 4 to 8. With G = N/D and wanted x, the command obeys N(d/dt) u = D(d/dt) x =: x̂, so u is
x̂ convolved with the impulse response of 1/N. (Eq. 8's term h(t) x̂(0) must not be there: u(0) is 0 for a system at rest.)

Zeros of G in the right half plane make that convolution grow. Then the bounded solution is another one (Devasia, Chen and
Paden, IEEE TAC 41 (1996) 930): each such zero z takes its part of 1/N backwards in time, −∫_t^∞ e^(z(t−λ)) x̂(λ) dλ, and
the command begins before the motion (pre-actuation).

x̂ is a sum of powers and exponentials on each piece, so each part is integrated exactly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.discretise import held
from cncgen.servo.plants import companion
from cncgen.servo.reference_profiles import ProfilePiece, ReferenceProfile, combined

Floats = NDArray[np.float64]


def modified_reference(
    numerator: Floats, denominator: Floats, wanted: ReferenceProfile, times: Floats, *, stable: bool = False
) -> Floats:
    """Return the command u at times, shape (n,).

    Args:
        numerator, denominator: G = N/D in s, highest power first.
        wanted: x.
        times: s, shape (n,); with `stable` they may begin before 0.
        stable: False for the paper's causal convolution, True for the bounded solution.

    Raises:
        ValueError: N has a zero on the imaginary axis or a double zero.
    """
    above, below = (np.trim_zeros(np.asarray(p, float), "f") for p in (numerator, denominator))
    if len(above) > len(below):
        raise ValueError("the transfer function is not proper")
    forcing = [combined(piece, below[::-1].tolist()) for piece in wanted.pieces]
    rest = below[-1] * wanted.final
    if len(above) == 1:
        return _forcing_at(forcing, rest, times) / above[0]
    zeros = np.roots(above)
    if np.abs(zeros.real).min() < 1e-12 * np.abs(zeros).max():
        raise ValueError("a zero on the imaginary axis has no bounded inverse")
    slopes = np.polyval(np.polyder(above), zeros)
    apart = np.abs(zeros[:, None] - zeros) + np.diag(np.full(len(zeros), np.inf))
    if apart.min() < 1e-6 * np.abs(zeros).max():
        raise ValueError("a double zero: separate it a little")
    total = np.zeros(len(times), complex)
    for zero, slope in zip(zeros, slopes, strict=True):
        backwards = stable and zero.real > 0.0
        part = _backward(zero, forcing, rest, times) if backwards else _forward(zero, forcing, rest, times)
        total += part / slope
    return total.real


def _forcing_at(forcing: list[ProfilePiece], rest: float, times: Floats) -> Floats:
    return ReferenceProfile(tuple(forcing), rest).value(times)


def _particular(
    zero: complex, piece: ProfilePiece
) -> tuple[NDArray[np.complex128], list[tuple[complex, float]]]:
    """Return the particular solution of u̇ = z u + x̂ on a piece: powers (lowest first) and exponentials."""
    powers = np.zeros(len(piece.powers), complex)
    for k in range(len(powers) - 1, -1, -1):
        above = (k + 1) * powers[k + 1] if k + 1 < len(powers) else 0.0
        powers[k] = (above - piece.powers[k]) / zero
    return powers, [(c / (rate - zero), rate) for c, rate in piece.exponentials]


def _particular_at(
    powers: NDArray[np.complex128], exponentials: list[tuple[complex, float]], tau: Floats
) -> NDArray[np.complex128]:
    total = np.polyval(powers[::-1], tau)
    for c, rate in exponentials:
        total = total + c * np.exp(rate * tau)
    return np.asarray(total, complex)


def _forward(
    zero: complex, forcing: list[ProfilePiece], rest: float, times: Floats
) -> NDArray[np.complex128]:
    """Return ∫_0^t e^(z(t−λ)) x̂ dλ."""
    result = np.zeros(len(times), complex)
    at = 0.0 + 0.0j
    for piece in [*forcing, ProfilePiece(forcing[-1].end, np.inf, (rest,))]:
        solution = _particular(zero, piece)
        free = at - _particular_at(*solution, np.zeros(1))[0]
        inside = (times > piece.start) & (times <= piece.end)
        tau = times[inside] - piece.start
        result[inside] = _particular_at(*solution, tau) + free * np.exp(zero * tau)
        if np.isfinite(piece.end):
            length = piece.end - piece.start
            at = _particular_at(*solution, np.array([length]))[0] + free * np.exp(zero * length)
    return result


def _backward(
    zero: complex, forcing: list[ProfilePiece], rest: float, times: Floats
) -> NDArray[np.complex128]:
    """Return −∫_t^∞ e^(z(t−λ)) x̂ dλ."""
    result = np.full(len(times), -rest / zero, complex)
    at = -rest / zero
    for piece in reversed(forcing):
        solution = _particular(zero, piece)
        length = piece.end - piece.start
        free = at - _particular_at(*solution, np.array([length]))[0]
        inside = (times > piece.start) & (times <= piece.end)
        tau = times[inside] - piece.start
        result[inside] = _particular_at(*solution, tau) + free * np.exp(zero * (tau - length))
        at = _particular_at(*solution, np.zeros(1))[0] + free * np.exp(-zero * length)
    before = times <= forcing[0].start
    result[before] = at * np.exp(zero * (times[before] - forcing[0].start))
    return result


def held_response(numerator: Floats, denominator: Floats, command: Floats, period: float) -> Floats:
    """Return the output at the samples of N/D under a command held over each period, from rest; shape (n,)."""
    a, b, c, feedthrough = companion(numerator, denominator)
    phi, gamma = held(a, b[:, None], period)
    state = np.zeros(len(a))
    result = np.empty(len(command))
    for k, u in enumerate(command):
        result[k] = c @ state + feedthrough * u
        state = phi @ state + gamma[:, 0] * u
    return result


def root_mean_square(error: Floats, period: float) -> float:
    """Return eq. 9, √∫e² dt, as √(T Σ e²): a sum, so over one second it is the rms."""
    return float(np.sqrt(period * (error**2).sum()))
