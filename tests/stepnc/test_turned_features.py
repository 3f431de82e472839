"""Turning without toolpaths of the file (ISO 14649-12): where the tool goes, against closed forms."""

import math
from pathlib import Path

import numpy as np
import pytest

from cncgen.toolpath.record import FeedMode, Kind
from tests.stepnc.building import E, codes, motions, run
from tests.stepnc.turning_parts import Turned


def fed(path):
    """Return start and end of the motions at the feed, (x, z) each, shape (n, 2, 2)."""
    rows = [k for k in motions(path) if path.feed_mode[k] == FeedMode.SPEED]
    return np.stack([path.starts[rows][:, [0, 2]], path.end[rows][:, [0, 2]]], axis=1)


def test_facing_in_passes_of_the_cutting_depth():
    """A bar with 3.5 mm before the face, 2, 1 and then 1 mm deep, 0.3 left: faces at 1.5, 0.5 and 0.3, past the axis by the nose."""
    part = Turned(50, 100, 3.5)
    part.turn("FACING_ROUGH", part.face(25), part.turning_tool(0.8), part.ways(depths=(2.0, 1.0)), 0.3)
    path, found = run(part.whole())
    assert codes(found) == []
    cuts = [s for s in fed(path) if s[0, 1] == s[1, 1]]
    np.testing.assert_allclose([s[0, 1] for s in cuts], [1.5, 0.5, 0.3])
    np.testing.assert_allclose([s[1, 0] for s in cuts], -0.8)
    assert min(s[0, 0] for s in cuts) > 25


def test_a_face_with_a_hub_stops_there():
    part = Turned(50, 100, 1.0)
    part.turn("FACING_FINISH", part.face(25, hub=6.0), part.turning_tool(0.4))
    path, found = run(part.whole())
    assert codes(found) == []
    assert fed(path)[:, :, 0].min() == pytest.approx(6.0)


def test_the_rear_face_is_faced_from_behind():
    part = Turned(50, 100, 0.0)
    part.turn("FACING_FINISH", part.face(25, z=-99.0), part.turning_tool(0.4))
    path, found = run(part.whole())
    assert codes(found) == []
    np.testing.assert_allclose(fed(path)[0][:, 1], -99.0)
    assert fed(path)[:, :, 1].min() < -99.0


@pytest.mark.parametrize("nose", [0.0, 0.4, 0.8])
@pytest.mark.parametrize("angle", [10.0, 45.0])
def test_the_nose_touches_a_cone(nose, angle):
    """The corner of a tool runs beside a cone by r (1 - tan(a / 2)) along X (R. Smith's rule for radius compensation)."""
    rise = 20 * math.tan(math.radians(angle))
    part = Turned(100, 100)
    feature = part.revolution((10, 0), (10 + rise, -20), (10 + rise, -40))
    part.turn("CONTOURING_FINISH", feature, part.turning_tool(nose))
    path, found = run(part.whole())
    assert codes(found) == []
    slopes = [
        s
        for s in fed(path)
        if abs(s[1, 0] - s[0, 0] - math.tan(math.radians(angle)) * (s[0, 1] - s[1, 1])) < 1e-3
    ]
    x, z = max((s for s in slopes if s[1, 1] < s[0, 1] - 1), key=lambda s: s[0, 1] - s[1, 1])[0]
    # From the cone's surface to the corner along X; the corner stands at (centre - nose, centre - nose).
    surface = 10 - z * math.tan(math.radians(angle))
    a = math.radians(angle)
    assert x - surface == pytest.approx(nose * (1 / math.cos(a) - 1 - math.tan(a)), abs=2e-3)


def test_rounded_profiles_become_arcs():
    """A quarter of 10 mm is followed with 10.8 mm by the centre of a nose of 0.8 mm (concave: 9.2)."""
    part = Turned(60, 100)
    circle = part.circle(10.0, origin=(20, 0, -10), axis=(0, -1, 0), reference=(1, 0, 0))
    arc = part.trimmed(circle, (10.0, 0.0, -10.0), (20.0, 0.0, -20.0), sense=True)
    first, last = part.polyline((10, 0, 0), (10, 0, -10)), part.polyline((20, 0, -20), (25, 0, -20))
    segments = tuple(
        part.add("COMPOSITE_CURVE_SEGMENT", E("CONTINUOUS"), E("T"), c) for c in (first, arc, last)
    )
    curve = part.add("COMPOSITE_CURVE", "", segments, E("F"))
    feature = part.turned("GENERAL_REVOLUTION", None, 0.0, part.add("GENERAL_PROFILE", None, curve))
    part.turn("CONTOURING_FINISH", feature, part.turning_tool(0.8))
    path, found = run(part.whole())
    assert codes(found) == []
    rows = np.flatnonzero(path.kind == Kind.ARC)
    radii = [float(np.linalg.norm(path.starts[k] - path.arcs.centre[path.curve[k]])) for k in rows]
    assert any(r == pytest.approx(9.2, abs=2e-3) for r in radii)


