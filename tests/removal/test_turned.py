"""Turning a bar: volumes of solids of revolution in closed form, and faults of the cut."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.removal.bars import TurnedCutting, bar_of
from cncgen.removal.record import Insert
from cncgen.removal.stock import Stock
from cncgen.removal.surfaces import ROUND_FEW, mesh_of
from tests.removal.paths import event, line, path_of
from tests.stepnc.turning_parts import Turned

SHAFT = Path(__file__).parents[2] / "programs" / "stepnc" / "shaft.stp"


def bar(diameter=50.0, low=-100.0, high=0.0):
    half = diameter / 2
    return Stock("cylinder", np.array([-half, -half, low]), np.array([half, half, high]))


def turn(tool, start, *moves, stock=None, target=None, cell=0.01):
    turning = event("spindle", speed_rpm=500.0, direction=-1)
    path = path_of(start, event("tool", tool=tool.name), turning, *moves)
    return TurnedCutting(bar_of(stock or bar(), cell), "t.nc", target, {tool.name: tool}).run([path])


def codes(removal):
    return [f.code for f in removal.findings]


def removed(removal):
    return removal.stock.raw_volume - removal.stock.volume


@pytest.mark.parametrize("nose", [0.0, 0.8])
def test_a_cylinder(nose):
    """Radius 25 to 20 over 60 mm; the nose leaves a fillet whose volume follows from Pappus."""
    out = turn(Insert("T", nose), (20, 0, 5), line(20, 0, -60), line(30, 0, -60))
    area, reach = nose**2 * (1 - math.pi / 4), nose * (1 - 2 / (3 * (4 - math.pi))) if nose else 0.0
    fillet = 2 * math.pi * area * (20 + nose - reach)
    assert removed(out) == pytest.approx(math.pi * (25**2 - 20**2) * 60 - fillet, rel=1e-4)
    assert codes(out) == []


def test_few_rings_are_the_surface_of_a_bar():
    """A cylinder, a shoulder and a cone with corners of 90 sides: within half a cell, five rings instead of thousands."""
    out = turn(Insert("T", 0.0), (20, 0, 5), line(20, 0, -30), line(22, 0, -30), line(25, 0, -60))
    vertices, triangles = mesh_of(out.stock, joined=True)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    sides = ROUND_FEW / (2 * math.pi) * math.sin(2 * math.pi / ROUND_FEW)
    volume = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)
    assert volume == pytest.approx(sides * out.stock.volume, rel=1e-3)
    assert len(triangles) < 20 * 2 * ROUND_FEW < len(mesh_of(out.stock)[1])


def test_a_face():
    out = turn(Insert("T", 0.8), (30, 0, -1.5), line(-0.8, 0, -1.5))
    assert removed(out) == pytest.approx(math.pi * 25**2 * 1.5, rel=1e-3)
    assert out.stock.radius[out.stock.z > -1.5].max() == 0.0


@pytest.mark.parametrize("left", [False, True])
def test_a_cone(left):
    """From radius 15 at one end to 25: h pi (R² - (R² + R r + r²) / 3)."""

    def z(v):
        return -100 - v if left else v

    tool = Insert("T", 0.0, left=left)
    out = turn(tool, (15 - 2, 0, z(2 * 2)), line(25, 0, z(-20)))
    assert removed(out) == pytest.approx(math.pi * 20 * (25**2 - (25**2 + 25 * 15 + 15**2) / 3), rel=2e-3)


def test_a_nose_rolls_down_a_cone():
    """A tool that falls by 30 degrees leaves the cone beside its nose: nose (1 / cos a - 1) + tan a nose above the corner's line."""
    a, nose = math.radians(30.0), 1.2
    out = turn(
        Insert("T", nose, trailing=math.radians(50.0)),
        (20, 0, 5),
        line(20, 0, -10),
        line(20 - 20 * math.tan(a), 0, -30),
    )
    z = np.array([-15.0, -20.0, -25.0])
    centre = 20 + nose + (z - nose + 10) * math.tan(a)
    left = np.interp(z, out.stock.z, out.stock.radius)
    np.testing.assert_allclose(left, centre - nose / math.cos(a), atol=2e-3)


