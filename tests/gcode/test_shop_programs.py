"""What the programs of shops and posts are made of: each text is our own, and where it leads is worked out by hand."""

from __future__ import annotations

import io
import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.gcode import read
from cncgen.gcode.source import open_source
from cncgen.gcode.text.dialects import choose
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import Kind

Move = tuple[float, float, float, float]
PLAIN = "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S1000 F350\n"
DRILL_203 = "CYCL DEF 203 UNIVERSAL DRILLING ~\n Q200=+2 ~\n Q201=-10 ~\n Q206=+100 ~\n Q202=+6 ~\n Q210=+0 ~\n Q203=+0 ~\n Q204=+20 ~\n Q212=+0 ~\n Q213=+0 ~\n Q205=+0 ~\n Q211=+0 ~\n Q208={out} ;RETRACTION FEED RATE ~\n Q256=+0.2\nCYCL CALL"


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        # FAUTO takes the feed of TOOL CALL whatever F was between (iTNC 530, "Feed rate F").
        ("L Z-5 F100\nL X+10 FAUTO", [(0, 0, -5, 100), (10, 0, -5, 350)]),
        # FU is a feed of each turn: 0.2 mm at 1000 rev/min.
        ("L X+10 FU0.2\nL Y+10", [(10, 0, 0, 200), (10, 10, 0, 200)]),
        # The control keeps the radius of the tool in Q108.
        ("L X+Q108 F100\nQ1 = Q108 * 2\nL X-Q1", [(4, 0, 0, 100), (-8, 0, 0, 100)]),
        # Parameters of the program alone, and those that are kept.
        ("QL1 = 3\nQR1 = QL1 * 2\nL X+QR1 FQL1\nFN 11: IF +QR1 GT +5 GOTO LBL 9\nL X+99\nLBL 9\nL X-QL1", [(6, 0, 0, 3), (-3, 0, 0, 3)]),
        # A comment goes on behind ~.
        (";MILLING OF A FACE BY ~\n THE AUTHOR, NO CYCLE ~\n VERSION 2\nL X+1 F100", [(1, 0, 0, 100)]),
        # Feeds of cycles: FMAX is a traverse, 0 that of plunging (cycle 203, Q208), FAUTO that of TOOL CALL.
        (DRILL_203.format(out="+500"), [(0, 0, 2, 0), (0, 0, -6, 100), (0, 0, 2, 500), (0, 0, -4, 0), (0, 0, -10, 100), (0, 0, 2, 500), (0, 0, 20, 0)]),
        (DRILL_203.format(out="+0"), [(0, 0, 2, 0), (0, 0, -6, 100), (0, 0, 2, 100), (0, 0, -4, 0), (0, 0, -10, 100), (0, 0, 2, 100), (0, 0, 20, 0)]),
        (DRILL_203.format(out=" MAX"), [(0, 0, 2, 0), (0, 0, -6, 100), (0, 0, 2, 0), (0, 0, -4, 0), (0, 0, -10, 100), (0, 0, 2, 0), (0, 0, 20, 0)]),
        (DRILL_203.format(out="FAUTO"), [(0, 0, 2, 0), (0, 0, -6, 100), (0, 0, 2, 350), (0, 0, -4, 0), (0, 0, -10, 100), (0, 0, 2, 350), (0, 0, 20, 0)]),
        # The feed of APPR, from its own beginning on, may be a Q parameter, or that of TOOL CALL.
        ("L X-30 F100\nQ5 = 80\nAPPR LT X+0 Y+0 LEN10 RL FQ5\nL X+10\nDEP LT LEN5 FAUTO",
         [(-30, 0, 0, 100), (-10, 4, 0, 100), (0, 4, 0, 80), (10, 4, 0, 80), (15, 4, 0, 350)]),
    ],
)  # fmt: skip
def test_plain_language(moves: Any, body: str, expected: list[Move]) -> None:
    assert moves(f"{PLAIN}{body}\n9 END PGM T MM\n") == expected


@pytest.mark.parametrize(
    ("body", "code"),
    [("L X+1 FAUTO", "feed-missing"), ("CYCL DEF 200 X ~\n Q206= AUTO", "feed-missing")],
)  # fmt: skip
def test_feeds_that_plain_language_cannot_tell(run: Any, body: str, code: str) -> None:
    out = run(f"0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S1000\n{body}\n9 END PGM T MM\n")
    assert out.errors[0][:2] == (code, len(body.splitlines()) + 2)


def test_blanks_that_a_conversational_control_draws_move_nothing(moves: Any) -> None:
    lathe = "O1\nG1901 D120. E80. L45. K0.5\nG50 S2000\nT0101\nG97 S1000 M3\nG0 X20. Z5.\nG1 Z-1. F.2\nM30"
    assert moves(lathe) == [(10, 0, 5, 0), (10, 0, -1, 200)]
    mill = "O1\nG1902 B100. D50. H20. I0. J0. K0.\nG90 G54 G43 H1 Z5.\nG1 X1. F100.\nM30"
    assert moves(mill) == [(0, 0, 5, 0), (1, 0, 5, 100)]


@pytest.mark.parametrize(
    "text",
    [
        # Codes that stand behind others in their block.
        "G0G50S2000\nG0X50.Z2.\nG1Z-30.F.3\nM30",
        "G21G99G96S200M3\nG0X50.Z2.\nG1Z-30.F.3\nM30",
        "G18G99G28U0W0\nG0X50.Z2.\nG1Z-30.F.3\nM30",
        # Without G18 and Y, the centre of an arc with K lies in the plane of lathes alone.
        "T01M06\nG97S220M3\nG0X205.Z10.\nX192.735Z0\nG3X193.84Z-.366I0.K-.6F.1\nM30",
    ],
)
def test_lathes_are_recognised(text: str) -> None:
    choice = choose(open_source(io.BytesIO(text.encode()), "t.nc"))
    assert (choice.dialect, choice.rival) == ("fanuc-lathe", "")


