"""A stream of setpoints with its data before the first row: axes, period, name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cncgen.arguments import undrawn, untouched
from cncgen.machine.record import Drive
from cncgen.setpoints.columns import Layout
from cncgen.setpoints.record import Setpoints


@dataclass(frozen=True, slots=True)
class SetpointStream:
    """Setpoints on their way, from a plan or from a file; the rows can be drawn once.

    Attributes:
        name: Where they come from: a file, a program.
        axes: Letters of the columns.
        period_s: Time between rows.
        chunks: The rows, in inside units.
        metadata: Text by key (program, machine, version) that files carry along.
        drives: Scaling of each axis's drive, where the machine has it.
    """

    name: str
    axes: str
    period_s: float
    chunks: Iterator[Setpoints]
    metadata: Mapping[str, str] = field(default_factory=dict)
    drives: Mapping[str, Drive] = field(default_factory=dict)

    def __iter__(self) -> Iterator[Setpoints]:
        return undrawn(self.chunks, repr(self))

    def __repr__(self) -> str:
        return f"SetpointStream({self.name!r}, axes {self.axes}, every {1e3 * self.period_s:g} ms)"

    def __reduce__(self) -> tuple[Any, ...]:
        """Refuse to be pickled or copied: its rows can be drawn once."""
        raise TypeError(f"{self!r} is drawn once and cannot be pickled; hand on what its collect() returns")

    def layout(self, signals: Sequence[str] = ()) -> Layout:
        """Return the columns of a file of these setpoints with some signals."""
        return Layout(self.axes, self.period_s, tuple(dict.fromkeys(signals)), self.metadata, self.drives)

    def collect(self) -> Setpoints:
        """Draw all rows; return them as one chunk, with their signals and events.

        Raises:
            UsageError: They, or some of them, were drawn already.
        """
        chunks = list(untouched(self.chunks, repr(self)))
        if not chunks:
            return Setpoints(self.axes, self.period_s, 0, np.zeros((0, len(self.axes))))
        signals = {name: np.concatenate([c.signals[name] for c in chunks]) for name in chunks[0].signals}
        events = tuple(event for chunk in chunks for event in chunk.events)
        position = np.concatenate([chunk.position for chunk in chunks])
        return Setpoints(self.axes, self.period_s, chunks[0].first, position, signals, events)
