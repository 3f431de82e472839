"""The AP238 AIM: its graph of properties, units, frames, order, technology, and what real writers get wrong."""

import io
import math
import re

import numpy as np
import pytest

from cncgen.stepnc import read
from cncgen.stepnc.part21 import DERIVED, Typed
from cncgen.toolpath.record import FeedMode, PathMode
from tests.stepnc.aim import Aim, E, Shaped
from tests.stepnc.building import codes, motions, run


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


def turning(aim, kind):
    """Add a unit of spindle speeds: revolutions or degrees a minute, radians a second, hertz, or revolutions alone."""
    revolution = aim.file.add("CONTEXT_DEPENDENT_UNIT", None, "revolution")
    radian = aim.file.add_complex(
        ("NAMED_UNIT", (DERIVED,)), ("PLANE_ANGLE_UNIT", ()), ("SI_UNIT", (None, E("RADIAN")))
    )
    hertz = aim.file.add_complex(("NAMED_UNIT", (DERIVED,)), ("SI_UNIT", (None, E("HERTZ"))))
    return {
        "rev/min": lambda: aim.file._product((revolution, 1.0), (aim.minute(), -1.0)),
        "deg/min": lambda: aim.file._product((aim.degree, 1.0), (aim.minute(), -1.0)),
        "rad/s": lambda: aim.file._product((radian, 1.0), (aim.file.second, -1.0)),
        "Hz": lambda: hertz,
        "rev": lambda: revolution,
    }[kind]()


@pytest.mark.parametrize(
    ("kind", "speed", "warned"),
    [
        ("rev/min", 1500.0, []),
        ("deg/min", 540_000.0, []),
        ("rad/s", 50.0 * math.pi, []),
        ("Hz", 25.0, []),
        ("rev", 25.0, ["stepnc-speed-unit"]),
    ],
)
def test_spindle_speeds_in_every_unit_of_turning(kind, speed, warned):
    """1500 rev/min are 25 turns, 50 pi rad a second; a unit without time is taken as a second's."""
    aim = Shaped()
    technology = aim.technology(spindle=-speed, spindle_unit=turning(aim, kind))
    path, found = aim.one_path(aim.polyline((0, 0, 0), (5, 0, 0)), technology)
    assert codes(found) == warned
    values = next(e for e in path.events if e.name == "spindle").values
    assert values["speed_rpm"] == pytest.approx(1500.0)
    assert values["direction"] == 1


def test_a_feed_per_tooth_in_millimetres_a_tooth():
    """0.1 mm a tooth, 4 teeth, 10 turns a second: 4 mm/s; the unit has the tooth in it."""
    aim = Aim()
    tooth = aim.file.add("CONTEXT_DEPENDENT_UNIT", None, "tooth")
    unit = aim.file._product((aim.file.mm, 1.0), (tooth, -1.0))
    technology = aim.technology(0.1, unit=unit, name="feed per tooth", spindle=-10.0)
    step, operation = aim.step()
    aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), technology)
    tool = aim.file.add(
        "MACHINING_TOOL", "7", "endmill", (operation,), aim.file.add("ACTION_RESOURCE_TYPE", "")
    )
    body = aim.file.add("RESOURCE_PROPERTY", "tool body", "", tool)
    ratio = aim.file.add_complex(("NAMED_UNIT", (DERIVED,)), ("RATIO_UNIT", ()))
    teeth = aim.file.measure("number of effective teeth", 4.0, ratio)
    # What is no number of a tool's, or in a unit of no use here, is passed over.
    pressure = aim.file.add_complex(("NAMED_UNIT", (DERIVED,)), ("SI_UNIT", (E("KILO"), E("PASCAL"))))
    coat = aim.file.add("DESCRIPTIVE_REPRESENTATION_ITEM", "coating", "TiN")
    items = (teeth, aim.file.measure("clamping pressure", 5.0, pressure), coat)
    held = aim.file.add("REPRESENTATION", "", items, aim.file.context)
    aim.file.add("RESOURCE_PROPERTY_REPRESENTATION", "", "", body, held)
    path, found = aim.read(aim.plan(step))
    assert codes(found) == []
    assert path.feed[motions(path)[-1]] == pytest.approx(4.0)


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
    assert shown == [("stop", 0), ("message", 0), ("coolant", 0), ("spindle", 0), ("dwell", 2.5), ("end", 0)]


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


