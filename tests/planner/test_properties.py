"""Properties of plans on a small fixed set of random programs; trials/planner_properties.py tries thousands."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from cncgen.machine import load
from cncgen.pipeline import read, read_text, sound
from cncgen.planner import PlanOptions, plan
from cncgen.planner.least_time import rolling_window
from cncgen.planner.motion import motion_at
from cncgen.planner.record import Limit
from cncgen.setpoints import sample
from trials import planner_properties as properties
from trials.generators import paths

ROOT = Path(__file__).resolve().parents[2]

ALIKE = ((100.0, 1000.0, 1e4),) * 4


@pytest.mark.parametrize(
    "name", ["limits", "continuous", "splitting", "reversing", "pace", "bounds", "tolerances"]
)
def test_random_programs(name: str) -> None:
    """Each property on a few random paths."""
    check, drawn = properties.PROPERTIES[name]

    @settings(max_examples=4)
    @given(drawn)
    def tried(case: paths.Case) -> None:
        check(case)

    tried()


@pytest.mark.parametrize("feed", [10.0, 100.0, 1000.0, 6000.0])
def test_lines_there_and_back_split(feed: float) -> None:
    """Rest-to-rest lines at any feed, cut in three (once up to 11 % apart where the feed is slow)."""
    moves = (paths.Line((1.0, 0.0, 0.0, 0.0)), paths.Line((-1.0, 0.0, 0.0, 0.0)))
    properties.splitting(paths.Case(moves, feed, False, "G61", ALIKE))


def test_arcs_by_inverse_time_in_another_unit() -> None:
    """Rows whose speeds differ by rounding alone count as one (once 1e-5 apart, with seven times the nodes)."""
    moves = (paths.Arc(1.0, 0.0, -1.0, 0.0), paths.Arc(1.0, 0.0, -1.0, 0.0))
    properties.units(paths.Case(moves, 10.0, True, "G61", ALIKE))


def test_full_circles_reversed_and_bounded() -> None:
    """Twice round, at a feed that the circle cannot be driven with."""
    moves = (paths.Arc(1.0, 0.0, -2.0 * math.pi, 0.0),) * 2
    case = paths.Case(moves, 10_000.0, False, "G61", ALIKE)
    properties.reversing(case)
    properties.bounds(case)
    properties.limits(case)


@pytest.mark.parametrize(
    ("program", "machine"), [("butterfly.nc", "xy-table"), ("butterfly_g1.nc", "generic-mill")]
)
def test_the_limit_that_is_named_is_reached(program: str, machine: str) -> None:
    """MotionPieces said to be held by jerk, acceleration or feed come within a twentieth of it, all but one in ten."""
    where = replace(load(machine), max_contour_error_mm=None)
    ratio: dict[Limit, list[np.ndarray]] = {Limit.JERK: [], Limit.ACCELERATION: [], Limit.FEED: []}
    for trajectory in plan(read(ROOT / "programs" / program).chunks(), where):
        profile = trajectory.profile
        for name, order in ((Limit.FEED, 0), (Limit.ACCELERATION, 1), (Limit.JERK, 2)):
            at = np.flatnonzero(profile.limit == name)
            share = np.linspace(0.0, 1.0, 9)
            t = (profile.t[at, None] + share * np.diff(profile.t)[at, None]).ravel()
            motion = motion_at(profile, t)
            if order == 0:
                rows = trajectory.toolpath.feed[trajectory.toolpath.path.row_of(motion.s)]
                found = motion.v / rows
            else:
                if trajectory.cubics is not None:
                    acceleration, jerk = trajectory.cubics.at(t, 3)[2:, :, :2]
                else:
                    x = trajectory.toolpath.path.evaluate(motion.s, 3)[:, :, :2]
                    v, a, j = motion.v[:, None], motion.a[:, None], motion.j[:, None]
                    acceleration, jerk = x[2] * v**2 + x[1] * a, x[3] * v**3 + 3.0 * x[2] * v * a + x[1] * j
                axis = where.axes["X"]
                of = (acceleration / axis.max_acceleration, jerk / axis.max_jerk)[order - 1]
                found = np.abs(of).max(axis=1)
            ratio[name].append(found.reshape(len(at), len(share)).max(axis=1))
    for name, parts in ratio.items():
        reached = np.concatenate(parts)
        assert not len(reached) or np.mean(reached > 0.95) > 0.9, name
    assert sum(map(len, ratio[Limit.JERK])) > 100


_SLOW_AND_FAST = """G21 G17 G90 G93 G61
G1 X0 Y0 Z0 A1.12202 F11.310600000000001
G2 X-1.327215874513501 Y0.348321735771135 Z1 I-0.551781759820867 J0.600253938277782 F11.310600000000001
G2 X-2.654431749027002 Y0.69664347154227 Z2 I-0.551781759820867 J0.600253938277782 F11.310600000000001
G1 X-2.654431749027002 Y0.69664347154227 Z2 A1.12448028 F11.310600000000001
G1 X-1.096271749027002 Y0.69664347154227 Z2.467448 A1.12448028 F11.310600000000001
G1 X-2.654431749027002 Y0.69664347154227 Z2 A1.12448028 F11.310600000000001
G3 X-7.331023510048968 Y-11.98176257588654 Z3 I-19.524100000000001 J-0 F11.310600000000001
G4 P0.050000
G3 X39.991762921732786 Y-0.294051191707172 Z3 I25.104700000000001 J-0.000000000000003 F11.310600000000001
G1 X39.991763021732787 Y-0.294051191707172 Z3.00000003 A1.12448028 F11.310600000000001
M2
"""


def test_slow_rows_beside_fast_ones_find_a_plan() -> None:
    """Inverse time asks for 1e-6 mm/s beside rows a million times as fast (once no plan was found)."""
    strong, weak = (85.1256, 328.881, 7191.06), (8.51256, 32.8881, 719.106)
    machine = paths.Case((), 1.0, True, "G61", (strong, strong, weak, strong)).machine
    chunks = [chunk for chunk in sound(read_text(_SLOW_AND_FAST, "slow.nc")) if len(chunk)]
    time = max(float(each.profile.t[-1]) for each in plan(chunks, machine))
    # Nine moves of 1/11.3 min each and the dwell, and what starts and stops add.
    assert 9 * 60.0 / 11.3106 + 0.05 <= time < 1.02 * (9 * 60.0 / 11.3106 + 0.05)


def test_an_axis_that_starts_in_a_tiny_move_after_a_curve() -> None:
    """One degree within 1e-7 mm is not moved to the end of the curve before it (once A passed its limit by 62 %)."""
    curve = paths.Curve(((13.0, -2.0, 1.6), (1.0, 5.0, -3.0), (1.0, 5.0, -3.0)), (1.0, 2.0, 1.0, 1.0), ())
    moves = (
        paths.Line((0.0, 0.0, 0.0, 1.0)),
        curve,
        paths.Line((8.7152109e-08, -4.9035803e-08, 3e-8, -1.0)),
        curve,
    )
    weak, strong = (10.4024, 45.3243, 3012.24), (104.024, 453.243, 30122.4)
    properties.limits(paths.Case(moves, 50_424.4, False, "G64 P0.001", (strong, weak, weak, strong)))


def test_axes_that_rest_do_not_count() -> None:
    """A rotary axis of the machine that never moves changes nothing of a plan in another unit (once 3e-8)."""
    circle = (paths.Line((1e-7, 0.0, 0.0, 0.0)), paths.Arc(1.0, 0.0, -2.0 * math.pi, 0.0))
    weak = (0.3, 1.0, 10.0)
    for inverse, feed in ((False, 600.0), (True, 60.0)):
        properties.units(paths.Case(circle, feed, inverse, "G61", (*ALIKE[:3], weak)))


def test_a_curve_that_ends_in_four_equal_points() -> None:
    """The derivative by the parameter is 0 at the end of the path (once an IndexError)."""
    curve = paths.Curve(((0.0, 0.0, 0.2),) * 4, (1.0,) * 5, (0.1,))
    case = paths.Case((paths.Line((1.0, 0.0, 0.0, 0.0)), curve, curve), 100.0, False, "G61", ALIKE)
    properties.limits(case)
    properties.reversing(case)


def test_helices_reversed() -> None:
    """Full turns with a rise, from their other end."""
    turn = paths.Arc(1.0, 0.0, -2.0 * math.pi, 1.0)
    properties.reversing(paths.Case((turn, turn), 100.0, False, "G61", ALIKE))


def test_full_circles_beside_a_rotary_axis_have_their_feed_in_mm() -> None:
    """A circle that ends where it starts, in a program with A: 538 mm/min (once taken for degrees, a 57th)."""
    chunks = list(sound(read_text("G21 G94\nG2 X0 Y0 I-1 F538\nG1 A90\nM2\n", "circle.nc")))
    feeds = np.concatenate([chunk.feed for chunk in chunks])
    np.testing.assert_allclose(feeds[:2], [538.0 / 60.0, math.radians(538.0) / 60.0])


def test_jerk_between_nodes_of_a_curve_whose_third_derivative_bends() -> None:
    """x''' of the NURBS falls by a third over an interval, no parabola (once 1.0039 of the limit of Z)."""
    curve = paths.Curve(((13.0, -10.0, -2.8), (-6.0, 10.0, -1.8), (-9.0, 10.0, 2.6)), (1.0,) * 4, ())
    strong, weak = (100.002, 794.328, 6969.63), (30.0006, 238.298, 2090.89)
    limits = (strong, weak, (3.00006, 23.8298, 209.089), strong)
    moves = (paths.Line((0.0, 0.0, 0.0, 1.0)), curve)
    properties.limits(paths.Case(moves, 794.328, False, "G61", limits))


def test_chords_of_a_long_period_stay_at_shallow_corners() -> None:
    """At 10 ms a corner of 0.02 rad that is passed, and a polyline of 10 µm steps: the chord tolerance of 1 µm (once 5 and 11)."""
    machine = replace(paths.Case((), 6000.0, False, "G61", ALIKE).machine, period_s=0.01)
    turn = 0.02 * np.arange(5)
    zigzag = 20.0 * np.cumsum(np.column_stack([np.cos(turn), np.sin(turn)]), axis=0)
    angle = 1e-3 * np.arange(1, 301)
    arc = 10.0 * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)])
    for corners in (zigzag, arc):
        blocks = "".join(f"G1 X{x:.9f} Y{y:.9f}\n" for x, y in corners)
        chunks = [c for c in sound(read_text(f"G61 F6000\n{blocks}M2\n", "chords.nc")) if len(c)]
        trajectories = plan(chunks, machine, PlanOptions(feedrate="optimal"))
        x = np.concatenate([chunk.position for chunk in sample(trajectories, machine, axes="XY")])
        along = np.diff(x, axis=0)
        away = corners[:-1, None] - x[:-1]
        share = np.einsum("cij,ij->ci", away, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-30)
        cut = np.linalg.norm(away - share.clip(0.0, 1.0)[..., None] * along, axis=2).min(axis=1)
        assert cut.max() <= 1.1e-3


@pytest.mark.parametrize("scale", [25.4, 1.0 / 25.4])
def test_other_units_leave_the_time_of_curves(scale: float) -> None:
    """A NURBS that stands at a double knot, a helix, lines a micrometre long (once 1e-5 apart, by cells of 1e-11 mm)."""
    points = ((9.0, 15.0, -0.4),) * 3 + ((-2.0, 10.0, -0.8), (-15.0, -4.0, 0.8), (14.0, 12.0, -2.2))
    curve = paths.Curve(points, (1.0, 0.5, 2.0, 1.0, 1.0, 2.0, 1.0), (0.1, 0.1, 0.5))
    moves = (curve, paths.Arc(1.0, 0.2, 6.0, 1.0), paths.Line((1e-6, 0.0, 0.0, 0.0)))
    case = paths.Case(moves, 1000.0, False, "G61", ALIKE)
    time = properties.planned(case).time
    assert properties.planned(replace(case, scale=scale)).time == pytest.approx(time, rel=1e-9)


def test_ramps_that_no_setpoint_shows_need_no_nodes() -> None:
    """Full acceleration after a quarter of a period (once ten nodes a period, and twice the time)."""
    curve = paths.Curve(((15.0, -10.0, 2.4), (-11.0, -13.0, -1.4), (15.0, 6.0, 2.0)), (1.0,) * 4, ())
    slow, fast = (13.9072, 6.94455, 30_000.0), (139.072, 69.4455, 300_000.0)
    case = paths.Case((curve,), 5038.5, False, "G61", (slow, slow, fast, fast))
    properties.limits(case)
    plan = properties.planned(case)
    pieces = sum(len(each.profile.t) for each in plan.trajectories)
    assert pieces < 4.0 * plan.time / paths.PERIOD


def test_ramps_of_four_fifths_of_a_period_need_few_nodes() -> None:
    """Setpoints hardly show what such a ramp is made of (once five nodes a period)."""
    curve = paths.Curve(((10.0, 14.0, -3.0), (-3.0, -6.0, 2.0), (-7.0, 11.0, 1.0)), (1.0,) * 4, ())
    case = paths.Case((curve,), 64349.0, False, "G61", ((3.0, 6.0, 7437.0),) * 4)
    properties.limits(case)
    plan = properties.planned(case)
    assert sum(len(each.profile.t) for each in plan.trajectories) < 3.0 * plan.time / paths.PERIOD


def test_a_line_that_ends_in_a_tiny_one_split() -> None:
    """Nodes grow back from a rest 1e-7 mm off (once 15 nodes a period, and 0.16 % apart)."""
    moves = tuple(paths.Line((x, 0.0, 0.3 * x, 0.0)) for x in (24.9033, 1e-7, -1e-7))
    weak, strong = (48.7386, 60.0, 102988.0), (162.462, 200.0, 343295.0)
    case = paths.Case(moves, 138746.0, False, "G61", (weak, weak, strong, weak))
    properties.splitting(case)
    plan = properties.planned(case)
    assert sum(len(each.profile.t) for each in plan.trajectories) < 3.0 * plan.time / paths.PERIOD


@pytest.mark.parametrize("number", [0, 1])
def test_one_turn_from_rest_to_rest_split(number: int) -> None:
    """All of it is a rise and a fall by jerk, by which nodes stand close (once 0.35 and 0.25 % apart)."""
    helix = paths.Arc(1.0, 0.5 * math.pi, 2.0 * math.pi, -3.0)
    circle = paths.Arc(0.11818, -1.19158, 2.0 * math.pi, 0.0)
    slow = ((29.1172, 3000.0, 1500.0), *((97.0572, 10_000.0, 5000.0),) * 3)
    fast = ((264.084, 1000.0, 97638.8), *((79.2252, 300.0, 29291.6),) * 3)
    turn, feed, limits = ((helix, 757.138, slow), (circle, 113_377.0, fast))[number]
    properties.splitting(paths.Case((turn,), feed, False, "G61", limits))


@pytest.mark.parametrize("number", [0, 1])
def test_a_rest_at_a_cusp_takes_nothing_of_the_jerk(number: int) -> None:
    """There x''' is rounding, and was held back beside it (once 0.2 % apart in other units)."""
    back = paths.Curve(((1.0, 0.0, 0.4),) * 2 + ((0.0, 0.0, 0.0),), (1.0,) * 4, ())
    away = paths.Curve(((0.0, 0.0, 0.0),) + ((0.0, 5.0, 1.6),) * 2, (1.0, 1.0, 2.0, 1.0), ())
    strong, weak = (20.0, 200.0, 5000.0), (6.0, 60.0, 1500.0)
    case = paths.Case(((back, away)[number],), 100.0, False, "G61", (strong, strong, weak, strong))
    time = properties.planned(case).time
    for scale in (25.4, 0.1, 3.0):
        assert properties.planned(replace(case, scale=scale)).time == pytest.approx(time, rel=1e-9)


def test_an_axis_that_turns_at_a_node_in_other_units() -> None:
    """At a breakpoint x' of Z is 0 to the last digit or not, and a profile begins its rise there (once 3e-9 apart)."""
    points = ((0.0, 8.0, 1.8), (-2.0, -7.0, -3.0), (7.0, -3.0, -0.6), (-1.0, 3.0, -3.0))
    curve = paths.Curve(points, (2.0, 2.0, 1.0, 0.5, 0.5), (0.8,))
    strong, weak = (966.259, 316.228, 5000.0), (28.9878, 9.48684, 150.0)
    case = paths.Case((curve,), 605.538, False, "G61", (strong, strong, weak, strong))
    properties.units(case)


