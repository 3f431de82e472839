"""The operations of ISO 14649-11 as records."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry.contact import Lean
from cncgen.stepnc.geometry.frames import Placements, Vector
from cncgen.stepnc.iso14649.technology import Resources
from cncgen.stepnc.iso14649.toolpaths import Toolpaths
from cncgen.stepnc.model import ANGLES, RATIOS, MachiningStrategy, Operation
from cncgen.stepnc.part21 import DERIVED, Enumeration, Ref, Typed
from cncgen.stepnc.schema.tables import positions
from cncgen.stepnc.schema.turning import OPERATIONS as TURNING_OPERATIONS

_OPERATIONS = (
    "FREEFORM_OPERATION",
    "PLANE_ROUGH_MILLING",
    "PLANE_FINISH_MILLING",
    "SIDE_ROUGH_MILLING",
    "SIDE_FINISH_MILLING",
    "BOTTOM_AND_SIDE_ROUGH_MILLING",
    "BOTTOM_AND_SIDE_FINISH_MILLING",
    "DRILLING",
    "CENTER_DRILLING",
    "COUNTER_SINKING",
    "BACK_BORING",
    "MULTISTEP_DRILLING",
    "BORING",
    "REAMING",
    "TAPPING",
    "THREAD_DRILLING",
    *TURNING_OPERATIONS,
)
#: Attributes that have a place of their own in `Operation`.
_HEAD = frozenset(
    [
        "its_toolpath",
        "its_tool_direction",
        "its_id",
        "retract_plane",
        "start_point",
        "its_tool",
        "its_technology",
        "its_machine_functions",
        "approach",
        "retract",
        "its_machining_strategy",
    ]
)


def kind_of(keyword: str) -> str:
    """Return ``bottom and side rough`` for BOTTOM_AND_SIDE_ROUGH_MILLING, ``freeform`` for FREEFORM_OPERATION."""
    name = keyword.lower()
    for ending in ("_operation", "_milling"):
        name = name.removesuffix(ending)
    return name.replace("_", " ")


class Operations:
    """Reads operations and their strategies."""

    def __init__(
        self, entities: Entities, placements: Placements, resources: Resources, toolpaths: Toolpaths
    ) -> None:
        self.entities = entities
        self.placements = placements
        self.resources = resources
        self.toolpaths = toolpaths

    def read(self, entity: Entity) -> Operation:
        """Return an operation.

        Raises:
            Skip: where it has a fault.
        """
        if entity.keyword not in _OPERATIONS:
            raise entity.fault("stepnc-unsupported", "this operation cannot be executed")
        toolpath, start = entity.ref("its_toolpath"), entity.ref("start_point")
        tool = self.resources.tool(entity.ref("its_tool"))
        lean = None if toolpath is None else self._lean(entity)
        tilt = self.tilt(entity) if lean is None else None
        return Operation(
            ident=entity.id,
            label=entity.text("its_id"),
            kind=kind_of(entity.keyword),
            paths=None
            if toolpath is None
            else self.toolpaths.read(toolpath, tool, tilt if lean is None else lean),
            tool=tool,
            technology=self.resources.technology(entity.ref("its_technology")),
            functions=self.resources.functions(entity.ref("its_machine_functions")),
            retract_plane=entity.optional("retract_plane"),
            start_point=None if start is None else self.placements.point(start, entity.id),
            values=self._values(entity),
            strategy=self._strategy(entity, "its_machining_strategy"),
            approach=self._strategy(entity, "approach"),
            retract=self._strategy(entity, "retract"),
            tilt=tilt,
        )

    def _values(self, entity: Entity) -> dict[str, Any]:
        """Return the further attributes by name: numbers, truth values, names, points and directions."""
        out: dict[str, Any] = {}
        for name in positions(entity.keyword, True):
            value = entity.get(name)
            if name in _HEAD or name == "others" or value is None or value is DERIVED:
                continue
            if isinstance(value, Typed):
                name = "dwell_turns" if value.type == "DWELL_REVOLUTION" else name
                value = value.value
            if isinstance(value, tuple) and all(type(v) in (int, float) for v in value):
                out[name] = tuple(entity.within(name, v) for v in value if isinstance(v, int | float))
            elif isinstance(value, Enumeration):
                out[name] = {"T": True, "F": False}.get(str(value), str(value))
            elif isinstance(value, Ref):
                vector = self._vector(entity, int(value))
                if vector is not None:
                    out[name] = vector
            elif isinstance(value, int | float):
                scale = self.toolpaths.curves.angle if name in ANGLES else 1.0
                out[name] = entity.ratio(name, float(value)) if name in RATIOS else float(value) * scale
        return out

    def _vector(self, entity: Entity, ident: int) -> Vector | None:
        """Return a direction or point; None for anything else, which the check of the file reports."""
        kind = self.entities.keyword(ident)
        if kind == "DIRECTION":
            return self.placements.direction(ident, entity.id)
        if kind == "CARTESIAN_POINT":
            return self.placements.point(ident, entity.id)
        return None

    def _strategy(self, entity: Entity, name: str) -> MachiningStrategy | None:
        ident = entity.ref(name)
        if ident is None:
            return None
        strategy = self.entities.get(ident, owner=entity.id)
        return MachiningStrategy(ident, kind_of(strategy.keyword), self._values(strategy))

    def tilt(self, entity: Entity) -> Vector | None:
        """Return the tool's direction in the operation's frame, None where it is Z.

        Raises:
            Skip: where it follows from the path in a way that cannot be made.
        """
        ident = entity.ref("its_tool_direction")
        direction = self.entities.optional(ident)
        if direction is None or direction.keyword in ("THREE_AXES", "TWO_AXES", "FIVE_AXES_VAR_TILT_YAW"):
            return None
        if direction.keyword == "THREE_AXES_TILTED_TOOL":
            axis = self.placements.direction(direction.entity("its_tool_direction").id, direction.id)
            return None if np.allclose(axis, [0.0, 0.0, 1.0], atol=1e-12) else axis
        tilt, yaw = direction.number("tilt_angle", 0.0), direction.number("yaw_angle", 0.0)
        if math.hypot(tilt, yaw) > 1e-12:
            text = "a tilt and yaw against path and surface need toolpaths with the surface's normals"
            raise direction.fault("stepnc-unsupported", text)
        return None

    def _lean(self, entity: Entity) -> Lean | None:
        """Return the constant tilt and yaw of an operation, None where it has another tool direction.

        Raises:
            Skip: where a tool with these angles is not above the surface.
        """
        direction = self.entities.optional(entity.ref("its_tool_direction"))
        if direction is None or direction.keyword != "FIVE_AXES_CONST_TILT_YAW":
            return None
        if direction.number("tilt_angle", 0.0) == 0.0 == direction.number("yaw_angle", 0.0):
            return None
        scale = self.toolpaths.curves.angle
        tilt, yaw = (direction.number(name, 0.0) * scale for name in ("tilt_angle", "yaw_angle"))
        if not (abs(tilt) < math.pi / 2 and abs(yaw) <= 2 * math.pi):
            text = f"tilt_angle is {math.degrees(tilt):g} and yaw_angle {math.degrees(yaw):g} degrees; within ±90 and ±360 can be made"
            raise direction.fault("stepnc-geometry", text)
        if abs(yaw) > 1e-12 and abs(tilt) > 1e-12:
            text = f"the yaw of {math.degrees(yaw):g} degrees is taken by the right hand about the surface's normal"
            direction.warn("stepnc-yaw", text)
        return Lean(tilt, yaw)
