"""Wrong calls of every command: a message that says what is wrong, its exit code, no trace and no file left behind."""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

import pytest

from cncgen.cli.app import run

ROOT = Path(__file__).resolve().parent.parent.parent

PART = "G21 G90 G61\nG1 X1 Y1 F600\nX2\nM2\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a program, its setpoints and a response to them."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "part.nc").write_text(PART)
    (folder / "dwell.nc").write_text("G21\nG4 P0.1\nM2\n")
    plan = ["plan", f"{folder}/part.nc", "-m", "xy-table", "-q", "-o", f"{folder}/s.csv"]
    assert run(plan) == 0
    simulate = ["simulate", f"{folder}/s.csv", "--axis-params", "xy-table", "-q", "-o", f"{folder}/r.csv"]
    assert run(simulate) == 0
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it, to work in."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("call", "code", "told"),
    [
        ("plan part.nc --signals ,", 2, "--signals names nothing"),
        ("plan part.nc --signals foo,vel", 2, "signals foo: not one of vel, acc"),
        ("plan part.nc --max-steps 0", 2, "0 is not in the range x>=1"),
        ("plan part.nc --tool-table nope", 2, "cannot read nope"),
        ("plan part.nc --parameters nope", 2, "cannot read nope"),
        ("plan part.nc -m .", 2, "it is a directory"),
        ("plan part.nc -m part.nc", 2, "part.nc"),
        ("plan part.nc -m xy-tabel", 2, "did you mean xy-table"),
        ("plan part.nc --path-tolerance 0", 2, "0.0 is not in the range 0<x<=1000000.0"),
        ("plan part.nc --path-tolerance 1e9", 2, "is not in the range 0<x<=1000000.0"),
        ("plan part.nc --feedrate fast", 2, "'fast' is not one of"),
        ("plan part.nc --format xlsx -o out", 2, "'xlsx' is not one of"),
        ("plan part.nc --language klingon", 2, "'klingon' is not one of"),
        ("plan part.nc --include nope", 2, "cannot read nope: there is no such file"),
        ("plan part.nc --include part.nc", 2, "not a directory"),
        ("verify s.csv -p part.nc --axes XX", 2, "'XX' does not name axes"),
        ("simulate s.csv --axes X,Q", 2, "'X,Q' does not name axes"),
        ("report part.nc -o page.pdf", 2, "page.pdf: a page is written as .html"),
        ("simulate --axis-params xy-table --fmu axes.zip", 2, "a unit of FMI is written as .fmu"),
        ("reproduce hsu", 2, "003 (tsai_2010), 004 (hsu_1999)"),
        (
            "plan part.nc -m xy-table --format csp-raw -o f",
            2,
            "csp and csp-raw need the drive scaling of axis X, Y",
        ),
        ("plan s.csv", 2, "s.csv holds setpoints or a response, not a program"),
        ("check r.csv", 2, "r.csv holds setpoints or a response, not a program"),
        ("verify s.csv -p s.csv", 2, "s.csv holds setpoints or a response, not a program"),
        ("plan part.nc more.nc", 2, "unexpected extra argument"),
        ("paln part.nc", 2, "did you mean plan?"),
        (
            "compare part.nc --interpolator taylor1 --interpolator taylor2",
            2,
            "--interpolator is given more than once",
        ),
        ("sweep run s.toml -o a --output b", 2, "--output is given more than once"),
        ("plan part.nc -o none/out.csv", 2, "its directory does not exist"),
        ("plan part.nc -o part.nc", 2, "would overwrite"),
        ("plan part.nc -m xy-table --max-contour-error 1e-9", 2, "1e-09 is not in the range x>=1e-06"),
        (
            "plan part.nc --events -",
            2,
            "--events and what the command writes cannot both go to standard output",
        ),
        (
            "plan part.nc -o a.csv --events - --save-parameters -",
            2,
            "--events and --save-parameters cannot both go",
        ),
        ("canon part.nc --save-parameters -", 2, "--save-parameters and what the command writes"),
        ("simulate part.nc --controller nope", 2, "no controller is called 'nope'"),
        ("simulate part.nc --settle -1", 2, "-1.0 is not in the range"),
        ("simulate part.nc --format csv", 2, "is not a setpoint file"),
        ("simulate s.csv --axis-params generic", 2, "there is no machine profile 'generic'"),
        ("simulate s.csv --axis-params xy-table --axes U", 2, "s.csv has no axis U; it has X, Y"),
        ("simulate s.csv --axis-params xy-table --axes XZ", 2, "s.csv has no axis Z; it has X"),
        ("simulate s.csv --axis-params xy-table --controller tcf --axes x", 2, "tcf"),
        ("verify s.csv -m xy-table", 2, "Missing option '-p' / '--program'"),
        ("verify - -p - -m xy-table", 2, "cannot both come from standard input"),
        ("verify s.csv -p part.nc --resolution 0", 2, "0.0 is not in the range 0<x<=1.0"),
        ("verify s.csv -p dwell.nc -m xy-table", 1, "verify-distance"),
        ("compare part.nc --feedrates foo,optimal,baz", 2, "feedrate = 'baz' is not one of optimal, ild"),
        ("compare part.nc --feedrates constant --interpolators bar", 2, "interpolator = 'bar' is not one of"),
        ("compare part.nc --interpolators ,", 2, "the list names nothing"),
        ("compare part.nc --controllers x -m xy-table", 2, "no controller is called 'x'"),
        ("compensate s.csv", 2, "give the servo data"),
        ("compensate part.nc --axis-params xy-table", 2, "a program is planned for a machine"),
        ("compensate s.csv -m xy-table --room 80%", 2, "setpoints are planned already"),
        ("compensate part.nc -m xy-table --room 3", 2, "is not within 5% and 100%"),
        ("compensate part.nc -m xy-table --perturb ten", 2, "is not a share, such as 10% or 0.1"),
        ("compensate s.csv -m xy-table --passes 0", 2, "0 is not in the range 1<=x<=100"),
        ("compensate s.csv --axis-params xy-table -o s.csv", 2, "--output s.csv would overwrite"),
        ("identify r.csv --axis q", 2, "r.csv has no axis Q; it has X, Y"),
        ("identify s.csv", 2, "the model needs the column x_force"),
        ("identify part.nc", 2, "names no column of times (t_s)"),
        ("identify r.csv --counts-per-mm -1", 2, "-1.0 is not in the range x>0"),
        ("identify r.csv --counts-per-rad 1591", 2, "--counts-per-mm and --counts-per-rad go together"),
        ("excite --axis q", 2, "has no axis q"),
        ("excite --axis x --low 100 --high 1", 2, "must rise and end below 500 Hz"),
        ("excite --axis x --share 2", 2, "the share is 2; it must be more than 0 and at most 1"),
        ("excite --axis x --amplitude nan", 2, "it must be at least 1e-09 and finite"),
        ("excite --axis x --amplitude 1e-308", 2, "it must be at least 1e-09 and finite"),
        ("excite --axis x -m xy-table --center 1e9", 2, "travel"),
        ("tune", 2, "give --bandwidth, or a PROGRAM to tune on"),
        ("tune --bandwidth 1e9 -m xy-table", 2, "bandwidth and damping must be positive"),
        ("tune part.nc --controller h-infinity", 2, "no gains to search on a program"),
        ("tune dwell.nc -m xy-table --sets 1", 2, "dwell.nc moves nothing"),
        ("convert part.nc --linearize 1e-12", 2, "1e-12 is not in the range x>=1e-09"),
        ("convert part.nc --linearize nan", 2, "not a finite number"),
        ("convert part.nc --to postscript", 2, "'postscript' is not one of"),
        ("reproduce 999", 2, "no paper is called '999'"),
        ("reproduce 000 --programs nowhere", 2, "bonder.nc is not in nowhere"),
        ("plot part.nc", 2, "Missing option '-o'"),
        ("plot part.nc -o a.jpg", 2, "written as .png, .svg, .pdf"),
        ("plot part.nc -o a.png", 2, "is one file for"),
        ("plot r.csv -o a.png --kinds foo", 2, "no picture is called foo"),
        ("plot s.csv -o a.png --kinds force", 2, "has no forces"),
        ("report part.nc -o none/a.html", 2, "its directory does not exist"),
        ("machines show nope", 2, "there is no machine profile 'nope'"),
        ("machines list", 2, "there is no machine profile 'list'"),
        ("codes --dialect foo", 2, "'foo' is not one of"),
        ("canon part.nc --table-units cubit", 2, "'cubit' is not one of"),
        ("check", 2, "Missing argument 'PROGRAM...'"),
        ("check part.nc nope.nc", 2, "cannot read nope.nc"),
    ],
)
def test_wrong_calls(
    folder: Path, capsys: pytest.CaptureFixture[str], call: str, code: int, told: str
) -> None:
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert run(call.split()) == code
    said = capsys.readouterr()
    assert told in said.err
    assert "internal error" not in said.err
    assert "Traceback" not in said.err
    assert said.out == ""
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize(
    ("call", "told"),
    [
        ("plan nope.nc -o none/a.csv", "cannot write none/a.csv: its directory does not exist"),
        ("plan nope.nc -o a.csv --events none/e", "cannot write none/e"),
        ("plan nope.nc -o a.parquet", "format parquet needs pyarrow"),
        ("compensate nope.nc -m xy-table -o none/a.csv", "cannot write none/a.csv"),
        ("compensate nope.nc -m xy-table -o a.xyz", "no format of setpoints has the suffix .xyz"),
        ("compensate nope.nc -m xy-table -o a.csv --wanted a.parquet", "format parquet needs pyarrow"),
        ("report nope.nc -o none/a.html", "cannot write none/a.html"),
        ("tune nope.nc -o .", "cannot write .: it is a directory"),
        ("plot nope.nc -o a.png", "a.png is one file for several pictures"),
        ("plot nope.nc -o part.nc", "cannot write pictures into part.nc: it is a file"),
        ("plot nope.nc -o none/a.png --kinds path", "cannot write none/a.png"),
        ("plot nope.nc -o a --kinds foo", "no picture is called foo"),
        ("cut nope.nc --picture a.xyz", "pictures are written as .png"),
        ("plot nope.nc -o a", "pictures need matplotlib"),
        ("cut nope.nc --picture a.svg", "pictures need matplotlib"),
        ("cut nope.nc --picture none/a.png", "cannot write none/a.png"),
        ("cut nope.nc -o a.png", "the stock is written as .stl"),
    ],
)
def test_outputs_are_judged_before_anything_is_read(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, call: str, told: str
) -> None:
    """They were named after minutes of work; that there is no such program would be the first thing to read."""
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    if "matplotlib" in told:
        monkeypatch.setitem(sys.modules, "matplotlib", None)
    before = sorted(folder.iterdir())
    assert run(call.split()) == 2
    assert told in capsys.readouterr().err
    assert sorted(folder.iterdir()) == before


