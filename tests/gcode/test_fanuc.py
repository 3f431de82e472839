"""FANUC's dialect: macros, programs by number, frames, and how the dialect is told."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cncgen.toolpath.record import FeedMode, Kind


def points(out: Any) -> list[list[float]]:
    """Return X Y Z of the motions, after asserting that all went well."""
    assert out.errors == []
    kinds = zip(out.path.end[:, :3], out.path.kind, strict=True)
    return [np.round(row, 9).tolist() for row, kind in kinds if kind != 3]


def fanuc(run: Any, text: str, **options: Any) -> list[list[float]]:
    """Run a text in FANUC's dialect."""
    return points(run(text, dialect="fanuc", **options))


def test_jumps_and_loops(run: Any) -> None:
    text = "#1=0\nWHILE[#1LT3]DO1\n#1=#1+1\nG0X#1\nEND1\nIF[#1EQ3]GOTO100\nG0X99\nN100 G0Y1\nGOTO 200\nX98\nN200 M30"
    assert fanuc(run, text) == [[1, 0, 0], [2, 0, 0], [3, 0, 0], [3, 1, 0]]


@pytest.mark.parametrize(
    ("line", "minutes"),
    [
        # The manual's own example: 20 mm and 40 degrees at F300 take 0.14907 min (B-63174EN, 4.2).
        ("G1 X20. C40. F300.", math.hypot(20.0, 40.0) / 300.0),
        ("G1 X3. Y4. C12. F300.", 13.0 / 300.0),
        ("G20 G1 X1. A2. F10.", math.hypot(1.0, 2.0) / 10.0),
        ("G95 S100 M3 G1 X20. C40. F2.", math.hypot(20.0, 40.0) / 200.0),
        ("G93 G1 X20. C40. F5.", 1.0 / 5.0),
        ("G1 A3. C4. F300.", 5.0 / 300.0),
        ("G1 X20. F300.", 20.0 / 300.0),
        ("G2 X20. Y0 I10. J0 A90. F300.", 10.0 * math.pi / 300.0),
    ],
)
def test_degrees_count_in_the_feed_of_lines(run: Any, line: str, minutes: float) -> None:
    """F is along all axes, degrees as millimetres (inches); of an arc it is along the arc."""
    path = run(f"G91 {line}\nM30", dialect="fanuc").path
    (row,) = np.flatnonzero(path.kind != Kind.EVENT)
    way = path.end[row] - path.start
    linear = [k for k, letter in enumerate(path.axes) if letter in "XYZ"]
    length = np.linalg.norm(way[linear]) or np.linalg.norm(way)
    length = 10.0 * math.pi if path.kind[row] == Kind.ARC else length
    seconds = (
        1.0 / path.feed[row] if path.feed_mode[row] == FeedMode.INVERSE_TIME else length / path.feed[row]
    )
    assert seconds == pytest.approx(60.0 * minutes, rel=1e-12)
    of_linuxcnc = run("G91 G1 X20 C40 F300\nM2", dialect="linuxcnc").path
    assert of_linuxcnc.feed[0] == pytest.approx(5.0)


def test_nested_loops(run: Any) -> None:
    text = "#1=0\nWHILE[#1LT2]DO1\n#1=#1+1\n#2=0\nWHILE[#2LT2]DO2\n#2=#2+1\nX#1Y#2\nEND2\nEND1\nM30"
    assert fanuc(run, text) == [[1, 1, 0], [1, 2, 0], [2, 1, 0], [2, 2, 0]]


def test_a_jump_back_is_a_loop(run: Any) -> None:
    assert fanuc(run, "#1=1\nN10 G0 X#1\n#1=#1*2\nIF[#1LE8]GOTO10\nM30") == [[v, 0, 0] for v in (1, 2, 4, 8)]


def test_vacant_parameters(run: Any) -> None:
    """Vacant is no word, 0 in arithmetic, equal to vacant alone (B-63324EN, 15.1)."""
    text = "G0 X5\nIF[#2EQ#0]THEN #3=1\nIF[#2EQ0]THEN #4=1\nG0 X#2 Y#3 Z#4\n#5=#2+2\nX#5\nM30"
    assert fanuc(run, text) == [[5, 0, 0], [5, 1, 0], [2, 1, 0]]


def test_a_condition_needs_no_then(run: Any) -> None:
    """As programs of shops write it: IF[#9GT0]#12=#9, and IF [ #1 EQ #2 ] S900. F500. on a Haas."""
    text = "#9=2\n#12=1\nIF[#9GT0]#12=#9(SET)\nIF[#9LT0]#12=7\nN8IF[#9EQ2]##9=[#12+1]\nG0 X#12 Y#2\nM30"
    assert fanuc(run, text) == [[2, 3, 0]]
    assert fanuc(run, "#1=1\nIF[#1EQ0]G0 X5\nIF[#1EQ1]G0 Y6\nM30") == [[0, 6, 0]]


