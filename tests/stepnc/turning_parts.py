"""Parts of ISO 14649-12: a bar, features that are turned, and operations on them."""

from tests.stepnc.building import E
from tests.stepnc.featured import Features


class Turned(Features):
    """A bar of a diameter from Z 0 (or `front`) to negative Z, and turning workingsteps on it."""

    def __init__(self, diameter=50.0, length=100.0, front=0.0, block=False):
        super().__init__()
        self.steps, self.heights = [], {}
        base = self.placement((0, 0, front - length))
        solid = (
            self.add(
                "BLOCK",
                "",
                self.placement((-diameter / 2, -diameter / 2, front - length)),
                diameter,
                diameter,
                length,
            )
            if block
            else self.add("RIGHT_CIRCULAR_CYLINDER", "", base, length, diameter / 2)
        )
        raw = self.add("WORKPIECE", "raw", None, None, None, None, solid, ())
        self.workpiece = self.add("WORKPIECE", "shaft", None, None, raw, None, None, ())
        self.bar = (diameter, length, front)

    def turned(self, keyword, *own, z=0.0, axis=None):
        place = self.placement((0, 0, z), axis, (1, 0, 0) if axis else None)
        made = self.add(keyword, "f", self.workpiece, (), place, *own)
        self.heights[made] = z
        return made

    def diameter(self, diameter, length, z, taper=None):
        """An outer diameter from Z `z - length` up to `z`, `diameter` at its low end; a taper to another diameter at the high end."""
        reduced = None if taper is None else self.add("DIAMETER_TAPER", self.size(taper))
        return self.turned("OUTER_DIAMETER", self.size(diameter), self.size(length), reduced, z=z - length)

    def face(self, radius, z=0.0, hub=0.0):
        reach = self.add("NUMERIC_PARAMETER", "length", float(radius - hub), "mm")
        return self.turned("REVOLVED_FLAT", None, hub, self.add("LINEAR_PROFILE", None, reach), z=z)

    def revolution(self, *points):
        """A profile through points (radius, z)."""
        line = self.polyline(*[(r, 0, z) for r, z in points])
        return self.turned("GENERAL_REVOLUTION", None, 0.0, self.add("GENERAL_PROFILE", None, line))

    def groove(self, radius, width, z, corner=None):
        corner = None if corner is None else self.size(corner)
        section = self.add("SQUARE_U_PROFILE", None, self.size(width), corner, 0.0, corner, 0.0)
        return self.turned("GROOVE", None, self.size(radius), section, z=z)

    def turning_tool(self, nose=0.0, trailing=None, hand="RIGHT", name="T1"):
        size = self.add(
            "TURNING_TOOL_DIMENSION", 50.0, None, None, None, trailing, None, None, None, None, nose, None
        )
        body = self.add("GENERAL_TURNING_TOOL", size, E(hand), None, None, None, None, None)
        return self.add("TURNING_MACHINE_TOOL", name, body, (), None, None, None)

    def grooving_tool(self, width, reach=50.0, nose=0.0, name="T2"):
        """As the second edition of ISO 14649-121 has it: the tool is the entity itself."""
        edge = self.add("CUTTING_EDGE_PROPERTIES", None, None, 5.0, None, None, None, (), None, None)
        return self.add(
            "GROOVING_TOOL",
            name,
            100.0,
            20.0,
            None,
            None,
            None,
            edge,
            E("RIGHT"),
            width,
            reach,
            nose,
            None,
            None,
        )

    def threading_tool(self, pitch, name="T3"):
        body = self.add(
            "TURNING_THREADING_TOOL",
            None,
            E("RIGHT"),
            None,
            None,
            None,
            None,
            None,
            pitch,
            E("RIGHT"),
            None,
            None,
            None,
        )
        return self.add("TURNING_MACHINE_TOOL", name, body, (), None, None, None)

    def ways(self, keyword="UNIDIRECTIONAL_TURNING", depths=(2.0,), overcut=None, lift=None, feed=None):
        return self.add(
            keyword, overcut, E("T"), tuple(depths), None, feed, None, None, None, lift, None, None
        )

    def turn(self, keyword, feature, tool, strategy=None, allowance=None, speed=("CONST_SPINDLE_SPEED", -20.0), per_turn=0.2,
             dwell=None, security=5.0):  # fmt: skip
        technology = self.add(
            "TURNING_TECHNOLOGY", None, E("TCP"), self.add(*speed), per_turn, E("F"), E("F"), E("F")
        )
        functions = self.add(
            "TURNING_MACHINE_FUNCTIONS", E("T"), None, None, (), E("F"), None, None, (), None, None, None
        )
        own = (dwell, allowance) if keyword.startswith("GROOVING") else (allowance,)
        operation = self.add(
            keyword,
            None,
            None,
            keyword.lower(),
            None,
            None,
            tool,
            technology,
            functions,
            None,
            None,
            strategy,
            *own,
        )
        # Of one feature the security plane stands in its frame, of several in the workpiece's.
        plane = self.plane(security + self.bar[2] - self.heights.get(feature, 0.0))
        name = keyword.lower().replace("_", " ")
        kind = "TURNING_WORKINGSTEP" if isinstance(feature, tuple) else "MACHINING_WORKINGSTEP"
        self.steps.append(self.add(kind, name, plane, feature, operation, None))
        return self

    def whole(self):
        """Return the text of the file."""
        self.project(self.plan(*self.steps))
        return self.text("(START, X60 Y0 Z60)")
