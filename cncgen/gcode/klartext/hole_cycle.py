"""The common part of most cycles of Heidenhain's plain language: heights, feeds and the way to them, at the tool's place."""

from __future__ import annotations

import math

from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.toolpath.record import Event

Z = 2
#: A feed that cycles are given as MAX, or above which they mean it, mm a minute.
FASTEST = 99_999.0
#: Infeeds beyond which their depth counts as a mistake.
_MOST = 10_000


def infeeds(surface: float, bottom: float, step: float, name: str, word: str = "Q202") -> tuple[float, ...]:
    """Return the levels from a surface down, a step below each other, and the bottom; it alone where the step is 0.

    Raises:
        BlockError: They are too many.
    """
    count = max(1, math.ceil((surface - bottom) / step - 1e-9)) if step > 0.0 else 1
    if count > _MOST:
        message = f"{word} = {step:g} makes {count} infeeds of {name}"
        raise BlockError("cycle-infeed", message, "CYCL", hint=f"{word} is the depth of one infeed")
    return (*(surface - k * step for k in range(1, count)), bottom)


def check_feeds(cycle: HoleCycle) -> None:
    """Raise where a milling cycle has no feed."""
    q = cycle.q
    if min(q[206], q[207]) <= 0.0:
        message = f"{cycle.name} has no feed: Q207 = {q[207]:g}, Q206 = {q[206]:g}"
        raise BlockError("feed-missing", message, "CYCL", hint="Q207 mills, Q206 plunges")


class HoleCycle(FlatCutter):
    """One run of a cycle where the tool is."""

    fastest = FASTEST

    def __init__(self, ip: Interpreter, name: str, levels: tuple[float, float] | None = None) -> None:
        """Take the surface and the depth, usually Q203 and Q201."""
        super().__init__(ip)
        self.name = name
        q = ip.parameters.numbers
        self.q = q
        surface, depth = levels or (q[203], q[201])
        self.start, self.bottom = surface + q[200], surface + depth
        self.back = max(self.start, surface + q[204])
        if depth >= 0.0 and levels is None:
            raise BlockError(
                "cycle-depth",
                f"the depth of {name}, Q201 = {q[201]:g}, does not lead downwards",
                "CYCL",
                hint="Q201 is below 0",
            )

    def go(self, z: float, *, rapid: bool) -> None:
        """Go to a height."""
        self.to(z=z, rapid=rapid)

    def feed(self, feed: float, what: str = "") -> None:
        """Take a feed."""
        if feed <= 0.0:
            raise BlockError(
                "feed-missing",
                f"the feed of {self.name}, {what} = {feed:g}, is not above 0",
                "CYCL",
                hint=f"{what} is mm a minute",
            )
        super().feed(feed)

    def down(self, at: float, depth: float, out: float | None = None) -> None:
        """Go from a depth down to another one, back by Q256, or out to a height, after each Q257 to break the chip."""
        q = self.q
        if q[257] > 0.0 and (at - depth) / q[257] > _MOST:
            message = f"Q257 = {q[257]:g} makes more than {_MOST} chip breaks"
            raise BlockError("cycle-infeed", message, "CYCL", hint="Q257 is the way to the next chip break")
        while q[257] > 0.0 and at - q[257] > depth:
            at -= q[257]
            self.go(at, rapid=False)
            self.go(at + abs(q[256]) if out is None else out, rapid=False)
        self.go(depth, rapid=False)

    def dwell(self, seconds: float) -> None:
        """Wait."""
        if seconds > 0.0:
            self.ip.sink.call(f"DWELL({seconds:.4f})", Event("dwell", True, seconds, {"seconds": seconds}))

    def end(self) -> None:
        """Go to the second clearance, with the program's feed in force again."""
        self.go(self.back, rapid=True)
        self.ip.sink.set_feed_rate(self.ip.state.feed)
