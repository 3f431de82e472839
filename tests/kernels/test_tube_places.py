"""Where points are nearest to a polyline, beside the least distance over all of it and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from cncgen.kernels import tube_places
from tests.kernels.plain import uncompiled


def matched(
    line: np.ndarray,
    points: np.ndarray,
    within: float,
    last: bool = True,
    least: float = 0.0,
    kernel=tube_places,
    rests: tuple[int, int] | None = None,
) -> np.ndarray:
    """Return the places of points in order, as many as there are; `rests` is a point, and the vertex where the motion rests there."""
    resting, still = np.zeros(len(points), np.int8), np.zeros(len(line), np.int8)
    if rests is not None:
        resting[rests[0]], still[rests[1]] = 1, 1
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    place = np.full(len(points), np.nan)
    count = len(points)
    entry, leaving, part = np.zeros(count), np.zeros(count, np.int64), np.zeros(1)
    found = kernel.match(
        line,
        way,
        points,
        np.full(count, within),
        np.full(count, least),
        resting,
        still,
        0.0,
        0.0,
        last,
        entry,
        leaving,
        place,
        part,
    )
    return place[:found]


def spiral(turns: np.ndarray) -> np.ndarray:
    """Return points of a spiral whose turns are 2 mm apart."""
    r = 1.0 + 2.0 * turns
    return np.stack([r * np.cos(2.0 * np.pi * turns), r * np.sin(2.0 * np.pi * turns), 0.2 * turns], axis=1)


def nearest(line: np.ndarray, point: np.ndarray) -> float:
    """Return the place of the least distance over all segments."""
    step = np.diff(line, axis=0)
    u = np.clip(((point - line[:-1]) * step).sum(axis=1) / (step**2).sum(axis=1), 0.0, 1.0)
    k = np.linalg.norm(point - line[:-1] - u[:, None] * step, axis=1).argmin()
    return float(k + u[k])


@pytest.mark.parametrize("seed", range(4))
def test_places_on_a_spiral_are_the_nearest_of_all(seed: int) -> None:
    """Its turns are twenty times as far apart as the points are from it, so no other place is near."""
    rng = np.random.default_rng(seed)
    line = spiral(np.sort(rng.uniform(0.0, 3.0, 700)))
    at = np.sort(rng.uniform(0.02, 2.98, 120))
    points = spiral(at) + rng.uniform(-0.03, 0.03, (120, 3))
    found = matched(line, points, 0.1)
    expected = np.array([nearest(line, point) for point in points])
    in_order = np.diff(expected, prepend=-1.0) > 0.0
    assert len(found) == 120
    # Where noise has turned two points round, the second has its place no earlier than the first.
    assert np.all(np.diff(found) >= 0.0)
    np.testing.assert_allclose(found[in_order], expected[in_order], atol=1e-9)
    np.testing.assert_array_equal(found, matched(line, points, 0.1, kernel=uncompiled("tube_places")))


def test_a_circle_that_is_run_twice_has_places_on_both_rounds() -> None:
    """The vertices of a polygon of 90 sides, twice round: those of the second round have places 90 higher."""
    angle = 2.0 * np.pi * np.arange(181) / 90.0
    line = 10.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    asked = np.arange(0, 181, 9)
    np.testing.assert_allclose(matched(line, line[asked].copy(), 0.02), asked, atol=1e-9)


def test_the_same_point_again_is_as_far_on_as_is_asked() -> None:
    line = np.array([[0.0, 0.0], [10.0, 0.0]])
    points = np.array([[2.0, 0.0], [2.0, 0.0], [2.0, 0.0]])
    np.testing.assert_allclose(matched(line, points, 1.0), [0.2, 0.2, 0.2], atol=1e-12)
    np.testing.assert_allclose(matched(line, points, 1.0, least=0.5), [0.2, 0.25, 0.3], atol=1e-12)


def test_points_that_are_too_far_or_near_an_open_end_wait() -> None:
    line = np.stack([np.arange(11.0), np.zeros(11)], axis=1)
    points = np.array([[2.0, 0.0], [4.5, 0.05], [10.0, 0.0]])
    np.testing.assert_allclose(matched(line, points, 0.1), [2.0, 4.5, 10.0], atol=1e-12)
    # The polyline goes on: what comes behind its last vertex may be nearer to the last point.
    np.testing.assert_allclose(matched(line, points, 0.1, last=False), [2.0, 4.5], atol=1e-12)
    # The second is farther from it than the polyline passes by any point.
    np.testing.assert_allclose(matched(line, points, 0.04), [2.0], atol=1e-12)


@pytest.mark.parametrize("kernel", [tube_places, uncompiled("tube_places")], ids=["compiled", "plain"])
def test_a_point_of_rest_is_where_the_motion_rests(kernel) -> None:
    """Two turns of a square of 1 mm pass their start three times; the motion rests there at the end of the second."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    line = np.vstack([square, square, [[0.0, 0.0], [5.0, 0.0]]])
    points = np.array([[1.0, 1.0], [0.0, 0.0], [5.0, 0.0]])
    assert matched(line, points, 1e-3, kernel=kernel).tolist() == [2.0, 4.0, 9.0]
    assert matched(line, points, 1e-3, kernel=kernel, rests=(1, 8)).tolist() == [2.0, 8.0, 9.0]


@pytest.mark.parametrize("kernel", [tube_places, uncompiled("tube_places")], ids=["compiled", "plain"])
def test_no_point_before_a_rest_has_a_place_after_it(kernel) -> None:
    """Within a distance as wide as the path the nearest places of three points lie behind the rest; each was one segment further on.

    A dwell there was then no rest of the motion.
    """
    line = np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, -0.1], [1.0, -0.2], [1.0, -0.3], [1.0, -1.0]])
    points = np.array([[0.0, 0.0], *[[1.0, -0.5]] * 3, [1.0, 0.0], [1.0, -1.0]])
    found = matched(line, points, 2.0, kernel=kernel, rests=(4, 2))
    assert found.tolist() == [0.0, 2.0, 2.0, 2.0, 2.0, 6.0]
