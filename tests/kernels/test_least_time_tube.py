"""The interior point of `least_time_tube`, with `tube_point` and `tube_step`: its step beside a dense solution of the whole system with numbers of complex steps."""

from __future__ import annotations

import copy
import sys
from collections.abc import Callable
from types import ModuleType, SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from numpy.typing import NDArray

from cncgen.kernels import least_time_tube as compiled
from cncgen.kernels import tube_point
from cncgen.planner.tube.window_problem import workspace
from tests.kernels.plain import uncompiled

Floats = NDArray[np.float64]

RHO = 1e7


@pytest.fixture(scope="module")
def plain() -> SimpleNamespace:
    """What the three kernels have, as plain Python that works on plain Python."""
    found: dict[str, ModuleType] = {}
    for name in ("tube_point", "tube_step", "least_time_tube"):
        with patch.dict(sys.modules, found):
            found[f"cncgen.kernels.{name}"] = uncompiled(name)
    point, step, search = found.values()
    return SimpleNamespace(
        **vars(point), backward=step.backward, forward=step.forward, limits=search._limits, solve=search.solve
    )


def random_problem(seed: int, n: int, steps: int, held: bool) -> tuple[SimpleNamespace, SimpleNamespace]:
    """Return a problem whose first guess is strictly inside all bounds but no motion, and random multipliers."""
    rng = np.random.default_rng(seed)
    count = rng.integers(0, 3, steps + 1)
    count[[0, -1]] = 0
    rows = np.zeros((count.sum(), 2 * n + 2))
    rows[:, :n] = rng.uniform(-0.4, 0.4, (len(rows), n))
    rows[:, n : 2 * n] = rng.normal(size=(len(rows), n))
    rows[:, n : 2 * n] /= np.linalg.norm(rows[:, n : 2 * n], axis=1)[:, None]
    rows[rng.random(len(rows)) < 0.3, n : 2 * n] = 0.0
    rows[:, -2] = rng.uniform(0.3, 0.5, len(rows))
    # By 0.1 of what a limit of acceleration counts for at most.
    rows[:, -1] = np.where(rng.random(len(rows)) < 0.5, rng.uniform(0.0, 5e-5, len(rows)), 0.0)
    x = rng.uniform(-0.5, 0.5, (steps + 1, n, 3))
    u = rng.uniform(-0.8, 0.8, (steps, n + 1))
    u[:, -1] = rng.uniform(0.5, 2.0, steps)
    tangent = rng.normal(size=(steps + 1, n))
    V = rng.uniform(50.0, 100.0, n)
    fast = np.sqrt(n) * V.max()
    problem = SimpleNamespace(
        V=V, A=rng.uniform(500.0, 2000.0, n), J=rng.uniform(2e4, 5e4, n), weight=np.zeros((0, n)),
        r=np.cumsum(rng.normal(size=(steps + 1, n)), axis=0),
        t=tangent / np.linalg.norm(tangent, axis=1)[:, None],
        h0=rng.uniform(0.01, 0.02, steps), first=np.concatenate([[0], np.cumsum(count)]).astype(np.int64), rows=rows,
        feed=np.where(rng.random(steps + 1) < 0.7, 1.0 / fast, 0.0),
        between=np.where((rng.random(steps) < 0.6) & held, 0.2 / fast, 0.0),
        hlow=np.full(steps, 0.05), hhigh=np.full(steps, 8.0), goal=rng.uniform(-0.2, 0.2, 3 * n),
        x=x.reshape(steps + 1, 3 * n), u=u, calm=0.01, cost=1.4, exact=1e-7,
    )  # fmt: skip
    if held:
        problem.x[:, 2::3] *= 0.1
    # The feed is meant over two axes, at some nodes over the others.
    first_axes = (np.arange(n) < 2).astype(float)
    problem.weight = np.where(rng.random((steps + 1, 1)) < 0.7, first_axes, 1.0 - first_axes)
    work = workspace(n, steps, len(rows))
    for name in ("lam", "nu", "lamT", "zx", "zu", "zr", "zf", "zm"):
        values = getattr(work, name)
        values[...] = rng.uniform(0.1, 1.0, values.shape)
    return problem, work


