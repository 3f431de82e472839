"""Hostile inputs that were once over a bound or ended in an internal error, each given to its command: exit code and diagnostic."""

from __future__ import annotations

import os
import re
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from cncgen import ranges
from cncgen.cli import app, memory
from cncgen.gcode import budget
from cncgen.machine.reading import TOP_NUMBERS
from cncgen.pipeline import planning, reading
from cncgen.planner.record import MOST_ROWS
from cncgen.planner.tube import stream
from cncgen.removal import sweeps
from cncgen.servo import compensation
from cncgen.toolpath.reading import ReadOptions

ROOT = Path(__file__).resolve().parents[1]

WEIGHTED = "G21 G90 G17 G64\nG6.2 P3 K0 X0 Y0 R{0} F1000\nK0 X1 Y1 R{1}\nK0 X2 Y0 R{0}\nK1\nK1\nK1\nM2\n"
LINES = "G21 G90 G64 P0.01\nG1 X1 Y0 F1000\nX2 Y1\nM2\n"
FIVE_AXES = (
    'name = "five"\nperiod_s = 0.001\nchord_tolerance_mm = 0.001\n'
    + "".join(
        f"[axes.{letter}]\nmax_velocity_{unit}_s = 100.0\nmax_acceleration_{unit}_s2 = 1000.0\nmax_jerk_{unit}_s3 = 1e4\n"
        for letter, unit in (("x", "mm"), ("y", "mm"), ("z", "mm"), ("a", "deg"), ("c", "deg"))
    )
    + '[kinematics]\nmodel = "table-table"\naxes = ["a", "c"]\n'
)
CSV = "t_s,x_mm,y_mm\n0,0,0\n0.001,1e300,0\n0.002,0,0\n"
VERIFY = ("-p", "p.nc", "-m", "xy-table")
PLAN = ("-m", "xy-table", "-o", "o.csv")
NINES = "9" * 400

