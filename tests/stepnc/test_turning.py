"""Turning (ISO 14649-12, AP238): explicit toolpaths at a spindle or cutting speed; what cannot be made is named."""

import io
import math

import numpy as np
import pytest

from cncgen.stepnc import read
from cncgen.toolpath.record import FeedMode
from tests.stepnc.aim import Aim
from tests.stepnc.building import WHOLE, E, Part, codes, motions, run

KEYS = ["TURNING_TYPE_OPERATION", "FACING_TURNING_OPERATION", "GROOVING_TURNING_OPERATION"]


def turned(curve, speed, keyword="CONTOURING_ROUGH", per_turn=0.2, feed=None, sync="F", workingstep=True):
    """Return a part whose one operation follows a curve (a list of points), None: without a toolpath."""
    part = Part()
    path = None
    if curve is not None:
        path = part.add("TOOLPATH_LIST", (part.trajectory(part.polyline(*curve)),))
    technology = part.add(
        "TURNING_TECHNOLOGY", feed, E("TCP"), part.add(*speed), per_turn, E(sync), E("F"), E("F")
    )
    functions = part.add("TURNING_MACHINE_FUNCTIONS", E("T"), None, None, (), E("F"), (), None)
    tool = part.add("TURNING_MACHINE_TOOL", "T1", None, (), None, None)
    operation = part.add(
        keyword,
        path,
        None,
        "op",
        None,
        None,
        tool,
        technology,
        functions,
        None,
        None,
        None,
        *([None] if keyword.startswith("CUTTING") else []),
        *([] if keyword == "KNURLING" else [0.5]),
    )
    workpiece = part.add("WORKPIECE", "w", None, None, None, None, None, ())
    size = part.add("TOLERANCED_LENGTH_MEASURE", 50.0, None)
    feature = part.add("OUTER_DIAMETER", "f", workpiece, (), part.placement((0, 0, 7)), size, size, None)
    if workingstep:
        step = part.add("TURNING_WORKINGSTEP", "ws", None, (feature,), operation)
    else:
        step = part.step(operation, feature)
    part.project(part.plan(step))
    return part


@pytest.mark.parametrize("workingstep", [True, False])
def test_a_cut_at_a_spindle_speed(workingstep):
    """0.2 mm a turn at 20 turns a second are 4 mm/s, M3 for a negative speed; the feature stands 7 mm along Z."""
    part = turned([(25, 0, 5), (25, 0, -40)], ("CONST_SPINDLE_SPEED", -20.0), workingstep=workingstep)
    path, found = part.read()
    assert codes(found) == []
    row = motions(path)[-1]
    np.testing.assert_allclose(path.end[row], [25, 0, -33])
    assert path.feed[row] == pytest.approx(4.0)
    values = {e.name: dict(e.values) for e in path.events}
    assert values["spindle"] == {"speed_rpm": 1200.0, "direction": 1}
    assert values["coolant"]["flood"]
    assert values["tool"]["tool"] == "T1"


def facing_time(outer, inner, speed, per_turn, most=None):
    """Return how long facing takes at a constant cutting speed: dt = 2 pi r dr / (f v), and dr / (f n) within the radius of n."""
    slow = 0.0 if most is None else min(max(speed / (2 * math.pi * most), inner), outer)
    low = max(inner, slow)
    return math.pi * (outer**2 - low**2) / (per_turn * speed) + (
        0.0 if most is None else (low - inner) / (per_turn * most)
    )


def seconds(path):
    rows = [k for k in motions(path) if path.feed_mode[k] == FeedMode.SPEED]
    lengths = np.linalg.norm((path.end - path.starts)[rows], axis=1)
    return float((lengths / path.feed[rows]).sum())


@pytest.mark.parametrize("most", [None, 50.0])
def test_facing_at_a_constant_cutting_speed_takes_as_long_as_the_integral(most):
    """2 m/s from a radius of 25 mm to 2 mm, 0.2 mm a turn; with 50 turns a second at most, reached at 6.37 mm."""
    part = turned([(25, 0, -7), (2, 0, -7)], ("CONST_CUTTING_SPEED", 2.0, most), "FACING_ROUGH")
    path, found = part.read()
    assert {c[:2] for c in found} == {("stepnc-spindle-sign", "note")}
    assert seconds(path) == pytest.approx(facing_time(25.0, 2.0, 2000.0, 0.2, most), rel=2e-3)
    spindle = next(e for e in path.events if e.name == "spindle")
    assert spindle.values["speed_rpm"] == pytest.approx(60 * 2000.0 / (2 * math.pi * 25.0))


def test_threading_in_step_with_the_spindle():
    """A pass of 1.5 mm a turn: the pitch is the feed per revolution."""
    part = turned(
        [(10, 0, 5), (10, 0, -20)], ("CONST_SPINDLE_SPEED", -10.0), "THREADING_ROUGH", 1.5, sync="T"
    )
    path, found = part.read()
    assert codes(found) == []
    assert [e.values["pitch_mm"] for e in path.events if e.name == "synchronise"] == [1.5, None]
    assert path.feed[motions(path)[-1]] == pytest.approx(15.0)


