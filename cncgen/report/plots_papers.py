"""The figures that the papers print, redrawn from our own data."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.report import reproduce_000, reproduce_002, reproduce_003, reproduce_004
from cncgen.report.plots import bound, line, new_figure, save
from cncgen.report.reproduction import NAMES
from cncgen.servo.controllers.stateline import Rule, interpolate, run_stateline
from cncgen.servo.inversion import held_response, modified_reference
from cncgen.servo.named_schemes import scheme_maker
from cncgen.servo.profiles import bell, exponential, linear
from cncgen.servo.simulate import simulate_scheme
from cncgen.setpoints.record import Setpoints

Figures = Iterator[tuple[str, Any]]


def draw_papers(folder: str, name: str | None = None, programs: str | None = None) -> list[str]:
    """Draw the figures of one paper, or of all, as PNG into a folder; return the files.

    Raises:
        UsageError: There is no such paper, matplotlib is missing, or the programs are not found.
    """
    if name is not None and name not in NAMES:
        raise UsageError(
            Diagnostic("reproduce-name", f"no paper is called {name!r}; there are {', '.join(NAMES)}")
        )
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    files = []
    for paper in [name] if name else NAMES:
        for title, figure in _PAPERS[paper](programs):
            file = target / f"paper_{paper}_{title}.png"
            save(figure, file)
            files.append(str(file))
    return files


def paper_000(programs: str | None) -> Figures:
    """Figs 5 to 7: contours, bounds of the speed command, driving force, with and without limiting."""
    runs = {s: reproduce_000.bonder(s, programs) for s in ("off", "reactive")}
    bounds = {s: reproduce_000.step_bounds(run) for s, run in runs.items()}
    figure, (part,) = new_figure("Paper 000, Fig. 5: contours (path: programs/bonder.nc)", height=4.5)
    for s, run in runs.items():
        rows = np.concatenate([r.position for r in run.response()])
        part.plot(rows[:, 0], rows[:, 1], linewidth=0.9, label=f"limiting {s}")
    part.set_xlabel("X (mm)")
    part.set_ylabel("Y (mm)")
    part.legend(fontsize=8)
    yield "fig5_contours", figure
    figure, parts = new_figure(
        "Paper 000, Fig. 6: bounds of the X speed command, eq. 3.6", rows=2, height=2.8
    )
    for part, s in zip(parts, ("off", "reactive"), strict=True):
        b = bounds[s]
        line(part, b.time_s, b.upper, color="crimson", label="upper bound")
        line(part, b.time_s, b.lower, color="tab:blue", linestyle="--", label="lower bound")
        line(part, b.time_s, b.command, color="0.2", label="command")
        part.set_ylabel(f"limiting {s}\n(pulse/ms)", fontsize=8)
        part.legend(fontsize=7, loc="upper right")
    parts[-1].set_xlabel("time (s)")
    yield "fig6_bounds", figure
    figure, parts = new_figure("Paper 000, Fig. 7: driving force of X", rows=2, height=2.4)
    for part, s in zip(parts, ("off", "reactive"), strict=True):
        line(part, bounds[s].time_s, bounds[s].force)
        bound(part, 10.0)
        part.set_ylabel(f"limiting {s} (V)", fontsize=8)
    parts[-1].set_xlabel("time (s)")
    yield "fig7_force", figure


def paper_001(programs: str | None) -> Figures:
    """The tracking errors behind Table 1, and the causal against the bounded inverse of (s − 8)/(s + 3)."""
    times = _ticks(1001)
    figure, parts = new_figure(
        "Paper 001: tracking error under the modified reference, (s+1)/(s²+2s+3)", rows=3, height=2.0
    )
    profiles = {"linear": linear(), "exponential": exponential(), "bell": bell()}
    for part, (name, profile) in zip(parts, profiles.items(), strict=True):
        above, below = np.array([1.0, 1.0]), np.array([1.0, 2.0, 3.0])
        command = modified_reference(above, below, profile, times)
        error = held_response(above, below, command, 0.001) - profile.value(times)
        line(part, times, 1e3 * error)
        part.set_ylabel(f"{name} (µm)", fontsize=8)
    parts[-1].set_xlabel("time (s)")
    yield "tracking_errors", figure
    long = _ticks(2501, first=-1500)
    above, below = np.array([1.0, -8.0]), np.array([1.0, 3.0])
    figure, parts = new_figure("Paper 001: (s−8)/(s+3), linear profile", rows=2, height=2.6)
    line(parts[0], times, modified_reference(above, below, linear(), times))
    parts[0].set_ylabel("causal command (mm)", fontsize=8)
    line(
        parts[1],
        long,
        modified_reference(above, below, linear(), long, stable=True),
        label="command with pre-actuation",
    )
    line(parts[1], long, linear().value(long), color="0.4", linestyle="--", label="wanted")
    parts[1].set_ylabel("bounded command (mm)", fontsize=8)
    parts[1].legend(fontsize=8)
    parts[1].set_xlabel("time (s)")
    yield "inversion", figure


def paper_002(programs: str | None) -> Figures:
    """Figs 3 to 10: a sharp corner under the rules, and the interpolators at a corner and on a circle."""
    master = reproduce_002.corner()
    figure, (part,) = new_figure("Paper 002, Fig. 3: sharp corner under the stateline", height=5.5, width=6.5)
    reference = interpolate(master, reproduce_002.PARTS, 2)
    part.plot(reference[:, 0], reference[:, 1], color="0.4", linewidth=0.8, label="reference")
    for rule in Rule:
        run = run_stateline(reference, reproduce_002.AXES, rule, 0.05)
        part.plot(
            run.position[:, 0], run.position[:, 1], linewidth=0.9, label=rule.name.lower().replace("_", " ")
        )
    x = master[:, 0].max()
    part.set_xlim(x - 1.5, x + 0.5)
    part.set_ylim(-0.5, 1.5)
    part.legend(fontsize=8)
    part.set_xlabel("X (mm)")
    part.set_ylabel("Y (mm)")
    yield "fig3_corner", figure
    figure, (part,) = new_figure("Paper 002, Figs 5 to 7: interpolators at the corner", height=5.5, width=6.5)
    part.plot(master[:, 0], master[:, 1], "ko", markersize=4, fillstyle="none", label="master")
    for kind in (2, 3, 4):
        rows = interpolate(master, reproduce_002.PARTS, kind)
        part.plot(rows[:, 0], rows[:, 1], linewidth=0.9, label=f"eq. {kind}")
    part.set_xlim(x - 2.0, x + 0.3)
    part.set_ylim(-0.3, 2.0)
    part.legend(fontsize=8)
    yield "fig5_to_7_interpolators", figure
    radius, angle = 20.0, np.arange(60) * 0.08
    circle = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    figure, parts = new_figure(
        "Paper 002, Figs 8 to 10: radial error on a circle of 20 mm at 100 mm/s", rows=3, height=1.9
    )
    for part, kind in zip(parts, (2, 3, 4), strict=True):
        rows = interpolate(circle, reproduce_002.PARTS, kind)[320:-320]
        line(part, _ticks(len(rows), reproduce_002.CONTROL), 1e3 * (np.hypot(*rows.T) - radius))
        part.set_ylabel(f"eq. {kind} (µm)", fontsize=8)
    parts[-1].set_xlabel("time (s)")
    yield "fig8_to_10_circle", figure


def paper_003(programs: str | None) -> Figures:
    """Figs 6, 7 and 10 to 14: corners of the butterfly, feed, and contour errors of the strategies."""
    figure, (part,) = new_figure("Paper 003, Figs 5 and 6: sharp corners of the butterfly", height=5.0)
    styles = ((7000.0, "o", 9), (5000.0, "s", 6), (3500.0, "x", 4))
    for feed, mark, size in styles:
        planned = reproduce_003.plan_of("butterfly.nc", programs, feed, "ild")
        if feed == 7000.0:
            rows = planned.signal("position")
            part.plot(rows[:, 0], rows[:, 1], color="0.4", linewidth=0.8)
        places = np.array([c.position[:2] for t in planned.trajectories for c in t.corners])
        part.plot(places[:, 0], places[:, 1], mark, markersize=size, fillstyle="none", linestyle="none",
                  label=f"{feed:g} mm/min: {len(places)}")  # fmt: skip
    part.set_aspect("equal", adjustable="datalim")
    part.legend(fontsize=8)
    yield "fig6_corners", figure
    for curve, number in (("trident", "10 and 12"), ("butterfly", "13 and 14")):
        figure, parts = new_figure(f"Paper 003, Figs {number}: {curve} at 7000 mm/min", rows=6, height=1.6)
        for k, feedrate in enumerate(("adaptive", "curvature", "ild")):
            planned = reproduce_003.plan_of(f"{curve}.nc", programs, 7000.0, feedrate)
            speed, error = planned.signal("feed"), 1e3 * reproduce_003.true_errors(planned)
            line(parts[2 * k], _ticks(len(speed)), speed)
            line(parts[2 * k + 1], _ticks(len(error)), error, color="tab:red")
            parts[2 * k].set_ylabel(f"{feedrate}\nfeed (mm/s)", fontsize=7)
            parts[2 * k + 1].set_ylabel("contour (µm)", fontsize=7)
        parts[-1].set_xlabel("time (s)")
        yield f"{curve}_errors", figure


def paper_004(programs: str | None) -> Figures:
    """Contour errors of the controllers on the circle (Table 1), and the speed of both interpolations (Table 3)."""
    from cncgen.machine import load_servos

    servos = load_servos("dyna-1007")
    rows = reproduce_004.circle(5.0)
    figure, parts = new_figure(
        "Paper 004, Table 1: contour error on a circle of 10 mm at 5 m/min", rows=5, height=1.5
    )
    for part, (name, label) in zip(parts, reproduce_004.LABELS.items(), strict=True):
        run = list(simulate_scheme([Setpoints("XY", 0.001, 0, rows)], scheme_maker(name, servos)))
        error = np.concatenate([r.contour_error_mm for r in run])[:-50]
        line(part, _ticks(len(error)), 1e3 * error)
        part.set_ylabel(f"{label} (µm)", fontsize=7)
    parts[-1].set_xlabel("time (s)")
    yield "table1_contour", figure
    figure, (part,) = new_figure("Paper 004, Table 3: commanded speed on the NURBS circle")
    for label, path in (
        ("uniform parameter steps", reproduce_004.uniform_circle()),
        ("constant speed", rows),
    ):
        speed = np.hypot(*np.diff(path, axis=0).T) / 0.001
        line(part, _ticks(len(speed)), speed, label=label)
    part.set_ylabel("speed (mm/s)")
    part.set_xlabel("time (s)")
    part.legend(fontsize=8)
    yield "table3_speed", figure


def _ticks(count: int, period: float = 0.001, first: int = 0) -> NDArray[np.float64]:
    """Return times of that many periods, s."""
    return np.asarray((first + np.arange(count)) * period, np.float64)


_PAPERS: dict[str, Callable[[str | None], Figures]] = {
    "000": paper_000,
    "001": paper_001,
    "002": paper_002,
    "003": paper_003,
    "004": paper_004,
}
