"""G64: deviation both ways, continuity, what is met exactly, feeds, lines and events, windows and chunks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cncgen.diagnostics import NoPlanError
from cncgen.geometry import nurbs
from cncgen.geometry.corridor import CorridorError
from cncgen.geometry.tables import ArcTable
from cncgen.planner.smoothing import smooth, stream
from cncgen.toolpath.record import Event, FeedMode, Kind, PathMode, Toolpath
from cncgen.toolpath.slicing import join
from tests.geometry.nearest import distances, samples
from tests.planner.smoothing.programs import chunked, facets, path_of, random_toolpath, toolpath


def smoothed(rows: Toolpath, size: int = 1000) -> Toolpath:
    return join(list(smooth(chunked(rows, size))))


def deviation(rows: Toolpath, result: Toolpath, most: int = 1500) -> float:
    """Largest distance from points of either path to the other, X Y Z, mm."""
    one, two = path_of(rows), path_of(result)
    if one.length == 0.0:
        return 0.0
    s, r = samples(one), samples(two)
    pick = np.random.default_rng(0)
    some, others = (np.unique(pick.choice(x, min(most, len(x)), replace=False)) for x in (s, r))
    some = np.union1d(some, one.row_s)
    there = distances(one.evaluate(some)[0], two, r).max()
    return float(max(there, distances(two.evaluate(others)[0], one, s).max()))


def assert_smooth(result: Toolpath, *exact: float) -> None:
    """Tangent, curvature and its derivative go on across every joint of two rows that were made, to rounding or to what
    is given for joints with rows that were not."""
    path = path_of(result)
    jumps = path.jumps()
    spline = (result.kind[jumps.before] == Kind.NURBS) & (result.kind[jumps.after] == Kind.NURBS)
    assert spline.any()
    for k, change in enumerate((jumps.tangent, jumps.second, jumps.third)):
        size = np.abs(path.evaluate(jumps.s[spline], 3)[k + 1]).max()
        assert np.abs(change[spline]).max() <= (exact[k] if exact else 1e-9 * (1 + size))


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=25)
def test_anything_stays_within_its_tolerance_and_keeps_its_events(seed: int) -> None:
    rows = random_toolpath(seed)
    result = smoothed(rows)
    assert deviation(rows, result) <= rows.tolerance.max() * (1 + 1e-9)
    assert [e.name for e in result.events] == [e.name for e in rows.events]
    np.testing.assert_array_equal(result.start, rows.start)
    np.testing.assert_allclose(result.end[-1], rows.end[-1], atol=1e-9)
    path = path_of(result)
    first = np.arange(len(result))
    begin = path.evaluate_parameter(first, path.parameter(first, path.row_s[:-1]))[0]
    np.testing.assert_allclose(begin, result.starts, atol=1e-9)
    assert np.all(np.diff(result.line) >= 0)


@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
@settings(max_examples=25)
def test_chunks_do_not_matter(seed: int, size: int) -> None:
    rows = random_toolpath(seed)
    one, other = smoothed(rows), smoothed(rows, size)
    np.testing.assert_array_equal(one.end, other.end)
    np.testing.assert_array_equal(one.nurbs.control_points, other.nurbs.control_points)
    np.testing.assert_array_equal(one.line, other.line)


def test_windows_make_one_smooth_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many small windows: within the tolerance, C3 over their seams, whatever the chunks."""
    monkeypatch.setattr(stream, "WINDOW", 256)
    rows = facets(2500)
    result = smoothed(rows)
    assert np.all(result.kind == Kind.NURBS)
    assert deviation(rows, result) <= 0.01
    assert_smooth(result)
    np.testing.assert_array_equal(result.end, smoothed(rows, 37).end)


