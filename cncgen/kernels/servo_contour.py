"""Distance of positions to a path through points, searched near the point that was commanded.

The path is a polyline without points that coincide; arc length along it tells how far a search may go.
"""

import cython


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _to_point(
    path: cython.double[:, ::1], i: cython.Py_ssize_t, position: cython.double[:, ::1], k: cython.Py_ssize_t
) -> cython.double:
    """Return the squared distance of position k to point i."""
    total: cython.double = 0.0
    d: cython.double
    axis: cython.Py_ssize_t
    for axis in range(path.shape[1]):
        d = position[k, axis] - path[i, axis]
        total += d * d
    return total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _to_segment(
    path: cython.double[:, ::1], i: cython.Py_ssize_t, position: cython.double[:, ::1], k: cython.Py_ssize_t
) -> cython.double:
    """Return the squared distance of position k to the segment from point i to point i + 1."""
    along: cython.double = 0.0
    square: cython.double = 0.0
    total: cython.double = 0.0
    step: cython.double
    d: cython.double
    axis: cython.Py_ssize_t
    for axis in range(path.shape[1]):
        step = path[i + 1, axis] - path[i, axis]
        along += step * (position[k, axis] - path[i, axis])
        square += step * step
    along = along / square if square > 0.0 else 0.0
    if along < 0.0:
        along = 0.0
    elif along > 1.0:
        along = 1.0
    for axis in range(path.shape[1]):
        d = position[k, axis] - path[i, axis] - along * (path[i + 1, axis] - path[i, axis])
        total += d * d
    return total


def distances(
    path: cython.double[:, ::1],
    arc: cython.double[::1],
    own: cython.longlong[::1],
    last: cython.longlong[::1],
    position: cython.double[:, ::1],
    reach: cython.double,
    result: cython.double[::1],
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

    A point at arc distance x from one that is d away is at least d − x away, so whatever lies nearer along the path
    than d − best is skipped.
    """
    count: cython.Py_ssize_t = position.shape[0]
    foot: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    low: cython.Py_ssize_t
    high: cython.Py_ssize_t
    middle: cython.Py_ssize_t
    best: cython.double
    d: cython.double
    window: cython.double
    bound: cython.double
    for k in range(count):
        best = _to_point(path, own[k], position, k) ** 0.5
        window = reach * best + 1e-9
        # The segment of the position before is mostly near: a small best to start with makes the skips long.
        for i in range(foot, foot + 2):
            if i < last[k] and -window < arc[i] - arc[own[k]] < window:
                d = _to_segment(path, i, position, k) ** 0.5
                if d < best:
                    best = d
                    foot = i
        i = own[k]
        bound = arc[i] - window
        while i > 0 and arc[i] > bound:
            d = _to_segment(path, i - 1, position, k) ** 0.5
            if d < best:
                best = d
                foot = i - 1
            d = arc[i] - (_to_point(path, i, position, k) ** 0.5 - best)
            i -= 1
            if arc[i] > d:
                high = i
                low = i - 1 if i > 0 else 0
                while low > 0 and arc[low] > d:
                    high = low
                    low = 2 * low - i if 2 * low > i else 0
                while low < high:
                    middle = (low + high) // 2
                    if arc[middle] > d:
                        high = middle
                    else:
                        low = middle + 1
                i = high
        i = own[k]
        bound = arc[i] + window
        while i < last[k] and arc[i] < bound:
            d = _to_segment(path, i, position, k) ** 0.5
            if d < best:
                best = d
                foot = i
            d = arc[i] + (_to_point(path, i, position, k) ** 0.5 - best)
            i += 1
            if arc[i] < d:
                low = i
                high = i + 1 if i < last[k] else i
                while high < last[k] and arc[high] < d:
                    low = high
                    high = 2 * high - i if 2 * high - i < last[k] else last[k]
                while low < high:
                    middle = (low + high + 1) // 2
                    if arc[middle] < d:
                        low = middle
                    else:
                        high = middle - 1
                i = low
        result[k] = best
