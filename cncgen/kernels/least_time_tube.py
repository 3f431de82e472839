"""Least time through a row of nodes with room around each: an interior point in the time domain (docs/tube.md).

Node k lies on the plane through r_k across t_k, as near to given lines and points as its rows say. Between nodes the jerk of each
axis is constant for a time h_k of its own. All is scaled: positions are offsets from r_k over `unit`, velocities, accelerations
and jerks parts of their limits, times parts of h0_k. A state is (p, v, a) of axis after axis, a control the jerks and h.

The problem is solved as Wächter and Biegler (2006) do (primal-dual barrier, exact Hessian, filter), each Newton step by a Riccati
recursion (Rao, Wright and Rawlings (1998)), so the work goes with the number of nodes.
"""

import cython
from cython.cimports.libc.math import fabs, log, sqrt

#: Weight of the squares of what is held by dual regularisation: places across the planes, and the state at the end.
_RHO = cython.declare(cython.double, 1e7)
#: Part of the way to a bound that a step may go.
_TAU = cython.declare(cython.double, 0.99)
#: Largest ratio of a multiplier to its central value, and of that to it (Wächter and Biegler (2006), eq. 16).
_OFF = cython.declare(cython.double, 1e10)
#: A step is halved so often at most.
_HALVINGS = cython.declare(cython.int, 6)
#: The barrier parameter µ falls to µ^(11/8), at most this part of itself, once the residual and, in parts of the
#: parameter, the products of slacks and multipliers are near.
_FALL = cython.declare(cython.double, 0.2)
_NEAR = cython.declare(cython.double, 1e-3)
_OFF_NEAR = cython.declare(cython.double, 10.0)
#: Damping: once the residual is below the first number, a step of less than this part of its length multiplies by `_CHANGE` what is
#: added to the Hessian, within these bounds; a longer step divides it.
_SETTLED = cython.declare(cython.double, 1e-2)
_SHORT = cython.declare(cython.double, 0.1)
_LEAST_DAMPING = cython.declare(cython.double, 1e-4)
_FIRST_DAMPING = cython.declare(cython.double, 1e-3)
_MOST_DAMPING = cython.declare(cython.double, 0.1)
_CHANGE = cython.declare(cython.double, 4.0)
#: Damping beyond which the Hessian is taken without the curvature of the motion.
_CONVEX = cython.declare(cython.double, 10.0)
#: The largest residual of a motion, after all iterations; before that it has to be `Tube.exact`.
_EXACT = cython.declare(cython.double, 1e-7)
#: The search ends where two steps in a row change the cost by less than this part of it, or so many iterations before the last one.
#: Then steps with much damping make the motion exact.
_FLAT = cython.declare(cython.double, 1e-6)
_CLOSING = cython.declare(cython.int, 12)
_CLOSING_DAMPING = cython.declare(cython.double, 1.0)
#: Cost of a step of mean length.
_COST = cython.declare(cython.double, 0.02)


