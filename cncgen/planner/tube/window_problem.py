"""The least-time problem between two states, on nodes with room around them (kernel ``least_time_tube``)."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import least_time_tube as kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Barrier parameter at the start and at the end, and iterations at most.
_START, _END, _MOST = 1e-3, 1e-6, 120
#: Barrier parameter at the start from the solution of a similar problem, and iterations at most.
_AGAIN, _MOST_AGAIN = 1e-5, 40
#: Part of the jerk limit that what nodes are missed by may make of a third difference; the most and, in parts of what doubles
#: can tell, the least that is asked of the scaled states.
_SHOWS, _MISSED, _TOLD = 1e-4, 1e-7, 4.0
#: Weight of jerk squared: calms where the feed alone binds.
_CALM = 0.01


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
        feed: Shape (N + 1,): speed over the weighed axes, infinite for none.
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
    feed: Floats
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


def solve(
    given: Problem,
    velocity: Floats,
    acceleration: Floats | None = None,
    offset: Floats | None = None,
    jerk: Floats | None = None,
) -> Solved:
    """Solve a problem.

    Args:
        given: The problem.
        velocity, acceleration, offset: Shape (N + 1, n), first guess at the nodes; strictly within the limits and the room.
        jerk: Shape (N, n), strictly within the limits, where the guess solves a problem that is nearly this one.
    """
    n, steps = len(given.velocity), len(given.step)
    unit = float(np.min(given.radius)) if len(given.radius) else 0.01
    x, u = np.zeros((steps + 1, n, 3)), np.zeros((steps, n + 1))
    if offset is not None:
        x[:, :, 0] = offset / unit
    x[:, :, 1] = velocity / given.velocity
    if acceleration is not None:
        x[:, :, 2] = acceleration / given.acceleration
    scale = np.stack([np.full(n, unit), given.velocity, given.acceleration])
    for at, state in ((0, given.start), (-1, given.goal)):
        x[at] = ((state - np.stack([given.point[at], np.zeros(n), np.zeros(n)])) / scale).T
    if jerk is not None:
        u[:, :n] = jerk / given.jerk
    u[:, n] = 1.0
    state = x.reshape(steps + 1, 3 * n)
    node = np.repeat(np.arange(steps + 1), np.diff(given.first))
    rows = np.concatenate(
        [(given.point[node] - given.centre) / unit, given.direction, (unit / given.radius)[:, None]], axis=1
    )
    tangent = given.tangent.copy()
    with np.errstate(divide="ignore"):
        problem = SimpleNamespace(
            V=given.velocity / unit,
            A=given.acceleration / unit,
            J=given.jerk / unit,
            weight=given.weight,
            r=np.ascontiguousarray(given.point / unit),
            t=tangent,
            h0=given.step,
            first=given.first,
            rows=np.ascontiguousarray(rows),
            feed=unit / given.feed,
            between=unit / given.between,
            hlow=np.full(steps, 0.05),
            hhigh=np.full(steps, 8.0),
            goal=state[-1].copy(),
            x=state,
            u=u,
            calm=_CALM,
            exact=_exact(given, unit),
        )
    work = workspace(n, steps, len(rows))
    tube = kernel.Tube(problem, work)
    mu, most = (_START, _MOST) if jerk is None else (_AGAIN, _MOST_AGAIN)
    found = kernel.solve(tube, mu, _END, most)
    p, v, a = (x * scale.T).transpose(2, 0, 1)
    return Solved(
        given.point + p,
        v,
        a,
        u[:, :n] * given.jerk,
        u[:, n] * given.step,
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
        "seen": (_MOST + 2, 2),
    }  # fmt: skip
    return SimpleNamespace(**{name: np.zeros(shape) for name, shape in shapes.items()})


def _exact(given: Problem, unit: float) -> float:
    """Return by how much scaled states may miss their nodes."""
    period = given.period_s
    # A step of the k-th derivative is in a third difference at most 3 - k times, over the period to the power of 3 - k.
    parts = (period**3 / (3.0 * unit), period**2 / (2.0 * given.velocity), period / given.acceleration)
    part = min(float(np.min(given.jerk * each)) for each in parts)
    return max(min(_SHOWS * part, _MISSED), _TOLD * float(np.spacing(np.abs(given.point).max() / unit)))
