"""What FANUC's programs get wrong, each with its place; and motions that frames carry which no cycle makes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from cncgen.gcode.text.search import candidates, search_path
from cncgen.toolpath.record import Kind

from .conftest import Outcome

Run = Callable[..., Outcome]

WRONG = {
    "a G10 of nothing": ("G10 P1 X1", ("g10-words", 1, 1)),
    "a G10 of something else": ("G10 L4 P1 X1", ("g10-words", 1, 5)),
    "a G10 of no one": ("G10 L2 X1", ("g10-words", 1, 1)),
    "a system that is none": ("G10 L2 P7 X1", ("g10-words", 1, 8)),
    "a tool's length without value": ("G10 L10 P1", ("g10-words", 1, 1)),
    "a system beyond the last": ("G54.1 P999", ("system-number", 1, 7)),
    "a local system of no axis": ("G52", ("axis-missing", 1, 1)),
    "a negative bound of the speed": ("G92 S-5", ("negative-speed", 1, 5)),
    "a negative bound in G96": ("G96 S100 D-5", ("negative-speed", 1, 10)),
    "a dwell backwards": ("G4 X-1", ("dwell-time", 1, 4)),
    "back without a way there": ("G29 X1", ("reference-point", 1, 1)),
    "back in no axis": ("G28 X1\nG29", ("axis-missing", 2, 1)),
    "a fifth reference point": ("G30 P5 X1", ("reference-point", 1, 5)),
    "a skip in no axis": ("F10\nG31", ("axis-missing", 2, 1)),
    "a skip under compensation": ("F10\nG41.1 D1\nG1 X9\nG31 X12", ("comp-refused", 4, 1)),
    "a frame under compensation": ("F10\nG41.1 D1\nG1 X9\nG68 X0 Y0 R30", ("frame-compensation", 4, 1)),
    "a corner at a point": ("F10\nG1 X9 ,R1\nX9\nX20", ("corner-size", 2, 7)),
    "a corner larger than its arc": ("F10\nG2 X2 R1 ,C5\nG1 X9", ("corner-size", 2, 10)),
    "a corner before a wrong arc": ("F10\nG1 X9 ,R1\nG2 X3 J1 R0.1", ("corner-next", 2, 7)),
    "a negative corner": ("F10\nG1 X9 ,R-1\nY4", ("corner-size", 2, 7)),
    "a pitch of no thread": ("S10 M3\nG33 Z-5 F0", ("pitch-missing", 2, 9)),
    "a spline of LinuxCNC": ("G0 X0\nG5 P1 Q2 X3 Y4", ("other-control", 2, 10)),
    "a rotation of LinuxCNC's G10": ("G10 L2 P1 X5 R30", ("g10-words", 1, 14)),
    "a place beside a length": ("G10 L10 P1 R5 X3", ("g10-words", 1, 15)),
    "Q beside a radius": ("G10 L12 P1 R5 Q1", ("g10-words", 1, 15)),
    "a turn in a plane of U V W": ("G17.1\nG68 X0 R5", ("rotation-plane", 2, 1)),
    "a weight of BSPLINE": ("F10\nBSPLINE X1 PW=-1", ("nurbs-weight", 2, 12)),
    "a length of BSPLINE": ("F10\nBSPLINE X1 PL=-1", ("nurbs-knot", 2, 12)),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_named_where_it_stands(run: Run, name: str) -> None:
    text, expected = WRONG[name]
    found = run(f"{text}\nG40 G0 X50\nM30", dialect="fanuc")
    assert found.errors[0] == expected
    assert all(d.hint for d in found.diagnostics)


def test_a_tool_of_no_table_has_no_length_to_set(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 Z10\n")
    found = run("G10 L10 P5 R3\nG10 L10 P1 R12\nG43 H1\nG0 Z0\nM30", dialect="fanuc", tool_table=table)
    assert found.errors == [("unknown-tool", 1, 9)]
    assert found.path.end[-1, 2] == 12


def test_a_skip_and_a_tap_go_with_the_frame(run: Run) -> None:
    """Turned by 90 degrees and mirrored, X leads along Y; taps go along Z as ever."""
    turned = "F100 S100 M3\nG68 X0 Y0 R90\n"
    skip = run(f"{turned}G31 X5\nM30", dialect="fanuc").path
    assert skip.end[-2, :2].round(9).tolist() == [0, 5]
    tap = run(f"{turned}G0 X5\nG33.1 Z-3 K1\nM30", dialect="fanuc").path
    ends = tap.end[tap.kind != 3][:, :3].round(9).tolist()
    assert ends == [[0, 5, 0], [0, 5, -3], [0, 5, 0]]
    mirrored = run("F100\nG51.1 X0\nG31 X5\nM30", dialect="fanuc").path
    assert mirrored.end[-2, 0] == -5


def test_codes_without_axes_put_a_motion_in_force(run: Run) -> None:
    thread = run("S60 M3\nG33 F2\nZ-4\nM30", dialect="fanuc")
    assert thread.errors == []
    assert thread.path.feed[thread.path.kind != 3].tolist() == [2.0]
    tap = run("S60 M3\nG33.1\nG0 X1\nM30", dialect="fanuc")
    assert tap.errors == []
    box = "S60 M3 G97\nG0 X20. Z2.\nG90 F.1\nX10. Z-5.\nM30"
    assert run(box, dialect="fanuc-lathe").path.end[-2, [0, 2]].tolist() == [10, 2]


def test_names_of_files_that_no_folder_has(tmp_path: Path) -> None:
    assert candidates(tmp_path / "none", "o100") == []
    assert candidates(tmp_path, "x" * 5000) == []
    assert candidates(tmp_path, "a\0b") == []
    (tmp_path / "O0100.NGC").write_text("M2\n")
    # A folder is listed once a run, which begins by this.
    search_path(None, ())
    assert [path.name for path in candidates(tmp_path, "o0100")] == ["O0100.NGC"]


def test_the_file_of_a_program_may_leave_out_its_o_and_zeros(tmp_path: Path, run: Run) -> None:
    names = ("O0012.TXT", "O12", "0012.nc", "12.cnc", "O120.nc", "12.pdf")
    for name in names:
        (tmp_path / name).write_text("O12\nG0 X3\nM99\n")
    assert [path.name for path in candidates(tmp_path, "O0012")] == list(names[:4])
    assert candidates(tmp_path, "a12") == []
    called = run("M98 P12\nM30", dialect="fanuc", include=(tmp_path,))
    assert called.errors == []
    assert called.path.end[0, 0] == 3.0


@pytest.mark.parametrize(
    ("block", "end", "column"),
    [
        ("G90 G91 G0 X1", [2, 0, 0], 1),
        ("G0 G1 X5 F100", [5, 0, 0], 1),
        ("N5 G54 G0 G55 X3", [10, 0, 0], 4),
        ("G28 G91 Z0. G90", [1, 0, 0], 5),
        ("G17 G18 G2 X2 Z1 I1 K0 F9", [2, 0, 1], 1),
    ],
)
def test_of_two_codes_of_a_group_the_last_one_counts(
    run: Run, block: str, end: list[float], column: int
) -> None:
    """B-63944EN, 3; on lathes, where G90 is a cycle, and in LinuxCNC it is an error."""
    out = run(f"#5241=7\nG0 X1\n{block}\nM30", dialect="fanuc")
    assert out.errors == []
    assert out.path.end[-1, :3].round(9).tolist() == end
    places = [(d.code, d.severity, d.span.line, d.span.column) for d in out.diagnostics if d.span]
    assert places == [("modal-conflict", "warning", 3, column)]
    for dialect in ("fanuc-lathe", "linuxcnc"):
        codes = [code for code, line, _ in run(f"G0 X1\n{block}\nM30", dialect=dialect).errors if line == 2]
        assert codes


def test_rows_of_holes_of_haas_are_not_taken_for_a_lathe(run: Run) -> None:
    """On a mill this is a pattern of holes: sending the programmer to the dialect of lathes leads astray.

    Haas (Mill Operator's Manual, G72): I, J and L, no K.
    """
    text = "G81 Z-5. R2. F100. L0\nG72 I50. J30. K30. L3\nG80\nM30"
    found = run(text, dialect="fanuc").diagnostics
    (fault,) = [d for d in found if d.severity == "error"]
    assert (fault.code, fault.message, fault.hint) == ("cycle-words", "G72 has a word K", "G72 I5. J30. L4")


def test_a_cycle_of_lathes_on_a_mill(run: Run) -> None:
    """G70 P Q finishes a profile: on a mill it would be a circle of holes."""
    found = run("G21 G0 X1\nG70 P10 Q20\nM30", dialect="fanuc").diagnostics
    (fault,) = [d for d in found if d.severity == "error"]
    assert (fault.code, "fanuc-lathe" in fault.hint) == ("cycle-missing", True)


@pytest.mark.parametrize("comment", ["(POCKET (ROUGH))", "( HOLE AT (61.0, 67.7) )", "(A (B (C) D) E)"])
def test_a_comment_with_pairs_of_parentheses_is_one_comment(run: Run, comment: str) -> None:
    """Any other way to end it leaves a ) without its (."""
    found = run(f"O1\nG0 X1 {comment}\nG1 X2 F100\nM30")
    assert found.errors == []
    assert found.path.end[found.path.kind != Kind.EVENT, 0].tolist() == [1, 2]


@pytest.mark.parametrize("line", ["G0 X1 (A (B)", "G0 X1 (A)(B (C)", "G0 (A (B) X1"])
def test_a_comment_ends_at_its_first_parenthesis(run: Run, line: str) -> None:
    """As on the control, which ignores what stands between control-out and control-in (B-64484EN, 13.1): macros of a shop were refused."""
    found = run(f"O1\n{line}\nG1 X2 F100\nM30")
    assert found.errors == []
    assert found.path.end[found.path.kind != Kind.EVENT, 0].tolist() == [1, 2]
    assert [d.span.line for d in found.diagnostics if d.code == "other-control"] == [2]


def test_a_jump_behind_a_setting_acts_each_time_that_its_text_is_read(run: Run) -> None:
    """By hand: the second line of the same text, as the first one, goes to N10, which then leads to N20. It was read without its GOTO."""
    text = "O1\nG21 G90 F100\n#1=0\n#2=1 GOTO10\nG1 X99\nN10 G1 X[5+#1]\n#1=#1+1\nIF[#1EQ2]GOTO20\n#2=1 GOTO10\nG1 X98\nN20 G1 X9\nM30"
    found = run(text, dialect="fanuc")
    assert found.errors == []
    assert found.path.end[found.path.kind != Kind.EVENT, 0].tolist() == [5, 6, 9]


def test_an_alarm_whose_variable_is_computed_ends_the_program(run: Run) -> None:
    """#[3000] is #3000 (B-63324EN, 15.2); it was stored, and the program went on."""
    found = run("O1\nG21 G90 F100\n#1=3000\n#[#1]=7 (WORN)\nG1 X5\nM30", dialect="fanuc")
    assert [fault[0] for fault in found.errors] == ["macro-alarm"]


def test_h_beside_a_call_is_not_taken_as_a_tool_offset(run: Run) -> None:
    """Mazak's M98 P H begins at a line; as an offset it moved Z by the difference of two tools."""
    text = "O1\nG43 H1 Z10\nM98 P100 H20\nM30\nO100\nN20 G0 X1\nM99"
    assert run(text).errors == [("other-control", 3, 10)]


def test_the_origins_g110_to_g129_of_haas_are_those_of_g154(run: Run) -> None:
    text = "O1\nG10 L20 P{p} X5\nG10 L20 P7 X7\n{code} G0 X1\nM30"
    for code, p in (("G110", 1), ("G111", 2), ("G114", 5), ("G129", 20)):
        found = run(text.format(code=code, p=p))
        assert found.errors == []
        assert found.path.end[-1, 0] == 6
    assert run("O1\nG109 G0 X1\nM30").errors[0][0] == "unknown-code"


@pytest.mark.parametrize(
    ("dialect", "block", "message", "hint"),
    [
        ("fanuc-lathe", "G195 F1.", "G195 (tapping with a driven tool)", "cncgen codes"),
        ("fanuc", "G72.1 P100 L6 X0 Y0 R60.", "G72.1 (copies of a subprogram, turned or shifted)", "G68"),
        ("fanuc", "G72.2 P100 L3 I30. J0.", "G72.2 (copies of a subprogram, turned or shifted)", "G52"),
        ("fanuc-lathe", "G68", "G68", "second turret"),
    ],
)
def test_a_code_that_other_dialects_have_is_named_as_what_it_is_here(
    run: Run, dialect: str, block: str, message: str, hint: str
) -> None:
    """Operator's Manual 30i, B-63944EN, "Figure copying" and "Mirror image for double turret"; both were called LinuxCNC's roughing."""
    found = run(f"O1\n{block}\nM30\nO100\nM99", dialect=dialect)
    error = next(one for one in found.diagnostics if one.severity == "error")
    assert error.code == "unknown-code"
    assert error.message.startswith(message)
    assert hint in (error.hint or "")


@pytest.mark.parametrize(
    ("lines", "told", "ends"),
    [
        ("GOTO 5\nWHILE[#1LT2]DO1\nG1 X9\nN5 G1 X#1\n#1=#1+1\nEND1", 4, [9, 1]),
        ("WHILE[#1LT2]DO1\nIF[#1EQ1]GOTO 5\nG1 X7\nN5 #1=#1+1\nEND1\nGOTO 6\nG1 X9\nN6 G1 X8", None, [7, 8]),
        ("GOTO 5\nG1 X9\nN5 WHILE[#1LT1]DO1\n#1=#1+1\nG1 X#1\nEND1", None, [1]),
        ("G65 P2 J1 I2\nG65 P2 I3 J4", 4, [2, 1, 3, 4]),
        ("G65 P2 I3 J4 K5 I6 J7 K8", None, [3, 4]),
        ("G65 P2 I3 I5 J4", 4, [3, 4]),
    ],
)
def test_what_controls_take_otherwise_in_macros_is_told(
    run: Run, lines: str, told: int | None, ends: list[float]
) -> None:
    """FANUC's manual: branches do not enter a loop, and I J K stand in the order of the alphabet (B-63324EN, 15.6 and 15.7.1)."""
    text = f"O1\nG21 G90 F100\n#1=0\n{lines}\nM30\nO2\nG1 X#4\nX#5\nM99"
    found = run(text, dialect="fanuc")
    assert found.errors == []
    lines_told = [d.span and d.span.line for d in found.diagnostics if d.code == "other-control"]
    assert lines_told == [told] * (told is not None)
    assert list(dict.fromkeys(found.path.end[:, 0].tolist())) == ends
