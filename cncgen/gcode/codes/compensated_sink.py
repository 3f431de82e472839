"""The sink of cutter radius compensation.

While that is on, this sink stands before the sink of the run: it sends motions through `tool_centre.ToolCentre` and holds
every other call back behind the motions that wait, so that calls come out in the order of the program. Codes that cannot be used with
it are refused in their block, with the words of LinuxCNC's manual ("G41, G42").
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from cncgen.diagnostics import Severity
from cncgen.gcode.block import AXES, Block
from cncgen.gcode.budget import MOTION
from cncgen.gcode.codes.table import COMPENSATION, COMPENSATION_PLANE, INTERRUPTS, STRICT_COMPENSATION, Codes
from cncgen.gcode.codes.tool_centre import CentreMove, CompensationError, ToolCentre
from cncgen.gcode.errors import BlockError
from cncgen.gcode.sinks.sink import Curve, PassingSink, Point, Sink
from cncgen.gcode.state.modal import PLANE_AXES, in_plane, swept
from cncgen.records import dataclass
from cncgen.toolpath.record import Event
from cncgen.units import INCH

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


@dataclass(slots=True)
class _Call:
    """A waiting call: its block, and the action."""

    block: Block
    run: Callable[[], None]


@dataclass(slots=True)
class _Move:
    """The companion of a piece of the tool centre's path: its block, the programmed end on all axes, an arc's radius."""

    block: Block
    end: Point
    plane: int
    feed: bool
    radius: float = 0.0


class CompensatedSink(PassingSink):
    """The sink while compensation is on: moves are offset, other calls wait their turn.

    Args:
        inner: The sink of the run.
        centre: The geometry.
        plane: Plane in which the tool is offset.
        start: Where the tool stands, program coordinates.
        inches: Whether program units are inches.
        codes: The rows of the dialect's codes, which say what is refused meanwhile.
        warn: Takes a gouge that the tool path makes and that LinuxCNC does not refuse.
        tool_offset: The tool's offset in force; None where it cannot change meanwhile.
        lenient: Whether blocks are refused as FANUC's controls do, not as LinuxCNC does.
        on_roll: Called before each arc around an outside corner.
        on_arc: Called where the entry is an arc.
        on_interrupt: Ends compensation for a block, with the name of a code and what it does; None where such codes are refused.
        contour_feed: On which arcs F is the feed along the contour: ``all``, ``inside``, or none (empty).
        feed: F as compensation begins.
    """

    def __init__(
        self,
        inner: Sink,
        centre: ToolCentre,
        plane: int,
        start: Point,
        inches: bool,
        codes: Codes,
        warn: Callable[[BlockError, Severity], None],
        *,
        tool_offset: Point | None = None,
        lenient: bool = False,
        on_roll: Callable[[], None] | None = None,
        on_arc: Callable[[], None] | None = None,
        on_interrupt: Callable[[Block, str, str], None] | None = None,
        contour_feed: str = "",
        feed: float = 0.0,
    ) -> None:
        super().__init__(inner)
        self.budget = inner.budget
        self._codes, self._lenient = codes, lenient
        self._on_roll, self._on_arc, self._on_interrupt = on_roll, on_arc, on_interrupt
        self._offset = tool_offset
        self.centre = centre
        self.plane = plane
        self._first, self._second, _ = PLANE_AXES[plane]
        self._last = list(start)
        self._warn = warn
        self._inches = inches
        self._speed: float | None = None
        self._arcs, self._feed = contour_feed, feed
        self._block = inner.block
        #: Whether G41 is in force, and not G42: a negative radius has the tool on the other side.
        self.left = centre.side > 0

    @property
    def block(self) -> Block:
        """Return the block that calls come from."""
        return self._block

    @block.setter
    def block(self, block: Block) -> None:
        self._block = self.inner.block = block
        refused = _refused(block, self._codes, self.plane, lenient=self._lenient)
        if refused is None:
            return
        name, what, interrupts = refused
        if self._on_interrupt is not None and interrupts:
            self._on_interrupt(block, name, what)
            return
        message = f"{name} {what}, and cutter compensation is on"
        raise BlockError("comp-refused", message, name, hint="turn it off before (G40 and a straight move)")

    def snapshot(self) -> tuple[Any, ...] | None:
        """Return a key of this state, or None if waiting blocks cannot be compared."""
        centre = self.centre.snapshot()
        return None if centre is None else (self.plane, self._last, self._inches, self._speed, centre)

    def beside(self, programmed: Point) -> Point:
        """Return the programmed position with the tool's centre, as far as its moves are known, in the plane."""
        return self._placed(programmed, self.centre.position)

    # Motions.

    def straight_traverse(self, end: Point) -> None:
        self._line(end, rapid=True)

    def straight_feed(self, end: Point) -> None:
        self._line(end, rapid=False)

    def _line(self, end: Point, rapid: bool) -> None:
        move = _Move(self._block, list(end), self.plane, not rapid)
        self._take(lambda: self.centre.line(in_plane(end, self.plane), move, rapid))

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        if self._on_arc is not None and self.centre.begins:
            self._on_arc()
        centre = complex(first, second)
        move = _Move(self._block, list(end), plane, True, abs(in_plane(end, self.plane) - centre))
        self._take(lambda: self.centre.arc(in_plane(end, self.plane), centre, turns, move))

    def nurbs_feed(self, curve: Curve) -> None:
        raise BlockError("comp-refused", "a spline cannot be offset by cutter compensation")

    def straight_probe(self, end: Point) -> None:
        raise BlockError("comp-refused", "no probing under cutter compensation")

    def rigid_tap(self, end: Point, pitch: float) -> None:
        raise BlockError("comp-refused", "no tapping under cutter compensation")

    def _placed(self, axes: Point, point: complex) -> Point:
        """Return a position with its plane coordinates put in."""
        out = list(axes)
        out[self._first], out[self._second] = point.real, point.imag
        return out

    def _take(self, move: Callable[[], list[CentreMove | _Call]]) -> None:
        """Feed the geometry and pass on the settled moves, after the remarks on a move that waited."""
        self.budget.spend(MOTION)
        waits = self.centre.last_waiting()
        where = f" (the move of line {waits.block.block.line})" if waits else ""
        settled = _or_fault(move)
        for remark in self.centre.take_remarks():
            fault = BlockError(remark.code, f"{remark}{where}", hint=remark.hint, values=remark.values)
            self._warn(fault, Severity.ERROR if remark.refused else Severity.WARNING)
        self._pass_on(settled)

    def _pass_on(self, settled: list[CentreMove | _Call]) -> None:
        inner, now = self.inner, self._block
        for item in settled:
            if isinstance(item, CentreMove):
                inner.block = item.block.block
                self._move(item, item.block)
            else:
                inner.block = item.block
                item.run()
        inner.block = now

    def _move(self, piece: CentreMove, move: _Move) -> None:
        """Call the sink of the run for a piece; around a corner the axes outside the plane stand still."""
        end = self._placed(self._last if piece.corner else move.end, piece.end)
        if self._speed is not None and not piece.rapid and not self.wants_comments:
            length = self._length(piece, end)
            self.inner.set_inverse_time(self._speed / length if length else 0.0, length)
        self._last = end
        if piece.centre is not None:
            if piece.corner and self._on_roll is not None:
                self._on_roll()
            factor = self._factor(piece, move)
            if factor != 1.0:
                self.inner.set_feed_rate(self._feed * factor)
            self.inner.arc_feed(end, piece.centre.real, piece.centre.imag, piece.turns, move.plane)
            if factor != 1.0:
                self.inner.set_feed_rate(self._feed)
        elif piece.rapid:
            self.inner.straight_traverse(end)
        else:
            self.inner.straight_feed(end)

    def _factor(self, piece: CentreMove, move: _Move) -> float:
        """Return how much faster than F the tool's centre goes where F is the feed along the contour: its radius by the contour's."""
        if (
            not self._arcs
            or piece.corner
            or not move.radius
            or piece.centre is None
            or self._speed is not None
        ):
            return 1.0
        factor = abs(piece.end - piece.centre) / move.radius
        return min(factor, 1.0) if self._arcs == "inside" else factor

    def _length(self, piece: CentreMove, end: Point) -> float:
        """Return the length of a piece from where the tool stands, in X Y Z, else of the rotary part."""
        across = math.dist(self._last[:3], end[:3])
        if piece.centre is not None:
            start = in_plane(self._last, self.plane) - piece.centre
            _, sweep = swept(start, piece.end - piece.centre, piece.turns)
            normal = PLANE_AXES[self.plane][2]
            across = math.hypot(abs(start) * sweep, end[normal] - self._last[normal])
        return across or math.dist(self._last[3:6], end[3:6])

    def finish(self) -> None:
        """Pass on all that waits."""
        self._take(self.centre.finish)

    def leave_towards(self, way: complex) -> None:
        """Pass on all that waits; the last move ends as if a line followed it in a direction."""
        self._take(lambda: self.centre.leave_towards(way))

    # Other calls wait behind the motions that wait.

    def __getattr__(self, name: str) -> Any:
        if not hasattr(Sink, name):
            # Frames beneath are not its own.
            raise AttributeError(name)
        self.__dict__[name] = lambda *arguments, **named: self._defer(
            partial(getattr(self.inner, name), *arguments, **named)
        )
        return self.__dict__[name]

    def _defer(self, run: Callable[[], None]) -> None:
        call = _Call(self._block, run)
        self._pass_on(_or_fault(lambda: self.centre.defer(call)))

    def use_length_units(self, inches: bool) -> None:
        """Change units: waiting moves are then passed on in the new ones."""
        self.inner.use_length_units(inches)
        if inches == self._inches:
            return
        self._inches = inches
        factor = 1.0 / INCH if inches else INCH
        self.centre.rescale(factor, "inch" if inches else "mm")
        waiting = [item.block for item in self.centre.waiting() if isinstance(item.block, _Move)]
        for point in (self._last, *(move.end for move in waiting)):
            point[:] = [v if 3 <= k <= 5 else v * factor for k, v in enumerate(point)]
        for move in waiting:
            move.radius *= factor

    def set_inverse_time(self, rate: float, length: float) -> None:
        """Take the speed that it means for the programmed move: all pieces of the move go at it, as in LinuxCNC."""
        self._defer(partial(setattr, self, "_speed", rate * length))
        self._defer(partial(self.inner.set_inverse_time, rate, length))

    def set_feed_rate(self, rate: float) -> None:
        """Pass on, and keep it for arcs."""
        self._defer(partial(setattr, self, "_feed", rate))
        self._defer(partial(self.inner.set_feed_rate, rate))

    def feed_along_contour(self, arcs: str) -> None:
        """Take on which arcs F is the feed along the contour, behind the moves that wait."""
        self._defer(partial(setattr, self, "_arcs", arcs))

    def set_feed_mode(self, mode: int, synched: bool) -> None:
        self._defer(partial(setattr, self, "_speed", None))
        self._defer(partial(self.inner.set_feed_mode, mode, synched))

    def set_g5x_offset(self, system: int, offset: Point) -> None:
        """Refuse to move the coordinate system."""
        message = "the coordinate system in force cannot change while cutter compensation is on"
        raise BlockError("comp-refused", message, "G10", hint="turn it off before (G40 and a straight move)")

    def use_tool_length_offset(self, offset: Point) -> None:
        """Pass on; coordinates of where the tool stands change by as much."""

        def run() -> None:
            self.inner.use_tool_length_offset(offset)
            if self._offset is not None:
                self._last = [p - n + o for p, n, o in zip(self._last, offset, self._offset, strict=True)]
                self._offset = list(offset)

        self._defer(run)

    def where(self, position: Point) -> Point:
        """Return `position`: nothing that asks goes with compensation."""
        return position

    def call(self, text: str, event: Event | None = None) -> None:
        """Pass on; messages and logs do not wait."""
        if text.startswith("MESSAGE(") or (event is not None and event.name in ("message", "log")):
            self.inner.call(text, event)
        else:
            self._defer(lambda: self.inner.call(text, event))


def _or_fault(step: Callable[[], list[CentreMove | _Call]]) -> list[CentreMove | _Call]:
    """Return the results of the geometry in a step; raise its fault as that of the block."""
    try:
        return step()
    except CompensationError as error:
        raise BlockError(error.code, str(error), hint=error.hint, values=error.values) from None


def _refused(block: Block, codes: Codes, plane: int, *, lenient: bool) -> tuple[str, str, bool] | None:
    """Return the code of a block that is not allowed while compensation is on, what it does, and whether it may interrupt it."""
    rows = codes.of(block)
    if not rows:
        return None
    beside = AXES[PLANE_AXES[plane][2]]
    refuses = COMPENSATION
    if not lenient:
        refuses |= STRICT_COMPENSATION | COMPENSATION_PLANE
    elif block.words.keys() & (set("xyz") - {beside}):
        refuses |= COMPENSATION_PLANE
    for code in rows:
        what, under = code.refused
        if under & refuses:
            return code.name, what, bool(under & INTERRUPTS)
        if code.plane not in (0, plane):
            return code.name, "changes the plane", False
    return None