@pytest.mark.parametrize(
    ("call", "work", "told"),
    [
        (
            "report part.nc --compare feedrate=foo",
            "cncgen.pipeline.reporting._recorded",
            "'foo' is not one of",
        ),
        ("report part.nc --compare nope.toml", "cncgen.pipeline.reporting._recorded", "nope.toml"),
        ("report part.nc --compare nope.csv", "cncgen.pipeline.reporting._recorded", "cannot read nope.csv"),
        (
            "compare part.nc --interpolators a",
            "cncgen.report.comparison.compare_strategies",
            "'a' is not one of",
        ),
        ("compare part.nc --controllers p,foo", "cncgen.planner.plan", "no controller is called 'foo'"),
    ],
)
def test_names_are_judged_before_the_work(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    call: str,
    work: str,
    told: str,
) -> None:
    def begun(*_: object, **__: object) -> None:
        raise AssertionError("the work has begun")

    monkeypatch.setattr(work, begun)
    assert run([*call.split(), "-o", "a.html"]) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ("call", "written"),
    [
        ("plan dwell.nc -m xy-table --signals vel,acc,jerk,feed,line,limit", "0.100000000,0.000000000"),
        ("compare dwell.nc", "| arclength    |                 0 |     0 | 0.1000 |"),
        ("convert dwell.nc --to stepnc", "END-ISO-10303-21;"),
        ("canon dwell.nc", "DWELL(0.1000)"),
    ],
)
def test_a_program_that_only_waits(
    folder: Path, capsys: pytest.CaptureFixture[str], call: str, written: str
) -> None:
    assert run(call.split()) == 0
    assert written in capsys.readouterr().out