def test_words_behind_the_head_of_a_loop_run_in_each_round(run: Any) -> None:
    """Haas programs of a shop begin passes so: WHILE [ #1 GT #2 ] DO1 #1= #1 - #3 IF [ #1 LT #2 ] THEN #1= #2."""
    text = "#1=0\nWHILE[#1GT-5]DO1(PASS)#1=#1-2 IF[#1LT-5]THEN#1=-5\nG0 Z#1\nEND1\nM30"
    assert [point[2] for point in fanuc(run, text)] == [-2, -4, -5]
    nested = (
        "#1=0\nDO1 #1=#1+1\n#2=0\nWHILE[#2LT2]DO2 #2=#2+1\nG0 X[10*#1+#2]\nEND2\nIF[#1EQ2]GOTO9\nEND1\nN9M30"
    )
    assert [point[0] for point in fanuc(run, nested)] == [11, 12, 21, 22]
    many = fanuc(run, "#1=0\nG0\nWHILE[#1LT3000]DO1 #1=#1+1\nX#1\nEND1\nM30")
    assert [point[0] for point in many] == list(range(1, 3001))


@pytest.mark.parametrize(
    ("word", "seconds", "said"),
    [("X1500", 1.5, 1), ("U500", 0.5, 1), ("X2", 2, 1), ("X2.", 2, 0), ("X150.", 150, 0)],
)
def test_a_dwell_without_a_decimal_point_counts_milliseconds(
    run: Any, word: str, seconds: float, said: int
) -> None:
    """G04 X1500 waits 1.5 s where least increments count (B-64484EN, "Dwell"), and X2 0.002 s: both readings are named."""
    out = run(f"G21\nG0X1.\nG4{word}\nM30", dialect="fanuc")
    assert [each.values["seconds"] for each in out.path.events if "seconds" in each.values] == [seconds]
    assert [d.code for d in out.diagnostics].count("dwell-point") == said


def test_an_angle_without_a_decimal_point_counts_thousandths(run: Any) -> None:
    """R90000 of G68 was 250 turns, which is none."""
    assert fanuc(run, "G21\nG68X0Y0R90000\nG0X10.Y0.\nG69\nM30") == [[0, 10, 0]]
    assert fanuc(run, "G21\nG68X0Y0R450.\nG0X10.Y0.\nG69\nM30") == [[0, 10, 0]]
    assert fanuc(run, "G21\nG68X0Y0R90\nG0X10.Y0.\nG69\nM30") == [[0, 10, 0]]


def test_macro_calls_have_arguments_and_locals_of_their_own(run: Any) -> None:
    text = "#1=4\nG65 P9001 A1.5 B2 X7 L2\nX#1\nM30\nO9001\nG0 X#1 Y#2 Z#24\n#1=9\nM99"
    assert fanuc(run, "G0\n" + text)[-1] == [4, 2, 7]
    assert [1.5, 2, 7] in fanuc(run, "G0\n" + text)


def test_argument_specification_two(run: Any) -> None:
    """I J K in sets: #4 #5 #6, then #7 #8 #9."""
    text = "G65 P1 I1 J2 K3 I4 J5 K6\nM30\nO1\nG0 X#4 Y#5 Z#6\nX#7 Y#8 Z#9\nM99"
    assert fanuc(run, text) == [[1, 2, 3], [4, 5, 6]]


def test_modal_macro_follows_each_motion(run: Any) -> None:
    text = "G66 P5 A3\nX10\nF100\nX20\nG67\nX30\nM30\nO5\nZ-#1\nZ0\nM99"
    expected = [[10, 0, 0], [10, 0, -3], [10, 0, 0], [20, 0, 0], [20, 0, -3], [20, 0, 0], [30, 0, 0]]
    assert fanuc(run, text) == expected


@pytest.mark.parametrize("block", ["G4 X1.", "G10 L2 P2 X5.", "G52 X0", "G90", "S500"])
def test_a_modal_macro_does_not_follow_axis_words_that_move_nothing(run: Any, block: str) -> None:
    """It follows blocks with a motion (B-63324EN, 15.7.2), that of an axis which stands there already, too."""
    text = f"G66 P5 A3\n{block}\nX0\nG67\nX30\nM30\nO5\nZ-#1\nZ0\nM99"
    assert fanuc(run, text) == [[0, 0, -3], [0, 0, 0], [30, 0, 0]]


def test_subprograms_share_the_callers_locals(run: Any) -> None:
    assert fanuc(run, "#1=2\nM98 P20003\nG0 X#1\nM30\nO3\n#1=#1+1\nM99") == [[4, 0, 0]]
    assert fanuc(run, "M98 P3\nX1\nN7 X2\nM30\nO3\nX9\nM99 P7") == [[9, 0, 0], [2, 0, 0]]


def test_m99_p_in_the_main_program_goes_to_its_line(run: Any) -> None:
    """As controls have it, most often behind a slash: it does not end the program there."""
    assert fanuc(run, "X1\nM99 P7\nX5\nN7 X6\nM30") == [[1, 0, 0], [6, 0, 0]]
    assert fanuc(run, "X1\n/M99 P7\nX5\nN7 X6\nM30") == [[1, 0, 0], [5, 0, 0], [6, 0, 0]]
    assert fanuc(run, "#1=0\nN7 #1=#1+1\nX#1\nIF [#1 GE 3] GOTO 9\nM99 P7\nN9 M30") == [
        [1, 0, 0],
        [2, 0, 0],
        [3, 0, 0],
    ]
    assert fanuc(run, "N7 G0 X1\nX2\nM99 P7\nM30") == [[1, 0, 0], [2, 0, 0]]


