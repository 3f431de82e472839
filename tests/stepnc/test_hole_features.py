"""Round holes: drilled, countersunk, pecked, bored, tapped, milled; in patterns and in steps."""

import io
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

from cncgen.diagnostics import UsageError
from cncgen.gcode import read
from cncgen.stepnc import gcode_lines
from cncgen.stepnc.features.holes import tip_length
from cncgen.stepnc.model import CuttingTool
from cncgen.toolpath.record import FeedMode, Kind
from tests.stepnc.building import WHOLE, E, codes, motions
from tests.stepnc.featured import GRID, ORIGIN, Features, cells, depths, hole_part, pocket_operation, tops


def test_drilling_goes_deeper_by_the_point():
    """118 degrees: the edge stands 31 degrees from the plane across; 5 mm tan 31 = 3.004303."""
    moves, path = depths(hole_part("DRILLING", body="TWIST_DRILL", tip=31.0))
    assert moves[-3:] == [(5.0, True), (-23.004303, False), (5.0, False)]
    assert path.feed[motions(path)[-1]] == 10.0


@pytest.mark.parametrize(
    ("tip", "around", "length"),
    [
        (0.0, 0.0, 2.0),
        (30.0, 0.0, 5 * math.tan(math.pi / 6) + 2 / math.sqrt(3)),
        (0.0, 30.0, 2 * math.cos(math.pi / 6) / math.sqrt(3)),
        (None, None, 0.0),
    ],
)
def test_a_rounded_edge_makes_the_point_longer(tip, around, length):
    """An arc of 2 mm touches edge and side r / tan (i/2) from where they meet at the inner angle i: 90, 120, 120 degrees."""
    degrees = [None if a is None else math.radians(a) for a in (tip, around)]
    drill = CuttingTool(1, "drill", "twist drill", 10.0, 2, degrees[0], 2.0, circumference_angle=degrees[1])
    assert tip_length(drill) == pytest.approx(length)


def test_a_feed_per_tooth_is_reduced_as_a_feed_is():
    """0.1 mm a tooth, 2 teeth, 10 turns a second are 2 mm/s; at half the speed and a quarter of the feed 0.5 mm/s."""
    part = Features()
    hole = part.add("ROUND_HOLE", *part.head(20.0), part.size(10), None, part.add("THROUGH_BOTTOM_CONDITION"))
    technology = part.technology(None, -10.0, feedrate_per_tooth=0.1)
    drill = part.tool("T", 10.0, body="TWIST_DRILL")
    plan = part.add("DRILLING_TYPE_STRATEGY", 0.5, 0.25, 2.0, None, None, None)
    head = (None, None, "op", 5.0, None, drill, technology, None)
    path, found = part.mill(hole, part.add("DRILLING", *head, *(None,) * 5, plan)).read()
    assert codes(found, "error") == []
    feeds = [float(path.feed[k]) for k in motions(path) if path.feed_mode[k] == FeedMode.SPEED]
    assert feeds[:2] == pytest.approx([0.5, 2.0])
    assert [e.values["speed_rpm"] for e in path.events if e.name == "spindle"] == [300.0, 600.0]


def test_drilling_with_overcut_dwell_and_feed_on_retract():
    moves, path = depths(hole_part("DRILLING", drilling=(2.0, None, None, 0.5, 3.0)))
    assert moves[-2:] == [(-22.0, False), (5.0, False)]
    assert [e.dwell_s for e in path.events if e.name == "dwell"] == [0.5]
    assert path.feed[motions(path)[-1]] == 30.0


def test_percents_for_ratios_are_taken_with_a_warning():
    part = hole_part("DRILLING", strategy=(75.0, 50.0, 2.0, 50.0, 75.0, 8.0))
    path, found = part.read()
    assert codes(found) == ["stepnc-ratio"] * len(codes(found))
    speeds = [e.values["speed_rpm"] for e in path.events if e.name == "spindle"]
    assert speeds == [450.0, 600.0, 300.0]


def test_centre_drilling_and_countersinking():
    moves, _ = depths(
        hole_part("CENTER_DRILLING", drilling=(None, 3.0, None, None, None), body="CENTER_DRILL")
    )
    assert moves[-2:] == [(-3.0, False), (5.0, False)]
    moves, _ = depths(hole_part("COUNTER_SINKING", body="COUNTERSINK", tip=45.0))
    assert moves[-2:] == [(-5.0, False), (5.0, False)]


@pytest.mark.parametrize("back", [1.0, 0.0])
def test_pecking(back):
    """First 8, then 5 a step: 8, 13, 18, 20; chips broken by 1 mm or cleared at the retract plane."""
    moves, _ = depths(hole_part("MULTISTEP_DRILLING", back, 8.0, 5.0, None))
    lows = [z for z, rapid in moves if not rapid and z < 0 and z not in (-7.0, -12.0, -17.0)]
    assert lows == [-8.0, -13.0, -18.0, -20.0]
    assert ((-7.0, False) in moves) == (back > 0)
    assert ((5.0, True) in moves[3:]) == (back == 0)


