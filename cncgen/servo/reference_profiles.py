"""Positions over time in pieces that are sums of powers and exponentials, and the three profiles of Chen and Hsu.

Source: S.-L. Chen and H.-S. Hsu, eqs 1 to 3: 10 mm in 1 s at up to 15 mm/s with 1/3 s of acceleration. The paper rounds the
constants of its pieces (0.07 for 5/72, 3.75 where the exponential gives 3.84 …); docs/modified-reference.md says which
reading of them gives its tables.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ProfilePiece:
    """x(t) = Σ powers[k] τᵏ + Σ c e^(λτ) with τ = t − start.

    Attributes:
        start, end: s.
        powers: Coefficients, lowest power first.
        exponentials: Pairs (c, λ).
    """

    start: float
    end: float
    powers: tuple[float, ...]
    exponentials: tuple[tuple[float, float], ...] = ()

    def derivative(self) -> ProfilePiece:
        """Return the piece of ẋ."""
        powers = tuple(k * c for k, c in enumerate(self.powers))[1:] or (0.0,)
        return ProfilePiece(
            self.start, self.end, powers, tuple((c * rate, rate) for c, rate in self.exponentials)
        )

    def value(self, t: Floats) -> Floats:
        """Return x at times, shape (n,)."""
        tau = np.asarray(t, float) - self.start
        total: Floats = np.asarray(np.polyval(self.powers[::-1], tau), np.float64)
        for c, rate in self.exponentials:
            total = total + c * np.exp(rate * tau)
        return total


@dataclass(frozen=True, slots=True)
class ReferenceProfile:
    """Pieces one after another; 0 before them, and standing at `final` after them."""

    pieces: tuple[ProfilePiece, ...]
    final: float

    def value(self, t: Floats) -> Floats:
        """Return x at times, shape (n,); at a joint the earlier piece counts, as the papers' (a < t ≤ b)."""
        t = np.asarray(t, float)
        result = np.where(t > self.pieces[0].start, self.final, 0.0)
        for piece in self.pieces:
            inside = (t > piece.start) & (t <= piece.end)
            result[inside] = piece.value(t[inside])
        return result


def combined(piece: ProfilePiece, weights: Sequence[float]) -> ProfilePiece:
    """Return weights[0] x + weights[1] ẋ + weights[2] ẍ … of a piece."""
    powers = np.zeros(len(piece.powers))
    exponentials: dict[float, float] = {}
    part = piece
    for weight in weights:
        powers[: len(part.powers)] += weight * np.array(part.powers)
        for c, rate in part.exponentials:
            exponentials[rate] = exponentials.get(rate, 0.0) + weight * c
        part = part.derivative()
    pairs = tuple((c, rate) for rate, c in exponentials.items())
    return ProfilePiece(piece.start, piece.end, tuple(powers), pairs)


def linear() -> ReferenceProfile:
    """Return eq. 2: acceleration of ±45 mm/s²."""
    third = 1.0 / 3.0
    return ReferenceProfile(
        (
            ProfilePiece(0.0, third, (0.0, 0.0, 22.5)),
            ProfilePiece(third, 2 * third, (2.5, 15.0)),
            ProfilePiece(2 * third, 1.0, (7.5, 15.0, -22.5)),
        ),
        10.0,
    )


#: Constants of eq. 1 as printed, and as continuity asks for them.
BELL_PRINTED = (0.0, 0.07, 1.32, 2.5, 7.5, 8.68, 9.93)
BELL_EXACT = (0.0, 5 / 72, 95 / 72, 2.5, 7.5, 625 / 72, 715 / 72)


def bell(constants: Sequence[float] = BELL_PRINTED) -> ReferenceProfile:
    """Return eq. 1: jerk of ±720 mm/s³, acceleration up to 60 mm/s²; see `BELL_PRINTED` and `BELL_EXACT`."""
    shapes = ((0, 0, 120), (2.5, 30), (12.5, 30, -120), (15,), (15, 0, -120), (12.5, -30), (2.5, -30, 120))
    ends = (0, 1 / 12, 1 / 4, 1 / 3, 2 / 3, 3 / 4, 11 / 12, 1)
    pieces = [
        ProfilePiece(ends[i], ends[i + 1], (constant, *map(float, shape)))
        for i, (shape, constant) in enumerate(zip(shapes, constants, strict=True))
    ]
    return ReferenceProfile(tuple(pieces), 10.0)


def exponential(normalised: bool = True) -> ReferenceProfile:
    """Return eq. 3 with exponentials of 12/s.

    As printed it jumps by 23 µm and ends at 0.27 mm/s. Normalised by K = 1/(1 − e⁻⁴) the speed is continuous and
    ends at 0, with the constants 3.84 and 8.84 between the pieces: the reading that gives the paper's tables.
    """
    third = 1.0 / 3.0
    if not normalised:
        return ReferenceProfile(
            (
                ProfilePiece(0.0, third, (-1.25, 15.0), ((1.25, -12.0),)),
                ProfilePiece(third, 2 * third, (3.75, 15.0)),
                ProfilePiece(2 * third, 1.0, (10.0,), ((-1.25, -12.0),)),
            ),
            10.0,
        )
    k = 1.0 / (1.0 - math.exp(-4.0))
    return ReferenceProfile(
        (
            ProfilePiece(0.0, third, (-1.25 * k, 15.0 * k), ((1.25 * k, -12.0),)),
            ProfilePiece(third, 2 * third, (3.84, 15.0)),
            ProfilePiece(
                2 * third, 1.0, (8.84 + 1.25 * k, -15.0 * math.exp(-4.0) * k), ((-1.25 * k, -12.0),)
            ),
        ),
        10.0,
    )
