"""A small program and a sweep of it, in a folder of their own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

#: Two lines at 50 mm/s: a job takes some ms.
PROGRAM = "G21 G17 G90 G61\nF3000\nG1 X10 Y1\nG1 X20 Y5\nM2\n"

SWEEP = """
programs = ["part.nc"]
machine = "xy-table"
[vary]
"axes.*.max_jerk_mm_s3" = { log = [2e4, 2e5], count = 3 }
"axes.x.servo.position_gain_1_s" = { normal = [120, 4], count = 2 }
[draw]
design = "sobol"
points = 8
seed = 1
[keep]
figures = ["cycle_time_s", "contour_error_max_mm", "setpoints_to_path_mm"]
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder with ``part.nc`` and ``sweep.toml``, which is the working directory too."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.nc").write_text(PROGRAM)
    (tmp_path / "sweep.toml").write_text(SWEEP)
    return tmp_path


@pytest.fixture
def with_sweep(folder: Path) -> Callable[[str], Path]:
    """Write another sweep.toml; return its path."""

    def write(text: str) -> Path:
        path = folder / "sweep.toml"
        path.write_text(text)
        return path

    return write
