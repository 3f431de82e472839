"""Pockets: rings parallel to the contour from inside out, a spiral, or lines with a contour; depth by depth.

Distances, directions and ways down are those that NIST's interpreter chooses for a rectangular pocket; other outlines
follow the same rules with offsets made by shapely.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.features import offsets, outlines
from cncgen.stepnc.features.bottoms import bottom_of, is_round
from cncgen.stepnc.features.entry import Entry, choose, plunge, ramp
from cncgen.stepnc.features.job import Floats, Job, Moves, at_height, raised
from cncgen.stepnc.features.ring_trees import Ring, nested, rings_of
from cncgen.stepnc.features.walls import Layer, drawn_in, layers
from cncgen.stepnc.geometry import profile_shapes
from cncgen.stepnc.geometry.chords import polyline_of
from cncgen.stepnc.geometry.pieces import Piece, Polyline
from cncgen.stepnc.model import CutterPath

if TYPE_CHECKING:
    from shapely import Polygon

_RINGS = ("", "contour parallel", "contour bidirectional", "bidirectional contour")
_SPIRALS = ("contour spiral",)
_LINES = ("bidirectional", "unidirectional")
#: Lower ridges between passes of a rounded tool are not told, mm.
RIDGE = 0.02
#: Regions times depths, and lines of all depths, of one pocket.
MAX_PASSES = 100_000
MAX_LINES = 5_000_000
#: Lines of a turn of a spiral, at least.
SPIRAL_PIECES = 360


def mill(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths of a closed or open pocket (BOTTOM_AND_SIDE_…_MILLING, ISO 14649-11; pockets, ISO 14649-10)."""
    bottom = bottom_of(job)
    flat = (
        ("", "flat", "through") if job.shape.diameter is None else ("", "flat", "through", "flat with radius")
    )
    if bottom is None and job.shape.bottom not in flat:
        raise job.fault("stepnc-unsupported", f"a pocket with a {job.shape.bottom} bottom cannot be made")
    outline = job.shape.outline
    if outline is None:
        raise job.fault("stepnc-missing", "the pocket has no boundary")
    check_radii(job if bottom is None else replace(job, shape=replace(job.shape, floor_radius=None)))
    total = bottom.lowest if bottom is not None else job.depth - job.value("allowance_bottom", 0.0)
    if job.shape.bottom == "through":
        total += job.value("overcut_length", 0.0)
    return _clear(job, offsets.polygon_of(outline), layers(job, total))