def test_boring_and_reaming_stop_the_spindle_if_asked():
    for kind in ("BORING", "REAMING"):
        moves, path = depths(hole_part(kind, E("T"), None, None))
        assert moves[-2:] == [(-20.0, False), (5.0, False)]
        assert [e.values["direction"] for e in path.events if e.name == "spindle"] == [1, 0]


def test_a_test_cut_is_left_out_with_a_warning():
    path, found = hole_part("BORING", E("F"), 2.0, None).read()
    assert codes(found) == ["stepnc-testcut"]
    assert path.end[motions(path)][:, 2].min() == -20.0


def test_tapping_is_in_step_with_the_spindle():
    """10 mm/s at 10 turns a second are 1 mm a turn: G33.1 Z-20 K1, as rs274 -g prints it, and no spindle warning."""
    part = hole_part("TAPPING", E("F"), body="TAP")
    moves, path = depths(part)
    assert moves[-2:] == [(-20.0, False), (5.0, False)]
    assert [e.values["pitch_mm"] for e in path.events if e.name == "synchronise"] == [1.0, None]
    calls = [line.split(maxsplit=1)[1] for line in part.calls()]
    k = calls.index("START_SPEED_FEED_SYNC(1.000000,0)")
    assert calls[k + 1 : k + 3] == ["RIGID_TAP(50.0000, 40.0000, -20.0000)", "STOP_SPEED_FEED_SYNCH()"]
    assert codes(part.read()[1]) == []
    lines = list(gcode_lines([path]))
    assert [line for line in lines if line.startswith("G33.1")] == ["G33.1 Z-20 K1"]
    again = read(io.BytesIO("\n".join(lines).encode()), "tap.ngc", WHOLE)
    (back,) = again.chunks()
    np.testing.assert_allclose(back.end[motions(back)][-2:], path.end[motions(path)][-2:])
    np.testing.assert_allclose(back.feed[motions(back)][-2:], 10.0)


@pytest.mark.parametrize(
    ("feed", "told"),
    [(0.005, False), (0.0125, False), (0.002, False), (0.001, True), (0.06, True)],
)
def test_a_pitch_that_no_thread_of_10_mm_has_is_told(feed, told):
    """At 10 turns a second 0.5, 1.25 (M10) and 0.2 mm (the finest pitch of ISO 261); 0.1 mm is none, and 6 mm neither."""
    found = hole_part("TAPPING", E("F"), body="TAP", feed=feed).read()[1]
    assert ("stepnc-pitch" in codes(found)) == told


def taken(text, control="linuxcnc"):
    """Return the toolpath of G-code that says nothing wrong."""
    source = read(io.BytesIO(text.encode()), "tap.ngc", replace(WHOLE, dialect=control))
    (path,) = source.chunks()
    assert [d.code for d in source.diagnostics if d.severity != "note"] == []
    return path


@pytest.mark.parametrize(("spindle", "cycle"), [("M3", "G84"), ("M4", "G74")])
def test_a_tap_for_fanuc_is_m29_and_a_cycle(spindle, cycle):
    """1 mm a turn at S600 are F600; read back, motions and pitches are those of G33.1."""
    path = taken(f"G21 G17 G90 G0 X50 Y40 Z5\nS600 {spindle}\nG33.1 Z-20 K1\nG1 X60 F100\nM2\n")
    lines = list(gcode_lines([path], control="fanuc"))
    k = lines.index("M29 S600")
    assert lines[k + 1 : k + 3] == [f"G94 G99 {cycle} X50. Y40. Z-20. R5. F600", "G80"]
    back = taken("\n".join(lines), "fanuc")
    moved, moves = motions(back)[-3:], motions(path)[-3:]
    np.testing.assert_allclose(back.end[moved], path.end[moves])
    np.testing.assert_allclose(back.feed[moved], path.feed[moves])
    pitches = [[e.values["pitch_mm"] for e in p.events if e.name == "synchronise"] for p in (path, back)]
    assert pitches == [[1.0, None], [1.0, None]]


def test_the_tap_of_a_feature_is_a_cycle_of_fanuc(tmp_path, cncgen):
    source, out = tmp_path / "tap.stp", tmp_path / "tap.nc"
    source.write_text(hole_part("TAPPING", E("F"), body="TAP").text())
    cncgen("convert", source, "-o", out, "--for", "fanuc")
    assert "G94 G99 G84 X50. Y40. Z-20. R5. F600" in out.read_text()


