"""Decides whether a motion may replace the plan: by its limits, at and between nodes, and its joints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.tube.window_problem import Solved

Floats = NDArray[np.float64]

#: Part by which a velocity may be over its limit between nodes, and an acceleration or jerk at all.
_OVER, _ROUNDED = 5e-5, 1e-6
#: Parts of an interval whose hulls bound the speed.
_PARTS = 32
#: Part of the limits of jerk and acceleration that steps at a node may make of a difference of setpoints.
_STEPS = 2e-4


def too_fast(found: Solved, velocity: Floats, feed: Floats, linear: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Tell on which intervals an axis is over its velocity, or the motion over the feed, shape (k,).

    Between nodes the velocity of an axis is a parabola: largest at an end or at its top. The speed is bounded from above.

    Args:
        found: The motion, of n axes.
        velocity: Shape (n,), limits.
        feed: Shape (k,).
        linear: Shape (n,): axes over which the feed is meant.
    """
    v, a, j, h = found.velocity[:-1], found.acceleration[:-1], found.jerk, found.step[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        top = np.where(j != 0.0, -a / j, 0.0)
    top = np.clip(top, 0.0, h)
    most = np.maximum(np.abs(v + top * (a + 0.5 * top * j)), np.abs(found.velocity[1:]))
    most = np.maximum(most, np.abs(v))
    out: NDArray[np.bool_] = np.any(most > (1.0 + _OVER) * velocity, axis=1)
    allowed = (1.0 + _OVER) * feed
    doubtful = np.flatnonzero(~out)
    for parts in (1, _PARTS):
        # The speed is convex, so on each part of a parabola it is at most that of an ordinate of its hull.
        begin = np.arange(parts) / parts * h[doubtful]
        v0, a0, j0 = (each[doubtful][:, None, linear] for each in (v, a, j))
        t, half = begin[..., None], 0.5 / parts * h[doubtful][..., None]
        first, slope = v0 + t * (a0 + 0.5 * t * j0), a0 + t * j0
        hull = np.stack([first, first + half * slope, first + 2.0 * half * (slope + half * j0)])
        speed = np.sqrt((hull**2).sum(axis=3)).max(axis=(0, 2))
        doubtful = doubtful[speed > allowed[doubtful]]
    out[doubtful] = True
    return out


def holds(
    found: Solved, ends: tuple[Floats, Floats], acceleration: Floats, jerk: Floats, period_s: float
) -> bool:
    """Tell whether a motion goes from one state to the other without a step that setpoints show, within acceleration and jerk.

    Acceleration is linear and jerk constant between nodes, so their largest values are at nodes.

    Args:
        found: The motion.
        ends: Shape (3, n) each: position, velocity and acceleration where it begins and ends.
        acceleration, jerk: Shape (n,), limits.
        period_s: Time between setpoints.
    """
    x, v, a, j, h = found.position, found.velocity, found.acceleration, found.jerk, found.step[:, None]
    if not (np.isfinite(x).all() and np.isfinite(j).all() and (h > 0.0).all()):
        return False
    if (np.abs(a) > (1.0 + _ROUNDED) * acceleration).any() or (np.abs(j) > (1.0 + _ROUNDED) * jerk).any():
        return False
    went = np.stack([x[:-1] + h * (v[:-1] + h * (a[:-1] / 2.0 + h * j / 6.0)), v[:-1] + h * (a[:-1] + h * j / 2.0), a[:-1] + h * j])  # fmt: skip
    came = np.stack([x, v, a])
    begin, end = (each[:, None] for each in ends)
    steps = np.abs(np.concatenate([went - came[:, 1:], came[:, :1] - begin, came[:, -1:] - end], axis=1))
    # A step of the k-th derivative is in a third difference at most 3 - k times, whatever the phase, and in a second one 2 - k times.
    for limit, weights in (
        (jerk, (3.0 / period_s**3, 2.0 / period_s**2, 1.0 / period_s)),
        (acceleration, (2.0 / period_s**2, 1.0 / period_s, 1.0)),
    ):
        rounding = 4.0 * np.spacing(np.abs(x).max()) * weights[0]
        shown = sum(weight * step for weight, step in zip(weights, steps, strict=True))
        if not np.all(shown <= _STEPS * limit + rounding):
            return False
    return True
