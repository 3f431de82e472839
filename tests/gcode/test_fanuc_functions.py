"""Functions of FANUC beside macros and cycles: coordinate systems, reference points, polar coordinates, threads."""

from __future__ import annotations

import io
import math
from typing import Any

import numpy as np
import pytest

from cncgen.diagnostics import Diagnostics
from cncgen.gcode import canon
from cncgen.toolpath.reading import ReadOptions


def fanuc(run: Any, text: str, **options: Any) -> list[list[float]]:
    """Return X Y Z of the motions, in machine coordinates, after asserting that all went well."""
    out = run(text, dialect="fanuc", **options)
    assert out.errors == []
    kinds = zip(out.path.end[:, :3], out.path.kind, strict=True)
    return [np.round(row, 9).tolist() for row, kind in kinds if kind != 3]


def remarks(run: Any, text: str) -> list[tuple[str, str]]:
    """Return severity and code of what was said."""
    return [(d.severity.value, d.code) for d in run(text, dialect="fanuc").diagnostics]


def test_g53_traverses_once(calls: Any) -> None:
    """The motion in force stays; the coordinates are the machine's (B-63324EN, 7.1)."""
    lines = calls("G10 L2 P1 X100\nG54 G1 X10 F100\nG53 Z-5\nX20\nM30", dialect="fanuc")
    assert [line.split(", 0.0000, 0.0000, 0.0000)")[0] for line in lines if line.startswith("STRAIGHT")] == [
        "STRAIGHT_FEED(10.0000, 0.0000, 0.0000",
        "STRAIGHT_TRAVERSE(10.0000, 0.0000, -5.0000",
        "STRAIGHT_FEED(20.0000, 0.0000, -5.0000",
    ]


def test_g53_in_incremental_mode_is_passed_over(run: Any) -> None:
    assert fanuc(run, "G0 X5\nG91 G53 Z-5\nX1\nM30") == [[5, 0, 0], [6, 0, 0]]
    assert ("warning", "g53-motion") in remarks(run, "G0 X5\nG91 G53 Z-5\nM30")


def test_g54_with_p_is_an_additional_system(run: Any) -> None:
    assert fanuc(run, "G10 L20 P3 X7\nG54 P3 G0 X1\nG54 X1\nM30") == [[8, 0, 0], [1, 0, 0]]


def test_a_local_system_stands_beside_what_g92_shifts(run: Any) -> None:
    """G52 is taken from the system that G92 moved, and G52 X0 leaves that one in force (B-63324EN, 7.3)."""
    text = "G0 X10\nG92 X0\nG52 X5\nG0 X1\nG52 X0\nG0 X1\nG92.1 X0\nG0 X1\nM30"
    assert fanuc(run, text) == [[10, 0, 0], [16, 0, 0], [11, 0, 0], [1, 0, 0]]


def test_g92_1_takes_the_axes_of_its_block(run: Any) -> None:
    assert fanuc(run, "G0 X10 Y10\nG92 X0 Y0\nG92.1 X0\nG0 X1 Y1\nM30")[-1] == [1, 11, 0]


