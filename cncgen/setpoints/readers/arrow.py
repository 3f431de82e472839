"""arrow: an Arrow IPC file with the CSV's columns (needs pyarrow)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import reading_faults
from cncgen.setpoints.packages import needed
from cncgen.setpoints.readers.blocks import FileBlock
from cncgen.setpoints.readers.tables import block_of, columns_of, stated_period


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the record batches of an Arrow file.

    Raises:
        UsageError: pyarrow is missing, or it is not an Arrow file with ``t_s`` and positions.
    """
    pa: Any = needed("arrow")
    try:
        with reading_faults(name):
            content = file.read()
        reader = pa.ipc.open_file(content)
        batches = (reader.get_batch(k) for k in range(reader.num_record_batches))
        yield from blocks_of_batches(reader.schema, batches, name)
    except (pa.ArrowException, OSError, ValueError, TypeError, LookupError) as error:
        raise UsageError(Diagnostic("setpoints-header", f"{name} is not an Arrow file: {error}")) from error


def blocks_of_batches(schema: Any, batches: Iterator[Any], name: str) -> Iterator[FileBlock]:
    """Yield record batches of one schema as blocks; pyarrow's faults of a damaged file are raised as they are."""
    found = columns_of(schema.names, name)
    stated = stated_period((schema.metadata or {}).get(b"period_s"))
    row = 0
    for batch in batches:
        batch.validate(full=True)
        columns = [batch.column(n).to_numpy(zero_copy_only=False) for n in ("t_s", *found)]
        matrix = np.stack(columns, axis=1).astype(np.float64)
        yield block_of(matrix, found, name, row, stated)
        row += len(matrix)
