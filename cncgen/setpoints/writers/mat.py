"""mat: a MATLAB 5 file, a column vector a column under the name that the CSV has, ``period_s`` and a structure ``metadata``.

The vectors stand one after the other, so columns wait in temporary files. A vector holds at most 2 GiB
(MAT-File Format, version 5): 268 million rows.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import Sink
from cncgen.setpoints.columns import Layout
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers.spooled import SpooledColumns, spooled

#: Rows of doubles in a vector of 2 GiB.
MAX_ROWS = (2**31 - 1) // 8
#: Variable that names the columns, the first of the file, so that a reader misses one that was cut off.
COLUMNS = "columns"
#: The text at the beginning of the file, without the date that scipy puts there: equal plans give equal bytes.
_HEADER = b"MATLAB 5.0 MAT-file, setpoints of cncgen".ljust(116)


class Writer:
    """Gathers columns and writes them at the end."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        self._sink, self._layout, self._columns = sink, layout, SpooledColumns(layout)

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        if self._columns.rows + len(chunk) > MAX_ROWS:
            message = f"format mat holds {MAX_ROWS} rows; the plan has more"
            raise UsageError(Diagnostic("setpoint-range", message, hint="--format hdf5 holds any number"))
        self._columns.add(chunk)

    def close(self) -> None:
        """Put the file together and send it on."""
        from scipy.io import savemat

        with spooled(self._sink) as out:
            self._save(savemat, out, {COLUMNS: ",".join(self._layout.names)})
            self._save(savemat, out, {"period_s": self._layout.period_s})
            if self._layout.metadata:
                self._save(savemat, out, {"metadata": dict(self._layout.metadata)})
            for name, file in self._columns.drain():
                column = np.fromfile(file, "<f8") if self._columns.rows else np.zeros(0)
                self._save(savemat, out, {name: column})
            out.seek(0)
            out.write(_HEADER)

    @staticmethod
    def _save(savemat: Any, out: Any, values: dict[str, Any]) -> None:
        """Append variables; scipy writes a header of 128 bytes where the file is at its beginning alone."""
        savemat(out, values, oned_as="column", long_field_names=True)
