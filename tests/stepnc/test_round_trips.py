"""G-code to AP238 to G-code keeps every motion; STEP-NC to G-code is what rs274 reads too."""

import io
import math
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cncgen.diagnostics import Diagnostics, UsageError
from cncgen.gcode import read as read_gcode
from cncgen.stepnc import canon, gcode_lines, read, write_ap238
from cncgen.stepnc.motion_lengths import motion_length
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import FeedMode, Kind
from tests.stepnc.building import E, Part

PROGRAMS = Path(__file__).parents[2] / "programs"
GCODE = sorted(p for p in PROGRAMS.glob("*.nc") if p.stat().st_size < 100_000)
STEPNC = sorted((PROGRAMS / "stepnc").glob("*.stp"))
WHOLE = ReadOptions(chunk_rows=10_000_000)


def one(program):
    """Return the toolpath of a small program."""
    chunks = list(program.chunks())
    assert not program.diagnostics.has_errors, [d.render() for d in program.diagnostics]
    return chunks[0]


def from_gcode(text: str):
    return one(read_gcode(io.BytesIO(text.encode()), "t.ngc", WHOLE))


def motions(path):
    """Return what must be kept: kinds, ends, feeds of motions, and the curves."""
    rows = np.flatnonzero(path.kind != Kind.EVENT)
    rapid = path.feed_mode[rows] == FeedMode.RAPID
    feed = np.where(rapid, -1.0, path.feed[rows])
    return path.kind[rows], path.end[rows], feed


def in_force(path):
    """Return, motion by motion, the tool, spindle and coolant in force and what happened since the motion before.

    Tools are numbered as they come: STEP-NC names them by words, G-code by numbers.
    """
    tools: dict[str, int] = {}
    tool, spindle, coolant, since, out = None, (0, 0.0), (False, False), [], []
    for row in range(len(path)):
        if path.kind[row] != Kind.EVENT:
            out.append((tool, spindle, coolant, tuple(since)))
            since = []
            continue
        event = path.events[int(path.curve[row])]
        values = event.values
        if event.name == "tool":
            tool = tools.setdefault(str(values["tool"]), len(tools))
        elif event.name == "spindle":
            turning = values["direction"]
            spindle = (turning, round(values["speed_rpm"], 6) if turning else 0.0)
        elif event.name == "coolant":
            coolant = (bool(values["flood"]), bool(values["mist"]))
        else:
            since.append((event.name, event.dwell_s, values.get("text"), values.get("kind")))
    return out, since


def same(a, b):
    kind_a, end_a, feed_a = motions(a)
    kind_b, end_b, feed_b = motions(b)
    np.testing.assert_array_equal(kind_a, kind_b)
    np.testing.assert_allclose(end_a[:, :3], end_b[:, :3], atol=1e-6)
    np.testing.assert_allclose(feed_a, feed_b, rtol=1e-7)
    rows_a, rows_b = (np.flatnonzero(p.kind != Kind.EVENT) for p in (a, b))
    np.testing.assert_array_equal(a.path_mode[rows_a], b.path_mode[rows_b])
    np.testing.assert_allclose(a.tolerance[rows_a], b.tolerance[rows_b], atol=1e-9)
    assert in_force(a) == in_force(b)
    np.testing.assert_allclose(a.start[:3], b.start[:3], atol=1e-6)
    np.testing.assert_allclose(a.arcs.centre, b.arcs.centre, atol=1e-6)
    np.testing.assert_allclose(a.arcs.normal, b.arcs.normal, atol=1e-9)
    np.testing.assert_allclose(a.arcs.sweep, b.arcs.sweep, atol=1e-6)
    np.testing.assert_array_equal(a.nurbs.degree, b.nurbs.degree)
    np.testing.assert_allclose(a.nurbs.control_points[:, :3], b.nurbs.control_points[:, :3], atol=1e-6)
    for table in ("point_offset", "knot_offset"):
        np.testing.assert_array_equal(getattr(a.nurbs, table), getattr(b.nurbs, table))
    for k in range(len(a.nurbs)):  # weights and knots up to a common factor, knots up to a shift
        p = slice(*a.nurbs.point_offset[k : k + 2])
        q = slice(*a.nurbs.knot_offset[k : k + 2])
        w, v = a.nurbs.weights[p], b.nurbs.weights[p]
        np.testing.assert_allclose(w / w[0], v / v[0], rtol=1e-7)
        np.testing.assert_allclose(a.nurbs.knots[q], b.nurbs.knots[q], atol=1e-8)


