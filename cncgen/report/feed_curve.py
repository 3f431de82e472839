"""The feed over a whole plan in a few numbers, gathered while setpoints stream, and as a line of block characters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Numbers that a curve has at most; at least half of them where there are as many setpoints.
BINS = 64
_BLOCKS = "▁▂▃▄▅▆▇█"


class FeedCurve:
    """Mean feed along X Y Z (else U V W) over equal times, of setpoints that come chunk by chunk.

    A bin holds a power of two of periods: where `BINS` are full, pairs are joined, so that the memory is fixed.

    Args:
        columns: Of the axes that the feed is of.
        period_s: Time between setpoints.
    """

    def __init__(self, columns: Sequence[int], period_s: float) -> None:
        self._columns, self._period = list(columns), period_s
        self._length = np.zeros(BINS)
        self._each = 1
        self._count = 0
        self._last: Floats | None = None

    def add(self, position: Floats) -> None:
        """Take the next rows of setpoints, shape (n, axes), mm."""
        rows = position[:, self._columns]
        if self._last is not None:
            rows = np.concatenate([self._last, rows])
        self._last = rows[-1:].copy()
        steps = np.sqrt((np.diff(rows, axis=0) ** 2).sum(axis=1))
        if not len(steps):
            return
        while self._count + len(steps) > BINS * self._each:
            self._length = np.append(self._length.reshape(-1, 2).sum(axis=1), np.zeros(BINS // 2))
            self._each *= 2
        at = (self._count + np.arange(len(steps))) // self._each
        self._length += np.bincount(at, weights=steps, minlength=BINS)
        self._count += len(steps)

    def feeds_mm_s(self) -> list[float]:
        """Return the mean feed of each bin that a motion came to, in order, mm/s."""
        used = -(-self._count // self._each)
        periods = np.minimum(self._each, self._count - self._each * np.arange(used))
        feeds: list[float] = (self._length[:used] / (periods * self._period)).tolist()
        return feeds


def sparkline(values: Sequence[float]) -> str:
    """Return values as a line of blocks: the lowest block is 0, the full one the largest value."""
    top = max(values, default=0.0)
    if top <= 0.0:
        return ""
    return "".join(_BLOCKS[min(int(len(_BLOCKS) * value / top), len(_BLOCKS) - 1)] for value in values)
