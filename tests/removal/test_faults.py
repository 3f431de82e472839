"""What removal names: rapids in stock, standing and wrong-way spindles, gouges, shanks, holders, what is left."""

import json
from collections import Counter

import numpy as np
import pytest

from cncgen.cli.app import run as command
from cncgen.diagnostics import UsageError
from cncgen.pipeline.removing import cut, cut_toolpaths
from cncgen.removal.cutters import cutter_of_option
from cncgen.removal.stock import box, read_stl
from cncgen.removal.surfaces import mesh_of, stl_bytes
from tests.removal.paths import event, line, path_of
from tests.stepnc.building import E
from tests.stepnc.featured import ORIGIN, Features, pocket_operation
from tests.stepnc.test_what_is_cut import face

BOX = box((0, 0, -20), (40, 30, 0))


def codes(removal):
    return [d.code for d in removal.findings]


def run(*moves, tool="flat:8", target=None, start=(-20.0, 15.0, 5.0)):
    cutters = {"*": cutter_of_option(f"*={tool}")}
    return cut_toolpaths([path_of(start, *moves)], BOX, "t.nc", cutters, target, 0.2)


class Flat:
    """A part that is a block as high as `height` for X above 20, and lower than all else."""

    def __init__(self, height):
        self.height = height

    def floor(self, x, y):
        return np.where(x > 20.0, self.height, -20.0)

    def demanded(self, x, y):
        return np.full(x.shape, np.inf)


def test_a_rapid_into_stock_is_named_with_line_place_depth_and_volume():
    """3 mm deep from the left edge of the block, x = 0, to x = 20 with the tool's front round at 24."""
    found = run(line(-20, 15, -3), line(20, 15, -3, rapid=True)).findings
    assert [d.code for d in found] == ["cut-rapid"]
    assert found[0].span.line == 2
    assert found[0].values["depth_mm"] == pytest.approx(3.0)
    assert found[0].values["volume_mm3"] == pytest.approx(3 * (20 * 8 + np.pi * 16 / 2), rel=0.01)
    assert found[0].severity == "error"


def test_a_rapid_where_the_tool_has_cut_already_is_none():
    assert codes(run(line(-20, 15, -3), line(20, 15, -3), line(-20, 15, -3, rapid=True))) == []


def test_a_rapid_above_the_stock_is_none():
    assert codes(run(line(-20, 15, 0.0), line(60, 15, 0.0, rapid=True))) == []


@pytest.mark.parametrize(("direction", "code"), [(0, "cut-spindle"), (-1, "cut-spindle-direction")])
def test_a_cut_with_the_spindle_standing_or_turning_wrong(direction, code):
    found = run(event("spindle", speed_rpm=100.0, direction=direction), line(-20, 15, -3), line(20, 15, -3))
    assert codes(found) == [code]


def test_a_standing_spindle_is_told_where_it_first_cuts(tmp_path, cncgen):
    """M5 stands between cuts; lines 8 and 9 cut with a standing spindle, 10 with it turning, and 12 stands again."""
    lines = "G21 G90|T1 M6|S3000 M3|G0 X-10 Y20 Z5|G0 Z-2|G1 X20 F600|M5|G1 X30|X40|M3 X50|M5|X60|M2"
    program = tmp_path / "stands.ngc"
    program.write_text(lines.replace("|", "\n"))
    done = cncgen("cut", program, "--stock", "box:0,0,-20,100,40,0", "--tool", "1=flat:10", "--json")
    (found,) = [f for f in map(json.loads, done.stderr.splitlines()) if f["code"] == "cut-spindle"]
    assert (found["line"], found["values"]["motions"]) == (8, 3)
    assert "3 motions to line 12" in found["message"]
    assert found["values"]["volume_mm3"] == pytest.approx(30 * 10 * 2, rel=0.01)


def test_a_gouge_of_the_part():
    """The part is 2 mm below the top; the tool is 3 mm deep: 1 mm over its width from x = 20 on."""
    found = run(line(-20, 15, -3), line(30, 15, -3), target=Flat(-2.0)).findings
    assert [d.code for d in found] == ["cut-gouge"]
    assert found[0].values["depth_mm"] == pytest.approx(1.0)
    assert found[0].values["volume_mm3"] == pytest.approx(10 * 8 + np.pi * 16 / 2, rel=0.02)
    assert codes(run(line(-20, 15, -2), line(30, 15, -2), target=Flat(-2.0))) == []