def test_g92_s_bounds_the_speed_and_does_not_set_it(calls: Any) -> None:
    lines = calls("M3 S500\nG92 S2000\nG96 S100\nM30", dialect="fanuc")
    assert "SET_SPINDLE_SPEED(0, 2000.0000)" not in lines
    assert "SET_SPINDLE_MODE(0 2000.0000)" in lines


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("G91 G28 Z0\nM30", [[1, 2, 0]]),
        ("G28 X5 Y6\nG90 G29 X7\nM30", [[5, 6, 3], [0, 0, 3], [5, 0, 3], [7, 0, 3]]),
        ("G30 Z4\nM30", [[1, 2, 4], [1, 2, 0]]),
        ("G30 P3 Z4\nM30", [[1, 2, 4], [1, 2, 0]]),
    ],
)
def test_reference_points(run: Any, text: str, expected: list[list[float]]) -> None:
    """The axes of the block alone go, by way of the point in the block; G29 comes back by that point."""
    assert fanuc(run, "G0 X1 Y2 Z3\n" + text)[1:] == expected


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("G30 Z0", [("note", "machine zero")]),
        ("G30 P4 Z0", [("warning", "machine zero")]),
        ("G53 G0 X1.\nG30.1\nG30 P2 X0", []),
        ("G53 G0 X1.\nG30.1\nG30 P3 X0\nG30 P3 X0", [("warning", "that of the second")]),
    ],
)
def test_the_place_of_a_reference_point_is_a_guess(run: Any, text: str, said: list[tuple[str, str]]) -> None:
    """The control has it in its parameters 1241 to 1243; lathes turn their turrets at G30 P3."""
    out = run(f"{text}\nM30", dialect="fanuc")
    assert out.errors == []
    found = [d for d in out.diagnostics if d.code == "reference-point"]
    assert [(str(d.severity), d.message.partition("taken to be ")[2]) for d in found] == said


def test_reference_points_under_a_rotation(run: Any) -> None:
    """Machine coordinates are not turned: X goes to its reference point, Y stays where the way led it."""
    assert fanuc(run, "G68 X0 Y0 R90\nG0 X10 Y0\nG91 G28 X0\nM30")[-1] == [0, 10, 0]


def test_polar_angles_add_up_in_incremental_mode(run: Any) -> None:
    """The radius stays about the origin, as in the manual's hole circle (B-63324EN, 14.5)."""
    found = fanuc(run, "G17 G90 G16\nG0 X100 Y30\nG91 Y120\nY120\nG90 G15\nM30")
    angles = [math.radians(a) for a in (30, 150, 270)]
    assert np.allclose(found, [[100 * math.cos(a), 100 * math.sin(a), 0] for a in angles], atol=1e-9)


def test_an_incremental_polar_radius_is_about_the_tool(run: Any) -> None:
    found = fanuc(run, "G0 X10 Y10\nG16 G91 X5 Y90\nM30")
    angle = math.radians(45 + 90)
    assert np.allclose(found[-1], [10 + 5 * math.cos(angle), 10 + 5 * math.sin(angle), 0])


def test_polar_holes_with_repeats(run: Any) -> None:
    """K repeats an incremental angle: a bolt circle in one block."""
    found = fanuc(run, "G0 X10 Y0 Z5\nG16 G91 G99 G81 Y90 Z-3 R-4 K3 F100\nG15 G80\nM30")
    corners = {(round(x), round(y)) for x, y, z in found if z < 0}
    assert corners == {(0, 10), (-10, 0), (0, -10)}


def test_thread_with_its_pitch_in_f(calls: Any) -> None:
    lines = calls("G97 S500 M3\nG33 Z-10 F1.5\nZ-20\nM30", dialect="fanuc")
    assert lines.count("START_SPEED_FEED_SYNC(1.500000,0)") == 2
    assert "SET_FEED_RATE(1.5000)" not in lines


def test_what_only_the_control_needs_is_passed_over(run: Any) -> None:
    text = "G10 L50\nN1020 P1 R88\nN1020 P2 R89\nG11\nG22 X1 Y1 Z1 I0 J0 K0\nG23\nM29 S500\nG5.1 Q1 X0 Y0\nG0 X1\nM30"
    assert fanuc(run, text) == [[1, 0, 0]]
    assert {code for _, code in remarks(run, text)} == {"control-data", "zone-not-checked"}


def test_other_m_codes_are_the_builders(run: Any) -> None:
    """They are events, and a warning names each."""
    text = "M31 M88\nG0 X1\nM30"
    assert fanuc(run, text) == [[1, 0, 0]]
    assert remarks(run, text) == [("warning", "builders-code")] * 2
    assert [e.values["m"] for e in run(text, dialect="fanuc").path.events if e.name == "user"] == [31, 88]


