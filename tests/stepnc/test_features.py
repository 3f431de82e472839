"""Toolpaths of features: what is cut, by heights on a grid, against the region that a round tool reaches; and the sequences of holes."""

import cmath
import math
from pathlib import Path

import numpy as np
import pytest
import shapely
from shapely import Point, Polygon, box

from cncgen.stepnc import read
from cncgen.stepnc.features.offsets import polygon_of, strip
from cncgen.stepnc.geometry.pieces import Polyline
from cncgen.toolpath.record import FeedMode, Kind
from tests.stepnc.building import E, codes, motions
from tests.stepnc.featured import GRID, ORIGIN, SIZE, Features, cells, check_cut, pocket_operation, tops
from tests.stepnc.heightfield import removed

L_SHAPE = ((-30, -20), (30, -20), (30, 0), (0, 0), (0, 20), (-30, 20))


@pytest.mark.parametrize(
    "strategy", ["CONTOUR_PARALLEL", "CONTOUR_SPIRAL", "BIDIRECTIONAL_MILLING", "UNIDIRECTIONAL_MILLING"]
)
@pytest.mark.parametrize("shape", ["rectangle", "circle", "polygon"])
def test_pockets_are_cleared_and_no_more(strategy, shape):
    part = Features()
    if shape == "rectangle":
        boundary, region = part.rectangle(60, 40), box(-30, -20, 30, 20)
    elif shape == "circle":
        boundary, region = (
            part.add("CIRCULAR_CLOSED_PROFILE", None, part.size(50)),
            Point(0, 0).buffer(25, 128),
        )
    else:
        boundary, region = part.polygon(*L_SHAPE), Polygon(L_SHAPE)
    part.mill(part.pocket(boundary), pocket_operation(part, strategy))
    heights, _ = part.heights(4.0)
    check_cut(heights, region, 4.0, 6.0)


@pytest.mark.parametrize("sides", [3, 6])
@pytest.mark.parametrize("across", [False, True])
def test_a_pocket_with_sides(sides, across):
    """ISO 14649-10, ngon_profile: one side is parallel to X and crosses Y at a negative value; where the flag is false the
    circle of the diameter surrounds the n-gon, else the n-gon surrounds the circle."""
    part = Features()
    boundary = part.add("NGON_CLOSED_PROFILE", None, part.size(40), sides, E("T") if across else E("F"))
    part.mill(part.pocket(boundary), pocket_operation(part))
    heights, _ = part.heights(4.0)
    radius = 20.0 / math.cos(math.pi / sides) if across else 20.0
    down = -math.pi / 2 - math.pi / sides  # the left corner of the lowest side
    corners = [
        (radius * math.cos(down + a), radius * math.sin(down + a))
        for a in np.arange(sides) * 2 * math.pi / sides
    ]
    assert corners[0][1] == pytest.approx(corners[1][1])
    assert corners[0][1] < 0
    check_cut(heights, Polygon(corners), 4.0, 6.0)


@pytest.mark.parametrize("sides", [2, 1e6])
def test_a_polygon_of_no_sides_is_refused(sides):
    part = Features()
    boundary = part.add("NGON_CLOSED_PROFILE", None, part.size(40), int(sides), E("T"))
    part.mill(part.pocket(boundary), pocket_operation(part))
    assert codes(part.read()[1], "error") == ["stepnc-geometry"]


def test_corners_that_rings_a_diameter_apart_leave_are_cut_too():
    """In a corner of angle a rings 8 mm apart stand 8 / sin (a/2) mm apart, more than the tool of 8 mm reaches."""
    triangle = ((0.0, 25.0), (-40.0, -15.0), (40.0, -15.0))
    part = Features()
    strategy = part.add("CONTOUR_PARALLEL", 0.0, E("T"), E("CCW"), E("CLIMB"))
    operation = part.operation(
        "BOTTOM_AND_SIDE_FINISH_MILLING", 3.0, 8.0, None, None, strategy=strategy, diameter=8.0
    )
    heights, found = part.mill(part.pocket(part.polygon(*triangle)), operation).heights(4.0)
    assert codes(found) == []
    check_cut(heights, Polygon(triangle), 4.0, 6.0)


def test_a_pocket_with_bosses():
    part = Features()
    bosses = (
        part.boss(part.polygon((-15, -6), (-5, -6), (-5, 6), (-15, 6))),
        part.boss(part.polygon((10, -8), (20, 8), (5, 8))),
    )
    feature = part.pocket(part.rectangle(70, 50), bosses)
    part.mill(feature, pocket_operation(part))
    heights, _ = part.heights(4.0)
    region = box(-35, -25, 35, 25) - box(-15, -6, -5, 6) - Polygon([(10, -8), (20, 8), (5, 8)])
    check_cut(heights, region, 4.0, 6.0)


def test_allowances_stay():
    part = Features()
    part.mill(part.pocket(part.rectangle(60, 40)), pocket_operation(part, finish=False, side=1.5, bottom=0.5))
    heights, _ = part.heights(4.0)
    check_cut(heights, box(-28.5, -18.5, 28.5, 18.5), 4.0, 5.5)


def test_rings_of_a_circle_are_circles():
    """Offsets of a polygon that stands for a circle go back to arcs of the right radius."""
    part = Features()
    part.mill(part.pocket(part.add("CIRCULAR_CLOSED_PROFILE", None, part.size(50))), pocket_operation(part))
    path, _ = part.read()
    full = path.arcs.sweep > 6.0
    flat = np.abs(path.end[path.kind == Kind.ARC][:, 2] - path.starts[path.kind == Kind.ARC][:, 2]) < 1e-9
    rows = np.flatnonzero(path.kind == Kind.ARC)[flat]
    radius = np.linalg.norm(path.starts[rows, :2] - path.arcs.centre[flat, :2], axis=1)
    assert np.abs(radius - 21.0).min() < 1e-3
    assert full.any()
    assert (path.kind == Kind.LINE).sum() < 60


@pytest.mark.parametrize("climb", [True, False])
def test_climb_and_conventional(climb):
    """Climb milling of a pocket with M3 goes against the clock: the wall is on the right."""
    part = Features()
    strategy = part.add("CONTOUR_PARALLEL", 0.4, E("T"), None, E("CLIMB" if climb else "CONVENTIONAL"))
    operation = part.operation("BOTTOM_AND_SIDE_FINISH_MILLING", 10.0, 5.0, None, None, strategy=strategy)
    part.mill(part.pocket(part.rectangle(60, 40)), operation)
    path, _ = part.read()
    ring = path.end[motions(path)][-7:-1, :2] - ORIGIN[:2]
    area = 0.5 * np.sum(ring[:-1, 0] * ring[1:, 1] - ring[1:, 0] * ring[:-1, 1])
    assert (area > 0) == climb


