"""The breakpoints of a block, as they are before `corners` classifies them, and of its neighbours beside its borders.

Blocks are cut by the work that they make, so a border may lie anywhere: amid a run of short rows, between two corners that
one setpoint sees. What happens at a corner depends on those around, so a block is classified with the breakpoints of its neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.columns import max_over_axes
from cncgen.geometry.path import Path
from cncgen.planner.least_time.crawling import crawling
from cncgen.planner.least_time.speed_caps import SpeedCap
from cncgen.planner.limits.axis_limits import AxisLimits, resolution
from cncgen.planner.limits.speeds import Feeds
from cncgen.toolpath.record import Kind, PathMode, Toolpath

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]

#: Part of the resolution up to which breakpoints are one place. That is J T³/4000: turning back on it, a third difference has
#: (1, −2, 1) times twice that, a thousandth of J. Within a curve they are those of one halt, a knot and the cusp beside it,
#: which four times as much must not part: where between them is rounding.
_TOGETHER, _TOGETHER_WITHIN = 0.0125, 0.05
#: Part of the resolution up to which a bend beside a knot is of its corner.
_KNOT_SHARE = 0.8 * _TOGETHER_WITHIN
#: Nodes stand so close that the direction turns less than this over an interval, rad, and its derivative changes accordingly
#: (`mesh_spacing`). Where it turns more (cusps, bends too short to show), derivatives are replaced by values from the ends (`mesh`).
SHARP = 0.3
#: Largest turn of a direction that is rounding alone, rad.
NO_TURN = 1e-9


@dataclass(frozen=True, slots=True)
class PathBlock:
    """A block of a toolpath, of a length greater than 0, and what the program asks of it.

    Attributes:
        toolpath, path: Its rows and their geometry.
        cap: A largest speed along the path, beside the bounds; None for none.
        feeds: Speeds of the rows.
        crawls: Shape (rows,), the rows that begin and end at rest (`crawling`).
    """

    toolpath: Toolpath
    path: Path
    cap: SpeedCap | None
    feeds: Feeds
    crawls: Bools

    @classmethod
    def of(cls, toolpath: Toolpath, cap: SpeedCap | None, bounds: AxisLimits) -> PathBlock:
        """Return a toolpath as a block."""
        path = toolpath.path
        feeds = Feeds.of(toolpath)
        return cls(toolpath, path, cap, feeds, crawling(path, feeds.speed, bounds))

    def top(self, bounds: AxisLimits, s: Floats, x: Floats, side: int) -> Floats:
        """Return the largest q = v² by all but jumps at places, shape (n,), of the row before (-1) or after (1).

        Args:
            bounds: Limits.
            s: Shape (n,), path coordinates, ascending.
            x: Shape (≥ 3, n, axes), the path and its derivatives there.
            side: Which row is meant at a joint of two.
        """
        row = self.path.row_of(s, side)
        q, _ = bounds.top(self.feeds.speed[row], self.feeds.limit[row], x[1], x[2])
        return self.cap.lower(s, x, q) if self.cap else q


@dataclass(frozen=True, slots=True)
class Breakpoints:
    """The `n` breakpoints of a path, ascending, both ends included.

    Attributes:
        s: Shape (n,), path coordinate, mm; 0 where the block begins, or, of those before it, where it ends.
        left, right: Shape (4, n, axes), position and derivatives on both sides of each.
        top: Shape (n,), the largest q = v² there by all but jumps.
        rest: Shape (n,), bool: the program asks for rest there: the end of a motion under G61.1, both ends of one that crawls,
            an event, the ends of the program.
        line, in_space: Shape (n − 1,), bool: a straight line leads to the next one; X, Y or Z move on the way.
    """

    s: Floats
    left: Floats
    right: Floats
    top: Floats
    rest: Bools
    line: Bools
    in_space: Bools

    def __len__(self) -> int:
        return len(self.s)

    def head(self, most: int) -> Breakpoints:
        """Return the first ones, `most` at most."""
        return self._part(slice(0, most), slice(0, most - 1), 0.0)

    def tail(self, most: int) -> Breakpoints:
        """Return the last ones, `most` at most, as those before another block."""
        return self._part(slice(-most, None), slice(-most + 1, None), self.s[-1])

    def _part(self, which: slice, between: slice, origin: float) -> Breakpoints:
        return Breakpoints(
            self.s[which] - origin,
            self.left[:, which],
            self.right[:, which],
            self.top[which],
            self.rest[which],
            self.line[between],
            self.in_space[between],
        )

    def followed_by(self, other: Breakpoints) -> Breakpoints:
        """Return these and those of the block that follows, whose first one is the place of the last of these."""
        border, first = [-1], [0]
        return Breakpoints(
            np.concatenate([self.s, self.s[-1] + other.s[1:]]),
            np.concatenate([self.left, other.left[:, 1:]], axis=1),
            np.concatenate([self.right[:, :-1], other.right], axis=1),
            np.concatenate([self.top[:-1], np.minimum(self.top[border], other.top[first]), other.top[1:]]),
            np.concatenate([self.rest[:-1], self.rest[border] | other.rest[first], other.rest[1:]]),
            np.concatenate([self.line, other.line]),
            np.concatenate([self.in_space, other.in_space]),
        )


def breakpoints_of(block: PathBlock, bounds: AxisLimits) -> Breakpoints:
    """Return the breakpoints of a block; those that no setpoint can tell apart are one, with the left side of the first, the right side
    of the last."""
    path = block.path
    seams = path.breakpoints()
    sides = (path.evaluate(seams, 3, -1), path.evaluate(seams, 3, 1))
    bends = _bends_beside(path, seams, (sides[0][1], sides[1][1]), bounds)
    if len(bends):
        seams = np.union1d(seams, bends)
        sides = (path.evaluate(seams, 3, -1), path.evaluate(seams, 3, 1))
    # At its ends a path is what it is within; a curve that ends in a cusp has no direction there.
    sides[0][:, 0], sides[1][:, -1] = sides[1][:, 0], sides[0][:, -1]
    between = path.row_of(0.5 * (seams[:-1] + seams[1:]))
    first, last = _distinct(seams, sides, bounds, path.kind[between] == Kind.NURBS)
    left, right, s = sides[0][:, first], sides[1][:, last], seams[first]
    rest = np.zeros(len(s), bool)
    rest[nearest(s, _rests(block))] = True
    row = path.row_of(0.5 * (s[:-1] + s[1:]))
    return Breakpoints(
        s,
        left,
        right,
        np.minimum(block.top(bounds, s, left, -1), block.top(bounds, seams[last], right, 1)),
        rest,
        path.kind[row] == Kind.LINE,
        path.moves_xyz[row],
    )


def _bends_beside(path: Path, seams: Floats, directions: tuple[Floats, Floats], bounds: AxisLimits) -> Floats:
    """Return places between which and a knot beside them a curve bends too briefly to show in setpoints, shape (k,).

    Nodes are further apart than that, and need not see the bend, though the direction after it is another one. What `_distinct`
    counts to the knot becomes its corner, the rest an interval of its own.

    Args:
        path: The path.
        seams: Shape (n,), its breakpoints.
        directions: Shape (n, axes) each, dx/ds on the left and right of them.
        bounds: Limits.
    """
    found, apart = [], np.diff(seams)
    curved = path.kind[path.row_of(0.5 * (seams[:-1] + seams[1:]))] == Kind.NURBS
    room = apart[curved]
    for side, x1 in zip((-1, 1), directions, strict=True):
        at, x1 = ((each[1:] if side < 0 else each[:-1])[curved] for each in (seams, x1))
        way = resolution(bounds, x1)
        at, x1, way = (each[room > way] for each in (at, x1, side * way))
        far = at + way
        beyond = path.evaluate(far, 1)[1]
        turned = _turned(x1, beyond)
        near = at[turned] + _KNOT_SHARE * way[turned]
        between = path.evaluate(near, 1)[1]
        found += [near[_turned(x1[turned], between)], far[turned][_turned(between, beyond[turned])]]
    return np.concatenate(found)


def _turned(one: Floats, other: Floats) -> NDArray[np.bool_]:
    """Tell which of two directions, shape (k, axes) each, differ by more than nodes are placed for."""
    out: NDArray[np.bool_] = max_over_axes(np.abs(other - one)) > SHARP * max_over_axes(np.abs(other))
    return out


def _distinct(
    s: Floats, sides: tuple[Floats, Floats], bounds: AxisLimits, curved: Bools
) -> tuple[Ints, Ints]:
    """Return which breakpoints are the first and which the last of a cluster that no setpoint can tell apart (`_TOGETHER`); the ends stay.

    Args:
        s: Shape (n,), path coordinate.
        sides: Derivatives on the left and on the right of each, shape (4, n, axes) each.
        bounds: Limits.
        curved: Shape (n − 1,), between which of them a NURBS goes on.
    """
    # The rows that meet at a cluster count too: a length may be short for one row and long for axes that only the other moves.
    seen = np.minimum(*(resolution(bounds, side[1]) for side in sides))
    way = np.diff(s)
    # Between two knots of a polygon a curve is as straight as a line.
    bend = np.maximum(np.abs(sides[1][2, :-1]), np.abs(sides[0][2, 1:]))
    part = np.where(curved & (max_over_axes(bend) * way > NO_TURN), _TOGETHER_WITHIN, _TOGETHER)
    apart = way > part * np.minimum(seen[:-1], seen[1:])
    if not apart.any():
        ends = np.array([0, len(s) - 1])
        return ends, ends
    first = np.flatnonzero(np.concatenate([[True], apart]))
    last = np.flatnonzero(np.concatenate([apart, [True]]))
    first[-1], last[0] = len(s) - 1, 0
    return first, last


def _rests(block: PathBlock) -> Floats:
    """Return the places where the program demands rest: at the ends of motions under G61.1, at both ends of crawling motions, at
    events."""
    toolpath, row_s = block.toolpath, block.path.row_s
    exact = np.flatnonzero((np.diff(row_s) > 0) & (toolpath.path_mode == PathMode.EXACT_STOP))
    waits = [row for row, _, event in toolpath.event_rows if event.stands]
    slow = np.flatnonzero(block.crawls)
    return row_s[np.concatenate([exact + 1, slow, slow + 1, np.array(waits, np.int64)])]


def nearest(s: Floats, at: Floats) -> Ints:
    """Return the index in ascending `s` nearest to each of `at`."""
    right = np.clip(np.searchsorted(s, at), 1, max(len(s) - 1, 1))
    index = np.minimum(right, len(s) - 1)
    lower = np.abs(s[right - 1] - at) <= np.abs(s[index] - at)
    return np.where(lower, right - 1, index)
