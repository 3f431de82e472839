# cython: cpow=True, infer_types=True
"""Arc length of rational B-splines, and the parameter at an arc length (docs/arc-length.md).

Curves and notation are those of `bspline`, on whose `Span` this works as C. Length is the integral of |C'| by a
Gauss-Legendre rule on panels where |C'| is smooth, in a table: B. Guenter and R. Parent (1990). Its inverse u(s) is a
Hermite polynomial of degree 7 a cell, as the feed correction polynomial of K. Erkorkmaz and Y. Altintas (2005).
"""

import cython
import numpy as np
from cython.cimports.cncgen.kernels.bspline import Curves, Span
from cython.cimports.libc.math import ldexp, sqrt

#: Points of the Gauss-Legendre rule.
_POINTS = cython.declare(cython.Py_ssize_t, 7)
#: Abscissae and weights of the rule that integrates |C'| over a cell, on [0, 1].
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(_POINTS)
#: Weights that give, of |C'| at the nodes, its Legendre coefficients of order 5 and 6 over the cell: (2n + 1) w P_n.
_TAILS = np.stack(
    [(2 * n + 1) * 0.5 * _WEIGHTS * np.polynomial.legendre.Legendre.basis(n)(_NODES) for n in (5, 6)]
)
_NODES = 0.5 + 0.5 * _NODES
_WEIGHTS = 0.5 * _WEIGHTS

#: Columns of a cell: u at its start, s at its start, its length in s, its width in u, and eight coefficients of the
#: polynomial u(tau), tau = (s - s_start) / length.
CELL_COLUMNS = 12
#: Marks of the start of a cell, as bits: a panel (a stretch on which |C'| is close to a polynomial of degree 4); a knot span; a row
#: of cells so short that the curve has a cusp there, or stands, and what comes after them.
PANEL, KNOT, CUSP = 1, 2, 4
#: Part of the mean of |C'| over a panel that its Legendre coefficients of order 5 and 6 reach at most.
_TAIL = cython.declare(cython.double, 1e-8)
#: Error of the way by rounding of a parameter, as a part of that of path coordinates, above which it is returned: |C'| beside heavy
#: points is a thousand times its mean, and a setpoint every 50 µs shows steps of 10⁻¹¹ mm.
_LACKING = cython.declare(cython.double, 0.25)
#: Part of the size of a curve below which a panel is not cut further.
_PANEL_LEAST = cython.declare(cython.double, 1e-10)
#: How often a span is halved at most: as often as its parameter can be.
_DEEPEST = cython.declare(cython.int, 52)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _hermite(
    cells: cython.double[:, ::1],
    row: cython.Py_ssize_t,
    u_end: cython.double,
    left: cython.double[::1],
    right: cython.double[::1],
) -> cython.void:
    """Fill the coefficients of the polynomial of degree 7 that has u and du/ds .. d³u/ds³ at both ends of the cell in a row."""
    h: cython.double = cells[row, 2]
    a1: cython.double = left[0] * h
    a2: cython.double = left[1] * h * h * 0.5
    a3: cython.double = left[2] * h * h * h / 6.0
    # The error of the start's cubic Taylor polynomial at the end, in value and derivatives.
    e0: cython.double = u_end - cells[row, 0] - a1 - a2 - a3
    e1: cython.double = right[0] * h - a1 - 2.0 * a2 - 3.0 * a3
    e2: cython.double = right[1] * h * h - 2.0 * a2 - 6.0 * a3
    e3: cython.double = right[2] * h * h * h - 6.0 * a3
    cells[row, 4] = cells[row, 0]
    cells[row, 5] = a1
    cells[row, 6] = a2
    cells[row, 7] = a3
    cells[row, 8] = 35.0 * e0 - 15.0 * e1 + 2.5 * e2 - e3 / 6.0
    cells[row, 9] = -84.0 * e0 + 39.0 * e1 - 7.0 * e2 + 0.5 * e3
    cells[row, 10] = 70.0 * e0 - 34.0 * e1 + 6.5 * e2 - 0.5 * e3
    cells[row, 11] = -20.0 * e0 + 10.0 * e1 - 2.0 * e2 + e3 / 6.0


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _beyond(
    cells: cython.const[cython.double][:, ::1], row: cython.Py_ssize_t, tau: cython.double
) -> cython.double:
    """By how much u at tau in 0 .. 1 of the cell in a row is more than where the cell begins, in all its digits."""
    u: cython.double = cells[row, 11]
    for k in range(6):
        u = u * tau + cells[row, 10 - k]
    return u * tau


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _horner(
    cells: cython.const[cython.double][:, ::1], row: cython.Py_ssize_t, tau: cython.double
) -> cython.double:
    """u at tau in 0 .. 1 of the cell in a row, kept inside the cell."""
    u: cython.double = _beyond(cells, row, tau) + cells[row, 4]
    if u < cells[row, 0]:
        return cells[row, 0]
    if u > cells[row, 0] + cells[row, 3]:
        return cells[row, 0] + cells[row, 3]
    return u


