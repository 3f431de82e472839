"""A tap stops at its depth, where the spindle turns back: no motion goes on through it, in any path mode."""

from __future__ import annotations

import numpy as np
import pytest

from cncgen.pipeline import read_text
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import FeedMode, Kind, PathMode

HEIDENHAIN = """BEGIN PGM T MM
TOOL CALL 1 Z S500
M3
L Z+50 R0 FMAX
CYCL DEF {cycle}
L X+10 Y+10 R0 FMAX M99
L Z+60 R0 FMAX M30
END PGM T MM
"""


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("linuxcnc", "G21 G90 G64 P0.01 S500 M3\nG0 X1 Y1 Z2\nG33.1 Z-10 K1\nG0 X3\nM2\n"),
        (
            "fanuc",
            "G21 G90 G94 G17 G54\nS500 M3\nG0 X0 Y0 Z5\nM29 S500\nG98 G84 X1 Y1 Z-10 R2 F500\nG80\nM30\n",
        ),
        ("sinumerik", "G90 G64 G17\nG0 X0 Y0 Z2\nS500 M3\nG331 Z-10 K1\nG332 Z2 K1\nG0 X10\nM30\n"),
        ("heidenhain", HEIDENHAIN.format(cycle="207 Q200=2 Q201=-10 Q239=1 Q203=0 Q204=50")),
        ("heidenhain", HEIDENHAIN.format(cycle="206 Q200=2 Q201=-10 Q206=500 Q211=0 Q203=0 Q204=50")),
        (
            "heidenhain",
            HEIDENHAIN.format(cycle="209 Q200=2 Q201=-10 Q239=1 Q203=0 Q204=50 Q257=4 Q256=1 Q336=0 Q403=1"),
        ),
    ],
)
def test_a_tap_stops_at_its_depth(dialect: str, text: str) -> None:
    program = read_text(text, options=ReadOptions(dialect=dialect))
    deep = 0
    for part in program.chunks():
        lines = np.flatnonzero((part.kind == Kind.LINE) & (part.feed_mode == FeedMode.SPEED))
        bottom = lines[np.abs(part.end[lines, part.axes.index("Z")] + 10.0) < 1e-9]
        deep += len(bottom)
        assert (part.path_mode[bottom] == PathMode.EXACT_STOP).all()
        rapids = part.feed_mode == FeedMode.RAPID
        assert (part.path_mode[rapids & (part.kind == Kind.LINE)][-1:] != PathMode.EXACT_STOP).all()
    assert deep == 1
