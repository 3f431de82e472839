"""Features of the AIM: placed as ISO 10303 or ISO 14649 has them, with all their parts."""

import math
from pathlib import Path

import numpy as np
import pytest

from cncgen.stepnc import read
from cncgen.toolpath.record import FeedMode, Kind
from tests.stepnc.aim import Aim, E, Shaped
from tests.stepnc.building import codes, motions
from tests.stepnc.heightfield import removed


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


def test_a_slot_with_leaning_walls():
    """12 mm wide at its floor, 5 deep, walls at 30 degrees: the axis of the tool of 8 mm goes 2 mm beside the middle at the floor."""
    aim = Shaped()
    angles = [("first angle", 30.0), ("second angle", 30.0)]
    path, found = aim.mill(
        "SLOT",
        swept_place(aim, "bottom", 5.0, 40.0),
        [
            ("course of travel", "PATH_FEATURE_COMPONENT", [("distance", 40.0)]),
            ("swept shape", "SQUARE_U_PROFILE", [("width", 12.0), ("depth", 5.0), *angles]),
        ],
    )
    assert codes(found, "error") == []
    cut = path.end[motions(path)]
    assert np.ptp(cut[cut[:, 2] == -5.0][:, 0]) == pytest.approx(4.0, abs=2e-3)
    # In one pass, steps of 5 mm times tan 30 degrees stay on the walls.
    assert codes(found, "warning").count("stepnc-uncut") == 1


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


# As the mapping tables of ISO 10303-238 (5.1.4) have them


def drilled(aim, feature):
    """Drill a feature; return the places that were drilled, and the faults."""
    step, _ = aim.machine(feature, "DRILLING_OPERATION", "drilling", "twist drill")
    path, found = aim.read(aim.plan(step))
    low = path.end[motions(path)].reshape(-1, 3)
    return np.unique(np.round(low[low[:, 2] == low[:, 2].min(initial=0)], 6), axis=0), codes(found, "error")


def hole_of(aim, *place, end="start"):
    """A blind hole of 8 mm, 6 deep: its placement at the bottom, or at the top with Z into the material."""
    z = (0, 0, 1) if end == "start" else (0, 0, -1)
    return aim.feature(
        "ROUND_HOLE",
        aim.place(*place, axis=z),
        [
            ("diameter", "CIRCULAR_CLOSED_PROFILE", [("diameter", 8.0)]),
            ("hole depth", "PATH_FEATURE_COMPONENT", [("distance", 6.0)]),
            (f"hole depth {end}", "HOLE_BOTTOM", [("tip angle", 118.0)], "conical", "hole bottom usage"),
        ],
    )


@pytest.mark.parametrize(("end", "z"), [("start", -6.0), ("end", 0.0)])
def test_the_end_of_the_path_at_which_the_bottom_is(end, z):
    aim = Shaped()
    places, errors = drilled(aim, hole_of(aim, 20, 30, z, end=end))
    assert errors == []
    assert places.tolist() == [[20, 30, -6]]


def test_patterns_of_holes():
    """Four on a circle of 20 mm, two rows of three, two anywhere: each within its pattern's placement."""
    circular, rectangular, general = Shaped(), Shaped(), Shaped()
    count = [("number of features", 4.0), ("angular spacing", 90.0), ("diameter", 20.0)]
    pattern = circular.feature("CIRCULAR_PATTERN", circular.place(100, 0, 0), own=count)
    base = hole_of(circular, 0, 0, -6)
    circular.file.add("FEATURE_COMPONENT_RELATIONSHIP", "pattern basis", "", pattern, base)
    places, errors = drilled(circular, pattern)
    assert errors == []
    expected = [[90, 0, -6], [100, -10, -6], [100, 10, -6], [110, 0, -6]]
    np.testing.assert_allclose(places, expected, atol=1e-9)

    count = [
        ("number of rows", 2.0),
        ("number of columns", 3.0),
        ("row spacing", 7.0),
        ("column spacing", 5.0),
    ]
    pattern = rectangular.feature("RECTANGULAR_PATTERN", rectangular.place(1, 2, 0), own=count)
    shape = rectangular.file.add("PRODUCT_DEFINITION_SHAPE", "", "", pattern)
    rectangular.describe(
        shape,
        "DIRECTION_SHAPE_REPRESENTATION",
        "row layout direction",
        rectangular.file.direction(-np.eye(3)[1]),
    )
    rectangular.relate("pattern basis", "", pattern, hole_of(rectangular, 0, 0, -6))
    places, errors = drilled(rectangular, pattern)
    assert errors == []
    assert places[:, :2].tolist() == [[1 + 5 * c, 2 - 7 * r] for c in range(3) for r in (1, 0)]

    spots = [general.place(x, 5, 0, name="base feature placement") for x in (3, 9)]
    pattern = general.feature("FEATURE_PATTERN", general.place(0, 0, 0), own=[("", s) for s in spots])
    general.relate("pattern basis", "", pattern, hole_of(general, 0, 0, -6))
    places, errors = drilled(general, pattern)
    assert errors == []
    assert places.tolist() == [[3, 5, -6], [9, 5, -6]]


