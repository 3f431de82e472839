"""Acceleration and jerk between the ends of intervals, where the rows of `cncgen.kernels.least_time` do not hold them.

`least_time` calls these functions as C (``least_time_between.pxd``).
"""

import cython
from cython.cimports.libc.math import fabs, sqrt

#: v², half its derivative, and v.
_Motion = cython.struct(q=cython.double, dq=cython.double, r=cython.double)

#: What limits are eased by at the start of a window in motion, by the slack.
_EASE = cython.declare(cython.double, 2.0)
#: The largest part of the jerk limit that is taken to hide between three values of the third derivative: of a cusp, those
#: tell little.
_CONCEALED = cython.declare(cython.double, 0.3)
#: The largest part of a limit that five values use which is not looked at any closer: between them, it is an eighth more.
_FAR = cython.declare(cython.double, 0.75)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _motion(
    b0: cython.double, b1: cython.double, b2: cython.double, g: cython.double, x: cython.double
) -> _Motion:
    """Return the motion at a part `x` of an interval of the length 1 / `g`, by the Bézier ordinates of v²."""
    u: cython.double = 1.0 - x
    q: cython.double = b0 * u * u + 2.0 * b1 * u * x + b2 * x * x
    return _Motion(q, ((b1 - b0) * u + (b2 - b1) * x) * g, sqrt(q))


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _peak(
    v0: cython.double, v1: cython.double, v2: cython.double, v3: cython.double, v4: cython.double
) -> cython.double:
    """Return the largest of five equidistant values between the first and the last, by parabolas through three of them.

    Where the largest of the five is inside, it is raised to the top of the parabola around it; where it is at an end,
    the largest inside is the top of the parabola through the three nearest to that end, if it lies between.
    """
    bend: cython.double
    slope: cython.double
    # The largest inside, and its neighbours.
    before: cython.double = v0
    best: cython.double = v1
    after: cython.double = v2
    if v2 > best:
        before, best, after = v1, v2, v3
    if v3 > best:
        before, best, after = v2, v3, v4
    if before > best:
        bend = 2.0 * best - before - after
        slope = 2.0 * (best - before) + bend
        return before + slope * slope / (8.0 * bend) if slope > 0.0 else best
    if after > best:
        bend = 2.0 * best - after - before
        slope = 2.0 * (best - after) + bend
        return after + slope * slope / (8.0 * bend) if slope > 0.0 else best
    bend = 2.0 * best - before - after
    slope = after - before
    return best + slope * slope / (8.0 * bend) if bend > 0.0 else best


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _quarter(near: cython.double, middle: cython.double, far: cython.double) -> cython.double:
    """Return a parabola's value a quarter of the way from one end to the other, by those at the ends and in the middle."""
    return 0.375 * near + 0.75 * middle - 0.125 * far


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _jerk(
    e1: cython.double, e2: cython.double, e3: cython.double, at: _Motion, ddq: cython.double
) -> cython.double:
    """Return the size of the jerk where the path has the derivatives e1, e2 and e3."""
    return fabs(e3 * at.q + 3.0 * e2 * at.dq + e1 * ddq) * at.r


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
) -> cython.double:
    """Lower the limits of intervals between whose ends acceleration or jerk of an axis passes its limit.

    Derivatives of the path are given at both ends and the middle of each interval, and taken as quadratics between; what
    the third one is more at the quarter points adds to the jerk there.
    The largest values inside, estimated from three inner points, are compared with those at the ends, where the rows
    hold them. While the iterates are far from the optimum (`fresh`), ``share[k, 0]`` (acceleration) and ``share[k, 1]``
    (jerk) become the ratio of the largest value at the ends to the largest inside; later they are only lowered, where a
    limit is passed, and by half of `slack` more, lest the next iterate pass it again. The largest part of a limit that
    was found inside is returned, of the first `eased` intervals without their ease (see `apply`).
    """
    n: cython.Py_ssize_t = h.shape[0]
    axes: cython.Py_ssize_t = d1.shape[2]
    k: cython.Py_ssize_t
    a: cython.Py_ssize_t
    b0: cython.double
    b2: cython.double
    ddq: cython.double
    g: cython.double
    m0: _Motion
    m1: _Motion
    m2: _Motion
    m3: _Motion
    m4: _Motion
    x1: cython.double
    x2: cython.double
    x3: cython.double
    y1: cython.double
    y2: cython.double
    y3: cython.double
    v0: cython.double
    v1: cython.double
    v2: cython.double
    v3: cython.double
    v4: cython.double
    limit: cython.double
    inside: cython.double
    end: cython.double
    near: cython.double = 0.9 if fresh else 1.0 + slack
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
        m0 = _motion(b0, c[k + 1], b2, g, 0.0)
        m1 = _motion(b0, c[k + 1], b2, g, 0.25)
        m2 = _motion(b0, c[k + 1], b2, g, 0.5)
        m3 = _motion(b0, c[k + 1], b2, g, 0.75)
        m4 = _motion(b0, c[k + 1], b2, g, 1.0)
        for a in range(axes):
            x1 = _quarter(d1[k, 0, a], d1[k, 1, a], d1[k, 2, a])
            x2 = _quarter(d2[k, 0, a], d2[k, 1, a], d2[k, 2, a])
            y1 = _quarter(d1[k, 2, a], d1[k, 1, a], d1[k, 0, a])
            y2 = _quarter(d2[k, 2, a], d2[k, 1, a], d2[k, 0, a])
            v0 = fabs(d2[k, 0, a] * m0.q + d1[k, 0, a] * m0.dq)
            v1 = fabs(x2 * m1.q + x1 * m1.dq)
            v2 = fabs(d2[k, 1, a] * m2.q + d1[k, 1, a] * m2.dq)
            v3 = fabs(y2 * m3.q + y1 * m3.dq)
            v4 = fabs(d2[k, 2, a] * m4.q + d1[k, 2, a] * m4.dq)
            limit = limits[0, a] * factor[k, 0, a]
            if k < eased:
                limit *= 1.0 + _EASE * slack
            inside = max(v1, max(v2, v3))
            end = max(v0, v4)
            if max(inside, end) > _FAR * limit:
                inside = _peak(v0, v1, v2, v3, v4)
                if inside > near * limit and inside > end:
                    bulge = margin * end / inside
                    share[k, 0, a] = min(share[k, 0, a], bulge)
                    if k + 1 < n:
                        share[k + 1, 0, a] = min(share[k + 1, 0, a], bulge)
            if inside > worst * limit:
                worst = inside / limit
            x3 = _quarter(d3[k, 0, a], d3[k, 1, a], d3[k, 2, a])
            y3 = _quarter(d3[k, 2, a], d3[k, 1, a], d3[k, 0, a])
            limit = limits[1, a] * factor[k, 1, a]
            most = _CONCEALED * limit
            v0 = _jerk(d1[k, 0, a], d2[k, 0, a], d3[k, 0, a], m0, ddq)
            v1 = _jerk(x1, x2, x3, m1, ddq) + min(hidden[k, a] * m1.q * m1.r, most)
            v2 = _jerk(d1[k, 1, a], d2[k, 1, a], d3[k, 1, a], m2, ddq)
            v3 = _jerk(y1, y2, y3, m3, ddq) + min(hidden[k, a] * m3.q * m3.r, most)
            v4 = _jerk(d1[k, 2, a], d2[k, 2, a], d3[k, 2, a], m4, ddq)
            if k < eased:
                limit *= 1.0 + _EASE * slack
            inside = max(v1, max(v2, v3))
            end = max(v0, v4)
            if max(inside, end) > _FAR * limit:
                inside = _peak(v0, v1, v2, v3, v4)
                if inside > near * limit and inside > end:
                    share[k, 1, a] = min(share[k, 1, a], margin * end / inside)
            if inside > worst * limit:
                worst = inside / limit
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
