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
