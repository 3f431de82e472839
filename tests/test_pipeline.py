"""The library: the stages in order, the language of a file, and the README's example."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cncgen
from cncgen.diagnostics import ProgramError, UsageError
from cncgen.pipeline import (
    canon,
    judge,
    language_of,
    plan_with_summary,
    read,
    read_text,
    report_page,
    variant_of,
)
from cncgen.pipeline.file_kinds import other_kind
from cncgen.planner import PlanOptions

SQUARE = "G21 G90 G61\nG0 X0 Y0\nG1 X10 F1200\nY10\nX0\nY0\nM2\n"


@pytest.mark.parametrize(
    ("name", "head", "language"),
    [
        ("a.nc", b"G0 X1", "gcode"),
        ("a.TAP", b"G0 X1", "gcode"),
        ("a.stp", b"", "stepnc"),
        ("a.STPNC", b"G0", "stepnc"),
        ("a.nc", b"ISO-10303-21;\nHEADER;", "stepnc"),
        ("-", b"\xef\xbb\xbf \nISO-10303-21;", "stepnc"),
        ("-", b"/* made by /* x **/ /*\xff*/\r\niso-10303-21 /* 2 */ ;", "stepnc"),
        ("a.nc", b"/* a comment longer than what was looked at " + b"*" * 4000, "stepnc"),
        ("a.nc", b"/* */ " * 600 + b"G0 X1", "gcode"),
        ("a.nc", b"/G0 X1 (ISO-10303-21;)", "gcode"),
        ("a.unknown", b"%", "gcode"),
    ],
)
def test_language(name: str, head: bytes, language: str) -> None:
    assert language_of(name, head) == language


@pytest.mark.parametrize(
    ("head", "what"),
    [
        (b'name = "mine"\nperiod_s = 0.001\n\n[axes.x]\n', "a machine file"),
        (b"solid a\n  facet normal 0 0 1\n", "a mesh"),
        (b"  0\r\nSECTION\r\n  2\r\nHEADER\r\n", "a drawing"),
        (b"%FSLAX24Y24*%\n%MOIN*%\n", "a layer"),
        (b"G04 a layer*\n%FSLAX24Y24*%\n", "a layer"),
        (b"<!DOCTYPE html>\n", "a web page"),
        (b"%PDF-1.4\n", "a PDF"),
        (b"PK\x03\x04" + bytes(26) + b"part.nc", "an archive"),
        (b"\x1f\x8b\x08\x00", "an archive"),
    ],
)
def test_a_file_of_another_kind_is_called_by_its_name(tmp_path: Path, head: bytes, what: str) -> None:
    """A machine in the place of the program, or a drawing, would give an error a line."""
    (tmp_path / "a.nc").write_bytes(head)
    with pytest.raises(cncgen.CncgenError) as raised:
        read(tmp_path / "a.nc")
    assert [one.code for one in raised.value.diagnostics] == ["not-a-program"]
    assert f"is {what}" in str(raised.value)
    assert read(tmp_path / "a.nc", language="gcode") is not None


@pytest.mark.parametrize(
    "text",
    [
        b"%\nO1\nG1 X1 F100\nM30\n%\n",
        b"G04 P1\nM2\n",
        b"; [axes.x] is a key\nM2\n",
        b"# 1=2\nM2\n",
        b"PK=5\n",
        b"",
    ],
)
def test_programs_are_no_file_of_another_kind(text: bytes) -> None:
    assert other_kind(text) is None


def test_the_example_of_the_readme(root: Path) -> None:
    text = (root / "README.md").read_text(encoding="utf-8")
    example = re.search(r"```python\n(.*?)```", text, re.S)
    assert example is not None
    lines = [line for line in example[1].splitlines() if line]
    assert len(lines) <= 10
    run = subprocess.run(
        [sys.executable, "-c", example[1]], cwd=root, capture_output=True, text=True, timeout=120, check=False
    )
    assert run.returncode == 0, run.stderr
    assert re.search(
        r"\d+\.\d{3} s, \d+ setpoints of axes XY\ncontour error at most \d+\.\d µm\n", run.stdout
    )


def test_stages_from_text_to_verdict() -> None:
    machine = cncgen.load_machine("xy-table")
    plan = cncgen.plan(read_text(SQUARE), machine, feedrate="constant")
    stream = cncgen.sample(plan, ("line", "feed"))
    assert (stream.axes, stream.period_s) == ("XY", 0.001)
    points = stream.collect()
    assert points.position[0].tolist() == points.position[-1].tolist() == [0.0, 0.0]
    assert set(points.signals) == {"line", "feed"}
    # 40 mm at 20 mm/s take at least 2 s.
    assert points.time_s[-1] >= 2.0
    np.testing.assert_allclose(np.abs(points.position).max(axis=0), 10.0, atol=1e-9)


@pytest.mark.parametrize("feedrate", ["optimal", "ild", "constant", "adaptive", "curvature"])
@pytest.mark.parametrize(
    ("text", "axes", "start"),
    [
        ("o<a> sub\ng0 x1\no<a> endsub\n", "X", [0.0]),
        ("G0 X0 Y0\n", "XY", [0.0, 0.0]),
        ("(START, X5 Y-2)\nG0 X5\nY-2\n", "XY", [5.0, -2.0]),
    ],
)
def test_a_program_that_asks_for_nothing_has_its_start(
    text: str, axes: str, start: list[float], feedrate: str
) -> None:
    """The first row is the start position at t = 0; it is the last one too, and stands still."""
    options = PlanOptions(feedrate=feedrate)
    signals = ("vel", "acc", "jerk", "feed", "line", "limit")
    stream, summary = plan_with_summary(read_text(text), "xy-table", options, signals)
    points = stream.collect()
    assert (points.axes, points.first, points.position.tolist()) == (axes, 0, [start])
    assert all(not np.any(values) for values in points.signals.values())
    assert summary.as_json()["samples"] == 1
    assert judge(points, read_text(text), "xy-table").holds
    beside = cncgen.Setpoints(axes, 0.001, 0, points.position + 0.1)
    assert not judge(beside, read_text(text), "xy-table").holds


@pytest.mark.parametrize(
    "how", [{"saturation": "reactive"}, {"saturation": "predictive"}, {"interpolator": "taylor2"}]
)
def test_stages_after_the_plan_of_nothing(how: dict[str, str]) -> None:
    plan = cncgen.plan(read_text("G0 X0 Y0\n"), "die-bonder", **how)
    assert cncgen.sample(plan).collect().position.tolist() == [[0.0, 0.0]]


def test_an_error_anywhere_ends_the_plan() -> None:
    with pytest.raises(ProgramError) as caught:
        list(cncgen.plan(read_text(SQUARE.replace("M2", "G1 X="), "part.nc"), "xy-table", feedrate="ild"))
    assert {d.span.file for d in caught.value.diagnostics if d.span} == {"part.nc"}


def test_summary_has_the_keys_of_the_interface() -> None:
    program = read_text("G21 G90 G61\nG1 X10 Y5 F1200\nG4 P0.5\nG1 X0\nM2\n", "part.nc")
    stream, summary = plan_with_summary(program, "xy-table", PlanOptions(feedrate="ild"))
    points = stream.collect()
    result = summary.as_json()
    assert set(result) >= {
        "schema_version", "program", "machine", "feedrate", "motion_time_s", "dwell_time_s", "path_length_mm",
        "motions", "samples", "period_s", "peak", "feed_mm_s", "feed_over_time_mm_s", "sharp_corners", "slowest", "diagnostics",
    }  # fmt: skip
    assert result["dwell_time_s"] == pytest.approx(0.5, abs=1e-9)
    assert result["path_length_mm"] == pytest.approx(np.hypot(10, 5) + 10, abs=1e-9)
    assert (result["motions"], result["samples"]) == (2, len(points))
    assert result["motion_time_s"] + 0.5 == pytest.approx(points.time_s[-1], abs=1e-3)
    padded = np.concatenate(
        [np.repeat(points.position[:1], 3, 0), points.position, np.repeat(points.position[-1:], 3, 0)]
    )
    for order, name in enumerate(("velocity", "acceleration", "jerk"), start=1):
        expected = np.abs(np.diff(padded, order, axis=0)).max(axis=0) / 0.001**order
        assert [result["peak"][k][name] for k in "xy"] == pytest.approx(expected, rel=1e-9)
    limit = cncgen.load_machine("xy-table").axes["X"].max_velocity
    assert result["peak"]["x"]["velocity_of_limit"] == pytest.approx(result["peak"]["x"]["velocity"] / limit)
    assert result["feed_mm_s"]["mean"] == pytest.approx(result["path_length_mm"] / result["motion_time_s"])


def test_turning_is_no_length() -> None:
    """Rotary axes alone move by radians: no length of path, no feed; with X it is X's."""
    text = "G21 G90 G61\nG1 X10 F600\nG0 A90\nG1 X20 A0 F600\nG1 A180 F9000\nM2\n"
    stream, summary = plan_with_summary(read_text(text), "generic-mill")
    stream.collect()
    result = summary.as_json()
    assert result["path_length_mm"] == pytest.approx(20.0, abs=1e-9)
    assert result["feed_mm_s"]["max"] == pytest.approx(10.0)
    assert 9.0 < result["feed_mm_s"]["mean"] < 10.0
    stream, summary = plan_with_summary(read_text("G0 A90\nM2\n"), "generic-mill")
    stream.collect()
    result = summary.as_json()
    assert (result["path_length_mm"], result["feed_mm_s"]) == (0.0, {"mean": 0.0, "max": 0.0})


