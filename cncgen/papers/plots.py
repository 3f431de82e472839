"""The figures that the papers print, redrawn from our own data."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.papers import hsu_1999, jung_choi_2001, plots_tsai_2010, yeh_sun_2008
from cncgen.papers.planned import Planned
from cncgen.papers.reproduction import NAMES
from cncgen.report.drawing import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    bound,
    folder,
    legend,
    line,
    new_figure,
    plane,
    save,
    ticks,
)
from cncgen.servo.controllers.stateline import Rule, interpolate, run_stateline
from cncgen.servo.inversion import held_response, modified_reference, root_mean_square
from cncgen.servo.named_schemes import scheme_maker
from cncgen.servo.profiles import bell, exponential, linear
from cncgen.servo.simulate import simulate_scheme
from cncgen.setpoints.record import Setpoints

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Figures = Iterator[tuple[str, Any]]


def draw_papers(output: str, name: str | None = None, programs: str | None = None) -> list[str]:
    """Draw the figures of one paper, or of all, as PNG into a folder; return the files.

    Raises:
        UsageError: There is no such paper, matplotlib is missing, or the programs are not found.
    """
    if name is not None and name not in NAMES:
        raise UsageError(
            Diagnostic("reproduce-name", f"no paper is called {name!r}; there are {', '.join(NAMES)}")
        )
    target = folder(output)
    files = []
    for paper in [name] if name else NAMES:
        for title, figure in _PAPERS[paper](programs):
            file = target / f"paper_{paper}_{title}.png"
            save(figure, file)
            files.append(str(file))
    return files


def paper_000(programs: str | None) -> Figures:
    """Figs 5 to 7: contours, bounds of the speed command, driving force, with and without limiting."""
    runs = {s: yeh_sun_2008.bonder(s, programs) for s in ("off", "reactive")}
    bounds = {s: yeh_sun_2008.step_bounds(run) for s, run in runs.items()}
    yield "fig5_contours", _bonder_contours(runs)
    figure, grid = new_figure("Paper 000, Fig. 6: bounds of the X speed command (eq. 3.6)", 2, height=2.8)
    for part, (s, b) in zip(grid[:, 0], bounds.items(), strict=True):
        line(part, b.time_s, b.upper, color=RED, label="upper bound")
        line(part, b.time_s, b.lower, color=BLUE, linestyle="--", label="lower bound")
        line(part, b.time_s, b.command, color="black", label="command")
        part.set_ylabel(f"limiting {s}\nspeed (pulse/ms)")
    legend(grid[0, 0], "upper right", ncols=3)
    grid[-1, 0].set_xlabel("time (s)")
    yield "fig6_bounds", figure
    figure, grid = new_figure("Paper 000, Fig. 7: driving force of X", 2, height=2.4)
    for part, (s, b) in zip(grid[:, 0], bounds.items(), strict=True):
        line(part, b.time_s, b.force)
        bound(part, 10.0, "bound of the drive")
        part.set_ylabel(f"limiting {s}\ndriving force (V)")
        part.set_xlim(-0.005, 0.2)
    legend(grid[0, 0], "upper right")
    grid[-1, 0].set_xlabel("time (s); nothing happens later")
    yield "fig7_force", figure


def _bonder_contours(runs: Mapping[str, Planned]) -> Figure:
    """Fig. 5, with the following error below it: the contours, along one axis each, cannot be told apart."""
    figure, grid = new_figure(
        "Paper 000, Fig. 5: contours and following errors (path: programs/bonder.nc)",
        2,
        height=3.0,
        share=False,
    )
    (top,), (low,) = grid
    for (s, run), color, width in zip(runs.items(), (ORANGE, BLUE), (2.4, 0.9), strict=True):
        parts = run.response()
        rows = np.concatenate([r.position for r in parts])
        wanted = np.concatenate([r.command for r in parts])
        error = 1e3 * np.hypot(*(wanted - rows).T)
        top.plot(rows[:, 0], rows[:, 1], linewidth=width, color=color, label=f"limiting {s}")
        line(low, ticks(len(error)), error, color=color, label=f"limiting {s}: at most {error.max():.0f} µm")
    top.set_aspect("equal", adjustable="datalim")
    top.set_xlabel("X (mm)")
    top.set_ylabel("Y (mm)")
    low.set_xlim(-0.005, 0.2)
    low.set_xlabel("time (s)")
    low.set_ylabel("following error (µm)")
    legend(top, "upper left")
    legend(low, "upper right")
    return figure


def paper_001(programs: str | None) -> Figures:
    """The tracking errors behind Table 1, and the causal against the bounded inverse of (s − 8)/(s + 3)."""
    times = ticks(1001)
    figure, grid = new_figure(
        "Paper 001, Figs 3 to 5: tracking error under the modified reference, (s+1)/(s²+2s+3)", 3, height=1.9
    )
    profiles = {"linear": linear(), "exponential": exponential(), "bell": bell()}
    for part, (name, profile) in zip(grid[:, 0], profiles.items(), strict=True):
        above, below = np.array([1.0, 1.0]), np.array([1.0, 2.0, 3.0])
        command = modified_reference(above, below, profile, times)
        error = held_response(above, below, command, 0.001) - profile.value(times)
        rms = 1e3 * root_mean_square(error, 0.001)
        line(part, times, 1e3 * error, label=f"{name} profile, rms {rms:.2f} µm")
        part.set_ylabel("error (µm)")
        legend(part, "upper center")
    grid[-1, 0].set_xlabel("time (s)")
    yield "fig3_to_5_tracking_errors", figure
    long = ticks(2501, first=-1500)
    above, below = np.array([1.0, -8.0]), np.array([1.0, 3.0])
    figure, grid = new_figure("Paper 001: commands for (s−8)/(s+3), linear profile", 2, height=2.6)
    line(
        grid[0, 0],
        times,
        modified_reference(above, below, linear(), times),
        color=ORANGE,
        label="causal command",
    )
    stable = modified_reference(above, below, linear(), long, stable=True)
    line(grid[1, 0], long, stable, label="command with pre-actuation")
    for part in grid[:, 0]:
        line(part, long, linear().value(long), color=GREY, linestyle="--", label="wanted position")
        part.set_ylabel("position (mm)")
        legend(part, "upper left")
    grid[-1, 0].set_xlabel("time (s)")
    yield "inversion", figure


def paper_002(programs: str | None) -> Figures:
    """Figs 3 to 10: a sharp corner under the rules, and the interpolators at a corner and on a circle."""
    yield "fig3_corner", _stateline_corner()
    yield "fig4_corner_errors", _stateline_errors()
    yield "fig5_to_7_interpolators", _interpolators_at_the_corner()
    radius, angle = 20.0, np.arange(40) * 0.08
    circle = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    figure, grid = new_figure(
        "Paper 002, Figs 8 to 10: radial error on a circle of 20 mm at 100 mm/s", 3, height=1.9
    )
    for part, kind in zip(grid[:, 0], (2, 3, 4), strict=True):
        rows = interpolate(circle, jung_choi_2001.PARTS, kind)[320 : 320 + 10 * jung_choi_2001.PARTS]
        line(part, ticks(len(rows), jung_choi_2001.CONTROL), 1e3 * (np.hypot(*rows.T) - radius))
        part.set_ylabel(f"eq. {kind}\nradial error (µm)")
    grid[-1, 0].set_xlabel("time (s): ten periods of the master")
    yield "fig8_to_10_circle", figure


def _interpolators_at_the_corner() -> Figure:
    """Figs 5 to 7: points of the master, the second stage between them, and what the axes make of it."""
    master = jung_choi_2001.corner()
    x = master[:, 0].max()
    figure, grid = new_figure(
        "Paper 002, Figs 5 to 7: interpolators at a corner", 1, 3, height=4.2, width=12.0
    )
    for part, kind in zip(grid[0], (2, 3, 4), strict=True):
        rows = interpolate(master, jung_choi_2001.PARTS, kind)
        actual = run_stateline(rows, jung_choi_2001.AXES, Rule.NONE, 0.05).position
        part.plot(rows[:, 0], rows[:, 1], linewidth=1.0, color=BLUE, label="second stage")
        part.plot(actual[:, 0], actual[:, 1], linewidth=1.0, color=ORANGE, label="axes, no stateline")
        part.plot(master[:, 0], master[:, 1], "ko", markersize=4, fillstyle="none", label="master")
        plane(part, [np.array([[x - 2.0, -0.3], [x + 0.3, 2.0]])], ("X (mm)", "Y (mm)"))
        part.set_title(f"eq. {kind}", fontsize=9)
    legend(grid[0, 0], "upper left")
    return figure


def _stateline_corner() -> Figure:
    """Fig. 3, the paths that a corner leaves; the rules' paths lie on each other, so they differ in width."""
    reference = interpolate(jung_choi_2001.corner(), jung_choi_2001.PARTS, 2)
    figure, ((part,),) = new_figure(
        "Paper 002, Fig. 3: sharp corner under the stateline", height=5.5, width=6.5
    )
    part.plot(reference[:, 0], reference[:, 1], color="black", linewidth=0.6, label="reference")
    looks = {
        Rule.NONE: ("no stateline", RED, 1.2),
        Rule.ERROR: ("eq. 7", ORANGE, 5.0),
        Rule.RULE_2: ("Rule 2", GREEN, 2.8),
        Rule.JERK: ("jerk rule", BLUE, 1.0),
    }
    for rule, (name, color, width) in looks.items():
        run = run_stateline(reference, jung_choi_2001.AXES, rule, 0.05)
        part.plot(run.position[:, 0], run.position[:, 1], linewidth=width, color=color, label=name)
    x = reference[:, 0].max()
    plane(part, [np.array([[x - 1.1, -0.2], [x + 0.2, 1.1]])], ("X (mm)", "Y (mm)"))
    legend(part, "upper left")
    return figure


