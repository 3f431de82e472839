"""What posts and old programs in plain language have: tilted planes, oversizes, tool names, cycles in parts, CALL PGM.

Levels of the cycles are those of the TNC 426 and TNC 640 manuals, worked out by hand.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.machine.kinematics import Kinematics

from .test_heidenhain_programs import ends, outcome

PECK = "CYCL DEF 1.0 PECKING\nCYCL DEF 1.1 SETUP 2\nCYCL DEF 1.2 DEPTH -10\nCYCL DEF 1.3 PECKG 4\nCYCL DEF 1.4 DWELL 0.5\nCYCL DEF 1.5 F100\n"

#: Program, and where its motions end. Tool 1 has the radius 2 and no length.
MOTIONS: dict[str, tuple[str, list[tuple[float, ...]]]] = {
    "a tool's name": ('TOOL CALL "FRAES10" Z S500 DL+0 DR+0\nL X+1 FMAX', [(1,)]),
    "the normal of a surface": ("LN X+1 Y-2 Z+3 NX+0.1 NY-0,2 NZ.97 F100\nLN X+2 NX0 NY0 NZ1", [(1, -2, 3), (2, -2, 3)]),
    "a length oversize": ("TOOL CALL 1 Z S500 DL+1.5\nL Z+0 FMAX\nTOOL CALL 1 Z S500\nL Z+0 FMAX", [(0, 0, 1.5), (0, 0, 0)]),
    "a radius oversize": ("TOOL CALL 1 Z S500 DR+0.5 DL+0\nL X+0 Y+0 Z-1 F100\nL X+10 RR\nL X+20", [(0, 0, -1), (10, -2.5, -1), (20, -2.5, -1)]),
    "M92": ("L Z+5 FMAX M92", [(0, 0, 5)]),
    "STOP with M1": ("STOP M1\nL X+1 FMAX", [(1,)]),
    "looking ahead": ("L X+1 F100 M120 LA5\nL X+2 F", [(1,), (2,)]),
    "numbered remarks": ("1 ;\n2 ; made by hand\nN3;\n4\n5 L X+1 FMAX", [(1,)]),
    "two remarks": ("L Z+5 FMAX M92 M109", [(0, 0, 5)]),
    "no blanks": ("CYCL DEF7.0 NULLPUNKT\nCYCL DEF7.1 X+5\nL X+1 FMAX", [(6,)]),
    "a plane that is reset": ("PLANE RESET STAY\nPLANE SPATIAL SPA+0 SPB+0 SPC+0 STAY SEQ+ TABLE ROT\nL X+1 FMAX", [(1,)]),
    "a plane turned about X": ("PLANE SPATIAL SPA+90 SPB+0 SPC+0 MOVE DIST50 F2000\nL X+1 Y+2 Z+3 FMAX", [(1, -3, 2)]),
    "a plane turned about X, then Z": ("PLANE SPATIAL SPA+90 SPB+0 SPC+90 STAY\nL X+1 Y+2 Z+3 FMAX", [(3, 1, 2)]),
    "cycle 19": ("CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+0 B+90 C+0\nL X+1 Y+2 Z+3 FMAX", [(3, 2, -1)]),
    "cycle 19 behind a shift": ("CYCL DEF 7.0\nCYCL DEF 7.1 X+10\nCYCL DEF 19.0\nCYCL DEF 19.1 A+0 B+90 C+0\nL X+1 Y+0 Z+3 FMAX\nCYCL DEF 19.0\nCYCL DEF 19.1\nL X+1 Z+3 FMAX",
                                [(13, 0, -1), (11, 0, 3)]),
    "functions": ("FUNCTION MODE MILL\nFUNCTION RESET TCPM\nL X+1 FMAX", [(1,)]),
    "cycle 1": (f"{PECK}L Z+2 FMAX\nL X+5 FMAX M99", [(0, 0, 2), (5, 0, 2), (5, 0, -4), (5, 0, 2), (5, 0, -3.4), (5, 0, -8), (5, 0, 2), (5, 0, -7.4), (5, 0, -10), (5, 0, 2)]),
    "cycle 2": ("CYCL DEF 2.0 TAPPING\nCYCL DEF 2.1 SETUP 2\nCYCL DEF 2.2 DEPTH -8\nCYCL DEF 2.3 DWELL 0\nCYCL DEF 2.4 F100\nL Z+2 FMAX M3\nCYCL CALL",
                [(0, 0, 2), (0, 0, -8), (0, 0, 2)]),
    "cycle 17": ("CYCL DEF 17.0 RIGID TAPPING\nCYCL DEF 17.1 SETUP 2\nCYCL DEF 17.2 DEPTH -8\nCYCL DEF 17.3 PITCH +1\nL Z+2 FMAX M3\nCYCL CALL",
                 [(0, 0, 2), (0, 0, -8), (0, 0, 2)]),
    "206": ("CYCL DEF 206 TAPPING ~\n Q200=2 ~\n Q201=-8 ~\n Q206=150 ~\n Q211=0 ~\n Q203=0 ~\n Q204=20\nM3\nCYCL CALL", [(0, 0, 2), (0, 0, -8), (0, 0, 2), (0, 0, 20)]),
    "209": ("CYCL DEF 209 TAPPING ~\n Q200=2 ~\n Q201=-8 ~\n Q239=1 ~\n Q203=0 ~\n Q204=20 ~\n Q257=5 ~\n Q256=1\nM3\nCYCL CALL",
            [(0, 0, 2), (0, 0, -5), (0, 0, -4), (0, 0, -8), (0, 0, 2), (0, 0, 20)]),
    "200 in one line": ("CYCL DEF 200 DRILLING Q200=2 Q201=-15 Q206=150 Q202=20 Q210=0 Q203=+0 Q204=50 Q211=0\nCYCL CALL",
                        [(0, 0, 2), (0, 0, -15), (0, 0, 50)]),
    "200 in lines of several": ("CYCL DEF 200 DRILLING ~\n Q200=2 Q201=-15 Q206=150 ~\n Q202=20 Q210=0 Q203=+0 Q204=50 Q211=0\nCYCL CALL",
                                [(0, 0, 2), (0, 0, -15), (0, 0, 50)]),
    "240": ("CYCL DEF 240 CENTERING ~\n Q200=2 ~\n Q343=0 ~\n Q201=-1 ~\n Q344=-5 ~\n Q206=150 ~\n Q211=0 ~\n Q203=0 ~\n Q204=20\nCYCL CALL",
            [(0, 0, 2), (0, 0, -1), (0, 0, 2), (0, 0, 20)]),
}  # fmt: skip


@pytest.mark.parametrize("name", MOTIONS)
def test_motions(run: Any, tmp_path: Path, name: str) -> None:
    text, expected = MOTIONS[name]
    out = outcome(run, tmp_path, text)
    assert out.errors == []
    assert ends(out.path.end[out.path.kind < 3][:, :3]) == ends(expected)


@pytest.mark.parametrize(
    ("text", "seconds"),
    [("9.0 DWELL\nCYCL DEF 9.1 DWELL 0.5", 0.5), ("9.0 VERWEILZEIT\nCYCL DEF 9.1 V.ZEIT 1.25", 1.25), ("9 .0 IDO\nCYCL DEF9.1 V.IDO5", 5.0),
     ("9.0 CZAS\nCYCL DEF 9.1 CZAS POST. 1.5", 1.5), ("9.0 IDŐ\nCYCL DEF 9.1 VÁRAKOZÁSI IDŐ.75", 0.75),
     ("9.0 PRZERWA CZASOWA\nCYCL DEF 9.1 CZAS ZWL.0.5", 0.5), ("9.0 DWELL\nCYCL DEF 9.1 V. ZEIT. 2", 2.0)],
)  # fmt: skip
def test_a_dwell_keeps_its_decimals(calls: Any, text: str, seconds: float) -> None:
    definition = f"CYCL DEF{text}" if text[1] == " " else f"CYCL DEF {text}"
    found = calls(f"0 BEGIN PGM T MM\n{definition}\nEND PGM T MM\n")
    assert [line for line in found if "DWELL" in line] == [f"DWELL({seconds:.4f})"]


WRONG: dict[str, tuple[str, tuple[str, int]]] = {
    "untilted points": ("L X+1 FMAX M130", ("unsupported-block", 3)),
    "a plane by vectors": ("PLANE VECTOR BX0 BY0 BZ1 NX0 NY0 NZ1 STAY", ("plane-points", 3)),
    "a program that is missing": ("CALL PGM NOWHERE", ("sub-missing", 3)),
    "a cycle without a part": ("CYCL DEF 1.0 PECKING\nCYCL DEF 1.1 SETUP 2\nCYCL CALL", ("cycle-words", 5)),
    "a diameter that is missing": ("CYCL DEF 240 CENTERING ~\n Q343=1 ~\n Q206=100 ~\n Q344=0\nCYCL CALL", ("cycle-words", 7)),
    "a start below the bottom": ("CYCL DEF 205 PECK ~\n Q200=2 ~\n Q201=-10 ~\n Q206=100 ~\n Q253=500 ~\n Q379=12\nCYCL CALL", ("cycle-words", 9)),
    "a slot without an angle": ("CYCL DEF 254 SLOT ~\n Q200=2 ~\n Q201=-5 ~\n Q206=100 ~\n Q207=100 ~\n Q219=12 ~\n Q375=60 ~\n Q248=0\nCYCL CALL",
        ("cycle-words", 11)),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_named_where_it_stands(run: Any, tmp_path: Path, name: str) -> None:
    text, (code, line) = WRONG[name]
    out = outcome(run, tmp_path, text)
    assert out.errors[0][:2] == (code, line)
    assert next(d for d in out.diagnostics if d.severity == "error").hint


def test_probing_is_passed_over_with_a_warning(run: Any, moves: Any, tmp_path: Path) -> None:
    probing = "TCH PROBE 412 DATUM INSIDE CIRCLE ~\n Q321=+0 ;CENTER ~\n Q262=+40 ;DIAMETER\nTCH PROBE 3.0 MEASURING\nTCH PROBE 3.1 Q1"
    out = outcome(run, tmp_path, f"L X+1 Y+2 FMAX\n{probing}\nL X+3 F100")
    assert out.errors == []
    assert [(d.code, d.severity) for d in out.diagnostics if d.code == "probe-not-run"] == [
        ("probe-not-run", "warning")
    ]
    text = f"0 BEGIN PGM T MM\nL X+1 Y+2 FMAX\n{probing}\nL X+3 F100\nEND PGM T MM\n"
    assert moves(text) == [(1, 2, 0, 0), (3, 2, 0, 100)]


def test_a_tilted_plane_and_m92_are_warned_of(run: Any, tmp_path: Path) -> None:
    out = outcome(run, tmp_path, "PLANE SPATIAL SPA+90 SPB+0 SPC+0 STAY\nL Z+5 FMAX M92")
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["swivel-frame", "builders-point"]


def test_a_program_calls_another_one_with_labels_of_its_own(run: Any, tmp_path: Path) -> None:
    (tmp_path / "SUB.H").write_text(
        "0 BEGIN PGM SUB MM\n1 LBL 1\n2 L IX+1 FMAX\n3 CALL LBL 1 REP 1\n4 END PGM SUB MM\n"
    )
    out = outcome(run, tmp_path, "LBL 1\nCALL PGM SUB\nL IY+5 FMAX\nCALL LBL 1 REP 1", include=(tmp_path,))
    assert out.errors == []
    assert ends(out.path.end[out.path.kind < 3][:, :2]) == ends(
        [(1, 0), (2, 0), (2, 5), (3, 5), (4, 5), (4, 10)]
    )


@pytest.mark.parametrize(
    ("calls", "expected"),
    [
        # Cycle 12 (iTNC 530, user's manual, 8.9): the program is a cycle, which M99 and CYCL CALL run from where the tool is.
        ("CYCL DEF 12.0 PGM CALL\nCYCL DEF 12.1 PGM TNC:\\KLAR35\\SUB.H\nL Y+5 FMAX M99\nL Y+9 FMAX\nCYCL CALL",
         [(0, 5), (1, 5), (1, 9), (2, 9)]),
        ("CYCL DEF 12.0 PGM CALL\nCYCL DEF 12.1 SUB\nCYCL CALL POS X+3 Y+4", [(3, 4), (4, 4)]),
        ('SEL PGM "SUB.H"\nCALL SELECTED PGM\nL Y+2 FMAX\nCALL SELECTED PGM', [(1,), (1, 2), (2, 2)]),
    ],
)  # fmt: skip
def test_a_program_is_called_that_is_named_before(
    run: Any, tmp_path: Path, calls: str, expected: list[tuple[float, ...]]
) -> None:
    (tmp_path / "SUB.H").write_text("0 BEGIN PGM SUB MM\n1 L IX+1 FMAX\n2 END PGM SUB MM\n")
    out = outcome(run, tmp_path, calls, include=(tmp_path,))
    assert out.errors == []
    assert ends(out.path.end[out.path.kind < 3][:, :2]) == ends(expected)


@pytest.mark.parametrize(
    ("calls", "code"),
    [
        ("CALL SELECTED PGM", "sub-missing"),
        ("CYCL DEF 12.0 PGM CALL\nCYCL DEF 12.1 PGM NOWHERE\nCYCL CALL", "sub-missing"),
        ("CYCL DEF 12.0 PGM CALL\nCYCL CALL", "sub-missing"),
        ("CYCL DEF 12.0 PGM CALL\nCYCL DEF 12.1 PGM SUB\nL X+1 FMAX M89", "unsupported-block"),
    ],
)
def test_a_program_that_is_not_there(run: Any, tmp_path: Path, calls: str, code: str) -> None:
    assert outcome(run, tmp_path, calls).errors[0][0] == code


def test_a_program_of_cycle_12_has_its_columns(run: Any, tmp_path: Path) -> None:
    (tmp_path / "SUB.H").write_text("0 BEGIN PGM SUB MM\n1 L IC+10 FMAX\n2 END PGM SUB MM\n")
    text = "CYCL DEF 12.0 PGM CALL\nCYCL DEF 12.1 PGM SUB\nL X+5 FMAX M99"
    assert outcome(run, tmp_path, text, include=(tmp_path,)).moving_axes == "XYZC"


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("0 BEGIN PGM T INCH\n1 L X+1 F10\n", "feed-inch"),
        ("0 BEGIN PGM T MM\n1 L X+1 F10 M116\n", "feed-function"),
        ("0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S2000\n2 L X+1 FZ0.05\n", "feed-teeth"),
    ],
)
def test_a_feed_that_may_mean_another_one_is_warned_of(run: Any, text: str, code: str) -> None:
    found = [d.code for d in run(f"{text}2 END PGM T MM\n").diagnostics if d.severity == "warning"]
    assert code in found


def test_a_feed_of_each_tooth_is_that_of_one(moves: Any) -> None:
    """FZ0.05 at 2000 turns a minute, of a tool with one tooth, is 100 mm a minute."""
    text = "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S2000\n2 L X+1 FZ0.05\n3 L X+2 FU0.2\n4 END PGM T MM\n"
    assert [move[3] for move in moves(text)] == [100, 400]


def test_a_normal_is_doubted_beside_oversizes_alone(run: Any, tmp_path: Path) -> None:
    line = "LN X+1 NX0 NY0 NZ1 F100"
    for sizes, said in (("DL+0", []), ("DL+0.2", ["surface-normal"])):
        out = outcome(run, tmp_path, f"TOOL CALL 1 Z S500 {sizes}\n{line}\n{line}")
        assert [d.code for d in out.diagnostics if d.severity == "warning"] == said


def test_a_tool_is_found_by_the_remark_of_the_table(run: Any, tmp_path: Path) -> None:
    (tmp_path / "t.tbl").write_text("T7 P7 D8 Z20 ;FRAES8\n")
    text = '0 BEGIN PGM T MM\n1 TOOL CALL "{}" Z S500\n2 L X+1 Z+0 FMAX\n3 TOOL CALL "B" Z\n4 END PGM T MM\n'
    ends_of = {}
    for name in ("Fraes8", "A"):
        out = run(text.format(name), tool_table=tmp_path / "t.tbl")
        ends_of[name] = (
            out.path.end[out.path.kind < 3][-1, 2],
            [d.span.line for d in out.diagnostics if d.code == "tool-name"],
        )
    assert ends_of == {"Fraes8": (20.0, [4]), "A": (0.0, [2])}


@pytest.mark.parametrize(
    ("function", "inside", "outside"),
    [("", 100, 100), (" M109", 60, 140), (" M110", 60, 100), (" M109 M110", 60, 100)],
)
def test_the_feed_of_the_cutting_edge(calls: Any, function: str, inside: float, outside: float) -> None:
    """iTNC 530, "Feed rate for circular arcs: M109/M110/M111": on arcs of radius 10 a tool of radius 4 has 0.6 of F inside, 1.4 outside."""
    for side, feed in (("RL", inside), ("RR", outside)):
        first = "".join(f"L{word}\n" for word in function.split())
        text = f"""BEGIN PGM T MM
