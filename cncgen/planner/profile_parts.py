"""Profiles cut in time and put together again."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.motion import motion_at, time_at
from cncgen.planner.record import Limit, Profile

Floats = NDArray[np.float64]


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
