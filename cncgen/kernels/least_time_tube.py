"""Least time through a row of nodes with room around each: an interior point in the time domain (docs/tube.md).

Node k lies on the plane through r_k across t_k, as near to given lines and points as its rows say. Between nodes the jerk of each
axis is constant for a time h_k of its own. All is scaled: positions are offsets from r_k over `unit`, velocities, accelerations
and jerks parts of their limits, times parts of h0_k. A state is (p, v, a) of axis after axis, a control the jerks and h.

The problem is solved as Wächter and Biegler (2006) do (primal-dual barrier, exact Hessian, filter), each Newton step by a Riccati
recursion (Rao, Wright and Rawlings (1998)), so the work goes with the number of nodes.

Functions take the number of axes as an argument: `solve` hands on 2 and 3 as constants, for which compilers unroll the loops.
"""

import cython
from cython.cimports.libc.math import fabs, log, sqrt

#: Weight of the squares of residuals under dual regularisation: places across the planes, and the state at the end.
_RHO = cython.declare(cython.double, 1e7)
#: Part of the way to a bound that a step may go.
_TAU = cython.declare(cython.double, 0.99)
#: Largest ratio of a multiplier to its central value, and of that to it (Wächter and Biegler (2006), eq. 16); and where a search goes on
#: after its problem has changed.
_OFF = cython.declare(cython.double, 1e10)
_OFF_AGAIN = cython.declare(cython.double, 10.0)
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
#: The search ends where two steps in a row change the cost by less than this part of it, or so many iterations before the last one.
#: Then steps with much damping, each with `_CHANGE` times that of the one before, make the motion exact.
_FLAT = cython.declare(cython.double, 1e-6)
_CLOSING = cython.declare(cython.int, 12)
_CLOSING_DAMPING = cython.declare(cython.double, 1.0)
#: Largest residual as a multiple of that of the first point, and the least residual that counts: an exact first point must be left.
_WORSE = cython.declare(cython.double, 4.0)
_LEAST_MISS = cython.declare(cython.double, 1.0)
#: A barrier function of a point beyond its bounds.
_BEYOND = cython.declare(cython.double, 1e300)