def mill_hole(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths of a round hole that is milled as a pocket."""
    if job.shape.diameter is None:
        raise job.fault("stepnc-missing", "the hole has no diameter")
    circle: list[Piece] = [profile_shapes.circle(job.shape.diameter)]
    return mill(replace(job, shape=replace(job.shape, outline=circle)))


def mill_open(job: Job, outline: list[Piece]) -> tuple[CutterPath, ...]:
    """Return the toolpaths that clear an outline whose sides are all open: a face with bosses, stock round a profile."""
    shape = replace(job.shape, outline=outline, open_sides=tuple(range(len(outline))), bottom="flat")
    return mill(replace(job, shape=shape))


def check_radii(job: Job) -> None:
    """Warn of corners and floors that are rounded otherwise than the tool cuts them."""
    radius, allowance = job.radius, job.value("allowance_side", 0.0)
    corner, floor = job.shape.corner_radius, job.shape.floor_radius
    if corner is not None and corner < radius + allowance - 1e-9:
        text = f"corners of {corner:g} mm cannot be cut by a tool of {radius:g} mm radius"
        if corner < radius - 1e-9:
            job.warn("stepnc-corner", f"{text}; material stays in them")
        else:
            job.warn(
                "stepnc-corner", f"{text} with an allowance of {allowance:g} mm; more of it stays in them"
            )
    edge = job.tool.edge
    if floor is not None and abs(floor - edge) > 1e-6:
        text = f"the floor has a radius of {floor:g} mm, the tool one of {edge:g} mm"
        what = "steps stay beside the wall" if floor > edge else "the tool's stays beside the wall"
        job.warn("stepnc-floor", f"{text}; {what}")


def opened(job: Job, whole: Polygon, drop: float) -> Any:
    """Return an outline grown over its open sides, so that the tool leaves the material there.

    Args:
        job: The feature with the indexes of its open sides.
        whole: shapely polygon of the outline.
        drop: How deep it goes, mm.
    """
    outline = job.shape.outline or []
    reach = job.radius + job.value("overcut_length", 2.5 * job.radius) + drawn_in(job, drop)
    return offsets.grown_over(whole, [outline[k] for k in job.shape.open_sides], reach)


def _step(job: Job) -> float:
    """Return the distance between passes, mm."""
    step = job.radial_step()
    if not step > 0:
        raise job.fault(
            "stepnc-geometry", f"the distance between passes is {step:g} mm: the overlap is too large"
        )
    if step > 2 * job.radius + 1e-9:
        text = f"passes are {step:g} mm apart, and the tool has {2 * job.radius:g} mm: walls would stay between them"
        raise job.fault("stepnc-range", text, hint=f"at most {2 * job.radius:g} mm")
    return step


def floor_reach(job: Job, step: float, corners: bool = True) -> float:
    """Return how far from its axis the tool cuts the floor, mm; warn of ridges that its rounded edge leaves between passes.

    Args:
        job: The feature.
        step: Distance between passes, mm.
        corners: Whether passes are rings, whose corners are farther from each other.
    """
    level, edge = job.radius - job.tool.edge, job.tool.edge
    if step / 2 - level <= 1e-9:
        return level
    over = (min(step / math.sqrt(2), job.radius) if corners else step / 2) - level
    ridge = edge - math.sqrt(max(edge**2 - min(over, edge) ** 2, 0.0))
    if ridge > RIDGE and not is_round(job) and not job.value("allowance_bottom", 0.0):
        text = f"passes {step:g} mm apart of a tool whose end is level over {2 * level:g} mm leave ridges up to {ridge:.2g} mm high"
        job.warn("stepnc-uncut", f"{text}; smaller steps make them lower")
    return job.radius


def _clear(job: Job, closed: Polygon, passes: list[Layer]) -> tuple[CutterPath, ...]:
    """Return the toolpaths that clear an outline (shapely polygon) level by level."""
    step, corner = _step(job), job.shape.corner_radius or 0.0
    lowest = -passes[-1].spans[-1][1]
    whole = opened(job, closed, lowest) if job.shape.open_sides else closed
    moves: Moves | None = None
    fitted, reach = False, floor_reach(job, step)
    for layer in passes:
        rings = nested(partial(layer.region, whole, corner), step, reach)
        if len(rings) * len(layer.spans) > MAX_PASSES:
            raise job.fault(
                "stepnc-geometry",
                f"{len(rings)} regions in {len(layer.spans)} depths are more than {MAX_PASSES} passes",
            )
        if not rings and not fitted:
            inset = layer.wall
            raise job.fault(
                "stepnc-geometry",
                f"the tool does not fit: nothing is left inside {inset:g} mm from the walls",
            )
        if not rings:
            job.warn(
                "stepnc-uncut", f"the tool does not fit below {layer.spans[0][0]:g} mm; material stays there"
            )
            break
        fitted = True
        for ring in rings:
            moves = _descend_levels(job, _cuts(job, ring, step, closed), layer.spans, moves)
        _check_reach(job, closed, layer, rings, corner)
    return moves.paths() if moves else ()


def _check_reach(job: Job, closed: Polygon, layer: Layer, rings: list[Ring], corner: float) -> None:
    """Warn of places too narrow for the tool, others than the corners that it rounds: a necking, a gap at a boss."""
    wall = layer.moved(-job.radius).region(closed, corner, 0.0)
    axis = [r.polygon for r in rings]
    left, reached = offsets.not_swept(wall, axis, job.radius), offsets.swept(axis, job.radius)
    narrow = [2 * offsets.inradius(p)[0] for p in offsets.notches(left, reached, job.radius)]
    if narrow:
        text = f"the tool of {2 * job.radius:g} mm does not reach {len(narrow)} places up to {max(narrow):.3g} mm wide"
        job.warn("stepnc-uncut", f"{text}; material stays there")


def _cuts(job: Job, ring: Ring, step: float, closed: Polygon) -> list[Cut]:
    """Return the cuts of one region by the operation's strategy."""
    strategy = job.operation.strategy.kind if job.operation.strategy else ""
    if strategy in _RINGS:
        return _ring_cuts(job, ring, spiral=False)
    if strategy in _SPIRALS:
        return _ring_cuts(job, ring, spiral=True)
    if strategy in _LINES:
        return _line_cuts(job, ring, step, closed)
    raise job.fault("stepnc-unsupported", f"a pocket cannot be made by strategy {strategy!r}")


#: A cut on one level: the way down to where it begins, and the closed or open curves to follow, each reached by a
#: straight line from the one before it.
Cut = tuple[Entry, list[list[Piece]]]


def _descend_levels(
    job: Job, cuts: list[Cut], spans: Sequence[tuple[float, float]], moves: Moves | None
) -> Moves:
    """Do the cuts of a region on all levels; the tool leaves at the retract plane, at the feed."""
    pieces = [p for _, curves in cuts for curve in curves for p in curve]
    lines = sum(len(p.points) if isinstance(p, Polyline) else 1 for p in pieces)
    if len(spans) * lines > MAX_LINES:
        raise job.fault(
            "stepnc-geometry", f"{len(spans)} depths of {lines} lines each are more than {MAX_LINES} lines"
        )
    if spans[0][0] == 0.0:
        begin = cuts[0][0].start(job.retract, spans[0][1])
    else:
        begin = cuts[0][0].start(*spans[0])
    above_begin = at_height(begin, job.retract)
    if moves is None:
        moves = Moves(job.operation.ident, above_begin)
    moves.rapid(above_begin)
    for k, (above, level) in enumerate(spans):
        for n, (entry, curves) in enumerate(cuts):
            if above < 0.0 or n:
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
        last = k + 1 == len(spans)
        moves.height(job.retract if last or len(cuts) > 1 else above)
    return moves


def _ring_cuts(job: Job, root: Ring, spiral: bool) -> list[Cut]:
    """Return the cuts of a tree of rings: one for every leaf, with the rings around it that no leaf before had."""
    parent = {id(child): ring for ring in rings_of(root) for child in ring.children}
    left = {id(ring): len(ring.children) for ring in rings_of(root)}  # children not yet cut
    cuts: list[Cut] = []
    stack = [root]
    while stack:
        ring = stack.pop()
        stack.extend(reversed(ring.children))
        if ring.children:
            continue
        rings = [ring]
        while (outer := parent.get(id(rings[-1]))) is not None:
            left[id(outer)] -= 1
            if left[id(outer)]:
                break
            rings.append(outer)
        cuts += _chain(job, root, rings, spiral)
    return cuts


def _chain(job: Job, root: Ring, rings: list[Ring], spiral: bool) -> list[Cut]:
    """Return the cut that begins in the middle of the first ring, a leaf, and goes out ring by ring.

    A spiral goes from a ring to the next one out in turns, and round the last one; where rings part or go round a boss
    it is a ring again. A ring that no straight line within the region leads to (round a boss) becomes a cut of its own,
    with a ramp along itself as the way down.
    """
    core = rings[0].core
    line = core if core is not None and len(core) == 2 else None
    curves: list[list[Piece]] = [] if line is None else [[Polyline(line)]]
    position = None if core is None else core[-1]
    ahead = None if line is None else _unit(line[1] - line[0])
    winds = [spiral and _winds(job, rings, k) for k in range(len(rings))] + [False]
    alone: list[Cut] = []
    for k, ring in enumerate(rings):
        contours = offsets.boundary_curves(ring.polygon, clockwise=not job.climb)
        for curve in outlines.with_detours(contours, ring.missed):
            near = outlines.starting_near(curve, position, ahead) if position is not None else curve
            if winds[k] and position is not None:
                curves.append([offsets.spiral_turn(rings[k - 1].polygon, near, position, SPIRAL_PIECES)])
                position = near[0].start
                if winds[k + 1]:
                    continue
            if position is not None and not offsets.line_inside(root.polygon, position, near[0].start):
                alone.append((_ramp_on(job, near), [near]))
                continue
            curves.append(near)
            position = near[-1].end
    return [(_way_down(job, root, core, curves), curves), *alone] if curves else alone


def _way_down(job: Job, root: Ring, core: Floats | None, curves: list[list[Piece]]) -> Entry:
    """Return the way down to where curves begin: the middle of a leaf where it has one."""
    first = curves[0][0]
    start = first.start if core is None else core[0]
    direction = (first.end if core is not None and len(core) == 2 else first.start) - start
    if elementary.length(direction) < 1e-9:
        direction = np.diff(polyline_of(first, 1e-3).points[:2], axis=0)[0]
    return choose(job, start, _unit(direction), curves[0], root.polygon)


def _winds(job: Job, rings: list[Ring], k: int) -> bool:
    """Tell whether a spiral goes from the ring before to ring k, which no place is missed between."""
    return k > 0 and not rings[k].missed and _follows(job, rings[k - 1], rings[k])


def _follows(job: Job, inner: Ring, outer: Ring) -> bool:
    """Tell whether a spiral can go from one ring to the other and leaves nothing between its turns.

    Nothing else may lie within the outer ring, and the tool must reach from it to the inner one everywhere: where a
    narrow part of the pocket has no inner ring it does not.
    """
    alone = len(outer.children) == 1 and outer.children[0] is inner
    if not alone or inner.polygon.interiors or outer.polygon.interiors:
        return False
    return offsets.lag(inner.polygon, outer.polygon) <= 2 * job.radius


def _unit(vector: Floats) -> Floats:
    return np.asarray(vector / elementary.length(vector))


def _ramp_on(job: Job, curve: list[Piece]) -> Entry:
    return ramp(job, curve[0].start, curve)


def _line_cuts(job: Job, root: Ring, step: float, closed: Polygon) -> list[Cut]:
    """Return lines across the pocket, each stretch a cut of its own where the way to it is barred, then the contours.

    A cut that begins beside the material (`closed`, the given outline) begins with a plunge.
    """
    all_open = len(job.shape.open_sides) == len(job.shape.outline or ())
    runs = _runs(job, root, step, contoured=not all_open)
    cuts: list[Cut] = []
    for run in runs:
        path: list[Piece] = [Polyline(np.stack(run))]
        free = job.shape.open_sides and offsets.distance_to(closed, run[0]) >= job.radius - 1e-9
        entry = plunge(run[0]) if free else choose(job, run[0], _unit(run[1] - run[0]), path, root.polygon)
        cuts.append((entry, [path]))
    contours = offsets.boundary_curves(root.polygon, not job.climb)
    for curve in contours[1:] if all_open else contours:
        near_curve = outlines.starting_near(curve, runs[-1][-1]) if runs else curve
        cuts.append((_ramp_on(job, near_curve), [near_curve]))
    return cuts


def _runs(job: Job, root: Ring, step: float, contoured: bool) -> list[list[Floats]]:
    """Return the points of lines across a region that follow each other without leaving it, to and fro or one way.

    Where the region's contour is cut too (`contoured`), lines shorter than the tool's radius are left to it.
    """
    strategy = job.operation.strategy
    values = strategy.values if strategy else {}
    one_way = strategy is not None and strategy.kind == "unidirectional"
    x, y = (1.0, 0.0) if values.get("feed_direction") is None else values["feed_direction"][:2]
    along = np.array([x, y, 0.0])
    if elementary.length(along) < 1e-9:
        raise job.fault("stepnc-geometry", "the feed direction is across the pocket")
    along = _unit(along)
    across = job.stepover(along)
    runs: list[list[Floats]] = []
    forward = True
    for row in offsets.chords(root.polygon, along, across, step):
        for stretch in row if forward else row[::-1]:
            a, b = stretch if forward else stretch[::-1]
            if contoured and float(elementary.length(b - a)) < job.radius:
                continue  # between two walls so close that going along them cuts it
            near = runs and not one_way and offsets.line_inside(root.polygon, runs[-1][-1], a)
            if near and len(row) == 1:
                runs[-1] += [a, b]
            else:
                runs.append([a, b])
        forward = one_way or not forward
    return runs
