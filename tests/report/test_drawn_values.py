"""What the pictures show, curve by curve: values in closed form, read back from the figure and from the SVG's text."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest

from cncgen.machine.record import Axis, Servo
from cncgen.planner.record import Limit, SharpCorner
from cncgen.report import drawing, plots
from cncgen.report.plot_data import PlotData, of_response, of_setpoints
from cncgen.report.svg import PICTURE, path_picture
from cncgen.servo.record import Response
from cncgen.setpoints.record import Setpoints

pytest.importorskip("matplotlib")

T = 0.001
#: A circle of 10 mm at 2 rad/s, followed 10 µm outside and 20 µm behind; A turns at 90°/s.
ANGLE = np.linspace(0.0, 6.0, 3001)
UNIT = np.column_stack([np.cos(ANGLE), np.sin(ANGLE)])
BEHIND = 0.02 * UNIT[:, ::-1] * [1.0, -1.0]
CIRCLE = PlotData(
    "circle", "XYA", T,
    command=np.column_stack([10.0 * UNIT, 45.0 * ANGLE]),
    position=np.column_stack([10.01 * UNIT + BEHIND, 45.0 * ANGLE - 0.5]),
    force=np.column_stack([3.0 * UNIT, ANGLE]), force_unit=("V", "", "rad/s"), force_bound=(10.0, np.nan, np.nan),
    contour=np.full(3001, 0.01),
)  # fmt: skip


def drawn(part: object) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the curves of a part of a figure; limits are horizontal dashes and no curves."""
    lines = [line for line in part.get_lines() if line.get_linestyle() != "--"]  # type: ignore[attr-defined]
    return [tuple(np.asarray(v, float) for v in line.get_data()) for line in lines]


def dashes(part: object) -> list[float]:
    """Return the heights of the limits of a part."""
    lines = [line for line in part.get_lines() if line.get_linestyle() == "--"]  # type: ignore[attr-defined]
    return [float(line.get_ydata()[0]) for line in lines]


def test_feed_of_the_command_and_of_the_axes() -> None:
    """20 mm/s, and 10.01/10 of it; the axis that turns has no part in either."""
    (part,) = plots.feed(CIRCLE).axes
    (time, command), (_, axes) = drawn(part)
    assert time[-1] == pytest.approx(6.0 / 2.0)
    # Before the first setpoint all stands, so the first difference is 0.
    assert (command[0], axes[0]) == (0.0, 0.0)
    assert command[1:] == pytest.approx(20.0, rel=1e-5)
    assert axes[1:] == pytest.approx(20.0 * math.hypot(10.01, 0.02) / 10.0, rel=1e-5)
    alone = plots.feed(replace(CIRCLE, position=None))
    assert len(drawn(alone.axes[0])) == 1
    turning = replace(CIRCLE, axes="A", command=CIRCLE.command[:, 2:], position=None)
    assert drawn(plots.feed(turning).axes[0])[0][1][1:] == pytest.approx(90.0, rel=1e-9)


def test_errors_in_thousandths() -> None:
    x, y, a, contour = plots.errors(CIRCLE).axes
    ((_, found),) = drawn(x)
    assert found == pytest.approx(-10.0 * UNIT[:, 0] - 20.0 * UNIT[:, 1], abs=1e-9)
    ((_, found),) = drawn(y)
    assert found == pytest.approx(-10.0 * UNIT[:, 1] + 20.0 * UNIT[:, 0], abs=1e-9)
    assert drawn(a)[0][1] == pytest.approx(500.0)
    assert drawn(contour)[0][1] == pytest.approx(10.0)
    labels = [part.get_ylabel() for part in (x, y, a, contour)]
    assert labels == [
        "X tracking error (µm)", "Y tracking error (µm)", "A tracking error (mdeg)", "contour error (µm)",
    ]  # fmt: skip


def test_forces_with_their_bounds() -> None:
    """An axis without a bound has no dashes, and no unit where none is known."""
    x, y, a = plots.force(CIRCLE).axes
    assert drawn(x)[0][1] == pytest.approx(3.0 * UNIT[:, 0])
    assert [dashes(part) for part in (x, y, a)] == [[10.0, -10.0], [], []]
    assert [part.get_ylabel() for part in (x, y, a)] == ["X drive (V)", "Y drive", "A drive (rad/s)"]
    assert [part.get_legend() is not None for part in (x, y, a)] == [True, False, False]


def test_derivatives_of_the_axes_beside_limits_in_the_units_of_files() -> None:
    """10 mm at 2 rad/s: 20 mm/s, 40 mm/s², 80 mm/s³; the limits of an axis that turns stand in degrees."""
    turning = Axis("A", math.pi, 2.0 * math.pi, 3.0 * math.pi)
    figure = plots.axes(replace(CIRCLE, limits={"A": turning}))
    parts = np.array(figure.axes).reshape(3, 3)
    for order, (part, other) in enumerate(zip(parts[:, 0], parts[:, 2], strict=True), start=1):
        ((_, found),) = drawn(part)
        assert np.abs(found[4:]).max() == pytest.approx(10.0 * 2.0**order, rel=1e-3)
        assert dashes(part) == []
        assert dashes(other) == [180.0 * order, -180.0 * order]
    assert parts[2, 2].get_ylabel() == "A jerk (deg/s³)"