def test_a_ball_end():
    """A hemisphere of 25 mm turned by a pointed tool: of the cylinder it leaves two thirds."""
    tool = Insert("T", 0.0)
    angles = np.linspace(0, math.pi / 2, 400)
    out = turn(tool, (0, 0, 0), *(line(25 * math.sin(a), 0, 25 * math.cos(a) - 25) for a in angles))
    assert removed(out) == pytest.approx(math.pi * 25**3 / 3, rel=2e-3)


def test_a_groove():
    out = turn(Insert("G", 0.0, width=4.0), (30, 0, -20), line(18, 0, -20), line(30, 0, -20, True))
    assert removed(out) == pytest.approx(math.pi * (25**2 - 18**2) * 4, rel=1e-6)
    assert codes(out) == []


def test_a_drilled_core():
    """A drill of 10 mm with 118 degrees, 30 mm deep at the tip."""
    from cncgen.removal.cutters import cutter_of_option

    drill = cutter_of_option("D=drill:10,118")
    path = path_of(
        (0.0, 0.0, 5.0),
        event("tool", tool="D"),
        event("spindle", direction=1, speed_rpm=1.0),
        line(0, 0, -30),
    )
    out = TurnedCutting(bar_of(bar(), 0.01), "t.nc", None, {"D": drill}).run([path])
    cone = 5 / math.tan(math.radians(59))
    assert removed(out) == pytest.approx(math.pi * 25 * (30 - cone) + math.pi * 25 * cone / 3, rel=1e-3)


def test_rapid_into_the_bar_is_named():
    out = turn(Insert("T", 0.4), (30, 0, -20), line(22, 0, -20, True))
    assert codes(out) == ["cut-rapid"]
    assert out.findings[0].values["depth_mm"] == pytest.approx(3.0, abs=1e-3)
    assert out.findings[0].values["place_mm"][2] == pytest.approx(-20, abs=1.0)


def test_a_standing_work_is_named():
    path = path_of(
        (30.0, 0.0, -20.0), event("tool", tool="T"), event("spindle", direction=0), line(22, 0, -20)
    )
    out = TurnedCutting(bar_of(bar(), 0.02), "t.nc", None, {"T": Insert("T", 0.4)}).run([path])
    assert codes(out) == ["cut-spindle"]


class Cylinder:
    """A part of radius 20 in front of Z -50."""

    def floor(self, z):
        return np.where(z > -50, 20.0, np.inf)

    demanded = floor

    def owner(self, z):
        return "", 1


def test_gouges_and_what_is_left():
    tool = Insert("T", 0.0)
    deep = turn(tool, (19.9, 0, 5), line(19.9, 0, -30), line(30, 0, -30), target=Cylinder())
    assert codes(deep) == ["cut-gouge", "cut-left"]
    assert deep.findings[0].values["depth_mm"] == pytest.approx(0.1)
    assert deep.findings[0].values["volume_mm3"] == pytest.approx(math.pi * (20**2 - 19.9**2) * 30, rel=1e-3)
    assert deep.findings[1].values["volume_mm3"] == pytest.approx(math.pi * (25**2 - 20**2) * 20, rel=1e-3)
    whole = turn(tool, (20, 0, 5), line(20, 0, -50), line(30, 0, -50), target=Cylinder())
    assert codes(whole) == []


def test_the_trailing_edge_gouges_where_the_contour_falls():
    """A tool with 20 degrees behind its corner that falls by 45 degrees cuts the flank behind it."""
    moves = (line(22, 0, 5), line(22, 0, -20), line(17, 0, -25), line(17, 0, -40), line(30, 0, -40))
    volumes = [
        removed(turn(Insert("T", 0.0, trailing=math.radians(a)), (30, 0, 5), *moves)) for a in (60.0, 20.0)
    ]
    assert volumes[1] > volumes[0] + 100


def shaft(*operations, **raw):
    part = Turned(50, 100, 1.0, **raw)
    tool = part.turning_tool(0.8, trailing=30.0)
    feature = part.revolution((8, 0), (10, -2), (10, -20), (15, -20), (20, -40), (20, -50))
    each = {
        "face": ("FACING_ROUGH", part.face(25), tool, part.ways(depths=(1.0,)), 0.2),
        "face finish": ("FACING_FINISH", part.face(25), tool),
        "rough": ("CONTOURING_ROUGH", feature, tool, part.ways(depths=(3.0, 2.0)), 0.4),
        "finish": ("CONTOURING_FINISH", feature, part.turning_tool(0.4, name="T5")),
        "groove": ("GROOVING_ROUGH", part.groove(7, 4, -12), part.grooving_tool(2.0), None, 0.1),
        "groove finish": ("GROOVING_FINISH", part.groove(7, 4, -12, 1.0), part.grooving_tool(2.0, nose=0.2)),
    }
    for name in operations or each:
        part.turn(*each[name])
    return part.whole()


