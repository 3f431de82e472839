"""The toolpaths of the AIM as records."""

from __future__ import annotations

import math

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.ap238.graph import Graph, Item
from cncgen.stepnc.ap238.technology import Resources, described
from cncgen.stepnc.ap238.units import Units
from cncgen.stepnc.entities import Entities, Entity, Skip, only
from cncgen.stepnc.geometry.chords import couple
from cncgen.stepnc.geometry.contact import locations
from cncgen.stepnc.geometry.curves import CurveReader
from cncgen.stepnc.geometry.frames import Matrix, Placements, Vector
from cncgen.stepnc.geometry.pieces import Piece, Polyline, reverse
from cncgen.stepnc.model import CutterPath, CuttingTool, Paths

#: Items of properties by the property's name.
Properties = dict[str, list[Item]]


class Toolpaths:
    """Reads the toolpaths of operations, and the curves and placements of properties."""

    def __init__(self, graph: Graph, units: Units, resources: Resources) -> None:
        self.graph = graph
        self.entities: Entities = graph.entities
        self.units = units
        self.resources = resources
        self._curves: dict[tuple[float, float], CurveReader] = {}

    def curves(self, context: int | None) -> CurveReader:
        """Return the reader of curves in the units of a context.

        Raises:
            Skip: where the units have a fault.
        """
        key = self.units.context(context)
        if key not in self._curves:
            self._curves[key] = CurveReader(self.entities, *key)
        return self._curves[key]

    def placed(self, properties: Properties, name: str, *kinds: str) -> tuple[Entity, Placements] | None:
        """Return the item of a property that is of these kinds, with the reader of its placements, or None.

        Raises:
            Skip: where there are several.
        """
        item = only(name, [i for i in properties.get(name, []) if i.entity.keyword in kinds])
        return None if item is None else (item.entity, self.curves(item.context).placements)

    def frame(self, properties: Properties, outer: Matrix) -> Matrix:
        """Return the frame of toolpaths within an outer one."""
        found = self.placed(properties, "toolpath orientation", "AXIS2_PLACEMENT_3D")
        return outer if found is None else elementary.product(outer, found[1].placement(found[0].id))

    def read(self, owner: int, tilt: Vector | None = None) -> Paths:
        """Return the toolpaths of an operation or rapid movement, by their sequence.

        Args:
            owner: Its number.
            tilt: Direction of the tool, shape (3,), where it is not Z.

        Raises:
            Skip: where a relationship has a fault.
        """
        idents = self.graph.related_ids(owner, "MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP")
        return Paths(idents, lambda k: self._path(self.entities.get(idents[k], owner=owner), owner, tilt))

    def _path(self, entity: Entity, owner: int, tilt: Vector | None) -> CutterPath:
        properties = self.graph.properties(entity.id)
        kind = entity.text("description").strip().lower()
        rapid, ratio = self._speed(properties)
        rapid = rapid or "connect" in {described(i) for i in properties.get("trajectory type", [])}
        technology, functions = self.resources.technology(entity.id), self.resources.functions(entity.id)
        if kind == "feedstop":
            seconds, turns = self._dwell(entity, properties)
            return CutterPath(
                entity.id, "dwell", technology=technology, functions=functions, seconds=seconds, turns=turns
            )
        if kind in ("connect direct", "connect security plane"):
            return CutterPath(entity.id, kind)
        if kind not in ("", "cutter location trajectory") and "basic curve" not in properties:
            raise entity.fault("stepnc-unsupported", f"a toolpath of kind {kind!r} cannot be executed")
        tool = self.resources.tool(owner) if kind == "cutter contact trajectory" else None
        return CutterPath(
            entity.id,
            "trajectory",
            lambda: self._pieces(entity, properties, tool, tilt),
            rapid,
            ratio,
            technology,
            functions,
            deviation=self._deviation(entity, properties),
        )

    def _deviation(self, entity: Entity, properties: Properties) -> float | None:
        """Return the property 'path maximum deviation', mm, or None."""
        item = only("path maximum deviation", properties.get("path maximum deviation", []))
        measure = None if item is None else self.units.measure(item.entity)
        if measure is None:
            return None
        if not measure.value >= 0:
            text = f"path maximum deviation is {measure.value:g} mm; it must not be negative"
            raise entity.fault("stepnc-range", text)
        return measure.value

    def _dwell(self, entity: Entity, properties: Properties) -> tuple[float, float]:
        """Return how long a feedstop waits, s, and how many turns of the spindle: one of them is 0."""
        item = only("dwell", properties.get("dwell", []))
        measure = None if item is None else self.units.measure(item.entity)
        if item is not None and measure is not None:
            revolutions = "revolution" in item.representation.lower() or measure.unit.revolution
            return (0.0, measure.value) if revolutions else (measure.value, 0.0)
        entity.warn("stepnc-missing", "the feedstop has no property 'dwell': it does not wait")
        return 0.0, 0.0

    def _speed(self, properties: Properties) -> tuple[bool, float]:
        item = only("speed profile", properties.get("speed profile", []))
        if item is None:
            return False, 1.0
        if described(item):
            return described(item) == "rapid", 1.0
        if "CURVE" in item.entity.keyword or item.entity.keyword == "POLYLINE":
            text = "the speed profile along the path is not applied; the feed holds"
            item.entity.warn("stepnc-speed-profile", text)
            return False, 1.0
        measure = self.units.measure(item.entity)
        return False, measure.value if measure is not None and measure.value > 0 else 1.0

    def _pieces(
        self, entity: Entity, properties: Properties, tool: CuttingTool | None, tilt: Vector | None
    ) -> list[Piece]:
        """Return the path of the tip; `tool` is given where the basic curve is the path of the contact point."""
        hint = "a COMPOSITE_CURVE whose segments they are, or a toolpath for each of them"
        curve = only("basic curve of a trajectory", properties.get("basic curve", []), hint)
        if curve is None:
            named = ", ".join(map(repr, properties)) or "none"
            text = f"ISO 10303-238 demands a property 'basic curve' of a trajectory; there are: {named}"
            raise entity.fault("stepnc-missing", text)
        pieces = self.curves(curve.context).read(curve.entity.id, entity.id)
        axes = self._directions(entity, properties, "tool axis")
        if entity.text("description").strip().lower() == "cutter contact trajectory":
            normals = self._directions(entity, properties, "surface normal")
            if normals is None or tool is None or tool.diameter is None:
                text = "a path of the contact point needs a 'surface normal' and a tool with a diameter"
                raise entity.fault("stepnc-missing", text)
            upright = np.array([0.0, 0.0, 1.0]) if tilt is None else tilt
            pieces = locations(pieces, normals, axes, upright, tool.diameter / 2, tool.edge)
        elif axes is not None:
            pieces = list[Piece](couple(pieces, axes))
        backwards = any(described(i) == "end to beginning" for i in properties.get("direction", []))
        return reverse(pieces) if backwards else pieces

    def _directions(self, entity: Entity, properties: Properties, name: str) -> list[Piece] | None:
        """Return the curve of directions that a property gives (constant for one DIRECTION), None without it."""
        item = only(name, properties.get(name, []))
        if item is None:
            return None
        if item.entity.keyword == "DIRECTION":
            direction = self.curves(item.context).placements.direction(item.entity.id)
            return [Polyline(np.stack([direction, direction]))]
        return CurveReader(self.entities, 1.0, math.pi / 180).read(item.entity.id, entity.id)

    def leans(self, action_property: int) -> bool:
        """Tell whether a property 'tool axis' or 'tool direction' has a direction that leaves Z."""
        for link in self.graph.index("ACTION_PROPERTY_REPRESENTATION", 0).of(action_property):
            try:
                items = self.graph.items(self.entities.get(link).entity("representation").id)
                if any(map(self._item_leans, items)):
                    return True
            except Skip:
                continue
        return False

    def _item_leans(self, item: Item) -> bool:
        curves, kind = self.curves(item.context), item.entity.keyword
        if kind == "DIRECTION":
            return bool(curves.placements.direction(item.entity.id)[2] < 1.0 - 1e-12)
        return ("CURVE" in kind or kind == "POLYLINE") and curves.leans(item.entity.id)

    def turns_frame(self, action_property: int) -> bool:
        """Tell whether a property 'toolpath orientation' tilts what it holds for."""
        for link in self.graph.index("ACTION_PROPERTY_REPRESENTATION", 0).of(action_property):
            try:
                items = self.graph.items(self.entities.get(link).entity("representation").id)
                frames = [self.curves(i.context).placements.placement(i.entity.id) for i in items]
            except Skip:
                continue
            if any(abs(f[2, 2] - 1.0) > 1e-12 for f in frames):
                return True
        return False
