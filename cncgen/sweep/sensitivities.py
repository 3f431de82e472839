"""Sobol' sensitivities of a figure to the varied quantities: shares of its variance.

The first-order share of a quantity is the part that its own variation explains, V[E(y|x_i)]/V(y). Its total share includes all
interactions with others, E[V(y|x_~i)]/V(y) (Sobol' 1993; Homma and Saltelli 1996). The estimators depend on the design:

* ``saltelli``: the estimators of Saltelli et al. 2010 (Computer Physics Communications 181, table 2: (b) for the first order)
  and of Jansen 1999 (same table, (f)) for the total.
* ``grid``: conditional means over the levels, which is exact for levels of equal weight.
* ``sobol`` and ``latin_hypercube``: a polynomial chaos expansion fitted by least squares, whose coefficients give both (Sudret 2008,
  Reliability Engineering & System Safety 93, eqs 35 to 39). Its degree is the one with the least leave-one-out error.

Of quantities that depend on each other (the covariance of an identification) the shares are those of the independent numbers
behind them, in the order of the parameters.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Most terms of an expansion, and most rows times terms squared of its fit: some seconds.
_MOST_TERMS, _MOST_WORK = 2000, 4e9
#: Highest degree of an expansion, and most quantities in one term.
_MOST_DEGREE, _MOST_TOGETHER = 20, 4
#: A degree is the best where so many after it are no better, or where it leaves no more than this share of the variance.
_NO_BETTER, _EXACT = 3, 1e-12
#: Rows that each term of an expansion must have.
_ROWS_A_TERM = 2


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """Shares of a figure's variance.

    Attributes:
        column: What is varied.
        first, total: NaN where the figure does not vary, or cannot be told.
    """

    column: str
    first: float
    total: float


@dataclass(frozen=True, slots=True)
class Sensitivities:
    """The sensitivities of one figure in one group of jobs.

    Attributes:
        figure: Its name.
        method: ``saltelli``, ``grid``, or ``expansion of degree 5``.
        rows: How many rows they are estimated from.
        explained: Of an expansion, the share of the variance that it predicts of rows that it has not seen (1 − the relative
            leave-one-out error); else 1.
        shares: A row a dimension.
    """

    figure: str
    method: str
    rows: int
    explained: float
    shares: tuple[Sensitivity, ...]


def sensitivities(
    design: str, points: Floats, levels: Sequence[int], columns: Sequence[str], figure: str, values: Floats
) -> Sensitivities:
    """Estimate the sensitivities of a figure from a design.

    Args:
        design: One of `designs.DESIGNS`.
        points: Shape (n, d), from `designs.unit_points`.
        levels: Shape (d,): levels of a list, 0 of a range.
        columns: Shape (d,): names.
        figure: Its name.
        values: Shape (n,); NaN where a job failed.
    """
    known = np.isfinite(values)
    dimensions = points.shape[1]
    method, explained = design, 1.0
    if design == "saltelli":
        first, total, count = from_matrices(values, dimensions)
    elif design == "grid" and known.all():
        shape = [len(np.unique(points[:, k])) for k in range(dimensions)]
        first, total = from_grid(values.reshape(shape))
        count = len(values)
    else:
        first, total, explained, degree = from_expansion(points[known], values[known], levels)
        method, count = f"expansion of degree {degree}", int(known.sum())
    shares = tuple(Sensitivity(c, float(f), float(t)) for c, f, t in zip(columns, first, total, strict=True))
    return Sensitivities(figure, method, count, explained, shares)


def from_matrices(values: Floats, dimensions: int) -> tuple[Floats, Floats, int]:
    """Return first-order and total shares, shape (d,), from f(A), f(B), f(AB_1) … below each other; and the rows used.

    Where one of a row's values is missing, the row is left out of all of them.
    """
    blocks = values.reshape(dimensions + 2, -1)
    blocks = blocks[:, np.isfinite(blocks).all(axis=0)]
    rows = blocks.shape[1]
    if rows < 2:
        return *_unknown(dimensions), rows * (dimensions + 2)
    blocks = (
        blocks - blocks[:2].mean()
    )  # the first-order estimator is the better, the nearer the mean is to 0
    a, b, mixed = blocks[0], blocks[1], blocks[2:]
    variance = float(blocks[:2].var())
    if not variance > 0.0:
        return *_unknown(dimensions), rows * (dimensions + 2)
    first = (b * (mixed - a)).mean(axis=1) / variance
    total = 0.5 * ((a - mixed) ** 2).mean(axis=1) / variance
    return first, total, rows * (dimensions + 2)


def from_grid(values: Floats) -> tuple[Floats, Floats]:
    """Return first-order and total shares, shape (d,), of values on a grid, an axis a quantity."""
    variance = float(values.var())
    if not variance > 0.0:
        return _unknown(values.ndim)
    axes = range(values.ndim)
    first = [values.mean(axis=tuple(j for j in axes if j != i)).var() for i in axes]
    total = [values.var(axis=i).mean() for i in axes]
    return np.array(first) / variance, np.array(total) / variance


def from_expansion(
    points: Floats, values: Floats, levels: Sequence[int]
) -> tuple[Floats, Floats, float, int]:
    """Fit polynomial chaos expansions; return first-order and total shares, shape (d,), of the best, its Q² and its degree.

    Args:
        points: Shape (n, d), as if drawn uniformly from [0, 1]^d.
        values: Shape (n,).
        levels: Shape (d,): 0 of a range, else how many levels the unit interval is cut into.
    """
    dimensions = points.shape[1]
    variance = float(values.var()) if len(values) else 0.0
    best: tuple[float, Floats, list[tuple[int, ...]]] | None = None
    degree = 0
    if variance > 0.0:
        tables = [_basis(points[:, k], levels[k]) for k in range(dimensions)]
        for trial in range(1, _MOST_DEGREE + 1):
            terms = list(_terms(dimensions, trial, [table.shape[1] - 1 for table in tables], len(values)))
            if not _affordable(len(values), len(terms)):
                break
            error, coefficients = _fitted(tables, terms, values)
            if best is None or error < best[0]:
                best, degree = (error, coefficients, terms), trial
            if trial >= degree + _NO_BETTER or best[0] <= _EXACT * variance:
                break
    if best is None:
        return *_unknown(dimensions), float("nan"), 0
    error, coefficients, terms = best
    power = coefficients**2
    whole = float(power[1:].sum())  # the first term is the mean
    if not whole > 0.0:
        return *_unknown(dimensions), float("nan"), degree
    used = np.array(terms) > 0
    alone = used.sum(axis=1) == 1
    first = np.array([power[used[:, k] & alone].sum() for k in range(dimensions)]) / whole
    total = np.array([power[used[:, k]].sum() for k in range(dimensions)]) / whole
    return first, total, 1.0 - error / variance, degree


def _unknown(dimensions: int) -> tuple[Floats, Floats]:
    return np.full(dimensions, np.nan), np.full(dimensions, np.nan)


def _affordable(rows: int, terms: int) -> bool:
    return terms <= _MOST_TERMS and rows >= _ROWS_A_TERM * terms and rows * terms**2 <= _MOST_WORK


def _basis(u: Floats, levels: int) -> Floats:
    """Return functions of one dimension that are orthonormal under its law, the constant first, shape (n, degrees + 1).

    Of a range: Legendre polynomials. Of a list of L levels: polynomials in the number of the level, as many as there are levels.
    """
    if levels == 0:
        table = np.polynomial.legendre.legvander(2.0 * u - 1.0, _MOST_DEGREE)
        scaled: Floats = table * np.sqrt(2.0 * np.arange(_MOST_DEGREE + 1) + 1.0)
        return scaled
    index = np.minimum((u * levels).astype(np.intp), levels - 1)
    degree = min(levels - 1, _MOST_DEGREE)
    middles = (2.0 * np.arange(levels) + 1.0) / levels - 1.0
    orthonormal, _ = np.linalg.qr(np.polynomial.legendre.legvander(middles, degree))
    found: Floats = (orthonormal * np.sqrt(levels))[index]
    return found


def _terms(dimensions: int, degree: int, highest: Sequence[int], rows: int) -> Iterator[tuple[int, ...]]:
    """Yield exponents of total degree up to `degree`, the constant first; no more than a fit to so many rows can have."""
    most = min(_MOST_TERMS, rows // _ROWS_A_TERM) + 1
    count = 1
    yield (0,) * dimensions
    for together in range(1, min(dimensions, degree, _MOST_TOGETHER) + 1):
        for chosen in itertools.combinations(range(dimensions), together):
            for powers in itertools.product(*(range(1, min(highest[k], degree) + 1) for k in chosen)):
                if sum(powers) <= degree:
                    term = [0] * dimensions
                    for k, power in zip(chosen, powers, strict=True):
                        term[k] = power
                    yield tuple(term)
                    count += 1
                    if count > most:
                        return


def _fitted(
    tables: Sequence[Floats], terms: Sequence[tuple[int, ...]], values: Floats
) -> tuple[float, Floats]:
    """Return the mean squared leave-one-out error of a least-squares expansion, and its coefficients, shape (terms,).

    The error needs one fit alone: a residual over 1 less its row's leverage (Blatman and Sudret 2011, eq. 28).
    """
    matrix = np.ones((len(values), len(terms)))
    for column, term in enumerate(terms):
        for k, power in enumerate(term):
            if power:
                matrix[:, column] *= tables[k][:, power]
    left, right = np.linalg.qr(matrix)
    if np.abs(np.diag(right)).min() < 1e-10 * np.abs(np.diag(right)).max():
        return np.inf, np.zeros(len(terms))  # the points do not tell so many terms apart
    coefficients = np.linalg.solve(right, left.T @ values)
    leverage = (left**2).sum(axis=1)
    loo = (values - matrix @ coefficients) / np.maximum(1.0 - leverage, 1e-12)
    return float((loo**2).mean()), coefficients
