# cython: infer_types=True
"""The passes of an iteration of `cncgen.kernels.least_time` over the rows, which calls them as C (``least_time_passes.pxd``).

Rows and columns are those of `cncgen.kernels.least_time_problem`. The loops over lanes hold no branch, for a compiler
to do several at once; results are kept lane by lane, and added up at the end of a pass.

A slack's step is Δw = (r − A·c − w) + (∇r ∓ A)·Δc. Written so, not as what the constraint will be less w, it has all its digits:
at the optimum w is 10⁻⁷ of r, and A·c the difference of numbers a million times as large, whose rounding would otherwise go
into w, through it into λ, and leave the dual residual at more than a hundredth of the time.
"""

import cython
from cython.cimports.cncgen.kernels.least_time_matrix import begin, gathered, spread
from cython.cimports.cncgen.kernels.least_time_problem import (
    A0, A1, A2, B, D, DB, DD, DK, DW0, DW1, DY0, DY1, END, FOUND0, FOUND1, FOUND2, FOUND3, G, H, K, LANES, M00,
    M01, M02, M11, M12, M22, MOTION, PART, ROOT, ROWS, SCALE, SIZE, SLOPE, SUMMED, SUMS, W0, W1, Y0, Y1, Problem,
    find_runs, inlined, vectorized,
)  # fmt: skip
from cython.cimports.libc.math import fabs

#: Where a run of rows has its numbers: in the rows, the motion, what its limit scales with, and the sums; and its lanes.
_Place = cython.struct(
    rows=cython.Py_ssize_t,
    motion=cython.Py_ssize_t,
    scale=cython.Py_ssize_t,
    sums=cython.Py_ssize_t,
    first=cython.Py_ssize_t,
    stop=cython.Py_ssize_t,
)