@cython.final
@cython.cclass
class _Measured:
    """The knot span whose length is taken, and room for that.

    Attributes:
        span: The span, with its derivatives.
        curves: The curves.
        metric_low, metric_high: Shape (m,), the columns that the length of each is taken over,
        low, high: and of the span's own one.
        rational: Whether the span's weights differ.
        taylor, slopes: Its Taylor coefficients, and those of their derivative, see `_taylor`.
        left, right: Derivatives of u(s) at both ends of a cell.
        speed: |C'| at the nodes of the rule,
        nodes, weights, tails: and the rule.
    """

    span: Span
    curves: Curves
    metric_low: cython.const[cython.longlong][::1]
    metric_high: cython.const[cython.longlong][::1]
    rational: cython.bint
    low: cython.Py_ssize_t
    high: cython.Py_ssize_t
    taylor: cython.double[:, ::1]
    slopes: cython.double[:, ::1]
    left: cython.double[::1]
    right: cython.double[::1]
    speed: cython.double[::1]
    nodes: cython.const[cython.double][::1]
    weights: cython.const[cython.double][::1]
    tails: cython.const[cython.double][:, ::1]

    def __init__(
        self,
        curves: Curves,
        metric_low: cython.const[cython.longlong][::1],
        metric_high: cython.const[cython.longlong][::1],
    ) -> None:
        """Make room for a span of any of the curves."""
        self.span = Span(curves)
        self.curves = curves
        self.metric_low = metric_low
        self.metric_high = metric_high
        self.taylor = np.zeros((curves.highest + 1, curves.points.shape[1] + 1))
        self.slopes = np.zeros_like(self.taylor)
        self.left = np.zeros(3)
        self.right = np.zeros(3)
        self.speed = np.zeros(_POINTS)
        self.nodes = _NODES
        self.weights = _WEIGHTS
        self.tails = _TAILS

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def enter(self, c: cython.Py_ssize_t, i: cython.Py_ssize_t) -> cython.void:
        """Take span `i` of curve c."""
        p: cython.Py_ssize_t = self.curves.degree[c]
        point: cython.Py_ssize_t = self.curves.point_offset[c] + i - self.curves.knot_offset[c] - p
        self.low = self.metric_low[c]
        self.high = self.metric_high[c]
        self.rational = False
        for j in range(point + 1, point + p + 1):
            self.rational = self.rational or self.curves.weights[j] != self.curves.weights[point]
        self.span.enter(c, i, max(p, 3))
        _taylor(self)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _taylor(on: _Measured) -> cython.void:
    """Fill ``on.taylor[k]`` with the k-th homogeneous Taylor coefficient about its middle, in half widths, and
    ``on.slopes[k]`` with that of the derivative.
    """
    a: cython.double = on.curves.knots[on.span.i]
    b: cython.double = on.curves.knots[on.span.i + 1]
    half: cython.double = 0.5 * (b - a)
    factor: cython.double = 1.0
    on.span.homogeneous(on.span.p, 0.5 * (a + b), on.taylor)
    for k in range(1, on.span.p + 1):
        factor *= half / k
        for d in range(on.taylor.shape[1]):
            on.taylor[k, d] *= factor
            on.slopes[k - 1, d] = k * on.taylor[k, d]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _inverse_derivatives(on: _Measured, out: cython.double[::1]) -> cython.bint:
    """Fill `out` with du/ds, d²u/ds², d³u/ds³ from C', C'', C''' in ``on.span.value``; False where C' vanishes.

    With g = ds/du = |C'|: g g' = C'.C'', g g'' + g'² = C''.C'' + C'.C'''. The first two are the coefficients of the
    interpolator by Taylor's series: S.-S. Yeh and J.-T. Sun (2008), eq. 3.1.
    """
    c11: cython.double = 0.0
    c12: cython.double = 0.0
    c22: cython.double = 0.0
    c13: cython.double = 0.0
    for d in range(on.low, on.high):
        c11 += on.span.value[1, d] * on.span.value[1, d]
        c12 += on.span.value[1, d] * on.span.value[2, d]
        c22 += on.span.value[2, d] * on.span.value[2, d]
        c13 += on.span.value[1, d] * on.span.value[3, d]
    g = sqrt(c11)
    if not g > 0.0:
        return False
    g1 = c12 / g
    g2 = (c22 + c13 - g1 * g1) / g
    out[0] = 1.0 / g
    out[1] = -g1 / (g * g * g)
    out[2] = (3.0 * g1 * g1 - g * g2) / (g * g * g * g * g)
    return True


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _smooth(on: _Measured, mean: cython.double) -> cython.bint:
    """Tell whether |C'| over a cell, in ``on.speed``, is close to a polynomial of degree 4.

    Sixth and seventh Legendre coefficient stand for all that follow. They are far above rounding where they reach
    `_TAIL`, so that two curves that differ in size or by rounding alone are cut alike.
    """
    odd: cython.double = 0.0
    even: cython.double = 0.0
    for n in range(_POINTS):
        odd += on.tails[0, n] * on.speed[n]
        even += on.tails[1, n] * on.speed[n]
    return abs(odd) + abs(even) <= _TAIL * mean


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _taylor_speed(on: _Measured, x: cython.double) -> cython.double:
    """|dC/dx| at x in half widths from the middle of the span."""
    p: cython.Py_ssize_t = on.span.p
    axes: cython.Py_ssize_t = on.taylor.shape[1] - 1
    weight: cython.double = on.taylor[0, axes]
    change: cython.double = 0.0
    value: cython.double
    slope: cython.double
    total: cython.double = 0.0
    if not on.rational:
        for d in range(on.low, on.high):
            slope = on.slopes[p - 1, d]
            for k in range(p - 2, -1, -1):
                slope = slope * x + on.slopes[k, d]
            total += slope * slope
        return sqrt(total) / weight
    weight = on.taylor[p, axes]
    for k in range(p - 1, -1, -1):
        change = change * x + weight
        weight = weight * x + on.taylor[k, axes]
    for d in range(on.low, on.high):
        value = on.taylor[p, d]
        slope = 0.0
        for k in range(p - 1, -1, -1):
            slope = slope * x + value
            value = value * x + on.taylor[k, d]
        slope -= change * value / weight
        total += slope * slope
    return sqrt(total) / weight


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _length(on: _Measured, a: cython.double, b: cython.double) -> cython.double:
    """Arc length between a and b, in half widths from the middle of the span, by one Gauss-Legendre rule.

    ``on.speed`` becomes |dC/dx| at its nodes.
    """
    total: cython.double = 0.0
    for n in range(_POINTS):
        on.speed[n] = _taylor_speed(on, a + (b - a) * on.nodes[n])
        total += on.weights[n] * on.speed[n]
    return total * (b - a)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _cell(
    on: _Measured,
    b: cython.double,
    tolerance: cython.double,
    least: cython.double,
    cells: cython.double[:, ::1],
    row: cython.Py_ssize_t,
) -> cython.int:
    """Make the cell in a row, from u in its first column to b, s from its second one.

    Returns 2 where length and inverse are within tolerance, 1 where only |C'| is smooth (or the length below `least`),
    else 0.
    """
    a: cython.double = cells[row, 0]
    middle: cython.double = 0.5 * (a + b)
    left: cython.double = on.curves.knots[on.span.i]
    right: cython.double = on.curves.knots[on.span.i + 1]
    centre: cython.double = 0.5 * (left + right)
    width: cython.double = 0.5 * (right - left)
    start: cython.double = (a - centre) / width
    between: cython.double = (middle - centre) / width
    end: cython.double = (b - centre) / width
    slope: cython.double
    whole = _length(on, start, end)
    if whole > least and not _smooth(on, whole / (end - start)):
        return 0
    half = _length(on, start, between)
    length = half + _length(on, between, end)
    cells[row, 2] = length
    cells[row, 3] = b - a
    cells[row, 4] = a
    cells[row, 5] = b - a
    for k in range(6, 12):
        cells[row, k] = 0.0
    if not length > tolerance or not (a < middle and middle < b):
        return 2
    on.span.derivatives(3, a)
    regular = _inverse_derivatives(on, on.left)
    on.span.derivatives(3, b)
    regular = _inverse_derivatives(on, on.right) and regular
    if not regular or abs(whole - length) > 10.0 * tolerance:
        return 1
    _hermite(cells, row, b, on.left, on.right)
    speed = _taylor_speed(on, between) / width
    share = half / length
    slope = 0.0
    for k in range(7, 0, -1):
        slope = slope * share + k * cells[row, 4 + k]
    # The slope is asked too: across a symmetric cusp the polynomial meets the middle, where nothing moves.
    if (
        abs(_horner(cells, row, share) - middle) * speed <= tolerance
        and abs(slope * speed / length - 1.0) < 1e-6
    ):
        return 2
    return 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _size(on: _Measured, c: cython.Py_ssize_t) -> cython.double:
    """Return how far the control points of curve c are from its first one, in the columns that are measured."""
    first: cython.Py_ssize_t = on.curves.point_offset[c]
    size: cython.double = 0.0
    for k in range(first, on.curves.point_offset[c + 1]):
        for d in range(on.metric_low[c], on.metric_high[c]):
            size = max(size, abs(on.curves.points[k, d] - on.curves.points[first, d]))
    return size


