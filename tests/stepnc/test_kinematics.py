"""Tool axes in the rotary axes of five-axis machines, in the table, the head or one in each, against rotations multiplied out here."""

import io
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.diagnostics import UsageError
from cncgen.machine.kinematics import Kinematics
from cncgen.stepnc import read
from cncgen.stepnc.execution.rotary_axes import ALONG, RotaryAxes
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import Kind
from tests.stepnc.building import Part

CENTRE, PIVOT = np.array([5.0, -3.0, -100.0]), 150.0
PAIRS = ["CB", "CA", "AB", "BA"]


def about(letter, angle):
    """The rotation about an axis by the right hand (Rodrigues)."""
    k = np.eye(3)["ABC".index(letter)]
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


@dataclass
class Machine:
    """A machine's rotary axes by their letters: the one that carries the other first, or the head's before the table's."""

    letters: str
    heads: int
    tolerance: float = 0.001

    @property
    def axes(self):
        return tuple(3 + "ABC".index(letter) for letter in self.letters)

    @property
    def turns(self):
        return (1, 0) if self.heads == 2 else (0, 1)

    def machine(self, tip, angles, length):
        first, second = np.radians(angles)
        one, two = self.letters
        tip, arm = np.asarray(tip), np.array([0, 0, length + PIVOT])
        if self.heads == 2:
            return tuple(tip + about(one, first) @ about(two, second) @ arm - [0, 0, PIVOT])
        if self.heads == 1:
            return tuple(
                CENTRE + about(two, -second) @ (tip - CENTRE) + about(one, first) @ arm - [0, 0, PIVOT]
            )
        turned = about(one, -first) @ about(two, -second) @ (tip - CENTRE)
        return tuple(CENTRE + turned + [0, 0, length])

    def lever(self, tip, angles, length):
        """The slides' way for a tip that stands equals the tip's for slides that stand: both are the same turn about the same axis."""
        turned = np.radians(1e-3) * np.eye(2)
        ways = [
            np.subtract(
                self.machine(tip, angles + np.degrees(t), length),
                self.machine(tip, angles - np.degrees(t), length),
            )
            for t in turned
        ]
        return np.linalg.norm(ways) / (2.0 * turned[0, 0])


def machine_of(turn_tilt, heads):
    """The machine whose axes turn and tilt so: in a head the turning axis carries the other, in a table it is carried."""
    return Machine(turn_tilt if heads == 2 else turn_tilt[::-1], heads)


@pytest.mark.parametrize("heads", [0, 1, 2])
@pytest.mark.parametrize("pair", PAIRS)
@given(
    tip=st.tuples(*[st.floats(-300.0, 300.0)] * 3),
    angles=st.tuples(*[st.floats(-200.0, 200.0)] * 2),
    length=st.floats(0.0, 200.0),
)
def test_the_lever_of_the_tip(pair, heads, tip, angles, length):
    machine = machine_of(pair, heads)
    ours = Kinematics(heads, machine.axes, tuple(CENTRE), PIVOT)
    assert ours.lever(tip, angles, length) == pytest.approx(
        machine.lever(tip, np.array(angles), length), rel=1e-5, abs=1e-5
    )


@pytest.mark.parametrize("heads", [0, 1, 2])
@pytest.mark.parametrize("pair", PAIRS)
@given(
    lean=st.floats(0.0, 3.1),
    around=st.floats(-3.1, 3.1),
    before=st.tuples(st.floats(-9, 9), st.floats(-9, 9)),
)
def test_angles_turn_the_tool_into_its_axis(pair, heads, lean, around, before):
    axis = np.array([math.sin(lean) * math.cos(around), math.sin(lean) * math.sin(around), math.cos(lean)])
    machine = machine_of(pair, heads)
    kinematics = RotaryAxes.of(machine)
    assert kinematics.letters == "".join(sorted(pair))
    angles = dict(zip(kinematics.letters, kinematics.angles_of(axis, before), strict=True))
    turn, tilt = pair
    made = about(turn, angles[turn]) @ about(tilt, angles[tilt]) @ [0, 0, 1]
    # Within ALONG of the turning axis that has no say in where the tool leans to.
    aside = math.hypot(*np.delete(axis, "ABC".index(turn)))
    close = 1e-8 if aside > ALONG else 2 * ALONG
    np.testing.assert_allclose(made, axis, atol=close)
    # The way along the axis is the spindle's: of a head turned by its own angles, else Z, which a table turns the workpiece to.
    degrees = tuple(math.degrees(angles[letter]) for letter in machine.letters)
    far, near = (np.array(machine.machine(tuple(p), degrees, 0.0)) for p in (20.0 * axis, np.zeros(3)))
    spindle = (about(tilt, angles[tilt]) @ [0, 0, 1], axis)[heads - 1] if heads else np.array([0, 0, 1])
    expected = 20.0 * spindle
    np.testing.assert_allclose(far - near, expected, atol=20 * close + 1e-6)


