"""The arithmetic of expressions, compiled and plain, against the functions that the interpreter explains errors with."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.gcode.errors import BlockError
from cncgen.gcode.text.expressions import BINARY, UNARY
from cncgen.kernels import gcode_arithmetic
from cncgen.kernels.gcode_codes import LITERALS

from .plain import uncompiled

KERNELS = [gcode_arithmetic, uncompiled("gcode_arithmetic")]
NUMBERS = st.one_of(
    st.floats(-1e12, 1e12), st.sampled_from([0.0, -0.0, 1.0, -1.0, 2.0, 0.5, 30.0, 90.0, 1e-4])
)


def value_of(function: Any, *arguments: float) -> float:
    """Return the value that the interpreter computes, NaN where it says that there is none."""
    try:
        value = function(*arguments)
    except BlockError:
        return math.nan
    return float(value)


def same(a: float, b: float) -> bool:
    """Tell whether two numbers are the same to the bit, or both none."""
    return (a != a and b != b) or (a == b and math.copysign(1.0, a) == math.copysign(1.0, b))


@given(st.sampled_from(sorted(BINARY)), NUMBERS, NUMBERS)
def test_operators_are_those_of_the_interpreter(name: str, a: float, b: float) -> None:
    wanted = value_of(BINARY[name], a, b)
    for kernel in KERNELS:
        assert same(kernel.joined(LITERALS[name], a, b), wanted)


@given(st.sampled_from(sorted(UNARY)), NUMBERS)
def test_functions_are_those_of_the_interpreter(name: str, a: float) -> None:
    wanted = value_of(UNARY[name], a)
    for kernel in KERNELS:
        assert same(kernel.function_of(LITERALS[name], a), wanted)


@pytest.mark.parametrize("kernel", KERNELS, ids=["compiled", "plain"])
def test_what_is_no_function_has_no_value(kernel: Any) -> None:
    assert all(math.isnan(kernel.function_of(LITERALS[name], 1.0)) for name in ("bin", "sqr", "if", "+"))
    assert kernel.arc_tangent(1.0, -1.0) == 135.0
