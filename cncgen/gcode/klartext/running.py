"""The order in which the lines of a program in plain language are executed, and the statements that lead from line to line."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import ClassVar

from cncgen.diagnostics import Severity
from cncgen.gcode.block import (
    AXES,
    AXIS_INDEX,
    CIRCLE,
    CYCLE_CALL,
    POLAR_ARC,
    POLAR_LINE,
    POLE,
    RADIUS_ARC,
    TIP,
    TIP_OFF,
    Block,
    Value,
    gather,
)
from cncgen.gcode.budget import LINE
from cncgen.gcode.codes.offsets import use_system
from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.codes.turning_profiles import Recorder, Segment
from cncgen.gcode.errors import BlockError, Stop
from cncgen.gcode.flow import recovery
from cncgen.gcode.flow.plain_lines import PlainLane
from cncgen.gcode.klartext import (
    contours,
    cycles,
    free_contours,
    lines,
    planes,
    points,
    programs,
    system_data,
)
from cncgen.gcode.klartext.datums import Datums
from cncgen.gcode.klartext.hole_cycle import FASTEST
from cncgen.gcode.klartext.program_text import UNREAD, ProgramText
from cncgen.gcode.sinks.sink import Point
from cncgen.gcode.source import open_source
from cncgen.gcode.state.systems import SYSTEM_COUNT
from cncgen.gcode.text import plain_language
from cncgen.gcode.text.evaluation import evaluate
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.line_runs import ProgramLines
from cncgen.gcode.text.plain_language import Statement
from cncgen.gcode.text.search import search_path

#: The cycle that names contours.
_CONTOUR_LABELS = 14
_FRAMES = (7, 8, 9, 10, 11, 19, 26, 247)
#: Where a subprogram leads back to that is read as a contour.
_END_OF_CONTOUR = -1
_ARCS = (CIRCLE, RADIUS_ARC, POLAR_ARC)
#: Cycles from this number on have their surface in Q203, and take M109 and M110 for their arcs on the control.
_OF_PARAMETERS = 200
#: The first letter of parameters, which follow a cycle.
_PARAMETER = ("Q", "q")
#: Codes of lines and arcs, to which a contour is approached and which corners join.
_DRAWN = frozenset(number / 10.0 for number in (0, 10, CIRCLE, RADIUS_ARC, POLAR_ARC, POLAR_LINE))


class HeidenhainRunner(ProgramText):
    """One run of a program in plain language."""

    dialect, ends_with = "heidenhain", "END PGM or M30"

    def _prepare(self) -> None:
        super()._prepare()
        self._lane = (
            PlainLane(self.ip, self.sources, self.plain, self._made) if self.plain and self.batches else None
        )
        self._calls: list[int] = []
        self._repeats: dict[int, int] = {}
        self._datums = Datums(self.ip, self._now)
        self._modal = False
        #: The part of the feed that M103 lets motions downwards have, 0 for all of it.
        self._plunge = 0.0
        self._globals: dict[int, float] = {}
        #: The pole of free contours, and end and direction of each motion, by its line.
        self._pole: complex | None = None
        self._ends: dict[int, free_contours.Known] = {}
        self._points: list[points.Place] = []
        #: The programs that SEL PGM and cycle 12 name.
        self._selected = self._program = ""
        self._beyond = 0
        #: The side of a contour that is read and not run, None where lines are run.
        self._side: int | None = None
        self._at = 0
        #: Programs that CALL PGM left, and the line where they go on.
        self._called: list[
            tuple[ProgramLines[Cursor], ProgramLines[str], dict[str, int], list[int], dict[int, int], int]
        ] = []

    def run(self) -> Iterator[None]:
        """Run to the end; yields now and then, so that rows can be taken away."""
        if not self._open():
            return
        self._read(self.sources[0])
        self.ip.begin()
        try:
            yield from self._run()
            self.ip.end_compensation()
        except Stop as stop:
            self._faults.here(stop.error)
        except BlockError as error:
            self._faults.here(error)
        if self._lines:
            self._check_end(self._lines[-1])

    def _run(self) -> Iterator[None]:
        self.ip.budget.forward = len(self._lines)
        while not self.ip.state.ended and (self._at < len(self._lines) or self._called):
            if self._at >= len(self._lines):
                self._return()
                continue
            if self._run_plain():
                yield
                continue
            at, self._at = self._at, self._at + 1
            self.ip.budget.count(1, LINE)
            if self.ip.budget.steps % 512 == 0:
                yield
            here = self._lines[at]
            self._enter(here)
            try:
                self._line(at, self._bodies[at])
            except BlockError as error:
                self._fail(here if error.at is None else self._lines[error.at], error)
                self._take_up(at)

    def _run_plain(self) -> bool:
        """Run plain lines in arrays; tell whether there were some."""
        if self._lane is None or self._modal or self._plunge or self._is_free:
            return False
        at, plain = self._at, Plain.of(self.ip)
        self._at = self._lane.run(self._lines, at, self.ip.budget.left(), plain.tool_feed)
        return self._at > at

    def _made(self, begin: list[float], motion: memoryview, end: memoryview, centre: memoryview) -> None:
        """Keep the direction in which the last of plain motions ends that goes along X or Y."""
        for row in range(len(motion) - 1, -1, -1):
            x, y = (end[row - 1, 0], end[row - 1, 1]) if row else begin[:2]
            way = complex(end[row, 0] - x, end[row, 1] - y)
            if way:
                Plain.of(self.ip).heading = way
                return

    def _take_up(self, at: int) -> None:
        """Stand where a line leads that failed, with its feed: arcs behind it were blamed for beginning elsewhere."""
        if self.ip.guard is not None:
            return
        words: dict[str, float] = {}
        for letter, value in plain_language.place(self._bodies[at]):
            with suppress(BlockError):
                words |= gather([(letter, evaluate(value, self.ip.parameters))]).words
        feed = words.pop("f", 0.0)
        if feed > 0.0:
            recovery.attempt(self.ip, Block({"f": feed}))
        recovery.stand(self.ip, Block(words))

    def _q(self, number: int) -> float:
        return float(self.ip.parameters.numbers[number])

    def _feed_word(self, word: str) -> float:
        """Return the feed that a Q parameter of a cycle is given by a word: FMAX, FAUTO."""
        if word == "MAX":
            return FASTEST
        feed = Plain.of(self.ip).tool_feed
        if feed <= 0.0:
            message = "AUTO takes the feed of TOOL CALL, which has none"
            raise BlockError("feed-missing", message, "AUTO", hint="TOOL CALL 5 Z S2000 F500")
        return feed

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

    def _line(self, at: int, body: str) -> None:
        """Execute a line."""
        if not body or body.startswith("*"):
            return
        statement = self._statement(at, body)
        run = self._RUNS.get(statement.kind)
        if self._called and statement.words in ([("m", 2.0)], [("m", 30.0)]):
            self._at = len(self._lines)
        elif run is not None:
            run(self, at, statement)
        else:
            self._plain(at, statement)

    # Jumps.

    def _pass_label(self, at: int, statement: Statement) -> None:
        """LBL 0 ends a subprogram; other labels are passed."""
        if statement.data[0] == "0" and self._calls:
            self._at = self._calls.pop()

    def _target(self, name: str) -> int:
        if name not in self._labels:
            message = f"LBL {name} is called, and stands nowhere"
            raise BlockError("label-missing", message, "LBL", hint=f"LBL {name} begins what is run")
        return self._labels[name]

    def _call(self, at: int, statement: Statement) -> None:
        """CALL LBL n: a subprogram to LBL 0; with REP m the lines from the label to here m times more."""
        name, times = statement.data
        target: int = self._target(name)
        if times is not None:
            if at not in self._repeats:
                self._repeats[at] = round(self._now(times))
            left = self._repeats[at]
            if left > 0:
                self._repeats[at] = left - 1
                self._at = target + 1
            else:
                self._repeats.pop(at, None)
            return
        if len(self._calls) >= self._options.max_call_depth:
            message = f"calls are nested more than {self._options.max_call_depth} deep"
            raise Stop(BlockError("call-depth", message, "CALL", hint="is the recursion without end?"))
        self._calls.append(at + 1)
        self._at = target + 1

    def _set(self, at: int, statement: Statement) -> None:
        """Set a Q parameter."""
        number, value = statement.data
        self.ip.parameters.set_number(number, self._now(value))

    def _set_feed(self, at: int, statement: Statement) -> None:
        """Set a Q parameter to a feed: FMAX, FAUTO."""
        number, word = statement.data
        self.ip.parameters.set_number(number, self._feed_word(word))

    def _take_global(self, at: int, statement: Statement) -> None:
        """Set a Q parameter to its value of GLOBAL DEF."""
        key = statement.data[0]
        if key not in self._globals:
            message = f"Q{key} = PREDEF takes a value that no GLOBAL DEF gives"
            hint = f"GLOBAL DEF 100 GENERAL ~ Q{key}=2"
            raise BlockError("cycle-words", message, "PREDEF", hint=hint)
        self.ip.parameters.set_number(float(key), self._globals[key])

    def _jump(self, at: int, statement: Statement) -> None:
        """FN 9 to FN 12."""
        holds, label = statement.data
        if self._now(holds):
            self._at = self._target(label) + 1

    def _read_data(self, at: int, statement: Statement) -> None:
        """FN 18."""
        number, *asked = statement.data
        group, place, index = (round(self._now(value or 0.0)) for value in asked)
        self.ip.parameters.set_number(number, system_data.read(self.ip, group, place, index))

    def _alarm(self, at: int, statement: Statement) -> None:
        message = f"the program raises an error: {self._bodies[at]}"
        raise Stop(BlockError("program-alarm", message, "FN", hint="FN 14 ends the program"))

    def _not_read(self, at: int, statement: Statement) -> None:
        hint = "FN 0 to FN 14, FN 18 and formulas of Q are read"
        raise BlockError("unsupported-block", f"FN {statement.data[0]} is not read", "FN", hint=hint)

    def _pass(self, at: int, statement: Statement) -> None:
        """What prints, sends or waits, and texts, which are not kept: statements that use one report it."""

    def _parameters(self, at: int, take: Callable[[Statement, int], None]) -> int:
        """Run the lines of parameters behind a cycle; return the first other line."""
        following = at + 1
        while following < len(self._bodies) and (
            not self._bodies[following] or self._bodies[following].startswith(_PARAMETER)
        ):
            if self._bodies[following]:
                try:
                    take(self._statement(following, self._bodies[following]), following)
                except BlockError as error:
                    self._fail(self._lines[following], error)
            following += 1
        return following

    def _take_parameter(self, statement: Statement, at: int) -> None:
        self._RUNS[statement.kind](self, at, statement)

    def _define_globals(self, at: int, statement: Statement) -> None:
        """GLOBAL DEF: keep the values that parameters of cycles take by PREDEF."""

        def take(given: Statement, following: int) -> None:
            number, value = given.data
            self._globals[int(number)] = self._feed_word(value) if given.kind == "feed" else self._now(value)

        self._at = self._parameters(at, take)

    def _call_named(self, at: int, statement: Statement) -> None:
        self._call_program(at, programs.bare(statement.data[0]))

    def _call_selected(self, at: int, statement: Statement) -> None:
        self._call_program(at, self._selected)

    def _call_program(self, at: int, name: str) -> None:
        """CALL PGM: another file, beside the program or in a folder of --include; its labels are its own."""
        if not name:
            message, hint = (
                "no program is named that is called",
                'SEL PGM "PART.H", or CYCL DEF 12.1 PGM PART.H, names it',
            )
            raise BlockError("sub-missing", message, "PGM", hint=hint)
        if len(self._called) >= self._options.max_call_depth:
            message = f"programs call each other more than {self._options.max_call_depth} deep"
            raise Stop(BlockError("call-depth", message, "CALL", hint="is the recursion without end?"))
        found = self._file(name, f"program {name} ({name}.H)", "PGM")
        self._called.append((self._lines, self._bodies, self._labels, self._calls, self._repeats, at + 1))
        self.sources.append(open_source(found, str(found)))
        self._begin_text(self.sources[-1])
        self._labels, self._calls, self._repeats, self._ends = {}, [], {}, {}
        self._read(self.sources[-1], len(self.sources) - 1)
        self._at = 0

    def _file(self, name: str, what: str, place: str) -> Path:
        """Return a file beside the program or in a folder of --include."""
        folders = search_path(self._path, self._options.include)
        found = programs.file_of(name, folders)
        if found is None:
            where = ", ".join(str(folder) for folder in folders) or "any folder"
            message, hint = f"there is no {what} in {where}", "--include adds a folder to the search path"
            raise BlockError("sub-missing", message, place, hint=hint)
        return found

    def _return(self) -> None:
        """Go on behind CALL PGM."""
        self._lines, self._bodies, self._labels, self._calls, self._repeats, self._at = self._called.pop()
        self._ends = {}

    # Contours.

    def _corner_after(self, at: int) -> tuple[str, float] | None:
        """Return the corner RND or CHF that the next line puts at the end of this one."""
        following = self._following(at)
        statement = self._ahead(following) if following is not None else UNREAD
        if statement.kind != "corner":
            return None
        kind, size = statement.data
        return (",r" if kind == "RND" else ",c"), self._now(size)

    def _check_corner(self, at: int, statement: Statement) -> None:
        kind = statement.data[0]
        before = next((k for k in range(at - 1, -1, -1) if self._bodies[k]), None)
        if before is None or not self._draws(before):
            raise BlockError(
                "corner-motion",
                f"{kind} has no element of a contour before it",
                kind,
                hint="an L or C block leads to the corner",
            )

    def _draws(self, at: int) -> bool:
        """Tell whether a line is an element of a contour, or is not read."""
        statement = self._ahead(at)
        return statement.kind in ("tangent", "free", UNREAD.kind) or _drawn(statement)

    def _block(self, at: int, words: Sequence[tuple[str, Value]]) -> Block:
        """Return words as a block, values known."""
        block = gather([(letter, evaluate(value, self.ip.parameters)) for letter, value in words])
        here = self._lines[at]
        block.source, block.line, block.offset = here.source, here.line, here.offset
        return block

    def _here(
        self, at: int, g: tuple[int, ...] = (), words: dict[str, float] | None = None, m: tuple[int, ...] = ()
    ) -> Block:
        """Return a block that stands at a line."""
        here = self._lines[at]
        return Block(words or {}, g, m, None, here.source, here.line, here.offset)

    def _plain(self, at: int, statement: Statement) -> None:
        """Execute a line of motions, tools and M functions."""
        marks = statement.marks
        if marks:
            self._modal = self._modal or "M89" in marks
            if "M103" in marks:
                self._plunge = self._now(marks["M103"]) / 100.0
        block = self._block(at, statement.words)
        usual = contours.plunge(self.ip, block, self._plunge)
        called = CYCLE_CALL in block.g
        if called:
            block.g = tuple(number for number in block.g if number != CYCLE_CALL)
            self._modal = False
        if self.ip.state.compensation != 40 and "R0" in marks and not {410, 420} & set(block.g):
            self._execute(Block({}, (400,), (), None, 0, block.line, block.offset))
        moves = not AXIS_INDEX.keys().isdisjoint(block.words) or any(
            number in (*_ARCS, POLAR_LINE) for number in block.g
        )
        if moves:
            corner = self._corner_after(at)
            if corner is not None:
                block.words[corner[0]] = corner[1]
        self._move(block)
        if usual is not None:
            self._execute(Block({"f": usual}, (), (), None, block.source, block.line, block.offset))
        if moves and self._is_free:
            self._ends[at] = complex(*self.ip.state.position[:2]), Plain.of(self.ip).heading
        if "t" in block.words:
            self._tell_tool()
        if called or (self._modal and moves):
            self._call_cycle(at, block)

    def _call_cycle(self, at: int, block: Block) -> None:
        """Run the cycle at the tool's place, or the program of cycle 12 from there on."""
        if Plain.of(self.ip).cycle == programs.CYCLE and not self._modal:
            self._call_program(at, self._program)
        else:
            if self.ip.contour_feed and Plain.of(self.ip).cycle >= _OF_PARAMETERS:
                message = "M109 and M110 do not act on the arcs of cycles here: their feed is that of the tool's centre"
                hint = "the path is not changed by it"
                self.ip.warn_once(BlockError("feed-function", message, "M109", hint=hint))
            cycles.call(self.ip, Block({}, (), (), None, 0, block.line, block.offset))

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
            plain.heading = way

    def _execute(self, block: Block) -> None:
        if self._side is not None:
            for number in block.g:
                self._side = self._side or {410: 1, 420: -1}.get(number, 0)
            block = replace(block, g=tuple(number for number in block.g if number not in (400, 410, 420)))
        if self.ip.guard is not None:
            self.ip.base.block = block
            self.ip.guard(self.ip, block)
        if block.words or block.g or block.m:
            self.ip.execute(block)

    def _tangent(self, at: int, statement: Statement) -> None:
        """CT X Y, CTP PR PA: an arc that goes on in the direction before."""
        block = self._block(at, statement.words)
        if statement.data[0]:
            contours.take_polar_end(self.ip, block.words)
        side = tuple(number for number in block.g if number in (410, 420))
        corner = self._corner_after(at)
        if side or self.ip.guard is not None:
            self._execute(Block({}, side, (), None, 0, block.line, block.offset))
        if "f" in block.words:
            self._execute(Block({"f": block.words["f"]}, (), (), None, 0, block.line, block.offset))
        end, centre, sense = contours.tangent_arc(self.ip, block.words)
        plain = Plain.of(self.ip)
        pole, plane = plain.pole, plain.plane
        plain.pole, plain.plane = centre, 17
        words = {"xyzabcuvw"[k]: end[k] for k in range(9) if end[k] != self.ip.state.position[k]}
        words["dr"] = float(sense)
        if corner is not None:
            words[corner[0]] = corner[1]
        try:
            self._execute(Block(words, (CIRCLE,), block.m, None, 0, block.line, block.offset))
        finally:
            plain.pole, plain.plane = pole, plane

    def _way(self, at: int, statement: Statement) -> None:
        """APPR and DEP."""
        kind, form, words = statement.data
        way = contours.way_of(kind, form, words, self._now)
        here = self._here(at)
        self._execute(here)
        if way.kind == "APPR":
            contours.approach(self.ip, way, here, self._leads(at))
        else:
            contours.departure(self.ip, way, here)
        if way.m:
            self._execute(self._here(at, m=tuple(way.m)))

    def _contour(self, label: str) -> tuple[list[Segment], int]:
        """Return the contour of a subprogram, and the side of the tool: 1 by RL, -1 by RR, 0 by neither."""
        target = self._target(label.upper())
        if _END_OF_CONTOUR in self._calls:
            message = f"LBL {label} is read as a contour where a contour is read, by a cycle that it calls"
            raise BlockError(
                "call-depth", message, "CYCL", hint="a contour is drawn, and calls no cycle of contours"
            )
        self._execute(Block({}, (), (), None, 0, 0, 0))
        ip, plain = self.ip, Plain.of(self.ip)
        kept = ip.state, ip.sink, self._at, plain.heading, plain.cycle
        recorder = Recorder(ip.state.position, 17)
        ip.state = replace(
            ip.state, position=ip.state.position.copy(), feed=1.0, feed_mode=94, compensation=40
        )
        ip.sink, self._at, self._side = recorder, target + 1, 0
        self._calls.append(_END_OF_CONTOUR)
        try:
            while 0 <= self._at < len(self._lines):
                at, self._at = self._at, self._at + 1
                ip.budget.count(1, LINE)
                self._line(at, self._bodies[at])
            self._execute(Block({}, (), (), None, 0, 0, 0))
            return recorder.segments[1:], self._side
        finally:
            if _END_OF_CONTOUR in self._calls:
                del self._calls[self._calls.index(_END_OF_CONTOUR) :]
            ip.guard, self._side = None, None
            ip.state, ip.sink, self._at, plain.heading, plain.cycle = kept

    def _leads(self, at: int) -> Callable[[Point], complex | None] | None:
        """Return what gives the direction in which the first element behind APPR leaves a point, past corners and poles, which are taken."""
        following = self._following(at)
        while following is not None:
            statement = self._ahead(following)
            if statement.kind in ("free", "select"):
                elements = self._elements(following)
                if elements:
                    return partial(free_contours.first_heading, elements)
            elif ("g", POLE / 10.0) in statement.words:
                self._plain(following, statement)
            elif statement.kind not in ("corner", "label"):
                return partial(self._heading, following, statement) if _drawn(statement) else None
            following = self._following(following)
        return None

    def _heading(self, at: int, statement: Statement, start: Point) -> complex | None:
        """Return the direction in which a block leaves a point."""
        return contours.first_heading(self.ip, start, partial(self._block, at, statement.words))

    def _elements(self, at: int) -> list[free_contours.Element]:
        """Return the elements of a free contour from a line on."""
        elements: list[free_contours.Element] = []
        pole = self._pole
        following: int | None = at
        while following is not None:
            statement = self._ahead(following)
            if statement.kind == "select":
                if not elements:
                    message = "FSELECT has no element before it whose solution it chooses"
                    raise BlockError(
                        "free-contour", message, "FSELECT", hint="it stands behind FL, FLT, FC or FCT"
                    )
                elements[-1].select = statement.data[0]
            elif statement.kind == "free":
                head, words = statement.data
                element = free_contours.element_of(head, words, following, self._now, self._number(following))
                if head == "FPOL":
                    pole = complex(element.values.get("X", 0.0), element.values.get("Y", 0.0))
                else:
                    element.pole = pole
                    elements.append(element)
            elif statement.kind != "corner":
                break
            following = self._following(following)
        self._beyond = len(self._bodies) if following is None else following
        self._pole = pole
        return elements

    def _known(self, number: int) -> free_contours.Known | None:
        """Return end and direction of the motion that a block of the text made last."""
        return next(
            (self._ends[k] for k in sorted(self._ends, reverse=True) if self._number(k) == number), None
        )

    def _free(self, at: int, statement: Statement) -> None:
        """FPOL, FL, FLT, FC, FCT: a free contour, as lines and arcs."""
        plain, state = Plain.of(self.ip), self.ip.state
        try:
            elements = self._elements(at)
        finally:
            self._at = max(self._at, self._beyond)
        start = complex(state.position[0], state.position[1])
        chain = free_contours.Chain(elements, start, plain.heading, self._known)
        for element, segment in zip(elements, chain.solve(), strict=True):
            count = next((most for one, most in chain.chosen if one is element), 0)
            block = self._block(element.at, plain_language.line(element.rest))
            corner = self._corner_after(element.at)
            block.words |= {"x": segment.end.real, "y": segment.end.imag}
            if segment.centre is not None:
                spoke = segment.centre - segment.start
                block.words |= {"i": spoke.real, "j": spoke.imag}
            if corner is not None:
                block.words[corner[0]] = corner[1]
            block.g = (*block.g, {0: 10, 1: 30, -1: 20}[segment.spin])
            if count:
                self._tell_choice(element, segment, count)
            self._execute(block)
            plain.heading = segment.heading(segment.end)
            self._ends[element.at] = segment.end, plain.heading

    def _tell_choice(self, element: free_contours.Element, segment: Segment, count: int) -> None:
        """Warn of a solution that FSELECT chose."""
        here = self._lines[element.at]
        self.ip.base.block = Block({}, source=here.source, line=here.line, offset=here.offset)
        self.ip.warn(free_contours.choice_of(element, segment, count), Severity.WARNING)

    # Cycles.

    def _take_pattern(self, at: int, statement: Statement) -> None:
        """PATTERN DEF: take the points that CYCL CALL PAT visits."""
        parts = list(statement.data)
        while self._at < len(self._bodies) and (more := self._ahead(self._at)).kind == "pattern_more":
            parts, self._at = [*parts, *more.data], self._at + 1
        self._points = []
        self._points = points.places(parts, self._now)

    def _call_pattern(self, at: int, statement: Statement) -> None:
        """CYCL CALL PAT: run the cycle at each point, at the feed of the block on the way to it."""
        if not self._points:
            message = "CYCL CALL PAT has no pattern to visit"
            raise BlockError(
                "cycle-missing",
                message,
                "CYCL",
                hint="PATTERN DEF POS1 (X+10 Y+10 Z+0) defines one; tables of points are not read",
            )
        for place, above in self._points:
            block = self._block(at, statement.words)
            block.words |= {"x": place.real, "y": place.imag}
            self._move(block)
            with self._raised(above):
                cycles.call(self.ip, Block({}, (), (), None, 0, block.line, block.offset))

    @contextmanager
    def _raised(self, above: float) -> Iterator[None]:
        """Raise the surface of the cycle that is called."""
        q = self.ip.parameters.numbers
        surface = q[203]
        q[203] = surface + above
        try:
            yield
        finally:
            q[203] = surface

    def _call_at(self, at: int, statement: Statement) -> None:
        """CYCL CALL POS: the cycle at a place, whose Z shifts the cycle; from below its clearance the tool rises first."""
        block = self._block(at, statement.words)
        q, above = self.ip.parameters.numbers, 0.0
        if Plain.of(self.ip).cycle >= _OF_PARAMETERS and "z" in block.words:
            above = block.words.pop("z")
            clearance = q[203] + above + q[200]
            if self.ip.state.position[2] < clearance:
                way = {name: value for name, value in block.words.items() if name not in AXES}
                self._move(replace(block, words={**way, "z": clearance}, m=()))
        self._move(block)
        with self._raised(above):
            self._call_cycle(at, block)

    def _cycle(self, at: int, statement: Statement) -> None:
        """CYCL DEF."""
        number, part, rest = statement.data
        try:
            self._part(at, number, part, rest)
        except BlockError as error:
            self._point(at, rest, error)
            raise

    def _part(self, at: int, number: int, part: str | None, rest: str) -> None:
        if number == 32:
            self._plain(at, Statement("block", plain_language.tolerance(rest) if part == "1" else []))
        elif number == _CONTOUR_LABELS:
            plain = Plain.of(self.ip)
            plain.contour = self._contour
            plain.labels = [] if part in (None, "0") else [*plain.labels, *lines.labels_of(rest)]
        elif number == programs.CYCLE:
            Plain.of(self.ip).cycle = number
            self._program = programs.of_cycle(rest) if part == "1" else ""
        elif number in _FRAMES:
            self._frame(at, number, part, rest)
        elif part is not None:
            cycles.take_part(self.ip, number, int(part), rest)
        else:
            self._define(at, number)

    def _define(self, at: int, number: int) -> None:
        """Take a cycle; a pattern runs once its Q parameters are read."""
        before = Plain.of(self.ip).cycle
        cycles.define(self.ip, number)
        self._at = self._parameters(at, self._take_parameter)
        if number in cycles.PATTERNS:
            here = self._lines[at]
            cycles.pattern(self.ip, number, before, Block({}, (), (), None, 0, here.line, here.offset))

    def _frame(self, at: int, number: int, part: str | None, rest: str) -> None:
        """Frames (`datums`), 9 dwell, 247 preset."""
        if number == 247:
            self._preset(at)
        elif number == 9:
            seconds = [v for _, v in plain_language.words_of(rest) if v == v] if part == "1" else []
            if seconds:
                self._execute(self._here(at, (40,), {"p": self._now(seconds[0])}))
        elif part == "1" or (part not in (None, "0") and number != 19):
            self._datums.of_cycle(number, rest)
        elif number == 8:
            following = self._following(at)
            behind = self._ahead(following).data if following is not None else ()
            if behind[:2] != (8, "1") or not behind[2]:
                self._datums.take(8, None)

    def _function(self, at: int, statement: Statement) -> None:
        """FUNCTION TCPM puts M128 in force, FUNCTION RESET TCPM ends it; others change nothing, or are not read."""
        body = f"FUNCTION {statement.data[0]}"
        if planes.TIP_ON.match(body) or planes.TIP_OFF.match(body):
            self._execute(self._here(at, (TIP if planes.TIP_ON.match(body) else TIP_OFF,)))
            return
        if planes.PAUSES.match(body):
            self.ip.warn_once(planes.no_pauses(), Severity.WARNING)
        else:
            planes.idle(body)

    def _dwell(self, at: int, statement: Statement) -> None:
        """FUNCTION DWELL."""
        unit, value = statement.data
        self._execute(
            self._here(at, (40,), {"p": planes.dwell_s(unit, self._now(value), self.ip.state.speed)})
        )

    def _plane(self, at: int, statement: Statement) -> None:
        """PLANE."""
        kind, *words = statement.data
        self._datums.plane(kind.upper(), words)

    def _transform(self, at: int, statement: Statement) -> None:
        """TRANS DATUM, MIRROR, ROTATION, SCALE of TNC 7."""
        kind, *words = statement.data
        self._datums.transform(kind.upper(), words)

    def _select_program(self, at: int, statement: Statement) -> None:
        """SEL PGM."""
        self._selected = programs.bare(statement.data[0])

    def _select_pattern(self, at: int, statement: Statement) -> None:
        """SEL PATTERN."""
        name, text = self._text(programs.bare(statement.data[0]), "table of points")
        self._points = points.of_table(text, name)

    def _select_table(self, at: int, statement: Statement) -> None:
        """SEL TABLE."""
        name, text = self._text(programs.bare(statement.data[0]), "table of datums")
        self._datums.choose(text, name)

    def _text(self, name: str, what: str) -> tuple[str, str]:
        """Return the name of the file of a table, and its text."""
        found = self._file(name, f"{what} {name}", "SEL")
        return found.name, bytes(open_source(found, str(found)).data[:]).decode("utf-8", "replace")

    def _preset(self, at: int) -> None:
        """247: the preset Q339; numbers 1 to 9 are the origins G54 to G59.3 of the parameter file."""
        self._at = self._parameters(at, self._take_parameter)
        number = round(self._q(339))
        if 1 <= number <= SYSTEM_COUNT:
            use_system(self.ip, number)
        elif number:
            # Of other presets only the control knows the place.
            use_system(self.ip, 1)
            message = f"preset {number} is taken as G54: presets 1 to {SYSTEM_COUNT} are G54 to G59.3"
            hint = "--parameters sets origins"
            self.ip.warn(BlockError("preset-unknown", message, "CYCL", hint=hint), Severity.WARNING)

    _RUNS: ClassVar[dict[str, Callable[[HeidenhainRunner, int, Statement], None]]] = {
        "label": _pass_label,
        "call": _call,
        "set": _set,
        "feed": _set_feed,
        "predefined": _take_global,
        "jump": _jump,
        "system_data": _read_data,
        "alarm": _alarm,
        "function_unknown": _not_read,
        "passed": _pass,
        "global_def": _define_globals,
        "call_program": _call_named,
        "call_selected": _call_selected,
        "select_program": _select_program,
        "select_pattern": _select_pattern,
        "select_table": _select_table,
        "corner": _check_corner,
        "way": _way,
        "free": _free,
        "select": _free,
        "tangent": _tangent,
        "cycle": _cycle,
        "call_at": _call_at,
        "call_pattern": _call_pattern,
        "pattern_def": _take_pattern,
        "plane": _plane,
        "dwell": _dwell,
        "transform": _transform,
        "function_block": _function,
    }


def _drawn(statement: Statement) -> bool:
    """Tell whether a block is a line or an arc."""
    return statement.kind == "block" and any(word[0] == "g" and word[1] in _DRAWN for word in statement.words)
