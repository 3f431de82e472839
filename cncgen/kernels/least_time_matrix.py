"""What the Newton step of the least-time problem is made of beside the rows: F, and its banded matrix.

The unknowns, their intervals and `ends` are those of `cncgen.kernels.least_time`, which calls these functions as C
(``least_time_matrix.pxd``).
"""

import cython
from cython.cimports.libc.math import sqrt


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def objective(
    c: cython.double[::1],
    h: cython.double[::1],
    ends: cython.double[:, ::1],
    extra: cython.double[:, ::1],
    grad: cython.double[::1],
    band: cython.double[:, ::1],
    root: cython.double[:, ::1],
) -> cython.double:
    """Return F; fill its gradient, the three upper diagonals of its Hessian in ``band[:, :3]``, and b^-1/2 in `root`."""
    n: cython.Py_ssize_t = h.shape[0]
    k: cython.Py_ssize_t
    total: cython.double = 0.0
    q0: cython.double
    q1: cython.double
    q2: cython.double
    m0: cython.double
    m1: cython.double
    m2: cython.double
    f0: cython.double
    f1: cython.double
    f2: cython.double
    e0: cython.double
    e1: cython.double
    e2: cython.double
    e3: cython.double
    for k in range(n + 2):
        grad[k] = 0.0
        band[k, 0] = 0.0
        band[k, 1] = 0.0
        band[k, 2] = 0.0
    for k in range(n):
        e0 = ends[k, 0]
        e1 = ends[k, 1]
        e2 = ends[k, 2]
        e3 = ends[k, 3]
        q0 = e0 * c[k] + e1 * c[k + 1]
        q2 = e2 * c[k + 1] + e3 * c[k + 2]
        q1 = 1.0 / (0.25 * (q0 + q2) + 0.5 * c[k + 1])
        q0 = 1.0 / q0
        q2 = 1.0 / q2
        root[k, 0] = sqrt(q0)
        root[k, 1] = sqrt(q2)
        f0 = (h[k] / 6.0 + extra[k, 0]) * root[k, 0]
        f2 = (h[k] / 6.0 + extra[k, 1]) * root[k, 1]
        f1 = h[k] / 1.5 * sqrt(q1)
        total += f0 + f1 + f2
        m0 = 0.25 * e0
        m1 = 0.25 * (e1 + e2) + 0.5
        m2 = 0.25 * e3
        f0 *= -0.5 * q0
        f1 *= -0.5 * q1
        f2 *= -0.5 * q2
        grad[k] += f0 * e0 + f1 * m0
        grad[k + 1] += f0 * e1 + f1 * m1 + f2 * e2
        grad[k + 2] += f1 * m2 + f2 * e3
        f0 *= -1.5 * q0
        f1 *= -1.5 * q1
        f2 *= -1.5 * q2
        band[k, 0] += f0 * e0 * e0 + f1 * m0 * m0
        band[k, 1] += f0 * e0 * e1 + f1 * m0 * m1
        band[k, 2] += f1 * m0 * m2
        band[k + 1, 0] += f0 * e1 * e1 + f1 * m1 * m1 + f2 * e2 * e2
        band[k + 1, 1] += f1 * m1 * m2 + f2 * e2 * e3
        band[k + 2, 0] += f1 * m2 * m2 + f2 * e3 * e3
    return total


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def factorize(band: cython.double[:, ::1], start: cython.Py_ssize_t, stop: cython.Py_ssize_t) -> cython.bint:
    """Factor the unknowns `start` to `stop` − 1 of the matrix as L D Lᵀ in place; return False where D is not positive."""
    k: cython.Py_ssize_t
    l1: cython.double
    l2: cython.double
    # What is left of the next two columns: two entries of the diagonal, and the one beside the first.
    d: cython.double = band[start, 0]
    beside: cython.double = band[start, 1]
    after: cython.double = band[start + 1, 0] if start + 1 < stop else 0.0
    for k in range(start, stop):
        if not d > 0.0:
            return False
        l1 = beside / d
        l2 = band[k, 2] / d
        band[k, 0] = d
        d = after - l1 * beside
        beside = band[k + 1, 1] - l1 * band[k, 2]
        after = band[k + 2, 0] - l2 * band[k, 2] if k + 2 < stop else 0.0
        band[k, 1] = l1
        band[k, 2] = l2
    return True


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def substitute(
    band: cython.double[:, ::1],
    start: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
    right: cython.double[::1],
    dc: cython.double[::1],
) -> cython.void:
    """Solve L D Lᵀ dc = right on the free unknowns; the others get 0."""
    k: cython.Py_ssize_t
    x: cython.double
    one: cython.double = 0.0
    two: cython.double = 0.0
    for k in range(dc.shape[0]):
        dc[k] = 0.0
    for k in range(start, stop):
        x = right[k]
        if k > start:
            x -= band[k - 1, 1] * one
        if k > start + 1:
            x -= band[k - 2, 2] * two
        dc[k] = x
        two = one
        one = x
    one = two = 0.0
    for k in range(stop - 1, start - 1, -1):
        x = dc[k] / band[k, 0] - band[k, 1] * one - band[k, 2] * two
        dc[k] = x
        two = one
        one = x


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def positive(c: cython.double[::1], dc: cython.double[::1], ends: cython.double[:, ::1]) -> cython.double:
    """Return the reciprocal of the longest step that keeps every ordinate of q non-negative."""
    k: cython.Py_ssize_t
    worst: cython.double = 0.0
    x: cython.double
    dx: cython.double
    for k in range(ends.shape[0]):
        worst = max(worst, -dc[k + 1] / c[k + 1])
        x = ends[k, 2] * c[k + 1] + ends[k, 3] * c[k + 2]
        dx = ends[k, 2] * dc[k + 1] + ends[k, 3] * dc[k + 2]
        worst = max(worst, -dx / x)
        x = ends[k, 0] * c[k] + ends[k, 1] * c[k + 1]
        dx = ends[k, 0] * dc[k] + ends[k, 1] * dc[k + 1]
        worst = max(worst, -dx / x)
    return worst
