"""The geometry of a toolpath, made once for the stages that ask for it in turn."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.path import Path
from cncgen.toolpath.record import FeedMode, Toolpath

#: The last toolpaths with their paths: planner, blending and sampling ask for the same ones one after the other, the
#: planner in another thread and some blocks ahead.
_recent: deque[tuple[Toolpath, Path]] = deque(maxlen=12)


def path_of(toolpath: Toolpath) -> Path:
    """Return the path of a toolpath, its coordinate from 0 at the start; the same object when asked again soon."""
    for known, path in tuple(_recent):
        if known is toolpath:
            return path
    t = toolpath
    path = Path(t.axes, t.start, t.kind, t.end, t.curve, t.arcs, t.nurbs)
    _recent.append((toolpath, path))
    return path


def programmed_speed(rows: Toolpath, row_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the speed along the path that the program asks for on each row, mm/s, shape (rows,); 0 in a rapid or an event.

    Args:
        rows: The rows that are travelled.
        row_s: Shape (rows + 1,): where each begins on the path, and the end.
    """
    inverse = rows.feed_mode == FeedMode.INVERSE_TIME
    feed = rows.feed * np.where(inverse, np.diff(row_s), path_of(rows).per_feed)
    return np.where(np.isfinite(feed) & (feed > 0), feed, 0.0)
