"""The border of two blocks lies anywhere; what is beside it counts on both sides."""

from types import MappingProxyType

import numpy as np
import pytest

from cncgen import PlanOptions, plan_with_summary
from cncgen.machine.record import Axis, Machine
from cncgen.pipeline import read_text
from cncgen.planner.least_time.block_planning import FIRST

V, A, J, PERIOD = 250.0, 2450.0, 5e4, 2e-3
TABLE = Machine("table", MappingProxyType({each: Axis(each, V, A, J) for each in "XY"}), PERIOD, 1e-3, 0.01)
#: A line counts as four control points.
ROWS = FIRST // 4


def _kinked(step: float, turns: dict[int, float]) -> str:
    """Return a G61 program of 300 lines of `step` mm, whose direction turns after some of them, rad."""
    direction = np.zeros(300)
    for row, turn in turns.items():
        direction[row:] += turn
    points = np.cumsum(step * np.stack([np.cos(direction), np.sin(direction)], axis=1), axis=0)
    lines = [f"G1 X{x:.9f} Y{y:.9f} F6000" for x, y in points.tolist()]
    return "\n".join(["G21 G90 G94 G61", *lines, "M2", ""])


@pytest.mark.parametrize(
    ("step", "one", "other"), [(0.03, 0.005, -0.005), (0.01, 0.005, 0.005), (0.03, 0.002, 0.002)]
)
def test_two_kinks_on_either_side_of_a_border_are_one_to_setpoints(
    step: float, one: float, other: float
) -> None:
    """Judged by differences. Each was passed as if alone, and the jerk of Y became 1.08 to 1.37 times its limit: a refused program."""
    chunks, _ = plan_with_summary(
        read_text(_kinked(step, {ROWS - 1: one, ROWS + 1: other})), TABLE, PlanOptions()
    )
    position = np.concatenate([chunk.position for chunk in chunks])
    for order, limit in enumerate((V, A, J), 1):
        assert np.abs(np.diff(position, order, axis=0)).max() / PERIOD**order <= limit * (1 + 1e-6)


def test_a_line_from_rest_to_rest_across_a_border_takes_what_it_takes_in_one_block() -> None:
    """Lines of 0.01 mm along X, then 10 mm along Y in eight rows, the border after four of them: 4 (d/2J)^(1/3) each, from rest to rest.

    The block before the border knew of no other rest, so its interval beside the corner was twice as long as may be: 12.7 % more time. Between intervals of constant jerk there is some left.
    """
    quick = Machine(
        "quick", MappingProxyType({each: Axis(each, 1e3, 1e4, J) for each in "XY"}), PERIOD, 1e-3, 0.01
    )
    corner = ROWS - 4
    rows = [f"G1 X{0.01 * (k + 1):.2f} F60000" for k in range(corner)]
    rows += [f"G1 Y{1.25 * (k + 1):.2f}" for k in range(8)]
    chunks, summary = plan_with_summary(
        read_text("\n".join(["G21 G90 G94 G61", *rows, "M2", ""])), quick, PlanOptions()
    )
    for _ in chunks:
        pass
    least = sum(4.0 * np.cbrt(way / (2.0 * J)) for way in (0.01 * corner, 10.0))
    assert summary.as_json()["motion_time_s"] == pytest.approx(least, rel=0.015)
