"""The search of a window's motion; the first rounds of the next window run beside it."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.record import Machine
from cncgen.planner.tube.deviation import PHASES, Reached, reached
from cncgen.planner.tube.handing import Hand
from cncgen.planner.tube.programmed import Programmed
from cncgen.planner.tube.reference_path import Reference
from cncgen.planner.tube.tube_nodes import Nodes
from cncgen.planner.tube.window_judge import REST, holds, joins
from cncgen.planner.tube.window_problem import Solved
from cncgen.planner.tube.window_rounds import Bounds, Rounds, Window

Floats = NDArray[np.float64]

#: Rounds of a window, at most.
_ROUNDS = 9
#: Part of the tolerance by which a motion near the solution may be over it, and the next window is still begun ahead.
_OVER = 1.0


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
        self.bounds = Bounds(*limits, machine.period_s)
        self.units = self.bound = 0
        self.pool = ThreadPoolExecutor(1, "tube")
        self.ahead: tuple[Rounds, Future[None]] | None = None

    def close(self) -> None:
        """End its thread."""
        self.pool.shutdown(cancel_futures=True)

    def solved(self, window: Window, following: Callable[[int], Nodes | None]) -> Solved | None:
        """Return a motion within all limits and the tolerance, or None where none is found.

        Args:
            window: The window.
            following: Returns the nodes of the window after so many of the nodes of this one, whose search then begins; None where
                they are not known yet.
        """
        rounds = self._begun_ahead(window)
        known = rounds is not None
        rounds = rounds or self._rounds(window)
        while known or rounds.number < _ROUNDS - 1:
            if self.units > self.bound:
                return None
            found = known or rounds.search()
            self._count(rounds)
            if not found:
                return None
            motion = rounds.motion
            if (known or rounds.number == 0) and not window.whole:
                self._go_ahead(window, following(window.final), motion)
            known = False
            first = self.hand.first_setpoint(window.t, motion)
            broken = rounds.judge(first, PHASES if rounds.number else 1)
            self._count(rounds)
            if rounds.exact and not broken:
                ends, bounds = (window.state, rounds.goal), self.bounds
                kept = holds(motion, ends, bounds.acceleration, bounds.jerk, bounds.period_s)
                return motion if kept and self._joins(window, motion, float(window.nodes.t[-1])) else None
            if rounds.exact and not rounds.changed:
                return None
        return None

    def _rounds(self, window: Window) -> Rounds:
        """Return the rounds of a window, before the first."""
        nodes = window.nodes
        goal = self.reference.state(float(nodes.s[-1]), float(nodes.t[-1]))
        allowed = self.program.column("tolerance")[nodes.row - self.program.base]
        return Rounds(window, self.bounds, goal, allowed)

    def _begun_ahead(self, window: Window) -> Rounds | None:
        """Return the rounds that were made ahead, from another state near its own, if this is their window."""
        if self.ahead is None:
            return None
        (rounds, done), self.ahead = self.ahead, None
        if not rounds.expects(window):
            return None
        done.result()
        self._count(rounds)
        return rounds if rounds.taken(window) else None

    def _count(self, rounds: Rounds) -> None:
        """Count what rounds have taken."""
        self.units += rounds.units
        rounds.units = 0

    def _go_ahead(self, window: Window, nodes: Nodes | None, motion: Solved) -> None:
        """Begin the search of the next window, from where a motion near that of this one is after its final nodes."""
        if nodes is None:
            return
        final, goals = window.final, None
        state = np.stack([motion.position[final], motion.velocity[final], motion.acceleration[final]])
        assert window.goals is not None
        first, period = self.hand.first_setpoint(window.t, motion), self.machine.period_s
        entry = reached(window.path, window.goals[0], motion, first, period, _OVER, final)
        path = window.path
        if entry is not None:
            stop = int(nodes.row[-1]) + 1
            path = self.program.lines(min(int(entry.line), stop - 1), stop)
            key = min(float(nodes.row[-1] + nodes.part[-1]), float(path.key[-1]))
            line = path.key[min(int(np.searchsorted(path.key, key, side="right")) - 1, len(path.key) - 2)]
            goals = entry, Reached.at(nodes.point[-1], key, float(line))
        rounds = self._rounds(
            Window(nodes, len(nodes), state, float(window.nodes.t[final - 1]), False, path, goals)
        )
        self.ahead = rounds, self.pool.submit(rounds.ahead)

    def _joins(self, window: Window, found: Solved, end: float) -> bool:
        """Tell whether differences of setpoints hold the limits over both ends of a motion, where the plan goes on."""
        grid, period = self.reference.grid, self.machine.period_s
        assert grid is not None
        known = grid.t[-1] >= end + 4.0 * period or grid.v[-1] <= REST
        limits = (self.bounds.velocity, self.bounds.acceleration, self.bounds.jerk)
        beside = (window.first, bool(known))
        return joins(found, (window.t, end), beside, self.reference.positions, limits, period)
