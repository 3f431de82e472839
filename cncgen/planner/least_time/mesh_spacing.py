"""Where the nodes of a block stand: dense where the path bends or the motion must slow down, sparse elsewhere.

`mesh` calls `placed` with the breakpoints that `corners` has classified. The block is examined at some places of each panel of the
path (`_probes`). There the largest spacing follows from the path and its limits (`_spacing`). Then it is made to grow slowly along
the path (`graded`), and the nodes are spread by it (`spread_nodes`). Reasons and figures: docs/least-time.md, Where nodes stand.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.geometry.path import Path
from cncgen.kernels import along_path as kernel
from cncgen.kernels import node_places
from cncgen.planner.least_time.breakpoints import NO_TURN, nearest
from cncgen.planner.least_time.corners import Corners
from cncgen.planner.limits.axis_limits import AxisLimits, along_path, lowered, resolution
from cncgen.room import left_of_addresses, room
from cncgen.toolpath.record import Kind

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]
#: Largest q at path coordinates, given the derivatives there, and whether the row before (-1) or after (1) is meant.
TopAt = Callable[[Floats, Floats, int], Floats]


class TooManyNodesError(Exception):
    """A block needs more nodes than there is room for.

    Attributes:
        nodes: How many.
        most: For how many there is room.
        s: Path coordinate where the stretch begins that needs most of them.
    """

    def __init__(self, nodes: float, most: int, s: float) -> None:
        super().__init__(f"{nodes:.3g} nodes")
        self.nodes = nodes
        self.most = most
        self.s = s


#: Largest spacing of nodes: the least of these parts of the radius of curvature; where the bound of the speed has a step, of the way on
#: which the acceleration ramps up from 0 to its limit; and of a panel of the path (docs/arc-length.md).
_OF_RADIUS, _OF_RAMP, _OF_PANEL = 0.08, 0.2, 1.3
#: The jerk that the path alone takes at the speed that the acceleration allows, in limits, from which nodes stand closer, and how many times
#: at most: other terms cancel most of it, and what the interval's quadratics miss of it grows with the spacing squared.
_LOADED, _TIMES = 16.0, 3.0
#: Largest growth of the spacing per length along the path.
_GROWTH = 0.25
#: Length of the interval beside a rest: the least of these parts of the distance in which full jerk reaches full acceleration, of
#: that in which it reaches the largest speed, of the radius of curvature, and of the distance to the next slow place.
_FIRST, _SLOW, _BEND, _PART = 0.125, 0.075, 0.005, 1.0 / 60.0
#: By this factor the shorter one of both sides is less where the motion turns back: constant acceleration leads so far in the same time, as a
#: part of the way on which all jerk would be used. A line of 2.5 mm to and fro takes 0.2 % longer than the least time; 1.3 % with 1, 0.1 % with 64.
_BACK = 16.0
#: Where the path hardly bends beside a rest, that interval need not be shorter than this many periods at the speed there.
_BRIEF = 0.002
#: The end of a jump's zone gets no node of its own if another node is nearer than this part of the zone.
_NARROW = 0.2
#: A bend slows the motion down if its speed is below this part of what is reached from the rest before it; and a bound of the
#: logarithms of speeds, by which `_bends` keeps rests apart.
_LOWER, _LOGS = 0.7, 100.0
#: Bounds of q that differ by less than this part are taken to be equal.
_ALIKE = 1e-6
#: The path counts as straight where following it at top speed takes at most this part of the acceleration limits.
_CALM = 0.01
#: A block that has fewer nodes than this gets closer ones, and by which factor at most.
AMPLE, CLOSEST = 3000, 4.0
#: The plan from which the search for a better path starts has nodes this many times as close: the search ends at the same time.
COARSE = 0.4
#: Nodes of a block at most, and bytes that the derivatives, limits and rows of each take. A block of 2048 butterflies has 1.2 million.
MOST, _BYTES = 2_000_000, 900
#: Of fewer nodes the room is not asked for.
_FEW = 50_000
#: Least distance of nodes as a part of the resolution. Where an axis turns back between two nodes, x'' is bounded (`mesh._calm`), and
#: the acceleration that is not seen is the square root of this, a seventh of the limit for nodes at the resolution itself.
_CLOSER = 0.01
#: Least distance of nodes as a part of the length of the block: a thousand times the rounding of a path coordinate.
_ROUNDING = 2.0**-42


def placed(
    path: Path,
    bounds: AxisLimits,
    corners: Corners,
    sides: tuple[Floats, Floats],
    lines: Bools,
    top_at: TopAt,
    coarse: bool,
) -> Floats:
    """Return the nodes of a block, ascending: its breakpoints, and nodes between them.

    The time that the spline loses falls with the spacing, and `AMPLE` nodes cost next to nothing. So a block with fewer nodes
    gets closer ones, by the factor √(AMPLE/n): a root, so that a node more or less makes no jump in the result.

    Args:
        path: Geometry.
        bounds: Limits.
        corners: Its breakpoints.
        sides: Derivatives on the left and on the right of each breakpoint, shape (4, breakpoints, axes) each.
        lines: Shape (breakpoints − 1,): stretches that need no nodes between their ends.
        top_at: Gives the largest q.
        coarse: Whether few nodes are as good as many.

    Raises:
        TooManyNodesError: They are more than there is room for.
    """
    probes, panels = _probes(path, corners, min(float(resolution(bounds, side[1]).min()) for side in sides))
    at = np.searchsorted(probes, corners.s)
    x = path.evaluate(probes, 3)
    x[:, at] = sides[1]
    x[:, -1] = sides[0][:, -1]
    tops = (top_at(corners.s, sides[0], -1), top_at(corners.s, sides[1], 1))
    shape = _shape(bounds, x, top_at(probes, x, 1), at, sides[0], tops[0])
    before, after = _first(bounds, corners, sides, lines, tops, _bends(shape, probes, corners))
    first = np.minimum(before, after)
    tight = np.flatnonzero((corners.stop & np.isfinite(first)) | (corners.zone > 0))
    beside = np.where(corners.stop, first, _beside(bounds, corners, sides))[tight]
    spacing, least = _spacing(shape, panels, _steps(shape, at, *tops), coarse), _seen(bounds, x[1], probes)
    borders = _borders(corners, before, after, lines)
    whole = lines[np.searchsorted(corners.s, borders[:-1], side="right") - 1] | _beside_rest(corners, borders)

    def nodes(closer: float) -> Floats:
        """Return the nodes of the block, so many times as close."""
        wanted = np.maximum(spacing / closer, least)
        wanted[at[tight]] = np.minimum(wanted[at[tight]], beside)
        return spread_nodes(*graded(probes, wanted, _GROWTH / closer), borders, whole)

    if coarse:
        return nodes(COARSE)
    s = nodes(1.0)
    closer = min(float(np.sqrt(AMPLE / len(s))), CLOSEST)
    return nodes(closer) if closer > 1.0 else s


def along(bounds: AxisLimits, x: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return acceleration and jerk along the path by the weakest axis, and how fast its direction turns, each (n,).

    Turns are measured in units of the axes' limits: the curvature for the acceleration is max |x''|/A over max |x'|/A; the
    path's curvature is that or the same with J, whichever is larger; its change is the same with the third derivative. If all axes
    have the same limits, these are the curvature of the path and its change, in another norm.

    Args:
        bounds: Limits.
        x: Shape (4, n, axes), position and derivatives.

    Returns:
        Acceleration, jerk; the curvature for the acceleration, the path's, and its change.
    """
    out = np.empty((5, x.shape[1]))
    x1, x2, x3 = (np.ascontiguousarray(each) for each in x[1:])
    kernel.turning(bounds.acceleration, bounds.jerk, x1, x2, x3, out)
    return out[0], out[1], out[2], out[3], out[4]


