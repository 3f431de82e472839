"""Every program under programs/ gives the canonical calls that LinuxCNC's interpreter printed for it."""

from __future__ import annotations

from pathlib import Path

import pytest

from trials.peer_comparison import CHOICES, PEER_FAULTS, difference, ours
from trials.rs274 import EXPECTED, Output, installed, programs, run


def ids(path: Path) -> str:
    """Name a case by its program."""
    return path.stem


def expect(program: Path, peer: Output) -> None:
    """Compare; what differs by choice or by a fault of the peer must differ still."""
    found = difference(program, ours(program), peer)
    if program.stem in PEER_FAULTS or program.stem in CHOICES:
        assert found, f"{program.stem} agrees: remove it from the table of differences"
        return
    assert found is None, found


@pytest.mark.parametrize("program", programs(), ids=ids)
def test_calls_are_those_that_the_peer_printed(program: Path) -> None:
    """Against the stored output, so it runs everywhere."""
    expect(program, Output.parse((EXPECTED / f"{program.stem}.canon").read_text()))


@pytest.mark.peer
@pytest.mark.skipif(not installed(), reason="rs274 (LinuxCNC) is not installed")
@pytest.mark.parametrize("program", programs(), ids=ids)
def test_stored_output_is_what_the_peer_prints_now(program: Path) -> None:
    """Against a fresh run: the stored output has not gone stale."""
    assert run(program).text() == (EXPECTED / f"{program.stem}.canon").read_text()


def test_every_program_has_its_output_and_every_output_its_program() -> None:
    """No file is left over on either side."""
    names = {p.stem for p in programs()}
    assert {p.stem for p in EXPECTED.glob("*.canon")} == names
    assert set(PEER_FAULTS) | set(CHOICES) <= names
    assert len(names) >= 150
