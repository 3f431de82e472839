"""Every strategy on pockets that are hard to clear: no wall is touched, no place is left, no rapid goes through material.

What is removed is found by an independent simulation of the tool (`tests.stepnc.heightfield.swept`), and what can be
removed by growing and shrinking the pocket's region by the tool's radius.
"""

import itertools
import math

import numpy as np
import pytest
import shapely
from shapely import Polygon, box

from cncgen.stepnc.features.offsets import grown, polygon_of, strip
from cncgen.stepnc.geometry.pieces import Arc
from tests.stepnc.building import E, codes
from tests.stepnc.featured import GRID, ORIGIN, SIZE, Features, cells, check_cut
from tests.stepnc.heightfield import swept

#: Corners whose largest circle is not in one place; corners of 50 degrees; a necking wider than the tool.
U_SHAPE = ((-35, -25), (35, -25), (35, 25), (20, 25), (20, -10), (-20, -10), (-20, 25), (-35, 25))
STAR = tuple(
    (r * math.cos(math.pi * k / 5), r * math.sin(math.pi * k / 5))
    for k, r in zip(range(10), itertools.cycle((28, 14)), strict=False)
)
NECK = (
    (-35, -20), (-5, -20), (-5, -5), (5, -5), (5, -20), (35, -20),
    (35, 20), (5, 20), (5, 5), (-5, 5), (-5, 20), (-35, 20),
)  # fmt: skip
OUTLINES = {"U": U_SHAPE, "star": STAR, "neck": NECK}
STRATEGIES = {
    "CONTOUR_PARALLEL": (E("T"), E("CCW"), E("CLIMB")),
    "CONTOUR_SPIRAL": (E("T"), E("CCW"), E("CONVENTIONAL")),
    "BIDIRECTIONAL_MILLING": (E("T"), None, E("LEFT"), None),
    "UNIDIRECTIONAL_MILLING": (E("T"), None, E("CLIMB")),
    "BIDIRECTIONAL_CONTOUR": (E("T"), None, E("LEFT"), E("CW"), None),
    "CONTOUR_BIDIRECTIONAL": (E("T"), None, E("RIGHT"), E("CCW"), None),
}
APPROACHES = [
    None,
    ("PLUNGE_TOOLAXIS",),
    ("PLUNGE_RAMP", 8.0),
    ("PLUNGE_HELIX", 2.0, 5.0),
    ("PLUNGE_ZIGZAG", 8.0, 5.0),
]


def milled(boundary, strategy, overlap, bosses=(), approach=None, along=None, diameter=8.0, kind="FINISH"):
    """Return the path of a pocket 6 mm deep, and its diagnostics; `boundary` makes the outline of a part."""
    part = Features()
    values = list(STRATEGIES[strategy])
    if along is not None and strategy.endswith("DIRECTIONAL_MILLING"):
        values[1] = part.direction(*along)
    way = None if approach is None else part.add(approach[0], None, *approach[1:])
    plan = part.add(strategy, overlap, *values)
    operation = part.operation(
        f"BOTTOM_AND_SIDE_{kind}_MILLING",
        3.0,
        None,
        None,
        None,
        approach=way,
        strategy=plan,
        diameter=diameter,
    )
    standing = tuple(part.boss(part.polygon(*corners)) for corners in bosses)
    part.mill(part.pocket(boundary(part), standing), operation)
    return part.read()


@pytest.mark.parametrize("overlap", [0.0, 0.4])
@pytest.mark.parametrize("outline", OUTLINES)
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_all_that_a_tool_reaches_is_cut_and_nothing_else(strategy, outline, overlap):
    """An overlap of 0 sets passes a diameter apart: in corners that leaves ridges, where the tool must go too."""
    corners = OUTLINES[outline]
    approach = APPROACHES[
        (list(STRATEGIES).index(strategy) + list(OUTLINES).index(outline)) % len(APPROACHES)
    ]
    path, found = milled(lambda p: p.polygon(*corners), strategy, overlap, approach=approach)
    assert codes(found, "error") == []
    heights, crashes = swept(path, SIZE, GRID, 4.0)
    assert crashes == []
    check_cut(heights, Polygon(corners), 4.0, 6.0)


BOSSES = {
    "at a wall": [((-30, -5), (-20, -5), (-20, 5), (-30, 5))],
    "through a wall": [((-40, -5), (-20, -5), (-20, 5), (-40, 5))],
    "outside": [((60, 0), (70, 0), (70, 10))],
    "one in the other": [((-8, -6), (8, -6), (8, 6), (-8, 6)), ((0, 0), (15, 0), (15, 10), (0, 10))],
    "too near": [((-24, -5), (-15, -5), (-15, 5), (-24, 5))],
}


