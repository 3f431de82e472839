"""Cutter radius compensation: G40, G41, G42, G41.1, G42.1.

While it is on, a sink stands before the sink of the run: it sends motions through `tool_centre.ToolCentre` and holds
every other call back behind the motions that wait, so that calls come out in the order of the program. Codes that do
not go with it are refused in the block that has them, in the words of LinuxCNC's manual ("G41, G42").
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable

from cncgen.diagnostics import Severity
from cncgen.gcode.block import AXES, Block
from cncgen.gcode.budget import MOTION
from cncgen.gcode.codes.table import Code, Handler
from cncgen.gcode.codes.tool_centre import CentreMove, CompensationError, ToolCentre
from cncgen.gcode.codes.tools import tell_unknown, whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.sinks.sink import Curve, MotionBatch, Point, Sink
from cncgen.gcode.state.modal import PLAIN_MOTIONS, PLANE_AXES, PLANE_CODES, Stage
from cncgen.records import dataclass
from cncgen.toolpath.record import Event, PathMode
from cncgen.units import INCH

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from cncgen.gcode.interpreter import Interpreter

#: How much farther than programmed (rad) LinuxCNC lets a compensated arc sweep: measured on its interpreter, for tools
#: inside and outside of arcs, radii of 0.5 to 10 and sweeps of 0.1 to 1.5 rad.
_GROWTH = 0.001
#: Planes in which a dialect compensates.
PLANES = {"linuxcnc": (17, 18), "fanuc": (17, 18, 19), "heidenhain": (17, 18, 19), "sinumerik": (17, 18, 19)}
#: Dialects in which compensation is LinuxCNC's.
_STRICT = ("linuxcnc",)
ORIENTATIONS = 10
_LAST_DIGIT = 1e-12

#: Codes that no block may have while compensation is on, in tenths, and the reason.
_REFUSED_G = {
    **dict.fromkeys((280, 281, 300, 301), "goes by way of a reference point"),
    **dict.fromkeys((330, 331, 760), "is synchronised with the spindle"),
    **dict.fromkeys((382, 383, 384, 385), "probes"),
    **dict.fromkeys((410, 411, 420, 421), "begins cutter compensation"),
    **dict.fromkeys((430, 431, 432, 490), "changes the tool's offset"),
    # G5.2 and G6.2 refuse by themselves (`splines`, `nurbs`), and pass over the other blocks of their curve.
    **dict.fromkeys((50, 51), "is a spline"),
    **dict.fromkeys((520, 920), "changes the origin"),
    530: "moves in machine coordinates",
    **dict.fromkeys((540, 550, 560, 570, 580, 590, 591, 592, 593), "changes the coordinate system"),
    **dict.fromkeys((610, 611, 640), "changes the path mode"),
    **dict.fromkeys((710, 711, 712, 720, 721, 722), "is a roughing cycle"),
    **dict.fromkeys((730, 740, 810, 820, 830, 840, 850, 860, 870, 880, 890), "is a canned cycle"),
    **dict.fromkeys((980, 990), "changes how canned cycles retract"),
}
_REFUSED_M = {
    60: "changes the tool",
    **dict.fromkeys((480, 490, 500, 510, 520, 530), "changes an override"),
    **dict.fromkeys((620, 630, 640, 650, 670, 680), "sets an output"),
    660: "waits for an input",
}
#: Of those, what FANUC's controls do while compensation is on; G28 and G30 of the axis beside the plane alone.
_OF_FANUC = frozenset({410, 420, 430, 440, 490, 610, 640, 980, 990})
_HOMING = frozenset({280, 300})
#: Roughing cycles of FANUC's lathes, which end compensation themselves (`turning_cycles_fanuc`), and the plane of lathes.
_ROUGHING, _LATHES_PLANE = frozenset({710, 720, 730}), 18


@dataclass(slots=True)
class _Call:
    """A call that waits: of which block, and what to do then."""

    block: Block
    run: Callable[[], None]


@dataclass(slots=True)
class _Move:
    """The companion of a piece of the tool centre's path: its block and the programmed end on all axes."""

    block: Block
    end: Point
    plane: int
    feed: bool


