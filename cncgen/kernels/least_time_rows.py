"""Constraints of the least-time problem as rows over three neighbouring unknowns (docs/least-time.md).

On an interval with Bézier ordinates b0, b1, b2 of q = v² and length h,

    q′(left) = 2 (b1 − b0) / h,   q′(right) = 2 (b2 − b1) / h,   q″ = 2 (b0 − 2 b1 + b2) / h²,

acceleration of an axis is x″ q + x′ q′/2 and its jerk (x‴ q + 3/2 x″ q′ + x′ q″/2) q^1/2. Each is a combination p0 b0 +
p1 b1 + p2 b2, hence one of the unknowns c[k], c[k+1], c[k+2] of `cncgen.kernels.least_time`.
"""

import cython
from cython.cimports.libc.math import cbrt, fabs, sqrt

if cython.compiled:
    from cython.cimports.cncgen.kernels.least_time_passes import exchange
else:
    from cncgen.kernels.least_time_passes import exchange

#: Parts by which numbers that are alike differ by rounding, and below which one beside another is rounding alone.
_ALIKE = cython.declare(cython.double, 1e-9)
_NOTHING = cython.declare(cython.double, 1e-13)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _put(
    rows: cython.double[:, ::1],
    i: cython.Py_ssize_t,
    ends: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    p0: cython.double,
    p1: cython.double,
    p2: cython.double,
    limit: cython.double,
) -> cython.void:
    """Write the row (p0 b0 + p1 b1 + p2 b2) / limit of interval `k`."""
    rows[i, 0] = p0 / limit * ends[k, 0]
    rows[i, 1] = (p0 * ends[k, 1] + p1 + p2 * ends[k, 2]) / limit
    rows[i, 2] = p2 / limit * ends[k, 3]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _moves(
    d: cython.double[:, :, ::1], k: cython.Py_ssize_t, a: cython.Py_ssize_t, rounding: cython.double
) -> cython.int:
    """Tell whether a derivative in interval `k` is there for axis `a` (2), for others alone (1), or for none (0).

    What is below `rounding` is none.
    """
    b: cython.Py_ssize_t
    e: cython.Py_ssize_t
    mine: cython.double = 0.0
    most: cython.double = 0.0
    for e in range(3):
        mine = max(mine, fabs(d[k, e, a]))
        for b in range(d.shape[2]):
            most = max(most, fabs(d[k, e, b]))
    if mine > max(_NOTHING * most, rounding):
        return 2
    return 1 if most > rounding else 0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _idle(
    h: cython.double,
    d1: cython.double[:, :, ::1],
    d2: cython.double[:, :, ::1],
    d3: cython.double[:, :, ::1],
    limits: cython.double[:, ::1],
    factor: cython.double[:, :, ::1],
    k: cython.Py_ssize_t,
    a: cython.Py_ssize_t,
) -> cython.bint:
    """Tell whether axis `a` can never bind in interval `k`: it stands, or on a straight interval another binds first.

    A derivative that changes the direction by rounding over the length `h` of the interval is none. What differs by less than `_ALIKE` is alike, lest rounding say how many rows a problem has.
    """
    b: cython.Py_ssize_t
    size: cython.double = 0.0
    bend: cython.int
    twist: cython.int
    acc: cython.double
    jerk: cython.double
    for b in range(d1.shape[2]):
        size = max(size, fabs(d1[k, 1, b]))
    bend = _moves(d2, k, a, _NOTHING * size / h)
    twist = _moves(d3, k, a, _NOTHING * size / (h * h))
    if _moves(d1, k, a, 0.0) < 2 and bend < 2 and twist < 2:
        return True
    if bend > 0 or twist > 0:
        return False
    for b in range(d1.shape[2]):
        if b == a:
            continue
        # The part of its limits that b takes, by the part that a takes of its own.
        acc = fabs(d1[k, 0, b]) * limits[0, a] * factor[k, 0, a]
        acc /= fabs(d1[k, 0, a]) * limits[0, b] * factor[k, 0, b]
        jerk = limits[1, a] * factor[k, 1, a] / (fabs(d1[k, 0, a]) * limits[1, b] * factor[k, 1, b])
        jerk *= fabs(d1[k, 0, b])
        if min(acc, jerk) > 1.0 - _ALIKE and (b < a or max(acc, jerk) > 1.0 + _ALIKE):
            return True
    return False


