"""Paper 003 (Tsai): sharp corners, contour errors predicted and true, feedrate strategies, mirror compensation."""

from __future__ import annotations

import numpy as np

from cncgen.geometry.curvature import curvature_extrema
from cncgen.machine import load_servos
from cncgen.machine.servo_schema import resolve
from cncgen.papers.planned import Planned, planned_program
from cncgen.papers.reproduction import Row, Table
from cncgen.planner import PlanOptions
from cncgen.planner.contour_prediction import predicted_errors
from cncgen.planner.paths import path_of
from cncgen.servo.controllers.hinf_servo import check, controller_of, family
from cncgen.servo.loop import close_loop
from cncgen.servo.mirror import Compensation
from cncgen.servo.models import control_period
from cncgen.servo.plants import transfer_function

MACHINE = "xy-table"
STAGE = "flexure-stage"
FEEDS = (3500.0, 5000.0, 7000.0)


def plan_of(program: str, programs: str | None, feed: float, feedrate: str | None = None) -> Planned:
    """Return a curve planned on the paper's table."""
    return planned_program(program, MACHINE, programs, feed, PlanOptions(feedrate=feedrate))


def true_errors(planned: Planned) -> np.ndarray:
    """Return the simulated axes' contour error at every setpoint, mm."""
    return np.concatenate([part.contour_error_mm for part in planned.response()])


def estimate_gap(planned: Planned) -> float:
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
    extrema = sum(len(curvature_extrema(path_of(t)).s) for t in planned.toolpaths)
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
