"""Decides whether a motion may replace the plan: by its limits, at and between nodes, and its joints."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import tube_motion
from cncgen.planner.tube.window_problem import Solved

Floats = NDArray[np.float64]

#: Parts by which velocity and feed may be over their limits between nodes, and an acceleration or jerk at all.
_OVER, _FASTER, _ROUNDED = 5e-5, 1.5e-4, 1e-6
#: Part of the limits of jerk and acceleration that steps at a node may make of a difference of setpoints.
_STEPS = 2e-4
#: Phases of setpoints that are looked at over the ends of a motion, and the part of a limit that they may reach.
_PHASES, _SEEN = 8, 1.0005


def too_fast(found: Solved, velocity: Floats, feed: Floats, weight: Floats) -> NDArray[np.bool_]:
    """Tell on which intervals an axis is over its velocity, shape (n,), or the axes with a `weight` of 1, shape (k, n), are together over the feed,
    shape (k,); the answer has shape (k,)."""
    out = np.empty(len(found.step), np.int8)
    most, allowed = (1.0 + _OVER) * velocity, (1.0 + _FASTER) * feed
    tube_motion.too_fast(
        found.velocity, found.acceleration, found.jerk, found.step, most, allowed, weight, out
    )
    return out.astype(bool)


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


def joins(
    found: Solved,
    ends: tuple[float, float],
    beside: tuple[bool, bool],
    plan: Callable[[Floats], Floats],
    limits: tuple[Floats, Floats, Floats],
    period_s: float,
) -> bool:
    """Tell whether differences of setpoints hold the limits over both ends of a motion, where the plan goes on.

    The plan may step within what the period allows, as long as all of a period is its own.

    Args:
        found: The motion, over all axes.
        ends: Times of the plan where it begins and ends, s.
        beside: Whether the plan is known before it, and after it; elsewhere nothing is asked.
        plan: Returns positions of the plan at times.
        limits: Shape (n,) each: velocity, acceleration and jerk.
        period_s: Time between setpoints.
    """
    end = float(np.cumsum(found.step)[-1])
    apart = period_s * (np.arange(-3, 4)[:, None] + np.arange(_PHASES) / _PHASES)
    for joint, known in zip((0.0, end), beside, strict=True):
        if not known:
            continue
        at = (joint + apart).ravel()
        x = np.empty((len(at), found.position.shape[1]))
        tube_motion.positions(
            found.position,
            found.velocity,
            found.acceleration,
            found.jerk,
            found.step,
            at,
            np.empty(len(at), np.int64),
            x,
        )
        outside = np.flatnonzero((at < 0.0) | (at > end))
        x[outside] = plan(np.where(at < 0.0, ends[0] + at, ends[1] + at - end)[outside])
        x = x.reshape(*apart.shape, -1)
        for order, limit in enumerate(limits, 1):
            most = _SEEN * limit * period_s**order + 2.0**order * np.spacing(np.abs(x).max())
            if (np.abs(np.diff(x, order, axis=0)) > most).any():
                return False
    return True
