"""Comparisons as tables: feedrate strategies, interpolators, and controllers on one program."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from cncgen.machine.record import Servo
from cncgen.report.comparison import Fluctuation, StrategyFigures
from cncgen.report.tables import number, text_table
from cncgen.servo.named_schemes import scheme_maker
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


def interpolator_table(fluctuations: Iterable[Fluctuation]) -> str:
    """Return the feedrate fluctuation of each interpolator: travelled against commanded distance per period."""
    rows = [
        [f.interpolator, f"{100 * f.max_part:.3g}", f"{100 * f.rms_part:.3g}", f"{f.time_s:.4f}"]
        for f in fluctuations
    ]
    return text_table(("interpolator", "fluctuation max %", "rms %", "time s"), rows)


def compare_controllers(
    setpoints: Sequence[Setpoints], servos: Mapping[str, Servo], names: Sequence[str]
) -> list[dict[str, Any]]:
    """Simulate the same setpoints under controllers by name; return the summary of each, with ``controller``.

    Raises:
        UsageError: A name is unknown, or a controller cannot be had for the axes.
    """
    return [
        {"controller": name, **summarize(simulate_scheme(iter(setpoints), scheme_maker(name, servos)))}
        for name in names
    ]


def controller_table(summaries: Sequence[Mapping[str, Any]]) -> str:
    """Return contour error, tracking errors, speed variation and saturation of each controller."""
    letters = list(summaries[0]["axes"]) if summaries else []
    header = ["controller", "contour max µm", "contour rms µm"]
    header += [f"{k.upper()} tracking rms {'µm' if file_unit(k) == 'mm' else 'mdeg'}" for k in letters]
    header += ["speed variation mm/s", "saturated"]
    rows = []
    for s in summaries:
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
    return text_table(header, rows)