#: The part of its limit from which a row that is asleep wakes, and the least slack that it wakes with.
_NEAR = cython.declare(cython.double, 0.6)
_LEAST = cython.declare(cython.double, 0.05)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _place(problem: Problem, runs: cython.longlong[:, ::1], i: cython.Py_ssize_t) -> _Place:
    """Return where run `i` has its numbers."""
    batch: cython.Py_ssize_t = runs[i, 0]
    motion: cython.Py_ssize_t = problem.batches[batch, 0] * MOTION
    end: cython.Py_ssize_t = problem.batches[batch, 1]
    which: cython.Py_ssize_t = end if problem.batches[batch, 2] == 2 else 2
    return _Place(
        batch * ROWS, motion + end * END, motion + which * SCALE, end * SUMS, runs[i, 1], runs[i, 2]
    )


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def set_up(problem: Problem, mu: cython.double) -> cython.void:
    """Set slacks of the rows that are awake to their value, r at least, and multipliers on the central path of `mu`."""
    rows: cython.double[::1] = problem.rows
    motion: cython.double[::1] = problem.motion
    at: _Place
    for i in range(problem.awake.first[problem.blocks]):
        at = _place(problem, problem.awake.of, i)
        for j in range(at.first, at.stop):
            r = rows[at.rows + PART + j] * motion[at.scale + ROOT + j]
            value = _value(rows, motion, at.rows + j, at.motion + j)
            w0 = r - min(value, 0.0)
            w1 = r + max(value, 0.0)
            _put(rows, at.rows + j, w0, w1, mu)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _value(
    rows: cython.double[::1], motion: cython.double[::1], i: cython.Py_ssize_t, m: cython.Py_ssize_t
) -> cython.double:
    """Return A·(q, d, κ)."""
    return rows[i + A0] * motion[m + B] + rows[i + A1] * motion[m + D] + rows[i + A2] * motion[m + K]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _put(
    rows: cython.double[::1],
    i: cython.Py_ssize_t,
    w0: cython.double,
    w1: cython.double,
    mu: cython.double,
) -> cython.void:
    """Set a row's slacks, with multipliers on the central path and no step."""
    rows[i + W0] = w0
    rows[i + W1] = w1
    rows[i + Y0] = mu / w0
    rows[i + Y1] = mu / w1
    rows[i + DW0] = rows[i + DW1] = rows[i + DY0] = rows[i + DY1] = 0.0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _approach(
    rows: cython.double[::1], motion: cython.double[::1], sums: cython.double[::1], at: _Place
) -> vectorized:
    """Fill the first column of `sums` with what a run of rows asleep uses of its limits beyond what wakes it."""
    for j in range(at.first, at.stop):
        sums[j] = fabs(_value(rows, motion, at.rows + j, at.motion + j)) - _NEAR * rows[at.rows + PART + j]


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def wake(problem: Problem, level: cython.double) -> cython.bint:
    """Wake the rows that come near their limits, with λ w = `level`; tell whether there are any.

    Those asleep are bounds and accelerations, so r = f.
    """
    rows: cython.double[::1] = problem.rows
    motion: cython.double[::1] = problem.motion
    sums: cython.double[::1] = problem.sums
    at: _Place
    woken: cython.bint = False
    for i in range(problem.asleep.first[problem.blocks]):
        at = _place(problem, problem.asleep.of, i)
        _approach(rows, motion, sums, at)
        for j in range(at.first, at.stop):
            if sums[j] > 0.0:
                part = rows[at.rows + PART + j]
                value = _value(rows, motion, at.rows + j, at.motion + j)
                least = _LEAST * part
                _put(rows, at.rows + j, max(part - value, least), max(part + value, least), level)
                problem.state[problem.asleep.of[i, 0], j] = 2
                woken = True
    if woken:
        find_runs(problem, 2, problem.awake)
        find_runs(problem, 1, problem.asleep)
    return woken


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _gather(
    rows: cython.double[::1],
    motion: cython.double[::1],
    sums: cython.double[::1],
    at: _Place,
    first: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
    step: cython.double,
    rise: cython.double,
) -> inlined:
    """Do a run of `gather`."""
    for j in range(first, stop):
        i = at.rows + j
        m = at.motion + j
        s = at.sums + j
        a0 = rows[i + A0]
        a1 = rows[i + A1]
        a2 = rows[i + A2]
        value = a0 * motion[m + B] + a1 * motion[m + D] + a2 * motion[m + K]
        r = rows[i + PART] * motion[at.scale + j + ROOT]
        slope = rows[i + PART] * motion[at.scale + j + SLOPE]
        w0 = max(rows[i + W0] + step * rows[i + DW0], r - value)
        w1 = max(rows[i + W1] + step * rows[i + DW1], r + value)
        y0 = rows[i + Y0] + rise * rows[i + DY0]
        y1 = rows[i + Y1] + rise * rows[i + DY1]
        rows[i + W0] = w0
        rows[i + W1] = w1
        rows[i + Y0] = y0
        rows[i + Y1] = y1
        both = 1.0 / (w0 * w1)
        s0 = y0 * w1 * both
        s1 = y1 * w0 * both
        sums[s + FOUND0] = max(sums[s + FOUND0], fabs(value) * motion[at.scale + j + SIZE] - rows[i + PART])
        sums[s + FOUND2] += w0 * y0 + w1 * y1
        t0 = s0 * (w0 - r + value)
        t1 = s1 * (w1 - r - value)
        more = s0 + s1
        less = s1 - s0
        # The gradients of both sides are (slope ∓ A0, ∓A1, ∓A2).
        x = more * a0 + less * slope
        y = more * slope + less * a0
        sums[s + M00] += a0 * x + slope * y
        sums[s + M01] += a1 * x
        sums[s + M02] += a2 * x
        sums[s + M11] += more * a1 * a1
        sums[s + M12] += more * a1 * a2
        sums[s + M22] += more * a2 * a2
        more = y0 + y1
        less = y1 - y0
        sums[s + G] -= less * a0 + more * slope
        sums[s + G + LANES] -= less * a1
        sums[s + G + 2 * LANES] -= less * a2
        more = t0 + t1
        less = t1 - t0
        sums[s + H] += less * a0 + more * slope
        sums[s + H + LANES] += less * a1
        sums[s + H + 2 * LANES] += less * a2


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _gather_block(
    problem: Problem,
    rows: cython.double[::1],
    motion: cython.double[::1],
    sums: cython.double[::1],
    block: cython.Py_ssize_t,
    step: cython.double,
    rise: cython.double,
) -> vectorized:
    """Do the runs of a block of `gather`."""
    for i in range(problem.awake.first[block], problem.awake.first[block + 1]):
        at = _place(problem, problem.awake.of, i)
        # With the number of lanes known, a compiler has less to ask.
        if at.first == 0 and at.stop == LANES:
            _gather(rows, motion, sums, at, 0, LANES, step, rise)
        else:
            _gather(rows, motion, sums, at, at.first, at.stop, step, rise)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def gather(
    problem: Problem,
    step: cython.double,
    rise: cython.double,
    dual: cython.double[::1],
    right: cython.double[::1],
    band: cython.double[:, ::1],
    out: cython.double[::1],
) -> cython.void:
    """Move slacks by `step`, multipliers by `rise`; set up the predictor's Newton matrix and right side.

    Slacks are raised to the value of their constraint where that is larger. `dual` becomes the residual ∇F − Σ λ ∇g,
    ``out[0]`` how far a limit is passed, at most, as a part of it, and ``out[1]`` the gap Σ λ w.
    """
    rows: cython.double[::1] = problem.rows
    motion: cython.double[::1] = problem.motion
    sums: cython.double[::1] = problem.sums
    dual[:] = 0.0
    right[:] = 0.0
    band[:, :] = 0.0
    sums[:] = 0.0
    for block in range(problem.blocks):
        begin(problem, block)
        _gather_block(problem, rows, motion, sums, block, step, rise)
        spread(problem, block, G, dual)
        spread(problem, block, H, right)
        gathered(problem, block, band)
    out[0] = _largest(sums, FOUND0)
    out[1] = _total(sums, FOUND2)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _largest(sums: cython.double[::1], column: cython.Py_ssize_t) -> cython.double:
    """Return the largest value that was found, or 0."""
    most: cython.double = 0.0
    for j in range(column, column + LANES):
        most = max(most, max(sums[j], sums[j + SUMS]))
    return most


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _total(sums: cython.double[::1], column: cython.Py_ssize_t) -> cython.double:
    """Return the sum of what was found."""
    total: cython.double = 0.0
    for j in range(column, column + LANES):
        total += sums[j] + sums[j + SUMS]
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _predict(
    rows: cython.double[::1],
    motion: cython.double[::1],
    sums: cython.double[::1],
    at: _Place,
    first: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
) -> inlined:
    """Do a run of `predict`."""
    for j in range(first, stop):
        i = at.rows + j
        m = at.motion + j
        s = at.sums + j
        a0 = rows[i + A0]
        a1 = rows[i + A1]
        a2 = rows[i + A2]
        value = a0 * motion[m + B] + a1 * motion[m + D] + a2 * motion[m + K]
        turn = a0 * motion[m + DB] + a1 * motion[m + DD] + a2 * motion[m + DK]
        r = rows[i + PART] * motion[at.scale + j + ROOT]
        slope = rows[i + PART] * motion[at.scale + j + SLOPE]
        rise = slope * motion[m + DB]
        w0 = rows[i + W0]
        w1 = rows[i + W1]
        both = 1.0 / (w0 * w1)
        z0 = w1 * both
        z1 = w0 * both
        d0 = (r - value - w0) + (rise - turn)
        d1 = (r + value - w1) + (rise + turn)
        x0 = d0 * z0
        x1 = d1 * z1
        sums[s + FOUND0] = max(sums[s + FOUND0], max(-x0, -x1))
        sums[s + FOUND1] = max(sums[s + FOUND1], 1.0 + max(x0, x1))
        sums[s + FOUND2] += d0 * rows[i + Y0] + d1 * rows[i + Y1]
        # Δw Δλ of both sides, with Δλ = −λ (1 + Δw/w).
        x0 = -d0 * rows[i + Y0] * (x0 + 1.0)
        x1 = -d1 * rows[i + Y1] * (x1 + 1.0)
        rows[i + DW0] = x0
        rows[i + DW1] = x1
        sums[s + FOUND3] += x0 + x1
        x0 *= z0
        x1 *= z1
        more = x0 + x1
        less = x0 - x1
        sums[s + G] += less * a0 - more * slope
        sums[s + G + LANES] += less * a1
        sums[s + G + 2 * LANES] += less * a2
        more = z0 + z1
        less = z1 - z0
        sums[s + H] += less * a0 + more * slope
        sums[s + H + LANES] += less * a1
        sums[s + H + 2 * LANES] += less * a2


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _predict_block(
    problem: Problem,
    rows: cython.double[::1],
    motion: cython.double[::1],
    sums: cython.double[::1],
    block: cython.Py_ssize_t,
) -> vectorized:
    """Do the runs of a block of `predict`."""
    for i in range(problem.awake.first[block], problem.awake.first[block + 1]):
        at = _place(problem, problem.awake.of, i)
        # With the number of lanes known, a compiler has less to ask.
        if at.first == 0 and at.stop == LANES:
            _predict(rows, motion, sums, at, 0, LANES)
        else:
            _predict(rows, motion, sums, at, at.first, at.stop)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def predict(
    problem: Problem, second: cython.double[::1], centre: cython.double[::1], out: cython.double[::1]
) -> cython.void:
    """Find the predictor's Δw and Δλ; keep their product alone, in the place of Δw.

    ``second + mu centre`` becomes what the corrector's right side has more than the predictor's; `out` the reciprocals
    of the longest primal and dual step to the boundary, then the sums of Δw λ and Δw Δλ.
    """
    rows: cython.double[::1] = problem.rows
    motion: cython.double[::1] = problem.motion
    sums: cython.double[::1] = problem.sums
    second[:] = 0.0
    centre[:] = 0.0
    sums[:] = 0.0
    for block in range(problem.blocks):
        for j in range(G, SUMMED):
            sums[j] = 0.0
            sums[SUMS + j] = 0.0
        _predict_block(problem, rows, motion, sums, block)
        spread(problem, block, G, second)
        spread(problem, block, H, centre)
    out[0] = _largest(sums, FOUND0)
    out[1] = _largest(sums, FOUND1)
    out[2] = _total(sums, FOUND2)
    out[3] = _total(sums, FOUND3)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _correct(
    rows: cython.double[::1],
    motion: cython.double[::1],
    sums: cython.double[::1],
    at: _Place,
    first: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
    mu: cython.double,
) -> inlined:
    """Do a run of `correct`."""
    for j in range(first, stop):
        i = at.rows + j
        m = at.motion + j
        s = at.sums + j
        value = rows[i + A0] * motion[m + B] + rows[i + A1] * motion[m + D] + rows[i + A2] * motion[m + K]
        turn = rows[i + A0] * motion[m + DB] + rows[i + A1] * motion[m + DD] + rows[i + A2] * motion[m + DK]
        r = rows[i + PART] * motion[at.scale + j + ROOT]
        rise = rows[i + PART] * motion[at.scale + j + SLOPE] * motion[m + DB]
        w0 = rows[i + W0]
        w1 = rows[i + W1]
        y0 = rows[i + Y0]
        y1 = rows[i + Y1]
        ww = w0 * w1
        yy = y0 * y1
        both = 1.0 / (ww * yy)
        z0 = w1 * yy * both
        z1 = w0 * yy * both
        d0 = (r - value - w0) + (rise - turn)
        d1 = (r + value - w1) + (rise + turn)
        x0 = (mu - rows[i + DW0] - y0 * d0) * z0 - y0
        x1 = (mu - rows[i + DW1] - y1 * d1) * z1 - y1
        rows[i + DW0] = d0
        rows[i + DW1] = d1
        rows[i + DY0] = x0
        rows[i + DY1] = x1
        sums[s + FOUND0] = max(sums[s + FOUND0], max(-d0 * z0, -d1 * z1))
        both *= ww
        sums[s + FOUND1] = max(sums[s + FOUND1], max(-x0 * y1 * both, -x1 * y0 * both))


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _correct_block(
    problem: Problem,
    rows: cython.double[::1],
    motion: cython.double[::1],
    sums: cython.double[::1],
    block: cython.Py_ssize_t,
    mu: cython.double,
) -> vectorized:
    """Do the runs of a block of `correct`."""
    for i in range(problem.awake.first[block], problem.awake.first[block + 1]):
        at = _place(problem, problem.awake.of, i)
        # With the number of lanes known, a compiler has less to ask.
        if at.first == 0 and at.stop == LANES:
            _correct(rows, motion, sums, at, 0, LANES, mu)
        else:
            _correct(rows, motion, sums, at, at.first, at.stop, mu)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def correct(problem: Problem, mu: cython.double, out: cython.double[::1]) -> cython.void:
    """Fill the corrector's Δw and Δλ, and `out` with the reciprocals of the longest primal and dual step to the boundary."""
    rows: cython.double[::1] = problem.rows
    motion: cython.double[::1] = problem.motion
    sums: cython.double[::1] = problem.sums
    sums[:] = 0.0
    for block in range(problem.blocks):
        _correct_block(problem, rows, motion, sums, block, mu)
    out[0] = _largest(sums, FOUND0)
    out[1] = _largest(sums, FOUND1)