def _stateline_errors() -> Figure:
    """Fig. 4: following errors of both axes round the corner, under Rule 2 and under the jerk rule."""
    reference = interpolate(jung_choi_2001.corner(), jung_choi_2001.PARTS, 2)
    figure, grid = new_figure("Paper 002, Fig. 4: following errors at the corner", 3, height=1.9)
    for part, (rule, name) in zip(
        grid[:, 0],
        ((Rule.NONE, "no stateline"), (Rule.RULE_2, "Rule 2"), (Rule.JERK, "jerk rule")),
        strict=True,
    ):
        run = run_stateline(reference, jung_choi_2001.AXES, rule, 0.05)
        error = reference[np.minimum(run.place, len(reference) - 1)] - run.position
        times = ticks(len(error), jung_choi_2001.CONTROL)
        line(part, times, error[:, 0], label="X")
        line(part, times, error[:, 1], color=ORANGE, label="Y")
        part.set_ylabel(f"{name}\nerror (mm)")
    legend(grid[0, 0], "center right")
    grid[-1, 0].set_xlabel("time (s)")
    return figure


def paper_004(programs: str | None) -> Figures:
    """Contour errors of the controllers on the circle (Table 1), and the speed of both interpolations (Table 3)."""
    from cncgen.machine import load_servos

    servos = load_servos("dyna-1007")
    rows = hsu_1999.circle(5.0)
    figure, grid = new_figure(
        "Paper 004, Table 1: contour error on a circle of 10 mm at 5 m/min, second turn", 5, height=1.5
    )
    turn = slice(*(int(1000 * t) for t in (0.2 + 0.754, 0.2 + 2 * 0.754)))
    for part, (name, label) in zip(grid[:, 0], hsu_1999.LABELS.items(), strict=True):
        run = list(simulate_scheme([Setpoints("XY", 0.001, 0, rows)], scheme_maker(name, servos)))
        error = 1e3 * np.concatenate([r.contour_error_mm for r in run])[turn]
        line(part, ticks(len(error), first=turn.start), error,
             label=f"{label}: rms {np.sqrt((error**2).mean()):.3g} µm")  # fmt: skip
        part.set_ylim(0.0, 1.45 * error.max())
        part.set_ylabel("error (µm)")
        legend(part, "upper right")
    grid[-1, 0].set_xlabel("time (s)")
    yield "table1_contour", figure
    figure, ((part,),) = new_figure("Paper 004, Table 3: commanded speed on the NURBS circle")
    for label, path, color in (
        ("uniform parameter steps", hsu_1999.uniform_circle(), ORANGE),
        ("constant speed (5 m/min)", rows, BLUE),
    ):
        speed = np.hypot(*np.diff(path, axis=0).T) / 0.001
        line(part, ticks(len(speed)), speed, label=label, color=color)
    part.set_ylabel("speed (mm/s)")
    part.set_xlabel("time (s)")
    part.set_ylim(bottom=0.0)
    legend(part, "lower right")
    yield "table3_speed", figure


_PAPERS: dict[str, Callable[[str | None], Figures]] = {
    "000": paper_000,
    "001": paper_001,
    "002": paper_002,
    "003": plots_tsai_2010.figures,
    "004": paper_004,
}