def _shape(
    bounds: AxisLimits, x: Floats, top: Floats, at: Ints, left: Floats, left_top: Floats
) -> tuple[Floats, ...]:
    """Return what `along` does at places, and the largest q there; at breakpoints the worse of both sides.

    Args:
        bounds: Limits.
        x: Shape (4, n, axes), position and derivatives at the places, on their right.
        top: Shape (n,), the largest q there.
        at: Shape (k,), which of them are breakpoints.
        left, left_top: Shape (4, k, axes) and (k,), the same on the left of these.
    """
    found = (*along(bounds, x), top)
    before = (*along(bounds, left), left_top)
    worst = (np.minimum, np.minimum, np.maximum, np.maximum, np.maximum, np.minimum)
    for mine, other, worse in zip(found, before, worst, strict=True):
        mine[at[1:]] = worse(mine[at[1:]], other[1:])
    return found


def _seen(bounds: AxisLimits, x1: Floats, s: Floats) -> Floats:
    """Return the least distance of nodes at the places `s`: by the resolution of setpoints, and by rounding."""
    return np.maximum(_CLOSER * resolution(bounds, x1), _ROUNDING * (s[-1] - s[0]))


def _spacing(shape: tuple[Floats, ...], panels: Floats, steps: Bools, coarse: bool) -> Floats:
    """Return the largest spacing at places of a block by the shape of the path and the speed that it allows, shape (n,), mm.

    Args:
        shape: Result of `_shape` at the places.
        panels: Shape (n,), length of the path's panel there; infinite on lines and arcs.
        steps: Shape (n,), see `_steps`.
        coarse: Whether the load of the jerk is left out of account.
    """
    acceleration, jerk, bend, turn, twist, top = shape
    with np.errstate(divide="ignore", invalid="ignore"):
        out = _OF_RADIUS / turn
        speed = np.sqrt(np.minimum(top, acceleration / bend))
        ramp = speed * np.minimum(acceleration / jerk, np.sqrt(speed / jerk))
        load = twist * (speed * speed * speed) / jerk
    if not coarse:
        # Where a straight line has no bend, it has no load either.
        out = out / np.sqrt(np.fmax(load / _LOADED, 1.0)).clip(None, _TIMES)
    out = np.where(steps, np.minimum(out, _OF_RAMP * ramp), out)
    # Panels follow the parameter, too: where a straight curve stands still, they are tiny and independent of the path.
    with np.errstate(invalid="ignore"):
        turns = turn * panels + twist * panels**2 > NO_TURN
    return np.where(turns, np.minimum(out, _OF_PANEL * panels), out)