def test_patterns_with_copies_left_out_are_refused():
    aim = Shaped()
    pattern = aim.feature(
        "CIRCULAR_PATTERN", None, own=[("number of features", 4.0), ("angular spacing", 90.0)]
    )
    aim.relate("pattern basis", "", pattern, hole_of(aim, 0, 0, -6))
    left_out = aim.file.add("SHAPE_ASPECT", "", "", None, E("T"))
    aim.file.add("PATTERN_OMIT_MEMBERSHIP", "", "", pattern, left_out)
    assert drilled(aim, pattern)[1] == ["stepnc-unsupported"]


def test_a_counterbored_hole_takes_the_element_that_fits_the_tool():
    """The tool of 8 mm drills the small hole, 6 deep, not the large one of 20 mm."""
    aim = Shaped()
    hole = aim.feature("COMPOSITE_HOLE", aim.place(20, 30, 0), text="counterbore")
    sizes = [("diameter", "CIRCULAR_CLOSED_PROFILE", [("diameter", 20.0)])]
    large = aim.feature("ROUND_HOLE", aim.place(0, 0, 0), sizes, limit=-2.0)
    aim.relate("large hole", "", hole, large)
    aim.relate("small hole", "", hole, hole_of(aim, 0, 0, -6))
    places, errors = drilled(aim, hole)
    assert errors == []
    assert places.tolist() == [[20, 30, -6]]


def extent(path):
    """Return the lowest and highest X and Y at the lowest level, and that level; arcs count by their ends."""
    cut = path.end[motions(path)]
    cut = cut[np.isclose(cut[:, 2], cut[:, 2].min())]
    return cut[:, :2].min(axis=0), cut[:, :2].max(axis=0), float(cut[0, 2])


@pytest.mark.parametrize(
    ("profile", "sizes"),
    [
        ("RECTANGULAR_CLOSED_PROFILE", [("length", 40.0), ("width", 30.0)]),
        ("CLOSED_PATH_PROFILE", None),
        ("NGON_CLOSED_PROFILE", [("number of sides", 4.0), ("diameter across flats", 30.0)]),
    ],
)
@pytest.mark.parametrize("end", ["start", "end"])
def test_pockets_by_their_profiles(profile, sizes, end):
    """5 deep at (20, 30): the tool of 8 mm stays 4 mm from the walls."""
    aim = Shaped()
    outline = aim.polyline((-20, -15, 0), (20, -15, 0), (20, 15, 0), (-20, 15, 0), (-20, -15, 0))
    z, height = ((0, 0, 1), -5.0) if end == "start" else ((0, 0, -1), 0.0)
    if profile.startswith(
        "NGON"
    ):  # a square with its sides along X and Y, turned by a quarter by its own placement
        turned = aim.place(0, 0, 0, reference=(0, 1, 0))
        sizes = [*sizes, ("", turned)]
    path, found = aim.mill(
        "POCKET",
        aim.place(20, 30, height, axis=z),
        [
            ("boundary", profile, sizes or [("", outline)], "boundary"),
            ("pocket depth", "PATH_FEATURE_COMPONENT", [("distance", 5.0)]),
            (f"pocket depth {end}", "POCKET_BOTTOM", [("radius", 0.0)], "planar", "pocket bottom usage"),
        ],
    )
    assert codes(found) == []
    low, high, level = extent(path)
    half = np.array([15.0, 15.0]) if profile.startswith("NGON") else np.array([20.0, 15.0])
    assert level == pytest.approx(-5.0)
    np.testing.assert_allclose(low, 4 - half + (20, 30), atol=1e-3)
    np.testing.assert_allclose(high, half - 4 + (20, 30), atol=1e-3)


def test_a_profile_that_repeats_its_features_placement_is_not_moved_twice():
    """As in the example of ISO 10303-238, annex J.6."""
    aim = Shaped()
    place = aim.place(20, 30, 0)
    sizes = [("length", 40.0), ("width", 30.0), ("", place)]
    boundary = ("boundary", "RECTANGULAR_CLOSED_PROFILE", sizes, "boundary")
    path, found = aim.mill("POCKET", place, [boundary], limit=-5.0)
    assert codes(found) == ["stepnc-placement"]
    low, high, _ = extent(path)
    np.testing.assert_allclose([low, high], [[4, 19], [36, 41]], atol=1e-3)


