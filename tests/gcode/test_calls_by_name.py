"""Programs that are called by name, jumps behind THEN, and blocks that a switch leaves out."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.diagnostics import Diagnostics
from cncgen.gcode import check, read
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import Kind

ROUND = "O<BOLT HOLE>\nG91 G0 X#1 Y2.\nG90\nM99\n"


def ends(text: str, **options: Any) -> list[tuple[float, ...]]:
    """Return the ends of the motions in X Y Z, of a text without errors."""
    program = read(io.BytesIO(text.encode()), "t.nc", ReadOptions(chunk_rows=1_000_000, **options))
    (path,) = program.chunks()
    assert [d.message for d in program.diagnostics if d.severity == "error"] == []
    return [tuple(end) for end in path.end[path.kind != Kind.EVENT, :3].round(6).tolist()]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("#1=1.\nM98 <BOLT HOLE> L2\n", [(1, 2, 0), (2, 4, 0)]),
        ("G65<Bolt Hole>A3.\nM98P7\n", [(3, 2, 0), (9, 2, 0)]),
        # A jump behind THEN, where it holds and where it does not.
        ("#1=1\nIF [#1 EQ 1] THEN GOTO 10\nG0 X5.\nN10 G0 Y1.\n", [(0, 1, 0)]),
        ("#1=2\nIF[#1EQ1]THENGOTO10\nG0 X5.\nN10 G0 Y1.\n", [(5, 0, 0), (5, 1, 0)]),
    ],
)
def test_calls_and_jumps(body: str, expected: list[tuple[float, ...]]) -> None:
    text = f"O1\nG21\n{body}M30\n{ROUND}O7\nG0 X9.\nM99\n"
    assert ends(text, dialect="fanuc") == expected


@pytest.mark.parametrize("call", ["M98 P7 Q20", "M98 <BOLT HOLE> Q20"])
def test_q_beside_a_program_is_the_line_at_which_it_begins(call: str) -> None:
    """Mazak, M98 P Q L: "Q = sequence number in subprogram to be called"; each round of L begins there. The main program has an N20 too."""
    bodies = "".join(f"{name}\nN10 X1.\nN20 X2.\nM99\n" for name in ("O7", "O<BOLT HOLE>"))
    text = f"O1\nG21 G91 G0\nN20 Y1.\n{call}\n{call} L2\nM30\n{bodies}"
    assert ends(text, dialect="fanuc") == [(0, 1, 0), (2, 1, 0), (4, 1, 0), (6, 1, 0)]


def test_a_program_has_the_line_at_which_it_begins() -> None:
    text = "G21\nM98 P7 Q30\nG0 X1.\nM30\nO7\nN10 X1.\nM99\n"
    collected = Diagnostics()
    check(io.BytesIO(text.encode()), "t.nc", ReadOptions(dialect="fanuc"), collected)
    assert [(d.code, d.span.line, d.span.column) for d in collected if d.severity == "error" and d.span] == [
        ("goto-target", 2, 8)
    ]


def test_a_program_called_by_name_stands_in_a_file_and_its_axes_are_known(tmp_path: Path) -> None:
    (tmp_path / "side.nc").write_text("O<SIDE>\nG0 B90.\nM99\n")
    main = tmp_path / "main.nc"
    main.write_text("O1\nG21\nM98 <SIDE>\nM30\n")
    program = read(main, "main.nc", ReadOptions(dialect="fanuc"))
    (path,) = program.chunks()
    assert (program.moving_axes, path.end[path.kind != Kind.EVENT].tolist()) == ("B", [[0, 0, 0, np.pi / 2]])


def test_a_name_that_is_nowhere(run: Any) -> None:
    assert run("O1\nG21\nM98 <NOWHERE>\nM30\n", dialect="fanuc").errors[0][:2] == ("sub-missing", 3)


SWITCHED = """0 BEGIN PGM T MM
1 TOOL CALL 1 Z S1000 F100
/ 2 L X+99 FMAX
/3 TCH PROBE 419 X ~
 Q263=+0 ~
 Q264=+0
4 L X+1 F100
/ 5 CYCL DEF 200 X ~
 Q200=+9