def test_variables_tell_the_modal_state(run: Any) -> None:
    """#4001 to #4130: codes by group, F, H, S, T (B-63324EN, 15.2)."""
    text = "G91 G18 G20 G41.1 D0\nG40 F5 S300 T3\nG81 Z-1 R0 F5\n" + "\n".join(
        f"#{100 + k}=#{n}"
        for k, n in enumerate((4001, 4002, 4003, 4006, 4007, 4009, 4010, 4014, 4109, 4119, 4120))
    )
    text = text.replace("G41.1 D0", "").replace("Z-1", "Y-1") + "\nG80 G21 G17 G90\n"
    text += "\n".join(f"G0 X#{100 + k}" for k in range(11)) + "\nM30"
    found = [x for x, _, _ in fanuc(run, text)][-11:]
    assert found == [0, 18, 91, 20, 40, 81, 98, 54, 5, 300, 3]


def test_group_12_is_read_as_the_coordinate_system_and_said_to_be_another_elsewhere(run: Any) -> None:
    """Group 12 of Mitsubishi's controls is the coordinate system; all public macros that were found with #4012 are written for them: they
    compare it with 54 to 59, and go back by G#33. On FANUC's it is G66 and G67."""
    assert fanuc(run, "G56\nG0 X#4012 Y#4014\nM30") == [[56, 56, 0]]
    assert fanuc(
        run, "G57\n#33=#4012\nIF[#33LT54]GOTO8\nG54\nG#33\nG0 X#4014\nGOTO9\nN8 #3000=121\nN9 M30"
    ) == [[57, 0, 0]]
    assert remarks(run, "G56\n#1=#4012\nG0 X#4012\nM30") == [("warning", "other-control")]
    assert remarks(run, "G56\n#1=#4014\nM30") == []


def test_the_codes_of_a_frame_in_force_are_read(run: Any) -> None:
    """B-64484EN, "System variables": groups 11, 16 and 22 are scaling, rotation and mirror images."""
    text = "G51.1 X0\n#101=#4022\nG50.1 X0\nG68 X0 Y0 R30\n#102=#4016\nG69\nG51 X0 Y0 P2.\n#103=#4011\nG50\n"
    assert fanuc(run, text + "G0 X#101 Y#102 Z#103\nG0 X#4022 Y#4016 Z#4011\nM30")[-2:] == [
        [51.1, 68, 51],
        [50.1, 69, 50],
    ]


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc"])
def test_machs_homing_is_not_a_stored_point_in_silence(run: Any, dialect: str) -> None:
    """Mach3's manual: G28.1 X Y Z references the axes; LinuxCNC's stores the point, and the words are a move."""
    said = [
        d.code
        for d in run("G0 X10\nG28.1 X5 Y5\nG28.1\nM30", dialect=dialect).diagnostics
        if d.severity == "warning"
    ]
    assert said == ["other-control"]


@pytest.mark.parametrize(
    "code", ["G15", "G25", "G26 P10 Q5 R20", "G40.1", "G49", "G50.1 X0", "G50.2", "G69", "G69.1", "G80.4"]
)
def test_heads_of_lathes_end_what_is_never_on(run: Any, code: str) -> None:
    out = run(f"G21 G97 S500 M3\n{code}\nG0 X20. Z5.\nM30", dialect="fanuc-lathe")
    assert out.errors == []
    assert out.path.end[-1, [0, 2]].tolist() == [10.0, 5.0]


def test_lathes_have_additional_systems(run: Any) -> None:
    out = run("G21 G10 L20 P3 X10. Z-50.\nG54.1 P3\nG0 X20. Z5.\nM30", dialect="fanuc-lathe")
    assert out.errors == []
    assert out.path.end[-1, [0, 2]].tolist() == [15.0, -45.0]


