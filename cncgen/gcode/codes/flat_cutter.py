"""The moves of a cutter in XY and Z that milling cycles of all languages are made of."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cncgen.gcode.codes.turning_profiles import Segment
    from cncgen.gcode.interpreter import Interpreter


class FlatCutter:
    """The tool; places may be seen from an origin, in a direction."""

    #: A feed from which on it goes as fast as it can.
    fastest = math.inf
    _fast = False

    def __init__(self, ip: Interpreter, origin: complex = 0j, turn: complex = 1.0 + 0j) -> None:
        self.ip, self.origin, self.turn = ip, origin, turn

    def place(self) -> complex:
        """Return where the tool is, as the machine sees it."""
        return complex(*self.ip.state.position[:2])

    def to(self, place: complex | None = None, z: float | None = None, *, rapid: bool = False) -> None:
        """Go to a place, or a height, or both, unless the tool is there."""
        end = self._end(place, z)
        if end != self.ip.state.position:
            self.straight(end, rapid=rapid)

    def straight(self, end: list[float], *, rapid: bool) -> None:
        """Go to an end point."""
        self.ip.go(end, rapid=rapid or self._fast)

    def feed(self, feed: float) -> None:
        """Take a feed."""
        self._fast = feed >= self.fastest
        if not self._fast:
            self.ip.sink.set_feed_rate(feed)

    def plunge(self, level: float, plunge: float, feed: float) -> None:
        """Go to a height at one feed, and take another one there."""
        self.feed(plunge)
        self.to(z=level)
        self.feed(feed)

    def rise(self, z: float, feed: float) -> None:
        """Go up to a height at a feed, or in a traverse where that is infinite."""
        if z > self.ip.state.position[2] and feed < math.inf:
            self.feed(feed)
        self.to(z=z, rapid=feed == math.inf)

    def arc(self, place: complex, centre: complex, turns: int, z: float | None = None) -> None:
        """Go to a place on an arc or a helix, counter-clockwise where `turns` is above 0."""
        end, middle = self._end(place, z), self.origin + centre * self.turn
        self.ip.sink.arc_feed(end, middle.real, middle.imag, turns, 17)
        self.ip.state.position, self.ip.state.moved = end, True

    def follow(self, segment: Segment) -> None:
        """Feed along a segment."""
        if segment.centre is None:
            self.to(segment.end)
        else:
            self.arc(segment.end, segment.centre, segment.spin)

    def _end(self, place: complex | None, z: float | None) -> list[float]:
        end = self.ip.state.position.copy()
        if place is not None:
            at = self.origin + place * self.turn
            end[0], end[1] = at.real, at.imag
        if z is not None:
            end[2] = z
        return end