def test_canonical_calls_of_other_controls_take_tools_without_a_table(calls: Any) -> None:
    found = calls("0 BEGIN PGM T MM\n1 TOOL CALL 27 Z S1000\n2 L X+1 F100\n3 END PGM T MM\n")
    assert [call for call in found if "STRAIGHT" in call] == [
        "STRAIGHT_FEED(1.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)"
    ]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        # DIAMON: X is a diameter in G90 and G91, its centre with AC() too; the increment of a centre and CR are radii.
        ("DIAMON\nG0 X40 Z0\nG1 X50\nG91 X10\nG90 Z=IC(-1)\nX=IC(10)",
         [(20, 0, 0, 0), (25, 0, 0, 100), (30, 0, 0, 100), (30, 0, -1, 100), (35, 0, -1, 100)]),
        ("DIAMON\nG0 X40 Z0\nG3 X60 Z-10 CR=10\nG3 X40 Z-20 I-10 K0\nG3 X20 Z-10 I=AC(20) K=AC(-20)",
         [(20, 0, 0, 0), (30, 0, -10, 100), (20, 0, -20, 100), (10, 0, -10, 100)]),
        ("DIAMON\nG0 X40 Z0\nCIP X40 Z-20 I1=60 K1=-10\nSUPA G0 X200", [(20, 0, 0, 0), (20, 0, -20, 100), (100, 0, -20, 0)]),
        # DIAM90: a diameter in G90, a radius in G91; DIAMOF: a radius.
        ("DIAM90\nG0 X40\nG1 G91 X10\nG90 X70\nDIAMOF\nX30", [(20, 0, 0, 0), (30, 0, 0, 100), (35, 0, 0, 100), (30, 0, 0, 100)]),
        # G26 bounds the speed of the spindle and G25 a working area: neither is a speed or a way.
        ("G95 S1000 M3 F0.1\nG26 S3000\nG25 X-50 Z-50\nG1 X10", [(10, 0, 0, 100)]),
        # Without M6 in the program T changes the tool at once: its radius is 4.
        ("T1 D1\nG1 G41 Z10\nX20\nG40 Z30", [(0, 0, 6, 100), (20, 0, 6, 100), (20, 0, 30, 100)]),
        ("T1=1 M1=4\nT2=\"CUT\" M2=3\nG1 X5", [(5, 0, 0, 100)]),
    ],
)  # fmt: skip
def test_lathes_of_sinumerik(moves: Any, body: str, expected: list[Move]) -> None:
    assert moves(f"G18 G90 G94 F100\n{body}\nM30\n", dialect="sinumerik") == expected


@pytest.mark.parametrize("plane", ["G18 ", ""])
def test_a_program_that_turns_has_diameters_unless_it_says_otherwise(run: Any, plane: str) -> None:
    text = f"{plane}G90 G95\nG0 X20 Z0\nG96 S200 LIMS=3000 M4\nG2 X30 Z-5 CR=5 F0.2\nM30\n"
    out = run(text)
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["diameter-doubtful"]
    assert out.errors == []
    assert out.path.end[out.path.kind < 3][:, [0, 2]].tolist() == [[10, 0], [15, -5]]
    # One that says DIAMOF further on was in diameters until there.
    later = run(text.replace("M30", "DIAMOF\nG0 X40\nM30"), dialect="sinumerik")
    assert [d.code for d in later.diagnostics if d.severity == "warning"] == ["diameter-doubtful"]
    assert later.path.end[later.path.kind < 3][:, 0].tolist() == [10, 15, 40]
    radii = run(f"DIAMOF\n{text}".replace("CR=5", "CR=9"), dialect="sinumerik")
    assert not [d for d in radii.diagnostics if d.severity == "warning"]
    # A mill may have a constant surface speed as well, for a boring head.
    assert not [
        d
        for d in run(f"G17\n{text[4:]}G0 Y1", dialect="sinumerik").diagnostics
        if d.code == "diameter-doubtful"
    ]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        # tan 30 deg = 1 / sqrt 3; 135 deg from Z in G18: Z goes back by as much as X (a radius) grows.
        ("ANG=30 X10", [(10, 10 / 3**0.5, 0)]),
        ("X1 Y1\nANG=90 Y4", [(1, 1, 0), (1, 4, 0)]),
        ("G91 X2\nANG=45 Y3", [(2, 0, 0), (5, 3, 0)]),
        ("G18 DIAMON\nG0 X20 Z0\nG1 ANG=135 X40", [(10, 0, 0), (20, 0, -10)]),
        # Two straight lines: they meet above the middle, at half of the base times the tangent of 30 degrees.
        ("ANG=30\nX10 Y0 ANG=-30", [(5, 5 / 3**0.5, 0), (10, 0, 0)]),
        ("ANG=0 CHR=2\n;\nX10 Y10 ANG=90", [(8, 0, 0), (10, 2, 0), (10, 10, 0)]),
        ("G18 DIAMON\nG0 X20 Z0\nG1 ANG=180 F50\nX40 Z-10 ANG=90 F100\nZ-20", [(10, 0, 0), (10, 0, -10), (20, 0, -10), (20, 0, -20)]),
    ],
)  # fmt: skip
def test_lines_by_their_angle(moves: Any, body: str, expected: list[tuple[float, float, float]]) -> None:
    found = [move[:3] for move in moves(f"F100\n{body}\nM30", dialect="sinumerik")]
    assert found == [pytest.approx(point, abs=1e-6) for point in expected]


