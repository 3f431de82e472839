"""The operations of the AIM and their strategies as records."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from cncgen.stepnc.ap238.graph import Graph, Item
from cncgen.stepnc.ap238.technology import Resources, described
from cncgen.stepnc.ap238.toolpaths import Properties, Toolpaths
from cncgen.stepnc.ap238.units import Units
from cncgen.stepnc.entities import Entity, only
from cncgen.stepnc.geometry.frames import Vector
from cncgen.stepnc.model import RATIOS, MachiningStrategy, Operation
from cncgen.stepnc.part21 import Ref, Typed

_KINDS = {
    "FREEFORM_MILLING_OPERATION": "freeform",
    "MILLING_TYPE_OPERATION": "freeform",
    "MACHINING_OPERATION": "freeform",
    "MACHINING_TOUCH_PROBING": "probing",
    "PLANE_MILLING_OPERATION": "plane",
    "SIDE_MILLING_OPERATION": "side",
    "BOTTOM_AND_SIDE_MILLING_OPERATION": "bottom and side",
    "DRILLING_OPERATION": "drilling",
    "BORING_OPERATION": "boring",
    "BACK_BORING_OPERATION": "back boring",
    "TAPPING_OPERATION": "tapping",
    "TURNING_TYPE_OPERATION": "turning",
    "FACING_TURNING_OPERATION": "facing",
    "CONTOURING_TURNING_OPERATION": "contouring",
    "GROOVING_TURNING_OPERATION": "grooving",
    "THREADING_TURNING_OPERATION": "threading",
    "KNURLING_TURNING_OPERATION": "knurling",
}
#: Kinds that rough or finish.
_TWO_STEPS = ("plane", "side", "bottom and side", "facing", "contouring", "grooving", "threading")
#: Properties of operations whose names in ISO 14649 are not the same with underscores.
_VALUE_NAMES = {
    "overlap ratio": "overlap",
    "feedrate on retract": "feed_on_retract",
    "multiple passes": "allow_multiple_passes",
    "reduced feedrate at start": "reduced_feed_at_start",
    "reduced feedrate at end": "reduced_feed_at_end",
    "testcut depth": "depth_of_testcut",
    "plunge angle": "angle",
    "plunge radius": "radius",
    "plunge width": "width",
    "travel angle": "angle",
    "travel radius": "radius",
    "lift feedrate": "lift_feed",
    "stepover feedrate": "stepover_feed",
    "cut in amount": "cut_in_amount_function",
    "dwell time": "dwell",
}
#: Properties that say yes or no in words: ``multiple passes not allowed``.
_FLAGS = frozenset(
    [
        "allow_multiple_passes",
        "spindle_stop_at_bottom",
        "compensation_chuck",
        "helical_movement_on_forward",
    ]
)
_NO = re.compile(r"\b(no|not|off|false)\b")
_ROTATIONS = {"clockwise": "CW", "counterclockwise": "CCW", "counter clockwise": "CCW"}
_PLACED = ("CARTESIAN_POINT", "AXIS2_PLACEMENT_3D", "PLANE")


class Operations:
    """Reads operations, their values and strategies."""

    def __init__(self, graph: Graph, units: Units, resources: Resources, toolpaths: Toolpaths) -> None:
        self.graph = graph
        self.units = units
        self.resources = resources
        self.toolpaths = toolpaths

    def read(self, entity: Entity) -> Operation:
        """Return an operation.

        Raises:
            Skip: where it has a fault.
        """
        if entity.keyword not in _KINDS:
            raise entity.fault("stepnc-unsupported", "this operation cannot be executed")
        properties = self.graph.properties(entity.id)
        tilt = self.tilt(entity, properties)
        paths = self.toolpaths.read(entity.id, tilt)
        values = self._values(properties)
        strategies = self._strategies(entity.id)
        start = self.toolpaths.placed(properties, "cut start point", "CARTESIAN_POINT")
        return Operation(
            ident=entity.id,
            label=entity.text("name"),
            kind=self._kind(entity),
            paths=paths or None,
            tool=self.resources.tool(entity.id),
            technology=self.resources.technology(entity.id),
            functions=self.resources.functions(entity.id),
            retract_plane=values.pop("retract_plane", None),
            start_point=None if start is None else start[1].point(start[0].id),
            values=values,
            strategy=strategies.get("machining"),
            approach=strategies.get("approach"),
            retract=strategies.get("retract"),
            tilt=tilt,
        )

    def _kind(self, entity: Entity) -> str:
        kind, detail = _KINDS[entity.keyword], entity.text("description").strip().lower()
        if kind in _TWO_STEPS and detail != "cutting in":
            return f"{kind} {'finish' if 'finish' in detail else 'rough'}"
        if kind in ("drilling", "boring", "tapping", "grooving") and detail:
            return detail
        return kind

    def tilt(self, entity: Entity, properties: Properties) -> Vector | None:
        """Return the tool's direction in the operation's frame, None where it is Z.

        Raises:
            Skip: where it follows from the path in a way that cannot be made.
        """
        item = only("tool direction", properties.get("tool direction", []))
        if item is not None:
            kind = item.representation.strip().lower()
            if item.entity.keyword == "DIRECTION":
                axis = self.toolpaths.curves(item.context).placements.direction(item.entity.id)
                return None if np.allclose(axis, [0.0, 0.0, 1.0], atol=1e-12) else axis
            if kind.startswith("five axes const"):
                measure = self.units.measure(item.entity)
                if measure is not None and abs(measure.value) > 1e-12:
                    text = "a tilt and yaw against the path's direction cannot be made"
                    raise entity.fault("stepnc-unsupported", text)
        return None

    def _values(self, properties: Properties) -> dict[str, Any]:
        """Return the measures, directions and words of properties under the names of ISO 14649."""
        out: dict[str, Any] = {}
        for name, items in properties.items():
            key = _VALUE_NAMES.get(name, name.replace(" ", "_"))
            given = [item for item in items if self._value(key, item) is not None]
            item = only(name, given)
            if item is not None:
                out[key] = self._value(key, item)
        if "dwell" in out and not self._waits(properties):
            out["dwell_turns"] = out.pop("dwell")
        return out

    def _waits(self, properties: Properties) -> bool:
        """Tell whether a dwell is a time, and no number of turns."""
        measures = [
            self.units.measure(i.entity) for n in ("dwell", "dwell time") for i in properties.get(n, [])
        ]
        return any(m is not None and m.unit.time == 1 for m in measures)

    def _value(self, key: str, item: Item) -> Any:
        """Return what an item says: a direction, words (yes or no as a truth value), a number; None for anything else."""
        text = described(item)
        if item.entity.keyword == "DIRECTION":
            return self.toolpaths.curves(item.context).placements.direction(item.entity.id)
        if text:
            return not _NO.search(text) if key in _FLAGS else _ROTATIONS.get(text, text)
        if item.entity.keyword in _PLACED:
            return None
        if item.entity.keyword == "COMPOUND_REPRESENTATION_ITEM":
            return self._list(item.entity)
        measure = self.units.measure(item.entity)
        if measure is None:
            return None
        return item.entity.ratio(key, measure.value) if key in RATIOS else measure.value

    def _list(self, entity: Entity) -> tuple[float, ...] | None:
        """Return the measures of a list, None where it has none."""
        members = next((p.value for p in entity.parameters if isinstance(p, Typed)), ())
        idents = [int(m) for m in members if isinstance(m, Ref)] if isinstance(members, tuple) else []
        found = [self.units.measure(self.graph.entities.get(i, owner=entity.id)) for i in idents]
        return tuple(m.value for m in found if m is not None) or None

    def _strategies(self, operation: int) -> dict[str, MachiningStrategy]:
        out: dict[str, MachiningStrategy] = {}
        for name, entity in self.graph.relation_names(operation, "MACHINING_STRATEGY_RELATIONSHIP"):
            kind = entity.text("description").strip().lower().replace("approach retract", "ap retract")
            kind = "drilling type strategy" if entity.keyword == "DRILLING_TYPE_STRATEGY" else kind
            values = self._values(self.graph.properties(entity.id))
            key = name.strip().lower()
            self.graph.entities.only(
                f"{key} strategy", [*([out[key].ident] if key in out else []), entity.id]
            )
            out[key] = MachiningStrategy(entity.id, kind, values)
        return out
