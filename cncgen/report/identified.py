"""Identification for users: from a log to servo tables and a text with fit and uncertainty."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cncgen.diagnostics import Diagnostic, Severity, UsageError
from cncgen.machine.record import Servo
from cncgen.servo.identification.etfe import etfe
from cncgen.servo.identification.fits import Fit, fit_first_order, fit_fourth_order, fit_velocity_loop
from cncgen.servo.identification.log import AxisLog, read_log
from cncgen.servo.identified_spread import SERVO_MODELS, servo_values
from cncgen.servo.models import axis_loop
from cncgen.units import file_unit

#: A fit below it leaves half of the motion's size unexplained: its parameters mean nothing.
POOR_FIT_PERCENT = 50.0


@dataclass(frozen=True, slots=True)
class Identified:
    """Servo tables (or a CSV table), the text for a person, plain values for the summary, and warnings."""

    table: str
    text: str
    values: dict[str, Any]
    remarks: tuple[Diagnostic, ...] = ()


def identified(
    path: str, model: str, letter: str | None, friction: bool = True, motor_scale: float | None = None
) -> Identified:
    """Fit a model to a log.

    Args:
        path: The log.
        model: ``velocity-loop``, ``first-order``, ``fourth-order`` or ``etfe``.
        letter: One axis, or None for all of the log.
        friction: Whether Coulomb friction is fitted.
        motor_scale: Counts a mm over counts a radian: the gain is given as Kc of a torque-mode motor too.

    Raises:
        UsageError: The log cannot be used (``log-…``), lacks a column (``log-columns``), or no fit is found
            (``identify-fit``).
    """
    log = read_log(path)
    if letter is not None and letter not in log:
        raise UsageError(Diagnostic("log-columns", f"{path} has no axis {letter}; it has {', '.join(log)}"))
    tables, texts, values = [], [], {}
    for axis in [log[letter]] if letter else log.values():
        try:
            # Overflows on the way do no harm: a fit that ends at numbers that are not finite is refused.
            with np.errstate(all="ignore"):
                table, text, found = (
                    _response(axis) if model == "etfe" else _fitted(axis, model, friction, motor_scale)
                )
        except ValueError as error:
            raise UsageError(Diagnostic("identify-fit", f"axis {axis.letter}: {error}")) from error
        tables.append(table)
        texts.append(text)
        values[axis.letter.lower()] = found
    return Identified(
        "\n".join(tables),
        "\n".join(texts),
        {"schema_version": 1, "log": path, "model": model, "axes": values},
        tuple(_poor(letter, found["fit_percent"]) for letter, found in values.items() if _is_poor(found))
        + tuple(_vague(letter, names) for letter, found in values.items() if (names := _undetermined(found)))
        + tuple(
            _runs_away(letter, size)
            for letter, found in values.items()
            if (size := found.get("largest_pole", 0.0)) >= 1.0
        ),
    )


def _is_poor(found: dict[str, Any]) -> bool:
    """Tell whether the model of an axis is hardly that of its log (nor is a fit of NaN good)."""
    return "fit_percent" in found and not found["fit_percent"] >= POOR_FIT_PERCENT


def _undetermined(found: dict[str, Any]) -> list[str]:
    """Return the names of the parameters that the log of an axis does not determine."""
    return [name for name, spread in found.get("uncertainty", {}).items() if not math.isfinite(spread)]


def _vague(letter: str, names: list[str]) -> Diagnostic:
    return Diagnostic(
        "identify-undetermined",
        f"axis {letter.upper()}: the log does not determine {', '.join(names)}: other values follow it as well",
        severity=Severity.WARNING,
        hint="a log of motion to and fro over a band of frequencies does (cncgen excite)",
        values={"axis": letter.upper(), "parameters": names},
    )


def _poor(letter: str, percent: float) -> Diagnostic:
    return Diagnostic(
        "identify-poor",
        f"axis {letter.upper()}: the model explains little of the log: fit {percent:.3g} %, below "
        f"{POOR_FIT_PERCENT:g} %",
        severity=Severity.WARNING,
        hint="is it the right --model, and does the drive move the axis in this log (cncgen excite)?",
        values={"axis": letter.upper(), "fit_percent": percent},
    )


def _runs_away(letter: str, size: float) -> Diagnostic:
    return Diagnostic(
        "identify-unstable",
        f"axis {letter.upper()}: the fitted loop is unstable as it is sampled (a pole at |z| = {size:.6g}), and the axis of the log is not",
        severity=Severity.WARNING,
        hint="the model lacks something that the axis has, feedforward or an integrator say: try --model fourth-order",
        values={"axis": letter.upper(), "largest_pole": size},
    )


def _column(axis: AxisLog, name: str) -> Any:
    values = getattr(axis, name)
    if values is None:
        low = axis.letter.lower()
        column = f"{low}_force" if name == "drive" else f"{low}_cmd_{file_unit(axis.letter)}"
        raise UsageError(
            Diagnostic(
                "log-columns",
                f"the model needs the column {column}, and the log has none",
                hint="a log has t_s, the command x_cmd_mm and the position x_mm, as cncgen simulate writes them",
            )
        )
    return values


def _fitted(
    axis: AxisLog, model: str, friction: bool, motor_scale: float | None
) -> tuple[str, str, dict[str, Any]]:
    if model == "velocity-loop":
        fit = fit_velocity_loop(_column(axis, "drive"), axis.position, axis.period_s, friction=friction)
    elif model == "first-order":
        fit = fit_first_order(_column(axis, "command"), axis.position, axis.period_s, friction=friction)
    else:
        fit = fit_fourth_order(_column(axis, "command"), axis.position, axis.period_s)
    values: dict[str, Any] = {
        "parameters": dict(fit.parameters),
        "uncertainty": dict(fit.uncertainty),
        "covariance": fit.covariance.as_json(),
        "fit_percent": fit.fit_percent,
        "residual_rms": fit.residual_rms,
    }
    if fit.model != "velocity-loop":
        servo = Servo(SERVO_MODELS[fit.model], servo_values(axis.letter, fit.model, fit.parameters))
        values["largest_pole"] = float(np.abs(axis_loop(servo, axis.letter, axis.period_s).poles()).max())
    lines = [
        f"{axis.letter}: {fit.model}, fit {fit.fit_percent:.3f} %, residual rms {1e3 * fit.residual_rms:.4g} µm"
    ]
    lines += [f"  {k} = {v:.6g} ± {fit.uncertainty[k]:.2g}" for k, v in fit.parameters.items()]
    if motor_scale is not None and "gain" in fit.parameters:
        kc, spread = (d["gain"] * motor_scale for d in (fit.parameters, fit.uncertainty))
        values["velocity_gain_rad_s_volt"] = kc
        lines.append(f"  velocity_gain_rad_s_volt (Kc) = {kc:.6g} ± {spread:.2g}")
    return _servo_table(axis.letter, fit), "\n".join(lines), values


def _servo_table(letter: str, fit: Fit) -> str:
    """Return a fit as a table of a machine file; a velocity loop gets P control as a start."""
    head = f"# fit {fit.fit_percent:.3f} %, residual rms {fit.residual_rms:.3g}"
    lines = [f"[axes.{letter.lower()}.servo]", f'model = "{SERVO_MODELS[fit.model]}"']
    if fit.model == "velocity-loop":
        notes = [
            f"# {name} = {value!r} ± {fit.uncertainty[name]:.2g} in mm, rad and s"
            for name, value in fit.parameters.items()
        ]
        lines = notes + lines
    values = servo_values(letter, fit.model, fit.parameters)
    lines += [f"{key} = {value!r}" for key, value in values.items()]
    if fit.model == "velocity-loop":
        gain, lag = values["numerator"][0], fit.parameters["time_constant_s"]
        lines.append(
            f"position_gain_1_{file_unit(letter)} = {1.0 / (4.0 * lag * gain)!r}"
            "  # a start: P control, critically damped; cncgen tune places PD"
        )
    return head + "\n" + "\n".join(lines) + "\n"


def _response(axis: AxisLog) -> tuple[str, str, dict[str, Any]]:
    source = axis.drive if axis.drive is not None else _column(axis, "command")
    found = etfe(source, axis.position, axis.period_s)
    rows = ["frequency_hz,magnitude,phase_deg,coherence,relative_error"]
    for f, h, gamma, error in zip(
        found.frequency_hz, found.response, found.coherence, found.relative_error, strict=True
    ):
        rows.append(
            f"{f:.6g},{abs(h):.6g},{math.degrees(math.atan2(h.imag, h.real)):.4f},{gamma:.6f},{error:.3g}"
        )
    good = found.coherence > 0.9
    band = (
        f"{found.frequency_hz[good].min():.3g} to {found.frequency_hz[good].max():.3g} Hz"
        if good.any()
        else "no band"
    )
    text = f"{axis.letter}: frequency response at {len(rows) - 1} frequencies; coherence above 0.9 in {band}"
    return "\n".join(rows) + "\n", text, {"frequencies": len(rows) - 1, "coherent_band": band}