class Dense:
    """The same problem as functions of one vector: all states but the first, then all controls."""

    def __init__(self, problem: SimpleNamespace, cost: float) -> None:
        self.problem, self.cost = problem, cost
        self.n, self.steps = len(problem.V), len(problem.h0)
        self.states = 3 * self.n * self.steps

    def vector(self, x: Floats, u: Floats) -> Floats:
        return np.concatenate([x[1:].ravel(), u.ravel()])

    def split(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        first = self.problem.x[:1].astype(y.dtype)
        x = np.concatenate([first, y[: self.states].reshape(self.steps, -1)])
        return x.reshape(self.steps + 1, self.n, 3), y[self.states :].reshape(self.steps, -1)

    def objective(self, y: np.ndarray) -> np.ndarray:
        _, u = self.split(y)
        p = self.problem
        calm = 0.5 * p.calm * (u[:, :-1] ** 2).sum(axis=1)
        return np.array([self.cost * (p.h0 * (u[:, -1] + calm)).sum()])

    def motion(self, y: np.ndarray) -> np.ndarray:
        """Return what nodes are missed by, in mm and seconds and then scaled, by node, axis and derivative."""
        x, u = self.split(y)
        p = self.problem
        h = (p.h0 * u[:, -1])[:, None]
        s, v, a, j = p.r + x[..., 0], p.V * x[..., 1], p.A * x[..., 2], p.J * u[:, :-1]
        went = [
            s[:-1] + h * v[:-1] + h**2 / 2 * a[:-1] + h**3 / 6 * j,
            v[:-1] + h * a[:-1] + h**2 / 2 * j,
            a[:-1] + h * j,
        ]
        came = [s[1:], v[1:], a[1:]]
        out = [(g - c) / scale for g, c, scale in zip(went, came, (1.0, p.V, p.A), strict=True)]
        return np.stack(out, axis=2).reshape(-1)

    def regular(self, y: np.ndarray) -> np.ndarray:
        """Return places across the planes, and what the goal is missed by."""
        x, _ = self.split(y)
        across = (self.problem.t * x[..., 0]).sum(axis=1)[1:-1]
        return np.concatenate([across, x[-1].ravel() - self.problem.goal])

    def slacks(self, y: np.ndarray) -> np.ndarray:
        """Return all slacks, in the order of `multipliers`."""
        x, u = self.split(y)
        p, n = self.problem, self.n
        out: list[Any] = []
        for k in range(self.steps):
            for i in range(n):
                out += [1 + u[k, i], 1 - u[k, i]]
            out += [u[k, n] - p.hlow[k], p.hhigh[k] - u[k, n]]
        for k in range(1, self.steps):
            for i in range(n):
                out += [1 + x[k, i, 1], 1 - x[k, i, 1], 1 + x[k, i, 2], 1 - x[k, i, 2]]
            for row in p.rows[p.first[k] : p.first[k + 1]]:
                away = x[k, :, 0] + row[-1] * p.A * x[k, :, 2] + row[:n]
                away = away - (away * row[n:-2]).sum() * row[n:-2]
                out.append(1 - (away**2).sum() * row[-2] ** 2)
            if p.feed[k] > 0:
                out.append(1 - (p.weight[k] * (p.V * x[k, :, 1] * p.feed[k]) ** 2).sum())
        for k in np.flatnonzero(p.between > 0).tolist():
            middle = x[k, :, 1] + p.h0[k] * u[k, n] * p.A * x[k, :, 2] / 2 / p.V
            for y_ in middle:
                out += [1 + y_, 1 - y_]
            out.append(1 - (p.weight[k] * p.weight[k + 1] * (p.V * middle * p.between[k]) ** 2).sum())
        return np.array(out)

    def multipliers(self, work: SimpleNamespace) -> Floats:
        p, out = self.problem, [work.zu.ravel()]
        for k in range(1, self.steps):
            out += [
                work.zx[k],
                work.zr[p.first[k] : p.first[k + 1]],
                work.zf[k : k + 1] if p.feed[k] > 0 else [],
            ]
        out += [work.zm[k] for k in np.flatnonzero(p.between > 0).tolist()]
        return np.concatenate(out)


def jacobian(function: Callable[[np.ndarray], np.ndarray], y: Floats) -> Floats:
    """Return derivatives by complex steps, exact to rounding."""
    columns = []
    for i in range(len(y)):
        moved = y.astype(complex)
        moved[i] += 1e-30j
        columns.append(function(moved).imag / 1e-30)
    return np.stack(columns, axis=-1)


def hessian(function: Callable[[np.ndarray], np.ndarray], y: Floats) -> Floats:
    """Return second derivatives of a sum: central differences of complex steps."""
    e = 1e-5
    rows = [
        (jacobian(function, y + e * unit) - jacobian(function, y - e * unit))[0] / (2 * e)
        for unit in np.eye(len(y))
    ]
    return np.stack(rows)


@pytest.mark.parametrize(("n", "held"), [(2, False), (2, True), (3, False), (3, True), (4, False)])
def test_step_solves_the_whole_system(plain: SimpleNamespace, n: int, held: bool) -> None:
    problem, work = random_problem(10 * n + held, n, 4, held)
    tube = plain.Tube(problem, work)
    tube.mu, delta = 0.05, 3.0
    plain.measure(tube, False)
    assert plain.backward(tube, delta)
    plain.forward(tube)
    dense = Dense(problem, tube.cost)
    y = dense.vector(problem.x, problem.u)
    z, s, slopes = dense.multipliers(work), dense.slacks(y), jacobian(dense.slacks, y)

    def lagrangian(at: np.ndarray) -> np.ndarray:
        total = dense.objective(at)[0] + work.lam.ravel() @ dense.motion(at) - z @ dense.slacks(at)
        return np.array([total])

    W = hessian(lagrangian, y) + slopes.T @ ((z / s)[:, None] * slopes)
    last = np.arange(len(y))
    # The state at the end is held by its weight alone.
    damped = (last < dense.states - 3 * n) | (last >= dense.states)
    W += delta * np.diag(damped.astype(float))
    gradient = jacobian(dense.objective, y)[0] - slopes.T @ (tube.mu / s)
    C, G = jacobian(dense.motion, y), jacobian(dense.regular, y)
    old = np.concatenate([work.nu[1:-1], work.lamT])
    zero = np.zeros((len(C), len(C) + len(G)))
    # The end is held the more, the more steps are damped.
    rho = np.concatenate([np.full(len(work.nu[1:-1]), RHO), np.full(3 * n, max(1.0, delta) * RHO)])
    system = np.block([
        [W, C.T, G.T],
        [C, zero],
        [G, np.zeros((len(G), len(C))), -np.diag(1.0 / rho)],
    ])  # fmt: skip
    right = np.concatenate([-gradient, -dense.motion(y), -dense.regular(y) - old / RHO])
    found = np.linalg.solve(system, right)
    step, lam, regular = np.split(found, [len(y), len(y) + len(C)])
    assert np.allclose(dense.vector(work.dx, work.du), step, rtol=1e-5, atol=1e-6 * np.abs(step).max())
    assert np.allclose(work.lam2.ravel(), lam, rtol=1e-5, atol=1e-6 * np.abs(lam).max())
    ours = np.concatenate([work.nu2[1:-1], work.lamT2])
    assert np.allclose(ours, regular, rtol=1e-5, atol=1e-6 * np.abs(regular).max())


@pytest.mark.parametrize(("n", "held"), [(2, False), (2, True), (3, True)])
def test_measures(plain: SimpleNamespace, n: int, held: bool) -> None:
    problem, work = random_problem(70 + n, n, 5, held)
    tube = plain.Tube(problem, work)
    plain.measure(tube, False)
    dense = Dense(problem, tube.cost)
    y = dense.vector(problem.x, problem.u)
    slacks = dense.slacks(y)
    missed = np.abs(np.concatenate([dense.motion(y), dense.regular(y)]))
    assert tube.value == pytest.approx(dense.objective(y)[0], rel=1e-12)
    assert tube.logs == pytest.approx(np.log(slacks).sum(), rel=1e-12)
    assert tube.missed == pytest.approx(missed.sum(), rel=1e-9)


@pytest.mark.parametrize("n", [2, 3])
def test_longest_step_leaves_a_hundredth_of_every_slack(plain: SimpleNamespace, n: int) -> None:
    for seed in range(20):
        problem, work = random_problem(100 + seed, n, 4, False)
        tube = plain.Tube(problem, work)
        tube.mu = 0.05
        plain.measure(tube, False)
        assert plain.backward(tube, 3.0)
        plain.forward(tube)
        steps = plain.limits(tube, n)
        dense = Dense(problem, tube.cost)
        y, step = dense.vector(problem.x, problem.u), dense.vector(work.dx, work.du)

        def left(part: float, dense: Dense = dense, y: Floats = y, step: Floats = step) -> float:
            return float((dense.slacks(y + part * step) / dense.slacks(y)).min())

        low, high = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if left(middle) >= 0.01 else (low, middle)
        assert steps.primal == pytest.approx(low, rel=1e-9)


def test_compiled_finds_the_same_as_plain_python(plain: SimpleNamespace) -> None:
    # A corner of 90° between two states at rest, in the middle of which one node is near its vertex.
    steps, unit = 12, 0.01
    way = np.linspace(-1.0, 1.0, steps + 1)
    point = np.stack([np.minimum(way, 0.0), np.maximum(way, 0.0)], axis=1)
    tangent = np.gradient(point, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    direction = np.where(way[:, None] < 0.0, [1.0, 0.0], [0.0, 1.0])
    direction[steps // 2] = 0.0
    inner = slice(1, steps)
    rows = np.concatenate(
        [np.zeros((steps - 1, 2)), direction[inner], np.ones((steps - 1, 1)), np.zeros((steps - 1, 1))],
        axis=1,
    )
    x = np.zeros((steps + 1, 2, 3))
    x[inner, :, 1] = 0.1 * tangent[inner]
    u = np.zeros((steps, 3))
    u[:, 2] = 1.0
    first = np.concatenate([[0], np.arange(steps), [steps - 1]]).astype(np.int64)
    problem = SimpleNamespace(
        V=np.full(2, 100.0 / unit), A=np.full(2, 2000.0 / unit), J=np.full(2, 5e4 / unit), weight=np.ones((steps + 1, 2)), r=point / unit, t=tangent,
        h0=np.full(steps, 0.016), first=first, rows=rows, feed=np.full(steps + 1, unit / 100.0), between=np.zeros(steps),
        hlow=np.full(steps, 0.05), hhigh=np.full(steps, 8.0), goal=np.zeros(6), x=x.reshape(steps + 1, 6), u=u, calm=0.01, cost=1.25,
        exact=1e-7,
    )  # fmt: skip
    same = copy.deepcopy(problem)
    slow, fast = (
        plain.Tube(problem, workspace(2, steps, len(rows))),
        tube_point.Tube(same, workspace(2, steps, len(rows))),
    )
    ours, theirs = plain.solve(slow, 1e-3, 1e-6, 120), compiled.solve(fast, 1e-3, 1e-6, 120)
    assert ours.status == theirs["status"] == 1
    assert ours.iterations == theirs["iterations"]
    assert np.allclose(problem.x, same.x, rtol=0.0, atol=1e-9)
    assert np.allclose(problem.u, same.u, rtol=0.0, atol=1e-9)