@pytest.mark.parametrize("call", ["M98 P200", "G65 P200", "M99 P77"])
def test_what_stands_behind_a_call_that_leads_nowhere_is_read(run: Any, call: str) -> None:
    """Plain blocks to the end are scanned with the call: the text counted as read, M30 as missing, I1 as no fault."""
    outcome = run(f"O100\n{call}\nG1 X5 F100\nG43 H77 X6\nG1 X7 I1\nM30\n", dialect="fanuc")
    assert [line for _, line, _ in outcome.errors] == [2, 5]
    assert "no-program-end" not in [each.code for each in outcome.diagnostics]


def test_programs_in_files(run: Any, tmp_path: Any) -> None:
    (tmp_path / "O0012.nc").write_text("%\nO0012\nG0 X5\nM99\n%\n")
    assert fanuc(run, "M98 P12\nM30", include=(tmp_path,)) == [[5, 0, 0]]


def test_the_next_program_of_a_file_is_not_run(run: Any) -> None:
    assert fanuc(run, "O1\nG0 X1\nO2\nG0 X2\nM30") == [[1, 0, 0]]


def test_rotation_mirror_and_scaling(run: Any) -> None:
    assert fanuc(run, "G68 X0 Y0 R90\nG0 X10 Y0\nG69\nX1\nM30") == [[0, 10, 0], [1, 10, 0]]
    assert fanuc(run, "G51.1 X5\nG0 X10 Y1\nG50.1\nX1\nM30") == [[0, 1, 0], [1, 1, 0]]
    assert fanuc(run, "G51 X10 Y0 P2\nG0 X20 Y1\nG50\nX0\nM30") == [[30, 2, 0], [0, 2, 0]]


def test_a_factor_of_scaling_in_thousandths(run: Any) -> None:
    """G51 P2000 and I2000 double, as on controls that take no decimal point there; a note says so."""
    text = "G51 X0 Y0 P{}\nG0 X3\nM30"
    assert fanuc(run, text.format(2000)) == fanuc(run, text.format(2)) == [[6, 0, 0]]
    notes = [d.code for d in run(text.format(2000), dialect="fanuc").diagnostics]
    assert notes == ["scale-thousandths"]


@pytest.mark.parametrize(
    ("frame", "carried"),
    [
        ("G68 X0 Y0 R90", lambda x, y: (-y, x)),
        ("G51.1 X0", lambda x, y: (-x, y)),
        ("G51 X0 Y0 I2 J3", lambda x, y: (2 * x, 3 * y)),
    ],
)
def test_a_frame_carries_splines(run: Any, frame: str, carried: Any) -> None:
    """Control points are turned, mirrored and scaled; weights and knots are the programmed ones."""
    points = [(0, 0), (10, 20), (30, 20), (40, -10)]
    blocks = [
        f"K{k} X{x} Y{y} R{w}" for k, (x, y), w in zip((0, 0, 0, 1), points, (1, 2, 0.5, 1), strict=True)
    ]
    text = f"{frame}\nG6.2 P3 F100 " + "\n".join([*blocks, "K2", "K2", "K2", "M30"])
    out = run(text, dialect="fanuc")
    assert out.errors == []
    table = out.path.nurbs
    np.testing.assert_allclose(table.control_points[:, :2], [carried(x, y) for x, y in points], atol=1e-12)
    np.testing.assert_array_equal(table.weights, [1, 2, 0.5, 1])
    np.testing.assert_array_equal(table.knots, [0, 0, 0, 1, 2, 2, 2])


def test_a_frame_carries_feeds_taps_and_probes(run: Any) -> None:
    text = "G68 X0 Y0 R90\nM3 S100\nG1 X10 F100\nG31 Y5\nG84 X20 Z-5 R2\nG80\nM30"
    out = run(text, dialect="fanuc")
    assert out.errors == []
    ends = out.path.end[out.path.kind == 0, :3].round(9).tolist()
    assert ends[:3] == [[0, 10, 0], [-5, 10, 0], [-5, 20, 0]]
    assert [-5, 20, -5] in ends


def test_a_mirrored_arc_turns_the_other_way(run: Any) -> None:
    out = run("G51.1 X0\nG0 X10\nG2 X20 I5 F100\nM30", dialect="fanuc")
    assert out.errors == []
    np.testing.assert_allclose(out.path.arcs.normal, [[0, 0, 1]])
    np.testing.assert_allclose(out.path.arcs.centre, [[-15, 0, 0]])


def test_polar_coordinates(run: Any) -> None:
    found = fanuc(run, "G16\nG0 X10 Y90\nG91 Y-90\nG90 G15\nX0\nM30")
    np.testing.assert_allclose(found, [[0, 10, 0], [10, 0, 0], [0, 0, 0]], atol=1e-9)


def test_look_ahead_codes_are_accepted(run: Any) -> None:
    out = run("G5 P10000\nG05.1 Q1\nG08 P1\nG0 X1\nG5 P0\nM30", dialect="fanuc")
    assert points(out) == [[1, 0, 0]]


def test_numbers_without_a_decimal_point(run: Any) -> None:
    text = "G0 X10 Y10. Z1500\nG20\nX100\n#1=5\nX#1\nM30"
    found = fanuc(run, text, least_increment=0.001)
    np.testing.assert_allclose(found, [[0.01, 10, 1.5], [0.254, 10, 1.5], [127, 10, 1.5]])
    assert fanuc(run, text)[0] == [10, 10, 1500]