TOOL DEF 1 L+0 R+4
TOOL CALL 1 Z S1000
L X-20 Y-30 Z+0 R0 FMAX
{first.replace("L", "L ")}L X+0 Y-10 {side} F100
L X+10
CR X+20 Y+0 R+10 DR+
L Y+30
L X+25 M111
CR X+35 Y+40 R+10 DR+
L Y+50
L X+50 Y+70 R0
END PGM T MM
"""
        feeds = [float(line[14:-1]) for line in calls(text) if line.startswith("SET_FEED_RATE(")]
        assert feeds[:-1] == ([100] if feed == 100 else [100, feed, 100])


@pytest.mark.parametrize(
    ("start", "way"),
    [("L X+1 Y+1 Z+50 FMAX", [(5, 0, 50), (5, 0, 14), (5, 0, 7)]), ("L X+1 Y+1 Z-9 FMAX", [(1, 1, 14), (5, 0, 14), (5, 0, 7)])],
)  # fmt: skip
def test_the_place_of_a_cycle_shifts_it(run: Any, start: str, way: list[tuple[float, ...]]) -> None:
    """iTNC 530, "Calling a cycle with CYCL CALL POS": its tool axis is an additional shift; from above the tool goes in the plane first,
    from below along its axis first. The surface is 10 + 2 here, the clearance 2 above it, the bottom 5 below."""
    text = f"""0 BEGIN PGM T MM
