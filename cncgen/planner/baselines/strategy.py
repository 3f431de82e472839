"""The papers' baselines, `constant`, `adaptive` and `curvature`: a speed for every place of the path, without regard to acceleration.

Speed follows curvature at once and starts and ends with a step, as in the papers that `ild` is compared with. Between two places v² is
linear in s (constant acceleration). The places are close enough for a relative error of 0.001.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.curvature import CurvatureExtrema, curvature_extrema
from cncgen.geometry.path import Path
from cncgen.machine.record import Machine
from cncgen.planner.assembly import assemble, events_before, timed, waits_of
from cncgen.planner.limits.row_limits import RowLimits, row_limits_of
from cncgen.planner.limits.speeds import chord_speed, curvature_speed
from cncgen.planner.options import PlanOptions
from cncgen.planner.record import Limit, Trajectory
from cncgen.toolpath.record import Kind, Toolpath

Floats = NDArray[np.float64]

#: Speed (mm/s) at places of curvature κ (1/mm, first argument) under the feed (mm/s, second), both of shape (n,).
SpeedLaw = Callable[[Floats, Floats], Floats]

#: Relative error of v² at which a stretch is halved, and how often that may be.
_TOLERANCE = 1e-4
_HALVINGS = 20
#: Stretches that a curve begins with.
_FIRST = 64


def plan_constant(chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions) -> Iterator[Trajectory]:
    """Travel at the feed, or at the axes' velocity where that is lower; acceleration and jerk are not limited."""
    return _by_curvature(chunks, machine, lambda curvature, feed: feed, Limit.FEED)


def plan_adaptive(chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions) -> Iterator[Trajectory]:
    """Travel at the feed, or at what the chord error allows (Yeh and Hsu 2002): V_af = (2/T_s) √(2δ/κ − δ²) (Tsai 2010, eq. 24)."""
    tolerance, period = machine.chord_tolerance_mm, machine.period_s
    return _by_curvature(
        chunks, machine, lambda bend, feed: chord_speed(bend, tolerance, period), Limit.CHORD
    )


def plan_curvature(
    chunks: Iterable[Toolpath], machine: Machine, options: PlanOptions
) -> Iterator[Trajectory]:
    """Travel at V_cf = κ̄ V_max/(κ + κ̄) (Tsai 2010, eq. 25), κ̄ = `kbar_per_mm`."""
    kbar = options.kbar_per_mm
    return _by_curvature(
        chunks, machine, lambda bend, feed: curvature_speed(bend, feed, kbar), Limit.CURVATURE
    )


def _by_curvature(
    chunks: Iterable[Toolpath], machine: Machine, law: SpeedLaw, limit: Limit
) -> Iterator[Trajectory]:
    """Plan chunks with the speed that `law` gives for the curvature of each place.

    Args:
        chunks: Consecutive stretches of one program.
        machine: Axis velocities are its only limits that count.
        law: The speed, never above the feed.
        limit: Marks the places where the law is below the feed.
    """
    t_s = 0.0
    for chunk in chunks:
        path = chunk.path
        rows = row_limits_of(chunk, path, machine, bends=False)
        place, owner = _places(chunk, path, rows, law)
        v = _speeds(path, place, owner, rows, law)
        start, end = v[:-1], v[1:]
        # A row's speed holds from its first place to its last: at a joint the next row's begins.
        joint = np.flatnonzero(np.diff(owner)) + 1
        inside = np.setdiff1d(np.flatnonzero(np.diff(place) > 0.0), joint - 1)
        profile_place = np.append(place[inside], place[-1:])
        duration = 2.0 * np.diff(place)[inside] / (start + end)[inside]
        a = (end - start)[inside] / duration
        slow = start[inside] < rows.top[owner[:-1][inside]] * (1.0 - 1e-12)
        bound = np.where(slow, np.int8(limit), rows.top_limit[owner[:-1][inside]])
        offset = np.searchsorted(owner[:-1][inside], np.arange(len(rows) + 1))
        events = events_before(chunk, rows.index)
        zero = np.zeros(len(a))
        profile, arrival = assemble(
            t_s,
            profile_place if len(rows) else np.asarray(path.row_s)[:1],
            (duration, start[inside], a, zero, zero),
            bound.astype(np.int8),
            offset,
            waits_of(events, len(rows) + 1),
        )
        t_s = float(profile.t[-1])
        yield Trajectory(chunk, np.asarray(path.row_s), profile, timed(events, arrival))


def _places(
    toolpath: Toolpath, path: Path, rows: RowLimits, law: SpeedLaw
) -> tuple[Floats, NDArray[np.int64]]:
    """Return places along the rows, both ends of each row among them, and the row that each belongs to."""
    number = np.arange(len(rows))
    place, owner = [rows.start, rows.end], [number, number]
    curves = np.flatnonzero(toolpath.kind[rows.index] == Kind.NURBS)
    if len(curves):
        extrema = curvature_extrema(path)
        for i in curves:
            inner = _refined(path, rows, int(i), extrema, law)[1:-1]
            place.append(inner)
            owner.append(np.full(len(inner), i))
    places, owners = np.concatenate(place), np.concatenate(owner)
    order = np.lexsort((places, owners))
    return places[order], owners[order]


def _refined(path: Path, rows: RowLimits, i: int, extrema: CurvatureExtrema, law: SpeedLaw) -> Floats:
    """Halve the stretches of a curve until v² is linear in each."""
    at = np.linspace(rows.start[i], rows.end[i], _FIRST + 1)
    inside = (extrema.s > rows.start[i]) & (extrema.s < rows.end[i])
    at = np.union1d(at, extrema.s[inside])
    open_ = np.ones(len(at) - 1, dtype=bool)
    for _ in range(_HALVINGS):
        middle = 0.5 * (at[:-1] + at[1:])[open_]
        if not len(middle):
            break
        owner = np.full(len(at), i)
        ends = _speeds(path, at, owner, rows, law) ** 2
        found = _speeds(path, middle, owner[: len(middle)], rows, law) ** 2
        wrong = np.abs(found - 0.5 * (ends[:-1] + ends[1:])[open_]) > _TOLERANCE * found
        halved = np.flatnonzero(open_)[wrong]
        open_[:] = False
        open_[halved] = True
        at = np.insert(at, halved + 1, middle[wrong])
        open_ = np.insert(open_, halved + 1, True)
    return at


def _speeds(path: Path, place: Floats, owner: NDArray[np.int64], rows: RowLimits, law: SpeedLaw) -> Floats:
    """Return the law's speed at places of given rows."""
    if not len(place):
        return np.zeros(0)
    inner = np.clip(place, *_inside(rows, owner))
    curvature = np.linalg.norm(path.evaluate(inner, 2)[2][:, :3], axis=1)
    top = rows.top[owner]
    return np.minimum(law(curvature, top), top)


def _inside(rows: RowLimits, owner: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Return the first and last place that are inside the rows, where the derivatives are the row's own."""
    margin = 1e-9 * rows.length[owner]
    return rows.start[owner] + margin, rows.end[owner] - margin
