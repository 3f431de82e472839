"""A safe excitation: a sine swept through a band of frequencies, within the limits of an axis."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine.record import Axis

Floats = NDArray[np.float64]

#: The ninth decimal of setpoints, mm or rad; less would not be seen in them.
LEAST_AMPLITUDE = 1e-9

#: Power of the smooth minimum of amplitudes.
SMOOTH = 4.0


def swept_sine(
    axis: Axis,
    period_s: float,
    *,
    duration_s: float = 20.0,
    low_hz: float = 0.5,
    high_hz: float = 100.0,
    amplitude: float = 10.0,
    share: float = 0.8,
    center: float = 0.0,
) -> Floats:
    """Return positions of a logarithmic sweep, shape (n,), at rest at both ends.

    Its phase is ω1 (eʳᵗ − 1)/r with r = ln(ω2/ω1)/duration: A. Farina, Simultaneous measurement of impulse response and
    distortion with a swept-sine technique, 108th AES Convention, Paris (2000).
    The amplitude at a frequency is the largest that keeps within `amplitude`, V/ω, A/ω² and J/ω³; the whole is scaled so
    that its finite differences reach `share` of no limit more than once. Ends swell from and fade to nothing over a
    twentieth of the time each.

    Args:
        axis: Its limits, mm or rad.
        period_s: s.
        duration_s: s.
        low_hz, high_hz: Band.
        amplitude: Largest swing either side, mm or rad.
        share: Of each limit.
        center: Where the axis swings about; the sweep starts and ends there.

    Raises:
        UsageError: The band or share makes no sense (``excite-band``), or the swing leaves the travel
            (``excite-travel``).
    """
    if not (0.0 < low_hz < high_hz < 0.5 / period_s):
        raise _fault(
            "excite-band",
            f"the band {low_hz:g} to {high_hz:g} Hz must rise and end below {0.5 / period_s:g} Hz",
        )
    for what, value, holds, wanted in (
        ("share", share, 0.0 < share <= 1.0, "more than 0 and at most 1"),
        (
            "amplitude",
            amplitude,
            LEAST_AMPLITUDE <= amplitude < math.inf,
            f"at least {LEAST_AMPLITUDE:g} and finite",
        ),
        ("centre", center, math.isfinite(center), "finite"),
    ):
        if not holds:
            raise _fault("excite-band", f"the {what} is {value:g}; it must be {wanted}")
    if not duration_s * low_hz >= 1.0:
        raise _fault("excite-band", f"one period of {low_hz:g} Hz does not fit into {duration_s:g} s")
    t = np.arange(0.0, duration_s + 0.5 * period_s, period_s)
    rate = math.log(high_hz / low_hz) / duration_s
    omega = 2.0 * math.pi * low_hz * np.exp(rate * t)
    phase = (omega - omega[0]) / rate
    limits = axis.max_velocity / omega, axis.max_acceleration / omega**2, axis.max_jerk / omega**3
    # A smooth minimum: where one limit took over from another with a kink, the jerk would have a peak.
    size = sum(limit**-SMOOTH for limit in (amplitude, *limits)) ** (-1.0 / SMOOTH)
    edge = np.clip(np.minimum(t, t[-1] - t) / (0.05 * duration_s), 0.0, 1.0)
    x = size * np.sin(phase) * edge**3 * (10.0 - 15.0 * edge + 6.0 * edge**2)
    x *= share * _room(x, axis, period_s, amplitude / share)
    if not (swing := float(np.abs(x).max())) >= LEAST_AMPLITUDE:
        raise _fault(
            "excite-band",
            f"a share of {share:g} of the limits leaves a swing of {swing:g}; it must be at least {LEAST_AMPLITUDE:g}",
        )
    if axis.travel is not None and (center + x.min() < axis.travel[0] or center + x.max() > axis.travel[1]):
        low, high = axis.travel
        raise _fault(
            "excite-travel",
            f"the swing from {center + x.min():g} to {center + x.max():g} leaves {low:g} to {high:g}",
        )
    return center + x


def _room(x: Floats, axis: Axis, period_s: float, amplitude: float) -> float:
    """Return the factor that brings positions to the nearest limit, by finite differences from rest to rest."""
    padded = np.concatenate([np.zeros(3), x, np.zeros(3)])
    peaks = [np.abs(np.diff(padded, n)).max() / period_s**n for n in (1, 2, 3)]
    limits = axis.max_velocity, axis.max_acceleration, axis.max_jerk
    return min(
        amplitude / np.abs(x).max(), *(limit / peak for limit, peak in zip(limits, peaks, strict=True))
    )


def _fault(code: str, message: str) -> UsageError:
    return UsageError(Diagnostic(code, message))
