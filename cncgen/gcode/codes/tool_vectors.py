"""The tool's direction on the way between two directions: in their plane, in lines of the rotary axes (ORIVECT, PATHCTRL VECTOR)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from cncgen.machine.kinematics import Kinematics, Vector, unit_vector

#: How far lines of the axes may lead the tool off its plane, degrees.
_OFF_PLANE = 0.01
#: Lines of one block at most.
_MOST_LINES = 256


class VectorTurn:
    """The directions between two, in their plane, in even steps of the angle.

    Args:
        first: Positions of the rotary axes at the beginning, degrees.
        last: At the end.
    """

    def __init__(self, kinematics: Kinematics, first: tuple[float, float], last: tuple[float, float]) -> None:
        self._kinematics, self._first, self._last = kinematics, first, last
        self._a, self._b = kinematics.direction(first), kinematics.direction(last)
        self._angle = _between(self._a, self._b)

    def _direction(self, t: float) -> Vector:
        s = math.sin(self._angle)
        if s < 1e-9:
            return self._a
        p, q = math.sin((1.0 - t) * self._angle) / s, math.sin(t * self._angle) / s
        x, y, z = (p * a + q * b for a, b in zip(self._a, self._b, strict=True))
        return x, y, z

    def _parts(self, count: int) -> list[tuple[float, tuple[float, float]]]:
        """Return the ends of equal parts: place from 0 to 1, and positions of the axes."""
        found, near = [], self._first
        for k in range(1, count):
            near = self._kinematics.angles_of(self._direction(k / count), near) or near
            found.append((k / count, near))
        return [*found, (1.0, self._last)]

    def off(self, count: int) -> float:
        """Return how far so many lines of the axes lead the tool off, in the middle of the worst of them, degrees."""
        worst, t, before = 0.0, 0.0, self._first
        for end, angles in self._parts(count):
            middle = ((before[0] + angles[0]) / 2.0, (before[1] + angles[1]) / 2.0)
            worst = max(worst, _between(self._kinematics.direction(middle), self._direction((t + end) / 2.0)))
            t, before = end, angles
        return math.degrees(worst)

    def lines(self) -> int:
        """Return how many lines keep the tool in the plane."""
        count = 1
        while count < _MOST_LINES and self.off(count) > _OFF_PLANE:
            count *= 2
        return count

    def between(self, count: int, start: Sequence[float], end: Sequence[float]) -> Iterator[list[float]]:
        """Yield the ends of all lines but the last one: positions of the nine axes, in the program's coordinates, between two."""
        for t, angles in self._parts(count)[:-1]:
            point = [a + t * (b - a) for a, b in zip(start, end, strict=True)]
            for column, before, angle in zip(self._kinematics.axes, self._first, angles, strict=True):
                point[column] = start[column] + angle - before
            yield point


def _between(a: Vector, b: Vector) -> float:
    """Return the angle between two directions, rad."""
    p, q = unit_vector(a), unit_vector(b)
    apart = math.dist(p, q)
    return 2.0 * math.asin(min(1.0, apart / 2.0))