def _steps(shape: tuple[Floats, ...], at: Ints, left: Floats, right: Floats) -> Bools:
    """Tell at which places the bound of q may have a step, or changes although the path is straight (a cap does), shape (n,).

    Elsewhere nodes that follow the bends of the path are dense enough for the ramps of the acceleration, too. Without this, lines of
    changing feeds take 1 to 17 % longer; everywhere, planning takes 1.9 times the CPU.

    Args:
        shape: Result of `_shape` at the n places.
        at: Shape (k,), which of them are breakpoints.
        left, right: Shape (k,), the largest q on both sides of these.
    """
    acceleration, _, bend, _, _, top = shape

    def differ(one: Floats, other: Floats) -> Bools:
        out: Bools = np.abs(one - other) > _ALIKE * np.minimum(one, other)
        return out

    with np.errstate(invalid="ignore"):
        changes = differ(top[1:], top[:-1])
        out: Bools = (np.append(changes, False) | np.append(False, changes)) & (
            bend * top < _CALM * acceleration
        )
        out[at] |= differ(left, right)
    # The block does not know whether there is one at its ends.
    out[[0, -1]] = True
    return out


def _bends(shape: tuple[Floats, ...], s: Floats, corners: Corners) -> tuple[Floats, Floats]:
    """Return how far before and after each breakpoint where the motion rests it must slow down for a bend or a feed, infinite for none.

    That is the nearest place of which the speed, by what the path is like there, is a part `_LOWER` of what full jerk and full
    acceleration from the rest reach between, as the path lets them.

    Args:
        shape: Result of `_shape` at the places `s`.
        s: Shape (n,), places, ascending.
        corners: The breakpoints, which are among the places.
    """
    acceleration, jerk, bend, _, twist, top = shape
    rest = np.searchsorted(s, corners.s[corners.stop])
    found = np.full((2, len(corners.s)), np.inf)
    if not len(rest):
        return found[0], found[1]
    with np.errstate(divide="ignore"):
        speed = np.minimum(np.sqrt(np.minimum(top, acceleration / bend)), elementary.cbrt(jerk / twist))
    here = np.arange(len(s))
    for out, step in zip(found, (-1, 1), strict=True):
        # Number of the rest that each place is left from, in the order of the way; −1 before the first one.
        order = here[::step]
        number = np.searchsorted(np.sort(step * rest), step * order, side="right") - 1
        order, number = order[number >= 0], number[number >= 0]
        start = rest[::step][number]
        way = np.abs(s[order] - s[start])
        gained = np.minimum(
            elementary.cbrt(4.5 * jerk[start] * way**2), np.sqrt(2.0 * acceleration[start] * way)
        )
        # The running maximum from each rest on, of all rests at once: each is given a range of logarithms of its own.
        with np.errstate(divide="ignore"):
            height = elementary.log(np.minimum(gained, speed[order])).clip(-_LOGS, _LOGS)
        reached = np.maximum.accumulate(height + 4.0 * _LOGS * number) - 4.0 * _LOGS * number
        slow = np.flatnonzero(elementary.log(speed[order]) < reached + elementary.log(_LOWER))
        away = np.full(len(rest), np.inf)
        np.minimum.at(away, number[slow], way[slow])
        out[corners.stop] = away[::step]
    return found[0], found[1]