def test_operations_that_cannot_be_done_are_refused():
    aim = Aim()
    step, operation = aim.step("EXTENDED_TYPE_OPERATION")
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


def test_probing_goes_along_its_toolpath_and_measures_nothing():
    aim = Aim()
    step, operation = aim.step("MACHINING_TOUCH_PROBING", "workpiece probing")
    aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology())
    bare, _ = aim.step("MACHINING_TOUCH_PROBING", "tool length probing")
    path, found = aim.read(aim.plan(step, bare))
    assert path.end[motions(path)].tolist() == [[5, 0, 0]]
    assert codes(found, "note") == ["probe-not-run"]
    assert codes(found, "error") == ["stepnc-unsupported"]


def test_probing_stands_in_a_workplan_without_a_workingstep_too():
    aim = Aim()
    probing = aim.file.method("MACHINING_TOUCH_PROBING", "probe", "workpiece probing")
    aim.path(probing, aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology())
    path, found = aim.read(aim.plan(probing))
    assert path.end[motions(path)].tolist() == [[5, 0, 0]]
    assert codes(found) == ["probe-not-run"]


def test_a_workingstep_of_two_operations_is_refused():
    aim = Aim()
    step, _ = aim.step()
    other = aim.file.method("FREEFORM_MILLING_OPERATION", "op")
    aim.file.add("MACHINING_OPERATION_RELATIONSHIP", "", "", step, other)
    assert codes(aim.read(aim.plan(step))[1], "error") == ["stepnc-unsupported"]


@pytest.mark.parametrize(("angle", "said"), [(0.0, []), (5.0, ["stepnc-unsupported"])])
def test_a_constant_tilt_of_nothing_is_none(angle, said):
    aim = Shaped()
    step, operation = aim.step()
    aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology())
    tilt = aim.file.measure("tilt angle", angle, aim.degree)
    keyword = "MACHINING_TOOL_DIRECTION_REPRESENTATION"
    aim.file.property(operation, "tool direction", keyword, "five axes const tilt yaw", tilt)
    path, found = aim.read(aim.plan(step))
    assert codes(found, "error") == said
    assert path.axes == "XYZ"


def test_ways_between_toolpaths_go_straight_or_by_the_security_plane():
    """From (5, 0, 0) to (20, 0, 0): straight, then back by the setup's plane at 30 mm; a toolpath of no kind is refused."""
    aim = Aim()
    step, operation = aim.step()
    technology = aim.technology()
    for curve, kind in (
        (((0, 0, 0), (5, 0, 0)), "connect direct"),
        (((20, 0, 0), (25, 0, 0)), "connect security plane"),
        (((0, 0, 0), (1, 0, 0)), None),
    ):
        aim.path(operation, aim.polyline(*curve), technology)
        if kind is not None:
            path = aim.file.method("MACHINING_TOOLPATH", "", kind)
            aim.sequence("MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP", operation, path)
    plane = aim.file.add("PLANE", "", aim.file.placement(np.array([0, 0, 30.0]), np.eye(3)[2], np.eye(3)[0]))
    aim.file.property(step, "security plane", "REPRESENTATION", "security plane", plane)
    path, found = aim.read(aim.plan(step))
    assert codes(found) == []
    assert path.end[motions(path)].tolist() == [
        [5, 0, 0], [20, 0, 0], [25, 0, 0], [25, 0, 30], [0, 0, 30], [0, 0, 0], [1, 0, 0],
    ]  # fmt: skip
    aim = Aim()
    step, operation = aim.step()
    odd = aim.file.method("MACHINING_TOOLPATH", "", "pirouette")
    aim.sequence("MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP", operation, odd)
    assert codes(aim.read(aim.plan(step))[1], "error") == ["stepnc-unsupported"]


def test_what_is_disabled_is_not_executed():
    aim = Aim()
    steps = []
    for k in (1, 2):
        step, operation = aim.step()
        aim.path(operation, aim.polyline((0, 0, 0), (k, 0, 0)), aim.technology())
        steps.append(step)
    aim.file.words(steps[0], "enabled", "disabled")
    aim.file.words(steps[1], "enabled", "enabled")
    path, found = aim.read(aim.plan(*steps))
    assert path.end[motions(path)].tolist() == [[2, 0, 0]]
    assert codes(found) == ["stepnc-disabled"]