def test_variables_tell_positions(run: Any) -> None:
    """End of the block #5001, machine #5021, work #5041 (a rotation turns it), tool offset #5081."""
    text = (
        "G10 L2 P1 X100\nG54 G0 X3 Y0\n#1=#5001\n#2=#5021\nG68 X0 Y0 R90\nG0 X3 Y0\n#3=#5041\n#4=#5042\nG69\n"
    )
    text += "G0 X#1 Y#2\nX#3 Y#4\nM30"
    assert fanuc(run, text)[-2:] == [[103, 103, 0], [100, 3, 0]]


def test_an_origin_set_in_a_variable_counts_at_once(run: Any) -> None:
    text = "G54 G0 X1\n#5221=50\nX2\n#5222=#5221/2\nG91 Y1\n#5201=1\nG90 X0 Y0\n#7001=9\nG54.1 P1 X0\nM30"
    expected = [[1, 0, 0], [52, 0, 0], [52, 1, 0], [51, 25, 0], [10, 25, 0]]
    assert fanuc(run, text) == expected


def test_the_length_of_the_tool_is_in_its_place(run: Any) -> None:
    """#5041 and #5061 have it included, #5001 not (from memory of the table in B-63324EN, 15.2): Renishaw's macros read `#5043-#116`, where #116 is
    the length, and those of mojimould/mould_moji compare `#5063-#2050` with the place of G31. It was not in them, so that they fell short by it."""
    text = "#2201=50\n#2001=1\nG43 H1 G0 Z10\nG31 Z5 F100\nX[#5043-#5083] Y[#5063-[#2001+#2201]]\nX[#5003+1.] Y[#5041+2.]\nM30"
    assert fanuc(run, text)[-2:] == [[5, 5, 56], [6, 7, 56]]
    assert ("warning", "other-control") in remarks(run, text)
    assert remarks(run, "#2201=50\nG43 H1 G0 Z10\nX#5042\nM30") == []
    assert fanuc(run, "G103 P1\n#2201=50\nG43 H1 G0 Z10\nX#5043\nM30")[-1] == [10, 0, 60]


def test_additional_systems_have_two_numbers(run: Any) -> None:
    """#14001 on are X Y Z of G54.1 P1 to P300, and #7001 on of P1 to P48 (B-64484EN, 15.2; on Haas's NGC of G154 P1 to P99): #14001 was plain
    storage, and P49 counted only from its next choice on, in mm whatever the unit."""
    assert fanuc(run, "G54.1 P1\n#14001=10\nG0 X0\n#7001=#14001+#7001\nX0\nM30") == [[10, 0, 0], [20, 0, 0]]
    assert fanuc(run, "G154 P2 G0 X1\n#14021=5\n#14022=3\nX0 Y0\nM30") == [[1, 0, 0], [5, 3, 0]]
    assert fanuc(run, "G20 G54.1 P49\n#14961=1\nG0 X0\nX#14961\nM30") == [[25.4, 0, 0], [50.8, 0, 0]]


def test_variables_hold_tool_data(run: Any) -> None:
    """Length #11001 (#2201) and its wear #10001 (#2001), radius #13001 and its wear #12001 (offset memory C)."""
    text = "#11002=10\n#10002=0.5\n#2201=7\n#13002=3\n#12002=0.25\nG43 H2 G0 Z0\nG0 X[#13002+#12002] Y#11001\nM30"
    assert fanuc(run, text)[-1] == [3.25, 7, 10.5]


def test_the_fourth_axis_is_told_to_be_a(run: Any) -> None:
    """Variables of places are numbered by axis: on a mill with a table B #5044 is that of B."""
    assert remarks(run, "B90.\nG0 X#5044\nM30") == [("note", "other-control")]
    assert remarks(run, "#5224=5.\nG0 X#5043\nM30") == [("note", "other-control")]
    assert remarks(run, "G0 X#5043 Y[#5081+#5221]\nM30") == []


