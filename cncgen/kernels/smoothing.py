# cython: cpow=True, infer_types=True
"""A smooth spline through a corridor: penalised least squares with a smoothing length that the corridor sets.

The path to follow is given as n cubic pieces y(t) over ``t[k] .. t[k + 1]``, t its arc length. The result is a B-spline
x(t) of degree 4 with simple knots that minimises

    integral |x - y|² dt + integral L(t)^6 |x'''|² dt,

where the smoothing length L(t) is made as large as |x(t) - y(t)| <= tolerance allows (docs/smoothing.md): graduation by
splines (I. J. Schoenberg (1964)) with a weight that varies along the path. As in P-splines (Eilers and Marx (1996)) the penalty
is a sum over control points, here those of x'''. Columns of y are scaled so that all are mm.
`cncgen.kernels.smoothing_lengths` places knots and samples by L; `cncgen.geometry.corridor` calls `fit`.
"""

import cython
import numpy as np
from cython.cimports.cncgen.kernels.smoothing_lengths import adjust, choose, lay, length_at, lower
from cython.cimports.libc.math import sqrt

#: Degree of the spline: x''' is continuous and linear between knots.
DEGREE = 4

_P = cython.declare(cython.Py_ssize_t, 4)
#: Part of the tolerance by which the bound between two points of comparison may exceed the values there; else the points are
#: placed closer.
_SLACK = cython.declare(cython.double, 0.02)
#: Stands for the part of the tolerance that is used where the equations could not be solved and the curve is NaN.
_LOST = cython.declare(cython.double, 1e30)
#: Most points of comparison on one stretch.
_MOST = cython.declare(cython.Py_ssize_t, 400)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _invert(
    knots: cython.double[::1], last: cython.Py_ssize_t, inverse: cython.double[:, ::1]
) -> cython.void:
    """Fill ``inverse[i, r − 1]`` with 1/(knots[i + r] − knots[i]), r = 1 … 4, 0 where these are one place."""
    for i in range(last + _P):
        for r in range(1, min(_P, last + _P - i) + 1):
            width = knots[i + r] - knots[i]
            inverse[i, r - 1] = 1.0 / width if width > 0.0 else 0.0


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _basis(
    knots: cython.double[::1],
    inverse: cython.double[:, ::1],
    i: cython.Py_ssize_t,
    u: cython.double,
    b: cython.double[::1],
) -> cython.void:
    """Fill b with the basis functions of degree 4 that live on span i (The NURBS Book, Algorithm A2.2)."""
    b[0] = 1.0
    for r in range(1, _P + 1):
        saved = 0.0
        for j in range(r):
            term = b[j] * inverse[i + 1 + j - r, r - 1]
            b[j] = saved + (knots[i + 1 + j] - u) * term
            saved = (u - knots[i + 1 + j - r]) * term
        b[r] = saved


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _follow(
    t: cython.const[cython.double][::1],
    y: cython.const[cython.double][:, :, ::1],
    knots: cython.double[::1],
    last: cython.Py_ssize_t,
    base: cython.double[:, ::1],
) -> cython.void:
    """Fill `base` with control points near those of the curve: the path at the means of their knots.

    These are the Greville abscissae (de Boor, A Practical Guide to Splines (2001), chapter XI): a spline with such control points
    is near the path, to second order in the knot distance.
    """
    n: cython.Py_ssize_t = t.shape[0] - 1
    k: cython.Py_ssize_t = 0
    for i in range(last):
        u = 0.25 * (knots[i + 1] + knots[i + 2] + knots[i + 3] + knots[i + 4])
        u = min(max(u, t[0]), t[n])
        while k < n - 1 and t[k + 1] <= u:
            k += 1
        u -= t[k]
        for d in range(base.shape[1]):
            base[i, d] = y[k, 0, d] + u * (y[k, 1, d] + u * (y[k, 2, d] + u * y[k, 3, d]))


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _attract(
    t: cython.const[cython.double][::1],
    y: cython.const[cython.double][:, :, ::1],
    knots: cython.double[::1],
    inverse: cython.double[:, ::1],
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    at: cython.double[::1],
    samples: cython.Py_ssize_t,
    matrix: cython.double[:, ::1],
    points: cython.double[:, ::1],
    base: cython.double[:, ::1],
    b: cython.double[::1],
) -> cython.void:
    """Add the integral of |x - y|² to the normal equations by the trapezoidal rule over the samples."""
    axes: cython.Py_ssize_t = points.shape[1]
    n: cython.Py_ssize_t = t.shape[0] - 1
    i: cython.Py_ssize_t = first
    k: cython.Py_ssize_t = 0
    value: cython.double
    for m in range(samples):
        weight = 0.0
        if m > 0:
            weight += 0.5 * (at[m] - at[m - 1])
        if m < samples - 1:
            weight += 0.5 * (at[m + 1] - at[m])
        while i < last - 1 and knots[i + 1] <= at[m]:
            i += 1
        while k < n - 1 and t[k + 1] <= at[m]:
            k += 1
        _basis(knots, inverse, i, at[m], b)
        u = at[m] - t[k]
        for d in range(axes):
            place = y[k, 0, d] + u * (y[k, 1, d] + u * (y[k, 2, d] + u * y[k, 3, d]))
            value = 0.0
            for j in range(_P + 1):
                value += b[j] * (place - base[i - _P + j, d])
            value *= weight
            for j in range(_P + 1):
                points[i - _P + j, d] += b[j] * value
        for j in range(_P + 1):
            for d in range(j, _P + 1):
                matrix[i - _P + j, d - j] += weight * b[j] * b[d]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _penalise(
    t: cython.const[cython.double][::1],
    scale: cython.double[::1],
    knots: cython.double[::1],
    inverse: cython.double[:, ::1],
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    matrix: cython.double[:, ::1],
    points: cython.double[:, ::1],
    base: cython.double[:, ::1],
    b: cython.double[::1],
) -> cython.void:
    """Add the integral of L⁶ |x'''|² to the normal equations: a sum over the control points sum_j b[j] c[i + j] of x'''.

    The part of the `base` is computed from differences of its points (the b[j] add up to 0), which keeps its digits.
    """
    n: cython.Py_ssize_t = t.shape[0] - 1
    k: cython.Py_ssize_t = 0
    value: cython.double
    for i in range(last - 3):
        if knots[i + 5] <= knots[first]:
            continue
        _third_difference(inverse, i, b)
        u = min(max(knots[i + 4], t[0]), t[n])
        while k < n - 1 and t[k + 1] <= u:
            k += 1
        length = length_at(t, scale, k, u)
        weight = 0.5 * (knots[i + 5] - knots[i + 3]) * length * length * length * length * length * length
        for j in range(4):
            for d in range(j, 4):
                matrix[i + j, d - j] += weight * b[j] * b[d]
        for d in range(base.shape[1]):
            value = b[3] * (base[i + 3, d] - base[i + 2, d]) - b[0] * (base[i + 1, d] - base[i, d])
            value += (b[2] + b[3]) * (base[i + 2, d] - base[i + 1, d])
            value *= weight
            for j in range(4):
                points[i + j, d] -= b[j] * value


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _assemble(
    t: cython.const[cython.double][::1],
    y: cython.const[cython.double][:, :, ::1],
    scale: cython.double[::1],
    knots: cython.double[::1],
    inverse: cython.double[:, ::1],
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    at: cython.double[::1],
    samples: cython.Py_ssize_t,
    matrix: cython.double[:, ::1],
    points: cython.double[:, ::1],
    base: cython.double[:, ::1],
    b: cython.double[::1],
) -> cython.void:
    """Build the normal equations: band ``matrix[i, d]`` = A[i, i + d], right side in `points` for unknowns 0 .. last − 1.

    Control point i has the support ``knots[i] .. knots[i + 5]``. The unknowns are the differences of the control points from those
    of `base`. So the condition of the equations, (L/h)⁶, multiplies the rounding of L and not that of the coordinates.
    """
    for i in range(last):
        for j in range(_P + 1):
            matrix[i, j] = 0.0
        for j in range(points.shape[1]):
            points[i, j] = 0.0
    _follow(t, y, knots, last, base)
    _attract(t, y, knots, inverse, first, last, at, samples, matrix, points, base, b)
    _penalise(t, scale, knots, inverse, first, last, matrix, points, base, b)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _third_difference(
    inverse: cython.double[:, ::1], i: cython.Py_ssize_t, b: cython.double[::1]
) -> cython.void:
    """Fill b with the weights of c[i .. i + 3] in control point i of x''' (NURBS Book, eq. 3.8 three times)."""
    f0: cython.double = 4.0 * inverse[i + 1, 3]
    f1: cython.double = 4.0 * inverse[i + 2, 3]
    f2: cython.double = 4.0 * inverse[i + 3, 3]
    g0: cython.double = 3.0 * inverse[i + 2, 2]
    g1: cython.double = 3.0 * inverse[i + 3, 2]
    h: cython.double = 2.0 * inverse[i + 3, 1]
    b[0] = -h * g0 * f0
    b[1] = h * (g1 * f1 + g0 * (f0 + f1))
    b[2] = -h * (g0 * f1 + g1 * (f1 + f2))
    b[3] = h * g1 * f2


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _polar(
    knots: cython.double[::1],
    i: cython.Py_ssize_t,
    y: cython.const[cython.double][:, :, ::1],
    k: cython.Py_ssize_t,
    origin: cython.double,
    out: cython.double[:, ::1],
) -> cython.void:
    """Set control point i to that of piece k: its polar form of degree 4 at ``knots[i + 1 .. i + 4]`` (L. Ramshaw (1989))."""
    a: cython.double = knots[i + 1] - origin
    b: cython.double = knots[i + 2] - origin
    c: cython.double = knots[i + 3] - origin
    e: cython.double = knots[i + 4] - origin
    for d in range(out.shape[1]):
        out[i, d] = (
            y[k, 0, d]
            + y[k, 1, d] * (a + b + c + e) / 4.0
            + y[k, 2, d] * (a * b + a * c + a * e + b * c + b * e + c * e) / 6.0
            + y[k, 3, d] * (a * b * c + a * b * e + a * c * e + b * c * e) / 4.0
        )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _give(
    matrix: cython.double[:, ::1],
    points: cython.double[:, ::1],
    base: cython.double[:, ::1],
    fixed: cython.double[:, ::1],
    count: cython.Py_ssize_t,
    head: cython.Py_ssize_t,
    tail: cython.Py_ssize_t,
) -> cython.void:
    """Take the first `head` and last `tail` unknowns out of a band system: they are given by `fixed`."""
    given: cython.bint
    other: cython.bint
    for i in range(count):
        given = i < head or i >= count - tail
        for j in range(1, min(_P + 1, count - i)):
            other = i + j < head or i + j >= count - tail
            if not given and not other:
                continue
            for d in range(points.shape[1]):
                if not other:
                    points[i + j, d] -= matrix[i, j] * (fixed[i, d] - base[i, d])
                elif not given:
                    points[i, d] -= matrix[i, j] * (fixed[i + j, d] - base[i + j, d])
            matrix[i, j] = 0.0
        if given:
            matrix[i, 0] = 1.0
            for d in range(points.shape[1]):
                points[i, d] = fixed[i, d] - base[i, d]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _solve(
    matrix: cython.double[:, ::1],
    points: cython.double[:, ::1],
    base: cython.double[:, ::1],
    fixed: cython.double[:, ::1],
    count: cython.Py_ssize_t,
    head: cython.Py_ssize_t,
    tail: cython.Py_ssize_t,
) -> cython.void:
    """Solve the band system by LDLᵀ and add the base; the first `head` and last `tail` points are given by `fixed`."""
    axes: cython.Py_ssize_t = points.shape[1]
    factor: cython.double
    _give(matrix, points, base, fixed, count, head, tail)
    for i in range(count):
        pivot = 1.0 / matrix[i, 0]
        for j in range(1, min(_P + 1, count - i)):
            factor = matrix[i, j] * pivot
            for m in range(j, min(_P + 1, count - i)):
                matrix[i + j, m - j] -= factor * matrix[i, m]
            for d in range(axes):
                points[i + j, d] -= factor * points[i, d]
    for i in range(count - 1, -1, -1):
        pivot = 1.0 / matrix[i, 0]
        for d in range(axes):
            factor = points[i, d]
            for j in range(1, min(_P + 1, count - i)):
                factor -= matrix[i, j] * points[i + j, d]
            points[i, d] = factor * pivot
    for i in range(count):
        for d in range(axes):
            points[i, d] += base[i, d]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _power_form(
    knots: cython.double[::1],
    inverse: cython.double[:, ::1],
    i: cython.Py_ssize_t,
    points: cython.double[:, ::1],
    q: cython.double[:, ::1],
    b: cython.double[:, ::1],
    out: cython.double[:, ::1],
) -> cython.double:
    """Fill ``out[k]`` with x^(k)/k! at the start of span i; returns a bound of |x''| on the span (its control points).

    ``b[r]`` becomes the basis of degree r there, whose last function vanishes; the derivatives' control points are made
    in place in q.
    """
    axes: cython.Py_ssize_t = points.shape[1]
    bend: cython.double = 0.0
    total: cython.double
    faculty: cython.double = 1.0
    b[0, 0] = 1.0
    for r in range(1, _P + 1):
        saved = 0.0
        for j in range(r):
            factor = b[r - 1, j] * inverse[i + 1 + j - r, r - 1] if j < r - 1 or r == 1 else 0.0
            b[r, j] = saved + (knots[i + 1 + j] - knots[i]) * factor
            saved = (knots[i] - knots[i + 1 + j - r]) * factor
    for j in range(_P + 1):
        for d in range(axes):
            q[j, d] = points[i - _P + j, d]
    for k in range(_P + 1):
        r = _P - k
        if k > 0:
            faculty /= k
            for j in range(r + 1):
                factor = (r + 1) * inverse[i + k - _P + j, r]
                for d in range(axes):
                    q[j, d] = factor * (q[j + 1, d] - q[j, d])
        if k == 2:
            for j in range(r + 1):
                total = 0.0
                for d in range(axes):
                    total += q[j, d] * q[j, d]
                bend = max(bend, total)
        for d in range(axes):
            total = b[r, 0] * q[0, d]
            for j in range(1, r):
                total += b[r, j] * q[j, d]
            out[k, d] = total * faculty
    return sqrt(bend)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _beside(
    x: cython.double[:, ::1],
    y: cython.const[cython.double][:, :, ::1],
    k: cython.Py_ssize_t,
    w: cython.double,
    curved: cython.bint,
    out: cython.double[:, ::1],
) -> cython.void:
    """Fill `out` with x − y as a polynomial of the place on the span, whose start is at w on piece k."""
    for d in range(x.shape[1]):
        out[0, d] = x[0, d] - (y[k, 0, d] + w * (y[k, 1, d] + w * (y[k, 2, d] + w * y[k, 3, d])))
        out[1, d] = x[1, d] - y[k, 1, d]
        out[2, d] = x[2, d]
        out[3, d] = x[3, d]
        out[4, d] = x[4, d]
    if curved:
        for d in range(x.shape[1]):
            out[1, d] -= w * (2.0 * y[k, 2, d] + 3.0 * w * y[k, 3, d])
            out[2, d] -= y[k, 2, d] + 3.0 * w * y[k, 3, d]
            out[3, d] -= y[k, 3, d]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _square(e: cython.double[:, ::1], u: cython.double) -> cython.double:
    """Return the square of what a polynomial is at u, over all columns."""
    total: cython.double = 0.0
    for d in range(e.shape[1]):
        value = e[0, d] + u * (e[1, d] + u * (e[2, d] + u * (e[3, d] + u * e[4, d])))
        total += value * value
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _compare_stretch(
    beside: cython.double[:, ::1],
    start: cython.double,
    a: cython.double,
    e: cython.double,
    middle: cython.double,
    turn: cython.double,
    tolerance: cython.double,
    used: cython.double[::1],
) -> cython.void:
    """Raise `used`, of both halves of a piece, to the part of the tolerance that is used from a to e, on one span and piece.

    Args:
        beside: Shape (5, axes): x − y in powers of the place on the span, which begins at `start`.
        start, a, e, middle: Places along the pieces, `middle` that of the piece.
        turn: Bound of |x'' − y''|.
        tolerance: Of the piece.
        used: Shape (2,).
    """
    width: cython.double = 8.0 * _SLACK * tolerance / (turn + 1e-300)
    steps: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, min((e - a) / sqrt(width), 1.0 * _MOST)) + 1
    before: cython.double = _square(beside, a - start)
    left: cython.double = -1.0
    right: cython.double = -1.0
    width = (e - a) / steps
    extra = 0.125 * width * width * turn
    for m in range(1, steps + 1):
        here = a + m * width
        after = _square(beside, here - start)
        # A piece that spans the middle counts on both halves; one that ends there, but for rounding, does not.
        if here - width < middle - 1e-6 * width:
            left = max(left, max(before, after))
        if here > middle + 1e-6 * width:
            right = max(right, max(before, after))
        before = after
    if left >= 0.0:
        used[0] = max(used[0], (sqrt(left) + extra) / tolerance)
    if right >= 0.0:
        used[1] = max(used[1], (sqrt(right) + extra) / tolerance)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _compare(
    t: cython.const[cython.double][::1],
    y: cython.const[cython.double][:, :, ::1],
    bend: cython.const[cython.double][::1],
    tolerance: cython.const[cython.double][::1],
    knots: cython.double[::1],
    inverse: cython.double[:, ::1],
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    points: cython.double[:, ::1],
    b: cython.double[:, ::1],
    room: cython.double[:, :, ::1],
    used: cython.double[:, ::1],
) -> cython.double:
    """Bound |x(t) − y(t)| everywhere; returns the largest part of the tolerance that is used.

    ``used[k]`` becomes the part on the first and on the second half of piece k. Between two points a distance w
    apart |x − y| is at most the larger of both ends plus w²/8 max |x'' − y''|.
    """
    n: cython.Py_ssize_t = t.shape[0] - 1
    k: cython.Py_ssize_t = 0
    worst: cython.double = 0.0
    q: cython.double[:, ::1] = room[0]
    x: cython.double[:, ::1] = room[1]
    beside: cython.double[:, ::1] = room[2]
    for k in range(n):
        used[k, 0] = 0.0
        used[k, 1] = 0.0
    k = 0
    for i in range(first, last):
        turn = _power_form(knots, inverse, i, points, q, b, x)
        if not turn < _LOST:
            # No number, or as good as none: the equations have lost all digits, and shorter lengths are asked for.
            for k in range(n):
                used[k, 0] = _LOST
                used[k, 1] = _LOST
            return _LOST
        a = knots[i]
        while k < n - 1 and t[k + 1] <= a:
            k += 1
        while a < knots[i + 1]:
            e = min(knots[i + 1], t[k + 1]) if k < n - 1 else knots[i + 1]
            _beside(x, y, k, knots[i] - t[k], bend[k] > 0.0, beside)
            _compare_stretch(
                beside, knots[i], a, e, 0.5 * (t[k] + t[k + 1]), turn + bend[k], tolerance[k], used[k]
            )
            worst = max(worst, max(used[k, 0], used[k, 1]))
            a = e
            if k < n - 1 and t[k + 1] <= a:
                k += 1
    return worst