@pytest.mark.parametrize("where", BOSSES)
@pytest.mark.parametrize("strategy", ["CONTOUR_PARALLEL", "CONTOUR_SPIRAL", "UNIDIRECTIONAL_MILLING"])
def test_bosses_stand_wherever_they_are(strategy, where):
    path, found = milled(lambda p: p.rectangle(60, 40), strategy, 0.3, BOSSES[where], along=(1, 1, 0))
    assert codes(found, "error") == []
    assert ("stepnc-uncut" in codes(found, "warning")) == (where == "too near")
    heights, crashes = swept(path, SIZE, GRID, 4.0)
    assert crashes == []
    region = box(-30, -20, 30, 20)
    for corners in BOSSES[where]:
        region = region - Polygon(corners)
    check_cut(heights, region, 4.0, 6.0)


def test_a_boss_that_fills_the_pocket_is_an_error():
    everywhere = [((-40, -30), (40, -30), (40, 30), (-40, 30))]
    _, found = milled(lambda p: p.rectangle(60, 40), "CONTOUR_PARALLEL", 0.3, everywhere)
    assert codes(found, "error") == ["stepnc-geometry"]


def test_a_first_line_of_no_length_is_no_ramp():
    """Lines across a rectangle by 45 degrees begin in its corner; ramping there went to and fro without an end."""
    path, found = milled(
        lambda p: p.rectangle(60, 40),
        "UNIDIRECTIONAL_MILLING",
        0.3,
        approach=("PLUNGE_RAMP", 10.0),
        along=(1, 1, 0),
    )
    assert codes(found) == []
    assert len(path) < 200
    heights, crashes = swept(path, SIZE, GRID, 4.0)
    assert crashes == []
    check_cut(heights, box(-30, -20, 30, 20), 4.0, 6.0)


def test_where_nothing_else_fits_the_tool_plunges_and_says_so():
    """In a hole 0.002 mm wider than the tool neither helix nor ramp has room."""
    path, found = milled(
        lambda p: p.add("CIRCULAR_CLOSED_PROFILE", None, p.size(8.002)),
        "CONTOUR_PARALLEL",
        0.4,
        approach=("PLUNGE_RAMP", 1.0),
    )
    assert codes(found) == ["stepnc-approach"]
    assert path.end[:, 2].min() == -6.0
    assert len(path) < 100


@pytest.mark.parametrize(
    "approach", [("PLUNGE_RAMP", 1e-7), ("PLUNGE_HELIX", 2.0, 1e-7), ("PLUNGE_ZIGZAG", 1e-7, 5.0)]
)
def test_ways_down_without_an_end_are_refused(approach):
    _, found = milled(lambda p: p.rectangle(60, 40), "CONTOUR_PARALLEL", 0.4, approach=approach)
    assert codes(found, "error") == ["stepnc-geometry"]


def test_rings_beyond_pythons_depth_of_calls():
    """A pocket of 1,200 rings."""
    part = Features()
    plan = part.add("CONTOUR_PARALLEL", None, E("T"), E("CCW"), E("CLIMB"))
    operation = part.operation("BOTTOM_AND_SIDE_ROUGH_MILLING", None, 0.0133, None, None, strategy=plan)
    part.mill(part.pocket(part.rectangle(60, 40)), operation)
    path, found = part.read()
    assert codes(found) == []
    assert len(path) > 4800
    deep = path.end[path.end[:, 2] < 0.0, :2] - ORIGIN[:2]
    np.testing.assert_allclose([deep.min(axis=0), deep.max(axis=0)], [[-26, -16], [26, 16]], atol=1e-6)


@pytest.mark.parametrize("kind", ["SIDE_FINISH_MILLING", "BOTTOM_AND_SIDE_ROUGH_MILLING"])
def test_a_wide_tool_leaves_what_stands_behind_a_narrow_step(kind):
    """A step 20 mm wide, the tool 14: growing its open side by 2.5 radii and more reached behind the wall too."""
    part = Features()
    wall = part.add("VEE_PROFILE", None, None, 90.0, 0.0)
    feature = part.step_feature(part.block((20, 5, -20), (70, 70, 0)), wall=wall)
    part.mill(
        feature, part.operation(kind, 6.0, None, None, *([None] if "BOTTOM" in kind else []), diameter=14.0)
    )
    path, found = part.read()
    assert codes(found, "error") == []
    heights, crashes = swept(path, SIZE, GRID, 7.0)
    assert crashes == []
    points, shape = cells()
    behind = shapely.contains(box(-30, 0, -GRID, 30), points).reshape(shape)
    np.testing.assert_array_equal(heights[behind], 0.0)
    cleared = shapely.contains(box(GRID, 8, 6.0, 30 - GRID), points).reshape(shape)
    np.testing.assert_allclose(heights[cleared], -6.0)


