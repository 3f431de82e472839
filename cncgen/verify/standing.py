"""Where setpoints stand still, so that a wait of the program can be found again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: mm and degrees: a step up to it is none.
_STILL = 2e-9
#: Rows (two a period) on either side of the nearest one in which a stand counts for a place.
_NEAR = 4


@dataclass(frozen=True, slots=True)
class Wait:
    """A wait of the program that the setpoints do not make.

    Attributes:
        line: Source line.
        asked, found: Periods.
        time: When, in periods.
    """

    line: int
    asked: float
    found: float
    time: float


class Stands:
    """Runs of rows without a step, as first and last row; two rows are a period."""

    def __init__(self, still_mm: float = 0.0) -> None:
        """Begin; `still_mm` is how far rounding may move what stands."""
        self._still = _STILL + 2.0 * still_mm
        self._runs: list[tuple[int, int]] = []
        self._count = 0

    def feed(self, rows: Floats, before: Floats) -> None:
        """Add rows, of which the first one comes after `before`, shape (1, axes)."""
        steps = np.abs(np.diff(np.concatenate([before, rows]), axis=0)).max(axis=1)
        still = np.concatenate([[False], steps <= self._still, [False]])
        edges = np.flatnonzero(np.diff(still.astype(np.int8)))
        # Row k stands with the one before it where the k-th step is none.
        for begin, end in edges.reshape(-1, 2).tolist():
            first, last = self._count + begin - 1, self._count + end - 1
            if self._runs and self._runs[-1][1] == first:
                first = self._runs.pop()[0]
            self._runs.append((first, last))
        self._count += len(rows)

    def longest(self, row: int) -> float:
        """Return for how many periods the setpoints stand at a row, or near it."""
        near = [last - first for first, last in self._runs if first - _NEAR <= row <= last + _NEAR]
        return 0.5 * max(near, default=0)

    def forget(self, row: int) -> None:
        """Drop what ended before a row."""
        self._runs = [run for run in self._runs if run[1] + _NEAR >= row]
