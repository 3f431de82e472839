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


def rows() -> None:
    """Three intervals of a mesh with their ordinates and places, and a jerk row with its tangent."""
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(8.4, 3.4), layout="constrained", width_ratios=(1.5, 1.0)
    )
    # Pieces of constant jerk, each from where the one before ends: durations, jerks, and v and a at the start.
    duration, jerk, v, a, start = (1.3, 1.15, 0.6), (0.5, 0.95, -1.7), 0.62, -0.55, 0.0
    node, b = [start], [v**2]
    for k, (whole, j) in enumerate(zip(duration, jerk, strict=True)):
        t = np.linspace(0.0, whole, 241)
        s, q = start + (v + (a / 2.0 + j * t / 6.0) * t) * t, (v + (a + j * t / 2.0) * t) ** 2
        h, after = s[-1] - start, a + j * whole
        way = h / 2.0 - (q[-1] ** 0.5 - v) * whole / 12.0
        c = q[0] + 2.0 * a * way
        left.plot(s, q, color="C0", lw=1.6)
        left.plot([start, start + way, s[-1]], [q[0], c, q[-1]], color="0.7", lw=0.7, ls="--")
        left.plot(start + way, c, "x", color="C3", ms=8)
        inner = start + h * np.array([0.25, 0.5, 0.75])
        left.plot(inner, np.interp(inner, s, q), "o", color="C0", mfc="w", ms=5)
        left.plot(start + 0.03 * h, -0.1, ">", color="C2", ms=7)
        left.plot(s[-1] - 0.03 * h, -0.1, "<", color="C2", ms=7)
        if k == 1:
            left.annotate("", (start, 0.62), (start + way, 0.62), arrowprops={"arrowstyle": "<->", "lw": 0.7})
            left.plot([start + way] * 2, [c, 0.68], color="0.7", lw=0.7, ls=":")
            left.annotate("l", (start + way / 2.0, 0.66), ha="center", fontsize=10)
            left.annotate("interval k, length h", (start + h / 2.0, 1.7), ha="center", fontsize=9)
            left.annotate("c", (start + way + 0.03, c - 0.06), fontsize=10)
        start, v, a = s[-1], q[-1] ** 0.5, after
        node.append(start)
        b.append(q[-1])
    left.plot(node, b, "o", color="0.3", ms=5)
    for s in node:
        left.axvline(s, color="0.85", lw=0.7, zorder=0)
    for text, k, side in (("b₀", 1, -0.08), ("b₂", 2, -0.09)):
        left.annotate(text, (node[k] + side, b[k] + 0.07), fontsize=10)
    left.set(ylim=(-0.18, 1.12 * max(b)), xlabel="s", ylabel="q = v²", xticks=[], yticks=[])
    q, here = np.linspace(0.25, 4.0, 200), 1.2
    tangent = here**-0.5 - 0.5 * here**-1.5 * (q - here)
    right.plot(q, q**-0.5, color="C0", lw=1.6, label="limit f J q^-½")
    right.plot(q, tangent, color="C3", lw=1.0, label="its tangent")
    right.fill_between(q, 0.0, np.maximum(tangent, 0.0), color="C3", alpha=0.12, lw=0)
    right.plot(here, here**-0.5, "o", color="0.3", ms=5)
    right.set(ylim=(0.0, 2.0), xlim=(0.25, 4.0), xlabel="q at the end of the interval", xticks=[], yticks=[])
    right.set_ylabel("left-hand side of the jerk row")
    right.legend(fontsize=8)
    figure.savefig(HERE / "least_time_rows.png", dpi=110)


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
    rows()
    predictive()
