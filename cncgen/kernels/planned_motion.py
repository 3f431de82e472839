# cython: infer_types=True
"""A solution of the least-time problem as a motion: pieces in time, names of limits, bends under it, minima of the speed.

Called by `cncgen.planner.least_time`. ``kind`` is that of `cncgen.planner.least_time.mesh`.
"""

import cython
from cython.cimports.libc.math import atan, atanh, fabs, sqrt

_LEAVE = cython.declare(cython.int, 1)
_ENTER = cython.declare(cython.int, 2)
_LINE = cython.declare(cython.int, 3)
_LEAVE_BACK = cython.declare(cython.int, 4)
_ENTER_BACK = cython.declare(cython.int, 5)
#: Change of the speed times the time of an interval, by its length, up to which the tangents of constant jerk meet in its middle.
_LEVEL = cython.declare(cython.double, 1e-9)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _parabola_time(x: cython.double) -> cython.double:
    """Return artanh(sqrt x)/sqrt x for x > 0 and arctan(sqrt -x)/sqrt -x for x < 0, which are one function; near 0 by its series."""
    root: cython.double = sqrt(fabs(x))
    if fabs(x) < 1e-3:
        return 1.0 + x * (1.0 / 3.0 + x * (1.0 / 5.0 + x * (1.0 / 7.0 + x * (1.0 / 9.0 + x * (1.0 / 11.0)))))
    if x > 0.0:
        return atanh(min(root, 1.0 - 1e-16)) / root
    return atan(root) / root


def pieces(
    kind: cython.const[cython.char][::1],
    h: cython.const[cython.double][::1],
    q: cython.const[cython.double][:, ::1],
    way: cython.const[cython.double][::1],
    out: cython.double[:, ::1],
) -> None:
    """Fill duration, v, a, j and c, the rows of `out`, of the motion on intervals, but lines.

    The jerk j is constant unless the tangents of q meet in the middle though the speed changes: then q is a parabola, and the jerk c v.

    Args:
        kind, h: Shape (n,).
        q, way: Shape (n, 3) and (n,), as in `cncgen.planner.least_time.problem.Solution`.
        out: Shape (5, n).
    """
    with cython.nogil:
        for k in range(h.shape[0]):
            out[1, k] = sqrt(q[k, 0])
            out[2, k] = out[3, k] = out[4, k] = 0.0
            if kind[k] == _LINE:
                continue
            total = out[1, k] + sqrt(q[k, 2])
            if kind[k] == _LEAVE or kind[k] == _ENTER:
                out[0, k] = 3.0 * h[k] / total
                out[3, k] = 2.0 * total / (out[0, k] * out[0, k])
                if kind[k] == _ENTER:
                    out[2, k] = -out[3, k] * out[0, k]
            elif kind[k] == _LEAVE_BACK or kind[k] == _ENTER_BACK:
                out[0, k] = 2.0 * h[k] / total
                out[2, k] = total / out[0, k] if kind[k] == _LEAVE_BACK else -total / out[0, k]
            else:
                out[2, k] = (q[k, 1] - q[k, 0]) / (2.0 * way[k])
                gain = (q[k, 2] - q[k, 1]) / (2.0 * (h[k] - way[k])) - out[2, k]
                out[0, k] = 4.0 * h[k] / (total + sqrt(max(total * total - gain * h[k] / 0.75, 0.0)))
                if way[k] == 0.5 * h[k] and fabs(total - 2.0 * out[1, k]) * out[0, k] > _LEVEL * h[k]:
                    out[0, k] = 2.0 * h[k] / total * _parabola_time(gain * h[k] / (total * total))
                    out[4, k] = gain / h[k]
                else:
                    out[3, k] = gain / out[0, k]


def bends(
    h: cython.const[cython.double][::1],
    x1: cython.const[cython.double][:, :, ::1],
    x2: cython.const[cython.double][:, :, ::1],
    scale: cython.const[cython.double][::1],
    q: cython.const[cython.double][:, ::1],
    v: cython.const[cython.double][::1],
    offset: cython.const[cython.longlong][::1],
    out: cython.double[:, ::1],
) -> None:
    """Fill `out` with what chords over intervals meet: largest speed and sharpest bend on each, and the turn at its start.

    Bends are those at its start, middle and end, and at least that by which its direction turns: about a cusp |x''| is bounded by what
    nodes resolve.

    Args:
        h: Shape (n,), lengths.
        x1, x2: Shape (n, 3, axes), derivatives at three places of each.
        scale: Shape (axes,), what columns are multiplied by to be mm.
        q: Shape (n, 3), ordinates.
        v: Speeds at the starts of pieces.
        offset: Shape (n + 1,), the piece that each interval begins with.
        out: Shape (6, n): speed, sharpest, turn, and the three bends.
    """
    size: cython.double
    inner: cython.double
    with cython.nogil:
        for k in range(h.shape[0]):
            out[0, k] = sqrt(max(q[k, 0], max(q[k, 1], q[k, 2])))
            for e in range(offset[k], offset[k + 1]):
                out[0, k] = max(out[0, k], v[e])
            inner = size = 0.0
            for d in range(scale.shape[0]):
                x = (x1[k, 2, d] - x1[k, 0, d]) * scale[d]
                inner += x * x
                if k > 0:
                    x = (x1[k, 0, d] - x1[k - 1, 2, d]) * scale[d]
                    size += x * x
            inner = sqrt(inner) / h[k]
            out[2, k] = sqrt(size)
            out[1, k] = inner
            for e in range(3):
                size = 0.0
                for d in range(scale.shape[0]):
                    size += x2[k, e, d] * scale[d] * (x2[k, e, d] * scale[d])
                out[3 + e, k] = max(inner, sqrt(size))
                out[1, k] = max(out[1, k], out[3 + e, k])


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _deep(
    s: cython.const[cython.double][::1],
    q: cython.const[cython.double][:],
    first: cython.Py_ssize_t,
    low: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    least_s: cython.double,
) -> cython.bint:
    """Tell whether q at `low` is a fifth below both ends of a way, and costs `least_s` beside the lower of them."""
    level: cython.double = min(q[first], q[last])
    time: cython.double = 0.0
    if not q[low] < 0.8 * level:
        return False
    level = sqrt(level)
    # A line from rest to rest has no speed at its nodes: it counts as slow.
    for k in range(first, last):
        time += 2.0 * (s[k + 1] - s[k]) / (min(sqrt(q[k + 1]), level) + min(sqrt(q[k]), level))
    return time - (s[last] - s[first]) / level >= least_s


def minima(
    s: cython.const[cython.double][::1],
    q: cython.const[cython.double][:],
    least_s: cython.double,
    out: cython.longlong[::1],
) -> int:
    """Fill `out` with the nodes where q has a minimum a fifth below where it turns before and after; return how many there are.

    The time that each costs, beside going through at the lower of these two, is `least_s` at least.

    Args:
        s, q: Shape (n,), nodes, and v^2 there.
        least_s: See above.
        out: Room for n.
    """
    n: cython.Py_ssize_t = q.shape[0]
    found: cython.Py_ssize_t = 0
    # The last two places where q turned, or its start.
    before: cython.Py_ssize_t = 0
    last: cython.Py_ssize_t = 0
    fell: cython.bint = False
    with cython.nogil:
        for i in range(1, n):
            if i < n - 1 and not (q[i - 1] < q[i] > q[i + 1] or q[i - 1] > q[i] < q[i + 1]):
                continue
            if fell and _deep(s, q, before, last, i, least_s):
                out[found] = last
                found += 1
            before = last
            last = i
            fell = i < n - 1 and q[i + 1] > q[i]
    return found
