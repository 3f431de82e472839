"""How long the motions of a toolpath are, in closed form: lines, arcs, helices, curves, turns of rotary axes."""

from __future__ import annotations

import math

import numpy as np
import pytest

import cncgen
from cncgen.stepnc.motion_lengths import motion_length
from cncgen.toolpath.record import Kind


@pytest.mark.parametrize(
    ("block", "length"),
    [
        ("G1 X3 Y4 Z12", 13.0),
        ("G1 X3 Y4 A90", 5.0),
        ("G1 A90", math.pi / 2),
        ("G1 A30 B40", math.radians(50.0)),
        ("G3 X0 Y0 I5 J0", 10.0 * math.pi),
        ("G3 X0 Y0 Z9 I5 J0 P2", math.hypot(20.0 * math.pi, 9.0)),
        ("G2 X5 Y5 I5 J0", 2.5 * math.pi),
        # y = 2 x − x²/5 from 0 to 10: with u = y', 5/2 times the integral of √(1 + u²) from −2 to 2.
        ("G5.1 X10 Y0 I5 J10", 5.0 * math.sqrt(5.0) + 2.5 * math.asinh(2.0)),
    ],
)
def test_lengths_are_those_of_closed_forms(block: str, length: float) -> None:
    """In X Y Z where they move, mm; else what the rotary axes turn by together, rad."""
    (path,) = cncgen.read_text(f"G21 G90 G17 F600\n{block}\nM2\n").chunks()
    row = int(np.flatnonzero(path.kind != Kind.EVENT)[0])
    points = np.stack([path.starts[row], path.end[row]])
    assert motion_length(path, row, points) == pytest.approx(length, rel=1e-12)