def test_tolerances_without_a_word_at_the_control_are_told():
    """FANUC's G64 takes no address (B-64304EN, cutting mode), LinuxCNC's has P."""
    text = b"G21 G90 F600\nG64 P0.02\nG1 X1\nG61\nX2\nG64 P0.05\nX3\nG64\nX4\nM2\n"
    for control, words, told in (
        ("linuxcnc", ["G64", "G64 P0.02", "G61", "G64 P0.05", "G64"], 0),
        ("fanuc", ["G64", "G61", "G64"], 1),
    ):
        remarks = Diagnostics()
        lines = list(
            gcode_lines(read_gcode(io.BytesIO(text), "a.nc").chunks(), control=control, remarks=remarks)
        )
        assert [line for line in lines if line[:3] in ("G61", "G64")] == words
        assert [d.code for d in remarks] == ["gcode-tolerance"] * told
        assert all("P0.02, P0.05 (mm)" in d.message for d in remarks)


@pytest.mark.parametrize("inches", [False, True])
@pytest.mark.parametrize("path", GCODE, ids=lambda p: p.stem)
def test_gcode_to_ap238_to_gcode(path, inches):
    original = one(read_gcode(path, path.name, WHOLE))
    stream = io.StringIO()
    write_ap238([original], stream, path.name, inches)
    stepnc = one(read(io.BytesIO(stream.getvalue().encode()), "t.stp", WHOLE))
    same(original, stepnc)
    same(original, from_gcode("\n".join(gcode_lines([stepnc]))))


def test_what_is_switched_without_a_motion_after_it_goes_along():
    """The last M5 and M9 were lost, those before a stop too, and the spindle started after the dwell that waits for it."""
    text = """(START, X0 Y0 Z50)
        G21 G90 T3 M6
        S1200 M3
        G4 P2
        G0 X10 Z5
        M5
        M1
        S1500 M4 M8
        G1 X20 F500
        M9
        M5
        M30
    """
    original = from_gcode(text)
    stream = io.StringIO()
    write_ap238([original], stream, "t")
    again = one(read(io.BytesIO(stream.getvalue().encode()), "t.stp", WHOLE))
    for path in (original, again, from_gcode("\n".join(gcode_lines([again])))):
        seen, turning, flood = [], 0.0, False
        for event in path.events:
            if event.name == "spindle":
                turning = event.values["direction"] * event.values["speed_rpm"]
            elif event.name == "coolant":
                flood = event.values["flood"]
            elif event.name in ("dwell", "stop", "end") and event.dwell_s + (event.name != "dwell") > 0:
                seen.append((event.name, round(turning), flood))
        assert seen == [("dwell", 1200, False), ("stop", 0, False), ("end", 0, False)]
    assert not [e for e in again.events if e.name == "dwell" and e.dwell_s == 0.0]


def test_tools_spindle_coolant_dwells_stops_and_modes_go_along():
    """All that a program says between its motions, in three planes, modes of feed apart from G93 (a speed in AP238)."""
    text = """(START, X0 Y0 Z50)
        G21 G90 T3 M6 S1200 M3 M8
        G0 X10 Z5
        G61 G1 Z-1 F100
        G64 P0.02 X50 F400
        (MSG, Hello World)
        G4 P0.5
        G2 X50 Y20 I0 J10
        G18 G3 X30 Z-1 I-10 K0 F200
        G19 G2 Y40 Z-1 J10 K0
        M0
        G17 G64 G3 X30 Y40 Z-5 I5 J0 P3
        S2000 M4 M9
        M1
        G20 G1 X1 F10
        M5
        T12 M6 M3 S500 M7
        G95 G1 X2 F0.01
        M30
        """
    original = from_gcode(text)
    stream = io.StringIO()
    write_ap238([original], stream)
    stepnc = one(read(io.BytesIO(stream.getvalue().encode()), "t.stp", WHOLE))
    same(original, stepnc)
    same(original, from_gcode("\n".join(gcode_lines([stepnc]))))


