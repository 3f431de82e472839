"""The record of a closed-loop simulation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.shown import html_of

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Response:
    """A chunk of the response of the servo axes to setpoints; row `i` holds at ``(first + i) * period_s``.

    Attributes:
        axes: Letters of the columns.
        period_s: Time between rows.
        first: Index of the first row.
        command: Shape (n, axes), mm or rad: the setpoints.
        position: Shape (n, axes): where the axes are.
        force: Shape (n, axes): the controller's demand on the drive, after its saturation.
        force_unit: Unit of each column of `force` (``V``, ``N·m``, ``mm/s`` …).
        saturated: Shape (n, axes), bool.
        contour_error_mm: Shape (n,): distance of the position from the commanded path, unsigned.
        tool_length_mm: Shape (n,): the offset of the tool along the spindle, if contour errors are those of its tip on the workpiece;
            None: they are those of X Y Z (U V W without them).
    """

    axes: str
    period_s: float
    first: int
    command: Floats
    position: Floats
    force: Floats
    force_unit: tuple[str, ...]
    saturated: NDArray[np.bool_]
    contour_error_mm: Floats
    tool_length_mm: Floats | None = None

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        return f"Response({len(self)} rows from {self.first}, axes {self.axes}, every {1e3 * self.period_s:g} ms)"

    def _repr_html_(self) -> str | None:
        return html_of(self)
