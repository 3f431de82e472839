"""The papers' tables hold their stated tolerances, and a missed one is seen."""

from pathlib import Path

import pytest

from cncgen.diagnostics import UsageError
from cncgen.papers.planned import planned_program, program_text, with_feed
from cncgen.papers.printed import Row, Table
from cncgen.papers.reproduction import (
    NAMES,
    as_text,
    as_values,
    draw_papers,
    reproduce,
)
from cncgen.planner import PlanOptions


@pytest.mark.parametrize("name", NAMES)
def test_every_stated_tolerance_holds(name):
    tables = reproduce(name)
    assert [row.what for table in tables for row in table.rows if not row.holds] == []
    assert any(row.checked for table in tables for row in table.rows)
    assert all(table.assumptions for table in tables)


def test_a_missed_tolerance_is_named():
    rows = (
        Row("near", 1.04, 1.0, within=0.05),
        Row("far", 1.06, 1.0, within=0.05),
        Row("many", 3.0, at_most=2.0),
    )
    table = Table("T", rows)
    assert [row.holds for row in rows] == [True, False, False]
    assert not table.holds
    text = as_text([table])
    assert text.count("MISSED") == 2
    assert "T: far" in text
    assert Row("bound", 8.0, at_least=8.0).holds
    assert not Row("no number", float("nan"), at_most=1.0).holds


def test_unknown_papers_and_missing_programs_are_diagnostics(tmp_path):
    with pytest.raises(UsageError, match="reproduce-name"):
        reproduce("005")
    with pytest.raises(UsageError, match="reproduce-programs"):
        program_text("butterfly.nc", str(tmp_path))


def test_what_a_table_asks() -> None:
    rows = (
        Row("near", 1.04, 1.0, "s", within=0.05, at_least=1.0),
        Row("at most", 3.0, at_most=2.0),
        Row("shown", 1.0, 2.0),
    )
    assert [row.asked for row in rows] == ["±5 %, ≥ 1", "≤ 2", ""]
    assert [row.checked for row in rows] == [True, True, False]
    values = as_values([Table("T", rows, ("assumed",))])
    assert values["holds"] is False
    assert [row["holds"] for row in values["tables"][0]["rows"]] == [True, False, None]
    text = as_text([Table("T", rows[:1], ("assumed",))])
    assert text.endswith("  assumed\n\nall stated tolerances hold\n")


def test_a_feed_stands_in_for_the_first_of_the_program() -> None:
    """Comments name feeds too; the second F stays."""
    text = b"(F100 of old)\nG21\n ( F1 )\nG1 X1 F200.5 (F7)\nG1 X2 F300\n"
    assert with_feed(text, 1500.0) == text.replace(b"F200.5", b"F1500")
    assert with_feed(b"M2\n", 1500.0) == b"M2\n"


def test_a_planned_program_is_its_setpoints(tmp_path: Path) -> None:
    (tmp_path / "line.nc").write_text("G21 G90 G61\nG1 X10 F600\nM2\n")
    options = PlanOptions(feedrate="constant")
    found = planned_program("line.nc", "xy-table", str(tmp_path), 1200.0, options)
    assert found.time_s == pytest.approx(0.5, abs=1e-12)
    assert len(found.signal("position")) == 501
    assert found.signal("feed")[250] == pytest.approx(20.0)
    assert set(found.servos) == {"X", "Y"}
    assert found.corners == sum(len(t.corners) for t in found.trajectories)


@pytest.mark.parametrize("paper", NAMES)
def test_figures_of_the_papers(paper, tmp_path):
    pytest.importorskip("matplotlib")
    files = draw_papers(str(tmp_path), paper)
    assert len(files) >= 2
    assert all(Path(file).read_bytes().startswith(b"\x89PNG") for file in files)
