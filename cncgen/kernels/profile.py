# cython: infer_types=True
"""Exact evaluation of a speed profile, pieces with s''' = j + c s', and the time at which it reaches a place.

With w = s' the piece solves w'' = j + c w, w(0) = v, w'(0) = a. Put q = j + c v and

    S1 = τ φ1(x),  S2 = τ² φ2(x),  S3 = τ³ φ3(x),  x = c τ²,  φn(x) = Σ_k x^k / (2k + n)!

(the functions of Stumpff 1959: sinh, cosh − 1 and sinh − x for c > 0, sin, 1 − cos and x − sin for c < 0). Then

    s(τ) = s0 + v τ + a S2 + q S3,   s' = v + a S1 + q S2,   s'' = a (1 + c S2) + q S1,   s''' = c a S1 + q (1 + c S2).

Near x = 0 the closed forms cancel; there the series is summed (seven terms, 1e-16 for |x| < 1/4).
"""

import cython
from cython.cimports.libc.math import cos, cosh, fabs, sin, sinh, sqrt


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _phi(n: cython.int, x: cython.double) -> cython.double:
    """Sum φn(x) = Σ x^k / (2k + n)! for small x, from the last term inwards."""
    total: cython.double = 1.0
    for k in range(7, 0, -1):
        total = 1.0 + total * x / ((2 * k + n) * (2 * k + n - 1))
    if n == 2:
        return total / 2.0
    if n == 3:
        return total / 6.0
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _move(
    tau: cython.double,
    v: cython.double,
    a: cython.double,
    j: cython.double,
    c: cython.double,
    out: cython.double[::1],
) -> cython.void:
    """Write what a piece has done after τ: distance, speed, acceleration, jerk."""
    q: cython.double = j + c * v
    x: cython.double = c * tau * tau
    if fabs(x) < 0.25:
        f1 = tau * _phi(1, x)
        f2 = tau * tau * _phi(2, x)
        f3 = tau * tau * tau * _phi(3, x)
    elif c > 0.0:
        r = sqrt(c)
        f1 = sinh(r * tau) / r
        f2 = (cosh(r * tau) - 1.0) / c
        f3 = (f1 - tau) / c
    else:
        r = sqrt(-c)
        f1 = sin(r * tau) / r
        f2 = (cos(r * tau) - 1.0) / c
        f3 = (f1 - tau) / c
    out[0] = v * tau + a * f2 + q * f3
    out[1] = v + a * f1 + q * f2
    out[2] = a * (1.0 + c * f2) + q * f1
    out[3] = c * a * f1 + q * (1.0 + c * f2)


def evaluate(
    at: cython.double[::1],
    t: cython.double[::1],
    s0: cython.double[::1],
    v: cython.double[::1],
    a: cython.double[::1],
    j: cython.double[::1],
    c: cython.double[::1],
    state: cython.double[:, ::1],
    piece: cython.longlong[::1],
) -> cython.void:
    """Fill rows of s, s', s'', s''' and the index of the piece at each time of `at` (non-decreasing).

    The piece of a time is the last one that starts at or before it; a time before the first piece or after the last
    one (by rounding) is moved to the nearest end. `t` and `s0` have one entry more than there are pieces. Positions
    never pass the piece's end in `s0`, so that rounding cannot carry a sample over the end of the path.
    """
    n: cython.Py_ssize_t = at.shape[0]
    last: cython.Py_ssize_t = v.shape[0] - 1
    k: cython.Py_ssize_t = 0
    with cython.nogil:
        for i in range(n):
            while k < last and t[k + 1] <= at[i]:
                k += 1
            tau = at[i] - t[k]
            if tau < 0.0:
                tau = 0.0
            elif tau > t[k + 1] - t[k]:
                tau = t[k + 1] - t[k]
            _move(tau, v[k], a[k], j[k], c[k], state[i])
            state[i, 0] += s0[k]
            if state[i, 0] > s0[k + 1]:
                state[i, 0] = s0[k + 1]
            piece[i] = k


def invert(
    at: cython.double[::1],
    t: cython.double[::1],
    s0: cython.double[::1],
    v: cython.double[::1],
    a: cython.double[::1],
    j: cython.double[::1],
    c: cython.double[::1],
    work: cython.double[::1],
    time: cython.double[::1],
) -> cython.void:
    """Fill the times at which the profile leaves each place of `at` (any order); `work` has 4 entries.

    Newton's method kept inside a shrinking bracket, within the piece that a bisection over `s0` finds. At a place
    where the profile waits, the time is that of the end of the wait.
    """
    n: cython.Py_ssize_t = at.shape[0]
    last: cython.Py_ssize_t = v.shape[0] - 1
    with cython.nogil:
        for i in range(n):
            low = 0
            high = last
            while low < high:
                middle = (low + high + 1) // 2
                if s0[middle] <= at[i]:
                    low = middle
                else:
                    high = middle - 1
            left = 0.0
            right = t[low + 1] - t[low]
            goal = at[i] - s0[low]
            if goal <= 0.0:
                time[i] = t[low]
                continue
            if at[i] >= s0[low + 1]:
                time[i] = t[low + 1]
                continue
            tau = 0.5 * right
            for _round in range(200):
                _move(tau, v[low], a[low], j[low], c[low], work)
                miss = work[0] - goal
                if miss > 0.0:
                    right = tau
                else:
                    left = tau
                if fabs(miss) <= 1e-15 * goal:
                    break
                if work[1] > 0.0:
                    tau = tau - miss / work[1]
                if not (left < tau < right):
                    tau = 0.5 * (left + right)
                    if tau <= left or tau >= right:
                        break
            time[i] = t[low] + tau
