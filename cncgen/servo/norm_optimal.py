"""The change of a command that removes most of a known error, within the limits of an axis.

A linear loop G answers a change c of its command by G c. Norm-optimal learning chooses the change that minimises

    |e − G c|² + ε|c|²   with   |D(u + c)| ≤ V T, |D²(u + c)| ≤ A T², |D³(u + c)| ≤ J T³, |f + F c| ≤ B

for a command u with the error e and the drive input f, whose bound is B; D is the difference over a period T, and F answers a
change of the command with one of the drive input (N. Amann, D. H. Owens and E. Rogers, IEE Proc. Control Theory and
Applications 143 (1996) 217). Without limits the solution is a non-causal filter,
c = G* e/(|G|² + ε): the stable inverse of S. Devasia, D. Chen and B. Paden, IEEE TAC 41 (1996) 930, with pre-actuation
where G has a dead time or zeros outside the unit circle. ε makes it a learning filter: where |G|² is below ε little is learnt.

With limits the problem is convex. The alternating direction method of multipliers splits it (S. Boyd, N. Parikh, E. Chu,
B. Peleato and J. Eckstein, Foundations and Trends in Machine Learning 3 (2011) 1, sections 3.1.1 and 3.4.3)
into a step that is diagonal in the frequencies and a clipping of the differences. The motion begins and ends at rest.
The frequencies are those of a stretch of time that is longer than the motion by the memory of G and its inverse.

Far from an error its change dies away, as the inverse's impulse response does. So a long motion is cut into windows with
overlaps in which it has died away, and their changes are faded into each other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from cncgen.machine.record import Axis

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

#: ε, for a loop whose gain at rest is 1.
REGULARISATION = 1e-5
#: Most rounds of the splitting; it ends before where no limit is exceeded by more than this share of it, and the change
#: moves by less than this share of itself in a round.
ROUNDS = 300
EXCESS = 5e-4
STANDS = 1e-5
#: Weights of velocity, acceleration, jerk and drive input (mm² for a whole limit), and relaxation. With these both motions that
#: the limits hardly touch and motions that they bind everywhere come near their end within some hundred rounds. They are for
#: errors up to `LARGE` (mm); beyond it they grow as the error's square does, which they stand beside in the minimum.
WEIGHTS = (1e-3, 1e-1, 1e-2, 1e-2)
LARGE = 1.0
RELAXATION = 1.7
#: Share of each limit that the splitting is given, since it comes to its end from outside the limits. (The velocity is
#: given whole: a motion may go at its limit for long. Of the drive input friction takes a little more or less in each pass.)
GIVEN = (1.0, 0.999, 0.999, 0.99)
#: Rows of a window between its seams, at least: transforms of so many stay in a processor's cache.
CORE = 1 << 13


@dataclass(slots=True)
class LimitedUpdate:
    """The changes of one axis's command; the splitting goes on where the change before ended.

    Attributes:
        response: G at the frequencies of `numpy.fft.rfft` over `length` periods.
        length: Of the stretch of time, periods.
        period_s: s.
        axis: Its limits; None without limits.
        regularisation: ε.
        enough: Rounds after which a change within the limits is taken, though it still moves.
        drive: F over the bound B of the drive, as `response`; None: it has none.
        excess: Of the last change: the largest difference (or drive input) over its limit, less 1.
        work: Periods times rounds so far.
    """

    response: Complexes
    length: int
    period_s: float
    axis: Axis | None
    regularisation: float = REGULARISATION
    enough: int = ROUNDS
    drive: Complexes | None = None
    excess: float = 0.0
    work: float = 0.0
    _multipliers: list[Floats] = field(default_factory=list)
    _scale: float = 0.0

    def change(
        self,
        command: Floats,
        error: Floats,
        rounds: int = ROUNDS,
        force: Floats | None = None,
        rows: slice = slice(None),
    ) -> Floats:
        """Return c, shape (n,), or the part of it in a window.

        Args:
            command: u, shape (n,), at rest before and after.
            error: e, shape (n,).
            rounds: Of the splitting, at most.
            force: f over the bound of the drive, shape (n,), where it has one.
            rows: The window; outside it the error is 0.
        """
        window = range(*rows.indices(len(command)))
        learnt = np.conj(self.response) * np.fft.rfft(error[rows], self.length)
        curvature = np.abs(self.response) ** 2 + self.regularisation
        self._scale = self._scale or max(1.0, (float(np.abs(error).max()) / LARGE) ** 2)
        limits = list(self._limits(command, force, window))
        if not limits:
            return self._in_time(learnt / curvature)[: len(window)]
        return self._split(learnt, curvature, limits, rounds)[: len(window)]

    def _limits(self, command: Floats, force: Floats | None, window: range) -> Iterator[_Limit]:
        """Yield what is limited, over what the splitting is given of it."""
        if self.axis is not None:
            once = 1.0 - np.exp(-2j * np.pi * np.fft.rfftfreq(self.length))
            bounds = (self.axis.max_velocity, self.axis.max_acceleration, self.axis.max_jerk)
            for k, bound in enumerate(bounds, start=1):
                scale = GIVEN[k - 1] * bound * self.period_s**k
                weight = self._scale * WEIGHTS[k - 1]
                yield _Limit(once**k / scale, self._steps(command, k, window) / scale, weight, GIVEN[k - 1])
        if self.drive is not None and force is not None:
            taken = np.zeros(self.length)
            taken[: len(window)] = force[window.start : window.stop]
            yield _Limit(self.drive / GIVEN[3], taken / GIVEN[3], self._scale * WEIGHTS[3], GIVEN[3])

    def _in_time(self, spectrum: Complexes) -> Floats:
        return np.asarray(np.fft.irfft(spectrum, self.length), np.float64)

    def _split(self, learnt: Complexes, curvature: Floats, limits: Sequence[_Limit], rounds: int) -> Floats:
        """Return c by alternating directions; v is what is limited, z the same clipped."""
        weighed = curvature + sum(one.weight * np.abs(one.operator) ** 2 for one in limits)
        z = [np.clip(one.taken, -1.0, 1.0) for one in limits]
        multipliers = self._multipliers or [np.zeros(self.length) for _ in limits]
        last = learnt / curvature
        v = [self._in_time(one.operator * last) + one.taken for one in limits]
        self.excess = _excess(limits, v)
        if self.excess <= 0.0:
            return self._in_time(last)
        aims = [1.0] * len(limits)
        for k in range(1, rounds + 1):
            spectrum = learnt.copy()
            for one, within, m in zip(limits, z, multipliers, strict=True):
                spectrum += one.weight * np.conj(one.operator) * np.fft.rfft(within - m - one.taken)
            spectrum /= weighed
            v = [self._in_time(one.operator * spectrum) + one.taken for one in limits]
            for i, reached in enumerate(v):
                relaxed = RELAXATION * reached + (1.0 - RELAXATION) * z[i] + multipliers[i]
                z[i] = np.clip(relaxed, -aims[i], aims[i])
                multipliers[i] = relaxed - z[i]
            self.excess = _excess(limits, v)
            moved = np.linalg.norm(spectrum - last)
            last = spectrum
            stands = k >= self.enough or moved <= STANDS * np.linalg.norm(spectrum)
            if stands and self.excess <= EXCESS:
                break
            if k % ROUNDS == 0:
                aims = [
                    aim / (1.0 + max(_excess([one], [w]), 0.0))
                    for aim, one, w in zip(aims, limits, v, strict=True)
                ]
        self.work += float(k) * self.length
        self._multipliers = multipliers
        return self._in_time(last)

    def _steps(self, command: Floats, order: int, window: range) -> Floats:
        """Return the differences within a window of a command that stands before and after, shape (length,)."""
        begin, end = window.start - order, window.stop
        before = np.repeat(command[:1], max(-begin, 0))
        after = np.repeat(command[-1:], order if end == len(command) else 0)
        found = np.diff(np.concatenate([before, command[max(begin, 0) : end], after]), order)
        steps = np.zeros(self.length)
        steps[: len(found)] = found
        return steps


@dataclass(slots=True)
class WindowedUpdate:
    """The changes of one axis's command, window by window.

    Attributes:
        windows: Of the motion.
        updates: One each, as `LimitedUpdate`.
        excess: Of the last change: how far the command exceeds a limit with it, as a share of it.
    """

    windows: Windows
    updates: list[LimitedUpdate]
    excess: float = 0.0

    @property
    def work(self) -> float:
        """Return periods times rounds so far."""
        return sum(update.work for update in self.updates)

    def change(
        self, command: Floats, error: Floats, rounds: int = ROUNDS, force: Floats | None = None
    ) -> Floats:
        """Return c, shape (n,); arguments are those of `LimitedUpdate.change`."""
        result = np.zeros(len(command))
        for k, update in enumerate(self.updates):
            rows, heard, counts = self.windows.part(k)
            weighed = np.zeros(len(command))
            weighed[rows] = error[rows] * heard
            result[rows] += counts * update.change(command, weighed, rounds, force, rows)
        self.excess = max(update.excess for update in self.updates)
        axis = self.updates[0].axis
        if len(self.updates) > 1 and axis is not None:
            sizes = limit_shares(command + result, axis, self.updates[0].period_s)
            self.excess = max(self.excess, float(sizes.max()) - 1.0)
        return result


@dataclass(frozen=True, slots=True)
class Windows:
    """How a motion is cut into windows.

    Attributes:
        seams: Rows where windows meet, with the first and the last of the motion: 0, …, n.
        overlap: By how many rows a window reaches over its seams.
    """

    seams: tuple[int, ...]
    overlap: int

    @property
    def rows(self) -> int:
        """Return the rows of the longest window, its overlaps included."""
        return max(b - a for a, b in pairwise(self.seams)) + (2 * self.overlap if len(self.seams) > 2 else 0)

    def part(self, k: int) -> tuple[slice, Floats, Floats]:
        """Return the rows of a window, and the weights, shape (rows,), of errors in it and of its changes.

        Errors fade out over the outer half of the overlap; changes fade into those of the next window over its inner half.
        """
        (a, b), n, over = self.seams[k : k + 2], self.seams[-1], self.overlap
        rows = np.arange(max(a - over, 0), min(b + over, n))
        heard, counts = np.ones(len(rows)), np.ones(len(rows))
        for inside, seam in ((1.0, a), (-1.0, b)):
            if 0 < seam < n:
                away = inside * (rows - seam)
                heard *= smooth_rise((away + over) / (over // 2))
                counts *= smooth_rise(away / (over // 2) + 0.5)
        return slice(int(rows[0]), int(rows[-1]) + 1), heard, counts


def cut(busy: Floats, overlap: int) -> Windows:
    """Return windows of a motion, whose seams lie where least of the limits is taken.

    Args:
        busy: Shape (n,): the share of the limits that each row takes.
        overlap: Rows after which a change has died away.
    """
    n, core = len(busy), max(CORE, 4 * overlap)
    count = max(round(n / core), 1)
    seams = [0]
    for k in range(1, count):
        near = np.arange(k * n // count - core // 4, k * n // count + core // 4)
        faded = sliding_window_view(
            busy[near[0] - overlap // 4 : near[-1] + overlap // 4 + 1], 2 * (overlap // 4) + 1
        )
        seams.append(int(near[faded.max(axis=1).argmin()]))
    return Windows((*seams, n), overlap)


def limit_shares(command: Floats, axis: Axis, period_s: float) -> Floats:
    """Return the largest share of a limit of velocity, acceleration or jerk that each row of a command takes, shape (n + 3,)."""
    whole = np.concatenate([np.repeat(command[:1], 3), command, np.repeat(command[-1:], 3)])
    bounds = (axis.max_velocity, axis.max_acceleration, axis.max_jerk)
    shares = [np.abs(np.diff(whole, k)) / (bound * period_s**k) for k, bound in enumerate(bounds, start=1)]
    return np.asarray(np.max([share[: len(command) + 3] for share in shares], axis=0))


def smooth_rise(share: Floats) -> Floats:
    """Return a rise from 0 to 1 over shares 0 to 1 that begins and ends with no velocity, acceleration or jerk."""
    share = np.clip(share, 0.0, 1.0)
    return share**4 * (35.0 - share * (84.0 - share * (70.0 - share * 20.0)))


def rise_time(distance: float, axis: Axis) -> float:
    """Return the least time, s, in which `smooth_rise` over a distance, mm or rad, keeps an axis's limits.

    Its largest derivatives are 35/16, 84√5/25 and 52.5.
    """
    return max(
        35.0 / 16.0 * distance / axis.max_velocity,
        math.sqrt(84.0 * math.sqrt(5.0) / 25.0 * distance / axis.max_acceleration),
        math.cbrt(52.5 * distance / axis.max_jerk),
    )


@dataclass(frozen=True, slots=True)
class _Limit:
    """Something linear in a change whose size is limited, over what the splitting is given of its limit.

    Attributes:
        operator: From the change, at the frequencies.
        taken: The share of the limit that the command takes without the change, shape (length,).
        weight: In the splitting.
        given: Share of the limit.
    """

    operator: Complexes
    taken: Floats
    weight: float
    given: float


def _excess(limits: Sequence[_Limit], reached: Sequence[Floats]) -> float:
    """Return the excess over the limit."""
    return max(one.given * float(np.abs(v).max()) for one, v in zip(limits, reached, strict=True)) - 1.0
