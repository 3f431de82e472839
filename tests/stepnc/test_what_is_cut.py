"""What would cut wrong is refused, warned of, or made safe: sizes, ways down, ends of lines, feeds, planes, orphans."""

import numpy as np
import pytest
from click.testing import CliRunner

from cncgen.cli.commands import cli
from cncgen.pipeline.removing import cut
from cncgen.toolpath.record import FeedMode
from tests.stepnc.aim import Aim
from tests.stepnc.building import E, Part, codes, motions, run
from tests.stepnc.featured import ORIGIN, Features, pocket_operation
from tests.stepnc.heightfield import swept

FACE = (60.0, 40.0)


def face(overcut, approach=None, kind="BIDIRECTIONAL_MILLING", overlap=0.25):
    """A face of 60 x 40 mm, 2 mm deep, cut along Y by a tool of 16 mm."""
    part = Features()
    course = part.add("LINEAR_PATH", None, part.size(FACE[1]), part.direction(0, 1, 0))
    width = part.add("LINEAR_PROFILE", None, part.add("NUMERIC_PARAMETER", "", FACE[0], "mm"))
    feature = part.add("PLANAR_FACE", *part.head(2.0), course, width, None, ())
    own = (E("F"), None, E("LEFT"), None) if kind.startswith("BI") else (E("F"), None, E("CLIMB"))
    strategy = part.add(kind, overlap, *own)
    down = part.add(*approach) if approach else None
    head = (None, None, "op", 5.0, None, part.tool("T", 16.0), part.technology(), None)
    operation = part.add("PLANE_ROUGH_MILLING", *head, overcut, down, None, strategy, None, None)
    return part.mill(feature, operation)


def ways_down(path, top=0.0):
    """Steepest way down at the feed below the top, degrees."""
    rows = motions(path)
    starts, ends = path.starts[rows, :3], path.end[rows, :3]
    feed = path.feed_mode[rows] != FeedMode.RAPID
    drop, way = starts[:, 2] - ends[:, 2], np.hypot(*(ends - starts)[:, :2].T)
    into = feed & (drop > 1e-9) & (ends[:, 2] < top - 1e-9)
    return np.degrees(np.arctan2(drop[into], way[into])).max(initial=0.0)


@pytest.mark.parametrize("overcut", [0.0, 5.0, None])
@pytest.mark.parametrize("kind", ["BIDIRECTIONAL_MILLING", "UNIDIRECTIONAL_MILLING"])
def test_facing_leaves_no_spikes_whatever_the_overcut(overcut, kind):
    """Above the middles between lines a round tool is sqrt(R² - (step/2)²) ahead of its axis: none of the face stays."""
    path, found = face(overcut, kind=kind).read()
    assert codes(found, "error") == []
    heights, crashes = swept(path, (160.0, 120.0), 0.5, 8.0)
    i, j = (slice(round(2 * o), round(2 * (o + s))) for o, s in zip(ORIGIN[:2], FACE, strict=True))
    np.testing.assert_allclose(heights[i, j], -2.0)
    assert not crashes


def test_facing_that_begins_above_the_face_goes_down_in_a_ramp():
    assert ways_down(face(0.0).read()[0]) == pytest.approx(10.0, abs=0.5)
    assert ways_down(face(0.0, ("PLUNGE_RAMP", None, 4.0)).read()[0]) == pytest.approx(4.0, abs=0.2)
    assert ways_down(face(None).read()[0]) == 90.0  # beside the material


@pytest.mark.parametrize(
    ("approach", "angle"),
    [
        (None, 10.0),
        (("PLUNGE_RAMP", None, 3.0), 3.0),
        (("PLUNGE_ZIGZAG", None, 5.0, 10.0), 5.0),
        (("PLUNGE_TOOLAXIS", None), 90.0),
    ],
)
def test_a_slot_as_wide_as_its_tool_is_entered_as_asked(approach, angle):
    part = Features()
    profile = part.add("SQUARE_U_PROFILE", None, part.size(8), None, None, None, None)
    ends = ("RADIUSED_SLOT_END_TYPE", "RADIUSED_SLOT_END_TYPE")
    down = part.add(*approach) if approach else None
    operation = part.operation("BOTTOM_AND_SIDE_ROUGH_MILLING", 3.0, None, None, None, approach=down)
    path, found = part.mill(part.slot(profile, ends=ends), operation).read()
    assert codes(found) == []
    assert ways_down(path) == pytest.approx(angle, abs=0.05 * angle)
    bottom = path.end[motions(path)]
    low = bottom[np.isclose(bottom[:, 2], -6.0)]
    np.testing.assert_allclose([low[:, 0].min(), low[:, 0].max()], [ORIGIN[0], ORIGIN[0] + 40.0])


