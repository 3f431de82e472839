"""F, and what it means: inverse time (G93), units per minute (G94), units per revolution (G95).

Source: Kramer et al. (2000), sections 2.1.2.5, 3.5.19 and 3.7.1; G95 as in LinuxCNC's manual.
"""

from __future__ import annotations

from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage

_MEANING = {93: "inverse time", 94: "units per minute", 95: "units per revolution"}


def set_feed(ip: Interpreter, block: Block) -> None:
    """F."""
    value = block.words["f"]
    if value < 0.0:
        raise BlockError("negative-feed", f"F{value:g} is negative", "F")
    ip.state.feed = value
    # In inverse time the rate belongs to the motion of the block, which passes it on with its length.
    if ip.state.feed_mode != 93:
        ip.sink.set_feed_rate(value)


def _set_mode(ip: Interpreter, mode: int) -> None:
    if ip.dialect == "fanuc" and ip.state.feed_mode == mode:
        # A repeated code changes nothing on FANUC's controls; in RS274/NGC it drops the feed.
        return
    ip.state.feed_mode = mode
    ip.sink.call(f'COMMENT("interpreter: feed mode set to {_MEANING[mode]}")')
    ip.sink.set_feed_mode(mode, synched=mode == 95)
    if mode != 93:
        # A rate of the other meaning must not live on (RS274/NGC, 3.5.19).
        ip.state.feed = 0.0
        ip.sink.set_feed_rate(0.0)


def inverse_time(ip: Interpreter, block: Block) -> None:
    """G93."""
    _set_mode(ip, 93)


def per_minute(ip: Interpreter, block: Block) -> None:
    """G94."""
    _set_mode(ip, 94)


def per_revolution(ip: Interpreter, block: Block) -> None:
    """G95."""
    _set_mode(ip, 95)


CODES = (
    Code("F", 0, "F", Stage.FEED, set_feed, "feed rate", "f"),
    Code("G", 930, "feed mode", Stage.FEED_MODE, inverse_time, "F is moves per minute (inverse time)"),
    Code("G", 940, "feed mode", Stage.FEED_MODE, per_minute, "F is units per minute"),
    Code("G", 950, "feed mode", Stage.FEED_MODE, per_revolution, "F is units per revolution of the spindle"),
)