@pytest.mark.parametrize(
    "body",
    [
        "ANG=30",
        "ANG=30 X1 Y1",
        "ANG=90 X5",
        "G2 ANG=30 X5 CR=9",
        "ANG=30\nX5",
        "ANG=30\nX5 Y5 ANG=30",
        "ANG=30\nX5 Y0 ANG=150",
        "ANG=30\nG91 X5 Y0 ANG=-30",
        "ANG=30\nF20 M8\nG2 X5 Y5 CR=9",
    ],
)
def test_lines_whose_angle_leads_nowhere(run: Any, body: str) -> None:
    (fault,) = (
        d for d in run(f"F100\n{body}\nM30", dialect="sinumerik").diagnostics if d.severity == "error"
    )
    assert fault.code == "drawing-angle"
    assert fault.span.line == 2 or "of line 2" in fault.message


def test_milling_cycles_need_no_feed_beside_their_own(moves: Any) -> None:
    text = "T1 D1 M6\nPOCKET4(20,0,2,-4,10,50,10,4,0,0,500,100,0,1)\nM30"
    assert {feed for *_, feed in moves(text, dialect="sinumerik")} == {0, 100, 500}


def test_a_shift_of_a_diameter_is_doubted(run: Any) -> None:
    shifted = run("DIAMON\nTRANS X10\nG1 X20 F100\nM30\n")
    assert [d.code for d in shifted.diagnostics if d.severity == "warning"] == ["frame-diameter"]


def test_a_program_is_called_by_its_text_and_a_tape_has_a_leader(moves: Any, tmp_path: Path) -> None:
    (tmp_path / "SUB1.SPF").write_text("G0 X7\nM17\n")
    text = '\0\0\0G90 G1 X1 F100\nCALL "SUB1"\nM30\n\0\0'
    assert moves(text, dialect="sinumerik", include=(tmp_path,)) == [(1, 0, 0, 100), (7, 0, 0, 0)]


def test_pockets_of_a_profile_are_roughed_where_its_first_line_has_both_axes(moves: Any) -> None:
    """G71 of type II: at depths of 4 the profile of radius 20, 12, 23 is free from Z2 to -40 and -36, then within its pocket."""
    lines = "N10 G0 X40. Z2.\nG1 Z-10.\nX24. Z-18.\nZ-25.\nX46. Z-36.\nN20 Z-40.\n"
    text = f"G98 S1000 M3\nG0 X62. Z2.\nG71 U4. R.5\nG71 P10 Q20 U0 W0 F100.\n{lines}M30\n"
    found = moves(text, dialect="fanuc-lathe")
    cuts = [(a[0], a[2], b[2]) for a, b in itertools.pairwise(found) if b[3] and a[0] == b[0]]
    # The slope at the beginning of the pocket has X19 at Z-11 and X15 at Z-15, that at its end at Z-32 and Z-28.
    assert cuts[:4] == [(27, 2, -40), (23, 2, -36), (19, -11, -32), (15, -15, -28)]
    assert [(x, z) for x, _, z, _ in found[-7:]] == [
        (20, 2),
        (20, -10),
        (12, -18),
        (12, -25),
        (23, -36),
        (23, -40),
        (31, 2),
    ]
    # No traverse leads through stock: below X31 it only goes to where the cut before has been, or leaves a cut.
    for a, b in itertools.pairwise(found):
        if b[3] == 0.0 and b[0] < a[0] < 31.0 and a[2] < 2.0:
            raise AssertionError((a, b))


@pytest.mark.parametrize(
    ("lines", "what"),
    [("N10 G0 X40.\nG1 Z-10.\nX24. Z-18.\nN20 X60. Z-40.", "not both X and Z"),
     ("N10 G0 X40. Z2.\nG1 Z-20.\nX46. Z-10.\nN20 X60. Z-40.", "goes back along Z")],
)  # fmt: skip
def test_profiles_that_cannot_be_roughed(run: Any, lines: str, what: str) -> None:
    text = f"G98 S1000 M3\nG0 X62. Z2.\nG71 U4. R.5\nG71 P10 Q20 U0 W0 F100.\n{lines}\nM30\n"
    out = run(text, dialect="fanuc-lathe")
    assert out.errors[0][:2] == ("profile-not-monotonic", 4)
    assert what in next(d.message for d in out.diagnostics if d.severity == "error")


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        # Three points: the origin, a point along X and one on the side of Y; R turns about Z, Q0 shifts in the plane.
        ("G68.2 P2 Q1 X0 Y0 Z0\nG68.2 P2 Q2 X10. Y0 Z0\nG68.2 P2 Q3 X0 Y10. Z0 R90.\nG1 X1. Y2. Z3.", (-2, 1, 3, 100)),
        ("G68.2 P2 Q0 X1. Y0 Z0 R0\nG68.2 P2 Q1 X10. Y0 Z0\nG68.2 P2 Q2 X10. Y10. Z0\nG68.2 P2 Q3 X10. Y0 Z10.\nG1 X1. Y2. Z3.", (13, 2, 2, 100)),
        # Two directions: X along the workpiece's Y and Z along its X, so that Y is along its Z.
        ("G68.2 P3 Q1 X5. Y0 Z0 I0 J1. K0\nG68.2 P3 Q2 I1. J0 K0\nG1 X1. Y2. Z3.", (8, 1, 2, 100)),
    ],
)  # fmt: skip
def test_tilted_planes_of_several_blocks(moves: Any, body: str, expected: Move) -> None:
    text = f"G90 F100.\n{body}\nG69\nM30\n"
    assert moves(text, dialect="fanuc")[-1] == expected


