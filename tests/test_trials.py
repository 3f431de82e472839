"""Seeds of evidence are apart from those of tuning, and the page shows what the script wrote."""

from __future__ import annotations

from pathlib import Path

import pytest

from trials import evidence, seeds
from trials.evidence import PAGE, Result, stored, with_tables


def test_seeds_for_tuning_and_for_evidence_are_apart() -> None:
    assert set(seeds.TUNING) == set(seeds.EVIDENCE)
    for trial, tuning in seeds.TUNING.items():
        found = seeds.EVIDENCE[trial]
        assert tuning.stop <= found.start or found.stop <= tuning.start, trial


def test_stored_results_are_of_seeds_for_evidence() -> None:
    for result in stored():
        first, last = result.seeds
        assert first <= last
        assert {first, last} <= set(seeds.EVIDENCE[result.trial]), result
        assert 0 <= result.failures <= result.programs


def test_the_page_shows_the_stored_results() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert with_tables(page, stored()) == page, "python -m trials.evidence --write"
    for trial in {result.trial for result in stored()}:
        assert f"<!-- trial: {trial} -->" in page


def test_a_run_takes_fresh_seeds_and_is_stored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evidence, "STORE", tmp_path / "evidence.json")
    evidence.store([Result("examiner", "units", "10⁻⁹", (20_000, 20_300), 159, 0)])
    monkeypatch.setitem(evidence.RUNS, "examiner", lambda name, count, seed: (2, seed + count - 1))
    found = evidence.run("examiner", "units", 50, replace=False)
    assert (found.seeds, found.programs, found.failures) == ((20_301, 20_350), 50, 2)
    assert [one.seeds[0] for one in stored()] == [20_000, 20_301]
    assert "| `units` | 10⁻⁹ | 20301 to 20350 | 50 | 2 | |" in evidence.table("examiner", stored())
    with pytest.raises(KeyError, match="write what it asks"):
        evidence.run("examiner", "nothing", 1, replace=False)
