"""Toolpaths of turning (ISO 14649-12) outside of a bar: facing, contouring, grooves and threads.

All is planned in the plane of u and r: r is the radius, u runs along the axis of the work against the feed, so that the tool goes
towards lower u. A position is that of the tool's corner where its two edges would meet were they not rounded: the lowest r and the
lowest u that it touches. Of a tool for grooves it is its corner at the lowest u.

The material left on a bar is kept from one workingstep to the next (`Bar`), so that rapid motions stay outside of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.features.job import Floats, Job, Moves
from cncgen.stepnc.features.outlines import QUARTER, refit
from cncgen.stepnc.geometry.chords import polyline_of
from cncgen.stepnc.geometry.frames import Matrix, apply
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline
from cncgen.stepnc.geometry.solids import Solid
from cncgen.stepnc.model import CutterPath

if TYPE_CHECKING:
    from shapely import Polygon
    from shapely.geometry.base import BaseGeometry

#: Distance from the bar at which the tool moves in rapid, mm, and by which it is lifted off where no lift_height is given.
CLEAR = 2.0
LIFT = 0.5
#: Material in front of a feature that is cut with it, mm; more has to be faced first.
MAX_EXCESS = 5.0
#: Chords of arcs, mm; they become arcs again.
CHORD = 2e-5
#: Beyond everything, mm.
FAR = 1e4
#: Coordinates alike, mm.
SAME = 1e-6
#: Depth by which a tool as wide as its groove may touch the walls, mm.
TOUCH = 1e-7
#: Passes of one operation.
MAX_PASSES = 5000
#: How much of its width a tool for grooves steps aside, at most.
SIDE_STEP = 0.8
#: Height of a thread in pitches (ISO 68-1: 17/24 of that of the triangle), and how many turns the spindle has to get in step.
THREAD_HEIGHT = 17 / 24 * math.sqrt(3) / 2
RUN_IN = 3.0


@dataclass(slots=True)
class Bar:
    """The half section of a bar: a shapely region of Z and radius, as it is seen from the machine."""

    region: BaseGeometry

    @classmethod
    def of(cls, raw: Solid) -> Bar:
        """Return the section of a raw piece; a block counts as the cylinder round it."""
        from shapely import box

        low, high = raw.reach(np.zeros(3), np.array([0.0, 0.0, 1.0]))
        if raw.kind == "cylinder" and abs(abs(raw.frame[2, 2]) - 1.0) < 1e-9:
            radius = raw.size[0] + math.hypot(raw.frame[0, 3], raw.frame[1, 3])
        else:
            reach = [raw.reach(np.zeros(3), np.eye(3)[k]) for k in (0, 1)]
            radius = math.hypot(*(max(abs(a), abs(b)) for a, b in reach))
        return cls(box(low, 0.0, high, radius))


@dataclass(frozen=True, slots=True)
class _Lathe:
    """A turning operation in the plane of u and r.

    Attributes:
        job: The work.
        bar: The material before it, None where it is not known.
        sense: u = sense · z of the machine.
        contour: Profile of the feature, in (u, r, 0), from the highest u down.
        nose: Radius of the tool's corner, mm.
    """

    job: Job
    bar: Bar | None
    sense: float
    contour: list[Piece]
    nose: float

    @property
    def points(self) -> Floats:
        """The profile as chords, shape (n, 2)."""
        chains = [polyline_of(p, CHORD).points[:, :2] for p in self.contour]
        return np.concatenate([chains[0][:1], *(c[1:] for c in chains)])

    def bounds(self) -> tuple[float, float, float]:
        """Return lowest u, highest u and largest r of bar and contour, mm."""
        points = self.points[self.points[:, 1] < FAR / 2]
        low, high, top = float(points[:, 0].min()), float(points[:, 0].max()), float(points[:, 1].max())
        if self.bar is None or self.bar.region.is_empty:
            return low, high, top
        a, _, b, r = self.bar.region.bounds
        ends = a * self.sense, b * self.sense
        return min(low, *ends), max(high, *ends), max(top, r)

    def taken(self, region: BaseGeometry) -> None:
        """Note that a region of (u, r) is no longer there."""
        if self.bar is not None:
            from shapely import affinity

            self.bar.region = self.bar.region.difference(
                affinity.scale(region, self.sense, 1.0, origin=(0, 0))
            )

    def begin(self, u: float, r: float) -> Moves:
        """Return moves that begin at a place."""
        return Moves(self.job.operation.ident, np.array([u, r, 0.0]))

    @property
    def allowance(self) -> float:
        """Material that is to stay on the profile, mm; raises `Skip` below 0."""
        given = self.job.value("allowance", 0.0)
        if given < 0:
            raise self.job.fault("stepnc-range", f"allowance is {given:g} mm; it must not be negative")
        return given

    @property
    def rough(self) -> bool:
        """Whether the operation roughs."""
        return self.job.operation.kind.endswith("rough")

    @property
    def lift(self) -> float:
        """How far the tool is lifted off, mm."""
        return self.job.strategy_value("lift_height", 0.0) or LIFT

    @property
    def overcut(self) -> float:
        """How far the tool goes beyond the end of a feature, mm."""
        return max(self.job.strategy_value("overcut_length", 0.0), 0.0)

    def depths(self, whole: float) -> list[float]:
        """Return how deep each pass lies below the first surface, mm: the cutting depths, the last of them repeated.

        Raises:
            Skip: where no depth is given, or there are too many.
        """
        strategy = self.job.operation.strategy
        given = strategy.values.get("cutting_depth", ()) if strategy else ()
        if not isinstance(given, tuple):
            given = (given,)
        if not given or not min(given) > 0:
            text = "roughing needs a strategy with cutting_depth, each of them above 0"
            raise self.job.fault("stepnc-missing", text, hint="UNIDIRECTIONAL_TURNING($,.T.,(2.0),$,…)")
        once = strategy is not None and strategy.values.get("allow_multiple_passes") is False
        if once and given[0] < whole - SAME:
            text = f"{whole:g} mm are to be cut {given[0]:g} mm deep, and allow_multiple_passes is false"
            raise self.job.fault("stepnc-depth", text)
        if (whole - sum(given)) / given[-1] > MAX_PASSES:
            raise self.job.fault(
                "stepnc-depth", f"passes {given[-1]:g} mm deep are too many; at most {MAX_PASSES}"
            )
        out: list[float] = []
        at, k = 0.0, 0
        while at < whole - SAME:
            at = min(at + given[min(k, len(given) - 1)], whole)
            out.append(at)
            k += 1
        return out


def make(job: Job, feature: str, frame: Matrix, bar: Bar | None) -> tuple[CutterPath, ...]:
    """Return the toolpaths of a turning operation, in the frame of its workingstep.

    Args:
        job: The work.
        feature: Its kind.
        frame: Of the workingstep, seen from the machine, whose Z is the axis of the work.
        bar: The rest of the raw piece, or None; it is cut.

    Raises:
        Skip: where they cannot be made, which is reported.
    """
    kind = job.operation.kind.removesuffix(" rough").removesuffix(" finish")
    way = _WAYS.get(kind)
    if way is None or job.shape.contour is None:
        text = f"no toolpath can be made for {kind} of a {feature}"
        raise job.fault("stepnc-unsupported", text, hint="give the operation explicit toolpaths")
    if job.shape.inside:
        raise job.fault(
            "stepnc-unsupported", "the wall of a bore is not turned yet: material_side points outwards"
        )
    if frame[0, 0] < 1 - 1e-9 or abs(abs(frame[2, 2]) - 1) > 1e-9 or np.abs(frame[:2, 3]).max() > 1e-6:
        text = "the axis of the feature must be that of the spindle, X 0 Y 0 along Z, and its X that of the machine"
        raise job.fault("stepnc-geometry", text)
    _note_ignored(job)
    sense = _sense(job, frame, bar)
    plane = _plane(sense)
    turn = elementary.product(plane.T, frame)  # the plane is a rotation: its inverse is its transpose
    contour = [p.moved(turn) for p in job.shape.contour]
    if contour[0].start[0] < contour[-1].end[0]:
        contour = [p.reversed() for p in reversed(contour)]
    lathe = _Lathe(job, bar, sense, contour, job.tool.nose or 0.0)
    if min(lathe.points[:, 1]) < -SAME:
        raise job.fault("stepnc-geometry", "the profile crosses the axis of the work")
    back = elementary.product(np.asarray(np.linalg.inv(frame)), plane)
    return tuple(replace(p, pieces=_moved(p.pieces, back)) for p in way(lathe).paths())


def _moved(pieces: Callable[[], list[Piece]], frame: Matrix) -> Callable[[], list[Piece]]:
    return lambda: [p.moved(frame) for p in pieces()]


def _plane(sense: float) -> Matrix:
    """Return the frame of (u, r, 0) seen from the machine: u along Z or against it, r along X."""
    plane = np.eye(4)
    plane[:3, :3] = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, sense], [sense, 0.0, 0.0]])
    return plane


def _sense(job: Job, frame: Matrix, bar: Bar | None) -> float:
    """Return 1 where the tool feeds against Z of the machine, −1 where it feeds along it, or faces the rear end of the bar."""
    if job.operation.kind.startswith("facing") and bar is not None and job.shape.contour:
        low, _, high, _ = bar.region.bounds
        face = float(apply(frame, job.shape.contour[0].start[None, :])[0, 2])
        return 1.0 if high - face <= face - low else -1.0
    strategy = job.operation.strategy
    given = strategy.values.get("feed_direction") if strategy else None
    if isinstance(given, np.ndarray):
        along = elementary.product(frame[:3, :3], given)
        if abs(along[2]) > abs(along[0]):
            return -1.0 if along[2] > 0 else 1.0
        if job.operation.kind.startswith("contouring rough"):
            raise job.fault("stepnc-unsupported", "roughing of a contour feeds along the axis, not across it")
        if along[0] > 0:
            raise job.fault("stepnc-unsupported", "a feed_direction away from the axis is not made; -X is")
    return -1.0 if job.tool.left_handed else 1.0


def _note_ignored(job: Job) -> None:
    """Warn of what a strategy asks and is not done."""
    strategy = job.operation.strategy
    asked = [
        n for n in ("lift_feed", "stepover_feed", "variable_feedrate") if strategy and strategy.values.get(n)
    ]
    if asked:
        job.warn("stepnc-speed", f"{', '.join(asked)} of the strategy: the feed of the technology holds")
    if job.operation.approach is not None or job.operation.retract is not None:
        text = f"the tool comes and goes beside the bar, {CLEAR:g} mm away from it, not as approach and retract ask"
        job.warn("stepnc-approach", text)


# Facing


def _face(lathe: _Lathe) -> Moves:
    """Return the moves of FACING: passes across the axis, one behind the other."""
    job, points = lathe.job, lathe.points
    if np.ptp(points[:, 0]) > SAME:
        raise job.fault(
            "stepnc-unsupported",
            "facing is for a flat face across the axis; a contouring operation can turn it",
        )
    face, hub = float(points[0, 0]) + lathe.allowance, float(points[:, 1].min())
    hub += lathe.allowance if hub > SAME else 0.0
    _, end, top = lathe.bounds()
    inner = hub if hub > SAME else -lathe.nose - lathe.overcut
    levels = [face]
    if lathe.rough:
        if lathe.bar is None:
            raise job.fault(
                "stepnc-missing", "roughing needs the raw piece: its_rawpiece with its_bounding_geometry"
            )
        levels = [end - d for d in lathe.depths(end - face)] or [face]
    out = top + CLEAR
    moves = lathe.begin(levels[0], out)
    for level in levels:
        moves.rapid(np.array([level, out, 0.0]))
        moves.feed(np.array([level, inner, 0.0]))
        moves.feed(np.array([level + lathe.lift, inner, 0.0]))
        moves.rapid(np.array([level + lathe.lift, out, 0.0]))
    from shapely import box

    lathe.taken(box(face, max(hub, 0.0) if hub > SAME else -1.0, FAR, FAR))
    return moves


# Contours


def _keep(lathe: _Lathe, far: float) -> Polygon:
    """Return what the tool's corner must not enter, in (u, r): the profile, level in front of it and a wall behind it."""
    from shapely import Polygon, affinity

    points = lathe.points
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
        raise lathe.job.fault(
            "stepnc-geometry", "the profile undercuts itself: some radius has two places along the axis"
        )
    grown = (
        polygon.buffer(lathe.allowance + lathe.nose, quad_segs=QUARTER)
        if lathe.allowance + lathe.nose > 0
        else polygon
    )
    return affinity.translate(grown, -lathe.nose, -lathe.nose)


