"""`ild` against Tsai's figures, closed forms on lines, and what any plan must keep."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cncgen.diagnostics import ProgramError, UsageError
from cncgen.machine import Machine
from cncgen.planner import PlanOptions, Trajectory, plan
from cncgen.planner.motion import motion_at
from cncgen.planner.record import Limit
from cncgen.toolpath.record import Event, FeedMode, PathMode, Toolpath

ILD = PlanOptions(feedrate="ild")


def planned(chunks: list[Toolpath], machine: Machine, options: PlanOptions = ILD) -> list[Trajectory]:
    """Plan and draw everything."""
    return list(plan(chunks, machine, options))


def total(trajectories: list[Trajectory]) -> float:
    """Time at the end."""
    return float(trajectories[-1].profile.t[-1])


@pytest.mark.parametrize(("feed", "corners"), [(7000, 24), (5000, 14), (3500, 11)])
def test_butterfly_has_the_papers_sharp_corners(
    feed: int, corners: int, program: Callable[..., list[Toolpath]], table: Machine
) -> None:
    """Tsai 2010, Fig. 6: 24, 14 and 11 sharp corners at 7000, 5000 and 3500 mm/min."""
    (done,) = planned(program("butterfly.nc", feed), table)
    assert len(done.corners) == corners
    s = motion_at(done.profile, np.array([c.t_s for c in done.corners])).s
    kappa, top = done.toolpath.path.curvature(s), feed / 60.0
    assert (kappa * top**2 > 2450.0).all()
    # eqs 23 to 25 with δ = 1 µm, T = 1 ms and κ̄ = 1/mm
    chord = 2e3 * np.sqrt(2e-3 / kappa - 1e-6)
    speed = np.minimum(chord, top / (kappa + 1.0))
    # The last corner lies 0.33 mm before the end: there the stop is what limits it.
    np.testing.assert_allclose([c.feed_mm_s for c in done.corners[:-1]], speed[:-1], rtol=1e-6)
    assert {c.limit for c in done.corners[:-1]} <= {Limit.CURVATURE, Limit.CHORD, Limit.ACCELERATION}
    assert done.corners[-1].feed_mm_s < speed[-1]


@pytest.mark.parametrize(("feed", "time"), [(3500, 7.146), (5000, 5.334), (7000, 4.258)])
def test_butterfly_times_with_every_maximum_a_corner(
    feed: int, time: float, program: Callable[..., list[Toolpath]], table: Machine
) -> None:
    """An independent seven-phase plan (A 2450, J 5e4, δ 1 µm, κ̄ 1, d_min 0): 7.146, 5.334 and 4.258 s."""
    options = replace(ILD, corner_distance_mm=0.0)
    assert total(planned(program("butterfly.nc", feed), table, options)) == pytest.approx(time, abs=5e-4)


def test_short_lines_under_g64_are_smoothed_first(
    program: Callable[..., list[Toolpath]], bounded_table: Machine
) -> None:
    """2000 lines on the butterfly are passed as a curve; each was a corner of its own (56 s, 1991 corners).

    The NURBS itself takes 7.3 s at the same feed; smoothed lines stay within 0.01 mm and so have less curvature at its tips.
    """
    done = planned(program("butterfly_g1.nc"), bounded_table)
    curve = planned(program("butterfly.nc", 6000), bounded_table)
    assert 0.75 * total(curve) < total(done) < total(curve)
    assert sum(len(part.corners) for part in done) < 30


def test_a_rounded_corner_is_passed_within_acceleration_and_jerk_of_its_curvature(
    program: Callable[..., list[Toolpath]], mill: Machine
) -> None:
    """v²κ ≤ A and v³κ² ≤ J at its apex, where the two rows of a rounding meet; a square of 50 mm at 100 mm/s."""
    done = planned(program("square_sharp.nc"), mill)
    bends = 0
    for part in done:
        at = part.toolpath.path.row_s[1:-1]
        kappa = part.toolpath.path.curvature(at - 1e-9)
        round_ = kappa > 1.0
        v = motion_at(part.profile, np.interp(at, part.profile.s, part.profile.t)).v[round_]
        bends += int(round_.sum())
        axis = mill.axes["X"]
        assert (v**2 * kappa[round_] <= 1.01 * axis.max_acceleration).all()
        assert (v**3 * kappa[round_] ** 2 <= 1.01 * axis.max_jerk).all()
    assert bends >= 3


def test_line_is_the_seven_phase_profile(lines: Callable[..., Toolpath], table: Machine) -> None:
    """Rest to rest over 100 mm at 100 mm/s: below A²/J = 120, so T = L/F + 2 √(F/J)."""
    done = planned([lines([(0, 0), (100, 0)])], table)
    assert total(done) == pytest.approx(100 / 100 + 2.0 * (100 / 5e4) ** 0.5, rel=1e-9)
    assert done[0].profile.s[-1] == 100.0


def test_diagonal_line_uses_both_axes(lines: Callable[..., Toolpath], table: Machine) -> None:
    """At 45° the path may accelerate √2 as hard as an axis; a rapid runs at the slower axis's share."""
    diagonal = lines([(0, 0), (50, 50)], feed=np.nan, feed_mode=FeedMode.RAPID)
    done = planned([diagonal], table)
    assert done[0].profile.v.max() == pytest.approx(250.0 * 2**0.5, rel=1e-6)
    top = np.abs(done[0].profile.a).max()
    assert top == pytest.approx(2450.0 * 2**0.5, rel=1e-9)