def test_a_tool_direction_tilts_the_tool():
    """(1, 0, 1) is B 45°; the position is the tip's."""
    aim = Aim()
    step, operation = aim.step()
    aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology())
    axis = aim.file.add("DIRECTION", "tool direction orientation", (1.0, 0.0, 1.0))
    keyword = "MACHINING_TOOL_DIRECTION_REPRESENTATION"
    aim.file.property(operation, "tool direction", keyword, "three axes tilted tool", axis)
    path, found = aim.read(aim.plan(step))
    assert codes(found) == []
    assert path.axes == "XYZBC"
    np.testing.assert_allclose(path.end[-2], [5, 0, 0, math.pi / 4, 0], atol=1e-12)


@pytest.mark.parametrize("turning", [True, False])
def test_a_dwell_in_turns_of_the_spindle(turning):
    """Three turns at 600 rev/min are 0.3 s; with a spindle that stands there is no such time."""
    aim = Aim()
    step, operation = aim.step()
    technology = aim.technology(spindle=-10.0 if turning else None)
    aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), technology)
    wait = aim.file.method("MACHINING_TOOLPATH", "", "feedstop")
    aim.sequence("MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP", operation, wait)
    count = Typed("COUNT_MEASURE", 3.0)
    item = aim.file.add("MEASURE_REPRESENTATION_ITEM", "dwell revolution", count, aim.file.mm)
    aim.file.property(wait, "dwell", "MACHINING_DWELL_TIME_REPRESENTATION", "dwell revolution", item)
    path, found = aim.read(aim.plan(step))
    assert codes(found, "error") == ([] if turning else ["stepnc-no-spindle"])
    assert [e.dwell_s for e in path.events if e.name == "dwell"] == pytest.approx([0.3] * turning)


def test_functions_with_their_texts_and_tools():
    aim = Aim()
    load = aim.file.method("MACHINING_NC_FUNCTION", "", "load tool")
    aim.file.add("MACHINING_TOOL", "7", "drill", (load,), aim.file.add("ACTION_RESOURCE_TYPE", "drill"))
    unload = aim.file.method("MACHINING_NC_FUNCTION", "", "unload tool")
    say = aim.file.method("MACHINING_NC_FUNCTION", "note", "display message")
    aim.file.words(say, "message text", "Turn the Part")
    path, found = aim.read(aim.plan(load, say, unload))
    events = [(e.name, *e.values.values()) for e in path.events]
    assert events == [
        ("tool", "7", "drill"),
        ("message", "Turn the Part"),
        ("user", "unload tool", "7"),
        ("end",),
    ]
    assert codes(found) == []


def test_a_setups_security_plane_and_its_workpiece():
    """Between toolpaths the tool goes up to the setup's plane at 30 mm."""
    aim = Aim()
    steps = []
    for x in (0, 20):
        step, operation = aim.step()
        aim.path(operation, aim.polyline((x, 0, 0), (x + 5, 0, 0)), aim.technology())
        steps.append(step)
    plan = aim.plan(*steps)
    setup = aim.file.add("MACHINING_SETUP", "s", "", "", ())
    formation = aim.file.add("PRODUCT_DEFINITION_FORMATION", "", "", setup)
    definition = aim.file.add("PRODUCT_DEFINITION", "", "", formation, None)
    process = aim.file.add("PRODUCT_DEFINITION_PROCESS", "setup", "", plan, "")
    aim.file.add("PROCESS_PRODUCT_ASSOCIATION", "", "", definition, process)
    prop = aim.file.add("PROPERTY_DEFINITION", "security plane", "", definition)
    z, x = np.array([0, 0, 1.0]), np.array([1.0, 0, 0])
    plane = aim.file.add("PLANE", "", aim.file.placement(np.array([0, 0, 30.0]), z, x))
    held = aim.file.add("SHAPE_REPRESENTATION", "", (plane,), aim.file.context)
    aim.file.add("PROPERTY_DEFINITION_REPRESENTATION", prop, held)
    path, found = aim.read(plan)
    assert codes(found) == []
    assert path.end[motions(path)][1:4].tolist() == [[5, 0, 30], [20, 0, 30], [20, 0, 0]]


def test_upright_tool_axes_and_features_that_are_not_machined_add_no_rotary_axes():
    """Tool axes that are all Z, and a feature that leans beside explicit toolpaths: the program has X, Y and Z."""
    aim = Shaped()
    hole = aim.feature("ROUND_HOLE", aim.place(0, 0, 0, axis=(1, 0, 0), reference=(0, 1, 0)))
    step, operation = aim.machine(hole, "FREEFORM_MILLING_OPERATION", "")
    path = aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology())
    axes = aim.polyline((0, 0, 1), (0, 0, 1))
    aim.file.property(path, "tool axis", "REPRESENTATION", "tool axis", axes)
    toolpath, found = aim.read(aim.plan(step))
    assert codes(found) == []
    assert toolpath.axes == "XYZ"
    assert toolpath.end[motions(toolpath)].tolist() == [[5, 0, 0]]


