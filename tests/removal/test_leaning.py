"""Tools that lean: volumes and depths against closed forms (0.5 %), and motions that are wrong."""

import json
import math
import re
from importlib import resources

import numpy as np
import pytest

from cncgen.cli.app import run
from cncgen.diagnostics import UsageError
from cncgen.machine.kinematics import Kinematics
from cncgen.pipeline.removing import cut, lean_toolpaths
from cncgen.removal.cutters import cutter_of_option
from cncgen.removal.dexels import dexel_mesh, dexels_of, moved, turns_of
from cncgen.removal.stock import box, stock_of_option
from cncgen.removal.surfaces import FEW, mesh_of, stl_bytes
from cncgen.toolpath.reading import ReadOptions
from tests.removal.paths import line, path_of
from tests.stepnc.building import Part

BOX = box((0, 0, -20), (40, 30, 0))
TILTS = [15.0, 30.0, 40.0]
#: Across the way, along it, and between; as long as they like.
AXES = [(0, 0, 1), (0.3, 0.4, 0.9), (-0.5, 0, 0.9), (0.9, 0.1, 0.3)]


class Fixed:
    """X Y Z are the tip of a tool that always leans alike."""

    def __init__(self, axis):
        self.axis = np.array(axis, float) / np.linalg.norm(axis)

    def __call__(self, letters, positions):
        return positions[:, :3], np.tile(self.axis, (len(positions), 1))

    def offset(self, length_mm):
        pass


def lean(tool, axis, *tips, stock=BOX, cell=0.1, rapid=False, target=None, above=30.0):
    """Go down to the first tip along the axis from far above, and on to the others."""
    poses = Fixed(axis)
    start = np.array(tips[0]) + above * poses.axis
    path = path_of(tuple(start), *(line(*tip, rapid=rapid) for tip in tips))
    return lean_toolpaths([path], stock, "t", poses, {"*": cutter_of_option(f"*={tool}")}, target, cell)


def close(removal, volume):
    removed = removal.raw_volume_mm3 - removal.stock.volume
    assert removed == pytest.approx(volume, rel=5e-3)
    assert sum(o.volume_mm3 for o in removal.operations) == pytest.approx(removed)


def across(degrees):
    """The axis of a tool that leans to -Y."""
    return (0.0, -math.sin(math.radians(degrees)), math.cos(math.radians(degrees)))


@pytest.mark.parametrize("degrees", TILTS)
def test_an_inclined_slot(degrees):
    """A section as wide as the tool; its mean length along the axis is that from the tip's way to the top."""
    out = lean("flat:8", across(degrees), (-20, 15, -5), (60, 15, -5))
    close(out, 40.0 * 8.0 * 5.0 / math.cos(math.radians(degrees)))
    # The lower corner of the section is R sin a below the tip.
    below = out.stock.fields[2].ends[:, 200, :].copy()
    bottoms = below[:, 1][out.stock.fields[2].counts[:, 200] == 1]
    assert bottoms.min() == pytest.approx(-5.0 - 4.0 * math.sin(math.radians(degrees)), abs=0.1)


@pytest.mark.parametrize("degrees", [20.0, 50.0, 70.0])
def test_a_flat_end_over_the_edge_of_a_block(degrees):
    """The end passes through the line 4 mm inside of the edge and leaves a face that falls to the side."""
    a, inside = math.radians(degrees), 4.0
    axis = np.array(across(degrees))
    tip = np.array([0.0, inside - math.cos(a), -math.sin(a)])
    out = lean("flat:40", axis, tip - np.array([40, 0, 0]), tip + np.array([80, 0, 0]))
    close(out, 40.0 * inside**2 * math.tan(a) / 2 if inside * math.tan(a) <= 20 else math.nan)


@pytest.mark.parametrize("axis", AXES)
def test_a_ball_cuts_the_same_however_it_leans(axis):
    """A groove less deep than the radius is a segment of the circle."""
    r, depth = 4.0, 3.0
    centre = np.array([0.0, 15.0, r - depth])
    tip = centre - r * np.array(axis) / np.linalg.norm(axis)
    if abs(axis[1]) > 0.2:
        # The shank that leans to the side stays above the block.
        depth = 1.5
        tip = tip + np.array([0, 0, 1.5])
    segment = r * r * math.acos((r - depth) / r) - (r - depth) * math.sqrt(2 * r * depth - depth * depth)
    out = lean("ball:8", axis, tip - np.array([20, 0, 0]), tip + np.array([60, 0, 0]))
    close(out, 40.0 * segment)


