"""The time that a machine takes for events: tool changes, spindle ramps, coolant, pallets, stops.

A stage between the program and every feedrate strategy. Each event whose work takes time gets it as `Event.takes_s`, and strategies
rest for this time. The spindle reaches its speed at its command, before the axes move on.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from cncgen.machine.times import Times
from cncgen.toolpath.record import Event, FeedMode, Kind, Toolpath


def with_event_times(chunks: Iterable[Toolpath], times: Times) -> Iterator[Toolpath]:
    """Yield toolpaths whose events take their time, and whose blocks take the control's own at least."""
    clock = _EventClock(times)
    for chunk in chunks:
        yield _paced(clock.timed(chunk), times.block_s)


def _paced(chunk: Toolpath, block_s: float) -> Toolpath:
    """Return a toolpath whose feeds leave each row the time that the control needs for a block."""
    if block_s <= 0.0 or not len(chunk):
        return chunk
    length = np.diff(chunk.path.row_s)
    most = np.where(chunk.feed_mode == FeedMode.INVERSE_TIME, 1.0, length) / block_s
    slower = (chunk.kind != Kind.EVENT) & (length > 0.0) & (chunk.feed > most)
    return replace(chunk, feed=np.where(slower, most, chunk.feed))


class _EventClock:
    """Follows tool, spindle and coolant of a program."""

    def __init__(self, times: Times) -> None:
        self._times = times
        self._rpm = 0.0
        self._pocket: int | None = None
        self._coolant = (False, False)

    def timed(self, chunk: Toolpath) -> Toolpath:
        """Return a toolpath with the time of each event."""
        if not chunk.events:
            return chunk
        events = list(chunk.events)
        for index in chunk.curve[chunk.kind == Kind.EVENT].tolist():
            seconds = self._seconds(events[index])
            if seconds > 0.0:
                events[index] = replace(events[index], takes_s=seconds)
        return replace(chunk, events=tuple(events))

    def _seconds(self, event: Event) -> float:
        """Return the time that an event takes, and go on from it."""
        if event.name == "tool":
            return self._tool(event)
        if event.name == "spindle":
            return self._spindle(event)
        if event.name == "coolant":
            return self._switched(event)
        if event.name == "stop":
            kind = str(event.values.get("kind", ""))
            pallet = self._times.pallet_s if "pallet" in kind else 0.0
            return pallet + self._times.operator_stop_s
        if event.name == "user" and "m" in event.values:
            return self._times.m_codes.get(f"M{event.values['m']}", 0.0)
        return 0.0

    def _tool(self, event: Event) -> float:
        number = event.values.get("tool")
        pocket = number if isinstance(number, int) else None
        before, self._pocket = self._pocket, pocket
        if not event.rest:  # M61 names the tool that is in the spindle already
            return 0.0
        # A changer takes the tool from a spindle at rest.
        braking = self._times.spindle_s(self._rpm, 0.0)
        self._rpm = 0.0
        return braking + self._times.tool_s(before, pocket) + self._times.m_codes.get("M6", 0.0)

    def _spindle(self, event: Event) -> float:
        if "orient_deg" in event.values:
            braking = self._times.spindle_s(self._rpm, 0.0)
            self._rpm = 0.0
            return braking + self._times.spindle_orient_s + self._times.m_codes.get("M19", 0.0)
        direction = int(event.values.get("direction", np.sign(self._rpm)) or 0)
        speed = abs(float(event.values.get("speed_rpm", abs(self._rpm)) or 0.0)) * direction
        before, self._rpm = self._rpm, speed
        code = {1: "M3", -1: "M4", 0: "M5"}[direction] if np.sign(before) != direction else ""
        return self._times.spindle_s(before, speed) + self._times.m_codes.get(code, 0.0)

    def _switched(self, event: Event) -> float:
        after = (bool(event.values.get("mist")), bool(event.values.get("flood")))
        before, self._coolant = self._coolant, after
        if before == after:
            return 0.0
        on = [name for name, a, b in zip(("M7", "M8"), before, after, strict=True) if b and not a]
        codes = on or ([] if any(after) else ["M9"])
        return self._times.coolant_s + sum(self._times.m_codes.get(code, 0.0) for code in codes)
