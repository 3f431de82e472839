"""G43.4 of FANUC: tool centre point control. The program gives the path of the tool's tip on the workpiece.

While it is in force, a `ToolPointSink` stands before the sink: the tip moves along its path while the rotary axes turn evenly. The
machine's axes follow in lines, as many as the tolerance of the kinematics needs (`kinematics`). F is the speed of the tip on the
workpiece, so each line has a time of its own, and is passed on in inverse time.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from functools import partial

from cncgen.gcode.block import AXIS_INDEX, Block
from cncgen.gcode.budget import MOTION
from cncgen.gcode.codes import carried_planes
from cncgen.gcode.codes.affine import AffineSink, FramedSink, applied
from cncgen.gcode.codes.followed_paths import LEVER_STEPS, MOST_A_MINUTE, FollowedSink, Path
from cncgen.gcode.codes.table import OF_FANUC, ROTARY_PATH, TOOL_POINT, Code
from cncgen.gcode.codes.tools import number_in_force, table_offset, take_length
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import MotionBatch, Point, Sink
from cncgen.gcode.state.modal import PLAIN_MOTIONS, Stage, to_machine, to_program, zeros
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import empty_block
from cncgen.machine.kinematics import Kinematics, Vector
from cncgen.records import replace

TYPE_CHECKING = False
if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_LINEAR, _ROTARY, _SECOND = (0, 1, 2), (3, 4, 5), (6, 7, 8)
#: The least lever, in length units a radian, of a run of motions.
_STUB = 1e-6
_DIRECTIONS = 435
#: What ends it in the languages that do not write G49.
_ENDS = {"M128": "M129", "PLANE": "M129", "TRAORI": "TRAFOOF"}


class ToolPointSink(FollowedSink):
    """Passes motions of the tip on as motions of the machine; other calls go through."""

    fault, under = "tcp-refused", TOOL_POINT

    def __init__(self, inner: Sink, ip: Interpreter, kinematics: Kinematics, name: str) -> None:
        super().__init__(inner, ip, name)
        self.kinematics, self.remedy = kinematics, f"use {_ENDS.get(name, 'G49')}"

    # Between the tip and the machine: points one at a time, or nine columns for as many.

    def shown(self, point: Point) -> Point:
        """Return the program coordinates that put the machine where the tip of `point` needs it."""
        origin, rotation, g92, offset = self.ip.state.offsets()
        unit, machine = self.ip.state.unit_mm, self._machine(point)
        x, y, z = self.kinematics.machine(_slides(machine, unit), self._angles(machine), offset[2] * unit)
        return to_program([x / unit, y / unit, z / unit, *machine[3:]], origin, rotation, g92, offset)

    def tip_of(self, point: Point) -> Point:
        """Return the tip's program coordinates where the machine stands at `point`: the inverse of `shown`."""
        origin, rotation, g92, offset = self.ip.state.offsets()
        unit, machine = self.ip.state.unit_mm, to_machine(point, origin, rotation, g92, offset)
        x, y, z = self.kinematics.tip(_slides(machine, unit), self._angles(machine), offset[2] * unit)
        return to_program([x / unit, y / unit, z / unit, *machine[3:]], origin, rotation, g92, zeros())

    def lever(self, point: Point) -> float:
        """Return how far the tip goes as the rotary axes turn, in length units a radian, where it stands at `point`."""
        unit, machine = self.ip.state.unit_mm, self._machine(point)
        length = self.ip.state.tool_offset[2] * unit
        return self.kinematics.lever(_slides(machine, unit), self._angles(machine), length) / unit

    def _reach(self, point: Point) -> float:
        unit = self.ip.state.unit_mm
        tip = _slides(self._machine(point), unit)
        return self.kinematics.reach(tip, self.ip.state.tool_offset[2] * unit)

    def _machine(self, point: Point) -> Point:
        """Return machine coordinates of the tip."""
        origin, rotation, g92, _ = self.ip.state.offsets()
        return to_machine(point, origin, rotation, g92, zeros())

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

    def _counts(self, start: Point, end: Point, length: float, sweep: float) -> float:
        """Return into how many lines of the axes a motion of the tip is cut, before it is rounded up; an arc sweeps so many degrees.

        Over the motion the second derivative of the axes is R T² + 2 D T + D S at most, with R the reach (`Kinematics.reach`), D the way, T
        the turn of both rotary axes and S the sweep of an arc, rad. A line is off by an eighth of it, and each of n by the n²th part.
        """
        way = length * self.ip.state.unit_mm
        turn = sum(abs(end[k] - start[k]) for k in _ROTARY) * math.pi / 180.0
        reach, other = self._reach(start), self._reach(end)
        # The larger one; on an arc it may be more, by the half of its way in each of two directions.
        reach = (reach + other + abs(reach - other)) / 2.0 + (way if sweep else 0.0)
        off = reach * turn * turn + way * (2.0 * turn + math.radians(sweep))
        return (off / (8.0 * self.kinematics.tolerance)) ** 0.5

    def _pieces(self, path: Path, begin: Point, length: float, sweep: float) -> Iterator[tuple[float, Point]]:
        """Yield place on the path (0 to 1) and program coordinates of the machine's lines' ends."""
        count = max(1, math.ceil(self._counts(path(0.0), path(1.0), length, sweep)))
        self.ip.budget.spend(MOTION * count)
        for k in range(1, count + 1):
            yield k / count, self.shown(path(k / count))

    @property
    def takes_batches(self) -> bool:
        """Whether runs of motions may come (`motions`): no other sink stands behind, and nothing is printed."""
        return self.inner is self.ip.base and not self.wants_comments

    def motions(self, batch: MotionBatch) -> None:
        """Pass a run of plain motions on: traverses and lines in columns, arcs and lines without a feed one by one."""
        kinds, feeds, begin = batch.motion.tolist(), batch.feed.tolist(), 0
        for row in [k for k, kind in enumerate(kinds) if kind > 1 or (kind and not feeds[k])]:
            self._pass_lines(batch, slice(begin, row))
            self._pass_one(batch, row)
            begin = row + 1
        self._pass_lines(batch, slice(begin, len(kinds)))

    def _pass_one(self, batch: MotionBatch, row: int) -> None:
        import numpy as np

        state = self.ip.state
        self.inner.block = empty_block(Cursor(batch.source, batch.offset[row], batch.line[row]))
        self._rate = state.feed = batch.feed[row]
        end, centre = (np.array(columns[row : row + 1])[0].tolist() for columns in (batch.end, batch.centre))
        if batch.turns[row]:
            self.arc_feed(end, centre[0], centre[1], batch.turns[row], state.plane)
        else:
            self.straight_feed(end)

    def _pass_lines(self, batch: MotionBatch, rows: slice) -> None:
        """Pass straight motions on, all of them at once; see `_follow` for one."""
        if rows.start == rows.stop:
            return
        import numpy as np

        of_rows = batch.part(rows.start, rows.stop)
        motion, end, rate = (np.array(c) for c in (of_rows.motion, of_rows.end, of_rows.feed))
        start = np.concatenate([[self._at], end[:-1]])
        self._at = end[-1].tolist()
        ways = [np.linalg.norm((end - start)[:, axes], axis=1) for axes in (_LINEAR, _ROTARY, _SECOND)]
        count = np.maximum(np.ceil(self._counts(list(start.T), list(end.T), ways[0], 0.0)), 1.0)
        count[motion == 0] = 1.0
        count[(end == start).all(axis=1)] = 0.0
        self.ip.budget.spend(MOTION * int(count.sum()))
        count = count.astype(np.int64)
        row = np.repeat(np.arange(len(count)), count)
        part = (np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count) + 1) / count[row]
        if not len(row):
            return
        tips = np.where(part[:, None] < 1.0, start[row] + (end - start)[row] * part[:, None], end[row])
        slides = np.column_stack(self.shown(list(tips.T)))
        mode = self.ip.state.feed_mode
        if mode != 93:
            # F is that of the tip, else of the turn, else of U V W.
            rate /= np.select([way > 0.0 for way in ways], ways, math.inf)
            self.inner.set_feed_mode(93, synched=False)
        made = replace(
            of_rows,
            motion=motion[row].data,
            end=slides.data,
            feed=np.minimum(rate[row] * count[row], MOST_A_MINUTE).data,
            feed_set=np.zeros(len(row), np.uint8).data,
            centre=np.zeros((len(row), 2)).data,
            turns=np.zeros(len(row), np.int64).data,
            line=np.array(of_rows.line)[row].data,
            offset=np.array(of_rows.offset)[row].data,
            reach=float(np.abs(slides).max()),
        )
        for lever, first, last in self._levers(np.concatenate([start[:1], tips])):
            self.inner.set_lever(lever)
            self.inner.motions(made.part(first, last))
        if mode != 93:
            self.inner.set_feed_mode(mode, synched=False)
            self.inner.set_feed_rate(of_rows.feed[-1])

    def _levers(self, tips: NDArray[np.float64]) -> Iterator[tuple[float, int, int]]:
        """Yield the lever of lines between places, shape (n + 1, 9), and the first and behind the last line that has it."""
        import numpy as np

        from cncgen.geometry import elementary

        of_ends = np.array(self.lever(list(tips.T)))
        longer = np.maximum(np.maximum(of_ends[:-1], of_ends[1:]), _STUB)
        step = np.ceil(LEVER_STEPS * elementary.log2(longer))
        changes = (np.flatnonzero(np.diff(step)) + 1).tolist()
        for first, last in itertools.pairwise([0, *changes, len(step)]):
            yield 2.0 ** (float(step[first]) / LEVER_STEPS), first, last