@pytest.mark.parametrize(
    ("keyword", "values"),
    [
        ("PLUNGE_TOOLAXIS", ()),
        ("PLUNGE_RAMP", (8.0,)),
        ("PLUNGE_HELIX", (2.0, 5.0)),
        ("PLUNGE_ZIGZAG", (8.0, 5.0)),
    ],
)
def test_approaches_go_down_no_steeper_than_they_say(keyword, values):
    part = Features()
    approach = part.add(keyword, None, *values)
    part.mill(part.pocket(part.rectangle(60, 40)), pocket_operation(part, approach=approach))
    path, found = part.read()
    assert codes(found, "error") == []
    heights = removed([path], SIZE, 0.0, GRID, {"T": 4.0})[1]
    check_cut(heights, box(-30, -20, 30, 20), 4.0, 6.0)
    down = [
        k
        for k in motions(path)
        if path.end[k, 2] < path.starts[k, 2] - 1e-9 and path.feed_mode[k] == FeedMode.SPEED
    ]
    slopes = []
    for k in down:
        drop = path.starts[k, 2] - path.end[k, 2]
        if path.kind[k] == Kind.ARC:
            a = path.curve[k]
            begin, end = (complex(*(p[k, :2] - path.arcs.centre[a, :2])) for p in (path.starts, path.end))
            turn = math.copysign(path.arcs.sweep[a], path.arcs.normal[a, 2])
            assert abs(begin * cmath.exp(1j * turn) - end) < 1e-9  # it ends where it has turned to
            length = abs(begin) * path.arcs.sweep[a]
        else:
            length = np.linalg.norm(path.end[k, :2] - path.starts[k, :2])
        slopes.append(math.degrees(math.atan2(drop, length)))
    if keyword == "PLUNGE_TOOLAXIS":
        assert set(slopes) == {90.0}
    else:
        limit = values[0] if keyword != "PLUNGE_HELIX" else values[1]
        entering = [s for s in slopes if s < 89]
        assert entering
        assert max(entering) <= limit + 1e-6


@pytest.mark.parametrize("width", [40.0, 13.0])
def test_without_an_approach_the_tool_goes_down_in_a_helix(width):
    """Of 0.4 diameters, 3.2 mm, radius at 10 degrees, as NIST's interpreter does; smaller where no more fits: 2.5 mm."""
    part = Features()
    part.mill(part.pocket(part.rectangle(60, width)), pocket_operation(part))
    path, found = part.read()
    assert codes(found, "error") == []
    down = next(k for k in motions(path) if path.kind[k] == Kind.ARC and path.end[k, 2] < path.starts[k, 2])
    arc = path.curve[down]
    radius = np.linalg.norm(path.starts[down, :2] - path.arcs.centre[arc, :2])
    assert radius == pytest.approx(min(3.2, (width - 8) / 2), abs=1e-6)
    drop = path.starts[down, 2] - path.end[down, 2]
    assert math.degrees(math.atan2(drop, radius * path.arcs.sweep[arc])) == pytest.approx(10.0)


def test_a_slot_as_wide_as_the_tool_and_a_wider_one():
    for width in (8.0, 14.0):
        part = Features()
        course = part.add("LINEAR_PATH", None, part.size(40), part.direction(1, 0, 0))
        profile = part.add("SQUARE_U_PROFILE", None, part.size(width), None, None, None, None)
        ends = (part.add("RADIUSED_SLOT_END_TYPE"), part.add("OPEN_SLOT_END_TYPE"))
        feature = part.add("SLOT", *part.head(), course, profile, ends)
        part.mill(feature, pocket_operation(part))
        heights, _ = part.heights(4.0)
        points, shape = cells()
        region = box(0, -width / 2, 40, width / 2) | Point(0, 0).buffer(width / 2, 64)
        reach = (
            region.buffer(-4 + 1e-6).buffer(4) | box(0, -width / 2, 40, width / 2) if width == 8 else region
        )
        inside = shapely.contains(reach.buffer(-GRID), points).reshape(shape)
        np.testing.assert_allclose(heights[inside], -6.0)
        beside = ~shapely.contains(box(-40, -width / 2 - GRID, 60, width / 2 + GRID), points).reshape(shape)
        np.testing.assert_array_equal(heights[beside], 0.0)


def flat_slot(part, *points, width=8.0):
    """A slot with flat ends along a polyline, as wide as the tool of 8 mm."""
    course = part.add("GENERAL_PATH", None, part.polyline(*points))
    profile = part.add("SQUARE_U_PROFILE", None, part.size(width), None, None, None, None)
    ends = tuple(part.add("FLAT_SLOT_END_TYPE", part.size(4), part.size(4)) for _ in range(2))
    part.mill(part.add("SLOT", *part.head(), course, profile, ends), pocket_operation(part))
    return part


def test_a_tool_as_wide_as_a_slot_stays_within_its_flat_ends():
    """ISO 14649-10, flat_slot_end_type: the end point of the course lies in the flat end."""
    heights, found = flat_slot(Features(), (0, 0, 0), (40, 0, 0)).heights(4.0)
    assert codes(found) == ["stepnc-uncut"]
    points, shape = cells()
    swept = box(4, -4, 36, 4) | Point(4, 0).buffer(4, 64) | Point(36, 0).buffer(4, 64)
    np.testing.assert_allclose(heights[shapely.contains(swept.buffer(-GRID), points).reshape(shape)], -6.0)
    np.testing.assert_array_equal(heights[~shapely.contains(swept.buffer(GRID), points).reshape(shape)], 0.0)


def test_a_flat_end_behind_a_short_line_is_refused():
    part = flat_slot(Features(), (0, 0, 0), (30, 0, 0), (30, 3, 0))
    assert codes(part.read()[1], "error") == ["stepnc-unsupported"]


