"""Exact transition of linear systems over a period: the matrix exponential and the holds.

Own routines, since they serve matrices of a dozen rows at most and importing scipy costs more than a simulation.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Terms of the Taylor series, enough for 1-norms up to 1/2: 0.5^19/19! is below 1e-22.
_TERMS = 18


def exponential(matrix: Floats) -> Floats:
    """Return e^M of a square matrix: balanced, scaled to a 1-norm below 1/2, Taylor series, squared back.

    Source: C. Moler and C. Van Loan, Nineteen dubious ways to compute the exponential of a matrix, SIAM Review 45
    (2003), method 3. A balanced matrix keeps the squarings few where states differ much in size.
    """
    balanced, scale = _balanced(np.asarray(matrix, float))
    norm = np.abs(balanced).sum(axis=0).max(initial=0.0)
    squarings = max(0, math.frexp(norm)[1] + 1) if norm > 0.5 else 0
    step = balanced / 2.0**squarings
    identity = np.eye(len(step))
    result = identity
    for k in range(_TERMS, 0, -1):
        result = identity + step @ result / k
    for _ in range(squarings):
        result = result @ result
    return scale[:, None] * result / scale


def _balanced(matrix: Floats) -> tuple[Floats, Floats]:
    """Return D⁻¹ M D with rows and columns of like size, and D's diagonal: powers of two, so nothing is rounded.

    Source: B. N. Parlett and C. Reinsch, Balancing a matrix, Numerische Mathematik 13 (1969) 293.
    On lists: for a dozen rows that is several times faster than numpy's calls.
    """
    n = len(matrix)
    size: list[list[float]] = np.abs(matrix).tolist()
    scale = [1.0] * n
    for _ in range(20):
        changed = False
        for i in range(n):
            row = sum(size[i]) - size[i][i]
            column = sum(line[i] for line in size) - size[i][i]
            if not (0.0 < column < math.inf and 0.0 < row < math.inf):
                continue
            factor = 2.0 ** round(0.5 * (math.log2(row) - math.log2(column)))
            if factor != 1.0:
                size[i] = [value / factor for value in size[i]]
                for line in size:
                    line[i] *= factor
                scale[i] *= factor
                changed = True
        if not changed:
            break
    diagonal = np.array(scale)
    return matrix * diagonal / diagonal[:, None], diagonal


def held(a: Floats, b: Floats, period: float) -> tuple[Floats, Floats]:
    """Return (Φ, Γ) of ẋ = A x + B u with u held over the period (zero-order hold).

    Both are blocks of the exponential of ((A, B), (0, 0)) T: C. F. Van Loan, Computing integrals involving the matrix
    exponential, IEEE Trans. Automatic Control 23 (1978) 395.

    Args:
        a: Shape (n, n).
        b: Shape (n, m).
        period: s.
    """
    n, m = b.shape
    block = np.zeros((n + m, n + m))
    block[:n, :n], block[:n, n:] = a, b
    result = exponential(block * period)
    return result[:n, :n], result[:n, n:]


def ramped(a: Floats, b: Floats, period: float) -> tuple[Floats, Floats, Floats]:
    """Return (Φ, Γ0, Γ1) of ẋ = A x + B u with u going straight from u0 to u1 (first-order hold).

    x(T) = Φ x(0) + Γ0 u0 + Γ1 u1, by the same exponential with u and its slope as states. Shapes as `held`.
    """
    n, m = b.shape
    block = np.zeros((n + 2 * m, n + 2 * m))
    block[:n, :n], block[:n, n : n + m] = a * period, b * period
    block[n : n + m, n + m :] = np.eye(m)
    result = exponential(block)
    constant, slope = result[:n, n : n + m], result[:n, n + m :]
    return result[:n, :n], constant - slope, slope