def test_roughing_leaves_the_allowance_and_no_step_is_deeper():
    part = Turned(50, 100)
    feature = part.revolution((10, 0), (10, -20), (18, -20), (18, -40))
    part.turn("CONTOURING_ROUGH", feature, part.turning_tool(), part.ways(depths=(3.0,)), 0.5)
    path, found = run(part.whole())
    assert codes(found) == []
    levels = sorted(
        {round(float(s[0, 0]), 6) for s in fed(path) if s[0, 0] == s[1, 0] and s[0, 1] - s[1, 1] > 5},
        reverse=True,
    )
    assert levels == pytest.approx([22.0, 19.0, 18.5, 16.0, 13.0, 10.5])
    assert max(-np.diff([25.0, *levels])) <= 3.0 + 1e-9


def test_several_features_in_one_workingstep():
    """Two diameters and the shoulder between them, in any order, make one profile."""
    part = Turned(50, 100)
    features = (part.diameter(40, 30, -20), part.face(20, z=-20, hub=10), part.diameter(20, 20, 0))
    part.turn("CONTOURING_FINISH", features, part.turning_tool())
    path, found = run(part.whole())
    assert codes(found) == []
    corners = np.unique(np.round(fed(path)[:, 1], 6), axis=0).tolist()
    for corner in ([10.0, -20.0], [20.0, -20.0], [20.0, -50.0]):
        assert corner in corners


@pytest.mark.parametrize("width", [2.0, 3.0, 4.0])
def test_a_groove_is_plunged_from_wall_to_wall(width):
    """The left edge of the tool from -14 to -10 less its width, never deeper than the floor with its allowance."""
    part = Turned(30, 60)
    part.turn("GROOVING_ROUGH", part.groove(10, 4, -12), part.grooving_tool(width))
    path, found = run(part.whole())
    assert codes(found) == []
    deep = np.array([s[1] for s in fed(path) if abs(s[1, 0] - 10.0) < 1e-6])
    assert deep[:, 1].min() == pytest.approx(-14.0)
    assert deep[:, 1].max() == pytest.approx(-10.0 - width)
    assert fed(path)[:, :, 0].min() >= 10.0 - 1e-6


def test_the_walls_and_rounded_corners_of_a_groove_are_finished():
    part = Turned(30, 60)
    part.turn("GROOVING_FINISH", part.groove(10, 5, -12, corner=1.0), part.grooving_tool(2.0, nose=0.2))
    path, found = run(part.whole())
    assert codes(found) == []
    rows = np.flatnonzero(path.kind == Kind.ARC)
    assert [
        float(np.linalg.norm(path.starts[k] - path.arcs.centre[path.curve[k]])) for k in rows
    ] == pytest.approx([0.8, 0.8], abs=1e-3)
    assert fed(path)[:, :, 0].min() == pytest.approx(10.0)


@pytest.mark.parametrize("way", ["CENTER", "LEFT_ZIGZAG"])
def test_a_thread_is_cut_in_step_in_passes_that_take_alike(way):
    """A way along the flanks is told to be straight in. A metric thread M20 x 2: 17/24 of the triangle's height, 1.2269 mm; passes of 0.4 mm grow with the root of their number."""
    part = Turned(20, 60)
    base = part.diameter(20, 30, 0)
    area = part.add("PARTIAL_AREA_DEFINITION", 24.0, part.placement(), None)
    text = part.add("DESCRIPTIVE_PARAMETER", "hand", "right")
    count = part.add("NUMERIC_PARAMETER", "threads", 0.5, "mm")
    thread = part.add("CATALOGUE_THREAD", "M20", part.workpiece, (), part.placement((0, 0, -30)), None, area, (base,),
                      E("F"), None, text, text, 20.0, count, text, None)  # fmt: skip
    part.heights[thread] = -30
    ways = part.add(
        "THREAD_STRATEGY",
        None,
        E("T"),
        (0.4,),
        None,
        E("CONSTANT_REMOVAL_AMOUNT"),
        E(way),
        None,
        None,
    )
    part.turn("THREADING_ROUGH", thread, part.threading_tool(2.0), ways, per_turn=2.0)
    path, found = run(part.whole())
    assert codes(found) == ([] if way == "CENTER" else ["stepnc-approach"])
    height = 17 / 24 * math.sqrt(3) / 2 * 2.0
    cuts = [s for s in fed(path) if s[0, 1] - s[1, 1] > 10]
    depths = [10 - s[0, 0] for s in cuts]
    np.testing.assert_allclose(depths, [*(0.4 * math.sqrt(k) for k in range(1, 10)), height])
    np.testing.assert_allclose([s[1, 1] for s in cuts], -24.0)
    np.testing.assert_allclose([s[0, 1] for s in cuts], 6.0)
    assert [e.values["pitch_mm"] for e in path.events if e.name == "synchronise"] == [2.0, None] * 10


