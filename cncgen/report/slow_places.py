"""Where a plan loses time: valleys of the speed along the path, with the source line and the limit that binds.

A valley runs from one maximum of the speed to the next one. Its cost is its time less the time that the
programmed feed would take for the same length. A ripple of less than `RIPPLE` of the speed does not split a valley.
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.record import Axis
from cncgen.planner.limits.speeds import programmed_speed
from cncgen.planner.motion import axes_at, motion_at
from cncgen.planner.record import Limit, Trajectory
from cncgen.units import ORDER_NAMES

Floats = NDArray[np.float64]

#: A maximum parts two valleys where the speed rises by more than this part of itself on both sides.
RIPPLE = 0.05

#: Places that are kept; a summary lists the first `LISTED` of them, the page all.
KEPT = 20
LISTED = 10
#: Rows of a table of pieces: loss (s), speed at the end (mm/s), line, limit, least speed with its t and s, index of the source,
#: number of the trajectory, and t of the middle.
_TRAJECTORY, _ROWS = 8, 10
#: The limits that each axis has of its own, with the order of the derivative.
_OF_AXES = {Limit.VELOCITY: 1, Limit.ACCELERATION: 2, Limit.JERK: 3}
#: An axis holds a piece back where it comes so near to its limit.
_HELD = 0.9
#: A speed of rest, mm/s.
_REST = 1e-9
#: Difference of sums of the same times in another order, s, with room to spare.
_ROUNDING_S = 1e-9


@dataclass(frozen=True, slots=True)
class SlowPlace:
    """A valley of the speed: time lost, and where, when, how fast at its slowest, and the limit of most of the loss.

    Attributes:
        lost_s: Its time less that of the programmed feed.
        source: File that `line` counts in, as `cncgen.toolpath.record.Toolpath.sources` names it.
        position: Of all axes where it is slowest, mm or rad.
        t_s, s_mm, feed_mm_s: When, where along the path and how fast that is.
        axis: Letter of the axis whose limit binds for most of the loss; "" if it does not belong to an axis, or no axis comes near it.
    """

    lost_s: float
    line: int
    source: str
    position: tuple[float, ...]
    t_s: float
    s_mm: float
    feed_mm_s: float
    limit: Limit
    axis: str = ""


class SlowPlaces:
    """Gathers the `KEPT` valleys that cost the most, over any number of trajectories.

    `rapid_mm_s` stands for the feed of a rapid; `axes`, by letter, are those whose limits bind.
    """

    def __init__(self, rapid_mm_s: float, axes: Mapping[str, Axis] = MappingProxyType({})) -> None:
        self._rapid, self._axes = rapid_mm_s, axes
        self._heap: list[tuple[float, int, SlowPlace]] = []
        self._count = 0
        self._open: list[NDArray] = []
        #: By number, the trajectories that open pieces are of.
        self._trajectories: dict[int, Trajectory] = {}
        self._added = 0

    def add(self, trajectory: Trajectory) -> None:
        """Take a stretch of a plan; its last valley stays open for the next one."""
        pieces = self._pieces(trajectory)
        if not pieces.shape[1]:
            return
        self._open.append(pieces)
        self._trajectories[self._added] = trajectory
        self._added += 1
        joined = np.concatenate(self._open, axis=1)
        cuts = _valley_cuts(joined[1])
        if cuts:
            starts = [0, *cuts[:-1]]
            # Sums computed at once show which of them may be among the worst, except for rounding.
            lost = np.add.reduceat(joined[0, : cuts[-1]], starts)
            least = self._heap[0][0] if len(self._heap) == KEPT else 0.0
            for n in np.flatnonzero(lost > least - _ROUNDING_S):
                self._close(joined[:, starts[n] : cuts[n]])
        self._open = [joined[:, cuts[-1] :]] if cuts else [joined]
        # A valley that never ends (a constant speed) is closed too: nothing grows with the program.
        if self._open[0].shape[1] > 200_000:
            self._close(self._open.pop())
        first = self._open[0][_TRAJECTORY, 0] if self._open and self._open[0].shape[1] else self._added
        for number in [number for number in self._trajectories if number < first]:
            del self._trajectories[number]

    def worst(self) -> list[SlowPlace]:
        """Return the places that cost the most, the worst first."""
        for part in self._open:
            self._close(part)
        self._open = []
        return [place for _, _, place in sorted(self._heap, reverse=True)]

    def _pieces(self, trajectory: Trajectory) -> Floats:
        """Return the table of moving pieces, shape (`_ROWS`, pieces)."""
        p, rows = trajectory.profile, trajectory.toolpath
        if not len(p) or not len(rows):
            return np.zeros((_ROWS, 0))
        time, length = np.diff(p.t), np.diff(p.s)
        row = np.searchsorted(trajectory.row_s[1:], 0.5 * (p.s[:-1] + p.s[1:]), side="left")
        row = np.minimum(row, len(rows) - 1)
        asked = programmed_speed(trajectory.toolpath)[row]
        loss = time - length / np.where(asked > 0.0, asked, self._rapid)
        speed = np.append(p.v[1:], np.maximum(motion_at(p, p.t[-1:]).v, 0.0))
        # A piece is slowest at one of its ends.
        at = np.arange(len(p)) + (speed <= p.v)
        number = np.full(len(p), self._added)
        slowest = (np.minimum(speed, p.v), p.t[at], p.s[at])
        middle = 0.5 * (p.t[:-1] + p.t[1:])
        pieces = np.stack([loss, speed, rows.line[row], p.limit, *slowest, rows.source[row], number, middle])
        waits = p.waits
        return pieces[:, ~waits] if waits.any() else pieces

    def _close(self, pieces: Floats) -> None:
        lost = float(pieces[0].sum())
        if not pieces.shape[1] or lost <= 0 or (len(self._heap) == KEPT and lost <= self._heap[0][0]):
            return
        by_limit = np.bincount(pieces[3].astype(np.int64), np.maximum(pieces[0], 0.0), len(Limit))
        # Time between two limits, or from one up to the feed, is lost to them.
        if by_limit[Limit.FEED + 1 :].any():
            by_limit[: Limit.FEED + 1] = 0.0
        limit = Limit(int(np.argmax(by_limit)))
        slowest = pieces[:, _slowest(pieces, limit)]
        line, (feed, t, s, source) = int(slowest[2]), slowest[4:_TRAJECTORY].tolist()
        trajectory = self._trajectories[int(slowest[_TRAJECTORY])]
        place = SlowPlace(
            lost,
            line,
            trajectory.toolpath.sources[int(source)],
            tuple(axes_at(trajectory, np.array([t]), 0)[0].tolist()),
            t,
            s,
            feed,
            limit,
            self._axis(pieces[:, pieces[3] == limit], limit),
        )
        self._count += 1
        heapq.heappush(self._heap, (lost, self._count, place))
        if len(self._heap) > KEPT:
            heapq.heappop(self._heap)

    def _axis(self, pieces: Floats, limit: Limit) -> str:
        """Return the letter of the axis that is nearest to its own limit for most of the lost time of pieces, or ""."""
        if limit not in _OF_AXES:
            return ""
        order = _OF_AXES[limit]
        lost: dict[str, float] = {}
        for number in np.unique(pieces[_TRAJECTORY]):
            trajectory, these = self._trajectories[int(number)], pieces[:, pieces[_TRAJECTORY] == number]
            letters = trajectory.toolpath.axes
            limits = [
                getattr(self._axes[a], f"max_{ORDER_NAMES[order - 1]}") if a in self._axes else np.inf
                for a in letters
            ]
            share = np.abs(axes_at(trajectory, these[_TRAJECTORY + 1], order)) / np.array(limits)
            first = np.argmax(share, axis=1)
            held = share[np.arange(len(first)), first] > _HELD
            for k in np.unique(first[held]):
                lost[letters[k]] = lost.get(letters[k], 0.0) + float(these[0, held & (first == k)].sum())
        return max(lost, key=lambda letter: lost[letter], default="")


def _slowest(pieces: Floats, limit: Limit) -> int:
    """Return which piece a valley is slowest on; of two that meet at a rest, that of the line that loses more to the limit."""
    first = int(np.argmin(pieces[4]))
    if pieces[4, first] > _REST:
        return first
    beside = [k for k in (first, first + 1) if k < pieces.shape[1] and pieces[4, k] <= _REST]

    def lost(k: int) -> float:
        of_line = (pieces[2] == pieces[2, k]) & (pieces[7] == pieces[7, k]) & (pieces[3] == limit)
        return float(pieces[0, of_line].sum())

    return max(beside, key=lost)


def _valley_cuts(speed: Floats) -> list[int]:
    """Return the indices after the maxima of the speed that part two valleys, in order."""
    slope = np.sign(np.diff(speed))
    turning = np.flatnonzero(slope)
    turns = turning[1:][slope[turning[1:]] != slope[turning[:-1]]]
    cuts: list[int] = []
    low, high, high_at = float(speed[0]) if len(speed) else 0.0, -1.0, -1
    places = np.append(turns, len(speed) - 1)
    for at, value in zip(places.tolist(), speed[places].tolist(), strict=True):
        if value > low * (1 + RIPPLE) + 1e-9 and value > high:
            high, high_at = value, at
        elif high_at >= 0 and value < high * (1 - RIPPLE):
            cuts.append(high_at + 1)
            low, high, high_at = value, -1.0, -1
        elif high_at < 0:
            low = min(low, value)
    return cuts
