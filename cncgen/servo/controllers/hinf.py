"""H-infinity mixed-sensitivity design for a stage with a resonance, and QFT-style bounds checked on it.

Source: M. S. Tsai, W. C. Pan and S. H. You, Robust control of a nano-positioning device using an integrated H∞ and QFT
controller (appended to Tsai 2010): design by H∞ with W1 on the error and W2 on the uncertainty, then reshape the
controller at high frequencies while the bounds |S| ≤ α(ω) (its eq. 4) and |L/(1 + L)| ≤ M_L (eq. 5) hold for every plant.
Its plant is shown in figures only; ours is a parameter. The solution is that of K. Glover and J. C. Doyle, Systems and
Control Letters 11 (1988) 167, for D11 = 0, as in Zhou and Doyle, Essentials of Robust Control, theorem 14.1.

Minimised is the H∞ norm of (W1 S; Wt T; wu K S) from setpoint to (W1 e, Wt y, wu u).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.plants import companion

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
#: A ratio of polynomials in s: (numerator, denominator), highest power first.
Ratio = tuple[Sequence[float], Sequence[float]]


@dataclass(frozen=True, slots=True)
class StateSpace:
    """ẋ = A x + B u, y = C x; shapes (n, n), (n, inputs), (outputs, n)."""

    a: Floats
    b: Floats
    c: Floats

    def response(self, frequencies: Floats) -> Complexes:
        """Return the response of the first output to the first input at rad/s, shape (n,)."""
        systems = 1j * np.asarray(frequencies)[:, None, None] * np.eye(len(self.a)) - self.a
        states = np.linalg.solve(
            systems, np.broadcast_to(self.b[:, :1], (len(systems), *self.b[:, :1].shape))
        )
        return np.asarray((self.c[:1] @ states)[:, 0, 0], np.complex128)


@dataclass(frozen=True, slots=True)
class Design:
    """A controller with the norm that it reaches."""

    controller: StateSpace
    gamma: float


def performance_weight(bandwidth: float, peak: float = 2.0, offset: float = 1e-3) -> Ratio:
    """Return W1, whose inverse bounds |S|: `offset` at rest, 1/√2 near `bandwidth` (rad/s), `peak` far above.

    W1 = (s/M + ωb)/(s + ωb ε), made strictly proper two decades above the bandwidth.
    """
    pole = 100.0 * bandwidth
    above = np.array([1.0 / peak, bandwidth])
    below = np.polymul([1.0, bandwidth * offset], [1.0 / pole, 1.0])
    return above.tolist(), below.tolist()


def robustness_weight(crossover: float, low: float = 0.3, high: float = 10.0) -> Ratio:
    """Return Wt, which covers a multiplicative uncertainty: `low` at rest, 1 near `crossover` (rad/s), `high` far above."""
    return [1.0 / crossover, low], [1.0 / (high * crossover), 1.0]


def mixed_sensitivity(
    plant: Ratio, error_weight: Ratio, output_weight: Ratio, control_weight: float
) -> Design:
    """Return the central controller within 0.1 % of the least norm.

    Args:
        plant: Strictly proper and stable.
        error_weight: W1, strictly proper and stable.
        output_weight: Wt, proper and stable.
        control_weight: wu > 0.

    Raises:
        ValueError: A condition is not met, or no controller exists at any norm up to 1e4.
    """
    if not control_weight > 0.0:
        raise ValueError("the control weight must be positive")
    system = _generalised(plant, error_weight, output_weight, control_weight)
    low, high = 1e-3, 1e4
    best = _central(system, high)
    if best is None:
        raise ValueError("no stabilising controller with a norm up to 10,000")
    while high > 1.001 * low:
        middle = float(np.sqrt(low * high))
        found = _central(system, middle)
        if found is None:
            low = middle
        else:
            best, high = found, middle
    return Design(StateSpace(best.a, best.b, best.c / control_weight), high)


@dataclass(frozen=True, slots=True)
class _System:
    """A, B1 (setpoint), B2 (control, scaled by 1/wu), C1 (W1 e; Wt y), C2; D21 = 1 and D12 = (0; 0; 1)."""

    a: Floats
    b1: Floats
    b2: Floats
    c1: Floats
    c2: Floats


def _generalised(plant: Ratio, error_weight: Ratio, output_weight: Ratio, control_weight: float) -> _System:
    ag, bg, cg, dg = companion(np.array(plant[0], float), np.array(plant[1], float))
    a1, b1, c1, d1 = companion(np.array(error_weight[0], float), np.array(error_weight[1], float))
    at, bt, ct, dt = companion(np.array(output_weight[0], float), np.array(output_weight[1], float))
    if dg != 0.0 or d1 != 0.0:
        raise ValueError("the plant and the error weight must be strictly proper")
    if max(np.linalg.eigvals(part).real.max(initial=-np.inf) for part in (ag, a1, at)) >= 0.0:
        raise ValueError("the plant and the weights must be stable")
    n, n1, nt = len(ag), len(a1), len(at)
    a = np.zeros((n + n1 + nt, n + n1 + nt))
    a[:n, :n] = ag
    a[n : n + n1, :n], a[n : n + n1, n : n + n1] = -np.outer(b1, cg), a1
    a[n + n1 :, :n], a[n + n1 :, n + n1 :] = np.outer(bt, cg), at
    first = np.concatenate([np.zeros(n), b1, np.zeros(nt)])[:, None]
    second = np.concatenate([bg, np.zeros(n1 + nt)])[:, None] / control_weight
    outputs = np.zeros((2, len(a)))
    outputs[0, n : n + n1] = c1
    outputs[1, :n], outputs[1, n + n1 :] = dt * cg, ct
    return _System(a, first, second, outputs, np.concatenate([-cg, np.zeros(n1 + nt)])[None])


def _central(s: _System, gamma: float) -> StateSpace | None:
    """Return the central controller at a norm, or None where none exists.

    The setpoint is the only disturbance, it is measured (D21 = 1), and A − B1 C2 has the poles of plant and weights, which
    are stable: so the filter's Riccati equation has the solution Y = 0, hence H2 = −B1, Z = 1 and the controller
    ẋ = (A + B2 F2 − B1 C2) x + B1 e, u = F2 x.
    """
    from scipy.linalg import solve_continuous_are

    b = np.hstack([s.b1, s.b2])
    weight = np.diag([-(gamma**2), 1.0])
    try:
        x = solve_continuous_are(s.a, b, s.c1.T @ s.c1, weight)
    except (np.linalg.LinAlgError, ValueError):
        return None
    if np.linalg.eigvalsh(0.5 * (x + x.T)).min() < -1e-7 * max(np.abs(x).max(), 1.0):
        return None
    f = -np.linalg.solve(weight, b.T @ x)
    controller = StateSpace(s.a + s.b2 @ f[1:2] - s.b1 @ s.c2, s.b1, f[1:2])
    return controller if _stable(s, controller) else None


def _stable(s: _System, controller: StateSpace) -> bool:
    top = np.hstack([s.a, s.b2 @ controller.c])
    bottom = np.hstack([controller.b @ s.c2, controller.a])
    return bool(np.linalg.eigvals(np.vstack([top, bottom])).real.max() < 0.0)


def rolled_off(controller: StateSpace, corner: float) -> StateSpace:
    """Return the controller with another pole at `corner` (rad/s): the reshaping at high frequencies."""
    n = len(controller.a)
    a = np.zeros((n + 1, n + 1))
    a[:n, :n] = controller.a
    a[n, :n], a[n, n] = corner * controller.c[0], -corner
    return StateSpace(a, np.vstack([controller.b, [[0.0]]]), np.concatenate([np.zeros(n), [1.0]])[None])
