"""The breakpoints of a block: where the path must be left at rest, and where its derivatives jump."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.geometry.columns import max_over_axes, norm
from cncgen.geometry.path import Path
from cncgen.geometry.tables import ranges
from cncgen.planner.least_time.breakpoints import NO_TURN, Breakpoints
from cncgen.planner.limits.axis_limits import (
    JUMP_SHARE,
    STEP_TAKES,
    SWAY_SHARE,
    AxisLimits,
    along_path,
    lowered,
    speed_within,
)

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]

#: Part of the jerk limit below which a jump is taken for none.
_NEGLIGIBLE = 2e-4
#: Least part of its speed that a jump keeps beside others, and in how many halvings the part is found.
_SLOWER, _HALVINGS = 0.02, 14
#: The derivative of the quadratic B-spline B over a period, T² B', and the linear one: periods, and values there.
_SLOPE = [-1.5, -0.5, 0.5, 1.5], [0.0, 1.0, -1.0, 0.0]
_HAT = [-1.0, 0.0, 1.0], [0.0, 1.0, 0.0]
#: Periods on either side of a jump in which setpoints see it: half of those that a third difference takes.
SEEN = 1.5
#: Where a corner lies on a chord over it: parts of its length.
_BEFORE = np.linspace(0.0, 1.0, 33)[1:-1]
#: Cost of a jump that is passed on either side of it, in periods: by itself, and where it takes all jerk along the path.
#: So 120 random programs of one to five corners take at most 0.03 % longer than the better one of passing all and stopping at all;
#: with 0.4 and 0.5 some of 150 take 0.4 %, where all are passed 22 of 120 over 0.5 %.
_DELAY, _SLOWED = 0.1, 1.2
#: Part of the largest acceleration that the motion must be allowed where it turns back, else it rests.
_WORTH = 0.25


@dataclass(frozen=True, slots=True)
class Corners:
    """The `n` breakpoints of a block, both ends included.

    Attributes:
        s: Shape (n,), path coordinate.
        stop: Shape (n,), bool: the motion rests there.
        corner: Shape (n,), bool: it rests, or slows, because the derivatives jump.
        speed: Shape (n,), mm/s: largest speed by the jump there; infinite for none, 0 for a stop.
        jump_share: Shape (n, 2, axes): parts of acceleration and jerk limits that the jump takes at that speed, or at the speed
            the path has there for other reasons where that is lower.
        acceleration: Shape (n,), mm/s²: largest size of the acceleration along the path by the jump; infinite for none.
        zone: Shape (n,), mm: how far on both sides a setpoint's third difference can see the jump; 0 for none.
        cuts: Shape (n,), bool: it rests, and chords might cut the corner by more than their tolerance if no setpoint fell
            near it.
        back: Shape (n,), mm/s²: the largest acceleration with which the motion turns back there, without a stay, as the path does; 0
            elsewhere.
    """

    s: Floats
    stop: Bools
    corner: Bools
    speed: Floats
    jump_share: Floats
    acceleration: Floats
    zone: Floats
    cuts: Bools
    back: Floats

    def only(self, kept: Bools | slice) -> Corners:
        """Return those that are kept."""
        return Corners(*(getattr(self, column.name)[kept] for column in fields(self)))


def corners_of(points: Breakpoints, bounds: AxisLimits) -> Corners:
    """Classify breakpoints: those of a block, maybe between those of its neighbours."""
    s, left, right, top = points.s, points.left, points.right, points.top
    stop = points.rest.copy()
    jumps = BlockJumps(bounds, s, left[1], right[1])
    turn = jumps.turn
    linear, square = bounds.jump(turn, right[2] - left[2])
    speed = speed_within(linear, square, JUMP_SHARE)
    held = speed < np.sqrt(top)
    v = np.where(held, speed, 0.0)[:, None]
    lost = jumps.lost(linear * v + square * v**2)
    worth = jumps.break_even(stop | held, top, lost)
    corner = held & (speed < worth)
    passing = np.where(stop | corner, 0.0, speed)
    rises = jumps.rises(points.line, points.in_space)

    def chord_speed(passing: Floats) -> Floats:
        return jumps.chord_speed(passing > 0.0, reached_speeds(np.minimum(passing, np.sqrt(top)), rises))

    chord = chord_speed(passing)
    rest = (chord <= 0.0) & (passing > 0.0)
    if rest.any():
        # Where the chord over a corner asks for rest, chords over others do not reach across.
        passing = np.where(rest, 0.0, passing)
        chord = np.where(rest, 0.0, chord_speed(passing))
    speed = np.minimum(passing, chord)
    v = reached_speeds(np.minimum(speed, np.sqrt(top)), rises)
    together = jumps.together(v)
    speed = np.where(together < v, together, speed)
    v = together[:, None]
    share = STEP_TAKES * linear * v + square * v**2
    felt = (max_over_axes(share) > _NEGLIGIBLE) | (chord < np.sqrt(top))
    corner |= felt & (speed < np.sqrt(top))
    speed[~felt & ~corner & ~stop] = np.inf
    stop |= speed <= 0.0
    passed = felt & ~stop
    back, bent = jumps.back(stop & ~points.rest)
    acceleration, there, sway = jumps.swayed(together, passed)
    seen = passed | (bent > 0.0).any(axis=1)
    zone = jumps.zones(together, np.maximum(there, back)) * seen
    # A pulse of acceleration v Δ is v Δ/T in the second difference that sees it.
    pulse = np.abs(turn) * v / (bounds.acceleration * bounds.period_s)
    return Corners(
        s=s,
        stop=stop,
        corner=corner,
        speed=speed,
        jump_share=np.stack([pulse, share + sway], 1) * passed[:, None, None]
        + np.stack([np.zeros_like(bent), bent], 1),
        acceleration=acceleration,
        zone=zone,
        cuts=jumps.cut(stop) & (back == 0.0),
        back=back,
    )


def rows_beside(path: Path, s: Floats) -> tuple[Ints, Ints]:
    """Return the rows of the stretches before and after corners, shape (n,) each; at the ends that of the only one.

    Several breakpoints that no setpoint can tell apart are one corner. The rows between them are neither before nor after it.

    Args:
        path: The path.
        s: Shape (n,), where the corners are.
    """
    row = path.row_of(0.5 * (s[:-1] + s[1:]))
    return np.insert(row, 0, row[0]), np.append(row, row[-1])


@dataclass(frozen=True, slots=True)
class BlockJumps:
    """The breakpoints of a block, n of them, as jumps of the path's direction.

    Attributes:
        bounds: Limits.
        s: Shape (n,), where they are.
        left, right: Shape (n, axes), dx/ds on both sides.
    """

    bounds: AxisLimits
    s: Floats
    left: Floats
    right: Floats

    @property
    def turn(self) -> Floats:
        """Shape (n, axes): Δ, the step of dx/ds."""
        return self.right - self.left

    def largest(self) -> tuple[Floats, Floats]:
        """Return the acceleration and the jerk along the path that its limits allow on the side that allows more, shape (n,) each."""
        acceleration, jerk = (
            np.maximum(along_path(limit, self.left), along_path(limit, self.right))
            for limit in (self.bounds.acceleration, self.bounds.jerk)
        )
        return acceleration, jerk

    def rises(self, line: Bools, in_space: Bools) -> tuple[Floats, Floats]:
        """Return by how much v² and v^(3/2) change from one to the next at most, shape (n − 1,) each; infinite for no bound.

        On lines these are 2 A d and √(9/2 J) d. The acceleration along a curve in X Y Z is a component of the vector of these axes.

        Args:
            line, in_space: As in `Breakpoints`.
        """
        bounds = self.bounds
        acceleration, jerk = (
            along_path(each, self.right[:-1]) for each in (bounds.acceleration, bounds.jerk)
        )
        # Axes that the machine lacks have none, and do not move.
        three = bounds.acceleration[:3]
        whole = float(np.linalg.norm(three[np.isfinite(three)]))
        bent = np.where(in_space, whole, np.inf)
        apart = np.diff(self.s)
        square = 2.0 * np.where(line, acceleration, bent) * apart
        return square, np.where(line, np.sqrt(4.5 * jerk) * apart, np.inf)

    def lost(self, share: Floats) -> Floats:
        """Return what part of the jerk along the path they take, shape (n,), the mean of both sides; of the axes `share`, shape (n, axes).

        An axis that hardly moves beside the jump leaves the others theirs. With the largest part of any axis one of 126 random programs
        takes 2.9 % longer.
        """
        kept, jerk = 1.0 - share, self.bounds.jerk
        with np.errstate(invalid="ignore"):
            parts = [
                along_path(jerk, side / kept) / along_path(jerk, side) for side in (self.left, self.right)
            ]
        return 1.0 - 0.5 * np.nan_to_num(parts[0] + parts[1])

    def break_even(self, slow: Bools, top: Floats, lost: Floats) -> Floats:
        """Return the speed, shape (n,), mm/s, below which a stop takes less time than to pass (docs/corners.md, Pass or stop).

        Args:
            slow: Shape (n,), which of them hold the speed back, or rest.
            top: Shape (n,), the largest q there.
            lost: Shape (n,), the part of the jerk along the path that each takes.
        """
        bounds, s = self.bounds, self.s
        acceleration, jerk = (
            along_path(each, self.left, self.right) for each in (bounds.acceleration, bounds.jerk)
        )
        slowest = np.minimum(jerk * bounds.period_s, acceleration) * bounds.period_s
        places = np.concatenate([s[:1], s[1:-1][slow[1:-1]], s[-1:]])
        before = s - places[np.maximum(np.searchsorted(places, s) - 1, 0)]
        after = places[np.minimum(np.searchsorted(places, s, side="right"), len(places) - 1)] - s
        speed = np.minimum(np.sqrt(top), elementary.cbrt(0.25 * np.minimum(before, after) ** 2 * jerk))
        reached = np.minimum(acceleration, np.sqrt(speed * jerk))
        return np.maximum(slowest, (_DELAY + _SLOWED * lost) * bounds.period_s * reached)

    def chord_speed(self, moving: Bools, speed: Floats) -> Floats:
        """Return the speed, shape (n,), at which the chord of a period cuts corners by the chord tolerance at most (docs/corners.md).

        Args:
            moving: Shape (n,), which of them are passed.
            speed: Shape (n,), what all else allows.
        """
        bounds, s, period = self.bounds, self.s, self.bounds.period_s
        # Within half a period the largest acceleration leads as far as a jerk of 6 A/T.
        within = np.minimum(bounds.jerk, 6.0 * bounds.acceleration / period)
        jerk = np.maximum(along_path(within, self.left), along_path(within, self.right))
        mm = bounds.scale * (self.turn * moving[:, None])
        size = norm(mm)
        single = np.full(len(s), np.inf)
        turned = size > 0.0
        room = 4.0 * bounds.chord_mm / (period * size[turned])
        single[turned] = np.maximum(room - jerk[turned] * period**2 / 24.0, 0.0)
        fastest = np.minimum(single, speed)
        apart = np.minimum(np.diff(s, prepend=-np.inf), np.diff(s, append=np.inf))
        # A corner with a negligible cut, even if all corners around were like it, is not the one furthest from a chord.
        many = np.searchsorted(s, s + fastest * period, side="right") - np.searchsorted(
            s, s - fastest * period
        )
        alike = 0.25 * many * size * np.where(size > 0.0, fastest, 0.0) * period
        close = np.flatnonzero((alike > _NEGLIGIBLE * bounds.chord_mm) & (apart < fastest * period))

        def kept(part: Floats, at: Ints) -> Bools:
            return chord_cut(s, mm, at, part * fastest[at] * period) <= bounds.chord_mm * (1.0 + _NEGLIGIBLE)

        close = close[~kept(np.ones(len(close)), close)]
        single[close] = fastest[close] * _largest_part(kept, close, _SLOWER)
        return single

    def together(self, speed: Floats) -> Floats:
        """Return the speed, shape (n,), at which those near each other keep to their share, with `speed` for that of those around
        (docs/corners.md, Jumps)."""
        s, period = self.s, self.bounds.period_s
        pulses = self.turn / (self.bounds.jerk * period**2), self.turn / (self.bounds.acceleration * period)
        reach = 2.0 * period * speed
        close = np.flatnonzero(np.minimum(np.diff(s, prepend=-np.inf), np.diff(s, append=np.inf)) < reach)
        size = np.maximum(*(max_over_axes(np.abs(each[close])) for each in pulses))
        close = close[size * speed[close] > _NEGLIGIBLE]

        def kept(part: Floats, at: Ints) -> Bools:
            v = part * speed[at]
            return _weighed(s, pulses, at, v * period) * v <= JUMP_SHARE * (1.0 + _NEGLIGIBLE)

        close = close[~kept(np.ones(len(close)), close)]
        out = speed.copy()
        out[close] *= _largest_part(kept, close, _SLOWER)
        return out

    def swayed(self, speed: Floats, passed: Bools) -> tuple[Floats, Floats, Floats]:
        """Return what the acceleration a along the path does, as a turn Δ adds a step |Δ a| to that of an axis (docs/corners.md, Jumps).

        A motion at the speed v that came from rest, or must come to rest, has the acceleration √(2 j v) at most. The jerk j along
        the path is twice that of the axes at most.

        Args:
            speed: Shape (n,), v, the largest one at each.
            passed: Shape (n,), which of them count.

        Returns:
            The bound of |a| for `SWAY_SHARE` of the jerk limit, shape (n,), infinite where it cannot be passed; the largest |a| there,
            shape (n,); and the part of the jerk limit taken, shape (n, axes).
        """
        bounds, (gain, jerk) = self.bounds, self.largest()
        # Where a curve stands, its control points being one, no limit bounds the jerk along it: but at rest none counts.
        from_rest = np.multiply(jerk, speed, out=np.zeros_like(speed), where=speed > 0.0)
        reached = np.minimum(gain, 2.0 * np.sqrt(from_rest))
        period, turn = bounds.period_s, np.abs(self.turn * passed[:, None])
        most_there = along_path(SWAY_SHARE * 2.0 * period * bounds.jerk, turn)
        sway = np.minimum(turn * reached[:, None] / (2.0 * period * bounds.jerk), SWAY_SHARE)
        # Beside a pulse smaller than that, the step has more weight than where the pulse has most.
        less = np.maximum(sway - turn * speed[:, None] / (period**2 * bounds.jerk), 0.0)
        sway += np.divide(less**2, 2.0 * sway, out=np.zeros_like(sway), where=less > 0.0)
        return np.where(most_there < reached, most_there, np.inf), np.minimum(most_there, reached), sway

    def zones(self, speed: Floats, there: Floats) -> Floats:
        """Return how far from them the motion comes while setpoints see them, shape (n,), mm.

        Meanwhile the speed v, shape (n,), rises (or falls) from the acceleration `there`, shape (n,), up to its limit, at full jerk.
        """
        gain, jerk = self.largest()
        seen = self.bounds.period_s * SEEN
        rise = np.minimum(gain, there + jerk * seen / 3.0)
        return seen * (speed + 0.5 * seen * rise)

    def cut(self, stop: Bools) -> Bools:
        """Tell which are rests, of those that `stop`, that the chord of a period may cut by more than the chord tolerance, shape (n,).

        In the time t from rest, or to it, an axis goes J t³/6 or A t²/2 at most. Of the path under a chord over the rest, no place is
        further than that from an end of the chord, t being a period.
        """
        bounds, t = self.bounds, self.bounds.period_s
        way = bounds.scale * np.minimum(bounds.jerk * t**3 / 6.0, bounds.acceleration * t**2 / 2.0)
        # Axes that the machine lacks do not move.
        far = norm(np.where(np.isfinite(way), way, 0.0)) > bounds.chord_mm
        out: Bools = stop & (norm(bounds.scale * self.turn) > NO_TURN) & far
        return out

    def back(self, may: Bools) -> tuple[Floats, Floats]:
        """Return the largest acceleration with which the motion turns back, and what of the jerk limit that takes.

        Without speed the axes have the acceleration x' a on both sides. A setpoint falls half a period T from the tip at most, in which
        the motion goes a T²/8 + j T³/48: that is kept within the chord tolerance. Where the path does not turn back quite straight, their
        acceleration has a step Δ a, which takes `SWAY_SHARE` of the jerk limit at most.

        Args:
            may: Shape (n,), where it may turn back.

        Returns:
            The acceleration, shape (n,), mm/s²; 0 where the path does not turn back, or where it is small. The part of the jerk limit that
            the step takes, shape (n, axes), 0 where that is next to nothing.
        """
        bounds, t = self.bounds, self.bounds.period_s
        out = along_path(bounds.acceleration, self.left, self.right)
        jerk = along_path(bounds.jerk, self.left, self.right)
        step = 0.75 * np.abs(self.left + self.right) / (bounds.jerk * t)
        size = norm(bounds.scale * self.right)
        with np.errstate(divide="ignore", invalid="ignore"):
            seen = 8.0 * bounds.chord_mm / (size * t**2) - jerk * t / 6.0
            most = np.minimum(seen, SWAY_SHARE / max_over_axes(step))
            back = np.where(may & (most > _WORTH * out), np.minimum(out, most), 0.0)
        taken = step * back[:, None]
        return back, np.where(taken > _NEGLIGIBLE, taken, 0.0)


def reached_speeds(speed: Floats, rises: tuple[Floats, Floats]) -> Floats:
    """Return the speed of each corner, shape (n,), bounded by the corners around it.

    Args:
        speed: Shape (n,), v that each of them allows.
        rises: Shape (n − 1,) each, by how much v² and v^(3/2) change from one to the next at most.
    """
    for power, rise in zip((2.0, 1.5), rises, strict=True):
        height = elementary.power(speed, power)
        way = np.concatenate([[0.0], np.cumsum(np.minimum(rise, height.max()))])
        least = lowered(height, way)
        # A speed that nothing around lowers keeps its digits: ways over many corners have few of those of a slow one.
        speed = np.where(least < height, elementary.power(np.maximum(least, 0.0), 1.0 / power), speed)
    return speed


def _weighed(s: Floats, pulses: tuple[Floats, Floats], at: Ints, step: Floats) -> Floats:
    """Return what differences over the periods around some jumps see of all jumps, by the speed, for the worst axis (docs/corners.md, Jumps).

    Args:
        s: Shape (n,), where the jumps are.
        pulses: Shape (n, axes) each: the jumps, in what the limits of jerk and of acceleration allow one alone, by the speed.
        at, step: Shape (k,), which of them, and the way of a period there.
    """
    if not len(at):
        return np.zeros(0)
    first = np.searchsorted(s, s[at] - 2.0 * step)
    last = np.searchsorted(s, s[at] + 2.0 * step, side="right")
    count = last - first
    begin = np.cumsum(count) - count
    owner, each = ranges(first, count)
    away = (s[each] - s[at][owner]) / step[owner]
    largest = np.zeros(len(at))
    for phase, times, weights, jump in (
        (-0.5, *_SLOPE, pulses[0]),
        (0.5, *_SLOPE, pulses[0]),
        (0.0, *_HAT, pulses[1]),
    ):
        weight = np.interp(away - phase, times, weights)
        total = np.add.reduceat(jump[each] * weight[:, None], begin)
        largest = np.maximum(largest, max_over_axes(np.abs(total)))
    return largest


def chord_cut(s: Floats, turn: Floats, at: Ints, length: Floats) -> Floats:
    """Return how far chords of a length are from corners that of all they go over they are the furthest from, (k,), mm (docs/corners.md).

    Chords are looked at that have parts `_BEFORE` of their length before the corner. |D| is largest at corners, where it rises before and
    falls behind.

    Args:
        s, turn: Shape (n,) and (n, axes), where the corners are, and Δ there, mm.
        at, length: Shape (k,), which of them, and of the chord over each.
    """
    if not len(at):
        return np.zeros(0)
    here, own = s[at], turn[at]
    sums, moments = (
        np.concatenate([np.zeros((1, turn.shape[1])), np.cumsum(each, axis=0)])
        for each in (turn, turn * (s - s[0])[:, None])
    )
    largest = np.zeros(len(at))
    for before in _BEFORE:
        start, end = here - before * length, here + (1.0 - before) * length
        first, last = np.searchsorted(s, start), np.searchsorted(s, end, side="right")
        # Σ Δ_i times the ways from the start of the chord, of those before the corner, and times those to its end.
        behind = (moments[at] - moments[first]) - (sums[at] - sums[first]) * (start - s[0])[:, None]
        ahead = (sums[last] - sums[at]) * (end - s[0])[:, None] - (moments[last] - moments[at])
        beside = before * ahead + (1.0 - before) * behind
        slope = (ahead - behind) / length[:, None]
        rise, fall = np.einsum("ij,ij->i", beside, slope), np.einsum("ij,ij->i", beside, own - slope)
        far = np.sqrt(np.einsum("ij,ij->i", beside, beside))
        largest = np.where((rise >= 0.0) & (fall >= 0.0), np.maximum(largest, far), largest)
    return largest


def _largest_part(kept: Callable[[Floats, Ints], Bools], at: Ints, least: float) -> Floats:
    """Return the largest part, from `least` to 1, of the speed at jumps `at` with which something is kept, shape (k,)."""
    low, high = np.full(len(at), least), np.ones(len(at))
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        good = kept(middle, at)
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    return low
