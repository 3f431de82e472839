"""The least-time problem on a row of intervals, as the kernels take it, and its solution.

`rolling_window` calls `solve` with the `Intervals` of its meshes; the numerical work is in the kernels ``least_time*``. ∫ q^(−1/2) ds
is minimised over q = v². The bounds are convex in q, except that of the jerk, which is replaced by its tangent in each iteration
(Verscheure et al., 2009; Debrouwere et al., 2013). The method is the primal-dual interior point of Mehrotra (1992). As the problem is
not convex, a run may stall or end at a plan that is not the best one: this module chooses the starts of runs, classifies their
results, and starts again if a result may be improved.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.columns import max_over_axes, min_over_axes
from cncgen.kernels import (
    least_time,
    least_time_intervals,
    least_time_problem,
    least_time_rows,
    least_time_ways,
)
from cncgen.planner.least_time.mesh import BENT, ENTER, LINE, SPLINE, Mesh
from cncgen.planner.record import Limit

Floats = NDArray[np.float64]
_Any = TypeVar("_Any", bound=np.generic)

#: Duality gap, as a part of the time, at which the iteration ends where the result is confirmed, and else; and part by which limits
#: may be exceeded between nodes.
GAP, ROUGH_GAP, SLACK = 1e-7, 1e-4, 5e-4
#: Iterations at most. Of 8,700 runs on random paths half take 11, a hundredth more than 27, and none more than 70.
MOST = 120
#: The starting profile is near a limit of acceleration, or a bound of q, if it uses this part of it, within this many
#: intervals on either side; other rows sleep at first.
FAR, _REACH = 0.45, 3
#: The first run starts from the q of the profile that rises and falls with full jerk, times the first of these, with some rows
#: asleep; the second one from far within the limits, with all rows.
_STARTS = (0.9, 0.01)
#: How often the starting profile is averaged over three neighbours, which rounds its edges off.
_ROUNDINGS = 160
#: Factor by which averaging may raise q: a slow place beside one a million times as fast would else end far above its limits.
_RAISED = 2.0
#: Dual residual, as a part of the time, above which an iterate that holds the limits is not taken for a plan: so far from the
#: optimum it may take a thousand times as long.
_STALLED = 0.1
#: An interval depends on where the window ends if a change of q at that end changes its q by more than this part of the
#: largest change anywhere.
_FELT = 1e-4
#: Duality gap, as a part of the time, up to which a run that has stalled near the optimum counts as one that has reached it.
_STALLED_GAP = 4e-4
#: A result that is to be confirmed is solved again from its own q times this factor, as is an earlier plan that leads to none.
_BELOW = 0.95
#: A result is confirmed when solving again changes its time by less than this part; and how often that is tried at most. Each
#: time the difference becomes about a thousand times smaller, so what is left is about 10⁻¹¹.
_STAYS, _AGAIN = 1e-8, 6
#: Ways are settled when none changes by more than this part of its interval; and how often that is tried at most.
_AGREED, _SETTLINGS = 1e-13, 60
#: The change up to which pieces of constant jerk count as joined: speeds at a node differ by less than so much of them. Of 967 windows
#: none had more than 10⁻¹⁴.
_JOINED = 1e-9
#: The part of the bound of q by the path and the feed below which another bound is meant.
_LOWER = 0.9
#: A row binds if its slack is below this part of its limit.
_NEAR = 0.02


@dataclass(frozen=True, slots=True)
class Intervals:
    """`n` intervals in a row: the columns of `Mesh`, of one or several meshes, with the limits.

    Attributes:
        h: Shape (n,), lengths.
        kind, x1, x2, x3, top, top_limit, factor, x3_excess: As in `Mesh`.
        node_top: Shape (n,): largest q at the left end of each interval by jumps.
        node_acceleration: Shape (n,): largest |q'| / 2 there by jumps.
        limits: Shape (2, axes): acceleration, jerk.
    """

    h: Floats
    kind: NDArray[np.int8]
    x1: Floats
    x2: Floats
    x3: Floats
    top: Floats
    top_limit: NDArray[np.int8]
    factor: Floats
    x3_excess: Floats
    node_top: Floats
    node_acceleration: Floats
    limits: Floats

    def __len__(self) -> int:
        return len(self.h)

    @classmethod
    def of(cls, parts: list[tuple[Mesh, slice]], limits: Floats) -> Intervals:
        """Return parts of meshes as one row that ends at rest, with the limits of acceleration and jerk."""
        h = np.concatenate([np.diff(mesh.s[rows.start : rows.stop + 1]) for mesh, rows in parts])
        columns = {
            name: _joined([getattr(mesh, name)[rows] for mesh, rows in parts]) for name in _MESH_COLUMNS
        }
        columns["kind"] = columns["kind"].copy()
        columns["kind"][-1] = LINE if columns["kind"][-1] == LINE else ENTER
        return cls(h=h, limits=limits, **columns)

    def head(self, n: int) -> Intervals:
        """Return the first `n` intervals, the last of which enters rest."""
        columns = {name: getattr(self, name)[:n] for name in ("h", *_MESH_COLUMNS)}
        columns["kind"] = columns["kind"].copy()
        columns["kind"][-1] = ENTER
        return replace(self, **columns)


def _joined(parts: list[NDArray[_Any]]) -> NDArray[_Any]:
    """Return the rows of all parts; of a single one, itself."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


