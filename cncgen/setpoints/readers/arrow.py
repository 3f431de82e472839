"""arrow: an Arrow IPC file with the CSV's columns (needs pyarrow)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, BinaryIO

import numpy as np

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import reading_faults
from cncgen.setpoints.columns import POSITION_COLUMNS
from cncgen.setpoints.readers.blocks import Block, warn_of_columns
from cncgen.setpoints.readers.f64 import check_rows


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[Block]:
    """Yield the record batches of an Arrow file.

    Raises:
        UsageError: pyarrow is missing, or it is no Arrow file with ``t_s`` and positions.
    """
    try:
        import pyarrow as pa
    except ImportError as error:
        hint = "pip install 'cncgen[arrow]'"
        raise UsageError(Diagnostic("missing-package", "format arrow needs pyarrow", hint=hint)) from error
    try:
        with reading_faults(name):
            content = file.read()
        yield from _batches(pa.ipc.open_file(content), name)
    except (pa.ArrowException, OSError, ValueError, TypeError, LookupError) as error:
        raise UsageError(Diagnostic("setpoints-header", f"{name} is no Arrow file: {error}")) from error


def _batches(reader: Any, name: str) -> Iterator[Block]:
    """Yield the record batches of an open file; what pyarrow says of a damaged one is raised as it is."""
    names = [n for n in reader.schema.names if n in POSITION_COLUMNS]
    if "t_s" not in reader.schema.names or not names:
        message = f"{name} is no setpoint file: it has no column t_s, or none of an axis position"
        raise UsageError(Diagnostic("setpoints-header", message))
    warn_of_columns([*map(str.lower, reader.schema.names)], name)
    letters, stated = "".join(POSITION_COLUMNS[n] for n in names), _stated(reader.schema.metadata)
    row = 0
    for index in range(reader.num_record_batches):
        batch = reader.get_batch(index)
        batch.validate(full=True)
        columns = [batch.column(n).to_numpy(zero_copy_only=False) for n in ("t_s", *names)]
        matrix = np.stack(columns, axis=1).astype(np.float64)
        check_rows(matrix, name, row)
        row += len(matrix)
        yield Block(letters, matrix[:, 0].copy(), matrix[:, 1:], stated)


def _stated(metadata: Mapping[bytes, bytes] | None) -> float | None:
    """Return the period that a file states, or None."""
    try:
        period = float((metadata or {}).get(b"period_s", b"nan"))
    except ValueError:
        return None
    return period if 0.0 < period < math.inf else None