def test_an_open_pocket_is_cleared_over_its_open_side():
    part = Features()
    wall = part.add(
        "GENERAL_PROFILE", None, part.polyline((20, -15, 0), (-20, -15, 0), (-20, 15, 0), (20, 15, 0))
    )
    condition = part.add("PLANAR_POCKET_BOTTOM_CONDITION")
    feature = part.add("OPEN_POCKET", *part.head(), (), None, condition, None, None, wall, None)
    part.mill(feature, pocket_operation(part))
    heights, _ = part.heights(4.0)
    points, shape = cells()
    corners = box(-20, -15, 20, 15).buffer(-4).buffer(4) | box(0, -15, 20, 15)
    inside = shapely.contains(corners.buffer(-GRID), points).reshape(shape)
    np.testing.assert_allclose(heights[inside], -6.0)
    behind = shapely.contains(box(-50, -40, -20 - GRID, 40), points).reshape(shape)
    np.testing.assert_array_equal(heights[behind], 0.0)


@pytest.mark.parametrize("kind", ["SIDE_FINISH_MILLING", "SIDE_ROUGH_MILLING"])
def test_an_outside_profile_is_gone_round(kind):
    part = Features()
    feature = part.add(
        "GENERAL_OUTSIDE_PROFILE",
        *part.head(),
        None,
        part.polygon((-20, -10), (20, -10), (20, 10), (-20, 10)),
    )
    part.mill(feature, part.operation(kind, 3.0, 2.0, 1.0 if "ROUGH" in kind else None))
    heights, _ = part.heights(4.0)
    left = 1.0 if "ROUGH" in kind else 0.0
    points, shape = cells()
    part_region = box(-20, -10, 20, 10).buffer(left, join_style="mitre")
    wall = box(-20, -10, 20, 10).buffer(left, quad_segs=64)
    ring = shapely.contains(wall.buffer(7.5).difference(part_region.buffer(GRID)), points).reshape(shape)
    np.testing.assert_allclose(heights[ring & (heights < 0)], -6.0)
    kept = shapely.contains(wall.buffer(-GRID), points).reshape(shape)
    np.testing.assert_array_equal(heights[kept], 0.0)
    around = shapely.contains((wall.buffer(7.0) - wall.buffer(GRID)), points).reshape(shape)
    np.testing.assert_allclose(heights[around], -6.0)


def test_the_wall_inside_a_hole():
    part = Features()
    hole = part.add("ROUND_HOLE", *part.head(), part.size(40), None, part.add("THROUGH_BOTTOM_CONDITION"))
    part.mill(hole, part.operation("SIDE_FINISH_MILLING", 3.0, 2.0, None))
    path, found = part.read()
    assert codes(found) == []
    arcs = path.arcs.centre[path.arcs.sweep > 6]
    np.testing.assert_allclose(arcs[:, :2], np.tile(ORIGIN[:2], (len(arcs), 1)), atol=1e-3)


def test_a_face_one_way_lifts_between_its_lines():
    part = Features()
    course = part.add("LINEAR_PATH", None, part.size(40), part.direction(0, 1, 0))
    width = part.add("LINEAR_PROFILE", None, part.add("NUMERIC_PARAMETER", "w", 30.0, "MM"))
    face = part.add("PLANAR_FACE", *part.head(4.0), course, width, None, ())
    one_way = part.add("UNIDIRECTIONAL_MILLING", 0.25, E("T"), part.direction(0, 1, 0), None)
    part.mill(face, part.operation("PLANE_ROUGH_MILLING", 2.0, 1.0, strategy=one_way))
    heights, _ = part.heights(4.0)
    points, shape = cells()
    inside = shapely.contains(box(0, 0, 30, 40).buffer(-GRID), points).reshape(shape)
    np.testing.assert_allclose(heights[inside], -3.0)  # 4 deep less the allowance of 1
    path, _ = part.read()
    feeds = [
        k
        for k in motions(path)
        if path.feed_mode[k] == FeedMode.SPEED and abs(path.end[k, 1] - path.starts[k, 1]) > 1
    ]
    assert (path.end[feeds, 1] > path.starts[feeds, 1]).all()


@pytest.mark.parametrize("turn", ["profile", "course"])
def test_the_profile_of_a_face_lies_along_the_x_of_its_own_placement(turn):
    """A course along X with a profile turned onto Y is the face that a course along Y with a profile along X is: 30 by 40 mm."""
    part = Features()
    course = (1, 0, 0) if turn == "profile" else (0, 1, 0)
    long, wide = (30.0, 40.0) if turn == "profile" else (40.0, 30.0)
    place = part.placement((0, 0, 0), (0, 0, 1), (0, 1, 0)) if turn == "profile" else None
    travel = part.add("LINEAR_PATH", None, part.size(long), part.direction(*course))
    width = part.add("LINEAR_PROFILE", place, part.add("NUMERIC_PARAMETER", "w", wide, "MM"))
    face = part.add("PLANAR_FACE", *part.head(4.0), travel, width, None, ())
    part.mill(face, part.operation("PLANE_ROUGH_MILLING", 2.0, 1.0))
    heights, found = part.heights(4.0)
    points, shape = cells()
    inside = shapely.contains(box(0, 0, 30, 40).buffer(-GRID), points).reshape(shape)
    assert codes(found, "error") == []
    np.testing.assert_allclose(heights[inside], -3.0)


def test_a_face_whose_profile_lies_along_its_course_has_no_area():
    part = Features()
    travel = part.add("LINEAR_PATH", None, part.size(40.0), part.direction(1, 0, 0))
    width = part.add("LINEAR_PROFILE", None, part.add("NUMERIC_PARAMETER", "w", 30.0, "MM"))
    face = part.add("PLANAR_FACE", *part.head(4.0), travel, width, None, ())
    path, found = part.mill(face, part.operation("PLANE_ROUGH_MILLING", 2.0, 1.0)).read()
    assert codes(found, "error") == ["stepnc-geometry"]
    assert not len(motions(path))