#: Files, the command, its exit code, and what it says.
CASES: dict[str, tuple[dict[str, str | bytes], tuple[str, ...], int, str]] = {
    **{
        f"weights of {w} and {end}": (
            {"w.nc": WEIGHTED.format(end, w)}, ("plan", "w.nc", *PLAN), 1, "number-range"
        )
        for w, end in (("200000000", "1"), ("300000000", "1"), ("999999999", "1"), ("100000000", "1"), ("1", "0.000000001"))
    },
    "coordinates of 1e9": ({"b.nc": "G21\nG1 X1000000000 F1000\nX0\nM2\n"}, ("plan", "b.nc", *PLAN), 1, "number-range"),
    "a tool point about a turn of 1e7 degrees": (
        {"t.nc": "G43.4 H1\nG1 X1 C10000000 F100\nM30\n", "five.toml": FIVE_AXES},
        ("check", "t.nc", "--dialect", "fanuc", "-m", "five.toml"), 1, "too-many-steps",
    ),
    "an arc of 1e7 turns": (
        {"a.nc": "G21\nG2 X0 Y0 I1 J0 P10000000 F100\nM2\n"}, ("plan", "a.nc", "-m", "generic-mill", "-o", "o.csv"), 3, "motion-endless"
    ),
    **{
        f"{what} beyond 1e8 mm of {dialect}, in check": (
            {"s.nc": text}, ("check", "s.nc", "--dialect", dialect), 1, "is sent to 180000000 mm"
        )
        for what, dialect, text in (
            ("a sum", "sinumerik", "G71 G90 G17\nR1=90000000\nG1 X=R1 F1000\nG1 X=R1+R1\nM30\n"),
            ("an origin", "sinumerik", "G71 G90 G17\nTRANS X90000000\nG1 X90000000 F1000\nM30\n"),
            ("an increment", "linuxcnc", "G21 G90 G17\nG1 X90000000 F1000\nG91 X90000000\nM2\n"),
            ("an increment", "fanuc", "G21 G90 G17\nG1 X90000000 F1000\nG91 X90000000\nM30\n"),
        )
    },
    "a loop of which why would make hundreds of plans": (
        {"o.nc": "G21 G64 F3000\no1 repeat [4000]\nG1 X1\nX0\no1 endrepeat\nM2\n"},
        ("why", "o.nc", "-m", "xy-table", "--effort", "fast"), 1, "more than 1300 motions",
    ),
    **{
        f"a loop of which {command} would make several plans": (
            {"o.nc": "G21 G64 F3000\no1 repeat [4000]\nG1 X1\nX0\no1 endrepeat\nM2\n"},
            (command, "o.nc", "-m", "xy-table", "--feedrate", "ild", *more), 1, "more than 1300 motions",
        )
        for command, *more in (("compare",), ("compensate", "-o", "o.csv"))
    },
    "a loop of which the axes are predicted": (
        {"o.nc": "G21 G64 F3000\no1 repeat [4000]\nG1 X1\nX0\no1 endrepeat\nM2\n"},
        ("plan", "o.nc", "-m", "generic-mill", "--feedrate", "ild", "-o", "o.csv"), 1, "more than 5600 motions",
    ),
    "a loop of corners of seven hours": (
        {"o.nc": "G21 G64 P0.01 F1000\no1 repeat [40000]\nG1 X3 Y0.4\nX0.4 Y2\no1 endrepeat\nM2\n"},
        ("plan", "o.nc", "--effort", "fast", *PLAN), 1, "error[long-plan]",
    ),
    "a feed of which setpoints would fill a disk": (
        {"o.nc": "G21 F1\nG1 X400\nM2\n"}, ("plan", "o.nc", *PLAN), 1, "24000001 setpoints come of 3 lines",
    ),
    "a short program that takes ten minutes, compensated": (
        {"o.nc": "G21 F1\nG1 X10\nM2\n"}, ("compensate", "o.nc", *PLAN), 3, "compensate-long"
    ),
    "a stock as thin as rounding": (
        {"a.nc": "G21 S1000 M3\nG2 X20 Y0 I10 J0 F100\nM2\n"},
        ("cut", "a.nc", "--stock", "cylinder:0,0,1e-12,-5,0", "--tool", "*=ball:4"), 2, "cut-grid",
    ),
    "a loop of 1e9": ({"o.nc": "G21\no1 repeat [1000000000]\no1 endrepeat\nM2\n"}, ("check", "o.nc"), 1, "too-many-steps"),
    "a turn in a plane of U V W": (
        {"g.nc": "G17.1\nG68X0R5\nM30\n"}, ("check", "g.nc", "--dialect", "fanuc"), 1, "rotation-plane"
    ),
    "a parameter of Heidenhain": (
        {"q.h": "BEGIN PGM A MM\nL XQ2147483648\nEND PGM A MM\n"}, ("check", "q.h", "--dialect", "heidenhain"), 1, "parameter-number"
    ),
    "a turn of Heidenhain": (
        {"q.h": f"BEGIN PGM A MM\nCYCL DEF 10.1 ROT+{NINES}\nEND PGM A MM\n"}, ("check", "q.h", "--dialect", "heidenhain"), 1, "number-range"
    ),
    "a row of operators of SINUMERIK as long as its line": (
        {"s.nc": f"R1={'1+' * 4700}1\nR2=SQRT(-R1)\nM30\n"}, ("check", "s.nc", "--dialect", "sinumerik"), 1, "-4701"
    ),
    "functions in functions of SINUMERIK": (
        {"s.nc": f"R1={'SIN(' * 1900}R2{')' * 1900}\nR2=SQRT(R1-1)\nM30\n"}, ("check", "s.nc", "--dialect", "sinumerik"), 1, "SQRT(-1)"
    ),
    "indices in indices of SINUMERIK": (
        {"s.nc": f"R1={'R[' * 4000}R2{']' * 4000}\nDEF REAL AA[2]\nR2=SQRT(R1-1+{'AA[' * 1900}R2{']' * 1900})\nM30\n"},
        ("check", "s.nc", "--dialect", "sinumerik"), 1, "SQRT(-1)"
    ),
    "a word of five thousand digits of SINUMERIK": (
        {"s.nc": f"G90{'9' * 5000}!\nM30\n"}, ("check", "s.nc", "--dialect", "sinumerik"), 1, "syntax"
    ),
    "a repetition of SINUMERIK": ({"s.nc": f"UP P={NINES}\nM30\n"}, ("check", "s.nc", "--dialect", "sinumerik"), 1, "number-range"),
    "a place in convert": (
        {"z.nc": "G71\nG0X0Z45678901234567890\nM2\n"}, ("convert", "z.nc", "-o", "o.nc"), 1, "number-range"
    ),
    "a coordinate of STEP-NC": (
        {"p.stp": f"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT($,({NINES},0.,0.));\nENDSEC;\nEND-ISO-10303-21;\n"},
        ("check", "p.stp"), 1, "error",
    ),
    "setpoints at 1e300": ({"s.csv": CSV, "p.nc": LINES}, ("verify", "s.csv", *VERIFY), 2, "setpoints-range"),
    "a period of 1e-9": (
        {"s.hal": "0 0\n1 0\n", "p.nc": LINES}, ("verify", "s.hal", *VERIFY, "--period", "1e-9"), 2, "setpoints-period"
    ),
    "a time of 5.5e303": (
        {"s.f64": struct.pack("<3d", 5.5e303, 0.0, 0.0), "p.nc": LINES}, ("verify", "s.f64", *VERIFY, "--axes", "XY"), 2, "setpoints-time"
    ),
}  # fmt: skip


