"""What places of a path allow along it: the kernel beside array formulas and beside its plain source."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from numpy.typing import NDArray

from cncgen.kernels import along_path
from tests.kernels.plain import uncompiled

Floats = NDArray[np.float64]

LIMITS = np.array([[500.0, 3000.0, 5e4], [400.0, 2500.0, 4e4], [50.0, np.inf, 1e4], [3.0, 20.0, 900.0]]).T
SCALE = np.array([1.0, 1.0, 1.0, 180.0 / np.pi])
FEED, VELOCITY, CHORD, CENTRIPETAL = range(1, 5)
TOLERANCE, PERIOD = 0.002, 0.001


def places(axes: int, seed: int) -> Floats:
    """Derivatives of all sizes, some of them 0: straight places, axes that stand still, places where nothing moves."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(3, 400, axes)) * 10.0 ** rng.uniform(-6, 6, (3, 400, 1))
    x[rng.random((3, 400, axes)) < 0.1] = 0.0
    x[1, :40] = 0.0
    x[0, 20:60] = 0.0
    x[2, 30:80] = 0.0
    return x


def ratio(a: Floats, b: Floats) -> Floats:
    """a / b, the largest number for what is infinite, 0 for 0 / 0."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.nan_to_num(a / b)


def results(kernel: ModuleType, x1: Floats, x2: Floats, x3: Floats) -> tuple[Floats, ...]:
    """All that the kernel says of places."""
    n, axes = x1.shape
    velocity, acceleration, jerk = LIMITS[:, :axes].copy()
    feed = np.where(np.arange(n) % 3 == 0, np.inf, 80.0)
    weakest, q, chord, turning = *np.empty((3, n)), np.empty((5, n))
    kind = np.empty(n, np.int8)
    kernel.weakest(velocity, x1, weakest)
    kernel.top(
        feed, np.full(n, FEED, np.int8), velocity, TOLERANCE, PERIOD, 12000.0, SCALE[:axes].copy(),
        np.array([VELOCITY, CHORD, CENTRIPETAL], np.int8), x1, x2, q, kind,
    )  # fmt: skip
    kernel.turning(acceleration, jerk, x1, x2, x3, turning)
    # Of both rows beside a place, the narrower one counts.
    before, after = np.arange(n) % 2, (np.arange(n) + 1) % 2
    tolerance = np.array([TOLERANCE, np.inf])
    kernel.chords_of_rows(x1, x2, SCALE[:axes].copy(), tolerance, before, after, PERIOD, chord)
    return weakest, q, kind, chord, turning


def formulas(x1: Floats, x2: Floats, x3: Floats) -> tuple[Floats, ...]:
    """The same as array formulas."""
    n, axes = x1.shape
    velocity, acceleration, jerk = LIMITS[:, :axes]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        weakest = (velocity / np.abs(x1)).min(axis=1)
        y1, y2 = x1 * SCALE[:axes], x2 * SCALE[:axes]
        part = np.sum(y1 * y2, axis=1) / np.sum(y1 * y1, axis=1)
        across = np.linalg.norm(y2 - np.where(np.isnan(part), 0.0, part)[:, None] * y1, axis=1)
        curvature = np.linalg.norm(x2[:, :3], axis=1)

        def chord_of(bend: Floats) -> Floats:
            return 2.0 / PERIOD * np.sqrt(TOLERANCE * np.maximum(2.0 / bend - TOLERANCE, 1.0 / bend))

        # Sharper than the tolerance: half of a period's way is no more than that.
        common = across if axes > 3 else curvature
        way = np.where(common > 1.0 / TOLERANCE, 2.0 * TOLERANCE / PERIOD / np.linalg.norm(y1, axis=1), 0.0)
        speeds = [
            np.where(np.arange(n) % 3 == 0, np.inf, 80.0),
            weakest,
            np.maximum(chord_of(common), way),
            np.sqrt(12000.0 / curvature),
        ]
        steep, bend, twist = (np.abs(x / acceleration).max(axis=1) for x in (x1, x2, x3))
        steep_j, bend_j, twist_j = (np.abs(x / jerk).max(axis=1) for x in (x1, x2, x3))
        turn = np.maximum(ratio(bend, steep), ratio(bend_j, steep_j))
        change = np.maximum(ratio(twist, steep), ratio(twist_j, steep_j))
        turning = np.array([1.0 / steep, 1.0 / steep_j, ratio(bend, steep), turn, change])
        return (
            weakest,
            np.min(speeds, axis=0) ** 2,
            1 + np.argmin(speeds, axis=0),
            chord_of(across),
            turning,
        )


@pytest.mark.parametrize("axes", [3, 4])
def test_the_kernel_says_what_the_formulas_do(axes: int) -> None:
    x = places(axes, axes)
    found, expected = results(along_path, *x), formulas(*x)
    assert len(set(found[2].tolist())) == 4
    # What is across is a difference: it has digits of what lies along.
    y1, y2 = x[0] * SCALE[:axes], x[1] * SCALE[:axes]
    clear = np.abs((y1 * y2).sum(axis=1)) < (1.0 - 1e-6) * np.linalg.norm(y1, axis=1) * np.linalg.norm(
        y2, axis=1
    )
    for which in (0, 1, 3):
        np.testing.assert_allclose(found[which][clear], expected[which][clear], rtol=1e-10)
    np.testing.assert_array_equal(found[2][clear], expected[2][clear])
    np.testing.assert_allclose(found[4], expected[4], rtol=1e-13)


@pytest.mark.parametrize("axes", [3, 4])
def test_plain_python_says_the_same(axes: int) -> None:
    x = places(axes, 7)[:, :120].copy()
    for ours, theirs in zip(results(along_path, *x), results(uncompiled("along_path"), *x), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_rows_without_a_tolerance_bound_no_speed() -> None:
    x1, x2 = np.eye(3)[:1], np.eye(3)[1:2]
    speed, rows = np.zeros(1), np.zeros(1, np.int64)
    along_path.chords_of_rows(x1, x2, np.ones(3), np.array([np.inf]), rows, rows, PERIOD, speed)
    assert speed[0] == np.inf


def test_the_chord_of_an_arc() -> None:
    """A chord of the length 2 √(2 r δ − δ²) lies δ from its arc; within the tolerance the way to the nearer end counts."""
    bend, tolerance = np.array([0.1, 1.0, 1.0, 0.0]), np.array([0.01, 0.5, 4.0, 0.01])
    speed = np.empty(4)
    along_path.chord_speed(bend, tolerance, 0.5, speed)
    exact = [2.0 * np.sqrt(2.0 * 10.0 * 0.01 - 0.01**2), 2.0 * np.sqrt(2.0 * 0.5 - 0.25), 2.0 * 2.0, np.inf]
    np.testing.assert_allclose(speed * 0.5, exact)