@pytest.mark.parametrize(
    ("cutmode", "spindle", "sense"),
    [
        (None, -50.0, -1),
        ("CONVENTIONAL", -50.0, -1),
        ("CLIMB", -50.0, 1),
        ("CONVENTIONAL", 50.0, 1),
        ("CLIMB", 50.0, -1),
    ],
)
def test_one_way_the_cutmode_says_on_which_side_the_next_line_is(cutmode, spindle, sense):
    """Feed along Y: conventional, what is uncut is on the left (-X) of a tool that turns with the clock; there edges meet it
    going with the feed."""
    part = Features()
    course = part.add("LINEAR_PATH", None, part.size(40), part.direction(0, 1, 0))
    width = part.add("LINEAR_PROFILE", None, part.add("NUMERIC_PARAMETER", "w", 30.0, "MM"))
    face = part.add("PLANAR_FACE", *part.head(4.0), course, width, None, ())
    mode = None if cutmode is None else E(cutmode)
    one_way = part.add("UNIDIRECTIONAL_MILLING", 0.25, E("T"), part.direction(0, 1, 0), mode)
    head = (None, None, "op", 5.0, None, part.tool("T", 8.0), part.technology(spindle=spindle), None)
    part.mill(face, part.add("PLANE_ROUGH_MILLING", *head, None, None, None, one_way, 5.0, 0.0))
    path, found = part.read()
    assert codes(found, "error") == []
    fed = [k for k in motions(path) if path.feed_mode[k] == FeedMode.SPEED]
    rows = [k for k in fed if path.end[k, 1] - path.starts[k, 1] > 10]
    assert len(rows) > 3
    assert (np.sign(np.diff(path.end[rows, 0])) == sense).all()


# What is refused


@pytest.mark.parametrize(
    "make",
    [
        lambda p: p.mill(p.pocket(p.rectangle(60, 40), slope=-5.0), pocket_operation(p)),
        lambda p: p.mill(p.pocket(p.rectangle(60, 40), slope=85.0), pocket_operation(p)),
        lambda p: p.mill(p.pocket(p.rectangle(6, 4)), pocket_operation(p)),
        lambda p: p.mill(p.pocket(p.rectangle(60, 40), depth=-3.0), pocket_operation(p)),
        lambda p: p.mill(p.pocket(p.add("CIRCLE", "", p.placement(), 5.0)), pocket_operation(p)),
        lambda p: p.mill(p.add("STEP", *p.head(), p.add("LINEAR_PATH", None, p.size(9), None), None, ()), pocket_operation(p)),
        lambda p: p.mill(p.pocket(p.rectangle(60, 40)), p.operation("SIDE_ROUGH_MILLING", 1.0, None, 20.0)),
        lambda p: p.mill(p.add("ROUND_HOLE", *p.head(), p.size(40), None, p.add("SPHERICAL_HOLE_BOTTOM", p.size(9))), pocket_operation(p)),
        lambda p: p.mill(p.slot(p.add("ROUNDED_U_PROFILE", None, p.size(14))), pocket_operation(p)),
        lambda p: p.mill(p.slot(p.add("SQUARE_U_PROFILE", None, p.size(14), None, 20.0, None, 10.0)), pocket_operation(p)),
        lambda p: p.mill(p.step_feature(p.block((0, 0, -9), (49, 80, 0))), pocket_operation(p)),
        lambda p: p.mill(p.pocket(p.rectangle(60, 40)), pocket_operation(p, diameter=None)),
        lambda p: p.mill(p.add("THREAD", *p.head(), *(None,) * 11), pocket_operation(p)),
    ],
)  # fmt: skip
def test_what_cannot_be_made_is_an_error(make):
    part = Features()
    _, found = make(part).read()
    assert codes(found, "error")


def test_corners_too_sharp_for_the_tool_are_warned_of():
    part = Features()
    part.mill(part.pocket(part.rectangle(60, 40), corner=2.0), pocket_operation(part))
    assert "stepnc-corner" in codes(part.read()[1], "warning")


def test_a_profile_stands_where_its_own_placement_says():
    """60 by 30 mm turned by a quarter about its middle and moved by (5, -3): 30 along X, 60 along Y."""
    part = Features()
    place = part.placement((5, -3, 0), (0, 0, 1), (0, 1, 0))
    profile = part.add("RECTANGULAR_CLOSED_PROFILE", place, part.size(30), part.size(60))
    part.mill(part.pocket(profile), pocket_operation(part))
    heights, found = part.heights(4.0)
    assert codes(found) == []
    check_cut(heights, box(-10, -33, 20, 27), 4.0, 6.0)


def face(width, unit):
    """Return the extent across of facing a width in a unit, mm, and the diagnostics; the lines go along Y."""
    part = Features()
    course = part.add("LINEAR_PATH", None, part.size(40), part.direction(0, 1, 0))
    profile = part.add("LINEAR_PROFILE", None, part.add("NUMERIC_PARAMETER", "w", float(width), unit))
    feature = part.add("PLANAR_FACE", *part.head(2.0), course, profile, None, ())
    path, found = part.mill(feature, part.operation("PLANE_FINISH_MILLING", 2.0, None)).read()
    cut = path.end[motions(path)]
    return np.ptp(cut[np.isclose(cut[:, 2], -2.0), 0]) if codes(found, "error") == [] else None, codes(found)


@pytest.mark.parametrize(
    ("width", "unit"), [(60, "MM"), (60, ""), (6, "cm"), (0.06, "M"), (60 / 25.4, "INCH"), (60 / 25.4, "in")]
)
def test_numeric_parameters_have_their_unit(width, unit):
    """60 mm wide: from the first line to the last the tool of 8 mm goes no less than to where nothing is left."""
    extent, found = face(width, unit)
    assert found == []
    assert 60 - 8 <= extent + 1e-6 < 60 + 8
    assert extent == pytest.approx(face(60, "MM")[0])
    assert face(1, "cubit")[1] == ["stepnc-unit"]


def test_an_outline_that_is_left_open_is_closed_by_a_line():
    part = Features()
    outline = part.add(
        "GENERAL_CLOSED_PROFILE", None, part.polyline((-30, -20, 0), (30, -20, 0), (30, 20, 0))
    )
    part.mill(part.pocket(outline), pocket_operation(part))
    heights, found = part.heights(4.0)
    assert codes(found, "error") == []
    check_cut(heights, Polygon([(-30, -20), (30, -20), (30, 20)]), 4.0, 6.0)