def said_of(command: tuple[str, ...], capfd: pytest.CaptureFixture[str]) -> tuple[int, str]:
    """Run a command in this process, where warnings are errors; return its exit code and what it says."""
    code = app.run(list(command))
    return code, capfd.readouterr().err


@pytest.mark.parametrize("name", CASES)
def test_bounds(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    files, command, code, expected = CASES[name]
    monkeypatch.chdir(tmp_path)
    for file, content in files.items():
        (tmp_path / file).write_bytes(content.encode() if isinstance(content, str) else content)
    found, said = said_of(command, capfd)
    assert (found, expected in said) == (code, True), said
    assert not (tmp_path / "o.csv").exists()


def test_a_machine_that_hardly_accelerates(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """3.8e-6 mm/s² and 2.8e6 mm/s were an internal error; the way is v²/a of 1 mm/s at most, so 1e-3 mm take 32 s."""
    monkeypatch.chdir(tmp_path)
    limits = "max_velocity_mm_s = 2.8e6\nmax_acceleration_mm_s2 = 3.8e-6\nmax_jerk_mm_s3 = 5e4\n"
    head = 'name = "slow"\nperiod_s = 0.1\nchord_tolerance_mm = 0.001\n'
    (tmp_path / "slow.toml").write_text(head + f"[axes.x]\n{limits}[axes.y]\n{limits}")
    (tmp_path / "p.nc").write_text("G21 G90 G61\nG1 X0.001 F1000\nM2\n")
    assert said_of(("plan", "p.nc", "-m", "slow.toml", "-o", "o.csv"), capfd)[0] == 0
    # From rest to rest in 2 √(s/a), and jerk adds nothing that shows.
    rows = (tmp_path / "o.csv").read_text().splitlines()
    assert float(rows[-1].split(",")[0]) == pytest.approx(2.0 * (1e-3 / 3.8e-6) ** 0.5, abs=0.2)
    assert said_of(("verify", "o.csv", "-p", "p.nc", "-m", "slow.toml"), capfd)[0] == 0


def test_warnings_of_libraries_say_nothing_to_a_user(tmp_path: Path) -> None:
    """In a process of its own: pytest takes warnings before they are shown."""
    (tmp_path / "p.nc").write_text(LINES)
    code = f"from cncgen.cli import app; print(app.run(['check', {str(tmp_path / 'p.nc')!r}]))\n"
    code += "import numpy, warnings; numpy.divide(numpy.ones(1), numpy.zeros(1)); warnings.warn('odd', RuntimeWarning)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "0\n"
    assert [line for line in done.stderr.splitlines() if "no errors" not in line] == []
    code = "import cncgen.report.drawing, logging; logging.getLogger('matplotlib.font_manager').warning('findfont: no cmr10')"
    drawn = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert drawn.stderr == ""


def test_a_cache_that_matplotlib_cannot_write_is_no_word_on_standard_error(tmp_path: Path) -> None:
    """Its three lines stood among the JSON of --json."""
    pytest.importorskip("matplotlib")
    (tmp_path / "p.nc").write_text(LINES)
    (tmp_path / "file").write_text("")
    run = subprocess.run(
        [
            sys.executable,
            "-m",
            "cncgen",
            "plot",
            "p.nc",
            "-m",
            "xy-table",
            "--kinds",
            "path",
            "-o",
            "p.svg",
            "--json",
        ],
        cwd=tmp_path,
        env={**os.environ, "MPLCONFIGDIR": str(tmp_path / "file" / "none")},
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stderr == ""


def test_bounds_of_security_are_those_of_the_code() -> None:
    """Each row of the table in SECURITY.md, with the constants that hold it."""
    table = (ROOT / "SECURITY.md").read_text().partition("## Bounds")[2]
    row = {
        cells[0]: cells[1]
        for line in table.splitlines()
        if len(cells := [c.strip() for c in line.strip("| ").split("|")]) > 1
    }
    periods = (TOP_NUMBERS["period_s"].low, TOP_NUMBERS["period_s"].high, *ranges.PERIOD_S)
    assert row["memory of a run beside what it has at its start (Linux)"] == f"{memory.DEFAULT_MIB} MiB"
    assert row["nested calls"] == str(ReadOptions().max_call_depth)
    stated = "{:g} to {:g} s of a machine, {:g} to {:g} s of a file".format(*periods).replace("e-0", "e-")
    assert row["time between setpoints"] == stated
    assert float(row["setpoints of one motion"]) == MOST_ROWS
    assert row["numbers of words, coordinates"] == f"±{ranges.POSITION:g}, mm or rad".replace("1e+08", "1e8")
    assert tuple(map(float, row["factors of frames, all together"].split(" to "))) == ranges.FACTORS
    assert float(row["weights of one rational curve"].rpartition(" ")[2]) == ranges.WEIGHT_RATIO
    work = next(cell for name, cell in row.items() if name.startswith("work of a program"))
    assert work.startswith(f"{budget.MOST_WORK:,} units and {budget.WORK_OF_A_LINE} a line")
    search = next(cell for name, cell in row.items() if name.startswith("search for a faster way"))
    beyond = f"{stream._OF_A_LINE:,} for each line beyond {stream._LINES}"
    assert search == f"{stream._MOST:,} units of some 10 µs, and {beyond}"
    long = next(cell for name, cell in row.items() if name.startswith("length of a plan"))
    assert long == (
        f"{planning.MOST_PIECES:,}, and {planning.PIECES_OF_A_LINE} for each line beyond {planning.FREE_LINES}"
    )
    pieces = next(cell for name, cell in row.items() if name.startswith("pieces that `cut` makes"))
    assert pieces == f"{sweeps.MOST_PIECES:,}"
    for begin, most in (
        ("motions and events that", reading.PLANNED),
        ("the same to a plan", reading.PREDICTED),
        ("the same to `why`", reading.REPEATED),
        ("setpoints of a program", (compensation.MOST_ROWS, compensation.MOST_ROWS_OF_A_LINE)),
    ):
        (cell,) = (cell for name, cell in row.items() if name.startswith(begin))
        assert cell == f"{most[0]:,} and {most[1]:,} a line"


def test_a_loop_of_more_motions_than_planning_takes_is_refused_where_they_are_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """131,068 motions of four lines took minutes to plan; the options allow more."""
    loop = "G21 G90 F3000\no1 repeat [65534]\nG1 X3 Y0.4\nX0.4 Y2\no1 endrepeat\nM2\n"
    (tmp_path / "p.nc").write_text(loop)
    monkeypatch.chdir(tmp_path)
    code, said = said_of(("convert", "p.nc", "-o", "o.nc"), capfd)
    assert code == 1
    assert "p.nc:3:1: error[too-many-steps]: more than 100400 motions" in said
    assert "--max-steps" in said
    assert not (tmp_path / "o.nc").exists()
    assert said_of(("convert", "p.nc", "-o", "o.nc", "--max-steps", "200000"), capfd)[0] == 0


def test_the_search_of_a_short_program_ends_with_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """What follows is the plan of the speed alone: it takes as long, and it holds its limits and the tolerance."""
    loop = "G21 G90 F3000\no1 repeat [200]\nG1 X3 Y0.4\nX0.4 Y2\no1 endrepeat\nM2\n"
    (tmp_path / "p.nc").write_text(loop)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cncgen.planner.tube.stream._MOST", 10_000)
    monkeypatch.setattr("cncgen.planner.tube.stream._OF_SECONDS", 0)
    code, said = said_of(("plan", "p.nc", "-m", "xy-table", "-o", "o.csv"), capfd)
    assert code == 0
    assert said.count("warning[search-ends]") == 1
    assert "--max-steps" in said
    assert said_of(("verify", "o.csv", "--program", "p.nc", "--machine", "xy-table"), capfd)[0] == 0
    whole = ("plan", "p.nc", "-m", "xy-table", "-o", "w.csv", "--max-steps", "1000")
    assert "search-ends" not in said_of(whole, capfd)[1]


def test_numbers_in_patterns_take_their_digits_once() -> None:
    """Digits, perhaps a point, and digits: where such a row may be parted anywhere, five thousand digits take ten seconds."""
    parted = re.compile(r"\\d[+*](?:\\\.|\[\.,\])\?\\d\*(?!\+)")
    assert parted.search(r"[A-Z](?:\d+\.?\d*|\.\d+)")
    assert [
        f"{file}:{number}"
        for file in sorted((ROOT / "cncgen").rglob("*.py"))
        for number, line in enumerate(file.read_text().splitlines(), 1)
        if parted.search(line)
    ] == []
