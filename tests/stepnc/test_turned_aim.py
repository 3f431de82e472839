"""Turned features of AP238 are the same work as those of ISO 14649-12."""

import io

import numpy as np
import pytest

from cncgen.stepnc import read
from tests.stepnc.building import WHOLE, codes, motions, run
from tests.stepnc.turned_aim import TurnedAim
from tests.stepnc.turning_parts import Turned


def told(text):
    """Return the diagnostics of a file."""
    program = read(io.BytesIO(text.encode()), "t.stp", WHOLE)
    list(program.chunks())
    return list(program.diagnostics)


def same(aim, iso):
    """Compare the motions of two files, and return their path."""
    (a, found), (b, expected) = run(aim.whole()), run(iso.whole())
    assert codes(found) == codes(expected) == []
    assert len(motions(a)) == len(motions(b)) > 2
    for name in ("kind", "feed_mode"):
        assert getattr(a, name)[motions(a)].tolist() == getattr(b, name)[motions(b)].tolist()
    for name in ("starts", "end", "feed"):
        np.testing.assert_allclose(getattr(a, name)[motions(a)], getattr(b, name)[motions(b)], atol=1e-9)
    return a


def test_facing():
    aim, iso = TurnedAim(50, 100, 3.5), Turned(50, 100, 3.5)
    ways = ("unidirectional", (2.0, 1.0), {"lift_height": 0.7})
    aim.turn("FACING", "roughing", aim.face(25.0), strategy=ways, allowance=0.3, nose=0.8)
    strategy = iso.ways(depths=(2.0, 1.0), lift=0.7)
    iso.turn("FACING_ROUGH", iso.face(25), iso.turning_tool(0.8), strategy, 0.3)
    same(aim, iso)


@pytest.mark.parametrize("detail", ["roughing", "finishing"])
def test_contouring_of_diameters_end_to_end(detail):
    aim, iso = TurnedAim(), Turned()
    # From Z 0 down: a cone from 20 to 30 mm, then 36 mm.
    features = [aim.diameter(30.0, 20.0, -20.0, taper=20.0), aim.diameter(36.0, 30.0, -50.0)]
    ways, allowance = ("unidirectional", (2.0,), {}), 0.4 if detail == "roughing" else 0.0
    aim.turn("CONTOURING", detail, *features, strategy=ways, allowance=allowance, nose=0.4)
    both = (iso.diameter(30, 20, 0, taper=20), iso.diameter(36, 30, -20))
    iso.turn(f"CONTOURING_{detail[:-3].upper()}", both, iso.turning_tool(0.4), iso.ways(), allowance)
    same(aim, iso)


def test_contouring_along_a_curve():
    aim, iso = TurnedAim(100, 100), Turned(100, 100)
    points = [(10.0, 0.0), (20.0, -20.0), (20.0, -40.0)]
    aim.turn("CONTOURING", "finishing", aim.revolution(*points), nose=0.8)
    iso.turn("CONTOURING_FINISH", iso.revolution(*points), iso.turning_tool(0.8))
    same(aim, iso)


@pytest.mark.parametrize("corner", [None, 0.5])
def test_grooving(corner):
    aim, iso = TurnedAim(20, 60), Turned(20, 60)
    ways = ("multistep grooving", (1.0,), {"retract_distance": 0.5})
    groove = aim.groove(7.0, 4.0, -12.0, corner)
    aim.turn("GROOVING", "roughing", groove, tool=("groove", 2.0, 8.0), strategy=ways, allowance=0.1)
    strategy = iso.add("MULTISTEP_GROOVING_STRATEGY", None, True, (1.0,), None, None, None, 0.5)
    iso.turn("GROOVING_ROUGH", iso.groove(7, 4, -12, corner), iso.grooving_tool(2.0, 8.0), strategy, 0.1)
    same(aim, iso)


def test_threading_goes_in_step_with_the_spindle():
    aim = TurnedAim(20, 60)
    base = aim.diameter(20.0, 20.0, -20.0)
    thread = aim.thread(base, 20.0, 0.5, z=-20.0)
    aim.turn("THREADING", "finishing", thread, tool=("thread", 2.0), per_turn=2.0)
    path, found = aim.read_whole()
    assert codes(found) == []
    assert [e.values["pitch_mm"] for e in path.events if e.name == "synchronise"] == [2.0, None]
    # The height of a metric thread (ISO 68-1): 17/24 of sqrt(3)/2 of the pitch.
    deepest = path.end[motions(path)][:, 0].min()
    assert deepest == pytest.approx(10 - 17 / 24 * np.sqrt(3) / 2 * 2.0)