def test_a_cut_deeper_than_the_cutting_edge():
    found = run(line(-20, 15, -6), line(20, 15, -6), tool="flat:8;length=5").findings
    assert [d.code for d in found] == ["cut-shank"]
    assert found[0].values["depth_mm"] == pytest.approx(1.0)


@pytest.mark.parametrize(("drop", "codes_of_it"), [(4.0, []), (7.0, ["cut-plunge"]), (90.0, ["cut-plunge"])])
def test_a_tool_that_is_hollow_at_its_end_goes_down_in_a_ramp(drop, codes_of_it):
    """At 4 degrees it may, at 7 and straight down it may not; on the way back nothing stands below it."""
    tool = event("tool", tool="face mill", diameter_mm=8.0, steepest_deg=5.0)
    away = 2.0 / np.tan(np.radians(drop)) if drop < 90 else 0.0
    found = run(tool, line(5, 15, 0), line(5 + away, 15, -2), line(5, 15, -2)).findings
    assert [d.code for d in found] == codes_of_it
    assert all(d.values["depth_mm"] == pytest.approx(2.0, rel=0.2) for d in found)


def test_a_shank_thicker_than_the_tool_and_a_holder_that_touches():
    deep = (line(-20, 15, -6), line(20, 15, -6))
    assert "cut-shank" in codes(run(*deep, tool="flat:8;length=5;shank=12"))
    found = run(*deep, tool="flat:8;holder=30,4").findings
    assert [d.code for d in found] == ["cut-holder"]
    assert found[0].values["depth_mm"] == pytest.approx(2.0)
    assert codes(run(*deep, tool="flat:8;holder=30,10")) == []


def test_a_program_without_stock_is_told_where_it_cuts(tmp_path, capsys):
    program = tmp_path / "p.ngc"
    program.write_text("G21 G90 S1000 M3\nG0 X-10 Y15 Z5\nG1 Z-2 F300\nX50 Y20\nG0 Z50\nM2\n")
    assert command(["cut", str(program)]) == 2
    assert "motions at the feed end within box:-10,15,-2,50,20,-2" in capsys.readouterr().err


def test_a_tool_without_a_size_is_told():
    out = cut_toolpaths(
        [path_of((-20, 15, 5), line(-20, 15, -3), line(20, 15, -3))], BOX, "t.nc", cell_mm=0.5
    )
    assert codes(out) == ["cut-tool"]
    assert "'*'" in out.findings[0].message  # before the first change of tools: it was called ''
    assert "--tool '*=flat:D'" in out.findings[0].hint
    assert "*=turn:NOSE,TRAILING" in out.findings[0].hint


def test_a_tool_narrower_than_a_cell_is_told_and_not_one_as_wide():
    """It cut next to nothing, no fault of it was found, and all was said to hold."""
    removal = run(line(-20, 15, -3), line(20, 15, -3), tool="flat:0.199")
    (found,) = removal.findings
    assert (found.code, found.severity, found.values["left_out_feed_mm"]) == ("cut-narrow", "error", 48.0)
    assert "0.199 mm is narrower than a cell of 0.2 mm" in found.message
    assert not removal.holds
    assert codes(run(line(-20, 15, -3), line(20, 15, -3), tool="flat:0.2")) != ["cut-narrow"]


def test_gcode_is_cut_with_the_diameters_of_the_tool_table(tmp_path):
    """T3 of 6 mm, and its length of 50 mm taken off: the tip goes to Z-2."""
    program, table = tmp_path / "p.ngc", tmp_path / "tool.tbl"
    program.write_text("G21 G90 T3 M6\nG43 H3 S1000 M3\nG0 X-10 Y15 Z5\nG1 Z-2 F300\nX50\nG0 Z5\nM2\n")
    table.write_text("T3 P3 Z50 D6 ; slot drill\n")
    report, stl, picture = tmp_path / "r.json", tmp_path / "r.stl", tmp_path / "r.png"
    arguments = ["cut", str(program), "--stock", "box:0,0,-20,40,30,0", "--tool-table", str(table)]
    arguments += ["--cell", "0.1", "--report", str(report), "-o", str(stl), "--picture", str(picture)]
    assert command(arguments) == 0
    values = json.loads(report.read_text())
    assert values["removed_mm3"] == pytest.approx(40 * 6 * 2, rel=5e-3)
    assert values["operations"][0]["tool"] == "3"
    triangles = read_stl(str(stl))
    assert triangles.min(axis=(0, 1))[2] == -20.0
    assert picture.stat().st_size > 1000