def leaning_slot(angle=20.0, ends=("OPEN", "OPEN"), width=10.0, course=None, second=None):
    """A slot along X whose floor is 6 mm deep and 10 mm wide, cut by a tool of 8 mm in passes of 3 mm."""
    part = Features()
    piece = part.block((0, 0, -20), (100, 80, 0))
    walls = (None, angle, None, angle if second is None else second)
    profile = part.add("SQUARE_U_PROFILE", None, part.size(width), *walls)
    if course is None:
        course = part.add("LINEAR_PATH", None, part.size(100), part.direction(1, 0, 0))
        place = part.placement((0, ORIGIN[1], 0))
    else:
        course, place = course(part), part.placement(ORIGIN)
    kinds = tuple(
        part.add(f"{end}_SLOT_END_TYPE", *((part.size(0),) * 2 if end == "FLAT" else ())) for end in ends
    )
    slot = part.add("SLOT", "f", piece, (), place, part.plane(-6.0), course, profile, kinds)
    return part.mill(slot, pocket_operation(part))


def test_leaning_walls_of_a_slot_are_cut_in_steps(tmp_path):
    """ISO 14649-10: the width is that of the floor, angles are from Z. Two steps of 3 mm, each as wide as the slot at its foot."""
    file = tmp_path / "slot.stp"
    file.write_text(leaning_slot().text())
    out = cut(file, cell_mm=0.1)
    assert [d.code for d in out.findings] == []
    upper = 10 + 2 * 3 * np.tan(np.radians(20))
    assert out.operations[-1].volume_mm3 == pytest.approx(100 * 3 * (upper + 10), rel=5e-3)


def ring(part):
    return part.add("COMPLETE_CIRCULAR_PATH", None, part.size(20))


def short(part):
    return part.add("LINEAR_PATH", None, part.size(30), part.direction(1, 0, 0))


@pytest.mark.parametrize(
    ("ends", "course"), [(("RADIUSED", "OPEN"), short), (("FLAT", "RADIUSED"), short), ((), ring)]
)
def test_ends_and_loops_of_leaning_slots_are_not_gouged(ends, course, tmp_path):
    file = tmp_path / "slot.stp"
    file.write_text(leaning_slot(ends=ends, course=course).text())
    assert [d.code for d in cut(file, cell_mm=0.2).findings] == []


@pytest.mark.parametrize(
    ("slot", "code", "severity"),
    [
        ({"angle": 90.0}, None, None),
        ({"angle": 0.3}, "stepnc-angle", "warning"),
        ({"angle": 60.0}, "stepnc-angle", "warning"),
        ({"angle": 20.0, "second": 10.0}, "stepnc-unsupported", "error"),
        ({"angle": -10.0}, "stepnc-geometry", "error"),
        # A tool of 8 mm in a floor as wide as it.
        ({"width": 8.0}, "stepnc-geometry", "error"),
    ],
)
def test_angles_of_walls_are_told_or_refused(slot, code, severity):
    _, found = leaning_slot(**slot).read()
    told = [c for c in codes(found, severity) if c == code] if code else codes(found, "error")
    assert told == ([code] if code else [])


@pytest.mark.parametrize(("edge", "refused"), [(None, True), (2.0, True), (4.0, False)])
def test_a_round_floor_needs_a_tool_as_round(edge, refused):
    """A slot of 8 mm with a floor round all across: a tool of 8 mm cuts its round away, but a ball."""
    part = Features()
    slot = part.slot(part.add("ROUNDED_U_PROFILE", None, part.size(8)))
    _, found = part.mill(slot, pocket_operation(part, edge=edge)).read()
    assert codes(found, "error") == (["stepnc-geometry"] if refused else [])


