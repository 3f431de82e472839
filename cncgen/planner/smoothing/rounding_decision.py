"""Which corners are worth rounding, and how far: those where the rounded path takes less time than the path as it is.

As it is, a corner is passed slowly, or the motion stops in it. All times are estimates in closed form for a corner and the
two rows beside it (docs/rounding.md); times of changes of speed are those of Biagiotti and Melchiorri (2008), section 3.4.
`stream` calls `rounding` before it fits a spline.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.geometry.columns import min_over_axes, norm
from cncgen.geometry.corridor import AROUND, FACETS, RUN_PART, WIDEST
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.limits.bend_speeds import across, chord_speed
from cncgen.planner.limits.speed_changes import change_time, peak_speed, rise_time
from cncgen.planner.smoothing.bend_time import REACH, Way, bends, response, turned
from cncgen.planner.smoothing.row_corners import BEND, TWIST, RowCorners
from cncgen.planner.smoothing.tolerance_estimate import chord_need
from cncgen.planner.smoothing.tolerance_split import chord_left, chord_room, fit_tolerance

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]

#: Part of the jerk limit that a step of the tangent takes at most, and speed, as a multiple of J T², below which a stop costs less:
#: `JUMP_SHARE` and `STOP_SPEED` of `cncgen.planner.limits.axis_limits`.
_SHARE, _STOP = 0.75, 1.0
#: Length of the rows beside a corner, in smoothing lengths, from which it is rounded independently of its neighbours; and from
#: which it is still weighed by itself where chords bound the speed.
_ALONE, _CROWDED = 3.0, 0.5
#: Largest slope of the smoothing length along the path, as in `cncgen.kernels.smoothing_lengths`.
_GRADE = 0.4
#: The way on each side of a corner that takes as long as if it were passed at the corner's own speed, in smoothing lengths: where
#: jerk bounds that speed (to which (c + c³)/2 is added, c the cosine between the directions), where acceleration does, and where
#: chords do and setpoints are dense. Fitted to 4500 plans of single corners, and set somewhat higher than their median, so that
#: what is chosen to be rounded is faster (docs/rounding.md).
_WAY_BY_JERK, _WAY_BY_ACCELERATION, _WAY_BY_CHORD = -0.3, 1.3, 1.2
#: Part of the excess that is added to that way if a period leads further than a smoothing length. Setpoints then cannot show
#: the bend in detail, so it costs more time. Same plans.
_WAY_BEYOND_PERIOD = 0.1
#: Time on each side, in periods, that a corner whose speed chords hold takes longer if it turns back by 180°; times −c else.
_TURNED_BACK = 0.5
#: Time on each side, in periods, that passing a corner unrounded costs: always, and in proportion to the part λ of the jerk along
#: the path that the corner takes.
_EXACT_ALWAYS, _EXACT_BY_JERK = 0.15, 1.5
#: Acceleration away from a rounded corner takes longer than from a rest by this part of the time in which the acceleration grows,
#: as nodes are placed there in geometric distances (docs/evidence.md). The median is 0.0125; this is the largest that was seen,
#: from places slower than J T², so that a corner is rounded only where that is certainly faster than a stop.
_RAMP_LOSS = 0.035
#: Number of smoothing lengths, each √2 times shorter than the one before, that are tried where chords bound the speed.
_TRIED = 17
#: Row of the chord bound in what `_rounded_speeds` returns.
_BY_CHORD = 2
#: Stops at all corners of a curve that chords hold are chosen only if they take less than this part of the estimated time of the
#: curve: the estimates are not more precise.
_SURELY = 0.95
#: Where chords hold the speed at a step of curvature: up to this multiple of the chord tolerance P is left to the chords alone; a
#: larger P may spread the step onto a line by this many ways of a period at most.
_NARROW, _SPREAD = 1.5, 3.0
#: Turn up to which two rows go on without a corner.
_NONE = 1e-6


@dataclass(frozen=True, slots=True)
class CornerSide:
    """One side of corners: limits along the row, and the largest speed on it."""

    acceleration: Floats
    jerk: Floats
    top: Floats

    def of(self, corners: NDArray[np.int64]) -> CornerSide:
        """Return that of some of the corners."""
        return CornerSide(self.acceleration[corners], self.jerk[corners], self.top[corners])

    def lost(self, speed: Floats) -> Floats:
        """Return the time lost by slowing from the top speed to `speed`, mm/s, at the corner (0 for a stop), s.

        A change of speed from v to V in the time f covers f (v + V)/2, for which the top speed needs f (v + V)/(2 V).
        """
        change = np.maximum(self.top - speed, 0.0)
        return change_time(change, self.acceleration, self.jerk) * change / (2.0 * self.top)

    def ramp(self, speed: Floats) -> Floats:
        """Return how long the acceleration grows in a change from `speed` to the top speed: the first of its phases, s."""
        change = np.maximum(self.top - speed, 0.0)
        return rise_time(change, self.acceleration, self.jerk)

    def crawled(self, way: Floats, speed: Floats) -> Floats:
        """Return the time lost on a way, mm, that is passed at `speed` instead of the top speed, s."""
        return way * np.maximum(1.0 / speed - 1.0 / self.top, 0.0)


def rounding(
    drive: AxisLimits, corners: RowCorners, before: float = 0.0, fit: Floats | None = None
) -> tuple[Floats, Floats]:
    """Return the largest smoothing length at each corner that is worth it, and the speed at which it is passed.

    Rounded with L = 3 P/|Δ| a turn Δ is passed at the largest speed v at which its curvature (acceleration), the change of that
    (jerk) and the chords keep to their limits. On each side that costs the change of speed down to v, and a way of about L
    at v. Unrounded, setpoints see its step of the tangent as a jerk of v Δ/T² and an acceleration of v Δ/T, and the chord cuts
    it by v T |Δ|/4; or the motion stops. Where chords bound v it grows only with √L, so a shorter L may take less time.

    Args:
        drive: See there.
        corners: Of consecutive rows; n of them have n + 1 rows.
        before: Speed at the start of the first row.
        fit: Shape (n,), what the smoothed path may leave the corners by, mm; None for what chords leave each.

    Returns:
        Shape (n,) each: mm, 0 for corners to be met exactly, infinite where the tolerance is what bounds it; mm/s, that of
        the corner rounded as far as the tolerance allows.
    """
    turn = np.where(corners.joined[:, None], corners.entry - corners.leave, 0.0)
    size = norm(turn)
    widest = np.full(len(size), np.inf)
    if not len(size):
        return widest, widest
    if fit is None:
        fit = fit_tolerance(corners.tolerance, drive.chord_reserve_mm, chord_need(drive, corners))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        length = _graded(3.0 * fit / size, corners.length[1, :-1])
        speeds = _rounded_speeds(drive, turn, length, BEND * size / length, corners.tolerance)
        speed, by_chord = speeds.min(axis=0), speeds.argmin(axis=0) == _BY_CHORD
        room = corners.length.min(axis=0)
        alone = room >= _ALONE * length
        beside = corners.length.max(axis=0) >= _ALONE * length
        looked_at = (size >= _NONE) & (alone | (by_chord & ((room >= _CROWDED * length) | beside)))
        at = np.flatnonzero(looked_at)
        if len(at):
            passing = np.append(np.where(corners.joined, speed, 0.0), [0.0, before])
            beyond = passing[at - 1], passing[at + 1]
            leave, entry = corners.leave[at], corners.entry[at]
            curved, out = largest_bend(leave, entry), bends(leave, entry)
            fitted = np.minimum(
                length, CornerPolyline.of(corners, corners.joined).longest(corners.tolerance)
            )[at]
            widest[at] = _Judged(drive, corners, at, turn, fitted, curved, out, beyond).worth()
        rest = corners.joined & (size >= _NONE) & ~looked_at
        if rest.any():
            widest[_better_stopped(drive, corners, turn, fit, rest, widest > 0.0)] = 0.0
    widest = np.minimum(widest, _steps(drive, corners, turn, size))
    return widest, speed


def _steps(drive: AxisLimits, corners: RowCorners, turn: Floats, size: Floats) -> Floats:
    """Return the largest smoothing length that is worth it where curves meet whose chords hold the speed below what the step
    of curvature between them allows as it is, shape (n,), mm: 0 for none, infinite elsewhere.

    Setpoints see that step, Δ, as ¾ v² |Δ|/T of jerk, and it may take `_SHARE`; and the turn there may be, see `_passed_speed`.
    Then what smoothing uses of a narrow tolerance is better left to the chords. Of a wide one some ways of a period do: where
    chords bound the speed a turn takes ∫ κ^½ ds of time, the longer the further it is spread onto a line.

    Args:
        drive, corners: See `rounding`.
        turn: Shape (n, axes), Δx'.
        size: Shape (n,), |Δx'|.
    """
    step = corners.bend.sum(axis=0)
    gain = np.maximum(np.abs(corners.leave), np.abs(corners.entry))
    # A rotary axis that stands there has no part in it.
    jerk = min_over_axes(np.where(~drive.rotary | (gain > 0.0), drive.jerk, np.inf))
    with np.errstate(divide="ignore", invalid="ignore"):
        by_chord = chord_speed(corners.bend.max(axis=0), drive.chord_mm, drive.period_s)
        passed = np.sqrt(_SHARE / 0.75 * jerk * drive.period_s / step)
        corner = _passed_speed(drive, np.abs(turn), size)
        corner[corner < _STOP * min_over_axes(drive.jerk / gain) * drive.period_s**2] = 0.0
    held = corners.joined & (step > 0.0) & (np.minimum(passed, corner) >= by_chord)
    narrow = corners.tolerance <= _NARROW * drive.chord_mm
    onto_line = corners.bend.min(axis=0) == 0.0
    wide = np.where(onto_line, _SPREAD * by_chord * drive.period_s, np.inf)
    return np.where(held, np.where(narrow, 0.0, wide), np.inf)


def _better_stopped(
    drive: AxisLimits, corners: RowCorners, turn: Floats, fit: Floats, among: Bools, rounded: Bools
) -> Bools:
    """Tell which corners chords hold so that a stop at each of them takes less time, shape (n,).

    Amid rows shorter than their smoothing lengths all corners bend the way together. So consecutive corners are weighed
    together, by the time of half of the row on either side of each.

    Args:
        drive, corners, fit: See `rounding`.
        turn: Shape (n, axes), Δ.
        among: Shape (n,), the corners that are weighed.
        rounded: Shape (n,), those that are rounded so far.
    """
    size, apart = norm(turn), corners.length[1, :-1]
    out = np.zeros(len(size), bool)
    at = np.flatnonzero(among)
    group = np.cumsum(np.diff(at, prepend=-1) > 1)
    # An upper bound first: were all of the turn made on the shorter row beside it, and full jerk of all axes used between stops.
    ways = ways_between_turns(corners, size)
    near, far = ways.min(axis=0)[at], ways.max(axis=0)[at]
    steep = chord_speed(size[at] / near, 0.5 * drive.chord_mm, drive.period_s)
    reached = elementary.cbrt(0.25 * np.linalg.norm(drive.jerk) * far**2)
    held = steep < np.minimum(reached, corners.feed[:, at].max(axis=0))
    if not held.any():
        return out
    seen = (np.bincount(group, held) > 0.0)[group]
    at, group = at[seen], group[seen]
    course = CornerPolyline.of(corners, corners.joined & rounded)
    most = np.minimum(3.0 * fit / size, course.longest(corners.tolerance))
    length = _graded(np.where(course.joined, most, np.inf), apart)
    # Nor is it longer than the curve that the corners are lets it be, which it would leave by some L³ κ² (`cncgen.geometry.corridor`).
    curved = course.bend(at, ways.max(axis=0)[at])
    with np.errstate(divide="ignore"):
        length[at] = np.minimum(length[at], elementary.cbrt(fit[at] / curved**2))
    bend = course.bend(at, length[at])
    chord = _rounded_speeds(drive, turn[at], length[at], bend, corners.tolerance[at])[_BY_CHORD]
    stopped, bent = np.zeros((2, len(at)))
    for k, direction in enumerate((corners.leave[at], corners.entry[at])):
        half, feed = 0.5 * ways[k, at], corners.feed[k, at]
        arc = chord_speed(corners.bend[k, at], drive.chord_mm, drive.period_s)
        # Speed that the row reaches between two stops, and speed that it allows besides.
        side, free = (
            _side(drive, direction, 2.0 * half, np.minimum(feed, arc), np.full(len(at), v))
            for v in (0.0, np.inf)
        )
        stopped += half / side.top + 0.5 * change_time(side.top, side.acceleration, side.jerk)
        slow, near = np.minimum(half, _WAY_BY_CHORD * length[at]), np.minimum(chord, free.top)
        # Where the feed holds the curve, that is shorter than the lines.
        bent += np.where(chord < free.top, slow / near, 0.0) + (half - slow) / np.maximum(near, side.top)
    out[at] = (np.bincount(group, stopped) < _SURELY * np.bincount(group, bent))[group]
    return out


def ways_between_turns(corners: RowCorners, size: Floats) -> Floats:
    """Return how far the turns before and after each corner are, shape (2, n), mm: a row that is cut in parts is one way.

    Args:
        corners: See `rounding`.
        size: Shape (n,), |Δx'|.
    """
    s = np.cumsum(np.append(corners.length[0, :1], corners.length[1]))
    turns = np.flatnonzero((size >= _NONE) | ~corners.joined)
    places = np.concatenate([[0.0], s[turns], s[-1:]])
    here = s[:-1]
    return np.stack(
        [
            here - places[np.searchsorted(turns, np.arange(len(size)))],
            places[np.searchsorted(turns, np.arange(len(size)), side="right") + 1] - here,
        ]
    )


def _graded(length: Floats, apart: Floats) -> Floats:
    """Return smoothing lengths as they are beside shorter ones of the corners before and after.

    Args:
        length: Shape (n,), mm.
        apart: Shape (n − 1,), from one corner to the next, mm.
    """
    out = length.copy()
    out[1:] = np.minimum(out[1:], length[:-1] + _GRADE * apart)
    out[:-1] = np.minimum(out[:-1], length[1:] + _GRADE * apart)
    return out


@dataclass(frozen=True, slots=True)
class CornerPolyline:
    """The polyline that turns at corners as the path does, and is straight between: n of them have n + 1 rows.

    Attributes:
        s: Shape (n + 2,), mm: path coordinate of the ends of rows.
        place: Shape (n + 2, axes), mm.
        step: Shape (n + 1, axes): dx/ds on each row.
        run: Shape (2, n): the corners with which each corner's run begins and ends.
        joined: Shape (n,): whether each is in a run.
    """

    s: Floats
    place: Floats
    step: Floats
    run: NDArray[np.int64]
    joined: Bools

    @classmethod
    def of(cls, corners: RowCorners, joined: Bools) -> CornerPolyline:
        """Return that of corners of which those `joined`, shape (n,), are in a run with what is beside them."""
        length = np.append(corners.length[0, :1], corners.length[1])
        turn = np.where(joined[:, None], corners.entry - corners.leave, 0.0)
        steps = corners.leave[0] + np.concatenate([np.zeros_like(turn[:1]), np.cumsum(turn, axis=0)])
        s = np.append(0.0, np.cumsum(length))
        place = np.concatenate([np.zeros_like(steps[:1]), np.cumsum(steps * length[:, None], axis=0)])
        index = np.arange(len(joined))
        first = np.maximum.accumulate(np.where(joined, 0, index + 1))
        last = np.minimum.accumulate(np.where(joined, index[-1], index - 1)[::-1])[::-1]
        return cls(s, place, steps, np.stack([first, last]), joined)

    def bend(self, at: NDArray[np.int64], length: Floats) -> Floats:
        """Return |x''| at corners where all others of their runs are rounded too, shape (k,), 1/mm.

        The response of a turn is about as wide as a triangle of the height 1/(3 L): the second difference of the path, which
        goes straight on beyond its run, over 3 L on either side.

        Args:
            at: Shape (k,), which corners; all joined.
            length: Shape (k,), smoothing length there, mm.
        """
        step = length / BEND
        first, last = self.run[:, at]
        begin, end = self.s[first], self.s[last + 2]
        here = self.s[at + 1]
        back, on = np.maximum(here - step, begin), np.minimum(here + step, end)
        before, after = (
            np.stack([np.interp(s, self.s, column) for column in self.place.T], axis=-1) for s in (back, on)
        )
        before -= (back - (here - step))[:, None] * self.step[first]
        after += (here + step - on)[:, None] * self.step[last + 1]
        out: Floats = norm(before - 2.0 * self.place[at + 1] + after) / step**2
        return out

    def longest(self, tolerance: Floats) -> Floats:
        """Return the largest smoothing length that a fit has at each corner, shape (n,), mm (`cncgen.geometry.corridor`)."""
        n = len(self.joined)
        index = np.arange(n)
        first = np.maximum(index + 1 - AROUND, self.run[0])
        last = np.minimum(index + 1 + AROUND, self.run[1] + 2)
        facets = FACETS * (self.s[last] - self.s[first]) / (last - first)
        run = self.s[self.run[1] + 2] - self.s[self.run[0]]
        out: Floats = np.minimum(np.maximum(WIDEST * tolerance, facets), RUN_PART * run)
        return out


def _bend(turn: Floats, length: Floats, apart: Floats, at: NDArray[np.int64]) -> Floats:
    """Return |x''| at corners, shape (k,), to which the next two on either side add theirs.

    Args:
        turn: Shape (n, axes), Δ.
        length: Shape (k,), smoothing length at the corners.
        apart: See `_graded`.
        at: Shape (k,), which corners.
    """
    place = np.concatenate([[0.0], np.cumsum(apart)])
    total = np.zeros((len(at), turn.shape[1]))
    for k in range(-2, 3):
        there = (at + k >= 0) & (at + k < len(turn))
        other = np.where(there, at + k, at)
        total += (there * response(np.abs(place[other] - place[at]) / length))[:, None] * turn[other]
    out: Floats = norm(total) / length
    return out


def largest_bend(leave: Floats, entry: Floats) -> Floats:
    """Return the largest |x''| L across x' where single corners are rounded, shape (n,): that along x' bends no chord.

    Args:
        leave, entry: Shape (n, axes), x' before and after.
    """
    turn = entry - leave
    slowest = -np.einsum("ij,ij->i", leave, turn) / np.einsum("ij,ij->i", turn, turn)
    s = np.linspace(0.0, 3.0, 61)
    made, there = turned(s), response(s)
    out = np.zeros(len(leave))
    for part in (0.02, 0.1, 0.25, 0.5, 0.75, 0.9, 0.98, np.clip(slowest, 0.02, 0.98)):
        parts = np.broadcast_to(part, len(leave))
        bend = across(leave + parts[:, None] * turn, turn, np.ones(turn.shape[1]))
        out = np.maximum(out, np.interp(np.abs(parts - 0.5), made, there) * bend)
    return out


@dataclass(frozen=True, slots=True)
class _Judged:
    """RowCorners whose rounding is weighed against none.

    Attributes:
        drive, corners: See `rounding`.
        at: Shape (k,), which corners.
        turn: Shape (n, axes), Δ of all.
        length: Shape (k,), the L that the tolerance allows.
        across: Shape (k,), largest |x''| across x' times L where a corner is rounded by itself.
        bends: Shape (2, steps + 1, k), that on the way out of it (`bend_time.bends`).
        beyond: Shape (k,) each, the speed at the other end of the row before and after.
    """

    drive: AxisLimits
    corners: RowCorners
    at: NDArray[np.int64]
    turn: Floats
    length: Floats
    across: Floats
    bends: Floats
    beyond: tuple[Floats, Floats]

    def worth(self) -> Floats:
        """Return the smoothing length that is worth it, as `rounding` does."""
        drive, leave, entry = self.drive, self.corners.leave[self.at], self.corners.entry[self.at]
        rows, feed = self.corners.length[:, self.at], self.corners.feed[:, self.at]
        sides = [_side(drive, u, rows[k], feed[k], self.beyond[k]) for k, u in enumerate((leave, entry))]
        one, two = leave / drive.jerk, entry / drive.jerk
        norms = norm(one) * norm(two)
        alike = np.einsum("ij,ij->i", one, two) / norms
        best, bound = self._cost(sides, alike, self.length)
        out, by_chord = np.full(len(best), np.inf), bound == _BY_CHORD
        few = np.flatnonzero(by_chord)
        if few.size:
            slow = replace(
                self,
                at=self.at[few],
                length=self.length[few],
                across=self.across[few],
                bends=self.bends[..., few],
                beyond=(self.beyond[0][few], self.beyond[1][few]),
            )
            best[few], out[few] = slow._shorter([side.of(few) for side in sides], alike[few], best[few])
        return np.where(best < self._unrounded(sides), out, 0.0)

    def _unrounded(self, sides: list[CornerSide]) -> Floats:
        """Return the time that corners cost as they are, shape (k,): passed, where that takes less, or in a stop."""
        drive, turn = self.drive, np.abs(self.turn[self.at])
        ways = np.abs(self.corners.leave[self.at]), np.abs(self.corners.entry[self.at])
        speed = _passed_speed(drive, turn, norm(turn))
        left = drive.jerk - turn * speed[:, None] / drive.period_s**2
        stop, passed = np.zeros((2, len(speed)))
        for side, gain in zip(sides, ways, strict=True):
            taken = 1.0 - min_over_axes(left / gain) / side.jerk
            late = (_EXACT_ALWAYS + _EXACT_BY_JERK * taken) * drive.period_s
            stop += side.lost(np.zeros_like(speed))
            passed += side.lost(speed) + late * np.maximum(1.0 - speed / side.top, 0.0)
        return np.minimum(passed, stop)

    def _shorter(self, sides: list[CornerSide], alike: Floats, best: Floats) -> tuple[Floats, Floats]:
        """Return what shorter lengths cost where that is less than `best`, and which; infinite where none does."""
        k = len(best)
        room = self.corners.length[:, self.at].min(axis=0)
        # The same lengths are tried whatever P is. So a larger P can always use the length that is best for a smaller one.
        unit = self.drive.chord_reserve_mm / norm(self.turn[self.at])
        first = np.ceil(2.0 * elementary.log2(self.length / unit)) - 1.0
        tried = unit * elementary.exp2(0.5 * (first - np.arange(_TRIED)[:, None]))
        every = np.tile(np.arange(k), _TRIED)
        several = replace(self, at=self.at[every], across=self.across[every], bends=self.bends[..., every])
        cost, _ = several._cost([side.of(every) for side in sides], alike[every], tried.ravel())
        cost = np.where(room >= _CROWDED * tried, cost.reshape(tried.shape), np.inf)
        out = np.full(k, np.inf)
        for length, lost in zip(tried, cost, strict=True):
            better = lost < (1.0 - 1e-9) * best
            best, out = np.where(better, lost, best), np.where(better, length, out)
        return best, out

    def _cost(
        self, sides: list[CornerSide], alike: Floats, length: Floats
    ) -> tuple[Floats, NDArray[np.int64]]:
        """Return the time that corners rounded with a length cost, shape (k,), and what bounds their speed."""
        drive, tolerance = self.drive, self.corners.tolerance[self.at]
        bend = self.across / length
        crowded = np.flatnonzero(self.corners.length[:, self.at].min(axis=0) < _ALONE * length)
        if crowded.size:
            apart, at = self.corners.length[1, :-1], self.at[crowded]
            bend[crowded] = np.maximum(bend[crowded], _bend(self.turn, length[crowded], apart, at))
        speeds = _rounded_speeds(drive, self.turn[self.at], length, bend, tolerance)
        speed, bound = speeds.min(axis=0), speeds.argmin(axis=0)
        by_jerk = elementary.power(speed / speeds[0], 3.0)
        step = speed * drive.period_s
        beyond = _WAY_BEYOND_PERIOD * np.maximum(step - length, 0.0)
        jerked = _WAY_BY_JERK + 0.5 * (alike + elementary.power(alike, 3.0))
        by_chord = bound == _BY_CHORD
        other = np.where(by_chord, _WAY_BY_CHORD / (1.0 + step / length), _WAY_BY_ACCELERATION)
        half = 0.5 * self.corners.length[:, self.at]

        def lost(parts: Floats) -> Floats:
            way = np.minimum(parts * length + beyond, half)
            return np.stack([side.lost(speed) + side.crawled(way[k], speed) for k, side in enumerate(sides)])

        cost = lost(by_jerk * jerked + (1.0 - by_jerk) * other)
        held = np.flatnonzero(by_chord)
        if held.size:
            made = self._held(held, [side.of(held) for side in sides], length[held], bend[held])
            part = by_jerk[held]
            alone = part * lost(jerked)[:, held] + (1.0 - part) * made
            # Where the path turns back, every axis must stop and start again at once.
            alone = alone + _TURNED_BACK * drive.period_s * np.maximum(-alike[held], 0.0)
            short = half[:, held] < REACH * length[held]
            cost[:, held] = np.where(short, np.maximum(alone, cost[:, held]), alone)
        return cost.sum(axis=0) + sum(_RAMP_LOSS * side.ramp(speed) for side in sides), bound

    def _held(
        self, which: NDArray[np.int64], sides: list[CornerSide], length: Floats, bend: Floats
    ) -> Floats:
        """Return the time that corners lose on each side whose speed chords hold, shape (2, n).

        Args:
            which: Shape (n,), of those that are weighed.
            sides, length, bend: Of these: limits, L, and the largest |x''| in the middle.
        """
        drive, at = self.drive, self.at[which]
        deviation = BEND * np.linalg.norm(self.turn[at], axis=1) * length
        left = chord_left(
            chord_room(self.corners.tolerance[at], deviation, drive.chord_reserve_mm), drive.chord_reserve_mm
        )
        # Where rows are short, neighbouring corners bend this way too.
        curved = self.bends[..., which] * (bend / self.across[which])
        half = 0.5 * self.corners.length[:, at]
        lost = []
        for k, side in enumerate(sides):
            way = Way(
                curved[k], length, half[k], left, side.acceleration, side.jerk, side.top, drive.period_s
            )
            lost.append(way.lost())
        return np.stack(lost)


def _side(drive: AxisLimits, direction: Floats, length: Floats, feed: Floats, beyond: Floats) -> CornerSide:
    """Return the side of corners on rows of a direction, that reach the speed `beyond` at their other ends."""
    gain = np.abs(direction)
    acceleration = min_over_axes(drive.acceleration / gain)
    jerk = min_over_axes(drive.jerk / gain)
    reached = np.maximum(peak_speed(length, acceleration, jerk), beyond)
    return CornerSide(
        acceleration, jerk, np.minimum(np.minimum(feed, min_over_axes(drive.velocity / gain)), reached)
    )


def _rounded_speeds(
    drive: AxisLimits, turn: Floats, length: Floats, bend: Floats, tolerance: Floats
) -> Floats:
    """Return the speeds at which jerk, acceleration and chords let rounded turns be passed, shape (3, n), mm/s.

    Args:
        drive: See there.
        turn: Shape (n, axes), Δ.
        length, bend, tolerance: Shape (n,), L, largest |x''| and P.
    """
    size = np.abs(turn)
    jerk = elementary.cbrt(min_over_axes(drive.jerk / size) * length**2 / TWIST)
    acceleration = np.sqrt(min_over_axes(drive.acceleration / size) * length / BEND)
    deviation = BEND * np.sqrt(np.einsum("ij,ij->i", turn, turn)) * length
    left = chord_left(chord_room(tolerance, deviation, drive.chord_reserve_mm), drive.chord_reserve_mm)
    chord = chord_speed(bend, left, drive.period_s)
    return np.stack([jerk, acceleration, chord])


def _passed_speed(drive: AxisLimits, turn: Floats, size: Floats) -> Floats:
    """Return the speed at which corners may be passed that are not rounded, mm/s.

    Args:
        drive: See there.
        turn: Shape (n, axes), |Δ| of each axis.
        size: Shape (n,), |Δ|.
    """
    period = drive.period_s
    jerk, acceleration = (min_over_axes(limit / turn) for limit in (drive.jerk, drive.acceleration))
    passed = np.minimum(_SHARE * jerk * period**2, acceleration * period)
    return np.minimum(passed, 4.0 * drive.chord_mm / (period * size))
