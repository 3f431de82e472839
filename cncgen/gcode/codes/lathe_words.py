"""Words of FANUC's lathes: diameters, distances U V W, and roundings and chamfers R I K of lines (B-64304EN-1, 8 and 4.5).

`turned` puts them in the words of the interpreter, once, before anything else sees the block.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from cncgen.diagnostics import Severity
from cncgen.gcode.block import Block
from cncgen.gcode.errors import BlockError

if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

X, Z = 0, 2
#: Words of distances: the axis and its column.
_DISTANCES = {"u": ("x", X), "v": ("y", 1), "w": ("z", Z)}
_G10 = 100
#: Codes, in tenths, whose X U W do not place the tool: G4, and the cycles whose U and W are depths or allowances.
_OTHER_WORDS = frozenset((40, 700, 710, 720, 730))
_LINE = 10
#: Codes, in tenths, beside which a block makes no line even while G1 is in force.
_NO_LINES = frozenset((0, 20, 30, 280, 290, 300, 310, 320, 500, 520, 650, 660, 740, 750, 760, 900, 920, 940))
#: Words of a line for the corner at its end, and those of mills.
_CORNERS = {"r": ",r", "i": ",c", "k": ",c"}


def turned(ip: Interpreter, block: Block) -> Block:
    """Return a block with X as a radius, distances as the place where they lead, and the corner of a line as ,R or ,C.

    Raises:
        BlockError: A place and a distance along the same axis, or an angle in place of one.
    """
    words = block.words
    if not words.keys() & {"x", "z", "u", "v", "w", "a"} or not _OTHER_WORDS.isdisjoint(block.g):
        return block
    found = dict(words)
    if "x" in found:
        found["x"] *= 0.5
    if _G10 in block.g:
        return replace(block, words=found)
    for letter, (axis, column) in _DISTANCES.items():
        if letter in found:
            if axis in found:
                message = f"{axis.upper()} and {letter.upper()} both say where {axis.upper()} goes"
                raise BlockError("axis-words-twice", message, letter.upper(), hint="write one of them")
            distance = found.pop(letter) * (0.5 if column == X else 1.0)
            found[axis] = ip.state.position[column] + distance
    if _LINE in block.g or (ip.state.motion == _LINE and _NO_LINES.isdisjoint(block.g)):
        _corner(ip, block, found)
    return replace(block, words=found)


def _corner(ip: Interpreter, block: Block, words: dict[str, float]) -> None:
    """Put R, I and K of a line as the rounding or chamfer that they mean; their sign tells only the way."""
    if "a" in words:
        message = f"A{words['a']:g} is the angle of a line, as drawings have it, which is not read"
        raise BlockError("drawing-angle", message, "A", hint="give X and Z of its end")
    if "c" in words:
        message = f"C{words['c']:g} of a line is the axis C"
        ip.base.block = block
        ip.warn(BlockError("other-control", message, "C", hint="a chamfer is ,C"), Severity.WARNING)
    for letter, corner in _CORNERS.items():
        if letter in words:
            words[corner] = abs(words.pop(letter))
