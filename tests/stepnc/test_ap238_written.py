"""AP238 as `convert` writes it, read by a reader that shares no line with ours, and by ours: motions, tools, raw piece."""

import io
import math
from pathlib import Path

import numpy as np
import pytest

from cncgen.gcode import read as read_gcode
from cncgen.removal.stock import stock_of_option
from cncgen.stepnc import gcode_lines, read, write_ap238
from cncgen.stepnc.cutting import cut_program
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import FeedMode, Kind
from tests.stepnc.aim import Aim
from tests.stepnc.building import E, Part
from tests.stepnc.other_reader import read_file

PROGRAMS = Path(__file__).parents[2] / "programs"
SMALL = [p for p in sorted(PROGRAMS.glob("*.nc")) if p.stat().st_size < 30_000]
WHOLE = ReadOptions(chunk_rows=10_000_000, workingsteps=True)


def one(program):
    chunks = list(program.chunks())
    assert not program.diagnostics.has_errors, [d.render() for d in program.diagnostics]
    return chunks[0]


def written(path, **more):
    stream = io.StringIO()
    write_ap238([path], stream, "part", **more)
    return stream.getvalue()


def from_gcode(text, options=WHOLE):
    return one(read_gcode(io.BytesIO(text.encode()), "t.ngc", options))


def test_a_program_that_does_nothing_is_a_file_that_is_read():
    """Its project was left out, and our own reader refused the file."""
    stream = io.StringIO()
    write_ap238(read_gcode(io.BytesIO(b"G21\nM2\n"), "t.ngc", WHOLE).chunks(), stream, "part")
    again = read(io.BytesIO(stream.getvalue().encode()), "t.stp")
    assert sum(int(np.sum(chunk.kind != Kind.EVENT)) for chunk in again.chunks()) == 0
    assert [d.code for d in again.diagnostics] == ["stepnc-no-motion"]


def compare(path, motions):
    """Assert that the other reader found what a toolpath says: ends, kinds, centres, feeds (mm/s), spindle (rev/s)."""
    rows = np.flatnonzero(path.kind != Kind.EVENT)
    assert len(rows) == len(motions)
    names = {Kind.LINE: "line", Kind.ARC: "arc", Kind.NURBS: "spline"}
    spindle = None
    events = iter(range(len(path)))
    for row, motion in zip(rows.tolist(), motions, strict=True):
        for k in events:
            if k == row:
                break
            event = path.events[int(path.curve[k])]
            if event.name == "spindle" and "direction" in event.values:
                # Against the clock is positive in AP238.
                spindle = -event.values["direction"] * event.values["speed_rpm"] / 60.0
        assert motion.kind == names[Kind(int(path.kind[row]))]
        ends = np.array([motion.points[0], motion.points[-1]])
        np.testing.assert_allclose(ends, [path.starts[row, :3], path.end[row, :3]], atol=1e-6)
        assert motion.rapid == (path.feed_mode[row] == FeedMode.RAPID)
        if motion.feed is not None and path.feed_mode[row] == FeedMode.SPEED:
            assert motion.feed == pytest.approx(path.feed[row], rel=1e-9)
        assert motion.rapid or motion.feed is not None or motion.pitch is not None
        if spindle is not None and not motion.rapid:
            assert motion.spindle is not None
            assert motion.spindle == pytest.approx(spindle, rel=1e-9)
        if motion.kind == "arc":
            index = int(path.curve[row])
            np.testing.assert_allclose(motion.curve[0], path.arcs.centre[index], atol=1e-6)
            np.testing.assert_allclose(motion.curve[1], path.arcs.normal[index], atol=1e-9)


@pytest.mark.parametrize("inches", [False, True])
@pytest.mark.parametrize("path", SMALL, ids=lambda p: p.stem)
def test_another_reader_finds_the_same_motions(path, inches):
    original = one(read_gcode(path, path.name, WHOLE))
    if set(original.axes) - set("XYZ"):
        pytest.skip("tool axes are compared in test_round_trips")
    compare(original, read_file(written(original, inches=inches)).motions)


def test_features_go_along_with_tools_steps_and_raw_piece():
    """The example's tools and block as its file has them: END MILL 10, BULL NOSE 8 R1, and a block of 100 x 70 x 20 mm."""
    source = PROGRAMS / "stepnc" / "features.stp"
    original = one(read(source, source.name, WHOLE))
    text = written(original)
    found = read_file(text)
    compare(original, found.motions)
    assert found.tools["END MILL 10"]["effective cutting diameter"] == pytest.approx(10.0)
    bull = found.tools["BULL NOSE 8 R1"]
    assert (bull["form"], bull["edge radius"]) == ("bullnose endmill", pytest.approx(1.0))
    drill = found.tools["DRILL 5"]
    assert 0 < drill["point angle"] < math.pi
    before = cut_program(source, "a.stp")
    after = cut_program(text.encode(), "b.stp")
    assert found.stock is not None
    assert found.stock[0] == "block"
    assert found.stock[2] == pytest.approx(before.raw[0].size)
    np.testing.assert_allclose(after.raw[0].frame, before.raw[0].frame, atol=1e-9)
    assert after.raw[0].size == pytest.approx(before.raw[0].size)
    steps = [m.step for m in found.motions]
    assert list(dict.fromkeys(steps))[:2] == ["clear step", "finish step wall"]
    again = one(read(io.BytesIO(text.encode()), "b.stp", WHOLE))
    tools = [[e for e in p.events if e.name == "tool"] for p in (original, again)]
    shared = ("diameter_mm", "edge_radius_mm", "point_angle_deg", "cutting_length_mm", "teeth", "length_mm")
    for a, b in zip(*tools, strict=True):
        assert {k: a.values.get(k) for k in shared} == pytest.approx({k: b.values.get(k) for k in shared})


