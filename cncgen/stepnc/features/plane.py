"""Planar faces: straight lines across the face, depth by depth, one way or to and fro.

Distances are those that NIST's interpreter chooses: the first line so that the tool bites one step into the face, lines
that overrun the face by the overcut less the radius (overcut: 1.25 diameters where none is given). Faces with bosses, and
other strategies than straight lines, are cut as pockets whose sides are open.
"""

from __future__ import annotations

import math

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.features import offsets, pocket
from cncgen.stepnc.features.entry import Entry, along_cut, plunge
from cncgen.stepnc.features.job import Floats, Job, Moves, at_height
from cncgen.stepnc.features.offsets import bounds_along
from cncgen.stepnc.geometry.pieces import Polyline
from cncgen.stepnc.model import CutterPath

_WAYS = ("bidirectional", "unidirectional", "")
#: Most lines over all depths.
_MOST_LINES = 1_000_000


def mill(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths of facing (PLANE_ROUGH_MILLING and PLANE_FINISH_MILLING of a PLANAR_FACE, ISO 14649-11)."""
    outline = job.shape.outline
    if outline is None:
        raise job.fault("stepnc-missing", "the face has no boundary")
    strategy = job.operation.strategy.kind if job.operation.strategy else ""
    if job.shape.bosses or strategy not in _WAYS:
        return pocket.mill_open(job, outline)
    along = _feed_direction(job)
    lines = _lines(job, along)
    levels = job.levels(job.depth - job.value("allowance_bottom", 0.0))
    if len(lines) * len(levels) > _MOST_LINES:
        raise job.fault(
            "stepnc-geometry", f"{len(lines)} lines in {len(levels)} depths are more than {_MOST_LINES}"
        )
    return (
        _bidirectional(job, lines, levels) if strategy != "unidirectional" else _one_way(job, lines, levels)
    )


def _feed_direction(job: Job) -> Floats:
    """Return the unit vector along the lines: the strategy's, else that of the face's course of travel."""
    strategy = job.operation.strategy
    given = strategy.values.get("feed_direction") if strategy else None
    if given is None:
        course = job.shape.course
        given = course[-1].end - course[0].start if course else np.array([1.0, 0.0, 0.0])
    flat = np.array([given[0], given[1], 0.0])
    length = float(elementary.length(flat))
    if length < 1e-9:
        raise job.fault("stepnc-geometry", "the feed direction is across the face")
    return flat / length


def _lines(job: Job, along: Floats) -> list[tuple[Floats, Floats]]:
    """Return start and end, shape (3,), of each line at height 0, all in the same direction."""
    radius = job.radius
    across = job.stepover(along)
    outline = job.shape.outline or []
    low, high = bounds_along(outline, along)
    near, far = bounds_along(outline, across)
    step = 2 * radius * (1.0 - job.strategy_value("overlap", 0.0))
    if not step > 0:
        raise job.fault(
            "stepnc-geometry", f"the distance between lines is {step:g} mm: the overlap is too large"
        )
    if step > 2 * radius + 1e-9:
        text = (
            f"lines are {step:g} mm apart, and the tool has {2 * radius:g} mm: ridges would stay between them"
        )
        raise job.fault("stepnc-range", text, hint="the overlap must not be below 0")
    pocket.floor_reach(job, step, corners=False)  # tells of ridges
    level = radius - job.tool.edge
    first = near + step - radius
    count = max(1, math.ceil((far - level - first) / step - 1e-9) + 1)
    if count > 20_000:
        raise job.fault("stepnc-geometry", f"{count} lines of {step:g} mm are more than 20000")
    places = first + step * np.arange(count)
    half = max(step / 2 if count > 1 else 0.0, step - radius, far - float(places[-1]))
    overrun = _overrun(job, min(half, level), level)
    return [
        ((low - overrun) * along + o * across, (high + overrun) * along + o * across) for o in places.tolist()
    ]


def _overrun(job: Job, half: float, level: float) -> float:
    """Return how far the tool's middle goes beyond the face, mm.

    The overcut is that of the tool's rear, as NIST's interpreter has it. The round front of a tool leaves the material at a
    distance `half` beside its line up to sqrt(r² - half²) ahead of its middle, with r the radius of its `level` end: it goes at least so
    far that none stays.
    """
    radius = job.radius
    asked = job.value("overcut_length", 2.5 * radius) - radius
    needed = -math.sqrt(max(level**2 - half**2, 0.0))
    if asked < needed - 1e-9:
        text = f"with an overcut of {asked + radius:g} mm spikes would stay at the ends of lines; it is made"
        job.warn("stepnc-overcut", f"{text} {needed + radius:g} mm")
    return max(asked, needed)


def _way_down(job: Job, start: Floats, end: Floats) -> Entry:
    """Return the way down at the start of a line: straight beside face and raw piece, else as the approach asks."""
    around = job.shape.stock or job.shape.outline or []
    if offsets.distance_to(offsets.polygon_of(around), start) >= job.radius - 1e-6:
        return plunge(start)
    return along_cut(job, start, [Polyline(np.stack([start, end]))])


def _bidirectional(
    job: Job, lines: list[tuple[Floats, Floats]], levels: list[float]
) -> tuple[CutterPath, ...]:
    moves = Moves(job.operation.ident, at_height(lines[0][0], job.retract))
    for level in levels:
        moves.rapid(at_height(lines[0][0], job.retract))
        _way_down(job, *lines[0]).descend(moves, level)
        for k, (start, end) in enumerate(lines):
            points = (start, end) if k % 2 == 0 else (end, start)
            moves.feed(*(at_height(p, level) for p in points))
        moves.height(job.retract, rapid=True)
    return moves.paths()


def _one_way(job: Job, lines: list[tuple[Floats, Floats]], levels: list[float]) -> tuple[CutterPath, ...]:
    moves = Moves(job.operation.ident, at_height(lines[0][0], job.retract))
    for level in levels:
        for start, end in lines:
            moves.rapid(at_height(start, job.retract))
            _way_down(job, start, end).descend(moves, level)
            moves.feed(at_height(end, level))
            moves.height(job.retract, rapid=True)
    return moves.paths()
