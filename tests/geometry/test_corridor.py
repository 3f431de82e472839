"""Pieces and the smooth spline within their corridor: closed forms, the bound of the deviation, seams."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from cncgen.geometry import corridor
from cncgen.geometry.corridor import END_DERIVATIVES, END_POINT, first_lengths, fit, split
from cncgen.geometry.path import ARC, LINE, Path
from cncgen.geometry.pieces import Pieces, pieces_of
from cncgen.geometry.tables import ArcTable, empty_arcs, empty_nurbs
from cncgen.kernels import smoothing

SCALE = np.ones(3)


def polyline(points: np.ndarray, tolerance: float = 0.01) -> Pieces:
    n = len(points) - 1
    path = Path("XYZ", points[0], [LINE] * n, points[1:], [-1] * n, empty_arcs(), empty_nurbs(3))
    return pieces_of(path, np.full(n, tolerance), SCALE).joined()


def facets(count: int, seed: int = 0, length: float = 0.2) -> np.ndarray:
    """Vertices on a smooth wavy curve."""
    s = np.arange(count + 1) * length
    phase = np.random.default_rng(seed).uniform(0, 6, 3)
    angle = np.sin(s / 9 + phase[0]) + 0.6 * np.sin(s / 4 + phase[1])
    points = np.cumsum(np.stack([np.cos(angle), np.sin(angle), 0.1 * np.sin(s / 7 + phase[2])], 1), axis=0)
    return points * length


def value(pieces: Pieces, t: np.ndarray) -> np.ndarray:
    """y(t), by plain indexing."""
    k = np.clip(np.searchsorted(pieces.t, t, side="right") - 1, 0, len(pieces.y) - 1)
    u = (t - pieces.t[k])[:, None]
    y = pieces.y[k]
    return y[:, 0] + u * (y[:, 1] + u * (y[:, 2] + u * y[:, 3]))


def misses(spline: corridor.Spline, pieces: Pieces, count: int = 20001) -> np.ndarray:
    """|x(t) − y(t)| by scipy's BSpline at many t."""
    t = np.linspace(spline.knots[4], spline.knots[-5], count)
    return np.linalg.norm(BSpline(spline.knots, spline.points, 4)(t) - value(pieces, t), axis=1)


def test_arc_pieces_stay_on_the_arc() -> None:
    """The Hermite pieces of a quarter of R5 miss its radius by at most their share of the tolerance."""
    arc = ArcTable(np.array([[0.0, 5, 0]]), np.array([[0.0, 0, 1]]), np.array([np.pi / 2]))
    path = Path("XYZ", [-10, 0, 0], [LINE, ARC], [[0, 0, 0], [5, 5, 0]], [-1, 0], arc, empty_nurbs(3))
    pieces = pieces_of(path, np.array([0.01, 0.01]), SCALE).joined()
    assert pieces.row[0] == 0
    assert set(pieces.row[1:]) == {1}
    points = value(pieces, np.linspace(10.0, pieces.t[-1], 2001))
    radius = np.hypot(points[:, 0], points[:, 1] - 5)
    np.testing.assert_allclose(radius, 5.0, atol=1e-3 * 0.01)
    np.testing.assert_allclose(pieces.bend[1:], 0.2, rtol=0.06)
    # The step of curvature at the joint, 0.2 / mm, sets the guess there.
    assert first_lengths(pieces)[1] == pytest.approx(np.sqrt(0.01 * 0.999 / (0.067 * 0.2)), rel=1e-2)


@pytest.mark.parametrize("length", [0.05, 0.3, 2.0])
def test_a_turn_is_rounded_as_the_closed_form_says(length: float) -> None:
    """Smoothing spline of order 3 across a turn of 0.02 rad: off by L |Δx'| / 3 at the turn (docs/smoothing.md)."""
    along = np.arange(1, 121)[:, None] * 0.25 * length
    points = np.vstack([-along[::-1] * [1, 0, 0], [[0, 0, 0]], along * [np.cos(0.02), np.sin(0.02), 0]])
    pieces = polyline(points, tolerance=1e9)
    knots, fixed, out = np.zeros(4000), np.zeros((4000, 3)), np.zeros((4000, 3))
    used, scale = np.zeros((240, 2)), np.full(241, length)
    last, _ = smoothing.fit(
        pieces.t, pieces.y, pieces.bend, pieces.tolerance, pieces.t[-1:], scale, scale.copy(), 0, 0.85,
        knots, 4, fixed, END_POINT, END_POINT, out, used,
    )  # fmt: skip
    at_turn = np.linalg.norm(BSpline(knots[: last + 5], out[:last], 4)(30 * length))
    # Knots a smoothing length apart carry the ideal spline to some per cent.
    assert at_turn == pytest.approx(length * 0.02 / 3, rel=0.1)


