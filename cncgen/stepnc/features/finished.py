"""The material that remains after all features: the lowest height that operations may cut, and the floors that they must reach."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Skip
from cncgen.stepnc.features import offsets, slot
from cncgen.stepnc.features.holes import tip_length
from cncgen.stepnc.features.job import Job
from cncgen.stepnc.features.offsets import OffsetError
from cncgen.stepnc.geometry import profile_shapes
from cncgen.stepnc.geometry.frames import Matrix
from cncgen.stepnc.geometry.pieces import Piece
from cncgen.stepnc.model import Feature, Workingstep
from cncgen.stepnc.part21 import Exchange

if TYPE_CHECKING:
    from shapely import Polygon

Floats = NDArray[np.float64]

#: How far beyond its open sides a feature may be cut, mm.
BEYOND = 1e3
#: Nothing is demanded of material so near to a wall, mm: a place on the wall itself may be told to stand or to go.
NEAR_WALL = 0.01
_HOLE_KINDS = ("round hole", "thread")
#: Operations that clear a hole as wide as their tool, without going round.
_DRILLING = ("drilling", "multistep drilling", "boring", "reaming")
_AROUND = ("general outside profile", "boss")
_AREAS = ("planar face", "closed pocket", "open pocket", "slot", "step")


@dataclass(frozen=True, slots=True)
class Cavity:
    """The material that one feature allows to be removed, in its frame.

    Attributes:
        frame: Of the feature, seen from the machine; its Z is the machine's.
        region: shapely polygon of its top.
        depth: Of its floor below its origin, mm.
        slope: Draft of its walls, rad.
        bosses: Standing in it: polygon, slope and height of the top of each.
        fillet: Radius between its upright walls and the floor, mm.
        tip: Of a round bottom: how deep below the floor its middle lies, and the radius over which it does so, mm.
        demands: shapely polygon within which nothing may be left, or None.
        demanded: Depth of the floor there, mm.
        owner: The workingstep that cuts it, by name, and its source line.
    """

    frame: Matrix
    region: Polygon
    depth: float
    slope: float = 0.0
    bosses: tuple[tuple[Polygon, float, float], ...] = ()
    fillet: float = 0.0
    tip: tuple[float, float] = (0.0, 1.0)
    demands: Polygon | None = None
    demanded: float = 0.0
    owner: tuple[str, int] = ("", 1)

    def _inside(self, polygon: Polygon, x: Floats, y: Floats) -> tuple[NDArray[np.bool_], Any]:
        """Tell which places of the machine, shapes alike, are over a polygon of the frame; return those as points of shapely."""
        import shapely

        inverse = np.linalg.inv(self.frame)
        u = inverse[0, 0] * x + inverse[0, 1] * y + inverse[0, 3]
        v = inverse[1, 0] * x + inverse[1, 1] * y + inverse[1, 3]
        low_u, low_v, high_u, high_v = polygon.bounds
        near = (u >= low_u) & (u <= high_u) & (v >= low_v) & (v <= high_v)
        places = shapely.points(u[near], v[near])
        shapely.prepare(polygon)
        hit = shapely.intersects(polygon, places)
        inside = np.zeros(x.shape, bool)
        inside[near] = hit
        return inside, places[hit]

    def lower(self, x: Floats, y: Floats, out: Floats) -> None:
        """Lower heights, shapes alike, to the lowest that may be cut at places of the machine."""
        inside, places = self._inside(self.region, x, y)
        if inside.any():
            out[inside] = np.minimum(out[inside], self.frame[2, 3] + self._heights(places))

    def lower_demanded(self, x: Floats, y: Floats, out: Floats) -> None:
        """Lower heights, shapes alike, to those above which nothing may be left at places of the machine."""
        if self.demands is not None and not self.demands.is_empty:
            inside, _ = self._inside(self.demands, x, y)
            out[inside] = np.minimum(out[inside], self.frame[2, 3] - self.demanded)

    def _heights(self, places: NDArray[np.object_]) -> Floats:
        """Return the lowest heights that may be cut at points of the region, in the frame."""
        import shapely

        depth = np.full(len(places), self.depth)
        if self.slope > 1e-9:
            away = shapely.distance(self.region.boundary, places)
            depth = np.minimum(depth, away / math.tan(self.slope))
        elif self.fillet > 0:
            away = np.minimum(shapely.distance(self.region.boundary, places), self.fillet)
            depth = depth - self.fillet + np.sqrt(self.fillet**2 - (self.fillet - away) ** 2)
        deeper, radius = self.tip
        if deeper > 0:
            centre = shapely.points(*self.region.centroid.coords[0])
            rho = shapely.distance(centre, places)
            depth = depth + deeper * np.maximum(1 - rho / radius, 0.0)
        heights = -depth
        for polygon, slope, top in self.bosses:
            away = shapely.distance(polygon, places)
            wall = np.where(away > 0, -np.inf, top)
            if slope > 1e-9:
                wall = top - away / math.tan(slope)
            heights = np.maximum(heights, wall)
        return np.asarray(heights)


@dataclass(frozen=True, slots=True)
class Finished:
    """The material that all features of a program leave standing together."""

    cavities: tuple[Cavity, ...]

    @classmethod
    def of(cls, steps: Sequence[Workingstep], exchange: Exchange) -> Finished | None:
        """Return what the features of workingsteps leave, None where one has no feature whose shape is known, or is tilted."""
        made: list[Cavity] = []
        for step in steps:
            if step.rapid or step.operation.kind == "probing":
                continue
            if step.feature is None or step.frame[2, 2] < 1 - 1e-9:
                return None
            try:
                cavities = _owned(_cavities(step, step.feature, step.frame, exchange, 0), step, exchange)
            except (Skip, OffsetError):
                return None
            if not cavities:
                return None
            made += cavities
        return cls(tuple(made)) if made else None

    def floor(self, x: Floats, y: Floats) -> Floats:
        """Return the lowest height that may be cut at places, shapes alike, mm; +inf where nothing may be."""
        out = np.full(x.shape, np.inf)
        for cavity in self.cavities:
            cavity.lower(x, y, out)
        return out

    def demanded(self, x: Floats, y: Floats) -> Floats:
        """Return the height above which nothing may remain, shapes alike, mm; +inf without such a feature."""
        out = np.full(x.shape, np.inf)
        for cavity in self.cavities:
            cavity.lower_demanded(x, y, out)
        return out

    def owner(self, x: float, y: float) -> tuple[str, int]:
        """Return the name and the source line of the workingstep whose floor is the lowest demanded at a place."""
        lowest, found = np.inf, ("", 1)
        for cavity in self.cavities:
            height = np.full(1, np.inf)
            cavity.lower_demanded(np.array([x]), np.array([y]), height)
            if height[0] < lowest:
                lowest, found = float(height[0]), cavity.owner
        return found


def _cavities(
    step: Workingstep, feature: Feature, frame: Matrix, exchange: Exchange, level: int
) -> list[Cavity]:
    """Return what a feature and its elements allow."""
    shape = feature.shape()
    if shape.elements:
        if level > 5:
            return []
        return [
            cavity
            for element in shape.elements
            for cavity in _cavities(
                step, element, elementary.product(frame, element.placement), exchange, level + 1
            )
        ]
    job = Job(step.ident, step.operation, shape, exchange)
    over = job.value("overcut_length", 0.0)
    if shape.depth is None or job.tool.diameter is None:
        raise Skip
    if feature.kind in _HOLE_KINDS:
        return [_hole(job, frame, over)]
    if feature.kind in _AROUND:
        return [_around(job, frame, over)]
    if feature.kind not in _AREAS or shape.section:
        raise Skip
    return [_area(job, feature.kind, frame, over)]


def _owned(cavities: list[Cavity], step: Workingstep, exchange: Exchange) -> list[Cavity]:
    """Return cavities with the workingstep that cuts them."""
    owner = (step.label or step.operation.label, exchange.line(step.operation.ident))
    return [replace(c, owner=owner) for c in cavities]


def _hole(job: Job, frame: Matrix, over: float) -> Cavity:
    """Return a hole, with the cone of a drill's point below it, as far as its bottom is one that a drill makes."""
    shape, kind = job.shape, job.operation.kind
    radius = (shape.diameter or 0.0) / 2
    if kind == "tapping":
        radius = max(radius, job.radius)
    elif shape.thread is not None:
        radius = max(radius, shape.thread / 2)
    if shape.slope < 0 or radius <= 0:
        raise Skip
    depth = (shape.depth or 0.0) + (over if shape.bottom in ("", "through") else 0.0)
    cone = 0.0
    if shape.bottom == "conical" and shape.bottom_angle:
        cone = radius / math.tan(shape.bottom_angle / 2)
    if kind.startswith(("bottom", "side")):
        depth += (shape.bottom_radius or 0.0) if shape.bottom == "spherical" else 0.0
    else:
        # `stepnc-tip` reports a drill whose point differs from the bottom.
        depth = max(depth, job.value("cutting_depth", 0.0) + over) + max(cone, tip_length(job.tool))
        cone = 0.0
    region = offsets.polygon_of([profile_shapes.circle(2 * radius)])
    whole = Cavity(frame, region, depth, shape.slope, tip=(cone, radius))
    drills = kind in _DRILLING
    # A milled thread leaves its ridges, which a height field does not have.
    mills = kind.startswith("bottom and side") and shape.thread is None
    level = drills or (mills and shape.bottom in ("", "flat", "through"))
    if not level or _allowances(job) or shape.slope != 0 or job.value("cutting_depth", 0.0) != 0:
        return whole
    reached = min(job.radius, radius) if drills else radius - job.tool.edge
    circle = offsets.polygon_of([profile_shapes.circle(2 * reached)])
    return replace(whole, demands=circle.buffer(-NEAR_WALL), demanded=shape.depth or 0.0)


