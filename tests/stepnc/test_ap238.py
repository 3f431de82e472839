"""The AP238 AIM: its graph of properties, units, frames, order, technology, and what real writers get wrong."""

import io
import math

import numpy as np
import pytest

from cncgen.stepnc.ap238.aim_file import AimFile
from cncgen.stepnc.part21 import DERIVED, Enumeration, Typed
from cncgen.toolpath.record import FeedMode
from tests.stepnc.building import codes, motions, run

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

    def technology(self, feed=250.0, unit=None, name="feed speed", spindle=None, spindle_unit=None):
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


def test_feed_per_minute_and_rapid():
    aim = Aim()
    step, operation = aim.step()
    technology = aim.technology(250.0, spindle=-50.0)
    aim.path(operation, aim.polyline((0, 0, 0), (9, 0, 0)), rapid=True)
    aim.path(operation, aim.polyline((9, 0, 0), (9, 9, 0)), technology)
    path, found = aim.read(aim.plan(step))
    assert codes(found) == []
    rows = motions(path)
    assert path.feed_mode[rows].tolist() == [FeedMode.RAPID, FeedMode.SPEED]
    assert path.feed[rows[1]] == pytest.approx(250 / 60)
    spindle = next(e for e in path.events if e.name == "spindle")
    assert dict(spindle.values) == {"speed_rpm": 3000.0, "direction": 1}


def test_inches_of_the_context_and_of_the_feed():
    aim = Aim(inches=True)
    path, found = aim.one_path(aim.polyline((0, 0, 0), (25.4, 0, 0)), aim.technology(10.0))  # 10 in/min
    assert codes(found) == []
    assert aim.stream.getvalue().count("CARTESIAN_POINT('',(1.,0.,0.))") == 1
    np.testing.assert_allclose(path.end[motions(path)[-1]], [25.4, 0, 0])
    assert path.feed[motions(path)[-1]] == pytest.approx(254 / 60)


def test_order_is_by_sequence_position_not_by_number():
    aim = Aim()
    step, operation = aim.step()
    technology = aim.technology()
    aim.path(operation, aim.polyline((2, 0, 0), (3, 0, 0)), technology, place=3)
    aim.path(operation, aim.polyline((0, 0, 0), (1, 0, 0)), technology, place=1)
    aim.path(operation, aim.polyline((1, 0, 0), (2, 0, 0)), technology, place=2)
    path, found = aim.read(aim.plan(step))
    assert codes(found) == []
    assert path.end[motions(path), 0].tolist() == [1, 2, 3]


def test_nested_plans_multiply_their_toolpath_frames():
    aim = Aim()
    step, operation = aim.step()
    aim.path(operation, aim.polyline((1, 0, 0), (2, 0, 0)), aim.technology())
    z, x = np.array([0, 0, 1.0]), np.array([1.0, 0, 0])
    inner, outer = aim.plan(step), None
    outer = aim.plan(inner, name="outer")
    frame = aim.file.placement(np.array([10.0, 0, 0]), z, np.array([0, 1.0, 0]), "orientation")
    aim.file.property(outer, "toolpath orientation", "REPRESENTATION", "", frame)
    frame = aim.file.placement(np.array([0, 5.0, 0]), z, x, "orientation")
    aim.file.property(inner, "toolpath orientation", "REPRESENTATION", "", frame)
    path, _ = aim.read(outer)
    np.testing.assert_allclose(path.end[motions(path)][-2:], [[5, 1, 0], [5, 2, 0]], atol=1e-12)


def test_parameter_trims_are_in_the_angle_unit_of_the_context():
    aim = Aim()
    place = aim.file.placement(np.zeros(3), np.array([0, 0, 1.0]), np.array([1.0, 0, 0]))
    circle = aim.file.add("CIRCLE", "", place, 10.0)
    trims = [(Typed("PARAMETER_VALUE", v),) for v in (0.0, 90.0)]  # the file's unit is degrees
    curve = aim.file.add("TRIMMED_CURVE", "", circle, *trims, E("T"), E("PARAMETER"))
    path, _ = aim.one_path(curve)
    np.testing.assert_allclose(path.end[motions(path)[-1]], [0, 10, 0], atol=1e-12)
    assert path.arcs.sweep[-1] == pytest.approx(math.pi / 2)