@given(st.integers(0, 10_000), st.sampled_from([0.001, 0.01, 0.1]))
@settings(max_examples=25)
def test_deviation_is_bounded_tightly(seed: int, tolerance: float) -> None:
    pieces = polyline(facets(200, seed), tolerance)
    spline = fit(pieces, np.zeros(0), END_POINT, END_POINT)
    worst = misses(spline, pieces).max() / tolerance
    assert worst <= spline.used <= 1.0
    assert spline.used <= worst + 0.06


def test_short_segments_are_smoothed_over_a_few_of_them() -> None:
    """On a circle of 0.2 mm chords with noise, knots stand 45 tolerances apart at most; on long rows further."""
    angle = np.arange(400) * 0.01
    noise = np.random.default_rng(5).normal(scale=0.001, size=(400, 3))
    circle = 20.0 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1) + noise
    spline = fit(polyline(circle), np.zeros(0), END_POINT, END_POINT)
    apart = np.diff(spline.knots[4:-4])
    assert np.median(apart) == pytest.approx(0.45, rel=0.1)
    long = fit(polyline(np.array([[0.0, 0, 0], [400, 0, 0], [800, 1, 0]])), np.zeros(0), END_POINT, END_POINT)
    assert np.diff(long.knots[4:-4]).max() > 50.0


def test_corners_of_a_zigzag_stay_within_the_tolerance() -> None:
    points = np.array([[k, (k % 2) * 3.0, 0.5 * (k % 3)] for k in range(30)])
    pieces = polyline(points)
    spline = fit(pieces, np.zeros(0), END_POINT, END_POINT)
    assert misses(spline, pieces, 400_001).max() <= 0.01


def test_facets_of_a_circle_vanish() -> None:
    """Chords of 2° on R20: a polyline turns by 0.035 at every vertex; |x'''| of the spline is near the circle's."""
    angle = np.radians(np.arange(0, 181, 2.0))
    points = np.stack([20 * np.cos(angle), 20 * np.sin(angle), 0 * angle], 1)
    pieces = polyline(points)
    spline = fit(pieces, np.zeros(0), END_POINT, END_POINT)
    x = BSpline(spline.knots, spline.points, 4)
    t = np.linspace(0.25, 0.75, 2001) * pieces.t[-1]
    np.testing.assert_allclose(np.linalg.norm(x(t, 3), axis=1), 1 / 20**2, rtol=0.5)
    np.testing.assert_allclose(np.linalg.norm(x(t, 2), axis=1), 1 / 20, rtol=0.01)


def test_ends_meet_the_path_in_point_or_in_three_derivatives() -> None:
    pieces = polyline(facets(60, 3))
    for mode, order in ((END_POINT, 0), (END_DERIVATIVES, 3)):
        spline = fit(pieces, np.zeros(0), mode, mode)
        x = BSpline(spline.knots, spline.points, 4)
        last = pieces.t[-1] - pieces.t[-2]
        end = pieces.y[-1, 0] + last * pieces.y[-1, 1]
        np.testing.assert_allclose(x(0.0), pieces.y[0, 0], atol=1e-12)
        np.testing.assert_allclose(x(pieces.t[-1]), end, atol=1e-12)
        for k in range(1, order + 1):
            exact = (pieces.y[0, 1], pieces.y[-1, 1]) if k == 1 else (0.0, 0.0)
            np.testing.assert_allclose(x(0.0, k), np.zeros(3) + exact[0], atol=1e-8)
            np.testing.assert_allclose(x(pieces.t[-1] * (1 - 1e-15), k), np.zeros(3) + exact[1], atol=1e-7)


def test_cuts_become_knots() -> None:
    pieces = polyline(facets(100, 5))
    cuts = pieces.t[[3, 17, 18, 60]]
    spline = fit(pieces, cuts, END_POINT, END_POINT)
    assert np.isin(cuts, spline.knots).all()
    assert np.all(np.diff(spline.knots[4:-4]) > 0)


def test_an_axis_that_stands_stands_on_the_curve() -> None:
    """Z moves between lines at two heights alone: elsewhere it does not move by a bit."""
    points = np.array([[0, 0, 0.1], [30, 0, 0.1], [30, 20, 0.1], [60, 20, 0.7], [60, 50, 0.7], [90, 50, 0.7]])
    spline = fit(polyline(points + 100.0), np.zeros(0), END_POINT, END_POINT)
    z = spline.points[:, 2]
    there = np.stack([spline.knots[1:-4], spline.knots[4:-1]])
    for stands, height in ((there[1] < 40.0, 100.1), (there[0] > 90.0, 100.7)):
        assert np.ptp(z[stands]) == 0.0
        assert z[stands][0] == pytest.approx(height, abs=1e-13)
    assert np.diff(z).max() > 0


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=15)
def test_other_units_give_the_same_curve(seed: int) -> None:
    """Round numbers, whose sums are round as well, times 25.4: as many knots, at the same places."""
    pick = np.random.default_rng(seed)
    steps = pick.integers(-3, 4, (12, 3)) * pick.choice([0.1, 0.45, 0.9, 5.0], (12, 1)) + [0.5, 0, 0]
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    one, other = (
        fit(polyline(unit * points, unit * 0.01), np.zeros(0), END_POINT, END_POINT) for unit in (1.0, 25.4)
    )
    assert one.spans == other.spans
    np.testing.assert_allclose(other.knots / 25.4, one.knots, atol=1e-8)
    np.testing.assert_allclose(other.points / 25.4, one.points, atol=1e-8)


