"""Input shaping: a command that is a few copies of the motion, one after the other, whose vibrations cancel.

A shaper is a row of impulses A_i at times t_i with Σ A_i = 1, all positive. A mode of natural frequency ω and damping ζ has the pole
s = −ζω + iω√(1 − ζ²), and its residual vibration after a shaped command is |Σ A_i e^(−s t_i)| of that after the command itself.
With Td = 2π/(ω√(1 − ζ²)) and D(τ) = e^(−ζωτ), the share by which a copy τ later has to be smaller:

    zv    1, D at 0, Td/2                            no vibration (O. J. M. Smith 1957; N. C. Singer and W. P. Seering 1990)
    zvd   1, 2D, D² at 0, Td/2, Td                   no derivative by ω either (Singer and Seering 1990)
    ei    (1 + V)/4, (1 − V)D/2, (1 + V)D²/4         V = 5 % at ω, none on either side (W. Singhose, W. Seering and N. Singer 1994)
    mzv   a, √2 a D, a D² at 0, 3 Td/8, 3 Td/4       no vibration, shorter than zvd: the weights follow from Σ A_i e^(−s t_i) = 0

each row divided by its sum. Shapers of several modes are convolved. Since the weights are positive and their sum is 1, the
shaped command keeps every limit of velocity, acceleration and jerk that the motion keeps.

Setpoints stand at multiples of the period. An impulse between two of them is divided between them. The shares are then changed by the
least amount that makes Σ A_i e^(−s t_i) equal to that of the impulses at their own times.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.arguments import wrong
from cncgen.geometry.contour_distance import contour_error
from cncgen.servo.simulate import contour_axes
from cncgen.setpoints.record import Setpoints

Floats = NDArray[np.float64]

#: V of the extra-insensitive shaper.
TOLERABLE = 0.05
SHAPERS = ("zv", "zvd", "ei", "mzv")
#: Setpoints that a shaper lasts at most. Shaping takes as many operations for each setpoint, and each mode of a machine is over sooner.
LONGEST_SHAPER = 100_000
#: Weights may be below 0 by this, from rounding.
_ROUNDING = 1e-12


@dataclass(frozen=True, slots=True)
class Mode:
    """A vibration: natural frequency, Hz, and damping, from 0 to below 1."""

    frequency_hz: float
    damping: float

    @property
    def pole(self) -> complex:
        """Return s = −ζω + iω√(1 − ζ²), 1/s."""
        omega = 2.0 * math.pi * self.frequency_hz
        return complex(-self.damping * omega, omega * math.sqrt(1.0 - self.damping**2))


@dataclass(frozen=True, slots=True)
class Impulses:
    """Weights and times, s, of a shaper; shape (n,) both."""

    weights: Floats
    times: Floats

    def residual(self, mode: Mode) -> float:
        """Return which share of its vibration is left to a mode: |Σ A_i e^(−s t_i)|, at the time of the first impulse."""
        return float(abs(np.sum(self.weights * np.exp(-mode.pole * self.times))))


def impulses(shaper: str, mode: Mode) -> Impulses:
    """Return the impulses of a shaper for a mode.

    Raises:
        UsageError: The name is unknown, or no mode vibrates so.
    """
    if shaper not in SHAPERS:
        raise wrong(f"no shaper is called {shaper!r}; there are {', '.join(SHAPERS)}")
    if not (mode.frequency_hz > 0.0 and math.isfinite(mode.frequency_hz) and 0.0 <= mode.damping < 1.0):
        raise wrong(f"a mode of {mode.frequency_hz:g} Hz and damping {mode.damping:g} does not vibrate")
    period = 2.0 * math.pi / mode.pole.imag
    shares = {
        "zv": ([1.0, 1.0], 1 / 2),
        "zvd": ([1.0, 2.0, 1.0], 1 / 2),
        "ei": ([(1.0 + TOLERABLE) / 4.0, (1.0 - TOLERABLE) / 2.0, (1.0 + TOLERABLE) / 4.0], 1 / 2),
        "mzv": ([1.0, math.sqrt(2.0), 1.0], 3 / 8),
    }
    plain, spacing = shares[shaper]
    times = spacing * period * np.arange(len(plain))
    weights = np.asarray(np.array(plain) * np.exp(mode.pole.real * times), np.float64)
    return Impulses(np.asarray(weights / weights.sum(), np.float64), np.asarray(times, np.float64))


def taps(shaper: str, modes: Sequence[Mode], period_s: float) -> Floats:
    """Return a shaper of several modes at the setpoints' period, shape (n,): u[k] = Σ taps[i] y[k − i].

    Raises:
        UsageError: As `impulses`; a mode is beyond a quarter of the setpoints' frequency; or the shaper lasts longer than
            `LONGEST_SHAPER` setpoints.
    """
    if not modes:
        raise wrong("a shaper needs a mode: its frequency in Hz and its damping")
    rows = [impulses(shaper, mode) for mode in modes]
    length_s = sum(float(found.times[-1]) for found in rows)
    if length_s > LONGEST_SHAPER * period_s:
        slowest = min(mode.frequency_hz for mode in modes)
        raise wrong(
            f"a {shaper} shaper for {slowest:g} Hz lasts {length_s:.4g} s, {length_s / period_s:.4g} setpoints of {1e3 * period_s:g} ms; "
            f"{LONGEST_SHAPER} is the limit",
            "frequencies of --modes are in Hz",
        )
    result = np.ones(1)
    for mode, found in zip(modes, rows, strict=True):
        if mode.frequency_hz * period_s >= 0.25:
            raise wrong(
                f"a mode of {mode.frequency_hz:g} Hz is too fast to be shaped by setpoints every {1e3 * period_s:g} ms: "
                f"{0.25 / period_s:g} Hz is the limit"
            )
        result = np.convolve(result, _at_setpoints(found, mode, period_s))
    return result


def _at_setpoints(found: Impulses, mode: Mode, period_s: float) -> Floats:
    """Return impulses shared out among setpoints, shape (n,), with the same sum and the same Σ A_i e^(−s t_i)."""
    places = found.times / period_s
    whole = np.floor(places + 1e-9).astype(int)
    late = np.clip(places - whole, 0.0, 1.0)
    shared = np.zeros(int(whole[-1]) + 2)
    np.add.at(shared, whole, found.weights * (1.0 - late))
    np.add.at(shared, whole + 1, found.weights * late)
    used = np.flatnonzero(shared > 1e-9)
    grown = np.exp(-mode.pole * period_s * used)
    wanted = complex(np.sum(found.weights * np.exp(-mode.pole * found.times)))
    rows = np.array([np.ones(len(used)), grown.real, grown.imag])
    missing = np.array([1.0, wanted.real, wanted.imag]) - rows @ shared[used]
    correction, *_ = np.linalg.lstsq(rows, missing, rcond=None)
    corrected = shared.copy()
    corrected[used] += correction
    # Where a weight would be negative, limits could be exceeded: then the plain sharing stands.
    good = corrected.min() >= -_ROUNDING
    return np.trim_zeros(np.maximum(corrected, 0.0) if good else shared, "b")


@dataclass(frozen=True, slots=True)
class Shaped:
    """A shaped motion.

    Attributes:
        command: Shape (n + m, axes).
        taps: Of the shaper, shape (m + 1,).
        delay_s: Mean delay of the command.
        path_max_mm, path_rms_mm: How far the command leaves the path of the motion; nan without linear axes.
    """

    command: Floats
    taps: Floats
    delay_s: float
    path_max_mm: float
    path_rms_mm: float

    def as_dict(self, modes: Sequence[Mode], period_s: float) -> dict[str, Any]:
        """Return the shaper and its effect on the path as plain values."""
        linear = not math.isnan(self.path_max_mm)
        return {
            "modes": [{"frequency_hz": mode.frequency_hz, "damping": mode.damping} for mode in modes],
            "impulses": self.taps.tolist(),
            "length_s": (len(self.taps) - 1) * period_s,
            "delay_s": self.delay_s,
            "path_max_mm": self.path_max_mm if linear else None,
            "path_rms_mm": self.path_rms_mm if linear else None,
        }


def shaped_setpoints(
    setpoints: Iterable[Setpoints], shaper: str, modes: Sequence[Mode]
) -> tuple[Setpoints, Shaped]:
    """Return setpoints shaped for modes, and how.

    Raises:
        UsageError: The setpoints are empty, or as `taps`.
    """
    chunks = [chunk for chunk in setpoints if len(chunk)]
    if not chunks:
        raise wrong("there are no setpoints")
    head = chunks[0]
    rows = np.concatenate([np.asarray(chunk.position, float) for chunk in chunks])
    found = shaped(rows, shaper, modes, head.period_s, contour_axes(head.axes))
    return Setpoints(head.axes, head.period_s, 0, found.command), found


def shaped(
    wanted: Floats, shaper: str, modes: Sequence[Mode], period_s: float, columns: Sequence[int]
) -> Shaped:
    """Return a motion shaped for modes.

    Args:
        wanted: Shape (n, axes), at rest at both ends.
        shaper: One of `SHAPERS`.
        modes: At least one.
        period_s: Of the rows.
        columns: The linear axes, whose path is looked at.

    Raises:
        UsageError: As `taps`.
    """
    weights = taps(shaper, modes, period_s)
    more = len(weights) - 1
    whole = np.concatenate(
        [np.repeat(wanted[:1], more, axis=0), wanted, np.repeat(wanted[-1:], more, axis=0)]
    )
    moved = np.column_stack([np.convolve(column, weights, "valid") for column in (whole - wanted[0]).T])
    command = moved + wanted[0]
    delay = float(np.sum(weights * np.arange(len(weights)))) * period_s
    error = np.array([np.nan])
    if columns:
        late = round(delay / period_s)
        held = np.concatenate(
            [np.repeat(wanted[:1], late, axis=0), wanted, np.repeat(wanted[-1:], more - late, axis=0)]
        )
        error = contour_error(held[:, list(columns)], command[:, list(columns)])
    return Shaped(command, weights, delay, float(error.max()), float(np.sqrt((error**2).mean())))
