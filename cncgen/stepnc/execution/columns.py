"""The listener that makes a toolpath of the canonical calls."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.tables import ArcTable, NurbsTable
from cncgen.stepnc.entities import Skip
from cncgen.stepnc.execution.canon import Canon
from cncgen.stepnc.geometry.pieces import Arc, Nurbs
from cncgen.stepnc.geometry.solids import Solid
from cncgen.stepnc.model import STEEPEST, TURNING, CuttingTool, Workingstep, WorkSetup
from cncgen.stepnc.turned_shapes import feed_sense
from cncgen.toolpath.building import RowBuilder, ToolpathBuilder
from cncgen.toolpath.record import Event, FeedMode, Kind, PathMode, Toolpath

Floats = NDArray[np.float64]


def _sizes(tool: CuttingTool) -> dict[str, Any]:
    """Return the sizes of a tool that are known, as values of its event."""
    values: dict[str, Any] = {}
    if tool.kind:
        values["form"] = tool.kind
    if tool.diameter:
        values["diameter_mm"] = tool.diameter
        if tool.tip_angle:
            values["point_angle_deg"] = 180.0 - 2.0 * math.degrees(tool.tip_angle)
        elif tool.edge:
            values["edge_radius_mm"] = tool.edge
    if tool.cutting_length:
        values["cutting_length_mm"] = tool.cutting_length
    if tool.left_handed:
        values["left_handed"] = True
    if not tool.centre_cutting:
        values["steepest_deg"] = math.degrees(STEEPEST)
    others = {
        "teeth": tool.teeth,
        "pitch_mm": tool.pitch,
        "length_mm": tool.offset_length,
        "nose_radius_mm": tool.nose,
        "width_mm": tool.width,
        "trailing_angle_deg": None if tool.trailing is None else math.degrees(tool.trailing),
    }
    values |= {key: size for key, size in others.items() if size}
    return values


class Columns(Canon):
    """Collects rows; `take` hands them on as a `Toolpath`."""

    def __init__(
        self, axes: str, name: str, line_of: Callable[[int], int], tolerance: float | None = None
    ) -> None:
        self._builder = ToolpathBuilder(axes, np.zeros(len(axes)), [name])
        self._line_of = line_of
        self._usual = self._tolerance = math.nan if tolerance is None else tolerance
        self._mode = PathMode.CONTINUOUS
        self._lever, self._long = 0.0, False
        self._line = 0
        self._feed = math.nan
        self._direction = 0
        self._rpm = 0.0
        # Straight lines wait to be added together: many toolpaths have few of them.
        self._waiting: list[tuple[Floats, bool, float, int]] = []
        self._waiting_rows = 0

    @property
    def count(self) -> int:
        """Return the rows collected since the last chunk."""
        return self._builder.count + self._waiting_rows

    def take(self) -> Toolpath:
        """Return what was collected as a chunk."""
        self._flush()
        return self._builder.take()

    def source(self, ident: int) -> None:
        """Give the next rows the line of an entity."""
        self._line = self._line_of(ident)

    def begin(self, position: Floats) -> None:
        """Start there."""
        self._flush()
        self._builder.place(position)

    def _event(self, name: str, rest: bool = False, dwell: float = 0.0, **values: object) -> None:
        self._flush()
        self._builder.event(Event(name, rest, dwell, values), self._line, 0)

    def setup(self, setup: WorkSetup) -> None:
        """Add an event with number, name and origin of the clamping."""
        origin = None if setup.origin is None else setup.origin[:3, 3].tolist()
        values: dict[str, Any] = {"number": setup.number, "setup": setup.label, "origin_mm": origin}
        self._event("setup", True, **values)

    def probing(self, on: bool) -> None:
        """Add an event that says whether lines end where the probe touches."""
        self._event("probe", probing=on)

    def change_tool(self, tool: CuttingTool) -> None:
        """Add a tool event."""
        sizes = _sizes(tool)
        # A tool of no length behind one that has some says so, for those who follow its tip.
        if self._long:
            sizes.setdefault("length_mm", 0.0)
        self._long = bool(sizes.get("length_mm"))
        self._event("tool", True, tool=tool.name, **sizes)

    def spindle(self, direction: int, rpm: float | None) -> None:
        """Add a spindle event where something changes."""
        speed = self._rpm if rpm is None else rpm
        if (direction, speed) != (self._direction, self._rpm):
            self._direction, self._rpm = direction, speed
            self._event("spindle", speed_rpm=speed, direction=direction)

    def coolant(self, flood: bool, mist: bool, through: bool) -> None:
        """Add a coolant event."""
        values = {"flood": flood, "mist": mist} | ({"through_spindle": True} if through else {})
        self._event("coolant", **values)

    def feed(self, speed: float) -> None:
        """Move at this speed, mm/s, from now on."""
        self._feed = speed

    def deviation(self, distance: float | None) -> None:
        """Move within this distance of the path from now on; None takes the distance of the options."""
        mode = PathMode.EXACT_PATH if distance == 0 else PathMode.CONTINUOUS
        tolerance = distance or self._usual
        if (mode, tolerance) != (self._mode, self._tolerance):
            self._flush()
            self._mode, self._tolerance = mode, tolerance

    def lever(self, lever: float) -> None:
        """Take this lever, mm/rad, from now on."""
        if lever != self._lever:
            self._flush()
            self._lever = lever

    def traverse(self, points: Floats) -> None:
        """Add rapid lines."""
        self._straight(points, True)

    def lines(self, points: Floats) -> None:
        """Add lines at the feed."""
        self._straight(points, False)

    def _straight(self, points: Floats, rapid: bool) -> None:
        self._waiting.append((points, rapid, math.nan if rapid else self._feed, self._line))
        self._waiting_rows += len(points)

    def _flush(self) -> None:
        """Add the lines that wait."""
        if not self._waiting:
            return
        points, rapid, feed, line = zip(*self._waiting, strict=True)
        counts = [len(p) for p in points]
        modes = np.where(rapid, FeedMode.RAPID, FeedMode.SPEED).astype(np.int8)
        n = self._waiting_rows
        self._waiting, self._waiting_rows = [], 0
        self._builder.add(
            RowBuilder(
                kind=np.full(n, Kind.LINE, np.int8),
                end=np.concatenate(points),
                feed=np.repeat(np.array(feed), counts),
                feed_mode=np.repeat(modes, counts),
                curve=np.full(n, -1, np.int64),
                line=np.repeat(np.array(line, np.int64), counts),
                path_mode=self._mode,
                tolerance=self._tolerance,
                lever=self._lever,
                source=0,
            )
        )

    def _curve(
        self, kind: Kind, end: Floats, rapid: bool, arcs: ArcTable | None, nurbs: NurbsTable | None
    ) -> None:
        self._flush()
        self._builder.add(
            RowBuilder(
                kind=np.array([kind], np.int8),
                end=end,
                feed=np.array([math.nan if rapid else self._feed]),
                feed_mode=np.array([FeedMode.RAPID if rapid else FeedMode.SPEED], np.int8),
                curve=np.zeros(1, np.int64),
                line=np.array([self._line], np.int64),
                path_mode=self._mode,
                tolerance=self._tolerance,
                lever=self._lever,
                source=0,
                arcs=arcs,
                nurbs=nurbs,
            )
        )

    def arc(self, arc: Arc, end: Floats, rapid: bool) -> None:
        """Add an arc."""
        table = ArcTable(arc.centre[None, :], arc.normal[None, :], np.array([arc.sweep]))
        self._curve(Kind.ARC, end[None, :], rapid, table, None)

    def nurbs(self, curve: Nurbs, control: Floats, rapid: bool) -> None:
        """Add a spline."""
        table = NurbsTable(
            np.array([curve.degree], np.int64),
            np.array([0, len(control)], np.int64),
            np.array([0, len(curve.knots)], np.int64),
            control,
            curve.weights,
            curve.knots,
        )
        self._curve(Kind.NURBS, control[-1:], rapid, None, table)

    def rigid_tap(self, end: Floats, pitch: float) -> None:
        """Add the way there and back, between events that say how far the tool goes in a turn of the spindle, which stops to turn back."""
        start, mode = self._builder_position(), self._mode
        self._event("synchronise", pitch_mm=pitch, tap=True)
        self._mode = PathMode.EXACT_STOP
        self._straight(np.stack([end, start]), False)
        self._flush()
        self._mode = mode
        self.synchronise(None)

    def synchronise(self, pitch: float | None) -> None:
        """Add an event that says how far the tool goes in a turn of the spindle, None: that it is free again."""
        self._event("synchronise", pitch_mm=pitch)

    def _builder_position(self) -> Floats:
        self._flush()
        return self._builder.position.copy()

    def dwell(self, seconds: float) -> None:
        """Add a dwell."""
        self._event("dwell", True, seconds, seconds=seconds)

    def stop(self, optional: bool) -> None:
        """Add a stop."""
        self._event("stop", True, kind="optional" if optional else "stop")

    def message(self, text: str) -> None:
        """Add a message."""
        self._event("message", text=text)

    def function(self, name: str, value: object) -> None:
        """Add a user event."""
        self._event("user", True, function=name, value=value)

    def end(self) -> None:
        """Add the end."""
        self._event("end", True)


class StepColumns(Columns):
    """Collects rows as `Columns` does, with an event at the beginning of each workingstep.

    The event has the name of the workingstep, its raw piece where that is another than the one before, how many there are in its setup
    where there are several, and how a turning tool stands whose toolpaths are made here.

    Attributes:
        steps: The workingsteps executed, in their order.
    """

    def __init__(
        self, axes: str, name: str, line_of: Callable[[int], int], tolerance: float | None = None
    ) -> None:
        super().__init__(axes, name, line_of, tolerance)
        self.steps: list[Workingstep] = []
        self._raw: Solid | None = None

    def workingstep(self, step: Workingstep) -> None:
        """Add an event with the workingstep's name."""
        self.steps.append(step)
        self.source(step.operation.ident)
        raw = step.raw if step.raw is not None and not step.raw.same(self._raw) else None
        self._raw = step.raw or self._raw
        values: dict[str, Any] = {"label": step.label or f"#{step.ident}", "entity": step.ident}
        if len(step.pieces) > 1:
            values["raw_pieces"] = len(step.pieces)
        with suppress(Skip):  # a fault of the feature is reported when its toolpaths are made
            if (
                step.operation.paths is None
                and step.feature is not None
                and step.operation.kind.startswith(TURNING)
            ):
                values["left_handed"] = feed_sense(step, step.feature.shape()) < 0
        self._event("workingstep", **(values if raw is None else values | {"stock": raw.values()}))
