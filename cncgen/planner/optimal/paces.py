"""How fast the program asks each row to be, and which rows it asks to be passed so slowly that they are stops."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.path import STANDSTILL, Path
from cncgen.planner.optimal.limits import Bounds, along_path, resolution
from cncgen.planner.paths import path_of
from cncgen.planner.record import Limit
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: Speed of a row, in what full jerk or acceleration gives in a period, below which the axes are as good as at rest on it.
_CRAWL = 0.02
#: Time of such a row, in times of rising to its speed from rest, from which it does not matter that it begins at rest.
_LONG = 2000.0
#: Part of the resolution up to which a row that is asked to be slow is as good as a stop.
_UNSEEN = 0.05
#: Length of a row, in tolerances, up to which what is smoothed within them may have no span of its own for it.
_SWALLOWED = 8.0


@dataclass(frozen=True, slots=True)
class Feeds:
    """Speed that the program asks of each row, mm/s (infinite: none), and the `Limit` that it stands for."""

    speed: Floats
    limit: NDArray[np.int8]

    @classmethod
    def of(cls, toolpath: Toolpath, path: Path) -> Feeds:
        """G94: the feed; G93: the row's length by its time; rapids: none."""
        inverse = toolpath.feed_mode == FeedMode.INVERSE_TIME
        rapid = (toolpath.feed_mode == FeedMode.RAPID) | (toolpath.kind == Kind.EVENT)
        speed = toolpath.feed * np.where(inverse, np.diff(path.row_s), path.per_feed)
        limit = np.where(rapid, Limit.VELOCITY, Limit.FEED).astype(np.int8)
        return cls(np.where(rapid, np.inf, speed), limit)


def crawling(path: Path, speed: Floats, bounds: Bounds) -> Bools:
    """Tell which rows of a path are asked to be so slow that the motion may as well begin and end them at rest.

    Their speed v is below a fiftieth of J T² and of A T, which is reached from rest in a seventh of a period, and their time,
    that is lost if they are passed as setpoints see them, is long beside the √(v/J) + v/A that this takes; or they are too
    short for setpoints to show anything else.

    Args:
        path: The rows.
        speed: Shape (rows,), mm/s, infinite for none.
        bounds: Limits.
    """
    out = np.zeros(len(speed), bool)
    rows = np.flatnonzero((speed < _fastest(bounds)) & (path.row_length > STANDSTILL))
    if not len(rows):
        return out
    x1 = path.evaluate(0.5 * (path.row_s[rows] + path.row_s[rows + 1]), 1)[1]
    length, v = path.row_length[rows], speed[rows]
    acceleration, jerk = (along_path(each, x1) for each in (bounds.axes.acceleration, bounds.axes.jerk))
    long = length / v >= _LONG * (np.sqrt(v / jerk) + v / acceleration)
    short = length <= _UNSEEN * resolution(bounds, x1)
    slow = v < _CRAWL * np.minimum(jerk * bounds.period_s, acceleration) * bounds.period_s
    out[rows] = slow & (long | short)
    return out


def _fastest(bounds: Bounds) -> float:
    """Return a speed that no crawling row has: no direction is further than the diagonal from all axes."""
    jerk = bounds.axes.jerk[np.isfinite(bounds.axes.jerk)]
    return float(_CRAWL * np.sqrt(len(bounds.axes.jerk)) * jerk.max(initial=0.0)) * bounds.period_s**2


def paced(chunks: Iterable[Toolpath], bounds_of: Callable[[str], Bounds]) -> Iterator[Toolpath]:
    """Yield chunks whose feeds under G64 are speeds, and whose rows that crawl by their time no smoothing takes in.

    The time that G93 gives a row is that of the whole row: as a speed it stays with every part that a row becomes. Under
    G64 a row of some tolerances may vanish in the curve of its neighbours; one that crawls by G93 is met exactly, that its time
    does not vanish with it. A feed in G94 is no time: what is shorter is faster.

    Args:
        chunks: Consecutive stretches of one program, tolerances filled in.
        bounds_of: Gives the limits for the letters of a toolpath.
    """
    for chunk in chunks:
        inverse = chunk.feed_mode == FeedMode.INVERSE_TIME
        slowest = np.min(chunk.feed, where=np.isfinite(chunk.feed), initial=np.inf)
        bounds = bounds_of(chunk.axes)
        if not inverse.any() and slowest >= _fastest(bounds):
            yield chunk
            continue
        path = path_of(chunk)
        speed = Feeds.of(chunk, path).speed
        met = inverse & (chunk.path_mode == PathMode.CONTINUOUS)
        met &= path.row_length <= _SWALLOWED * chunk.tolerance
        met &= crawling(path, speed, bounds)
        # What is met exactly keeps its time, to the last digit.
        split = inverse & (chunk.path_mode == PathMode.CONTINUOUS) & ~met
        yield replace(
            chunk,
            feed=np.where(split, speed / path.per_feed, chunk.feed),
            feed_mode=np.where(split, FeedMode.SPEED, chunk.feed_mode).astype(np.int8),
            path_mode=np.where(met, PathMode.EXACT_PATH, chunk.path_mode).astype(np.int8),
        )