#: Where `cells` is: rows done, arc length of the curve up to them, whether the last one is tiny, whether there is room.
_Progress = cython.struct(rows=cython.Py_ssize_t, s=cython.double, tiny=cython.bint, fits=cython.bint)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _cut_span(
    on: _Measured,
    coarse: cython.double,
    least: cython.double,
    out: cython.double[:, ::1],
    begins: cython.char[::1],
    done: _Progress,
) -> _Progress:
    """Cut a span into panels, and these into cells on which length and inverse are known to `coarse`.

    Panels are dyadic parts of the span, those that are not smooth are halved: a curve and its reverse have the same ones.
    """
    rows: cython.Py_ssize_t = done.rows
    s: cython.double = done.s
    tiny: cython.bint = done.tiny
    within: cython.double = coarse
    begin: cython.char = 3
    first: cython.double = on.curves.knots[on.span.i]
    last: cython.double = on.curves.knots[on.span.i + 1]
    # The panel that is looked for, or that is cut into cells, by its number of those `depth` halvings make, and its end.
    look: cython.bint = True
    depth: cython.int = 0
    number: cython.longlong = 0
    end: cython.double = last
    # Both ends of the cell that is tried.
    a: cython.double = first
    b: cython.double = end
    while rows < out.shape[0]:
        out[rows, 0] = a
        out[rows, 1] = s
        grade = _cell(on, b, within, least if look and depth < _DEEPEST else 1e300, out, rows)
        look = grade == 0
        if look:
            depth += 1
            number *= 2
            end = first + (last - first) * ldexp(number + 1, -depth)
            b = end
            continue
        if grade < 2:
            b = 0.5 * (a + b)
            continue
        if tiny != (out[rows, 2] <= 10.0 * coarse):
            tiny = not tiny
            begin += 4
        begins[rows] = begin
        s += out[rows, 2]
        rows += 1
        if (rows - done.rows) % 512 == 0:
            # No curve needs that many cells: rounding keeps it from its tolerance.
            within *= 8.0
        if not b < last:
            return _Progress(rows=rows, s=s, tiny=tiny, fits=True)
        a = b
        begin = 0
        # The next try is twice as wide as what was just accepted, so widths can grow again.
        b = b + 2.0 * out[rows - 1, 3]
        if not a < end:
            begin = 1
            look = True
            # The other half of the last halved interval that is not done.
            number += 1
            while number % 2 == 0:
                number //= 2
                depth -= 1
            end = (
                last
                if number + 1 == ldexp(1.0, depth)
                else first + (last - first) * ldexp(number + 1, -depth)
            )
            b = end
        elif b + 0.5 * out[rows - 1, 3] > end:
            b = end
    return _Progress(rows=rows, s=s, tiny=tiny, fits=False)


