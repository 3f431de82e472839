"""Velocity feedforward round any closed loop: r + eᵥ ṙ cancels the lag at constant velocity.

Source: Y. Koren and C. C. Lo, Advanced controllers for feed drives, Annals of the CIRP 41 (1992) 689 (feedforward controllers).
Of a loop H(z) from setpoint to position the error at constant velocity v is eᵥ v with eᵥ = T (A'(1) − B'(1))/A(1), H = B/A:
1/Kv of a P loop. The error of acceleration remains.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.frequency import ratio_in_z
from cncgen.servo.loop import AxisLoop
from cncgen.servo.stream import SampleBlock

Floats = NDArray[np.float64]


def velocity_error(loop: AxisLoop, parts: int = 1) -> float:
    """Return eᵥ, s, of a loop with that many control periods a setpoint.

    Raises:
        ValueError: The loop does not reach its setpoint at rest.
    """
    above, below = ratio_in_z(loop, parts)
    size = float(below.sum())
    if not (abs(size) > 0.0 and abs(above.sum() - size) <= 1e-6 * abs(size)):
        raise ValueError("the loop does not reach its setpoint at rest: its error at constant velocity grows")
    slope = float(np.polyval(np.polyder(below), 1.0) - np.polyval(np.polyder(above), 1.0))
    return loop.period * parts * slope / size


class Feedforward:
    """The prefilter of all axes (`cncgen.servo.scheme.Prefilter`): eᵥ times the central difference of the setpoints."""

    before, after = 1, 2

    def __init__(self, lags: Sequence[float]) -> None:
        """Take eᵥ of each axis, s."""
        self._lags = np.array(lags, float)

    def started(self) -> Callable[[SampleBlock, Floats], Floats]:
        """Return the filter; it has no memory."""

        def over(block: SampleBlock, origin: Floats) -> Floats:
            first, last = block.before, block.before + len(block) + 1
            at, later, earlier = (block.values[first + k : last + k] for k in (0, 1, -1))
            shaped: Floats = at - origin + self._lags * (later - earlier) / (2.0 * block.period_s)
            return shaped

        return over
