"""Follow a polyline with a sequence of points that run along it: the nearest place ahead of each.

Each point is matched with a place on the polyline that is not before the place of the point before it. From there the
segments ahead are searched for the first place within the tolerance, and from it on as long as the distance falls: the
first local minimum. So a path that crosses itself, or goes back the way it came, is followed branch by branch, which
the nearest point of the whole path would not do. A place that is off by more than `NOISE` of the tolerance is given up
for one further on in the window at less than half its distance: round a corner, or on the way back behind a tip.

Where nothing within the window is within the tolerance, nor on the few segments after it (a stroke that was left out),
the nearest place is the match (the point is beyond tolerance, and its distance says by how much). Points that are further from it than the window is long are lost
(the setpoints left a piece out, which a shorter piece would be seen by the window for): a run of them is looked for
further and further ahead, after 1, 2, 4, 8 … of them, so that the work stays in proportion. A point that is nearer is
off and not lost; looked for all along a path that crosses itself, it would be found on another branch.
"""

import cython
from cython.cimports.libc.math import sqrt

#: Part of the tolerance within which a place is the right one without looking further.
NOISE = cython.declare(cython.double, 0.02)

#: Segments that are searched though they begin beyond the window, where nothing in it is within the tolerance.
_FEW = cython.declare(cython.Py_ssize_t, 16)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _fraction(
    points: cython.double[:, ::1],
    i: cython.Py_ssize_t,
    line: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    at_least: cython.double,
) -> cython.double:
    """Return where on segment `k`, from 0 to 1 and not before `at_least`, the place nearest to point `i` is."""
    dot: cython.double = 0.0
    size: cython.double = 0.0
    d: cython.double
    c: cython.Py_ssize_t
    for c in range(line.shape[1]):
        d = line[k + 1, c] - line[k, c]
        dot += (points[i, c] - line[k, c]) * d
        size += d * d
    if size == 0.0:
        return 1.0
    if dot <= at_least * size:
        return at_least
    return dot / size if dot < size else 1.0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _distance(
    points: cython.double[:, ::1],
    i: cython.Py_ssize_t,
    line: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    f: cython.double,
) -> cython.double:
    """Return the distance of point `i` from the place at fraction `f` of segment `k`."""
    total: cython.double = 0.0
    d: cython.double
    c: cython.Py_ssize_t
    for c in range(line.shape[1]):
        d = points[i, c] - (line[k, c] + f * (line[k + 1, c] - line[k, c]))
        total += d * d
    return sqrt(total)


def follow(
    points: cython.double[:, ::1],
    line: cython.double[:, ::1],
    along: cython.double[::1],
    point_tolerance: cython.double[::1],
    segment_tolerance: cython.double[::1],
    reach: cython.double[::1],
    segment: cython.longlong[::1],
    fraction: cython.double[::1],
    distance: cython.double[::1],
    state: cython.double[::1],
) -> cython.void:
    """Match points with places on a polyline, in order; more points may follow in further calls.

    Args:
        points: Shape (n, d).
        line: Shape (m + 1, d), m >= 1: vertices of the polyline.
        along: Shape (m + 1,): length of the polyline up to each vertex.
        point_tolerance: Shape (n,), and
        segment_tolerance: Shape (m,): a match is within tolerance if its distance is within both.
        reach: Shape (n,): length of the window of each point, counted from the match before it.
        segment: Shape (n,): receives the segment of each match,
        fraction: Shape (n,): the place on it, from 0 to 1,
        distance: Shape (n,): and how far the point is from there.
        state: Shape (4,): carried from call to call; 0, 0, 0, 1 before the first. Segment and fraction of the last
            match, how many points were lost in a row, and after how many the next far search comes.
    """
    n: cython.Py_ssize_t = points.shape[0]
    m: cython.Py_ssize_t = line.shape[0] - 1
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    at: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, state[0])
    best: cython.Py_ssize_t
    lost: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, state[2])
    next_search: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, state[3])
    at_f: cython.double = state[1]
    f: cython.double
    best_f: cython.double
    near: cython.Py_ssize_t = 0
    near_f: cython.double = 0.0
    near_d: cython.double = 0.0
    d: cython.double
    best_d: cython.double
    end: cython.double
    tolerance: cython.double
    found: cython.bint
    far: cython.bint
    nearer: cython.bint
    with cython.nogil:
        for i in range(n):
            end = along[at] + at_f * (along[at + 1] - along[at]) + reach[i]
            best = at
            best_f = at_f
            best_d = _distance(points, i, line, at, at_f)
            found = best_d <= point_tolerance[i] and best_d <= segment_tolerance[at]
            far = False
            k = at
            while k < m:
                if not far and along[k] > end and (found or k > at + _FEW):
                    if found or best_d <= reach[i] or lost != next_search:
                        break
                    far = True
                    next_search *= 2
                    near = best
                    near_f = best_f
                    near_d = best_d
                f = _fraction(points, i, line, k, at_f if k == at else 0.0)
                d = _distance(points, i, line, k, f)
                tolerance = point_tolerance[i]
                if segment_tolerance[k] < tolerance:
                    tolerance = segment_tolerance[k]
                if not found:
                    nearer = d < best_d or d <= tolerance
                    found = d <= tolerance
                else:
                    # The distance falls on from the segment before, or is clearly less than at the place found.
                    nearer = (d <= best_d and k <= best + 1 and (k == best or best_f == 1.0)) or (
                        d < 0.5 * best_d and d <= tolerance
                    )
                if nearer:
                    best = k
                    best_f = f
                    best_d = d
                if found and best_d <= NOISE * tolerance and not (best == k and best_f == 1.0):
                    break
                k += 1
            if not found and far:
                best = near
                best_f = near_f
                best_d = near_d
            if found or best_d <= reach[i]:
                lost = 0
                next_search = 1
            else:
                lost += 1
            at = best
            at_f = best_f
            segment[i] = best
            fraction[i] = best_f
            distance[i] = best_d
    state[0] = at
    state[1] = at_f
    state[2] = lost
    state[3] = next_search
