"""Soft approach and retraction: G147, G247, G347 and G148, G248, G348 (840D sl, Fundamentals, "Smooth approach and retraction").

P0 is where the tool stands before the block, P4 the first point of the contour, P3 where the line, quadrant or semicircle to it begins,
P2 the height DISCL above it. To P2 the tool goes as before the block, from there to P3 (G341), or on a helix from P3 (G340), at FAD.
A retraction is the same the other way. With DISR for the path of the tool's middle, the programmed arc is larger by the tool's radius.
"""

from __future__ import annotations

import cmath
import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cncgen.gcode.block import AXES
from cncgen.gcode.codes.compensated_sink import CompensatedSink
from cncgen.gcode.codes.corners import tried_motion
from cncgen.gcode.codes.cutter_compensation import feed_along_contour
from cncgen.gcode.codes.leads import lead_arc, lead_line
from cncgen.gcode.codes.turning_profiles import Segment
from cncgen.gcode.errors import BlockError
from cncgen.gcode.sinumerik.arcs import follow
from cncgen.gcode.state.modal import in_plane

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions, Words
    from cncgen.gcode.text.labels import Cursor

#: Codes that approach and retract, and how many quarters of a circle their arc has.
APPROACH, RETRACT = {147: 0, 247: 1, 347: 2}, {148: 0, 248: 1, 348: 2}
CODES = APPROACH.keys() | RETRACT.keys()
_WORDS = ("DISR", "DISCL", "DISRP", "FAD")
_TINY = 1e-9


@dataclass(slots=True)
class Soft:
    """The words of a block about an approach or a retraction.

    Attributes:
        code, radius, height, feed: The code, DISR, DISCL or None, FAD or 0.
        in_plane: Whether the way beside the contour has its height (G341), or changes it (G340).
        side: From the left (1) or right (-1) of the contour, from where the tool is (0), or as G41 and G42 have it (2).
        begin: Where the tool stands before it.
        before: Motion and feed of the block before.
        here: The block.
        placed: Whether the contour's first point is known.
    """

    code: int
    radius: float
    height: tuple[str, float] | None
    feed: float
    in_plane: bool
    side: int
    begin: list[float]
    before: tuple[str, float]
    here: Cursor
    placed: bool = False

    def fault(self, what: str, word: str = "", hint: str = "") -> BlockError:
        """Return a fault of the block."""
        name = word or f"G{self.code}"
        hint = hint or "G41 G247 DISR=10 DISCL=5 X Y Z begins a contour"
        return BlockError("soft-approach", f"G{self.code} {what}", name, hint=hint)

    def level(self, floor: float, outer: float) -> float:
        """Return the height between a floor and where the tool comes from at which the slow infeed begins."""
        if self.height is None:
            return floor
        mode, value = self.height
        height = value if mode == "AC" else floor + (value if outer >= floor else -value)
        return min(max(height, min(floor, outer)), max(floor, outer))


def of(motions: Motions, words: Words) -> Soft | None:
    """Return what a block says of an approach or a retraction, taking its words; None where it has none; raise where there are two codes, or no DISR above 0."""
    codes = [code for code in words.g if code in CODES]
    if not codes:
        return None
    found = {name: words.named.pop(name) for name in _WORDS if name in words.named}
    radius = found.get("DISR", ("", 0.0))[1]
    now = motions.ip.state.position.copy(), motions.before, motions.here
    height, feed = found.get("DISCL"), found.get("FAD", ("", 0.0))[1]
    feed *= motions.feed_scale
    soft = Soft(codes[0], radius, height, feed, motions.soft_in_plane, motions.soft_side, *now)
    if len(codes) > 1 or radius <= 0.0:
        what = "stands beside another one" if len(codes) > 1 else f"has DISR={radius:g}"
        raise soft.fault(what, "DISR", "DISR is the radius of the arc, or the length of the line, above 0")
    if "DISRP" in found:
        raise soft.fault("has DISRP, a retraction plane, which is not read", "DISRP", "leave DISRP out")
    return soft


def approach(motions: Motions, soft: Soft, words: Words) -> None:
    """Keep an approach until the contour's first motion tells its direction; P4 is the block's end, or the end of the next block."""
    first, second, _ = motions.plane()
    soft.placed = bool({AXES[first].upper(), AXES[second].upper()} & words.axes.keys())
    end = motions.end_of(words)
    words.axes.clear()
    motions.ip.state.position = end
    motions.soft = soft


def take_next(motions: Motions, words: Words, end: list[float]) -> bool:
    """Take the motion behind an approach; tell whether it only says where the contour begins."""
    soft = motions.soft
    assert soft is not None
    state = motions.ip.state
    if not soft.placed:
        soft.placed = True
        state.position = end
        words.axes.clear()
        return True
    motions.soft = None
    place = state.position.copy()
    segment = _tried(motions, words, end)
    if segment is None:
        state.position = soft.begin
        raise soft.fault("is not followed by a motion in the plane")
    state.position = soft.begin.copy()
    here, motions.here = motions.here, soft.here
    _lead(motions, soft, place, segment)
    motions.here = here
    return False


