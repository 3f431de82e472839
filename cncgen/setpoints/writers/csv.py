"""CSV: a header, then a row a period; positions with nine decimals, correctly rounded."""

from __future__ import annotations

from cncgen.files import Sink
from cncgen.setpoints.columns import INTEGERS, Layout, check_finite
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers.text_rows import RowText


class Writer:
    """Writes ``t_s,x_mm,…`` and its rows."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        self._sink, self._layout, self._names = sink, layout, layout.names
        commas = ["", *[","] * (len(self._names) - 1), "\n"]
        self._text = RowText(commas, [0 if name in INTEGERS else 9 for name in self._names])
        sink.write((",".join(self._names) + "\n").encode())

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        matrix = self._layout.matrix(chunk)
        check_finite(matrix, self._names, chunk.first)
        self._sink.write(self._text.format(matrix))

    def close(self) -> None:
        """Nothing follows the last row."""
