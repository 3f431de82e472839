"""Corners for which no estimate tells whether to pass them or to stop: a short piece of the path is planned both ways.

`block_planning` asks `CornerTrials` for the `Mesh` of each block. Rule and figures: docs/corners.md, Pass or stop.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.path import Path
from cncgen.planner.least_time.corners import BlockEnd, Corners, nearest
from cncgen.planner.least_time.mesh import Mesh, Section
from cncgen.planner.least_time.mesh_spacing import AMPLE, CLOSEST
from cncgen.planner.least_time.rolling_window import MARGIN, RollingWindow
from cncgen.planner.least_time.speed_caps import SpeedCap
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.toolpath.record import Toolpath

Ints = NDArray[np.int64]
Decision = NDArray[np.int8]

#: Both ways are tried at jumps whose speed lies between these multiples of the speed at which, by the estimate, a stop takes as
#: long as passing.
_SLOWEST, FASTEST = 0.3, 2.0
#: Nodes that are planned at once at most.
SIZE = 1200
#: Nodes of a trial, as a part of the number that the plan has there.
_COARSER = 0.5
#: Largest number of ways in which a piece is tried; where the budget allows fewer than the second number, it is not tried at all.
_WAYS, _FEWEST = 8, 4
#: The budget of trials, in nodes (100,000 take about a second): the cost of each trial beside its own nodes, the part of its nodes
#: that a block adds to the budget, and the budget that a program begins with.
EACH, _PART = 400, 0.02
MOST = 100_000
#: Part of the time by which another way must be faster to be taken.
_LESS = 1e-4


@dataclass(slots=True)
class CornerTrials:
    """CornerTrials of a program, block by block.

    Attributes:
        left: Nodes that trials may still cost.
    """

    left: float = float(MOST)

    def mesh_of(
        self,
        toolpath: Toolpath,
        path: Path,
        bounds: AxisLimits,
        before: BlockEnd | None,
        after: BlockEnd | None,
        cap: SpeedCap | None = None,
    ) -> Mesh:
        """Cut a block into intervals.

        Args:
            toolpath, path: The block, of a length greater than 0.
            bounds: Limits.
            before, after: The end of the block before and the start of the next; None where the motion starts or ends at
                this block's border.
            cap: A largest speed along the path, beside the bounds.

        Raises:
            NoPlanError: It would be more intervals than memory is meant for.
        """
        section = Section.of(toolpath, path, bounds, before, after, cap)
        corners = section.corners()
        mesh = section.mesh(corners)
        self.left += _PART * len(mesh)
        decision = self._tried(section, corners, mesh)
        return mesh if decision is None else section.mesh(section.corners(decision))

    def _tried(self, section: Section, corners: Corners, mesh: Mesh) -> Decision | None:
        """Return where to stop (-1) and what to pass (1), shape (breakpoints,), if trials differ from the corners; else None."""
        # Below `_SLOWEST` a corner is passed only if chords hold its speed. The estimate does not weigh that, so it is tried.
        doubtful = (corners.doubt < FASTEST) & ((corners.doubt > _SLOWEST) | ~corners.stop)
        doubtful[[0, -1]] = False
        if not doubtful.any():
            return None
        decision = np.where(corners.stop, -1, np.where(np.isfinite(corners.speed), 1, 0)).astype(np.int8)
        decision[[0, -1]] = 0
        before = decision.copy()
        closest = float(np.clip(AMPLE / len(mesh), 1.0, CLOSEST))
        closer = max(1.0, _COARSER * closest)
        for start, end in trial_pieces(nearest(mesh.s, corners.s), corners.stop):
            piece, inner = section.part(float(mesh.s[start]), float(mesh.s[end]))
            if not doubtful[inner].any():
                continue
            each = EACH + (end - start) * closer / closest
            ways = min(_WAYS, int(self.left / each))
            if ways < _FEWEST:
                break
            decision[inner], tried = _fastest(piece, decision[inner], doubtful[inner], ways, closer, MARGIN)
            self.left -= tried * each
        return None if np.array_equal(decision, before) else decision


class _Between(NamedTuple):
    """The motion between two stops that does not depend on what lies beyond them: its time, and its stops with both ends."""

    seconds: float
    stops: tuple[int, ...]


def trial_pieces(node: Ints, stop: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the first and the last node of what is planned at once, of `SIZE` nodes at most.

    They are halves of halves, parted at the stop next to the middle, so that a path and its reverse have the same, but for
    ties.
    """
    rests = node[stop]
    out, left = [], [(0, int(node[-1]))]
    while left:
        start, end = left.pop()
        if end - start <= SIZE:
            out.append((start, end))
            continue
        within = rests[(rests > start) & (rests < end)]
        middle = (start + end) // 2
        if len(within):
            middle = int(within[np.argmin(np.abs(2 * within - start - end))])
        left += [(middle, end), (start, middle)]
    return out


