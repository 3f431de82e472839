"""G47 P of Haas's mills engraves a line of text (Mill Operator's Manual, 96-8000, "G47 Text Engraving").

P0 takes the first comment of its block, P32 to P126 one character by its number in ASCII. X and Y are the lower left corner of the first letter,
I the angle of the line, J its height (1 inch), Z the depth, R the height between strokes and at the end, E the feed downwards, F the feed.
Letters are our own, since the control's stand in a program of the control, O9876.
"""

from __future__ import annotations

import cmath
import math
import re

from cncgen.gcode.block import Block
from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.letters import engraved, strokes
from cncgen.gcode.codes.lines import check_cycle_feed
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.grammars.terminals import FANUC
from cncgen.units import INCH

#: The word P of a text, and the first and last character that P is.
_TEXT, _FIRST, _LAST = 0, 32, 126
_HEIGHT = 1.0


def engrave(ip: Interpreter, block: Block) -> None:
    """Engrave the text of a block; raise where the text is a number that the control counts, or a word is missing or cannot be."""
    words, text = block.words, _text_of(ip, block)
    height = words.get("j", _HEIGHT * (1.0 if ip.state.inches else INCH))
    refuse(
        "G47",
        ("z" not in words, "cycle-words", "G47 P has no depth Z", "G47 P0 X10. Y10. J5. R1. Z-0.2 F300. (TEXT)"),
        (not ip.state.absolute, "not-read", "G47 P in G91 is not read", "G90 stands before it"),
        (height <= 0.0, "cycle-words", f"J{height:g} of G47 is no height of letters", "J is above 0"),
    )  # fmt: skip
    check_cycle_feed(ip, block, "G47")
    message = (
        "G47 engraves letters of our own: those of the control are not published, and are longer or shorter"
    )
    hint = "place, height, angle, depth and feeds are the program's"
    ip.warn_once("engraving-letters", message, "G47", hint)
    end = ip.end_point(block)
    feed, above, depth = ip.state.feed, words.get("r", ip.state.position[2]), end[2]
    cutter = FlatCutter(ip, complex(*end[:2]), cmath.rect(1.0, math.radians(words.get("i", 0.0))))
    cutter.to(0j, rapid=True)
    engraved(cutter, strokes(text, height), (above, depth), (words.get("e", feed), feed))


def _text_of(ip: Interpreter, block: Block) -> str:
    """Return the text that a block engraves; raise where it is none that is known."""
    number = block.words.get("p", -1.0)
    if _FIRST <= number <= _LAST and number.is_integer():
        return chr(int(number))
    hint = "P0 engraves the comment of the block, P32 to P126 a character"
    if number != _TEXT:
        message = "the number that G47 P1 engraves is counted by the control: not read"
        raise BlockError(
            "not-read", message if number == 1.0 else "G47 has no P that is read", "G47", hint=hint
        )
    line = ip.flow_control().subroutines.sources[block.source].text_at(block.offset)
    comments = [match[0][1:-1] for match in re.finditer(FANUC["COMMENT"], line) if match[0][0] == "("]
    text = comments[0] if comments else ""
    if not text:
        message = "G47 P0 has no comment, which is its text"
        raise BlockError("cycle-words", message, "G47", hint="G47 P0 (TEXT) engraves TEXT")
    return text