def cells(
    first_curve: cython.Py_ssize_t,
    closeness: cython.double,
    metric_low: cython.const[cython.longlong][::1],
    metric_high: cython.const[cython.longlong][::1],
    curves: Curves,
    cell_offset: cython.longlong[::1],
    out: cython.double[:, ::1],
    begins: cython.char[::1],
):
    """Cut curves from `first_curve` on into cells on which arc length and its inverse are known to `closeness` (a part
    of the size of the curve), wherever it stands: control points are taken from one of their own.

    Every knot span is cut into panels, by halves, until |C'| is smooth on each; panels are cut into cells until the
    Gauss rule agrees with itself on the halves, and the Hermite polynomial of degree 7 for u(s) meets the middle.
    Length is taken over the columns ``metric_low[c]`` up to ``metric_high[c]`` of curve c. Rows of `out` follow
    `CELL_COLUMNS`, s from 0 at the start of each curve, `begins` has the bits of the marks that begin with them;
    ``cell_offset[c + 1]`` becomes the number of rows after curve c. Returns the first curve that `out` had no room for.
    """
    knots: cython.const[cython.double][::1] = curves.knots
    on: _Measured = _Measured(curves, metric_low, metric_high)
    done: _Progress = _Progress(rows=0, s=0.0, tiny=False, fits=True)
    c: cython.Py_ssize_t = first_curve
    with cython.nogil:
        while c < curves.degree.shape[0]:
            p = curves.degree[c]
            done = _Progress(rows=cell_offset[c], s=0.0, tiny=False, fits=True)
            least = _size(on, c)
            coarse = 4e-15 * least
            # The Taylor form that lengths are taken from loses a bit a degree.
            for k in range(4, p):
                coarse += coarse
            coarse, least = coarse + closeness * least, max(_PANEL_LEAST * least, 10.0 * coarse)
            for i in range(curves.knot_offset[c] + p, curves.knot_offset[c + 1] - p - 1):
                if not knots[i] < knots[i + 1]:
                    continue
                on.enter(c, i)
                done = _cut_span(on, coarse, least, out, begins, done)
                if not done.fits:
                    break
            if not done.fits:
                break
            cell_offset[c + 1] = done.rows
            c += 1
    return c


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def cell_at(
    cell: cython.const[cython.double][:, ::1],
    low: cython.Py_ssize_t,
    high: cython.Py_ssize_t,
    reach: cython.double,
    near: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """The last of the rows `low` up to `high` whose cell begins before `reach`, or the first; `near` or the next one are tried first."""
    for middle in range(max(near, low), min(near + 2, high)):
        if cell[middle, 1] < reach and not (middle + 1 < high and cell[middle + 1, 1] < reach):
            return middle
    while high - low > 1:
        middle = (low + high) // 2
        if cell[middle, 1] < reach:
            low = middle
        else:
            high = middle
    return low


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def parameter_at(
    cell: cython.const[cython.double][:, ::1],
    low: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    s: cython.double,
    side: cython.int,
    snap: cython.double,
    rest: cython.double[::1],
) -> cython.double:
    """The parameter u at arc length s from the start of a curve, which is on the cell in row `low` (`cell_at`) of those up to `last`.

    A place within `snap` of the border of a cell counts as that border, so that a knot is met exactly. Cells of
    length 0 (a stretch of the curve that does not move) are passed over towards `side`.

    ``rest[0]`` becomes what u lacks as a float, where the way that this is, is more than `_LACKING` of `snap`; else 0.
    """
    tau: cython.double = s - cell[low, 1]
    rest[0] = 0.0
    # Start and width may add up to the float beyond the knot, which is of the next span.
    end = cell[low + 1, 0] if low < last else cell[low, 0] + cell[low, 3]
    if cell[low, 2] <= 0.0:
        return end if side >= 0 else cell[low, 0]
    if tau <= snap:
        return cell[low, 0]
    if tau >= cell[low, 2] - snap:
        return end
    u = _horner(cell, low, tau / cell[low, 2])
    # |C'| is about the mean of the cell.
    if 2.0**-53 * abs(u) * cell[low, 2] > _LACKING * snap * cell[low, 3] and cell[low, 0] < u < end:
        rest[0] = _beyond(cell, low, tau / cell[low, 2]) - (u - cell[low, 0])
    return u


def invert(
    curve: cython.const[cython.longlong][::1],
    s: cython.const[cython.double][::1],
    side: cython.int,
    snap: cython.double,
    cell_offset: cython.const[cython.longlong][::1],
    cell: cython.const[cython.double][:, ::1],
    out: cython.double[::1],
):
    """Fill `out` with the parameter u at arc length ``s[n]`` from the start of curve ``curve[n]``, see `parameter_at`."""
    at: cython.Py_ssize_t = -1
    rest: cython.double[::1] = np.zeros(1)
    with cython.nogil:
        for n in range(s.shape[0]):
            c = curve[n]
            if cell_offset[c] == cell_offset[c + 1]:
                out[n] = 0.0
                continue
            reach = s[n] + snap if side >= 0 else s[n] - snap
            at = cell_at(cell, cell_offset[c], cell_offset[c + 1], reach, at)
            out[n] = parameter_at(cell, at, cell_offset[c + 1] - 1, s[n], side, snap, rest)


def lengths(
    curve: cython.const[cython.longlong][::1],
    u: cython.const[cython.double][::1],
    metric_low: cython.const[cython.longlong][::1],
    metric_high: cython.const[cython.longlong][::1],
    curves: Curves,
    cell_offset: cython.longlong[::1],
    cell: cython.const[cython.double][:, ::1],
    out: cython.double[::1],
):
    """Fill `out` with the arc length from the start of curve ``curve[n]`` to its parameter ``u[n]``."""
    knots: cython.const[cython.double][::1] = curves.knots
    on: _Measured = _Measured(curves, metric_low, metric_high)
    with cython.nogil:
        for n in range(u.shape[0]):
            c = curve[n]
            low = cell_offset[c]
            high = cell_offset[c + 1]
            if low == high:
                out[n] = 0.0
                continue
            while high - low > 1:
                middle = (low + high) // 2
                if cell[middle, 0] <= u[n]:
                    low = middle
                else:
                    high = middle
            at = min(max(u[n], cell[low, 0]), cell[low, 0] + cell[low, 3])
            i = on.span.find(c, cell[low, 0], 1)
            on.enter(c, i)
            on.rational = True
            centre = 0.5 * (knots[i] + knots[i + 1])
            width = 0.5 * (knots[i + 1] - knots[i])
            start = (cell[low, 0] - centre) / width
            end = (at - centre) / width
            out[n] = cell[low, 1] + _length(on, start, end)
