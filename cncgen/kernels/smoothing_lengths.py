# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, cpow=True
"""The smoothing length along a path, and the knots and samples that it lays, for `cncgen.kernels.smoothing`.

The length is kept at the ends of the pieces of the path, and grows away from them where a piece is long
(docs/smoothing.md).
"""

import cython
from cython.cimports.libc.math import floor, sqrt

#: Degree of the spline.
_P = cython.declare(cython.Py_ssize_t, 4)
#: Slope of the smoothing length along the path.
_GRADE = cython.declare(cython.double, 0.4)
#: Knot distance as a part of the smoothing length.
_MESH = cython.declare(cython.double, 1.0)
#: Knot distances that are left before a cut up to which they make one span, and two. These and the next ones are no round
#: numbers: programs are made of round numbers, and where the two are equal rounding chooses.
_ONE = cython.declare(cython.double, 1.0873)
_TWO = cython.declare(cython.double, 1.6127)
#: Strides between cuts up to which all are made to fit, and what is added to their number before its fraction goes.
_MANY = cython.declare(cython.Py_ssize_t, 64)
_UP = cython.declare(cython.double, 0.6873)
#: Knot distance, as a part of what it would be, below which a cut makes no knot beside another: the equations would lose
#: all digits, (L/h)⁶ is their condition.
_LEAST = cython.declare(cython.double, 0.02)
#: Smoothing lengths around the end of a piece in which the tolerance that is used counts.
_REACH = cython.declare(cython.double, 2.0137)
#: Part of a knot span that a piece has to be longer, so that knots and middles on it are samples: a straight one, and a
#: curved one, whose every point is meant.
_LONGER = cython.declare(cython.double, 1.0137)
_CURVED = cython.declare(cython.double, 0.2037)
#: Steps of a factor by which the length changes: knots add up lengths, thousands of them in a window, and rounding of the
#: curve would multiply from round to round.
_STEPS = cython.declare(cython.double, 1024.0)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def length_at(
    t: cython.const[cython.double][::1], scale: cython.double[::1], k: cython.Py_ssize_t, at: cython.double
) -> cython.double:
    """Smoothing length at a place of piece k: that of the ends, growing away from them where the piece is long.

    On pieces of up to two lengths it does not grow: it would do so and shrink again from knot to knot, and shake the curve.
    From eight lengths on it grows freely.
    """
    left: cython.double = scale[k] + _GRADE * (at - t[k])
    right: cython.double = scale[k + 1] + _GRADE * (t[k + 1] - at)
    larger: cython.double = max(scale[k], scale[k + 1])
    length: cython.double = t[k + 1] - t[k]
    free: cython.double = min(max((length / larger - 2.0) / 6.0, 0.0), 1.0)
    return min(left, right, larger + 0.5 * _GRADE * free * length)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def lower(t: cython.const[cython.double][::1], scale: cython.double[::1]) -> cython.void:
    """Lower smoothing lengths at the ends of pieces until their slope is at most `_GRADE`."""
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t = t.shape[0] - 1
    for k in range(n):
        scale[k + 1] = min(scale[k + 1], scale[k] + _GRADE * (t[k + 1] - t[k]))
    for k in range(n - 1, -1, -1):
        scale[k] = min(scale[k], scale[k + 1] + _GRADE * (t[k + 1] - t[k]))


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _stride(
    t: cython.const[cython.double][::1], scale: cython.double[::1], k: cython.Py_ssize_t, at: cython.double
) -> cython.double:
    """Distance from a place of piece k to the next knot: a smoothing length, taken in the middle of the step."""
    n: cython.Py_ssize_t = t.shape[0] - 1
    step: cython.double = _MESH * length_at(t, scale, k, at)
    middle: cython.double = min(at + 0.5 * step, t[n])
    while k < n - 1 and t[k + 1] <= middle:
        k += 1
    return _MESH * min(length_at(t, scale, k, middle), 1.25 * step)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _share(
    t: cython.const[cython.double][::1],
    scale: cython.double[::1],
    k: cython.Py_ssize_t,
    at: cython.double,
    end: cython.double,
) -> cython.double:
    """How many strides lead from a place of piece k to `end`; −1 for more than `_MANY`."""
    n: cython.Py_ssize_t = t.shape[0] - 1
    count: cython.Py_ssize_t = 0
    step: cython.double = 1.0
    while at < end:
        if count == _MANY:
            return -1.0
        while k < n - 1 and t[k + 1] <= at:
            k += 1
        step = _stride(t, scale, k, at)
        at += step
        count += 1
    return count - (at - end) / step


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _evenly(
    t: cython.const[cython.double][::1],
    scale: cython.double[::1],
    k: cython.Py_ssize_t,
    knots: cython.double[::1],
    first: cython.Py_ssize_t,
    count: cython.Py_ssize_t,
    share: cython.double,
    end: cython.double,
) -> cython.void:
    """Lay `count` knots after ``knots[first]``, which lies on piece k, the last of them at `end`: by steps of which about that
    `share` is taken, all by one factor.
    """
    j: cython.Py_ssize_t
    n: cython.Py_ssize_t = t.shape[0] - 1
    begin: cython.double = knots[first]
    at: cython.double = begin
    for j in range(first + 1, first + count + 1):
        while k < n - 1 and t[k + 1] <= at:
            k += 1
        at += share * _stride(t, scale, k, at)
        knots[j] = at
    share = (end - begin) / (at - begin)
    for j in range(first + 1, first + count):
        knots[j] = begin + share * (knots[j] - begin)
    knots[first + count] = end


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def lay(
    t: cython.const[cython.double][::1],
    scale: cython.double[::1],
    cuts: cython.const[cython.double][::1],
    knots: cython.double[::1],
    laid: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """Lay knots from ``knots[laid]`` to the last cut; returns the index of the last, −1 without room.

    Knots stand a smoothing length apart, taken in the middle of the step. Every cut is a knot, but where the one before
    it or the last one of all is closer than `_LEAST` of that. Between cuts that are `_MANY` steps apart at most all steps
    are longer or shorter by one factor, so that on both sides of a cut knots stand alike.
    """
    i: cython.Py_ssize_t = laid
    k: cython.Py_ssize_t = 0
    c: cython.Py_ssize_t
    n: cython.Py_ssize_t = t.shape[0] - 1
    at: cython.double = knots[laid]
    end: cython.double = cuts[cuts.shape[0] - 1]
    step: cython.double
    share: cython.double
    count: cython.Py_ssize_t
    m: cython.Py_ssize_t = 0
    for c in range(cuts.shape[0]):
        m = k
        while m < n - 1 and t[m + 1] <= cuts[c]:
            m += 1
        step = _LEAST * _MESH * length_at(t, scale, m, cuts[c])
        if cuts[c] < end and (cuts[c] - at < step or end - cuts[c] < step):
            continue
        while k < n - 1 and t[k + 1] <= at:
            k += 1
        share = _share(t, scale, k, at, cuts[c])
        if share > 0.0:
            count = max(cython.cast(cython.Py_ssize_t, share + _UP), 1)
            if i + count + _P + 1 >= knots.shape[0]:
                return -1
            _evenly(t, scale, k, knots, i, count, share / count, cuts[c])
            i += count
            at = cuts[c]
            continue
        while at < cuts[c]:
            while k < n - 1 and t[k + 1] <= at:
                k += 1
            step = _stride(t, scale, k, at)
            if at + _TWO * step >= cuts[c]:
                # What is left makes one span, or two of half of it.
                if at + _ONE * step < cuts[c]:
                    at = 0.5 * (at + cuts[c])
                else:
                    at = cuts[c]
            else:
                at = at + step
            i += 1
            if i + _P + 1 >= knots.shape[0]:
                return -1
            knots[i] = at
    return i


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def choose(
    t: cython.const[cython.double][::1],
    bend: cython.const[cython.double][::1],
    knots: cython.double[::1],
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    at: cython.double[::1],
) -> cython.Py_ssize_t:
    """Choose where to compare: the ends of pieces, and on long and on curved pieces knots and middles of their spans too.

    Returns how many, −1 without room.
    """
    n: cython.Py_ssize_t = t.shape[0] - 1
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t = first
    count: cython.Py_ssize_t = 0
    here: cython.double
    longer: cython.double
    for k in range(n):
        if t[k + 1] <= knots[first]:
            continue
        if count + 2 >= at.shape[0]:
            return -1
        if t[k] >= knots[first]:
            at[count] = t[k]
            count += 1
        while i < last and knots[i + 1] <= t[k]:
            i += 1
        longer = _LONGER if bend[k] == 0.0 else _CURVED
        if t[k + 1] - t[k] <= longer * (knots[i + 1] - knots[i]):
            continue
        while i < last and knots[i] < t[k + 1]:
            if count + 4 >= at.shape[0]:
                return -1
            if knots[i] > t[k]:
                at[count] = knots[i]
                count += 1
            here = 0.5 * (knots[i] + knots[i + 1])
            if t[k] < here and here < t[k + 1]:
                at[count] = here
                count += 1
            i += 1
        i = max(i - 1, first)
    at[count] = t[n]
    return count + 1


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def adjust(
    t: cython.const[cython.double][::1],
    scale: cython.double[::1],
    used: cython.double[:, ::1],
    longest: cython.const[cython.double][::1],
    grow: cython.bint,
    least: cython.double,
    change: cython.double[::1],
) -> cython.void:
    """Shrink the smoothing length where the tolerance is exceeded, grow it where much of it is left.

    At the end of a piece counts what is used within two smoothing lengths of it.
    """
    n: cython.Py_ssize_t = t.shape[0] - 1
    k: cython.Py_ssize_t
    m: cython.Py_ssize_t
    most: cython.double
    reach: cython.double
    for k in range(n + 1):
        reach = _REACH * scale[k]
        most = 0.0
        m = k
        while m < n and t[m] < t[k] + reach:
            most = max(most, used[m, 0])
            if 0.5 * (t[m] + t[m + 1]) < t[k] + reach:
                most = max(most, used[m, 1])
            m += 1
        m = k - 1
        while m >= 0 and t[m + 1] > t[k] - reach:
            most = max(most, used[m, 1])
            if 0.5 * (t[m] + t[m + 1]) > t[k] - reach:
                most = max(most, used[m, 0])
            m -= 1
        change[k] = 1.0
        if most > 1.0:
            change[k] = max(0.35, (0.5 + 0.5 * least if grow else 0.93) / most)
        elif grow and most < least:
            change[k] = min(1.6, sqrt((0.5 + 0.5 * least) / max(most, 1e-3)))
        change[k] = floor(_STEPS * change[k]) / _STEPS
    for k in range(n + 1):
        scale[k] = min(scale[k] * change[k], longest[k])
    lower(t, scale)
