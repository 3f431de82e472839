"""The last resort where the solver finds no plan: a slow motion that is certain to hold every limit, and where to stop.

`rolling_window` calls it. All limits are homogeneous in q = v²: if q is multiplied by λ, velocity² and acceleration are multiplied
by λ, jerk by λ^(3/2) (uniform time scaling: Hollerbach, Dynamic scaling of manipulator trajectories (1984)). So any motion from rest
to rest holds every limit if it is slowed enough.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.planner.least_time.mesh import SPLINE
from cncgen.planner.least_time.problem import Intervals, Solution, profile
from cncgen.planner.limits.axis_limits import along_path
from cncgen.planner.record import Limit

Floats = NDArray[np.float64]

#: Parts of an interval at which limits are compared, and the part of the limits that the motion is slowed to, since between
#: these places it may use somewhat more.
_PLACES, _USED = np.linspace(0.0, 1.0, 17), 0.8


def time_scaled(given: Intervals) -> Solution:
    """Return a motion that holds every limit on intervals from rest to rest, far from the least time.

    It is the profile that the solver starts from (`cncgen.planner.least_time.problem.profile`), slowed as a whole.
    """
    q, edge = profile(given)
    limit = np.full(len(given), Limit.JERK, np.int8)
    return Solution(_part(given, q, edge) * q, limit, 0.0, len(given), True)


def obstacle(given: Intervals, q: Floats, period_s: float) -> int:
    """Return the node at which to stop instead, because limits are exceeded most beside it and the motion is slow there; 0 for none.

    Slow means below the smaller of J T² and A T, as where the path is nearly a cusp: a stop there costs next to nothing. Of
    both ends of the interval on which limits are exceeded most it is the one where x''' is larger beside the jerk limits.

    Args:
        given: The intervals.
        q: Shape (n, 3), ordinates of their solution.
        period_s: T.
    """
    spline = np.flatnonzero(given.kind == SPLINE)
    acceleration, jerk = _used(given, q, spline)
    worst = spline[np.argmax(np.maximum(acceleration, elementary.power(jerk, 2.0 / 3.0)))]
    steep = np.abs(given.x1[worst]).max(axis=0, keepdims=True)
    a, j = (float(along_path(limit, steep)[0]) for limit in given.limits)
    slow = np.sqrt(q[worst].max()) < min(j * period_s, a) * period_s
    left, right = (np.abs(given.x3[worst, end] / given.limits[1]).max() for end in (0, 2))
    return int(worst + (right > left)) if slow else 0


def _part(given: Intervals, q: Floats, edge: Floats) -> float:
    """Return the factor by which to multiply the ordinates q so that every limit is held with `_USED` of it.

    Args:
        given: The n intervals.
        q: Shape (n, 3), ordinates.
        edge: Shape (k, 2), largest q at both ends of the k spline intervals.
    """
    spline = np.flatnonzero(given.kind == SPLINE)
    acceleration, jerk = _used(given, q, spline)
    # q' is linear, so largest at an end; bounds of its half are those of jumps at the nodes.
    slope = np.abs(np.diff(q[spline], axis=1)) / given.h[spline, None]
    sway = np.stack([given.node_acceleration[spline], given.node_acceleration[spline + 1]], axis=1)
    most = max(
        float(acceleration.max()),
        float(jerk.max()) ** (2.0 / 3.0),
        float((q[spline][:, ::2] / edge).max()),
        float((q[spline].max(axis=1) / given.top[spline].min(axis=1)).max()),
        float((slope / sway).max()),
    )
    return _USED / max(most, _USED)


def _used(given: Intervals, q: Floats, spline: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Return the largest parts of the limits of acceleration and of jerk that spline intervals use, shape (k,) each."""
    u = _PLACES[:, None]
    b, h = q[spline, None, :, None], given.h[spline, None, None]
    value = b[:, :, 0] * (1.0 - u) ** 2 + 2.0 * b[:, :, 1] * u * (1.0 - u) + b[:, :, 2] * u**2
    slope = ((b[:, :, 1] - b[:, :, 0]) * (1.0 - u) + (b[:, :, 2] - b[:, :, 1]) * u) / h
    bend = (b[:, :, 0] - 2.0 * b[:, :, 1] + b[:, :, 2]) / h**2
    # The parabola through the values at the ends and in the middle.
    weights = np.stack([(1.0 - u) * (1.0 - 2.0 * u), 4.0 * u * (1.0 - u), u * (2.0 * u - 1.0)])[:, :, 0]
    x1, x2, x3 = (np.einsum("kma,mp->kpa", each[spline], weights) for each in (given.x1, given.x2, given.x3))
    limits = given.limits * given.factor[spline]
    acceleration = np.abs(x2 * value + x1 * slope)
    jerk = np.abs(x3 * value + 3.0 * x2 * slope + x1 * bend) + given.x3_excess[spline, None] * value
    jerk *= np.sqrt(np.maximum(value, 0.0))
    used = (each / limits[:, None, which] for which, each in enumerate((acceleration, jerk)))
    return tuple(each.max(axis=(1, 2)) for each in used)
