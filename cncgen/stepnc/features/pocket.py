"""Pockets: rings parallel to the contour from inside out, a spiral, or lines with a contour; depth by depth.

Distances, directions and ways down are those that NIST's interpreter chooses for a rectangular pocket; other outlines
follow the same rules with offsets made by shapely.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from cncgen.stepnc.execution.linearize import polyline_of
from cncgen.stepnc.features import offsets
from cncgen.stepnc.features.entry import Entry, choose, ramp
from cncgen.stepnc.features.job import Floats, Job, Moves, at_height, raised
from cncgen.stepnc.features.offsets import Ring
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline
from cncgen.stepnc.model import Path

_RINGS = ("", "contour parallel", "contour bidirectional", "bidirectional contour")
_LINES = ("bidirectional", "unidirectional")
#: Regions times depths, and lines of all depths, of one pocket.
MAX_PASSES = 100_000
MAX_LINES = 5_000_000
#: Lines of a turn of a spiral.
SPIRAL_POINTS = 720


def mill(job: Job) -> tuple[Path, ...]:
    """Return the toolpaths of a closed or open pocket."""
    if job.shape.slope > 1e-9:
        raise job.fault("stepnc-unsupported", "walls with a slope cannot be made by passes of one outline")
    if job.shape.bottom not in ("", "flat", "through"):
        raise job.fault("stepnc-unsupported", f"a pocket with a {job.shape.bottom} bottom cannot be made")
    outline = job.shape.outline
    if outline is None:
        raise job.fault("stepnc-missing", "the pocket has no boundary")
    radius, allowance = job.radius, job.value("allowance_side", 0.0)
    _check_radii(job, radius, allowance)
    whole = offsets.polygon_of(outline)
    if job.shape.open_sides:
        whole = _opened(job, whole)
    bosses = [offsets.polygon_of(b) for b in job.shape.bosses]
    corner = job.shape.corner_radius or 0.0
    inset = radius + allowance

    def shrink(distance: float) -> list[Any]:
        return offsets.region(whole, bosses, distance, corner)

    return _clear(job, shrink, inset)


def mill_hole(job: Job) -> tuple[Path, ...]:
    """Return the toolpaths of a round hole that is milled as a pocket."""
    if job.shape.diameter is None:
        raise job.fault("stepnc-missing", "the hole has no diameter")
    start = np.array([job.shape.diameter / 2, 0.0, 0.0])
    circle: list[Piece] = [Arc(start, start, np.zeros(3), np.array([0.0, 0.0, 1.0]), 2 * np.pi)]
    bottom = job.shape.bottom if job.shape.bottom in ("through", "flat") else "flat"
    if job.shape.bottom == "conical":
        raise job.fault("stepnc-unsupported", "a conical bottom cannot be milled flat")
    return mill(replace(job, shape=replace(job.shape, outline=circle, bottom=bottom)))


def _check_radii(job: Job, radius: float, allowance: float) -> None:
    corner, floor = job.shape.corner_radius, job.shape.floor_radius
    if corner is not None and corner < radius + allowance - 1e-9:
        text = f"corners of {corner:g} mm cannot be cut by a tool of {radius:g} mm radius"
        if corner < radius - 1e-9:
            job.warn("stepnc-corner", f"{text}; material stays in them")
        else:
            job.warn(
                "stepnc-corner", f"{text} with an allowance of {allowance:g} mm; more of it stays in them"
            )
    edge = job.tool.edge_radius or 0.0
    if floor is not None and abs(floor - edge) > 1e-6:
        job.warn("stepnc-floor", f"the floor has a radius of {floor:g} mm, the tool one of {edge:g} mm")


def _opened(job: Job, whole: Any) -> Any:
    """Return the outline grown over its open sides, so that the tool leaves the material there."""
    from cncgen.stepnc.features.offsets import grown_over

    outline = job.shape.outline or []
    reach = job.radius + job.value("overcut_length", 2.5 * job.radius)
    return grown_over(whole, [outline[k] for k in job.shape.open_sides], reach)


def _clear(job: Job, shrink: Any, inset: float) -> tuple[Path, ...]:
    """Return the toolpaths that clear a region level by level."""
    total = job.depth - job.value("allowance_bottom", 0.0)
    if job.shape.bottom == "through":
        total += job.value("overcut_length", 0.0)
    levels = job.levels(total)
    step = job.radial_step()
    if not step > 0:
        raise job.fault(
            "stepnc-geometry", f"the distance between passes is {step:g} mm: the overlap is too large"
        )
    if step > 2 * job.radius + 1e-9:
        text = f"passes {step:g} mm apart leave material between them: the tool has {2 * job.radius:g} mm"
        job.warn("stepnc-uncut", text)
    strategy = job.operation.strategy.kind if job.operation.strategy else ""
    rings = offsets.nested(shrink, inset, step)
    if not rings:
        raise job.fault(
            "stepnc-geometry", f"the tool does not fit: nothing is left inside {inset:g} mm from the walls"
        )
    moves: Moves | None = None
    for ring in rings:
        if len(rings) * len(levels) > MAX_PASSES:
            raise job.fault("stepnc-geometry", f"{len(rings)} regions in {len(levels)} depths are too many")
        if strategy in _RINGS:
            cuts = _ring_cuts(job, ring)
        elif strategy == "contour spiral":
            cuts = [_spiral_cut(job, ring)]
        elif strategy in _LINES:
            cuts = _line_cuts(job, ring, step, strategy == "unidirectional")
        else:
            raise job.fault("stepnc-unsupported", f"a pocket cannot be made by strategy {strategy!r}")
        moves = _descend_levels(job, cuts, levels, moves)
    return moves.paths() if moves else ()


#: A cut on one level: the way down to where it begins, and the closed or open curves to follow, each reached by a
#: straight line from the one before it.
Cut = tuple[Entry, list[list[Piece]]]


def _descend_levels(job: Job, cuts: list[Cut], levels: list[float], moves: Moves | None) -> Moves:
    """Do the cuts of a region on all levels; the tool leaves at the retract plane, at the feed."""
    pieces = [p for _, curves in cuts for curve in curves for p in curve]
    lines = sum(len(p.points) if isinstance(p, Polyline) else 1 for p in pieces)
    if len(levels) * lines > MAX_LINES:
        raise job.fault("stepnc-geometry", f"{len(levels)} depths of {lines} lines each are too many")
    begin = cuts[0][0].start(job.retract, levels[0])
    above_begin = np.array([begin[0], begin[1], job.retract])
    if moves is None:
        moves = Moves(job.operation.ident, above_begin)
    moves.rapid(above_begin)
    for k, level in enumerate(levels):
        above = levels[k - 1] if k else 0.0
        for n, (entry, curves) in enumerate(cuts):
            if k or n:
                start = entry.start(above, level)
                clear = float(moves.position[2]) if n == 0 else job.retract
                moves.rapid(np.array([start[0], start[1], clear]))
                moves.feed(np.array([start[0], start[1], above]))
            entry.descend(moves, level)
            for curve in curves:
                moves.feed(at_height(curve[0].start, level))
                moves.follow(raised(curve, level))
            if n + 1 < len(cuts):
                moves.height(job.retract)
        last = k + 1 == len(levels)
        moves.height(job.retract if last or len(cuts) > 1 else above)
    return moves


def _ring_cuts(job: Job, root: Ring) -> list[Cut]:
    """Return the cuts of a tree of rings: one for every leaf, with the rings around it that no leaf before had."""
    clockwise = not job.climb
    order: list[tuple[Ring, list[Ring]]] = []
    done: set[int] = set()

    def leaves(ring: Ring, around: list[Ring]) -> None:
        for child in ring.children:
            leaves(child, [ring, *around])
        if not ring.children:
            order.append((ring, around))

    leaves(root, [])
    remaining = {id(r): _count_leaves(r) for r in _all(root)}
    cuts = []
    for leaf, around in order:
        rings = [leaf]
        for ring in around:
            remaining[id(ring)] -= 1
            if remaining[id(ring)] == 0 and id(ring) not in done:
                done.add(id(ring))
                rings.append(ring)
        cuts += _chain(job, root, leaf, rings, clockwise)
    return cuts


def _all(ring: Ring) -> list[Ring]:
    out = [ring]
    for child in ring.children:
        out += _all(child)
    return out


def _count_leaves(ring: Ring) -> int:
    return sum(_count_leaves(c) for c in ring.children) if ring.children else 1


def _chain(job: Job, root: Ring, leaf: Ring, rings: list[Ring], clockwise: bool) -> list[Cut]:
    """Return the cut that begins in a leaf's middle and goes out ring by ring.

    A ring that no straight line within the region leads to (round a boss) becomes a cut of its own, with a ramp
    along itself as the way down.
    """
    core = leaf.core
    curves: list[list[Piece]] = []
    if core is not None and len(core) == 2:
        curves.append([Polyline(core)])
    start = core[0] if core is not None else None
    position = None if core is None else core[-1]
    ahead = core[1] - core[0] if core is not None and len(core) == 2 else None
    ahead = ahead / np.linalg.norm(ahead) if ahead is not None else None
    alone: list[Cut] = []
    for ring in rings:
        for curve in offsets.boundary_curves(ring.polygon, clockwise):
            near = offsets.starting_near(curve, position, ahead) if position is not None else curve
            if position is not None and not offsets.line_inside(root.polygon, position, near[0].start):
                alone.append((_ramp_on(job, near), [near]))
                continue
            curves.append(near)
            start = near[0].start if start is None else start
            position = near[-1].end
    if start is None or not curves:
        return alone
    target = core[1] if core is not None and len(core) == 2 else curves[0][0].start
    direction = target - start
    if np.linalg.norm(direction) < 1e-9:
        direction = np.diff(polyline_of(curves[0][0], 1e-3).points[:2], axis=0)[0]
    direction = direction / np.linalg.norm(direction)
    entry = choose(job, start, direction, curves[0], root.polygon)
    return [(entry, curves), *alone]


def _ramp_on(job: Job, curve: list[Piece]) -> Entry:
    from cncgen.stepnc.features.entry import DEFAULT_ANGLE

    return ramp(curve[0].start, curve, DEFAULT_ANGLE)


def _spiral_cut(job: Job, root: Ring) -> Cut:
    """Return one continuous cut: the middle, the innermost ring, a spiral outwards, the outermost ring."""
    chain = [root]
    while chain[-1].children:
        if len(chain[-1].children) > 1 or chain[-1].polygon.interiors:
            raise job.fault("stepnc-unsupported", "a spiral needs a pocket whose offsets stay in one piece")
        chain.append(chain[-1].children[0])
    if root.polygon.interiors:
        raise job.fault("stepnc-unsupported", "a spiral cannot go round a boss; use contour parallel")
    if root.polygon.area < 0.999 * root.polygon.convex_hull.area:
        text = (
            "a spiral in a pocket that is not convex leaves material between its turns; use contour parallel"
        )
        raise job.fault("stepnc-unsupported", text)
    clockwise = not job.climb
    core = chain[-1].core
    start = core[0] if core is not None else np.append(offsets.inradius(root.polygon)[1], 0.0)
    middle: list[list[Piece]] = [[Polyline(core)]] if core is not None and len(core) == 2 else []
    position = core[-1] if core is not None else start
    loops: list[Floats] = []
    curves: list[list[Piece]] = []
    for ring in reversed(chain):
        curves.append(offsets.starting_near(offsets.boundary_curves(ring.polygon, clockwise)[0], position))
        loops.append(_even(curves[-1], SPIRAL_POINTS))
        position = loops[-1][0]
    t = np.linspace(0.0, 1.0, SPIRAL_POINTS + 1)[:, None]
    turns: list[list[Piece]] = [[Polyline((1 - t) * a + t * b)] for a, b in pairwise(loops)]
    path = [*middle, curves[0], *turns, *(curves[-1:] if len(curves) > 1 else [])]
    first = path[0][0]
    target = first.end if middle else first.start
    direction = target - start
    if np.linalg.norm(direction) < 1e-9:
        direction = loops[0][1] - loops[0][0]
    direction = direction / np.linalg.norm(direction)
    return choose(job, start, direction, path[0], root.polygon), path


def _even(curve: list[Piece], count: int) -> Floats:
    """Return `count` + 1 points, shape (count + 1, 3), evenly along a curve."""
    points = np.concatenate([polyline_of(p, 1e-3).points for p in curve])
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    even = np.linspace(0.0, s[-1], count + 1)
    return np.column_stack([np.interp(even, s, points[:, k]) for k in range(3)])


def _line_cuts(job: Job, root: Ring, step: float, one_way: bool) -> list[Cut]:
    """Return lines across the pocket, each stretch a cut of its own where the way to it is barred, then the contour."""
    strategy = job.operation.strategy
    along = strategy.values.get("feed_direction") if strategy else None
    along = np.array([1.0, 0.0, 0.0]) if along is None else np.array([along[0], along[1], 0.0])
    if np.linalg.norm(along) < 1e-9:
        raise job.fault("stepnc-geometry", "the feed direction is across the pocket")
    along = along / np.linalg.norm(along)
    side = str(strategy.values.get("stepover_direction", "LEFT")).upper() if strategy else "LEFT"
    across = np.array([-along[1], along[0], 0.0]) * (1.0 if side == "LEFT" else -1.0)
    runs: list[list[Floats]] = []
    forward = True
    for row in offsets.chords(root.polygon, along, across, step):
        for stretch in row if forward else row[::-1]:
            a, b = stretch if forward else stretch[::-1]
            near = runs and not one_way and offsets.line_inside(root.polygon, runs[-1][-1], a)
            if near and len(row) == 1:
                runs[-1] += [a, b]
            else:
                runs.append([a, b])
        forward = one_way or not forward
    cuts: list[Cut] = []
    for run in runs:
        path: list[Piece] = [Polyline(np.stack(run))]
        direction = (run[1] - run[0]) / np.linalg.norm(run[1] - run[0])
        cuts.append((choose(job, run[0], direction, path, root.polygon), [path]))
    for curve in offsets.boundary_curves(root.polygon, not job.climb):
        near_curve = offsets.starting_near(curve, runs[-1][-1]) if runs else curve
        cuts.append((_ramp_on(job, near_curve), [near_curve]))
    return cuts