@pytest.mark.parametrize(("seconds", "word"), [("0.25", "X0.25"), ("2", "X2.")])
def test_a_dwell_for_fanuc_is_seconds(seconds, word):
    """P is ms there, and X without a point is too; lengths without one are least increments, 0.05 mm of X50 (B-64304EN)."""
    path = taken(f"G21 G17 G90 G0 X50 Y40 Z5\nG4 P{seconds}\nG3 X0 I-25 F300\nM2\n")
    lines = list(gcode_lines([path], control="fanuc"))
    assert f"G4 {word}" in lines
    assert "G0 X50. Y40. Z5." in lines
    assert "G94 G3 X0. Y40. Z5. I-25. J0. F300" in lines
    back = taken("\n".join(lines), "fanuc")
    assert [e.dwell_s for e in back.events if e.name == "dwell"] == [float(seconds)]


def test_the_lead_of_g33_is_f_for_fanuc():
    """K is LinuxCNC's word (B-64304EN, threading: F is the lead); the feed in mm a minute is written anew after it."""
    path = taken("G21 G17 G90 G0 X0 Y0 Z5\nS600 M3\nG1 Z4 F300\nG33 Z-20 K1.5\nG1 X60 F300\nM2\n")
    lines = list(gcode_lines([path], control="fanuc"))
    k = lines.index("G33 Z-20. F1.5")
    assert lines[k + 1] == "G94 G1 X60. F300"
    back = taken("\n".join(lines), "fanuc")
    assert next(e.values.get("pitch_mm") for e in back.events if e.name == "synchronise") == 1.5
    assert back.end[-1].tolist() == [60.0, 0.0, -20.0]


def test_a_tap_along_x_is_refused_for_fanuc():
    path = taken("G21 G17 G90 G0 X0 Y0 Z5\nS600 M3\nG33.1 X-20 K1\nM2\n")
    with pytest.raises(UsageError, match="along Z"):
        list(gcode_lines([path], control="fanuc"))


def test_a_helix_of_two_turns_is_lines_for_fanuc():
    """FANUC's arcs have no P."""
    path = taken("G21 G17 G90 G0 X0 Y0 Z5\nG3 I10 Z1 P2 F100\nM2\n")
    assert any(line.endswith("P2 F100") for line in gcode_lines([path]))
    lines = list(gcode_lines([path], control="fanuc"))
    assert not any(line.startswith(("G2 ", "G3 ", "G94 G3")) for line in lines)
    assert sum(line.startswith(("G1", "G94 G1")) for line in lines) > 100


@pytest.mark.parametrize(
    ("kind", "own", "hole", "wide", "more", "code"),
    [
        ("DRILLING", (), 10.0, 12.0, {}, "stepnc-tool-size"),
        ("REAMING", (None, None, None), 10.0, 10.5, {}, "stepnc-tool-size"),
        ("BORING", (E("F"), None, None), 10.0, 11.0, {}, "stepnc-tool-size"),
        ("DRILLING", (), 10.0, 10.0, {"drilling": (None, 25.0, None, None, None)}, "stepnc-depth"),
        ("DRILLING", (), 10.0, 10.0, {"drilling": (2.0, None, None, None, None)}, "stepnc-depth"),
    ],
)
def test_a_tool_larger_than_its_hole_and_a_depth_below_its_end_are_refused(kind, own, hole, wide, more, code):
    part = Features()
    blind = part.add("FLAT_HOLE_BOTTOM")
    feature = part.add("ROUND_HOLE", *part.head(20.0), part.size(hole), None, blind)
    head = (None, None, "op", 5.0, None, part.tool("T", wide), part.technology(0.01, -10.0), None)
    part.mill(feature, part.add(kind, *head, *more.get("drilling", (None,) * 5), None, *own))
    path, found = part.read()
    assert codes(found, "error") == [code]
    assert not len(motions(path))


@pytest.mark.parametrize("bottom", ["CONICAL_HOLE_BOTTOM", "THROUGH_BOTTOM_CONDITION"])
def test_a_cutting_depth_measured_at_the_tip_is_told_by_its_size(bottom):
    """A real file: 10 mm drill of 20 degrees, hole 10 mm deep, cutting_depth 10 + 5 tan 20 = 11.8199 mm; the tip goes that deep."""
    part = Features()
    values = (140.0, None) if bottom.startswith("CON") else ()
    feature = part.add("ROUND_HOLE", *part.head(10.0), part.size(10.0), None, part.add(bottom, *values))
    tool = part.tool("T", 10.0, body="TWIST_DRILL", tip=20.0)
    head = (None, None, "op", 5.0, None, tool, part.technology(0.01, -10.0), None)
    part.mill(feature, part.add("DRILLING", *head, None, 11.819851171331011, None, None, None, None))
    path, found = part.read()
    assert codes(found) == ["stepnc-depth"]
    assert path.end[motions(path)][:, 2].min() == pytest.approx(-11.81985, abs=1e-4)


