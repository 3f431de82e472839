"""Statements of a program in plain language: labels, calls and jumps, Q parameters, cycles and frames."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from cncgen.diagnostics import Severity
from cncgen.gcode.block import AXES, Block
from cncgen.gcode.codes.offsets import use_system
from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.errors import BlockError, Stop
from cncgen.gcode.klartext import cycles, lines, orientation, planes, points, programs, system_data, unread
from cncgen.gcode.klartext.contour_lines import ContourLines
from cncgen.gcode.klartext.datums import Datums
from cncgen.gcode.klartext.executing import INCLUDE, OF_PARAMETERS, behind_call
from cncgen.gcode.klartext.hole_cycle import FASTEST, lent
from cncgen.gcode.klartext.program_text import Frame, Program
from cncgen.gcode.state.systems import SYSTEM_COUNT
from cncgen.gcode.text import plain_language
from cncgen.gcode.text.plain_language import Statement
from cncgen.grammars.terminals import HEIDENHAIN as TERMINALS

_CONTOUR_LABELS = 14
#: A text that is written out.
_WRITTEN = re.compile(r'"([^"]*)"')
#: A label of cycle 14: CONTOUR LABEL 1 /2 /"ISLAND".
_LABEL = re.compile(rf"{TERMINALS['STRING']}|\d+")
_PRESET = re.compile(r"#\s*(?P<row>\d+)(?P<keep>\s+KEEP\s+TRANS)?(?:\s+WP)?", re.IGNORECASE)
#: Functions of tables and of the PLC.
_FUNCTIONS_NOT_READ = {
    "19": " (values for the PLC)", "28": " (reading a table)",
}  # fmt: skip
#: How far a number of repeats may lie from a whole one by rounding.
_WHOLE = 1e-6
#: Blocks that end a program that was called.
_ENDS = ([("m", 2.0)], [("m", 30.0)])
_FRAMES = (7, 8, 9, 10, 11, 19, 26, cycles.PRESET)


class HeidenhainRunner(ContourLines):
    """One run of a program in plain language."""

    dialect, ends_with, suffixes = "heidenhain", "END PGM or M30", programs.SUFFIXES

    def _prepare(self) -> None:
        super()._prepare()
        self._datums = Datums(self.ip, self._now)
        self._globals: dict[int, float] = {}
        self._points: list[points.Place] = []
        self._table = ""
        self._selected = ""

    def _finish(self, main: Program) -> None:
        super()._finish(main)
        self._tell_unset()

    def _tell_unset(self) -> None:
        """Warn of Q parameters that nothing sets: programs that ran before have set them on the control (TNC 640, "Q parameters": they are
        "globally effective for all programs stored in the TNC memory")."""
        found = lines.unset(self.sources)
        if not found:
            return
        names = list(found)
        more = f" and {len(names) - 3} more" if len(names) > 3 else ""
        message = f"{', '.join(names[:3])}{more} {'is' if len(names) == 1 else 'are'} read before anything sets {'it' if len(names) == 1 else 'them'}: 0 here"
        hint = "on the control the value is that of a program that ran before"
        index, offset, line = found[names[0]]
        at = re.search(rf"(?i){names[0]}(?!\d)", self.sources[index].text_at(offset))
        column = at.start() + 1 if at else 0
        error = BlockError(
            "variable-assumed", message, names[0], column=column, length=len(names[0]), hint=hint
        )
        self.reporter.report(self.sources[index], line, offset, error, Severity.WARNING)

    def _line(self, frame: Frame, at: int) -> None:
        body = frame.program.lines[at].body
        if body and body[0] != "*":
            self._run_statement(frame, at, self._statement(at, body))

    def _run_statement(self, frame: Frame, at: int, statement: Statement) -> None:
        run = self._handler(statement.kind)
        if len(self.frames) > 1 and statement.words in _ENDS and sum(not one.part for one in self.frames) > 1:
            if statement.kind != "end_program":
                code = f"M{statement.words[0][1]:g}"
                message = (
                    f"{code} stands in a program that another one calls: the run goes on in that one here"
                )
                hint = f"a program that is called must not have M2 or M30 (TNC 640, CALL PGM); without {code} it ends with END PGM"
                self.ip.warn_once("called-end", message, code, hint)
            self.leave()
        elif run is not None:
            run(frame, at, statement)
        else:
            self._plain(at, statement)

    def _feed_word(self, word: str) -> float:
        """Return the feed that a Q parameter of a cycle is given by a word: FMAX, FAUTO."""
        if word == "MAX":
            return FASTEST
        feed = Plain.of(self.ip).tool_feed
        if feed <= 0.0:
            message = "AUTO takes the feed of TOOL CALL, which has none"
            raise BlockError("feed-missing", message, "AUTO", hint="TOOL CALL 5 Z S2000 F500")
        return feed

    # Jumps.

    def _led_to(self, program: Program, at: int) -> int | None:
        statement = self._ahead_in(program, at)
        name = {"jump": -1, "call": 0}.get(statement.kind)
        found = program.labelled(statement.data[name]) if name is not None else []
        return found[0] + 1 if len(found) == 1 else None

    def do_label(self, frame: Frame, at: int, statement: Statement) -> None:
        """LBL 0 ends a subprogram; other labels are passed."""
        if statement.data[0] == "0" and frame.part:
            self._pop()

    def do_call(self, frame: Frame, at: int, statement: Statement) -> None:
        """CALL LBL n: a subprogram to LBL 0; with REP m the lines from the label to here m times more."""
        name, times = statement.data
        target = self._target(name)
        if times is None:
            self.enter(Frame(frame.program, at=target + 1, part=True), "CALL")
            return
        left = frame.loops.pop(at, None)
        left = self._rounds(name, self._now(times)) if left is None else left
        if left > 0:
            if target > at:
                message = f"CALL LBL {name} REP leads to a label below it: the run goes on there and does not return"
                hint = f"CALL LBL {name} without REP calls a subprogram that ends with LBL 0"
                self.ip.warn_once("repeat-ahead", message, "CALL", hint)
            frame.loops[at], frame.at = left - 1, target + 1

    def _rounds(self, name: str, value: float) -> int:
        """Return how often REP repeats: a value that is not whole is rounded, and told."""
        count = round(value)
        if abs(value - count) > _WHOLE:
            message = f"CALL LBL {name} REP repeats {value:g} times, which is not whole: {count} are run, and a control may run another number"
            self.ip.warn_once("repeat-not-whole", message, "CALL", "INT makes the number whole")
        return count

    def do_set(self, frame: Frame, at: int, statement: Statement) -> None:
        """Set a Q parameter."""
        number, value = statement.data
        self.ip.parameters.set_number(number, self._now(value))

    def do_feed(self, frame: Frame, at: int, statement: Statement) -> None:
        """Set a Q parameter to a feed: FMAX, FAUTO."""
        number, word = statement.data
        self.ip.parameters.set_number(number, self._feed_word(word))

    def do_predefined(self, frame: Frame, at: int, statement: Statement) -> None:
        """Set a Q parameter to its value of GLOBAL DEF."""
        key = statement.data[0]
        if key not in self._globals:
            message = f"Q{key} = PREDEF takes a value that no GLOBAL DEF gives"
            raise BlockError("cycle-words", message, "PREDEF", hint=f"GLOBAL DEF 100 GENERAL ~ Q{key}=2")
        self.ip.parameters.set_number(float(key), self._globals[key])

    def do_jump(self, frame: Frame, at: int, statement: Statement) -> None:
        """FN 9 to FN 12."""
        holds, label = statement.data
        if self._now(holds):
            frame.at = self._target(label) + 1

    def do_system_data(self, frame: Frame, at: int, statement: Statement) -> None:
        """FN 18."""
        number, *asked = statement.data
        group, place, index = (round(self._now(value or 0.0)) for value in asked)
        self.ip.parameters.set_number(number, system_data.read(self.ip, group, place, index))

    def do_write_data(self, frame: Frame, at: int, statement: Statement) -> None:
        """FN 17."""
        *asked, value = statement.data
        group, place, index = (round(self._now(part or 0.0)) for part in asked)
        system_data.write(self.ip, group, place, index, 0.0 if isinstance(value, str) else self._now(value))

    def do_open_table(self, frame: Frame, at: int, statement: Statement) -> None:
        """FN 26."""
        self._table = programs.bare(statement.data[0]).replace("\\", "/").rsplit("/", 1)[-1].upper()

    def do_write_table(self, frame: Frame, at: int, statement: Statement) -> None:
        """FN 27; raise where FN 26 has opened no table."""
        row, columns, value = statement.data
        if not self._table:
            message = "FN 27 writes into the table that FN 26 opened, and none is open"
            raise BlockError("unsupported-block", message, "FN", hint="FN 26: TABOPEN TNC:\\TOOL.T opens one")
        written = None if isinstance(value, str) else self._now(value)
        system_data.write_column(self.ip, self._table, round(self._now(row)), columns.strip('"'), written)

    def do_alarm(self, frame: Frame, at: int, statement: Statement) -> None:
        """FN 14."""
        message = f"the program raises an error: {frame.program.lines[at].body}"
        raise Stop(BlockError("program-alarm", message, "FN", hint="FN 14 ends the program"))

    def do_function_unknown(self, frame: Frame, at: int, statement: Statement) -> None:
        """FN that is not read."""
        hint = "FN 0 to FN 14, FN 17, FN 18 and formulas of Q are read"
        what = _FUNCTIONS_NOT_READ.get(statement.data[0], "")
        raise BlockError("unsupported-block", f"FN {statement.data[0]}{what} is not read", "FN", hint=hint)

    def do_text(self, frame: Frame, at: int, statement: Statement) -> None:
        """Keep a text that is written out, which cycle 225 engraves."""
        number, text = statement.data
        texts, whole = Plain.of(self.ip).texts, _WRITTEN.fullmatch(text.strip().rstrip("~").rstrip())
        texts.pop(number, None)
        if whole:
            texts[number] = whole[1]

    def do_passed(self, frame: Frame, at: int, statement: Statement) -> None:
        """Pass statements that print, send or wait, and texts, which are not kept: a statement that uses one reports it."""

    def _parameters(self, frame: Frame, at: int, take: Callable[[Statement, int], None]) -> None:
        """Run the lines of parameters behind a cycle; go on behind them."""
        given = frame.program.lines
        frame.at = at + 1
        while frame.at < len(given) and (
            not given[frame.at].body or given[frame.at].body.startswith(("Q", "q"))
        ):
            following, frame.at = frame.at, frame.at + 1
            if given[following].body:
                try:
                    take(self._statement(following, given[following].body), following)
                except BlockError as error:
                    self._faults.fail(given[following].here, error)

    def _take_parameters(self, frame: Frame, at: int) -> list[int]:
        """Set the parameters behind a cycle, and return their numbers."""
        given: list[int] = []

        def take(statement: Statement, following: int) -> None:
            if statement.kind != "text":
                given.append(int(statement.data[0]))
            self._run_statement(self.frames[-1], following, statement)

        self._parameters(frame, at, take)
        return given

    def do_global_def(self, frame: Frame, at: int, statement: Statement) -> None:
        """GLOBAL DEF: keep the values that parameters of cycles take by PREDEF."""

        def take(given: Statement, following: int) -> None:
            number, value = given.data
            self._globals[int(number)] = self._feed_word(value) if given.kind == "feed" else self._now(value)

        self._parameters(frame, at, take)

    def do_call_program(self, frame: Frame, at: int, statement: Statement) -> None:
        self._call_program(programs.bare(statement.data[0]))

    def do_call_selected(self, frame: Frame, at: int, statement: Statement) -> None:
        self._call_program(self._selected)

    # Cycles.

    def do_pattern_def(self, frame: Frame, at: int, statement: Statement) -> None:
        """PATTERN DEF: take the points that CYCL CALL PAT visits."""
        parts = list(statement.data)
        while frame.at < frame.end and (more := self._ahead(frame.at)).kind == "pattern_more":
            parts, frame.at = [*parts, *more.data], frame.at + 1
        self._points = []
        self._points = points.places(parts, self._now)

    def do_call_pattern(self, frame: Frame, at: int, statement: Statement) -> None:
        """CYCL CALL PAT: run the cycle at each point, at the feed of the block on the way to it."""
        if not self._points:
            hint = 'PATTERN DEF POS1 (X+10 Y+10 Z+0) or SEL PATTERN "NAME.PNT" stands before it'
            raise BlockError("cycle-missing", "CYCL CALL PAT has no pattern to visit", "CYCL", hint=hint)
        late: list[Block] = []
        q = self.ip.parameters.numbers
        for place, above in self._points:
            block = self._block(at, statement.words)
            late = behind_call(block)
            block.words |= {"x": place.real, "y": place.imag}
            self._move(block)
            with lent(q, {203: q[203] + above}):
                cycles.call(self.ip, block.beside({}))
        for part in late:
            self._execute(part)

    def do_call_at(self, frame: Frame, at: int, statement: Statement) -> None:
        """CYCL CALL POS: the cycle at a place, whose Z shifts the cycle; from below its clearance the tool rises first. It ends M89."""
        block = self._block(at, statement.words)
        late = behind_call(block)
        Plain.of(self.ip).modal = False
        q, above = self.ip.parameters.numbers, 0.0
        if Plain.of(self.ip).cycle >= OF_PARAMETERS and "z" in block.words:
            above = block.words.pop("z")
            clearance = q[203] + above + q[200]
            if self.ip.state.position[2] < clearance:
                way = {name: value for name, value in block.words.items() if name not in AXES}
                self._move(replace(block, words={**way, "z": clearance}, m=()))
        self._move(block)
        with lent(q, {203: q[203] + above}):
            self._call_cycle(block)
        for part in late:
            self._execute(part)

    def do_cycle(self, frame: Frame, at: int, statement: Statement) -> None:
        """CYCL DEF."""
        number, part, rest = statement.data
        try:
            self._part(frame, at, number, part, rest)
        except BlockError as error:
            self._point(self._lines[at].here, rest, error)
            raise

    def _part(self, frame: Frame, at: int, number: int, part: str | None, rest: str) -> None:
        if number == 32:
            self._tolerance(at, rest if part == "1" else None)
        elif number == _CONTOUR_LABELS:
            before = Plain.of(self.ip).labels
            self._take_labels(
                []
                if part in (None, "0")
                else [*before, *[found[0].strip('"') for found in _LABEL.finditer(rest)]]
            )
        elif number == programs.CYCLE:
            plain = Plain.of(self.ip)
            plain.cycle, plain.modal = number, False
            self._of_cycle = programs.of_cycle(rest) if part == "1" else ""
        elif number in _FRAMES:
            self._frame(frame, at, number, part, rest)
        elif part not in (None, "0"):
            cycles.take_part(self.ip, number, int(part), rest)
        else:
            self._define(frame, at, number)

    def _tolerance(self, at: int, rest: str | None) -> None:
        """32.1: the tolerance of the path; other parts move nothing."""
        words = plain_language.words_of(rest) if rest is not None else []
        unread.tell(self.ip, "cycle 32", words, ("T",))
        self._plain(at, Statement("block", plain_language.tolerance(words) if rest is not None else []))

    def _take_labels(self, labels: list[str]) -> None:
        plain = Plain.of(self.ip)
        plain.contour, plain.labels = self._contour, labels

    def _define(self, frame: Frame, at: int, number: int) -> None:
        """Take a cycle; a pattern runs once its Q parameters are read."""
        before = Plain.of(self.ip).cycle
        cycles.define(self.ip, number)
        cycles.take_given(self.ip, number, self._take_parameters(frame, at))
        if number in cycles.PATTERNS:
            cycles.pattern(self.ip, number, before, self._here(at))

    def _frame(self, frame: Frame, at: int, number: int, part: str | None, rest: str) -> None:
        """Frames (`datums`), 9 dwell, 247 preset."""
        if number == cycles.PRESET:
            self._preset(frame, at)
        elif number == 9:
            # The name of its value is of the operator's language.
            given = (
                [word for word in plain_language.words_of(rest) if word[1] == word[1]] if part == "1" else []
            )
            own = {given[0][0]} - {*AXES.upper()} if given else set()
            unread.tell(self.ip, "cycle 9", given, own)
            if given:
                self._execute(self._here(at, (40,), {"p": self._now(given[0][1])}))
        elif part == "1" or (part not in (None, "0") and number != 19):
            self._datums.of_cycle(number, rest)
        elif number == 8:
            following = self._following(at)
            behind = self._ahead(following).data if following is not None else ()
            if behind[:2] != (8, "1") or not behind[2]:
                self._datums.take(8, None)

    def do_dwell(self, frame: Frame, at: int, statement: Statement) -> None:
        """FUNCTION DWELL."""
        unit, value = statement.data
        self._execute(
            self._here(at, (40,), {"p": planes.dwell_s(unit, self._now(value), self.ip.state.speed)})
        )

    def do_tip_on(self, frame: Frame, at: int, statement: Statement) -> None:
        """FUNCTION TCPM."""
        orientation.turn_on(self.ip, statement.data)
        self._plain(at, statement)

    def do_plane(self, frame: Frame, at: int, statement: Statement) -> None:
        """PLANE."""
        kind, *words = statement.data
        self._datums.plane(kind.upper(), words)

    def do_transform(self, frame: Frame, at: int, statement: Statement) -> None:
        """TRANS DATUM, MIRROR, ROTATION, SCALE of TNC 7."""
        kind, *words = statement.data
        self._datums.transform(kind.upper(), words)

    def do_select_program(self, frame: Frame, at: int, statement: Statement) -> None:
        """SEL PGM."""
        self._selected = programs.bare(statement.data[0])

    def do_select_pattern(self, frame: Frame, at: int, statement: Statement) -> None:
        """SEL PATTERN."""
        name, text = self._text(programs.bare(statement.data[0]), "table of points")
        self._points = points.of_table(text, name)

    def do_select_table(self, frame: Frame, at: int, statement: Statement) -> None:
        """SEL TABLE."""
        name, text = self._text(programs.bare(statement.data[0]), "table of datums")
        self._datums.choose(text, name)

    def _text(self, name: str, what: str) -> tuple[str, str]:
        """Return the name of the file of a table, and its text."""
        found = self.file(name, f"there is no {what} {name}", "SEL", INCLUDE)
        return Path(found.name).name, bytes(found.data[:]).decode("utf-8", "replace")

    def _preset(self, frame: Frame, at: int) -> None:
        """247: the preset Q339; numbers 1 to 9 are the origins G54 to G59.3 of the parameter file. It ends cycles 7, 8, 10, 11 and 26."""
        given = self._take_parameters(frame, at)
        cycles.take_given(self.ip, cycles.PRESET, given)
        self._datums.untransform()
        self._use_preset(round(self.ip.parameters.numbers[339]))

    def do_preset(self, frame: Frame, at: int, statement: Statement) -> None:
        """PRESET SELECT: a row of the table of presets; KEEP TRANS keeps the shifts and turns in force (TNC 7, "PRESET SELECT")."""
        found = _PRESET.fullmatch(statement.data[0].strip())
        if found is None:
            message = f"PRESET SELECT {statement.data[0].strip()} is not read"
            hint = "PRESET SELECT #3 takes preset 3; names stand in a table of the control"
            raise BlockError("unsupported-block", message, "PRESET", hint=hint)
        if not found["keep"]:
            self._datums.untransform()
        self._use_preset(int(found["row"]))

    def _use_preset(self, number: int) -> None:
        if 1 <= number <= SYSTEM_COUNT:
            use_system(self.ip, number)
        elif number:
            # Of other presets only the control knows the place.
            use_system(self.ip, 1)
            message = f"preset {number} is taken as G54: presets 1 to {SYSTEM_COUNT} are G54 to G59.3"
            self.ip.warn("preset-unknown", message, "PRESET", "--parameters sets origins")
