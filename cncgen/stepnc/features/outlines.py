"""Closed curves of lines and arcs: from the polygons that stand for them, and begun at another place."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cncgen.geometry import elementary
from cncgen.stepnc.features.job import Floats
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline

#: How far refitted arcs may leave the polygon, mm.
REFIT = 1e-4
#: Segments of a quarter circle in offsets, and the largest angle that an edge of an arc may have.
QUARTER = 64
EDGE_ANGLE = 1.05 * math.pi / 2 / QUARTER
#: Edges that an arc has at least, and the angle that it turns by, rad.
_SHORTEST_RUN = 6
_SMALLEST_TURN = 0.05


def refit(points: Floats) -> list[Piece]:
    """Return a closed polygon, shape (n, 2) with the first point last again, as lines and arcs at height 0.

    Runs of short edges whose points lie on one circle (within `REFIT`) become an arc.
    """
    p = np.column_stack([points, np.zeros(len(points))])
    p = _begin_at_corner(p)
    n = len(p)
    pieces: list[Piece] = []
    line = [p[0]]
    k = 0
    while k < n - 1:
        run = _arc_run(p, k)
        if run is None:
            line.append(p[k + 1])
            k += 1
            continue
        if len(line) > 1:
            pieces.append(Polyline(np.stack(line)))
        end, centre = run
        pieces.append(_arc(p[k : end + 1], centre))
        k, line = end, [p[end]]
    if len(line) > 1:
        pieces.append(Polyline(np.stack(line)))
    return _tangent(pieces)


def _tangent(pieces: list[Piece]) -> list[Piece]:
    """Return a closed curve whose arcs begin and end where the lines beside them touch their circles.

    Polygons have no vertex there: an offset's first edge runs from the line past the point of contact onto the arc.
    """
    out = list(pieces)
    for k, piece in enumerate(out):
        if not isinstance(piece, Arc) or len(out) < 2:
            continue
        before, after = out[k - 1], out[(k + 1) % len(out)]
        start, end = piece.start, piece.end
        if isinstance(before, Polyline):
            start = _contact(before.points[-2], before.points[-1], piece, start)
            out[k - 1] = Polyline(np.concatenate([before.points[:-1], start[None, :]]))
            after = out[(k + 1) % len(out)]
        if isinstance(after, Polyline):
            end = _contact(after.points[1], after.points[0], piece, end)
            out[(k + 1) % len(out)] = Polyline(np.concatenate([end[None, :], after.points[1:]]))
        u, w = start - piece.centre, end - piece.centre
        sweep = math.atan2(
            float(elementary.product(piece.normal, np.cross(u, w))), float(elementary.product(u, w))
        ) % (2 * math.pi)
        out[k] = Arc(start, end, piece.centre, piece.normal, sweep)
    return out


def _contact(far: Floats, near: Floats, arc: Arc, point: Floats) -> Floats:
    """Return where the line from `far` to `near` touches an arc's circle, if that is beside the arc's end `point`."""
    along = near - far
    length = float(elementary.length(along))
    radius = float(elementary.length(point - arc.centre))
    foot = far + along * float(elementary.product(arc.centre - far, along)) / max(length**2, 1e-300)
    beside = float(elementary.length(foot - point)) <= 1.5 * EDGE_ANGLE * radius
    touches = abs(float(elementary.length(foot - arc.centre)) - radius) <= 2 * REFIT
    ahead = float(elementary.product(foot - far, along)) > 0
    return foot if beside and touches and ahead else point


def _begin_at_corner(p: Floats) -> Floats:
    """Turn a closed polygon so that it begins where its longest edge ends: not within an arc."""
    edges = np.linalg.norm(np.diff(p, axis=0), axis=1)
    k = _first_longest(edges) + 1
    if k >= len(p) - 1 or edges.max() < 2 * np.median(edges):
        return p
    return np.concatenate([p[k:-1], p[: k + 1]])


def _arc_run(p: Floats, k: int) -> tuple[int, Floats] | None:
    """Return the last index of the points from k on that lie on one circle, and its centre; None without an arc.

    The circle is fitted to the first points, then to all that lie on it, until no more join. An edge must be short for
    its circle: no longer than those of the first points, or so that the circle bulges over it by no more than `REFIT`.
    """
    edges = np.linalg.norm(np.diff(p[k:], axis=0), axis=1)
    end = k + _SHORTEST_RUN
    if end >= len(p):
        return None
    usual = 1.2 * float(edges[:_SHORTEST_RUN].max())
    centre = np.zeros(3)
    for _ in range(10):
        circle = _circle(p[k : end + 1])
        if circle is None:
            return None
        centre, radius = circle
        off = np.abs(np.linalg.norm(p[k:] - centre, axis=1) - radius)
        longest = min(EDGE_ANGLE * radius, max(math.sqrt(8 * radius * REFIT), usual))
        bad = np.flatnonzero((off[1:] > REFIT) | (edges > longest))
        reach = k + (int(bad[0]) if len(bad) else len(p) - 1 - k)
        if off[0] > REFIT or reach - k < _SHORTEST_RUN:
            return None
        if reach == end:
            break
        end = reach
    turn = float(edges[: end - k].sum()) / radius
    return (end, centre) if turn > _SMALLEST_TURN else None


def _circle(points: Floats) -> tuple[Floats, float] | None:
    """Return centre, shape (3,), and radius of the circle nearest to points (I. Kåsa, 1976); None for a line.

    Least squares of x² + y² = a x + b y + c about the mean of the points, where c is the mean of x² + y². The determinant of
    the other two equations is a difference of products of sums of n terms. Each product is at most a quarter of
    (Σ x² + y²)², so their rounding is at most (n + 2) ε/2 of that; points whose determinant is not twice that lie on a line.
    """
    middle = points[:, :2].mean(axis=0)
    x, y = (points[:, :2] - middle).T
    square = x * x + y * y
    xx, xy, yy = (x * x).sum(), (x * y).sum(), (y * y).sum()
    determinant = xx * yy - xy * xy
    if determinant <= (len(x) + 2) * np.finfo(float).eps * (xx + yy) ** 2:
        return None
    right, up, c = (x * square).sum(), (y * square).sum(), square.mean()
    a, b = (right * yy - up * xy) / determinant, (up * xx - right * xy) / determinant
    radius = math.sqrt(max(c + (a**2 + b**2) / 4, 0.0))
    return np.array([middle[0] + a / 2, middle[1] + b / 2, points[0, 2]]), radius


def _arc(points: Floats, centre: Floats) -> Arc:
    """Return the arc through points on a circle, the way that all of them go round: single steps may go back a little."""
    angles = np.unwrap(elementary.arctan2(points[:, 1] - centre[1], points[:, 0] - centre[0]))
    swept = float(angles[-1] - angles[0])
    return Arc(points[0], points[-1], centre, np.array([0.0, 0.0, math.copysign(1.0, swept)]), abs(swept))


def starting_near(curve: list[Piece], point: Floats, ahead: Floats | None = None) -> list[Piece]:
    """Return a closed curve that begins (and ends) at its point nearest to `point`.

    Of several with the same distance, the one in the direction `ahead` is taken.
    """
    split = _split(curve)
    index, t, place = _nearest(split, point, ahead)
    first, last = _divide(split[index], t, place)
    return _joined([*last, *split[index + 1 :], *split[:index], *first])


def with_detours(curves: list[list[Piece]], places: Sequence[Floats]) -> list[list[Piece]]:
    """Return curves that go from their point nearest to each place to that place and back."""
    out = list(curves)
    for place in places:
        near = [(_split(c), _nearest(_split(c), place, None)) for c in out]
        k = min(range(len(out)), key=lambda i: float(elementary.length(near[i][1][2] - place)))
        split, (index, t, begin) = near[k]
        first, last = _divide(split[index], t, begin)
        detour = Polyline(np.stack([begin, place, begin]))
        out[k] = _joined([*split[:index], *first, detour, *last, *split[index + 1 :]])
    return out


def _split(curve: list[Piece]) -> list[Piece]:
    """Return a curve's arcs and single lines."""
    split: list[Piece] = []
    for piece in curve:
        if isinstance(piece, Polyline):
            split += [Polyline(piece.points[k : k + 2]) for k in range(len(piece.points) - 1)]
        else:
            split.append(piece)
    return split


