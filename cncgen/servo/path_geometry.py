"""Tangent, speed and curvature of a setpoint stream, by central differences over neighbouring setpoints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.stream import SampleBlock

Floats = NDArray[np.float64]

#: Below this step from setpoint to setpoint a direction is rounding, mm.
STANDING_MM = 1e-8
#: Below this one a curvature is.
CRAWLING_MM = 1e-4


@dataclass(frozen=True, slots=True)
class PathGeometry:
    """Per setpoint, shape (n, axes) or (n,): velocity, acceleration, unit tangent (0 at rest), speed, curvature vector."""

    velocity: Floats
    acceleration: Floats
    tangent: Floats
    speed: Floats
    curvature: Floats


def path_geometry(block: SampleBlock, shift: int = 0) -> PathGeometry:
    """Return the geometry at each setpoint of a block (or `shift` setpoints later); it needs a margin of one more."""
    before, at, after = (block.shifted(shift + by) for by in (-1, 0, 1))
    velocity = (after - before) / (2.0 * block.period_s)
    acceleration = (after - 2.0 * at + before) / block.period_s**2
    speed = np.sqrt((velocity**2).sum(axis=1))
    moving = speed * block.period_s > STANDING_MM
    tangent = np.where(moving[:, None], velocity / np.where(moving, speed, 1.0)[:, None], 0.0)
    across = acceleration - (acceleration * tangent).sum(axis=1)[:, None] * tangent
    fast = speed * block.period_s > CRAWLING_MM
    curvature = np.where(fast[:, None], across / np.where(fast, speed, 1.0)[:, None] ** 2, 0.0)
    return PathGeometry(velocity, acceleration, tangent, speed, curvature)
