"""Words and planes that programs of shops have in Heidenhain's plain language, against what the manuals say of them (TNC 640, TNC 7)."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.gcode import read
from cncgen.machine.kinematics import Kinematics
from cncgen.toolpath.reading import ReadOptions

Run = Callable[..., Any]
DRILL = "CYCL DEF 200 DRILLING ~\n Q200=2 ~\n Q201=-5 ~\n Q206=100 ~\n Q202=5 ~\n Q210=0 ~\n Q203=+0 ~\n Q204=20 ~\n Q211=0\n"


def program(body: str) -> str:
    """Return a program in mm that does some lines."""
    return f"0 BEGIN PGM A MM\n{body}\nEND PGM A MM\n"


def ends(run: Run, body: str, **options: Any) -> list[list[float]]:
    """Return where the motions of some lines lead in X Y Z, after asserting that all went well."""
    out = run(program(body), dialect="heidenhain", **options)
    assert out.errors == []
    return (np.round(out.path.end[out.path.kind != 3, :3], 9) + 0.0).tolist()


def said(run: Run, body: str) -> list[tuple[str, str]]:
    """Return severity and code of what was said of some lines."""
    return [(d.severity.value, d.code) for d in run(program(body), dialect="heidenhain").diagnostics]


@pytest.mark.parametrize(
    "word", ["M90", "M118 X1 Y1", "M138 C", "M124 T0.01", "M112 T0.01 A10", "M120 LA5", "M138"]
)
def test_settings_of_the_control_change_no_motion(run: Run, word: str) -> None:
    assert ends(run, f"L X+5 FMAX {word}\nL Y+2 FMAX") == [[5, 0, 0], [5, 2, 0]]
    assert said(run, f"L X+5 FMAX {word}\nL Y+2 FMAX") == []


@pytest.mark.parametrize("word", ["M97", "M98"])
def test_corners_that_are_not_made_are_told_of(run: Run, word: str) -> None:
    """M98 was looked for as a call of a subprogram."""
    assert said(run, f"L X+5 FMAX {word}") == [("warning", "contour-function")]


def test_feeds_a_revolution(run: Run) -> None:
    """M136: F is mm a revolution, M137 mm a minute."""
    out = run(program("TOOL CALL 1 Z S1000\nM3\nM136\nL X+5 F0.2\nM137\nL X+10 F300"), dialect="heidenhain")
    assert out.errors == []
    feeds = out.path.feed[out.path.feed_mode == 0] * 60.0
    assert feeds.round(6).tolist() == [200.0, 300.0]


@pytest.mark.parametrize(
    "line",
    [
        'QS1 = "ABC"',
        "FN 19: PLC = +10 / +Q1",
        "FN 26: TABOPEN TNC:\\A.TAB",
        "FUNCTION DCM OFF",
        "FUNCTION PROG PATH IS CONTOUR",
    ],
)
def test_lines_that_move_nothing(run: Run, line: str) -> None:
    assert ends(run, f"{line}\nL X+5 FMAX") == [[5, 0, 0]]
    assert ends(run, f"LBL 1\n{line}\nL X+5 FMAX") == [[5, 0, 0]]


def test_a_tool_by_a_parameter(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "t.tbl"
    table.write_text("T7 P7 Z30 D10\n")
    assert ends(run, "Q1=7\nTOOL CALL Q1 Z S100\nL Z+1 FMAX", tool_table=table) == [[0, 0, 31]]


def test_a_datum_shift_by_steps_without_other_signs(run: Run) -> None:
    body = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\nCYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 IX+5\nCYCL DEF 7.2 IY-1\nL X+0 Y+0 FMAX"
    assert ends(run, body) == [[15, -1, 0]]


def test_factors_of_axes_about_a_centre(run: Run) -> None:
    """Cycle 26: 15 + 1.4 (0 - 15) = -6, 20 + 0.6 (0 - 20) = 8."""
    body = "CYCL DEF 26.0 AXIS SCALING\nCYCL DEF 26.1 X1.4 Y0.6 CCX+15 CCY+20\nL X+0 Y+0 FMAX\nCYCL DEF 26.0\nCYCL DEF 26.1 X1 Y1\nL X+3 Y+0 FMAX"
    assert ends(run, body) == [[-6, 8, 0], [3, 0, 0]]
    assert ("error", "scale-missing") in said(run, "CYCL DEF 26.0\nCYCL DEF 26.1 X0\nL X+0 FMAX")


@pytest.mark.parametrize(
    ("line", "end", "expected"),
    [
        ("TRANS DATUM AXIS X+10 Y-2", "TRANS DATUM RESET", [14, 1, 0]),
        ("TRANS MIRROR AXIS X", "TRANS MIRROR RESET", [-4, 3, 0]),
        ("TRANS ROTATION ROT+90", "TRANS ROTATION RESET", [-3, 4, 0]),
        ("TRANS SCALE SCL0.5", "TRANS SCALE RESET", [2, 1.5, 0]),
    ],
)
def test_frames_of_tnc_7(run: Run, line: str, end: str, expected: list[float]) -> None:
    assert ends(run, f"{line}\nL X+4 Y+3 FMAX\n{end}\nL X+4 Y+3 FMAX") == [expected, [4, 3, 0]]


def turned(axis: str, degrees: float, vector: list[float]) -> list[float]:
    """Return a vector turned about an axis, by the textbook's formula."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    x, y, z = vector
    return {
        "X": [x, c * y - s * z, s * y + c * z],
        "Y": [c * x + s * z, y, c * z - s * x],
        "Z": [c * x - s * y, s * x + c * y, z],
    }[axis]


