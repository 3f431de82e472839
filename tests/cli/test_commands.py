"""Commands as a person uses them: what they print, and that a chain of them works."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import threading
import tomllib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from cncgen.cli import options
from cncgen.cli.app import run
from cncgen.gcode.codes.table import table

Run = Callable[..., "subprocess.CompletedProcess[bytes]"]

PROGRAM = b"G21 G17 G90 G61\nM3 S1000\nG0 X0 Y0\nG1 X10 F1200\nG4 P0.1\nG3 X20 Y0 I5\n(MSG, done)\nM30\n"


@pytest.fixture
def part(tmp_path: Path) -> Path:
    path = tmp_path / "part.nc"
    path.write_bytes(PROGRAM)
    return path


def test_machines(cncgen: Run, root: Path) -> None:
    listed = cncgen("machines").stdout.decode().splitlines()
    names = [line.split()[0] for line in listed]
    assert names == sorted(path.stem for path in (root / "cncgen" / "machine" / "profiles").glob("*.toml"))
    assert {"die-bonder", "dyna-1007", "generic-lathe", "generic-mill", "xy-table"} <= set(names)
    shown = cncgen("machines", "show", "xy-table").stdout.decode()
    assert tomllib.loads(shown)["axes"]["x"]["max_acceleration_mm_s2"] == 2450.0


def test_a_shown_machine_can_be_edited_and_used(cncgen: Run, tmp_path: Path, part: Path) -> None:
    text = cncgen("machines", "show", "generic-mill").stdout.decode()
    (tmp_path / "mine.toml").write_text(text.replace("period_s = 0.001", "period_s = 0.004"))
    run = cncgen("plan", part, "-m", "mine.toml", "--feedrate", "ild")
    assert run.returncode == 0, run.stderr.decode()
    assert run.stdout.splitlines()[2].startswith(b"0.004000000,")
    again = cncgen("machines", "show", "mine.toml").stdout.decode()
    assert tomllib.loads(again)["period_s"] == 0.004


def test_codes_are_those_of_the_interpreter(cncgen: Run) -> None:
    listed = cncgen("codes", "--dialect", "linuxcnc").stdout.decode().splitlines()[2:]
    names = {code.name for code in table("linuxcnc").values() if code.group != "user"}
    assert {line.split("|")[1].strip() for line in listed} == names | {"M100 … M199"}
    assert all(line.split("|")[4].strip() for line in listed), "a code without a line of help"


@pytest.mark.parametrize("strategy", ["optimal", "ild", "constant", "adaptive", "curvature"])
def test_each_strategy_plans_from_start_to_end(
    cncgen: Run, part: Path, tmp_path: Path, strategy: str
) -> None:
    run = cncgen("plan", part, "--feedrate", strategy, "--summary", "s.json", "-o", "out.csv")
    assert run.returncode == 0, run.stderr.decode()
    table = np.loadtxt(tmp_path / "out.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(table[0], [0, 0, 0], atol=1e-9)
    np.testing.assert_allclose(table[-1, 1:], [20, 0], atol=1e-9)
    np.testing.assert_allclose(np.diff(table[:, 0]), 0.001, atol=1e-9)
    summary = json.loads((tmp_path / "s.json").read_text())
    assert summary["feedrate"] == strategy
    assert summary["dwell_time_s"] == pytest.approx(0.1, abs=1e-9)
    assert summary["path_length_mm"] == pytest.approx(10 + 5 * np.pi, abs=1e-6)
    assert summary["samples"] == len(table)


def test_plan_verify_and_simulate_in_a_chain(cncgen: Run, part: Path, tmp_path: Path) -> None:
    planned = cncgen("plan", part, "-m", "xy-table")
    assert planned.returncode == 0, planned.stderr.decode()
    (tmp_path / "out.csv").write_bytes(planned.stdout)
    judged = cncgen("verify", "out.csv", "--program", part, "--machine", "xy-table", "--report", "v.json")
    assert judged.returncode == 0, judged.stderr.decode()
    assert b"broken: none" in judged.stderr
    assert json.loads((tmp_path / "v.json").read_text())["holds"] is True
    answered = cncgen("simulate", "--axis-params", "xy-table", stdin=planned.stdout)
    assert answered.returncode == 0, answered.stderr.decode()
    header, *rows = answered.stdout.decode().splitlines()
    assert (
        header == "t_s,x_cmd_mm,x_mm,x_force,x_saturated,y_cmd_mm,y_mm,y_force,y_saturated,contour_error_mm"
    )
    assert len(rows) == len(planned.stdout.splitlines()) - 1
    by_program = cncgen("simulate", part, "-m", "xy-table", "--axis-params", "xy-table")
    assert by_program.returncode == 0, by_program.stderr.decode()
    assert by_program.stdout.splitlines()[0].decode() == header


def test_verify_says_where_a_limit_is_broken(cncgen: Run, part: Path, tmp_path: Path) -> None:
    assert cncgen("plan", part, "-m", "xy-table", "-o", "out.csv").returncode == 0
    lines = (tmp_path / "out.csv").read_text().splitlines()
    at = len(lines) // 2
    t_s, x, y = map(float, lines[at].split(","))
    lines[at] = f"{t_s:.9f},{x + 0.01:.9f},{y:.9f}"
    (tmp_path / "bent.csv").write_text("\n".join(lines) + "\n")
    run = cncgen("verify", "bent.csv", "--program", part, "--machine", "xy-table", "--json")
    assert run.returncode == 1
    said = run.stderr.decode()
    records = [json.loads(line) for line in said.splitlines() if line.startswith("{")]
    broken = {record["code"]: record["values"] for record in records}
    assert set(broken) >= {"verify-acceleration", "verify-jerk"}
    assert broken["verify-jerk"]["axis"] == "X"
    assert abs(broken["verify-jerk"]["t_s"] - t_s) < 0.003


def test_setpoints_of_others_with_their_own_period(cncgen: Run, tmp_path: Path) -> None:
    """A line of 10 mm as a cosine at 2 kHz: within the limits; and on another line: not covered."""
    (tmp_path / "line.nc").write_text("G21 G90 G61\nG1 X10 F6000\nM2\n")
    k = np.arange(1001)
    tau = k / 1000
    x = 10 * (tau - np.sin(2 * np.pi * tau) / (2 * np.pi))
    rows = "\n".join(f"{0.0005 * i:.4f},{value:.9f}" for i, value in zip(k, x, strict=True))
    (tmp_path / "theirs.csv").write_text(f"t_s,x_mm\n{rows}\n")
    good = cncgen("verify", "theirs.csv", "--program", "line.nc", "--machine", "xy-table")
    assert good.returncode == 0, good.stderr.decode()
    (tmp_path / "line.nc").write_text("G21 G90 G61\nG1 X11 F6000\nM2\n")
    short = cncgen("verify", "theirs.csv", "--program", "line.nc", "--machine", "xy-table")
    assert short.returncode == 1
    assert b"verify-coverage" in short.stderr


def test_events_and_signals(cncgen: Run, part: Path, tmp_path: Path) -> None:
    run = cncgen(
        "plan", part, "-o", "o.csv", "--signals", "vel,feed,line", "--events", "e.jsonl", "--feedrate", "ild"
    )
    assert run.returncode == 0, run.stderr.decode()
    lines = (tmp_path / "o.csv").read_text().splitlines()
    assert lines[0] == "t_s,x_mm,y_mm,x_vel_mm_s,y_vel_mm_s,feed_mm_s,line"
    assert {line.rsplit(",", 1)[1] for line in lines[1:]} <= set("2345678")
    events = [json.loads(line) for line in (tmp_path / "e.jsonl").read_text().splitlines()]
    assert [e["t_s"] for e in events] == sorted(e["t_s"] for e in events)
    assert {"spindle", "dwell"} <= {e["event"] for e in events}
    assert all(set(e) >= {"t_s", "line", "event"} for e in events)


def test_quiet_says_nothing_when_all_is_well(cncgen: Run, part: Path) -> None:
    run = cncgen("plan", part, "-q", "-o", "o.csv")
    assert (run.returncode, run.stderr) == (0, b"")


def test_summary_on_standard_error(cncgen: Run, part: Path) -> None:
    run = cncgen("plan", part, "-q", "-o", "o.csv", "--summary", "-")
    assert json.loads(run.stderr)["schema_version"] == 1


def test_a_plan_that_breaks_limits_says_so(cncgen: Run, part: Path) -> None:
    """A constant feed steps at the start: F1200 is 20 mm/s, in a period of 1 ms 20000 mm/s² against 2450."""
    run = cncgen("plan", part, "-m", "xy-table", "--feedrate", "constant", "-q", "-o", "o.csv", "--json")
    assert run.returncode == 0
    (warning,) = [json.loads(line) for line in run.stderr.splitlines()]
    assert warning["code"] == "plan-over-limits"
    assert warning["severity"] == "warning"
    assert "constant asks more than the machine's limits: X acceleration 816.3 %" in warning["message"]


def test_the_interpolator_that_breaks_limits_is_named(cncgen: Run, part: Path) -> None:
    """The feed is that of `optimal` already, so another interpolator is what keeps the limits."""
    run = cncgen(
        "plan", part, "-m", "xy-table", "--interpolator", "two-stage-linear", "-q", "-o", "o.csv", "--json"
    )
    said = {item["code"]: item for item in map(json.loads, run.stderr.splitlines())}
    assert set(said) == {"plan-over-limits", "two-stage-distance"}
    warning = said["plan-over-limits"]
    assert "optimal with two-stage-linear interpolation asks more" in warning["message"]
    assert "--interpolator arclength" in warning["hint"]


def on_terminal(arguments: list[str], cwd: Path) -> tuple[int, str]:
    """Run the command with a terminal of 40 columns behind standard output and error; return its code and text."""
    pty = pytest.importorskip("pty")
    controller, terminal = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "cncgen", *arguments],
        stdin=subprocess.DEVNULL,
        stdout=terminal,
        stderr=terminal,
        cwd=cwd,
        env={**os.environ, "COLUMNS": "40"},
    )
    os.close(terminal)
    pieces = []
    with suppress(OSError):  # the terminal is gone when the command has ended
        while piece := os.read(controller, 65_536):
            pieces.append(piece)
    os.close(controller)
    return process.wait(timeout=60), b"".join(pieces).decode()


def test_on_a_terminal_the_summary_stands_alone(part: Path, tmp_path: Path) -> None:
    """No stream unless it is asked for, never a binary one, and no colours or cursor movements but those of progress."""
    code, said = on_terminal(["plan", str(part)], tmp_path)
    assert code == 0
    assert "t_s,x_mm" not in said
    assert "motions" in said
    # A machine that has much else to do shows progress.
    assert "\x1b" not in re.sub(r"\r[^\r\n]*\x1b\[K", "", said)
    code, said = on_terminal(["plan", str(part), "-o", "-", "-q"], tmp_path)
    assert code == 0
    assert said.startswith("t_s,x_mm,y_mm\r\n0.000000000,")
    code, said = on_terminal(["plan", str(part), "-o", "-", "--format", "f64"], tmp_path)
    assert code == 2
    assert "binary" in said
    code, said = on_terminal(["excite", "--axis", "x", "-o", "-", "--format", "f64"], tmp_path)
    assert code == 2
    assert "binary" in said
    code, said = on_terminal(["simulate", str(part), "-m", "xy-table"], tmp_path)
    assert code == 0
    assert "contour error" in said
    assert "x_cmd_mm" not in said


def test_a_drive_that_saturates_is_said_with_its_line(cncgen: Run, programs: Path, tmp_path: Path) -> None:
    """The corners of the bonder at 12 m/min: reactive limiting leaves some ticks (docs/saturation.md)."""
    fast = (programs / "bonder.nc").read_text().replace("F6000", "F12000")
    (tmp_path / "fast.nc").write_text(fast)
    how = ("--feedrate", "constant", "--interpolator", "uniform", "--saturation", "reactive")
    run = cncgen("plan", "fast.nc", "-m", "die-bonder", *how, "-q", "-o", "o.csv", "--json")
    assert run.returncode == 0
    found = {item["code"]: item for item in map(json.loads, run.stderr.splitlines())}
    assert found["drive-saturates"]["severity"] == "warning"
    assert "near line 28" in found["drive-saturates"]["message"]


def test_rounding_is_no_broken_limit(cncgen: Run, part: Path, tmp_path: Path) -> None:
    """A jerk limit of 1e-6 mm/s³ is kept; doubles near 20 mm make some 1e-14 / T³ of noise, 1e-5 mm/s³."""
    shown = cncgen("machines", "show", "xy-table").stdout.decode()
    slow = re.sub(r"max_jerk_mm_s3 = .*", "max_jerk_mm_s3 = 1e-6", shown)
    (tmp_path / "slow.toml").write_text(slow)
    (tmp_path / "tiny.nc").write_text("G21 G61\n(START, X20 Y20)\nG1 X20.00001 F1000\nM2\n")
    run = cncgen("plan", "tiny.nc", "-m", "slow.toml", "-q", "-o", "o.csv", "--json")
    assert run.returncode == 0
    assert {json.loads(line)["code"] for line in run.stderr.splitlines()} == {
        "machine-doubt",
        "plan-rounding",
    }


@pytest.mark.parametrize("kind", ["csv", "jsonl", "npy", "npz", "f64", "hal", "arrow"])
@pytest.mark.parametrize("text", ["M2\n", "G0 X0 Y0 Z0\n"])
def test_a_program_without_motion_has_one_setpoint(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str, text: str
) -> None:
    """A single row tells no period: the file states it, or the machine has it."""
    (tmp_path / "still.nc").write_text(text)
    program, setpoints = str(tmp_path / "still.nc"), str(tmp_path / f"s.{kind}")
    assert run(["plan", program, "-q", "-o", setpoints]) == 0
    assert run(["verify", setpoints, "-p", program]) == 0
    assert run(["simulate", setpoints, "--axes", "x,y,z"]) == 0
    out, err = capsys.readouterr()
    assert "1 setpoint every 1 ms" in err
    header, row = out.splitlines()
    assert header.startswith("t_s,x_cmd_mm,")
    assert set(row.split(",")) == {"0.000000000", "0"}


def test_one_setpoint_is_compensated(tmp_path: Path) -> None:
    """It has the machine's period, and the command rests where it does."""
    (tmp_path / "one.csv").write_text("t_s,x_mm,y_mm\n0,5,-2\n")
    output = tmp_path / "command.csv"
    assert run(["compensate", str(tmp_path / "one.csv"), "-m", "xy-table", "-q", "-o", str(output)]) == 0
    rows = output.read_text().splitlines()[1:]
    assert {row.split(",", 1)[1] for row in rows} == {"5.000000000,-2.000000000"}
    assert rows[1].startswith("0.001000000,")


