"""G43.4 of FANUC: tool centre point control. The program gives the path of the tool's tip on the workpiece.

While it is in force, a `ToolPointSink` stands before the sink: the tip moves along its path while the rotary axes turn evenly. The
machine's axes follow in lines, as many as the tolerance of the kinematics needs (`kinematics`). F is the speed of the tip on the
workpiece, so each line has a time of its own, and is passed on in inverse time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

from cncgen.gcode.block import AXIS_INDEX, Block
from cncgen.gcode.budget import MOTION
from cncgen.gcode.codes import carried_planes
from cncgen.gcode.codes.affine import AffineSink, FramedSink, applied
from cncgen.gcode.codes.followed_paths import LOOK_DEGREES, FollowedSink, Path
from cncgen.gcode.codes.table import OF_FANUC, ROTARY_PATH, TOOL_POINT, Code
from cncgen.gcode.codes.tools import number_in_force, table_offset, take_length
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Point, Sink
from cncgen.gcode.state.modal import PLAIN_MOTIONS, Stage, to_machine, to_program, zeros
from cncgen.machine.kinematics import Kinematics
from cncgen.records import replace

#: A path is looked at in at least so many parts.
_LOOK_PARTS = 2
_DIRECTIONS = 435
#: Halvings of such a step.
_MAX_DEPTH = 12


class ToolPointSink(FollowedSink):
    """Passes motions of the tip on as motions of the machine; other calls go through."""

    fault, remedy, under = "tcp-refused", "use G49", TOOL_POINT

    def __init__(self, inner: Sink, ip: Interpreter, kinematics: Kinematics) -> None:
        super().__init__(inner, ip, "G43.4")
        self.kinematics = kinematics

    # Between the tip and the machine.

    def shown(self, point: Point) -> Point:
        """Return the program coordinates that put the machine where the tip of `point` needs it."""
        origin, rotation, g92, offset = self.ip.state.offsets()
        unit = self.ip.state.unit_mm
        tip = to_machine(point, origin, rotation, g92, zeros())
        x, y, z = self.kinematics.machine(
            (tip[0] * unit, tip[1] * unit, tip[2] * unit), self._angles(tip), offset[2] * unit
        )
        return to_program([x / unit, y / unit, z / unit, *tip[3:]], origin, rotation, g92, offset)

    def tip_of(self, point: Point) -> Point:
        """Return the tip's program coordinates where the machine stands at `point`: the inverse of `shown`."""
        origin, rotation, g92, offset = self.ip.state.offsets()
        unit = self.ip.state.unit_mm
        machine = to_machine(point, origin, rotation, g92, offset)
        x, y, z = self.kinematics.tip(
            (machine[0] * unit, machine[1] * unit, machine[2] * unit), self._angles(machine), offset[2] * unit
        )
        return to_program([x / unit, y / unit, z / unit, *machine[3:]], origin, rotation, g92, zeros())

    def lever(self, point: Point) -> float:
        """Return how far the tip goes as the rotary axes turn, in length units a radian, where it stands at `point`."""
        origin, rotation, g92, offset = self.ip.state.offsets()
        unit = self.ip.state.unit_mm
        tip = to_machine(point, origin, rotation, g92, zeros())
        place = tip[0] * unit, tip[1] * unit, tip[2] * unit
        return self.kinematics.lever(place, self._angles(tip), offset[2] * unit) / unit

    def _angles(self, machine: Point) -> tuple[float, float]:
        outer, inner = self.kinematics.axes
        return machine[outer], machine[inner]

    def place_tip(self, point: Point) -> None:
        """Take the tip as standing there."""
        self._at = list(point)

    # Motions.

    def _rate_of(self, path: Path, length: float) -> float:
        """Return how often a minute the motion could be made: F over the tip's way, else over the turn of the axes."""
        way = length or math.dist(path(0.0)[3:6], path(1.0)[3:6])
        return self.ip.state.feed / way if way else 0.0

    def _pieces(self, path: Path, begin: Point, sweep: float) -> Iterator[tuple[float, Point]]:
        """Yield place on the path (0 to 1) and program coordinates of the machine's lines' ends."""
        start, end = path(0.0), path(1.0)
        turns = [abs(a - b) for a, b in zip(start[3:6], end[3:6], strict=True)]
        turn = max(sweep, *turns)
        count = 1
        if turn and (sweep or self._bulge(math.dist(start[:3], end[:3]), math.radians(sum(turns)))):
            count = max(_LOOK_PARTS, math.ceil(turn / LOOK_DEGREES))
        self.ip.budget.spend(MOTION * count)
        for k in range(1, count + 1):
            after = self.shown(path(k / count))
            if count == 1:
                yield 1.0, after
                return
            yield from self._halved(path, (k - 1) / count, begin, k / count, after, _MAX_DEPTH)
            begin = after

    def _bulge(self, way: float, turn: float) -> bool:
        """Tell whether a line of the axes may leave the tip's line, which is `way` long, by more than the tolerance in a turn, rad.

        With R the lever, D the way and T the turn of both axes the second derivative of the axes over the line is R T² + 2 D T at most.
        The lever is that of the line's start, and grows by the way at most for each axis.
        """
        lever = self._last_lever + math.sqrt(2.0) * way
        off = (lever * turn**2 + 2.0 * way * turn) / 8.0
        return off * self.ip.state.unit_mm > self.kinematics.tolerance

    def _halved(
        self, path: Path, begin: float, before: Point, end: float, after: Point, depth: int
    ) -> Iterator[tuple[float, Point]]:
        """Yield a step, or its halves where its middle is farther from the line than the tolerance."""
        unit = self.ip.state.unit_mm
        middle = (begin + end) / 2.0
        there = self.shown(path(middle))
        straight = [(p + q) / 2.0 for p, q in zip(before[:3], after[:3], strict=True)]
        if depth and math.dist(there[:3], straight) * unit > self.kinematics.tolerance:
            yield from self._halved(path, begin, before, middle, there, depth - 1)
            yield from self._halved(path, middle, there, end, after, depth - 1)
        else:
            yield end, after


