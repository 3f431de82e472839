"""Places of codes whose fault would be silent, each computed by hand; the rule stands beside it.

LinuxCNC's rules are those of its manual (G-code reference), FANUC's of B-64304EN, Haas's of its mill operator's manual.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cncgen.toolpath.record import PathMode


def places(run: Any, text: str, **options: Any) -> list[list[float]]:
    """Return the ends of the motions in machine coordinates, mm and rad; the program must have no errors."""
    out = run(text, **options)
    assert out.errors == []
    found: list[list[float]] = out.path.end[out.path.kind != 3].round(9).tolist()
    return found


SYSTEMS = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"]


@pytest.mark.parametrize(("dialect", "count"), [("linuxcnc", 9), ("fanuc", 6)])
def test_each_work_system_has_its_own_origin(run: Any, dialect: str, count: int) -> None:
    """System n has X10n Y-n as origin; X1 Y2 in it is X10n+1 Y2-n of the machine."""
    origins = "".join(f"G10 L2 P{n} X{10 * n} Y{-n}\n" for n in range(1, count + 1))
    motions = "".join(f"{code}\nG0 X1 Y2\n" for code in SYSTEMS[:count])
    expected = [[10 * n + 1, 2 - n, 0] for n in range(1, count + 1)]
    assert places(run, origins + motions + "M30", dialect=dialect) == expected


#: Haas: G110 is G154 P1, G111 is P2, and G114 to G129 are P5 to P20; G112 and G113 are other codes.
HAAS = {"G110": 1, "G111": 2, **{f"G{109 + n}": n for n in range(5, 21)}}


@pytest.mark.parametrize("code", [*HAAS, "G154 P3", "G154 P4", "G154 P17", "G154 P48"])
def test_each_additional_system_has_its_own_origin(run: Any, code: str) -> None:
    """Origins of all 48 systems are set, so that a neighbour's would show; G54.1 Pn is the same system."""
    number = HAAS[code] if code in HAAS else int(code.split("P")[1])
    origins = "".join(f"G10 L20 P{n} X{10 * n}\n" for n in range(1, 49))
    text = f"{origins}G54 G0 X1\n{code}\nX2\nG54 X3\nG54.1 P{number}\nX4\nM30"
    expected = [1, 10 * number + 2, 3, 10 * number + 4]
    assert [row[0] for row in places(run, text, dialect="fanuc")] == expected


@pytest.mark.parametrize(("store", "home"), [("G28.1", "G28"), ("G30.1", "G30")])
def test_a_stored_reference_point_is_a_place_of_the_machine(run: Any, store: str, home: str) -> None:
    """Stored at X105 Y6 Z17 of the machine, under an origin and a tool length that count no more when it is called."""
    text = (
        f"G10 L2 P1 X100\nG10 L1 P1 Z10\nT1 M6 G43\nG0 X5 Y6 Z7\n{store}\n"
        f"G10 L2 P1 X0\nG49\nG0 X0 Y0 Z0\n{home} X2\n{home}\nM2"
    )
    found = places(run, text)
    assert found[0] == [105, 6, 17]
    # By way of X2 to the reference point in X alone; then, without words, in all axes.
    assert found[2:4] == [[2, 0, 0], [105, 0, 0]]
    assert found[-1] == [105, 6, 17]


def test_an_offset_of_g92_is_put_aside_and_taken_up(run: Any) -> None:
    """At X10 becomes X0: the offset is 10. G92.2 leaves it out, G92.3 takes it up, G92.1 forgets it."""
    text = "G0 X10\nG92 X0\nX5\nG92.2\nX5\nG92.3\nX5\nG92.1\nX5\nG92.3\nX6\nM2"
    assert [row[0] for row in places(run, text)] == [10, 15, 5, 15, 5, 6]


def test_g92_counts_from_the_system_in_force(run: Any) -> None:
    """X1 of G55 is X21 of the machine. As X4 its offset is -3, in G54 too: X0 of G54 is -3."""
    text = "G10 L2 P2 X20\nG55\nG0 X1\nG92 X4\nX0\nG54\nX0\nM2"
    assert [row[0] for row in places(run, text)] == [21, 17, -3]


def test_lengths_of_two_tools_add_up(run: Any) -> None:
    """G43 takes tool 1's 10 mm, G43.2 H2 adds 3 mm, and another one 3 mm more; G49 takes all away."""
    text = (
        "G10 L1 P1 Z10\nG10 L1 P2 Z3\nT1 M6\nG43\nG0 Z0\nG43.2 H2\nZ0\nG43.2 H2\nZ0\nG43 H2\nZ0\nG49\nZ0\nM2"
    )
    assert [row[2] for row in places(run, text)] == [10, 13, 16, 3, 0]


def test_m61_names_the_tool_in_the_spindle(run: Any) -> None:
    """Without a tool change: G43 without H takes the length of tool 2."""
    assert places(run, "G10 L1 P1 Z10\nG10 L1 P2 Z4\nM61 Q2\nG43\nG0 Z1\nM2") == [[0, 0, 5]]


