"""Comparisons as tables: feedrate strategies, interpolators, and controllers on one program."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any

from cncgen.diagnostics import UsageError
from cncgen.machine.record import Servo
from cncgen.report.comparison import Fluctuation, StrategyFigures
from cncgen.report.tables import number, text_table
from cncgen.servo.named_schemes import Settings, scheme_maker
from cncgen.servo.simulate import simulate_scheme
from cncgen.servo.summary import summarize
from cncgen.setpoints.record import Setpoints
from cncgen.units import file_unit


def strategy_table(figures: Iterable[StrategyFigures]) -> str:
    """Return time, contour errors, and peaks of acceleration and jerk of each strategy; a fault instead of figures."""
    header = (
        "feedrate",
        "time s",
        "contour max µm",
        "contour rms µm",
        "predicted µm",
        "acceleration mm/s²",
        "of limit",
        "jerk mm/s³",
        "of limit",
    )
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
            ]
        )
    return text_table(header, rows)


def strategy_values(
    figures: Iterable[StrategyFigures], fluctuations: Iterable[Fluctuation]
) -> dict[str, Any]:
    """Return the figures of both tables as plain values; a strategy that failed has its ``fault`` alone."""
    strategies = []
    for one in figures:
        values = {field.name: getattr(one, field.name) for field in fields(one)}
        fault = values.pop("fault")
        strategies.append({"feedrate": one.feedrate, "fault": fault.message} if fault else values)
    interpolators = []
    for each in fluctuations:
        values = {field.name: getattr(each, field.name) for field in fields(each)}
        problem = values.pop("fault")
        interpolators.append(
            {"interpolator": each.interpolator, "fault": problem.message} if problem else values
        )
    return {"strategies": strategies, "interpolators": interpolators}


def interpolator_table(fluctuations: Iterable[Fluctuation]) -> str:
    """Return each interpolator's fluctuation of the feed, its time, its distance from the path, and that of the axes.

    The fluctuation is travelled against commanded distance per period. An interpolator that fails has its fault's code.
    """
    header = (
        "interpolator",
        "fluctuation max %",
        "rms %",
        "time s",
        "path error µm",
        "contour max µm",
    )
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
            ]
        )
    return text_table(header, rows)


def compare_controllers(
    setpoints: Sequence[Setpoints],
    servos: Mapping[str, Servo],
    names: Sequence[str],
    settings: Settings | None = None,
) -> list[dict[str, Any]]:
    """Simulate the same setpoints under controllers by name; return the summary of each, with ``controller``.

    A controller that cannot be had for the axes has its ``fault`` (a diagnostic's message) instead of figures, so that
    the others are still compared.

    Raises:
        UsageError: A name is unknown, an axis has no servo data, or no controller can be had.
    """
    makers = [scheme_maker(name, servos, settings) for name in names]
    found: list[dict[str, Any]] = []
    first: UsageError | None = None
    for name, maker in zip(names, makers, strict=True):
        try:
            found.append({"controller": name, **summarize(simulate_scheme(iter(setpoints), maker))})
        except UsageError as error:
            if error.diagnostics[0].code not in ("controller-unfit", "servo-unstable"):
                raise
            found.append({"controller": name, "fault": error.diagnostics[0].message})
            first = first or error
    if first is not None and all("fault" in one for one in found):
        raise first
    return found


def controller_table(summaries: Sequence[Mapping[str, Any]]) -> str:
    """Return contour error, tracking errors, speed variation and saturation of each controller."""
    whole = [s for s in summaries if "fault" not in s]
    letters = list(whole[0]["axes"]) if whole else []
    header = ["controller", "contour max µm", "contour rms µm"]
    header += [f"{k.upper()} tracking rms {'µm' if file_unit(k) == 'mm' else 'mdeg'}" for k in letters]
    header += ["speed variation mm/s", "saturated"]
    rows = []
    for s in summaries:
        if "fault" in s:
            rows.append([s["controller"], *["-"] * (len(header) - 1)])
            continue
        tracking = [number(s["axes"][k][f"tracking_rms_{file_unit(k)}"], 1000) for k in letters]
        contour = [number(s[f"contour_error_{kind}_mm"], 1000) for kind in ("max", "rms")]
        rows.append(
            [
                s["controller"],
                *contour,
                *tracking,
                number(s["speed_variation_mm_s"]),
                str(s["saturated_samples"]),
            ]
        )
    faults = [f"  {s['fault']}\n" for s in summaries if "fault" in s]
    return text_table(header, rows) + "".join(faults)