@pytest.mark.parametrize("stock", ["box:0,0,-4,10,10,0", "cylinder:5,5,10,-4,0"])
def test_a_stock_of_which_nothing_is_left_has_no_triangles(stock, tmp_path, capsys):
    """The last four of 84 bytes of a binary STL count triangles; they were an internal error."""
    program, stl = tmp_path / "p.ngc", tmp_path / "r.stl"
    program.write_text("G21 G90 S1000 M3\nG0 X-20 Y5 Z5\nG1 Z-5 F1000\nX30\nM2\n")
    assert command(["cut", str(program), "--stock", stock, "--tool", "*=flat:30", "-o", str(stl)]) == 0
    assert stl.read_bytes()[80:] == bytes(4)
    assert "warning[cut-empty]" in capsys.readouterr().err


def test_a_rapid_of_gcode_into_stock_ends_with_exit_1(tmp_path, capsys):
    program = tmp_path / "p.ngc"
    program.write_text("G21 G90 S1000 M3\nG0 X-10 Y15 Z5\nG0 Z-2\nG0 X50\nM2\n")
    assert command(["cut", str(program), "--stock", "box:0,0,-20,40,30,0", "--tool", "*=flat:6"]) == 1
    assert "p.ngc:4:1: error[cut-rapid]" in capsys.readouterr().err


@pytest.mark.parametrize(
    "text", ["3=flat", "3=bull:10", "flat:6", "3=flat:-2", "3=flat:6;length", "3=what:6"]
)
def test_tools_that_are_none_are_refused(text, tmp_path, capsys):
    program = tmp_path / "p.ngc"
    program.write_text("M2\n")
    assert command(["cut", str(program), "--stock", "box:0,0,-20,40,30,0", "--tool", text]) == 2
    assert "cut-tool" in capsys.readouterr().err


@pytest.mark.parametrize(
    "text", ["box:0,0,0", "box:0,0,0,0,1,1", "cylinder:0,0,1", "cylinder:0,0,-10,0,5", "no-such-file.stl"]
)
def test_stocks_that_are_none_are_refused(text, tmp_path):
    program = tmp_path / "p.ngc"
    program.write_text("M2\n")
    assert command(["cut", str(program), "--stock", text]) == 2


def test_a_text_that_is_cut_off_is_no_stock(tmp_path):
    """Its triangles were a stock that is open where the file ends."""
    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    file = tmp_path / "s.stl"
    file.write_text(f"solid s\n{facet}endsolid s\n")
    assert read_stl(str(file)).shape == (1, 3, 3)
    file.write_text(f"solid s\n{facet}")
    with pytest.raises(UsageError, match="is cut off"):
        read_stl(str(file))


def pocket_part(tmp_path, radial=5.0, stop=None):
    part = Features()
    workpiece = part.block((0, 0, -20), (100, 80, 0))
    place, bottom = part.placement(ORIGIN), part.add("PLANAR_POCKET_BOTTOM_CONDITION")
    own = ("f", workpiece, (), place, part.plane(-6.0), (), None, bottom, None, None, part.rectangle(60, 40))
    part.mill(part.add("CLOSED_POCKET", *own), pocket_operation(part, radial=radial))
    file = tmp_path / "pocket.stp"
    file.write_text(part.text())
    return file


def test_a_pocket_of_stepnc_is_cut_from_the_raw_piece_of_the_file(tmp_path):
    """60 x 40 x 6 mm with corners of 4 mm; nothing is wrong and nothing is left that the tool could reach."""
    out = cut(pocket_part(tmp_path), cell_mm=0.1)
    assert codes(out) == []
    assert out.operations[-1].volume_mm3 == pytest.approx(6 * (2400 - (4 - np.pi) * 16), rel=5e-3)


