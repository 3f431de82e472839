"""ISO 14649: workplans, frames, technology, toolpath kinds, functions, statements, defects of real files."""

import io
import math

import numpy as np
import pytest

from cncgen.stepnc import read, tree
from cncgen.stepnc.execution.executor import MAX_DEPTH
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import FeedMode, Kind
from tests.stepnc.building import E, Part, Typed, codes, motions, run


def events(path, name=None):
    rows = [path.events[path.curve[k]] for k in range(len(path)) if path.kind[k] == Kind.EVENT]
    return [e for e in rows if name in (None, e.name)]


def square(part, z=0.0):
    return part.polyline((0, 0, z), (10, 0, z), (10, 10, z))


# Structure and frames


def test_frames_chain_workpiece_and_feature_but_not_the_setup():
    """machine <- workpiece setup <- feature; the setup's origin is a work offset: a note."""
    part = Part()
    workpiece = part.add("WORKPIECE", "block", None, None, None, None, None, ())
    place = part.placement((100, 0, 0), (0, 0, 1), (0, 1, 0))  # X of the workpiece is Y outside
    held = part.add("WORKPIECE_SETUP", workpiece, place, None, None, ())
    setup = part.add("SETUP", "setup", part.placement((7, 8, 9)), part.plane(50), (held,))
    feature = part.add("TOOLPATH_FEATURE", "f", workpiece, (), part.placement((1, 2, 3)), None)
    operation = part.freeform(part.trajectory(square(part)))
    part.project(part.plan(part.step(operation, feature), setup=setup))
    path, found = part.read()
    assert codes(found) == ["stepnc-work-offset"]
    ends = path.end[motions(path)]
    np.testing.assert_allclose(
        ends[:3], [[0, 0, 50], [98, 1, 50], [98, 1, 3]], atol=1e-12
    )  # by the security plane
    np.testing.assert_allclose(ends[3:], [[98, 11, 3], [88, 11, 3]], atol=1e-12)


def test_nested_workplans_run_in_order_and_share_the_setup():
    part = Part()
    steps = [part.step(part.freeform(part.trajectory(part.polyline((0, 0, k), (1, 0, k))))) for k in range(4)]
    inner = part.plan(steps[1], part.plan(steps[2]))
    part.project(part.plan(steps[0], inner, steps[3], setup=part.add("SETUP", "", None, part.plane(20), ())))
    path, found = part.read()
    assert codes(found) == []
    feeds = [k for k in motions(path) if path.feed_mode[k] == FeedMode.SPEED]
    assert path.end[feeds, 2].tolist() == [0, 1, 2, 3]


def test_a_workplan_within_itself_is_an_error_and_ends():
    part = Part()
    name = part.reserve()
    part.fill(name, "WORKPLAN", "again", (name,), None, None, None)
    part.project(name)
    _, found = part.read()
    assert codes(found, "error") == ["part21-cycle"]


@pytest.mark.parametrize(("levels", "said"), [(MAX_DEPTH, []), (MAX_DEPTH + 1, ["stepnc-nesting"])])
def test_workplans_nest_so_deep(levels, said):
    """A bound of our own, far above any part's."""
    part = Part()
    plan = part.plan(part.step(part.freeform(part.trajectory(part.polyline((0, 0, 0), (5, 0, 0))))))
    for _ in range(levels - 1):
        plan = part.plan(plan)
    part.project(plan)
    path, found = part.read()
    assert codes(found, "error") == said
    assert (len(motions(path)) == 0) == bool(said)


def test_operations_without_a_tool_or_a_toolpath_and_functions_that_nothing_does():
    part = Part()
    line = part.trajectory(part.polyline((0, 0, 0), (5, 0, 0)))
    functions = part.add(
        "MILLING_MACHINE_FUNCTIONS", E("F"), None, None, E("F"), None, (), E("F"), part.direction(0, 0, 1), None, ()
    )  # fmt: skip
    steps = [
        part.step(part.freeform(line, tool=None)),
        part.step(part.freeform(line, functions=functions)),
        part.step(part.freeform()),
    ]
    part.project(part.plan(part.add("LOAD_TOOL", "", None), *steps))
    path, found = part.read()
    assert codes(found, "error") == ["stepnc-missing"]
    assert {"stepnc-no-tool", "stepnc-function", "stepnc-empty"} <= set(codes(found, "warning"))
    assert path.end[motions(path)][-1].tolist() == [5, 0, 0]


def test_a_fault_in_one_step_leaves_the_others():
    part = Part()
    good = [part.step(part.freeform(part.trajectory(part.polyline((0, 0, k), (9, 0, k))))) for k in (0, 0)]
    bad = [part.step(part.freeform(part.trajectory(part.circle(-1)))) for _ in range(2)]
    part.project(part.plan(good[0], bad[0], good[1], bad[1]))
    path, found = part.read()
    assert codes(found, "error") == ["stepnc-geometry"] * 2
    assert sum(path.feed_mode == FeedMode.SPEED) >= 2


def test_no_project():
    part = Part()
    part.point(1, 2, 3)
    _, found = part.read()
    assert codes(found, "error") == ["stepnc-no-project"]


# Technology


def test_feed_and_speed_units():
    """m/s to mm/s; rev/s to rev/min; negative turns with the clock."""
    path, _ = simple()
    rows = [k for k in motions(path) if path.feed_mode[k] == FeedMode.SPEED]
    assert path.feed[rows].tolist() == [20.0, 20.0]
    assert dict(events(path, "spindle")[0].values) == {"speed_rpm": 3000.0, "direction": 1}


def simple(**technology):
    part = Part()
    tech = part.technology(**technology)
    operation = part.freeform(part.trajectory(square(part)), technology=tech)
    part.project(part.plan(part.step(operation)))
    return part.read()


def test_feed_per_tooth_and_cutting_speed():
    """2 teeth, 10 mm: 1 m/s are 1000 / (10 pi) rev/s; 0.05 mm a tooth."""
    path, found = simple(feed=None, spindle=None, cutspeed=1.0, feedrate_per_tooth=0.05)
    turns = 1000 / (math.pi * 10)
    assert codes(found) == []
    assert path.feed[motions(path)[-1]] == pytest.approx(0.05 * 2 * turns)
    assert events(path, "spindle")[0].values["speed_rpm"] == pytest.approx(60 * turns)
    assert events(path, "spindle")[0].values["direction"] == 1