def test_direction_and_trajectory_type():
    aim = Aim()
    path, _ = aim.one_path(
        aim.polyline((0, 0, 0), (5, 0, 0)), direction="end to beginning", trajectory_type="connect"
    )
    rows = motions(path)
    assert path.end[rows[-1], 0] == 0
    assert path.feed_mode[rows[-1]] == FeedMode.RAPID


def test_a_ratio_of_speed():
    aim = Aim()
    step, operation = aim.step()
    path = aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology(600.0))
    item = aim.file.add("MEASURE_REPRESENTATION_ITEM", "", Typed("RATIO_MEASURE", 0.5), None)
    keyword = "MACHINING_TOOLPATH_SPEED_PROFILE_REPRESENTATION"
    aim.file.property(path, "speed profile", keyword, "", item)
    made, _ = aim.read(aim.plan(step))
    assert made.feed[motions(made)[-1]] == pytest.approx(5.0)


def test_feed_per_revolution_in_a_unit_of_speed_is_warned_of():
    aim = Aim()
    technology = aim.technology(0.1, name="feed per revolution", spindle=-10.0)
    path, found = aim.one_path(aim.polyline((0, 0, 0), (5, 0, 0)), technology)
    assert codes(found) == ["stepnc-feed-unit"]
    assert path.feed[motions(path)[-1]] == pytest.approx(0.1 * 10)


def test_void_values_are_not_set():
    """Two 'spindle' properties, one with $ for its value: the other counts."""
    aim = Aim()
    technology = aim.technology(spindle=-20.0)
    void = aim.file.add("MEASURE_REPRESENTATION_ITEM", "rotational speed", None, aim.file.spindle_unit)
    keyword = "MACHINING_SPINDLE_SPEED_REPRESENTATION"
    aim.file.property(technology, "spindle", keyword, "spindle speed", void)
    path, found = aim.one_path(aim.polyline((0, 0, 0), (5, 0, 0)), technology)
    assert codes(found) == []
    assert next(e for e in path.events if e.name == "spindle").values["speed_rpm"] == 1200.0


def test_revolutions_per_minute_and_radians_per_second():
    aim = Aim()
    revolution = aim.file.add("CONTEXT_DEPENDENT_UNIT", None, "revolution")
    unit = aim.file._product((revolution, 1.0), (aim.minute(), -1.0))
    path, _ = aim.one_path(
        aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology(spindle=-1500.0, spindle_unit=unit)
    )
    assert next(e for e in path.events if e.name == "spindle").values["speed_rpm"] == pytest.approx(1500.0)


def test_tools_by_the_operations_that_use_them_gather_their_values():
    """One RESOURCE_PROPERTY a value, as STEP Tools' writer has it; the feed is per tooth."""
    aim = Aim()
    step, operation = aim.step()
    technology = aim.technology(0.1, unit=aim.file.length, name="feed per tooth", spindle=-10.0)
    aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), technology)
    kind = aim.file.add("ACTION_RESOURCE_TYPE", "milling cutting tool")
    tool = aim.file.add("MACHINING_TOOL", "7", "endmill", (operation,), kind)
    for name, value, unit in (
        ("number of effective teeth", 4.0, None),
        ("effective cutting diameter", 12.0, aim.file.mm),
    ):
        item = aim.file.add("MEASURE_REPRESENTATION_ITEM", name, Typed("NUMERIC_MEASURE", value), unit)
        body = aim.file.add("MACHINING_TOOL_BODY_REPRESENTATION", name, (item,), aim.file.context)
        prop = aim.file.add("RESOURCE_PROPERTY", "tool body", "", tool)
        aim.file.add("RESOURCE_PROPERTY_REPRESENTATION", "", "", prop, body)
    path, found = aim.read(aim.plan(step))
    assert codes(found) == []
    assert next(e for e in path.events if e.name == "tool").values["tool"] == "7"
    assert path.feed[motions(path)[-1]] == pytest.approx(0.1 * 4 * 10)


