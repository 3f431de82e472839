# cython: infer_types=True
"""The problem of `cncgen.kernels.least_time_tube`, and the values of a point: slacks of its bounds, and what its motion misses.

Node k lies on the plane through r_k across t_k, as near to given lines and points as its rows say. Between nodes the jerk of each
axis is constant for a time h_k of its own. All is scaled: positions are offsets from r_k over `unit`, velocities, accelerations
and jerks parts of their limits, times parts of h0_k. A state is (p, v, a) of axis after axis, a control the jerks and h.

Functions take the number of axes as an argument: `measure` hands on 2 and 3 as constants, for which compilers unroll the loops.
"""

import cython
from cython.cimports.libc.math import fabs, log

#: Weight of the squares of residuals under dual regularisation: places across the planes, and the state at the end.
RHO = 1e7
#: A barrier function of a point beyond its bounds.
BEYOND = 1e300
_BEYOND = cython.declare(cython.double, BEYOND)
#: A product of slacks that is as small, or as large as its reciprocal, is not multiplied on.
_SMALL = cython.declare(cython.double, 1e-20)


@cython.cclass
class Tube:
    """The problem, its current solution, and the working arrays of an iteration. `n` axes (9 at most), `steps` intervals.

    `x` and `u` are the first guess and then the solution. Rows of node k are ``first[k]`` to ``first[k + 1]`` of `rows`, each
    an offset o = (r_k - c)/unit, a direction d (0 for a point), unit/ρ and b, s²: |(1 - d dᵀ)(p + b a + o)| unit ≤ ρ, where a is not
    scaled by its limit but by `unit`. `weight`, (steps + 1, n), is 1 for the axes over which the feed of a node is meant, and between nodes for those of both. Where `between` is above 0, 1 over a speed, velocities and that speed are bounded between nodes as well: the middle ordinate v + a h/2 of the
    parabola of the velocity is, and with those at its ends all of it. The search goes on until no scaled state is missed by `exact`.

    Of the point that was measured last: `value`, its cost, `logs`, the sum of the logarithms of its slacks, `missed`, the sum of its
    residuals, `most`, the largest of them without planes; slacks and their gradients of rows and of the feed, those of the speed
    between nodes with the middle ordinates, and the residuals, `miss`, of each interval.
    """

    def __init__(self, problem, work):
        self.V, self.weight = problem.V, problem.weight
        self.AV, self.JA = problem.A / problem.V, problem.J / problem.A
        self.r, self.t, self.h0 = problem.r, problem.t, problem.h0
        self.first, self.rows, self.feed = problem.first, problem.rows, problem.feed
        self.between = problem.between
        self.hlow, self.hhigh, self.goal = problem.hlow, problem.hhigh, problem.goal
        self.x, self.u, self.calm, self.exact = problem.x, problem.u, problem.calm, problem.exact
        self.x2, self.u2, self.dx, self.du = work.x2, work.u2, work.dx, work.du
        self.lam, self.lam2, self.nu, self.nu2 = work.lam, work.lam2, work.nu, work.nu2
        self.lamT, self.lamT2 = work.lamT, work.lamT2
        self.zx, self.dzx, self.zu, self.dzu = work.zx, work.dzx, work.zu, work.dzu
        self.zr, self.dzr, self.zf, self.dzf = work.zr, work.dzr, work.zf, work.dzf
        self.zm, self.dzm = work.zm, work.dzm
        self.P, self.q, self.K, self.seen = work.P, work.q, work.K, work.seen
        self.row_slack, self.row_slope, self.miss = work.row_slack, work.row_slope, work.miss
        self.feed_slack, self.feed_slope = work.feed_slack, work.feed_slope
        self.middle_slack, self.middle = work.middle_slack, work.middle
        self.n = len(self.V)
        self.steps = len(self.h0)
        self.cost = problem.cost
        self.mu = 1e-3
        self.curvature = 1.0
        self.rho = RHO


