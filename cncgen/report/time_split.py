"""The parts of a plan's cycle time: cutting, rapid, tool changes, spindle, dwell, other events, stops."""

from __future__ import annotations

from typing import Any

import numpy as np

from cncgen.planner.record import Limit, Trajectory
from cncgen.report.tables import counted, duration
from cncgen.toolpath.record import Event, FeedMode

#: Parts in the order that summaries name them.
PARTS = ("cutting", "rapid", "tool", "spindle", "dwell", "other", "stops")
#: Part of an event's own time by the event's name.
_PART_OF = {"tool": "tool", "spindle": "spindle", "stop": "stops"}


#: Remainder by rounding of rests whose whole time events have taken, s.
_ROUNDING_S = 1e-9


def part_of(event: Event) -> str:
    """Return the part that an event's own time belongs to."""
    return _PART_OF.get(event.name, "other")


class TimeSplit:
    """Adds up the parts of the time line over the trajectories of a plan; they sum to its end."""

    def __init__(self) -> None:
        self._seconds = dict.fromkeys(PARTS, 0.0)
        self._stood_s = self._taken_s = self._end_s = 0.0
        #: Tool changes, spindle commands and stops that took no time.
        self.instant: dict[str, int] = {}

    @property
    def dwell_s(self) -> float:
        """Seconds of rest that the program demanded, with their extension to a setpoint."""
        left = self._stood_s - self._taken_s
        return left if left > _ROUNDING_S else 0.0

    def add(self, trajectory: Trajectory) -> None:
        """Take a stretch of a plan.

        A piece belongs to the row that it moves on. The waits of a plan for the next setpoint belong to the motion
        before them.
        """
        profile, rows = trajectory.profile, trajectory.toolpath
        if len(profile.t):
            self._end_s = float(profile.t[-1])
        if len(profile) and len(rows):
            time = np.diff(profile.t)
            stops = profile.waits & (profile.limit == Limit.STOP)
            self._stood_s += float(time[stops].sum())
            middle = 0.5 * (profile.s[:-1] + profile.s[1:])
            row = np.minimum(np.searchsorted(trajectory.row_s[1:], middle, side="left"), len(rows) - 1)
            rapid = rows.feed_mode[row] == FeedMode.RAPID
            self._seconds["rapid"] += float(time[~stops & rapid].sum())
            self._seconds["cutting"] += float(time[~stops & ~rapid].sum())
        for _, _, event in trajectory.events:
            self._take(event)

    def _take(self, event: Event) -> None:
        self._seconds[part_of(event)] += event.takes_s
        self._taken_s += event.takes_s
        if event.name in _PART_OF and not event.takes_s:
            self.instant[event.name] = self.instant.get(event.name, 0) + 1

    def as_json(self) -> dict[str, Any]:
        """Return ``cycle_time_s`` and ``cycle_time_split_s``, whose parts add up to it."""
        return {
            "cycle_time_s": self._end_s,
            "cycle_time_split_s": {**self._seconds, "dwell": self.dwell_s},
        }


#: Usual names of events that take time on a real machine.
_CALLED = {"tool": "tool change", "spindle": "spindle command", "stop": "stop"}


def untimed_text(summary: dict[str, Any]) -> str:
    """Return the events that take no time since the machine has no [times]; "" without any."""
    events = summary.get("untimed_events", {})
    told = [counted(events[name], called) for name, called in _CALLED.items() if name in events]
    if not told:
        return ""
    listed = " and ".join(filter(None, (", ".join(told[:-1]), told[-1])))
    return f"{listed} taken as instant: {summary['machine']} has no [times]"


def split_text(summary: dict[str, Any]) -> str:
    """Return the parts that take time, as a person reads them."""
    parts = summary["cycle_time_split_s"]
    told = [f"{duration(parts[name])} {name}" for name in PARTS if parts[name] > 5e-7]
    return ", ".join(told) or "no motion"
