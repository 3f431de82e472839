"""Paper 000 (Yeh and Sun): the die bonder's drives under a step limiter."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cncgen.machine import load_servos
from cncgen.machine.record import Servo
from cncgen.machine.servo_schema import closed_loop, resolve
from cncgen.papers.planned import PlannedProgram, planned_program
from cncgen.papers.printed import Basis, Row, RowKind, Table, absent, drawing, given
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


def bonder(
    saturation: str,
    programs: str | None = None,
    feed_mm_min: float | None = None,
    counts_per_mm: float | None = None,
) -> PlannedProgram:
    """Return the die bonder's program at uniform parameter steps, with or without limiting.

    Args:
        saturation: ``off`` or ``reactive``.
        programs: Folder of the example programs; None: looked for.
        feed_mm_min: Mean speed; None: the program's.
        counts_per_mm: Scale of both axes; None: the profile's.
    """
    servos = dict(load_servos("die-bonder"))
    if counts_per_mm is not None:
        servos = {
            k: Servo(s.model, {**s.parameters, "counts_per_mm": counts_per_mm}) for k, s in servos.items()
        }
    options = PlanOptions(
        feedrate="constant", interpolator="uniform", saturation=saturation, servos=MappingProxyType(servos)
    )
    return planned_program(PROGRAM, "die-bonder", programs, feed_mm_min, options)


def following_errors(planned: PlannedProgram) -> Floats:
    """Return the largest following error of each axis over a simulated run, µm."""
    parts = planned.response()
    error = np.concatenate([part.command - part.position for part in parts])
    largest: Floats = 1e3 * np.abs(error).max(axis=0)
    return largest


def contour_error(planned: PlannedProgram) -> float:
    """Return the largest contour error of a simulated run, µm."""
    return 1e3 * float(max(part.contour_error_mm.max() for part in planned.response()))


def tables(programs: str | None = None) -> list[Table]:
    """Return Table 1 with derived values, and the figures: effects of limiting on the drives and on the contour."""
    runs = {s: bonder(s, programs) for s in ("off", "reactive")}
    return [_given(programs), _contours(runs, programs), _drives(runs), _schemes(), _machine()]


def _given(programs: str | None) -> Table:
    """Table 1 and the sampling time, which are taken over."""
    printed = {
        "X": ("0.31", "2506.17", "1591.5494", "0.0136", "0.03"),
        "Y": ("0.135", "3156.23", "1591.5494", "0.00577", "0.028"),
    }
    keys = (
        ("tau", "time_constant_s"),
        ("Kc", "velocity_gain_rad_s_volt"),
        ("Ke", "counts_per_rad"),
        ("Kp", "position_gain_volt_count"),
        ("Kd", "derivative_gain_volt_s_rad"),
    )
    rows = [
        given(f"Table 1, {letter}: {name}", text, float(resolve(_servo(letter), letter)[key]))
        for letter, values in printed.items()
        for (name, key), text in zip(keys, values, strict=True)
    ]
    rows.append(given("section 4: sampling time and time step", "1 ms", 1e3 * PERIOD, "ms"))
    corners = planned_program(PROGRAM, "die-bonder", programs, options=PlanOptions(feedrate="ild")).corners
    rows.append(
        Row("section 4: sharp corners in the path", corners, "two sharp corners exist", at_least=2.0, at_most=2.0,
            kind=RowKind.INPUT, basis=None)
    )  # fmt: skip
    return Table("Paper 000, Table 1 and section 4: the machine as given", tuple(rows), (_UNITS,))


def _contours(runs: Mapping[str, PlannedProgram], programs: str | None) -> Table:
    """Fig. 5 and the following error that the text names with it."""
    errors = following_errors(runs["reactive"])
    slower = following_errors(bonder("reactive", programs, feed_mm_min=3000.0))
    finer = following_errors(bonder("reactive", programs, counts_per_mm=4000.0))
    rows = [
        Row(f"Fig. 5: following error of {letter} with limiting", float(errors[i]), "limited to 100 µm", "µm", at_most=100.0,
            basis=Basis.SCANNED,
            sensitivity=(("half the speed", float(slower[i])), ("0.25 µm a count", float(finer[i]))), reason=_TOO_LARGE)
        for i, letter in enumerate("XY")
    ]  # fmt: skip
    ratio = contour_error(runs["reactive"]) / contour_error(runs["off"])
    rows.append(
        Row("Fig. 5: contour error with limiting over that without", ratio, "the contouring accuracy is maintained",
            at_most=1.0, basis=Basis.SCANNED)
    )  # fmt: skip
    rows.append(absent("Fig. 5: the two contours", "", _NO_PATH))
    return Table("Paper 000, Fig. 5: contouring with and without limiting, on our path", tuple(rows), _PATH)


def _drives(runs: Mapping[str, PlannedProgram]) -> Table:
    """Figs 6 and 7: speed commands within their bounds, forces within the drive's."""
    bounds = {s: step_bounds(run) for s, run in runs.items()}
    outside = {
        s: int(((b.command > b.upper + 1e-6) | (b.command < b.lower - 1e-6)).sum()) for s, b in bounds.items()
    }
    over = {s: int((np.abs(b.force) >= 10.0).sum()) for s, b in bounds.items()}
    rows = (
        Row("Fig. 6: speed commands of X outside eq. 3.6, with limiting", outside["reactive"],
            "confined to the lower and upper bounds", at_most=0.0, basis=Basis.SCANNED,
            sensitivity=(("without limiting", outside["off"]),)),
        absent("Fig. 6: the bounds over time", "", _NO_PATH, "pulse/ms"),
        Row("Fig. 7: samples of X in saturation, with limiting", over["reactive"], "actuator saturation does not occur",
            at_most=0.0, basis=Basis.SCANNED),
        Row("Fig. 7: samples of X in saturation, without limiting", over["off"], "larger than the input limit", at_least=1.0,
            basis=Basis.SCANNED),
        absent("Fig. 7: the driving forces over time", "", _NO_PATH),
    )  # fmt: skip
    return Table("Paper 000, Figs 6 and 7: bounds and forces, on our path", rows, _PATH)