def test_an_open_pocket_is_left_over_its_open_side():
    """Its wall goes round three sides; the fourth, at Y 15, is open."""
    aim = Shaped()
    wall = aim.polyline((-20, 15, 0), (-20, -15, 0), (20, -15, 0), (20, 15, 0))
    path, found = aim.mill(
        "POCKET",
        aim.place(0, 0, 0),
        [("boundary", "OPEN_PATH_PROFILE", [("", wall)], "boundary")],
        limit=-5.0,
    )
    assert codes(found) == []
    low, high, _ = extent(path)
    np.testing.assert_allclose(low, [-16, -11], atol=1e-3)
    assert high[0] == pytest.approx(16, abs=1e-3)
    assert high[1] >= 15


@pytest.mark.parametrize("turned", [False, True])
def test_an_open_pocket_whose_open_side_is_a_curve_of_its_own(turned):
    """The wall along X at Y -15, from X -20 to 20; the open side goes round by (20, 15) and (-20, 15), either way."""
    aim = Shaped()
    corners = [(20, -15, 0), (20, 15, 0), (-20, 15, 0), (-20, -15, 0)]
    open_side = aim.polyline(*(corners[::-1] if turned else corners))
    wall = [("profile length", 40.0), ("", aim.place(-20, -15, 0))]
    path, found = aim.mill(
        "POCKET",
        aim.place(0, 0, 0),
        [
            ("wall boundary", "LINEAR_PROFILE", wall, "wall", "wall boundary usage"),
            ("open boundary", "OPEN_PATH_PROFILE", [("", open_side)], "boundary"),
        ],
        limit=-5.0,
    )
    assert codes(found) == []
    low, high, _ = extent(path)
    assert low[1] == pytest.approx(-11, abs=1e-3)
    assert high[1] >= 15
    assert low[0] <= -20
    assert high[0] >= 20


def test_an_outline_that_is_left_open_is_closed_by_a_line():
    """A triangle of which two sides are given: the tool of 8 mm keeps 4 mm from the third too, x = y."""
    aim = Shaped()
    sides = aim.polyline((0, 0, 0), (40, 0, 0), (40, 40, 0))
    path, found = aim.mill(
        "POCKET",
        aim.place(0, 0, 0),
        [("boundary", "CLOSED_PATH_PROFILE", [("", sides)], "boundary")],
        limit=-5.0,
    )
    assert codes(found) == []
    cut = path.end[motions(path)]
    cut = cut[np.isclose(cut[:, 2], -5.0)]
    assert ((cut[:, 0] - cut[:, 1]) / math.sqrt(2)).min() == pytest.approx(4.0, abs=1e-3)


@pytest.mark.parametrize("convention", ["bottom", "top"])
@pytest.mark.parametrize("closed", ["start", "end"])
def test_each_end_of_a_slot_is_as_it_is_given(convention, closed):
    """As wide as the tool, 40 long from Y 30 on: it stops at a radiused end and goes beyond an open one.

    The path of ISO 10303 begins at the other end than that of the placement of ISO 14649.
    """
    aim = Shaped()
    ends = {"start": "open", "end": "open"} | {closed: "radiused"}
    path, found = aim.mill(
        "SLOT",
        swept_place(aim, convention, 5.0, 40.0),
        [
            ("course of travel", "PATH_FEATURE_COMPONENT", [("distance", 40.0)]),
            ("swept shape", "SQUARE_U_PROFILE", [("width", 8.0), ("depth", 5.0), ("first angle", 90.0)]),
            *(
                (f"course of travel {end}", "SLOT_END", [("radius", 0.0)], kind, "slot end usage")
                for end, kind in ends.items()
            ),
        ],
        limit=-5.0 if convention == "top" else None,
    )
    assert codes(found, "error") == []
    low, high, _ = extent(path)
    at_low = (closed == "start") == (convention == "top")
    assert (low[1] == pytest.approx(30.0, abs=1e-3)) == at_low
    assert (high[1] == pytest.approx(70.0, abs=1e-3)) == (not at_low)
    assert low[1] <= 30.001
    assert high[1] >= 69.999


def test_a_slot_along_a_curve():
    """As wide as the tool, along two lines: the tool's axis goes along them."""
    aim = Shaped()
    course = aim.polyline((0, 0, 0), (0, 30, 0), (20, 50, 0))
    path, found = aim.mill(
        "SLOT",
        aim.place(0, 0, 0),
        [
            ("course of travel", "PATH_FEATURE_COMPONENT", [("", course)], "complex"),
            ("swept shape", "SQUARE_U_PROFILE", [("width", 8.0)]),
        ],
        limit=-3.0,
    )
    assert codes(found) == []
    cut = path.end[motions(path)]
    cut = cut[np.isclose(cut[:, 2], -3.0), :2]
    assert np.linalg.norm(cut - (0, 30), axis=1).min() < 1e-6
    off = np.where(cut[:, 1] <= 30, cut[:, 0], (cut[:, 0] - cut[:, 1] + 30) / math.sqrt(2))
    np.testing.assert_allclose(off, 0.0, atol=1e-6)