def test_a_feature_that_leans_is_machined_with_a_leaning_tool():
    """A hole into X from (0, 30, 10): the tool goes along -X, B stands at 90 degrees."""
    aim = Shaped()
    place = aim.place(0, 30, 10, axis=(-1, 0, 0), reference=(0, 1, 0))
    sizes = [("diameter", "CIRCULAR_CLOSED_PROFILE", [("diameter", 8.0)])]
    step, _ = aim.machine(
        aim.feature("ROUND_HOLE", place, sizes, limit=-6.0), "DRILLING_OPERATION", "drilling"
    )
    toolpath, found = aim.read(aim.plan(step))
    assert toolpath.axes == "XYZBC"
    low = toolpath.end[motions(toolpath)][-2]
    np.testing.assert_allclose(low[:3], [6, 30, 10], atol=1e-9)
    assert abs(low[3]) == pytest.approx(math.pi / 2)
    assert codes(found, "error") == []


def one_step(aim, x):
    """Return a workingstep that feeds from the origin to x."""
    step, operation = aim.step()
    aim.path(operation, aim.polyline((0, 0, 0), (x, 0, 0)), aim.technology())
    return step


@pytest.mark.parametrize(("kind", "last"), [("non-sequential", 7), ("selective", 3)])
def test_branches_that_may_run_in_any_order_run_in_theirs(kind, last):
    """All of them one after the other; of those of which one is enough, the first."""
    aim = Aim()
    branch = aim.file.method("MACHINING_PROCESS_EXECUTABLE", "branch", kind)
    for x in (3, 7):
        aim.file.add("MACHINING_PROCESS_BRANCH_RELATIONSHIP", "", "", branch, one_step(aim, x))
    path, found = aim.read(aim.plan(branch))
    assert codes(found, "error") == []
    ends = path.end[motions(path), 0].tolist()
    assert (ends[0], ends[-1]) == (3, last)


def test_branches_at_a_time_and_executables_of_no_kind_are_refused():
    aim = Aim()
    parallel = aim.file.method("MACHINING_PROCESS_EXECUTABLE", "both", "parallel")
    for x in (3, 7):
        aim.file.add("MACHINING_PROCESS_CONCURRENT_RELATIONSHIP", "", "", parallel, one_step(aim, x))
    unknown = aim.file.method("MACHINING_PROCESS_EXECUTABLE", "what", "")
    path, found = aim.read(aim.plan(parallel, unknown, one_step(aim, 9)))
    assert codes(found, "error") == ["stepnc-parallel", "stepnc-unsupported"]
    assert path.end[motions(path), 0].tolist() == [9]


def test_a_feedstop_of_no_time_and_a_speed_along_the_path_are_remarked_on():
    aim = Aim()
    step, operation = aim.step()
    path = aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology(600.0))
    aim.file.property(path, "speed profile", "REPRESENTATION", "", aim.polyline((0, 0, 0), (1, 1, 0)))
    wait = aim.file.method("MACHINING_TOOLPATH", "", "feedstop")
    aim.sequence("MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP", operation, wait)
    toolpath, found = aim.read(aim.plan(step))
    assert sorted(codes(found)) == ["stepnc-missing", "stepnc-speed-profile"]
    assert [(e.name, e.dwell_s) for e in toolpath.events] == [("spindle", 0.0), ("dwell", 0.0), ("end", 0.0)]
    assert toolpath.feed[motions(toolpath)].tolist() == [10.0]


@pytest.mark.parametrize(
    ("deviation", "mode", "tolerance"), [(0.02, PathMode.CONTINUOUS, 0.02), (0.0, PathMode.EXACT_PATH, None)]
)
def test_the_largest_deviation_is_the_tolerance_of_a_path(deviation, mode, tolerance):
    """None at all is an exact path."""
    aim = Aim()
    step, operation = aim.step()
    path = aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology())
    item = aim.file.measure("path maximum deviation", deviation, aim.file.mm)
    aim.file.property(path, "path maximum deviation", "REPRESENTATION", "", item)
    toolpath, found = aim.read(aim.plan(step))
    assert codes(found) == []
    row = motions(toolpath)[-1]
    assert toolpath.path_mode[row] == mode
    assert tolerance is None or toolpath.tolerance[row] == tolerance


