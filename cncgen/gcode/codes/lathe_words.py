"""Words of FANUC's lathes: diameters along X, and distances U V W along X Y Z (B-64304EN-1, 8.1 and 8.4)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from cncgen.gcode.block import Block
from cncgen.gcode.errors import BlockError

if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

X, Z = 0, 2
#: Words of distances: the axis and its column.
_DISTANCES = {"u": ("x", X), "v": ("y", 1), "w": ("z", Z)}
#: Codes, in tenths, whose X U W are no place of the tool: G4, and the cycles whose U and W are depths or allowances.
_OTHER_WORDS = frozenset((40, 700, 710, 720, 730))
_G10 = 100


def in_radius(ip: Interpreter, block: Block) -> Block:
    """Return a block with its diameter X as a radius, and its distances U V W as the X Y Z where they lead.

    Raises:
        BlockError: A place and a distance along the same axis.
    """
    words = block.words
    if not words.keys() & {"x", "u", "v", "w"} or not _OTHER_WORDS.isdisjoint(block.g):
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
    return replace(block, words=found)
