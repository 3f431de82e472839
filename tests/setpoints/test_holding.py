"""A plan that promises limits and breaks one is refused before its setpoints are written."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cncgen.cli.app import run
from cncgen.diagnostics import NoPlanError
from cncgen.machine import load
from cncgen.setpoints.holding import held
from cncgen.setpoints.record import Setpoints

#: A middle weight of 2e8: its curve has a bend far smaller than a setpoint's rounding.
EXTREME = "G21 G90 G17 G64\nG6.2 P3 K0 X0 Y0 R1 F1000\nK0 X1 Y1 R{weight}\nK0 X2 Y0 R1\nK1\nK1\nK1\nM2\n"


def chunks(position: np.ndarray, size: int = 7) -> Iterator[Setpoints]:
    for first in range(0, len(position), size):
        yield Setpoints("X", 0.001, first, position[first : first + size, None])


def smooth(jerk: float, rows: int = 41) -> np.ndarray:
    """Return setpoints whose third differences are ± `jerk` and that end at rest: +1 −2 +1 in thirds of 1, 2 and 1."""
    steps = np.concatenate([[0.0] * 4, [jerk] * 8, [-jerk] * 16, [jerk] * 8, [0.0] * 5]) * 1e-9
    return np.cumsum(np.cumsum(np.cumsum(steps)))[:rows]


def test_setpoints_at_the_limit_pass_as_they_are() -> None:
    machine = load("xy-table")
    position = smooth(machine.axes["X"].max_jerk)
    passed = list(held(chunks(position), machine))
    np.testing.assert_array_equal(np.concatenate([c.position[:, 0] for c in passed]), position)


def test_one_over_the_limit_is_refused_before_its_chunk(tmp_path: Path) -> None:
    machine = load("xy-table")
    position = smooth(machine.axes["X"].max_jerk)
    position[20:] += 3e-6
    stream = held(chunks(position), machine)
    # The step shows at row 21, where it adds 9000 mm/s³ to a jerk that is at its limit.
    assert [next(stream).first for _ in range(3)] == [0, 7, 14]
    with pytest.raises(NoPlanError, match=r"jerk of X would be .* mm/s³, 1\.\d+ times its limit"):
        next(stream)


def test_an_end_that_does_not_rest_is_refused() -> None:
    machine = load("xy-table")
    stream = held(chunks(0.2 * np.arange(5) ** 2 * 1e-3), replace(machine))
    with pytest.raises(NoPlanError, match=r"acceleration of X|jerk of X"):
        list(stream)


@pytest.mark.parametrize("weight", ["200000000"])
def test_a_curve_of_extreme_weights_holds_or_is_refused(tmp_path: Path, weight: str) -> None:
    (tmp_path / "a.nc").write_text(EXTREME.format(weight=weight))
    out = tmp_path / "a.csv"
    code = run(["plan", str(tmp_path / "a.nc"), "-m", "xy-table", "-o", str(out), "-q"])
    assert code in (0, 1, 3)
    assert out.exists() == (code == 0)
    if code == 0:
        assert run(["verify", str(out), "--program", str(tmp_path / "a.nc"), "-m", "xy-table", "-q"]) == 0
