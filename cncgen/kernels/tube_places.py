"""Where points, in order, are nearest to a polyline that passes each of them within a distance."""

import cython
from cython.cimports.libc.math import sqrt


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def match(
    line: cython.double[:, ::1],
    way: cython.double[::1],
    points: cython.double[:, ::1],
    within: cython.double[::1],
    least: cython.double[::1],
    start: cython.double,
    begin: cython.Py_ssize_t,
    last: cython.bint,
    place: cython.double[::1],
) -> cython.Py_ssize_t:
    """Find for each point the first place, not before that of the point before it, where the distance has a minimum that is small enough.

    Args:
        line: Shape (m, n), the polyline's vertices.
        way: Shape (m,), length along it.
        points: Shape (k, n).
        within: Shape (k,): how near the polyline passes each point.
        least: Shape (k,): the way at least from the place of the point before.
        start: The way at that place, for the first point.
        begin: Segment from which on the first point is looked for.
        last: Whether the polyline ends here; if not, it goes on, and points near its end are left for later.
        place: Shape (k,), written: segment number plus the part of it.

    Returns:
        How many points have a place; those after them lie beyond the end or are nowhere within their distance.
    """
    m: cython.Py_ssize_t = line.shape[0]
    n: cython.Py_ssize_t = line.shape[1]
    count: cython.Py_ssize_t = points.shape[0]
    p: cython.Py_ssize_t
    i: cython.Py_ssize_t
    e: cython.Py_ssize_t
    at: cython.Py_ssize_t = begin
    part: cython.double = 0.0
    best: cython.double
    found: cython.double
    closed: cython.bint
    d: cython.double
    u: cython.double
    dot: cython.double
    size: cython.double
    y: cython.double
    z: cython.double
    for p in range(count):
        best = 1e300
        found = -1.0
        closed = False
        start += least[p]
        for i in range(at, m - 1):
            if way[i + 1] < start:
                continue
            dot = 0.0
            size = 0.0
            for e in range(n):
                y = line[i + 1, e] - line[i, e]
                z = points[p, e] - line[i, e]
                dot += y * z
                size += y * y
            u = dot / size if size > 0.0 else 0.0
            u = 0.0 if u < 0.0 else 1.0 if u > 1.0 else u
            if i == at and u < part:
                u = part
            if way[i] < start and way[i + 1] > way[i] and way[i] + u * (way[i + 1] - way[i]) < start:
                u = (start - way[i]) / (way[i + 1] - way[i])
            d = 0.0
            for e in range(n):
                z = points[p, e] - line[i, e] - u * (line[i + 1, e] - line[i, e])
                d += z * z
            d = sqrt(d)
            if d < best - 1e-12:
                best = d
                found = i + u
            elif (
                best <= within[p]
                and way[i + 1] - way[cython.cast(cython.Py_ssize_t, found)] > 2.0 * within[p] + best
                and d > best + 0.5 * within[p]
            ):
                closed = True
                break
        if found < 0.0 or best > within[p] or not (closed or last):
            return p
        place[p] = found
        at = cython.cast(cython.Py_ssize_t, found)
        part = found - at
        start = way[at] + part * (way[at + 1] - way[at]) if at < m - 1 else way[m - 1]
        if at > m - 2:
            at = m - 2
            part = 1.0
    return count
