"""The distance from the commanded path: the kernel's skipping search beside one that leaves no segment out."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from cncgen.kernels import servo_contour

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def to_segment(a: Floats, b: Floats, x: Floats) -> float:
    """Distance of a point from a segment."""
    along = np.clip((b - a) @ (x - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return float(np.linalg.norm(a + along * (b - a) - x))


def all_segments(path: Floats, arc: Floats, own: Indices, last: Indices, x: Floats, reach: float) -> Floats:
    """Of every segment that begins, as seen from the point that was commanded, within `reach` times the tracking error."""
    found = []
    for k, at in enumerate(own):
        best = float(np.linalg.norm(x[k] - path[at]))
        window = reach * best + 1e-9
        back = [i for i in range(at) if arc[at] - arc[i + 1] < window]
        ahead = [i for i in range(at, last[k]) if arc[i] - arc[at] < window]
        found.append(min([best, *(to_segment(path[i], path[i + 1], x[k]) for i in back + ahead)]))
    return np.array(found)


@given(
    st.integers(0, 10**6), st.integers(1, 3), st.floats(0.01, 20.0), st.floats(1.0, 8.0), st.integers(2, 70)
)  # fmt: skip
def test_nothing_nearer_is_skipped(seed: int, axes: int, error: float, reach: float, count: int) -> None:
    """Walks that cross themselves, with steps of very different lengths; errors from a hundredth of a step to the whole path."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(size=(count - 1, axes)) * 10.0 ** rng.uniform(-2.0, 0.5, (count - 1, 1))
    path = np.concatenate([np.zeros((1, axes)), np.cumsum(steps, axis=0)])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=1))])
    own = np.sort(rng.integers(0, count, 25))
    last = np.minimum(own + rng.integers(0, 40, 25), count - 1)
    # Some stand where they were to be, give or take, and some beside quite another place of the path.
    beside = np.where(rng.random(25) < 0.5, own, rng.integers(0, count, 25))
    position = path[beside] + error * rng.normal(size=(25, axes)) * rng.choice([0.01, 1.0], (25, 1))
    found, feet = np.empty(25), np.empty((25, axes))
    servo_contour.distances(path, arc, own, last, position, reach, found, feet)
    assert np.linalg.norm(position - feet, axis=1) == pytest.approx(found, rel=1e-9, abs=1e-12)
    on_path = [min(to_segment(a, b, foot) for a, b in pairwise(path)) for foot in feet]
    assert max(on_path) < 1e-9
    assert found == pytest.approx(all_segments(path, arc, own, last, position, reach), rel=1e-12, abs=1e-12)


def test_what_lies_beyond_the_reach_or_the_last_point_is_not_looked_at() -> None:
    """There and back 1 mm beside: the way back is nearer, but 20 mm of path away, and may not be known yet."""
    path = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 1.0], [0.0, 1.0]])
    arc = np.array([0.0, 10.0, 11.0, 21.0])
    position = np.array([[0.5, 0.9]])
    for reach, last, distance in ((3.0, 3, 0.9), (30.0, 3, 0.1), (30.0, 2, 0.9)):
        found = np.empty(1)
        servo_contour.distances(
            path, arc, np.array([0]), np.array([last]), position, reach, found, np.empty((0, 2))
        )
        assert found[0] == pytest.approx(distance)


@given(st.integers(0, 10**6), st.integers(1, 3), st.integers(1, 60))
def test_points_that_places_are_at(seed: int, axes: int, count: int) -> None:
    """Beside numpy's argmin over the points ahead that are within reach, place by place."""
    rng = np.random.default_rng(seed)
    path = np.cumsum(rng.uniform(0.1, 1.0, (80, axes)) * rng.choice([-1.0, 1.0], (80, axes)), axis=0)
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    wanted = path[np.sort(rng.integers(0, 80, count))] + rng.normal(0.0, 0.1, (count, axes))
    wanted[rng.random(count) < 0.2] = wanted[0]
    at, expected = 0, []
    for k, place in enumerate(wanted):
        step = float(np.linalg.norm(place - wanted[k - 1])) if k else 0.0
        if not k or step > 0.0:
            end = int(np.searchsorted(arc, arc[at] + 2.0 * step + 0.5)) + 1
            at += int(((path[at:end] - place) ** 2).sum(axis=1).argmin())
        expected.append(at)
    found = np.empty(count, np.int64)
    servo_contour.vertices_reached(path, arc, wanted, 0.1, found)
    assert found.tolist() == expected