def build(
    h: cython.double[::1],
    ends: cython.double[:, ::1],
    d1: cython.double[:, :, ::1],
    d2: cython.double[:, :, ::1],
    d3: cython.double[:, :, ::1],
    limits: cython.double[:, ::1],
    factor: cython.double[:, :, ::1],
    box: cython.double[:, ::1],
    sway: cython.double[:, ::1],
    joint: cython.char[::1],
    given: cython.bint,
    rows: cython.double[:, ::1],
    offset: cython.longlong[::1],
    kind: cython.char[::1],
    axis: cython.longlong[::1],
) -> int:
    """Fill the rows of a window and return how many there are.

    Args:
        h, ends: Lengths, and end ordinates by unknowns, of the `n` intervals.
        d1, d2, d3: Shape (n, 3, axes), derivatives of the path at left end, middle and right end.
        limits: Shape (2, axes): acceleration, jerk.
        factor: Shape (n, 2, axes): parts of acceleration and jerk limits that the interval may use.
        box: Shape (n, 3): largest q at the left end, for the middle ordinate, and at the right end (infinite: none).
        sway: Shape (n, 2): largest |q′|/2 at the left and at the right end (infinite: none).
        joint: Shape (n,): 1 where acceleration must be held at the right end too (the next interval does not start
            with the same derivatives).
        given: Whether the state at the left end of the first interval is given (its rows there are left out).
        rows, offset, kind, axis: As `cncgen.kernels.least_time.solve` takes them, with room for n (5 + 4 axes) rows.
    """
    n: cython.Py_ssize_t = h.shape[0]
    i: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t
    a: cython.Py_ssize_t
    e: cython.Py_ssize_t
    g: cython.double
    x1: cython.double
    x2: cython.double
    x3: cython.double
    jerk: cython.double
    acceleration: cython.double
    with cython.nogil:
        offset[0] = 0
        for k in range(n):
            g = 1.0 / h[k]
            for e in range(3):
                if box[k, e] < 1e300 and not (given and k == 0 and e < 2):
                    _put(rows, i, ends, k, e == 0, e == 1, e == 2, box[k, e])
                    kind[i] = 0
                    axis[i] = -1
                    i += 1
            for e in range(2):
                if sway[k, e] < 1e300 and not (given and k == 0 and e == 0):
                    _put(rows, i, ends, k, (e - 1) * g, (1 - 2 * e) * g, e * g, sway[k, e])
                    kind[i] = 1
                    axis[i] = 0
                    i += 1
            for a in range(d1.shape[2]):
                if _idle(h[k], d1, d2, d3, limits, factor, k, a):
                    continue
                jerk = limits[1, a] * factor[k, 1, a]
                acceleration = limits[0, a] * factor[k, 0, a]
                for e in range(0, 3, 2):
                    x1 = d1[k, e, a] * g
                    x2 = d2[k, e, a]
                    x3 = d3[k, e, a]
                    if e == 0:
                        if not (given and k == 0):
                            _put(rows, i, ends, k, x2 - x1, x1, 0.0, acceleration)
                            kind[i] = 1
                            axis[i] = a
                            i += 1
                        x1 *= g
                        x2 *= 3.0 * g
                        _put(rows, i, ends, k, x3 - x2 + x1, x2 - 2.0 * x1, x1, jerk)
                        kind[i] = 2
                    else:
                        if joint[k]:
                            _put(rows, i, ends, k, 0.0, -x1, x2 + x1, acceleration)
                            kind[i] = 1
                            axis[i] = a
                            i += 1
                        x1 *= g
                        x2 *= 3.0 * g
                        _put(rows, i, ends, k, x1, -x2 - 2.0 * x1, x3 + x2 + x1, jerk)
                        kind[i] = 3
                    axis[i] = a
                    i += 1
            offset[k + 1] = i
    return i


