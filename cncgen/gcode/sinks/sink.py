"""The interface that the interpreter calls: the canonical machining functions of NISTIR 6556, as a protocol.

Positions are lists of nine numbers, X Y Z A B C U V W, in the program's units and coordinates; offsets are calls of
their own. A sink either prints the calls (`printing`) or builds a toolpath in machine coordinates (`columns`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from cncgen.gcode.block import Block
from cncgen.gcode.budget import Budget
from cncgen.gcode.errors import BlockError
from cncgen.records import dataclass, replace
from cncgen.toolpath.record import Event, PathMode

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Protocol
else:
    Protocol = object

Point = list[float]

#: Radius below which a surface speed (G96) without a limit asks for no more revolutions.
LEAST_RADIUS_MM = 0.01
#: Start and end of an arc closer than this in the plane, mm: whole turns. The rounding of coordinates is less.
FULL_CIRCLE_MM = 1e-9
#: Tolerances of arcs for mm and inch programs, as LinuxCNC's interpreter has them (measured on it).
#: Half a chord may exceed R by this, and no radius may be shorter.
RADIUS_TOLERANCE = {False: 0.00127, True: 0.00005}
#: The radii at start and end of an arc by centre may differ by this …
CENTRE_TOLERANCE = {False: 0.02 * math.sqrt(2.0), True: 0.002 * math.sqrt(2.0)}
#: … or by this part of the larger one …
CENTRE_RELATIVE = 0.001
#: … but never by more than this many times the tolerance.
CENTRE_FACTOR = 100.0


@dataclass(frozen=True, slots=True)
class MotionBatch:
    """Motions in columns, a row a motion, as `cncgen.kernels.gcode_motion.Advance` gives them.

    The columns are buffers that the next batch uses again: whoever keeps them, copies them.

    Attributes:
        motion: Shape (n,), int8, 0 traverse, 1 feed, 2 and 3 arcs.
        end: Shape (n, 9), double.
        feed: Shape (n,), double, the feed rate in force.
        feed_set: Shape (n,), uint8, whether the block gave it.
        centre: Shape (n, 2), double, of arcs, in the two axes of the plane.
        turns: Shape (n,), int64, of arcs: signed number of turns begun, positive counter-clockwise.
        line, offset: Shape (n,), int64, line number and byte offset of the block in its source.
        source: Index of the source.
        reach: No coordinate of an end or centre is larger, of either sign.
        turn: No way of A, B or C is longer, from where they stood before.
        creeps: Whether a line turns an axis while X Y Z (else U V W) move by less than a millionth of that.
    """

    motion: memoryview
    end: memoryview
    feed: memoryview
    feed_set: memoryview
    centre: memoryview
    turns: memoryview
    line: memoryview
    offset: memoryview
    source: int
    reach: float
    turn: float
    creeps: bool

    def part(self, begin: int, end: int) -> MotionBatch:
        """Return some of the rows. The bounds are those of all rows."""
        return replace(self, **{name: getattr(self, name)[begin:end] for name in _COLUMNS})


#: The columns of a `MotionBatch`.
_COLUMNS = ("motion", "end", "feed", "feed_set", "centre", "turns", "line", "offset")


def refuse_uvw(plane: int) -> None:
    """Raise for an arc in a plane of U V W, of which no toolpath is made: its arcs lie in X Y Z."""
    if plane not in (17, 18, 19):
        name = f"G{plane / 10:g}"
        hint = "write the arc as short lines G1 along U V W, or in the planes of X Y Z"
        raise BlockError("arc-plane", f"arcs in the plane of {name} are not planned", name, hint=hint)


@dataclass(frozen=True, slots=True)
class Curve:
    """A rational B-spline in program coordinates: `points` are positions, the first is where the motion starts.

    `rate` (1/min) is how often a minute the motion could be made, in inverse time mode; None in the other modes.
    """

    degree: int
    points: Sequence[Sequence[float]]
    weights: Sequence[float]
    knots: Sequence[float]
    rate: float | None = None


class Sink(Protocol):
    """Receives canonical calls; `block` is the block that they come from. Sinks say of a call only what is their own."""

    block: Block
    #: Counts the work of the run; its interpreter sets it.
    budget: Budget
    #: Whether comments that do nothing are wanted (a toolpath has no use for them).
    wants_comments: bool

    def motions(self, batch: MotionBatch) -> None:
        """Take a run of plain motions."""

    def straight_traverse(self, end: Point) -> None:
        """Move to `end` as fast as the machine can."""

    def straight_feed(self, end: Point) -> None:
        """Move to `end` in a straight line at the feed rate."""

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        """Move on an arc or helix about (first, second) of the plane's axes; `turns` positive counter-clockwise."""

    def straight_probe(self, end: Point) -> None:
        """Move to `end` at the feed rate, looking for contact."""

    def rigid_tap(self, end: Point, pitch: float) -> None:
        """Move to `end` and back in step with the spindle, `pitch` a revolution."""

    def synchronise(self, pitch: float | None) -> None:
        """Feed in step with the spindle, `pitch` a revolution, or no longer (None). Prints nothing."""

    def nurbs_feed(self, curve: Curve) -> None:
        """Move along a rational B-spline."""

    def use_length_units(self, inches: bool) -> None:
        """Take lengths in inches or millimetres from now on."""

    def select_plane(self, plane: int) -> None:
        """Set the plane of arcs: 17, 18 or 19 (171, 181, 191: the planes of U V W)."""

    def set_feed_rate(self, rate: float) -> None:
        """Set the feed rate: units/min, 1/min or units/rev by the feed mode."""

    def set_inverse_time(self, rate: float, length: float) -> None:
        """Set the rate (1/min) of the next motion, of that length, in inverse time mode."""

    def set_feed_mode(self, mode: int, synched: bool) -> None:
        """Set the meaning of the feed rate: 93, 94 or 95."""

    def set_spindle(self, speed: float, direction: int) -> None:
        """Tell the speed (rev/min) and direction in force; feeds per revolution depend on them. Prints nothing."""

    def set_surface_speed(self, limit: float | None) -> None:
        """Take spindle speeds as m/min (ft/min) at X, at most `limit` rev/min; None: as rev/min. Prints nothing."""

    def set_motion_control_mode(self, mode: PathMode, tolerance: float | None, naive: float | None) -> None:
        """Set how close the motion stays to the path; `tolerance` in length units, None where not given."""

    def set_lever(self, lever: float) -> None:
        """Tell how far the tip goes as rotary axes turn that carry it, in length units a radian (`Toolpath.lever`). Prints nothing."""

    def set_g5x_offset(self, system: int, offset: Point) -> None:
        """Set the origin of the work coordinate system (1 to 9)."""

    def set_g92_offset(self, offset: Point) -> None:
        """Set the offset on top of the work coordinate system."""

    def set_xy_rotation(self, degrees: float) -> None:
        """Turn the work coordinate system about Z."""

    def use_tool_length_offset(self, offset: Point) -> None:
        """Set the tool's offset."""

    def where(self, position: Point) -> Point:
        """Return where the machine says it stands after a tool change or a probe; `position` is where it should."""

    def place(self, position: Point) -> None:
        """Take `position` (program coordinates) as where the machine stands, without motion."""

    def call(self, text: str, event: Event | None = None) -> None:
        """Take any other call: its text, and the event that it means to a machine."""


class PassingSink:
    """A sink that stands before another one for a while and passes on the calls that its subclass does not take."""

    def __init__(self, inner: Sink) -> None:
        self.inner = inner
        self.wants_comments = inner.wants_comments

    @property
    def block(self) -> Block:
        """The block that calls come from."""
        return self.inner.block

    @block.setter
    def block(self, block: Block) -> None:
        self.inner.block = block
        self._check(block)

    def _check(self, block: Block) -> None:
        """Refuse a block that does not go with the sink."""

    @property
    def takes_batches(self) -> bool:
        """Whether runs of motions may come (`motions`)."""
        return False

    def motions(self, batch: MotionBatch) -> None:
        """Refuse: runs of motions are not made meanwhile (`Interpreter.batchable`)."""
        raise RuntimeError(f"a batch of motions went to a {type(self).__name__}")

    def __getattr__(self, name: str) -> Any:
        return getattr(self.inner, name)


class TryingSink(PassingSink):
    """A sink of a block that is only tried: it forgets the calls that its subclass does not take, and has the values of `inner`."""

    def __getattr__(self, name: str) -> Any:
        value = getattr(self.inner, name)
        return (lambda *arguments, **named: None) if callable(value) else value
