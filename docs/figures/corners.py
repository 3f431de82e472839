"""The figure of docs/corners.md, from our own plans.

python docs/figures/corners.py
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import matplotlib as mpl
import numpy as np

import cncgen
from cncgen.machine import Machine, load

mpl.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent


def passed() -> None:
    """A corner of 0.1 rad at 4 ms, under G61: setpoints beside it, and third differences of each axis by the limit."""
    machine = _machine(period_s=0.004, chord_um=10.0)
    turn = 0.05
    end = 20.0 * np.array([1.0 + np.cos(turn), np.sin(turn)])
    program = f"G61 G1 X20 Y0 F6000\nX{end[0]:.6f} Y{end[1]:.6f}\nM2\n"
    setpoints = cncgen.sample(cncgen.plan(cncgen.read_text(program), machine)).collect()
    x, t = setpoints.position, setpoints.time_s
    jerk = np.diff(np.vstack([np.repeat(x[:1], 3, axis=0), x]), 3, axis=0) / machine.period_s**3 / 50_000.0
    near = np.flatnonzero(np.abs(x[:, 0] - 20.0) < 0.9)
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.2), layout="constrained")
    left.plot([19.0, 20.0, 21.0], [0.0, 0.0, np.tan(turn)], color="0.7", lw=1.0, label="programmed")
    left.plot(x[near, 0], x[near, 1], "o-", ms=3.0, lw=0.8, label="setpoints and their chords")
    left.set(xlabel="x, mm", ylabel="y, mm")
    left.legend(fontsize=8)
    right.step(t, jerk, where="mid", lw=0.9, label=("x", "y"))
    right.axhline(1.0, color="0.6", lw=0.6)
    right.axhline(-1.0, color="0.6", lw=0.6)
    middle = float(t[near].mean())
    right.set(
        xlim=(middle - 0.12, middle + 0.12), xlabel="t, s", ylabel="third difference, by the jerk limit"
    )
    right.legend(fontsize=8)
    figure.savefig(HERE / "corners.png", dpi=110)


def _machine(period_s: float, chord_um: float) -> Machine:
    """Return an X Y machine of 100 mm/s, 1000 mm/s² and 50,000 mm/s³."""
    table = load("xy-table")
    axes = {
        k: replace(axis, max_velocity=100.0, max_acceleration=1000.0, max_jerk=50_000.0)
        for k, axis in table.axes.items()
    }
    return replace(table, period_s=period_s, chord_tolerance_mm=1e-3 * chord_um, axes=MappingProxyType(axes))


if __name__ == "__main__":
    passed()
