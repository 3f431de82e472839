# cython: cpow=True, infer_types=True
"""Derivatives of a path of lines and NURBS by its coordinate s, at many places in one pass (docs/nurbs.md).

Rows of a path lie end to end, those of its curves as in `bspline`, with the cells of `arc_length` that lead from s to the
parameter.
"""

import cython
import numpy as np
from cython.cimports.cncgen.kernels.arc_length import cell_at, parameter_at
from cython.cimports.cncgen.kernels.bspline import Curves, Span
from cython.cimports.libc.math import sqrt

#: Kinds of rows that are closed forms elsewhere, and that are curves; the values of `cncgen.geometry.path`.
_ARC = cython.declare(cython.int, 1)
_NURBS = cython.declare(cython.int, 2)


@cython.final
@cython.cclass
class Rows:
    """The columns of a path of n rows, m of them NURBS.

    Attributes:
        s: Shape (n + 1,), path coordinate where rows begin, and the end.
        length: Shape (n,), of each.
        kind: Shape (n,), int8.
        curve: Shape (n,), the curve of rows that are NURBS.
        starts, ends: Shape (n, axes), points.
        first, last: The first and the last row that moves.
        snap: Path coordinates that differ by less are the same.
        curves: The curves.
        low, high: Shape (m,), the columns over which the length of each is taken.
        cell_offset, cells: See `arc_length`.
        total: Shape (m,), the length of each.
        along: Shape (control points, axes), dx/ds of spans on a straight line in the row of their first control point, 0 of others.
        slow: |dC/du| below this part of its mean over the curve is looked at for whether it vanishes.
    """

    s: cython.const[cython.double][::1]
    length: cython.const[cython.double][::1]
    kind: cython.const[cython.schar][::1]
    curve: cython.const[cython.longlong][::1]
    starts: cython.const[cython.double][:, ::1]
    ends: cython.const[cython.double][:, ::1]
    first: cython.Py_ssize_t
    last: cython.Py_ssize_t
    snap: cython.double
    curves: Curves
    low: cython.const[cython.longlong][::1]
    high: cython.const[cython.longlong][::1]
    cell_offset: cython.const[cython.longlong][::1]
    cells: cython.const[cython.double][:, ::1]
    total: cython.const[cython.double][::1]
    along: cython.const[cython.double][:, ::1]
    slow: cython.double

    def __init__(
        self,
        s: cython.const[cython.double][::1],
        length: cython.const[cython.double][::1],
        kind: cython.const[cython.schar][::1],
        curve: cython.const[cython.longlong][::1],
        starts: cython.const[cython.double][:, ::1],
        ends: cython.const[cython.double][:, ::1],
        first: cython.Py_ssize_t,
        last: cython.Py_ssize_t,
        snap: cython.double,
        curves: Curves,
        low: cython.const[cython.longlong][::1],
        high: cython.const[cython.longlong][::1],
        cell_offset: cython.const[cython.longlong][::1],
        cells: cython.const[cython.double][:, ::1],
        total: cython.const[cython.double][::1],
        along: cython.const[cython.double][:, ::1],
        slow: cython.double,
    ) -> None:
        """Keep the arrays themselves."""
        self.s = s
        self.length = length
        self.kind = kind
        self.curve = curve
        self.starts = starts
        self.ends = ends
        self.first = first
        self.last = last
        self.snap = snap
        self.curves = curves
        self.low = low
        self.high = high
        self.cell_offset = cell_offset
        self.cells = cells
        self.total = total
        self.along = along
        self.slow = slow


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _row_at(on: Rows, s: cython.double, side: cython.int, near: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """The last row that begins before s, or at it for side >= 0; `near` or the next one are tried first."""
    high: cython.Py_ssize_t = on.length.shape[0] + 1
    for low in range(near, min(near + 2, high - 1)):
        if (on.s[low] < s or (side >= 0 and on.s[low] == s)) and not (
            on.s[low + 1] < s or (side >= 0 and on.s[low + 1] == s)
        ):
            break
    else:
        low = -1
        while high - low > 1:
            middle = (low + high) // 2
            if on.s[middle] < s or (side >= 0 and on.s[middle] == s):
                low = middle
            else:
                high = middle
    return max(on.first, min(low, on.last))


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _by_length(
    value: cython.double[:, ::1],
    order: cython.Py_ssize_t,
    low: cython.Py_ssize_t,
    high: cython.Py_ssize_t,
) -> cython.double:
    """Turn derivatives by u, one a row of `value`, into those by s; 0 where C' is 0. Returns |C'| over low .. high.

    With g = ds/du = |C'|: g' = C'.C''/g, g'' = (C''.C'' + C'.C''' - g'^2)/g, x' = C'/g, x'' = (C'' - x' g')/g^2 and
    x''' = (C''' - 3 x'' g g' - x' g'')/g^3.
    """
    c11: cython.double = 0.0
    c12: cython.double = 0.0
    c22: cython.double = 0.0
    c13: cython.double = 0.0
    inverse: cython.double = 0.0
    for d in range(low, high):
        c11 += value[1, d] * value[1, d]
        if order > 1:
            c12 += value[1, d] * value[2, d]
        if order > 2:
            c22 += value[2, d] * value[2, d]
            c13 += value[1, d] * value[3, d]
    g = sqrt(c11)
    if g > 0.0:
        inverse = 1.0 / g
    g1 = c12 * inverse
    g2 = (c22 + c13 - g1 * g1) * inverse
    for d in range(value.shape[1]):
        value[1, d] *= inverse
        if order > 1:
            value[2, d] = (value[2, d] - value[1, d] * g1) * (inverse * inverse)
        if order > 2:
            value[3, d] = (
                value[3, d] * (inverse * inverse)
                - (3.0 * value[2, d] * g1 + value[1, d] * g2 * inverse) * inverse
            ) * inverse
    return g


def by_length(
    low: cython.const[cython.longlong][::1],
    high: cython.const[cython.longlong][::1],
    values: cython.double[:, :, ::1],
):
    """Turn ``values[k, n]``, k = 1 .. 3 or less: derivatives by a parameter become those by the length over the columns
    ``low[n]`` up to ``high[n]``; 0 where the first one is 0.
    """
    order: cython.Py_ssize_t = values.shape[0] - 1
    value: cython.double[:, ::1] = np.zeros((4, values.shape[2]))
    with cython.nogil:
        for n in range(values.shape[1]):
            for k in range(1, order + 1):
                for d in range(values.shape[2]):
                    value[k, d] = values[k, n, d]
            _by_length(value, order, low[n], high[n])
            for k in range(1, order + 1):
                for d in range(values.shape[2]):
                    values[k, n, d] = value[k, d]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _line(
    on: Rows, row: cython.Py_ssize_t, u: cython.double, order: cython.Py_ssize_t, value: cython.double[:, ::1]
) -> cython.void:
    """Fill `value` with a point of a row that is a line, or does not move, at the part u of it, and its derivatives by s.

    From the nearer end, so that both ends are met to the bit.
    """
    length: cython.double = on.s[row + 1] - on.s[row]
    moves: cython.bint = on.kind[row] == 0
    for d in range(value.shape[1]):
        delta = on.ends[row, d] - on.starts[row, d] if moves else 0.0
        if u < 0.5:
            value[0, d] = on.starts[row, d] + u * delta
        else:
            value[0, d] = on.ends[row, d] - (1.0 - u) * delta
        value[1, d] = delta / length if length > 0.0 else 0.0
        for k in range(2, order + 1):
            value[k, d] = 0.0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _straighten(
    on: Rows, j: cython.Py_ssize_t, order: cython.Py_ssize_t, value: cython.double[:, ::1]
) -> cython.void:
    """Take from the derivatives of a span on a straight line what bends it: rounding, large where it turns back or nearly stands.

    `j` is the first control point of the span.
    """
    forth: cython.double = 0.0
    straight: cython.bint = False
    for d in range(on.along.shape[1]):
        forth += value[1, d] * on.along[j, d]
        straight = straight or on.along[j, d] != 0.0
    if straight:
        forth = 1.0 if forth > 0.0 else (-1.0 if forth < 0.0 else 0.0)
        for d in range(on.along.shape[1]):
            value[1, d] = forth * on.along[j, d]
            for k in range(2, order + 1):
                value[k, d] = 0.0


def rows(on: Rows, s: cython.const[cython.double][::1], side: cython.int, out: cython.longlong[::1]):
    """Fill `out` with the row at each s: where two meet, that on the right for `side` >= 0, on the left for `side` < 0.

    Only rows that move are found. Sorted places are cheap.
    """
    at: cython.Py_ssize_t = on.first
    with cython.nogil:
        for n in range(s.shape[0]):
            at = _row_at(on, s[n], side, at)
            out[n] = at


def evaluate(
    on: Rows,
    s: cython.const[cython.double][::1],
    side: cython.int,
    order: cython.Py_ssize_t,
    row: cython.longlong[::1],
    u: cython.double[::1],
    slow: cython.longlong[::1],
    out: cython.double[:, :, ::1],
):
    """Fill ``out[k, n]``, k = 0 .. order <= 3, with the k-th derivative of the path by its coordinate at ``s[n]``.

    At a breakpoint `side` tells whose derivatives are meant: 1 those on its right, -1 on its left. ``row[n]`` becomes the
    row, ``u[n]`` its own parameter there. Of an arc only its row is found. Returns how many places of curves have |C'|
    so small that it may vanish; ``slow`` begins with their numbers. Places of one span in a row are cheap: sort them.
    """
    knots: cython.const[cython.double][::1] = on.curves.knots
    axes: cython.Py_ssize_t = out.shape[2]
    span: Span = Span(on.curves)
    point: cython.double[:, ::1] = np.zeros((4, axes))
    found: cython.Py_ssize_t = 0
    at: cython.Py_ssize_t = on.first
    cell: cython.Py_ssize_t = -1
    rest: cython.double[::1] = np.zeros(1)
    with cython.nogil:
        for n in range(s.shape[0]):
            at = _row_at(on, s[n], side, at)
            row[n] = at
            local = max(s[n] - on.s[at], 0.0)
            if local > on.length[at]:
                local = on.length[at]
            if on.kind[at] == _ARC:
                continue
            if on.kind[at] != _NURBS:
                u[n] = local / on.length[at] if on.length[at] > 0.0 else 0.0
                _line(on, at, u[n], order, point)
                for k in range(order + 1):
                    for d in range(axes):
                        out[k, n, d] = point[k, d]
            else:
                c = on.curve[at]
                i = on.cell_offset[c + 1]
                rest[0] = u[n] = 0.0
                if on.cell_offset[c] < i:
                    cell = cell_at(
                        on.cells,
                        on.cell_offset[c],
                        i,
                        local + on.snap if side >= 0 else local - on.snap,
                        cell,
                    )
                    u[n] = parameter_at(on.cells, cell, i - 1, local, side, on.snap, rest)
                needed = max(order, 1) if rest[0] != 0.0 else order
                if c != span.c or not (knots[span.i] < u[n] and u[n] < knots[span.i + 1]):
                    i = span.find(c, u[n], side)
                    if c != span.c or i != span.i:
                        span.enter(c, i, max(order, 1))
                span.derivatives(needed, u[n])
                if rest[0] != 0.0:
                    for d in range(axes):
                        span.value[0, d] += rest[0] * span.value[1, d]
                if order > 0:
                    g = _by_length(span.value, order, on.low[c], on.high[c])
                    i = on.curves.degree[c]
                    whole = knots[on.curves.knot_offset[c + 1] - i - 1] - knots[on.curves.knot_offset[c] + i]
                    if g * whole <= on.slow * on.total[c]:
                        slow[found] = n
                        found += 1
                    i = on.curves.point_offset[c] + span.i - on.curves.knot_offset[c] - i
                    _straighten(on, i, order, span.value)
                for k in range(order + 1):
                    for d in range(axes):
                        out[k, n, d] = span.value[k, d]
    return found
