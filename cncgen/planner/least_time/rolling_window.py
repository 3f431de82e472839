"""The look-ahead's window: meshes that are read but not yet final, planned down to a stop at the window's end.

`block_planning` appends meshes and calls `advance`, which solves (`problem`), measures chords (`chord_refinement`), and yields the
final part, for `timeline`. A part of the plan is final if it does not depend on the stop at the end.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, NoPlanError, Span
from cncgen.geometry.columns import min_over_axes
from cncgen.planner.least_time.chord_refinement import LOST, ChordedMotion, MeshPath
from cncgen.planner.least_time.mesh import ENTER, ENTER_BACK, LEAVE, LEAVE_BACK, LINE, SPLINE, Mesh
from cncgen.planner.least_time.motion_pieces import MotionPieces, pieces_of
from cncgen.planner.least_time.problem import Intervals, Solution, solve
from cncgen.planner.least_time.time_scaling import obstacle, time_scaled
from cncgen.planner.least_time.timeline import SolvedWindow
from cncgen.planner.limits.axis_limits import AxisLimits

Floats = NDArray[np.float64]

#: Intervals that a window holds before it is planned, and the first one, for which the first setpoints wait. Longer windows need more
#: iterations; of shorter ones a larger part is planned twice.
SIZE, FIRST = 3200, 1600
#: The part of the limits of acceleration and jerk that is planned with. The rest is what the motion may use more
#: between nodes, where no row holds it; measured (docs/least-time.md).
MARGIN = 0.9993
#: How often bounds of q are lowered for chords that are too long, and the factor on q to start solving again from.
_ROUNDS, _SLOWER = 6, 0.9
#: The last so many times they are lowered under all of each chord.
_EVERYWHERE = 3
#: This many periods before the part that depends on the window's end are not final either: one for the chord that reaches into
#: it, and one in which the next window can still brake for such a chord.
_CLEAR = 2.0
#: Relative difference of q between neighbours up to which they are on one plateau.
_LEVEL = 1e-6
#: A stop for a place that no motion can pass lies at most this many intervals before it.
_BESIDE = 2
#: Intervals at the start of a program whose solutions are confirmed (`problem.solve`, settled). A path in another unit of length
#: differs by rounding, and where it is fitted by 10⁻⁹; the solver, which ends at a gap of 10⁻⁷, may turn that into a time that
#: differs by 10⁻⁶. Costs about 0.1 s of CPU.
_SETTLED = 20_000


@dataclass(slots=True)
class RollingWindow:
    """Tracks in a row. Their intervals are open until they are handed on.

    Attributes:
        bounds: Limits.
        meshes: In order; of the first, the intervals from `used` on are still open.
        used: Intervals of the first mesh that are handed on.
        state: q and q'/2 there, where the motion is under way; None at rest.
        reserve: The last plan for the first open intervals, down to a stop: always there to fall back on.
        wanted: Number of open intervals at which the window is planned next.
        unsettled: Number of intervals whose solutions are still to be confirmed (`_SETTLED`).
    """

    bounds: AxisLimits
    meshes: list[Mesh] = field(default_factory=list)
    used: int = 0
    state: tuple[float, float] | None = None
    reserve: Solution | None = None
    wanted: int = FIRST
    unsettled: int = _SETTLED

    def __len__(self) -> int:
        return sum(len(mesh) for mesh in self.meshes) - self.used

    def advance(self, last: bool) -> Iterator[SolvedWindow]:
        """Plan the open part if it is long enough, and hand on the final part: all of it at the `last` call."""
        while len(self) > self.wanted or (last and len(self)):
            count = min(len(self), self.wanted)
            given = self._intervals(count)
            whole = count == len(self)
            rest = 0 if whole else _last_rest(given.kind, count // 4)
            if rest:
                given = self._intervals(rest)
            elif not whole:
                given = _cut_short(given)
            solution, stops = self._solved(given)
            cut = len(solution.q) < len(given)
            if cut:
                given = self._intervals(len(solution.q))
            stands = stops or (not cut and bool(rest or whole))
            given, solution, pieces = self._held(given, solution, stands)
            self.unsettled -= len(given)
            final = len(given)
            if not (solution.fallback or stands):
                final = _last_top(solution.q[:, 1], self._unfelt(solution, pieces))
                if final < count // 8 and count < 8 * SIZE and not cut:
                    self.wanted = 2 * count
                    continue
                final = max(final, len(given) // 4, 1)
                # Neither at rest nor where the motion turns back does it have a state to go on from.
                final += int(given.kind[final] in (ENTER, ENTER_BACK))
                final += int(given.kind[final] == LEAVE_BACK)
            # From its new state the motion can certainly stop where the last plan did, so the next window reaches beyond that.
            self.wanted = max(SIZE, 3 * (len(given) - final) // 2)
            yield self._hand_on(given, solution, pieces, final, last and final == len(self))

    def _parts(self, count: int) -> list[tuple[Mesh, slice]]:
        """Return the meshes of the first `count` open intervals, and which intervals of each these are."""
        parts = []
        for number, mesh in enumerate(self.meshes):
            first = self.used if number == 0 else 0
            parts.append((mesh, slice(first, min(len(mesh), first + count))))
            count -= parts[-1][1].stop - first
            if not count:
                break
        return parts

    def _held(
        self, given: Intervals, solution: Solution, stands: bool
    ) -> tuple[Intervals, Solution, MotionPieces]:
        """Lower bounds of q where chords between setpoints are further from the path than their tolerance, and solve again.

        The lower bounds stay with the meshes, for the windows that follow. Where no motion within them is found, a motion from rest is slowed
        as a whole. Unless the motion `stands` after the last interval, chords near the end are not measured: that part is planned again.

        Raises:
            NoPlanError: Chords are still too far from the path after the last round, or no motion that is under way has
                closer ones.
        """
        course = MeshPath(self._parts(len(given)), self.bounds)
        for left in range(_ROUNDS, -1, -1):
            pieces = pieces_of(given, solution)
            count = len(given) if stands or solution.fallback else max(1, solution.unfelt)
            motion = ChordedMotion.of(given, solution, course, pieces, count)
            lower = motion.held(left <= _EVERYWHERE)
            if lower is None:
                break
            known = _SLOWER * np.minimum(solution.q[:, 1], min_over_axes(lower.top))
            again = solve(lower, self.state, known, settled=self.unsettled > 0) if left else None
            if again and not again.converged:
                # Slow enough, a motion from rest holds them.
                again = time_scaled(lower) if self.state is None else None
            if again is None:
                over, way = motion.furthest()
                if over > LOST:
                    raise NoPlanError(_too_far(over, course.line_at(way)))
                break
            given, solution = lower, again
            self._lower(given)
        return given, solution, pieces

    def _lower(self, given: Intervals) -> None:
        """Keep the bounds of q of the first open intervals."""
        first = 0
        for mesh, rows in self._parts(len(given)):
            here = slice(first, first + rows.stop - rows.start)
            mesh.top[rows], mesh.top_limit[rows] = given.top[here], given.top_limit[here]
            mesh.node_top[rows] = given.node_top[here]
            first = here.stop

    def _unfelt(self, solution: Solution, pieces: MotionPieces) -> int:
        """Return how many intervals depend on where the window ends neither themselves nor by the chords that begin on them.

        A further period is left out: if the next window finds that the first chord of its own is too long, it must have room
        to brake before that begins.
        """
        t = np.concatenate([[0.0], np.cumsum(pieces.duration)])[pieces.offset]
        clear = t[solution.unfelt] - _CLEAR * self.bounds.period_s
        upto = int(np.searchsorted(t, clear, side="right")) - 1
        return max(upto, 0)

    def _intervals(self, count: int) -> Intervals:
        """Return the first `count` open intervals as one row that ends at rest."""
        bounds = self.bounds
        limits = np.stack([bounds.acceleration, bounds.jerk]) * MARGIN
        return Intervals.of(self._parts(count), limits)

    def _solved(self, given: Intervals) -> tuple[Solution, bool]:
        """Solve; where that fails, plan less of the path (docs/least-time.md, Windows).

        Returns:
            The solution, maybe for fewer intervals, and whether the stop at its end is a real one.
        """
        known = self.reserve.q[:, 1] if self.reserve else None
        least = len(self.reserve.q) if self.reserve else 0
        stops = False
        while True:
            solution = solve(given, self.state, known, settled=self.unsettled > 0)
            if solution.converged:
                return solution, stops
            before = self._stop_for(given, least, solution)
            stops = before > 0
            fewer = before or _stop_before(given.kind, (len(given) + least) // 2)
            if fewer <= least:
                if self.reserve:
                    return self.reserve, False
                return time_scaled(given), False
            given = given.head(fewer)

    def _stop_for(self, given: Intervals, least: int, found: Solution) -> int:
        """Return after how many intervals, more than `least`, to stop for a place that no motion can pass (`obstacle`); 0 for none."""
        place = obstacle(given, found, self.bounds.period_s)
        before = _stop_before(given.kind, place)
        return before if least < before < len(given) - 2 and place - before <= _BESIDE else 0

    def _hand_on(
        self, given: Intervals, solution: Solution, pieces: MotionPieces, final: int, ends: bool
    ) -> SolvedWindow:
        """Take the first `final` intervals out of the window; whether the program `ends` there."""
        n = len(given)
        out = SolvedWindow(
            self.bounds, self._parts(n), given.h, pieces, solution, final, self.state is not None, ends
        )
        for mesh, rows in self._parts(final):
            self.used = rows.stop
            if rows.stop == len(mesh):
                self.meshes.pop(0)
                self.used = 0
        self.state, self.reserve = None, None
        if final < n and given.kind[final] == SPLINE:
            self.state = (float(pieces.v[pieces.offset[final]] ** 2), float(pieces.a[pieces.offset[final]]))
            q, way, limit = (
                solution.q[final:].copy(),
                solution.way[final:].copy(),
                solution.limit[final:].copy(),
            )
            self.reserve = Solution(q, way, limit, 0.0, 0, True, fallback=True)
        elif final == n and self.meshes and self.meshes[0].kind[self.used] in (SPLINE, LEAVE_BACK):
            # The window could not be planned beyond this place, so the motion stops here, and the next mesh leaves a rest.
            self.meshes[0].kind[self.used] = LEAVE
            self.meshes[0].corner[self.used] = True
        return out


def _too_far(over: float, span: Span) -> Diagnostic:
    """Say that chords between setpoints are too far from the path whatever was tried."""
    return Diagnostic(
        "plan-over-limits",
        f"no plan was found that keeps the chord tolerance: a chord between setpoints would be {over:.4g} times the tolerance "
        "from the path here",
        span=span,
        hint="take a shorter period or a wider chord tolerance",
    )


def _last_rest(kind: NDArray[np.int8], least: int) -> int:
    """Return after how many intervals, at least `least`, the path rests for the last time; 0 for nowhere."""
    rests = np.flatnonzero((kind[:-1] == ENTER) | (kind[:-1] == LINE)) + 1
    return int(rests[-1]) if len(rests) and rests[-1] >= least else 0


def _last_top(q: Floats, last: int) -> int:
    """Return the interval of the last maximum or plateau of q up to `last`; `last` without one.

    A good place to end the final part. Amid braking or accelerating at full jerk the state allows hardly any motion but the
    planned one, so the next window would have no interior for the solver to start in.
    """
    before, here, after = q[:last], q[1 : last + 1], q[2 : last + 2]
    n = len(after)
    level = np.flatnonzero((here[:n] >= (1.0 - _LEVEL) * before[:n]) & (after <= (1.0 + _LEVEL) * here[:n]))
    return int(level[-1]) + 1 if len(level) else last


def _cut_short(given: Intervals) -> Intervals:
    """Leave out intervals at the end until the rest can brake: a spline interval before the one that enters rest."""
    n = len(given)
    while n > 3 and (given.kind[n - 2] != SPLINE or given.kind[n - 1] == LEAVE):
        n -= 1
    return given if n == len(given) else given.head(n)


def _stop_before(kind: NDArray[np.int8], most: int) -> int:
    """Return how many intervals, at most `most`, can end at a stop amid the spline; 0 for none."""
    spline = kind == SPLINE
    amid = np.flatnonzero(spline[:-3] & spline[1:-2] & spline[2:-1] & spline[3:]) + 2
    amid = amid[amid <= most]
    return int(amid[-1]) if len(amid) else 0
