"""Chords between setpoints, measured on a planned motion: where they are too far from the path, bounds of q are lowered, and
`rolling_window` solves again (docs/corners.md, Chords elsewhere).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Span
from cncgen.geometry.columns import max_over_axes, norm
from cncgen.geometry.tables import ranges
from cncgen.kernels import planned_motion
from cncgen.planner.least_time.breakpoints import NO_TURN
from cncgen.planner.least_time.mesh import LINE, SPLINE, Mesh
from cncgen.planner.least_time.motion_pieces import MotionPieces
from cncgen.planner.least_time.problem import Intervals, Solution, middles
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.motion import motion_at
from cncgen.planner.record import Limit, Profile

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

#: Part by which a chord may exceed its tolerance before bounds are lowered, and the part of the tolerance they are lowered to.
_OVER, _AIM = 2e-4, 0.9995
#: Part of the tolerance beyond which no plan is better than one with such chords: `verify` sees more.
LOST = 1.001
#: Parts of a period at which chords begin: when looking for chords that may be too long, and when comparing them with the path,
#: which is done at as many places along each chord.
_COARSE, _FINE = 8, 32
#: Around the phase where the distance is largest the search is refined this often, into so many parts.
_CLOSER, _CLOSE = 3, 8
#: Chords are looked for that begin in this many periods at the end of an interval: earlier ones lie within the interval, where
#: only its own speed changes.
_LATE = 2.0
#: Periods that a bend from rest to rest is made to take where the chord from one end to the other is too long: less than one, and no
#: setpoint may be on it.
_BRIEF = 1.05
#: Largest ratio of curvatures along a chord for which x'' is taken to be one parabola along it. Without it, where chords of 0.05 µm bind
#: on all of a butterfly, so many are measured that it takes 1.5 times the CPU.
_SMOOTH = 1.3


@dataclass(frozen=True, slots=True)
class MeshPath:
    """The path under a row of intervals.

    Attributes:
        parts: Tracks in a row, and which of their intervals.
        bounds: Limits.
    """

    parts: list[tuple[Mesh, slice]]
    bounds: AxisLimits

    def positions(self, interval: Ints, along: Floats) -> Floats:
        """Return positions, shape (k, axes), mm (a degree counted as a millimetre).

        Args:
            interval: Shape (k,), ascending numbers of intervals.
            along: Shape (k,), mm from the start of each.
        """
        out = np.zeros((len(interval), len(self.bounds.scale)))
        first = 0
        for mesh, rows in self.parts:
            last = first + rows.stop - rows.start
            here = slice(*np.searchsorted(interval, [first, last]).tolist())
            if here.start < here.stop:
                s = mesh.s[interval[here] - first + rows.start] + along[here]
                out[here] = mesh.path.evaluate(s, 0)[0] * self.bounds.scale
            first = last
        return out

    def breakpoints(self) -> Floats:
        """Return the ways from the first interval on to the places where derivatives may jump, shape (k,), ascending, mm."""
        found, way = [], 0.0
        for mesh, rows in self.parts:
            first, last = mesh.s[[rows.start, rows.stop]]
            s = mesh.path.breakpoints()
            found.append(s[(s > first) & (s < last)] - first + way)
            way += last - first
        return np.concatenate(found)

    def tolerance(self) -> Floats:
        """Return how far chords may be from the path on each interval, shape (n,), mm."""
        return np.concatenate([mesh.chord[rows] for mesh, rows in self.parts])

    def line_at(self, way: float) -> Span:
        """Return the line of the program at a way from the first interval on, mm."""
        for mesh, rows in self.parts:
            first, last = mesh.s[[rows.start, rows.stop]]
            if way <= last - first:
                break
            way -= last - first
        return mesh.toolpath.span(mesh.path.row_of(np.array([first + way]))[0])


@dataclass(frozen=True, slots=True)
class _Compared:
    """Chords of a period, `k` of them, and how far they are from the path.

    Attributes:
        phase: Shape (k,), when they begin, in parts of a period.
        begin, end: Shape (k,), between which ways they lie.
        tip: Shape (k,), the way where the path is furthest from them.
        over: Shape (k,), the largest distance as a part of the tolerance.
    """

    phase: Ints
    begin: Floats
    end: Floats
    tip: Floats
    over: Floats

    def peaks(self) -> Ints:
        """Return the phases around which the distance may exceed the tolerance."""
        rise, beside = np.diff(self.over), np.diff(self.phase) == 1
        size = np.abs(rise) * beside
        more = np.maximum(np.append(0.0, size), np.append(size, 0.0))
        below = np.append((rise > 0.0) & beside, False) | np.append(False, (rise < 0.0) & beside)
        return self.phase[~below & (more > _OVER) & (self.over + more > 1.0 + _OVER)]


@dataclass(frozen=True, slots=True)
class ChordedMotion:
    """A motion over `n` intervals.

    Attributes:
        given, found: The intervals, of which these are the first, and the motion on them as it was solved.
        course, profile: The path, and the motion in time from 0; its s is the way from the first interval on.
        owner: Shape (pieces,), the interval of each piece.
        s, t: Shape (n + 1,), way and time at the nodes.
        speed: Shape (n,), largest v on each interval, mm/s.
        bend: Shape (n, 3), |x''| at its start, middle and end, 1/mm, by which the path leaves its chord.
        sharpest: Shape (n,), the largest of them.
        corner: Shape (n,), |Δx'| at its start.
        end: Shape (n,), how many intervals there are up to the next rest in a corner, or to the last.
        tolerance: Shape (n,), mm.
        period: T, s.
    """

    given: Intervals
    found: Solution
    course: MeshPath
    profile: Profile
    owner: Ints
    s: Floats
    t: Floats
    speed: Floats
    bend: Floats
    sharpest: Floats
    corner: Floats
    end: Ints
    tolerance: Floats
    period: float

    @classmethod
    def of(
        cls, given: Intervals, found: Solution, course: MeshPath, pieces: MotionPieces, n: int
    ) -> ChordedMotion:
        """Look at the first `n` intervals; chords that end beyond are left to later calls."""
        profile, owner = pieces.profile(given.h[:n])
        offset, v = pieces.offset[: n + 1], profile.v
        seen = np.empty((6, n))
        planned_motion.bends(given.h[:n], given.x1, given.x2, course.bounds.scale, found.q, v, offset, seen)
        speed, sharpest, corner, *bend = seen
        corner[corner < NO_TURN] = 0.0
        stands = v[offset[:-1]] == 0.0
        rest = np.append(np.flatnonzero(stands & (corner > 0.0)), n)
        return cls(
            given=given,
            found=found,
            course=course,
            profile=profile,
            owner=owner,
            s=np.append(0.0, np.cumsum(given.h[:n])),
            t=profile.t[offset],
            speed=speed,
            bend=np.stack(bend, axis=1),
            sharpest=sharpest,
            corner=corner,
            end=rest[np.searchsorted(rest, np.arange(n), side="right")],
            tolerance=course.tolerance()[:n],
            period=course.bounds.period_s,
        )

    def held(self, everywhere: bool) -> Intervals | None:
        """Return the intervals with lower bounds of q where chords leave the path by more than their tolerance; None if none does.

        Chords of all phases of setpoints are held, but for those over a rest in a corner: there the motion waits for a setpoint instead.

        Args:
            everywhere: Whether bounds are lowered under all of each chord that is too long, and not only under a chord of the required
                length around the place furthest from it.
        """
        begin, end, _ = self._brief()
        if len(begin):
            # Once they take a period, their chords are measured like all others.
            slower = (self._time(begin, end) / (_BRIEF * self.period)) ** 2
            return self._lowered(begin, 0.5 * (begin + end), end, slower)
        begin, end, tip, over = self._measured(self._too_long(self._suspects()))
        if not len(begin):
            return None
        shorter = _AIM / over
        if everywhere:
            return self._lowered(begin, tip, end, shorter**2)
        begin, end = tip - shorter * (tip - begin), tip + shorter * (end - tip)
        worst = _worst(begin, tip, end, over)
        begin, tip, end = begin[worst], tip[worst], end[worst]
        return self._lowered(begin, tip, end, (self._time(begin, end) / self.period) ** 2)

    def furthest(self) -> tuple[float, float]:
        """Return how far a chord is at most from the path, as a part of its tolerance, and the way to that place, mm.

        It is 0 where none passes its tolerance.
        """
        begin, end, far = self._brief()
        _, _, tip, over = self._measured(self._too_long(self._suspects()))
        places, parts = np.concatenate([0.5 * (begin + end), tip, [0.0]]), np.concatenate([far, over, [0.0]])
        worst = int(np.argmax(parts))
        return float(parts[worst]), float(places[worst])

    def _brief(self) -> tuple[Floats, Floats, Floats]:
        """Return between which ways the motion goes from rest to rest in less than a period, too far from the chord, shape (k,) each, and how
        far these are from the chord, as parts of the tolerance; at its end it rests where it is over all intervals."""
        nodes = np.append(0 if self.profile.v[0] == 0.0 else self.end[0], np.unique(self.end))
        first, last = nodes[:-1], nodes[1:]
        if len(self.speed) < len(self.given):
            first, last = first[:-1], last[:-1]
        length = self.s[last] - self.s[first]
        soon = (last > first) & (self.t[last] - self.t[first] < self.period)
        first, last, length = first[soon], last[soon], length[soon]
        at = np.flatnonzero(self._may_pass(length, first, last, _over(self.sharpest, first, last)))
        away = np.array([self._away(int(first[k]), int(last[k])) for k in at])
        far = away > 1.0 + _OVER
        return self.s[first[at[far]]], self.s[last[at[far]]], away[far]

    def _away(self, first: int, last: int) -> float:
        """Return how far the path over intervals is from the chord over all of them, as a part of the tolerance."""
        part = np.arange(_CLOSE) / _CLOSE
        interval = np.repeat(np.arange(first, last), _CLOSE)
        along = (np.diff(self.s)[first:last, None] * part).ravel()
        x = self.course.positions(interval, along)
        end = self.course.positions(np.array([last - 1]), np.diff(self.s)[last - 1 : last])
        away = distances_from_chords(x, np.repeat(x[:1], len(x), axis=0), np.repeat(end, len(x), axis=0))
        return float((away / self.tolerance[interval]).max())

    def _suspects(self) -> Floats:
        """Return when chords begin that may be too long by the largest speed and curvature in reach, shape (k,), ascending."""
        first = np.arange(len(self.speed))
        last = np.minimum(np.searchsorted(self.t, self.t[1:] + self.period), self.end)
        length = self.period * _over(self.speed, first, last)
        at = np.flatnonzero(self._may_pass(length, first, last, _over(self.sharpest, first, last)))
        begin = np.maximum(self.t[at], self.t[at + 1] - _LATE * self.period)
        count = np.ceil(_COARSE * (self.t[at + 1] - begin) / self.period).astype(np.int64)
        step = np.repeat((self.t[at + 1] - begin) / count, count)
        start = np.repeat(begin, count) + step * ranges(np.zeros_like(count), count)[1]
        return start[start + self.period <= np.repeat(self.t[self.end[at]], count)]

    def _too_long(self, start: Floats) -> Floats:
        """Return those of the chords from `start` on that may be too long by their length and the curvature along them."""
        one, other = (motion_at(self.profile, start + more).s for more in (0.0, self.period))
        first = np.clip(np.searchsorted(self.s, one, side="right") - 1, 0, len(self.speed) - 1)
        last = np.maximum(np.searchsorted(self.s, other), first + 1)
        sharpest = _over(self.sharpest, first, last)
        places = np.stack([self.s[:-1], 0.5 * (self.s[:-1] + self.s[1:]), self.s[1:]], axis=1).ravel()
        near = [np.interp(part, places, self.bend.ravel()) for part in (one, 0.5 * (one + other), other)]
        # For x'' a parabola along the chord, its middle is (x''₀ + 10 x''₁ + x''₂) ℓ²/96 beside it.
        parabola = (near[0] + 10.0 * near[1] + near[2]) / 12.0
        smooth = sharpest <= _SMOOTH * np.minimum.reduce(near)
        bend = np.where(smooth, np.minimum(parabola, sharpest), sharpest)
        return start[self._may_pass(other - one, first, last, bend)]

    def _may_pass(self, length: Floats, first: Ints, last: Ints, bend: Floats) -> Bools:
        """Tell whether chords over the intervals `first` to before `last` may pass the least of their tolerances.

        With Green's function of the second derivative, at most ℓ/4, a bend κ is ℓ² κ/8 beside the chord, a corner ℓ |Δ|/4.
        """
        turned = np.cumsum(self.corner)
        corners = turned[last - 1] - turned[first]
        least = np.maximum(-_over(-self.tolerance, first, last), self._floor(corners > 0.0))
        out: Bools = length * (length * bend / 8.0 + corners / 4.0) > (1.0 + _OVER) * least
        return out

    def _floor(self, cornered: Bools) -> Floats:
        """Return the least tolerance of chords over corners, shape (k,), 0 for others: smoothing ends before them."""
        return np.where(cornered, self.course.bounds.chord_mm, 0.0)

    def _measured(self, start: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Compare chords about those from `start` on with the path.

        Returns: Of the chords that are too far from it: their begins and ends on the way, the places of the path furthest from them,
            and the largest distances as parts of the tolerance. Shape (k,) each.
        """
        if not len(start):
            return (np.zeros(0),) * 4
        parts = _FINE
        about = np.arange(-2, _FINE // _COARSE + 2)
        phase = np.unique((np.floor(start * (parts / self.period))[:, None] + about).astype(np.int64))
        found = []
        for left in range(_CLOSER, -1, -1):
            compared = self._compared(phase, parts)
            found.append(compared)
            # Over a tip, what a chord leaves out grows with its phase up to where its ends are as far from it, and falls from
            # there.
            top = _CLOSE * compared.peaks()
            if not (left and len(top)):
                break
            parts *= _CLOSE
            phase = np.unique(top[:, None] + np.arange(1 - _CLOSE, _CLOSE))
        over = np.concatenate([each.over for each in found])
        far = over > 1.0 + _OVER
        begin, end, tip = (
            np.concatenate(column)[far]
            for column in zip(*((each.begin, each.end, each.tip) for each in found), strict=True)
        )
        return begin, end, tip, over[far]

    def _time(self, begin: Floats, end: Floats) -> Floats:
        """Return how long the motion takes from one place to another, shape (k,), s."""
        one, other = (np.interp(place, self.s, self.t) for place in (begin, end))
        return other - one

    def _lowered(self, begin: Floats, tip: Floats, end: Floats, part: Floats) -> Intervals:
        """Return the intervals whose bounds of q are parts of the q that they have, under chords between two ways with one between; shape (k,)
        each."""
        given, s, found = self.given, self.s, self.found
        n = len(s) - 1
        middle = 0.5 * (s[:-1] + s[1:])
        # A chord within one interval does not go over its middle.
        within = np.clip(np.searchsorted(s, tip, side="right") - 1, 0, n - 1)
        first = np.minimum(np.searchsorted(middle, begin), within)
        last = np.maximum(np.searchsorted(middle, end, side="right"), within + 1)
        chord, at = ranges(first, np.maximum(last - first, 0))
        here, spline = found.q[:n], given.kind[:n] == SPLINE
        # Beside a rest, the bound is that of the moving end.
        values = np.repeat(max_over_axes(here)[:, None], 3, axis=1)
        values[spline, ::2] = here[spline, ::2]
        values[spline, 1] = middles(given.h[:n][spline], here[spline], found.way[:n][spline])
        top, top_limit, node_top = given.top.copy(), given.top_limit.copy(), given.node_top.copy()
        curved = given.kind[at] != LINE
        chord, at = chord[curved], at[curved]
        np.minimum.at(top, at, part[chord, None] * values[at])
        top_limit[at] = Limit.CHORD
        first, last = np.searchsorted(s[:-1], begin), np.searchsorted(s[:-1], end, side="right")
        chord, at = ranges(first, last - first)
        moving = here[at, 0] > 0.0
        chord, at = chord[moving], at[moving]
        np.minimum.at(node_top, at, part[chord] * here[at, 0])
        return replace(given, top=top, top_limit=top_limit, node_top=node_top)

    def _compared(self, phase: Ints, parts: int) -> _Compared:
        """Compare chords that begin at ascending phases, in parts of a period, with the path."""
        step, every = self.period / parts, parts // _FINE
        phase = phase[(phase >= 0) & ((phase + parts) * step <= self.t[-1])]
        ticks = np.unique((phase[:, None] + every * np.arange(_FINE + 1)).ravel())
        motion = motion_at(self.profile, ticks * step)
        interval = self.owner[motion.piece]
        along = motion.s - self.s[interval]
        x = self.course.positions(interval, along)
        at, last = np.searchsorted(ticks, phase), np.searchsorted(ticks, phase + parts)
        clear = self.end[interval[at]] >= interval[last] + (along[last] > 0.0)
        at, last, phase = at[clear], last[clear], phase[clear]
        turned = np.cumsum(self.corner)[interval]
        floor = self._floor(turned[last] > turned[at])
        away = np.zeros((_FINE + 1, len(at)))
        for k in range(1, _FINE):
            here = np.searchsorted(ticks, phase + every * k)
            tolerance = np.maximum(self.tolerance[interval[here]], floor)
            away[k] = distances_from_chords(x[here], x[at], x[last]) / tolerance
        own, furthest = np.arange(len(at)), away.argmax(axis=0)
        over = away[furthest, own]
        places = motion.s[np.searchsorted(ticks, phase + every * np.arange(_FINE + 1)[:, None])]
        return _Compared(phase, places[0], places[-1], places[furthest, own], over)


def _worst(begin: Floats, tip: Floats, end: Floats, over: Floats) -> Ints:
    """Return which chords to shorten first: the worst, and of the others those about places that none of these goes over.

    Args:
        begin, end: Shape (k,), between which ways they are to lie.
        tip: Shape (k,), the places furthest from them.
        over: Shape (k,), how far these are.
    """
    chosen = []
    left = np.argsort(-over, kind="stable")
    while len(left):
        chosen.append(left[0])
        left = left[1:]
        left = left[(tip[left] < begin[chosen[-1]]) | (tip[left] > end[chosen[-1]])]
    return np.array(chosen)


def distances_from_chords(x: Floats, a: Floats, b: Floats) -> Floats:
    """Return the distances of points from chords, shape (k,), all given as (k, axes)."""
    chord, side = b - a, x - a
    square = np.einsum("ij,ij->i", chord, chord)
    part = np.einsum("ij,ij->i", chord, side) / np.where(square > 0.0, square, 1.0)
    return norm(side - np.clip(part, 0.0, 1.0)[:, None] * chord)


def _over(values: Floats, first: Ints, last: Ints) -> Floats:
    """Return the largest of values from `first` to before `last`, shape (k,)."""
    pairs = np.stack([first, last], axis=1).ravel()
    out: Floats = np.maximum.reduceat(np.append(values, -np.inf), pairs)[::2] if len(pairs) else np.zeros(0)
    return out
