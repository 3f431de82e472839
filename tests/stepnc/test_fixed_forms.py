"""Outlines, patterns, placements and special knots of ISO 14649-10 and ISO 10303-42, beside closed forms and scipy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.interpolate import BSpline
from shapely import Polygon

from cncgen.stepnc.features.offsets import holds_circle, inradius
from cncgen.stepnc.geometry import frames, profile_shapes, splines
from cncgen.stepnc.geometry.contact import tips
from cncgen.stepnc.geometry.pieces import Nurbs


@pytest.mark.parametrize("sides", [3, 4, 6, 7])
@pytest.mark.parametrize("across_flats", [False, True])
def test_a_polygon_touches_the_circle_that_it_is_given(sides: int, across_flats: bool) -> None:
    """The corners lie on it, or the middles of the sides; the first side is parallel to X, at negative Y."""
    points = profile_shapes.regular_polygon(sides, 10.0, across_flats).points
    assert points[0].tolist() == points[-1].tolist()
    middles = 0.5 * (points[1:] + points[:-1])
    touching = middles if across_flats else points
    assert np.linalg.norm(touching, axis=1) == pytest.approx(np.full(len(touching), 5.0))
    assert points[0, 1] == pytest.approx(points[1, 1])
    assert points[0, 1] < 0.0
    x, y = points[:-1, 0], points[:-1, 1]
    # The area of a regular polygon in the circle of radius R is n R²/2 sin(2π/n), positive against the clock.
    radius = 5.0 / (math.cos(math.pi / sides) if across_flats else 1.0)
    area = 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert area == pytest.approx(0.5 * sides * radius**2 * math.sin(2.0 * math.pi / sides))


@pytest.mark.parametrize("sweep", [math.pi / 2, -math.pi / 3, 2.0 * math.pi])
def test_a_circular_path_begins_on_x_and_turns_by_its_sweep(sweep: float) -> None:
    """The end is the start turned about Z; the normal tells the sense."""
    arc = profile_shapes.circular_path(3.0, sweep)
    assert arc.start.tolist() == [3.0, 0.0, 0.0]
    assert arc.end == pytest.approx([3.0 * math.cos(sweep), 3.0 * math.sin(sweep), 0.0])
    assert (arc.normal[2], arc.sweep) == (math.copysign(1.0, sweep), abs(sweep))


def test_copies_of_a_rectangular_pattern_stand_row_by_row() -> None:
    """Two rows 5 mm apart along Y of three columns 2 mm apart along X."""
    found = profile_shapes.rectangular_places(2, 3, np.array([0.0, 5.0, 0.0]), np.array([2.0, 0.0, 0.0]))
    places = [tuple(frame[:2, 3]) for frame in found]
    assert places == [(0, 0), (2, 0), (4, 0), (0, 5), (2, 5), (4, 5)]


@pytest.mark.parametrize(
    ("axis", "reference"),
    [(None, None), ((0, 0, 2), None), ((1, 0, 0), None), ((1, 2, 3), (0, 1, 1)), ((0, 0, -1), (1, 1, 5))],
)
def test_a_placement_is_a_rotation_with_its_axis_and_reference(
    axis: tuple[float, ...] | None, reference: tuple[float, ...] | None
) -> None:
    """ISO 10303-42: orthonormal and right-handed; Z along the axis, and the reference in the plane of X and Z, X forward."""
    z, x = (None if each is None else np.array(each, float) for each in (axis, reference))
    frame = frames.from_axes(np.array([7.0, 8.0, 9.0]), z, x)
    turn = frame[:3, :3]
    assert turn.T @ turn == pytest.approx(np.eye(3), abs=1e-15)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    wanted = np.array([0.0, 0.0, 1.0]) if z is None else z / np.linalg.norm(z)
    assert turn[:, 2] == pytest.approx(wanted)
    if x is not None:
        assert turn[:, 1] @ x == pytest.approx(0.0, abs=1e-15)
        assert turn[:, 0] @ x > 0.0
    assert frames.apply(frame, np.zeros((1, 3))).tolist() == [[7.0, 8.0, 9.0]]
    back = frames.apply(np.linalg.inv(frame), frames.apply(frame, np.eye(3)))
    assert back == pytest.approx(np.eye(3), abs=1e-12)


@pytest.mark.parametrize(("spans", "degree"), [(1, 2), (3, 2), (2, 3)])
def test_a_piecewise_bezier_curve_is_its_bernstein_polynomials(spans: int, degree: int) -> None:
    """Each span by itself, Σ C(p, i) uⁱ (1 − u)^(p − i) P_i."""
    rng = np.random.default_rng(spans + 10 * degree)
    points = rng.normal(size=(spans * degree + 1, 3))
    knots = splines.bezier_knots(len(points), degree)
    curve = Nurbs(degree, points, np.ones(len(points)), knots)
    u = np.linspace(0.0, 1.0, 9)[:-1]
    for span in range(spans):
        own = points[span * degree : (span + 1) * degree + 1]
        expected = sum(
            math.comb(degree, i) * (u**i * (1.0 - u) ** (degree - i))[:, None] * own[i]
            for i in range(degree + 1)
        )
        assert splines.evaluate(curve, span + u) == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_special_knots_make_the_curves_that_scipy_makes_of_them(degree: int) -> None:
    """Uniform: equidistant, from the first parameter 0 on; quasi-uniform: the same, with its end points met."""
    points = np.random.default_rng(degree).normal(size=(7, 3))
    uniform, quasi = splines.uniform_knots(7, degree), splines.quasi_uniform_knots(7, degree)
    assert np.diff(uniform).tolist() == [1.0] * (7 + degree)
    assert uniform[degree] == 0.0
    for knots in (uniform, quasi):
        curve = Nurbs(degree, points, np.ones(7), knots)
        u = np.linspace(knots[degree], knots[-degree - 1], 33)
        assert splines.evaluate(curve, u) == pytest.approx(BSpline(knots, points, degree)(u), abs=1e-13)
    met = splines.evaluate(Nurbs(degree, points, np.ones(7), quasi), np.array([0.0, 7.0 - degree]))
    assert met == pytest.approx(points[[0, -1]], abs=1e-13)


def test_the_nearest_place_on_a_circle_lies_on_the_ray_from_its_centre() -> None:
    """At the distance | |p| − r |, for points inside and outside."""
    circle = splines.ellipse_arc(
        np.zeros(3), np.array([5.0, 0, 0]), np.array([0, 5.0, 0]), 0.0, 2.0 * math.pi
    )
    for angle, size in ((0.7, 8.0), (4.0, 2.0), (2.0, 5.0)):
        ray = np.array([math.cos(angle), math.sin(angle), 0.0])
        u, distance = splines.nearest_parameter(circle, size * ray)
        assert distance == pytest.approx(abs(size - 5.0), abs=1e-9)
        assert splines.evaluate(circle, np.array([u]))[0] == pytest.approx(5.0 * ray, abs=1e-6)


def test_the_largest_circle_in_a_triangle_and_in_a_rectangle() -> None:
    """In an equilateral triangle of side a its radius is a/(2 √3), in a rectangle half of the shorter side."""
    triangle = Polygon([(0.0, 0.0), (6.0, 0.0), (3.0, 3.0 * math.sqrt(3.0))])
    radius, centre = inradius(triangle)
    assert radius == pytest.approx(6.0 / (2.0 * math.sqrt(3.0)), abs=1e-5)
    assert centre == pytest.approx([3.0, math.sqrt(3.0)], abs=1e-2)
    assert inradius(Polygon([(0, 0), (20, 0), (20, 4), (0, 4)]))[0] == pytest.approx(2.0, abs=1e-5)
    assert holds_circle(triangle, 1.73)
    assert not holds_circle(triangle, 1.74)


@pytest.mark.parametrize("lean", [0.0, 0.3, 1.2])
def test_a_ball_touches_a_plane_wherever_its_tool_leans(lean: float) -> None:
    """The centre of the ball is R off the plane along its normal, and the tip R from the centre against the axis."""
    normal, axis = np.array([[0.0, 0.0, 1.0]]), np.array([[math.sin(lean), 0.0, math.cos(lean)]])
    tip = tips(np.array([[4.0, 5.0, 0.0]]), normal, axis, 3.0, 3.0)
    assert tip + 3.0 * axis == pytest.approx(np.array([[4.0, 5.0, 3.0]]))


def test_a_square_cutter_that_leans_touches_with_its_rim() -> None:
    """The rim's lowest point is R cos θ to the side of the tip, and R sin θ below it."""
    lean = 0.4
    axis = np.array([[math.sin(lean), 0.0, math.cos(lean)]])
    tip = tips(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), axis, 3.0, 0.0)[0]
    assert tip == pytest.approx([-3.0 * math.cos(lean), 0.0, 3.0 * math.sin(lean)])
    upright = tips(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 0.0, 1.0]]), 3.0, 0.0)
    assert upright.tolist() == [[0.0, 0.0, 0.0]]