def test_walls_on_the_middles_of_columns_are_not_left(tmp_path):
    """Walls at 29.8 and 70.2 mm, where columns of 0.4 mm have their middles: whether a place on a wall stands or goes is chance."""
    part = Features()
    workpiece = part.block((0, 0, -20), (100, 80, 0))
    bottom, radius = part.add("PLANAR_POCKET_BOTTOM_CONDITION"), part.size(4)
    place, boundary = part.placement(ORIGIN), part.rectangle(40.4, 40.4)
    own = ("f", workpiece, (), place, part.plane(-6.0), (), None, bottom, None, radius, boundary)
    part.mill(part.add("CLOSED_POCKET", *own), pocket_operation(part))
    file = tmp_path / "pocket.stp"
    file.write_text(part.text())
    assert codes(cut(file, cell_mm=0.4)) == []


def test_old_toolpaths_of_features_are_found_wrong(tmp_path):
    """As they were made before: rings too far apart leave walls, a floor too deep is a gouge."""
    from cncgen.stepnc.cutting import cut_program

    program = cut_program(pocket_part(tmp_path))
    stock = box((0, 0, -20), (100, 80, 0))
    tool = cutter_of_option("*=flat:8")
    x, y = ORIGIN[:2]
    ring = [line(x + a, y + b, -6.0) for a, b in ((-26, -16), (26, -16), (26, 16), (-26, 16), (-26, -16))]
    out = cut_toolpaths(
        [path_of((x - 26, y - 16, 5.0), *ring)], stock, "t", {"*": tool}, program.finished, 0.2
    )
    assert codes(out) == ["cut-left"]
    assert out.findings[0].values["depth_mm"] == pytest.approx(6.0)
    assert out.findings[0].values["volume_mm3"] == pytest.approx(6.0 * 44 * 24, rel=0.02)
    assert out.findings[0].values["operation"] == "ws"
    source = pocket_part(tmp_path).read_text().splitlines()[out.findings[0].span.line - 1]
    assert "BOTTOM_AND_SIDE_FINISH_MILLING" in source
    deep = [line(x, y, -7.0), line(x + 5, y, -7.0)]
    gouged = cut_toolpaths([path_of((x, y, 5.0), *deep)], stock, "t", {"*": tool}, program.finished, 0.2)
    assert codes(gouged)[0] == "cut-gouge"
    assert gouged.findings[0].values["depth_mm"] == pytest.approx(1.0)


def old(part, tool, *moves, start=None, spindle=1000.0):
    """Cut what features leave along toolpaths as they were made before; places are from the feature's origin."""
    from cncgen.stepnc.cutting import cut_program

    x, y = ORIGIN[:2]
    program = cut_program(part.text().encode(), "t.stp")
    assert program.finished is not None
    moved = [event("spindle", speed_rpm=spindle, direction=int(spindle > 0))]
    moved += [line(x + a, y + b, z, rapid) for a, b, z, rapid in moves]
    path = path_of((x + moves[0][0], y + moves[0][1], 20.0) if start is None else start, *moved)
    cutters = {"*": cutter_of_option(f"*={tool}")}
    stock = box((0, 0, -20), (100, 80, 0))
    return cut_toolpaths([path], stock, "t", cutters, program.finished, 0.2)


def filleted_part(finish=True, **tool):
    """A pocket of 60 x 40 mm, 6 mm deep, with a fillet of 2 mm between wall and floor."""
    part = Features()
    workpiece = part.block((0, 0, -20), (100, 80, 0))
    place, bottom = part.placement(ORIGIN), part.add("PLANAR_POCKET_BOTTOM_CONDITION")
    sizes = (part.size(2), part.size(4))
    own = ("f", workpiece, (), place, part.plane(-6.0), (), None, bottom, *sizes, part.rectangle(60, 40))
    return part.mill(part.add("CLOSED_POCKET", *own), pocket_operation(part, finish=finish, **tool))


@pytest.mark.parametrize("edge", [None, 1.0, 2.0])
@pytest.mark.parametrize("finish", [True, False])
def test_a_fillet_between_wall_and_floor_is_not_cut_away(finish, edge, tmp_path):
    file = tmp_path / "pocket.stp"
    file.write_text(filleted_part(finish, edge=edge).text())
    assert codes(cut(file, cell_mm=0.2)) == []