class CompensatedSink:
    """The sink while compensation is on: moves are offset, other calls wait their turn.

    Args:
        inner: The sink of the run.
        centre: The geometry.
        plane: Plane in which the tool is offset.
        start: Where the tool stands, program coordinates.
        inches: Whether program units are inches.
        warn: Takes a gouge that the tool path makes and that LinuxCNC does not refuse.
        tool_offset: The tool's offset in force; None where it cannot change meanwhile.
        lenient: Whether blocks are refused as FANUC's controls do, not as LinuxCNC does.
    """

    def __init__(
        self,
        inner: Sink,
        centre: ToolCentre,
        plane: int,
        start: Point,
        inches: bool,
        warn: Callable[[BlockError, Severity], None],
        *,
        tool_offset: Point | None = None,
        lenient: bool = False,
    ) -> None:
        self.inner = inner
        self._lenient = lenient
        self._offset = tool_offset
        self.centre = centre
        self.budget = inner.budget
        self.wants_comments = inner.wants_comments
        self.plane = plane
        self._first, self._second, _ = PLANE_AXES[plane]
        self._last = list(start)
        self._warn = warn
        self._inches = inches
        self._speed: float | None = None
        self._block = inner.block

    @property
    def block(self) -> Block:
        """Return the block that calls come from."""
        return self._block

    @block.setter
    def block(self, block: Block) -> None:
        self._block = self.inner.block = block
        _refuse(block, self.plane, lenient=self._lenient)

    def snapshot(self) -> tuple[Any, ...] | None:
        """Return what tells this state from others, or None where blocks wait that cannot be compared."""
        centre = self.centre.snapshot()
        return None if centre is None else (self.plane, self._last, self._inches, self._speed, centre)

    def beside(self, programmed: Point) -> Point:
        """Return the programmed position with the tool's centre, as far as its moves are known, in the plane."""
        return self._placed(programmed, self.centre.position)

    # Motions.

    def motions(self, batch: MotionBatch) -> None:
        """Refuse arrays: the interpreter runs blocks one by one meanwhile."""
        raise RuntimeError("motions came in arrays while cutter compensation is on")

    def straight_traverse(self, end: Point) -> None:
        """Offset a traverse."""
        self._line(end, rapid=True)

    def straight_feed(self, end: Point) -> None:
        """Offset a line."""
        self._line(end, rapid=False)

    def _line(self, end: Point, rapid: bool) -> None:
        move = _Move(self._block, list(end), self.plane, not rapid)
        self._take(lambda: self.centre.line(self._in_plane(end), move, rapid))

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        """Offset an arc."""
        move = _Move(self._block, list(end), plane, True)
        centre = complex(first, second)
        self._take(lambda: self.centre.arc(self._in_plane(end), centre, turns, move))

    def nurbs_feed(self, curve: Curve) -> None:
        """Refuse a spline."""
        raise BlockError("comp-refused", "a spline cannot be offset by cutter compensation")

    def straight_probe(self, end: Point) -> None:
        """Refuse to probe."""
        raise BlockError("comp-refused", "no probing under cutter compensation")

    def rigid_tap(self, end: Point, pitch: float) -> None:
        """Refuse to tap."""
        raise BlockError("comp-refused", "no tapping under cutter compensation")

    def _in_plane(self, end: Point) -> complex:
        return complex(end[self._first], end[self._second])

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
            self.inner.arc_feed(end, piece.centre.real, piece.centre.imag, piece.turns, move.plane)
        elif piece.rapid:
            self.inner.straight_traverse(end)
        else:
            self.inner.straight_feed(end)

    def _length(self, piece: CentreMove, end: Point) -> float:
        """Return the length of a piece from where the tool stands, in X Y Z, else of the rotary part."""
        across = math.dist(self._last[:3], end[:3])
        if piece.centre is not None:
            start = complex(self._last[self._first], self._last[self._second]) - piece.centre
            spin = 1.0 if piece.turns > 0 else -1.0
            sweep = (spin * cmath.phase((piece.end - piece.centre) / start)) % (
                2.0 * math.pi
            ) or 2.0 * math.pi
            normal = PLANE_AXES[self.plane][2]
            turns = 2.0 * math.pi * (abs(piece.turns) - 1)
            across = math.hypot(abs(start) * (sweep + turns), end[normal] - self._last[normal])
        return across or math.dist(self._last[3:6], end[3:6])

    def finish(self) -> None:
        """Pass on all that waits."""
        self._take(self.centre.finish)

    # Other calls wait behind the motions that wait.

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

    def select_plane(self, plane: int) -> None:
        """Pass on."""
        self._defer(lambda: self.inner.select_plane(plane))

    def set_feed_rate(self, rate: float) -> None:
        """Pass on."""
        self._defer(lambda: self.inner.set_feed_rate(rate))

    def set_inverse_time(self, rate: float, length: float) -> None:
        """Take the speed that it means for the programmed move: all pieces of the move go at it, as in LinuxCNC."""

        def run() -> None:
            self._speed = rate * length
            self.inner.set_inverse_time(rate, length)

        self._defer(run)

    def synchronise(self, pitch: float | None) -> None:
        """Pass on."""
        self._defer(lambda: self.inner.synchronise(pitch))

    def set_feed_mode(self, mode: int, synched: bool) -> None:
        """Pass on."""

        def run() -> None:
            self._speed = None
            self.inner.set_feed_mode(mode, synched)

        self._defer(run)

    def set_spindle(self, speed: float, direction: int) -> None:
        """Pass on."""
        self._defer(lambda: self.inner.set_spindle(speed, direction))

    def set_surface_speed(self, limit: float | None) -> None:
        """Pass on."""
        self._defer(lambda: self.inner.set_surface_speed(limit))

    def set_motion_control_mode(self, mode: PathMode, tolerance: float | None, naive: float | None) -> None:
        """Pass on."""
        self._defer(lambda: self.inner.set_motion_control_mode(mode, tolerance, naive))

    def set_g5x_offset(self, system: int, offset: Point) -> None:
        """Refuse to move the coordinate system."""
        raise BlockError(
            "comp-refused",
            "the coordinate system in force cannot change while cutter compensation is on",
            "G10",
            hint="turn it off before (G40 and a straight move)",
        )

    def set_g92_offset(self, offset: Point) -> None:
        """Pass on."""
        self._defer(lambda: self.inner.set_g92_offset(offset))

    def set_xy_rotation(self, degrees: float) -> None:
        """Pass on."""
        self._defer(lambda: self.inner.set_xy_rotation(degrees))

    def use_tool_length_offset(self, offset: Point) -> None:
        """Pass on; coordinates of where the tool stands change by as much."""

        def run() -> None:
            self.inner.use_tool_length_offset(offset)
            if self._offset is not None:
                self._last = [p - n + o for p, n, o in zip(self._last, offset, self._offset, strict=True)]
                self._offset = list(offset)

        self._defer(run)

    def place(self, position: Point) -> None:
        """Pass on."""
        self._defer(lambda: self.inner.place(position))

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
    """Return what the geometry settles in a step; raise its fault as the block's."""
    try:
        return step()
    except CompensationError as error:
        raise BlockError(error.code, str(error), hint=error.hint, values=error.values) from None