def _fastest(
    piece: Section, decision: Decision, doubtful: NDArray[np.bool_], ways: int, closer: float, margin: float
) -> tuple[Decision, int]:
    """Return the fastest chain of motions from stop to stop that trials of a piece have found.

    Tried are first the estimate, a stop at all corners in doubt, and a stop at none; then the best of these with single
    corners changed.

    Args:
        piece: From rest to rest.
        decision: Shape (n,), what the breakpoints within it do by the estimate: -1 stop, 1 pass, 0 no choice.
        doubtful: Shape (n,), which of them are in doubt.
        ways: CornerTrials at most.
        closer: Factor by which nodes stand closer than their density tells.
        margin: Part of the limits that is planned with.

    Returns:
        The decisions, shape (n,), and how many trials that took.
    """
    found: dict[tuple[int, int], _Between] = {}
    tried: set[bytes] = set()
    best, flips = decision, False
    fresh = [decision, *(np.where(doubtful, each, decision).astype(np.int8) for each in (-1, 1))]
    while fresh:
        for way in fresh:
            if way.tobytes() in tried:
                continue
            plan_trial(piece, way, closer, margin, found, 0.0 if way is decision else _LESS)
            tried.add(way.tobytes())
            if not found:
                # Even the estimate has no solution that is found at once.
                return decision, len(tried)
        before, kept = best, np.zeros(len(decision) + 2, bool)
        kept[_chain(found, len(decision) + 1)] = True
        best = np.where(doubtful, np.where(kept[1:-1], -1, 1), decision).astype(np.int8)
        if flips and np.array_equal(best, before):
            break
        flips = True
        fresh = [way for way in _flipped(best, doubtful) if way.tobytes() not in tried][: ways - len(tried)]
    return best, len(tried)


def plan_trial(
    piece: Section,
    decision: Decision,
    closer: float,
    margin: float,
    found: dict[tuple[int, int], _Between],
    less: float,
) -> None:
    """Plan a piece from rest to rest, and keep what it takes between stops where that is less than what was `found`."""
    corners = piece.corners(np.concatenate([[0], decision, [0]]).astype(np.int8))
    mesh = piece.mesh(corners, closer)
    arrival = RollingWindow(piece.bounds, margin, [mesh]).arrival()
    if arrival is None:
        return
    t = arrival[nearest(mesh.s, corners.s)] + 0.5 * piece.bounds.period_s * np.cumsum(corners.cuts)
    before, after = corners.reached()
    # A stop that the zone of a jump reaches over does not separate the motions before and after it.
    parts = corners.stop & np.isinf(before) & np.isinf(after)
    parts[[0, -1]] = True
    for i, j in pairwise(np.flatnonzero(parts).tolist()):
        seconds = float(t[j] - t[i]) * (1.0 + less)
        if (i, j) not in found or seconds < found[i, j].seconds:
            found[i, j] = _Between(seconds, tuple((i + np.flatnonzero(corners.stop[i : j + 1])).tolist()))


def _chain(found: dict[tuple[int, int], _Between], last: int) -> list[int]:
    """Return the stops, from 0 to `last`, of the fastest chain of what was found: a shortest path in a graph without cycles.

    Stops are visited in ascending order, which is a topological one (Cormen et al., Introduction to Algorithms (2009),
    section 24.2).
    """
    best: dict[int, tuple[float, list[int]]] = {0: (0.0, [])}
    for i, j in sorted(found):
        if i in best:
            total = best[i][0] + found[i, j].seconds
            if j not in best or total < best[j][0]:
                best[j] = total, [*best[i][1], *found[i, j].stops]
    return best[last][1]


def _flipped(decision: Decision, doubtful: NDArray[np.bool_]) -> list[Decision]:
    """Return decisions for the breakpoints within a piece that try each one in doubt the other way.

    Those are tried together between which there is a way from stop to stop, over which zones hardly reach.
    """
    stops = np.flatnonzero(decision < 0)
    groups: list[tuple[int, list[int]]] = []
    for k in np.flatnonzero(doubtful).tolist():
        at = int(np.searchsorted(stops, k))
        own = int(at < len(stops) and stops[at] == k)
        before = int(stops[at - 1]) if at else -1
        after = int(stops[at + own]) if at + own < len(stops) else len(decision)
        for number, (end, members) in enumerate(groups):
            if end < before:
                groups[number] = after, [*members, k]
                break
        else:
            groups.append((after, [k]))
    out = []
    for _, members in groups:
        other = decision.copy()
        other[members] *= -1
        out.append(other)
    return out
