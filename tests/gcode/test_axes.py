"""The axes that a program names: its own, those of files that it calls, and those that come as a surprise."""

from __future__ import annotations

import math
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest

from cncgen.gcode import canon, read
from cncgen.gcode.block import Block
from cncgen.gcode.codes import dwell
from cncgen.gcode.codes.reference import rows
from cncgen.gcode.codes.table import COMPENSATION, ROTARY_PATH, STRICT_COMPENSATION, TOOL_POINT, Code, table
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.machine.kinematics import Kinematics
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import Kind

SUBPROGRAMS = {
    "turn.ngc": "o<turn> sub\nG1 A90 F1000\nG1 Z5\no<turn> endsub\n",
    "7.ngc": "o7 sub\no<turn> call\no7 endsub\n",
    "O0012.nc": "G1 B30. F1000.\nM99\n",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in SUBPROGRAMS.items():
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("text", "axes", "dialect"),
    [
        ("o<turn> call\nM2\n", "ZA", "linuxcnc"),
        ("O < T u R n > CALL\nM2\n", "ZA", "linuxcnc"),
        ("o7 call\nM2\n", "ZA", "linuxcnc"),
        ("M98 P12\nM30\n", "B", "fanuc"),
        ("G65 P12 C5. X1.\nM30\n", "B", "fanuc"),
    ],
)
def test_axes_of_called_files_move(folder: Path, text: str, axes: str, dialect: str) -> None:
    main = folder / "main.ngc"
    main.write_text(text)
    program = read(main, "main.ngc", ReadOptions(dialect=dialect))
    kinds = [kind for chunk in program.chunks() for kind in chunk.kind.tolist() if kind != Kind.EVENT]
    assert (program.moving_axes, len(kinds)) == (axes, len(axes))
    assert not program.diagnostics.has_errors


def test_an_axis_of_a_file_that_a_computed_number_names_is_an_error(folder: Path) -> None:
    main = folder / "main.ngc"
    main.write_text("#1 = 7\nG1 X5 F100\no[#1] call\nM2\n")
    program = read(main, "main.ngc", ReadOptions(dialect="linuxcnc"))
    list(program.chunks())
    errors = [d for d in program.diagnostics if d.severity == "error" and d.span]
    assert [(d.code, Path(d.span.file).name, d.span.line) for d in errors if d.span] == [
        ("late-axis", "turn.ngc", 2)
    ]


@pytest.mark.parametrize(
    ("text", "axes"),
    [
        ("G2 I1\n", "XY"),
        ("G18 G2 K1\n", "XZ"),
        ("G018\nG2 K1 I1\n", "XZ"),
        ("G2 I1\nG018\nG2 K1 I1\n", "XYZ"),
        ("o7 call\nG18 G2 K1\n", "XYZA"),
        ("G19 G2 J1\n", "YZ"),
        ("g 1 9 G2 K1\n", "YZ"),
        ("G17 G2 I1 K1\n", "XY"),
    ],
)
def test_a_full_circle_names_the_axes_of_its_plane(folder: Path, text: str, axes: str) -> None:
    """Of a circle in X Z that names no axis, the setpoints once had X and Y."""
    main = folder / "main.ngc"
    main.write_text("F100\n" + text + "M2\n")
    assert read(main, "main.ngc", ReadOptions(dialect="linuxcnc")).moving_axes == axes


def test_files_that_call_each_other_are_looked_into_once(folder: Path) -> None:
    (folder / "turn.ngc").write_text("o<turn> sub\no7 call\nG1 W1\no<turn> endsub\n")
    main = folder / "main.ngc"
    main.write_text("G1 X1 F1\no7 call\nM2\n")
    assert read(main, "main.ngc", ReadOptions(dialect="linuxcnc")).moving_axes == "XW"


#: A table that turns about X, and one on it that turns about Z.
TABLES = Kinematics(0, (3, 5), (0.0, 0.0, -100.0))


