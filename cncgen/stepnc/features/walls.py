"""The distance of the tool's axis from an outline: walls with a draft, tools with rounded edges, low bosses.

A wall leans by its draft φ from the vertical, away from the material that is removed at the top. The outline is the
wall's at its top. A tool of radius R whose edge is rounded by r touches the wall with the rounding's circle, at
r (1 - sin φ) above its tip; with the tip at depth d its axis is then

    R - r + r / cos φ + (d - r) tan φ

from the outline. Cut level by level, such a wall keeps steps whose height is the depth of a pass and whose width is
that times tan φ: the tool leaves material there, and never cuts into the wall.

A fillet of radius f between wall and floor is touched by the rounding from within: the centres of both are f - r apart.
With the tip h above the floor, the axis is then

    R - r + c - sqrt((f - r)² - (f - r - h)²)

from the outline, c the distance of the fillet's centre from it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

from cncgen.stepnc.features import offsets
from cncgen.stepnc.features.bottoms import bottom_of
from cncgen.stepnc.features.job import MAX_SLOPE, Job

if TYPE_CHECKING:
    from shapely import Polygon

#: Narrower steps on leaning walls are not told, mm.
STEP = 0.1
#: Passes that finish a fillet between wall and floor with a tool whose own edge is less round.
FILLET_PASSES = 8


def axis_distance(job: Job, slope: float, depth: float) -> float:
    """Return how far from a wall's outline the tool's axis is with the tip `depth` mm below the outline.

    Raises:
        Skip: where the wall overhangs or is next to level.
    """
    radius = job.radius
    if abs(slope) < 1e-9:
        return radius
    if not 0 < slope < MAX_SLOPE:
        text = f"a wall at {math.degrees(slope):g} degrees from the vertical cannot be cut from above"
        raise job.fault("stepnc-geometry", text)
    edge = job.tool.edge
    return radius - edge + edge / math.cos(slope) + (depth - edge) * math.tan(slope)


def drawn_in(job: Job, depth: float) -> float:
    """Return how much farther from the outline the tool stays at a depth than at the top: leaning walls, fillets, mm."""
    return depth * math.tan(job.shape.slope) + max((job.shape.floor_radius or 0.0) - job.tool.edge, 0.0)


def fillet_distance(job: Job, slope: float, height: float, above: float) -> float:
    """Return how far from a wall's outline the tool's axis is beside the fillet at its foot; 0 if irrelevant.

    Args:
        job: The feature.
        slope: Draft of the wall, rad.
        height: Of the wall, mm.
        above: How far the tip is above the floor, mm.
    """
    floor, edge = job.shape.floor_radius, job.tool.edge
    if floor is None or job.shape.bottom == "through" or edge > floor - 1e-9:
        return 0.0
    below = floor - edge - above
    if below <= (floor - edge) * math.sin(slope):
        return 0.0
    centre = height * math.tan(slope) + floor * (1 - math.sin(slope)) / math.cos(slope)
    return job.radius - edge + centre - math.sqrt(max((floor - edge) ** 2 - below**2, 0.0))


@dataclass(frozen=True, slots=True)
class Layer:
    """Passes that have the same region: from height to height, with the insets of the outline and of the bosses.

    Attributes:
        spans: Heights above (where the last pass was) and of each pass, mm.
        wall: How far inside the outline the tool's axis stays, mm.
        bosses: Polygons that stand in the way, each with how far outside of it the axis stays, mm.
    """

    spans: tuple[tuple[float, float], ...]
    wall: float
    bosses: tuple[tuple[Polygon, float], ...]

    def moved(self, outwards: float) -> Layer:
        """Return the layer of a tool whose axis stays farther from the material by so much (negative: nearer), mm."""
        bosses = tuple((polygon, distance + outwards) for polygon, distance in self.bosses)
        return replace(self, wall=self.wall + outwards, bosses=bosses)

    def region(self, outline: Polygon, corner_radius: float, further: float) -> list[Polygon]:
        """Return where the tool's axis may go, less a margin of `further` mm, as shapely polygons."""
        inner = self.moved(further)
        return offsets.region(outline, inner.bosses, inner.wall, corner_radius)


def layers(job: Job, total: float) -> list[Layer]:
    """Return the passes of a feature down to `total` mm, those together that have the same region.

    Bosses lower than the feature's top stand in the way below their tops alone, where a pass ends (the allowance of
    the bottom stays on them as well). Round bottoms narrow the way.

    Raises:
        Skip: where a wall cannot be cut or nothing is left.
    """
    side, bottom = job.value("allowance_side", 0.0), job.value("allowance_bottom", 0.0)
    bosses = [(offsets.polygon_of(b.outline), b.slope, b.top) for b in job.shape.bosses]
    narrows = bottom_of(job)
    fillet = job.shape.floor_radius if narrows is None else None
    stops = [top + bottom for _, _, top in bosses] + [-d for d in (narrows.stops() if narrows else ())]
    if fillet is not None and fillet > job.tool.edge and job.operation.kind.endswith("finish"):
        rise = fillet - job.tool.edge
        stops += [rise * k / FILLET_PASSES - total for k in range(1, FILLET_PASSES) if rise < total]
    levels = job.levels(total, stops)
    out: list[Layer] = []
    _tell_steps(job, [0.0, *levels])

    def distance(slope: float, top: float, level: float) -> float:
        beside = axis_distance(job, slope, top - level)
        if fillet is not None:
            beside = max(beside, fillet_distance(job, slope, top + job.depth, job.depth + level - bottom))
        return beside + side

    for above, level in pairwise([0.0, *levels]):
        standing = tuple(
            (polygon, distance(slope, top, level))
            for polygon, slope, top in bosses
            if level < top + bottom - 1e-9
        )
        wall = distance(job.shape.slope, 0.0, level)
        if narrows is not None and -level > narrows.begins:
            wall = max(wall, (job.shape.diameter or 0.0) / 2 - narrows.reach(-level))
        last = out[-1] if out else None
        if last is not None and (last.wall, last.bosses) == (wall, standing):
            out[-1] = Layer((*last.spans, (above, level)), wall, standing)
        else:
            out.append(Layer(((above, level),), wall, standing))
    return out


def _tell_steps(job: Job, levels: list[float]) -> None:
    """Warn of the steps that passes at these heights leave beside leaning walls, where no allowance says that more is to come."""
    height = max(above - level for above, level in pairwise(levels))
    width = height * math.tan(job.shape.slope)
    if width > STEP and not job.value("allowance_side", 0.0):
        text = f"passes {height:g} mm deep leave steps {width:.2g} mm wide on walls that lean by {math.degrees(job.shape.slope):g} degrees"
        job.warn("stepnc-uncut", f"{text}; axial_cutting_depth makes them smaller")
