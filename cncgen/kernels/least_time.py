"""Primal-dual interior-point method for the least time along a path (docs/least-time.md).

Unknown is q(s) = v² as a quadratic spline, by its Bézier middle ordinates: ``c[k + 1]`` belongs to interval `k`, and the
ordinates at the interval's ends are ``b0 = ends[k,0] c[k] + ends[k,1] c[k+1]`` and ``b2 = ends[k,2] c[k+1] +
ends[k,3] c[k+2]``. ``c[0]`` and ``c[n+1]`` are given; so is ``c[1]`` where the window starts in motion. Minimised is

    F = Σ h/6 (b0^-1/2 + 4 m^-1/2 + b2^-1/2) + Σ extra0 b0^-1/2 + Σ extra2 b2^-1/2,   m = (b0 + 2 c + b2) / 4,

subject to rows r(q) ± A·(c[k], c[k+1], c[k+2]) ≥ 0 that each touch three neighbours. Hence the Newton matrix has five
diagonals, and an iteration is linear in the number of intervals.

A row of `rows` is (A0, A1, A2, r, w+, w−, λ+, λ−, Δw+, Δw−, Δλ+, Δλ−, g+, g−, r′, Q0, Q1, Q2, f): `w` slacks, `λ`
multipliers, `g` the values of the two constraints. `kind` of a row: 0 one-sided with r = f, 1 two-sided with r = f, 2
two-sided with r = f q^-1/2 where q = Q·(c[k], c[k+1], c[k+2]).

The function r is convex, so its tangent lies below it: a step along which the linearised constraint holds keeps the
constraint itself (Hunter and Lange, *A tutorial on MM algorithms*, 2004), and slacks may be reset to g wherever g is
larger. Steps follow Mehrotra (*SIAM J. Optim.* 2, 1992).
"""

import cython
from cython.cimports.libc.math import fabs, sqrt