def test_functions_dwell_and_coolant():
    aim = Aim()
    stop = aim.file.method("MACHINING_NC_FUNCTION", "halt", "program stop")
    text = aim.file.method("MACHINING_NC_FUNCTION", "hello", "display message")
    step, operation = aim.step()
    path = aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology())
    functions = aim.file.method("MACHINING_FUNCTIONS", "", "milling")
    aim.file.words(functions, "coolant", "coolant on")
    aim.file.add("MACHINING_FUNCTIONS_RELATIONSHIP", "", "", path, functions)
    wait = aim.file.method("MACHINING_TOOLPATH", "", "feedstop")
    aim.sequence("MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP", operation, wait)
    item = aim.file.measure("dwell time", 2.5, aim.file.second)
    aim.file.property(wait, "dwell", "MACHINING_DWELL_TIME_REPRESENTATION", "dwell time", item)
    made, found = aim.read(aim.plan(stop, text, step))
    assert codes(found) == []
    shown = [(e.name, e.dwell_s) for e in made.events]
    assert shown == [("stop", 0), ("message", 0), ("coolant", 0), ("dwell", 2.5), ("end", 0)]


def test_security_plane_and_rapid_movement():
    aim = Aim()
    z, x = np.array([0, 0, 1.0]), np.array([1.0, 0, 0])
    step, operation = aim.step()
    aim.path(operation, aim.polyline((5, 5, 0), (9, 5, 0)), aim.technology())
    plane = aim.file.add("PLANE", "", aim.file.placement(np.array([0, 0, 40.0]), z, x))
    aim.file.property(step, "security plane", "REPRESENTATION", "", plane)
    rapid = aim.file.method("MACHINING_RAPID_MOVEMENT", "away")
    aim.path(rapid, aim.polyline((9, 5, 0), (9, 5, 80)))
    path, found = aim.read(aim.plan(step, rapid))
    assert codes(found) == []
    assert path.end[motions(path)].tolist() == [[0, 0, 40], [5, 5, 40], [5, 5, 0], [9, 5, 0], [9, 5, 80]]
    assert path.feed_mode[motions(path)[-1]] == FeedMode.RAPID


def test_without_a_security_plane_the_way_is_at_the_start_height_and_warned_of():
    aim = Aim()
    step, operation = aim.step()
    technology = aim.technology()
    aim.path(operation, aim.polyline((0, 0, -5), (9, 0, -5)), technology)
    aim.path(operation, aim.polyline((20, 0, -5), (29, 0, -5)), technology)
    path, found = aim.read(aim.plan(step))
    assert sorted(codes(found)) == ["path-gap", "stepnc-no-security-plane"]
    assert path.end[motions(path)].tolist()[2:5] == [[9, 0, 0], [20, 0, 0], [20, 0, -5]]


def test_a_tool_axis_along_a_spline():
    """Knots parametrise the axis too: halfway the tool leans halfway."""
    aim = Aim()
    control = tuple(aim.file.points(np.array([[0, 0, 0], [5, 0, 0], [10, 0, 0.0]])))
    tail = ((3, 3), (0.0, 1.0), E("UNSPECIFIED"))
    curve = aim.file.add("B_SPLINE_CURVE_WITH_KNOTS", "", 2, control, E("UNSPECIFIED"), E("F"), E("F"), *tail)
    axes = tuple(aim.file.points(np.array([[0, 0, 1], [0.5, 0, 1], [1, 0, 1.0]])))
    lean = aim.file.add("B_SPLINE_CURVE_WITH_KNOTS", "", 2, axes, E("UNSPECIFIED"), E("F"), E("F"), *tail)
    step, operation = aim.step()
    path = aim.path(operation, curve, aim.technology())
    aim.file.property(path, "tool axis", "REPRESENTATION", "", lean)
    made, found = aim.read(aim.plan(step))
    assert codes(found) == []
    assert made.axes == "XYZBC"
    rows = motions(made)
    expected = np.arctan2(made.end[rows, 0] / 10, 1.0)
    np.testing.assert_allclose(made.end[rows, 3], expected, atol=1e-4)
    assert made.end[rows[-1], 3] == pytest.approx(math.pi / 4)


