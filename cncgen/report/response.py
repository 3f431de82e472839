"""What a simulation says: the response CSV, and its summary gathered while it streams by."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.files import open_output
from cncgen.servo.record import Response
from cncgen.setpoints.columns import file_units
from cncgen.setpoints.writers.text_rows import RowText
from cncgen.units import file_unit

Floats = NDArray[np.float64]

SCHEMA_VERSION = 1


def column_names(axes: str) -> list[str]:
    """Return the columns of a response CSV (interface.md, Simulation response CSV)."""
    names = ["t_s"]
    for axis in axes:
        low, unit = axis.lower(), file_unit(axis)
        names += [f"{low}_cmd_{unit}", f"{low}_{unit}", f"{low}_force", f"{low}_saturated"]
    return [*names, "contour_error_mm"]


def write_responses(responses: Iterable[Response], path: str | os.PathLike[str] | None) -> None:
    """Write a response as CSV, whole or not at all (to standard output for None).

    A contour error that is not defined (rotary axes alone) is written as 0.
    """
    text: RowText | None = None
    with open_output(path) as sink:
        for response in responses:
            if text is None:
                names = column_names(response.axes)
                sink.write((",".join(names) + "\n").encode())
                decimals = [0 if name.endswith("_saturated") else 9 for name in names]
                text = RowText(["", *[","] * (len(names) - 1), "\n"], decimals)
            sink.write(text.format(_matrix(response)))


def _matrix(response: Response) -> Floats:
    time_s = (response.first + np.arange(len(response))) * response.period_s
    command, position = (
        file_units(response.command, response.axes),
        file_units(response.position, response.axes),
    )
    parts = [time_s]
    for k in range(len(response.axes)):
        parts += [
            command[:, k],
            position[:, k],
            response.force[:, k],
            response.saturated[:, k].astype(np.float64),
        ]
    parts.append(np.nan_to_num(response.contour_error_mm))
    return np.ascontiguousarray(np.column_stack(parts))


class ResponseSummary:
    """Tracking error, contour error, speed variation and saturation of a response that streams by."""

    def __init__(self, setpoints: str, servos: Any, axes: str, period_s: float) -> None:
        self._setpoints, self._servos, self._axes, self._period_s = setpoints, servos, axes, period_s
        count = len(axes)
        self._rows = 0
        self._error_max, self._error_squares = np.zeros(count), np.zeros(count)
        self._contour_max = self._contour_squares = 0.0
        self._contour_rows = 0
        self._saturated = np.zeros(count, np.int64)
        self._units: tuple[str, ...] = ()
        self._speed = _SpeedRatio([k for k, axis in enumerate(axes) if axis in "XYZ"], period_s)

    def over(self, responses: Iterable[Response]) -> Iterator[Response]:
        """Hand on the chunks of a response, taking their figures."""
        for response in responses:
            self._add(response)
            yield response

    def _add(self, response: Response) -> None:
        error = file_units(response.command - response.position, response.axes)
        self._rows += len(response)
        self._error_max = np.maximum(self._error_max, np.abs(error).max(axis=0, initial=0.0))
        self._error_squares += (error**2).sum(axis=0)
        contour = response.contour_error_mm[np.isfinite(response.contour_error_mm)]
        self._contour_max = max(self._contour_max, float(np.abs(contour).max(initial=0.0)))
        self._contour_squares += float((contour**2).sum())
        self._contour_rows += len(contour)
        self._saturated += response.saturated.sum(axis=0)
        self._units = response.force_unit
        self._speed.add(response)

    def as_json(self) -> dict[str, Any]:
        """Return plain values: per axis tracking error and saturated samples, contour error, speed variation."""
        axes = {}
        for k, letter in enumerate(self._axes):
            unit = file_unit(letter)
            axes[letter.lower()] = {
                f"tracking_error_rms_{unit}": float(np.sqrt(self._error_squares[k] / max(self._rows, 1))),
                f"tracking_error_max_{unit}": float(self._error_max[k]),
                "saturated_samples": int(self._saturated[k]),
                "force_unit": self._units[k] if self._units else None,
            }
        rows = self._contour_rows
        return {
            "schema_version": SCHEMA_VERSION,
            "setpoints": self._setpoints,
            "axis_params": str(self._servos),
            "samples": self._rows,
            "period_s": self._period_s,
            "axes": axes,
            "contour_error_rms_mm": float(np.sqrt(self._contour_squares / rows)) if rows else None,
            "contour_error_max_mm": self._contour_max if rows else None,
            "speed_variation_rms_mm_s": self._speed.rms,
            "saturated_samples": int(self._saturated.sum()),
        }


class _SpeedRatio:
    """Root mean square of the difference between travelled and commanded speed along X Y Z."""

    def __init__(self, columns: list[int], period_s: float) -> None:
        self._columns, self._period_s = columns, period_s
        self._squares, self._rows = 0.0, 0
        self._tail: tuple[Floats, Floats] | None = None

    def add(self, response: Response) -> None:
        """Take a chunk."""
        if not self._columns or not len(response):
            return
        command, position = response.command[:, self._columns], response.position[:, self._columns]
        if self._tail is not None:
            command = np.concatenate([self._tail[0], command])
            position = np.concatenate([self._tail[1], position])
        speeds = [np.linalg.norm(np.diff(x, axis=0), axis=1) / self._period_s for x in (command, position)]
        self._squares += float(((speeds[1] - speeds[0]) ** 2).sum())
        self._rows += len(speeds[0])
        self._tail = command[-1:], position[-1:]

    @property
    def rms(self) -> float | None:
        """The figure in mm/s, or None without X Y Z."""
        return float(np.sqrt(self._squares / self._rows)) if self._rows else None


def as_text(summary: dict[str, Any]) -> str:
    """Return the summary as the lines that a person reads."""
    lines = [f"{summary['samples']} samples simulated with {summary['axis_params']}"]
    for letter, axis in summary["axes"].items():
        unit = file_unit(letter)
        lines.append(
            f"  {letter.upper()}: tracking error rms {1000 * axis[f'tracking_error_rms_{unit}']:.3f}, "
            f"max {1000 * axis[f'tracking_error_max_{unit}']:.3f} {'µm' if unit == 'mm' else 'mdeg'}; "
            f"{axis['saturated_samples']} saturated samples"
        )
    if summary["contour_error_max_mm"] is not None:
        lines.append(
            f"contour error rms {1000 * summary['contour_error_rms_mm']:.3f}, "
            f"max {1000 * summary['contour_error_max_mm']:.3f} µm; "
            f"speed variation rms {summary['speed_variation_rms_mm_s'] or 0.0:.4f} mm/s"
        )
    return "\n".join(lines)
