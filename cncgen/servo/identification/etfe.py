"""The empirical transfer function estimate with its coherence.

Source: L. Ljung, System Identification, 2nd ed., sections 6.3 and 6.4 (spectral analysis, Welch's average over segments);
J. S. Bendat and A. G. Piersol, Random Data, 3rd ed., eq. 9.90 (the relative standard error from the coherence).
Tsai 2010 identifies its X-Y table so, with a sweep of 0.1 to 500 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.identification.fits import checked_log

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class FrequencyResponse:
    """H = S_yu/S_uu at frequencies (Hz), with coherence γ² and the relative standard error of |H|."""

    frequency_hz: Floats
    response: NDArray[np.complex128]
    coherence: Floats
    relative_error: Floats


def etfe(drive: Floats, output: Floats, period_s: float, segments: int = 8) -> FrequencyResponse:
    """Estimate the response from drive to output.

    Args:
        drive, output: Shape (n,).
        period_s: s.
        segments: The record is cut into about so many Hann-windowed segments that overlap by half.

    Raises:
        ValueError: `checked_log` refuses it, or it is too short for the segments.
    """
    from scipy.signal import coherence, csd, welch

    drive, output = checked_log(drive, output, period_s)
    length = 2 * len(drive) // (segments + 1)
    if length < 32:
        raise ValueError(f"{len(drive)} samples are too few for {segments} segments")
    options = {"fs": 1.0 / period_s, "nperseg": length, "detrend": "linear"}
    frequency, power = welch(drive, **options)
    _, cross = csd(drive, output, **options)
    _, gamma = coherence(drive, output, **options)
    excited = (frequency > 0.0) & (power > 1e-12 * power.max())
    gamma = np.clip(gamma[excited], 1e-12, 1.0)
    averages = max(1, 2 * len(drive) // length - 1)
    error = np.sqrt((1.0 - gamma) / (2.0 * averages * gamma))
    return FrequencyResponse(frequency[excited], cross[excited] / power[excited], gamma, error)
