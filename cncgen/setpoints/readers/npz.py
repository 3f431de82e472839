"""npz: an array a column under the names of the CSV's columns, read some rows at a time."""

from __future__ import annotations

import math
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import ExitStack
from tokenize import TokenError
from typing import IO, BinaryIO

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import reading_faults
from cncgen.setpoints.readers.blocks import FileBlock
from cncgen.setpoints.readers.f64 import ROWS
from cncgen.setpoints.readers.npy import array_header, reason
from cncgen.setpoints.readers.tables import block_of, columns_of, seekable, stated_period

#: Faults that zipfile and numpy raise for a damaged archive. RuntimeError: it is encrypted, or of a method they do not know.
_FAULTS = (
    OSError,
    ValueError,
    TypeError,
    EOFError,
    KeyError,
    OverflowError,
    RuntimeError,
    SyntaxError,
    TokenError,
    zipfile.BadZipFile,
    zlib.error,
)


def blocks(file: BinaryIO, name: str, axes: str | None, period_s: float | None) -> Iterator[FileBlock]:
    """Yield the rows of an npz file.

    Raises:
        UsageError: The file is not an npz archive, lacks ``t_s`` or a position, columns differ in length, or one is
            an axis in another unit.
    """
    with reading_faults(name):
        source = seekable(file)
    try:
        with zipfile.ZipFile(source) as archive, ExitStack() as members:
            names = [item.removesuffix(".npy") for item in archive.namelist() if item.endswith(".npy")]
            found = ["t_s", *columns_of(names, name)]
            columns = [_Column(members.enter_context(archive.open(f"{n}.npy"))) for n in found]
            if len({column.shape for column in columns}) != 1 or len(columns[0].shape) != 1:
                shapes = ", ".join(f"{n} {c.shape}" for n, c in zip(found, columns, strict=True))
                raise UsageError(
                    Diagnostic("setpoints-columns", f"{name}: columns differ in shape: {shapes}")
                )
            period = _period(archive, names)
            for row in range(0, columns[0].shape[0], ROWS):
                matrix = np.stack([column.rows(ROWS) for column in columns], axis=1)
                yield block_of(matrix, found[1:], name, row, period)
    except _FAULTS as error:
        raise UsageError(
            Diagnostic("setpoints-header", f"{name} is not an npz file: {reason(error)}")
        ) from error


def _period(archive: zipfile.ZipFile, names: list[str]) -> float | None:
    """Return the period that an archive states, or None."""
    if "period_s" not in names:
        return None
    with archive.open("period_s.npy") as member:
        column = _Column(member)
        return stated_period(column.rows(1)[0]) if math.prod(column.shape) == 1 else None


class _Column:
    """An array of an archive, read from its start some rows at a time; its header alone allocates nothing."""

    def __init__(self, member: IO[bytes]) -> None:
        self._member = member
        self.shape, _, self._kind = array_header(member)
        if self._kind.kind not in "fiu":
            raise ValueError(f"an array of {self._kind} holds no plain numbers")
        self._left = math.prod(self.shape)

    def rows(self, count: int) -> NDArray[np.float64]:
        """Return the next values, `count` of them or those that are left."""
        count = min(count, self._left)
        data = self._member.read(count * self._kind.itemsize)
        if len(data) < count * self._kind.itemsize:
            raise ValueError("an array is shorter than its header says")
        self._left -= count
        return np.frombuffer(data, self._kind).astype(np.float64)