def test_short_steps_leave_no_rounding_in_the_time() -> None:
    """Arcs of a weak axis, the larger one in 25 short steps of the interior point.

    What acceleration may be more between nodes goes to and fro with the motion there, by 5e-7 of the time.
    """
    arcs = (paths.Arc(0.0775427, 0.0, 0.998, 0.0), paths.Arc(1.0, 0.0, -2.0 * math.pi, 0.0))
    strong, weak = (169.914, 200.0, 1e6), (5.09742, 6.0, 3e4)
    case = paths.Case(arcs, 169.914, False, "G61", (strong, weak, strong, weak))
    time = properties.planned(case).time
    for scale in (25.4, 2.7, 1.0 / 7.3):
        assert properties.planned(replace(case, scale=scale)).time == pytest.approx(time, rel=1e-6)


def test_spacings_beside_a_rest_in_other_units() -> None:
    """Looked at in quarters of a panel they are as 2 to 3: rounding once chose whether they grow between (once 5e-7 apart)."""
    turn = paths.Arc(0.277022, 0.10226351881399598, 2.0 * math.pi, -3.0)
    end = paths.Line((9.659910850657212e-08, 2.5857537309950945e-08, 3e-08, 0.0))
    limits = ((80.7993, 76.4778, 52962.0), (269.331, 254.926, 176540.0), *((8.07993, 7.64778, 5296.2),) * 2)
    case = paths.Case((turn, end), 100.0, False, "G61.1", limits)
    time = properties.planned(case).time
    for scale in (25.4, 2.7, 0.91):
        assert properties.planned(replace(case, scale=scale)).time == pytest.approx(time, rel=1e-9)


