"""A check says of a program what its reading says, counts its motions, and does without the toolpath's libraries."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path

import pytest

from cncgen.diagnostics import Diagnostics, ProgramError, UsageError
from cncgen.gcode import check, read
from cncgen.toolpath.reading import ReadOptions
from trials.peer_cases import write_programs

ROOT = Path(__file__).resolve().parent.parent.parent


@pytest.mark.parametrize("folder", ["programs", "programs/bad", "tests/peer/cases"])
def test_a_check_says_what_reading_says(folder: str, tmp_path: Path) -> None:
    where = ROOT / folder
    if folder == "tests/peer/cases":
        where = tmp_path
        write_programs(where)
    paths = sorted(path for path in where.iterdir() if path.suffix in {".nc", ".ngc"})
    assert len(paths) > 5
    for path in paths:
        options = ReadOptions(max_steps=200_000)
        found = Diagnostics()
        count = check(path, path.name, options, found)
        program = read(path, path.name, options)
        rows = sum(len(chunk) for chunk in program.chunks())
        assert [d.render() for d in found] == [d.render() for d in program.diagnostics], path
        # Motions of no length are no rows.
        assert count >= rows, path


def test_motions_and_events_are_counted() -> None:
    """A line, an arc, a spline, a tap there and back; events as the toolpath has them; a run of blocks, and a loop."""
    text = b"F100 S100 M3\nG1 X1\nG2 X3 I1\nG5 X9 Y1 I1 J1 P1 Q1\nG33.1 Z-1 K1\nM2\n"
    (chunk,) = read(io.BytesIO(text), "t").chunks()
    assert check(io.BytesIO(text), "t") == 1 + 1 + 1 + 2 + len(chunk.events) == len(chunk)
    assert check(io.BytesIO(b"F1\n" + b"G1 X1\nG3 X0 I-.5\n" * 500 + b"M2\n"), "t") == 1001
    assert check(io.BytesIO(b"F1\no1 repeat [50]\nG1 X1\nG0 X0\no1 endrepeat\nM2\n"), "t") == 101


def test_errors_are_raised_where_nobody_takes_them(tmp_path: Path) -> None:
    with pytest.raises(ProgramError) as caught:
        check(io.BytesIO(b"G21 G1 X1\nG2 X1\n"), "t")
    assert [d.code for d in caught.value.diagnostics] == ["feed-missing", "arc-centre", "no-program-end"]
    with pytest.raises(UsageError):
        check(tmp_path / "none.ngc", "none.ngc")


@pytest.mark.parametrize(
    "text", ["G1 X1 F5\nG2 X3 I1\nM2\n", "#1=2\no1 while [#1 LT 9]\n#1=[#1+1]\no1 endwhile\nM2\n"]
)
def test_a_check_imports_neither_numpy_nor_the_parser(text: str, tmp_path: Path) -> None:
    """They take longer to import than a program of fifty thousand lines to check."""
    (tmp_path / "p.ngc").write_text(text)
    # Without what an environment imports for its own sake.
    begin = (
        "import sys, types; package = types.ModuleType('cncgen.grammars'); package.__path__ = ['grammars']; "
        "sys.modules['cncgen.grammars'] = package; sys.path.insert(0, '.'); from cncgen.cli.app import run; "
        f"assert run(['check', {str(tmp_path / 'p.ngc')!r}]) == 0; print(*sys.modules)"
    )
    found = subprocess.run(
        [sys.executable, "-S", "-c", begin], capture_output=True, text=True, check=True, cwd=ROOT
    )
    imported = {name.partition(".")[0] for name in found.stdout.split()}
    assert "cncgen" in imported
    assert "cncgen.gcode.text.built_patterns" in found.stdout.split()
    assert not imported & {"click", "numpy", "lark", "scipy", "tempfile"}
    # Each would take a twentieth of all the time, or more.
    assert not imported & {"dataclasses", "enum", "inspect", "pathlib", "re", "typing", "urllib"}