def test_a_fillet_is_finished_in_steps(tmp_path):
    """A sharp tool at the height h of each of eight passes stays 2 - sqrt(2² - (2 - h)²) from the wall: rectangles with corners of 4 mm."""
    file = tmp_path / "pocket.stp"
    file.write_text(filleted_part().text())
    heights = np.arange(8) * 2 / 8
    away = np.append(2 - np.sqrt(4 - (2 - heights) ** 2), 0.0)
    # Above the fillet's passes there is one, half as deep as the first of them.
    thick = np.append(np.full(7, 2 / 8), [4.25 / 2, 4.25 / 2])
    areas = (60 - 2 * away) * (40 - 2 * away) - (4 - np.pi) * 16
    volume = cut(file, cell_mm=0.1).operations[-1].volume_mm3
    assert volume == pytest.approx((areas * thick).sum(), rel=2e-3)


def test_a_sharp_tool_beside_the_wall_gouges_the_fillet():
    found = old(filleted_part(), "flat:8", (-26, 0, -6, False), (-26, 5, -6, False)).findings
    depths = [f.values["depth_mm"] for f in found if f.code == "cut-gouge"]
    # At the middle of the second column of 0.2 mm; the first is too near to the side of the tool to count.
    assert max(depths) == pytest.approx(2.0 - np.sqrt(4.0 - 1.7**2), abs=0.01)


@pytest.mark.parametrize(("radial", "edge", "told"), [(5.0, 1.0, False), (7.0, 2.0, True), (3.0, 4.0, True)])
def test_ridges_between_passes_of_a_rounded_tool_are_found_and_told(radial, edge, told, tmp_path):
    """A tool of 8 mm is level over 8 less twice the radius of its edge; farther apart its passes leave ridges on the floor."""
    part = Features()
    workpiece = part.block((0, 0, -20), (100, 80, 0))
    place, bottom = part.placement(ORIGIN), part.add("PLANAR_POCKET_BOTTOM_CONDITION")
    own = ("f", workpiece, (), place, part.plane(-6.0), (), None, bottom, None, None, part.rectangle(60, 40))
    part.mill(part.add("CLOSED_POCKET", *own), pocket_operation(part, radial=radial, edge=edge))
    _, found = part.read()
    assert ("stepnc-uncut" in [code for code, _, _ in found]) == told
    file = tmp_path / "pocket.stp"
    file.write_text(part.text())
    left = cut(file, cell_mm=0.25).findings
    assert {f.code for f in left} == ({"cut-left"} if told else set())
    # The highest are those of lines 7 mm apart, 1.5 mm beyond the level end.
    assert all(f.values["depth_mm"] < 2 - np.sqrt(4 - 1.5**2) for f in left)


@pytest.mark.parametrize(("overlap", "told"), [(0.3, False), (0.1, True)])
def test_the_rounded_edge_of_a_facing_tool_leaves_no_ridge_in_silence(overlap, told, tmp_path):
    """A tool of 8 mm with an edge of 1 mm is level over 6: lines 5.6 mm apart leave nothing, also at the border; 7.2 mm do."""
    part = Features()
    piece = part.block((0, 0, -20), (60, 40, 0))
    course = part.add("LINEAR_PATH", None, part.size(40), part.direction(0, 1, 0))
    width = part.add("LINEAR_PROFILE", None, part.add("NUMERIC_PARAMETER", "", 60.0, "mm"))
    own = ("f", piece, (), part.placement((0, 0, 0)), part.plane(-2.0), course, width, None, ())
    strategy = part.add("UNIDIRECTIONAL_MILLING", overlap, E("F"), None, E("CLIMB"))
    head = (None, None, "op", 5.0, None, part.tool("T", 8.0, edge=1.0), part.technology(), None)
    operation = part.add("PLANE_ROUGH_MILLING", *head, 0.0, None, None, strategy, None, None)
    part.mill(part.add("PLANAR_FACE", *own), operation)
    file = tmp_path / "face.stp"
    file.write_text(part.text())
    assert ("stepnc-uncut" in [code for code, _, _ in part.read()[1]]) == told
    assert {f.code for f in cut(file, cell_mm=0.25).findings} == ({"cut-left"} if told else set())


