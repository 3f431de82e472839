# cython: infer_types=True
"""Distance of positions to a path through points, searched near the point that was commanded.

The path is a polyline without points that coincide; arc length along it tells how far a search may go. Points within an
arc length are found by doubling steps and bisection (J. L. Bentley and A. C. Yao, An almost optimal algorithm for
unbounded searching, Information Processing Letters 5 (1976) 82), since most lie near.
"""

import cython

#: The nearest that a search has found: distance, and index of the segment's first point.
_Foot = cython.struct(distance=cython.double, segment=cython.Py_ssize_t)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _to_point(
    path: cython.double[:, ::1], i: cython.Py_ssize_t, position: cython.double[:, ::1], k: cython.Py_ssize_t
) -> cython.double:
    """Return the squared distance of position k to point i."""
    total: cython.double = 0.0
    for axis in range(path.shape[1]):
        d = position[k, axis] - path[i, axis]
        total += d * d
    return total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _along(
    path: cython.double[:, ::1], i: cython.Py_ssize_t, position: cython.double[:, ::1], k: cython.Py_ssize_t
) -> cython.double:
    """Return where the segment from point i to point i + 1 is nearest to position k: 0 at its first point, 1 at its last."""
    along: cython.double = 0.0
    square: cython.double = 0.0
    for axis in range(path.shape[1]):
        step = path[i + 1, axis] - path[i, axis]
        along += step * (position[k, axis] - path[i, axis])
        square += step * step
    along = along / square if square > 0.0 else 0.0
    if along < 0.0:
        along = 0.0
    elif along > 1.0:
        along = 1.0
    return along


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _to_segment(
    path: cython.double[:, ::1], i: cython.Py_ssize_t, position: cython.double[:, ::1], k: cython.Py_ssize_t
) -> cython.double:
    """Return the squared distance of position k to the segment from point i to point i + 1."""
    along: cython.double = _along(path, i, position, k)
    total: cython.double = 0.0
    for axis in range(path.shape[1]):
        d = position[k, axis] - path[i, axis] - along * (path[i + 1, axis] - path[i, axis])
        total += d * d
    return total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _last_up_to(
    arc: cython.double[::1], i: cython.Py_ssize_t, last: cython.Py_ssize_t, bound: cython.double
) -> cython.Py_ssize_t:
    """Return the last point from i to `last` whose arc length is below `bound` (i where none is), by doubling steps."""
    low: cython.Py_ssize_t = i
    high: cython.Py_ssize_t = i + 1 if i < last else i
    while high < last and arc[high] < bound:
        low = high
        high = 2 * high - i if 2 * high - i < last else last
    while low < high:
        middle = (low + high + 1) // 2
        if arc[middle] < bound:
            low = middle
        else:
            high = middle - 1
    return low


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _first_down_to(arc: cython.double[::1], i: cython.Py_ssize_t, bound: cython.double) -> cython.Py_ssize_t:
    """Return the first point up to i whose arc length is above `bound` (i where none is), by doubling steps."""
    high: cython.Py_ssize_t = i
    low: cython.Py_ssize_t = i - 1 if i > 0 else 0
    while low > 0 and arc[low] > bound:
        high = low
        low = 2 * low - i if 2 * low > i else 0
    while low < high:
        middle = (low + high) // 2
        if arc[middle] > bound:
            high = middle
        else:
            low = middle + 1
    return high


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _nearer(
    path: cython.double[:, ::1],
    segment: cython.Py_ssize_t,
    position: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    best: _Foot,
) -> _Foot:
    """Return the nearer of the best foot and that on a segment."""
    d: cython.double = _to_segment(path, segment, position, k) ** 0.5
    return _Foot(distance=d, segment=segment) if d < best.distance else best


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _search_back(
    path: cython.double[:, ::1],
    arc: cython.double[::1],
    i: cython.Py_ssize_t,
    window: cython.double,
    position: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    best: _Foot,
) -> _Foot:
    """Return the nearest foot on the segments before point i, as far back as the window."""
    low: cython.double = arc[i] - window
    d: cython.double
    while i > 0 and arc[i] > low:
        best = _nearer(path, i - 1, position, k, best)
        d = _to_point(path, i, position, k) ** 0.5
        i = _first_down_to(arc, i - 1, arc[i] - (d - best.distance))
    return best


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _search_ahead(
    path: cython.double[:, ::1],
    arc: cython.double[::1],
    i: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    window: cython.double,
    position: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    best: _Foot,
) -> _Foot:
    """Return the nearest foot on the segments after point i, as far ahead as the window and the last point."""
    high: cython.double = arc[i] + window
    d: cython.double
    while i < last and arc[i] < high:
        best = _nearer(path, i, position, k, best)
        d = _to_point(path, i, position, k) ** 0.5
        i = _last_up_to(arc, i + 1, last, arc[i] + (d - best.distance))
    return best


