"""Small STEP-NC files for tests, written by the Part 21 writer."""

import io

import numpy as np

from cncgen.stepnc import canon, read
from cncgen.stepnc.part21 import DERIVED, Enumeration, Instance, Record, Ref, Typed, write
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import Kind

E = Enumeration
WHOLE = ReadOptions(chunk_rows=10_000_000)


class Part:
    """Instances of a file; every method adds some and returns the name of the last."""

    def __init__(self):
        self.instances = []

    def add(self, keyword, *parameters):
        return self.complex((keyword, parameters))

    def complex(self, *parts):
        records = tuple(Record(k, tuple(p)) for k, p in parts)
        self.instances.append(Instance(len(self.instances) + 1, records))
        return Ref(len(self.instances))

    def reserve(self):
        """Return a name whose instance comes later by `fill`."""
        return self.add("SETUP", "", None, None, ())

    def fill(self, name, keyword, *parameters):
        self.instances[name - 1] = Instance(int(name), (Record(keyword, tuple(parameters)),))

    # Geometry

    def point(self, *xyz):
        return self.add("CARTESIAN_POINT", "", tuple(float(v) for v in xyz))

    def direction(self, *xyz):
        return self.add("DIRECTION", "", tuple(float(v) for v in xyz))

    def placement(self, origin=(0, 0, 0), axis=None, reference=None):
        z = self.direction(*axis) if axis else None
        x = self.direction(*reference) if reference else None
        return self.add("AXIS2_PLACEMENT_3D", "", self.point(*origin), z, x)

    def plane(self, z):
        return self.add("PLANE", "", self.placement((0, 0, z)))

    def polyline(self, *points):
        return self.add("POLYLINE", "", tuple(self.point(*p) for p in points))

    def circle(self, radius, **place):
        return self.add("CIRCLE", "", self.placement(**place), float(radius))

    def trimmed(self, basis, begin, end, sense=True, master="CARTESIAN"):
        def trim(t):
            return (self.point(*t),) if isinstance(t, tuple) else (Typed("PARAMETER_VALUE", float(t)),)

        flag = E("T") if sense else E("F")
        return self.add("TRIMMED_CURVE", "", basis, trim(begin), trim(end), flag, E(master))

    # ISO 14649

    def technology(self, feed=0.02, spindle=-50.0, **other):
        values = {"cutspeed": None, "feedrate_per_tooth": None} | other
        off = E("F")
        return self.add(
            "MILLING_TECHNOLOGY", feed, E("TCP"), values["cutspeed"], spindle, values["feedrate_per_tooth"],
            off, off, off, None,
        )  # fmt: skip

    def tool(self, name="1", diameter=10.0, body="ENDMILL", teeth=2, tip=None, edge=None, hand="RIGHT"):
        size = self.add("MILLING_TOOL_DIMENSION", diameter, tip, None, None, edge, None, None)
        extra = (None,) if body.startswith("TAPERED") or body == "COUNTERSINK" else ()
        shape = self.add(body, size, teeth, E(hand), None, None, *extra)
        return self.add("MILLING_CUTTING_TOOL", name, shape, (), None, None, None)

    def trajectory(self, curve, kind="TRAJECTORY_PATH", speed=None, technology=None, forward=None, axis=None):
        way = None if forward is None else E("T" if forward else "F")
        return self.add(
            "CUTTER_LOCATION_TRAJECTORY", E("T"), E(kind), speed, technology, None, way, curve, axis, None
        )

    def freeform(self, *toolpaths, technology="default", tool="default", functions=None, direction=None):
        paths = self.add("TOOLPATH_LIST", tuple(toolpaths))
        technology = self.technology() if technology == "default" else technology
        tool = self.tool() if tool == "default" else tool
        rest = (None, None, None, None)
        return self.add(
            "FREEFORM_OPERATION", paths, direction, "op", None, None, tool, technology, functions, *rest
        )

    def step(self, operation, feature=None, security=None):
        return self.add("MACHINING_WORKINGSTEP", "ws", security, feature, operation, None)

    def plan(self, *elements, setup=None):
        return self.add("WORKPLAN", "plan", tuple(elements), None, setup, None)

    def project(self, plan):
        return self.add("PROJECT", "project", plan, (), None, None, None)

    def run_curve(self, curve, **options):
        """Make the program that follows one curve."""
        self.project(self.plan(self.step(self.freeform(self.trajectory(curve, **options)))))
        return self

    # The file

    def text(self, comment="(START, X0 Y0 Z0)"):
        stream = io.StringIO()
        write(stream, self.instances, ["MACHINING_SCHEMA"], comments=[comment])
        return stream.getvalue()

    def read(self):
        return run(self.text())

    def calls(self):
        return list(canon(self.text().encode(), "t.stp"))


def run(text):
    """Return the toolpath of a file, and its diagnostics as (code, severity, line)."""
    program = read(io.BytesIO(text.encode()), "t.stp", WHOLE)
    (path,) = program.chunks()
    return path, [(d.code, str(d.severity), d.span.line if d.span else 0) for d in program.diagnostics]


def codes(found, severity=None):
    return [c for c, s, _ in found if severity in (None, s)]


def motions(path):
    """Return the rows of motions."""
    return np.flatnonzero(path.kind != Kind.EVENT)


__all__ = ["DERIVED", "E", "Part", "Typed", "codes", "motions", "run"]