def _refuse(block: Block, plane: int, *, lenient: bool) -> None:
    """Raise where a block does what cannot be done while compensation is on."""
    beside = AXES[PLANE_AXES[plane][2]]
    homes_beside = lenient and not block.words.keys() & (set("xyz") - {beside})
    for letter, numbers, refused in (("G", block.g, _REFUSED_G), ("M", block.m, _REFUSED_M)):
        for number in numbers:
            what = refused.get(number)
            if letter == "G" and lenient and (number in _OF_FANUC or (homes_beside and number in _HOMING)):
                what = None
            if letter == "G" and lenient and plane == _LATHES_PLANE and number in _ROUGHING:
                what = None
            if what is None and letter == "G" and PLANE_CODES.get(number, plane) != plane:
                what = "changes the plane"
            if what is not None:
                name = f"{letter}{number / 10:g}"
                raise BlockError(
                    "comp-refused",
                    f"{name} {what}, and cutter compensation is on",
                    name,
                    hint="turn it off before (G40 and a straight move)",
                )


# The codes.


def _turn_on(left: bool, dynamic: bool) -> Handler:
    def run(ip: Interpreter, block: Block) -> None:
        state = ip.state
        name = f"G{41 if left else 42}{'.1' if dynamic else ''}"
        if state.plane not in PLANES[ip.dialect]:
            raise BlockError(
                "comp-plane",
                f"{name} works in the planes {' and '.join(f'G{p}' for p in PLANES[ip.dialect])}, not in G{state.plane}",
                name,
            )
        radius, orientation = (_programmed if dynamic else _of_the_tool)(ip, block, name)
        side = left == (radius >= 0.0)
        if isinstance(ip.sink, CompensatedSink) and ip.dialect not in _STRICT:
            _renew(ip, ip.sink, radius, left)
            return
        first, second, _ = state.plane_axes()
        start = complex(state.position[first], state.position[second])
        unit = "inch" if state.inches else "mm"
        growth = _GROWTH if ip.dialect == "linuxcnc" else None
        # FANUC enters on a move of any length. LinuxCNC's radius of a table may be less by the last digit of a double.
        least = 0.0 if ip.dialect not in _STRICT else abs(radius) * (1.0 if dynamic else 1.0 - _LAST_DIGIT)
        centre = ToolCentre(radius, left, start, orientation, unit, growth=growth, least_entry=least)
        ip.sink.call(f'COMMENT("interpreter: cutter radius compensation on {"left" if side else "right"}")')
        state.compensation = 41 if side else 42
        sink = CompensatedSink(
            ip.sink,
            centre,
            state.plane,
            state.position,
            state.inches,
            ip.warn,
            tool_offset=list(state.tool_offset),
            lenient=ip.dialect not in _STRICT,
        )
        ip.sink, ip.compensated_position = sink, sink.beside

    return run