def drilled_part():
    """A hole of 10 mm, 8 mm deep, with a flat bottom."""
    part = Features()
    workpiece = part.block((0, 0, -20), (100, 80, 0))
    flat = part.add("FLAT_HOLE_BOTTOM")
    hole = part.add(
        "ROUND_HOLE", "h", workpiece, (), part.placement(ORIGIN), part.plane(-8.0), part.size(10), None, flat
    )
    head = (None, None, "op", 11.0, None, part.tool("d", 10.0), part.technology(), None)
    return part.mill(hole, part.add("DRILLING", *head, None, None, None, None, None, None))


@pytest.mark.parametrize(
    ("tool", "depth", "gouge"),
    [
        ("flat:10", 8.0, None),
        # Below the bottom of the hole.
        ("flat:10", 11.0, 3.0),
        # A tool of 12 mm takes the wall along with it: the block beside the hole, 8 mm high.
        ("flat:12", 8.0, 8.0),
        # Through the block, 20 mm thick.
        ("flat:10", 25.0, 12.0),
    ],
)
def test_old_holes_with_a_wrong_tool_or_depth_are_gouges(tool, depth, gouge):
    found = old(drilled_part(), tool, (0, 0, -depth, False), (0, 0, 20, True)).findings
    assert {f.code for f in found} == ({"cut-gouge"} if gouge else set())
    if gouge:
        assert found[0].values["depth_mm"] == pytest.approx(gouge)


def test_old_holes_with_a_standing_spindle_are_found():
    found = old(drilled_part(), "flat:10", (0, 0, -8, False), (0, 0, 20, True), spindle=0.0).findings
    assert [f.code for f in found] == ["cut-spindle"]


def test_old_facing_leaves_spikes_that_are_found():
    """Lines 12 mm apart of a tool of 16 mm whose front goes as far as the side, 40 mm away: between round fronts it stands 2 mm high."""
    moves = []
    for x in (6.0, 18.0, 30.0, 42.0):
        moves += [(x, 8.0, 20.0, True), (x, 8.0, -2.0, False), (x, 32.0, -2.0, False), (x, 32.0, 20.0, True)]
    found = old(face(0.0), "flat:16", *moves).findings
    assert {f.code for f in found} == {"cut-left"}
    assert all(f.values["depth_mm"] == pytest.approx(2.0) for f in found)


def test_old_rapids_through_standing_walls_are_found(tmp_path):
    """Rings 20 mm apart by a tool of 8 mm leave walls, and the rapid from one to the next goes through."""
    from cncgen.stepnc.cutting import cut_program

    program = cut_program(pocket_part(tmp_path))
    x, y = ORIGIN[:2]
    moves = [line(x - 10, y - 10, -6), line(x + 10, y - 10, -6), line(x + 10, y + 10, -6, rapid=True)]
    tool = {"*": cutter_of_option("*=flat:8")}
    stock = box((0, 0, -20), (100, 80, 0))
    out = cut_toolpaths([path_of((x - 10, y - 10, 5.0), *moves)], stock, "t", tool, program.finished, 0.2)
    (found,) = [f for f in out.findings if f.code == "cut-rapid"]
    assert found.values["depth_mm"] == pytest.approx(6.0)
    # A strip of 8 mm by 20 mm and a half circle, less what the line before it has cut: a square of 4 mm and a quarter of a circle.
    area = 160.0 + 8.0 * np.pi - 16.0 - 4.0 * np.pi
    assert found.values["volume_mm3"] == pytest.approx(6.0 * area, rel=1e-3)


def test_the_mesh_of_a_cut_block_has_its_volume():
    """By the divergence theorem, of a grid so fine that walls one cell wide do not count."""
    out = run(line(-20, 15, -3), line(60, 15, -3))
    vertices, triangles = mesh_of(out.stock)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    volume = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)
    assert volume == pytest.approx(out.stock.volume, rel=0.02)
    count = int.from_bytes(stl_bytes(vertices, triangles)[80:84], "little")
    assert count <= len(triangles)


#: Corners of the cells of a grid of nodes: low X and low Y, high X, high Y, both.
_A, _B, _C, _D = np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, :-1], np.s_[1:, 1:]