def test_left_handed_tools_turn_the_other_way():
    part = Part()
    tool = part.tool(hand="LEFT")
    operation = part.freeform(
        part.trajectory(square(part)), tool=tool, technology=part.technology(0.01, None, cutspeed=1.0)
    )
    part.project(part.plan(part.step(operation)))
    path, _ = part.read()
    assert events(path, "spindle")[0].values["direction"] == -1


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({"cutspeed": 11.0}, "stepnc-speed-both"),
        ({"spindle": 6000.0}, "stepnc-speed-unit"),
        ({"spindle": 12.0}, "stepnc-spindle-sign"),
        ({"spindle": None, "cutspeed": 60.0}, "stepnc-speed-unit"),
    ],
)
def test_implausible_speeds_are_warned_of(given, code):
    _, found = simple(**given)
    assert code in codes(found, "warning")


def test_no_feed_is_an_error():
    _, found = simple(feed=None, spindle=-10.0)
    assert codes(found, "error") == ["stepnc-no-feed"]


def test_precedence_of_technology_and_the_ratio_of_speed():
    part = Part()
    own = part.technology(0.005, -10.0)
    ratio = Typed("POSITIVE_RATIO_MEASURE", 0.5)
    a, b, c = ((0, 0, 0), (9, 0, 0)), ((9, 0, 0), (9, 9, 0)), ((9, 9, 0), (0, 9, 0))
    paths = [
        part.trajectory(part.polyline(*a)),
        part.trajectory(part.polyline(*b), technology=own),
        part.trajectory(part.polyline(*c), speed=ratio),
    ]
    part.project(part.plan(part.step(part.freeform(*paths))))
    path, _ = part.read()
    assert path.feed[motions(path)].tolist() == [20.0, 5.0, 10.0]
    assert [e.values["speed_rpm"] for e in events(path, "spindle")] == [3000.0, 600.0, 3000.0]


@pytest.mark.parametrize(
    "options", [{"speed": E("RAPID")}, {"speed": Typed("SPEED_NAME", E("RAPID"))}, {"kind": "CONNECT"}]
)
def test_what_is_rapid(options):
    part = Part()
    path, _ = part.run_curve(square(part), **options).read()
    assert (path.feed_mode[motions(path)] == FeedMode.RAPID).all()


# Toolpath kinds


def paths_of(*make):
    part = Part()
    operation = part.freeform(*(m(part) for m in make))
    part.project(part.plan(part.step(operation, security=part.plane(30))))
    return part.read()


def line(*points):
    return lambda part: part.trajectory(part.polyline(*points))


HEAD = (E("T"), E("TRAJECTORY_PATH"), None, None, None)


def test_feedstop_waits():
    path, found = paths_of(line((0, 0, 0), (5, 0, 0)), lambda p: p.add("FEEDSTOP", *HEAD, 1.5))
    assert codes(found) == []
    assert [e.dwell_s for e in events(path, "dwell")] == [1.5]


@pytest.mark.parametrize("seconds", [-1.0, 1e300])
def test_a_dwell_of_no_time_is_refused(seconds):
    part = Part()
    wait = part.add("FEEDSTOP", E("T"), E("CONTACT"), None, None, None, seconds)
    part.project(part.plan(part.step(part.freeform(wait))))
    assert codes(part.read()[1]) == ["stepnc-range"]


def test_connect_by_the_security_plane_and_direct():
    def connected(kind):
        connector = (lambda p: p.add("CONNECT_SECPLANE", *HEAD, None, None)) if kind == "plane" else (
            lambda p: p.add("CONNECT_DIRECT", *HEAD)
        )  # fmt: skip
        path, found = paths_of(line((0, 0, 0), (5, 0, 0)), connector, line((9, 9, 0), (9, 0, 0)))
        assert codes(found) == []
        return path.end[motions(path)].tolist()

    assert connected("plane")[1:] == [[5, 0, 30], [9, 9, 30], [9, 9, 0], [9, 0, 0]]
    assert connected("direct")[1:] == [[9, 9, 0], [9, 0, 0]]


def test_a_gap_is_named_and_crossed_at_the_security_plane():
    path, found = paths_of(line((0, 0, 0), (5, 0, 0)), line((9, 9, 0), (9, 0, 0)))
    assert codes(found) == ["path-gap"]
    assert path.end[motions(path)][1].tolist() == [5, 0, 30]


def test_approach_by_an_angle_and_by_an_arc():
    def angled(part):
        fix = part.point(-20, 0, 10)
        return part.add("AP_LIFT_PATH_ANGLE", E("T"), E("APPROACH"), None, None, None, fix, None, 30.0, 10.0)

    path, found = paths_of(line((-20, 0, 10), (-20, 0, 10.5)), angled, line((0, 0, 0), (9, 0, 0)))
    ends = path.end[motions(path)]
    corner = [-10 * math.cos(math.pi / 6), 0, 10 * math.sin(math.pi / 6)]
    assert "stepnc-geometry" not in codes(found)
    assert np.abs(ends - corner).max(axis=1).min() < 1e-9

    def tangent(part):
        fix = part.point(-10, 5, 0)
        return part.add("AP_LIFT_PATH_TANGENT", E("T"), E("APPROACH"), None, None, None, fix, None, 5.0)

    path, found = paths_of(tangent, line((0, 0, 0), (9, 0, 0)))
    assert codes(found, "error") == []
    arc = np.flatnonzero(path.kind == Kind.ARC)[0]
    np.testing.assert_allclose(path.arcs.centre[0], [0, 5, 0], atol=1e-12)
    np.testing.assert_allclose(path.end[arc], [0, 0, 0], atol=1e-12)
    # The line before the arc is tangent to it.
    touch = path.starts[arc]
    assert np.dot(touch - path.arcs.centre[0], touch - [-10, 5, 0]) == pytest.approx(0, abs=1e-9)


