"""mf4: an ASAM MDF 4 file, a channel a column under the name that the CSV has, ``t_s`` the master channel (needs asammdf)."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from typing import Any

from cncgen.files import Sink
from cncgen.setpoints.columns import Layout, check_finite
from cncgen.setpoints.packages import needed
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers.spooled import spooled

#: A fixed start of measurement, so that equal plans give equal bytes.
_START = datetime(1980, 1, 1, tzinfo=UTC)


class Writer:
    """Appends rows to one channel group."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        asammdf: Any = needed("mf4")
        blocks: Any = needed("mf4", "asammdf.blocks.v4_blocks")
        self._asammdf, self._sink, self._layout = asammdf, sink, layout
        self._file: Any = asammdf.MDF(version="4.10")
        self._file.header.start_time = _START
        self._file.header.comment = json.dumps({"period_s": layout.period_s, **layout.metadata})
        made = blocks.FileHistory()  # the one that `save` adds has the time of day
        made.time_stamp = _START
        made.comment = "<FHcomment><TX>created</TX><tool_id>cncgen</tool_id></FHcomment>"
        self._file.file_history.append(made)
        self._begun = False

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        matrix = self._layout.matrix(chunk)
        check_finite(matrix, self._layout.names, chunk.first)
        times, names = matrix[:, 0].copy(), self._layout.names
        columns = [matrix[:, k].copy() for k in range(1, len(names))]
        if self._begun:
            self._file.extend(0, [(times, None), *((column, None) for column in columns)])
            return
        units = self._layout.units
        self._file.append(
            [
                self._asammdf.Signal(column, times, name=name, unit=unit)
                for name, column, unit in zip(names[1:], columns, units[1:], strict=True)
            ],
            comment="setpoints",
            common_timebase=True,
        )
        self._begun = True

    def close(self) -> None:
        """End the file and send it on."""
        with spooled(self._sink) as file:
            self._file.save(file, add_history_block=False)
            self._file.close()