def closed(triangles):
    """Tell whether each edge of a mesh, of triangles of places, is gone along once in each direction."""
    edges = Counter()
    for three in triangles:
        for k in range(3):
            edges[three[k], three[(k + 1) % 3]] += 1
    return all(edges[b, a] == count for (a, b), count in edges.items())


def test_level_columns_are_joined_and_the_mesh_stays_closed(tmp_path):
    """Volume and area by the divergence theorem and of prisms below two triangles a cell, with a slot, a step and a hole right through."""
    out = run(
        line(-20, 15, -3),
        line(60, 15, -3),
        line(60, 25, -7),
        line(-20, 25, -7),
        line(20, 5, -25),
        line(20, 5, 5),
    )
    field = out.stock
    heights, low = np.maximum(field.heights, field.bottom), field.bottom
    x, y = field.x, field.y
    for row in (x, y):
        row[0], row[-1] = row[0] - field.cell / 2, row[-1] + field.cell / 2
    thick = heights > low
    solid = thick[:-1, :-1] | thick[:-1, 1:] | thick[1:, :-1] | thick[1:, 1:]
    volume = area = 0.0
    flat, height = np.stack(np.meshgrid(x, y), axis=-1), heights - low
    for corners in ((_A, _B, _D), (_A, _D, _C)):
        across = [flat[corner][solid] for corner in corners[1:]] - flat[corners[0]][solid]
        size = (across[0, :, 0] * across[1, :, 1] - across[0, :, 1] * across[1, :, 0]) / 2
        volume += np.sum(size * np.mean([height[corner][solid] for corner in corners], axis=0))
        for z in (heights, low):
            p, q, r = (np.dstack([flat, z])[corner][solid] for corner in corners)
            area += np.linalg.norm(np.cross(q - p, r - p), axis=1).sum() / 2
    for side, walls in ((x, height[[0, -1]]), (y, height.T[[0, -1]])):
        for wall in walls:
            area += np.sum((wall[1:] + wall[:-1]) / 2 * np.diff(side))
    vertices, triangles = mesh_of(field)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    assert np.linalg.norm(normal, axis=1).sum() / 2 == pytest.approx(area, rel=1e-9)
    assert np.einsum("ij,ij->", a, normal) / 6 == pytest.approx(volume, rel=1e-9)
    assert len(triangles) < 4 * solid.sum() / 10
    file = tmp_path / "left.stl"
    file.write_bytes(stl_bytes(vertices, triangles))
    assert closed([tuple(map(tuple, three)) for three in read_stl(str(file)).tolist()])


def test_a_target_mesh_says_what_is_gouged_and_left(tmp_path):
    """The part is the block with a slot of 8 mm, 3 mm deep; cut 4 mm deep it is gouged, 2 mm deep some is left."""
    wanted = tmp_path / "part.stl"
    wanted.write_bytes(stl_bytes(*mesh_of(run(line(-20, 15, -3), line(60, 15, -3)).stock)))
    for depth, code in ((4, "cut-gouge"), (2, "cut-left"), (3, None)):
        program = tmp_path / "p.ngc"
        program.write_text(f"G21 G90 S1000 M3\nG0 X-20 Y15 Z5\nG1 Z-{depth} F300\nX60\nG0 Z5\nM2\n")
        out = cut(program, stock="box:0,0,-20,40,30,0", tools=["*=flat:8"], target=str(wanted), cell_mm=0.2)
        assert code in codes(out) if code else not codes(out)


