"""The figures of paper 003 and of the paper appended to it, redrawn from our own data."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from cncgen.machine import load_servos
from cncgen.machine.servo_schema import resolve
from cncgen.papers import tsai_2010
from cncgen.planner import PlanOptions
from cncgen.planner.contour_prediction import predicted_errors
from cncgen.report.drawing import BLUE, GREY, ORANGE, RED, legend, line, new_figure, plane, ticks
from cncgen.servo.controllers.hinf_servo import check, controller_of
from cncgen.servo.models import control_period

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Figures = Iterator[tuple[str, Any]]


def figures(programs: str | None) -> Figures:
    """Figs 1, 3, 6, 7 and 10 to 14: corners, curvature, estimate, feed and errors; and the appended paper's stage."""
    yield "fig1_trident", _trident(programs)
    yield "fig3_estimate", _estimate(programs)
    yield "fig6_curvature", _curvature(programs)
    figure, ((part,),) = new_figure("Paper 003, Figs 5 and 6: sharp corners of the butterfly", height=5.4)
    styles = ((7000.0, "o", 10, BLUE), (5000.0, "s", 7, ORANGE), (3500.0, "x", 5, "black"))
    for feed, mark, size, color in styles:
        planned = tsai_2010.plan_of("butterfly.nc", programs, feed, "ild")
        if feed == 7000.0:
            rows = planned.signal("position")
            part.plot(rows[:, 0], rows[:, 1], color=GREY, linewidth=0.8)
            plane(part, [rows], ("X (mm)", "Y (mm)"))
        places = np.array([c.position[:2] for t in planned.trajectories for c in t.corners])
        part.plot(places[:, 0], places[:, 1], mark, markersize=size, fillstyle="none", linestyle="none",
                  color=color, label=f"{feed:g} mm/min: {len(places)} corners")  # fmt: skip
    figure.legend(loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    yield "fig6_corners", figure
    for curve, number in (("trident", "10 and 12"), ("butterfly", "13 and 14")):
        yield (
            f"{curve}_errors",
            _strategies(curve, f"Paper 003, Figs {number}: {curve} at 7000 mm/min", programs),
        )
    yield "stage_bounds", _stage_bounds()
    yield "stage_step", _stage_step()


def _strategies(curve: str, title: str, programs: str | None) -> Figure:
    """Feed above contour error, a column a strategy; the errors' scales differ by thirty times."""
    figure, grid = new_figure(title, 2, 3, height=2.6, width=12.0, share="col")
    for k, feedrate in enumerate(("adaptive", "curvature", "ild")):
        planned = tsai_2010.plan_of(f"{curve}.nc", programs, 7000.0, feedrate)
        speed, error = planned.signal("feed"), 1e3 * tsai_2010.true_errors(planned)
        line(grid[0, k], ticks(len(speed)), speed)
        line(grid[1, k], ticks(len(error)), error, color=RED)
        grid[1, k].set_title(f"at most {error.max():.3g} µm", fontsize=9)
        grid[0, k].set_title(f"{feedrate}: {planned.time_s:.3f} s", fontsize=9)
        grid[1, k].set_ylim(bottom=0.0)
        grid[1, k].set_xlabel("time (s)")
    grid[0, 0].set_ylabel("feed (mm/s)")
    grid[1, 0].set_ylabel("contour error (µm)")
    return figure


def _trident(programs: str | None) -> Figure:
    """Fig. 1: the curve with its sharp corners."""
    figure, ((part,),) = new_figure("Paper 003, Fig. 1: sharp corners of the trident (our curve)", height=5.0)
    planned = tsai_2010.plan_of("trident.nc", programs, 7000.0, "ild")
    rows = planned.signal("position")
    part.plot(rows[:, 0], rows[:, 1], color=GREY, linewidth=0.9)
    for name, corner in zip("ABCDE", (c for t in planned.trajectories for c in t.corners), strict=False):
        part.plot(*corner.position[:2], "o", color=RED, markersize=6, fillstyle="none")
        part.annotate(name, corner.position[:2], xytext=(6, 4), textcoords="offset points")
    plane(part, [rows], ("X (mm)", "Y (mm)"))
    return figure


def _estimate(programs: str | None) -> Figure:
    """Fig. 3: contour error round the second corner of the trident, estimated and true."""
    planned = tsai_2010.plan_of("trident.nc", programs, 3500.0, "curvature")
    actual = 1e3 * tsai_2010.true_errors(planned)
    found = predicted_errors(planned.trajectories, planned.machine, PlanOptions())
    estimate = 1e3 * np.abs(np.zeros(0) if found is None else found)
    count = min(len(actual), len(estimate))
    at = int(actual[:count].argmax())
    shown = slice(max(0, at - 150), min(count, at + 150))
    figure, grid = new_figure(
        "Paper 003, Fig. 3: contour error at a tip of the trident, 3500 mm/min", 2, height=2.4
    )
    times = ticks(count)[shown]
    line(grid[0, 0], times, actual[shown], color=GREY, linewidth=2.4, label="true")
    line(grid[0, 0], times, estimate[shown], label="estimated (eqs 15 to 18)")
    line(grid[1, 0], times, estimate[shown] - actual[shown], color=RED)
    grid[0, 0].set_ylabel("contour error (µm)")
    grid[1, 0].set_ylabel("estimated - true (µm)")
    grid[1, 0].set_xlabel("time (s)")
    legend(grid[0, 0], "upper right")
    return figure


def _curvature(programs: str | None) -> Figure:
    """Fig. 6: curvature along the butterfly, with the threshold A_max/V² of each feed."""
    planned = tsai_2010.plan_of("butterfly.nc", programs, 3500.0, "ild")
    rows = planned.signal("position")
    a, b = rows[1:-1] - rows[:-2], rows[2:] - rows[1:-1]
    la, lb = np.hypot(*a.T), np.hypot(*b.T)
    moved = (la > 1e-5) & (lb > 1e-5)
    turn = np.abs(np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1)))
    bend = 2.0 * turn[moved] / (la + lb)[moved]
    figure, ((part,),) = new_figure(
        "Paper 003, Fig. 6: curvature of the butterfly and thresholds of a sharp corner"
    )
    line(part, np.cumsum(la)[moved], np.maximum(bend, 1e-4), label="curvature")
    limit = planned.machine.axes["X"].max_acceleration
    for feed, color in zip(tsai_2010.FEEDS, (RED, ORANGE, GREY), strict=True):
        threshold = limit / (feed / 60.0) ** 2
        part.axhline(
            threshold,
            color=color,
            linestyle="--",
            linewidth=0.9,
            label=f"A/V² at {feed:g} mm/min: {threshold:.3g}/mm",
        )
    part.set_yscale("log")
    part.set_ylabel("curvature (1/mm)")
    part.set_xlabel("length (mm)")
    figure.legend(loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    return figure


def _stage_bounds() -> Figure:
    """The appended paper's bounds on the sampled loops of its stage, the worst of all payloads."""
    figure, grid = new_figure("Appended to paper 003: bounds on the flexure stage under H-infinity control", 1, 2,
                              height=3.6, width=11.0)  # fmt: skip
    for letter, color in (("X", BLUE), ("Y", ORANGE)):
        servo = load_servos(tsai_2010.STAGE)[letter]
        values = resolve(servo, letter)
        period = control_period(servo, letter, 0.001)
        found = check(values, controller_of(values, period), period)
        hertz = found.frequency / (2.0 * math.pi)
        for part, worst, allowed, name in (
            (grid[0, 0], found.sensitivity, found.allowed, "S"),
            (grid[0, 1], found.complementary, np.full(len(hertz), found.peak), "T"),
        ):
            line(
                part,
                hertz,
                20 * np.log10(np.maximum(worst, 1e-6)),
                color=color,
                label=f"{letter}, worst of {found.plants} plants",
            )
            if letter == "X":
                line(part, hertz, 20 * np.log10(allowed), color=RED, linestyle="--", label="bound")
            part.set_xscale("log")
            part.set_ylim(-60, 12)
            part.set_xlabel("frequency (Hz)")
            part.set_ylabel(f"|{name}| (dB)")
    legend(grid[0, 0], "lower right")
    legend(grid[0, 1], "lower left")
    return figure


def _stage_step() -> Figure:
    """The step of 20 µm, for every payload."""
    figure, grid = new_figure("Appended to paper 003: step of 20 µm, nine payloads", 2, height=2.4)
    for part, letter in zip(grid[:, 0], "XY", strict=True):
        for rows in tsai_2010.stage_steps(letter):
            line(part, ticks(len(rows), 0.0005)[:600], rows[:600], linewidth=0.6)
        part.axhline(20.0, color=GREY, linewidth=0.8, linestyle="--")
        part.set_ylabel(f"{letter} (µm)")
    grid[-1, 0].set_xlabel("time (s)")
    return figure
