"""Clearing a pocket with a flat cutter: loops beside the wall from the inside out, level by level.

The loops are our own choice, because manuals do not state them. The wall, the depths and the feeds are those of the cycle.
"""

from __future__ import annotations

import cmath
import math

from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.records import dataclass

#: Loops or levels beyond which a step counts as a mistake.
_MOST = 10_000
_TINY = 1e-9


@dataclass(frozen=True, slots=True)
class Pocket:
    """A rectangle with rounded corners in XY: centre, half length and half width, radius of the corners, angle in degrees."""

    centre: complex
    length: float
    width: float
    corner: float
    angle: float = 0.0


@dataclass(frozen=True, slots=True)
class Clearing:
    """How a pocket is cleared: tool radius, step aside, levels in Z, heights, feeds, and the sense (1 counter-clockwise).

    What is finished has been cleared: above the last level, the floor, the tool goes along the wall alone.
    """

    radius: float
    step: float
    levels: tuple[float, ...]
    start: float
    feed: float
    plunge: float
    sense: int = 1
    finish: bool = False


def levels_of(surface: float, depth: float, infeed: float, name: str) -> tuple[float, ...]:
    """Return the levels from a surface down to a depth, equal steps not deeper than an infeed."""
    way = surface - depth
    count = max(1, math.ceil(way / infeed - _TINY)) if infeed > 0.0 else 1
    if count > _MOST:
        raise BlockError(
            "cycle-infeed",
            f"an infeed of {infeed:g} makes {count} levels of {name}",
            name,
            hint=f"at most {_MOST} levels are made",
        )
    return tuple(surface - way * (k + 1) / count for k in range(count))


def clear(ip: Interpreter, pocket: Pocket, how: Clearing, name: str) -> None:
    """Clear a pocket, and go back to the height of the start.

    Raises:
        BlockError: The tool does not fit, or steps aside by nothing.
    """
    if min(pocket.length, pocket.width) < how.radius - _TINY:
        raise BlockError(
            "cycle-tool",
            f"{name} is {2.0 * min(pocket.length, pocket.width):g} wide, and the tool has the diameter {2.0 * how.radius:g}",
            name, hint="take a smaller tool, whose diameter the tool table has",
        )  # fmt: skip
    if how.step <= 0.0:
        raise BlockError(
            "cycle-tool",
            f"{name} steps aside by {how.step:g}: the tool has no radius",
            name,
            hint="--tool-table gives the diameter of the tool",
        )
    PocketPath(ip, pocket, how).run(name)


@dataclass(slots=True)
class PocketPath:
    """The moves of one pocket; places are relative to its centre, along its length."""

    ip: Interpreter
    pocket: Pocket
    how: Clearing

    def run(self, name: str) -> None:
        """Make all levels."""
        offsets = self._offsets(name)
        for level in self.how.levels:
            self.go(self.begin(offsets[0]), None, rapid=True)
            self.go(None, self.how.start, rapid=True)
            self._feed(self.how.plunge)
            self.go(None, level, rapid=False)
            self._feed(self.how.feed)
            for offset in offsets if not self.how.finish or level == self.how.levels[-1] else offsets[-1:]:
                self.go(self.begin(offset), None, rapid=False)
                self.loop(offset)
            self.go(self.begin(offsets[0]), None, rapid=False)
            self.go(None, self.how.start, rapid=True)

    def _half(self) -> tuple[float, float]:
        return self.pocket.length - self.how.radius, self.pocket.width - self.how.radius

    def _offsets(self, name: str) -> list[float]:
        """Return how far inside the last loop each one lies, the innermost first, so that the tool leaves nothing between them.

        Corners of loops that are not rounded lie farther apart than their sides, and the innermost loop has a middle of its own.
        """
        reach, step = min(self._half()), self.how.step
        if self.how.radius > 0.0 and self.pocket.corner < min(self.pocket.length, self.pocket.width) - _TINY:
            step = min(step, math.sqrt(2.0) * self.how.radius)
        count = math.floor(reach / step + _TINY)
        if count > _MOST:
            raise BlockError(
                "cycle-tool",
                f"{name} makes {count} loops",
                name,
                hint=f"at most {_MOST} are made: is the step aside too small?",
            )
        inner = [reach] if reach - step * count > self.how.radius + _TINY else []
        return [*inner, *(step * k for k in range(count, -1, -1))]

    def begin(self, offset: float) -> complex:
        """Return where a loop begins: in the middle of the long side."""
        return complex(0.0, -(self._half()[1] - offset))

    def loop(self, offset: float) -> None:
        """Go once around, from the middle of the long side."""
        a, b = (half - offset for half in self._half())
        r = max(0.0, min(self.pocket.corner - self.how.radius - offset, a, b))
        if b < _TINY:
            for place in (complex(a, 0.0), complex(-a, 0.0), 0j):
                self.go(place, None, rapid=False)
            return
        side = float(self.how.sense)
        corners = [(complex(a - r, -b), complex(a, -b + r), complex(a - r, -b + r)), (complex(a, b - r), complex(a - r, b), complex(a - r, b - r)),
                   (complex(-a + r, b), complex(-a, b - r), complex(-a + r, b - r)), (complex(-a, -b + r), complex(-a + r, -b), complex(-a + r, -b + r))]  # fmt: skip
        if side < 0.0:
            corners = [(end, begin, centre) for begin, end, centre in reversed(corners)]
        for begin, end, centre in corners:
            self.go(begin, None, rapid=False)
            if r > _TINY:
                self._arc(end, centre)
        self.go(complex(0.0, -b), None, rapid=False)

    def _placed(self, place: complex) -> complex:
        return self.pocket.centre + place * cmath.rect(1.0, math.radians(self.pocket.angle))

    def go(self, place: complex | None, z: float | None, *, rapid: bool) -> None:
        """Go to a place, or a height, or both."""
        end = self.ip.state.position.copy()
        if place is not None:
            at = self._placed(place)
            end[0], end[1] = at.real, at.imag
        if z is not None:
            end[2] = z
        if end == self.ip.state.position:
            return
        (self.ip.sink.straight_traverse if rapid else self.ip.sink.straight_feed)(end)
        self.ip.state.position, self.ip.state.moved = end, True

    def _arc(self, end: complex, centre: complex) -> None:
        finish = self.ip.state.position.copy()
        at, middle = self._placed(end), self._placed(centre)
        finish[0], finish[1] = at.real, at.imag
        if finish == self.ip.state.position:
            return
        self.ip.sink.arc_feed(finish, middle.real, middle.imag, self.how.sense, 17)
        self.ip.state.position = finish

    def _feed(self, feed: float) -> None:
        self.ip.sink.set_feed_rate(feed)


