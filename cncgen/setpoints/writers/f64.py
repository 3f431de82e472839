"""f64: the columns of the CSV as raw little-endian doubles, row by row, with no header."""

from __future__ import annotations

from cncgen.files import Sink
from cncgen.setpoints.columns import Layout, check_finite
from cncgen.setpoints.record import Setpoints


class Writer:
    """Writes rows of 8-byte doubles."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        self._sink, self._layout = sink, layout

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        matrix = self._layout.matrix(chunk)
        check_finite(matrix, self._layout.names, chunk.first)
        self._sink.write(matrix.astype("<f8", copy=False).tobytes())

    def close(self) -> None:
        """Nothing follows the last row."""
