"""A package of others brings a format and a dialect: it is installed into a folder as pip would, and used by the commands."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

FORMAT = """
import numpy as np
from cncgen.setpoints.readers.csv import blocks as csv_blocks

BINARY = False

class Writer:
    def __init__(self, sink, layout):
        self.sink = sink
        sink.write(("t;" + ";".join(layout.axes.lower()) + "\\n").encode())

    def write(self, chunk):
        for number, row in enumerate(chunk.position, start=chunk.first):
            values = [number * chunk.period_s, *row]
            self.sink.write((";".join(repr(float(value)) for value in values) + "\\n").encode())

    def close(self):
        pass

def blocks(file, name, axes, period_s):
    import io
    head, _, rest = file.read().partition(b"\\n")
    letters = head.decode().split(";")[1:]
    columns = ",".join(["t_s", *(f"{letter}_mm" for letter in letters)])
    yield from csv_blocks(io.BytesIO(columns.encode() + b"\\n" + rest.replace(b";", b",")), name, axes, period_s)
"""
DIALECT = """
BASE = "linuxcnc"

def translated(text):
    return text.replace("RAPID", "G0").replace("CUT", "G1")
"""
ENTRY_POINTS = """[cncgen.setpoint_formats]
semi = brought.semicolons
broken = brought.not_there
[cncgen.dialects]
shopfloor = brought.shopfloor
short = brought.short
lost = brought.lost
"""
PROGRAM = "G21 G90 G61 F1200\nRAPID X1\nCUT X10 Y5\nM2\n"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package and its metadata, as `pip install --target` leaves them."""
    folder = tmp_path_factory.mktemp("site")
    (folder / "brought").mkdir()
    (folder / "brought" / "__init__.py").write_text("")
    (folder / "brought" / "semicolons.py").write_text(FORMAT)
    (folder / "brought" / "shopfloor.py").write_text(DIALECT)
    (folder / "brought" / "short.py").write_text("BASE = 'fanuc'\ndef translated(text):\n    return ''\n")
    (folder / "brought" / "lost.py").write_text("BASE = 'nosuch'\ndef translated(text):\n    return text\n")
    about = folder / "brought-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: brought\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(ENTRY_POINTS)
    (folder / "part.nc").write_text(PROGRAM)
    (folder / "elsewhere").mkdir()
    (folder / "elsewhere" / "part.nc").write_text(PROGRAM)
    return folder


def run(site: Path, line: str, installed: bool = True) -> subprocess.CompletedProcess[str]:
    """Run a command line in the folder, with the package installed or not."""
    environment = os.environ | ({"PYTHONPATH": str(site)} if installed else {})
    return subprocess.run(
        [sys.executable, "-m", "cncgen", *line.split()],
        cwd=site if installed else site / "elsewhere",
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_a_format_of_others_is_written_and_read(site: Path) -> None:
    made = run(site, "plan part.nc --dialect shopfloor -o part.semi")
    assert made.returncode == 0, made.stderr
    rows = (site / "part.semi").read_text().splitlines()
    assert rows[0] == "t;x;y"
    assert [float(word) for word in rows[-1].split(";")][1:] == [10.0, 5.0]
    judged = run(site, "verify part.semi --program part.nc --dialect shopfloor")
    assert judged.returncode == 0, judged.stderr
    named = run(site, "plan part.nc --dialect shopfloor -o - --format semi -q")
    assert named.stdout.splitlines() == rows


def test_a_dialect_of_others_keeps_the_lines_of_the_program(site: Path) -> None:
    (site / "faulty.nc").write_text("G21 G90\nRAPID X1\nCUT X10 Y5 F100\nCUT X[1\nM2\n")
    found = run(site, "check faulty.nc --dialect shopfloor")
    assert found.returncode == 1
    assert "faulty.nc:4:" in found.stderr


@pytest.mark.parametrize(
    ("line", "wanted"),
    [
        ("plan part.nc --dialect shopfloor -o part.broken", "cannot be loaded"),
        ("check part.nc --dialect short", "must have the lines of the program"),
        ("check part.nc --dialect lost", "brought.lost: BASE = 'nosuch' is not one of"),
        ("check part.nc --dialect shopflor", "'shopfloor'"),
        ("plan part.nc --dialect shopfloor -o - --format simi", "'semi'"),
    ],
)
def test_faults_of_a_package_are_named(site: Path, line: str, wanted: str) -> None:
    found = run(site, line)
    assert found.returncode == 2
    assert wanted in found.stderr
    assert "internal error" not in found.stderr


def test_the_library_names_what_packages_bring(site: Path) -> None:
    calls = (
        "cncgen.read_text('G0 X1', dialect='shopflor', units='furlong')",
        "cncgen.write(cncgen.sample(cncgen.plan(cncgen.read_text('G21 G90 F600\\nG1 X1'), 'xy-table')), 'a.csv', format='simi')",
    )
    # The other faults of a call are named beside it.
    for call, wanted in zip(calls, (("shopfloor", "furlong"), ("semi",)), strict=True):
        script = f"import cncgen\ntry:\n    {call}\nexcept cncgen.CncgenError as error:\n    print(error)"
        done = subprocess.run(
            [sys.executable, "-c", script], cwd=site, env=os.environ | {"PYTHONPATH": str(site)}, capture_output=True, text=True, timeout=120, check=True
        )  # fmt: skip
        assert "is not one of" in done.stdout
        assert all(each in done.stdout for each in wanted)


def test_without_the_package_its_names_are_unknown(site: Path) -> None:
    assert run(site, "check part.nc --dialect shopfloor", installed=False).returncode == 2
    unknown = run(site, "plan part.nc -o other.semi", installed=False)
    assert unknown.returncode == 2
    assert "suffix .semi" in unknown.stderr


def test_the_package_of_the_page_works(root: Path, tmp_path: Path) -> None:
    """Its modules and entry points, as they stand in docs/extensions.md."""
    page = (root / "docs/extensions.md").read_text(encoding="utf-8")
    codes = re.findall(r"^```python\n(.*?)^```", page, re.M | re.S)
    tables = re.findall(r"^```toml\n(.*?)^```", page, re.M | re.S)
    points = ""
    for code, table in zip(codes, tables, strict=True):
        for group, named in tomllib.loads(table)["project"]["entry-points"].items():
            ((name, module),) = named.items()
            points += f"[{group}]\n{name} = {module}\n"
            path = tmp_path / f"{module.replace('.', '/')}.py"
            path.parent.mkdir(exist_ok=True)
            path.write_text(code, encoding="utf-8")
    about = tmp_path / "mypackage-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: mypackage\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(points)
    (tmp_path / "part.nc").write_text(PROGRAM)
    made = run(tmp_path, "plan part.nc --dialect shopfloor -o part.semi")
    assert made.returncode == 0, made.stderr
    rows = (tmp_path / "part.semi").read_text().splitlines()
    assert rows[0] == "t;x;y"
    assert [float(word) for word in rows[-1].split(";")][1:] == [10.0, 5.0]
