"""Paper 003 (Tsai): sharp corners, contour errors predicted and true, feedrate strategies, mirror compensation."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from cncgen.geometry.curvature import curvature_extrema
from cncgen.machine import load_servos
from cncgen.machine.servo_schema import resolve
from cncgen.papers.planned import PlannedProgram, planned_program
from cncgen.papers.printed import Row, Table
from cncgen.planner import PlanOptions
from cncgen.planner.contour_prediction import predicted_errors
from cncgen.report.drawing import (
    BLUE,
    GREY,
    ORANGE,
    RED,
    legend,
    line,
    new_figure,
    plane,
    ticks,
)
from cncgen.servo.controllers.hinf_servo import check, controller_of, family
from cncgen.servo.loop import close_loop
from cncgen.servo.mirror import Compensation
from cncgen.servo.models import control_period
from cncgen.servo.plants import transfer_function

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cncgen.report.drawing import Figures

MACHINE = "xy-table"
STAGE = "flexure-stage"
FEEDS = (3500.0, 5000.0, 7000.0)


def plan_of(program: str, programs: str | None, feed: float, feedrate: str | None = None) -> PlannedProgram:
    """Return a curve planned on the paper's table."""
    return planned_program(program, MACHINE, programs, feed, PlanOptions(feedrate=feedrate))


def true_errors(planned: PlannedProgram) -> np.ndarray:
    """Return the simulated axes' contour error at every setpoint, mm."""
    return np.concatenate([part.contour_error_mm for part in planned.response()])


def estimate_gap(planned: PlannedProgram) -> float:
    """Return the largest difference of predicted (eqs 15 to 18) and true contour error at a setpoint, µm.

    As in the paper's Fig. 3 the true one is measured where a perpendicular to the path exists: positions that overshoot
    the path's end along its tangent have none.
    """
    predicted = predicted_errors(planned.trajectories, planned.machine, PlanOptions())
    actual = true_errors(planned)
    if predicted is None:
        return float("nan")
    position = np.concatenate([part.position for part in planned.response()])
    wanted = planned.signal("position")
    end = wanted[-1]
    moved = np.flatnonzero(np.abs(wanted - end).max(axis=1) > 1e-3)[-1]
    beyond = ((position - end) @ (end - wanted[moved]) > 0.0) & (np.abs(position - end).max(axis=1) < 0.1)
    count = min(len(predicted), len(actual))
    gap = np.abs(np.abs(predicted[:count]) - actual[:count])
    return 1e3 * float(gap[~beyond[:count]].max())


def mirror_ratio(programs: str | None, passes: int = 2) -> tuple[float, float, float]:
    """Return the butterfly's largest contour error at 7000 mm/min before and after compensation (µm), and their ratio."""
    planned = plan_of("butterfly.nc", programs, 7000.0)
    compensation = Compensation(iter(planned.setpoints), planned.servos, passes=passes)
    for _ in compensation.chunks():
        pass
    gained = compensation.gained()
    before, after = (1e3 * gained[k]["contour_max_mm"] for k in ("before", "after"))
    return before, after, before / after


def stage_steps(letter: str, seconds: float = 0.8) -> list[np.ndarray]:
    """Return the response of the flexure stage to a step of 20 µm for every payload, µm, one row a control period."""
    servo = load_servos(STAGE)[letter]
    values = resolve(servo, letter)
    period = control_period(servo, letter, 0.001)
    controller = controller_of(values, period)
    found = []
    for above, below in family(values):
        loop = close_loop(transfer_function(np.array(above), np.array(below)), controller, period)
        a, b, _ = loop.transition()
        states = np.zeros((round(seconds / period), len(a)))
        for k in range(1, len(states)):
            states[k] = a @ states[k - 1] + b
        found.append(20.0 * states @ loop.output)
    return found


def _stage(programs: str | None = None) -> Table:
    rows = []
    for letter in "XY":
        servo = load_servos(STAGE)[letter]
        values = resolve(servo, letter)
        period = control_period(servo, letter, 0.001)
        bounds = check(values, controller_of(values, period), period)
        steps = stage_steps(letter)
        rises = [(np.argmax(step > 18.0) - np.argmax(step > 2.0)) * period for step in steps]
        ends = [abs(float(step[-1]) - 20.0) for step in steps]
        rows.append(
            Row(
                f"{letter}: rise time of 20 µm, slowest of {len(steps)} plants",
                max(rises),
                0.1,
                "s",
                at_most=0.1,
            )
        )
        rows.append(Row(f"{letter}: error after 0.8 s, largest", max(ends), 1.0, "µm", at_most=1.0))
        share = float((bounds.sensitivity / bounds.allowed).max())
        rows.append(Row(f"{letter}: |S| of its bound (eq. 4), largest", share, at_most=1.0))
        rows.append(
            Row(f"{letter}: |T| (eq. 5), largest", float(bounds.complementary.max()), at_most=bounds.peak)
        )
    return Table(
        "Appended to paper 003: H-infinity and QFT control of a flexure stage", tuple(rows), _FLEXURE
    )


def tables(programs: str | None = None) -> list[Table]:
    """Return corner counts, estimates, reductions, mirror compensation, and the appended paper's stage."""
    return [_corners(programs), _estimates(programs), _reductions(programs), _mirror(programs), _stage()]


