"""The least-time problem between two states, on nodes with room around them (kernel ``least_time_tube``)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import least_time_tube as kernel
from cncgen.kernels import tube_point

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Barrier parameter at the start, near the solution and at the end, and iterations at most.
_START, _NEAR, _END, _MOST = 1e-3, 1e-5, 1e-6, 200
#: Barrier parameter where a search goes on with a narrower problem.
_AGAIN = 3e-6
#: Barrier parameter where it goes on with a wider one.
_WIDER = 1e-4
#: Part of the jerk limit that what nodes are missed by may make of a third difference; the most and, in parts of what doubles
#: can tell, the least that is asked of the scaled states.
_SHOWS, _MISSED, _TOLD = 1e-4, 1e-7, 4.0
#: Times between nodes are at least and at most these parts of those of the guess; where less is asked, at least the second part.
_SHORTEST, _MORE, _MOST_TIME = 0.05, 1.5, 8.0
#: Weight of jerk squared: calms where the feed alone binds. Cost of a step of mean length.
_CALM, _COST = 0.01, 0.02
#: Arrays of a problem and of its workspace that have a row for each node, for each step between two, and for each row of room.
_OF_NODES = [
    "r",
    "t",
    "feed",
    "x",
    "x2",
    "dx",
    "nu",
    "nu2",
    "zx",
    "dzx",
    "zf",
    "dzf",
    "P",
    "q",
    "feed_slack",
    "feed_slope",
]
_OF_STEPS = [
    "h0",
    "between",
    "hlow",
    "hhigh",
    "u",
    "u2",
    "du",
    "lam",
    "lam2",
    "zu",
    "dzu",
    "zm",
    "dzm",
    "K",
    "middle_slack",
    "middle",
    "miss",
]
_OF_ROWS = ["rows", "zr", "dzr", "row_slack", "row_slope"]


@dataclass(frozen=True, slots=True)
class Problem:
    """Nodes 0 … N with what holds there, of `n` axes; lengths in mm of all axes alike (`axis_scale`).

    Attributes:
        velocity, acceleration, jerk: Shape (n,), limits.
        weight: Shape (n,): 1 for the axes over which the feed is meant, else 0.
        point, tangent: Shape (N + 1, n): where each node's plane stands, and the unit vector across it.
        step: Shape (N,): first guess of the time between nodes, s.
        first: Shape (N + 2,): rows of node k are first[k] … first[k + 1].
        centre, direction: Shape (rows, n): a line through a point, or a point (direction 0).
        radius: Shape (rows,): how near the node is to it, mm.
        bow: Shape (rows,): time squared, s², that the acceleration counts for: place p + bow a is that near, p itself where it is 0.
        feed: Shape (N + 1,): speed over the weighed axes, infinite for none.
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
    longest: Floats
    between: Floats
    start: Floats
    goal: Floats
    period_s: float


@dataclass(frozen=True, slots=True)
class Solved:
    """Positions, velocities and accelerations at the nodes, shape (N + 1, n) each; jerks (N, n) and times (N,) between them.

    Attributes:
        status: 1 where it holds.
        iterations: Of the interior point.
        residual: Distances by which nodes are missed, in scaled units.
    """

    position: Floats
    velocity: Floats
    acceleration: Floats
    jerk: Floats
    step: Floats
    status: int
    iterations: int
    residual: float


