"""The axes that a program names: its own, those of files that it calls, and those that come as a surprise."""

from __future__ import annotations

from pathlib import Path

import pytest

from cncgen.gcode import read
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
        ("late-axis", "7.ngc", 2)
    ]


@pytest.mark.parametrize(
    ("text", "axes"),
    [
        ("G2 I1\n", "XY"),
        ("G18 G2 K1\n", "XZ"),
        ("G018\nG2 K1 I1\n", "XYZ"),
        ("G19 G2 J1\n", "XYZ"),
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