def test_a_straight_curve_that_stands_at_its_end_is_passed_at_feed() -> None:
    """Three equal points where two lines join: panels and x''' there are the parameter's (once 1.8 % longer, one way)."""
    points = ((1.0, 0.0, 1.0),) * 3
    curve = paths.Curve(points, (1.0, 0.5, 1.0, 0.5), ())
    strong, weak = (20.0, 200.0, 5000.0), (0.6, 6.0, 150.0)
    case = paths.Case((curve, curve), 100.0, False, "G61", (strong, weak, strong, strong))
    properties.reversing(case)
    # 2 √2 mm at feed, and √(v/J) along the diagonal at both ends.
    v, jerk = 100.0 / 60.0, 5000.0 * math.sqrt(2.0)
    assert properties.planned(case).time == pytest.approx(
        2.0 * math.sqrt(2.0) / v + 2.0 * math.sqrt(v / jerk), rel=2e-3
    )


def test_a_corner_beside_a_rest_takes_no_longer_than_a_stop() -> None:
    """A move of 1e-7 mm after a curve: to pass its corner gains 1.4 ms of 3.5 s, and nodes beside it cost hardly more elsewhere.

    Once it took 0.6 % longer than a stop.
    """
    points = ((13.0, 3.0, 1.0),) * 2 + ((14.0, -1.0, -1.0),) * 3 + ((-11.0, 3.0, -2.0),)
    curve = paths.Curve(points, (0.5, 2.0, 1.0, 1.0, 1.0, 1.0, 1.0), (0.3, 0.6, 0.9))
    strong, weak = (444.654, 20000.0, 33052.2), (13.3396, 600.0, 991.566)
    moves = (curve, paths.Line((-1e-7, 0.0, 3e-8, 0.0)))
    case = paths.Case(moves, 13300.5, False, "G61", (weak, strong, strong, weak))
    stops = properties.planned(replace(case, mode="G61.1")).time
    assert properties.planned(case).time <= stops * 1.001