@pytest.mark.parametrize("axis", [(0, 0, 1), (0.3, 0.4, 0.9), (-0.5, 0, 0.9)])
@pytest.mark.parametrize("tool", ["flat:8", "drill:8,118", "ball:8", "bull:8,2", "chamfer:8,90,4"])
def test_an_inclined_hole(tool, axis):
    """The cylinder from its lower end to the top at the axis, less what the end of the tool leaves of it."""
    cutter = cutter_of_option(f"*={tool}")
    rho = np.linspace(0.0, 4.0, 20001)
    missing = 2 * math.pi * float(np.trapezoid(cutter.height(rho) * rho, rho))
    out = lean(tool, axis, (20, 15, -9))
    cosine = axis[2] / float(np.linalg.norm(axis))
    close(out, math.pi * 16.0 * 9.0 / cosine - missing)


@pytest.mark.parametrize("tool", ["flat:9", "ball:9", "bull:9,2", "drill:9,100", "chamfer:9,60,3"])
def test_dexels_are_cut_where_the_tool_passes(tool):
    """Against 3,000 places of the tool along a random way, at random points: inside, where one of the places holds the point."""
    rng = np.random.default_rng()
    cutter = cutter_of_option(f"*={tool}")
    axis = rng.normal(size=3)
    axis[2] = abs(axis[2]) + 0.3
    a, b = rng.uniform((8, 8, -12), (32, 22, -2), (2, 3))
    out = lean(tool, axis, a, b, cell=0.5, above=60.0)
    axis = axis / np.linalg.norm(axis)
    way = np.concatenate(
        [a + np.linspace(60, 0, 3001)[:, None] * axis, a + np.linspace(0, 1, 3001)[:, None] * (b - a)]
    )
    for _ in range(300):
        axis_of = int(rng.integers(3))
        field = out.stock.fields[axis_of]
        u, v, w = ((axis_of + 1) % 3, (axis_of + 2) % 3, axis_of)
        j, i = int(rng.integers(field.counts.shape[0])), int(rng.integers(field.counts.shape[1]))
        point = np.empty(3)
        point[u], point[v] = out.stock.nodes(u)[i], out.stock.nodes(v)[j]
        point[w] = rng.uniform(BOX.low[w], BOX.high[w])
        along = (point - way) @ axis
        apart = np.linalg.norm(point - way - along[:, None] * axis, axis=1)
        # How far the point is within the tool, and within one that is a little larger or smaller.
        within = [
            bool(
                (
                    (along >= cutter.height(np.clip(apart - grow, 0.0, 4.5)) - grow) & (apart <= 4.5 + grow)
                ).any()
            )
            for grow in (0.03, -0.03)
        ]
        ends = field.ends[j, i, : 2 * field.counts[j, i]].reshape(-1, 2)
        there = bool(((ends[:, 0] <= point[w]) & (point[w] <= ends[:, 1])).any())
        if within[0] == within[1]:
            assert there != within[0]


def test_many_holes_through_one_line_have_places():
    """Seven holes across lines along X part each of these eight times."""
    moves = [line(3, 15, 5)]
    for k in range(7):
        x, y = 3.1 + 5.437 * k, 15.0 + 0.013 * k
        moves += [line(x, y, 5), line(x, y, -21), line(x, y, 5)]
    out = lean_toolpaths(
        [path_of((3, 15, 5), *moves)],
        BOX,
        "t",
        Fixed((0, 0, 1)),
        {"*": cutter_of_option("*=flat:3")},
        None,
        0.1,
    )
    field = out.stock.fields[0]
    assert field.counts.max() == 8
    # Between holes the tool goes above the block.
    close(out, 7 * math.pi * 2.25 * 20.0)


@pytest.mark.parametrize("text", ["box:0,0,-20,40,30,0", "cylinder:20,15,24,-20,0"])
def test_raw_pieces_and_their_meshes_have_their_volumes(text):
    stock = stock_of_option(text)
    made = dexels_of(stock, 0.2)
    size = stock.high - stock.low
    volume = float(np.prod(size)) * (1.0 if stock.kind == "box" else math.pi / 4)
    assert made.volume == pytest.approx(volume, rel=2e-3)
    vertices, triangles = mesh_of(made)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    assert float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6) == pytest.approx(volume, rel=2e-3)