class Search:
    """A search for the motion of a problem, which goes on from where it is when the problem gets narrower."""

    def __init__(
        self,
        given: Problem,
        velocity: Floats,
        acceleration: Floats | None = None,
        offset: Floats | None = None,
    ) -> None:
        """Begin a search.

        Args:
            given: The problem.
            velocity, acceleration, offset: Shape (N + 1, n), first guess at the nodes; strictly within the limits and the room.
        """
        n, steps = len(given.velocity), len(given.step)
        unit = float(np.min(given.radius)) if len(given.radius) else 0.01
        self.given, self.unit = given, unit
        self.x, self.u = np.zeros((steps + 1, n, 3)), np.zeros((steps, n + 1))
        self.scale = np.stack([np.full(n, unit), given.velocity, given.acceleration])
        for at, state in ((0, given.start), (-1, given.goal)):
            self.x[at] = ((state - np.stack([given.point[at], np.zeros(n), np.zeros(n)])) / self.scale).T
        still = np.zeros((steps + 1, n))
        self._move(
            given.step, velocity, still if acceleration is None else acceleration, still if offset is None else offset, None
        )  # fmt: skip
        self.rows = self._room(given)
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
            hlow=np.full(steps, _SHORTEST),
            hhigh=np.clip(given.longest / given.step, _MORE, _MOST_TIME),
            goal=state[-1].copy(),
            x=state,
            u=self.u,
            calm=_CALM,
            cost=_COST / float(given.step.mean()),
            exact=_exact(given, unit),
        )
        self.tube = tube_point.Tube(self.arrays, self.arrays)

    def begin(self, state: Floats) -> Solved:
        """Return what has been found, but beginning in another state near its own, shape (3, n)."""
        position = self.given.point[0] + 0.0
        self.x[0] = ((state - np.stack([position, 0.0 * position, 0.0 * position])) / self.scale).T
        return self._solved(self.last)

    def solve(self, near: bool = False) -> Solved:
        """Return the solution, or what is near it: then with less of the room, and nodes missed by up to a thousandth of it."""
        return self._solved(kernel.solve(self.tube, _START, _NEAR if near else _END, _MOST, near))

    def _room(self, given: Problem) -> Floats:
        """Return the rows of room of a problem as the kernel takes them."""
        node = np.repeat(np.arange(len(given.point)), np.diff(given.first))
        away = (given.point[node] - given.centre) / self.unit
        return np.concatenate(
            [away, given.direction, (self.unit / given.radius)[:, None], given.bow[:, None]], axis=1
        )

    def wider(self, given: Problem, near: bool) -> Solved:
        """Return the solution, or what is near it, of a problem that differs in `radius` and `centre`, with more room."""
        # Its times are those of this guess.
        self.given = replace(self.given, radius=given.radius, centre=given.centre)
        self.rows[:] = self._room(self.given)
        return self._solved(kernel.solve(self.tube, _WIDER, _NEAR if near else _END, _MOST, near, True))

    def narrower(
        self,
        given: Problem,
        step: Floats,
        velocity: Floats,
        acceleration: Floats,
        offset: Floats,
        jerk: Floats,
        parts: Sequence[tuple[int, int]],
        far: bool = False,
    ) -> Solved:
        """Return the solution of a problem that differs in `radius` and `between`, from a guess strictly within it.

        Args:
            given: That problem.
            step: Shape (N,), times of the guess, s.
            velocity, acceleration, offset: Shape (N + 1, n), the guess at the nodes.
            jerk: Shape (N, n), between them.
            parts: First and last nodes, between which the motion is searched anew; the states there stay, and all beside them.
            far: Whether the guess is far from a solution.
        """
        self.rows[:, -2] = self.unit / given.radius
        with np.errstate(divide="ignore"):
            self.between[:] = self.unit / given.between
        found = []
        for first, last in parts:
            self._move(step, velocity, acceleration, offset, jerk, first, last)
            end = self.arrays.x[last].copy()
            tube = self.tube if last - first == len(step) else self._part(first, last)
            found.append(kernel.solve(tube, _WIDER if far else _AGAIN, _END, _MOST, False, True))
            if last < len(step):
                # The step before is missed by at most both halves of what counts as exact, the one behind by no more than before.
                self.arrays.x[last] = end
        return self._solved(
            {
                "status": min(each["status"] for each in found),
                "iterations": max(each["iterations"] for each in found),
                "residual": max(each["residual"] for each in found),
            }
        )

    def _part(self, first: int, last: int) -> tube_point.Tube:
        """Return the search from a node to another one, which works on the same arrays, so goes on with their multipliers."""
        whole = self.arrays
        part, row = SimpleNamespace(**vars(whole)), int(whole.first[first])
        for names, begin, stop in (
            (_OF_NODES, first, last + 1), (_OF_STEPS, first, last), (_OF_ROWS, row, None)
        ):  # fmt: skip
            for name in names:
                setattr(part, name, getattr(whole, name)[begin:stop])
        part.first = whole.first[first : last + 2] - row
        if last < len(whole.h0):
            # The multiplier of the last step's motion is that of the state in which it ends.
            part.goal, part.exact = whole.x[last].copy(), 0.5 * whole.exact
            part.lamT, part.lamT2 = whole.lam[last - 1].copy(), whole.lamT2.copy()
        return tube_point.Tube(part, part)

    def _move(
        self,
        step: Floats,
        velocity: Floats,
        acceleration: Floats,
        offset: Floats,
        jerk: Floats | None,
        first: int = 0,
        last: int | None = None,
    ) -> None:
        """Take a guess between two nodes."""
        nodes, steps = slice(first + 1, len(step) if last is None else last), slice(first, last)
        for order, each in enumerate((offset, velocity, acceleration)):
            self.x[nodes, :, order] = each[nodes] / self.scale[order]
        if jerk is not None:
            self.u[steps, :-1] = jerk[steps] / self.given.jerk
        self.u[steps, -1] = step[steps] / self.given.step[steps]

    def _solved(self, found: kernel.Found) -> Solved:
        self.last = found
        p, v, a = (self.x[:, :, order] * self.scale[order] for order in range(3))
        return Solved(
            self.given.point + p,
            v,
            a,
            self.u[:, :-1] * self.given.jerk,
            self.u[:, -1] * self.given.step,
            found["status"],
            found["iterations"],
            found["residual"],
        )