def test_a_face_within_a_closed_boundary():
    """A circle of 20 mm about (10, 15) instead of the rectangle of 30 by 40 mm: the lines go beyond it, not over all."""
    aim = Shaped()
    circle = [("diameter", 20.0), ("", aim.place(10, 15, 0))]
    path, found = aim.mill(
        "FLAT_FACE",
        aim.place(0, 0, -2),
        [
            ("course of travel", "PATH_FEATURE_COMPONENT", [("distance", 40.0)]),
            ("removal boundary", "LINEAR_PROFILE", [("profile length", 30.0)]),
            ("face boundary", "CIRCULAR_CLOSED_PROFILE", circle, "boundary"),
        ],
        operation="PLANE_MILLING_OPERATION",
        own=[("removal depth", 2.0)],
    )
    assert codes(found) == []
    low, high, _ = extent(path)
    middle = (low + high) / 2
    assert middle[1] == pytest.approx(15.0)
    assert high[1] - low[1] == pytest.approx(20 + 2 * (2.5 * 4 - 4), abs=1e-4)  # overcut_length: 2.5 radii
    assert high[0] < 20 + 4


def test_a_boss_stays_in_a_pocket():
    """A round boss of 10 mm in the middle, as high as the pocket is deep: the tool's axis stays 9 mm from its centre."""
    aim = Shaped()
    pocket = aim.feature(
        "POCKET",
        aim.place(0, 0, -5),
        [
            ("boundary", "RECTANGULAR_CLOSED_PROFILE", [("length", 60.0), ("width", 60.0)], "boundary"),
            ("pocket depth", "PATH_FEATURE_COMPONENT", [("distance", 5.0)]),
        ],
    )
    boss = aim.feature(
        "BOSS",
        aim.place(0, 0, 0),
        [
            ("boundary", "CIRCULAR_CLOSED_PROFILE", [("diameter", 10.0)], "boundary"),
            ("boss height", "PATH_FEATURE_COMPONENT", [("distance", 5.0)]),
        ],
    )
    aim.relate("", "uncut volume", pocket, boss)
    step, _ = aim.machine(pocket)
    path, found = aim.read(aim.plan(step))
    assert codes(found) == []
    cut = path.end[motions(path)]
    cut = cut[np.isclose(cut[:, 2], -5.0)]
    assert np.linalg.norm(cut[:, :2], axis=1).min() == pytest.approx(9.0, abs=1e-3)


def test_a_slot_along_an_arc():
    """As wide as the tool: along the middle, a quarter circle of 30 mm, 3 below the top."""
    aim = Shaped()
    path, found = aim.mill(
        "SLOT",
        aim.place(0, 0, 0),
        [
            ("course of travel", "PATH_FEATURE_COMPONENT", [("radius", 30.0), ("sweep angle", 90.0)], "partial circular"),
            ("swept shape", "SQUARE_U_PROFILE", [("width", 8.0)]),
        ],
        limit=-3.0,
    )  # fmt: skip
    assert codes(found) == []
    assert path.arcs.sweep == pytest.approx([math.pi / 2])
    np.testing.assert_allclose(path.end[motions(path)][-2], [0, 30, -3], atol=1e-9)


def test_a_face_from_its_bottom_with_its_removal_depth():
    """30 along X, 40 along the path's direction, 2 deep: the lines overrun it along the path."""
    aim = Shaped()
    along = aim.file.direction(np.array([0.0, 1.0, 0.0]))
    path, found = aim.mill(
        "FLAT_FACE",
        aim.place(0, 0, -2),
        [
            ("course of travel", "PATH_FEATURE_COMPONENT", [("distance", 40.0), ("", along)]),
            ("removal boundary", "LINEAR_PROFILE", [("profile length", 30.0)]),
        ],
        operation="PLANE_MILLING_OPERATION",
        own=[("removal depth", 2.0)],
    )
    assert codes(found) == []
    low, high, level = extent(path)
    assert level == pytest.approx(-2.0)
    assert low[1] < 0
    assert high[1] > 40


@pytest.mark.parametrize(
    "taper", [("final diameter", 20.0), ("taper angle", math.degrees(math.atan(0.5)))], ids=lambda t: t[0]
)
def test_a_hole_that_is_milled_with_its_taper(taper):
    """30 mm at the top, 20 mm at 10 deep; cut in one pass its walls stand where the bottom is: 10 - 4 mm."""
    aim = Shaped()
    path, found = aim.mill(
        "ROUND_HOLE",
        aim.place(0, 0, 0),
        [
            ("diameter", "CIRCULAR_CLOSED_PROFILE", [("diameter", 30.0)]),
            ("change in diameter", "TAPER", [taper], "taper", "taper usage"),
            ("hole depth start", "HOLE_BOTTOM", [("radius", 0.0)], "through", "hole bottom usage"),
        ],
        limit=-10.0,
    )
    assert codes(found, "error") == []
    cut = path.end[motions(path)]
    cut = cut[np.isclose(cut[:, 2], cut[:, 2].min())]
    assert np.linalg.norm(cut[:, :2], axis=1).max() == pytest.approx(6.0, abs=1e-3)