@pytest.mark.parametrize("keyword", ["CUTTING_IN", "KNURLING"])
def test_operations_that_are_not_made_are_named(keyword):
    part = turned(None, ("CONST_SPINDLE_SPEED", -20.0), keyword)
    program = read(io.BytesIO(part.text().encode()), "t.stp", WHOLE)
    (path,) = program.chunks()
    assert not len(motions(path))
    errors = [d for d in program.diagnostics if d.severity == "error"]
    assert [d.code for d in errors] == ["stepnc-unsupported"]
    assert keyword.replace("_", " ").lower() in errors[0].message


def test_the_sign_of_the_largest_speed_tells_the_sense():
    """ISO 14649-10: a rot_speed_measure below 0 turns with the clock."""
    path, found = turned(
        [(25, 0, -7), (2, 0, -7)], ("CONST_CUTTING_SPEED", 2.0, -50.0), "FACING_ROUGH"
    ).read()
    assert codes(found) == []
    assert next(e for e in path.events if e.name == "spindle").values["direction"] == 1
    assert seconds(path) == pytest.approx(facing_time(25.0, 2.0, 2000.0, 0.2, 50.0), rel=2e-3)


@pytest.mark.parametrize(
    ("kind", "on"), [("FLOOD", "flood"), ("MIST", "mist"), ("THROUGH_TOOL", "through_spindle")]
)
def test_the_type_of_coolant(kind, on):
    """ISO 14649-12: coolant_type of turning_machine_functions."""
    part = turned([(25, 0, 5), (25, 0, -40)], ("CONST_SPINDLE_SPEED", -20.0))
    text = part.text().replace("TURNING_MACHINE_FUNCTIONS(.T.,$", f"TURNING_MACHINE_FUNCTIONS(.T.,.{kind}.")
    path, _ = run(text)
    coolant = next(e for e in path.events if e.name == "coolant")
    assert {k for k, v in coolant.values.items() if v} == {on}


@pytest.mark.parametrize("keyword", KEYS)
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("most", [None, 50.0])
def test_ap238_at_a_constant_cutting_speed(keyword, most, sign):
    """As Next-NC writes it: a surface speed in length a minute, below 0 with the clock, and the largest rotational speed."""
    aim = Aim()
    step, operation = aim.step(keyword)
    file, minute = aim.file, aim.minute()
    technology = file.method("MACHINING_TECHNOLOGY", "", "turning")
    item = file.measure("feed per revolution", 0.2, file.feed_per_turn)
    name = "MACHINING_FEED_SPEED_REPRESENTATION"
    file.property(technology, "feedrate", name, "feed per revolution", item)
    items = [
        file.measure("surface speed", sign * 120_000.0, file._product((file.length, 1.0), (minute, -1.0)))
    ]
    if most is not None:
        items.append(file.measure("maximum rotational speed", most, file.spindle_unit))
    name = "MACHINING_SPINDLE_SPEED_REPRESENTATION"
    file.property(technology, "spindle", name, "cutting speed", *items)
    aim.path(operation, aim.polyline((25, 0, 0), (2, 0, 0)), technology)
    path, found = aim.read(aim.plan(step))
    assert {c[:2] for c in found} == ({("stepnc-spindle-sign", "note")} if sign > 0 else set())
    assert next(e for e in path.events if e.name == "spindle").values["direction"] == 1
    assert seconds(path) == pytest.approx(facing_time(25.0, 2.0, 2000.0, 0.2, most), rel=2e-3)


def test_an_operation_of_ap238_without_toolpaths_and_feature_is_named():
    aim = Aim()
    step, _ = aim.step("GROOVING_TURNING_OPERATION")
    assert codes(aim.read(aim.plan(step))[1], "error") == ["stepnc-missing"]


def test_setpoints_of_a_lathe_hold_limits_and_stay_in_their_plane(tmp_path, cncgen):
    """Setpoints that `verify` finds within limits and path; X is a radius, Y stays 0."""
    part = turned([(25, 0, -7), (20, 0, -7), (20, 0, -40), (30, 0, -45)], ("CONST_CUTTING_SPEED", 2.0, 50.0))
    program, out = tmp_path / "shaft.stp", tmp_path / "shaft.csv"
    program.write_text(part.text("(START, X30 Y0 Z20)"))
    done = cncgen("plan", program, "-m", "generic-mill", "-o", out)
    assert done.returncode == 0, done.stderr
    assert cncgen("verify", out, "--program", program, "-m", "generic-mill").returncode == 0
    rows = np.genfromtxt(out, delimiter=",", names=True)
    assert np.abs(rows["y_mm"]).max() == 0.0
    assert rows["z_mm"][-1] == pytest.approx(-38.0)