ONTO = {
    "line": lambda part: part.polyline((0, 0, 0), (9, 0, 0)),
    "arc": lambda part: part.trimmed(part.circle(9, origin=(0, 9, 0)), (0, 0, 0), (9, 9, 0)),
    "spline": lambda part: part.add(
        "BEZIER_CURVE", "", 2, tuple(part.point(*p) for p in ((0, 0, 0), (5, 0, 0), (9, 4, 0))),
        E("UNSPECIFIED"), E("F"), E("F"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("curve", ONTO)
@pytest.mark.parametrize(("kind", "fix"), [("APPROACH", (-20, 3, 10)), ("LIFT", (20, 3, 10))])
def test_the_last_line_of_an_approach_meets_the_path_at_its_angle(curve, kind, fix):
    """10 mm long, at 30 degrees to the path's first direction, X (of a lift: to its last), in the plane towards the point.

    With a direction of its own, straight down, that plane is upright.
    """
    for direction in (None, (0, 0, -1)):

        def angled(part, direction=direction):
            way = None if direction is None else part.direction(*direction)
            head = (E("T"), E(kind), None, None, None, part.point(*fix))
            return part.add("AP_LIFT_PATH_ANGLE", *head, way, 30.0, 10.0)

        def path(part):
            made = ONTO[curve](part)
            return part.trajectory(made, forward=False if kind == "LIFT" else None)

        made, found = paths_of(*((angled, path) if kind == "APPROACH" else (path, angled)))
        assert codes(found, "error") == []
        rows = motions(made)
        at = made.starts[rows] if kind == "LIFT" else made.end[rows]
        meeting = rows[np.flatnonzero(np.linalg.norm(at, axis=1) < 1e-9)[-1 if kind == "LIFT" else 0]]
        way = made.end[meeting] - made.starts[meeting]
        assert np.linalg.norm(way) == pytest.approx(10.0)
        # A lift goes off the path, which comes along -X.
        tangent = np.array([-1.0 if kind == "LIFT" else 1.0, 0, 0])
        assert way @ tangent == pytest.approx(10 * math.cos(math.radians(30)), abs=1e-4)
        across = (way - way @ tangent * tangent) * (1 if kind == "LIFT" else -1)
        plane = np.array([0, 3, 10]) if direction is None else np.array([0, 0, 1])
        np.testing.assert_allclose(across / np.linalg.norm(across), plane / np.linalg.norm(plane), atol=1e-4)


@pytest.mark.parametrize(
    ("keyword", "fix", "values"),
    [
        ("AP_LIFT_PATH_ANGLE", (-20, 3, 10), (30.0, 0.0)),
        ("AP_LIFT_PATH_TANGENT", (-20, 3, 10), (0.0,)),
        ("AP_LIFT_PATH_TANGENT", (-20, 0, 0), (5.0,)),
        ("AP_LIFT_PATH_TANGENT", (0, 4, 0), (5.0,)),
        ("AP_LIFT_PATH_ANGLE", None, (30.0, 5.0)),
    ],
)
def test_approaches_that_no_path_makes_are_refused(keyword, fix, values):
    """No bend, no radius, in line with the path, within the circle, from nowhere."""

    def approach(part):
        point = None if fix is None else part.point(*fix)
        return part.add(keyword, E("T"), E("APPROACH"), None, None, None, point, None, *values)

    _, found = paths_of(approach, line((0, 0, 0), (9, 0, 0)))
    assert codes(found, "error") == ["stepnc-geometry" if fix else "stepnc-missing"]


def test_axis_trajectory():
    def axes(part):
        commands = tuple(
            part.add("POLYLINE", "", tuple(part.add("CARTESIAN_POINT", "", (v,)) for v in values))
            for values in ((0.0, 1.0, 2.0), (0.0, 5.0, 5.0), (0.0, 0.0, -1.0))
        )
        return part.add("AXIS_TRAJECTORY", *HEAD, None, ("X", "Y", "Z"), commands)

    path, found = paths_of(axes)
    assert codes(found) == []
    assert path.end[motions(path)].tolist() == [[1, 5, 0], [2, 5, -1]]


def test_contact_paths_without_normals_are_refused():
    def contact(part):
        curve = part.polyline((0, 0, 0), (1, 0, 0))
        return part.add("CUTTER_CONTACT_TRAJECTORY", *HEAD, None, curve, None, None)

    _, found = paths_of(contact)
    assert "stepnc-unsupported" in codes(found, "error")


# Functions and statements


def test_functions_between_workingsteps():
    part = Part()
    tool = part.tool("9")
    elements = [
        part.add("DISPLAY_MESSAGE", "", "hello"),
        part.add("OPTIONAL_STOP", ""),
        part.add("PROGRAM_STOP", ""),
        part.add("LOAD_TOOL", "", tool),
        part.add("UNLOAD_TOOL", "", tool),
        part.add("EXCHANGE_PALLET", ""),
        part.add("INDEX_TABLE", "", 3),
        part.add("SET_MARK", ""),
        part.add("WAIT_FOR_MARK", "", None),
    ]
    part.project(part.plan(*elements))
    path, found = part.read()
    names = [
        (e.name, e.values.get("kind") or e.values.get("text") or e.values.get("tool")) for e in events(path)
    ]
    assert names[:4] == [("message", "hello"), ("stop", "optional"), ("stop", "stop"), ("tool", "9")]
    assert [e.values["function"] for e in events(path, "user")] == [
        "unload tool", "exchange pallet", "index table", "set mark", "wait for mark",
    ]  # fmt: skip
    assert codes(found) == ["stepnc-channel"] * 2


def test_a_tool_that_is_unloaded_neither_turns_nor_is_cooled_and_is_loaded_again():
    part = Part()
    tool = part.tool("9")
    wet = part.add("MILLING_MACHINE_FUNCTIONS", E("T"), None, None, E("F"), None, (), E("F"), None, None, ())
    cut = part.step(part.freeform(part.trajectory(square(part)), tool=tool, functions=wet))
    part.project(part.plan(cut, part.add("UNLOAD_TOOL", "", tool), cut))
    path, found = part.read()
    assert codes(found, "error") == []
    said = [(e.name, e.values.get("direction", e.values.get("flood"))) for e in events(path)]
    once = [("tool", None), ("coolant", True), ("spindle", 1)]
    out = [("spindle", 0), ("coolant", False), ("user", None)]
    assert [s for s in said if s[0] != "end"][:9] == [*once, *out, *once]


def test_functions_as_canonical_calls():
    """What NIST's functions have a call for is one, the rest a comment."""
    part = Part()
    tool = part.tool("9")
    elements = [
        part.add("DISPLAY_MESSAGE", "", "hello"),
        part.add("OPTIONAL_STOP", ""),
        part.add("PROGRAM_STOP", ""),
        part.add("EXCHANGE_PALLET", ""),
        part.add("INDEX_TABLE", "", 3),
        part.add("SET_MARK", ""),
        part.add("LOAD_TOOL", "", tool),
        part.add("UNLOAD_TOOL", "", tool),
    ]
    part.project(part.plan(*elements))
    said = calls_of(part)
    wanted = ['MESSAGE("hello")', "OPTIONAL_PROGRAM_STOP()", "PROGRAM_STOP()", "PALLET_SHUTTLE()"]
    assert [call for call in said if call in wanted] == wanted
    assert [call for call in said if call.startswith("COMMENT")] == [
        'COMMENT("index table: 3")',
        'COMMENT("set mark")',
        'COMMENT("unload tool: 9")',
    ]


def calls_of(part):
    """Return the canonical calls of a part without their numbers."""
    return [line.split(None, 1)[1] for line in part.calls()]


def test_curves_as_canonical_calls():
    """An arc in a main plane is one; across them it is its spline, and a helix across them is named by its end."""
    part = Part()
    part.run_curve(part.trimmed(part.circle(10, axis=(1, 0, 0), reference=(0, 1, 0)), (0, 10, 0), (0, 0, 10)))
    said = calls_of(part)
    assert said[said.index("SELECT_PLANE(CANON_PLANE_YZ)") + 1 :][:1] == [
        "ARC_FEED(0.0000, 10.0000, 0.0000, 0.0000, 1, 0.0000)"
    ]
    part = Part()
    part.run_curve(part.circle(10, axis=(0, 0.6, 0.8), reference=(1, 0, 0)))
    (spline,) = [call for call in calls_of(part) if call.startswith("NURBS_FEED")]
    assert spline.startswith("NURBS_FEED(2, [0.000000, 0.000000, 0.000000, ")
    assert "(10.0000, 0.0000, 0.0000, 1.000000)" in spline
    part = Part()
    basis = part.add("HELIX", "", part.placement(axis=(0, 0.6, 0.8), reference=(1, 0, 0)), 5.0, 2.0)
    part.run_curve(part.trimmed(basis, (5, 0, 0), (5, 1.2, 1.6)))
    assert "ARC_FEED_IN_SPACE(5.0000, 1.2000, 1.6000)" in calls_of(part)


def test_rapid_movement_is_in_the_setup_frame():
    part = Part()
    paths = part.add("TOOLPATH_LIST", (part.trajectory(square(part, 5.0)),))
    part.project(part.plan(part.add("RAPID_MOVEMENT", "r", None, paths, None)))
    path, _ = part.read()
    assert path.end[motions(path)][-1].tolist() == [10, 10, 5]
    assert (path.feed_mode == FeedMode.RAPID).all()


def test_while_counts_and_if_chooses():
    """WHILE n < 3: message, n := 3 by way of IF."""
    part = Part()
    n = part.add("NC_VARIABLE", "n", 1.0)
    three = part.add("NC_CONSTANT", "three", 3.0)
    say = [part.add("DISPLAY_MESSAGE", "", t) for t in ("loop", "yes", "no")]
    below = part.add("COMPARISON_LESS", n, three)
    one = part.add("COMPARISON_EQUAL", n, 1.0)
    either = part.add("OR_EXPRESSION", (one, part.add("NOT_EXPRESSION", below)))
    choice = part.add("IF_STATEMENT", "", part.add("AND_EXPRESSION", (either, below)), say[1], say[2])
    two = part.add("ASSIGNMENT", "", n, 2.0)
    both = part.add("XOR_EXPRESSION", one, part.add("COMPARISON_GREATER_EQUAL", n, 2.0))
    advance = part.add(
        "IF_STATEMENT", "", part.add("COMPARISON_EQUAL", n, 2.0), part.add("ASSIGNMENT", "", n, three), two
    )
    guarded = part.add("IF_STATEMENT", "", both, advance, None)
    body = part.plan(say[0], choice, guarded)
    part.project(part.plan(part.add("WHILE_STATEMENT", "", below, body)))
    path, found = part.read()
    assert codes(found) == []
    assert [e.values["text"] for e in events(path, "message")] == ["loop", "yes", "loop", "no"]


def test_a_condition_on_a_variable_without_a_value_is_named():
    part = Part()
    n = part.add("NC_VARIABLE", "n", None)
    say = [part.add("DISPLAY_MESSAGE", "", t) for t in ("yes", "no", "after")]
    choice = part.add("IF_STATEMENT", "", part.add("COMPARISON_LESS", n, 1.0), say[0], say[1])
    part.project(part.plan(choice, say[2]))
    path, found = part.read()
    assert codes(found, "error") == ["stepnc-missing"]
    assert [e.values["text"] for e in events(path, "message")] == ["after"]


def test_a_loop_without_end_is_ended():
    """Variables get numbers and other variables alone, so that a turn that leaves them as an earlier one did repeats it."""
    part = Part()
    n, m, k = (
        part.add("NC_VARIABLE", name, value) for name, value in zip("nmk", (0.0, 1.0, 0.0), strict=True)
    )
    always = part.add("COMPARISON_LESS", n, 5.0)
    swap = [part.add("ASSIGNMENT", "", *pair) for pair in ((k, n), (n, m), (m, k))]
    part.project(
        part.plan(part.add("WHILE_STATEMENT", "", always, part.plan(part.add("SET_MARK", ""), *swap)))
    )
    path, found = part.read()
    assert codes(found, "error") == ["stepnc-endless"]
    assert len(path.kind) < 20


def test_parallel_is_refused_selective_and_non_sequential_are_not():
    part = Part()
    marks = [part.add("DISPLAY_MESSAGE", "", t) for t in "abcd"]
    part.project(
        part.plan(
            part.add("NON_SEQUENTIAL", "", (marks[0], marks[1])),
            part.add("SELECTIVE", "", (marks[2], marks[3])),
            part.add("PARALLEL", "", (marks[0],)),
            part.add("PARALLEL", "", (marks[0], marks[1])),
        )
    )
    path, found = part.read()
    assert [e.values["text"] for e in events(path, "message")] == ["a", "b", "c", "a"]
    assert codes(found, "error") == ["stepnc-parallel"]
    assert codes(found, "warning") == ["stepnc-selective"]


def test_probing_is_refused():
    part = Part()
    part.project(part.plan(part.add("TOOL_LENGTH_PROBING", "", None, None, None, None, None, None, None)))
    assert codes(part.read()[1], "error") == ["stepnc-unsupported"]


def test_coolant_and_tool_events():
    part = Part()
    functions = part.add(
        "MILLING_MACHINE_FUNCTIONS", E("T"), None, E("T"), E("F"), None, (), E("F"), None, None, ()
    )
    operation = part.freeform(part.trajectory(square(part)), functions=functions)
    other = part.freeform(part.trajectory(part.polyline((10, 10, 0), (0, 0, 0))), tool=part.tool("2"))
    part.project(part.plan(part.step(operation), part.step(other)))
    path, _ = part.read()
    shown = [
        (e.name, e.values.get("flood"), e.values.get("tool"))
        for e in events(path)
        if e.name in ("coolant", "tool")
    ]
    assert shown == [
        ("tool", None, "1"),
        ("coolant", True, None),
        ("coolant", False, None),
        ("tool", None, "2"),
    ]


# Tool axes


def test_tool_axis_curve_turns_b_and_c():
    """The axis goes from upright to 45 degrees towards +Y: C at 90 degrees, B from 0 to 45."""
    part = Part()
    s = math.sqrt(0.5)
    axis = part.polyline((0, 0, 1), (0, s, s))
    path, found = part.run_curve(part.polyline((0, 0, 0), (10, 0, 0)), axis=axis).read()
    assert codes(found) == []
    assert path.axes == "XYZBC"
    rows = motions(path)
    np.testing.assert_allclose(path.end[rows[-1]], [10, 0, 0, math.pi / 4, math.pi / 2], atol=1e-9)
    b, c, x = path.end[rows, 3], path.end[rows, 4], path.end[rows, 0]
    assert (np.diff(b) >= -1e-12).all()
    np.testing.assert_allclose(c[b > 1e-9], math.pi / 2, atol=1e-9)
    np.testing.assert_allclose(b, x / 10 * math.pi / 4, atol=1e-9)  # along the great circle


def composite(part, *curves):
    """A composite curve of curves, end to end."""
    parts = [part.add("COMPOSITE_CURVE_SEGMENT", E("CONTINUOUS"), E("T"), c) for c in curves]
    return part.add("COMPOSITE_CURVE", "", tuple(parts), E("U"))


def test_a_tool_axis_of_two_directions_goes_along_the_length_of_several_curves():
    """Linearly from upright to 45 degrees towards X: a line of 10 mm and half a circle of 10 mm across are 10 : 5 pi."""
    part = Part()
    half = part.trimmed(part.circle(5, origin=(10, 5, 0)), (10, 0, 0), (10, 10, 0))
    path = composite(part, part.polyline((0, 0, 0), (10, 0, 0)), half)
    made, found = part.run_curve(path, axis=part.polyline((0, 0, 1), (1, 0, 1))).read()
    assert codes(found) == []
    rows = motions(made)
    corner = rows[np.argmin(np.linalg.norm(made.end[rows, :3] - (10, 0, 0), axis=1))]
    np.testing.assert_allclose(made.end[corner, :3], [10, 0, 0], atol=1e-12)
    assert math.tan(made.end[corner, 3]) == pytest.approx(10 / (10 + 5 * math.pi), rel=1e-4)
    np.testing.assert_allclose(made.end[rows[-1]], [10, 10, 0, math.pi / 4, 0], atol=1e-9)


def test_curves_and_tool_axes_in_as_many_parts_go_together():
    """Two lines of different length: where they meet the tool leans by the 45 degrees at which the axes' curves meet."""
    part = Part()
    path = composite(part, part.polyline((0, 0, 0), (10, 0, 0)), part.polyline((10, 0, 0), (10, 30, 0)))
    axis = composite(part, part.polyline((0, 0, 1), (1, 0, 1)), part.polyline((1, 0, 1), (0, 0, 1)))
    made, found = part.run_curve(path, axis=axis).read()
    assert codes(found) == []
    rows = motions(made)
    corner = rows[np.argmin(np.linalg.norm(made.end[rows, :3] - (10, 0, 0), axis=1))]
    np.testing.assert_allclose(made.end[corner], [10, 0, 0, math.pi / 4, 0], atol=1e-9)
    np.testing.assert_allclose(made.end[rows[-1], :4], [10, 30, 0, 0], atol=1e-9)


def test_a_tool_axis_on_a_cone_goes_round_with_an_arc():
    """A tool that leans outwards by 45 degrees all along a circle: B stays, but for great circles between, C turns along."""
    part = Part()
    path = part.trimmed(part.circle(10), 0, 180, master="PARAMETER")
    axis = part.trimmed(part.circle(1, origin=(0, 0, 1)), 0, 180, master="PARAMETER")
    made, found = part.run_curve(path, axis=axis).read()
    assert codes(found) == []
    rows = motions(made)[-100:]  # beyond the way to the beginning
    np.testing.assert_allclose(made.end[rows, 3], math.pi / 4, atol=5e-5)
    turned = np.unwrap(made.end[rows, 4]) - np.arctan2(made.end[rows, 1], made.end[rows, 0])
    np.testing.assert_allclose(np.cos(turned), 1.0, atol=1e-6)


def test_a_tilted_feature_turns_the_tool():
    part = Part()
    feature = part.add(
        "TOOLPATH_FEATURE", "f", None, (), part.placement((0, 0, 0), (1, 0, 0), (0, 0, -1)), None
    )
    operation = part.freeform(part.trajectory(part.polyline((0, 0, 0), (0, 0, 5))))
    part.project(part.plan(part.step(operation, feature)))
    path, _ = part.read()
    row = motions(path)[-1]
    np.testing.assert_allclose(path.end[row], [5, 0, 0, math.pi / 2, 0], atol=1e-12)


def test_a_tilted_tool():
    part = Part()
    tilted = part.add("THREE_AXES_TILTED_TOOL", part.direction(0, 0.6, 0.8))
    operation = part.freeform(part.trajectory(square(part)), direction=tilted)
    part.project(part.plan(part.step(operation)))
    path, found = part.read()
    assert codes(found) == []
    row = motions(path)[-1]
    np.testing.assert_allclose(path.end[row, 3:], [math.atan2(0.6, 0.8), math.pi / 2], atol=1e-12)


# What real files get wrong


@pytest.mark.parametrize(("given", "degrees"), [(0.5236, 30.0), (0.349066, 20.0), (0.05, 0.05)])
def test_a_tip_angle_in_radians_is_taken_so_where_it_makes_a_drill(given, degrees):
    """0.5236 rad are 30 degrees; 0.05 may be degrees of a nearly flat tool. The event has the angle between the sides."""
    part = Part()
    tool = part.tool("d", 6.0, "TWIST_DRILL", tip=given)
    part.project(part.plan(part.step(part.freeform(part.trajectory(square(part)), tool=tool))))
    path, found = part.read()
    assert codes(found) == ["stepnc-angle"]
    (event,) = [e for e in path.events if e.name == "tool"]
    assert event.values["point_angle_deg"] == pytest.approx(180.0 - 2 * degrees, abs=1e-3)


def test_missing_attributes_and_dangling_references_are_all_named():
    text = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('','',(''),(''),'','','');
FILE_SCHEMA(('MACHINING_SCHEMA'));
ENDSEC;
DATA;
#1=PROJECT('p',#2,(),$,$,$);
#2=WORKPLAN('w',(#3,#99),$,$);
#3=MACHINING_WORKINGSTEP('s',#2,$,'op',$);
#4=DIRECTION('',(0.,0.,0.));
#5=AXIS2_PLACEMENT_3D('',#4,$,$);
ENDSEC;
END-ISO-10303-21;
"""
    _, found = run(text)
    assert ("stepnc-attributes", "error", 9) in found
    assert ("part21-dangling", "error", 9) in found
    assert ("stepnc-type", "error", 10) in found


def test_faults_that_are_not_shown_are_counted_once_however_often_the_program_is_read():
    """60 operations without a tool: 50 are named, and one line says that there are 10 more."""
    part = Part()
    curve = part.polyline((0, 0, 0), (1, 0, 0))
    steps = [part.step(part.freeform(part.trajectory(curve), tool=None)) for _ in range(60)]
    part.project(part.plan(*steps))
    program = read(io.BytesIO(part.text().encode()), "t.stp")
    counts = []
    for _ in range(3):
        list(program.chunks())
        counts.append(program.diagnostics.total)
    said = [item.message for item in program.diagnostics if item.code == "stepnc-no-tool"]
    assert said[-1] == "10 more of these in the file"
    assert counts == [counts[0]] * 3


@pytest.mark.parametrize("header", ["COMBINED_SCHEMA", "INTEGRATED_CNC_SCHEMA", "SOMETHING"])
def test_the_schema_is_told_by_the_entities(header):
    part = Part()
    part.run_curve(square(part))
    path, _ = run(part.text().replace("MACHINING_SCHEMA", header))
    assert len(motions(path)) == 2


def test_a_workplan_without_a_project_whose_setup_is_broken():
    part = Part()
    held = part.add("WORKPIECE_SETUP", None, part.point(1, 2, 3), None, None, ())
    part.plan(setup=part.add("SETUP", "", None, None, (held,)))
    _, found = part.read()
    assert "stepnc-type" in codes(found, "error")


@pytest.mark.parametrize(
    ("values", "code"),
    [
        ({"feed": 1e12}, "stepnc-speed"),
        ({"feed": 1e4, "spindle": -1e14}, "stepnc-speed"),
        ({"feed": 1e308}, "stepnc-range"),
        ({"feed": 1e4, "spindle": -1e300}, "stepnc-range"),
    ],
)
def test_speeds_of_no_machine_are_refused(values, code):
    """1e308 m/s would be infinite in mm/s: numbers above 1e15 are refused as such."""
    part = Part()
    curve = part.polyline((0, 0, 0), (1, 0, 0))
    part.run_curve(curve, technology=part.technology(**values))
    assert codes(part.read()[1], "error") == [code]


@pytest.mark.parametrize(
    ("body", "edge", "tip"),
    [
        ("BALL_ENDMILL", None, (5 * math.sqrt(0.5), 0.0, 5 * (math.sqrt(0.5) - 1))),
        ("BULLNOSE_ENDMILL", 2.0, (2 * math.sqrt(0.5) + 3, 0.0, 2 * (math.sqrt(0.5) - 1))),
        ("ENDMILL", None, (5.0, 0.0, 0.0)),
    ],
)
def test_the_contact_point_and_the_surface_tell_where_the_tip_is(body, edge, tip):
    """A plane at 45 degrees that falls along X, its normal (1, 0, 1): the ball's centre is one radius along the normal."""
    part = Part()
    points = ((0, 0, 0), (0, 10, 0))
    normal = part.polyline((math.sqrt(0.5), 0, math.sqrt(0.5)), (math.sqrt(0.5), 0, math.sqrt(0.5)))
    basic = part.add("CURVE_WITH_NORMAL_VECTOR", part.polyline(*points), normal)
    contact = part.add("CUTTER_CONTACT_TRAJECTORY", *HEAD, None, basic, None, E("FRONT"))
    part.project(part.plan(part.step(part.freeform(contact, tool=part.tool(body=body, edge=edge)))))
    path, found = part.read()
    assert codes(found, "error") == []
    rows = motions(path)[-1:]
    np.testing.assert_allclose(path.starts[rows, :3], [tip], atol=1e-12)
    np.testing.assert_allclose(path.end[rows, :3], [np.add(tip, (0, 10, 0))], atol=1e-12)


def test_a_ball_round_a_cylinder_leaves_its_centre_on_a_larger_one():
    """Contact on a half circle of 20 mm in X-Z, normals outwards: the centre of a ball of 5 mm runs on 25 mm."""
    part = Part()
    curve = part.trimmed(
        part.circle(20.0, axis=(0, -1, 0), reference=(1, 0, 0)), 0.0, 180.0, master="PARAMETER"
    )
    unit = part.trimmed(
        part.circle(1.0, axis=(0, -1, 0), reference=(1, 0, 0)), 0.0, 180.0, master="PARAMETER"
    )
    basic = part.add("CURVE_WITH_NORMAL_VECTOR", curve, unit)
    contact = part.add("CUTTER_CONTACT_TRAJECTORY", *HEAD, None, basic, None, None)
    part.project(part.plan(part.step(part.freeform(contact, tool=part.tool(body="BALL_ENDMILL")))))
    path, found = part.read()
    assert codes(found, "error") == []
    centre = path.end[motions(path)][1:, :3] + [0, 0, 5.0]
    np.testing.assert_allclose(np.hypot(centre[:, 0], centre[:, 2]), 25.0, atol=2e-3)


def contact_with_axes(part, points, normals, axes, body="BALL_ENDMILL", edge=None):
    """A contact path of a tool of 10 mm with its own tool axes: returns what `Part.read` does."""
    basic = part.add("CURVE_WITH_NORMAL_VECTOR", points, normals)
    contact = part.add("CUTTER_CONTACT_TRAJECTORY", *HEAD, None, basic, axes, None)
    part.project(part.plan(part.step(part.freeform(contact, tool=part.tool(body=body, edge=edge)))))
    path, found = part.read()
    assert codes(found, "error") == []
    return path


def test_a_contact_path_with_its_own_tool_axes_keeps_each():
    """A ball of 5 mm: tip = p + 5 (n - a), wherever the normal turns and the tool leans, at the points and between."""
    part = Part()
    lean, turn = math.radians(30), math.radians(20)
    leaning = (math.sin(lean), 0.0, math.cos(lean))
    sloped = (0.0, math.sin(turn), math.cos(turn))
    points = part.polyline((0, 0, 0), (10, 0, 0), (20, 0, 0))
    normals = part.polyline((0, 0, 1), sloped, (0, 0, 1))
    path = contact_with_axes(part, points, normals, part.polyline((0, 0, 1), leaning, (0, 0, 1)))
    rows = motions(path)
    axes = tool_axes(path, rows)
    touched = path.end[rows, :3] + 5 * axes  # the ball's centre, 5 mm along the normal from the contact
    middle = int(np.argmin(np.linalg.norm(axes - leaning, axis=1)))
    np.testing.assert_allclose(axes[middle], leaning, atol=1e-12)
    np.testing.assert_allclose(touched[middle], np.array([10, 0, 0]) + 5 * np.array(sloped), atol=1e-12)
    # Between, the centre lies 5 mm from the line that is touched, less what the chords bulge.
    np.testing.assert_allclose(np.hypot(touched[:, 1], touched[:, 2]), 5.0, atol=5e-5)


def test_where_only_the_tool_axis_turns_the_contact_point_stays_on_its_line():
    """From upright to 60 degrees about a ball on a plane: its centre stays 5 mm above the line, but for 5 (1 - cos 0.25°)."""
    part = Part()
    lean = math.radians(60)
    axes = part.polyline((0, 0, 1), (math.sin(lean), 0, math.cos(lean)))
    path = contact_with_axes(
        part, part.polyline((0, 0, 0), (10, 0, 0)), part.polyline((0, 0, 1), (0, 0, 1)), axes
    )
    rows = motions(path)
    centre = path.end[rows, :3] + 5 * tool_axes(path, rows)
    np.testing.assert_allclose(centre[:, 2], 5.0, atol=5e-5)
    between = (path.starts[rows[1:], :3] + path.end[rows[1:], :3]) / 2
    b = (path.starts[rows[1:], 3] + path.end[rows[1:], 3]) / 2
    np.testing.assert_allclose(between[:, 2] + 5 * np.cos(b), 5.0, atol=5e-5)


def test_composite_contact_paths_have_the_axes_of_each_part():
    """Two lines; on the first the tool goes from upright to 30 degrees towards X, on the second back again."""
    part = Part()
    lean = (0.5, 0.0, math.sqrt(0.75))

    def joined(begin, middle, end):
        lines = [part.polyline(begin, middle), part.polyline(middle, end)]
        segments = [part.add("COMPOSITE_CURVE_SEGMENT", E("CONTINUOUS"), E("T"), x) for x in lines]
        return part.add("COMPOSITE_CURVE", "", tuple(segments), E("U"))

    points = joined((0, 0, 0), (10, 0, 0), (30, 0, 0))
    normals = joined(*3 * [(0, 0, 1)])
    path = contact_with_axes(part, points, normals, joined((0, 0, 1), lean, (0, 0, 1)))
    rows = motions(path)
    b = path.end[rows, 3]
    assert b.max() == pytest.approx(math.radians(30))
    # The contact is 5 (n - a) off the tip: where the tool leans most it is at X 10, and it leans by the length between.
    contact = path.end[rows, :3] + 5 * tool_axes(path, rows) - (0, 0, 5)
    np.testing.assert_allclose(contact[:, 1:], 0.0, atol=5e-5)
    x = contact[:, 0]
    np.testing.assert_allclose(np.degrees(b), np.interp(x, [0, 10, 30], [0, 30, 0]), atol=1e-3)


def leaning_contact(part, points, normals, angles, forward=None, body="BALL_ENDMILL"):
    """A contact path of a tool of 10 mm with a constant tilt and yaw, degrees; returns what `Part.read` does."""
    basic = part.add("CURVE_WITH_NORMAL_VECTOR", points, normals)
    sense = None if forward is None else E("T" if forward else "F")
    contact = part.add("CUTTER_CONTACT_TRAJECTORY", *HEAD, sense, basic, None, None)
    direction = part.add("FIVE_AXES_CONST_TILT_YAW", *map(float, angles))
    operation = part.freeform(contact, tool=part.tool(body=body), direction=direction)
    part.project(part.plan(part.step(operation)))
    return part.read()


def tool_axes(path, rows):
    """The unit vectors from the tip to the spindle of rows: Rz(C) Ry(B) z."""
    b, c = path.end[rows, 3], path.end[rows, 4]
    return np.column_stack([np.cos(c) * np.sin(b), np.sin(c) * np.sin(b), np.cos(b)])


@pytest.mark.parametrize(
    ("angles", "forward", "axis"),
    [
        ((30, 0), True, (0.5, 0.0, math.sqrt(0.75))),
        ((-30, 0), True, (-0.5, 0.0, math.sqrt(0.75))),
        ((30, 0), False, (-0.5, 0.0, math.sqrt(0.75))),
        ((30, 90), True, (0.0, 0.5, math.sqrt(0.75))),
    ],
)
def test_a_tool_that_leans_along_a_line(angles, forward, axis):
    """ISO 14649-11: tilted in feed direction against the normal, then turned about it. A ball's centre stays over its contact."""
    part = Part()
    line = part.polyline((0, 0, 0), (10, 0, 0))
    path, found = leaning_contact(part, line, part.polyline((0, 0, 1), (0, 0, 1)), angles, forward)
    assert codes(found) == (["stepnc-yaw"] if angles[1] else [])
    row = motions(path)[-1:]
    np.testing.assert_allclose(tool_axes(path, row), [axis], atol=1e-12)
    end = (10.0 if forward else 0.0, 0.0, 5.0)
    np.testing.assert_allclose(path.end[row, :3], [np.array(end) - 5 * np.array(axis)], atol=1e-12)


def test_a_tool_that_leans_turns_in_a_corner():
    part = Part()
    corner = part.polyline((0, 0, 0), (10, 0, 0), (10, 10, 0))
    path, found = leaning_contact(part, corner, part.polyline(*[(0, 0, 1)] * 3), (20, 0))
    assert codes(found) == []
    rows = motions(path)[2:]
    axes = tool_axes(path, rows)
    centre = path.end[rows, :3] + 5 * axes
    np.testing.assert_allclose(centre[:, 2], 5.0, atol=1e-9)
    up = np.cos(np.radians(20))
    np.testing.assert_allclose(axes[:, 2], up, atol=1e-9)
    turning = np.linalg.norm(centre[:, :2] - (10, 0), axis=1) < 1e-9
    assert turning.sum() > 100  # 90 degrees by half a degree
    np.testing.assert_allclose(axes[-1], [0, np.sin(np.radians(20)), up], atol=1e-9)


def test_a_tool_that_leans_round_a_cylinder_keeps_its_angle():
    """A half circle of 20 mm in X-Z, normals outwards, tilt 10: the axis is 10 degrees from the normal everywhere."""
    part = Part()
    place = {"axis": (0, -1, 0), "reference": (1, 0, 0)}
    curve = part.trimmed(part.circle(20.0, **place), 45.0, 135.0, master="PARAMETER")
    unit = part.trimmed(part.circle(1.0, **place), 45.0, 135.0, master="PARAMETER")
    path, found = leaning_contact(part, curve, unit, (10, 0))
    assert codes(found) == []
    rows = motions(path)[2:]
    axes = tool_axes(path, rows)
    normal = path.end[rows, :3] + 5 * axes
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    np.testing.assert_allclose((normal * axes).sum(axis=1), np.cos(np.radians(10)), atol=2e-4)
    # The feed goes from +X to -X, so the tool leans towards -X at the top.
    top = np.abs(normal[:, 0]).argmin()
    assert axes[top, 0] == pytest.approx(-np.sin(np.radians(10)), abs=0.02)


def test_the_tips_path_with_surface_normals_leans_too():
    part = Part()
    normals = part.polyline((0, 0, 1), (0, 0, 1))
    curve = part.polyline((0, 0, 0), (0, 10, 0))
    trajectory = part.add("CUTTER_LOCATION_TRAJECTORY", *HEAD, None, curve, None, normals)
    direction = part.add("FIVE_AXES_CONST_TILT_YAW", 30.0, 0.0)
    part.project(part.plan(part.step(part.freeform(trajectory, direction=direction))))
    path, found = part.read()
    assert codes(found) == []
    row = motions(path)[-1:]
    np.testing.assert_allclose(path.end[row, :3], [[0, 10, 0]], atol=1e-12)
    np.testing.assert_allclose(tool_axes(path, row), [[0, 0.5, math.sqrt(0.75)]], atol=1e-12)


@pytest.mark.parametrize(
    ("angles", "end", "code"),
    [((95, 0), (10, 0, 0), "stepnc-geometry"), ((30, 0), (0, 0, 10), "stepnc-geometry")],
)
def test_a_lean_that_cannot_be_is_refused(angles, end, code):
    """Under the surface; along the normal, where no feed lies in the surface."""
    part = Part()
    normals = part.polyline((0, 0, 1), (0, 0, 1))
    _, found = leaning_contact(part, part.polyline((0, 0, 0), end), normals, angles)
    assert codes(found, "error") == [code]


def test_a_lean_without_normals_or_toolpaths_is_refused():
    part = Part()
    direction = part.add("FIVE_AXES_CONST_TILT_YAW", 30.0, 0.0)
    line = part.trajectory(part.polyline((0, 0, 0), (5, 0, 0)))
    part.project(part.plan(part.step(part.freeform(line, direction=direction))))
    assert codes(part.read()[1], "error") == ["stepnc-missing"]


def speeds_of(options, **tool):
    """The spindle events of an operation with 11 'm/s' and 5.8357 'rev/s' on a tool of 6 mm."""
    part = Part()
    technology = part.technology(spindle=5.8357, cutspeed=11.0)
    line = part.trajectory(part.polyline((0, 0, 0), (1, 0, 0)))
    part.project(
        part.plan(part.step(part.freeform(line, technology=technology, tool=part.tool(diameter=6.0, **tool))))
    )
    program = read(io.BytesIO(part.text().encode()), "t.stp", ReadOptions(**options))
    events = [e for chunk in program.chunks() for e in chunk.events if e.name == "spindle"]
    return [(e.values["direction"], round(e.values["speed_rpm"], 2)) for e in events], codes_of(program)


def codes_of(program):
    return [d.code for d in program.diagnostics]


def test_cutting_speeds_in_metres_a_minute_and_senses_by_the_tools_hand():
    """As one adapter writes them: 1000 * 11 / (pi * 6) = 583.57 rev/min."""
    assert speeds_of({})[0] == [(-1, 350.14)]
    assert "stepnc-spindle-sign" in speeds_of({})[1]
    assert speeds_of({"speed_unit": "m/min"}) == ([(1, 583.57)], [])
    assert speeds_of({"spindle_sign": "tool"})[0] == [(1, 350.14)]
    assert speeds_of({"spindle_sign": "tool"}, hand="LEFT")[0] == [(-1, 350.14)]


def test_probing_goes_along_its_toolpath_and_measures_nothing():
    part = Part()
    touch = part.trajectory(
        part.polyline((0, 0, 5), (0, 0, 0)), technology=part.technology(feed=0.005, spindle=None)
    )
    paths = part.add("TOOLPATH_LIST", (touch,))
    part.project(part.plan(part.add("TOUCH_PROBING", "probe", None, paths, None, None)))
    path, found = part.read()
    assert ("probe-not-run", "note") in [(c, s) for c, s, _ in found]
    assert codes(found, "error") == []
    assert path.end[motions(path)][-1].tolist() == [0, 0, 0]
    assert path.feed[motions(path)][-1] == 5.0


def test_probing_without_a_toolpath_is_refused():
    part = Part()
    part.project(part.plan(part.add("TOUCH_PROBING", "probe", None, None, None, None)))
    assert codes(part.read()[1], "error") == ["stepnc-unsupported"]


@pytest.mark.parametrize("second", ["WORKPIECE_SETUP($,#9001,$,$,())", "PLANE('',#9001)"])
def test_a_number_defined_twice_is_a_diagnostic(second):
    """Found by fuzzing: the instances of a type may hold one whose number is another entity's."""
    part = Part()
    part.run_curve(part.polyline((0, 0, 0), (1, 0, 0)))
    tilted = "#9001=AXIS2_PLACEMENT_3D('',#1,#9002,$);\n#9002=DIRECTION('',(1.,0.,0.));\n"
    text = part.text().replace("DATA;\n", f"DATA;\n#9000=PLANE('',#9001);\n#9000={second};\n{tilted}", 1)
    _, found = run(text)
    assert "part21-duplicate" in codes(found, "error")
    assert list(tree(text.encode(), "t.stp"))


def test_a_feed_that_is_none_of_a_tool_is_asked_about():
    """0.175 m/s at 350 rev/min are 30 mm a turn: 0.175 mm per revolution was meant (as in files of one writer)."""
    part = Part()
    line = part.trajectory(part.polyline((0, 0, 0), (5, 0, 0)))
    technology = part.technology(feed=0.175, spindle=-5.8357)
    part.project(
        part.plan(part.step(part.freeform(line, technology=technology, tool=part.tool(diameter=6.0))))
    )
    assert codes(part.read()[1]) == ["stepnc-feed-unit"]