def test_the_direction_into_the_material_says_which_face_is_faced():
    """A left-handed tool, and no raw piece: the example of ISO 14649-12, annex D."""
    aim = TurnedAim(raw=False)
    aim.turn("FACING", "finishing", aim.face(20.0, 160.0, side=np.array([0, 0, -1.0])), hand="left", nose=0.4)
    path, found = aim.read_whole()
    assert codes(found) == []
    assert path.end[motions(path)][:, 2].min() == pytest.approx(160.0)


def test_diameters_against_z_are_taken_as_the_standards_own_example_means_them():
    """Annex D of ISO 14649-12, J.7 of ISO 10303-238: a cone of 40 to 80 mm placed at Z 160, a cylinder of 80 at Z 110."""
    aim = TurnedAim(90, 165, 165)
    features = [aim.diameter(40.0, 50.0, 160.0, taper=80.0), aim.diameter(80.0, 110.0, 110.0)]
    aim.turn("CONTOURING", "finishing", *features, nose=0.0, hand="left")
    path, found = aim.read_whole()
    # Its tools are left-handed, and the profile rises against Z.
    assert sorted(codes(found)) == ["stepnc-depth", "stepnc-feed-direction", "stepnc-placement"]
    fed = path.end[motions(path)][:, [0, 2]]
    for corner in ([20.0, 160.0], [40.0, 110.0], [40.0, 0.0]):
        assert np.abs(fed - corner).sum(axis=1).min() < 1e-6


def test_one_diameter_lies_where_the_raw_piece_is():
    aim = TurnedAim(50, 100, 0)
    aim.turn("CONTOURING", "finishing", aim.diameter(40.0, 30.0, 0.0), nose=0.4)
    path, found = aim.read_whole()
    assert codes(found) == ["stepnc-placement"]
    assert path.end[motions(path)][:, 2].min() == pytest.approx(-30.0, abs=0.5)


def test_the_trailing_edge_is_that_of_the_cutting_edge_and_its_included_angle():
    """A leading edge at 95 degrees and 55 between the edges leave 30: a slope of 40 degrees down the feed is refused."""
    points = [(20.0, 0.0), (20.0, -10.0), (20 - 10 * np.tan(np.radians(40)), -20.0)]
    aim = TurnedAim()
    aim.turn("CONTOURING", "finishing", aim.revolution(*points), nose=0.4, edge=(95.0, 55.0))
    (found,) = told(aim.whole())
    assert found.code == "stepnc-tool-size"
    assert "trailing edge has 30" in found.message


def test_a_fine_number_of_threads_is_one_an_inch():
    aim = TurnedAim(20, 60)
    thread = aim.thread(aim.diameter(20.0, 20.0, -20.0), 20.0, 10.0, z=-20.0)
    aim.turn("THREADING", "finishing", thread, tool=("thread", 2.54), per_turn=2.54)
    path, found = aim.read_whole()
    assert codes(found) == ["stepnc-unit"]
    assert len(motions(path)) > 2


REFUSED = {
    "knurling": ("KNURLING", "", ("turn",), "no toolpath can be made for knurling of an outer diameter"),
    "cutting off": (
        "GROOVING",
        "cutting in",
        ("groove", 2.0, 10.0),
        "no toolpath can be made for cutting in",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_turned_is_named(name):
    keyword, detail, tool, text = REFUSED[name]
    aim = TurnedAim(20, 60)
    aim.turn(keyword, detail, aim.diameter(20.0, 20.0, -20.0), tool=tool)
    (found,) = [d for d in told(aim.whole()) if d.severity == "error"]
    assert found.code == "stepnc-unsupported"
    assert found.message.partition(": ")[2].startswith(text) or text in found.message


def test_a_cutting_speed_of_a_crawl_is_remarked():
    """2.5 mm/s, which the standard's own example has: 2.5 m/s is meant."""
    part = Turned()
    speed = ("CONST_CUTTING_SPEED", 0.0025, -50.0)
    part.turn("FACING_FINISH", part.face(25), part.turning_tool(0.4), speed=speed)
    assert codes(run(part.whole())[1]) == ["stepnc-speed-unit"]