def _first(
    bounds: AxisLimits,
    corners: Corners,
    sides: tuple[Floats, Floats],
    lines: Bools,
    tops: tuple[Floats, Floats],
    bends: tuple[Floats, Floats],
) -> tuple[Floats, Floats]:
    """Return the lengths of the intervals before and after each breakpoint where the motion rests.

    They are infinite where it does not rest, and where nothing but straight lines from rest to rest meets.

    Args:
        bounds, corners, sides, lines: As `placed` takes them.
        tops: Shape (breakpoints,) each, the largest q on their left and right.
        bends: Shape (breakpoints,) each, how far before and after each rest the motion must slow down for a bend or a feed.
    """
    curved = ~(np.concatenate([[True], lines]) & np.concatenate([lines, [True]]))
    rest = np.flatnonzero(corners.stop & curved)
    slow = _slow_places(corners)
    apart = _PART * np.diff(slow, prepend=-np.inf, append=np.inf)
    at = np.searchsorted(slow, corners.s[rest])
    gap = np.diff(corners.s, prepend=-np.inf, append=np.inf) / 3.0
    found = []
    for x, far, near, bent, top in (
        (sides[0], apart[at], gap[:-1], bends[0], tops[0]),
        (sides[1], apart[at + 1], gap[1:], bends[1], tops[1]),
    ):
        acceleration, jerk, _, turn, _ = along(bounds, x[:, rest])
        # Where a curve stands, no limit bounds the motion along it, and the first wish is no number.
        with np.errstate(divide="ignore", invalid="ignore"):
            # From rest full jerk reaches v after √(2 v/j) and so (2 v)^(3/2)/(6 √j).
            speed = np.sqrt(top[rest])
            slow = elementary.power(2.0 * speed, 1.5) / (6.0 * np.sqrt(jerk))
            wanted = [
                _FIRST * elementary.power(acceleration, 3.0) / (6.0 * jerk**2),
                _SLOW * slow,
                _BEND / turn,
            ]
        # Where the top speed is reached almost at once, the interval may be shorter than the least distance of nodes: on it
        # constant jerk takes three times as long as the top speed would.
        least, brief = _seen(bounds, x[1], corners.s)[rest], _BRIEF * bounds.period_s * speed
        least = np.where(wanted[2] > brief, np.minimum(least, brief), least)
        out = np.full(len(corners.s), np.inf)
        wanted.append(_PART * bent[rest])
        out[rest] = np.minimum.reduce([np.maximum(np.fmin.reduce(wanted), least), far, near[rest]])
        found.append(out)
    back = corners.back > 0.0
    found[0][back] = found[1][back] = np.minimum(found[0][back], found[1][back]) / _BACK
    return found[0], found[1]


def _slow_places(corners: Corners) -> Floats:
    """Return where rests and passed corners are, shape (k,), which slow the motion alike; a border of the block may be beside one."""
    slow = corners.stop | np.isfinite(corners.speed)
    slow[[0, -1]] = True
    return corners.s[slow]


def _beside(bounds: AxisLimits, corners: Corners, sides: tuple[Floats, Floats]) -> Floats:
    """Return the largest spacing at breakpoints with a jump: a part of its zone, and where the speed there is low, of the
    way on which full jerk raises it by half."""
    jerk = along_path(bounds.jerk, sides[0][1], sides[1][1])
    with np.errstate(invalid="ignore"):
        ramp = np.sqrt(corners.speed / jerk)
        return np.fmin(0.35 * corners.zone, 0.25 * corners.speed * ramp)