def _lead(motions: Motions, soft: Soft, place: list[float], segment: Segment) -> None:
    """Lead the tool to the contour's first point and motion."""
    first, second, normal = motions.plane()
    path = _arc(
        motions, soft, in_plane(place, motions.ip.state.plane), segment.heading(segment.start), on=True
    )
    floor, outer = place[normal], soft.begin[normal]
    low = soft.level(floor, outer)
    feed = motions.ip.state.feed
    _as_before(motions, soft, {first: path.start.real, second: path.start.imag})
    _as_before(motions, soft, {normal: low})
    slow = soft.feed or feed
    if slow <= 0.0:
        message = f"G{soft.code} has no feed: neither FAD nor F"
        raise BlockError("feed-missing", message, "F", hint="F feeds on the arc")
    if soft.in_plane and abs(low - floor) > _TINY:
        motions.emit({"f": slow, AXES[normal]: floor}, (10,))
    if feed and (soft.in_plane or not soft.feed):
        slow = feed
    motions.emit({"f": slow})
    _follow(motions, path, floor)
    if feed:
        motions.emit({"f": feed})


def retract(motions: Motions, soft: Soft, words: Words) -> None:
    """Leave the contour, go up to DISCL, and to the end of the block; G40 of the block ends compensation behind the arc."""
    first, second, normal = motions.plane()
    way = in_plane(motions.heading, motions.ip.state.plane) if motions.heading else 0j
    end = motions.end_of(words)
    moved = {AXES[k].upper() for k in (first, second)} & words.axes.keys()
    words.axes.clear()
    if abs(way) < _TINY:
        raise soft.fault("does not stand behind a motion in the plane")
    place = motions.ip.state.position
    floor = place[normal]
    high = soft.level(floor, end[normal]) if end[normal] != floor else floor
    path = _arc(motions, soft, motions.here_in_plane(), way / abs(way), on=False)
    feed, old = motions.ip.state.feed, soft.before[1] or motions.ip.state.feed
    if old <= 0.0:
        raise BlockError("feed-missing", f"G{soft.code} has no feed", "F", hint="F feeds on the arc")
    motions.emit({"f": old})
    _follow(motions, path, floor if soft.in_plane else high)
    if soft.in_plane and abs(high - floor) > _TINY:
        motions.emit({"f": soft.feed or old, AXES[normal]: high}, (10,))
    if feed:
        motions.emit({"f": feed})
    rapid = motions.motion == "G0"
    motions.move({AXES[normal]: end[normal]}, rapid=rapid)
    if 40 in words.g:
        motions.emit({}, (400,))
    if moved:
        motions.move({AXES[k]: end[k] for k in (first, second)}, rapid=rapid)
    motions.heading = None


def _as_before(motions: Motions, soft: Soft, place: dict[int, float]) -> None:
    """Go to a place as the block before moved."""
    rapid = soft.before[0] == "G0" or soft.before[1] <= 0.0
    if not rapid:
        motions.emit({"f": soft.before[1]})
    motions.move({AXES[k]: value for k, value in place.items()}, rapid=rapid)


def _follow(motions: Motions, path: Segment, height: float) -> None:
    """Feed along the line or arc between P3 and P4, to a height. The arc is that of the tool's centre, and so is its feed."""
    arcs = motions.ip.contour_feed
    feed_along_contour(motions.ip, "")
    follow(motions, path.end, path.centre, path.spin, height)
    feed_along_contour(motions.ip, arcs)


def _arc(motions: Motions, soft: Soft, point: complex, heading: complex, *, on: bool) -> Segment:
    """Return the programmed line or arc from P3 to the contour's point P4, or away from it.

    The tool's middle is left (s = 1) or right (-1) of the contour by its radius; the centre of its arc lies DISR beside it on the side of
    the approach, and is that of the programmed arc too.
    """
    sink = motions.ip.sink
    radius = sink.centre.radius if isinstance(sink, CompensatedSink) else 0.0
    tool = {41: 1, 42: -1}.get(motions.ip.state.compensation, 0)
    quarters = (APPROACH if on else RETRACT)[soft.code]
    if not quarters:
        return lead_line(point, heading, soft.radius + radius, leaving=not on)
    away = in_plane(soft.begin, motions.ip.state.plane) - point
    side = tool if soft.side == 2 else soft.side or (1 if (away * heading.conjugate()).imag >= 0.0 else -1)
    if not side:
        raise soft.fault(
            "takes its side from G41 or G42, and none is in force",
            hint="G141 approaches from the left, G142 from the right",
        )
    beside = tool * radius + side * soft.radius
    if beside * side <= _TINY:
        what = f"has DISR={soft.radius:g}, and the tool, of the radius {radius:g}, lies on the other side of the contour"
        raise soft.fault(what, "DISR", "make DISR larger")
    return lead_arc(point, heading, beside, cmath.pi / 2.0 * quarters, leaving=not on)


def _tried(motions: Motions, words: Words, end: list[float]) -> Segment | None:
    """Return the motion of a block in the plane, without making it."""
    ip, plane = motions.ip, motions.ip.state.plane
    start, kept = ip.state.position.copy(), motions.fields()
    try:
        found = tried_motion(ip, lambda: motions.make(copy.deepcopy(words), end.copy()), compensation=40)
    finally:
        motions.set_fields(kept)
    if found is None:
        return None
    segment = found.segment(start, plane)
    return None if segment.centre is None and segment.start == segment.end else segment
