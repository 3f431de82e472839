"""The sink of a check: counts motions and events, and keeps none of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from cncgen.gcode.block import AXES, Block
from cncgen.gcode.budget import CALL, MOTION, Budget
from cncgen.gcode.sinks.sink import Curve, MotionBatch, Point, refuse_uvw
from cncgen.gcode.state.modal import PLANE_AXES
from cncgen.ranges import KNOT_PART, WEIGHT_RATIO
from cncgen.toolpath.record import Event, PathMode

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

#: Time at slow feeds, or of waiting, beyond which another reading is named, s, and the feed that counts as slow here, units a minute.
LONG_S = 36_000.0
SLOW = 5.0
#: A rotary axis with roll-over goes a longer way than this the other way round, degrees, with room for rounding.
HALF_TURN = 180.0 + 1e-6
_ROTARY = slice(3, 6)
#: Places and offsets up to this, in units of the program, add up to places within `cncgen.ranges.POSITION`.
_NEAR = 1e6
#: A way of X Y Z that is less than this part of the turn beside it may leave them a feed below `cncgen.ranges.FEEDS`.
_CREEP = 1e-6
#: Tolerances up to this, in units of the program, are within `cncgen.ranges.TOLERANCE_MM`.
_WIDE = 1e4
#: How far within the bounds of `cncgen.ranges` the weights and knots of a curve are beyond doubt.
_DOUBTED = 2.0


class CountingSink:
    """Takes every call like `columns.ColumnsSink` and counts the rows of the toolpath."""

    wants_comments = False

    def __init__(self) -> None:
        self.block = Block({})
        self.budget = Budget()
        self.count = 0
        #: Whether a feed below 5 units a minute was seen, and for how long the program waits, s: both may make it longer than is meant.
        self.slow, self.waited = False, 0.0
        #: Whether a place, a centre or an offset is so far away that their sum may be beyond `cncgen.ranges.POSITION`, a tolerance so wide,
        #: a curve's weights or knots so far apart, or the feed of a line that turns an axis so small a part of F along X Y Z.
        self.far = False
        #: The way of a rotary axis, degrees, beyond which one is told, and whether one was longer.
        self.longest_turn, self.turned = math.inf, False
        self._rest: list[float] = []
        self._named: set[int] = set()
        #: Columns of axes that may have moved, in program coordinates or by a rotation, before a word of the main text named them.
        self.unnamed: set[int] = set()

    def motions(self, batch: MotionBatch) -> None:
        """Count a run of motions; their ends and some of their feeds are looked at."""
        count = len(batch.motion)
        self.count += count
        self.far = self.far or not batch.reach <= _NEAR
        for k in {0, count // 2, count - 1}:
            self.set_feed_rate(batch.feed[k])
        # Plain motions move the axes alone that words of their blocks name.
        last: Any = batch.end[count - 1 : count].tolist()
        end = last[0]
        self.turned = self.turned or batch.turn > self.longest_turn
        self.far = self.far or batch.creeps
        if batch.source != 0:
            self.unnamed.update(
                k for k in range(len(AXES)) if end[k] != self._rest[k] and k not in self._named
            )
        self._rest = end

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        """Count an arc; raise where it lies in a plane of U V W."""
        refuse_uvw(plane)
        self._one(end)
        self._reach((first, second))
        self.unnamed.update(set(PLANE_AXES[plane][:2]) - self._named)

    def rigid_tap(self, end: Point, pitch: float) -> None:
        """Count the way there and the way back, and the events that say that they go in step with the spindle."""
        self._one(end)
        self._one(end)
        self.count += 2

    def straight_probe(self, end: Point) -> None:
        """Count the line, and the event before it."""
        self._one(end)
        self.count += 1

    def synchronise(self, pitch: float | None) -> None:
        self.count += 1

    def call(self, text: str, event: Event | None = None) -> None:
        if event is not None:
            self.budget.spend(CALL)
            self.count += 1
            self.waited += event.dwell_s

    def set_feed_rate(self, rate: float) -> None:
        self.slow = self.slow or (rate != 0.0 and not rate >= SLOW)

    def where(self, position: Point) -> Point:
        self._rest = list(position)
        return position

    def _one(self, end: Point) -> None:
        self.budget.spend(MOTION)
        self.count += 1
        if end != self._rest:
            self._watch(end)

    def _watch(self, end: Point) -> None:
        """Note the axes that a motion names, and those that it moves without."""
        words = self.block.words if self.block.source == 0 else {}
        for k, letter in enumerate(AXES):
            if end[k] != self._rest[k] and k not in self._named:
                (self._named if letter in words else self.unnamed).add(k)
        for angle, rest in zip(end[_ROTARY], self._rest[_ROTARY], strict=True):
            self.turned = self.turned or abs(angle - rest) > self.longest_turn
        # The part of a feed along all axes that is left for X Y Z (else U V W).
        way = [abs(new - old) for new, old in zip(end, self._rest, strict=True)]
        linear = max(way[:3]) or max(way[6:])
        self.far = self.far or 0.0 < linear < _CREEP * max(way[_ROTARY])
        self._rest = list(end)
        self._reach(end)

    def _reach(self, point: Sequence[float]) -> None:
        """Look at a place or an offset."""
        self.far = self.far or not all(-_NEAR <= value <= _NEAR for value in point)

    def nurbs_feed(self, curve: Curve) -> None:
        """Count a curve, and look at its numbers."""
        for point in curve.points:
            self._reach(point)
        weights, knots = curve.weights, curve.knots
        span = min((after - one for one, after in pairwise(knots) if after > one), default=0.0)
        near = span >= _DOUBTED * KNOT_PART * (knots[-1] - knots[0])
        self.far = self.far or not (near and _DOUBTED * max(weights) <= WEIGHT_RATIO * min(weights))
        self._one(list(curve.points[-1]))

    def set_xy_rotation(self, degrees: float) -> None:
        """Take a rotation, which moves X with Y."""
        if degrees:
            self.unnamed.update((0, 1))

    straight_traverse = straight_feed = _one

    def _nothing(self, *arguments: object, **named: object) -> None:
        """Count nothing: the call only changes how motions are made."""

    def set_g5x_offset(self, system: int, offset: Point) -> None:
        """Look at an origin."""
        self._reach(offset)

    def set_motion_control_mode(self, mode: PathMode, tolerance: float | None, naive: float | None) -> None:
        """Look at a tolerance."""
        self.far = self.far or not (tolerance or 0.0) <= _WIDE

    place = use_tool_length_offset = set_g92_offset = _reach
    use_length_units = select_plane = set_inverse_time = set_surface_speed = set_lever = _nothing
    set_feed_mode = set_spindle = _nothing


class MovingSink(CountingSink):
    """Notes which axes move."""

    def __init__(self) -> None:
        super().__init__()
        #: Columns of the axes that moved.
        self.moved: set[int] = set()

    def motions(self, batch: MotionBatch) -> None:
        """Note the axes of a run of motions."""
        before = self._rest or len(AXES) * [0.0]
        for row in range(len(batch.motion)):
            after: Any = batch.end[row : row + 1].tolist()
            self._note(before, after[0])
            before = after[0]
        super().motions(batch)

    def _watch(self, end: Point) -> None:
        self._note(self._rest or len(AXES) * [0.0], end)
        super()._watch(end)

    def _note(self, before: Sequence[float], after: Sequence[float]) -> None:
        self.moved.update(k for k, (old, new) in enumerate(zip(before, after, strict=True)) if old != new)