@pytest.mark.parametrize(
    ("text", "axes", "dialect"),
    [
        # Codes that move axes which no word names; a search for letters lost them without a word.
        ("G2 X10 R5 F100\n", "XY", "linuxcnc"),
        ("G18 G2 X10 R5 F100\n", "XZ", "linuxcnc"),
        ("G10 L2 P1 R30\nG1 X10 F100\n", "XY", "linuxcnc"),
        ("G10 L2 P1 Z3\nG1 X10 F100\n", "XZ", "linuxcnc"),
        ("G41.1 D2\nG1 X10 F100\n", "XY", "linuxcnc"),
        ("G1 X1 F9\nG28\n", "XYZ", "linuxcnc"),
        ("G1 X1 F9\nG28 X0\n", "X", "linuxcnc"),
        ("G68 R30\nG1 X10 F100\n", "XY", "fanuc"),
        ("G16\nG1 X10 F100\n", "XY", "fanuc"),
        ("#1=2\nG#1 X3 R5 F10\n", "XYZ", "linuxcnc"),
        # Words as the grammar reads them: a letter before a function, comments, arguments of macros.
        ("G1 Z ASIN[1] F100\n", "Z", "linuxcnc"),
        ("#1=ASIN[1]\nG1 Y[ABS[#1]] F100\n", "Y", "linuxcnc"),
        ("G1 X1 F9 (Y2) ;Z3\nz 4", "XZ", "linuxcnc"),
        ("#<x>=1\nG1 F1 Y#<x>\n", "Y", "linuxcnc"),
        ("G1 F1 @5 ^90\n", "XY", "linuxcnc"),
        ("G1 F1 a-1b+2c.5\n", "ABC", "linuxcnc"),
        ("O1\nG65 P1 A2 B3\nX1\n", "X", "fanuc"),
        ("g 0 66 p1 c4\nA1\n", "A", "fanuc"),
        # Blocks of SINUMERIK as its grammar reads them: texts in apostrophes, macros, numbers of blocks before letters.
        ("G1 X1 F9\nMSG('C=5 Y2') ; Z3\n", "X", "sinumerik"),
        ("DEFINE AUF AS Z100\nG0 X1\nAUF\n", "XZ", "sinumerik"),
        ("N5Y=3 F9\nN6G0X=IC(2)\n", "XY", "sinumerik"),
        ("G0 POS[Z]=3 X2\n", "XZ", "sinumerik"),
        ("R1=$AA_IM[Z]\nG1 X=R1 F9\n", "X", "sinumerik"),
        ("G0 X0\nG2 X10 CR=5 F9\n", "XY", "sinumerik"),
        ("G0 X0\nG18\nG2 X10 CR=5 F9\n", "XYZ", "sinumerik"),
    ],
)
def test_axes_that_codes_move(text: str, axes: str, dialect: str) -> None:
    assert read(BytesIO(text.encode()), "t", ReadOptions(dialect=dialect)).moving_axes == axes


@pytest.mark.parametrize(
    "call", ['EXTCALL "UP.SPF"', 'EXTCALL("/_N_SPF_DIR/_N_UP_SPF")', 'CALL "UP"', "MCALL UP", "UP P2"]
)
def test_axes_of_called_files_of_sinumerik_move(tmp_path: Path, call: str) -> None:
    (tmp_path / "UP.SPF").write_text("G0 Z5\nM17\n")
    main = tmp_path / "main.mpf"
    main.write_text(f"G0 X1\n{call}\nX2\nM30\n")
    program = read(main, "main.mpf", ReadOptions(dialect="sinumerik"))
    assert program.moving_axes == "XZ"
    assert any(end for chunk in program.chunks() for end in chunk.end[:, 2].tolist())
    assert not program.diagnostics.has_errors


@pytest.mark.parametrize("code", ["G43.4", "G43 .4", "g 4 3.4", "G043.40"])
@pytest.mark.parametrize("called", [False, True])
def test_the_tool_point_moves_x_y_and_z(tmp_path: Path, code: str, called: bool) -> None:
    """The tip stays where it is while the table turns, so that X Y Z follow: they were lost in files and with blanks."""
    inner = f"{code} H1\nG1 A90. F1000.\nG49\n"
    (tmp_path / "O0012.nc").write_text(inner + "M99\n")
    main = tmp_path / "main.nc"
    main.write_text(("M98 P12\n" if called else inner) + "M30\n")
    program = read(main, "main.nc", ReadOptions(dialect="fanuc", kinematics=TABLES))
    assert program.moving_axes == "XYZA"


@pytest.mark.parametrize(
    ("parameters", "text", "axis", "line"),
    [
        ("5230 30\n", "G1 F9 Z1\nG1 X10\nM2\n", "Y", 2),
        ("5169 7\n", "G1 X1 F9\nG28\nM2\n", "W", 2),
    ],
)
def test_an_axis_that_moves_without_a_column_is_an_error(
    tmp_path: Path, parameters: str, text: str, axis: str, line: int
) -> None:
    """A rotation and reference points that the control keeps move axes which nothing in the program names."""
    (tmp_path / "rs274.var").write_text(parameters)
    options = ReadOptions(dialect="linuxcnc", units="mm", parameters=tmp_path / "rs274.var")
    program = read(BytesIO(text.encode()), "t", options)
    list(program.chunks())
    ((code, message, place),) = [(d.code, d.message, d.span) for d in program.diagnostics]
    assert place is not None
    assert (code, message[0], place.line) == ("late-axis", axis, line)


@pytest.mark.parametrize("block", ["G1 A90. /B10. F100", "G1 ATAN[45.]/[2] F100"])
def test_words_before_a_slash_within_a_block_of_fanuc_have_columns(block: str) -> None:
    """What stands before the slash is read (`cut`, B-63324EN 13.2), so its axes are named: A moved without a column, an error."""
    program = read(
        BytesIO(f"O1\nG21 G90\nG1 X1. F100\n{block}\nM30\n".encode()), "t", ReadOptions(dialect="fanuc")
    )
    (chunk,) = program.chunks()
    assert [d.code for d in program.diagnostics if d.code != "other-control"] == []
    turned = {"A90.": math.radians(90.0), "ATAN[45.]/[2]": math.radians(1.0)}[block.split()[1]]
    assert (program.moving_axes, chunk.end[-1, 3]) == ("XA", pytest.approx(turned))


