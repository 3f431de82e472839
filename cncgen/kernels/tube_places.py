# cython: infer_types=True
"""Where points, in order, are nearest to a polyline that passes each of them within a distance."""

import cython
from cython.cimports.libc.math import sqrt


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _nearest(
    line: cython.double[:, ::1],
    i: cython.Py_ssize_t,
    least: cython.double,
    point: cython.double[::1],
    part: cython.double[::1],
) -> cython.double:
    """Return the distance of a point from segment `i`, from a part of it on, and write the part that is nearest."""
    n: cython.Py_ssize_t = line.shape[1]
    dot: cython.double = 0.0
    size: cython.double = 0.0
    square: cython.double = 0.0
    for e in range(n):
        y = line[i + 1, e] - line[i, e]
        z = point[e] - line[i, e]
        dot += y * z
        size += y * y
    u = dot / size if size > 0.0 else 0.0
    u = least if u < least else 1.0 if u > 1.0 else u
    for e in range(n):
        z = point[e] - line[i, e] - u * (line[i + 1, e] - line[i, e])
        square += z * z
    part[0] = u
    return sqrt(square)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _part_at(way: cython.double[::1], i: cython.Py_ssize_t, s: cython.double) -> cython.double:
    """Return the part of segment `i` that ends at a way on it or beyond it, 0 where it begins there or later."""
    if not (way[i] < s and way[i + 1] > way[i]):
        return 0.0
    return min((s - way[i]) / (way[i + 1] - way[i]), 1.0)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _entered(
    line: cython.double[:, ::1],
    way: cython.double[::1],
    points: cython.double[:, ::1],
    within: cython.double[::1],
    least: cython.double[::1],
    rests: cython.char[::1],
    still: cython.char[::1],
    reached: cython.double,
    last: cython.bint,
    entry: cython.double[::1],
    leaving: cython.longlong[::1],
    part: cython.double[::1],
) -> cython.Py_ssize_t:
    """Find where the polyline comes near each point, and the last segment before it leaves it; return of how many both are known."""
    m: cython.Py_ssize_t = line.shape[0]
    i: cython.Py_ssize_t = 0
    for p in range(points.shape[0]):
        first = reached + least[p]
        while i < m - 1:
            if way[i + 1] >= first and max(still[i], still[i + 1]) >= rests[p]:
                if _nearest(line, i, _part_at(way, i, first), points[p], part) <= within[p]:
                    break
            i += 1
        if i >= m - 1:
            return p
        reached = way[i] + part[0] * (way[i + 1] - way[i])
        entry[p] = reached
        leaving[p] = i
        # A rest is one place.
        while (
            rests[p] != 1
            and leaving[p] < m - 2
            and _nearest(line, leaving[p] + 1, 0.0, points[p], part) <= within[p]
        ):
            leaving[p] += 1
        if leaving[p] == m - 2 and not last:
            return p
    return points.shape[0]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _placed(
    line: cython.double[:, ::1],
    way: cython.double[::1],
    points: cython.double[:, ::1],
    count: cython.Py_ssize_t,
    start: cython.double,
    entry: cython.double[::1],
    leaving: cython.longlong[::1],
    place: cython.double[::1],
    part: cython.double[::1],
) -> cython.void:
    """Find the places of the first points, each the nearest one from its entry, and the place before, to where it is left."""
    m: cython.Py_ssize_t = line.shape[0]
    i: cython.Py_ssize_t = 0
    for p in range(count):
        start = max(start, entry[p])
        while i < m - 2 and way[i + 1] < start:
            i += 1
        part[0] = least = _part_at(way, i, start)
        # Where the point before has its place at the end of the last segment, so has this one.
        best = _nearest(line, i, least, points[p], part) if i <= leaving[p] else 0.0
        place[p] = i + part[0]
        for segment in range(i + 1, leaving[p] + 1):
            d = _nearest(line, segment, 0.0, points[p], part)
            if d < best - 1e-12:
                best = d
                place[p] = segment + part[0]
        i = min(cython.cast(cython.Py_ssize_t, place[p]), m - 2)
        start = way[i] + (place[p] - i) * (way[i + 1] - way[i])


def match(
    line: cython.double[:, ::1],
    way: cython.double[::1],
    points: cython.double[:, ::1],
    within: cython.double[::1],
    least: cython.double[::1],
    rests: cython.char[::1],
    still: cython.char[::1],
    reached: cython.double,
    start: cython.double,
    last: cython.bint,
    entry: cython.double[::1],
    leaving: cython.longlong[::1],
    place: cython.double[::1],
    part: cython.double[::1],
) -> int:
    """Find for each point a place, not before that of the point before it, where the polyline is nearest to it.

    The polyline comes near each point for a first time after it came near the point before. A point's place lies between there
    and where it leaves that point, or one of those after it, and is the nearest one there.

    Args:
        line: Shape (m, n), the polyline's vertices.
        way: Shape (m,), length along it.
        points: Shape (k, n).
        within: Shape (k,): how near the polyline passes each point.
        least: Shape (k,): the way at least from where it comes near the point before.
        rests: Shape (k,): 1 for points where the motion along the polyline rests, 2 for that where it ends.
        still: Shape (m,): 1 for vertices where it rests, 2 for that where it ends.
        reached: The way where it came near the last point that has a place.
        start: The way at that place.
        last: Whether the polyline and the points end here; if not, points whose places depend on what follows are left for later.
        entry, leaving, place, part: Shape (k,) each and (1,), written: the way where it comes near each point, the last segment that
            is near; the place as segment number plus the part of it; workspace.

    Returns:
        How many points have a place; those after them are left for later, or are nowhere within their distance.
    """
    with cython.nogil:
        known = _entered(line, way, points, within, least, rests, still, reached, last, entry, leaving, part)
        # Points of which one that is known comes near only after they are left wait for what follows.
        final = known
        if not last:
            while final > 0 and way[leaving[final - 1]] >= entry[known - 1]:
                final -= 1
        for p in range(known - 2, -1, -1):
            leaving[p] = min(leaving[p], leaving[p + 1])
        _placed(line, way, points, final, start, entry, leaving, place, part)
    return final
