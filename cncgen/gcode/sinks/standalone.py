"""The imaginary machine of LinuxCNC's ``rs274 -g``, for calls that agree with its own.

`rs274` runs the interpreter without a machine, on an imaginary one whose answers enter the calls that follow: where
it stands after a tool change or a probe, which tool its spindle holds, and the tools of its table. `canon` prints the
calls of a run on this machine; a toolpath is read without it. Its behaviour was measured on `rs274` 2.9 (programs under
``tests/peer``):

- lengths in the tool table and in the parameter file are inches;
- where no table is given it has the tools of `rs274`'s manual page;
- it follows motions and changes of origin, turns nothing by the rotation of a coordinate system and knows no tool
  offset, and the interpreter takes its position at the end of a block with M6 and after a probe;
- calls are nested nine deep at most;
- a probe trips 0.01 inch before the programmed point;
- a tool offset in force keeps its number when the units change;
- T0 M6 and M61 leave the tool in its spindle as it was.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from cncgen.gcode.block import Block
from cncgen.gcode.budget import Budget
from cncgen.gcode.sinks.printing import PrintingSink
from cncgen.gcode.sinks.sink import Curve, Point, Sink
from cncgen.gcode.state.modal import LENGTHS, zeros
from cncgen.toolpath.record import Event
from cncgen.units import INCH

CALL_LEVELS = 9
#: How far before the programmed point the probe trips (mm and inch).
_SHORT = {False: 0.01 * INCH, True: 0.01}


class StandAloneSink(PrintingSink):
    """Prints the calls, and knows where the make-believe machine stands, in its own program coordinates."""

    def __init__(self, text_at: Callable[[int, int], str]) -> None:
        super().__init__(text_at)
        self._position = zeros()
        self._origin = zeros()
        self._g92 = zeros()
        self._inches = False
        self._stopped = False
        #: The sink that the interpreter calls: this one, or one before it that holds calls back.
        self.outermost: Callable[[], Sink] = lambda: self

    def _numbered_by(self) -> Block:
        """Return the block that is executed: the peer prints its N word with calls that waited for it, too."""
        return self.outermost().block

    def stop(self) -> None:
        """Print nothing more: the peer ends at the first error, while the other errors are still looked for."""
        self._stopped = True

    def call(self, text: str, event: Event | None = None) -> None:
        """Print a call, before the first error."""
        if not self._stopped:
            super().call(text, event)

    def reset(self, count: int) -> None:
        """Print that the interpreter is reset, as at the end of every run."""
        self._stopped = False
        self.outermost = lambda: self
        self.budget = Budget()  # the work of the run is done
        self.block = Block({})  # no line's
        for _ in range(count):
            self.call("ON_RESET()")

    def where(self, position: Point) -> Point:
        return self._position.copy()

    def _motion(self, text: str, end: Point) -> None:
        """Print and go there."""
        super()._motion(text, end)
        self._position = list(end)

    def nurbs_feed(self, curve: Curve) -> None:
        super().nurbs_feed(curve)
        self._position = list(curve.points[-1])

    def straight_probe(self, end: Point) -> None:
        """Print, and touch something shortly before the end."""
        super().straight_probe(end)
        start, self._position = self._position, list(end)
        length = math.dist(start[:3], end[:3])
        if length > 0.0:
            back = _SHORT[self._inches] / length
            for axis in range(3):
                self._position[axis] -= back * (end[axis] - start[axis])

    def use_length_units(self, inches: bool) -> None:
        super().use_length_units(inches)
        if inches != self._inches:
            self._inches = inches
            factor = 1.0 / INCH if inches else INCH
            for vector in (self._position, self._origin, self._g92):
                vector[:] = [value * (factor if k in LENGTHS else 1.0) for k, value in enumerate(vector)]

    def set_g5x_offset(self, system: int, offset: Point) -> None:
        super().set_g5x_offset(system, offset)
        self._shift(self._origin, offset)
        self._origin = list(offset)

    def set_g92_offset(self, offset: Point) -> None:
        super().set_g92_offset(offset)
        self._shift(self._g92, offset)
        self._g92 = list(offset)

    def _shift(self, before: Point, after: Point) -> None:
        """Keep the machine where it is while an offset changes (the peer does not turn it)."""
        self._position = [p + b - a for p, b, a in zip(self._position, before, after, strict=True)]