@pytest.mark.parametrize(
    "body",
    ["G68.2 P2 Q2 X1.", "G68.2 P2 Q1 X1.\nG68.2 P2 Q3 X1.", "G68.2 P2 X1.", "G68.2 P2 Q1 X0\nG68.2 P2 Q2 X0\nG68.2 P2 Q3 Y1.",
     "G68.2 P3 Q1 I1. J0 K0\nG68.2 P3 Q2 I1. J0 K1.", "G68.2 P2 Q1 X0\nG68.2 P2 Q90000000 X1."],
)  # fmt: skip
def test_tilted_planes_that_are_incomplete(run: Any, body: str) -> None:
    out = run(f"G90 F100.\n{body}\nM30\n", dialect="fanuc")
    assert out.errors[0][:2] == ("plane-points", len(body.splitlines()) + 1)


def test_words_of_lathes_that_are_not_corners(moves: Any) -> None:
    """R and K of a drilling cycle are its level and count while G1 is in force; H alone moves the axis C; M98 Q calls a line."""
    text = "G98 S1000 M3 F100.\nG0 X0 Z5.\nG1 Z4.\nG85 Z-6. R-2. K1\nG80\nM98 Q500\nM30\nN500 G0 X10.\nM99\n"
    assert [move[2:] for move in moves(text, dialect="fanuc-lathe")] == [
        (5, 0),
        (4, 100),
        (2, 0),
        (-6, 100),
        (2, 100),
        (4, 0),
        (4, 0),
    ]
    source = io.BytesIO(b"G98 F100.\nG0 H90.\nG1 Z-5.\nG0 H90.\nM30\n")
    program = read(source, "t.nc", ReadOptions(dialect="fanuc-lathe"))
    assert program.moving_axes == "ZC"
    (path,) = program.chunks()
    assert path.axes == "XYZC"
    assert np.degrees(path.end[:, 3]).round(9).tolist()[0] == 90.0


def test_pecks_by_a_factor(moves: Any) -> None:
    """DAM below 0 is the factor of each step to the one before (840D, CYCLE83): 4, 2, then MDEP 1.5."""
    text = "G17 G90 F100\nG0 Z20\nCYCLE83(20,0,2,-10,,,4,-0.5,0,0,1,0,,1.5,1,0,0)\nM30\n"
    depths = [z for _, _, z, feed in moves(text, dialect="sinumerik") if feed]
    assert depths == [-4, -3, -6, -5, -7.5, -6.5, -9, -8, -10]


def test_tools_of_an_index_or_a_text_and_other_presets(run: Any) -> None:
    text = '0 BEGIN PGM T MM\n1 DECLARE STRING QS1 = "MILL"\n2 TOOL CALL 12.1 Z S1000 F100\nTOOL CALL QS1 Z S500\nCYCL DEF 247 PRESET ~\n Q339=20\nL X+1\nEND PGM T MM\n'
    out = run(text)
    assert out.errors == []
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == [
        "tool-index",
        "preset-unknown",
    ]


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc"])
def test_lengths_that_may_count_increments_are_doubted(run: Any, dialect: str) -> None:
    text = "G21 G90 F200\nG1 X+040000\nZ-002000\nM2\n"
    assert [
        d.span.line for d in run(text, dialect=dialect).diagnostics if d.code == "other-control" and d.span
    ] == [2]
    assert "other-control" not in [
        d.code for d in run(text, dialect=dialect, least_increment=0.001).diagnostics
    ]
    assert "other-control" not in [
        d.code for d in run("G1 X4000 Y1234.5 F1\nM2\n", dialect=dialect).diagnostics
    ]


def test_a_program_of_fanuc_without_a_point_is_doubted(run: Any) -> None:
    text = "%\nO7\nG21 G90 F200\nG1 X1000\nZ-500\nM30\n%"
    assert ("warning", "other-control", 4) in remarks(run(text))
    # A point somewhere tells nothing of the others, unless whole numbers end in it.
    assert ("warning", "other-control", 4) in remarks(run(text.replace("Z-500", "Z-5.")))
    assert "other-control" not in [code for _, code, _ in remarks(run(text.replace("Z-500", "Z-5.5")))]
    assert "other-control" not in [code for _, code, _ in remarks(run(text.replace("X1000", "X999")))]


def test_face_and_cylinder_of_sinumerik(run: Any) -> None:
    """TRANSMIT: C90 at X10 is the point 0 10 of the face; the line to 10 10 has x sin(c) = 10. TRACYL(40): 10 mm are 10/20 rad."""
    out = run("G17 G90 G94 F100\nG0 C90 Z1\nX10 Y0\nTRANSMIT\nG1 X10 Y10\nTRAFOOF\nG0 X30 C0\nTRACYL(40)\nG19\nG1 Y10 Z5\nTRAFOOF\nG0 X50\nM30\n",
              dialect="sinumerik")  # fmt: skip
    assert out.errors == []
    assert out.path.axes == "XYZC"
    x, y, z, c = out.path.end.T
    face = np.flatnonzero((out.path.line == 5) & (out.path.kind != Kind.EVENT))
    assert np.abs(x[face] * np.sin(c[face]) - 10.0).max() < 0.0011
    assert (x[face[-1]], np.degrees(c[face[-1]])) == pytest.approx((200**0.5, 45.0))
    cylinder = np.flatnonzero((out.path.line == 10) & (out.path.kind != Kind.EVENT))
    assert (x[cylinder[-1]], z[cylinder[-1]], c[cylinder[-1]]) == pytest.approx((30.0, 5.0, 0.5))
    assert not y.any()
    assert run("TRACYL(40,1,2)\nM30\n", dialect="sinumerik").errors[0][0] == "not-read"


