"""Technology, machine functions and tools of the AIM."""

from __future__ import annotations

import math
from typing import Any

from cncgen.stepnc.ap238.graph import Graph, Item
from cncgen.stepnc.ap238.units import Measure, Units
from cncgen.stepnc.entities import Entity, Skip, only
from cncgen.stepnc.model import TURNING_TOOLS, CuttingTool, Functions, Technology

#: Kinds of turning tools (10303-238, WR20 to WR22 of machining_tool) by their names here.
_TURNING_KINDS = {
    "general turning tool": "turning tool",
    "user defined turning tool": "turning tool",
    "turning threading tool": "threading tool",
}
_ON = {"on": True, "off": False, "true": True, "false": False}


def turns_of(measure: Measure) -> float:
    """Return a speed of rotation in revolutions per second: that of a measure with an angle is in radians."""
    return measure.value / (2 * math.pi if measure.unit.angle else 1.0)


class Resources:
    """Reads what operations and toolpaths share, each entity once."""

    def __init__(self, graph: Graph, units: Units) -> None:
        self.graph = graph
        self.units = units
        self._technologies: dict[int, Technology] = {}
        self._functions: dict[int, Functions] = {}
        self._tools: dict[int, CuttingTool] = {}

    # Technology

    def technology(self, owner: int) -> Technology | None:
        """Return the technology of an operation or toolpath, None where it has none.

        Raises:
            Skip: where it has a fault.
        """
        related = self.graph.related_ids(owner, "MACHINING_TECHNOLOGY_RELATIONSHIP")
        ident = self.graph.entities.only("technology", related)
        if ident is None:
            return None
        if ident not in self._technologies:
            self._technologies[ident] = self._read_technology(ident)
        return self._technologies[ident]

    def _read_technology(self, ident: int) -> Technology:
        properties = self.graph.properties(ident)
        feed, tooth, revolution = self._feeds(properties)
        spindle, cutting, fastest = self._spindle(properties)
        words = [described(i) for i in properties.get("synchronize spindle with feed", [])]
        in_step = any(w and not w.endswith(("not synchronized", "off", "false")) for w in words)
        return Technology(ident, feed, tooth, revolution, spindle, cutting, in_step, fastest)

    def _feeds(self, properties: dict[str, list[Item]]) -> tuple[float | None, float | None, float | None]:
        """Return the feed in mm/s, a tooth and a revolution in mm; each may stand once."""
        found: dict[str, tuple[Item, Measure]] = {}
        measures = self._measures(properties.get("feedrate", []) + properties.get("feed rate", []))
        kinds = ("feed per tooth", "feed per revolution", "feed")
        for kind in kinds:
            named = [(item, m) for item, name, m in measures if (name if name in kinds else "feed") == kind]
            only(kind, [item for item, _ in named])
            if named:
                found[kind] = named[0]
        feed, tooth = (found[k][1].value if k in found else None for k in ("feed", "feed per tooth"))
        if "feed per revolution" not in found:
            return feed, tooth, None
        item, measure = found["feed per revolution"]
        if not measure.unit.time:
            return feed, tooth, measure.value
        text = "a feed per revolution has a unit of length per time; its number is taken as a length"
        item.entity.warn("stepnc-feed-unit", text)
        return feed, tooth, measure.value / measure.unit.factor * self._length_factor(item)

    def _spindle(self, properties: dict[str, list[Item]]) -> tuple[float | None, float | None, float | None]:
        """Return the spindle's speed in 1/s, the cutting speed in mm/s, and the largest spindle speed in 1/s; each may stand once."""
        measures = self._measures(properties.get("spindle", []))
        most = [m for item, _, m in measures if item.name == "maximum rotational speed"]
        told = [(item, m) for item, _, m in measures if item.name != "maximum rotational speed"]
        along = [(item, m) for item, m in told if m.unit.length == 1]
        turning = [(item, m) for item, m in told if m.unit.length == 0]
        only("cutting speed", [item for item, _ in along])
        only("spindle speed", [item for item, _ in turning])
        spindle = turns_of(turning[0][1]) if turning else None
        if turning and not turning[0][1].unit.time:
            text = "the spindle speed has no unit of time; it is taken as revolutions per second"
            turning[0][0].entity.warn("stepnc-speed-unit", text)
        cutting = along[0][1].value if along else None
        fastest = turns_of(most[0]) if most else None
        if cutting is not None and fastest is not None and fastest < 0:
            cutting = -abs(cutting)
        return spindle, cutting, fastest

    def _length_factor(self, item: Item) -> float:
        return self.units.context(item.context)[0]

    def _measures(self, items: list[Item]) -> list[tuple[Item, str, Measure]]:
        """Return the measures that are set, under the name of their representation, else of the item."""
        out = []
        for item in items:
            if item.entity.instance.part("DESCRIPTIVE_REPRESENTATION_ITEM"):
                continue
            measure = self.units.measure(item.entity)
            if measure is not None:
                out.append((item, item.representation.strip().lower() or item.name, measure))
        return out

    # Machine functions

    def functions(self, owner: int) -> Functions | None:
        """Return the machine functions of an operation or toolpath, None where it has none.

        Raises:
            Skip: where they have a fault.
        """
        related = self.graph.related_ids(owner, "MACHINING_FUNCTIONS_RELATIONSHIP")
        ident = self.graph.entities.only("set of machine functions", related)
        if ident is None:
            return None
        if ident not in self._functions:
            properties = self.graph.properties(ident)

            def state(name: str) -> bool | None:
                words = {i: described(i).split()[-1:] for i in properties.get(name, [])}
                said = {_ON[w[0]]: i for i, w in words.items() if w and w[0] in _ON}
                only(name, list(said.values()))
                return next(iter(said), None)

            known = ("coolant", "mist", "through spindle coolant")
            way = only("coolant type", properties.get("coolant type", []))
            kind = "" if way is None else described(way)
            quiet = (
                *known,
                "coolant type",
                "chip removal",
                "coolant pressure",
                "through pressure",
                "axis clamping",
            )
            others = {n: True for n in properties if n not in quiet}
            coolant, mist, through = (state(n) for n in known)
            self._functions[ident] = Functions(ident, coolant, mist, through, others).by_way_of(kind)
        return self._functions[ident]

    # Tools

    def tool(self, owner: int) -> CuttingTool | None:
        """Return the tool that an operation uses, None where none says that it is used there.

        Raises:
            Skip: where it has a fault.
        """
        ident = self.graph.entities.only("tool", self.graph.index("MACHINING_TOOL", None).of(owner))
        if ident is None:
            return None
        if ident not in self._tools:
            self._tools[ident] = self._read_tool(ident)
        return self._tools[ident]

    def _read_tool(self, ident: int) -> CuttingTool:
        entity = self.graph.entities.get(ident, "MACHINING_TOOL")
        values: dict[str, Any] = {}
        for name, item in self._described(ident):
            try:
                if item.entity.instance.part("DESCRIPTIVE_REPRESENTATION_ITEM"):
                    values[name] = described(item)
                    continue
                measure = self.units.measure(item.entity)
            except Skip:
                continue
            if measure is not None:
                if values.get(name, measure.value) != measure.value:
                    text = f"{name} of the tool #{ident} is {values[name]:g} and {measure.value:g}; the last counts"
                    item.entity.warn("stepnc-several", text)
                values[name] = measure.value
        number = {k: v for k, v in values.items() if isinstance(v, float)}
        teeth = number.get("number of effective teeth", number.get("number of teeth"))
        point = number.get("point angle")
        kind = entity.text("description").strip().lower()
        kind = _TURNING_KINDS.get(kind, kind)
        if kind in TURNING_TOOLS:
            return self._turning_tool(entity, kind, values, number)
        return CuttingTool(
            ident,
            entity.text("name") or f"#{ident}",
            kind,
            number.get("effective cutting diameter", number.get("cutting diameter", number.get("diameter"))),
            None if teeth is None else round(teeth),
            None if point is None else math.pi / 2 - point / 2,
            number.get("edge radius", number.get("corner radius")),
            cutting_length=number.get("maximum depth of cut"),
            offset_length=number.get("overall assembly length", number.get("functional length")),
            left_handed="left" in str(values.get("hand of cut", "")),
            pitch=number.get("thread pitch", number.get("pitch")),
        )

    def _described(self, ident: int) -> list[tuple[str, Item]]:
        """Return what describes a tool and its cutting edges, by the name of the item, its representation or the property."""
        edges = [
            int(self.graph.entities.exchange.links_of(self.graph.entities.exchange.row_of(link))[1])
            for link in self.graph.index("ACTION_RESOURCE_RELATIONSHIP", 0).of(ident)
        ]
        return [
            (item.name or item.representation.strip().lower() or name, item)
            for owner in (ident, *edges)
            for name, item in self.graph.resource_items(owner)
        ]

    def _turning_tool(
        self, entity: Entity, kind: str, values: dict[str, Any], number: dict[str, float]
    ) -> CuttingTool:
        """Return a turning tool; its trailing edge stands behind its leading edge and the angle between the two."""
        lead, between = number.get("cutting edge angle"), number.get("tool included angle")
        trailing = None if lead is None or between is None else math.pi - lead - between
        made = CuttingTool(
            entity.id,
            entity.text("name") or f"#{entity.id}",
            kind,
            cutting_length=number.get("maximum grooving depth", number.get("cutting edge length")),
            left_handed="left" in str(values.get("hand of cut", "")),
            pitch=number.get("thread pitch", number.get("pitch")),
            nose=number.get("corner radius", number.get("nose radius")),
            width=number.get("cutting width"),
            trailing=number.get("end cutting edge angle", trailing),
        )
        for what, value in (("nose radius", made.nose), ("width", made.width)):
            if value is not None and not value >= 0:
                raise entity.fault(
                    "stepnc-tool", f"the tool's {what} is {value:g} mm; it must not be below 0"
                )
        return made


def text_of(item: Item) -> str:
    """Return the written description of a DESCRIPTIVE_REPRESENTATION_ITEM, "" for other items."""
    part = item.entity.instance.part("DESCRIPTIVE_REPRESENTATION_ITEM")
    value = part.parameters[-1] if part and part.parameters else ""
    return value.strip() if isinstance(value, str) else ""


def described(item: Item) -> str:
    """Return the description of a DESCRIPTIVE_REPRESENTATION_ITEM, lower case, "" of anything else."""
    return text_of(item).lower()
