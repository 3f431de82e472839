"""Closed loops that nobody can mean: they grow by themselves, stand elsewhere than their setpoint, or follow seconds behind it.

The loops are simulated as they are given; these warnings change nothing. A loop z⁺ = A z + B0 r[k] + B1 r[k+1], x = C z + D r has the
transfer function G(z) = C (z I − A)⁻¹ (B0 + z B1) + D. Over a setpoint that stands it settles at G(1) = C (I − A)⁻¹ (B0 + B1) + D. How far it
falls behind a setpoint of constant velocity follows from powers of the transition of the states, the setpoint and its step.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator

import numpy as np

from cncgen.diagnostics import Diagnostic, RemarkWarning, Severity
from cncgen.servo.loop import AxisLoop
from cncgen.servo.scheme import Scheme, SchemeMaker

#: Poles whose growth in a control period is no more are on the unit circle but for rounding (a double eigenvalue keeps half the digits).
LEAST_GROWTH = 1e-7
#: Drives of machines stay 5 to 100 ms behind their setpoints (velocity gains of 10 to 200 1/s).
LONGEST_LAG_S = 1.0
#: Constant velocity for so long shows the lag. A gain that is wrong by less than `LEAST_MISS` adds less than `LONGEST_LAG_S` in it.
RAMP_S = 90.0
#: A loop that ends so far from its setpoint, as a part of it, has a wrong gain.
LEAST_MISS = 0.01


def telling(maker: SchemeMaker) -> SchemeMaker:
    """Return a maker of schemes that tells the doubts of the scheme that it makes, as `RemarkWarning`."""

    def made(axes: str, period_s: float) -> Scheme:
        scheme = maker(axes, period_s)
        # Coupled axes are stable, or not, together.
        for letter, loop in zip(axes, scheme.loops if scheme.coupling is None else (), strict=False):
            for doubt in doubts(loop, letter):
                warnings.warn(RemarkWarning(doubt), stacklevel=2)
        return scheme

    return made


def doubts(loop: AxisLoop, letter: str) -> Iterator[Diagnostic]:
    """Yield what is implausible of the closed loop of an axis."""
    poles = loop.poles()
    worst = poles[np.abs(poles).argmax()] if len(poles) else 0.0
    growth = math.log(abs(worst)) if abs(worst) > 0.0 else -math.inf
    if growth > LEAST_GROWTH:
        yield _unstable(letter, complex(worst), loop.period)
        return
    settled = _settled(loop)
    if abs(settled - 1.0) > LEAST_MISS:
        yield _remark(
            "servo-gain",
            f"axis {letter} comes to rest at {settled:.4g} times the way of its setpoints",
            "of a transfer function the last coefficients of numerator and denominator are to be equal",
            gain=settled,
        )
    elif (lag_s := _lag_s(loop)) > LONGEST_LAG_S:
        yield _remark(
            "servo-lag",
            f"axis {letter} falls {lag_s:.3g} s behind setpoints of constant velocity: {100.0 * lag_s:.4g} mm at 100 mm/s",
            "drives stay some 5 to 100 ms behind; are gains in 1/s and time constants in s?",
            lag_s=lag_s,
        )


def _settled(loop: AxisLoop) -> float:
    """Return G(1); 1 of a loop that never settles."""
    matrix, now, after = loop.transition()
    to_rest = np.eye(len(matrix)) - matrix
    if not len(matrix) or np.linalg.cond(to_rest) > 1e12:
        return 1.0
    return float(loop.output @ np.linalg.solve(to_rest, now + after)) + loop.feedthrough


def _lag_s(loop: AxisLoop) -> float:
    """Return how far the axis is behind setpoints of constant velocity at most, s: 1, 2, 4 … periods after it begins, up to `RAMP_S`."""
    matrix, now, after = loop.transition()
    count = len(matrix)
    # z, the setpoint r and its step d = T v: z⁺ = A z + B0 r + B1 (r + d), r⁺ = r + d; v = 1.
    power = np.eye(count + 2)
    power[:count] = np.column_stack([matrix, now + after, after])
    power[count, count + 1] = 1.0
    ahead = np.append(-loop.output, [1.0 - loop.feedthrough, 0.0])
    longest, periods = 0.0, 1
    while periods * loop.period <= RAMP_S:
        longest = max(longest, float(ahead @ power[:, -1]) * loop.period)
        power, periods = power @ power, 2 * periods
    return longest


def _unstable(letter: str, pole: complex, period: float) -> Diagnostic:
    growth_s = period / math.log(abs(pole))
    turn_hz = abs(math.atan2(pole.imag, pole.real)) / (2.0 * math.pi * period)
    turning = f", {turn_hz:.4g} Hz" if turn_hz > 0.0 else ""
    return _remark(
        "servo-unstable",
        f"the closed loop of axis {letter} is unstable: its pole at {1.0 / growth_s:+.4g} 1/s{turning} grows by a factor of e "
        f"every {growth_s:.4g} s",
        "of a transfer function look at the signs of the denominator; else lower the gains",
        pole_1_s=1.0 / growth_s,
        pole_hz=turn_hz,
        growth_s=growth_s,
    )


def _remark(code: str, message: str, hint: str, **values: float) -> Diagnostic:
    return Diagnostic(code, message, severity=Severity.WARNING, hint=hint, values=values)
