"""Designs: which points of the unit cube a sweep tries.

``grid``: every combination of the quantities' levels. ``latin_hypercube`` and ``sobol``: as scipy.stats.qmc draws them with a
seed. ``saltelli``: the matrices A, B and AB_i from which first-order and total sensitivities are estimated (Saltelli et al.
2010, Variance based sensitivity analysis of model output, Computer Physics Communications 181).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cncgen.interrupts import held

Floats = NDArray[np.float64]

DESIGNS = ("grid", "latin_hypercube", "sobol", "saltelli")
#: Columns of a Sobol sequence are tabulated to so many dimensions (scipy.stats.qmc.Sobol.MAXDIM).
MOST_DIMENSIONS = 21_201


def design_size(design: str, points: int, shares: Sequence[Sequence[float]]) -> int:
    """Return how many points a design has; the arguments are those of `unit_points`."""
    if not shares:
        return 1
    if design == "grid":
        return math.prod(len(column) for column in shares)
    return points * (len(shares) + 2) if design == "saltelli" else points


def unit_points(design: str, points: int, seed: int, shares: Sequence[Sequence[float]]) -> Floats:
    """Return the points of a design, shape (n, dimensions), each number from 0 to 1.

    Args:
        design: One of `DESIGNS`.
        points: Of a draw; of ``saltelli`` the rows of the matrices A and B. A grid needs none.
        seed: Of a draw.
        shares: The numbers that each dimension takes on a grid; other designs need their number of dimensions alone.
    """
    dimensions = len(shares)
    if not dimensions:
        return np.zeros((1, 0))
    if design == "grid":
        return np.array(list(itertools.product(*shares)))
    if design == "saltelli":
        base = _sobol(2 * dimensions, points, seed)
        first, second = base[:, :dimensions], base[:, dimensions:]
        blocks = [first, second]
        for k in range(dimensions):
            mixed = first.copy()
            mixed[:, k] = second[:, k]
            blocks.append(mixed)
        return np.vstack(blocks)
    if design == "sobol":
        return _sobol(dimensions, points, seed)
    from scipy.stats import qmc

    drawn: Floats = qmc.LatinHypercube(dimensions, seed=seed).random(points)
    return drawn


def _sobol(dimensions: int, points: int, seed: int) -> Floats:
    """Return the first points of a scrambled Sobol sequence; more points of one seed go on where fewer end."""
    import warnings

    from scipy.stats import qmc

    with warnings.catch_warnings():
        # The reader of the file reports a number that is not a power of two.
        warnings.simplefilter("ignore", UserWarning)
        with held():  # scipy reads a table where an exception would be printed and dropped
            sobol = qmc.Sobol(dimensions, scramble=True, seed=seed)
        drawn: Floats = sobol.random(points)
    return drawn


def is_power_of_two(points: int) -> bool:
    """Tell whether a Sobol sequence of so many points is balanced (Sobol' 1967; scipy.stats.qmc.Sobol says why)."""
    return points & (points - 1) == 0
