"""Reals of Part 21, tool tables, and arcs through via points, beside Python's own reading and closed forms."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.diagnostics import UsageError
from cncgen.machine.tool_table import read_tool_table
from cncgen.stepnc.geometry.pieces import Arc, Polyline
from cncgen.stepnc.geometry.via_points import polyline_with_via_points
from cncgen.stepnc.part21.writer import format_real

#: REAL of ISO 10303-21: a point and digits before it are demanded, digits behind it are not; the exponent has a capital E.
REAL = re.compile(r"[+-]?[0-9]+\.[0-9]*(E[+-]?[0-9]+)?")


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_real_is_one_of_part_21_and_comes_back_to_the_bit(value: float) -> None:
    text = format_real(value)
    assert REAL.fullmatch(text)
    assert math.copysign(1.0, float(text)) == math.copysign(1.0, value)
    assert float(text) == value


@pytest.mark.parametrize(
    ("value", "text"), [(1.0, "1."), (-0.5, "-0.5"), (1e22, "1.E22"), (1.5e-7, "1.5E-7"), (0.0, "0.")]
)
def test_a_real_is_written_as_short_as_it_can_be(value: float, text: str) -> None:
    assert format_real(value) == text


@pytest.mark.parametrize("value", [math.inf, -math.inf, math.nan])
def test_what_is_not_finite_has_no_text(value: float) -> None:
    with pytest.raises(ValueError, match="no text"):
        format_real(value)


def test_lengths_go_by_remark_and_by_number(tmp_path: Path) -> None:
    """Inches are 25.4 mm; of two alike remarks the last counts."""
    table = tmp_path / "tools.tbl"
    table.write_text("; comment\nT3 P3 Z50 D18 ; Mill 18mm\nT4 P4 z-1.5;\nT5 P9 Z7 ; spare\n\n")
    found = read_tool_table(table)
    assert found.lengths(inches=False) == {"3": 50.0, "MILL 18MM": 50.0, "4": -1.5, "5": 7.0, "SPARE": 7.0}
    assert found.lengths(inches=True)["MILL 18MM"] == pytest.approx(1270.0)


def test_every_wrong_line_of_a_tool_table_is_named(tmp_path: Path) -> None:
    table = tmp_path / "tools.tbl"
    table.write_text("T1 Z5\nhello\nT1.5 Z5\nP2 Z5\nT1 Z6\nT7 Z5 D6 Z7\n")
    with pytest.raises(UsageError) as caught:
        read_tool_table(table)
    assert [found.span.line for found in caught.value.diagnostics if found.span] == [2, 3, 4, 5, 6]


class _Faulty:
    """Stands for the entity of a polyline: its faults are exceptions here."""

    def fault(self, code: str, message: str) -> Exception:
        return ValueError(f"{code}: {message}")


def pieces_of(points: list[list[float]], via: list[int]) -> list[Any]:
    """Return the pieces of a polyline whose points of these numbers are via points."""
    flags = np.isin(np.arange(len(points)), via)
    return polyline_with_via_points(cast("Any", _Faulty()), np.array(points, float), flags)


@pytest.mark.parametrize("lift", [0.0, 3.0])
def test_an_arc_goes_through_its_via_point(lift: float) -> None:
    """A half circle of R = 5 about the origin, flat or leaning: centre and radius are those of the three points."""
    before, arc, after = pieces_of([[-9, 0, 0], [-5, 0, 0], [0, 4, lift], [5, 0, 0], [9, 0, 0]], [2])
    assert isinstance(before, Polyline)
    assert isinstance(arc, Arc)
    assert isinstance(after, Polyline)
    reach = [np.linalg.norm(np.array(p, float) - arc.centre) for p in ([-5, 0, 0], [0, 4, lift], [5, 0, 0])]
    assert reach == pytest.approx([reach[0]] * 3)
    # Half the chord c = 5 and the height h of the arc: R = (c² + h²)/(2 h), sweep 4 atan(h/c).
    height = math.hypot(4.0, lift)
    assert reach[0] == pytest.approx((25.0 + height**2) / (2.0 * height))
    assert arc.sweep == pytest.approx(4.0 * math.atan(height / 5.0))
    assert arc.normal @ np.array([0.0, 4.0, lift]) == pytest.approx(0.0, abs=1e-12)


def test_two_via_points_make_a_full_circle() -> None:
    """Through the point before and both of them; what follows goes on from where it began."""
    circle, line = pieces_of([[5, 0, 0], [0, 5, 0], [-5, 0, 0], [9, 9, 0]], [1, 2])
    assert circle.sweep == 2.0 * math.pi
    assert circle.centre == pytest.approx(np.zeros(3))
    assert circle.start.tolist() == circle.end.tolist() == [5, 0, 0]
    assert line.points.tolist() == [[5, 0, 0], [9, 9, 0]]


@pytest.mark.parametrize(
    ("points", "via", "message"),
    [
        ([[0, 0, 0], [1, 1, 0], [2, 0, 0]], [0], "stands at an end"),
        ([[0, 0, 0], [1, 1, 0], [2, 0, 0]], [2], "stands at an end"),
        ([[0, 0, 0], [1, 1, 0], [2, 2, 0]], [1], "lie on one line"),
        ([[0, 0, 0], [1, 1, 0], [2, 0, 0], [3, 1, 0], [4, 0, 0]], [1, 2, 3], "three via points"),
    ],
)
def test_via_points_that_make_no_arc_are_refused(
    points: list[list[float]], via: list[int], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        pieces_of(points, via)
