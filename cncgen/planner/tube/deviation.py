"""The deviation of setpoints from the programmed rows, in both directions and in order: by the free space of both (Alt and Godau
(1995))."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import free_space as kernel
from cncgen.kernels import tube_motion
from cncgen.planner.tube.programmed import USED, RowLines
from cncgen.planner.tube.window_problem import Solved

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Part of the tolerance that chords of the motion may leave it by where they are longer than those of setpoints, or two phases of
#: setpoints differ by; and how many phases are looked at, at most.
_CHORD, PHASES = 0.004, 12
#: Factors on the tolerance that are tried if it is exceeded, since with more than it takes, corners near each other are passed elsewhere;
#: the first of them where none are; and bisections between the last two where that tells nothing. With one list for both, four of 205
#: random programs take 2 to 25 % longer, and one 17 % less.
_FACTORS, _PLAIN, _HALVINGS = [1.0 + 0.01 * 5.0**k for k in range(6)], 2, 5
#: Corners that are nearer than so many tolerances are passed elsewhere with hardly more than it takes.
TIGHT = 4.0
#: Part of a period within which times are the same.
_SAME = 1e-6
#: Work of a walk beside its pairs, in pairs.
_WALK = 4000
#: Part of the tolerance within which places are the same, and how far from rows the plan is, in parts of its own tolerance.
_SAME_PLACE, _PLAN = 1e-3, 1.001


@dataclass(frozen=True, slots=True)
class Reached:
    """Places that a setpoint may be at: intervals on lines that follow one another, by their keys (`RowLines`).

    Attributes:
        point: Shape (n,), the setpoint.
        line: Key of where the first line begins.
        low, high: Shape (k,): an interval each; none where low is above high.
    """

    point: Floats
    line: float
    low: Floats
    high: Floats

    @classmethod
    def at(cls, point: Floats, key: float, line: float | None = None) -> Reached:
        """Return one place, of a line that begins there if no other is given."""
        return cls(point, key if line is None else line, np.array([key]), np.array([key]))


class _Walk(NamedTuple):
    """How setpoints and the rows go along each other.

    Attributes:
        chords: How many of the chords are done.
        whole: Whether all are, and the goal may be gone on from.
        out, line: Shape (points,): distance of each point from the lines that it reaches, and which one that is from.
        back, at: Shape (vertices,): distance of each vertex from the chords that reach it, and which one that is from.
        space: Its last state.
    """

    chords: int
    whole: bool
    out: Floats
    line: Ints
    back: Floats
    at: Ints
    space: kernel.FreeSpace

    @property
    def last(self) -> int:
        """The last line that was reached."""
        first, low, _ = self.space.reached()
        return first + len(low) - 1


def excess(
    path: RowLines,
    ends: tuple[Reached, Reached],
    own: Ints,
    motion: Solved,
    first_s: float,
    period_s: float,
    passed: float,
    most: int = PHASES,
) -> tuple[Floats, int]:
    """Return by how much setpoints of a motion, of their own phase and others, are over the tolerance before each node, and the work.

    The distances have shape (k,), mm, the work is about the pairs of a chord and a line that were looked at. −∞ stands where they are
    not, or by no more than a part of it that may be passed. Vertices that are missed count before their own node, else before the one
    that is nearest in time. Where every place is near enough, but not in order, it is what more of the tolerance would do.

    Args:
        path: The rows from where the motion begins to where it ends, or beyond.
        ends: Where on them the setpoint before it is, and places that all have to be reached at its end: the next motion goes on from one.
        own: Shape (vertices,): the node of each vertex of the rows, −1 for none.
        motion: Over all axes.
        first_s: Time of its first setpoint.
        period_s: Time between setpoints.
        passed: Part of the tolerance by which they may be over it.
        most: Phases that are looked at, at most.
    """
    end = np.cumsum(motion.step)
    over = np.full(len(end), -np.inf)
    allowed = (1.0 + passed) * path.tolerance
    beside = np.maximum(np.append(path.tolerance, 0.0), np.insert(path.tolerance, 0, 0.0))
    walker = _Walker(path, *ends)
    tight = tangled(path, own)
    for t in _phases(_bends(motion), motion.step, first_s, period_s, float(path.tolerance.min()), most):
        points, node = _at(motion, t)
        points[0] = ends[0].point
        first = walker.walk(points, allowed)
        if first.whole:
            continue
        less, factor, found = 1.0, 1.0, first
        for more in _FACTORS if tight else _FACTORS[_PLAIN:]:
            less, factor, found = factor, more, walker.walk(points, more * allowed)
            if found.whole:
                break
        if tight:
            factor, found = walker.least(points, allowed, (less, factor), found)
        np.maximum.at(over, node[1:], (found.out - path.tolerance[found.line])[1:])
        seen = np.flatnonzero(np.isfinite(found.back) & (path.key <= max(ends[1].high)))
        chord = found.at[seen]
        way = points[chord + 1] - points[chord]
        part = ((path.points[seen] - points[chord]) * way).sum(axis=1) / np.maximum(
            (way**2).sum(axis=1), 1e-300
        )
        when = t[chord] + np.clip(part, 0.0, 1.0) * (t[chord + 1] - t[chord])
        near = np.minimum(np.searchsorted(end, when), len(end) - 1)
        by = found.back[seen] - beside[seen]
        # Before its own node too, where it has one.
        mine = np.where(own[seen] < 0, near, own[seen])
        for place in (near, mine):
            np.maximum.at(over, place, by)
        if not (over > passed * path.tolerance.max()).any():
            if not tight:
                factor, found = walker.least(points, allowed, (less, factor), found)
            # Vertices that are reached in time only with more of it.
            late = (seen > first.last) & (found.at[seen] <= first.chords)
            stuck = mine[late] if late.any() else node[min(first.chords + 1, len(node) - 1)]
            over[stuck] = (factor * (1.0 + passed) - 1.0) * path.tolerance.max()
    return over, walker.cells


def tangled(path: RowLines, own: Ints) -> bool:
    """Tell whether corners, vertices of the rows that have a node of their own, are so near each other that there are many local optima."""
    corner = np.flatnonzero(own >= 0)
    # Along the rows: a closed contour ends in the corner where it began.
    way = np.concatenate([[0.0], np.cumsum(np.sqrt((np.diff(path.points, axis=0) ** 2).sum(axis=1)))])
    return bool((np.diff(way[corner]) < TIGHT * path.tolerance[corner[1:] - 1]).any())


def reached(
    path: RowLines, entry: Reached, motion: Solved, first_s: float, period_s: float, passed: float, count: int
) -> Reached | None:
    """Return where its last setpoint before node `count` of a motion may be; the arguments are those of `excess`."""
    end = float(np.cumsum(motion.step)[count - 1])
    t = next(_phases(_bends(motion), motion.step, first_s, period_s, float(path.tolerance.min())))
    t = _shown(t, first_s, period_s, end)
    allowed = (1.0 + passed) * path.tolerance
    return _gone(path, entry, _at(motion, t)[0], allowed, allowed)


def followed(
    path: RowLines,
    entry: Reached,
    plan: tuple[Floats, Floats, Callable[[Floats], Floats]],
    first_s: float,
    period_s: float,
    passed: float,
    chord_mm: float,
    whole: bool,
) -> Reached | None:
    """Return where the end of a stretch of the plan may be, or its last setpoint, None where it is too far from the rows.

    Args:
        path, entry, first_s, period_s, passed: As of `excess`.
        plan: Shape (k, n) and (k,), velocities at times from its start to its end, s; and a function of time that returns positions.
        chord_mm: By which chords of the plan may leave the rows where their tolerance is less.
        whole: Whether its end is meant.
    """
    velocity, t, position = plan
    step = np.diff(t)
    bend = np.sqrt((np.diff(velocity, axis=0) ** 2).sum(axis=1)) / np.maximum(step, 1e-12)
    at = next(_phases(bend, step, first_s, period_s, float(path.tolerance.min())))
    at = at if whole else _shown(at, first_s, period_s, float(t[-1]))
    allowed = _PLAN * np.maximum(path.tolerance / USED, chord_mm)
    return _gone(path, entry, position(at), allowed, (1.0 + passed) * path.tolerance)


def _shown(t: Floats, first_s: float, period_s: float, end: float) -> Floats:
    """Return times up to the last setpoint until `end`, of which the first one is where the setpoint before them is."""
    last = first_s + period_s * np.floor((end - first_s) / period_s + _SAME)
    return np.append(t[t < last - _SAME * period_s], last) if last > 0.0 else t[:1]


def _gone(path: RowLines, entry: Reached, points: Floats, allowed: Floats, there: Floats) -> Reached | None:
    """Return where the last of points may be within what is allowed on the way and there."""
    points[0] = entry.point
    walk = _Walker(path, entry).walk(points, allowed)
    if walk.chords < len(points) - 1:
        return None
    first, low, high = walk.space.reached()
    own = slice(first, first + len(low))
    begin, way = path.points[own], np.diff(path.points[first : own.stop + 1], axis=0)
    size = np.maximum((way**2).sum(axis=1), 1e-300)
    foot = ((points[-1] - begin) * way).sum(axis=1) / size
    away = ((points[-1] - begin - foot[:, None] * way) ** 2).sum(axis=1)
    half = np.sqrt(np.maximum(there[own] ** 2 - away, 0.0) / size)
    width = np.diff(path.key[first : own.stop + 1])
    ends = (
        np.maximum(low, foot - half),
        np.where(away <= there[own] ** 2, np.minimum(high, foot + half), -1.0),
    )
    if not (ends[0] <= ends[1]).any():
        return None
    key = path.key[own]
    return Reached(points[-1], float(key[0]), key + ends[0] * width, key + ends[1] * width)


def _bends(motion: Solved) -> Floats:
    """Return the largest acceleration of each interval, shape (k,)."""
    size = np.sqrt((motion.acceleration**2).sum(axis=1))
    return np.maximum(size[1:], size[:-1])


def _phases(
    bend: Floats, step: Floats, first_s: float, period_s: float, tolerance: float, most: int = PHASES
) -> Iterator[Floats]:
    """Yield times of setpoints of a motion and those of its ends, of their own phase and of others; further apart where chords show less.

    Of other phases, the start is there twice: once for the setpoint before it.
    """
    end = np.cumsum(step)
    with np.errstate(divide="ignore"):
        fine = np.sqrt(8.0 * _CHORD * tolerance / bend)
    apart = period_s * np.maximum(np.floor(np.minimum(fine, step) / period_s + _SAME), 1.0)
    count = np.concatenate([[0.0], np.cumsum(step / apart)])
    number = int(np.clip(np.ceil(period_s / fine.min()), 1, most))
    near = np.interp(np.arange(count[-1] + 1.0), count, np.concatenate([[0.0], end])) / period_s
    for phase in range(number):
        own = first_s / period_s + phase / number
        whole = np.ceil(near - own - _SAME)
        inner = period_s * (own + whole[np.append(True, whole[1:] > whole[:-1])])
        inner = inner[np.searchsorted(inner, 0.0, side="right") : np.searchsorted(inner, end[-1])]
        yield np.concatenate([[0.0] * (2 if phase else 1), inner, end[-1:]])


class _Walker:
    """Goes along points and rows from where the points begin on these."""

    def __init__(self, path: RowLines, entry: Reached, goal: Reached | None = None) -> None:
        """Take the rows, where the first point is on them, and what the last one has to reach."""
        self.path, self.goal, self.cells = path, goal, 0
        self.first, self.entry = self._within(entry)
        if goal is not None:
            self.begin, (self.low, self.high) = self._within(goal)
            own = slice(self.begin, self.begin + len(self.low) + 1)
            length = np.sqrt((np.diff(path.points[own], axis=0) ** 2).sum(axis=1))
            self.same = _SAME_PLACE * path.tolerance[own][: len(length)] / np.maximum(length, 1e-300)

    def _within(self, place: Reached) -> tuple[int, Floats]:
        """Return the first line of places, and where on their lines they begin and end, shape (2, k)."""
        first = int(np.searchsorted(self.path.key, place.line))
        key = self.path.key[first : first + len(place.low) + 1]
        width = key[1:] - key[:-1]
        ends = np.stack([place.low, place.high])[:, : len(width)] - key[:-1]
        # A line without length is begun and ended at once.
        return first, ends / np.where(width > 0.0, width, 1.0)

    def walk(self, points: Floats, allowed: Floats) -> _Walk:
        """Go along points, with what each line allows, mm."""
        lines, count = len(allowed), len(points)
        back, at, during = (
            np.full(lines + 1, np.inf),
            np.zeros(lines + 1, np.int64),
            np.full((lines + 1, 2), -1),
        )
        out, line = np.zeros(count), np.zeros(count, np.int64)
        space = kernel.FreeSpace(self.path.points, allowed, True, back, at, during, np.empty((4, lines)))
        space.enter(self.first, self.entry[0].tolist(), np.minimum(self.entry[1], 1.0).tolist())
        done, why = space.run(points, 0, count - 1, 1.0, count, 0, out, line)
        self.cells += space.cells + _WALK
        return _Walk(done, why == kernel.DONE and self._covers(space), out, line, back, at, space)

    def least(
        self, points: Floats, allowed: Floats, between: tuple[float, float], found: _Walk
    ) -> tuple[float, _Walk]:
        """Return a factor on what is allowed that is hardly more than it takes, and the walk with it; `found` is that with the larger one."""
        less, more = between
        for _ in range(_HALVINGS):
            half = 0.5 * (less + more)
            walk = self.walk(points, half * allowed)
            less, more, found = (less, half, walk) if walk.whole else (half, more, found)
        return more, found

    def _covers(self, space: kernel.FreeSpace) -> bool:
        """Tell whether all places of the goal are reached, but for intervals too short to tell."""
        if self.goal is None:
            return True
        first, low, high = space.reached()
        reached = np.full((2, max(self.begin + len(self.low), first + len(low))), np.nan)
        some = np.array(low) <= np.array(high)
        reached[:, first : first + len(low)] = np.where(some, [low, high], np.nan)
        own, same = reached[:, self.begin : self.begin + len(self.low)], self.same
        there = (own[0] <= self.low + same) & (own[1] >= self.low - same)
        return bool(
            (there | (self.high - self.low <= same)).all() and (there & (self.high >= self.low)).any()
        )


def _at(motion: Solved, t: Floats) -> tuple[Floats, Ints]:
    """Return positions at ascending times, shape (k, n), and the interval of each, which ends no earlier than it."""
    points, node = np.empty((len(t), motion.position.shape[1])), np.empty(len(t), np.int64)
    tube_motion.positions(
        motion.position, motion.velocity, motion.acceleration, motion.jerk, motion.step, t, node, points
    )
    return points, node
