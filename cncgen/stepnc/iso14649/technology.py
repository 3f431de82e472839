"""Technology, machine functions and tools of ISO 14649."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.model import CuttingTool, Functions, Technology
from cncgen.stepnc.part21 import Enumeration, Ref, Typed

_T = TypeVar("_T")

DEGREE = math.pi / 180.0
#: Tip angles from here to 2 are taken as radians: 5 degrees and more.
LEAST_RADIANS = 0.087
#: Bodies of turning tools (ISO 14649-121), which are tools by themselves in its second edition.
_TURNING_BODIES = (
    "GENERAL_TURNING_TOOL",
    "GROOVING_TOOL",
    "TURNING_THREADING_TOOL",
    "USER_DEFINED_TURNING_TOOL",
)
#: Attributes that all bodies have before their own.
_OWN_OF_BODY = 7


class Resources:
    """Reads what operations share, each entity once."""

    def __init__(self, entities: Entities) -> None:
        self.entities = entities
        self._kept: dict[tuple[str, int], Any] = {}

    def technology(self, ident: int | None) -> Technology | None:
        """Return a MILLING_TECHNOLOGY; m/s become mm/s, rev/s stay.

        Raises:
            Skip: where the entity is of another type, or at fault.
        """
        return None if ident is None else self._keep(ident, self._technology)

    def functions(self, ident: int | None) -> Functions | None:
        """Return MILLING_MACHINE_FUNCTIONS.

        Raises:
            Skip: where the entity is of another type, or at fault.
        """
        return None if ident is None else self._keep(ident, self._functions)

    def tool(self, ident: int | None) -> CuttingTool | None:
        """Return a MILLING_CUTTING_TOOL with the dimensions of its body.

        Raises:
            Skip: where the entity is of another type, or at fault.
        """
        return None if ident is None else self._keep(ident, self._tool)

    def _keep(self, ident: int, read: Callable[[int], _T]) -> _T:
        key = (read.__name__, ident)
        if key not in self._kept:
            self._kept[key] = read(ident)
        return self._kept[key]

    def _technology(self, ident: int) -> Technology:
        entity = self.entities.get(ident, "MILLING_TECHNOLOGY", "TURNING_TECHNOLOGY", "TECHNOLOGY")
        if entity.keyword == "TURNING_TECHNOLOGY":
            return self._turning(entity)
        feed, cutting = entity.optional("feedrate"), entity.optional("cutspeed")
        for name, value in (("feedrate", feed), ("cutspeed", cutting)):
            if value is not None and not value >= 0:
                raise entity.fault("stepnc-speed", f"{name} is {value:g} m/s, not positive")
        if entity.enum("feedrate_reference") == "CCP":
            text = "the feed is meant at the cutter contact point; it is kept at the tool centre point"
            entity.warn("stepnc-feed-reference", text)
        if (
            entity.get("its_adaptive_control") is not None
            and entity.flag("its_adaptive_control") is not False
        ):
            entity.warn("stepnc-adaptive", "adaptive control is not done")
        return Technology(
            ident,
            None if feed is None else feed * 1000.0,
            entity.optional("feedrate_per_tooth"),
            None,
            entity.optional("spindle"),
            None if cutting is None else cutting * 1000.0,
            entity.flag("synchronize_spindle_with_feed") is True,
        )

    def _turning(self, entity: Entity) -> Technology:
        """Return a TURNING_TECHNOLOGY (ISO 14649-12): m/s become mm/s; rev/s and mm a turn stay."""
        feed, spindle, cutting, most, with_clock = entity.optional("feedrate"), None, None, None, False
        speed = self.entities.optional(entity.ref("spindle_speed"))
        if speed is not None and speed.keyword == "CONST_CUTTING_SPEED":
            cutting, most = speed.number("speed") * 1000.0, speed.optional("max_speed")
            with_clock = most is not None and most < 0
        elif speed is not None:
            spindle = self.entities.get(speed.id, "CONST_SPINDLE_SPEED", owner=entity.id).number("rot_speed")
        given = (feed, entity.optional("feed_per_revolution"), cutting)
        if any(v is not None and not v >= 0 for v in given):
            raise entity.fault("stepnc-speed", "a feed or cutting speed is not positive")
        return Technology(
            entity.id,
            None if feed is None else feed * 1000.0,
            feed_per_rev=given[1],
            spindle=spindle,
            cutting_speed=-cutting if with_clock and cutting is not None else cutting,
            synchronised=entity.flag("sync_spindle_and_z_feed") is True,
            max_spindle=most,
        )

    def _functions(self, ident: int) -> Functions:
        entity = self.entities.get(ident, "MILLING_MACHINE_FUNCTIONS", "TURNING_MACHINE_FUNCTIONS")
        if entity.keyword == "TURNING_MACHINE_FUNCTIONS":
            return Functions(ident, entity.flag("coolant")).by_way_of(entity.enum("coolant_type").lower())
        others = {}
        if entity.get("oriented_spindle_stop") is not None:
            others["oriented spindle stop"] = True
        for other in entity.refs("other_functions"):
            others[self.entities.get(other).text("parameter_name") or f"#{other}"] = True
        mist, through = entity.flag("mist"), entity.flag("through_spindle_coolant")
        return Functions(ident, entity.flag("coolant"), mist, through, others)

    def _tool(self, ident: int) -> CuttingTool:
        entity = self.entities.get(
            ident,
            "MILLING_CUTTING_TOOL",
            "CUTTING_TOOL",
            "USER_DEFINED_TOOL",
            "MACHINING_TOOL",
            "TURNING_MACHINE_TOOL",
            "TURNING_CUTTING_TOOL",
            *_TURNING_BODIES,
        )
        name = entity.text("its_id") or f"#{ident}"
        if entity.keyword in _TURNING_BODIES:
            return self._turning_tool(ident, None, entity)
        if entity.keyword.startswith("TURNING_"):
            body_id = entity.get("its_tool_body")
            body = self.entities.get(int(body_id), owner=ident) if isinstance(body_id, Ref) else None
            return self._turning_tool(ident, name, body)
        body_id = entity.ref("its_tool_body")
        if body_id is None:
            return CuttingTool(ident, name)
        body = self.entities.get(body_id, owner=ident)
        dimension_id = body.ref("dimension")
        size = (
            self.entities.get(dimension_id, "MILLING_TOOL_DIMENSION", owner=body_id) if dimension_id else None
        )
        edges = entity.refs("its_cutting_edge")
        offset = self.entities.get(edges[0]).optional("tool_offset_length") if edges else None
        teeth = body.optional("number_of_teeth")
        return CuttingTool(
            ident,
            name,
            body.keyword.lower().replace("_", " "),
            teeth=None if teeth is None else int(teeth),
            offset_length=offset,
            left_handed=body.enum("hand_of_cut") == "LEFT",
            **(self._dimensions(size) if size else {}),
        )

    def _turning_tool(self, ident: int, name: str | None, body: Entity | None) -> CuttingTool:
        """Return a tool of ISO 14649-121: with its body (first edition), or as an entity by itself (`name` None)."""
        if body is None or body.keyword not in _TURNING_BODIES:
            return CuttingTool(ident, name or f"#{ident}", "turning tool")
        values = [v.value if isinstance(v, Typed) else v for v in body.parameters]
        own = _OWN_OF_BODY + (1 if name is None else 0)
        if name is None:
            name = str(values[0]) if isinstance(values[0], str) else f"#{ident}"

        def number(k: int) -> float | None:
            value = values[k] if k < len(values) else None
            return body.within("a size", value) if type(value) in (int, float) else None  # type: ignore[arg-type]

        kind = {"GROOVING_TOOL": "grooving tool", "TURNING_THREADING_TOOL": "threading tool"}
        left = any(str(v).upper() == "LEFT" for v in values if isinstance(v, Enumeration))
        made = CuttingTool(ident, name, kind.get(body.keyword, "turning tool"), left_handed=left)
        if body.keyword == "GROOVING_TOOL":
            made = replace(made, width=number(own), cutting_length=number(own + 1), nose=number(own + 2))
        elif body.keyword == "TURNING_THREADING_TOOL":
            made = replace(made, pitch=number(own))
        sizes = next((v for v in values if isinstance(v, Ref)), None)
        size = None if sizes is None else self.entities.get(int(sizes), owner=body.id)
        if size is not None and size.keyword == "TURNING_TOOL_DIMENSION":
            nose, end = size.optional("nose_radius"), size.optional("end_cutting_edge_angle")
            made = replace(made, cutting_length=made.cutting_length or size.optional("cutting_edge_length"))
            trailing = None if end is None else end * DEGREE
            made = replace(made, nose=made.nose if nose is None else nose, trailing=trailing)
        elif size is not None and size.keyword == "CUTTING_EDGE_PROPERTIES":
            made = self._edge(made, size)
        for what, value in (("nose radius", made.nose), ("width", made.width)):
            if value is not None and not value >= 0:
                raise body.fault("stepnc-tool", f"the tool's {what} is {value:g} mm; it must not be below 0")
        return made

    def _edge(self, tool: CuttingTool, edge: Entity) -> CuttingTool:
        """Return a turning tool with the corner and angles of its CUTTING_EDGE_PROPERTIES (second edition)."""
        lead, between = edge.optional("tool_cutting_edge_angle"), edge.optional("tool_included_angle")
        trailing = None if lead is None or between is None else (180.0 - lead - between) * DEGREE
        nose = tool.nose
        for ident in edge.refs("corner_transitions"):
            corner = self.entities.get(ident, "CORNER_TRANSITION", owner=edge.id).entity("transition")
            if corner.keyword == "ROUNDED_CORNER":
                given = corner.get("corner_radius")
                measured = self.entities.get(int(given), owner=corner.id) if isinstance(given, Ref) else None
                nose = (
                    corner.number("corner_radius")
                    if measured is None
                    else measured.number("theoretical_size")
                )
        length = tool.cutting_length or edge.optional("cutting_edge_length")
        return replace(tool, nose=nose, trailing=trailing, cutting_length=length)

    def _dimensions(self, size: Entity) -> dict[str, float | None]:
        tip, around = size.optional("tool_top_angle"), size.optional("tool_circumference_angle")
        if tip is not None and 0 < tip < 2:
            text = (
                f"a tool tip angle of {tip:g}° makes no drill; it is taken as {tip / DEGREE:.4g}°, in radians"
            )
            if tip < LEAST_RADIANS:
                text = f"a tool tip angle of {tip:g}°; is it meant in radians?"
            size.warn("stepnc-angle", text)
            tip = tip if tip < LEAST_RADIANS else tip / DEGREE
        diameter = size.optional("diameter")
        if diameter is not None and not diameter > 0:
            raise size.fault("stepnc-tool", f"the tool's diameter is {diameter:g} mm; it must be above 0")
        return {
            "diameter": diameter,
            "tip_angle": None if tip is None else tip * DEGREE,
            "circumference_angle": None if around is None else around * DEGREE,
            "cutting_length": size.optional("cutting_edge_length"),
            "edge_radius": size.optional("edge_radius"),
            "edge_centre_vertical": size.optional("edge_center_vertical"),
            "edge_centre_horizontal": size.optional("edge_center_horizontal"),
        }


def speed_of(entity: Entity) -> tuple[bool, float]:
    """Return whether a toolpath's ``its_speed`` is rapid, and the factor of the feed."""
    value = entity.get("its_speed")
    while isinstance(value, Typed):
        value = value.value
    if isinstance(value, Enumeration):
        return value == "RAPID", 1.0
    if isinstance(value, float | int) and not isinstance(value, bool) and type(value) in (int, float):
        if not value > 0:
            raise entity.fault("stepnc-speed", f"its_speed is the ratio {value:g}; it must be above 0")
        return False, float(value)
    if value is not None:
        entity.warn("stepnc-speed-profile", "the speed profile along the path is not applied; the feed holds")
    return False, 1.0
