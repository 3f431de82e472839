"""The look-ahead's window: stretches that are read and not yet planned for good, seen as one row of segments."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.assembly import assemble, timed, waits_of
from cncgen.planner.look_ahead import Pieces, Segments
from cncgen.planner.record import Limit, SharpCorner, Trajectory
from cncgen.planner.stretch import Stretch

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Sharp corners that are handed on one by one; beyond them they are counted.
MAX_CORNERS = 10_000


@dataclass(slots=True)
class Window:
    """Stretches in a row; the last joint of one is the first of the next.

    Attributes:
        stretches: In order; of each, the segments from `Stretch.used` on are still open.
        t_s: Time at the first open joint.
        speed_mm_s: Speed there.
        corners: Sharp corners handed on so far.
    """

    stretches: list[Stretch] = field(default_factory=list)
    t_s: float = 0.0
    speed_mm_s: float = 0.0
    corners: int = 0

    def __len__(self) -> int:
        return sum(len(s) - s.used for s in self.stretches)

    def segments(self) -> Segments:
        """Return the open segments of all stretches; a joint of two stretches has the lower of both caps."""
        open_ = [(s, s.used) for s in self.stretches]
        cap = [np.array([np.inf])]
        for stretch, used in open_:
            cap[-1][-1] = min(cap[-1][-1], stretch.cap[used])
            cap.append(stretch.cap[used + 1 :].copy())
            if not len(cap[-1]):
                cap.pop()
        return Segments(
            length=np.concatenate([np.diff(s.s[used:]) for s, used in open_]),
            top=np.concatenate([s.top[used:] for s, used in open_]),
            top_limit=np.concatenate([s.top_limit[used:] for s, used in open_]),
            acceleration=np.concatenate([s.acceleration[used:] for s, used in open_]),
            jerk=np.concatenate([s.jerk[used:] for s, used in open_]),
            cap=np.concatenate(cap),
        )

    def turns(self) -> Floats:
        """Return where the path turns at a joint, in lengths from the first open joint on, increasing."""
        places, origin = [np.zeros(0)], 0.0
        for stretch in self.stretches:
            local = stretch.s[stretch.used :] - stretch.s[stretch.used]
            places.append(origin + local[stretch.turns[stretch.used :]])
            origin += local[-1]
        return np.concatenate(places)

    def hand_on(self, pieces: Pieces, joint: Ints, speeds: Floats, upto: int) -> list[Trajectory]:
        """Turn the first `upto` open segments into trajectories, and take them out of the window.

        Args:
            pieces: Speed profile of the window's segments, which may be cut finer than the window's own.
            joint: Shape (open segments + 1,): where each open joint stands among the joints of `pieces`.
            speeds: Shape (joints of `pieces`,), mm/s.
            upto: How many of the open segments are final.
        """
        done: list[Trajectory] = []
        position = 0
        while self.stretches:
            stretch = self.stretches[0]
            count = min(len(stretch) - stretch.used, upto - position)
            whole = stretch.used + count == len(stretch)
            if count or whole:
                done.append(self._trajectory(stretch, count, whole, pieces, joint[position:], speeds))
            stretch.used += count
            position += count
            if not whole:
                break
            # A stretch ends with the joint that the next one begins with: what lowers it counts for both.
            self.stretches.pop(0)
        self.speed_mm_s = float(speeds[joint[position]])
        return done

    def _trajectory(
        self, stretch: Stretch, count: int, whole: bool, pieces: Pieces, joint: Ints, speeds: Floats
    ) -> Trajectory:
        """Lay the pieces of `count` segments of a stretch, with the waits of its events, on the time axis."""
        first = stretch.used
        start, stop = int(pieces.offset[joint[0]]), int(pieces.offset[joint[count]])
        cut = slice(start, stop)
        # Each open segment starts exactly at its joint; only within a segment are lengths added up.
        before = np.concatenate([[0.0], np.cumsum(pieces.length[cut])])
        offset = pieces.offset[joint[: count + 1]] - start
        owner = np.repeat(np.arange(count), np.diff(offset))
        s = stretch.s[first + owner] + before[:-1] - before[offset[owner]]
        s = np.append(s, stretch.s[first + count])
        moves = (pieces.duration[cut], pieces.v[cut], pieces.a[cut], pieces.j[cut], pieces.c[cut])
        last = first + count if whole else first + count - 1
        events = [e for e in stretch.events if first <= e[0] <= last]
        waits = waits_of(events, count + 1, first)
        profile, arrival = assemble(self.t_s, s, moves, pieces.limit[cut], offset, waits)
        self.t_s = float(profile.t[-1])
        corners = self._corners(stretch, first, count, joint, speeds, arrival)
        return Trajectory(
            toolpath=stretch.toolpath,
            row_s=np.asarray(stretch.path.row_s),
            profile=profile,
            events=timed(events, arrival, first),
            corners=tuple(corners),
            values={"corners_total": self.corners},
        )

    def _corners(
        self, stretch: Stretch, first: int, count: int, joint: Ints, speeds: Floats, arrival: Floats
    ) -> list[SharpCorner]:
        """Name the sharp corners among the first joints of `count` segments."""
        at = np.flatnonzero(stretch.sharp[first : first + count])
        self.corners += len(at)
        at = at[: max(0, MAX_CORNERS - self.corners + len(at))]
        if not len(at):
            return []
        s = stretch.s[first + at]
        position = stretch.path.evaluate(s, 0)[0]
        row = np.searchsorted(stretch.path.row_s[1:], s)
        line = stretch.toolpath.line[np.minimum(row, len(stretch.toolpath) - 1)]
        feed = speeds[joint[at]]
        held = feed >= stretch.cap[first + at] * (1.0 - 1e-9)
        limit = np.where(held, stretch.cap_limit[first + at], np.int8(Limit.ACCELERATION))
        return [
            SharpCorner(
                int(line[i]), tuple(position[i].tolist()), float(feed[i]), Limit(int(limit[i])), float(t)
            )
            for i, t in enumerate(arrival[at])
        ]