def test_planes_by_euler_angles(run: Run) -> None:
    """Precession about Z, nutation about the new X, rotation about the new Z: the last turn acts on a point first."""
    found = ends(run, "PLANE EULER EULPR45 EULNU20 EULROT22 STAY\nL X+1 Y+2 Z+3 FMAX")[-1]
    assert np.allclose(found, turned("Z", 45, turned("X", 20, turned("Z", 22, [1, 2, 3]))))


def test_planes_that_turn_the_plane_in_force(run: Run) -> None:
    """PLANE RELATIV turns about the axes of the tilted plane, those of SPATIAL about the machine's."""
    found = ends(
        run, "PLANE SPATIAL SPA+30 SPB+0 SPC+20 STAY\nPLANE RELATIV SPB-45 STAY\nL X+1 Y+2 Z+3 FMAX"
    )[-1]
    assert np.allclose(found, turned("Z", 20, turned("X", 30, turned("Y", -45, [1, 2, 3]))))


def test_planes_by_three_points(run: Run) -> None:
    """X leads along (1, 0, 1), Y stays: the plane stands at 45 degrees about Y, and the origin stays."""
    points = "PLANE POINTS P1X+5 P1Y+0 P1Z+0 P2X+6 P2Y+0 P2Z+1 P3X+5 P3Y+9 P3Z+0 STAY"
    found = ends(run, f"{points}\nL X+1 Y+2 Z+3 FMAX\nPLANE RESET STAY\nL X+1 Y+2 Z+3 FMAX")
    assert np.allclose(found[0], turned("Y", -45, [1, 2, 3]))
    assert found[1] == [1, 2, 3]
    assert ("error", "plane-points") in said(run, "PLANE POINTS P1X+0 P2X+1 P3X+2 STAY\nL X+1 FMAX")


def test_points_of_a_table(tmp_path: Path) -> None:
    (tmp_path / "HOLES.PNT").write_text(
        "BEGIN HOLES .PNT MM\nNR X Y Z\n0 +10 +20 +0\n1 +30,5 +20 -1\n[END]\n"
    )
    path = tmp_path / "a.h"
    path.write_text(
        program(
            f'L Z+20 R0 FMAX\nSEL PATTERN "TNC:\\\\P\\\\holes.pnt"\n{DRILL}CYCL CALL PAT FMAX'.replace(
                "\\\\", "\\"
            )
        )
    )
    found = read(path, "a.h", ReadOptions(dialect="heidenhain"))
    rows = np.concatenate([chunk.end[chunk.kind != 3, :3] for chunk in found.chunks()])
    assert [d.code for d in found.diagnostics if d.severity == "error"] == []
    assert [row for row in rows.tolist() if row[2] < -4.0] == [[10, 20, -5], [30.5, 20, -6]]


TABLES = Kinematics(0, (3, 5), (0.0, 0.0, -100.0))


@pytest.mark.parametrize("words", ["REFPNT TIP-CENTER", "AXIS POS REFPNT CENTER-CENTER"])
def test_tcpm_of_the_centre_of_the_tool_is_refused(run: Run, words: str) -> None:
    """Points of the ball's centre were read as those of the tip without a word."""
    out = run(program(f"FUNCTION TCPM F TCP {words}"), dialect="heidenhain", kinematics=TABLES)
    assert [code for code, *_ in out.errors] == ["unsupported-block"]
    assert said(run, "FUNCTION TCPM F CONT REFPNT TIP-TIP")[0] == ("warning", "feed-function")


@pytest.mark.parametrize(
    ("begin", "end"),
    [
        ("M128", "M129"),
        ("L M128 F1000", "L M129"),
        ("FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS", "FUNCTION RESET TCPM"),
    ],
)
def test_the_tip_stays_on_the_workpiece(run: Run, tmp_path: Path, begin: str, end: str) -> None:
    """As G43.4: at C90 the point (10, 0) of the table is at (0, -10); M129 leaves the machine where it is, the length in force."""
    table = tmp_path / "t.tbl"
    table.write_text("T1 P1 Z50 D10\n")
    body = f"TOOL CALL 1 Z S100\nL X+10 Y+0 Z+0 FMAX\n{begin}\nL C+90 FMAX\nL X+20 FMAX\n{end}\nL Z+5 FMAX"
    out = run(program(body), dialect="heidenhain", kinematics=TABLES, tool_table=table)
    assert out.errors == []
    found = out.path.end[out.path.kind != 3]
    np.testing.assert_allclose(
        found[:, :3], [[10, 0, 50], [0, -10, 50], [0, -20, 50], [0, -20, 55]], atol=1e-9
    )
    assert out.moving_axes == "XYZC"


def test_without_kinematics_the_tip_goes_where_the_program_says(run: Run) -> None:
    text = program("TOOL CALL 1 Z S100\nM128\nL X+10 C+90 F100\nM129\nL Z+5 FMAX")
    assert run(text, dialect="heidenhain").errors[0][0] == "tcp-machine"
    out = run(text, dialect="heidenhain", tips_alone=True)
    assert out.errors == []
    assert [(d.code, d.severity) for d in out.diagnostics if d.code.startswith("tcp")] == [
        ("tcp-machine", "warning")
    ]
    assert out.path.end[out.path.kind != 3][:, [0, 2]].tolist() == [[10.0, 0.0], [10.0, 5.0]]


def test_a_comment_goes_on_behind_a_tilde(run: Run) -> None:
    """Behind words, too, as TNCs wrap a long one; a parameter of a cycle is none of it."""
    body = "1 Q1 = 5 + 1 ; the half of a key~\n width minus the cutter's)\n2 L X+Q1 F100 ;to it~\n - as said\n3 L Y+2"
    assert ends(run, body) == [[6, 0, 0], [6, 2, 0]]
    cycle = DRILL.replace("Q200=2 ~", "Q200=2 ;CLEARANCE ~").replace("Q201=-5 ~", "Q201=-5 ;DEPTH ~")
    assert ends(run, f"{cycle}\nL X+1 FMAX M99")[1:3] == [[1, 0, 2], [1, 0, -5]]