@pytest.mark.parametrize(("unit", "pitch"), [("G21", 1.0), ("G20", 25.4)])
def test_taps_threads_and_probes_go_along(unit, pitch):
    """Feed and speed alone do not say that they go together, nor that a line ends where something is touched."""
    original = from_gcode(
        f"(START, X0 Y0 Z0)\n{unit} G90 S60 M3 F10\nG0 Z1\nG33.1 Z-1 K1\nG33 Z-2 K1\nG38.3 Z-3\nG1 Z0\nM2\n"
    )
    stream = io.StringIO()
    write_ap238([original], stream)
    stepnc = one(read(io.BytesIO(stream.getvalue().encode()), "t.stp", WHOLE))
    again = from_gcode("\n".join(gcode_lines([stepnc])))
    for path in (original, stepnc, again):
        said = [e for e in path.events if e.name in ("synchronise", "probe")]
        pitches = [e.values["pitch_mm"] for e in said if e.name == "synchronise"]
        assert pitches == [pytest.approx(pitch), None, pytest.approx(pitch), None]
        assert [bool(e.values.get("tap")) for e in said if e.name == "synchronise"] == [
            True,
            False,
            False,
            False,
        ]
        assert [bool(e.values.get("probing")) for e in said if e.name == "probe"] == [True, False]
        same(original, path)


@pytest.mark.parametrize(
    ("motion", "way"),
    [
        ("G1 X3 Y4", 5.0),
        ("G2 X10 Y10 Z2 J10", math.hypot(15.0 * math.pi, 2.0)),
        ("G5.1 X10 Y0 I5 J10", 5.0 * math.sqrt(5.0) + 2.5 * math.asinh(2.0)),
        ("G1 B30 C0", math.radians(30.0)),
    ],
)
def test_a_part_of_a_minute_becomes_a_speed_along_the_way(motion, way):
    """G93 F6 is 10 s for a motion: AP238 has speeds alone. Three quarters of a helix, and a parabola 10 wide and 5 high."""
    axes = " B0 C0" if "B" in motion else ""
    original = from_gcode(f"(START, X0 Y0 Z0{axes})\nG93 {motion} F6\nM2\n")
    stream = io.StringIO()
    write_ap238([original], stream)
    made = one(read(io.BytesIO(stream.getvalue().encode()), "t.stp", WHOLE))
    np.testing.assert_allclose(motions(made)[2], way / 10.0, rtol=1e-9)


def test_feeds_of_rotary_axes_alone_are_in_degrees():
    """1 rad/s after 1 mm/s, and 1 mm/s again: 60 mm/min and 10800/pi degrees/min (then 120), each said where it changes."""
    turn = 10800 / math.pi
    text = f"G1 X1 F60\nX2\nA30 F{turn:.9f}\nA60\nX3 A90 F60\nG1 A0 F120\nM2\n"
    original = from_gcode(f"(START, X0 Y0 Z0 A0)\n{text}")
    one_of_both = np.where(
        np.isclose(original.feed, 1.0), 1.0, original.feed
    )  # mm/s and rad/s to the last digit
    lines = list(gcode_lines([replace(original, feed=one_of_both)]))
    same(original, from_gcode("\n".join(lines)))
    feeds = [float(word[1:]) for line in lines for word in line.split() if word[0] == "F"]
    assert feeds == pytest.approx([60.0, turn, 60.0, 120.0])


