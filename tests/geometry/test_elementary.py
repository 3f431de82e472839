"""Elementary functions beside those of the standard library, which are the C library's."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cncgen.geometry import elementary
from cncgen.kernels import elementary as kernel
from tests.kernels.plain import uncompiled

STANDARD = {"arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctanh": "atanh"}
COMPILED = not str(kernel.__file__).endswith(".py")
#: Uncompiled they are NumPy's, which are within four units in the last place.
CLOSE = 0.0 if COMPILED else 1e-15


@pytest.mark.parametrize("name", kernel.OF_ONE)
def test_functions_of_one_are_those_of_the_standard_library(name: str) -> None:
    x = np.random.default_rng(1).uniform(0.001, 0.999, 2000)
    if name in ("cbrt", "exp", "exp2", "expm1", "arctan"):
        x = (x - 0.5) * 100.0
    slow = getattr(math, STANDARD.get(name, name))
    expected = np.array([slow(v) for v in x])
    found = getattr(elementary, name)(x)
    np.testing.assert_allclose(found, expected, rtol=CLOSE, atol=0.0)
    numpys = np.empty_like(x)
    uncompiled("elementary").of_one(name, x, numpys)
    np.testing.assert_allclose(numpys, expected, rtol=1e-14)


def test_functions_of_two_are_those_of_the_standard_library() -> None:
    x, y = np.random.default_rng(2).uniform(-3.0, 3.0, (2, 2000))
    angle = np.array([math.atan2(b, a) for a, b in zip(x, y, strict=True)])
    power = np.array([math.pow(abs(a), b) for a, b in zip(x, y, strict=True)])
    np.testing.assert_allclose(elementary.arctan2(y, x), angle, rtol=CLOSE, atol=0.0)
    np.testing.assert_allclose(elementary.power(np.abs(x), y), power, rtol=CLOSE, atol=0.0)
    for name, one, two, expected in (("arctan2", y, x, angle), ("power", np.abs(x), y, power)):
        numpys = np.empty_like(x)
        getattr(uncompiled("elementary"), name)(one, two, numpys)
        np.testing.assert_allclose(numpys, expected, rtol=1e-14)


def test_shapes_are_those_that_broadcast() -> None:
    assert elementary.cbrt(27.0) == pytest.approx(3.0, rel=1e-15)
    assert isinstance(elementary.cbrt(27.0), np.float64)
    assert elementary.cbrt(np.zeros((3, 0))).shape == (3, 0)
    table = np.arange(6.0).reshape(2, 3)
    np.testing.assert_array_equal(elementary.power(table.T, 2.0), table.T**2)
    np.testing.assert_array_equal(elementary.arctan2(table, table[:1]), np.arctan2(table, table[:1]))


def test_where_a_function_has_no_value_there_is_no_warning() -> None:
    assert np.isneginf(elementary.log(0.0))
    assert np.isnan(elementary.log(-1.0))
    assert np.isposinf(elementary.exp(1000.0))
    assert np.isnan(elementary.arcsin(2.0))


def test_products_are_sums_in_the_order_of_their_terms() -> None:
    rng = np.random.default_rng(5)
    vector, matrix, points = rng.normal(size=3), rng.normal(size=(3, 3)), rng.normal(size=(7, 3))
    by_hand = [sum(a * b for a, b in zip(row, vector, strict=True)) for row in points]
    np.testing.assert_array_equal(elementary.product(points, vector), by_hand)
    for a, b in ((points, matrix), (vector, matrix), (matrix, matrix), (vector, vector)):
        np.testing.assert_allclose(elementary.product(a, b), a @ b, rtol=1e-13)
    assert elementary.length(vector) == math.sqrt(sum(x * x for x in vector))
