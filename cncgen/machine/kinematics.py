"""How the rotary axes of a five-axis machine carry its table or its head: the table ``[kinematics]`` of the machine.

```toml
[kinematics]
model = "table-table"            # or "head-head", or "head-table"
axes = ["a", "c"]                # the one that carries the other first; head-table: the head's first
centre_mm = [0.0, 0.0, -150.0]   # tables: a point of their axes (two: where they meet), machine coordinates
pivot_mm = 180.0                 # heads: from the spindle's gauge line to their axes (two: to where they meet)
tolerance_mm = 0.001             # how far lines of the machine's axes may be from the tool's path
degree_mm = 2.0                  # what a degree of them counts as in the tolerances of path and chords
```

A turns about X, B about Y, C about Z, positive as ISO 841 has it: the tool turns that way relative to the workpiece, so a
table turns the other way. With p the tool's tip in machine coordinates of the table at 0, L the tool's length, z the
direction of the spindle, H the rotation of the head and T that which a table takes back, the machine stands at

    m = c + T^-1 (p - c) + H (L + P) z - P z,

which is p + L z where the rotary axes are at 0, as without G43.4, and the tool's direction in the coordinates of the table
is T H z. H and T are

| model | H | T |
| --- | --- | --- |
| table-table | 1 | R2(θ2) R1(θ1) |
| head-table | R1(θ1) | R2(θ2) |
| head-head | R1(θ1) R2(θ2) | 1 |
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cncgen.machine.settings_schema import KINEMATICS, check

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.machine.record import Machine

Vector = tuple[float, float, float]
_TOLERANCE_MM = 0.001
_SPINDLE: Vector = (0.0, 0.0, 1.0)
#: Columns of A and C, and the axes of the planes in which A, B and C turn.
_A, _C = 3, 5
_PLANES = ((1, 2), (2, 0), (0, 1))
#: Directions nearer than this to an axis lie along it.
_TINY = 1e-9


@dataclass(frozen=True, slots=True)
class Kinematics:
    """Lengths in mm.

    `machine`, `tip`, `lever` and `reach` take points and angles one at a time, or each coordinate as an array, for as many.

    Attributes:
        heads: How many of the rotary axes carry the tool; the others carry the table.
        axes: Columns of the rotary axes (3 is A), the carrying axis first; of one in the head and one in the table, the head's first.
        centre: A point of the axes of tables, machine coordinates.
        pivot: From the gauge line to the axes of heads.
        tolerance: Largest distance of the axes' lines from the path.
    """

    heads: int
    axes: tuple[int, int]
    centre: Vector = (0.0, 0.0, 0.0)
    pivot: float = 0.0
    tolerance: float = _TOLERANCE_MM

    @property
    def turns(self) -> tuple[int, int]:
        """Which of the axes turns the spindle first, and which second: 0 the first of `axes`, 1 the other."""
        return (1, 0) if self.heads == len(self.axes) else (0, 1)

    @property
    def _of_head(self) -> tuple[int, ...]:
        return self.turns[: self.heads]

    @property
    def _of_table(self) -> tuple[int, ...]:
        return self.turns[self.heads :]

    def machine(self, tip: Vector, angles: tuple[float, float], length: float) -> Vector:
        """Return X Y Z of the machine for a tip, angles in degrees and a tool of that length."""
        c, away = self.centre, _less(tip, self.centre)
        for place in reversed(self._of_table):
            away = _turn(away, self.axes[place], -angles[place])
        x, y, z = self._turned((0.0, 0.0, length + self.pivot), self._of_head, angles)
        return c[0] + away[0] + x, c[1] + away[1] + y, c[2] + away[2] + z - self.pivot

    def tip(self, machine: Vector, angles: tuple[float, float], length: float) -> Vector:
        """Return the tip of the tool: the inverse of `machine`."""
        c = self.centre
        arm = self._turned((0.0, 0.0, length + self.pivot), self._of_head, angles)
        away = _less(_less(machine, arm), (c[0], c[1], c[2] - self.pivot))
        x, y, z = self._turned(away, self._of_table, angles)
        return c[0] + x, c[1] + y, c[2] + z

    def lever(self, tip: Vector, angles: tuple[float, float], length: float) -> float:
        """Return how far the tip goes on the workpiece as the rotary axes turn, mm/rad: the root of the sum of the squares over both.

        By each axis it is the distance of what the axis carries from it.
        """
        away, arm, squares = _less(tip, self.centre), (0.0, 0.0, length + self.pivot), 0.0
        for place in reversed(self._of_table):
            squares += _beside_axis(away, self.axes[place])
            away = _turn(away, self.axes[place], -angles[place])
        for place in self._of_head:
            squares += _beside_axis(arm, self.axes[place])
            arm = _turn(arm, self.axes[place], angles[place])
        return squares**0.5

    def reach(self, tip: Vector, length: float) -> float:
        """Return what the lever is at most, at any angles, mm/rad; it bounds the second derivative too (`ToolPointSink.counts`)."""
        x, y, z = _less(tip, self.centre)
        squares = len(self._of_table) * (x * x + y * y + z * z)
        return (squares + len(self._of_head) * (length + self.pivot) ** 2) ** 0.5

    def direction(self, angles: tuple[float, float]) -> Vector:
        """Return the direction from the tool's tip to its spindle, in the coordinates of the table."""
        return self._turned(_SPINDLE, self.turns, angles)

    def angles_of(self, direction: Vector, near: tuple[float, float]) -> tuple[float, float] | None:
        """Return the angles, in degrees, that give the tool a direction: of the two pairs the one with the least way from `near`.

        An axis that lies along the direction stays. None where the axis that turns the spindle first is C: then no angle tilts it.
        """

        def way(pair: tuple[float, float]) -> float:
            return round(abs(pair[0] - near[0]) + abs(pair[1] - near[1]), 6)

        return min(self.pairs_of(direction, near), key=way, default=None)

    def pairs_of(
        self, direction: Vector, near: tuple[float, float], along: float | None = None
    ) -> list[tuple[float, float]]:
        """Return both pairs of angles, degrees, that give the tool a direction, by the whole turns that bring them nearest to `near`.

        An axis that lies along the direction goes to `along`, or stays where that is None. No pair where the axis that turns the spindle
        first is C.
        """
        # d = R(last) R(tilt) z: the component of d along the last axis is that of R(tilt) z, which gives the tilt.
        tilt, last = (self.axes[place] for place in self.turns)
        if tilt == _C:
            return []
        x, y, z = wanted = unit_vector(direction)
        if last == _C:
            steep = math.degrees(math.atan2(math.hypot(x, y), z))
            tilts = (steep, -steep)
        else:
            steep = math.degrees(
                math.atan2(x, math.hypot(y, z)) if last == _A else -math.atan2(y, math.hypot(x, z))
            )
            tilts = (steep, 180.0 - steep)
        a, b = _PLANES[last - _A]
        first, second = self.turns
        now = near[first], near[second]
        pairs = []
        for angle in tilts:
            bent = _turn(_SPINDLE, tilt, angle)
            turn = now[1] if along is None else along
            if math.hypot(wanted[a], wanted[b]) > _TINY:
                turn = math.degrees(math.atan2(wanted[b], wanted[a]) - math.atan2(bent[b], bent[a]))
            pair = _nearest(angle, now[0]), _nearest(turn, now[1])
            pairs.append((pair[first], pair[second]))
        return pairs

    def turned_plane(self, angles: tuple[float, float]) -> tuple[Vector, ...]:
        """Return the rotation, by rows, whose Z is `direction` and whose X and Y are the machine's while the axes stand at these angles."""
        return self._rotation(self.turns, angles)

    def table_plane(self, angles: tuple[float, float]) -> tuple[Vector, ...]:
        """Return the part of `turned_plane` that the table turns: T above."""
        return self._rotation(self._of_table, angles)

    @property
    def tilting(self) -> int:
        """Which of the axes turns the spindle first."""
        return self.turns[0]

    def _rotation(self, turns: tuple[int, ...], angles: tuple[float, float]) -> tuple[Vector, ...]:
        x, y, z = (self._turned(unit, turns, angles) for unit in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), _SPINDLE))
        return tuple((x[i], y[i], z[i]) for i in range(3))

    def _turned(self, vector: Vector, turns: tuple[int, ...], angles: tuple[float, float]) -> Vector:
        """Turn a vector by axes, one after another."""
        for place in turns:
            vector = _turn(vector, self.axes[place], angles[place])
        return vector


