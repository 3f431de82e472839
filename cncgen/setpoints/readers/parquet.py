"""parquet: an Apache Parquet file with the CSV's columns, read some rows at a time (needs pyarrow)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, BinaryIO

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import reading_faults
from cncgen.setpoints.packages import needed
from cncgen.setpoints.readers.arrow import blocks_of_batches
from cncgen.setpoints.readers.blocks import FileBlock
from cncgen.setpoints.readers.f64 import ROWS
from cncgen.setpoints.readers.tables import columns_of, seekable


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the rows of a Parquet file.

    Raises:
        UsageError: pyarrow is missing, or it is not a Parquet file with ``t_s`` and positions.
    """
    pa: Any = needed("parquet")
    parquet: Any = needed("parquet", "pyarrow.parquet")
    try:
        with reading_faults(name):
            reader = parquet.ParquetFile(seekable(file))
        schema = reader.schema_arrow
        wanted = ["t_s", *columns_of(schema.names, name)]
        batches = reader.iter_batches(batch_size=ROWS, columns=wanted)
        yield from blocks_of_batches(schema, batches, name)
    except (pa.ArrowException, OSError, ValueError, TypeError, LookupError) as error:
        raise UsageError(Diagnostic("setpoints-header", f"{name} is not a Parquet file: {error}")) from error
