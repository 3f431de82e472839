# cython: infer_types=True
"""The intervals of a least-time problem, as arrays of a mesh, and as `cncgen.kernels.least_time_problem` takes them.

Called by `cncgen.planner.least_time.problem`. `kind` is that of `cncgen.planner.least_time.mesh`; ``at`` names the spline intervals.
Beside a rest q' must match that of constant jerk, q ~ s^(4/3), so q' = 4 q/(3 h); where the motion turns back, that of constant acceleration,
q' = q/h (docs/least-time.md).
"""

import cython
from cython.cimports.libc.math import cbrt, fabs, pow, sqrt

_LEAVE = cython.declare(cython.int, 1)
_ENTER = cython.declare(cython.int, 2)
_LEAVE_BACK = cython.declare(cython.int, 4)
_ENTER_BACK = cython.declare(cython.int, 5)
_INFINITE = cython.declare(cython.double, float("inf"))
#: Two bounds of q, or two parts of a limit, that differ by less than this part are taken to be equal: rounding, which differs
#: from one unit of length to another, must not change the problem.
_ALIKE = cython.declare(cython.double, 1e-6)
#: A jump of the direction, and of the acceleration of an axis as a part of its limit, for which both sides of a node are looked at.
_TURN = cython.declare(cython.double, 1e-9)
_JUMP = cython.declare(cython.double, 1e-4)


def beside_rests(
    kind: cython.const[cython.char][::1],
    h: cython.const[cython.double][::1],
    at: cython.const[cython.longlong][::1],
    moving: cython.bint,
    extra: cython.double[:, ::1],
    back: cython.char[::1],
) -> None:
    """Fill the weights in the time of the intervals at rests beside those of `at`.

    Args:
        kind, h: Shape (n,), the intervals.
        at: Shape (k,).
        moving: Whether the motion is under way at the start.
        extra, back: Shape (k, 2) and (k,), see `cncgen.kernels.least_time_problem`.
    """
    with cython.nogil:
        for i in range(at.shape[0]):
            k = at[i]
            extra[i, 0] = extra[i, 1] = 0.0
            if not (moving and k == 0):
                if kind[k - 1] == _LEAVE:
                    extra[i, 0] = 3.0 * h[k - 1]
                elif kind[k - 1] == _LEAVE_BACK:
                    extra[i, 0] = 2.0 * h[k - 1]
            back[i] = kind[k + 1] == _ENTER_BACK
            if back[i]:
                extra[i, 1] = 2.0 * h[k + 1]
            elif kind[k + 1] == _ENTER:
                extra[i, 1] = 3.0 * h[k + 1]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _rest_top(
    k: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    h: cython.double,
    x1: cython.const[cython.double][:, :, ::1],
    x2: cython.const[cython.double][:, :, ::1],
    x3: cython.const[cython.double][:, :, ::1],
    top: cython.const[cython.double][:, ::1],
    factor: cython.const[cython.double][:, :, ::1],
    limits: cython.const[cython.double][:, ::1],
) -> cython.double:
    """Return the largest q at the moving `end` of interval `k`, which leaves or enters rest.

    With constant jerk j from rest, s = j t^3/6: q = (9/2 j s^2)^(2/3), and an axis has at most the acceleration
    |x'| (6 j^2 s)^(1/3) + |x''| q and the jerk j (|x'| + 9 |x''| s + 9/2 |x'''| s^2). Held in the middle and at the moving
    end: at the rest itself, where a curve may be infinitely sharp, |x'| alone counts.
    """
    jerk: cython.double = _INFINITE
    most: cython.double = _INFINITE
    for place in range(2):
        e = end if place else 1
        s = h if place else 0.5 * h
        for a in range(x1.shape[2]):
            steep = max(fabs(x1[k, 0, a]), max(fabs(x1[k, 1, a]), fabs(x1[k, 2, a])))
            x = fabs(x2[k, e, a])
            y = steep + 9.0 * x * s + 4.5 * fabs(x3[k, e, a]) * s * s
            jerk = min(jerk, limits[1, a] * factor[k, 1, a] / y)
            y = cbrt(4.5 * s * s)
            y = steep * cbrt(6.0 * s) + x * (y * y)
            jerk = min(jerk, pow(limits[0, a] * factor[k, 0, a] / y, 1.5))
        most = min(most, top[k, e] if place else top[k, e] / pow(0.5, 4.0 / 3.0))
    x = cbrt(4.5 * jerk * (h * h))
    return min(x * x, most)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _back_top(
    k: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    h: cython.double,
    x1: cython.const[cython.double][:, :, ::1],
    x2: cython.const[cython.double][:, :, ::1],
    x3: cython.const[cython.double][:, :, ::1],
    top: cython.const[cython.double][:, ::1],
    factor: cython.const[cython.double][:, :, ::1],
    limits: cython.const[cython.double][:, ::1],
) -> cython.double:
    """Return the largest q at the moving `end` of interval `k`, beside a place where the motion turns back.

    With constant acceleration a, q = 2 a s, and an axis has at most the acceleration a (|x'| + 2 |x''| s) and the jerk
    (2 a)^(3/2) s^(1/2) (3/2 |x''| + |x'''| s). Held in the middle and at the moving end.
    """
    acceleration: cython.double = _INFINITE
    for place in range(2):
        e = end if place else 1
        s = h if place else 0.5 * h
        for a in range(x1.shape[2]):
            steep = max(fabs(x1[k, 0, a]), max(fabs(x1[k, 1, a]), fabs(x1[k, 2, a])))
            y = steep + 2.0 * fabs(x2[k, e, a]) * s
            acceleration = min(acceleration, limits[0, a] * factor[k, 0, a] / y)
            y = sqrt(s) * (1.5 * fabs(x2[k, e, a]) + fabs(x3[k, e, a]) * s)
            acceleration = min(acceleration, 0.5 * pow(limits[1, a] * factor[k, 1, a] / y, 2.0 / 3.0))
        acceleration = min(acceleration, 0.5 * top[k, e] / s)
    return 2.0 * acceleration * h


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _middle(top: cython.const[cython.double][:, ::1], k: cython.Py_ssize_t) -> cython.double:
    """Return the bound of the middle ordinate: a convex bound is met by the parabola through its three values, a concave one,
    maybe with an edge, by its chords."""
    return max(
        min(2.0 * top[k, 1] - 0.5 * (top[k, 0] + top[k, 2]), top[k, 1]),
        0.5 * min(top[k, 0], min(top[k, 1], top[k, 2])),
    )


