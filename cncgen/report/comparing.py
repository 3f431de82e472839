"""Comparisons as tables: feedrate strategies, interpolators, and controllers on one program."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any

from cncgen.diagnostics import UsageError
from cncgen.machine.record import Axis, Servo
from cncgen.report.comparison import Demand, Fluctuation, StrategyFigures
from cncgen.report.tables import number, text_table
from cncgen.servo.command_limits import breaks, broken_values
from cncgen.servo.loop_doubts import telling
from cncgen.servo.named_schemes import Settings, scheme_maker
from cncgen.servo.response_spread import drawn_figures, spread_values
from cncgen.servo.scheme import SchemeMaker
from cncgen.servo.simulate import shaped_command, simulate_scheme
from cncgen.servo.summary import summarize
from cncgen.servo.uncertainty import Perturbation
from cncgen.servo.wanted_motion import WantedMotion, judged_against
from cncgen.setpoints.record import Setpoints
from cncgen.units import file_unit

#: Column of the errors against a reference.
_AGAINST = "from the reference µm"


def strategy_table(figures: Iterable[StrategyFigures]) -> str:
    """Return time, contour errors, and peaks of acceleration and jerk of each strategy; a fault instead of figures."""
    header = [
        "feedrate",
        "time s",
        "contour max µm",
        "contour rms µm",
        "predicted µm",
        "acceleration mm/s²",
        "of limit",
        "jerk mm/s³",
        "of limit",
    ]
    figures = list(figures)
    against = any(f.reference_max_mm is not None for f in figures)
    header += [_AGAINST] if against else []
    header += _demand_header(figures)
    rows = []
    for f in figures:
        if f.fault is not None:
            rows.append([f.feedrate, f.fault.code, *["-"] * (len(header) - 2)])
            continue
        rows.append(
            [
                f.feedrate,
                f"{f.time_s:.4f}",
                number(f.contour_max_mm, 1000),
                number(f.contour_rms_mm, 1000),
                number(f.predicted_max_mm, 1000),
                number(f.acceleration, digits=5),
                number(f.acceleration_of_limit),
                number(f.jerk, digits=5),
                number(f.jerk_of_limit),
                *([number(f.reference_max_mm, 1000)] if against else []),
                *_demand_cells(f.demand),
            ]
        )
    return text_table(header, rows)


def strategy_values(
    figures: Iterable[StrategyFigures], fluctuations: Iterable[Fluctuation]
) -> dict[str, Any]:
    """Return the figures of both tables as plain values; a strategy that failed has its ``fault`` alone."""
    strategies = []
    for one in figures:
        values = _values_of(one)
        fault = values.pop("fault")
        strategies.append({"feedrate": one.feedrate, "fault": fault.message} if fault else values)
    interpolators = []
    for each in fluctuations:
        values = _values_of(each)
        problem = values.pop("fault")
        interpolators.append(
            {"interpolator": each.interpolator, "fault": problem.message} if problem else values
        )
    return {"strategies": strategies, "interpolators": interpolators}


def _values_of(figures: StrategyFigures | Fluctuation) -> dict[str, Any]:
    """Return the fields of a row, those of its demand among them."""
    values = {field.name: getattr(figures, field.name) for field in fields(figures)}
    demand: Demand | None = values.pop("demand")
    if demand is not None:
        effort = None if demand.effort is None else {k: value for k, (value, _) in demand.effort.items()}
        values |= {
            "force_max": effort,
            "saturated_samples": demand.saturated,
            "breaks": list(demand.breaks),
        }
    return values


def interpolator_table(fluctuations: Iterable[Fluctuation]) -> str:
    """Return each interpolator's fluctuation of the feed, its time, its distance from the path, and that of the axes.

    The fluctuation is travelled against commanded distance per period. An interpolator that fails has its fault's code.
    """
    header = [
        "interpolator",
        "fluctuation max %",
        "rms %",
        "time s",
        "path error µm",
        "contour max µm",
    ]
    fluctuations = list(fluctuations)
    against = any(f.reference_max_mm is not None for f in fluctuations)
    header += [_AGAINST] if against else []
    header += _demand_header(fluctuations)
    rows = []
    for f in fluctuations:
        if f.fault is not None:
            rows.append([f.interpolator, f.fault.code, *["-"] * (len(header) - 2)])
            continue
        rows.append(
            [
                f.interpolator,
                f"{100 * f.max_part:.3g}",
                f"{100 * f.rms_part:.3g}",
                f"{f.time_s:.4f}",
                number(f.path_error_mm, 1000),
                number(f.contour_max_mm, 1000),
                *([number(f.reference_max_mm, 1000)] if against else []),
                *_demand_cells(f.demand),
            ]
        )
    return text_table(header, rows)


def _demand_header(figures: Iterable[StrategyFigures | Fluctuation]) -> list[str]:
    """Return the columns of `_demand_cells`."""
    first = next((f.demand for f in figures if f.demand is not None), None)
    if first is None:
        return []
    efforts = [
        f"{letter.upper()} effort {unit}".strip() for letter, (_, unit) in (first.effort or {}).items()
    ]
    return [*efforts, *(["saturated"] if first.effort else []), "breaks"]


def _demand_cells(demand: Demand | None) -> list[str]:
    """Return the largest drive input of each axis and the setpoints at a bound, where there are servo data, and broken limits."""
    if demand is None:
        return []
    efforts = [number(value) for value, _ in (demand.effort or {}).values()]
    return [*efforts, *([str(demand.saturated)] if demand.effort else []), _break_text(demand.breaks)]


def compare_controllers(
    setpoints: Sequence[Setpoints],
    servos: Mapping[str, Servo],
    names: Sequence[str],
    settings: Settings | None = None,
    limits: Mapping[str, Axis] | None = None,
    wanted: WantedMotion | None = None,
    drawn: Perturbation | None = None,
) -> list[dict[str, Any]]:
    """Simulate the same setpoints under controllers by name; return the summary of each, with ``controller``.

    With `limits` each has ``breaks``: by how much the setpoints that the loops are given, after a prefilter, exceed a limit. With `wanted` each has its errors against the wanted motion as ``reference``. With `drawn`
    each has the spread of its errors over drawn machines as ``perturbed``.

    A controller that cannot be had for the axes has its ``fault`` (a diagnostic's message) instead of figures, so that
    the others are still compared.

    Raises:
        UsageError: A name is unknown, an axis has no servo data, or no controller can be had.
    """
    makers = [scheme_maker(name, servos, settings) for name in names]
    mechanism = None if wanted is None else wanted.kinematics
    found: list[dict[str, Any]] = []
    first: UsageError | None = None
    for name, maker in zip(names, makers, strict=True):
        try:
            responses = list(simulate_scheme(iter(setpoints), telling(maker), kinematics=mechanism))
            summary = {"controller": name, **summarize(responses)}
            if limits is not None:
                summary["breaks"] = _breaks(setpoints, maker, limits)
            if wanted is not None:
                summary["reference"] = judged_against(wanted, responses)
            if drawn is not None:
                figures = drawn_figures(
                    setpoints, servos, drawn, controller=name, settings=settings, kinematics=mechanism
                )
                summary["perturbed"] = spread_values(figures, drawn)
            found.append(summary)
        except UsageError as error:
            if error.diagnostics[0].code not in ("controller-unfit", "servo-unstable"):
                raise
            found.append({"controller": name, "fault": error.diagnostics[0].message})
            first = first or error
    if first is not None and all("fault" in one for one in found):
        raise first
    return found


def _break_text(found: Sequence[Mapping[str, Any]]) -> str:
    """Return the broken limits in one cell."""
    words = [f"{b['axis']} {b['limit']}" + (f" {b['ratio']:.3g}x" if b["ratio"] else "") for b in found]
    return ", ".join(words) or "none"


def _spread_cells(found: Mapping[str, Any]) -> dict[str, str]:
    """Return the interval and the worst of the largest contour error over drawn machines; an unstable one has no number."""
    share, error = (100.0 * found[key] for key in ("interval_share", "interval_share_error"))
    interval = worst = "-"
    errors = found.get("contour_error_max_mm")
    if errors is not None:
        low, high, worst = (
            "unstable" if errors[key] is None else number(errors[key], 1000)
            for key in ("low", "high", "worst")
        )
        interval = f"{low} to {high}"
    return {f"drawn {share:g} ± {error:.1f} % µm": interval, "worst µm": worst}


def _breaks(
    setpoints: Sequence[Setpoints], maker: SchemeMaker, limits: Mapping[str, Axis]
) -> list[dict[str, Any]]:
    """Return axis, limit and ratio of each limit that the shaped setpoints break."""
    head = setpoints[0]
    command = shaped_command(iter(setpoints), maker(head.axes, head.period_s))
    return broken_values(breaks(limits, head.axes, command, head.period_s))


def _controller_cells(summary: Mapping[str, Any], against: str) -> dict[str, str]:
    """Return the cells of a controller's row by their headings; `against` is that of the errors against a reference."""
    axes = summary["axes"]
    cells = {"controller": summary["controller"]}
    for kind in ("max", "rms"):
        cells[f"contour {kind} µm"] = number(summary[f"contour_error_{kind}_mm"], 1000)
    if "reference" in summary:
        cells[against] = number(summary["reference"]["contour_error_max_mm"], 1000)
    if "perturbed" in summary:
        cells |= _spread_cells(summary["perturbed"])
    for letter, axis in axes.items():
        unit = file_unit(letter)
        shown = "µm" if unit == "mm" else "mdeg"
        cells[f"{letter.upper()} tracking rms {shown}"] = number(axis[f"tracking_rms_{unit}"], 1000)
    cells["speed variation mm/s"] = number(summary["speed_variation_mm_s"])
    for letter, axis in axes.items():
        cells[f"{letter.upper()} effort {axis['force_unit']}".strip()] = number(axis["force_max"])
    cells["saturated"] = str(summary["saturated_samples"])
    if "breaks" in summary:
        cells["breaks"] = _break_text(summary["breaks"])
    return cells


def controller_table(summaries: Sequence[Mapping[str, Any]], against_program: bool = True) -> str:
    """Return contour error, tracking errors, speed variation, effort, saturation and broken limits of each controller."""
    against = "from the program µm" if against_program else _AGAINST
    rows = [
        {"controller": s["controller"]} if "fault" in s else _controller_cells(s, against) for s in summaries
    ]
    header = list(max(rows, key=len, default={"controller": ""}))
    faults = [f"  {s['fault']}\n" for s in summaries if "fault" in s]
    return text_table(header, [[row.get(k, "-") for k in header] for row in rows]) + "".join(faults)
