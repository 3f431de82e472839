"""The chord limit where rotary axes move with X Y Z: what bends their common path, not what makes them faster along it."""

from __future__ import annotations

import numpy as np

from cncgen import pipeline
from cncgen.machine.record import Axis, Machine
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.limits.speeds import chord_speed
from cncgen.planner.record import Limit
from cncgen.units import DEGREE

CHORD, PERIOD = 0.001, 0.001


def machine() -> Machine:
    axes = {letter: Axis(letter, 200.0, 2000.0, 1e5) for letter in "XYZ"}
    axes["A"] = Axis("A", 200.0 * DEGREE, 2000.0 * DEGREE, 1e5 * DEGREE)
    return Machine("here", axes, period_s=PERIOD, chord_tolerance_mm=CHORD)


def test_the_bend_is_that_of_the_common_path() -> None:
    """|x' ∧ x''| / |x'|, by the minors of both, with a degree for a millimetre."""
    draw = np.random.default_rng(3)
    x1, x2 = draw.normal(size=(2, 50, 4))
    x1[:, 3], x2[:, 3] = 0.01 * x1[:, 3], 100.0 * x2[:, 3]
    scale = np.array([1.0, 1.0, 1.0, 1.0 / DEGREE])
    a, b = x1 * scale, x2 * scale
    i, j = np.triu_indices(4, 1)
    bend = np.linalg.norm(a[:, i] * b[:, j] - a[:, j] * b[:, i], axis=1) / np.linalg.norm(a, axis=1)
    free = np.full(50, np.inf)
    q, _ = AxisLimits.of(machine(), "XYZA").top(free, np.full(50, Limit.FEED, np.int8), x1, x2)
    # Sharper than the tolerance half of a period's way is what counts.
    way = np.where(bend > 1.0 / CHORD, 2.0 * CHORD / PERIOD / np.linalg.norm(a, axis=1), 0.0)
    expected = np.maximum(chord_speed(bend, CHORD, PERIOD), way)
    velocity = np.min(np.array([200.0, 200.0, 200.0, 200.0 * DEGREE]) / np.abs(x1), axis=1)
    np.testing.assert_allclose(np.sqrt(q), np.minimum(expected, velocity), rtol=1e-9)
    assert (expected < velocity).any()


def test_a_bend_sharper_than_the_tolerance_is_passed_at_two_tolerances_a_period() -> None:
    """No point of a period's way is further than half of it from its nearer end, however sharp the bend is."""
    x1 = np.tile([1.0, 0.0, 0.0], (3, 1))
    x2 = np.array([[0.0, 1e4, 0.0], [0.0, 1e9, 0.0], [0.0, 1e15, 0.0]])
    q, _ = AxisLimits.of(machine(), "XYZ").top(np.full(3, np.inf), np.full(3, Limit.FEED, np.int8), x1, x2)
    np.testing.assert_allclose(np.sqrt(q), 2.0 * CHORD / PERIOD, rtol=1e-12)


def test_x_and_y_that_nearly_stand_while_a_goes_on_cost_no_time() -> None:
    """P beyond the moves: X Y nearly stand on the way from a smoothed star to short rows; once that took seconds."""
    star = [(0.257, 0.183, -1.34), (0.281, -0.087, -1.34), (0.446, 0.128, 0.06), (0.179, 0.081, -0.097)]
    star += [(0.407, -0.064, -1.702), (0.337, 0.197, -1.834), (0.212, -0.043, -1.8), (0.467, 0.05, -1.8)]
    star += [(0.216, 0.153, -1.488), (0.331, -0.092, -1.548)]
    shake = np.random.default_rng(0).normal(0.0, 0.004, 35)
    short = [(0.331 + 0.001 * k, -0.092 - 0.0018 * k, -1.55 + shake[k]) for k in range(35)]
    rows = "".join(f"G1 X{x:.6f} Y{y:.6f} A{a:.6f}\n" for x, y, a in star + short)
    times = []
    for mode in ("G61", "G64 P2.6"):
        program = pipeline.read_text(f"G21 G90 {mode} F800\nG1 X0.457 A-1.34\n{rows}M2\n")
        times.append(list(pipeline.plan(program, machine()))[-1].profile.t[-1])
    assert times[1] <= 0.4 * times[0]