def workspace(n: int, steps: int, rows: int) -> SimpleNamespace:
    """Return arrays for a search over `steps` intervals of `n` axes: steps, multipliers, gains and the cost to go."""
    N, U = 3 * n, n + 1
    shapes = {
        "x2": (steps + 1, N), "u2": (steps, U), "dx": (steps + 1, N), "du": (steps, U), "lam": (steps, N), "lam2": (steps, N),
        "nu": (steps + 1,), "nu2": (steps + 1,), "lamT": (N,), "lamT2": (N,), "zx": (steps + 1, 4 * n), "dzx": (steps + 1, 4 * n),
        "zu": (steps, 2 * U), "dzu": (steps, 2 * U), "zr": (rows + 1,), "dzr": (rows + 1,), "zf": (steps + 1,), "dzf": (steps + 1,),
        "zm": (steps, 2 * n + 1), "dzm": (steps, 2 * n + 1), "P": (steps + 1, N * N), "q": (steps + 1, N), "K": (steps, U * (N + 1)),
        "seen": (_MOST + 2, 2), "row_slack": (rows + 1,), "row_slope": (rows + 1, n), "feed_slack": (steps + 1,),
        "feed_slope": (steps + 1, n), "middle_slack": (steps,), "middle": (steps, n), "miss": (steps, N),
    }  # fmt: skip
    return SimpleNamespace(**{name: np.zeros(shape) for name, shape in shapes.items()})


def _exact(given: Problem, unit: float) -> float:
    """Return by how much scaled states may miss their nodes."""
    period = given.period_s
    # A step of the k-th derivative is in a third difference at most 3 - k times, over the period to the power of 3 - k.
    parts = (period**3 / (3.0 * unit), period**2 / (2.0 * given.velocity), period / given.acceleration)
    part = min(float(np.min(given.jerk * each)) for each in parts)
    return max(min(_SHOWS * part, _MISSED), _TOLD * float(np.spacing(np.abs(given.point).max() / unit)))