def test_a_cutting_depth_below_the_raw_piece_is_refused():
    part = Features()
    workpiece = part.block((0, 0, -15), (100, 80, 0))
    place = part.placement(ORIGIN)
    through = part.add("THROUGH_BOTTOM_CONDITION")
    hole = part.add("ROUND_HOLE", "f", workpiece, (), place, part.plane(-15), part.size(10), None, through)
    head = (None, None, "op", 5.0, None, part.tool("T", 10), part.technology(0.01, -10.0), None)
    part.mill(hole, part.add("DRILLING", *head, None, 30.0, None, None, None, None))
    assert codes(part.read()[1], "error") == ["stepnc-depth"]


@pytest.mark.parametrize(
    ("feed", "spindle", "code"), [(None, -10.0, "stepnc-missing"), (0.01, None, "stepnc-missing")]
)
def test_tapping_without_a_feed_or_a_speed_is_refused(feed, spindle, code):
    part = Features()
    through = part.add("THROUGH_BOTTOM_CONDITION")
    hole = part.add("ROUND_HOLE", *part.head(20.0), part.size(6), None, through)
    tap, technology = part.tool("T", 6.0, body="TAP"), part.technology(feed, spindle)
    head = (None, None, "op", 5.0, None, tap, technology, None)
    part.mill(hole, part.add("TAPPING", *head, *(None,) * 5, None, E("F")))
    assert code in codes(part.read()[1], "error")


def test_operations_of_holes_are_for_round_ones():
    part = Features()
    pocket = part.pocket(part.rectangle(60, 40))
    head = (None, None, "op", 5.0, None, part.tool("T", 6.0, body="TWIST_DRILL"), part.technology(), None)
    part.mill(pocket, part.add("DRILLING", *head, *(None,) * 5, None))
    assert codes(part.read()[1], "error") == ["stepnc-unsupported"]


def drilled_pattern(keyword, own, base=(0, 0, 0)):
    """Return the middles of the holes of a pattern, and the diagnostics; `own` makes its attributes."""
    part = Features()
    through = part.add("THROUGH_BOTTOM_CONDITION")
    hole = part.add(
        "ROUND_HOLE", "h", None, (), part.placement(base), part.plane(-5), part.size(6), None, through
    )
    pattern = part.add(keyword, *part.head(None)[:4], hole, *own(part))
    tool = part.tool("T", 6.0)
    drilling = (None, None, "op", 5.0, None, tool, part.technology(), None, *(None,) * 6)
    part.mill(pattern, part.add("DRILLING", *drilling))
    path, found = part.read()
    bottoms = path.end[motions(path)]
    return bottoms[np.abs(bottoms[:, 2] + 5) < 1e-9][:, :2] - ORIGIN[:2], codes(found)


def rows(moved=lambda part: (), omitted=lambda part: ()):
    """Return what makes the attributes of two rows of two, 15 mm apart, the rows 10 mm."""
    return lambda part: (
        part.size(15),
        part.direction(1, 0, 0),
        2,
        2,
        part.size(10),
        part.direction(0, 1, 0),
        moved(part),
        omitted(part),
    )


def circle(count, step=90.0, moved=(), omitted=(), diameter=24, turn=None):
    """Return what makes the attributes of a circular pattern."""
    return lambda part: (
        step,
        count,
        tuple(part.add("CIRCULAR_OFFSET", *m) for m in moved),
        tuple(part.add("CIRCULAR_OMIT", k) for k in omitted),
        None if diameter is None else part.size(diameter),
        turn,
    )


ROUND = [(12, 0), (0, 12), (-12, 0), (0, -12)]


@pytest.mark.parametrize(
    ("keyword", "own", "base", "places"),
    [
        ("RECTANGULAR_PATTERN", rows(), (0, 0, 0), [(0, 0), (15, 0), (0, 10), (15, 10)]),
        ("RECTANGULAR_PATTERN", rows(), (1, 2, 0), [(1, 2), (16, 2), (1, 12), (16, 12)]),
        ("CIRCULAR_PATTERN", circle(4), (0, 0, 0), ROUND),
        # Its diameter may be given too where the base feature stands on the circle.
        ("CIRCULAR_PATTERN", circle(4), (12, 0, 0), ROUND),
        ("CIRCULAR_PATTERN", circle(4, diameter=None, turn=0.0), (12, 0, 0), ROUND),
        (
            "GENERAL_PATTERN",
            lambda part: ((part.placement((1, 2, 0)), part.placement((3, 4, 0))),),
            (9, 9, 0),
            [(1, 2), (3, 4)],
        ),
    ],
)
def test_patterns_repeat_the_feature(keyword, own, base, places):
    bottoms, found = drilled_pattern(keyword, own, base)
    assert found == []
    np.testing.assert_allclose(bottoms, places, atol=1e-9)