def test_short_names():
    aim = Aim()
    curve = aim.polyline((0, 0, 0), (5, 0, 0))
    step, operation = aim.step()
    aim.path(operation, curve, aim.technology())
    aim.file.project(aim.plan(step), "p")
    text = aim.stream.getvalue()
    for short, name in (("CRTPNT", "CARTESIAN_POINT"), ("PLYLN", "POLYLINE"), ("MCHTLP", "MACHINING_TOOLPATH"),
                        ("ACTPRP", "ACTION_PROPERTY"), ("MCH0", "MACHINING_WORKPLAN")):  # fmt: skip
        text = text.replace(f"={name}(", f"={short}(")
    head = "ISO-10303-21;\n/* (START, X0 Y0 Z0) */\nHEADER;\nFILE_SCHEMA(('X'));\nENDSEC;\nDATA;\n"
    path, found = run(head + text + "ENDSEC;\nEND-ISO-10303-21;\n")
    assert codes(found) == []
    assert path.end[motions(path)].tolist() == [[5, 0, 0]]


@pytest.mark.parametrize("keyword", ["MACHINING_TOUCH_PROBING", "CONTOURING_TURNING_OPERATION"])
def test_operations_that_cannot_be_done_are_refused(keyword):
    aim = Aim()
    step, operation = aim.step(keyword)
    aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology())
    _, found = aim.read(aim.plan(step))
    assert codes(found, "error") == ["stepnc-unsupported"]


def test_a_toolpath_without_its_curve():
    aim = Aim()
    step, operation = aim.step()
    path = aim.file.method("MACHINING_TOOLPATH", "", "cutter location trajectory")
    aim.sequence("MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP", operation, path)
    aim.file.add("MACHINING_TECHNOLOGY_RELATIONSHIP", "", "", path, aim.technology())
    _, found = aim.read(aim.plan(step))
    assert codes(found, "error") == ["stepnc-missing"]


def test_a_plan_within_itself():
    aim = Aim()
    plan = aim.plan()
    aim.sequence("MACHINING_PROCESS_SEQUENCE_RELATIONSHIP", plan, plan)
    _, found = aim.read(plan)
    assert "part21-cycle" in codes(found, "error")


# Features


def hole(aim, depth, convention):
    """Add a drilling of a round hole of 10 mm at (20, 30): placement at the bottom (ISO 10303) or top (14649)."""
    z, x = np.array([0, 0, 1.0]), np.array([1.0, 0, 0])
    step, operation = aim.step("DRILLING_OPERATION", "drilling")
    aim.file.add("MACHINING_TECHNOLOGY_RELATIONSHIP", "", "", operation, aim.technology(120.0))
    kind = aim.file.add("ACTION_RESOURCE_TYPE", "drilling cutting tool")
    aim.file.add("MACHINING_TOOL", "3", "twist drill", (operation,), kind)
    feature = aim.file.add_complex(
        ("CHARACTERIZED_OBJECT", ("hole", "")), ("FEATURE_DEFINITION", ()), ("INSTANCED_FEATURE", ()),
        ("ROUND_HOLE", ()), ("SHAPE_ASPECT", ("hole", "", None, E("T"))),
    )  # fmt: skip
    process = aim.file.method("MACHINING_FEATURE_PROCESS")
    aim.file.add("MACHINING_FEATURE_RELATIONSHIP", "", "", step, process)
    action = aim.file.add("PROPERTY_PROCESS", "machining", "", process, "")
    aim.file.add("PROCESS_PROPERTY_ASSOCIATION", "", "", action, feature)
    shape = aim.file.add("PRODUCT_DEFINITION_SHAPE", "", "", feature)
    height = -depth if convention == "bottom" else 0.0
    place = aim.file.placement(np.array([20.0, 30.0, height]), z, x, "orientation")
    representation = aim.file.add("SHAPE_REPRESENTATION_WITH_PARAMETERS", "", (place,), aim.file.context)
    aim.file.add("SHAPE_DEFINITION_REPRESENTATION", shape, representation)
    limit = depth if convention == "bottom" else -depth
    plane = aim.file.add("PLANE", "", aim.file.placement(np.array([0, 0, limit]), z, x))
    bound = aim.file.add("SHAPE_REPRESENTATION", "maximum feature limit", (plane,), aim.file.context)
    aim.file.add("SHAPE_DEFINITION_REPRESENTATION", shape, bound)
    return step


@pytest.mark.parametrize("convention", ["bottom", "top"])
def test_a_hole_is_drilled_in_either_convention(convention):
    aim = Aim()
    step = hole(aim, 12.0, convention)
    path, found = aim.read(aim.plan(step))
    assert codes(found) == []
    assert path.end[motions(path), 2].min() == -12.0
    assert path.end[motions(path)][-1].tolist() == [20, 30, 5]


