"""Tangent, speed and curvature of setpoints by central differences, beside their closed forms on a circle."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from cncgen.servo.path_geometry import path_geometry
from cncgen.servo.plants import sampled_transfer_function
from cncgen.servo.stream import blocks
from cncgen.servo.summary import path_speed
from cncgen.setpoints.record import Setpoints

T = 0.004


@pytest.mark.parametrize("turn", [0.01, 0.1, 0.5])
@pytest.mark.parametrize("shift", [0, 1])
def test_on_a_circle_differences_are_those_of_sines(turn: float, shift: int) -> None:
    """With φ = ωT: speed R sin φ/T, acceleration R (2 − 2 cos φ)/T² inwards, so curvature (2 − 2 cos φ)/(R sin² φ)."""
    radius = 20.0
    angle = turn * np.arange(60)
    circle = Setpoints("XY", T, 0, radius * np.column_stack([np.cos(angle), np.sin(angle)]))
    (block,) = blocks([circle], 2, 2)
    found = path_geometry(block, shift)
    inner = slice(2, 56)
    at = angle[inner] + shift * turn
    inwards = -np.column_stack([np.cos(at), np.sin(at)])
    assert found.speed[inner] == pytest.approx(np.full(54, radius * math.sin(turn) / T))
    assert found.tangent[inner] == pytest.approx(np.column_stack([-np.sin(at), np.cos(at)]))
    acceleration = 2.0 * radius * (1.0 - math.cos(turn)) / T**2
    assert found.acceleration[inner] == pytest.approx(acceleration * inwards, rel=1e-9, abs=1e-6)
    curvature = 2.0 * (1.0 - math.cos(turn)) / (radius * math.sin(turn) ** 2)
    assert found.curvature[inner] == pytest.approx(curvature * inwards, rel=1e-6, abs=1e-9)
    # Between two setpoints it is the chord, 2 R sin(φ/2).
    chord = 2.0 * radius * math.sin(0.5 * turn) / T
    assert path_speed(circle.position, T) == pytest.approx(np.full(59, chord))


def test_at_rest_there_is_no_direction_and_where_it_crawls_no_curvature() -> None:
    """A step of 10⁻⁹ mm is rounding; of 10⁻⁵ mm its direction is known, but not how it bends."""
    rows = np.concatenate(
        [np.zeros((10, 2)), 1e-5 * np.column_stack([np.arange(10), (-1.0) ** np.arange(10)])]
    )
    (block,) = blocks([Setpoints("XY", T, 0, rows)], 1, 1)
    found = path_geometry(block)
    assert not found.tangent[:8].any()
    assert np.linalg.norm(found.tangent[12:18], axis=1) == pytest.approx(np.ones(6))
    assert not found.curvature.any()


def test_a_ratio_in_z_is_its_difference_equation() -> None:
    """y[k] = 1.5 y[k−1] − 0.56 y[k−2] + 0.3 u[k−1] + 0.1 u[k−2], as scipy filters, from rest under any input."""
    plant = sampled_transfer_function(np.array([0.3, 0.1]), np.array([1.0, -1.5, 0.56]), T, 2.0 * T)
    assert (plant.sample_time_s, plant.delay_s) == (T, 2.0 * T)
    u = np.random.default_rng(3).normal(size=200)
    x, out = np.zeros(2), np.zeros(200)
    for k in range(200):
        out[k] = plant.c @ x
        x = plant.a @ x + plant.b * u[k]
    expected = lfilter([0.0, 0.3, 0.1], [1.0, -1.5, 0.56], u)
    assert out == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize(
    ("numerator", "delay", "message"),
    [((1.0, 0.0), 0.0, "lower degree"), ((1.0,), 0.5 * T, "whole number of its sample times")],
)
def test_a_ratio_in_z_that_is_no_plant_is_refused(
    numerator: tuple[float, ...], delay: float, message: str
) -> None:
    """One that answers at once, and one whose dead time ends between samples."""
    with pytest.raises(ValueError, match=message):
        sampled_transfer_function(np.array(numerator), np.array([1.0, -0.5]), T, delay)