def _corners(programs: str | None) -> Table:
    rows = []
    for feed, printed in zip(FEEDS, (11, 14, 24), strict=True):
        planned = plan_of("butterfly.nc", programs, feed, feedrate="ild")
        rows.append(Row(f"butterfly, {feed:g} mm/min: sharp corners", planned.corners, printed, within=0.0))
    extrema = sum(len(curvature_extrema(t.path).s) for t in planned.toolpaths)
    rows.append(Row("butterfly: local extrema of curvature", extrema, 73, within=0.0))
    return Table("Paper 003, Fig. 6: sharp corners of the butterfly", tuple(rows), _CORNERS)


def _estimates(programs: str | None) -> Table:
    rows = []
    for name in ("trident", "butterfly"):
        for feed in FEEDS:
            planned = plan_of(f"{name}.nc", programs, feed, feedrate="ild")
            label = f"{name}, {feed:g} mm/min: predicted and true contour error differ by at most"
            rows.append(
                Row(
                    label,
                    estimate_gap(planned),
                    2.0 if name == "trident" and feed == 3500 else None,
                    "µm",
                    at_most=3.0,
                )
            )
    return Table("Paper 003, section 6.1: estimate of the contour error", tuple(rows), (_TRIDENT, _LOOP))


def _reductions(programs: str | None) -> Table:
    rows = []
    for name in ("trident", "butterfly"):
        largest = {}
        for feedrate in ("adaptive", "curvature", "ild"):
            planned = plan_of(f"{name}.nc", programs, 7000.0, feedrate=feedrate)
            largest[feedrate] = 1e3 * float(true_errors(planned).max())
            rows.append(Row(f"{name}, {feedrate}: largest contour error", largest[feedrate], unit="µm"))
            rows.append(Row(f"{name}, {feedrate}: time", planned.time_s, unit="s"))
        rows.append(Row(f"{name}, ild: at most the 10 µm asked", largest["ild"], 10.0, "µm", at_most=10.0))
        for feedrate, printed in (("adaptive", 90.65), ("curvature", 69.04)):
            less = 100.0 * (1.0 - largest["ild"] / largest[feedrate])
            shown = printed if name == "trident" else None
            rows.append(Row(f"{name}, ild against {feedrate}: reduction", less, shown, "%"))
    return Table("Paper 003, Table V: contour errors at 7000 mm/min", tuple(rows), (_TRIDENT, _LOOP))


def _mirror(programs: str | None) -> Table:
    before, after, ratio = mirror_ratio(programs)
    rows = (
        Row("butterfly, least-time plan: largest contour error", before, unit="µm"),
        Row("the same after two passes", after, unit="µm"),
        Row("smaller by", ratio, unit="×", at_least=10.0),
    )
    return Table("Mirror compensation of the butterfly at 7000 mm/min", rows, (_MIRROR,))


_CORNERS = (
    "A_max = 2450 mm/s² (0.25 g) is not printed; corners nearer than 1 mm to another one or to the start are not counted",
)
_TRIDENT = "the paper's trident is not published: ours has three tips and two valleys"
_LOOP = "the loop's values are Tian's (2025), who prints the coefficients of the same structure"
_FLEXURE = (
    "the paper's plants are in its figures only: ours has one resonance of 25 or 27.5 Hz and payloads within 10 % (profile"
    " flexure-stage)",
    "the loops are sampled at 0.5 ms; quantisation and saturation are left out",
)
_MIRROR = "not in the paper; the model is exact and no limit is checked: cncgen compensate refuses what the machine cannot do"


def figures(programs: str | None = None) -> Figures:
    """Figs 1, 3, 6, 7 and 10 to 14: corners, curvature, estimate, feed and errors; and the appended paper's stage."""
    yield "fig1_trident", _trident(programs)
    yield "fig3_estimate", _estimate(programs)
    yield "fig6_curvature", _curvature(programs)
    figure, ((part,),) = new_figure("Paper 003, Figs 5 and 6: sharp corners of the butterfly", height=5.4)
    styles = ((7000.0, "o", 10, BLUE), (5000.0, "s", 7, ORANGE), (3500.0, "x", 5, "black"))
    for feed, mark, size, color in styles:
        planned = plan_of("butterfly.nc", programs, feed, "ild")
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
        planned = plan_of(f"{curve}.nc", programs, 7000.0, feedrate)
        speed, error = planned.signal("feed"), 1e3 * true_errors(planned)
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
    planned = plan_of("trident.nc", programs, 7000.0, "ild")
    rows = planned.signal("position")
    part.plot(rows[:, 0], rows[:, 1], color=GREY, linewidth=0.9)
    for name, corner in zip("ABCDE", (c for t in planned.trajectories for c in t.corners), strict=False):
        part.plot(*corner.position[:2], "o", color=RED, markersize=6, fillstyle="none")
        part.annotate(name, corner.position[:2], xytext=(6, 4), textcoords="offset points")
    plane(part, [rows], ("X (mm)", "Y (mm)"))
    return figure


def _estimate(programs: str | None) -> Figure:
    """Fig. 3: contour error round the second corner of the trident, estimated and true."""
    planned = plan_of("trident.nc", programs, 3500.0, "curvature")
    actual = 1e3 * true_errors(planned)
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
    planned = plan_of("butterfly.nc", programs, 3500.0, "ild")
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
    for feed, color in zip(FEEDS, (RED, ORANGE, GREY), strict=True):
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
        servo = load_servos(STAGE)[letter]
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
        for rows in stage_steps(letter):
            line(part, ticks(len(rows), 0.0005)[:600], rows[:600], linewidth=0.6)
        part.axhline(20.0, color=GREY, linewidth=0.8, linestyle="--")
        part.set_ylabel(f"{letter} (µm)")
    grid[-1, 0].set_xlabel("time (s)")
    return figure
