"""The lines of a profile in the order of their execution: O-words, macros and settings act as anywhere else in a run, and each block goes
to the cycle in place of the machine.

LinuxCNC's turning cycles run the subroutine of a profile as a call (seen with its interpreter); FANUC's run lines of their own program.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from cncgen.gcode.block import Block
from cncgen.gcode.budget import LINE
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow.calls import LOCALS
from cncgen.gcode.flow.line_by_line import LineRunner
from cncgen.gcode.flow.o_words import FlowControl
from cncgen.gcode.text.labels import Cursor, Label

_MAX_STEPS = 20_000
Take = Callable[[Block], None]


def run_profile(control: FlowControl, take: Take, first: Cursor, end: Cursor | Label, word: str) -> None:
    """Run a profile: each block that its lines execute, values computed, is taken by the cycle.

    Args:
        control: O-words and the calls in progress; its interpreter's parameters are read and set.
        take: Receives the blocks.
        first: The first line.
        end: The last line; or the label of the subroutine, whose end it is, and whose locals are its own
            (FANUC's go on with those of the caller).
        word: The word of the cycle that names the profile.

    Raises:
        BlockError: A line is wrong, or leads out of the profile.
        Astray: Calls nest too deep.
    """
    calls, block = control.calls, control.ip.base.block
    depth = len(calls.frames)
    if not isinstance(end, Cursor):
        calls.enter(end, first, [0.0] * LOCALS if control.ip.dialect == "linuxcnc" else None)
    try:
        for here, target in _steps(control, take, first, word):
            if isinstance(end, Cursor):
                if (
                    len(calls.frames) != depth
                    or not first.offset <= target.offset <= control.lines.after(end).offset
                ):
                    message = f"line {here.line} leads out of the profile, which ends in line {end.line}"
                    hint = "a profile is moves, and jumps and loops within it"
                    raise BlockError("profile-flow", message, word, hint=hint)
                if target.offset > end.offset:
                    return
            elif len(calls.frames) == depth:
                return
    finally:
        while len(calls.frames) > depth:
            calls.leave()
        control.ip.base.block = block


def _steps(control: FlowControl, take: Take, here: Cursor, word: str) -> Iterator[tuple[Cursor, Cursor]]:
    """Run line after line up to the end of the text; yield each with the line that it leads to."""
    runner, lines = LineRunner(control, take), control.lines
    for _ in range(_MAX_STEPS):
        if here.offset >= len(control.subroutines.sources[here.source]):
            return
        control.ip.budget.count(1, LINE)
        try:
            after = lines.after(here)
            target = runner.run(lines.parse(lines.text(here)), here, after) or after
        except BlockError as error:
            raise error.within(f"line {here.line} of the profile", word) from None
        yield here, target
        here = target
    raise BlockError("profile-length", f"the profile executes more than {_MAX_STEPS} lines", word)