def _nearest(pieces: list[Piece], point: Floats, ahead: Floats | None) -> tuple[int, float, Floats]:
    """Return the piece with the point nearest to `point`, its parameter there (0 to 1), and that point."""
    best = (math.inf, 0, 0.0, pieces[0].start)
    for index, piece in enumerate(pieces):
        t, place = _nearest_on(piece, point)
        way = place[:2] - point[:2]
        distance = float(elementary.length(way))
        if ahead is not None and distance > 0:
            distance -= 1e-4 * float(elementary.product(way, ahead[:2])) / distance
        if distance < best[0] - 1e-9:
            best = (distance, index, t, place)
    return best[1:]


def _nearest_on(piece: Piece, point: Floats) -> tuple[float, Floats]:
    if isinstance(piece, Arc):
        u, w = piece.start - piece.centre, point - piece.centre
        turn = piece.normal[2]
        angle = math.atan2((u[0] * w[1] - u[1] * w[0]) * turn, u[0] * w[0] + u[1] * w[1]) % (2 * math.pi)
        if angle > piece.sweep:
            angle = piece.sweep if angle - piece.sweep < 2 * math.pi - angle else 0.0
        t = angle / piece.sweep
        return t, piece.points(np.array([t]))[0]
    a, b = piece.start, piece.end
    along = b - a
    t = float(
        np.clip(
            elementary.product((point - a)[:2], along[:2])
            / max(float(elementary.product(along, along)), 1e-300),
            0.0,
            1.0,
        )
    )
    return t, a + t * along


