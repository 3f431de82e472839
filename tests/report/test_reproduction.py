"""The papers' tables hold their stated tolerances, and a missed one is seen."""

import pytest

from cncgen.diagnostics import UsageError
from cncgen.report.reproduction import NAMES, Row, Table, as_text, program_text, reproduce


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
