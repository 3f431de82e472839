"""Peaks of finite differences of a setpoint stream, chunk by chunk, with rest before the first and after the last."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class DifferencePeaks:
    """Largest first, second and third finite differences of each axis, by the period.

    Attributes:
        samples: Rows seen.
        peak: Shape (3, axes): velocity, acceleration and jerk, in the unit of the positions.
    """

    def __init__(self, axes: int, period_s: float) -> None:
        self.samples = 0
        self.peak = np.zeros((3, axes))
        self._period_s = period_s
        self._tail: Floats | None = None

    def add(self, position: Floats) -> None:
        """Take the rows of a chunk, shape (n, axes)."""
        if not len(position):
            return
        before = np.repeat(position[:1], 3, axis=0) if self._tail is None else self._tail
        rows = np.concatenate([before, position])
        self._measure(rows)
        self._tail = rows[-3:]
        self.samples += len(position)

    def finish(self) -> None:
        """Take the rest after the last row."""
        if self._tail is not None:
            self._measure(np.concatenate([self._tail, np.repeat(self._tail[-1:], 3, axis=0)]))

    def _measure(self, rows: Floats) -> None:
        # An axis a row: numpy takes differences and maxima along long rows ten times as fast as across them.
        difference = np.ascontiguousarray(rows.T)
        for order in range(3):
            difference = difference[:, 1:] - difference[:, :-1]
            # From zero, since the opposite of zero is -0, which an axis that stands would show.
            size = np.maximum(difference.max(axis=1), 0.0 - difference.min(axis=1))
            np.maximum(self.peak[order], size / self._period_s ** (order + 1), out=self.peak[order])
