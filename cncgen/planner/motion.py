"""Exact evaluation of profiles: the place at a time, and the time at a place; profiles cut in time and put together again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.kernels import profile as kernel
from cncgen.planner.record import Limit, Profile, Trajectory

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Motion:
    """A profile at some times, each of shape (n,): position mm, speed mm/s, mm/s², mm/s³, and the piece's index."""

    s: Floats
    v: Floats
    a: Floats
    j: Floats
    piece: NDArray[np.int64]


def motion_at(profile: Profile, t: Floats) -> Motion:
    """Evaluate a profile exactly.

    Args:
        profile: Pieces with s''' = j + c s'.
        t: Shape (n,), s, non-decreasing. A time outside the profile is moved to its nearest end.

    Returns:
        Path coordinate, speed, acceleration and jerk along the path, and the index of the piece, of each time.
    """
    n = len(t)
    piece = np.zeros(n, np.int64)
    state = np.zeros((n, 4))
    if len(profile):
        kernel.evaluate(np.ascontiguousarray(t, np.float64), *_columns(profile), state, piece)
    else:
        state[:, 0] = profile.s[-1]
    return Motion(state[:, 0], state[:, 1], state[:, 2], state[:, 3], piece)


def by_time(x: Floats, at: Motion, order: int) -> Floats:
    """Return the positions of axes or a derivative of them by time, shape (n, axes), by the chain rule.

    Args:
        x: Derivatives of the axes by the path, ``x[k]`` = dᵏx/dsᵏ, shape (order + 1 or more, n, axes).
        at: The motion along the path.
        order: 0 to 3.
    """
    v, a, j = at.v[:, None], at.a[:, None], at.j[:, None]
    if order < 2:
        return x[1] * v if order else x[0]
    if order == 2:
        return x[2] * v**2 + x[1] * a
    return x[3] * elementary.power(v, 3.0) + 3.0 * x[2] * v * a + x[1] * j


def axes_at(trajectory: Trajectory, t: Floats, order: int) -> Floats:
    """Return the positions of the axes (mm or rad) or a derivative of them by time (order 1 to 3) at times, shape (n, axes).

    Args:
        trajectory: The trajectory whose time `t` is.
        t: Shape (n,), s, non-decreasing.
        order: 0 to 3.
    """
    if trajectory.cubics is not None:
        return trajectory.cubics.at(t, order)[order]
    at = motion_at(trajectory.profile, t)
    return by_time(trajectory.toolpath.path.evaluate(at.s, order), at, order)


def time_at(profile: Profile, s: Floats) -> Floats:
    """Return the times at which a profile leaves the places s (shape (n,), mm): at a wait, the end of the wait."""
    if not len(profile):
        return np.full(len(s), profile.t[-1])
    time = np.zeros(len(s))
    kernel.invert(np.ascontiguousarray(s, np.float64), *_columns(profile), np.zeros(4), time)
    return time


def arrival_at(profile: Profile, s: Floats) -> Floats:
    """Return the times at which a profile reaches places (shape (n,), mm): at a wait, its beginning."""
    if not len(profile):
        return np.full(len(s), profile.t[0])
    first = np.clip(np.searchsorted(profile.s, s, side="left"), 0, len(profile))
    return np.where(profile.s[first] == s, profile.t[first], time_at(profile, s))


def cut(profile: Profile, start: float, end: float, shift: float = 0.0) -> Profile:
    """Cut a profile from one time to another, and move it in time by `shift`; the pieces stay exact."""
    first = max(0, int(np.searchsorted(profile.t, start, side="right")) - 1)
    last = int(np.searchsorted(profile.t, end, side="left"))
    if end <= start or first >= min(last, len(profile)):
        nothing = np.zeros(0)
        place = motion_at(profile, np.array([start])).s
        return Profile(
            np.array([end + shift]), place, nothing, nothing, nothing, nothing, np.zeros(0, np.int8)
        )
    t = np.concatenate([[start], profile.t[first + 1 : last], [end]])
    ends = motion_at(profile, np.array([start, end]))
    s = np.concatenate([ends.s[:1], profile.s[first + 1 : last], ends.s[1:]])
    if profile.t[min(last, len(profile))] == end:
        s[-1] = profile.s[last]
    pick = slice(first, last)
    v, a, j = profile.v[pick].copy(), profile.a[pick].copy(), profile.j[pick].copy()
    c = profile.c[pick]
    v[0], a[0] = ends.v[0], ends.a[0]
    # s''' = j + c s' keeps its j wherever a piece is entered.
    j[0] = profile.j[first]
    return Profile(t + shift, s, v, a, j, c, profile.limit[pick])


def stepped(plan: Profile, t: Floats, s: Floats, planned: Floats) -> Profile:
    """Return pieces of constant speed, marked with the limit of a plan there.

    Args:
        plan: The plan.
        t, s: Shape (n,), when and where on its path they begin, and the last one ends.
        planned: Shape (n,), the time of the plan at each.
    """
    duration = np.diff(t)
    v = np.divide(np.diff(s), duration, out=np.zeros_like(duration), where=duration > 0.0)
    zero = np.zeros(len(v))
    limit = (
        plan.limit[motion_at(plan, planned[:-1]).piece] if len(plan) else np.full(len(v), np.int8(Limit.NONE))
    )
    return Profile(t, s, v, zero, zero, zero, limit)


def joined(parts: Sequence[Profile]) -> Profile:
    """Put profiles, each beginning where and when the one before it ends, one after the other."""
    t = np.concatenate([*(p.t[:-1] for p in parts), parts[-1].t[-1:]])
    s = np.concatenate([*(p.s[:-1] for p in parts), parts[-1].s[-1:]])
    v, a, j, c, limit = (
        np.concatenate([getattr(p, name) for p in parts]) for name in ("v", "a", "j", "c", "limit")
    )
    return Profile(t, s, v, a, j, c, limit.astype(np.int8))


def _columns(profile: Profile) -> tuple[Floats, ...]:
    p = profile
    return tuple(np.ascontiguousarray(x, np.float64) for x in (p.t, p.s, p.v, p.a, p.j, p.c))
