# cython: infer_types=True
"""Constraints of the least-time problem as rows, and a profile to start from (docs/least-time.md).

`cncgen.kernels.least_time_problem` describes rows, and how rows and intervals lie in memory.
"""

import cython
from cython.cimports.cncgen.kernels.least_time_matrix import survey
from cython.cimports.cncgen.kernels.least_time_problem import (
    A0, A1, A2, B, D, END, FIXED, LANES, MOTION, PARABOLA, PART, ROOT, ROWS, SCALE, W0, W1, Problem, find_runs, size,
    vectorized,
)  # fmt: skip
from cython.cimports.libc.math import cbrt, fabs, sqrt

#: Quantity that a row bounds, as in `cncgen.kernels.least_time`.
_BOX = cython.declare(cython.longlong, 0)
_ACCELERATION = cython.declare(cython.longlong, 1)
_JERK = cython.declare(cython.longlong, 2)
#: Parts by which numbers that are alike differ by rounding, and below which one beside another is rounding alone.
_ALIKE = cython.declare(cython.double, 1e-9)
_NOTHING = cython.declare(cython.double, 1e-13)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _moves(
    d: cython.double[:, :, ::1], k: cython.Py_ssize_t, a: cython.Py_ssize_t, rounding: cython.double
) -> cython.int:
    """Tell whether a derivative in interval `k` is there for axis `a` (2), for others alone (1), or for none (0).

    Values below `rounding` count as 0.
    """
    mine: cython.double = 0.0
    most: cython.double = 0.0
    for e in range(3):
        mine = max(mine, fabs(d[k, e, a]))
        for b in range(d.shape[2]):
            most = max(most, fabs(d[k, e, b]))
    if mine > max(_NOTHING * most, rounding):
        return 2
    return 1 if most > rounding else 0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _idle(problem: Problem, k: cython.Py_ssize_t, a: cython.Py_ssize_t) -> cython.bint:
    """Tell whether axis `a` can never bind in interval `k`: it stands, or on a straight interval another binds first.

    A derivative that changes the direction by no more than rounding over the length `h` of the interval counts as zero.
    Values that differ by less than `_ALIKE` count as equal, lest rounding say how many rows a problem has.
    """
    h: cython.double = problem.h[k]
    most: cython.double = 0.0
    jerk: cython.double
    for b in range(problem.d1.shape[2]):
        most = max(most, fabs(problem.d1[k, 1, b]))
    bend = _moves(problem.d2, k, a, _NOTHING * most / h)
    twist = _moves(problem.d3, k, a, _NOTHING * most / (h * h))
    if _moves(problem.d1, k, a, 0.0) < 2 and bend < 2 and twist < 2:
        return True
    if bend > 0 or twist > 0:
        return False
    for b in range(problem.d1.shape[2]):
        if b == a:
            continue
        # The part of its limits that b takes, by the part that a takes of its own.
        acc = fabs(problem.d1[k, 0, b]) * problem.limits[0, a] * problem.factor[k, 0, a]
        acc /= fabs(problem.d1[k, 0, a]) * problem.limits[0, b] * problem.factor[k, 0, b]
        jerk = (
            problem.limits[1, a]
            * problem.factor[k, 1, a]
            / (fabs(problem.d1[k, 0, a]) * problem.limits[1, b] * problem.factor[k, 1, b])
        )
        jerk *= fabs(problem.d1[k, 0, b])
        if min(acc, jerk) > 1.0 - _ALIKE and (b < a or max(acc, jerk) > 1.0 + _ALIKE):
            return True
    return False


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _open(
    problem: Problem,
    block: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    kind: cython.longlong,
    axis: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """Begin the batch after the last one; return where its rows are."""
    b = problem.count
    problem.batches[b, 0], problem.batches[b, 1], problem.batches[b, 2], problem.batches[b, 3] = (
        block,
        end,
        kind,
        axis,
    )
    for j in range(LANES):
        problem.state[b, j] = 0
    return b * ROWS


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _put(
    problem: Problem,
    j: cython.Py_ssize_t,
    a0: cython.double,
    a1: cython.double,
    a2: cython.double,
    limit: cython.double,
) -> cython.void:
    """Write a row, awake, of interval `j` of its block to the batch after the last one."""
    i = problem.count * ROWS + j
    limit = 1.0 / limit
    problem.rows[i + A0] = a0 * limit
    problem.rows[i + A1] = a1 * limit
    problem.rows[i + A2] = a2 * limit
    problem.rows[i + PART] = 1.0
    problem.state[problem.count, j] = 2


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _close(problem: Problem) -> cython.void:
    """Keep the batch after the last one where it has rows."""
    for j in range(LANES):
        if problem.state[problem.count, j] != 0:
            problem.count += 1
            return


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _bounds(
    problem: Problem,
    block: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    bound: cython.double[:, ::1],
    sway: cython.double[:, ::1],
) -> cython.void:
    """Write the bounds of q and d of a block at one end; the middle ordinate counts as one at the left end."""
    for m in range(2 * end, 2 + end):
        _open(problem, block, end, _BOX, -1)
        for j in range(size(problem, block)):
            k = block * LANES + j
            if bound[k, m] < 1e300 and not (problem.free > 1 and k == 0 and end == 0):
                _put(problem, j, 1.0, problem.h[k] if m == 1 else 0.0, 0.0, bound[k, m])
        _close(problem)
    _open(problem, block, end, _ACCELERATION, 0)
    for j in range(size(problem, block)):
        k = block * LANES + j
        if sway[k, end] < 1e300 and not (problem.free > 1 and k == 0 and end == 0):
            _put(problem, j, 0.0, 1.0, 0.0, sway[k, end])
    _close(problem)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _put_all(
    problem: Problem,
    rows: cython.double[::1],
    d1: cython.double[:, :, ::1],
    d2: cython.double[:, :, ::1],
    d3: cython.double[:, :, ::1],
    factor: cython.double[:, :, ::1],
    block: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    which: cython.Py_ssize_t,
    a: cython.Py_ssize_t,
) -> vectorized:
    """Write the rows of acceleration (0) or jerk (1) of an axis, of all intervals of a block at one end, after the last batch."""
    e = 2 * end
    for j in range(size(problem, block)):
        k = block * LANES + j
        i = problem.count * ROWS + j
        over = 1.0 / (problem.limits[which, a] * factor[k, which, a])
        rows[i + A0] = (d3[k, e, a] if which == 1 else d2[k, e, a]) * over
        rows[i + A1] = (3.0 * d2[k, e, a] if which == 1 else d1[k, e, a]) * over
        rows[i + A2] = d1[k, e, a] * over if which == 1 else 0.0
        rows[i + PART] = 1.0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _limited(
    problem: Problem,
    block: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    held_right: cython.char[::1],
    idle: cython.char[:, ::1],
) -> cython.void:
    """Write accelerations and jerks of a block at one end."""
    for a in range(problem.d1.shape[2]):
        for which in range(2):
            _open(problem, block, end, _JERK if which == 1 else _ACCELERATION, a)
            _put_all(
                problem,
                problem.rows,
                problem.d1,
                problem.d2,
                problem.d3,
                problem.factor,
                block,
                end,
                which,
                a,
            )
            for j in range(size(problem, block)):
                k = block * LANES + j
                if idle[a, k] == 0 and (
                    which == 1 or (held_right[k] != 0 if end == 1 else problem.free == 1 or k > 0)
                ):
                    problem.state[problem.count, j] = 2
            _close(problem)


def build(
    problem: Problem,
    box: cython.double[:, ::1],
    tilt: cython.double[::1],
    bent: cython.char[::1],
    sway: cython.double[:, ::1],
    held_right: cython.char[::1],
) -> cython.void:
    """Fill the rows of a window, all awake; where it starts in motion, those that the state alone decides are left out.

    Args:
        problem: Without rows.
        box: Shape (n, 3): largest q at the left end, for the middle ordinate, and at the right end (infinite: none).
        tilt: Shape (n,): how fast the bound of the middle ordinate rises with the way that it stands for.
        bent: Shape (n,): whether q is a parabola there in any case, as the bound is that of one.
        sway: Shape (n, 2): largest |q′|/2 at the left and at the right end (infinite: none).
        held_right: Shape (n,): 1 where acceleration must be held at the right end too (the next interval does not start
            with the same derivatives).
    """
    axes: cython.Py_ssize_t = problem.d1.shape[2]
    import numpy

    idle: cython.char[:, ::1] = numpy.empty((axes, problem.n), numpy.int8)
    with cython.nogil:
        for k in range(problem.n):
            problem.middle[k, 0] = box[k, 1]
            problem.middle[k, 1] = tilt[k]
            if bent[k]:
                problem.fixed[k // LANES * FIXED + k % LANES + PARABOLA] = 1.0
        for a in range(axes):
            for k in range(problem.n):
                idle[a, k] = _idle(problem, k, a)
        problem.count = 0
        for block in range(problem.blocks):
            for end in range(2):
                _bounds(problem, block, end, box, sway)
                _limited(problem, block, end, held_right, idle)
        find_runs(problem, 2, problem.awake)
        find_runs(problem, 1, problem.asleep)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(m=cython.Py_ssize_t)
def _used(problem: Problem, b: cython.Py_ssize_t, j: cython.Py_ssize_t) -> cython.double:
    """Return the part of its limit that a row other than one of jerk uses."""
    i = b * ROWS + j
    m = problem.batches[b, 0] * MOTION + problem.batches[b, 1] * END + j
    return fabs(problem.rows[i + A0] * problem.motion[m + B] + problem.rows[i + A1] * problem.motion[m + D])


def thin(problem: Problem, reach: cython.Py_ssize_t, far: cython.double) -> cython.void:
    """Let the bounds and accelerations sleep that the profile ``problem.c`` stays far from.

    Those of intervals beside a rest stay awake.

    Args:
        problem: Its rows awake.
        reach: A row stays awake where the profile comes near its limit within so many intervals.
        far: The part of a limit from which it is near.
    """
    n: cython.Py_ssize_t = problem.n
    axes: cython.Py_ssize_t = problem.d1.shape[2]
    near: cython.double
    import numpy

    # The part that is used of each axis's acceleration, and, in the last row, of bounds.
    peak: cython.double[:, ::1] = numpy.zeros((axes + 1, n))
    with cython.nogil:
        survey(problem)
        for b in range(problem.count):
            if problem.batches[b, 2] != _JERK:
                a = problem.batches[b, 3] if problem.batches[b, 2] == _ACCELERATION else axes
                for j in range(size(problem, problem.batches[b, 0])):
                    if problem.state[b, j] != 0:
                        k = problem.batches[b, 0] * LANES + j
                        peak[a, k] = max(peak[a, k], _used(problem, b, j))
        for b in range(problem.count):
            if problem.batches[b, 2] != _JERK:
                a = problem.batches[b, 3] if problem.batches[b, 2] == _ACCELERATION else axes
                for j in range(size(problem, problem.batches[b, 0])):
                    k = problem.batches[b, 0] * LANES + j
                    if problem.state[b, j] != 0 and problem.ends[k, 0] != 0.0 and problem.ends[k, 3] != 0.0:
                        near = 0.0
                        for m in range(max(k - reach, 0), min(k + reach + 1, n)):
                            near = max(near, peak[a, m])
                        if near < far:
                            problem.state[b, j] = 1
        find_runs(problem, 2, problem.awake)
        find_runs(problem, 1, problem.asleep)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _ceiling(
    problem: Problem,
    k: cython.Py_ssize_t,
    e: cython.Py_ssize_t,
    q: cython.double,
) -> cython.double:
    """Return q, lowered to what steady motion allows at an end of an interval."""
    # The least cube of a speed.
    cube: cython.double = 1e300
    for a in range(problem.d2.shape[2]):
        x = fabs(problem.d2[k, e, a])
        if x * q > problem.limits[0, a]:
            q = problem.limits[0, a] / x
        x = fabs(problem.d3[k, e, a])
        if x > 0.0:
            cube = min(cube, problem.limits[1, a] / x)
    if cube * cube < 2.0 * q * q * q:
        x = cbrt(cube)
        q = min(q, x * x)
    return q


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _gain(
    problem: Problem,
    k: cython.Py_ssize_t,
    e: cython.Py_ssize_t,
    cap: cython.double,
    state: cython.double[::1],
) -> cython.void:
    """Move ``state`` = (q, acceleration) over an interval with full jerk, the acceleration limits and the bound `cap` of q."""
    length: cython.double = problem.h[k]
    acc: cython.double = 1e300
    jerk: cython.double = 1e300
    most: cython.double = 0.0
    q: cython.double = state[0]
    v: cython.double = sqrt(q)
    rate: cython.double = state[1]
    for a in range(problem.d1.shape[2]):
        most = max(most, fabs(problem.d1[k, e, a]))
    for a in range(problem.d1.shape[2]):
        x = fabs(problem.d1[k, e, a])
        # An axis that turns about here asks for nothing; how much that is, would be rounding by rounding.
        if x > _ALIKE * most:
            acc = min(
                acc,
                max(problem.limits[0, a] * problem.factor[k, 0, a] - fabs(problem.d2[k, e, a]) * q, 0.0) / x,
            )
            jerk = min(jerk, problem.limits[1, a] * problem.factor[k, 1, a] / x)
    t = cbrt(6.0 * length / jerk)
    if v * t > length:
        t = length / v
    # Newton from above on the increasing, convex s(t) = length.
    for _ in range(4):
        t -= (((jerk * t / 6.0 + 0.5 * rate) * t + v) * t - length) / ((0.5 * jerk * t + rate) * t + v)
    rate = min(rate + jerk * t, acc)
    v += 0.5 * (state[1] + rate) * t
    state[0] = min(v * v, cap)
    state[1] = min(rate, max(0.0, 0.5 * (state[0] - q) / length))
    if state[0] < cap:
        state[1] = rate


def start(problem: Problem, top: cython.double[:, ::1], part: cython.double) -> cython.void:
    """Fill the free unknowns with a profile to start from: `part` of one that rises and falls with full jerk along the path.

    A forward and a backward pass over the nodes below what steady motion allows, as for acceleration limits alone
    (Bobrow et al., *Int. J. Robotics Research* 4(3), 1985), with the acceleration as second state; the lower of both.

    Args:
        problem: The others are given.
        top: Shape (n, 2), largest q at both ends of each interval.
        part: Factor of q.
    """
    n: cython.Py_ssize_t = problem.n
    c: cython.double[::1] = problem.c
    h: cython.double[::1] = problem.h
    ends: cython.double[:, ::1] = problem.ends
    import numpy

    q: cython.double[:, ::1] = numpy.empty((n, 2))
    state: cython.double[::1] = numpy.zeros(2)
    with cython.nogil:
        for k in range(n):
            q[k, 0] = _ceiling(problem, k, 0, top[k, 0])
            q[k, 1] = _ceiling(problem, k, 2, top[k, 1])
        for k in range(n):
            if k == 0 or ends[k, 0] == 0.0:
                # beside a rest: q' = 2 q (1/e − 1)/h
                state[0] = q[k, 0]
                state[1] = (
                    q[k, 0] * (1.0 / ends[k, 1] - 1.0) / h[k]
                    if ends[k, 1] > 0.0
                    else max(0.0, (c[1] - c[0]) / h[k])
                )
            elif q[k, 0] < (1.0 - _ALIKE) * state[0]:
                state[0] = q[k, 0]
                state[1] = 0.0
            q[k, 0] = state[0]
            _gain(problem, k, 0, q[k, 1], state)
            q[k, 1] = state[0]
        for k in range(n - 1, -1, -1):
            if k == n - 1 or ends[k, 3] == 0.0:
                state[0] = q[k, 1]
                state[1] = q[k, 1] * (1.0 / ends[k, 2] - 1.0) / h[k]
            elif q[k, 1] < (1.0 - _ALIKE) * state[0]:
                state[0] = q[k, 1]
                state[1] = 0.0
            q[k, 1] = state[0]
            _gain(problem, k, 2, q[k, 0], state)
            q[k, 0] = state[0]
            if k + 1 >= problem.free:
                c[k + 1] = part * min(q[k, 0], q[k, 1])
        c[n + 1] = 1.0
        if problem.free == 1:
            c[0] = 1.0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _averaged(
    c: cython.double[::1], out: cython.double[::1], first: cython.Py_ssize_t, stop: cython.Py_ssize_t
) -> vectorized:
    """Fill `out` from `first` up to `stop` with the average of `c` over three neighbours."""
    for k in range(first, stop):
        out[k] = 0.25 * (c[k - 1] + c[k + 1]) + 0.5 * c[k]


def rounded(problem: Problem, times: cython.int, raised: cython.double) -> cython.void:
    """Average the free unknowns over three neighbours, but the outermost, so many `times`; to `raised` times what they were at most."""
    c: cython.double[::1] = problem.c
    import numpy

    most: cython.double[::1] = raised * numpy.asarray(c)
    # Into another array and back, for a compiler to do several at once.
    out: cython.double[::1] = numpy.array(c)
    with cython.nogil:
        for _ in range(times // 2):
            _averaged(c, out, problem.free + 1, problem.n)
            _averaged(out, c, problem.free + 1, problem.n)
        if times % 2 == 1:
            _averaged(c, out, problem.free + 1, problem.n)
            c[:] = out
        for k in range(problem.free, problem.n + 1):
            c[k] = min(c[k], most[k])


def nearest(problem: Problem, margin: cython.double[::1], closest: cython.char[::1]) -> cython.void:
    """Name the constraint that each interval comes nearest to.

    Args:
        problem: As `cncgen.kernels.least_time.solve` has left it.
        margin: Shape (n,), 1 on entry: becomes the least slack of a row of the interval, as a part of its limit.
        closest: Shape (n,): becomes the kind of that row.
    """
    m: cython.Py_ssize_t
    r: cython.double
    with cython.nogil:
        survey(problem)
        for b in range(problem.count):
            m = problem.batches[b, 0] * MOTION + ROOT
            m += (problem.batches[b, 1] if problem.batches[b, 2] == _JERK else 2) * SCALE
            for j in range(size(problem, problem.batches[b, 0])):
                if problem.state[b, j] != 2:
                    continue
                i = b * ROWS + j
                k = problem.batches[b, 0] * LANES + j
                r = problem.rows[i + PART] * problem.motion[m + j]
                w = min(problem.rows[i + W0], problem.rows[i + W1])
                if w < margin[k] * r:
                    margin[k] = w / r
                    closest[k] = problem.batches[b, 2]