def test_coordinate_systems(run: Any) -> None:
    text = (
        "G10 L2 P1 X10\nG10 L20 P2 X100 Y5\nG0 X1\nG54.1 P2\nX1 Y0\nG54\nX0\nG91 G10 L2 P1 X-3\nG90 X0\nM30"
    )
    assert fanuc(run, text) == [[11, 0, 0], [101, 5, 0], [10, 5, 0], [7, 5, 0]]
    far = "G10 L20 P48 X100\nG10 L20 P49 X200\nG10 L20 P300 X300\nG54.1 P48\nG0 X1\nG54.1 P49\nX1\nG154 P300\nX1\nM30"
    assert [x for x, *_ in fanuc(run, far)] == [101, 201, 301]
    assert run("G54.1 P301\nM30", dialect="fanuc").errors == [("system-number", 1, 7)]
    assert run("G10 L2 P7 X1\nM30", dialect="fanuc").errors == [("g10-words", 1, 8)]


def test_tool_lengths_set_by_the_program(run: Any) -> None:
    assert fanuc(run, "G10 L10 P3 R25.\nG0 G43 H3 Z0\nG49 Z0\nM30") == [[0, 0, 25], [0, 0, 0]]


def test_an_alarm_ends_the_program(run: Any) -> None:
    out = run("G0 X1\n#3000=12(NO TOOL)\nG0 X2\nM30", dialect="fanuc")
    assert [d.message for d in out.diagnostics] == ["the program raises alarm 12: NO TOOL"]
    out = run("IF[#1EQ#0]THEN#3000=1(NEED AXIS)\nG0 X2\nM30", dialect="fanuc")
    assert [d.message for d in out.diagnostics] == ["the program raises alarm 1: NEED AXIS"]


@pytest.mark.parametrize(
    ("text", "dialect", "line"),
    [
        ("G0 X1\nIF[#1EQ1]GOTO10\nN10 M30", "fanuc", 2),
        ("%\nO1234 (PART)\nG0 X1\nM30\n%", "fanuc", 2),
        ("#1=#2+1\nM30", "fanuc", 1),
        ("G0 X1\nN5 IF [#1 EQ 1] THEN #2=3\nM30", "fanuc", 2),
        ("G54.1 P3\nM30", "fanuc", 1),
        ("DPRNT[X#1[33]]\nM30", "fanuc", 1),
        ("G0 X4\nG04 X.5\nM30", "fanuc", 2),
        ("G0 X1\no100 if [1]\no100 endif\nM2", "linuxcnc", 2),
        ("G68 X0 Y0 R10\nM30", "fanuc", 1),
        ("#<depth>=1\nM2", "linuxcnc", 1),
    ],
)
def test_auto_says_what_it_chose_and_why(run: Any, text: str, dialect: str, line: int) -> None:
    out = run(text)
    (note,) = [d for d in out.diagnostics if d.code == "dialect"]
    assert note.severity == "note"
    assert note.message.startswith(f"read as {dialect}: ")
    assert note.span
    assert note.span.line == line
    assert out.errors == []


@pytest.mark.parametrize(
    "text",
    [
        "G0 X1\nM2",
        "#1=5 #2=-6 (a-b)\nM2",
        "#1=[2+3] ; x-1\nG10 L1 P2 Z3\nM2",
        "G5 P0 Q-3 I1 J1 X1 Y1 F100\nM2",
        "(IF GOTO)\nG0 X1\nM2",
    ],
)
def test_auto_without_a_sign_is_silent(run: Any, text: str) -> None:
    assert run(text).diagnostics == []


def test_modal_macros_nest(run: Any) -> None:
    """Motions of the last macro call the one before it (B-63324EN, 15.7.2)."""
    text = "G0\nG66 P1\nZ10\nG66 P2\nZ15\nG67\nZ20\nG67\nZ25\nM30\nO1\nX#101\n#101=#101+1\nM99\nO2\nY60\nY70\nM99"
    found = fanuc(run, "#101=1\n" + text)
    assert found == [
        [0, 0, 10],
        [1, 0, 10],
        [1, 0, 15],
        [1, 60, 15],
        [2, 60, 15],
        [2, 70, 15],
        [3, 70, 15],
        [3, 70, 20],
        [4, 70, 20],
        [4, 70, 25],
    ]


@pytest.mark.parametrize("by", ["G65 P1 A3.", "G66 P1 A3.\nG4 P0\nX0"])
def test_g_codes_before_a_macro_call_apply_to_it(run: Any, by: str) -> None:
    """G91 of the block of G65 was passed over in silence, so the macro went to X3 and not on by 3."""
    macro = "\nM30\nO1\nX#1\nM99"
    assert fanuc(run, f"G0 X5\nG91 {by}{macro}")[-1] == [8, 0, 0]
    assert fanuc(run, f"G0 X5\nG91\n{by}{macro}")[-1] == [8, 0, 0]