def test_words_of_a_block_in_lines_of_their_own(run: Run) -> None:
    """TNC 145 to 155 put them so; an indented block of a program without numbers is one of its own."""
    body = "1 TOOL DEF 1 L+0,000\n            R+5,000\n2 TOOL CALL 1 Z\n               S 1000\n3 L X+10,000 Y+20,000\n            R0 F900 M03\n4 L\n            Z+1"
    out = run(program(body), dialect="heidenhain")
    assert out.errors == []
    rows = out.path.kind != 3
    assert (out.path.end[rows, :3].tolist(), (out.path.feed[rows] * 60.0).tolist()) == (
        [[10, 20, 0], [10, 20, 1]],
        [900, 900],
    )
    assert ends(run, "L X+5 FMAX\n    L Y+5 FMAX") == [[5, 0, 0], [5, 5, 0]]


def test_an_increment_behind_appr_counts_from_the_contour(moves: Callable[..., Any]) -> None:
    """It counted from where the tool stood before: the way on was square to (-1, -1), though the first element leads to (1, 1)."""
    head = "0 BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X-10 Y-10 FMAX M3\nAPPR LT X+5 Y+5 LEN2 RL F100\n"
    tail = "L X+50 Y+90\nDEP LT LEN2\nEND PGM A MM\n"
    assert moves(f"{head}L IX+10 IY+10\n{tail}") == moves(f"{head}L X+15 Y+15\n{tail}")


def test_a_dwell_by_its_function(run: Run) -> None:
    """FUNCTION DWELL in seconds, and in revolutions of a spindle that makes 10 a second."""
    out = run(
        program("TOOL CALL 1 Z S600\nFUNCTION DWELL TIME0.5\nFUNCTION DWELL REV 5\nL X+1 F100"),
        dialect="heidenhain",
    )
    assert out.errors == []
    assert [event.values["seconds"] for event in out.path.events if event.name == "dwell"] == [0.5, 0.5]
    assert said(run, "FUNCTION DWELL REV 5\nL X+1 F100")[0] == ("error", "spindle-stopped")
    assert said(run, "FUNCTION FEED DWELL D-TIME0.5 F-TIME5\nL X+1 F100")[0] == ("warning", "feed-function")


def test_global_values_of_cycles(run: Run) -> None:
    """GLOBAL DEF gives what PREDEF takes (TNC 640): the set-up clearance 3 and the second one 30."""
    define = "GLOBAL DEF 100 GENERAL ~\n Q200=+3 ;SET-UP CLEARANCE ~\n Q204=+30 ~\n Q253=+750 ~\n Q208=MAX\n"
    cycle = DRILL.replace("Q200=2", "Q200= PREDEF").replace("Q204=20", "Q204= PREDEF")
    assert ends(run, f"{define}{cycle}\nL X+1 FMAX M99") == [[1, 0, 0], [1, 0, 3], [1, 0, -5], [1, 0, 30]]
    assert said(run, f"{cycle}\nL X+1 FMAX M99")[0] == ("error", "cycle-words")


@pytest.mark.parametrize(
    "word",
    [
        "COUNT INC",
        'FILE COPY "A" TO "B"',
        "LIFTOFF TCS X+0 Y+0.5 Z+0.5",
        "PARAXCOMP DISPLAY W",
        "PARAXMODE OFF",
    ],
)
def test_functions_that_move_nothing(run: Run, word: str) -> None:
    assert ends(run, f"FUNCTION {word}\nL X+5 FMAX") == [[5, 0, 0]]


def test_a_plane_names_the_axes_that_it_turns_into(run: Run) -> None:
    """Under PLANE AXIAL the lines in X and Y had no column of Z, which they move."""
    out = run(program("PLANE AXIAL B-45 STAY\nL X+10 Y+5 F100"), dialect="heidenhain")
    assert out.errors == []
    assert out.moving_axes[:3] == "XYZ"


def test_a_formula_goes_on_behind_a_tilde(run: Run) -> None:
    """As TNCs wrap a long one; a block that follows a ~ by mistake is a block."""
    assert ends(run, "1 Q1 = 5 + ( 2 * ~\n    SIN ( 90 ) ) + ~\n    1\n2 L X+Q1 F100") == [[8, 0, 0]]
    assert ends(run, "1 Q1 = 5 ~\n2 L X+Q1 F100") == [[5, 0, 0]]
    assert ends(run, "Q1 = 5 ~\nL X+Q1 F100") == [[5, 0, 0]]


def test_words_without_a_value_change_nothing(run: Run) -> None:
    """R, F and M alone, as TNC 355 and posts for it write them."""
    assert ends(run, "L X+5 R F500 M3\nL Y+2 R F M\nCYCL DEF 7.1 X+1\nL X+5 R FMAX M") == [
        [5, 0, 0],
        [5, 2, 0],
        [6, 2, 0],
    ]


def test_oversizes_alone_are_those_of_the_tool_in_the_spindle(run: Run, tmp_path: Path) -> None:
    """TOOL CALL DL-1 was passed over in silence. The tool is 10 long and 6 wide."""
    table = tmp_path / "t.tbl"
    table.write_text("T5 P5 Z10 D6\n")
    body = "TOOL CALL 5 Z S500\nL Z+10 FMAX\nTOOL CALL DL-1 DR+0.5\nL Z+11 FMAX\nL X+Q108 Y+Q114 FMAX\nTOOL CALL 5 Z S500\nL Z+10 FMAX"
    assert ends(run, body, tool_table=table) == [[0, 0, 20], [3.5, 9, 20]]


