"""npz: one array a column under the column's name, and ``period_s``, for `numpy.load`.

Columns grow side by side and stand one after the other in the file, so each waits in a temporary file.
"""

from __future__ import annotations

import shutil
import struct
import zipfile
from typing import IO, cast

from cncgen.files import Sink
from cncgen.setpoints.columns import Layout
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers.npy import npy_header
from cncgen.setpoints.writers.spooled import SpooledColumns

#: A fixed date, so that the same program gives the same bytes.
_DATE = (1980, 1, 1, 0, 0, 0)


class Writer:
    """Writes the members of an uncompressed zip archive."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        self._sink, self._layout, self._columns = sink, layout, SpooledColumns(layout)

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        self._columns.add(chunk)

    def close(self) -> None:
        """Put the archive together."""
        with zipfile.ZipFile(cast(IO[bytes], _Stream(self._sink)), "w", allowZip64=True) as archive:
            for name, file in self._columns.drain():
                with _member(archive, name) as member:
                    member.write(npy_header((self._columns.rows,)))
                    shutil.copyfileobj(file, member, 1 << 20)
            with _member(archive, "period_s") as member:
                member.write(npy_header(()))
                member.write(struct.pack("<d", self._layout.period_s))


def _member(archive: zipfile.ZipFile, name: str) -> IO[bytes]:
    return archive.open(zipfile.ZipInfo(f"{name}.npy", _DATE), "w", force_zip64=True)


class _Stream:
    """A sink as the write-only stream that `zipfile` takes without seeking."""

    def __init__(self, sink: Sink) -> None:
        self.write, self.flush = sink.write, sink.flush
