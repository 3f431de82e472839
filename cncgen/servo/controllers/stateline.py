"""The stateline: axes that share one line, and hold together whenever one of them would fall behind.

Source: B. K. Jung and W. C. Choi, eqs 2 to 7 and Rule 2, after Yellowley and Pottier (1989, 1994). A master gives
a position every Δt (16 ms); each axis interpolates between them every 0.5 ms (eqs 2 to 4), checks its own error, and pulls
the line low where its rule is broken. While the line is low, all references stand still and the servo loops go on. So the path keeps
its shape and only the time grows.

    eq. 7      |E| ≤ |Kve V⁺| + δ
    Rule 2     |E + Kve (I⁺V⁺ − I V) + Kac (I⁺V⁺ − I V)/(Nf Ts)| ≤ |Kve I⁺V⁺| + δ
    jerk rule  adds Kje ((I⁺⁺V⁺⁺ − I⁺V⁺) − (I V − I⁻V⁻))/(Nf Ts) to the left side

V is an axis's speed in this period, V⁺ and V⁺⁺ in the next ones, I whether the line lets it have that speed: 1 for those to
come (the question is whether they may), and what happened for those that went. For a loop Kv/(s(τs + 1)): Kve = 1/Kv,
Kac = τ/Kv − 1/Kv², Kje = 1/Kv³ − 2τ/Kv² (the coefficients of the ramp, parabola and cubic responses).

Progress. Rules 2 and 3 as printed can hold for ever: with the references frozen E decays to 0, and the rest of the left side
may still exceed the right. Here an axis only pulls the line while |E| > δ, that is while waiting can help. Held loops are
stable, so |E| ≤ δ comes, the line rises, and the reference advances: no deadlock for any path and any gains with δ > 0. A
bound on the wait (`patience`) covers what no linear loop would do, and is counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import servo_stateline
from cncgen.servo.discretise import held

Floats = NDArray[np.float64]


class Rule(IntEnum):
    """Error criterion of each axis."""

    NONE = 0
    ERROR = 1
    RULE_2 = 2
    JERK = 3


@dataclass(frozen=True, slots=True)
class StatelineAxis:
    """P control with gain Kv (1/s) round a velocity loop of lag τ (s)."""

    gain: float
    lag: float

    @property
    def error_gains(self) -> tuple[float, float, float]:
        """Return Kve (s), Kac (s²) and Kje (s³): the error at constant speed, acceleration and jerk."""
        k, tau = self.gain, self.lag
        return 1.0 / k, tau / k - 1.0 / k**2, 1.0 / k**3 - 2.0 * tau / k**2


@dataclass(frozen=True, slots=True)
class StatelineRun:
    """Results of a run: positions (n, axes) and reference index (n,) a control period, periods held, forced steps."""

    position: Floats
    place: NDArray[np.int64]
    period: float
    held: int
    forced: int

    @property
    def time_s(self) -> float:
        """Return how long it took."""
        return len(self.position) * self.period


def run_stateline(
    reference: Floats,
    axes: Sequence[StatelineAxis],
    rule: Rule,
    static_bound: float,
    *,
    period: float = 0.0005,
    spread: float = 0.016,
    patience_s: float = 10.0,
) -> StatelineRun:
    """Follow a reference under a stateline.

    Args:
        reference: Shape (n, axes), mm, one row a control period.
        axes: The servo loops.
        rule: The check of each axis.
        static_bound: δ, mm.
        period: Control period Ts, s.
        spread: Nf Ts, the time that a change of speed is spread over, s (the master's period).
        patience_s: The line may be low so long before a step is forced.

    Raises:
        ValueError: δ is not positive where a rule is on: waiting then need not end.
    """
    if rule is not Rule.NONE and not static_bound > 0.0:
        raise ValueError("the static bound must be positive, or an axis at rest would hold the line for ever")
    steps = [_step(axis, period) for axis in axes]
    gains = np.array([[*axis.error_gains, static_bound, spread] for axis in axes], float)
    settle = int(np.ceil(30.0 * max(1.0 / a.gain + a.lag for a in axes) / period))
    patience = int(np.ceil(patience_s / period))
    room = 2 * len(reference) + settle
    while True:
        position, place = np.empty((room, len(axes))), np.zeros(room, np.int64)
        counts = np.zeros(2, np.int64)
        taken = servo_stateline.run(
            np.ascontiguousarray(reference, float),
            np.array([phi for phi, _ in steps]),
            np.array([gamma for _, gamma in steps]),
            np.array([axis.gain for axis in axes], float),
            gains,
            int(rule),
            period,
            patience,
            np.column_stack([reference[0], np.zeros(len(axes))]),
            position,
            place,
            counts,
        )
        if taken >= 0:
            return StatelineRun(position[:taken], place[:taken], period, int(counts[0]), int(counts[1]))
        if room > (patience + 2) * len(reference) + settle:
            raise ValueError("the axes do not settle: a loop is unstable")
        room *= 2


def _step(axis: StatelineAxis, period: float) -> tuple[Floats, Floats]:
    a = np.array([[0.0, 1.0], [0.0, -1.0 / axis.lag]])
    phi, gamma = held(a, np.array([[0.0], [1.0 / axis.lag]]), period)
    return phi, gamma[:, 0]