def unit_vector(vector: Vector) -> Vector:
    """Return a vector of length 1."""
    length = math.hypot(*vector)
    return vector[0] / length, vector[1] / length, vector[2] / length


def _nearest(degrees: float, near: float) -> float:
    """Return an angle by the number of whole turns that brings it nearest."""
    return degrees + 360.0 * round((near - degrees) / 360.0)


def _less(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _turn(vector: Vector, column: int, degrees: float) -> Vector:
    """Turn a vector about X, Y or Z (columns 3, 4, 5)."""
    if isinstance(degrees, float | int):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    else:
        import numpy as np

        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    first, second = _PLANES[column - _A]
    out = list(vector)
    out[first], out[second] = c * vector[first] - s * vector[second], s * vector[first] + c * vector[second]
    return out[0], out[1], out[2]


def _beside_axis(vector: Vector, column: int) -> float:
    """Return the square of the distance from X, Y or Z (columns 3, 4, 5)."""
    first, second = _PLANES[column - _A]
    return vector[first] * vector[first] + vector[second] * vector[second]


def mechanism_of(machine: Machine) -> Kinematics | None:
    """Return how the rotary axes of a machine carry table or head; None where it does not say.

    Raises:
        UsageError: See `kinematics_of`.
    """
    table = machine.settings.get("kinematics")
    return None if table is None else kinematics_of(table)


def kinematics_of(table: Mapping[str, Any]) -> Kinematics:
    """Read the table ``[kinematics]`` of a machine.

    Raises:
        UsageError: All that is wrong with it, by key.
    """
    check("kinematics", table)
    first, second = (3 + "abc".index(str(letter).lower()) for letter in table["axes"])
    x, y, z = (float(value) for value in table.get("centre_mm", (0.0, 0.0, 0.0)))
    return Kinematics(
        KINEMATICS[table["model"]],
        (first, second),
        (x, y, z),
        float(table.get("pivot_mm", 0.0)),
        float(table.get("tolerance_mm", _TOLERANCE_MM)),
    )
