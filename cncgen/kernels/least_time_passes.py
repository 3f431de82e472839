"""The passes of an iteration of `cncgen.kernels.least_time` over the rows, which calls them as C (``least_time_passes.pxd``).

Rows, their columns and their kinds are described there, and which of them are awake. ∇r = p.

A slack's step is Δw = (r − A·c − w) + (p − A)·Δc. Written so, not as what the constraint will be less w, it has all its digits:
at the optimum w is 10⁻⁷ of r, and A·c the difference of numbers a million times as large, whose rounding would otherwise go
into w, through it into λ, and leave the dual residual at more than a hundredth of the time.
"""

import cython
from cython.cimports.libc.math import fabs

_REAL = cython.typedef(cython.double)
#: The limit of a row and its gradient.
_Limit = cython.struct(r=cython.double, p0=cython.double, p1=cython.double, p2=cython.double)

#: Slacks and multipliers of both sides of a row.
_Sides = cython.struct(w0=cython.double, w1=cython.double, y0=cython.double, y1=cython.double)

#: The part of its limit from which a row that is asleep wakes, and the least slack that it wakes with.
_NEAR = cython.declare(cython.double, 0.6)
_LEAST = cython.declare(cython.double, 0.05)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _limit(
    part: cython.double,
    kind: cython.char,
    ends: cython.double[:, ::1],
    root: cython.double[:, ::1],
    k: cython.Py_ssize_t,
) -> _Limit:
    """Return r and its gradient of a row of interval `k` that may use `part` of its limit: part b^-1/2 for a jerk."""
    slope: cython.double
    if kind == 2:
        part *= root[k, 0]
        slope = -0.5 * part * root[k, 0] * root[k, 0]
        return _Limit(part, slope * ends[k, 0], slope * ends[k, 1], 0.0)
    if kind == 3:
        part *= root[k, 1]
        slope = -0.5 * part * root[k, 1] * root[k, 1]
        return _Limit(part, 0.0, slope * ends[k, 2], slope * ends[k, 3])
    return _Limit(part, 0.0, 0.0, 0.0)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _moved(
    rows: cython.double[:, ::1],
    i: cython.Py_ssize_t,
    kind: cython.char,
    step: cython.double,
    rise: cython.double,
    mu: cython.double,
    r: cython.double,
    value: cython.double,
) -> _Sides:
    """Set slacks and multipliers of a row whose limit and value are given, as `gather` says, and return them."""
    w0: cython.double
    w1: cython.double
    y0: cython.double
    y1: cython.double
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
    if kind == 0:
        w1 = 1.0
        y1 = 0.0
    rows[i, 4] = w0
    rows[i, 5] = w1
    rows[i, 6] = y0
    rows[i, 7] = y1
    return _Sides(w0, w1, y0, y1)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def exchange(
    rows: cython.double[:, ::1],
    kind: cython.char[::1],
    axis: cython.longlong[::1],
    i: cython.Py_ssize_t,
    j: cython.Py_ssize_t,
) -> cython.void:
    """Let two rows change places."""
    m: cython.Py_ssize_t
    x: cython.double
    which: cython.char = kind[i]
    whose: cython.longlong = axis[i]
    for m in range(rows.shape[1]):
        x = rows[i, m]
        rows[i, m] = rows[j, m]
        rows[j, m] = x
    kind[i] = kind[j]
    kind[j] = which
    axis[i] = axis[j]
    axis[j] = whose


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _woken(
    c: cython.double[::1],
    rows: cython.double[:, ::1],
    kind: cython.char[::1],
    axis: cython.longlong[::1],
    k: cython.Py_ssize_t,
    first: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
    level: cython.double,
) -> cython.Py_ssize_t:
    """Wake the rows of interval `k` from `first` to `stop` − 1 that come near their limits; return where the others begin.

    Those asleep are bounds and accelerations, so r = f. They get the multipliers of a gap `level`.
    """
    i: cython.Py_ssize_t
    r: cython.double
    value: cython.double
    for i in range(first, stop):
        r = rows[i, 3]
        value = rows[i, 0] * c[k] + rows[i, 1] * c[k + 1] + rows[i, 2] * c[k + 2]
        if fabs(value) > _NEAR * r:
            rows[i, 4] = max(r - value, _LEAST * r)
            rows[i, 5] = max(r + value, _LEAST * r)
            rows[i, 6] = level / rows[i, 4]
            rows[i, 7] = level / rows[i, 5]
            rows[i, 8] = rows[i, 9] = rows[i, 10] = rows[i, 11] = 0.0
            exchange(rows, kind, axis, i, first)
            first += 1
    return first


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(
    limit=_Limit, sides=_Sides, c0=_REAL, c1=_REAL, c2=_REAL, a0=_REAL, a1=_REAL, a2=_REAL, p0=_REAL, p1=_REAL,
    p2=_REAL, m00=_REAL, m01=_REAL, m02=_REAL, m11=_REAL, m12=_REAL, m22=_REAL, d0=_REAL, d1=_REAL,
    d2=_REAL, r0=_REAL, r1=_REAL, r2=_REAL, value=_REAL, r=_REAL, w0=_REAL, w1=_REAL, y0=_REAL, y1=_REAL,
    s0=_REAL, s1=_REAL, t0=_REAL, t1=_REAL, inverse=_REAL, more=_REAL, less=_REAL,
)  # fmt: skip
def gather(
    c: cython.double[::1],
    ends: cython.double[:, ::1],
    root: cython.double[:, ::1],
    rows: cython.double[:, ::1],
    offset: cython.longlong[::1],
    awake: cython.longlong[::1],
    kind: cython.char[::1],
    axis: cython.longlong[::1],
    level: cython.double,
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
    the largest −g / r, how far a constraint is broken as a part of its limit, ``out[1]`` the gap Σ λ w, and ``out[2]``
    the number of one-sided constraints that are awake. A row that comes near its limit wakes with λ w = `level`.
    With ∇r = p, the gradients of a row's two constraints are p ∓ A.
    """
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t = ends.shape[0]
    worst: cython.double = 0.0
    gap: cython.double = 0.0
    count: cython.Py_ssize_t = 0
    for k in range(n + 2):
        right[k] = -grad[k]
        dual[k] = grad[k]
    for k in range(n):
        c0 = c[k]
        c1 = c[k + 1]
        c2 = c[k + 2]
        m00 = m01 = m02 = m11 = m12 = m22 = 0.0
        d0 = d1 = d2 = r0 = r1 = r2 = 0.0
        if awake[k] < offset[k + 1]:
            awake[k] = _woken(c, rows, kind, axis, k, awake[k], offset[k + 1], level)
        for i in range(offset[k], awake[k]):
            a0 = rows[i, 0]
            a1 = rows[i, 1]
            a2 = rows[i, 2]
            limit = _limit(rows[i, 3], kind[i], ends, root, k)
            r = limit.r
            p0 = limit.p0
            p1 = limit.p1
            p2 = limit.p2
            value = a0 * c0 + a1 * c1 + a2 * c2
            sides = _moved(rows, i, kind[i], step, rise, mu, r, value)
            w0 = sides.w0
            w1 = sides.w1
            y0 = sides.y0
            y1 = sides.y1
            count += 1 if kind[i] == 0 else 2
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
    out[2] = count


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(
    limit=_Limit, a0=_REAL, a1=_REAL, a2=_REAL, p0=_REAL, p1=_REAL, p2=_REAL, r=_REAL, value=_REAL, rise=_REAL,
    turn=_REAL, w0=_REAL, w1=_REAL, y0=_REAL, y1=_REAL, dw=_REAL, dy=_REAL, z0=_REAL, z1=_REAL, u0=_REAL, u1=_REAL,
    g0=_REAL, g1=_REAL, g2=_REAL, h0=_REAL, h1=_REAL, h2=_REAL,
)  # fmt: skip
def predict(
    c: cython.double[::1],
    dc: cython.double[::1],
    ends: cython.double[:, ::1],
    root: cython.double[:, ::1],
    rows: cython.double[:, ::1],
    offset: cython.longlong[::1],
    awake: cython.longlong[::1],
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
        for i in range(offset[k], awake[k]):
            a0 = rows[i, 0]
            a1 = rows[i, 1]
            a2 = rows[i, 2]
            limit = _limit(rows[i, 3], kind[i], ends, root, k)
            p0 = limit.p0
            p1 = limit.p1
            p2 = limit.p2
            r = limit.r
            value = a0 * c[k] + a1 * c[k + 1] + a2 * c[k + 2]
            rise = p0 * dc[k] + p1 * dc[k + 1] + p2 * dc[k + 2]
            turn = a0 * dc[k] + a1 * dc[k + 1] + a2 * dc[k + 2]
            w0 = rows[i, 4]
            w1 = rows[i, 5]
            y0 = rows[i, 6]
            y1 = rows[i, 7]
            u0 = 1.0 / (w0 * w1)
            z0 = w1 * u0
            z1 = w0 * u0
            dw = (r - value - w0) + (rise - turn)
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
                dw = (r + value - w1) + (rise + turn)
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


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def correct(
    c: cython.double[::1],
    dc: cython.double[::1],
    ends: cython.double[:, ::1],
    root: cython.double[:, ::1],
    rows: cython.double[:, ::1],
    offset: cython.longlong[::1],
    awake: cython.longlong[::1],
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
    rise: cython.double
    value: cython.double
    turn: cython.double
    w0: cython.double
    w1: cython.double
    dw: cython.double
    dy: cython.double
    inverse: cython.double
    primal: cython.double = 0.0
    dual: cython.double = 0.0
    for k in range(n):
        for i in range(offset[k], awake[k]):
            r = rows[i, 3]
            rise = 0.0
            if kind[i] == 2:
                r *= root[k, 0]
                slope = -0.5 * r * root[k, 0] * root[k, 0]
                rise = slope * (ends[k, 0] * dc[k] + ends[k, 1] * dc[k + 1])
            elif kind[i] == 3:
                r *= root[k, 1]
                slope = -0.5 * r * root[k, 1] * root[k, 1]
                rise = slope * (ends[k, 2] * dc[k + 1] + ends[k, 3] * dc[k + 2])
            value = rows[i, 0] * c[k] + rows[i, 1] * c[k + 1] + rows[i, 2] * c[k + 2]
            turn = rows[i, 0] * dc[k] + rows[i, 1] * dc[k + 1] + rows[i, 2] * dc[k + 2]
            w0 = rows[i, 4]
            w1 = rows[i, 5]
            inverse = 1.0 / (w0 * w1)
            dw = (r - value - w0) + (rise - turn)
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
            dw = (r + value - w1) + (rise + turn)
            dy = (mu - rows[i, 9] - rows[i, 7] * dw) * w0 * inverse - rows[i, 7]
            rows[i, 9] = dw
            rows[i, 11] = dy
            primal = max(primal, -dw * w0 * inverse)
            if -dy > dual * rows[i, 7]:
                dual = -dy / rows[i, 7]
    out[0] = primal
    out[1] = dual
