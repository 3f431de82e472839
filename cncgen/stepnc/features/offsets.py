"""Offsets of outlines by shapely, and what lies inside or outside of what.

`outlines` puts arcs back where polygons had to stand for them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.features.job import Floats
from cncgen.stepnc.features.outlines import QUARTER, refit
from cncgen.stepnc.geometry.chords import polyline_of
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline

if TYPE_CHECKING:
    from shapely import LineString, Polygon
    from shapely.geometry.base import BaseGeometry

#: Distance of the polygons that stand for arcs from them, mm.
CHORD = 2e-5
#: Distance of points along edges that are offset, mm, and how many of them an outline gets.
SPACING = 0.2
MAX_POINTS = 20_000
#: Offsets below this are margins, mm: they are not checked.
SMALL_OFFSET = 0.01
#: Tolerance of the largest inscribed circle, mm.
CENTRE = 1e-6
#: Rings from a wall to the middle, and lines across a pocket.
MAX_RINGS = 2000
#: The largest coordinates of outlines, and the farthest that they are offset, mm.
MAX_OFFSET = 1e5


class OffsetError(ValueError):
    """Passes so close that there are too many of them, or an offset by no distance."""


def grown(geometry: BaseGeometry, distance: float, **how: str | float) -> BaseGeometry:
    """Return a shapely geometry grown by a distance, mm (negative: shrunk); `how` as shapely's `buffer` takes it.

    GEOS loses parts of its results from arcs of fine chords beside long edges: of one in seven circular slots, shrunk,
    an end was missing. So each result is checked, and where it is wrong made from points closer to each other along the
    edges, or from coarser chords.

    Raises:
        OffsetError: where the distance is larger than any part, or no parallel outline results.
    """
    if not abs(distance) <= MAX_OFFSET:
        raise OffsetError(f"an offset of {distance:g} mm is beyond ±{MAX_OFFSET:g} mm")
    out = geometry.buffer(distance, **how)
    simple = "join_style" in how or geometry.geom_type not in ("Polygon", "MultiPolygon")
    if simple or abs(distance) < SMALL_OFFSET or _is_parallel(out, geometry, abs(distance)):
        return out
    spacing = max(SPACING, geometry.length / MAX_POINTS)
    for coarse in (0.0, 5 * CHORD, 20 * CHORD):
        dense = (geometry.simplify(coarse) if coarse else geometry).segmentize(spacing)
        # From its lowest point on, a ring has no needless vertex where it begins.
        out = dense.buffer(distance, **how).normalize().simplify(1e-7)
        if _is_parallel(out, geometry, abs(distance)):
            return out
    raise OffsetError(f"no outline {distance:g} mm beside the given one can be made")


def _is_parallel(parallel: BaseGeometry, geometry: BaseGeometry, distance: float) -> bool:
    """Tell whether the boundary of one geometry is a distance from that of another everywhere."""
    from shapely import dwithin, get_coordinates, points, prepare

    if parallel.is_empty:
        return True
    fine = 1e-3
    spacing = max(distance / 4, parallel.length / MAX_POINTS, SPACING)
    places = points(get_coordinates(parallel.boundary.simplify(fine).segmentize(spacing)))
    boundary = geometry.boundary.simplify(fine)
    prepare(boundary)
    allowed = 3 * fine + 3e-4 * distance
    near, far = dwithin(boundary, places, distance - allowed), dwithin(boundary, places, distance + allowed)
    return bool(far.all()) and not bool(near.any())


def _chords_of(piece: Piece) -> Floats:
    """Return the points of a piece's chords, shape (n, 3); arcs beyond metres of radius get no more of them."""
    radius = float(elementary.length(piece.start - piece.centre)) if isinstance(piece, Arc) else 0.0
    return polyline_of(piece, max(CHORD, 1e-6 * radius)).points


def bounds_along(pieces: list[Piece], direction: Floats) -> tuple[float, float]:
    """Return the lowest and highest coordinate of pieces along a unit vector, mm."""
    points = np.concatenate([_chords_of(p) for p in pieces])
    along = elementary.product(points, direction)
    return float(along.min()), float(along.max())