@pytest.mark.parametrize(
    ("angle", "kind", "expected"),
    [
        # Depths in radius of a thread of diameter 40: half of TDEP less FAL, all of it, TDEP, and one pass more.
        ("0", "1", [(19.5, 4), (19.0, 4), (18.8, 4), (18.8, 4)]),
        # Inside, and by equal sections: the first depth is 1/sqrt(2) of it.
        ("0", "4", [(20 + 2**-0.5, 4), (21, 4), (21.2, 4), (21.2, 4)]),
        # At 45 degrees of infeed the start moves along as deep as the cut.
        ("45", "1", [(19.5, 3.5), (19.0, 3.0), (18.8, 2.8), (18.8, 2.8)]),
        ("-45", "1", [(19.5, 3.5), (19.0, 5.0), (18.8, 2.8), (18.8, 5.2)]),
    ],
)
def test_threads_of_cycle97(moves: Any, angle: str, kind: str, expected: list[tuple[float, float]]) -> None:
    text = f"G18 G90 G95 DIAMON\nS500 M3\nG0 X60 Z10\nCYCLE97(2,,0,-20,40,40,4,2,1.2,0.2,{angle},0,2,1,{kind},1)\nM30\n"
    found = moves(text, dialect="sinumerik")
    cuts = [(a[:3], b[:3]) for a, b in itertools.pairwise(found) if b[3]]
    assert [(a[0], a[2]) for a, _ in cuts] == [
        (pytest.approx(x, abs=1e-6), pytest.approx(z)) for x, z in expected
    ]
    assert all(b[2] == -22.0 and b[0] == a[0] for a, b in cuts)


@pytest.mark.parametrize(
    ("vari", "tail", "expected"),
    [
        # As CYCLE97: two cuts and the allowance, one pass more; with one flank the angle's sign is above 0, with both in turn below.
        (300001, "0", [(19.5, 4), (19.0, 4), (18.8, 4), (18.8, 4)]),
        (1300101, "45", [(19.5, 3.5), (19.0, 3.0), (18.8, 2.8), (18.8, 2.8)]),
        (300201, "45", [(19.5, 3.5), (19.0, 5.0), (18.8, 2.8), (18.8, 5.2)]),
        (300003, "0", [(20 - 2**-0.5, 4), (19, 4), (18.8, 4), (18.8, 4)]),
        (100001, "0", [(19.5, 4), (19.0, 4)]),
        (200001, "0", [(18.8, 4), (18.8, 4)]),
    ],
)
def test_threads_of_cycle99(moves: Any, vari: int, tail: str, expected: list[tuple[float, float]]) -> None:
    """The thread of CYCLE97 above, in the order of a program that a control made: SPL SPD FPL FPD … NRC NID PIT VARI NUMTH SDIS."""
    text = f"G18 G90 G95 DIAMON\nS500 M3\nG0 X60 Z10\nCYCLE99(0,40,-20,,4,2,1.2,0.2,{tail},0,2,1,2,{vari},1,3)\nM30\n"
    found = moves(text, dialect="sinumerik")
    cuts = [(a[:3], b[:3]) for a, b in itertools.pairwise(found) if b[3]]
    assert [(a[0], a[2]) for a, _ in cuts] == [
        (pytest.approx(x, abs=1e-6), pytest.approx(z)) for x, z in expected
    ]
    assert {b[3] for b in found if b[3]} == {1000.0}
    # SDIS is how far the tool leaves the thread.
    assert max(move[0] for move in found[1:]) == 23.0


def test_cuts_of_cycle99_by_the_first_one_and_an_angle_by_its_width(moves: Any) -> None:
    """Equal sections whose first cut is at most 0.5 of 1: four, of 0.5, 0.5 sqrt 2, …; 1.2 aside over a depth of 1.2 is 45 degrees."""
    text = "G18 G90 G95 DIAMON\nS500 M3\nG0 X60 Z10\nCYCLE99(0,40,-20,40,4,2,1.2,0.2,,0,,,2,300103,1,1,0.5,,,,,,1.2,1,,,,2,0)\nM30\n"
    found = moves(text, dialect="sinumerik")
    cuts = [(a[0], a[2]) for a, b in itertools.pairwise(found) if b[3]]
    assert cuts == [
        (pytest.approx(20 - d, abs=1e-6), pytest.approx(4 - d, abs=1e-6))
        for d in (0.5, 0.5**0.5, 0.75**0.5, 1, 1.2)
    ]


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ("0,40,-20,,4,2,1.2,0.2,0,0,2,1,2,300011,1", "not-read"),
        ("0,40,-20,,4,2,1.2,0.2,0,0,2,1,2,900001,1", "not-read"),
        ("0,40,-20,,4,2,1.2,0.2,0,0,2,1,2,300001,1,1,0,0,0.1", "not-read"),
        ("0,40,-20,,4,2,1.2,0.2,0,0,2,1,2,300001,1,1,0,0,0,0,0,0,0,3", "not-read"),
        ("5,40,-20,,4,2,1.2,0.2,0,0,2,1,2,300001,1,1,0,0,0,0,0,0,0,1,,,,2,1", "not-read"),
        ("0,40,-20,,4,2,1.2,0.2,0,0,0,1,2,300001,1", "thread-words"),
        ("0,40,-20,,4,2,1.2,0.2,0,0,2,1,2,300007,1", "thread-words"),
        ("0,40,-20,,4,2,1.2,0.2,0,0,2,1,2,300001,1,1,0,0,0,0,0,0,0,1,,,,1,0", "cycle-plane"),
    ],
)
def test_threads_of_cycle99_that_are_not_read(run: Any, words: str, code: str) -> None:
    assert run(f"G18 S100 M3\nCYCLE99({words})\nM30\n", dialect="sinumerik").errors[0][:2] == (code, 2)