def test_a_deviation_below_zero_is_refused():
    aim = Aim()
    step, operation = aim.step()
    path = aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology())
    item = aim.file.measure("path maximum deviation", -0.02, aim.file.mm)
    aim.file.property(path, "path maximum deviation", "REPRESENTATION", "", item)
    assert codes(aim.read(aim.plan(step))[1], "error") == ["stepnc-range"]


def test_a_contact_path_without_its_surface_normal_is_refused():
    aim = Shaped()
    step, op = aim.step()
    aim.tool(op, "ball endmill")
    aim.path(op, aim.polyline((0, 0, 0), (0, 10, 0)), aim.technology())
    text = aim.stream.getvalue().replace("'cutter location trajectory'", "'cutter contact trajectory'")
    aim.stream.seek(0)
    aim.stream.write(text)
    assert codes(aim.read(aim.plan(step))[1], "error") == ["stepnc-missing"]


def named(aim, *parts):
    """Add a unit of length with the parts of its kind."""
    return aim.file.add_complex(*sorted([*parts, ("LENGTH_UNIT", ()), ("NAMED_UNIT", (DERIVED,))]))


@pytest.mark.parametrize(
    "make",
    [
        lambda aim: named(aim, ("SI_UNIT", (None, E("FURLONG")))),
        lambda aim: named(aim, ("SI_UNIT", (None, None))),
        lambda aim: named(aim, ("CONTEXT_DEPENDENT_UNIT", ("hogshead",))),
        lambda aim: named(aim, ("CONVERSION_BASED_UNIT", ("INCH", None))),
        lambda aim: named(aim, ("CONVERSION_BASED_UNIT", ("INCH", aim.file.add("MEASURE_WITH_UNIT", None, aim.file.mm)))),
        lambda aim: named(aim),
        lambda aim: aim.file._product((aim.file.length, 11.0)),
    ],
)  # fmt: skip
def test_units_that_are_none_are_refused(make):
    aim = Aim()
    _, found = aim.one_path(aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology(10.0, unit=make(aim)))
    assert "stepnc-unit" in codes(found, "error")


def test_prefixes_of_si_and_units_made_of_units():
    """600 cm/min as 0.1 m/s: a conversion of a prefixed unit over one of a second."""
    aim = Aim()
    centi = named(aim, ("SI_UNIT", (E("CENTI"), E("METRE"))))
    ten = aim.file.add("MEASURE_WITH_UNIT", Typed("LENGTH_MEASURE", 10.0), centi)
    decimetre = named(aim, ("CONVERSION_BASED_UNIT", ("DM", ten)))
    unit = aim.file._product((decimetre, 1.0), (aim.file.second, -1.0))
    path, found = aim.one_path(aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology(1.0, unit=unit))
    assert codes(found) == []
    assert path.feed[motions(path)[-1]] == pytest.approx(100.0)


def test_a_path_in_a_writers_own_property_is_refused_by_its_name():
    """Next-NC 0.2 gives arcs as texts of its own; a trajectory of ISO 10303-238 has a basic curve."""
    aim = Aim()
    step, operation = aim.step()
    aim.path(operation, aim.polyline((0, 0, 0), (9, 0, 0)), aim.technology())
    aim.file.project(aim.plan(step), "p")
    data = aim.stream.getvalue().replace("'basic curve'", "'next-nc circular motion'")
    text = f"ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('X'));\nENDSEC;\nDATA;\n{data}ENDSEC;\nEND-ISO-10303-21;\n"
    program = read(io.BytesIO(text.encode()), "t.stp")
    assert not any(len(motions(path)) for path in program.chunks())
    (error,) = [d for d in program.diagnostics if d.severity == "error"]
    assert error.code == "stepnc-missing"
    assert error.message.endswith("there are: 'next-nc circular motion'")


def test_a_context_without_a_unit_of_length_is_told():
    aim = Aim()
    step, operation = aim.step()
    aim.path(operation, aim.polyline((0, 0, 0), (9, 0, 0)), aim.technology())
    whole = aim.stream.getvalue()
    aim.stream.seek(0)
    aim.stream.write(
        re.sub(r"GLOBAL_UNIT_ASSIGNED_CONTEXT\(\([^)]*\)\)", "GLOBAL_UNIT_ASSIGNED_CONTEXT(())", whole)
    )
    aim.stream.truncate()
    path, found = aim.read(aim.plan(step))
    assert codes(found) == ["stepnc-unit"]
    assert path.end[motions(path)[-1]].tolist()[:3] == [9.0, 0.0, 0.0]


