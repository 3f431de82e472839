"""O-words: subroutines, branches and loops, by jumps between lines of the text.

Nothing is nested here: where a jump leads is looked up by its label (`labels`). A `Cursor` is a place to go on from.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from cncgen.diagnostics import Severity, UsageError
from cncgen.gcode import descent, macros
from cncgen.gcode.axes import moving_axes
from cncgen.gcode.block import Flow, Value, nearest
from cncgen.gcode.errors import Astray, BlockError
from cncgen.gcode.expressions import EQUAL, evaluate
from cncgen.gcode.labels import LOOP_END, Cursor, Label, Labels, Marked, line_matches
from cncgen.gcode.macro_loops import Loops
from cncgen.gcode.search import candidates, leaves_path, search_path
from cncgen.gcode.source import Source, open_source

if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

#: Local numbered parameters: the arguments of a subroutine, #1 to #30, of a macro, #1 to #33.
LOCALS = 30
MACRO_LOCALS = 33
#: Values in brackets that an O-word takes at most, where it has a bound.
_MOST_ARGUMENTS = {"sub": 0, **dict.fromkeys(("if", "elseif", "while", "repeat", "return", "endsub"), 1)}


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

    def __init__(
        self, ip: Interpreter, sources: list[Source], program: Path | None, axes: str | None
    ) -> None:
        self.ip = ip
        self.sources = sources
        self.frames: list[Frame] = []
        self._main = Frame(Cursor(0, 0, 0), 0.0, [], {})
        self._labels: dict[int, Labels] = {}
        #: Where subroutines of a label, called from a source, begin.
        self._subs: dict[tuple[Label, int, tuple[str, ...]], Marked] = {}
        self._lines: dict[int, dict[int, list[Cursor]]] = {}
        self._locals = MACRO_LOCALS if ip.dialect == "fanuc" else LOCALS
        self._files: dict[str, int] = {}
        #: DO and END by source, for the macros of FANUC.
        self.loops: dict[int, Loops] = {}
        #: Labels of subroutines that were found without an end.
        self._unclosed: set[Label] = set()
        #: Where a label of a branch or loop was met first, and its keyword, by the subroutine that it is local to.
        self._first: dict[tuple[Label, int, Label], tuple[Cursor, str]] = {}
        self._folders = search_path(program, ip.options.include)
        self._axes = axes
        #: Runs the blocks that wait, where the machine's state is about to change.
        self.settle: Callable[[], None] = lambda: None

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
            other = "linuxcnc" if self.ip.dialect == "fanuc" else "fanuc"
            raise BlockError(
                "unsupported-flow",
                f"{flow.keyword.upper()} is not of the {self.ip.dialect} dialect",
                hint=f"--dialect {other} has it",
            )
        if len(flow.arguments) > _MOST_ARGUMENTS.get(flow.keyword, len(flow.arguments)):
            raise BlockError(
                "oword-arguments", f"{flow.keyword.upper()} has {len(flow.arguments)} values in brackets", "O"
            )
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
                f"o{_shown(label)} begins {_with_article(keyword)} in line {first.line} already",
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
            if parsed.flow.asks_state:
                self.settle()
            if self.condition(parsed.flow):
                return mark.after
            place = mark.cursor

    def _leave_if(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        """Handle ELSE or ELSEIF at the end of the branch that was taken: go behind ENDIF."""
        label = self._label(flow)
        self.previous_mark(here, label, ("if",), flow.keyword)
        if flow.keyword == "elseif":
            self.condition(flow)  # not asked for, but it must have a value: LinuxCNC computes it on the way
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
        mark = self.next_mark(here, label, ends, LOOP_END)
        self.frame.doing.discard(label)
        return mark.after

    def _continue(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        return self.next_mark(here, self._label(flow), ("endwhile", "endrepeat", "while"), LOOP_END).cursor

    # Subroutines.

    def _sub(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        """Skip a definition."""
        label = self._label(flow)
        labels = self.labels(here.source)
        end = labels.next(here.offset, label, ("endsub",), self._resolved, over_borders=True)
        if end is None:
            return self._unclosed_sub(label, here)
        first = labels.first(label, ("sub",), self._resolved)
        if first is not None and first.cursor != here:
            error = BlockError(
                "oword-duplicate",
                f"subroutine o{_shown(label)} is defined in line {first.cursor.line} already",
                "O",
                hint="give it another name",
            )
            self.ip.warn(error, Severity.ERROR)
            return end.after
        if labels.has_sub_between(here.offset, end.cursor.offset):
            error = BlockError(
                "oword-nested-sub",
                "a subroutine is defined within a subroutine",
                "O",
                hint="close the outer one first; it may call the inner one all the same",
            )
            self.ip.warn(error, Severity.ERROR)
        return end.after

    def _unclosed_sub(self, label: Label, here: Cursor) -> Cursor | None:
        """Report a definition without its end, and skip what another label's ENDSUB closes."""
        self._unclosed.add(label)
        border = self.labels(here.source).border(here.offset)
        end = border if border is not None and border.keyword == "endsub" else None
        hint = f"it must stand below, with the label o{_shown(label)}"
        if end is not None:
            hint += f"; line {end.cursor.line} has the ENDSUB of another label"
        self.ip.warn(
            BlockError("oword-unmatched", f"o{_shown(label)} has no ENDSUB", "O", hint=hint), Severity.ERROR
        )
        return end.after if end is not None else None

    def _endsub(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        label = self._label(flow)
        # A computed label may have changed by the parameters that the subroutine has of its own.
        if not self.frames or (self.frame.label != label and not callable(flow.label)):
            raise BlockError(
                "oword-unmatched",
                f"o{_shown(label)} ENDSUB with no SUB that was called",
                "O",
                hint="SUB and ENDSUB have the same label",
            )
        return self.leave(flow.arguments)

    def _return(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        if not self.frames:
            raise BlockError(
                "oword-unmatched", "RETURN outside a subroutine", "O", hint="M2 or M30 end the main program"
            )
        return self.leave(flow.arguments)

    def _call(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        label = self._label(flow)
        if len(flow.arguments) > LOCALS:
            raise BlockError(
                "oword-arguments",
                f"{len(flow.arguments)} arguments; a call takes {LOCALS}",
                "O",
                hint="pass more in global parameters: #<_name>, or #31 and above",
            )
        values = [
            value if isinstance(value, float) else evaluate(value, self.ip.parameters)
            for value in flow.arguments
        ]
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
        """Begin a call with these local parameters (None: the numbered ones of the caller go on)."""
        if len(self.frames) >= self.ip.options.max_call_depth:
            raise Astray(
                BlockError(
                    "call-depth",
                    f"subroutine calls are nested more than {self.ip.options.max_call_depth} deep",
                    hint="is the recursion without end?",
                )
            )
        parameters = self.ip.parameters
        frame = Frame(back, label, parameters.numbers[1 : self._locals + 1], parameters.local, values=values)
        self.frames.append(frame)
        parameters.local = {}
        if values is not None:
            parameters.numbers[1 : self._locals + 1] = values
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
        if frame.values is not None:
            # A program that M98 calls has the numbered local parameters of its caller.
            parameters.numbers[1 : self._locals + 1] = frame.numbers
        parameters.local = frame.named
        parameters.named["_value"] = value
        parameters.named["_value_returned"] = 1.0 if returned else 0.0
        if frame.restore and frame.saved is not None:
            self.settle()
            self.ip.restore(frame.saved)
        return frame.back

    def give_up(self) -> None:
        """End all calls in progress; the main program has its local parameters back."""
        if self.frames:
            first = self.frames[0]
            self.ip.parameters.numbers[1 : self._locals + 1] = first.numbers
            self.ip.parameters.local = first.named
            self.frames.clear()

    def call_number(
        self, number: int, times: int, here: Cursor, after: Cursor, values: list[float] | None = None
    ) -> Cursor:
        """M98 P L, G65 P L: run the program of that number `times` times, with these local parameters."""
        label = float(number)
        try:
            target = self.sub_of(label, here, ("program", "sub"))
        except BlockError as error:
            error.word = "P"
            raise
        if target.keyword == "sub" and self.ip.dialect == "linuxcnc":
            hint = f"use o{number} CALL"
            raise BlockError("sub-kind", f"o{number} is a SUB, which M98 cannot run", "P", hint=hint)
        frame = self.enter(label, target.after, after, values)
        frame.by_number = True
        frame.again = (target.after, times - 1)
        return target.after

    # Labels.

    def _label(self, flow: Flow) -> Label:
        label = flow.label
        if isinstance(label, str):
            return label
        assert label is not None
        value = evaluate(label, self.ip.parameters)
        whole = nearest(value, "the label")
        if abs(value - whole) > EQUAL:
            raise BlockError("oword-label", f"a label of {value:g}, which is no whole number", "O")
        return float(whole)

    def _value(self, flow: Flow, index: int) -> float:
        if len(flow.arguments) <= index:
            raise BlockError(
                "oword-arguments",
                f"{flow.keyword.upper()} needs a value in brackets",
                "O",
                hint=f"o{_shown(self._label(flow))} {flow.keyword} [#1 LT 10]",
            )
        return evaluate(flow.arguments[index], self.ip.parameters)

    def program_range(self, here: Cursor) -> tuple[int, int]:
        """Return the offsets between which the program of a line stands in its file."""
        begin, end = 0, len(self.sources[here.source])
        for mark in self.labels(here.source).marks:
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
            for begin, line, match in line_matches(self.sources[source], pattern):
                lines.setdefault(int(match.group(1)), []).append(Cursor(source, begin, line))
            self._lines[source] = lines
        return self._lines[source]

    def condition(self, flow: Flow) -> bool:
        return self._value(flow, 0) != 0.0

    def labels(self, source: int) -> Labels:
        """Return the lines of a source that jumps may lead to."""
        if source not in self._labels:
            self._labels[source] = Labels(self.sources[source], source, self.ip.dialect)
        return self._labels[source]

    def has_written_labels(self, source: int) -> bool:
        """Tell whether no label of a source is computed, so that each means the same whenever it is looked up."""
        return not self.labels(source).computed

    def next_mark(self, here: Cursor, label: Label, keywords: tuple[str, ...], wanted: str) -> Marked:
        """Return the first later line of the subroutine with this label and one of the keywords."""
        labels = self.labels(here.source)
        mark = labels.next(here.offset, label, keywords, self._resolved, over_borders=False)
        if mark is not None:
            return mark
        if wanted == LOOP_END:
            raise BlockError(
                "oword-unmatched",
                f"o{_shown(label)} stands in no loop",
                "O",
                hint="BREAK and CONTINUE have the label of the loop around them",
            )
        raise BlockError(
            "oword-unmatched",
            f"o{_shown(label)} has no {wanted.upper()}",
            "O",
            hint=f"it must stand below, with the label o{_shown(label)}, in the same subroutine",
        )

    def previous_mark(self, here: Cursor, label: Label, keywords: tuple[str, ...], word: str) -> Marked:
        """Return the last earlier line of the subroutine with this label and one of the keywords."""
        mark = self.find_previous(here, label, keywords)
        if mark is not None:
            return mark
        raise BlockError(
            "oword-unmatched",
            f"o{_shown(label)} {word.upper()} with no {keywords[0].upper()}",
            "O",
            hint=f"it must stand above, with the label o{_shown(label)}, in the same subroutine",
        )

    def find_previous(self, here: Cursor, label: Label, keywords: tuple[str, ...]) -> Marked | None:
        """Return `previous_mark`, None where there is none."""
        return self.labels(here.source).previous(here.offset, label, keywords, self._resolved)

    def _resolved(self, label: Value | str) -> Value | str:
        """Return a label as it is now (it may be computed)."""
        return label(self.ip.parameters) if callable(label) else label

    def sub_of(self, label: Label, here: Cursor, keywords: tuple[str, ...] = ("sub",)) -> Marked:
        """Return the line that begins a subroutine: in this file, or in the file of its name."""
        if label in self._unclosed:
            raise BlockError(
                "sub-unfinished", f"o{_shown(label)} has no ENDSUB: it is not run", "O", hint="see its SUB"
            )
        key = label, here.source, keywords
        if key in self._subs:
            return self._subs[key]
        for source in dict.fromkeys((here.source, *range(len(self.sources)))):
            found = self.labels(source).first(label, keywords, self._resolved)
            if found is not None:
                if not self._labels[source].computed:
                    self._subs[key] = found
                return found
        source = self._file(label)
        if self.ip.dialect == "fanuc":
            marks = self.labels(source).marks
            return next((m for m in marks if m.keyword == "program"), _whole(label, source))
        found = self.labels(source).first(label, keywords, self._resolved)
        if found is not None:
            return found
        name = self.sources[source].name
        raise BlockError(
            "sub-missing",
            f"{name} has no o{_shown(label)} SUB",
            "O",
            hint="the file of a subroutine holds the subroutine of its name",
        )

    def _file(self, label: Label) -> int:
        """Return the source of the file that holds a subroutine; it must lie in a folder of the search path."""
        name = label if isinstance(label, str) else f"{label:g}"
        if self.ip.dialect == "fanuc" and isinstance(label, float):
            name = f"O{int(label):04d}"
        if name in self._files:
            return self._files[name]
        if leaves_path(name):
            raise BlockError(
                "sub-path",
                f"the subroutine name <{name}> leads out of the search path",
                "O",
                hint="give the bare name, and the folder with --include",
            )
        for folder in self._folders:
            for path in candidates(folder, name):
                try:
                    source = open_source(path, str(path))
                except UsageError:
                    continue
                self._check_axes(source)
                self.sources.append(source)
                self._files[name] = len(self.sources) - 1
                return self._files[name]
        places = ", ".join(str(folder) for folder in self._folders) or "the search path, which is empty"
        what = f"program {name}" if self.ip.dialect == "fanuc" else f"subroutine o{_shown(label)}"
        raise BlockError(
            "sub-missing",
            f"there is no {what} in the text, and no file {name}.ngc in {places}",
            "O",
            hint="--include adds a folder to the search path",
        )

    def _check_axes(self, source: Source) -> None:
        """Refuse a file that moves axes which were not foreseen: their column cannot be added under way."""
        late = "" if self._axes is None else "".join(a for a in moving_axes(source) if a not in self._axes)
        if late:
            raise BlockError(
                "late-axis",
                f"{source.name} names {' and '.join(late)}, which neither the program nor a file that it calls by its"
                " name does",
                "O",
                hint=f"name {' and '.join(late)} in the program, or call the file by its name or number",
            )


def _whole(label: Label, source: int) -> Marked:
    """Return the beginning of a file that is one program without a number."""
    first = Cursor(source, 0, 1)
    return Marked(label, "program", first, first)


def _with_article(keyword: str) -> str:
    """Return ``a WHILE``, ``an IF``."""
    return f"{'an' if keyword == 'if' else 'a'} {keyword.upper()}"


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