def test_lines_of_a_narrow_tolerance_take_their_phases() -> None:
    """Under G64 P0.001 chords have a cap, which no line needs: inverse time crawls 1e-7 mm in 6 s (once 1.1 s more)."""
    turn = paths.Line((1e-7, 0.0, 3e-8, 49.34))
    moves = (turn, paths.Line((-1e-7, 0.0, -3e-8, -49.34)), turn)
    strong, weak = (79.4328, 246.718, 16624.8), (2.38298, 7.40154, 498.744)
    case = paths.Case(moves, 9.99977, True, "G64 P0.001", (strong, weak, weak, strong))
    exact = properties.planned(replace(case, mode="G61")).time
    assert properties.planned(case).time == pytest.approx(exact, rel=1e-9)


def test_a_line_of_three_equal_points_at_its_end() -> None:
    """Its derivatives are rounding there, and bounded the first interval of the way back (once 67 % longer)."""
    curve = paths.Curve(((11.0, 0.0, -0.8),) * 3, (1.0, 1.0, 1.0, 2.0), ())
    back = paths.Line((-1.00231, 0.0, 0.0, 0.0))
    limits = (
        (0.71952, 568.0, 3190.0),
        (24.0, 18900.0, 106_000.0),
        (7.2, 5680.0, 31_900.0),
        (24.0, 18900.0, 106_000.0),
    )
    properties.reversing(paths.Case((curve, back), 3036.21, False, "G61.1", limits))


