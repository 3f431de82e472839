"""The kernels of smoothing, compiled and as plain Python, and the smoothing length by a slow obvious reference."""

from __future__ import annotations

from itertools import pairwise
from types import ModuleType

import numpy as np
import pytest
from scipy.interpolate import BSpline

from cncgen.geometry.corridor import END_DERIVATIVES, END_POINT, first_lengths
from cncgen.geometry.path import LINE, Path
from cncgen.geometry.pieces import Pieces, pieces_of
from cncgen.geometry.tables import empty_arcs, empty_nurbs
from cncgen.kernels import smoothing, smoothing_lengths
from tests.kernels.plain import uncompiled

LENGTHS = ("adjust", "choose", "lay", "length_at", "lower")


def plain() -> ModuleType:
    """Load the kernel and the one that it calls uncompiled."""
    kernel, lengths = uncompiled("smoothing"), uncompiled("smoothing_lengths")
    for name in LENGTHS:
        setattr(kernel, name, getattr(lengths, name))
    return kernel


def polyline(count: int, seed: int) -> Pieces:
    """Return lines of all lengths with all turns as pieces within 10 µm."""
    rng = np.random.default_rng(seed)
    heading = np.cumsum(rng.normal(size=count) * rng.choice([0.05, 1.0], count))
    way = 10.0 ** rng.uniform(-2.0, 0.5, count)
    steps = way[:, None] * np.stack([np.cos(heading), np.sin(heading), 0.1 * np.sin(3.0 * heading)], axis=1)
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    path = Path("XYZ", points[0], [LINE] * count, points[1:], [-1] * count, empty_arcs(), empty_nurbs(3))
    return pieces_of(path, np.full(count, 0.01), np.ones(3)).joined()


def fitted(kernel: ModuleType, pieces: Pieces, tail: int) -> tuple:
    """Return what a kernel makes of pieces."""
    n = len(pieces.y)
    room = 4 * n + 200
    knots, fixed, points = np.zeros(room), np.zeros((room, 3)), np.zeros((room, 3))
    used, scale = np.zeros((n, 2)), np.minimum(first_lengths(pieces), 0.5)
    last, worst = kernel.fit(
        pieces.t, pieces.y, pieces.bend, pieces.tolerance, pieces.t[-1:], scale, np.full(n + 1, 0.5), 2, 0.85,
        knots, 4, fixed, END_POINT, tail, points, used,
    )  # fmt: skip
    return last, worst, knots, points, used, scale


def path_at(pieces: Pieces, at: np.ndarray) -> np.ndarray:
    """Return the path's points at places along it, shape (n, 3)."""
    k = np.clip(np.searchsorted(pieces.t, at, side="right") - 1, 0, len(pieces.y) - 1)
    u = (at - pieces.t[k])[:, None]
    a = pieces.y[k]
    return a[:, 0] + u * (a[:, 1] + u * (a[:, 2] + u * a[:, 3]))


