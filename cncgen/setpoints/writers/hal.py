"""HAL: the text that LinuxCNC's `halstreamer` reads, one line a servo period, one number a pin, axes alone.

The pins are floats in the order of the axes (``loadrt streamer cfg=ff`` for two), in mm and degrees; the comment on
the first line names them.
"""

from __future__ import annotations

import numpy as np

from cncgen.files import Sink
from cncgen.setpoints.columns import Layout, check_finite, file_units, position_column
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers.text_rows import RowText


class Writer:
    """Writes the positions separated by spaces."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        self._sink, self._axes = sink, layout.axes
        self._names = [position_column(axis) for axis in layout.axes]
        self._text = RowText(["", *[" "] * (len(self._axes) - 1), "\n"], [9] * len(self._axes))
        sink.write(f"# {' '.join(self._names)} every {layout.period_s:.9g} s\n".encode())

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        matrix = np.ascontiguousarray(file_units(chunk.position, self._axes))
        check_finite(matrix, self._names, chunk.first)
        self._sink.write(self._text.format(matrix))

    def close(self) -> None:
        """Nothing follows the last row."""