1 TOOL CALL 1 Z S1000
2 {start}
3 CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=100 Q202=5 Q210=0 Q203=+10 Q204=20 Q211=0
4 CYCL CALL POS X+5 Y+0 Z+2 FMAX
5 L X+6 FMAX M99
6 END PGM T MM
"""
    out = run(text)
    assert out.errors == []
    ends = [tuple(end) for end in out.path.end[out.path.kind != 3, :3].tolist()]
    assert ends[1:4] == way
    assert min(z for x, _, z in ends if x == 6) == 5


def test_a_feed_of_a_cycle_without_its_sign(run: Any) -> None:
    """Q206 FAUTO, as programs written by hand have it, is Q206=FAUTO: the feed of TOOL CALL."""
    text = """BEGIN PGM A MM
TOOL CALL 1 Z S1000 F300
CYCL DEF 200 ;Bohren
Q200=+2
Q201=-4
Q206 FAUTO ;Vorschub
Q202=+5
Q210=+0
Q203=+0
Q204=+50
Q211=+0
L X+1 Y+0 FMAX M99
END PGM A MM
"""
    out, same = run(text), run(text.replace("Q206 FAUTO", "Q206=FAUTO"))
    assert out.errors == same.errors == []
    # So do those whose lines go on behind ~, in which it was taken as the rest of the line above.
    begin, end = text.index("Q200"), text.index("L X+1")
    joined = run(
        text[:begin].rstrip() + " ~\n" + text[begin:end].rstrip().replace("\n", " ~\n") + "\n" + text[end:]
    )
    assert joined.errors == []
    assert [e.tolist() for e in joined.path.end] == [e.tolist() for e in same.path.end]
    assert 5.0 in out.path.feed.tolist()
    assert [e.tolist() for e in out.path.end] == [e.tolist() for e in same.path.end]


@pytest.mark.parametrize(
    ("block", "message"),
    [
        ('SEL CONTOUR "TNC:\\\\C.HC"', "SEL CONTOUR is not read"),
        ("CALL FOO", "CALL FOO is not read"),
        ("Q1 = STRLEN ( SRC_QS2 )", "STRLEN, a function of texts, is not read"),
    ],
)
def test_what_is_not_read_is_named(run: Any, block: str, message: str) -> None:
    """TNC 640, 34059x, "SL Cycles with complex contour formula" and "Determining the length of a string"; both were faults of syntax."""
    found = run(f"0 BEGIN PGM T MM\n1 {block}\n2 END PGM T MM", dialect="heidenhain")
    error = next(one for one in found.diagnostics if one.severity == "error")
    assert (error.code, error.message) == ("unsupported-block", message)


def rotary(run: Any, body: str, **options: Any) -> list[float]:
    """Return where C stands behind each motion, degrees."""
    found = run(f"0 BEGIN PGM T MM\n{body}\nEND PGM T MM", dialect="heidenhain", **options)
    assert found.errors == []
    return np.degrees(found.path.end[found.path.kind != 3, -1]).round(6).tolist()  # type: ignore[no-any-return]


@pytest.mark.parametrize(("block", "goal"), [("M94", 540), ("L M94 C", 540), ("L M94 A", 180), ("L X+1 M94 C R0 FMAX", 540)])  # fmt: skip
def test_m94_counts_a_rotary_axis_from_0_again(run: Any, block: str, goal: float) -> None:
    """The manual's example: from 538 to 180 the axis goes -358 degrees, behind M94 from 178 to 180, 2 (TNC 640, 34059x, "Reducing display
    of a rotary axis to a value less than 360 degrees: M94")."""
    assert rotary(run, f"L X+0 A+0 C+538 R0 FMAX\n{block}\nL C+180 FMAX")[-1] == goal


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("L C+350 FMAX\nM126\nL C+10 FMAX", [350, 370]),
        ("L C+10 FMAX M126\nL C+340 FMAX", [10, -20]),
        ("L C+350 FMAX\nL C+10 FMAX M126\nL IC+5 FMAX\nL C+20 FMAX M127\nL C+350 FMAX\nL C+30 FMAX", [350, 370, 375, 380, 710, 390]),
    ],
)  # fmt: skip
def test_rotary_axes_go_the_shorter_way(run: Any, body: str, expected: list[float]) -> None:
    """The manual's table: from 350 to 10 the axis goes +20 degrees, from 10 to 340 -30 (TNC 640, "Shortest-path traverse of rotary axes: M126");
    behind M127 from what is displayed to what is programmed."""
    assert rotary(run, body) == expected
    if len(expected) == 2:
        many = "\n".join(f"L C+{angle % 360} F500" for angle in range(0, 3600, 100))
        assert rotary(run, f"M126\n{many}")[-1] == 3500


