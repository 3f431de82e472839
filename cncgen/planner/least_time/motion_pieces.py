"""A solution (q by s) as pieces in time (s by t), each in closed form; between `problem` and `rolling_window`.

On the spline s''' = c s', beside a rest and on straight lines from rest to rest the jerk is constant (`Profile`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.planner.least_time.mesh import ENTER, LEAVE, LINE
from cncgen.planner.least_time.problem import Intervals
from cncgen.planner.limits.axis_limits import along_path
from cncgen.planner.limits.speed_changes import peak_speed, rise_time
from cncgen.planner.record import Limit

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class MotionPieces:
    """MotionPieces of `n` intervals, `k` in all.

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


def pieces_of(given: Intervals, q: Floats, limit: NDArray[np.int8]) -> MotionPieces:
    """Turn ordinates of q = v² into pieces.

    On a spline interval with ordinates b0, b1, b2: v² = b0, a = q'/2 = (b1 − b0)/h, c = q''/2 = (b0 − 2 b1 + b2)/h². As
    v'' = c v, the duration is 2 artanh(x)/√c with x = √c h/(v0 + v1), artan for c < 0 (docs/least-time.md). From rest,
    v = j t²/2 and s = j t³/6 give t = 3 h/v and j = 2 v/t². A line from rest to rest has up to seven pieces.

    Args:
        given: The n intervals.
        q: Shape (n, 3), ordinates.
        limit: Shape (n,), int8.
    """
    n, h, kind = len(given), given.h, given.kind
    lines = np.flatnonzero(kind == LINE)
    b0, b1, b2 = q.T
    total = np.sqrt(b0) + np.sqrt(b2)
    total[lines] = 1.0
    bend = b0 - 2.0 * b1 + b2
    duration = 2.0 * h / total * parabola_time(bend / total**2)
    a, j, c = (b1 - b0) / h, np.zeros(n), bend / h**2
    rest = (kind == LEAVE) | (kind == ENTER)
    if np.any(rest):
        duration = np.where(rest, 3.0 * h / total, duration)
        constant = 2.0 * total / duration**2
        j, c = np.where(rest, constant, 0.0), np.where(rest, 0.0, c)
        a = np.where(kind == LEAVE, 0.0, np.where(kind == ENTER, -constant * duration, a))
    count = np.ones(n, np.int64)
    place, v = np.zeros(n), np.sqrt(b0)
    if not len(lines):
        return MotionPieces(np.arange(n + 1), place, duration, v, a, j, c, limit)
    line_count, columns = seven_phases(given, lines)
    count[lines] = line_count
    offset = np.concatenate([[0], np.cumsum(count)])
    merged = [np.repeat(column, count) for column in (place, duration, v, a, j, c, limit)]
    where = np.repeat(kind == LINE, count)
    for mine, theirs in zip(merged, columns, strict=True):
        mine[where] = theirs
    return MotionPieces(offset, *merged)


def seven_phases(given: Intervals, lines: NDArray[np.int64]) -> tuple[NDArray[np.int64], tuple[NDArray, ...]]:
    """Return the seven-phase profile of each straight line from rest to rest: the number of its pieces, and their columns.

    Phases that last no time are left out. The speed is the smaller of the top speed and of `peak_speed`.
    """
    length = given.h[lines]
    acc, jerk = (along_path(limit, given.x1[lines, 1]) for limit in given.limits)
    v = np.minimum(peak_speed(length, acc, jerk), np.sqrt(given.top[lines].min(axis=1)))
    rise = rise_time(v, acc, jerk)
    hold = np.maximum(v / (jerk * rise) - rise, 0.0)
    cruise = np.maximum(length / v - 2.0 * rise - hold, 0.0)
    zero = np.zeros_like(v)
    duration = np.stack([rise, hold, rise, cruise, rise, hold, rise], axis=1)
    j = np.stack([jerk, zero, -jerk, zero, -jerk, zero, jerk], axis=1)
    state = np.zeros((3, len(lines), 8))
    for phase in range(7):
        t, s = duration[:, phase], state[:, :, phase]
        state[2, :, phase + 1] = s[2] + j[:, phase] * t
        state[1, :, phase + 1] = s[1] + (s[2] + 0.5 * j[:, phase] * t) * t
        state[0, :, phase + 1] = s[0] + (s[1] + (0.5 * s[2] + j[:, phase] * t / 6.0) * t) * t
    name = np.array(
        [Limit.JERK, Limit.ACCELERATION, Limit.JERK, 0, Limit.JERK, Limit.ACCELERATION, Limit.JERK],
        np.int8,
    )
    limit = np.tile(name, (len(lines), 1))
    limit[:, 3] = given.top_limit[lines]
    there = duration > 0.0
    place, v_at, a_at = (column[:, :7][there] for column in state)
    return there.sum(axis=1), (
        place,
        duration[there],
        v_at,
        a_at,
        j[there],
        np.zeros(len(place)),
        limit[there],
    )


def parabola_time(x: Floats) -> Floats:
    """Return artanh(√x)/√x for x > 0 and arctan(√−x)/√−x for x < 0, which are one function; near 0 by its series."""
    root = np.sqrt(np.abs(x))
    near = np.abs(x) < 1e-3
    safe = np.where(near, 0.5, root)
    closed = (
        np.where(x > 0.0, elementary.arctanh(np.minimum(safe, 1.0 - 1e-16)), elementary.arctan(safe)) / safe
    )
    series = 1.0 + x * (1 / 3 + x * (1 / 5 + x * (1 / 7 + x * (1 / 9 + x / 11))))
    return np.where(near, series, closed)