6 L Y+2
7 END PGM T MM
"""


def test_blocks_of_plain_language_that_a_switch_leaves_out() -> None:
    """A block goes on behind ~, and is left out as a whole."""
    assert ends(SWITCHED) == [(1, 0, 0), (1, 2, 0)]
    assert ends(SWITCHED.replace("TCH PROBE 419 X ~\n Q263=+0 ~\n Q264=+0", "L Y+5 FMAX"), block_delete=False) == [
        (99, 0, 0), (99, 5, 0), (1, 5, 0), (1, 2, 0)]  # fmt: skip


@pytest.mark.parametrize(
    ("parameters", "text", "line"),
    [("5230 30\n", "G1 F9 Z1\nG1 X10\nM2\n", 2), ("5169 7\n", "G1 X1 F9\nG28\nM2\n", 2), ("5169 7\n", "G28\nM2\n", 1)],
)  # fmt: skip
def test_check_names_an_axis_without_a_column(tmp_path: Path, parameters: str, text: str, line: int) -> None:
    (tmp_path / "rs274.var").write_text(parameters)
    found = Diagnostics()
    options = ReadOptions(dialect="linuxcnc", units="mm", parameters=tmp_path / "rs274.var")
    check(io.BytesIO(text.encode()), "t", options, found)
    assert [(d.code, d.span.line) for d in found if d.span] == [("late-axis", line)]


def test_what_could_stand_there_is_named_in_words(run: Any) -> None:
    (fault,) = (d for d in run("O1\nG0 X1. =2\nM30\n", dialect="fanuc").diagnostics if d.severity == "error")
    assert "a word, a comment, a jump or loop of a macro or # was expected" in fault.message


def test_a_program_of_heidenhain_is_called_whatever_its_capitals(tmp_path: Path) -> None:
    (tmp_path / "FACE.H").write_text("0 BEGIN PGM FACE MM\n1 L X+7 F100\n2 END PGM FACE MM\n")
    main = tmp_path / "main.h"
    main.write_text("0 BEGIN PGM M MM\n1 TOOL CALL 1 Z S100\n2 CALL PGM TNC:\\Face.h\n3 END PGM M MM\n")
    program = read(main, "main.h", ReadOptions())
    (path,) = program.chunks()
    assert path.end[path.kind != Kind.EVENT].tolist() == [[7, 0, 0]]


@pytest.mark.parametrize(("unit", "scale"), [("MM", 1.0), ("INCH", 25.4)])
def test_system_data_are_in_millimetres(unit: str, scale: float) -> None:
    """FN 18 gives mm whatever the program's unit ("List of FN functions" of TNC 7): Q1 of a place 2 units on is 2 or 50.8."""
    text = f"0 BEGIN PGM T {unit}\n1 TOOL CALL 1 Z S100\n2 L X+2 F100\n3 FN 18: SYSREAD Q1 = ID270 NR1 IDX1\n4 FN 18: SYSREAD Q2 = ID240 NR1 IDX1\n5 FN 18: SYSREAD Q3 = ID10 NR1\n6 L X+Q1 Y+Q2 Z+Q3\n7 END PGM T {unit}\n"
    assert ends(text)[-1] == pytest.approx((2.0 * scale * scale, 2.0 * scale * scale, (scale > 1.0) * scale))


@pytest.mark.parametrize(
    "call", ["M98 (part.nc)", "M98 (USB0/JOBS/PART.NC)", "M98 (part) L1", "m98(part.nc)"]
)
def test_m98_of_haas_names_a_file_in_parentheses(tmp_path: Path, call: str) -> None:
    """The folder is one of the control's disk; the file is looked for beside the program, and the axes that it moves have columns."""
    (tmp_path / "part.nc").write_text("%\nO8\nG0 Y3.\nM99\n%\n")
    main = tmp_path / "main.nc"
    main.write_text(f"O1\nG21 G90\nG0 X1.\n{call}\nX2.\nM30\n")
    program = read(main, "main.nc", ReadOptions(dialect="fanuc", chunk_rows=1_000_000))
    (path,) = program.chunks()
    assert [d.message for d in program.diagnostics if d.severity == "error"] == []
    assert path.end[path.kind != Kind.EVENT, :2].tolist() == [[1, 0], [1, 3], [2, 3]]
    told = [d.message for d in program.diagnostics if d.code == "other-control"]
    assert len(told) == ("USB0" in call)


def test_a_remark_behind_m98_p_names_no_file() -> None:
    assert ends("O1\nG21\nM98 P7 (the holes)\nM30\nO7\nG0 X9.\nM99\n", dialect="fanuc") == [(9, 0, 0)]
