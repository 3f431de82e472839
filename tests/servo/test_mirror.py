"""Mirror compensation: what theory says of its error, streams."""

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.machine.record import Servo
from cncgen.servo.mirror import Compensation

from .bench import circle, profile, run, stream


def compensated(rows, servos, **options):
    work = Compensation(stream(rows, chunk=700), servos, **options)
    command = np.concatenate([chunk.position for chunk in work.chunks()])
    return command, work.gained()


@pytest.mark.parametrize("passes", [1, 2, 3])
def test_the_error_of_a_slow_circle_falls_by_the_loops_error_each_pass(passes):
    """E(s) = 1 − G(s) multiplies the error once a pass: at ω it shrinks by |E(jω)|."""
    speed, radius = 30.0, 10.0
    servos = {k: Servo("first-order", {"position_gain_1_s": 60.0}) for k in "XY"}
    rows = circle(radius, speed, turns=3.0, ramp=1.0)
    command, _ = compensated(rows, servos, passes=passes, settle_s=0.0)
    part = slice(len(rows) // 2, -300)
    left = np.hypot(*(rows - run(command, servos).position)[part].T).mean()
    z = np.exp(1j * speed / radius * 0.001)
    error = abs(1.0 - 0.06 / (z - 1.0 + 0.06))
    assert left == pytest.approx(radius * error ** (passes + 1), rel=0.02)


def test_what_it_says_it_gains_is_what_a_simulation_finds():
    u = np.linspace(0.0, 1.0, 1500)
    angle = 6.0 * u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    servos, rows = profile("xy-table"), 10.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    command, gained = compensated(rows, servos, passes=2, settle_s=0.05)
    held = np.vstack([rows, np.repeat(rows[-1:], 50, axis=0)])
    error = np.hypot(*(held - run(command, servos).position).T)
    assert gained["after"]["tracking_max_mm"] == pytest.approx(error.max(), rel=1e-9)
    assert gained["after"]["contour_max_mm"] < 0.1 * gained["before"]["contour_max_mm"]
    assert gained["contour_max_ratio"] > 10.0


def test_chunks_change_nothing():
    rows = circle(5.0, 50.0, turns=15.0)[:9500]
    servos = profile("dyna-1007")
    outcomes = []
    for chunk in (333, 20_000):
        work = Compensation(stream(rows, chunk=chunk), servos, passes=2)
        outcomes.append(np.concatenate([c.position for c in work.chunks()]))
    assert outcomes[0] == pytest.approx(outcomes[1], abs=1e-12)


def test_no_passes_are_refused():
    with pytest.raises(UsageError, match="passes = 0: at least one is needed"):
        compensated(circle(10.0, 60.0)[:50], profile("xy-table"), passes=0)