def test_circles_are_cut_evenly() -> None:
    """Two turns of R5: L³ κ² is P from end to end, which the ends use 0.37 of, and knots stand as far apart as L."""
    turns = ArcTable(np.zeros((2, 3)), np.tile([0.0, 0, 1], (2, 1)), np.full(2, 2 * np.pi))
    path = Path("XYZ", [5, 0, 0], [ARC] * 2, [[5, 0, 0]] * 2, [0, 1], turns, empty_nurbs(3))
    pieces = pieces_of(path, np.full(2, 0.001), SCALE).joined()
    spline = fit(pieces, np.zeros(0), END_POINT, END_POINT)
    radius = np.linalg.norm(
        BSpline(spline.knots, spline.points, 4)(np.linspace(0.0, pieces.t[-1], 5001)), axis=1
    )
    assert np.abs(radius - 5.0).max() <= 0.45 * 0.001
    np.testing.assert_allclose(np.diff(spline.knots[4:-4]), np.cbrt(0.001 * 5.0**2), rtol=0.1)


def test_a_seam_goes_on_without_a_trace() -> None:
    """Two windows: one B-spline all the same, and what the second changes of the first fit is small."""
    points = facets(600, 8)
    whole = polyline(points)
    first = fit(polyline(points[:401]), np.zeros(0), END_POINT, 0)
    origin = 250
    span = int(np.searchsorted(first.knots, whole.t[origin] + 3.0)) - 4
    done, seam = split(first, span, float(whole.t[origin]))
    rest = polyline(points[origin:])
    second = fit(rest, np.zeros(0), END_POINT, END_POINT, seam)
    np.testing.assert_array_equal(second.knots[:9] + whole.t[origin], done.knots[-9:])
    np.testing.assert_array_equal(second.points[:4], done.points[-4:])
    joined = corridor.Spline(
        np.concatenate([done.knots, second.knots[9:] + whole.t[origin]]),
        np.concatenate([done.points, second.points[4:]]),
        0.0,
        second.deviation,
    )
    assert misses(joined, whole).max() <= 0.01


def test_a_seam_that_strains_is_met_by_shorter_lengths_behind_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a thousand windows of noisy lines one found no curve: lengths before a seam cannot mend what follows it."""
    points = facets(160, 88)
    points += np.random.default_rng(88).normal(size=points.shape) * [0.006, 0.006, 0.0]
    whole = polyline(points)
    first = fit(polyline(points[:101]), np.zeros(0), END_POINT, 0)
    span = first.spans - 4
    origin = int(np.searchsorted(whole.t, first.knots[4 + span], side="right")) - 1
    _, seam = split(first, span, float(whole.t[origin]))
    rest = polyline(points[origin:], 0.0095)
    assert misses(fit(rest, np.zeros(0), END_POINT, END_POINT, seam), rest).max() <= 0.0095
    monkeypatch.setattr(corridor, "_RETRY_FACTORS", ())
    with pytest.raises(corridor.CorridorError):
        fit(rest, np.zeros(0), END_POINT, END_POINT, seam)


@pytest.mark.parametrize("tolerance", [0.002, 0.01, 0.1])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_the_reverse_of_a_path_is_fitted_by_the_same_curve(noise: float, tolerance: float) -> None:
    """80 facets of 0.05 to 0.4 mm, two knots given. Once knots were laid from the start, and their number was another."""
    rng = np.random.default_rng(11)
    points = facets(720, length=0.05)[np.cumsum(rng.integers(1, 9, 80))] + rng.normal(
        scale=noise, size=(80, 3)
    )
    forth, back = polyline(points, tolerance), polyline(points[::-1], tolerance)
    one, other = (
        fit(way, way.t[at], END_POINT, END_POINT) for way, at in ((forth, [20, 33]), (back, [46, 59]))
    )
    np.testing.assert_allclose(other.points[::-1], one.points, atol=1e-8)
    np.testing.assert_allclose(other.knots[-1] - other.knots[::-1], one.knots, atol=1e-8)


def test_inches_give_the_same_curve() -> None:
    """2000 facets, a thousand knots: rounding of one round is not to multiply in the next ones. Once it was 10⁻⁵ mm."""
    rng = np.random.default_rng(3)
    points = facets(2000) + rng.normal(scale=0.002, size=(2001, 3)) + 100.0
    one = fit(polyline(points), np.zeros(0), END_POINT, END_POINT)
    other = fit(polyline(25.4 * points, 25.4 * 0.01), np.zeros(0), END_POINT, END_POINT)
    np.testing.assert_allclose(other.knots / 25.4, one.knots, atol=1e-9)
    np.testing.assert_allclose(other.points / 25.4, one.points, atol=1e-9)
