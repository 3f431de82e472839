"""Motions of the part that a sink passes on as lines of the axes, as many as a tolerance needs: lines and arcs as paths."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator

from cncgen.gcode.block import Block
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Curve, PassingSink, Point, Sink
from cncgen.gcode.state.modal import PLANE_AXES, in_plane, swept
from cncgen.ranges import FEEDS

#: A point of the part by the place on a path, 0 to 1.
Path = Callable[[float], Point]
#: A path is looked at in steps of at most this turn of an arc or a rotary axis, degrees.
LOOK_DEGREES = 10.0
#: Steps of levers from one to its double, so that many motions have the same and are handed on together.
LEVER_STEPS = 32
#: The largest of inverse times (`cncgen.ranges.FEEDS`, which are by the second).
MOST_A_MINUTE = 60.0 * FEEDS[1]


class FollowedSink(PassingSink):
    """Passes straight lines and arcs of the part on in lines of the machine's axes; its subclass tells where these stand.

    Attributes:
        name: The code that is in force.
        fault, remedy: Code and help of the diagnostics of what is refused.
        under: The bit of `Code.refused` that says which codes are.
    """

    fault, remedy, under = "", "", 0

    def __init__(self, inner: Sink, ip: Interpreter, name: str) -> None:
        super().__init__(inner)
        self.ip, self.name = ip, name
        self._at = ip.state.position.copy()
        self._last_lever = 0.0
        self._rate = 0.0

    def _check(self, block: Block) -> None:
        for code in self.ip.codes.of(block):
            what, under = code.refused
            if under & self.under:
                self._refuse(f"{code.name} {what}: not", code.name)

    def _refuse(self, what: str, word: str = "") -> None:
        raise BlockError(self.fault, f"{what} under {self.name}", word, hint=self.remedy)

    def straight_feed(self, end: Point) -> None:
        """Move on a straight line of the part; one without a length would be a motion of the rounding of the axes."""
        start = self._at
        if end == start:
            return

        def path(t: float) -> Point:
            return [a + (b - a) * t for a, b in zip(start, end, strict=True)]

        self._follow(path, math.dist(start[:3], end[:3]), 0.0)
        self._at = list(end)

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        """Move on an arc or helix of the part."""
        a, b, normal = PLANE_AXES[plane]
        start, centre = self._at, complex(first, second)
        spoke, last = in_plane(start, plane) - centre, in_plane(end, plane) - centre
        sweep = math.prod(swept(spoke, last, turns))

        def path(t: float) -> Point:
            if t == 1.0:
                return list(end)
            point = [p + (q - p) * t for p, q in zip(start, end, strict=True)]
            place = centre + cmath.rect(
                abs(spoke) + (abs(last) - abs(spoke)) * t, cmath.phase(spoke) + sweep * t
            )
            point[a], point[b] = place.real, place.imag
            return point

        length = math.hypot(abs(spoke) * sweep, end[normal] - start[normal])
        self._follow(path, length, math.degrees(abs(sweep)))
        self._at = list(end)

    def shown(self, point: Point) -> Point:
        """Return the axes for a point of the part."""
        raise NotImplementedError

    def lever(self, point: Point) -> float:
        """Return how far the tip goes as the rotary axes turn, in length units a radian, at a point of the part."""
        raise NotImplementedError

    def _carry(self, point: Point) -> None:
        """Tell the lever of a line from the last point to this one, the longer of those of its ends."""
        before, self._last_lever = self._last_lever, self.lever(point)
        longer = max(before, self._last_lever)
        self.inner.set_lever(
            2.0 ** (math.ceil(LEVER_STEPS * math.log2(longer)) / LEVER_STEPS) if longer else 0.0
        )

    def _led(self, point: Point) -> Point:
        """Return the axes for a point of the part, and stand there."""
        self._at = list(point)
        return self.shown(point)

    def place(self, position: Point) -> None:
        self.inner.place(self._led(position))

    def straight_traverse(self, end: Point) -> None:
        """Traverse, each axis to its place."""
        self._last_lever = self.lever(self._at)
        self._carry(end)
        self.inner.straight_traverse(self._led(end))

    def _rate_of(self, path: Path, length: float) -> float:
        """Return how often a minute the motion could be made at F."""
        raise NotImplementedError

    def _pieces(self, path: Path, begin: Point, length: float, sweep: float) -> Iterator[tuple[float, Point]]:
        """Yield place on the path (0 to 1) and axes of the ends of lines; an arc has a sweep in degrees, else it is 0."""
        raise NotImplementedError

    def _follow(self, path: Path, length: float, sweep: float) -> None:
        """Pass a path of a length on in lines of the axes, each with its share of the time."""
        state = self.ip.state
        timed = state.feed_mode != 93
        rate = self._rate_of(path, length) if timed else self._rate
        if timed and rate:
            self.inner.set_feed_mode(93, synched=False)
        done, before = 0.0, self.shown(path(0.0))
        self._last_lever = self.lever(path(0.0))
        for t, point in self._pieces(path, before, length, sweep):
            self._carry(path(t))
            if rate:
                # Of a way of rounding alone, next to no time is left.
                share = min(rate / (t - done), MOST_A_MINUTE)
                self.inner.set_inverse_time(share, math.dist(point[:3], before[:3]))
            self.inner.straight_feed(point)
            done, before = t, point
        if timed and rate:
            self.inner.set_feed_mode(state.feed_mode, synched=False)
            self.inner.set_feed_rate(state.feed)

    def straight_probe(self, end: Point) -> None:
        self._refuse("no probing")

    def rigid_tap(self, end: Point, pitch: float) -> None:
        self._refuse("no tapping")

    def nurbs_feed(self, curve: Curve) -> None:
        self._refuse("no splines")

    def set_inverse_time(self, rate: float, length: float) -> None:
        """Keep the rate of the next motion (1/min)."""
        self._rate = rate