def _around(job: Job, frame: Matrix, over: float) -> Cavity:
    """Return all that is outside of a profile or boss."""
    import shapely

    from cncgen.stepnc.features.profile import _outline

    inner = offsets.polygon_of(_outline(job))
    region = shapely.box(-BEYOND, -BEYOND, BEYOND, BEYOND)
    boss = ((inner, job.shape.slope, 0.0),)
    return Cavity(frame, region, (job.shape.depth or 0.0) + over, 0.0, boss)


def _slot(job: Job, over: float) -> tuple[Job, list[Piece] | None]:
    """Return a slot as a pocket, as far as a round tool goes to clear it, its radius beyond the ends; and its own outline."""
    course, width = slot._course(job)
    ends = tuple("radiused" if end not in ("open", "flat") else end for end in (*job.shape.ends, "", "")[:2])
    shape = replace(job.shape, ends=ends)

    def pocket(beyond: float) -> Job:
        values = {**job.operation.values, "overcut_length": beyond}
        longer = replace(job, shape=shape, operation=replace(job.operation, values=values))
        return slot._as_pocket(longer, course, width)

    return pocket(over + job.radius), pocket(1e-3 - job.radius).shape.outline


def _area(job: Job, kind: str, frame: Matrix, over: float) -> Cavity:
    """Return a pocket, slot, step or face, grown over its open sides."""
    shape, through = job.shape, job.shape.bottom == "through"
    own = None
    if kind == "slot":
        job, own = _slot(job, over)
    elif kind == "step":
        job = slot._step_as_pocket(job)
    outline = job.shape.outline
    if outline is None:
        raise Skip
    closed = offsets.polygon_of(outline)
    if job.shape.corner_radius and not job.shape.open_sides and kind == "closed pocket":
        corner = job.shape.corner_radius
        rounded = closed.buffer(-corner, quad_segs=64).buffer(corner, quad_segs=64)
        closed = closed if rounded.is_empty else rounded.buffer(1e-3)
    region = closed
    if kind == "planar face":
        region = closed.buffer(BEYOND, quad_segs=2)
    elif job.shape.open_sides:
        region = offsets.grown_over(closed, [outline[k] for k in job.shape.open_sides], BEYOND)
    bosses = tuple((offsets.polygon_of(b.outline), b.slope, b.top) for b in job.shape.bosses)
    depth = (shape.depth or 0.0) + (over if through else 0.0)
    fillet = (shape.floor_radius or 0.0) if not through else 0.0
    made = Cavity(frame, region, depth, job.shape.slope, bosses, fillet)
    plain = job.shape.slope == 0 and not any(b.slope for b in job.shape.bosses)
    cuts_floor = not job.operation.kind.startswith("side")
    if not plain or not cuts_floor or _allowances(job) or job.tool.tip_angle:
        return made
    free, reach = closed, region
    for polygon, _, _ in bosses:
        free, reach = free.difference(polygon), reach.difference(polygon)
    # The level end of a round tool reaches the opening of where its axis may be: beside a fillet that keeps away from the wall.
    level = job.radius - job.tool.edge - 1e-3
    away = level + max(fillet, job.tool.edge)
    reached = reach.buffer(-away, quad_segs=64).buffer(max(level, 0.0), quad_segs=64)
    if own is not None:  # the slot ends at its open end
        free = free.intersection(offsets.polygon_of(own))
    demands = reached.intersection(free).buffer(-NEAR_WALL, quad_segs=2)
    return replace(made, demands=demands, demanded=shape.depth or 0.0)


def _allowances(job: Job) -> bool:
    return job.value("allowance_side", 0.0) > 0 or job.value("allowance_bottom", 0.0) > 0