@pytest.mark.parametrize("turned", [False, True])
def test_an_open_pocket_whose_open_side_is_a_curve_of_its_own(turned):
    """The wall along X at Y -15, 40 long; the open side goes round by (20, 15) and (-20, 15), either way."""
    part = Features()
    place = part.placement((-20, -15, 0))
    wall = part.add("LINEAR_PROFILE", place, part.add("NUMERIC_PARAMETER", "l", 40.0, "MM"))
    open_side = [(20, -15, 0), (20, 15, 0), (-20, 15, 0), (-20, -15, 0)]
    boundary = part.add("GENERAL_PROFILE", None, part.polyline(*(open_side[::-1] if turned else open_side)))
    condition = part.add("PLANAR_POCKET_BOTTOM_CONDITION")
    feature = part.add("OPEN_POCKET", *part.head(), (), None, condition, None, None, boundary, wall)
    part.mill(feature, pocket_operation(part))
    heights, found = part.heights(4.0)
    assert codes(found, "error") == []
    points, shape = cells()
    inside = shapely.contains(box(-20, -15, 20, 15).buffer(-GRID), points).reshape(shape)
    np.testing.assert_allclose(heights[inside], -6.0)
    behind = shapely.contains(box(-50, -40, 50, -15 - GRID), points).reshape(shape)
    np.testing.assert_array_equal(heights[behind], 0.0)


def test_an_open_side_that_does_not_meet_the_wall_is_refused():
    part = Features()
    wall = part.add("LINEAR_PROFILE", None, part.add("NUMERIC_PARAMETER", "l", 40.0, "MM"))
    boundary = part.add("GENERAL_PROFILE", None, part.polyline((41, 0, 0), (40, 20, 0), (0, 0, 0)))
    condition = part.add("PLANAR_POCKET_BOTTOM_CONDITION")
    feature = part.add("OPEN_POCKET", *part.head(), (), None, condition, None, None, boundary, wall)
    part.mill(feature, pocket_operation(part))
    assert codes(part.read()[1], "error") == ["stepnc-geometry"]


def test_an_outside_profile_is_as_deep_as_its_profile_is_swept():
    """Without a depth plane: 4 mm along Z."""
    part = Features()
    sweep = part.add("LINEAR_PATH", None, part.size(4), part.direction(0, 0, -1))
    outline = part.polygon((-20, -10), (20, -10), (20, 10), (-20, 10))
    feature = part.add("GENERAL_OUTSIDE_PROFILE", *part.head(None), sweep, outline)
    path, found = part.mill(feature, part.operation("SIDE_FINISH_MILLING", 6.0, 2.0, None)).read()
    assert codes(found, "error") == []
    assert path.end[motions(path), 2].min() == pytest.approx(-4.0)


def test_a_placement_that_repeats_the_feature_is_taken_as_none():
    """As in files of one adapter: the profile's placement is the feature's again."""
    part = Features()
    place = part.placement(ORIGIN)
    profile = part.add("RECTANGULAR_CLOSED_PROFILE", place, part.size(40), part.size(60))
    part.mill(part.pocket(profile), pocket_operation(part))
    heights, found = part.heights(4.0)
    assert "stepnc-placement" in codes(found, "warning")
    check_cut(heights, box(-30, -20, 30, 20), 4.0, 6.0)


def test_leads_onto_a_contour_by_an_arc_and_by_an_angle():
    """An arc of 3 mm, tangent to the wall; off it in a line of 4 mm at 30 degrees."""
    part = Features()
    outline = part.polygon((-20, -10), (20, -10), (20, 10), (-20, 10))
    feature = part.add("GENERAL_OUTSIDE_PROFILE", *part.head(), None, outline)
    operation = part.operation(
        "SIDE_FINISH_MILLING", 6.0, 2.0, None, approach=part.add("AP_RETRACT_TANGENT", None, 3.0)
    )
    values = list(part.instances[operation - 1].parts[0].parameters)
    values[10] = part.add("AP_RETRACT_ANGLE", None, 30.0, 4.0)
    part.fill(operation, "SIDE_FINISH_MILLING", *values)
    path, found = part.mill(feature, operation).read()
    assert codes(found) == []
    rows = motions(path)
    first = next(k for k in rows if path.kind[k] == Kind.ARC)
    assert np.linalg.norm(path.starts[first, :2] - path.arcs.centre[0, :2]) == pytest.approx(3.0)
    last = rows[-2]  # before the way up
    leave = path.end[last, :2] - path.starts[last, :2]
    assert np.linalg.norm(leave) == pytest.approx(4.0)
    before = path.end[rows[-3], :2] - path.starts[rows[-3], :2]
    cosine = leave @ before / np.linalg.norm(leave) / np.linalg.norm(before)
    # The contour begins within the first chord of a corner, 0.35 degrees from its line.
    assert math.degrees(math.acos(cosine)) == pytest.approx(30.0, abs=0.4)


@pytest.mark.parametrize("distance", [-4.0, -7.3, 2.5])
def test_offsets_go_back_to_the_lines_and_arcs_that_they_are(distance):
    """A rectangle with corners of 5 mm, shrunk or grown: four lines, four quarter circles of the radius left."""
    from cncgen.stepnc.features import offsets
    from cncgen.stepnc.geometry.chords import polyline_of
    from cncgen.stepnc.geometry.pieces import Arc

    outline = box(-20, -10, 20, 10).buffer(-5).buffer(5, quad_segs=800)  # as fine as outlines are
    (region,) = offsets.region(outline, [], distance)
    (curve,) = offsets.boundary_curves(region, clockwise=True)
    arcs = [p for p in curve if isinstance(p, Arc)]
    assert len(arcs) == 4
    for arc in arcs:
        assert np.linalg.norm(arc.start - arc.centre) == pytest.approx(5 - distance, abs=2e-4)
        np.testing.assert_allclose(np.abs(arc.centre[:2]), [15, 5], atol=2e-3)
    points = np.concatenate([polyline_of(p, 1e-5).points for p in curve])
    exact = box(-15, -5, 15, 5).buffer(5 - distance, quad_segs=2000).exterior
    assert max(exact.distance(Point(x, y)) for x, y, _ in points[::7]) < 4e-4
    for one, other in zip(curve, curve[1:] + curve[:1], strict=True):
        np.testing.assert_allclose(one.end, other.start, atol=1e-12)


def inside(region):
    """The cells of the block within a region about `ORIGIN`, one cell from its edge."""
    points, shape = cells()
    return shapely.contains(region.buffer(-GRID), points).reshape(shape)