def _second(what, aim, step, operation, path, line):
    file, other = aim.file, aim.polyline((5, 0, 0), (5, 5, 0))
    place = [
        file.placement(np.array([k, 0, 0.0]), np.array([0, 0, 1.0]), np.array([1.0, 0, 0])) for k in (1, 2)
    ]
    if what == "basic curve":
        file.property(path, "basic curve", "REPRESENTATION", "basic curve", other)
    elif what == "technology":
        for technology in (aim.technology(1.0), aim.technology(2.0)):
            file.add("MACHINING_TECHNOLOGY_RELATIONSHIP", "", "", operation, technology)
    elif what == "toolpath orientation":
        file.property(step, what, "REPRESENTATION", what, *place)
    elif what == "speed profile":
        file.words(path, what, "rapid")
        file.words(path, what, "feed")
    elif what == "tool axis":
        file.property(
            path,
            what,
            "REPRESENTATION",
            what,
            *(file.direction(np.array(d)) for d in ([0, 0, 1.0], [0, 1.0, 1.0])),
        )
    elif what == "feed":
        technology = aim.technology(60.0)
        item = file.measure("feed", 600.0, aim.per_minute())
        file.property(technology, "feedrate", "MACHINING_FEED_SPEED_REPRESENTATION", "feed speed", item)
        file.add("MACHINING_TECHNOLOGY_RELATIONSHIP", "", "", operation, technology)
    elif what == "tool":
        for name in "ab":
            tool = file.add("MACHINING_TOOL", name, "", operation, file.add("ACTION_RESOURCE_TYPE", "tool"))
            assert tool


@pytest.mark.parametrize(
    "what",
    ["basic curve", "technology", "toolpath orientation", "speed profile", "tool axis", "feed", "tool"],
)
def test_several_of_what_the_standard_has_one_of_are_refused(what):
    """Each is a single attribute in the ARM of ISO 10303-238 (basiccurve: bounded_curve); no order tells which is meant."""
    aim = Aim()
    step, operation = aim.step()
    line = aim.polyline((0, 0, 0), (5, 0, 0))
    path = aim.path(operation, line, aim.technology() if what not in ("feed", "technology") else None)
    _second(what, aim, step, operation, path, line)
    toolpath, found = aim.read(aim.plan(step))
    assert codes(found).count("stepnc-several") == 1
    assert len(motions(toolpath)) == 0


def test_one_curve_that_is_named_twice_is_one():
    aim = Aim()
    step, operation = aim.step()
    line = aim.polyline((0, 0, 0), (5, 0, 0))
    path = aim.path(operation, line, aim.technology())
    aim.file.property(path, "basic curve", "REPRESENTATION", "basic curve", line)
    toolpath, found = aim.read(aim.plan(step))
    assert codes(found) == []
    assert toolpath.end[motions(toolpath)[-1]].tolist()[:3] == [5.0, 0.0, 0.0]


class Logic:
    """Expressions of an AIM: in the fourth edition an item holds each, before it they are items themselves (ISO 10303-238, 5.1.6)."""

    def __init__(self, aim, edition):
        self.file, self.edition = aim.file, edition

    def expression(self, kind, *parts):
        """A complex instance with the supertypes of ISO 13584-20 that have attributes, and the kind itself."""
        item = (
            []
            if self.edition == 4
            else [("EXPRESSION_REPRESENTATION_ITEM", ()), ("REPRESENTATION_ITEM", ("e",))]
        )
        return self.file.add_complex(*sorted([("GENERIC_EXPRESSION", ()), (kind, ()), *parts, *item]))

    def item(self, expression):
        return (
            self.file.add("EXPRESSION_ITEM_REPRESENTATION_ITEM", "e", expression)
            if self.edition == 4
            else expression
        )

    def variable(self):
        return self.expression("REAL_NUMERIC_VARIABLE", ("NUMERIC_VARIABLE", ()))

    def literal(self, value):
        return self.expression("REAL_LITERAL", ("LITERAL_NUMBER", (value,)))

    def compared(self, kind, a, b):
        return self.expression(
            f"COMPARISON_{kind}", ("BINARY_GENERIC_EXPRESSION", ((a, b),)), ("BOOLEAN_EXPRESSION", ())
        )

    def total(self, *terms):
        return self.expression("PLUS_EXPRESSION", ("MULTIPLE_ARITY_GENERIC_EXPRESSION", (terms,)))

    def statement(self, kind, **properties):
        made = self.file.method("MACHINING_PROCESS_EXECUTABLE", kind, kind)
        for name, expression in properties.items():
            self.file.property(made, name, "REPRESENTATION", name, self.item(expression))
        return made