#: Columns of `rows`.
WIDTH = 19


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
) -> cython.double:
    """Return F; fill its gradient and the three upper diagonals of its Hessian in ``band[:, :3]``."""
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
        q1 = 0.25 * (q0 + q2) + 0.5 * c[k + 1]
        f0 = (h[k] / 6.0 + extra[k, 0]) / sqrt(q0)
        f2 = (h[k] / 6.0 + extra[k, 1]) / sqrt(q2)
        f1 = h[k] / 1.5 / sqrt(q1)
        total += f0 + f1 + f2
        m0 = 0.25 * e0
        m1 = 0.25 * (e1 + e2) + 0.5
        m2 = 0.25 * e3
        f0 = -0.5 * f0 / q0
        f1 = -0.5 * f1 / q1
        f2 = -0.5 * f2 / q2
        grad[k] += f0 * e0 + f1 * m0
        grad[k + 1] += f0 * e1 + f1 * m1 + f2 * e2
        grad[k + 2] += f1 * m2 + f2 * e3
        f0 = -1.5 * f0 / q0
        f1 = -1.5 * f1 / q1
        f2 = -1.5 * f2 / q2
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
def _evaluate(
    c: cython.double[::1],
    rows: cython.double[:, ::1],
    m: cython.Py_ssize_t,
    place: cython.longlong[::1],
    kind: cython.char[::1],
    first: cython.bint,
    floor: cython.double,
    infeasible: cython.double[::1],
) -> cython.void:
    """Fill r, r′ and g of every row, and raise slacks to g where g is larger; `first` sets them up.

    ``infeasible[0]`` becomes the largest (w − g) / r: how far a constraint is broken, as a part of its limit.
    """
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    value: cython.double
    q: cython.double
    r: cython.double
    slope: cython.double
    worst: cython.double = 0.0
    for i in range(m):
        k = place[i]
        value = rows[i, 0] * c[k] + rows[i, 1] * c[k + 1] + rows[i, 2] * c[k + 2]
        r = rows[i, 18]
        slope = 0.0
        if kind[i] == 2:
            q = rows[i, 15] * c[k] + rows[i, 16] * c[k + 1] + rows[i, 17] * c[k + 2]
            r /= sqrt(q)
            slope = -0.5 * r / q
        rows[i, 12] = r - value
        rows[i, 13] = r + value
        rows[i, 14] = slope
        rows[i, 3] = r
        if first:
            rows[i, 4] = max(rows[i, 12], floor * r)
            rows[i, 5] = max(rows[i, 13], floor * r)
        else:
            rows[i, 4] = max(rows[i, 4], rows[i, 12])
            rows[i, 5] = max(rows[i, 5], rows[i, 13])
        worst = max(worst, (rows[i, 4] - rows[i, 12]) / r)
        if kind[i] > 0:
            worst = max(worst, (rows[i, 5] - rows[i, 13]) / r)
    infeasible[0] = worst


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _gather(
    rows: cython.double[:, ::1],
    m: cython.Py_ssize_t,
    place: cython.longlong[::1],
    kind: cython.char[::1],
    mu: cython.double,
    corrector: cython.bint,
    grad: cython.double[::1],
    dual: cython.double[::1],
    right: cython.double[::1],
    band: cython.double[:, ::1],
) -> cython.void:
    """Add the rows' share to the Newton matrix and fill its right side.

    Predictor: matrix and the dual residual ∇F − Σ λ ∇g too. Corrector: the right side alone, for the centring `mu` and
    with the second-order term Δw Δλ of the predictor.
    """
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t = grad.shape[0]
    s: cython.double
    y: cython.double
    p0: cython.double
    p1: cython.double
    p2: cython.double
    g0: cython.double
    g1: cython.double
    g2: cython.double
    for k in range(n):
        right[k] = -grad[k]
        if not corrector:
            dual[k] = grad[k]
    for i in range(m):
        k = place[i]
        p0 = p1 = p2 = 0.0
        if kind[i] == 2:
            p0 = rows[i, 14] * rows[i, 15]
            p1 = rows[i, 14] * rows[i, 16]
            p2 = rows[i, 14] * rows[i, 17]
        g0 = p0 - rows[i, 0]
        g1 = p1 - rows[i, 1]
        g2 = p2 - rows[i, 2]
        s = rows[i, 6] / rows[i, 4]
        y = -s * (rows[i, 12] - rows[i, 4])
        if corrector:
            y += (mu - rows[i, 8] * rows[i, 10]) / rows[i, 4]
        else:
            band[k, 0] += s * g0 * g0
            band[k, 1] += s * g0 * g1
            band[k, 2] += s * g0 * g2
            band[k + 1, 0] += s * g1 * g1
            band[k + 1, 1] += s * g1 * g2
            band[k + 2, 0] += s * g2 * g2
            dual[k] -= rows[i, 6] * g0
            dual[k + 1] -= rows[i, 6] * g1
            dual[k + 2] -= rows[i, 6] * g2
        right[k] += y * g0
        right[k + 1] += y * g1
        right[k + 2] += y * g2
        if kind[i] == 0:
            continue
        g0 = p0 + rows[i, 0]
        g1 = p1 + rows[i, 1]
        g2 = p2 + rows[i, 2]
        s = rows[i, 7] / rows[i, 5]
        y = -s * (rows[i, 13] - rows[i, 5])
        if corrector:
            y += (mu - rows[i, 9] * rows[i, 11]) / rows[i, 5]
        else:
            band[k, 0] += s * g0 * g0
            band[k, 1] += s * g0 * g1
            band[k, 2] += s * g0 * g2
            band[k + 1, 0] += s * g1 * g1
            band[k + 1, 1] += s * g1 * g2
            band[k + 2, 0] += s * g2 * g2
            dual[k] -= rows[i, 7] * g0
            dual[k + 1] -= rows[i, 7] * g1
            dual[k + 2] -= rows[i, 7] * g2
        right[k] += y * g0
        right[k + 1] += y * g1
        right[k + 2] += y * g2


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
def _directions(
    dc: cython.double[::1],
    rows: cython.double[:, ::1],
    m: cython.Py_ssize_t,
    place: cython.longlong[::1],
    kind: cython.char[::1],
    mu: cython.double,
    corrector: cython.bint,
    out: cython.double[::1],
) -> cython.void:
    """Fill Δw, Δλ of every row; `out` becomes the reciprocals of the longest primal and dual step to the boundary, then
    the sums of w λ, Δw λ, w Δλ and Δw Δλ."""
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    side: cython.Py_ssize_t
    base: cython.double
    bend: cython.double
    w: cython.double
    y: cython.double
    dw: cython.double
    dy: cython.double
    primal: cython.double = 0.0
    dual: cython.double = 0.0
    s0: cython.double = 0.0
    s1: cython.double = 0.0
    s2: cython.double = 0.0
    s3: cython.double = 0.0
    for i in range(m):
        k = place[i]
        base = rows[i, 0] * dc[k] + rows[i, 1] * dc[k + 1] + rows[i, 2] * dc[k + 2]
        bend = 0.0
        if kind[i] == 2:
            bend = rows[i, 14] * (rows[i, 15] * dc[k] + rows[i, 16] * dc[k + 1] + rows[i, 17] * dc[k + 2])
        for side in range(1 if kind[i] == 0 else 2):
            w = rows[i, 4 + side]
            y = rows[i, 6 + side]
            dw = rows[i, 12 + side] - w + bend + (base if side else -base)
            dy = -y * dw
            if corrector:
                dy += mu - rows[i, 8 + side] * rows[i, 10 + side]
            dy = dy / w - y
            rows[i, 8 + side] = dw
            rows[i, 10 + side] = dy
            if -dw > primal * w:
                primal = -dw / w
            if -dy > dual * y:
                dual = -dy / y
            s0 += w * y
            s1 += dw * y
            s2 += w * dy
            s3 += dw * dy
    out[0] = primal
    out[1] = dual
    out[2] = s0
    out[3] = s1
    out[4] = s2
    out[5] = s3


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
def _move(
    c: cython.double[::1],
    dc: cython.double[::1],
    rows: cython.double[:, ::1],
    m: cython.Py_ssize_t,
    kind: cython.char[::1],
    primal: cython.double,
    dual: cython.double,
) -> cython.void:
    """Step by `primal` in c and w, by `dual` in λ."""
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    for k in range(c.shape[0]):
        c[k] += primal * dc[k]
    for i in range(m):
        rows[i, 4] += primal * rows[i, 8]
        rows[i, 6] += dual * rows[i, 10]
        if kind[i] > 0:
            rows[i, 5] += primal * rows[i, 9]
            rows[i, 7] += dual * rows[i, 11]


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
    fresh: cython.bint,
    value: cython.double[::1],
) -> cython.double:
    """Lower the limits of intervals between whose ends acceleration or jerk of an axis passes its limit.

    Derivatives of the path are given at both ends and the middle of each interval, and taken as quadratics between.
    The largest values inside, estimated from three inner points, are compared with those at the ends, where the rows hold them. While the iterates
    are far from the optimum (`fresh`), ``share[k, 0]`` (acceleration) and ``share[k, 1]`` (jerk) become the ratio of
    the largest value at the ends to the largest inside; later they are only lowered, where a limit is passed. The
    largest part of a limit that was found inside is returned.
    """
    n: cython.Py_ssize_t = h.shape[0]
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
    worst: cython.double = 0.0
    if fresh:
        for k in range(n):
            for a in range(d1.shape[2]):
                share[k, 0, a] = 1.0
                share[k, 1, a] = 1.0
    for k in range(n):
        b0 = ends[k, 0] * c[k] + ends[k, 1] * c[k + 1]
        b2 = ends[k, 2] * c[k + 1] + ends[k, 3] * c[k + 2]
        ddq = 2.0 * (b0 - 2.0 * c[k + 1] + b2) / (h[k] * h[k])
        for a in range(d1.shape[2]):
            for p in range(5):
                x = 0.25 * p
                u = 1.0 - x
                l0 = u * (u - x)
                l1 = 4.0 * u * x
                l2 = x * (x - u)
                q = b0 * u * u + 2.0 * c[k + 1] * u * x + b2 * x * x
                dq = 2.0 * ((c[k + 1] - b0) * u + (b2 - c[k + 1]) * x) / h[k]
                e1 = l0 * d1[k, 0, a] + l1 * d1[k, 1, a] + l2 * d1[k, 2, a]
                e2 = l0 * d2[k, 0, a] + l1 * d2[k, 1, a] + l2 * d2[k, 2, a]
                e3 = l0 * d3[k, 0, a] + l1 * d3[k, 1, a] + l2 * d3[k, 2, a]
                value[p] = fabs(e2 * q + 0.5 * e1 * dq)
                value[5 + p] = fabs(e3 * q + 1.5 * e2 * dq + 0.5 * e1 * ddq) * sqrt(q)
            acc_end = max(value[0], value[4])
            acc_in = _peak(value, 0)
            jerk_end = max(value[5], value[9])
            jerk_in = _peak(value, 5)
            acc = acc_in / limits[0, a]
            jerk = jerk_in / (limits[1, a] * factor[k, a])
            worst = max(worst, max(acc, jerk))
            if acc > (0.9 if fresh else 1.0 + slack) and acc_in > acc_end:
                bulge = acc_end / acc_in
                share[k, 0, a] = min(share[k, 0, a], bulge)
                if k + 1 < n:
                    share[k + 1, 0, a] = min(share[k + 1, 0, a], bulge)
            if jerk > (0.9 if fresh else 1.0 + slack) and jerk_in > jerk_end:
                share[k, 1, a] = min(share[k, 1, a], jerk_end / jerk_in)
    return worst


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _apply(
    rows: cython.double[:, ::1],
    m: cython.Py_ssize_t,
    place: cython.longlong[::1],
    kind: cython.char[::1],
    axis: cython.longlong[::1],
    share: cython.double[:, :, ::1],
) -> cython.void:
    """Set the part f of the limits that each row may use."""
    i: cython.Py_ssize_t
    for i in range(m):
        if kind[i] > 0:
            rows[i, 18] = share[place[i], kind[i] - 1, axis[i]]
        else:
            rows[i, 18] = 1.0