def test_a_chain_of_threads_of_cycle98(moves: Any) -> None:
    """The manual's example (840D, Programming Guide, Cycles, 4.8), two cuts: from 10 before Z0 to 10 behind Z-80, X35.857 there.

    Three leads in one pass; the tool leaves the thread by 1 beyond all its diameters, and the run-out of the last cone is one of them.
    """
    text = "G95 S1000 M4\nG0 X60 Z20 DIAMON G18\nCYCLE98(0,30,-30,30,-60,36,-80,50,10,10,0.92,,,,2,{},1.5,2,2,{},1)\nM2\n"
    end = 25 + 10 * 7 / 20
    found = moves(text.format(0, 1), dialect="sinumerik")
    for cut in (0.46, 0.92):
        way = [(15 - cut, 10), (15 - cut, -30), (18 - cut, -60), (end - cut, -90), (end + 1, -90)]
        assert any(
            [(m[0], m[2]) for m in found[k : k + 5]] == [pytest.approx(p) for p in way]
            for k in range(len(found))
        )
    leads = [1.5, 2 * (1 + 0.1**2) ** 0.5, 2 * (1 + 0.35**2) ** 0.5]
    assert [m[3] for m in found if m[3]] == pytest.approx([1000 * lead for lead in leads] * 2)


@pytest.mark.parametrize(
    "points", ["0,30,0,30,0,30,0,30", "0,30,-30,30,-20,36,-80,50", "0,30,-30,30,-40,60,-80,60"]
)
def test_chains_of_threads_that_nobody_can_cut(run: Any, points: str) -> None:
    text = f"G18 S100 M3\nCYCLE98({points},2,2,1,,,,2,0,1,1,1,1,1)\nM30\n"
    assert run(text, dialect="sinumerik").errors[0][:2] == ("thread-words", 2)


@pytest.mark.parametrize(
    "words",
    [
        "0,-20,40,40,4,2,1,1,0,0,2,0,1,1",
        "0,0,40,40,4,2,1,0,0,0,2,0,1,1",
        "0,-20,40,40,4,2,1,0,0,0,0,0,1,1",
        "0,-20,40,40,4,2,1,0,0,0,2,0,7,1",
    ],
)
def test_threads_that_nobody_can_cut(run: Any, words: str) -> None:
    assert run(f"G18 S100 M3\nCYCLE97(2,,{words})\nM30\n", dialect="sinumerik").errors[0][:2] == (
        "thread-words",
        2,
    )


SUBPROGRAM, MAIN = "O1000 (WAY, M30 IN BRACKETS)\nG0 X5\nM99\n", "O1\nG21 G0 X1\nM98 P1000\nM30\n"


@pytest.mark.parametrize("head", ["O0002\n", "%\nO0002 (PART)\n\n", "%\nO2;\n(BEHIND)\n%\n", "O<PART>\nO3\n"])
def test_a_program_number_without_blocks_is_not_the_program(run: Any, head: str) -> None:
    """A shop's file began with O0002, O0001(BRIDES), and not a motion was read."""
    out = run(head + "O0001(BRIDES)\nG21 G0 X1.\nM30\n", dialect="fanuc")
    assert out.errors == []
    found = [(d.code, d.span.line) for d in out.diagnostics if d.severity == "warning" and d.span]
    assert found == [("main-behind", head.count("\n") + 1)]
    assert out.path.end[out.path.kind != Kind.EVENT, 0].tolist() == [1.0]
    assert "main-behind" not in [d.code for d in run(MAIN + SUBPROGRAM + "O7\n", dialect="fanuc").diagnostics]


@pytest.mark.parametrize(
    ("text", "warned"),
    [(SUBPROGRAM + MAIN, [("main-behind", 4)]), (f"%\n{SUBPROGRAM}%\n%\n{MAIN}%\n", [("main-behind", 7)]), (MAIN + SUBPROGRAM, []), (SUBPROGRAM, [])],
)  # fmt: skip
def test_a_main_program_behind_a_subprogram_is_run(run: Any, text: str, warned: list[Any]) -> None:
    out = run(text, dialect="fanuc")
    assert [(d.code, d.span.line) for d in out.diagnostics if d.code == "main-behind" and d.span] == warned
    ends = out.path.end[out.path.kind != Kind.EVENT, 0].tolist()
    assert (out.errors, ends) == ([], [5.0] if text == SUBPROGRAM else [1.0, 5.0])


def test_the_centre_of_a_rotation_as_mach3_writes_it(moves: Any) -> None:
    """About (10, 5) by 90 degrees: (12, 5) is (10, 7), and (10, 8) is (7, 5)."""
    ends = [
        end[:3]
        for end in moves("G21 G90\nG68 A10. B5. R90.\nG0 X12. Y5.\nX10. Y8.\nG69\nM30\n", dialect="fanuc")
    ]
    assert ends == [(10, 7, 0), (7, 5, 0)]


@pytest.mark.parametrize("block", ["G68 X1. A10. B5. R90.", "G18 G68 A10. B5. R90."])
def test_a_centre_that_is_written_twice_or_lies_in_another_plane(run: Any, block: str) -> None:
    assert run(f"{block}\nM30\n", dialect="fanuc").errors[0][:2] == ("rotation-plane", 1)


def test_allowances_of_a_finishing_cycle_are_passed_over_with_a_warning(run: Any) -> None:
    """Programs of Haas's lathes write G70 with the words of G71: the profile is finished as it is written."""
    text = "G99 S1000 M3\nG0 X62. Z2.\nG71 U2. R.5\nG71 P10 Q20 U.4 W.1 F.2\nN10 G0 X40.\nG1 Z-10. F.1\nN20 X60.\nG70 P10 Q20{}\nM30\n"
    plain, idle = (run(text.format(words), dialect="fanuc-lathe") for words in ("", " U0.1 W0 D0.01"))
    assert np.array_equal(plain.path.end, idle.path.end)
    assert [(d.code, d.span.line) for d in idle.diagnostics if d.severity == "warning" and d.span] == [
        ("unused-word", 8)
    ]


