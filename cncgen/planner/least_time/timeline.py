"""The intervals that windows hand on, in time: rests that last until a setpoint is near enough, and trajectories with their corners.

This has no influence on later plans, so it runs in another thread than the solver (`block_planning`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import planned_motion
from cncgen.planner.assembly import assemble, timed, waits_of
from cncgen.planner.least_time.breakpoints import nearest
from cncgen.planner.least_time.chord_refinement import MeshPath
from cncgen.planner.least_time.corners import SEEN
from cncgen.planner.least_time.mesh import Mesh
from cncgen.planner.least_time.motion_pieces import MotionPieces
from cncgen.planner.least_time.problem import Solution
from cncgen.planner.least_time.setpoint_alignment import PathMotion, SetpointAlignment, hold_chord, started
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.record import MAX_CORNERS, Limit, SharpCorner, Trajectory

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SolvedWindow:
    """`n` intervals that a window has solved, of which the first ones are final.

    Attributes:
        bounds: Limits.
        parts: Their meshes, and which intervals of each these are.
        h: Shape (n,), lengths, mm.
        pieces, solution: The motion on them.
        final: How many of them are final.
        moving: Whether the motion is under way at their start.
        ends: Whether the program ends with those that are final.
    """

    bounds: AxisLimits
    parts: list[tuple[Mesh, slice]]
    h: Floats
    pieces: MotionPieces
    solution: Solution
    final: int
    moving: bool
    ends: bool


@dataclass(slots=True)
class Timeline:
    """The final part of a program's motion.

    Attributes:
        t_s: Time at its end.
        corners: Sharp corners so far.
        past: Its ways, back to a period before `t_s` at least.
        cornered: Whether the last part had rests that chords might cut (`Mesh.cuts`).
        open_s: When a setpoint falls before a rest whose next setpoint is not final yet.
    """

    t_s: float = 0.0
    corners: int = 0
    past: list[PathMotion] = field(default_factory=list)
    cornered: bool = False
    open_s: float | None = None

    def trajectories(self, planned: SolvedWindow) -> Iterator[Trajectory]:
        """Turn the intervals that are final into trajectories."""
        longer = self._longer(planned)
        position = 0
        for mesh, rows in planned.parts:
            count = min(rows.stop - rows.start, planned.final - position)
            if count <= 0:
                break
            yield self._trajectory(planned, mesh, rows.start, slice(position, position + count), longer)
            position += count
        self._look_back(planned.ends)

    def _look_back(self, ends: bool) -> None:
        """Compare the chord over a rest with the handed-on motion, if the setpoint after it was not final when the rest was timed.

        Raises:
            NoPlanError: It is too far from the path: since then the motion to that setpoint became another one.
        """
        period = self.past[-1].course.bounds.period_s if self.past else np.inf
        if self.open_s is not None and (ends or self.t_s >= self.open_s + period):
            hold_chord(self.past, self.open_s, self.open_s + period)
            self.open_s = None
        last = float(np.floor(self.t_s / period) * period)
        if any(
            (way.profile.v[way.profile.t[:-1] > last] <= 0.0).any()
            for way in self.past
            if way.profile.t[-1] > last
        ):
            self.open_s = last

    def _longer(self, planned: SolvedWindow) -> Floats:
        """Return how much longer than the program asks for rests last before the intervals that are final, shape (final,), s."""
        parts, pieces, final = planned.parts, planned.pieces, planned.final
        cuts = np.concatenate([mesh.cuts[rows] for mesh, rows in parts])[:final]
        cornered, self.cornered = self.cornered, bool(cuts.any())
        # The motion also rests at places within a mesh that it cannot pass.
        stopped = not planned.moving and parts[0][1].start > 0
        if not (cornered or self.cornered or stopped):
            return np.zeros(final)
        dwells = np.zeros(len(planned.h) + 1)
        first = 0
        for mesh, rows in parts:
            events = [event for event in mesh.events if rows.start <= event[0] <= rows.stop]
            dwells[first : first + rows.stop - rows.start + 1] += waits_of(
                events, rows.stop - rows.start + 1, rows.start
            )
            first += rows.stop - rows.start
        way = PathMotion.planned(MeshPath(parts, planned.bounds), planned.h, pieces)
        stands = cuts | (dwells[:final] > 0.0)
        if not self.past and not dwells[0]:
            # The first wait is before the motion starts.
            after = np.flatnonzero(stands[1:]) + 1
            longer, start = started(way, after, way.profile.t[pieces.offset], dwells, planned.ends)
            longer[0] = start
            return longer[:final]
        # How the motion goes on after a rest at the end of the last hand-on, and so the chord over it, is known only now.
        stands[0] |= not planned.moving
        rests = SetpointAlignment(way, self.past, np.flatnonzero(stands), [self.t_s], [0.0])
        return rests.lengthened(way.profile.t[pieces.offset], dwells)[:final]

    def _trajectory(
        self, planned: SolvedWindow, mesh: Mesh, first: int, part: slice, longer: Floats
    ) -> Trajectory:
        """Return the trajectory of a part of the intervals, those of a mesh from its `first` on."""
        pieces, period_s = planned.pieces, planned.bounds.period_s
        q, limit = planned.solution.q[part, 0], planned.solution.limit[part]
        count = part.stop - part.start
        whole = first + count == len(mesh)
        last = first + count if whole else first + count - 1
        events = [event for event in mesh.events if first <= event[0] <= last]
        waits = waits_of(events, count + 1, first)
        first_piece, last_piece = pieces.offset[part.start], pieces.offset[part.stop]
        cut = slice(first_piece, last_piece)
        offset = pieces.offset[part.start : part.stop + 1] - first_piece
        why = np.where(waits > 0.0, np.int8(Limit.STOP), np.int8(Limit.CHORD))
        waits[:-1] += longer[part]
        owner = np.repeat(np.arange(count), np.diff(offset))
        profile, arrival = assemble(
            self.t_s,
            np.append(mesh.s[first + owner] + pieces.place[cut], mesh.s[first + count]),
            (pieces.duration[cut], pieces.v[cut], pieces.a[cut], pieces.j[cut], pieces.c[cut]),
            pieces.limit[cut],
            offset,
            waits,
            why,
        )
        self.t_s = float(profile.t[-1])
        since = self.t_s - period_s if self.open_s is None else min(self.open_s, self.t_s - period_s)
        self.past = [way for way in self.past if way.profile.t[-1] > since]
        self.past.append(PathMotion.gone(mesh, profile, planned.bounds))
        slow = slow_nodes(mesh, first, q, limit, period_s)
        room = max(0, MAX_CORNERS - self.corners)
        self.corners += len(slow)
        corners = corners_at(slow[:room], mesh, first, q, limit, arrival)
        return Trajectory(
            toolpath=mesh.toolpath,
            row_s=np.asarray(mesh.path.row_s),
            profile=profile,
            events=timed(events, arrival, first),
            corners=corners,
            values={"corners_total": self.corners},
        )


def slow_nodes(
    mesh: Mesh, first: int, q: Floats, limit: NDArray[np.int8], period_s: float
) -> NDArray[np.int64]:
    """Return the nodes, counted from `first`, at which the motion slows for a corner.

    Those are jumps of the path's derivatives, and minima of the speed between maxima a tenth higher that curvature
    (acceleration, jerk, chord error) causes. A minimum where setpoints see a jump (`SEEN`) is that jump's. One that
    costs less than a period does not count. q and limit, shape (count,), are those at the left ends of the intervals from there on.
    """
    jumps = np.flatnonzero(mesh.corner[first : first + len(q)])
    s = mesh.s[first : first + len(q)]
    minima = np.empty(len(q), np.int64)
    minima = minima[: planned_motion.minima(s, q, period_s, minima)]
    minima = minima[~np.isin(limit[minima], (Limit.NONE, Limit.FEED, Limit.STOP))]
    if len(jumps) and len(minima):
        beside = jumps[nearest(s[jumps], s[minima])]
        way = SEEN * period_s * np.sqrt(np.maximum(q[beside], q[minima]))
        minima = minima[np.abs(s[minima] - s[beside]) > way]
    return np.union1d(jumps, minima)


def corners_at(
    at: NDArray[np.int64], mesh: Mesh, first: int, q: Floats, limit: NDArray[np.int8], arrival: Floats
) -> tuple[SharpCorner, ...]:
    """Name the corners at nodes that `slow_nodes` found; `arrival` has the time at the nodes from `first` on."""
    if not len(at):
        return ()
    s = mesh.s[first + at]
    position = mesh.path.evaluate(s, 0)[0].tolist()
    line = mesh.toolpath.line[mesh.path.row_of(s)].tolist()
    which = np.where(mesh.corner[first + at], np.int8(Limit.CORNER), limit[at]).tolist()
    speed, when = np.sqrt(q[at]).tolist(), arrival[at].tolist()
    return tuple(
        SharpCorner(row, tuple(place), v, Limit(name), t)
        for row, place, v, name, t in zip(line, position, speed, which, when, strict=True)
    )