def _schemes() -> Table:
    """Figs 1 to 4."""
    rows = [drawing(f"Fig. {k}: block diagram") for k in (1, 2, 3)]
    return Table("Paper 000, Figs 1 to 4", (*rows, drawing("Fig. 4: photograph of the setup")))


def _machine() -> Table:
    """Values that follow from Table 1 by hand, held against the code."""
    rows = []
    for letter, natural, damping, largest in (("X", 418.3, 0.294, 90.56), ("Y", 463.4, 0.714, 198.3)):
        servo = _servo(letter)
        lag, drag, stiff = closed_loop(servo, letter).denominator
        wn = math.sqrt(stiff / lag)
        p = resolve(servo, letter)
        step = p["saturation_volt"] / force_sum(letter) * p["counts_per_rad"] * PERIOD
        for name, ours, unit, expected in (
            ("natural frequency", wn, "rad/s", natural),
            ("damping", drag / lag / (2 * wn), "", damping),
            ("largest first step at 10 V", step, "pulse/ms", largest),
        ):
            rows.append(
                Row(f"{letter}: {name}", ours, unit=unit, within=2e-3, kind=RowKind.OURS, expected=expected)
            )
    return Table("Paper 000: consequences of Table 1 (not in the paper)", tuple(rows), (_UNITS,))


_UNITS = (
    "units are not printed: those of docs/servo-models.md make the table consistent. The bound of the drive and the counts per mm"
    " are not printed either: 10 V and 1,000 are assumed"
)
_PATH = (
    "the path is programs/bonder.nc, which has two sharp corners in one NURBS; the plant is the controller's model; uniform steps"
    " at 6000 mm/min on average. Path and speed were chosen so that the drives saturate at the start",
)
_NO_PATH = "path, speed, bound of the drive and counts per mm are not printed"
_TOO_LARGE = (
    "a force near the 10 V costs 300 to 500 counts whatever the path, so 100 µm ask for at most 0.25 µm a count or for less force"
    " (docs/saturation.md); neither is printed"
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
