"""The deviation of setpoints from the programmed rows, in both directions and in order: by the free space of both (Alt and Godau
(1995))."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import free_space as kernel
from cncgen.planner.tube.programmed import RowLines
from cncgen.planner.tube.window_problem import Solved

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Part of the tolerance that chords of the motion may leave it by where they are longer than those of setpoints, or two phases of
#: setpoints differ by; and how many phases are looked at, at most.
_CHORD, _PHASES = 0.004, 12
#: Factors on the tolerance that are tried if it is exceeded: doublings, and then bisections between the last two.
_DOUBLINGS, _HALVINGS = 6, 5
#: A line is done to its end, except for rounding.
_END = 1e-9


@dataclass(frozen=True, slots=True)
class Reached:
    """Places at which a motion may be: intervals on lines that follow one another, by their keys (`RowLines`).

    Attributes:
        line: Key of where the first line begins.
        low, high: Shape (k,): an interval each; none where low is above high.
    """

    line: float
    low: Floats
    high: Floats

    @classmethod
    def at(cls, path: RowLines, key: float) -> Reached:
        """Return one place."""
        on = int(np.clip(np.searchsorted(path.key, key, side="right") - 1, 0, len(path.tolerance) - 1))
        return cls(float(path.key[on]), np.array([key]), np.array([key]))


class _Walk(NamedTuple):
    """How a motion and the rows go along each other.

    Attributes:
        chords: How many of the motion's chords are done.
        whole: Whether all of both are.
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


def excess(path: RowLines, entry: Reached, motion: Solved, period_s: float, passed: float) -> Floats:
    """Return by how much setpoints of a motion, whatever their phase, are over the tolerance before each node, shape (k,), mm.

    −∞ where they are not, or by no more than a part of it that may be passed. Where they go along the rows in order only with more
    than twice the tolerance, it may be less than that. Where every place is near enough, but not in order, it is what more of it would do.

    Args:
        path: The rows from where the motion begins to where it ends.
        entry: Where on them it begins.
        motion: Over all axes.
        period_s: Time between setpoints.
        passed: Part of the tolerance by which they may be over it.
    """
    end = np.cumsum(motion.step)
    over = np.full(len(end), -np.inf)
    allowed = (1.0 + passed) * path.tolerance
    beside = np.maximum(np.append(path.tolerance, 0.0), np.insert(path.tolerance, 0, 0.0))
    for t in _phases(motion, end, period_s, float(path.tolerance.min())):
        points = _at(motion, end, t)
        first = _walk(path, points, allowed, entry)
        if first.whole:
            continue
        node = np.minimum(np.searchsorted(end, t), len(end) - 1)
        found, factor = first, 1.0
        for _ in range(_DOUBLINGS):
            factor *= 2.0
            found = _walk(path, points, factor * allowed, entry)
            if found.whole:
                break
        np.maximum.at(over, node[1:], (found.out - path.tolerance[found.line])[1:])
        seen = np.flatnonzero(np.isfinite(found.back))
        chord = found.at[seen]
        way = points[chord + 1] - points[chord]
        part = ((path.points[seen] - points[chord]) * way).sum(axis=1) / np.maximum(
            (way**2).sum(axis=1), 1e-300
        )
        when = t[chord] + np.clip(part, 0.0, 1.0) * (t[chord + 1] - t[chord])
        np.maximum.at(
            over, np.minimum(np.searchsorted(end, when), len(end) - 1), found.back[seen] - beside[seen]
        )
        if not (over > passed * path.tolerance.max()).any():
            less = 0.5 * factor
            for _ in range(_HALVINGS):
                half = 0.5 * (less + factor)
                less, factor = (
                    (less, half) if _walk(path, points, half * allowed, entry).whole else (half, factor)
                )
            stuck = node[min(first.chords + 1, len(node) - 1)]
            over[stuck] = (factor * (1.0 + passed) - 1.0) * path.tolerance.max()
    return over


def reached(
    path: RowLines, entry: Reached, motion: Solved, period_s: float, passed: float, count: int
) -> Reached:
    """Return where a motion may be at its node `count`, by setpoints of one phase; the arguments are those of `excess`."""
    end = np.cumsum(motion.step)
    t = next(_phases(motion, end, period_s, float(path.tolerance.min())))
    t = np.append(t[t < end[count - 1]], end[count - 1])
    first, low, high = _walk(
        path, _at(motion, end, t), (1.0 + passed) * path.tolerance, entry
    ).space.reached()
    begin, width = path.key[first : first + len(low)], np.diff(path.key[first : first + len(low) + 1])
    return Reached(float(begin[0]), begin + low * width, begin + high * width)


def _phases(motion: Solved, end: Floats, period_s: float, tolerance: float) -> Iterator[Floats]:
    """Yield times of setpoints of a motion, of one phase after the other, its ends among them; further apart where chords show less."""
    bend = np.sqrt((motion.acceleration**2).sum(axis=1))
    with np.errstate(divide="ignore"):
        fine = np.sqrt(8.0 * _CHORD * tolerance / np.maximum(bend[1:], bend[:-1]))
    count = np.concatenate(
        [[0.0], np.cumsum(motion.step / np.maximum(np.minimum(fine, motion.step), period_s))]
    )
    number = int(np.clip(np.ceil(period_s / fine.min()), 1, _PHASES))
    clock = np.concatenate([[0.0], end])
    for phase in range(number):
        inner = np.arange(phase / number, count[-1])
        yield np.concatenate([[0.0], np.interp(inner[inner > 0.0], count, clock), end[-1:]])


def _walk(path: RowLines, points: Floats, allowed: Floats, entry: Reached) -> _Walk:
    """Go along points and rows with what each line allows, mm."""
    lines, count = len(allowed), len(points)
    back, at, during = np.full(lines + 1, np.inf), np.zeros(lines + 1, np.int64), np.full((lines + 1, 2), -1)
    out, line = np.zeros(count), np.zeros(count, np.int64)
    space = kernel.FreeSpace(path.points, allowed, True, back, at, during, np.empty((4, lines)))
    first = int(np.searchsorted(path.key, entry.line))
    own = slice(first, min(first + len(entry.low), lines))
    begin, width = path.key[own], np.diff(path.key)[own]
    # A line without length is begun and ended at once.
    size = np.where(width > 0.0, width, 1.0)
    low, high = ((each[: len(begin)] - begin) / size for each in (entry.low, entry.high))
    space.enter(first, low.tolist(), np.minimum(high, 1.0).tolist())
    done, why = space.run(points, 0, count - 1, 1.0, count, 0, out, line)
    first, low, high = space.reached()
    whole = why == kernel.DONE and first + len(low) == lines and high[-1] >= 1.0 - _END
    return _Walk(done, whole, out, line, back, at, space)


def _at(motion: Solved, end: Floats, t: Floats) -> Floats:
    """Return positions at times, shape (k, n), of intervals that end at `end`."""
    k = np.minimum(np.searchsorted(end, t), len(end) - 1)
    h = (t - end[k] + motion.step[k])[:, None]
    parts = (motion.position, motion.velocity, motion.acceleration / 2.0, motion.jerk / 6.0)
    x, v, a, j = (each[k] for each in parts)
    out: Floats = x + h * (v + h * (a + h * j))
    return out