def _measures(vertices, triangles):
    """Return volume and area of a mesh, and whether each edge belongs to two triangles that go along it to and fro."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    there, back = (
        np.sort(edges @ step) for step in (np.array([len(vertices), 1]), np.array([1, len(vertices)]))
    )
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    volume = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)
    return volume, area, bool(np.array_equal(there, back) and np.all(np.diff(there) > 0))


@pytest.mark.parametrize(("tool", "share"), [("flat:8", 10), ("ball:8", 5)])
def test_planes_of_dexels_have_few_triangles(tool, share):
    """The same surface, and so the same volume and area; an STL file had a million triangles, most of them amid faces of the box."""
    stock = lean(tool, across(30), (-20, 15, -5), (60, 15, -5), cell=0.2).stock
    whole, few = dexel_mesh(stock), mesh_of(stock)
    assert share * len(few[1]) < len(whole[1])
    volume, area, closed = _measures(*few)
    assert (volume, area) == pytest.approx(_measures(*whole)[:2], rel=1e-9)
    assert closed


def test_few_triangles_of_dexels_keep_the_volume():
    """A box with a slot that leans, as a mesh of 80,000 triangles at the most; corners of cells of 0.2 mm become their middle."""
    stock = lean("ball:8", across(30), (-20, 15, -5), (60, 15, -5), cell=0.1).stock
    vertices, triangles = mesh_of(stock, joined=True)
    assert len(triangles) <= FEW < len(mesh_of(stock)[1])
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    assert float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6) == pytest.approx(stock.volume, rel=0.02)


def test_a_stock_that_is_stood_otherwise_keeps_its_volume_and_its_hollows():
    """A slot that a tool on its side cut under the top is still there after a quarter turn, and after 30 degrees."""
    out = lean("flat:6", (0, -1, 0), (-20, 10, -10), (60, 10, -10), cell=0.25)
    volume = 40.0 * 30.0 * 20.0 - 40.0 * 10.0 * 6.0
    assert out.stock.volume == pytest.approx(volume, rel=5e-3)
    for degrees in (90.0, 30.0):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        move = np.array([[1, 0, 0, 3], [0, c, -s, 4], [0, s, c, 5], [0, 0, 0, 1]], float)
        assert moved(out.stock, move).volume == pytest.approx(volume, rel=5e-3)


TABLE = Kinematics(0, (3, 5), (20.0, 15.0, 0.0))
HEAD = Kinematics(2, (5, 4), pivot=50.0)


def machined(tmp_path, kinematics, *lines):
    """Cut a program of a machine whose axes carry table or head."""
    program = tmp_path / "p.ngc"
    program.write_text("\n".join(["G21 G90 G94 S1000 M3", *lines, "M2", ""]))
    options = ReadOptions(kinematics=kinematics)
    return cut(program, stock="box:0,0,-20,40,30,0", tools=["*=flat:6"], cell_mm=0.2, options=options)


def test_a_turning_table_cuts_a_ring(tmp_path):
    """A tool 9 mm from the middle of a table that turns once: a ring as wide as the tool (Pappus)."""
    out = machined(tmp_path, TABLE, "G0 X29 Y15 Z5", "G1 Z-3 F300", "C360 F2000", "G0 Z5")
    assert [f.code for f in out.findings] == []
    close(out, 2 * math.pi * 9.0 * 6.0 * 3.0)


def test_a_tilted_table_is_cut_in_the_frame_of_the_work(tmp_path):
    """At A30 the table turns the block about X by -30 degrees: the spindle's axis is that of a tool that leans to -Y by 30."""
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    tips = [np.array([x, 0.0, -5.0]) for x in (-40.0, 40.0)]
    at = [f"X{20 + t[0]:.6f} Y{15 + c * t[1] + s * t[2]:.6f} Z{-s * t[1] + c * t[2]:.6f}" for t in tips]
    out = machined(tmp_path, TABLE, "G0 X-20 Y15 Z50", "G0 A30", f"G0 {at[0]}", f"G1 {at[1]} F900")
    assert [f.code for f in out.findings] == []
    close(out, 40.0 * 6.0 * 5.0 / c)