#: The columns that have a row an interval and stand in `Mesh` under the same name.
_MESH_COLUMNS = tuple(each.name for each in fields(Intervals) if each.name not in ("h", "limits"))


@dataclass(frozen=True, slots=True)
class Solution:
    """q = v² on each interval of a problem.

    Attributes:
        q: Shape (n, 3): q at the start of a spline interval, where the tangents of q at both ends meet, and at its end; where the
            interval leaves or enters rest, q at both ends (first and last column).
        way: Shape (n,), mm from the start of each spline interval to where the tangents meet.
        limit: Shape (n,), int8, the `Limit` that is nearest on the interval.
        time: Time of all, s.
        unfelt: How many intervals at the start do not depend on where the row ends: these are final.
        converged: Whether every limit is held, in a time near the least.
        fallback: Whether it is the reserve of an earlier plan.
    """

    q: Floats
    way: Floats
    limit: NDArray[np.int8]
    time: float
    unfelt: int
    converged: bool
    fallback: bool = False


@dataclass(frozen=True, slots=True)
class SolverRun:
    """A run of the interior-point method from one start.

    Attributes:
        solution: Its result.
        left: Duality gap as a part of the time: 0 at the optimum, the gap where it stalled near the optimum, else infinite.
    """

    solution: Solution
    left: float


