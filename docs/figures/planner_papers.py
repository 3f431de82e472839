"""Draw the figures of docs/ild.md, docs/interpolators.md and docs/saturation.md from our own plans.

Run from the top of a checkout: ``python docs/figures/planner_papers.py`` (needs the extra ``cncgen[plot]``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cncgen import pipeline
from cncgen.machine import Machine, load
from cncgen.planner import PlanOptions, Trajectory, plan
from cncgen.planner.interpolators import STEPPERS, retime_one
from cncgen.planner.motion import motion_at, time_at
from cncgen.planner.saturation import Limiter, pd_plus_axes
from cncgen.servo import simulate
from cncgen.setpoints import sample
from cncgen.toolpath.record import Toolpath

HERE = Path(__file__).parent
PROGRAMS = HERE.parents[1] / "programs"
T = 1e-3


def main() -> None:
    """Draw all three."""
    table = load("xy-table")
    draw_ild(table, replace(table, max_contour_error_mm=None))
    draw_interpolators(replace(table, max_contour_error_mm=None))
    draw_saturation(load("die-bonder"))


def chunks_of(name: str) -> list[Toolpath]:
    """Read a program."""
    return list(pipeline.read(PROGRAMS / name).chunks())


def saved(figure: Figure, name: str) -> None:
    """Write a figure as PNG."""
    FigureCanvasAgg(figure)
    figure.tight_layout()
    figure.savefig(HERE / f"{name}.png", dpi=80)


def contour_errors(trajectories: list[Trajectory], machine: Machine) -> np.ndarray:
    """Return the contour errors of the simulated axes, µm."""
    servos = {k: axis.servo for k, axis in machine.axes.items() if axis.servo is not None}
    parts = simulate(sample(trajectories, machine, axes="XY"), servos)
    return 1e3 * np.concatenate([r.contour_error_mm for r in parts])


def draw_ild(table: Machine, free: Machine) -> None:
    """Path with corners; feed along the path with and without the dynamics module; contour error over time."""
    chunks = chunks_of("butterfly.nc")
    figure = Figure(figsize=(9, 7))
    path, feed, error = figure.add_subplot(2, 2, 1), figure.add_subplot(2, 2, 2), figure.add_subplot(2, 1, 2)
    runs = (("ild, no bound", free, "ild"), ("ild, 10 µm", table, "ild"), ("curvature", free, "curvature"))
    for label, machine, name in runs:
        trajectories = list(plan(chunks, machine, PlanOptions(feedrate=name)))
        motion = motion_at(trajectories[0].profile, np.arange(0.0, trajectories[0].profile.t[-1], T))
        if name == "ild":
            feed.plot(motion.s, motion.v * 0.06, lw=0.8, label=label)
        errors = contour_errors(trajectories, machine)
        error.semilogy(np.arange(len(errors)) * T, np.maximum(errors, 1e-2), lw=0.7, label=label)
        if label == "ild, no bound":
            x = np.concatenate([c.position for c in sample(trajectories, machine, axes="XY")])
            path.plot(*x.T, "k-", lw=0.8)
            path.plot(*np.array([c.position[:2] for c in trajectories[0].corners]).T, "r.", ms=6)
    path.set(aspect="equal", title="24 sharp corners at 7000 mm/min", xlabel="X, mm", ylabel="Y, mm")
    feed.set(xlabel="path, mm", ylabel="feed, m/min", title="feed along the path")
    error.set(xlabel="time, s", ylabel="contour error, µm", title="contour error of the simulated table")
    error.axhline(10.0, color="k", lw=0.6, ls="--")
    feed.legend(fontsize=7)
    error.legend(fontsize=7)
    saved(figure, "ild")


def fluctuations(planned: Trajectory) -> Iterator[tuple[str, np.ndarray]]:
    """Yield each interpolator's travelled / commanded − 1 a period, in per cent."""
    for name in ("taylor1", "taylor2"):
        moved = retime_one(planned, STEPPERS[name], T, 0.0).profile
        s = motion_at(moved, np.arange(0.0, moved.t[-1], T)).s
        then = time_at(planned.profile, s[:-1]) + T
        whole = then < planned.profile.t[-1]
        aim = motion_at(planned.profile, then[whole]).s
        yield name, 100.0 * (np.diff(s)[whole] / (aim - s[:-1][whole]) - 1.0)


def draw_interpolators(machine: Machine) -> None:
    """Feed fluctuation of the Taylor interpolators over time, on the plan of `ild` and at constant feed."""
    figure = Figure(figsize=(9, 4))
    for i, feedrate in enumerate(("ild", "constant")):
        axes = figure.add_subplot(1, 2, i + 1)
        (planned, *_) = plan(chunks_of("butterfly.nc"), machine, PlanOptions(feedrate=feedrate))
        for name, error in fluctuations(planned):
            axes.semilogy(np.arange(len(error)) * T, np.maximum(np.abs(error), 1e-6), lw=0.5, label=name)
        axes.axhline(1e-4, color="k", lw=0.6, ls="--", label="bound for arclength")
        axes.set(
            xlabel="time, s", title=f"{feedrate}, 7000 mm/min", ylabel="|fluctuation|, %", ylim=(1e-6, 200)
        )
        axes.legend(fontsize=7)
    saved(figure, "interpolators")


def draw_saturation(machine: Machine) -> None:
    """Commanded speed of X with the bounds of eq. 3.6, and its force with and without limiting (Figs 6 and 7)."""
    options = PlanOptions(feedrate="constant", interpolator="uniform")
    trajectories = list(plan(chunks_of("bonder.nc"), machine, options))
    axes = pd_plus_axes(machine, options)
    limited = Limiter(axes, machine.period_s, keep_forces=True)
    free = Limiter({k: replace(a, bound=1e9) for k, a in axes.items()}, machine.period_s, keep_forces=True)
    figure = Figure(figsize=(9, 6))
    top, bottom = figure.add_subplot(2, 1, 1), figure.add_subplot(2, 1, 2)
    for limiter, label in ((free, "off"), (limited, "reactive")):
        limiter.advance(trajectories)
        forces = np.concatenate(limiter.forces)[:, 0]
        t = np.arange(1, len(forces) + 1)
        bottom.plot(t[:80], forces[:80, 3], lw=0.9, label=label)
        if limiter is limited:
            pulses = forces * 1.5915494
            top.plot(t[:80], pulses[:80, 2], "k-", lw=1.0, label="commanded speed")
            top.plot(t[:80], pulses[:80, :2], "r--", lw=0.7, label=["bounds of eq. 3.6", None])
    top.set(
        xlabel="time, ms",
        ylabel="X, pulse/ms",
        ylim=(-200, 900),
        title="bonder.nc, F6000, uniform, reactive",
    )
    bottom.set(
        xlabel="time, ms",
        ylabel="force asked of X, V",
        title="voltage that the PD+ law asks of a drive of ±10 V",
    )
    for v in (-10.0, 10.0):
        bottom.axhline(v, color="k", lw=0.6, ls="--")
    top.legend(fontsize=7)
    bottom.legend(fontsize=7)
    saved(figure, "saturation")


if __name__ == "__main__":
    main()
