"""Blocks of a program in plain language on the interpreter: words with their values, motions, cycles at their ends, contours that are read."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

from cncgen.gcode.block import AXIS_INDEX, Block, Own, Value, evaluate, gather
from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.codes.turning_profiles import Segment
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow import recovery
from cncgen.gcode.flow.plain_lines import PlainLane
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.klartext import contours, cycles, orientation, programs
from cncgen.gcode.klartext.program_text import Frame, ProgramText
from cncgen.gcode.text import plain_language
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.plain_language import Statement
from cncgen.kernels.language_code import TOOL_FEED
from cncgen.units import INCH

#: Cycles from this number on have their surface in Q203, and take M109 and M110 for their arcs on the control.
OF_PARAMETERS = 200
INCLUDE = "--include adds a folder to the search path"
_ARCS = (Own.CIRCLE, Own.RADIUS_ARC, Own.POLAR_ARC)
#: M functions that act at the end of their block (TNC 155, "M-functions which affect program run"), one lot after another: M5, M6 and M9
#: (M13 and M14, M3, M4 and M8 act at its beginning), M0 and M1, M2 and M30.
_AT_THE_END = (50, 60, 90), (0, 10), (20, 300)


class _ToolFeed:
    """The feed of TOOL CALL as a variable that the kernel reads; before TOOL CALL has one, there is none without an index."""

    kind = "REAL"

    def __init__(self, ip: Interpreter) -> None:
        self._ip = ip

    @property
    def values(self) -> list[float]:
        return [Plain.of(self._ip).tool_feed]

    @property
    def bounds(self) -> tuple[int, ...]:
        """Return no bounds, as of one number, where there is a feed."""
        return () if self.values[0] > 0.0 else (0,)


class Execution(ProgramText):
    """A run, as far as it executes blocks."""

    def _prepare(self) -> None:
        super()._prepare()
        #: The part of the feed that M103 lets motions downwards have, 0 for all of it.
        self._plunge = 0.0
        self._of_cycle = ""
        #: The words of the block that is run, where they were computed before.
        self._given_words: list[tuple[str, float]] | None = None
        #: The side of a contour that is read and not run, None where lines are run.
        self._side: int | None = None

    def _is_plain(self) -> bool:
        return self._is_plain_in_space() and orientation.is_plain(self.ip)

    def _is_plain_in_space(self) -> bool:
        plain = Plain.of(self.ip)
        return not (plain.modal or self._plunge or self._is_free or plain.paraxial)

    def _run_plain(self, lane: PlainLane, frame: Frame, most: int) -> int:
        lines, found = frame.program.lines, frame.program.lines.run_at(frame.at)
        turns = found is not None and frame.at + found[1] in frame.program.turning
        if self._is_plain() or (self._is_plain_in_space() and not turns):
            return lane.run(lines, frame.at, most)
        return frame.at

    def _scopes(self) -> list[dict[str, Any]]:
        return [{TOOL_FEED: _ToolFeed(self.ip)}]

    def _run_words(self, at: int, here: Cursor, words: list[tuple[str, float]]) -> None:
        self._given_words = words
        self._plain(at, Statement("block", words))
        self._given_words = None

    def _made(self, begin: list[float], motion: memoryview, end: memoryview, centre: memoryview) -> None:
        """Keep the direction in which the last of plain motions ends that goes along X or Y."""
        for row in range(len(motion) - 1, -1, -1):
            x, y = (end[row - 1, 0], end[row - 1, 1]) if row else begin[:2]
            way = complex(end[row, 0] - x, end[row, 1] - y)
            if way:
                Plain.of(self.ip).heading = way / abs(way)
                return

    def _take_up(self, frame: Frame, at: int) -> None:
        """Stand where a line leads that failed, with its feed: arcs behind it were blamed for beginning elsewhere."""
        if self.ip.guard is not None:
            return
        words: dict[str, float] = {}
        known, self._given_words = self._given_words, None
        # Parameters may be those of lines behind it by now.
        for letter, value in known or self._place(at):
            if known and letter not in AXIS_INDEX and letter != "f":
                continue
            with suppress(BlockError):
                words |= gather([(letter, evaluate(value, self.ip.parameters))]).words
        feed = words.pop("f", 0.0)
        if feed > 0.0:
            recovery.attempt(self.ip, Block({"f": feed}))
        recovery.stand(self.ip, Block(words))

    def _place(self, at: int) -> plain_language.Words:
        """Return where a line leads that failed, and its feed, as far as it was read."""
        return plain_language.place(self._lines[at].body)

    def _now(self, value: Value) -> float:
        """Return the present value of what a block gives; raise where a double cannot hold it."""
        try:
            found = evaluate(value, self.ip.parameters)
        except BlockError as error:
            error.hint = error.hint or "was the Q parameter set?"
            raise
        if not math.isfinite(found):
            raise BlockError("number-range", f"a value is {found:g}, beyond the range of numbers")
        return found

    def _block(self, at: int, words: Sequence[tuple[str, Value]]) -> Block:
        block = gather([(letter, evaluate(value, self.ip.parameters)) for letter, value in words])
        here = self._lines[at].here
        block.source, block.line, block.offset = here.source, here.line, here.offset
        return block

    def _here(
        self, at: int, g: tuple[int, ...] = (), words: dict[str, float] | None = None, m: tuple[int, ...] = ()
    ) -> Block:
        here = self._lines[at].here
        return Block(words or {}, g, m, None, here.source, here.line, here.offset)

    def _take_marks(self, marks: Mapping[str, Value]) -> None:
        """Take the functions of a line that stay in force."""
        Plain.of(self.ip).modal |= "M89" in marks
        if "M103" in marks:
            self._plunge = self._now(marks["M103"]) / 100.0
        if "M128" in marks:
            orientation.turn_on(self.ip, ())

    def _change_side(self, block: Block, ends: bool) -> None:
        """End cutter compensation where the line does, and refuse its other side without an end."""
        if self.ip.state.compensation != 40 and ends and not {410, 420} & set(block.g):
            self._execute(block.beside({}, (400,)))
        if {self.ip.state.compensation * 10, *block.g} >= {410, 420}:
            message = f"{'RL is followed by RR' if 420 in block.g else 'RR is followed by RL'} without a block with R0 between"
            raise BlockError("comp-refused", message, "R", hint="a line with R0 leads off the contour before")

    def _plain(self, at: int, statement: Statement) -> None:
        self._execute_whole(at, statement.marks, self._block(at, statement.words))

    def _execute_whole(self, at: int, marks: Mapping[str, Value], block: Block) -> None:
        """Run a block of the interpreter's codes with what this language does before and behind it."""
        self._take_marks(marks)
        orientation.count_turns(self.ip, block, marks)
        orientation.take(self.ip, block, marks)
        contours.lengthen(self.ip, block, marks)
        usual = contours.plunge(self.ip, block, self._plunge)
        called = self._calls(block)
        self._change_side(block, "R0" in marks)
        moves = _moves(block)
        calls = called or (Plain.of(self.ip).modal and moves)
        late = behind_call(block) if calls else []
        if moves:
            block.words |= self._corner_after(at)
        for part in orientation.between(self.ip, block):
            self._move(part)
        self._move(block)
        if usual is not None:
            self._execute(block.beside({"f": usual}))
        if moves and self._is_free:
            self.frames[-1].program.ends[at] = complex(*self.ip.state.position[:2]), Plain.of(self.ip).heading
        if "t" in block.words:
            self._tell_tool()
        if calls:
            self._call_cycle(block)
        for part in late:
            self._execute(part)

    def _calls(self, block: Block) -> bool:
        """Tell whether M99 calls the cycle at the end of a block, which ends M89, and take it out."""
        called = Own.CYCLE_CALL in block.g
        if called:
            block.g = tuple(number for number in block.g if number != Own.CYCLE_CALL)
            Plain.of(self.ip).modal = False
        return called

    def _corner_after(self, at: int) -> dict[str, float]:
        """Return the corner that the line behind a motion puts at its end."""
        return {}

    def _call_cycle(self, block: Block) -> None:
        """Run the cycle at the tool's place, or the program of cycle 12 from there on."""
        plain = Plain.of(self.ip)
        if plain.cycle == programs.CYCLE and not plain.modal:
            self._call_program(self._of_cycle)
        else:
            if self.ip.contour_feed and plain.cycle >= OF_PARAMETERS:
                message = "M109 and M110 do not act on the arcs of cycles here: their feed is that of the tool's centre"
                self.ip.warn_once("feed-function", message, "M109", "the path is not changed by it")
            cycles.call(self.ip, block.beside({}))

    def _call_program(self, name: str) -> None:
        """CALL PGM: another file, beside the program or in a folder of --include; its labels are its own."""
        if not name:
            hint = 'SEL PGM "PART.H", or CYCL DEF 12.1 PGM PART.H, names it'
            raise BlockError("sub-missing", "no program is named that is called", "PGM", hint=hint)
        file = name if "." in name else f"{name}.H"
        program = self.program_of(name, f"there is no program {file}", "PGM", INCLUDE)
        program.ends.clear()
        frame, inches, numbers = Frame(program), self.ip.state.inches, self.ip.parameters.numbers
        own = numbers[plain_language.LOCAL]
        frame.back = lambda: self._take_back(inches, own)
        self.enter(frame, "CALL")
        numbers[plain_language.LOCAL] = array("d", bytes(8 * len(own)))

    def _take_back(self, inches: bool, own: array[float]) -> None:
        """Go on with the unit and the QL of the caller: MM and INCH of BEGIN PGM, and QL, are those of one program (TNC 640, ISO
        programming 3/2014, "Principle and overview of functions": they are "not applied as part of program calls")."""
        self.ip.parameters.numbers[plain_language.LOCAL] = own
        if self.ip.state.inches != inches:
            self._execute(Block({}, g=(200 if inches else 210,)))

    def _tell_tool(self) -> None:
        """Set the Q parameters that the control keeps of the tool: radius, axis (2, Z), unit (1, inch), length."""
        ip = self.ip
        tool = ip.tools.find(ip.state.tool)
        length, radius = (tool.offset[2], tool.diameter / 2.0) if tool else (0.0, 0.0)
        scale = ip.table_scale()
        for number, value in (
            (108, radius * scale),
            (109, 2.0),
            (113, float(ip.state.inches)),
            (114, length * scale),
        ):
            ip.parameters.set_number(float(number), value)

    def _move(self, block: Block) -> None:
        """Execute a block, and keep the direction in which it ends."""
        state, plain = self.ip.state, Plain.of(self.ip)
        before = state.position.copy()
        self._execute(block)
        way = complex(state.position[0] - before[0], state.position[1] - before[1])
        if way and not any(number in _ARCS for number in block.g):
            plain.heading = way / abs(way)

    def _execute(self, block: Block) -> None:
        if self._side is not None:
            for number in block.g:
                self._side = self._side or {410: 1, 420: -1}.get(number, 0)
            block = replace(block, g=tuple(number for number in block.g if number not in (400, 410, 420)))
        if self.ip.guard is not None:
            self.ip.base.block = block
            self.ip.guard(self.ip, block)
        inches = self.ip.state.inches
        for part in in_order(block, moves=_moves(block)) if block.m else (block,):
            if part.words or part.g or part.m:
                self.ip.execute(part)
        if self.ip.state.inches != inches:
            self._convert()

    def _convert(self) -> None:
        """Keep the feeds and the pole in force where a program in another unit begins or ends."""
        ip, plain = self.ip, Plain.of(self.ip)
        factor = 1.0 / INCH if ip.state.inches else INCH
        plain.tool_feed *= factor
        if plain.pole is not None:
            plain.pole *= factor
        if ip.state.feed:
            ip.state.feed *= factor
            ip.sink.set_feed_rate(ip.state.feed)

    def _target(self, name: str) -> int:
        """Return the line of a label; raise where it stands nowhere, or several times."""
        program = self.frames[-1].program
        if len(found := program.labelled(name)) > 1:
            places = " and ".join(str(program.lines[k].here.line) for k in found)
            message = f"LBL {name} stands {len(found)} times, in lines {places}"
            hint = "a label is set once; give the others other names"
            raise BlockError("label-repeated", message, "LBL", hint=hint)
        message = f"LBL {name} is called, and stands nowhere"
        return self.label(program, name, message, "LBL", f"LBL {name} begins what is run")

    def _contour(self, label: str) -> tuple[list[Segment], int]:
        """Return the contour of a subprogram, and the side of the tool: 1 by RL, -1 by RR, 0 by neither."""
        target = self._target(label.upper())
        self._settle()
        plain = Plain.of(self.ip)
        kept = plain.heading, plain.cycle
        self._side = 0
        try:
            frame = Frame(self.frames[-1].program, at=target + 1, part=True)
            return self.record(frame, f"LBL {label}", 17).segments[1:], self._side
        finally:
            self._side = None
            plain.heading, plain.cycle = kept


def _moves(block: Block) -> bool:
    return not (AXIS_INDEX.keys().isdisjoint(block.words) and {*_ARCS, Own.POLAR_LINE}.isdisjoint(block.g))


def behind_call(block: Block) -> list[Block]:
    """Take what acts at the end of a block that calls a cycle out of it, and return it."""
    first, *late = in_order(block, moves=True, calls=True)
    block.m = first.m
    return late


def in_order(block: Block, *, moves: bool, calls: bool = False) -> Iterator[Block]:
    """Yield a block without what acts at its end, and that, where one block of the interpreter has another order."""
    off, stops, ends = (tuple(number for number in block.m if number in lot) for lot in _AT_THE_END)
    if (off and moves) or (stops and ends) or (calls and (stops or ends)):
        yield replace(block, m=tuple(number for number in block.m if number not in (*off, *stops, *ends)))
        for lot in (off, stops, ends[:1]):
            if lot:
                yield block.beside({}, (), lot)
    else:
        yield block
