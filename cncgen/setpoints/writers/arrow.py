"""arrow: an Arrow IPC file, a record batch a chunk, its columns those of the CSV (needs pyarrow)."""

from __future__ import annotations

from typing import Any

from cncgen.files import Sink
from cncgen.setpoints.columns import INTEGERS, Layout, check_finite
from cncgen.setpoints.packages import needed
from cncgen.setpoints.record import Setpoints


class BatchMaker:
    """Turns chunks into record batches of one schema, which carries the period and the metadata of the layout."""

    def __init__(self, kind: str, layout: Layout) -> None:
        self.arrow: Any = needed(kind)
        self._layout = layout
        pa = self.arrow
        types = [(name, pa.int64() if name in INTEGERS else pa.float64()) for name in layout.names]
        metadata = {"period_s": repr(layout.period_s), **layout.metadata}
        self.schema: Any = pa.schema(types, metadata=metadata)

    def batch(self, chunk: Setpoints) -> Any:
        """Return the record batch of a chunk."""
        matrix = self._layout.matrix(chunk)
        check_finite(matrix, self._layout.names, chunk.first)
        columns = [
            self.arrow.array(column, type=field.type, safe=False)
            for column, field in zip(matrix.T, self.schema, strict=True)
        ]
        return self.arrow.record_batch(columns, schema=self.schema)


class Writer:
    """Writes record batches."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        self._batches = BatchMaker("arrow", layout)
        pa = self._batches.arrow
        self._stream = pa.PythonFile(OpenSink(sink), mode="w")
        self._file = pa.ipc.new_file(self._stream, self._batches.schema)

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        self._file.write_batch(self._batches.batch(chunk))

    def close(self) -> None:
        """Write the footer."""
        self._file.close()


class OpenSink:
    """A sink that pyarrow may not close."""

    closed = False

    def __init__(self, sink: Sink) -> None:
        self.write, self.flush = sink.write, sink.flush
