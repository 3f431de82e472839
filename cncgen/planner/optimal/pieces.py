"""A solution as pieces in time: on a spline interval s''' = c s', where it leaves or enters rest constant jerk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.optimal.track import ENTER, LEAVE, SPLINE

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Pieces:
    """Duration, and v, a, j, c at the start, of one piece an interval; each of shape (n,)."""

    duration: Floats
    v: Floats
    a: Floats
    j: Floats
    c: Floats


def pieces_of(h: Floats, kind: NDArray[np.int8], q: Floats) -> Pieces:
    """Turn ordinates of q = v² into pieces.

    On a spline interval with ordinates b0, b1, b2: v² = b0, a = q'/2 = (b1 − b0)/h, c = q''/2 = (b0 − 2 b1 + b2)/h². As
    v'' = c v, the duration is 2 artanh(x)/√c with x = √c h/(v0 + v1), artan for c < 0 (docs/least-time.md). From rest,
    v = j t²/2 and s = j t³/6 give t = 3 h/v and j = 2 v/t².

    Args:
        h: Shape (n,), lengths.
        kind: Shape (n,), of `cncgen.planner.optimal.track`.
        q: Shape (n, 3), ordinates.
    """
    b0, b1, b2 = q.T
    v0, v2 = np.sqrt(b0), np.sqrt(b2)
    total = v0 + v2
    bend = b0 - 2.0 * b1 + b2
    x = bend / total**2
    duration = 2.0 * h / total * _stretched(x)
    v, a, j, c = v0, (b1 - b0) / h, np.zeros_like(h), bend / h**2
    rest = kind != SPLINE
    if np.any(rest):
        duration = np.where(rest, 3.0 * h / total, duration)
        constant = 2.0 * total / duration**2
        j, c = np.where(rest, constant, 0.0), np.where(rest, 0.0, c)
        a = np.where(kind == LEAVE, 0.0, np.where(kind == ENTER, -constant * duration, a))
    return Pieces(duration, v, a, j, c)


def _stretched(x: Floats) -> Floats:
    """Return artanh(√x)/√x, artan(√−x)/√−x for x < 0; by its series near 0."""
    root = np.sqrt(np.abs(x))
    near = np.abs(x) < 1e-3
    safe = np.where(near, 0.5, root)
    closed = np.where(x > 0.0, np.arctanh(np.minimum(safe, 1.0 - 1e-16)), np.arctan(safe)) / safe
    series = 1.0 + x * (1 / 3 + x * (1 / 5 + x * (1 / 7 + x * (1 / 9 + x / 11))))
    return np.where(near, series, closed)