def test_corners_are_counted_beyond_those_that_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cncgen.report.summary.MAX_CORNERS", 2)
    text = "G21 G90 G61 F600\n" + "".join(f"G1 X{k} Y{k % 2}\n" for k in range(1, 7)) + "M2\n"
    stream, summary = plan_with_summary(read_text(text), "xy-table", PlanOptions(feedrate="ild"))
    stream.collect()
    result = summary.as_json()
    assert (len(result["sharp_corners"]), result["sharp_corner_count"]) == (2, 5)


def test_slowest_places_name_line_and_limit() -> None:
    """A right angle between two long lines costs the most in the middle; start and end are the other places."""
    program = read_text("G21 G90 G61\nG1 X50 F6000\nY50\nM2\n")
    stream, summary = plan_with_summary(program, "xy-table", PlanOptions(feedrate="ild"))
    stream.collect()
    slowest = summary.as_json()["slowest"]
    assert 1 <= len(slowest) <= 10
    assert [p["lost_s"] for p in slowest] == sorted((p["lost_s"] for p in slowest), reverse=True)
    assert {p["line"] for p in slowest} <= {2, 3}
    corner = min(slowest, key=lambda p: abs(p["s_mm"] - 50))
    assert corner["s_mm"] == pytest.approx(50, abs=5)