def _slides(machine: Point, unit: float) -> Vector:
    return machine[0] * unit, machine[1] * unit, machine[2] * unit


def turn_on(ip: Interpreter, block: Block, name: str = "G43.4") -> None:
    """G43.4 H, which other controls call by other names: Haas's five-axis mills G234 H (UMC operator's supplement).

    Without the kinematics of a machine it is refused, or X Y Z stay places of the tip where no machine will move (`ReadOptions.tips_alone`).
    """
    faults = (
        (ip.state.compensation != 40, "cutter compensation", "use G40"),
        (ip.state.feed_mode == 95, "G95", "use G94"),
    )
    refuse(
        name,
        *((holds, "tcp-refused", f"{name} does not go with {what}", hint) for holds, what, hint in faults),
    )
    number = number_in_force(ip, block, name)
    begin(ip, table_offset(ip, number)[2] if number else 0.0, name)
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


def begin(ip: Interpreter, length: float, name: str) -> None:
    """Follow the tip of a tool of that length, in the program's unit, the machine staying where it is; a word of the program asks for it."""
    end(ip, 43.4, [0.0, 0.0, length, *zeros()[3:]])
    if ip.options.kinematics is None:
        return
    below = ip.sink.inner if isinstance(ip.sink, FramedSink) else ip.sink
    tool = ToolPointSink(below, ip, ip.options.kinematics, name)
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
