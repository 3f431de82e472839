"""mcap: ROS 2 `JointTrajectory` messages on the topic ``/joint_trajectory``, one a chunk; no ROS is needed (needs mcap).

Velocities and accelerations of the points are those of the signals ``vel`` and ``acc``, where they were asked for.
Nanoseconds count from the start of the program.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cncgen.files import Sink
from cncgen.setpoints.columns import Layout, check_finite, position_column
from cncgen.setpoints.joint_trajectory import DEFINITION, TYPE, JointPoints, encode, to_metres
from cncgen.setpoints.packages import needed
from cncgen.setpoints.record import Setpoints

TOPIC = "/joint_trajectory"
#: Points of a message: a few times as many as a controller's buffer, few enough for a reader to hold.
_POINTS = 4096


class Writer:
    """Writes messages."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        needed("mcap")
        module: Any = needed("mcap", "mcap.writer")
        self._layout, self._sequence = layout, 0
        self._file = module.Writer(_Counted(sink))
        self._file.start("ros2", "cncgen")
        schema = self._file.register_schema(TYPE, "ros2msg", DEFINITION.encode())
        self._channel = self._file.register_channel(TOPIC, "cdr", schema)
        texts = {"period_s": repr(layout.period_s), "axes": layout.axes, **layout.metadata}
        self._file.add_metadata("setpoints", texts)

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        check_finite(chunk.position, [position_column(axis) for axis in chunk.axes], chunk.first)
        for first in range(0, len(chunk), _POINTS):
            rows = slice(first, first + _POINTS)
            points = JointPoints(
                self._layout.axes,
                np.rint(chunk.time_s[rows] * 1e9).astype(np.int64),
                to_metres(chunk.position[rows], chunk.axes),
                self._signal(chunk, "vel", rows),
                self._signal(chunk, "acc", rows),
            )
            stamp = int(points.time_ns[0])
            self._file.add_message(self._channel, stamp, encode(points), stamp, self._sequence)
            self._sequence += 1

    def _signal(self, chunk: Setpoints, name: str, rows: slice) -> np.ndarray:
        """Return a signal of the axes in m and rad, or an array without columns where it was not asked for."""
        if name not in self._layout.signals:
            return np.zeros((len(chunk.position[rows]), 0))
        return to_metres(chunk.signals[name][rows], chunk.axes)

    def close(self) -> None:
        """Write the index."""
        self._file.finish()


class _Counted:
    """A sink that tells how much was written to it: the library asks for the place of each record, and pipes know none."""

    def __init__(self, sink: Sink) -> None:
        self._sink, self._written = sink, 0
        self.flush = sink.flush

    def write(self, data: bytes | bytearray | memoryview) -> int:
        self._written += len(data)
        return self._sink.write(data)

    def tell(self) -> int:
        return self._written
