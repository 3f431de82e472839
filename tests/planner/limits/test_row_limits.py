"""What rows, joints and corners allow, in closed form; what is checked before planning."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.diagnostics import ProgramError, UsageError
from cncgen.machine import Machine, load
from cncgen.planner import PlanOptions, plan
from cncgen.planner.checks import checked
from cncgen.planner.ild.sharp_corners import CornerRule
from cncgen.planner.ild.stretch import joint_speeds, turned
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.limits.row_limits import row_limits_of
from cncgen.planner.limits.speeds import chord_speed, curvature_speed
from cncgen.planner.record import Limit
from cncgen.planner.strategies import FEEDRATES, strategy
from cncgen.toolpath.record import FeedMode, PathMode, Toolpath


def test_line_divides_its_limits(lines: Callable[..., Toolpath], mill: Machine) -> None:
    """Along (3, 0, 4)/5 X takes 0.6 and Z 0.8: each limit is the least of axis limit by share."""
    toolpath = lines([(0, 0, 0), (3, 0, 4)], feed=np.nan, feed_mode=FeedMode.RAPID)
    rows = row_limits_of(toolpath, toolpath.path, mill)
    x, z = mill.axes["X"], mill.axes["Z"]
    assert rows.top[0] == pytest.approx(min(x.max_velocity / 0.6, z.max_velocity / 0.8))
    assert rows.acceleration[0] == pytest.approx(min(x.max_acceleration / 0.6, z.max_acceleration / 0.8))
    assert rows.jerk[0] == pytest.approx(min(x.max_jerk / 0.6, z.max_jerk / 0.8))
    assert rows.top_limit[0] == Limit.VELOCITY
    np.testing.assert_allclose(rows.tangent_in[0], [0.6, 0.0, 0.8])


def test_arc_is_limited_by_curvature(arc: Callable[..., Toolpath], table: Machine) -> None:
    """Radius 4: √(A r), ∛(J r²), the chord's 2/T √(2δr − δ²); which one binds is named."""
    toolpath = arc(4.0, 2.0, 1e4)
    rows = row_limits_of(toolpath, toolpath.path, table)
    assert rows.top[0] == pytest.approx(min((2450 * 4) ** 0.5, (5e4 * 16) ** (1 / 3)))
    assert rows.top_limit[0] == Limit.JERK
    free = row_limits_of(toolpath, toolpath.path, table, bends=False)
    assert free.top[0] == 250.0
    capped = row_limits_of(toolpath, toolpath.path, replace(table, max_centripetal_mm_s2=100.0))
    assert (capped.top[0], capped.top_limit[0]) == (pytest.approx(20.0), Limit.CENTRIPETAL)


@given(st.floats(1e-4, 1e4), st.floats(1e-5, 0.1))
def test_chord_speed_keeps_the_chord(radius: float, tolerance: float) -> None:
    """Eq. 24: the sagitta of the chord travelled in a period is the tolerance; on a smaller circle the way leads no further."""
    chord = float(chord_speed(np.array([1.0 / radius]), tolerance, 1e-3)[0]) * 1e-3
    if radius >= tolerance:
        sagitta = radius - (max(radius**2 - chord**2 / 4.0, 0.0)) ** 0.5
        assert sagitta == pytest.approx(tolerance, rel=1e-4, abs=1e-9 * radius)
    else:
        assert chord == pytest.approx(2.0 * (tolerance * radius) ** 0.5)
        assert chord / 2.0 < tolerance


def test_curvature_speed_halves_at_kbar() -> None:
    """Eq. 25: V at κ = 0, V/2 at κ = κ̄."""
    assert curvature_speed(np.array([0.0, 2.0]), 100.0, 2.0).tolist() == [100.0, 50.0]


