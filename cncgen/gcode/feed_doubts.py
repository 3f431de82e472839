"""Warnings about absurd times and feeds, with their numbers and the other reading."""

from __future__ import annotations

from cncgen.diagnostics import Diagnostic, Severity
from cncgen.gcode.sinks.counting import LONG_S, SLOW

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.toolpath.record import Toolpath

#: The feed that counts as slow, mm/s.
_SLOW = SLOW / 60.0
#: Feed from which the time of every length is a number, mm/s.
_LEAST = 1e-290


class Clock:
    """Counts the time of slow feeds and of waiting while a program is read, and remarks where it is too long to be meant."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._slow_s = self._length_mm = self._waited_s = 0.0
        self._said = False

    def add(self, chunk: Toolpath) -> Diagnostic | None:
        """Take the rows of a chunk; return a remark, once."""
        import numpy as np

        from cncgen.ranges import POSITION
        from cncgen.toolpath.record import FeedMode, Kind

        rows = (chunk.feed_mode == FeedMode.SPEED) & (chunk.kind != Kind.EVENT) & (chunk.feed < _SLOW)
        if rows.any():
            # A place out of range is an error, which is told when the text ends.
            way = np.clip((chunk.end - chunk.starts)[rows][:, :3], -2.0 * POSITION, 2.0 * POSITION)
            length = np.linalg.norm(way, axis=1)
            feed = chunk.feed[rows]
            moving = feed > 0.0
            self._slow_s += float((length[moving] / np.maximum(feed[moving], _LEAST)).sum())
            self._length_mm += float(length.sum())
        self._waited_s += sum(event.dwell_s for event in chunk.events)
        return None if self._said else self._remark()

    def _remark(self) -> Diagnostic | None:
        if self._slow_s > LONG_S:
            mean = 60.0 * self._length_mm / self._slow_s
            message = (
                f"{self._name} takes {self._slow_s / 3600.0:.1f} hours at its feeds: {self._length_mm:.0f} mm at a mean of"
                f" {mean:.2g} mm/min; a feed of {mean:.2g} mm a revolution at 1000 rev/min takes {self._slow_s / 1000.0:.0f} s"
            )
            hint = "is F a feed a revolution (G95, --dialect fanuc-lathe)?"
        elif self._waited_s > LONG_S:
            message = (
                f"{self._name} waits for {self._waited_s / 3600.0:.1f} hours; read as milliseconds, its dwells"
                f" take {self._waited_s / 1000.0:.0f} s"
            )
            hint = "P of G4 counts milliseconds in --dialect fanuc, seconds in --dialect linuxcnc"
        else:
            return None
        self._said = True
        return Diagnostic("time-doubtful", message, Severity.WARNING, hint=hint)