@pytest.mark.parametrize("repeat", ["REP", "REP /", ""])
def test_a_call_without_repeats_is_of_a_subprogram(run: Run, repeat: str) -> None:
    """TNC 155 and 355 write REP where nothing is repeated."""
    assert ends(run, f"LBL 1\nL IX+1 FMAX\nLBL 0\nCALL LBL 1 {repeat} \nL Y+5 FMAX") == [
        [1, 0, 0],
        [2, 0, 0],
        [2, 5, 0],
    ]


def test_a_tool_that_no_table_gives_goes_between_the_walls(run: Run) -> None:
    """A pocket of 100 by 100 with an island 20 wide, 8 off its wall: a tool of 10 mm would not go between them, one of 8 does."""
    data = "CYCL DEF 20 DATA ~\n Q1=-2 ~\n Q2=1 ~\n Q3=0 ~\n Q4=0 ~\n Q5=0 ~\n Q6=2 ~\n Q7=10 ~\n Q8=0 ~\n Q9=1\n"
    side = (
        "CYCL DEF 24 SIDE ~\n Q9=1 ~\n Q10=-5 ~\n Q11=100 ~\n Q12=500 ~\n Q14=0\nCYCL CALL\nL Z+50 FMAX M2\n"
    )
    pocket = "LBL 1\nL X+0 Y+0 RL\nL X+100\nL Y+100\nL X+0\nL Y+0\nLBL 0\n"
    island = "LBL 2\nL X+8 Y+40 RR\nL X+28\nL Y+60\nL X+8\nL Y+40\nLBL 0\n"
    body = f"TOOL CALL 1 Z S500\nM3\nCYCL DEF 14.0\nCYCL DEF 14.1 LABEL 1 /2\n{data}{side}{pocket}{island}"
    out = run(program(body), dialect="heidenhain")
    assert out.errors == []
    (told,) = [d.message for d in out.diagnostics if d.code == "tool-assumed"]
    width = float(told.split("for a tool ")[1].split()[0])
    assert 4.0 <= width <= 8.0


def test_blocks_of_a_simulator_have_numbers_with_n(run: Run) -> None:
    """As those of KELLER and MTS, between remarks in parentheses."""
    text = (
        '(   Programmer: "S W"\n(\nBEGIN PGM 04 MM\nN1 BLK FORM 0.1 Z X0 Y0 Z120\nN2 TOOL CALL 1 Z S2000 F200\nN3 L X-40 Y-40 Z1 FMAX M13\n'
        "N4 LBL 1\nN5 L IX+10 F AUTO\nN6 CALL LBL 1 REP 1\nN7 L Z1 R0 FMAX\nN8 END PGM 04 MM\n"
    )
    out = run(text)
    assert out.errors == []
    assert out.path.end[out.path.kind != 3, :3].tolist() == [[-40, -40, 1], [-30, -40, 1], [-20, -40, 1]]


def test_a_block_that_begins_with_an_axis_goes_along_it(run: Run) -> None:
    assert ends(run, "1 X+15 R0 F100\n2 IY-3 FMAX M3\n3 X+Q1 F50") == [[15, 0, 0], [15, -3, 0], [0, -3, 0]]
    assert said(run, "1 X+15 Y+3 R0 F100")[0] == ("error", "unsupported-block")


def test_a_smaller_feed_downwards(run: Run, moves: Callable[..., Any]) -> None:
    """The manual's example of M103: 500 along, 20 % of it straight down, root 2 of that at 45 degrees, 500 upwards; M103 alone ends it."""
    body = "L X+20 Y+20 R0 F500 M103 F20\nL Y+50\nL IZ-2.5\nL IY+5 IZ-5\nL IX+50\nL Z+5\nL IX+1 M103\nL IZ-1"
    feeds = [feed for *_, feed in moves(program(body))]
    assert feeds == pytest.approx([500, 500, 100, 100 * math.sqrt(2), 500, 500, 500, 500], abs=1e-5)
    helix = "L X+1 F500 M103 F20\nCC X+5 Y+0\nCP IPA+90 IZ-1 DR+"
    assert said(run, helix) == [("warning", "feed-function")]


DATUMS = "BEGIN A.D MM\nNR X Y Z A B C DOC\n0 +0 +0 +0 +0 +0 +0 ORIGIN\n5 +100,5 -20 +3 +0 +0 +0 VICE 2\n6 +1 +0 +0 +0 +0 +45\n[END]\n"


def of_file(folder: Path, body: str) -> tuple[list[list[float]], list[str]]:
    """Return the ends of the motions of a program beside a table of datums, and the codes of its errors."""
    (folder / "A.D").write_text(DATUMS)
    path = folder / "a.h"
    path.write_text(program(body))
    found = read(path, "a.h", ReadOptions(dialect="heidenhain"))
    rows = [chunk.end[chunk.kind != 3, :3] for chunk in found.chunks()]
    codes = [d.code for d in found.diagnostics if d.severity == "error"]
    return (np.concatenate(rows).tolist() if rows else []), codes