def test_radii_by_older_numbers(run: Any) -> None:
    """#2401 on are radii (B-63324EN, 15.2), and #2601 on their wear on Haas's mills (the system variables of its manual 96-8210); elsewhere
    those may be origins. A public library of macros for moulds (mojimould/mould_moji, O460000) reads `#[2400+#4120]+#[2600+#4120]`."""
    text = "#13002=3\n#12002=0.25\n{}G0 X#2402 Y[#[2400+2]+#[2600+2]]\nM30"
    assert fanuc(run, text.format(""))[-1] == [3, 3, 0]
    assert fanuc(run, "#2403=4\nG0 X#13003\nM30")[-1] == [4, 0, 0]
    haas = "G103 P1\n#2402=3\n#2602=0.25\nG0 X#2402 Y[#[2400+2]+#[2600+2]]\nM30"
    assert fanuc(run, haas)[-1] == [3, 3.25, 0]
    assert remarks(run, haas) == []


def test_a_loop_that_waits_for_the_clock_ends(run: Any) -> None:
    text = "#3001=0\nWHILE[#3001LT50]DO1\nEND1\nG0 X1\nM30"
    assert fanuc(run, text) == [[1, 0, 0]]
    assert remarks(run, text).count(("note", "timer")) == 1


def test_variables_of_the_state_cannot_be_set(run: Any) -> None:
    out = run("#5021=3\n#4001=1\nM30", dialect="fanuc")
    assert out.errors == [("parameter-read-only", 1, 1), ("parameter-read-only", 2, 1)]


def test_other_spellings_of_functions(run: Any) -> None:
    """SQR, RND and ATN are SQRT, ROUND and ATAN; POW has two values (B-63944EN, 16.3)."""
    text = "#1=POW[2,3]+SQR[9]\n#2=RND[2.6]\n#3=ATN[1]/[1]\nG0 X#1 Y#2 Z#3\nM30"
    assert fanuc(run, text) == [[11, 3, 45]]
    assert run("#1=SQR[9]\nM2", dialect="linuxcnc").errors[0][0] == "syntax"


def test_numbered_block_skip_and_colons(run: Any) -> None:
    text = ":1\n/2 G0 X9\nN3 /G0 X8\nM98 P2\nM30\n:0002\n/3N5 X7\nN4 /2 DPRNT[A]\nN6 G0 X1\nM99"
    assert fanuc(run, text) == [[1, 0, 0]]
    assert fanuc(run, text, block_delete=False) == [[9, 0, 0], [8, 0, 0], [7, 0, 0], [1, 0, 0]]


def test_output_commands_show_values(run: Any) -> None:
    text = "#1=-12.3456\nPOPEN\nDPRNT[X#1[53]*T#2[20]]\nN9 DPRNT[DONE]\nPCLOS\nG0 X1\nM30"
    out = run(text, dialect="fanuc")
    assert out.errors == []
    assert [e.values["text"] for e in out.path.events if e.name == "message"] == ["X-   12.346 T   ", "DONE"]


def test_a_loop_ends_in_its_own_program(run: Any) -> None:
    """The END of another program closes nothing."""
    out = run(
        "O1\nDO1\nG0 X1\nM98 P2\nM30\nO2\n#1=0\nWHILE[#1LT2]DO1\n#1=#1+1\nY#1\nEND1\nM99", dialect="fanuc"
    )
    assert out.errors == [("loop-unmatched", 2, 1)]
    assert out.path.end[:, :2].tolist()[:3] == [[1, 0], [1, 1], [1, 2]]


def test_machine_coordinates_are_not_polar(run: Any) -> None:
    assert fanuc(run, "G16 G0 X10 Y90\nG53 X3 Y4\nM30")[-1] == [3, 4, 0]


def test_one_shot_codes_beside_a_motion_code(run: Any) -> None:
    """G0 G91 G28 Z0 goes to the reference point, and G0 is in force after it."""
    text = "G1 X5 Z5 F100\nG0 G91 G28 Z0\nG90 Y7\nG1 G4 X2.\nG0 G92 X0\nX1\nM30"
    out = run(text, dialect="fanuc")
    assert out.errors == []
    assert out.path.end[out.path.kind != 3, :3].tolist() == [[5, 0, 5], [5, 0, 0], [5, 7, 0], [6, 7, 0]]
    assert [np.isfinite(f) for f in out.path.feed[out.path.kind != 3]] == [True, False, False, False]