def test_standard_input(monkeypatch: pytest.MonkeyPatch) -> None:
    raw = io.BufferedReader(io.BytesIO(SQUARE.encode()))  # type: ignore[arg-type]
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(raw))
    program = cncgen.read("-")
    assert sum(len(chunk) for chunk in program.chunks()) >= 5


def test_canon_of_a_file(programs: Path) -> None:
    lines = list(canon(programs / "square_sharp.nc"))
    assert any("STRAIGHT_FEED(0.0000, 50.0000" in line for line in lines)
    with pytest.raises(UsageError, match="no such file"):
        list(canon(programs / "none.nc"))


def test_verify_in_the_library() -> None:
    program = "G21 G90 G61\nG1 X10 F600\nM2\n"
    machine = cncgen.load_machine("xy-table")
    stream = cncgen.sample(cncgen.plan(read_text(program), machine, feedrate="ild"))
    verdict = judge(stream, read_text(program), machine)
    assert verdict.holds
    assert verdict.as_json()["holds"] is True


def test_a_file_that_is_no_regular_file(tmp_path: Path) -> None:
    """A named pipe is read as a stream."""
    import os
    import threading

    pipe = tmp_path / "pipe.nc"
    os.mkfifo(pipe)
    writer = threading.Thread(target=lambda: pipe.write_text(SQUARE))
    writer.start()
    program = cncgen.read(pipe)
    writer.join()
    assert sum(len(chunk) for chunk in program.chunks()) >= 5


def test_the_summary_names_the_strategy_that_is_taken_by_itself() -> None:
    stream, summary = plan_with_summary(read_text(SQUARE), "xy-table")
    stream.collect()
    assert summary.as_json()["feedrate"] == "optimal"