def timed(path, rows):
    """Return how long motions take together at their feeds, s: 1/F in inverse time."""
    inverse = path.feed_mode[rows] == FeedMode.INVERSE_TIME
    lengths = [motion_length(path, k, np.stack([path.starts[k], path.end[k]])) for k in rows]
    return float(np.sum(np.where(inverse, 1.0, lengths) / path.feed[rows]))


@pytest.mark.parametrize("motion", ["G1 X3 Y4", "G3 X10 Y10 Z2 J10", "G5.1 X10 Y0 I5 J10", "G1 B30"])
@pytest.mark.parametrize("linearize", [None, 0.01])
def test_a_part_of_a_minute_stays_one_in_gcode(motion, linearize):
    """G93 F6 is 10 s, for one motion or for all the lines that it becomes; G6.2, which knows no G93, gets a speed."""
    axes = " B0" if "B" in motion else ""
    original = from_gcode(f"(START, X0 Y0 Z0{axes})\nG93 {motion} F6\nM2\n")
    made = from_gcode("\n".join(gcode_lines([original], linearize=linearize)))
    rows = np.flatnonzero((made.kind != Kind.EVENT) & (made.feed_mode != FeedMode.RAPID))
    assert timed(made, rows) == pytest.approx(10.0, rel=1e-6)
    np.testing.assert_allclose(made.end[rows[-1], :3], original.end[0, :3], atol=1e-9)


@pytest.mark.parametrize(
    ("states", "words"),
    [
        ([(True, False), (True, True)], ["M8", "M7"]),
        ([(True, False), (False, True)], ["M8", "M9", "M7"]),
        ([(True, True), (False, True)], ["M8", "M7", "M9", "M7"]),
        ([(True, True), (False, False)], ["M8", "M7", "M9"]),
    ],
)
def test_coolant_is_written_as_it_changes(states, words):
    """Flood and mist of workingsteps; M9 stops both, and what stays on is said again. The end of a tool stops it too."""
    part = Part()
    steps = []
    for k, (flood, mist) in enumerate(states):
        on = [E("T" if state else "F") for state in (flood, mist)]
        functions = part.add(
            "MILLING_MACHINE_FUNCTIONS", on[0], None, on[1], E("F"), None, (), E("F"), None, None, ()
        )
        path = part.trajectory(part.polyline((k, 0, 0), (k + 1, 0, 0)))
        steps.append(part.step(part.freeform(path, functions=functions)))
    part.project(part.plan(*steps))
    lines = list(gcode_lines([one(read(io.BytesIO(part.text().encode()), "t.stp", WHOLE))]))
    assert [line for line in lines if line in ("M7", "M8", "M9")][: len(words)] == words


def test_axes_that_ap238_has_no_place_for_are_refused():
    for text, axes in (("G0 A5", "XYZA"), ("G0 B5", "XYZB")):
        with pytest.raises(UsageError, match=f"not of axes {axes}"):
            write_ap238([from_gcode(f"{text}\nM2\n")], io.StringIO())


@pytest.mark.parametrize("path", STEPNC, ids=lambda p: p.stem)
def test_stepnc_to_gcode(path):
    original = one(read(path, path.name, WHOLE))
    lines = list(gcode_lines([original], describe=lambda line: f"line {line}"))
    same(original, from_gcode("\n".join(lines)))
    assert sum(line.startswith("(line ") for line in lines) >= 5


@pytest.mark.parametrize("path", GCODE, ids=lambda p: p.stem)
def test_lines_alone_stay_within_the_tolerance(path):
    original = one(read_gcode(path, path.name, WHOLE))
    lines = from_gcode("\n".join(gcode_lines([original], linearize=0.01)))
    assert not len(lines.arcs)
    assert not len(lines.nurbs)
    np.testing.assert_allclose(lines.end[-1, :3], original.end[-1, :3], atol=1e-6)


def rs274(text, folder):
    """Return what LinuxCNC's interpreter prints for a program."""
    target = folder / "part.ngc"
    target.write_text(text + "\n")
    command = ["rs274", "-g", "-n", "0", target]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout


