"""G38.2 to G38.5: probing. Here it moves to the programmed point; if the code demands contact, contact is made there.

Source: Kramer et al. (2000), section 3.5.9; G38.3 to G38.5 as in LinuxCNC's manual.
"""

from __future__ import annotations

import math
from array import array
from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.lines import check_feed, need_axis
from cncgen.gcode.codes.table import COMPENSATION, ROTARY_PATH, TOOL_POINT, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.gcode.state.predefined import PROBE, PROBE_HIT
from cncgen.records import replace
from cncgen.toolpath.record import Event

_WORDS = "xyzabcuvw@^"
#: A probe that must find something and moves by less than this does not move (program units); LinuxCNC lets others.
_LEAST = 1e-9
#: G38.2 and G38.4: an error where contact is not made, or not lost.
_DEMANDING = (382, 384)
_HINT = {
    True: "it counts as touched there: parameters #5061 and after hold this point, #5070 is 1",
    False: "nothing can be touched here: parameters #5061 and after hold this point, #5070 is 0",
}


def _probe(ip: Interpreter, block: Block, tenths: int) -> None:
    name = f"G{tenths / 10:g}"
    state = ip.state
    state.motion = tenths
    need_axis(block, name)
    if state.feed_mode != 94:
        raise BlockError("probe-mode", f"{name} does not go with G{state.feed_mode}", name)
    check_feed(ip, block, name)
    end = ip.end_point(block)
    if tenths in _DEMANDING and math.dist(end, state.position) < _LEAST:
        raise BlockError("probe-short", f"{name} starts where it ends", name)
    # Where contact is demanded, the program goes on only after it was made; `rs274` reports a probe without contact.
    touched = tenths in _DEMANDING and not ip.options.stand_alone
    ip.note_once("probe-not-run", f"{name} is planned to the programmed point", name, _HINT[touched])
    ip.sink.call("TURN_PROBE_ON()")
    ip.sink.straight_probe(end)
    ip.sink.call("TURN_PROBE_OFF()", Event("probe"))
    state.position, state.moved = ip.base.where(end), True
    ip.parameters.numbers[PROBE : PROBE + 9] = array("d", end)
    ip.parameters.numbers[PROBE_HIT] = float(touched)


def skip(ip: Interpreter, block: Block) -> None:
    """G31 of FANUC: a line that the skip signal ends, here never; its end is in #5061 and after. R1 of Mitsubishi ramps its speed."""
    need_axis(block, "G31")
    check_feed(ip, block, "G31")
    end = ip.end_point(block)
    ip.note_once("probe-not-run", "G31 is planned to the programmed point", "G31")
    ip.go(end)
    # On lathes X is a diameter, as in all variables.
    across = 2.0 if ip.state.diameter else 1.0
    ip.parameters.numbers[PROBE : PROBE + 9] = array("d", (across * end[0], *end[1:]))


def tell(ip: Interpreter, name: str, what: str) -> None:
    """Say that a line which ends at a signal was planned to its place, and what the code would set."""
    message = f"{name} is planned to the place where the probe is looked for, and {what} stays as it is"
    hint = "offsets and origins that it would set are those of --tool-table and --parameters"
    ip.warn_once("probe-not-run", message, name, hint)


def middle(ip: Interpreter, block: Block) -> None:
    """G136 of Haas: as G31, the middle between its place and the last one becomes the origin (Haas mill operator's manual, "G136")."""
    need_axis(block, "G136")
    check_feed(ip, block, "G136")
    ip.go(ip.end_point(block))
    tell(ip, "G136", "the origin")


def length(ip: Interpreter, block: Block) -> None:
    """G37 H Z F of Haas: feed down to the probe, which stands at Z0 of the coordinate system (Haas mill operator's manual, "G37").

    Raises:
        BlockError: It has no F: G37 of other controls goes to the place of its probe, which their parameters have.
    """
    if "f" not in block.words:
        message = "G37 (automatic tool length measurement) has no F: where other controls than Haas's have their probe, is not known"
        raise BlockError("not-read", message, "G37", hint="set the length by G10 L10, or in the tool table")
    ip.go([0.0 if k == 2 else place for k, place in enumerate(ip.state.position)])
    tell(ip, "G37", "the tool's length")


#: Programs of the makers of probes, which the control has and the text has not: Renishaw's Inspection Plus, Haas's VPS; and
#: the one of Renishaw's that moves to a place, stopping where something is touched.
MEASURING = frozenset((*range(9800, 9900), 9023, 9995, 9996))
POSITIONING = 9810
#: Arguments of that one: axes by the number of their parameter, and the feed.
_PLACE = {24: "x", 25: "y", 26: "z", 9: "f"}


def measures(ip: Interpreter, block: Block, number: int, values: list[float]) -> bool:
    """Tell whether a missing program is one of a probe's maker, and apply its effect on the position.

    Measuring leads back to its start, and its results are unknown: it is ignored with a warning.
    """
    if number not in MEASURING:
        return False
    if number == POSITIONING:
        words = {letter: values[k - 1] for k, letter in _PLACE.items() if values[k - 1] == values[k - 1]}
        motion = ip.state.motion
        ip.execute(replace(block, words=words, g=(10,), m=()))
        ip.state.motion = motion
    else:
        ip.sink.block = block
        message = f"O{number} measures with a probe: passed over, and what it would set stays as it is"
        hint = "its motions take time that is not counted; offsets and parameters that it sets are those of --parameters"
        ip.warn_once("probe-not-run", message, "P", hint)
    return True


_SKIP = Code("G", 310, "non-modal", Stage.MOTION, skip, "line that the skip signal ends", "xyzabcuvwpqr", "own",
    dialects=("fanuc",), refused=("ends at a signal", COMPENSATION | ROTARY_PATH | TOOL_POINT))  # fmt: skip
_PROBES = tuple(
    Code("G", tenths, "motion", Stage.MOTION, partial(_probe, tenths=tenths), f"probe {text}", _WORDS, "motion",
        refused=("probes", COMPENSATION))
    for tenths, text in (
        (382, "towards the part, with an error where nothing is touched"),
        (383, "towards the part"),
        (384, "away from the part, with an error where contact is not lost"),
        (385, "away from the part"),
    )
)  # fmt: skip
_MEASURES = (
    Code("G", 1360, "non-modal", Stage.MOTION, middle, "line that the skip signal ends; the middle of two is the origin (Haas)",
        "xyzabcijk", "own", dialects=("fanuc",), refused=_SKIP.refused, without="lathes"),
    Code("G", 370, "non-modal", Stage.MOTION, length, "measure a tool's length with a probe (Haas)", "zh", "own",
        dialects=("fanuc",), takes="h", moves="Z", refused=_SKIP.refused, without="lathes"),
)  # fmt: skip
CODES = (_SKIP, *_PROBES, *_MEASURES)