def test_an_open_end_within_the_raw_piece_is_told_and_entered_along_the_slot():
    part = Features()
    workpiece = part.block((0, 0, -20), (150, 80, 0))
    profile = part.add("SQUARE_U_PROFILE", None, part.size(8), None, None, None, None)
    course = part.add("LINEAR_PATH", None, part.size(40), part.direction(1, 0, 0))
    place = part.placement(ORIGIN)
    ends = tuple(part.add("OPEN_SLOT_END_TYPE") for _ in range(2))
    slot = part.add("SLOT", "f", workpiece, (), place, part.plane(-6.0), course, profile, ends)
    operation = part.operation("BOTTOM_AND_SIDE_ROUGH_MILLING", 3.0, None, None, None)
    path, found = part.mill(slot, operation).read()
    assert codes(found) == ["stepnc-open-end"]
    assert ways_down(path) < 11.0


def test_a_face_mill_does_not_go_straight_down():
    part = face(0.0, ("PLUNGE_TOOLAXIS", None))
    tool = next(i for i in part.instances if i.keyword == "ENDMILL")
    text = part.text().replace("ENDMILL", "FACEMILL")
    assert tool is not None
    assert "stepnc-plunge" in codes(run(text)[1])
    steep = face(0.0).text().replace("ENDMILL", "FACEMILL")
    assert ways_down(run(steep)[0]) < 2.5


def test_a_notch_narrower_than_the_tool_is_told():
    """A profile of 60 x 40 mm with a notch of 4 mm; one of 12 mm is cut by the tool of 8 mm."""
    for width, told in ((4.0, True), (12.0, False)):
        part = Features()
        h = width / 2
        corners = ((-30, -20), (30, -20), (30, 20), (h, 20), (h, 8), (-h, 8), (-h, 20), (-30, 20))
        profile = part.add("GENERAL_OUTSIDE_PROFILE", *part.head(6.0), None, part.polygon(*corners))
        operation = part.operation("SIDE_FINISH_MILLING", None, None, None)
        found = part.mill(profile, operation).read()[1]
        assert codes(found, "error") == []
        assert ("stepnc-uncut" in codes(found)) == told


@pytest.mark.parametrize(
    ("notch", "told"),
    [
        (((30, 2), (33, 2), (33, -2), (30, -2)), True),  # 4 mm wide and 3 deep
        (
            ((30, 8), (33, 8), (33, -8), (30, -8)),
            False,
        ),  # as deep, and twice as wide as the tool: two corners
        (((30, -20),), False),
        (((60, -20),), False),  # corners of 34 and 146 degrees, which the tool rounds
    ],
)
def test_a_pocket_with_a_notch_narrower_than_its_tool_of_8_mm_is_told(notch, told):
    part = Features()
    corners = [(-30, -20), (-30, 20), (30, 20), *notch]
    corners += [(30, -20)] if len(notch) > 1 else []
    found = part.mill(part.pocket(part.polygon(*corners[::-1])), pocket_operation(part)).read()[1]
    assert codes(found, "error") == []
    assert ("stepnc-uncut" in codes(found)) == told


def test_radial_depths_above_the_diameter_are_refused():
    part = Features()
    operation = pocket_operation(part, radial=9.0)
    path, found = part.mill(part.pocket(part.rectangle(60, 40)), operation).read()
    assert codes(found, "error") == ["stepnc-range"]
    assert not len(motions(path))


def test_a_pocket_deeper_than_the_raw_piece_is_refused():
    part = Features()
    workpiece = part.block((0, 0, -5), (100, 80, 0))
    place, bottom = part.placement(ORIGIN), part.add("PLANAR_POCKET_BOTTOM_CONDITION")
    boundary = part.rectangle(60, 40)
    own = ("f", workpiece, (), place, part.plane(-6.0), (), None, bottom, None, None, boundary)
    found = part.mill(part.add("CLOSED_POCKET", *own), pocket_operation(part)).read()[1]
    assert codes(found, "error") == ["stepnc-depth"]


def test_a_security_plane_below_the_part_is_refused():
    part = Features()
    pocket = part.pocket(part.rectangle(60, 40))
    part.project(part.plan(part.step(pocket_operation(part), pocket, part.plane(-2.0))))
    assert codes(part.read()[1], "error") == ["stepnc-security-plane"]


