"""A minute at most of fuzzing: mutated programs crash nothing, hang nothing and stay within their memory."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.skipif(sys.platform != "linux", reason="memory is bounded through Linux's resource limits")
@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_mutated_programs_break_nothing(seed: int) -> None:
    """The child bounds its own memory; every fault is printed with the seed and number that make it again."""
    command = [sys.executable, "-m", "trials.gcode_fuzz", "--minutes", "0.15", "--seed", str(seed)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(done.stdout.split()[0]) > 50
