"""npy: one array of doubles, shape (rows, columns), its columns those of the CSV.

The number of rows stands in the header and is known at the end, so the header has a fixed size and is written again;
where the sink cannot go back (a pipe), the rows wait in a temporary file.
"""

from __future__ import annotations

import shutil
from typing import IO

from cncgen.files import OutputFile, Sink
from cncgen.setpoints.columns import Layout, check_finite
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers.spooled import spool_of

#: Bytes of the whole header, a multiple of 64 as the format wants.
_HEADER_BYTES = 128


def npy_header(shape: tuple[int, ...]) -> bytes:
    """Return the header of a version 1.0 npy file of little-endian doubles in C order, `_HEADER_BYTES` long."""
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape!r}, }}"
    length = _HEADER_BYTES - 10
    return b"\x93NUMPY\x01\x00" + length.to_bytes(2, "little") + text.ljust(length - 1).encode() + b"\n"


class Writer:
    """Writes one npy array."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        self._sink, self._layout, self._rows = sink, layout, 0
        self._body: OutputFile | IO[bytes]
        if isinstance(sink, OutputFile) and sink.seekable:
            self._body = sink
            self._write_header()
        else:
            self._body = spool_of(self)

    def _write_header(self) -> None:
        self._sink.write(npy_header((self._rows, len(self._layout.names))))

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        matrix = self._layout.matrix(chunk)
        check_finite(matrix, self._layout.names, chunk.first)
        self._body.write(matrix.astype("<f8", copy=False).tobytes())
        self._rows += len(matrix)

    def close(self) -> None:
        """Write the header with the number of rows."""
        if isinstance(self._body, OutputFile):
            self._body.seek(0)
            self._write_header()
            self._body.seek(0, 2)
        else:
            self._write_header()
            with self._body as body:
                body.seek(0)
                shutil.copyfileobj(body, self._sink, 1 << 20)
