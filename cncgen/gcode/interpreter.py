"""The modal interpreter: executes one block after another on the state and calls the sink."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

from cncgen.diagnostics import Severity
from cncgen.gcode.block import AXIS_INDEX, Block
from cncgen.gcode.codes import ALONE, BOTH, Code, Codes, Handler, table
from cncgen.gcode.errors import BlockError
from cncgen.gcode.modal import NO_MOTION, Stage, State, to_machine, to_program
from cncgen.gcode.parameters import (
    G92,
    G92_ON,
    SYSTEM,
    SYSTEM_COUNT,
    SYSTEM_STEP,
    SYSTEMS,
    Parameters,
    read_parameters,
)
from cncgen.gcode.polar import plane_polar_end, polar_end
from cncgen.gcode.sink import Sink
from cncgen.gcode.tool_table import ToolTable, tools_of
from cncgen.gcode.unsupported import shown
from cncgen.toolpath.reading import ReadOptions
from cncgen.units import INCH

if TYPE_CHECKING:
    from cncgen.gcode.calls import Frame
    from cncgen.gcode.flow import FlowControl

_AXIS_LETTERS = frozenset("xyzabcuvw@^")
#: Plans kept; a program uses some dozens.
_MAX_PLANS = 4096
_G53 = 530
#: G0 and G1.
_STRAIGHT = (0, 10)
_PLAIN_MOTIONS = (0, 10, 20, 30)


@dataclass(frozen=True, slots=True)
class Plan:
    """What a block with these codes and letters does in this modal motion, in order."""

    steps: tuple[Handler, ...]


def _run_under(ip: Interpreter, block: Block) -> None:
    """Make the motion that is in force again after G80 of FANUC."""
    ip.codes["G", ip.state.motion].run(ip, block)


_UNDER = Code("G", -1, "motion", Stage.MOTION, _run_under, "", "xyzabcuvwijkr", "motion")


def _traverse_once(ip: Interpreter, block: Block) -> None:
    """Traverse as G53 of FANUC does; the motion in force stays."""
    motion = ip.state.motion
    ip.codes["G", 0].run(ip, block)
    ip.state.motion = motion


@cache
def _only_modal(number: int) -> Code:
    """Return what a motion code of FANUC does beside a one-shot code that takes the axis words: it is in force then."""

    def run(ip: Interpreter, block: Block) -> None:
        ip.state.motion = number

    return Code("G", number, "motion", Stage.MOTION, run, "")


_TRAVERSE_ONCE = Code("G", 0, "motion", Stage.MOTION, _traverse_once, "", "xyzabcuvw", "motion")


class Interpreter:
    """State, parameters and sink of one run.

    `warn` takes a remark on the block that is executed (a `BlockError` and its severity).
    """

    def __init__(
        self,
        sink: Sink,
        options: ReadOptions,
        warn: Callable[[BlockError, Severity], None],
        dialect: str = "linuxcnc",
    ) -> None:
        self.sink: Sink = sink
        #: The sink below cutter compensation and frames, which put their own before it.
        self.base = sink
        self.options = options
        #: G66: number, times and arguments of the macros that follow each motion, the last one first.
        self.modal_macros: list[tuple[int, int, list[float]]] = []
        #: Arguments of the macro that `jump` asks for.
        self.macro_values: list[float] | None = None
        self.warn = warn
        self.dialect = dialect
        self.codes = table(dialect)
        self.state: State = State()
        if dialect == "fanuc":
            self.state.motion = 0
            self.state.retract_old = True
        self.parameters: Parameters = Parameters(self)
        self.tools: ToolTable = tools_of(options)
        if options.stand_alone:
            self.state.fetched = next(iter(self.tools.tools), 0)
        #: What M98 or M99 asked for: kind, number, times; taken by the runner after the block.
        self.jump: tuple[str, int, int] | None = None
        self.flow: FlowControl | None = None
        #: Looks at each block before it runs while a curve of several blocks is open; set by that curve's handler.
        self.guard: Handler | None = None
        #: Where the last SPL ended.
        self.ended: object | None = None
        self.beside: Callable[[list[float]], list[float]] | None = None
        #: Whether blocks are passed over up to G11 of FANUC.
        self.passing_over = False
        self._plans: dict[tuple[object, ...], Plan] = {}
        if options.parameters is not None:
            read_parameters(options.parameters, self.parameters)

    def begin(self) -> None:
        """Take the coordinate system that the parameter file left in force, and tell the sink what is in force."""
        numbers = self.parameters.numbers
        state = self.state
        state.system = max(1, min(SYSTEM_COUNT, round(numbers[SYSTEM])))
        first = SYSTEMS + SYSTEM_STEP * (state.system - 1)
        scale = self.table_scale()
        state.origin = self.parameters.offset(first, scale)
        state.rotation = numbers[first + 9]
        if numbers[G92_ON]:
            state.g92, state.g92_on = self.parameters.offset(G92, scale), True
        state.position = to_program(state.position, *state.offsets())
        sink = self.sink
        sink.use_length_units(False)
        sink.set_g5x_offset(state.system, state.origin)
        sink.set_g92_offset(state.g92)
        sink.set_xy_rotation(state.rotation)
        state.position = sink.where(state.position)
        sink.call("SET_FEED_REFERENCE(CANON_XYZ)")
        sink.call("ON_RESET()")

    def execute(self, block: Block) -> None:
        """Execute a block.

        Raises:
            BlockError: What is wrong with it; parts that come earlier in the order of execution have been done.
        """
        self.perform(self.plan_of(block), block)

    def perform(self, plan: Plan, block: Block) -> None:
        """Execute a block by the plan of its codes and letters in the modal motion in force."""
        if self.state.diameter and "x" in block.words:
            # The block may be run again: its words stay as they are written.
            block = replace(block, words={**block.words, "x": 0.5 * block.words["x"]})
        self.sink.block = block
        for step in plan.steps:
            step(self, block)

    def plan_of(self, block: Block) -> Plan:
        """Return what a block does in the modal motion in force.

        Raises:
            BlockError: Its codes do not go together, or a word belongs to none of them.
        """
        key = (self.state.motion, block.g, block.m, *block.words)
        plan = self._plans.get(key)
        if plan is None:
            if len(self._plans) >= _MAX_PLANS:
                self._plans.clear()
            plan = self._plans[key] = self._plan(block)
        return plan

    def _plan(self, block: Block) -> Plan:
        """Find the codes of a block, check that they go together, and order them."""
        codes = [self._code("G", number) for number in block.g] + [
            self._code("M", number) for number in block.m
        ]
        codes = _without_cancel(codes)
        _check_groups(codes)
        if self.dialect == "fanuc":
            codes = _one_mover(codes)
        motion = self._motion_of(block, codes)
        if motion is not None and motion not in codes:
            codes.append(motion)
        taken = {letter for code in codes for letter in code.takes}
        codes += [
            self.codes[letter.upper(), 0]
            for letter in block.words
            if letter.upper() in ALONE and letter not in taken
        ]
        if _G53 in block.g and (motion is None or motion.number not in _STRAIGHT):
            raise BlockError("g53-motion", "G53 goes with G0 and G1 only", "G53")
        allowed = set().union(*(code.words for code in codes), *(code.named for code in codes))
        for letter in block.words:
            if letter not in allowed:
                raise _unused(letter, self.codes)
        steps = [code.run for code in sorted(codes, key=lambda code: code.stage)]
        steps += [code.after for code in codes if code.after is not None]
        return Plan(tuple(steps))

    def _code(self, letter: str, number: int) -> Code:
        """Return a code of the table, or raise."""
        code = self.codes.get((letter, number))
        if code is None and letter == "M" and self.dialect == "fanuc":
            from cncgen.gcode.subprograms import of_builder

            return of_builder(number)
        if code is None:
            name = f"{letter}{number / 10:g}"
            hint = "`cncgen codes` lists all that are read"
            other = next((d for d in BOTH if d != self.dialect and (letter, number) in table(d)), None)
            if other:
                hint = f"it is a code of the {other} dialect: --dialect {other}"
            raise BlockError(
                "unknown-code", f"{shown(letter, number, name)} is not supported", name, hint=hint
            )
        return code

    def _motion_of(self, block: Block, codes: list[Code]) -> Code | None:
        """Return the motion that the block's axis words belong to: its own, or the modal one."""
        own = [code for code in codes if code.axes == "own"]
        motion = next((code for code in codes if code.axes == "motion"), None)
        moves = not _AXIS_LETTERS.isdisjoint(block.words)
        moving = motion if motion and motion.number != NO_MOTION else None
        if own and (moving or len(own) > 1) and moves:
            other = moving or own[1]
            raise BlockError(
                "axis-words-twice", f"{own[0].name} and {other.name} both need the axis words", own[0].name
            )
        if own or motion:
            return motion
        if moves and _G53 in block.g and self.dialect == "fanuc":
            return _TRAVERSE_ONCE
        return self._motion_in_force(block, codes, moves)

    def _motion_in_force(self, block: Block, codes: list[Code], moves: bool) -> Code | None:
        """Return the modal motion that a block without a motion code goes on with."""
        modal = self.codes.get(("G", self.state.motion))
        if any(code.group == "canned cycle" for code in codes):
            modal = _UNDER
        if modal is not None and modal.number != NO_MOTION and not set(modal.summons).isdisjoint(block.words):
            return modal
        if moves:
            letter = next(letter for letter in block.words if letter in _AXIS_LETTERS)
            raise BlockError(
                "no-motion-mode",
                f"{letter.upper()} stands in a block with no motion code, and none is in force",
                letter.upper(),
                hint="begin with G0, G1, G2 or G3",
            )
        return None

    # What handlers share.

    def batchable(self) -> bool:
        """Tell whether plain motions may be interpreted in arrays, without a handler a block."""
        state = self.state
        return (
            state.motion in (0, 10, 20, 30, NO_MOTION)
            and state.plane in (17, 18, 19)
            and state.compensation == 40
            and not state.diameter
            and (state.feed_mode != 95 or (state.speed > 0.0 and state.direction != 0))
            and self.guard is None
            and self.sink is self.base
            and state.polar is None
            and not self.passing_over
            and not self.modal_macros
            # A printed rate in inverse time depends on the motion's length.
            and not (state.feed_mode == 93 and self.sink.wants_comments)
        )

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
            polar_end(state, block, end)
        if _G53 in block.g:
            return self._in_machine(block, end)
        if state.polar is not None:
            plane_polar_end(state, words, end)
        return end

    def _in_machine(self, block: Block, end: list[float]) -> list[float]:
        """Return where axis words in machine coordinates (G53) lead."""
        state = self.state
        if not state.absolute:
            message = "G53 does not go with G91: its coordinates are absolute"
            if self.dialect != "fanuc":
                raise BlockError("g53-motion", message, "G53", hint="use G90")
            hint = "the control passes the block over; use G90"
            self.warn(BlockError("g53-motion", message, "G53", hint=hint), Severity.WARNING)
            return state.position.copy()
        machine = self.machine_position()
        for letter in block.words:
            if letter in AXIS_INDEX:
                machine[AXIS_INDEX[letter]] = end[AXIS_INDEX[letter]]
        return self.from_machine(machine)

    def standing(self) -> list[float]:
        """Return where the tool stands as parameters tell it: beside the path under cutter compensation."""
        position = self.state.position
        return self.beside(position) if self.beside else position

    def scale_of(self, index: int) -> float:
        """Return the factor from the units of the tool table and parameter file to the program's, for a column."""
        return 1.0 if 3 <= index <= 5 else self.table_scale()

    def table_scale(self) -> float:
        """Return that factor for lengths."""
        return (INCH if self.options.inch_tables else 1.0) / (INCH if self.state.inches else 1.0)

    def increment(self) -> float:
        """Return what a number without a decimal point counts in, in program units."""
        size = self.options.least_increment or 1.0
        return size / 10.0 if self.state.inches else size

    def frame(self) -> Frame:
        """Return the record of the innermost subroutine call."""
        assert self.flow is not None
        return self.flow.calls.frame

    def call_level(self) -> int:
        """Return how many calls are in progress."""
        return len(self.flow.calls.frames) if self.flow else 0

    def restore(self, saved: object) -> None:
        """Bring back a modal state that M73 saved."""
        from cncgen.gcode.saved import Saved, restore

        assert isinstance(saved, Saved)
        restore(self, saved)

    def end_compensation(self) -> None:
        """Let the motion go that cutter compensation holds back."""
        self.state.compensation = 40
        if self.sink is not self.base:
            from cncgen.gcode.cutter_compensation import end

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
        """Take program coordinates anew after an offset changed; the machine stays at `machine`."""
        self.state.position = self.from_machine(machine)