def test_corner_of_lines_is_all_but_a_stop(lines: Callable[..., Toolpath], table: Machine) -> None:
    """A step of an axis's speed by v is a third difference v/T² of the setpoints: v <= J T² = 0.05 mm/s."""
    done = planned([lines([(0, 0), (10, 0), (10, 10)])], table)
    (corner,) = done[0].corners
    assert corner.feed_mm_s == pytest.approx(0.05, rel=1e-9)
    assert corner.position[:2] == (10.0, 0.0)
    assert (corner.line, corner.limit) == (1, Limit.CORNER)


def test_splitting_a_line_changes_nothing(lines: Callable[..., Toolpath], table: Machine) -> None:
    """Tangent joints are passed at full speed: a line in a hundred parts takes as long."""
    whole = planned([lines([(0, 0), (100, 50)])], table)
    parts = planned([lines([(i, i / 2) for i in range(101)])], table)
    assert total(parts) == pytest.approx(total(whole), rel=1e-9)
    assert not any(t.corners for t in parts)


def test_exact_stop_and_events_rest(lines: Callable[..., Toolpath], table: Machine) -> None:
    """G61.1 stops at a tangent joint; a dwell waits its seconds at rest; other events do not stop."""
    straight = [(0, 0), (10, 0), (20, 0)]
    through = total(planned([lines(straight)], table))
    stops = total(planned([lines(straight, mode=PathMode.EXACT_STOP)], table))
    halves = total(planned([lines([(0, 0), (10, 0)])], table))
    assert stops == pytest.approx(2.0 * halves, rel=1e-9)
    passing = planned([lines(straight, events={1: Event("coolant")})], table)
    assert total(passing) == pytest.approx(through, rel=1e-12)
    ((when, line, event),) = passing[0].events
    assert motion_at(passing[0].profile, np.array([when])).s[0] == pytest.approx(10.0, abs=1e-9)
    assert (line, event.name) == (101, "coolant")
    dwelling = planned([lines(straight, events={1: Event("dwell", rest=True, dwell_s=0.5)})], table)
    assert total(dwelling) == pytest.approx(stops + 0.5, rel=1e-9)
    assert dwelling[0].events[0][0] == pytest.approx(halves, rel=1e-9)
    still = motion_at(dwelling[0].profile, np.array([halves + 0.25]))
    assert (still.s[0], still.v[0]) == (pytest.approx(10.0), 0.0)


def test_events_at_both_ends_and_alone(lines: Callable[..., Toolpath], table: Machine) -> None:
    """Events before the first and after the last motion, two at one place, and a chunk of events alone."""
    both = {0: Event("tool", dwell_s=1.0), 1: Event("stop", rest=True, dwell_s=2.0)}
    done = planned([lines([(0, 0), (10, 0)], events=both), lines([(10, 0)], events={0: Event("end")})], table)
    times = [when for t in done for when, _, _ in t.events]
    move = total(planned([lines([(0, 0), (10, 0)])], table))
    assert times == pytest.approx([0.0, 1.0 + move, 3.0 + move])
    assert total(done) == pytest.approx(3.0 + move)


def test_inverse_time_feed(lines: Callable[..., Toolpath], table: Machine) -> None:
    """G93: 30 mm in 1/0.1 s is 3 mm/s, with the ramps beside it."""
    done = planned([lines([(0, 0), (30, 0)], feed=0.1, feed_mode=FeedMode.INVERSE_TIME)], table)
    assert done[0].profile.v.max() == pytest.approx(3.0)
    assert total(done) == pytest.approx(10.0 + 2.0 * (3.0 / 5e4) ** 0.5)


def test_rotary_axis_alone(lines: Callable[..., Toolpath], mill: Machine) -> None:
    """A move of A alone is measured in rad and limited by that axis."""
    done = planned([lines([(0, 0, 0, 0), (0, 0, 0, 3.0)], feed=100.0, axes="XYZA")], mill)
    assert done[0].profile.s[-1] == pytest.approx(3.0)
    assert done[0].profile.v.max() <= mill.axes["A"].max_velocity * (1 + 1e-9)


def test_arc_holds_its_centripetal_limit(arc: Callable[..., Toolpath], table: Machine) -> None:
    """v²κ <= A and v³κ² <= J on an arc of radius 2 at a feed far above both."""
    done = planned([arc(2.0, 6.0, 240.0)], table)
    assert done[0].profile.v.max() == pytest.approx(
        min((2450 * 2.0) ** 0.5, (5e4 * 4.0) ** (1 / 3)), rel=1e-6
    )


