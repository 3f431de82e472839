# cython: infer_types=True
"""Acceleration and jerk between the ends of intervals, where the rows of `cncgen.kernels.least_time` do not hold them.

`least_time` calls these functions as C (``least_time_between.pxd``).
"""

import cython
from cython.cimports.cncgen.kernels.least_time_problem import (
    B, D, END, FIXED, K, LANES, LENGTH, LIFT, MOTION, PACE, PARABOLA, PART, PLACES, RATE, ROWS, SCALE, SIZE, USED, Problem,
    size, vectorized,
)  # fmt: skip
from cython.cimports.libc.math import fabs, sqrt


#: Amount by which limits are eased at the start of a window in motion, by the slack.
_EASE = cython.declare(cython.double, 1.2)
#: Part of the slack by which values inside may be larger than those at the ends: under constant jerk they often are by next to nothing,
#: here or there as iterates come.
_LEVEL = cython.declare(cython.double, 0.4)
#: The largest part of the jerk limit that is taken to hide between three values of the third derivative: of a cusp, those
#: tell little.
_CONCEALED = cython.declare(cython.double, 0.3)
#: The largest part of a limit that five values use which is not looked at any closer: between them, it is an eighth more.
_FAR = cython.declare(cython.double, 0.75)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _peak(
    v0: cython.double, v1: cython.double, v2: cython.double, v3: cython.double, v4: cython.double
) -> cython.double:
    """Return the largest of five equidistant values between the first and the last, by parabolas through three of them.

    Where the largest of the five is inside, it is raised to the top of the parabola around it; where it is at an end,
    the largest inside is the top of the parabola through the three nearest to that end, if it lies between.
    """
    # The largest inside, and its neighbours.
    before: cython.double = v0
    best: cython.double = v1
    after: cython.double = v2
    if v2 > best:
        before, best, after = v1, v2, v3
    if v3 > best:
        before, best, after = v2, v3, v4
    if before > best:
        bend = 2.0 * best - before - after
        slope = 2.0 * (best - before) + bend
        return before + slope * slope / (8.0 * bend) if slope > 0.0 else best
    if after > best:
        bend = 2.0 * best - after - before
        slope = 2.0 * (best - after) + bend
        return after + slope * slope / (8.0 * bend) if slope > 0.0 else best
    bend = 2.0 * best - before - after
    slope = after - before
    return best + slope * slope / (8.0 * bend) if bend > 0.0 else best


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _quarter(near: cython.double, middle: cython.double, far: cython.double) -> cython.double:
    """Return a parabola's value a quarter of the way from one end to the other, by those at the ends and in the middle."""
    return 0.375 * near + 0.75 * middle - 0.125 * far


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _inside(
    problem: Problem,
    fixed: cython.double[::1],
    motion: cython.double[::1],
    sums: cython.double[::1],
    block: cython.Py_ssize_t,
) -> vectorized:
    """Fill q = v², d and v at the quarter points and in the middle of the intervals of a block, from `PLACES` on.

    Where the tangents of q do not meet in the middle, d is a parabola.
    """
    for place in range(3):
        x = 0.25 * (place + 1)
        for j in range(size(problem, block)):
            f = block * FIXED + j
            m = block * MOTION + j
            s = PLACES + 3 * place * LANES + j
            gain = motion[m + END + D] - motion[m + D]
            bend = 1.5 - 6.0 * fixed[f + LIFT] * fixed[f + PACE] * fixed[f + PACE]
            q = motion[m + B] + 2.0 * fixed[f + LENGTH] * x * (
                motion[m + D] + gain * x * (0.5 * (1.0 - bend) + bend * x / 3.0)
            )
            sums[s] = q
            sums[s + LANES] = motion[m + D] + gain * x * (1.0 - bend + bend * x)
            sums[s + 2 * LANES] = sqrt(q)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _sizes(
    problem: Problem, d1: cython.double[:, :, ::1], d2: cython.double[:, :, ::1], d3: cython.double[:, :, ::1],
    fixed: cython.double[::1], motion: cython.double[::1], sums: cython.double[::1], block: cython.Py_ssize_t, a: cython.Py_ssize_t,
) -> vectorized:  # fmt: skip
    """Fill the sizes of acceleration and jerk of an axis at five places of the intervals of a block.

    Derivatives of the path are parabolas between the ends; the excess of the third one at the quarter points adds to the jerk.
    """
    for j in range(size(problem, block)):
        k = block * LANES + j
        m = block * MOTION + j
        p = PLACES + j
        x1 = _quarter(d1[k, 0, a], d1[k, 1, a], d1[k, 2, a])
        x2 = _quarter(d2[k, 0, a], d2[k, 1, a], d2[k, 2, a])
        x3 = _quarter(d3[k, 0, a], d3[k, 1, a], d3[k, 2, a])
        y1 = _quarter(d1[k, 2, a], d1[k, 1, a], d1[k, 0, a])
        y2 = _quarter(d2[k, 2, a], d2[k, 1, a], d2[k, 0, a])
        y3 = _quarter(d3[k, 2, a], d3[k, 1, a], d3[k, 0, a])
        sums[j] = fabs(d2[k, 0, a] * motion[m + B] + d1[k, 0, a] * motion[m + D])
        sums[LANES + j] = fabs(x2 * sums[p] + x1 * sums[p + LANES])
        sums[2 * LANES + j] = fabs(d2[k, 1, a] * sums[p + 3 * LANES] + d1[k, 1, a] * sums[p + 4 * LANES])
        sums[3 * LANES + j] = fabs(y2 * sums[p + 6 * LANES] + y1 * sums[p + 7 * LANES])
        sums[4 * LANES + j] = fabs(d2[k, 2, a] * motion[m + END + B] + d1[k, 2, a] * motion[m + END + D])
        # κ v is the jerk along the path of a parabola; with constant jerk κ is that of the mean speed.
        part = fixed[block * FIXED + j + PARABOLA]
        rate = (1.0 - part) * fixed[block * FIXED + j + RATE]
        along = motion[m + K]
        most = _CONCEALED * problem.limits[1, a] * problem.factor[k, 1, a]
        more = problem.x3_excess[k, a]
        sums[5 * LANES + j] = fabs(
            motion[m + SIZE] * (d3[k, 0, a] * motion[m + B] + 3.0 * d2[k, 0, a] * motion[m + D])
            + d1[k, 0, a] * along * (rate + part * motion[m + SIZE])
        )
        sums[6 * LANES + j] = fabs(
            sums[p + 2 * LANES] * (x3 * sums[p] + 3.0 * x2 * sums[p + LANES])
            + x1 * along * (rate + part * sums[p + 2 * LANES])
        ) + min(more * sums[p] * sums[p + 2 * LANES], most)
        sums[7 * LANES + j] = fabs(
            sums[p + 5 * LANES]
            * (d3[k, 1, a] * sums[p + 3 * LANES] + 3.0 * d2[k, 1, a] * sums[p + 4 * LANES])
            + d1[k, 1, a] * along * (rate + part * sums[p + 5 * LANES])
        )
        sums[8 * LANES + j] = fabs(
            sums[p + 8 * LANES] * (y3 * sums[p + 6 * LANES] + 3.0 * y2 * sums[p + 7 * LANES])
            + y1 * along * (rate + part * sums[p + 8 * LANES])
        ) + min(more * sums[p + 6 * LANES] * sums[p + 8 * LANES], most)
        sums[9 * LANES + j] = fabs(
            motion[m + SCALE + SIZE]
            * (d3[k, 2, a] * motion[m + END + B] + 3.0 * d2[k, 2, a] * motion[m + END + D])
            + d1[k, 2, a] * along * (rate + part * motion[m + SCALE + SIZE])
        )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(limit=cython.double)