def test_a_toolpath_without_a_feed_has_that_of_its_operation():
    """The first path has 5 mm/s of its own; the second a technology without a feed: the operation's 20 mm/s count."""
    part = Part()
    own, none = part.technology(0.005), part.technology(None)
    first = part.trajectory(part.polyline((0, 0, 0), (10, 0, 0)), technology=own)
    second = part.trajectory(part.polyline((10, 0, 0), (20, 0, 0)), technology=none)
    part.project(part.plan(part.step(part.freeform(first, second))))
    path, found = part.read()
    assert codes(found) == []
    assert path.feed[motions(path)].tolist() == [5.0, 20.0]


def test_a_feed_of_the_operation_before_is_told():
    """As in the example of ISO 14649-11, whose pocket is milled by a technology without a feed."""
    part = Part()
    first = part.step(part.freeform(part.trajectory(part.polyline((0, 0, 0), (9, 0, 0)))))
    bare = part.technology(feed=None)
    second = part.step(part.freeform(part.trajectory(part.polyline((9, 0, 0), (9, 9, 0))), technology=bare))
    part.project(part.plan(first, second))
    path, found = part.read()
    assert codes(found) == ["stepnc-no-feed"]
    assert path.feed[motions(path)].tolist() == pytest.approx([20.0, 20.0])
    alone = Part()
    alone.project(
        alone.plan(
            alone.step(
                alone.freeform(
                    alone.trajectory(alone.polyline((0, 0, 0), (9, 0, 0))),
                    technology=alone.technology(feed=None),
                )
            )
        )
    )
    assert codes(alone.read()[1], "error") == ["stepnc-no-feed"]


def test_a_feed_of_nothing_is_refused():
    """A motion at 0 mm/min never ends: `check` found no error, and `convert` wrote F0."""
    part = Part()
    still = part.technology(feed=0.0)
    part.project(
        part.plan(
            part.step(part.freeform(part.trajectory(part.polyline((0, 0, 0), (9, 0, 0))), technology=still))
        )
    )
    assert codes(part.read()[1], "error") == ["stepnc-speed"]


@pytest.mark.parametrize("named", [True, False])
def test_several_main_workplans_are_told(named):
    """Two projects, or two workplans without a project, ran one after the other without a word."""
    part = Part()
    for x in (9, 5):
        plan = part.plan(part.step(part.freeform(part.trajectory(part.polyline((0, 0, 0), (x, 0, 0))))))
        if named:
            part.project(plan)
    path, found = part.read()
    assert codes(found, "warning").count("stepnc-several") == 1
    assert path.end[motions(path)][-1].tolist() == [5, 0, 0]


def test_what_no_workplan_holds_is_told():
    part = Part()
    line = part.trajectory(part.polyline((0, 0, 0), (10, 0, 0)))
    part.step(part.freeform(line))
    inner = part.plan(part.step(part.freeform(line)))
    part.project(part.plan(part.step(part.freeform(line))))
    path, found = part.read()
    assert codes(found) == ["stepnc-orphan"] * 3  # a workingstep, a workplan and the workingstep in it
    assert len(motions(path)) == 1
    assert int(inner) in [int(i.id) for i in part.instances]


def test_a_project_that_does_nothing_is_told():
    part = Part()
    part.project(part.plan())
    assert codes(part.read()[1]) == ["stepnc-no-motion"]


@pytest.mark.parametrize("spindle", [0.0, None])
def test_cutting_with_a_standing_spindle_is_told(spindle):
    part = Part()
    line = part.trajectory(part.polyline((0, 0, 0), (10, 0, 0)))
    part.project(part.plan(part.step(part.freeform(line, technology=part.technology(0.02, spindle)))))
    assert codes(part.read()[1]) == ["stepnc-no-spindle"]