@pytest.mark.parametrize("name", ["O0012", "o0012.nc", "O0012.cnc"])
def test_files_of_subprograms(tmp_path: Any, run: Any, name: str) -> None:
    """FANUC's files are named by their program number, often without a suffix."""
    (tmp_path / name).write_text("O0012\nG0 X3\nM99\n")
    assert fanuc(run, "M98 P12\nM198 P12\nM30", include=(tmp_path,)) == [[3, 0, 0]]


def test_l_of_an_arc_is_its_number_of_turns(calls: Any) -> None:
    """Four turns and a quarter are L5 (B-63944EN/02, 4.7, spiral interpolation)."""
    lines = calls("G0 X5 Z5\nG3 X5 Z-10 I-5 L5 F100\nG2 X0 Y-5 Z-12 I-5 L2\nM30", dialect="fanuc")
    arcs = [line for line in lines if line.startswith("ARC_FEED")]
    assert arcs == [
        "ARC_FEED(5.0000, 0.0000, 0.0000, 0.0000, 5, -10.0000, 0.0000, 0.0000, 0.0000)",
        "ARC_FEED(0.0000, -5.0000, 0.0000, 0.0000, -2, -12.0000, 0.0000, 0.0000, 0.0000)",
    ]


@pytest.mark.parametrize(
    ("words", "code"), [("L0", "arc-turns"), ("L1.5", "not-whole"), ("P2 L2", "arc-turns")]
)
def test_turns_that_no_arc_has(run: Any, words: str, code: str) -> None:
    assert run(f"G0 X5\nG3 I-5 {words} F100\nM30", dialect="fanuc").errors[0][:2] == (code, 2)


def test_turns_by_l_are_not_linuxcnc_s(run: Any) -> None:
    """`rs274` refuses L there."""
    assert run("G0 X5\nG3 X5 I-5 L2 F100\nM2", dialect="linuxcnc").errors[0] == ("unused-word", 2, 11)


@pytest.mark.parametrize("block", ["M98 P9 I10. X1.", "M98 P9 E3"])
def test_arguments_of_m98_are_told_to_be_those_of_g65(run: Any, block: str) -> None:
    """Controls hand arguments on by G65 and G66 alone (B-63324EN, 15.7)."""
    out = run(f"{block}\nM30\nO9\nM99", dialect="fanuc")
    said = next(d for d in out.diagnostics if d.code == "unused-word")
    assert said.hint is not None
    assert said.hint.startswith("M98 hands no arguments on: G65 P with ")


def test_variables_of_the_control_that_nobody_has_set(run: Any, tmp_path: Any) -> None:
    """#1004 is an input, #3012 the time, #4115 the program (B-63324EN, 15.2); each counts as 0, which each says once."""
    text = "O1\nG0 X[#1004] Y[#3012]\nX[#4115+1]\nX[#4115+1]\nM30"
    assert fanuc(run, text) == [[1, 0, 0]]
    found = [d for d in run(text, dialect="fanuc").diagnostics if d.code == "variable-assumed"]
    assert [(d.severity.value, d.span.line) for d in found if d.span] == [
        ("note", 2),
        ("note", 2),
        ("note", 3),
    ]
    assert [d.message[:5] for d in found] == ["#1004", "#3012", "#4115"]
    # What the program or a parameter file sets is known; so are origins, of which 0 is a value.
    assert ("note", "variable-assumed") not in remarks(run, "#1004=0\nG0 X[#1004+#5221+#2001+#3001]\nM30")
    file = tmp_path / "p.var"
    file.write_text("1004 0\n")
    out = run("G0 X[#1004]\nM30", dialect="fanuc", parameters=file)
    assert not any(d.code == "variable-assumed" for d in out.diagnostics)


