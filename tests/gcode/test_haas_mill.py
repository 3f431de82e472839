"""Codes of Haas's mills as their operator's manual prints them (Mill NGC, 2017, chapter 7): cycles, probing, tapping along any line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from cncgen.toolpath.record import Kind

Run = Callable[..., Any]
Moves = Callable[..., list[tuple[float, float, float, float]]]

HEAD = "O60001\nG21 G90 G54 G0 X0 Y0 Z5\nM3 S1000\n"


def levels(moves: Moves, cycle: str) -> list[tuple[float, bool]]:
    """Return the height of each motion of a hole, and whether it is a feed."""
    done = moves(f"{HEAD}{cycle} F100\nG80\nM30", dialect="fanuc")
    return [(round(z, 9), feed > 0.0) for _, _, z, feed in done[1:]]


def test_g73_with_k_and_q_returns_to_r_whenever_its_steps_add_up_to_k(moves: Moves) -> None:
    """ "The tool is returned to the R plane after the number of passes totals up to the K amount"; a step begins 0.254 above the last."""
    found = levels(moves, "G73 Z-9 R1. Q2. K4.")
    assert [z for z, feed in found if feed] == [-1, -3, -5, -7, -9]
    assert [z for z, feed in found if not feed] == [1, -0.746, 1, -2.746, -4.746, 1, -6.746, 5]


def test_steps_of_a_peck_that_fill_the_hole_end_at_its_bottom(moves: Moves) -> None:
    """Ten steps of 0.1 from 0 make ten feeds: their sum in binary is short of 1 by 1e-16."""
    found = levels(moves, "G73 Z-1. R0. I0.1 J0. K0.1")
    assert [z for z, feed in found if feed] == [round(-0.1 * k, 9) for k in range(1, 11)]


@pytest.mark.parametrize("cycle", ["G81", "G82 P0.3", "G83 Q2.", "G84"])
def test_e_clears_chips_and_moves_nothing(run: Run, cycle: str) -> None:
    """ "E - Chip-clean RPM (Spindle reverses to remove chips after each cycle)"."""
    text = HEAD + "{} Z-4. R1. F100{}\nG80\nM30"
    with_e, without = (run(text.format(cycle, e), dialect="fanuc") for e in (" E2000", ""))
    assert with_e.errors == []
    assert with_e.path.end.tolist() == without.path.end.tolist()
    assert "E2000" in next(d.message for d in with_e.diagnostics if d.code == "cycle-words")


@pytest.mark.parametrize(
    ("block", "place"),
    [
        ("G1 Y-2 F100\nG35 Y-3 D1 F10", (0, -3, 5)),
        ("G1 Y-2 F100\nG36 Y-3 F10", (0, -3, 5)),
        ("G136 Y-3 F10", (0, -3, 5)),
        ("G43 H1\nG37 H1 Z0 F30", (0, 0, 0)),
    ],
)
def test_probing_is_planned_to_its_place_and_told(moves: Moves, run: Run, block: str, place: Any) -> None:
    """The way ends where the probe touches, which the place of the block, or for G37 the origin, is nearest to."""
    *_, last = moves(f"{HEAD}{block}\nM30", dialect="fanuc")
    assert last[:3] == place
    assert 0.0 < last[3] <= 30.0
    said = [
        d.severity
        for d in run(f"{HEAD}{block}\nM30", dialect="fanuc").diagnostics
        if d.code == "probe-not-run"
    ]
    assert said == ["warning"]


def test_g36_in_a_traverse_and_g37_without_f_are_refused(run: Run) -> None:
    """Both feed at F; G37 without F is another control's, whose parameters have the place of its probe."""
    assert run(f"{HEAD}G36 Y-3\nM30", dialect="fanuc").errors == [("cycle-missing", 4, 1)]
    assert run(f"{HEAD}G37 Z0\nM30", dialect="fanuc").errors == [("not-read", 4, 1)]


