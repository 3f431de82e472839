"""Primal-dual interior-point method for the least time along a path (docs/least-time.md).

Unknown is q(s) = v² as a quadratic spline, by its Bézier middle ordinates: ``c[k + 1]`` belongs to interval `k`, and the
ordinates at the interval's ends are ``b0 = ends[k,0] c[k] + ends[k,1] c[k+1]`` and ``b2 = ends[k,2] c[k+1] +
ends[k,3] c[k+2]``. ``c[0]`` and ``c[n+1]`` are given; so is ``c[1]`` where the window starts in motion. Minimised is

    F = Σ h/6 (b0^-1/2 + 4 m^-1/2 + b2^-1/2) + Σ extra0 b0^-1/2 + Σ extra2 b2^-1/2,   m = (b0 + 2 c + b2) / 4,

subject to rows r(q) ± A·(c[k], c[k+1], c[k+2]) ≥ 0 that each touch three neighbours. Hence the Newton matrix has five
diagonals, and an iteration is linear in the number of intervals: three passes over the rows, which memory traffic bounds.

A row of `rows` is (A0, A1, A2, f, w+, w−, λ+, λ−, Δw+, Δw−, Δλ+, Δλ−): `w` slacks, `λ` multipliers. By its kind, r = f
on an upper bound (`BOX`, one-sided) and on an acceleration, and r = f b^-1/2 on a jerk at the left or the right end of
the interval, b the ordinate there.

The function r is convex, so its tangent lies below it: a step along which the linearised constraint holds keeps the
constraint itself (Hunter and Lange, *A tutorial on MM algorithms*, 2004), and slacks may be reset to the constraint's
value wherever that is larger. Steps follow Mehrotra (*SIAM J. Optim.* 2, 1992), those
of slacks and of multipliers each as long as they may be.
"""

import cython
from cython.cimports.libc.math import fabs, sqrt