def test_tiny_curves_that_are_lines_take_no_days() -> None:
    """Two ways of 0.2 mm in Z with three equal points (once 17 days: the end was infinitely sharp)."""
    curve = paths.Curve(((0.0, 0.0, 0.2),) * 3, (1.0, 2.0, 1.0, 0.5), ())
    case = paths.Case((curve, curve), 100.0, False, "G61.1", ((20.0, 200.0, 5000.0),) * 4)
    # At v = 100 mm/min 0.24 s, and twice 2 √(v/J) for starts and stops that do not reach the acceleration limit.
    least = 0.24 + 4.0 * math.sqrt(100.0 / 60.0 / 5000.0)
    assert least * 0.999 < properties.planned(case).time < least * 1.01


def test_crawling_rows_beside_fast_ones_reversed() -> None:
    """A rotary axis turns 13 degrees within 1e-7 mm, after 130 mm at feed (once a stop amid them, 5 %)."""
    strong, weak = (20.0, 429.956, 5000.0), (0.6, 12.8987, 150.0)
    moves = (
        paths.Line((0.0, 1.0, 0.0, -0.027623)),
        paths.Arc(20.0, 0.998, -2.0 * math.pi, -3.0),
        paths.Line((-1.0, 0.0, 0.3, 0.0)),
        paths.Line((-1e-07, 0.0, 0.0, 1.0)),
        paths.Line((0.0, 1e-07, 0.0, 12.7153)),
        paths.Arc(1.0, 0.0, -2.0 * math.pi, 0.0),
    )
    properties.reversing(paths.Case(moves, 100.0, False, "G61", (strong, strong, strong, weak)))


