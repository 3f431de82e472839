"""parquet: an Apache Parquet file, a row group a chunk, its columns those of the CSV (needs pyarrow)."""

from __future__ import annotations

from cncgen.files import Sink
from cncgen.setpoints.columns import Layout
from cncgen.setpoints.packages import needed
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers.arrow import BatchMaker, OpenSink


class Writer:
    """Writes row groups."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        self._batches = BatchMaker("parquet", layout)
        parquet = needed("parquet", "pyarrow.parquet")
        stream = self._batches.arrow.PythonFile(OpenSink(sink), mode="w")
        self._file = parquet.ParquetWriter(stream, self._batches.schema, compression="zstd")

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        self._file.write_batch(self._batches.batch(chunk))

    def __del__(self) -> None:
        # A writer that is given up early would write its footer to a file that is gone.
        if hasattr(self, "_file"):
            self._file.is_open = False

    def close(self) -> None:
        """Write the footer."""
        self._file.close()
