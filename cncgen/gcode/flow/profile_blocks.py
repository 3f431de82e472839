"""The blocks of a profile's subroutine in the order of their execution: O-words act as in any call, settings are made.

LinuxCNC's turning cycles run the subroutine of a profile as a call (seen with its interpreter). Its motions are not made; the
cycle takes their words.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from cncgen.gcode.block import Block, Parsed
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow.compiling import Compiler
from cncgen.gcode.flow.o_words import FlowControl
from cncgen.gcode.flow.reading import LineReader
from cncgen.gcode.text.labels import Cursor, Label

#: Lines executed beyond which a profile counts as endless.
_MAX_STEPS = 20_000
#: Local numbered parameters, #1 to #30.
_LOCALS = 30


def profile_blocks(control: FlowControl, lines: LineReader, label: Label, after: Cursor) -> Iterator[Block]:
    """Yield each block that a profile's subroutine executes, values computed; its locals are its own.

    Args:
        control: O-words and the calls in progress; its interpreter's parameters are read and set.
        lines: The lines of the run.
        label: The subroutine's name.
        after: The line behind its beginning.

    Raises:
        BlockError: A line is wrong, or an O-word leads nowhere.
        Astray: Calls nest too deep.
    """
    found: list[Block] = []
    compiler = Compiler(control.ip, control, lambda block, plans: found.append(block))
    calls = control.calls
    depth = len(calls.frames)
    calls.enter(label, after, [0.0] * _LOCALS)
    met: dict[Cursor, tuple[Parsed, Callable[[], None], Cursor]] = {}
    here = after
    try:
        for _ in range(_MAX_STEPS):
            if here.offset >= len(control.subroutines.sources[here.source]):
                return
            if here not in met:
                parsed = lines.parse(lines.text(here))
                met[here] = parsed, compiler.action(parsed, here), lines.after(here)
            parsed, run, following = met[here]
            if parsed.flow is not None:
                here = control.run(parsed.flow, here, following) or following
                if len(calls.frames) == depth:
                    return
                continue
            run()
            yield from found
            found.clear()
            here = following
        raise BlockError("profile-length", f"the profile executes more than {_MAX_STEPS} lines", "Q")
    finally:
        while len(calls.frames) > depth:
            calls.leave()
