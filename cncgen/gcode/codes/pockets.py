"""Clearing a pocket with a flat cutter: loops beside the wall from the inside out, level by level.

The loops are our own choice, because manuals do not state them. The wall, the depths and the feeds are those of the cycle.
"""

from __future__ import annotations

import cmath
import math

from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.steps import MOST
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.records import dataclass

_TINY = 1e-9


@dataclass(frozen=True, slots=True)
class Pocket:
    """A rectangle with rounded corners in XY: centre, half length and half width, radius of the corners, angle in degrees."""

    centre: complex
    length: float
    width: float
    corner: float
    angle: float = 0.0

    def within(self, side: float) -> Pocket:
        """Return the pocket that leaves an allowance on this one's wall."""
        corner = max(self.corner - side, 0.0)
        return Pocket(self.centre, self.length - side, self.width - side, corner, self.angle)


@dataclass(frozen=True, slots=True)
class Clearing:
    """How a pocket is cleared: tool radius, step aside, levels in Z, heights, feeds, and the sense (1 counter-clockwise).

    A finished pocket has been cleared before: above the last level, the floor, the tool goes along the wall alone. `out` is the feed upwards
    along contours, infinite for a traverse.
    """

    radius: float
    step: float
    levels: tuple[float, ...]
    start: float
    feed: float
    plunge: float
    sense: int = 1
    finish: bool = False
    out: float = math.inf


def clear(ip: Interpreter, pocket: Pocket, how: Clearing, name: str) -> None:
    """Clear a pocket, and go back to the height of the start; raise where the tool does not fit, or steps aside by nothing."""
    narrow = min(pocket.length, pocket.width)
    refuse(
        name,
        (narrow < how.radius - _TINY, "cycle-tool", f"{name} is {2.0 * narrow:g} wide, and the tool has the diameter {2.0 * how.radius:g}",
         "take a smaller tool, whose diameter the tool table has"),
        (how.step <= 0.0, "cycle-tool", f"{name} steps aside by {how.step:g}: the tool has no radius", "--tool-table gives the diameter of the tool"),
    )  # fmt: skip
    PocketPath(ip, pocket, how).run(name)


class PocketPath(FlatCutter):
    """The moves of one pocket; places are relative to its centre, along its length."""

    def __init__(self, ip: Interpreter, pocket: Pocket, how: Clearing) -> None:
        super().__init__(ip, pocket.centre, cmath.rect(1.0, math.radians(pocket.angle)))
        self.pocket, self.how = pocket, how

    def run(self, name: str) -> None:
        offsets = self._offsets(name)
        for level in self.how.levels:
            self.to(self.begin(offsets[0]), rapid=True)
            self.down(level)
            for offset in offsets if not self.how.finish or level == self.how.levels[-1] else offsets[-1:]:
                self.loop(offset)
            self.to(self.begin(offsets[0]))
            self.to(z=self.how.start, rapid=True)

    def _half(self) -> tuple[float, float]:
        return self.pocket.length - self.how.radius, self.pocket.width - self.how.radius

    def _offsets(self, name: str) -> list[float]:
        """Return how far inside the last loop each one lies, the innermost first, so that the tool leaves nothing between them.

        Corners of loops that are not rounded lie farther apart than their sides, and the innermost loop has a middle of its own.
        """
        reach, step = min(self._half()), self.how.step
        if self.how.radius > 0.0:
            rounded = self.pocket.corner >= min(self.pocket.length, self.pocket.width) - _TINY
            step = min(step, (2.0 if rounded else math.sqrt(2.0)) * self.how.radius)
        count = math.floor(reach / step + _TINY)
        hint = f"at most {MOST} are made: is the step aside too small?"
        refuse(name, (count > MOST, "cycle-tool", f"{name} makes {count} loops", hint))
        inner = [reach] if reach - step * count > self.how.radius + _TINY else []
        return [*inner, *(step * k for k in range(count, -1, -1))]

    def begin(self, offset: float) -> complex:
        """Return where a loop begins: in the middle of the long side."""
        return complex(0.0, -(self._half()[1] - offset))

    def loop(self, offset: float, corner: int | None = None) -> None:
        """Go to where a loop begins, the middle of the long side or behind a corner, counter-clockwise from that side, and once around."""
        a, b = (half - offset for half in self._half())
        r = max(0.0, min(self.pocket.corner - self.how.radius - offset, a, b))
        if b < _TINY:
            for place in (self.begin(offset), complex(a, 0.0), complex(-a, 0.0), 0j):
                self.to(place)
            return
        side = float(self.how.sense)
        corners = [(complex(a - r, -b), complex(a, -b + r), complex(a - r, -b + r)), (complex(a, b - r), complex(a - r, b), complex(a - r, b - r)),
                   (complex(-a + r, b), complex(-a, b - r), complex(-a + r, b - r)), (complex(-a, -b + r), complex(-a + r, -b), complex(-a + r, -b + r))]  # fmt: skip
        if side < 0.0:
            corners = [(end, begin, centre) for begin, end, centre in reversed(corners)]
        start = self.begin(offset)
        if corner is not None:
            behind = (corner if side > 0.0 else 3 - corner) + 1
            corners = corners[behind:] + corners[:behind]
            start = corners[-1][1]
        self.to(start)
        for begin, end, centre in corners:
            self.to(begin)
            if r > _TINY:
                self.arc(end, centre, self.how.sense)
        self.to(start)

    def free(self, beside: complex, side: float, count: int, corner: int | None = None) -> None:
        """Mill what stands within the pocket free, whose tool has a radius below 0: at each level down beside the blank, loops in to `side`
        in front of the wall, from the middle of its long side or a corner, and back."""
        for level in self.how.levels:
            self.to(beside, rapid=True)
            self.down(level)
            for k in range(count - 1, -1, -1):
                self.loop(-(side + k * self.how.step), corner)
            self.to(beside)
            self.to(z=self.how.start, rapid=True)

    def down(self, level: float) -> None:
        """Go down to a level, and take the feed."""
        self.to(z=self.how.start, rapid=True)
        self.plunge(level, self.how.plunge, self.how.feed)


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
    steps = max(1, math.ceil(reach / min(how.step, 2.0 * how.radius) - _TINY)) if reach > _TINY else 0
    offsets = [reach * k / steps for k in range(1, steps + 1)] or [0.0]
    if offsets[0] > how.radius + _TINY:
        offsets.insert(0, 0.0)
    tool, begin = FlatCutter(ip), bow.place(bow.radius, bow.begin)
    tool.to(begin, rapid=True)
    tool.to(z=how.start, rapid=True)
    for level in how.levels:
        tool.plunge(level, how.plunge, how.feed)
        for offset in offsets:
            if offset >= _TINY:
                tool.to(bow.place(bow.radius + offset * how.sense, bow.begin))
            for place, centre, sense in bow.loop(offset, how.sense):
                tool.arc(place, centre, sense)
        tool.to(begin)
    tool.to(z=how.start, rapid=True)