@pytest.mark.parametrize("strategy", ["CONTOUR_PARALLEL", "CONTOUR_SPIRAL", "BIDIRECTIONAL_MILLING"])
def test_sloped_walls_are_cut_in_steps_outside_of_them(strategy):
    """Walls at 30 degrees: at depth z they stand z tan 30 inside their outline, and no step of 1 mm goes into them."""
    part = Features()
    operation = pocket_operation(part, strategy)
    values = list(part.instances[operation - 1].parts[0].parameters)
    values[12] = 1.0
    part.fill(operation, "BOTTOM_AND_SIDE_FINISH_MILLING", *values)
    part.mill(part.pocket(part.rectangle(60, 40), slope=30.0), operation)
    heights, found = part.heights(4.0)
    assert codes(found) == ["stepnc-uncut"]
    x, row = tops(heights)
    wall = -np.clip((30 - np.abs(x)) / math.tan(math.radians(30)), 0, 6)  # the exact wall
    reached = GRID / math.tan(math.radians(30))  # a cell of the grid, down the wall
    assert (row >= wall - reached).all()
    assert (row <= wall + 1.0 + reached).all()
    np.testing.assert_allclose(
        heights[inside(box(-30, -20, 30, 20).buffer(-6 * math.tan(math.radians(30)) - 2))], -6
    )


@pytest.mark.parametrize("edge", [0.0, 1.5, 4.0])
def test_a_rounded_tool_touches_a_sloped_wall_and_no_more(edge):
    """The distance from the axis to the wall's line at every height of the cutter's edge is at least its radius there."""
    from cncgen.stepnc.features.job import Job
    from cncgen.stepnc.features.walls import axis_distance
    from cncgen.stepnc.model import CuttingTool, Operation, Shape

    tool = CuttingTool(1, "T", diameter=8.0, edge_radius=edge)
    job = Job(1, Operation(1, "", "side finish", None, tool=tool), Shape(), None)
    for slope in (0.0, 0.1, 0.7):
        axis = axis_distance(job, slope, 5.0)
        height = np.linspace(0, 10, 4001)
        reach = 4.0 - edge + np.sqrt(np.clip(edge**2 - np.clip(edge - height, 0, None) ** 2, 0, None))
        left = axis - reach - (5.0 - height) * math.tan(slope)  # from the cutter to the wall
        assert left.min() == pytest.approx(0.0, abs=1e-5)


def test_a_boss_lower_than_the_pocket_is_faced_and_its_draft_stands():
    """A boss of 10 mm square, 2.5 below the top, its walls at 20 degrees; the pocket is 6 deep."""
    part = Features()
    square = part.polygon((-5, -5), (5, -5), (5, 5), (-5, 5))
    feature = part.pocket(part.rectangle(70, 60), (part.boss(square, slope=20.0, top=-2.5),))
    part.mill(feature, pocket_operation(part))
    heights, found = part.heights(4.0)
    assert codes(found) == []
    np.testing.assert_allclose(heights[inside(box(-5, -5, 5, 5))], -2.5)
    draft = 3.5 * math.tan(math.radians(20))
    np.testing.assert_allclose(
        heights[inside(box(-20, -20, 20, 20) - box(-5, -5, 5, 5).buffer(draft + 2))], -6
    )
    x, row = tops(heights)
    foot = np.abs(x) < 5 + draft - GRID
    assert (row[foot] > -6).all()


def planar_face(part, bosses=()):
    course = part.add("LINEAR_PATH", None, part.size(40), part.direction(0, 1, 0))
    width = part.add("LINEAR_PROFILE", None, part.add("NUMERIC_PARAMETER", "w", 40.0, "MM"))
    return part.add("PLANAR_FACE", *part.head(2.0), course, width, None, bosses)


@pytest.mark.parametrize(
    ("strategy", "values"),
    [
        ("BIDIRECTIONAL_MILLING", (0.4, E("T"), None, E("LEFT"), None)),
        ("CONTOUR_PARALLEL", (0.4, E("T"), E("CCW"), E("CLIMB"))),
    ],
)
def test_a_face_with_a_boss(strategy, values):
    part = Features()
    square = part.polygon((10, 12), (25, 12), (25, 28), (10, 28))
    plan = part.add(strategy, *values)
    part.mill(
        planar_face(part, (part.boss(square),)),
        part.operation("PLANE_FINISH_MILLING", 2.0, None, strategy=plan),
    )
    heights, found = part.heights(4.0)
    assert codes(found) == []
    np.testing.assert_array_equal(heights[inside(box(10, 12, 25, 28))], 0.0)
    np.testing.assert_allclose(heights[inside(box(0, 0, 40, 40) - box(10, 12, 25, 28).buffer(GRID))], -2.0)


@pytest.mark.parametrize(
    ("tilt", "opening", "along", "region"),
    [
        (0.0, 90.0, (0, 1, 0), box(0, 0, 20, 30)),
        (90.0, 90.0, (0, 1, 0), box(-30, 0, 0, 30)),
        (None, None, (0, 1, 0), box(0, 0, 20, 30)),
        (None, None, (0, -1, 0), box(0, -30, 20, 0)),
        (None, None, (1, 0, 0), box(0, -35, 30, 0)),
    ],
)
@pytest.mark.parametrize("kind", ["BOTTOM_AND_SIDE_FINISH_MILLING", "PLANE_FINISH_MILLING"])
def test_a_step_reaches_to_the_end_of_the_raw_piece(tilt, opening, along, region, kind):
    """The raw piece goes from (-30, -35) to (20, 30) about the step; what is removed lies between the profile's arms."""
    part = Features()
    wall = None if tilt is None else part.add("VEE_PROFILE", None, None, opening, tilt)
    feature = part.step_feature(part.block((20, 5, -20), (70, 70, 0)), wall=wall, along=along)
    own = (3.0, 4.0, None, None) if kind.startswith("BOTTOM") else (3.0, None)
    part.mill(feature, part.operation(kind, *own))
    heights, found = part.heights(4.0)
    assert codes(found) == []
    cleared = region.buffer(-4).buffer(4, quad_segs=64)
    np.testing.assert_allclose(heights[inside(cleared)], -6.0)
    rest = box(-30, -35, 20, 30) - region.buffer(GRID)
    np.testing.assert_array_equal(heights[inside(rest)], 0.0)
    # The sides at the end of the raw piece are cut without rounded corners.
    points, shape = cells()
    at_edges = shapely.contains(region.buffer(-GRID) - region.buffer(-3), points).reshape(shape)
    assert (heights[at_edges] == -6.0).mean() > 0.9


