# cython: cpow=True, infer_types=True
"""Rational B-splines of any degree: derivatives at parameters.

Many curves lie end to end in flat arrays, `Curves`. Notation of L. Piegl and W. Tiller, The NURBS Book, 2nd ed. (1997):
knots U, degree p, knot span i with U[i] <= u < U[i+1]; spans and knots are counted over all curves.

`arc_length` works on both classes as C, by ``bspline.pxd``, which has the types of their attributes.
"""

import cython
import numpy as np
from cython.cimports.libc.math import nextafter


@cython.final
@cython.cclass
class Curves:
    """The columns of a `cncgen.geometry.tables.NurbsTable` of m curves.

    Attributes:
        degree: Shape (m,).
        point_offset, knot_offset: Shape (m + 1,), where the points and the knots of each curve begin.
        points: Shape (points, axes), mm or rad, not multiplied by the weights.
        weights: Shape (points,).
        knots: Shape (knots,).
        highest: The highest degree.
    """

    def __init__(
        self,
        degree: cython.const[cython.longlong][::1],
        point_offset: cython.const[cython.longlong][::1],
        knot_offset: cython.const[cython.longlong][::1],
        points: cython.const[cython.double][:, ::1],
        weights: cython.const[cython.double][::1],
        knots: cython.const[cython.double][::1],
    ) -> None:
        """Keep the arrays themselves."""
        self.degree = degree
        self.point_offset = point_offset
        self.knot_offset = knot_offset
        self.points = points
        self.weights = weights
        self.knots = knots
        self.highest = int(np.max(degree)) if degree.shape[0] else 0


