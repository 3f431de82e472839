# cython: infer_types=True
"""Where the tangents of q at both ends of an interval meet, so that the jerk along the path is constant on it (docs/least-time.md).

Constant jerk j over an interval of length h takes from (v₀, a₀) to (v₁, a₁), with gain g = a₁ − a₀ and mean speed m = (v₀ + v₁)/2, the time

    T = 2 h / (m + (m² − g h/3)^½),

and the tangents of q = v² at its ends, of slopes 2 a₀ and 2 a₁, meet at the way l = h/2 − (v₁ − v₀) T/12. That way is not known before the
motion is. So `settle` takes it from the iterate, as `least_time_between` takes the shares; the changes shrink with the steps.

`least_time` calls these functions as C (``least_time_ways.pxd``).
"""

import cython
from cython.cimports.cncgen.kernels.least_time_matrix import survey
from cython.cimports.cncgen.kernels.least_time_problem import (
    A0, A1, A2, D, END, FIXED, HELD, LANES, LENGTH, MOTION, PARABOLA, PULL, RATE, ROOT, ROWS, SCALE, SIZE, WAY, Problem,
    lay, size, vectorized,
)  # fmt: skip
from cython.cimports.libc.math import fabs, sqrt

#: Of the mean speed's square, the least (m² − g h/3): that of constant jerk from rest, beyond which no constant jerk goes.
_REST = cython.declare(cython.double, 1.0 / 9.0)
#: Mean speed over the slower one of an interval from which on its q is a parabola: beside the tip of a cusp, where the speed is next to
#: nothing, ways change as much with the iterates as these with the ways, and neither settles.
_APART = cython.declare(cython.double, 1.8)
#: The largest part of the mean speed by which κ at a slow end is taken to be more than in the mean; the other end has all of the jerk.
_SLOW = cython.declare(cython.double, 8.0)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _settle(
    problem: Problem,
    fixed: cython.double[::1],
    motion: cython.double[::1],
    sums: cython.double[::1],
    block: cython.Py_ssize_t,
    apart: cython.double,
) -> vectorized:
    """Do `settle` for a block; changes of ways as parts of h in the first column of `sums`."""
    for j in range(size(problem, block)):
        f = block * FIXED + j
        m = block * MOTION + j
        h = fixed[f + LENGTH]
        gain = motion[m + END + D] - motion[m + D]
        rise = motion[m + SCALE + SIZE] - motion[m + SIZE]
        mean = 0.5 * (motion[m + SCALE + SIZE] + motion[m + SIZE])
        time = 2.0 * h / (mean + sqrt(max(mean * mean - gain * h / 3.0, _REST * mean * mean)))
        slow = min(motion[m + SCALE + SIZE], motion[m + SIZE])
        fixed[f + PARABOLA] = 1.0 if mean > apart * slow else fixed[f + PARABOLA]
        bent = 1.0 - fixed[f + PARABOLA]
        way = 0.5 * h - bent * min(max(rise * time / 12.0, -0.25 * h), 0.25 * h)
        sums[j] = max(sums[j], fabs(way - fixed[f + WAY]) / h)
        fixed[f + WAY] = way
        rate = h / time
        fixed[f + RATE] = rate
        fixed[f + PULL] = 1.0 + bent * (min(rate * motion[m + ROOT], _SLOW) - 1.0)
        fixed[f + PULL + LANES] = 1.0 + bent * (min(rate * motion[m + SCALE + ROOT], _SLOW) - 1.0)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def settle(problem: Problem, choose: cython.bint) -> cython.double:
    """Set the ways by the motion of the unknowns, and all that follows from them but rows; return their largest change as a part of h.

    Where the window starts in motion, its second unknown follows, as q and its slope are given.

    Args:
        problem: Its motion as `cncgen.kernels.least_time_matrix.survey` fills it.
        choose: Whether q becomes a parabola where the speed changes by a multiple.
    """
    sums: cython.double[::1] = problem.sums
    most: cython.double = 0.0
    for j in range(LANES):
        sums[j] = 0.0
    for block in range(problem.blocks):
        _settle(problem, problem.fixed, problem.motion, sums, block, _APART if choose else 1e300)
    for j in range(LANES):
        most = max(most, sums[j])
    lay(problem)
    if problem.free > 1:
        problem.c[1] = problem.c[0] + 2.0 * problem.start * problem.way[0]
    return most


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def meet(problem: Problem) -> cython.void:
    """Where the motion turns back, give both sides the smaller one of their accelerations."""
    c: cython.double[::1] = problem.c
    for k in range(problem.n - 1):
        if problem.back[k] != 0:
            one = problem.ends[k, 2] / problem.extra[k, 1]
            other = problem.ends[k + 1, 1] / problem.extra[k + 1, 0]
            least = min(one * c[k + 1], other * c[k + 2])
            c[k + 1], c[k + 2] = least / one, least / other


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _turn(
    rows: cython.double[::1], fixed: cython.double[::1], i: cython.Py_ssize_t, f: cython.Py_ssize_t
) -> vectorized:
    """Scale the coefficients of κ of a batch."""
    for j in range(LANES):
        rows[i + j] *= fixed[f + PULL + j] / fixed[f + HELD + j]


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def refit(problem: Problem) -> cython.void:
    """Set the coefficients of rows that follow from the ways: those of κ, and of the unknowns' own bounds."""
    rows: cython.double[::1] = problem.rows
    fixed: cython.double[::1] = problem.fixed
    for b in range(problem.count):
        block = problem.batches[b, 0]
        if problem.batches[b, 2] == 2:
            _turn(rows, fixed, b * ROWS + A2, block * FIXED + problem.batches[b, 1] * LANES)
        elif problem.batches[b, 2] == 0 and problem.batches[b, 1] == 0:
            for j in range(size(problem, block)):
                k = block * LANES + j
                i = b * ROWS + j
                if problem.state[b, j] != 0 and rows[i + A1] != 0.0:
                    moved = problem.middle[k, 0] + problem.middle[k, 1] * (
                        problem.way[k] - 0.5 * problem.h[k]
                    )
                    scale = 1.0 / max(moved, 0.5 * problem.middle[k, 0])
                    rows[i + A0] = scale
                    rows[i + A1] = 2.0 * problem.way[k] * scale
    for block in range(problem.blocks):
        for j in range(2 * LANES):
            fixed[block * FIXED + HELD + j] = fixed[block * FIXED + PULL + j]


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def agree(problem: Problem, least: cython.double, most: cython.int) -> cython.double:
    """Settle the ways until none changes by more than a part of its interval, or so many times; return the last change."""
    change: cython.double = 1.0
    meet(problem)
    survey(problem)
    for _ in range(most):
        change = settle(problem, False)
        meet(problem)
        survey(problem)
        if change <= least:
            break
    return change
