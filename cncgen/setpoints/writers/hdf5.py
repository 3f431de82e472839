"""hdf5: a data set a column, named as those of the CSV; period and metadata are attributes of the file (needs h5py)."""

from __future__ import annotations

from typing import Any

import numpy as np

from cncgen.files import Sink
from cncgen.setpoints.columns import INTEGERS, Layout, check_finite
from cncgen.setpoints.packages import needed
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers.spooled import Spool

#: Rows of a chunk of the file.
_CHUNK_ROWS = 16_384


class Writer:
    """Appends rows to data sets that grow."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        h5py: Any = needed("hdf5")
        self._sink, self._layout, self._rows = sink, layout, 0
        self._spool = Spool(".h5")
        self._file = h5py.File(self._spool.path, "w", track_order=True)
        self._file.attrs["period_s"] = layout.period_s
        for key, text in layout.metadata.items():
            self._file.attrs[key] = text
        for name in layout.names:
            kind = np.int64 if name in INTEGERS else np.float64
            self._file.create_dataset(name, (0,), kind, maxshape=(None,), chunks=(_CHUNK_ROWS,))

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        matrix = self._layout.matrix(chunk)
        check_finite(matrix, self._layout.names, chunk.first)
        first, self._rows = self._rows, self._rows + len(matrix)
        for name, column in zip(self._layout.names, matrix.T, strict=True):
            self._file[name].resize((self._rows,))
            self._file[name][first:] = column

    def close(self) -> None:
        """End the file and send it on."""
        self._file.close()
        self._spool.send(self._sink)
