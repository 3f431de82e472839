"""A solution (q by s) as pieces in time (s by t), each in closed form; between `problem` and `rolling_window`.

The jerk along the path is constant on each of them (`Profile`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.columns import min_over_axes
from cncgen.kernels import planned_motion, seven_phase
from cncgen.planner.least_time.mesh import LINE
from cncgen.planner.least_time.problem import Intervals, Solution
from cncgen.planner.limits.axis_limits import along_path
from cncgen.planner.record import Limit, Profile

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class MotionPieces:
    """Pieces of `n` intervals, `k` in all.

    Attributes:
        offset: Shape (n + 1,): the piece that each interval begins with, and k.
        place: Shape (k,), mm from the start of its interval.
        duration, v, a, j, c: Shape (k,), s and the state at the start of the piece.
        limit: Shape (k,), int8, a `Limit`.
    """

    offset: NDArray[np.int64]
    place: Floats
    duration: Floats
    v: Floats
    a: Floats
    j: Floats
    c: Floats
    limit: NDArray[np.int8]

    def profile(self, h: Floats) -> tuple[Profile, NDArray[np.int64]]:
        """Return the motion over the first intervals, of lengths `h`, and the interval of each piece; way and time begin at 0."""
        count = self.offset[len(h)]
        owner = np.repeat(np.arange(len(h)), np.diff(self.offset[: len(h) + 1]))
        way, t = (np.concatenate([[0.0], np.cumsum(each)]) for each in (h, self.duration[:count]))
        s = np.append(way[owner] + self.place[:count], way[-1])
        v, a, j, c = (each[:count] for each in (self.v, self.a, self.j, self.c))
        return Profile(t, s, v, a, j, c, self.limit[:count]), owner


def pieces_of(given: Intervals, found: Solution) -> MotionPieces:
    """Turn q = v² into pieces.

    On a spline interval with speeds v0, v1 and accelerations a0, a1 the duration is 2 h/(m + √(m² − (a1 − a0) h/3)) with the mean speed m
    (docs/least-time.md). From rest, v = j t²/2 and s = j t³/6 give t = 3 h/v and j = 2 v/t². A line from rest to rest has up to seven
    pieces.

    Args:
        given: The n intervals.
        found: Their solution.
    """
    n, h, kind = len(given), given.h, given.kind
    lines = np.flatnonzero(kind == LINE)
    out = np.zeros((6, n))
    planned_motion.pieces(kind, h, found.q, found.way, out[1:])
    limit = found.limit
    count = np.ones(n, np.int64)
    if not len(lines):
        place, duration, v, a, j, c = out
        return MotionPieces(np.arange(n + 1), place, duration, v, a, j, c, limit)
    line_count, columns = seven_phases(given, lines)
    count[lines] = line_count
    offset = np.concatenate([[0], np.cumsum(count)])
    merged = [np.repeat(column, count) for column in (*out, limit)]
    where = np.repeat(kind == LINE, count)
    for mine, theirs in zip(merged, columns, strict=True):
        mine[where] = theirs
    return MotionPieces(offset, *merged)


def seven_phases(given: Intervals, lines: NDArray[np.int64]) -> tuple[NDArray[np.int64], tuple[NDArray, ...]]:
    """Return the seven-phase profile of each straight line from rest to rest: the number of its pieces, and their columns.

    Phases that last no time are left out.
    """
    n, length = len(lines), given.h[lines]
    acc, jerk = (along_path(limit, given.x1[lines, 1]) for limit in given.limits)
    top = np.sqrt(min_over_axes(given.top[lines]))
    table, offset = np.empty((7 * n, 7)), np.zeros(n + 1, np.int64)
    seven_phase.build(0, length, acc, jerk, top, np.zeros(n + 1), table, offset)
    duration, v, a, j, c, phase, way = table[: offset[-1]].T
    owner = np.repeat(np.arange(n), np.diff(offset))
    number = np.arange(offset[-1]) - offset[owner]
    ways = np.zeros((n, 7))
    ways[owner, number] = way
    place = (np.cumsum(ways, axis=1) - ways)[owner, number]
    limit = np.choose(
        phase.astype(np.int64),
        [given.top_limit[lines][owner], np.int8(Limit.ACCELERATION), np.int8(Limit.JERK)],
    )
    return np.diff(offset), (place, duration, v, a, j, c, limit)
