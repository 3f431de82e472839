# cython: infer_types=True
"""Elementary functions of the C library, element by element, by the names that NumPy gives them.

`cncgen.geometry.elementary` says why. Uncompiled, they are NumPy's.
"""

import cython
import numpy as np
from cython.cimports.libc.math import (
    acos,
    asin,
    atan,
    atan2,
    atanh,
    cbrt,
    exp,
    exp2,
    expm1,
    log,
    log1p,
    log2,
    pow,
)

OF_ONE = ("cbrt", "exp", "exp2", "expm1", "log", "log1p", "log2", "arcsin", "arccos", "arctan", "arctanh")


def of_one(name: str, x: cython.const[cython.double][::1], out: cython.double[::1]):
    """Fill `out` with the function `name`, one of `OF_ONE`, of each element of `x`; both have shape (n,)."""
    which: cython.Py_ssize_t = OF_ONE.index(name)
    if not cython.compiled:
        with np.errstate(all="ignore"):
            getattr(np, name)(x, out=out)
        return
    with cython.nogil:
        if which == 0:
            for k in range(x.shape[0]):
                out[k] = cbrt(x[k])
        elif which == 1:
            for k in range(x.shape[0]):
                out[k] = exp(x[k])
        elif which == 2:
            for k in range(x.shape[0]):
                out[k] = exp2(x[k])
        elif which == 3:
            for k in range(x.shape[0]):
                out[k] = expm1(x[k])
        elif which == 4:
            for k in range(x.shape[0]):
                out[k] = log(x[k])
        elif which == 5:
            for k in range(x.shape[0]):
                out[k] = log1p(x[k])
        elif which == 6:
            for k in range(x.shape[0]):
                out[k] = log2(x[k])
        elif which == 7:
            for k in range(x.shape[0]):
                out[k] = asin(x[k])
        elif which == 8:
            for k in range(x.shape[0]):
                out[k] = acos(x[k])
        elif which == 9:
            for k in range(x.shape[0]):
                out[k] = atan(x[k])
        elif which == 10:
            for k in range(x.shape[0]):
                out[k] = atanh(x[k])


def arctan2(
    y: cython.const[cython.double][::1], x: cython.const[cython.double][::1], out: cython.double[::1]
):
    """Fill `out` with the angle, rad, of each point (x, y); all have shape (n,)."""
    if not cython.compiled:
        np.arctan2(y, x, out=out)
        return
    with cython.nogil:
        for k in range(x.shape[0]):
            out[k] = atan2(y[k], x[k])


def power(x: cython.const[cython.double][::1], y: cython.const[cython.double][::1], out: cython.double[::1]):
    """Fill `out` with each x to the power y; all have shape (n,)."""
    if not cython.compiled:
        with np.errstate(all="ignore"):
            np.power(x, y, out=out)
        return
    with cython.nogil:
        for k in range(x.shape[0]):
            out[k] = pow(x[k], y[k])