def test_a_row_of_next_to_no_length_in_three_parts() -> None:
    """Of 2e-8 mm, 32 mm from the start of a block, the path coordinate tells seven digits (once corners of A, 0.6 %)."""
    slow, fast = (16.0, 8.6, 30_000.0), (530.0, 287.0, 1e6)
    moves = (paths.Line((32.0, 0.0, 0.0, 0.0)), paths.Line((0.0, 1e-7, 0.0, 71.0)))
    properties.splitting(paths.Case(moves, 34_000.0, False, "G61", (slow, fast, slow, slow)))


def test_windows_take_the_time_of_one_beside_a_weak_axis(monkeypatch: pytest.MonkeyPatch) -> None:
    """X brakes for long where the path turns and the speed rises (windows once took 7 % more than one wide window)."""
    points = ((9.0, 4.0, -1.8), (-9.0, 12.0, -2.0), (2.0, 1.0, -0.6), (0.0, 4.0, 1.4), (10.0, 6.0, 1.6))
    curve = paths.Curve(
        (*points, (15.0, -15.0, -1.8), (15.0, -15.0, -1.8)),
        (1.0, 0.5, 1.0, 1.0, 1.0, 1.0, 0.5, 0.5),
        (0.3, 0.7, 0.9, 0.9),
    )
    weak, strong = (27.0, 6.0, 2158.0), (900.0, 200.0, 72_000.0)
    case = paths.Case((curve,), 11489.0, False, "G61", (weak, strong, strong, strong))
    windows = properties.planned(case).time
    monkeypatch.setattr(
        rolling_window.RollingWindow.__init__,
        "__defaults__",
        tuple(
            20_000 if value == rolling_window.SIZE else value
            for value in rolling_window.RollingWindow.__init__.__defaults__
        ),
    )
    assert windows == pytest.approx(properties.planned(case).time, rel=1e-3)


def test_next_to_nothing_before_a_rest_reversed() -> None:
    """A row of 0.1 nm before a dwell cannot be told from its end: once all after it kept the plan of the speed alone, 3.3 % longer."""
    one = paths.Curve(
        ((14.0, 15.0, 1.0), (11.0, 8.0, 3.0), (-2.0, 1.0, 2.0), (-1.0, 15.0, 2.8), (-1.0, 15.0, 2.8)),
        (2.0, 0.5, 0.5, 2.0, 0.5, 0.5),
        (0.8, 0.8),
    )
    other = paths.Curve(((-10.0, 9.0, -1.2), (-3.0, -12.0, -0.4), (2.0, -2.0, 0.4)), (0.5, 0.5, 1.0, 1.0), ())
    tiny = paths.Line((1e-7, 0.0, 0.0, 0.0))
    arc = paths.Arc(11.0377, -6.1e-5, -1.94, 0.0)
    last = paths.Line((0.0479344, 0.0, 0.0, -1.0))
    strong = (859.753, 1258.93, 12225.0)
    limits = ((257.926, 377.679, 3667.5), (25.7926, 37.7679, 366.75), strong, strong)
    moves = (one, other, tiny, arc, paths.Dwell(0.05), tiny, last)
    properties.reversing(paths.Case(moves, 996.014, False, "G64 P0.001", limits))