def test_words_of_common_variables_that_nothing_has_set_are_told(run: Any) -> None:
    """A word of a vacant variable is ignored (B-63324EN, 15.1): G43 H#518 took no length without a word. Arguments may be left out."""
    for text, place in (
        ("O1\nT1 M6\nG43 H#518 Z5.\nM30", (3, 6)),
        ("O1\nG0 X[#518+1.]\nM30", (2, 6)),
        ("O1\n#518=1\nG43 H#518 Z5.\nM30", None),
        ("O1\nIF [#518 EQ #0] GOTO 9\nG0 X#518\nN9 #1=#518\nM30", None),
        ("O1\nM98 P2\nG43 H#518 Z5.\nM30\nO2\n#518=1\nM99", None),
        ("O1\n#1=518\n#[#1]=1\nG43 H#518 Z5.\nM30", None),
        ("O1\nG65 P2 X5.\nM30\nO2\nG0 X#24 Y#25 (H#518)\nM99", None),
    ):
        found = [d for d in run(text, dialect="fanuc").diagnostics if d.code == "variable-assumed"]
        assert [(d.span.line, d.span.column) for d in found if d.span] == ([place] if place else []), text


def test_each_variable_that_nothing_has_set_is_told_once(run: Any) -> None:
    text = "O1\nG0 X[#518+1.] Z#519\nY[#518+2.]\nG1 Z[#520-1.] F#521\nM30"
    found = [d for d in run(text, dialect="fanuc").diagnostics if d.code == "variable-assumed"]
    assert [d.message.split()[3] for d in found] == ["#519", "#518", "#521"]


@pytest.mark.parametrize("number", [2501, 2601, 2801])
def test_radii_and_origins_by_older_numbers_are_not_set_in_silence(run: Any, number: int) -> None:
    """#2401 on are radii, #2501 and #2601 also G54 X and Y of other controls (B-63324EN, 15.2): neither is meant for sure."""
    assert ("warning", "other-control") in remarks(run, f"#{number}=5.\nG0 X1\nM30")
    assert remarks(run, "#2201=5.\nG0 X1\nM30") == []


def test_an_angle_without_a_radius_is_warned_of(run: Any) -> None:
    """K0 keeps the words of the cycle and no place (B-63324EN, 13.1): six holes at one place are not meant."""
    cycle = "G0 X0 Y0 Z5\nG16 G81 {} Z-2 R1 F50 {}\nG91 Y60 K6\nG90 G15 G80\nM30"
    assert ("warning", "polar-angle") in remarks(run, cycle.format("X20 Y0", "K0"))
    assert ("warning", "polar-angle") not in remarks(run, cycle.format("X20 Y0", ""))
    assert ("warning", "polar-angle") not in remarks(run, "G16 G0 X0 Y30\nG15\nM30")


def test_an_angle_beside_g91_is_added(run: Any) -> None:
    """Six windows of Haas's example O60684 (96-8000, G68): each G91 G68 R60 turns on by 60 degrees; FANUC: parameter 5400 bit 0."""
    text = "G90 G0 X0 Y0\nM97 P1000 L6\nM30\nN1000\nG91 G68 R60.\nG90 G0 X10. Y0\nX0 Y0\nM99\n"
    corners = [row for row in fanuc(run, text) if row != [0, 0, 0]]
    expected = [[10 * math.cos(k * math.pi / 3), 10 * math.sin(k * math.pi / 3), 0] for k in range(1, 7)]
    assert np.allclose(corners, expected, atol=1e-8)
    assert remarks(run, text).count(("warning", "rotation-incremental")) == 1


def test_an_angle_under_an_earlier_g91_is_the_angle_itself(run: Any) -> None:
    text = "G68 X0 Y0 R30.\nG91\nG68 X0 Y0 R90.\nG90 G0 X10. Y0\nM30"
    assert fanuc(run, text) == [[0, 10, 0]]
    assert ("warning", "rotation-incremental") in remarks(run, text)


