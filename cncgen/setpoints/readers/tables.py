"""Files of named columns, whatever their format: which columns are read, and the blocks that they make."""

from __future__ import annotations

import io
import math
import shutil
import tempfile
import weakref
from collections.abc import Callable, Iterator, Sequence
from typing import IO, BinaryIO

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.setpoints.columns import POSITION_COLUMNS
from cncgen.setpoints.readers.blocks import FileBlock, warn_of_columns
from cncgen.setpoints.readers.f64 import ROWS, check_rows

Floats = NDArray[np.float64]


def columns_of(names: Sequence[str], name: str) -> list[str]:
    """Return the columns of positions of a file that names them.

    Raises:
        UsageError: It has no time, no position, or an axis in another unit.
    """
    found = [n for n in names if n in POSITION_COLUMNS]
    if "t_s" not in names or not found:
        message = f"{name} is not a setpoint file: it needs t_s and a position (x_mm, a_deg …)"
        raise UsageError(
            Diagnostic("setpoints-header", message, hint=f"it has {', '.join(names[:12]) or 'no columns'}")
        )
    warn_of_columns([*map(str.lower, names)], name)
    return found


def block_of(
    matrix: Floats, columns: Sequence[str], name: str, row: int, period_s: float | None
) -> FileBlock:
    """Return a block of rows, time first, after a check for finite numbers; `row` is the index of the first."""
    check_rows(matrix, name, row)
    letters = "".join(POSITION_COLUMNS[n] for n in columns)
    return FileBlock(letters, matrix[:, 0].copy(), matrix[:, 1:], period_s)


def sliced(
    names: Sequence[str],
    lengths: Sequence[int],
    part: Callable[[str, slice], NDArray],
    name: str,
    period_s: float | None,
) -> Iterator[FileBlock]:
    """Yield blocks of columns that can be read in parts.

    Args:
        names: All columns of the file.
        lengths: Rows of each.
        part: Returns some rows of a column.
        name: The file.
        period_s: The period that it states.

    Raises:
        UsageError: As `columns_of`; columns differ in length.
    """
    found = ["t_s", *columns_of(names, name)]
    rows = {n: lengths[names.index(n)] for n in found}
    if len(set(rows.values())) != 1:
        told = ", ".join(f"{n} has {count}" for n, count in rows.items())
        raise UsageError(
            Diagnostic("setpoints-columns", f"{name}: columns differ in their number of rows: {told}")
        )
    for first in range(0, rows["t_s"], ROWS):
        where = slice(first, first + ROWS)
        matrix = np.stack([np.asarray(part(n, where), np.float64) for n in found], axis=1)
        yield block_of(matrix, found[1:], name, first, period_s)


def stated_period(value: object) -> float | None:
    """Return a period that a file states, or None if it is not a positive number."""
    try:
        period = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return None
    return period if 0.0 < period < math.inf else None


class SizedFile:
    """A file in which one can go back, of which no read asks for more than there is.

    A damaged file claims lengths of its parts, and libraries ask for so much at once: Python makes room for it before it reads.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = seekable(file)
        here = self._file.tell()
        self._end = self._file.seek(0, io.SEEK_END)
        self._file.seek(here)

    def seekable(self) -> bool:
        """Return True."""
        return True

    def readable(self) -> bool:
        """Return True."""
        return True

    def seek(self, offset: int, whence: int = 0) -> int:
        """Move to a place; beyond the end it is a ValueError where the system has no such number."""
        try:
            return self._file.seek(offset, whence)
        except (OverflowError, OSError) as error:
            raise ValueError(f"it names the place {offset} of itself") from error

    def tell(self) -> int:
        """Return the place."""
        return self._file.tell()

    def read(self, count: int | None = -1) -> bytes:
        """Return so many bytes, or as many as there are."""
        left = max(self._end - self._file.tell(), 0)
        return self._file.read(left if count is None or count < 0 else min(count, left))


def seekable(file: BinaryIO) -> IO[bytes]:
    """Return a file in which one can go back: a pipe is copied to a temporary file first."""
    if file.seekable():
        return file
    copy = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the pipe
    weakref.finalize(file, copy.close)
    shutil.copyfileobj(file, copy, 1 << 20)
    copy.seek(0)
    return copy
