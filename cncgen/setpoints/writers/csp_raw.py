"""csp-raw: CiA 402 cyclic synchronous position as packed frames, one a period, for the process image of an EtherCAT master.

The file begins with ``CSP1``, the length of the text that follows as a little-endian uint32, and that text: a JSON object with the
period, the axes, the size of a frame, its objects, and the scaling of each drive. Frames follow: of each axis 607Ah,
60B0h, 60B1h (INT32) and 60B2h (INT16), little-endian, without gaps.
"""

from __future__ import annotations

import json
import struct

from cncgen.files import Sink
from cncgen.setpoints.columns import Layout
from cncgen.setpoints.drive_units import FrameMaker, description
from cncgen.setpoints.record import Setpoints

SIGNATURE = b"CSP1"


class Writer:
    """Writes frames."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        self._sink = sink
        self._frames = FrameMaker(layout.axes, layout.period_s, layout.drives)
        about = {**description(layout.axes, layout.period_s, layout.drives), **layout.metadata}
        text = json.dumps(about).encode()
        sink.write(SIGNATURE + struct.pack("<I", len(text)) + text)

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk but its last, which waits for the next chunk."""
        self._sink.write(self._frames.frames(chunk).tobytes())

    def close(self) -> None:
        """Write the last row."""
        self._sink.write(self._frames.last().tobytes())
