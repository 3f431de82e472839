"""Rows of a toolpath as straight lines of the tool's tip."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cncgen.toolpath.record import FeedMode, Kind, Toolpath

Floats = NDArray[np.float64]


class Lines(NamedTuple):
    """Straight lines in the order of the motion.

    Attributes:
        ends: Shape (n, 6): start and end, mm.
        line: Shape (n,): source line of each.
        rapid: Shape (n,), bool.
        seconds: Shape (n,): at the programmed feed, 0 for rapids.
    """

    ends: Floats
    line: NDArray[np.int64]
    rapid: NDArray[np.bool_]
    seconds: Floats


def lines_of(path: Toolpath, begin: int, end: int) -> Lines:
    """Return the motions among the rows `begin` to `end` of a toolpath that has lines alone."""
    rows = np.arange(begin, end)[path.kind[begin:end] != Kind.EVENT]
    starts = path.starts[rows, :3]
    ends = np.ascontiguousarray(np.concatenate([starts, path.end[rows, :3]], axis=1))
    rapid = path.feed_mode[rows] == FeedMode.RAPID
    inverse = path.feed_mode[rows] == FeedMode.INVERSE_TIME
    way = np.linalg.norm(ends[:, 3:] - ends[:, :3], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        seconds = np.where(inverse, 1.0, way) / path.feed[rows]
    return Lines(ends, path.line[rows], rapid, np.where(rapid | ~np.isfinite(seconds), 0.0, seconds))
