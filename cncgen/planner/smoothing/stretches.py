"""Straight stretches: consecutive lines that go straight on count as one, so that cutting a line changes nothing.

How long a row is tells smoothing what is a corner by itself and what a facet (docs/smoothing.md): it must be the length of
the straight line, not that of the parts in which it is written.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.path import STANDSTILL
from cncgen.planner.smoothing.runs import LEAST_TOLERANCE, axis_scale
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath
from cncgen.toolpath.slicing import between

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Part of the tolerance by which ends of parts may be off the straight line: room for coordinates rounded in their last
#: places, and a thousandth of what arcs are compared by.
_OFF = 1e-6
#: Turn from which parts are no straight line, however short they are.
_TURN = 1e-3
#: Part of the speed by which that of parts may differ: speeds of G93 come from lengths, with their rounding.
_SAME = 1e-9
#: Parts of a row at most: what has been read of a stretch waits for its end.
_MOST = 512


@dataclass(frozen=True, slots=True)
class Stretches:
    """A toolpath in which lines that go straight on are one row: m of them, of n ≥ m parts.

    Attributes:
        rows: Each with the line of its first part.
        parts: As they are programmed, but for the digits by which their ends are off the straight line.
        first: Shape (m + 1,): where the parts of each row begin, and n.
        part_length: Shape (n,), mm: how long parts that are lines are, over all axes.
    """

    rows: Toolpath
    parts: Toolpath
    first: Ints
    part_length: Floats

    @classmethod
    def of(cls, parts: Toolpath) -> Stretches:
        """Join the lines of a toolpath under G64 that go straight on at the same speed."""
        places = np.concatenate([parts.start[None], parts.end])
        places *= axis_scale(parts.axes)
        steps = np.diff(places, axis=0)
        length = np.sqrt(np.einsum("ij,ij->i", steps, steps))
        joined = _goes_on(parts, steps, length)
        if not joined.any():
            return cls(parts, parts, np.arange(len(parts) + 1), length)
        joined = _straight(joined, places, parts.tolerance)
        first = np.append(np.flatnonzero(~joined), len(parts))
        return cls(_joined(parts, length, first), _aligned(parts, length, first), first, length)

    def but_last(self) -> Stretches:
        """Return these without the last row."""
        first = self.first[:-1]
        stop = int(first[-1])
        rows = parts = between(self.parts, 0, stop)
        if len(first) < len(parts) + 1:
            rows = between(self.rows, 0, len(first) - 1)
        return Stretches(rows, parts, first, self.part_length[:stop])

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
        of = np.repeat(np.arange(len(rows)), count)
        last = np.cumsum(count) - 1
        part = np.arange(len(of)) + (self.first[rows + 1] - 1 - last)[of]
        way = np.cumsum(self.part_length[part])
        before = np.concatenate([[0.0], way[last[:-1]]])
        share = np.divide(
            way - before[of], (way[last] - before)[of], out=np.ones(len(of)), where=(count > 1)[of]
        )
        t = row_t[:-1][of] + share * np.diff(row_t)[of]
        t[last] = row_t[1:]
        return part, np.concatenate([row_t[:1], t]), of


def _goes_on(parts: Toolpath, steps: Floats, length: Floats) -> Bools:
    """Tell which rows are lines that go on in the direction and at the speed of the line before, shape (n,)."""
    out = np.zeros(len(parts), bool)
    alike = np.einsum("ij,ij->i", steps[:-1], steps[1:]) > (1.0 - 0.5 * _TURN**2) * length[:-1] * length[1:]
    two = 1 + np.flatnonzero(alike & (parts.kind[1:] == Kind.LINE) & (parts.kind[:-1] == Kind.LINE))
    one = two - 1
    speed = [np.where(_inverse(parts, at), parts.feed[at] * length[at], parts.feed[at]) for at in (one, two)]
    tolerance, shorter = parts.tolerance[two], np.minimum(length[one], length[two])
    same = np.abs(speed[1] - speed[0]) <= _SAME * speed[0]
    same &= (tolerance == parts.tolerance[one]) & (tolerance >= LEAST_TOLERANCE) & (shorter > STANDSTILL)
    same &= (parts.feed_mode[one] == parts.feed_mode[two]) & (parts.feed_mode[two] != FeedMode.RAPID)
    for at in (one, two):
        same &= parts.path_mode[at] == PathMode.CONTINUOUS
    one, two, tolerance, shorter = one[same], two[same], tolerance[same], shorter[same]
    turn = steps[two] / length[two, None] - steps[one] / length[one, None]
    out[two[np.linalg.norm(turn, axis=1) * shorter <= _OFF * tolerance]] = True
    return out


def _inverse(parts: Toolpath, at: Ints) -> Bools:
    out: Bools = parts.feed_mode[at] == FeedMode.INVERSE_TIME
    return out


def _straight(joined: Bools, places: Floats, tolerance: Floats) -> Bools:
    """Return which rows to join with the row before so that every stretch is straight as a whole, and bounded, shape (n,)."""
    index = np.arange(len(joined))
    begin = np.maximum.accumulate(np.where(joined, 0, index))
    out = joined & ((index - begin) % _MOST != 0)
    first = np.flatnonzero(~out)
    stop = np.append(first[1:], len(out))
    of = np.cumsum(~out) - 1
    inner = np.flatnonzero(out)
    chord = (places[stop] - places[first])[of[inner]]
    way = places[inner] - places[first[of[inner]]]
    along = np.einsum("ij,ij->i", way, chord) / np.einsum("ij,ij->i", chord, chord)
    away = way - along[:, None] * chord
    bent = np.einsum("ij,ij->i", away, away) > (_OFF * tolerance[inner]) ** 2
    curves = np.zeros(len(first), bool)
    curves[of[inner[bent]]] = True
    kept: Bools = out & ~curves[of]
    return kept


def _joined(parts: Toolpath, length: Floats, first: Ints) -> Toolpath:
    """Return the toolpath of rows whose parts begin at `first`."""
    begin, last = first[:-1], first[1:] - 1
    inverse = _inverse(parts, begin) & (last > begin)
    share = np.ones(len(begin))
    np.divide(length[begin], np.add.reduceat(length, begin), out=share, where=inverse)
    columns = ("kind", "feed_mode", "path_mode", "tolerance", "curve", "line", "source")
    picked = {name: getattr(parts, name)[begin] for name in columns}
    return replace(parts, end=parts.end[last], feed=parts.feed[begin] * share, **picked)


def _aligned(parts: Toolpath, length: Floats, first: Ints) -> Toolpath:
    """Return parts that begin at `first` in each row with all their ends on its straight line.

    What is joined may pass exactly, and the least turn that is left of rounding would be a corner there.
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
    return replace(parts, end=end)
