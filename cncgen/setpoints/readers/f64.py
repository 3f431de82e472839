"""f64: rows of raw little-endian doubles: time, then the axes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import reading_faults
from cncgen.setpoints.readers import letters_or_fault
from cncgen.setpoints.readers.blocks import FileBlock

#: Rows read at a time, and bytes, which are fewer rows where they are long.
ROWS, BYTES = 65_536, 1 << 26


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the rows of a raw file, whose columns are the time and those of `axes`.

    Raises:
        UsageError: `axes` is missing, the file ends within a row, or a number is not finite.
    """
    letters = letters_or_fault(axes, name, "f64")
    for matrix in matrices(file, name, 1 + len(letters)):
        yield FileBlock(letters, matrix[:, 0].copy(), matrix[:, 1:])


def matrices(file: BinaryIO, name: str, columns: int) -> Iterator[NDArray[np.float64]]:
    """Yield rows of that many doubles until the file ends; a broken row or number is a `UsageError`."""
    size, row = 8 * columns, 0
    while True:
        with reading_faults(name):
            data = file.read(size * max(min(ROWS, BYTES // size), 1))
        if not data:
            return
        if len(data) % size:
            message = f"{name}: ends within a row of {columns} doubles (after row {row + len(data) // size})"
            raise UsageError(Diagnostic("setpoints-columns", message))
        matrix = np.frombuffer(data, "<f8").reshape(-1, columns).astype(np.float64)
        check_rows(matrix, name, row)
        row += len(matrix)
        yield matrix


def check_rows(matrix: NDArray[np.float64], name: str, row: int) -> None:
    """Raise `UsageError` at the first row with a number that is not finite."""
    finite = np.isfinite(matrix).all(axis=1)
    if not finite.all():
        at = int(np.argmin(finite))
        message = f"{name}: row {row + at + 1} holds {matrix[at].tolist()}, not all finite"
        raise UsageError(Diagnostic("setpoints-number", message, values={"row": row + at + 1}))