def distances(
    path: cython.double[:, ::1],
    arc: cython.double[::1],
    own: cython.longlong[::1],
    last: cython.longlong[::1],
    position: cython.double[:, ::1],
    reach: cython.double,
    result: cython.double[::1],
    feet: cython.double[:, ::1],
) -> None:
    """Write the distance of each position to the path.

    Args:
        path: Shape (p, axes), consecutive points apart.
        arc: Shape (p,), arc length at each point.
        own: Shape (n,), index of the point that was commanded.
        last: Shape (n,), index of the last point that may be looked at.
        position: Shape (n, axes).
        reach: The search goes so many times the tracking error along the path, both ways.
        result: Shape (n,).
        feet: Shape (n, axes), written with the nearest points; (0, axes) where nobody asks for them.

    A point at arc distance x from one that is d away is at least d − x away, so whatever lies nearer along the path
    than d − best is skipped.
    """
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    own_distance: cython.double
    along: cython.double
    best: _Foot = _Foot(distance=0.0, segment=0)
    for k in range(position.shape[0]):
        own_distance = _to_point(path, own[k], position, k) ** 0.5
        best.distance = own_distance
        window = reach * best.distance + 1e-9
        # The segment of the position before is mostly near: a small best to start with makes the skips long.
        for i in range(best.segment, best.segment + 2):
            if i < last[k] and -window < arc[i] - arc[own[k]] < window:
                best = _nearer(path, i, position, k, best)
        best = _search_back(path, arc, own[k], window, position, k, best)
        best = _search_ahead(path, arc, own[k], last[k], window, position, k, best)
        result[k] = best.distance
        if k < feet.shape[0]:
            i = best.segment if best.distance < own_distance else own[k]
            along = _along(path, i, position, k) if best.distance < own_distance else 0.0
            for axis in range(path.shape[1]):
                feet[k, axis] = path[i, axis]
                if along > 0.0:
                    feet[k, axis] += along * (path[i + 1, axis] - path[i, axis])


def vertices_reached(
    path: cython.double[:, ::1],
    arc: cython.double[::1],
    wanted: cython.double[:, ::1],
    spacing: cython.double,
    result: cython.longlong[::1],
) -> None:
    """Write the point of the path that each wanted place is at, going forward only.

    Args:
        path: Shape (p, axes), consecutive points apart.
        arc: Shape (p,), arc length at each point.
        wanted: Shape (n, axes), places near the path, in its order. One that does not differ from the one before is where that is.
        spacing: Largest distance of two consecutive points.
        result: Shape (n,), index of the nearest point within twice the step and five spacings ahead of the one before.
    """
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    at: cython.Py_ssize_t = 0
    step: cython.double
    bound: cython.double
    for k in range(wanted.shape[0]):
        step = _to_point(wanted, k - 1, wanted, k) ** 0.5 if k > 0 else 0.0
        if k == 0 or step > 0.0:
            bound = arc[at] + 2.0 * step + 5.0 * spacing
            nearest = _to_point(path, at, wanted, k)
            i = at
            while i + 1 < path.shape[0] and arc[i] < bound:
                i += 1
                d = _to_point(path, i, wanted, k)
                if d < nearest:
                    nearest = d
                    at = i
        result[k] = at