@pytest.mark.parametrize("block", [False, True])
def test_a_shaft_is_turned_whole(tmp_path, cncgen, block):
    """Nothing is gouged, met at rapid or left; the volume is that of cone, cylinders and groove."""
    program = tmp_path / "shaft.stp"
    program.write_text(shaft(block=block))
    done = cncgen(
        "cut",
        program,
        "--report",
        tmp_path / "r.json",
        "-o",
        tmp_path / "r.stl",
        "--picture",
        tmp_path / "r.png",
    )
    assert done.returncode == 0, done.stderr.decode()
    assert "cut-" not in done.stderr.decode()
    left = json.loads((tmp_path / "r.json").read_text())["volume_mm3"]

    def cone(a, b, h):
        return math.pi * h * (a * a + a * b + b * b) / 3

    radius2 = 2 * 25**2 if block else 25**2
    whole = (
        cone(8, 10, 2) + math.pi * 100 * 18 + cone(15, 20, 20) + math.pi * 400 * 10 + math.pi * radius2 * 49
    )
    assert left == pytest.approx(whole - math.pi * (100 - 49) * 4, rel=1e-3)
    from cncgen.removal.stock import read_stl

    corners = read_stl(str(tmp_path / "r.stl"))
    volume = float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)
    assert volume == pytest.approx(left, rel=2e-3)


def test_check_cuts_what_is_turned(tmp_path, cncgen):
    """A roughing of the contour without finishing leaves its allowance, which no feature forbids; a groove alone is right."""
    program = tmp_path / "shaft.stp"
    program.write_text(shaft("face", "face finish", "rough"))
    done = cncgen("check", program)
    assert done.returncode == 0, done.stderr.decode()
    assert "cut-" not in done.stderr.decode()


def test_turning_tools_go_along_to_ap238(tmp_path, cncgen):
    """Nose, width and trailing edge: what is cut of the bar is the same by operation."""
    program, other = tmp_path / "shaft.stp", tmp_path / "other.stp"
    program.write_text(shaft())
    assert cncgen("convert", program, "-o", other).returncode == 0
    reports = []
    for name in (program, other):
        assert cncgen("cut", name, "--report", tmp_path / "r.json").returncode == 0
        reports.append(json.loads((tmp_path / "r.json").read_text()))
    volumes = [[o["removed_mm3"] for o in r["operations"]] for r in reports]
    assert volumes[1] == pytest.approx(volumes[0], rel=1e-4)


def test_g_code_of_a_lathe(tmp_path, cncgen):
    """A bar turned to radius 20 by G-code with X as a radius, the tool given as an option."""
    program = tmp_path / "t.nc"
    program.write_text("G21 G18 G90 G8 T1 M6 M4 S500 F200\nG0 X20 Z5\nG1 Z-60\nX30\nG0 X22 Z-70\nM2\n")
    done = cncgen(
        "cut",
        program,
        "--stock",
        "cylinder:0,0,50,-100,0",
        "--tool",
        "1=turn:0.8,30",
        "--report",
        tmp_path / "r.json",
    )
    assert done.returncode == 1
    assert "cut-rapid" in done.stderr.decode()