@pytest.mark.parametrize(
    ("line", "column"), [("G65 P1 A1. G1", 12), ("X5. G65 P1 A1.", 1), ("G0 X5. G66 P1 A1.", 4)]
)
def test_what_is_not_an_argument_of_a_macro_is_refused(run: Any, line: str, column: int) -> None:
    """B-63324EN, 15.7.1: G65 stands before its arguments, and G is none. They were passed over, or became arguments."""
    found = run(f"G21\n{line}\nM30\nO1\nX#1\nM99", dialect="fanuc")
    assert found.errors == [("macro-arguments", 2, column)]


def test_angles_of_macros(run: Any) -> None:
    """ATAN[y] is -90 to 90, ATAN[y]/[x] 0 to 360, ASIN 0 to 360 (parameter NAT is 0)."""
    found = fanuc(run, "G0 X[ATAN[-1]] Y[ATAN[-1]/[-1]] Z[ASIN[-0.5]]\nX[ATAN[1]/2] Y[ATAN[1,1]]\nM30")
    np.testing.assert_allclose(found, [[-45, 225, 330], [22.5, 45, 330]])


def test_geometry_and_wear_of_tools(run: Any) -> None:
    text = "G10 L10 P1 R10.\nG10 L11 P1 R1.\nG0 G43 H1 Z0\nG44 H1 Z0\nG91 G10 L11 P1 R2.\nG90 G43 H1 Z0\nH0 G43 Z1\nM30"
    assert fanuc(run, text) == [[0, 0, 11], [0, 0, -11], [0, 0, 13], [0, 0, 1]]


def test_a_length_taken_under_g91(run: Any) -> None:
    """The example of tool length offset A in FANUC's manuals: H1 = -4 counts in the blocks that take and drop it, whose path closes."""
    text = (
        "G10 L10 P1 R-4.\nG91 G0 X120. Y80.\nG43 Z-32. H1\nG1 Z-21. F1000\nG0 Z21.\nX30. Y-50.\nG1 Z-41.\nG0 Z41.\nX50. Y30.\n"
        "G1 Z-25.\nG0 Z57. H0\nX-200. Y-60.\nM2"
    )
    assert [z for _, _, z in fanuc(run, text)] == [0, -36, -57, -36, -36, -77, -36, -36, -61, 0, 0]
    assert fanuc(run, text)[-1] == [0, 0, 0]
    assert fanuc(run, "G10 L10 P1 R-4.\nG0 G43 Z5. H1\nG91 G49 Z2.\nG90 Z0\nM30") == [
        [0, 0, 1],
        [0, 0, 7],
        [0, 0, 0],
    ]
    for block, severity in (
        ("G91 G43 Z1. H1", "warning"),
        ("G43 H1", "note"),
        ("G43 Z1. H1", None),
        ("G91 G28 Z0 G43 H1", None),
    ):
        out = run(f"G10 L10 P1 R-4.\nG0 X1.\n{block}\nM30", dialect="fanuc")
        assert [d.severity.value for d in out.diagnostics if d.code == "length-moves"] == [severity] * (
            severity is not None
        ), block


def test_the_shift_of_all_systems(run: Any) -> None:
    text = "G10 L2 P0 X5\nG10 L2 P2 Y1\nG0 X0\nG55 Y0\nG10 L2 P0 X0\nX1\nM30"
    assert fanuc(run, text) == [[5, 0, 0], [5, 1, 0], [1, 1, 0]]


def test_skip_goes_to_the_programmed_point_and_says_so(run: Any) -> None:
    out = run("G31 X10 F100\nG0 X#5061 Y1\nM30", dialect="fanuc")
    assert points(out) == [[10, 0, 0], [10, 1, 0]]
    assert [d.code for d in out.diagnostics] == ["probe-not-run"]


def test_exact_stop_of_one_block(run: Any) -> None:
    out = run("G64\nG1 X1 F100\nG9 X2\nX3\nG61 X4\nG63 X5\nM30", dialect="fanuc")
    assert out.errors == []
    modes = out.path.path_mode[out.path.kind == 0].tolist()
    assert modes[0] == modes[2] == modes[4]
    assert modes[1] == modes[3] != modes[0]


def test_frames_together(run: Any) -> None:
    """Mirror, then scaling, then rotation: (3, 1) -> (-3, 1) -> (-6, 2) -> a quarter turn, the other way in a mirror -> (2, 6)."""
    text = "G51.1 X0\nG51 X0 Y0 P2\nG68 X0 Y0 R90\nG0 X3 Y1\nG69\nX3 Y1\nG50\nX3 Y1\nG50.1\nX3 Y1\nM30"
    assert fanuc(run, text) == [[2, 6, 0], [-6, 2, 0], [-3, 1, 0], [3, 1, 0]]