def test_facets_become_fewer_and_smoother() -> None:
    """A smooth curve by chords of 0.2 mm: |x'''| of the result is near that of the curve, not of the chords."""
    result = smoothed(facets(1000))
    assert len(result) < 600
    path = path_of(result)
    s = np.linspace(2, path.length - 2, 5000)
    x3 = np.linalg.norm(path.evaluate(s, 3)[3], axis=1)
    # The curve's own: angle'' + curvature², with angle(s) as in `facets`.
    t = np.linspace(2, 198, 5000)
    bend = 1.5 / 13 * np.cos(t / 13) + 1.1 / 5.1 * np.cos(t / 5.1 + 1) + 0.4 / 1.7 * np.cos(t / 1.7) + 1 / 200
    change = 1.5 / 169 * np.sin(t / 13) + 1.1 / 5.1**2 * np.sin(t / 5.1 + 1) + 0.4 / 1.7**2 * np.sin(t / 1.7)
    assert x3.max() < 2.0 * np.hypot(bend**2, change).max()


def test_square_corners_and_rounded_corners() -> None:
    """Sharp corners are cut, R5 corners are not; both within the tolerance and smooth all along."""
    corners = [[50, 0, 0], [50, 50, 0], [0, 50, 0], [0, 0, 0]]
    sharp = toolpath([0, 0, 0], corners)
    result = smoothed(sharp)
    assert deviation(sharp, result) <= 0.01
    assert_smooth(result)
    assert path_of(result).length == pytest.approx(200 - 0.03, abs=0.01)
    # The tolerance stays the program's; what is left to chords stands beside it.
    assert set(result.tolerance) == {0.01}
    assert result.chord_room is not None
    assert (result.chord_room <= 0.01).all()
    centres = np.array([[45.0, 5, 0], [45, 45, 0], [5, 45, 0], [5, 5, 0]])
    arcs = ArcTable(centres, np.tile([0.0, 0, 1], (4, 1)), np.full(4, np.pi / 2))
    ends = [[45, 0, 0], [50, 5, 0], [50, 45, 0], [45, 50, 0], [5, 50, 0], [0, 45, 0], [0, 5, 0], [5, 0, 0]]
    rounded = toolpath([5, 0, 0], ends, [0, 1] * 4, [-1, 0, -1, 1, -1, 2, -1, 3], arcs)
    result = smoothed(rounded)
    assert deviation(rounded, result) <= 0.01
    assert_smooth(result)
    path = path_of(result)
    x3 = np.abs(path.evaluate(np.linspace(0, path.length, 20001), 3)[3]).max()
    # A ramp of some 0.7 mm to the curvature of 0.2: the corners are driven through at 60 mm/s and more.
    assert x3 < 0.5


@pytest.mark.parametrize(
    "columns",
    [
        {"path_mode": PathMode.EXACT_PATH},
        {"path_mode": PathMode.EXACT_STOP},
        {"tolerance": 0.0},
        {"tolerance": np.nan},
    ],
)
def test_what_must_be_met_exactly_passes_unchanged(columns: dict) -> None:
    rows = toolpath([0, 0, 0], [[10, 0, 0], [10, 10, 0], [10, 20, 1]], **columns)
    result = smoothed(rows)
    np.testing.assert_array_equal(result.kind, rows.kind)
    np.testing.assert_array_equal(result.end, rows.end)


def test_rapids_are_rounded_and_joints_of_rapids_and_feeds_are_met_exactly() -> None:
    """Two rapids, two cuts and two rapids, at right angles: the second, third and fourth joint are within a run, or between two."""
    ends = [[10, 0, 0], [10, 10, 0], [10, 10, -5], [20, 10, -5], [20, 10, 5], [0, 10, 5]]
    swift = np.array([1, 1, 0, 0, 1, 1], bool)
    modes = np.where(swift, FeedMode.RAPID, FeedMode.SPEED).astype(np.int8)
    rows = toolpath([0, 0, 0], ends, feed=np.where(swift, 250.0, 50.0), feed_mode=modes)
    result = smoothed(rows)
    assert deviation(rows, result) <= rows.tolerance.max() * (1 + 1e-9)
    away = distances(np.array(ends, float), path_of(result), samples(path_of(result)))
    np.testing.assert_array_equal(away < 1e-9, [False, True, False, True, False, True])
    first = np.flatnonzero(np.diff(result.feed_mode, prepend=-1))
    assert result.feed_mode[first].tolist() == [FeedMode.RAPID, FeedMode.SPEED, FeedMode.RAPID]