def test_arcs_in_planes_of_u_v_w_are_refused() -> None:
    """Of a toolpath, arcs lie in X Y Z: one from U0 to U10 was planned as no motion at all."""
    program = read(BytesIO(b"F600\nG17.1 G2 U10 V0 I5\nM2\n"), "t", ReadOptions(dialect="linuxcnc"))
    list(program.chunks())
    assert [d.code for d in program.diagnostics] == ["arc-plane"]


class MadeUp:
    """G321, of LinuxCNC and FANUC, and an M321, by a row each in one module; a kinematics for what it is refused under."""

    TABLE = Kinematics(0, (3, 5), (0.0, 0.0, -100.0))

    @staticmethod
    def aside(ip: Interpreter, block: Block) -> None:
        """Go to X, and in Y twice as far."""
        end = ip.end_point(block)
        end[1] = 2.0 * end[0]
        ip.sink.straight_traverse(end)
        ip.state.position, ip.state.motion = end, 3210

    ROWS = (
        Code("G", 3210, "motion", Stage.MOTION, aside, "to X, and Y twice as far", "x", "motion", moves="Y",
            refused=("goes aside", COMPENSATION | ROTARY_PATH | TOOL_POINT)),
        Code("M", 3210, "doors", Stage.PINS, lambda ip, block: ip.sink.call("DOOR()"), "the door opens", dialects=("linuxcnc",),
            without="others", refused=("opens the door", STRICT_COMPENSATION)),
    )  # fmt: skip


@pytest.fixture
def made_up(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(dwell, "CODES", (*dwell.CODES, *MadeUp.ROWS))
    table.cache_clear()
    yield
    table.cache_clear()


def read_text(
    text: str, dialect: str, **options: Any
) -> tuple[str, list[list[float]], list[tuple[str, str]]]:
    """Return the moving axes of a text, the ends of its motions, and its errors."""
    program = read(BytesIO(text.encode()), "t", ReadOptions(dialect=dialect, units="mm", **options))
    ends = [end for chunk in program.chunks() for end in chunk.end[chunk.kind != Kind.EVENT].tolist()]
    errors = [(d.code, d.message) for d in program.diagnostics if d.severity == "error"]
    return program.moving_axes, ends, errors


@pytest.mark.usefixtures("made_up")
def test_a_code_is_added_in_one_file(tmp_path: Path) -> None:
    """A row in the CODES of one module is enough: the code is read, runs, has its columns, and stands in the list of codes."""
    for dialect in ("linuxcnc", "fanuc"):
        assert read_text("G321 X5\nX6\nM2\n", dialect) == ("XY", [[5.0, 10.0, 0.0], [6.0, 12.0, 0.0]], [])
    (tmp_path / "aside.ngc").write_text("o<aside> sub\nG321 X5\no<aside> endsub\n")
    assert read_text("o<aside> call\nM2\n", "linuxcnc", include=(tmp_path,))[0] == "XY"
    printed = list(canon(BytesIO(b"M321\nM2\n"), "t", ReadOptions(dialect="linuxcnc")))
    assert any(line.endswith("DOOR()") for line in printed)
    listed = list(rows())
    assert ("G321", "X", "linuxcnc fanuc fanuc-lathe", "to X, and Y twice as far") in listed
    assert ("M321", "", "linuxcnc", "the door opens") in listed
    # Of lathes it is too: X is a diameter there.
    assert read_text("G321 X5\nM2\n", "fanuc-lathe") == ("XY", [[2.5, 5.0, 0.0]], [])
    # Other languages leave the M code to the machine's builder.
    assert ("M", 3210) in table("linuxcnc")
    assert ("M", 3210) not in table("sinumerik")
    assert ("G", 3210) in table("sinumerik")


@pytest.mark.usefixtures("made_up")
@pytest.mark.parametrize(
    ("dialect", "before", "code", "message"),
    [
        ("linuxcnc", "F10 G41.1 D1\nG1 X9", "comp-refused", "G321 goes aside, and cutter compensation is on"),
        ("fanuc", "F10 G41.1 D1\nG1 X9", "comp-refused", "G321 goes aside, and cutter compensation is on"),
        ("fanuc", "G0 X20 C0\nG12.1", "rotary-refused", "G321 goes aside: not under G12.1"),
        ("fanuc", "G10 L10 P1 R50.\nG43.4 H1", "tcp-refused", "G321 goes aside: not under G43.4"),
    ],
)
def test_an_added_code_is_refused_where_its_row_says_so(
    dialect: str, before: str, code: str, message: str
) -> None:
    _, _, errors = read_text(f"{before}\nG321 X12\nM2", dialect, kinematics=MadeUp.TABLE)
    assert errors[0] == (code, message)


@pytest.mark.usefixtures("made_up")
def test_an_added_code_is_refused_under_one_kind_of_compensation_alone() -> None:
    text = "F10 G41.1 D1\nG1 X9\nM321\nX20\nG40 G0 X30\nM2"
    assert read_text(text, "linuxcnc")[2] == [
        ("comp-refused", "M321 opens the door, and cutter compensation is on")
    ]
