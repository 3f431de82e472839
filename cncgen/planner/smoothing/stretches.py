"""Lines that go straight on, and arcs that go on about one centre, are joined to one row before smoothing (docs/smoothing.md, Runs), so
cutting a line in two has no effect.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.columns import norm
from cncgen.geometry.tables import ranges
from cncgen.planner.limits.axis_limits import axis_scale
from cncgen.planner.smoothing.circles import OFF, TURN, Circles, arcs_of, goes_on
from cncgen.planner.smoothing.runs import LEAST_TOLERANCE
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath
from cncgen.toolpath.slicing import between

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Part of the tolerance by which ends of parts may be off the straight line: room for coordinates rounded in their last
#: places, and a thousandth of the room of arcs.
_OFF = 1e-6
#: Part of the speed by which that of parts may differ, and may at most where parts are so short that the room for
#: coordinates is more of them than that: speeds of G93 come from lengths, of arcs whose centres are rounded too, and from
#: F, of which eight digits may be known.
SAME, _SAME_WHERE_SHORT = 1e-7, 1e-5
#: Part of the largest turn of a stretch that is not straight, from which another turn counts: lines are cut there.
_NO_TURN = 1e-3
#: Largest number of parts of a row: the parts of a stretch wait in memory for its end.
_MOST = 512


@dataclass(frozen=True, slots=True)
class Stretches:
    """A toolpath in which lines that go straight on, and arcs that go on, are one row: m of them, of n ≥ m parts.

    Attributes:
        rows: Each with the line of its first part.
        parts: The programmed parts, with their ends moved onto the straight line or the arc.
        first: Shape (m + 1,): where the parts of each row begin, and n.
        part_length: Shape (n,), mm: how long parts are: lines over all axes, arcs in X Y Z.
        off: Shape (m,), mm: by how much the parts of each row, as programmed, are off it at most; 0 for lines.
    """

    rows: Toolpath
    parts: Toolpath
    first: Ints
    part_length: Floats
    off: Floats

    @classmethod
    def of(cls, parts: Toolpath) -> Stretches:
        """Join rows that go on under G64 at the same speed."""
        places = np.concatenate([parts.start[None], parts.end])
        turning = _pairs(parts, Kind.ARC)
        round_on = goes_on(parts, places[:-1], turning)
        arcs = np.union1d(turning, turning - 1)
        curved = arcs_of(parts, places[:-1], arcs).length
        scaled = places * axis_scale(parts.axes, parts.degree_mm)
        steps = np.diff(scaled, axis=0)
        length = np.sqrt(np.einsum("ij,ij->i", steps, steps))
        length[arcs] = curved
        joined = _straight_on(parts, steps, length)
        joined[_alike(parts, length, turning[round_on])] = True
        if not joined.any():
            return cls(parts, parts, np.arange(len(parts) + 1), length, np.zeros(len(parts)))
        joined = _straight(_bounded(joined), scaled, parts)
        joined, circles = _round(joined, parts, places[:-1])
        first = np.append(np.flatnonzero(~joined), len(parts))
        rows, off = _joined(parts, length, first), np.zeros(len(first) - 1)
        at = np.searchsorted(first, circles.first)
        off[at] = circles.off
        aligned = circles.parts_onto(_aligned(parts, length, first))
        return cls(circles.rows_onto(rows, at), aligned, first, length, off)

    def but_last(self) -> Stretches:
        """Return these without the last row."""
        first = self.first[:-1]
        stop = int(first[-1])
        rows = parts = between(self.parts, 0, stop)
        if len(first) < len(parts) + 1:
            rows = between(self.rows, 0, len(first) - 1)
        return Stretches(rows, parts, first, self.part_length[:stop], self.off[: len(first) - 1])

    def part_off(self) -> Floats:
        """Return `off` of each part, those below the rounding of coordinates left out, shape (n,)."""
        off = np.where(self.off > _OFF * self.rows.tolerance, self.off, 0.0)
        return np.repeat(off, np.diff(self.first))

    def within(self, rows: Ints, most: int) -> int:
        """Return how many of ascending `rows` the first `most` parts from the start of the first one hold."""
        return int(np.searchsorted(self.first[rows + 1], self.first[rows[0]] + most, side="right"))

    def parts_of(self, rows: Ints, row_t: Floats) -> tuple[Ints, Floats, Ints]:
        """Return the parts of k rows, p ≥ k of them.

        Args:
            rows: Shape (k,), ascending.
            row_t: Shape (k + 1,): a coordinate along the rows, at their ends.

        Returns:
            The parts, shape (p,); the coordinate at their ends, shape (p + 1,); which of `rows` each belongs to, shape (p,).
        """
        count = self.first[rows + 1] - self.first[rows]
        if count.max() == 1:
            return self.first[rows], row_t, np.arange(len(rows))
        of, part = ranges(self.first[rows], count)
        last = np.cumsum(count) - 1
        way = np.cumsum(self.part_length[part])
        before = np.concatenate([[0.0], way[last[:-1]]])
        share = np.divide(
            way - before[of], (way[last] - before)[of], out=np.ones(len(of)), where=(count > 1)[of]
        )
        t = row_t[:-1][of] + share * np.diff(row_t)[of]
        t[last] = row_t[1:]
        return part, np.concatenate([row_t[:1], t]), of


def _pairs(parts: Toolpath, kind: Kind) -> Ints:
    """Return the rows of a kind that follow another of it."""
    return 1 + np.flatnonzero((parts.kind[1:] == kind) & (parts.kind[:-1] == kind))


def _alike(parts: Toolpath, length: Floats, two: Ints) -> Ints:
    """Return those of rows that are moved at the speed of the row before, under G64 within the same tolerance."""
    one = two - 1
    speed = [np.where(_inverse(parts, at), parts.feed[at] * length[at], parts.feed[at]) for at in (one, two)]
    tolerance = parts.tolerance[two]
    shorter = np.minimum(length[one], length[two])
    rounding = np.minimum(_OFF * tolerance, _SAME_WHERE_SHORT * shorter)
    same = np.abs(speed[1] - speed[0]) * shorter <= np.maximum(SAME * shorter, rounding) * speed[0]
    same &= (tolerance == parts.tolerance[one]) & (tolerance >= LEAST_TOLERANCE)
    same &= shorter > 0.0
    same &= parts.feed_mode[one] == parts.feed_mode[two]
    for at in (one, two):
        same &= parts.path_mode[at] == PathMode.CONTINUOUS
    return two[same]


def _straight_on(parts: Toolpath, steps: Floats, length: Floats) -> Bools:
    """Tell which rows are lines that go on in the direction and at the speed of the line before, shape (n,)."""
    out = np.zeros(len(parts), bool)
    ahead = np.einsum("ij,ij->i", steps[:-1], steps[1:]) > (1.0 - 0.5 * TURN**2) * length[:-1] * length[1:]
    two = _pairs(parts, Kind.LINE)
    two = _alike(parts, length, two[ahead[two - 1]])
    one = two - 1
    turn = steps[two] / length[two, None] - steps[one] / length[one, None]
    # A place within `_OFF` of a straight line is within twice `_OFF` of the line between two ends: `_straight` looks closer.
    away = norm(turn) * length[one] * length[two] / (length[one] + length[two])
    out[two[away <= 2.0 * _OFF * parts.tolerance[two]]] = True
    return out


def _inverse(parts: Toolpath, at: Ints) -> Bools:
    out: Bools = parts.feed_mode[at] == FeedMode.INVERSE_TIME
    return out


def _bounded(joined: Bools) -> Bools:
    """Return which rows to join with the row before so that stretches are bounded, shape (n,)."""
    index = np.arange(len(joined))
    begin = np.maximum.accumulate(np.where(joined, 0, index))
    out: Bools = joined & ((index - begin) % _MOST != 0)
    return out


def _straight(joined: Bools, places: Floats, parts: Toolpath) -> Bools:
    """Return which rows to join with the row before so that every stretch of lines is straight as a whole, shape (n,).

    Other stretches are cut where they turn most for their length: whether a line goes on must not depend on how short the parts
    are that meet there. Where no such turn stands out, a stretch is a curve, and its parts are rows.
    """
    out = joined.copy()
    while True:
        first = np.flatnonzero(~out)
        stop = np.append(first[1:], len(out))
        of = np.cumsum(~out) - 1
        inner = np.flatnonzero(out & (parts.kind == Kind.LINE))
        chord = (places[stop] - places[first])[of[inner]]
        way = places[inner] - places[first[of[inner]]]
        along = np.einsum("ij,ij->i", way, chord) / np.einsum("ij,ij->i", chord, chord)
        away = way - along[:, None] * chord
        far = np.einsum("ij,ij->i", away, away) > (_OFF * parts.tolerance[inner]) ** 2
        if not far.any():
            return out
        bent = np.zeros(len(first), bool)
        bent[of[inner[far]]] = True
        inner = inner[bent[of[inner]]]
        out[inner[_kinks(inner, of[inner], first, stop, places, parts.tolerance)]] = False


def _kinks(inner: Ints, of: Ints, first: Ints, stop: Ints, places: Floats, tolerance: Floats) -> Bools:
    """Tell where to cut stretches that are not straight, shape (k,): at the largest turns, or at all of them.

    Args:
        inner: Shape (k,): rows at whose starts they may be cut.
        of, first, stop: Shape (k,), which stretch each is in; shape (m,), where they begin and end.
        places: Shape (n + 1, axes): the ends of rows, mm.
        tolerance: Shape (n,), mm.
    """
    steps = places[inner] - places[inner - 1], places[inner + 1] - places[inner]
    ways = [step / norm(step)[:, None] for step in steps]
    reach = [norm(places[end] - places[inner]) for end in (first[of], stop[of])]
    angle = norm(ways[1] - ways[0])
    turn = angle * np.minimum(*reach)
    widest, most = np.zeros((2, len(first)))
    np.maximum.at(widest, of, angle)
    np.maximum.at(most, of, turn)
    slight = most[of] <= _OFF * tolerance[inner]
    out: Bools = (turn >= 0.5 * most[of]) | (slight & (angle > _NO_TURN * widest[of]))
    return out


def _round(joined: Bools, parts: Toolpath, starts: Floats) -> tuple[Bools, Circles]:
    """Return which rows to join so that every stretch of arcs is one arc as a whole, shape (n,), and these arcs."""
    first = np.flatnonzero(~joined)
    stop = np.append(first[1:], len(joined))
    chains = (stop - first > 1) & (parts.kind[first] == Kind.ARC)
    first, stop = first[chains], stop[chains]
    circles = Circles.of_parts(parts, starts, first, stop)
    good = circles.off <= OFF * parts.tolerance[first]
    if good.all():
        return joined, circles
    kept = joined.copy()
    kept[circles.parts[~good[circles.of]]] = False
    return kept, Circles.of_parts(parts, starts, first[good], stop[good])


def _joined(parts: Toolpath, length: Floats, first: Ints) -> Toolpath:
    """Return the toolpath of rows whose parts begin at `first`, each at the speed of the first."""
    begin, last = first[:-1], first[1:] - 1
    inverse = _inverse(parts, begin) & (last > begin)
    share = np.ones(len(begin))
    np.divide(length[begin], np.add.reduceat(length, begin), out=share, where=inverse)
    columns = parts.columns(begin) | {"end": parts.end[last], "feed": parts.feed[begin] * share}
    return replace(parts, **columns)


def _aligned(parts: Toolpath, length: Floats, first: Ints) -> Toolpath:
    """Return parts that begin at `first` in each row with all their ends on its straight line; of arcs too; at one speed.

    Joined parts may be passed exactly, and the least turn that rounding leaves would then be a corner.
    """
    count = np.diff(first)
    of = np.repeat(np.arange(len(count)), count)
    inner = np.flatnonzero(of[1:] == of[:-1])
    starts, of = parts.starts, of[inner]
    way = np.cumsum(length)
    before = way[first[:-1]] - length[first[:-1]]
    share = (way[inner] - before[of]) / (way[first[1:] - 1] - before)[of]
    end = parts.end.copy()
    begin = starts[first[:-1]][of]
    end[inner] = begin + share[:, None] * (parts.end[first[1:] - 1][of] - begin)
    same = ~_inverse(parts, inner + 1)
    feed = parts.feed.copy()
    feed[inner[same] + 1] = parts.feed[first[:-1]][of[same]]
    return replace(parts, end=end, feed=feed)
