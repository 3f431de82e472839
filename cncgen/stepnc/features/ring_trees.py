"""Nested rings of a region from inside out; a tool that follows them leaves no material between them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.features.job import Floats
from cncgen.stepnc.features.offsets import (
    MAX_RINGS,
    OffsetError,
    distance_to,
    grown,
    holds_circle,
    inradius,
    point_of,
    polygons,
)
from cncgen.stepnc.features.outlines import QUARTER

if TYPE_CHECKING:
    from shapely import Polygon

#: Largest radius of a circle that no cut needs to reach, by the reach of the tool.
UNCUT = 1e-3


@dataclass(slots=True)
class Ring:
    """A node of the tree of offsets: a polygon, its boundary curves, and what lies inside it.

    Attributes:
        polygon: Where it leads.
        inset: How far inside the outermost ring it lies, mm.
        children: Further in.
        core: Of a leaf: the line (2, 3) or point (1, 3) that its middle shrinks to.
        missed: Places inside it, shape (3,), beside which neither it nor a ring farther in cuts: the tool goes there
            and back.
    """

    polygon: Polygon
    inset: float = 0.0
    children: list[Ring] = field(default_factory=list)
    core: Floats | None = None
    missed: list[Floats] = field(default_factory=list)


def nested(shrink: Callable[[float], list[Polygon]], step: float, reach: float) -> list[Ring]:
    """Return the trees of offsets of a region, the outermost rings as roots.

    The distance between rings is the step or less, so that a whole number of them leads to the middle. That leaves
    nothing between straight sides a step apart; in corners rings are farther from each other, and the middle of a leaf
    need not be a line or point that one more cut goes along. A place there beyond `reach` of all cuts gets another
    ring, or is noted as `missed`. With a step wider than two reaches it is meant to stay.

    Args:
        shrink: Function from the distance inwards of the outermost ring (mm) to the polygons there.
        step: Largest distance between rings, mm.
        reach: How far from its axis the tool cuts, mm.
    """
    roots = [Ring(p) for p in shrink(0.0)]
    if not roots:
        return []
    deepest = max(inradius(r.polygon)[0] for r in roots)
    count = max(1, math.ceil(deepest / step - 1e-6))
    if count > MAX_RINGS:
        raise OffsetError(f"passes {step:g} mm apart make {count} rings; at most {MAX_RINGS} are made")
    outer = roots
    for k in range(1, count):
        inner = [Ring(p, k * deepest / count) for p in shrink(k * deepest / count)]
        for ring in inner:
            point = ring.polygon.representative_point()
            parent = next((o for o in outer if o.polygon.covers(point)), outer[0])
            parent.children.append(ring)
        outer = inner
    for root in roots:
        _add_cores(root)
        if step <= 2 * reach + 1e-9:
            for leaf in [r for r in rings_of(root) if not r.children]:
                _fill(leaf, shrink, reach)
            _note_missed(root, reach)
    return roots


def rings_of(root: Ring) -> list[Ring]:
    """Return a ring and all within it."""
    out = [root]
    for ring in out:
        out.extend(ring.children)
    return out


def _add_cores(root: Ring) -> None:
    """Give every leaf the line or point that its middle shrinks to."""
    for ring in rings_of(root):
        if not ring.children:
            ring.core = _core(ring.polygon)


def _beyond(rings: Sequence[Ring], polygon: Polygon, reach: float) -> list[Polygon]:
    """Return the parts of a polygon that the tool does not cut on its way along rings and their cores."""
    from shapely import LineString, Point, union_all

    lines = [r.polygon.boundary for r in rings]
    lines += [
        LineString(r.core) if len(r.core) > 1 else Point(r.core[0]) for r in rings if r.core is not None
    ]
    cut = union_all([grown(line, reach, quad_segs=QUARTER) for line in lines])
    # Polygons that stand for circles reach less far by the height of their chords.
    return [p for p in polygons(polygon.difference(cut)) if holds_circle(p, UNCUT * reach)]


def _fill(leaf: Ring, shrink: Callable[[float], list[Polygon]], reach: float) -> None:
    """Give a leaf rings half way to its middle where its core leaves material there."""
    if not _beyond([leaf], leaf.polygon, reach):
        return
    inset = leaf.inset + inradius(leaf.polygon)[0] / 2
    leaf.children = [Ring(p, inset) for p in shrink(inset) if leaf.polygon.covers(p.representative_point())]
    if leaf.children:
        leaf.core = None
        _add_cores(leaf)


def _note_missed(root: Ring, reach: float) -> None:
    """Note the places between rings that none of them reaches, each with the innermost ring round it."""
    rings = rings_of(root)
    for part in _beyond(rings, root.polygon, reach):
        left = [part]
        while left:
            _, (x, y) = inradius(left[0])
            place = np.array([x, y, 0.0])
            around = max((r for r in rings if distance_to(r.polygon, place) == 0.0), key=lambda r: r.inset)
            around.missed.append(place)
            rest = left.pop(0).difference(grown(point_of(place), reach, quad_segs=QUARTER))
            left += [p for p in polygons(rest) if holds_circle(p, UNCUT * reach)]


def _core(polygon: Polygon) -> Floats | None:
    """Return the line between the middles of a long polygon's ends, else the centre of its largest circle.

    A rectangle shrunk by all but e of its inradius is 2 e wide, and e longer at each end than what it shrinks to.
    """
    radius, centre = inradius(polygon)
    if radius < 1e-3:
        return None
    left = 0.05 * radius
    thin = polygons(grown(polygon, -(radius - left), quad_segs=QUARTER, join_style="mitre"))
    if len(thin) == 1:
        box = np.array(thin[0].minimum_rotated_rectangle.exterior.coords)[:-1]
        sides = np.linalg.norm(np.roll(box, -1, axis=0) - box, axis=1)
        k = int(np.argmin(sides[:2]))
        length = float(sides[1 - k]) - 2 * left
        if abs(sides[k] - 2 * left) < 1e-3 * left and length > 1e-3:
            ends = np.stack([(box[k] + box[(k + 1) % 4]) / 2, (box[(k + 2) % 4] + box[(k + 3) % 4]) / 2])
            inward = (ends[1] - ends[0]) / elementary.length(ends[1] - ends[0]) * left
            ends = ends + np.stack([inward, -inward])
            ends = ends[np.lexsort(np.round(ends.T[::-1], 6))]
            return np.column_stack([ends, np.zeros(2)])
    return np.array([[centre[0], centre[1], 0.0]])