def _divide(piece: Piece, t: float, place: Floats) -> tuple[list[Piece], list[Piece]]:
    if t <= 1e-9:
        return [], [piece]
    if t >= 1 - 1e-9:
        return [piece], []
    if isinstance(piece, Arc):
        return (
            [Arc(piece.start, place, piece.centre, piece.normal, piece.sweep * t)],
            [Arc(place, piece.end, piece.centre, piece.normal, piece.sweep * (1 - t))],
        )
    return [Polyline(np.stack([piece.start, place]))], [Polyline(np.stack([place, piece.end]))]


def _joined(pieces: list[Piece]) -> list[Piece]:
    """Return pieces with lines that follow one another made one polyline."""
    out: list[Piece] = []
    for piece in pieces:
        last = out[-1] if out else None
        if isinstance(piece, Polyline) and isinstance(last, Polyline):
            out[-1] = Polyline(np.concatenate([last.points, piece.points[1:]]))
        else:
            out.append(piece)
    return out


def middle_of_longest(curve: list[Piece]) -> Floats:
    """Return the middle of the longest line or arc of a closed curve, shape (3,); the start of a full circle."""
    if len(curve) == 1 and isinstance(curve[0], Arc):
        return curve[0].start
    middles: list[tuple[float, Floats]] = []
    for piece in curve:
        if isinstance(piece, Polyline):
            steps = np.linalg.norm(np.diff(piece.points, axis=0), axis=1)
            k = _first_longest(steps)
            middles.append((float(steps[k]), (piece.points[k] + piece.points[k + 1]) / 2))
        elif isinstance(piece, Arc):
            radius = float(elementary.length(piece.start - piece.centre))
            middles.append((radius * piece.sweep, piece.points(np.array([0.5]))[0]))
    return middles[_first_longest([m[0] for m in middles])][1] if middles else curve[0].start


def _first_longest(lengths: ArrayLike) -> int:
    """Return the first of the longest: lengths that differ by less than rounding, as opposite sides of a rectangle do, are one."""
    given = np.asarray(lengths, float)
    return int(np.argmax(given >= given.max() * (1.0 - 1e-12)))
