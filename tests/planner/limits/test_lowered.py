"""What nothing around lowers keeps all its digits, however long the way to it is."""

import numpy as np
import pytest

from cncgen.machine import load
from cncgen.pipeline import read_text
from cncgen.planner.least_time.corners import BlockJumps, reached_speeds
from cncgen.planner.limits.axis_limits import AxisLimits, lowered
from cncgen.toolpath.record import Kind


@pytest.mark.parametrize("seed", range(5))
def test_lowered_is_the_least_of_all_cones(seed: int) -> None:
    """At each place the least of all values there, each grown by the way to it (a double loop)."""
    rng = np.random.default_rng(seed)
    way = np.cumsum(rng.exponential(1.0, 60))
    values = rng.exponential(20.0, 60)
    expected = (values + np.abs(way[:, None] - way)).min(axis=1)
    assert lowered(values, way) == pytest.approx(expected, rel=1e-13)


def test_a_slow_joint_far_along_keeps_its_speed_to_the_last_digit() -> None:
    """Of 10⁻² mm/s behind curves of 10³ mm/s (once 3·10⁻⁶ of it was rounding, which units chose)."""
    speed = np.where(np.arange(30) % 7 == 5, 0.010162709087104894, 1077.35002)
    free = np.full(29, np.inf)
    assert (reached_speeds(speed, (free, free)) == speed).all()


def test_along_a_curve_the_speed_rises_by_what_all_axes_do_together() -> None:
    """v² by 2 √(A_x² + A_y² + A_z²) d on an arc, by 2 A d on a line in X; nothing is known where B turns alone."""
    machine = load("generic-mill")
    text = "G21 G90 G94 G17 F6000\nG1 X10\nG3 X10 Y10 I0 J5\nG1 B30\nM2\n"
    (rows,) = read_text(text).chunks()
    bounds, path = AxisLimits.of(machine, rows.axes), rows.path
    direction = path.evaluate(path.row_s, 1, 1)[1]
    square, power = BlockJumps(bounds, path.row_s, direction, direction).rises(
        path.kind == Kind.LINE, path.moves_xyz
    )
    a = [machine.axes[letter].max_acceleration for letter in "XYZ"]
    assert square[:2] == pytest.approx(
        [2.0 * a[0] * 10.0, 2.0 * np.hypot(np.hypot(*a[:2]), a[2]) * 5.0 * np.pi]
    )
    assert power[0] == pytest.approx(np.sqrt(4.5 * machine.axes["X"].max_jerk) * 10.0)
    assert power[1] == np.inf