def test_the_axis_that_tilts_goes_its_way(run: Any) -> None:
    """A of a trunnion is bounded: from 100 to -100 is no way over 180."""
    table = Kinematics(0, (3, 5), (0.0, 0.0, -100.0))
    body = "0 BEGIN PGM T MM\nL A+100 C+350 FMAX\nL A-100 C+10 FMAX M126\nEND PGM T MM"
    found = run(body, dialect="heidenhain", kinematics=table)
    assert np.degrees(found.path.end[-1, 3:]).round(6).tolist() == [-100, 370]
    assert [one.code for one in found.diagnostics if one.code == "rotary-display"] == ["rotary-display"]


def test_motions_of_a_cycle_stand_in_the_program_that_calls_it(run: Any, tmp_path: Path) -> None:
    """The hole is drilled in line 3 of the called program, whose index among the sources is 1."""
    (tmp_path / "SUB.H").write_text(
        "0 BEGIN PGM SUB MM\n1 CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=150 Q202=5 Q210=0 Q203=0 Q204=50 Q211=0\n"
        "2 L X+10 R0 FMAX M99\n3 END PGM SUB MM\n"
    )
    text = "0 BEGIN PGM MAIN MM\n1 TOOL CALL 1 Z S1000 F500\n2 L Z+50 R0 FMAX\n3 CALL PGM SUB\n4 L Z+99 R0 FMAX M30\n5 END PGM MAIN MM\n"
    path = run(text, dialect="heidenhain", include=(tmp_path,)).path
    moves = path.kind < 3
    places = [
        *zip(path.source[moves].tolist(), path.line[moves].tolist(), path.end[moves, 2].tolist(), strict=True)
    ]
    assert places == [(0, 3, 50.0), (1, 3, 50.0), (1, 3, 2.0), (1, 3, -5.0), (1, 3, 50.0), (0, 5, 99.0)]


