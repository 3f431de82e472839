"""Toolpaths to an AP238 file: one workplan, a workingstep a tool (or as the program has them), a toolpath for every stretch
of alike motions; tools with their sizes, and the raw piece of each setup.

Lines become polylines, arcs trimmed circles, helices trimmed HELIX curves (of ISO 14649-11; the AIM has none of its
own), splines B-splines with their knots and weights. A comment before the header states the first position of the tool. Numbers have
all their digits, so reading the file gives the same values.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TextIO

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Severity, UsageError
from cncgen.geometry import elementary
from cncgen.stepnc.ap238.aim_file import AimFile, E, Stock
from cncgen.stepnc.motion_lengths import motion_length
from cncgen.stepnc.part21 import Ref
from cncgen.toolpath.record import Event, FeedMode, Kind, PathMode, Toolpath

Floats = NDArray[np.float64]

#: Sizes of tools: keys of tool events, and the names that the AIM has for them.
_LENGTHS = {
    "diameter_mm": "effective cutting diameter",
    "edge_radius_mm": "edge radius",
    "cutting_length_mm": "maximum depth of cut",
    "length_mm": "overall assembly length",
    "pitch_mm": "thread pitch",
    "nose_radius_mm": "corner radius",
    "width_mm": "cutting width",
}
_ANGLES = {"point_angle_deg": "point angle", "trailing_angle_deg": "end cutting edge angle"}

SCHEMA = "MODEL_BASED_INTEGRATED_MANUFACTURING_SCHEMA { 1 0 10303 442 3 1 4 }"


def write_ap238(
    chunks: Iterable[Toolpath],
    stream: TextIO,
    name: str = "",
    inches: bool = False,
    stock: Stock | None = None,
) -> list[Diagnostic]:
    """Write a program as an AP238 file.

    Args:
        chunks: Its toolpath, piece by piece; axes X Y Z, or X Y Z B C as `read` gives them.
        stream: Text stream.
        name: Of the project.
        inches: Whether lengths are written in inches.
        stock: The raw piece (`AimFile.project`), before that of workingsteps.

    Returns:
        Warnings of what the file leaves out.

    Raises:
        UsageError: where the program has other axes, which AP238 has no place for.
    """
    iterator = iter(chunks)
    first = next(iterator, None)
    start = np.zeros(3) if first is None else first.start[:3]
    stream.write("ISO-10303-21;\n")
    words = " ".join(f"{a}{v!r}" for a, v in zip("XYZ", start.tolist(), strict=True))
    stream.write(f"/* (START, {words}) */\n")
    stream.write("HEADER;\nFILE_DESCRIPTION(('toolpaths'),'2;1');\n")
    stream.write(
        f"FILE_NAME('','',(''),(''),'cncgen','cncgen','');\nFILE_SCHEMA(('{SCHEMA}'));\nENDSEC;\nDATA;\n"
    )
    writer = _Writer(AimFile(stream, inches), name, stock, stock is not None)
    for chunk in _all(first, iterator):
        writer.chunk(chunk)
    writer.close()
    stream.write("ENDSEC;\nEND-ISO-10303-21;\n")
    return writer.left_out()


def _all(first: Toolpath | None, rest: Iterator[Toolpath]) -> Iterator[Toolpath]:
    if first is not None:
        yield first
    yield from rest


@dataclass(slots=True)
class _State:
    """The settings that hold for the next toolpath."""

    tool: str | None = None
    spindle: float | None = None
    coolant: tuple[bool, bool, bool] | None = None
    pitch: float | None = None
    probing: bool = False

    @property
    def running(self) -> tuple[float, tuple[bool, bool, bool]]:
        """Return what spindle and coolant do: nothing where nobody said so."""
        return self.spindle or 0.0, self.coolant or (False, False, False)


class _Users(NamedTuple):
    """The sizes of a tool, as its event has them, and the operations that use it."""

    values: dict[str, Any]
    users: list[Ref]


@dataclass(slots=True)
class _Writer:
    file: AimFile
    name: str
    stock: Stock | None = None
    of_all: bool = False
    several: Event | None = None
    state: _State = field(default_factory=_State)
    _plan: Ref | None = None
    _operation: Ref | None = None
    _paths: int = 0
    _steps: int = 0
    _setups: list[tuple[Ref, Stock]] = field(default_factory=list)
    _within: Ref | None = None
    _steps_within: int = 0
    _label: str = ""
    _tools: dict[str, _Users] = field(default_factory=dict)
    _technologies: dict[tuple[float | None, float | None, float | None], Ref] = field(default_factory=dict)
    _functions: dict[tuple[bool, bool, bool], Ref] = field(default_factory=dict)
    #: Spindle and coolant in the last toolpath.
    _attached: tuple[float, tuple[bool, bool, bool]] = (0.0, (False, False, False))

    def close(self) -> None:
        """Write what refers to all that came before."""
        kind = self.file.add("ACTION_RESOURCE_TYPE", "milling cutting tool")
        for tool, (values, users) in self._tools.items():
            form = str(values.get("form") or "milling cutting tool")
            self._sizes(self.file.add("MACHINING_TOOL", tool, form, tuple(users), kind), values)
        self.file.project(self._main(), self.name or "program", self.stock, self._setups)

    def left_out(self) -> list[Diagnostic]:
        """Return warnings of what the file leaves out."""
        if self.several is None:
            return []
        values = self.several.values
        text = f"workingstep {values.get('label', '')} (#{values['entity']}) has {values['raw_pieces']} raw pieces in its setup, of which one is written"
        hint = "convert each of them to a file of its own, or give the raw piece of all with --stock"
        return [Diagnostic("stepnc-raw-pieces", text, Severity.WARNING, hint=hint)]

    def _sizes(self, tool: Ref, values: Mapping[str, Any]) -> None:
        """Write the sizes of a tool that are known, as properties of its body."""
        file = self.file
        items = [file.size(item, values[key]) for key, item in _LENGTHS.items() if values.get(key)]
        items += [file.angle(item, values[key]) for key, item in _ANGLES.items() if values.get(key)]
        if values.get("teeth"):
            items.append(file.teeth("number of effective teeth", values["teeth"]))
        if values.get("left_handed"):
            items.append(file.add("DESCRIPTIVE_REPRESENTATION_ITEM", "hand of cut", "left"))
        for item in items:
            owner = file.add("RESOURCE_PROPERTY", "tool body", "", tool)
            body = file.add("MACHINING_TOOL_BODY_REPRESENTATION", "", (item,), file.context)
            file.add("RESOURCE_PROPERTY_REPRESENTATION", "", "", owner, body)

    # Structure

    def _standing(self, stock: Stock) -> None:
        """Begin a workplan with a setup of its own where the raw piece is another one than before, or stands elsewhere."""
        if self.of_all:
            return
        if self.stock is None and self._plan is None:
            self.stock = stock
            return
        self._within = self.file.method("MACHINING_WORKPLAN", f"setup {len(self._setups) + 2}")
        self._setups.append((self._within, stock))
        self._steps += 1
        self._sequence(self._main(), self._within, self._steps)
        self._steps_within = 0

    def _main(self) -> Ref:
        self._plan = self._plan or self.file.method("MACHINING_WORKPLAN", self.name or "program")
        return self._plan

    def _child(self, child: Ref) -> None:
        if self._within is None:
            self._steps += 1
            self._sequence(self._main(), child, self._steps)
        else:
            self._steps_within += 1
            self._sequence(self._within, child, self._steps_within)

    def _sequence(self, plan: Ref, child: Ref, number: int) -> None:
        self.file.relate("MACHINING_PROCESS_SEQUENCE_RELATIONSHIP", plan, child, number)

    def _begin_operation(self) -> Ref:
        if self._operation is None:
            step = self.file.method("MACHINING_WORKINGSTEP", self._label or f"step {self._steps + 1}")
            kind = "MACHINING_TOUCH_PROBING" if self.state.probing else "FREEFORM_MILLING_OPERATION"
            self._operation = self.file.method(kind)
            self.file.add("MACHINING_OPERATION_RELATIONSHIP", "", "", step, self._operation)
            self._child(step)
            self._paths = 0
            if self.state.tool is not None:
                self._tools[self.state.tool].users.append(self._operation)
        return self._operation

    def _path(self, description: str) -> Ref:
        operation = self._begin_operation()
        path = self.file.method("MACHINING_TOOLPATH", "", description)
        self._paths += 1
        self.file.relate("MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP", operation, path, self._paths)
        return path

    # Rows

    def chunk(self, toolpath: Toolpath) -> None:
        """Write the rows of a chunk."""
        others = set(toolpath.axes) - set("XYZBC")
        if others or ("B" in toolpath.axes) != ("C" in toolpath.axes):
            text = f"AP238 has toolpaths of X Y Z and a tool axis (B and C), not of axes {toolpath.axes}"
            raise UsageError(Diagnostic("stepnc-axes", text))
        n = len(toolpath)
        feed = np.nan_to_num(toolpath.feed, nan=-1.0)
        exact = toolpath.path_mode != PathMode.CONTINUOUS
        deviation = np.where(exact, 0.0, np.nan_to_num(toolpath.tolerance, nan=-1.0))
        change = np.ones(n + 1, bool)
        change[1:n] = (
            (toolpath.kind[1:] != Kind.LINE)
            | (toolpath.kind[:-1] != Kind.LINE)
            | (feed[1:] != feed[:-1])
            | (toolpath.feed_mode[1:] != toolpath.feed_mode[:-1])
            | (toolpath.feed_mode[1:] == FeedMode.INVERSE_TIME)
            | (deviation[1:] != deviation[:-1])
        )
        starts = toolpath.starts
        edges = np.flatnonzero(change)
        for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
            if toolpath.kind[begin] == Kind.EVENT:
                self._event(toolpath.events[int(toolpath.curve[begin])])
            else:
                self._motion(toolpath, starts, begin, end, float(deviation[begin]))

    def _motion(self, toolpath: Toolpath, starts: Floats, begin: int, end: int, deviation: float) -> None:
        kind = toolpath.kind[begin]
        points = np.concatenate([starts[begin : begin + 1], toolpath.end[begin:end]])
        if kind == Kind.LINE:
            curve = self.file.add("POLYLINE", "", tuple(self.file.points(points[:, :3])))
        elif kind == Kind.ARC:
            curve = self._arc(toolpath, points[0, :3], points[1, :3], int(toolpath.curve[begin]))
        else:
            curve = self._spline(toolpath, int(toolpath.curve[begin]))
        path = self._path("cutter location trajectory")
        self.file.property(path, "basic curve", "REPRESENTATION", "basic curve", curve)
        self._tool_axis(path, toolpath, points, kind)
        if deviation >= 0:
            name = "path maximum deviation"
            item = self.file.measure(name, deviation / self.file.unit, self.file.length)
            self.file.property(path, name, "REPRESENTATION", name, item)
        mode, feed = toolpath.feed_mode[begin], float(toolpath.feed[begin])
        if mode == FeedMode.RAPID:
            keyword = "MACHINING_TOOLPATH_SPEED_PROFILE_REPRESENTATION"
            self.file.words(path, "speed profile", "rapid", keyword)
        elif mode == FeedMode.INVERSE_TIME:
            feed *= motion_length(toolpath, begin, points)
        self._attach(path, None if mode == FeedMode.RAPID else feed)

    def _attach(self, path: Ref, feed: float | None) -> None:
        """Give a toolpath its technology and functions."""
        self._attached = self.state.running
        pitch = None if feed is None else self.state.pitch
        key = (feed, self.state.spindle, pitch)
        if key != (None, None, None):
            if key not in self._technologies:
                self._technologies[key] = self._technology(*key)
            self.file.add("MACHINING_TECHNOLOGY_RELATIONSHIP", "", "", path, self._technologies[key])
        coolant = self.state.coolant
        if coolant is not None:
            if coolant not in self._functions:
                functions = self.file.method("MACHINING_FUNCTIONS", "", "milling")
                for name, on in zip(("coolant", "mist", "through spindle coolant"), coolant, strict=True):
                    self.file.words(functions, name, f"{name} {'on' if on else 'off'}")
                self._functions[coolant] = functions
            self.file.add("MACHINING_FUNCTIONS_RELATIONSHIP", "", "", path, self._functions[coolant])

    def _technology(self, feed: float | None, spindle: float | None, pitch: float | None) -> Ref:
        file = self.file
        technology = file.method("MACHINING_TECHNOLOGY", "", "milling")
        if pitch is not None:
            unit, name = file.feed_per_turn, "feed per revolution"
            item = file.measure(name, pitch / file.unit, unit)
            file.property(technology, "feedrate", "MACHINING_FEED_SPEED_REPRESENTATION", name, item)
            file.words(technology, "synchronize spindle with feed", "synchronized")
        elif feed is not None:
            item = file.measure("feed speed", feed / file.unit, file.feed_unit)
            file.property(technology, "feedrate", "MACHINING_FEED_SPEED_REPRESENTATION", "feed speed", item)
        if spindle is not None:
            item = file.measure("rotational speed", spindle, file.spindle_unit)
            keyword = "MACHINING_SPINDLE_SPEED_REPRESENTATION"
            file.property(technology, "spindle", keyword, "spindle speed", item)
        return technology

    def _arc(self, toolpath: Toolpath, start: Floats, end: Floats, index: int) -> Ref:
        table, file = toolpath.arcs, self.file
        centre, normal, sweep = table.centre[index], table.normal[index], float(table.sweep[index])
        radius = float(elementary.length(start - centre))
        place = file.placement(centre, normal, (start - centre) / radius)
        trims = file.points(np.stack([start, end]))
        rise = float(elementary.product(end - start, normal))
        if abs(rise) > 1e-9 or sweep > 2 * math.pi + 1e-9:
            pitch = rise * 2 * math.pi / sweep
            basis = file.add("HELIX", "", place, radius / file.unit, pitch / file.unit)
        else:
            basis = file.add("CIRCLE", "", place, radius / file.unit)
        master = E("CARTESIAN")
        return file.add("TRIMMED_CURVE", "", basis, (trims[0],), (trims[1],), E("T"), master)

    def _spline(self, toolpath: Toolpath, index: int) -> Ref:
        table, file = toolpath.nurbs, self.file
        points = slice(int(table.point_offset[index]), int(table.point_offset[index + 1]))
        control, weights = table.control_points[points, :3], table.weights[points]
        knots = table.knots[int(table.knot_offset[index]) : int(table.knot_offset[index + 1])]
        values, counts = np.unique(knots, return_counts=True)
        refs = tuple(file.points(control))
        head = (int(table.degree[index]), refs, E("UNSPECIFIED"), E("F"), E("U"))
        tail = (tuple(counts.tolist()), tuple(values.tolist()), E("UNSPECIFIED"))
        if (weights == weights[0]).all():
            return file.add("B_SPLINE_CURVE_WITH_KNOTS", "", *head, *tail)
        return file.add_complex(
            ("BOUNDED_CURVE", ()),
            ("B_SPLINE_CURVE", head),
            ("B_SPLINE_CURVE_WITH_KNOTS", tail),
            ("CURVE", ()),
            ("GEOMETRIC_REPRESENTATION_ITEM", ()),
            ("RATIONAL_B_SPLINE_CURVE", (tuple(weights.tolist()),)),
            ("REPRESENTATION_ITEM", ("",)),
        )

    def _tool_axis(self, path: Ref, toolpath: Toolpath, points: Floats, kind: int) -> None:
        """Write the tool axis at the points of a line, or at start and end of another curve, where there is one."""
        if "B" not in toolpath.axes:
            return
        b, c = points[:, toolpath.axes.index("B")], points[:, toolpath.axes.index("C")]
        axis = np.column_stack([np.cos(c) * np.sin(b), np.sin(c) * np.sin(b), np.cos(b)])
        unit, self.file.unit = self.file.unit, 1.0  # directions have no unit
        refs = tuple(self.file.points(axis))
        self.file.unit = unit
        self.file.property(
            path, "tool axis", "REPRESENTATION", "tool axis", self.file.add("POLYLINE", "", refs)
        )

    # Events

    def _event(self, event: Event) -> None:
        values = event.values
        if event.name == "tool":
            self.state.tool, self._operation = str(values.get("tool", "")), None
            known = self._tools.setdefault(self.state.tool, _Users(dict(values), []))
            known.values.update(values)
        elif event.name == "workingstep":
            self._label, self._operation = str(values.get("label", "")), None
            if "stock" in values:
                self._standing(values["stock"])
            if values.get("raw_pieces", 1) > 1:
                self.several = self.several or event
        elif event.name == "spindle" and "direction" in values:
            direction, speed = int(values["direction"]), float(values["speed_rpm"])
            self.state.spindle = -direction * speed / 60.0 if direction else 0.0
        elif event.name == "setup":
            self._function("display message", f"setup {values.get('setup', '')}")
        elif event.name == "synchronise":
            self.state.pitch = values.get("pitch_mm")
        elif event.name == "probe":
            self.state.probing, self._operation = bool(values.get("probing")), None
        elif event.name == "coolant":
            names = ("flood", "mist", "through_spindle")
            self.state.coolant = tuple(bool(values.get(n, False)) for n in names)  # type: ignore[assignment]
        elif event.name == "dwell":
            if event.dwell_s > 0.0:
                self._attach(self._feedstop(event.dwell_s), None)
            else:
                self._feedstop(0.0)
        elif event.name == "end":
            self._settle()
        elif event.name == "stop":
            self._settle()
            optional = values.get("kind") == "optional"
            self._function("optional stop" if optional else "program stop", "")
        elif event.name == "message":
            self._function("display message", str(values.get("text", "")))

    def _feedstop(self, seconds: float) -> Ref:
        """Write a toolpath that waits."""
        path = self._path("feedstop")
        item = self.file.measure("dwell time", seconds, self.file.second)
        self.file.property(path, "dwell", "MACHINING_DWELL_TIME_REPRESENTATION", "dwell time", item)
        return path

    def _settle(self) -> None:
        """Switch what no toolpath has switched yet: a setting is that of a toolpath, so the last ones need one without motion."""
        if self._attached != self.state.running:
            self._attach(self._feedstop(0.0), None)

    def _function(self, kind: str, text: str) -> None:
        function = self.file.method("MACHINING_NC_FUNCTION", text or kind, kind)
        if text:
            self.file.words(function, "message", text)
        self._child(function)
        self._operation = None
