"""Finite differences of setpoints against the limits of each axis, with rest before the first and after the last."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostics, Severity
from cncgen.machine.record import Axis
from cncgen.units import ORDER_NAMES, ORDERS, file_unit, to_file
from cncgen.verify.verdict import Peak, breach, on_line

Floats = NDArray[np.float64]
Lines = NDArray[np.int64]

#: A difference is over its limit beyond this part of it.
MARGIN = 1.001

#: Unit of the ninth decimal, which a position in a text file of ours is rounded to.
RESOLUTION = 1e-9


@dataclass(slots=True)
class _Order:
    """One order of difference of one axis: its limit, what rounding may add, the worst one so far."""

    name: str
    limit: float
    rounding: float
    value: float = 0.0
    sample: int = 0
    line: int = 0
    over: int = 0


class AxisJudge:
    """The finite differences of one axis, and its travel, as its positions come in.

    A k-th difference may exceed its limit by the effect of rounding, 2ᵏ (resolution / 2 + ε) / Tᵏ. Here ε is the distance
    of neighbouring doubles at the farthest position: half of it where a position was computed, half where it was read.
    """

    def __init__(self, axis: Axis, period_s: float, resolution: float) -> None:
        """Begin.

        Args:
            axis: Limits.
            period_s: Time between rows.
            resolution: Rounding of positions, mm or degrees.
        """
        factor = to_file(axis.letter)
        self._axis, self._period, self._resolution = axis, period_s, resolution
        limits = (axis.max_velocity, axis.max_acceleration, axis.max_jerk)
        self._orders = [
            _Order(name, limit * factor, 2.0**k * 0.5 * resolution / period_s**k)
            for k, (name, limit) in enumerate(zip(ORDER_NAMES, limits, strict=True), start=1)
        ]
        self._travel = None if axis.travel is None else tuple(factor * end for end in axis.travel)
        self._outside = (0.0, 0.0, 0, 0)  # By how much; position, sample, line.
        self._decimals = list(range(2, 9))
        self._count = 0
        self._before: Floats = np.zeros(0)
        self._lines: Lines = np.zeros(0, np.int64)

    def feed(self, x: Floats, lines: Lines) -> None:
        """Add positions, in mm or degrees, and the source line of each."""
        if not len(x):
            return
        if not self._count:
            self._before, self._lines = np.repeat(x[:1], 3), np.repeat(lines[:1], 3)
        self._differences(x, lines)
        self._look_outside(x, lines)
        for decimals in self._decimals[:]:
            unit = 10.0**-decimals
            if unit <= 1.5 * self._resolution or np.any(np.abs(x - np.round(x, decimals)) >= 1e-3 * unit):
                self._decimals.remove(decimals)
        self._count += len(x)

    def finish(self) -> tuple[list[Peak], Diagnostics]:
        """Come to rest; return a peak an order, and a diagnostic for each limit that is broken."""
        if self._count:
            self._differences(np.repeat(self._before[-1:], 3), np.repeat(self._lines[-1:], 3))
        breaches = Diagnostics()
        peaks = []
        for order, (_, power) in zip(self._orders, ORDERS, strict=True):
            peaks.append(self._peak(order))
            self._report(order, power, peaks[-1], breaches)
        self._report_travel(breaches)
        return peaks, breaches

    def _differences(self, x: Floats, lines: Lines) -> None:
        difference = np.concatenate([self._before, x])
        spacing = float(np.spacing(np.abs(difference).max()))
        around = np.concatenate([self._lines, lines])
        for k, order in enumerate(self._orders, start=1):
            difference = np.diff(difference)
            # Only differences that end with a new sample: row r ends with row r + k of `around`.
            size = np.abs(difference[3 - k :]) / self._period**k
            worst = int(np.argmax(size))
            if size[worst] > order.value:
                # The middle of samples g - k … g is the place.
                back = k - (k + 1) // 2
                order.value, order.sample = float(size[worst]), self._count + worst - back
                order.line = int(around[3 + worst - back])
            rounding = order.rounding + 2.0**k * spacing / self._period**k
            order.over += int(np.count_nonzero(size > order.limit * MARGIN + rounding))
        self._before, self._lines = np.concatenate([self._before, x])[-3:], around[-3:]

    def _look_outside(self, x: Floats, lines: Lines) -> None:
        if self._travel is None:
            return
        outside = np.maximum(self._travel[0] - x, x - self._travel[1])
        worst = int(np.argmax(outside))
        if outside[worst] > self._outside[0]:
            self._outside = (float(outside[worst]), float(x[worst]), self._count + worst, int(lines[worst]))

    def _peak(self, order: _Order) -> Peak:
        sample = min(max(order.sample, 0), max(self._count - 1, 0))
        time_s = sample * self._period
        return Peak(self._axis.letter, order.name, order.value, order.limit, time_s, order.line, order.over)

    def _report(self, order: _Order, power: str, peak: Peak, breaches: Diagnostics) -> None:
        letter, unit = self._axis.letter, file_unit(self._axis.letter)
        if order.rounding > order.limit:
            message = (
                f"axis {letter}: {order.name} is not judged: rounding positions to {self._resolution:g} {unit} alone "
                f"makes up to {order.rounding:.3g} {unit}/s{power} of it at this period"
            )
            breaches.add(replace(breach("rounding", message, axis=letter), severity=Severity.NOTE))
        if peak.broken:
            found = breach(
                order.name,
                f"axis {letter}: {order.name} {peak.value:.6g} {unit}/s{power} at t = {peak.t_s:.4f} s "
                f"{on_line(peak.line)}, {100 * (peak.of_limit - 1):.3g} % over the limit of {order.limit:.6g}; "
                f"{peak.broken} samples are over it",
                axis=letter,
                value=peak.value,
                limit=order.limit,
                t_s=peak.t_s,
                line=peak.line,
                samples=peak.broken,
            )
            breaches.add(replace(found, hint=self._rounding_hint()))

    def _rounding_hint(self) -> str:
        """Say where positions have fewer decimals than the resolution they are judged with."""
        if not self._decimals:
            return ""
        decimals = self._decimals[0]
        unit = 10.0**-decimals
        return f"the positions have {decimals} decimals: --resolution {unit:g} allows for their rounding"

    def _report_travel(self, breaches: Diagnostics) -> None:
        outside, position, sample, line = self._outside
        if self._travel is None or not outside > self._resolution:
            return
        unit, (low, high) = file_unit(self._axis.letter), self._travel
        t_s = sample * self._period
        breaches.add(
            breach(
                "travel",
                f"axis {self._axis.letter}: position {position:.6f} {unit} at t = {t_s:.4f} s "
                f"{on_line(line)} is outside the travel of {low:g} to {high:g} {unit}",
                axis=self._axis.letter,
                value=position,
                low=low,
                high=high,
                t_s=t_s,
                line=line,
            )
        )
