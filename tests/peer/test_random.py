"""A fixed set of random programs agrees with LinuxCNC's interpreter; trials/language_beside_rs274.py runs thousands."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings

from trials.generators.gcode_language import STAGES, programs, write_files
from trials.peer_cases import FILES
from trials.peer_comparison import disagreement, ours
from trials.rs274 import Setup, installed

needs_peer = [
    pytest.mark.peer,
    pytest.mark.skipif(not installed(), reason="rs274 (LinuxCNC) is not installed"),
]


@pytest.mark.parametrize("stage", [pytest.param(name, marks=needs_peer) for name in STAGES])
def test_programs_of_each_stage_agree(stage: str, tmp_path: Path) -> None:
    """A few programs of each feature by itself, straight lines between."""

    @settings(max_examples=10)
    @given(text=programs((stage, "lines")))
    def agrees(text: str) -> None:
        assert disagreement(text, tmp_path) is None

    agrees()


@pytest.mark.peer
@pytest.mark.skipif(not installed(), reason="rs274 (LinuxCNC) is not installed")
def test_programs_of_the_whole_language_agree(tmp_path: Path) -> None:
    """Features in any order after one another."""

    @settings(max_examples=80)
    @given(text=programs())
    def agrees(text: str) -> None:
        assert disagreement(text, tmp_path) is None

    agrees()


@settings(max_examples=100)
@given(text=programs())
def test_random_programs_read_without_a_crash(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    """Without the peer: what the grammar calls valid gives calls, and errors in gouged corners alone."""
    program = tmp_path_factory.mktemp("random") / "random.ngc"
    program.write_text(text)
    write_files(program.parent)
    mine = ours(program, Setup(tools=FILES / "mill.tbl"))
    assert mine.calls
    assert mine.error is None or "error[comp-" in mine.error
