"""The look-ahead's window: stretches that are read and not yet planned for good, seen as one row of segments.

Joints are counted over all open stretches, from the first open one on; places are lengths from there. The planner drops joints that do
not limit the speed (a line in two parts). Speed profiles have zero acceleration at every joint, so otherwise a finer division would
make a program slower.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Span
from cncgen.planner.assembly import assemble, timed
from cncgen.planner.ild.look_ahead import SegmentPieces, Segments
from cncgen.planner.ild.stretch import Stretch
from cncgen.planner.motion import arrival_at, cut
from cncgen.planner.record import MAX_CORNERS, Limit, Profile, SharpCorner, Trajectory
from cncgen.toolpath.record import Event

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Tops and limits that differ by this part are equal.
_EQUAL = 1e-9


@dataclass(frozen=True, slots=True)
class OpenPath:
    """The open joints of a window.

    Attributes:
        place: Shape (n + 1,), mm: length from the first open joint to each.
        first: Number of each stretch's first open joint, and, last, n.
        kept: Shape (m + 1,): the joints that segments end at.
        segments: The `m` segments between them.
    """

    place: Floats
    first: list[int]
    kept: Ints
    segments: Segments


@dataclass(slots=True)
class OpenStretches:
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

    def least_time_s(self) -> float:
        """Return how long the open segments take at their top speeds, s."""
        return sum(float((np.diff(s.s[s.used :]) / s.top[s.used :]).sum()) for s in self.stretches)

    def span_at(self, place: float) -> Span:
        """Return the source line of a place, mm from the first open joint."""
        stretch = self.stretches[0]
        for stretch in self.stretches:
            length = float(stretch.s[-1] - stretch.s[stretch.used])
            if place <= length:
                break
            place -= length
        row = np.searchsorted(stretch.path.row_s[1:], stretch.s[stretch.used] + place)
        return stretch.toolpath.span(min(int(row), len(stretch.toolpath) - 1))

    def open_path(self) -> OpenPath:
        """Number the open joints, and drop those that hold nothing back."""
        parts = [(s, s.used) for s in self.stretches]
        first = np.concatenate([[0], np.cumsum([len(s) - used for s, used in parts])]).astype(int).tolist()
        cap = np.full(first[-1] + 1, np.inf)
        for (stretch, used), a, b in zip(parts, first, first[1:], strict=False):
            np.minimum(cap[a : b + 1], stretch.cap[used:], out=cap[a : b + 1])
        place = np.concatenate([[0.0], np.cumsum(np.concatenate([np.diff(s.s[used:]) for s, used in parts]))])
        columns = {
            name: np.concatenate([getattr(s, name)[used:] for s, used in parts])
            for name in ("top", "top_limit", "acceleration", "jerk")
        }
        kept = _kept(cap, columns["top"], columns["acceleration"], columns["jerk"])
        left = kept[:-1]
        segments = Segments(
            length=np.diff(place[kept]),
            top=columns["top"][left],
            top_limit=columns["top_limit"][left],
            acceleration=columns["acceleration"][left],
            jerk=columns["jerk"][left],
            cap=cap[kept],
        )
        return OpenPath(place, first, kept, segments)

    def turns(self, open_path: OpenPath) -> Floats:
        """Return the places at which the tangent turns at a joint, increasing."""
        turns = np.zeros(len(open_path.place), dtype=bool)
        for stretch, a, b in zip(self.stretches, open_path.first, open_path.first[1:], strict=False):
            turns[a : b + 1] |= stretch.turns[stretch.used :]
        return open_path.place[turns]

    def hand_on(
        self, open_path: OpenPath, pieces: SegmentPieces, joint: Ints, speeds: Floats, upto: int
    ) -> list[Trajectory]:
        """Turn the first `upto` segments into trajectories, and take them out of the window.

        Args:
            open_path: The open joints.
            pieces: Speed profiles of the segments, which may be cut finer than those of `open_path`.
            joint: Shape (m + 1,): where each kept joint stands among the joints of `pieces`.
            speeds: Shape (joints of `pieces`,), mm/s.
            upto: How many of the segments are final.
        """
        kept, waits = open_path.kept[: upto + 1], np.zeros(upto + 1)
        final = int(kept[-1])
        owners, events = self._events(open_path, final)
        for at, _, event in events:
            if event.wait_s > 0.0:
                waits[np.searchsorted(kept, at)] += event.wait_s
        profile, reached = laid_out(self.t_s, open_path.place[kept], pieces, joint[: upto + 1], waits)
        arrival = arrival_at(profile, open_path.place[: final + 1])
        # A place of the profile is a sum of lengths and may differ from the joint's in its last bits, so a wait would be passed.
        arrival[kept] = reached
        happened = timed(events, arrival)
        speed = np.interp(np.arange(final + 1), open_path.kept, speeds[joint])
        done: list[Trajectory] = []
        for number, stretch in enumerate(self.stretches):
            a, b = open_path.first[number], open_path.first[number + 1]
            end = min(b, final)
            if a > final or (b > final and a == final):
                break
            over = [
                t + event.wait_s
                for owner, (at, *_), (t, _, event) in zip(owners, events, happened, strict=True)
                if at == end and owner <= number
            ]
            until = max([self.t_s, float(arrival[end]), *over])
            part = cut(profile, self.t_s, until)
            done.append(
                Trajectory(
                    toolpath=stretch.toolpath,
                    row_s=np.asarray(stretch.path.row_s),
                    profile=_local(part, stretch, float(open_path.place[a]), end - a),
                    events=tuple(h for owner, h in zip(owners, happened, strict=True) if owner == number),
                    corners=tuple(self._corners(stretch, end - a, speed[a:], arrival[a:])),
                    values={"corners_total": self.corners},
                )
            )
            stretch.used += end - a
            self.t_s = until
        self.stretches = self.stretches[sum(b <= final for b in open_path.first[1:]) :]
        self.speed_mm_s = float(speeds[joint[upto]])
        return done

    def _events(self, open_path: OpenPath, final: int) -> tuple[list[int], list[tuple[int, int, Event]]]:
        """Return the events up to a joint in order, with their joints and source lines, and the number of the stretch of each; at that
        joint, only those of stretches that end there."""
        owners, found = [], []
        for number, stretch in enumerate(self.stretches):
            a, b = open_path.first[number], open_path.first[number + 1]
            for at, line, event in stretch.events:
                joint = a + at - stretch.used
                if at >= stretch.used and (joint < final or b <= final):
                    owners.append(number)
                    found.append((joint, line, event))
        return owners, found

    def _corners(self, stretch: Stretch, count: int, speed: Floats, time: Floats) -> list[SharpCorner]:
        """Name the sharp corners among the next `count` joints of a stretch; speeds and times begin with the first."""
        first = stretch.used
        at = np.flatnonzero(stretch.sharp[first : first + count])
        self.corners += len(at)
        at = at[: max(0, MAX_CORNERS - self.corners + len(at))]
        if not len(at):
            return []
        s = stretch.s[first + at]
        position = stretch.path.evaluate(s, 0)[0]
        row = np.searchsorted(stretch.path.row_s[1:], s)
        line = stretch.toolpath.line[np.minimum(row, len(stretch.toolpath) - 1)]
        feed = speed[at]
        held = feed >= stretch.cap[first + at] * (1.0 - 1e-9)
        limit = np.where(held, stretch.cap_limit[first + at], np.int8(Limit.ACCELERATION))
        return [
            SharpCorner(
                int(line[i]), tuple(position[i].tolist()), float(feed[i]), Limit(int(limit[i])), float(t)
            )
            for i, t in enumerate(time[at])
        ]


def _kept(cap: Floats, top: Floats, acceleration: Floats, jerk: Floats) -> Ints:
    """Return the joints that hold something back, and both ends."""
    n = len(top)
    differ = np.zeros(max(n - 1, 0), dtype=bool)
    for column in (top, acceleration, jerk):
        # Infinite tops (rapids without a limit) are equal to each other.
        one, other = column[:-1], column[1:]
        differ |= (one != other) & ~(np.abs(one - other) <= _EQUAL * np.minimum(one, other))
    held = differ | (cap[1:-1] < np.maximum(top[:-1], top[1:]))
    return np.concatenate([[0], np.flatnonzero(held) + 1, [n] if n else []]).astype(np.int64)


def laid_out(
    start_s: float, place: Floats, pieces: SegmentPieces, joint: Ints, waits: Floats
) -> tuple[Profile, Floats]:
    """Lay the pieces up to the last of some joints on the time axis; return the arrival at each joint, too.

    Args:
        start_s: Time at the first one.
        place: Shape (m + 1,), mm: where they are.
        pieces: Speed profiles of segments.
        joint: Shape (m + 1,): where they stand among the joints of these.
        waits: Shape (m + 1,), s.
    """
    offset = pieces.offset[joint]
    count = int(offset[-1])
    # Every segment starts exactly at its joint; only within a segment are lengths added up.
    before = np.concatenate([[0.0], np.cumsum(pieces.length[:count])])
    owner = np.repeat(np.arange(len(joint) - 1), np.diff(offset))
    s = np.append(place[owner] + before[:-1] - before[offset[owner]], place[-1])
    p = pieces
    moves = (p.duration[:count], p.v[:count], p.a[:count], p.j[:count], p.c[:count])
    return assemble(start_s, s, moves, pieces.limit[:count], offset, waits)


def _local(part: Profile, stretch: Stretch, origin: float, count: int) -> Profile:
    """Move a profile of `count` segments from places of the window to the path coordinate of a stretch."""
    first, last = stretch.s[stretch.used], stretch.s[stretch.used + count]
    s = np.clip(first + (part.s - origin), first, last)
    s[-1] = last
    return replace(part, s=s)