def least_squares(pieces: Pieces, knots: np.ndarray, at: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return the control points of the least ∫|x − y|² (trapezoidal rule over `at`) plus ΣL⁶|x'''|² (over its control points)."""
    count = len(knots) - 5
    weight = np.zeros(len(at))
    weight[:-1] += 0.5 * np.diff(at)
    weight[1:] += 0.5 * np.diff(at)
    third = BSpline(knots, np.eye(count), 4).derivative(3)
    rows, sizes = [], []
    for i in range(count - 3):
        place = float(np.clip(knots[i + 4], pieces.t[0], pieces.t[-1]))
        k = int(np.clip(np.searchsorted(pieces.t, place, side="right") - 1, 0, len(pieces.y) - 1))
        length = smoothing_lengths.length_at(pieces.t, scale, k, place)
        sizes.append(0.5 * (knots[i + 5] - knots[i + 3]) * length**6)
        # x''' is linear between knots, so its control points are its values there.
        rows.append(third(np.nextafter(place, 0.0) if place == knots[-1] else place))
    root = np.sqrt(weight)[:, None]
    basis = BSpline.design_matrix(at, knots, 4).toarray()
    left = np.concatenate([root * basis, np.sqrt(sizes)[:, None] * np.array(rows)])
    right = np.concatenate([root * path_at(pieces, at), np.zeros((count - 3, 3))])
    # The first point is the path's.
    first = path_at(pieces, knots[:1])
    rest = np.linalg.lstsq(left[:, 1:], right - left[:, :1] * first, rcond=None)[0]
    return np.concatenate([first, rest])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_curve_is_that_of_dense_least_squares_and_uses_what_it_says(seed: int) -> None:
    """Beside scipy's B-splines and numpy's least squares, and beside distances at 60,000 places."""
    pieces = polyline(12, seed)
    last, worst, knots, points, used, scale = fitted(smoothing, pieces, 0)
    knots, points = knots[: last + 5], points[:last]
    at = np.zeros(4 * len(knots) + 40)
    at = at[: smoothing_lengths.choose(pieces.t, pieces.bend, np.append(knots, 0.0), 4, last, at)]
    # The condition of the equations is (L/h)⁶, so both have the rounding of that.
    np.testing.assert_allclose(points, least_squares(pieces, knots, at, scale), atol=1e-7)
    s = np.union1d(np.linspace(0.0, pieces.t[-1], 60_001), pieces.t)
    off = np.linalg.norm(BSpline(knots, points, 4)(s) - path_at(pieces, s), axis=1) / 0.01
    halves = np.sort(np.append(pieces.t, 0.5 * (pieces.t[1:] + pieces.t[:-1])))
    half = np.searchsorted(halves, s, side="right") - 1
    found = np.array([off[half == k].max() for k in range(24)])
    # It is a bound: no less than what the places show, and of a piece a few hundredths more at the most.
    assert np.all(used.ravel() >= found - 1e-9)
    assert np.all(used.max(axis=1) < found.reshape(-1, 2).max(axis=1) + 0.05)
    assert worst == used.max() <= 1.0


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("tail", [0, END_POINT, END_DERIVATIVES])
def test_plain_python_gives_the_same_curve(seed: int, tail: int) -> None:
    pieces = polyline(12, seed)
    for ours, theirs in zip(fitted(smoothing, pieces, tail), fitted(plain(), pieces, tail), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-10, atol=1e-13)


def test_plain_python_lays_the_same_lengths_knots_and_samples() -> None:
    pieces, lengths = polyline(30, 3), uncompiled("smoothing_lengths")
    rng = np.random.default_rng(4)
    start, used = rng.uniform(0.01, 0.4, 31), rng.uniform(0.0, 1.5, (30, 2))
    made = []
    for kernel in (smoothing_lengths, lengths):
        scale, knots, at, change = start.copy(), np.zeros(2000), np.zeros(6000), np.zeros(31)
        kernel.lower(pieces.t, scale)
        last = kernel.lay(pieces.t, scale, pieces.t[[7, -1]], knots, 4, np.empty(31))
        knots[last + 1 : last + 5] = knots[last]
        count = kernel.choose(pieces.t, pieces.bend, knots, 4, last, at)
        here = kernel.length_at(pieces.t, scale, 5, 0.3 * pieces.t[5] + 0.7 * pieces.t[6])
        lowered = scale.copy()
        kernel.adjust(pieces.t, scale, used, np.full(31, 0.3), True, 0.85, change)
        made.append((last, knots, count, at, here, lowered, scale, change))
    for ours, theirs in zip(*made, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_lengths_change_by_steps() -> None:
    """In thousandths: knots add up lengths, and what rounding makes of a factor would add up with them."""
    pieces = polyline(30, 5)
    made = []
    for rounding in (0.0, 1e-12):
        used = np.random.default_rng(8).uniform(0.2, 1.3, (30, 2)) * (1.0 + rounding)
        scale, change = np.full(31, 0.01), np.zeros(31)
        smoothing_lengths.adjust(pieces.t, scale, used, np.full(31, 1.0), True, 0.85, change)
        made.append(change)
    np.testing.assert_array_equal(*made)
    assert (change > 1.0).any()
    assert (change < 1.0).any()


def test_lengths_grow_by_four_tenths_of_the_way() -> None:
    """The largest function below the given values with that slope: the least over all of value + 0.4 distance."""
    rng = np.random.default_rng(6)
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(0.01, 2.0, 40))])
    given = rng.uniform(0.01, 3.0, 41)
    scale = given.copy()
    smoothing_lengths.lower(t, scale)
    np.testing.assert_allclose(scale, (given + 0.4 * np.abs(t[:, None] - t)).min(axis=1), rtol=1e-12)


