"""Slots along a path, and steps: open ends and sides are extended until the tool is out of the material."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.features import offsets, pocket, profile
from cncgen.stepnc.features.entry import Entry, along_cut, plunge
from cncgen.stepnc.features.job import Job, Moves, at_height, raised
from cncgen.stepnc.features.walls import drawn_in
from cncgen.stepnc.geometry.approach import start_tangent
from cncgen.stepnc.geometry.pieces import Piece, Polyline, reverse
from cncgen.stepnc.model import Boss, CutterPath

#: Difference of slot width and tool diameter up to which one pass along the middle makes the slot, mm.
SAME_WIDTH = 1e-6
#: Smaller differences of the angles of a vee and its tool do not count, rad.
SAME_ANGLE = math.radians(0.1)


def _course(job: Job) -> tuple[list[Piece], float]:
    """Return the course and the width at the top: where the walls lean, `width` is that of the floor."""
    course, width = _path(job), job.shape.width
    if width is None:
        raise job.fault("stepnc-missing", "the slot has no width")
    return course, width + 2 * _lean(job)


def _lean(job: Job) -> float:
    """Return how far the foot of a leaning wall is from its top, mm."""
    return job.depth * math.tan(job.shape.slope) if job.shape.slope else 0.0


def _path(job: Job) -> list[Piece]:
    course = job.shape.course
    if course is None:
        raise job.fault("stepnc-missing", "the slot has no course")
    if any(abs(float(p.end[2] - p.start[2])) > 1e-9 for p in course):
        raise job.fault("stepnc-unsupported", "a slot whose course is not level cannot be made")
    if "woodruff" in job.shape.ends:
        raise job.fault("stepnc-unsupported", "a slot with a woodruff end cannot be made")
    return course


def _is_loop(course: list[Piece]) -> bool:
    return float(elementary.length(course[-1].end - course[0].start)) < 1e-6


def _extended(job: Job, course: list[Piece]) -> list[Piece]:
    """Return the course with straight lines added at its open ends: radius and overcut."""
    out = list(course)
    reach = job.radius + job.value("overcut_length", 0.0) + drawn_in(job, job.depth)
    ends = (*job.shape.ends, "", "")[:2]
    if ends[0] == "open":
        first = out[0].start
        out.insert(0, Polyline(np.stack([first - reach * start_tangent(out[0]), first])))
    if ends[1] == "open":
        last = out[-1].end
        out.append(Polyline(np.stack([last, last - reach * start_tangent(out[-1].reversed())])))
    return out


def _middle(job: Job, course: list[Piece]) -> list[Piece]:
    """Return the way of a tool as wide as the slot: beyond open ends, and up to flat ones, where it leaves the corners.

    The course ends in a flat end, and in the centre of a round one (ISO 14649-10, slot end types).
    """
    if _is_loop(course):
        return course
    out = _extended(job, course)
    for k, end in enumerate(job.shape.ends[:2]):
        if end == "flat":
            out = reverse(_shortened(job, reverse(out))) if k == 0 else _shortened(job, out)
            text = f"the corners of a flat end are rounded by the tool, {job.radius:g} mm"
            job.warn("stepnc-uncut", text)
    return out


def _shortened(job: Job, course: list[Piece]) -> list[Piece]:
    """Return a course whose end is cut off by the tool's radius."""
    *rest, last = course
    if isinstance(last, Polyline):
        step = last.points[-1] - last.points[-2]
        length = float(elementary.length(step))
        if length > job.radius:
            end = last.points[-1] - job.radius / length * step
            return [*rest, Polyline(np.concatenate([last.points[:-1], end[None, :]]))]
    text = (
        f"a flat end is made at the end of a straight line longer than the tool's radius, {job.radius:g} mm"
    )
    raise job.fault("stepnc-unsupported", text)


