"""What would shorten a program: derivatives against closed forms and against differences of another step."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cncgen.cli.app import run
from cncgen.machine import Machine, load
from cncgen.pipeline import read, why
from cncgen.planner import PlanOptions
from cncgen.report.shortening import Case, Quantity, planned_times, quantities


def case_of(tmp_path: Path, text: str, machine: Machine) -> Case:
    path = tmp_path / "part.nc"
    path.write_text(text)
    program = read(path)
    return Case(lambda: program.chunks(), machine, PlanOptions())


def test_a_long_line_at_its_feed_in_closed_form(tmp_path: Path) -> None:
    """L/F + F/A + A/J from rest to rest where F is reached, in seven phases (Biagiotti and Melchiorri (2008), 3.4)."""
    machine = load("xy-table")
    axis = machine.axes["X"]
    feed, jerk, acc = 100.0, axis.max_jerk, axis.max_acceleration
    (tmp_path / "a.nc").write_text("G21 G90 G61 F6000\nG1 X200\nM2\n")
    now, found = why(tmp_path / "a.nc", machine)
    worth = {each.name: each for each in found}
    # The feed is reached without full acceleration where F < A²/J: then the ramps take 2 √(F/J).
    assert feed < acc**2 / jerk
    assert now.cycle_s == pytest.approx(200 / feed + 2 * (feed / jerk) ** 0.5, abs=2e-3)
    by_feed = 0.1 * (200 / feed - (feed / jerk) ** 0.5)
    by_jerk = 0.1 * (feed / jerk) ** 0.5
    assert worth["feed"].derivative_s == pytest.approx(by_feed, rel=1e-3)
    assert worth["X jerk"].derivative_s == pytest.approx(by_jerk, rel=1e-3)
    saved = 2 * (feed / jerk) ** 0.5 * (1 - 1.1**-0.5)
    assert worth["X jerk"].saved_s == pytest.approx(saved, rel=1e-2)
    assert [each.name for each in found[:2]] == ["feed", "X jerk"]
    assert worth["X velocity"].saved_s == pytest.approx(0.0, abs=1e-6)


def program(seed: int) -> str:
    """Return a pocket-like program: lines and tangent arcs of random sizes, rapids between two passes."""
    rng = np.random.default_rng(seed)
    rows = [f"G21 G90 G17 G64 P0.02 F{rng.integers(1500, 9000)}", "G0 X5 Y5"]
    for _ in range(2):
        w, h, r = rng.uniform(10, 40), rng.uniform(10, 30), rng.uniform(1, 4)
        rows += [f"G1 X{5 + w:.3f}", f"G3 X{5 + w + r:.3f} Y{5 + r:.3f} J{r:.3f} I0", f"G1 Y{5 + r + h:.3f}"]
        rows += [f"G1 X{rng.uniform(0, 10):.3f} Y{rng.uniform(20, 30):.3f}", "G0 X5 Y5"]
    return "\n".join([*rows, "M2", ""])


def agrees(case: Case, quantity: Quantity, largest: float) -> tuple[float, float]:
    """Return the derivative with the step of `why`, and with half of it."""
    slopes = []
    for step in (0.02, 0.01):
        times = [planned_times(quantity.scaled(case, 1 + sign * step)) for sign in (1, -1)]
        parts = [t.parts[quantity.part] if quantity.part else t.cycle_s for t in times]
        slopes.append((parts[0] - parts[1]) / (2 * step))
    return slopes[0], slopes[1]


@pytest.mark.parametrize("seed", [11, 12])
def test_derivatives_agree_with_differences_of_half_the_step(tmp_path: Path, seed: int) -> None:
    # Along the path: path and speed together are found to about 1e-4 of the time, a tenth of a difference of 1 % in X jerk.
    case = replace(case_of(tmp_path, program(seed), load("xy-table")), options=PlanOptions(effort="fast"))
    pairs = {q.name: agrees(case, q, 0.0) for q in quantities(case, "XY")}
    largest = max(abs(b) for _, b in pairs.values())
    for name, (a, b) in pairs.items():
        assert abs(a - b) <= 0.02 * max(abs(b), 0.05 * largest), name


def test_times_of_the_machine_are_exact(tmp_path: Path) -> None:
    table = {"tool_change_s": 4.0, "spindle_acceleration_rpm_s": 6000.0, "pockets": 20}
    machine = replace(load("xy-table"), settings={"times": table})
    (tmp_path / "a.nc").write_text("G21 G90 F3000\nT1 M6\nS6000 M3\nG1 X10\nT2 M6\nX0\nM2\n")
    now, found = why(tmp_path / "a.nc", machine)
    worth = {each.name: each for each in found}
    assert worth["times.tool_change_s"].saved_s == pytest.approx(0.8, abs=1e-9)
    assert "times.pockets" not in worth
    # Up once, and down before the second change: (1 s + 1 s) (1 - 1/1.1).
    assert worth["times.spindle_acceleration_rpm_s"].saved_s == pytest.approx(2 - 2 / 1.1, abs=1e-9)
    assert sum(now.tools.values()) == pytest.approx(now.cycle_s, abs=1e-9)
    assert {*now.tools} == {"–", "1", "2"}
    assert worth["times.tool_change_s"].lines[0][2] == pytest.approx(0.4, abs=1e-9)


def test_the_command_ranks_and_writes_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.nc").write_text("G21 G90 F3000\nG1 X10\nM2\n")
    assert run(["why", str(tmp_path / "a.nc"), "-m", "xy-table", "--summary", str(tmp_path / "s.json")]) == 0
    assert capsys.readouterr().out.splitlines()[3].startswith("| feed")
    values = json.loads((tmp_path / "s.json").read_text())
    saved = [each["saved_s"] for each in values["quantities"]]
    assert saved == sorted(saved, reverse=True)
    assert {"name", "value", "change", "derivative_s", "saved_s", "lines", "tools"} == set(
        values["quantities"][0]
    )