def _along(keep: Polygon, start: float, top: float) -> list[Piece]:
    """Return the boundary of a polygon from where it comes down to `start` along u to where it rises above `top`."""
    from shapely.geometry.polygon import orient

    ring = np.array(orient(keep).exterior.coords)
    pieces = [s for p in refit(ring) for s in _segments(p)]
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


def _segments(piece: Piece) -> list[Piece]:
    """Return the lines of a polyline one by one; other pieces as they are."""
    if not isinstance(piece, Polyline):
        return [piece]
    return [Polyline(piece.points[k : k + 2]) for k in range(len(piece.points) - 1)]


def _check_falls(lathe: _Lathe, bar_known: bool) -> None:
    """Raise `Skip` where the profile falls, in the direction of the feed, more steeply than the tool's trailing edge lets it.

    Roughing cuts what lies behind a hump in one pass, so a hollow may be at most one pass deep.
    """
    points, job = lathe.points, lathe.job
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
    if lathe.rough and bar_known:
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


def _start(lathe: _Lathe) -> float:
    """Return where the tool begins to feed along the axis: in front of all that stands before the profile.

    Raises:
        Skip: where more stands there than is cut with the feature.
    """
    from shapely import affinity, box

    begin, radius = float(lathe.points[0, 0]), float(lathe.points[0, 1])
    if lathe.bar is None:
        return begin + CLEAR
    seen = affinity.scale(lathe.bar.region, lathe.sense, 1.0, origin=(0, 0))
    stands = seen.intersection(box(begin + SAME, radius + SAME, FAR, FAR))
    if stands.is_empty or stands.area < 1e-3:
        return begin + CLEAR
    excess = float(stands.bounds[2]) - begin
    text = f"{excess:.4g} mm of material stand in front of the feature"
    if excess > MAX_EXCESS:
        raise lathe.job.fault(
            "stepnc-geometry", f"{text}; at most {MAX_EXCESS:g} mm are cut with it", hint="face the bar first"
        )
    lathe.job.warn("stepnc-depth", f"{text}, and are cut with it")
    return begin + excess + CLEAR


