"""Where the nodes of a block stand: dense where the path bends or the motion must slow down, sparse elsewhere."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.path import Path
from cncgen.planner.optimal.joints import Joints
from cncgen.planner.optimal.limits import Bounds

TopAt = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]

Floats = NDArray[np.float64]

#: Spacing by effort: as a part of the radius of curvature, of the distance that a ramp of acceleration from 0 to its
#: limit takes, and its growth from node to node.
DENSITY = {"best": (0.08, 0.2, 0.2), "fast": (0.15, 0.35, 0.35)}
#: First interval from rest, as a part of the distance in which full jerk from rest reaches full acceleration.
_FIRST = 0.5
#: And as a part of the radius of curvature there, and of the distance to the next rest.
_BEND, _PART = 0.02, 1.0 / 12.0


def place(
    path: Path,
    bounds: Bounds,
    joints: Joints,
    lines: NDArray[np.bool_],
    top_at: TopAt,
    effort: str,
) -> Floats:
    """Return the nodes of a block, ascending: its breakpoints, and what lies between.

    Args:
        path: Geometry.
        bounds: Limits.
        joints: Its breakpoints.
        lines: Shape (breakpoints − 1,): stretches that need no nodes between their ends.
        top_at: Gives the largest q at path coordinates and derivatives there.
        effort: A key of `DENSITY`.
    """
    bend_part, ramp_part, growth = DENSITY[effort]
    probes = _probes(path, joints)
    _, x1, x2, _ = x = path.evaluate(probes, 3)
    acceleration, jerk, bend = along(bounds, x1, x2)
    q = np.minimum(top_at(probes, x), acceleration / np.maximum(bend, 1e-300))
    q = np.where(bend > 0, q, top_at(probes, x))
    ramp = acceleration / jerk
    fastest = acceleration * ramp + np.sqrt(acceleration * (joints.s[-1] - joints.s[0]))
    spacing = ramp_part * ramp * np.minimum(np.sqrt(q), fastest)
    spacing = np.minimum(spacing, bend_part / np.maximum(bend, 1e-300))
    at = np.searchsorted(probes, joints.s)
    at = np.minimum(at, len(probes) - 1)
    beside = np.concatenate([[True], lines]) & np.concatenate([lines, [True]])
    rest = np.flatnonzero(joints.stop & ~beside)
    between = np.diff(joints.s[rest]) if len(rest) > 1 else np.array([np.inf])
    first = np.minimum(_FIRST * acceleration[at] * ramp[at] ** 2 / 6.0, _BEND / np.maximum(bend[at], 1e-300))
    room = np.full(len(joints.s), np.inf)
    room[rest] = _PART * np.minimum(
        np.concatenate([[np.inf], between])[: len(rest)], np.concatenate([between, [np.inf]])[: len(rest)]
    )
    gap = np.diff(joints.s, prepend=-np.inf, append=np.inf) / 3.0
    first = np.minimum(np.minimum(first, room), np.minimum(gap[:-1], gap[1:]))
    zone = np.flatnonzero(joints.zone > 0)
    tight = np.concatenate([rest, zone])
    here = np.concatenate([first[rest], 0.7 * joints.zone[zone]])
    fine = _around(probes, joints.s[tight], here, spacing[at[tight]] / growth)
    spacing = np.interp(fine, probes, spacing)
    at = np.searchsorted(fine, joints.s[tight])
    spacing[at] = np.minimum(spacing[at], here)
    spacing = _graded(fine, spacing, growth)
    borders = _borders(joints, first, lines)
    stretch = np.searchsorted(joints.s, borders[:-1], side="right") - 1
    return _spread(fine, spacing, borders, lines[stretch])


def along(bounds: Bounds, x1: Floats, x2: Floats) -> tuple[Floats, Floats, Floats]:
    """Return acceleration and jerk along the path by the weakest axis, and how fast its direction turns, each (n,).

    The turn is measured in the axes' own accelerations: max |x''|/A over max |x'|/A, the curvature where all are alike.
    """
    limit = bounds.axes
    share = np.abs(x1) / limit.acceleration
    steep = share.max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        jerk = 1.0 / (np.abs(x1) / limit.jerk).max(axis=1)
        bend = (np.abs(x2) / limit.acceleration).max(axis=1) / steep
        return 1.0 / steep, jerk, np.nan_to_num(bend)


def _probes(path: Path, joints: Joints) -> Floats:
    """Return places to look at the path: borders of its cells, its breakpoints, and points between."""
    borders = np.union1d(path.sample_borders(), joints.s)
    inner = borders[:-1, None] + np.diff(borders)[:, None] * np.array([0.0, 0.25, 0.5, 0.75])
    return np.append(inner.ravel(), borders[-1])


def _around(s: Floats, centre: Floats, base: Floats, reach: Floats) -> Floats:
    """Return `s` with points at doubling distances, from `base` up to `reach`, on both sides of each centre."""
    more = [s, centre]
    distance = base.copy()
    while np.any(distance < reach):
        near = distance < reach
        more += [centre[near] - distance[near], centre[near] + distance[near]]
        distance *= 2.0
    out = np.unique(np.concatenate(more))
    return out[(out >= s[0]) & (out <= s[-1])]


def _graded(s: Floats, spacing: Floats, growth: float) -> Floats:
    """Lower the spacing so that it grows by no more than `growth` per length along the path, in both directions."""
    forward = np.minimum.accumulate(spacing - growth * s) + growth * s
    backward = np.minimum.accumulate((spacing + growth * s)[::-1])[::-1] - growth * s
    return np.minimum(np.minimum(forward, backward), spacing)


def _borders(joints: Joints, first: Floats, lines: NDArray[np.bool_]) -> Floats:
    """Return the places that must be nodes: breakpoints, and the first interval on the curved sides of a rest."""
    leaves = np.flatnonzero(joints.stop[:-1] & ~lines)
    enters = np.flatnonzero(joints.stop[1:] & ~lines) + 1
    return np.unique(
        np.concatenate([joints.s, joints.s[leaves] + first[leaves], joints.s[enters] - first[enters]])
    )


def _spread(s: Floats, spacing: Floats, borders: Floats, whole: NDArray[np.bool_]) -> Floats:
    """Divide each stretch between borders evenly in the measure ds / spacing; those that stay `whole` not at all."""
    density = 1.0 / spacing
    measure = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(s))])
    at = np.interp(borders, s, measure)
    count = np.maximum(np.ceil(np.diff(at) - 1e-9).astype(np.int64), 1)
    count[whole] = 1
    stretch = np.repeat(np.arange(len(count)), count)
    step = np.arange(len(stretch)) - np.repeat(np.cumsum(count) - count, count)
    inner = at[stretch] + (at[stretch + 1] - at[stretch]) * step / count[stretch]
    nodes = np.interp(inner, measure, s)
    nodes[step == 0] = borders[:-1]
    return np.append(nodes, borders[-1])
