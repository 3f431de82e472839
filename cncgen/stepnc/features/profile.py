"""Walls: passes along a contour, outside a profile or boss, or inside a pocket; layer by layer, depth by depth."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby, pairwise
from typing import TYPE_CHECKING

import numpy as np

from cncgen.stepnc.features import offsets, outlines, pocket
from cncgen.stepnc.features.job import Floats, Job, Moves, at_height, raised
from cncgen.stepnc.features.walls import Layer, axis_distance, layers
from cncgen.stepnc.geometry import profile_shapes
from cncgen.stepnc.geometry.approach import start_tangent
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline
from cncgen.stepnc.model import Boss, CutterPath, MachiningStrategy

if TYPE_CHECKING:
    from shapely import Polygon

#: Radius of the arcs onto and off the contour, in diameters of the tool (NIST gives none; a common choice).
LEAD_RADIUS = 0.25
#: How often a lead that does not fit is halved.
SHORTEST_LEAD = 6


def mill_outside(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths round a profile or boss (SIDE_…_MILLING, ISO 14649-11): on its wall, and in layers if asked."""
    return _mill(job, outside=True)


def mill_inside(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths along the walls inside an outline; over its open sides they run beside the material."""
    return _mill(job, outside=False)


def clear_outside(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths of bottom and side milling round a profile or boss.

    Roughing clears all of the raw piece round it, finishing goes round its wall. Where the raw piece is not given,
    roughing does as finishing, with a warning: how much stands round the profile is not known.
    """
    stock = job.shape.stock
    if not job.operation.kind.endswith("rough"):
        return _mill(job, outside=True)
    if stock is None:
        text = "the raw piece has no bounding geometry; the wall alone is cut, in one layer round it"
        job.warn("stepnc-stock", text)
        return _mill(job, outside=True)
    boss = Boss(_outline(job), job.shape.slope)
    shape = replace(job.shape, bosses=(boss,), slope=0.0, corner_radius=None, floor_radius=None)
    return pocket.mill_open(replace(job, shape=shape), stock)


def _outline(job: Job) -> list[Piece]:
    if job.shape.outline is not None:
        return job.shape.outline
    if job.shape.diameter is None:
        raise job.fault("stepnc-missing", "the feature has no boundary")
    return [profile_shapes.circle(job.shape.diameter)]


def _mill(job: Job, outside: bool) -> tuple[CutterPath, ...]:
    whole = offsets.polygon_of(_outline(job))
    total = job.depth - job.value("allowance_bottom", 0.0) + job.value("overcut_length", 0.0)
    passes = _outer_layers(job, total) if outside else layers(job, total)
    if job.shape.open_sides:
        whole = pocket.opened(job, whole, total)
    corner = job.shape.corner_radius or 0.0
    # Climb outside goes with the clock, inside against it (spindle with the clock), a hole the other way round.
    clockwise = job.climb == outside if job.clockwise_spindle else job.climb != outside
    moves: Moves | None = None
    for further in _further(job, outside):
        for layer in passes:
            heights = [level for _, level in layer.spans]
            for polygon in layer.region(whole, corner, -further if outside else further):
                curves = offsets.boundary_curves(polygon, clockwise)
                for curve in curves[:1] if outside else curves:
                    moves = _passes(job, curve, heights, moves, Free(polygon, outside))
            if further == 0.0:
                _check_notches(job, whole, layer, corner, outside)
    if moves is None:
        raise job.fault("stepnc-geometry", "the tool does not fit inside the outline")
    return moves.paths()


def _outer_layers(job: Job, total: float) -> list[Layer]:
    """Return the passes round the outside, each with the (negative) inset of its contour."""
    side = job.value("allowance_side", 0.0)
    spans = list(pairwise([0.0, *job.levels(total)]))
    groups = groupby(spans, lambda span: -side - axis_distance(job, job.shape.slope, -span[1]))
    return [Layer(tuple(group), inset, ()) for inset, group in groups]


def _check_notches(job: Job, whole: Polygon, layer: Layer, corner: float, outside: bool) -> None:
    """Warn of notches in the outline that are too narrow for the tool, others than the corners that it rounds."""
    radius, axis = job.radius, layer.region(whole, corner, 0.0)
    if outside:
        left, reached = offsets.filled(axis, layer.moved(radius).region(whole, corner, 0.0), radius)
    else:
        walls = layer.moved(-radius).region(whole, corner, 0.0)
        left, reached = offsets.not_swept(walls, axis, radius), offsets.swept(axis, radius)
    widths = [2 * offsets.inradius(p)[0] for p in offsets.notches(left, reached, radius)]
    if widths:
        text = f"the tool of {2 * radius:g} mm does not reach {len(widths)} notches up to {max(widths):.3g} mm wide"
        job.warn("stepnc-uncut", f"{text}; material stays there")


@dataclass(frozen=True, slots=True)
class Free:
    """Where the tool's axis may go beside a contour: inside a shapely polygon, or outside of it."""

    polygon: Polygon
    outside: bool

    def holds(self, piece: Piece) -> bool:
        """Tell whether a piece stays there (within 1e-3 mm)."""
        return offsets.piece_inside(self.polygon, piece, self.outside)

    def side(self, point: Floats, along: Floats) -> Floats:
        """Return the unit vector across the contour at a point to where no material stands."""
        left = np.array([-along[1], along[0], 0.0])
        inside = offsets.clearance(self.polygon, point + 1e-3 * left) > 0
        return left if inside != self.outside else -left


def _further(job: Job, outside: bool) -> list[float]:
    """Return how far each pass stays from the wall beyond the allowance, from the outermost material to the wall, mm.

    Where the operation gives a radial depth and its strategy allows several passes, the layers reach to the farthest
    corner of the raw piece; where that is not known, and inside, there is one layer before the last.
    """
    radial = job.value("radial_cutting_depth", 0.0)
    strategy = job.operation.strategy
    several = strategy is not None and strategy.values.get("allow_multiple_passes") is True
    if not (several and radial > 0):
        return [0.0]
    count = 2
    if outside and job.shape.stock is not None:
        far = offsets.farthest(_outline(job), job.shape.stock) - job.value("allowance_side", 0.0)
        count = max(1, math.ceil(far / radial - 1e-9))
        if count > offsets.MAX_RINGS:
            text = f"{count} layers of {radial:g} mm are more than {offsets.MAX_RINGS}"
            raise job.fault("stepnc-geometry", text)
    return [radial * k for k in reversed(range(count))]


def _passes(job: Job, curve: list[Piece], levels: list[float], moves: Moves | None, free: Free) -> Moves:
    """Go round a contour on all levels, onto it and off it from the free side, from the middle of its longest piece."""
    curve = outlines.starting_near(curve, outlines.middle_of_longest(curve))
    point, along = curve[0].start, start_tangent(curve[0])
    side = free.side(point, along)
    on = _lead(job, job.operation.approach, point, along, side, free)
    off = [p.reversed() for p in _lead(job, job.operation.retract, point, -along, side, free)]
    path = [*on, *curve, *off]
    start = path[0].start
    if moves is None:
        moves = Moves(job.operation.ident, at_height(start, job.retract))
    for level in levels:
        moves.rapid(at_height(moves.position, job.retract))
        moves.rapid(at_height(start, job.retract))
        moves.height(level)
        moves.follow(raised(path, level))
        moves.height(job.retract)
    return moves


def _lead(
    job: Job, strategy: MachiningStrategy | None, point: Floats, along: Floats, side: Floats, free: Free
) -> list[Piece]:
    """Return the way onto a contour at a point: an arc of a radius, a line at an angle, else a quarter circle.

    AP_RETRACT_TANGENT and AP_RETRACT_ANGLE of ISO 14649-11.

    Where it would run into material it is made shorter, with a warning where its size is given. Where none fits, the
    tool plunges at the point.
    """
    values = strategy.values if strategy else {}
    size = LEAD_RADIUS * 2 * job.radius
    make: Callable[[float], Piece] = partial(_quarter, point, along, side)
    given = strategy is not None and strategy.kind in ("ap retract angle", "ap retract tangent")
    if strategy is not None and strategy.kind == "ap retract angle":
        angle, size = float(values.get("angle", 0.0)), float(values.get("travel_length", 0.0))
        make = partial(_straight, point, math.sin(angle) * side - math.cos(angle) * along)
    elif strategy is not None and strategy.kind == "ap retract tangent":
        size = float(values.get("radius", size))
    elif strategy is not None and strategy.kind != "plunge toolaxis":
        job.warn(
            "stepnc-approach", f"{strategy.kind!r} is for pockets; the contour is met by a quarter circle"
        )
    if not size > 0:
        text = f"the approach or retract has a size of {size:g} mm; it must be above 0"
        raise job.fault("stepnc-geometry", text)
    for halvings in range(SHORTEST_LEAD):
        piece = make(size / 2**halvings)
        if free.holds(piece):
            if given and halvings:
                job.warn(
                    "stepnc-approach",
                    f"an approach of {size:g} mm does not fit; it has {size / 2**halvings:g}",
                )
            return [piece]
    job.warn("stepnc-approach", "no way onto the contour fits; the tool plunges on it")
    return []


def _straight(point: Floats, away: Floats, length: float) -> Polyline:
    """Return the line onto a point from the direction `away`."""
    return Polyline(np.stack([point + length * away, point]))


def _quarter(point: Floats, along: Floats, free: Floats, radius: float) -> Arc:
    """Return the quarter circle that comes onto the contour at a point."""
    centre = point + radius * free
    turn = float(np.cross(along, free)[2])
    normal = np.array([0.0, 0.0, 1.0 if turn > 0 else -1.0])
    return Arc(centre - radius * along, point, centre, normal, math.pi / 2)