def test_joint_speeds_are_differences_of_setpoints() -> None:
    """At the speed allowed, setpoints through the joint have second and third differences at their limits, no higher."""
    machine = load("xy-table")
    limits = AxisLimits.of(machine, "XYZ")
    one, other = np.array([[1.0, 0.0, 0.0]]), np.array([[0.8, 0.6, 0.0]])
    none = np.zeros((1, 3))
    (v,) = joint_speeds(other - one, none, limits)
    k = np.arange(-5, 6)[:, None]
    x = np.where(k < 0, k * v * one, k * v * other) * 1e-3
    third = np.abs(np.diff(x, 3, axis=0)).max() / 1e-9
    second = np.abs(np.diff(x, 2, axis=0)).max() / 1e-6
    assert second <= 2450.0
    assert 0.5 * 5e4 < third <= 5e4 * (1 + 1e-9)
    assert not turned(np.full((1, 3), 1e-7))[0]
    assert joint_speeds(none, none, limits)[0] == np.inf
    (bend,) = joint_speeds(none, np.array([[0.0, 0.2, 0.0]]), limits)
    assert bend**2 * 0.2 == pytest.approx(5e4 * 1e-3)


def test_corners_keep_their_distance() -> None:
    """κ > A/V² and at least d_min from the last corner and from the start: a hand-made row of maxima."""
    rule = CornerRule(1e-3, 1e-3, 1.0, 1.0)
    s = np.array([0.3, 2.0, 2.5, 3.1, 9.0])
    kappa = np.array([5.0, 5.0, 9.0, 5.0, 0.1])
    assert rule.corners(s, kappa, 0.0, 2450.0, 100.0).tolist() == [1, 3]
    none = replace(rule, distance_mm=0.0)
    assert none.corners(s, kappa, 0.0, 2450.0, 100.0).tolist() == [0, 1, 2, 3]
    speed, limit = rule.speeds(kappa, 100.0)
    assert speed[0] == pytest.approx(min(2e3 * (2e-3 / 5 - 1e-6) ** 0.5, 100.0 / 6.0))
    assert limit[0] == Limit.CURVATURE


def test_missing_axes_and_travel_are_named(lines: Callable[..., Toolpath], table: Machine) -> None:
    """Every fault of a chunk in one error: an axis that the machine lacks, and ends beyond the travel."""
    toolpath = lines([(0, 0, 0), (501, 0, 0), (501, -600, 1)])
    with pytest.raises(ProgramError) as caught:
        list(plan([toolpath], table, PlanOptions()))
    found = [(d.code, d.span.line) for d in caught.value.diagnostics if d.span]
    assert found == [
        ("axis-missing", 2),
        ("travel-exceeded", 1),
        ("travel-exceeded", 2),
    ]


def test_tolerance_comes_from_option_program_machine(lines: Callable[..., Toolpath], table: Machine) -> None:
    """`--path-tolerance`, else the program's G64 P, else the machine's; rows of other modes have none."""
    g64 = lines([(0, 0), (1, 0), (2, 0)], mode=PathMode.CONTINUOUS)
    said = replace(g64, tolerance=np.array([np.nan, 0.02]))
    (machines,) = checked([said], table, PlanOptions())
    assert machines.tolerance.tolist() == [table.path_tolerance_mm, 0.02]
    (asked,) = checked([said], table, PlanOptions(path_tolerance_mm=0.5))
    assert asked.tolerance.tolist() == [0.5, 0.5]
    (exact,) = checked([lines([(0, 0), (1, 0)])], table, PlanOptions(path_tolerance_mm=0.5))
    assert np.isnan(exact.tolerance).all()


def test_options_name_every_fault() -> None:
    """Wrong words and numbers are all in one error, with what is allowed."""
    wrong = PlanOptions(interpolator="spline", profile="square", kbar_per_mm=0.0, corner_distance_mm=-1.0)
    with pytest.raises(UsageError) as caught:
        wrong.check()
    assert len(caught.value.diagnostics) == 4
    assert "arclength, taylor1, taylor2, uniform" in caught.value.diagnostics[0].message


def test_registry_names_what_is_there() -> None:
    """The baselines and ild are always there; an unknown name is refused with the names."""
    assert {"ild", "constant", "adaptive", "curvature"} <= set(FEEDRATES)
    assert strategy("constant").__name__ == "plan_constant"
    assert strategy(None) is strategy(FEEDRATES[0])
    with pytest.raises(UsageError, match="quickest"):
        strategy("quickest")