@dataclass(frozen=True, slots=True)
class SplineRow:
    """The spline intervals of a row, `n` of them, as the kernels take them.

    Attributes:
        given, state: All intervals, and q and q'/2 at the start, where the motion is under way there.
        at: Shape (n,), the numbers of those on the spline.
        h, extra, back, box, tilt, bent, sway: See `cncgen.kernels.least_time` and `cncgen.kernels.least_time_rows`.
        edge: Shape (n, 2), largest q at both ends.
        held_right: Shape (n,), where acceleration must be held at the right end too.
        x3_excess: Shape (n, axes), as in `Mesh`.
        shape: Derivatives of the path (x1, x2, x3), limits and the parts of them that may be used.
    """

    given: Intervals
    state: tuple[float, float] | None
    at: NDArray[np.int64]
    h: Floats
    extra: Floats
    back: NDArray[np.int8]
    box: Floats
    tilt: Floats
    bent: NDArray[np.int8]
    sway: Floats
    edge: Floats
    held_right: NDArray[np.int8]
    x3_excess: Floats
    shape: tuple[Floats, Floats, Floats, Floats, Floats]

    @classmethod
    def of(cls, given: Intervals, state: tuple[float, float] | None) -> SplineRow:
        """Take the spline intervals of a row that starts at rest or in a state of motion."""
        at = np.flatnonzero(given.kind == SPLINE)
        count = len(at)
        extra, box, edge, sway = (np.empty((count, columns)) for columns in (2, 3, 2, 2))
        tilt, held_right, back = np.empty(count), np.empty(count, np.int8), np.empty(count, np.int8)
        least_time_intervals.beside_rests(given.kind, given.h, at, state is not None, extra, back)
        least_time_intervals.bounds(
            given.kind, given.h, given.x1, given.x2, given.x3, given.top, given.factor, given.node_top, given.node_acceleration,
            given.limits, at, box, tilt, edge, sway, held_right,
        )  # fmt: skip
        if state is not None:
            edge[0, 0] = state[0]
        # If they lie side by side, a slice spares copying them.
        pick = slice(at[0], at[-1] + 1) if at[-1] - at[0] < count else at
        shape = (given.x1[pick], given.x2[pick], given.x3[pick], given.limits, given.factor[pick])
        bent, excess = _bent(given, at), given.x3_excess[pick]
        return cls(
            given, state, at, given.h[pick], extra, back, box, tilt, bent, sway, edge, held_right, excess, shape,
        )  # fmt: skip

    def begun(
        self, part: float, known: Floats | None = None, slower: float = 1.0
    ) -> least_time_problem.Problem:
        """Return the problem as the kernels take it, without rows, with unknowns to start from.

        Args:
            part: Of the q of the profile that rises and falls with full jerk.
            known: Shape (k,), middle ordinates of an earlier plan for the first intervals: no less than that; or None.
            slower: Part of the earlier plan to start from instead, where it is less than 1.
        """
        free = 1 if self.state is None else 2
        kernel = least_time_problem.Problem(free, self.h, self.extra, *self.shape, self.x3_excess, self.back)
        c = np.asarray(kernel.c)
        if self.state is not None:
            c[0], kernel.start = self.state
            c[1] = c[0] + 2.0 * kernel.start * kernel.way[0]
        least_time_rows.start(kernel, self.edge, part)
        # At its edges the profile exceeds the jerk limit by far: rounded off it needs fewer iterations.
        least_time_rows.rounded(kernel, _ROUNDINGS, _RAISED)
        if known is not None:
            ahead = self.at[self.at < len(known)]
            there = slice(free, 1 + len(ahead))
            known = known[ahead[free - 1 :]]
            c[there] = slower * known if slower < 1.0 else np.maximum(c[there], known)
        least_time_ways.meet(kernel)
        return kernel

    def run(self, start: tuple[float, Floats | None, float], thinned: bool, settled: bool) -> SolverRun:
        """Run the interior-point method from a start (of `begun`), to a smaller gap if the result is to be confirmed (`settled`).

        If `thinned`, rows that the start stays far from are left out at first.
        """
        kernel = self.begun(*start)
        least_time_rows.build(kernel, self.box, self.tilt, self.bent, self.sway, self.held_right)
        if thinned:
            least_time_rows.thin(kernel, _REACH, FAR)
        report, change = np.zeros(7), np.zeros(len(self.at) + 2)
        status = least_time.solve(kernel, GAP if settled else ROUGH_GAP, SLACK, MOST, report, change)
        time, gap, over, _, residual, between, apart = report.tolist()
        held = over < SLACK and 0.0 < between < 1.0 + SLACK and residual < _STALLED * time
        found = apart <= _JOINED and (status >= 0 or held)
        unfelt = _unfelt(self.at, np.abs(change[1:-1])) if found else 0
        left = 0.0 if status == 0 else gap / time
        solution = Solution(*self.motion(kernel), self._binding(kernel), time, unfelt, found)
        return SolverRun(solution, left if found and status >= 0 else np.inf)

    def confirmed(self, run: SolverRun, always: bool = False) -> Solution:
        """Confirm a result: solve again from a little below it until its time no longer changes.

        That is done where the run stalled near the optimum, or `always`. Two things go wrong in runs of many short steps. Far from
        the central path steps stay short, and the optimum is not reached; from a little below, it is. And the parts of the
        limits that may be used at the ends of intervals are taken from the iterates, so they keep the rounding that has grown
        over the steps; from a little below steps are long, and the error falls by a thousand each time.
        """
        first = run
        for _ in range(_AGAIN):
            if run.left == 0.0 and not always:
                return run.solution
            again = self.run((_STARTS[0], run.solution.q[:, 1], _BELOW), thinned=True, settled=always)
            longer = again.solution.time / run.solution.time - 1.0
            # A stalled run may be shorter than the optimum, as its parts of the limits were not yet up to date.
            if again.left >= _STALLED_GAP or longer > (_STALLED_GAP if again.left == 0.0 else 0.0):
                break
            run = again
            if abs(longer) <= _STAYS:
                return run.solution
        # The runs do not agree: any of them is a plan.
        return min(first.solution, run.solution, key=lambda each: each.time)

    def motion(self, kernel: least_time_problem.Problem) -> tuple[Floats, Floats]:
        """Return q and the ways on all intervals, as in `Solution`."""
        q, way = np.zeros((len(self.given), 3)), np.zeros(len(self.given))
        least_time_intervals.ordinates(self.given.kind, self.at, kernel.ends, kernel.c, q)
        way[self.at] = kernel.way
        return q, way

    def _binding(self, kernel: least_time_problem.Problem) -> NDArray[np.int8]:
        """Name the limit that each interval comes nearest to; none where all are more than a fiftieth away."""
        given, at = self.given, self.at
        margin, closest = np.ones(len(at)), np.zeros(len(at), np.int8)
        least_time_rows.nearest(kernel, margin, closest)
        names = np.array([Limit.FEED, Limit.ACCELERATION, Limit.JERK], np.int8)[closest]
        # Beside a rest the bound of q may be that of full jerk from there.
        rests = (max_over_axes(self.extra) > 0.0) & (
            min_over_axes(self.edge) < _LOWER * min_over_axes(given.top[at])
        )
        bound = np.where(rests, np.int8(Limit.JERK), given.top_limit[at])
        names = np.where(closest == least_time.BOX, bound, names)
        out = np.full(len(given), Limit.JERK, np.int8)
        out[at] = np.where(margin < _NEAR, names, Limit.NONE)
        return out


