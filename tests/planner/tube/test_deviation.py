"""By how much setpoints are over the tolerance: closed forms, with and without order, and beside the Fréchet distance of dense samples."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from cncgen.planner.tube import deviation
from cncgen.planner.tube.deviation import Reached, excess, reached, tangled
from cncgen.planner.tube.programmed import RowLines
from cncgen.planner.tube.window_problem import Solved

Floats = NDArray[np.float64]
TOLERANCE = 0.01


def rows(*points: tuple[float, float], tolerance: float = TOLERANCE) -> RowLines:
    return RowLines(
        np.array(points, float), np.arange(float(len(points))), np.full(len(points) - 1, tolerance)
    )


def motion(position: Floats, velocity: Floats, acceleration: Floats, jerk: Floats, step: Floats) -> Solved:
    return Solved(position, velocity, acceleration, jerk, step, 1, 0)


def steady(*points: tuple[float, float], nodes: int = 20) -> Solved:
    """Return a motion of 1 mm/s along lines; its nodes are the same part of each line apart."""
    x = np.array(points, float)
    part = np.arange(nodes) / nodes
    position = np.concatenate([*(a + part[:, None] * (b - a) for a, b in pairwise(x)), x[-1:]])
    way = np.diff(position, axis=0)
    step = np.sqrt((way**2).sum(axis=1))
    velocity = np.concatenate([way / step[:, None], np.zeros((1, 2))])
    return motion(position, velocity, np.zeros_like(position), np.zeros_like(way), step)


def ends(path: RowLines, found: Solved) -> tuple[Reached, Reached]:
    """Return the start of the first row and the end of the last one."""
    return Reached.at(found.position[0], 0.0), Reached.at(found.position[-1], path.key[-1], path.key[-2])


def none(path: RowLines) -> NDArray[np.int64]:
    """Return that no vertex has a node."""
    return np.full(len(path.key), -1)


def over(path: RowLines, found: Solved, period_s: float = 1e-3, first_s: float = 0.0) -> Floats:
    return excess(path, ends(path, found), none(path), found, first_s, period_s, 0.0)[0]


def test_a_missed_vertex_counts_at_its_own_node() -> None:
    """A motion that cuts a right angle from 0.3 before to 0.3 behind it leaves the vertex by 0.3/√2; elsewhere it is on the rows."""
    path = rows((0, 0), (1, 0), (1, 1))
    found = steady((0, 0), (0.7, 0), (1, 0.3), (1, 1))
    for own in (25, 32):
        at = none(path)
        at[1] = own
        by = excess(path, ends(path, found), at, found, 0.0, 1e-3, 0.0)[0]
        assert by[own] == pytest.approx(0.3 * np.sqrt(0.5) - TOLERANCE, abs=1e-6)


@pytest.mark.parametrize(
    ("points", "near"),
    [
        # A closed square ends in the corner where it began, and goes on; along the rows that is 4 away.
        (((-1, 0), (0, 0), (1, 0), (1, 1), (0, 1), (0, 0), (-1, -1)), False),
        (((-1, 0), (0, 0), (0, 3.9 * TOLERANCE), (1, 1)), True),
        (((-1, 0), (0, 0), (0, 4.1 * TOLERANCE), (1, 1)), False),
    ],
)
def test_corners_are_near_each_other_along_the_rows(
    points: tuple[tuple[float, float], ...], near: bool
) -> None:
    """Corners are near each other by four tolerances; a motion that cuts one is judged with few comparisons where they are not."""
    path = rows(*points)
    own = none(path)
    own[[1, -2]] = 0
    assert tangled(path, own) == near


def test_a_motion_over_the_tolerance_is_judged_in_two_comparisons(monkeypatch: pytest.MonkeyPatch) -> None:
    """A closed square whose corners are passed at 1.2 of the tolerance: one comparison tells, a wider one measures."""
    cut = 1.2 * TOLERANCE * np.sqrt(2.0)
    corner = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    way = [corner[0]]
    for (x0, y0), (x, y), (x1, y1) in zip(corner[:-1], corner[1:], [*corner[2:], corner[0]], strict=True):
        way += [(x + cut * (x0 - x), y + cut * (y0 - y)), (x + cut * (x1 - x), y + cut * (y1 - y))]
    path = rows(*corner, corner[0])
    found = steady(*way, corner[0], nodes=10)
    made, walk = [], deviation._Walker.walk
    monkeypatch.setattr(deviation._Walker, "walk", lambda *given: made.append(1) or walk(*given))
    by, _ = excess(path, ends(path, found), np.array([0, 20, 40, 60, 69]), found, 0.0, 1e-4, 0.0)
    assert by.max() == pytest.approx(0.2 * TOLERANCE, rel=0.01)
    assert len(made) == 2


def test_a_motion_beside_a_line_is_over_by_what_it_is_apart() -> None:
    path = rows((0, 0), (1, 0))
    assert (over(path, steady((0, 0.0099), (1, 0.0099))) < 0.0).all()
    found = over(path, steady((0, 0.0), (0.5, 0.0), (0.5, 0.012), (1, 0.012)))
    assert found.max() == pytest.approx(0.002, abs=1e-9)
    assert found[:29].max() < 0.0 < found[-20:].min()


def test_a_corner_that_is_cut_is_over_by_its_distance_from_the_way() -> None:
    """A way from 0.1 before to 0.1 behind a right angle passes it by 0.1/√2."""
    found = over(rows((0, 0), (1, 0), (1, 1)), steady((0, 0), (0.9, 0), (1, 0.1), (1, 1)))
    assert found.max() == pytest.approx(0.1 / np.sqrt(2.0) - TOLERANCE, rel=1e-3)
    assert 20 <= found.argmax() < 40


def test_places_are_passed_in_order() -> None:
    """Rows go to 1, back to 0.5 and on. A way straight on is on them everywhere, and passes all; in order it is never nearer than 0.25."""
    path, straight = rows((0, 0), (1, 0), (0.5, 0), (1.5, 0)), steady((0, 0), (1.5, 0))
    assert 0.1 < over(path, straight).max() <= 0.25
    wide = rows((0, 0), (1, 0), (0.5, 0), (1.5, 0), tolerance=0.2501)
    assert (over(wide, straight) < 0.0).all()


def test_a_motion_reaches_the_end_of_the_rows() -> None:
    assert over(rows((0, 0), (1, 0)), steady((0, 0), (0.9, 0))).max() == pytest.approx(
        0.1 - TOLERANCE, rel=0.05
    )


@pytest.mark.parametrize("period_s", [0.05, 0.2])
def test_chords_of_setpoints_of_any_phase_count(period_s: float) -> None:
    """A way with an acceleration a and speed to and fro across is furthest from its chords by a T²/8 at its tip."""
    a, h = 2.0, 0.02
    t = np.arange(-25, 26) * h
    position, velocity = np.stack([t, 0.5 * a * t**2], axis=1), np.stack([np.ones_like(t), a * t], axis=1)
    found = motion(
        position,
        velocity,
        np.broadcast_to([0.0, a], position.shape).copy(),
        np.zeros((50, 2)),
        np.full(50, h),
    )
    # The rows are the way itself, with chords that are short beside setpoints.
    fine = np.linspace(-0.5, 0.5, 2001)
    points = np.stack([fine, 0.5 * a * fine**2], axis=1)
    sagitta = a * period_s**2 / 8.0
    for tolerance, kept in ((1.02 * sagitta, True), (0.98 * sagitta, False)):
        path = RowLines(points, np.linspace(0.0, 1.0, 2001), np.full(2000, tolerance))
        assert (over(path, found, period_s) <= 0.0).all() == kept


@pytest.mark.parametrize("part", [0.5, 0.5 - 1.0 / 24.0])
def test_a_tip_is_missed_by_setpoints_of_the_motion_itself(part: float) -> None:
    """Setpoints half a period before and after a tip are a T²/8 short of it; of any twelfth of a period later, 0.84 of that at most."""
    a, period, h = 2.0, 0.2, 0.02
    t = np.arange(-25, 26) * h
    position, velocity = (np.stack([each, 0.0 * t], axis=1) for each in (-0.5 * a * t**2, -a * t))
    found = motion(
        position,
        velocity,
        np.broadcast_to([-a, 0.0], position.shape).copy(),
        np.zeros((50, 2)),
        np.full(50, h),
    )
    path = rows(
        (float(position[0, 0]), 0.0),
        (0.0, 0.0),
        (float(position[-1, 0]), 0.0),
        tolerance=0.97 * a * period**2 / 8.0,
    )
    first = (0.5 - part * period) % period
    assert (over(path, found, period, first) <= 0.0).all() == (part < 0.5)


def test_a_motion_goes_on_from_where_it_may_be() -> None:
    """What follows is judged from the places that are reached: half a way, and the rest from there."""
    path = rows((0, 0), (1, 0), (0.5, 0), (1.5, 0))
    whole = steady((0, 0), (1, 0), (0.5, 0), (1.5, 0))
    assert (over(path, whole) <= 0.0).all()
    there = reached(path, ends(path, whole)[0], whole, 0.0, 1e-3, 0.0, 30)
    # At 0.75 on the way back, and nowhere else.
    assert there.line == 1.0
    assert (float(there.low[0]), float(there.high[0])) == pytest.approx((1.5 - 0.02, 1.5 + 0.02))
    # The last setpoint before node 30 is there, one more than half a period later is not.
    assert there.point == pytest.approx([0.75, 0.0])
    before = reached(path, ends(path, whole)[0], whole, 0.6e-3, 1e-3, 0.0, 30).point
    assert before == pytest.approx([0.75 + 0.4e-3, 0.0])
    rest = Solved(
        whole.position[30:],
        whole.velocity[30:],
        whole.acceleration[30:],
        whole.jerk[30:],
        whole.step[30:],
        1,
        0,
    )
    goal = ends(path, whole)[1]
    assert (excess(path, (there, goal), none(path), rest, 0.0, 1e-3, 0.0)[0] <= 0.0).all()
    # From there a way that leaves out the turn is not in order.
    assert excess(path, (there, goal), none(path), steady((0.75, 0), (1.5, 0)), 0.0, 1e-3, 0.0)[0].max() > 0.1
