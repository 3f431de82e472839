"""What ``--compare`` names, and ``cncgen view``."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cncgen
from cncgen.cli.app import run
from cncgen.diagnostics import Severity, UsageError
from cncgen.pipeline import ShownPart, report_page, variant_of
from cncgen.pipeline.removing import cut
from cncgen.report.page import Recording
from cncgen.setpoints.differencing import differenced

ROOT = Path(__file__).resolve().parent.parent.parent
SQUARE = "G21 G90 G94 G61 F1200\nG1 X10\nY10\nX0\nY0\nM2\n"


def parts_of(page: str) -> list[dict[str, Any]]:
    found = re.search(r'id="header">(.*?)</script>', page, re.S)
    assert found
    parts: list[dict[str, Any]] = json.loads(found[1])["parts"]
    return parts


def test_a_machine_settings_or_a_file(tmp_path: Path) -> None:
    options = cncgen.PlanOptions(path_tolerance_mm=0.03)
    assert variant_of("xy-table", options).machine == "xy-table"
    found = variant_of("feedrate=ild,tolerance=0.02,machine=dyna-1007", options)
    assert (found.machine, found.options) == (
        "dyna-1007",
        cncgen.PlanOptions(feedrate="ild", path_tolerance_mm=0.02),
    )
    file = tmp_path / "s.csv"
    file.write_text("t_s,x_mm\n0,0\n0.001,0\n")
    assert variant_of(str(file)).setpoints == str(file)
    with pytest.raises(UsageError, match=r"cannot read none\.csv: there is no such file"):
        report_page(cncgen.read_text(SQUARE), "xy-table", compare=[variant_of("none.csv")])


@pytest.mark.parametrize("what", ["speed=3", "tolerance=wide", "tolerance=-1", "tolerance=nan"])
def test_what_cannot_be_compared_is_named(what: str) -> None:
    with pytest.raises(UsageError, match=re.escape(what.split("=")[0])):
        variant_of(what)


def test_charts_of_a_plan_that_jumps_show_its_jumps(monkeypatch: pytest.MonkeyPatch) -> None:
    """20 mm/s from rest in one period of 1 ms are 20,000 mm/s²; the plan's own acceleration is 0, and so was the chart's."""
    seen: list[float] = []
    take = Recording._take_motion
    monkeypatch.setattr(
        Recording,
        "_take_motion",
        lambda self, chunk: (seen.append(float(np.abs(chunk.signals["acc"]).max())), take(self, chunk)),
    )
    report_page(cncgen.read_text(SQUARE), "xy-table", cncgen.PlanOptions(feedrate="constant"))
    assert max(seen) == pytest.approx(20_000.0, rel=1e-6)


def test_a_page_has_all_of_the_plans(tmp_path: Path) -> None:
    file, rows = tmp_path / "square.nc", tmp_path / "rows.csv"
    file.write_text(SQUARE)
    cncgen.write(cncgen.sample(cncgen.plan(file, "xy-table", feedrate="constant")), rows)
    variants = [variant_of("feedrate=ild"), variant_of(str(rows)), variant_of("generic-mill")]
    parts = parts_of(report_page(file, "xy-table", compare=variants).html)
    assert [part["label"] for part in parts] == ["xy-table", "feedrate=ild", "rows.csv", "generic-mill"]
    assert [part["machine"] for part in parts] == ["xy-table", "xy-table", "xy-table", "generic-mill"]
    assert [part["rows"] for part in parts][2] == len(rows.read_text().splitlines()) - 1
    assert "line" not in parts[2]["streams"]
    assert {"feed_mm_s", "x_jerk_mm_s3"} <= parts[2]["streams"].keys()


def test_errors_from_the_wanted_motion_stand_beside_those_from_the_command(tmp_path: Path) -> None:
    """The figures are those of `cncgen simulate --reference`, and the signal's largest value is the largest error."""
    file, found = tmp_path / "square.nc", tmp_path / "s.json"
    file.write_text(SQUARE)
    page = tmp_path / "page.html"
    assert run(["report", str(file), "-m", "dyna-1007", "--reference", str(file), "-o", str(page)]) == 0
    call = ["simulate", str(file), "-m", "dyna-1007", "--reference", str(file), "-o", str(tmp_path / "r.csv")]
    assert run([*call, "--summary", str(found)]) == 0
    (part,) = parts_of(page.read_text())
    shown, wanted = part["summary"]["reference"], json.loads(found.read_text())["reference"]
    assert [shown.pop(key) for key in ("name", "contour_error_of")] == [wanted.pop("name"), "XY"]
    assert wanted.pop("contour_error_of") == "XY"
    assert shown == pytest.approx(wanted, rel=1e-6)
    assert {"contour_error_mm", "reference_contour_mm"} <= part["streams"].keys()