def test_the_command_takes_the_machine_that_turns(tmp_path, capsys):
    """The same from the command line; without the machine it is refused, and the hint names the option."""
    machine, program = tmp_path / "five.toml", tmp_path / "p.ngc"
    text = (resources.files("cncgen.machine.profiles") / "generic-mill.toml").read_text()
    table = '\n[kinematics]\nmodel = "table-table"\naxes = ["a", "c"]\ncentre_mm = [20, 15, 0]\n'
    machine.write_text(text + table)
    program.write_text("G21 G90 G94 S1000 M3\nG0 X29 Y15 Z5\nG1 Z-3 F300\nC360 F2000\nG0 Z5\nM2\n")
    report = tmp_path / "r.json"
    given = ["cut", str(program), "--stock", "box:0,0,-20,40,30,0", "--tool", "*=flat:6", "--cell", "0.2"]
    assert run([*given, "--machine", str(machine), "--report", str(report)]) == 0
    removed = json.loads(report.read_text())["removed_mm3"]
    assert removed == pytest.approx(2 * math.pi * 9.0 * 6.0 * 3.0, rel=5e-3)
    capsys.readouterr()
    assert run(given) == 2
    said = capsys.readouterr().err
    assert "cut-tilted" in said
    assert "--machine" in said


def test_a_head_over_a_table_cuts_a_ring_with_a_leaning_tool(tmp_path):
    """Half a turn of the table under a head at B20, the tip 4 mm deep: as much as the same way of the tip and the tool by a fork head."""
    a = math.radians(20.0)
    reach = 50.0

    def ring(kinematics, turned):
        lines = []
        for degrees in range(0, 181, 3):
            c = math.radians(degrees)
            tip = np.array([9.0 * math.cos(c), 9.0 * math.sin(c), -4.0])
            lean = np.array([math.sin(a) * math.cos(c), math.sin(a) * math.sin(c), math.cos(a) - 1.0])
            if not turned:
                tip, lean = np.array([9.0, 0, -4.0]), np.array([math.sin(a), 0, math.cos(a) - 1.0])
            x, y, z = np.array([20.0, 15.0, 0.0]) + tip + reach * lean
            lines.append(f"G1 X{x:.6f} Y{y:.6f} Z{z:.6f} B20 C{degrees} F9000")
        first = lines[0].replace("G1 ", "G0 ").split(" F")[0]
        above = re.sub(r"Z(\S+)", lambda z: f"Z{float(z[1]) + 40.0}", first)
        out = machined(tmp_path, kinematics, "G0 Z90", above, *lines)
        return out.raw_volume_mm3 - out.stock.volume

    mixed = ring(Kinematics(1, (4, 5), (20.0, 15.0, 0.0), pivot=reach), turned=False)
    fork = ring(HEAD, turned=True)
    assert mixed == pytest.approx(fork, rel=2e-3)
    assert mixed > 9.0 * math.pi * 6.0 * 4.0  # at least what an upright tool takes


@pytest.mark.parametrize("length", [0.0, 40.0])
def test_a_head_and_the_length_of_its_tool(tmp_path, length):
    """A head with a tool of any length, tip at (20, 15, -9), B 20 degrees: an inclined hole."""
    a = math.radians(20.0)
    reach = 50.0 + length

    def at(above):
        tip = np.array([20.0, 15.0, -9.0]) + above * np.array([math.sin(a), 0, math.cos(a)])
        # X Y Z of the program under G43 are those of the tip where the head stands upright.
        return f"X{tip[0] + reach * math.sin(a):.6f} Y{tip[1]:.6f} Z{tip[2] + reach * (math.cos(a) - 1):.6f}"

    offset = f"G43.1 Z{length}" if length else "G49"
    out = machined(tmp_path, HEAD, offset, "G0 Z200", "G0 B20", f"G0 {at(60)}", f"G1 {at(0)} F900")
    assert [f.code for f in out.findings] == []
    close(out, math.pi * 9.0 * 9.0 / math.cos(a))


def test_a_machine_that_does_not_say_how_it_turns_is_refused(tmp_path):
    with pytest.raises(UsageError, match="moves A, and how these axes carry"):
        machined(tmp_path, None, "G0 A30", "G1 X10 F100")
    with pytest.raises(UsageError, match="has CB"):
        machined(tmp_path, HEAD, "G0 A30", "G1 X10 F100")


