"""Walls: passes along a contour, outside a profile or boss, or inside a pocket; layer by layer, depth by depth."""

from __future__ import annotations

import math

import numpy as np

from cncgen.stepnc.features import offsets
from cncgen.stepnc.features.job import Floats, Job, Moves, raised
from cncgen.stepnc.geometry.approach import start_tangent
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline
from cncgen.stepnc.model import Path, Strategy

#: Radius of the arcs onto and off the contour, in diameters of the tool (NIST gives none; a common choice).
LEAD_RADIUS = 0.25


def mill_outside(job: Job) -> tuple[Path, ...]:
    """Return the toolpaths round the outside of a profile."""
    return _mill(job, outside=True)


def mill_inside(job: Job) -> tuple[Path, ...]:
    """Return the toolpaths along the walls inside an outline."""
    return _mill(job, outside=False)


def _outline(job: Job) -> list[Piece]:
    if job.shape.outline is not None:
        return job.shape.outline
    if job.shape.diameter is None:
        raise job.fault("stepnc-missing", "the feature has no boundary")
    start = np.array([job.shape.diameter / 2, 0.0, 0.0])
    return [Arc(start, start, np.zeros(3), np.array([0.0, 0.0, 1.0]), 2 * math.pi)]


def _mill(job: Job, outside: bool) -> tuple[Path, ...]:
    if job.shape.slope > 1e-9:
        raise job.fault("stepnc-unsupported", "walls with a slope cannot be made by passes of one outline")
    radius, allowance = job.radius, job.value("allowance_side", 0.0)
    whole = offsets.polygon_of(_outline(job))
    levels = job.levels(job.depth - job.value("allowance_bottom", 0.0) + job.value("overcut_length", 0.0))
    corner = job.shape.corner_radius or 0.0
    distance = -(radius + allowance) if outside else radius + allowance
    # Climb outside goes with the clock, inside against it (spindle with the clock), a hole the other way round.
    clockwise = job.climb == outside if job.clockwise_spindle else job.climb != outside
    moves: Moves | None = None
    for inset in _layers(job, distance, outside):
        for polygon in offsets.region(whole, [], inset, corner):
            for curve in offsets.boundary_curves(polygon, clockwise)[:1]:
                moves = _passes(job, curve, levels, moves, outside)
    if moves is None:
        raise job.fault("stepnc-geometry", "the tool does not fit inside the outline")
    return moves.paths()


def _layers(job: Job, distance: float, outside: bool) -> list[float]:
    """Return the insets of the passes, from the outermost material to the wall.

    How much stands before the wall is not in the feature; where the operation gives a radial depth and its strategy
    allows several passes, there is one layer before the last, a radial depth away.
    """
    radial = job.value("radial_cutting_depth", 0.0)
    strategy = job.operation.strategy
    several = strategy is not None and strategy.values.get("allow_multiple_passes") is True
    if not (several and radial > 0):
        return [distance]
    return [distance + (-radial if outside else radial), distance]


def _passes(job: Job, curve: list[Piece], levels: list[float], moves: Moves | None, outside: bool) -> Moves:
    """Go round a contour on all levels, onto it and off it from the free side."""
    along = start_tangent(curve[0])
    free = _free_side(curve, along, outside)
    on = _lead(job, job.operation.approach, curve[0].start, along, free)
    off = _lead(job, job.operation.retract, curve[0].start, -along, free).reversed()
    start = on.start
    if moves is None:
        moves = Moves(job.operation.ident, np.array([start[0], start[1], job.retract]))
    for level in levels:
        moves.rapid(np.array([moves.position[0], moves.position[1], job.retract]))
        moves.rapid(np.array([start[0], start[1], job.retract]))
        moves.height(level)
        moves.follow(raised([on, *curve, off], level))
        moves.height(job.retract)
    return moves


def _lead(job: Job, strategy: Strategy | None, point: Floats, along: Floats, free: Floats) -> Piece:
    """Return the way onto a contour at a point: an arc of a radius, a line at an angle, else a quarter circle."""
    values = strategy.values if strategy else {}
    if strategy is not None and strategy.kind == "ap retract angle":
        angle, length = math.radians(float(values.get("angle", 0.0))), float(values.get("travel_length", 0.0))
        if not length > 0:
            raise job.fault("stepnc-geometry", f"a travel length of {length:g} mm")
        away = length * (math.sin(angle) * free - math.cos(angle) * along)
        return Polyline(np.stack([point + away, point]))
    radius = LEAD_RADIUS * 2 * job.radius
    if strategy is not None and strategy.kind == "ap retract tangent":
        radius = float(values.get("radius", radius))
        if not radius > 0:
            raise job.fault("stepnc-geometry", f"an approach by an arc of {radius:g} mm")
    elif strategy is not None and strategy.kind != "plunge toolaxis":
        job.warn(
            "stepnc-approach", f"{strategy.kind!r} is for pockets; the contour is met by a quarter circle"
        )
    return _quarter(point, along, free, radius)


def _free_side(curve: list[Piece], along: Floats, outside: bool) -> Floats:
    """Return the unit vector across the contour's start to where no material stands."""
    left = np.array([-along[1], along[0], 0.0])
    polygon = offsets.polygon_of(curve)
    inside = offsets.clearance(polygon, curve[0].start + 1e-3 * left) > 0
    return left if inside != outside else -left


def _quarter(point: Floats, along: Floats, free: Floats, radius: float) -> Arc:
    """Return the quarter circle that comes onto the contour at a point."""
    centre = point + radius * free
    turn = float(np.cross(along, free)[2])
    normal = np.array([0.0, 0.0, 1.0 if turn > 0 else -1.0])
    return Arc(centre - radius * along, point, centre, normal, math.pi / 2)