#: Columns of `rows`.
WIDTH = 12
#: What a row bounds.
BOX, ACCELERATION, JERK_LEFT, JERK_RIGHT = range(4)
#: What limits are eased by at the start of a window in motion, by the slack, and on how many intervals.
_EASE = cython.declare(cython.double, 2.0)
_EASED = cython.declare(cython.Py_ssize_t, 3)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _objective(
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


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _gather(
    c: cython.double[::1],
    ends: cython.double[:, ::1],
    root: cython.double[:, ::1],
    rows: cython.double[:, ::1],
    offset: cython.longlong[::1],
    kind: cython.char[::1],
    step: cython.double,
    rise: cython.double,
    mu: cython.double,
    grad: cython.double[::1],
    dual: cython.double[::1],
    right: cython.double[::1],
    band: cython.double[:, ::1],
    out: cython.double[::1],
) -> cython.void:
    """Move slacks by `step`, multipliers by `rise`; add the rows' share to the predictor's Newton matrix and right side.

    Slacks are raised to the value g of their constraint where that is larger. Where `mu` is positive, the rows are set
    up: slacks to g, r at least, multipliers on the central path. `dual` becomes the residual ∇F − Σ λ ∇g, ``out[0]``
    the largest −g / r, how far a constraint is broken as a part of its limit, and ``out[1]`` the gap Σ λ w.
    With ∇r = p, the gradients of a row's two constraints are p ∓ A.
    """
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t = ends.shape[0]
    c0: cython.double
    c1: cython.double
    c2: cython.double
    a0: cython.double
    a1: cython.double
    a2: cython.double
    p0: cython.double
    p1: cython.double
    p2: cython.double
    m00: cython.double
    m01: cython.double
    m02: cython.double
    m11: cython.double
    m12: cython.double
    m22: cython.double
    d0: cython.double
    d1: cython.double
    d2: cython.double
    r0: cython.double
    r1: cython.double
    r2: cython.double
    value: cython.double
    r: cython.double
    slope: cython.double
    w0: cython.double
    w1: cython.double
    y0: cython.double
    y1: cython.double
    s0: cython.double
    s1: cython.double
    t0: cython.double
    t1: cython.double
    inverse: cython.double
    more: cython.double
    less: cython.double
    worst: cython.double = 0.0
    gap: cython.double = 0.0
    for k in range(n + 2):
        right[k] = -grad[k]
        dual[k] = grad[k]
    for k in range(n):
        c0 = c[k]
        c1 = c[k + 1]
        c2 = c[k + 2]
        m00 = m01 = m02 = m11 = m12 = m22 = 0.0
        d0 = d1 = d2 = r0 = r1 = r2 = 0.0
        for i in range(offset[k], offset[k + 1]):
            a0 = rows[i, 0]
            a1 = rows[i, 1]
            a2 = rows[i, 2]
            r = rows[i, 3]
            p0 = p1 = p2 = 0.0
            if kind[i] == 2:
                r *= root[k, 0]
                slope = -0.5 * r * root[k, 0] * root[k, 0]
                p0 = slope * ends[k, 0]
                p1 = slope * ends[k, 1]
            elif kind[i] == 3:
                r *= root[k, 1]
                slope = -0.5 * r * root[k, 1] * root[k, 1]
                p1 = slope * ends[k, 2]
                p2 = slope * ends[k, 3]
            value = a0 * c0 + a1 * c1 + a2 * c2
            if mu > 0.0:
                w0 = max(r - value, r)
                w1 = max(r + value, r)
                y0 = mu / w0
                y1 = mu / w1
            else:
                w0 = max(rows[i, 4] + step * rows[i, 8], r - value)
                w1 = max(rows[i, 5] + step * rows[i, 9], r + value)
                y0 = rows[i, 6] + rise * rows[i, 10]
                y1 = rows[i, 7] + rise * rows[i, 11]
            if kind[i] == 0:
                w1 = 1.0
                y1 = 0.0
            rows[i, 4] = w0
            rows[i, 5] = w1
            rows[i, 6] = y0
            rows[i, 7] = y1
            gap += w0 * y0 + w1 * y1
            inverse = 1.0 / (w0 * w1)
            s0 = y0 * w1 * inverse
            s1 = y1 * w0 * inverse
            t0 = value if kind[i] == 0 else fabs(value)
            if t0 - r > worst * r:
                worst = t0 / r - 1.0
            t0 = s0 * (w0 - r + value)
            t1 = s1 * (w1 - r - value)
            more = s0 + s1
            m00 += more * a0 * a0
            m01 += more * a0 * a1
            m02 += more * a0 * a2
            m11 += more * a1 * a1
            m12 += more * a1 * a2
            m22 += more * a2 * a2
            s0 = s1 - s0
            less = y1 - y0
            y0 = y0 + y1
            t1 = t1 - t0
            t0 = t1 + 2.0 * t0
            if kind[i] == 2:
                m00 += p0 * (more * p0 + 2.0 * s0 * a0)
                m01 += p0 * (more * p1 + s0 * a1) + s0 * p1 * a0
                m02 += p0 * s0 * a2
                m11 += p1 * (more * p1 + 2.0 * s0 * a1)
                m12 += p1 * s0 * a2
            elif kind[i] == 3:
                m01 += s0 * p1 * a0
                m02 += s0 * p2 * a0
                m11 += p1 * (more * p1 + 2.0 * s0 * a1)
                m12 += p1 * (more * p2 + s0 * a2) + s0 * p2 * a1
                m22 += p2 * (more * p2 + 2.0 * s0 * a2)
            d0 += less * a0 + y0 * p0
            d1 += less * a1 + y0 * p1
            d2 += less * a2 + y0 * p2
            r0 += t1 * a0 + t0 * p0
            r1 += t1 * a1 + t0 * p1
            r2 += t1 * a2 + t0 * p2
        dual[k] -= d0
        dual[k + 1] -= d1
        dual[k + 2] -= d2
        right[k] += r0
        right[k + 1] += r1
        right[k + 2] += r2
        band[k, 0] += m00
        band[k, 1] += m01
        band[k, 2] += m02
        band[k + 1, 0] += m11
        band[k + 1, 1] += m12
        band[k + 2, 0] += m22
    out[0] = worst
    out[1] = gap


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _factor(band: cython.double[:, ::1], start: cython.Py_ssize_t, stop: cython.Py_ssize_t) -> cython.bint:
    """Factor the unknowns `start` to `stop` − 1 of the matrix as L D Lᵀ in place; return False where D is not positive."""
    k: cython.Py_ssize_t
    d: cython.double
    l1: cython.double
    l2: cython.double
    for k in range(start, stop):
        d = band[k, 0]
        if not d > 0.0:
            return False
        l1 = band[k, 1] / d
        l2 = band[k, 2] / d
        if k + 1 < stop:
            band[k + 1, 0] -= l1 * band[k, 1]
            band[k + 1, 1] -= l1 * band[k, 2]
        if k + 2 < stop:
            band[k + 2, 0] -= l2 * band[k, 2]
        band[k, 1] = l1
        band[k, 2] = l2
    return True


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _substitute(
    band: cython.double[:, ::1],
    start: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
    right: cython.double[::1],
    dc: cython.double[::1],
) -> cython.void:
    """Solve L D Lᵀ dc = right on the free unknowns; the others get 0."""
    k: cython.Py_ssize_t
    for k in range(dc.shape[0]):
        dc[k] = 0.0
    for k in range(start, stop):
        dc[k] = right[k]
        if k > start:
            dc[k] -= band[k - 1, 1] * dc[k - 1]
        if k > start + 1:
            dc[k] -= band[k - 2, 2] * dc[k - 2]
    for k in range(start, stop):
        dc[k] /= band[k, 0]
    for k in range(stop - 2, start - 1, -1):
        dc[k] -= band[k, 1] * dc[k + 1]
        if k + 2 < stop:
            dc[k] -= band[k, 2] * dc[k + 2]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _predict(
    c: cython.double[::1],
    dc: cython.double[::1],
    ends: cython.double[:, ::1],
    root: cython.double[:, ::1],
    rows: cython.double[:, ::1],
    offset: cython.longlong[::1],
    kind: cython.char[::1],
    centre: cython.double[::1],
    second: cython.double[::1],
    out: cython.double[::1],
) -> cython.void:
    """Find the predictor's Δw and Δλ; keep their product alone, in the place of Δw.

    ``second + mu centre`` becomes what the corrector's right side has more than the predictor's; `out` the reciprocals
    of the longest primal and dual step to the boundary, then the sums of w λ, Δw λ, w Δλ and Δw Δλ.
    """
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t = ends.shape[0]
    a0: cython.double
    a1: cython.double
    a2: cython.double
    p0: cython.double
    p1: cython.double
    p2: cython.double
    r: cython.double
    slope: cython.double
    turn: cython.double
    w0: cython.double
    w1: cython.double
    y0: cython.double
    y1: cython.double
    dw: cython.double
    dy: cython.double
    z0: cython.double
    z1: cython.double
    u0: cython.double
    u1: cython.double
    g0: cython.double
    g1: cython.double
    g2: cython.double
    h0: cython.double
    h1: cython.double
    h2: cython.double
    primal: cython.double = 0.0
    dual: cython.double = 0.0
    sum0: cython.double = 0.0
    sum1: cython.double = 0.0
    sum2: cython.double = 0.0
    sum3: cython.double = 0.0
    for k in range(n + 2):
        centre[k] = 0.0
        second[k] = 0.0
    for k in range(n):
        g0 = g1 = g2 = h0 = h1 = h2 = 0.0
        for i in range(offset[k], offset[k + 1]):
            a0 = rows[i, 0]
            a1 = rows[i, 1]
            a2 = rows[i, 2]
            r = rows[i, 3]
            p0 = p1 = p2 = 0.0
            if kind[i] == 2:
                r *= root[k, 0]
                slope = -0.5 * r * root[k, 0] * root[k, 0]
                p0 = slope * ends[k, 0]
                p1 = slope * ends[k, 1]
                r += p0 * dc[k] + p1 * dc[k + 1]
            elif kind[i] == 3:
                r *= root[k, 1]
                slope = -0.5 * r * root[k, 1] * root[k, 1]
                p1 = slope * ends[k, 2]
                p2 = slope * ends[k, 3]
                r += p1 * dc[k + 1] + p2 * dc[k + 2]
            turn = a0 * (c[k] + dc[k]) + a1 * (c[k + 1] + dc[k + 1]) + a2 * (c[k + 2] + dc[k + 2])
            w0 = rows[i, 4]
            w1 = rows[i, 5]
            y0 = rows[i, 6]
            y1 = rows[i, 7]
            u0 = 1.0 / (w0 * w1)
            z0 = w1 * u0
            z1 = w0 * u0
            dw = r - turn - w0
            primal = max(primal, -dw * z0)
            dual = max(dual, 1.0 + dw * z0)
            dy = -y0 * (dw * z0 + 1.0)
            sum0 += w0 * y0
            sum1 += dw * y0
            sum2 += w0 * dy
            dw *= dy
            sum3 += dw
            rows[i, 8] = dw
            u0 = -dw * z0
            if kind[i] > 0:
                dw = r + turn - w1
                primal = max(primal, -dw * z1)
                dual = max(dual, 1.0 + dw * z1)
                dy = -y1 * (dw * z1 + 1.0)
                sum0 += w1 * y1
                sum1 += dw * y1
                sum2 += w1 * dy
                dw *= dy
                sum3 += dw
                rows[i, 9] = dw
                u1 = -dw * z1
            else:
                u1 = z1 = 0.0
            u0, u1 = u0 + u1, u1 - u0
            z0, z1 = z0 + z1, z1 - z0
            g0 += u1 * a0 + u0 * p0
            g1 += u1 * a1 + u0 * p1
            g2 += u1 * a2 + u0 * p2
            h0 += z1 * a0 + z0 * p0
            h1 += z1 * a1 + z0 * p1
            h2 += z1 * a2 + z0 * p2
        second[k] += g0
        second[k + 1] += g1
        second[k + 2] += g2
        centre[k] += h0
        centre[k + 1] += h1
        centre[k + 2] += h2
    out[0] = primal
    out[1] = dual
    out[2] = sum0
    out[3] = sum1
    out[4] = sum2
    out[5] = sum3


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _correct(
    c: cython.double[::1],
    dc: cython.double[::1],
    ends: cython.double[:, ::1],
    root: cython.double[:, ::1],
    rows: cython.double[:, ::1],
    offset: cython.longlong[::1],
    kind: cython.char[::1],
    mu: cython.double,
    out: cython.double[::1],
) -> cython.void:
    """Fill the corrector's Δw and Δλ, and `out` with the reciprocals of the longest primal and dual step to the boundary."""
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t = ends.shape[0]
    r: cython.double
    slope: cython.double
    turn: cython.double
    w0: cython.double
    w1: cython.double
    dw: cython.double
    dy: cython.double
    inverse: cython.double
    primal: cython.double = 0.0
    dual: cython.double = 0.0
    for k in range(n):
        for i in range(offset[k], offset[k + 1]):
            r = rows[i, 3]
            if kind[i] == 2:
                r *= root[k, 0]
                slope = -0.5 * r * root[k, 0] * root[k, 0]
                r += slope * (ends[k, 0] * dc[k] + ends[k, 1] * dc[k + 1])
            elif kind[i] == 3:
                r *= root[k, 1]
                slope = -0.5 * r * root[k, 1] * root[k, 1]
                r += slope * (ends[k, 2] * dc[k + 1] + ends[k, 3] * dc[k + 2])
            turn = (
                rows[i, 0] * (c[k] + dc[k])
                + rows[i, 1] * (c[k + 1] + dc[k + 1])
                + rows[i, 2] * (c[k + 2] + dc[k + 2])
            )
            w0 = rows[i, 4]
            w1 = rows[i, 5]
            inverse = 1.0 / (w0 * w1)
            dw = r - turn - w0
            dy = (mu - rows[i, 8] - rows[i, 6] * dw) * w1 * inverse - rows[i, 6]
            rows[i, 8] = dw
            rows[i, 10] = dy
            primal = max(primal, -dw * w1 * inverse)
            if -dy > dual * rows[i, 6]:
                dual = -dy / rows[i, 6]
            if kind[i] == 0:
                rows[i, 9] = 0.0
                rows[i, 11] = 0.0
                continue
            dw = r + turn - w1
            dy = (mu - rows[i, 9] - rows[i, 7] * dw) * w0 * inverse - rows[i, 7]
            rows[i, 9] = dw
            rows[i, 11] = dy
            primal = max(primal, -dw * w0 * inverse)
            if -dy > dual * rows[i, 7]:
                dual = -dy / rows[i, 7]
    out[0] = primal
    out[1] = dual


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _positive(c: cython.double[::1], dc: cython.double[::1], ends: cython.double[:, ::1]) -> cython.double:
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


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _peak(value: cython.double[::1], first: cython.Py_ssize_t) -> cython.double:
    """Return the largest of five equidistant values' inner three, raised to the top of the parabola around it."""
    p: cython.Py_ssize_t = first + 1
    bend: cython.double
    slope: cython.double
    if value[first + 2] > value[p]:
        p = first + 2
    if value[first + 3] > value[p]:
        p = first + 3
    bend = 2.0 * value[p] - value[p - 1] - value[p + 1]
    slope = value[p + 1] - value[p - 1]
    if value[p - 1] < value[p] and value[p + 1] < value[p]:
        return value[p] + slope * slope / (8.0 * bend)
    return value[p]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _tighten(
    c: cython.double[::1],
    h: cython.double[::1],
    ends: cython.double[:, ::1],
    d1: cython.double[:, :, ::1],
    d2: cython.double[:, :, ::1],
    d3: cython.double[:, :, ::1],
    limits: cython.double[:, ::1],
    factor: cython.double[:, ::1],
    share: cython.double[:, :, ::1],
    slack: cython.double,
    eased: cython.Py_ssize_t,
    fresh: cython.bint,
    value: cython.double[::1],
) -> cython.double:
    """Lower the limits of intervals between whose ends acceleration or jerk of an axis passes its limit.

    Derivatives of the path are given at both ends and the middle of each interval, and taken as quadratics between.
    The largest values inside, estimated from three inner points, are compared with those at the ends, where the rows
    hold them. While the iterates are far from the optimum (`fresh`), ``share[k, 0]`` (acceleration) and ``share[k, 1]``
    (jerk) become the ratio of the largest value at the ends to the largest inside; later they are only lowered, where a
    limit is passed, and by half of `slack` more, lest the next iterate pass it again. The largest part of a limit that
    was found inside is returned, of the first `eased` intervals without their ease (see `_apply`). `value` has room for
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
        for a in range(axes):
            acc_end = max(value[10 * a], value[10 * a + 4])
            acc_in = _peak(value, 10 * a)
            jerk_end = max(value[10 * a + 5], value[10 * a + 9])
            jerk_in = _peak(value, 10 * a + 5)
            acc = acc_in / limits[0, a]
            jerk = jerk_in / (limits[1, a] * factor[k, a])
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


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _apply(
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


def solve(
    c: cython.double[::1],
    free: cython.Py_ssize_t,
    h: cython.double[::1],
    ends: cython.double[:, ::1],
    extra: cython.double[:, ::1],
    rows: cython.double[:, ::1],
    offset: cython.longlong[::1],
    kind: cython.char[::1],
    axis: cython.longlong[::1],
    d1: cython.double[:, :, ::1],
    d2: cython.double[:, :, ::1],
    d3: cython.double[:, :, ::1],
    limits: cython.double[:, ::1],
    factor: cython.double[:, ::1],
    share: cython.double[:, :, ::1],
    tolerance: cython.double,
    slack: cython.double,
    most: cython.int,
    report: cython.double[::1],
) -> int:
    """Improve `c` to the least time within the rows; `c`, `rows` and what describes them are changed in place.

    Args:
        c: Shape (n + 2,), positive: start on entry, result on exit.
        free: Index of the first unknown that may change (1, or 2 where the window starts in motion).
        h: Shape (n,), lengths of the intervals.
        ends: Shape (n, 4), see above.
        extra: Shape (n, 2), further weight of q^-1/2 at the left and right end.
        rows: Shape (room, `WIDTH`), constraints: those of interval k are ``offset[k]`` to ``offset[k + 1]`` − 1.
        offset: Shape (n + 1,).
        kind, axis: Shape (room,): kind of each row, and the axis that it bounds.
        d1, d2, d3: Shape (n, 3, axes), derivatives of the path at left end, middle and right end.
        limits: Shape (2, axes): acceleration, jerk.
        factor: Shape (n, axes): part of the jerk limit that the interval may use.
        share: Shape (n, 2, axes), ones: parts of acceleration and jerk limits at the ends that hold them between; updated.
        tolerance: Duality gap as a part of F at which to end.
        slack: Part by which a limit may be passed between the ends of an interval.
        most: Iterations at most.
        report: Shape (6,): F, gap, primal infeasibility, iterations, dual residual, worst ratio between the ends.

    Returns:
        0; 1 where it came near and then stalled (every limit held, dual residual a hundred times larger at most); or why
        it did not converge: −1 out of iterations, −2 the matrix lost its positive diagonal by rounding.
    """
    n: cython.Py_ssize_t = h.shape[0]
    import numpy

    grad: cython.double[::1] = numpy.zeros(n + 2)
    dual: cython.double[::1] = numpy.zeros(n + 2)
    right: cython.double[::1] = numpy.zeros(n + 2)
    centre: cython.double[::1] = numpy.zeros(n + 2)
    second: cython.double[::1] = numpy.zeros(n + 2)
    dc: cython.double[::1] = numpy.zeros(n + 2)
    band: cython.double[:, ::1] = numpy.zeros((n + 2, 3))
    root: cython.double[:, ::1] = numpy.zeros((n, 2))
    out: cython.double[::1] = numpy.zeros(6)
    value: cython.double[::1] = numpy.zeros(10 * d1.shape[2])
    iteration: cython.int = 0
    status: cython.int = -1
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    fresh: cython.bint
    ready: cython.bint
    sides: cython.Py_ssize_t = 0
    eased: cython.Py_ssize_t = _EASED if free > 1 else 0
    f: cython.double = 0.0
    mu: cython.double
    gap: cython.double = 0.0
    residual: cython.double = 0.0
    primal: cython.double = 0.0
    sigma: cython.double
    step: cython.double = 0.0
    rise: cython.double = 0.0
    ahead: cython.double
    kept: cython.double = 1e300
    near: cython.double[::1] = numpy.zeros(n + 2)
    with cython.nogil:
        _apply(rows, offset, kind, axis, share, slack, eased)
        for i in range(offset[n]):
            sides += 1 if kind[i] == 0 else 2
        for iteration in range(most):
            f = _objective(c, h, ends, extra, grad, band, root)
            # Far from the optimum the shares may lag by an iteration.
            if iteration > 2 and (gap < 0.012 * f or (gap < 0.3 * f and iteration % 2 == 0)):
                fresh = gap > 0.006 * f
                report[5] = _tighten(
                    c, h, ends, d1, d2, d3, limits, factor, share, slack, eased, fresh, value
                )
                if fresh or report[5] > 1.0 + slack:
                    _apply(rows, offset, kind, axis, share, slack, eased)
            mu = 3.0 * f / sides if iteration == 0 else 0.0
            _gather(c, ends, root, rows, offset, kind, step, rise, mu, grad, dual, right, band, out)
            primal = out[0]
            gap = out[1]
            residual = 0.0
            for k in range(free, n + 1):
                residual += fabs(dual[k] * c[k])
            ready = report[5] < 1.0 + slack and primal < slack
            if ready and gap < 2.0 * tolerance * f and residual < 10.0 * tolerance * f:
                status = 0
                break
            if ready and residual < 100.0 * tolerance * f and gap < kept:
                kept = gap
                near[:] = c
            elif kept < 1e300 and (gap > 3.0 * kept or step < 0.02):
                break
            if not _factor(band, free, n + 1):
                status = -2
                break
            _substitute(band, free, n + 1, right, dc)
            _predict(c, dc, ends, root, rows, offset, kind, centre, second, out)
            step = 1.0 / max(1.0, max(out[0], _positive(c, dc, ends) / 0.9))
            ahead = 1.0 / max(1.0, out[1])
            sigma = (out[2] + step * out[3] + ahead * out[4] + step * ahead * out[5]) / out[2]
            mu = max(sigma * sigma * sigma * out[2], tolerance * f) / sides
            for k in range(n + 2):
                right[k] += second[k] + mu * centre[k]
            _substitute(band, free, n + 1, right, dc)
            _correct(c, dc, ends, root, rows, offset, kind, mu, out)
            step = 1.0 / max(1.0, max(out[0] / 0.99, _positive(c, dc, ends) / 0.9))
            rise = 1.0 / max(1.0, out[1] / 0.99)
            for k in range(n + 2):
                c[k] += step * dc[k]
        if status < 0 and kept < 1e300:
            # Stalled beside the optimum: by rounding, or where a limit was lowered last.
            c[:] = near
            f = _objective(c, h, ends, extra, grad, band, root)
            gap = kept
            primal = 0.0
            status = 1
    report[0] = f
    report[1] = gap
    report[2] = primal
    report[3] = iteration
    report[4] = residual
    return status


def response(
    c: cython.double[::1],
    free: cython.Py_ssize_t,
    h: cython.double[::1],
    ends: cython.double[:, ::1],
    extra: cython.double[:, ::1],
    rows: cython.double[:, ::1],
    offset: cython.longlong[::1],
    kind: cython.char[::1],
    out: cython.double[::1],
) -> int:
    """Tell how the solution follows where its last unknown is pushed: the last column of the inverse Newton matrix.

    Args:
        c, free, h, ends, extra, rows, offset, kind: As `solve` has left them.
        out: Shape (n + 2,), zeros: becomes dc/dc[n], a change of q by the change of q at the end.

    Returns:
        0, or −2 where the matrix lost its positive diagonal by rounding.
    """
    n: cython.Py_ssize_t = h.shape[0]
    k: cython.Py_ssize_t
    end: cython.double
    positive: cython.bint
    import numpy

    grad: cython.double[::1] = numpy.zeros(n + 2)
    dual: cython.double[::1] = numpy.zeros(n + 2)
    right: cython.double[::1] = numpy.zeros(n + 2)
    band: cython.double[:, ::1] = numpy.zeros((n + 2, 3))
    root: cython.double[:, ::1] = numpy.zeros((n, 2))
    found: cython.double[::1] = numpy.zeros(6)
    with cython.nogil:
        _objective(c, h, ends, extra, grad, band, root)
        _gather(c, ends, root, rows, offset, kind, 0.0, 0.0, 0.0, grad, dual, right, band, found)
        positive = _factor(band, free, n + 1)
        if positive:
            for k in range(n + 2):
                right[k] = 0.0
            right[n] = 1.0
            _substitute(band, free, n + 1, right, out)
            end = out[n]
            for k in range(n + 2):
                out[k] /= end
    return 0 if positive else -2
