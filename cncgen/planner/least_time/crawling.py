"""Rows that are slow enough for the motion to stop at their ends, and the speeds of rows as smoothing takes them.

`block_planning` calls `paced` before the path is smoothed, `breakpoints` asks for `crawling` of each block
(docs/corners.md, Rows that crawl).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.path import STANDSTILL, Path
from cncgen.planner.limits.axis_limits import AxisLimits, along_path, resolution
from cncgen.planner.limits.speeds import Feeds
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: A row crawls if its speed is below this part of J T² and of A T, the speeds that full jerk and full acceleration reach from
#: rest in about a period: setpoints then can hardly tell it from standing still.
_CRAWL = 0.02
#: Its time must be this multiple of the time √(v/J) + v/A to reach its speed from rest: stopping at both ends then costs about a
#: thousandth of it.
_LONG = 2000.0
#: Or it is shorter than this part of `resolution`, the length that shows in setpoints: then it is a stop whatever its time.
_UNSEEN = 0.05
#: Rows up to this many tolerances long may vanish when smoothed: the fitted curve may have no span of its own for them.
_SWALLOWED = 8.0


def crawling(path: Path, speed: Floats, bounds: AxisLimits) -> Bools:
    """Tell which rows of a path are so slow that the motion may as well begin and end them at rest (docs/corners.md), or too short to show in
    setpoints, shape (rows,).

    Args:
        path, bounds: The rows and the limits.
        speed: Shape (rows,), mm/s, infinite for none.
    """
    out = np.zeros(len(speed), bool)
    rows = np.flatnonzero((speed < _fastest(bounds)) & (path.row_length > STANDSTILL))
    if not len(rows):
        return out
    x1 = path.evaluate(0.5 * (path.row_s[rows] + path.row_s[rows + 1]), 1)[1]
    length, v = path.row_length[rows], speed[rows]
    acceleration, jerk = (along_path(each, x1) for each in (bounds.acceleration, bounds.jerk))
    long = length / v >= _LONG * (np.sqrt(v / jerk) + v / acceleration)
    short = length <= _UNSEEN * resolution(bounds, x1)
    slow = v < _CRAWL * np.minimum(jerk * bounds.period_s, acceleration) * bounds.period_s
    out[rows] = slow & (long | short)
    return out


def _fastest(bounds: AxisLimits) -> float:
    """Return a speed, mm/s, from which no row can crawl: √n times that of the axis with the most jerk, for n axes.

    A direction may lie between all axes, so the jerk along it may be that of the diagonal.
    """
    jerk = bounds.jerk[np.isfinite(bounds.jerk)]
    return float(_CRAWL * np.sqrt(len(bounds.jerk)) * jerk.max(initial=0.0)) * bounds.period_s**2


def paced(chunks: Iterable[Toolpath], bounds_of: Callable[[str], AxisLimits]) -> Iterator[Toolpath]:
    """Yield chunks ready for smoothing: under G64 inverse-time feeds (G93) become speeds, which hold for each part of a row as well, and rows that
    crawl by them are met exactly (G61), since a row of some tolerances may vanish in the curve of its neighbours, and its time with it.
    Rapids get a speed under G64 too, the largest along their middles.

    Args:
        chunks: Consecutive stretches of one program, tolerances filled in.
        bounds_of: Gives the limits for the letters of a toolpath.
    """
    for chunk in chunks:
        bounds = bounds_of(chunk.axes)
        chunk = _rapids_paced(chunk, bounds)
        inverse = chunk.feed_mode == FeedMode.INVERSE_TIME
        slowest = np.min(chunk.feed, where=np.isfinite(chunk.feed), initial=np.inf)
        if not inverse.any() and slowest >= _fastest(bounds):
            yield chunk
            continue
        path = chunk.path
        speed = Feeds.of(chunk).speed
        met = inverse & (chunk.path_mode == PathMode.CONTINUOUS)
        met &= path.row_length <= _SWALLOWED * chunk.tolerance
        met &= crawling(path, speed, bounds)
        # Rows that are met exactly keep their time, to the last digit.
        split = inverse & (chunk.path_mode == PathMode.CONTINUOUS) & ~met
        yield replace(
            chunk,
            feed=np.where(split, speed / path.per_feed, chunk.feed),
            feed_mode=np.where(split, FeedMode.SPEED, chunk.feed_mode).astype(np.int8),
            path_mode=np.where(met, PathMode.EXACT_PATH, chunk.path_mode).astype(np.int8),
        )


def _rapids_paced(chunk: Toolpath, bounds: AxisLimits) -> Toolpath:
    """Return a chunk whose rapids under G64 have a feed, the speed that velocities of axes allow along their middles.

    Speeds that smoothing and the search compare and divide by are to be numbers. The velocities themselves bound the plan.
    """
    rapid = (chunk.feed_mode == FeedMode.RAPID) & (chunk.path_mode == PathMode.CONTINUOUS)
    rows = np.flatnonzero(rapid & (chunk.kind != Kind.EVENT))
    if not len(rows):
        return chunk
    path = chunk.path
    rows = rows[path.moves_xyz[rows] & (path.row_length[rows] > STANDSTILL)]
    x1 = path.evaluate(0.5 * (path.row_s[rows] + path.row_s[rows + 1]), 1)[1]
    feed = chunk.feed.copy()
    feed[rows] = along_path(bounds.velocity, x1) / path.per_feed[rows]
    return replace(chunk, feed=feed)
