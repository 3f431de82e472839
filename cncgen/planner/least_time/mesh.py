"""A block of a toolpath as intervals between nodes, with all data of the least-time problem.

`mesh_of` cuts a block at its breakpoints, which `corners` classifies, and between them into the intervals of a `Mesh`, on which `problem`
works.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, NoPlanError
from cncgen.geometry.columns import max_over_axes, min_over_axes
from cncgen.geometry.path import Path
from cncgen.kernels import node_places
from cncgen.planner.least_time.breakpoints import SHARP, Breakpoints, PathBlock, nearest
from cncgen.planner.least_time.corners import Corners, corners_of, rows_beside
from cncgen.planner.least_time.mesh_spacing import MOST, TooManyNodesError, TopAt, placed
from cncgen.planner.limits.axis_limits import JUMP_SHARE, STEP_TAKES, SWAY_SHARE, AxisLimits, resolution
from cncgen.planner.limits.speeds import Feeds
from cncgen.planner.record import Limit
from cncgen.planner.smoothing.runs import loose
from cncgen.toolpath.record import Event, Kind, PathMode, Toolpath

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Kinds of intervals: `SPLINE`, one on which q is a quadratic; `LEAVE` and `ENTER`, one that leaves or enters a rest with
#: constant jerk; `LINE`, a whole straight line from rest to rest; `LEAVE_BACK` and `ENTER_BACK`, one that leaves or enters a place where the
#: motion turns back, with constant acceleration.
SPLINE, LEAVE, ENTER, LINE, LEAVE_BACK, ENTER_BACK = range(6)
#: Part of the feed that changes, below which a straight line goes on: speeds of G93 come from lengths, with their rounding.
_STRAIGHT = 1e-9
#: Relative change of a direction that is rounding alone.
_LAST_DIGITS = 2.0**-48
#: A turn of at least this is a corner, rad. A smaller one may be rounding of the coordinates of short rows.
_SEEN = 1e-5
#: Allowance for values between the quarter points, as a multiple of those at the points: slightly more in x''', and twice as much in
#: x''.
_EXCESS = 2.5
#: Quarter points are compared where the bounds of q on an interval are off a line by more than this part of the least: beside a kink an
#: eighth of that is the most by which the bound is passed, so half as much of it in v.
BENT = 0.008
#: Part of the acceleration limit that may be hidden between the values of x'' of an interval, else it is halved; and how often at most.
_BULGE, _HALVINGS = 0.01, 5
#: The third derivative at the quarter points is taken to be at most this over the square of the length of the interval.
_BELIEVED = 0.3


@dataclass(slots=True)
class Mesh:
    """A block as `n` intervals between n + 1 nodes. Not frozen: the rolling window lowers bounds of q, and adds rests.

    Attributes:
        toolpath, path: The block and its geometry.
        s: Shape (n + 1,), path coordinate of the nodes.
        kind: Shape (n,), int8: `SPLINE`, `LEAVE` …
        x1, x2, x3: Shape (n, 3, axes): derivatives of the path at the left end, middle and right end of each interval.
        top: Shape (n, 3): largest q = v² there.
        top_limit: Shape (n,), int8: the `Limit` behind the lowest of them.
        node_top: Shape (n + 1,): largest q at the nodes because of jumps of the derivatives there; infinite without a jump.
        node_acceleration: Shape (n + 1,): largest |q'| / 2 at the nodes because of such jumps; infinite without.
        factor: Shape (n, 2, axes): parts of acceleration and jerk limits that jumps near by leave.
        x3_excess: Shape (n, axes): by how much |x'''| within an interval may exceed the parabola through its three values.
        chord: Shape (n,), mm: how far the chord of a period may be from the path there.
        stop: Shape (n + 1,), bool: nodes of rest.
        corner: Shape (n + 1,), bool: nodes where the motion slows or rests because the derivatives jump.
        cuts: Shape (n,), bool: intervals that begin with a rest in a corner, where the chord between two setpoints might be too
            far from the corner if no setpoint falls near it (`setpoint_alignment`).
        events: Node, source line and event, in order.
    """

    toolpath: Toolpath
    path: Path
    s: Floats
    kind: NDArray[np.int8]
    x1: Floats
    x2: Floats
    x3: Floats
    top: Floats
    top_limit: NDArray[np.int8]
    node_top: Floats
    node_acceleration: Floats
    factor: Floats
    x3_excess: Floats
    chord: Floats
    stop: NDArray[np.bool_]
    corner: NDArray[np.bool_]
    cuts: NDArray[np.bool_]
    events: list[tuple[int, int, Event]]

    def __len__(self) -> int:
        return len(self.kind)


def mesh_of(
    block: PathBlock,
    points: Breakpoints,
    around: tuple[Breakpoints | None, Breakpoints | None],
    bounds: AxisLimits,
    coarse: bool = False,
) -> Mesh:
    """Cut a block into intervals.

    Args:
        block: The block.
        points: Its breakpoints.
        around: The breakpoints of its neighbours beside its start and its end; None where the motion starts or ends there.
        bounds: Limits.
        coarse: Few nodes will do but for blocks with rows that are not planned again within a tolerance, or where other axes than
            X Y Z move: there the search is dear, and ends more often, and a slow axis makes few nodes cost more (5 % of 4 s).

    Raises:
        NoPlanError: It would be more intervals than memory is meant for.
    """
    toolpath, path, cap = block.toolpath, block.path, block.cap

    def top_at(s: Floats, x: Floats, side: int) -> Floats:
        return block.top(bounds, s, x, side)

    every, corners, sides = _classified(block, points, around, bounds)
    lines = _lines(path, corners)
    if cap and cap.straight:
        # Crawling rows are slower than any cap.
        lines &= block.crawls[path.row_of(0.5 * (corners.s[:-1] + corners.s[1:]))]
    if coarse:
        kept = ~loose(toolpath) | ~path.moves_xyz | (toolpath.end != toolpath.starts)[:, 3:].any(axis=1)
        coarse = not kept[toolpath.kind != Kind.EVENT].any()
    try:
        s = placed(path, bounds, corners, sides, lines, top_at, coarse)
    except TooManyNodesError as many:
        raise NoPlanError(_too_many(toolpath, path, bounds, many)) from None
    for _ in range(1 if coarse else _HALVINGS):
        mesh, bulging = _intervals(block, bounds, (every, corners), sides, lines, s)
        if not len(bulging):
            break
        s = np.union1d(s, 0.5 * (s[bulging] + s[bulging + 1]))
    _lower_steep(mesh, top_at)
    return mesh


def _classified(
    block: PathBlock,
    points: Breakpoints,
    around: tuple[Breakpoints | None, Breakpoints | None],
    bounds: AxisLimits,
) -> tuple[Corners, Corners, tuple[Floats, Floats]]:
    """Return the corners of a block and its neighbours; those of the block that count, and the derivatives on both sides of these,
    shape (4, n, axes) each."""
    before, after = around
    joined = before.followed_by(points) if before else points
    first = len(joined) - len(points)
    joined = joined.followed_by(after) if after else joined
    every = corners_of(joined, bounds)
    here = slice(first, first + len(points))
    corners = every.only(here)
    # The end of a block is the start of the next one.
    corners.cuts[-1] = False
    sides = (joined.left[:, here], joined.right[:, here])
    kept = ~_straight_on(block.path, block.feeds, corners, sides)
    return every, corners.only(kept), (sides[0][:, kept], sides[1][:, kept])


def _intervals(
    block: PathBlock,
    bounds: AxisLimits,
    classified: tuple[Corners, Corners],
    sides: tuple[Floats, Floats],
    lines: NDArray[np.bool_],
    s: Floats,
) -> tuple[Mesh, Ints]:
    """Return the intervals between the nodes `s`, and which of them bulge (`_concealed`)."""
    toolpath, path, feeds, cap = block.toolpath, block.path, block.feeds, block.cap
    every, corners = classified
    n = len(s) - 1
    length = np.diff(s)
    places = s[:-1, None] + length[:, None] * (0.0, 0.25, 0.5, 0.75)
    places[:, 2] = 0.5 * (s[:-1] + s[1:])
    seen = path.evaluate(places.ravel(), 3).reshape(4, n, 4, -1)
    node = nearest(s, corners.s)
    x = np.empty((4, n, 3, seen.shape[3]))
    x[:, :, :2], x[:, :-1, 2] = seen[:, :, ::2], seen[:, 1:, 0]
    # Breakpoints that no setpoint can tell apart are one node, whose sides are those of the first and of the last.
    x[:, node[1:] - 1, 2] = sides[0][:, 1:]
    x[:, node[:-1], 0] = sides[1][:, :-1]
    row = path.row_of(places[:, 2])
    flat = np.repeat(row, 3)
    top, limit = bounds.top(
        feeds.speed[flat], feeds.limit[flat], *(each.reshape(3 * n, -1) for each in x[1:3])
    )
    top3, which = top.reshape(n, 3), limit.reshape(n, 3)
    stop, corner, cuts = np.zeros((3, n + 1), bool)
    stop[node], corner[node], cuts[node] = corners.stop, corners.corner, corners.cuts
    if cap:
        capped = cap.on_intervals(s, x, stop[:-1], stop[1:])
        capped[node[:-1][lines]] = np.inf
        which[capped < top3] = cap.limit
        top3 = np.minimum(top3, capped)
    node_top, node_acceleration = np.full((2, n + 1), np.inf)
    node_top[node], node_acceleration[node] = corners.speed**2, corners.acceleration
    kind = np.full(n, SPLINE, np.int8)
    kind[stop[:-1]] = LEAVE
    kind[stop[1:]] = ENTER
    reached = np.zeros(n + 1)
    reached[node] = 2.0 * corners.back
    for turns, ends in ((LEAVE_BACK, reached[:-1]), (ENTER_BACK, reached[1:])):
        back = ends > 0.0
        kind[back] = turns
        top3[back] = np.minimum(top3[back], (ends * length)[back, None] * (1.0, 0.5, 1.0))
    kind[node[:-1][lines]] = LINE
    spline = kind == SPLINE
    _calm(x, length, spline)
    x3_excess, bulging = _concealed(s, spline, x, seen, top3, bounds)
    mesh = Mesh(
        toolpath=toolpath,
        path=path,
        s=s,
        kind=kind,
        x1=x[1],
        x2=x[2],
        x3=x[3],
        top=top3,
        top_limit=which[np.arange(n), top3.argmin(axis=1)],
        node_top=node_top,
        node_acceleration=node_acceleration,
        factor=_factors(s, every),
        x3_excess=x3_excess,
        chord=_chords(toolpath, row, bounds),
        stop=stop,
        corner=corner,
        cuts=cuts[:-1],
        events=_events(toolpath, path, s),
    )
    return mesh, bulging


def _lower_steep(mesh: Mesh, top_at: TopAt) -> None:
    """Lower the bounds of q that do not hold at the quarter points of their interval.

    An interval has bounds q₀, q₁, q₂ at its start, middle and end. A motion that follows them has the parabola through the three,
    which is (3 q₀ + 6 q₁ − q₂)/8 at the first quarter. Beside the place of a curve where a weak axis turns back, the bound V²/x'² of its
    velocity falls by a multiple over an interval, and the parabola is above it at the quarter beside the larger bound, which is lowered.
    Where another limit takes over within the interval, it may be above it beside the least one, and the middle is lowered.

    Args:
        mesh: The intervals; `top` is changed.
        top_at: Gives the largest q.
    """
    top = mesh.top
    low, high = min_over_axes(top), max_over_axes(top)
    with np.errstate(invalid="ignore"):
        bent = np.abs(top[:, 0] - 2.0 * top[:, 1] + top[:, 2]) > BENT * low
    fast = (mesh.top_limit == Limit.VELOCITY) & bent & np.isfinite(high)
    at = np.flatnonzero(fast & (mesh.kind == SPLINE))
    if not len(at):
        return
    places = (mesh.s[at, None] + np.diff(mesh.s)[at, None] * (0.25, 0.75)).ravel()
    bound = top_at(places, mesh.path.evaluate(places, 3), 1).reshape(-1, 2)
    for near, far, own in ((0, 2, bound[:, 0]), (2, 0, bound[:, 1])):
        for place, part in ((near, 3.0), (1, 6.0)):
            over = (3.0 * top[at, near] + 6.0 * top[at, 1] - top[at, far]) / 8.0 - own
            top[at, place] = np.maximum(top[at, place] - 8.0 / part * np.maximum(over, 0.0), low[at])


def _too_many(toolpath: Toolpath, path: Path, bounds: AxisLimits, many: TooManyNodesError) -> Diagnostic:
    """Report the row that needs too many nodes."""
    row = int(path.row_of(np.array([many.s]))[0])
    more = (
        "A larger --max-memory has room for more"
        if many.most < MOST
        else "More memory makes no room for more"
    )
    return Diagnostic(
        "too-many-nodes",
        f"a plan of this motion and those around needs {many.nodes:,.0f} nodes, and has room for {many.most:,}",
        span=toolpath.span(row),
        hint=f"it takes hours at the limits of some axis, or with chords of setpoints within {bounds.chord_mm:g} mm of the path; are these in mm, "
        f"degrees and s? {more}",
        values={"nodes": many.nodes, "most": many.most},
    )


def _straight_on(
    path: Path, feeds: Feeds, corners: Corners, sides: tuple[Floats, Floats]
) -> NDArray[np.bool_]:
    """Tell at which corners a line goes on at its feed with a turn below `_SEEN` that is passed without slowing down.

    Where a program has cut one line into many, rounding of their ends to its decimals makes such turns.
    """
    before, after = rows_beside(path, corners.s)
    out = (path.kind[before] == Kind.LINE) & (path.kind[after] == Kind.LINE) & (after > before)
    out &= np.isinf(corners.speed) & ~corners.stop & ~corners.corner
    out &= np.isclose(feeds.speed[before], feeds.speed[after], rtol=_STRAIGHT, atol=0.0)
    out[[0, -1]] = False
    at = np.flatnonzero(out)
    one, other = (side[1][at] for side in sides)
    out[at] = max_over_axes(np.abs(other - one) / np.maximum(np.abs(one), 1.0)) < _SEEN
    return out


def _lines(path: Path, corners: Corners) -> NDArray[np.bool_]:
    """Tell which stretches between breakpoints are straight lines from rest to rest."""
    row = path.row_of(0.5 * (corners.s[:-1] + corners.s[1:]))
    rests = corners.stop & (corners.back == 0.0)
    return (path.kind[row] == Kind.LINE) & rests[:-1] & rests[1:]


def _calm(x: Floats, h: Floats, spline: NDArray[np.bool_]) -> None:
    """Bound the derivatives on intervals that bend more than nodes are placed for, in place.

    Usually intervals are short beside what the derivatives ask for (`cncgen.planner.least_time.mesh_spacing`). Exceptions are cusps,
    where derivatives are infinite or nothing but rounding, and bends too short to show in setpoints. There |x''| and |x'''|
    are bounded so that the direction turns by `SHARP` over the interval at most, and are made linear over it where it is
    of the `spline`: the path between nodes that setpoints cannot tell apart must not limit the motion.

    Args:
        x: Shape (4, n, 3, axes), position and derivatives at the start, middle and end of each interval; changed.
        h: Shape (n,), lengths, mm.
        spline: Shape (n,), which intervals are of the spline.
    """
    node_places.calm(x, h, spline.view(np.int8), SHARP, _LAST_DIGITS)


def _factors(s: Floats, corners: Corners) -> Floats:
    """Return the rest of the limits beside the jumps on each interval, shape (n, 2, axes): of acceleration and of jerk.

    Where zones overlap, all of them take.
    """
    near = np.flatnonzero(corners.zone > 0)
    first = np.searchsorted(s, corners.s[near] - corners.zone[near], side="right") - 1
    last = np.searchsorted(s, corners.s[near] + corners.zone[near], side="left")
    change = np.zeros((len(s), *corners.jump_share.shape[1:]))
    np.add.at(change, np.maximum(first, 0), corners.jump_share[near])
    np.add.at(change, np.minimum(last, len(s) - 1), -corners.jump_share[near])
    return np.maximum(1.0 - np.cumsum(change, axis=0)[:-1], 1.0 - STEP_TAKES * JUMP_SHARE - SWAY_SHARE)


def _concealed(
    s: Floats, spline: NDArray[np.bool_], x: Floats, seen: Floats, top: Floats, bounds: AxisLimits
) -> tuple[Floats, Ints]:
    """Return by how much |x'''| within an interval may exceed what its three values show, shape (n, axes), and the intervals that bulge.

    The kernel takes x'' and x''' as quadratics over an interval. The first result is the difference of x''' from the quadratic
    at the quarter points, times `_EXCESS`. An interval bulges where what x'' differs by may take more than `_BULGE`
    of the acceleration of an axis, as between the nodes of a curve on which a slow axis turns back. Intervals beside a rest are left
    out: v³ grows as s² there, and at a rest in a cusp x''' is rounding.

    Args:
        s: Shape (n + 1,), nodes.
        spline: Shape (n,), which intervals are beside no rest.
        x: Shape (4, n, 3, axes), derivatives at the start, middle and end of each interval.
        seen: Shape (4, n, 4, axes), those of the path at its start and quarters.
        top: Shape (n, 3), the largest q at the start, middle and end.
        bounds: Limits.
    """
    out, lost = np.empty((len(x[0]), x.shape[3])), np.empty(len(x[0]))
    node_places.concealed(
        s, spline.view(np.int8), x, seen, top, bounds.acceleration, _BELIEVED, _EXCESS, out, lost
    )
    bulging = np.flatnonzero(lost > _BULGE)
    if len(bulging):
        long = np.diff(s) > 2.0 * resolution(bounds, x[1, :, 1])
        bulging = bulging[long[bulging]]
    return out, bulging


def _chords(toolpath: Toolpath, row: Ints, bounds: AxisLimits) -> Floats:
    """Return how far chords may be from the path in rows, shape (n,): under G64 as far as smoothing leaves room for."""
    return np.where(
        toolpath.path_mode[row] == PathMode.CONTINUOUS, toolpath.chord_tolerance[row], bounds.chord_mm
    )


def _events(toolpath: Toolpath, path: Path, s: Floats) -> list[tuple[int, int, Event]]:
    events = [each for each in toolpath.event_rows if s[0] <= path.row_s[each[0]] <= s[-1]]
    node = nearest(s, path.row_s[[row for row, *_ in events]]).tolist() if events else []
    return [(at, line, event) for at, (_, line, event) in zip(node, events, strict=True)]
