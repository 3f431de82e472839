"""The order in which the lines of a program in plain language are executed, and the statements that lead from line to line."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

from cncgen.diagnostics import Severity
from cncgen.gcode.block import (
    AXIS_INDEX,
    CIRCLE,
    CYCLE_CALL,
    POLAR_ARC,
    POLAR_LINE,
    RADIUS_ARC,
    TIP,
    TIP_OFF,
    Block,
    Parsed,
    gather,
)
from cncgen.gcode.budget import LINE
from cncgen.gcode.codes.offsets import use_system
from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.codes.turning_profiles import Recorder, Segment
from cncgen.gcode.errors import BlockError, Stop
from cncgen.gcode.flow.language_run import LanguageRun
from cncgen.gcode.klartext import (
    contours,
    cycles,
    free_contours,
    lines,
    planes,
    points,
    programs,
    q_formulas,
    system_data,
)
from cncgen.gcode.klartext.datums import Datums
from cncgen.gcode.klartext.hole_cycle import FASTEST
from cncgen.gcode.sinks.sink import Point
from cncgen.gcode.source import Source, open_source
from cncgen.gcode.state.systems import SYSTEM_COUNT
from cncgen.gcode.text import plain_language
from cncgen.gcode.text.evaluation import evaluate
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.search import search_path

_LABEL = re.compile(r"LBL\s*(?:\"(?P<name>[^\"]*)\"|(?P<number>\w+))\s*\Z", re.IGNORECASE)
_CALL = re.compile(
    r"CALL\s+LBL\s*(?:\"(?P<name>[^\"]*)\"|(?P<number>\w+))(?:\s+REP\s*(?:(?P<times>\d{1,99}|Q\d+)(?:/\d+)?|/)?)?\s*\Z",
    re.IGNORECASE,
)
_CORNER = re.compile(
    r"(?P<kind>RND|CHF)\s*R?\s*(?P<size>(?:[-+]\s*)?(?:Q\d+|\d++[.,]?+\d*+|[.,]\d+))(?:\s*F\s*(?:AUTO|Q?[\d.,]+))?\s*\Z",
    re.IGNORECASE,
)
_DEFINITION = re.compile(
    r"CYCL\s+DEF\s*(?P<number>\d{1,99})(?:\s*\.(?P<part>\d{1,99}))?(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL
)
_TANGENT = re.compile(r"CT(?:(?P<polar>P(?=[\sPI]))|(?=[\sXYZI]))(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL)
_PLACE = re.compile(r"CYCL\s+CALL\s+POS\b(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL)
_PATTERN = re.compile(r"CYCL\s+CALL\s+PAT\b(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL)
_VALUE = re.compile(r"\s*((?:[-+]\s*)?(?:Q\d+|\d++[.,]?+\d*+|[.,]\d+))")
_END_OF_PROGRAM = re.compile(r"END\s+PGM\b|(?:L\s+)?(?:M0?2|M30)\s*\Z", re.IGNORECASE)
#: The cycle that names contours.
_CONTOUR_LABELS = 14
_FRAMES = (7, 8, 9, 10, 11, 19, 26, 247)
#: The axes of a mirror image, which without them is ended.
_MIRRORED = re.compile(r"CYCL\s+DEF\s+8\.1\s*\S", re.IGNORECASE)
#: Where a subprogram leads back to that is read as a contour.
_END_OF_CONTOUR = -1
_ARCS = (CIRCLE, RADIUS_ARC, POLAR_ARC)
_CALLED = CYCLE_CALL / 10.0
_MODAL = re.compile(r"\bM89\b", re.IGNORECASE)
_PREDEF = re.compile(r"Q(?P<number>\d{1,4})\s*=\s*PREDEF\s*\Z", re.IGNORECASE)
_GLOBAL = re.compile(r"Q(?P<number>\d{1,4})\s*=(?P<value>.*)\Z", re.IGNORECASE)
_SIDE_OFF = re.compile(r"\bR0\b(?![.\d])", re.IGNORECASE)


class HeidenhainRunner(LanguageRun):
    """One run of a program in plain language."""

    dialect, ends_with = "heidenhain", "END PGM or M30"

    def _prepare(self) -> None:
        self._lines: list[Cursor] = []
        self._bodies: list[str] = []
        self._labels: dict[str, int] = {}
        self._calls: list[int] = []
        self._repeats: dict[int, int] = {}
        self._parsed: dict[str, Parsed] = {}
        self._datums = Datums(self.ip, self._value)
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
            tuple[list[Cursor], list[str], dict[str, int], list[int], dict[int, int], int]
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

    def _read(self, source: Source, index: int = 0) -> None:
        """Take the lines, their text without numbers and comments, and the labels."""
        for offset, number, bare, below in lines.bodies(source, block_delete=self._options.block_delete):
            if below:
                self._bodies[-1] += f" {bare}"
            for own in () if below else self._said(bare):
                label = _LABEL.match(own)
                if label:
                    name = (label["name"] if label["name"] is not None else label["number"]).upper()
                    if name != "0":
                        self._labels.setdefault(name, len(self._lines))
                self._lines.append(Cursor(index, offset, number))
                self._bodies.append(own)

    def _said(self, bare: str) -> list[str]:
        """Return a line as blocks, its parameters of a cycle apart."""
        return lines.apart(bare)

    def _run(self) -> Iterator[None]:
        self.ip.budget.forward = len(self._lines)
        while not self.ip.state.ended and (self._at < len(self._lines) or self._called):
            if self._at >= len(self._lines):
                self._return()
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

    def _q(self, number: int) -> float:
        numbers = self.ip.parameters.numbers
        if number >= len(numbers):
            message = f"Q{number} is not read: Q parameters go up to Q{len(numbers) - 1}"
            raise BlockError("parameter-number", message, "Q", hint="take a smaller number")
        return float(numbers[number])

    def _feed_word(self, word: str) -> float:
        """Return the feed that a Q parameter of a cycle is given by a word: FMAX, FAUTO."""
        if word == "MAX":
            return FASTEST
        feed = Plain.of(self.ip).tool_feed
        if feed <= 0.0:
            message = "AUTO takes the feed of TOOL CALL, which has none"
            raise BlockError("feed-missing", message, "AUTO", hint="TOOL CALL 5 Z S2000 F500")
        return feed

    def _value(self, text: str) -> float:
        return q_formulas.formula(text.replace(",", "."), self._q)

    def _line(self, at: int, body: str) -> None:
        """Execute a line."""
        if not body or body.startswith("*"):
            return
        head = body[:4].upper()
        if head.startswith("LBL") and _LABEL.match(body):
            self._pass_label(at, body)
        elif head == "CALL" and _CALL.match(body):
            self._call(at, body)
        elif free_contours.BEGINS.match(body):
            self._free(at)
        elif head.startswith(("FN", "Q")):
            self._set(at, body)
        elif head.startswith(("RND", "CHF")):
            self._check_corner(at, body)
        elif head in ("APPR", "DEP ", "DEP\t"):
            self._way(at, body)
        elif head == "CYCL":
            self._cycle(at, body)
        elif head.startswith("CT") and _TANGENT.match(body):
            self._tangent(at, body)
        elif head == "PLAN":
            self._datums.plane(body)
        elif head == "PATT" and points.BEGINS.match(body):
            self._take_pattern(at, body)
        elif head == "FUNC":
            self._function(body)
        elif head == "GLOB" and re.match(r"GLOBAL\s+DEF\b", body, re.IGNORECASE):
            self._define_globals(at)
        elif head in ("TRAN", "SEL ") and self._transformed(body):
            return
        elif head == "CALL" and (name := self._program_of(body)) is not None:
            self._call_program(at, name)
        elif self._called and _END_OF_PROGRAM.match(body):
            self._at = len(self._lines)
        else:
            self._plain(at, body)

    # Jumps.

    def _pass_label(self, at: int, body: str) -> None:
        """LBL 0 ends a subprogram; other labels are passed."""
        label = _LABEL.match(body)
        assert label
        if label["number"] == "0" and self._calls:
            self._at = self._calls.pop()

    def _target(self, name: str) -> int:
        if name not in self._labels:
            message = f"LBL {name} is called, and stands nowhere"
            raise BlockError("label-missing", message, "LBL", hint=f"LBL {name} begins what is run")
        return self._labels[name]

    def _call(self, at: int, body: str) -> None:
        """CALL LBL n: a subprogram to LBL 0; with REP m the lines from the label to here m times more."""
        match = _CALL.match(body)
        assert match
        name = (match["name"] if match["name"] is not None else match["number"]).upper()
        target = self._target(name)
        if match["times"] is not None:
            left = self._repeats.get(at, round(self._value(match["times"])))
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

    def _set(self, at: int, body: str) -> None:
        """Set a Q parameter, or jump by FN 9 to FN 12."""
        jump = q_formulas.jump(body, self._q)
        if jump is not None:
            holds, label = jump
            if holds:
                self._at = self._target(label) + 1
            return
        wanted = _PREDEF.match(body)
        if wanted:
            key = int(wanted["number"])
            if key not in self._globals:
                message = f"Q{key} = PREDEF takes a value that no GLOBAL DEF gives"
                hint = f"GLOBAL DEF 100 GENERAL ~ Q{key}=2"
                raise BlockError("cycle-words", message, "PREDEF", hint=hint)
            self.ip.parameters.set_number(float(key), self._globals[key])
            return
        found = q_formulas.assignment(body, self._q, self._feed_word)
        if found is not None:
            number, value = found
            self.ip.parameters.set_number(number, value)
            return
        if q_formulas.function_number(body) == 18:
            number, value = system_data.read(self.ip, body, self._value)
            self.ip.parameters.set_number(float(number), value)
            return
        q_formulas.pass_over(body)

    def _define_globals(self, at: int) -> None:
        """GLOBAL DEF: keep the values that parameters of cycles take by PREDEF."""
        while self._at < len(self._bodies) and (given := _GLOBAL.match(self._bodies[self._at])):
            word = given["value"].strip().upper()
            value = self._feed_word(word) if word in ("MAX", "AUTO") else self._value(given["value"])
            self._globals[int(given["number"])] = value
            self._at += 1

    def _program_of(self, body: str) -> str | None:
        """Return the name of the program that CALL PGM or CALL SELECTED PGM calls, None where the line is neither."""
        match = programs.CALL.match(body)
        if match:
            return programs.bare(match["name"])
        return self._selected if programs.SELECTED.match(body) else None

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
        self._lines, self._bodies, self._labels, self._calls, self._repeats = [], [], {}, [], {}
        self._ends = {}
        self.sources.append(open_source(found, str(found)))
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

    def _following(self, at: int) -> int | None:
        """Return the next line that is not a comment."""
        return next(
            (
                k
                for k in range(at + 1, len(self._bodies))
                if self._bodies[k] and not self._bodies[k].startswith("*")
            ),
            None,
        )

    def _corner_after(self, at: int) -> tuple[str, float] | None:
        """Return the corner RND or CHF that the next line puts at the end of this one."""
        following = self._following(at)
        match = _CORNER.match(self._bodies[following]) if following is not None else None
        if match is None:
            return None
        return (",r" if match["kind"].upper() == "RND" else ",c"), self._value(match["size"])

    def _check_corner(self, at: int, body: str) -> None:
        if _CORNER.match(body) is None:
            message = f"{body[:3].upper()} has no size that is read"
            raise BlockError("syntax", message, body[:3].upper(), hint="RND R5, CHF 2")
        before = next((k for k in range(at - 1, -1, -1) if self._bodies[k]), None)
        if before is None or not re.match(
            r"(?:L|C|CR|CT|CP|LP|LN|FLT?|FCT?)\b|[GXYZHI]", self._bodies[before], re.IGNORECASE
        ):
            raise BlockError(
                "corner-motion",
                f"{body[:3].upper()} has no element of a contour before it",
                body[:3].upper(),
                hint="an L or C block leads to the corner",
            )

    def _block(self, at: int, body: str) -> Block:
        """Return a line of the plain language as a block, values known."""
        parsed = self._parsed.get(body)
        if parsed is None:
            parsed = plain_language.parse(body)
            if len(self._parsed) < 4096:
                self._parsed[body] = parsed
        for target, value in parsed.settings:
            assert not isinstance(target, str)
            self.ip.parameters.set_number(
                evaluate(target, self.ip.parameters), evaluate(value, self.ip.parameters)
            )
        block = gather([(letter, evaluate(value, self.ip.parameters)) for letter, value in parsed.words])
        here = self._lines[at]
        return replace(block, source=here.source, line=here.line, offset=here.offset)

    def _plain(self, at: int, body: str) -> None:
        """Execute a line of motions, tools and M functions."""
        if _MODAL.search(body):
            self._modal = True
            body = _MODAL.sub("   ", body)
        body, self._plunge = contours.plunge_of(body, self._plunge, self._value)
        block = self._block(at, body)
        usual = contours.plunge(self.ip, block, self._plunge)
        called = CYCLE_CALL in block.g
        if called:
            block.g = tuple(number for number in block.g if number != CYCLE_CALL)
            self._modal = False
        if self.ip.state.compensation != 40 and _SIDE_OFF.search(body) and not {410, 420} & set(block.g):
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
        if moves:
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

    def _tangent(self, at: int, body: str) -> None:
        """CT X Y, CTP PR PA: an arc that goes on in the direction before."""
        match = _TANGENT.match(body)
        assert match
        block = self._block(at, f"{'LP' if match['polar'] else 'L'} {match['rest']}")
        if match["polar"]:
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

    def _way(self, at: int, body: str) -> None:
        """APPR and DEP."""
        way = contours.way_of(body, self._value)
        if way is None:
            raise BlockError(
                "unsupported-block",
                f"{body.split()[0].upper()} is not read in this form",
                body.split()[0].upper(),
                hint="LT, LN, CT and LCT are",
            )
        here = Block({}, (), (), None, 0, self._lines[at].line, self._lines[at].offset)
        self._execute(here)
        if way.kind == "APPR":
            contours.approach(self.ip, way, here, self._leads(at))
        else:
            contours.departure(self.ip, way, here)
        if way.m:
            self._execute(Block({}, (), tuple(way.m), None, 0, here.line, here.offset))

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
            body = self._bodies[following]
            if free_contours.BEGINS.match(body):
                elements = self._elements(following)
                if elements:
                    return partial(free_contours.first_heading, elements)
            elif re.match(r"CC\b", body, re.IGNORECASE):
                self._plain(following, body)
            elif not (_CORNER.match(body) or _LABEL.match(body)):
                if not re.match(r"(?:L|C|CR|CP|LP)\b", body, re.IGNORECASE):
                    return None
                return partial(self._heading, following, body)
            following = self._following(following)
        return None

    def _heading(self, at: int, body: str, start: Point) -> complex | None:
        """Return the direction in which a block leaves a point."""
        return contours.first_heading(self.ip, start, partial(self._block, at, body))

    def _elements(self, at: int) -> list[free_contours.Element]:
        """Return the elements of a free contour from a line on."""
        elements: list[free_contours.Element] = []
        pole = self._pole
        following: int | None = at
        while following is not None:
            body = self._bodies[following]
            choice = free_contours.SELECTS.match(body)
            if choice:
                if not elements:
                    message = "FSELECT has no element before it whose solution it chooses"
                    raise BlockError(
                        "free-contour", message, "FSELECT", hint="it stands behind FL, FLT, FC or FCT"
                    )
                elements[-1].select = int(choice["number"])
            elif free_contours.BEGINS.match(body):
                element = free_contours.element_of(body, following, self._value, self._number(following))
                if body.upper().startswith("FPOL"):
                    pole = complex(element.values.get("X", 0.0), element.values.get("Y", 0.0))
                else:
                    element.pole = pole
                    elements.append(element)
            elif not _CORNER.match(body):
                break
            following = self._following(following)
        self._beyond = len(self._bodies) if following is None else following
        self._pole = pole
        return elements

    def _number(self, at: int) -> int:
        """Return the number of a block in the text, 0 where it has none."""
        here = self._lines[at]
        digits = re.match(r"\s*/?\s*(\d{1,9})\s", self.sources[here.source].text_at(here.offset))
        return int(digits[1]) if digits else 0

    def _known(self, number: int) -> free_contours.Known | None:
        """Return end and direction of the motion that a block of the text made last."""
        return next(
            (self._ends[k] for k in sorted(self._ends, reverse=True) if self._number(k) == number), None
        )

    def _free(self, at: int) -> None:
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
            block = self._block(element.at, f"L {element.rest}" if element.rest.strip() else "")
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

    def _take_pattern(self, at: int, body: str) -> None:
        """PATTERN DEF: take the points that CYCL CALL PAT visits."""
        self._points = []
        while self._at < len(self._bodies) and points.GOES_ON.match(self._bodies[self._at]):
            body, self._at = f"{body} {self._bodies[self._at]}", self._at + 1
        self._points = points.places(body, self._value)

    def _call_pattern(self, at: int, rest: str) -> None:
        """CYCL CALL PAT: run the cycle at each point, at the feed of the block on the way to it."""
        if not self._points:
            message = "CYCL CALL PAT has no pattern to visit"
            raise BlockError(
                "cycle-missing",
                message,
                "CYCL",
                hint="PATTERN DEF POS1 (X+10 Y+10 Z+0) defines one; tables of points are not read",
            )
        q = self.ip.parameters.numbers
        surface = q[203]
        for place, above in self._points:
            block = self._block(at, f"L X{place.real:.9f} Y{place.imag:.9f} {rest}")
            self._move(block)
            q[203] = surface + above
            try:
                cycles.call(self.ip, Block({}, (), (), None, 0, block.line, block.offset))
            finally:
                q[203] = surface

    def _cycle(self, at: int, body: str) -> None:
        visits = _PATTERN.match(body)
        if visits:
            self._call_pattern(at, visits["rest"])
            return
        place = _PLACE.match(body)
        if place:
            block = self._block(at, f"L {place['rest']} FMAX")
            self._move(block)
            self._call_cycle(at, block)
            return
        match = _DEFINITION.match(body)
        number = int(match["number"]) if match else 0
        if match is None or number == 32:
            self._plain(at, body)
        elif number == _CONTOUR_LABELS:
            plain = Plain.of(self.ip)
            plain.contour = self._contour
            plain.labels = (
                [] if match["part"] in (None, "0") else [*plain.labels, *lines.labels_of(match["rest"])]
            )
        elif number == programs.CYCLE:
            Plain.of(self.ip).cycle = number
            self._program = programs.of_cycle(match["rest"]) if match["part"] == "1" else ""
        elif number in _FRAMES:
            self._frame(at, number, match["part"], match["rest"])
        elif match["part"] is not None:
            cycles.take_part(self.ip, number, int(match["part"]), match["rest"], self._value)
        else:
            self._define(at, number)

    def _define(self, at: int, number: int) -> None:
        """Take a cycle; a pattern runs once its Q parameters are read."""
        before = Plain.of(self.ip).cycle
        cycles.define(self.ip, number)
        following = at + 1
        while following < len(self._bodies) and re.match(
            r"Q\d+\s*=|\Z", self._bodies[following], re.IGNORECASE
        ):
            if self._bodies[following]:
                try:
                    self._set(following, self._bodies[following])
                except BlockError as error:
                    self._fail(self._lines[following], error)
            following += 1
        self._at = following
        if number in cycles.PATTERNS:
            here = self._lines[at]
            cycles.pattern(self.ip, number, before, Block({}, (), (), None, 0, here.line, here.offset))

    def _frame(self, at: int, number: int, part: str | None, rest: str) -> None:
        """Frames (`datums`), 9 dwell, 247 preset."""
        here = self._lines[at]
        if number == 247:
            self._preset(at)
        elif number == 9:
            numbers = re.sub(r"(?!Q\d)[A-Z][A-Z.]*", " ", rest, flags=re.IGNORECASE)
            seconds = _VALUE.search(numbers) if part == "1" else None
            if seconds:
                self._execute(
                    Block({"p": self._value(seconds[1])}, (40,), (), None, 0, here.line, here.offset)
                )
        elif part == "1" or (part not in (None, "0") and number != 19):
            self._datums.set(number, rest)
        elif number == 8:
            following = self._following(at)
            if following is None or not _MIRRORED.match(self._bodies[following]):
                self._datums.take(8, None)

    def _function(self, body: str) -> None:
        """FUNCTION TCPM puts M128 in force, FUNCTION RESET TCPM ends it; others change nothing, or are not read."""
        if planes.TIP_ON.match(body) or planes.TIP_OFF.match(body):
            number = TIP if planes.TIP_ON.match(body) else TIP_OFF
            here = self._lines[self._at - 1]
            self._execute(Block({}, (number,), (), None, here.source, here.line, here.offset))
            return
        seconds = planes.dwell_s(body, self._value, self.ip.state.speed)
        if seconds is not None:
            here = self._lines[self._at - 1]
            self._execute(Block({"p": seconds}, (40,), (), None, here.source, here.line, here.offset))
        elif planes.PAUSES.match(body):
            self.ip.warn_once(planes.no_pauses(), Severity.WARNING)
        else:
            planes.idle(body)

    def _transformed(self, body: str) -> bool:
        """Do TRANS DATUM, MIRROR, ROTATION, SCALE of TNC 7, SEL PATTERN and SEL PGM; tell whether the line is one of them."""
        selected = programs.SELECT.match(body)
        if selected:
            self._selected = programs.bare(selected["name"])
            return True
        table = points.TABLE.match(body)
        if table:
            self._points = self._table(programs.bare(table["name"]))
            return True
        return self._datums.transform(body)

    def _table(self, name: str) -> list[points.Place]:
        """Return the points of a table that SEL PATTERN names."""
        found = self._file(name, f"table of points {name}", "SEL")
        text = bytes(open_source(found, str(found)).data[:]).decode("utf-8", "replace")
        return points.of_table(text, found.name)

    def _preset(self, at: int) -> None:
        """247: the preset Q339; numbers 1 to 9 are the origins G54 to G59.3 of the parameter file."""
        following = at + 1
        while following < len(self._bodies) and re.match(r"Q\d+\s*=", self._bodies[following], re.IGNORECASE):
            self._set(following, self._bodies[following])
            following += 1
        self._at = following
        number = round(self._q(339))
        if 1 <= number <= SYSTEM_COUNT:
            use_system(self.ip, number)
        elif number:
            # Of other presets only the control knows the place.
            use_system(self.ip, 1)
            message = f"preset {number} is taken as G54: presets 1 to {SYSTEM_COUNT} are G54 to G59.3"
            hint = "--parameters sets origins"
            self.ip.warn(BlockError("preset-unknown", message, "CYCL", hint=hint), Severity.WARNING)