def bounds(
    kind: cython.const[cython.char][::1],
    h: cython.const[cython.double][::1],
    x1: cython.const[cython.double][:, :, ::1],
    x2: cython.const[cython.double][:, :, ::1],
    x3: cython.const[cython.double][:, :, ::1],
    top: cython.const[cython.double][:, ::1],
    factor: cython.const[cython.double][:, :, ::1],
    node_top: cython.const[cython.double][::1],
    node_acceleration: cython.const[cython.double][::1],
    limits: cython.const[cython.double][:, ::1],
    at: cython.const[cython.longlong][::1],
    box: cython.double[:, ::1],
    tilt: cython.double[::1],
    edge: cython.double[:, ::1],
    sway: cython.double[:, ::1],
    held_right: cython.char[::1],
) -> None:
    """Fill the bounds of the spline intervals `at`.

    Args:
        kind, h, x1, x2, x3, top, factor, node_top, node_acceleration, limits: As in `cncgen.planner.least_time.problem.Intervals`.
        at: Shape (k,).
        box: Shape (k, 3), bounds of the ordinates that are rows, infinite where there is none: an ordinate between two bounded
            ones is bounded as they are, and needs no row of its own if all three bounds are equal.
        tilt: Shape (k,), how fast the bound of the middle ordinate rises with the way that it stands for; 0 without a bound.
        edge: Shape (k, 2), bounds of q at both ends.
        sway: Shape (k, 2), bounds of |q'|/2 at both ends, infinite where the neighbour has them.
        held_right: Shape (k,), whether acceleration must be held at the right end too.
    """
    enters: cython.bint
    held: cython.bint
    with cython.nogil:
        for i in range(at.shape[0]):
            k = at[i]
            enters = kind[k + 1] == _ENTER or kind[k + 1] == _ENTER_BACK
            edge[i, 0] = min(top[k, 0], node_top[k])
            if k > 0:
                edge[i, 0] = min(edge[i, 0], top[k - 1, 2])
                if kind[k - 1] == _LEAVE:
                    edge[i, 0] = min(
                        edge[i, 0], _rest_top(k - 1, 2, h[k - 1], x1, x2, x3, top, factor, limits)
                    )
                elif kind[k - 1] == _LEAVE_BACK:
                    edge[i, 0] = min(
                        edge[i, 0], _back_top(k - 1, 2, h[k - 1], x1, x2, x3, top, factor, limits)
                    )
            edge[i, 1] = min(min(top[k + 1, 0], top[k, 2]), node_top[k + 1])
            sway[i, 0], sway[i, 1] = node_acceleration[k], _INFINITE
            if enters:
                if kind[k + 1] == _ENTER:
                    most = _rest_top(k + 1, 0, h[k + 1], x1, x2, x3, top, factor, limits)
                else:
                    most = _back_top(k + 1, 0, h[k + 1], x1, x2, x3, top, factor, limits)
                edge[i, 1] = min(edge[i, 1], most)
                sway[i, 1] = node_acceleration[k + 1]
            middle = _middle(top, k)
            tilt[i] = (top[k, 2] - top[k, 0]) / h[k] if max(top[k, 0], top[k, 2]) < 1e300 else 0.0
            box[i, 0], box[i, 1], box[i, 2] = edge[i, 0], middle, edge[i, 1] if enters else _INFINITE
            if (
                i > 0
                and kind[k - 1] == 0
                and fabs(middle - edge[i, 0]) <= _ALIKE * edge[i, 0]
                and fabs(_middle(top, k - 1) - edge[i, 0]) <= _ALIKE * edge[i, 0]
            ):
                box[i, 0] = _INFINITE
            held = enters
            for a in range(x1.shape[2]):
                held = held or fabs(x1[k + 1, 0, a] - x1[k, 2, a]) > _TURN
                held = held or fabs(x2[k + 1, 0, a] - x2[k, 2, a]) * top[k, 2] / limits[0, a] > _JUMP
                # Beside a corner that takes a part of the limit, the next interval may have more of it left than this one.
                held = held or factor[k + 1, 0, a] > (1.0 + _ALIKE) * factor[k, 0, a]
            held_right[i] = held


def ordinates(
    kind: cython.const[cython.char][::1],
    at: cython.const[cython.longlong][::1],
    by: cython.const[cython.double][:, ::1],
    c: cython.const[cython.double][::1],
    q: cython.double[:, ::1],
) -> None:
    """Fill the ordinates of q, shape (n, 3), of intervals by the unknowns `c`, shape (k + 2,); at rest they are 0.

    Args:
        kind: Shape (n,).
        at, by: Shape (k,) and (k, 4), spline intervals, and E0 to E3 of `cncgen.kernels.least_time_problem`.
        c, q: See above.
    """
    with cython.nogil:
        for i in range(at.shape[0]):
            k = at[i]
            q[k, 0] = by[i, 0] * c[i] + by[i, 1] * c[i + 1]
            q[k, 1] = c[i + 1]
            q[k, 2] = by[i, 2] * c[i + 1] + by[i, 3] * c[i + 2]
            if k > 0 and (kind[k - 1] == _LEAVE or kind[k - 1] == _LEAVE_BACK):
                q[k - 1, 2] = q[k, 0]
            if kind[k + 1] == _ENTER or kind[k + 1] == _ENTER_BACK:
                q[k + 1, 0] = q[k, 2]