def _contour(lathe: _Lathe) -> Moves:
    """Return the moves of CONTOURING: of roughing passes along the axis, then once along the profile."""
    from shapely import LineString, Polygon, affinity

    job = lathe.job
    _check_falls(lathe, lathe.bar is not None)
    start = _start(lathe)
    keep = _keep(lathe, start)
    low, _, top = lathe.bounds()
    out = top + CLEAR
    way = _along(keep, start, out)
    if not way:
        raise job.fault("stepnc-geometry", "no path along the profile can be made")
    moves = lathe.begin(start, out)
    if lathe.rough:
        if lathe.bar is None:
            raise job.fault(
                "stepnc-missing", "roughing needs the raw piece: its_rawpiece with its_bounding_geometry"
            )
        deepest = min(float(p.start[1]) for p in way)
        for depth in lathe.depths(max(top - deepest, 0.0))[:-1]:
            level = top - depth
            free = LineString([(start, level), (low - FAR, level)]).difference(keep)
            parts = [g for g in getattr(free, "geoms", [free]) if not g.is_empty]
            first = max(parts, key=lambda g: g.bounds[2], default=None)
            if first is None or first.bounds[2] < start - SAME:
                continue  # lower than where the profile begins: the last way along it cuts that hollow
            hit = float(first.bounds[0])
            moves.rapid(np.array([start, level, 0.0]))
            lifted = np.array([hit + lathe.lift, level + lathe.lift, 0.0])
            moves.feed(np.array([hit, level, 0.0]), lifted)
            moves.rapid(np.array([start, level + lathe.lift, 0.0]))
    moves.rapid(way[0].start)
    moves.follow(way)
    points = lathe.points
    # Behind the wall the bar stays; in front of the profile it is cut as far as that begins.
    gone = Polygon([(start + FAR, points[0, 1]), *points.tolist(), (points[-1, 0], FAR), (start + FAR, FAR)])
    lathe.taken(gone.difference(affinity.translate(keep, lathe.nose, lathe.nose).buffer(-lathe.nose)))
    return moves


