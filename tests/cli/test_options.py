"""Options do what their help says: what each one changes, against closed forms where there are any."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen import pipeline
from cncgen.cli.app import run
from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine import load_servos
from cncgen.planner import PlanOptions
from cncgen.toolpath.reading import ReadOptions

#: A line of 10 mm at 50 mm/s.
LINE = "G21 G90 G61\nG1 X10 F3000\nM2\n"
#: With a corner that G64 may round.
CORNER = "G21 G90 G64 P0.05\nG1 X10 F3000\nY10\nM2\n"

#: Servo data: P loops of 50 1/s, which lag by v/Kv, 1 mm at 50 mm/s.
SLOW_LOOPS = """
[axes.x.servo]
model = "first-order"
position_gain_1_s = 50.0
[axes.y.servo]
model = "first-order"
position_gain_1_s = 50.0
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, with two programs."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.nc").write_text(LINE)
    (tmp_path / "corner.nc").write_text(CORNER)
    return tmp_path


def call(line: str) -> int:
    """Run a command line and return its exit code."""
    return run(line.split())


def table(path: str | Path) -> np.ndarray:
    """Return the numbers of a CSV file, without its header."""
    return np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)


def without_times(source: Path, target: Path) -> None:
    """Write the positions of a setpoint file alone, as halstreamer takes them."""
    np.savetxt(target, table(source)[:, 1:], fmt="%.9f")


# Planning and reading


