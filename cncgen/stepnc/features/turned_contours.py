"""Facing and contouring of the outside of a bar."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.features.job import Moves
from cncgen.stepnc.features.outlines import QUARTER, refit
from cncgen.stepnc.features.turned_bar import CLEAR, FAR, SAME, BarJob, segments
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline

if TYPE_CHECKING:
    from shapely import Polygon

#: Material in front of a feature that is cut with it, mm; more has to be faced first.
MAX_EXCESS = 5.0


def face(work: BarJob) -> Moves:
    """Return the moves of FACING: passes across the axis, one behind the other."""
    job, points = work.job, work.points
    if np.ptp(points[:, 0]) > SAME:
        raise job.fault(
            "stepnc-unsupported",
            "facing is for a flat face across the axis; a contouring operation can turn it",
        )
    face, hub = float(points[0, 0]) + work.allowance, float(points[:, 1].min())
    hub += work.allowance if hub > SAME else 0.0
    _, end, top = work.bounds()
    inner = hub if hub > SAME else -work.nose - work.overcut
    levels = [face]
    if work.rough:
        work.known_bar("roughing")
        levels = [end - d for d in work.depths(end - face)] or [face]
    out = top + CLEAR
    moves = work.begin(levels[0], out)
    for level in levels:
        moves.rapid(np.array([level, out, 0.0]))
        moves.feed(np.array([level, inner, 0.0]))
        moves.feed(np.array([level + work.lift, inner, 0.0]))
        moves.rapid(np.array([level + work.lift, out, 0.0]))
    from shapely import box

    work.taken(box(face, max(hub, 0.0) if hub > SAME else -1.0, FAR, FAR))
    return moves


def _keep(work: BarJob, far: float) -> Polygon:
    """Return the forbidden region of the tool's corner, in (u, r): the profile, level in front of it and a wall behind it."""
    from shapely import Polygon, affinity

    points = work.points
    first, last = points[0], points[-1]
    inner: list[list[float]] = points.tolist()
    ring = [
        (far + FAR, first[1]),
        *inner,
        (last[0], FAR),
        (last[0] - FAR, FAR),
        (last[0] - FAR, -2 * FAR),
        (far + FAR, -2 * FAR),
    ]
    polygon = Polygon(ring)
    if not polygon.is_valid:
        raise work.job.fault(
            "stepnc-geometry", "the profile undercuts itself: some radius has two places along the axis"
        )
    grown = (
        polygon.buffer(work.allowance + work.nose, quad_segs=QUARTER)
        if work.allowance + work.nose > 0
        else polygon
    )
    return affinity.translate(grown, -work.nose, -work.nose)


def _along(keep: Polygon, start: float, top: float) -> list[Piece]:
    """Return the boundary of a polygon from where it comes down to `start` along u to where it rises above `top`."""
    from shapely.geometry.polygon import orient

    ring = np.array(orient(keep).exterior.coords)
    pieces = [s for p in refit(ring) for s in segments(p)]
    out: list[Piece] = []
    for piece in pieces:
        a, b = piece.start, piece.end
        if not out:
            if not a[0] > start >= b[0] or a[1] < -FAR:
                continue
            a = a + (start - a[0]) / (b[0] - a[0]) * (b - a)
            piece = Polyline(np.stack([a, b]))
        if b[1] > top and isinstance(piece, Polyline):
            if a[1] < top:
                out.append(Polyline(np.stack([a, a + (top - a[1]) / (b[1] - a[1]) * (b - a)])))
            return out
        if isinstance(piece, Arc) or np.abs(a - b).max() > SAME:
            out.append(piece)
    return out


