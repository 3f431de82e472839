"""The passes of the least-time kernels over their rows, beside the same by the definition of every constraint."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from types import ModuleType

import numpy as np
import pytest

from cncgen.kernels import (
    least_time,
    least_time_between,
    least_time_matrix,
    least_time_passes,
    least_time_problem,
    least_time_rows,
)
from tests.kernels.plain import uncompiled

N, AXES = 45, 2
LIMITS = np.array([[900.0, 700.0], [4e4, 3e4]])
ASLEEP, AWAKE = 1, 2


@dataclass
class Case:
    """Intervals of random lengths along a path of random derivatives, and the kernels that work on them."""

    rows: ModuleType
    matrix: ModuleType
    passes: ModuleType
    problem: least_time_problem.Problem

    @property
    def c(self) -> np.ndarray:
        """The unknowns."""
        return np.asarray(self.problem.c)

    def uses(self, c: np.ndarray) -> list[np.ndarray]:
        """Return A·(q, d, κ) and r, times q^½ for a jerk, of all accelerations and jerks at left ends, and jerks at right ones."""
        h, ends, way = (np.asarray(x) for x in (self.problem.h, self.problem.ends, self.problem.way))
        h, way = h[:, None], way[:, None]
        b0 = (ends[:, 0] * c[:-2] + ends[:, 1] * c[1:-1])[:, None]
        b2 = (ends[:, 2] * c[1:-1] + ends[:, 3] * c[2:])[:, None]
        b1 = c[1:-1, None]
        left, right = (b1 - b0) / (2.0 * way), (b2 - b1) / (2.0 * (h - way))
        bend = (right - left) / h
        x1, x2, x3 = (np.asarray(x) for x in (self.problem.d1, self.problem.d2, self.problem.d3))
        found = [((x2[:, 0] * b0 + x1[:, 0] * left) / LIMITS[0], np.ones((N, AXES)))]
        for end, b, d in ((0, b0, left), (2, b2, right)):
            pull = np.asarray(self.problem.fixed).reshape(-1, 21, 32)[:, 16 + end // 2].ravel()[:N, None]
            jerk = (x3[:, end] * b + 3.0 * x2[:, end] * d + x1[:, end] * bend * pull) / LIMITS[1]
            found.append((jerk, b**-0.5 * np.ones((N, AXES))))
        return found

    def limits(self, c: np.ndarray) -> np.ndarray:
        """Return r of every one-sided constraint."""
        return np.concatenate([np.concatenate([r.ravel()] * 2) for _, r in self.uses(c)])

    def values(self, c: np.ndarray) -> np.ndarray:
        """Return r ∓ A·(q, d, κ) of every one-sided constraint."""
        return np.concatenate([np.concatenate([(r - x).ravel(), (r + x).ravel()]) for x, r in self.uses(c)])

    def slopes(self, c: np.ndarray) -> np.ndarray:
        """Return the gradients of `values`, a row each, by complex steps: exact to rounding."""
        units = np.eye(N + 2)
        return np.stack([np.imag(self.values(c + 1e-30j * unit)) / 1e-30 for unit in units], axis=-1)


def winding(h: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return derivatives of a path of unit speed whose heading is 0.6 sin 2s, on intervals of lengths `h`."""
    s = np.append(0.0, np.cumsum(h))
    at = np.stack([s[:-1], 0.5 * (s[:-1] + s[1:]), s[1:]], axis=1)
    heading, turn, more = 0.6 * np.sin(2.0 * at), 1.2 * np.cos(2.0 * at), -2.4 * np.sin(2.0 * at)
    along = np.stack([np.cos(heading), np.sin(heading)], axis=2)
    across = np.stack([-np.sin(heading), np.cos(heading)], axis=2)
    third = more[:, :, None] * across - (turn**2)[:, :, None] * along
    return along, turn[:, :, None] * across, third


def case(monkeypatch: pytest.MonkeyPatch, compiled: bool = True, smooth: bool = False) -> Case:
    """Return a case whose rows are built and surveyed; with kernels as plain Python where these are not to be compiled."""
    kernels = [least_time_problem, least_time_matrix, least_time_passes, least_time_rows]
    if not compiled:
        for k, part in enumerate(("problem", "matrix", "passes", "rows")):
            kernels[k] = uncompiled(f"least_time_{part}")
            monkeypatch.setitem(sys.modules, f"cncgen.kernels.least_time_{part}", kernels[k])
    numbers, matrix, passes, rows = kernels
    rng = np.random.default_rng(11)
    d1, d2, d3 = (scale * rng.normal(size=(N, 3, AXES)) for scale in (1.0, 0.3, 0.1))
    h = rng.uniform(0.05, 0.1 if smooth else 0.2, N)
    if smooth:
        d1, d2, d3 = winding(h)
    problem = numbers.Problem(
        1,
        h,
        np.zeros((N, 2)),
        d1,
        d2,
        d3,
        LIMITS,
        np.ones((N, 2, AXES)),
        np.zeros((N, AXES)),
        np.zeros(N, np.int8),
    )
    problem.c[:] = 300.0 + 10.0 * np.sin(np.arange(N + 2.0))
    if not smooth:
        # Tangents that meet anywhere.
        np.asarray(problem.fixed).reshape(-1, 21, 32)[:, 14] *= rng.uniform(0.6, 1.4, (2, 32))
        numbers.lay(problem)
    rows.build(
        problem,
        np.full((N, 3), np.inf),
        np.zeros(N),
        np.zeros(N, np.int8),
        np.full((N, 2), np.inf),
        np.zeros(N, np.int8),
    )
    matrix.survey(problem)
    return Case(rows, matrix, passes, problem)


