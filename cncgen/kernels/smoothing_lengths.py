# cython: cpow=True, infer_types=True
"""The smoothing length L along a path, and the knots and samples that follow from it, for `cncgen.kernels.smoothing`.

L is given at the ends of the pieces of the path, and grows away from them where a piece is long (docs/smoothing.md, The length).
Knots stand L apart: a *stride* is the distance from one to the next, and ∫ dt/L counts strides.
"""

import cython
from cython.cimports.libc.math import expm1, floor, log, sqrt

#: Degree of the spline.
_P = cython.declare(cython.Py_ssize_t, 4)
#: Largest slope of the smoothing length along the path.
_GRADE = cython.declare(cython.double, 0.4)
#: Knot distance as a part of the smoothing length.
_MESH = cython.declare(cython.double, 1.0)
#: Increase of log L from knot to knot where L has the slope `_GRADE`. ∫ dt/L would give 0.4; with 0.392 knots stand 2 % closer
#: there, which is a little faster on average (docs/smoothing.md, Knots).
_RATE = cython.declare(cython.double, 0.392)
#: Added to the number of strides between two cuts before it is truncated. This and the next numbers are not round on purpose:
#: programs are made of round numbers, and where a comparison of two equal ones decides, rounding would decide.
_UP = cython.declare(cython.double, 0.6873)
#: A cut makes no knot if that is nearer to another than this part of a stride: the condition of the normal equations grows with
#: (L/h)⁶, and they would lose all digits.
_LEAST = cython.declare(cython.double, 0.02)
#: L at the end of a piece is adjusted to the tolerance that is used within this many L of it.
_REACH = cython.declare(cython.double, 2.0137)
#: Knots and middles of spans on a piece are samples if the piece is longer than this multiple of the span: for straight pieces,
#: and for curved ones, of which every point is meant.
_LONGER = cython.declare(cython.double, 1.0137)
_CURVED = cython.declare(cython.double, 0.2037)
#: L changes by factors that are multiples of 1/1024. A knot is placed by the sum of thousands of lengths, so without that the
#: rounding of the curve would grow from round to round.
_STEPS = cython.declare(cython.double, 1024.0)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _largest(start: cython.double, end: cython.double, length: cython.double) -> cython.double:
    """Return the largest smoothing length on a piece, by its length and the smoothing lengths at its ends.

    On pieces of up to two L it does not grow: it would grow and shrink again from knot to knot, to no use. On those of eight L and
    more it grows freely.
    """
    larger: cython.double = max(start, end)
    free: cython.double = min(max((length / larger - 2.0) / 6.0, 0.0), 1.0)
    return max(min(larger + 0.5 * _GRADE * free * length, 0.5 * (start + end + _GRADE * length)), larger)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def length_at(
    t: cython.const[cython.double][::1], scale: cython.double[::1], k: cython.Py_ssize_t, at: cython.double
) -> cython.double:
    """Return the smoothing length at a place of piece k: that of the ends, growing away from them where the piece is long."""
    left: cython.double = scale[k] + _GRADE * (at - t[k])
    right: cython.double = scale[k + 1] + _GRADE * (t[k + 1] - at)
    return min(left, right, _largest(scale[k], scale[k + 1], t[k + 1] - t[k]))


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def lower(t: cython.const[cython.double][::1], scale: cython.double[::1]) -> cython.void:
    """Lower smoothing lengths at the ends of pieces until their slope is at most `_GRADE`: a forward and a backward pass."""
    n: cython.Py_ssize_t = t.shape[0] - 1
    for k in range(n):
        scale[k + 1] = min(scale[k + 1], scale[k] + _GRADE * (t[k + 1] - t[k]))
    for k in range(n - 1, -1, -1):
        scale[k] = min(scale[k], scale[k + 1] + _GRADE * (t[k + 1] - t[k]))


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _growing(start: cython.double, end: cython.double) -> cython.double:
    """Return how many strides lie on the way on which L grows, or shrinks, from one length to another at full slope."""
    return log(end / start) / _RATE if end > start else 0.0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _count(
    t: cython.const[cython.double][::1], scale: cython.double[::1], strides: cython.double[::1]
) -> cython.void:
    """Fill `strides` with how many lead from the start to the ends of pieces: ∫dt/L, more of it where L changes (`_RATE`)."""
    strides[0] = 0.0
    for k in range(t.shape[0] - 1):
        length = t[k + 1] - t[k]
        most = _largest(scale[k], scale[k + 1], length)
        strides[k + 1] = (
            strides[k]
            + _growing(scale[k], most)
            + _growing(scale[k + 1], most)
            + max(length - (2.0 * most - scale[k] - scale[k + 1]) / _GRADE, 0.0) / most
        )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _strides_at(
    t: cython.const[cython.double][::1],
    scale: cython.double[::1],
    strides: cython.double[::1],
    k: cython.Py_ssize_t,
    at: cython.double,
) -> cython.double:
    """How many strides lead to a place of piece k."""
    after: cython.double = at - t[k]
    before: cython.double = t[k + 1] - at
    most: cython.double = _largest(scale[k], scale[k + 1], t[k + 1] - t[k])
    if after * _GRADE <= most - scale[k]:
        return strides[k] + _growing(scale[k], scale[k] + _GRADE * after)
    if before * _GRADE <= most - scale[k + 1]:
        return strides[k + 1] - _growing(scale[k + 1], scale[k + 1] + _GRADE * before)
    return strides[k] + _growing(scale[k], most) + (after - (most - scale[k]) / _GRADE) / most


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _place_of(
    t: cython.const[cython.double][::1],
    scale: cython.double[::1],
    strides: cython.double[::1],
    k: cython.Py_ssize_t,
    count: cython.double,
) -> cython.double:
    """The place on piece k to which so many strides lead."""
    after: cython.double = count - strides[k]
    before: cython.double = strides[k + 1] - count
    most: cython.double = _largest(scale[k], scale[k + 1], t[k + 1] - t[k])
    rise: cython.double = _growing(scale[k], most)
    if after <= rise:
        return t[k] + scale[k] * expm1(_RATE * after) / _GRADE
    if before <= _growing(scale[k + 1], most):
        return t[k + 1] - scale[k + 1] * expm1(_RATE * before) / _GRADE
    return t[k] + (most - scale[k]) / _GRADE + (after - rise) * most


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def lay(
    t: cython.const[cython.double][::1],
    scale: cython.double[::1],
    cuts: cython.const[cython.double][::1],
    knots: cython.double[::1],
    laid: cython.Py_ssize_t,
    strides: cython.double[::1],
) -> cython.Py_ssize_t:
    """Lay knots from ``knots[laid]`` to the last cut; returns the index of the last, −1 without room.

    Every cut is a knot, but where the one before it or the last one of all is closer than `_LEAST` of a knot distance. Between
    cuts knots stand a smoothing length apart: one stride (`_count`), or as near to that as their number lets it be. So the
    reverse of a path has the same knots, and on both sides of a cut they stand alike.

    Args:
        t, scale: Ends of pieces, and the smoothing lengths there.
        cuts: Ascending.
        knots: Room for them, up to `laid` in place.
        laid: Index of the last one in place.
        strides: Shape as `t`, to work in.
    """
    i: cython.Py_ssize_t = laid
    k: cython.Py_ssize_t = 0
    n: cython.Py_ssize_t = t.shape[0] - 1
    at: cython.double = knots[laid]
    end: cython.double = cuts[cuts.shape[0] - 1]
    share: cython.double
    count: cython.Py_ssize_t
    m: cython.Py_ssize_t = 0
    _count(t, scale, strides)
    while k < n - 1 and t[k + 1] <= at:
        k += 1
    begun = _strides_at(t, scale, strides, k, at)
    for c in range(cuts.shape[0]):
        while m < n - 1 and t[m + 1] <= cuts[c]:
            m += 1
        least = _LEAST * _MESH * length_at(t, scale, m, cuts[c])
        if cuts[c] < end and (cuts[c] - at < least or end - cuts[c] < least):
            continue
        here = _strides_at(t, scale, strides, m, cuts[c])
        share = (here - begun) / _MESH
        count = max(cython.cast(cython.Py_ssize_t, share + _UP), 1)
        if i + count + _P + 1 >= knots.shape[0]:
            return -1
        share = (here - begun) / count
        for j in range(1, count):
            while k < n - 1 and strides[k + 1] <= begun + j * share:
                k += 1
            knots[i + j] = _place_of(t, scale, strides, k, begun + j * share)
        i += count
        knots[i] = at = cuts[c]
        begun = here
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
    i: cython.Py_ssize_t = first
    j: cython.Py_ssize_t = first
    count: cython.Py_ssize_t = 0
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
        # Spans may be of other sizes at both ends.
        while j < last - 1 and knots[j + 1] < t[k + 1]:
            j += 1
        longer = 0.5 * (_LONGER if bend[k] == 0.0 else _CURVED)
        if t[k + 1] - t[k] <= longer * (knots[i + 1] - knots[i] + knots[j + 1] - knots[j]):
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
    most: cython.double
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
