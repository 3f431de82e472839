"""What another control would read: said once, at its first place, and only where it is doubtful."""

from __future__ import annotations

import io
from collections.abc import Callable

import pytest

from cncgen.diagnostics import Diagnostics
from cncgen.gcode import check
from cncgen.toolpath.reading import ReadOptions

from .conftest import Outcome


def said(run: Callable[..., Outcome], text: str, dialect: str = "fanuc") -> list[tuple[int, int]]:
    """Return line and column of the doubts about a text."""
    out = run(text, dialect=dialect)
    return [(d.span.line, d.span.column) for d in out.diagnostics if d.code == "other-control" and d.span]


@pytest.mark.parametrize(
    ("text", "places"),
    [
        ("G0 X1.\nG50 S3000\nG50 S2000\nM30", [(2, 1)]),
        ("(G50 S1)\nG50\nG92 S3000\nM30", []),
        ("N5 (Ü) G1 X1. U-2. F100\nM30", [(1, 15)]),
        ("G28 U0 W0\nM30", [(1, 5)]),
        ("G0 X1. (U5)\nG4 U1.\nG65 P1 U3.\nM30\nO1\nM99", []),
        ("G0 X10.; G1 X20. F100.\nM30;", [(1, 8)]),
        ("G0 X10. ; the wall\n; G2 is next\nM30;", [(2, 1)]),
        ("G0 X10.;\nM30;", []),
        # Whole numbers that end in a point are written for controls that count least increments without one (M700V manual, 5.3, type I).
        ("G0 X10. Y0\nX12.5 Y-30\nM30", [(2, 7)]),
        ("G0 X12.5 Y-30\nM30", []),
        ("(Y5) G0 X10. Y0\nX#1 Y[3]\nM30", []),
    ],
)
def test_doubts_about_a_program_of_fanuc(
    run: Callable[..., Outcome], text: str, places: list[tuple[int, int]]
) -> None:
    assert said(run, text) == places


def turned(run: Callable[..., Outcome], text: str) -> list[int]:
    """Return the lines at which a text is warned of ways that roll-over makes shorter."""
    return [d.span.line for d in run(text, dialect="fanuc").diagnostics if d.code == "roll-over" and d.span]


def test_a_rotary_axis_that_may_go_the_other_way_round(run: Callable[..., Outcome]) -> None:
    """The moves of the manual's example with roll-over (B-63534EN, 20.2.1): -150, then -30 to A540 from 210, where it stands at -150 here.

    Distances are gone as they are; what counts is where the axis stands when the block runs.
    """
    text = "G90 G0 A-150.\nA540.\nM30"
    assert turned(run, text) == [2]
    found = next(d for d in run(text, dialect="fanuc").diagnostics if d.code == "roll-over")
    assert "from -150 to 540, by 690 degrees" in found.message
    assert "goes by -30" in found.message
    for text, lines in (
        ("G90 G0 X1. A350. (A5)\nN2 G1 A10. F500.\nM30", [1]),
        ("G0 A170.\nA340.\nA-10.\nM30", [3]),
        ("G0 A180.\nA0.\nM30", []),
        ("G91 G0 A540.\nM30", []),
        ("G91 G0 A100.\nA200.\nM30", []),
        ("G0 A90.\nG91 A180.\nG90 A360.\nM30", []),
        # The last G90 or G91 of the text is not what is in force: the distance of the line shows in the numbers.
        ("G0 A10.\nG91\nM98 P2\nM30\nO2\nA200.\nG90\nM99", []),
        ("G0 A100.\nM98 P2\nM30\nO2\n#1=-120.\nA#1\nM99", [6]),
        ("#1=0\nWHILE [#1 LT 4] DO1\nG0 A[#1*90.]\n#1=#1+1\nEND1\nA0.\nM30", [6]),
        ("/G0 A300.\nA90.\nM30", []),
        ("G0 A100.\nG92 A0\nA150.\nM30", []),
        ("G91 G28 A0\nM30", []),
        ("G65 P1 A500.\nM30\nO1\nM99", []),
        ("G68 X0 Y0 R10. (A900)\nG69\nM30", []),
    ):
        assert turned(run, text) == lines, text


def test_a_check_looks_at_ways_of_rotary_axes_beyond_the_head_of_a_long_text() -> None:
    """An endless table is warned of once, at the first way that differs, by `check` as by `plan`."""
    text = "O1\nG21 G90 G0 A0\n" + "G1 X1. F100.\nX2.\n" * 6000 + "A200.\nA0\nM30\n"
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", ReadOptions(dialect="fanuc"), found)
    assert [d.span.line for d in found if d.code == "roll-over" and d.span] == [12003]


@pytest.mark.parametrize(
    "line",
    [
        'N20 T="MILL 10" D1',
        "N55 CYCLE832(0.01,_FINISH,1)",
        "G1 X=IC(10)",
        "N85 R1=10",
        "IF R1>5 GOTOF ENDE",
        "TRAORI",
        "G2 X10 Y10 CR=10",
        "DEF REAL DEPTH",
    ],
)
@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc"])
def test_sinumeriks_own_language_is_named(run: Callable[..., Outcome], line: str, dialect: str) -> None:
    out = run(f"G0 X1 (R1=2, CYCLE81(1))\n{line}\nM30", dialect=dialect)
    assert [(d.code, d.span.line) for d in out.diagnostics if d.severity == "warning" and d.span] == [
        ("other-control", 2)
    ]
    assert out.errors


@pytest.mark.parametrize(
    ("text", "places"),
    [
        ("G4 P1.5\nG04 P99\n(G4 P500) G4 P200.\nM2", []),
        ("G21 (dwell)\nG04 P500\nG4 P600\nM2", [(2, 5)]),
        ("G82 X1 Y1 Z-1 R1 P0.5 F100\nG64 P100\nG10 L2 P1 X100\nM2", []),
        ("G0 Z5\nG98 G82 X1 Y1 Z-1 R1 P250 F100\nM2", [(2, 22)]),
        ("G0 Z5\nG82 G98 X1 Y1 Z-1 R1 P250 F100\nM2", [(2, 22)]),
    ],
)
def test_a_dwell_of_minutes_may_be_milliseconds(
    run: Callable[..., Outcome], text: str, places: list[tuple[int, int]]
) -> None:
    assert said(run, text, "linuxcnc") == places


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc"])
def test_heidenhains_din_iso_is_named(run: Callable[..., Outcome], dialect: str) -> None:
    """Once, and not where * multiplies or stands in a comment."""
    text = "G0 X1 (2 * 3) ; see 5*\n#1=[2*3]\nN30 T1 G17 S3500*\nN40 G00 G40 G90 Z+250 *\nM30"
    assert said(run, text, dialect) == [(3, 17)]


def test_linuxcnc_has_axes_u_and_w_and_comments_behind_semicolons(run: Callable[..., Outcome]) -> None:
    assert said(run, "G0 X1 U2 ; G1 X3\nM2", "linuxcnc") == []