@pytest.mark.parametrize("compiled", [True, False])
def test_steps_of_predictor_and_corrector(compiled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Algorithm 14.3 of Nocedal and Wright (2006): Δw = g + ∇g Δc − w, and Δλ from λ w + λ Δw + w Δλ = μ − Δw_aff Δλ_aff."""
    this, rng, mu = case(monkeypatch, compiled), np.random.default_rng(12), 3e-3
    c, dc = this.c.copy(), np.append(rng.normal(size=N + 1), 0.0)
    this.passes.set_up(this.problem, mu)
    g, slopes = this.values(c), this.slopes(c)
    w = np.maximum(g, this.limits(c))
    y = mu / w
    this.matrix.turn(this.problem, dc)
    second, centre, out = np.zeros(N + 2), np.zeros(N + 2), np.zeros(4)
    this.passes.predict(this.problem, second, centre, out)
    dw = g + slopes @ dc - w
    dy = -y * (1.0 + dw / w)
    assert out == pytest.approx(
        [max(0.0, (-dw / w).max()), max(0.0, (-dy / y).max()), dw @ y, dw @ dy], rel=1e-9
    )
    for ours, wanted in ((second, -slopes.T @ (dw * dy / w)), (centre, slopes.T @ (1.0 / w))):
        assert ours == pytest.approx(wanted, rel=1e-9, abs=1e-9 * np.abs(wanted).max())
    # The corrector takes another step than the predictor, whose products alone it keeps.
    other, target, found = rng.normal(size=N + 2), 1e-3, np.zeros(4)
    this.matrix.turn(this.problem, other)
    this.passes.correct(this.problem, target, found)
    dw_other = g + slopes @ other - w
    dy_other = (target - dw * dy - y * dw_other) / w - y
    assert found[:2] == pytest.approx([(-dw_other / w).max(), (-dy_other / y).max()], rel=1e-9)
    # `gather` goes there: λ w by its sum after the steps, where slacks are the constraint's value at least.
    dual, right, band = np.zeros(N + 2), np.zeros(N + 2), np.zeros((3, N + 2))
    step, rise = 0.5 / found[0], 0.5 / found[1]
    this.passes.gather(this.problem, step, rise, dual, right, band, found)
    assert found[1] == pytest.approx(np.maximum(w + step * dw_other, g) @ (y + rise * dy_other), rel=1e-9)


@pytest.mark.parametrize("compiled", [True, False])
def test_rows_wake_that_use_more_than_three_fifths(compiled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    this = case(monkeypatch, compiled)
    this.c[:] = 1e-3
    this.rows.thin(this.problem, 0, 0.5)
    state = np.asarray(this.problem.state)
    kinds = np.asarray(this.problem.batches)[: this.problem.count, 2]
    assert np.all(state[: this.problem.count][kinds == 1] != AWAKE)
    assert not this.passes.wake(this.problem, 1e-3)
    this.c[:] = 1500.0 + 1400.0 * np.sin(0.3 * np.arange(N + 2.0))
    this.matrix.survey(this.problem)
    assert this.passes.wake(this.problem, 1e-3)
    used = np.abs(this.uses(this.c)[0][0])
    for batch in np.flatnonzero(kinds == 1):
        block, _, _, axis = np.asarray(this.problem.batches)[batch]
        here = used[32 * block : 32 * block + 32, axis]
        assert state[batch, : len(here)].tolist() == np.where(here > 0.6, AWAKE, ASLEEP).tolist()


def test_the_profile_to_start_from_leaves_rest_with_full_jerk(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a line q = v² with v = j t²/2 at s = j t³/6, up to the middle, and mirrored from there; times the part."""
    jerk, h, first = 3e4, 0.1, 0.3

    def q(s: np.ndarray) -> np.ndarray:
        return (0.5 * jerk * (6.0 * s / jerk) ** (2.0 / 3.0)) ** 2

    n = 80
    extra = np.zeros((n, 2))
    extra[0, 0] = extra[-1, 1] = 3.0 * first
    line = np.zeros((3, n, 3, 1))
    line[0] = 1.0
    for problems, rows in ((least_time_problem, least_time_rows), (None, None)):
        if problems is None:
            plain = case(monkeypatch, compiled=False)
            problems, rows = sys.modules["cncgen.kernels.least_time_problem"], plain.rows
        problem = problems.Problem(
            1, np.full(n, h), extra, *line, np.array([[1e9], [jerk]]), np.ones((n, 2, 1)),
            np.zeros((n, 1)), np.zeros(n, np.int8),
        )  # fmt: skip
        top = np.full((n, 2), 1e12)
        top[0, 0] = top[-1, 1] = q(np.array(first))
        rows.start(problem, top, 0.9)
        s = first + h * np.arange(n + 1)
        profile = q(np.minimum(s, s[-1] + first - s))
        # An interval has the lower of its ends.
        wanted = 0.9 * np.minimum(profile[:-1], profile[1:])
        assert np.asarray(problem.c)[1:-1] == pytest.approx(wanted, rel=1e-6)


def test_limits_are_parts_of_rows_and_what_is_nearest_is_the_least_slack(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """At the optimum slacks are what the definition of each constraint leaves, and the nearest kind has the least."""
    this = case(monkeypatch, smooth=True)
    assert least_time.solve(this.problem, 1e-9, 5e-4, 200, np.zeros(7), np.zeros(N + 2)) == 0
    assert np.asarray(this.problem.share).max() <= 1.0
    margin, closest = np.ones(N), np.zeros(N, np.int8)
    least_time_rows.nearest(this.problem, margin, closest)
    slacks = []
    for k, (value, r) in enumerate(this.uses(this.c)):
        part = np.asarray(this.problem.share)[:, 1 if k else 0]
        slacks.append((1.0 - np.abs(value) / (r * part)).min(axis=1))
    acceleration, jerk = slacks[0], np.minimum(slacks[1], slacks[2])
    assert margin == pytest.approx(np.minimum(acceleration, jerk), abs=1e-4)
    clear = np.abs(acceleration - jerk) > 1e-3
    assert clear.sum() > N // 2
    assert closest[clear].tolist() == np.where(acceleration < jerk, 1, 2)[clear].tolist()


def test_the_time_without_limits_is_that_of_the_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    """q is the bound everywhere, so F = length/√bound; and a bound twice as high there takes its part of that."""
    rows = case(monkeypatch).problem
    high = 1e12 * np.ones_like(LIMITS)
    problem = least_time_problem.Problem(
        1, rows.h, np.zeros((N, 2)), rows.d1, rows.d2, rows.d3, high, np.ones((N, 2, AXES)),
        np.zeros((N, AXES)), np.zeros(N, np.int8),
    )  # fmt: skip
    box = np.full((N, 3), 400.0)
    least_time_rows.build(
        problem, box, np.zeros(N), np.zeros(N, np.int8), np.full((N, 2), np.inf), np.zeros(N, np.int8)
    )
    problem.c[:] = 100.0
    problem.c[0] = problem.c[N + 1] = 400.0
    report = np.zeros(7)
    assert least_time.solve(problem, 1e-9, 5e-4, 200, report, np.zeros(N + 2)) == 0
    assert report[0] == pytest.approx(np.sum(rows.h) / 20.0, rel=1e-7)
    assert np.asarray(problem.c) == pytest.approx(400.0, rel=1e-4)


def test_the_response_is_the_last_column_of_the_inverse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the Newton matrix that `gather` sets up, as numpy inverts it."""
    this = case(monkeypatch, smooth=True)
    out = np.zeros(N + 2)
    # It ends before the optimum, so the matrix is that of the last iterate.
    assert least_time.solve(this.problem, 1e-9, 5e-4, 6, np.zeros(7), out) == -1
    dual, right, band = np.zeros(N + 2), np.zeros(N + 2), np.zeros((3, N + 2))
    least_time_passes.gather(this.problem, 0.0, 0.0, dual, right, band, np.zeros(4))
    full = np.zeros((N + 2, N + 2))
    for m in range(3):
        for k in range(N + 2 - m):
            full[k, k + m] = full[k + m, k] = band[m, k]
    column = np.linalg.inv(full[1 : N + 1, 1 : N + 1])[:, -1]
    assert out[1 : N + 1] == pytest.approx(column / column[-1], rel=1e-6, abs=1e-9)


def test_parts_of_limits_go_into_their_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Row by row what `share` has for its interval, kind and axis, and 1.2 · slack more in the eased intervals."""
    this = case(monkeypatch)
    share = np.asarray(this.problem.share)
    share[:] = np.random.default_rng(4).uniform(0.5, 1.0, share.shape)
    least_time_between.apply(this.problem, 1e-3, 3)
    parts = np.asarray(this.problem.rows).reshape(-1, 12, 32)[:, 3]
    for batch, (block, _, kind, axis) in enumerate(np.asarray(this.problem.batches)[: this.problem.count]):
        k = np.arange(32 * block, min(32 * block + 32, N))
        wanted = share[k, 0 if kind == 1 else 1, axis] + np.where(k < 3, 1.2 * 1e-3, 0.0)
        np.testing.assert_array_equal(parts[batch, : len(k)], wanted)