def test_a_workpiece_that_stands_elsewhere_in_its_setup():
    """Features move with the workpiece, by (100, 0, 50)."""
    aim = Shaped()
    step, _ = aim.machine(hole_of(aim, 0, 0, -6), "DRILLING_OPERATION", "drilling", "twist drill")
    plan = aim.plan(step)
    setup = aim.file.add("PRODUCT_DEFINITION", "", "", aim.file.mm, None)
    workpiece = aim.file.add("PRODUCT_DEFINITION", "", "", aim.file.mm, None)
    process = aim.file.add("PRODUCT_DEFINITION_PROCESS", "setup", "", plan, "")
    aim.file.add("PROCESS_PRODUCT_ASSOCIATION", "", "", setup, process)
    relation = aim.file.add("MACHINING_SETUP_WORKPIECE_RELATIONSHIP", "", "", "", setup, workpiece)
    shape = aim.file.add("PRODUCT_DEFINITION_SHAPE", "", "", relation)
    places = [aim.place(*p, name="") for p in ((0, 0, 0), (100, 0, 50))]
    spaces = [aim.file.add("SHAPE_REPRESENTATION", "", (p,), aim.file.context) for p in places]
    move = aim.file.add("ITEM_DEFINED_TRANSFORMATION", "", "", *places)
    link = aim.file.add_complex(
        ("REPRESENTATION_RELATIONSHIP", ("", "", *spaces)),
        ("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION", (move,)),
        ("SHAPE_REPRESENTATION_RELATIONSHIP", ()),
    )
    aim.file.add("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION", link, shape)
    path, found = aim.read(plan)
    assert codes(found, "error") == []
    assert path.end[motions(path), 2].min() == pytest.approx(44.0)
    assert path.end[motions(path)][-1, 0] == pytest.approx(100.0)


def test_percents_for_ratios():
    aim = Shaped()
    face = aim.feature(
        "FLAT_FACE",
        aim.place(0, 0, -2),
        [
            ("course of travel", "PATH_FEATURE_COMPONENT", [("distance", 40.0)]),
            ("removal boundary", "LINEAR_PROFILE", [("profile length", 30.0)]),
        ],
        own=[("removal depth", 2.0)],
    )
    step, operation = aim.machine(face, "PLANE_MILLING_OPERATION")
    strategy = aim.file.method("MILLING_TYPE_STRATEGY", "", "bidirectional")
    aim.file.add("MACHINING_STRATEGY_RELATIONSHIP", "machining", "", operation, strategy)
    ratio = aim.file.add("MEASURE_REPRESENTATION_ITEM", "overlap", 50.0, aim.file.mm)
    aim.file.property(strategy, "overlap ratio", "REPRESENTATION", "overlap ratio", ratio)
    path, found = aim.read(aim.plan(step))
    assert codes(found) == ["stepnc-ratio"]
    assert len(np.unique(np.round(path.end[motions(path), 0], 3))) >= 7


def test_the_plate():
    """The plate of programs/stepnc/plate_ap238.stp, by heights."""
    program = read(Path(__file__).parents[2] / "programs" / "stepnc" / "plate_ap238.stp", "plate_ap238.stp")
    path = next(iter(program.chunks()))
    assert [d.code for d in program.diagnostics] == []
    radius = {"MILL 20": 10.0, "MILL 10": 5.0, "MILL 6": 3.0, "BALL 6": 3.0, "DRILL 5": 2.5}
    heights = removed([path], (160.0, 100.0), 0.0, 0.5, radius)[1]

    def at(x, y):
        return pytest.approx(heights[int(x / 0.5), int(y / 0.5)], abs=1e-6)

    assert at(5, 5) == at(80, 50) == at(105, 50) == -1.0  # the face
    assert at(30, 30) == at(45, 20) == at(60, 80) == -9.0  # the pocket
    assert at(45, 55) == at(50, 55) == -3.0  # its boss
    assert at(105, 90) == at(105, 99) == -5.0 - 1.0  # the bay, out to its open side
    assert at(105, 56) == -1.0
    assert at(123, 26) == at(87, 26) == at(105, 43) == -4.0  # the groove
    assert at(105, 25) == -1.0
    for x, y in ((113, 25), (97, 25), (140, 20), (150, 50), (145, 80)):
        assert heights[int(x / 0.5), int(y / 0.5)] < -13.0  # through
    assert at(150, 80) == -5.0  # the counterbore
    assert heights[260, 100] == pytest.approx(-10.0, abs=0.01)  # the middle of the round bottom


