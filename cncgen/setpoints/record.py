"""The stream record: positions of the axes, one row a period."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cncgen.shown import html_of
from cncgen.toolpath.record import Event

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Setpoints:
    """A chunk of the setpoint stream: row `i` holds at ``(first + i) * period_s``.

    Attributes:
        axes: Letters of the columns.
        period_s: Time between rows.
        first: Index of the first row in the whole stream.
        position: Shape (n, axes), mm or rad.
        signals: Further columns by name, where they were asked for. ``vel``, ``acc`` and ``jerk`` have the shape (n, axes).
            The others have the shape (n,): ``feed`` (mm/s along the path), ``programmed`` (the feed that the program asks
            for, 0 in a rapid), ``line``, ``source`` (the file of the line, 0 for the program) and ``limit`` (a
            `cncgen.planner.record.Limit`).
        events: Pairs of time and `Event` with the source line, that fall into this chunk.
    """

    axes: str
    period_s: float
    first: int
    position: Floats
    signals: Mapping[str, NDArray] = field(default_factory=dict)
    events: tuple[tuple[float, int, Event], ...] = ()

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        more = f", signals {', '.join(self.signals)}" if self.signals else ""
        rows = f"{len(self)} rows from {self.first}"
        return f"Setpoints({rows}, axes {self.axes}, every {1e3 * self.period_s:g} ms{more})"

    def _repr_html_(self) -> str | None:
        return html_of(self)

    @property
    def time_s(self) -> Floats:
        """Shape (n,): time of each row."""
        rows = np.arange(self.first, self.first + len(self), dtype=np.float64)
        return rows * self.period_s