def remarks(out: Any) -> list[tuple[str, str, int]]:
    """Return what a run says beside guesses of units and dialects: severity, code, line."""
    passed = ("units-assumed", "dialect", "no-tool-table")
    return [(str(d.severity), d.code, d.span.line) for d in out.diagnostics if d.code not in passed]


@pytest.mark.parametrize(
    ("text", "end", "said"),
    [
        # grbl and Mach take K0 of an arc in XY, Mach and FANUC's G53 without axes does nothing, M25 is a builder's code (Hurco).
        ("G21 G90 F100\nG2 X10 Y0 I5 J0 K0.000\nM2", (10, 0), []),
        ("G21\nG53 G90 G40\nG0 X5\nM2", (5, 0), []),
        ("G21 G0 X1\nM25\nG0 X5\nM30", (5, 0), [("warning", "builders-code", 2)]),
        # grbl begins with G0 in force.
        ("G21\nX5\nM2", (5, 0), [("warning", "other-control", 2)]),
        # S of G4 is a time in seconds with Marlin.
        ("G21\nG0 X5\nG4 S3\nM2", (5, 0), [("warning", "other-control", 3)]),
    ],
)  # fmt: skip
def test_what_linuxcnc_alone_refuses_is_passed_over_where_no_sign_tells_the_control(
    run: Any, text: str, end: tuple[float, float], said: list[tuple[str, str, int]]
) -> None:
    out = run(text)
    assert remarks(out) == said
    assert tuple(out.path.end[-1, :2]) == end
    # LinuxCNC itself refuses each (`rs274`).
    assert len(run(text, dialect="linuxcnc").errors) == 1


def test_an_arc_has_no_centre_out_of_its_plane(run: Any) -> None:
    assert [e[:2] for e in run("G21 G90 F100\nG2 X10 Y0 I5 K1\nM2").errors] == [("arc-plane", 2)]


@pytest.mark.parametrize(
    ("words", "seconds", "said"),
    [
        ("P500", 0.5, 0),
        # With a point FANUC's controls raise an alarm, so that another unit is meant: Haas counts seconds.
        ("P.5", 0.5, 1),
        ("P2.", 2.0, 1),
        # Half a second as well: nobody waits for 500 s.
        ("P500.", 0.5, 1),
        ("P2", 0.002, 1),
        ("X2.", 2.0, 0),
    ],
)
def test_a_dwell_of_fanuc_counts_as_its_point_says(run: Any, words: str, seconds: float, said: int) -> None:
    out = run(f"%\nO1\nG21 G04 {words}\nM30\n%", dialect="fanuc")
    assert [e.values["seconds"] for e in out.path.events if e.name == "dwell"] == [seconds]
    assert [d.code for d in out.diagnostics].count("dwell-point") == said


def test_a_dwell_of_a_program_of_haas_with_a_point_counts_seconds_however_long(run: Any) -> None:
    """Haas's own program that runs a spindle in says "Cycle time: 2 hours": 600 + 600 + 900 s and 15 times twice 30 + 150 s."""
    text = (
        "%\nO02021\nS750 M03\nG04 P600.\nS2500 M03\nG04 P600.\nS5000 M03\nG04 P900.\nM97 P1000 L15\nM97 P1000 L15\nM30\n"
        "N1000\nS7500 M03\nG04 P30.\nS500 M03\nG04 P150.\nM99\n%"
    )
    assert sum(event.dwell_s for event in run(text, dialect="fanuc").path.events) == 7500.0


def test_a_dwell_in_a_cycle_counts_as_its_point_says(calls: Any) -> None:
    text = "%\nO1\nG21 G90 G99 F100\nG0 Z5.\nG82 X0 Y0 Z-1. R1. P{}\nX1.\nG80\nM30\n%"
    for words, seconds in (("250", "0.2500"), (".25", "0.2500"), ("250.", "0.2500")):
        assert [c for c in calls(text.format(words)) if "DWELL" in c] == 2 * [f"DWELL({seconds})"]


def test_a_step_of_least_increments_is_no_stroke_through_the_hole(run: Any, moves: Any) -> None:
    text = "%\nO1\nG21 G90 G98\nG0 Z10.\nG83 X0 Y0 Z-5. R1. Q{} F100\nG80\nM30\n%"
    levels = [[z for _, _, z, feed in moves(text.format(q)) if feed] for q in ("2000", "2.", "9.")]
    assert levels == [[-1.0, -3.0, -5.0], [-1.0, -3.0, -5.0], [-5.0]]
    assert ("warning", "cycle-peck", 5) in remarks(run(text.format("2000")))


def test_measuring_macros_of_a_probe_lead_back_to_where_they_began(run: Any, moves: Any) -> None:
    text = "%\nO1\nG21 G90\nG0 Z50.\nG65 P9832\nG65 P9810 X4. Z10. F3000.\nG65 P9811 Z0. S1.\nG65 P9833\nG1 Y2.\nM30\n%"
    assert moves(text) == [(0, 0, 50, 0), (4, 0, 10, 3000), (4, 2, 10, 3000)]
    assert [code for _, code, _ in remarks(run(text))] == ["probe-not-run"]
    assert [e[:2] for e in run(text.replace("P9811", "P8811")).errors] == [("sub-missing", 7)]


