"""A limit that is relaxed never makes a motion longer: curves on which it once did."""

from __future__ import annotations

from types import MappingProxyType

import pytest

import cncgen
from cncgen.machine.record import Axis, Machine

#: Velocity, acceleration and jerk of X Y Z; the axis whose acceleration is relaxed; control points and weights; knots.
WEAK_X_AND_Z = (
    {"X": (29.0, 300.0, 489.0), "Y": (967.0, 10000.0, 16305.0), "Z": (29.0, 300.0, 489.0)},
    "Z",
    [(0, 0, 0, 1), (-6, -5, -1.2, 1), (10, 12, -1, 0.5), (2, -3, 0.2, 0.5)],
    [0, 0, 0, 0],
)
HIGH_JERK = (
    {"X": (6.64188, 8.85027, 30000.0), "Y": (221.396, 295.009, 1e6), "Z": (221.396, 295.009, 1e6)},
    "Z",
    [(0, 0, 0, 0.5), (-11, -10, 1.8, 2), (-3, -12, 2.8, 1), (5, 11, 3, 0.5), (-13, -7, 0.6, 1), (12, 13, -1.4, 1), (7, 0, 2.8, 1), (-5, 15, 3, 1)],
    [0, 0, 0, 0, 0.1, 0.8, 0.9, 0.9],
)  # fmt: skip


def seconds(limits: dict[str, tuple[float, float, float]], points: list, knots: list[float]) -> float:
    """Return the least time of a cubic NURBS of G61."""
    rows = [f"K{k} X{x} Y{y} Z{z} R{r}" for k, (x, y, z, r) in zip(knots, points, strict=True)]
    rows[0] += " F3453"
    text = "\n".join(["G21 G90 G61", f"G6.2 P4 {rows[0]}", *rows[1:], *["K1"] * 4, "M2", ""])
    axes = {letter: Axis(letter, *values) for letter, values in limits.items()}
    machine = Machine("weak", MappingProxyType(axes))
    return list(cncgen.plan(cncgen.read_text(text), machine))[-1].profile.t[-1]


@pytest.mark.parametrize("case", [WEAK_X_AND_Z, HIGH_JERK])
@pytest.mark.parametrize("factor", [1.25, 1.5, 3.0])
def test_more_acceleration_takes_no_more_time(case: tuple, factor: float) -> None:
    """The interval beside a rest was too long where jerk binds (1.7 %); a window found no start, and stopped (0.8 %)."""
    limits, letter, points, knots = case
    velocity, acceleration, jerk = limits[letter]
    relaxed = {**limits, letter: (velocity, factor * acceleration, jerk)}
    assert seconds(relaxed, points, knots) <= seconds(limits, points, knots) * (1.0 + 1e-3)
