"""The parts that cycles of all languages are made of: checks, steps and levels, places of patterns, ways to a contour; by hand."""

from __future__ import annotations

import math
from typing import Any

import pytest

from cncgen.gcode.codes.leads import lead_arc, lead_line
from cncgen.gcode.codes.places import in_rows, on_circle
from cncgen.gcode.codes.steps import MOST, levels_of, steps_of
from cncgen.gcode.errors import BlockError, refuse


def test_the_first_fault_that_holds_is_raised() -> None:
    refuse("X", (False, "a", "first", ""))
    with pytest.raises(BlockError) as found:
        refuse("X", (False, "a", "first", ""), (True, "b", "second", "help"), (True, "c", "third", ""))
    error = found.value
    assert (error.code, error.message, error.word, error.hint) == ("b", "second", "X", "help")


def test_levels_are_equal_steps_not_deeper_than_the_infeed() -> None:
    assert levels_of(2.0, -7.0, 4.0, "G0") == pytest.approx((-1.0, -4.0, -7.0))
    assert levels_of(2.0, -7.0, 3.0, "G0") == pytest.approx((-1.0, -4.0, -7.0))
    assert levels_of(2.0, -7.0, 0.0, "G0") == (-7.0,)


@pytest.mark.parametrize(
    ("way", "step", "least", "count"), [(10.0, 4.0, 1, 3), (0.0, 4.0, 1, 1), (0.0, 4.0, 0, 0), (10.0, 0.0, 1, 1)]
)  # fmt: skip
def test_steps_are_counted(way: float, step: float, least: int, count: int) -> None:
    assert steps_of(way, step, "Q", "", least=least) == count


def test_too_many_steps_say_how_many() -> None:
    assert steps_of(MOST, 1.0, "Q", "") == MOST
    with pytest.raises(BlockError, match="Q1 makes 10001 infeeds"):
        steps_of(MOST + 1.0, 1.0, "Q", "Q1 makes {} infeeds")


def test_places_of_patterns() -> None:
    assert on_circle(1j, 2.0, 90.0, 90.0, 2) == pytest.approx([3j, -2.0 + 1j])
    rows = in_rows(1.0 + 0j, 2.0 + 0j, 3j, 3, 3)
    assert rows == [1, 3, 5, 5 + 3j, 3 + 3j, 1 + 3j, 1 + 6j, 3 + 6j, 5 + 6j]
    assert in_rows(1.0 + 0j, 2.0 + 0j, 3j, 3, 3, frame=True) == [place for place in rows if place != 3 + 3j]


@pytest.mark.parametrize(
    ("aside", "leaving", "far", "spin"),
    [(2.0, False, -2 + 2j, 1), (2.0, True, 2 + 2j, 1), (-2.0, False, -2 - 2j, -1), (-2.0, True, 2 - 2j, -1)],
)
def test_a_quadrant_leads_to_a_contour_in_its_direction(
    aside: float, leaving: bool, far: complex, spin: int
) -> None:
    """The contour goes to X+ through the origin; counter-clockwise where the centre is to the left."""
    lead = lead_arc(0j, 1.0 + 0j, aside, math.pi / 2.0, leaving=leaving)
    assert (lead.end if leaving else lead.start) == pytest.approx(far)
    assert (lead.start if leaving else lead.end, lead.centre, lead.spin) == (0j, 1j * aside, spin)
    assert lead.heading(0j) == pytest.approx(1.0 + 0j)
    line = lead_line(0j, 1.0 + 0j, 3.0, leaving=leaving)
    assert (line.start, line.end) == ((0j, 3 + 0j) if leaving else (-3 + 0j, 0j))


@pytest.mark.parametrize("cycle", [200, 202])
def test_a_hole_at_fmax_is_traversed_by_each_cycle(moves: Any, cycle: int) -> None:
    """Q206 = FMAX means in 200 what it means in the other cycles, whose number 99999 is that of FMAX (iTNC 530, "Cycles for drilling")."""
    words = "Q200=2 ~\n Q201=-5 ~\n Q206=FMAX ~\n Q202=5 ~\n Q210=0 ~\n Q203=0 ~\n Q204=10 ~\n Q211=0 ~\n Q208=100 ~\n Q214=0"
    found = moves(
        f"0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S1000 F350\nCYCL DEF {cycle} D ~\n {words}\nCYCL CALL\n9 END PGM T MM\n"
    )
    assert found[:2] == [(0, 0, 2, 0), (0, 0, -5, 0)]
