# cython: infer_types=True
"""Least time through a row of nodes with room around each: an interior point in the time domain (docs/tube.md).

The problem is that of `cncgen.kernels.tube_point`. It is solved as Wächter and Biegler (2006) do (primal-dual barrier, exact Hessian,
filter), each Newton step by `cncgen.kernels.tube_step`, so the work goes with the number of nodes.

Functions take the number of axes as an argument: `solve` hands on 2 and 3 as constants, for which compilers unroll the loops.
"""

import cython
from cython.cimports.cncgen.kernels.tube_point import Tube, measure
from cython.cimports.cncgen.kernels.tube_step import backward, forward
from cython.cimports.libc.math import fabs, sqrt

from cncgen.kernels.tube_point import BEYOND

_BEYOND = cython.declare(cython.double, BEYOND)

#: Part of the way to a bound that a step may go.
_TAU = cython.declare(cython.double, 0.99)
#: Largest ratio of a multiplier to its central value, and of that to it (Wächter and Biegler (2006), eq. 16); and where a search goes on
#: after its problem has changed.
_OFF = cython.declare(cython.double, 1e10)
_OFF_AGAIN = cython.declare(cython.double, 10.0)
#: A step is halved so often at most.
_HALVINGS = cython.declare(cython.int, 6)
#: The barrier parameter µ falls to µ^(11/8), at most this part of itself, once the residual and, in parts of the
#: parameter, the products of slacks and multipliers are near. A search that ends near the solution has a residual below the third number.
_FALL = cython.declare(cython.double, 0.2)
_CLOSE = cython.declare(cython.double, 0.1)
_NEAR = cython.declare(cython.double, 1e-3)
_OFF_NEAR = cython.declare(cython.double, 10.0)
#: Damping: a step of less than the second number multiplies by `_CHANGE` what is added to the Hessian, within these bounds, once the
#: residual is below the first number; before that one of less than a tenth of that does. A longer step divides it.
_SETTLED = cython.declare(cython.double, 1e-2)
_SHORT = cython.declare(cython.double, 0.1)
_LEAST_DAMPING = cython.declare(cython.double, 1e-4)
_FIRST_DAMPING = cython.declare(cython.double, 1e-3)
_MOST_DAMPING = cython.declare(cython.double, 0.1)
_CHANGE = cython.declare(cython.double, 4.0)
#: So many steps in a row of less than this part, and the search ends: closing where it is near, without a solution where it is not.
_HOPELESS = cython.declare(cython.int, 10)
_STUCK = cython.declare(cython.double, 1e-3)
#: Damping beyond which the Hessian is taken without the curvature of the motion.
_CONVEX = cython.declare(cython.double, 10.0)
#: The search ends where two steps in a row change the cost by less than this part of it, or so many iterations before the last one.
#: Then steps with much damping, each with `_CHANGE` times that of the one before, make the motion exact.
_FLAT = cython.declare(cython.double, 3e-6)
#: Largest residual for that: damped steps make it less than a thousandth of itself.
_NEARLY = cython.declare(cython.double, 1e-3)
_CLOSING = cython.declare(cython.int, 12)
_CLOSING_DAMPING = cython.declare(cython.double, 1.0)
#: Largest residual as a multiple of that of the first point, and the least residual that counts: an exact first point must be left.
_WORSE = cython.declare(cython.double, 4.0)
_LEAST_MISS = cython.declare(cython.double, 1.0)


# How far the step may go, and where it ends.

