# cython: infer_types=True
"""A motion whose jerk is constant between nodes: where it is at times, where it is too fast, and how its nodes come into their room."""

import cython
from cython.cimports.libc.math import fabs, sqrt

#: Parts of an interval whose hulls bound the speed: first the whole, then so many.
_PARTS = cython.declare(cython.int, 32)
#: Times that a node is moved into the room of each of its rows, and how often of these within its plane, which may not be enough.
_PUSHES = cython.declare(cython.int, 8)
_ACROSS = cython.declare(cython.int, 4)
#: Least part of a way within a plane that is taken to lead to the row.
_STEEP = cython.declare(cython.double, 0.1)


def positions(
    position: cython.double[:, ::1],
    velocity: cython.double[:, ::1],
    acceleration: cython.double[:, ::1],
    jerk: cython.double[:, ::1],
    step: cython.double[::1],
    times: cython.double[::1],
    node: cython.longlong[::1],
    points: cython.double[:, ::1],
) -> None:
    """Write where a motion is at times.

    Args:
        position, velocity, acceleration: Shape (k + 1, n), at the nodes.
        jerk: Shape (k, n).
        step: Shape (k,), times between nodes, s.
        times: Shape (m,), ascending, from the first node on, s.
        node: Shape (m,), written: the interval of each, which ends no earlier than it.
        points: Shape (m, n), written.
    """
    k: cython.Py_ssize_t = 0
    end: cython.double = step[0]
    with cython.nogil:
        for i in range(times.shape[0]):
            while k < step.shape[0] - 1 and times[i] > end:
                k += 1
                end += step[k]
            node[i] = k
            h = times[i] - end + step[k]
            for e in range(position.shape[1]):
                points[i, e] = position[k, e] + h * (
                    velocity[k, e] + h * (acceleration[k, e] / 2.0 + h * jerk[k, e] / 6.0)
                )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _fastest(
    velocity: cython.double[:, ::1],
    acceleration: cython.double[:, ::1],
    jerk: cython.double[:, ::1],
    h: cython.double,
    k: cython.Py_ssize_t,
    weight: cython.double[:, ::1],
    parts: cython.int,
) -> cython.double:
    """Return a bound of the speed over the weighed axes on an interval, from the hulls of parts of it.

    The speed is convex in the velocity, and a parabola lies in the hull of its ends and its middle ordinate.
    """
    half: cython.double = 0.5 * h / parts
    v: cython.double
    first: cython.double
    middle: cython.double
    last: cython.double
    most: cython.double = 0.0
    for part in range(parts):
        t = 2.0 * half * part
        first = 0.0
        middle = 0.0
        last = 0.0
        for e in range(velocity.shape[1]):
            v = velocity[k, e] + t * (acceleration[k, e] + 0.5 * t * jerk[k, e])
            slope = acceleration[k, e] + t * jerk[k, e]
            first += weight[k, e] * v * v
            middle += weight[k, e] * (v + half * slope) * (v + half * slope)
            v += 2.0 * half * (slope + half * jerk[k, e])
            last += weight[k, e] * v * v
        most = max(most, first, middle, last)
    return sqrt(most)


def too_fast(
    velocity: cython.double[:, ::1],
    acceleration: cython.double[:, ::1],
    jerk: cython.double[:, ::1],
    step: cython.double[::1],
    most: cython.double[::1],
    feed: cython.double[::1],
    weight: cython.double[:, ::1],
    out: cython.char[::1],
) -> None:
    """Write 1 for intervals on which an axis is over its velocity, or the weighed ones are over the feed, else 0.

    Between nodes the velocity of an axis is a parabola: largest at an end or at its top. The speed is bounded from above.

    Args:
        velocity, acceleration: Shape (k + 1, n), at the nodes.
        jerk: Shape (k, n).
        step: Shape (k,), s.
        most: Shape (n,), velocities.
        feed: Shape (k,), speeds.
        weight: Shape (k, n), 1 for the axes that the feed is meant over, else 0.
        out: Shape (k,), written.
    """
    t: cython.double
    with cython.nogil:
        for k in range(step.shape[0]):
            out[k] = 0
            for e in range(velocity.shape[1]):
                t = -acceleration[k, e] / jerk[k, e] if jerk[k, e] != 0.0 else 0.0
                t = min(max(t, 0.0), step[k])
                t = velocity[k, e] + t * (acceleration[k, e] + 0.5 * t * jerk[k, e])
                out[k] |= max(fabs(t), fabs(velocity[k, e]), fabs(velocity[k + 1, e])) > most[e]
            if not out[k]:
                out[k] = (
                    _fastest(velocity, acceleration, jerk, step[k], k, weight, 1) > feed[k]
                    and _fastest(velocity, acceleration, jerk, step[k], k, weight, _PARTS) > feed[k]
                )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _push(
    point: cython.double[:, ::1],
    tangent: cython.double[:, ::1],
    centre: cython.double[:, ::1],
    direction: cython.double[:, ::1],
    radius: cython.double[::1],
    k: cython.Py_ssize_t,
    m: cython.Py_ssize_t,
    within: cython.double,
    across: cython.bint,
    out: cython.double[:, ::1],
) -> cython.bint:
    """Move a node to a part of the room of a row if it is beyond that, within its plane if asked; tell whether it moved."""
    away = cython.declare(cython.double[9])
    along: cython.double = 0.0
    size: cython.double = 0.0
    for e in range(point.shape[1]):
        away[e] = point[k, e] + out[k, e] - centre[m, e]
        along += away[e] * direction[m, e]
    for e in range(point.shape[1]):
        away[e] -= along * direction[m, e]
        size += away[e] * away[e]
    size = sqrt(size)
    if size <= (within + 1e-9) * radius[m]:
        return False
    part = 1.0 - within * radius[m] / size
    along = 0.0
    if across:
        for e in range(point.shape[1]):
            along += away[e] * tangent[k, e]
        # Within the plane the way is longer; hardly any way there leads nearer where the plane is along the row.
        part /= max(1.0 - along * along / (size * size), _STEEP)
    for e in range(point.shape[1]):
        out[k, e] -= part * (away[e] - along * tangent[k, e])
    return True


def move_inside(
    point: cython.double[:, ::1],
    tangent: cython.double[:, ::1],
    first: cython.longlong[::1],
    centre: cython.double[:, ::1],
    direction: cython.double[:, ::1],
    radius: cython.double[::1],
    within: cython.double,
    out: cython.double[:, ::1],
) -> None:
    """Change offsets of nodes so that these are within a part of their room.

    Args:
        point, tangent, first, centre, direction, radius: As of a problem (`cncgen.planner.tube.window_problem`).
        within: Part of the room.
        out: Shape (N + 1, n), from `point`, changed.
    """
    with cython.nogil:
        for k in range(point.shape[0]):
            for number in range(_PUSHES):
                moved = False
                for m in range(first[k], first[k + 1]):
                    moved |= _push(
                        point, tangent, centre, direction, radius, k, m, within, number < _ACROSS, out
                    )
                if not moved:
                    break
