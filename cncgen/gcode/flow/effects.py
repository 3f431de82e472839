"""The effect of a line, for the course of a run and for the profiles of turning cycles."""

from __future__ import annotations

from collections.abc import Callable

from cncgen.gcode.block import Flow, Parsed
from cncgen.gcode.errors import BlockError
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import empty_block

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.flow.compiling import Compiler
    from cncgen.gcode.flow.o_words import FlowControl

#: Runs a line; gives where it leads, None for the next line.
Effect = Callable[[], Cursor | None]


def effect_of(
    control: FlowControl, compiler: Callable[[], Compiler], parsed: Parsed, here: Cursor, after: Cursor
) -> tuple[Effect, bool]:
    """Return what a line does, `after` which another stands, and whether it is an O-word."""
    if parsed.deletable and control.ip.options.block_delete:
        return lambda: None, False
    begin, jumps = None, False
    if parsed.flow is not None and parsed.flow.then is None:
        begin = _o_word(control, parsed.flow, here, after)
        if not (parsed.words or parsed.settings):
            return begin, True
        # Words behind the number of a program, or settings before a jump (FANUC).
        jumps = parsed.flow.keyword == "goto"
        if jumps and parsed.words:
            raise BlockError(
                "unsupported-flow", "GOTO stands beside words", "GOTO", hint="give it a line of its own"
            )
        parsed.flow = None
    run = compiler().action(parsed, here) if parsed.flow is None else compiler().then(parsed.flow, here)

    def effect() -> Cursor | None:
        if begin is not None and not jumps:
            begin()
        control.flush()
        run()
        if begin is not None and jumps:
            return begin()
        return control.follow_jump(here, after) if control.ip.jump is not None else None

    return effect, False


def _o_word(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Effect:
    """Return the effect of an O-word; blocks that wait run before it where its values may depend on where the machine is."""
    block = empty_block(here)

    def effect() -> Cursor | None:
        # Conditions of macros may read where the machine is.
        if flow.asks_state or control.ip.dialect == "fanuc":
            control.flush()
        control.ip.base.block = block
        return control.run(flow, here, after)

    return effect