def turn_on(ip: Interpreter, block: Block, name: str = "G43.4") -> None:
    """G43.4 H, which other controls call by other names: Haas's five-axis mills G234 H (UMC operator's supplement).

    Without the kinematics of a machine it is refused, or X Y Z stay places of the tip where no machine will move (`ReadOptions.tips_alone`).
    """
    try:
        _turn_on(ip, block)
    except BlockError as error:
        message = error.message.replace("G43.4", name)
        raise BlockError(error.code, message, name, hint=error.hint, values=error.values) from None
    if ip.options.kinematics is None:
        hint = "give --machine a TOML file with a table [kinematics]"
        if not ip.options.tips_alone:
            message = f"{name} needs a machine with rotary axes that is described"
            raise BlockError("tcp-machine", message, name, hint=hint)
        message = f"{name}: X Y Z are read as places of the tool's tip; no kinematics say what the slides do as rotary axes turn"
        ip.warn_once("tcp-machine", message, name, hint)


def turn_on_directions(ip: Interpreter, block: Block) -> None:
    """G43.5 H: as G43.4; the blocks after it have the tool's direction I J K in place of rotary axes (A-79348E, type 2).

    Raises:
        BlockError: I J K in its own block (alarm PS5421 of turning tables), or Q, by which the tool leans towards its way.
    """
    given = next((letter.upper() for letter in "ijkq" if block.words.get(letter)), "")
    if given:
        hint = "I J K stand in the blocks after it; as they stand, the tool goes along them without Q"
        raise BlockError("not-read", f"{given} in the block of G43.5 is not read", given, hint=hint)
    turn_on(ip, block, "G43.5")
    ip.rewrite = _directed


def _directed(ip: Interpreter, block: Block) -> Block:
    """Return a block with the rotary axes where the tool has the direction I J K: of two pairs of positions the nearer one.

    Raises:
        BlockError: I J K stand beside a rotary axis or a code other than G0 and G1, have no length, or no positions reach them.
    """
    given = {letter: block.words[letter] for letter in "ijk" if letter in block.words}
    if not given or _DIRECTIONS in block.g:
        return block
    first = next(iter(given)).upper()
    motion = next((number for number in block.g if number in PLAIN_MOTIONS), ip.state.motion)
    beside = next((letter for letter in "abc" if letter in block.words), "")
    if beside or motion not in (0, 10):
        other = beside.upper() or f"G{motion // 10}"
        message = f"I J K under G43.5 are the tool's direction, which is not read beside {other}"
        hint = "lines have it, and no rotary axis beside it; R is the radius of an arc"
        raise BlockError("tcp-refused", message, first, hint=hint)
    x, y, z = (given.get(letter, 0.0) for letter in "ijk")
    if math.hypot(x, y, z) == 0.0:
        message = "the direction of the tool, I J K, has no length"
        raise BlockError("orientation-vector", message, first, hint="K1 is along Z")
    words = {letter: value for letter, value in block.words.items() if letter not in given}
    if ip.options.kinematics is not None:
        direction = (x, y, z)
        if isinstance(ip.sink, AffineSink):
            direction = applied(ip.sink.program.matrix, direction)
        absolute = ip.state.absolute if {900, 910}.isdisjoint(block.g) else 900 in block.g
        for letter, value in carried_planes.toward(ip, ip.options.kinematics, direction, first).items():
            words[letter] = value if absolute else value - ip.state.position[AXIS_INDEX[letter]]
    return replace(block, words=words)