@pytest.mark.parametrize("kind", ["COMPOUND_FEATURE", "CIRCULAR_PATTERN", "POCKET"])
def test_features_that_hold_themselves_end_in_a_diagnostic(kind):
    aim = Shaped()
    own = [("number of features", 3.0), ("angular spacing", 10.0)]
    sizes = [("boundary", "RECTANGULAR_CLOSED_PROFILE", [("length", 40.0), ("width", 30.0)], "boundary")]
    feature = aim.feature(kind, aim.place(0, 0, 0), sizes, limit=-5.0, own=own)
    aim.relate("pattern basis", "uncut volume", feature, feature)
    step, _ = aim.machine(feature)
    path, found = aim.read(aim.plan(step))
    if kind == "POCKET":  # what is no boss does not stand in it
        assert codes(found) == []
        assert len(motions(path))
    else:
        assert codes(found, "error") == ["stepnc-geometry"]


def test_features_in_inches_are_the_same():
    """Geometry in the unit of its context, sizes in their own."""
    ends = []
    for inches in (False, True):
        aim = Shaped(inches)
        corners = ((-20, -15, 0), (20, -15, 0), (20, 15, 0), (-20, 15, 0), (-20, -15, 0))
        path, found = aim.mill(
            "POCKET",
            aim.place(20, 30, -5),
            [
                ("boundary", "CLOSED_PATH_PROFILE", [("", aim.polyline(*corners))], "boundary"),
                ("pocket depth", "PATH_FEATURE_COMPONENT", [("distance", 5.0)]),
            ],
        )
        # 600 inches a minute are 5 mm a turn of the 8 mm tool.
        assert codes(found) == (["stepnc-feed-unit"] if inches else [])
        ends.append(path.end[motions(path)])
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-6)


def test_a_pocket_with_the_placement_of_one_standard_and_the_depth_plane_of_the_other():
    """As in the annotated example of ISO 10303-238: Z into the material, the plane 30 mm below all the same.

    The outline goes from the corner to +Y and -X of the placement, whose X is -X of the part: X 45 to 95, Y 110 to 190.
    """
    aim = Shaped()
    outline = aim.polyline((0, 0, 0), (0, 80, 0), (-50, 80, 0), (-50, 0, 0), (0, 0, 0))
    path, found = aim.mill(
        "POCKET",
        aim.place(45, 110, 0, axis=(0, 0, -1), reference=(-1, 0, 0)),
        [
            ("boundary", "CLOSED_PATH_PROFILE", [("", outline)]),
            ("pocket depth", "PATH_FEATURE_COMPONENT", [("distance", 30.0)]),
            ("pocket depth end", "POCKET_BOTTOM", [("radius", 0.0)], "planar", "pocket bottom usage"),
        ],
        limit=-30.0,
    )
    assert codes(found) == []
    low, high, level = extent(path)
    assert level == pytest.approx(-30.0)
    np.testing.assert_allclose([low, high], [[49, 114], [91, 186]], atol=1e-3)


def test_tapping_with_the_pitch_of_the_tap():
    """1.25 mm a turn at 8 turns a second are 10 mm/s, whatever feed is given; the way out is in step too."""
    aim = Shaped()
    technology = aim.technology(600.0 * 60, spindle=-8.0)
    step, _ = aim.machine(
        hole_of(aim, 20, 30, -6), "TAPPING_OPERATION", "tapping", "tap", technology, [("thread pitch", 1.25)]
    )
    path, found = aim.read(aim.plan(step))
    assert codes(found, "error") == []
    rows = [k for k in motions(path) if path.feed_mode[k] == FeedMode.SPEED]
    np.testing.assert_allclose(path.end[rows, 2], [-6, 5])
    np.testing.assert_allclose(path.feed[rows], 10.0)
    assert codes(found) == ["stepnc-pitch"]
    assert [e.values["pitch_mm"] for e in path.events if e.name == "synchronise"] == [1.25, None]
    assert [e.values["direction"] for e in path.events if e.name == "spindle"] == [1]


@pytest.mark.parametrize(("hand", "sense"), [("right", 1), ("left", -1)])
def test_a_cutting_speed_turns_as_the_hand_of_the_tool(hand, sense):
    """0.2 m/s on 8 mm are 200 / (8 pi) turns a second; ISO 14649-10: clockwise, 1, for right-handed cutters."""
    aim = Shaped()
    per_second = aim.file._product((aim.file.mm, 1.0), (aim.file.second, -1.0))
    technology = aim.technology(600.0, spindle=200.0, spindle_unit=per_second)
    hole, hands = hole_of(aim, 20, 30, -6), [("hand of cut", hand)]
    step, _ = aim.machine(hole, "DRILLING_OPERATION", "drilling", "twist drill", technology, hands)
    path, found = aim.read(aim.plan(step))
    assert codes(found, "error") == []
    values = next(e for e in path.events if e.name == "spindle").values
    assert values["speed_rpm"] == pytest.approx(200 / (8 * math.pi) * 60)
    assert values["direction"] == sense