def test_what_stands_on_the_command_line_is_what_the_planner_is_given(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every option of planning, each at another value than its default."""
    given = {}

    def seen(program: Any, machine: Any, options: PlanOptions, signals: Any, **_: Any) -> None:
        given.update(machine=machine, options=options, signals=signals)
        raise UsageError(Diagnostic("seen", "enough"))

    monkeypatch.setattr(pipeline, "plan_with_summary", seen)
    line = (
        "plan line.nc -m xy-table --feedrate ild --interpolator taylor1 --saturation predictive --profile linear"
        " --effort fast --path-tolerance 0.02 --max-contour-error 0.03 --axis-params dyna-1007 --signals vel,line"
    )
    assert call(line) == 2
    assert (given["machine"], given["signals"]) == ("xy-table", ("vel", "line"))
    assert given["options"] == PlanOptions(
        feedrate="ild",
        interpolator="taylor1",
        saturation="predictive",
        profile="linear",
        effort="fast",
        path_tolerance_mm=0.02,
        max_contour_error_mm=0.03,
        servos=load_servos("dyna-1007"),
    )


def test_what_stands_on_the_command_line_is_what_the_reader_is_given(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every option of reading, each at another value than its default."""
    given = {}

    def seen(name: str, *, language: str | None, options: ReadOptions) -> None:
        given.update(name=name, language=language, options=options)
        raise UsageError(Diagnostic("seen", "enough"))

    monkeypatch.setattr(pipeline, "read", seen)
    line = (
        "plan line.nc --language gcode --dialect fanuc --tool-table t --parameters p --table-units inch"
        " --save-parameters s --include . --include .. --no-block-delete --speed-unit m/min --spindle-sign tool"
        " --max-steps 7 --path-tolerance 0.02"
    )
    assert call(line) == 2
    assert (given["name"], given["language"]) == ("line.nc", "gcode")
    assert given["options"] == ReadOptions(
        dialect="fanuc",
        tool_table=Path("t"),
        parameters=Path("p"),
        inch_tables=True,
        save_parameters=Path("s"),
        include=(Path(), Path("..")),
        block_delete=False,
        speed_unit="m/min",
        spindle_sign="tool",
        max_steps=7,
        tolerance_mm=0.02,
        # The machine's, which has no option.
        fastest_spindle=12_000.0,
    )


@pytest.mark.parametrize(
    ("profile", "seconds"),
    [("linear", 10 / 50 + 50 / 3000), ("bell", 10 / 50 + 2 * math.sqrt(50 / 50_000))],
)
def test_profiles_of_ild_take_the_time_of_their_ramps(folder: Path, profile: str, seconds: float) -> None:
    """L/F and half of either ramp: F/A linearly, 2 √(F/J) where the jerk alone limits (F < A²/J = 180 mm/s)."""
    line = f"plan line.nc --feedrate ild --profile {profile} -q -o s.csv --summary s.json"
    assert call(line) == 0
    summary = json.loads((folder / "s.json").read_text())
    assert summary["motion_time_s"] == pytest.approx(seconds, abs=0.002)


def test_subprograms_are_searched_where_include_says(folder: Path) -> None:
    (folder / "subs").mkdir()
    (folder / "subs" / "side.ngc").write_text("o<side> sub\nG1 X7 F3000\no<side> endsub\nM2\n")
    (folder / "calls.nc").write_text("G21 G90\no<side> call\nM2\n")
    assert run(["check", "-q", "calls.nc"]) == 1
    assert call("convert calls.nc --include subs -q -o made.nc") == 0
    assert "X7" in (folder / "made.nc").read_text()


@pytest.mark.parametrize(("steps", "code"), [("5", 1), ("500", 0)])
def test_programs_end_after_so_many_steps(
    folder: Path, capsys: pytest.CaptureFixture[str], steps: str, code: int
) -> None:
    (folder / "loop.nc").write_text("o1 repeat [40]\nG91 G0 X1\no1 endrepeat\nM2\n")
    assert run(["check", "loop.nc", "--max-steps", steps]) == code
    assert ("error[" in capsys.readouterr().err) == bool(code)


def test_blocks_that_begin_with_a_slash(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Skipped, but where --no-block-delete says otherwise; canon runs them as rs274 does."""
    (folder / "slash.nc").write_text("G21 G90 F100\nG1 X1\n/G1 X2\nG1 X3\nM2\n")
    for line, there in (
        ("convert slash.nc", False),
        ("convert slash.nc --no-block-delete", True),
        ("canon slash.nc", True),
        ("canon slash.nc --block-delete", False),
    ):
        assert call(line) == 0
        out = capsys.readouterr().out
        assert ("G1 X2" in out or "STRAIGHT_FEED(2.0000" in out) == there, line


@pytest.mark.parametrize(
    ("line", "length"),
    [
        ("canon t.nc --tool-table t.tbl", 25.4),
        ("canon t.nc --tool-table t.tbl --table-units mm", 1.0),
        ("convert t.nc --tool-table t.tbl", 1.0),
        ("convert t.nc --tool-table t.tbl --table-units inch", 25.4),
    ],
)
def test_lengths_of_tool_tables(
    folder: Path, capsys: pytest.CaptureFixture[str], line: str, length: float
) -> None:
    """A tool of length 1 is an inch long for canon, as for rs274, and a millimetre for the others."""
    (folder / "t.tbl").write_text("T1 P1 Z1 D1\n")
    (folder / "t.nc").write_text("G21 G90\nT1 M6\nG43 H1\nG0 Z0\nM2\n")
    assert call(line) == 0
    out = capsys.readouterr().out
    expected = f"USE_TOOL_LENGTH_OFFSET(0.0000 0.0000 {length:.4f}" if "canon" in line else f"Z{length:g}"
    assert expected in out


# Setpoints


def test_a_simulation_goes_on_while_the_axes_settle(folder: Path) -> None:
    """By 50 ms: 50 more rows, in which the command stands and a P loop comes closer."""
    assert call("plan line.nc -m dyna-1007 -q -o s.csv") == 0
    assert call("simulate s.csv --axis-params dyna-1007 -q -o short.csv") == 0
    assert call("simulate s.csv --axis-params dyna-1007 --settle 0.05 -q -o long.csv") == 0
    short, long = table("short.csv"), table("long.csv")
    assert len(long) == len(short) + 50
    np.testing.assert_array_equal(long[: len(short)], short)
    np.testing.assert_array_equal(long[len(short) :, 1], 10.0)
    assert abs(long[-1, 2] - 10.0) < abs(short[-1, 2] - 10.0)


def test_a_simulation_takes_the_servo_data_of_axis_params(folder: Path) -> None:
    """And not the machine's: a P loop of 50 1/s lags by v/Kv, 1 mm at 50 mm/s."""
    (folder / "servo.toml").write_text(SLOW_LOOPS)
    assert call("simulate line.nc -m xy-table --axis-params servo.toml -q -o r.csv") == 0
    rows = table("r.csv")
    middle = np.argmin(np.abs(rows[:, 1] - 7.0))
    assert rows[middle, 1] - rows[middle, 2] == pytest.approx(1.0, abs=0.02)


def test_verify_judges_by_the_tolerance_resolution_and_period_that_are_given(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The corner is cut by up to 50 µm; rounded to 1 µm, second differences of 1 ms are off by some mm/s²; 1 ms as 2 ms."""
    assert call("plan corner.nc -m xy-table -q -o s.csv") == 0
    judge = "verify s.csv -p corner.nc -m xy-table"
    assert call(judge) == 0
    assert call(f"{judge} --path-tolerance 0.001") == 1
    assert "verify-distance" in capsys.readouterr().err
    rows = [line.split(",") for line in (folder / "s.csv").read_text().splitlines()]
    rounded = [",".join([t, *(f"{float(v):.3f}" for v in values)]) for t, *values in rows[1:]]
    (folder / "r.csv").write_text("\n".join([",".join(rows[0]), *rounded]) + "\n")
    judge = "verify r.csv -p corner.nc -m xy-table"
    assert call(judge) == 1
    assert call(f"{judge} --resolution 0.001") == 0
    without_times(folder / "s.csv", folder / "s.hal")
    capsys.readouterr()
    assert call("verify s.hal -p corner.nc -m xy-table --period 0.002") == 0
    assert "setpoints every 2 ms" in capsys.readouterr().err


def test_a_single_setpoint_has_the_machines_period(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One row of times tells none."""
    assert run(["machines", "show", "xy-table"]) == 0
    text = capsys.readouterr().out.replace("period_s = 0.001\n", "period_s = 0.004\n")
    (folder / "slow.toml").write_text(text)
    (folder / "still.nc").write_text("G21\nG0 X0\nM2\n")
    (folder / "one.csv").write_text("t_s,x_mm\n0,0\n")
    assert call("verify one.csv -p still.nc -m slow.toml") == 0
    assert "1 setpoint every 4 ms" in capsys.readouterr().err
    assert call("simulate one.csv -m slow.toml --settle 0.02 -q -o r.csv") == 0
    np.testing.assert_allclose(table("r.csv")[:, 0], 0.004 * np.arange(6), atol=1e-12)


def test_a_command_is_held_until_it_has_settled(folder: Path) -> None:
    """Of setpoints, and of a program: longer where --settle says so."""
    assert call("plan line.nc -m dyna-1007 -q -o s.csv") == 0
    for source in ("s.csv", "line.nc"):
        ends = {}
        for settle in (0.1, 2.5):
            line = f"compensate {source} -m dyna-1007 --settle {settle} --perturb 0% -q -o c.csv --summary g.json"
            assert call(line) == 0
            gained = json.loads((folder / "g.json").read_text())
            ends[settle] = gained["settle_s"]
            assert len(table("c.csv")) == gained["samples"]
            assert len(table("s.csv")) == round(
                gained["samples"] - 1000 * (gained["lead_s"] + gained["settle_s"])
            )
        assert ends[0.1] >= 0.1
        assert ends[2.5] == pytest.approx(2.5)


@pytest.mark.parametrize("source", ["s.csv", "line.nc"])
def test_a_compensation_takes_a_lag_away(folder: Path, source: str) -> None:
    """With the servo data of --axis-params: the lag is 1 mm before; on a straight line the tracking error is what counts."""
    (folder / "servo.toml").write_text(SLOW_LOOPS)
    assert call("plan line.nc -m xy-table -q -o s.csv") == 0
    line = f"compensate {source} -m xy-table --axis-params servo.toml --draws 4 -q -o c.csv --summary g.json"
    assert call(line) == 0
    gained = json.loads((folder / "g.json").read_text())
    assert gained["before"]["tracking_max_mm"] == pytest.approx(1.0, abs=0.05)
    assert gained["after"]["tracking_max_mm"] < 0.1
    assert gained["perturbed"]["draws"] == 4


@pytest.mark.parametrize(("axis", "column", "limit"), [("X", "x_mm", 50_000.0), ("A", "a_deg", 20_000.0)])
def test_a_sweep_has_the_swing_centre_and_share_that_are_given(
    folder: Path, axis: str, column: str, limit: float
) -> None:
    """In the units of files; where jerk binds, a quarter of the share is a quarter of the jerk."""
    line = f"excite -m generic-mill --axis {axis} --duration 4 --low 1 --high 20 --center 5 -q"
    swing, jerk = {}, {}
    for name, more in (("usual", ""), ("small", "--amplitude 0.5"), ("less", "--share 0.2")):
        assert call(f"{line} {more} -o {name}.csv") == 0
        assert (folder / f"{name}.csv").read_text().startswith(f"t_s,{column}\n")
        x = table(f"{name}.csv")[:, 1]
        assert x[0] == x[-1] == 5.0
        swing[name], jerk[name] = np.abs(x - 5.0).max(), np.abs(np.diff(x, 3)).max() / 0.001**3
    assert 0.25 < swing["small"] <= 0.5 < swing["usual"]
    assert jerk["usual"] == pytest.approx(0.8 * limit, rel=1e-3)
    assert jerk["less"] == pytest.approx(0.2 * limit, rel=1e-3)


def test_a_search_is_the_same_for_the_same_seed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """And another for another; loops nearer to −1 than --modulus allows are not taken."""
    line = "tune line.nc -m dyna-1007 --sets 3 --jobs 1 --no-bode -q -o"
    for name, more in (("a", "--seed 1"), ("b", "--seed 1"), ("c", "--seed 2")):
        assert call(f"{line} {name}.toml {more}") == 0
    a, b, c = (tomllib.loads((folder / f"{name}.toml").read_text()) for name in "abc")
    assert a == b
    assert a != c
    assert call(f"{line} d.toml --seed 1 --modulus 0.9") == 2
    assert "none of 3 gain sets keeps the modulus margin 0.9" in capsys.readouterr().err


# Programs


def test_arcs_become_lines_in_stepnc_too(folder: Path) -> None:
    """A half circle of 10 mm within 10 µm: steps of 2 acos(1 - 0.01/10), 90 mrad, 36 of them at the least."""
    (folder / "arc.nc").write_text("G21 G90\nG3 X-20 I-10 F1000\nM2\n")
    assert call("convert arc.nc -q -o arc.stp") == 0
    assert "CIRCLE" in (folder / "arc.stp").read_text()
    assert call("convert arc.nc --linearize 0.01 -q -o lines.stp") == 0
    text = (folder / "lines.stp").read_text()
    assert "CIRCLE" not in text
    assert math.ceil(math.pi / (2 * math.acos(1 - 0.01 / 10))) <= text.count("CARTESIAN_POINT") <= 80


@pytest.mark.parametrize(("to", "begins"), [("gcode", "("), ("stepnc", "ISO-10303-21;")])
def test_the_language_that_is_written_is_the_one_asked_for(folder: Path, to: str, begins: str) -> None:
    """Whatever the suffix says."""
    for name in ("a.stp", "a.nc"):
        assert run(["convert", "line.nc", "--to", to, "-q", "-o", name]) == 0
        assert (folder / name).read_text().startswith(begins)


@pytest.mark.parametrize("order", ["bad.nc none.nc", "none.nc bad.nc", "bad.nc line.nc none.nc line.nc"])
def test_check_ends_with_the_gravest_code_of_all_programs(folder: Path, order: str) -> None:
    """1 for a program with errors, 2 for one that cannot be read, in whatever order."""
    (folder / "bad.nc").write_text("G1 X=\n")
    assert run(["check", "-q", *order.split()]) == 2


def test_a_report_plans_and_verifies_the_program_that_was_meant(folder: Path) -> None:
    """The verdict reads the program again, with the same options: here a block that is usually skipped."""
    (folder / "slash.nc").write_text("G21 G90 G61\nG1 X5 F3000\n/G1 Y5\nG1 X9\nM2\n")
    line = "report slash.nc -m xy-table --no-block-delete -q -o page.html"
    assert call(line) == 0
    assert '"verdict":{"holds":true' in (folder / "page.html").read_text()
    assert call(f"{line} --feedrate ild") == 0
    assert '"feedrate":"ild"' in (folder / "page.html").read_text()


@pytest.mark.parametrize(
    "files",
    [
        ["programs/bracket.nc"],
        ["programs/bad", "none.nc"],
        [""],
        ["tests/cli/test_options.py", "programs/bracket.nc"],
        *([str(path)] for path in sorted((Path(__file__).parents[2] / "programs" / "bad").glob("*"))[::12]),
    ],
)
def test_a_check_without_options_is_one_with_their_defaults(
    files: list[str], root: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without options there is nothing to parse, and click is not imported: the defaults must be the same."""
    monkeypatch.chdir(root)
    code, said = run(["check", *files]), capsys.readouterr()
    assert said.err
    assert run(["check", "--units", "auto", *files]) == code
    assert capsys.readouterr() == said