def test_the_nearer_solution_is_taken_and_upright_tools_do_not_turn():
    kinematics = RotaryAxes.of(machine_of("CA", 0))
    axis = np.array([0.0, -math.sin(0.3), math.cos(0.3)])
    assert kinematics.angles_of(axis, (0.0, 0.0)) == pytest.approx((0.3, 0.0))
    assert kinematics.angles_of(axis, (-0.2, 3.0)) == pytest.approx((-0.3, math.pi))
    assert kinematics.angles_of(np.array([0.0, 0, 1]), (0.5, 1.25)) == (0.0, 1.25)


def test_a_machine_whose_axes_do_not_tilt_is_refused():
    with pytest.raises(UsageError):
        RotaryAxes.of(Machine("CA", 0))


def made_on(machine):
    """A line with a leaning tool, and an arc with the tool at 30 degrees, for a tool of 80 mm."""
    part = Part()
    edge = part.add("CUTTING_COMPONENT", 80.0, None, None, None, None)
    tool = part.tool(body="BALL_ENDMILL")
    values = list(part.instances[tool - 1].parts[0].parameters)
    values[2] = (edge,)
    part.fill(tool, "MILLING_CUTTING_TOOL", *values)
    first = part.trajectory(
        part.polyline((0, 0, 0), (40, 0, 0)), axis=part.polyline((0, 0, 1), (math.sin(0.6), 0, math.cos(0.6)))
    )
    part.project(part.plan(part.step(part.freeform(first, tool=tool))))
    program = read(
        io.BytesIO(part.text().encode()), "t.stp", ReadOptions(kinematics=machine, chunk_rows=10**7)
    )
    (path,) = program.chunks()
    assert [d for d in program.diagnostics if str(d.severity) == "error"] == []
    return program, path


@pytest.mark.parametrize("heads", [0, 1, 2])
@pytest.mark.parametrize("pair", PAIRS)
def test_lines_of_the_slides_keep_the_tip_on_its_path(pair, heads):
    """Between any two rows, at any place of the straight line of all axes, the tip is within the tolerance of its line."""
    machine = machine_of(pair, heads)
    program, path = made_on(machine)
    letters = "".join(sorted(pair))
    assert program.axes == "XYZ" + letters
    rows = np.flatnonzero((path.kind == Kind.LINE) & np.isfinite(path.feed))
    assert len(rows) > 60  # 34 degrees in steps of half a degree
    points = np.concatenate([path.starts[rows[:1]], path.end[rows]])
    middle = np.concatenate([(1 - f) * points[:-1] + f * points[1:] for f in (0.0, 0.3, 0.5, 1.0)])
    for row in middle:
        angles = dict(zip(letters, np.degrees(row[3:]), strict=True))
        degrees = tuple(angles[letter] for letter in machine.letters)
        # The machine's equation is affine in the tip: its inverse from the images of the origin and the axes.
        origin = np.array(machine.machine((0, 0, 0), degrees, 80.0))
        images = [np.array(machine.machine(tuple(e), degrees, 80.0)) - origin for e in np.eye(3)]
        tip = np.linalg.solve(np.stack(images, axis=1), row[:3] + np.array([0, 0, 80.0]) - origin)
        assert np.hypot(tip[1], tip[2]) < 1.5e-3
        assert -1e-3 < tip[0] < 40 + 1e-3
        turn, tilt = pair
        axis = about(turn, math.radians(angles[turn])) @ about(tilt, math.radians(angles[tilt])) @ [0, 0, 1]
        assert abs(axis[1]) < 1e-4


def test_the_feed_is_the_tips():
    """The slides of a fork head go a longer way while it leans: their speed is larger by as much."""
    machine = machine_of("CB", 2)
    _, path = made_on(machine)
    rows = np.flatnonzero((path.kind == Kind.LINE) & np.isfinite(path.feed))
    slid = np.linalg.norm(path.end[rows, :3] - path.starts[rows, :3], axis=1)
    assert (slid / path.feed[rows]).sum() == pytest.approx(40.0 / 20.0, rel=1e-6)
    assert path.feed[rows].max() > 40.0


def test_without_a_mechanism_the_tip_is_told():
    program, path = made_on(None)
    assert program.axes == "XYZBC"
    np.testing.assert_allclose(path.end[path.kind == Kind.LINE][-1], [40, 0, 0, 0.6, 0], atol=1e-12)