@pytest.mark.parametrize(
    ("text", "options", "rings"),
    [
        ("G98 T0101\nG97 S500 M3\nG1 X40 Z5 F200\nZ-60\nM30\n", ["--dialect", "fanuc-lathe"], True),
        ("G94 T1 M6\nG96 D3000 S200 M3\nG1 X20 Z5 F200\nZ-60\nM2\n", [], True),
        ("G20\nG94 T1 M6\nG96 D3000 S600 M3\nG1 X1 Z0.2 F20\nZ-2\nM2\n", [], True),
        ("G94 T1 M6\nS500 M3\nG1 X20 Z5 F200\nZ-60\nM2\n", ["-m", "lathe.toml"], True),
        ("G94 T1 M6\nS500 M3\nG1 X20 Z5 F200\nZ-60\nM2\n", [], False),
        ("G94 T1 M6\nG96 D3000 S200 M3\nG1 X20 Y3 Z5 F200\nZ-60\nM2\n", [], False),
    ],
    ids=["dialect", "G96", "G96 in inches", "machine", "mill", "moves Y"],
)
def test_the_work_of_a_lathe_is_turned_whatever_is_known_of_its_tools(tmp_path, cncgen, text, options, rings):
    """A tool of 10 mm cuts a groove on a mill: on a lathe it was milled as well, into a bar that stood."""
    (tmp_path / "t.nc").write_text("G21 G18 G90\n" + text)
    limits = "{max_velocity_mm_s = 100, max_acceleration_mm_s2 = 1e3, max_jerk_mm_s3 = 1e4}"
    (tmp_path / "lathe.toml").write_text(f"[axes]\nx = {limits}\nz = {limits}\n")
    bar = ["--stock", "cylinder:0,0,50,-100,0", "--tool", "1=flat:10", "--tool", "0101=flat:10"]
    done = cncgen("cut", "t.nc", *bar, *options)
    said = done.stderr.decode()
    assert ("removed 0.0 of" in said and "rings" in said) is rings
    assert ("moves beside the axis of the bar" in said) is rings


@pytest.mark.parametrize("seed", range(12))
def test_random_shafts(seed, tmp_path):
    """Steps, cones and roundings that rise from the free end: roughed, finished, cut; no gouge, no rapid, nothing left."""
    from cncgen.pipeline.removing import cut

    rng = np.random.default_rng(seed)
    points = [(float(rng.uniform(3, 10)), 0.0)]
    for _ in range(int(rng.integers(2, 7))):
        r, z = points[-1]
        step = float(rng.uniform(2, 12))
        kind = rng.integers(3)
        rise = float(rng.uniform(0.5, 4)) if kind else 0.0
        points.append((r + rise, z - (0.0 if kind == 1 else step)))
    part = Turned(2 * points[-1][0] + float(rng.uniform(1, 12)), 120, float(rng.uniform(0, 3)))
    tool = part.turning_tool(float(rng.choice([0.0, 0.4, 0.8])))
    ways = part.ways(depths=(float(rng.uniform(0.5, 4)),))
    feature = part.revolution(*points)
    part.turn("FACING_ROUGH", part.face(part.bar[0] / 2), tool, ways, 0.0)
    part.turn("CONTOURING_ROUGH", feature, tool, ways, float(rng.choice([0.0, 0.3])))
    part.turn("CONTOURING_FINISH", feature, tool)
    program = tmp_path / "shaft.stp"
    program.write_text(part.whole())
    removal = cut(str(program))
    assert codes(removal) == []


def test_work_that_is_turned_in_several_setups_is_refused(monkeypatch):
    """A bar is cut where it stands first: what a second chuck turns would be cut at the wrong end."""
    from cncgen.pipeline import removing

    monkeypatch.setattr(removing, "clampings_of", lambda program: {1: None, 2: None})
    monkeypatch.setattr(removing, "_setups", lambda toolpaths: 2)
    with pytest.raises(UsageError, match="turns its work in 2 setups"):
        removing.cut(SHAFT)


def test_a_left_handed_tool_faces_the_front_and_turns_a_profile_that_rises_against_z(tmp_path, cncgen):
    """The tools of ISO 14649-12, annex D: it stands beside the face as a right-handed one does, and gouges nothing."""
    part = Turned(90, 165, 165)
    tool = part.turning_tool(0.0, hand="LEFT")
    part.turn("FACING_ROUGH", part.face(45, 160), tool, part.ways(depths=(3.0,)), 0.5)
    part.turn("FACING_FINISH", part.face(45, 160), tool)
    feature = part.revolution((20, 160), (40, 110), (40, 0))
    part.turn("CONTOURING_ROUGH", feature, tool, part.ways(depths=(3.0,)), 0.5)
    part.turn("CONTOURING_FINISH", feature, tool)
    program = tmp_path / "annex_d.stp"
    program.write_text(part.whole())
    done = cncgen("cut", program, "--report", tmp_path / "r.json")
    assert done.returncode == 0, done.stderr.decode()
    assert "cut-" not in done.stderr.decode()
    left = json.loads((tmp_path / "r.json").read_text())["volume_mm3"]
    assert left == pytest.approx(math.pi * (1600 * 110 + 50 * (400 + 800 + 1600) / 3), rel=1e-3)
