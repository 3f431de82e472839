"""arrow: an Arrow IPC file, a record batch a chunk, its columns those of the CSV (needs pyarrow)."""

from __future__ import annotations

from typing import Any

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import Sink
from cncgen.setpoints.columns import INTEGERS, Layout, check_finite
from cncgen.setpoints.record import Setpoints


class Writer:
    """Writes record batches."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        try:
            import pyarrow as pa
        except ImportError as error:
            hint = "pip install 'cncgen[arrow]'"
            raise UsageError(
                Diagnostic("missing-package", "format arrow needs pyarrow", hint=hint)
            ) from error
        self._layout, self._arrow = layout, pa
        types = [(name, pa.int64() if name in INTEGERS else pa.float64()) for name in layout.names]
        metadata = {"period_s": repr(layout.period_s)}
        self._schema: Any = pa.schema(types, metadata=metadata)
        self._stream = pa.PythonFile(_Open(sink), mode="w")
        self._file = pa.ipc.new_file(self._stream, self._schema)

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        matrix = self._layout.matrix(chunk)
        check_finite(matrix, self._layout.names, chunk.first)
        columns = [
            self._arrow.array(column, type=field.type, safe=False)
            for column, field in zip(matrix.T, self._schema, strict=True)
        ]
        self._file.write_batch(self._arrow.record_batch(columns, schema=self._schema))

    def close(self) -> None:
        """Write the footer."""
        self._file.close()


class _Open:
    """A sink that pyarrow may not close."""

    closed = False

    def __init__(self, sink: Sink) -> None:
        self.write, self.flush = sink.write, sink.flush
