"""G38.2 to G38.5: probing, which here moves to the programmed point: there is nothing to touch."""

from __future__ import annotations

import math

from cncgen.diagnostics import Severity
from cncgen.gcode.block import Block
from cncgen.gcode.codes import Code, Handler
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.lines import check_feed, has_axis
from cncgen.gcode.modal import Stage
from cncgen.gcode.parameters import PROBE, PROBE_HIT

_WORDS = "xyzabcuvw@^"
#: A probe must move by this in X Y Z (mm or inch).
_LEAST = {False: 0.254, True: 0.01}


def _probe(tenths: int) -> Handler:
    name = f"G{tenths / 10:g}"

    def run(ip: Interpreter, block: Block) -> None:
        state = ip.state
        state.motion = tenths
        if not has_axis(block):
            raise BlockError("axis-missing", f"{name} has no axis word", name)
        if state.compensation != 40:
            raise BlockError("probe-mode", f"{name} does not go with cutter compensation", name)
        if state.feed_mode != 94:
            raise BlockError("probe-mode", f"{name} does not go with G{state.feed_mode}", name)
        check_feed(ip, block, name)
        end = ip.end_point(block)
        rotary = end[3:6] != state.position[3:6]
        if not rotary and math.dist(end[:3], state.position[:3]) < _LEAST[state.inches]:
            raise BlockError("probe-short", f"{name} starts nearly where it ends", name)
        ip.warn(
            BlockError("probe-not-run", f"{name} is planned to the programmed point", name), Severity.NOTE
        )
        ip.sink.call("TURN_PROBE_ON()")
        ip.sink.straight_probe(end)
        ip.sink.call("TURN_PROBE_OFF()", Event_probe)
        state.position, state.moved = end, True
        ip.parameters.numbers[PROBE : PROBE + 9] = end
        ip.parameters.numbers[PROBE_HIT] = 0.0

    return run


from cncgen.toolpath.record import Event  # noqa: E402

Event_probe = Event("probe")

CODES = tuple(
    Code("G", tenths, "motion", Stage.MOTION, _probe(tenths), f"probe {text}", _WORDS, "motion")
    for tenths, text in (
        (382, "towards the part, with an error where nothing is touched"),
        (383, "towards the part"),
        (384, "away from the part, with an error where contact is not lost"),
        (385, "away from the part"),
    )
)