@cython.cclass
class Tube:
    """The problem, its solution so far, and what an iteration works on. `n` axes, `steps` intervals.

    `x` and `u` are the first guess and then the solution. Rows of node k are ``first[k]`` to ``first[k + 1]`` of `rows`, each
    an offset o = (r_k - c)/unit, a direction d (0 for a point) and unit/ρ: |(1 - d dᵀ)(p + o)| unit ≤ ρ. Where `between` is
    above 0, 1 over a speed, velocities and that speed are bounded between nodes as well: the middle ordinate v + a h/2 of the
    parabola of the velocity is, and with those at its ends all of it. The search goes on until no scaled state is missed by `exact`.
    """

    n: cython.Py_ssize_t
    steps: cython.Py_ssize_t
    calm: cython.double
    mu: cython.double
    curvature: cython.double
    V: cython.double[::1]
    A: cython.double[::1]
    J: cython.double[::1]
    weight: cython.double[::1]
    r: cython.double[:, ::1]
    t: cython.double[:, ::1]
    h0: cython.double[::1]
    first: cython.longlong[::1]
    rows: cython.double[:, ::1]
    feed: cython.double[::1]
    between: cython.double[::1]
    hlow: cython.double[::1]
    hhigh: cython.double[::1]
    goal: cython.double[::1]
    exact: cython.double
    cost: cython.double
    x: cython.double[:, ::1]
    u: cython.double[:, ::1]
    x2: cython.double[:, ::1]
    u2: cython.double[:, ::1]
    dx: cython.double[:, ::1]
    du: cython.double[:, ::1]
    lam: cython.double[:, ::1]
    lam2: cython.double[:, ::1]
    nu: cython.double[::1]
    nu2: cython.double[::1]
    lamT: cython.double[::1]
    lamT2: cython.double[::1]
    zx: cython.double[:, ::1]
    dzx: cython.double[:, ::1]
    zu: cython.double[:, ::1]
    dzu: cython.double[:, ::1]
    zr: cython.double[::1]
    dzr: cython.double[::1]
    zf: cython.double[::1]
    dzf: cython.double[::1]
    zm: cython.double[:, ::1]
    dzm: cython.double[:, ::1]
    P: cython.double[:, ::1]
    q: cython.double[:, ::1]
    K: cython.double[:, ::1]
    w: cython.double[::1]
    seen: cython.double[:, ::1]

    def __init__(self, problem, work):
        self.V, self.A, self.J, self.weight = problem.V, problem.A, problem.J, problem.weight
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
        self.P, self.q, self.K, self.w, self.seen = work.P, work.q, work.K, work.w, work.seen
        self.n = len(self.V)
        self.steps = len(self.h0)
        self.cost = _COST * self.steps / sum(self.h0)
        self.mu = 1e-3
        self.curvature = 1.0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _row_slack(
    rows: cython.double[:, ::1],
    m: cython.Py_ssize_t,
    x: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    n: cython.Py_ssize_t,
) -> cython.double:
    """Return 1 - |(1 - d dᵀ)(p + o)|² (unit/ρ)²."""
    i: cython.Py_ssize_t
    y: cython.double
    along: cython.double = 0.0
    square: cython.double = 0.0
    for i in range(n):
        y = x[k, 3 * i] + rows[m, i]
        along += y * rows[m, n + i]
        square += y * y
    return 1.0 - (square - along * along) * rows[m, 2 * n] * rows[m, 2 * n]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _feed_slack(tube: Tube, x: cython.double[:, ::1], k: cython.Py_ssize_t) -> cython.double:
    i: cython.Py_ssize_t
    v: cython.double
    square: cython.double = 0.0
    for i in range(tube.n):
        v = tube.V[i] * x[k, 3 * i + 1]
        square += tube.weight[i] * v * v
    return 1.0 - square * tube.feed[k] * tube.feed[k]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _middle(
    tube: Tube, x: cython.double[:, ::1], u: cython.double[:, ::1], k: cython.Py_ssize_t, i: cython.Py_ssize_t
) -> cython.double:
    """Return the middle ordinate of an axis's velocity on an interval."""
    return x[k, 3 * i + 1] + 0.5 * tube.A[i] / tube.V[i] * tube.h0[k] * u[k, tube.n] * x[k, 3 * i + 2]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _middle_feed(
    tube: Tube, x: cython.double[:, ::1], u: cython.double[:, ::1], k: cython.Py_ssize_t
) -> cython.double:
    i: cython.Py_ssize_t
    v: cython.double
    square: cython.double = 0.0
    for i in range(tube.n):
        v = tube.V[i] * tube.between[k] * _middle(tube, x, u, k, i)
        square += tube.weight[i] * v * v
    return 1.0 - square


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _middle_slack(
    tube: Tube, x: cython.double[:, ::1], u: cython.double[:, ::1], k: cython.Py_ssize_t, e: cython.Py_ssize_t
) -> cython.double:
    """Return slack `e` of an interval: two bounds an axis, then the speed."""
    if e == 2 * tube.n:
        return _middle_feed(tube, x, u, k)
    return 1.0 + _middle(tube, x, u, k, e // 2) if e % 2 == 0 else 1.0 - _middle(tube, x, u, k, e // 2)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _add_middle(
    tube: Tube,
    k: cython.Py_ssize_t,
    controls: cython.bint,
    M: cython.Py_ssize_t,
    S: cython.Py_ssize_t,
    G: cython.Py_ssize_t,
) -> cython.void:
    """Add the rows of an interval to what belongs to h (`controls`), or to the state alone."""
    n: cython.Py_ssize_t = tube.n
    N: cython.Py_ssize_t = 3 * n
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    o: cython.Py_ssize_t = S + n * (N + 1)
    f: cython.Py_ssize_t
    mu: cython.double = tube.mu
    y: cython.double
    z: cython.double
    c: cython.double
    ga: cython.double
    gh: cython.double
    g: cython.double
    bend: cython.double
    weight: cython.double
    size: cython.double
    sf: cython.double = _middle_feed(tube, tube.x, tube.u, k)
    zf: cython.double = tube.zm[k, 2 * n]
    w: cython.double[::1] = tube.w
    P: cython.double[:, ::1] = tube.P
    total: cython.double = 0.0
    for i in range(n):
        y = _middle(tube, tube.x, tube.u, k, i)
        c = 0.5 * tube.A[i] / tube.V[i] * tube.h0[k]
        ga = c * tube.u[k, n]
        gh = c * tube.x[k, 3 * i + 2]
        size = tube.V[i] * tube.between[k]
        size = tube.weight[i] * size * size
        weight = tube.zm[k, 2 * i] / (1.0 + y) + tube.zm[k, 2 * i + 1] / (1.0 - y) + 2.0 * zf * size
        bend = tube.zm[k, 2 * i + 1] - tube.zm[k, 2 * i] + 2.0 * zf * size * y
        g = mu / (1.0 - y) - mu / (1.0 + y) + mu / sf * 2.0 * size * y
        # This axis's part of the speed's gradient, without its sign.
        w[i] = 2.0 * size * y
        total += w[i] * gh
        f = 3 * i
        if controls:
            w[M] += weight * gh * gh
            w[G] += g * gh
            w[o + f + 1] += weight * gh
            w[o + f + 2] += weight * ga * gh + bend * c
        else:
            P[k, (f + 1) * (N + 1)] += weight
            P[k, (f + 2) * (N + 1)] += weight * ga * ga
            P[k, (f + 1) * N + f + 2] += weight * ga
            P[k, (f + 2) * N + f + 1] += weight * ga
            tube.q[k, f + 1] += g
            tube.q[k, f + 2] += g * ga
    z = zf / sf
    if controls:
        w[M] += z * total * total
        for i in range(n):
            w[o + 3 * i + 1] += z * total * w[i]
            w[o + 3 * i + 2] += z * total * w[i] * 0.5 * tube.A[i] / tube.V[i] * tube.h0[k] * tube.u[k, n]
        return
    for i in range(n):
        ga = 0.5 * tube.A[i] / tube.V[i] * tube.h0[k] * tube.u[k, n]
        for j in range(n):
            c = 0.5 * tube.A[j] / tube.V[j] * tube.h0[k] * tube.u[k, n]
            y = z * w[i] * w[j]
            P[k, (3 * i + 1) * N + 3 * j + 1] += y
            P[k, (3 * i + 1) * N + 3 * j + 2] += y * c
            P[k, (3 * i + 2) * N + 3 * j + 1] += y * ga
            P[k, (3 * i + 2) * N + 3 * j + 2] += y * ga * c


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _defect(
    tube: Tube,
    x: cython.double[:, ::1],
    u: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    i: cython.Py_ssize_t,
    out: cython.double[::1],
    at: cython.Py_ssize_t,
) -> cython.void:
    """Write what axis `i` misses node k + 1 by, as (p, v, a), to ``out[at:]``."""
    n: cython.Py_ssize_t = tube.n
    h: cython.double = u[k, n] * tube.h0[k]
    v: cython.double = tube.V[i] * x[k, 3 * i + 1]
    a: cython.double = tube.A[i] * x[k, 3 * i + 2]
    j: cython.double = tube.J[i] * u[k, i]
    out[at] = (
        x[k, 3 * i] - x[k + 1, 3 * i] + (tube.r[k, i] - tube.r[k + 1, i] + h * (v + h * (a / 2 + h * j / 6)))
    )
    out[at + 1] = (v + h * (a + h * j / 2)) / tube.V[i] - x[k + 1, 3 * i + 1]
    out[at + 2] = (a + h * j) / tube.A[i] - x[k + 1, 3 * i + 2]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _merit(
    tube: Tube, x: cython.double[:, ::1], u: cython.double[:, ::1], which: cython.int
) -> cython.double:
    """Return the barrier function of a point (`which` 0), the sum of what it misses (1) or the largest of that (2)."""
    n: cython.Py_ssize_t = tube.n
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    m: cython.Py_ssize_t
    total: cython.double = 0.0
    most: cython.double = 0.0
    product: cython.double
    y: cython.double
    if which == 0:
        for k in range(tube.steps):
            product = (u[k, n] - tube.hlow[k]) * (tube.hhigh[k] - u[k, n])
            for i in range(n):
                product *= 1.0 - u[k, i] * u[k, i]
                total += 0.5 * tube.calm * tube.cost * tube.h0[k] * u[k, i] * u[k, i]
            total += tube.cost * tube.h0[k] * u[k, n] - tube.mu * log(product)
            if tube.between[k] > 0.0:
                product = 1.0
                for i in range(2 * n + 1):
                    y = _middle_slack(tube, x, u, k, i)
                    if y <= 0.0:
                        return 1e301
                    product *= y
                total -= tube.mu * log(product)
            if k > 0:
                product = _feed_slack(tube, x, k)
                for i in range(n):
                    y = x[k, 3 * i + 1]
                    product *= 1.0 - y * y
                    y = x[k, 3 * i + 2]
                    product *= 1.0 - y * y
                for m in range(tube.first[k], tube.first[k + 1]):
                    product *= _row_slack(tube.rows, m, x, k, n)
                total -= tube.mu * log(product)
        return total
    for k in range(tube.steps):
        for i in range(n):
            _defect(tube, x, u, k, i, tube.w, 0)
            y = fabs(tube.w[0]) + fabs(tube.w[1]) + fabs(tube.w[2])
            total += y
            most = max(most, y)
        if k > 0:
            y = 0.0
            for i in range(n):
                y += tube.t[k, i] * x[k, 3 * i]
            total += fabs(y)
            most = max(most, fabs(y))
    for i in range(3 * n):
        y = fabs(x[tube.steps, i] - tube.goal[i])
        total += y
        most = max(most, y)
    return total if which == 1 else most


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _node(
    tube: Tube, k: cython.Py_ssize_t, P: cython.double[:, ::1], q: cython.double[:, ::1], delta: cython.double
) -> cython.void:
    """Add the bounds and rows of node k to the Hessian and the gradient of the cost to go from there."""
    n: cython.Py_ssize_t = tube.n
    N: cython.Py_ssize_t = 3 * n
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    e: cython.Py_ssize_t
    m: cython.Py_ssize_t
    y: cython.double
    s: cython.double
    z: cython.double
    c: cython.double
    along: cython.double
    low: cython.double
    high: cython.double
    mu: cython.double = tube.mu
    x: cython.double[:, ::1] = tube.x
    g: cython.double[::1] = tube.w
    rows: cython.double[:, ::1] = tube.rows
    for i in range(n):
        for e in range(1, 3):
            y = x[k, 3 * i + e]
            low = 1.0 + y
            high = 1.0 - y
            j = 4 * i + 2 * (e - 1)
            P[k, (3 * i + e) * (N + 1)] += tube.zx[k, j] / low + tube.zx[k, j + 1] / high
            q[k, 3 * i + e] += mu / high - mu / low
        P[k, 3 * i * (N + 1)] += delta
    # The plane of the node.
    y = tube.nu[k]
    for i in range(n):
        y += _RHO * tube.t[k, i] * x[k, 3 * i]
    for i in range(n):
        q[k, 3 * i] += tube.t[k, i] * y
        for j in range(n):
            P[k, 3 * i * N + 3 * j] += _RHO * tube.t[k, i] * tube.t[k, j]
    # Lines and points that it is near to: slack s, its gradient g, its Hessian -2 c (1 - d dᵀ).
    for m in range(tube.first[k], tube.first[k + 1]):
        along = 0.0
        for i in range(n):
            along += (x[k, 3 * i] + rows[m, i]) * rows[m, n + i]
        c = rows[m, 2 * n] * rows[m, 2 * n]
        s = 1.0
        for i in range(n):
            y = x[k, 3 * i] + rows[m, i]
            s -= c * (y - along * rows[m, n + i]) * (y - along * rows[m, n + i])
            g[i] = -2.0 * c * (y - along * rows[m, n + i])
        z = tube.zr[m]
        for i in range(n):
            q[k, 3 * i] -= mu / s * g[i]
            P[k, 3 * i * (N + 1)] += 2.0 * c * z
            for j in range(n):
                P[k, 3 * i * N + 3 * j] += z / s * g[i] * g[j] - 2.0 * c * z * rows[m, n + i] * rows[m, n + j]
    if tube.feed[k] > 0.0:
        s = _feed_slack(tube, x, k)
        z = tube.zf[k]
        for i in range(n):
            c = tube.V[i] * tube.feed[k]
            c = tube.weight[i] * c * c
            g[i] = -2.0 * c * x[k, 3 * i + 1]
            q[k, 3 * i + 1] -= mu / s * g[i]
            P[k, (3 * i + 1) * (N + 1)] += 2.0 * c * z
        for i in range(n):
            for j in range(n):
                P[k, (3 * i + 1) * N + 3 * j + 1] += z / s * g[i] * g[j]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _backward(tube: Tube, delta: cython.double) -> cython.bint:
    """Work the cost to go backwards and keep the gains; return False where the Hessian over the controls is not positive."""
    n: cython.Py_ssize_t = tube.n
    N: cython.Py_ssize_t = 3 * n
    U: cython.Py_ssize_t = n + 1
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    f: cython.Py_ssize_t
    o: cython.Py_ssize_t
    P: cython.double[:, ::1] = tube.P
    q: cython.double[:, ::1] = tube.q
    K: cython.double[:, ::1] = tube.K
    x: cython.double[:, ::1] = tube.x
    u: cython.double[:, ::1] = tube.u
    lam: cython.double[:, ::1] = tube.lam
    w: cython.double[::1] = tube.w
    h: cython.double
    h0: cython.double
    v: cython.double
    a: cython.double
    jerk: cython.double
    lp: cython.double
    lv: cython.double
    la: cython.double
    y: cython.double
    z: cython.double
    p0: cython.double
    p1: cython.double
    p2: cython.double
    low: cython.double
    high: cython.double
    mu: cython.double = tube.mu
    # Places in the work array: T (3 an axis), b (3), c (3), f (3), y = P f + p, Pc, Y = P T, W = P b, and M over controls.
    T: cython.Py_ssize_t = 3 * n
    B: cython.Py_ssize_t = T + N
    C: cython.Py_ssize_t = B + N
    F: cython.Py_ssize_t = C + N
    Yf: cython.Py_ssize_t = F + N
    Pc: cython.Py_ssize_t = Yf + N
    Y: cython.Py_ssize_t = Pc + N
    W: cython.Py_ssize_t = Y + N * N
    G: cython.Py_ssize_t = W + N * n
    M: cython.Py_ssize_t = G + U
    S: cython.Py_ssize_t = M + U * U
    last: cython.Py_ssize_t = tube.steps
    for i in range(N * N):
        P[last, i] = 0.0
    for i in range(N):
        P[last, i * (N + 1)] = _RHO
        q[last, i] = tube.lamT[i] + _RHO * (x[last, i] - tube.goal[i])
    for k in range(last - 1, -1, -1):
        h0 = tube.h0[k]
        h = u[k, n] * h0
        z = tube.cost * h0
        low = u[k, n] - tube.hlow[k]
        high = tube.hhigh[k] - u[k, n]
        for i in range(U * U):
            w[M + i] = 0.0
        w[M + U * U - 1] = tube.zu[k, 2 * n] / low + tube.zu[k, 2 * n + 1] / high + delta
        w[G + n] = z - mu / low + mu / high
        for i in range(n):
            low = 1.0 + u[k, i]
            high = 1.0 - u[k, i]
            w[M + i * (U + 1)] = (
                tube.zu[k, 2 * i] / low + tube.zu[k, 2 * i + 1] / high + tube.calm * z + delta
            )
            w[G + i] = mu / high - mu / low + tube.calm * z * u[k, i]
            v = tube.V[i] * x[k, 3 * i + 1]
            a = tube.A[i] * x[k, 3 * i + 2]
            jerk = tube.J[i] * u[k, i]
            w[T + 3 * i] = tube.V[i] * h
            w[T + 3 * i + 1] = 0.5 * tube.A[i] * h * h
            w[T + 3 * i + 2] = tube.A[i] * h / tube.V[i]
            w[B + 3 * i] = tube.J[i] * h * h * h / 6
            w[B + 3 * i + 1] = 0.5 * tube.J[i] * h * h / tube.V[i]
            w[B + 3 * i + 2] = tube.J[i] * h / tube.A[i]
            w[C + 3 * i] = h0 * (v + h * (a + 0.5 * h * jerk))
            w[C + 3 * i + 1] = h0 * (a + h * jerk) / tube.V[i]
            w[C + 3 * i + 2] = h0 * jerk / tube.A[i]
            _defect(tube, x, u, k, i, w, F + 3 * i)
            lp = tube.curvature * lam[k, 3 * i]
            lv = tube.curvature * lam[k, 3 * i + 1] / tube.V[i]
            la = tube.curvature * lam[k, 3 * i + 2] / tube.A[i]
            w[M + U * U - 1] += h0 * h0 * (lp * (a + h * jerk) + lv * jerk)
            w[M + n * U + i] += tube.J[i] * h0 * (lp * h * h / 2 + lv * h + la)
            # Of h and the state; c' P T is added below.
            o = S + n * (N + 1) + 3 * i
            w[o] = 0.0
            w[o + 1] = tube.V[i] * h0 * lp
            w[o + 2] = tube.A[i] * h0 * (lp * h + lv)
        if tube.between[k] > 0.0:
            _add_middle(tube, k, True, M + U * U - 1, S, G + n)
        # P times what acts on the next state.
        for i in range(N):
            p0 = q[k + 1, i]
            p1 = 0.0
            for j in range(n):
                o = i * N + 3 * j
                p0 += (
                    P[k + 1, o] * w[F + 3 * j]
                    + P[k + 1, o + 1] * w[F + 3 * j + 1]
                    + P[k + 1, o + 2] * w[F + 3 * j + 2]
                )
                p1 += (
                    P[k + 1, o] * w[C + 3 * j]
                    + P[k + 1, o + 1] * w[C + 3 * j + 1]
                    + P[k + 1, o + 2] * w[C + 3 * j + 2]
                )
            w[Yf + i] = p0
            w[Pc + i] = p1
            for j in range(n):
                o = i * N + 3 * j
                p0 = P[k + 1, o]
                p1 = P[k + 1, o + 1]
                p2 = P[k + 1, o + 2]
                w[Y + o] = p0
                w[Y + o + 1] = p0 * w[T + 3 * j] + p1
                w[Y + o + 2] = p0 * w[T + 3 * j + 1] + p1 * w[T + 3 * j + 2] + p2
                w[W + i * n + j] = p0 * w[B + 3 * j] + p1 * w[B + 3 * j + 1] + p2 * w[B + 3 * j + 2]
        # M over the controls, over controls and states, and the gradient.
        y = 0.0
        z = 0.0
        for i in range(N):
            y += w[C + i] * w[Pc + i]
            z += w[C + i] * w[Yf + i]
        w[M + U * U - 1] += y
        w[G + n] += z
        for i in range(n):
            o = 3 * i
            w[G + i] += w[B + o] * w[Yf + o] + w[B + o + 1] * w[Yf + o + 1] + w[B + o + 2] * w[Yf + o + 2]
            w[M + n * U + i] += (
                w[B + o] * w[Pc + o] + w[B + o + 1] * w[Pc + o + 1] + w[B + o + 2] * w[Pc + o + 2]
            )
            for j in range(i + 1):
                w[M + i * U + j] += (
                    w[B + o] * w[W + o * n + j]
                    + w[B + o + 1] * w[W + (o + 1) * n + j]
                    + w[B + o + 2] * w[W + (o + 2) * n + j]
                )
            for j in range(N):
                w[S + i * (N + 1) + j] = (
                    w[B + o] * w[Y + o * N + j]
                    + w[B + o + 1] * w[Y + (o + 1) * N + j]
                    + w[B + o + 2] * w[Y + (o + 2) * N + j]
                )
            # c' P T, axis by axis.
            f = S + n * (N + 1) + o
            w[f] += w[Pc + o]
            w[f + 1] += w[Pc + o] * w[T + o] + w[Pc + o + 1]
            w[f + 2] += w[Pc + o] * w[T + o + 1] + w[Pc + o + 1] * w[T + o + 2] + w[Pc + o + 2]
        for i in range(U):
            w[S + i * (N + 1) + N] = w[G + i]
        # M = L L', and L S = (M over controls and states, gradient).
        for i in range(U):
            for j in range(i + 1):
                y = w[M + i * U + j]
                for f in range(j):
                    y -= w[M + i * U + f] * w[M + j * U + f]
                if i == j:
                    if y <= 1e-14:
                        return False
                    w[M + i * U + i] = 1.0 / sqrt(y)
                else:
                    w[M + i * U + j] = y * w[M + j * U + j]
            for f in range(i):
                z = w[M + i * U + f]
                for j in range(N + 1):
                    w[S + i * (N + 1) + j] -= z * w[S + f * (N + 1) + j]
            z = w[M + i * U + i]
            for j in range(N + 1):
                w[S + i * (N + 1) + j] *= z
        # The cost to go: T' Y - S' S.
        for i in range(n):
            o = 3 * i
            for j in range(N):
                p0 = w[Y + o * N + j]
                p1 = w[Y + (o + 1) * N + j]
                p2 = w[Y + (o + 2) * N + j]
                P[k, o * N + j] = p0
                P[k, (o + 1) * N + j] = p0 * w[T + o] + p1
                P[k, (o + 2) * N + j] = p0 * w[T + o + 1] + p1 * w[T + o + 2] + p2
            p0 = w[Yf + o]
            p1 = w[Yf + o + 1]
            p2 = w[Yf + o + 2]
            q[k, o] = p0
            q[k, o + 1] = p0 * w[T + o] + p1
            q[k, o + 2] = p0 * w[T + o + 1] + p1 * w[T + o + 2] + p2
            P[k, (o + 1) * (N + 1)] += delta
            P[k, (o + 2) * (N + 1)] += delta
        if tube.between[k] > 0.0:
            _add_middle(tube, k, False, 0, 0, 0)
        for f in range(U):
            o = S + f * (N + 1)
            z = w[o + N]
            for i in range(N):
                y = w[o + i]
                q[k, i] -= y * z
                for j in range(N):
                    P[k, i * N + j] -= y * w[o + j]
        # Gains: K = -L'⁻¹ S.
        for i in range(U - 1, -1, -1):
            for j in range(N + 1):
                w[S + i * (N + 1) + j] *= w[M + i * U + i]
            for f in range(i):
                z = w[M + i * U + f]
                for j in range(N + 1):
                    w[S + f * (N + 1) + j] -= z * w[S + i * (N + 1) + j]
        for i in range(U * (N + 1)):
            K[k, i] = -w[S + i]
        if k > 0:
            _node(tube, k, P, q, delta)
            for i in range(N):
                for j in range(i):
                    y = 0.5 * (P[k, i * N + j] + P[k, j * N + i])
                    P[k, i * N + j] = y
                    P[k, j * N + i] = y
    return True


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _forward(tube: Tube) -> cython.void:
    """Work out the Newton step and the multipliers after it."""
    n: cython.Py_ssize_t = tube.n
    N: cython.Py_ssize_t = 3 * n
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    y: cython.double
    h: cython.double
    h0: cython.double
    v: cython.double
    a: cython.double
    jerk: cython.double
    dh: cython.double
    dx: cython.double[:, ::1] = tube.dx
    du: cython.double[:, ::1] = tube.du
    x: cython.double[:, ::1] = tube.x
    u: cython.double[:, ::1] = tube.u
    w: cython.double[::1] = tube.w
    for i in range(N):
        dx[0, i] = 0.0
    for k in range(tube.steps):
        for i in range(n + 1):
            y = tube.K[k, i * (N + 1) + N]
            for j in range(N):
                y += tube.K[k, i * (N + 1) + j] * dx[k, j]
            du[k, i] = y
        h0 = tube.h0[k]
        h = u[k, n] * h0
        dh = du[k, n] * h0
        for i in range(n):
            v = tube.V[i] * x[k, 3 * i + 1]
            a = tube.A[i] * x[k, 3 * i + 2]
            jerk = tube.J[i] * u[k, i]
            _defect(tube, x, u, k, i, w, 0)
            dx[k + 1, 3 * i] = (
                w[0]
                + dx[k, 3 * i]
                + h
                * (
                    tube.V[i] * dx[k, 3 * i + 1]
                    + h * (0.5 * tube.A[i] * dx[k, 3 * i + 2] + h * tube.J[i] * du[k, i] / 6)
                )
                + dh * (v + h * (a + 0.5 * h * jerk))
            )
            dx[k + 1, 3 * i + 1] = (
                w[1]
                + dx[k, 3 * i + 1]
                + (h * (tube.A[i] * dx[k, 3 * i + 2] + 0.5 * h * tube.J[i] * du[k, i]) + dh * (a + h * jerk))
                / tube.V[i]
            )
            dx[k + 1, 3 * i + 2] = (
                w[2] + dx[k, 3 * i + 2] + (h * tube.J[i] * du[k, i] + dh * jerk) / tube.A[i]
            )
        for i in range(N):
            y = tube.q[k + 1, i]
            for j in range(N):
                y += tube.P[k + 1, i * N + j] * dx[k + 1, j]
            tube.lam2[k, i] = y
        if k > 0:
            y = 0.0
            for i in range(n):
                y += tube.t[k, i] * (x[k, 3 * i] + dx[k, 3 * i])
            tube.nu2[k] = tube.nu[k] + _RHO * y
    for i in range(N):
        tube.lamT2[i] = tube.lamT[i] + _RHO * (x[tube.steps, i] + dx[tube.steps, i] - tube.goal[i])


