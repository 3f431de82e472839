"""A bound on the predicted contour error under `optimal`: what the simulated loops then do, and what is said."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.machine import Machine
from cncgen.machine.record import Servo
from cncgen.pipeline import read_text
from cncgen.planner import PlanOptions, plan
from cncgen.planner.contour_prediction import prediction
from cncgen.planner.least_time.replanning import by_block, speed_along
from cncgen.planner.record import Limit, Trajectory
from cncgen.servo import simulate
from cncgen.setpoints import sample
from cncgen.toolpath.record import Toolpath


def worst(trajectories: list[Trajectory], machine: Machine) -> float:
    """Return the largest contour error of the simulated loops, mm."""
    servos = {k: axis.servo for k, axis in machine.axes.items() if axis.servo is not None}
    parts = simulate(sample(iter(trajectories), machine, axes="XY"), servos, settle_s=0.2)
    return max(float(part.contour_error_mm.max(initial=0.0)) for part in parts)


def planned(chunks: list[Toolpath], machine: Machine, bound: float | None) -> list[Trajectory]:
    """Plan with `optimal`."""
    return list(plan(chunks, machine, PlanOptions(max_contour_error_mm=bound)))


@pytest.mark.parametrize(
    ("name", "bound"), [("butterfly.nc", 0.01), ("trident.nc", 0.02), ("square_sharp.nc", 0.01)]
)
def test_simulated_error_is_within_the_bound(
    program: Callable[..., list[Toolpath]], table: Machine, name: str, bound: float
) -> None:
    """Curves and corners on the table of Tsai 2010; without the bound it is far exceeded, with it nearly reached."""
    chunks = program(name)
    free, held = planned(chunks, table, None), planned(chunks, table, bound)
    assert worst(free, table) > 1.5 * bound
    assert 0.85 * bound <= worst(held, table) <= bound
    assert held[-1].profile.t[-1] > free[-1].profile.t[-1]
    assert Limit.CONTOUR_ERROR in np.concatenate([t.profile.limit for t in held])
    assert not any(t.values.get("diagnostics") for t in held)


@pytest.mark.parametrize("bound", [0.009, 0.004])
def test_stops_keep_the_bound_too(lines: Callable[..., Toolpath], mill: Machine, bound: float) -> None:
    """The mill's loops overshoot by 10.4 µm and more where it stops as fast as it may: the way to a stop is slower, then, and no bend."""
    machine = replace(mill, axes={k: mill.axes[k] for k in "XYZ"})
    for corners in ([(0, 0), (30, 0)], [(0, 0), (20, 0), (20, 20), (0, 5)]):
        chunks = [lines(corners, 200.0)]
        free, held = planned(chunks, machine, None), planned(chunks, machine, bound)
        assert worst(free, machine) > 0.0103
        assert worst(held, machine) <= bound
        assert free[-1].profile.t[-1] < held[-1].profile.t[-1] < 1.35 * free[-1].profile.t[-1]
        assert not any(t.values.get("diagnostics") for t in held)


def test_circle_runs_at_the_static_speed(arc: Callable[..., Toolpath], table: Machine) -> None:
    """Round and round, v²κ is what the steady state allows: C v²κ is just under the bound (docs/ild.md, C = 2.85e-5)."""
    bound = 0.005
    radius = 5.0
    held = planned([arc(radius, 40.0 * np.pi, 200.0)], table, bound)
    per = prediction(table, PlanOptions(), "XY").per_centripetal_s2
    top = max(float(t.profile.v.max()) for t in held)
    assert 0.88 * bound <= per * top**2 / radius <= bound
    assert worst(held, table) <= bound


def test_axes_of_different_speed(lines: Callable[..., Toolpath], table: Machine) -> None:
    """On a diagonal, loops with different lags leave the path in proportion to the speed: E = v (1/K_x − 1/K_y)/2."""
    gains = {"X": 100.0, "Y": 50.0}
    servos = {k: Servo("first-order", {"position_gain_1_s": g}) for k, g in gains.items()}
    machine = replace(table, axes={k: replace(a, servo=servos[k]) for k, a in table.axes.items()})
    held = planned([lines([(0, 0), (100, 100)], 200.0)], machine, 0.1)
    profile = next(by_block(held)).profile
    (top,) = speed_along(profile, 0.0)(np.array([70.0]))
    assert top * (1 / 50.0 - 1 / 100.0) / 2.0 == pytest.approx(0.1, rel=0.08)
    assert worst(held, machine) <= 0.1


def test_a_bound_too_loose_changes_nothing(program: Callable[..., list[Toolpath]], table: Machine) -> None:
    """Nothing binds at a millimetre, so the time is that without a bound."""
    chunks = program("trident.nc")
    assert planned(chunks, table, 1.0)[-1].profile.t[-1] == pytest.approx(
        planned(chunks, table, None)[-1].profile.t[-1], rel=1e-9
    )


def test_a_bound_that_no_speed_meets_is_reported(lines: Callable[..., Toolpath], table: Machine) -> None:
    """A nanometre."""
    held = planned([lines([(0, 0), (3, 0), (3, 3)], 100.0)], table, 1e-6)
    assert [d.code for t in held for d in t.values.get("diagnostics", ())] == ["contour-error"]


def test_axes_without_servo_data_are_named(lines: Callable[..., Toolpath], table: Machine) -> None:
    """All of them in one error."""
    bare = replace(table, axes={k: replace(a, servo=None) for k, a in table.axes.items()})
    with pytest.raises(UsageError) as found:
        planned([lines([(0, 0), (3, 0)], 100.0)], bare, 0.01)
    assert len(found.value.diagnostics) == len(bare.axes)


def test_what_does_not_move_has_no_contour_error(table: Machine) -> None:
    for text in ("G4 P0.5\nM2\n", "M2\n", "G0 X0\n"):
        done = planned(list(read_text(text).chunks()), table, 0.01)
        assert worst(done, table) == 0.0
