"""The sink that builds a toolpath: canonical motions in program coordinates become columns in machine mm and rad.

Single motions are gathered into a batch and go the same way as the batches of the fast lane: offsets, rotation and units are applied
to arrays when one of these changes or a chunk is full.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cncgen.gcode.block import AXIS_INDEX, Block
from cncgen.gcode.budget import ARRAYS, EVENT, MOTION, Budget
from cncgen.gcode.sinks.sink import FULL_CIRCLE_MM, Curve, MotionBatch, Point, refuse_uvw
from cncgen.gcode.state.modal import PLANE_AXES, zeros
from cncgen.geometry import elementary
from cncgen.geometry.tables import ArcTable, NurbsTable
from cncgen.toolpath.building import RowBuilder, ToolpathBuilder
from cncgen.toolpath.record import Event, FeedMode, Kind, PathMode
from cncgen.units import AXIS_LETTERS, DEGREE, INCH, PER_MINUTE

Floats = NDArray[np.float64]
_MAX_PENDING = 4096
#: A way shorter than this, mm or rad, comes of rounding, as of offsets that are added and taken off again.
_ROUNDING = 1e-6
_SHORT = 256


class _Motions(NamedTuple):
    """Motions of one source as arrays; the columns are those of `MotionBatch`."""

    motion: NDArray[np.int8]
    end: Floats
    feed: Floats
    centre: Floats
    turns: NDArray[np.int64]
    line: NDArray[np.int64]
    source: int


class ColumnsSink:
    """Turns canonical calls into rows of a `ToolpathBuilder`."""

    wants_comments = False

    def __init__(
        self,
        builder: ToolpathBuilder,
        tolerance_mm: float | None = None,
        *,
        degrees_count: bool = False,
        tips: bool = False,
        tells_lengths: bool = False,
        shown: str = "",
    ) -> None:
        """Take motions for a builder.

        Args:
            builder: Takes the rows.
            tolerance_mm: The path tolerance, whatever the program says.
            degrees_count: F of a line is the speed along all its axes, a degree as a unit of length, as FANUC's
                controls have it; else along X Y Z where these move, as LinuxCNC has it.
            tips: Offsets of tools are left out, so that positions are those of their tips.
            tells_lengths: Lengths of tools are told by events, for those who ask where their tips are.
            shown: Letters of the axes that the output shows; all of the builder's where it is empty.
        """
        self.block = Block({})
        self.budget = Budget()
        self.builder = builder
        self._degrees_count = degrees_count
        self._tips, self._tells_lengths = tips, tells_lengths
        self._columns = [AXIS_INDEX[letter.lower()] for letter in builder.axes]
        self._rotary = np.array([3 <= c <= 5 for c in self._columns])
        self._uvw = np.array([c >= 6 for c in self._columns])
        #: Columns of axes that the output does not show, and where they stand.
        self._hidden = [k for k, x in enumerate(AXIS_LETTERS) if x not in (shown or builder.axes)]
        self._rest: Floats = np.zeros(len(AXIS_LETTERS))
        #: The first motion of an axis that the output does not show: its letter, line and source.
        self.unforeseen: tuple[str, int, int] | None = None
        self._forced_tolerance = tolerance_mm
        self._path_mode = PathMode.CONTINUOUS
        self._tolerance = math.nan if tolerance_mm is None else tolerance_mm
        self._lever = 0.0
        self._feed_mode = 94
        self._feed = 0.0
        self._speed = 0.0
        self._surface: float | None = None
        self._plane = 17
        self._scale = 1.0
        self._origin, self._g92, self._tool = zeros(), zeros(), zeros()
        self._rotation = 0.0
        self._pending: list[tuple[int, Point, float, float, float, int, int]] = []

    # Motions.

    def straight_traverse(self, end: Point) -> None:
        self._keep(0, end, 0.0, 0.0, 0)

    def straight_feed(self, end: Point) -> None:
        self._keep(1, end, 0.0, 0.0, 0)

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        """Keep an arc; raise where it lies in a plane of U V W."""
        refuse_uvw(plane)
        self._keep(2, end, first, second, turns)

    def straight_probe(self, end: Point) -> None:
        """Keep a line: a probe is planned as if nothing were touched. The event that ends it comes with its call."""
        self._add(Event("probe", values={"probing": True}))
        self._keep(1, end, 0.0, 0.0, 0)

    def rigid_tap(self, end: Point, pitch: float) -> None:
        """Keep the way there and the way back, which meet at the depth that is programmed, where the spindle stops to turn back."""
        self.flush()
        machine, mode = self.builder.position.copy(), self._path_mode
        self._path_mode = PathMode.EXACT_STOP
        self.synchronise(pitch, tap=True)
        self._keep(1, end, 0.0, 0.0, 0)
        self.flush()
        self._path_mode = mode
        if (self.builder.position != machine).any():
            self.builder.retrace(machine)
        self.synchronise(None)

    def synchronise(self, pitch: float | None, tap: bool = False) -> None:
        """Say with an event how far the tool goes in a turn, which neither feed nor speed tells, and set the feed."""
        told = {"pitch_mm": None if pitch is None else pitch * self._scale}
        self._add(Event("synchronise", values={**told, "tap": True} if tap else told))
        varies = self._surface is not None
        if varies or self._feed_mode == 93 or (self._before is not None and self._before[1] == 93):
            # The kept motions must share one meaning of the feed; 94 and 95 differ by a factor alone, if it is constant.
            self.flush()
        if pitch is not None:
            self._before = self._feed, self._feed_mode
            self._feed = pitch * self._speed if self._feed_mode == 94 and not varies else pitch
            self._feed_mode = 95 if self._feed_mode == 93 or varies else self._feed_mode
        elif self._before is not None:
            self._feed, self._feed_mode = self._before
            self._before = None

    _before: tuple[float, int] | None = None

    def _keep(self, motion: int, end: Point, first: float, second: float, turns: int) -> None:
        self.budget.spend(MOTION)
        pending = self._pending
        if len(pending) >= _MAX_PENDING or (pending and self.block.source != self._source):
            self.flush()
        self._source = self.block.source
        pending.append((motion, end, self._feed, first, second, turns, self.block.line))

    _source = 0

    def flush(self) -> None:
        """Hand on the motions kept."""
        pending = self._pending
        if not pending:
            return
        motion, end, feed, first, second, turns, line = zip(*pending, strict=True)
        centre = np.column_stack([first, second])
        columns = np.array(motion, np.int8), np.array(end), np.array(feed), centre, np.array(turns, np.int64)
        pending.clear()
        self._append(_Motions(*columns, np.array(line, np.int64), self._source))

    def motions(self, batch: MotionBatch) -> None:
        """Take a run of plain motions; short ones are kept with single motions until there are more."""
        if len(batch.motion) < _SHORT:
            if self._pending and batch.source != self._source:
                self.flush()
            self._source = batch.source
            first, second = zip(*batch.centre.tolist(), strict=True)
            listed = (column.tolist() for column in (batch.motion, batch.end, batch.feed))
            self._pending.extend(
                zip(*listed, first, second, batch.turns.tolist(), batch.line.tolist(), strict=True)
            )
            if len(self._pending) >= _MAX_PENDING:
                self.flush()
        else:
            self.flush()
            columns = map(np.asarray, (batch.motion, batch.end, batch.feed, batch.centre, batch.turns))
            self._append(_Motions._make([*columns, np.array(batch.line), batch.source]))

    def nurbs_feed(self, curve: Curve) -> None:
        self.budget.spend(MOTION)
        self.budget.add(ARRAYS)
        self.flush()
        if curve.rate is not None:
            self._feed = curve.rate
        points = self._machine(np.array(curve.points, float))
        self._watch(np.array(curve.points, float), np.full(len(points), self.block.line), self.block.source)
        points[0] = self.builder.position
        one = np.ones(1)
        end = points[-1:]
        rotary_only = not (points[:, ~self._rotary] != points[0, ~self._rotary]).any()
        rate = self._revolutions(points[:1], end)
        table = NurbsTable(
            np.array([curve.degree]),
            np.array([0, len(points)]),
            np.array([0, len(curve.knots)]),
            points,
            np.array(curve.weights, float),
            np.array(curve.knots, float),
        )
        self.builder.add(
            RowBuilder(
                kind=np.array([Kind.NURBS], np.int8),
                end=end,
                feed=self._inside_feed(one * self._feed, np.array([rotary_only]), rate),
                feed_mode=np.array([self._inside_mode()], np.int8),
                curve=np.zeros(1, np.int64),
                line=np.array([self.block.line], np.int64),
                path_mode=self._path_mode,
                tolerance=self._tolerance,
                lever=self._lever,
                source=self.block.source,
                nurbs=table,
            )
        )

    def _append(self, batch: _Motions) -> None:
        """Transform motions and add their rows."""
        end = self._machine(batch.end)
        start = np.concatenate([self.builder.position[None, :], end[:-1]])
        if self._surface is not None and self._feed_mode == 95:
            batch, start, end = self._parted(batch, start, end)
        motion = batch.motion
        arcs = motion >= 2
        self.budget.add(ARRAYS * (4 if arcs.any() else 1))
        self._watch(batch.end, batch.line, batch.source)
        if arcs.any() and any(k in self._hidden for k in PLANE_AXES[self._plane][:2]):
            self._watch_arcs(batch, arcs)
        rapid = motion == 0
        rate = self._revolutions(start, end)
        # A full circle ends where it starts, and yet moves linear axes.
        feed = self._inside_feed(batch.feed, self._rotary_only(start, end) & ~arcs, rate)
        if self._degrees_count and self._feed_mode != 93 and self._rotary.any():
            feed *= np.where(arcs, 1.0, self._linear_share(end - start))
        feed[rapid] = np.nan
        curve = np.full(len(motion), -1, np.int64)
        table = None
        if arcs.any():
            curve[arcs] = np.arange(np.count_nonzero(arcs))
            table = self._arc_table(batch, arcs, start[arcs], end[arcs])
        self.builder.add(
            RowBuilder(
                kind=np.where(arcs, Kind.ARC, Kind.LINE).astype(np.int8),
                end=end,
                feed=feed,
                feed_mode=np.where(rapid, FeedMode.RAPID, self._inside_mode()).astype(np.int8),
                curve=curve,
                line=batch.line,
                path_mode=self._path_mode,
                tolerance=self._tolerance,
                lever=self._lever,
                source=batch.source,
                arcs=table,
            )
        )

    def _watch(self, points: Floats, line: NDArray[np.int64], source: int) -> None:
        """Remember the first motion to `points`, program coordinates, of an axis that the output does not show."""
        if self.unforeseen is None and self._hidden:
            moved = np.abs(self._of_machine(points)[:, self._hidden] - self._rest[self._hidden]) > _ROUNDING
            if moved.any():
                row, column = np.argwhere(moved)[0]
                self.unforeseen = AXIS_LETTERS[self._hidden[column]], int(line[row]), source

    def _watch_arcs(self, batch: _Motions, arcs: NDArray[np.bool_]) -> None:
        """Remember the first arc that moves an axis of its plane which the output does not show."""
        axis = next(k for k in PLANE_AXES[self._plane][:2] if k in self._hidden)
        if self.unforeseen is None:
            self.unforeseen = AXIS_LETTERS[axis], int(batch.line[arcs][0]), batch.source

    def _parted(self, batch: _Motions, start: Floats, end: Floats) -> tuple[_Motions, Floats, Floats]:
        """Cut the lines along which the spindle's speed changes; return the motions with their starts and ends."""
        from cncgen.gcode.sinks.surface_speed import parted

        line = batch.motion == 1
        first = self._radius(start)
        # Cutting lines alone change the radius; other motions keep that of their start.
        last = np.where(line, self._radius(end), first)
        knee = self._surface_mm_min() / (2.0 * math.pi * self._surface) if self._surface else math.inf
        owner, until = parted(first, last, knee)
        whole = (until == 1.0)[:, None]
        ends = np.where(whole, end[owner], start[owner] + until[:, None] * (end - start)[owner])
        columns: tuple[Any, ...] = batch[:-1]
        parts = _Motions._make([*(column[owner] for column in columns), batch.source])
        return parts, np.concatenate([self.builder.position[None, :], ends[:-1]]), ends

    def _radius(self, points: Floats) -> Floats:
        """Return the distance of machine positions from X0 of the program, mm, signed."""
        radius: Floats = points[:, 0] - self._machine(np.zeros((1, len(AXIS_INDEX))))[0, 0]
        return radius

    def _surface_mm_min(self) -> float:
        """Return the surface speed: S is m/min, or ft/min where lengths are inches."""
        return self._speed * (1000.0 if self._scale == 1.0 else 12.0 * INCH)

    def _revolutions(self, start: Floats, end: Floats) -> Floats | float:
        """Return the spindle's speed along motions, rev/min: one for all, but in G96 one for the mean radius of each."""
        if self._surface is None:
            return self._speed
        from cncgen.gcode.sinks.surface_speed import revolutions

        mean = 0.5 * (self._radius(start) + self._radius(end))
        return revolutions(self._surface_mm_min(), self._surface, mean)

    def _rotary_only(self, start: Floats, end: Floats) -> NDArray[np.bool_]:
        """Tell the rows that move no linear axis: their feed is in degrees."""
        if not self._rotary.any():
            return np.zeros(len(end), bool)
        return ~(start[:, ~self._rotary] != end[:, ~self._rotary]).any(axis=1)

    def _linear_share(self, way: Floats) -> Floats:
        """Return how much of the ways of lines, a degree as a unit of length, is that of X Y Z (else U V W); 1 of rotary ones.

        FANUC B-63174EN, 4.2: of G1 X20 C40 F300 (G91, mm) the time is √(20² + 40²)/300 min.
        """
        lengths = way * np.where(self._rotary, self._scale / DEGREE, 1.0)
        first = np.linalg.norm(lengths[:, ~self._rotary & ~self._uvw], axis=1)
        linear = np.where(first > 0.0, first, np.linalg.norm(lengths[:, self._uvw], axis=1))
        whole = np.linalg.norm(lengths, axis=1)
        return np.divide(linear, whole, out=np.ones(len(way)), where=linear > 0.0)

    def _machine(self, points: Floats) -> Floats:
        """Return machine coordinates, mm and rad, in the builder's columns, of points in program coordinates."""
        return self._of_machine(points)[:, self._columns]

    def _of_machine(self, points: Floats) -> Floats:
        """Return machine coordinates of all nine axes, mm and rad, of points in program coordinates."""
        out = points + self._g92 if any(self._g92) else points.copy()
        if self._rotation:
            c, s = math.cos(self._rotation * DEGREE), math.sin(self._rotation * DEGREE)
            x, y = out[:, 0].copy(), out[:, 1].copy()
            out[:, 0], out[:, 1] = c * x - s * y, s * x + c * y
        out += np.array(self._origin) + np.array(self._tool)
        out[:, :3] *= self._scale
        out[:, 3:6] *= DEGREE
        out[:, 6:] *= self._scale
        return out

    def _arc_table(self, batch: _Motions, arcs: NDArray[np.bool_], start: Floats, end: Floats) -> ArcTable:
        """Return centre, normal and sweep in the machine's frame."""
        first, second, normal = PLANE_AXES[self._plane]
        points = batch.end[arcs].copy()
        points[:, first], points[:, second] = batch.centre[arcs].T
        centre = self._machine(points)[:, :3]
        axis = np.zeros(3)
        axis[normal % 3] = 1.0
        if self._rotation:
            c, s = math.cos(self._rotation * DEGREE), math.sin(self._rotation * DEGREE)
            axis = np.array([c * axis[0] - s * axis[1], s * axis[0] + c * axis[1], axis[2]])
        begin, finish = start[:, :3] - centre, end[:, :3] - centre
        # The centre lies on the axis at the height of the start point.
        centre += np.outer(elementary.product(begin, axis), axis)
        begin -= np.outer(elementary.product(begin, axis), axis)
        finish -= np.outer(elementary.product(finish, axis), axis)
        turns = batch.turns[arcs]
        sense = np.sign(turns).astype(float)
        normals = sense[:, None] * axis
        angle = elementary.arctan2(
            (np.cross(begin, finish) * normals).sum(axis=1), (begin * finish).sum(axis=1)
        )
        angle = np.where(angle <= 0.0, angle + 2.0 * np.pi, angle)
        whole = np.linalg.norm(finish - begin, axis=1) < FULL_CIRCLE_MM
        angle[whole] = 2.0 * np.pi
        return ArcTable(centre, normals, angle + 2.0 * np.pi * (np.abs(turns) - 1))

    def _inside_mode(self) -> FeedMode:
        return FeedMode.INVERSE_TIME if self._feed_mode == 93 else FeedMode.SPEED

    def _inside_feed(self, feed: Floats, rotary_only: NDArray[np.bool_], rate: Floats | float) -> Floats:
        """Return mm/s, rad/s or 1/s of feed rates as programmed; `rate` is the spindle's speed, rev/min."""
        if self._feed_mode == 93:
            return feed * PER_MINUTE
        out = feed * (PER_MINUTE * (rate if self._feed_mode == 95 else 1.0))
        return out * np.where(rotary_only, DEGREE, self._scale)

    # Modes that later motions depend on.

    def use_length_units(self, inches: bool) -> None:
        """Take lengths in inches or millimetres; offsets in force keep their length."""
        self.flush()
        scale = INCH if inches else 1.0
        factor = self._scale / scale
        for vector in (self._origin, self._g92, self._tool):
            vector[:3] = [v * factor for v in vector[:3]]
            vector[6:] = [v * factor for v in vector[6:]]
        self._scale = scale

    def select_plane(self, plane: int) -> None:
        self.flush()
        self._plane = plane

    def set_feed_rate(self, rate: float) -> None:
        self._feed = rate

    def set_inverse_time(self, rate: float, length: float) -> None:
        self._feed = rate

    def set_feed_mode(self, mode: int, synched: bool) -> None:
        self.flush()
        self._feed_mode = mode

    def set_spindle(self, speed: float, direction: int) -> None:
        """Set the speed that feeds per revolution are multiplied by."""
        self.flush()
        self._speed = speed if direction else 0.0

    def set_surface_speed(self, limit: float | None) -> None:
        """Set whether the speed is a surface speed, and the bound of the revolutions."""
        self.flush()
        self._surface = limit

    def set_motion_control_mode(self, mode: PathMode, tolerance: float | None, naive: float | None) -> None:
        """Set path mode and tolerance (NaN where the program gives none)."""
        self.flush()
        self._path_mode = mode
        if self._forced_tolerance is None:
            self._tolerance = math.nan if tolerance is None else tolerance * self._scale

    def set_lever(self, lever: float) -> None:
        if lever * self._scale != self._lever:
            self.flush()
            self._lever = lever * self._scale

    def set_g5x_offset(self, system: int, offset: Point) -> None:
        self.flush()
        self._origin = list(offset)

    def set_g92_offset(self, offset: Point) -> None:
        self.flush()
        self._g92 = list(offset)

    def set_xy_rotation(self, degrees: float) -> None:
        self.flush()
        self._rotation = degrees

    def use_tool_length_offset(self, offset: Point) -> None:
        self.flush()
        if self._tells_lengths:
            self._add(Event("tool offset", values={"length_mm": offset[2] * self._scale}))
        if not self._tips:
            self._tool = list(offset)

    def where(self, position: Point) -> Point:
        return position

    def place(self, position: Point) -> None:
        self.flush()
        self.builder.place(self._machine(np.array([position]))[0])
        self._rest = self._of_machine(np.array([position]))[0]

    def call(self, text: str, event: Event | None = None) -> None:
        if event is not None:
            self.budget.spend(EVENT)
            self._add(event)

    def _add(self, event: Event) -> None:
        self.flush()
        self.builder.event(event, self.block.line, self.block.source)