def thin(
    c: cython.double[::1],
    ends: cython.double[:, ::1],
    rows: cython.double[:, ::1],
    offset: cython.longlong[::1],
    awake: cython.longlong[::1],
    kind: cython.char[::1],
    axis: cython.longlong[::1],
    reach: cython.Py_ssize_t,
    far: cython.double,
    peak: cython.double[:, ::1],
) -> cython.void:
    """Let the bounds and accelerations sleep that a profile stays far from.

    Those of intervals beside a rest stay awake.

    Args:
        c: Shape (n + 2,), the profile.
        ends, rows, offset, kind, axis: As `build` has left them; changed in place.
        awake: Shape (n,): becomes where the rows of each interval begin that sleep, the others being put before them.
        reach: A row stays awake where the profile comes near its limit within so many intervals.
        far: The part of a limit from which it is near.
        peak: Shape (n, axes + 1), zeros: room for the part that is used of each axis's acceleration, and of bounds.
    """
    n: cython.Py_ssize_t = peak.shape[0]
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    m: cython.Py_ssize_t
    a: cython.Py_ssize_t
    stop: cython.Py_ssize_t
    near: cython.double
    with cython.nogil:
        for k in range(n):
            for i in range(offset[k], offset[k + 1]):
                if kind[i] < 2:
                    a = axis[i] if kind[i] == 1 else peak.shape[1] - 1
                    near = fabs(rows[i, 0] * c[k] + rows[i, 1] * c[k + 1] + rows[i, 2] * c[k + 2])
                    peak[k, a] = max(peak[k, a], near)
        for k in range(n):
            stop = offset[k + 1]
            i = offset[k]
            while i < stop:
                near = far
                if kind[i] < 2 and ends[k, 0] != 0.0 and ends[k, 3] != 0.0:
                    a = axis[i] if kind[i] == 1 else peak.shape[1] - 1
                    near = 0.0
                    for m in range(max(k - reach, 0), min(k + reach + 1, n)):
                        near = max(near, peak[m, a])
                if near < far:
                    stop -= 1
                    exchange(rows, kind, axis, i, stop)
                else:
                    i += 1
            awake[k] = stop


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _ceiling(
    d2: cython.double[:, :, ::1],
    d3: cython.double[:, :, ::1],
    limits: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    e: cython.Py_ssize_t,
    q: cython.double,
) -> cython.double:
    """Return q, lowered to what steady motion allows at an end of an interval."""
    a: cython.Py_ssize_t
    x: cython.double
    for a in range(d2.shape[2]):
        x = fabs(d2[k, e, a])
        if x * q > limits[0, a]:
            q = limits[0, a] / x
        x = fabs(d3[k, e, a])
        if x > 0.0:
            x = cbrt(limits[1, a] / x)
            q = min(q, x * x)
    return q


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _gain(
    d1: cython.double[:, :, ::1],
    d2: cython.double[:, :, ::1],
    limits: cython.double[:, ::1],
    factor: cython.double[:, :, ::1],
    k: cython.Py_ssize_t,
    e: cython.Py_ssize_t,
    length: cython.double,
    cap: cython.double,
    state: cython.double[::1],
) -> cython.void:
    """Move ``state`` = (q, acceleration) over a length with full jerk, the acceleration limits and the bound `cap` of q."""
    a: cython.Py_ssize_t
    _: cython.int
    acc: cython.double = 1e300
    jerk: cython.double = 1e300
    most: cython.double = 0.0
    x: cython.double
    q: cython.double = state[0]
    v: cython.double = sqrt(q)
    rate: cython.double = state[1]
    t: cython.double
    for a in range(d1.shape[2]):
        most = max(most, fabs(d1[k, e, a]))
    for a in range(d1.shape[2]):
        x = fabs(d1[k, e, a])
        # An axis that turns about here asks for nothing; how much that is, would be rounding by rounding.
        if x > _ALIKE * most:
            acc = min(acc, max(limits[0, a] * factor[k, 0, a] - fabs(d2[k, e, a]) * q, 0.0) / x)
            jerk = min(jerk, limits[1, a] * factor[k, 1, a] / x)
    t = cbrt(6.0 * length / jerk)
    if v * t > length:
        t = length / v
    # Newton from above on the increasing, convex s(t) = length.
    for _ in range(4):
        t -= (((jerk * t / 6.0 + 0.5 * rate) * t + v) * t - length) / ((0.5 * jerk * t + rate) * t + v)
    rate = min(rate + jerk * t, acc)
    v += 0.5 * (state[1] + rate) * t
    state[0] = min(v * v, cap)
    state[1] = min(rate, max(0.0, 0.5 * (state[0] - q) / length))
    if state[0] < cap:
        state[1] = rate


