"""The lines of a profile's subroutine in the order of their execution: O-words lead as they do in any call, settings are done.

LinuxCNC's turning cycles run the subroutine of a profile as a call (seen with its interpreter). Its motions are not made; the
cycle takes their words.
"""

from __future__ import annotations

from collections.abc import Iterator

from cncgen.gcode.block import Parsed
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.text import grammar
from cncgen.gcode.text.expressions import evaluate
from cncgen.gcode.text.labels import Cursor, Label

#: Lines executed beyond which a profile counts as endless.
_MAX_STEPS = 20_000
#: Local numbered parameters, #1 to #30.
_LOCALS = 30


def profile_lines(ip: Interpreter, label: Label, after: Cursor) -> Iterator[list[tuple[str, float]]]:
    """Yield the words of each line that a profile's subroutine executes, values computed; its locals are its own.

    Args:
        ip: The interpreter, whose parameters the lines read and set.
        label: The subroutine's name.
        after: The line behind its beginning.

    Raises:
        BlockError: A line is wrong, or an O-word leads nowhere.
        Astray: Calls nest too deep.
    """
    assert ip.flow is not None
    flow, calls = ip.flow, ip.flow.calls
    depth = len(calls.frames)
    calls.enter(label, after, [0.0] * _LOCALS)
    lines: dict[Cursor, tuple[Parsed, Cursor]] = {}
    here = after
    try:
        for _ in range(_MAX_STEPS):
            if here.offset >= len(flow.subroutines.sources[here.source]):
                return
            parsed, following = lines.get(here) or lines.setdefault(here, _read(ip, here))
            if parsed.flow is not None:
                here = flow.run(parsed.flow, here, following) or following
                if len(calls.frames) == depth:
                    return
                continue
            words = [(letter, evaluate(value, ip.parameters)) for letter, value in parsed.words]
            _set(ip, parsed)
            yield words
            here = following
        raise BlockError("profile-length", f"the profile executes more than {_MAX_STEPS} lines", "Q")
    finally:
        while len(calls.frames) > depth:
            calls.leave()


def _read(ip: Interpreter, here: Cursor) -> tuple[Parsed, Cursor]:
    """Return a line, and where the next one begins."""
    assert ip.flow is not None
    text = ip.flow.subroutines.sources[here.source]
    after = Cursor(here.source, text.line_end(here.offset) + 1, here.line + 1)
    return grammar.parse(text.text_at(here.offset), ip.dialect), after


def _set(ip: Interpreter, parsed: Parsed) -> None:
    """Set the parameters of a line; all values are read before."""
    parameters = ip.parameters
    found = [
        (x if isinstance(x, str) else evaluate(x, parameters), evaluate(value, parameters))
        for x, value in parsed.settings
    ]
    for target, number in found:
        if isinstance(target, str):
            parameters.set_name(target, number)
        else:
            parameters.set_number(target, number)
