"""The search of a window's motion; the first rounds of the next two windows are made in another thread meanwhile."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.tube.deviation import Reached, reached
from cncgen.planner.tube.handing import Hand
from cncgen.planner.tube.programmed import Programmed, RowLines
from cncgen.planner.tube.reference_path import REST, Reference
from cncgen.planner.tube.scales import Bounds
from cncgen.planner.tube.tube_nodes import Nodes
from cncgen.planner.tube.window_judge import holds, joins
from cncgen.planner.tube.window_problem import Solved
from cncgen.planner.tube.window_rounds import Rounds, Window
from cncgen.room import pool

Floats = NDArray[np.float64]

#: A window is searched a second time if the first search finds nothing or takes less than this part of the bound. What breaks something
#: is not searched again once a window has taken the second part of what is left of the bound, so those after it have as much.
_CHEAP, _SHARE = 0.02, 0.5
#: Part of the tolerance by which a motion near the solution may be over it, and the next window is still begun ahead.
_OVER = 1.0
#: Windows that are begun ahead, and the part of a period at which the first setpoint is where that is not known yet.
AHEAD, _PHASE = 2, 0.5


#: A window, a motion over it and the time of that one's first setpoint; rounds that were made, their window, and what they found.
Begun = tuple[Window, Solved, float]
Made = tuple[Rounds, Window, Solved | None]


#: Returns the nodes of the window after so many nodes, where the one before it has that many of them, and after how many of its own the
#: next one begins; None where they are not known yet.
Following = Callable[[int, int], tuple[Nodes, int] | None]


@dataclass(frozen=True, slots=True)
class _Ahead:
    """A window whose first rounds are made in the other thread, its nodes and after how many of them the next one begins."""

    nodes: Nodes
    final: int
    done: Future[Made | None]


class WindowSearch:
    """The search of one window after the other.

    Attributes:
        units, bound, share: The work of all searches, in units of some 10 µs, its bound, and that of one window.
    """

    def __init__(self, program: Programmed, reference: Reference, hand: Hand, bounds: Bounds) -> None:
        """Take the rows and the plan along them, what hands on the motions that are found, and the limits."""
        self.program, self.reference, self.hand, self.bounds = program, reference, hand, bounds
        self.units, self.bound, self.share = 0, 0, 0.0
        self.pool = pool(AHEAD, "tube")
        self.ahead: deque[_Ahead] = deque()
        self.begun: deque[tuple[Rounds, Future[bool]]] = deque()

    def close(self) -> None:
        """End its thread."""
        self.pool.shutdown(cancel_futures=True)

    def solved(self, window: Window, following: Following | None) -> Solved | None:
        """Return a motion within all limits and the tolerance, or None where none is found.

        Args:
            window: The window.
            following: The source of the windows after it, whose search then begins; None for none.
        """
        before, found = self.units, None
        self.share = before + _SHARE * (self.bound - before)
        rounds = self._begun(window) or self._begun_ahead(window) or self._rounds(window)
        if rounds.number < 0 or rounds.found:
            found = self._searched(rounds, window, following)
        if not window.tangled or self.units > (self.share if found is None else before + _CHEAP * self.bound):
            return found
        # There are many local optima: the faster one of two searches counts.
        rounds = self._rounds(window)
        rounds.tangent = window.nodes.looser
        other = self._searched(rounds, window, None)
        if other is None or (found is not None and found.step.sum() <= other.step.sum()):
            return found
        self.forget()
        return other

    def begin(self, window: Window) -> None:
        """Begin the search of a window from rest to rest: of what goes before it only the phase of its setpoints depends."""
        rounds = self._rounds(window)
        first = 0.0 if self.hand.phased else _PHASE * self.bounds.period_s
        made = self.pool.submit(lambda: rounds.search() and rounds.to_end(lambda _: first))
        self.begun.append((rounds, made))

    def _begun(self, window: Window) -> Rounds | None:
        """Return the rounds of a window whose search has begun, once they are made."""
        while self.begun and self.begun[0][0].window.t <= window.t:
            rounds, made = self.begun.popleft()
            if rounds.window.t == window.t and _same(window.nodes, rounds.window.nodes):
                made.result()
                self._counted(rounds)
                return rounds
            made.cancel()
        return None

    def _searched(self, rounds: Rounds, window: Window, following: Following | None) -> Solved | None:
        """Return the motion that rounds of a window end in, None where they do not."""
        if rounds.number < 0 and not rounds.search():
            self._counted(rounds)
            return None
        first = partial(self.hand.first_setpoint, window.t)
        if following:
            self._go_ahead((window, rounds.motion, first(rounds.motion)), following)
        ended = rounds.to_end(first, lambda: self.share - self.units - rounds.units)
        self._counted(rounds)
        if not ended:
            return None
        motion, ends, bounds = rounds.motion, (window.state, rounds.goal), self.bounds
        kept = holds(motion, ends, bounds.acceleration, bounds.jerk, bounds.period_s)
        return motion if kept and self._joins(window, motion, float(window.nodes.t[-1])) else None

    def forget(self) -> None:
        """Leave what has begun ahead: the motion goes on from elsewhere."""
        for each in self.ahead:
            each.done.cancel()
        self.ahead.clear()

    def _rounds(self, window: Window) -> Rounds:
        """Return the rounds of a window, before the first."""
        return Rounds(window, self.bounds, *self._ends(window.nodes))

    def _ends(self, nodes: Nodes) -> tuple[Floats, Floats]:
        """Return the state in which a window ends, and the tolerance at its nodes."""
        goal = self.reference.state(float(nodes.s[-1]), float(nodes.t[-1]))
        return goal, self.program.column("tolerance")[nodes.row - self.program.base]

    def _begun_ahead(self, window: Window) -> Rounds | None:
        """Return the rounds that were made ahead, from another state near its own, if this is their window."""
        if not self.ahead:
            return None
        each = self.ahead.popleft()
        made = each.done.result() if _same(window.nodes, each.nodes) else None
        if made is not None:
            self._counted(made[0])
            if made[2] is not None and made[0].taken(window):
                return made[0]
        self.forget()
        return None

    def _counted(self, rounds: Rounds) -> None:
        """Count what rounds have taken."""
        self.units += rounds.units
        rounds.units = 0

    def _go_ahead(self, begun: Begun, following: Following) -> None:
        """Begin the rounds of the next windows, from where motions near those of the ones before them are after their final nodes."""
        window = begun[0]
        end, planned, row = window.final, len(window.nodes), int(window.nodes.row[0])
        before: Future[Made | None] | None = None
        if window.whole:
            return
        for depth in range(AHEAD):
            if depth == len(self.ahead):
                found = following(end, planned)
                if found is None:
                    return
                nodes, final = found
                path = self.program.lines(max(row, self.program.base), int(nodes.row[-1]) + 1)
                given = nodes, final, path, self._ends(nodes), before or begun
                self.ahead.append(_Ahead(nodes, final, self.pool.submit(self._made_ahead, *given)))
            each = self.ahead[depth]
            before, row = each.done, int(each.nodes.row[0])
            if each.final == len(each.nodes):
                return
            end, planned = end + each.final, len(each.nodes)

    def _made_ahead(
        self,
        nodes: Nodes,
        final: int,
        path: RowLines,
        ends: tuple[Floats, Floats],
        before: Begun | Future[Made | None],
    ) -> Made | None:
        """Return the first rounds of a window and what they found, from where a motion is after the final nodes of the one before it.

        None are made where no motion was found there.

        Args:
            nodes, final: As of `Window`.
            path: The rows, from where the window before it begins.
            ends: The state where it ends, and the tolerance at its nodes.
            before: What it begins after.
        """
        period, goals = self.bounds.period_s, None
        if isinstance(before, Future):
            made = before.result()
            if made is None or made[2] is None:
                return None
            before = made[1], made[2], _PHASE * period
        last, motion, first_s = before
        at = last.final
        state = np.stack([motion.position[at], motion.velocity[at], motion.acceleration[at]])
        entry = last.goals and reached(last.path, last.goals[0], motion, first_s, period, _OVER, at)
        if entry is not None and entry.line >= path.key[0]:
            path = path.since(entry.line)
            key = min(float(nodes.row[-1] + nodes.part[-1]), float(path.key[-1]))
            line = path.key[min(int(np.searchsorted(path.key, key, side="right")) - 1, len(path.key) - 2)]
            goals = entry, Reached.at(nodes.point[-1], key, float(line))
        window = Window(nodes, final, state, float(last.nodes.t[at - 1]), False, path, goals)
        rounds = Rounds(window, self.bounds, *ends)
        return rounds, window, rounds.motion if rounds.ahead(_PHASE * period) else None

    def _joins(self, window: Window, found: Solved, end: float) -> bool:
        """Tell whether differences of setpoints hold the limits over both ends of a motion, where the plan goes on."""
        grid, period = self.reference.grid, self.bounds.period_s
        assert grid is not None
        known = grid.t[-1] >= end + 4.0 * period or grid.v[-1] <= REST
        limits = (self.bounds.velocity, self.bounds.acceleration, self.bounds.jerk)
        beside = (window.first, bool(known))
        return joins(found, (window.t, end), beside, self.reference.positions, limits, period)


def _same(nodes: Nodes, others: Nodes) -> bool:
    """Tell whether nodes are those that were expected."""
    return len(nodes) == len(others) and all(nodes.s[k] == others.s[k] for k in (0, -1))
