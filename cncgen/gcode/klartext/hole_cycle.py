"""The common part of most cycles of Heidenhain's plain language: heights, feeds and the way to them, at the tool's place."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableSequence
from contextlib import contextmanager

from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.steps import steps_of
from cncgen.gcode.errors import refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.toolpath.record import Event

Z = 2
#: A feed that cycles are given as MAX, or above which they mean it, mm a minute.
FASTEST = 99_999.0


@contextmanager
def lent(q: MutableSequence[float], values: Mapping[int, float]) -> Iterator[None]:
    """Let Q parameters have other values meanwhile."""
    kept = {number: q[number] for number in values}
    try:
        for number, value in values.items():
            q[number] = value
        yield
    finally:
        for number, value in kept.items():
            q[number] = value


def infeeds(surface: float, bottom: float, step: float, name: str, word: str = "Q202") -> tuple[float, ...]:
    """Return the levels from a surface down, a step below each other, and the bottom; it alone where the step is 0; raise where they are too many."""
    makes, hint = f"{word} = {step:g} makes {{}} infeeds of {name}", f"{word} is the depth of one infeed"
    count = steps_of(surface - bottom, step, "CYCL", makes, hint)
    return (*(surface - k * step for k in range(1, count)), bottom)


def check_feeds(cycle: HoleCycle) -> None:
    """Raise where a milling cycle has no feed."""
    q = cycle.q
    message = f"{cycle.name} has no feed: Q207 = {q[207]:g}, Q206 = {q[206]:g}"
    refuse("CYCL", (min(q[206], q[207]) <= 0.0, "feed-missing", message, "Q207 mills, Q206 plunges"))


class HoleCycle(FlatCutter):
    """One run of a cycle where the tool is; `home` is where it goes at last, above the second clearance."""

    fastest = FASTEST
    home: complex | None = None

    def __init__(self, ip: Interpreter, name: str, levels: tuple[float, float] | None = None) -> None:
        """Take the surface and the depth, usually Q203 and Q201."""
        super().__init__(ip)
        self.name = name
        q = ip.parameters.numbers
        self.q = q
        surface, depth = levels or (q[203], q[201])
        self.start, self.bottom = surface + q[200], surface + depth
        self.back = max(self.start, surface + q[204])
        message = f"the depth of {name}, Q201 = {q[201]:g}, does not lead downwards"
        refuse("CYCL", (depth >= 0.0 and levels is None, "cycle-depth", message, "Q201 is below 0"))

    def infeeds(self, number: int, floor: float = 0.0) -> tuple[float, ...]:
        """Return the levels of Q202 or Q338 from the surface Q203 down to an allowance above the bottom."""
        q = self.q
        return infeeds(q[203], self.bottom + floor, abs(q[number]), self.name, f"Q{number}")

    def go(self, z: float, *, rapid: bool) -> None:
        """Go to a height."""
        self.to(z=z, rapid=rapid)

    def feed(self, feed: float, what: str = "") -> None:
        """Take a feed."""
        message = f"the feed of {self.name}, {what} = {feed:g}, is not above 0"
        refuse("CYCL", (feed <= 0.0, "feed-missing", message, f"{what} is mm a minute"))
        super().feed(feed)

    def begin(self) -> None:
        """Traverse to the set-up clearance, and take the feed downwards, Q206."""
        self.go(self.start, rapid=True)
        self.feed(self.q[206], "Q206")

    def drill(self) -> None:
        """Go from the set-up clearance to the bottom, and wait Q211."""
        self.begin()
        self.go(self.bottom, rapid=False)
        self.dwell(self.q[211])

    def out(self) -> None:
        """Go to the set-up clearance at Q208, where that is 0 at Q206."""
        self.feed(self.q[208] or self.q[206], "Q208")
        self.go(self.start, rapid=False)

    def down(self, at: float, depth: float, out: float | None = None) -> None:
        """Go from a depth down to another one, back by Q256, or out to a height, after each Q257 to break the chip."""
        q = self.q
        makes, hint = f"Q257 = {q[257]:g} makes {{}} chip breaks", "Q257 is the way to the next chip break"
        steps_of(at - depth, q[257], "CYCL", makes, hint)
        while q[257] > 0.0 and at - q[257] > depth:
            at -= q[257]
            self.go(at, rapid=False)
            self.go(at + abs(q[256]) if out is None else out, rapid=False)
        self.go(depth, rapid=False)

    def dwell(self, seconds: float) -> None:
        if seconds > 0.0:
            self.ip.sink.call(f"DWELL({seconds:.4f})", Event("dwell", True, seconds, {"seconds": seconds}))

    def end(self) -> None:
        """Go to the second clearance, with the program's feed in force again."""
        self.go(self.back, rapid=True)
        self.ip.sink.set_feed_rate(self.ip.state.feed)
        if self.home is not None:
            self.to(self.home, rapid=True)