def test_datums_of_a_table(tmp_path: Path) -> None:
    """#5 and TABLINE5 take X Y Z of row 5 of the table that SEL TABLE names, a Q parameter may be its number; #0 ends it."""
    lines = [
        'SEL TABLE "TNC:\\PROJ\\A.D"',
        "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 #5\nL X+1 Y+2 Z+3 FMAX",
        "CYCL DEF 7.0\nCYCL DEF 7.1 #0\nL X+1 Y+2 FMAX",
        "Q9 = 5\nCYCL DEF 7.0\nCYCL DEF 7.1 #Q9\nL X+2 Y+2 FMAX",
        "TRANS DATUM RESET\nTRANS DATUM TABLE TABLINE5\nL X+3 FMAX",
    ]
    places, codes = of_file(tmp_path, "\n".join(lines))
    assert codes == []
    assert places == [[101.5, -18, 6], [1, 2, 6], [102.5, -18, 6], [103.5, -18, 6]]


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("CYCL DEF 7.1 #5", "datum-missing"),
        ('SEL TABLE "A.D"\nCYCL DEF 7.1 #7', "datum-missing"),
        ('SEL TABLE "A.D"\nCYCL DEF 7.1 #6', "not-read"),
        ('SEL TABLE "B.D"', "sub-missing"),
    ],
)
def test_datums_that_are_not_there(tmp_path: Path, body: str, code: str) -> None:
    assert of_file(tmp_path, f"{body}\nL X+1 FMAX")[1] == [code]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        # A preset ends the datum shift, mirroring, rotation and factors (iTNC 530, "Datum setting (cycle 247)").
        ("CYCL DEF 7.0 DATUM\nCYCL DEF 7.1 IX-60\nL X+0 Y+1 FMAX\nCYCL DEF 247 PRESET ~\n Q339=+1\nCYCL DEF 7.0 DATUM\nCYCL DEF 7.1 IX+60\nL X+0 FMAX",
         [[-60, 1, 0], [60, 1, 0]]),
        ("CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1 X\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+90\nCYCL DEF 247 PRESET ~\n Q339=+1\nL X+5 Y+1 FMAX", [[5, 1, 0]]),
        ("CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+45\nCYCL DEF 247 PRESET ~\n Q339=+1\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 IROT+90\nL X+5 FMAX",
         [[0, 5, 0]]),
        # A block that begins behind a comment that ends in ~ is run, as posts write their heads; so is one without a number.
        ("1 ;MCX FILE -~\n2 L X+10 FMAX", [[10, 0, 0]]),
        ("1 * - PART ~\n2 L X+10 FMAX", [[10, 0, 0]]),
        (";HEAD ~\nL X+10 FMAX", [[10, 0, 0]]),
        (f"{DRILL.rstrip()} ;DWELL ~\nL X+10 FMAX", [[10, 0, 0]]),
        # The text of a comment goes on below it.
        ("1 ;HEAD ~\n    L X+99 IS NOT RUN\n2 L X+10 FMAX", [[10, 0, 0]]),
        # A remark that ends in * makes no program of DIN/ISO of numbers with N.
        ("N1 L X+10 FMAX\nN2 ; * PART *\nN3 * - PART *\nN4 L Y+5 FMAX", [[10, 0, 0], [10, 5, 0]]),
        # Words go on behind ~, however far in they stand.
        ("1 L X+10 ~\n  Y+5 ~\nFMAX", [[10, 5, 0]]),
    ],
)  # fmt: skip
def test_presets_and_blocks_that_go_on(run: Run, body: str, expected: list[list[float]]) -> None:
    assert ends(run, body) == expected


@pytest.mark.parametrize(
    "body",
    [
        "L X+5 F200 FMAX",
        "L X+5 FMAX F200",
        "L X+Q1 FMAX R0 F200",
        "L X+5 RL R0",
        "L X+5 R0 RR F100",
        "L X+5 FMAX FAUTO",
    ],
)
def test_a_block_with_two_feeds_or_two_sides_is_refused(run: Run, body: str) -> None:
    """The control takes one of them a block: a traverse at F200 would have been one at full speed."""
    assert said(run, f"Q1 = 3\nTOOL CALL 1 Z S100 F100\nL Z+5 FMAX\n{body}")[-1] == ("error", "repeated-word")


def test_a_cycle_that_is_not_read_is_named_once(run: Run) -> None:
    """Each call of it was a fault of its own: no cycle to call."""
    out = run(
        program(
            "CYCL DEF 276 KONTURZUG 3D ~\n Q513=10\nL X+1 FMAX M99\nL X+2 FMAX M99\nCYCL DEF 239 LOAD ~\n Q570=+0"
        ),
        dialect="heidenhain",
    )
    assert [(d.code, d.message) for d in out.diagnostics if d.code != "no-tool-table"] == [
        ("unsupported-block", "cycle 276 (a contour train in space) is not read"),
        ("cycle-idle", "cycle 239 moves no tool: passed over"),
    ]


@pytest.mark.parametrize("end", ["STOP M30", "STOP M9 M2", "M0 M30"])
def test_a_stop_in_the_last_block(calls: Run, end: str) -> None:
    """Posts of shops end with STOP M30: it was refused, as two M functions of one group."""
    found = calls(program(f"L X+5 FMAX\n{end}\nL X+9 FMAX"), dialect="heidenhain")
    assert [call for call in found if call.startswith(("PROGRAM_", "STRAIGHT"))] == [
        "STRAIGHT_TRAVERSE(5.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)",
        "PROGRAM_STOP()",
        "PROGRAM_END()",
    ]


def test_repeats_that_a_parameter_counts(run: Run) -> None:
    """REP Q3/Q3 is how an iTNC 530 writes repeats by a parameter (WALLX20X20.H of a shop was refused)."""
    assert ends(run, "Q3 = 2\nLBL 1\nL IX+1 FMAX\nCALL LBL 1 REP Q3/Q3") == [[1, 0, 0], [2, 0, 0], [3, 0, 0]]


