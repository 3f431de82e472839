"""225: text along a line from the tool's place on, letters of the height Q513 at the angle Q374, their gaps times Q514 (TNC 320, "ENGRAVING").

Newer controls have the place of the text about the tool's (Q367), of which the lower left corner (0, 1) is read, its greatest length (Q574),
and infeeds (Q202). Places, depth, heights and feeds are the cycle's; the letters are our own, since the control's are not published.
"""

from __future__ import annotations

import cmath
import math

from cncgen.gcode.codes.letters import strokes
from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.klartext.hole_cycle import HoleCycle, check_feeds

_TEXT = 500


def engrave(cycle: HoleCycle) -> None:
    """Engrave the text of QS500; raise where it is not known, has system variables, or lies on an arc."""
    q, text = cycle.q, Plain.of(cycle.ip).texts.get(_TEXT)
    check_feeds(cycle)
    place = cycle.place()
    if text is None or "%" in text or round(q[516]):
        what = (
            f"Q516 = {q[516]:g}, text on an arc,"
            if text and round(q[516])
            else "the text, which the control composes,"
        )
        hint = 'QS500="ABC" and Q516=0 engrave a known text along a line'
        raise BlockError("unsupported-block", f"{what} of {cycle.name} is not read", "CYCL", hint=hint)
    place_of = f"Q367 = {q[367]:g} of {cycle.name} is not read: the text begins at the tool's place"
    hint = "Q367 is 0 or 1, the lower left corner"
    refuse("CYCL", (round(q[367]) not in (0, 1), "unsupported-block", place_of, hint))
    turn, letters = cmath.rect(1.0, math.radians(q[374])), strokes(text, q[513], q[514] or 1.0)
    length = max((point.real for stroke in letters for point in stroke), default=0.0)
    message = f"{cycle.name} engraves letters of our own: those of the control are not published, and are longer or shorter"
    if 0.0 < q[574] < length:
        message += (
            f"; the text is {length:.4g} long here, and no longer than Q574 = {q[574]:g} on the control"
        )
    hint = "places, depth, heights and feeds are the cycle's"
    cycle.ip.warn_once("engraving-letters", message, "CYCL", hint)
    cycle.begin()
    for level in cycle.infeeds(202):
        for stroke in letters:
            cycle.go(cycle.start, rapid=True)
            cycle.to(place + stroke[0] * turn, rapid=True)
            cycle.plunge(level, q[206], q[207])
            for point in stroke[1:]:
                cycle.to(place + point * turn)
