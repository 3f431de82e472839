"""Feeds and times that nobody can mean: said with their numbers, and what else they may be.

A lathe's ``F0.3`` a revolution, read as mm a minute, makes hours of setpoints of a part of two minutes.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from cncgen.diagnostics import Diagnostic, Severity
from cncgen.gcode.codes.table import LATHE
from cncgen.gcode.errors import BlockError
from cncgen.gcode.source import Source
from cncgen.gcode.text.labels import Cursor
from cncgen.units import INCH

if TYPE_CHECKING:
    from cncgen.toolpath.record import Toolpath

#: Feeds below this are not meant a minute, mm/min.
LEAST_FEED = 0.5
#: Feeds above this are not meant a revolution, mm.
MOST_FEED = 10.0
#: Time at such feeds, or of waiting, beyond which another reading is named, s, and the feed that counts as slow, mm/s.
LONG_S = 36_000.0
_SLOW = 5.0 / 60.0
#: Feed from which the time of every length is a number, mm/s.
_LEAST = 1e-290
#: The spellings of a feed below 1: one for each case, as a letter is found much sooner than one of two.
_SMALL = re.compile(rb"F[ \t]*0*\.\d"), re.compile(rb"f[ \t]*0*\.\d")
_COMMENT = re.compile(rb"\([^)\n]*\)|;[^\n]*|\n")
#: Words that decide on the meaning of F: modes, and codes whose F is a pitch or lead.
_WORD = re.compile(
    rb"\n|(?<![A-Za-z#<])(?:[Gg][ \t]*0*(?P<g>\d+)(?:\.\d+)?|[Ff][ \t]*(?P<f>\d+\.?\d*|\.\d+))(?![\d.])",
)
_PITCHED = frozenset((33, 32, 34, 74, 76, 84, 88, 92, 63, 331, 332, 7, 8))
#: Bytes before the first small feed that are looked at for modes.
_BEFORE = 1_048_576


def small_feeds(source: Source, dialect: str) -> Iterator[tuple[Cursor, BlockError]]:
    """Yield the first feed in units per minute that is below `LEAST_FEED`, and the line where it stands; on lathes the first one a
    revolution above `MOST_FEED` too."""
    if dialect in ("heidenhain", "sinumerik"):
        return
    if dialect == LATHE:
        yield from _large_feeds(source)
    data = source.data
    places = [match.start() for match in (pattern.search(data) for pattern in _SMALL) if match]
    if not places:
        return
    first = min(places)
    begin = max(0, data.rfind(b"\n", 0, max(0, first - _BEFORE)) + 1)
    text = _COMMENT.sub(lambda m: m[0] if m[0] == b"\n" else b" " * len(m[0]), data[begin : first + _BEFORE])
    mode, unit = 95 if dialect == LATHE else 94, 1.0
    pitched = False
    for match in _WORD.finditer(text):
        if match[0] == b"\n":
            pitched = False
        elif match["g"]:
            code = int(match["g"])
            pitched = pitched or code in _PITCHED
            unit = {20: INCH, 21: 1.0}.get(code, unit)
            modes = {98: 94, 99: 95} if dialect == LATHE else {93: 93, 94: 94, 95: 95}
            mode = modes.get(code, mode)
        elif mode == 94 and not pitched and 0.0 < float(match["f"]) * unit < LEAST_FEED:
            yield _small_feed(source, begin + match.start(), float(match["f"]), unit, dialect)
            return


def _large_feeds(source: Source) -> Iterator[tuple[Cursor, BlockError]]:
    """Yield the first feed of a lathe's revolution that nobody can mean: F100 in G99, where G98 was forgotten or is the control's own."""
    text = _COMMENT.sub(lambda m: m[0] if m[0] == b"\n" else b" " * len(m[0]), source.data[:_BEFORE])
    unit, turning, pitched = 1.0, True, False
    for match in _WORD.finditer(text):
        if match[0] == b"\n":
            pitched = False
        elif match["g"]:
            code = int(match["g"])
            pitched = pitched or code in _PITCHED
            unit = {20: INCH, 21: 1.0}.get(code, unit)
            turning = {98: False, 99: True}.get(code, turning)
        elif turning and not pitched and float(match["f"]) * unit > MOST_FEED:
            feed, at = float(match["f"]), match.start()
            begin = text.rfind(b"\n", 0, at) + 1
            message = f"F{feed:g} in G99 is {feed * unit:.4g} mm a revolution: at 1000 rev/min {feed * unit:.4g} m a minute"
            hint = "a feed a minute is of G98"
            column = len(source.data[begin:at].decode("utf-8", "replace")) + 1
            error = BlockError(
                "feed-doubtful", message, column=column, hint=hint, values={"feed_mm_rev": feed * unit}
            )
            yield Cursor(0, begin, text[:begin].count(b"\n") + 1), error
            return


def _small_feed(source: Source, at: int, feed: float, unit: float, dialect: str) -> tuple[Cursor, BlockError]:
    line_begin = source.data.rfind(b"\n", 0, at) + 1
    line = source.data[:line_begin].count(b"\n") + 1
    column = len(source.data[line_begin:at].decode("utf-8", "replace")) + 1
    hours = 100.0 / (feed * unit) / 60.0
    message = f"F{feed:g} is {feed * unit:.3g} mm a minute: 100 mm take {hours:.1f} hours"
    if dialect == LATHE:
        hint = "a feed a revolution is of G99"
    else:
        hint = "a feed a revolution is of G95; --dialect fanuc-lathe reads it so without G95"
    error = BlockError(
        "feed-doubtful", message, column=column, hint=hint, values={"feed_mm_min": feed * unit}
    )
    return Cursor(0, line_begin, line), error


class Clock:
    """Counts the time of slow feeds and of waiting while a program is read, and remarks where it is too long to be meant."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._slow_s = self._length_mm = self._waited_s = 0.0
        self._said = False

    def add(self, chunk: Toolpath) -> Diagnostic | None:
        """Take the rows of a chunk; return a remark, once."""
        import numpy as np

        from cncgen.toolpath.record import FeedMode, Kind

        rows = (chunk.feed_mode == FeedMode.SPEED) & (chunk.kind != Kind.EVENT) & (chunk.feed < _SLOW)
        if rows.any():
            length = np.linalg.norm((chunk.end - chunk.starts)[rows][:, :3], axis=1)
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