@pytest.mark.parametrize("inches", [False, True])
@pytest.mark.parametrize(
    ("stock", "kind", "corner", "size"),
    [
        ("box:0,-5,-20,100,80,0", "block", [0, -5, -20], [100, 85, 20]),
        ("cylinder:10,20,50,-30,0", "cylinder", [10, 20, -30], [50, 30]),
    ],
)
def test_the_raw_piece_of_the_option(stock, kind, corner, size, inches):
    path = from_gcode("T1 M6 S1000 M3\nG0 X0 Y0 Z5\nG1 Z-1 F100\nM2\n")
    text = written(path, inches=inches, stock=stock_of_option(stock).solid_values())
    found = read_file(text).stock
    assert found is not None
    assert (found[0], found[1], found[2]) == (kind, pytest.approx(corner), pytest.approx(size))
    raw = cut_program(text.encode(), "t.stp").raw
    assert raw[0].kind == kind


def test_a_raw_piece_of_step_nc_maker_is_read():
    """Its words: a workpiece made from a block with length, width and height as measures, in inches."""
    aim = Aim(inches=True)
    step, operation = aim.step()
    aim.path(operation, aim.polyline((0, 0, 0), (25.4, 0, 0)), aim.technology())
    stock = {"kind": "block", "frame": np.eye(4).tolist(), "size": [70 * 25.4, 2540.0, 1270.0]}
    aim.file.project(aim.plan(step), "p", stock)
    text = aim.stream.getvalue()
    assert "LENGTH_MEASURE(70.)" in text
    raw = cut_program(
        f"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n{text}ENDSEC;\nEND-ISO-10303-21;\n".encode()
    ).raw
    assert raw[0].size == pytest.approx((1778.0, 2540.0, 1270.0))


def test_tools_of_the_tool_table(tmp_path):
    table = tmp_path / "tools.tbl"
    table.write_text("T3 P3 D12.5 Z50 ; END MILL\n")
    path = from_gcode("T3 M6 S1000 M3\nG0 X0 Y0 Z5\nG1 Z-1 F100\nM2\n", ReadOptions(tool_table=table))
    tools = read_file(written(path)).tools
    assert tools["3"]["effective cutting diameter"] == pytest.approx(12.5)


def test_a_tap_stays_in_step():
    """A tap of 1.25 mm goes there and back in step: one path of AP238 with the pitch as its feed per revolution."""
    part = Part()
    technology = part.add(
        "MILLING_TECHNOLOGY", 0.0125, E("TCP"), None, -10.0, None, E("T"), E("F"), E("F"), None
    )
    path = part.trajectory(part.polyline((0, 0, 5), (0, 0, -10), (0, 0, 5)))
    part.project(part.plan(part.step(part.freeform(path, technology=technology))))
    original = one(read(io.BytesIO(part.text().encode()), "t.stp", WHOLE))
    text = written(original)
    found = read_file(text).motions
    assert [m.pitch for m in found if not m.rapid] == pytest.approx([1.25, 1.25])
    again = one(read(io.BytesIO(text.encode()), "t.stp", WHOLE))
    pitches = [[e.values["pitch_mm"] for e in p.events if e.name == "synchronise"] for p in (original, again)]
    assert pitches[0] == pitches[1] == [1.25, None]
    gcode = "\n".join(gcode_lines([again]))
    assert "G33.1 Z-10 K1.25" in gcode


def test_a_thread_that_does_not_turn_back_is_g33():
    part = Part()
    technology = part.add(
        "MILLING_TECHNOLOGY", 0.02, E("TCP"), None, -10.0, None, E("T"), E("F"), E("F"), None
    )
    path = part.trajectory(part.polyline((0, 0, 5), (0, 0, -10)))
    part.project(part.plan(part.step(part.freeform(path, technology=technology))))
    original = one(read(io.BytesIO(part.text().encode()), "t.stp", WHOLE))
    assert "G33 Z-10 K2" in "\n".join(gcode_lines([original]))
    again = one(read(io.BytesIO(written(original).encode()), "t.stp", WHOLE))
    assert "G33 Z-10 K2" in "\n".join(gcode_lines([again]))


def test_convert_takes_the_raw_piece_and_refuses_it_for_gcode(tmp_path, cncgen):
    part, out = tmp_path / "part.nc", tmp_path / "part.stp"
    part.write_text("T1 M6 S1000 M3\nG0 X0 Y0 Z5\nG1 Z-1 F100\nM2\n")
    done = cncgen("convert", part, "-o", out, "--stock", "box:0,0,-5,9,9,0")
    assert done.returncode == 0, done.stderr
    stock = read_file(out.read_text()).stock
    assert stock is not None
    assert stock[2] == pytest.approx([9, 9, 5])
    done = cncgen("convert", part, "--stock", "box:0,0,-5,9,9,0")
    assert (done.returncode, b"error[usage]" in done.stderr) == (2, True)