def test_chunks_do_not_matter(lines: Callable[..., Toolpath], table: Machine) -> None:
    """The same program in chunks of 1, 3 or all rows, and with a small window, gives the same times."""
    rng = np.random.default_rng(2)
    turns = np.cumsum(rng.normal(0.0, 2e-4, 60))
    x = np.concatenate([[[0.0, 0.0]], np.cumsum(3.0 * np.stack([np.cos(turns), np.sin(turns)], 1), axis=0)])
    whole = total(planned([lines(x)], table))
    for size in (1, 3, 17):
        cut = [lines(x[i : i + size + 1]) for i in range(0, 60, size)]
        for rows in (20_000, 45):
            done = planned(cut, table, replace(ILD, lookahead_rows=rows))
            assert total(done) == pytest.approx(whole, rel=1e-9)
            ends = [(t.profile.t[0], t.profile.t[-1]) for t in done]
            assert all(a[1] == b[0] for a, b in pairwise(ends))


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-40, 40), st.floats(-40, 40)), min_size=2, max_size=12),
    st.sampled_from(["bell", "linear", "exponential"]),
    st.floats(1.0, 400.0),
)
def test_any_polyline_is_travelled_from_rest_to_rest(
    lines: Callable[..., Toolpath],
    table: Machine,
    points: list[tuple[float, float]],
    profile: str,
    feed: float,
) -> None:
    """Whatever the points: the whole length, monotone, from rest to rest, no faster than the feed."""
    done = planned([lines(points, feed)], table, replace(ILD, profile=profile))
    p = done[-1].profile
    length = np.linalg.norm(np.diff(np.array(points), axis=0), axis=1).sum()
    assert p.s[-1] == pytest.approx(length, rel=1e-9, abs=1e-9)
    at = motion_at(p, np.linspace(0.0, p.t[-1], 2000))
    assert (np.diff(at.s) >= -1e-9).all()
    assert (at.v <= min(feed, 250.0 * 2**0.5) * (1 + 1e-9)).all()
    assert at.v[0] == pytest.approx(0.0, abs=1e-6)


def test_no_feed_is_named(lines: Callable[..., Toolpath], table: Machine) -> None:
    """A cutting motion without F is an error with its line."""
    with pytest.raises(ProgramError) as caught:
        planned([lines([(0, 0), (1, 0), (2, 0)], feed=0.0)], table)
    assert [d.code for d in caught.value.diagnostics] == ["feed-missing"] * 2
    assert caught.value.diagnostics[0].span is not None
    assert caught.value.diagnostics[0].span.line == 1


def test_prediction_needs_servo_data(lines: Callable[..., Toolpath], bounded_table: Machine) -> None:
    """A bound on the contour error without servo data: every axis is named."""
    bare = replace(
        bounded_table, axes={k: replace(axis, servo=None) for k, axis in bounded_table.axes.items()}
    )
    with pytest.raises(UsageError) as caught:
        planned([lines([(0, 0), (1, 0)])], bare)
    assert ["axis X" in d.message or "axis Y" in d.message for d in caught.value.diagnostics] == [True, True]


def test_empty_program(table: Machine, lines: Callable[..., Toolpath]) -> None:
    """No chunks, no trajectories; rows of length 0 move nothing."""
    assert planned([], table) == []
    done = planned([lines([(1, 1), (1, 1), (1, 1)])], table)
    assert total(done) == 0.0


def test_corner_within_a_curve_is_a_corner(nurbs: Callable[..., Toolpath], table: Machine) -> None:
    """Three coinciding control points turn a cubic by 90° with no curvature at all: it is slowed for all the same."""
    curve = nurbs([(0, 0), (5, 0), (10, 0), (10, 0), (10, 0), (10, 5), (10, 10)], 100.0)
    (done,) = planned([curve], table)
    (corner,) = done.corners
    assert corner.position[:2] == pytest.approx((10.0, 0.0))
    assert corner.feed_mm_s == pytest.approx(0.05, rel=1e-3)
    assert corner.limit == Limit.CORNER


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([1, 5, 20_000]), st.sampled_from(["bell", "exponential"]))
def test_tiny_moves_in_small_windows(
    lines: Callable[..., Toolpath], table: Machine, seed: int, rows: int, profile: str
) -> None:
    """Moves of 1e-7 mm, doubled points and chunks without rows: no gap in time, the end is reached."""
    rng = np.random.default_rng(seed)
    x = np.round(rng.uniform(-2, 2, (rng.integers(2, 12), 2))) * 1e-7
    half = len(x) // 2
    chunks = [lines(x[: half + 1]), lines(x[half : half + 1]), lines(x[half:])]
    done = planned(chunks, table, replace(ILD, profile=profile, lookahead_rows=rows))
    assert all(a.profile.t[-1] == pytest.approx(b.profile.t[0], abs=1e-12) for a, b in pairwise(done))
    assert all((np.diff(t.profile.t) >= 0).all() for t in done)
    assert done[-1].profile.s[-1] == done[-1].row_s[-1]