def polygon_of(pieces: list[Piece]) -> Any:
    """Return the shapely polygon of a closed outline (arcs and splines as chords).

    Raises:
        OffsetError: where it is larger than any part, or crosses itself.
    """
    from shapely import Polygon, make_valid

    points = np.concatenate([_chords_of(p)[:, :2] for p in pieces])
    if not np.abs(points).max() <= MAX_OFFSET:
        raise OffsetError(f"the outline has coordinates beyond ±{MAX_OFFSET:g} mm")
    polygon = Polygon(points)
    if polygon.is_valid:
        return polygon
    mended = make_valid(polygon).buffer(0)
    x, y = (points - points[0]).T
    round_it = abs(0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
    if abs(mended.area - round_it) > 1e-6 * mended.area + 1e-3:
        text = f"the outline crosses itself: it goes round {round_it:.6g} mm², and holds {mended.area:.6g}"
        raise OffsetError(text)
    return mended


def region(
    outline: Polygon, bosses: Sequence[tuple[Polygon, float]], distance: float, corner_radius: float = 0.0
) -> list[Polygon]:
    """Return where the tool's centre may go: the outline shrunk by a distance, bosses grown, as polygons.

    Args:
        outline: shapely polygon.
        bosses: shapely polygons, each with the distance that it grows by, mm.
        distance: mm; negative grows.
        corner_radius: Of the outline's convex corners before it is shrunk, mm.
    """
    inside = grown(outline, -distance, quad_segs=QUARTER)
    left = corner_radius - distance
    if left > 1e-9:
        inside = grown(inside, -left, quad_segs=QUARTER, join_style="mitre", mitre_limit=10.0)
        inside = grown(inside, left, quad_segs=QUARTER)
    for boss, margin in bosses:
        inside = inside.difference(grown(boss, margin, quad_segs=QUARTER))
    return polygons(inside)


def not_swept(regions: Sequence[Polygon], axis: Sequence[Polygon], reach: float) -> list[Polygon]:
    """Return the polygons of regions that a tool leaves whose axis goes everywhere in other polygons."""
    cut = swept(axis, reach)
    return [p for region in regions for p in polygons(region.difference(cut))]


def swept(axis: Sequence[Polygon], reach: float) -> BaseGeometry:
    """Return what a tool cuts whose axis goes everywhere in polygons."""
    from shapely import union_all

    return union_all([grown(p, reach + CHORD, quad_segs=QUARTER) for p in axis])


def filled(
    axis: Sequence[Polygon], walls: Sequence[BaseGeometry], radius: float
) -> tuple[list[Polygon], BaseGeometry]:
    """Return the parts of the walls' notches that a tool of a radius does not reach, and a ring of the reached part.

    The boundary of the tool's way, shrunk by the radius again, has the notches filled (a closing of the walls).
    """
    from shapely import union_all

    closed = union_all([grown(p, -radius + CHORD, quad_segs=QUARTER) for p in axis])
    return polygons(closed.difference(union_all(list(walls)))), closed.buffer(2 * radius).difference(closed)


def notches(places: Sequence[Polygon], reached: BaseGeometry, radius: float) -> list[Polygon]:
    """Return the places that a tool of a radius leaves, mm, which are more than the corners that it rounds.

    Material left in a corner comes to a point: less than a third of it is farther from the tool than half of its depth. A
    notch with walls side by side has about half of itself there. A place that holds a circle of half the radius is always
    reported. `reached` is what the tool cuts, near the places at least.
    """
    from shapely import box, distance, get_coordinates, points, prepare

    corners, owners = get_coordinates(places, return_index=True)
    prepare(reached)
    depths = np.zeros(len(places))
    np.maximum.at(depths, owners, distance(reached, points(corners)))

    def is_notch(place: Polygon, depth: float) -> bool:
        if holds_circle(place, radius / 2):
            return True
        if depth <= 0.1 * radius:
            return False
        about = reached.intersection(box(*place.buffer(depth).bounds))
        return bool(place.difference(about.buffer(depth / 2)).area > place.area / 3)

    return [place for place, depth in zip(places, depths.tolist(), strict=True) if is_notch(place, depth)]


def polygons(geometry: BaseGeometry) -> list[Polygon]:
    """Return the polygons of a geometry, slivers left out."""
    parts = getattr(geometry, "geoms", [geometry])
    return [p for p in parts if p.geom_type == "Polygon" and p.area > 1e-8]


def holds_circle(polygon: Polygon, radius: float) -> bool:
    """Tell whether a circle of a radius, mm, fits into a polygon (sooner known than the largest that does)."""
    return bool(polygon.area > math.pi * radius**2) and not polygon.buffer(-radius).is_empty


def inradius(polygon: Polygon) -> tuple[float, Floats]:
    """Return radius and centre, shape (2,), of the largest circle inside a polygon, mm."""
    from shapely import maximum_inscribed_circle

    line = np.array(maximum_inscribed_circle(polygon, tolerance=CENTRE).coords)
    return float(elementary.length(line[1] - line[0])), line[0]


def boundary_curves(polygon: Polygon, clockwise: bool) -> list[list[Piece]]:
    """Return the boundaries of a polygon as closed curves, the outer one first: with the clock, holes against it."""
    from shapely.geometry.polygon import orient

    turned = orient(polygon, sign=-1.0 if clockwise else 1.0)
    return [refit(np.array(ring.coords)) for ring in (turned.exterior, *turned.interiors)]


def lag(inner: Polygon, outer: Polygon) -> float:
    """Return how far the farthest point of an outer ring is from the inner one, mm."""
    from shapely import distance, points

    return float(distance(inner.exterior, points(np.array(outer.exterior.coords))).max())


def spiral_turn(inner: Polygon, outer: list[Piece], start: Floats, count: int) -> Piece:
    """Return one turn of a spiral from a ring to the next one out, ending where the outer ring begins.

    Every point of the turn lies on the way from a point of the outer ring to the nearest one of the inner ring, farther
    out by the share of the turn that is done. So the turns stay as far from each other as the rings.

    Args:
        inner: shapely polygon of the inner ring.
        outer: The closed outer ring, beginning where it is nearest to `start`.
        start: Shape (3,), on the inner ring, where the turn begins.
        count: How many pieces the turn has at least.
    """
    from shapely import line_interpolate_point, line_locate_point, points

    line = np.concatenate([polyline_of(p, 1e-3).points for p in outer])[:, :2]
    line = line[np.concatenate([[True], np.abs(np.diff(line, axis=0)).max(axis=1) > 1e-9])]
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    even = np.unique(np.concatenate([s, np.linspace(0.0, s[-1], count + 1)]))
    far = np.column_stack([np.interp(even, s, line[:, k]) for k in (0, 1)])
    ring = inner.exterior
    near = line_interpolate_point(ring, line_locate_point(ring, points(far)))
    close = np.array([(p.x, p.y) for p in near])
    turn = close + (even / s[-1])[:, None] * (far - close)
    turn[0] = start[:2]
    return Polyline(np.column_stack([turn, np.zeros(len(turn))]))


def line_inside(polygon: Polygon, a: Floats, b: Floats) -> bool:
    """Tell whether the straight line between two points stays within a polygon (within 1e-4 mm)."""
    from shapely import LineString

    return bool(grown(polygon, 1e-4).covers(LineString([a[:2], b[:2]])))


def piece_inside(polygon: Polygon, piece: Piece, outside: bool) -> bool:
    """Tell whether a piece stays within a polygon, or outside of it, by 1e-3 mm."""
    from shapely import LineString

    line = LineString(_chords_of(piece)[:, :2])
    return not line.intersects(grown(polygon, -1e-3)) if outside else bool(grown(polygon, 1e-3).covers(line))


def clearance(polygon: Polygon, point: Floats) -> float:
    """Return how far a point within a polygon is from its boundary, mm; 0 outside."""
    place = point_of(point)
    return float(polygon.boundary.distance(place)) if polygon.covers(place) else 0.0


def distance_to(polygon: Polygon, point: Floats) -> float:
    """Return how far a point is from a polygon, mm; 0 inside."""
    return float(polygon.distance(point_of(point)))


def point_of(point: Floats) -> Any:
    from shapely import Point

    return Point(point[0], point[1])


def farthest(outline: list[Piece], around: list[Piece]) -> float:
    """Return how far the farthest point of a second outline lies outside the first one, mm."""
    from shapely import Point

    inner, outer = polygon_of(outline), polygon_of(around)
    return max(inner.distance(Point(x, y)) for x, y in np.array(outer.exterior.coords))


def chords(polygon: Polygon, along: Floats, across: Floats, step: float) -> list[list[tuple[Floats, Floats]]]:
    """Return the lines of a zigzag within a polygon: row by row, each row its stretches along the direction, at Z 0."""
    from shapely import LineString

    points = np.array(polygon.exterior.coords)
    low, high = elementary.product(points, along[:2]), elementary.product(points, across[:2])
    count = max(1, math.ceil((high.max() - high.min()) / step - 1e-9))
    if count > 10 * MAX_RINGS:
        raise OffsetError(f"passes {step:g} mm apart make {count} lines; at most {10 * MAX_RINGS} are made")
    rows = []
    for k in range(count + 1):
        at = high.min() + (high.max() - high.min()) * k / count
        at = min(max(at, high.min() + 1e-6), high.max() - 1e-6)
        ends = [s * along[:2] + at * across[:2] for s in (low.min() - 1.0, low.max() + 1.0)]
        cut = polygon.intersection(LineString(ends))
        parts = [np.array(g.coords) for g in getattr(cut, "geoms", [cut]) if g.geom_type == "LineString"]
        stretches = [np.column_stack([c, np.zeros(len(c))]) for c in parts if len(c) > 1]
        stretches.sort(key=lambda c: float(elementary.product(c[0], along)))
        rows.append([(c[0], c[-1]) for c in stretches if elementary.length(c[-1] - c[0]) > 1e-6])
    return [r for r in rows if r]


def grown_over(polygon: Polygon, sides: list[Piece], reach: float) -> Any:
    """Return a polygon with what lies within `reach` mm beyond its open sides added, square to them."""
    from shapely import LineString, unary_union

    chains = _chains([_chords_of(p)[:, :2] for p in sides])
    if len(chains) == 1 and np.abs(chains[0][0] - chains[0][-1]).max() < 1e-9:
        return grown(polygon, reach, quad_segs=QUARTER, join_style="mitre")
    beyond = [part for c in chains for part in _beside(polygon, LineString(c), reach)]
    return unary_union([polygon, *(grown(part, 1e-7) for part in beyond)]).buffer(-1e-7)


def _beside(polygon: Polygon, side: LineString, reach: float) -> list[Polygon]:
    """Return what lies within `reach` mm of a side of a polygon, outside of it and reached over that side.

    A strip as wide goes through a narrow polygon and comes out behind its other side: there it does not count.
    """
    strip = grown(side, reach, cap_style="flat", join_style="mitre")
    parts = polygons(strip.difference(polygon))
    return [p for p in parts if grown(p, 1e-6).intersection(side).length > 1e-5]


def _chains(lines: list[Floats]) -> list[Floats]:
    """Return lines, each shape (n, 2), that begin where the one before ends (the first: the last) as one."""
    out: list[Floats] = []
    for line in lines:
        if out and np.abs(out[-1][-1] - line[0]).max() < 1e-9:
            out[-1] = np.concatenate([out[-1], line[1:]])
        else:
            out.append(line)
    if len(out) > 1 and np.abs(out[-1][-1] - out[0][0]).max() < 1e-9:
        last = out.pop()
        out[0] = np.concatenate([last, out[0][1:]])
    return out


def within_stock(corners: Floats, stock: list[Piece] | None) -> tuple[list[Piece], list[int]]:
    """Return the part of a polygon that lies in the raw piece, its sides one by one, and which of them are walls.

    A side is a wall where it lies within the raw piece; without one the first side alone is.

    Args:
        corners: Shape (n, 3), the first again at the end, mm.
        stock: Outline of the raw piece, or None.
    """
    from shapely import Point, Polygon

    if stock is None:
        return [Polyline(corners[k : k + 2]) for k in range(len(corners) - 1)], [0]
    raw = polygon_of(stock)
    parts = polygons(Polygon(corners[:, :2]).intersection(raw))
    ring = np.array(parts[0].exterior.coords) if parts else corners[:, :2]
    sides: list[Piece] = [
        Polyline(np.column_stack([ring[k : k + 2], np.zeros(2)])) for k in range(len(ring) - 1)
    ]
    middles = [Point((s.start + s.end)[:2] / 2) for s in sides]
    return sides, [k for k, m in enumerate(middles) if raw.covers(m) and raw.exterior.distance(m) > 1e-6]


def strip(path: list[Piece], half: float, rounded: tuple[bool, ...]) -> list[list[Piece]]:
    """Return the outlines of the region within `half` mm of a path, the outer one first; ends rounded or square.

    Nothing where that is not in one piece: no path is so wide.
    """
    from shapely import LineString, Point

    points = np.concatenate([_chords_of(p)[:, :2] for p in path])
    closed = np.abs(points[0] - points[-1]).max() < 1e-6
    line = LineString(points)
    body = grown(line, half, quad_segs=QUARTER, cap_style="round" if closed else "flat")
    for end, round_it in zip((points[0], points[-1]), rounded, strict=False):
        if round_it:
            body = body.union(grown(Point(end), half, quad_segs=QUARTER))
    parts = polygons(body)
    return boundary_curves(parts[0], clockwise=False) if len(parts) == 1 else []
