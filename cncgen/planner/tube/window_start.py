"""First guesses of a window's motion, strictly within the limits and the room."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.tube.tube_nodes import Nodes
from cncgen.planner.tube.window_problem import Problem, Solved

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
#: A problem with steps in time; velocities, accelerations and offsets at its nodes; jerks between them.
Start = tuple[Problem, Floats, Floats, Floats, Floats | None]

#: Parts of the speed that guesses have, one after the other, and whether one goes on steadily, at the pace of corners at least, or as
#: the plan does.
_STARTS = ((0.9, False), (0.6, True), (0.4, True))
#: Part of limits and room that a guess uses.
_WITHIN = 0.9
#: Part of its limits by which the solution of a round is moved inside them to start the next one.
_PULLED = 0.001
#: Halvings of an acceleration that leaves the room, before it is set to 0.
_EASED = 5


def starts(given: Problem, nodes: Nodes, before: Solved | None) -> Iterator[Start]:
    """Return guesses, the best one first.

    Args:
        given: The problem.
        nodes: Those after the first one.
        before: The solution of a similar problem, if there is one.
    """
    if before is not None:
        yield _again(given, before)
    for part, steady in _STARTS:
        yield _along(given, nodes, part, steady)


def _again(given: Problem, before: Solved) -> Start:
    """Return a solution, moved into limits and room."""
    within = 1.0 - _PULLED
    limits = [within * each for each in (given.velocity, given.acceleration, given.jerk)]
    speed, bent, jerk = (
        np.clip(each, -limit, limit)
        for each, limit in zip((before.velocity, before.acceleration, before.jerk), limits, strict=True)
    )
    speed *= _down(given, speed, within)
    # Rows that hold the middle ordinates may be new.
    bent[:-1][_beyond(given, speed, bent, before.step, within)] = 0.0
    offset = before.position - given.point
    offset += _inside(given, offset, bent, within, 0.0)
    _eased(given, offset, bent)
    return replace(given, step=before.step), speed, bent, offset, jerk


def _along(given: Problem, nodes: Nodes, part: float, steady: bool) -> Start:
    """Return a part of the speed of the plan on its path, with the acceleration of that unless it is steady."""
    steps, speeds = (nodes.step, nodes.speed) if steady else (nodes.plan_step, nodes.plan_speed)
    steps = np.maximum(steps, 1e-3 * nodes.step) / part
    speed = part * np.concatenate([[0.0], speeds])[:, None] * given.tangent
    speed[0], speed[-1] = given.start[1], given.goal[1]
    inner = speed[1:-1]
    inner *= np.minimum(1.0, _WITHIN / np.maximum((np.abs(inner) / given.velocity).max(axis=1), 1e-9))[
        :, None
    ]
    inner *= _down(given, speed, _WITHIN)[1:-1]
    rate = np.zeros_like(speed)
    if not steady:
        rate[1:-1] = (speed[2:] - speed[:-2]) / (steps[1:] + steps[:-1])[:, None]
        rate = np.clip(rate, -_WITHIN * given.acceleration, _WITHIN * given.acceleration)
        rate[:-1][_beyond(given, speed, rate, steps, 0.5 * (1.0 + _WITHIN))] = 0.0
    offset = _inside(given, np.zeros_like(given.point), rate)
    _eased(given, offset, rate)
    return replace(given, step=steps), speed, rate, offset, None


def _beyond(given: Problem, speed: Floats, rate: Floats, steps: Floats, within: float) -> Bools:
    """Tell which intervals have a middle ordinate of the velocity beyond a part of its bound, shape (steps,)."""
    middle = speed[:-1] + 0.5 * steps[:, None] * rate[:-1]
    out: Bools = (np.abs(middle) > within * given.velocity).any(axis=1) & np.isfinite(given.between)
    out |= np.sqrt((middle**2 * given.weight).sum(axis=1)) > within * given.between
    return out


def _down(given: Problem, speed: Floats, within: float) -> Floats:
    """Return what brings velocities below a part of the feed, shape (nodes, 1)."""
    along = np.sqrt((speed**2 * given.weight).sum(axis=1))
    out: Floats = np.minimum(1.0, within * given.feed / np.maximum(along, 1e-9))[:, None]
    return out


def _away(given: Problem, owner: Ints, offset: Floats, rate: Floats) -> Floats:
    """Return how far the places of rows are from where they should be, shape (rows, n)."""
    out: Floats = given.point[owner] + offset[owner] + given.bent[:, None] * rate[owner] - given.centre
    out -= (out * given.direction).sum(axis=1)[:, None] * given.direction
    return out


def _inside(given: Problem, offset: Floats, rate: Floats, part: float = _WITHIN, deep: float = 0.5) -> Floats:
    """Return further offsets, shape (nodes, n), that bring nodes within a part of the room, and those beyond that deeper by so much of the rest."""
    out = np.zeros_like(offset)
    owner = np.repeat(np.arange(len(out)), np.diff(given.first))
    for number in range(8):
        away = _away(given, owner, offset + out, rate)
        size = np.sqrt((away**2).sum(axis=1))
        over = np.flatnonzero(size > (part + 1e-9) * given.radius)
        if not len(over):
            break
        push = -away[over] * (1.0 - (part - deep) * given.radius[over] / size[over])[:, None]
        if number < 4:
            # Within the plane of the node, if that is enough.
            t = given.tangent[owner[over]]
            push -= (push * t).sum(axis=1)[:, None] * t
        out[owner[over]] += push
    return out


def _eased(given: Problem, offset: Floats, rate: Floats) -> None:
    """Lessen the accelerations that take chords out of the room."""
    owner = np.repeat(np.arange(len(offset)), np.diff(given.first))
    for number in range(_EASED):
        away = _away(given, owner, offset, rate)
        over = owner[(away**2).sum(axis=1) >= given.radius**2]
        rate[over] *= 0.5 if number < _EASED - 1 else 0.0