#: A curve that begins along X at (10, 0) and ends along Y at (15, 5), without curvature at both ends.
BEND = nurbs.single(
    5, [0.0] * 6 + [1.0] * 6, [[10, 0, 0], [11, 0, 0], [12, 0, 0], [15, 3, 0], [15, 4, 0], [15, 5, 0]]
)


def test_a_single_motion_and_a_nurbs_pass_unchanged() -> None:
    table = BEND
    rows = toolpath([0, 0, 0], [[10, 0, 0], [15, 5, 0], [15, 9, 0]], [0, 2, 0], [-1, 0, -1], nurbs=table)
    result = smoothed(rows)
    np.testing.assert_array_equal(result.kind, [0, 2, 0])
    np.testing.assert_array_equal(result.nurbs.control_points, table.control_points)


def test_a_smooth_joint_with_an_exact_row_stays_smooth() -> None:
    """Two lines run into a curve smoothly: the run before it ends on the line in three derivatives."""
    table = BEND
    rows = toolpath([0, -5, 0], [[0, 0, 0], [10, 0, 0], [15, 5, 0]], [0, 0, 2], [-1, -1, 0], nurbs=table)
    result = smoothed(rows)
    path = path_of(result)
    x, x1, x2, x3 = path.evaluate([path.row_s[-2]], 3, -1)
    np.testing.assert_allclose(x, [[10, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(x1, [[1, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(x2, 0, atol=1e-8)
    np.testing.assert_allclose(x3, 0, atol=1e-6)


@pytest.mark.parametrize(
    ("before", "curve"),
    [
        # a turn of 45 degrees, a step of curvature at a tangent joint, two curves in a corner
        ([9, -1, 0], [[10, 0, 0], [30, 0, 0], [40, 20, 0]]),
        ([0, 0, 0], [[10, 0, 0], [30, 0, 0], [30, 20, 0]]),
    ],
)
def test_the_end_of_a_nurbs_at_a_corner_is_rounded(before: list, curve: list) -> None:
    table = nurbs.single(2, [0, 0, 0, 1, 1, 1], curve)
    rows = toolpath(before, [curve[0], curve[-1]], [0, 2], [-1, 0], nurbs=table)
    result = smoothed(rows)
    assert deviation(rows, result) <= 0.01
    assert_smooth(result, 1e-6, 1e-4, 0.02)
    # Beyond what the corner needs the curve is the programmed one.
    path, given = path_of(result), path_of(rows)
    far = np.linspace(0.8, 1.0, 20)
    there = path.evaluate(path.row_s[0] + far * path.length)[0]
    assert distances(there, given).max() < 1e-9


def test_a_nurbs_that_starts_at_rest_of_its_parameter_is_met_exactly() -> None:
    """Three control points in one: |dC/du| = 3 u² is one panel long, and has no tangent where the corner is."""
    control = [[10.0, 0, 0], [10, 0, 0], [10, 0, 0], [10, 5, 0]]
    table = nurbs.single(3, [0, 0, 0, 0, 1, 1, 1, 1], control)
    rows = toolpath([0, 0, 0], [control[0], control[-1]], [0, 2], [-1, 0], nurbs=table)
    result = smoothed(rows)
    assert result.kind.tolist() == [Kind.LINE, Kind.NURBS]
    np.testing.assert_array_equal(result.nurbs.control_points, control)


def test_two_curves_in_a_corner_are_rounded_and_short_ones_with_their_neighbours() -> None:
    tables = [
        nurbs.single(3, [0, 0, 0, 0, 1, 1, 1, 1], [[0, 0, 0], [5, 0, 0], [10, 1, 0], [10, 5, 0]]),
        nurbs.single(3, [0, 0, 0, 0, 1, 1, 1, 1], [[10, 5, 0], [10.1, 5, 0], [10.2, 5.1, 0], [10.2, 5.2, 0]]),
        nurbs.single(3, [0, 0, 0, 0, 1, 1, 1, 1], [[10.2, 5.2, 0], [15, 5.2, 0], [20, 7, 0], [25, 0, 0]]),
    ]
    ends = [table.control_points[-1].tolist() for table in tables]
    rows = toolpath([0, 0, 0], ends, [2, 2, 2], [0, 1, 2], nurbs=nurbs.concatenate(tables))
    result = smoothed(rows)
    assert deviation(rows, result) <= 0.01
    assert_smooth(result, 1e-6, 1e-4, 0.02)
    np.testing.assert_array_equal(np.unique(result.line), [1, 2, 3])


def test_parts_of_a_nurbs_by_inverse_time_keep_its_speed() -> None:
    table = nurbs.single(2, [0, 0, 0, 1, 1, 1], [[10, 0, 0], [30, 0, 0], [40, 20, 0]])
    rows = toolpath(
        [9, -1, 0], [[10, 0, 0], [40, 20, 0]], [0, 2], [-1, 0], nurbs=table, feed_mode=1, feed=0.5
    )
    result = smoothed(rows)
    length = np.diff(path_of(rows).row_s)
    speed = np.where(result.feed_mode == 1, result.feed * np.diff(path_of(result).row_s), result.feed)
    np.testing.assert_allclose(speed, 0.5 * length[result.line - 1], rtol=1e-3)


def test_a_reversal_is_met_exactly() -> None:
    rows = toolpath([0, 0, 0], [[5, 5, 0], [15, 5, 0], [6, 5, 0], [6, 9, 0]])
    result = smoothed(rows)
    assert distances(np.array([[15.0, 5, 0]]), path_of(result)).max() < 1e-9
    assert deviation(rows, result) <= 0.01


def test_feed_and_line_go_over_from_the_rows() -> None:
    feeds = np.repeat([50.0, 80.0, 20.0], 100)
    rows = facets(300, feed=feeds)
    result = smoothed(rows)
    np.testing.assert_array_equal(result.feed, feeds[result.line - 1])
    # A change of feed is where its row begins, to the tolerance.
    change = np.flatnonzero(np.diff(result.feed))
    assert len(change) == 2
    np.testing.assert_allclose(result.end[change], rows.end[[99, 199]], atol=0.01)


def test_feeds_that_differ_by_rounding_are_one_feed() -> None:
    """Where the lines meet they turn by so little that no knot is laid for that."""

    def knots(feed: float) -> np.ndarray:
        return smoothed(toolpath([0, 0, 0], [[5, 1, 0], [10, 2.02, 0]], feed=[30.0, feed])).nurbs.knots

    np.testing.assert_array_equal(knots(30.0 * (1 + 2e-16)), knots(30.0))
    vertex = np.sqrt(26.0)
    assert np.abs(knots(30.1) - vertex).min() < 1e-9 < np.abs(knots(30.0) - vertex).min()


def test_inverse_time_becomes_the_speed_of_the_row() -> None:
    rows = toolpath([0, 0, 0], [[3, 0, 0], [3, 4, 0]], feed=[2.0, 0.5], feed_mode=FeedMode.INVERSE_TIME)
    result = smoothed(rows)
    assert set(result.feed_mode) == {FeedMode.SPEED}
    assert set(zip(result.line, result.feed, strict=True)) == {(1, 6.0), (2, 2.0)}


def test_events_without_rest_stand_where_they_stood() -> None:
    rows = facets(200)
    end = np.insert(rows.end, 120, rows.end[119], axis=0)
    kind = np.insert(rows.kind, 120, Kind.EVENT)
    curve = np.insert(rows.curve, 120, 0)
    with_event = toolpath(rows.start, end, kind, curve, events=(Event("spindle"),))
    result = smoothed(with_event)
    at = int(np.flatnonzero(result.kind == Kind.EVENT)[0])
    np.testing.assert_allclose(result.end[at], rows.end[119], atol=0.01)
    np.testing.assert_array_equal(result.end[at], result.end[at - 1])
    assert result.line[at - 1] <= 121 <= result.line[at + 1]
    assert_smooth(result)
    # Where the axes rest for it, the corner is met exactly.
    resting = smoothed(toolpath(rows.start, end, kind, curve, events=(Event("stop", rest=True),)))
    at = int(np.flatnonzero(resting.kind == Kind.EVENT)[0])
    np.testing.assert_allclose(resting.end[at], rows.end[119], atol=1e-12)


def test_further_axes_follow_within_their_equivalent() -> None:
    """A starts to turn in the middle of a straight line: its corner is rounded by P at most, a degree for a mm."""
    rows = toolpath([0] * 4, [[10, 0, 0, 0], [20, 0, 0, 1], [30, 0, 0, 0.2]], axes="XYZA")
    result = smoothed(rows)
    path = path_of(result)
    x = path.evaluate(np.linspace(0, path.length, 20001))[0]
    np.testing.assert_allclose(x[:, 1:3], 0, atol=1e-12)
    programmed = np.interp(x[:, 0], [0, 10, 20, 30], [0, 0, 1, 0.2])
    # X moves by the tolerance too, and A turns 0.1 rad a mm.
    assert np.abs(x[:, 3] - programmed).max() <= 0.01 * np.radians(1.0) + 0.01 * 0.1
    assert_smooth(result)


def test_a_run_without_a_curve_is_an_error_with_its_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    """The kernel is made to fail, for no program is known that makes it."""

    def fail(*_: object, **__: object) -> None:
        raise CorridorError(1.7, 12)

    monkeypatch.setattr(stream, "fit", fail)
    with pytest.raises(NoPlanError, match=r"lines 1 to 20: .*1\.7000"):
        smoothed(facets(20))


def test_nothing_gives_nothing() -> None:
    assert list(smooth(iter([]))) == []


def test_tolerances_of_their_rows_hold() -> None:
    """P 0.1, then P 0.001: each stretch keeps its own."""
    tolerance = np.repeat([0.1, 0.001], 100)
    rows = facets(200, tolerance=tolerance)
    result = smoothed(rows)
    whole, fine = path_of(rows), path_of(result)
    s = samples(fine)
    fine_part = fine.row_of(s) >= np.searchsorted(result.line, 101)
    assert distances(fine.evaluate(s[fine_part])[0], whole).max() <= 0.001 * (1 + 1e-9)


@pytest.mark.parametrize("tolerance", [20.956782, 1.0, 0.01])
@pytest.mark.parametrize("short", [6e-7, 1e-5, 1e-3])
@pytest.mark.parametrize("where", [0, 1, 2])
def test_a_feed_of_its_own_on_next_to_nothing(tolerance: float, short: float, where: int) -> None:
    """A change of feed makes a knot, and two of them 1e-7 smoothing lengths apart took all digits: no number came out."""
    start, *ends = [[17.5088298, 0.0, 0.0], [14.7048651, 0.571741, 0.0], [13.1997164, 0.4114792, 0.0]]
    before = (start, *ends)[where]
    ends.insert(where, [before[0] - short, before[1] + short / 6.0, 0.0])
    rows = toolpath(start, ends, feed=[20.0, 30.0, 40.0], tolerance=tolerance)
    result = join(list(smooth([rows])))
    assert np.isfinite(result.nurbs.control_points).all()
    assert deviation(rows, result) <= tolerance * (1 + 1e-9)
    # Each row of some length is there with its feed, but for the time of the short one, which a neighbour has.
    for feed in np.delete(rows.feed, where):
        assert np.abs(result.feed / feed - 1.0).min() <= 1.5 * short


@pytest.mark.parametrize("feed", [0.002, 0.5])
def test_a_slow_row_too_short_for_a_span_keeps_its_time(feed: float) -> None:
    """3 µm at 0.5 mm/s (2 µm/s) amid lines at 20 mm/s: P leaves it no span of its own, and once it took no time."""
    ends = [[5.0, 0.0, 0.0], [5.003, 0.0, 0.0], [10.0, 0.5, 0.0]]
    rows = toolpath([0.0, 0.0, 0.0], ends, feed=[20.0, feed, 20.0], tolerance=0.05)
    result = join(list(smooth([rows])))
    asked, made = (np.sum(path_of(each).row_length / each.feed) for each in (rows, result))
    assert made == pytest.approx(asked, rel=1e-3)