def solve(
    given: Intervals,
    state: tuple[float, float] | None,
    known: Floats | None = None,
    settled: bool = False,
) -> Solution:
    """Find the least time on a row of intervals that ends at rest.

    Args:
        given: The intervals; the last one enters rest, the first one leaves it unless `state` says otherwise.
        state: q and q'/2 at the start, where the motion is under way there.
        known: Shape (k,), middle ordinates of an earlier plan for the first intervals, to start from.
        settled: Whether the result is confirmed (`SplineRow.confirmed`) even if the run did not stall.

    Returns:
        The solution; ``converged`` is False where no motion that holds every limit was found.
    """
    n = len(given)
    if not (given.kind == SPLINE).any():
        return Solution(np.zeros((n, 3)), np.zeros(n), np.full(n, Limit.JERK, np.int8), 0.0, n, True)
    row = SplineRow.of(given, state)
    found: list[Solution] = []
    near, within = _STARTS
    # Most rows never bind. The starting profile tells which, so the first run leaves them out. The second one starts from far within
    # the limits; a state of motion may leave hardly any other one than the earlier plan, so then from somewhat below that.
    for start, thinned in (
        ((near, known, 1.0), True),
        ((within, None if state is None else known, _BELOW), False),
    ):
        run = row.run(start, thinned, settled)
        if run.left < _STALLED_GAP:
            return row.confirmed(run, settled)
        found.append(run.solution)
    # A plan that holds every limit is a plan, though the method did not find the best one.
    return min(found, key=lambda each: (not each.converged, each.time))


def profile(given: Intervals) -> tuple[Floats, Floats, Floats]:
    """Return a motion that rises and falls with full jerk from rest to rest, and what bounds q at their ends.

    Args:
        given: The intervals, at least one of them on the spline.

    Returns:
        q and ways, as in `Solution`, and the largest q at both ends of spline intervals, shape (k, 2).
    """
    row = SplineRow.of(given, None)
    kernel = row.begun(_STARTS[0])
    if least_time_ways.agree(kernel, _AGREED, _SETTLINGS) > _JOINED:
        # As parabolas they join in any case.
        kernel = row.begun(_STARTS[0])
    return *row.motion(kernel), row.edge


def _bent(given: Intervals, at: NDArray[np.int64]) -> NDArray[np.int8]:
    """Tell of intervals whether the bound of q by the velocity of an axis, which the motion may follow, is curved there, shape (k,)."""
    top = given.top[at]
    with np.errstate(invalid="ignore"):
        bend = np.abs(top[:, 0] - 2.0 * top[:, 1] + top[:, 2])
    out: NDArray[np.int8] = (bend > BENT * min_over_axes(top)) & (given.top_limit[at] == Limit.VELOCITY)
    return out.astype(np.int8)


def _unfelt(spline: NDArray[np.int64], change: Floats) -> int:
    """Return how many intervals come before those that change if q at the end of the row is changed.

    As far back as the motion brakes for the end, a change of q there is passed on from interval to interval. Before that
    another limit holds the speed, and the change dies out within a few intervals (docs/least-time.md).

    Args:
        spline: Shape (k,), numbers of the spline intervals.
        change: Shape (k,), how much q changes on each of them.
    """
    largest = change.max()
    return int(spline[np.argmax(change > _FELT * largest)]) if largest > 0.0 else 0


def slopes(h: Floats, q: Floats, way: Floats) -> tuple[Floats, Floats]:
    """Return the accelerations q'/2 at both ends of spline intervals, shape (n,) each, mm/s².

    Args:
        h: Shape (n,), lengths.
        q, way: As in `Solution`.
    """
    return (q[:, 1] - q[:, 0]) / (2.0 * way), (q[:, 2] - q[:, 1]) / (2.0 * (h - way))


def middles(h: Floats, q: Floats, way: Floats) -> Floats:
    """Return q in the middle of spline intervals, shape (n,): the cubic of s with the slopes at its ends (docs/least-time.md).

    Args:
        h: Shape (n,), lengths.
        q, way: As in `Solution`.
    """
    one, other = slopes(h, q, way)
    return q[:, 0] + h * one + (0.75 * h - way) * (other - one)
