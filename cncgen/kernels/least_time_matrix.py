# cython: infer_types=True
"""The parts of the Newton step of the least-time problem beside the rows: F, the motion, and the banded matrix.

Columns are those of `cncgen.kernels.least_time_problem`; `cncgen.kernels.least_time` calls these functions as C
(``least_time_matrix.pxd``).
"""

import cython
from cython.cimports.cncgen.kernels.least_time_problem import (
    B, D, DB, DD, DK, E0, E1, E2, E3, END, ENTER, FIXED, G, H, K, LANES, LEAVE, LEFT, LENGTH, LIFT, M00,
    M01, M02, M11, M12, M22, MIDDLE1, MIDDLE2, MOTION, PACE, RIGHT, ROOT, SCALE, SIZE, SLOPE, SUMMED, SUMS, WEIGHT0, WEIGHT1,
    WEIGHT2, Problem, size, vectorized,
)  # fmt: skip
from cython.cimports.libc.math import sqrt


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _survey(
    problem: Problem,
    c: cython.double[::1],
    fixed: cython.double[::1],
    motion: cython.double[::1],
    sums: cython.double[::1],
    block: cython.Py_ssize_t,
) -> vectorized:
    """Fill the columns of the motion of a block, and its parts of F in the first column of `sums`."""
    for j in range(size(problem, block)):
        k = block * LANES + j
        f = block * FIXED + j
        m = block * MOTION + j
        c0 = c[k]
        c1 = c[k + 1]
        c2 = c[k + 2]
        q0 = fixed[f + E0] * c0 + fixed[f + E1] * c1
        q2 = fixed[f + E2] * c1 + fixed[f + E3] * c2
        d0 = fixed[f + LEFT] * (c1 - c0) + fixed[f + LEAVE] * c1
        d2 = fixed[f + RIGHT] * (c2 - c1) - fixed[f + ENTER] * c1
        motion[m + B] = q0
        motion[m + D] = d0
        x = (d2 - d0) * fixed[f + PACE]
        motion[m + K] = motion[m + END + K] = x
        q1 = 1.0 / (q0 + fixed[f + LENGTH] * d0 + fixed[f + LIFT] * x)
        motion[m + END + B] = q2
        motion[m + END + D] = d2
        motion[m + 2 * SCALE + ROOT] = 1.0
        motion[m + 2 * SCALE + SIZE] = 1.0
        x = 1.0 / q0
        c0 = sqrt(x)
        time = fixed[f + WEIGHT0] * c0
        motion[m + ROOT] = c0
        motion[m + SLOPE] = -0.5 * x * c0
        motion[m + SIZE] = q0 * c0
        x = 1.0 / q2
        c0 = sqrt(x)
        time += fixed[f + WEIGHT2] * c0
        motion[m + SCALE + ROOT] = c0
        motion[m + SCALE + SLOPE] = -0.5 * x * c0
        motion[m + SCALE + SIZE] = q2 * c0
        x = fixed[f + WEIGHT1] * sqrt(q1)
        sums[j] = time + x
        x *= -0.5 * q1
        motion[m + MIDDLE1] = x
        motion[m + MIDDLE2] = -1.5 * x * q1


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def survey(problem: Problem) -> cython.double:
    """Fill the columns of the motion, and return F."""
    sums: cython.double[::1] = problem.sums
    total: cython.double = 0.0
    for block in range(problem.blocks):
        _survey(problem, problem.c, problem.fixed, problem.motion, sums, block)
        for j in range(size(problem, block)):
            total += sums[j]
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _begin(
    problem: Problem,
    fixed: cython.double[::1],
    motion: cython.double[::1],
    sums: cython.double[::1],
    block: cython.Py_ssize_t,
) -> vectorized:
    """Do `begin`."""
    for j in range(SUMMED):
        sums[j] = 0.0
        sums[SUMS + j] = 0.0
    for j in range(size(problem, block)):
        f = block * FIXED + j
        m = block * MOTION + j
        s = j
        t = SUMS + j
        z = fixed[f + LENGTH]
        y = fixed[f + LIFT]
        x = fixed[f + WEIGHT0] * motion[m + SLOPE]
        sums[s + G] = x + motion[m + MIDDLE1]
        sums[s + G + LANES] = motion[m + MIDDLE1] * z
        sums[s + G + 2 * LANES] = motion[m + MIDDLE1] * y
        sums[s + H] = -x - motion[m + MIDDLE1]
        sums[s + H + LANES] = -motion[m + MIDDLE1] * z
        sums[s + H + 2 * LANES] = -motion[m + MIDDLE1] * y
        sums[s + M00] = motion[m + MIDDLE2] - 1.5 * x * motion[m + ROOT] * motion[m + ROOT]
        x = motion[m + MIDDLE2] * z
        sums[s + M01] = x
        sums[s + M11] = x * z
        sums[s + M12] = x * y
        x = motion[m + MIDDLE2] * y
        sums[s + M02] = x
        sums[s + M22] = x * y
        x = fixed[f + WEIGHT2] * motion[m + SCALE + SLOPE]
        sums[t + G] = x
        sums[t + H] = -x
        sums[t + M00] = -1.5 * x * motion[m + SCALE + ROOT] * motion[m + SCALE + ROOT]


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def begin(problem: Problem, block: cython.Py_ssize_t) -> cython.void:
    """Begin the sums of a block with F: its gradient in `G`, the negative in `H`, and its Hessian in the matrix.

    In the middle of an interval q is b + h d + h (3/4 h − l) κ by q, d and κ at the left end.
    """
    _begin(problem, problem.fixed, problem.motion, problem.sums, block)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _spread(
    problem: Problem,
    fixed: cython.double[::1],
    sums: cython.double[::1],
    block: cython.Py_ssize_t,
    column: cython.Py_ssize_t,
    vector: cython.double[::1],
) -> vectorized:
    """Do `spread`."""
    count = size(problem, block)
    k = block * LANES
    for j in range(count):
        f = block * FIXED + j
        s = column + j
        x = fixed[f + PACE] * (sums[s + 2 * LANES] + sums[s + SUMS + 2 * LANES])
        sums[s + 2 * LANES] = x
        vector[k + j] += fixed[f + E0] * sums[s] - fixed[f + LEFT] * (sums[s + LANES] - x)
    for j in range(count):
        f = block * FIXED + j
        s = column + j
        t = s + SUMS
        x = sums[s + 2 * LANES]
        vector[k + 1 + j] += (
            fixed[f + E1] * sums[s]
            + (fixed[f + LEFT] + fixed[f + LEAVE]) * (sums[s + LANES] - x)
            + fixed[f + E2] * sums[t]
            - (fixed[f + RIGHT] + fixed[f + ENTER]) * (sums[t + LANES] + x)
        )
    for j in range(count):
        f = block * FIXED + j
        s = column + j
        t = s + SUMS
        vector[k + 2 + j] += fixed[f + E3] * sums[t] + fixed[f + RIGHT] * (
            sums[t + LANES] + sums[s + 2 * LANES]
        )


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def spread(
    problem: Problem, block: cython.Py_ssize_t, column: cython.Py_ssize_t, vector: cython.double[::1]
) -> cython.void:
    """Add the sums of a block that begin in `column`, of (q, d, κ) at both ends, to a vector of the unknowns."""
    _spread(problem, problem.fixed, problem.sums, block, column, vector)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _gathered(
    problem: Problem,
    fixed: cython.double[::1],
    sums: cython.double[::1],
    block: cython.Py_ssize_t,
    band: cython.double[:, ::1],
) -> vectorized:
    """Do `gathered`."""
    count = size(problem, block)
    k = block * LANES
    for j in range(count):
        f = block * FIXED + j
        s = j
        t = SUMS + j
        # q, d and κ by the three unknowns: b and d at the left end, u and v at the right one.
        b0 = fixed[f + E0]
        b1 = fixed[f + E1]
        d0 = -fixed[f + LEFT]
        d1 = fixed[f + LEFT] + fixed[f + LEAVE]
        u1 = fixed[f + E2]
        u2 = fixed[f + E3]
        v1 = -fixed[f + RIGHT] - fixed[f + ENTER]
        v2 = fixed[f + RIGHT]
        k0 = -fixed[f + PACE] * d0
        k1 = fixed[f + PACE] * (v1 - d1)
        k2 = fixed[f + PACE] * v2
        both = sums[s + M22] + sums[t + M22]
        # The matrix by the columns of that: p, r at the left end, then for κ, and x, y at the right end.
        p0 = sums[s + M00] * b0 + sums[s + M01] * d0 + sums[s + M02] * k0
        p1 = sums[s + M00] * b1 + sums[s + M01] * d1 + sums[s + M02] * k1
        r0 = sums[s + M01] * b0 + sums[s + M11] * d0 + sums[s + M12] * k0
        r1 = sums[s + M01] * b1 + sums[s + M11] * d1 + sums[s + M12] * k1
        t0 = sums[s + M02] * b0 + sums[s + M12] * d0 + both * k0
        t1 = sums[s + M02] * b1 + sums[s + M12] * d1 + sums[t + M02] * u1 + sums[t + M12] * v1 + both * k1
        t2 = sums[t + M02] * u2 + sums[t + M12] * v2 + both * k2
        p2 = sums[t + M00] * u2 + sums[t + M01] * v2 + sums[t + M02] * k2
        r2 = sums[t + M01] * u2 + sums[t + M11] * v2 + sums[t + M12] * k2
        x = sums[t + M00] * u1 + sums[t + M01] * v1 + sums[t + M02] * k1
        y = sums[t + M01] * u1 + sums[t + M11] * v1 + sums[t + M12] * k1
        sums[s + M00] = b0 * p0 + d0 * r0 + k0 * t0
        sums[s + M01] = b1 * p0 + d1 * r0 + (u1 * sums[t + M02] + v1 * sums[t + M12]) * k0 + k1 * t0
        sums[s + M02] = (u2 * sums[t + M02] + v2 * sums[t + M12]) * k0 + k2 * t0
        sums[s + M11] = b1 * p1 + d1 * r1 + u1 * x + v1 * y + k1 * t1
        sums[s + M12] = u2 * x + v2 * y + k2 * t1
        sums[s + M22] = u2 * p2 + v2 * r2 + k2 * t2
    for j in range(count):
        band[0, k + j] += sums[j + M00]
        band[1, k + j] += sums[j + M01]
        band[2, k + j] += sums[j + M02]
    for j in range(count):
        band[0, k + 1 + j] += sums[j + M11]
        band[1, k + 1 + j] += sums[j + M12]
    for j in range(count):
        band[0, k + 2 + j] += sums[j + M22]


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def gathered(problem: Problem, block: cython.Py_ssize_t, band: cython.double[:, ::1]) -> cython.void:
    """Add the matrix of a block, of (q, d, κ) at both ends, to three upper diagonals of that of the unknowns."""
    _gathered(problem, problem.fixed, problem.sums, block, band)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def factorize(band: cython.double[:, ::1], start: cython.Py_ssize_t, stop: cython.Py_ssize_t) -> cython.bint:
    """Factor the unknowns `start` to `stop` − 1 of the matrix as L D Lᵀ in place; return False where D is not positive.

    ``band[m, k]`` is the entry of row k and column k + m; it becomes 1/D for m = 0, and that of L in column k for others.
    Gaussian elimination in a band, in the storage of BCHFAC (de Boor, A Practical Guide to Splines (2001), chapter XIV),
    for five diagonals.
    """
    # The remainder of the next two columns: two entries of the diagonal, and the one beside the first.
    d: cython.double = band[0, start]
    beside: cython.double = band[1, start]
    after: cython.double = band[0, start + 1] if start + 1 < stop else 0.0
    for k in range(start, stop):
        if not d > 0.0:
            return False
        inverse = 1.0 / d
        l1 = beside * inverse
        l2 = band[2, k] * inverse
        d = after - l1 * beside
        beside = band[1, k + 1] - l1 * band[2, k]
        after = band[0, k + 2] - l2 * band[2, k] if k + 2 < stop else 0.0
        band[0, k] = inverse
        band[1, k] = l1
        band[2, k] = l2
    return True


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def substitute(
    band: cython.double[:, ::1],
    start: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
    right: cython.double[::1],
    dc: cython.double[::1],
) -> cython.void:
    """Solve L D Lᵀ dc = right on the free unknowns; the others get 0. (BCHSLV of de Boor (2001), see `factorize`.)"""
    l1: cython.double = 0.0
    l2: cython.double = 0.0
    l3: cython.double = 0.0
    one: cython.double = 0.0
    two: cython.double = 0.0
    dc[:] = 0.0
    for k in range(start, stop):
        x = right[k] - l2 * two - l1 * one
        dc[k] = x
        two = one
        one = x
        l1 = band[1, k]
        l2 = l3
        l3 = band[2, k]
    one = two = 0.0
    for k in range(stop - 1, start - 1, -1):
        x = dc[k] * band[0, k] - band[2, k] * two - band[1, k] * one
        dc[k] = x
        two = one
        one = x


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _turn(
    problem: Problem,
    c: cython.double[::1],
    dc: cython.double[::1],
    fixed: cython.double[::1],
    motion: cython.double[::1],
    sums: cython.double[::1],
    block: cython.Py_ssize_t,
) -> vectorized:
    """Fill the steps of the motion of a block, and raise its part of what `turn` returns, in the first column of `sums`."""
    for j in range(size(problem, block)):
        k = block * LANES + j
        f = block * FIXED + j
        m = block * MOTION + j
        c0 = dc[k]
        c1 = dc[k + 1]
        c2 = dc[k + 2]
        d0 = fixed[f + LEFT] * (c1 - c0) + fixed[f + LEAVE] * c1
        d2 = fixed[f + RIGHT] * (c2 - c1) - fixed[f + ENTER] * c1
        most = max(sums[j], -c1 / c[k + 1])
        x = fixed[f + E0] * c0 + fixed[f + E1] * c1
        motion[m + DB] = x
        most = max(most, -x * motion[m + ROOT] * motion[m + ROOT])
        motion[m + DD] = d0
        motion[m + DK] = motion[m + END + DK] = (d2 - d0) * fixed[f + PACE]
        x = fixed[f + E2] * c1 + fixed[f + E3] * c2
        motion[m + END + DB] = x
        sums[j] = max(most, -x * motion[m + SCALE + ROOT] * motion[m + SCALE + ROOT])
        motion[m + END + DD] = d2


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def turn(problem: Problem, dc: cython.double[::1]) -> cython.double:
    """Fill the steps of the motion; return the reciprocal of the longest step that keeps every ordinate of q non-negative."""
    sums: cython.double[::1] = problem.sums
    most: cython.double = 0.0
    for j in range(LANES):
        sums[j] = 0.0
    for block in range(problem.blocks):
        _turn(problem, problem.c, dc, problem.fixed, problem.motion, sums, block)
    for j in range(LANES):
        most = max(most, sums[j])
    return most
