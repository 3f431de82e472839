"""Motions between nodes: places, speeds, and ways into the room, compiled and plain, by closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cncgen.kernels import tube_motion

from .plain import uncompiled

KERNELS = pytest.mark.parametrize(
    "kernel", [tube_motion, uncompiled("tube_motion")], ids=["compiled", "plain"]
)


@KERNELS
def test_places_are_those_of_a_cubic(kernel: Any) -> None:
    """x = t³, cut at uneven times: the nodes' own times belong to the interval that they end."""
    end = np.array([0.3, 0.4, 1.1])
    t = np.concatenate([[0.0], end])
    x = np.stack([t**3, -(t**3)], axis=1)
    v, a = 3.0 * t**2, 6.0 * t
    state = [np.stack([each, -each], axis=1) for each in (v, a)]
    times = np.array([0.0, 0.1, 0.3, 0.35, 0.4, 0.41, 1.1])
    points, node = np.empty((7, 2)), np.empty(7, np.int64)
    jerk = np.tile([6.0, -6.0], (3, 1))
    kernel.positions(x, *state, jerk, np.diff(t), times, node, points)
    assert points == pytest.approx(np.stack([times**3, -(times**3)], axis=1), abs=1e-15)
    assert node.tolist() == [0, 0, 0, 1, 1, 2, 2]


@KERNELS
def test_the_top_of_a_parabola_counts(kernel: Any) -> None:
    """v = 60 t - 30 t² for 2 s has its top, 30, at 1 s; beside 40 of another axis the speed is 50 there, by its bound at most 50.03."""
    velocity, jerk = np.array([[0.0, 40.0], [0.0, 40.0]]), np.array([[-60.0, 0.0]])
    acceleration, step, out = np.array([[60.0, 0.0], [-60.0, 0.0]]), np.array([2.0]), np.empty(1, np.int8)
    for top, feed, second, over in (
        (30.01, 50.03, 1.0, 0), (29.99, 50.03, 1.0, 1), (30.01, 49.99, 1.0, 1), (30.01, 49.99, 0.0, 0)
    ):  # fmt: skip
        weight, most = np.array([[1.0, second]]), np.array([top, 50.0])
        kernel.too_fast(velocity, acceleration, jerk, step, most, np.array([feed]), weight, out)
        assert out.tolist() == [over]


@KERNELS
def test_nodes_come_into_their_room_within_their_planes(kernel: Any) -> None:
    """A band along X of 1 mm about Y 0: a node at Y 3 comes to Y 0.9; one across a plane of 45° comes there along the plane."""
    point = np.array([[0.0, 3.0], [0.0, 0.5], [0.0, 3.0]])
    tangent = np.array([[1.0, 0.0], [1.0, 0.0], [np.sqrt(0.5), np.sqrt(0.5)]])
    first, rows = np.array([0, 1, 2, 3]), np.zeros((3, 2))
    direction, out = np.tile([1.0, 0.0], (3, 1)), np.zeros((3, 2))
    kernel.move_inside(point, tangent, first, rows, direction, np.ones(3), 0.9, out)
    assert (point + out)[:2] == pytest.approx(np.array([[0.0, 0.9], [0.0, 0.5]]), abs=1e-15)
    assert abs(float((point + out)[2, 1])) <= 0.9 + 1e-9
    assert out[2] @ tangent[2] == pytest.approx(0.0, abs=1e-12)
