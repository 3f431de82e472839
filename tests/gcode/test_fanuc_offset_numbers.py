"""H and D of FANUC stay in force and may stand by themselves (B-63324EN, 14.1.1 and 14.4; modal #4107 and #4111)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cncgen.toolpath.record import Kind

_TOOLS = "G10 L12 P2 R2.\nG10 L12 P5 R5.\nG10 L10 P2 R10.\nG10 L10 P3 R20.\nG0\n"


def _ends(run: Any, text: str, **options: Any) -> list[list[float]]:
    """Return X Y Z of the motions' ends, after asserting that all went well."""
    out = run(_TOOLS + text + "\nM30", dialect="fanuc", **options)
    assert out.errors == []
    return np.round(out.path.end[out.path.kind != 3, :3], 9).tolist()


@pytest.mark.parametrize(
    "text",
    [
        "D5\nG41 X10 Y5",
        "G43 H2 D5 X0 Y0 Z-10\nG41 X10 Y5",
        "G41 D5 X10 Y0\nX20\nG40 X0 Y0\nG41 X10 Y5",
        "T2 M6\nD5\nG41 X10 Y5",
    ],
)
def test_the_radius_is_that_of_the_last_d(run: Any, text: str) -> None:
    """Along X from there, the tool's centre is 5 mm above the path."""
    assert _ends(run, text + "\nX30\nX40\nG40 X50")[-2][1] == 10.0


def test_d0_is_no_radius(run: Any) -> None:
    """So is the D of a program that names tool 2 in the spindle alone: nothing there says D."""
    assert _ends(run, "T2 M6\nG41 D0 X10 Y0\nX20\nG40 X30") == [[10, 0, 0], [20, 0, 0], [30, 0, 0]]
    assert _ends(run, "T2 M6\nG41 X10 Y0\nX20\nX30\nG40 X40")[-2] == [30, 2, 0]


def test_h_by_itself_changes_the_offset_in_force(run: Any) -> None:
    text = "G43 H2 Z0\nH3 Z0\nG44 Z0\nH0 Z1\nG49\nH3 Z2\nG43 Z0\nG49 Z0\nX[#4111]"
    assert _ends(run, text) == [[0, 0, z] for z in (10, 20, -20, 1, 2, 20, 0)] + [[3, 0, 0]]


def test_numbers_in_force_are_system_variables(run: Any) -> None:
    assert _ends(run, "D7\nH9\nX#4107 Y#4111 Z#4008") == [[7, 9, 49]]


def test_lines_that_run_again_change_numbers_too(run: Any) -> None:
    text = "#1=2\nWHILE[#1LE3]DO1\nG43H#1Z0\n#1=#1+1\nEND1\n#1=2\nWHILE[#1LE3]DO1\nH#1Z5\n#1=#1+1\nEND1"
    assert [z for _, _, z in _ends(run, text)] == [10, 20, 15, 25]


@pytest.mark.parametrize(
    ("text", "dialect", "fault"),
    [
        ("D1.5\nM30", "fanuc", ("not-whole", 1, 1)),
        ("H-1\nM30", "fanuc", ("negative-number", 1, 1)),
        ("D5\nM2", "linuxcnc", ("unused-word", 1, 1)),
        ("G1 X1 F100 H1\nM2", "linuxcnc", ("unused-word", 1, 12)),
    ],
)
def test_numbers_where_they_cannot_be(run: Any, text: str, dialect: str, fault: tuple[str, int, int]) -> None:
    assert run(text, dialect=dialect).errors == [fault]


def test_h_of_a_lathe_is_a_distance_of_c(run: Any) -> None:
    """B-64304EN-1, G-code system A: H goes along C, which needs no word of its own."""
    out = run("G0 X2. C10.\nX4. H5.\nM30\n", dialect="fanuc-lathe")
    assert out.errors == []
    assert np.degrees(
        out.path.end[out.path.kind != Kind.EVENT][-1, out.path.axes.index("C")]
    ) == pytest.approx(15.0)
    alone = run("G0 X1 H1\nM30", dialect="fanuc-lathe")
    assert alone.errors == []
    assert np.degrees(alone.path.end[0, alone.path.axes.index("C")]) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("text", "said"), [("G10 L12 P1 R5.", 1), ("G10 L13 P1 R.1", 1), ("G10 L10 P1 R5.", 0)]
)
def test_an_offset_that_may_be_a_diameter_is_noted(run: Any, text: str, said: int) -> None:
    """In diameter mode (setting 40) Haas's controls halve it (Haas mill operator's manual, G141)."""
    found = run(f"{text}\nM30", dialect="fanuc").diagnostics
    assert [(d.severity.value, d.code) for d in found].count(("note", "offset-radius")) == said


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("T1 M6\nG43 G0 Z10.", 1),
        ("T1 M6\nG41 G1 X20. F100.\nY20.\nG40 X0", 1),
        ("T1 M6\nG43 H1 G0 Z10.\nG49\nG43 Z5.", 0),
        ("T1 M6\nG41 D1 G1 X20. F100.\nY20.\nG40 X0\nG41 X20.\nY0\nG40 X0", 0),
        ("T1 M6\nG43 H0 G0 Z10.", 0),
    ],
)
def test_an_offset_that_no_number_names_is_a_guess(run: Any, text: str, said: int) -> None:
    """A control goes on with the last H and D, or with none."""
    out = run(f"{text}\nM30", dialect="fanuc")
    assert out.errors == []
    assert [str(d.severity) for d in out.diagnostics if d.code == "offset-number"] == ["note"] * said
