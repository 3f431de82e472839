"""Clearing pockets of any closed contours, with islands: rows of a flat cutter, then a pass beside each wall.

A row's tool may stand where it is inside the contours and no nearer to any of them than its radius. The ends of this range on a row
have a closed form, from the lines and circles at that distance. Rows and the ways between them are our own choice; walls, levels and
feeds are those of the cycle.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from itertools import pairwise

from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.pockets import Clearing
from cncgen.gcode.codes.steps import steps_of
from cncgen.gcode.codes.turning_profiles import Segment, backwards, moved_aside
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter

_TINY = 1e-9
#: Ends of a contour farther apart than this leave it open, mm.
_CLOSED = 0.01
#: How far a chord may be from its arc where walls are compared, mm.
_CHORD = 1e-3

Contour = Sequence[Segment]
#: Contours, and whether each is an island.
Nested = Sequence[tuple[Contour, bool]]
Row = tuple[float, list[tuple[float, float]]]


def closed(contour: Contour, name: str) -> list[Segment]:
    """Return a contour that leads back to its start; raise where it is open, or has no area."""
    if not contour or abs(contour[-1].end - contour[0].start) > _CLOSED or abs(area(contour)) < _TINY:
        hint = "its last move leads back to its start"
        raise BlockError("profile-length", f"a contour of {name} is not closed", name, hint=hint)
    return list(contour)


def _polygon(contour: Contour, sagitta: float) -> list[complex]:
    """Return points of a contour, its arcs cut into chords."""
    points = []
    for s in contour:
        points.append(s.start)
        if s.centre is not None:
            part = max(0.01, 2.0 * math.acos(max(0.0, 1.0 - sagitta / s.radius())))
            count = math.ceil(s.sweep() / part)
            points += [
                s.centre + (s.start - s.centre) * cmath.rect(1.0, s.spin * s.sweep() * k / count)
                for k in range(1, count)
            ]
    return points


def area(contour: Contour) -> float:
    """Return the area of a contour, above 0 where it goes counter-clockwise."""
    points = _polygon(contour, _CHORD)
    return sum((a.conjugate() * b).imag for a, b in pairwise([*points, points[0]])) / 2.0


def _distance(segment: Segment, p: complex) -> float:
    if segment.centre is None:
        along = segment.end - segment.start
        part = min(1.0, max(0.0, ((p - segment.start) * along.conjugate()).real / abs(along) ** 2))
        return abs(p - segment.start - part * along)
    if p != segment.centre and segment.holds(p):
        return abs(abs(p - segment.centre) - segment.radius())
    return min(abs(p - segment.start), abs(p - segment.end))


def _inside(polygons: Sequence[Sequence[complex]], p: complex) -> bool:
    """Tell whether a point lies within an odd number of polygons."""
    odd = False
    for points in polygons:
        for a, b in pairwise([*points, points[0]]):
            if (a.imag > p.imag) != (b.imag > p.imag):
                odd ^= p.real < a.real + (p.imag - a.imag) / (b.imag - a.imag) * (b.real - a.real)
    return odd


def _marks(segment: Segment, radius: float, y: float) -> list[float]:
    """Return where a row meets the lines and circles at a distance from a segment."""
    circles = [(segment.start, radius), (segment.end, radius)]
    found = []
    if segment.centre is None:
        way = segment.heading(segment.start)
        if abs(way.imag) > _TINY:
            for side in (1j, -1j):
                at = segment.start + side * radius * way
                found.append(at.real + (y - at.imag) / way.imag * way.real)
    else:
        circles += [
            (segment.centre, abs(segment.radius() + radius)),
            (segment.centre, abs(segment.radius() - radius)),
        ]
    for centre, reach in circles:
        half = reach**2 - (y - centre.imag) ** 2
        if half >= 0.0:
            found += [centre.real - math.sqrt(half), centre.real + math.sqrt(half)]
    return found


def rows(contours: Sequence[Contour], radius: float, step: float, name: str) -> list[Row]:
    """Return the rows, from below: Y, and where on it the tool may stand, from the lowest place where it may; raise where there are too many."""
    segments = [s for contour in contours for s in contour]
    polygons = [_polygon(contour, radius / 4.0) for contour in contours]
    heights = [p.imag for s in segments for p in s.extremes()]
    low, high = min(heights) + radius, max(heights) - radius
    makes, hint = f"{name} makes {{}} rows", "is the step aside too small?"
    count = steps_of(high - low, step, name, makes, hint, 0) if high > low + _TINY else 0
    found = []
    for k in range(count + 1):
        y = low + (high - low) * k / max(count, 1)
        marks = sorted(x for s in segments for x in _marks(s, radius, y))
        spans: list[tuple[float, float]] = []
        for a, b in pairwise(marks):
            middle = complex((a + b) / 2.0, y)
            if (
                b - a < _TINY
                or not _inside(polygons, middle)
                or any(_distance(s, middle) < radius - _TINY for s in segments)
            ):
                continue
            if spans and a - spans[-1][1] < _TINY:
                spans[-1] = (spans[-1][0], b)
            else:
                spans.append((a, b))
        found.append((y, spans))
    return found


def around(contours: Nested, distance: float, name: str, *, climb: bool) -> list[list[Segment]]:
    """Return the ways of the tool around contours; raise where it does not go between two walls."""
    segments = [s for contour, _ in contours for s in contour]
    ways = [_beside(contour, distance, island, climb) for contour, island in contours]
    for way in ways:
        points = _polygon(way, _CHORD)
        for a, b in pairwise([*points, points[0]]):
            if not free(a, b, segments, distance - 2.0 * _CHORD):
                message = f"the tool does not go between two walls of {name} near X{a.real:.3f} Y{a.imag:.3f}"
                raise BlockError("cycle-tool", message, name, hint="take a smaller tool")
    return ways


def _beside(contour: Contour, distance: float, island: bool, climb: bool) -> list[Segment]:
    """Return the way around one contour, from the middle of its longest segment: the wall on its right where it climbs."""
    way = list(contour)
    if (area(contour) > 0.0) == (island == climb):
        way = backwards(way)
    longest = max(
        range(len(way)),
        key=lambda k: (
            way[k].sweep() * way[k].radius() if way[k].centre is not None else abs(way[k].end - way[k].start)
        ),
    )
    s = way[longest]
    half = (
        (s.start + s.end) / 2.0
        if s.centre is None
        else s.centre + (s.start - s.centre) * cmath.rect(1.0, s.spin * s.sweep() / 2.0)
    )
    ring = [
        Segment(half, s.end, s.centre, s.spin),
        *way[longest + 1 :],
        *way[:longest],
        Segment(s.start, half, s.centre, s.spin),
    ]
    return moved_aside(ring, distance, climb)


def walls(ip: Interpreter, ways: Sequence[Sequence[Segment]], how: Clearing) -> None:
    """Go along the ways beside the walls at each level."""
    tool = FlatCutter(ip)
    for way in ways:
        for level in how.levels:
            tool.to(way[0].start, rapid=True)
            tool.to(z=how.start, rapid=True)
            tool.plunge(level, how.plunge, how.feed)
            for segment in way:
                tool.follow(segment)
            tool.rise(how.start, how.out)


def clear(
    ip: Interpreter,
    contours: Sequence[Contour],
    radius: float,
    how: Clearing,
    gap: float,
    name: str,
    *,
    turn: complex = 1.0 + 0j,
    opened: Callable[[float, float], complex] | None = None,
) -> None:
    """Mill the rows of a radius to and fro at each level, over the start where a wall stands between them; raise where the tool goes in nowhere.

    The previous level cut everything that lies at least `gap` above a level. `turn` is the direction of the rows. `opened` goes down to a
    level, from the height that is free above it, and returns where the tool stands then.
    """
    tool, found = FlatCutter(ip, 0j, turn), rows(contours, radius, how.step, name)
    segments = [s for contour in contours for s in contour]
    if not any(spans for _, spans in found):
        message = f"the tool of diameter {2.0 * how.radius:g} does not go into the contours of {name}"
        raise BlockError("cycle-tool", message, name, hint="take a smaller tool")
    above = how.start
    for level in how.levels:
        at, back = opened(level, above) if opened else None, False
        for y, spans in found:
            for a, b in reversed(spans) if back else spans:
                begin, end = complex(b if back else a, y), complex(a if back else b, y)
                if at is None or not free(at, begin, segments, radius):
                    tool.rise(max(how.start, ip.state.position[2]), how.out)
                    tool.to(begin, rapid=True)
                    tool.to(z=above, rapid=True)
                    tool.plunge(level, how.plunge, how.feed)
                tool.to(begin)
                tool.to(end)
                at = end
            back = not back and bool(spans)
        tool.rise(how.start, how.out)
        above = min(how.start, level + gap)


def free(p: complex, q: complex, segments: Sequence[Segment], radius: float) -> bool:
    """Tell whether a straight way between two places of the tool keeps the radius from each segment."""
    way = Segment(p, q)
    if abs(q - p) < _TINY:
        return True
    for s in segments:
        near = [s.start, s.end]
        if s.centre is not None:
            # Outside a circle the foot of its centre is nearest; inside it, one of the ends is.
            foot = p + ((s.centre - p) * way.heading(p).conjugate()).real * way.heading(p)
            half = s.radius() ** 2 - abs(foot - s.centre) ** 2
            places = [foot] if half < 0.0 else [foot + k * math.sqrt(half) * way.heading(p) for k in (-1, 1)]
            if any(
                _distance(way, place) < _TINY and _distance(s, place) < radius - _TINY for place in places
            ):
                return False
        elif _apart(s, p, q) and _apart(way, s.start, s.end):
            return False
        if min(*(_distance(way, point) for point in near), _distance(s, p), _distance(s, q)) < radius - _TINY:
            return False
    return True


def _apart(line: Segment, p: complex, q: complex) -> bool:
    """Tell whether two points lie on either side of a line."""
    across = line.heading(line.start).conjugate()
    return ((across * (p - line.start)).imag > 0.0) != ((across * (q - line.start)).imag > 0.0)


def room(contours: Nested, name: str, most: float, least: float, allowance: float, climb: bool) -> float:
    """Return the radius of a tool that no table gives: the greatest one, or a smaller one that goes around with an allowance."""
    radius = most
    while radius > least:
        try:
            around(contours, radius + allowance, name, climb=climb)
        except BlockError:
            radius *= 0.8
        else:
            break
    return radius


def check(contours: Nested, name: str) -> None:
    """Raise where contours cross, or where pockets and islands do not lie within each other in turn."""
    polygons = [_polygon(contour, _CHORD) for contour, _ in contours]
    for k, (_, island) in enumerate(contours):
        others = polygons[:k] + polygons[k + 1 :]
        inside = {tuple(_inside([other], point) for other in others) for point in polygons[k]}
        if len(inside) > 1 or (sum(inside.pop()) % 2 == 1) != island:
            message = f"the contours of {name} cross, or an island does not lie within a pocket"
            hint = "pockets apart from each other, islands within them; the side of RL or RR tells one from the other"
            raise BlockError("not-read", message, name, hint=hint)
