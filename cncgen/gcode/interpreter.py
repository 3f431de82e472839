"""The modal interpreter: executes one block after another on the state and calls the sink.

It finds the plan of a block (`block_plans`) and calls its handlers, which stand in `cncgen.gcode.codes`. The order
of lines is the business of `cncgen.gcode.flow`. Methods here serve several handlers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property

from cncgen.diagnostics import Severity
from cncgen.gcode.block import AXIS_INDEX, Block, Jump
from cncgen.gcode.block_plans import G53, BlockPlans
from cncgen.gcode.budget import Budget
from cncgen.gcode.codes.table import LATHES, Handler, language_of
from cncgen.gcode.errors import BlockError
from cncgen.gcode.sinks.sink import PassingSink, Sink
from cncgen.gcode.state.modal import NO_MOTION, PLAIN_MOTIONS, State, to_machine, to_program
from cncgen.gcode.state.parameters import (
    G92,
    G92_ON,
    SYSTEM,
    SYSTEM_COUNT,
    SYSTEM_STEP,
    SYSTEMS,
    Parameters,
    read_parameters,
)
from cncgen.records import replace
from cncgen.toolpath.reading import ReadOptions
from cncgen.units import INCH

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.codes.heidenhain import Ended
    from cncgen.gcode.codes.plain_language import Plain
    from cncgen.gcode.flow.calls import Frame
    from cncgen.gcode.flow.o_words import FlowControl
    from cncgen.machine.tool_table import ToolTable

#: The radius of a tool that no table describes, for cycles that step aside by a part of it, mm.
_CUTTING_MM = 5.0


class Interpreter:
    """State, parameters and sink of one run.

    Attributes:
        sink: Takes the canonical calls of handlers. Cutter compensation and frames put sinks of their own before `base`.
        base: The sink of the run.
        options: How the program is read.
        budget: Counts the blocks and the work of the run.
        remark: Takes a remark on the block that is executed: a `BlockError` and its severity.
        dialect: The control whose words, jumps and arithmetic are read: ``linuxcnc``, ``fanuc`` or ``heidenhain``.
        lathe: Whether X and Z are those of a lathe of FANUC: X a diameter, U and W distances.
        codes: The codes of the dialect.
        state: The modal state, `cncgen.gcode.state.modal.State`.
        parameters: Numbered and named parameters.
        tools_given: Whether there is a tool table; else any tool may be called.
        jump: The jump of M98, M99 or a cycle; the runner takes it after the block.
        macro_values: Arguments of the macro that `jump` asks for.
        modal_macros: G66: number, times and arguments of the macros that follow each motion, the last one first.
        flow: The subroutine calls in progress; None where a block is executed by itself.
        guard: Called with each block before it runs while a curve of several blocks is open; set by that curve's handler.
        rewrite: Takes the words of each block as those of another plane while a linear and a rotary axis make paths together.
        compensated_position: Gives the place beside the path where cutter compensation has the tool; None without it.
        contour_feed: On which compensated arcs F is the feed along the contour: ``all``, ``inside``, or none (empty).
        last_spline_end: Where Heidenhain's last SPL ended, and in which direction.
        plane_blocks, plane_origin, plane_turn: Points or directions of a tilted plane that takes several blocks, by P and Q; its origin,
            and how far it is turned.
        plain_language: State that Heidenhain's plain language keeps from block to block, once it has any.
        rotary: The axes A and C that blocks of a lathe have named: words of lines mostly mean angles and chamfers.
        skipping: Whether blocks are passed over up to G11 of FANUC.
        system: The dialect, of which FANUC's lathes have three for their systems of G codes.
        steps: Whether G91 is in force on a lathe that has it.
        distances: Columns of the axes that the block of a lathe moves by distances.
        feed_doubted: Whether a feed was one that nobody can mean.
        feed_mode_said: Whether the program has said the meaning of F.
        units_said: Whether it has said the unit of lengths.
        ended_in: The block whose M2 or M30 ended it.
        plain: Whether no sign shows the control of the program: then words that LinuxCNC refuses and other controls ignore are
            ignored.
    """

    def __init__(
        self,
        sink: Sink,
        options: ReadOptions,
        remark: Callable[[BlockError, Severity], None],
        dialect: str = "linuxcnc",
        *,
        plain: bool = False,
    ) -> None:
        self.sink: Sink = sink
        self.base = sink
        self.options = options
        self.budget = sink.budget = Budget(options.max_steps)
        self.modal_macros: list[tuple[int, int, list[float]]] = []
        self.macro_values: list[float] | None = None
        self.remark = remark
        self.dialect = language_of(dialect)
        self.lathe = dialect in LATHES
        self.system: str = dialect
        self.plain = plain
        self._plans = BlockPlans(dialect, plain=plain)
        self.codes = self._plans.codes
        self.state: State = State()
        if self.dialect == "fanuc":
            self.state.motion = 0
            self.state.retract_old = True
        if self.lathe:
            self.state.plane, self.state.feed_mode, self.state.diameter = 18, 95, True
        self.parameters: Parameters = Parameters(self)
        self.tools_given = bool(options.tool_table) or (options.stand_alone and dialect == "linuxcnc")
        # A table is read now, whose faults end the run.
        first = next(iter(self.tools.tools), 0) if self.tools_given else 0
        if options.stand_alone:
            self.state.fetched = first
        self.jump: Jump | None = None
        self.flow: FlowControl | None = None
        self.guard: Handler | None = None
        self.rewrite: Callable[[Interpreter, Block], Block] | None = None
        self.last_spline_end: Ended | None = None
        self.plain_language: Plain | None = None
        self.plane_blocks: dict[tuple[int, int], tuple[float, float, float]] = {}
        self.plane_origin = (0.0, 0.0, 0.0)
        self.plane_turn = 0.0
        self.compensated_position: Callable[[list[float]], list[float]] | None = None
        self.contour_feed = ""
        self._said: set[tuple[str, str]] = set()
        self.skipping = self.feed_doubted = self.feed_mode_said = self.units_said = self.steps = False
        self.rotary: set[str] = set()
        self.distances: frozenset[int] = frozenset()
        self.ended_in: Block | None = None
        if options.parameters is not None:
            read_parameters(options.parameters, self.parameters)

    @cached_property
    def tools(self) -> ToolTable:
        """The tools; a program without any does not import their module."""
        from cncgen.machine.tool_table import tools_of

        return tools_of(self.options.tool_table, self.tools_given)

    def begin(self) -> None:
        """Take the coordinate system of the parameter file, and pass the state in force to the sink."""
        numbers = self.parameters.numbers
        state = self.state
        state.inches = self.options.units == "inch"
        state.system = max(1, min(SYSTEM_COUNT, round(numbers[SYSTEM])))
        first = SYSTEMS + SYSTEM_STEP * (state.system - 1)
        scale = self.table_scale()
        state.origin = self.parameters.offset(first, scale)
        state.rotation = numbers[first + 9]
        if numbers[G92_ON]:
            state.g92, state.g92_on = self.parameters.offset(G92, scale), True
        state.position = to_program(state.position, *state.offsets())
        sink = self.sink
        sink.use_length_units(state.inches)
        sink.set_g5x_offset(state.system, state.origin)
        sink.set_g92_offset(state.g92)
        sink.set_xy_rotation(state.rotation)
        state.position = sink.where(state.position)
        if self.lathe:
            sink.select_plane(18)
            sink.set_feed_mode(95, synched=True)
        sink.call("SET_FEED_REFERENCE(CANON_XYZ)")
        sink.call("ON_RESET()")

    def warn(self, code: str, message: str, word: str = "", hint: str = "") -> None:
        """Warn of a word of the block that is executed."""
        self.remark(BlockError(code, message, word, hint=hint), Severity.WARNING)

    def fault(self, code: str, message: str, word: str = "", hint: str = "") -> None:
        """Report an error on it that does not keep the block from going on."""
        self.remark(BlockError(code, message, word, hint=hint), Severity.ERROR)

    def note(self, code: str, message: str, word: str = "", hint: str = "") -> None:
        """Add a note on such a word."""
        self.remark(BlockError(code, message, word, hint=hint), Severity.NOTE)

    def warn_once(self, code: str, message: str, word: str = "", hint: str = "") -> None:
        """Warn, once in a run for the code and hint."""
        if self._is_new(code, hint):
            self.warn(code, message, word, hint)

    def note_once(self, code: str, message: str, word: str = "", hint: str = "") -> None:
        """Add a note, once in a run for the code and hint."""
        if self._is_new(code, hint):
            self.note(code, message, word, hint)

    def fault_once(self, code: str, message: str, word: str = "", hint: str = "") -> None:
        """Report such an error, once in a run for the code and hint."""
        if self._is_new(code, hint):
            self.fault(code, message, word, hint)

    def _is_new(self, code: str, hint: str) -> bool:
        """Tell whether no remark of that code and hint was made once in the run, and count this one."""
        before = len(self._said)
        self._said.add((code, hint))
        return len(self._said) > before

    def check(self, block: Block) -> None:
        """Raise where a block has codes that do not go together, or a word that belongs to none of them."""
        self._plans.of(block, self.state.motion)

    def execute(self, block: Block) -> None:
        """Execute a block in the modal motion in force.

        Raises:
            BlockError: The block has a fault; parts that come earlier in the order of execution have been done.
        """
        steps = self._plans.of(block, self.state.motion)
        if self.state.diameter and not self.lathe and "x" in block.words:
            # The block may be run again: its words stay as they are written.
            block = replace(block, words={**block.words, "x": 0.5 * block.words["x"]})
        self.sink.block = block
        for step in steps:
            step(self, block)

    # State shared by handlers.

    def batchable(self, cycles: frozenset[int]) -> bool:
        """Tell whether plain motions, and holes of these cycles, may be interpreted in arrays, without a handler a block."""
        state = self.state
        return (
            (state.motion in (*PLAIN_MOTIONS, NO_MOTION) or state.motion in cycles)
            and state.plane in (17, 18, 19)
            and state.compensation == 40
            and not state.diameter
            and not state.driven
            and (state.feed_mode != 95 or (state.speed > 0.0 and state.direction != 0))
            and self.guard is None
            and (self.sink is self.base or self._passes_batches)
            and state.polar is None
            and not self.skipping
            and not self.modal_macros
            # A printed rate in inverse time depends on the motion's length.
            and not (state.feed_mode == 93 and self.sink.wants_comments)
        )

    @property
    def _passes_batches(self) -> bool:
        """Whether the sink before the base takes runs of motions, as their words have them."""
        return isinstance(self.sink, PassingSink) and self.sink.takes_batches and self.rewrite is None

    def end_point(self, block: Block) -> list[float]:
        """Return where the block's axis words lead, in program coordinates."""
        state = self.state
        end = state.position.copy()
        words = block.words
        if state.absolute:
            for letter, value in words.items():
                index = AXIS_INDEX.get(letter)
                if index is not None:
                    end[index] = value
        else:
            for letter, value in words.items():
                index = AXIS_INDEX.get(letter)
                if index is not None:
                    end[index] += value
        if "@" in words or "^" in words:
            from cncgen.gcode.codes.polar import polar_end

            polar_end(state, block, end)
        if G53 in block.g:
            return self._in_machine(block, end)
        if state.polar is not None:
            from cncgen.gcode.codes.polar import plane_polar_end

            plane_polar_end(self, words, end)
        return end

    def go(self, end: list[float], *, rapid: bool = False) -> None:
        """Go to an end point in a straight line; under G93 a feed takes its F, as its block alone has said it."""
        if not rapid and self.state.feed_mode == 93:
            here = self.state.position
            # Where X Y Z stand still, the way is that of the rotary axes.
            way = math.dist(here[:3], end[:3]) or math.dist(here[3:6], end[3:6])
            self.sink.set_inverse_time(self.state.feed, way)
        (self.sink.straight_traverse if rapid else self.sink.straight_feed)(end)
        self.state.position, self.state.moved = end, True

    @contextmanager
    def on_trial(
        self, sink: Sink, position: list[float] | None = None, compensation: int | None = None
    ) -> Iterator[None]:
        """Let motions be made on another sink, at a feed of 1, from a position and under a compensation of its own; all is put back behind
        them."""
        state, before = self.state, (self.sink, self.guard, self.compensated_position)
        self.state = replace(
            state,
            feed=1.0,
            feed_mode=94,
            position=list(state.position if position is None else position),
            compensation=state.compensation if compensation is None else compensation,
        )
        self.sink, self.guard, self.compensated_position = sink, None, None
        try:
            yield
        finally:
            self.state = state
            self.sink, self.guard, self.compensated_position = before

    def _in_machine(self, block: Block, end: list[float]) -> list[float]:
        """Return where axis words in machine coordinates (G53) lead."""
        state = self.state
        if not state.absolute:
            message = "G53 does not go with G91: its coordinates are absolute"
            if self.dialect != "fanuc":
                raise BlockError("g53-motion", message, "G53", hint="use G90")
            hint = "the control passes the block over, and Mitsubishi's move by its distances (M700V, 14.4); use G90"
            self.warn("g53-motion", message, "G53", hint)
            return state.position.copy()
        machine = self.machine_position()
        for letter in block.words:
            if letter in AXIS_INDEX:
                machine[AXIS_INDEX[letter]] = end[AXIS_INDEX[letter]]
        return self.from_machine(machine)

    def reported_position(self) -> list[float]:
        """Return where the tool is as #5420 to #5428 and named parameters tell it: beside the path under cutter compensation."""
        position = self.state.position
        return self.compensated_position(position) if self.compensated_position else position

    def scale_of(self, index: int) -> float:
        """Return the factor from the units of the tool table and the parameter file to those in force, for the column of an axis.

        A B C (columns 3 to 5) are degrees everywhere.
        """
        return 1.0 if 3 <= index <= 5 else self.table_scale()

    def table_scale(self) -> float:
        """Return that factor for lengths."""
        return (INCH if self.options.inch_tables else 1.0) / self.state.unit_mm

    def tool_radius(self) -> float:
        """Return the radius of the tool in the spindle, in program units; 0 where no table gives it."""
        tool = self.tools.find(self.state.tool)
        return tool.diameter * self.table_scale() / 2.0 if tool else 0.0

    def cutting_radius(self, name: str, half: float = math.inf, least: float = 0.0) -> float:
        """Return the radius of the tool in the spindle for a cycle that steps aside by a part of it.

        Without a tool table it is 5 mm, or four fifths of half the width of a pocket or slot, but `least` at least, with a warning.
        """
        radius = self.tool_radius()
        if radius > 0.0 or self.tools_given:
            return radius
        radius = max(min(_CUTTING_MM / self.state.unit_mm, 0.8 * half), least)
        message = f"{name} is worked out for a tool {2.0 * radius:g} wide: no tool table gives its diameter"
        hint = "--tool-table gives it; the loops that clear depend on it"
        self.warn_once("tool-assumed", message, hint=hint)
        return radius

    def increment(self) -> float:
        """Return the least increment, which a number without a decimal point counts in (FANUC), in program units."""
        size = self.options.least_increment or 1.0
        return size / 10.0 if self.state.inches else size

    def frame(self) -> Frame:
        """Return the record of the innermost subroutine call."""
        return self.flow_control().calls.frame

    def flow_control(self) -> FlowControl:
        """Return what follows calls and loops; raise where the language of the program has its own."""
        if self.flow is None:
            message = (
                f"the code is one of LinuxCNC and FANUC, and the program is in the dialect {self.dialect}"
            )
            raise BlockError("unsupported-block", message, hint="--dialect tells another one")
        return self.flow

    def call_level(self) -> int:
        """Return how many calls are in progress."""
        return len(self.flow.calls.frames) if self.flow else 0

    def end_compensation(self) -> None:
        """End cutter compensation: the motion that it still holds back is passed on."""
        self.state.compensation = 40
        if self.sink is not self.base:
            from cncgen.gcode.codes.cutter_compensation import end

            end(self)

    def end_program(self) -> None:
        """End as M2 does."""
        self.codes["M", 20].run(self, self.sink.block)

    def machine_position(self) -> list[float]:
        """Return where the tool's reference point is, in machine coordinates and program units."""
        return to_machine(self.to_work(self.state.position), *self.state.offsets())

    def from_machine(self, machine: list[float]) -> list[float]:
        """Return program coordinates of a position in machine coordinates and program units."""
        return self.from_work(to_program(machine, *self.state.offsets()))

    def to_work(self, point: list[float]) -> list[float]:
        """Return work coordinates of a programmed point: another one under the frames of FANUC alone."""
        frame = getattr(self.sink, "frame", None)
        return point if frame is None else list(frame.to_work(point))

    def from_work(self, point: list[float]) -> list[float]:
        """Return the programmed point of work coordinates."""
        frame = getattr(self.sink, "frame", None)
        return point if frame is None else list(frame.to_programmed(point))

    def rebase(self, machine: list[float]) -> None:
        """Compute the program coordinates again after an offset has changed; the machine stays at `machine`."""
        renew = getattr(self.sink, "renew", None)
        if renew is not None:
            renew(self)
        self.stand(self.from_machine(machine))

    def stand(self, position: list[float]) -> None:
        """Take the tool as standing at other program coordinates, the machine where it is."""
        self.state.position = position
        tell = getattr(self.sink, "offsets_changed", None)
        if tell is not None:
            tell(self.state.position)