def test_a_language_that_is_told_is_not_guessed() -> None:
    """G-code under the name of a STEP file, and read as one where that is asked for."""
    guessed = read_text(SQUARE, "part.stp")
    list(guessed.chunks())
    assert guessed.diagnostics.has_errors
    told = read_text(SQUARE, "part.stp", language="gcode")
    assert sum(len(chunk) for chunk in told.chunks()) >= 5
    assert not told.diagnostics.has_errors
    assert read_text(SQUARE, "part.nc", language="stepnc").language == "stepnc"


def test_a_page_has_a_verdict(tmp_path: Path) -> None:
    """A program is verified in the language that it was read in, and one from memory too."""
    file = tmp_path / "square.stp"
    file.write_text(SQUARE)
    page = report_page(cncgen.read(file, language="gcode"), "xy-table")
    assert '"verdict":{"holds":true' in page.html
    assert '"verdict":{"holds":true' in report_page(read_text(SQUARE), "xy-table").html


INCREMENTS = "[interpreter]\nleast_increment_mm = 0.001"
TABLES = '[kinematics]\nmodel = "table-table"\naxes = ["a", "c"]\ncentre_mm = [0.0, 0.0, -150.0]'
SHORT = "O1\nG21 G90\nG1 X10 F60000\nM30\n"
TIP = "O1\nG21 G90\nG43.4 H0\nG1 A30. F600.\nG49\nM30\n"


@pytest.mark.parametrize(
    ("table", "text", "end"),
    [
        pytest.param(INCREMENTS, SHORT, {"X": 0.01}, id="numbers without a point count increments"),
        # The table turns the tip by -30 degrees about its axis, 150 mm below: (0, 150 sin 30, 150 cos 30 - 150).
        pytest.param(
            TABLES, TIP, {"Y": 75.0, "Z": 150.0 * (3**0.5 / 2 - 1), "A": np.pi / 6}, id="tilting table"
        ),
    ],
)
@pytest.mark.parametrize("from_memory", [True, False])
def test_a_program_is_read_as_the_machine_has_it(
    tmp_path: Path, root: Path, table: str, text: str, end: dict[str, float], from_memory: bool
) -> None:
    """One that was read for no machine, and planned on another one before, too."""
    shipped = (root / "cncgen/machine/profiles/generic-mill.toml").read_text()
    (tmp_path / "own.toml").write_text(shipped.replace("[times]", f"{table}\n\n[times]"))
    (tmp_path / "part.nc").write_text(text)
    program = read_text(text, dialect="fanuc") if from_memory else read(tmp_path / "part.nc", dialect="fanuc")
    if text is SHORT:
        elsewhere = cncgen.sample(cncgen.plan(program, "generic-mill")).collect()
        assert elsewhere.position[-1, elsewhere.axes.index("X")] == pytest.approx(10.0)
    else:
        with pytest.raises(ProgramError, match="tcp-machine"):
            list(cncgen.plan(program, "generic-mill"))
    planned = cncgen.plan(program, tmp_path / "own.toml")
    found = cncgen.sample(planned).collect()
    for axis, position in end.items():
        assert found.position[-1, found.axes.index(axis)] == pytest.approx(position, abs=1e-6)
    assert judge(found, program, tmp_path / "own.toml").holds


def test_a_page_reads_a_program_for_each_machine(tmp_path: Path, root: Path) -> None:
    """X10 is 10 mm on the one and 0.01 mm on the other; times of one straight motion from rest to rest, J T³ / 32 = X."""
    shipped = (root / "cncgen/machine/profiles/generic-mill.toml").read_text()
    (tmp_path / "own.toml").write_text(shipped.replace("[times]", f"{INCREMENTS}\n\n[times]"))
    variant = variant_of(f"machine={tmp_path / 'own.toml'}")
    page = report_page(read_text(SHORT, dialect="fanuc"), "generic-mill", compare=[variant])
    header = re.search(r'<script type="application/json" id="header">(.*?)</script>', page.html, re.S)
    assert header
    times = [part["summary"]["motion_time_s"] for part in json.loads(header[1])["parts"]]
    assert times == pytest.approx([(32 * x / 5e4) ** (1 / 3) for x in (10.0, 0.01)], abs=0.002)