def _used(
    problem: Problem,
    factor: cython.double[:, :, ::1],
    sums: cython.double[::1],
    block: cython.Py_ssize_t,
    which: cython.Py_ssize_t,
    a: cython.Py_ssize_t,
    slack: cython.double,
    eased: cython.Py_ssize_t,
) -> vectorized:
    """Fill the parts of a limit that an axis uses in a block: inside the intervals at `USED`, and there and at their ends after it."""
    for j in range(size(problem, block)):
        k = block * LANES + j
        s = 5 * which * LANES + j
        limit = problem.limits[which, a] * factor[k, which, a]
        limit = limit * (1.0 + _EASE * slack) if k < eased else limit
        inside = max(sums[s + LANES], max(sums[s + 2 * LANES], sums[s + 3 * LANES]))
        sums[USED + j] = inside / limit
        sums[USED + LANES + j] = max(inside, max(sums[s], sums[s + 4 * LANES])) / limit


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(limit=cython.double, part=cython.double)
def _lower(
    problem: Problem,
    sums: cython.double[::1],
    share: cython.double[:, :, ::1],
    block: cython.Py_ssize_t,
    which: cython.Py_ssize_t,
    a: cython.Py_ssize_t,
    slack: cython.double,
    eased: cython.Py_ssize_t,
    fresh: cython.bint,
) -> cython.double:
    """Lower the acceleration (0) or the jerk limits (1) of an axis in a block; return the largest part of one inside."""
    near: cython.double = 0.9 if fresh else 1.0 + slack
    margin: cython.double = 1.0 + _LEVEL * slack if fresh else 1.0 - 0.5 * slack
    worst: cython.double = 0.0
    _used(problem, problem.factor, sums, block, which, a, slack, eased)
    for j in range(size(problem, block)):
        part = sums[USED + j]
        if sums[USED + LANES + j] > _FAR:
            k = block * LANES + j
            s = 5 * which * LANES + j
            limit = problem.limits[which, a] * problem.factor[k, which, a]
            if k < eased:
                limit *= 1.0 + _EASE * slack
            end = max(sums[s], sums[s + 4 * LANES])
            inside = _peak(
                sums[s], sums[s + LANES], sums[s + 2 * LANES], sums[s + 3 * LANES], sums[s + 4 * LANES]
            )
            part = inside / limit
            if inside > near * limit and inside > end * max(margin, 1.0):
                bulge = margin * end / inside
                share[k, which, a] = min(share[k, which, a], bulge)
                # Acceleration at a node is a row of the interval after it.
                if which == 0 and k + 1 < problem.n:
                    share[k + 1, 0, a] = min(share[k + 1, 0, a], bulge)
        worst = max(worst, part)
    return worst


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def tighten(
    problem: Problem, slack: cython.double, eased: cython.Py_ssize_t, fresh: cython.bint
) -> cython.double:
    """Lower the limits of intervals between whose ends acceleration or jerk of an axis passes its limit.

    The largest values inside, estimated from three inner points, are compared with those at the ends, where the rows
    hold them. While the iterates are far from the optimum (`fresh`), ``share[k, 0]`` (acceleration) and ``share[k, 1]``
    (jerk) become the ratio of the largest value at the ends to the largest inside; later they are only lowered, where a
    limit is passed, and by half of `slack` more, lest the next iterate pass it again. The largest part of a limit that
    was found inside is returned, of the first `eased` intervals without their ease (see `apply`).

    Args:
        problem: Its motion as `cncgen.kernels.least_time_matrix.survey` fills it.
        slack: Part by which a limit may be passed.
        eased: Number of intervals whose limits are eased.
        fresh: Whether to begin anew.
    """
    worst: cython.double = 0.0
    if fresh:
        problem.share[:, :, :] = 1.0
    for block in range(problem.blocks):
        _inside(problem, problem.fixed, problem.motion, problem.sums, block)
        for a in range(problem.d1.shape[2]):
            if not problem.moves[a]:
                continue
            _sizes(
                problem,
                problem.d1,
                problem.d2,
                problem.d3,
                problem.fixed,
                problem.motion,
                problem.sums,
                block,
                a,
            )
            for which in range(2):
                worst = max(
                    worst, _lower(problem, problem.sums, problem.share, block, which, a, slack, eased, fresh)
                )
    return worst


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def apply(problem: Problem, slack: cython.double, eased: cython.Py_ssize_t) -> cython.void:
    """Set the part f of the limits that each row may use; on the first `eased` intervals `_EASE` times `slack` more.

    A window that starts in motion has little choice there: the plan that gave the state may pass its rows by `slack`,
    and rows of two axes that bind against each other would leave none.
    """
    for b in range(problem.count):
        if problem.batches[b, 2] == 0:
            continue
        which = 0 if problem.batches[b, 2] == 1 else 1
        a = problem.batches[b, 3]
        k = problem.batches[b, 0] * LANES
        for j in range(size(problem, problem.batches[b, 0])):
            problem.rows[b * ROWS + PART + j] = problem.share[k + j, which, a]
            if k + j < eased:
                problem.rows[b * ROWS + PART + j] += _EASE * slack
