"""G12 and G13 of Haas's mills: a circular pocket about the place where the tool stands (Haas mill operator's manual, "G12, G13").

I is the radius of the first circle, K that of the finished one, Q the step between them; D, which stays in force, takes the tool's radius off. With L the depth Z
is cut in as many steps in G91. The tool goes out from the middle and back to it along X: this way is our own choice, the circles are
those of the cycle.
"""

from __future__ import annotations

from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.cutter_compensation import tool_of_radius
from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.lines import check_cycle_feed
from cncgen.gcode.codes.steps import MOST, steps_of
from cncgen.gcode.codes.table import Code
from cncgen.gcode.codes.tools import whole
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage

_Z = 2


def _radii(words: dict[str, float], name: str, tool: float) -> list[float]:
    """Return the radii of the tool's circles, the smallest first; raise where I, K and Q do not go together, or the tool does not fit."""
    first = words.get("i", 0.0)
    last, step = words.get("k", first), words.get("q", 0.0)
    wrong = last < first or (last > first and step <= 0.0)
    order = f"K{last:g} of {name} is to be I{first:g} or more, with a step Q above 0 between them"
    smaller = f"the circle of {name}, {last:g}, is not larger than the tool's radius, {tool:g}"
    message = f"{name} has no radius I above 0"
    refuse(name, (first <= 0.0, "cycle-words", message, "I is the radius of the first circle"))
    refuse("K", (wrong, "cycle-words", order, "G13 I0.3 K1. Q0.3 cuts circles of 0.3, 0.6, 0.9 and 1"))
    refuse(name, (last <= tool, "cycle-tool", smaller, "D0 takes no radius off"))
    count = steps_of(last - first, step, "Q", f"Q{step:g} of {name} makes {{}} circles", least=0)
    return [radius for k in range(count + 1) if (radius := min(first + k * step, last) - tool) > 0.0]


def _depths(ip: Interpreter, block: Block, name: str) -> list[float]:
    start = ip.state.position[_Z]
    if "z" not in block.words:
        return [start]
    count = whole(block, "l", name) if "l" in block.words else 1
    if not 1 <= count <= MOST or (count > 1 and ip.state.absolute):
        message = f"L{count} of {name} cuts Z as often in steps: it is from 1 to {MOST}, and above 1 in G91"
        raise BlockError("cycle-repeats", message, "L", hint="G91 G13 Z-0.1 L5 cuts to 0.5")
    if ip.state.absolute:
        return [block.words["z"]]
    return [start + block.words["z"] * (k + 1) for k in range(count)]


def _pocket(ip: Interpreter, block: Block, name: str, sense: int) -> None:
    state = ip.state
    elsewhere = state.plane != 17 or state.compensation != 40
    bare = "d" not in block.words and state.radius_number is None
    refuse(
        name,
        (elsewhere, "cycle-plane", f"{name} works in G17 and G40", "use G17 and G40 before it"),
        (bare, "comp-diameter", f"{name} has no D", "D is the number of the tool's radius, D0 none"),
    )
    check_cycle_feed(ip, block, name)
    tool = tool_of_radius(ip, block, name)
    radii = _radii(block.words, name, abs(tool.diameter) * ip.table_scale() / 2.0)
    cutter = FlatCutter(ip)
    middle = cutter.place()
    for depth in _depths(ip, block, name):
        cutter.to(z=depth)
        for radius in radii:
            cutter.to(middle + radius)
            cutter.arc(middle + radius, middle, sense)
        cutter.to(middle)
    state.moved = True


CODES = tuple(
    Code("G", number, "non-modal", Stage.MOTION, partial(_pocket, name=name, sense=sense), f"circular pocket, {way} (Haas)",
        "zikqld", "own", dialects=("fanuc",), takes="d", moves="plane", without="lathes")
    for number, name, sense, way in ((120, "G12", -1, "clockwise"), (130, "G13", 1, "counter-clockwise"))
)  # fmt: skip