# Grooves


def _blade(lathe: _Lathe) -> tuple[Polygon, float]:
    """Return where the left corner of a tool for grooves must not go, in (u, r), and the tool's width, mm."""
    from shapely import MultiPoint, Polygon, affinity, unary_union

    job, points = lathe.job, lathe.points
    width = job.tool.width
    if width is None or not width > 0:
        raise job.fault(
            "stepnc-missing", "a groove needs the width of its tool: GROOVING_TOOL with cutting_width"
        )
    nose = min(lathe.nose, width / 2)
    ring = [(FAR, FAR), *points.tolist(), (-FAR, FAR), (-FAR, -2 * FAR), (FAR, -2 * FAR)]
    keep = Polygon(ring)
    if not keep.is_valid:
        raise job.fault("stepnc-geometry", "the section of the groove crosses itself")
    grown = keep.buffer(lathe.allowance + nose, quad_segs=QUARTER) if lathe.allowance + nose > 0 else keep
    slide = max(width - 2 * nose - 2 * TOUCH, 0.0)
    edges = np.array(grown.exterior.coords)
    # The tool's level end sweeps what lies left of the polygon, as far as it is wide.
    swept = [
        MultiPoint([a, b, (a[0] - slide, a[1]), (b[0] - slide, b[1])]).convex_hull
        for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
    ]
    whole = unary_union([grown, affinity.translate(grown, -slide), *swept]) if slide > 0 else grown
    return affinity.translate(whole, -nose - TOUCH, -nose), width