def test_strategies_are_compared_on_a_program_without_motion(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "still.nc").write_text("G4 P0.5\nM2\n")
    assert run(["compare", str(tmp_path / "still.nc")]) == 0
    rows = [line.split("|") for line in capsys.readouterr().out.splitlines() if line.startswith("| optimal")]
    assert [cell.strip() for cell in rows[0][2:5]] == ["0.5000", "0", "0"]


@pytest.mark.parametrize("words", ["G1 X10 Y5 Z0 F3000\nX20 Y10", "G1 Z0 F3000"])
def test_an_axis_that_the_machine_lacks_and_that_stands_still_is_left_out_of_a_comparison(
    words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """``convert --fit`` writes Z0 into programs for a table of two axes."""
    program = tmp_path / "z.nc"
    program.write_text(f"G21 G90\n{words}\nM2\n")
    assert run(["compare", str(program), "-m", "xy-table"]) == 0
    assert run(["compare", str(program), "-m", "xy-table", "--controllers", "p"]) == 0
    assert "| p " in capsys.readouterr().out


def test_a_tree_of_standard_input(cncgen: Run, programs: Path) -> None:
    file = programs / "stepnc" / "features.stp"
    of_file, of_stream = (
        cncgen("check", "--tree", file),
        cncgen("check", "--tree", "-", stdin=file.read_bytes()),
    )
    assert (of_stream.returncode, of_stream.stdout) == (0, of_file.stdout)
    assert of_stream.stdout.startswith(b"workplan 'plan' (#168)")


def test_the_language_of_standard_input_can_be_said(cncgen: Run) -> None:
    assert cncgen("check", "--tree", "-", stdin=PROGRAM).returncode == 0
    wrong = cncgen("check", "--tree", "--language", "stepnc", "-", stdin=PROGRAM)
    assert wrong.returncode == 1
    assert b"error[part21-" in wrong.stderr


def test_a_report_on_standard_input_has_a_verdict(cncgen: Run, part: Path) -> None:
    of_stream = cncgen("report", "-", "--feedrate", "ild", stdin=PROGRAM)
    of_file = cncgen("report", part, "--feedrate", "ild")
    assert (of_stream.returncode, of_file.returncode) == (0, 0)
    assert b'"verdict":{"holds":' in of_stream.stdout
    assert b'"verdict":{"holds":' in of_file.stdout


@pytest.mark.parametrize("kind", ["csv", "jsonl", "npz"])
@pytest.mark.parametrize("name", ["points", "points.txt", "points.nc"])
def test_setpoints_are_known_by_how_they_begin(tmp_path: Path, part: Path, kind: str, name: str) -> None:
    """The name says nothing, or says that it is a program."""
    points = str(tmp_path / name)
    assert run(["plan", str(part), "-m", "xy-table", "-q", "--format", kind, "-o", points]) == 0
    response = tmp_path / "response.csv"
    call = ["simulate", points, "--axis-params", "xy-table", "--axes", "xy", "-q", "-o", str(response)]
    assert run(call) == 0
    assert response.read_text().startswith("t_s,x_cmd_mm,x_mm,x_force,x_saturated,y_cmd_mm")


@pytest.mark.parametrize("kind", ["csv", "jsonl", "npz", None])
def test_what_comes_through_a_pipe_is_known_by_how_it_begins(
    tmp_path: Path, part: Path, kind: str | None
) -> None:
    """Setpoints, and a program where the kind is None, in two pieces of which the first one says little."""
    points, pipe, response = tmp_path / "points", tmp_path / "pipe", tmp_path / "response.csv"
    assert run(["plan", str(part), "-m", "xy-table", "-q", "--format", kind or "csv", "-o", str(points)]) == 0
    content = (points if kind else part).read_bytes()
    os.mkfifo(pipe)

    def write() -> None:
        with open(pipe, "wb", buffering=0) as file:
            file.write(content[:1])
            file.write(content[1:])

    writer = threading.Thread(target=write, daemon=True)
    writer.start()
    call = ["simulate", str(pipe), "-m", "xy-table", "--axes", "xy", "-q", "-o", str(response)]
    assert run(call) == 0
    writer.join(10)
    of_file = tmp_path / "of_file.csv"
    assert run([*call[:1], str(points if kind else part), *call[2:-1], str(of_file)]) == 0
    assert response.read_bytes() == of_file.read_bytes()


def test_setpoints_that_do_not_name_their_axes_are_drawn(tmp_path: Path, part: Path) -> None:
    setpoints, picture = str(tmp_path / "s.npy"), tmp_path / "p.svg"
    assert run(["plan", str(part), "--feedrate", "ild", "-q", "-o", setpoints]) == 0
    assert run(["plot", setpoints, "--kinds", "path", "-o", str(picture)]) == 2
    assert run(["plot", setpoints, "--axes", "XY", "--kinds", "path", "-o", str(picture)]) == 0
    assert b"<svg" in picture.read_bytes()


def test_a_machine_says_how_programs_are_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """G43.4 takes the kinematics of a machine, for check, canon and convert too; what reads alone does without a machine."""
    five, machine = tmp_path / "five.nc", tmp_path / "five.toml"
    five.write_text("%\nO1\nG21 G90\nG43.4 H1 X0 Y0 Z50\nG1 X10 B30 F1000\nG49\nM30\n%\n")
    assert run(["machines", "show", "generic-mill"]) == 0
    tables = '[kinematics]\nmodel = "head-head"\naxes = ["c", "b"]\npivot_mm = 180.0\n'
    machine.write_text(capsys.readouterr().out + "\n" + tables)
    for command, code, told in (("check", 0, "warning"), ("canon", 0, "warning"), ("convert", 1, "error")):
        assert run([command, str(five)]) == code
        assert f"{told}[tcp-machine]" in capsys.readouterr().err
        assert run([command, str(five), "-m", "generic-mill"]) == 1
        assert "error[tcp-machine]" in capsys.readouterr().err
        assert run([command, str(five), "-m", str(machine)]) == 0
        capsys.readouterr()
    assert run(["check", str(five), "-m", "none.toml"]) == 2


def test_choices_are_those_of_the_rooms() -> None:
    """They stand in `cncgen.cli.options` a second time, so that help needs no numpy."""
    from cncgen import pipeline
    from cncgen.gcode.codes import reference
    from cncgen.machine.settings_schema import DIALECTS
    from cncgen.planner import options as planning
    from cncgen.planner.strategies import FEEDRATES

    assert tuple(pipeline.SUFFIXES) == options.LANGUAGES
    assert FEEDRATES == options.FEEDRATES
    assert ("auto", *DIALECTS) == options.DIALECTS
    assert set(reference.DIALECTS) == set(DIALECTS) - {"fanuc-lathe-b", "fanuc-lathe-c"}
    for name in ("INTERPOLATORS", "SATURATIONS", "PROFILES", "EFFORTS", "CONTROLS", "LEAST_CONTOUR_ERROR_MM"):
        assert getattr(options, name) == getattr(planning, name)


def test_canon_says_which_dialect_it_took(cncgen: Run, tmp_path: Path) -> None:
    (tmp_path / "lathe.nc").write_text("N01G50S600\nN02G0X50.Z2.\nN03M30\n")
    run = cncgen("canon", "lathe.nc")
    assert run.returncode == 0
    assert b"note[dialect]: read as fanuc-lathe" in run.stderr


def test_the_name_of_a_machine_shows_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["machines", "show", "xy-table"]) == 0
    shown = capsys.readouterr().out
    assert run(["machines", "xy-table"]) == 0
    assert capsys.readouterr().out == shown
    assert run(["machines", "xy-tabel"]) == 2
    assert "did you mean xy-table?" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["simulate", "compare"])
