"""The response file: ``t_s``, per axis command, position, force and saturation, then the contour error."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from cncgen.files import Sink
from cncgen.servo.record import Response
from cncgen.servo.simulate import contour_axes
from cncgen.setpoints.columns import file_units
from cncgen.setpoints.writers.text_rows import RowText
from cncgen.units import DEGREE, file_unit

Floats = NDArray[np.float64]


def columns(axes: str) -> list[str]:
    """Return the header: ``t_s``, ``x_cmd_mm``, ``x_mm``, ``x_force``, ``x_saturated`` …, ``contour_error_mm``.

    The contour error is left out where no linear axis moves, since it is a distance from a path in space.
    """
    names = ["t_s"]
    for letter in axes.lower():
        unit = file_unit(letter)
        names += [f"{letter}_cmd_{unit}", f"{letter}_{unit}", f"{letter}_force", f"{letter}_saturated"]
    return [*names, "contour_error_mm"] if contour_axes(axes) else names


def matrix(response: Response) -> Floats:
    """Return the numbers of a chunk in the units of files, shape (n, columns); `columns` names them."""
    axes = response.axes
    time = (response.first + np.arange(len(response)))[:, None] * response.period_s
    command, position = file_units(response.command, axes), file_units(response.position, axes)
    force, _ = force_in_files(response)
    parts = np.stack([command, position, force, response.saturated], axis=2).reshape(len(response), -1)
    errors = [response.contour_error_mm[:, None]] if contour_axes(axes) else []
    return np.ascontiguousarray(np.concatenate([time, parts, *errors], axis=1))


def force_in_files(response: Response) -> tuple[Floats, tuple[str, ...]]:
    """Return forces, shape (n, axes), with radians as degrees, and their units."""
    turning = [unit.startswith("rad") for unit in response.force_unit]
    units = tuple(
        unit.replace("rad", "deg", 1) if t else unit
        for unit, t in zip(response.force_unit, turning, strict=True)
    )
    return np.where(turning, response.force / DEGREE, response.force), units


class ResponseWriter:
    """Writes a response to a sink, chunk by chunk; the header goes out with the first one."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._text: RowText | None = None

    def write(self, response: Response) -> None:
        """Write the rows of a chunk."""
        if self._text is None:
            names = columns(response.axes)
            commas = ["", *[","] * (len(names) - 1), "\n"]
            self._text = RowText(commas, [0 if name.endswith("_saturated") else 9 for name in names])
            self._sink.write((",".join(names) + "\n").encode())
        self._sink.write(self._text.format(matrix(response)))


def written(sink: Sink, responses: Iterable[Response]) -> Iterator[Response]:
    """Write each chunk and yield it on."""
    writer = ResponseWriter(sink)
    for response in responses:
        writer.write(response)
        yield response