REFUSED = {
    "a wall that the tool would have to fall down": (
        "stepnc-tool-size",
        [(15, 0), (15, -10), (10, -10), (10, -20)],
        {},
    ),
    "a fall steeper than the trailing edge": (
        "stepnc-tool-size",
        [(15, 0), (10, -10), (10, -20)],
        {"trailing": 20.0},
    ),
    "a hollow in roughing": (
        "stepnc-unsupported",
        [(15, 0), (10, -20), (10, -30), (18, -30)],
        {"trailing": 40.0},
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_profiles_that_the_tool_would_spoil_are_refused(name):
    code, points, tool = REFUSED[name]
    part = Turned(50, 100)
    part.turn("CONTOURING_ROUGH", part.revolution(*points), part.turning_tool(**tool), part.ways())
    path, found = run(part.whole())
    assert codes(found, "error") == [code]
    assert not len(fed(path))


def test_material_in_front_of_a_diameter_is_faced_first_or_told():
    for front, severity in ((3.0, "warning"), (20.0, "error")):
        part = Turned(50, 100, front)
        part.turn("CONTOURING_FINISH", part.diameter(40, 30, 0), part.turning_tool())
        _, found = run(part.whole())
        assert codes(found, severity) == ["stepnc-depth" if severity == "warning" else "stepnc-geometry"]
    part = Turned(50, 100, 20.0)
    part.turn("FACING_ROUGH", part.face(25), part.turning_tool(), part.ways())
    part.turn("CONTOURING_FINISH", part.diameter(40, 30, 0), part.turning_tool())
    assert codes(run(part.whole())[1]) == []


def test_a_tool_wider_than_the_groove_is_refused():
    part = Turned(30, 60)
    part.turn("GROOVING_ROUGH", part.groove(10, 4, -12), part.grooving_tool(4.5))
    assert codes(run(part.whole())[1]) == ["stepnc-tool-size"]
    part = Turned(30, 60)
    part.turn("GROOVING_ROUGH", part.groove(5, 4, -12), part.grooving_tool(3.0, reach=8.0))
    assert codes(run(part.whole())[1]) == ["stepnc-tool-size"]


def test_setpoints_of_a_turned_shaft_hold_the_limits(tmp_path, cncgen):
    """Planned and verified; the smallest radius that setpoints reach in front of Z 0 and in the groove is that of the features."""
    program = Path(__file__).parents[2] / "programs" / "stepnc" / "shaft.stp"
    out = tmp_path / "shaft.csv"
    done = cncgen("plan", program, "-m", "generic-mill", "--effort", "fast", "-o", out)
    assert done.returncode == 0, done.stderr.decode()
    done = cncgen("verify", out, "--program", program, "-m", "generic-mill")
    assert done.returncode == 0, done.stderr.decode()
    rows = np.genfromtxt(out, delimiter=",", names=True)
    groove = (rows["z_mm"] < -11) & (rows["z_mm"] > -15)
    assert np.abs(rows["y_mm"]).max() == 0.0
    assert rows["x_mm"][groove].min() == pytest.approx(7.0, abs=0.02)
    assert rows["x_mm"].min() == pytest.approx(-0.8, abs=1e-3)


def test_workplans_of_two_channels_are_told():
    """Two turrets: each workplan is done, one after the other."""
    part = Turned(50, 100)
    part.turn("FACING_FINISH", part.face(25), part.turning_tool())
    channels = [part.add("CHANNEL", str(k)) for k in (1, 2)]
    plans = [part.add("WORKPLAN", "turret", (), c, None, None) for c in channels]
    part.project(part.plan(*plans, *part.steps))
    _, found = run(part.text())
    assert codes(found) == ["stepnc-channel"]


def test_no_pass_begins_below_the_front_of_a_profile_that_falls():
    """A pass at radius 14.4 would begin inside the front, which has 15; the way along the profile cuts the fall."""
    part = Turned(40, 100)
    feature = part.revolution((15, 0), (14, -3), (14, -10), (18, -10), (18, -12))
    part.turn("CONTOURING_ROUGH", feature, part.turning_tool(trailing=40.0), part.ways(depths=(2.8,)))
    path, found = run(part.whole())
    assert codes(found) == []
    front = [s for s in fed(path) if s[0, 1] > 0]
    assert min(s[0, 0] for s in front) == pytest.approx(15.0)
