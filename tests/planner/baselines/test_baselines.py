"""The papers' baselines: the speed at every place is the law's, on curves, lines and arcs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cncgen.machine import Machine
from cncgen.planner import PlanOptions, plan
from cncgen.planner.motion import motion_at
from cncgen.planner.record import Limit
from cncgen.toolpath.record import Event, Toolpath

LAWS: dict[str, Callable[[np.ndarray, float], np.ndarray]] = {
    "constant": lambda kappa, top: np.full_like(kappa, top),
    "adaptive": lambda kappa, top: np.minimum(top, 2e3 * np.sqrt(2e-3 / kappa - 1e-6)),
    "curvature": lambda kappa, top: top / (kappa + 1.0),
}


@pytest.mark.parametrize("name", list(LAWS))
def test_speed_is_the_law_everywhere(
    name: str, program: Callable[..., list[Toolpath]], table: Machine
) -> None:
    """Sampled between the pieces' ends on the butterfly: within 0.2 % of eq. 24 (δ 1 µm, T 1 ms) or 25 (κ̄ 1/mm)."""
    done, *_ = plan(program("butterfly.nc", 7000), table, PlanOptions(feedrate=name))
    at = motion_at(done.profile, np.linspace(1e-6, done.profile.t[-1] - 1e-6, 20_000))
    law = LAWS[name](done.toolpath.path.curvature(at.s), 7000 / 60)
    np.testing.assert_allclose(at.v, law, rtol=2e-3)
    assert done.profile.s[-1] == pytest.approx(382.8566, abs=1e-3)


def test_time_is_the_integral(program: Callable[..., list[Toolpath]], table: Machine) -> None:
    """∫ ds/V of eq. 25 by quadrature over the curve: T = L/F + ∫κ ds/F."""
    done, *_ = plan(program("butterfly.nc", 7000), table, PlanOptions(feedrate="curvature"))
    path = done.toolpath.path
    s = np.linspace(*path.row_s[[0, -1]], 400_001)
    kappa = path.curvature(0.5 * (s[1:] + s[:-1]))
    expected = (path.length + np.sum(kappa * np.diff(s))) / (7000 / 60)
    assert done.profile.t[-1] == pytest.approx(expected, rel=1e-3)


def test_lines_arcs_and_waits(
    lines: Callable[..., Toolpath], arc: Callable[..., Toolpath], table: Machine
) -> None:
    """Feed on lines from first to last; eq. 24 on a small arc; a dwell waits; speeds may step at joints."""
    path = lines([(0, 0), (50, 0), (50, 100)], 100.0, events={1: Event("dwell", dwell_s=0.25)})
    (done,) = plan([path], table, PlanOptions(feedrate="adaptive"))
    assert done.profile.t[-1] == pytest.approx(0.5 + 0.25 + 1.0)
    assert done.events[0][0] == pytest.approx(0.5)
    assert Limit.STOP in done.profile.limit
    (turn,) = plan([arc(0.5, 3.0, 100.0)], table, PlanOptions(feedrate="adaptive"))
    assert turn.profile.v.max() == pytest.approx(2e3 * (2e-3 * 0.5 - 1e-6) ** 0.5)
    assert set(turn.profile.limit.tolist()) == {int(Limit.CHORD)}


def test_chunks_follow_each_other(lines: Callable[..., Toolpath], table: Machine) -> None:
    """Time goes on from chunk to chunk; a chunk of events alone takes their dwells."""
    chunks = [lines([(0, 0), (10, 0)], 10.0), lines([(10, 0)], events={0: Event("dwell", dwell_s=2.0)})]
    done = list(plan(chunks, table, PlanOptions(feedrate="constant")))
    assert [t.profile.t[-1] for t in done] == pytest.approx([1.0, 3.0])
    assert done[1].events[0][0] == pytest.approx(1.0)