def _probes(path: Path, corners: Corners, seen: float) -> tuple[Floats, Floats]:
    """Return places to look at the path, four a panel: borders of its panels, its breakpoints, and points between; and the
    length of the panel there, which a polynomial of low degree carries (infinite on lines and arcs).

    An arc is cut where an axis stands on it: beside a weak axis, what the path allows changes by as much as the limits
    differ within a small angle there, which places any way apart would miss.

    Panels that begin nearer to a breakpoint than `seen` are too small to be seen: about a cusp their derivatives are
    rounding alone.
    """
    turning = path.turning_points()
    borders = path.sample_borders()
    borders = np.union1d(borders, turning[np.diff(turning, prepend=-np.inf) > seen])
    borders = borders[(borders >= corners.s[0]) & (borders <= corners.s[-1])]
    near = nearest(corners.s, borders)
    borders = np.union1d(borders[np.abs(corners.s[near] - borders) > seen], corners.s)
    length = np.diff(borders)
    inner = borders[:-1, None] + length[:, None] * np.array([0.0, 0.25, 0.5, 0.75])
    straight = path.kind[path.row_of(borders[:-1])] != Kind.NURBS
    cells = np.where(straight, np.inf, length)
    there = np.append(np.repeat(cells, 4), cells[-1])
    there[4:-1:4] = np.minimum(cells[:-1], cells[1:])
    return np.append(inner.ravel(), borders[-1]), there


def graded(s: Floats, spacing: Floats, growth: float) -> tuple[Floats, Floats]:
    """Lower the spacing so that it grows by at most `growth` per length along the path, in both directions.

    Between places whose spacing differs by much it grows from the smaller one as fast as it may, up to the larger one:
    where it ends to grow or begins to shrink, places are inserted. Elsewhere it is linear.

    Args:
        s: Shape (n,), places, ascending.
        spacing: Shape (n,), largest spacing there.
        growth: Largest growth.

    Returns:
        Places, those inserted among them, and the spacing there.
    """
    fine, out = np.empty((2, 3 * len(s)))
    count = node_places.graded(s, spacing, lowered(spacing, growth * s), growth, fine, out)
    return fine[:count], out[:count]


def _borders(corners: Corners, before: Floats, after: Floats, lines: Bools) -> Floats:
    """Return the places that must be nodes: breakpoints, the first interval on the curved sides of a rest, and zones."""
    leaves = np.flatnonzero(corners.stop[:-1] & ~lines)
    enters = np.flatnonzero(corners.stop[1:] & ~lines) + 1
    first = np.concatenate([corners.s[leaves] + after[leaves], corners.s[enters] - before[enters]])
    return _with_zones(corners, np.unique(np.concatenate([corners.s, first])))


def _with_zones(corners: Corners, borders: Floats) -> Floats:
    """Add the places where a jump begins and ends to be seen, as less jerk is left between them than beside them.

    Those stay out that lie within the first interval from a rest, or much nearer to another border than the zone is wide.
    """
    passed = np.flatnonzero(corners.zone > 0.0)
    if not len(passed):
        return borders
    s, zone = corners.s[passed], corners.zone[passed]
    edge, which = np.unique(np.concatenate([s - zone, s + zone]), return_index=True)
    least = _NARROW * np.tile(zone, 2)[which]
    after = np.clip(np.searchsorted(borders, edge), 1, len(borders) - 1)
    apart = np.minimum(edge - borders[after - 1], borders[after] - edge)
    apart = np.minimum(apart, np.diff(edge, prepend=-np.inf))
    return np.union1d(borders, edge[(apart > least) & ~_beside_rest(corners, borders)[after - 1]])


def _beside_rest(corners: Corners, borders: Floats) -> Bools:
    """Tell which stretches between borders leave or enter a rest."""
    rest = np.zeros(len(borders), bool)
    rest[np.searchsorted(borders, corners.s[corners.stop])] = True
    return rest[:-1] | rest[1:]


def spread_nodes(s: Floats, spacing: Floats, borders: Floats, whole: Bools) -> Floats:
    """Divide each stretch between borders evenly in the measure ds / spacing; `whole` stretches are not divided.

    Raises:
        TooManyNodesError: They are more than `MOST`, or take more memory than the run has.
    """
    up_to, at, count = np.empty(len(s)), np.empty(len(borders)), np.empty(len(whole))
    node_places.measure(s, spacing, borders, whole.view(np.int8), up_to, at, count)
    needed = float(count.sum())
    most = MOST if needed <= _FEW else int(min(MOST, room() / _BYTES, left_of_addresses() / _BYTES))
    if not needed <= most:
        raise TooManyNodesError(needed, most, float(borders[np.argmax(count)]))
    nodes = np.empty(int(count.sum()) + 1)
    return nodes[: node_places.spread(s, spacing, borders, up_to, at, count, nodes)]