def test_check_cuts_the_features_of_a_file(tmp_path, capsys):
    """A countersink of 30 mm reaches over the wall beside its hole: a gouge that no check of sizes finds."""
    assert command(["check", str(pocket_part(tmp_path))]) == 0
    part = Features()
    workpiece = part.block((0, 0, -20), (100, 80, 0))
    flat, through = part.add("PLANAR_POCKET_BOTTOM_CONDITION"), part.add("THROUGH_BOTTOM_CONDITION")
    pocket = part.add(
        "CLOSED_POCKET", "p", workpiece, (), part.placement(ORIGIN), part.plane(-6.0), (), None, flat, None, None,
        part.rectangle(24, 24),
    )  # fmt: skip
    hole = part.add(
        "ROUND_HOLE", "h", workpiece, (), part.placement((ORIGIN[0], ORIGIN[1], -6.0)), part.plane(-14.0),
        part.size(8), None, through,
    )  # fmt: skip
    sink = part.tool("sink", 30.0, body="COUNTERSINK", tip=45.0)
    head = (None, None, "op", 11.0, None, sink, part.technology(), None)
    operation = part.add("COUNTER_SINKING", *head, None, 14.0, None, None, None, None)
    steps = (
        part.step(pocket_operation(part), pocket, part.plane(20)),
        part.step(operation, hole, part.plane(20)),
    )
    part.project(part.plan(*steps))
    file = tmp_path / "sink.stp"
    file.write_text(part.text())
    capsys.readouterr()
    assert command(["check", str(file)]) == 1
    assert "error[cut-gouge]" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("features", None, None),
        ("nist_ex1", (0, 0, -45), (100, 120, 5)),
        ("plate_ap238", (0, 0, -20), (160, 100, 3)),
    ],
)
def test_nothing_is_wrong_with_the_programs_of_features(programs, name, low, high):
    stock = None if low is None else box(low, high)
    assert codes(cut(programs / "stepnc" / f"{name}.stp", stock=stock, cell_mm=0.5)) == []


def test_the_explicit_toolpaths_of_nist_cut_what_their_features_do(programs):
    """Both files have the same 537 lines of canonical calls, so what is left is the same to the last column."""
    stock = box((0, 0, -45), (100, 120, 5))
    both = [cut(programs / "stepnc" / f"nist_ex1{e}.stp", stock=stock, cell_mm=0.5) for e in ("", "E")]
    difference = np.abs(both[0].stock.heights - both[1].stock.heights)
    assert (difference < 1e-3).mean() > 0.9995
    assert both[0].stock.volume == pytest.approx(both[1].stock.volume, rel=1e-4)


@pytest.mark.parametrize(
    ("form", "why"),
    [
        ("bull:10,6", "more than half of the diameter"),
        ("chamfer:10,190", "at most 180 degrees"),
        ("chamfer:10,90,12", "the tip is wider"),
        ("drill:10,0", "the angle is not above 0"),
        ("turn:0.4,90", "below 90 degrees"),
        ("flat:10;shank=-8", "names no tool"),
    ],
)
def test_forms_that_no_tool_has_are_refused_with_the_reason(form, why):
    with pytest.raises(UsageError, match=why):
        cutter_of_option(f"1={form}")


def test_the_form_of_a_tool_may_be_written_in_capitals():
    """A ball of 6 mm has a rounded edge of its radius, 3 mm, however its form is written."""
    assert cutter_of_option("1=Ball:6").edge == 3.0


@pytest.mark.parametrize(
    ("tools", "way", "code"),
    [
        ([], "7: 10 mm, 8: 6 mm", 1),
        (["8=flat:4"], "7: 10 mm", 1),
        (["7=flat:4", "8=flat:4"], "*: 0 mm", 0),
        (["*=flat:4"], "", 0),
    ],
)
def test_cuts_that_are_left_out_are_not_judged(tmp_path, tools, way, code, capsys):
    """What a tool of no known size cuts is missing from the verdict, and from what later tools meet; a rapid to the change is not."""
    text = "G21 G90 G94 G17 S1000 M3 F600\nG0 Z5\nT7 M6\nM3\nG0 X10 Y10\nG1 Z-1\nX14\nG0 Z5\nT8 M6\nM3\nG0 X20\nG1 Z-1\nM2\n"
    file = tmp_path / "part.nc"
    file.write_text(text)
    box = "box:0,0,-10,40,40,0"
    found = [each for each in cut(file, stock=box, tools=tools).findings if each.code == "cut-tool"]
    told = {each.values["tool"]: each for each in found}
    wanted = {part.split(": ")[0]: part.split(": ")[1] for part in way.split(", ") if part}
    for name, length in wanted.items():
        assert f" are left out, {length} of them at the feed" in told[name].message
        assert told[name].severity.value == ("warning" if length == "0 mm" else "error")
    assert set(told) - {"*"} == set(wanted) - {"*"}
    options = [word for tool in tools for word in ("--tool", tool)]
    assert command(["cut", str(file), "--stock", box, *options]) == code
    capsys.readouterr()
