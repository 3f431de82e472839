"""G45 to G48 of FANUC and Mitsubishi: motions that a tool offset makes longer or shorter (M700V programming manual, 12.6; B-64484EN,
"Tool offset (G45 to G48)").

Each word of an axis that moves goes once (G45) or twice (G47) the offset D farther, or less far (G46, G48): below 0 it goes the other
way. In G90 an axis that stays where it is does not move; in G91 a word 0 moves by the offset, in the direction of its sign. Of arcs,
a quarter and three quarters of a circle are read, whose centre I J K moves as well.
"""

from __future__ import annotations

import math
from functools import partial

from cncgen.gcode.block import AXES, AXIS_INDEX, Block
from cncgen.gcode.codes.cutter_compensation import tool_of_radius
from cncgen.gcode.codes.engraving_haas import engrave
from cncgen.gcode.codes.lines import need_axis
from cncgen.gcode.codes.table import COMPENSATION, ROTARY_PATH, TOOL_POINT, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import PLAIN_MOTIONS, Stage
from cncgen.records import replace

_CENTRE = "ijk"
#: Words of engraving, which G47 is on Haas's mills.
_ENGRAVING = frozenset("epr")
#: How far the words of an arc may be from those of a quarter or three quarters of a circle, program units.
_ROUNDED = 0.002


def _offset(ip: Interpreter, block: Block, name: str) -> float:
    """Return the offset of D, program units; raise where there is no D, or no such tool."""
    if ip.state.radius_number is None and not {"d", "h"} & block.words.keys():
        message = f"{name} has no D, and none is in force"
        raise BlockError("comp-diameter", message, name, hint="D is the number of the offset")
    tool = tool_of_radius(ip, block, name)
    return tool.diameter * ip.table_scale() / 2.0 if tool.number else 0.0


def _longer(ip: Interpreter, words: dict[str, float], more: float) -> dict[str, float]:
    """Return the words of a motion that goes farther in each of its axes."""
    found = dict(words)
    for letter in words.keys() & AXIS_INDEX.keys():
        value = words[letter]
        way = value - ip.state.position[AXIS_INDEX[letter]] if ip.state.absolute else value
        if way != 0.0 or not ip.state.absolute:
            found[letter] = value + more * math.copysign(1.0, way)
    return found


def _check_arc(ip: Interpreter, words: dict[str, float], name: str) -> None:
    """Raise where an arc is neither a quarter nor three quarters of a circle from one of its axes to the other."""
    first, second, _ = ip.state.plane_axes()
    end = ip.end_point(Block(words))
    ways = [abs(end[axis] - ip.state.position[axis]) for axis in (first, second)]
    centre = sorted(abs(words.get(letter, 0.0)) for letter in _CENTRE)
    if centre[1] != 0.0 or max(abs(way - centre[2]) for way in ways) > _ROUNDED:
        message = f"{name} is read on a quarter or three quarters of a circle by I, J or K alone"
        raise BlockError("not-read", message, name, hint="G41 or G42 with D moves any arc")


def _moved(ip: Interpreter, block: Block, name: str, times: float) -> None:
    words = {letter: value for letter, value in block.words.items() if letter not in "dh"}
    if _ENGRAVING & words.keys():
        engrave(ip, block)
        return
    need_axis(block, name)
    motion = next((number for number in block.g if number in PLAIN_MOTIONS), ip.state.motion)
    if motion not in PLAIN_MOTIONS:
        raise BlockError("not-read", f"{name} in a canned cycle is not read", name, hint="use G80 before it")
    more = times * _offset(ip, block, name)
    if motion in (20, 30):
        _check_arc(ip, words, name)
        words.update({k: v + more * math.copysign(1.0, v) for k, v in words.items() if k in _CENTRE and v})
    ip.codes["G", motion].run(ip, replace(block, words=_longer(ip, words, more)))


CODES = tuple(
    Code("G", number, "non-modal", Stage.MOTION, partial(_moved, name=name, times=times), f"motion {text} by the offset D",
        AXES + "dhijk" + more, "own", dialects=("fanuc",), takes="dh",
        refused=("moves by an offset", COMPENSATION | ROTARY_PATH | TOOL_POINT), without="lathes")
    for number, name, times, text, more in (
        (450, "G45", 1.0, "longer", ""), (460, "G46", -1.0, "shorter", ""),
        (470, "G47", 2.0, "twice longer", "epr"), (480, "G48", -2.0, "twice shorter", ""),
    )
)  # fmt: skip