def test_faults_of_a_leaning_tool():
    """A rapid whose lower corner is 2 mm + R sin a below the top; a shank; a holder."""
    out = lean("flat:8", across(30), (-20, 15, -2), (60, 15, -2), rapid=True)
    (found,) = out.findings
    assert found.code == "cut-rapid"
    assert found.values["depth_mm"] == pytest.approx(2 + 4 * math.sin(math.radians(30)), abs=0.05)
    x, y, z = found.values["place_mm"]
    assert 0 <= x <= 40
    assert 0 <= y <= 30
    assert -4.1 <= z <= 0
    # Along the axis the material above the tip is 5 / cos a high at the middle, R tan a more at the side.
    out = lean("flat:8;length=3", across(30), (-20, 15, -5), (60, 15, -5))
    assert [f.code for f in out.findings] == ["cut-shank"]
    high = 5 / math.cos(math.radians(30)) + 4 * math.tan(math.radians(30)) - 3
    assert out.findings[0].values["depth_mm"] == pytest.approx(high, abs=0.2)
    out = lean("flat:8;holder=30,9", across(30), (-20, 15, -5), (60, 15, -5))
    assert [f.code for f in out.findings] == ["cut-holder"]
    assert [
        f.code for f in lean("flat:8;holder=30,20", across(30), (-20, 15, -5), (60, 15, -5)).findings
    ] == []


def test_beside_a_finished_slot_a_leaning_tool_may_go_at_rapid():
    """Through the slot again at rapid: it touches walls and floor all along, and enters nothing."""
    poses = Fixed(across(25))
    up = np.array([-20, 15, -5]) + 30 * poses.axis
    moves = [line(-20, 15, -5), line(60, 15, -5), line(-20, 15, -5, rapid=True)]
    out = lean_toolpaths(
        [path_of(tuple(up), *moves)], BOX, "t", poses, {"*": cutter_of_option("*=bull:8,1")}, None, 0.2
    )
    assert [f.code for f in out.findings] == []


def test_a_target_tells_gouges_and_what_is_left_of_leaning_tools(tmp_path):
    """The part has the inclined slot; a tool 1 mm deeper along its axis gouges it, one 1 mm higher leaves a floor."""
    from cncgen.removal.targets import MeshTarget

    def tips(out):
        y, z = np.array([15, -5]) + out * np.array(across(30))[1:]
        return (-20, y, z), (60, y, z)

    part = tmp_path / "part.stl"
    part.write_bytes(stl_bytes(*mesh_of(lean("flat:8", across(30), *tips(0), cell=0.2).stock)))
    target = MeshTarget.of_file(str(part))
    for out, code in ((0, None), (-1, "cut-gouge"), (1, "cut-left")):
        found = lean("flat:8", across(30), *tips(out), cell=0.2, target=target).findings
        assert {f.code for f in found} == ({code} if code else set())
        if code:
            depth = max(f.values["depth_mm"] for f in found)
            assert depth == pytest.approx(1 / math.cos(math.radians(30)), abs=0.3)


def test_tool_axes_of_step_nc_are_cut(tmp_path):
    """A slot with the tool's axis along a direction of ISO 14649-10, by an end mill of 10 mm."""
    part = Part()
    path = part.trajectory(
        part.polyline((-20, 15, -5), (60, 15, -5)), axis=part.polyline(across(30), across(30))
    )
    part.project(part.plan(part.step(part.freeform(path, tool=part.tool("T1", 10.0)))))
    program = tmp_path / "p.stp"
    program.write_text(part.text())
    out = cut(program, stock="box:0,0,-20,40,30,0", cell_mm=0.2)
    close(out, 40.0 * 10.0 * 5.0 / math.cos(math.radians(30)))


def test_a_mesh_of_many_nodes_takes_every_second_one(monkeypatch):
    """A slot in the block, 40 x 6 x 4 mm, whose mesh is that of a grid of 0.4 mm where 0.2 mm would have too many nodes."""
    out = lean("flat:6", (0, 0, 1), (-20, 15, -4), (60, 15, -4))
    whole = dexel_mesh(out.stock)[0]
    monkeypatch.setattr("cncgen.removal.dexels.MESH_NODES", 10**6)
    vertices, triangles = dexel_mesh(out.stock)
    assert len(vertices) < 0.3 * len(whole)
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    volume = float((np.cross(a, b) * c).sum() / 6)
    assert volume == pytest.approx(40 * 30 * 20 - 40 * 6 * 4, rel=5e-3)


def test_a_tool_that_turns_goes_in_pieces_as_short_as_the_stock_above_it_needs():
    """A quarter of a cell where a tool of 3 mm leaves the stock: 13 mm above its tip, or 23 mm beside it if it lies along X."""
    stock = dexels_of(BOX, 0.2)
    tips, axes = np.array([[20.0, 15.0, -10.0]] * 2), np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])
    levers = np.hypot([10.0 + 3.0, 20.0 + 3.0], 3.0)
    np.testing.assert_allclose(turns_of(stock, tips, axes, 3.0), 0.1 / levers)
