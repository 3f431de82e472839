"""The pages: commands, options, files, tables and references that they name are there, and their examples run."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest

import cncgen
from cncgen.cli.commands import cli
from cncgen.machine import load
from cncgen.machine.reading import machine_from_toml
from cncgen.planner.record import Limit

ROOT = Path(__file__).resolve().parent.parent
PAGES = ["README.md", *sorted(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md"))]


def text_of(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def command_lines(page: str) -> list[list[str]]:
    """Return the words of each command line in a code block or between backticks, a pipe's parts apart."""
    text = text_of(page)
    fenced = re.findall(r"^```(\S*)\n(.*?)^```$", text, re.M | re.S)
    blocks = [code for kind, code in fenced if kind in ("", "sh")] + re.findall(r"(?:^    .*\n)+", text, re.M)
    lines = [line.strip() for block in blocks for line in block.splitlines()]
    lines += [" ".join(span.split()) for span in re.findall(r"(?<!`)`([^`]+)`(?!`)", text)]
    parts = [part.strip() for line in lines for part in re.split(r"[|>]", line)]
    return [shlex.split(part, comments=True) for part in parts if part.startswith("cncgen ")]


def command_of(words: list[str]) -> tuple[click.Command, list[str]]:
    """Return the command that words after ``cncgen`` name, and the words that follow it."""
    command: click.Command = cli
    while words and isinstance(command, click.Group):
        found = command.get_command(click.Context(command), words[0])
        if found is None and "run" in getattr(command, "commands", ()):  # a word that may be left out
            return command.commands["run"], words
        if found is None:
            break
        command, words = found, words[1:]
    return command, words


@pytest.mark.parametrize("page", PAGES)
def test_command_lines_name_commands_and_options_that_are_there(page: str) -> None:
    """In capitals stand values of the reader's own; a word that is one of several choices is one of them."""
    for line in command_lines(page):
        if line[1:] == ["COMMAND", "--help"]:
            continue
        command, rest = command_of(line[1:])
        assert command is not cli, line
        options = {flag: item for item in command.params for flag in (*item.opts, *item.secondary_opts)}
        for word, value in zip(rest, [*rest[1:], "…"], strict=True) if rest else ():
            if word.startswith("-") and word != "-":
                assert word in options, line
                kind = options[word].type
                if isinstance(kind, click.Choice) and value != "…":
                    assert value in kind.choices, line


def test_command_lines_are_found() -> None:
    """The test above would pass where none is."""
    assert [line[1] for line in command_lines("README.md")].count("plan") >= 2
    assert ["cncgen", "check", "--tree", "part.stp"] in command_lines("docs/stepnc.md")


@pytest.mark.parametrize("page", PAGES)
def test_files_that_the_pages_name_are_there(page: str) -> None:
    names = re.findall(r"`((?:cncgen|grammars|programs|benchmarks|tests|docs)/[\w./-]*)`", text_of(page))
    missing = [name for name in names if not (ROOT / name).exists()]
    assert not missing


def test_the_readme_names_every_limit() -> None:
    """By its number in the column, in order."""
    (said,) = re.findall(r"`limit` says what holds the speed back: ([^.]*)\.", text_of("README.md"))
    numbers = [int(part.split()[0]) for part in said.replace("\n", " ").split(", ")]
    names = [part.split(maxsplit=1)[1].split()[0] for part in said.replace("\n", " ").split(", ")]
    assert numbers == [limit.value for limit in Limit]
    assert names[1:] == [limit.name.lower().split("_")[0] for limit in Limit][1:]


def test_the_readmes_machine_is_one() -> None:
    (table,) = re.findall(r"```toml\n(.*?)```", text_of("README.md"), re.S)
    machine = machine_from_toml(table.encode(), "mine.toml")
    assert machine.name == "mine"
    assert machine.axes["X"].travel == (-500.0, 500.0)