@pytest.mark.parametrize(
    ("feed", "spindle", "told"),
    [(0.00004, -50.0, True), (0.00004, -5.0, True), (0.0005, -50.0, False), (0.02, -50.0, False)],
)
def test_feeds_too_slow_to_be_meant_are_told(feed, spindle, told):
    """0.04 mm/s are 0.8 micrometres a turn at 50 turns a second, and hours at any speed."""
    part = Part()
    line = part.trajectory(part.polyline((0, 0, 0), (10, 0, 0)))
    part.project(part.plan(part.step(part.freeform(line, technology=part.technology(feed, spindle)))))
    assert codes(part.read()[1]) == ["stepnc-feed-unit"] * told


def test_warnings_of_check_are_those_of_canon(tmp_path):
    part = Part()
    line = part.trajectory(part.polyline((0, 0, 0), (10, 0, 0)))
    part.project(part.plan(part.step(part.freeform(line, technology=part.technology(0.00004)))))
    file = tmp_path / "slow.stp"
    file.write_text(part.text())
    for command in ("check", "canon"):
        result = CliRunner().invoke(cli, [command, str(file)])
        assert result.exit_code == 0
        assert "stepnc-feed-unit" in result.stderr


def test_a_setup_with_a_fault_leaves_its_workingsteps_to_be_looked_at():
    part = Part()
    line = part.trajectory(part.polyline((0, 0, 0), (10, 0, 0)))
    step = part.step(part.freeform(line, technology=part.technology(-0.02)))
    setup = part.add("SETUP", "s", part.direction(1, 0, 0), None, ())
    part.project(part.plan(step, setup=setup))
    assert {"stepnc-type", "stepnc-speed"} <= set(codes(part.read()[1], "error"))


def placed(aim, items):
    """A plan with a setup whose workpiece is placed by a transformation between two items."""
    file = aim.file
    step, operation = aim.step()
    aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), aim.technology())
    plan = aim.plan(step)
    setup, workpiece = (file.add("PRODUCT_DEFINITION", n, "", None, None) for n in ("setup", "part"))
    process = file.add("PRODUCT_DEFINITION_PROCESS", "setup", "", plan, "")
    file.add("PROCESS_PRODUCT_ASSOCIATION", "", "", setup, process)
    relation = file.add("MACHINING_SETUP_WORKPIECE_RELATIONSHIP", "", "", "", setup, workpiece)
    shape = file.add("PRODUCT_DEFINITION_SHAPE", "", "", relation)
    change = file.add("ITEM_DEFINED_TRANSFORMATION", "", "", *items(file))
    link = file.add_complex(
        ("REPRESENTATION_RELATIONSHIP", ("", "", None, None)),
        ("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION", (change,)),
        ("SHAPE_REPRESENTATION_RELATIONSHIP", ()),
    )
    file.add("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION", link, shape)
    return aim.read(plan)


def test_a_transformation_with_an_item_unset_is_from_the_origin():
    z, x = np.array([0, 0, 1.0]), np.array([1.0, 0, 0])
    path, found = placed(Aim(), lambda f: (None, f.placement(np.array([1.0, 2.0, 3.0]), z, x)))
    assert codes(found, "error") == []
    assert "stepnc-placement" in codes(found)
    assert len(motions(path)) == 1


def test_the_unit_count_is_a_number():
    aim = Aim()
    exponents = aim.file.add("DIMENSIONAL_EXPONENTS", 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    count = aim.file.add_complex(("CONTEXT_DEPENDENT_UNIT", ("count",)), ("NAMED_UNIT", (exponents,)))
    step, operation = aim.step()
    technology = aim.technology(spindle=-50.0, feed=0.1, unit=count, name="feed per tooth")
    aim.path(operation, aim.polyline((0, 0, 0), (5, 0, 0)), technology)
    assert "stepnc-unit" not in codes(aim.read(aim.plan(step))[1], "error")
    assert "stepnc-unit" in codes(aim.read(aim.plan(step))[1], "warning")


def test_a_fault_of_a_size_says_what_is_allowed():
    part = Features()
    bottom = part.add("CONICAL_HOLE_BOTTOM", 200.0, None)
    hole = part.add("ROUND_HOLE", *part.head(6.0), part.size(30), None, bottom)
    program = part.mill(hole, pocket_operation(part)).text()
    result = CliRunner().invoke(cli, ["check", "-", "--language", "stepnc"], input=program)
    assert "is 200 degrees; it must lie between 0 and 160" in result.stderr
