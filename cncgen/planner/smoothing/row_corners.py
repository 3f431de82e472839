"""The corners between rows that may be smoothed (`RowCorners`). `stream` makes them; `tolerance_estimate` and `rounding_decision`
take them, with the limits of the machine as mm (`AxisLimits.in_mm`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: Largest |x''| L and |x'''| L² of a turn by 1 that is smoothed with the length L (docs/smoothing.md).
BEND, TWIST = 1.0 / 3.0, 0.1475


@dataclass(frozen=True, slots=True)
class RowCorners:
    """The n places where consecutive rows that may be smoothed meet.

    Attributes:
        leave, entry: Shape (n, axes): dx/ds before and after, scaled.
        length, feed: Shape (2, n), mm and mm/s: of the row before and of the row after.
        tolerance: Shape (n,), P, mm.
        joined: Shape (n,): whether the two rows are in one run.
        bend: Shape (2, n), 1/mm: largest curvature of the row before and of the row after.
    """

    leave: Floats
    entry: Floats
    length: Floats
    feed: Floats
    tolerance: Floats
    joined: Bools
    bend: Floats