def test_a_program_asks_where_the_travel_ends(run: Run) -> None:
    """ID230 is the "Traverse range", NR2 the negative and NR3 the positive limit switch, IDX the axis (TNC 640, "System data").

    Programs of shops retract by it, and posts begin with ``FN 18: SYSREAD Q30 = ID230 NR3 IDX3`` and ``L ZQ30 R0 FMAX M91``.
    """
    body = "L X+1 Z-7 FMAX\nFN 18: SYSREAD Q30 = ID230 NR3 IDX3\nFN 18: SYSREAD Q31 = ID230 NR2 IDX3\nL ZQ30 R0 FMAX M91\nL Z+Q31 R0 FMAX M91"
    known = ends(run, body, travel=(("X", -5.0, 5.0), ("Z", -500.0, 12.5)))
    assert known == [[1, 0, -7], [1, 0, 12.5], [1, 0, -500]]
    # Where the machine has no bounds, the way there is none, as with M140 MB MAX.
    assert ends(run, body) == [[1, 0, -7]]
    assert said(run, body) == [("warning", "travel-unknown")]


COLUMN = [("warning", "variable-assumed")]


@pytest.mark.parametrize(
    ("lines", "expected", "told"),
    [
        ("FN 18: SYSREAD Q1 = ID50 NR19 IDX1", [0, 0], COLUMN),
        ("FN 18: SYSREAD Q1 = ID20 NR11", [0, 0], []),
        ("FN 17: SYSWRITE ID50 NR1 IDX1 = +12.5\nFN 18: SYSREAD Q1 = ID50 NR1 IDX1", [12.5, 0], []),
        ("FN 17: SYSWRITE ID50 NR2 IDX1 = +4\nFN 18: SYSREAD Q2 = ID50 NR2 IDX1", [0, 4], []),
        (
            'FN 17: SYSWRITE ID50 NR0 IDX1 = ""\nFN 17: SYSWRITE ID50 NR4 IDX1 = +0',
            [0, 0],
            [*COLUMN, *COLUMN],
        ),
        ("FN 17: SYSWRITE ID50 NR36 IDX Q1 = +Q1", [0, 0], COLUMN),
    ],
)
def test_columns_of_the_tool_table(
    run: Run, lines: str, expected: list[float], told: list[tuple[str, str]]
) -> None:
    """Numbers of columns as a shop's TOOL-TABLE-CLEANUP.H for TNC 640 names them: NR1 L, NR2 R, NR4 DL, NR19 R-OFFS, NR36 the kind."""
    body = f"TOOL CALL 2 Z S1000\nQ1 = 0\nQ2 = 0\n{lines}\nL X+Q1 Y+Q2 Z+1 FMAX"
    assert ends(run, body)[-1][:2] == expected
    assert [told for told in said(run, body) if told[0] != "note"] == told


def test_dl_is_not_of_the_tool_table(run: Run) -> None:
    body = "TOOL DEF 1 L+10 R+2\nTOOL CALL 1 Z S1000 DL+1 DR+1\nFN 18: SYSREAD Q1 = ID50 NR1 IDX1\nFN 18: SYSREAD Q2 = ID50 NR2 IDX1\nL X+Q1 Y+Q2 FMAX"
    assert ends(run, body)[-1][:2] == [10, 2]


@pytest.mark.parametrize("line", ["ID50 NR5 IDX1 = +0.1", "ID503 NR1 IDX1 = +10"])
def test_what_fn_17_may_move_is_refused(run: Run, line: str) -> None:
    assert ("error", "unsupported-block") in said(run, f"FN 17: SYSWRITE {line}")


ENGRAVE = "CYCL DEF 225 ENGRAVING ~\n QS500={text} ;TEXT ~\n Q513=12 ~\n Q514={gap} ~\n Q515=0 ~\n Q516={arc} ~\n Q374={turn} ~\n Q517=0 ~\n Q207=500 ~\n"
ENGRAVE += " Q201=-0.5 ~\n Q206=150 ~\n Q200=2 ~\n Q203=1 ~\n Q204=20\nL X+5 Y+7 R0 FMAX M3 M99"


@pytest.mark.parametrize(
    ("gap", "turn", "along"),
    [(0, 0, (5 + 4, 7)), (1, 0, (5 + 4, 7)), (2, 0, (5 + 8, 7)), (0, 90, (5, 7 + 4))],
)
def test_text_is_engraved(run: Run, gap: float, turn: float, along: tuple[float, float]) -> None:
    """225 (TNC 320, "ENGRAVING"): letters as high as Q513 from the tool's place on, turned by Q374, Q201 below the surface Q203, the gap times
    Q514. I is a stroke of no width; our gap is a third of the height."""
    body = "TOOL DEF 1 L+0 R+1\nTOOL CALL 1 Z S1000\n" + ENGRAVE.format(
        text='"II"', gap=gap, arc=0, turn=turn
    )
    found = ends(run, body)
    x, y = along
    up = (0, 12) if turn == 0 else (-12, 0)
    assert found == [
        [5, 7, 0], [5, 7, 3], [5, 7, 0.5], [5 + up[0], 7 + up[1], 0.5], [5 + up[0], 7 + up[1], 3],
        [x, y, 3], [x, y, 0.5], [x + up[0], y + up[1], 0.5], [x + up[0], y + up[1], 21],
    ]  # fmt: skip
    assert said(run, body) == [("warning", "engraving-letters")]


def test_text_of_newer_controls_is_cut_in_infeeds_and_begins_where_it_is_read(run: Run) -> None:
    """Q202, Q367 and Q574 were passed over: 0.5 deep in infeeds of 0.3; a text of 4 that the control would make no longer than 3; its middle."""
    head, text = (
        "TOOL DEF 1 L+0 R+1\nTOOL CALL 1 Z S1000\n",
        ENGRAVE.format(text='"II"', gap=0, arc=0, turn=0),
    )
    body = head + text.replace("Q204=20", "Q204=20 ~\n Q202=0.3 ~\n Q367={place} ~\n Q574=3")
    found = ends(run, body.format(place=1))
    assert [z for _, _, z in found if z < 3] == [0, *[0.7] * 4, *[0.5] * 4]
    (warning,) = run(program(body.format(place=0)), dialect="heidenhain").diagnostics
    assert "no longer than Q574 = 3" in warning.message
    assert ("error", "unsupported-block") in said(run, body.format(place=5))