# Each bound is a slack s ≥ 0 with a multiplier z. The box of an unknown y has two, 1 + y and 1 - y (the time: hlow and hhigh).


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _row(
    tube: Tube,
    n: cython.Py_ssize_t,
    m: cython.Py_ssize_t,
    k: cython.Py_ssize_t,
    x: cython.double[:, ::1],
) -> cython.double:
    """Return the slack 1 - |(1 - d dᵀ)(p + b a + o)|² (unit/ρ)² of a row, and keep it with its gradient over p."""
    along: cython.double = 0.0
    s: cython.double = 1.0
    c: cython.double = tube.rows[m, 2 * n] * tube.rows[m, 2 * n]
    b: cython.double = tube.rows[m, 2 * n + 1]
    for i in range(n):
        tube.row_slope[m, i] = x[k, 3 * i] + b * tube.V[i] * tube.AV[i] * x[k, 3 * i + 2] + tube.rows[m, i]
        along += tube.row_slope[m, i] * tube.rows[m, n + i]
    for i in range(n):
        y = tube.row_slope[m, i] - along * tube.rows[m, n + i]
        s -= c * y * y
        tube.row_slope[m, i] = -2.0 * c * y
    tube.row_slack[m] = s
    return s


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _feed(
    tube: Tube,
    n: cython.Py_ssize_t,
    k: cython.Py_ssize_t,
    x: cython.double[:, ::1],
) -> cython.double:
    """Return the slack 1 - Σ c v² of the feed at a node, c = weight (V feed)², and keep it with its gradient over the velocities."""
    s: cython.double = 1.0
    for i in range(n):
        y = tube.V[i] * tube.feed[k]
        c = tube.weight[k, i] * y * y
        y = x[k, 3 * i + 1]
        s -= c * y * y
        tube.feed_slope[k, i] = -2.0 * c * y
    tube.feed_slack[k] = s
    return s


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _middles(
    tube: Tube,
    n: cython.Py_ssize_t,
    k: cython.Py_ssize_t,
    x: cython.double[:, ::1],
    u: cython.double[:, ::1],
) -> cython.double:
    """Return the slack 1 - Σ c y² of the speed of an interval, c = weight (V between)²; keep it and the middle ordinates y of velocities."""
    s: cython.double = 1.0
    for i in range(n):
        y = x[k, 3 * i + 1] + 0.5 * tube.AV[i] * tube.h0[k] * u[k, n] * x[k, 3 * i + 2]
        z = tube.V[i] * tube.between[k]
        s -= tube.weight[k, i] * tube.weight[k + 1, i] * z * z * y * y
        tube.middle[k, i] = y
    tube.middle_slack[k] = s
    return s


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _missed(
    tube: Tube,
    n: cython.Py_ssize_t,
    k: cython.Py_ssize_t,
    x: cython.double[:, ::1],
    u: cython.double[:, ::1],
) -> cython.void:
    """Keep the residual f of the motion of an interval at node k + 1."""
    h: cython.double = u[k, n] * tube.h0[k]
    for i in range(n):
        ha = h * tube.AV[i]
        hj = h * tube.JA[i] * u[k, i]
        v = x[k, 3 * i + 1]
        a = x[k, 3 * i + 2]
        tube.miss[k, 3 * i] = (x[k, 3 * i] - x[k + 1, 3 * i]) + (
            (tube.r[k, i] - tube.r[k + 1, i]) + h * tube.V[i] * (v + ha * (a / 2 + hj / 6))
        )
        tube.miss[k, 3 * i + 1] = (v + ha * (a + hj / 2)) - x[k + 1, 3 * i + 1]
        tube.miss[k, 3 * i + 2] = (a + hj) - x[k + 1, 3 * i + 2]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _measure(
    tube: Tube, n: cython.Py_ssize_t, x: cython.double[:, ::1], u: cython.double[:, ::1]
) -> cython.void:
    """Work out the values of a point."""
    product: cython.double = 1.0
    y: cython.double
    plane: cython.double
    cost: cython.double = 0.0
    logs: cython.double = 0.0
    missed: cython.double = 0.0
    most: cython.double = 0.0
    for k in range(tube.steps):
        # One logarithm for the slacks of several nodes.
        if not (_SMALL < product and product * _SMALL < 1.0):
            logs += log(product)
            product = 1.0
        product *= (u[k, n] - tube.hlow[k]) * (tube.hhigh[k] - u[k, n])
        y = 0.0
        for i in range(n):
            product *= 1.0 - u[k, i] * u[k, i]
            y += u[k, i] * u[k, i]
        cost += tube.cost * tube.h0[k] * (u[k, n] + 0.5 * tube.calm * y)
        if tube.between[k] > 0.0:
            y = _middles(tube, n, k, x, u)
            product *= y
            for i in range(n):
                if fabs(tube.middle[k, i]) >= 1.0 or y <= 0.0:
                    cost = 2.0 * _BEYOND
                product *= 1.0 - tube.middle[k, i] * tube.middle[k, i]
        _missed(tube, n, k, x, u)
        for i in range(n):
            y = fabs(tube.miss[k, 3 * i]) + fabs(tube.miss[k, 3 * i + 1]) + fabs(tube.miss[k, 3 * i + 2])
            missed += y
            most = max(most, y)
        if k == 0:
            continue
        product *= _feed(tube, n, k, x)
        plane = 0.0
        for i in range(n):
            plane += tube.t[k, i] * x[k, 3 * i]
            y = x[k, 3 * i + 1]
            product *= 1.0 - y * y
            y = x[k, 3 * i + 2]
            product *= 1.0 - y * y
        for m in range(tube.first[k], tube.first[k + 1]):
            product *= _row(tube, n, m, k, x)
        # Where along its row a node lies matters little: its motion is as exact beside the plane.
        missed += fabs(plane)
    for i in range(3 * n):
        y = fabs(x[tube.steps, i] - tube.goal[i])
        missed += y
        most = max(most, y)
    tube.value, tube.logs, tube.missed, tube.most = cost, logs + log(product), missed, most


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def measure(tube: Tube, tried: cython.bint) -> cython.void:
    """Work out the values of the current point, or of the one that was `tried`."""
    x: cython.double[:, ::1] = tube.x2 if tried else tube.x
    u: cython.double[:, ::1] = tube.u2 if tried else tube.u
    if tube.n == 2:
        _measure(tube, 2, x, u)
    elif tube.n == 3:
        _measure(tube, 3, x, u)
    else:
        _measure(tube, tube.n, x, u)