def test_g184_taps_along_a_line_and_back(moves: Moves, calls: Callable[..., list[str]]) -> None:
    """ "X Y Z position at bottom of hole": from the place before it there and back at F."""
    text = f"{HEAD}G184 X-7. Z1. F500 S500\nM30"
    assert moves(text, dialect="fanuc")[1:] == [(-7, 0, 1, 500), (0, 0, 5, 500)]
    turns = [call for call in calls(text, dialect="fanuc") if "SPINDLE_C" in call]
    assert [call.split("_")[2][:7] for call in turns] == ["CLOCKWI", "COUNTER", "CLOCKWI"]


@pytest.mark.parametrize(("code", "number"), [("G112", 3), ("G113", 4)])
def test_g112_and_g113_are_coordinate_systems_on_mills(
    moves: Moves, run: Run, code: str, number: int
) -> None:
    """The table of G codes has "G112 #9 Coordinate System", which is G154 P3; before, X and Y turned into X and C without a word."""
    text = f"{HEAD}G10 L20 P{number} X10. Y8.\nG0 {code} X1. Y1.\nG154 P{number} X2. Y1.\nM30"
    assert [move[:2] for move in moves(text, dialect="fanuc")[1:]] == [(11, 9), (12, 9)]
    out = run(text, dialect="fanuc")
    assert "c" not in out.moving_axes.lower()
    assert [d.severity for d in out.diagnostics if code in d.message] == ["warning"]


WRAPPED = """O60472
G21 G90 G54 G0 X0 Y0 A0
S1000 M3
G107 A0 Y0 {radius}
G1 X10. Y5. F100
G2 X15. Y10. R5.
G107
G0 X0
M30
"""


@pytest.mark.parametrize("radius", ["R20.", "Q40."])
def test_g107_maps_y_onto_a_cylinder(run: Run, radius: str) -> None:
    """ "Q - Diameter of the cylindrical surface", R its radius: 5 along Y are 5/20 rad of A, and Y stands still."""
    out = run(WRAPPED.format(radius=radius), dialect="fanuc")
    assert out.errors == []
    x, y, angle = (
        out.path.end[out.path.kind != Kind.EVENT][:, out.axes.lower().index(axis)] for axis in "xya"
    )
    assert max(abs(y)) == 0.0
    assert x[-2:] == pytest.approx([15.0, 0.0])
    assert angle[-2:] == pytest.approx([0.5, 0.5])
    middle = complex(15.0, 5.0)
    ways = [abs(complex(a, 20.0 * b) - middle) for a, b in zip(x, angle, strict=True)]
    assert [way for a, way in zip(x, ways, strict=True) if a >= 10.0] == pytest.approx(
        [5.0] * sum(x >= 10.0), abs=1e-9
    )


@pytest.mark.parametrize(
    ("block", "error"),
    [
        ("G107 A0 Y0", ("axis-missing", 4, 1)),
        ("G107 A0 Y0 R-2.", ("axis-missing", 4, 6)),
        ("G107 A0 Y0 R20.\nG1 A5. F100", ("rotary-refused", 5, 4)),
    ],
)
def test_faults_of_g107(run: Run, block: str, error: tuple[str, int, int]) -> None:
    """Without R and Q the radius is setting 34 of the control, which no one knows here."""
    assert run(f"{HEAD}{block}\nM30", dialect="fanuc").errors[:1] == [error]


def test_general_variables_by_their_newer_numbers_are_told(run: Run) -> None:
    """The table of macro variables: "#10100-#10199, legacy #100-#199"."""
    out = run(f"{HEAD}#10100=5.\nG0 X#10100\nM30", dialect="fanuc")
    assert ("other-control", "warning") in [(d.code, d.severity) for d in out.diagnostics]


def test_a_rotation_by_a_variable_that_a_probe_would_set_is_none(run: Run, moves: Moves) -> None:
    """ "If you do not specify the angle of rotation (R), then the control uses the value in Setting 72", 0 unless it is set."""
    text = f"{HEAD}G65 P9812 X50. S1\nG68 X0 Y0 R[#139]\nG0 X10.\nM30"
    assert moves(text, dialect="fanuc")[-1][:2] == (10, 0)
    assert ("rotation-angle", "warning") in [
        (d.code, d.severity) for d in run(text, dialect="fanuc").diagnostics
    ]
    assert run(f"{HEAD}G68 X0 Y0\nM30", dialect="fanuc").errors == [("rotation-angle", 4, 1)]