@cython.cclass
class Tube:
    """The problem, its current solution, and the working arrays of an iteration. `n` axes (9 at most), `steps` intervals.

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
    rho: cython.double
    V: cython.double[::1]
    AV: cython.double[::1]
    JA: cython.double[::1]
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
    seen: cython.double[:, ::1]

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
        self.n = len(self.V)
        self.steps = len(self.h0)
        self.cost = problem.cost
        self.mu = 1e-3
        self.curvature = 1.0
        self.rho = _RHO


# Bounds. Each is a slack s ≥ 0 with a multiplier z. The box of an unknown y has two, 1 + y and 1 - y (the time: hlow and hhigh).


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
    g: cython.p_double,
) -> cython.double:
    """Return the slack 1 - |(1 - d dᵀ)(p + o)|² (unit/ρ)² of a row, and write its gradient."""
    i: cython.Py_ssize_t
    along: cython.double = 0.0
    s: cython.double = 1.0
    y: cython.double
    c: cython.double = tube.rows[m, 2 * n] * tube.rows[m, 2 * n]
    for i in range(n):
        g[i] = x[k, 3 * i] + tube.rows[m, i]
        along += g[i] * tube.rows[m, n + i]
    for i in range(n):
        y = g[i] - along * tube.rows[m, n + i]
        s -= c * y * y
        g[i] = -2.0 * c * y
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
    c: cython.p_double,
    g: cython.p_double,
) -> cython.double:
    """Return the slack 1 - Σ c v² of the feed at a node; write the c of each axis, and the gradient over the velocities."""
    i: cython.Py_ssize_t
    s: cython.double = 1.0
    y: cython.double
    for i in range(n):
        y = tube.V[i] * tube.feed[k]
        c[i] = tube.weight[i] * y * y
        y = x[k, 3 * i + 1]
        s -= c[i] * y * y
        g[i] = -2.0 * c[i] * y
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
    y: cython.p_double,
    c: cython.p_double,
) -> cython.double:
    """Write the middle ordinates y of the velocities of an interval, and the c of the slack 1 - Σ c y² of its speed; return that."""
    i: cython.Py_ssize_t
    s: cython.double = 1.0
    z: cython.double
    for i in range(n):
        y[i] = x[k, 3 * i + 1] + 0.5 * tube.AV[i] * tube.h0[k] * u[k, n] * x[k, 3 * i + 2]
        z = tube.V[i] * tube.between[k]
        c[i] = tube.weight[i] * z * z
        s -= c[i] * y[i] * y[i]
    return s


_Measure = cython.struct(cost=cython.double, logs=cython.double, missed=cython.double, most=cython.double)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _measure(
    tube: Tube, n: cython.Py_ssize_t, x: cython.double[:, ::1], u: cython.double[:, ::1]
) -> _Measure:
    """Return the cost of a point, the sum of the logarithms of its slacks, the sum of its residuals, and the largest of them without
    planes."""
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    m: cython.Py_ssize_t
    out: _Measure = _Measure(0.0, 0.0, 0.0, 0.0)
    product: cython.double
    y: cython.double
    plane: cython.double
    F = cython.declare(cython.double[27])
    g = cython.declare(cython.double[9])
    c = cython.declare(cython.double[9])
    for k in range(tube.steps):
        product = (u[k, n] - tube.hlow[k]) * (tube.hhigh[k] - u[k, n])
        y = 0.0
        for i in range(n):
            product *= 1.0 - u[k, i] * u[k, i]
            y += u[k, i] * u[k, i]
        out.cost += tube.cost * tube.h0[k] * (u[k, n] + 0.5 * tube.calm * y)
        out.logs += log(product)
        if tube.between[k] > 0.0:
            product = _middles(tube, n, k, x, u, g, c)
            for i in range(n):
                if fabs(g[i]) >= 1.0 or product <= 0.0:
                    out.cost = 2.0 * _BEYOND
                product *= 1.0 - g[i] * g[i]
            out.logs += log(product)
        _missed(tube, n, k, x, u, F)
        for i in range(n):
            y = fabs(F[3 * i]) + fabs(F[3 * i + 1]) + fabs(F[3 * i + 2])
            out.missed += y
            out.most = max(out.most, y)
        if k == 0:
            continue
        product = _feed(tube, n, k, x, c, g)
        plane = 0.0
        for i in range(n):
            plane += tube.t[k, i] * x[k, 3 * i]
            y = x[k, 3 * i + 1]
            product *= 1.0 - y * y
            y = x[k, 3 * i + 2]
            product *= 1.0 - y * y
        for m in range(tube.first[k], tube.first[k + 1]):
            product *= _row(tube, n, m, k, x, g)
        out.logs += log(product)
        # Where along its row a node lies matters little: its motion is as exact beside the plane.
        out.missed += fabs(plane)
    for i in range(3 * n):
        y = fabs(x[tube.steps, i] - tube.goal[i])
        out.missed += y
        out.most = max(out.most, y)
    return out


# The Newton step. Of an interval, x⁺ = A x + B j + c h + f for changes of state, jerks and time; A and B go axis by axis.


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
    F: cython.p_double,
) -> cython.void:
    """Write the residual f of the motion of an interval at node k + 1."""
    i: cython.Py_ssize_t
    h: cython.double = u[k, n] * tube.h0[k]
    ha: cython.double
    hj: cython.double
    v: cython.double
    a: cython.double
    for i in range(n):
        ha = h * tube.AV[i]
        hj = h * tube.JA[i] * u[k, i]
        v = x[k, 3 * i + 1]
        a = x[k, 3 * i + 2]
        F[3 * i] = (x[k, 3 * i] - x[k + 1, 3 * i]) + (
            (tube.r[k, i] - tube.r[k + 1, i]) + h * tube.V[i] * (v + ha * (a / 2 + hj / 6))
        )
        F[3 * i + 1] = (v + ha * (a + hj / 2)) - x[k + 1, 3 * i + 1]
        F[3 * i + 2] = (a + hj) - x[k + 1, 3 * i + 2]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _linear(
    tube: Tube,
    n: cython.Py_ssize_t,
    k: cython.Py_ssize_t,
    A: cython.p_double,
    B: cython.p_double,
    C: cython.p_double,
) -> cython.void:
    """Write what changes move node k + 1 by: A of an axis is ((1, A0, A1), (0, 1, A2), (0, 0, 1))."""
    i: cython.Py_ssize_t
    h: cython.double = tube.u[k, n] * tube.h0[k]
    ha: cython.double
    hj: cython.double
    v: cython.double
    a: cython.double
    j: cython.double
    for i in range(n):
        ha = h * tube.AV[i]
        hj = h * tube.JA[i]
        v = tube.x[k, 3 * i + 1]
        a = tube.x[k, 3 * i + 2]
        j = tube.u[k, i]
        A[3 * i] = h * tube.V[i]
        A[3 * i + 1] = 0.5 * A[3 * i] * ha
        A[3 * i + 2] = ha
        B[3 * i] = A[3 * i] * ha * hj / 6
        B[3 * i + 1] = 0.5 * ha * hj
        B[3 * i + 2] = hj
        C[3 * i] = tube.h0[k] * tube.V[i] * (v + ha * (a + 0.5 * hj * j))
        C[3 * i + 1] = tube.h0[k] * tube.AV[i] * (a + hj * j)
        C[3 * i + 2] = tube.h0[k] * tube.JA[i] * j


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _node(tube: Tube, n: cython.Py_ssize_t, k: cython.Py_ssize_t, delta: cython.double) -> cython.void:
    """Begin the cost to go from node k, ½ xᵀP x + qᵀx, with its bounds, rows and plane. Of P, what lies above its axes' diagonal is left."""
    N: cython.Py_ssize_t = 3 * n
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    e: cython.Py_ssize_t
    m: cython.Py_ssize_t
    y: cython.double
    s: cython.double
    z: cython.double
    low: cython.double
    high: cython.double
    across: cython.double
    P: cython.double[:, ::1] = tube.P
    q: cython.double[:, ::1] = tube.q
    g = cython.declare(cython.double[9])
    c = cython.declare(cython.double[9])
    for i in range(N * N):
        P[k, i] = 0.0
    across = tube.nu[k]
    for i in range(n):
        across += _RHO * tube.t[k, i] * tube.x[k, 3 * i]
    for i in range(n):
        q[k, 3 * i] = tube.t[k, i] * across
        P[k, 3 * i * (N + 1)] = delta
        for j in range(i + 1):
            P[k, 3 * i * N + 3 * j] += _RHO * tube.t[k, i] * tube.t[k, j]
        for e in range(2):
            low = 1.0 + tube.x[k, 3 * i + e + 1]
            high = 1.0 - tube.x[k, 3 * i + e + 1]
            y = 1.0 / (low * high)
            j = 4 * i + 2 * e
            P[k, (3 * i + e + 1) * (N + 1)] = delta + (tube.zx[k, j] * high + tube.zx[k, j + 1] * low) * y
            q[k, 3 * i + e + 1] = tube.mu * (low - high) * y
    for m in range(tube.first[k], tube.first[k + 1]):
        s = 1.0 / _row(tube, n, m, k, tube.x, g)
        z = tube.zr[m]
        y = 2.0 * z * tube.rows[m, 2 * n] * tube.rows[m, 2 * n]
        for i in range(n):
            q[k, 3 * i] -= tube.mu * s * g[i]
            P[k, 3 * i * (N + 1)] += y
            for j in range(i + 1):
                P[k, 3 * i * N + 3 * j] += z * s * g[i] * g[j] - y * tube.rows[m, n + i] * tube.rows[m, n + j]
    if tube.feed[k] > 0.0:
        s = 1.0 / _feed(tube, n, k, tube.x, c, g)
        z = tube.zf[k]
        for i in range(n):
            q[k, 3 * i + 1] -= tube.mu * s * g[i]
            P[k, (3 * i + 1) * (N + 1)] += 2.0 * c[i] * z
            for j in range(i + 1):
                P[k, (3 * i + 1) * N + 3 * j + 1] += z * s * g[i] * g[j]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _interval(
    tube: Tube,
    n: cython.Py_ssize_t,
    k: cython.Py_ssize_t,
    delta: cython.double,
    M: cython.p_double,
    S: cython.p_double,
) -> cython.void:
    """Begin the Hessian over the controls (M, its lower half) and over controls and states, beside the gradient (S), of an interval."""
    N: cython.Py_ssize_t = 3 * n
    U: cython.Py_ssize_t = n + 1
    i: cython.Py_ssize_t
    h0: cython.double = tube.h0[k]
    h: cython.double = tube.u[k, n] * h0
    time: cython.double = tube.cost * h0
    low: cython.double
    high: cython.double
    y: cython.double
    lp: cython.double
    lv: cython.double
    la: cython.double
    for i in range(U * U):
        M[i] = 0.0
    for i in range(U):
        if i < n:
            low = 1.0 + tube.u[k, i]
            high = 1.0 - tube.u[k, i]
        else:
            low = tube.u[k, n] - tube.hlow[k]
            high = tube.hhigh[k] - tube.u[k, n]
        y = 1.0 / (low * high)
        M[i * (U + 1)] = delta + (tube.zu[k, 2 * i] * high + tube.zu[k, 2 * i + 1] * low) * y
        S[i * (N + 1) + N] = tube.mu * (low - high) * y
    S[n * (N + 1) + N] += time
    for i in range(n):
        M[i * (U + 1)] += tube.calm * time
        S[i * (N + 1) + N] += tube.calm * time * tube.u[k, i]
        # The curvature of the motion: h with itself, with the jerk, the velocity and the acceleration.
        lp = tube.curvature * h0 * tube.V[i] * tube.lam[k, 3 * i]
        lv = tube.curvature * h0 * tube.lam[k, 3 * i + 1]
        la = tube.curvature * h0 * tube.lam[k, 3 * i + 2]
        y = h * tube.JA[i]
        M[n * U + n] += (
            h0
            * tube.AV[i]
            * (lp * (tube.x[k, 3 * i + 2] + y * tube.u[k, i]) + lv * tube.JA[i] * tube.u[k, i])
        )
        M[n * U + i] += tube.JA[i] * (tube.AV[i] * h * (0.5 * lp * h + lv) + la)
        S[n * (N + 1) + 3 * i] = 0.0
        S[n * (N + 1) + 3 * i + 1] = lp
        S[n * (N + 1) + 3 * i + 2] = tube.AV[i] * (lp * h + lv)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _held(
    tube: Tube, n: cython.Py_ssize_t, k: cython.Py_ssize_t, M: cython.p_double, S: cython.p_double
) -> cython.void:
    """Add the bounds of the middle ordinates of an interval, y = v + b a with b = h AV/2."""
    N: cython.Py_ssize_t = 3 * n
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    o: cython.Py_ssize_t = n * (N + 1)
    f: cython.Py_ssize_t
    z: cython.double
    b: cython.double
    gh: cython.double
    g: cython.double
    bend: cython.double
    weight: cython.double
    s: cython.double
    total: cython.double = 0.0
    P: cython.double[:, ::1] = tube.P
    y = cython.declare(cython.double[9])
    c = cython.declare(cython.double[9])
    s = _middles(tube, n, k, tube.x, tube.u, y, c)
    z = tube.zm[k, 2 * n]
    for i in range(n):
        b = 0.5 * tube.AV[i] * tube.h0[k]
        gh = b * tube.x[k, 3 * i + 2]
        weight = tube.zm[k, 2 * i] / (1.0 + y[i]) + tube.zm[k, 2 * i + 1] / (1.0 - y[i]) + 2.0 * z * c[i]
        bend = tube.zm[k, 2 * i + 1] - tube.zm[k, 2 * i] + 2.0 * z * c[i] * y[i]
        g = tube.mu / (1.0 - y[i]) - tube.mu / (1.0 + y[i]) + 2.0 * tube.mu / s * c[i] * y[i]
        # This axis's part of the speed's gradient, without its sign.
        y[i] *= 2.0 * c[i]
        total += y[i] * gh
        f = 3 * i
        M[n * (n + 2)] += weight * gh * gh
        S[o + N] += g * gh
        S[o + f + 1] += weight * gh
        S[o + f + 2] += bend * b
        b *= tube.u[k, n]
        S[o + f + 2] += weight * b * gh
        if k > 0:
            P[k, (f + 1) * (N + 1)] += weight
            P[k, (f + 2) * (N + 1)] += weight * b * b
            P[k, (f + 2) * N + f + 1] += weight * b
            tube.q[k, f + 1] += g
            tube.q[k, f + 2] += g * b
    z /= s
    M[n * (n + 2)] += z * total * total
    for i in range(n):
        b = 0.5 * tube.AV[i] * tube.h0[k] * tube.u[k, n]
        S[o + 3 * i + 1] += z * total * y[i]
        S[o + 3 * i + 2] += z * total * y[i] * b
        if k == 0:
            continue
        for j in range(i + 1):
            g = 0.5 * tube.AV[j] * tube.h0[k] * tube.u[k, n]
            s = z * y[i] * y[j]
            P[k, (3 * i + 1) * N + 3 * j + 1] += s
            P[k, (3 * i + 2) * N + 3 * j + 1] += s * b
            P[k, (3 * i + 2) * N + 3 * j + 2] += s * b * g
            if j < i:
                P[k, (3 * i + 1) * N + 3 * j + 2] += s * g


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _carried(
    tube: Tube,
    n: cython.Py_ssize_t,
    k: cython.Py_ssize_t,
    A: cython.p_double,
    M: cython.p_double,
    S: cython.p_double,
    y: cython.p_double,
) -> cython.void:
    """Add the cost to go from node k + 1 to the Hessians over the controls; write its gradient y = P f + q after the motion."""
    N: cython.Py_ssize_t = 3 * n
    U: cython.Py_ssize_t = n + 1
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    o: cython.Py_ssize_t
    p0: cython.double
    p1: cython.double
    p2: cython.double
    P: cython.double[:, ::1] = tube.P
    B = cython.declare(cython.double[27])
    C = cython.declare(cython.double[27])
    F = cython.declare(cython.double[27])
    PC = cython.declare(cython.double[27])
    _linear(tube, n, k, A, B, C)
    _missed(tube, n, k, tube.x, tube.u, F)
    for i in range(N):
        y[i] = tube.q[k + 1, i]
        PC[i] = 0.0
    for j in range(N):
        p0 = F[j]
        p1 = C[j]
        for i in range(N):
            y[i] += P[k + 1, j * N + i] * p0
            PC[i] += P[k + 1, j * N + i] * p1
    for i in range(n):
        # P B of this axis, and with it the rows of its jerk.
        for j in range(N):
            o = 3 * i * N + j
            F[j] = (
                B[3 * i] * P[k + 1, o] + B[3 * i + 1] * P[k + 1, o + N] + B[3 * i + 2] * P[k + 1, o + 2 * N]
            )
        for j in range(n):
            p0 = F[3 * j]
            p1 = F[3 * j + 1]
            p2 = F[3 * j + 2]
            if j <= i:
                M[i * U + j] += B[3 * j] * p0 + B[3 * j + 1] * p1 + B[3 * j + 2] * p2
            o = i * (N + 1) + 3 * j
            S[o] = p0
            S[o + 1] = A[3 * j] * p0 + p1
            S[o + 2] = A[3 * j + 1] * p0 + A[3 * j + 2] * p1 + p2
        p0 = PC[3 * i]
        p1 = PC[3 * i + 1]
        p2 = PC[3 * i + 2]
        S[i * (N + 1) + N] += B[3 * i] * y[3 * i] + B[3 * i + 1] * y[3 * i + 1] + B[3 * i + 2] * y[3 * i + 2]
        M[n * U + i] += B[3 * i] * p0 + B[3 * i + 1] * p1 + B[3 * i + 2] * p2
        M[n * U + n] += C[3 * i] * p0 + C[3 * i + 1] * p1 + C[3 * i + 2] * p2
        o = n * (N + 1)
        S[o + N] += C[3 * i] * y[3 * i] + C[3 * i + 1] * y[3 * i + 1] + C[3 * i + 2] * y[3 * i + 2]
        o += 3 * i
        S[o] += p0
        S[o + 1] += A[3 * i] * p0 + p1
        S[o + 2] += A[3 * i + 1] * p0 + A[3 * i + 2] * p1 + p2


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _factored(n: cython.Py_ssize_t, M: cython.p_double, S: cython.p_double) -> cython.bint:
    """Replace M by L of M = L Lᵀ (1 over its diagonal) and S by L⁻¹ S; return False where M is not positive."""
    N: cython.Py_ssize_t = 3 * n
    U: cython.Py_ssize_t = n + 1
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    f: cython.Py_ssize_t
    y: cython.double
    for i in range(U):
        for j in range(i + 1):
            y = M[i * U + j]
            for f in range(j):
                y -= M[i * U + f] * M[j * U + f]
            if i == j:
                if y <= 1e-14:
                    return False
                M[i * U + i] = 1.0 / sqrt(y)
            else:
                M[i * U + j] = y * M[j * U + j]
        for f in range(i):
            for j in range(N + 1):
                S[i * (N + 1) + j] -= M[i * U + f] * S[f * (N + 1) + j]
        for j in range(N + 1):
            S[i * (N + 1) + j] *= M[i * U + i]
    return True


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _to_go(
    tube: Tube,
    n: cython.Py_ssize_t,
    k: cython.Py_ssize_t,
    A: cython.p_double,
    S: cython.p_double,
    y: cython.p_double,
) -> cython.void:
    """Add Aᵀ P⁺ A - SᵀS to P and Aᵀ y - Sᵀ s to q of node k, and fill in the other half of P."""
    N: cython.Py_ssize_t = 3 * n
    U: cython.Py_ssize_t = n + 1
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    e: cython.Py_ssize_t
    f: cython.Py_ssize_t
    o: cython.Py_ssize_t
    z: cython.double
    P: cython.double[:, ::1] = tube.P
    R = cython.declare(cython.double[9])
    for i in range(n):
        for j in range(i + 1):
            for e in range(3):
                o = (3 * i + e) * N + 3 * j
                R[3 * e] = P[k + 1, o]
                R[3 * e + 1] = P[k + 1, o] * A[3 * j] + P[k + 1, o + 1]
                R[3 * e + 2] = P[k + 1, o] * A[3 * j + 1] + P[k + 1, o + 1] * A[3 * j + 2] + P[k + 1, o + 2]
            for e in range(3):
                R[6 + e] += A[3 * i + 1] * R[e] + A[3 * i + 2] * R[3 + e]
                R[3 + e] += A[3 * i] * R[e]
            for e in range(3):
                for f in range(3):
                    P[k, (3 * i + e) * N + 3 * j + f] += R[3 * e + f]
        tube.q[k, 3 * i] += y[3 * i]
        tube.q[k, 3 * i + 1] += A[3 * i] * y[3 * i] + y[3 * i + 1]
        tube.q[k, 3 * i + 2] += A[3 * i + 1] * y[3 * i] + A[3 * i + 2] * y[3 * i + 1] + y[3 * i + 2]
    for i in range(N):
        z = tube.q[k, i]
        for o in range(U):
            z -= S[o * (N + 1) + i] * S[o * (N + 1) + N]
        tube.q[k, i] = z
        for j in range(i + 1):
            z = P[k, i * N + j]
            for o in range(U):
                z -= S[o * (N + 1) + i] * S[o * (N + 1) + j]
            P[k, i * N + j] = z
            P[k, j * N + i] = z


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _gains(
    tube: Tube, n: cython.Py_ssize_t, k: cython.Py_ssize_t, M: cython.p_double, S: cython.p_double
) -> cython.void:
    """Keep the gains of an interval, K = -L⁻ᵀ S: controls are K (x, 1)."""
    N: cython.Py_ssize_t = 3 * n
    U: cython.Py_ssize_t = n + 1
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    f: cython.Py_ssize_t
    for i in range(U - 1, -1, -1):
        for j in range(N + 1):
            S[i * (N + 1) + j] *= M[i * U + i]
        for f in range(i):
            for j in range(N + 1):
                S[f * (N + 1) + j] -= M[i * U + f] * S[i * (N + 1) + j]
    for i in range(U * (N + 1)):
        tube.K[k, i] = -S[i]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _backward(tube: Tube, n: cython.Py_ssize_t, delta: cython.double) -> cython.bint:
    """Work the cost to go backwards and keep the gains; return False where the Hessian over the controls is not positive."""
    N: cython.Py_ssize_t = 3 * n
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    last: cython.Py_ssize_t = tube.steps
    A = cython.declare(cython.double[27])
    M = cython.declare(cython.double[100])
    S = cython.declare(cython.double[280])
    y = cython.declare(cython.double[27])
    # The end is met whatever damps steps; planes then give way.
    tube.rho = _RHO * max(1.0, delta)
    for i in range(N * N):
        tube.P[last, i] = 0.0
    for i in range(N):
        tube.P[last, i * (N + 1)] = tube.rho
        tube.q[last, i] = tube.lamT[i] + tube.rho * (tube.x[last, i] - tube.goal[i])
    for k in range(last - 1, -1, -1):
        _interval(tube, n, k, delta, M, S)
        if k > 0:
            _node(tube, n, k, delta)
        if tube.between[k] > 0.0:
            _held(tube, n, k, M, S)
        _carried(tube, n, k, A, M, S, y)
        if not _factored(n, M, S):
            return False
        if k > 0:
            _to_go(tube, n, k, A, S, y)
        _gains(tube, n, k, M, S)
    return True


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _forward(tube: Tube, n: cython.Py_ssize_t) -> cython.void:
    """Work out the Newton step and the multipliers of the equations after it."""
    N: cython.Py_ssize_t = 3 * n
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    y: cython.double
    dx: cython.double[:, ::1] = tube.dx
    du: cython.double[:, ::1] = tube.du
    A = cython.declare(cython.double[27])
    B = cython.declare(cython.double[27])
    C = cython.declare(cython.double[27])
    F = cython.declare(cython.double[27])
    for i in range(N):
        dx[0, i] = 0.0
    for k in range(tube.steps):
        for i in range(n + 1):
            y = tube.K[k, i * (N + 1) + N]
            for j in range(N):
                y += tube.K[k, i * (N + 1) + j] * dx[k, j]
            du[k, i] = y
        _linear(tube, n, k, A, B, C)
        _missed(tube, n, k, tube.x, tube.u, F)
        for i in range(n):
            j = 3 * i
            y = A[j] * dx[k, j + 1] + A[j + 1] * dx[k, j + 2]
            dx[k + 1, j] = F[j] + (dx[k, j] + y) + (B[j] * du[k, i] + C[j] * du[k, n])
            dx[k + 1, j + 1] = (
                F[j + 1]
                + (dx[k, j + 1] + A[j + 2] * dx[k, j + 2])
                + (B[j + 1] * du[k, i] + C[j + 1] * du[k, n])
            )
            dx[k + 1, j + 2] = F[j + 2] + dx[k, j + 2] + (B[j + 2] * du[k, i] + C[j + 2] * du[k, n])
        for i in range(N):
            y = tube.q[k + 1, i]
            for j in range(N):
                y += tube.P[k + 1, i * N + j] * dx[k + 1, j]
            tube.lam2[k, i] = y
        if k > 0:
            y = 0.0
            for i in range(n):
                y += tube.t[k, i] * (tube.x[k, 3 * i] + dx[k, 3 * i])
            tube.nu2[k] = tube.nu[k] + _RHO * y
    for i in range(N):
        tube.lamT2[i] = tube.lamT[i] + tube.rho * (tube.x[tube.steps, i] + dx[tube.steps, i] - tube.goal[i])


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
    i: cython.Py_ssize_t
    m: cython.Py_ssize_t
    h: cython.double = tube.u[k, n]
    d: cython.double
    s: cython.double
    along: cython.double = 0.0
    square: cython.double
    kept: cython.bint
    a: cython.double
    y = cython.declare(cython.double[9])
    c = cython.declare(cython.double[9])
    s = _middles(tube, n, k, tube.x, tube.u, y, c)
    for i in range(n):
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
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    e: cython.Py_ssize_t
    m: cython.Py_ssize_t
    mu: cython.double = tube.mu
    s: cython.double
    y: cython.double
    d: cython.double
    along: cython.double
    # What steps are divided by, so that whole steps are the longest.
    steps: _Steps = _Steps(_TAU, _TAU, 0.0)
    x: cython.double[:, ::1] = tube.x
    u: cython.double[:, ::1] = tube.u
    dx: cython.double[:, ::1] = tube.dx
    du: cython.double[:, ::1] = tube.du
    g = cython.declare(cython.double[9])
    c = cython.declare(cython.double[9])
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
            s = _row(tube, n, m, k, x, g)
            y = 0.0
            d = 0.0
            along = 0.0
            for i in range(n):
                y += g[i] * dx[k, 3 * i]
                d += dx[k, 3 * i] * dx[k, 3 * i]
                along += dx[k, 3 * i] * tube.rows[m, n + i]
            d = (d - along * along) * tube.rows[m, 2 * n] * tube.rows[m, 2 * n]
            steps.primal = _curve(s, y, d, steps.primal)
            tube.dzr[m] = _beside(tube.zr[m], s, y, mu)
            steps.dual = _dual(tube.zr[m], tube.dzr[m], steps.dual)
        if tube.feed[k] > 0.0:
            s = _feed(tube, n, k, x, c, g)
            y = 0.0
            d = 0.0
            for i in range(n):
                y += g[i] * dx[k, 3 * i + 1]
                d += c[i] * dx[k, 3 * i + 1] * dx[k, 3 * i + 1]
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
    """Move the multipliers by a part of their step, within a factor of their central values; return how far products are off mu."""
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    m: cython.Py_ssize_t
    mu: cython.double = tube.mu
    s: cython.double
    y: cython.double
    off: cython.double = 0.0
    g = cython.declare(cython.double[9])
    c = cython.declare(cython.double[9])
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
            y = _middles(tube, n, k, tube.x, tube.u, g, c)
            for i in range(2 * n + 1):
                s = y if i == 2 * n else 1.0 + g[i // 2] if i % 2 == 0 else 1.0 - g[i // 2]
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
            s = _row(tube, n, m, k, tube.x, g)
            tube.zr[m] = _kept(tube.zr[m] + part * tube.dzr[m], s, mu, most)
            off = max(off, fabs(tube.zr[m] * s - mu))
        if tube.feed[k] > 0.0:
            s = _feed(tube, n, k, tube.x, c, g)
            tube.zf[k] = _kept(tube.zf[k] + part * tube.dzf[k], s, mu, most)
            off = max(off, fabs(tube.zf[k] * s - mu))
    return off


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _taken(tube: Tube, count: cython.Py_ssize_t, phi: cython.double, c: cython.double) -> cython.bint:
    """Tell whether a filter lets a point pass: beside each pair that it has, less of one of the two."""
    i: cython.Py_ssize_t
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
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
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
    it: cython.int
    back: cython.int
    count: cython.Py_ssize_t = 1
    delta: cython.double = 0.0
    damping: cython.double
    off: cython.double
    part: cython.double = 1.0
    residual: cython.double
    size: cython.double = 1.0
    phi: cython.double = 0.0
    last: cython.double
    fourth: cython.double
    flat: cython.int = 0
    closing: cython.bint = False
    calming: cython.double = _CLOSING_DAMPING
    steps: _Steps
    here: _Measure
    tube.mu = mu
    off = _multipliers(tube, n, 0.0, _OFF_AGAIN if again else 1.0)
    here = _measure(tube, n, tube.x, tube.u)
    # No point that misses much more than the first one passes the filter: on long intervals, steps in h miss by a thousand times that.
    tube.seen[0, 0] = -_BEYOND
    tube.seen[0, 1] = _WORSE * max(here.missed, _LEAST_MISS)
    for it in range(most):
        residual = here.most
        if it > 0:
            if residual < tube.exact and (closing or (tube.mu <= mu_end and off < tube.mu and size < 1e-3)):
                return Found(1, it, residual, off)
            if residual < _NEAR and off < _OFF_NEAR * tube.mu and part > 0.5:
                if near and tube.mu <= mu_end:
                    return Found(1, it, residual, off)
                fourth = sqrt(sqrt(tube.mu))
                if tube.mu > mu_end:
                    tube.mu = max(mu_end, min(_FALL * tube.mu, tube.mu * fourth * sqrt(fourth)))
                    count = 1
        closing |= it >= most - _CLOSING
        damping = delta
        if closing:
            # Steps become those of the least change, so that residuals fall with their squares.
            damping = calming
            calming *= _CHANGE
        tube.curvature = 1.0
        while not _backward(tube, n, damping):
            damping = max(_LEAST_DAMPING, _CHANGE * damping)
            if damping > _CONVEX:
                # The multipliers are far off: the step without the curvature of the motion has a positive Hessian.
                tube.curvature = 0.0
            if damping > 1e12:
                return Found(-1, it, residual, off)
        _forward(tube, n)
        steps = _limits(tube, n)
        size = steps.size
        # The step is halved until the filter, which the present point joins, lets it pass.
        last = phi
        tube.seen[count, 0] = here.cost - tube.mu * here.logs
        tube.seen[count, 1] = here.missed
        count += 1
        part = steps.primal
        for back in range(_HALVINGS):
            if back > 0:
                part *= 0.5
            _moved(tube, n, part)
            here = _measure(tube, n, tube.x2, tube.u2)
            phi = here.cost - tube.mu * here.logs
            if _taken(tube, count, phi, here.missed):
                break
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
        _accept(tube, n, part)
        off = _multipliers(tube, n, steps.dual, _OFF)
        if not off < 1e300:
            return Found(-1, it, residual, off)
    return Found(here.most < tube.exact, most, here.most, off)


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
