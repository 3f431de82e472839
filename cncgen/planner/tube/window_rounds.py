"""The rounds of a window's search, each with less room or held speeds where the one before broke what is asked of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.planner.tube.deviation import PHASES, Reached, excess, tangled
from cncgen.planner.tube.programmed import RowLines
from cncgen.planner.tube.scales import SPACING, Bounds
from cncgen.planner.tube.tube_nodes import Nodes
from cncgen.planner.tube.window_judge import too_fast
from cncgen.planner.tube.window_problem import Problem, Solved
from cncgen.planner.tube.window_start import Found, again, begun, faster

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: By how much more than it is too much room is narrowed where the motion leaves the tolerance between nodes.
_MORE = 1.1
#: Part of a window from which on all of it is searched again.
_MOSTLY = 0.6
#: Where the motion of a round takes so many times as long as that of the round before, or so many iterations, the search has lost its
#: way, and begins anew as well.
_LOST, _ASTRAY = 1.05, 100
#: Rounds in which only the nodes beside such a place have less room; then all those within half a period have, as chords reach there: from
#: the first on, one of 49 random programs takes 0.5 % longer. Least room, as a part of the tolerance.
_LOCAL, _NARROWEST = 2, 0.1
#: Part of the tolerance that is planned with by which a motion may be over it.
PASSED = 0.004
#: Part of limits and feeds that a search is given, as what it finds is exact but for rounding; and of the least times of rows, which mean
#: nearly the same as the feed: with 0.9999 of these, fewer windows of five axes had a solution.
_WITHIN, _PACE = 1.0 - 1e-6, 0.9998
#: Times between nodes are at most so many times as long as usual beside those without a plane.
_LONGEST = 1.5
#: Rounds of a window, at most.
_ROUNDS = 9
#: An axis that moves less stands still, mm.
_STILL = 1e-7
#: Nodes after the beginning of a window that keep their room ahead: the state that is expected there may be over the tolerance itself.
_BEGIN = 10
#: Units of search, of some 10 µs each, that a round takes beside its steps, a step of Newton's method at a node of two axes, and the
#: comparison of a chord with a line.
_ROUND, _STEP, _CELL = 120, 0.03, 0.004


@dataclass(slots=True)
class Window:
    """Nodes that are planned at once.

    Attributes:
        nodes: Those after where the run is.
        final: After how many of them the next window begins; all where none does.
        state, t: Shape (3, axes), the state where it begins, and when on the reference.
        first: Whether the plan, and no motion in its place, goes before it.
        path, goals: The rows, and where on them its setpoints begin and have to end; None where that cannot be told.
    """

    nodes: Nodes
    final: int
    state: Floats
    t: float
    first: bool
    path: RowLines
    goals: tuple[Reached, Reached] | None

    @property
    def whole(self) -> bool:
        """Whether no other window begins within it."""
        return self.final == len(self.nodes)

    @property
    def tangled(self) -> bool:
        """Whether corners are so near each other that there are many local optima."""
        return tangled(self.path, vertex_nodes(self))


class Rounds:
    """The rounds of a window: each searches, and narrows the room or holds speeds where what it found breaks something.

    Attributes:
        window: The window; as it is expected, where its rounds have begun ahead.
        number: Of the last round; -1 before the first.
        motion: The motion found by that search, over all axes.
        exact: Whether it holds all that the search is given, from where the window begins.
        tangent: Shape (nodes, axes), those of the planes of nodes.
        early: Whether where it begins is only expected.
        changed: Whether judging it has changed what the next one is given.
        units: The work of the rounds that is not counted yet.
    """

    def __init__(self, window: Window, bounds: Bounds, goal: Floats, allowed: Floats) -> None:
        """Begin with none.

        Args:
            window: The window.
            bounds: The limits.
            goal: Shape (3, axes), the state where it ends.
            allowed: Shape (nodes,), the tolerance at them.
        """
        nodes = window.nodes
        self.window, self.goal, self.allowed = window, goal, allowed
        fastest = max(nodes.feed.max(), np.abs(window.state[1]).max(), np.abs(goal[1]).max())
        self.bounds = bounds.within(float(allowed.max()), float(fastest))
        self.columns = moving(window.state, nodes)
        self.number, self.units, self.exact, self.changed, self.early = -1, 0, False, False, False
        self.tangent = nodes.tangent
        self._radius, self._held = nodes.radius, np.zeros(len(nodes), bool)
        self._own = vertex_nodes(window)
        self._parts = [(0, len(nodes))]
        self._got: Found | None = None
        # Steps of Newton's method grow with the square of the axes: 0.25, 0.51 and 1.49 µs a node for two, three and five.
        self._step = _STEP * len(nodes) * (len(self.columns) / 2.0) ** 2

    def search(self) -> bool:
        """Make the next round; return whether it finds a motion."""
        nodes = self.window.nodes
        self.number += 1
        # The first round shows where room has to be less, which needs no exact motion.
        near = self.number == 0
        given, spent = self._given(), 0
        lost = self._got is None
        if self._got is not None:
            # A search that goes astray ends in a motion as well, far from the fastest one.
            before = float(self._got[1].step.sum())
            self._got, spent = _narrower(self._got, given, self._parts)
            took = self._got[1]
            lost = took.status != 1 or took.iterations > _ASTRAY or float(took.step.sum()) > _LOST * before
        if lost:
            tangled = self.window.tangled
            anew, more = begun(given, nodes, near, tangled) if near or not self.early else (None, 0)
            self._got, spent = faster(self._got, anew), spent + more
        self.units += _ROUND + int(self._step * spent)
        self.exact = not near
        if self._got is None:
            return False
        self.motion = _spread(self._got[1], self.columns, self.window.state, self.goal[0])
        return True

    def judge(self, first_s: float, phases: int) -> bool:
        """Tell whether the motion breaks tolerance, velocity or feed, which the next round is then given less of.

        Args:
            first_s: Time of its first setpoint.
            phases: Phases of setpoints that are looked at.
        """
        window, nodes, columns = self.window, self.window.nodes, self.columns
        assert window.goals is not None
        assert self._got is not None
        found = self._got[1]
        given = (window.path, window.goals, self._own, self.motion, first_s, self.bounds.period_s, PASSED)
        over, cells = excess(*given, phases)
        self.units += int(_CELL * cells)
        if self.early:
            over[:_BEGIN] = -np.inf
        feed = np.maximum(nodes.feed, np.append(nodes.feed[:1], nodes.feed[:-1]))
        weight = nodes.weight.take(columns, axis=1)
        weight[1:] *= weight[:-1].copy()
        fast = too_fast(found, self.bounds.velocity[columns], feed, weight)
        known, before = self._held.copy(), self._radius
        if fast.any():
            # The neighbours soon are, once these are held: twice as many in each round, as all of a window may be. With all of it at
            # once, four of 205 random programs take 0.5 to 5 % longer, and one 3 % less.
            reach = 4 << self.number
            self._held |= np.convolve(fast, np.ones(2 * reach + 1))[reach:-reach] > 0
            # A motion that begins or ends at a limit has the middle ordinate beside that at the limit as well.
            self._held[0] = self._held[-1] = False
        self._radius = self._narrowed(over, found.step)
        changed = (
            np.bincount(np.repeat(np.arange(len(nodes)), nodes.count), self._radius != before, len(nodes)) > 0
        )
        changed |= self._held != known
        self.changed = bool(changed.any())
        if self.number:
            # A motion that begins elsewhere than its search did is made to meet that state.
            changed[0] |= not self.exact
            self._parts = _parts(changed, np.cumsum(found.step), self.bounds.felt(float(nodes.feed.max())))
        return bool((over > -np.inf).any() or fast.any())

    @property
    def found(self) -> bool:
        """Whether the last round has found a motion."""
        return self._got is not None

    def to_end(self, first: Callable[[Solved], float], left: Callable[[], float] = lambda: np.inf) -> bool:
        """Judge the motion, and make rounds until one holds what is asked; return whether one does.

        Args:
            first: Returns the time of the first setpoint of a motion.
            left: Returns the units that are left: without any, what breaks something is not searched again.
        """
        while True:
            broken = self.judge(first(self.motion), PHASES if self.number else 1)
            if self.exact and not (broken and self.changed):
                return not broken
            if (broken and left() < 0.0) or self.number == _ROUNDS - 1 or not self.search():
                return False

    def ahead(self, first_s: float) -> bool:
        """Make the first two rounds, or one where it is not known where on the rows the window begins; return whether they find a motion."""
        self.early = True
        found = self.search()
        if found and self.window.goals is not None:
            self.judge(first_s, 1)
            found = self.search()
        self.early = False
        return found

    def taken(self, window: Window) -> bool:
        """Go on with the window as it is, from another state near the one expected; return whether the same axes move."""
        assert self._got is not None
        if not np.array_equal(self.columns, moving(window.state, window.nodes)):
            return False
        search = self._got[0]
        self.window, self._own, self.exact = window, vertex_nodes(window), False
        self._got = search, search.begin(window.state[:, self.columns])
        self.motion = _spread(self._got[1], self.columns, window.state, self.goal[0])
        return True

    def _narrowed(self, over: Floats, step: Floats) -> Floats:
        """Return the room of nodes, less where setpoints are over the tolerance before a node and beside that."""
        nodes = self.window.nodes
        more = np.maximum(over, np.append(over[1:], -1.0))
        if self.number >= _LOCAL:
            more = _around(more, np.cumsum(step), 0.5 * self.bounds.period_s)
        less = np.where(more > 0.0, _MORE * more + 1e-3 * 2.0**self.number * self.allowed, 0.0)
        out: Floats = np.maximum(
            self._radius - np.repeat(less, nodes.count),
            np.minimum(self._radius, _NARROWEST * nodes.allowed),
        )
        return out

    def _given(self) -> Problem:
        """Return the problem of the next round."""
        start, nodes, columns, bounds = self.window.state, self.window.nodes, self.columns, self.bounds
        point = np.concatenate([start[:1], nodes.point]).take(columns, axis=1)
        tangent = np.concatenate([self.tangent[:1], self.tangent]).take(columns, axis=1)
        tangent /= np.maximum(np.sqrt((tangent**2).sum(axis=1)), 1e-300)[:, None]
        # The state at the end is given: it needs no room.
        rooms = slice(len(nodes.radius) - int(nodes.count[-1]))
        feed = _WITHIN * np.append(nodes.feed[:1], nodes.feed)
        return Problem(
            velocity=_WITHIN * bounds.velocity[columns],
            acceleration=_WITHIN * bounds.acceleration[columns],
            jerk=_WITHIN * bounds.jerk[columns],
            weight=np.concatenate([nodes.weight[:1], nodes.weight]).take(columns, axis=1),
            point=point,
            tangent=tangent,
            step=nodes.step,
            first=np.concatenate([[0, 0], np.cumsum(nodes.count[:-1]), [rooms.stop]]).astype(np.int64),
            centre=nodes.centre[rooms].take(columns, axis=1),
            direction=nodes.direction[rooms].take(columns, axis=1),
            radius=self._radius[rooms],
            bow=nodes.chord[rooms] * bounds.period_s**2 / 8.0,
            feed=feed,
            shortest=_PACE * nodes.least,
            longest=self._longest(),
            between=np.where(self._held, np.maximum(feed[1:], feed[:-1]), np.inf),
            start=start[:, columns],
            goal=self.goal[:, columns],
            period_s=bounds.period_s,
        )

    def _longest(self) -> Floats:
        """Return the most of the times between nodes, shape (k,), s: infinite but beside nodes that no plane holds.

        Such nodes gather where the motion is slow, and one interval beside them grew so long that the motion left its room there.
        """
        loose = (self.tangent == 0.0).all(axis=1)
        jerk = self.bounds.jerk[self.columns]
        weakest = float(jerk.min())
        usual = _LONGEST * SPACING[0] * elementary.cbrt(self.allowed / weakest)
        return np.where(loose | np.append(loose[:1], loose[:-1]), usual, np.inf)


def moving(start: Floats, nodes: Nodes) -> Ints:
    """Return the axes that move from a state over nodes."""
    return np.flatnonzero(np.ptp(np.concatenate([start[:1], nodes.point]), axis=0) > _STILL)


def vertex_nodes(window: Window) -> Ints:
    """Return the node of each vertex of the rows of a window, −1 where it has none, shape (vertices,)."""
    key, vertex = window.path.key, window.nodes.vertex
    out = np.full(len(key), -1)
    node = np.flatnonzero((vertex >= key[0]) & (vertex <= key[-1]))
    out[np.searchsorted(key, vertex[node])] = node
    return out


def _around(values: Floats, t: Floats, reach: float) -> Floats:
    """Return the largest of values, and of those above 0 within a time of each, shape (k,)."""
    if not (values > 0.0).any():
        return values
    near = np.stack([np.searchsorted(t, t - reach), np.searchsorted(t, t + reach, side="right")], axis=1)
    largest = np.maximum.reduceat(np.append(values, -np.inf), near.ravel())[::2]
    return np.where(largest > 0.0, largest, values)


def _parts(changed: NDArray[np.bool_], t: Floats, reach: float) -> list[tuple[int, int]]:
    """Return the first and last nodes of the parts of a window within a time of what has changed before nodes 1 and on, at times `t`."""
    beside = np.flatnonzero(np.diff(np.r_[0.0, _around(changed.astype(float), t, reach), 0.0]))
    parts = [(int(first), int(last)) for first, last in beside.reshape(-1, 2)]
    long = sum(last - first for first, last in parts) > _MOSTLY * len(t)
    return [(0, len(t))] if long else parts


def _narrower(got: Found, given: Problem, parts: list[tuple[int, int]]) -> tuple[Found, int]:
    """Return a search that goes on with less room in parts of a window, or else in all of it and from further away; and the iterations over all."""
    search, before = got
    guess, steps, spent = again(given, before), len(given.step), 0
    for each, far in ((parts, False), ([(0, steps)], True)):
        found = search.narrower(given, guess, each, far)
        spent += -(-found.iterations * sum(last - first for first, last in each) // steps)
        if found.status == 1:
            break
    return (search, found), spent


def _spread(found: Solved, columns: Ints, state: Floats, end: Floats) -> Solved:
    """Return a motion over all axes, of which the others stand, whose last interval comes to its end exactly.

    Nodes are met within the resolution of setpoints; the last one is where the motion rests or the plan goes on.
    """
    count, axes = len(found.step), len(end)
    position, velocity, acceleration, jerk = found.position, found.velocity, found.acceleration, found.jerk
    if len(columns) < axes:
        position = np.broadcast_to(state[0], (count + 1, axes)).copy()
        velocity, acceleration, jerk = (np.zeros((rows, axes)) for rows in (count + 1, count + 1, count))
        for whole, part in (
            (position, found.position), (velocity, found.velocity), (acceleration, found.acceleration), (jerk, found.jerk)
        ):  # fmt: skip
            whole[:, columns] = part
    else:
        position = position.copy()
    h = found.step[-1]
    way = h * (velocity[-2] + h * (acceleration[-2] / 2.0 + h * jerk[-1] / 6.0))
    position[-2:] = end - way, end
    return replace(found, position=position, velocity=velocity, acceleration=acceleration, jerk=jerk)
