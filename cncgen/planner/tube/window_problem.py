"""The least-time problem between two states, on nodes with room around them (kernel ``least_time_tube``)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import least_time_tube as kernel
from cncgen.kernels import tube_point

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Barrier parameter at the start, near the solution and at the end, and iterations at most.
_START, _NEAR, _END, _MOST = 1e-3, 1e-5, 1e-6, 200
#: Barrier parameter where a search goes on with a narrower problem, from near its solution and from far.
_AGAIN, _FAR = 3e-6, 1e-4
#: Part of the jerk limit that what nodes are missed by may make of a third difference; the most and, in parts of what doubles
#: can tell, the least that is asked of the scaled states.
_SHOWS, _MISSED, _TOLD = 1e-4, 1e-7, 4.0
#: Times between nodes are at least and at most these parts of those of the guess; where less is asked, at least the second part.
_SHORTEST, _MORE, _MOST_TIME = 0.05, 1.5, 8.0
#: Weight of jerk squared: calms where the feed alone binds. Cost of a step of mean length.
_CALM, _COST = 0.01, 0.02


@dataclass(frozen=True, slots=True)
class Problem:
    """Nodes 0 … N with what holds there, of `n` axes; lengths in mm of all axes alike (`axis_scale`).

    Attributes:
        velocity, acceleration, jerk: Shape (n,), limits.
        weight: Shape (N + 1, n): 1 for the axes over which the feed of a node is meant, else 0.
        point, tangent: Shape (N + 1, n): where each node's plane stands, and the unit vector across it.
        step: Shape (N,): first guess of the time between nodes, s.
        first: Shape (N + 2,): rows of node k are first[k] … first[k + 1].
        centre, direction: Shape (rows, n): a line through a point, or a point (direction 0).
        radius: Shape (rows,): how near the node is to it, mm.
        bow: Shape (rows,): time squared, s², that the acceleration counts for: place p + bow a is that near, p itself where it is 0.
        feed: Shape (N + 1,): speed over the weighed axes, infinite for none.
        shortest: Shape (N,): least of the time between nodes, s; the first guess takes more.
        longest: Shape (N,): most of the time between nodes, s; a guess that takes nearly as long may take half of its own more.
        between: Shape (N,): speed to which an interval is held between its nodes, its axes as well; infinite where it need not be.
        start, goal: Shape (3, n): position, velocity and acceleration at both ends.
        period_s: Time between setpoints: nodes are met so exactly that third differences over it hold the jerk.
    """

    velocity: Floats
    acceleration: Floats
    jerk: Floats
    weight: Floats
    point: Floats
    tangent: Floats
    step: Floats
    first: Ints
    centre: Floats
    direction: Floats
    radius: Floats
    bow: Floats
    feed: Floats
    shortest: Floats
    longest: Floats
    between: Floats
    start: Floats
    goal: Floats
    period_s: float

    @property
    def weights_between(self) -> Floats:
        """Shape (N, n): the weights between nodes, of axes that the feeds of both are meant over."""
        return self.weight[:-1] * self.weight[1:]


@dataclass(frozen=True, slots=True)
class Guess:
    """A motion to begin a search from: times between the nodes, shape (N,), with jerks, (N, n); velocities, accelerations and ways off
    `Problem.point` at them, (N + 1, n) each."""

    step: Floats
    velocity: Floats
    acceleration: Floats
    offset: Floats
    jerk: Floats


@dataclass(frozen=True, slots=True)
class Solved:
    """Positions, velocities and accelerations at the nodes, shape (N + 1, n) each; jerks (N, n) and times (N,) between them.

    Attributes:
        status: 1 where it holds.
        iterations: Of the interior point.
    """

    position: Floats
    velocity: Floats
    acceleration: Floats
    jerk: Floats
    step: Floats
    status: int
    iterations: int


class Search:
    """A search for the motion of a problem, which goes on from where it is when the problem gets narrower."""

    def __init__(self, given: Problem, guess: Guess) -> None:
        """Begin a search from a guess strictly within the limits and the room, whose times are those of the problem."""
        n, steps = len(given.velocity), len(given.step)
        unit = float(np.min(given.radius)) if len(given.radius) else 0.01
        self.given, self.unit = given, unit
        self.x, self.u = np.zeros((steps + 1, n, 3)), np.zeros((steps, n + 1))
        self.scale = np.stack([np.full(n, unit), given.velocity, given.acceleration])
        self._end(0, given.start)
        self._end(-1, given.goal)
        self._move(guess, 0, steps)
        node = np.repeat(np.arange(steps + 1), np.diff(given.first))
        away = (given.point[node] - given.centre) / unit
        self.rows = np.column_stack([away, given.direction, unit / given.radius, given.bow])
        state = self.x.reshape(steps + 1, 3 * n)
        with np.errstate(divide="ignore"):
            feed, self.between = unit / given.feed, unit / given.between
        self.arrays = SimpleNamespace(
            **vars(workspace(n, steps, len(self.rows))),
            V=given.velocity / unit,
            A=given.acceleration / unit,
            J=given.jerk / unit,
            weight=given.weight,
            r=np.ascontiguousarray(given.point / unit),
            t=given.tangent.copy(),
            h0=given.step,
            first=given.first,
            rows=self.rows,
            feed=feed,
            between=self.between,
            hlow=np.maximum(given.shortest / given.step, _SHORTEST),
            hhigh=np.clip(given.longest / given.step, _MORE, _MOST_TIME),
            goal=state[-1].copy(),
            x=state,
            u=self.u,
            calm=_CALM,
            cost=_COST / float(given.step.mean()),
            exact=_exact(given, unit),
        )
        self.tube = tube_point.Tube(self.arrays, self.arrays)

    def _end(self, at: int, state: Floats) -> None:
        """Begin or end in a state, shape (3, n)."""
        still = np.zeros_like(state[0])
        self.x[at] = ((state - np.stack([self.given.point[at], still, still])) / self.scale).T

    def begin(self, state: Floats) -> Solved:
        """Return what has been found, but beginning in another state near its own, shape (3, n)."""
        self._end(0, state)
        return self._solved(self.last)

    def solve(self, near: bool = False) -> Solved:
        """Return the solution, or what is near it: then with less of the room, and nodes missed by up to a thousandth of it."""
        return self._solved(kernel.solve(self.tube, _START, _NEAR if near else _END, _MOST, near))

    def narrower(
        self, given: Problem, guess: Guess, parts: Sequence[tuple[int, int]], far: bool = False
    ) -> Solved:
        """Return the solution of a problem that differs in `radius` and `between`, from a guess strictly within it.

        Args:
            given, guess: That problem, and the guess.
            parts: First and last nodes, between which the motion is searched anew; the states there stay, and all beside them.
            far: Whether the guess is far from a solution.
        """
        self.rows[:, -2] = self.unit / given.radius
        with np.errstate(divide="ignore"):
            self.between[:] = self.unit / given.between
        found = []
        for first, last in parts:
            self._move(guess, first, last)
            end = self.arrays.x[last].copy()
            tube = self.tube if last - first == len(self.u) else self._part(first, last)
            found.append(kernel.solve(tube, _FAR if far else _AGAIN, _END, _MOST, False, True))
            if last < len(self.u):
                # The step before is missed by at most both halves of what counts as exact, the one behind by no more than before.
                self.arrays.x[last] = end
        status, most = (
            how(each[name] for each in found) for how, name in ((min, "status"), (max, "iterations"))
        )
        return self._solved({"status": status, "iterations": most})

    def _part(self, first: int, last: int) -> tube_point.Tube:
        """Return the search from a node to another one, which works on the same arrays, so goes on with their multipliers."""
        whole = self.arrays
        part, row = SimpleNamespace(**vars(whole)), int(whole.first[first])
        own = _widths(self.x.shape[1])
        for names, begin, stop in (
            (["r", "t", "weight", "feed", "x", *own[0]], first, last + 1),
            (["h0", "between", "hlow", "hhigh", "u", *own[1]], first, last),
            (["rows", *own[2]], row, None),
        ):
            for name in names:
                setattr(part, name, getattr(whole, name)[begin:stop])
        part.first = whole.first[first : last + 2] - row
        if last < len(whole.h0):
            # The multiplier of the last step's motion is that of the state in which it ends.
            part.goal, part.exact = whole.x[last].copy(), 0.5 * whole.exact
            part.lamT, part.lamT2 = whole.lam[last - 1].copy(), whole.lamT2.copy()
        return tube_point.Tube(part, part)

    def _move(self, guess: Guess, first: int, last: int) -> None:
        """Take a guess between two nodes."""
        nodes, steps = slice(first + 1, last), slice(first, last)
        for order, each in enumerate((guess.offset, guess.velocity, guess.acceleration)):
            self.x[nodes, :, order] = each[nodes] / self.scale[order]
        self.u[steps, :-1] = guess.jerk[steps] / self.given.jerk
        self.u[steps, -1] = guess.step[steps] / self.given.step[steps]

    def _solved(self, found: Mapping[str, int]) -> Solved:
        """Return the motion as it is, of what the kernel said about it."""
        self.last = found
        p, v, a = (self.x[:, :, order] * self.scale[order] for order in range(3))
        jerk, step = self.u[:, :-1] * self.given.jerk, self.u[:, -1] * self.given.step
        return Solved(self.given.point + p, v, a, jerk, step, found["status"], found["iterations"])


def _widths(n: int) -> tuple[dict[str, int], dict[str, int], dict[str, int]]:
    """Return the widths of the arrays that a search over `n` axes works on, 0 for numbers: those with a row for each node, for each
    step between two, and for each row of room."""
    N, U = 3 * n, n + 1
    return (
        {
            "x2": N, "dx": N, "nu": 0, "nu2": 0, "zx": 4 * n, "dzx": 4 * n, "zf": 0, "dzf": 0, "P": N * N, "q": N,
            "feed_slack": 0, "feed_slope": n,
        },
        {
            "u2": U, "du": U, "lam": N, "lam2": N, "zu": 2 * U, "dzu": 2 * U, "zm": 2 * n + 1, "dzm": 2 * n + 1,
            "K": U * (N + 1), "middle_slack": 0, "middle": n, "miss": N,
        },
        {"zr": 0, "dzr": 0, "row_slack": 0, "row_slope": n},
    )  # fmt: skip


def workspace(n: int, steps: int, rows: int) -> SimpleNamespace:
    """Return arrays for a search over `steps` intervals of `n` axes: steps, multipliers, gains and the cost to go."""
    own = {"lamT": np.zeros(3 * n), "lamT2": np.zeros(3 * n), "seen": np.zeros((_MOST + 2, 2))}
    for count, widths in zip((steps + 1, steps, rows + 1), _widths(n), strict=True):
        own |= {name: np.zeros((count, width) if width else count) for name, width in widths.items()}
    return SimpleNamespace(**own)


def _exact(given: Problem, unit: float) -> float:
    """Return by how much scaled states may miss their nodes."""
    period = given.period_s
    # A step of the k-th derivative is in a third difference at most 3 - k times, over the period to the power of 3 - k.
    parts = (period**3 / (3.0 * unit), period**2 / (2.0 * given.velocity), period / given.acceleration)
    part = min(float(np.min(given.jerk * each)) for each in parts)
    return max(min(_SHOWS * part, _MISSED), _TOLD * float(np.spacing(np.abs(given.point).max() / unit)))
