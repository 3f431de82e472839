"""csp: CiA 402 cyclic synchronous position as CSV: the time, then 607Ah, 60B0h, 60B1h and 60B2h of each axis as integers.

The first line is a comment with a JSON object: period, axes, and the scaling of each drive.
"""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray

from cncgen.files import Sink
from cncgen.setpoints.columns import Layout
from cncgen.setpoints.drive_units import FrameMaker, description, frame_type
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers.text_rows import RowText


class Writer:
    """Writes ``t_s,x_607a,x_60b0,…`` and its rows."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        self._sink, self._period = sink, layout.period_s
        self._first: int | None = None
        self._frames = FrameMaker(layout.axes, layout.period_s, layout.drives)
        about = {**description(layout.axes, layout.period_s, layout.drives), **layout.metadata}
        names = ["t_s", *(frame_type(layout.axes).names or ())]
        self._text = RowText(["", *[","] * (len(names) - 1), "\n"], [9, *[0] * (len(names) - 1)])
        sink.write(f"# {json.dumps(about)}\n{','.join(names)}\n".encode())

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk but its last, which waits for the next chunk."""
        if self._first is None:
            self._first = chunk.first
        self._send(self._frames.frames(chunk))

    def _send(self, frames: NDArray[np.void]) -> None:
        first = self._first or 0
        times = np.arange(first, first + len(frames)) * self._period
        columns = [times, *(frames[name] for name in frames.dtype.names or ())]
        self._sink.write(self._text.format(np.ascontiguousarray(np.stack(columns, axis=1), np.float64)))
        self._first = first + len(frames)

    def close(self) -> None:
        """Write the last row."""
        last = self._frames.last()
        if len(last):
            self._send(last)
