"""Pieces of motion and the waits of events, laid on one time axis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.record import Limit, Profile
from cncgen.toolpath.record import Event, Toolpath

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


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
    if not len(where):
        t = start_s + np.concatenate([[0.0], np.cumsum(moves[0])])
        return Profile(t, place, *moves[1:], limit), t[offset]
    duration, v, a, j, c = (np.insert(column, where, 0.0) for column in moves)
    duration[where + np.arange(len(where))] = waits[at_rest]
    t = start_s + np.concatenate([[0.0], np.cumsum(duration)])
    s = np.insert(place, where, place[where])
    earlier = np.concatenate([[0], np.cumsum(waits > 0.0)])[:-1]
    name = np.int8(Limit.STOP) if why is None else why[at_rest]
    profile = Profile(t, s, v, a, j, c, np.insert(limit, where, name))
    return profile, t[offset + earlier]


def events_before(toolpath: Toolpath, index: Ints) -> list[tuple[int, int, Event]]:
    """Return the events of a toolpath, with the source line of each and the place in `index` of the moving row that it is before.

    Args:
        toolpath: The rows.
        index: Shape (m,), the numbers of those that move.
    """
    return [(int(np.searchsorted(index, row)), line, event) for row, line, event in toolpath.event_rows]


def waits_of(events: Sequence[tuple[int, int, Event]], joints: int, first: int = 0) -> Floats:
    """Add up the waits of events at each of the joints from `first` on, shape (joints,), s."""
    waits = np.zeros(joints)
    for joint, _, event in events:
        waits[joint - first] += event.wait_s
    return waits


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
        waited += event.wait_s
    return tuple(done)
