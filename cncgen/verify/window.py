"""The part of the programmed path that the matching works on: read as it is needed, then dropped."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from cncgen.verify.flatten import FlatPath, chord_mm

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A distance breaks its tolerance if it exceeds this multiple of it (plus the errors of flattening and rounding).
MARGIN = 1.001

#: At least so many segments are drawn at a time, as far as there are any.
_AT_LEAST = 4096


class MatchWindow:
    """Segments of the path, `m` of them, with what the matching notes at their vertices.

    A segment of no length stands before the path, and one after it, so that the setpoints may stand at either end.

    Attributes:
        points: Shape (m + 1, axes), mm and degrees.
        line: Shape (m,), source lines.
        tolerance: Shape (m,), mm.
        allowed: Shape (m,), mm: the tolerance with its margin.
        wait_s: Shape (m,), how long the axes have to stand at the end.
        distance: Shape (m + 1,), the least distance of each vertex, infinite where it has not been reached.
        at: Shape (m + 1,), the chord that it was reached on.
        during: Shape (m + 1, 2), the first and the last chord on which it can be matched.
        ended: The last segment is the path's last.
        dropped: How many segments have been forgotten.
    """

    def __init__(self, pieces: Iterator[FlatPath], longest: float = np.inf, rounding: float = 0.0) -> None:
        """Begin with the first piece.

        Args:
            pieces: Consecutive stretches of the path, one at least.
            longest: Segments are cut to this length, mm, or to their tolerance where that is more.
            rounding: How far the rounding of positions may move a setpoint, mm.
        """
        first = next(pieces)
        self._parts, self._rounding = _cut(chain((first,), pieces), longest), rounding
        self.points = first.points[:1]
        self.line = np.zeros(0, np.int64)
        self.tolerance = self.allowed = self.wait_s = np.zeros(0)
        self.distance, self.at = np.array([np.inf]), np.zeros(1, np.int64)
        self.during = np.full((1, 2), -1, np.int64)
        self.ended = False
        self.dropped = 0
        self._append(first.points[:1], first.line[:1], first.tolerance[:1], np.zeros(1))
        self.extend()

    def __len__(self) -> int:
        return len(self.line)

    def extend(self) -> bool:
        """Draw more of the path; return False where it has ended before."""
        if self.ended:
            return False
        # Half of the held part again, so that a wide window is not copied for each small piece.
        enough, parts, count = max(_AT_LEAST, len(self) // 2), [], 0
        for part in self._parts:
            parts.append(part)
            count += len(part[1])
            if count >= enough:
                break
        else:
            points, line, tolerance, _ = (
                parts[-1] if parts else (self.points, self.line, self.tolerance, None)
            )
            parts.append((points[-1:], line[-1:], tolerance[-1:], np.zeros(1)))
            self.ended = True
        points, line, tolerance, wait_s = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        self._append(points, line, tolerance, wait_s)
        return True

    def drop(self, count: int) -> None:
        """Forget the first segments."""
        self.dropped += count
        for name in ("points", "line", "tolerance", "allowed", "wait_s", "distance", "at", "during"):
            setattr(self, name, getattr(self, name)[count:].copy())

    def vertex_allowed(self) -> Floats:
        """Return how far each vertex may be, shape (m + 1,): the wider of its two segments counts."""
        own = self.allowed
        return np.maximum(np.append(own, 0.0), np.insert(own, 0, 0.0))

    def _append(self, points: Floats, line: Ints, tolerance: Floats, wait_s: Floats) -> None:
        count = len(line)
        allowed = tolerance * MARGIN + 2.0 * chord_mm(tolerance) + self._rounding
        self.points = np.ascontiguousarray(np.concatenate([self.points, points]))
        self.line = np.concatenate([self.line, line])
        self.tolerance = np.concatenate([self.tolerance, tolerance])
        self.allowed = np.concatenate([self.allowed, allowed])
        self.wait_s = np.concatenate([self.wait_s, wait_s])
        self.distance = np.concatenate([self.distance, np.full(count, np.inf)])
        self.at = np.concatenate([self.at, np.zeros(count, np.int64)])
        self.during = np.concatenate([self.during, np.full((count, 2), -1, np.int64)])


def _cut(pieces: Iterable[FlatPath], longest: float) -> Iterator[tuple[Floats, Ints, Floats, Floats]]:
    """Cut segments to a length; yield ends, lines, tolerances and waits of some of the parts at a time."""
    for piece in pieces:
        lengths = np.linalg.norm(np.diff(piece.points, axis=0), axis=1)
        parts = np.maximum(np.ceil(lengths / np.maximum(longest, piece.tolerance)), 1).astype(np.int64)
        upto = np.cumsum(parts)
        for first in range(0, int(upto[-1]), _AT_LEAST):
            index = np.arange(first, min(first + _AT_LEAST, upto[-1]))
            owner = np.searchsorted(upto, index, side="right")
            f = ((index - upto[owner] + parts[owner] + 1) / parts[owner])[:, None]
            begin, end = piece.points[:-1][owner], piece.points[1:][owner]
            points = np.where(f == 1.0, end, begin + f * (end - begin))
            wait = np.where(f[:, 0] == 1.0, piece.wait_s[owner], 0.0)
            yield points, piece.line[owner], piece.tolerance[owner], wait
