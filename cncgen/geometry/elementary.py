"""Elementary functions of arrays, with the same digits on every processor.

NumPy has several implementations of cbrt, exp, log, pow and most inverse functions. It chooses one by the processor, and they
differ in the last digit. A plan whose steps are chosen by such a digit would then depend on the machine that makes it. These
functions are those of the C library, element by element. (NumPy's sin, cos, sqrt and hypot are the same everywhere.)

All take arrays or numbers of any shapes that broadcast, and return doubles. Outside the domain of a function the result is infinite or
not a number, without a warning. Uncompiled kernels leave the functions to NumPy.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from cncgen.geometry.tables import Floats
from cncgen.kernels import elementary as kernel


def _of_one(name: str, x: ArrayLike) -> Floats:
    given = np.asarray(x, np.float64)
    out = np.empty(given.shape)
    kernel.of_one(name, given.ravel(), out.reshape(-1))
    return out[()]


def _of_two(function: Callable[[Floats, Floats, Floats], None], x: ArrayLike, y: ArrayLike) -> Floats:
    one, two = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(y, np.float64))
    out = np.empty(one.shape)
    function(one.ravel(), two.ravel(), out.reshape(-1))
    return out[()]


def cbrt(x: ArrayLike) -> Floats:
    """Return the cube root."""
    return _of_one("cbrt", x)


def exp(x: ArrayLike) -> Floats:
    """Return e to the power x."""
    return _of_one("exp", x)


def exp2(x: ArrayLike) -> Floats:
    """Return 2 to the power x."""
    return _of_one("exp2", x)


def expm1(x: ArrayLike) -> Floats:
    """Return exp(x) − 1."""
    return _of_one("expm1", x)


def log(x: ArrayLike) -> Floats:
    """Return the natural logarithm."""
    return _of_one("log", x)


def log1p(x: ArrayLike) -> Floats:
    """Return log(1 + x)."""
    return _of_one("log1p", x)


def log2(x: ArrayLike) -> Floats:
    """Return the logarithm to the base 2."""
    return _of_one("log2", x)


def arcsin(x: ArrayLike) -> Floats:
    """Return the angle, rad, whose sine is x, −π/2 to π/2."""
    return _of_one("arcsin", x)


def arccos(x: ArrayLike) -> Floats:
    """Return the angle, rad, whose cosine is x, 0 to π."""
    return _of_one("arccos", x)


def arctan(x: ArrayLike) -> Floats:
    """Return the angle, rad, whose tangent is x, −π/2 to π/2."""
    return _of_one("arctan", x)


def arctanh(x: ArrayLike) -> Floats:
    """Return the number whose hyperbolic tangent is x."""
    return _of_one("arctanh", x)


def arctan2(y: ArrayLike, x: ArrayLike) -> Floats:
    """Return the angle, rad, of the point (x, y), −π to π."""
    return _of_two(kernel.arctan2, y, x)


def power(x: ArrayLike, y: ArrayLike) -> Floats:
    """Return x to the power y."""
    return _of_two(kernel.power, x, y)


def product(a: Floats, b: Floats) -> Floats:
    """Return the matrix product a @ b of arrays of one or two dimensions, for few terms: each sum in the order of its terms.

    NumPy's rounds as the processor's library of matrices does; so does its norm of a vector (`length`).
    """
    if b.ndim == 1:
        return (a * b).sum(axis=-1)
    return (a[..., None] * b).sum(axis=-2)


def length(vector: Floats) -> np.float64:
    """Return the length of a vector, shape (n,), of few components."""
    return np.sqrt((vector * vector).sum())