_Steps = cython.struct(primal=cython.double, dual=cython.double, size=cython.double)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _dual(z: cython.double, dz: cython.double, dual: cython.double) -> cython.double:
    """Return the divisor of the step of multipliers, raised so that this multiplier stays above 0."""
    return -dz / z if -dz > dual * z else dual


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _box(
    z: cython.double[:, ::1],
    dz: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    at: cython.Py_ssize_t,
    low: cython.double,
    high: cython.double,
    d: cython.double,
    mu: cython.double,
    steps: _Steps,
) -> _Steps:
    """Compute the steps of the multipliers of two bounds, and the divisor of the step."""
    y: cython.double = 1.0 / (low * high)
    a: cython.double = (mu - z[k, at] * d) * high * y - z[k, at]
    b: cython.double = (mu + z[k, at + 1] * d) * low * y - z[k, at + 1]
    dz[k, at] = a
    dz[k, at + 1] = b
    if -d > steps.primal * low:
        steps.primal = -d / low
    if d > steps.primal * high:
        steps.primal = d / high
    steps.dual = _dual(z[k, at], a, steps.dual)
    steps.dual = _dual(z[k, at + 1], b, steps.dual)
    steps.size = max(steps.size, fabs(d))
    return steps


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _curve(s: cython.double, g: cython.double, c: cython.double, primal: cython.double) -> cython.double:
    """Return the divisor of a step for which s + g α - c α² keeps (1 - τ) s."""
    left: cython.double = _TAU * s
    part: cython.double = _TAU / primal
    if left + part * (g - c * part) >= 0.0:
        return primal
    # α = (g + root) / (2 c) = 2 left / (root - g)
    return _TAU * (sqrt(g * g + 4.0 * c * left) - g) / (2.0 * left)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _beside(z: cython.double, s: cython.double, g: cython.double, mu: cython.double) -> cython.double:
    """Return the step of a multiplier whose slack s changes by g."""
    return (mu - z * g) / s - z


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _between(tube: Tube, n: cython.Py_ssize_t, k: cython.Py_ssize_t, steps: _Steps) -> _Steps:
    """Work out the steps of the multipliers of the middle ordinates of an interval; shorten the step until their slacks stay."""
    h: cython.double = tube.u[k, n]
    d: cython.double
    along: cython.double = 0.0
    square: cython.double
    kept: cython.bint
    a: cython.double
    y = cython.declare(cython.double[9])
    c = cython.declare(cython.double[9])
    s = tube.middle_slack[k]
    for i in range(n):
        y[i] = tube.middle[k, i]
        c[i] = tube.V[i] * tube.between[k]
        c[i] = tube.weight[k, i] * tube.weight[k + 1, i] * c[i] * c[i]
        a = 0.5 * tube.AV[i] * tube.h0[k]
        d = tube.dx[k, 3 * i + 1] + a * (h * tube.dx[k, 3 * i + 2] + tube.du[k, n] * tube.x[k, 3 * i + 2])
        along -= 2.0 * c[i] * y[i] * d
        tube.dzm[k, 2 * i] = _beside(tube.zm[k, 2 * i], 1.0 + y[i], d, tube.mu)
        tube.dzm[k, 2 * i + 1] = _beside(tube.zm[k, 2 * i + 1], 1.0 - y[i], -d, tube.mu)
    tube.dzm[k, 2 * n] = _beside(tube.zm[k, 2 * n], s, along, tube.mu)
    for i in range(2 * n + 1):
        steps.dual = _dual(tube.zm[k, i], tube.dzm[k, i], steps.dual)
    for m in range(60):
        h = 0.5 * tube.h0[k] * (tube.u[k, n] + steps.primal * tube.du[k, n])
        square = 0.0
        kept = True
        for i in range(n):
            a = tube.x[k, 3 * i + 1] + steps.primal * tube.dx[k, 3 * i + 1]
            a += tube.AV[i] * h * (tube.x[k, 3 * i + 2] + steps.primal * tube.dx[k, 3 * i + 2])
            kept = kept and 1.0 + a >= (1.0 - _TAU) * (1.0 + y[i]) and 1.0 - a >= (1.0 - _TAU) * (1.0 - y[i])
            square += c[i] * a * a
        if kept and 1.0 - square >= (1.0 - _TAU) * s:
            break
        steps.primal *= 0.8
    return steps


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _limits(tube: Tube, n: cython.Py_ssize_t) -> _Steps:
    """Work out the steps of the multipliers, and how far unknowns and multipliers may go."""
    mu: cython.double = tube.mu
    y: cython.double
    d: cython.double
    along: cython.double
    # Divisors of steps, so that whole steps are the longest.
    steps: _Steps = _Steps(_TAU, _TAU, 0.0)
    x: cython.double[:, ::1] = tube.x
    u: cython.double[:, ::1] = tube.u
    dx: cython.double[:, ::1] = tube.dx
    du: cython.double[:, ::1] = tube.du
    g: cython.double[:, ::1] = tube.row_slope
    for k in range(tube.steps):
        for i in range(n):
            steps = _box(tube.zu, tube.dzu, k, 2 * i, 1.0 + u[k, i], 1.0 - u[k, i], du[k, i], mu, steps)
        y = u[k, n]
        steps = _box(tube.zu, tube.dzu, k, 2 * n, y - tube.hlow[k], tube.hhigh[k] - y, du[k, n], mu, steps)
        if k == 0:
            continue
        for i in range(n):
            for e in range(2):
                y = x[k, 3 * i + e + 1]
                d = dx[k, 3 * i + e + 1]
                steps = _box(tube.zx, tube.dzx, k, 4 * i + 2 * e, 1.0 + y, 1.0 - y, d, mu, steps)
        for m in range(tube.first[k], tube.first[k + 1]):
            s = tube.row_slack[m]
            y = 0.0
            d = 0.0
            along = 0.0
            for i in range(n):
                moved = dx[k, 3 * i] + tube.rows[m, 2 * n + 1] * tube.V[i] * tube.AV[i] * dx[k, 3 * i + 2]
                y += g[m, i] * moved
                d += moved * moved
                along += moved * tube.rows[m, n + i]
            d = (d - along * along) * tube.rows[m, 2 * n] * tube.rows[m, 2 * n]
            steps.primal = _curve(s, y, d, steps.primal)
            tube.dzr[m] = _beside(tube.zr[m], s, y, mu)
            steps.dual = _dual(tube.zr[m], tube.dzr[m], steps.dual)
        if tube.feed[k] > 0.0:
            s = tube.feed_slack[k]
            y = 0.0
            d = 0.0
            for i in range(n):
                y += tube.feed_slope[k, i] * dx[k, 3 * i + 1]
                c = tube.V[i] * tube.feed[k]
                d += tube.weight[k, i] * c * c * dx[k, 3 * i + 1] * dx[k, 3 * i + 1]
            steps.primal = _curve(s, y, d, steps.primal)
            tube.dzf[k] = _beside(tube.zf[k], s, y, mu)
            steps.dual = _dual(tube.zf[k], tube.dzf[k], steps.dual)
    steps.primal = _TAU / steps.primal
    for k in range(tube.steps):
        if tube.between[k] > 0.0:
            steps = _between(tube, n, k, steps)
    steps.dual = _TAU / steps.dual
    return steps


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _kept(z: cython.double, s: cython.double, mu: cython.double, most: cython.double) -> cython.double:
    """Return a multiplier, kept near its central value."""
    return mu / most / s if z * s < mu / most else mu * most / s if z * s > mu * most else z


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _multipliers(tube: Tube, n: cython.Py_ssize_t, part: cython.double, most: cython.double) -> cython.double:
    """Move the multipliers of the point that was measured last by a part of their step, within a factor of their central values; return how far products are off mu."""
    mu: cython.double = tube.mu
    off: cython.double = 0.0
    for k in range(tube.steps):
        for i in range(2 * n + 2):
            if i < 2 * n:
                y = tube.u[k, i // 2]
                s = 1.0 + y if i % 2 == 0 else 1.0 - y
            else:
                s = tube.u[k, n] - tube.hlow[k] if i % 2 == 0 else tube.hhigh[k] - tube.u[k, n]
            y = _kept(tube.zu[k, i] + part * tube.dzu[k, i], s, mu, most)
            tube.zu[k, i] = y
            off = max(off, fabs(y * s - mu))
        if tube.between[k] > 0.0:
            for i in range(2 * n + 1):
                y = tube.middle[k, i // 2] if i < 2 * n else 0.0
                s = tube.middle_slack[k] if i == 2 * n else 1.0 + y if i % 2 == 0 else 1.0 - y
                tube.zm[k, i] = _kept(tube.zm[k, i] + part * tube.dzm[k, i], s, mu, most)
                off = max(off, fabs(tube.zm[k, i] * s - mu))
        if k == 0:
            continue
        for i in range(4 * n):
            y = tube.x[k, 3 * (i // 4) + 1 + (i % 4) // 2]
            s = 1.0 + y if i % 2 == 0 else 1.0 - y
            y = _kept(tube.zx[k, i] + part * tube.dzx[k, i], s, mu, most)
            tube.zx[k, i] = y
            off = max(off, fabs(y * s - mu))
        for m in range(tube.first[k], tube.first[k + 1]):
            s = tube.row_slack[m]
            tube.zr[m] = _kept(tube.zr[m] + part * tube.dzr[m], s, mu, most)
            off = max(off, fabs(tube.zr[m] * s - mu))
        if tube.feed[k] > 0.0:
            s = tube.feed_slack[k]
            tube.zf[k] = _kept(tube.zf[k] + part * tube.dzf[k], s, mu, most)
            off = max(off, fabs(tube.zf[k] * s - mu))
    return off


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _taken(tube: Tube, count: cython.Py_ssize_t, phi: cython.double, c: cython.double) -> cython.bint:
    """Tell whether a filter lets a point pass: beside each pair that it has, less of one of the two."""
    if not phi < _BEYOND:
        return False
    for i in range(count):
        if not (c <= max(0.99999 * tube.seen[i, 1], 1e-7) or phi <= tube.seen[i, 0] - 1e-5 * tube.seen[i, 1]):
            return False
    return True


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _moved(tube: Tube, n: cython.Py_ssize_t, part: cython.double) -> cython.void:
    """Write the point that a part of the step leads to."""
    for k in range(tube.steps + 1):
        for i in range(3 * n):
            tube.x2[k, i] = tube.x[k, i] + part * tube.dx[k, i]
    for k in range(tube.steps):
        for i in range(n + 1):
            tube.u2[k, i] = tube.u[k, i] + part * tube.du[k, i]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _accept(tube: Tube, n: cython.Py_ssize_t, part: cython.double) -> cython.void:
    """Take the point that the step leads to, and the multipliers of the equations."""
    for k in range(tube.steps + 1):
        for i in range(3 * n):
            tube.x[k, i] = tube.x2[k, i]
    for k in range(tube.steps):
        for i in range(n + 1):
            tube.u[k, i] = tube.u2[k, i]
        for i in range(3 * n):
            tube.lam[k, i] += part * (tube.lam2[k, i] - tube.lam[k, i])
        if k > 0:
            tube.nu[k] += part * (tube.nu2[k] - tube.nu[k])
    for i in range(3 * n):
        tube.lamT[i] += part * (tube.lamT2[i] - tube.lamT[i])


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _cost(tube: Tube) -> cython.double:
    """Return the barrier function of the point that was measured last."""
    return tube.value - tube.mu * tube.logs


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _fallen(mu: cython.double, mu_end: cython.double) -> cython.double:
    """Return the barrier parameter after one whose problem is nearly solved."""
    fourth = sqrt(sqrt(mu))
    return max(mu_end, min(_FALL * mu, mu * fourth * sqrt(fourth)))


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _direction(tube: Tube, damping: cython.double) -> cython.double:
    """Compute a Newton step with as much damping as makes the Hessian positive definite; return the damping, -1 where none does."""
    tube.curvature = 1.0
    while not backward(tube, damping):
        damping = max(_LEAST_DAMPING, _CHANGE * damping)
        if damping > _CONVEX:
            # The multipliers are far off: the step without the curvature of the motion has a positive Hessian.
            tube.curvature = 0.0
        if damping > 1e12:
            return -1.0
    forward(tube)
    return damping


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _searched(
    tube: Tube, n: cython.Py_ssize_t, count: cython.Py_ssize_t, part: cython.double
) -> cython.double:
    """Halve a step until the filter lets the point pass that it leads to, and measure that; return the part of the step that is left."""
    for back in range(_HALVINGS):
        if back > 0:
            part *= 0.5
        _moved(tube, n, part)
        measure(tube, True)
        if _taken(tube, count, _cost(tube), tube.missed):
            break
    return part


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _next_damping(damping: cython.double, part: cython.double, residual: cython.double) -> cython.double:
    """Return the damping of the step after one of which a part was taken."""
    if part < _SHORT and (residual < _SETTLED or part < 0.1 * _SHORT):
        return min(_MOST_DAMPING, max(_FIRST_DAMPING, _CHANGE * damping))
    return damping / _CHANGE if damping > _LEAST_DAMPING else 0.0


Found = cython.struct(status=cython.int, iterations=cython.int, residual=cython.double, off=cython.double)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _solved(
    tube: Tube,
    n: cython.Py_ssize_t,
    mu: cython.double,
    mu_end: cython.double,
    most: cython.int,
    near: cython.bint,
    again: cython.bint,
) -> Found:
    count: cython.Py_ssize_t = 1
    damping: cython.double = 0.0
    part: cython.double = 1.0
    size: cython.double = 1.0
    phi: cython.double = 0.0
    solved: cython.bint
    level: cython.bint
    flat: cython.int = 0
    stuck: cython.int = 0
    closing: cython.bint = False
    calming: cython.double = _CLOSING_DAMPING
    tube.mu = mu
    measure(tube, False)
    off = _multipliers(tube, n, 0.0, _OFF_AGAIN if again else 1.0)
    # No point that misses much more than the first one passes the filter: on long intervals, steps in h miss by a thousand times that.
    tube.seen[0, 0] = -_BEYOND
    tube.seen[0, 1] = _WORSE * max(tube.missed, _LEAST_MISS)
    for it in range(most):
        residual = tube.most
        if it > 0:
            solved = tube.mu <= mu_end and off < tube.mu and size < 1e-3
            if residual < tube.exact and (closing or solved):
                return Found(1, it, residual, off)
            if residual < _CLOSE and off < _OFF_NEAR * tube.mu and part > 0.5:
                if near and tube.mu <= mu_end and residual < _NEAR:
                    return Found(1, it, residual, off)
                if tube.mu > mu_end:
                    tube.mu = _fallen(tube.mu, mu_end)
                    count = 1
        closing |= it >= most - _CLOSING
        if closing:
            # Steps become those of the least change, so that residuals fall with their squares.
            damping = calming
            calming *= _CHANGE
        damping = _direction(tube, damping)
        if damping < 0.0:
            return Found(-1, it, residual, off)
        steps = _limits(tube, n)
        size = steps.size
        # The filter takes in the present point.
        tube.seen[count, 0] = _cost(tube)
        tube.seen[count, 1] = tube.missed
        count += 1
        last = phi
        part = _searched(tube, n, count, steps.primal)
        phi = _cost(tube)
        if not phi < 1e308:
            return Found(-1, it, residual, off)
        level = tube.mu <= mu_end and residual < _NEARLY and fabs(phi - last) < _FLAT * fabs(phi)
        flat = flat + 1 if level else 0
        stuck = stuck + 1 if part < _STUCK else 0
        if stuck == _HOPELESS and residual > _CLOSE:
            return Found(0, it, residual, off)
        closing |= flat > 1 or stuck == _HOPELESS
        damping = _next_damping(damping, part, residual)
        _accept(tube, n, part)
        off = _multipliers(tube, n, steps.dual, _OFF)
        if not off < 1e300:
            return Found(-1, it, residual, off)
    return Found(tube.most < tube.exact, most, tube.most, off)


def solve(
    tube: Tube,
    mu: cython.double,
    mu_end: cython.double,
    most: cython.int,
    near: cython.bint = False,
    again: cython.bint = False,
):
    """Solve; 1 means that the motion is exact, 0 that `most` iterations were not enough for that, -1 that no step was found.

    `near` ends the search where the barrier parameter would fall below `mu_end`; `again` goes on with the multipliers of the search before.
    """
    found: Found
    with cython.nogil:
        if tube.n == 2:
            found = _solved(tube, 2, mu, mu_end, most, near, again)
        elif tube.n == 3:
            found = _solved(tube, 3, mu, mu_end, most, near, again)
        else:
            found = _solved(tube, tube.n, mu, mu_end, most, near, again)
    return found