def mill(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths of a SLOT (ISO 14649-10).

    They go along its middle where the tool is as wide, else as in a pocket about its course.
    """
    if job.shape.section:
        return _formed(job)
    course, top = _course(job)
    width = top - 2 * _lean(job)
    free = width - 2 * job.radius - 2 * job.value("allowance_side", 0.0)
    if free < -SAME_WIDTH:
        text = f"a tool of {2 * job.radius:g} mm does not fit a slot of {width:g} mm"
        side = job.value("allowance_side", 0.0)
        text += f" with {side:g} mm left on either wall (allowance_side)" if side else ""
        raise job.fault("stepnc-geometry", text)
    floor = job.shape.floor_radius
    if floor is not None and floor >= width / 2 - SAME_WIDTH and free > SAME_WIDTH:
        text = f"a floor round all across ({floor:g} mm) needs a tool as wide as the slot, {width:g} mm"
        raise job.fault("stepnc-unsupported", text)
    if free > SAME_WIDTH:
        if job.shape.slope and "flat" in job.shape.ends:
            job.warn(
                "stepnc-uncut",
                "the walls of a flat end lean as the others do; the rest beside them is not cut",
            )
        return pocket.mill(_as_pocket(job, course, top))
    if job.shape.slope:
        text = f"leaning walls need a tool narrower than the floor of the slot, {width:g} mm; this one has {2 * job.radius:g} mm"
        raise job.fault("stepnc-geometry", text)
    if floor is not None and floor > job.tool.edge + SAME_WIDTH:
        text = f"the floor has a radius of {floor:g} mm; a tool as wide as the slot whose edge has {job.tool.edge:g} mm cuts it away"
        raise job.fault("stepnc-geometry", text)
    pocket.check_radii(job)
    return _along(job, _middle(job, course), job.levels(job.depth - job.value("allowance_bottom", 0.0)))


def _formed(job: Job) -> tuple[CutterPath, ...]:
    """Return the passes along the middle of a slot whose section is the tool's: a vee, or an arc cut by a ball."""
    shape, tool = job.shape, job.tool
    half, radius = shape.section_angle / 2, shape.section_radius
    if shape.section == "vee":
        point = math.nan if tool.tip_angle is None else math.pi - 2 * tool.tip_angle
        fits = (
            abs(point - shape.section_angle) <= SAME_ANGLE and abs((tool.edge_radius or 0.0) - radius) <= 1e-6
        )
        wanted = f"a point of {math.degrees(shape.section_angle):.1f} degrees rounded by {radius:g} mm"
        width = 2 * (radius / math.cos(half) + (job.depth - radius) * math.tan(half))
    else:
        fits = abs(tool.edge - radius) <= 1e-6 and abs(job.radius - radius) <= 1e-6
        wanted = f"a ball of {radius:g} mm radius"
        width = 2 * radius * math.sin(min(half, math.pi / 2))
        if abs(job.depth - radius * (1 - math.cos(half))) > 1e-3:
            text = f"the arc is {radius * (1 - math.cos(half)):.3f} mm deep, the slot {job.depth:.3f}; the slot's counts"
            job.warn("stepnc-depth", text)
    if not fits or job.value("allowance_side", 0.0) or job.value("allowance_bottom", 0.0):
        text = f"a slot of this section needs {wanted}, and no allowances"
        raise job.fault("stepnc-unsupported", text)
    if width > 2 * job.radius + 1e-6:
        text = f"the slot is {width:.3f} mm wide at its top, wider than the tool, {2 * job.radius:g} mm"
        raise job.fault("stepnc-geometry", text)
    return _along(job, _middle(job, _path(job)), job.levels(job.depth))


def mill_walls(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths along both walls of a slot."""
    if job.shape.section:
        raise job.fault(
            "stepnc-unsupported",
            f"walls of a slot whose section is {job.shape.section} cannot be finished alone; a rough operation cuts the slot",
        )
    return profile.mill_inside(_as_pocket(job, *_course(job)))


def _as_pocket(job: Job, course: list[Piece], width: float) -> Job:
    """Return the slot as a pocket within half its width of the course; a loop leaves its middle standing."""
    loop = _is_loop(course)
    rounded = () if loop else tuple(end == "radiused" for end in (*job.shape.ends, "", "")[:2])
    outlines = offsets.strip(course if loop else _extended(job, course), width / 2, rounded)
    if not outlines:
        raise job.fault("stepnc-geometry", f"no slot {width:g} mm wide follows the course in one piece")
    outline, *inner = outlines
    bosses = tuple(Boss(b, job.shape.slope) for b in inner) if loop else job.shape.bosses
    return replace(job, shape=replace(job.shape, outline=outline, bosses=bosses))


def _along(job: Job, path: list[Piece], levels: list[float]) -> tuple[CutterPath, ...]:
    """Return passes along a path, to and fro; where an end is within the material the tool goes down as the approach asks."""
    ways = (path, reverse(path))
    entries = [_way_down(job, way, k) for k, way in enumerate(ways)]
    moves = Moves(job.operation.ident, at_height(path[0].start, job.retract))
    moves.height(min(job.top, job.retract))
    for k, level in enumerate(levels):
        way = ways[k % 2]
        entries[k % 2].descend(moves, level)
        moves.follow(raised(way, level))
    moves.height(job.retract)
    return moves.paths()


def _way_down(job: Job, way: list[Piece], end: int) -> Entry:
    """Return the way down at the beginning of a way: straight beside the material, else along the cut.

    Args:
        job: The slot.
        way: From the end on.
        end: Which of the slot's ends it is, 0 or 1.
    """
    place = way[0].start
    if not _is_loop(way) and (*job.shape.ends, "", "")[end] == "open":
        if job.shape.stock is None:
            return plunge(place)
        beyond = offsets.distance_to(offsets.polygon_of(job.shape.stock), place)
        if beyond >= job.radius - 1e-6:
            return plunge(place)
        text = f"the slot's open end lies within the raw piece: the tool would be {job.radius - beyond:.3g} mm in material"
        job.warn("stepnc-open-end", f"{text} beyond the end; it goes down along the slot")
    return along_cut(job, place, way)


def step(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths that clear a STEP (ISO 14649-10) from its wall to the end of its width, else of the raw piece."""
    return pocket.mill(_step_as_pocket(job))


def step_wall(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths along the wall of a step."""
    return profile.mill_inside(_step_as_pocket(job))


def _step_as_pocket(job: Job) -> Job:
    """Return the step as a pocket open on every side that does not stand in the material.

    The course is the foot of the wall, and what is removed lies on its right. Sides within the raw piece are walls;
    where that is not known, the wall along the course is the only one.
    """
    course, width, stock = job.shape.course, job.shape.width, job.shape.stock
    if course is None:
        raise job.fault("stepnc-missing", "the step has no wall")
    along = course[-1].end - course[0].start
    length = float(np.hypot(along[0], along[1]))
    if length < 1e-9 or abs(float(along[2])) > 1e-9 or len(course) > 1 or not isinstance(course[0], Polyline):
        raise job.fault(
            "stepnc-unsupported", "a step along a path that is not straight and level cannot be made"
        )
    right = np.array([along[1], -along[0], 0.0]) / length
    foot = course[0].points[[0, -1]]
    if width is None and stock is None:
        text = "how wide the step is follows from the raw piece, and that has no bounding geometry"
        raise job.fault("stepnc-missing", text, hint="give the workpiece an its_rawpiece with a BLOCK")
    if width is None:
        _, far = offsets.bounds_along(stock or [], right)
        width = far - float(elementary.product(foot[0], right))
        if not width > 0:
            raise job.fault("stepnc-geometry", "the raw piece ends before the wall of the step")
    top = foot - job.depth * math.tan(job.shape.slope) * right
    corners = np.stack([top[0], top[1], foot[1] + width * right, foot[0] + width * right, top[0]])
    outline, closed = offsets.within_stock(corners, stock)
    open_sides = tuple(k for k in range(len(outline)) if k not in closed)
    return replace(job, shape=replace(job.shape, outline=outline, open_sides=open_sides))
