"""The change of a command that takes most of a known error away, within the limits of an axis.

A linear loop G answers a change c of its command by G c. Norm-optimal learning chooses the change that minimises

    |e − G c|² + ε|c|²   with   |D(u + c)| ≤ V T, |D²(u + c)| ≤ A T², |D³(u + c)| ≤ J T³

for a command u with the error e; D is the difference over a period T (N. Amann, D. H. Owens and E. Rogers, IEE Proc. Control
Theory and Applications 143 (1996) 217). Without limits the answer is a filter that looks both ways,
c = G* e/(|G|² + ε): the stable inverse of S. Devasia, D. Chen and B. Paden, IEEE TAC 41 (1996) 930, with pre-actuation
where G has a dead time or zeros outside the unit circle. ε makes it a learning filter: where |G|² is below ε little is learnt.

With limits the problem is convex. The alternating direction method of multipliers splits it (S. Boyd, N. Parikh, E. Chu,
B. Peleato and J. Eckstein, Foundations and Trends in Machine Learning 3 (2011) 1, sections 3.1.1 and 3.4.3)
into a step that is diagonal in the frequencies and a clipping of the differences. The motion begins and ends at rest.
The frequencies are those of a stretch of time that is longer than the motion by what G and its inverse remember.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
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
#: Weights of velocity, acceleration and jerk (mm² for a whole limit), and relaxation. With these both motions that the limits
#: hardly touch and motions that they bind everywhere come near their end within some hundred rounds.
WEIGHTS = (1e-3, 1e-1, 1e-2)
RELAXATION = 1.7
#: Share of acceleration and jerk that the splitting is given, since it comes to its end from outside the limits. (The
#: velocity is given whole: a motion may go at its limit for long.)
GIVEN = (1.0, 0.999, 0.999)


@dataclass(slots=True)
class LimitedUpdate:
    """The changes of one axis's command; the splitting goes on where the change before ended.

    Attributes:
        response: G at the frequencies of `numpy.fft.rfft` over `length` periods.
        length: Of the stretch of time, periods.
        period_s: s.
        axis: Its limits; None: there are none.
        regularisation: ε.
        enough: Rounds after which a change within the limits is taken, though it still moves.
        excess: Of the last change: the largest difference over its limit, less 1.
    """

    response: Complexes
    length: int
    period_s: float
    axis: Axis | None
    regularisation: float = REGULARISATION
    enough: int = ROUNDS
    excess: float = 0.0
    _multipliers: list[Floats] = field(default_factory=list)

    def change(self, command: Floats, error: Floats, rounds: int = ROUNDS) -> Floats:
        """Return c, shape (n,).

        Args:
            command: u, shape (n,), at rest before and after.
            error: e, shape (n,).
            rounds: Of the splitting, at most.
        """
        learnt = np.conj(self.response) * np.fft.rfft(error, self.length)
        curvature = np.abs(self.response) ** 2 + self.regularisation
        if self.axis is None:
            return self._in_time(learnt / curvature)[: len(command)]
        return self._split(learnt, curvature, _limits(self.axis), command, rounds)[: len(command)]

    def _in_time(self, spectrum: Complexes) -> Floats:
        return np.asarray(np.fft.irfft(spectrum, self.length), np.float64)

    def _split(
        self, learnt: Complexes, curvature: Floats, limits: Floats, command: Floats, rounds: int
    ) -> Floats:
        """Return c by alternating directions; v are the differences over their limits, z the clipped ones."""
        once = 1.0 - np.exp(-2j * np.pi * np.fft.rfftfreq(self.length))
        scales = [self.period_s**k * limit for k, limit in enumerate(limits, start=1)]
        operators = [once**k / scale for k, scale in enumerate(scales, start=1)]
        given = [self._steps(command, k) / scale for k, scale in enumerate(scales, start=1)]
        weighed = curvature + sum(w * np.abs(d) ** 2 for w, d in zip(WEIGHTS, operators, strict=True))
        z = [np.clip(step, -1.0, 1.0) for step in given]
        multipliers = self._multipliers or [np.zeros(self.length) for _ in given]
        last = learnt / curvature
        v = [self._in_time(d * last) + step for d, step in zip(operators, given, strict=True)]
        self.excess = _excess(v)
        if self.excess <= 0.0:
            return self._in_time(last)
        for k in range(1, rounds + 1):
            spectrum = learnt.copy()
            for w, d, within, m, step in zip(WEIGHTS, operators, z, multipliers, given, strict=True):
                spectrum += w * np.conj(d) * np.fft.rfft(within - m - step)
            spectrum /= weighed
            v = [self._in_time(d * spectrum) + step for d, step in zip(operators, given, strict=True)]
            for i, reached in enumerate(v):
                relaxed = RELAXATION * reached + (1.0 - RELAXATION) * z[i] + multipliers[i]
                z[i] = np.clip(relaxed, -1.0, 1.0)
                multipliers[i] = relaxed - z[i]
            self.excess = _excess(v)
            moved = np.linalg.norm(spectrum - last)
            last = spectrum
            stands = k >= self.enough or moved <= STANDS * np.linalg.norm(spectrum)
            if stands and self.excess <= EXCESS:
                break
        self._multipliers = multipliers
        return self._in_time(last)

    def _steps(self, command: Floats, order: int) -> Floats:
        """Return the differences of a command that stands before and after, shape (length,)."""
        whole = np.concatenate([np.repeat(command[:1], order), command, np.repeat(command[-1:], order)])
        steps = np.zeros(self.length)
        found = np.diff(whole, order)
        steps[: len(found)] = found
        return steps


def _excess(differences: list[Floats]) -> float:
    """Return how far differences over what the splitting is given are over the limits."""
    return max(share * float(np.abs(v).max()) for share, v in zip(GIVEN, differences, strict=True)) - 1.0


def _limits(axis: Axis) -> Floats:
    """Return what the splitting is given of the limits of velocity, acceleration and jerk."""
    return np.array(GIVEN) * (axis.max_velocity, axis.max_acceleration, axis.max_jerk)