def _without_cancel(codes: list[Code]) -> list[Code]:
    """Drop G80 where its block has another motion code, which ends a canned cycle as well."""
    if sum(code.group == "motion" for code in codes) < 2:
        return codes
    return [code for code in codes if (code.letter, code.number) != ("G", NO_MOTION)]


def _one_mover(codes: list[Code]) -> list[Code]:
    """Leave the axis words to a one-shot code of FANUC (``G0 G28 Z0``) that stands beside G0 to G3."""
    if not any(code.axes == "own" and code.group == "non-modal" for code in codes):
        return codes
    return [
        _only_modal(code.number) if code.letter == "G" and code.number in _PLAIN_MOTIONS else code
        for code in codes
    ]


def _check_groups(codes: list[Code]) -> None:
    """Raise where two codes of one modal group stand in one block."""
    seen: dict[str, Code] = {}
    for code in codes:
        other = seen.get(code.group)
        if other is not None:
            raise BlockError(
                "modal-conflict",
                f"{other.name} and {code.name} are of one modal group ({code.group})",
                code.name,
                hint="write them in two blocks",
            )
        seen[code.group] = code


def _unused(letter: str, codes: Codes) -> BlockError:
    """Return the fault of a word that no code of its block uses."""
    users = sorted({code.number: code.name for code in codes.values() if letter in code.words}.items())
    names = ", ".join(name for _, name in users[:8])
    hint = f"it belongs to {names}" if names else ""
    if letter == "e":
        hint = "numbers have no exponent in G-code" + (f"; E {hint[3:]}" if hint else "")
    return BlockError(
        "unused-word",
        f"{letter.upper()} stands in a block with no code that uses it",
        letter.upper(),
        hint=hint,
    )