def _renew(ip: Interpreter, sink: CompensatedSink, radius: float, left: bool) -> None:
    """Take the radius and side of a G41 or G42 that stands while compensation is on; the same again changes nothing."""
    side = 1 if left == (radius >= 0.0) else -1
    if (abs(radius), side) != (sink.centre.radius, sink.centre.side):
        sink.centre.renew(radius, left)
        ip.state.compensation = 41 if side > 0 else 42


def _programmed(ip: Interpreter, block: Block, name: str) -> tuple[float, int]:
    """Return radius (program units) and orientation of G41.1 D L."""
    if "d" not in block.words:
        raise BlockError("comp-diameter", f"{name} has no D", name, hint="D is the tool's diameter")
    orientation = block.words.get("l", 0.0)
    if "l" in block.words and ip.state.plane != 18:
        raise BlockError("comp-orientation", f"L of {name} is for lathes: plane G18", "L")
    if orientation != round(orientation) or not 0 <= orientation < ORIENTATIONS:
        raise BlockError("comp-orientation", f"L{orientation:g} of {name}: an orientation is 0 to 9", "L")
    return block.words["d"] / 2.0, round(orientation)


def _of_the_tool(ip: Interpreter, block: Block, name: str) -> tuple[float, int]:
    """Return radius (program units) and orientation of the tool of D, or of the one in the spindle."""
    number = _number_in_force(ip, block, name)
    tool = ip.tools.find(number)
    if tool is None:
        raise BlockError("unknown-tool", f"tool {number} is not in the tool table", "D")
    tell_unknown(ip, tool.number, "D")
    return tool.diameter * ip.table_scale() / 2.0, tool.orientation


