"""`check --output-format`: SARIF by the structure of its standard, GitHub's commands by their escapes, JSON lines."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from cncgen.cli import app
from cncgen.diagnostics import Diagnostic, Severity, Span
from cncgen.report.annotations import github


@pytest.fixture
def part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A program with an arc that no circle is, in line 2, and without an end."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a part.nc").write_text("G21 G90 G17\nG2 X10 Y0 I4 J0 F100\n")
    return tmp_path / "a part.nc"


def check(part: Path, output_format: str, capfd: pytest.CaptureFixture[str]) -> str:
    assert app.run(["check", part.name, "--output-format", output_format]) == 1
    return capfd.readouterr().out


def test_sarif_has_a_rule_a_code_and_a_place_a_result(part: Path, capfd: pytest.CaptureFixture[str]) -> None:
    log = json.loads(check(part, "sarif", capfd))
    assert log["version"] == "2.1.0"
    (run,) = log["runs"]
    rules = run["tool"]["driver"]["rules"]
    found = {rules[one["ruleIndex"]]["id"]: one for one in run["results"]}
    assert {rule["id"] for rule in rules} == set(found) == {one["ruleId"] for one in run["results"]}
    arc = found["arc-radius"]
    assert arc["level"] == "error"
    place = arc["locations"][0]["physicalLocation"]
    assert place["artifactLocation"]["uri"] == "a%20part.nc"
    # The word I4, from column 12 up to the one behind it.
    assert place["region"]["startLine"] == 2
    line = part.read_text().splitlines()[1]
    region = place["region"]
    assert line[region["startColumn"] - 1 : region["endColumn"] - 1].strip() in ("I4", "X10", "G2")
    assert found["no-program-end"]["level"] == "warning"
    assert all(rule["shortDescription"]["text"].endswith(".") for rule in rules)


def test_a_program_without_faults_is_an_empty_log(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "part.nc").write_text("G21 G90\nG0 X1\nM2\n")
    assert app.run(["check", str(tmp_path / "part.nc"), "--output-format", "sarif"]) == 0
    assert json.loads(capfd.readouterr().out)["runs"][0]["results"] == []


def test_github_names_file_line_and_column(part: Path, capfd: pytest.CaptureFixture[str]) -> None:
    lines = check(part, "github", capfd).splitlines()
    arc = next(line for line in lines if "title=arc-radius" in line)
    assert re.match(r"::error file=a part\.nc,line=2,col=\d+,title=arc-radius::", arc)
    assert any(line.startswith("::warning ") and "no-program-end" in line for line in lines)


def test_what_would_end_a_command_of_github_is_escaped() -> None:
    """%, line breaks, and in values colon and comma (GitHub's toolkit, `command.ts`)."""
    item = Diagnostic("a-b", "50 % of\nall", Severity.NOTE, Span("C:\\x,y.nc", 3, 1), hint="h")
    assert (
        github([item]) == "::notice file=C%3A\\x%2Cy.nc,line=3,col=1,title=a-b::50 %25 of%0Aall%0Ahelp: h\n"
    )


def test_json_is_that_of_the_option(part: Path, capfd: pytest.CaptureFixture[str]) -> None:
    by_format = check(part, "json", capfd)
    app.run(["check", part.name, "--json"])
    assert by_format == capfd.readouterr().out
    assert [json.loads(line)["code"] for line in by_format.splitlines()].count("arc-radius") == 1


def test_a_file_that_is_missing_is_a_result_without_a_place(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert app.run(["check", str(tmp_path / "no.nc"), "--output-format", "sarif"]) == 2
    (one,) = json.loads(capfd.readouterr().out)["runs"][0]["results"]
    assert (one["ruleId"], "locations" in one) == ("file-read", False)
