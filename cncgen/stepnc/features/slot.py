"""Slots along a path, and steps: open ends and sides are extended until the tool is out of the material."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cncgen.stepnc.features import offsets, pocket
from cncgen.stepnc.features.job import Job, Moves, at_height, raised
from cncgen.stepnc.geometry.approach import start_tangent
from cncgen.stepnc.geometry.pieces import Piece, Polyline, reverse
from cncgen.stepnc.model import Path

#: Difference of slot width and tool diameter up to which one pass along the middle makes the slot, mm.
SAME_WIDTH = 1e-6


def _course(job: Job) -> tuple[list[Piece], float]:
    course, width = job.shape.course, job.shape.width
    if course is None or width is None:
        raise job.fault("stepnc-missing", "the slot has no course or no width")
    if any(abs(float(p.end[2] - p.start[2])) > 1e-9 for p in course):
        raise job.fault("stepnc-unsupported", "a slot whose course is not level cannot be made")
    return course, width


def _extended(job: Job, course: list[Piece]) -> list[Piece]:
    """Return the course with straight lines added at its open ends: radius and overcut."""
    out = list(course)
    reach = job.radius + job.value("overcut_length", 0.0)
    ends = (*job.shape.ends, "", "")[:2]
    for end in ends:
        if end in ("woodruff", "loop"):
            raise job.fault("stepnc-unsupported", f"a slot with a {end} end cannot be made")
    if ends[0] == "open":
        first = out[0].start
        out.insert(0, Polyline(np.stack([first - reach * start_tangent(out[0]), first])))
    if ends[1] == "open":
        last = out[-1].end
        out.append(Polyline(np.stack([last, last - reach * start_tangent(out[-1].reversed())])))
    return out


def mill(job: Job) -> tuple[Path, ...]:
    """Return the toolpaths of a slot: along its middle where the tool is as wide, else as a pocket about its course."""
    course, width = _course(job)
    ends = (*job.shape.ends, "", "")[:2]
    allowance = job.value("allowance_side", 0.0)
    free = width - 2 * job.radius - 2 * allowance
    if free < -SAME_WIDTH:
        raise job.fault(
            "stepnc-geometry", f"a tool of {2 * job.radius:g} mm does not fit a slot of {width:g} mm"
        )
    path = _extended(job, course)
    if free > SAME_WIDTH:
        outline = offsets.strip(path, width / 2, tuple(e == "radiused" for e in ends))
        return pocket.mill(replace(job, shape=replace(job.shape, outline=outline, floor_radius=None)))
    return _along(job, path, job.levels(job.depth - job.value("allowance_bottom", 0.0)))


def _along(job: Job, path: list[Piece], levels: list[float]) -> tuple[Path, ...]:
    """Return passes along a path, to and fro, plunging at its ends."""
    moves = Moves(job.operation.ident, at_height(path[0].start, job.retract))
    for k, level in enumerate(levels):
        way = path if k % 2 == 0 else reverse(path)
        moves.height(level)
        moves.follow(raised(way, level))
    moves.height(job.retract)
    return moves.paths()


def step(job: Job) -> tuple[Path, ...]:
    """Return nothing: what a step removes beside its wall is not in the feature.

    Raises:
        Skip: where the width of the step is not given.
    """
    course, width = job.shape.course, job.shape.width
    if course is None or width is None:
        raise job.fault("stepnc-missing", "the step has no wall or no width")
    along = course[-1].end - course[0].start
    length = float(np.linalg.norm(along))
    if length < 1e-9 or len(course) > 1:
        raise job.fault("stepnc-unsupported", "a step along a path that is not straight cannot be made")
    left = np.array([-along[1], along[0], 0.0]) / length * width
    a, b = course[0].start, course[0].end
    outline: list[Piece] = [
        Polyline(np.stack(p)) for p in ((a, b), (b, b + left), (b + left, a + left), (a + left, a))
    ]
    shape = replace(job.shape, outline=outline, open_sides=(1, 2, 3))
    return pocket.mill(replace(job, shape=shape))
