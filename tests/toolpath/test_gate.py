"""The gate of a toolpath: numbers beyond what planning can hold are named before anything is planned."""

from __future__ import annotations

import pytest

import cncgen
from cncgen.diagnostics import ProgramError

CURVE = "G21 G90 G17 G64\nG6.2 P3 K0 X0 Y0 R{a} F1000\nK0 X1 Y1 R{b}\nK0 X2 Y0 R{a}\nK{m}\nK1\nK1\nM2\n"

#: Programs, and what their fault says: line, code, number, bound.
BEYOND = {
    "a weight of 2e7": (CURVE.format(a=1, b=20000000, m=1), 7, "20000000, not within 1 to 1e+06"),
    "weights of 1e-9": (CURVE.format(a="0.000000001", b=1, m=1), 7, "1e+09, not within 1 to 1e+06"),
    "a sum of distances": (
        "G21 G91 F100\n" + "G1 X90000000\n" * 2 + "M2\n",
        3,
        "180000000 mm or rad, not within ±1e+08",
    ),
    "inches": ("G20 F100\nG1 X90000000\nM2\n", 2, "2.286e+09 mm or rad, not within ±1e+08"),
}


@pytest.mark.parametrize("name", BEYOND)
def test_a_number_beyond_the_gate(name: str) -> None:
    text, line, said = BEYOND[name]
    with pytest.raises(ProgramError) as caught:
        list(cncgen.plan(cncgen.read_text(text, "far.nc"), "generic-mill"))
    (fault,) = caught.value.diagnostics
    assert (fault.code, fault.span and fault.span.line) == ("number-range", line)
    assert said in fault.message
    assert fault.hint


@pytest.mark.parametrize("weight", ["1000000", "0.000001"])
def test_a_curve_at_the_bound_of_weights_is_planned(weight: str) -> None:
    """Its setpoints keep the limits, as verify sees them."""
    text = CURVE.format(a=1, b=weight, m=1)
    program = cncgen.read_text(text, "edge.nc")
    setpoints = cncgen.sample(cncgen.plan(program, "xy-table"))
    assert cncgen.judge(setpoints, program, "xy-table").holds