@pytest.mark.parametrize(
    ("frame", "expected"),
    [
        # Scaling carries the centre to (20, 0), and X20 to 40 (B-63944EN-2, 6, "Scaling and coordinate system rotation"; Haas 96-8000, G68).
        ("G51 X0 Y0 P2.\nG68 X10 Y0 R90", [20, 20, 0]),
        # Without a centre it is where the tool stands.
        ("G51 X0 Y0 P2.\nG0 X10 Y0\nG68 R90", [20, 20, 0]),
        # In a mirror image of one axis "CW and CCW are interchanged" (SINUMERIK, ISO Milling, table 3-6): the image of the turned figure.
        ("G51.1 X0\nG68 X10 Y0 R90", [-10, 10, 0]),
        ("G51 X0 Y0 I-1. J1. K1.\nG68 X10 Y0 R90", [-10, 10, 0]),
        # Of both axes they are not.
        ("G51.1 X0 Y0\nG68 X10 Y0 R90", [-10, -10, 0]),
        # Scaling in a rotation: the centre of scaling turns (Mitsubishi M700V, 13.20 (7)).
        ("G68 X0 Y0 R90\nG51 X10 Y0 P2.", [0, 30, 0]),
    ],
)
def test_rotation_within_scaling_and_mirror_images(run: Any, frame: str, expected: list[float]) -> None:
    assert fanuc(run, f"{frame}\nG0 X20 Y0\nM30")[-1] == expected


def test_steps_of_a_scaled_hole_are_as_written(run: Any) -> None:
    """Scaling carries Z and R of a cycle, not steps, clearances and shifts (Haas 96-8000, G51)."""
    scale = "G0 Z10.\nG51 X0 Y0 Z0 P2.\n"
    found = fanuc(run, f"{scale}G83 X5. Z-10. R1. Q12. F100.\nG80\nM30")
    assert [z for _, _, z in found[2:]] == [2, -10, 2, -9.746, -20, 10]
    found = fanuc(run, f"{scale}G73 X5. Z-10. R1. I12. J2. K1. F100.\nG80\nM30")
    assert [z for _, _, z in found[2:]] == [2, -10, -9.746, -20, 10]
    found = fanuc(run, f"{scale}M3 S100\nG76 X5. Z-10. R1. Q.5 F100.\nG80\nM30")
    assert [10.5, 0, -20] in found
    found = fanuc(run, f"{scale}M3 S100\nG76 X5. Z-10. R1. I.5 J-.25 F100.\nG80\nM30")
    assert [10.5, -0.25, -20] in found


def test_a_centre_off_the_axis_of_a_mirror_image_is_warned_of(run: Any) -> None:
    """The manuals tell which way it turns, and not whether the centre is mirrored."""
    for centre, said in (("X10 Y0", 1), ("X0 Y10", 0)):
        out = run(f"G51.1 X0\nG68 {centre} R90\nG0 X20 Y0\nM30", dialect="fanuc")
        assert [d.code for d in out.diagnostics].count("rotation-mirrored") == said


def test_loops_and_jumps_that_run_often(run: Any) -> None:
    """Loops in a loop, left by a jump, in a program run twice: 2 · (1 + 2 + 3 + 3 + 3) rounds of 0.5 mm."""
    text = (
        "%\nO1\nG91 F100\nM98 P2 L2\nM30\nO2\n#1=0\nWHILE[#1 LT 5]DO1\n#1=#1+1\n#2=0\nDO2\n#2=#2+1\nG1 X0.5\n"
        "IF[#2 GE #1]GOTO 20\nIF[#2 EQ 3]GOTO 20\nEND2\nN20 G1 Y1\nEND1\nGOTO 40\nN30 X99\nN40 M99\n%\n"
    )
    out = run(text, dialect="fanuc")
    assert out.errors == []
    assert out.path.end[-1, :2].tolist() == [0.5 * 2 * (1 + 2 + 3 + 3 + 3), 10.0]
    missing = run("%\nO1\n#1=1\nN1 #1=#1-1\nIF[#1 GE 0]GOTO 1\nIF[#1 LT 0]GOTO 7\nM30\n%\n", dialect="fanuc")
    assert [(code, line) for code, line, _ in missing.errors] == [("goto-target", 6)]


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ("G04 P1.", [("dwell-point", 1, 5)]),
        ("(P1.) G4 P.5", [("dwell-point", 1, 10)]),
        ("G04 P500 (P1.)", []),
        ("G04 X1.", []),
    ],
)
def test_a_dwell_in_milliseconds_has_no_decimal_point(
    run: Any, block: str, said: list[tuple[str, int, int]]
) -> None:
    out = run(f"{block}\nM30", dialect="fanuc")
    assert [(d.code, d.span.line, d.span.column) for d in out.diagnostics if d.span] == said


def test_g53_without_axes_does_nothing(run: Any) -> None:
    assert fanuc(run, "G0 X5\nG53\nG1 F100 X9\nM30") == [[5, 0, 0], [9, 0, 0]]


def test_codes_of_the_machines_builder_are_remarked_once_each(run: Any) -> None:
    out = run("M10\nM11\n" * 50 + "M30", dialect="fanuc")
    assert [(d.code, d.span.line) for d in out.diagnostics] == [("builders-code", 1), ("builders-code", 2)]
    assert [event.values["m"] for event in out.path.events if event.name == "user"] == [10, 11] * 50


def test_a_motion_code_beside_g28_tells_the_dialect(run: Any) -> None:
    out = run("N1 G00 G91 G28 Z0.;\nN2 G91 G0 G28 X0. Y0.;\nM30")
    assert (out.errors, [d.code for d in out.diagnostics]) == ([], ["dialect"])
    assert [d.code for d in run("G91 G28 Z0\nG0 X1\nM2").diagnostics] == []


