"""The search of a window's motion, in rounds, each with less room or held speeds where the one before broke what is asked of it."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.record import Machine
from cncgen.planner.tube.deviation import PHASES, Reached, excess
from cncgen.planner.tube.handing import Hand
from cncgen.planner.tube.programmed import Programmed, RowLines
from cncgen.planner.tube.reference_path import Reference
from cncgen.planner.tube.tube_nodes import Nodes
from cncgen.planner.tube.window_judge import REST, holds, joins, too_fast
from cncgen.planner.tube.window_problem import Problem, Solved
from cncgen.planner.tube.window_start import Found, again, begun, faster

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: The way that a stop takes, in time of the reference, over which the end of a window is felt: a multiple of v/A + A/J.
_FELT = 1.2
#: Times that the room is narrowed where the motion leaves the tolerance between nodes, and by how much more than that.
_ROUNDS, _MORE = 9, 1.1
#: Parts of `_FELT` on both sides of what a round changes that are searched again, and of the window from which on all of it is.
_BESIDE, _MOSTLY = 1.0, 0.6
#: Iterations of a round after which the search is begun anew as well.
_LONG = 25
#: Rounds in which only the nodes beside such a place have less room; then all those within half a period have, as chords reach there.
#: Least room, as a part of the tolerance.
_LOCAL, _NARROWEST = 2, 0.1
#: Part of the tolerance that is planned with by which a motion may be over it.
PASSED = 0.004
#: An axis that moves less stands still, mm.
_STILL = 1e-7
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


@dataclass(frozen=True, slots=True)
class _Ahead:
    """The search of the window that is expected next, from where the motion is likely to be at its beginning.

    Attributes:
        nodes, columns: Those of the window, and the axes that move there.
        found: A motion near the solution, once it is there.
    """

    nodes: Nodes
    columns: Ints
    found: Future[tuple[Found | None, int]]

    def taken(self, nodes: Nodes, columns: Ints, state: Floats) -> tuple[Found | None, int]:
        """Return the search and what it found, from another state near its own, if this is its window; and its iterations."""
        same = len(nodes) == len(self.nodes) and all(nodes.s[k] == self.nodes.s[k] for k in (0, -1))
        if not (same and np.array_equal(columns, self.columns)):
            return None, 0
        got, spent = self.found.result()
        return got and (got[0], got[0].begin(state[:, columns])), spent


class WindowSearch:
    """The search of one window after the other.

    Attributes:
        units, bound: What all searches have taken, in units of some 10 µs, and what they may take.
    """

    def __init__(
        self,
        program: Programmed,
        machine: Machine,
        reference: Reference,
        hand: Hand,
        limits: tuple[Floats, Floats, Floats],
    ) -> None:
        """Take what windows are of.

        Args:
            program: The rows.
            machine: Its period.
            reference: The plan along them.
            hand: What hands on the motions that are found.
            limits: Shape (axes,) each: velocity, acceleration and jerk.
        """
        self.program, self.machine, self.reference, self.hand = program, machine, reference, hand
        self.velocity, self.acceleration, self.jerk = limits
        self.units = self.bound = 0
        self.pool = ThreadPoolExecutor(1, "tube")
        self.ahead: _Ahead | None = None

    def close(self) -> None:
        """End its thread."""
        self.pool.shutdown(cancel_futures=True)

    def felt(self, feed: float) -> float:
        """Return the time over which the end of a window has influence, at a feed that bounds linear axes."""
        speed = np.where(np.arange(len(self.velocity)) < 3, np.minimum(self.velocity, feed), self.velocity)
        limited = np.isfinite(self.jerk)
        times = speed[limited] / self.acceleration[limited] + self.acceleration[limited] / self.jerk[limited]
        return _FELT * float(times.max())

    def solved(self, window: Window, following: Callable[[int], Nodes | None]) -> Solved | None:
        """Return a motion within all limits and the tolerance, or None where none is found.

        Args:
            window: The window.
            following: Returns the nodes of the window after so many of the nodes of this one, whose search then begins; None where
                they are not known yet.
        """
        nodes, path, goals = window.nodes, window.path, window.goals
        assert goals is not None
        columns = moving(window.state, nodes)
        goal = self.reference.state(float(nodes.s[-1]), float(nodes.t[-1]))
        radius, held, parts = nodes.radius, np.zeros(len(nodes), bool), [(0, len(nodes))]
        got, spent = (None, 0) if self.ahead is None else self.ahead.taken(nodes, columns, window.state)
        self.ahead = None
        # Steps of Newton's method grow with the cube of the axes.
        step = _STEP * len(nodes) * (len(columns) / 2.0) ** 3
        for number in range(_ROUNDS):
            if self.units > self.bound:
                return None
            given = self._given(window.state, nodes, goal, columns, held)
            given = replace(given, radius=radius[: len(given.radius)])
            # The first round shows where room has to be less, which needs no exact motion.
            near = number == 0
            if got is not None and not near:
                got, spent = _narrower(got, given, parts)
            if got is None or got[1].status != 1 or got[1].iterations > _LONG:
                # What ends because iterations run out is a motion, but not the fastest one.
                anew, more = begun(given, nodes, near)
                got, spent = faster(got, anew), spent + more
            self.units += _ROUND + int(step * spent)
            if got is None:
                return None
            found = got[1]
            feed = np.maximum(nodes.feed, np.append(nodes.feed[:1], nodes.feed[:-1]))
            fast = too_fast(found, self.velocity[columns], feed, int((columns < 3).sum()))
            lifted = _spread(found, columns, window.state, goal[0])
            if near and not window.whole:
                self._go_ahead(following(window.final), window.final, lifted)
            first = self.hand.first_setpoint(window.t, found)
            phases = 1 if near else PHASES
            over, cells = excess(path, goals, lifted, first, self.machine.period_s, PASSED, phases)
            self.units += int(_CELL * cells)
            if not near and not (over > -np.inf).any() and not fast.any():
                ends, period = (window.state, goal), self.machine.period_s
                kept = holds(lifted, ends, self.acceleration, self.jerk, period)
                return lifted if kept and self._joins(window, lifted, float(nodes.t[-1])) else None
            known, before = held.copy(), radius
            if fast.any():
                # The neighbours soon are, once these are held.
                held |= np.convolve(fast, np.ones(9))[4:-4] > 0
                # A motion that begins or ends at a limit has the middle ordinate beside that at the limit as well.
                held[0] = held[-1] = False
            radius = self._narrowed(nodes, radius, over, found.step, number)
            changed = (
                np.bincount(np.repeat(np.arange(len(nodes)), nodes.count), radius != before, len(nodes)) > 0
            )
            changed |= held != known
            if not near:
                if not changed.any():
                    return None
                parts = _parts(changed, np.cumsum(found.step), _BESIDE * self.felt(float(nodes.feed.max())))
        return None

    def _narrowed(self, nodes: Nodes, radius: Floats, over: Floats, step: Floats, number: int) -> Floats:
        """Return the room of nodes after a round, less where setpoints are over the tolerance before a node and beside that."""
        allowed = self.program.column("tolerance")[nodes.row - self.program.base]
        more = np.maximum(over, np.append(over[1:], -1.0))
        if number >= _LOCAL:
            more = _around(more, np.cumsum(step), 0.5 * self.machine.period_s)
        less = np.where(more > 0.0, _MORE * more + 1e-3 * 2.0**number * allowed, 0.0)
        out: Floats = np.maximum(
            radius - np.repeat(less, nodes.count), np.minimum(radius, _NARROWEST * nodes.allowed)
        )
        return out

    def _go_ahead(self, nodes: Nodes | None, final: int, motion: Solved) -> None:
        """Begin the search of the next window, from where a motion near that of this one is after its final nodes."""
        if nodes is None:
            return
        state = np.stack([motion.position[final], motion.velocity[final], motion.acceleration[final]])
        columns = moving(state, nodes)
        goal = self.reference.state(float(nodes.s[-1]), float(nodes.t[-1]))
        given = self._given(state, nodes, goal, columns, np.zeros(len(nodes), bool))
        self.ahead = _Ahead(nodes, columns, self.pool.submit(begun, given, nodes, True))

    def _joins(self, window: Window, found: Solved, end: float) -> bool:
        """Tell whether differences of setpoints hold the limits over both ends of a motion, where the plan goes on."""
        grid, period = self.reference.grid, self.machine.period_s
        assert grid is not None
        known = grid.t[-1] >= end + 4.0 * period or grid.v[-1] <= REST
        limits = (self.velocity, self.acceleration, self.jerk)
        beside = (window.first, bool(known))
        return joins(found, (window.t, end), beside, self.reference.positions, limits, period)

    def _given(
        self, start: Floats, nodes: Nodes, goal: Floats, columns: Ints, held: NDArray[np.bool_]
    ) -> Problem:
        """Return the problem of a window, with the room of its nodes as it was first."""
        point = np.concatenate([start[:1], nodes.point]).take(columns, axis=1)
        tangent = np.concatenate([nodes.tangent[:1], nodes.tangent]).take(columns, axis=1)
        tangent /= np.maximum(np.sqrt((tangent**2).sum(axis=1)), 1e-300)[:, None]
        # The state at the end is given: it needs no room.
        rooms = slice(len(nodes.radius) - int(nodes.count[-1]))
        feed = 0.9999 * np.append(nodes.feed[:1], nodes.feed)
        margin = 1.0 - 1e-6
        return Problem(
            velocity=margin * self.velocity[columns],
            acceleration=margin * self.acceleration[columns],
            jerk=margin * self.jerk[columns],
            weight=(columns < 3).astype(float),
            point=point,
            tangent=tangent,
            step=nodes.step,
            first=np.concatenate([[0, 0], np.cumsum(nodes.count[:-1]), [rooms.stop]]).astype(np.int64),
            centre=nodes.centre[rooms].take(columns, axis=1),
            direction=nodes.direction[rooms].take(columns, axis=1),
            radius=nodes.radius[rooms],
            feed=feed,
            between=np.where(held, np.maximum(feed[1:], feed[:-1]), np.inf),
            start=start[:, columns],
            goal=goal[:, columns],
            period_s=self.machine.period_s,
        )


def moving(start: Floats, nodes: Nodes) -> Ints:
    """Return the axes that move from a state over nodes."""
    return np.flatnonzero(np.ptp(np.concatenate([start[:1], nodes.point]), axis=0) > _STILL)


def _around(values: Floats, t: Floats, reach: float) -> Floats:
    """Return the largest of values, and of those above 0 within a time of each, shape (k,)."""
    first, stop = np.searchsorted(t, t - reach), np.searchsorted(t, t + reach, side="right")
    out = values.copy()
    # Most are below all that counts.
    for k in np.flatnonzero(values > 0.0).tolist():
        out[first[k] : stop[k]] = np.maximum(out[first[k] : stop[k]], values[k])
    return out


def _parts(changed: NDArray[np.bool_], t: Floats, reach: float) -> list[tuple[int, int]]:
    """Return the first and last nodes of the parts of a window within a time of what has changed before nodes 1 and on, at times `t`."""
    beside = np.flatnonzero(np.diff(np.r_[0.0, _around(changed.astype(float), t, reach), 0.0]))
    parts = [(int(first), int(last)) for first, last in beside.reshape(-1, 2)]
    long = sum(last - first for first, last in parts) > _MOSTLY * len(t)
    return [(0, len(t))] if long else parts


def _narrower(got: Found, given: Problem, parts: list[tuple[int, int]]) -> tuple[Found, int]:
    """Return a search that goes on with less room, in all of a window where parts of it are not enough; and the iterations over all."""
    search, before = got
    whole, spent = [(0, len(given.step))], 0
    guess = again(given, before)
    if parts != whole:
        found = search.narrower(given, *guess, parts)
        spent = found.iterations * sum(last - first for first, last in parts) // len(given.step) + 1
        if found.status == 1:
            return (search, found), spent
    found = search.narrower(given, *guess, whole)
    return (search, found), spent + found.iterations


def _spread(found: Solved, columns: Ints, state: Floats, end: Floats) -> Solved:
    """Return a motion over all axes, of which the others stand, whose last interval comes to its end exactly.

    Nodes are met within the resolution of setpoints; the last one is where the motion rests or the plan goes on.
    """
    count, axes = len(found.step), len(end)
    position = np.broadcast_to(state[0], (count + 1, axes)).copy()
    velocity, acceleration, jerk = (np.zeros((rows, axes)) for rows in (count + 1, count + 1, count))
    for whole, part in (
        (position, found.position), (velocity, found.velocity), (acceleration, found.acceleration), (jerk, found.jerk)
    ):  # fmt: skip
        whole[:, columns] = part
    h = found.step[-1]
    way = h * (velocity[-2] + h * (acceleration[-2] / 2.0 + h * jerk[-1] / 6.0))
    position[-2:] = end - way, end
    return replace(found, position=position, velocity=velocity, acceleration=acceleration, jerk=jerk)