def test_an_outline_given_at_the_top_is_not_mirrored():
    """A triangle seen from above: flipped placements see it from below."""
    for z, axis, end in ((-5.0, (0, 0, 1), "start"), (0.0, (0, 0, -1), "end")):
        aim = Shaped()
        up = 1 if end == "start" else -1  # Y of a placement whose Z goes down is -Y
        corners = [(0, 0, 0), (60, 0, 0), (0, 60 * up, 0), (0, 0, 0)]
        path, found = aim.mill(
            "POCKET",
            aim.place(10, 20, z, axis=axis),
            [
                ("boundary", "CLOSED_PATH_PROFILE", [("", aim.polyline(*corners))], "boundary"),
                ("pocket depth", "PATH_FEATURE_COMPONENT", [("distance", 5.0)]),
                (f"pocket depth {end}", "POCKET_BOTTOM", [("radius", 0.0)], "planar", "pocket bottom usage"),
            ],
        )
        assert codes(found) == []
        low, _, level = extent(path)
        assert level == pytest.approx(-5.0)
        np.testing.assert_allclose(low, [14, 24], atol=1e-3)


def test_a_drilling_strategy_with_its_names_and_percents():
    """As in the annotated example: relative speeds of 75 and 50, a feed on retract of 0."""
    aim = Shaped()
    step, operation = aim.machine(hole_of(aim, 0, 0, -6), "DRILLING_OPERATION", "drilling", "twist drill")
    strategy = aim.file.method("DRILLING_TYPE_STRATEGY")
    aim.file.add("MACHINING_STRATEGY_RELATIONSHIP", "machining", "", operation, strategy)
    percents = {
        "reduced cut at start": 75.0,
        "reduced feedrate at start": 50.0,
        "reduced feedrate at end": 25.0,
    }
    for owner, name, value in [
        *((strategy, n, v) for n, v in percents.items()),
        (strategy, "depth of start", 2.0),
        (strategy, "depth of end", 4.0),
        (operation, "feedrate on retract", 0.0),
    ]:
        item = aim.file.add("MEASURE_REPRESENTATION_ITEM", "relative speed", value, aim.file.mm)
        aim.file.property(owner, name, "REPRESENTATION", "relative speed", item)
    path, found = aim.read(aim.plan(step))
    assert codes(found) == ["stepnc-ratio"] * 4
    rows = motions(path)[-4:]
    assert path.end[rows, 2].tolist() == pytest.approx([-2, -4, -6, 5])
    np.testing.assert_allclose(path.feed[rows] * 60, [300, 600, 150, 600])


def test_arcs_of_no_angle_are_refused():
    """Found by fuzzing: an infinite sweep."""
    aim = Shaped()
    components = [
        ("course of travel", "PATH_FEATURE_COMPONENT", [("radius", 30.0), ("sweep angle", 1e14)], "partial circular"),
        ("swept shape", "SQUARE_U_PROFILE", [("width", 8.0)]),
    ]  # fmt: skip
    _, found = aim.mill("SLOT", aim.place(0, 0, 0), components, limit=-3.0)
    assert codes(found, "error") == ["stepnc-geometry"]


def test_patterns_of_no_angle_are_refused():
    """Found by fuzzing."""
    aim = Shaped()
    size = [("number of features", 4.0), ("angular spacing", 1e14)]
    pattern = aim.feature("CIRCULAR_PATTERN", aim.place(0, 0, 0), own=size)
    aim.relate("pattern basis", "", pattern, hole_of(aim, 0, 0, -6))
    assert drilled(aim, pattern)[1] == ["stepnc-geometry"]


def slot_of(aim, sizes, keyword, limit=-4.0, course=(("distance", 40.0),), text="linear"):
    """Return a slot placed at the top whose section has a profile."""
    components = [
        ("course of travel", "PATH_FEATURE_COMPONENT", list(course), text),
        ("swept shape", keyword, sizes),
    ]
    return aim.feature("SLOT", aim.place(0, 0, 0), components, limit)


def test_a_round_slot_is_cut_by_the_ball_that_fits_it():
    """A half circle of 4 mm by a ball of 8: along the middle, its tip at the bottom."""
    aim = Shaped()
    slot = slot_of(aim, [("radius", 4.0), ("sweep angle", 180.0)], "PARTIAL_CIRCULAR_PROFILE")
    step, _ = aim.machine(slot, kind="ball endmill")
    path, found = aim.read(aim.plan(step))
    assert codes(found) == []
    low, high, level = extent(path)
    assert level == pytest.approx(-4.0)
    np.testing.assert_allclose([low[0], high[0]], 0.0, atol=1e-9)
    assert low[1] <= 0.0
    assert high[1] >= 40.0


