"""What another control would read: said once, at its first place, and only where it is doubtful."""

from __future__ import annotations

import io
import time
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
        ("G0 X10. ; the wall\n; G2 is next\nG28 U0 ; G28=goto(0,0), G91=distances\nM30;", [(3, 5)]),
        ("G0 X10. ; the wall\n;N5 G2 X[#1+2] R-#3 ; next\nM30;", [(2, 1)]),
        ("G0 X10.\nG4 X5\nG04 X3\nM30", []),
        ("G0 X10.;\nM30;", []),
        # Haas's controls need no THEN.
        (
            "#1=1\nIF[[#1EQ1]AND[#2LT[#3+1]]]THEN#4=[1]\nN5 IF [#1 EQ 1] GOTO9\nIF[[#1EQ1]OR[#2EQ1]]#4=2\nIF[#1EQ1]S900\nN9IF[#1EQ2]M99\nM30",
            [(5, 10)],
        ),
        # Whole numbers that end in a point are written for controls that count least increments without one (M700V manual, 5.3, type I).
        ("G0 X10. Y0\nX12.5 Y-30\nM30", [(2, 7)]),
        ("G0 X12.5 Y-30\nM30", []),
        ("(Y5) G0 X10. Y0\nX#1 Y[3]\nM30", []),
        # So are Q of pecks, R and centres of arcs; arguments, numbers of modes and long pecks, which are read so, are none.
        ("G0 X10. Y0 Z9.\nG83 X1. Z-10. R2. Q5 F100.\nG80\nM30", [(2, 19)]),
        ("G0 X10. Y0 Z9.\nG98 G81 Z-10. R2 F100.\nG80\nM30", [(2, 15)]),
        ("G1 X10. Y0 F100.\nG2 X20. I5 J0\nM30", [(2, 9)]),
        ("G0 X10. Y0 Z9.\nG83 X1. Z-10. R2. Q2000 F100.\nG80\nM30", []),
        ("G0 X10. Y0\nG5.1 Q1\nG65 P1 R5 Q3\nG10 L10 P1 R5\nM30\nO1\nM99", []),
        ("G0 X10. Y0\nG84 X1. Z-10. R2. J2 F1.\nM30", []),
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
    example = "G90 G0 A-150.\nA540.\nM30"
    found = next(d for d in run(example, dialect="fanuc").diagnostics if d.code == "roll-over")
    assert "from -150 to 540, by 690 degrees" in found.message
    assert "goes by -30" in found.message
    for text, lines in (
        (example, [2]),
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


def found(text: str, code: str, **options: str) -> list[tuple[int, str]]:
    """Return lines and messages of the remarks of one code that a check makes."""
    remarks = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", ReadOptions(**options), remarks)  # type: ignore[arg-type]
    return [(d.span.line, d.message) for d in remarks if d.code == code and d.span]


def test_a_feed_that_rotary_axes_share_is_doubted_where_no_sign_tells_the_control() -> None:
    """10 mm and 90 degrees at F100: 6 s along X, and sqrt(10² + 90²) / 100 min = 54.3 s along both; an inch is 1 and 90 at F10."""
    line = "G90\nG0 X0 A0\nG1 X10 A90 F100\nM2"
    assert [number for number, _ in found("G21 " + line, "feed-rotary")] == [3]
    assert "takes 6 s" in found("G21 " + line, "feed-rotary")[0][1]
    assert "take 54.3 s" in found("G21 " + line, "feed-rotary")[0][1]
    assert "take 540 s" in found("G20 G90\nG0 X0 A0\nG1 X1 A90 F10\nM2", "feed-rotary")[0][1]
    for text, options in (
        ("G21 " + line, {"dialect": "linuxcnc"}),
        ("G21 " + line, {"dialect": "fanuc"}),
        ("O1\nG21 " + line, {}),
        ("G21 G93 " + line.replace("F100", "F10"), {}),
        ("G21 G90\nG0 X0 A0\nG1 A90 F100\nX10\nM2", {}),
        ("G21 G90\nG0 X0 A0\nG1 X100 A90 F100\nM2", {}),
    ):
        assert found(text, "feed-rotary", **options) == [], (text, options)


def test_lengths_before_g20_are_taken_as_mm_with_a_warning() -> None:
    """The unit of a text that says it late is what the control had before (B-63534EN, 8.2)."""
    text = "G0 X1 Y1\nG20 G1 X1 F10\nM2"
    assert [line for line, _ in found(text, "units-doubtful")] == [2]
    assert found(text, "units-doubtful", units="inch") == []
    for text in (
        "G20\nG0 X1 Y1\nG1 X2 F10\nM2",
        "o1 sub\nG0 X1\no1 endsub\nG20\no1 call\nM2",
        "G21 G0 X1\nG20 X1\nM2",
        "G0 X1\nG21 X1\nM2",
    ):
        assert found(text, "units-doubtful") == [], text


@pytest.mark.parametrize(
    ("text", "dialect", "lines"),
    [
        # FANUC's manual has G53 traverse (B-63534EN, 7.1); G1 beside it feeds here.
        ("G0 X1.\nG53 G1 Z-5. F100.\nM30", "fanuc", [2]),
        ("G1 X1. F100.\nG53 Z-5.\nM30", "fanuc", [2]),
        ("G1 X1. F100.\nG53 G0 Z-5.\nG53\nM30", "fanuc", []),
        ("G0 X1.\nG53 Z-5.\nM30", "fanuc", []),
        ("G0 X1\nG53 G1 Z-5 F100\nM2", "linuxcnc", []),
        # Six digits of T are nose radius, tool and offset on Okuma's lathes (OSP manuals, "T commands").
        ("G50 S900\nT010101\nM30", "fanuc-lathe", [2]),
        ("G50 S900\nT1212\nM30", "fanuc-lathe", []),
        # A drilling centre's programs change the tool by T alone (FANUC calls O9000 then, parameter 6001#5).
        ("T1 (T9)\nG0 X1.\nT2(DRILL)\nX2.\nT3\nM30", "fanuc", [3]),
        ("T1\nG0 X1.\nT01\nX2.\nM30", "fanuc", []),
        ("T1\nG0 X1.\nT2\nM06\nM30", "fanuc", []),
        ("T1\nM98 P5\nT2\nM98 P5\nM30\nO5\nM6\nM99", "fanuc", []),
        # A macro of a shop went on in the next line, up to ENDIF.
        ("#1=0\nIF[#1 EQ 1]THEN (SKIP)\nG0 X1.\nIF[#1 EQ 0] THEN #2=1\nM30", "fanuc", [2]),
        # SINUMERIK's ISO dialect ends with G290.
        ("G291\nG0 X1.\nG290\nM30", "fanuc", [3]),
        # Of five, three are the offset on Doosan's Lynx 2100 (their programs pair T04004 with T04104); one number by two digits is not.
        ("T01001\nG0 X5.\nT01101\nM30", "fanuc-lathe", [1]),
        ("(T01001)\nT0101\nT01010\nT00303\nM30", "fanuc-lathe", []),
    ],
)
def test_words_that_controls_read_otherwise(text: str, dialect: str, lines: list[int]) -> None:
    assert [line for line, _ in found(text, "other-control", dialect=dialect)] == lines


def test_a_chamfer_of_a_thread_that_only_the_control_knows_is_said() -> None:
    """Parameter 5130 gives it (B-64304EN-1, 4.1.2); G76 P011060 sets it to one lead."""
    cut = "T0101\nG97 S500 M3\nG0 X32. Z5.\nG92 X29. Z-25. F2.\nX28.\nM30"
    assert [line for line, _ in found(cut, "thread-chamfer", dialect="fanuc-lathe")] == [4]
    said = cut.replace("G92", "G76 P011060 Q100 R0.05\nG92")
    assert found(said, "thread-chamfer", dialect="fanuc-lathe") == []


def test_an_origin_within_a_frame_is_doubted_once() -> None:
    """FANUC: G52 to G59 and G92 must not be commanded in a rotation, scaling or mirror image (B-63534EN, 14.6 to 14.9)."""
    for frame in ("G68 X1. Y0 R90.", "G51 X0 Y0 P2000", "G51.1 X0"):
        for origin in ("G55", "G52 X5.", "G92 X0", "G54.1 P2"):
            text = f"G0 X1.\n{frame}\n{origin}\n{origin}\nG69\nM30"
            assert [line for line, _ in found(text, "frame-origin", dialect="fanuc")] == [3], text
    assert found("G54\nG68 X0 Y0 R9.\nG43 H1\nG69\nG55\nM30", "frame-origin", dialect="fanuc") == []


def test_a_check_looks_at_ways_of_rotary_axes_beyond_the_head_of_a_long_text() -> None:
    """An endless table is warned of once, at the first way that differs, by `check` as by `plan`."""
    text = "O1\nG21 G90 G0 A0\n" + "G1 X1. F100.\nX2.\n" * 6000 + "A200.\nA0\nM30\n"
    found = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", ReadOptions(dialect="fanuc"), found)
    assert [d.span.line for d in found if d.code == "roll-over" and d.span] == [12003]
    steps = "O1\nG21 G90 G0 A0\nG91\n" + "G1 X1. F100.\n" * 90_000 + "A360.\n" * 200 + "M30\n"
    found = Diagnostics()
    check(io.BytesIO(steps.encode()), "t.nc", ReadOptions(dialect="fanuc"), found)
    assert [d for d in found if d.code == "roll-over"] == []


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


@pytest.mark.parametrize(
    ("text", "places"),
    [("G64 P10\nG64 P1000\nG64 P999\nM2", [(2, 5)]), ("G20\nG64 P0.39\nG64 P0.4\nM2", [(3, 5)])],
)
def test_a_tolerance_as_wide_as_a_part_is_no_length(
    run: Callable[..., Outcome], text: str, places: list[tuple[int, int]]
) -> None:
    """More than 10 mm, 0.3937 inches; it is said once."""
    out = run(text, dialect="linuxcnc", units="auto")
    found = [(d.span.line, d.span.column) for d in out.diagnostics if d.code == "tolerance-wide" and d.span]
    assert found == places


@pytest.mark.parametrize(
    ("line", "told"), [("(REPLACE F0.1 ; F1000)", 0), ("G1 X1. (A) ; G1 X2.", 1), ("(A; G1 X2.) ;X3.", 1)]
)
def test_a_semicolon_within_a_comment_hides_no_block(
    run: Callable[..., Outcome], line: str, told: int
) -> None:
    out = run(f"O1\nG21 G90 F100.\n{line}\nM30", dialect="fanuc")
    assert len([d for d in out.diagnostics if d.message.startswith("what follows ;")]) == told


@pytest.mark.parametrize(
    ("text", "dialect", "place"),
    [
        ("G21 F100 (1/2)\nG1 X[1/2]\n/G1 X2.\n/G1 X3.\nM30", "fanuc", (3, 1)),
        ("G21 F100\n N10 /2 G1 X2.\nM30", "fanuc", (2, 6)),
        ("G21 F100\n/ G1 X2\nM2", "linuxcnc", (2, 1)),
        ("G71 F100\nN20 /1 G1 X2\nM30", "sinumerik", (2, 5)),
        ("0 BEGIN PGM A MM\n1 L X+1 F100\n/2 L X+2\n3 END PGM A MM", "heidenhain", (3, 1)),
        ("G21 F100\nG1 X[1/2] (/G1 X2.)\nM30", "fanuc", None),
    ],
)
def test_the_first_block_left_out_is_noted(
    run: Callable[..., Outcome], text: str, dialect: str, place: tuple[int, int] | None
) -> None:
    """A control runs it unless its switch is on, and a whole way may stand in such blocks."""
    for left_out in (True, False):
        found = run(text, dialect=dialect, block_delete=left_out).diagnostics
        places = [(d.span.line, d.span.column) for d in found if d.code == "blocks-left-out" and d.span]
        assert places == ([place] if place and left_out else [])


@pytest.mark.parametrize(("block", "column"), [("/G1 X2", 1), (" N10 /G1 X2", 6), ("G1 X[1/2]", None)])
def test_the_first_block_left_out_is_noted_behind_many_divisions(
    run: Callable[..., Outcome], block: str, column: int | None
) -> None:
    text = "G21 F100\n" + "G1 X[1/2]\n" * 3000 + block + "\nM2\n"
    places = [
        (d.span.line, d.span.column) for d in run(text).diagnostics if d.code == "blocks-left-out" and d.span
    ]
    assert places == ([(3002, column)] if column else [])


@pytest.mark.parametrize("sign", ["/", ";G1 X1 "])
def test_signs_in_a_comment_are_not_looked_at_one_by_one(run: Callable[..., Outcome], sign: str) -> None:
    """Each of them was followed back to the start of its line: this took a minute and more."""
    begin = time.process_time()
    run(f"G21 G1 X1 F100 ({sign * (2_000_000 // len(sign))})\n/ X2\nM2\n", dialect="fanuc")
    assert time.process_time() - begin < 10.0


@pytest.mark.parametrize(
    ("block", "column"),
    [("<SHAFT_T12> (MAIN)", None), ("M98 <GROOVE_T3>", None), ("M98 <GROOVE_T3> T4", 17), ("T4 M6", 1)],
)
def test_a_word_within_the_name_of_a_program_is_none(
    run: Callable[..., Outcome], block: str, column: int | None
) -> None:
    """T12 of a name was taken for a tool of two digits."""
    text = f"O1\nG21 G99\nT0101\n{block}\nM30\n<GROOVE_T3>\nM99\n"
    found = run(text, dialect="fanuc-lathe").diagnostics
    assert [d.span.column for d in found if d.code == "other-control" and d.span] == (
        [column] if column else []
    )
