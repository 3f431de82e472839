"""What the door of the library lets in: numbers that are numbers, letters of axes, fields by their names, streams once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from cncgen.arguments import expect_axes, expect_fields, expect_number, is_number, undrawn
from cncgen.diagnostics import UsageError


@pytest.mark.parametrize("value", [0, -1.5, np.float32(2.0), np.int64(3), Fraction(1, 3), 1e308])
def test_numbers_of_any_kind_are_numbers(value: Any) -> None:
    assert is_number(value)
    assert expect_number(value, "x", low=-10.0) == float(value)


@pytest.mark.parametrize("value", [True, np.inf, np.nan, "1", None, 1j, 10**400, [1.0], np.array([1.0])])
def test_what_is_no_finite_number_is_none(value: Any) -> None:
    """Truth values are none; a whole number may be too long for a double."""
    assert not is_number(value)
    with pytest.raises(UsageError, match="must be a finite number not below 0"):
        expect_number(value, "x")


@pytest.mark.parametrize(
    ("value", "open_low", "good"),
    [(0.0, False, True), (0.0, True, False), (1.0, True, True), (1.5, False, False)],
)
def test_bounds_belong_to_the_range_unless_it_is_open(value: float, open_low: bool, good: bool) -> None:
    if good:
        assert expect_number(value, "x", high=1.0, open_low=open_low) == value
    else:
        with pytest.raises(UsageError, match=r"x = .* up to 1"):
            expect_number(value, "x", high=1.0, open_low=open_low)


@pytest.mark.parametrize("letters", ["", "xy", "XX", "XQ", ["X"], None])
def test_axes_are_capital_letters_once_each(letters: Any) -> None:
    assert expect_axes("ZXA", "axes") == "ZXA"
    with pytest.raises(UsageError, match="letters of axes"):
        expect_axes(letters, "axes")


@dataclass
class _Options:
    feedrate: str = ""
    effort: str = ""


def test_every_unknown_field_is_named_with_what_may_be_meant() -> None:
    expect_fields(_Options(), ["effort"])
    with pytest.raises(UsageError) as caught:
        expect_fields(_Options(), ["feedrat", "effort", "q"])
    hints = [(found.message, found.hint) for found in caught.value.diagnostics]
    assert hints == [
        ("there is no option 'feedrat'", "did you mean feedrate?"),
        ("there is no option 'q'", "there are feedrate, effort"),
    ]


def test_a_stream_can_be_drawn_once() -> None:
    """A list may be drawn again; a generator that has ended would look like an empty stream."""

    def rows() -> Iterator[int]:
        yield 1

    stream = rows()
    assert list(undrawn(stream, "the rows")) == [1]
    with pytest.raises(UsageError, match="the rows was drawn already"):
        undrawn(stream, "the rows")
    again = iter([1])
    assert undrawn(again, "a list") is again