def _groove(lathe: _Lathe) -> Moves:
    """Return the moves of GROOVING: plunges side by side, or once round the walls and floor."""
    from shapely import LineString, Polygon

    job = lathe.job
    keep, width = _blade(lathe)
    if lathe.bar is None:
        raise job.fault(
            "stepnc-missing", "a groove needs the raw piece: its_rawpiece with its_bounding_geometry"
        )
    points = lathe.points
    middle = float(np.median(points[:, 0]))
    top = _surface(lathe, middle, job.shape.width or width)
    if top <= float(points[:, 1].min()) + SAME:
        text = f"the bar has a radius of {top:g} mm there, and the groove's bottom one of {points[:, 1].min():g} mm"
        raise job.fault("stepnc-depth", f"nothing is left to cut: {text}")
    opening = LineString([(middle - FAR / 2, top), (middle + FAR / 2, top)]).difference(keep)
    parts = [g.bounds for g in getattr(opening, "geoms", [opening]) if not g.is_empty]
    if not parts:
        text = f"a tool {width:g} mm wide does not enter the groove"
        text += f" of {job.shape.width:g} mm" if job.shape.width else ""
        text += f" with an allowance of {lathe.allowance:g} mm" if lathe.allowance else ""
        raise job.fault("stepnc-tool-size", text)
    left, right = parts[0][0], parts[0][2]
    depth = top - float(points[:, 1].min())
    if job.tool.cutting_length and depth > job.tool.cutting_length + SAME:
        text = f"the groove is {depth:g} mm deep, and the tool reaches {job.tool.cutting_length:g} mm"
        raise job.fault("stepnc-tool-size", text)
    out = lathe.bounds()[2] + CLEAR
    moves = lathe.begin(right, out)
    moves.rapid(np.array([right, top + CLEAR, 0.0]))
    if lathe.rough:
        _plunge(lathe, moves, keep, (left, right), top)
    else:
        moves.follow(_round(keep, (left, right), top + CLEAR))
    moves.rapid(np.array([moves.position[0], out, 0.0]))
    region = Polygon(points)
    lathe.taken(region.buffer(-lathe.allowance) if lathe.allowance else region)
    return moves