BOX = [("length", 40.0), ("width", 30.0)]
VEE = [("profile angle", 90.0), ("tilt angle", 45.0), ("profile radius", 0.0)]
DISTANCE = ("course of travel", "PATH_FEATURE_COMPONENT", [("distance", 40.0)])


def feature_of(kind, *components, limit=-5.0):
    return lambda aim: aim.feature(kind, aim.place(0, 0, 0), list(components), limit)


@pytest.mark.parametrize(
    ("make", "code"),
    [
        # A flat tool has not the section of a vee, nor one that is too wide that of an arc.
        (lambda a: slot_of(a, VEE, "VEE_PROFILE"), "stepnc-unsupported"),
        (lambda a: slot_of(a, [("radius", 3.0), ("sweep angle", 180.0)], "PARTIAL_CIRCULAR_PROFILE"), "stepnc-unsupported"),
        (lambda a: slot_of(a, [("depth", 5.0)], "SQUARE_U_PROFILE"), "stepnc-unsupported"),
        (lambda a: slot_of(a, [("width", 12.0), ("first angle", 80.0)], "SQUARE_U_PROFILE"), "stepnc-unsupported"),
        (lambda a: slot_of(a, [("width", 12.0)], "TEE_PROFILE"), "stepnc-unsupported"),
        (feature_of("SLOT", DISTANCE), "stepnc-missing"),
        (feature_of("STEP", DISTANCE), "stepnc-unsupported"),
        (feature_of("STEP", ("wall boundary", "VEE_PROFILE", [*VEE, ("first side length", 15.0)])), "stepnc-unsupported"),
        (feature_of("STEP", DISTANCE, ("wall boundary", "VEE_PROFILE", [*VEE, ("first side length", 15.0)])), "stepnc-unsupported"),
        (feature_of("STEP", DISTANCE, ("wall boundary", "VEE_PROFILE", [("profile angle", 90.0), ("tilt angle", 0.0)])), "stepnc-unsupported"),
        (feature_of("POCKET"), "stepnc-missing"),
        (feature_of("OUTSIDE_PROFILE"), "stepnc-missing"),
        (feature_of("FLAT_FACE", DISTANCE), "stepnc-missing"),
        (feature_of("FLAT_FACE", DISTANCE, ("removal boundary", "LINEAR_PROFILE", [])), "stepnc-missing"),
        (feature_of("GEAR"), "stepnc-unsupported"),
    ],
)  # fmt: skip
def test_features_that_cannot_be_made_are_refused(make, code):
    aim = Shaped()
    step, _ = aim.machine(make(aim))
    _, found = aim.read(aim.plan(step))
    assert code in codes(found, "error")
    assert codes(found, "error") == [code] * len(codes(found, "error"))


def test_a_boss_that_leans_is_refused():
    aim = Shaped()
    boundary = ("boundary", "RECTANGULAR_CLOSED_PROFILE", BOX, "boundary")
    pocket = aim.feature("POCKET", aim.place(0, 0, 0), [boundary], -5.0)
    round_one = ("boundary", "CIRCULAR_CLOSED_PROFILE", [("diameter", 10.0)], "boundary")
    boss = aim.feature("BOSS", aim.place(0, 0, 0, axis=(0, 1, 0)), [round_one])
    aim.relate("", "uncut volume", pocket, boss)
    step, _ = aim.machine(pocket)
    _, found = aim.read(aim.plan(step))
    assert "stepnc-unsupported" in codes(found, "error")


@pytest.mark.parametrize("degrees", [3.0, 10.0])
def test_an_angle_of_an_approach_is_in_the_unit_of_its_measure(degrees):
    """A helix down into a pocket: the angle came as radians inside, and was taken for degrees."""
    aim = Shaped()
    boundary = ("boundary", "RECTANGULAR_CLOSED_PROFILE", [("length", 40.0), ("width", 40.0)])
    step, operation = aim.machine(aim.feature("POCKET", aim.place(0, 0, 0), [boundary], limit=-2.0))
    approach = aim.file.method("MACHINING_APPROACH_RETRACT_STRATEGY", "", "plunge helix")
    aim.file.add("MACHINING_STRATEGY_RELATIONSHIP", "approach", "", operation, approach)
    for name, item in (
        ("plunge radius", aim.file.measure("", 6.0, aim.file.mm)),
        ("plunge angle", aim.file.measure("", degrees, aim.degree)),
    ):
        aim.file.property(approach, name, "REPRESENTATION", "", item)
    path, found = aim.read(aim.plan(step))
    assert codes(found) == []
    rows = motions(path)
    drop, length = path.starts[rows, 2] - path.end[rows, 2], path.path.row_length[rows]
    helix = (path.kind[rows] == Kind.ARC) & (drop > 1e-9)
    assert helix.any()
    np.testing.assert_allclose(np.degrees(np.arcsin(drop[helix] / length[helix])), degrees, atol=0.1)