def test_a_program_is_planned_on_the_machine_of_its_servo_data(
    tmp_path: Path, part: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    """As with -m; the machine that is taken is named."""
    found = {}
    for given in (["-m", "xy-table"], ["--axis-params", "xy-table"]):
        output = tmp_path / given[0].strip("-")
        assert run([command, str(part), *given, "-o", str(output)]) == 0
        found[given[0]] = output.read_text()
        assert ("planned on xy-table, the machine of --axis-params" in capsys.readouterr().err) == (
            given[0] == "--axis-params"
        )
    assert found["-m"] == found["--axis-params"]


def test_servo_data_without_limits_are_no_machine_to_plan_on(
    tmp_path: Path, part: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["machines", "xy-table"]) == 0
    axes = tomllib.loads(capsys.readouterr().out)["axes"]
    lines = [
        f"[axes.{letter}.servo]\n" + "".join(f"{key} = {value!r}\n" for key, value in axis["servo"].items())
        for letter, axis in axes.items()
    ]
    servos = tmp_path / "servos.toml"
    servos.write_text("".join(lines).replace("True", "true").replace("False", "false"))
    assert run(["simulate", str(part), "--axis-params", str(servos), "-o", str(tmp_path / "r.csv")]) == 0
    assert "has no limits: planned on generic-mill" in capsys.readouterr().err


def test_check_ends_with_a_line_a_file_and_a_total(
    tmp_path: Path, part: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = tmp_path / "wrong.nc"
    wrong.write_text("G21 G90\nG1 X F100\nG1 Y\nM2\n")
    assert run(["check", str(part), str(wrong)]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert lines[-2] == f"{wrong}: 2 errors"
    assert lines[-1] == "2 files: 1 without errors, 1 with errors"
    assert run(["check", str(part)]) == 0
    assert "files" not in capsys.readouterr().err


def test_an_estimate_has_times_and_no_setpoints(
    part: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["plan", str(part), "--as", "grbl", "-o", str(tmp_path / "x.csv")]) == 2
    assert "it has no setpoints to write" in capsys.readouterr().err
    assert run(["plan", str(part), "--as", "grbl", "--signals", "vel"]) == 2
    assert "it has no setpoints to write" in capsys.readouterr().err
    assert run(["plan", str(part), "--as", "grbl", "--summary", str(tmp_path / "s.json")]) == 0
    said = capsys.readouterr()
    assert said.out == ""
    assert "note[plan-estimate]: an estimate of grbl" in said.err
    found = json.loads((tmp_path / "s.json").read_text())
    assert (found["feedrate"], found["peak"]) == ("grbl", {})
    assert found["cycle_time_s"] > 0


def test_a_comparison_tells_of_an_unstable_loop_once(
    tmp_path: Path, part: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """A sampled P loop of an integrator has its pole at 1 − Kv T: below −1, so unstable, for Kv above 2/T = 2000 1/s."""
    axis = (
        "max_velocity_mm_s = 250.0\nmax_acceleration_mm_s2 = 2500.0\nmax_jerk_mm_s3 = 50000.0\n"
        '[axes.{0}.servo]\nmodel = "first-order"\nposition_gain_1_s = 2100.0\n'
    )
    head = 'name = "eager"\nperiod_s = 0.001\nchord_tolerance_mm = 0.001\npath_tolerance_mm = 0.01\n'
    text = head + "".join(f"[axes.{letter}]\n" + axis.format(letter) for letter in "xy")
    (tmp_path / "eager.toml").write_text(text)
    words = ["compare", str(part), "-m", str(tmp_path / "eager.toml"), "--feedrates", "optimal,constant"]
    for _ in "ab":  # a second run in one process tells it again
        run(words)
        said = capfd.readouterr().err
        for letter in "XY":
            assert said.count(f"warning[servo-unstable]: the closed loop of axis {letter}") == 1


def test_compare_shows_the_interpolator_that_is_asked_for(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "part.nc").write_text("G21 G1 X5 F1000\nM2\n")
    assert (
        run(["compare", str(tmp_path / "part.nc"), "--feedrates", "ild", "--interpolator", "stateline"]) == 0
    )
    assert "| stateline " in capfd.readouterr().out


def test_compare_says_that_interpolators_have_a_plan_of_their_own(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Path and speed together round a corner within G64; interpolators follow a path that is given, in more time."""
    (tmp_path / "part.nc").write_text("G21 G64 P0.05 G1 X5 F3000\nY5\nM2\n")
    for feedrates, said in (("optimal", True), ("ild", False)):
        assert run(["compare", str(tmp_path / "part.nc"), "-m", "xy-table", "--feedrates", feedrates]) == 0
        assert ("interpolators are compared on a plan of the speed" in capfd.readouterr().err) == said


@pytest.mark.parametrize(
    ("command", "option", "told"),
    [
        ("why", ("--kbar", "2"), True),
        ("compare", ("--kbar", "2"), False),
        ("compare", ("--kbar", "2", "--feedrates", "optimal"), True),
        ("compare", ("--stateline-bound", "0.1"), True),
        ("compare", ("--controllers", "p", "--profile", "linear"), True),
    ],
)
def test_options_that_no_plan_of_a_run_asks_for_are_told(
    cncgen: Run, part: Path, command: str, option: tuple[str, ...], told: bool
) -> None:
    """`why` makes one kind of plan; `compare` makes several, and an option that one of them asks for is used."""
    run = cncgen(command, part, "-m", "xy-table", *option, "--json", "-o", "o.txt")
    assert run.returncode == 0
    assert told == ("option-unused" in [json.loads(line)["code"] for line in run.stderr.splitlines()])


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (("simulate", "--feedrate", "ild"), "no use for --feedrate: o.csv holds setpoints"),
        (("simulate", "--dialect", "fanuc"), "no use for --dialect: o.csv holds setpoints"),
        (("compensate", "--max-steps", "9"), "no use for --max-steps: o.csv holds setpoints"),
        (
            ("compensate", "--shaper", "zv", "--modes", "30:0.05", "--effort", "fast"),
            "no use for --effort: o.csv",
        ),
        (("plot", "--kinds", "path", "--units", "inch"), "no use for --units: o.csv holds setpoints"),
        (
            ("simulate", "--draws", "9", "--draw-seed", "1"),
            "no use for --draws, --draw-seed: without --perturb",
        ),
    ],
)
def test_options_of_planning_are_told_where_setpoints_are_planned_already(
    cncgen: Run, part: Path, command: tuple[str, ...], said: str
) -> None:
    cncgen("plan", part, "-m", "xy-table", "-q", "-o", "o.csv")
    name, *options = command
    out = "p.svg" if name == "plot" else "r.csv"
    run = cncgen(name, "o.csv", "--axis-params", "xy-table", *options, "-o", out, "--json")
    assert run.returncode == 0
    (found,) = (
        one for line in run.stderr.splitlines() if (one := json.loads(line))["code"] == "option-unused"
    )
    assert (found["severity"], found["message"][: len(said)]) == ("warning", said)
