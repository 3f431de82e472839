"""The axes that a program in plain language names, known before it runs."""

from __future__ import annotations

import re

from cncgen.gcode.source import Source
from cncgen.units import AXIS_LETTERS

_COMMENTS = re.compile(
    rb";[^\n]*|^[ \t]*(?:\d+[ \t]+)?(?:BLK[ \t]+FORM|BEGIN|END)\b[^\n]*", re.MULTILINE | re.IGNORECASE
)
#: An axis and its value: ``X+10``, ``IY-2,5``, ``Z+Q1``; K1X of a spline stands beside its X.
_AXIS = re.compile(rb"(?<![A-Z0-9])I?([XYZABCUVW])(?=[ \t]*[-+]?[ \t]*(?:\d|[.,]\d|Q[LR]?\d))", re.IGNORECASE)
_PLANE = re.compile(rb"(?<![A-Z])(?:I?P[RA][ \t]*[-+\dQ]|(?:APPR|DEP|RND|CTP|CP|LP)\b)", re.IGNORECASE)
_CYCLES = re.compile(rb"(?<![A-Z])(?:CYCL\b|M99\b|M89\b|M140\b)", re.IGNORECASE)


def moving_axes(text: Source) -> str:
    """Return the letters of the axes that a program names, in the order of ``XYZABCUVW``; cycles name X, Y and Z."""
    code = _COMMENTS.sub(b"", bytes(text.data[:]))
    named = {match[1].decode().upper() for match in _AXIS.finditer(code)}
    if _PLANE.search(code):
        named |= set("XY")
    if _CYCLES.search(code):
        named |= set("XYZ")
    return "".join(letter for letter in AXIS_LETTERS if letter in named)