def test_errors_need_servo_data(tmp_path: Path) -> None:
    file, machine = tmp_path / "square.nc", tmp_path / "bare.toml"
    file.write_text(SQUARE)
    limits = "max_velocity_mm_s = 100.0\nmax_acceleration_mm_s2 = 1000.0\nmax_jerk_mm_s3 = 5e4\n"
    machine.write_text(f"period_s = 0.001\n[axes.x]\n{limits}[axes.y]\n{limits}")
    assert run(["report", str(file), "-m", str(machine), "--reference", str(file), "-o", "-"]) == 2


def test_differences_go_on_from_chunk_to_chunk() -> None:
    """x = t³: velocity, acceleration and jerk as numpy differences them, from rest before the first row."""
    t = np.arange(40) * 0.01
    rows = np.column_stack([t**3, 2 * t])
    padded = np.concatenate([np.repeat(rows[:1], 3, axis=0), rows])
    for sizes in ([40], [1, 1, 1, 37], [2, 17, 21]):
        edges = np.concatenate([[0], np.cumsum(sizes)])
        chunks = [cncgen.Setpoints("XY", 0.01, int(a), rows[a:b]) for a, b in pairwise(edges)]
        found = list(differenced(chunks))
        for order, name in enumerate(("vel", "acc", "jerk"), start=1):
            expected = np.diff(padded, n=order, axis=0)[3 - order :] / 0.01**order
            np.testing.assert_allclose(np.concatenate([c.signals[name] for c in found]), expected, atol=1e-9)
        speed = np.concatenate([c.signals["feed"] for c in found])
        np.testing.assert_allclose(speed, np.linalg.norm(np.diff(padded, axis=0)[2:], axis=1) / 0.01)


def test_view_opens_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda url: bool(opened.append(url)) or True)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    file = tmp_path / "square.nc"
    file.write_text(SQUARE)
    assert run(["view", str(file), "-m", "xy-table"]) == 0
    (page,) = tmp_path.glob("cncgen-*.html")
    assert opened == [page.as_uri()]
    assert parts_of(page.read_text(encoding="utf-8"))[0]["machine"] == "xy-table"
    assert str(page) in capsys.readouterr().err
    monkeypatch.setattr("webbrowser.open", lambda url: False)
    assert run(["view", str(file), "-m", "xy-table"]) == 0
    assert "no browser can be started here" in capsys.readouterr().err


def test_a_page_on_features_shows_the_part_without_being_asked(tmp_path: Path) -> None:
    """The raw piece of the file; a file without one is told of, and its page shows no part."""
    files = ROOT / "programs" / "stepnc"
    page = report_page(files / "shaft.stp")
    removal = parts_of(page.html)[0]["removal"]
    assert removal["removed_mm3"] == pytest.approx(
        sum(o.volume_mm3 for o in cut(files / "shaft.stp").operations), rel=1e-9
    )
    assert not page.remarks
    page = report_page(files / "nist_ex1E.stp")
    assert "removal" not in parts_of(page.html)[0]
    assert [(item.code, item.severity) for item in page.remarks] == [("cut-stock", Severity.NOTE)]


def test_a_stock_that_is_asked_for_must_be_one(tmp_path: Path) -> None:
    program = tmp_path / "a.nc"
    program.write_text(SQUARE)
    with pytest.raises(UsageError, match="box"):
        report_page(program, "xy-table", shown_part=ShownPart("box:1"))
    with pytest.raises(UsageError, match="stock is not known"):
        report_page(program, "xy-table", shown_part=ShownPart(tools=("*=flat:8",)))


def test_an_estimate_of_a_control_is_not_said_to_break_limits(tmp_path: Path) -> None:
    """Its trapezoids know no jerk, and its positions stay on the path where the control would round a corner; as of ``plan --as``."""
    (tmp_path / "square.nc").write_text(SQUARE)
    page = report_page(tmp_path / "square.nc", "xy-table", compare=[variant_of("as=grbl")])
    assert [item.code for item in page.remarks] == ["plan-estimate"]
    assert parts_of(page.html)[1]["summary"]["feedrate"] == "grbl"