def _check_falls(work: BarJob, bar_known: bool) -> None:
    """Raise `Skip` where the profile falls, in the direction of the feed, more steeply than the tool's trailing edge lets it.

    Roughing cuts what lies behind a hump in one pass, so a hollow may be at most one pass deep.
    """
    points, job = work.points, work.job
    along, down = -np.diff(points[:, 0]), -np.diff(points[:, 1])
    steepest = float(
        elementary.arctan2(np.maximum(down, 0.0), np.maximum(along, 0.0))[down > SAME].max(initial=0.0)
    )
    if steepest > 0:
        trailing = job.tool.trailing
        text = f"the profile falls by up to {math.degrees(steepest):.3g} degrees along the feed"
        if steepest > math.pi / 2 - 1e-6:
            raise job.fault(
                "stepnc-tool-size", f"{text}; a tool for grooves cuts such a wall, or a feed the other way"
            )
        if trailing is not None and steepest > trailing + 1e-6:
            raise job.fault(
                "stepnc-tool-size", f"{text}, and the tool's trailing edge has {math.degrees(trailing):.3g}"
            )
        if trailing is None:
            job.warn("stepnc-tool-size", f"{text}, and the angle of the tool's trailing edge is not known")
    if work.rough and bar_known:
        hollow = float((np.maximum.accumulate(points[:, 1]) - points[:, 1]).max())
        strategy = job.operation.strategy
        given = strategy.values.get("cutting_depth", ()) if strategy else ()
        most = given[-1] if isinstance(given, tuple) and given else 0.0
        if hollow > most + SAME:
            text = (
                f"the profile has a hollow {hollow:g} mm deep behind a hump, and passes are {most:g} mm deep"
            )
            raise job.fault(
                "stepnc-unsupported", text, hint="turn it as a GROOVE, or with feed_direction the other way"
            )


def _start(work: BarJob) -> float:
    """Return where the tool begins to feed along the axis: in front of all that stands before the profile.

    Raises:
        Skip: where more stands there than is cut with the feature.
    """
    from shapely import affinity, box

    begin, radius = float(work.points[0, 0]), float(work.points[0, 1])
    if work.bar is None:
        return begin + CLEAR
    seen = affinity.scale(work.bar.region, work.sense, 1.0, origin=(0, 0))
    stands = seen.intersection(box(begin + SAME, radius + SAME, FAR, FAR))
    if stands.is_empty or stands.area < 1e-3:
        return begin + CLEAR
    excess = float(stands.bounds[2]) - begin
    text = f"{excess:.4g} mm of material stand in front of the feature"
    if excess > MAX_EXCESS:
        raise work.job.fault(
            "stepnc-geometry", f"{text}; at most {MAX_EXCESS:g} mm are cut with it", hint="face the bar first"
        )
    work.job.warn("stepnc-depth", f"{text}, and are cut with it")
    return begin + excess + CLEAR


def contour(work: BarJob) -> Moves:
    """Return the moves of CONTOURING: of roughing passes along the axis, then once along the profile."""
    from shapely import LineString, Polygon, affinity

    job = work.job
    _check_falls(work, work.bar is not None)
    start = _start(work)
    keep = _keep(work, start)
    low, _, top = work.bounds()
    out = top + CLEAR
    way = _along(keep, start, out)
    if not way:
        raise job.fault("stepnc-geometry", "no path along the profile can be made")
    moves = work.begin(start, out)
    if work.rough:
        work.known_bar("roughing")
        deepest = min(float(p.start[1]) for p in way)
        for depth in work.depths(max(top - deepest, 0.0))[:-1]:
            level = top - depth
            free = LineString([(start, level), (low - FAR, level)]).difference(keep)
            parts = [g for g in getattr(free, "geoms", [free]) if not g.is_empty]
            first = max(parts, key=lambda g: g.bounds[2], default=None)
            if first is None or first.bounds[2] < start - SAME:
                continue  # lower than where the profile begins: the last way along it cuts that hollow
            hit = float(first.bounds[0])
            moves.rapid(np.array([start, level, 0.0]))
            lifted = np.array([hit + work.lift, level + work.lift, 0.0])
            moves.feed(np.array([hit, level, 0.0]), lifted)
            moves.rapid(np.array([start, level + work.lift, 0.0]))
    moves.rapid(way[0].start)
    moves.follow(way)
    points = work.points
    # Behind the wall the bar stays; in front of the profile it is cut as far as that begins.
    gone = Polygon([(start + FAR, points[0, 1]), *points.tolist(), (points[-1, 0], FAR), (start + FAR, FAR)])
    work.taken(gone.difference(affinity.translate(keep, work.nose, work.nose).buffer(-work.nose)))
    return moves
