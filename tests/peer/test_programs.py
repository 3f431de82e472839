"""Every case under cases/ gives the canonical calls that LinuxCNC's interpreter printed for it."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from trials.peer_cases import CASES, PEER, PeerCase, peer_cases, read_file
from trials.peer_comparison import difference, ours
from trials.rs274 import Output, installed, run

ALL = peer_cases()


def ids(case: PeerCase) -> str:
    """Name a test by its case."""
    return case.name


@pytest.mark.parametrize("case", ALL, ids=ids)
def test_calls_are_those_that_the_peer_printed(case: PeerCase, folder: Path) -> None:
    """Against the stored output, so it runs everywhere; differences by choice or by a fault of the peer must stay."""
    assert case.expected is not None, f"python -m trials.regenerate_peer_cases {case.name}"
    program = folder / f"{case.name}.ngc"
    found = difference(program, ours(program), Output.parse(case.expected))
    if case.differs:
        assert found, f"{case.name} agrees: take the reason out of its first line"
    else:
        assert found is None, found


@pytest.mark.peer
@pytest.mark.skipif(not installed(), reason="rs274 (LinuxCNC) is not installed")
@pytest.mark.parametrize("case", ALL, ids=ids)
def test_stored_output_is_what_the_peer_prints_now(case: PeerCase, folder: Path) -> None:
    """Against a fresh run: the stored output has not gone stale."""
    assert run(folder / f"{case.name}.ngc").text() == case.expected


def test_cases_are_read_as_they_are_written() -> None:
    """Bytes of each file come back, each case has its own name, and no program stands elsewhere."""
    for path in CASES.glob("*.txt"):
        assert "".join(case.text() for case in read_file(path)) == path.read_text(encoding="utf-8"), path.name
    assert [name for name, count in Counter(case.name for case in ALL).items() if count > 1] == []
    assert len(ALL) >= 860
    assert {path.name for path in PEER.iterdir() if path.is_dir()} - {"__pycache__"} == {"cases", "files"}


def test_a_case_that_was_not_run_has_no_output() -> None:
    case = PeerCase.parse("==== new | our choice: why\nG0 X1\nM2\n")
    assert (case.name, case.program, case.expected) == ("new", "G0 X1\nM2\n", None)
    assert (case.choice, case.fault) == ("why", "")