@pytest.mark.parametrize(("code", "side"), [("G41.1", 1), ("G42.1", -1)])
def test_a_radius_named_in_the_block(run: Any, code: str, side: int) -> None:
    """D is a diameter: along X the centre is 2 mm to the left or to the right of the path, at a right angle."""
    found = places(run, f"F100\n{code} D4\nG1 X10\nX30\nX50\nM2")
    assert found == [[10, 2 * side, 0], [30, 2 * side, 0], [50, 2 * side, 0]]


def test_an_outer_corner_is_rounded_about_its_point(run: Any) -> None:
    """From X to Y on the right: an arc of the radius about X30 Y0, from (30, -2) to (32, 0)."""
    out = run("F100\nG42.1 D4\nG1 X10\nX30\nY20\nM2")
    assert places(run, "F100\nG42.1 D4\nG1 X10\nX30\nY20\nM2")[1:] == [[30, -2, 0], [32, 0, 0], [32, 20, 0]]
    assert out.path.arcs.centre[0].tolist() == pytest.approx([30, 0, 0])
    turned = out.path.arcs.sweep * out.path.arcs.normal[:, 2]
    assert turned.tolist() == pytest.approx([math.pi / 2])


def test_absolute_centres_count_from_the_origin_of_the_system(run: Any) -> None:
    """G90.1: I0 J0 is the origin, X100 Y50 of the machine. G91.1: J-10 is 10 mm below the arc's start."""
    text = "G10 L2 P1 X100 Y50\nF100\nG1 X10 Y0\nG90.1\nG3 X0 Y10 I0 J0\nG91.1\nG3 X-10 Y0 I0 J-10\nM2"
    out = run(text)
    assert places(run, text)[-2:] == [[100, 60, 0], [90, 50, 0]]
    assert out.path.arcs.centre.tolist() == [pytest.approx([100, 50, 0]), pytest.approx([100, 50, 0])]
    assert (out.path.arcs.sweep * out.path.arcs.normal[:, 2]).tolist() == pytest.approx([math.pi / 2] * 2)


def test_codes_that_end_an_exact_stop(run: Any) -> None:
    """G61 holds until G62, G63 or G64; G9 holds for its own block."""
    text = "F100\nG61 X0 G1\nX1\nG62\nX2\nG61\nX3\nG63\nX4\nG9 X5\nX6\nM30"
    out = run(text, dialect="fanuc")
    modes = out.path.path_mode[out.path.kind != 3]
    ends = out.path.end[out.path.kind != 3, 0].tolist()
    exact = [x for x, mode in zip(ends, modes, strict=True) if mode == PathMode.EXACT_STOP]
    assert [x for x in exact if x > 0] == [1, 3, 5]


def test_g107_is_the_surface_of_a_cylinder(run: Any) -> None:
    """A line on the surface: halfway down it has turned half of the way; C0 of G107 ends it."""
    text = "G0 Z60 C0\nF100\nG107 C57.29578\nG1 Z-10 C90\nG107 C0\nG1 Z5\nM30"
    found = np.array(places(run, text, dialect="fanuc"))
    surface = found[(found[:, 2] < 60) & (found[:, 2] >= -10)][:-1]
    np.testing.assert_allclose(surface[:, 3], (60 - surface[:, 2]) / 70 * math.pi / 2, atol=1e-9)
    assert found[-2].tolist() == pytest.approx([0, 0, -10, math.pi / 2])
    assert found[-1].tolist() == pytest.approx([0, 0, 5, math.pi / 2])


@pytest.mark.parametrize("code", ["G38.2", "G38.3", "G38.4", "G38.5"])
def test_a_probing_line_is_planned_to_its_end_with_a_note(run: Any, code: str) -> None:
    """Nothing is touched while a program is planned."""
    out = run(f"F100\nG0 X1\n{code} X7\nM2")
    assert out.path.end[out.path.kind != 3, 0].tolist() == [1, 7]
    assert [(d.code, d.severity) for d in out.diagnostics] == [("probe-not-run", "note")]


@pytest.mark.parametrize(
    ("plane", "arc"), [("G17.1", "U0 V10 I-10"), ("G18.1", "U0 W10 I-10"), ("G19.1", "V0 W10 J-10")]
)
def test_arcs_of_u_v_w_are_refused_and_lines_are_not(run: Any, plane: str, arc: str) -> None:
    """The first line as in LinuxCNC's simple-gcode-generators, airfoil/0_naca_test.ngc: no direction of G40 lies in such a plane."""
    first = arc[0]
    out = run(f"{plane} G40 G80\nF100\nG1 {first}10\nG2 {arc}\nM2")
    assert [(code, line) for code, line, _ in out.errors] == [("arc-plane", 4)]
    axes = out.axes.index(first)
    assert out.path.end[out.path.kind != 3][0, axes] == 10


