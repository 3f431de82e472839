"""The true contour error: the distance of a position from the commanded path, and not from the commanded point.

The path is the polyline through the setpoints (a drive that interpolates between setpoints goes along it; it leaves
the programmed curve by the chord error at most). The search starts at the commanded point and goes both ways along the path, as far as
`REACH` times the tracking error. Further away, the path belongs to another place of the part that happens to be near.
docs/contour-error.md has the derivation. It is the distance of the numerical method of Tsai (2010), section 6.1 and Fig. 3, who drops
a perpendicular onto the commanded path. At a corner or an end without perpendicular it is the distance to the nearest point.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import servo_contour

Floats = NDArray[np.float64]

#: How many times the tracking error the search goes along the path. The nearest point is at most twice as far from the
#: commanded point as the position is; the rest allows for the path's bends.
REACH = 3.0
#: Setpoints that the search sees ahead, for positions that lead the command.
AHEAD = 256
#: Setpoints that are kept of the path behind.
BEHIND = 65536


class ContourTracker:
    """Contour errors of a stream, chunk by chunk: `push` rows, draw distances, `finish` at the end."""

    def __init__(self, axes: int) -> None:
        self._path = np.empty((0, axes))
        self._arc = np.empty(0)
        self._own = np.empty(0, np.int64)
        self._position = np.empty((0, axes))

    def push(self, command: Floats, position: Floats) -> Floats:
        """Add rows of commanded and actual position, shape (n, axes); return the distances known by now, in order."""
        self._extend(command)
        self._position = np.concatenate([self._position, position])
        return self._measure(len(self._position) - AHEAD, final=False)

    def finish(self) -> Floats:
        """Return the distances of the rows that still wait."""
        return self._measure(len(self._position), final=True)

    def _extend(self, command: Floats) -> None:
        if not len(command):
            return
        joined = np.concatenate([self._path[-1:], command])
        steps = np.sqrt((np.diff(joined, axis=0) ** 2).sum(axis=1))
        moved = steps > 0.0
        if not len(self._path):
            moved = np.concatenate([[True], moved])
            steps = np.concatenate([[0.0], steps])
        base = self._arc[-1] if len(self._arc) else 0.0
        own = len(self._path) - 1 + np.cumsum(moved)
        self._path = np.concatenate([self._path, command[moved]])
        self._arc = np.concatenate([self._arc, base + np.cumsum(steps)[moved]])
        self._own = np.concatenate([self._own, own])

    def _measure(self, count: int, final: bool) -> Floats:
        if count <= 0:
            return np.empty(0)
        own = self._own[:count]
        beyond = np.minimum(np.arange(count) + AHEAD, len(self._own) - 1)
        result = np.empty(count)
        servo_contour.distances(
            np.ascontiguousarray(self._path),
            np.ascontiguousarray(self._arc),
            np.ascontiguousarray(own),
            np.ascontiguousarray(self._own[beyond]),
            np.ascontiguousarray(self._position[:count]),
            REACH,
            result,
            np.empty((0, self._path.shape[1])),
        )
        self._own, self._position = self._own[count:], self._position[count:]
        self._forget()
        return result

    def _forget(self) -> None:
        """Drop the path that no position can reach any more."""
        oldest = (self._own[0] if len(self._own) else len(self._path) - 1) - BEHIND
        if oldest > BEHIND:
            self._path, self._own = self._path[oldest:], self._own - oldest
            self._arc = self._arc[oldest:] - self._arc[oldest]


def contour_error(command: Floats, position: Floats) -> Floats:
    """Return the contour error of whole arrays, shape (n, axes) each: shape (n,)."""
    tracker = ContourTracker(command.shape[1])
    return np.concatenate([tracker.push(command, position), tracker.finish()])


def nearest_on_path(command: Floats, position: Floats) -> Floats:
    """Return the places on the path that `contour_error` measures from, shape (n, axes) as both arguments."""
    steps = np.sqrt((np.diff(command, axis=0) ** 2).sum(axis=1))
    moved = np.concatenate([[True], steps > 0.0])
    own = np.cumsum(moved) - 1
    ahead = own[np.minimum(np.arange(len(own)) + AHEAD, len(own) - 1)]
    arc = np.concatenate([[0.0], np.cumsum(steps)])[moved]
    feet = np.empty(command.shape)
    servo_contour.distances(
        np.ascontiguousarray(command[moved]), arc, own, ahead, np.ascontiguousarray(position), REACH,
        np.empty(len(command)), feet,
    )  # fmt: skip
    return feet
