"""Grooves in the outside of a bar."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from cncgen.stepnc.features.job import Moves
from cncgen.stepnc.features.outlines import QUARTER, refit
from cncgen.stepnc.features.turned_bar import CLEAR, FAR, LIFT, SAME, Bar, BarJob, segments
from cncgen.stepnc.geometry.pieces import Piece, Polyline

if TYPE_CHECKING:
    from shapely import Polygon

#: Depth by which a tool as wide as its groove may touch the walls, mm.
TOUCH = 1e-7
#: How much of its width a tool for grooves steps aside, at most.
SIDE_STEP = 0.8


def _blade(work: BarJob) -> tuple[Polygon, float]:
    """Return where the left corner of a tool for grooves must not go, in (u, r), and the tool's width, mm."""
    from shapely import MultiPoint, Polygon, affinity, unary_union

    job, points = work.job, work.points
    width = job.tool.width
    if width is None or not width > 0:
        raise job.fault(
            "stepnc-missing", "a groove needs the width of its tool: GROOVING_TOOL with cutting_width"
        )
    nose = min(work.nose, width / 2)
    ring = [(FAR, FAR), *points.tolist(), (-FAR, FAR), (-FAR, -2 * FAR), (FAR, -2 * FAR)]
    keep = Polygon(ring)
    if not keep.is_valid:
        raise job.fault("stepnc-geometry", "the section of the groove crosses itself")
    grown = keep.buffer(work.allowance + nose, quad_segs=QUARTER) if work.allowance + nose > 0 else keep
    slide = max(width - 2 * nose - 2 * TOUCH, 0.0)
    edges = np.array(grown.exterior.coords)
    # The flat end of the tool sweeps the region left of the polygon, over its width.
    swept = [
        MultiPoint([a, b, (a[0] - slide, a[1]), (b[0] - slide, b[1])]).convex_hull
        for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
    ]
    whole = unary_union([grown, affinity.translate(grown, -slide), *swept]) if slide > 0 else grown
    return affinity.translate(whole, -nose - TOUCH, -nose), width


def groove(work: BarJob) -> Moves:
    """Return the moves of GROOVING: plunges side by side, or once round the walls and floor."""
    from shapely import LineString, Polygon

    job = work.job
    keep, width = _blade(work)
    bar = work.known_bar("a groove")
    points = work.points
    middle = float(np.median(points[:, 0]))
    top = _surface(work, bar, middle, job.shape.width or width)
    if top <= float(points[:, 1].min()) + SAME:
        text = f"the bar has a radius of {top:g} mm there, and the groove's bottom one of {points[:, 1].min():g} mm"
        raise job.fault("stepnc-depth", f"nothing is left to cut: {text}")
    opening = LineString([(middle - FAR / 2, top), (middle + FAR / 2, top)]).difference(keep)
    parts = [g.bounds for g in getattr(opening, "geoms", [opening]) if not g.is_empty]
    if not parts:
        text = f"a tool {width:g} mm wide does not enter the groove"
        text += f" of {job.shape.width:g} mm" if job.shape.width else ""
        text += f" with an allowance of {work.allowance:g} mm" if work.allowance else ""
        raise job.fault("stepnc-tool-size", text)
    left, right = parts[0][0], parts[0][2]
    depth = top - float(points[:, 1].min())
    if job.tool.cutting_length and depth > job.tool.cutting_length + SAME:
        text = f"the groove is {depth:g} mm deep, and the tool reaches {job.tool.cutting_length:g} mm"
        raise job.fault("stepnc-tool-size", text)
    out = work.bounds()[2] + CLEAR
    moves = work.begin(right, out)
    moves.rapid(np.array([right, top + CLEAR, 0.0]))
    if work.rough:
        _plunge(work, moves, keep, (left, right), top)
    else:
        moves.follow(_round(keep, (left, right), top + CLEAR))
    moves.rapid(np.array([moves.position[0], out, 0.0]))
    region = Polygon(points)
    work.taken(region.buffer(-work.allowance) if work.allowance else region)
    return moves


def _surface(work: BarJob, bar: Bar, middle: float, width: float) -> float:
    """Return the largest radius of the bar round a place, `width` mm to each side."""
    from shapely import affinity, box

    seen = affinity.scale(bar.region, work.sense, 1.0, origin=(0, 0))
    there = seen.intersection(box(middle - width, 0.0, middle + width, FAR))
    return float(there.bounds[3]) if not there.is_empty else 0.0


def _dwell(work: BarJob, moves: Moves) -> None:
    """Wait as the operation asks."""
    moves.dwell(work.job.value("dwell", 0.0))
    moves.dwell_turns(work.job.value("dwell_turns", 0.0))


def _floor_at(keep: Polygon, u: float, top: float) -> float:
    """Return how deep a tool may plunge at a place, mm."""
    from shapely import LineString

    free = LineString([(u, top), (u, -FAR)]).difference(keep)
    return float(max(getattr(free, "geoms", [free]), key=lambda g: g.bounds[3]).bounds[1])


def _plunge(work: BarJob, moves: Moves, keep: Polygon, opening: tuple[float, float], top: float) -> None:
    """Plunge side by side over an opening, each time in as many steps as the strategy has depths."""
    job = work.job
    left, right = opening
    count = (
        math.ceil((right - left) / (SIDE_STEP * (job.tool.width or 0.0)) - 1e-9) if right - left > SAME else 0
    )
    out = top + CLEAR
    strategy = job.operation.strategy
    back = job.strategy_value("retract_distance", 0.0)
    for u in np.linspace(right, left, count + 1).tolist():
        # A hair beside the wall, which the line down must not touch.
        inside = min(max(u, left + SAME), right - SAME) if count else (left + right) / 2
        whole = top - _floor_at(keep, inside, top)
        moves.rapid(np.array([u, out, 0.0]))
        steps = work.depths(whole) if strategy and strategy.values.get("cutting_depth") else [whole]
        for depth in steps:
            moves.feed(np.array([u, top - depth, 0.0]))
            if depth < steps[-1]:
                moves.rapid(np.array([u, min(top - depth + back, out) if back > 0 else out, 0.0]))
                if back <= 0:
                    moves.rapid(np.array([u, top - depth + LIFT, 0.0]))
        _dwell(work, moves)
        moves.rapid(np.array([u, out, 0.0]))


def _round(keep: Polygon, opening: tuple[float, float], top: float) -> list[Piece]:
    """Return the way of a tool down one wall of a groove, along its floor and up the other, from the highest u on."""
    from shapely import box
    from shapely.geometry.polygon import orient

    left, right = opening
    middle = (left + right) / 2
    free = box(left - FAR, -FAR, right + FAR, top).difference(keep)
    parts = [g for g in getattr(free, "geoms", [free]) if g.bounds[0] - SAME <= middle <= g.bounds[2] + SAME]
    if not parts:  # as wide as its tool: straight down
        deep = _floor_at(keep, middle, top)
        down = np.array([[middle, top, 0.0], [middle, deep, 0.0]])
        return [Polyline(down), Polyline(down[::-1])]
    # Under a wide roof, whose edge is the longest, so that `refit` begins there.
    roofed = max(parts, key=lambda g: g.area).union(box(left - FAR, top, right + FAR, top + FAR))
    ring = np.array(orient(roofed, sign=-1.0).exterior.coords)
    pieces = (s for p in refit(ring) for s in segments(p))
    return [p for p in pieces if min(p.start[1], p.end[1]) < top - SAME]
