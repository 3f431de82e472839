"""Events as JSON lines: when spindle, coolant, tool, stop, message and the like fall due."""

from __future__ import annotations

import json

from cncgen.diagnostics import json_values
from cncgen.files import Sink
from cncgen.setpoints.record import Setpoints


class EventWriter:
    """Writes an object an event: ``t_s``, ``line``, ``event``, then the event's own values.

    An event that takes time has its end too, ``end_t_s``.
    """

    def __init__(self, sink: Sink) -> None:
        self._sink = sink

    def write(self, chunk: Setpoints) -> None:
        """Write the events of a chunk."""
        for t_s, line, event in chunk.events:
            # A dwell of 0 s counts as a dwell too: readers of the file add up all of them.
            wait = {"dwell_s": event.dwell_s} if event.dwell_s or event.name == "dwell" else {}
            if event.wait_s:
                wait |= {"end_t_s": round(t_s + event.wait_s, 9)}
            record = {"t_s": round(t_s, 9), "line": line, "event": event.name, **wait, **event.values}
            self._sink.write((json.dumps(json_values(record)) + "\n").encode())

    def close(self) -> None:
        """Nothing follows the last event."""
