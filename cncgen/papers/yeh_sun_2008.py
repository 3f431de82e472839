"""Paper 000 (Yeh and Sun): the die bonder's drives under a step limiter."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cncgen.machine import load_servos
from cncgen.machine.record import Servo
from cncgen.machine.servo_schema import closed_loop, resolve
from cncgen.papers.planned import PlannedProgram, planned_program
from cncgen.papers.printed import Row, Table
from cncgen.planner import PlanOptions
from cncgen.report.drawing import (
    BLUE,
    ORANGE,
    RED,
    bound,
    legend,
    line,
    new_figure,
    ticks,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cncgen.report.drawing import Figures

Floats = NDArray[np.float64]

PROGRAM = "bonder.nc"
PERIOD = 0.001


@dataclass(frozen=True, slots=True)
class StepBounds:
    """Figs 6 and 7 as data: speed command with its bounds (pulse/ms) and driving force (V), one row a period."""

    time_s: Floats
    command: Floats
    lower: Floats
    upper: Floats
    force: Floats


def force_sum(letter: str) -> float:
    """Return S of eq. 3.5 in V s/rad: kp' + kd + kv + ka with kp' = kp Ke Ts (the unit of w being rad/s)."""
    p = resolve(_servo(letter), letter)
    gain = p["velocity_gain_rad_s_volt"]
    stiff = p["position_gain_volt_count"] * p["counts_per_rad"] * PERIOD
    return float(stiff + p["derivative_gain_volt_s_rad"] + (1.0 + p["time_constant_s"] / PERIOD) / gain)


def _servo(letter: str) -> Servo:
    return load_servos("die-bonder")[letter]


def step_bounds(planned: PlannedProgram, letter: str = "X") -> StepBounds:
    """Return eq. 3.6's bounds on the speed command along a simulated run of an axis.

    v[k] follows from the force before the drive's bound, u = S wd + v; where the drive is in saturation that force is
    computed from commanded and actual positions by eq. 3.3.
    """
    parts = planned.response()
    i = parts[0].axes.index(letter)
    command, position, force = (
        np.concatenate([getattr(p, k)[:, i] for p in parts]) for k in ("command", "position", "force")
    )
    p = resolve(_servo(letter), letter)
    scale, ke = p["counts_per_mm"], p["counts_per_rad"]
    wanted, actual = command * scale, position * scale
    rate = np.diff(wanted, prepend=wanted[0]) / (PERIOD * ke)
    measured = np.diff(actual, prepend=actual[0]) / (PERIOD * ke)
    before = np.concatenate([[0.0], rate[:-1]])
    gain = p["velocity_gain_rad_s_volt"]
    free = (
        p["position_gain_volt_count"] * (np.concatenate([wanted[:1], wanted[:-1]]) - actual)
        - p["derivative_gain_volt_s_rad"] * measured
        - p["time_constant_s"] / (gain * PERIOD) * before
    )
    total, bound, pulses = force_sum(letter), p["saturation_volt"], ke * PERIOD
    return StepBounds(
        np.asarray(np.arange(len(rate)) * PERIOD, np.float64),
        rate * pulses,
        (-bound - free) / total * pulses,
        (bound - free) / total * pulses,
        force,
    )


def bonder(saturation: str, programs: str | None = None) -> PlannedProgram:
    """Return the die bonder's program at uniform parameter steps, with or without limiting."""
    options = PlanOptions(feedrate="constant", interpolator="uniform", saturation=saturation)
    return planned_program(PROGRAM, "die-bonder", programs, options=options)


def tables(programs: str | None = None) -> list[Table]:
    """Return what Table 1's machine comes to, and what limiting does to its drives."""
    rows = []
    for letter, natural, damping, largest in (("X", 418.3, 0.294, 90.56), ("Y", 463.4, 0.714, 198.3)):
        servo = _servo(letter)
        loop = closed_loop(servo, letter)
        lag, drag, stiff = loop.denominator
        wn = math.sqrt(stiff / lag)
        p = resolve(servo, letter)
        step = p["saturation_volt"] / force_sum(letter) * p["counts_per_rad"] * PERIOD
        rows.append(Row(f"{letter}: natural frequency", wn, natural, "rad/s", within=1e-3))
        rows.append(Row(f"{letter}: damping", drag / lag / (2 * wn), damping, "", within=2e-3))
        rows.append(Row(f"{letter}: largest first step at 10 V", step, largest, "pulse/ms", within=1e-3))
    limited = []
    for saturation in ("off", "reactive"):
        bounds = step_bounds(bonder(saturation, programs))
        over = int((np.abs(bounds.force) >= 10.0).sum())
        outside = int(((bounds.command > bounds.upper + 1e-6) | (bounds.command < bounds.lower - 1e-6)).sum())
        off = saturation == "off"
        limited.append(
            Row(f"limiting {saturation}: samples of X in saturation", over, at_least=1.0 if off else None,
                at_most=None if off else 0.0)
        )  # fmt: skip
        limited.append(
            Row(
                f"limiting {saturation}: speed commands outside eq. 3.6",
                outside,
                at_most=None if off else 0.0,
            )
        )
        limited.append(
            Row(f"limiting {saturation}: largest force on X", float(np.abs(bounds.force).max()), unit="V")
        )
    return [
        Table("Paper 000, Table 1: the machine", tuple(rows), _MACHINE),
        Table("Paper 000, Figs 5 to 7: limiting, on our path", tuple(limited), _PATH),
    ]


_MACHINE = (
    "the printed column is what Table 1 gives by hand in the units that make it consistent (docs/servo-models.md)",
    "neither the bound of the drive nor the counts per mm are printed: 10 V and 1,000 are assumed",
)
_PATH = (
    "the paper's path is not printed: programs/bonder.nc has two sharp corners in one NURBS; plant = controller's model",
)


def figures(programs: str | None = None) -> Figures:
    """Figs 5 to 7: contours, bounds of the speed command, driving force, with and without limiting."""
    runs = {s: bonder(s, programs) for s in ("off", "reactive")}
    bounds = {s: step_bounds(run) for s, run in runs.items()}
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


def _bonder_contours(runs: Mapping[str, PlannedProgram]) -> Figure:
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