@pytest.mark.parametrize("kind", ["GENERAL_OUTSIDE_PROFILE", "CIRCULAR_CLOSED_SHAPE_PROFILE", "BOSS"])
def test_roughing_round_a_profile_clears_the_raw_piece(kind):
    part = Features()
    workpiece = part.block((20, 10, -20), (80, 70, 0))
    name, _, operations, place, depth = part.head()
    head = (name, workpiece, operations, place, depth)
    circle = part.add("CIRCULAR_CLOSED_PROFILE", None, part.size(20))
    own = {
        "GENERAL_OUTSIDE_PROFILE": (None, circle),
        "CIRCULAR_CLOSED_SHAPE_PROFILE": (None, None, None, circle),
        "BOSS": (circle, None),
    }[kind]
    part.mill(
        part.add(kind, *head, *own), part.operation("BOTTOM_AND_SIDE_ROUGH_MILLING", 3.0, 4.0, 1.0, 0.5)
    )
    heights, found = part.heights(4.0)
    assert codes(found) == []
    kept = Point(0, 0).buffer(11, 64)
    np.testing.assert_array_equal(heights[inside(kept)], 0.0)
    np.testing.assert_allclose(heights[inside(box(-30, -30, 30, 30) - kept.buffer(GRID))], -5.5)


def test_a_round_raw_piece_is_cleared_round_a_profile():
    """A cylinder of 30 mm about the part's axis; one that lies across it tells nothing, and is remarked on."""
    for axis, said in (((0, 0, 1), []), ((0, 1, 0), ["stepnc-stock"])):
        part = Features()
        base = part.add("AXIS1_PLACEMENT", "", part.point(ORIGIN[0], ORIGIN[1], -20), part.direction(*axis))
        solid = part.add("RIGHT_CIRCULAR_CYLINDER", "", base, 20.0, 30.0)
        raw = part.add("WORKPIECE", "raw", None, None, None, None, solid, ())
        workpiece = part.add("WORKPIECE", "part", None, None, raw, None, None, ())
        name, _, operations, place, depth = part.head()
        circle = part.add("CIRCULAR_CLOSED_PROFILE", None, part.size(20))
        feature = part.add("GENERAL_OUTSIDE_PROFILE", name, workpiece, operations, place, depth, None, circle)
        part.mill(feature, part.operation("BOTTOM_AND_SIDE_ROUGH_MILLING", 3.0, 4.0, 1.0, 0.5))
        heights, found = part.heights(4.0)
        assert codes(found) == said
        kept = Point(0, 0).buffer(11, 64)
        np.testing.assert_array_equal(heights[inside(kept)], 0.0)
        cleared = heights[inside(Point(0, 0).buffer(30 - GRID, 64) - kept.buffer(GRID))]
        if said:
            assert (cleared == 0.0).mean() > 0.3  # one pass round the profile alone
        else:
            np.testing.assert_allclose(cleared, -5.5)


def test_layers_of_side_roughing_begin_at_the_farthest_corner_of_the_raw_piece():
    """A circle of 10 mm in a square of 60: its corner is 30 sqrt 2 - 10 = 32.43 mm away: five layers of 7 mm."""
    part = Features()
    name, _, operations, place, depth = part.head()
    circle = part.add("CIRCULAR_CLOSED_PROFILE", None, part.size(20))
    feature = part.add(
        "GENERAL_OUTSIDE_PROFILE",
        name,
        part.block((20, 10, -20), (80, 70, 0)),
        operations,
        place,
        depth,
        None,
        circle,
    )
    plan = part.add("CONTOUR_PARALLEL", None, E("T"), None, E("CLIMB"))
    part.mill(feature, part.operation("SIDE_ROUGH_MILLING", 6.0, 7.0, None, strategy=plan))
    path, found = part.read()
    assert codes(found) == []
    arcs = [k for k in motions(path) if path.kind[k] == Kind.ARC]
    round_it = [k for k in arcs if np.abs(path.arcs.centre[path.curve[k], :2] - ORIGIN[:2]).max() < 1e-3]
    radius = [np.linalg.norm(path.starts[k, :2] - path.arcs.centre[path.curve[k], :2]) for k in round_it]
    radius = list(dict.fromkeys(np.round(radius, 3)))
    np.testing.assert_allclose(radius, [42, 35, 28, 21, 14], atol=1e-3)


def test_no_slot_is_wider_than_its_arc_lets_it_be():
    """A quarter of a ring: its area is (R² − r²) π/4; wider than its radius allows it is nothing in one piece."""
    turn = np.linspace(0.0, 0.5 * np.pi, 200)
    arc = [Polyline(30.0 * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(200)]))]
    (outline,) = strip(arc, 5.0, ())
    assert polygon_of(outline).area == pytest.approx((35.0**2 - 25.0**2) * np.pi / 4.0, rel=1e-3)
    assert strip(arc, 180.0, ()) == []


@pytest.mark.parametrize(("width", "kind"), [(8.0, "BOTTOM"), (12.0, "BOTTOM"), (12.0, "SIDE")])
def test_a_slot_in_a_loop_leaves_its_middle(width, kind):
    part = Features()
    course = part.add("COMPLETE_CIRCULAR_PATH", None, part.size(20))
    profile = part.add("SQUARE_U_PROFILE", None, part.size(width), None, None, None, None)
    feature = part.slot(profile, course, ("LOOP_SLOT_END_TYPE", "LOOP_SLOT_END_TYPE"))
    operation = (
        pocket_operation(part) if kind == "BOTTOM" else part.operation("SIDE_FINISH_MILLING", 3.0, None, None)
    )
    part.mill(feature, operation)
    heights, found = part.heights(4.0)
    assert codes(found, "error") == []
    ring = Point(0, 0).buffer(20 + width / 2, 64) - Point(0, 0).buffer(20 - width / 2, 64)
    if kind == "BOTTOM":
        np.testing.assert_allclose(heights[inside(ring)], -6.0)
    np.testing.assert_array_equal(heights[inside(Point(0, 0).buffer(20 - width / 2, 64))], 0.0)


def test_the_walls_of_an_open_pocket_and_of_a_slot():
    part = Features()
    wall = part.add(
        "GENERAL_PROFILE", None, part.polyline((20, -15, 0), (-20, -15, 0), (-20, 15, 0), (20, 15, 0))
    )
    condition = part.add("PLANAR_POCKET_BOTTOM_CONDITION")
    feature = part.add("OPEN_POCKET", *part.head(), (), None, condition, None, None, wall, None)
    part.mill(feature, part.operation("SIDE_FINISH_MILLING", 3.0, 2.0, None))
    heights, found = part.heights(4.0)
    assert codes(found) == []
    pocket = box(-20, -15, 30, 15)
    along = (pocket - pocket.buffer(-7)) & box(-15, -15, 20, 15)
    np.testing.assert_allclose(heights[inside(along)], -6.0)
    np.testing.assert_array_equal(
        heights[inside(box(-40, -30, 20, 30) - box(-20, -15, 20, 15).buffer(GRID))], 0.0
    )