def test_the_path_with_its_magnified_error() -> None:
    """A twentieth of 20 mm is 1 mm, 101 times 9.9 µm: 10 µm show as 1 mm outside, however far behind the axes are."""
    data = replace(CIRCLE, contour=np.full(3001, 0.0099))
    command, ring = (np.column_stack(xy) for xy in drawn(plots.path(data).axes[0]))
    assert command == pytest.approx(CIRCLE.command[:, :2])
    # The tangent at both ends is a chord of one side, which leaves a part of the lag across it.
    assert np.hypot(*ring[1:-1].T) == pytest.approx(11.0, rel=1e-6)
    still = replace(CIRCLE, command=np.ones((3, 3)), position=np.ones((3, 3)), contour=np.zeros(3))
    command, ring = (np.column_stack(xy) for xy in drawn(plots.path(still).axes[0]))
    assert (ring == command).all()


def test_a_map_has_one_scale_and_room_round_it() -> None:
    """0.04 of the longer side on all sides; as high as its rows ask, within bounds."""
    _, ((part,),) = drawing.new_figure("map")
    rows = np.array([[0.0, 10.0], [50.0, 30.0]])
    drawing.plane(part, [rows[:1], rows[1:]], ("a", "b"))
    assert part.get_xlim() == pytest.approx((-2.0, 52.0))
    assert part.get_ylim() == pytest.approx((8.0, 32.0))
    assert part.get_aspect() == 1.0
    assert drawing.map_size(np.array([[0.0, 0.0], [10.0, 5.0]])) == pytest.approx(4.0)
    assert drawing.map_size(np.array([[0.0, 0.0], [10.0, 1.0]])) == 2.6
    assert drawing.map_size(np.array([[0.0, 0.0], [1.0, 10.0]])) == 9.0


def test_curvature_over_length() -> None:
    """1/r of a helix of radius 10 and pitch 2π·5 is 10/(10² + 5²), at the length √(10² + 5²) times its angle."""
    helix = np.column_stack([10.0 * UNIT, 5.0 * ANGLE])
    figure = plots.curvature(replace(CIRCLE, axes="XYZ", command=helix))
    ((length, found),) = drawn(figure.axes[0])
    assert found == pytest.approx(10.0 / 125.0, rel=1e-5)
    assert length == pytest.approx(math.sqrt(125.0) * ANGLE[1:-1], rel=1e-5)


def test_data_of_setpoints_and_of_a_response() -> None:
    """Degrees in files, radians inside; corners in the columns of the program; bounds where the servo has one."""
    rows = np.column_stack([ANGLE, 2.0 * ANGLE])
    corner = SharpCorner(1, (1.0, 2.0, 3.0), 5.0, Limit.CORNER, 0.1)
    points = [Setpoints("ZX", T, 0, rows[:100]), Setpoints("ZX", T, 100, rows[100:])]
    found = of_setpoints(points, "t", corners=[corner])
    assert found.command == pytest.approx(rows)
    assert found.corners is not None
    assert found.corners.tolist() == [[3.0, 1.0]]
    turned = of_setpoints([Setpoints("XA", T, 0, rows)], "t", corners=[corner])
    assert turned.command == pytest.approx(rows * [1.0, 180.0 / math.pi])
    # The plan's corners are in X Y Z: where a column is none of them there is no mark.
    assert turned.corners is None
    saturated = np.zeros(rows.shape, bool)
    part = Response("XA", T, 0, rows, rows, rows, ("V", "rad/s"), saturated, np.full(len(rows), np.nan))
    servo = Servo("pi-p-feedforward", {"velocity_gain_1_s": 1.0, "integral_rate_1_s": 1.0,
                                       "position_gain_1_s": 1.0, "saturation_mm_s2": 7.5})  # fmt: skip
    data = of_response([part, part], "t", servos={"X": servo})
    assert data.force_bound[0] == 7.5
    assert math.isnan(data.force_bound[1])
    assert data.position is not None
    assert len(data.position) == 2 * len(rows)
    assert data.force is not None
    assert data.force[:, 0] == pytest.approx(np.tile(rows[:, 0], 2))


def test_marks_and_the_strip_of_speeds_lie_within_the_picture() -> None:
    """A square of 10 mm: 82 units a millimetre, its corner a mark; the strip runs up to the usual speed."""
    points = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])
    svg = ET.fromstring(path_picture(points, "XY", np.array([1.0, 5.0, 5.0]), points[1:2]))
    (mark,) = (e for e in svg.iter() if e.get("class") == "mark")
    assert [mark.get("cx"), mark.get("cy")] == ["860.0", "860.0"]
    strip = [e for e in svg.iter() if e.tag == "rect"]
    lefts = [float(e.get("x") or 0) for e in strip]
    assert np.diff(lefts) == pytest.approx([14.0] * 8)
    zero, name = [e for e in svg.iter() if e.tag == "text"][-2:]
    assert (zero.text, name.text) == ("0", "5 mm/s")
    assert float(zero.get("x") or 0) < lefts[0] < lefts[-1] + 14.0 < float(name.get("x") or 0) < PICTURE