def test_copies_left_out_and_moved():
    """ISO 14649-10, circular_pattern: number_of_feature is what is left, and the omitted ones add to the largest index."""
    bottoms, found = drilled_pattern("CIRCULAR_PATTERN", circle(3, omitted=(2,)))
    assert found == []
    np.testing.assert_allclose(bottoms, [ROUND[0], ROUND[2], ROUND[3]], atol=1e-9)
    bottoms, found = drilled_pattern("CIRCULAR_PATTERN", circle(3, omitted=(1,), moved=((45.0, 4),)))
    assert found == []
    np.testing.assert_allclose(bottoms, [ROUND[1], ROUND[2], (12 / 2**0.5, -12 / 2**0.5)], atol=1e-9)
    changed = rows(
        lambda part: (part.add("RECTANGULAR_OFFSET", part.direction(0, 1, 0), 3.0, 2, 1),),
        lambda part: (part.add("RECTANGULAR_OMIT", 1, 2),),
    )
    bottoms, found = drilled_pattern("RECTANGULAR_PATTERN", changed)
    assert found == []
    np.testing.assert_allclose(bottoms, [(0, 0), (0, 13), (15, 10)], atol=1e-9)


@pytest.mark.parametrize(
    "own",
    [
        circle(3, omitted=(0,)),
        circle(3, omitted=(5,)),
        circle(2, omitted=(2, 2)),
        circle(4, moved=((10.0, 5),)),
        circle(4, diameter=20),
    ],
)
def test_a_pattern_that_contradicts_itself_is_refused(own):
    """Copies that it has not, and a diameter that is not the one that its base feature stands on."""
    assert drilled_pattern("CIRCULAR_PATTERN", own, (12, 0, 0))[1] == ["stepnc-geometry"]


def test_copies_of_more_than_a_turn_are_warned_of():
    bottoms, found = drilled_pattern("CIRCULAR_PATTERN", circle(5))
    np.testing.assert_allclose(bottoms, [*ROUND, ROUND[0]], atol=1e-9)
    assert found == ["stepnc-geometry"]


@pytest.mark.parametrize(("turn", "along"), [(None, 90.0), (0.0, 0.0), (30.0, 30.0)])
def test_how_the_copies_of_a_circle_are_turned(turn, along):
    """Slots of 10 mm along X: base_feature_rotation is the angle from one copy to the next; without it they go round."""
    part = Features()
    course = part.add("LINEAR_PATH", None, part.size(10), part.direction(1, 0, 0))
    profile = part.add("SQUARE_U_PROFILE", None, part.size(6), None, None, None, None)
    round_ends = tuple(part.add("RADIUSED_SLOT_END_TYPE") for _ in range(2))
    slot = part.add("SLOT", "s", None, (), part.placement(), part.plane(-2), course, profile, round_ends)
    pattern = part.add("CIRCULAR_PATTERN", *part.head(None)[:4], slot, *circle(2, turn=turn)(part))
    head = (None, None, "op", 5.0, None, part.tool("T", 6.0), part.technology(), None, None, None, None, None)
    part.mill(pattern, part.add("BOTTOM_AND_SIDE_ROUGH_MILLING", *head, None, None, None, None))
    path, found = part.read()
    assert codes(found, "error") == []
    cut = path.end[motions(path)]
    cut = cut[np.abs(cut[:, 2] + 2) < 1e-9][:, :2] - ORIGIN[:2]
    angle = np.radians(along)
    ends = [(0.0, 12.0), (10.0 * np.cos(angle), 12.0 + 10.0 * np.sin(angle))]
    for end in ends:
        assert np.linalg.norm(cut - end, axis=1).min() < 1e-6


def test_a_counterbored_hole_takes_the_element_that_fits_the_tool():
    part = Features()
    small = part.add(
        "ROUND_HOLE",
        "s",
        None,
        (),
        part.placement(),
        part.plane(-20),
        part.size(6),
        None,
        part.add("THROUGH_BOTTOM_CONDITION"),
    )
    large = part.add(
        "ROUND_HOLE",
        "l",
        None,
        (),
        part.placement(),
        part.plane(-4),
        part.size(11),
        None,
        part.add("FLAT_HOLE_BOTTOM"),
    )
    feature = part.add("COUNTERBORE_HOLE", *part.head(None)[:4], (small, large))
    operation = part.add(
        "DRILLING", None, None, "op", 5.0, None, part.tool("T", 11.0), part.technology(), None, *(None,) * 6
    )
    moves, _ = depths(part.mill(feature, operation))
    assert moves[-2:] == [(-4.0, False), (5.0, False)]


@pytest.mark.parametrize("taper", ["DIAMETER_TAPER", "ANGLE_TAPER"])
def test_a_tapered_hole_is_milled_in_steps(taper):
    """From 40 mm at the top to 28 mm at 6 mm below: 45 degrees."""
    part = Features()
    change = part.add(taper, part.size(28) if taper == "DIAMETER_TAPER" else 45.0)
    hole = part.add("ROUND_HOLE", *part.head(), part.size(40), change, part.add("FLAT_HOLE_BOTTOM"))
    operation = part.operation("BOTTOM_AND_SIDE_FINISH_MILLING", 0.5, 4.0, None, None)
    part.mill(hole, operation)
    heights, found = part.heights(4.0)
    assert codes(found) == ["stepnc-uncut"]
    x, row = tops(heights)
    wall = -np.clip(20 - np.abs(x), 0, 6)
    assert (row >= wall - GRID).all()
    assert (row <= wall + 0.5 + GRID).all()