def test_saved_modes_come_back(run: Any) -> None:
    """M70 saves inches and increments, M72 restores them: 1 inch further. M73 does so at the end of the subroutine."""
    saved = "G20 G91\nM70\nG21 G90\nG0 X5\nM72\nX1\nM2"
    assert [row[0] for row in places(run, saved)] == pytest.approx([5, 30.4])
    sub = "o100 sub\nM73\nG20 G91\nG0 X1\no100 endsub\nG21 G90\no100 call\nG0 X1\nM2"
    assert [row[0] for row in places(run, sub)] == pytest.approx([25.4, 1])


@pytest.mark.parametrize("block", ["G22 X1 Y1 Z1 I-9 J-9 K-9", "G23", "G103 P1", "G187 P3 E.1", "G11"])
def test_words_of_codes_that_move_nothing_move_nothing(run: Any, block: str) -> None:
    """X Y Z of G22 are the corner of a zone, not a place to go to."""
    assert places(run, f"G0 X5\n{block}\nG0 Y6\nM30", dialect="fanuc") == [[5, 0, 0], [5, 6, 0]]


@pytest.mark.parametrize(
    ("plane", "word", "first", "second"), [("G17", "X", 0, 1), ("G18", "Z", 2, 0), ("G19", "Y", 1, 2)]
)
def test_a_rotation_turns_from_the_first_axis_of_its_plane_to_the_second(
    run: Any, plane: str, word: str, first: int, second: int
) -> None:
    """By 30 degrees: 10 mm along X of G17, Z of G18, Y of G19 become 8.66 mm of it and 5 mm of Y, X, Z."""
    a, b = "XYZ"[first], "XYZ"[second]
    found = places(run, f"{plane}\nG68 {a}0 {b}0 R30\nG0 {word}10\nG69\nM30", dialect="fanuc")
    assert found[0][first] == pytest.approx(10 * math.cos(math.pi / 6))
    assert found[0][second] == pytest.approx(5)


@pytest.mark.parametrize(("plane", "first", "second"), [("G17", 0, 1), ("G18", 2, 0), ("G19", 1, 2)])
def test_polar_words_are_radius_and_angle_of_their_plane(
    run: Any, plane: str, first: int, second: int
) -> None:
    """The first axis's word is the radius; 30 degrees, then, in increments, 60 more: straight along the second axis."""
    a, b = "XYZ"[first], "XYZ"[second]
    text = f"{plane}\nG16\nG0 {a}10 {b}30\nG91 {b}60\nG90 G15\nM30"
    found = places(run, text, dialect="fanuc")
    assert found[0][first] == pytest.approx(10 * math.cos(math.pi / 6))
    assert found[0][second] == pytest.approx(5)
    assert found[1][first] == pytest.approx(0, abs=1e-9)
    assert found[1][second] == pytest.approx(10)


def test_distances_of_a_lathe(run: Any) -> None:
    """X and U are diameters: X20 is 10 mm from the axis, U-4 goes 2 mm; W is a distance along Z."""
    text = "G0 X20. Z5.\nU-4. W-2.\nX10. W-1.\nG50 X30. Z0\nG0 X20.\nM30"
    # G50 names the place X10 Z2 as X30 Z0, so that X20 is 5 mm nearer to the axis of the program.
    assert places(run, text, dialect="fanuc-lathe") == [[10, 0, 5], [8, 0, 3], [5, 0, 2], [0, 0, 2]]


def test_feeds_a_minute_and_a_revolution(run: Any) -> None:
    """120 mm/min are 2 mm/s; 0.3 mm a revolution at 600 rev/min are 3 mm/s."""
    text = "G98 G1 X10. F120.\nG99 G97 S600 M3\nG1 X20. F0.3\nM30"
    out = run(text, dialect="fanuc-lathe")
    assert out.errors == []
    assert out.path.feed[out.path.kind != 3].tolist() == pytest.approx([2, 3])


@pytest.mark.parametrize(("code", "sign"), [("G43", 1), ("G44", -1)])
def test_wear_counts_with_the_length_of_its_offset(run: Any, code: str, sign: int) -> None:
    """10 mm less 0.5 mm of wear, added by G43 and taken away by G44."""
    text = f"G10 L10 P1 R10.\nG10 L11 P1 R-0.5\nG0 {code} H1 Z1\nM30"
    assert places(run, text, dialect="fanuc") == [[0, 0, 1 + sign * 9.5]]


def test_a_local_system_lies_in_every_work_system(run: Any) -> None:
    """G52 holds in G55 too, until G52 X0 Y0 ends it."""
    text = "G10 L2 P2 X100\nG52 X10 Y5\nG0 X1 Y1\nG55 X2\nG52 X0 Y0\nX3 Y0\nM30"
    assert places(run, text, dialect="fanuc") == [[11, 6, 0], [112, 6, 0], [103, 0, 0]]
