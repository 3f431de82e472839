"""Finite differences of setpoints against the limits of each axis, with rest before the first and after the last."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostics, Severity
from cncgen.machine.record import Axis, Machine
from cncgen.units import file_unit, to_file
from cncgen.verify.verdict import ORDERS, Peak, breach

Floats = NDArray[np.float64]

#: A difference is over its limit beyond this part of it.
MARGIN = 1.001

_SUPERSCRIPT = {"": "", "2": "²", "3": "³"}

#: Unit of the ninth decimal, which a position in a text file of ours is rounded to.
RESOLUTION = 1e-9


def judge_limits(
    position: Floats,
    axes: str,
    period_s: float,
    machine: Machine,
    lines: NDArray[np.int64],
    resolution: float = RESOLUTION,
) -> tuple[list[Peak], Diagnostics]:
    """Judge finite differences of orders 1 to 3, and travel.

    Args:
        position: Shape (n, axes), mm and degrees.
        axes: Letters of the columns.
        period_s: Time between rows.
        machine: Limits.
        lines: Shape (n,), source line at each sample.
        resolution: What positions are rounded to, mm and degrees.

    Returns:
        Three peaks an axis, and a diagnostic for each order and axis that is over its limit, and for travel. A k-th
        difference may be over by what rounding can make of it, 2ᵏ (resolution / 2) / Tᵏ.
    """
    peaks: list[Peak] = []
    breaches = Diagnostics()
    for column, letter in enumerate(axes):
        x = position[:, column]
        axis = machine.axes.get(letter)
        if axis is None:
            if np.ptp(x) > resolution:
                message = f"axis {letter} moves, and machine {machine.name} has none"
                breaches.add(breach("axis", message, axis=letter))
            continue
        peaks += _differences(x, axis, period_s, lines, breaches, resolution)
        _judge_travel(x, axis, period_s, lines, breaches, resolution)
    return peaks, breaches


def _differences(
    x: Floats,
    axis: Axis,
    period_s: float,
    lines: NDArray[np.int64],
    breaches: Diagnostics,
    resolution: float,
) -> list[Peak]:
    unit, factor = file_unit(axis.letter), to_file(axis.letter)
    limits = (axis.max_velocity, axis.max_acceleration, axis.max_jerk)
    padded = np.concatenate([np.repeat(x[:1], 3), x, np.repeat(x[-1:], 3)])
    peaks = []
    difference = padded
    for k, ((order, power), limit) in enumerate(zip(ORDERS, limits, strict=True), start=1):
        limit *= factor
        difference = np.diff(difference)
        size = np.abs(difference) / period_s**k
        worst = int(np.argmax(size))
        # Row `r` of a k-th difference spans samples r - 3 to r - 3 + k of the stream; its middle is the place.
        sample = int(np.clip(worst - 3 + (k + 1) // 2, 0, len(x) - 1))
        rounding = 2.0**k * 0.5 * resolution / period_s**k
        over = size > limit * MARGIN + rounding
        peak = Peak(
            axis.letter,
            order,
            float(size[worst]),
            limit,
            sample * period_s,
            int(lines[sample]),
            int(over.sum()),
        )
        peaks.append(peak)
        if rounding > limit:
            message = (
                f"axis {axis.letter}: {order} is not judged: rounding positions to {resolution:g} {unit} alone makes up to "
                f"{rounding:.3g} {unit}/s{_SUPERSCRIPT[power]} of it at this period"
            )
            breaches.add(replace(breach("rounding", message, axis=axis.letter), severity=Severity.NOTE))
        if peak.broken:
            found = breach(
                order,
                f"axis {axis.letter}: {order} {peak.value:.6g} {unit}/s{_SUPERSCRIPT[power]} at t = {peak.t_s:.4f} s "
                f"(line {peak.line}), {100 * (peak.of_limit - 1):.3g} % over the limit of {limit:.6g}; "
                f"{peak.broken} samples are over it",
                axis=axis.letter,
                value=peak.value,
                limit=limit,
                t_s=peak.t_s,
                line=peak.line,
                samples=peak.broken,
            )
            breaches.add(replace(found, hint=_rounding_hint(x, resolution)))
    return peaks


def _rounding_hint(x: Floats, resolution: float) -> str:
    """Say where positions have fewer decimals than the resolution they are judged with."""
    for decimals in range(2, 9):
        unit = 10.0**-decimals
        if unit > 1.5 * resolution and np.all(np.abs(x - np.round(x, decimals)) < 1e-3 * unit):
            return f"the positions have {decimals} decimals: --resolution {unit:g} allows for their rounding"
    return ""


def _judge_travel(
    x: Floats,
    axis: Axis,
    period_s: float,
    lines: NDArray[np.int64],
    breaches: Diagnostics,
    resolution: float,
) -> None:
    if axis.travel is None:
        return
    unit, factor = file_unit(axis.letter), to_file(axis.letter)
    low, high = axis.travel[0] * factor, axis.travel[1] * factor
    outside = np.maximum(low - x, x - high)
    worst = int(np.argmax(outside))
    if outside[worst] > resolution:
        breaches.add(
            breach(
                "travel",
                f"axis {axis.letter}: position {x[worst]:.6f} {unit} at t = {worst * period_s:.4f} s "
                f"(line {lines[worst]}) is outside the travel of {low:g} to {high:g} {unit}",
                axis=axis.letter,
                value=float(x[worst]),
                low=low,
                high=high,
                t_s=worst * period_s,
                line=int(lines[worst]),
            )
        )