@pytest.mark.parametrize("edition", [3, 4])
def test_if_takes_the_branch_of_its_condition_and_while_runs_until_it_is_false(edition):
    """x = 1; while x < 4: feed to 5, x = x + 1; then if x = 4: feed to 7, else to 9; not (x > 4): feed to 11."""
    aim = Aim()
    logic, relate = Logic(aim, edition), aim.file.add
    x = logic.variable()
    first = logic.statement("assignment", lvalue=x, rvalue=logic.literal(1.0))
    add = logic.statement("assignment", lvalue=x, rvalue=logic.total(x, logic.literal(1.0)))
    loop = logic.statement("while statement", condition=logic.compared("LESS", x, logic.literal(4.0)))
    relate("MACHINING_PROCESS_BODY_RELATIONSHIP", "", "", loop, aim.plan(one_step(aim, 5), add))
    choice = logic.statement("if statement", condition=logic.compared("EQUAL", x, logic.literal(4.0)))
    for name, place in (("true branch", 7), ("false branch", 9)):
        relate("MACHINING_PROCESS_BRANCH_RELATIONSHIP", name, "", choice, one_step(aim, place))
    more = logic.compared("GREATER", x, logic.literal(4.0))
    last = logic.statement(
        "if statement", condition=logic.expression("NOT_EXPRESSION", ("UNARY_GENERIC_EXPRESSION", (more,)))
    )
    relate("MACHINING_PROCESS_BRANCH_RELATIONSHIP", "true branch", "", last, one_step(aim, 11))
    path, found = aim.read(aim.plan(first, loop, choice, last))
    assert codes(found, "error") == []
    assert [v for v in path.end[motions(path), 0].tolist() if v] == [5, 5, 5, 7, 11]


@pytest.mark.parametrize(
    ("kind", "operands", "value"),
    [
        ("MINUS_EXPRESSION", (7, 2), 5), ("MULT_EXPRESSION", (7, 2), 14), ("SLASH_EXPRESSION", (7, 2), 3.5),
        ("POWER_EXPRESSION", (2, 3), 8), ("MAXIMUM_FUNCTION", (3, 9, 4), 9), ("MINIMUM_FUNCTION", (3, 9, 4), 3),
        ("ATAN_FUNCTION", (1, 0), math.pi / 2), ("ATAN_FUNCTION", (1, 1), math.pi / 4), ("MINUS_FUNCTION", (3,), -3), ("ABS_FUNCTION", (-3,), 3),
        ("SQUARE_ROOT_FUNCTION", (16,), 4), ("SIN_FUNCTION", (math.pi / 6,), 0.5), ("COS_FUNCTION", (math.pi / 3,), 0.5),
        ("TAN_FUNCTION", (math.pi / 4,), 1), ("ASIN_FUNCTION", (1,), math.pi / 2), ("ACOS_FUNCTION", (0,), math.pi / 2),
        ("EXP_FUNCTION", (1,), math.e), ("LOG_FUNCTION", (math.e,), 1), ("LOG2_FUNCTION", (8,), 3), ("LOG10_FUNCTION", (1000,), 3),
        ("SLASH_EXPRESSION", (7, 0), None), ("SQUARE_ROOT_FUNCTION", (-1,), None), ("LOG_FUNCTION", (0,), None),
        ("EXP_FUNCTION", (1e6,), None), ("ATAN_FUNCTION", (0, 0), None), ("POWER_EXPRESSION", (-8, 0.5), None),
    ],
)  # fmt: skip
def test_arithmetic_of_the_aim_has_the_value_of_its_function(kind, operands, value):
    """Values by hand; where a function has none, the statement is left out with a diagnostic that names it."""
    aim = Aim()
    logic = Logic(aim, 4)
    arity = {1: "UNARY", 2: "BINARY"}.get(len(operands), "MULTIPLE_ARITY")
    terms = tuple(logic.literal(float(each)) for each in operands)
    own = (terms[0],) if arity == "UNARY" else (terms,)
    made = logic.expression(kind, (f"{arity}_GENERIC_EXPRESSION", own))
    wanted = 0.0 if value is None else value
    low, high = (logic.literal(wanted + off) for off in (-1e-9, 1e-9))
    between = (logic.compared("GREATER", made, low), logic.compared("LESS", made, high))
    both = logic.expression("AND_EXPRESSION", ("MULTIPLE_ARITY_GENERIC_EXPRESSION", (between,)))
    choice = logic.statement("if statement", condition=both)
    aim.file.add("MACHINING_PROCESS_BRANCH_RELATIONSHIP", "true branch", "", choice, one_step(aim, 7))
    path, found = aim.read(aim.plan(choice, one_step(aim, 9)))
    assert codes(found, "error") == ([] if value is not None else ["stepnc-range"])
    assert path.end[motions(path), 0].tolist()[-1] == 9
    assert (7 in path.end[motions(path), 0].tolist()) == (value is not None)


