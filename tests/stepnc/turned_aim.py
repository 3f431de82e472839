"""Turned features in the encoding of ISO 10303-238, as its annex J.7 writes the example of ISO 14649-12."""

from cncgen.stepnc.part21 import Enumeration, Typed
from tests.stepnc.aim import Shaped
from tests.stepnc.building import run

E = Enumeration
TOOLS = {
    "turn": ("general turning tool", []),
    "groove": ("grooving tool", ["cutting width", "maximum grooving depth"]),
    "thread": ("turning threading tool", ["thread pitch"]),
}


class TurnedAim(Shaped):
    """A bar of a diameter from Z `front - length` to `front`, and turning workingsteps on it."""

    def __init__(self, diameter=50.0, length=100.0, front=0.0, raw=True):
        super().__init__()
        self.steps = []
        frame = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, front - length], [0, 0, 0, 1]]
        size = (diameter / 2, diameter / 2, length)
        self.stock = {"kind": "cylinder", "frame": frame, "size": size} if raw else None

    def profile(self, feature, name, keyword, sizes=(), curve=None, usage="profile usage", place=None):
        """Give a feature a profile, or another component, by way of an occurrence of its shape."""
        shape = self.file.add("PRODUCT_DEFINITION_SHAPE", "", name, feature)
        occurrence = self.file.add("SHAPE_ASPECT", "", f"{name} occurrence", shape, E("F"))
        entity = self.file.add(keyword, "", name, None, E("F"))
        relation = "FEATURE_COMPONENT_RELATIONSHIP" if keyword == "TAPER" else "SHAPE_DEFINING_RELATIONSHIP"
        self.file.add(relation, name if keyword == "TAPER" else "", usage, entity, occurrence)
        held = self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", entity)
        items = [] if place is None else [place]
        items += [] if curve is None else [curve]
        keyword = "PATH_SHAPE_REPRESENTATION" if curve is not None else "SHAPE_REPRESENTATION_WITH_PARAMETERS"
        self.describe(held, keyword, "", *items, *self.sizes(sizes))
        return entity

    def diameter(self, diameter, length, z, taper=None):
        place = self.place(0, 0, z)
        feature = self.feature(
            "OUTER_ROUND", place, own=[("diameter", diameter), ("length", length)], text="outer diameter"
        )
        if taper is not None:
            self.profile(feature, "reduced size", "TAPER", [("final diameter", taper)], usage="taper usage")
        return feature

    def revolved(self, text, radius, z, side=None):
        own = [("radius", radius)]
        feature = self.feature("REVOLVED_PROFILE", self.place(0, 0, z), own=own, text=text)
        if side is not None:
            shape = self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", feature)
            items = (self.file.direction(side),)
            keyword = "DIRECTION_SHAPE_REPRESENTATION"
            held = self.file.add(keyword, "removal direction", items, self.file.context)
            self.file.add("PROPERTY_DEFINITION_REPRESENTATION", shape, held)
        return feature

    def face(self, radius, z=0.0, hub=0.0, side=None):
        feature = self.revolved("flat", hub, z, side)
        # The example names the length otherwise than the standard does.
        self.profile(feature, "flat edge shape", "LINEAR_PROFILE", [("linear profile length", radius - hub)])
        return feature

    def revolution(self, *points):
        feature = self.revolved("general revolution", 0.0, 0.0)
        curve = self.polyline(*[(r, 0, z) for r, z in points])
        self.profile(feature, "outer edge profile", "OPEN_PATH_PROFILE", curve=curve)
        return feature

    def groove(self, radius, width, z, corner=None):
        feature = self.revolved("groove", radius, z)
        corners = [] if corner is None else [("first radius", corner), ("second radius", corner)]
        self.profile(feature, "sweep", "SQUARE_U_PROFILE", [("width", width), *corners])
        return feature

    def thread(self, base, major, per_mm, length=None, z=0.0, hand="right"):
        words = [
            self.file.add("DESCRIPTIVE_REPRESENTATION_ITEM", name, text)
            for name, text in (("thread side", "external"), ("hand", hand))
        ]
        count = self.file.add(
            "MEASURE_REPRESENTATION_ITEM", "number of threads", Typed("RATIO_MEASURE", per_mm), None
        )
        own = [("major diameter", major), ("", count), *(("", w) for w in words)]
        feature = self.feature("THREAD", self.place(0, 0, z), own=own, text="thread")
        shape = self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", feature)
        aspect = self.file.add("SHAPE_ASPECT", "", "", shape, E("F"))
        self.file.add("SHAPE_DEFINING_RELATIONSHIP", "", "applied shape", base, aspect)
        if length is not None:
            sizes = [("effective length", length)]
            self.profile(feature, "partial area", "APPLIED_AREA", sizes, usage="applied area usage")
        return feature

    def turning_tool(self, operation, kind="turn", *sizes, nose=None, hand="right", edge=None):
        """Add a tool; `edge` gives the cutting edge angle and the included angle, degrees."""
        name, names = TOOLS[kind]
        turning = self.file.add("ACTION_RESOURCE_TYPE", "turning cutting tool")
        tool = self.file.add("MACHINING_TOOL", kind, name, (operation,), turning)
        values = [*zip(names, sizes, strict=True), *([] if nose is None else [("corner radius", nose)])]
        items = [self.file.add("DESCRIPTIVE_REPRESENTATION_ITEM", "hand of cut", hand), *self.sizes(values)]
        body = self.file.add("RESOURCE_PROPERTY", "tool body", "", tool)
        held = self.file.add("MACHINING_TOOL_BODY_REPRESENTATION", "", tuple(items), self.file.context)
        self.file.add("RESOURCE_PROPERTY_REPRESENTATION", "", "", body, held)
        if edge is not None:
            part = self.file.add("MACHINING_CUTTING_COMPONENT", "", "", (), turning, "", None)
            self.file.add("ACTION_RESOURCE_RELATIONSHIP", "", None, tool, part)
            for name, value in zip(("cutting edge angle", "tool included angle"), edge, strict=True):
                owner = self.file.add("RESOURCE_PROPERTY", name, "", part)
                item = self.file.measure("", value, self.degree)
                held = self.file.add("REPRESENTATION", "", (item,), self.file.context)
                self.file.add("RESOURCE_PROPERTY_REPRESENTATION", "", "", owner, held)
        return tool

    def number(self, owner, name, value, unit=None):
        self.file.property(
            owner, name, "REPRESENTATION", "", self.file.measure("", value, unit or self.file.mm)
        )

    def strategy(self, operation, kind="unidirectional", depths=(2.0,), **values):
        made = self.file.method("TURNING_TYPE_STRATEGY", "", kind)
        self.file.add("MACHINING_STRATEGY_RELATIONSHIP", "machining", kind, operation, made)
        each = tuple(self.file.measure("", d, self.file.mm) for d in depths)
        if each:
            whole = self.file.add("COMPOUND_REPRESENTATION_ITEM", "", Typed("LIST_REPRESENTATION_ITEM", each))
            self.file.property(made, "cutting depth", "REPRESENTATION", "", whole)
        for name, value in values.items():
            self.number(made, name.replace("_", " "), value)

    def turn(
        self, keyword, detail, *features, tool=("turn",), strategy=None, allowance=None, per_turn=0.2, **edges
    ):
        """Add a workingstep: `tool` is its kind and sizes, `edges` more of it, `strategy` (kind, depths, values)."""
        step, operation = self.step(f"{keyword}_TURNING_OPERATION", detail)
        technology = self.file.method("MACHINING_TECHNOLOGY", "", "turning")
        item = self.file.measure("feed per revolution", per_turn, self.file.mm)
        keyword = "MACHINING_FEED_SPEED_REPRESENTATION"
        self.file.property(technology, "feedrate", keyword, "feed per revolution", item)
        item = self.file.measure("rotational speed", -20.0, self.file.spindle_unit)
        keyword = "MACHINING_SPINDLE_SPEED_REPRESENTATION"
        self.file.property(technology, "spindle", keyword, "spindle speed", item)
        self.file.add("MACHINING_TECHNOLOGY_RELATIONSHIP", "", "", operation, technology)
        self.turning_tool(operation, *tool, **edges)
        if strategy is not None:
            kind, depths, values = strategy
            self.strategy(operation, kind, depths, **values)
        if allowance is not None:
            self.number(operation, "allowance", allowance)
        relation = "MACHINING_FEATURE_RELATIONSHIP"
        for feature in features:
            process = self.file.method("MACHINING_FEATURE_PROCESS")
            if len(features) > 1:
                self.file.relate("MACHINING_FEATURE_SEQUENCE_RELATIONSHIP", step, process, 0)
            else:
                self.file.add(relation, "", "", step, process)
            action = self.file.add("PROPERTY_PROCESS", "machining", "", process, "")
            self.file.add("PROCESS_PROPERTY_ASSOCIATION", "", "", action, feature)
        self.steps.append(step)
        return self

    def whole(self):
        """Return the text of the file."""
        self.file.project(self.plan(*self.steps), "p", self.stock)
        head = "ISO-10303-21;\n/* (START, X60 Y0 Z60) */\nHEADER;\nFILE_SCHEMA(('X'));\nENDSEC;\nDATA;\n"
        return head + self.stream.getvalue() + "ENDSEC;\nEND-ISO-10303-21;\n"

    def read_whole(self):
        return run(self.whole())
