"""Figures of docs/least-time.md and of predictive saturation in docs/saturation.md, from our own plans.

python docs/figures/least_time.py
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import matplotlib as mpl
import numpy as np

import cncgen
from cncgen.machine import Machine, load
from cncgen.planner import PlanOptions, plan
from cncgen.planner.motion import motion_at
from cncgen.servo import simulate
from cncgen.setpoints import sample

mpl.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
PROGRAMS = HERE.parents[1] / "programs"


def least_time() -> None:
    """The butterfly: speed along the path, and the axes' accelerations and jerks by their limits."""
    table = replace(load("xy-table"), max_contour_error_mm=None)
    limits = table.axes["X"]
    (done,) = (
        t
        for t in plan(cncgen.read(PROGRAMS / "butterfly.nc").chunks(), table)
        if t.profile.t[-1] > t.profile.t[0]
    )
    t = np.linspace(0.0, float(done.profile.t[-1]), 12_000)
    at = motion_at(done.profile, t)
    x = done.toolpath.path.evaluate(at.s, 3)[:, :, :2]
    v, a, j = at.v[:, None], at.a[:, None], at.j[:, None]
    acceleration = np.abs(x[2] * v**2 + x[1] * a).max(axis=1) / limits.max_acceleration
    jerk = np.abs(x[3] * v**3 + 3.0 * x[2] * v * a + x[1] * j).max(axis=1) / limits.max_jerk
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(8.0, 4.6), sharex=True, layout="constrained")
    top.plot(t, at.v, lw=0.9)
    top.set_ylabel("v, mm/s")
    bottom.plot(t, jerk, lw=0.6, label="jerk")
    bottom.plot(t, acceleration, lw=0.9, label="acceleration")
    bottom.axhline(1.0, color="0.6", lw=0.6)
    bottom.set_ylabel("of the limit, worse axis")
    bottom.set_xlabel("t, s")
    bottom.legend(loc="lower right", fontsize=8)
    figure.savefig(HERE / "least_time.png", dpi=110)


def predictive() -> None:
    """Force and following error on the die bonder, 0.25 µm a count and limits beyond the drives."""
    bonder = _fine(load("die-bonder"))
    chunks = list(cncgen.read(PROGRAMS / "bonder.nc").chunks())
    chunks = [replace(c, feed=np.where(np.isnan(c.feed), np.nan, 400.0)) for c in chunks]
    servos = {k: axis.servo for k, axis in bonder.axes.items() if axis.servo is not None}
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(8.0, 4.6), sharex=True, layout="constrained")
    for mode in ("off", "reactive", "predictive"):
        done = list(plan(chunks, bonder, PlanOptions(saturation=mode)))
        parts = list(simulate(sample(iter(done), bonder, axes="XY"), servos, settle_s=0.02))
        t = bonder.period_s * np.arange(sum(len(p.force) for p in parts))
        top.plot(t, np.concatenate([p.force for p in parts])[:, 0], lw=0.8, label=mode)
        error = np.concatenate([p.command - p.position for p in parts])
        bottom.plot(t, 1e3 * np.abs(error).max(axis=1), lw=0.8)
    top.set_ylabel("force of X, V")
    top.legend(loc="upper right", fontsize=8)
    bottom.axhline(100.0, color="0.6", lw=0.6)
    bottom.set_yscale("log")
    bottom.set_ylim(0.1, 1e4)
    bottom.set_ylabel("following error, µm")
    bottom.set_xlabel("t, s")
    figure.savefig(HERE / "saturation_predictive.png", dpi=110)


def _fine(machine: Machine) -> Machine:
    axes = {
        k: replace(
            axis,
            max_acceleration=1e6,
            max_jerk=1e9,
            servo=replace(axis.servo, parameters={**axis.servo.parameters, "counts_per_mm": 4000.0})
            if axis.servo
            else None,
        )
        for k, axis in machine.axes.items()
    }
    return replace(machine, axes=MappingProxyType(axes))


if __name__ == "__main__":
    least_time()
    predictive()