class Shaped(Aim):
    """A file with one feature that is milled."""

    def mill(self, kind, place, components, operation="BOTTOM_AND_SIDE_MILLING_OPERATION", limit=None):
        """Add a workingstep: `components` are (name, entity, sizes) of profiles and paths, `limit` the depth plane."""
        step, op = self.step(operation, "finish")
        self.file.add("MACHINING_TECHNOLOGY_RELATIONSHIP", "", "", op, self.technology(600.0))
        self.tool(op, "endmill")
        feature = self.file.add_complex(
            *sorted([("CHARACTERIZED_OBJECT", ("f", "")), ("FEATURE_DEFINITION", ()), ("INSTANCED_FEATURE", ()),
            (kind, ()), ("SHAPE_ASPECT", ("f", "", None, E("T")))])
        )  # fmt: skip
        process = self.file.method("MACHINING_FEATURE_PROCESS")
        self.file.add("MACHINING_FEATURE_RELATIONSHIP", "", "", step, process)
        action = self.file.add("PROPERTY_PROCESS", "machining", "", process, "")
        self.file.add("PROCESS_PROPERTY_ASSOCIATION", "", "", action, feature)
        shape = self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", feature)
        self.describe(shape, "SHAPE_REPRESENTATION_WITH_PARAMETERS", "", place)
        if limit is not None:
            z, x = np.array([0, 0, 1.0]), np.array([1.0, 0, 0])
            plane = self.file.add("PLANE", "", self.file.placement(np.array([0, 0, limit]), z, x))
            self.describe(shape, "SHAPE_REPRESENTATION", "maximum feature limit", plane)
        for name, keyword, sizes in components:
            occurrence = self.file.add("SHAPE_ASPECT", "", f"{name} occurrence", shape, E("T"))
            entity = self.file.add(keyword, "", "linear", None, E("T"))
            usage = "profile usage" if "PROFILE" in keyword else "path feature component usage"
            self.file.add("SHAPE_DEFINING_RELATIONSHIP", name, usage, entity, occurrence)
            items = [self.file.measure(n, v, self.degree if "angle" in n else self.file.mm) for n, v in sizes]
            own = self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", entity)
            self.describe(own, "SHAPE_REPRESENTATION_WITH_PARAMETERS", "", *items)
        return self.read(self.plan(step))

    def tool(self, operation, kind):
        """Add a tool of 8 mm that an operation uses."""
        tool = self.file.add(
            "MACHINING_TOOL", "T", kind, (operation,), self.file.add("ACTION_RESOURCE_TYPE", "mill")
        )
        prop = self.file.add("RESOURCE_PROPERTY", "effective cutting diameter", "", tool)
        size = self.file.measure("effective cutting diameter", 8.0, self.file.mm)
        held = self.file.add("REPRESENTATION", "", (size,), self.file.context)
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


def swept_place(aim, convention, depth, length):
    """The placement of a slot or step whose top stands at (20, 30, 0) and that goes 40 mm along Y of the machine."""
    x, y, z = np.eye(3)
    if convention == "top":
        return aim.file.placement(np.array([20.0, 30.0, 0.0]), z, x, "orientation")
    # At the bottom of the other end, Z along the path (backwards along Y), Y out of the material.
    return aim.file.placement(np.array([20.0, 30.0 + length, -depth]), -y, x, "orientation")


@pytest.mark.parametrize("convention", ["bottom", "top"])
def test_a_slot_in_either_convention(convention):
    """12 mm wide, 5 deep, 40 long: cut by 8 mm from 26 to 44 less the radius in Y, 5 below 0."""
    aim = Shaped()
    path, found = aim.mill(
        "SLOT",
        swept_place(aim, convention, 5.0, 40.0),
        [
            ("course of travel", "PATH_FEATURE_COMPONENT", [("distance", 40.0)]),
            ("swept shape", "SQUARE_U_PROFILE", [("width", 12.0), ("depth", 5.0), ("first angle", 90.0)]),
        ],
        limit=-5.0 if convention == "top" else None,
    )
    assert codes(found, "error") == []
    cut = path.end[motions(path)]
    cut = cut[cut[:, 2] == cut[:, 2].min()]
    assert cut[0, 2] == pytest.approx(-5.0)
    np.testing.assert_allclose(cut[:, :2].min(axis=0), [18.0, 34.0], atol=1e-3)
    np.testing.assert_allclose(cut[:, :2].max(axis=0), [22.0, 66.0], atol=1e-3)


