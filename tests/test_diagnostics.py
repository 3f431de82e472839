"""Diagnostics: the text and the JSON of one, the excerpt of a long line, and a list that stays bounded."""

from __future__ import annotations

import pickle

import pytest

from cncgen.diagnostics import (
    MAX_ALIKE,
    MAX_EXCERPT,
    MAX_KEPT,
    MAX_TOLD,
    Diagnostic,
    Diagnostics,
    ProgramError,
    Severity,
    Span,
    excerpt_of,
)


def test_the_text_of_the_interface() -> None:
    fault = Diagnostic(
        "arc-radius",
        "start and end are not on one circle",
        span=Span("part.nc", 12, 7, 4),
        excerpt="G2 X10 Y0 I5 J0",
        hint="R is shorter",
    )
    assert fault.render() == (
        "part.nc:12:7: error[arc-radius]: start and end are not on one circle\n"
        "   12 | G2 X10 Y0 I5 J0\n"
        "      |       ^^^^\n"
        "  help: R is shorter"
    )
    assert Diagnostic("a", "b", Severity.NOTE).render() == "note[a]: b"


@pytest.mark.parametrize(
    ("column", "length", "marks"),
    [(1, 1, "^"), (4, 3, "   ^^^"), (4, 99, "   ^^^"), (4, 0, "   ^"), (6, 9, "     ^"), (7, 1, "      ^")],
)
def test_marks_end_with_the_line(column: int, length: int, marks: str) -> None:
    """Of a line of six characters; a place just behind it is shown too."""
    fault = Diagnostic("a", "b", span=Span("f", 1, column, length), excerpt="G1 X10")
    assert fault.render().splitlines()[2] == f"      | {marks}"


@pytest.mark.parametrize("column", [1, 100, 101, 150, 500, 899, 900, 1000])
def test_a_long_line_is_cut_around_its_fault(column: int) -> None:
    line = "".join(chr(0x4E00 + k) for k in range(1000))
    text, cut = excerpt_of(line + "\r\n", column)
    assert len(text) == MAX_EXCERPT
    assert text == line[cut : cut + MAX_EXCERPT]
    assert text[column - 1 - cut] == line[column - 1]
    assert cut == min(max(column - 1 - 100, 0), 800)


def test_a_line_that_fits_is_whole() -> None:
    assert excerpt_of("x" * MAX_EXCERPT + "\n", 150) == ("x" * MAX_EXCERPT, 0)
    assert excerpt_of("G1\tX\x1b[1m\x00\x7f", 3) == ("G1 X␛[1m␀�", 0)
    # An override of the direction of writing would show "; G0 1X" as what moves.
    assert excerpt_of("X1 ; \u202e1X 0G\u2066", 1) == ("X1 ; �1X 0G�", 0)


def test_what_says_the_same_is_kept_some_times() -> None:
    """The same fault in every line of a program leaves room for the others."""
    alike = Diagnostic("feed-missing", "G1 with no feed rate")
    found = Diagnostics([alike] * (MAX_ALIKE + 5000))
    found.add(Diagnostic("feed-missing", "G2 with no feed rate"))
    found.add(Diagnostic("feed-missing", "G1 with no feed rate", Severity.NOTE))
    assert (len(found), found.suppressed) == (MAX_ALIKE + 2, 5000)
    assert found.counts == {"error": MAX_ALIKE + 5001, "warning": 0, "note": 1}


def test_a_list_keeps_the_first_and_counts_all() -> None:
    found = Diagnostics(Diagnostic(str(k), "", Severity.WARNING) for k in range(MAX_KEPT + 3))
    assert (len(found), found.suppressed, found.has_errors) == (MAX_KEPT, 3, False)
    found.add(Diagnostic("last", ""))
    assert (len(found), found.suppressed, found.has_errors) == (MAX_KEPT, 4, True)
    assert [item.code for item in found][-1] == str(MAX_KEPT - 1)
    assert repr(found) == f"Diagnostics(1 error, {MAX_KEPT + 3} warnings)"


def test_what_is_not_kept_is_counted_on() -> None:
    """Through another list, in an error, its text, and its pickle."""
    first = Diagnostics([Diagnostic("a", "b")] * (MAX_ALIKE + 5))
    second = Diagnostics([Diagnostic("c", "d", Severity.NOTE)])
    second.extend(first)
    assert (len(second), second.suppressed, second.counts[Severity.ERROR]) == (
        MAX_ALIKE + 1,
        5,
        MAX_ALIKE + 5,
    )
    error = ProgramError(second)
    assert str(error).endswith("5 more were counted and are not shown")
    again = pickle.loads(pickle.dumps(error))
    assert (again.suppressed, str(again), again.diagnostics) == (5, str(error), error.diagnostics)
    assert ProgramError(first.__iter__()).suppressed == 0


def test_the_text_of_an_exception_is_bounded() -> None:
    """A notebook prints it whole; all the faults are in `diagnostics`."""
    error = ProgramError(Diagnostic("a", f"fault {k}") for k in range(50))
    assert str(error).splitlines()[MAX_TOLD - 1].endswith(f"fault {MAX_TOLD - 1}")
    assert str(error).splitlines()[MAX_TOLD:] == ["30 more were counted and are not shown"]
    assert len(error.diagnostics) == 50
