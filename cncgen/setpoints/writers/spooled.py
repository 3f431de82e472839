"""Temporary files, for formats that go back in the file or write column after column. They have no names, so that a process that
is killed leaves nothing.
"""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, BinaryIO

from cncgen.files import Sink
from cncgen.setpoints.columns import Layout, check_finite
from cncgen.setpoints.record import Setpoints


def spool_of(writer: object) -> IO[bytes]:
    """Open a file that is closed with its writer, also with one that is given up."""
    file = tempfile.TemporaryFile()  # noqa: SIM115 - closed below
    weakref.finalize(writer, file.close)
    return file


@contextmanager
def spooled(sink: Sink) -> Iterator[BinaryIO]:
    """Give a file for a with block, which then goes to a sink as a whole."""
    with tempfile.TemporaryFile() as file:
        file.raw.name = "spool"  # type: ignore[attr-defined] # asammdf makes a path of the name, which is the descriptor's number
        yield file
        file.seek(0)
        shutil.copyfileobj(file, sink, 1 << 20)


class SpooledColumns:
    """The columns of setpoints, a temporary file each, for formats in which one stands after the other.

    Attributes:
        rows: How many were added.
    """

    def __init__(self, layout: Layout) -> None:
        self._layout, self.rows = layout, 0
        self._files = [spool_of(self) for _ in layout.names]

    def add(self, chunk: Setpoints) -> None:
        """Add the rows of a chunk, little-endian doubles."""
        matrix = self._layout.matrix(chunk)
        check_finite(matrix, self._layout.names, chunk.first)
        for column, file in zip(matrix.T, self._files, strict=True):
            file.write(column.astype("<f8").tobytes())
        self.rows += len(matrix)

    def drain(self) -> Iterator[tuple[str, IO[bytes]]]:
        """Yield name and file of each column, at its beginning; close it afterwards."""
        for name, file in zip(self._layout.names, self._files, strict=True):
            with file:
                file.seek(0)
                yield name, file
