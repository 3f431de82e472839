"""O-words: subroutines, branches and loops, by jumps between lines of the text.

Nothing is nested here: a jump's target is the next line with the same label and a fitting keyword, as in LinuxCNC
("O Codes"), whose labels are local to the subroutine that they stand in. A `Cursor` is a place to go on from.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from cncgen.diagnostics import Severity, UsageError
from cncgen.gcode import descent, macros
from cncgen.gcode.block import Flow, Value, nearest
from cncgen.gcode.errors import BlockError, Stop
from cncgen.gcode.expressions import evaluate
from cncgen.gcode.source import Source, open_source

if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

#: Local numbered parameters: the arguments of a subroutine, #1 to #30, of a macro, #1 to #33.
LOCALS = 30
MACRO_LOCALS = 33
#: Lines that a jump may lead to: O-words, program numbers, loops of macros.
_O_LINE = re.compile(
    rb"(?:\A|\n)[ \t]*(?:/[ \t]*)?(?:[nN][ \t\d.]*)?((?:[oO]|(?i:while|do[ \t]*\d|end[ \t]*\d))[^\n]*)"
)
Label = float | str


class Cursor(NamedTuple):
    """A line: source, byte offset, line number."""

    source: int
    offset: int
    line: int


class Marked(NamedTuple):
    """A line with an O-word."""

    label: Value | str
    keyword: str
    cursor: Cursor
    after: Cursor


@dataclass(slots=True)
class Frame:
    """A call: where it goes back to, and what it puts back."""

    back: Cursor
    label: Label
    numbers: list[float]
    named: dict[str, float]
    again: tuple[Cursor, int] | None = None
    doing: set[Label] = field(default_factory=set)
    left: dict[Label, int] = field(default_factory=dict)
    saved: object | None = None
    restore: bool = False
    by_number: bool = False
    values: list[float] | None = None
    modal: bool = False


class FlowControl:
    """Calls in progress, and where the labels of each source are."""

    def __init__(self, ip: Interpreter, sources: list[Source], program: Path | None) -> None:
        self.ip = ip
        self.sources = sources
        self.frames: list[Frame] = []
        self._main = Frame(Cursor(0, 0, 0), 0.0, [], {})
        self._marks: dict[int, list[Marked]] = {}
        self._computed_labels: set[int] = set()
        self._lines: dict[int, dict[int, list[Cursor]]] = {}
        self._locals = MACRO_LOCALS if ip.dialect == "fanuc" else LOCALS
        self._offsets: dict[int, list[int]] = {}
        self._files: dict[str, int] = {}
        #: Where a label of a branch or loop was met first, and its keyword, by the subroutine that it is local to.
        self._first: dict[tuple[Label, int, Label], tuple[Cursor, str]] = {}
        self._folders = ([program.parent] if program else []) + list(ip.options.include)

    #: Arguments that a call may have.
    argument_room = LOCALS

    @property
    def frame(self) -> Frame:
        """Return the innermost call, or the record of the main program."""
        return self.frames[-1] if self.frames else self._main

    def run(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        """Execute an O-word; return where to go on, or None for the next line."""
        if flow.keyword in ("goto", "while-do", "end-do") and self.ip.dialect == "fanuc":
            return macros.run(self, flow, here)
        method = _METHODS.get(flow.keyword)
        if method is None or (self.ip.dialect == "fanuc" and flow.keyword != "program"):
            raise BlockError("unsupported-flow", f"{flow.keyword.upper()} is not of this dialect")
        return method(self, flow, here, after)

    # Branches and loops.

    def claim(self, flow: Flow, label: Label, here: Cursor) -> None:
        """Take a label for the branch or loop that begins here; raise where another one of this subroutine has it."""
        if flow.keyword == "while" and label in self.frame.doing:
            return
        first, keyword = self._first.setdefault((self.frame.label, here.source, label), (here, flow.keyword))
        if first.offset != here.offset and not keyword == flow.keyword == "do":
            raise BlockError(
                "oword-duplicate",
                f"o{_shown(label)} begins a {keyword.upper()} in line {first.line} already",
                "O",
                hint="give each branch and loop of a subroutine a label of its own",
            )

    def _if(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        self.claim(flow, self._label(flow), here)
        if self.condition(flow):
            return None
        label = self._label(flow)
        place = here
        while True:
            mark = self.next_mark(place, label, ("elseif", "else", "endif"), "endif")
            if mark.keyword != "elseif":
                return mark.after
            text = self.sources[mark.cursor.source].text_at(mark.cursor.offset)
            parsed = descent.parse(text, self.ip.dialect)
            assert parsed.flow is not None
            if self.condition(parsed.flow):
                return mark.after
            place = mark.cursor

    def _leave_if(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        """Handle ELSE or ELSEIF at the end of the branch that was taken: go behind ENDIF."""
        label = self._label(flow)
        self.previous_mark(here, label, ("if",), flow.keyword)
        return self.next_mark(here, label, ("endif",), "endif").after

    def _endif(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        self.previous_mark(here, self._label(flow), ("if",), "endif")
        return None

    def _while(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        label = self._label(flow)
        self.claim(flow, label, here)
        holds = self.condition(flow)
        if label in self.frame.doing:
            if holds:
                return self.previous_mark(here, label, ("do",), "while").after
            self.frame.doing.discard(label)
            return None
        return None if holds else self.next_mark(here, label, ("endwhile",), "endwhile").after

    def _endwhile(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        return self.previous_mark(here, self._label(flow), ("while",), "endwhile").cursor

    def _do(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        self.claim(flow, self._label(flow), here)
        self.frame.doing.add(self._label(flow))
        return None

    def _repeat(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        label = self._label(flow)
        self.claim(flow, label, here)
        count = nearest(self._value(flow, 0), "the count of REPEAT")
        if count <= 0:
            return self.next_mark(here, label, ("endrepeat",), "endrepeat").after
        self.frame.left[label] = count
        return None

    def _endrepeat(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        label = self._label(flow)
        start = self.previous_mark(here, label, ("repeat",), "endrepeat")
        left = self.frame.left.get(label, 0) - 1
        self.frame.left[label] = left
        return start.after if left > 0 else None

    def _break(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        label = self._label(flow)
        ends = ("endwhile", "endrepeat", "while")
        mark = self.next_mark(here, label, ends, "the loop's end")
        self.frame.doing.discard(label)
        return mark.after

    def _continue(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        return self.next_mark(
            here, self._label(flow), ("endwhile", "endrepeat", "while"), "the loop's end"
        ).cursor

    # Subroutines.

    def _sub(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        """Skip a definition."""
        label = self._label(flow)
        end = self.next_mark(here, label, ("endsub",), "endsub")
        first = next((m for m in self.marks(here.source) if m.keyword == "sub" and m.label == label), None)
        if first is not None and first.cursor != here:
            raise BlockError(
                "oword-duplicate",
                f"subroutine o{_shown(label)} is defined in line {first.cursor.line} already",
                "O",
                hint="give it another name",
            )
        for mark in self.marks(here.source):
            if here.offset < mark.cursor.offset < end.cursor.offset and mark.keyword == "sub":
                error = BlockError("oword-nested-sub", "a subroutine is defined within a subroutine", "O")
                self.ip.warn(error, Severity.ERROR)
                break
        return end.after

    def _endsub(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        label = self._label(flow)
        if not self.frames or self.frame.label != label:
            raise BlockError("oword-unmatched", f"o{_shown(label)} ENDSUB with no SUB that was called", "O")
        return self.leave(flow.arguments)

    def _return(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        if not self.frames:
            raise BlockError("oword-unmatched", "RETURN outside a subroutine", "O")
        return self.leave(flow.arguments)

    def _call(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        label = self._label(flow)
        if len(flow.arguments) > LOCALS:
            raise BlockError(
                "oword-arguments", f"{len(flow.arguments)} arguments; a call takes {LOCALS}", "O"
            )
        values = [evaluate(value, self.ip.parameters) for value in flow.arguments]
        target = self.sub_of(label, here)
        values += [0.0] * (LOCALS - len(values))
        self.enter(label, target.after, after, values)
        return target.after

    def _program(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        """Pass the number of a program; the next program of a file of several ends the main one."""
        if self.ip.dialect == "fanuc" and not self.frames:
            if self._begun:
                self.ip.end_program()
            self._begun = True
        return None

    _begun = False

    def enter(self, label: Label, target: Cursor, back: Cursor, values: list[float] | None) -> Frame:
        """Begin a call with these local parameters (None: those of the caller go on)."""
        if len(self.frames) >= self.ip.options.max_call_depth:
            raise Stop(
                BlockError(
                    "call-depth",
                    f"subroutine calls are nested more than {self.ip.options.max_call_depth} deep",
                    hint="is the recursion without end?",
                )
            )
        parameters = self.ip.parameters
        frame = Frame(back, label, parameters.numbers[1 : self._locals + 1], parameters.local, values=values)
        self.frames.append(frame)
        if values is not None:
            parameters.numbers[1 : self._locals + 1] = values
            parameters.local = {}
        return frame

    def leave(self, returned: tuple[Value, ...] = ()) -> Cursor:
        """End the innermost call; return where it goes back to."""
        parameters = self.ip.parameters
        frame = self.frame
        value = evaluate(returned[0], parameters) if returned else 0.0
        if frame.again is not None and frame.again[1] > 0:
            frame.again = (frame.again[0], frame.again[1] - 1)
            if frame.values is not None:
                parameters.numbers[1 : self._locals + 1] = frame.values
            return frame.again[0]
        self.frames.pop()
        if frame.values is not None or self.ip.dialect != "fanuc":
            # A program called by M98 of FANUC has the local parameters of its caller.
            parameters.numbers[1 : self._locals + 1] = frame.numbers
        parameters.local = frame.named
        if not frame.by_number:
            parameters.named["_value"] = value
            parameters.named["_value_returned"] = 1.0 if returned else 0.0
        if frame.restore and frame.saved is not None:
            self.ip.restore(frame.saved)
        return frame.back

    def call_number(
        self, number: int, times: int, here: Cursor, after: Cursor, values: list[float] | None = None
    ) -> Cursor:
        """M98 P L, G65 P L: run the program of that number `times` times, with these local parameters."""
        label = float(number)
        target = self.sub_of(label, here, ("program", "sub"))
        if target.keyword == "sub" and self.ip.dialect == "linuxcnc":
            hint = f"use o{number} CALL"
            raise Stop(BlockError("sub-kind", f"o{number} is a SUB, which M98 cannot run", "P", hint=hint))
        frame = self.enter(label, target.after, after, values)
        frame.by_number = True
        frame.again = (target.after, times - 1)
        return target.after

    # Labels.

    def _label(self, flow: Flow) -> Label:
        label = flow.label
        if isinstance(label, str | float):
            return label
        assert callable(label)
        return float(nearest(label(self.ip.parameters), "the label"))

    def _value(self, flow: Flow, index: int) -> float:
        if len(flow.arguments) <= index:
            raise BlockError("oword-arguments", f"{flow.keyword.upper()} needs a value in brackets", "O")
        return evaluate(flow.arguments[index], self.ip.parameters)

    def program_range(self, here: Cursor) -> tuple[int, int]:
        """Return the offsets between which the program of a line stands in its file."""
        begin, end = 0, len(self.sources[here.source])
        for mark in self.marks(here.source):
            if mark.keyword == "program":
                if mark.cursor.offset <= here.offset:
                    begin = mark.cursor.offset
                else:
                    return begin, mark.cursor.offset
        return begin, end

    def numbered(self, source: int, pattern: re.Pattern[bytes]) -> dict[int, list[Cursor]]:
        """Return the lines of a source by their N word."""
        if source not in self._lines:
            lines: dict[int, list[Cursor]] = {}
            for begin, line, match in _line_matches(self.sources[source], pattern):
                lines.setdefault(int(match.group(1)), []).append(Cursor(source, begin, line))
            self._lines[source] = lines
        return self._lines[source]

    def condition(self, flow: Flow) -> bool:
        return self._value(flow, 0) != 0.0

    def marks(self, source: int) -> list[Marked]:
        """Return the O-word lines of a source, in order."""
        if source not in self._marks:
            self._marks[source] = list(_find_marks(self.sources[source], source, self.ip.dialect))
            self._offsets[source] = [mark.cursor.offset for mark in self._marks[source]]
            if any(callable(mark.label) for mark in self._marks[source]):
                self._computed_labels.add(source)
        return self._marks[source]

    def has_written_labels(self, source: int) -> bool:
        """Tell whether no label of a source is computed, so that each means the same whenever it is looked up."""
        self.marks(source)
        return source not in self._computed_labels

    def next_mark(self, here: Cursor, label: Label, keywords: tuple[str, ...], wanted: str) -> Marked:
        """Return the first later line of the subroutine with this label and one of the keywords."""
        marks = self.marks(here.source)
        for mark in marks[bisect_right(self._offsets[here.source], here.offset) :]:
            if mark.keyword in keywords and self._is(mark, label):
                return mark
            if mark.keyword in ("sub", "endsub") and wanted != "endsub":
                break
        if wanted == "END":
            raise Stop(BlockError("loop-unmatched", f"DO {_shown(label)} has no END {_shown(label)}", "DO"))
        raise Stop(BlockError("oword-unmatched", f"o{_shown(label)} has no {wanted.upper()}", "O"))

    def previous_mark(self, here: Cursor, label: Label, keywords: tuple[str, ...], word: str) -> Marked:
        """Return the last earlier line of the subroutine with this label and one of the keywords."""
        mark = self.find_previous(here, label, keywords)
        if mark is not None:
            return mark
        if word == "END":
            raise BlockError("loop-unmatched", f"END {_shown(label)} has no DO {_shown(label)}", "")
        raise BlockError(
            "oword-unmatched", f"o{_shown(label)} {word.upper()} with no {keywords[0].upper()}", "O"
        )

    def find_previous(self, here: Cursor, label: Label, keywords: tuple[str, ...]) -> Marked | None:
        """Return `previous_mark`, None where there is none."""
        marks = self.marks(here.source)
        index = bisect_right(self._offsets[here.source], here.offset) - 2
        while index >= 0:
            mark = marks[index]
            if mark.keyword in keywords and self._is(mark, label):
                return mark
            if mark.keyword in ("sub", "endsub"):
                break
            index -= 1
        return None

    def _is(self, mark: Marked, label: Label) -> bool:
        """Tell whether a line has that label now (it may be computed)."""
        own = mark.label
        return (own(self.ip.parameters) if callable(own) else own) == label

    def sub_of(self, label: Label, here: Cursor, keywords: tuple[str, ...] = ("sub",)) -> Marked:
        """Return the line that begins a subroutine: in this file, or in the file of its name."""
        for source in dict.fromkeys((here.source, *range(len(self.sources)))):
            for mark in self.marks(source):
                if mark.keyword in keywords and self._is(mark, label):
                    return mark
        source = self._file(label)
        if self.ip.dialect == "fanuc":
            return next((m for m in self.marks(source) if m.keyword == "program"), _whole(label, source))
        for mark in self.marks(source):
            if mark.keyword in keywords and mark.label == label:
                return mark
        name = self.sources[source].name
        raise Stop(BlockError("sub-missing", f"{name} has no o{_shown(label)} SUB", "O"))

    def _file(self, label: Label) -> int:
        """Return the source of the file that holds a subroutine; it must lie in a folder of the search path."""
        name = label if isinstance(label, str) else f"{label:g}"
        if self.ip.dialect == "fanuc" and isinstance(label, float):
            name = f"O{int(label):04d}"
        if name in self._files:
            return self._files[name]
        if "/" in name or "\\" in name or name.startswith("."):
            raise Stop(
                BlockError("sub-path", f"the subroutine name <{name}> leads out of the search path", "O")
            )
        for folder in self._folders:
            for path in _candidates(folder, name):
                try:
                    self.sources.append(open_source(path, str(path)))
                except UsageError:
                    continue
                self._files[name] = len(self.sources) - 1
                return self._files[name]
        places = ", ".join(str(folder) for folder in self._folders) or "the search path, which is empty"
        raise Stop(
            BlockError(
                "sub-missing",
                f"there is no subroutine o{_shown(label)}, and no file {name}.ngc in {places}",
                "O",
                hint="--include adds a folder to the search path",
            )
        )


def _candidates(folder: Path, name: str) -> list[Path]:
    """Return the files of a folder that hold a subroutine of that name (names are case-insensitive)."""
    exact = folder / f"{name}.ngc"
    if exact.is_file():
        return [exact]
    if not folder.is_dir():
        return []
    wanted = {f"{name}{suffix}".lower() for suffix in (".ngc", ".nc", ".tap")}
    return sorted(path for path in folder.iterdir() if path.name.lower() in wanted and path.is_file())


def _line_matches(source: Source, pattern: re.Pattern[bytes]) -> Iterator[tuple[int, int, re.Match[bytes]]]:
    """Yield offset, number and match of the lines that a pattern (which may take the newline before) fits."""
    line, counted = 1, 0
    for match in pattern.finditer(source.data):
        begin = match.start() + (1 if source.data[match.start() : match.start() + 1] == b"\n" else 0)
        line += source.data[counted:begin].count(b"\n")
        counted = begin
        yield begin, line, match


def _find_marks(source: Source, index: int, dialect: str) -> Iterator[Marked]:
    """Find the lines of a text that jumps may lead to."""
    for begin, line, _ in _line_matches(source, _O_LINE):
        try:
            flow = descent.parse(source.text_at(begin), dialect).flow
        except BlockError:
            continue
        if flow is not None and flow.label is not None:
            after = Cursor(index, source.line_end(begin) + 1, line + 1)
            yield Marked(flow.label, flow.keyword, Cursor(index, begin, line), after)


def _whole(label: Label, source: int) -> Marked:
    """Return the beginning of a file that is one program without a number."""
    first = Cursor(source, 0, 1)
    return Marked(label, "program", first, first)


def _shown(label: Label) -> str:
    """Return how a label is written."""
    return f"<{label}>" if isinstance(label, str) else f"{label:g}"


Method = Callable[[FlowControl, Flow, Cursor, Cursor], Cursor | None]
_METHODS: dict[str, Method] = {
    "if": FlowControl._if,
    "elseif": FlowControl._leave_if,
    "else": FlowControl._leave_if,
    "endif": FlowControl._endif,
    "while": FlowControl._while,
    "endwhile": FlowControl._endwhile,
    "do": FlowControl._do,
    "repeat": FlowControl._repeat,
    "endrepeat": FlowControl._endrepeat,
    "break": FlowControl._break,
    "continue": FlowControl._continue,
    "sub": FlowControl._sub,
    "endsub": FlowControl._endsub,
    "return": FlowControl._return,
    "call": FlowControl._call,
    "program": FlowControl._program,
}
