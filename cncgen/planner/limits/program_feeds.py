"""The speed that the program asks of each row."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.path import Path
from cncgen.planner.record import Limit
from cncgen.toolpath.record import FeedMode, Kind, Toolpath

Floats = NDArray[np.float64]


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


def programmed_speed(rows: Toolpath, row_s: Floats) -> Floats:
    """Return the speed along the path that the program asks for on each row, mm/s, shape (rows,); 0 in a rapid or an event.

    Args:
        rows: The rows that are travelled.
        row_s: Shape (rows + 1,): where each begins on the path, and the end.
    """
    inverse = rows.feed_mode == FeedMode.INVERSE_TIME
    feed = rows.feed * np.where(inverse, np.diff(row_s), rows.path.per_feed)
    return np.where((rows.feed_mode != FeedMode.RAPID) & np.isfinite(feed) & (feed > 0), feed, 0.0)