@pytest.mark.parametrize("convention", ["bottom", "top"])
def test_a_step_in_either_convention(convention):
    """A wall at X 20, 15 mm wide to +X, 4 deep: the axis of the tool stays 4 mm from the wall and goes beyond the rest."""
    aim = Shaped()
    sizes = [
        ("profile angle", 90.0),
        ("tilt angle", 0.0),
        ("first side length", 15.0),
        ("second side length", 4.0),
    ]
    path, found = aim.mill(
        "STEP",
        swept_place(aim, convention, 4.0, 40.0),
        [
            ("course of travel", "PATH_FEATURE_COMPONENT", [("distance", 40.0)]),
            ("wall boundary", "VEE_PROFILE", sizes),
        ],
        limit=-4.0 if convention == "top" else None,
    )
    assert codes(found, "error") == []
    cut = path.end[motions(path)]
    cut = cut[cut[:, 2] == cut[:, 2].min()]
    assert cut[0, 2] == pytest.approx(-4.0)
    assert cut[:, 0].min() == pytest.approx(24.0, abs=1e-3)
    assert cut[:, 0].max() >= 35.0
    assert cut[:, 1].min() <= 30.0
    assert cut[:, 1].max() >= 70.0


def test_an_outside_profile_from_its_bottom():
    aim = Shaped()
    place = aim.file.placement(np.array([20.0, 30.0, -6.0]), np.eye(3)[2], np.eye(3)[0], "orientation")
    path, found = aim.mill(
        "OUTSIDE_PROFILE",
        place,
        [
            ("profile swept shape", "PATH_FEATURE_COMPONENT", [("distance", 6.0)]),
            ("feature boundary", "CIRCULAR_CLOSED_PROFILE", [("diameter", 20.0)]),
        ],
        operation="SIDE_MILLING_OPERATION",
        limit=6.0,
    )
    assert codes(found, "error") == []
    assert path.end[motions(path), 2].min() == -6.0
    radius = np.linalg.norm(path.arcs.centre[:, :2] - [20.0, 30.0], axis=1)
    assert (radius < 1e-3).any()


def test_a_contact_path_with_its_surface_normal():
    """A ball of 4 mm radius under a wall's edge: 4 mm along the normal (1, 0, 1) / sqrt 2, less 4 mm down the axis."""
    aim = Shaped()
    step, op = aim.step()
    aim.tool(op, "ball endmill")
    path = aim.path(op, aim.polyline((0, 0, 0), (0, 10, 0)), aim.technology())
    aim.file.property(
        path, "surface normal", "REPRESENTATION", "surface normal", aim.file.direction(np.array([1.0, 0, 1]))
    )
    text = aim.stream.getvalue()
    text = text.replace("'cutter location trajectory'", "'cutter contact trajectory'")
    aim.stream.seek(0)
    aim.stream.write(text)
    toolpath, found = aim.read(aim.plan(step))
    assert codes(found, "error") == []
    side = 4 * math.sqrt(0.5)
    np.testing.assert_allclose(toolpath.end[motions(toolpath)][-1, :3], [side, 10, side - 4], atol=1e-9)


def test_a_process_whose_number_is_another_entitys_is_a_diagnostic():
    """Found by fuzzing."""
    aim = Aim()
    curve = aim.polyline((0, 0, 0), (5, 0, 0))
    step, operation = aim.step()
    aim.path(operation, curve, aim.technology())
    plan = aim.plan(step)
    aim.stream.write(
        f"#9000=ACTION_PROPERTY('x','',;\n#9000=PRODUCT_DEFINITION_PROCESS('machining','',{plan!r},'');\n"
        "#9001=PRODUCT_DEFINITION_PROCESS('machining','',#9002;\n"
    )
    _, found = aim.read(plan)
    assert {"part21-duplicate", "part21-syntax"} <= set(codes(found, "error"))
