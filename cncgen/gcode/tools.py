"""Tools: T, M6 and M61."""

from __future__ import annotations

from cncgen.gcode.block import Block
from cncgen.gcode.codes import Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.modal import Stage
from cncgen.toolpath.record import Event


def whole(block: Block, letter: str, name: str) -> int:
    """Return a word that must be a whole number, not negative."""
    value = block.words[letter]
    if abs(value - round(value)) > 1e-4:
        raise BlockError(
            "not-whole", f"{letter.upper()}{value:g} of {name} is not a whole number", letter.upper()
        )
    if value < 0:
        raise BlockError(
            "negative-number", f"{letter.upper()}{value:g} of {name} is negative", letter.upper()
        )
    return round(value)


def select(ip: Interpreter, block: Block) -> None:
    """T."""
    ip.state.selected = whole(block, "t", "the tool")
    ip.sink.call(f"SELECT_TOOL({ip.state.selected})")


def change(ip: Interpreter, block: Block) -> None:
    """M6."""
    state = ip.state
    ip.sink.call("START_CHANGE()")
    state.direction = 0
    ip.sink.set_spindle(state.speed, 0)
    ip.sink.call("STOP_SPINDLE_TURNING(0)")
    state.tool = state.selected
    ip.sink.call(f"CHANGE_TOOL({state.tool})", Event("tool", True, values={"tool": state.tool}))


CODES = (
    Code("T", 0, "T", Stage.TOOL, select, "tool to be changed in next", "t"),
    Code("M", 60, "tool change", Stage.CHANGE, change, "change to the tool of T"),
)