def test_a_second_rotation_without_a_centre_turns_about_the_tool(run: Any) -> None:
    """The tool's position is the centre where X and Y are omitted (Haas 96-8000, G68): where it is, not the words that led it there."""
    assert fanuc(run, "G68 X0 Y0 R90.\nG0 X10. Y0\nG68 R180.\nG0 X20. Y0\nM30") == [[0, 10, 0], [-20, 20, 0]]


@pytest.mark.parametrize(("incremental", "expected"), [("", [0, 10, 0]), ("I0", [-10, 0, 0])])
def test_an_angle_of_mach3_is_added_by_i(run: Any, incremental: str, expected: list[float]) -> None:
    """Mach3's manual, G68: with I under G91 the angle is added to the one in effect; the value of I is not used."""
    text = f"G68 A0 B0 R90.\nG91 G68 A0 B0 {incremental} R90.\nG90 G0 X10. Y0\nM30"
    assert fanuc(run, text)[-1] == expected


def test_g68_with_a_direction_turns_space(run: Any) -> None:
    """The origin is shifted, then turned; a second G68 without a centre turns about the same origin (B-62764EN, 14, N1 and N2)."""
    first, second = "G68 X10. Y20. Z30. I0 J0 K1. R90.\n", "G68 I1. J0 K0 R90.\n"
    assert fanuc(run, f"{first}G0 X1. Y2. Z3.\nG69\nG0 X0\nM30") == [[8, 21, 33], [0, 21, 33]]
    assert fanuc(run, f"{first}{second}G0 X1. Y2. Z3.\nG69\nM30") == [[13, 21, 32]]
    # A third of a turn about the diagonal takes X to Y, Y to Z and Z to X.
    assert fanuc(run, "G68 X0 Y0 Z0 I1. J1. K1. R120.\nG0 X1. Y2. Z3.\nM30") == [[3, 1, 2]]
    assert ("error", "axis-missing") in remarks(run, second + "M30")
    assert ("error", "plane-points") in remarks(run, "G68 X0 Y0 Z0 I0 J0 K0 R90.\nM30")
    assert ("warning", "swivel-frame") in remarks(run, first + "M30")


def test_variables_of_haas_are_no_lengths_of_tools(run: Any) -> None:
    """#10001 is the wear of the first length on FANUC's controls, and #10000 to #10999 are general variables of Haas's newer ones (96-8210):
    a public program that scans by a probe keeps its spacings there, and its tool 10 became 0.3 longer."""
    text = "G21 G90\n#10010=0.3\n#10012=10\n{}G43 H#10012\nG1 Z1 F300\nX#10010\nM30"
    assert fanuc(run, text.format(""))[-1] == [0.3, 0, 1.3]
    assert fanuc(run, text.format("G103 P1\n"))[-1] == [0.3, 0, 1]


def test_a_remark_on_a_variable_of_a_subprogram_is_of_its_line(run: Any) -> None:
    """It stood at the call."""
    out = run("G65 P2\nM98 P3\nM30\nO2\n#1=#4012\nM99\nO3\nIF[#2501 EQ 5]GOTO9\nN9 M99", dialect="fanuc")
    assert [(d.code, d.span.line) for d in out.diagnostics] == [("other-control", 5), ("variable-assumed", 8)]


def test_a_remark_on_a_variable_is_of_its_line_where_blocks_before_it_wait() -> None:
    """A public library of macros was remarked on at its comments."""
    found = Diagnostics()
    text = b"%\nO1\nG65 P2\nM30\nO2\n#2=8\nG0 X3.\n(D)\n\n#1=#[2500+#2]\nM99\n"
    assert list(canon(io.BytesIO(text), "t.nc", ReadOptions(dialect="fanuc", units="mm"), found))
    assert [(d.code, d.span.line) for d in found if d.span] == [("variable-assumed", 10)]
