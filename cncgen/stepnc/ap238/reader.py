"""The executables of an AIM file: workplans, workingsteps, rapid movements, functions, toolpaths."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cncgen.diagnostics import Severity
from cncgen.stepnc.ap238.features import Features
from cncgen.stepnc.ap238.graph import Graph, Item
from cncgen.stepnc.ap238.technology import Resources, described
from cncgen.stepnc.ap238.units import Units
from cncgen.stepnc.entities import Entities, Entity, Skip
from cncgen.stepnc.execution.linearize import couple
from cncgen.stepnc.geometry.contact import locations
from cncgen.stepnc.geometry.curves import Curves
from cncgen.stepnc.geometry.frames import Matrix, Placements, identity
from cncgen.stepnc.geometry.pieces import Piece, Polyline, reverse
from cncgen.stepnc.model import (
    Block,
    Executable,
    NcFunction,
    Operation,
    Path,
    Paths,
    Strategy,
    Tool,
    Workingstep,
)
from cncgen.stepnc.part21 import Exchange

_OPERATION_KINDS = {
    "FREEFORM_MILLING_OPERATION": "freeform",
    "MILLING_TYPE_OPERATION": "freeform",
    "MACHINING_OPERATION": "freeform",
    "PLANE_MILLING_OPERATION": "plane",
    "SIDE_MILLING_OPERATION": "side",
    "BOTTOM_AND_SIDE_MILLING_OPERATION": "bottom and side",
    "DRILLING_OPERATION": "drilling",
    "BORING_OPERATION": "boring",
    "BACK_BORING_OPERATION": "back boring",
    "TAPPING_OPERATION": "tapping",
}
#: Properties of operations whose names in ISO 14649 are not the same with underscores.
_VALUE_NAMES = {
    "overlap ratio": "overlap",
    "feedrate on retract": "feed_on_retract",
    "multiple passes": "allow_multiple_passes",
    "plunge angle": "angle",
    "plunge radius": "radius",
}
_CURVES = ("basic curve", "tool axis", "surface normal", "tool reference direction")


class Ap238Reader:
    """Reads executables when the executor asks for them."""

    def __init__(self, exchange: Exchange) -> None:
        self.exchange = exchange
        self.entities = Entities(exchange, iso=False)
        self.graph = Graph(self.entities)
        self.units = Units(self.entities)
        self.resources = Resources(self.graph, self.units)
        self.features = Features(self.graph, self.units)
        self._curves: dict[tuple[float, float], Curves] = {}

    def variables(self) -> dict[str, float]:
        """Return no variables: the AIM has none that are read here."""
        return {}

    def curves(self, context: int | None) -> Curves:
        """Return the reader of curves in the units of a context.

        Raises:
            Skip: where the units have a fault.
        """
        key = self.units.context(context)
        if key not in self._curves:
            self._curves[key] = Curves(self.entities, *key)
        return self._curves[key]

    def roots(self) -> list[Executable]:
        """Return the workplans that a project's process chooses, else those that no other holds."""
        chosen = []
        for instance in self.exchange.instances("PRODUCT_DEFINITION_PROCESS"):
            try:
                entity = self.entities.get(instance.id)
            except Skip:
                continue
            method = entity.get("chosen_method")
            if entity.text("name").strip().lower() == "machining" and isinstance(method, int):
                chosen.append(int(method))
        plans = [i.id for i in self.exchange.instances("MACHINING_WORKPLAN")]
        held = set()
        for relation in self.exchange.rows_of_type("MACHINING_PROCESS_SEQUENCE_RELATIONSHIP").tolist():
            held.update(self.exchange.links_of(relation)[1:2].tolist())
        roots = [p for p in dict.fromkeys(chosen) if p in set(plans)] or [p for p in plans if p not in held]
        if not roots:
            text = "there is no MACHINING_WORKPLAN that is not held by another: nothing is executed"
            self.exchange.reporter.report("stepnc-no-project", text, 0)
        out = []
        for root in roots:
            try:
                out.append(self.executable(root, identity()))
            except Skip:
                continue
        return out

    def executable(self, ident: int, context: Any) -> Executable:
        """Return an executable within a block; `context` is the frame of its toolpaths.

        Raises:
            Skip: where it has a fault.
        """
        entity = self.entities.get(ident)
        kind, label = entity.keyword, entity.text("name")
        if kind == "MACHINING_WORKPLAN":
            return self._workplan(entity, context)
        if kind == "MACHINING_WORKINGSTEP":
            return self._workingstep(entity, context)
        if kind == "MACHINING_RAPID_MOVEMENT":
            properties = self.graph.properties(ident)
            frame = self._frame(properties, context)
            operation = Operation(ident, label, "rapid", self._paths(ident))
            return Workingstep(
                ident, label, operation, None, frame, self._security(properties, frame), rapid=True
            )
        if kind == "MACHINING_NC_FUNCTION":
            properties = self.graph.properties(ident)
            texts = [described(i) for items in properties.values() for i in items]
            name = entity.text("description").strip().lower()
            return NcFunction(
                ident, label, name, {"text": next((t for t in texts if t), label), "value": label}
            )
        return self._process(entity, context)

    def _workplan(self, entity: Entity, frame: Matrix) -> Block:
        properties = self.graph.properties(entity.id)
        children = self.graph.related(entity.id, "MACHINING_PROCESS_SEQUENCE_RELATIONSHIP")
        inner = self._frame(properties, frame)
        self._note_setup(entity)
        return Block(entity.id, entity.text("name"), "workplan", tuple(c.id for c in children), inner)

    def _note_setup(self, plan: Entity) -> None:
        for process in self.graph.index("PRODUCT_DEFINITION_PROCESS", 0).of(plan.id):
            if self.entities.get(process).text("name").strip().lower() != "setup":
                continue
            for origin in self.features.setup_origins(process):
                if not np.allclose(origin, np.eye(4), atol=1e-9):
                    x, y, z = origin[:3, 3]
                    text = f"#{plan.id}: the setup stands at ({x:g}, {y:g}, {z:g}) mm: a work offset, not applied"
                    self.exchange.report(plan.id, "stepnc-work-offset", text, severity=Severity.NOTE)

    def _process(self, entity: Entity, context: Any) -> Executable:
        """Return an executable of several branches."""
        branches = self.graph.related(entity.id, "MACHINING_PROCESS_CONCURRENT_RELATIONSHIP")
        if branches:
            return Block(entity.id, entity.text("name"), "parallel", tuple(b.id for b in branches), context)
        kind = entity.text("description").strip().lower().replace("-", " ")
        members = self.graph.related(entity.id, "MACHINING_PROCESS_SEQUENCE_RELATIONSHIP")
        members += self.graph.related(entity.id, "MACHINING_PROCESS_BRANCH_RELATIONSHIP")
        if kind in ("non sequential", "selective") and members:
            return Block(entity.id, entity.text("name"), kind, tuple(m.id for m in members), context)
        raise entity.fault(
            "stepnc-unsupported", f"this executable ({kind or 'of no kind'}) cannot be executed"
        )

    # Frames

    def _placement(
        self, properties: dict[str, list[Item]], name: str, *kinds: str
    ) -> tuple[Entity, Placements] | None:
        for item in properties.get(name, []):
            if item.entity.keyword in kinds:
                return item.entity, self.curves(item.context).placements
        return None

    def _frame(self, properties: dict[str, list[Item]], outer: Matrix) -> Matrix:
        found = self._placement(properties, "toolpath orientation", "AXIS2_PLACEMENT_3D")
        return outer if found is None else outer @ found[1].placement(found[0].id)

    def _security(self, properties: dict[str, list[Item]], frame: Matrix) -> Matrix | None:
        found = self._placement(properties, "security plane", "PLANE", "ELEMENTARY_SURFACE")
        if found is not None:
            plane = found[1].plane(found[0].id)
            return None if plane is None else frame @ plane
        bare = self._placement(properties, "security plane", "AXIS2_PLACEMENT_3D")
        return None if bare is None else frame @ bare[1].placement(bare[0].id)

    # Workingsteps

    def _workingstep(self, entity: Entity, outer: Matrix) -> Workingstep:
        properties = self.graph.properties(entity.id)
        frame = self._frame(properties, outer)
        operations = self.graph.related(entity.id, "MACHINING_OPERATION_RELATIONSHIP")
        if not operations:
            raise entity.fault("stepnc-missing", "the workingstep has no operation")
        if len(operations) > 1:
            raise entity.fault(
                "stepnc-unsupported", f"the workingstep has {len(operations)} operations, not one"
            )
        operation = self._operation(operations[0])
        security = self._security(properties, frame)
        feature = None
        if operation.paths is None:
            feature = self.features.of_workingstep(entity.id)
            frame = frame if feature is None else frame @ feature.placement
        return Workingstep(entity.id, entity.text("name"), operation, feature, frame, security)

    def _operation(self, entity: Entity) -> Operation:
        if entity.keyword not in _OPERATION_KINDS:
            raise entity.fault("stepnc-unsupported", "this operation cannot be executed")
        paths = self._paths(entity.id)
        properties = self.graph.properties(entity.id)
        values = self._values(properties)
        strategies = self._strategies(entity.id)
        start = self._placement(properties, "cut start point", "CARTESIAN_POINT")
        return Operation(
            entity.id,
            entity.text("name"),
            self._kind(entity),
            paths or None,
            self.resources.tool(entity.id),
            self.resources.technology(entity.id),
            self.resources.functions(entity.id),
            values.pop("retract_plane", None),
            None if start is None else start[1].point(start[0].id),
            values,
            strategies.get("machining"),
            strategies.get("approach"),
            strategies.get("retract"),
        )

    def _kind(self, entity: Entity) -> str:
        kind, detail = _OPERATION_KINDS[entity.keyword], entity.text("description").strip().lower()
        if kind in ("plane", "side", "bottom and side"):
            return f"{kind} {'finish' if 'finish' in detail else 'rough'}"
        if kind in ("drilling", "boring", "tapping") and detail:
            return detail
        return kind

    def _values(self, properties: dict[str, list[Item]]) -> dict[str, Any]:
        """Return the measures, directions and words of properties under the names of ISO 14649."""
        out: dict[str, Any] = {}
        for name, items in properties.items():
            key = _VALUE_NAMES.get(name, name.replace(" ", "_"))
            for item in items:
                if item.entity.keyword == "DIRECTION":
                    out[key] = self.curves(item.context).placements.direction(item.entity.id)
                elif described(item):
                    out[key] = described(item)
                elif item.entity.keyword not in ("CARTESIAN_POINT", "AXIS2_PLACEMENT_3D", "PLANE"):
                    measure = self.units.measure(item.entity)
                    if measure is not None:
                        out[key] = measure.value
        return out

    def _strategies(self, operation: int) -> dict[str, Strategy]:
        out = {}
        for name, entity in self.graph.relation_names(operation, "MACHINING_STRATEGY_RELATIONSHIP"):
            kind = entity.text("description").strip().lower()
            kind = "drilling type strategy" if entity.keyword == "DRILLING_TYPE_STRATEGY" else kind
            out[name.strip().lower()] = Strategy(
                entity.id, kind, self._values(self.graph.properties(entity.id))
            )
        return out

    # Toolpaths

    def _paths(self, owner: int) -> Paths:
        idents = self.graph.related_ids(owner, "MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP")
        return Paths(idents, lambda k: self._path(self.entities.get(idents[k], owner=owner), owner))

    def _path(self, entity: Entity, owner: int) -> Path:
        properties = self.graph.properties(entity.id)
        kind = entity.text("description").strip().lower()
        rapid, ratio = self._speed(properties)
        rapid = rapid or "connect" in {described(i) for i in properties.get("trajectory type", [])}
        technology, functions = self.resources.technology(entity.id), self.resources.functions(entity.id)
        if kind == "feedstop":
            seconds = 0.0
            for item in properties.get("dwell", []):
                measure = self.units.measure(item.entity)
                seconds = measure.value if measure is not None else seconds
            return Path(entity.id, "dwell", technology=technology, functions=functions, seconds=seconds)
        if kind in ("connect direct", "connect security plane"):
            return Path(entity.id, kind)
        if kind not in ("", "cutter location trajectory") and "basic curve" not in properties:
            raise entity.fault("stepnc-unsupported", f"a toolpath of kind {kind!r} cannot be executed")
        tool = self.resources.tool(owner) if kind == "cutter contact trajectory" else None
        return Path(
            entity.id,
            "trajectory",
            lambda: self._pieces(entity, properties, tool),
            rapid,
            ratio,
            technology,
            functions,
        )

    def _speed(self, properties: dict[str, list[Item]]) -> tuple[bool, float]:
        ratio = 1.0
        for item in properties.get("speed profile", []):
            if described(item):
                return described(item) == "rapid", 1.0
            if "CURVE" in item.entity.keyword or item.entity.keyword == "POLYLINE":
                text = "the speed profile along the path is not applied; the feed holds"
                item.entity.warn("stepnc-speed-profile", text)
                continue
            measure = self.units.measure(item.entity)
            ratio = measure.value if measure is not None and measure.value > 0 else ratio
        return False, ratio

    def _pieces(self, entity: Entity, properties: dict[str, list[Item]], tool: Tool | None) -> list[Piece]:
        """Return the path of the tip; `tool` is given where the basic curve is the path of the contact point."""
        basic = properties.get("basic curve", [])
        if not basic:
            raise entity.fault("stepnc-missing", "the toolpath has no property 'basic curve'")
        curve = basic[0]
        pieces = self.curves(curve.context).read(curve.entity.id, entity.id)
        axes = self._directions(entity, properties, "tool axis")
        if entity.text("description").strip().lower() == "cutter contact trajectory":
            normals = self._directions(entity, properties, "surface normal")
            if normals is None or tool is None or tool.diameter is None:
                text = "a path of the contact point needs a 'surface normal' and a tool with a diameter"
                raise entity.fault("stepnc-missing", text)
            upright = np.array([0.0, 0.0, 1.0])
            pieces = locations(pieces, normals, axes, upright, tool.diameter / 2, tool.edge)
        elif axes is not None:
            pieces = list[Piece](couple(pieces, axes))
        backwards = any(described(i) == "end to beginning" for i in properties.get("direction", []))
        return reverse(pieces) if backwards else pieces

    def _directions(self, entity: Entity, properties: dict[str, list[Item]], name: str) -> list[Piece] | None:
        """Return the curve of directions that a property gives (constant for one DIRECTION), None without it."""
        for item in properties.get(name, []):
            if item.entity.keyword == "DIRECTION":
                direction = self.curves(item.context).placements.direction(item.entity.id)
                return [Polyline(np.stack([direction, direction]))]
            return Curves(self.entities, 1.0, math.pi / 180).read(item.entity.id, entity.id)
        return None

    def needs_rotary(self) -> bool:
        """Tell whether a tool axis may leave the machine's Z: by tool axes or tilted toolpath frames."""
        for instance in self.exchange.instances("ACTION_PROPERTY"):
            name = str(instance.parameters[0] if instance.parameters else "").strip().lower()
            if name == "tool axis":
                return True
            if name == "toolpath orientation" and self._is_tilted(instance.id):
                return True
        return any(self.features.tilted())

    def _is_tilted(self, ident: int) -> bool:
        for link in self.graph.index("ACTION_PROPERTY_REPRESENTATION", 0).of(ident):
            try:
                items = self.graph.items(self.entities.get(link).entity("representation").id)
                frames = [self.curves(i.context).placements.placement(i.entity.id) for i in items]
            except Skip:
                continue
            if any(abs(f[2, 2] - 1.0) > 1e-12 for f in frames):
                return True
        return False