def test_a_variable_of_the_aim_has_its_initial_value():
    aim = Aim()
    logic = Logic(aim, 4)
    x = logic.variable()
    aim.file.add(
        "REPRESENTATION_ITEM_RELATIONSHIP", "", "initial value", logic.item(x), logic.item(logic.literal(2.0))
    )
    choice = logic.statement("if statement", condition=logic.compared("EQUAL", x, logic.literal(2.0)))
    aim.file.add("MACHINING_PROCESS_BRANCH_RELATIONSHIP", "true branch", "", choice, one_step(aim, 7))
    path, found = aim.read(aim.plan(choice))
    assert codes(found, "error") == []
    assert path.end[motions(path), 0].tolist() == [7]


@pytest.mark.parametrize(
    ("fault", "code"),
    [("no value", "stepnc-missing"), ("no condition", "stepnc-missing"), ("strange", "stepnc-unsupported"),
     ("no branch", "stepnc-missing"), ("two bodies", "stepnc-several"), ("endless", "stepnc-endless")],
)  # fmt: skip
def test_what_cannot_be_decided_is_named_and_the_rest_goes_on(fault, code):
    aim = Aim()
    logic = Logic(aim, 4)
    x, one = logic.variable(), logic.literal(1.0)
    loop = fault in ("two bodies", "endless")
    condition = logic.compared("EQUAL", one, one) if loop else logic.compared("EQUAL", x, one)
    if fault == "strange":
        condition = logic.expression("LIKE_EXPRESSION", ("BINARY_GENERIC_EXPRESSION", ((x, one),)))
    given = {} if fault == "no condition" else {"condition": condition}
    statement = logic.statement("while statement" if loop else "if statement", **given)
    relation = "MACHINING_PROCESS_BODY_RELATIONSHIP" if loop else "MACHINING_PROCESS_BRANCH_RELATIONSHIP"
    if fault != "no branch":
        aim.file.add(relation, "true branch", "", statement, one_step(aim, 7))
    if fault == "two bodies":
        aim.file.add(relation, "", "", statement, one_step(aim, 8))
    path, found = aim.read(aim.plan(statement, one_step(aim, 9)))
    assert codes(found, "error") == [code]
    if fault != "endless":
        assert path.end[motions(path), 0].tolist() == [9]


def test_elements_in_any_order_stand_in_the_relationship_of_a_body():
    """ISO 10303-238, 5.1.6.18: NON_SEQUENTIAL; the instructions of a setup become a message."""
    aim = Aim()
    block = aim.file.method("MACHINING_PROCESS_EXECUTABLE", "block", "non-sequential")
    for x in (3, 7):
        aim.file.add("MACHINING_PROCESS_BODY_RELATIONSHIP", "", "", block, one_step(aim, x))
    told = aim.file.method("MACHINING_PROCESS_EXECUTABLE", "turn", "setup instructions")
    text = aim.file.add("MACHINING_OPERATOR_INSTRUCTION", "", "turn the part over", "", "", ())
    aim.file.relate("MACHINING_OPERATOR_INSTRUCTION_RELATIONSHIP", told, text, 1)
    path, found = aim.read(aim.plan(block, told))
    assert codes(found, "error") == []
    assert [v for v in path.end[motions(path), 0].tolist() if v] == [3, 7]
    assert [e.values["text"] for e in path.events if e.name == "message"] == ["turn the part over"]
