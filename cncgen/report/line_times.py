"""The time of a plan by lines of the program: motion exactly by the profile, dwells by their events."""

from __future__ import annotations

import heapq
from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from cncgen.planner.motion import time_at
from cncgen.planner.record import Limit, Profile, Trajectory
from cncgen.toolpath.record import Kind


@dataclass(frozen=True, slots=True)
class LineTime:
    """Times of the lines of a program: its file, its number, time s (waits among it), length mm along the path."""

    source: str
    line: int
    time_s: float
    length_mm: float


class LineTimes:
    """Gathers the time of each line over any number of trajectories; memory grows with the lines."""

    def __init__(self) -> None:
        self._time: dict[tuple[str, int], float] = defaultdict(float)
        self._length: dict[tuple[str, int], float] = defaultdict(float)

    def add(self, trajectory: Trajectory) -> None:
        """Take a stretch of a plan; a row that several stretches travel has its share from each."""
        p, rows = trajectory.profile, trajectory.toolpath
        if not len(p) or not len(rows):
            return
        s = np.clip(trajectory.row_s, p.s[0], p.s[-1])
        leaving = time_at(p, s)
        spent, length = np.diff(leaving - _waited(p, leaving)), np.diff(s)
        for row in np.flatnonzero((rows.kind != Kind.EVENT) & ((spent > 0) | (length > 0))):
            key = rows.sources[int(rows.source[row])], int(rows.line[row])
            self._time[key] += float(spent[row])
            self._length[key] += float(length[row])
        for _, line, event in trajectory.events:
            if event.wait_s:
                self._time[(rows.sources[0], line)] += event.wait_s

    @property
    def lines(self) -> int:
        """Return how many lines take time."""
        return len(self._time)

    @property
    def total_s(self) -> float:
        """Return the time of all lines."""
        return sum(self._time.values())

    def longest(self, count: int) -> list[LineTime]:
        """Return the lines that take the most time, the longest first."""
        keys = heapq.nlargest(count, self._time, key=lambda key: (self._time[key], -key[1]))
        return [LineTime(*key, self._time[key], self._length[key]) for key in keys]


def _waited(p: Profile, t: np.ndarray) -> np.ndarray:
    """Return how much of the time up to each of `t` a profile waits for an event."""
    wait = p.waits & (p.limit == Limit.STOP)
    return np.interp(t, p.t, np.concatenate([[0.0], np.cumsum(np.diff(p.t) * wait)]))
