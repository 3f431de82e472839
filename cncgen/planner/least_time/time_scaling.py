"""The last resort where the solver finds no plan: a slow motion that is certain to hold every limit, and where to stop (docs/least-time.md,
Windows). Multiplying q = v² by λ is uniform time scaling (Hollerbach, Dynamic scaling of manipulator trajectories (1984)).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.geometry.columns import max_over_axes, min_over_axes
from cncgen.planner.least_time.mesh import SPLINE
from cncgen.planner.least_time.problem import Intervals, Solution, profile, slopes
from cncgen.planner.limits.axis_limits import along_path
from cncgen.planner.record import Limit

Floats = NDArray[np.float64]

#: Parts of the time on an interval at which limits are compared, and the part of the limits that the motion is slowed to, since between
#: these places it may use somewhat more.
_PLACES, _USED = np.linspace(0.0, 1.0, 17), 0.8


def time_scaled(given: Intervals) -> Solution:
    """Return a motion that holds every limit on intervals from rest to rest, far from the least time.

    It is the profile that the solver starts from (`cncgen.planner.least_time.problem.profile`), slowed as a whole.
    """
    q, way, edge = profile(given)
    found = Solution(q, way, np.full(len(given), Limit.JERK, np.int8), 0.0, len(given), True)
    return replace(found, q=_part(given, found, edge) * q)


def obstacle(given: Intervals, found: Solution, period_s: float) -> int:
    """Return the node at which to stop instead, because limits are exceeded most beside it and the motion is slow there; 0 for none.

    Slow means below the smaller of J T² and A T, as where the path is nearly a cusp: a stop there costs next to nothing. Of
    both ends of the interval on which limits are exceeded most it is the one where x''' is larger beside the jerk limits.

    Args:
        given: The intervals.
        found: Their solution.
        period_s: T.
    """
    spline = np.flatnonzero(given.kind == SPLINE)
    acceleration, jerk = _used(given, found, spline)
    worst = spline[np.argmax(np.maximum(acceleration, elementary.power(jerk, 2.0 / 3.0)))]
    steep = np.abs(given.x1[worst]).max(axis=0, keepdims=True)
    a, j = (float(along_path(limit, steep)[0]) for limit in given.limits)
    slow = np.sqrt(found.q[worst].max()) < min(j * period_s, a) * period_s
    left, right = (np.abs(given.x3[worst, end] / given.limits[1]).max() for end in (0, 2))
    return int(worst + (right > left)) if slow else 0


def _part(given: Intervals, found: Solution, edge: Floats) -> float:
    """Return the factor by which to multiply q so that every limit is held with `_USED` of it.

    Args:
        given: The n intervals.
        found: A motion on them.
        edge: Shape (k, 2), largest q at both ends of the k spline intervals.
    """
    spline, q = np.flatnonzero(given.kind == SPLINE), found.q
    acceleration, jerk = _used(given, found, spline)
    # q' is largest at an end; bounds of its half are those of jumps at the nodes.
    slope = np.abs(np.stack(slopes(given.h[spline], q[spline], found.way[spline]), axis=1))
    sway = np.stack([given.node_acceleration[spline], given.node_acceleration[spline + 1]], axis=1)
    most = max(
        float(acceleration.max()),
        float(jerk.max()) ** (2.0 / 3.0),
        float((q[spline][:, ::2] / edge).max()),
        float((max_over_axes(q[spline]) / min_over_axes(given.top[spline])).max()),
        float((slope / sway).max()),
    )
    return _USED / max(most, _USED)


def _used(given: Intervals, found: Solution, spline: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Return the largest parts of the limits of acceleration and of jerk that spline intervals use, shape (k,) each."""
    h, q, way = given.h[spline], found.q[spline], found.way[spline]
    one, other = slopes(h, q, way)
    mean = 0.5 * (np.sqrt(q[:, 0]) + np.sqrt(q[:, 2]))
    time = 2.0 * h / (mean + np.sqrt(np.maximum(mean**2 - (other - one) * h / 3.0, 0.0)))
    # At parts of the time: v and a in closed form.
    v, a, j = np.sqrt(q[:, :1]), one[:, None], ((other - one) / time)[:, None]
    t = time[:, None] * _PLACES
    # Parts of the way at those of the time, and v and a there.
    u = (v + (0.5 * a + j * t / 6.0) * t) * t / h[:, None]
    speed, slope = ((v + (a + 0.5 * j * t) * t)[:, :, None], (a + j * t)[:, :, None])
    value = speed**2
    # The parabola through the values at the ends and in the middle.
    weights = np.stack([(1.0 - u) * (1.0 - 2.0 * u), 4.0 * u * (1.0 - u), u * (2.0 * u - 1.0)])
    x1, x2, x3 = (np.einsum("kma,mkp->kpa", each[spline], weights) for each in (given.x1, given.x2, given.x3))
    limits = given.limits * given.factor[spline]
    acceleration = np.abs(x2 * value + x1 * slope)
    jerk = (
        np.abs((x3 * value + 3.0 * x2 * slope) * speed + x1 * j[:, :, None])
        + given.x3_excess[spline, None] * value * speed
    )
    used = (each / limits[:, None, which] for which, each in enumerate((acceleration, jerk)))
    return tuple(each.max(axis=(1, 2)) for each in used)