@pytest.mark.parametrize(
    ("factor", "out"), [("", 1250.0), (" ~\n Q403=1.5", 1875.0), (" ~\n Q403=0.5", 625.0)]
)
def test_a_tap_comes_out_faster(moves: Any, factor: str, out: float) -> None:
    """Q403 multiplies the speed of the spindle on the way out of the hole, and the feed with it (cycle 209): 1000 * 1.25 in, times Q403 out."""
    text = (
        "BEGIN PGM T MM\nTOOL CALL 1 Z S1000\nM3\nCYCL DEF 209 TAPPING ~\n Q200=2 ~\n Q201=-8 ~\n Q239=1.25 ~\n Q203=0 ~\n Q204=20 ~\n Q257=5 ~\n Q256=1"
        f"{factor}\nCYCL CALL\nM30\nEND PGM T MM\n"
    )
    assert [move[2:] for move in moves(text)][1:] == [(-5, 1250), (-4, 1250), (-8, 1250), (2, out), (20, 0)]


@pytest.mark.parametrize(("unit", "there"), [("MM", 10.0), ("INCH", 254.0)])
def test_a_called_program_has_its_own_unit_and_keeps_the_feed(
    run: Any, tmp_path: Path, unit: str, there: float
) -> None:
    """TNC 640, "Tool-related data": "A feed rate entered as a numerical value remains in effect until a block with a different feed rate is
    reached"; MM and INCH are of the program that BEGIN PGM begins. Worked out by hand: 10 inches are 254 mm."""
    (tmp_path / "SUB.H").write_text(f"0 BEGIN PGM SUB {unit}\n1 L X+10\n2 END PGM SUB {unit}\n")
    text = "0 BEGIN PGM MAIN MM\n1 TOOL CALL 1 Z S1000\n2 CC X+20 Y+0\n3 L X+5 F300\n4 CALL PGM SUB\n5 L X+50\n6 LP PR+1 PA+0\n7 END PGM MAIN MM\n"
    out = run(text, include=(tmp_path,))
    assert out.errors == []
    moves = out.path.kind != 3
    assert out.path.end[moves, 0].tolist() == pytest.approx([5.0, there, 50.0, 21.0])
    assert out.path.feed[moves].tolist() == pytest.approx([300.0 / 60.0] * 4)


