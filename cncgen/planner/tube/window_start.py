"""First guesses of a window's motion, strictly within the limits and the room."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import tube_motion
from cncgen.planner.tube.tube_nodes import Nodes
from cncgen.planner.tube.window_problem import Guess, Problem, Search, Solved

Floats = NDArray[np.float64]
#: A search, and what it found.
Found = tuple[Search, Solved]

#: Parts of the speed that guesses have, one after the other, and of the acceleration at that speed, at the pace of corners at least; and
#: of the one that goes before the later ones where corners are near each other, at the pace of the plan. Without the slowest, two of 80
#: small chains take 3 and 8 % longer.
_STARTS, _SLOW = ((0.95, 0.3), (0.6, 0.0), (0.4, 0.0)), (0.9, 1.0)
#: Part of limits and room that a guess uses.
_WITHIN = 0.9
#: Part of its limits by which the solution of a round is moved inside them to start the next one.
_PULLED = 0.001


def begun(given: Problem, nodes: Nodes, near: bool, tangled: bool) -> tuple[Found | None, int]:
    """Return a search and what it found from the first of all guesses that leads to a solution, and the iterations of all of them.

    Args:
        given: The problem.
        nodes: Those after the first one.
        near: Whether to go near the solution only.
        tangled: Whether there are many local optima, as corners are near each other.
    """
    spent = 0
    for number, (part, bent) in enumerate((_SLOW, *_STARTS[1:]) if tangled else _STARTS):
        guess = _along(given, nodes, part, bent, tangled and not number)
        search = Search(replace(given, step=guess.step), guess)
        found = search.solve(near)
        spent += found.iterations
        if found.status == 1:
            return (search, found), spent
    return None, spent


def faster(one: Found | None, other: Found | None) -> Found | None:
    """Return the search that found the faster motion, of those that found one."""
    found = [each for each in (one, other) if each is not None and each[1].status == 1]
    return min(found, key=lambda each: float(each[1].step.sum()), default=None)


def again(given: Problem, before: Solved) -> Guess:
    """Return a solution, moved into limits and room: the same motion in more time where intervals are held that it is too fast on."""
    within = 1.0 - _PULLED
    slower = max(1.0, _between(given, before) / within)
    limits = [within * each for each in (given.velocity, given.acceleration, given.jerk)]
    speed, bent, jerk = (
        np.clip(each / slower**order, -limit, limit)
        for order, each, limit in zip(
            (1, 2, 3), (before.velocity, before.acceleration, before.jerk), limits, strict=True
        )
    )
    speed *= _down(given, speed, within)
    offset = _inside(given, before.position - given.point, within)
    return Guess(slower * before.step, speed, _bowed(given, offset, bent, within), offset, jerk)


def _between(given: Problem, before: Solved) -> float:
    """Return the largest part of velocity limit and feed that a motion uses at the middle ordinates of the intervals that are held."""
    held = np.isfinite(given.between)
    middle = before.velocity[:-1][held] + 0.5 * before.step[held, None] * before.acceleration[:-1][held]
    along = np.sqrt((middle**2 * given.weights_between[held]).sum(axis=1)) / given.between[held]
    return float(np.maximum((np.abs(middle) / given.velocity).max(axis=1), along).max(initial=0.0))


def _along(given: Problem, nodes: Nodes, part: float, bent: float, slow: bool) -> Guess:
    """Return a part of the speed of the plan on its path, at the pace of corners at least unless it is `slow`, with a part of the acceleration of that."""
    steps, speeds = (nodes.plan_step, nodes.plan_speed) if slow else (nodes.step, nodes.speed)
    steps = np.maximum(np.maximum(steps, 1e-3 * nodes.step) / part, given.shortest / _WITHIN)
    speed = part * np.concatenate([[0.0], speeds])[:, None] * given.tangent
    speed[0], speed[-1] = given.start[1], given.goal[1]
    inner = speed[1:-1]
    inner *= np.minimum(1.0, _WITHIN / np.maximum((np.abs(inner) / given.velocity).max(axis=1), 1e-9))[
        :, None
    ]
    inner *= _down(given, speed, _WITHIN)[1:-1]
    rate = np.zeros_like(speed)
    rate[1:-1] = bent * (speed[2:] - speed[:-2]) / (steps[1:] + steps[:-1])[:, None]
    rate = np.clip(rate, -_WITHIN * given.acceleration, _WITHIN * given.acceleration)
    middle = speed[:-1] + 0.5 * steps[:, None] * rate[:-1]
    over = (np.abs(middle) > 0.5 * (1.0 + _WITHIN) * given.velocity).any(axis=1)
    over |= np.sqrt((middle**2 * given.weights_between).sum(axis=1)) > 0.5 * (1.0 + _WITHIN) * given.between
    rate[:-1][over] = 0.0
    offset = _inside(given, np.zeros_like(given.point))
    jerk = np.zeros_like(speed[1:])
    return Guess(steps, speed, _bowed(given, offset, rate, _WITHIN), offset, jerk)


def _down(given: Problem, speed: Floats, within: float) -> Floats:
    """Return what brings velocities below a part of the feed, shape (nodes, 1)."""
    along = np.sqrt((speed**2 * given.weight).sum(axis=1))
    out: Floats = np.minimum(1.0, within * given.feed / np.maximum(along, 1e-9))[:, None]
    return out


def _inside(given: Problem, offset: Floats, within: float = _WITHIN) -> Floats:
    """Return offsets, shape (N + 1, n), that bring nodes within a part of their room."""
    out = offset.copy()
    rows = given.centre, given.direction, given.radius
    tube_motion.move_inside(given.point, given.tangent, given.first, *rows, within, out)
    return out


def _bowed(given: Problem, offset: Floats, acceleration: Floats, within: float) -> Floats:
    """Return accelerations, shape (N + 1, n), less where with them chords would not be within a part of their room."""
    rows = np.flatnonzero(given.bow > 0.0)
    node = np.repeat(np.arange(len(given.point)), np.diff(given.first))[rows]
    way = given.direction[rows]
    away, bow = (
        each - (each * way).sum(axis=1)[:, None] * way
        for each in (
            (given.point + offset)[node] - given.centre[rows],
            given.bow[rows, None] * acceleration[node],
        )
    )
    # The part of the acceleration at which |away + part · bow| is that part of the radius.
    square, half = (bow**2).sum(axis=1), (away * bow).sum(axis=1)
    free = np.maximum((within * given.radius[rows]) ** 2 - (away**2).sum(axis=1), 0.0)
    part = free / np.maximum(half + np.sqrt(half**2 + square * free), 1e-300)
    out = acceleration.copy()
    out[node] *= np.minimum(part, 1.0)[:, None]
    return out
