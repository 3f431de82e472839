"""Acceleration and jerk between the ends of intervals, where the rows of `cncgen.kernels.least_time` do not hold them.

`least_time` calls these functions as C (``least_time_between.pxd``).
"""

import cython
from cython.cimports.libc.math import fabs, sqrt

#: What limits are eased by at the start of a window in motion, by the slack.
_EASE = cython.declare(cython.double, 2.0)
#: The largest part of the jerk limit that is taken to hide between three values of the third derivative: of a cusp, those
#: tell little.
_CONCEALED = cython.declare(cython.double, 0.3)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _peak(value: cython.double[::1], first: cython.Py_ssize_t) -> cython.double:
    """Return the largest of five equidistant values between the first and the last, by parabolas through three of them.

    Where the largest of the five is inside, it is raised to the top of the parabola around it; where it is at an end,
    the largest inside is the top of the parabola through the three nearest to that end, if it lies between.
    """
    p: cython.Py_ssize_t
    best: cython.Py_ssize_t = first + 1
    bend: cython.double
    slope: cython.double
    for p in range(first + 2, first + 4):
        if value[p] > value[best]:
            best = p
    if value[best - 1] > value[best]:
        p = best - 1
        bend = 2.0 * value[best] - value[p] - value[best + 1]
        slope = 2.0 * (value[best] - value[p]) + bend
    elif value[best + 1] > value[best]:
        p = best + 1
        bend = 2.0 * value[best] - value[p] - value[best - 1]
        slope = 2.0 * (value[best] - value[p]) + bend
    else:
        p = best
        bend = 2.0 * value[p] - value[p - 1] - value[p + 1]
        slope = value[p + 1] - value[p - 1]
        return value[p] + slope * slope / (8.0 * bend) if bend > 0.0 else value[p]
    return value[p] + slope * slope / (8.0 * bend) if slope > 0.0 else value[best]


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def tighten(
    c: cython.double[::1],
    h: cython.double[::1],
    ends: cython.double[:, ::1],
    d1: cython.double[:, :, ::1],
    d2: cython.double[:, :, ::1],
    d3: cython.double[:, :, ::1],
    limits: cython.double[:, ::1],
    factor: cython.double[:, :, ::1],
    hidden: cython.double[:, ::1],
    share: cython.double[:, :, ::1],
    slack: cython.double,
    eased: cython.Py_ssize_t,
    fresh: cython.bint,
    value: cython.double[::1],
) -> cython.double:
    """Lower the limits of intervals between whose ends acceleration or jerk of an axis passes its limit.

    Derivatives of the path are given at both ends and the middle of each interval, and taken as quadratics between; what
    the third one is more at the quarter points adds to the jerk there.
    The largest values inside, estimated from three inner points, are compared with those at the ends, where the rows
    hold them. While the iterates are far from the optimum (`fresh`), ``share[k, 0]`` (acceleration) and ``share[k, 1]``
    (jerk) become the ratio of the largest value at the ends to the largest inside; later they are only lowered, where a
    limit is passed, and by half of `slack` more, lest the next iterate pass it again. The largest part of a limit that
    was found inside is returned, of the first `eased` intervals without their ease (see `apply`). `value` has room for
    10 doubles an axis.
    """
    n: cython.Py_ssize_t = h.shape[0]
    axes: cython.Py_ssize_t = d1.shape[2]
    k: cython.Py_ssize_t
    a: cython.Py_ssize_t
    p: cython.Py_ssize_t
    x: cython.double
    u: cython.double
    l0: cython.double
    l1: cython.double
    l2: cython.double
    b0: cython.double
    b2: cython.double
    q: cython.double
    dq: cython.double
    ddq: cython.double
    g: cython.double
    r: cython.double
    e1: cython.double
    e2: cython.double
    e3: cython.double
    acc: cython.double
    jerk: cython.double
    acc_end: cython.double
    jerk_end: cython.double
    acc_in: cython.double
    jerk_in: cython.double
    bulge: cython.double
    most: cython.double
    margin: cython.double = 1.0 if fresh else 1.0 - 0.5 * slack
    worst: cython.double = 0.0
    if fresh:
        for k in range(n):
            for a in range(axes):
                share[k, 0, a] = 1.0
                share[k, 1, a] = 1.0
    for k in range(n):
        b0 = ends[k, 0] * c[k] + ends[k, 1] * c[k + 1]
        b2 = ends[k, 2] * c[k + 1] + ends[k, 3] * c[k + 2]
        g = 1.0 / h[k]
        ddq = (b0 - 2.0 * c[k + 1] + b2) * g * g
        for p in range(5):
            x = 0.25 * p
            u = 1.0 - x
            l0 = u * (u - x)
            l1 = 4.0 * u * x
            l2 = x * (x - u)
            q = b0 * u * u + 2.0 * c[k + 1] * u * x + b2 * x * x
            dq = ((c[k + 1] - b0) * u + (b2 - c[k + 1]) * x) * g
            r = sqrt(q)
            for a in range(axes):
                e1 = l0 * d1[k, 0, a] + l1 * d1[k, 1, a] + l2 * d1[k, 2, a]
                e2 = l0 * d2[k, 0, a] + l1 * d2[k, 1, a] + l2 * d2[k, 2, a]
                e3 = l0 * d3[k, 0, a] + l1 * d3[k, 1, a] + l2 * d3[k, 2, a]
                value[10 * a + p] = fabs(e2 * q + e1 * dq)
                value[10 * a + 5 + p] = fabs(e3 * q + 3.0 * e2 * dq + e1 * ddq) * r
                if p & 1:
                    most = _CONCEALED * limits[1, a] * factor[k, 1, a]
                    value[10 * a + 5 + p] += min(hidden[k, a] * q * r, most)
        for a in range(axes):
            acc_end = max(value[10 * a], value[10 * a + 4])
            acc_in = _peak(value, 10 * a)
            jerk_end = max(value[10 * a + 5], value[10 * a + 9])
            jerk_in = _peak(value, 10 * a + 5)
            acc = acc_in / (limits[0, a] * factor[k, 0, a])
            jerk = jerk_in / (limits[1, a] * factor[k, 1, a])
            if k < eased:
                acc /= 1.0 + _EASE * slack
                jerk /= 1.0 + _EASE * slack
            worst = max(worst, max(acc, jerk))
            if acc > (0.9 if fresh else 1.0 + slack) and acc_in > acc_end:
                bulge = margin * acc_end / acc_in
                share[k, 0, a] = min(share[k, 0, a], bulge)
                if k + 1 < n:
                    share[k + 1, 0, a] = min(share[k + 1, 0, a], bulge)
            if jerk > (0.9 if fresh else 1.0 + slack) and jerk_in > jerk_end:
                share[k, 1, a] = min(share[k, 1, a], margin * jerk_end / jerk_in)
    return worst


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def apply(
    rows: cython.double[:, ::1],
    offset: cython.longlong[::1],
    kind: cython.char[::1],
    axis: cython.longlong[::1],
    share: cython.double[:, :, ::1],
    slack: cython.double,
    eased: cython.Py_ssize_t,
) -> cython.void:
    """Set the part f of the limits that each row may use; on the first `eased` intervals `_EASE` times `slack` more.

    A window that starts in motion has little choice there: the plan that gave the state may pass its rows by `slack`,
    and rows of two axes that bind against each other would leave none.
    """
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    ease: cython.double
    for k in range(share.shape[0]):
        ease = _EASE * slack if k < eased else 0.0
        for i in range(offset[k], offset[k + 1]):
            rows[i, 3] = share[k, 0 if kind[i] == 1 else 1, axis[i]] + ease if kind[i] > 0 else 1.0