def test_a_countersunk_hole_is_drilled_and_countersunk():
    """The drill takes the straight element, the countersink the tapered one: 6 mm of radius at 45 degrees, 6 mm deep."""
    for kind, body, diameter, tip, bottom in (
        ("DRILLING", "TWIST_DRILL", 6.0, None, -20.0),
        ("COUNTER_SINKING", "COUNTERSINK", 20.0, 45.0, -6.0),
    ):
        part = Features()
        through = part.add("THROUGH_BOTTOM_CONDITION")
        place = part.placement()
        straight = part.add("ROUND_HOLE", "s", None, (), place, part.plane(-20), part.size(6), None, through)
        taper = part.add("ANGLE_TAPER", 45.0)
        cone = part.add("ROUND_HOLE", "c", None, (), place, part.plane(-3), part.size(12), taper, through)
        feature = part.add("COUNTERSUNK_HOLE", *part.head(None)[:4], (straight, cone))
        tool = part.tool("T", diameter, body=body, tip=tip)
        part.mill(
            feature, part.add(kind, None, None, "op", 5.0, None, tool, part.technology(), None, *(None,) * 6)
        )
        moves, _ = depths(part)
        assert moves[-2:] == [(bottom, False), (5.0, False)]


def test_a_thread_is_tapped_to_its_own_depth():
    part = Features()
    hole = part.add(
        "ROUND_HOLE", "h", None, (), part.placement(), part.plane(-20), part.size(5), None,
        part.add("THROUGH_BOTTOM_CONDITION"),
    )  # fmt: skip
    own = (None, (hole,), E("T"), None, None, None, 6.0, None, None, None)
    thread = part.add("CATALOGUE_THREAD", *part.head(12.0), *own)
    head = (None, None, "op", 5.0, None, part.tool("T", 6.0, body="TAP"), part.technology(0.01, -10.0), None)
    part.mill(thread, part.add("TAPPING", *head, *(None,) * 6, E("F")))
    moves, path = depths(part)
    assert moves[-2:] == [(-12.0, False), (5.0, False)]
    assert [e.values["pitch_mm"] for e in path.events if e.name == "synchronise"] == [1.0, None]


# Round bottoms: of a hole of 30 mm and 6 mm depth of its wall


BOTTOMS = {
    # 90 degrees: as deep as the way from the wall.
    "cone": (("CONICAL_HOLE_BOTTOM", 90.0, None), lambda r: 6 + np.maximum(15 - r, 0)),
    # 17 mm radius: its centre is 8 mm above the end of the wall.
    "sphere": (("SPHERICAL_HOLE_BOTTOM", 17.0), lambda r: 6 - 8 + np.sqrt(np.maximum(17**2 - r**2, 0))),
    # A corner of 4 mm about the circle of 11 mm, 2 mm deep.
    "corner": (
        ("FLAT_WITH_RADIUS_HOLE_BOTTOM", 4.0),
        lambda r: 2 + np.sqrt(np.maximum(16 - np.maximum(r - 11, 0) ** 2, 0)),
    ),
}


def round_bottom(shape, diameter=8.0, edge=None, kind="finish", **more):
    """Return a part with a hole of that bottom, milled in passes of 3 mm, less where the bottom narrows."""
    part = Features()
    (keyword, *sizes), surface = BOTTOMS[shape]
    values = [part.size(v) if keyword != "CONICAL_HOLE_BOTTOM" and v else v for v in sizes]
    hole = part.add("ROUND_HOLE", *part.head(), part.size(30), None, part.add(keyword, *values))
    operation = pocket_operation(part, finish=kind == "finish", radial=2.0, diameter=diameter, **more)
    tool = part.instances[operation - 1].parts[0].parameters[5]
    if edge is not None:
        body = part.instances[tool - 1].parts[0].parameters[1]
        size = part.instances[body - 1].parts[0].parameters[0]
        part.fill(size, "MILLING_TOOL_DIMENSION", diameter, None, None, None, edge, None, None)
    return part.mill(hole, operation), surface


@pytest.mark.parametrize("shape", list(BOTTOMS))
def test_round_bottoms_are_milled_in_steps_above_them(shape):
    """What a flat tool leaves lies above the bottom everywhere, and by no more than a pass where the tool gets to."""
    part, surface = round_bottom(shape)
    heights, found = part.heights(4.0)
    assert set(codes(found)) <= {"stepnc-uncut"}
    points, size = cells()
    r = np.hypot(shapely.get_x(points), shapely.get_y(points)).reshape(size)
    inside = r < 15 - GRID
    wanted = -surface(np.maximum(r - GRID, 0))  # the deepest within a cell
    assert (heights[inside] >= wanted[inside] - 1e-6).all()
    reached = inside & (r > 4 + GRID)
    step = (surface(np.array([4.0]))[0] - 2) / 8 + GRID * 1.5
    assert (heights[reached] + surface(r)[reached] <= step).all()
    np.testing.assert_array_equal(heights[r > 15 + GRID], 0.0)