@pytest.mark.parametrize(
    ("content", "fine"),
    [
        (PART.encode("utf-8-sig"), True),
        (PART.replace("\n", "\r\n").encode(), True),
        (PART.replace("\n", "\r").encode(), True),
        (PART.encode() + b"\x1a", True),
        (PART.replace("M2", "(\u00fcber)\nM2").encode("latin-1"), True),
        (b"%\n" + PART.encode() + b"%\n", True),
        (PART.encode("utf-16"), True),
        (PART.encode("utf-16-le"), False),
        (PART.encode("utf-32-be"), False),
        (PART.encode("cp037"), False),
        (bytes(range(256)) * 40, False),
    ],
    ids=[
        "BOM",
        "CR LF",
        "CR",
        "Ctrl-Z",
        "Latin-1",
        "%",
        "UTF-16",
        "UTF-16 without its mark",
        "UTF-32",
        "EBCDIC",
        "bytes",
    ],
)
def test_encodings_of_programs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], content: bytes, fine: bool
) -> None:
    """What editors, controls and file transfers make of a text has the same two motions; what is no text is a fault."""
    path = tmp_path / "part.nc"
    path.write_bytes(content)
    assert run(["canon", str(path)]) == (0 if fine else 1)
    said = capsys.readouterr()
    assert re.findall(r"STRAIGHT_FEED\(([0-9.]+)", said.out) == (["1.0000", "2.0000"] if fine else [])
    assert fine or "error[" in said.err
