"""Profiles cut and joined are the profile; look-ahead windows settle what later rows cannot change."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.machine import Machine
from cncgen.planner import PlanOptions, plan
from cncgen.planner.assembly import assemble
from cncgen.planner.ild.look_ahead import Segments, joint_speeds, settled
from cncgen.planner.motion import arrival_at, cut, joined, motion_at, time_at
from cncgen.planner.record import Limit, Profile
from cncgen.toolpath.record import Toolpath

RNG = np.random.default_rng(17)


def some_profile() -> Profile:
    """Return pieces of every kind with a wait in the middle: ramp, cruise, wait, exponential, oscillation."""
    v = np.array([0.0, 20.0, 0.0, 30.0, 10.0])
    a = np.array([0.0, 0.0, 0.0, 100.0, 50.0])
    j = np.array([5e3, 0.0, 0.0, -900.0, 0.0])
    c = np.array([0.0, 0.0, 0.0, 30.0, -400.0])
    tau = np.array([0.09, 0.2, 0.5, 0.1, 0.05])
    s = [0.0]
    for k in range(5):
        one = Profile(
            np.array([0.0, tau[k]]),
            np.array([0.0, 1e9]),
            *(x[k : k + 1] for x in (v, a, j, c)),
            np.zeros(1, np.int8),
        )
        s.append(s[-1] + float(motion_at(one, tau[k : k + 1]).s[0]))
    t = np.concatenate([[1.0], 1.0 + np.cumsum(tau)])
    return Profile(t, np.array(s), v, a, j, c, np.arange(5, dtype=np.int8))


@given(st.lists(st.floats(1.0, 1.94), min_size=1, max_size=6, unique=True))
def test_parts_are_the_whole(times: list[float]) -> None:
    """Place, speed, acceleration and jerk of the joined parts are those of the profile, everywhere."""
    whole = some_profile()
    ends = [1.0, *sorted(times), float(whole.t[-1])]
    parts = joined([cut(whole, a, b) for a, b in pairwise(ends)])
    at = np.sort(RNG.uniform(1.0, whole.t[-1], 300))
    at = at[np.min(np.abs(at[:, None] - np.array(ends)), axis=1) > 1e-9]
    one, other = motion_at(whole, at), motion_at(parts, at)
    for name in ("s", "v", "a", "j"):
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=1e-9, atol=1e-8)
    assert parts.s[-1] == whole.s[-1]


def test_shift_and_nothing() -> None:
    """A cut moved in time; a cut of no length is a place."""
    whole = some_profile()
    part = cut(whole, 1.05, 1.25, shift=3.0)
    assert (part.t[0], part.t[-1]) == (4.05, 4.25)
    none = cut(whole, 1.2, 1.2)
    assert len(none) == 0
    assert none.s[0] == motion_at(whole, np.array([1.2])).s[0]


def test_arrival_and_leaving_differ_by_the_wait() -> None:
    """At the wait's place, arrival is its start and leaving its end; elsewhere they are one."""
    whole = some_profile()
    place = whole.s[2:3]
    assert arrival_at(whole, place)[0] == whole.t[2]
    assert time_at(whole, place)[0] == whole.t[3]
    inside = motion_at(whole, np.array([1.04, 1.2, 1.82])).s
    np.testing.assert_allclose(arrival_at(whole, inside), [1.04, 1.2, 1.82], atol=1e-12)


def test_waits_are_put_between_pieces() -> None:
    """Two pieces, joints at both ends and between, a wait at the start and one at the end."""
    ones = np.ones(2)
    profile, arrival = assemble(
        5.0, np.array([0.0, 1.0, 2.0]), (ones, ones, 0 * ones, 0 * ones, 0 * ones),
        np.zeros(2, np.int8), np.array([0, 1, 2]), np.array([0.5, 0.0, 0.25]),
    )  # fmt: skip
    assert profile.t.tolist() == [5.0, 5.5, 6.5, 7.5, 7.75]
    assert profile.s.tolist() == [0.0, 0.0, 1.0, 2.0, 2.0]
    assert arrival.tolist() == [5.0, 6.5, 7.5]
    assert profile.limit.tolist() == [Limit.STOP, 0, 0, Limit.STOP]


@given(st.integers(2, 40), st.integers(0, 10_000))
def test_settled_speeds_never_change(n: int, seed: int) -> None:
    """Whatever follows a window, the joints said to be settled keep their speeds to the bit."""
    rng = np.random.default_rng(seed)
    m = n + 10
    length, cap = rng.uniform(0.01, 8.0, m), rng.uniform(1.0, 120.0, m + 1)
    full = np.full(m, 120.0)
    limits = full * 0 + 2e3, full * 0 + 5e4
    whole = Segments(length, full, np.zeros(m, np.int8), *limits, cap)
    window = Segments(length[:n], full[:n], np.zeros(n, np.int8), limits[0][:n], limits[1][:n], cap[: n + 1])
    known = settled(window, 0.0, "bell")
    inside = joint_speeds(window, 0.0, 0.0, "bell")[:known]
    assert (joint_speeds(whole, 0.0, 0.0, "bell")[:known] == inside).all()


def test_window_hands_on_before_the_end(lines: Callable[..., Toolpath], table: Machine) -> None:
    """First trajectories leave while the program is still being read: smoothing gathers 2048 rows, and nothing waits for the end."""
    drawn = 0

    def chunks() -> list[Toolpath]:
        nonlocal drawn
        for i in range(1600):
            drawn += 1
            x = 0.4 * i - 400.0
            yield lines([(x, 0), (x + 0.2, 0.06), (x + 0.4, 0)], 50.0)

    trajectories = plan(chunks(), table, PlanOptions(feedrate="ild", lookahead_rows=8))
    next(iter(trajectories))
    assert drawn < 1050
    assert list(trajectories)[-1].profile.t[-1] == pytest.approx(
        list(plan(chunks(), table, PlanOptions(feedrate="ild")))[-1].profile.t[-1], rel=1e-9
    )
