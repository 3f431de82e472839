"""F, and what it means: inverse time (G93), units per minute (G94), units per revolution (G95).

Source: Kramer et al. (2000), sections 2.1.2.5, 3.5.19 and 3.7.1; G95 as in LinuxCNC's manual.
"""

from __future__ import annotations

import math
from functools import partial

from cncgen.diagnostics import Severity
from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import BOTH, TOOL_POINT, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage

#: Feeds below this are not meant a minute, mm/min; feeds above this not a revolution of a lathe, mm.
LEAST_FEED, MOST_FEED = 0.5, 10.0
_MEANING = {93: "inverse time", 94: "units per minute", 95: "units per revolution"}


def set_feed(ip: Interpreter, block: Block) -> None:
    """F."""
    value = block.words["f"]
    if value < 0.0:
        raise BlockError("negative-feed", f"F{value:g} is negative", "F")
    least, most = feeds_meant(ip)
    if not (value == 0.0 or least <= value <= most):
        _doubt(ip, block, value)
    ip.state.feed = value
    # In inverse time the rate belongs to the motion of the block, which passes it on with its length.
    if ip.state.feed_mode != 93:
        ip.sink.set_feed_rate(value)


def feeds_meant(ip: Interpreter) -> tuple[float, float]:
    """Return the feeds between which one is not doubted, in program units; the first doubt of a run is the only one."""
    # SINUMERIK's G97 has a feed a revolution, which a program that means mm a minute by it does not know.
    turned = ip.dialect == "sinumerik" and ip.state.feed_mode == 95
    if ip.feed_doubted or not (ip.dialect in BOTH or turned):
        return 0.0, math.inf
    unit = ip.state.unit_mm
    if ip.state.feed_mode == 94:
        return LEAST_FEED / unit, math.inf
    return 0.0, MOST_FEED / unit if turned or (ip.lathe and ip.state.feed_mode == 95) else math.inf


def _doubt(ip: Interpreter, block: Block, feed: float) -> None:
    """Remark on a feed that nobody can mean: a lathe's F0.3, read as mm a minute, makes hours of setpoints of a part of two minutes."""
    in_force = ip.codes.row("G", ip.state.motion)
    if any(row.pitched for row in ip.codes.of(block)) or (in_force is not None and in_force.pitched):
        return
    ip.feed_doubted = True
    mm = feed * ip.state.unit_mm
    if ip.dialect == "sinumerik":
        message = f"F{feed:g} is {mm:.4g} mm a revolution: at 1000 rev/min {mm:.4g} m a minute"
        hint = "G95, G96 and G97 have a feed a revolution, G94, G961 and G971 one a minute"
        values = {"feed_mm_rev": mm}
    elif ip.state.feed_mode == 95:
        message = f"F{feed:g} in G99 is {mm:.4g} mm a revolution: at 1000 rev/min {mm:.4g} m a minute"
        hint, values = "a feed a minute is of G98", {"feed_mm_rev": mm}
        if not ip.feed_mode_said:
            message += "; it is read as mm a minute, since neither G98 nor G99 was said"
            hint = "G98 or G99 says which"
            set_mode(ip, block, 94)
    else:
        message = f"F{feed:g} is {mm:.3g} mm a minute: 100 mm take {100.0 / mm / 60.0:.1f} hours"
        hint = "a feed a revolution is of G95; --dialect fanuc-lathe reads it so without G95"
        hint, values = "a feed a revolution is of G99" if ip.lathe else hint, {"feed_mm_min": mm}
    ip.remark(BlockError("feed-doubtful", message, "F", hint=hint, values=values), Severity.WARNING)


def set_mode(ip: Interpreter, block: Block, mode: int) -> None:
    """G93, G94, G95."""
    ip.feed_mode_said = True
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


CODES = (
    Code("F", 0, "F", Stage.FEED, set_feed, "feed rate", "f"),
    Code("G", 930, "feed mode", Stage.FEED_MODE, partial(set_mode, mode=93), "F is moves per minute (inverse time)", waits=True,
        without="lathes", restores=("feed_mode", 93)),
    Code("G", 940, "feed mode", Stage.FEED_MODE, partial(set_mode, mode=94), "F is units per minute", waits=True, without="lathes",
        restores=("feed_mode", 94)),
    Code("G", 950, "feed mode", Stage.FEED_MODE, partial(set_mode, mode=95), "F is units per revolution of the spindle",
        refused=("feeds per revolution", TOOL_POINT), without="lathes", restores=("feed_mode", 95)),
)  # fmt: skip
