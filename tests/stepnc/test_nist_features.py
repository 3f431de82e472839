"""NIST's ex1: the part from features alone, against NIST's interpreter and against the volume of the features."""

import math
import re
from pathlib import Path

import pytest

from cncgen.diagnostics import Diagnostics
from cncgen.stepnc import canon, read
from tests.stepnc.heightfield import removed

PROGRAMS = Path(__file__).parents[2] / "programs" / "stepnc"


def test_every_call_is_that_of_nist():
    """Facing, drilling, reaming, rough and finish pocket: 490 motions to the last digit printed."""
    found = Diagnostics()
    lines = list(canon(PROGRAMS / "nist_ex1.stp", "nist_ex1.stp", diagnostics=found))
    assert not found.has_errors
    offset = re.compile(r"USE_TOOL_LENGTH_OFFSET\(.*\)")
    expected = [line.rstrip() for line in (PROGRAMS / "nist_ex1.can").read_text().splitlines()]
    assert [offset.sub("", line) for line in lines] == [offset.sub("", line) for line in expected]


def test_removed_volume_is_that_of_the_features():
    """A face of 5 mm on 100 x 120 mm, a hole of 22 mm, a pocket of 80 x 50 mm with corners of 10 mm, both 30 deep."""
    program = read(PROGRAMS / "nist_ex1.stp", "nist_ex1.stp")
    # The drill's point goes 7 mm below the block's underside at -30: heights below it count as -30.
    radii = {"MILL 18MM": 9.0, "SPIRAL_DRILL_20MM": 10.0, "REAMER_22MM": 11.0}
    _, heights = removed(program.chunks(), (100.0, 120.0), 5.0, 0.5, radii)
    volume = float((5.0 - heights.clip(min=-30.0)).sum() * 0.25)
    corners = (4 - math.pi) * 10.0**2
    expected = 100 * 120 * 5.0 + math.pi * 11.0**2 * 30.0 + (80 * 50 - corners) * 30.0
    assert volume == pytest.approx(expected, rel=0.01)
