"""The tool's centre keeps its radius away from the path: against polygons and their distances, and by symmetry."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from shapely import LinearRing, Point, Polygon

from cncgen.gcode.codes.tool_centre import SMOOTH_TURN, CentreMove, CompensationError, ToolCentre


def follow(corners: list[complex], radius: float, left: bool) -> list[CentreMove]:
    """Compensate a closed polygon, entered by a straight move from far outside."""
    centre = ToolCentre(radius, left, 2.0 * corners[0])
    out = []
    for corner in [*corners, corners[0]]:
        out += centre.line(corner, None)
    return out + centre.finish()


def samples(pieces: list[CentreMove]) -> list[complex]:
    """Return points along the pieces from the end of the first."""
    at, out = pieces[0].end, []
    for piece in pieces[1:]:
        if piece.centre is None:
            out += [at + f * (piece.end - at) for f in np.linspace(0, 1, 12)]
        else:
            spoke = at - piece.centre
            sweep = cmath.phase((piece.end - piece.centre) / spoke)
            out += [piece.centre + spoke * cmath.exp(1j * f * sweep) for f in np.linspace(0, 1, 12)]
        at = piece.end
    return out


#: Corners on a circle, by the parts of the way around that lie between them.
polygons = st.lists(st.floats(0.3, 1.0), min_size=5, max_size=9).map(
    lambda parts: [2.0 * math.pi * sum(parts[:k]) / sum(parts) for k in range(len(parts))]
)


@given(polygons, st.floats(0.01, 0.49))
def test_outside_of_a_convex_polygon_every_point_is_a_radius_away(angles: list[float], part: float) -> None:
    """Clockwise with the tool left of the path: straight along the edges, rolling around the corners."""
    corners = [100.0 * cmath.exp(-1j * a) for a in angles]
    # The way in and out meets an edge in an inside corner, which needs an edge longer than the tool's radius.
    radius = part * min(abs(p - q) for p, q in pairwise([*corners, corners[0]]))
    ring = LinearRing([(c.real, c.imag) for c in corners])
    inside = Polygon(ring)
    for point in samples(follow(corners, radius, left=True)):
        assert ring.distance(Point(point.real, point.imag)) == pytest.approx(radius, abs=1e-9)
        assert not inside.contains(Point(point.real, point.imag))


def test_inside_a_square_the_corners_are_where_the_offset_lines_meet() -> None:
    """A square of 20 with a tool of radius 3: the centre runs on the square of 14 within it."""
    centre = ToolCentre(3.0, True, 0j)
    out = []
    for corner in (0 - 10j, 10 - 10j, 10 + 10j, -10 + 10j, -10 - 10j, 0 - 10j):
        out += centre.line(corner, None)
    ends = [piece.end for piece in out + centre.finish()]
    np.testing.assert_allclose(ends[1:], [7 - 7j, 7 + 7j, -7 + 7j, -7 - 7j, -7j], atol=1e-12)


def random_path(angles: list[float]) -> list[complex]:
    """Return corners of a path of long moves in these directions."""
    return [complex(p) for p in np.cumsum([40.0 * cmath.exp(1j * a) for a in angles])]


@given(st.lists(st.floats(-1.2, 1.2), min_size=3, max_size=8), st.booleans())
def test_a_mirrored_path_is_compensated_on_the_other_side(turns: list[float], left: bool) -> None:
    corners = random_path([float(a) for a in np.cumsum(turns)])
    plain = ToolCentre(2.0, left, 0j)
    mirrored = ToolCentre(2.0, not left, 0j)
    one = [p for c in corners for p in plain.line(c, None)] + plain.finish()
    other = [p for c in corners for p in mirrored.line(c.conjugate(), None)] + mirrored.finish()
    np.testing.assert_allclose([p.end.conjugate() for p in other], [p.end for p in one], atol=1e-9)
    assert [-p.turns for p in other] == [p.turns for p in one]


@given(st.lists(st.floats(-1.2, 1.2), min_size=3, max_size=8), st.floats(0.01, 30.0), st.integers(0, 3))
def test_a_change_of_units_on_the_way_scales_what_is_left(
    turns: list[float], factor: float, when: int
) -> None:
    # A turn of exactly the limit counts as smooth or not by the last digit.
    assume(all(abs(abs(turn) - SMOOTH_TURN) > 1e-9 for turn in turns))
    corners = random_path([float(a) for a in np.cumsum(turns)])
    plain, scaled = ToolCentre(2.0, True, 0j), ToolCentre(2.0, True, 0j)
    one, other, scale = [], [], 1.0
    for index, corner in enumerate(corners):
        if index == when:
            scaled.rescale(factor, "other")
            scale = factor
        one += [p.end for p in plain.line(corner, None)]
        other += [p.end / scale for p in scaled.line(corner * scale, None)]
    one += [p.end for p in plain.finish()]
    other += [p.end / scale for p in scaled.finish()]
    np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9)


def test_entry_arc_is_tangent_to_the_offset_arc_at_its_end() -> None:
    """From (0, 0) by G3 to (20, 20) about (0, 20), radius 3 inside: centre (c, 20) with 17 − c = |(c, 20)|."""
    centre = ToolCentre(3.0, True, 0j)
    centre.arc(20 + 20j, 20j, 1, None)
    (piece,) = centre.finish()
    c = (17.0**2 - 20.0**2) / (2 * 17.0)
    assert piece.centre == pytest.approx(complex(c, 20.0))
    assert piece.end == pytest.approx(17 + 20j)


def test_deferred_blocks_come_out_behind_the_moves_before_them() -> None:
    centre = ToolCentre(1.0, True, 0j)
    assert centre.defer("first") == ["first"]
    assert centre.line(10 + 0j, "a") == []
    assert centre.defer("waits") == []
    out = centre.line(20 + 0j, "b")
    assert [item if isinstance(item, str) else item.block for item in out] == ["a", "waits"]


def test_an_entry_no_longer_than_the_radius_is_refused() -> None:
    with pytest.raises(CompensationError) as caught:
        ToolCentre(4.0, True, 0j).line(1 + 0j, None)
    assert caught.value.code == "comp-entry"


def test_a_move_too_short_for_its_corners_is_said_once_and_made() -> None:
    centre = ToolCentre(4.0, True, 0j)
    found = []
    for end in [20 + 0j, 40 + 0j, 40 + 1j, 0 + 1j, 0 + 30j]:
        centre.line(end, None)
        found += [(end, remark.code, remark.refused) for remark in centre.take_remarks()]
    # The move of length 1 into the narrow slot is judged when the next one is known.
    assert found == [(0 + 1j, "comp-gouge", True)]
    centre.finish()
    assert centre.take_remarks() == []


@pytest.mark.parametrize("left", [True, False])
@pytest.mark.parametrize("radius", [1.5, 5.0])
@pytest.mark.parametrize("angle", [0.2, 1.4])
def test_an_arc_may_sweep_a_thousandth_more_than_programmed(left: bool, radius: float, angle: float) -> None:
    """Closed form: off the tangent by d, the arc's sweep grows by d r / R' (R' its offset radius); LinuxCNC's limit is 0.001."""
    tool = 1.0
    offset = radius - tool if left else radius + tool
    for growth, refused in ((0.00095, []), (0.00105, ["comp-gouge"]), (-0.00105, [])):
        centre = ToolCentre(tool, left, -20 + 0j, growth=0.001)
        turn = growth * offset / tool * (-1.0 if left else 1.0)
        heading = cmath.exp(1j * turn)
        middle = 1j * radius * heading
        end = middle - 1j * radius * heading * cmath.exp(1j * angle)
        centre.line(0j, None)
        centre.arc(end, middle, 1, None)
        out = heading * cmath.exp(1j * (angle + (-1.0 if left else 1.0)))  # away from the tool
        centre.line(end + 50.0 * out, None)
        assert [remark.code for remark in centre.take_remarks() if remark.refused] == refused


def test_an_arc_smaller_than_the_tool_is_refused() -> None:
    centre = ToolCentre(4.0, True, 0j)
    centre.line(20 + 0j, None)
    with pytest.raises(CompensationError, match="does not fit"):
        centre.arc(22 + 2j, 20 + 2j, 1, None)


@pytest.mark.parametrize("plane", ["G17", "G18"])
@pytest.mark.parametrize(
    "block",
    [
        "G28",
        "G53 G0 X1",
        "G55",
        "G92 X1",
        "G10 L2 P1 X1",
        "G43",
        "G61",
        "M6",
        "M64 P1",
        "G81 X1 Z-1 R1",
        "G41.1 D1",
    ],
)
def test_what_cannot_be_done_meanwhile_is_refused_in_its_line(
    run: Callable[..., Any], plane: str, block: str
) -> None:
    out = run(f"{plane} F100\nG41.1 D2\nG1 X20 Z20\nX40 Z5\n{block}\nM2\n", dialect="linuxcnc")
    assert [line for _, line, _ in out.errors] == [5]


def test_rows_keep_their_lines_and_the_path_stays_beside_the_contour(run: Callable[..., Any]) -> None:
    out = run("F100\nG41.1 D4\nG1 X20\nX40\n(remark)\nY-20\nG40 G0 X80\nM2\n", dialect="linuxcnc")
    assert out.errors == []
    moving = out.path.kind != 3
    assert out.path.line[moving].tolist() == [3, 4, 6, 6, 7]
    np.testing.assert_allclose(
        out.path.end[moving, :2], [[20, 2], [40, 2], [42, 0], [42, -20], [80, -20]], atol=1e-12
    )


def test_an_arc_right_after_compensation_is_refused(run: Callable[..., Any]) -> None:
    out = run("F100\nG41.1 D4\nG1 X20\nX40\nG40\nG2 X60 Y0 I10\nM2\n", dialect="linuxcnc")
    assert [(code, line) for code, line, _ in out.errors] == [("comp-exit", 6)]


def test_inverse_time_is_shared_by_the_pieces_of_a_move(run: Any) -> None:
    """A rolled corner and its line go at the speed that F means for the programmed line: here 20 mm, twice a minute."""
    text = "F100\nG42.1 D4\nG1 X10\nG93 X20 F1\nY-20 F2\nX0 F2\nG40 Y-40 F1\nM2"
    out = run(text.replace("Y-20", "Y20"))
    assert out.errors == []
    out = run("G41.1 D4\nF100 G1 X10\nG93 X20 F1\nY-20 F2\nX40 F2\nG40 Y-40 F1\nM2")
    assert out.errors == []
    # The line to Y-20 comes behind an arc of radius 2 about (20, 0), a quarter turn.
    rows = np.flatnonzero(out.path.feed_mode == 1)
    arcs = np.flatnonzero(out.path.kind == 1)
    corner = next(row for row in arcs if row in rows)
    seconds = 1.0 / out.path.feed[[corner, corner + 1]]
    lengths = np.array([np.pi, abs(out.path.end[corner + 1, 1] - out.path.end[corner, 1])])
    np.testing.assert_allclose(seconds, lengths / (20 * 2 / 60))
