"""Reductions over the last axis of an array of short vectors, shape (…, axes) → (…).

Done column by column, which for a few columns is much faster than NumPy's reduction along the last axis. Maximum, minimum and
"any" are the same to the bit; sums are added from the first column to the last.
"""

from __future__ import annotations

from functools import reduce
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_Any = TypeVar("_Any", bound=np.generic)


def _columns(values: NDArray[_Any]) -> list[NDArray[_Any]]:
    """Return views of the columns: for a few of them in a quarter of the time of `numpy.moveaxis`."""
    return [values[..., column] for column in range(values.shape[-1])]


def max_over_axes(values: Floats) -> Floats:
    """Return the maximum over the last axis."""
    return reduce(np.maximum, _columns(values))


def min_over_axes(values: Floats) -> Floats:
    """Return the minimum over the last axis."""
    return reduce(np.minimum, _columns(values))


def norm(values: Floats) -> Floats:
    """Return the Euclidean norm over the last axis."""
    out: Floats = np.sqrt(total(values * values))
    return out


def total(values: Floats) -> Floats:
    """Return the sum over the last axis."""
    return reduce(np.add, _columns(values))


def anywhere(values: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return where any element of the last axis is true."""
    return reduce(np.logical_or, _columns(values))