@pytest.mark.parametrize(
    "head", ["%\n<PART-1>(a part)", "%O1000(A PART)", "%\nO<PART-1>", "%\n:1000 (A PART)"]
)
def test_heads_of_programs(run: Any, head: str) -> None:
    """Newer controls write a name in < > without the O; what stands behind % belongs to the leader."""
    out = run(f"{head}\nG0X1.\nM30\n%")
    assert points(out) == [[1, 0, 0]]
    assert [d.code for d in out.diagnostics] == ["dialect"]


@pytest.mark.parametrize(
    ("block", "code", "column"),
    [
        ("<PART", "syntax", 1),
        ("M98 <>", "syntax", 5),
        ("G1 <5> X2", "unused-word", 4),
        ("<A> G1 X1", "feed-missing", 5),
    ],
)
def test_names_stand_alone_on_their_line(run: Any, block: str, code: str, column: int) -> None:
    """Or at the beginning of a line, where words may follow as behind a number; or behind a word that calls by name."""
    out = run(f"O1\n{block}\nM30", dialect="fanuc")
    assert out.errors == [(code, 2, column)]


def test_lines_of_haas_run_like_a_program(run: Any) -> None:
    """M97 goes to a line of its own program and back at M99, as often as L says; in a subprogram its own lines count."""
    out = run(
        "O1\nG0 X1\nM97 P7 L2\nG91\nM98 P2\nM30\nN7 Y1\nM99\nO2\nM97 P7\nM99\nN7 Z3\nM99", dialect="fanuc"
    )
    assert out.errors == []
    ends = out.path.end[out.path.kind != 3, :3].tolist()
    assert ends == [[1, 0, 0], [1, 1, 0], [1, 1, 3]]
    wrong = run("O1\nM97\nM97 P8\nM97 P7 L0\nM30\nN7 X1\nN9 M97 P9\nM99", dialect="fanuc")
    assert wrong.errors == [("sub-missing", 2, 1), ("goto-target", 3, 5)]
    deep = run("O1\nN9 M97 P9\nM30", dialect="fanuc")
    assert [code for code, _, _ in deep.errors] == ["call-depth"]


def test_the_length_of_an_output_is_no_jump(run: Any) -> None:
    """The length of the text stands behind its instruction: 13074 is 18 + 256 * 51, as FLOW is of SUB, and 4 the first number before."""
    output = "DPRNT[" + 13_067 * "*" + "]"
    program = f"O1\nG21 G0 X1\nX4.\n{output}\nM98 P4\nM30\n"
    assert run(program, dialect="fanuc").errors == [("sub-missing", 5, 5)]


def test_codes_of_haas(run: Any) -> None:
    out = run("G10 L20 P3 X5\nG103 P1\nG187 P3 E0.01\nG154 P3\nG0 X1\nM30", dialect="fanuc")
    assert out.errors == []
    assert out.path.end[-1, 0] == 6


@pytest.mark.parametrize(
    "head", ["(A NAME)\n %\n", "; made by a post\n\n%\nO12 (PART)\n", "(A (B))\n%\n", "%1\n", "(A)\n%0012\n"]
)
@pytest.mark.parametrize("dialect", ["fanuc", "linuxcnc"])
@pytest.mark.parametrize("end", ["M30\n%\n", "M30\n", "%\n"])
def test_comments_before_the_percent_that_begins_a_program(
    run: Any, head: str, dialect: str, end: str
) -> None:
    """Text in front of the first % is the leader of a tape (B-63324EN, 13.1): the program was passed over without a word."""
    if dialect == "linuxcnc" and "(A (" in head:
        pytest.skip("LinuxCNC has no comments in comments")
    out = run(f"{head}G0 X1\n{end}", dialect=dialect)
    assert points(out) == [[1, 0, 0]]


def test_a_percent_behind_blocks_ends_the_program(run: Any) -> None:
    assert points(run("(A)\nG0 X1\n%\nG0 X2\nM30\n", dialect="fanuc")) == [[1, 0, 0]]


def test_abbreviations_of_jumps_and_loops(run: Any) -> None:
    """WH, GO and EN (B-63324EN, 15.11)."""
    text = "#1=0\nWH[#1LT3]DO1\n#1=#1+1\nG0X#1\nEN1\nIF[#1EQ3]GO100\nG0X99\nN100 G0Y1\nGO 200\nX98\nN200 M30"
    assert fanuc(run, text) == [[1, 0, 0], [2, 0, 0], [3, 0, 0], [3, 1, 0]]


def test_an_offset_that_no_tool_has(run: Any, tmp_path: Any) -> None:
    """A control has all numbers of offsets: #10100 is one of them whatever the tool table holds."""
    table = tmp_path / "a.tbl"
    table.write_text("T1 P1 Z5\n")
    assert fanuc(run, "#10100=7.\nG0 X#10100\nM30", tool_table=table) == [[7, 0, 0]]


@pytest.mark.parametrize("dialect", ["fanuc", "linuxcnc"])
def test_blocks_behind_the_end_are_told_of(run: Any, dialect: str) -> None:
    """A % ends the reading, wherever it stands; what is behind it was passed over without a word."""
    out = run("%\nG0 X1\n%\n(A)\n\nG0 X2\nN5 G0 X3\nM30\n%\n", dialect=dialect)
    assert points(out) == [[1, 0, 0]]
    (said,) = [d for d in out.diagnostics if d.code == "text-behind-end"]
    assert (said.span.line, said.message.split()[0]) == (3, "3")
    assert not [
        d
        for d in run("%\nG0 X1\nM30\n%\n(A)\n\n%\n", dialect=dialect).diagnostics
        if d.code == "text-behind-end"
    ]


