"""CYCLE60 of SINUMERIK: text along a line (from memory of 840D, Programming Guide, Cycles, "Engraving cycle"); its letters are our own.

Text on an arc, another reference point than the lower left corner, and polar places (VARI other than 0) are not read.
"""

from __future__ import annotations

import cmath
import math
from typing import TYPE_CHECKING

from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.letters import GAP, engraved, strokes
from cncgen.gcode.errors import refuse
from cncgen.gcode.sinumerik.cycle_modes import MillingModes
from cncgen.gcode.sinumerik.cycles import Values, check_plane, doubt_order, filled, given, milling_feed

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions


def engrave(motions: Motions, name: str, values: Values) -> None:
    """CYCLE60(TEXT, RTP, RFP, SDIS, DP, DPR, PA, PO, STA, CP1, CP2, WID, DF, FFD, FFP1, VARI, CODEP), then UMODE GMODE DMODE AMODE.

    WID is the height of capitals, DF what lies between two letters, which is usual where it is left out.
    """
    v = [0.0, *(filled(values, k) for k in range(1, 17))]
    text, vari, height = values[0] if values else None, round(v[15]), v[11]
    check_plane(motions, name)
    modes = MillingModes.of(motions, name, values, 18)
    known = isinstance(text, str) and text.strip() != ""
    refuse(
        name,
        (not known, "cycle-words", f"{name} has no text, which is its first parameter", f'{name}("ABC", 10, 0, 1, -0.2, …)'),
        ("<" in str(text), "not-read", f"{name} of a text with a variable (<…>), which the control composes, is not read", "write the text itself"),
        (vari != 0, "not-read", f"VARI = {vari} of {name} (an arc, another reference point, a length of the whole) is not read", "VARI = 0 is a line from its lower left corner"),
        (height <= 0.0 or v[12] < 0.0, "cycle-words", f"{name} has letters {height:g} high, {v[12]:g} apart", "WID and DF are above 0"),
    )  # fmt: skip
    hole, feed = modes.hole(motions, name, values[1:6]), milling_feed(motions, name, v[14])
    doubt_order(
        motions,
        name,
        "TEXT RTP RFP SDIS DP DPR PA PO STA CP1 CP2 WID DF FFD FFP1 VARI: are the values these?",
    )
    message = f"{name} engraves letters of our own: those of the control are not published, and are wider or narrower"
    hint = "place, height, angle, depth and feeds are the program's"
    motions.ip.warn_once("engraving-letters", message, name, hint)
    gap = 1.0 if given(values, 12) is None else v[12] / (GAP * height)
    hole.go(hole.back, rapid=True)
    cutter = FlatCutter(motions.ip, complex(v[6], v[7]), cmath.rect(1.0, math.radians(v[8])))
    letters = strokes(str(text), height, gap)
    cutter.to(letters[0][0], rapid=True)
    engraved(cutter, letters, (hole.start, hole.depth), (v[13] or feed, feed))
    cutter.feed(motions.ip.state.feed)
    hole.go(hole.back, rapid=True)
