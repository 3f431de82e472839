"""JSON lines: an object a period, its keys the columns of the CSV."""

from __future__ import annotations

from cncgen.files import Sink
from cncgen.setpoints.columns import INTEGERS, Layout, check_finite
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers.text_rows import RowText


class Writer:
    """Writes ``{"t_s": 0.000000000, "x_mm": …}`` lines."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        self._sink, self._layout, self._names = sink, layout, layout.names
        keys = [f', "{name}": ' for name in self._names]
        keys[0] = "{" + keys[0][2:]
        self._text = RowText([*keys, "}\n"], [0 if name in INTEGERS else 9 for name in self._names])

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        matrix = self._layout.matrix(chunk)
        check_finite(matrix, self._names, chunk.first)
        self._sink.write(self._text.format(matrix))

    def close(self) -> None:
        """Nothing follows the last row."""