def test_there_is_no_room_for_more_knots_than_there_is_room() -> None:
    pieces = polyline(12, 1)
    scale = np.full(13, 1e-3)
    assert smoothing_lengths.lay(pieces.t, scale, pieces.t[-1:], np.zeros(50), 4, np.empty(13)) == -1


def test_knots_stand_alike_by_the_length_between_them() -> None:
    """∫dt/L, by the trapezoidal rule, from one knot to the next, and somewhat more where L changes: all alike between cuts."""
    pieces = polyline(30, 7)
    scale, knots = np.random.default_rng(9).uniform(0.02, 0.3, 31), np.zeros(3000)
    smoothing_lengths.lower(pieces.t, scale)
    cuts = np.array([0.3 * pieces.t[4] + 0.7 * pieces.t[5], pieces.t[11], pieces.t[-1]])
    last = smoothing_lengths.lay(pieces.t, scale, cuts, knots, 4, np.empty(31))
    s = np.union1d(np.linspace(0.0, pieces.t[-1], 400_001), np.concatenate([pieces.t, knots[4 : last + 1]]))
    k = np.clip(np.searchsorted(pieces.t, s, side="right") - 1, 0, 29)
    length = np.array([smoothing_lengths.length_at(pieces.t, scale, *at) for at in zip(k, s, strict=True)])
    weight = np.where(np.abs(np.diff(length)) > 0.2 * np.diff(s), 0.4 / 0.392, 1.0)
    strides = np.append(0.0, np.cumsum(weight * np.diff(s) * 0.5 * (1.0 / length[1:] + 1.0 / length[:-1])))
    steps = np.diff(strides[np.searchsorted(s, knots[4 : last + 1])])
    borders = np.searchsorted(knots[4 : last + 1], np.append(0.0, cuts))
    for first, stop in pairwise(borders):
        assert stop - first > 3
        np.testing.assert_allclose(steps[first:stop], steps[first], rtol=1e-3)
        assert abs(steps[first] * (stop - first) - (stop - first)) < 0.7


def test_the_reverse_of_a_path_has_its_knots_and_samples() -> None:
    """Once laid from the start, they were not: which curve came out turned on the direction."""
    pieces, rng = polyline(30, 3), np.random.default_rng(4)
    scale, bend = rng.uniform(0.01, 0.4, 31), rng.choice([0.0, 1.0], 30)
    cuts = np.append(pieces.t[0], pieces.t[[7, 19, -1]])
    made = []
    for way in (1, -1):
        t, length = (np.ascontiguousarray(column[::way]) for column in (way * pieces.t, scale))
        t -= t[0]
        knots, at = np.zeros(2000), np.zeros(6000)
        smoothing_lengths.lower(t, length)
        places = np.ascontiguousarray((way * cuts)[::way])
        last = smoothing_lengths.lay(t, length, (places - places[0])[1:], knots, 4, np.empty(31))
        knots[last + 1 : last + 5] = knots[last]
        count = smoothing_lengths.choose(t, np.ascontiguousarray(bend[::way]), knots, 4, last, at)
        made.append((knots[4 : last + 1], at[:count]))
    for forth, back in zip(*made, strict=True):
        np.testing.assert_allclose(forth, forth[-1] - back[::-1], atol=1e-10)