def test_local_parameters_are_those_of_one_program(run: Any, tmp_path: Path) -> None:
    """TNC 640, ISO programming 3/2014, "Principle and overview of functions": "Local parameters QL are only effective within the respective
    program, and are not applied as part of program calls"; Q is global."""
    (tmp_path / "SUB.H").write_text(
        "0 BEGIN PGM SUB MM\n1 L X+QL1 Y+Q5 FMAX\n2 QL1 = 7\n3 Q5 = 9\n4 END PGM SUB MM\n"
    )
    text = "0 BEGIN PGM M MM\n1 TOOL CALL 1 Z S1000\n2 QL1 = 5\n3 Q5 = 1\n4 CALL PGM SUB\n5 CALL PGM SUB\n6 L X+QL1 Y+Q5 FMAX\n7 END PGM M MM\n"
    path = run(text, include=(tmp_path,)).path
    assert path.end[path.kind < 3][:, :2].tolist() == [[0, 1], [0, 9], [5, 9]]


def test_a_program_that_is_called_and_ends_with_m30_is_told(run: Any, tmp_path: Path) -> None:
    """iTNC 530, "Separate program as subprogram": "The called program must not contain the miscellaneous functions M2 or M30"."""
    for last, codes in (("", []), ("M30\n", ["called-end"])):
        (tmp_path / "SUB.H").write_text(f"0 BEGIN PGM SUB MM\n1 L X+1 FMAX\n{last}9 END PGM SUB MM\n")
        out = run(
            "0 BEGIN PGM M MM\n1 CALL PGM SUB\n2 L X+2 FMAX\n3 M30\n4 END PGM M MM\n", include=(tmp_path,)
        )
        assert [d.code for d in out.diagnostics if d.severity == "warning"] == codes
        assert out.path.end[out.path.kind < 3][:, 0].tolist() == [1, 2]