def test_a_circle_about_the_tables_axis_is_turned_by_the_table_alone():
    """30 mm at 20 mm/s about C, the tool leaning outwards: C turns by 2/3 rad/s, the slides stand still."""
    part = Part()
    t = np.linspace(0.0, 2 * math.pi, 73)
    ring = np.column_stack([CENTRE[0] + 30 * np.cos(t), CENTRE[1] + 30 * np.sin(t), np.zeros(73)])
    lean = np.column_stack([0.3 * np.cos(t), 0.3 * np.sin(t), np.ones(73)])
    curve, axis = (part.polyline(*map(tuple, p)) for p in (ring, lean))
    part.run_curve(curve, axis=axis)
    machine = Machine("AC", heads=False, tolerance=0.1)
    program = read(
        io.BytesIO(part.text().encode()), "t.stp", ReadOptions(kinematics=machine, chunk_rows=10**7)
    )
    (path,) = program.chunks()
    rows = np.flatnonzero((path.kind == Kind.LINE) & np.isfinite(path.feed))
    turned = path.end[rows, 4] - path.starts[rows, 4]
    assert np.abs(turned).sum() == pytest.approx(2 * math.pi, abs=1e-6)
    assert np.ptp(path.end[rows, :3], axis=0).max() < 0.2  # chords of 5 degrees stand for the circle: 0.03 mm
    way = np.linalg.norm(
        np.diff(np.concatenate([path.starts[rows[:1]], path.end[rows]])[:, :3], axis=0), axis=1
    )
    angle = np.linalg.norm(path.end[rows, 3:] - path.starts[rows, 3:], axis=1)
    time = (np.where(way > 0, way, angle) / path.feed[rows]).sum()
    chords = np.linalg.norm(np.diff(ring, axis=0), axis=1).sum()
    assert time == pytest.approx(chords / 20.0, rel=1e-6)


def swept(aside, pair="CB"):
    """A tool that leans from 20 degrees along X to 20 degrees the other way, `aside` beside the pole."""
    part = Part()
    lean = np.linspace(-0.35, 0.35, 15)
    axes = part.polyline(*[(math.sin(a), aside, math.cos(a)) for a in lean])
    part.run_curve(part.polyline(*[(k, 0, 0) for k in range(15)]), axis=axes)
    program = read(
        io.BytesIO(part.text().encode()),
        "t.stp",
        ReadOptions(kinematics=machine_of(pair, True), chunk_rows=10**7),
    )
    (path,) = program.chunks()
    fed = np.flatnonzero((path.kind == Kind.LINE) & np.isfinite(path.feed))
    rows = np.concatenate([path.starts[fed[:1]], path.end[fed]])
    return rows, [d.code for d in program.diagnostics], "".join(sorted(pair))


@pytest.mark.parametrize("aside", [0.0, 4e-6])
def test_through_the_pole_the_tilt_goes_on_and_nothing_turns(aside):
    """Also where the tool's axis is beside it by less than the last digit that a file gives."""
    rows, found, letters = swept(aside)
    turn, tilt = (rows[:, 3 + letters.index(c)] for c in "CB")
    assert found == []
    assert np.ptp(turn) < 4e-3  # 4e-6 over the lean of 0.0014 that comes nearest to the pole
    assert np.ptp(tilt) == pytest.approx(0.7, abs=1e-6)
    assert (np.diff(tilt) * np.sign(tilt[-1] - tilt[0]) >= -1e-12).all()


def test_beside_the_pole_the_turning_axis_swings_and_a_warning_says_so():
    """0.001 rad beside it: half a turn, less 2 * 0.001 / sin 20°, and the axis leads the tool along its way all the time."""
    rows, found, letters = swept(0.001)
    turn, tilt = (rows[:, 3 + letters.index(c)] for c in "CB")
    assert found == ["stepnc-singular"]
    assert np.ptp(turn) == pytest.approx(math.pi - 2 * math.atan2(0.001, math.sin(0.35)), abs=1e-4)
    y = np.sin(turn) * np.sin(tilt)
    assert np.abs(y - 0.001).max() < 2e-4


def test_turns_go_on_beyond_a_whole_one():
    """Three times round with the tool leaning outwards: C ends three turns farther on."""
    part = Part()
    t = np.linspace(0.0, 6 * math.pi, 109)
    ring = part.polyline(*[(10 * math.cos(a), 10 * math.sin(a), 0) for a in t])
    axes = part.polyline(*[(0.3 * math.cos(a), 0.3 * math.sin(a), 1) for a in t])
    path, found = part.run_curve(ring, axis=axes).read()
    assert found == []
    angles = path.end[path.kind == Kind.LINE, 4]
    assert angles[-1] - angles[0] == pytest.approx(6 * math.pi, abs=0.1)
    assert (np.diff(angles) >= -1e-9).all()