@pytest.mark.parametrize(
    ("radius", "turn", "width", "distance"),
    [
        (22.0, 270.0, 14.5, 7.0),
        (15.87, 270.0, 10.5, 4.72),
        (20.15, 60.0, 11.36, 5.11),
        (39.25, 60.0, 19.14, 8.61),
    ],
)
def test_a_circular_slot_shrunk_keeps_its_ends(radius, turn, width, distance):
    """What is left lies at radii a to b and, at the radius p, from asin(d / p) behind each end: its area is an integral.

    GEOS alone loses up to a tenth of some of these, at one end.
    """
    sweep = math.radians(turn)
    ends = [np.array([radius * math.cos(t), radius * math.sin(t), 0.0]) for t in (0.0, sweep)]
    (outline,) = strip([Arc(*ends, np.zeros(3), np.array([0.0, 0.0, 1.0]), sweep)], width / 2, (False, False))
    left = grown(polygon_of(outline), -distance, quad_segs=64)
    half = width / 2 - distance
    p = np.linspace(radius - half, radius + half, 10_001)
    area = np.trapezoid(p * (sweep - 2 * np.arcsin(distance / p)), p)
    assert left.area == pytest.approx(area, rel=2e-3)


@pytest.mark.parametrize("ends", list(itertools.product(("RADIUSED", "FLAT"), repeat=2)))
@pytest.mark.parametrize(("width", "turn"), [(14.5, 270.0), (6.0, 180.0)])
def test_circular_slots_are_cut_to_their_ends(width, turn, ends):
    """An arc at a slot's round end was taken the wrong way round where its first step went back by a micrometre."""
    part, diameter = Features(), 14.0 if width > 14.0 else 3.0
    course = part.add("PARTIAL_CIRCULAR_PATH", None, part.size(22), turn)
    profile = part.add("SQUARE_U_PROFILE", None, part.size(width), None, None, None, None)
    closed = [part.add(f"{e}_SLOT_END_TYPE", *((None, None) if e == "FLAT" else ())) for e in ends]
    feature = part.add("SLOT", *part.head(), course, profile, tuple(closed))
    part.mill(
        feature, part.operation("BOTTOM_AND_SIDE_FINISH_MILLING", 3.0, None, None, None, diameter=diameter)
    )
    path, found = part.read()
    assert codes(found, "error") == []
    angle = np.linspace(0.0, math.radians(turn), 1000)
    line = 22.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    region = shapely.LineString(line).buffer(width / 2, quad_segs=128, cap_style="flat")
    for end, place in zip(ends, (line[0], line[-1]), strict=True):
        region |= shapely.Point(place).buffer(width / 2, quad_segs=128) if end == "RADIUSED" else region
    heights, crashes = swept(path, SIZE, GRID, diameter / 2)
    assert crashes == []
    check_cut(heights, region.simplify(1e-3), diameter / 2, 6.0)


def odd_pocket(boundary=None, sizes=(3.0, None, None, None), approach=None, retract=5.0, spindle=-50.0):
    """The diagnostics of a pocket with sizes of no sense; `sizes` are axial and radial depth, and the allowances."""
    part = Features()
    way = None if approach is None else part.add(approach[0], None, *approach[1:])
    plan = part.add("CONTOUR_PARALLEL", 0.4, *STRATEGIES["CONTOUR_PARALLEL"])
    tool, technology = part.tool("T", 8.0), part.technology(spindle=spindle)
    head = (None, None, "op", retract, None, tool, technology, None, None, way, None, plan)
    operation = part.add("BOTTOM_AND_SIDE_FINISH_MILLING", *head, *sizes)
    outline = part.rectangle(60, 40) if boundary is None else boundary(part)
    return part.mill(part.pocket(outline), operation).read()[1]


@pytest.mark.parametrize(
    ("what", "code"),
    [
        ({"sizes": (-1.0, None, None, None)}, "stepnc-range"),
        ({"sizes": (3.0, -1.0, None, None)}, "stepnc-range"),
        ({"sizes": (3.0, None, -1.0, None)}, "stepnc-range"),  # it would cut 1 mm into the wall
        ({"sizes": (3.0, None, None, -2.0)}, "stepnc-range"),
        ({"retract": -3.0}, "stepnc-range"),  # rapid moves would go through the part
        ({"approach": ("PLUNGE_HELIX", 0.0, 5.0)}, "stepnc-geometry"),
        ({"approach": ("PLUNGE_HELIX", -2.0, 5.0)}, "stepnc-geometry"),
        ({"boundary": lambda p: p.rectangle(-60, 40)}, "stepnc-geometry"),
        ({"boundary": lambda p: p.add("CIRCULAR_CLOSED_PROFILE", None, p.size(-50))}, "stepnc-geometry"),
        ({"boundary": lambda p: p.polygon((-20, -20), (20, 20), (20, -20), (-20, 20))}, "stepnc-geometry"),
    ],
)
def test_sizes_of_no_sense_are_refused(what, code):
    assert codes(odd_pocket(**what), "error") == [code]


def test_a_spindle_that_stands_is_warned_of():
    assert codes(odd_pocket(spindle=0.0)) == ["stepnc-no-spindle"]