def _surface(lathe: _Lathe, middle: float, width: float) -> float:
    """Return the largest radius of the bar round a place, `width` mm to each side."""
    from shapely import affinity, box

    seen = affinity.scale(lathe.bar.region, lathe.sense, 1.0, origin=(0, 0)) if lathe.bar else box(0, 0, 0, 0)
    there = seen.intersection(box(middle - width, 0.0, middle + width, FAR))
    return float(there.bounds[3]) if not there.is_empty else 0.0


def _dwell(lathe: _Lathe, moves: Moves) -> None:
    """Wait as the operation asks."""
    moves.dwell(lathe.job.value("dwell", 0.0))
    moves.dwell_turns(lathe.job.value("dwell_turns", 0.0))


def _floor_at(keep: Polygon, u: float, top: float) -> float:
    """Return how deep a tool may plunge at a place, mm."""
    from shapely import LineString

    free = LineString([(u, top), (u, -FAR)]).difference(keep)
    return float(max(getattr(free, "geoms", [free]), key=lambda g: g.bounds[3]).bounds[1])


def _plunge(lathe: _Lathe, moves: Moves, keep: Polygon, opening: tuple[float, float], top: float) -> None:
    """Plunge side by side over an opening, each time in as many steps as the strategy has depths."""
    job = lathe.job
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
        steps = lathe.depths(whole) if strategy and strategy.values.get("cutting_depth") else [whole]
        for depth in steps:
            moves.feed(np.array([u, top - depth, 0.0]))
            if depth < steps[-1]:
                moves.rapid(np.array([u, min(top - depth + back, out) if back > 0 else out, 0.0]))
                if back <= 0:
                    moves.rapid(np.array([u, top - depth + LIFT, 0.0]))
        _dwell(lathe, moves)
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
    pieces = (s for p in refit(ring) for s in _segments(p))
    return [p for p in pieces if min(p.start[1], p.end[1]) < top - SAME]


# Threads


