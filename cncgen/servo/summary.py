"""Figures of a simulated response: tracking and contour error, speed variation, saturation."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.record import Response
from cncgen.servo.response_csv import force_in_files
from cncgen.servo.simulate import contour_axes
from cncgen.units import file_unit, to_file

Floats = NDArray[np.float64]


class _Moments:
    """Count, sum of squares, largest magnitude and where it was."""

    def __init__(self) -> None:
        self.count = 0
        self.square = 0.0
        self.largest = 0.0
        self.row = 0

    def add(self, values: Floats, first: int) -> None:
        finite = np.abs(values[np.isfinite(values)])
        if not len(finite):
            return
        self.count += len(finite)
        self.square += float(finite @ finite)
        if finite.max() > self.largest or self.count == len(finite):
            self.row = first + int(np.nanargmax(np.abs(values)))
            self.largest = float(finite.max())

    @property
    def rms(self) -> float:
        return math.sqrt(self.square / self.count) if self.count else 0.0


class ResponseSummary:
    """Gathers a response chunk by chunk: `add` each, then `as_dict`."""

    def __init__(self) -> None:
        self._axes = ""
        self._period = 0.0
        self._units: tuple[str, ...] = ()
        self._rows = 0
        self._tracking: list[_Moments] = []
        self._force: list[_Moments] = []
        self._saturated: list[int] = []
        self._contour, self._of_tip = _Moments(), False
        self._speed = _Moments()
        self._last: tuple[Floats, Floats] | None = None

    def add(self, response: Response) -> None:
        """Take one chunk in."""
        if not self._axes:
            self._axes, self._period, self._units = (
                response.axes,
                response.period_s,
                force_in_files(response)[1],
            )
            self._tracking = [_Moments() for _ in response.axes]
            self._force = [_Moments() for _ in response.axes]
            self._saturated = [0] * len(response.axes)
        self._rows += len(response)
        force, _ = force_in_files(response)
        for i in range(len(self._axes)):
            self._tracking[i].add(response.command[:, i] - response.position[:, i], response.first)
            self._force[i].add(force[:, i], response.first)
            self._saturated[i] += int(response.saturated[:, i].sum())
        self._contour.add(response.contour_error_mm, response.first)
        self._of_tip = response.tool_length_mm is not None
        self._add_speed(response)

    def _add_speed(self, response: Response) -> None:
        columns = contour_axes(response.axes)
        rows = response.command[:, columns], response.position[:, columns]
        if self._last is not None:
            rows = tuple(np.concatenate([a, b]) for a, b in zip(self._last, rows, strict=True))  # type: ignore[assignment]
        self._last = rows[0][-1:], rows[1][-1:]
        wanted, actual = (path_speed(part, response.period_s) for part in rows)
        self._speed.add(actual - wanted, response.first)

    def as_dict(self) -> dict[str, Any]:
        """Return plain values: the summary of a simulation (``--summary``); lengths in mm (deg for rotary axes)."""
        axes: dict[str, Any] = {}
        for i, letter in enumerate(self._axes):
            unit, factor = file_unit(letter), to_file(letter)
            tracking = self._tracking[i]
            axes[letter.lower()] = {
                f"tracking_rms_{unit}": tracking.rms * factor,
                f"tracking_max_{unit}": tracking.largest * factor,
                "tracking_max_t_s": tracking.row * self._period,
                "force_max": self._force[i].largest,
                "force_unit": self._units[i],
                "saturated_samples": self._saturated[i],
            }
        return {
            "samples": self._rows,
            "period_s": self._period,
            "axes": axes,
            "contour_error_rms_mm": self._contour.rms if self._contour.count else None,
            "contour_error_max_mm": self._contour.largest if self._contour.count else None,
            "contour_error_max_t_s": self._contour.row * self._period,
            "contour_error_of": "tip"
            if self._of_tip
            else "".join(self._axes[k] for k in contour_axes(self._axes)),
            "speed_variation_mm_s": self._speed.rms,
            "saturated_samples": sum(self._saturated),
        }


def path_speed(position: Floats, period_s: float) -> Floats:
    """Return the speed between consecutive positions, shape (n − 1,), of positions (n, axes)."""
    return np.sqrt((np.diff(position, axis=0) ** 2).sum(axis=1)) / period_s


def summarize(responses: Iterable[Response]) -> dict[str, Any]:
    """Return the summary of a whole response."""
    summary = ResponseSummary()
    for response in responses:
        summary.add(response)
    return summary.as_dict()


def watched(responses: Iterable[Response], summary: ResponseSummary) -> Iterator[Response]:
    """Yield each chunk on after the summary has taken it in."""
    for response in responses:
        summary.add(response)
        yield response