@cython.final
@cython.cclass
class Span:
    """The knot span that is worked on, and room for it.

    Attributes:
        curves: The curves that spans are of.
        c, i, p: Its curve, index and degree; c is −1 before the first one.
        plain: Whether its weights are all 1: the curve is a polynomial, and its weight is not worked out.
        q: ``q[k, j]``: homogeneous control points of its k-th derivative (NURBS Book, eq. 3.8), the weight last, from the
            point ``q[p + 1, 0]`` as origin.
        value: The curve and its derivatives at a place, shape (4, axes + 1), the weight's last.
        basis: Basis functions.
        over: ``over[r, j]``: the reciprocal of U[i + 1 + j] - U[i + 1 + j - r], for j < r.
    """

    def __init__(self, curves: Curves) -> None:
        """Make room for a span of any of the curves."""
        degree: cython.Py_ssize_t = curves.highest
        axes: cython.Py_ssize_t = curves.points.shape[1]
        self.curves = curves
        self.c = -1
        self.q = np.zeros((max(degree, 3) + 2, degree + 1, axes + 1))
        self.value = np.zeros((4, axes + 1))
        self.basis = np.zeros(degree + 1)
        self.over = np.zeros((degree + 1, degree + 1))

    @cython.ccall
    @cython.nogil
    @cython.exceptval(check=False)
    def find(self, c: cython.Py_ssize_t, u: cython.double, side: cython.int) -> cython.Py_ssize_t:
        """Index i of the non-empty span of curve c with U[i] <= u < U[i+1] (side >= 0) or U[i] < u <= U[i+1] (side < 0).

        By bisection over the parameter range (The NURBS Book (1997), Algorithm A2.1), of which the first or last span is what a `u` outside
        gets.
        """
        p: cython.Py_ssize_t = self.curves.degree[c]
        first: cython.Py_ssize_t = self.curves.knot_offset[c] + p
        last: cython.Py_ssize_t = self.curves.knot_offset[c + 1] - p - 1
        low: cython.Py_ssize_t = first
        high: cython.Py_ssize_t = last
        while high - low > 1:
            middle = (low + high) // 2
            if self.curves.knots[middle] < u or (side >= 0 and self.curves.knots[middle] == u):
                low = middle
            else:
                high = middle
        while low > first and self.curves.knots[low] == self.curves.knots[low + 1]:
            low -= 1
        while low < last - 1 and self.curves.knots[low] == self.curves.knots[low + 1]:
            low += 1
        return low

    @cython.ccall
    @cython.nogil
    @cython.exceptval(check=False)
    def enter(self, c: cython.Py_ssize_t, i: cython.Py_ssize_t, order: cython.Py_ssize_t) -> cython.void:
        """Take span i of curve c, for derivatives up to `order`: fill `q`.

        The span's p + 1 control points are taken from one of them as origin: from two that coincide if there are such, for
        where the curve stands nearly, derivatives keep their digits so whatever the weights; else from the heaviest, near
        which the curve stays and the quotient rule would take alike numbers from each other.
        """
        p: cython.Py_ssize_t = self.curves.degree[c]
        point: cython.Py_ssize_t = self.curves.point_offset[c] + i - self.curves.knot_offset[c] - p
        axes: cython.Py_ssize_t = self.curves.points.shape[1]
        origin: cython.Py_ssize_t = point
        self.c = c
        self.i = i
        self.p = p
        for k in range(1, p + 1):
            for j in range(k):
                self.over[k, j] = 1.0 / (self.curves.knots[i + 1 + j] - self.curves.knots[i + 1 + j - k])
        self.plain = self.curves.weights[point] == 1.0
        for j in range(1, p + 1):
            self.plain = self.plain and self.curves.weights[point + j] == 1.0
            if self.curves.weights[point + j] > self.curves.weights[origin]:
                origin = point + j
        for j in range(p - 1, -1, -1):
            alike = True
            for d in range(axes):
                if self.curves.points[point + j, d] != self.curves.points[point + j + 1, d]:
                    alike = False
            if alike:
                origin = point + j
        for d in range(axes):
            self.q[p + 1, 0, d] = self.curves.points[origin, d]
        for j in range(p + 1):
            for d in range(axes):
                self.q[0, j, d] = (
                    self.curves.points[point + j, d] - self.curves.points[origin, d]
                ) * self.curves.weights[point + j]
            self.q[0, j, axes] = self.curves.weights[point + j]
        for k in range(1, order + 1):
            if k > p:
                break
            for j in range(p - k + 1):
                factor = (p - k + 1) * self.over[p - k + 1, j]
                for d in range(axes + 1):
                    self.q[k, j, d] = factor * (self.q[k - 1, j + 1, d] - self.q[k - 1, j, d])

    @cython.ccall
    @cython.nogil
    @cython.exceptval(check=False)
    def homogeneous(
        self, order: cython.Py_ssize_t, u: cython.double, out: cython.double[:, ::1]
    ) -> cython.void:
        """Fill ``out[k]``, k up to `order` and p, with the k-th homogeneous derivative at u.

        Basis functions by the Cox-de Boor recurrence (The NURBS Book (1997), Algorithm A2.2): at degree p - k they meet the points of the
        k-th derivative.
        """
        i: cython.Py_ssize_t = self.i
        p: cython.Py_ssize_t = self.p
        columns: cython.Py_ssize_t = self.q.shape[2]
        saved: cython.double
        term: cython.double
        x: cython.double
        y: cython.double
        z: cython.double
        if self.plain:
            columns -= 1
            out[0, columns] = 1.0
            for r in range(1, min(order, p) + 1):
                out[r, columns] = 0.0
        self.basis[0] = 1.0
        for r in range(p + 1):
            if r > 0:
                saved = 0.0
                for j in range(r):
                    term = self.basis[j] * self.over[r, j]
                    self.basis[j] = saved + (self.curves.knots[i + 1 + j] - u) * term
                    saved = (u - self.curves.knots[i + 1 + j - r]) * term
                self.basis[r] = saved
            if p - r <= order:
                # Three sums side by side: each alone waits for its last term.
                for d in range(0, columns - 2, 3):
                    x = y = z = 0.0
                    for j in range(r + 1):
                        term = self.basis[j]
                        x += term * self.q[p - r, j, d]
                        y += term * self.q[p - r, j, d + 1]
                        z += term * self.q[p - r, j, d + 2]
                    out[p - r, d] = x
                    out[p - r, d + 1] = y
                    out[p - r, d + 2] = z
                for d in range(columns - columns % 3, columns):
                    term = 0.0
                    for j in range(r + 1):
                        term += self.basis[j] * self.q[p - r, j, d]
                    out[p - r, d] = term

    @cython.ccall
    @cython.nogil
    @cython.exceptval(check=False)
    def derivatives(self, order: cython.Py_ssize_t, u: cython.double) -> cython.void:
        """Fill ``value[k]``, k up to `order`, with the k-th derivative at u, its weight in the last column.

        The quotient rule (The NURBS Book (1997), eq. 4.8) on the homogeneous ones.
        """
        axes: cython.Py_ssize_t = self.q.shape[2] - 1
        for k in range(self.p + 1, order + 1):
            for d in range(axes + 1):
                self.value[k, d] = 0.0
        self.homogeneous(order, u, self.value)
        if self.plain:
            for d in range(axes):
                self.value[0, d] += self.q[self.p + 1, 0, d]
            return
        for d in range(axes):
            self.value[0, d] = self.value[0, d] / self.value[0, axes]
            if order > 0:
                self.value[1, d] = (self.value[1, d] - self.value[1, axes] * self.value[0, d]) / self.value[
                    0, axes
                ]
            if order > 1:
                self.value[2, d] = (
                    self.value[2, d]
                    - 2.0 * self.value[1, axes] * self.value[1, d]
                    - self.value[2, axes] * self.value[0, d]
                ) / self.value[0, axes]
            if order > 2:
                self.value[3, d] = (
                    self.value[3, d]
                    - 3.0 * self.value[1, axes] * self.value[2, d]
                    - 3.0 * self.value[2, axes] * self.value[1, d]
                    - self.value[3, axes] * self.value[0, d]
                ) / self.value[0, axes]
            self.value[0, d] += self.q[self.p + 1, 0, d]