_Steps = cython.struct(primal=cython.double, dual=cython.double, size=cython.double)


@cython.cfunc
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
    """Work out the steps of the multipliers of two bounds, and how far the step may go (as 1 over the part)."""
    a: cython.double = (mu - z[k, at] * d) / low - z[k, at]
    b: cython.double = (mu + z[k, at + 1] * d) / high - z[k, at + 1]
    dz[k, at] = a
    dz[k, at + 1] = b
    steps.primal = max(steps.primal, max(-d / low, d / high))
    steps.dual = max(steps.dual, max(-a / z[k, at], -b / z[k, at + 1]))
    steps.size = max(steps.size, fabs(d))
    return steps


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _curve(s: cython.double, g: cython.double, c: cython.double) -> cython.double:
    """Return 1 over the part of a step up to which s + g α - c α² keeps (1 - τ) s."""
    left: cython.double = _TAU * s
    root: cython.double = sqrt(g * g + 4.0 * c * left)
    # α = (g + root) / (2 c) = 2 left / (root - g)
    return _TAU * (root - g) / (2.0 * left)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _middle_after(
    tube: Tube, k: cython.Py_ssize_t, e: cython.Py_ssize_t, part: cython.double
) -> cython.double:
    """Return slack `e` of an interval after a part of the step."""
    n: cython.Py_ssize_t = tube.n
    i: cython.Py_ssize_t
    y: cython.double
    v: cython.double
    square: cython.double = 0.0
    h: cython.double = 0.5 * tube.h0[k] * (tube.u[k, n] + part * tube.du[k, n])
    for i in range(n):
        if e < 2 * n and i != e // 2:
            continue
        y = tube.x[k, 3 * i + 1] + part * tube.dx[k, 3 * i + 1]
        y += tube.A[i] / tube.V[i] * h * (tube.x[k, 3 * i + 2] + part * tube.dx[k, 3 * i + 2])
        if e < 2 * n:
            return 1.0 + y if e % 2 == 0 else 1.0 - y
        v = tube.V[i] * tube.between[k] * y
        square += tube.weight[i] * v * v
    return 1.0 - square


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _limits(tube: Tube) -> _Steps:
    """Work out the steps of the multipliers, and how far unknowns and multipliers may go."""
    n: cython.Py_ssize_t = tube.n
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    e: cython.Py_ssize_t
    m: cython.Py_ssize_t
    mu: cython.double = tube.mu
    s: cython.double
    g: cython.double
    c: cython.double
    y: cython.double
    d: cython.double
    z: cython.double
    along: cython.double
    dalong: cython.double
    steps: _Steps = _Steps(1e-12, 1e-12, 0.0)
    x: cython.double[:, ::1] = tube.x
    u: cython.double[:, ::1] = tube.u
    dx: cython.double[:, ::1] = tube.dx
    du: cython.double[:, ::1] = tube.du
    rows: cython.double[:, ::1] = tube.rows
    for k in range(tube.steps):
        for i in range(n):
            steps = _box(tube.zu, tube.dzu, k, 2 * i, 1.0 + u[k, i], 1.0 - u[k, i], du[k, i], mu, steps)
        steps = _box(
            tube.zu, tube.dzu, k, 2 * n, u[k, n] - tube.hlow[k], tube.hhigh[k] - u[k, n], du[k, n], mu, steps
        )
        if k == 0:
            continue
        for i in range(n):
            for e in range(1, 3):
                y = x[k, 3 * i + e]
                steps = _box(
                    tube.zx, tube.dzx, k, 4 * i + 2 * (e - 1), 1.0 + y, 1.0 - y, dx[k, 3 * i + e], mu, steps
                )
        for m in range(tube.first[k], tube.first[k + 1]):
            along = 0.0
            dalong = 0.0
            for i in range(n):
                along += (x[k, 3 * i] + rows[m, i]) * rows[m, n + i]
                dalong += dx[k, 3 * i] * rows[m, n + i]
            s = 1.0
            g = 0.0
            c = 0.0
            z = rows[m, 2 * n] * rows[m, 2 * n]
            for i in range(n):
                y = x[k, 3 * i] + rows[m, i] - along * rows[m, n + i]
                d = dx[k, 3 * i] - dalong * rows[m, n + i]
                s -= z * y * y
                g -= 2.0 * z * y * d
                c += z * d * d
            steps.primal = max(steps.primal, _curve(s, g, c))
            z = tube.zr[m]
            y = mu / s - z - z / s * g
            tube.dzr[m] = y
            steps.dual = max(steps.dual, -y / z)
        if tube.feed[k] > 0.0:
            s = _feed_slack(tube, x, k)
            g = 0.0
            c = 0.0
            for i in range(n):
                y = tube.V[i] * tube.feed[k]
                y = tube.weight[i] * y * y
                g -= 2.0 * y * x[k, 3 * i + 1] * dx[k, 3 * i + 1]
                c += y * dx[k, 3 * i + 1] * dx[k, 3 * i + 1]
            steps.primal = max(steps.primal, _curve(s, g, c))
            z = tube.zf[k]
            y = mu / s - z - z / s * g
            tube.dzf[k] = y
            steps.dual = max(steps.dual, -y / z)
    steps.primal = min(1.0, _TAU / steps.primal)
    for k in range(tube.steps):
        if tube.between[k] <= 0.0:
            continue
        along = 0.0
        for i in range(n):
            c = 0.5 * tube.A[i] / tube.V[i] * tube.h0[k]
            d = dx[k, 3 * i + 1] + c * (u[k, n] * dx[k, 3 * i + 2] + du[k, n] * x[k, 3 * i + 2])
            y = _middle(tube, x, u, k, i)
            s = tube.V[i] * tube.between[k]
            along -= 2.0 * tube.weight[i] * s * s * y * d
            for e in range(2):
                s = 1.0 + y if e == 0 else 1.0 - y
                g = d if e == 0 else -d
                z = tube.zm[k, 2 * i + e]
                g = mu / s - z - z / s * g
                tube.dzm[k, 2 * i + e] = g
                steps.dual = max(steps.dual, -g / z)
        s = _middle_feed(tube, x, u, k)
        z = tube.zm[k, 2 * n]
        g = mu / s - z - z / s * along
        tube.dzm[k, 2 * n] = g
        steps.dual = max(steps.dual, -g / z)
        for i in range(2 * n + 1):
            s = _middle_slack(tube, x, u, k, i)
            for m in range(60):
                if _middle_after(tube, k, i, steps.primal) >= (1.0 - _TAU) * s:
                    break
                steps.primal *= 0.8
    steps.dual = min(1.0, _TAU / steps.dual)
    return steps


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _kept(z: cython.double, centre: cython.double) -> cython.double:
    return min(max(z, centre / _OFF), centre * _OFF)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _multipliers(tube: Tube, part: cython.double, reset: cython.bint) -> cython.double:
    """Move the multipliers by a part of their step (or set them on the central path); return how far products are off mu."""
    n: cython.Py_ssize_t = tube.n
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    m: cython.Py_ssize_t
    mu: cython.double = tube.mu
    s: cython.double
    y: cython.double
    off: cython.double = 0.0
    for k in range(tube.steps):
        for i in range(2 * n + 2):
            if i < 2 * n:
                y = tube.u[k, i // 2]
                s = 1.0 + y if i % 2 == 0 else 1.0 - y
            else:
                s = tube.u[k, n] - tube.hlow[k] if i % 2 == 0 else tube.hhigh[k] - tube.u[k, n]
            tube.zu[k, i] = mu / s if reset else _kept(tube.zu[k, i] + part * tube.dzu[k, i], mu / s)
            off = max(off, fabs(tube.zu[k, i] * s - mu))
        if tube.between[k] > 0.0:
            for i in range(2 * n + 1):
                s = _middle_slack(tube, tube.x, tube.u, k, i)
                tube.zm[k, i] = mu / s if reset else _kept(tube.zm[k, i] + part * tube.dzm[k, i], mu / s)
                off = max(off, fabs(tube.zm[k, i] * s - mu))
        if k == 0:
            continue
        for i in range(4 * n):
            y = tube.x[k, 3 * (i // 4) + 1 + (i % 4) // 2]
            s = 1.0 + y if i % 2 == 0 else 1.0 - y
            tube.zx[k, i] = mu / s if reset else _kept(tube.zx[k, i] + part * tube.dzx[k, i], mu / s)
            off = max(off, fabs(tube.zx[k, i] * s - mu))
        for m in range(tube.first[k], tube.first[k + 1]):
            s = _row_slack(tube.rows, m, tube.x, k, n)
            tube.zr[m] = mu / s if reset else _kept(tube.zr[m] + part * tube.dzr[m], mu / s)
            off = max(off, fabs(tube.zr[m] * s - mu))
        if tube.feed[k] > 0.0:
            s = _feed_slack(tube, tube.x, k)
            tube.zf[k] = mu / s if reset else _kept(tube.zf[k] + part * tube.dzf[k], mu / s)
            off = max(off, fabs(tube.zf[k] * s - mu))
    return off


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _taken(tube: Tube, count: cython.Py_ssize_t, phi: cython.double, c: cython.double) -> cython.bint:
    """Tell whether a filter lets a point pass: beside each pair that it has, less of one of the two."""
    i: cython.Py_ssize_t
    if not phi < 1e300:
        return False
    for i in range(count):
        if not (c <= max(0.99999 * tube.seen[i, 1], 1e-7) or phi <= tube.seen[i, 0] - 1e-5 * tube.seen[i, 1]):
            return False
    return True


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _moved(tube: Tube, part: cython.double) -> cython.void:
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    for k in range(tube.steps + 1):
        for i in range(3 * tube.n):
            tube.x2[k, i] = tube.x[k, i] + part * tube.dx[k, i]
    for k in range(tube.steps):
        for i in range(tube.n + 1):
            tube.u2[k, i] = tube.u[k, i] + part * tube.du[k, i]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _searched(tube: Tube, part: cython.double, count: cython.Py_ssize_t) -> cython.double:
    """Halve a step until the filter lets it pass, or often enough; return its part. The present point joins the filter."""
    back: cython.int
    tube.seen[count, 0] = _merit(tube, tube.x, tube.u, 0)
    tube.seen[count, 1] = _merit(tube, tube.x, tube.u, 1)
    for back in range(_HALVINGS):
        _moved(tube, part)
        if back == _HALVINGS - 1 or _taken(
            tube, count + 1, _merit(tube, tube.x2, tube.u2, 0), _merit(tube, tube.x2, tube.u2, 1)
        ):
            break
        part *= 0.5
    return part


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _accept(tube: Tube, part: cython.double) -> cython.void:
    """Take the point that the step leads to, and the multipliers of the equations."""
    n: cython.Py_ssize_t = tube.n
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
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


Found = cython.struct(status=cython.int, iterations=cython.int, residual=cython.double, off=cython.double)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def solve(tube: Tube, mu: cython.double, mu_end: cython.double, most: cython.int) -> Found:
    """Solve; 1 means that the motion is exact, 0 that `most` iterations were not enough for that, -1 that no step was found."""
    it: cython.int
    count: cython.Py_ssize_t = 0
    delta: cython.double = 0.0
    damping: cython.double
    off: cython.double
    part: cython.double = 1.0
    residual: cython.double = 0.0
    size: cython.double = 1.0
    phi: cython.double = 0.0
    last: cython.double
    fourth: cython.double
    flat: cython.int = 0
    closing: cython.bint = False
    steps: _Steps
    tube.mu = mu
    off = _multipliers(tube, 0.0, True)
    for it in range(most):
        residual = _merit(tube, tube.x, tube.u, 2)
        if it > 0:
            if residual < tube.exact and (closing or (tube.mu <= mu_end and off < tube.mu and size < 1e-3)):
                return Found(1, it, residual, off)
            if residual < _NEAR and off < _OFF_NEAR * tube.mu and tube.mu > mu_end and part > 0.5:
                fourth = sqrt(sqrt(tube.mu))
                tube.mu = max(mu_end, min(_FALL * tube.mu, tube.mu * fourth * sqrt(fourth)))
                count = 0
        closing |= it >= most - _CLOSING
        damping = _CLOSING_DAMPING if closing else delta
        tube.curvature = 1.0
        while not _backward(tube, damping):
            damping = max(_LEAST_DAMPING, _CHANGE * damping)
            if damping > _CONVEX:
                # The multipliers are far off: the step without the curvature of the motion has a positive Hessian.
                tube.curvature = 0.0
            if damping > 1e12:
                return Found(-1, it, residual, off)
        _forward(tube)
        steps = _limits(tube)
        size = steps.size
        last = phi
        part = _searched(tube, steps.primal, count)
        count += 1
        phi = _merit(tube, tube.x2, tube.u2, 0)
        if not phi < 1e308:
            return Found(-1, it, residual, off)
        flat = (
            flat + 1 if tube.mu <= mu_end and residual < 1e-4 and fabs(phi - last) < _FLAT * fabs(phi) else 0
        )
        closing |= flat > 1
        if part < _SHORT and residual < _SETTLED:
            delta = min(_MOST_DAMPING, max(_FIRST_DAMPING, _CHANGE * damping))
        else:
            delta = damping / _CHANGE if damping > _LEAST_DAMPING else 0.0
        _accept(tube, part)
        off = _multipliers(tube, steps.dual, False)
        if not off < 1e300:
            return Found(-1, it, residual, off)
    residual = _merit(tube, tube.x, tube.u, 2)
    return Found(residual < _EXACT, most, residual, off)
