"""Whether threads come to the speed that their pitch and the spindle ask for: where they do not, the pitch is not the programmed one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Severity, Span
from cncgen.planner.record import Trajectory
from cncgen.toolpath.record import FeedMode

#: A thread comes to its speed from this part of it on.
_REACHED = 0.99


class ThreadSpeeds:
    """Follows the trajectories of a plan from one thread to the next. Rigid taps are left out: there the spindle follows the axis."""

    def __init__(self) -> None:
        self._pitch_mm: float | None = None
        #: The largest share of its speed that the thread has come to, its speed and that share of it, mm/s, and where it begins.
        self._best: tuple[float, float, float] = 0.0, 0.0, 0.0
        self._span: Span | None = None

    def add(self, trajectory: Trajectory, top_mm_s: NDArray[np.float64]) -> list[Diagnostic]:
        """Take a stretch of a plan, and the largest speed of each piece of its profile; return what is wrong with threads that end in it."""
        events = [(t, event.values) for t, _, event in trajectory.events if event.name == "synchronise"]
        if self._pitch_mm is None and not events:
            return []
        found = []
        begin = -np.inf
        for t, values in events:
            self._follow(trajectory, top_mm_s, begin, t)
            pitch = None if values.get("tap") else values["pitch_mm"]
            if pitch is None:
                found += self._ended()
            self._pitch_mm, begin = pitch, t
        self._follow(trajectory, top_mm_s, begin, np.inf)
        return found

    def _follow(
        self, trajectory: Trajectory, top_mm_s: NDArray[np.float64], begin_s: float, end_s: float
    ) -> None:
        """Take the speeds of the pieces from one time to another, if they are of a thread."""
        profile, rows = trajectory.profile, trajectory.toolpath
        if self._pitch_mm is None or not len(profile):
            return
        when = 0.5 * (profile.t[:-1] + profile.t[1:])
        middle = 0.5 * (profile.s[:-1] + profile.s[1:])
        row = np.minimum(np.searchsorted(trajectory.row_s[1:], middle, side="left"), len(rows) - 1)
        within = (when > begin_s) & (when < end_s) & (np.diff(profile.s) > 0.0)
        pieces = np.flatnonzero(within & (rows.feed_mode[row] == FeedMode.SPEED) & (rows.feed[row] > 0.0))
        if not len(pieces):
            return
        if self._span is None:
            self._span = rows.span(row[pieces[0]])
        feed = rows.feed[row[pieces]]
        share = top_mm_s[pieces] / feed
        best = int(share.argmax())
        self._best = max(self._best, (float(share[best]), float(feed[best]), float(top_mm_s[pieces[best]])))

    def _ended(self) -> list[Diagnostic]:
        """Return what is wrong with the thread that has ended, if anything, and wait for the next one."""
        (share, feed, top), pitch, span = self._best, self._pitch_mm, self._span
        self._pitch_mm = self._span = None
        self._best = 0.0, 0.0, 0.0
        if span is None or share >= _REACHED:
            return []
        return [
            Diagnostic(
                "thread-speed",
                f"a thread of {pitch:g} mm a turn asks for {feed:.4g} mm/s, and the axes come to {top:.4g} mm/s:"
                " its pitch is not kept",
                severity=Severity.WARNING,
                span=span,
                hint="lower S, give it a longer run-in, or raise the limits of the axis",
                values={"pitch_mm": pitch, "feed_mm_s": feed, "reached_mm_s": top},
            )
        ]
