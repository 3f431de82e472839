"""A controller given as a linear system in s on the error, sampled by Tustin's rule.

Source: K. J. Åström and B. Wittenmark, Computer-Controlled Systems, 3rd ed., section 8.3: s = (2/T)(z − 1)/(z + 1), which preserves
stability, and the response up to a tenth of the sampling frequency.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.controller import Controller

Floats = NDArray[np.float64]


def sampled(a: Floats, b: Floats, c: Floats, d: float, period: float) -> Controller:
    """Return u = (C(sI − A)⁻¹B + D)(r − y) sampled.

    Args:
        a: Shape (n, n).
        b, c: Shape (n,).
        d: Direct gain.
        period: Sampling period, s.
    """
    inverse = np.linalg.inv(np.eye(len(a)) - 0.5 * period * a)
    drive = inverse @ b * period
    gain = d + 0.5 * float(c @ drive)
    return Controller(
        a=inverse @ (np.eye(len(a)) + 0.5 * period * a),
        b_setpoint=drive,
        b_position=-drive,
        c=c @ inverse,
        d_setpoint=gain,
        d_position=-gain,
    )