def _turn_on(ip: Interpreter, block: Block) -> None:
    if ip.state.compensation != 40:
        raise BlockError("tcp-refused", "G43.4 does not go with cutter compensation", "G43.4", hint="use G40")
    if ip.state.feed_mode == 95:
        raise BlockError("tcp-refused", "G43.4 does not go with G95", "G43.4", hint="use G94")
    number = number_in_force(ip, block, "G43.4")
    begin(ip, table_offset(ip, number)[2] if number else 0.0)


def begin(ip: Interpreter, length: float) -> None:
    """Follow the tip of a tool of that length, in the program's unit, the machine staying where it is."""
    end(ip, 43.4, [0.0, 0.0, length, *zeros()[3:]])
    if ip.options.kinematics is None:
        return
    below = ip.sink.inner if isinstance(ip.sink, FramedSink) else ip.sink
    tool = ToolPointSink(below, ip, ip.options.kinematics)
    tip = tool.tip_of(ip.to_work(ip.state.position))
    tool.place_tip(tip)
    if isinstance(ip.sink, FramedSink):
        ip.sink.inner = tool
    else:
        ip.sink = tool
    ip.stand(ip.from_work(tip))


def turn_off(ip: Interpreter) -> None:
    """Take the sink of G43.4 away, and the directions of G43.5, the machine staying where it is."""
    if ip.rewrite is _directed:
        ip.rewrite = None
    framed = ip.sink if isinstance(ip.sink, FramedSink) else None
    tool = framed.inner if framed else ip.sink
    if not isinstance(tool, ToolPointSink):
        return
    place = tool.shown(ip.to_work(ip.state.position))
    tool.inner.set_lever(0.0)
    if framed:
        framed.inner = tool.inner
    else:
        ip.sink = tool.inner
    ip.stand(ip.from_work(place))


def end(ip: Interpreter, code: float, offset: Point) -> None:
    """Follow no tip: the length code and tool offset are those given, the machine staying where it is."""
    turn_off(ip)
    machine = ip.machine_position()
    ip.state.length_code, ip.state.tool_offset = code, offset
    ip.rebase(machine)
    ip.sink.use_tool_length_offset(offset)


def length_off(ip: Interpreter, block: Block) -> None:
    """G49 of FANUC: no tool offset, no tool centre point control."""
    turn_off(ip)
    ip.state.length_code = 49
    take_length(ip, block, zeros())


CODES = (
    Code("G", 434, "tool length", Stage.TOOL_LENGTH, turn_on, "tool centre point control with the length H", "h", dialects=OF_FANUC,
        takes="h", moves="XYZ", refused=("follows the tool's tip", ROTARY_PATH), without="lathes"),
    Code("G", _DIRECTIONS, "tool length", Stage.TOOL_LENGTH, turn_on_directions, "tool centre point control with directions I J K of the tool", "hijkq",
        dialects=OF_FANUC, takes="h", moves="XYZrotary", refused=("follows the tool's tip", ROTARY_PATH), without="lathes"),
    Code("G", 2340, "tool length", Stage.TOOL_LENGTH, partial(turn_on, name="G234"), "tool centre point control with the length H (Haas)", "h",
        dialects=OF_FANUC, takes="h", moves="XYZ", refused=("follows the tool's tip", ROTARY_PATH), without="lathes"),
    Code("G", 490, "tool length", Stage.TOOL_LENGTH, length_off, "no tool offset, no tool centre point control", dialects=OF_FANUC,
        without="lathes"),
)  # fmt: skip
