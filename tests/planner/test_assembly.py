"""SegmentPieces and waits put together in time, and events at the moments that dwells give them."""

from __future__ import annotations

import numpy as np
import pytest

from cncgen.planner.assembly import assemble, timed, waits_of
from cncgen.planner.interpolators import ticks_between
from cncgen.planner.motion import motion_at, time_at
from cncgen.planner.record import Limit
from cncgen.toolpath.record import Event

#: At joint, of line, what: a dwell at the start, two events and a dwell between them at the second joint.
EVENTS = [
    (0, 1, Event("dwell", dwell_s=0.5)),
    (1, 3, Event("spindle")),
    (1, 4, Event("dwell", dwell_s=2.0)),
    (1, 5, Event("coolant")),
]


def test_dwells_at_a_joint_add_up_and_events_fall_due_behind_those_before_them() -> None:
    """Joints are counted from the first that is asked for."""
    assert waits_of(EVENTS, 3).tolist() == [0.5, 2.0, 0.0]
    assert waits_of(EVENTS[1:], 2, first=1).tolist() == [2.0, 0.0]
    due = timed(EVENTS, np.array([0.0, 10.0, 14.0]))
    assert [(t, line, event.name) for t, line, event in due] == [
        (0.0, 1, "dwell"), (10.0, 3, "spindle"), (10.0, 4, "dwell"), (12.0, 5, "coolant"),
    ]  # fmt: skip


def test_a_motion_rests_where_it_waits_and_goes_on_as_it_was() -> None:
    """Two jerks from rest to rest over 2 mm, once without and once with waits of 0.5 s before and 2 s in the middle joint.

    From rest with the jerk j for a second v = j/2 and s = j/6; back with −j from the speed v at the acceleration 0.
    """
    moves = tuple(np.array(column) for column in ([1.0, 1.0], [0.0, 0.0], [0.0, 0.0], [6.0, 6.0], [0.0, 0.0]))
    place, limit = np.array([0.0, 1.0, 2.0]), np.full(2, Limit.JERK, np.int8)
    offset = np.array([0, 1, 2])
    plain, arrival = assemble(3.0, place, moves, limit, offset, np.zeros(3))
    assert arrival.tolist() == [3.0, 4.0, 5.0]
    waits = np.array([0.5, 2.0, 0.0])
    waiting, late = assemble(3.0, place, moves, limit, offset, waits)
    assert late.tolist() == [3.0, 4.5, 7.5]
    assert waiting.limit.tolist() == [Limit.STOP, Limit.JERK, Limit.STOP, Limit.JERK]
    assert waiting.waits.tolist() == [True, False, True, False]
    t = np.linspace(0.0, 1.0, 9)
    assert motion_at(waiting, 3.5 + t).s == pytest.approx(motion_at(plain, 3.0 + t).s, abs=1e-15)
    assert motion_at(waiting, 3.5 + t[:-1]).s == pytest.approx(t[:-1] ** 3, abs=1e-15)
    assert motion_at(waiting, 4.5 + 2.0 * t).s == pytest.approx(np.ones(9))
    assert motion_at(waiting, 6.5 + t).s == pytest.approx(motion_at(plain, 4.0 + t).s, abs=1e-15)
    # It leaves a place where it waits when the wait is over.
    assert time_at(waiting, np.array([1.0, 1.125])) == pytest.approx([6.5, 7.0])


def test_the_reason_of_a_wait_is_named() -> None:
    """What chords wait for a setpoint is no stop of the program."""
    none = np.zeros(0)
    profile, _ = assemble(
        0.0, np.zeros(1), (none,) * 5, np.zeros(0, np.int8), np.zeros(1, np.int64), np.array([0.3]),
        np.array([Limit.CHORD], np.int8),
    )  # fmt: skip
    assert (profile.limit.tolist(), profile.t.tolist()) == ([Limit.CHORD], [0.0, 0.3])


@pytest.mark.parametrize(
    ("start", "end", "ticks"),
    [(0.0, 0.003, [1, 2]), (0.0005, 0.0025, [1, 2]), (0.001, 0.002, []), (0.0015, 0.0019, []), (0.1 + 0.2, 0.302, [301])],
)  # fmt: skip
def test_ticks_are_the_multiples_of_the_period_strictly_between(
    start: float, end: float, ticks: list[int]
) -> None:
    """At 1 ms; 0.1 + 0.2 is 0.3 but for rounding, and no tick after it."""
    assert ticks_between(start, end, 0.001) == pytest.approx(np.array(ticks) * 0.001)
