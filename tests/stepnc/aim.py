"""Small AP238 files for tests, in the graph of the AIM."""

import io
import math

import numpy as np

from cncgen.stepnc.ap238.aim_file import AimFile
from cncgen.stepnc.part21 import DERIVED, Enumeration, Typed
from tests.stepnc.building import run

E = Enumeration


class Aim:
    """A small AIM file."""

    def __init__(self, inches=False):
        self.stream = io.StringIO()
        self.file = AimFile(self.stream, inches)
        self.places = {}

    def polyline(self, *points):
        return self.file.add("POLYLINE", "", tuple(self.file.points(np.array(points, float))))

    def sequence(self, keyword, owner, member, place=None):
        self.places[owner] = self.places.get(owner, 0) + 1
        self.file.relate(keyword, owner, member, place or self.places[owner])

    def path(self, owner, curve, technology=None, rapid=False, place=None, **words):
        path = self.file.method("MACHINING_TOOLPATH", "", "cutter location trajectory")
        self.sequence("MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP", owner, path, place)
        self.file.property(path, "basic curve", "REPRESENTATION", "basic curve", curve)
        if rapid:
            words["speed_profile"] = "rapid"
        for name, text in words.items():
            self.file.words(path, name.replace("_", " "), text)
        if technology:
            self.file.add("MACHINING_TECHNOLOGY_RELATIONSHIP", "", "", path, technology)
        return path

    def technology(self, feed=250.0, unit=None, name="feed speed", spindle=-50.0, spindle_unit=None):
        technology = self.file.method("MACHINING_TECHNOLOGY", "", "milling")
        item = self.file.measure("feed", feed, unit or self.per_minute())
        self.file.property(technology, "feedrate", "MACHINING_FEED_SPEED_REPRESENTATION", name, item)
        if spindle is not None:
            item = self.file.measure("rotational speed", spindle, spindle_unit or self.file.spindle_unit)
            keyword = "MACHINING_SPINDLE_SPEED_REPRESENTATION"
            self.file.property(technology, "spindle", keyword, "spindle speed", item)
        return technology

    def per_minute(self):
        minute = self.file.complex_minute if hasattr(self.file, "complex_minute") else self.minute()
        return self.file._product((self.file.length, 1.0), (minute, -1.0))

    def minute(self):
        exponents = self.file.add("DIMENSIONAL_EXPONENTS", 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
        measure = self.file.add("MEASURE_WITH_UNIT", Typed("TIME_MEASURE", 60.0), self.file.second)
        return self.file.add_complex(
            ("CONVERSION_BASED_UNIT", ("MINUTE", measure)), ("NAMED_UNIT", (exponents,)), ("TIME_UNIT", ())
        )

    def step(self, keyword="FREEFORM_MILLING_OPERATION", description=""):
        step = self.file.method("MACHINING_WORKINGSTEP", "ws")
        operation = self.file.method(keyword, "op", description)
        self.file.add("MACHINING_OPERATION_RELATIONSHIP", "", "", step, operation)
        return step, operation

    def plan(self, *children, name="plan"):
        plan = self.file.method("MACHINING_WORKPLAN", name)
        for child in children:
            self.sequence("MACHINING_PROCESS_SEQUENCE_RELATIONSHIP", plan, child)
        return plan

    def read(self, plan):
        self.file.project(plan, "p")
        head = "ISO-10303-21;\n/* (START, X0 Y0 Z0) */\nHEADER;\nFILE_SCHEMA(('X'));\nENDSEC;\nDATA;\n"
        return run(head + self.stream.getvalue() + "ENDSEC;\nEND-ISO-10303-21;\n")

    def one_path(self, curve, technology=None, **words):
        step, operation = self.step()
        self.path(operation, curve, technology or self.technology(), **words)
        return self.read(self.plan(step))


class Shaped(Aim):
    """A file with one feature that is milled."""

    def feature(self, kind, place, components=(), limit=None, own=(), text="", name="f"):
        """Add a feature.

        Args:
            kind: Its entity.
            place: AXIS2_PLACEMENT_3D named 'orientation', or None.
            components: (name, entity, sizes) of profiles, paths, bottoms …, a description and a usage after them.
            limit: Height of the depth plane.
            own: (name, number) of the feature itself.
            text, name: Its description and name.
        """
        feature = self.file.add_complex(
            *sorted([("CHARACTERIZED_OBJECT", (name, text)), ("FEATURE_DEFINITION", ()), ("INSTANCED_FEATURE", ()),
            (kind, ()), ("SHAPE_ASPECT", (name, "", None, E("T")))])
        )  # fmt: skip
        shape = self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", feature)
        items = [] if place is None else [place]
        self.describe(shape, "SHAPE_REPRESENTATION_WITH_PARAMETERS", "", *items, *self.sizes(own))
        if limit is not None:
            z, x = np.array([0, 0, 1.0]), np.array([1.0, 0, 0])
            plane = self.file.add("PLANE", "", self.file.placement(np.array([0, 0, limit]), z, x))
            self.describe(shape, "SHAPE_REPRESENTATION", "maximum feature limit", plane)
        for name, keyword, sizes, *rest in components:
            description, usage = (*rest, None, None)[:2]
            occurrence = self.file.add("SHAPE_ASPECT", "", f"{name} occurrence", shape, E("T"))
            entity = self.file.add(keyword, "", description or "linear", None, E("T"))
            usage = usage or ("profile usage" if "PROFILE" in keyword else "path feature component usage")
            relation = "SHAPE_DEFINING_RELATIONSHIP"
            if keyword in ("HOLE_BOTTOM", "POCKET_BOTTOM", "TAPER", "SLOT_END"):
                relation = "FEATURE_COMPONENT_RELATIONSHIP"
            self.file.add(relation, name, usage, entity, occurrence)
            held = self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", entity)
            self.describe(held, "SHAPE_REPRESENTATION_WITH_PARAMETERS", "", *self.sizes(sizes))
        return feature

    def sizes(self, values):
        """Add measures of (name, number) in mm, angles in degrees; what is no number is an item already."""
        return [
            self.file.measure(n, v, self.degree if "angle" in n or "angular" in n or "rotation" in n else self.file.mm)
            if isinstance(v, float)
            else v
            for n, v in values
        ]  # fmt: skip

    def relate(self, name, usage, owner, member):
        """Relate a feature to one that belongs to it, by way of a composite aspect of its shape."""
        shape = self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", owner)
        aspect = self.file.add("COMPOSITE_SHAPE_ASPECT", "", "", shape, E("T"))
        self.file.add("FEATURE_COMPONENT_RELATIONSHIP", name, usage, aspect, member)

    def machine(
        self,
        feature,
        keyword="BOTTOM_AND_SIDE_MILLING_OPERATION",
        detail="finish",
        kind="endmill",
        technology=None,
        tool=(),
    ):
        """Add a workingstep that machines a feature, and return it with its operation; `tool` as for `tool`."""
        step, op = self.step(keyword, detail)
        technology = technology or self.technology(600.0)
        self.file.add("MACHINING_TECHNOLOGY_RELATIONSHIP", "", "", op, technology)
        self.tool(op, kind, *tool)
        process = self.file.method("MACHINING_FEATURE_PROCESS")
        self.file.add("MACHINING_FEATURE_RELATIONSHIP", "", "", step, process)
        action = self.file.add("PROPERTY_PROCESS", "machining", "", process, "")
        self.file.add("PROCESS_PROPERTY_ASSOCIATION", "", "", action, feature)
        return step, op

    def mill(
        self, kind, place, components, operation="BOTTOM_AND_SIDE_MILLING_OPERATION", limit=None, **more
    ):
        """Read a file with one feature and one operation on it."""
        step, _ = self.machine(self.feature(kind, place, components, limit, **more), operation)
        return self.read(self.plan(step))

    def place(self, *xyz, axis=(0, 0, 1), reference=(1, 0, 0), name="orientation"):
        """Add a placement."""
        return self.file.placement(*(np.array(v, float) for v in (xyz, axis, reference)), name)

    def tool(self, operation, kind, *more):
        """Add a tool of 8 mm that an operation uses, with more (name, mm or text) of it."""
        tool = self.file.add(
            "MACHINING_TOOL", "T", kind, (operation,), self.file.add("ACTION_RESOURCE_TYPE", "mill")
        )
        prop = self.file.add("RESOURCE_PROPERTY", "effective cutting diameter", "", tool)
        size = self.file.measure("effective cutting diameter", 8.0, self.file.mm)
        words = [
            self.file.measure(name, value, self.file.mm)
            if isinstance(value, float)
            else self.file.add("DESCRIPTIVE_REPRESENTATION_ITEM", name, value)
            for name, value in more
        ]
        held = self.file.add("REPRESENTATION", "", (size, *words), self.file.context)
        self.file.add("RESOURCE_PROPERTY_REPRESENTATION", "", "", prop, held)

    def describe(self, shape, keyword, name, *items):
        representation = self.file.add(keyword, name, items, self.file.context)
        self.file.add("SHAPE_DEFINITION_REPRESENTATION", shape, representation)

    @property
    def degree(self):
        if not hasattr(self, "_degree"):
            radian = self.file.add_complex(
                ("NAMED_UNIT", (DERIVED,)), ("PLANE_ANGLE_UNIT", ()), ("SI_UNIT", (None, E("RADIAN")))
            )
            factor = self.file.add(
                "PLANE_ANGLE_MEASURE_WITH_UNIT", Typed("PLANE_ANGLE_MEASURE", math.pi / 180), radian
            )
            exponents = self.file.add("DIMENSIONAL_EXPONENTS", *[0.0] * 7)
            self._degree = self.file.add_complex(
                ("CONVERSION_BASED_UNIT", ("DEGREE", factor)),
                ("NAMED_UNIT", (exponents,)),
                ("PLANE_ANGLE_UNIT", ()),
            )
        return self._degree
