"""The length of a rest in a corner for which the chord between setpoints over it keeps to the tolerance (docs/corners.md, Rests); called by
`timeline`. The times of setpoints are known after the motion up to the rest is planned.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, NoPlanError
from cncgen.geometry import elementary
from cncgen.planner.least_time.chord_refinement import LOST, MeshPath
from cncgen.planner.least_time.mesh import Mesh
from cncgen.planner.least_time.motion_pieces import MotionPieces
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.motion import motion_at
from cncgen.planner.record import Profile

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Part of a period that counts as no time.
_ROUNDING = 1e-6
#: The shortest wait is found by trying this many at once, and as many between the best two of them, in so many rounds.
_TRIED, _ROUNDS = 17, 3
#: Part of the tolerance that chords keep to; the rest is for interpolating between the waits that are tried.
_KEPT = 0.9999
#: Where the path is compared with a chord, beside nodes: parts of an interval.
_PARTS = np.array([0.0, 0.25, 0.5, 0.75])


#: Times of the start that are tried within the first period; how often the interval between two of them is halved; and the length
#: of a motion in periods from which the choice is not made, as less than one period of it no longer matters. Where all start at once,
#: four of 126 random programs take 0.7 to 1.7 % longer.
_STARTS, _HALVINGS, _SHORT = 16, 8, 100.0


@dataclass(frozen=True, slots=True)
class PathMotion:
    """A path under intervals, and a motion on it.

    Attributes:
        course: The path.
        s: Shape (n + 1,), way at the nodes, mm.
        breaks: Ways at all breakpoints of the path, ascending: where several of them are one node, any may be the corner's tip.
        profile: The motion, whose s is that way.
    """

    course: MeshPath
    s: Floats
    breaks: Floats
    profile: Profile

    @classmethod
    def planned(cls, course: MeshPath, h: Floats, pieces: MotionPieces) -> PathMotion:
        """Return what is planned on intervals of the lengths `h`: way and time from 0 on, without waits."""
        s = np.concatenate([[0.0], np.cumsum(h)])
        return cls(course, s, course.breakpoints(), pieces.profile(h)[0])

    @classmethod
    def gone(cls, mesh: Mesh, profile: Profile, bounds: AxisLimits) -> PathMotion:
        """Return the part of a mesh that is handed on."""
        course = MeshPath([(mesh, slice(0, len(mesh)))], bounds)
        return cls(course, mesh.s, mesh.s[0] + course.breakpoints(), profile)

    def at(self, t: Floats) -> Floats:
        """Return the ways at times, which do not fall, shape (k,)."""
        return motion_at(self.profile, t).s

    def positions(self, s: Floats) -> tuple[Floats, Ints]:
        """Return places, shape (k, axes), at ascending ways, and their intervals."""
        interval = np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, len(self.s) - 2)
        return self.course.positions(interval, s - self.s[interval]), interval

    def between(self, begin: float, end: float) -> tuple[Floats, Floats, Floats]:
        """Return what is compared with chords from way to way: ways, shape (k,), places, shape (k, axes), and tolerances.

        The first and the last are `begin` and `end`. Nodes have the narrower tolerance of both sides; over a corner none
        is less than the chord tolerance, as smoothing ends before it.
        """
        first, last = np.searchsorted(self.s, [begin, end], side="right") - 1
        there = np.arange(max(int(first), 0), min(int(last) + 1, len(self.s) - 1))
        inner = (self.s[there, None] + (self.s[there + 1] - self.s[there])[:, None] * _PARTS).ravel()
        breaks = self.breaks[slice(*np.searchsorted(self.breaks, [begin, end]).tolist())]
        inner = np.sort(np.concatenate([inner, breaks]))
        ways = np.concatenate([[begin], inner[(inner > begin) & (inner < end)], [end]])
        places, interval = self.positions(ways)
        own = self.course.tolerance()
        before = np.where(ways == self.s[interval], own[np.maximum(interval - 1, 0)], np.inf)
        tolerance = np.minimum(own[interval], before)
        return ways, places, _KEPT * np.maximum(tolerance, self.course.bounds.chord_mm)


@dataclass(slots=True)
class SetpointAlignment:
    """The rests of a row of intervals, one after the other.

    Attributes:
        way: The motion that is planned there.
        past: Motions that have been handed on, ascending; at least up to a period before.
        stands: Intervals that begin at a rest which lasts, or may have to.
        real, moving: Times at which the motion comes to rests, and leaves them, and those without waits.
    """

    way: PathMotion
    past: list[PathMotion]
    stands: Ints
    real: list[float]
    moving: list[float]

    def lengthened(self, node_t: Floats, dwells: Floats) -> Floats:
        """Return how much longer than its dwell each rest lasts, shape (n,), s.

        Args:
            node_t: Shape (n + 1,), s: when the motion is at the nodes, without waits.
            dwells: Shape (≥ n,), s: the dwells that the program asks for at them.
        """
        out = np.zeros(len(node_t) - 1)
        period = self.way.course.bounds.period_s
        ends = np.append(node_t[self.stands], node_t[-1])[1:]
        for k, following in zip(self.stands.tolist(), ends.tolist(), strict=True):
            moving = float(node_t[k])
            arrival = self.real[-1] + moving - self.moving[-1]
            leave = arrival + float(dwells[k])
            # A wait as short as rounding does not count.
            last = np.floor(leave / period + _ROUNDING) * period
            if last < arrival - _ROUNDING * period:
                out[k] = self._wait(float(last), moving, last + period - leave, following)
            self.real += [arrival, leave + float(out[k])]
            self.moving += [moving, moving]
        return out

    def _wait(self, last: float, moving: float, due: float, following: float) -> float:
        """Return how long to wait so that the chord over a rest keeps to the tolerance, s: until the next setpoint at most.

        The path is followed up to the next rest at most, since there the motion can wait for the same setpoint.

        Args:
            last: When the setpoint before was.
            moving: When the rest is left, without waits.
            due: How long after it the next setpoint is.
            following: When the next rest is reached, without waits.

        Raises:
            NoPlanError: Waiting does not help, as the chord is too far from the path before the rest.
        """
        ways, x, tolerance = self._under(last, min(moving + due, following))
        if _most(x, tolerance) <= 1.0:
            return 0.0
        low, high = 0.0, due
        for _ in range(_ROUNDS):
            waits = np.linspace(low, high, _TRIED)
            ends = self.way.at(np.minimum(moving + due - waits, following)[::-1])
            other, _ = self.way.positions(ends)
            over = _over(x, tolerance, ways[None, :] < ends[::-1, None], other[::-1])
            kept = np.flatnonzero(over <= 1.0)
            if not len(kept):
                if over[-1] > LOST:
                    raise NoPlanError(_cut_off(float(over[-1]), last))
                return due
            if not kept[0]:
                return low
            after = int(kept[0])
            low, high = waits[after - 1], waits[after]
        # From rest the way is as t³.
        one, least = elementary.cbrt(over[[after - 1, after]])
        return float(low + (high - low) * (one - 1.0) / (one - least))

    def _under(self, last: float, end: float) -> tuple[Floats, Floats, Floats]:
        """Return what `PathMotion.between` does from the setpoint at a time `last` up to `end`, a time without waits.

        Ways before the row are less than 0.
        """
        until = self.way.at(np.array([end])).item()
        if last >= self.real[0]:
            k = bisect_right(self.real, last)
            moved = self.moving[k - 1] + last - self.real[k - 1]
            moved = min([moved, *self.moving[k : k + 1]])
            return self.way.between(self.way.at(np.array([moved])).item(), until)
        found = [self.way.between(0.0, until)]
        for way in self.past[::-1]:
            begun = float(way.profile.t[0]) <= last
            since = way.at(np.array([last])).item() if begun else float(way.profile.s[0])
            end_s = float(way.profile.s[-1])
            ways, places, tolerance = way.between(since, end_s)
            found.insert(0, (ways - end_s - 1.0, places, tolerance))
            if begun:
                break
        ways, places, tolerance = (np.concatenate(each) for each in zip(*found, strict=True))
        return ways, places, tolerance


def started(
    way: PathMotion, stands: Ints, node_t: Floats, dwells: Floats, ends: bool
) -> tuple[Floats, float]:
    """Return how much longer than its dwell each rest of a motion that starts lasts, shape (n,), s, and when it starts: within the first period
    such that it takes the least time and meets no more setpoints (docs/corners.md, The way back). Of long motions that is next to nothing.

    Args:
        way: The planned motion.
        stands, node_t, dwells: As of `SetpointAlignment.lengthened`; none of the intervals is the first.
        ends: Whether the motion ends with them; else the rest must not be later.
    """
    period = way.course.bounds.period_s
    least = float(node_t[-1] + dwells[: len(node_t) - 1].sum())

    def from_start(at: float) -> tuple[float, float, Floats]:
        longer = SetpointAlignment(way, [], stands, [at], [0.0]).lengthened(node_t, dwells)
        return least + float(longer.sum()), at, longer

    best = from_start(0.0)
    if best[0] - least <= _ROUNDING * period or best[0] > _SHORT * period:
        return best[2], 0.0
    latest = (np.ceil(best[0] / period - _ROUNDING) if ends else best[0] / period + _ROUNDING) * period
    tried = np.append(np.arange(1, _STARTS) / _STARTS * period, latest - least)
    for at in np.sort(tried[(tried > 0.0) & (tried < period)]).tolist():
        found = from_start(at)
        if found[0] + at <= latest + _ROUNDING * period and found[0] < best[0]:
            best = found
    low, high = best[1], best[1] + period / _STARTS
    for _ in range(_HALVINGS if best[0] > least else 0):
        found = from_start(0.5 * (low + high))
        if found[0] + found[1] <= latest + _ROUNDING * period and found[0] < best[0]:
            best, low = found, found[1]
        else:
            high = found[1]
    return best[2], best[1]


def hold_chord(past: list[PathMotion], begin: float, end: float) -> None:
    """See that the chord between two times keeps to the tolerance of the path under it.

    Args:
        past: The motion that was handed on, ascending in time.
        begin, end: Times of two setpoints, s; the second one may be after the end of the motion.

    Raises:
        NoPlanError: It does not.
    """
    found = []
    for way in past:
        low, high = np.clip([begin, end], *way.profile.t[[0, -1]])
        if low < high:
            _, x, tolerance = way.between(*way.at(np.array([low, high])).tolist())
            found.append((x, tolerance))
    if found:
        x, tolerance = (np.concatenate(each) for each in zip(*found, strict=True))
        over = _most(x, tolerance)
        if over > LOST:
            raise NoPlanError(_cut_off(over, begin))


def _cut_off(over: float, last: float) -> Diagnostic:
    """Say that a chord to a rest is too far from the path."""
    return Diagnostic(
        "plan-over-limits",
        f"no plan was found that keeps the chord tolerance: the setpoint after {last:.4f} s of the motion would lie beyond a curve "
        f"between two rests, {over:.4g} times the tolerance from it",
        hint="take a shorter period or a wider chord tolerance: the curve takes less than a period",
    )


def _most(x: Floats, tolerance: Floats) -> float:
    """Return how far places are at most from the chord from the first to the last, as a part of their tolerance."""
    return float(_over(x, tolerance, np.ones((1, len(x)), bool), x[-1:])[0])


def _over(x: Floats, tolerance: Floats, under: NDArray[np.bool_], end: Floats) -> Floats:
    """Return how far places are at most from chords that are gone along with them, as parts of their tolerance, shape (k,).

    The chord does not turn back where the path does: of monotone places on it the nearest are halfway between the furthest so far and the
    least to come.

    Args:
        x, tolerance: Shape (m, axes) and (m,), places in their order; chords begin at the first.
        under: Shape (k, m), which of the places lie under each chord, the first ones.
        end: Shape (k, axes), where the chords end.
    """
    chord, side = end - x[0], x - x[0]
    square = np.einsum("ka,ka->k", chord, chord)
    along = np.clip(chord @ side.T / np.where(square > 0.0, square, 1.0)[:, None], 0.0, 1.0)
    ahead = np.minimum.accumulate(np.where(under, along, 1.0)[:, ::-1], axis=1)[:, ::-1]
    part = 0.5 * (np.maximum.accumulate(along, axis=1) + ahead)
    away = side[None] - part[..., None] * chord[:, None]
    far = np.sqrt(np.einsum("kma,kma->km", away, away)) / tolerance
    out: Floats = np.where(under, far, 0.0).max(axis=1)
    return out