@pytest.mark.parametrize("shape", list(BOTTOMS))
@pytest.mark.parametrize("edge", [0.0, 1.5, 3.0])
def test_a_rounded_tool_touches_a_round_bottom_and_no_more(shape, edge):
    """The cutter's outline, turned about its axis, against the bottom's: it stays inside, and touches."""
    part, surface = round_bottom(shape, diameter=6.0, edge=edge)
    path, found = part.read()
    assert codes(found, "error") == []
    rows = motions(path)
    place = path.end[rows][:, :2] - (50.0, 40.0)
    depth, axis = -path.end[rows, 2], np.linalg.norm(place, axis=1)
    t = np.linspace(0, math.pi / 2, 400)
    out, up = 3.0 - edge + edge * np.sin(t), edge - edge * np.cos(t)
    left = [
        surface(a + out) - (d - up)
        for a, d in zip(axis, depth, strict=True)
        if d > 6.5 or (shape == "corner" and d > 3)
    ]
    assert min(x.min() for x in left) == pytest.approx(0.0, abs=2e-3)


def test_an_allowance_lies_over_a_round_bottom():
    """With 0.5 mm on the bottom the lowest point is 0.5 mm higher than without."""
    low = []
    for allowance in (None, 0.5):
        part, _ = round_bottom("sphere", kind="rough", bottom=allowance, side=0.0)
        path, _ = part.read()
        low.append(path.end[motions(path), 2].min())
    assert low[1] - low[0] == pytest.approx(0.5, abs=1e-9)


@pytest.mark.parametrize(
    ("bottom", "expected"),
    [
        (("FLAT_HOLE_BOTTOM",), ["stepnc-tip"]),
        (("CONICAL_HOLE_BOTTOM", 90.0, None), ["stepnc-tip"]),
        (("CONICAL_HOLE_BOTTOM", 120.0, None), []),
        (("CONICAL_HOLE_BOTTOM", 2.0943951023931953, None), ["stepnc-angle"]),
        (("CONICAL_HOLE_BOTTOM", 0.5235987755982988, None), ["stepnc-angle"]),
        (("CONICAL_HOLE_BOTTOM", 120.4, None), []),
        (("CONICAL_HOLE_BOTTOM", 119.4, None), ["stepnc-tip"]),
        (("THROUGH_BOTTOM_CONDITION",), []),
    ],
)
def test_a_drills_point_that_is_not_the_bottoms(bottom, expected):
    """The drill's edges stand at 30 degrees: a point of 120, half a degree more or less; UFSC's files give both alike, in radians."""
    part = Features()
    hole = part.add("ROUND_HOLE", *part.head(), part.size(10), None, part.add(*bottom))
    tool = part.tool("T", 10.0, body="TWIST_DRILL", tip=30.0)
    drilling = part.add("DRILLING", None, None, "op", 5.0, None, tool, part.technology(), None, *(None,) * 6)
    _, found = part.mill(hole, drilling).read()
    assert codes(found) == expected


# Threads that are milled: M12 x 1.75 into a hole of 10.2 mm


def milled_thread(
    keyword="BOTTOM_AND_SIDE_FINISH_MILLING", count=1 / 1.75, unit="1/mm", hand=None, diameter=8.0
):
    part = Features()
    hole = part.add(
        "ROUND_HOLE", "h", None, (), part.placement(), part.plane(-20), part.size(10.2), None,
        part.add("THROUGH_BOTTOM_CONDITION"),
    )  # fmt: skip
    number = part.add("NUMERIC_PARAMETER", "threads", count, unit)
    hand = hand and part.add("DESCRIPTIVE_PARAMETER", "hand", hand)
    thread = part.add(
        "CATALOGUE_THREAD",
        *part.head(14.0),
        None,
        (hole,),
        E("T"),
        None,
        None,
        None,
        12.0,
        number,
        hand,
        None,
    )
    tool = part.tool("T", diameter, body="THREAD_MILL")
    head = (None, None, "op", 5.0, None, tool, part.technology(0.01, -10.0), None)
    own = (None,) * {"SIDE_FINISH_MILLING": 7}.get(keyword, 8)
    own = (*own[:6], E("F")) if keyword == "THREAD_DRILLING" else own
    part.mill(thread, part.add(keyword, *head, *own))
    return part


