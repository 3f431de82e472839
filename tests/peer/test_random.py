"""A fixed set of random programs agrees with LinuxCNC's interpreter; benchmarks/random_programs.py runs thousands."""

from __future__ import annotations

from pathlib import Path

import pytest
from comparison import difference, ours
from grammar import STAGES, programs, write_files
from hypothesis import given, settings
from rs274 import PROGRAMS, Setup, installed, run_once, without_reset

needs_peer = [
    pytest.mark.peer,
    pytest.mark.skipif(not installed(), reason="rs274 (LinuxCNC) is not installed"),
]


def check(text: str, folder: Path) -> None:
    """Demand the same calls of both interpreters."""
    program = folder / "random.ngc"
    program.write_text(text)
    write_files(folder)
    setup = Setup(tools=PROGRAMS / "mill.tbl")
    peer = run_once(program, setup)
    if peer.error is not None:
        # How many calls of the wrong block come before the error is not known here; no block makes more than these.
        peer.calls = without_reset(peer.calls)
        peer.partial = min(2, len(peer.calls))
    assert difference(program, ours(program, setup), peer) is None


@pytest.mark.parametrize("stage", [pytest.param(name, marks=needs_peer) for name in STAGES])
def test_programs_of_each_stage_agree(stage: str, tmp_path: Path) -> None:
    """A few programs of each feature by itself, straight lines between."""

    @settings(max_examples=10)
    @given(text=programs((stage, "lines")))
    def agrees(text: str) -> None:
        check(text, tmp_path)

    agrees()


@pytest.mark.peer
@pytest.mark.skipif(not installed(), reason="rs274 (LinuxCNC) is not installed")
def test_programs_of_the_whole_language_agree(tmp_path: Path) -> None:
    """Features in any order after one another."""

    @settings(max_examples=80)
    @given(text=programs())
    def agrees(text: str) -> None:
        check(text, tmp_path)

    agrees()


@settings(max_examples=100)
@given(text=programs())
def test_random_programs_read_without_a_crash(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    """Without the peer: what the grammar calls valid gives calls, and errors in gouged corners alone."""
    program = tmp_path_factory.mktemp("random") / "random.ngc"
    program.write_text(text)
    write_files(program.parent)
    mine = ours(program, Setup(tools=PROGRAMS / "mill.tbl"))
    assert mine.calls
    assert mine.error is None or "error[comp-" in mine.error
