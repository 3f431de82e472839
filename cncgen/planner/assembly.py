"""Pieces of motion and the waits of events, laid on one time axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.record import Limit, Profile
from cncgen.toolpath.record import Event

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Part of a period that counts as none.
_ROUNDING = 1e-6
#: Halvings in which the latest setpoint after a rest is found.
_HALVINGS = 30


def assemble(
    start_s: float,
    place: Floats,
    moves: tuple[Floats, Floats, Floats, Floats, Floats],
    limit: NDArray[np.int8],
    offset: Ints,
    waits: Floats,
    why: NDArray[np.int8] | None = None,
) -> tuple[Profile, Floats]:
    """Put waits between pieces and pieces after each other in time.

    Args:
        start_s: Time at the first joint.
        place: Shape (k + 1,): path coordinate at the start of each piece, and at the end.
        moves: Duration, v, a, j, c of the pieces, each of shape (k,).
        limit: Shape (k,).
        offset: Shape (joints,): the piece that begins at each joint, k at the last.
        waits: Shape (joints,): seconds of rest at each joint; 0 for none.
        why: Shape (joints,): the `Limit` that each wait is for; all are stops of the program by default.

    Returns:
        The profile, and the time of arrival at each joint (before its wait).
    """
    at_rest = np.flatnonzero(waits > 0.0)
    where = offset[at_rest]
    duration, v, a, j, c = (np.insert(column, where, 0.0) for column in moves)
    duration[where + np.arange(len(where))] = waits[at_rest]
    t = start_s + np.concatenate([[0.0], np.cumsum(duration)])
    s = np.insert(place, where, place[where])
    earlier = np.concatenate([[0], np.cumsum(waits > 0.0)])[:-1]
    name = np.int8(Limit.STOP) if why is None else why[at_rest]
    profile = Profile(t, s, v, a, j, c, np.insert(limit, where, name))
    return profile, t[offset + earlier]


def waits_of(events: Sequence[tuple[int, int, Event]], joints: int, first: int = 0) -> Floats:
    """Add up the dwells of events at each of the joints from `first` on, shape (joints,), s."""
    waits = np.zeros(joints)
    for joint, _, event in events:
        waits[joint - first] += event.dwell_s
    return waits


@dataclass(frozen=True, slots=True)
class Cuts:
    """`k` rests in corners that the chord of a period may cut too far, ascending.

    Attributes:
        joint: Shape (k,), which joints they are.
        room: Shape (k,), mm: the tolerance by |Δ|, the size of the step of dx/ds.
        bend: Shape (k, 2), 1/mm: |x''| by |Δ| before and after the corner.
        acceleration, jerk: Shape (k, 2), along the path before and after the corner.
    """

    joint: Ints
    room: Floats
    bend: Floats
    acceleration: Floats
    jerk: Floats

    def __len__(self) -> int:
        return len(self.joint)

    def between(self, first: int, last: int) -> Cuts:
        """Return those of the joints from `first` to before `last`, which are counted from `first`."""
        part = slice(*np.searchsorted(self.joint, [first, last]).tolist())
        columns = (self.room, self.bend, self.acceleration, self.jerk)
        return Cuts(self.joint[part] - first, *(each[part] for each in columns))

    def late(self, which: int, since_s: float, due_s: float) -> float:
        """Return how long after a rest a setpoint may be the first one, where the last one was so long before it, s.

        From or to rest the motion goes w(τ) = J τ³/6 or A τ²/2, whichever is less, in the time τ at most. A chord that
        begins a before the corner and ends b after it cuts it by no more than (|Δ| + κ₁ a/2 + κ₂ b/2) a b/(a + b), and curves
        beside it leave what that makes of the chord by κ₁ a²/8 and κ₂ b²/8.

        Args:
            which: The rest.
            since_s: How long before it the last setpoint was.
            due_s: How long after it the next one is, which is as late as it may be.
        """
        room, (one, other) = self.room[which], self.bend[which]
        before = self._way(which, 0, since_s)

        def cut(time_s: float) -> float:
            after = self._way(which, 1, time_s)
            both = before + after
            sharp = before * after / both if both > 0.0 else 0.0
            turned = 1.0 + 0.5 * (one * before + other * after)
            return float(sharp * turned + 0.125 * max(one * before**2, other * after**2))

        if cut(due_s) <= room:
            return due_s
        low, high = 0.0, due_s
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if cut(middle) <= room else (low, middle)
        return low

    def _way(self, which: int, side: int, time_s: float) -> float:
        """Return how far the motion comes from rest, or to rest, in a time, mm."""
        by_jerk = float(self.jerk[which, side]) * time_s**3 / 6.0
        return min(by_jerk, float(self.acceleration[which, side]) * time_s**2 / 2.0)


def kept_for_setpoints(start_s: float, way_s: Floats, waits: Floats, cuts: Cuts, period_s: float) -> Floats:
    """Lengthen waits so that chords between setpoints cut no rest too far: a setpoint falls on it, or near enough to it.

    Args:
        start_s: Time at the first joint, s; setpoints fall on multiples of the period.
        way_s: Shape (joints,), s: time of the motion up to each joint, without waits.
        waits: Shape (joints,), s of rest at each joint.
        cuts: The rests that it is about.
        period_s: T.
    """
    out = waits.copy()
    arrival = start_s + way_s + np.cumsum(waits) - waits
    # A chord that goes over the next corner too is none that this one's room tells of.
    alone = np.diff(way_s[cuts.joint], append=np.inf) > period_s
    later = 0.0
    for k, joint in enumerate(cuts.joint.tolist()):
        due = -(arrival[joint] + later) % period_s
        # What rounding leaves until the next one is no wait.
        if due >= (1.0 - _ROUNDING) * period_s:
            continue
        late = cuts.late(k, period_s - due, due) if alone[k] else 0.0
        more = max(0.0, due - late - waits[joint])
        out[joint] += more
        later += more
    return out


def timed(
    events: Sequence[tuple[int, int, Event]], arrival: Floats, first: int = 0
) -> tuple[tuple[float, int, Event], ...]:
    """Give each event its time: the arrival at its joint, and after that the dwells of the events before it there."""
    done: list[tuple[float, int, Event]] = []
    at, waited = -1, 0.0
    for joint, line, event in events:
        if joint != at:
            at, waited = joint, 0.0
        done.append((float(arrival[joint - first]) + waited, line, event))
        waited += event.dwell_s
    return tuple(done)
