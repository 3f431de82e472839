"""Where setpoints stand still, to find the waits (dwells) of the program in them; used by `matching`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Largest step between setpoints, mm or degrees, that counts as standing still: two units of the ninth decimal.
_STILL = 2e-9
#: A stand counts for a place if it lies within this many rows (two a period) of the row that is nearest to the place.
_NEAR = 4
#: Periods by which a stand may appear shorter than it is, as it begins and ends between ticks; and rounding.
BETWEEN_TICKS = 2.0 + 1e-6


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


@dataclass(frozen=True, slots=True)
class Passed:
    """A place of the path that the setpoints go past.

    Attributes:
        place: Shape (axes,), mm and degrees.
        row: The row that is nearest to it.
        first, last: Rows between which the place can be matched.
        near: Largest distance from the place, mm, at which a stand counts as one there.
    """

    place: Floats
    row: int
    first: int
    last: int
    near: float


@dataclass(slots=True)
class _Stand:
    """A run of rows without a step.

    Attributes:
        first, last: Rows.
        place: Shape (axes,), mm and degrees.
        taken: Periods of it that waits have been found to be.
    """

    first: int
    last: int
    place: Floats
    taken: float = 0.0

    @property
    def left(self) -> float:
        """Return for how many periods it stands beside what has been taken."""
        return max(0.5 * (self.last - self.first) - self.taken, 0.0)


class Stands:
    """Runs of rows without a step, two rows being a period, and which of them waits are.

    A wait is where its place on the path is passed nearest, or another time as near, as a path that folds within its
    tolerance may be. Waits come in order, and so do their stands; each belongs to one alone.
    """

    def __init__(self, still_mm: float = 0.0) -> None:
        """Begin; `still_mm` is how far rounding may move what stands."""
        self._still = _STILL + 2.0 * still_mm
        self._stands: list[_Stand] = []
        self._count = 0
        #: The stand of the wait before, how much of it that is, and the row from which that was looked for.
        self._before: tuple[_Stand | None, float, int] = (None, 0.0, -1)

    def feed(self, rows: Floats, before: Floats) -> None:
        """Add rows, of which the first one comes after `before`, shape (1, axes)."""
        steps = np.abs(np.diff(np.concatenate([before, rows]), axis=0)).max(axis=1)
        still = np.concatenate([[False], steps <= self._still, [False]])
        edges = np.flatnonzero(np.diff(still.astype(np.int8)))
        # Row k stands with the one before it where the k-th step does not move.
        for begin, end in edges.reshape(-1, 2).tolist():
            first, last = self._count + begin - 1, self._count + end - 1
            if self._stands and self._stands[-1].last == first:
                self._stands[-1].last = last
            else:
                self._stands.append(_Stand(first, last, rows[end - 1].copy()))
        self._count += len(rows)

    def found(self, asked: float, passed: Passed, again: bool) -> float:
        """Return for how many periods the setpoints stand at a place, and take so many `asked` of them where they are enough.

        Args:
            asked: Periods. A stand between two ticks shows as up to two less.
            passed: Where.
            again: This wait goes on from the one before, and the time asked for is of both.
        """
        if again:
            stand, periods, since = self._before
            if stand is not None:
                stand.taken -= periods
        else:
            since = self._before[0].first if self._before[0] is not None else self._before[2]
        self._before = (None, 0.0, since)
        least, most = asked - BETWEEN_TICKS, 0.0
        for stand in self._stands:
            if stand.first < since or not self._at(stand, passed):
                continue
            most = max(most, stand.left)
            if stand.left >= least:
                stand.taken += max(least, 0.0)
                self._before = (stand, max(least, 0.0), since)
                break
        return most

    def _at(self, stand: _Stand, passed: Passed) -> bool:
        """Tell whether a stand is at a place."""
        if stand.first - _NEAR <= passed.row <= stand.last + _NEAR:
            return True
        if stand.last + _NEAR < passed.first or stand.first - _NEAR > passed.last:
            return False
        return bool(np.linalg.norm(stand.place - passed.place) <= passed.near + self._still)

    def forget(self, row: int) -> None:
        """Drop what ended before a row."""
        self._stands = [stand for stand in self._stands if stand.last + _NEAR >= row]