def solve(
    c: cython.double[::1],
    free: cython.Py_ssize_t,
    h: cython.double[::1],
    ends: cython.double[:, ::1],
    extra: cython.double[:, ::1],
    rows: cython.double[:, ::1],
    m: cython.Py_ssize_t,
    place: cython.longlong[::1],
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
        rows: Shape (room, `WIDTH`), constraints; those beyond `m` are room for more.
        m: Number of rows that are there.
        place, kind: Shape (room,): interval and kind of each row.
        d1, d2, d3: Shape (n, 3, axes), derivatives of the path at left end, middle and right end.
        limits: Shape (2, axes): acceleration, jerk.
        factor: Shape (n, axes): part of the jerk limit that the interval may use.
        tolerance: Duality gap as a part of F at which to end.
        slack: Part by which a limit may be passed between the ends of an interval.
        most: Iterations at most.
        report: Shape (6,): F, gap, primal infeasibility, iterations, dual residual, worst ratio between the ends.

    Returns:
        Number of rows at the end (those at inner points are appended), negative where the method did not converge: −1
        out of iterations, −2 the matrix lost its positive diagonal by rounding.
    """
    n: cython.Py_ssize_t = h.shape[0]
    import numpy

    grad: cython.double[::1] = numpy.zeros(n + 2)
    dual: cython.double[::1] = numpy.zeros(n + 2)
    right: cython.double[::1] = numpy.zeros(n + 2)
    dc: cython.double[::1] = numpy.zeros(n + 2)
    band: cython.double[:, ::1] = numpy.zeros((n + 2, 3))
    out: cython.double[::1] = numpy.zeros(6)
    value: cython.double[::1] = numpy.zeros(10)
    iteration: cython.int = 0
    status: cython.Py_ssize_t = -1
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    fresh: cython.bint
    sides: cython.Py_ssize_t = 0
    f: cython.double = 0.0
    mu: cython.double
    gap: cython.double
    residual: cython.double = 0.0
    primal: cython.double = 0.0
    sigma: cython.double
    step: cython.double
    ahead: cython.double
    with cython.nogil:
        _apply(rows, m, place, kind, axis, share)
        _evaluate(c, rows, m, place, kind, True, 1.0, out)
        f = _objective(c, h, ends, extra, grad, band)
        for i in range(m):
            sides += 1 if kind[i] == 0 else 2
        mu = f / sides
        gap = f
        for i in range(m):
            rows[i, 6] = mu / rows[i, 4]
            rows[i, 7] = mu / rows[i, 5]
        for iteration in range(most):
            f = _objective(c, h, ends, extra, grad, band)
            if iteration > 2 and gap < 0.3 * f:
                fresh = gap > 0.006 * f
                report[5] = _tighten(c, h, ends, d1, d2, d3, limits, factor, share, slack, fresh, value)
                if fresh or report[5] > 1.0 + slack:
                    _apply(rows, m, place, kind, axis, share)
            _evaluate(c, rows, m, place, kind, False, 0.0, out)
            primal = out[0]
            _gather(rows, m, place, kind, 0.0, False, grad, dual, right, band)
            gap = 0.0
            for i in range(m):
                gap += rows[i, 4] * rows[i, 6]
                if kind[i] > 0:
                    gap += rows[i, 5] * rows[i, 7]
            residual = 0.0
            for k in range(free, n + 1):
                residual += fabs(dual[k] * c[k])
            if (
                gap < 2.0 * tolerance * f
                and residual < 10.0 * tolerance * f
                and report[5] < 1.0 + slack
                and primal < slack
            ):
                status = m
                break
            if not _factor(band, free, n + 1):
                status = -2
                break
            _substitute(band, free, n + 1, right, dc)
            _directions(dc, rows, m, place, kind, 0.0, False, out)
            step = 1.0 / max(1.0, max(out[0], _positive(c, dc, ends) / 0.9))
            ahead = 1.0 / max(1.0, out[1])
            sigma = (out[2] + step * out[3] + ahead * out[4] + step * ahead * out[5]) / out[2]
            mu = max(sigma * sigma * sigma * out[2], tolerance * f) / sides
            _gather(rows, m, place, kind, mu, True, grad, dual, right, band)
            _substitute(band, free, n + 1, right, dc)
            _directions(dc, rows, m, place, kind, mu, True, out)
            step = 1.0 / max(1.0, max(out[0] / 0.99, _positive(c, dc, ends) / 0.9))
            ahead = 1.0 / max(1.0, out[1] / 0.99)
            step = ahead = min(step, ahead)
            _move(c, dc, rows, m, kind, step, ahead)
    report[0] = f
    report[1] = gap
    report[2] = primal
    report[3] = iteration
    report[4] = residual
    return status