def evaluate(
    curve: cython.const[cython.longlong][::1],
    u: cython.const[cython.double][::1],
    side: cython.int,
    order: cython.Py_ssize_t,
    curves: Curves,
    out: cython.double[:, :, ::1],
):
    """Fill ``out[k, n]`` with the k-th derivative (k = 0 .. order <= 3) of curve ``curve[n]`` at ``u[n]``.

    Parameters outside the range of a curve continue its first or last span. At a knot, `side` >= 0 takes the span
    that begins there, `side` < 0 the one that ends there. Points of one span in a row are cheap: sort them.
    """
    knots: cython.const[cython.double][::1] = curves.knots
    axes: cython.Py_ssize_t = curves.points.shape[1]
    span: Span = Span(curves)
    with cython.nogil:
        for n in range(u.shape[0]):
            c = curve[n]
            if c != span.c or not (knots[span.i] < u[n] and u[n] < knots[span.i + 1]):
                i = span.find(c, u[n], side)
                if c != span.c or i != span.i:
                    span.enter(c, i, order)
            span.derivatives(order, u[n])
            for k in range(order + 1):
                for d in range(axes):
                    out[k, n, d] = span.value[k, d]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _leaves_line(
    points: cython.const[cython.double][:, ::1],
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    furthest: cython.Py_ssize_t,
    limit: cython.double,
) -> cython.bint:
    """Whether a point `first` up to `last` is further than `limit`, in some axis, from the line of `first` to `furthest`.

    The distance is taken at the height that the point has in the axis in which the line is longest (docs/nurbs.md).
    """
    along: cython.Py_ssize_t = 0
    for d in range(1, points.shape[1]):
        if abs(points[furthest, d] - points[first, d]) > abs(points[furthest, along] - points[first, along]):
            along = d
    for k in range(first + 1, last):
        part = (points[k, along] - points[first, along]) / (points[furthest, along] - points[first, along])
        for d in range(points.shape[1]):
            if (
                abs((points[k, d] - points[first, d]) - part * (points[furthest, d] - points[first, d]))
                > limit
            ):
                return True
    return False


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _line_through(
    points: cython.const[cython.double][:, ::1],
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    roundings: cython.double,
) -> cython.Py_ssize_t:
    """The point furthest from the one at `first` of those up to `last`, if all lie on the line of both but for rounding; else -1."""
    furthest: cython.Py_ssize_t = first
    away: cython.double
    far: cython.double = 0.0
    size: cython.double = 0.0
    for k in range(first, last):
        away = 0.0
        for d in range(points.shape[1]):
            away += (points[k, d] - points[first, d]) * (points[k, d] - points[first, d])
            size = max(size, abs(points[k, d]))
        if away > far:
            far = away
            furthest = k
    size = roundings * (nextafter(size, 2.0 * size + 1.0) - size)
    if far > 0.0 and _leaves_line(points, first, last, furthest, size):
        return -1
    return furthest


def directions(curves: Curves, roundings: cython.double, out: cython.double[:, ::1]):
    """Fill ``out[j]`` with the way of the span whose control points begin with the j-th, from that one to the furthest of them,
    if all lie on that line as far as the rounding of coordinates, `roundings` units in the last place of the largest, lets that
    be known; else, and where no span begins, with 0. All spans of a curve that lies on a line have the way of the whole.
    """
    points: cython.const[cython.double][:, ::1] = curves.points
    axes: cython.Py_ssize_t = points.shape[1]
    with cython.nogil:
        for c in range(curves.degree.shape[0]):
            first = curves.point_offset[c]
            after = curves.point_offset[c + 1]
            whole = _line_through(points, first, after, roundings)
            for k in range(first, after):
                begin = first
                furthest = whole
                if whole < 0:
                    begin = k
                    furthest = k
                    if k + curves.degree[c] < after:
                        furthest = max(k, _line_through(points, k, k + curves.degree[c] + 1, roundings))
                for d in range(axes):
                    out[k, d] = points[furthest, d] - points[begin, d]


def spans(
    curve: cython.const[cython.longlong][::1],
    u: cython.const[cython.double][::1],
    side: cython.int,
    curves: Curves,
    out: cython.longlong[::1],
):
    """Fill ``out[n]`` with the first control point of the span of curve ``curve[n]`` at ``u[n]``, on `side` of a knot."""
    span: Span = Span(curves)
    with cython.nogil:
        for n in range(u.shape[0]):
            c = curve[n]
            out[n] = (
                curves.point_offset[c] + span.find(c, u[n], side) - curves.knot_offset[c] - curves.degree[c]
            )