def test_the_coupling_table_is_one(tmp_path: Path) -> None:
    """Its keys are those that the schemes read, beside any machine."""
    (table,) = re.findall(r"```toml\n(.*?)```", text_of("docs/controllers.md"), re.S)
    profile = (ROOT / "cncgen/machine/profiles/xy-table.toml").read_text(encoding="utf-8")
    assert "[coupling]" not in profile
    (tmp_path / "m.toml").write_text(profile + table, encoding="utf-8")
    from cncgen.servo.named_schemes import settings_of

    coupling = load(tmp_path / "m.toml").settings["coupling"]
    assert dict(coupling) == tomllib.loads(table)["coupling"]
    assert settings_of(coupling)


def test_the_readmes_commands_run(tmp_path: Path) -> None:
    """Those of its section on the command, in order, in a shell, on a part of its own."""
    if not (shell := shutil.which("bash")):
        pytest.skip("bash is not installed")
    shutil.copy(ROOT / "programs" / "square_r5.nc", tmp_path / "part.nc")
    section = text_of("README.md").split("## As a command")[1]
    block = re.search(r"\n((?:    cncgen [^\n]*\n)+)", section)
    assert block is not None
    script = f'set -eo pipefail\ncncgen() {{ "{sys.executable}" -m cncgen "$@"; }}\n{block[1]}'
    run = subprocess.run(
        [shell, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=240, check=False
    )
    assert run.returncode == 0, run.stderr[-2000:]
    assert {path.name for path in tmp_path.iterdir()} >= {"part.csv", "part.html", "response.csv"}


def test_the_examples_of_the_library_run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One after the other, from the top of the checkout; what they print is what the page says of it."""
    monkeypatch.chdir(ROOT)
    code = re.findall(r"```python\n(.*?)```", text_of("docs/library.md"), re.S)
    names: dict[str, Any] = {}
    exec(compile("".join(code), "library.md", "exec"), names)
    radius = float(np.hypot(*names["steady"].T).mean())
    assert 20.0 - radius == pytest.approx(20.0 * (1.0 - 1.0 / np.hypot(1.0, 2.5 / 80.0)), rel=0.1)
    fit = names["fit"]
    for name, value in names["drive"].parameters.items():
        assert abs(fit.parameters[name] - value) < 4.0 * fit.uncertainty[name]
    said = capsys.readouterr().out
    assert said.startswith("optimal: ")
    assert said.endswith("arc-radius 2 1.0\n")


def test_the_library_page_has_every_public_name() -> None:
    (table,) = re.findall(r"\| name \|.*?\n\n", text_of("docs/library.md"), re.S)
    said = set(re.findall(r"^\| ((?:`\w+`(?:, )?)+)", table, re.M))
    named = {name for cell in said for name in re.findall(r"`(\w+)`", cell)}
    shown = {"Setpoints", "Diagnostic", "__version__"}  # what stages hand on, and what errors carry
    assert named | shown == set(cncgen.__all__)


#: Author and year, as docstrings and pages cite: the last of the names that stand before the year.
_CITED = re.compile(
    r"\b([A-Z][a-zåäöéü]+)(?:(?: and|,? et al\.)[^.;()]{0,30})?,? \(?((?:19|20)\d\d)\b(?! mm)", re.S
)
#: What looks so and is the name of a standard, a journal or a book.
_NO_AUTHOR = {"Convention", "Interpreter", "Systems", "Machines", "Geometry", "Paris", "The"}


def test_what_is_cited_stands_among_the_references() -> None:
    references = text_of("docs/references.md")
    missing = set()
    for path in [*(ROOT / "cncgen").rglob("*.py"), *(ROOT / page for page in PAGES)]:
        for author, year in _CITED.findall(path.read_text(encoding="utf-8")):
            entries = [entry for entry in re.split(r"\n- |\n\|", references) if author in entry]
            if author not in _NO_AUTHOR and not any(year in entry for entry in entries):
                missing.add(f"{path.relative_to(ROOT)}: {author} {year}")
    assert not missing
