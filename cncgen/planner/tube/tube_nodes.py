"""The nodes on the reference, and the room around each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.geometry.path import metric_columns
from cncgen.planner.limits.axis_limits import lowered
from cncgen.planner.tube.programmed import Programmed
from cncgen.planner.tube.reference_path import REST, Grid, Reference
from cncgen.planner.tube.scales import Scales

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
#: Rows of room: centres, directions, radii, the tolerances that these are of, and whether chords are meant.
_Band = tuple[Floats, Floats, Floats, Floats, Floats]

#: Growth of the spacing with the time from close nodes.
_GROWTH = 0.12
#: The path turns by at most so much between nodes, rad.
_TURN = 0.25
#: Spacing on a bend may be so many times the usual one where it takes little of the acceleration.
_CALM = 8.0
#: Part of the acceleration that a bend takes, below which it counts as straight.
_BENT = 1e-4
#: A corner has a node where it leaves the chord between nodes by more than this part of the tolerance, or turns by more, rad.
_SHOWS, _SHARP = 0.1, 0.35
#: The plan follows a corner that it leaves by less than this part of the room.
_FOLLOWS = 0.5
#: Times between nodes for which those beside the ends of a run are spaced by the time of the plan: it gathers speed within that.
_BESIDE_REST = 128.0
#: Below this turn, rad, a disc about the corner stands for the two bands: with them the butterfly takes 15 % more computing.
_SLIGHT = 0.15
#: Rows go back where the chord between their unit tangents is longer, just beyond a right angle.
_GOES_BACK = 1.42
#: Chords at corners have room where these turn by more, rad, and chords may be off the motion by more than this part of the tolerance.
_BOWED, _SAGS = 1e-3, 0.004
#: Chords have room at all nodes where they may be off by more than this part of it.
_BENDS = 0.1
#: Part of the room at which the plan is where it would be outside.
_TAKEN = 0.9
#: Where joints are so many times as far apart as the plan goes between them, it cuts off what lies there; nodes that the motion has on it.
#: With one, a star as large as P takes 3 % longer.
_CUT, _FEWEST = 2.0, 3
#: Tangents before and after a place are opposite where the length of their sum is less: rounding of unit vectors is 1e-16.
_OPPOSITE = 1e-9


@dataclass(slots=True)
class Nodes:
    """Nodes of a run, `k` of them, without the first of the run.

    Attributes:
        s, t: Shape (k,): place and time (with waits) on the reference.
        point, tangent: Shape (k, n): place and direction; a tangent of 0 stands for a node without a plane.
        looser: Shape (k, n): the tangents of the second search, which are 0 at more nodes.
        speed: Shape (k,): speed of the first guess.
        step: Shape (k,): time from the node before.
        plan_speed, plan_step: Shape (k,): the same of the plan, without waits.
        row: Shape (k,): the row before the node, counted from the start of the program.
        part: Shape (k,): part of that row.
        vertex: Shape (k,): row that starts at the node, −1 where it lies within one.
        feed: Shape (k,).
        weight: Shape (k, n): 1 for the axes that the feed is meant over, else 0.
        least: Shape (k,): least time from the node before, s; 0 where the feed of X Y Z is all that holds.
        count: Shape (k,): rows of room.
        centre, direction: Shape (rooms, n).
        radius, allowed: Shape (rooms,): room, and the tolerance that it is of.
        chord: Shape (rooms,): 1 where the room is that of the middle of the chord between setpoints half a period before and after
            the node, 0 where it is that of the node.
    """

    s: Floats
    t: Floats
    point: Floats
    tangent: Floats
    looser: Floats
    speed: Floats
    step: Floats
    plan_speed: Floats
    plan_step: Floats
    row: Ints
    part: Floats
    vertex: Ints
    feed: Floats
    weight: Floats
    least: Floats
    count: Ints
    centre: Floats
    direction: Floats
    radius: Floats
    allowed: Floats
    chord: Floats

    def __len__(self) -> int:
        return len(self.s)

    def nodes(self, first: int, stop: int) -> Nodes:
        """Return some of the nodes."""
        begin = int(self.count[:first].sum())
        rooms = slice(begin, begin + int(self.count[first:stop].sum()))
        return Nodes(
            *(getattr(self, name)[rooms if name in _ROOMS else slice(first, stop)] for name in self.__slots__)
        )

    def joined(self, other: Nodes) -> Nodes:
        """Return these nodes and then others."""
        return Nodes(
            *(np.concatenate([getattr(self, name), getattr(other, name)]) for name in self.__slots__)
        )


_ROOMS = ("centre", "direction", "radius", "allowed", "chord")


def weights(over: Ints, axes: str) -> Floats:
    """Return 1 for the axes of each of `metric_columns`, by its number, shape (k,), else 0, shape (k, axes)."""
    out = np.zeros((len(over), len(axes)))
    for number, group in enumerate(metric_columns(axes)):
        out[over == number, group] = 1.0
    return out


def borders_of(program: Programmed, first: int, places: Floats, speed: Floats, scales: Scales) -> Bools:
    """Tell which of the joints at the starts of rows first + 1 … show between nodes, shape (rows − 1,)."""
    rows = slice(first - program.base, first - program.base + len(places) - 1)
    tolerance, feed = scales.part * program.column("tolerance")[rows], program.column("bound")[rows]
    leave, entry = program.column("leave")[rows], program.column("entry")[rows]
    chord = np.sqrt(((entry[1:] - leave[:-1]) ** 2).sum(axis=1))
    turn = 2.0 * elementary.arcsin(np.minimum(0.5 * chord, 1.0))
    narrow = np.minimum(tolerance[1:], tolerance[:-1])
    time = scales.spacing(narrow)[0]
    shown = (
        turn * np.maximum(speed[1:-1], 2.0 * elementary.cbrt(narrow**2 * scales.jerk)) * time / 4.0
        > _SHOWS * narrow
    )
    return shown | (turn > _SHARP) | (feed[1:] != feed[:-1]) | (tolerance[1:] != tolerance[:-1])


def nodes_of(
    program: Programmed,
    reference: Reference,
    grid: Grid,
    first: int,
    places: Floats,
    border: Bools,
    ends: tuple[bool, bool],
    scales: Scales,
    within: tuple[float, float] = (0.0, 1.0),
) -> Nodes:
    """Return the nodes of rows `first` … , after the first place up to the last one.

    Args:
        program, reference: Rows and plan.
        grid: Samples from the first place to the last one at least.
        first: Number of the first row.
        places: Shape (rows + 1,): s of the reference where each row starts, and where the last one ends.
        border: Shape (rows + 1,): which of these have a node.
        ends: Whether the first and the last place are ends of the run.
        scales: Of the machine.
        within: Parts of the first row and of the last one that the first and the last place are at.
    """
    count = len(places) - 1
    # The row after the last one too, where the run goes on.
    own = slice(first - program.base, first - program.base + count + (not ends[1]))
    tolerance = program.column("tolerance")[own]
    # Fine samples: the grid's, and the joints.
    joint = np.append(program.column("joint")[own][:count].astype(bool), True)
    joint[0] = True
    joint |= border
    clock = _Clock.of(grid, places, joint, border, ends, scales, scales.part * float(tolerance.min()))
    ends_at = np.flatnonzero(border)
    apart = np.sqrt((np.diff(program.joints(own)[ends_at], axis=0) ** 2).sum(axis=1))
    fewest = np.ones(len(places), np.int64)
    fewest[ends_at[:-1][apart > _CUT * np.diff(places[ends_at])]] = _FEWEST
    node, last = clock.spaced(border[joint], fewest[joint])
    vertex = np.full(len(node), -1, np.int64)
    vertex[last] = first + np.searchsorted(places, node[last])
    found = np.clip(np.searchsorted(places, node, side="left") - 1, 0, count - 1)
    part = (node - places[found]) / np.maximum(places[found + 1] - places[found], 1e-300)
    # Rows before a border may have no length on the plan. Where the plan is moving, a run ends before its last row does.
    moving = ends[1] and grid.v[np.searchsorted(grid.s, node[-1], side="left")] > REST
    known = ends_at[1 : len(ends_at) - moving]
    at = np.flatnonzero(last)[: len(known)]
    vertex[at], found[at], part[at] = first + known, known - 1, 1.0
    low, high = np.where(found == 0, within[0], 0.0), np.where(found == count - 1, within[1], 1.0)
    part = low + (high - low) * part
    point, tangent = reference.at(node, -1)
    # Only at borders the path may turn.
    after = tangent.copy()
    after[last] = reference.at(node[last], 1)[1]
    tangent += after
    tangent /= np.maximum(np.sqrt((tangent**2).sum(axis=1)), _OPPOSITE)[:, None]
    feed, over = program.column("bound")[own], program.column("over")[own]
    inner = last & (found + 1 < len(feed))
    ahead = found + inner
    # At a joint the lower feed of both rows, of X Y Z where one of them has that.
    other = (over[ahead] == 0) & (over[found] != 0) | (over[ahead] == over[found]) & (
        feed[ahead] < feed[found]
    )
    holding = np.where(other, ahead, found)
    least = program.column("least")[own]
    upto = np.cumsum(least) - least
    laid = _Laid(
        program, own, places, node, vertex, found, part, point, tangent, _corners(program, own, vertex, found)
    )
    near = program.nearest(point, first + found, part)
    loose, looser = laid.loose(near[1], scales.part)
    rooms = laid.rooms(near, scales)
    without = np.where(looser[:, None], 0.0, tangent)
    tangent[loose] = 0.0
    when = np.interp(node, grid.s, grid.t)
    if ends[1]:
        # At a rest it is the time of arrival.
        when[-1] = grid.t[np.searchsorted(grid.s, node[-1], side="left")]
    return Nodes(
        node,
        when,
        point,
        tangent,
        without,
        clock.speed(node),
        np.diff(np.interp(node, clock.s, clock.time), prepend=0.0),
        np.interp(node, clock.s, clock.v),
        np.diff(np.interp(node, clock.s, clock.free), prepend=clock.free[0]),
        first + found,
        part,
        vertex,
        feed[holding],
        weights(over[holding], program.axes),
        np.diff(upto[found] + part * least[found], prepend=within[0] * least[0]),
        *rooms,
    )


@dataclass(frozen=True, slots=True)
class _Clock:
    """Time by which nodes are spaced: that of the plan beside rests, else that of the plan with corners passed.

    Attributes:
        s: Shape (m,), fine samples on the reference: the grid's, and joints.
        free, v, time, pace: Shape (m,): time and speed of the plan, and those of the clock.
        spacing: Shape (m,), time between nodes.
        where: Shape (joints,), samples that are joints.
        slow: Samples up to the first of which, and from the second of which on, the plan counts.
    """

    s: Floats
    free: Floats
    v: Floats
    time: Floats
    pace: Floats
    spacing: Floats
    where: Ints
    slow: tuple[int, int]

    @classmethod
    def of(
        cls,
        grid: Grid,
        places: Floats,
        joint: Bools,
        border: Bools,
        ends: tuple[bool, bool],
        scales: Scales,
        tolerance: float,
    ) -> _Clock:
        """Return the clock between the first place and the last one; the arguments are those of `nodes_of`, and which rows begin at joints."""
        usual, near = scales.spacing(tolerance)
        seen = places[joint]
        s = np.unique(np.concatenate([grid.s[(grid.s > places[0]) & (grid.s < places[-1])], seen]))
        free, v, bend, rate = (
            np.interp(s, grid.s, each) for each in (grid.free, grid.v, grid.bend, grid.rate)
        )
        cell = np.diff(s)
        # A corner is passed no faster than its slowest axis goes.
        slowest = np.interp(s, grid.s, (np.abs(grid.tangent) / scales.bounds.velocity).max(axis=1))
        floor = np.minimum(scales.floor(tolerance), 1.0 / np.maximum(slowest, 1e-300))
        passing = rate / floor
        quick = np.minimum(np.diff(free), cell * 0.5 * (passing[1:] + passing[:-1]))
        where = np.searchsorted(s, seen)
        blocks = where[np.flatnonzero(border[joint])]
        slow = [0, len(s)]
        # A crawling feed takes hours; its nodes are counted by the way like all others, except at the start and the end.
        if ends[0]:
            middle = np.searchsorted(s, 0.5 * (s[blocks[0]] + s[blocks[1]]))
            slow[0] = min(int(middle), int(np.searchsorted(free, free[0] + _BESIDE_REST * usual)))
            quick[: slow[0]] = np.diff(free)[: slow[0]]
        if ends[1]:
            middle = np.searchsorted(s, 0.5 * (s[blocks[-2]] + s[blocks[-1]]))
            slow[1] = max(int(middle), int(np.searchsorted(free, free[-1] - _BESIDE_REST * usual)))
            quick[slow[1] :] = np.diff(free)[slow[1] :]
        time = np.concatenate([[0.0], np.cumsum(quick)])
        pace = np.maximum(v, floor)
        used = pace**2 * bend / scales.bounds.strongest[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            at = np.where(used > _BENT, usual * np.clip(0.5 / np.sqrt(used), 1.0, _CALM), 1e3)
            at = np.minimum(at, np.maximum(_TURN / (bend * pace), 0.3 * near))
        at[where] = np.minimum(at[where], usual)
        at[blocks] = near
        pace = np.where(np.append(quick, quick[-1:]) <= 0, v, pace)
        return cls(s, free, v, time, pace, lowered(at, _GROWTH * time), where, (slow[0], slow[1]))

    def spaced(self, border: Bools, fewest: Ints) -> tuple[Floats, Bools]:
        """Return nodes, shape (k,), and which of them are borders; `border` tells those of the joints, `fewest` how many follow one at least."""
        s, at = self.s, self.spacing
        u = np.concatenate([[0.0], np.cumsum(np.diff(self.time) * 0.5 * (1.0 / at[1:] + 1.0 / at[:-1]))])
        blocks = self.where[np.flatnonzero(border)]
        least = np.ones(len(s), np.int64)
        least[self.where] = fewest
        each = np.maximum(np.ceil(np.diff(u[blocks]) - 0.2).astype(np.int64), least[blocks[:-1]])
        begin = np.repeat(blocks[:-1], each)
        number = np.arange(each.sum()) - np.repeat(np.cumsum(each) - each, each) + 1
        size = np.repeat(each, each)
        target = u[begin] + (u[np.repeat(blocks[1:], each)] - u[begin]) * number / size
        node = np.interp(target, u, s)
        last = number == size
        node[last] = s[blocks[1:]]
        return node, last

    def speed(self, node: Floats) -> Floats:
        """Return the speed of the clock at nodes, shape (k,)."""
        first, last = self.slow
        begin = self.s[first] if first else -np.inf
        end = self.s[last] if last < len(self.s) else np.inf
        beside = (node < begin) | (node > end)
        return np.where(beside, np.interp(node, self.s, self.v), np.interp(node, self.s, self.pace))


@dataclass(frozen=True, slots=True)
class _Laid:
    """`k` nodes on rows.

    Attributes:
        program, own: The rows.
        places: Shape (rows + 1,): s of the reference where each starts, and where the last one ends.
        node, point, tangent: Shape (k,) and (k, n), s of the nodes, and position and direction of the reference there.
        vertex: Shape (k,): row that starts at the node, −1 where it lies within one.
        row, part: Shape (k,): which of the rows is before the node, and the part of it that is.
        corners: The nodes at corners, the row after each, the narrower tolerance of both rows, and the turn of unit tangents.
    """

    program: Programmed
    own: slice
    places: Floats
    node: Floats
    vertex: Ints
    row: Ints
    part: Floats
    point: Floats
    tangent: Floats
    corners: tuple[Ints, Ints, Floats, Floats]

    def column(self, name: str) -> np.ndarray:
        """Return a column of the rows."""
        return self.program.column(name)[self.own]

    def loose(self, along: Floats, part: float) -> tuple[Bools, Bools]:
        """Tell which nodes have no plane: those of sharp corners, and those from which all is within their room where rows turn back or feeds
        change, or the plan hardly leaves a sharp corner; and of the second ones, within twice of it where rows turn back: one place may then be
        within the tolerance of all between. Rows go `along`; room is that part of the tolerance.

        Planes there would make the motion go as deep into a corner, or into several that are a way back together, as the plan does, and
        change its speed where the plan changes it.
        """
        feed, tolerance = self.column("bound"), part * self.column("tolerance")[self.row]
        # The way that feeds count: s of a row that turns alone is in rad.
        turns = self.column("over")[self.row] == 2
        node = np.cumsum(np.diff(self.node, prepend=self.node[0]) * np.where(turns, self.program.radius, 1.0))
        corner, row, narrow, turn = self.corners
        before, after = along.copy(), along.copy()
        before[corner], after[corner] = self.column("leave")[row - 1], self.column("entry")[row]
        out = np.zeros(len(node), bool)
        out[corner[turn > _SHARP]] = True
        change, pair, lag = np.zeros((2, len(node) + 1), np.int64), np.arange(len(node)), 0
        away = np.sqrt(((self.point[corner] - self.column("start")[row]) ** 2).sum(axis=1))
        followed = corner[(turn > _SHARP) & (away < _FOLLOWS * part * narrow)]
        way = np.concatenate([[0.0], np.cumsum(np.sqrt((np.diff(self.point, axis=0) ** 2).sum(axis=1)))])
        for at, places in ((followed, way), (corner[feed[row] != feed[row - 1]], node)):
            for each in change:
                np.add.at(each, np.searchsorted(places, places[at] - tolerance[at]), 1)
                np.add.at(each, np.searchsorted(places, places[at] + tolerance[at], side="right"), -1)
        span = np.ptp(np.concatenate([before, after]), axis=0)
        if np.sqrt((span**2).sum()) <= _GOES_BACK:
            # None of these directions is opposite to another.
            pair = pair[:0]
        while len(pair):
            # Between a node and the one `lag` after it.
            back = pair[np.sqrt(((after[pair + lag] - before[pair]) ** 2).sum(axis=1)) > _GOES_BACK]
            reach = np.minimum(tolerance[back], tolerance[back + lag])
            for each, times in zip(change, (1.0, 2.0), strict=True):
                begin = np.searchsorted(node, node[back + lag] - times * reach, side="right")
                end = np.searchsorted(node, node[back] + times * reach)
                np.add.at(each, begin[begin < end], 1)
                np.add.at(each, end[begin < end], -1)
            lag += 1
            pair = pair[pair + lag < len(node)]
            pair = pair[node[pair + lag] - node[pair] < 4.0 * tolerance[pair]]
        within = np.cumsum(change[:, :-1], axis=1) > 0
        return out | within[0], out | within[1]

    def rooms(
        self, near: tuple[Floats, Floats], scales: Scales
    ) -> tuple[Ints, Floats, Floats, Floats, Floats, Floats]:
        """Return how many rows of room each node has, and of them what `_Band` says, all for the part of the tolerance that is used.

        Each has the band about the line of its row; at a sharp corner it has those of both rows beside the ball about the corner. There
        chords between setpoints cut the corner off, so they have the room about it as well.
        """
        node, tangent = self.node, self.tangent
        centre, direction = near
        radius, allowed = (self.column("tolerance")[self.row] for _ in range(2))
        # A line through a row has no end. Where the plane lets nodes go along it beyond the row by more than the tolerance, a ball bounds them.
        cosine = np.abs((direction * tangent).sum(axis=1))
        along = radius * np.sqrt(np.maximum(1.0 - cosine**2, 0.0)) / np.maximum(cosine, 1e-9)
        direction[along > self._left() + radius] = 0.0
        band = centre, direction, radius, allowed, np.zeros(len(node))
        self._about_skipped(band)
        sharp, *bands = self._at_corners(band)
        bowed, chords = self._of_chords(band, scales)
        key = np.argsort(np.concatenate([np.arange(len(node)), sharp, sharp, bowed]), kind="stable")
        centres, directions, radii, tolerances, chord = (
            np.concatenate(each)[key] for each in zip(band, *bands, chords, strict=True)
        )
        counts = np.ones(len(node), np.int64)
        counts[sharp] += 2
        counts[bowed] += 1
        where = np.repeat(self.point, counts, axis=0)
        # Where rows fold within the tolerance, the plan may go along another one than this node's. It is within the tolerance, so the room
        # takes it in; the judge looks at all rows.
        away = where - centres
        away -= (away * directions).sum(axis=1)[:, None] * directions
        far = np.sqrt((away**2).sum(axis=1))
        outside = np.where(far > radii, 1.0 - _TAKEN * radii / np.maximum(far, 1e-300), 0.0)
        centres += outside[:, None] * away
        # A part of the radius is within all of it about centres that much nearer to the same points.
        used = scales.part
        centres = where + used * (centres - where)
        return counts, centres, directions, used * radii, used * tolerances, chord

    def _about_skipped(self, band: _Band) -> None:
        """Move the bands of nodes beside corners that have none to the middle of the corners' deviations from their lines, and narrow them.

        Rounds would find that too, for a quarter more computing on the butterfly.
        """
        centre, direction, radius, *_ = band
        node, places = self.node, self.places
        inner = slice(1, len(places) - 1)
        interval = np.searchsorted(node, places[inner], side="left")
        skipped = (interval < len(node)) & (node[np.minimum(interval, len(node) - 1)] != places[inner])
        skipped &= self.column("joint")[inner].astype(bool)
        low, high = np.zeros_like(centre), np.zeros_like(centre)
        corner = self.column("start")[inner][skipped]
        for side in (0, -1):
            k = interval[skipped] + side
            ok = k >= 0
            away = corner[ok] - centre[k[ok]]
            away -= (away * direction[k[ok]]).sum(axis=1)[:, None] * direction[k[ok]]
            np.minimum.at(low, k[ok], away)
            np.maximum.at(high, k[ok], away)
        centre += 0.5 * (low + high)
        radius[:] = np.maximum(radius - 0.5 * np.sqrt(((high - low) ** 2).sum(axis=1)), 0.2 * radius)

    def _at_corners(self, band: _Band) -> tuple[Ints, _Band, _Band]:
        """Turn the bands of nodes at corners into balls about these; return which corners are sharp, and the bands of both rows there.

        At a slight corner the ball takes the place of both bands.
        """
        centre, direction, radius, allowed, _ = band
        start, feed = self.column("start"), self.column("bound")
        corner, after, narrow, turn = self.corners
        slight = turn < _SLIGHT
        # Where the feed changes there is no plane to bound the node along the rows.
        bent = (turn >= 1e-3) | (feed[after - 1] != feed[after])
        ball = corner[bent]
        centre[ball], direction[ball], allowed[ball] = start[after[bent]], 0.0, narrow[bent]
        radius[ball] = narrow[bent] * np.where(slight[bent], np.cos(0.5 * turn[bent]), 1.0)
        at, room = start[after[~slight]], narrow[~slight]
        still = np.zeros(len(room))
        one, other = (
            (at, each[~slight], room, room, still)
            for each in (self.column("leave")[after - 1], self.column("entry")[after])
        )
        return corner[~slight], one, other

    def _of_chords(self, band: _Band, scales: Scales) -> tuple[Ints, _Band]:
        """Return the nodes where chords have room, and that room: at corners that about the corner, across the way where this does not turn
        back, elsewhere that of the node.

        There are none where chords are so near the motion that judging it tells enough.
        """
        off = scales.sagitta(self.column("bound"))[self.row] / scales.part
        corner, after, narrow, turn = self.corners
        bowed = (turn >= _BOWED) & (off[corner] > _SAGS * narrow)
        way = np.where((turn > _GOES_BACK)[:, None], 0.0, self.tangent[corner])[bowed]
        room = narrow[bowed]
        corner, after = corner[bowed], after[bowed]
        about = self.column("start")[after], way, room, room
        beside = np.setdiff1d(np.flatnonzero(off > _BENDS * band[3]), corner)
        both = [np.concatenate([each, other[beside]]) for each, other in zip(about, band[:4], strict=True)]
        node = np.concatenate([corner, beside])
        return node, (both[0], both[1], both[2], both[3], np.ones(len(node)))

    def _left(self) -> Floats:
        """Return how far the row of each node goes on to either side, and those that go on as it does, the shorter of both, shape (k,)."""
        length, joint, row = self.column("length"), self.column("joint").astype(bool), self.row
        upto = np.concatenate([[0.0], np.cumsum(length)])
        ends = np.concatenate([[0.0], upto[1:-1][joint[1:]], upto[-1:]])
        at = upto[row] + self.part * length[row]
        following = np.clip(np.searchsorted(ends, upto[row], side="right"), 1, len(ends) - 1)
        out: Floats = np.minimum(at - ends[following - 1], ends[following] - at)
        return out


def _corners(program: Programmed, own: slice, vertex: Ints, row: Ints) -> tuple[Ints, Ints, Floats, Floats]:
    """Return `_Laid.corners`; the arguments are the other attributes of that name."""
    tolerance = program.column("tolerance")[own]
    corner = np.flatnonzero((vertex >= 0) & (row + 1 < len(tolerance)))
    before, after = row[corner], row[corner] + 1
    change = program.column("entry")[own][after] - program.column("leave")[own][before]
    turn = np.sqrt((change**2).sum(axis=1))
    return corner, after, np.minimum(tolerance[before], tolerance[after]), turn