def test_programs_of_six_digits_and_common_variables_beyond_the_others(run: Any, moves: Any) -> None:
    """Options of FANUC's controls: M98 P110001 runs O110001 where there is one, else O0001 11 times; #900000 begins without a value."""
    text = "%\nO110000\nG21 G91 G1 F100\nM98 P110001\nM98 P110001 L2\nM30\nO110001\nX1.\nM99\nO1\nY1.\nM99\n%"
    assert [move[:2] for move in moves(text)] == [(1, 0), (2, 0), (3, 0)]
    assert [move[:2] for move in moves(text.replace("O110001\nX1.\nM99\n", "").replace(" L2", ""))][-1] == (
        0,
        22,
    )
    text = "%\nO1\nG21 G0\nIF[#900000 EQ #0] GOTO 1\nX9.\nN1 #900000=3\n#100002=#900000*2\nX#900000 Y#[100000+2] Z#199999\nM30\n%"
    assert moves(text) == [(3, 6, 0, 0)]
    assert [e[:2] for e in run("%\nO1\n#907400=1\nM30\n%").errors] == [("parameter-number", 3)]


def test_a_main_program_without_its_number_calls_others_as_fanuc_has_it(run: Any, tmp_path: Path) -> None:
    (tmp_path / "O0007").write_text("O0007\nG91 G0 X1.\nM99\n")
    out = run("G90 G21 G0 X0. Y0.\nM98 P0007\nM98 P20007\nM30\n", include=(tmp_path,))
    assert out.errors == []
    assert next(d.message for d in out.diagnostics if d.code == "dialect").startswith("read as fanuc")
    assert out.path.end[-1, 0] == 3.0


@pytest.mark.parametrize(("words", "said"), [("M74 H1 J2", "builders-code"), ("M74 J1 X2.", "unused-word")])
def test_words_beside_a_builders_code_are_its_own_where_no_axis_moves(
    run: Any, words: str, said: str
) -> None:
    out = run(f"%\nO1\nG21 G90 G0 X1.\n{words}\nM30\n%")
    assert [code for _, code, _ in remarks(out)] == [said]


def test_commands_to_grbl_are_passed_over(run: Any) -> None:
    out = run("$H\n$110=500\nG21 G90 G0 X5\n?\nM2\n")
    assert remarks(out) == [("warning", "other-control", 1)]
    assert out.path.end[-1, 0] == 5.0
    assert [e[:2] for e in run("G21\n$J=G91 X5 F100\nM2\n").errors] == [("syntax", 2)]


def test_a_time_of_marlin_is_no_speed(run: Any) -> None:
    out = run("G21\nM3 S1000\nG4 S3\nG0 X5\nM2\n")
    assert [event.dwell_s for event in out.path.events if event.name == "dwell"] == [3.0]
    assert [e.values["speed_rpm"] for e in out.path.events if "speed_rpm" in e.values] == [1000.0] * 2


def test_no_motion_is_in_force_behind_g80(run: Any) -> None:
    """grbl refuses an axis word there: error 31, G80 in force."""
    assert [e[:2] for e in run("G21\nG0 X5\nG80\nX7\nM2").errors] == [("no-motion-mode", 4)]


@pytest.mark.parametrize("dialect", ["auto", "fanuc"])
def test_lines_to_a_simulator_are_passed_over(run: Any, dialect: str) -> None:
    """CNCSimulator Pro's guide, 6.3: $-commands control the simulation, and have nothing to do with CNC codes."""
    out = run("$AddRegPart 1 X2.925 Y2.005\n$Mill\nG21 G90 G0 X5.\nM30\n", dialect=dialect)
    assert remarks(out) == [("warning", "other-control", 1)]
    assert out.path.end[-1, 0] == 5.0


def test_lines_to_a_simulator_do_not_begin_a_program(run: Any) -> None:
    """They are no blocks, so that a % behind them begins the program as one behind comments does."""
    out = run("(a shaft)\n$AddRegPart 1\n%\nG21 G90 G0 X5.\nM30\n%\n")
    assert remarks(out) == [("warning", "other-control", 2)]
    assert out.path.end[-1, 0] == 5.0


def test_a_feed_that_a_faulty_line_works_out_is_not_missed_behind_it(run: Any) -> None:
    text = "O1\nG21 G90\n#100=200\nM3 S[#100] F[#100*2].\nG1 X1.\nX2.\nM30"
    assert [e[0] for e in run(text, dialect="fanuc").errors] == ["syntax"]


def test_an_axis_beside_a_pattern_of_holes_is_told(run: Any) -> None:
    text = "O1\nG21 G90 G0 X0 Y0 Z5.\nG81 X1. Z-2. R1. F10\nG70 I5. J0 L3 A20.\nM30"
    assert [e[0] for e in run(text, dialect="fanuc").errors] == ["unused-word"]


def test_a_feed_a_minute_on_a_lathe_that_never_said_its_mode(run: Any, moves: Any) -> None:
    """F120 a revolution is nobody's; it is 120 mm a minute unless G99 was said."""
    text = "%\nO1\nT0101\nM3 S500\n{}G0 X50. Z2.\nG1 Z-10. F120.\nM30\n%"
    for said, feed in (("", 120.0), ("G99 ", 60000.0)):
        assert moves(text.format(said), dialect="fanuc-lathe")[-1][3] == pytest.approx(feed)
        found = [d.code for d in run(text.format(said), dialect="fanuc-lathe").diagnostics]
        assert found.count("feed-doubtful") == 1


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc"])
@pytest.mark.parametrize("line", [":(tool 1)", ": (end)", ":"])
def test_the_sign_of_a_program_without_its_number_is_passed_over(run: Any, dialect: str, line: str) -> None:
    """It names no program, and says nothing else; its line was refused."""
    out = run(f"G21 G90 G0 X5.\n{line}\nX6.\nM30\n", dialect=dialect)
    assert out.errors == []
    assert out.path.end[:, 0].tolist()[-1] == 6.0
    assert [d.severity for d in out.diagnostics if d.code == "other-control"] == ["warning"]
