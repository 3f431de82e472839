"""Each diagnostic is explained, and each example gives the diagnostic that it is for."""

from __future__ import annotations

import ast
import json
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from cncgen.cli import app
from cncgen.explanations import ROOMS, codes, cure_of, explanation

PACKAGE = Path(__file__).resolve().parent.parent / "cncgen"
#: What makes a diagnostic of the code that is among its first arguments.
MAKERS = re.compile(
    r"Diagnostic|BlockError|CompensationError|error|warning|_?warn|_?fault|_?note|_?fail|_?report(_row)?"
)
#: Codes of one word; what has a hyphen is a code wherever it stands.
WORDS = {
    "argument",
    "dialect",
    "domain",
    "internal",
    "interrupted",
    "smoothing",
    "syntax",
    "system",
    "timer",
    "usage",
}


def reported() -> dict[str, str]:
    """Return the codes that are written in the source, each with a module that reports it."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.Call):
                continue
            name = getattr(node.func, "id", getattr(node.func, "attr", ""))
            if not MAKERS.fullmatch(name):
                continue
            for value in (one.value for one in node.args[:3] if isinstance(one, ast.Constant)):
                if isinstance(value, str) and (
                    value in WORDS or re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)+", value)
                ):
                    found[value] = path.relative_to(PACKAGE).as_posix()
    return found


def test_every_code_is_explained_and_each_once() -> None:
    missing = {code: where for code, where in reported().items() if code not in codes()}
    assert missing == {}
    assert len(reported()) > 300
    assert len(set(codes())) == len(codes())


def test_explanations_are_whole_sentences_with_a_cure() -> None:
    for code in codes():
        found = explanation(code)
        assert found is not None
        assert found.room in ROOMS
        assert found.cause[0].isupper() or found.cause.startswith("cncgen"), code
        assert found.cause.endswith("."), code
        assert found.cure, code
        assert found.command, code


def test_the_package_holds_the_explanations() -> None:
    """Each room with a file is asked, and its file is package data."""
    assert {path.parent.name for path in PACKAGE.rglob("explanations.toml")} == set(ROOMS)
    project = tomllib.loads((PACKAGE.parent / "pyproject.toml").read_text(encoding="utf-8"))
    data = project["tool"]["setuptools"]["package-data"]
    assert [room for room in ROOMS if "explanations.toml" not in data.get(f"cncgen.{room}", [])] == []
    assert "bad/*.nc" in data["cncgen.programs"]


@pytest.mark.parametrize("code", codes())
def test_an_example_gives_its_code(
    code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    found = explanation(code)
    assert found is not None
    monkeypatch.chdir(tmp_path)
    for name, text in found.every_file().items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text.lstrip("\n"), encoding="utf-8")
    for line in found.command.strip().splitlines():
        if line.startswith("python "):  # what writes a file that is too long to print, or uses the library
            words = [sys.executable, *line.split(" ", 1)[1:]]
            run = subprocess.run(" ".join(words), shell=True, capture_output=True, text=True, check=False)
            print(run.stdout, run.stderr)
            continue
        words = shlex.split(line)
        while "=" in words[0]:  # a variable of the environment
            monkeypatch.setenv(*words.pop(0).split("=", 1))
        assert words[0] == "cncgen"
        bound = ["--max-steps", "20000"] if words[1] == "check" and "--max-steps" not in words else []
        app.run([*words[1:], *bound])
    said = "".join(capfd.readouterr())
    assert f"[{code}]" in said or f'"code": "{code}"' in said


def test_explain_prints_the_page(capfd: pytest.CaptureFixture[str]) -> None:
    assert app.run(["explain", "arc-radius"]) == 0
    said = capfd.readouterr().out
    assert said.startswith("arc-radius: The words of an arc fit no circle")
    assert "    $ cncgen check example.nc" in said


def test_an_unknown_code_names_those_that_are_near(capfd: pytest.CaptureFixture[str]) -> None:
    assert app.run(["explain", "arc-radus"]) == 2
    assert "is arc-radius" in capfd.readouterr().err


def test_json_says_where_more_is_said(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "part.nc").write_text("G21 G1 X1\nM2\n")
    app.run(["check", str(tmp_path / "part.nc"), "--json"])
    (line,) = capfd.readouterr().out.splitlines()
    assert json.loads(line)["explain"] == "cncgen explain feed-missing"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("G21 G1 X1\nM2\n", "cncgen explain feed-missing has cause, cure and an example"),
        (
            "G21 G1 X1\nQ7\nM2\n",
            "cncgen explain CODE has cause, cure and an example of each, as cncgen explain feed-missing",
        ),
    ],
)
def test_who_reads_at_a_terminal_is_told_of_the_page(
    text: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "part.nc").write_text(text)
    app.run(["check", str(tmp_path / "part.nc")])
    assert "cncgen explain" not in capsys.readouterr().err
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    app.run(["check", str(tmp_path / "part.nc")])
    assert capsys.readouterr().err.splitlines()[-1] == told


def test_a_cure_is_that_of_the_file() -> None:
    """One is looked up without reading the file as TOML."""
    for code in codes():
        found = explanation(code)
        assert found is not None
        assert cure_of(found.room, code) == found.cure, code
    assert cure_of("gcode", "no-such-code") == ""


def test_the_cure_of_faults_of_one_kind_is_looked_up_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search through the explanations takes a hundred times as long as reading a line, and each line may have the fault."""
    reads = []
    read = Path.read_text
    monkeypatch.setattr(Path, "read_text", lambda path, **how: (reads.append(path), read(path, **how))[1])
    cure_of.cache_clear()
    assert len({cure_of("gcode", "syntax") for _ in range(3)}) == len(reads) == 1