@pytest.mark.peer
@pytest.mark.skipif(shutil.which("rs274") is None, reason="LinuxCNC's rs274 is not installed")
@pytest.mark.parametrize("path", STEPNC, ids=lambda p: p.stem)
def test_linuxcnc_reads_the_same_motions(path, tmp_path):
    """Against NIST's own output for its files, else ours: rs274 prints four decimals, rounded once more."""
    program = one(read(path, path.name, WHOLE))
    printed = rs274("\n".join(gcode_lines([program])), tmp_path)
    number = re.compile(r"-?\d+\.\d+|-?\d+")

    def calls(text):
        return [
            line[line.index(c) :]
            for line in text.splitlines()
            for c in ("STRAIGHT_", "ARC_FEED")
            if c in line
        ]

    if path.stem.startswith("nist"):
        expected = (PROGRAMS / "stepnc" / "nist_ex1.can").read_text()
    else:
        expected = "\n".join(canon(path, path.name))
    mine, theirs = calls(printed), calls(expected)
    motions = {"nist_ex1": 490, "nist_ex1E": 490, "features": 998, "plate_ap238": 874, "shaft": 149}[
        path.stem
    ]
    assert len(mine) == len(theirs) == motions
    for a, b in zip(mine, theirs, strict=True):
        assert a.split("(")[0] == b.split("(")[0]
        expected = [float(v) for v in number.findall(b)]
        np.testing.assert_allclose(
            [float(v) for v in number.findall(a)][: len(expected)], expected, atol=1.01e-4
        )


@pytest.mark.peer
@pytest.mark.skipif(shutil.which("rs274") is None, reason="LinuxCNC's rs274 is not installed")
@pytest.mark.parametrize("linearize", [None, 0.01])
@pytest.mark.parametrize("path", GCODE, ids=lambda p: p.stem)
def test_linuxcnc_reads_programs_that_went_through_ap238(path, linearize, tmp_path):
    """Where no spline is left, to the ends that are ours; the start is a rapid of its own before a cut."""
    stream = io.StringIO()
    write_ap238([one(read_gcode(path, path.name, WHOLE))], stream, path.name)
    stepnc = one(read(io.BytesIO(stream.getvalue().encode()), "t.stp", WHOLE))
    if linearize is None and len(stepnc.nurbs):
        pytest.skip("LinuxCNC has no G6.2")
    text = "\n".join(gcode_lines([stepnc], linearize=linearize))
    printed = rs274(text, tmp_path)
    calls = re.findall(r"(STRAIGHT_\w+|ARC_FEED)\(([^)]*)\)", printed)
    numbers = [[float(v) for v in values.split(",")] for _, values in calls]
    theirs = np.array(
        [n[:3] if c != "ARC_FEED" else (n[0], n[1], n[5]) for (c, _), n in zip(calls, numbers, strict=True)]
    )
    ours = from_gcode(text)
    ends = ours.end[ours.kind != Kind.EVENT][:, :3]
    begun = len(theirs) - len(ends)
    assert begun in (0, 1)
    np.testing.assert_allclose(theirs[begun:], ends, atol=1.01e-4)


def test_tool_axes_survive_ap238():
    """Five axes: positions and angles of every point, through the tool axis curves of the AIM."""
    part = Part()
    axis = part.polyline((0, 0, 1), (0.3, 0.1, 1), (0.5, -0.4, 0.8))
    part.run_curve(part.polyline((0, 0, 0), (10, 0, 0), (10, 20, 5)), axis=axis)
    original, found = part.read()
    assert found == []
    stream = io.StringIO()
    write_ap238([original], stream)
    again = one(read(io.BytesIO(stream.getvalue().encode()), "t.stp", WHOLE))
    assert again.axes == original.axes == "XYZBC"
    rows, same_rows = (np.flatnonzero(p.kind != Kind.EVENT) for p in (original, again))
    np.testing.assert_allclose(again.end[same_rows], original.end[rows], atol=1e-9)
    gcode = from_gcode("\n".join(gcode_lines([original])))
    np.testing.assert_allclose(gcode.end[gcode.kind != Kind.EVENT], original.end[rows], atol=1e-7)