def test_the_leader_of_a_tape_is_passed_over(run: Any) -> None:
    out = run("\nSENT BY A PC\n%\nO1\nG0 X1\nM30\n%\n", dialect="fanuc")
    assert points(out) == [[1, 0, 0]]
    (said,) = [d for d in out.diagnostics if d.code == "text-before-start"]
    assert said.message.startswith("2 lines")
    # A number alone is the leader's, as some editors write it above the program.
    out = run("O0067 (THREAD)\n%\nG90\nG0 X1\nM30\n%\n", dialect="fanuc")
    assert points(out) == [[1, 0, 0]]
    # A program stands before the %, which ends it, and its subprogram behind.
    out = run("(PART)\nO3\nG0 X1\nM98 P4\nM30\n%\nO4\nG0 Y2\nM99\n%\n", dialect="fanuc")
    assert points(out) == [[1, 0, 0], [1, 2, 0]]
    # Two % at the end are no frame of a program.
    assert points(run("O1\nG0 X1\nM30\n%\n%\n", dialect="fanuc")) == [[1, 0, 0]]


def test_words_behind_the_number_of_a_program(run: Any) -> None:
    """They run with the program, from the text and from each call: O1000 G21 was refused, and N takes the place of O (B-63684EN, 13)."""
    text = "O0001 (PART) G20 G90 G0 X1\nM98 P2 L2\nG65 P3 A7.\nM30\nO0002 #1=#1+1 G91 G0 X2\nM99\nO0003 G90 X#1\nM99"
    assert np.round(points(run(text, dialect="fanuc")), 9).tolist() == [
        [25.4, 0, 0],
        [76.2, 0, 0],
        [127, 0, 0],
        [177.8, 0, 0],
    ]


def test_mitsubishi_ramps_a_skip(run: Any) -> None:
    """G31 R1 (M80 programming manual, "Skip function") moves as G31 does; R had no code."""
    out = run("O1\nG31 R1 X5 F100\nM30", dialect="fanuc")
    assert points(out) == [[5, 0, 0]]
    assert out.errors == []


def test_no_dynamic_fixture_offset(run: Any) -> None:
    assert fanuc(run, "G54.2 P0\nG0 X1\nM30") == [[1, 0, 0]]
    assert run("G54.2 P1\nM30", dialect="fanuc").errors == [("unknown-code", 1, 1)]


def test_heads_of_mach_and_tormach(run: Any) -> None:
    """G50, G15, G69 end what is never on; G70 and G71 without words are units: both are errors of LinuxCNC's own interpreter."""
    out = run("G90 G64 G50 G15 G69\nG70\nG0 X1\nG71\nG0 X1\nM2")
    assert points(out) == [[25.4, 0, 0], [1, 0, 0]]
    assert [d.code for d in out.diagnostics] == ["other-control"] * 2
    # Where LinuxCNC itself is asked for, `rs274` decides ("Unknown g code used"); `canon` refused it, and reading did not.
    assert run("G50\nM2", dialect="linuxcnc").errors == [("unknown-code", 1, 1)]
    assert run("G70\nM2", dialect="linuxcnc").errors == [("profile-missing", 1, 1)]


def test_heads_of_hurco(run: Any) -> None:
    """G70 and G71 of BNC programs are units, in a head that has G43 H; with a cycle in force or words they are Haas's patterns."""
    out = run("O5\nG0 G17 G40 G90 G70\nT1 M6\nG43 Z1. H1\nX1. Y0\nG71\nX2.\nM30")
    assert points(out)[-2:] == [[25.4, 0, 25.4], [2, 0, 25.4]]
    assert [d.code for d in out.diagnostics if d.code not in ("dialect", "no-tool-table")] == [
        "other-control"
    ] * 2
    assert run("G81 X1. Z-1. R1. F9.\nG70\nM30", dialect="fanuc").errors == [("cycle-words", 2, 1)]


def test_two_tools_before_m6_of_mazak(run: Any) -> None:
    """T1 T2 M6 changes to tool 1 and makes tool 2 ready (Mazak, EIA programming); without M6 two T are an error."""
    out = run("T1 T2 M6\nG0 X1\nM30", dialect="fanuc")
    assert points(out) == [[1, 0, 0]]
    assert [event.values["tool"] for event in out.path.events if event.name == "tool"] == [1]
    assert run("T1 T2\nM30", dialect="fanuc").errors == [("repeated-word", 1, 1)]
    assert run("T1 T2 M6\nM2", dialect="linuxcnc").errors == [("repeated-word", 1, 1)]


def test_labels_are_what_the_grammar_reads(run: Any) -> None:
    """Blanks within an N word, comments before it, and numbers that nobody can name: patterns of their own found other lines."""
    text = f"O1\nGOTO 20\nG0 X99\n/ N 2 0.5 G0 X1\nN{'9' * 6000} X2\n(N20) X3\nM30"
    out = run(text, dialect="fanuc")
    assert [code for code, *_ in out.errors] == []
    assert out.path.end[out.path.kind != 3, 0].tolist() == [2.0, 3.0]