@pytest.mark.parametrize(("text", "arc"), [('"A"', 1), ('"%time0"', 0), ("QS1 || QS2", 0)])
def test_text_that_is_not_known_is_not_engraved(run: Run, text: str, arc: int) -> None:
    assert ("error", "unsupported-block") in said(run, ENGRAVE.format(text=text, gap=0, arc=arc, turn=0))


@pytest.mark.parametrize(
    ("oversize", "told"), [("DR-2.5", ["tool-oversize"]), ("DL-1.8", []), ("DR+0.5", [])]
)
def test_oversizes_of_a_tool_that_nothing_gives_are_told(run: Run, oversize: str, told: list[str]) -> None:
    """The radius was DR alone, below 0, and RL led to the wrong side without a word."""
    found = said(run, f"TOOL CALL 31 Z S3000 {oversize}\nL X-1 Y-26 RL F1000\nL X+26 Y+1\nL X-12 Y+12 R0")
    assert [code for _, code in found if code.startswith(("no-tool", "tool"))] == ["no-tool-table", *told]


def test_titles_and_names_are_no_axes(tmp_path: Path) -> None:
    """A and W of a heading, a file or a tool's name had columns in the setpoints."""
    (tmp_path / "B 5.H").write_text("0 BEGIN PGM B MM\nL Y+1 FMAX\nEND PGM B MM\n")
    lines = '* - W 9 VHM\n3 * - A 12\nFN 16: F-PRINT TNC:\\A 5\nTOOL CALL "C 4" Z S100\nCALL PGM TNC:\\B 5.H\nCYCL DEF 32.0 TOLERANCE U 2\nCYCL DEF 32.1 T0.05\nL X+1 FMAX'
    path = tmp_path / "main.h"
    path.write_text(program(lines))
    out = read(path, path.name)
    assert sum(len(chunk) for chunk in out.chunks()) > 0
    assert out.axes == "XYZ"


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ("CALL LBL 5 REP 2\nL X+10\nLBL 5\nL IX+1", ["repeat-ahead"]),
        ("CALL LBL 5 REP 0\nL X+10\nLBL 5\nL IX+1", []),
        ("LBL 5\nL IX+1\nCALL LBL 5 REP 2", []),
    ],
)
def test_repeat_of_a_label_below_is_told(run: Run, lines: str, told: list[str]) -> None:
    """The lines between call and label were left out without a word."""
    found = [code for _, code in said(run, f"TOOL CALL 1 Z S1000\nL X+0 Y+0 R0 F500\n{lines}")]
    assert [code for code in found if code == "repeat-ahead"] == told


@pytest.mark.parametrize(
    ("times", "end", "told"), [("2.4", 3, 1), ("2.6", 4, 1), ("3", 4, 0), ("0.3 * 10", 4, 0)]
)
def test_repeats_that_are_not_whole_are_told(run: Run, times: str, end: int, told: int) -> None:
    """Q9 = Q1 / Q2 of a groove that goes down in turns was 35.5: 36 were run without a word."""
    text = f"TOOL CALL 1 Z S1000\nL X+0 Y+0 R0 FMAX\nQ9 = {times}\nLBL 1\nL IX+1 FMAX\nCALL LBL 1 REP Q9"
    assert ends(run, text)[-1][0] == end
    assert [code for _, code in said(run, text)].count("repeat-not-whole") == told


def test_points_of_a_pattern_by_steps(run: Run) -> None:
    """TNC 640, "Defining individual machining positions": POS2 (X+15 IY+6.5) lies 6.5 above the point before."""
    text = (
        "PATTERN DEF POS1 (X+25 Y+33.5 Z+0) POS2 (X+15 IY+6.5 Z+0) POS3 (IX-5 IY-10 Z+0)\n"
        "CYCL DEF 240 Q200=2 Q343=0 Q201=-2 Q344=0 Q206=100 Q211=0 Q203=+0 Q204=20\nCYCL CALL PAT FMAX M3\n"
    )
    assert [place[:2] for place in ends(run, text) if place[2] == -2] == [[25, 33.5], [15, 40], [10, 30]]
    assert said(run, "PATTERN DEF POS1 (X+25 IY+3)\n")[0] == ("error", "unsupported-block")


@pytest.mark.parametrize(
    ("lines", "code"),
    [
        ("CC X+1 Y+2 F500", "syntax"),
        ("CC X+1 Y+2 FAUTO", "syntax"),
        ("TOOL DEF 5 X5", "syntax"),
        ("TOOL DEF 5 L+10 R+3 F100", "syntax"),
        ("CYCL DEF 9.0 DWELL\nCYCL DEF 9.1 DWELL 1.5 X5", "not-read"),
        ("CYCL DEF 9.0 DWELL\nCYCL DEF 9.1 X5", "not-read"),
        ("CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.05 X5", "not-read"),
        ("CYCL DEF 19.0 PLANE\nCYCL DEF 19.1 A+0 B+30 C+0 X5", "not-read"),
        ("CYCL DEF 19.0 PLANE\nCYCL DEF 19.1 IB+30", "not-read"),
        ("PLANE AXIAL IB+30 STAY", "not-read"),
        ("PLANE SPATIAL SPA+30 SPB+0 SPC+0 X+5 STAY", "not-read"),
    ],
)
@pytest.mark.parametrize("flow", ["", "LBL 1\n"])
def test_words_that_a_block_does_not_have(run: Run, flow: str, lines: str, code: str) -> None:
    """They were passed over in silence; a step IB was taken for no angle."""
    assert ("error", code) in said(run, f"{flow}TOOL CALL 1 Z S100 F100\n{lines}\nL X+1 FMAX")