def start(
    h: cython.double[::1],
    ends: cython.double[:, ::1],
    d1: cython.double[:, :, ::1],
    d2: cython.double[:, :, ::1],
    d3: cython.double[:, :, ::1],
    limits: cython.double[:, ::1],
    factor: cython.double[:, :, ::1],
    top: cython.double[:, ::1],
    part: cython.double,
    free: cython.Py_ssize_t,
    q: cython.double[:, ::1],
    c: cython.double[::1],
) -> cython.void:
    """Fill `c` with a profile to start from: `part` of one that rises and falls with full jerk along the path.

    A forward and a backward pass over the nodes below what steady motion allows, as for acceleration limits alone
    (Bobrow et al., *Int. J. Robotics Research* 4(3), 1985), with the acceleration as second state; the lower of both.

    Args:
        h, ends, d1, d2, d3, limits, factor: As in `build`.
        top: Shape (n, 2), largest q at both ends of each interval.
        part: Factor of q.
        free: First unknown to fill; those before it are given.
        q: Shape (n, 2), room for q at both ends.
        c: Shape (n + 2,), the result.
    """
    n: cython.Py_ssize_t = h.shape[0]
    k: cython.Py_ssize_t
    import numpy

    state: cython.double[::1] = numpy.zeros(2)
    with cython.nogil:
        for k in range(n):
            q[k, 0] = _ceiling(d2, d3, limits, k, 0, top[k, 0])
            q[k, 1] = _ceiling(d2, d3, limits, k, 2, top[k, 1])
        for k in range(n):
            if k == 0 or ends[k, 0] == 0.0:
                # beside a rest: q' = 2 q (1/e − 1)/h
                state[0] = q[k, 0]
                state[1] = (
                    q[k, 0] * (1.0 / ends[k, 1] - 1.0) / h[k]
                    if ends[k, 1] > 0.0
                    else max(0.0, (c[1] - c[0]) / h[k])
                )
            elif q[k, 0] < (1.0 - _ALIKE) * state[0]:
                state[0] = q[k, 0]
                state[1] = 0.0
            q[k, 0] = state[0]
            _gain(d1, d2, limits, factor, k, 0, h[k], q[k, 1], state)
            q[k, 1] = state[0]
        for k in range(n - 1, -1, -1):
            if k == n - 1 or ends[k, 3] == 0.0:
                state[0] = q[k, 1]
                state[1] = q[k, 1] * (1.0 / ends[k, 2] - 1.0) / h[k]
            elif q[k, 1] < (1.0 - _ALIKE) * state[0]:
                state[0] = q[k, 1]
                state[1] = 0.0
            q[k, 1] = state[0]
            _gain(d1, d2, limits, factor, k, 2, h[k], q[k, 0], state)
            q[k, 0] = state[0]
            if k + 1 >= free:
                c[k + 1] = part * min(q[k, 0], q[k, 1])
        c[n + 1] = 1.0
        if free == 1:
            c[0] = 1.0


def nearest(
    c: cython.double[::1],
    ends: cython.double[:, ::1],
    rows: cython.double[:, ::1],
    offset: cython.longlong[::1],
    awake: cython.longlong[::1],
    kind: cython.char[::1],
    margin: cython.double[::1],
    closest: cython.char[::1],
) -> cython.void:
    """Name the constraint that each interval comes nearest to.

    Args:
        c, ends, rows, offset, awake, kind: As `cncgen.kernels.least_time.solve` has left them.
        margin: Shape (n,), 1 on entry: becomes the least slack of a row of the interval, as a part of its limit.
        closest: Shape (n,): becomes the kind of that row.
    """
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    w: cython.double
    r: cython.double
    with cython.nogil:
        for k in range(margin.shape[0]):
            for i in range(offset[k], awake[k]):
                w = rows[i, 4]
                if kind[i] > 0:
                    w = min(w, rows[i, 5])
                r = rows[i, 3]
                if kind[i] == 2:
                    r /= sqrt(ends[k, 0] * c[k] + ends[k, 1] * c[k + 1])
                elif kind[i] == 3:
                    r /= sqrt(ends[k, 2] * c[k + 1] + ends[k, 3] * c[k + 2])
                if w < margin[k] * r:
                    margin[k] = w / r
                    closest[k] = kind[i]