def fit(
    t: cython.const[cython.double][::1],
    y: cython.const[cython.double][:, :, ::1],
    bend: cython.const[cython.double][::1],
    tolerance: cython.const[cython.double][::1],
    cuts: cython.const[cython.double][::1],
    scale: cython.double[::1],
    longest: cython.const[cython.double][::1],
    rounds: cython.Py_ssize_t,
    least: cython.double,
    knots: cython.double[::1],
    laid: cython.Py_ssize_t,
    fixed: cython.double[:, ::1],
    head: cython.Py_ssize_t,
    tail: cython.Py_ssize_t,
    points: cython.double[:, ::1],
    used: cython.double[:, ::1],
):
    """Fit a spline of degree 4 to pieces within their tolerance.

    The curve begins at ``knots[4]``. Either nothing came before it: the first five knots are t[0] and `laid` is 4;
    or it goes on from another: the first nine knots and the first four control points are the other's last ones,
    `laid` is 8, and the pieces begin at or before ``knots[4]``.

    Args:
        t: Shape (n + 1,), arc length at the ends of the pieces.
        y: Shape (n, 4, axes): power coefficients of each piece in t − t[k].
        bend: Shape (n,): bound of |y''| on the piece.
        tolerance: Shape (n,), mm.
        cuts: Places that become knots, ascending, after ``knots[laid]``, the last one t[n].
        scale: Shape (n + 1,): smoothing length at the ends of pieces, to start from; updated.
        longest: Shape (n + 1,): largest smoothing length there.
        rounds: Tries in which the smoothing length may grow; after them it only shrinks.
        least: Part of the tolerance that is to be used: below it the length grows.
        knots: Room for the knots, the given ones in place.
        laid: Index of the last given knot.
        fixed: Shape as `points`; where the curve goes on from another its first four rows are given.
        head, tail: Control points at the start and at the end that are not free: 0 at an open end; 1 where the curve
            has the end point in common with the path; 2 where its direction too; 4 where three derivatives, or where it goes on.
        points: Room for the control points, as many rows as knots.
        used: Shape (n, 2): part of the tolerance used on the halves of each piece.

    Returns:
        Index of the last knot of the curve (as many control points), and the largest part of the tolerance used;
        the index is −1 where the room did not suffice.
    """
    n: cython.Py_ssize_t = t.shape[0] - 1
    axes: cython.Py_ssize_t = y.shape[2]
    room: cython.Py_ssize_t = knots.shape[0]
    at: cython.double[::1] = np.empty(3 * room + n + 8)
    matrix: cython.double[:, ::1] = np.empty((room, 5))
    base: cython.double[:, ::1] = np.empty((room, axes))
    inverse: cython.double[:, ::1] = np.zeros((room, 4))
    b: cython.double[:, ::1] = np.empty((5, 5))
    work: cython.double[:, :, ::1] = np.empty((3, 5, axes))
    change: cython.double[::1] = np.empty(n + 1)
    strides: cython.double[::1] = np.empty(n + 1)
    last: cython.Py_ssize_t = -1
    turn: cython.Py_ssize_t = 0
    worst: cython.double = 0.0
    with cython.nogil:
        lower(t, scale)
        while True:
            last = lay(t, scale, cuts, knots, laid, strides)
            if last < 0:
                break
            for j in range(1, _P + 1):
                knots[last + j] = knots[last]
            samples = choose(t, bend, knots, _P, last, at)
            if samples < 0:
                last = -1
                break
            _invert(knots, last, inverse)
            _assemble(t, y, scale, knots, inverse, _P, last, at, samples, matrix, points, base, b[0])
            if laid == _P:
                for j in range(head):
                    _polar(knots, j, y, 0, t[0], fixed)
            for j in range(last - tail, last):
                _polar(knots, j, y, n - 1, t[n - 1], fixed)
            _solve(matrix, points, base, fixed, last, head, tail)
            worst = _compare(t, y, bend, tolerance, knots, inverse, _P, last, points, b, work, used)
            turn += 1
            if worst <= 1.0 and turn > rounds:
                break
            if turn > rounds + 60:
                break
            adjust(t, scale, used, longest, turn <= rounds, least, change)
    return last, worst