def _number_in_force(ip: Interpreter, block: Block, name: str) -> int:
    """Return the D of a block, else the tool in the spindle, which D0 of LinuxCNC is too.

    FANUC's D stays in force, and D0 names no tool.
    """
    number = whole(block, "d", name) if "d" in block.words else None
    if number is None and "h" in block.words and ip.dialect == "fanuc" and not {430, 440} & set(block.g):
        number = whole(block, "h", name)
        message = f"H{number} of {name} is read as the number of the radius, as controls without D have it"
        ip.warn(BlockError("radius-by-h", message, "H", hint="write D for the radius"), Severity.NOTE)
    if ip.dialect != "fanuc":
        return number or ip.state.tool
    if number is not None:
        ip.state.radius_number = number
    number = ip.state.radius_number
    return ip.state.tool if number is None else number


def radius_number(ip: Interpreter, block: Block) -> None:
    """D of FANUC by itself: the offset of the next G41 or G42."""
    number = whole(block, "d", "")
    changed = number != ip.state.radius_number
    ip.state.radius_number = number
    if changed and isinstance(ip.sink, CompensatedSink):
        radius, _ = _of_the_tool(ip, Block({}), "D")
        _renew(ip, ip.sink, radius, ip.state.compensation == 41)


def turn_off(ip: Interpreter, block: Block) -> None:
    """G40."""
    leaves = isinstance(ip.sink, CompensatedSink) and ip.sink.centre.moved
    end(ip)
    ip.sink.call('COMMENT("interpreter: cutter radius compensation off")')
    if leaves and not _check_leaving(ip, block):
        ip.guard = _leave_straight


def end(ip: Interpreter) -> None:
    """Pass on what waits and take the compensating sink away; the tool stays where it is until the next move."""
    sink = ip.sink
    ip.state.compensation = 40
    if isinstance(sink, CompensatedSink):
        try:
            sink.finish()
        finally:
            ip.sink, ip.compensated_position = sink.inner, None


def _leave_straight(ip: Interpreter, block: Block) -> None:
    """Watch the blocks after G40 up to the first motion."""
    if _check_leaving(ip, block):
        ip.guard = None


def _check_leaving(ip: Interpreter, block: Block) -> bool:
    """Tell whether a block moves; raise where it leaves compensation on an arc."""
    motions = [number for number in block.g if number in PLAIN_MOTIONS]
    if not motions and not block.words.keys() & set("xyz"):
        return False
    motion = motions[0] if motions else ip.state.motion
    if motion in (20, 30):
        ip.guard = None
        raise BlockError(
            "comp-exit",
            "the first move after cutter compensation is an arc; it must be straight",
            "R" if "r" in block.words else "I",
            hint="leave on a G0 or G1 longer than the tool's diameter",
        )
    return True


_GROUP = "cutter compensation"
_STAGE = Stage.RADIUS_COMPENSATION
CODES = (
    Code("G", 400, _GROUP, _STAGE, turn_off, "cutter compensation off"),
    Code(
        "G",
        410,
        _GROUP,
        _STAGE,
        _turn_on(True, False),
        "cutter compensation, tool left of the path",
        "d",
        takes="d",
        moves="plane",
    ),
    Code(
        "G",
        420,
        _GROUP,
        _STAGE,
        _turn_on(False, False),
        "cutter compensation, tool right of the path",
        "d",
        takes="d",
        moves="plane",
    ),
    Code(
        "G",
        411,
        _GROUP,
        _STAGE,
        _turn_on(True, True),
        "as G41, for the diameter D",
        "dl",
        takes="d",
        moves="plane",
    ),
    Code(
        "G",
        421,
        _GROUP,
        _STAGE,
        _turn_on(False, True),
        "as G42, for the diameter D",
        "dl",
        takes="d",
        moves="plane",
    ),
    Code("D", 0, "D", _STAGE, radius_number, "number of the tool radius", "d", dialects=("fanuc",)),
)
