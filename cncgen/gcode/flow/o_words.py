"""The order of execution: O-words by their keywords, on the calls in progress and the lines that labels mark.

There is no nesting: the target of a jump is looked up by its label (`labels`). A `Cursor` is a place to go on from.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cached_property

from cncgen.gcode.block import Block, Flow, evaluate, nearest
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow.calls import Calls
from cncgen.gcode.source import Source
from cncgen.gcode.text.labels import Cursor, Label, shown

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.flow.profile_lines import Take
    from cncgen.gcode.flow.reading import LineReader
    from cncgen.gcode.flow.subroutines import Subroutines
    from cncgen.gcode.interpreter import Interpreter
    from cncgen.gcode.text.marked_lines import Marked

    Method = Callable[["FlowControl", Flow, Cursor, Cursor], Cursor | None]


_EQUAL = 1e-4
_LOOP_END = "the loop's end"
#: Keywords that begin a branch or loop, and claim its label, and those that end it.
_BEGINNING = {"if": "endif", "while": "endwhile", "do": "while", "repeat": "endrepeat"}
#: Values in brackets that an O-word takes at most, where it has a bound.
_MOST_ARGUMENTS = {"sub": 0, **dict.fromkeys(("if", "elseif", "while", "repeat", "return", "endsub"), 1)}


class FlowControl:
    """Executes O-words.

    Attributes:
        calls: The calls in progress.
        begun: Whether a program number of FANUC was passed, which the main program begins with.
        lines: The lines of the run; these and what follows are set by whoever puts the parts together.
        execute: Executes a block.
        run_profile: Runs the lines of a profile (`profile_lines`).
    """

    def __init__(
        self, ip: Interpreter, sources: list[Source], program: str | os.PathLike[str] | None
    ) -> None:
        self.ip = ip
        self.calls = Calls(ip)
        self._sources, self._program = sources, program
        self.begun = False
        self.lines: LineReader
        self.execute: Callable[[Block], None]
        self.run_profile: Callable[[Take, Cursor, Cursor | Label, str], None]
        #: Jumps back, by their offsets, and whether they repeat the main program for ever (`repeats`).
        self.repeating: dict[int, bool] = {}
        #: Loops of macros that ask for a signal, while they have their one pass.
        self.waiting: set[Cursor] = set()
        #: Where a label of a branch or loop was met first, and its keyword, by the subroutine that it is local to.
        self._first: dict[tuple[Label, int, Label], tuple[Cursor, str]] = {}

    def run(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        """Execute an O-word; return where to go on, or None for the next line."""
        if flow.keyword in ("goto", "while-do", "end-do") and self.ip.dialect == "fanuc":
            from cncgen.gcode.flow import macros

            return macros.run(self, flow, here)
        method = self._methods.get(flow.keyword)
        if method is None or (self.ip.dialect == "fanuc" and flow.keyword != "program"):
            other = "linuxcnc" if self.ip.dialect == "fanuc" else "fanuc"
            message = f"{flow.keyword.upper()} is not of the {self.ip.dialect} dialect"
            raise BlockError("unsupported-flow", message, hint=f"--dialect {other} has it")
        if len(flow.arguments) > _MOST_ARGUMENTS.get(flow.keyword, len(flow.arguments)):
            count = len(flow.arguments)
            message = f"{flow.keyword.upper()} has {count} value{'s' if count > 1 else ''} in brackets"
            hint = (
                "SUB names no parameters: the values of CALL are #1 to #30 within"
                if flow.keyword == "sub"
                else "IF, WHILE and REPEAT have one value in brackets, a call one for each argument"
            )
            raise BlockError("oword-arguments", message, "O", hint=hint)
        return method(self, flow, here, after)

    @cached_property
    def subroutines(self) -> Subroutines:
        """The texts, and the lines of each that jumps lead to."""
        from cncgen.gcode.flow.subroutines import Subroutines

        return Subroutines(self.ip, self._sources, self._program)

    @cached_property
    def of_haas(self) -> bool:
        """Whether the text has a code that Haas's controls alone have."""
        from cncgen.gcode.text.dialects import of_haas

        return of_haas(self._sources[0])

    @cached_property
    def _methods(self) -> dict[str, Method]:
        """The function that executes each keyword; most programs have no O-word, and do not import it."""
        from cncgen.gcode.flow import sub_words
        from cncgen.kernels.gcode_codes import LOOKS

        return {
            **dict.fromkeys(LOOKS, FlowControl._branch),
            "sub": sub_words.define,
            "endsub": sub_words.end_sub,
            "return": sub_words.give_back,
            "call": sub_words.call,
            "program": sub_words.pass_program_number,
        }

    def _branch(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        """Handle an O-word of a branch or loop: IF ELSEIF ELSE ENDIF, WHILE ENDWHILE, DO WHILE, REPEAT ENDREPEAT, BREAK, CONTINUE."""
        from cncgen.kernels import gcode_codes

        keyword, frame = flow.keyword, self.calls.frame
        above, below = gcode_codes.LOOKS[keyword]
        label = self.label_of(flow)
        new = keyword in _BEGINNING and self.claim(flow, label, here)
        mark = self.previous_mark(here, label, above, keyword) if above and keyword != "while" else None
        value = 0.0
        if keyword in ("if", "elseif", "while"):  # LinuxCNC computes that of ELSEIF on the way, too
            value = self.value_of(flow)
        elif keyword == "repeat" and not frame.repeats(label):
            value = float(nearest(self.value_of(flow), "the count of REPEAT"))
        elif keyword in ("break", "continue"):
            mark = self.next_mark(here, label, below, _LOOP_END)
        way = frame.lead(gcode_codes.KEYWORDS[keyword], label, value)
        if way == gcode_codes.STAY:
            if new:
                self._check_end(keyword, label, here)
            return None
        if way == gcode_codes.PAST_PREVIOUS and keyword == "while":
            mark = self.previous_mark(here, label, above, "while")
        elif way == gcode_codes.PAST_NEXT and keyword != "break":
            mark = self._next_branch(here, label, below)
        assert mark is not None
        return mark.after if way in (gcode_codes.PAST_NEXT, gcode_codes.PAST_PREVIOUS) else mark.cursor

    def _next_branch(self, here: Cursor, label: Label, below: tuple[str, ...]) -> Marked:
        """Return the O-word below that is looked for: of branches, the first ELSEIF whose condition holds."""
        while True:
            mark = self.next_mark(here, label, below, below[-1])
            if mark.keyword != "elseif":
                return mark
            try:
                parsed = self.lines.parse(self.lines.text(mark.cursor))
                assert parsed.flow is not None
                holds = self.condition(parsed.flow)
            except BlockError as error:
                error.place = mark.cursor
                raise
            if holds:
                return mark
            here = mark.cursor

    def follow_jump(self, here: Cursor, after: Cursor) -> Cursor | None:
        """Execute the jump of a block (`Interpreter.jump`); return where to go on, or None for the next line."""
        from cncgen.gcode.flow import sub_words

        return sub_words.follow_jump(self, here, after)

    def line_numbered(self, here: Cursor, number: int, word: str) -> Cursor:
        """Return the line of a FANUC program that has an N word, which `word` of another line names."""
        from cncgen.gcode.flow import macros

        return macros.line_numbered(self, here, number, word)

    # Values.

    def label_of(self, flow: Flow) -> Label:
        """Return the label of an O-word, written or computed."""
        label = flow.label
        if isinstance(label, str):
            return label
        assert label is not None
        value = evaluate(label, self.ip.parameters)
        whole = nearest(value, "the label")
        if abs(value - whole) > _EQUAL:
            raise BlockError("oword-label", f"the label is {value:g}; it must be a whole number", "O")
        return float(whole)

    def value_of(self, flow: Flow) -> float:
        """Return the value in brackets of an O-word."""
        if not flow.arguments:
            message = f"{flow.keyword.upper()} needs a value in brackets"
            hint = f"o{shown(self.label_of(flow))} {flow.keyword} [{'10' if flow.keyword == 'repeat' else '#1 LT 10'}]"
            raise BlockError("oword-arguments", message, "O", hint=hint)
        return evaluate(flow.arguments[0], self.ip.parameters)

    def condition(self, flow: Flow) -> bool:
        """Tell whether the condition of an O-word holds."""
        return self.value_of(flow) != 0.0

    # Lines.

    def claim(self, flow: Flow, label: Label, here: Cursor) -> bool:
        """Take a label for the branch or loop that begins here; tell whether it begins for the first time.

        Raises:
            BlockError: Another one of this subroutine has it.
        """
        frame = self.calls.frame
        if flow.keyword == "while" and frame.doing is not None and label in frame.doing:
            return False
        first, keyword = self._first.setdefault((frame.label, here.source, label), (here, flow.keyword))
        if first.offset != here.offset and not keyword == flow.keyword == "do":
            article = "an" if keyword == "if" else "a"
            message = f"o{shown(label)} begins {article} {keyword.upper()} in line {first.line} already"
            hint = "give each branch and loop of a subroutine a label of its own"
            raise BlockError("oword-duplicate", message, "O", hint=hint)
        return first is here

    def _check_end(self, keyword: str, label: Label, here: Cursor) -> None:
        """Warn of a branch or loop without an end, which no jump has to look for while the program ends inside: it is run once."""
        labels, end = self.subroutines.labels(here.source), _BEGINNING[keyword]
        if labels.next(here.offset, label, (end,), self.subroutines.resolved, over_borders=False) is None:
            message = f"o{shown(label)} {keyword.upper()} has no {end.upper()}: what follows is run once"
            hint = f"it must stand below, with the label o{shown(label)}, in the same subroutine"
            self.ip.warn("oword-unclosed", message, "O", hint)

    def next_mark(self, here: Cursor, label: Label, keywords: tuple[str, ...], wanted: str) -> Marked:
        """Return the first later line of the subroutine with this label and one of the keywords."""
        labels = self.subroutines.labels(here.source)
        mark = labels.next(here.offset, label, keywords, self.subroutines.resolved, over_borders=False)
        if mark is not None:
            return mark
        if wanted == _LOOP_END:
            hint = "BREAK and CONTINUE have the label of the loop around them"
            raise BlockError("oword-unmatched", f"o{shown(label)} stands in no loop", "O", hint=hint)
        over = labels.next(here.offset, label, keywords, self.subroutines.resolved, over_borders=True)
        hint = (
            self._parted(over, labels.border(here.offset), wanted)
            or f"it must stand below, with the label o{shown(label)}, in the same subroutine"
        )
        raise BlockError("oword-unmatched", f"o{shown(label)} has no {wanted.upper()}", "O", hint=hint)

    def previous_mark(self, here: Cursor, label: Label, keywords: tuple[str, ...], word: str) -> Marked:
        """Return the last earlier line of the subroutine with this label and one of the keywords."""
        labels = self.subroutines.labels(here.source)
        mark = labels.previous(here.offset, label, keywords, self.subroutines.resolved)
        if mark is not None:
            return mark
        over = labels.first(label, keywords, self.subroutines.resolved)
        if over is not None and over.cursor.offset > here.offset:
            over = None
        message = f"o{shown(label)} {word.upper()} with no {keywords[0].upper()}"
        hint = (
            self._parted(over, over and labels.border(over.cursor.offset), keywords[0])
            or f"it must stand above, with the label o{shown(label)}, in the same subroutine"
        )
        raise BlockError("oword-unmatched", message, "O", hint=hint)

    @staticmethod
    def _parted(over: Marked | None, border: Marked | None, keyword: str) -> str:
        """Return the help where the O-word that is missed stands behind the `border` of a subroutine, else ""."""
        if over is None or border is None or border.keyword != "sub":
            return ""
        return (
            f"the subroutine that begins in line {border.cursor.line} parts it from the {keyword.upper()} "
            f"in line {over.cursor.line}: define it outside of branches and loops"
        )
