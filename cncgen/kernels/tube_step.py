# cython: infer_types=True
"""The Newton step of `cncgen.kernels.least_time_tube`: a Riccati recursion (Rao, Wright and Rawlings (1998)) over a row of nodes.

Of an interval, x⁺ = A x + B j + c h + f for changes of state, jerks and time; A and B go axis by axis. Functions take the number of
axes as an argument: `backward` and `forward` hand on 2 and 3 as constants, for which compilers unroll the loops.
"""

import cython
from cython.cimports.cncgen.kernels.tube_point import Tube
from cython.cimports.libc.math import sqrt

from cncgen.kernels.tube_point import RHO

_RHO = cython.declare(cython.double, RHO)


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
    h: cython.double = tube.u[k, n] * tube.h0[k]
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
    across: cython.double
    for i in range(N * N):
        tube.P[k, i] = 0.0
    across = tube.nu[k]
    for i in range(n):
        across += _RHO * tube.t[k, i] * tube.x[k, 3 * i]
    for i in range(n):
        tube.q[k, 3 * i] = tube.t[k, i] * across
        tube.P[k, 3 * i * (N + 1)] = delta
        for j in range(i + 1):
            tube.P[k, 3 * i * N + 3 * j] += _RHO * tube.t[k, i] * tube.t[k, j]
        for e in range(2):
            low = 1.0 + tube.x[k, 3 * i + e + 1]
            high = 1.0 - tube.x[k, 3 * i + e + 1]
            y = 1.0 / (low * high)
            j = 4 * i + 2 * e
            tube.P[k, (3 * i + e + 1) * (N + 1)] = (
                delta + (tube.zx[k, j] * high + tube.zx[k, j + 1] * low) * y
            )
            tube.q[k, 3 * i + e + 1] = tube.mu * (low - high) * y
    for m in range(tube.first[k], tube.first[k + 1]):
        s = 1.0 / tube.row_slack[m]
        z = tube.zr[m]
        y = 2.0 * z * tube.rows[m, 2 * n] * tube.rows[m, 2 * n]
        b = tube.rows[m, 2 * n + 1]
        for i in range(n):
            tube.q[k, 3 * i] -= tube.mu * s * tube.row_slope[m, i]
            tube.P[k, 3 * i * (N + 1)] += y
            for j in range(i + 1):
                tube.P[k, 3 * i * N + 3 * j] += (
                    z * s * tube.row_slope[m, i] * tube.row_slope[m, j]
                    - y * tube.rows[m, n + i] * tube.rows[m, n + j]
                )
        if b > 0.0:
            _bowed(tube, n, k, m, y, b)
    if tube.feed[k] > 0.0:
        s = 1.0 / tube.feed_slack[k]
        z = tube.zf[k]
        for i in range(n):
            tube.q[k, 3 * i + 1] -= tube.mu * s * tube.feed_slope[k, i]
            c = tube.V[i] * tube.feed[k]
            c = tube.weight[k, i] * c * c
            tube.P[k, (3 * i + 1) * (N + 1)] += 2.0 * c * z
            for j in range(i + 1):
                tube.P[k, (3 * i + 1) * N + 3 * j + 1] += (
                    z * s * tube.feed_slope[k, i] * tube.feed_slope[k, j]
                )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _bowed(
    tube: Tube,
    n: cython.Py_ssize_t,
    k: cython.Py_ssize_t,
    m: cython.Py_ssize_t,
    y: cython.double,
    b: cython.double,
) -> cython.void:
    """Add what a row of p + b a has over the accelerations, beside its part over the positions, y of which is across its direction."""
    N: cython.Py_ssize_t = 3 * n
    s: cython.double = 1.0 / tube.row_slack[m]
    for i in range(n):
        g = b * tube.V[i] * tube.AV[i]
        tube.q[k, 3 * i + 2] -= tube.mu * s * tube.row_slope[m, i] * g
        for j in range(i + 1):
            z = (
                tube.zr[m] * s * tube.row_slope[m, i] * tube.row_slope[m, j]
                - y * tube.rows[m, n + i] * tube.rows[m, n + j]
                + (y if i == j else 0.0)
            )
            f = b * tube.V[j] * tube.AV[j]
            tube.P[k, (3 * i + 2) * N + 3 * j] += z * g
            tube.P[k, (3 * i + 2) * N + 3 * j + 2] += z * g * f
            if j < i:
                tube.P[k, 3 * i * N + 3 * j + 2] += z * f


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
    h0: cython.double = tube.h0[k]
    h: cython.double = tube.u[k, n] * h0
    time: cython.double = tube.cost * h0
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
    o: cython.Py_ssize_t = n * (N + 1)
    total: cython.double = 0.0
    y = cython.declare(cython.double[9])
    c = cython.declare(cython.double[9])
    s = tube.middle_slack[k]
    for i in range(n):
        y[i] = tube.middle[k, i]
        c[i] = tube.V[i] * tube.between[k]
        c[i] = tube.weight[k, i] * tube.weight[k + 1, i] * c[i] * c[i]
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
            tube.P[k, (f + 1) * (N + 1)] += weight
            tube.P[k, (f + 2) * (N + 1)] += weight * b * b
            tube.P[k, (f + 2) * N + f + 1] += weight * b
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
            tube.P[k, (3 * i + 1) * N + 3 * j + 1] += s
            tube.P[k, (3 * i + 2) * N + 3 * j + 1] += s * b
            tube.P[k, (3 * i + 2) * N + 3 * j + 2] += s * b * g
            if j < i:
                tube.P[k, (3 * i + 1) * N + 3 * j + 2] += s * g


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
    B = cython.declare(cython.double[27])
    C = cython.declare(cython.double[27])
    F = cython.declare(cython.double[27])
    PC = cython.declare(cython.double[27])
    _linear(tube, n, k, A, B, C)
    for i in range(N):
        y[i] = tube.q[k + 1, i]
        PC[i] = 0.0
    for j in range(N):
        p0 = tube.miss[k, j]
        p1 = C[j]
        for i in range(N):
            y[i] += tube.P[k + 1, j * N + i] * p0
            PC[i] += tube.P[k + 1, j * N + i] * p1
    for i in range(n):
        # P B of this axis, and with it the rows of its jerk.
        for j in range(N):
            o = 3 * i * N + j
            F[j] = (
                B[3 * i] * tube.P[k + 1, o]
                + B[3 * i + 1] * tube.P[k + 1, o + N]
                + B[3 * i + 2] * tube.P[k + 1, o + 2 * N]
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
    z: cython.double
    R = cython.declare(cython.double[9])
    for i in range(n):
        for j in range(i + 1):
            for e in range(3):
                o = (3 * i + e) * N + 3 * j
                R[3 * e] = tube.P[k + 1, o]
                R[3 * e + 1] = tube.P[k + 1, o] * A[3 * j] + tube.P[k + 1, o + 1]
                R[3 * e + 2] = (
                    tube.P[k + 1, o] * A[3 * j + 1]
                    + tube.P[k + 1, o + 1] * A[3 * j + 2]
                    + tube.P[k + 1, o + 2]
                )
            for e in range(3):
                R[6 + e] += A[3 * i + 1] * R[e] + A[3 * i + 2] * R[3 + e]
                R[3 + e] += A[3 * i] * R[e]
            for e in range(3):
                for f in range(3):
                    tube.P[k, (3 * i + e) * N + 3 * j + f] += R[3 * e + f]
        tube.q[k, 3 * i] += y[3 * i]
        tube.q[k, 3 * i + 1] += A[3 * i] * y[3 * i] + y[3 * i + 1]
        tube.q[k, 3 * i + 2] += A[3 * i + 1] * y[3 * i] + A[3 * i + 2] * y[3 * i + 1] + y[3 * i + 2]
    for i in range(N):
        z = tube.q[k, i]
        for o in range(U):
            z -= S[o * (N + 1) + i] * S[o * (N + 1) + N]
        tube.q[k, i] = z
        for j in range(i + 1):
            z = tube.P[k, i * N + j]
            for o in range(U):
                z -= S[o * (N + 1) + i] * S[o * (N + 1) + j]
            tube.P[k, i * N + j] = z
            tube.P[k, j * N + i] = z


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
    y: cython.double
    A = cython.declare(cython.double[27])
    B = cython.declare(cython.double[27])
    C = cython.declare(cython.double[27])
    for i in range(N):
        tube.dx[0, i] = 0.0
    for k in range(tube.steps):
        for i in range(n + 1):
            y = tube.K[k, i * (N + 1) + N]
            for j in range(N):
                y += tube.K[k, i * (N + 1) + j] * tube.dx[k, j]
            tube.du[k, i] = y
        _linear(tube, n, k, A, B, C)
        for i in range(n):
            j = 3 * i
            y = A[j] * tube.dx[k, j + 1] + A[j + 1] * tube.dx[k, j + 2]
            tube.dx[k + 1, j] = (
                tube.miss[k, j] + (tube.dx[k, j] + y) + (B[j] * tube.du[k, i] + C[j] * tube.du[k, n])
            )
            tube.dx[k + 1, j + 1] = (
                tube.miss[k, j + 1]
                + (tube.dx[k, j + 1] + A[j + 2] * tube.dx[k, j + 2])
                + (B[j + 1] * tube.du[k, i] + C[j + 1] * tube.du[k, n])
            )
            tube.dx[k + 1, j + 2] = (
                tube.miss[k, j + 2]
                + tube.dx[k, j + 2]
                + (B[j + 2] * tube.du[k, i] + C[j + 2] * tube.du[k, n])
            )
        for i in range(N):
            y = tube.q[k + 1, i]
            for j in range(N):
                y += tube.P[k + 1, i * N + j] * tube.dx[k + 1, j]
            tube.lam2[k, i] = y
        if k > 0:
            y = 0.0
            for i in range(n):
                y += tube.t[k, i] * (tube.x[k, 3 * i] + tube.dx[k, 3 * i])
            tube.nu2[k] = tube.nu[k] + _RHO * y
    for i in range(N):
        tube.lamT2[i] = tube.lamT[i] + tube.rho * (
            tube.x[tube.steps, i] + tube.dx[tube.steps, i] - tube.goal[i]
        )


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def backward(tube: Tube, delta: cython.double) -> cython.bint:
    """Work the cost to go backwards from the point that was measured last, with the damping `delta`, and keep the gains.

    Returns False where the Hessian over the controls is not positive.
    """
    if tube.n == 2:
        return _backward(tube, 2, delta)
    if tube.n == 3:
        return _backward(tube, 3, delta)
    return _backward(tube, tube.n, delta)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def forward(tube: Tube) -> cython.void:
    """Work out the Newton step and the multipliers of the equations after it, by the gains that `backward` has kept."""
    if tube.n == 2:
        _forward(tube, 2)
    elif tube.n == 3:
        _forward(tube, 3)
    else:
        _forward(tube, tube.n)