@dataclass(frozen=True, slots=True)
class Bow:
    """A slot along an arc: its middle line, from one angle (degrees) up to another, about a centre."""

    centre: complex
    radius: float
    begin: float
    end: float

    def place(self, radius: float, angle: float) -> complex:
        """Return a place at a distance from the centre."""
        return self.centre + cmath.rect(radius, math.radians(angle))

    def loop(self, offset: float, sense: int) -> list[tuple[complex, complex, int]]:
        """Return the arcs once around at a distance from the middle line: end, centre and sense of each, from the end where it begins."""
        if offset < _TINY:
            return [
                (self.place(self.radius, angle), self.centre, way)
                for angle, way in ((self.end, 1), (self.begin, -1))
            ]
        # Counter-clockwise: out along the greater radius, back along the smaller; clockwise the other way.
        first, second = self.radius + offset * sense, self.radius - offset * sense
        return [
            (self.place(first, self.end), self.centre, 1),
            (self.place(second, self.end), self.place(self.radius, self.end), sense),
            (self.place(second, self.begin), self.centre, -1),
            (self.place(first, self.begin), self.place(self.radius, self.begin), sense),
        ]


def clear_bow(ip: Interpreter, bow: Bow, half: float, how: Clearing, name: str) -> None:
    """Clear a slot of half a width along an arc, from the middle line out, and go back to the height of the start.

    Raises:
        BlockError: The tool does not fit.
    """
    reach = half - how.radius
    if how.radius <= 0.0 or reach < -_TINY or bow.radius < half:
        message = f"{name} is {2.0 * half:g} wide on a circle of {2.0 * bow.radius:g}, and the tool has the diameter {2.0 * how.radius:g}"
        raise BlockError("cycle-tool", message, name, hint="--tool-table gives the diameter of the tool")
    steps = max(1, math.ceil(reach / how.step - _TINY)) if reach > _TINY else 0
    offsets = [reach * k / steps for k in range(1, steps + 1)] or [0.0]
    if offsets[0] > how.radius + _TINY:
        offsets.insert(0, 0.0)
    path = PocketPath(ip, Pocket(0j, 0.0, 0.0, 0.0), how)
    begin = bow.place(bow.radius, bow.begin)
    path.go(begin, None, rapid=True)
    path.go(None, how.start, rapid=True)
    for level in how.levels:
        ip.sink.set_feed_rate(how.plunge)
        path.go(None, level, rapid=False)
        ip.sink.set_feed_rate(how.feed)
        for offset in offsets:
            if offset >= _TINY:
                path.go(bow.place(bow.radius + offset * how.sense, bow.begin), None, rapid=False)
            for place, centre, sense in bow.loop(offset, how.sense):
                end = [place.real, place.imag, *ip.state.position[2:]]
                ip.sink.arc_feed(end, centre.real, centre.imag, sense, 17)
                ip.state.position, ip.state.moved = end, True
        path.go(begin, None, rapid=False)
    path.go(None, how.start, rapid=True)
