"""What posts of FreeCAD 0.20 write: the lines below are those of its Profile, Drilling and Helix of a block of 60 x 40 x 20 mm."""

from __future__ import annotations

import io

import pytest

from cncgen.diagnostics import Diagnostics
from cncgen.gcode import check, read
from cncgen.toolpath.reading import ReadOptions

#: The head of the post for UCCNC, the circle of a helix, and a hole of G82 without a dwell.
UCCNC = """%prog1
(Exported by FreeCAD for UC-CNC)
G17 (Default: XY-plane)
G54
G40
G49
G90
G80
M6 T1
M3 S6000
G0 Z26.000
G0 X16.500 Y20.000
G1 Z21.000 F200.000
G2 X13.500 Y20.000 Z18.900 I-1.500 J0.000 K0.000 F600.000
G0 Z26.000
G98
G82 X15.000 Y20.000 Z0.000 R24.000 F200.000
G80
M30
"""


def found_in(text: str, dialect: str = "auto") -> list[tuple[str, str]]:
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", ReadOptions(dialect=dialect), found)
    return [(one.severity, one.code) for one in found if one.severity != "note"]


def test_a_program_for_uccnc_is_read() -> None:
    """A name behind %, K0 of an arc in XY and G82 without P, which LinuxCNC refuses and UCCNC takes."""
    assert found_in(UCCNC) == []
    rows = [row for chunk in read(io.BytesIO(UCCNC.encode()), "t.nc").chunks() for row in chunk.end[:, :3]]
    # Half a helix around X15 Y20, then the hole down to Z0 at its centre.
    assert [13.5, 20.0, 18.9] in [pytest.approx(list(row)) for row in rows]
    assert min(row[2] for row in rows) == pytest.approx(0.0)


def test_only_a_zero_is_no_centre_of_another_plane() -> None:
    arc = "O1\nG21 G90 G17\nG0 X0 Y0\nG2 X10. Y0. I5. J0. {k} F600.\nM30\n"
    assert found_in(arc.format(k="K0.000")) == []
    assert found_in(arc.format(k="K0.1")) == [("error", "arc-plane")]
    # rs274 of LinuxCNC 2.9: "K word given for arc in XY plane".
    assert found_in(arc.format(k="K0.000").replace("O1\n", ""), "linuxcnc") == [("error", "arc-plane")]


def test_the_end_without_a_tool_length() -> None:
    """``G49 H0`` at the end of Centroid's post; rs274 refuses it."""
    text = "G21 G90\nG0 X1\nM5\nG49 H0\nG90 G80 G40 G49\nM2\n"
    assert found_in(text) == []
    assert found_in(text, "linuxcnc") == [("error", "unused-word")]


@pytest.mark.parametrize(
    ("first", "doubt"),
    [
        ("G53 G00 G17", 0),
        ("G0 X1", 1),
        ("G10 L2 P2 X-20.0995", 1),
        ("G52 Y1", 1),
        ("G92 X0", 0),
        ("G10 L2 P1 X0 B90", 0),
    ],
)
def test_a_unit_behind_no_length(first: str, doubt: int) -> None:
    """G53 without an axis, as a post for Centroid writes it, moves nothing; origins by G10 before G20 are lengths in mm here."""
    assert found_in(f"G90\n{first}\nG20\nG1 X1 F10\nM2\n") == [("warning", "units-doubtful")] * doubt


@pytest.mark.parametrize(
    ("text", "control"),
    [
        (";Exported by FreeCAD\n;Post Processor: centroid_post\nG90 G80 G40 G49\nG0 X1\nM25\nM99\n", "Centroid"),
        ("G77      ; Move to release position\nM10 O6.0 ; Stop spindle\nM01 Insert tool 1\n", "nccad"),
        ("PA;PA;\n!MC1;\nVS2.0;\n!VZ1.0;\nPU2470,1670;\nZ2470,1670,640;\nZ2500,0,640;\n", "Roland"),
    ],
)  # fmt: skip
def test_controls_whose_language_is_not_read(text: str, control: str) -> None:
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", diagnostics=found)
    assert [one.code for one in found if one.severity == "error"] == ["control-unread"]
    assert control in "".join(one.message for one in found)


def test_colon_numbers_are_not_of_acramatic_alone() -> None:
    """NX's generic posts number the block of a tool change by a colon: the refusal named Acramatic alone, and no cure but another post."""
    text = "N0010 G40 G17 G90 G21\n:0020 T01 M06\nN0030 G0 X10. Y10. S900 M3\nN0040 G1 X20. F100\nN0050 M30\n"
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", diagnostics=found)
    refusal = next(one for one in found if one.code == "control-unread")
    assert "NX" in refusal.message
    assert "write N for the colon" in refusal.hint
    cured = Diagnostics()
    check(io.BytesIO(text.replace(":", "N").encode()), "t.nc", diagnostics=cured)
    assert not [one for one in cured if one.severity == "error"]


@pytest.mark.parametrize(
    ("above", "line", "likelier"),
    [
        ("G90 G10 L2 P0 X0. Y0.\n(X5.)\nG90 G10 L2 P1 X-9.2545 Y-12.4306 B0.", 4, True),
        ("G90 G10 L2 P1 X-9.2545\nG0 X1.", 2, False),
        ("G0 X0\nG0 Z2.5", 3, False),
    ],
)
def test_the_warning_of_a_late_unit_names_the_first_length(above: str, line: int, likelier: bool) -> None:
    """A shop sets its origins by G10 above G20, in the inches that its machine is in: only the line of G20 was named, and no likelihood."""
    found = Diagnostics()
    check(io.BytesIO(f"%\n{above}\nG20\nG1 X1. F10.\nM30\n%\n".encode()), "t.nc", diagnostics=found)
    warning = next(one for one in found if one.code == "units-doubtful" and "behind it" in one.message)
    assert f"from line {line} on" in warning.message
    assert "--units inch" in warning.hint
    assert ("likelier" in warning.hint) is likelier


@pytest.mark.parametrize("above", ["G28", "G91 G28 Z0\nG90", "G28 U0 W0", "G0 X0 Z0."])
def test_ways_to_the_reference_point_above_a_unit_are_the_same_in_both(above: str) -> None:
    """Haas lathe programs of a school have G28 above the line of G20: it was said to leave lengths in mm."""
    found = Diagnostics()
    check(
        io.BytesIO(f"%\nO1\n{above}\nG50 S2000\nG20\nG0 X1. Z.1\nM30\n%\n".encode()),
        "t.nc",
        diagnostics=found,
    )
    assert "units-doubtful" not in [one.code for one in found]
