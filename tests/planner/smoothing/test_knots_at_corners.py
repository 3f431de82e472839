"""Knots stand alike about corners that are rounded by themselves, so that a little more tolerance never takes longer."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest

from cncgen.machine import load
from cncgen.pipeline import read_text, sound
from cncgen.planner import PlanOptions, plan
from cncgen.planner.smoothing import smooth
from tests.planner.smoothing.programs import toolpath


def rounded_square(tolerance: float, radius: float) -> str:
    """A square of 50 mm, its corners of that radius, 0 for sharp ones."""
    lines = [f"G21 G90 G17 G64 P{tolerance:.9f}", f"G1 X{radius} Y0 F6000"]
    for heading in range(4):
        angle = 0.5 * np.pi * (heading + np.arange(2))
        way, left = (np.round([np.cos(at), np.sin(at)]) for at in angle)
        corner = 25.0 + 25.0 * (way - left)
        for code, end in (("G1", corner - radius * way), ("G3", corner + radius * left)):
            centre = f" I{radius * left[0]} J{radius * left[1]}" if code == "G3" else ""
            if code == "G1" or radius:
                lines.append(f"{code} X{end[0]} Y{end[1]}{centre}")
    return "\n".join([*lines, "M2", ""])


@pytest.mark.parametrize("radius", [0.0, 1.0, 5.0])
def test_more_tolerance_takes_no_longer(radius: float) -> None:
    """In steps of a hundredth. While knots stood anywhere about a joint, it took up to 0.13, 1.0 and 0.5 % longer."""
    machine, least = load("generic-mill"), np.inf
    for tolerance in 0.006 * 1.01 ** np.arange(16):
        chunks = sound(read_text(rounded_square(tolerance, radius), "a.nc"))
        time = max(
            float(each.profile.t[-1]) for each in plan(chunks, machine, PlanOptions(feedrate="optimal"))
        )
        assert time <= 1.0005 * least
        least = min(least, time)


def test_knots_stand_alike_on_both_sides_of_a_turn() -> None:
    """A turn with 40 mm before it and 30 after: it is a knot, and so far as they are its own spans agree to some per cent."""
    (made,) = smooth([toolpath([0, 0, 0], [[40.0, 0.0, 0.0], [40.0, 30.0, 0.0]])])
    knots = np.unique(made.nurbs.knots)
    at = int(np.abs(knots - 40.0).argmin())
    assert knots[at] == pytest.approx(40.0, abs=1e-12)
    np.testing.assert_allclose(knots[at + 1 : at + 6] - 40.0, 40.0 - knots[at - 1 : at - 6 : -1], rtol=0.05)


def test_more_tolerance_takes_no_longer_where_chords_ask_for_shorter_lengths() -> None:
    """A zigzag at 4 ms, P from 90 to 170 µm: chords of 1 µm hold what is rounded to a tenth of a millimetre whatever P is.

    Where P would have let four times that be used, such a corner counted as one that is not felt, and knots stood anywhere about
    it: 0.5 % longer.
    """
    slow = {"max_velocity": 100.0, "max_acceleration": 1000.0, "max_jerk": 50_000.0}
    machine = load("xy-table")
    axes = {letter: replace(axis, **slow) for letter, axis in machine.axes.items()}
    machine = replace(machine, period_s=0.004, chord_tolerance_mm=0.001, axes=MappingProxyType(axes))
    zigzag = "".join(f"X{5 * k} Y{5 * (k % 2)}\n" for k in range(1, 7))
    least = np.inf
    for tolerance in np.geomspace(0.09, 0.17, 7):
        text = f"G21 G90 G17 G64 P{tolerance:.9f}\nG1 F6000\n{zigzag}M2\n"
        time = max(float(each.profile.t[-1]) for each in plan(sound(read_text(text, "a.nc")), machine))
        assert time <= 1.0005 * least
        least = min(least, time)
