"""How far from an outline the axis of the tool stays: walls with a draft, tools with rounded edges, low bosses.

A wall leans by its draft φ from the vertical, away from the material that is removed at the top. The outline is the
wall's at its top. A tool of radius R whose edge is rounded by r touches the wall with the rounding's circle, at
r (1 - sin φ) above its tip; with the tip at depth d its axis is then

    R - r + r / cos φ + (d - r) tan φ

from the outline. Cut level by level, such a wall keeps steps whose height is the depth of a pass and whose width is
that times tan φ: the tool leaves material there, and never cuts into the wall.
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
    stops = [top + bottom for _, _, top in bosses] + [-d for d in (narrows.stops() if narrows else ())]
    levels = job.levels(total, stops)
    out: list[Layer] = []
    for above, level in pairwise([0.0, *levels]):
        standing = tuple(
            (polygon, axis_distance(job, slope, top - level) + side)
            for polygon, slope, top in bosses
            if level < top + bottom - 1e-9
        )
        wall = axis_distance(job, job.shape.slope, -level) + side
        if narrows is not None and -level > narrows.begins:
            wall = max(wall, (job.shape.diameter or 0.0) / 2 - narrows.reach(-level))
        last = out[-1] if out else None
        if last is not None and (last.wall, last.bosses) == (wall, standing):
            out[-1] = Layer((*last.spans, (above, level)), wall, standing)
        else:
            out.append(Layer(((above, level),), wall, standing))
    return out