@pytest.mark.parametrize(
    ("keyword", "count", "unit"),
    [
        ("BOTTOM_AND_SIDE_FINISH_MILLING", 1 / 1.75, "1/mm"),
        ("SIDE_FINISH_MILLING", 25.4 / 1.75, "per inch"),
        ("THREAD_DRILLING", 1 / 1.75, "1/mm"),
    ],
)
def test_a_thread_is_milled_along_a_helix_of_its_pitch(keyword, count, unit):
    """Right-handed: up against the clock, 2 mm from the axis for a tool of 8 mm, 1.75 mm a turn over 14 mm less both leads."""
    path, found = milled_thread(keyword, count, unit).read()
    assert codes(found) == []
    rows = [k for k in motions(path) if path.kind[k] == Kind.ARC]
    assert len(rows) == 3
    k = rows[1]
    start, end, sweep = path.starts[k], path.end[k], path.arcs.sweep[path.curve[k]]
    centre = path.arcs.centre[path.curve[k]]
    assert np.hypot(*(start - centre)[:2]) == pytest.approx(2.0)
    assert path.arcs.normal[path.curve[k]][2] == pytest.approx(1.0)
    assert end[2] - start[2] == pytest.approx(14.0 - 1.75 / 2)
    assert (end[2] - start[2]) / sweep * 2 * math.pi == pytest.approx(1.75)
    assert path.starts[rows[0]][2] == -14.0
    np.testing.assert_allclose(path.end[rows[2]], [*centre[:2], 0.0], atol=1e-9)


def test_a_left_handed_thread_goes_down_against_the_clock():
    path, found = milled_thread(hand="left hand").read()
    assert codes(found) == []
    k = [k for k in motions(path) if path.kind[k] == Kind.ARC][1]
    assert path.end[k][2] - path.starts[k][2] == pytest.approx(-14.0 + 1.75 / 2)
    assert path.arcs.normal[path.curve[k]][2] == pytest.approx(1.0)


@pytest.mark.parametrize(("diameter", "code"), [(10.5, "stepnc-tool-size"), (8.0, None)])
def test_a_thread_mill_must_fit_its_hole(diameter, code):
    found = milled_thread(diameter=diameter).read()[1]
    assert codes(found, "error") == ([code] if code else [])


def test_a_tap_takes_the_pitch_of_its_thread():
    """20 threads an inch are 1.27 mm a turn; the feed of 10 mm/s at 10 turns a second says 1 mm, which is remarked."""
    part = Features()
    hole = part.add(
        "ROUND_HOLE", "h", None, (), part.placement(), part.plane(-20), part.size(5.1), None,
        part.add("THROUGH_BOTTOM_CONDITION"),
    )  # fmt: skip
    number = part.add("NUMERIC_PARAMETER", "threads", 20.0, "per inch")
    own = (None, (hole,), E("T"), None, None, None, 6.35, number, None, None)
    thread = part.add("CATALOGUE_THREAD", *part.head(12.0), *own)
    head = (None, None, "op", 5.0, None, part.tool("T", 6.35, body="TAP"), part.technology(0.01, -10.0), None)
    part.mill(thread, part.add("TAPPING", *head, *(None,) * 6, E("F")))
    path, found = part.read()
    assert codes(found) == ["stepnc-pitch"]
    assert [e.values["pitch_mm"] for e in path.events if e.name == "synchronise"] == [
        pytest.approx(1.27),
        None,
    ]


def test_a_milled_thread_in_a_block_is_cut_without_a_finding(tmp_path, cncgen):
    """Material removal knows that the thread is wider than its hole, and that its ridges stay."""
    part = Features()
    block, place = part.block((0, 0, -20), (100, 80, 0)), part.placement(ORIGIN)
    through = part.add("THROUGH_BOTTOM_CONDITION")
    hole = part.add("ROUND_HOLE", "h", block, (), place, part.plane(-20), part.size(10.2), None, through)
    number = part.add("NUMERIC_PARAMETER", "threads", 1 / 1.75, "1/mm")
    own = (None, (hole,), E("T"), None, None, None, 12.0, number, None, None)
    thread = part.add("CATALOGUE_THREAD", "t", block, (), place, part.plane(-14), *own)
    head = (None, None, "op", 5.0, None)
    technology = part.technology(0.005, -10.0)
    drill = part.tool("D", 10.2, body="TWIST_DRILL", tip=30.0)
    mill = part.tool("T", 8.0, body="THREAD_MILL")
    operations = [
        part.add("DRILLING", *head, drill, technology, None, 2.0, *(None,) * 5),
        part.add("BOTTOM_AND_SIDE_FINISH_MILLING", *head, mill, technology, None, *(None,) * 8),
    ]
    plane = part.plane(30)
    steps = [
        part.add("MACHINING_WORKINGSTEP", "ws", plane, f, o, None)
        for f, o in zip((hole, thread), operations, strict=True)
    ]
    part.project(part.plan(*steps))
    program = tmp_path / "thread.stp"
    program.write_text(part.text())
    done = cncgen("check", program)
    assert done.returncode == 0, done.stderr
    assert b"[cut-" not in done.stdout + done.stderr
