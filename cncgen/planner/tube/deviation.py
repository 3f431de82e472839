"""How far a motion with nodes leaves the programmed rows, between nodes and by chords of setpoints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import tube_places
from cncgen.planner.tube.programmed import Programmed
from cncgen.planner.tube.tube_nodes import Nodes
from cncgen.planner.tube.window_problem import Solved

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A place may be near another row if the way there along the rows is less than so many times the tolerance.
_BESIDE = 3.0
#: Part of a row that is no way back, but for rounding.
_BACK = 1e-6
#: Parts of chords that are looked at: in a period of one bend the middle is furthest from it, and of several any may be.
_MIDDLE, _QUARTERS = (0.5,), (0.5, 0.25, 0.75)
#: Places of an interval that are looked at.
_PARTS = np.array([1 / 6, 1 / 3, 1 / 2, 2 / 3, 5 / 6])


def excess(
    program: Programmed,
    nodes: Nodes,
    solved: Solved,
    columns: Ints,
    still: Floats,
    begin_s: float,
    period_s: float,
) -> Floats:
    """Return by how much the motion is over the tolerance before each node, shape (k,), mm; negative values are room.

    Args:
        program: The rows.
        nodes: Those after the first one of the window.
        solved: The motion.
        columns: Axes that move.
        still: Shape (axes,): where the others stand, scaled.
        begin_s: Place of the first node on the reference.
        period_s: Time between setpoints.
    """
    count, parts = len(nodes), len(_PARTS)
    end = np.cumsum(solved.step)
    t = (end - solved.step)[:, None] + solved.step[:, None] * np.append(_PARTS, 1.0)
    chords = _MIDDLE if (solved.step > period_s).all() else _QUARTERS
    rounds = [_at(solved, end, t[:, :-1]), *(_on_chord(solved, end, t, period_s, part) for part in chords)]
    points = np.concatenate(rounds, axis=1)
    each = points.shape[1]
    full = np.broadcast_to(still, (count * each, len(still))).copy()
    full[:, columns] = points.reshape(count * each, -1)
    base = program.base
    # Where on the rows each place should be, by their lengths.
    length = np.asarray(program.column("length"))
    upto = np.concatenate([[0.0], np.cumsum(length)])
    reached = upto[nodes.row - base] + nodes.part * length[nodes.row - base]
    before = np.append(max(reached[0] - (nodes.s[0] - begin_s), 0.0), reached[:-1])
    sixth = np.concatenate([_PARTS, *[np.append(_PARTS, 1.0)] * len(chords)])
    along = before[:, None] + np.maximum(reached - before, 0.0)[:, None] * sixth
    row = np.clip(np.searchsorted(upto, along.ravel(), side="left") - 1, 0, len(length) - 1)
    part = (along.ravel() - upto[row]) / length[row]
    allowed = np.asarray(program.column("tolerance"))[row]
    place, _, far = program.nearest(full, base + row, part)
    key, distance = row + far, np.sqrt(((place - full) ** 2).sum(axis=1))
    order = np.arange(count * each).reshape(count, each)
    turns = [some.ravel() for some in np.split(order, parts + np.arange(len(chords)) * (parts + 1), axis=1)]
    _in_order(program, full, turns, key, distance)
    for way, end_of in ((-1, "start"), (1, "end")):
        over = np.flatnonzero(distance > allowed)
        left = np.sqrt(((place[over] - np.asarray(program.column(end_of))[row[over]]) ** 2).sum(axis=1))
        for step in (1, 2, 3):
            other = row[over] + way * step
            near = (left < _BESIDE * allowed[over]) & (other >= 0) & (other < len(length))
            over, left, other = over[near], left[near], other[near]
            if not len(over):
                break
            start = np.full(len(over), 0.0 if way > 0 else 1.0)
            found, _, far = program.nearest(full[over], base + other, start)
            away = np.sqrt(((found - full[over]) ** 2).sum(axis=1))
            nearer = away < distance[over]
            distance[over[nearer]], key[over[nearer]] = away[nearer], (other + far)[nearer]
            far_off = distance[over] > allowed[over]
            over, left = over[far_off], (left + length[other])[far_off]
    # What was found on a row ahead is where the motion is from there on.
    _in_order(program, full, turns, key, distance)
    curved = np.asarray(program.column("curved"))[row].reshape(count, each).any(axis=1)
    out: Floats = (distance - allowed).reshape(count, each).max(axis=1)
    lines = full.reshape(count, each, -1)[:, parts : 2 * parts + 1]
    out = np.maximum(out, _passed(program, nodes, full.reshape(count, each, -1)))
    k = np.flatnonzero(curved)
    if len(k):
        # Curves are looked at from their own places as well, and from where they change fast: a tip may be cut.
        at = slice(parts, 2 * parts + 1)
        own = row.reshape(count, each)[k, at].ravel()
        points = program.at(base + own, part.reshape(count, each)[k, at].ravel()).reshape(
            len(k), parts + 1, -1
        )
        around = np.concatenate(
            [lines[np.maximum(k - 1, 0)], lines[k], lines[np.minimum(k + 1, count - 1)]], axis=1
        )
        missed = _to_line(points, around) - allowed.reshape(count, each)[k, at]
        out[k] = np.maximum(out[k], missed.max(axis=1))
        rows, parts_of = program.borders(int(nodes.row[0]), int(nodes.row[-1]))
        tips = upto[rows - base] + parts_of * length[rows - base]
        there = (tips > before[0]) & (tips <= reached[-1])
        rows, parts_of = rows[there], parts_of[there]
        k = np.searchsorted(reached, tips[there])
        around = np.concatenate(
            [lines[np.maximum(k - 1, 0)], lines[k], lines[np.minimum(k + 1, count - 1)]], axis=1
        )
        missed = _to_line(program.at(rows, parts_of)[:, None], around)[:, 0]
        np.maximum.at(out, k, missed - np.asarray(program.column("tolerance"))[rows - base])
    return out


def _on_chord(solved: Solved, end: Floats, t: Floats, period_s: float, part: float) -> Floats:
    """Return points on chords between setpoints, shape (k, m, n), each such a part of a period after the chord's beginning.

    Args:
        solved: The motion.
        end: Shape (k,): times at which its intervals end, s.
        t: Shape (k, m): times of the motion, s; chords end where it does.
        period_s: Time between setpoints.
        part: From 0 to 1.
    """
    before, after = np.minimum(part * period_s, t), np.minimum((1.0 - part) * period_s, end[-1] - t)
    weight = (before / (before + after))[..., None]
    return (1.0 - weight) * _at(solved, end, t - before) + weight * _at(solved, end, t + after)


def _in_order(program: Programmed, full: Floats, turns: list[Ints], key: Floats, distance: Floats) -> None:
    """Keep the order: where a motion goes back, its place is the furthest one that it has been at.

    Args:
        program: The rows.
        full: Shape (n, axes), points of the motion.
        turns: Points that follow one another, by their numbers.
        key: Shape (n,): the row of each point's place, from the first one known, and how far it is on that; changed.
        distance: Shape (n,), mm, from that place; changed.
    """
    for turn in turns:
        furthest = np.maximum.accumulate(key[turn])
        late = furthest - key[turn] > _BACK
        at, furthest = turn[late], furthest[late]
        row = np.minimum(furthest.astype(np.int64), len(program.column("length")) - 1)
        place = program.on(program.base + row, furthest - row)
        key[at], distance[at] = furthest, np.sqrt(((place - full[at]) ** 2).sum(axis=1))


def _to_line(points: Floats, line: Floats) -> Floats:
    """Return the distances of points, shape (k, p, n), from polylines, shape (k, m, n), each from its own; shape (k, p)."""
    out = np.empty(points.shape[:2])
    tube_places.distances(np.ascontiguousarray(points), np.ascontiguousarray(line), out)
    return out


def _at(solved: Solved, end: Floats, t: Floats) -> Floats:
    """Return positions at times, shape (k, m, n), of intervals that end at `end`."""
    k = np.minimum(np.searchsorted(end, t), len(end) - 1)
    h = (t - end[k] + solved.step[k])[..., None]
    motion = np.stack(
        [solved.position[:-1], solved.velocity[:-1], solved.acceleration[:-1] / 2, solved.jerk / 6], axis=1
    )[k]
    out: Floats = motion[..., 0, :] + h * (
        motion[..., 1, :] + h * (motion[..., 2, :] + h * motion[..., 3, :])
    )
    return out


def _passed(program: Programmed, nodes: Nodes, points: Floats) -> Floats:
    """Return by how much joints are passed too far from before each node, shape (k,)."""
    out = np.full(len(nodes), -np.inf)
    begin = np.concatenate([nodes.row[:1], nodes.row[:-1]])
    count = nodes.row - begin
    owner = np.repeat(np.arange(len(nodes)), count)
    if not len(owner):
        return out
    joint = begin[owner] + 1 + np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    corner = program.column("start")[joint - program.base]
    tolerance = program.column("tolerance")
    allowed = np.minimum(tolerance[joint - program.base], tolerance[joint - 1 - program.base])
    # Middles of chords between setpoints, with those of the interval before.
    middles = points[:, len(_PARTS) : 2 * len(_PARTS) + 1]
    here, before = middles[owner], middles[np.maximum(owner - 1, 0)]
    line = np.concatenate([before, here], axis=1)
    distance = _to_line(corner[:, None], line)[:, 0]
    np.maximum.at(out, owner, distance - allowed)
    return out
