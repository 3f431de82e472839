"""Random programs under G64: the judge that shares no code with the planner finds every limit and the tolerance kept."""

from __future__ import annotations

import numpy as np
import pytest

import cncgen
from cncgen.pipeline import judge
from trials import examiner


def polyline(rng: np.random.Generator) -> list[str]:
    """Lines that fold within the tolerance, with rapids between."""
    steps = rng.normal(0, 10 ** rng.uniform(-0.5, 1.3), (rng.integers(3, 20), 2))
    return [f"G{int(rng.random() < 0.8)} X{x:.3f} Y{y:.3f}" for x, y in np.cumsum(steps, axis=0)]


def arcs(rng: np.random.Generator) -> list[str]:
    """Lines and arcs by radius, no two of which join tangentially."""
    rows, here = [], np.zeros(2)
    for place in np.round(np.cumsum(rng.normal(0, 5, (12, 2)), axis=0), 3):
        size = max(float(np.linalg.norm(place - here)) * rng.uniform(0.55, 3), 0.01)
        code = f"G{rng.integers(2, 4)} R{size:.4f}" if rng.random() < 0.5 else "G1"
        rows.append(f"{code} X{place[0]:.3f} Y{place[1]:.3f}")
        here = place
    return rows


def curve(rng: np.random.Generator) -> list[str]:
    """Short lines of a closed curve in space."""
    t, size = np.linspace(0, 2 * np.pi, 200), rng.uniform(1, 20)
    x, y, z = np.sin(2 * t), np.sin(3 * t + 0.5), 0.2 * np.cos(t)
    return [f"G1 X{size * a:.4f} Y{size * b:.4f} Z{size * c:.4f}" for a, b, c in zip(x, y, z, strict=True)]


@pytest.mark.parametrize("rows", [polyline, arcs, curve])
@pytest.mark.parametrize("seed", [52001, 52002])
def test_limits_and_tolerance_are_kept_and_no_plan_is_slower(rows: object, seed: int) -> None:
    rng = np.random.default_rng(seed)
    tolerance = 10 ** rng.uniform(-2.5, -0.8)
    head = f"G21 G90 G17 G64 P{tolerance:.4f} F{rng.integers(500, 14000)}"
    text = "\n".join([head, *rows(rng), "M2", ""])  # type: ignore[operator]
    times = []
    for effort in ("best", "fast"):
        program = cncgen.read_text(text, "random.nc")
        setpoints = cncgen.sample(cncgen.plan(program, "generic-mill", effort=effort)).collect()
        verdict = judge(setpoints, cncgen.read_text(text, "random.nc"), "generic-mill")
        assert verdict.holds, (seed, [fault.message for fault in verdict.breaches])
        times.append(setpoints.time_s[-1])
    assert times[0] <= times[1] + 0.001


def test_nodes_of_a_part_of_tangled_rows_stay() -> None:
    """A hundred rows in one place of a path that is as large as P: nodes for a part of them had no length (an exception of numpy)."""
    assert examiner.examined("relaxing", range(20437, 20438)) == 0