def _thread(lathe: _Lathe) -> Moves:
    """Return the moves of THREADING: passes in step with the spindle, each deeper.

    Depths are those of the strategy, or grow with the square root of the number of the pass, so that each takes as much
    (CONSTANT_REMOVAL_AMOUNT). Without a minor diameter the thread is as high as a metric one (ISO 68-1).
    """
    job, shape = lathe.job, lathe.job.shape
    pitch = abs(shape.pitch) if shape.pitch is not None else job.tool.pitch
    if pitch is None or not pitch > 0:
        raise job.fault("stepnc-missing", "a thread needs its pitch: number_of_threads, or that of the tool")
    if shape.pitch is not None and job.tool.pitch is not None and abs(job.tool.pitch - pitch) > 1e-3:
        text = f"the tool has a pitch of {job.tool.pitch:g} mm and the thread one of {pitch:g} mm"
        raise job.fault("stepnc-pitch", text)
    strategy = job.operation.strategy
    asked = str(strategy.values.get("threading_direction", "")).upper() if strategy else ""
    if (shape.pitch or 1.0) < 0 or asked.startswith("LEFT"):
        raise job.fault("stepnc-unsupported", "a left-handed thread is not turned; explicit toolpaths are")
    major = shape.thread or 2 * float(lathe.points[:, 1].max())
    minor = shape.diameter or major - 2 * THREAD_HEIGHT * pitch
    if not 0 < minor < major:
        raise job.fault("stepnc-geometry", f"the thread has diameters of {major:g} and {minor:g} mm")
    begin = float(lathe.points[0, 0])
    end = begin - shape.width if shape.width else float(lathe.points[-1, 0])
    moves_out = max(lathe.bounds()[2], major / 2) + CLEAR
    start = begin + RUN_IN * pitch
    height = (major - minor) / 2 - lathe.allowance
    angle = strategy.values.get("path_return_angle") if strategy else None
    moves = lathe.begin(start, moves_out)
    moves.at(_steady(job, major, pitch))
    for depth in _thread_depths(lathe, height):
        r = major / 2 - depth
        moves.rapid(np.array([start, r, 0.0]))
        leave = [np.array([end, r, 0.0])]
        if isinstance(angle, float) and 0 < angle < 90:
            run = (major / 2 + LIFT - r) / math.tan(math.radians(angle))
            leave = [np.array([end + run, r, 0.0]), np.array([end, major / 2 + LIFT, 0.0])]
        moves.thread(leave, pitch)
        moves.rapid(np.array([end, moves_out, 0.0]), np.array([start, moves_out, 0.0]))
    return moves


def _thread_depths(lathe: _Lathe, height: float) -> list[float]:
    """Return the depth of each pass below the major diameter, mm."""
    if not height > 0:
        raise lathe.job.fault(
            "stepnc-depth", f"nothing is left of the thread: its height less the allowance is {height:g} mm"
        )
    if not lathe.rough:
        return [height]
    depths = lathe.depths(height)
    strategy = lathe.job.operation.strategy
    if (
        strategy
        and str(strategy.values.get("cut_in_amount_function", "")).upper() == "CONSTANT_REMOVAL_AMOUNT"
    ):
        first = depths[0]
        count = math.ceil((height / first) ** 2 - 1e-9)
        depths = [min(first * math.sqrt(k + 1), height) for k in range(count)]
    return depths


def _steady(job: Job, diameter: float, pitch: float) -> Any:
    """Return the technology of a thread: a spindle speed that does not change, and the pitch as the feed."""
    technology = job.technology
    speed = technology.spindle
    if speed is None and technology.cutting_speed is not None:
        speed = -technology.cutting_speed / (math.pi * diameter)
        if technology.max_spindle:
            speed = -min(-speed, abs(technology.max_spindle))
        text = f"a thread needs a spindle that keeps its speed: {-speed * 60:.4g} a minute, that of its major diameter"
        job.warn("stepnc-speed", text)
    if not speed:
        raise job.fault("stepnc-missing", "threading needs a spindle speed above 0")
    per_turn = technology.feed_per_rev if technology.feed is None else technology.feed / abs(speed)
    if per_turn is not None and abs(per_turn - pitch) > 1e-3 * pitch:
        job.warn(
            "stepnc-pitch",
            f"the feed makes {per_turn:.4g} mm a turn, and the thread has a pitch of {pitch:g} mm; the pitch counts",
        )
    return replace(technology, spindle=speed, cutting_speed=None, feed=pitch * abs(speed), feed_per_rev=None)


_WAYS: dict[str, Callable[[_Lathe], Moves]] = {
    "facing": _face,
    "contouring": _contour,
    "grooving": _groove,
    "threading": _thread,
}