@pytest.mark.parametrize(
    ("lines", "code"),
    [
        ("PLANE SPATIAL SPA+30 SPB+0 SPC+0 STAY XYZ5", "not-read"),
        ("CYCL DEF 19.0 PLANE\nCYCL DEF 19.1 A+30 B+0 C+0 ODST50", "not-read"),
        ("CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.05 XYZ5", "not-read"),
        ("CYCL DEF 247 DATUM SETTING ~\n Q339=+1 ~\n Q777=+3", "cycle-parameters"),
        ("CYCL DEF 247 DATUM SETTING", "cycle-parameters"),
    ],
)
def test_words_of_no_known_meaning_are_told(run: Run, lines: str, code: str) -> None:
    """Names of values may be those of another language of the control (ABST and DIST are one word): they warn."""
    assert ("warning", code) in said(run, f"{lines}\nL X+1 FMAX")


@pytest.mark.parametrize(
    "lines",
    [
        "CYCL DEF 9.0 VERWEILZEIT\nCYCL DEF 9.1 V.ZEIT 1.5",
        "CYCL DEF 32.0 TOLERANZ\nCYCL DEF 32.1 T0.05\nCYCL DEF 32.2 HSC-MODE:1 TA0.5",
        "PLANE RESET TURN MB MAX FMAX",
        "PLANE SPATIAL SPA+0 SPB+0 SPC+0 TURN MB50 F2000 SEQ- COORD ROT",
        "PLANE SPATIAL SPA+0 SPB+0 SPC+0 MOVE ABST50 F MAX SYM+ TABLE ROT",
        "CYCL DEF 247 DATUM SETTING ~\n Q339=+1",
        "TOOL DEF 5",
        "CC IX+5 IY+0",
    ],
)
def test_words_that_are_known_are_not_told(run: Run, lines: str) -> None:
    assert not {"not-read", "cycle-parameters", "syntax"} & {
        code for _, code in said(run, f"{lines}\nL X+1 FMAX")
    }


def test_rotary_axes_turn_at_the_feed_of_the_tool(run: Run) -> None:
    """FAUTO of PLANE is the feed of TOOL CALL, 500 here: the axes traversed."""
    kinematics = Kinematics(0, (3, 5), (0.0, 0.0, -100.0))
    body = "TOOL CALL 1 Z S100 F500\nPLANE SPATIAL SPA-45 SPB+0 SPC+0 TURN {}"
    told, given = (
        run(program(body.format(word)), dialect="heidenhain", kinematics=kinematics)
        for word in ("FAUTO", "F500")
    )
    assert told.errors == given.errors == []
    assert told.path.kind.tolist() == given.path.kind.tolist()
    assert np.array_equal(told.path.feed, given.path.feed, equal_nan=True)
    assert np.isfinite(told.path.feed).any()


def test_cutting_speed_in_inches_is_told(run: Run, tmp_path: Path) -> None:
    """VC is in m a minute; a control may count feet a minute in a program in INCH."""
    table = tmp_path / "t.tbl"
    table.write_text("T5 P5 D20\n")
    text = "0 BEGIN PGM A INCH\nTOOL CALL 5 Z S( VC = 120 )\nL X+1 F10 M3\nEND PGM A INCH\n"
    out = run(text, dialect="heidenhain", tool_table=table)
    assert any(d.code == "feed-inch" and "VC" in d.message for d in out.diagnostics)


#: What a tool presetter sends: L and R of tool 40, in the tool table of the control.
PRESETTER = """FN 26: TABOPEN TNC:\\table\\tool.t
QS10 = "TI-0047"
QL10 = +115.029
QL11 = +7.516
FN 27: TABWRITE 40/"NAME" = QS10
FN 27: TABWRITE 40/"L"    = QL10
FN 27: TABWRITE 40/"R"    = QL11
FN 27: TABWRITE 40/"R2"   = +0
TOOL CALL 40 Z S1000
L X+0 Y+0 Z+0 FMAX
L X+20 Y+20 RL F500
L X+40
"""


def test_a_presetter_writes_the_tool_table(run: Run) -> None:
    """Its length and radius were passed over without a word; a name is passed over with a warning."""
    out = run(PRESETTER, dialect="heidenhain")
    assert out.errors == []
    assert out.path.end[-1].tolist() == pytest.approx([40, 27.516, 115.029])
    assert any("NAME of TOOL.T" in d.message for d in out.diagnostics if d.severity == "warning")


@pytest.mark.parametrize(
    "line",
    ['FN 27: TABWRITE 40/"L,R" = Q1', 'FN 27: TABWRITE 40/"DL" = +0.1', 'FN 27: TABWRITE 40/"R2" = +1'],
)
def test_columns_of_tools_that_are_not_kept(run: Run, line: str) -> None:
    out = run(f"FN 26: TABOPEN TNC:\\table\\tool.t\n{line}\nL X+5 FMAX", dialect="heidenhain")
    assert out.errors[0][0] == "unsupported-block"


def test_a_table_that_is_not_kept(run: Run) -> None:
    out = run(
        'FN 26: TABOPEN TNC:\\A.TAB\nFN 27: TABWRITE 5/"R,DEPTH" = Q5\nL X+5 FMAX', dialect="heidenhain"
    )
    assert out.errors == []
    assert "R,DEPTH of A.TAB" in " ".join(d.message for d in out.diagnostics)


def test_a_table_that_none_has_opened_is_not_written(run: Run) -> None:
    """This ended in an internal error."""
    out = run('FN 27: TABWRITE 5/"L" = +3\nL X+5 FMAX', dialect="heidenhain")
    assert out.errors[0][0] == "unsupported-block"