# Tapered holes


def test_the_sample_program_of_features():
    """The plate of programs/stepnc/features.stp, by heights: floors, the boss, the plate's top between them."""
    program = read(Path(__file__).parents[2] / "programs" / "stepnc" / "features.stp", "features.stp")
    path = next(iter(program.chunks()))
    assert [d.code for d in program.diagnostics] == []
    radius = {"END MILL 10": 5.0, "BULL NOSE 8 R1": 4.0, "DRILL 5": 2.5, "COUNTERSINK 12": 6.0}
    heights = removed([path], (120.0, 80.0), 0.0, GRID, radius)[1]

    def at(x, y):
        return heights[int(x / GRID), int(y / GRID)]

    assert at(110, 60) == -8.0  # the step, between two holes
    assert at(102, 40) == 0.0  # beside its wall
    assert at(30, 14) == -4.0  # the slot
    assert at(72, 25) == at(90, 25) == at(72, 65) == -5.0  # both arms of the corner pocket
    assert at(90, 60) == 0.0
    assert at(35, 50) == -3.8  # the boss, with the allowance of roughing: its walls alone are finished
    assert at(20, 50) == -9.8
    assert at(13, 50) == -10.0  # along the walls, which lean by 0.87 mm
    assert at(10.4, 50) > -9.5
    assert at(112, 10) < -25.0  # a hole


@pytest.mark.parametrize(
    ("attribute", "value"), [("retract_plane", 1e308), ("allowance_side", 1e308), ("overcut_length", -1e300)]
)
def test_sizes_of_no_part_are_refused(attribute, value):
    """Found by fuzzing: infinite sums must end in a diagnostic."""
    from cncgen.stepnc.schema.tables import positions

    part = Features()
    operation = pocket_operation(part)
    keyword = "BOTTOM_AND_SIDE_FINISH_MILLING"
    values = list(part.instances[operation - 1].parts[0].parameters)
    values[positions(keyword, True)[attribute]] = value
    part.fill(operation, keyword, *values)
    wall = part.add(
        "GENERAL_PROFILE", None, part.polyline((20, -15, 0), (-20, -15, 0), (-20, 15, 0), (20, 15, 0))
    )
    condition = part.add("PLANAR_POCKET_BOTTOM_CONDITION")
    feature = part.add("OPEN_POCKET", *part.head(), (), None, condition, None, None, wall, None)
    assert codes(part.mill(feature, operation).read()[1], "error")


def test_an_outline_of_no_part_is_refused():
    part = Features()
    part.mill(part.pocket(part.rectangle(1e200, 40)), pocket_operation(part))
    assert codes(part.read()[1], "error")


def formed_slot(profile, tool, depth=5.0, operation="BOTTOM_AND_SIDE_FINISH_MILLING"):
    """A slot of 40 mm along X whose section the tool has: `tool` are diameter, tip angle and edge radius."""
    part = Features()
    course = part.add("LINEAR_PATH", None, part.size(40), part.direction(1, 0, 0))
    ends = tuple(part.add("OPEN_SLOT_END_TYPE") for _ in range(2))
    slot = part.add("SLOT", *part.head(depth), course, part.add(*profile(part)), ends)
    made = part.operation(operation, 2.0, None, None, None)
    diameter, tip, edge = tool
    cutter = part.tool("T", diameter, tip=tip, edge=edge)
    values = list(part.instances[made - 1].parts[0].parameters)
    values[5] = cutter
    part.fill(made, operation, *values)
    return part.mill(slot, made).read()


@pytest.mark.parametrize(
    ("profile", "tool", "depth"),
    [
        (lambda p: ("VEE_PROFILE", None, p.size(0), 90.0, 45.0), (12.0, 45.0, None), 5.0),
        (lambda p: ("VEE_PROFILE", None, p.size(0.5), 60.0, 60.0), (12.0, 60.0, 0.5), 5.0),
        (lambda p: ("PARTIAL_CIRCULAR_PROFILE", None, p.size(5), 180.0), (10.0, None, 5.0), 5.0),
        (lambda p: ("PARTIAL_CIRCULAR_PROFILE", None, p.size(8), 120.0), (16.0, None, 8.0), 4.0),
    ],
)
def test_a_slot_whose_section_is_the_tools_is_cut_along_its_middle(profile, tool, depth):
    path, found = formed_slot(profile, tool, depth)
    assert codes(found) == []
    cut = path.end[motions(path)]
    assert cut[:, 2].min() == pytest.approx(-depth)
    cut = cut[cut[:, 2] < 0]
    np.testing.assert_allclose(cut[:, 1], ORIGIN[1])
    assert cut[:, 0].min() <= ORIGIN[0] - tool[0] / 2
    assert cut[:, 0].max() >= ORIGIN[0] + 40 + tool[0] / 2


@pytest.mark.parametrize(
    ("profile", "tool"),
    [
        (
            lambda p: ("VEE_PROFILE", None, p.size(0), 90.0, 45.0),
            (12.0, 30.0, None),
        ),  # a point of 120 degrees
        (lambda p: ("VEE_PROFILE", None, p.size(0), 90.0, 45.0), (12.0, None, None)),  # a flat end
        (lambda p: ("VEE_PROFILE", None, p.size(0), 90.0, 45.0), (8.0, 45.0, None)),  # 10 mm wide at the top
        (lambda p: ("VEE_PROFILE", None, p.size(0), 90.0, 20.0), (12.0, 45.0, None)),  # it leans
        (lambda p: ("PARTIAL_CIRCULAR_PROFILE", None, p.size(5), 180.0), (8.0, None, 4.0)),
        (lambda p: ("PARTIAL_CIRCULAR_PROFILE", None, p.size(5), 200.0), (10.0, None, 5.0)),
        (lambda p: ("TEE_PROFILE", None, *(None,) * 8), (10.0, None, 5.0)),
    ],
)
def test_a_slot_whose_section_is_another_is_refused(profile, tool):
    assert codes(formed_slot(profile, tool)[1], "error") in (["stepnc-unsupported"], ["stepnc-geometry"])
