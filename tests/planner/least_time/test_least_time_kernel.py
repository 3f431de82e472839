"""The interior-point kernel against a general solver, closed forms, and compiled against plain Python."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest
from scipy.optimize import minimize

from cncgen.kernels import (
    least_time_between,
    least_time_matrix,
    least_time_passes,
    least_time_problem,
    least_time_rows,
)
from cncgen.planner.least_time import problem
from cncgen.planner.least_time.mesh import ENTER, LEAVE, SPLINE
from cncgen.planner.least_time.problem import Intervals, slopes, solve
from cncgen.planner.record import Limit
from tests.kernels.plain import uncompiled

#: Columns of a problem that have a row for each interval.
PER_INTERVAL = (
    "h",
    "kind",
    "x1",
    "x2",
    "x3",
    "top",
    "top_limit",
    "factor",
    "x3_excess",
    "node_top",
    "node_acceleration",
)


def plain(monkeypatch: pytest.MonkeyPatch) -> dict[str, ModuleType]:
    """Load the kernels uncompiled, each with those that it calls."""
    kernels = {}
    for part in ("_problem", "_matrix", "_passes", "_between", "_ways", "_rows", ""):
        name = f"least_time{part}"
        kernels[name] = uncompiled(name)
        monkeypatch.setitem(sys.modules, f"cncgen.kernels.{name}", kernels[name])
    return kernels


#: What `state` says of a row that is awake.
AWAKE = 2


def wave(
    count: int, length: float = 30.0, height: float = 2.0, feed: float = 60.0, axes: int = 2
) -> Intervals:
    """Return a wave x = s', y = height·sin, roughly by its length: the kernel need not know that it is no unit speed."""
    s = np.concatenate([[0.0], length * np.linspace(0.03, 0.97, count - 1), [length]])
    at = np.stack([s[:-1], 0.5 * (s[:-1] + s[1:]), s[1:]], axis=1)
    w = 2.0 * np.pi / length * 2.0
    columns = []
    for order in (1, 2, 3):
        x = np.ones_like(at) if order == 1 else np.zeros_like(at)
        y = height * w**order * np.sin(w * at + order * np.pi / 2.0)
        columns.append(np.stack([x, y, 0.1 * y][:axes], axis=2))
    kind = np.full(count, SPLINE, np.int8)
    kind[0], kind[-1] = LEAVE, ENTER
    return Intervals(
        h=np.diff(s),
        kind=kind,
        x1=columns[0],
        x2=columns[1],
        x3=columns[2],
        top=np.full((count, 3), feed**2),
        top_limit=np.full(count, Limit.FEED, np.int8),
        factor=np.ones((count, 2, axes)),
        x3_excess=np.zeros((count, axes)),
        node_top=np.full(count, np.inf),
        node_acceleration=np.full(count, np.inf),
        limits=np.array([[1000.0] * axes, [50_000.0] * axes]),
    )


def time_of(given: Intervals, c: np.ndarray, ends: np.ndarray, extra: np.ndarray) -> float:
    """Return the time by the objective's definition: Simpson's rule on q^-1/2, and 3 h q^-1/2 beside a rest."""
    return time_of_complex(given, c, ends, extra).real


def time_of_complex(given: Intervals, c: np.ndarray, ends: np.ndarray, extra: np.ndarray) -> complex:
    """Return the same of complex unknowns, as analytic function."""
    h = given.h[1:-1]
    b0, b2 = ends[:, 0] * c[:-2] + ends[:, 1] * c[1:-1], ends[:, 2] * c[1:-1] + ends[:, 3] * c[2:]
    m = 0.25 * (b0 + b2) + 0.5 * c[1:-1]
    simpson = h / 6.0 * (b0**-0.5 + 4.0 * m**-0.5 + b2**-0.5)
    return complex(np.sum(simpson + extra[:, 0] * b0**-0.5 + extra[:, 1] * b2**-0.5))


def durations(h: np.ndarray, q: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Return the time T of constant jerk over intervals: h = (v₀ + v₁) T/2 − (a₁ − a₀) T²/12, the smaller root."""
    before, after = slopes(h, q, way)
    gain, mean = after - before, 0.5 * (np.sqrt(q[:, 0]) + np.sqrt(q[:, 2]))
    return 2.0 * h / (mean + np.sqrt(np.maximum(mean**2 - gain * h / 3.0, 0.0)))


def motion(given: Intervals, q: np.ndarray, way: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return |acceleration| and |jerk| as parts of their limits at both ends of the spline intervals, of constant jerk along the path."""
    h, q, way = given.h[1:-1], q[1:-1], way[1:-1]
    before, after = slopes(h, q, way)
    along = ((after - before) / durations(h, q, way))[:, None]
    acceleration, jerk = [], []
    for end, b, d in ((0, q[:, 0, None], before[:, None]), (2, q[:, 2, None], after[:, None])):
        x1, x2, x3 = given.x1[1:-1, end], given.x2[1:-1, end], given.x3[1:-1, end]
        acceleration.append(x2 * b + x1 * d)
        jerk.append((x3 * b + 3.0 * x2 * d) * np.sqrt(b) + x1 * along)
    return np.abs(acceleration) / given.limits[0], np.abs(jerk) / given.limits[1]


def settled(given: Intervals, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return q and ways of unknowns on a row from rest to rest, so that the jerk is constant: l = h/2 − (v₁ − v₀) T/12.

    Beside a rest v² has the slope 4 q/(3 h) of constant jerk from there; between two intervals it lies on their common tangent.
    """
    h, c = given.h[1:-1], c[1:-1]
    way = 0.5 * h
    q = np.zeros((len(given), 3))
    for _ in range(40):
        rest = h - way
        q[1:-1, 1] = c
        q[2:-1, 0] = q[1:-2, 2] = (way[1:] * c[:-1] + rest[:-1] * c[1:]) / (rest[:-1] + way[1:])
        q[1, 0] = c[0] / (1.0 + 4.0 * way[0] / (3.0 * given.h[0]))
        q[-2, 2] = c[-1] / (1.0 + 4.0 * rest[-1] / (3.0 * given.h[-1]))
        speed = np.sqrt(np.maximum(q[1:-1], 0.0))
        time = durations(h, np.maximum(q[1:-1], 1e-9), way)
        way = np.clip(0.5 * h - (speed[:, 2] - speed[:, 0]) * time / 12.0, 0.25 * h, 0.75 * h)
    q[0, 2], q[-1, 0] = q[1, 0], q[-2, 2]
    return q, np.concatenate([[0.0], way, [0.0]])


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_the_least_time_is_that_of_a_general_solver(axes: int) -> None:
    given = wave(30, height=0.5, axes=axes)
    ours = solve(given, None)
    assert ours.converged

    columns = problem.SplineRow.of(given, None)
    at, box = columns.at, columns.box

    def full(x: np.ndarray) -> np.ndarray:
        return np.concatenate([[1.0], x * 1000.0, [1.0]])

    def room(x: np.ndarray) -> np.ndarray:
        q, way = settled(given, full(x))
        acceleration, jerk = motion(given, q, way)
        bounded = np.isfinite(box)
        return np.concatenate(
            [
                1.0 - acceleration.ravel(),
                1.0 - jerk.ravel(),
                1.0 - (q[1:-1] / box)[bounded],
                x,
                q[1:-1].ravel() * 1e-3,
            ]
        )

    start = np.full(len(at), 0.1)
    found = minimize(
        lambda x: time_from(given, *settled(given, full(x))),
        start,
        method="SLSQP",
        constraints={"type": "ineq", "fun": room},
        options={"maxiter": 400, "ftol": 1e-9},
    )
    assert found.success
    # What the method holds between the ends of an interval too costs a little; it never gains.
    assert found.fun * (1.0 - 1e-4) < time_from(given, ours.q, ours.way) < found.fun * 1.02


def constraints(given: Intervals, at: np.ndarray, ends: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return r ∓ the part of its limit of every acceleration at a left end and every jerk, by their definitions."""
    h = given.h[at, None]
    b0 = (ends[:, 0] * c[:-2] + ends[:, 1] * c[1:-1])[:, None]
    b2 = (ends[:, 2] * c[1:-1] + ends[:, 3] * c[2:])[:, None]
    b1 = c[1:-1, None]
    left, right, bend = (b1 - b0) / h, (b2 - b1) / h, (b0 - 2.0 * b1 + b2) / h**2
    x1, x2, x3 = given.x1[at], given.x2[at], given.x3[at]
    acceleration = (x2[:, 0] * b0 + x1[:, 0] * left) / given.limits[0]
    out = [1.0 - acceleration, 1.0 + acceleration]
    for end, b, d in ((0, b0, left), (2, b2, right)):
        jerk = (x3[:, end] * b + 3.0 * x2[:, end] * d + x1[:, end] * bend) / given.limits[1]
        out += [b**-0.5 - jerk, b**-0.5 + jerk]
    return np.concatenate([x.ravel() for x in out])


def test_residual_matrix_and_right_side_are_those_of_the_constraints_as_they_are_defined() -> None:
    """∇F − Σ λ ∇g, ∇²F + Σ λ/w ∇g ∇gᵀ and −∇F + Σ λ/w (w − g) ∇g, the gradients by complex steps, exact to rounding."""
    given = wave(42, height=0.5)
    columns = problem.SplineRow.of(given, None)
    at, h, extra = columns.at, columns.h, columns.extra
    rows = least_time_problem.Problem(
        1, h, extra, given.x1[at], given.x2[at], given.x3[at], given.limits, given.factor[at],
        given.x3_excess[at], columns.back,
    )  # fmt: skip
    n, mu, ends = len(at), 1e-3, np.asarray(rows.ends)
    c = 300.0 + 100.0 * np.sin(np.arange(n + 2.0))
    rows.c[:] = c
    least_time_rows.build(
        rows,
        np.full((n, 3), np.inf),
        np.zeros(n),
        np.zeros(n, np.int8),
        np.full((n, 2), np.inf),
        np.zeros(n, np.int8),
    )
    assert least_time_matrix.survey(rows) == pytest.approx(time_of(given, c, ends, extra), rel=1e-13)
    least_time_passes.set_up(rows, mu)
    dual, right, band, found = np.zeros(n + 2), np.zeros(n + 2), np.zeros((3, n + 2)), np.zeros(4)
    least_time_passes.gather(rows, 0.0, 0.0, dual, right, band, found)

    def slope(of: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        return np.stack([np.imag(of(c + 1e-30j * unit)) / 1e-30 for unit in np.eye(n + 2)], axis=-1)

    def time_slope(x: np.ndarray) -> np.ndarray:
        steps = (time_of_complex(given, x + 1e-30j * unit, ends, extra) for unit in np.eye(n + 2))
        return np.array([step.imag / 1e-30 for step in steps])

    g, slopes = constraints(given, at, ends, c), slope(lambda x: constraints(given, at, ends, x))
    # Slacks begin with what the limit is without the motion, at the least.
    limits = np.concatenate([np.ones(4 * n), constraints(given, at, ends, c)[4 * n :]])
    jerks = limits[4 * n :].reshape(2, 2, -1)
    jerks[:] = jerks.mean(axis=1, keepdims=True)
    w = np.maximum(g, limits)
    y = mu / w
    force = time_slope(c)
    assert dual == pytest.approx(force - slopes.T @ y, rel=1e-9, abs=1e-9 * np.abs(slopes.T @ y).max())
    wanted = -force + slopes.T @ (y / w * (w - g))
    assert right == pytest.approx(wanted, rel=1e-9, abs=1e-9 * np.abs(wanted).max())
    curvature = np.stack([(time_slope(c + u) - time_slope(c - u)) / 2e-2 for u in 1e-2 * np.eye(n + 2)])
    matrix = curvature + slopes.T @ ((y / w)[:, None] * slopes)
    for m in range(3):
        wanted = np.diagonal(matrix, m)
        assert band[m, : n + 2 - m] == pytest.approx(wanted, rel=1e-6, abs=1e-9 * np.abs(matrix).max())


@pytest.mark.parametrize("feed", [20.0, 60.0, 1e4])
def test_every_limit_holds_and_one_binds(feed: float) -> None:
    given = wave(60, feed=feed, axes=3)
    ours = solve(given, None)
    acceleration, jerk = motion(given, ours.q, ours.way)
    worst = np.maximum(acceleration, jerk).max(axis=(0, 2))
    worst = np.maximum(worst, ours.q[1:-1].max(axis=1) / feed**2)
    assert worst.max() < 1.0 + 1e-3
    assert np.median(worst) > 0.97
    assert ours.time == pytest.approx(time_from(given, ours.q, ours.way), rel=1e-3)
    named = set(ours.limit[1:-1].tolist())
    assert named <= {Limit.NONE, Limit.FEED, Limit.ACCELERATION, Limit.JERK}
    assert (Limit.FEED in named) == (feed < 1e3)


def time_from(given: Intervals, q: np.ndarray, way: np.ndarray) -> float:
    """Return the time of constant jerks, and 3 h / v beside a rest."""
    inside = durations(given.h[1:-1], q[1:-1], way[1:-1]).sum()
    return float(inside + 3.0 * given.h[0] / np.sqrt(q[0, 2]) + 3.0 * given.h[-1] / np.sqrt(q[-1, 0]))


def state_at(given: Intervals, found: problem.Solution, at: int) -> tuple[float, float]:
    """Return q and q'/2 at the start of an interval."""
    here = slice(at, at + 1)
    return float(found.q[at, 0]), float(slopes(given.h[here], found.q[here], found.way[here])[0][0])


def test_a_window_in_motion_goes_on_as_the_plan_that_it_is_cut_from() -> None:
    whole = wave(60)
    first = solve(whole, None)
    at = 25
    rest = replace(whole, **{name: getattr(whole, name)[at:] for name in PER_INTERVAL})
    second = solve(rest, state_at(whole, first, at), first.q[at:, 1])
    assert second.converged
    assert state_at(rest, second, 0) == pytest.approx(state_at(whole, first, at), rel=1e-12)
    assert np.allclose(second.q[:, 1], first.q[at:, 1], rtol=0.02)


@pytest.mark.parametrize(("feed", "count"), [(20.0, 250), (60.0, 250), (1e4, 250), (1e4, 310)])
def test_what_does_not_feel_the_end_is_what_a_longer_row_has(feed: float, count: int) -> None:
    whole = wave(400, length=100.0, feed=feed)
    part = replace(whole, **{name: getattr(whole, name)[:count].copy() for name in PER_INTERVAL})
    part.kind[-1] = ENTER
    found, longer = solve(part, None), solve(whole, None)
    away = np.abs(found.q[:, 1] / np.maximum(longer.q[:count, 1], 1e-9) - 1.0)
    assert found.unfelt > 100
    assert np.all(away[1 : found.unfelt] < 2e-3)
    # Soon after, the motion does brake.
    assert away[min(found.unfelt + 60, count - 2)] > 0.01


@pytest.mark.parametrize("moving", [False, True])
def test_compiled_and_plain_agree(moving: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    given = wave(24, axes=3)
    state = None
    if moving:
        given.kind[0] = SPLINE
        state = (100.0, 20.0 / float(given.h[0]))
    compiled = solve(given, state)
    for name, kernel in plain(monkeypatch).items():
        if hasattr(problem, name):
            monkeypatch.setattr(problem, name, kernel)
    slow = solve(given, state)
    assert compiled.converged
    assert slow.converged
    assert slow.q == pytest.approx(compiled.q, rel=1e-9)
    assert slow.limit.tolist() == compiled.limit.tolist()
    assert slow.time == pytest.approx(compiled.time, rel=1e-12)
    assert slow.unfelt == compiled.unfelt


@pytest.mark.parametrize("feed", [20.0, 60.0, 1e4])
def test_rows_left_out_change_nothing(feed: float, monkeypatch: pytest.MonkeyPatch) -> None:
    given = wave(80, feed=feed, axes=3)
    counts: list[tuple[int, int]] = []
    thin = least_time_rows.thin

    def counted(rows: least_time_problem.Problem, reach: int, far: float) -> None:
        thin(rows, reach, far)
        state = np.asarray(rows.state)[: rows.count]
        counts.append((int((state > 0).sum()), int((state == AWAKE).sum())))

    monkeypatch.setattr(least_time_rows, "thin", counted)
    some = solve(given, None)
    monkeypatch.setattr(least_time_rows, "thin", lambda *_: None)
    whole = solve(given, None)
    assert len(counts) == 1
    assert counts[0][1] < 0.9 * counts[0][0]
    # What limits are lowered by between nodes, up to half of the slack, depends on the way to the optimum.
    assert some.time == pytest.approx(whole.time, rel=0.2 * problem.SLACK)
    assert np.mean(some.limit == whole.limit) > 0.95


def test_a_row_that_should_not_have_been_left_out_comes_back(monkeypatch: pytest.MonkeyPatch) -> None:
    given = wave(60)
    whole = solve(given, None)
    monkeypatch.setattr(problem, "FAR", 1e6)
    blind = solve(given, None)
    assert blind.converged
    acceleration, _ = motion(given, blind.q, blind.way)
    assert acceleration.max() < 1.0 + 1e-3
    assert blind.time == pytest.approx(whole.time, rel=0.2 * problem.SLACK)


def small(
    second: np.ndarray, third: np.ndarray, limit: float, x3_excess: float = 0.0
) -> least_time_problem.Problem:
    """Return intervals of length 1 of one axis that moves by its second and third derivative alone, without rows."""
    n = len(second)
    return least_time_problem.Problem(
        1, np.ones(n), np.zeros((n, 2)), np.zeros((n, 3, 1)), second[:, :, None].copy(),
        third[:, :, None].copy(), np.full((2, 1), limit), np.ones((n, 2, 1)), np.full((n, 1), x3_excess),
        np.zeros(n, np.int8),
    )  # fmt: skip


@pytest.mark.parametrize("free", [1, 2])
def test_a_profile_is_rounded_by_binomial_weights_and_not_raised_beyond_its_part(free: int) -> None:
    """Far from its ends: averages over three neighbours are binomial weights; a step of 10 is raised to twice 1 beside it."""
    rows = small(np.zeros((40, 3)), np.zeros((40, 3)), 1.0)
    c = np.asarray(rows.c)
    c[21] = 3.0
    rows.free = free
    least_time_rows.rounded(rows, 5, 100.0)
    weights = np.array([math.comb(10, k) for k in range(11)]) / 2.0**10
    assert c[16:27] == pytest.approx(1.0 + 2.0 * weights, rel=1e-15)
    assert np.all(c[:16] == 1.0)
    assert np.all(c[27:] == 1.0)
    c[:21], c[21:] = 1.0, 10.0
    least_time_rows.rounded(rows, 50, 2.0)
    assert c[20] == 2.0
    assert np.all(np.diff(c) >= 0.0)


def test_thinning_keeps_what_is_near_and_what_is_beside_a_rest() -> None:
    # One axis, three intervals: a bound and an acceleration each, of the profile all ones.
    used = np.array([0.2, 0.6, 0.1])
    rows = small(np.repeat(used[:, None], 3, axis=1), np.zeros((3, 3)), 1.0)
    np.asarray(rows.ends)[0, 0] = 0.0
    box, sway = np.full((3, 3), np.inf), np.full((3, 2), np.inf)
    box[:, 0] = 10.0
    least_time_rows.build(rows, box, np.zeros(3), np.zeros(3, np.int8), sway, np.zeros(3, np.int8))
    least_time_rows.thin(rows, 0, 0.5)
    kinds = np.asarray(rows.batches)[: rows.count, 2]
    state = np.asarray(rows.state)[: rows.count, :3]
    # The first interval leaves a rest; of the others, only the acceleration of the second comes near.
    assert kinds.tolist() == [0, 1, 2, 2]
    assert state.tolist() == [[2, 1, 1], [2, 2, 1], [2, 2, 2], [2, 2, 2]]


@pytest.mark.parametrize("at", [11, 42, 50])
def test_a_window_whose_start_binds_on_two_sides_goes_on(at: int) -> None:
    # There, jerk of x from above and jerk of y from below leave the second ordinate no room but for the slack.
    whole = wave(60, axes=3)
    first = solve(whole, None)
    rest = replace(whole, **{name: getattr(whole, name)[at:].copy() for name in PER_INTERVAL})
    rest.factor[:2, 1] *= 1.0 - problem.SLACK
    second = solve(rest, state_at(whole, first, at), first.q[at:, 1])
    assert second.converged
    acceleration, jerk = motion(rest, second.q, second.way)
    assert acceleration.max() < 1.0 + 1e-3
    assert jerk.max() < 1.0 + 3.0 * problem.SLACK


def test_a_limit_that_steps_up_at_a_node_is_held_on_both_sides() -> None:
    """On a line, intervals that a corner leaves 0.23 of the acceleration hold it up to the node where they end."""
    count, first, stop = 120, 40, 80
    given = wave(count, feed=400.0)
    given.x1[:], given.x2[:], given.x3[:] = [1.0, 0.0], 0.0, 0.0
    given.factor[first:stop, 0] = 0.23
    found = solve(given, None)
    assert found.converged
    # On a line q' / 2 is the acceleration.
    inner = slice(1, -1)
    slope = np.abs(np.stack(slopes(given.h[inner], found.q[inner], found.way[inner]), 1))
    assert slope[first - 1 : stop - 1].max() <= 0.23 * 1000.0 * 1.0006
    assert slope.max() > 0.9 * 1000.0


@pytest.mark.parametrize("top", [0.1, 0.3, 0.5, 0.7, 0.9])
def test_what_passes_a_limit_between_the_ends_is_found_wherever_it_is(top: float) -> None:
    """At constant q the acceleration x'' q is the parabola 1 - (x - top)², whose largest value is 1."""
    x = np.array([0.0, 0.5, 1.0])
    second = (1.0 - (x - top) ** 2)[None, :]
    rows = small(second, np.zeros((1, 3)), 0.95)
    least_time_matrix.survey(rows)
    found = least_time_between.tighten(rows, 5e-4, 0, True)
    assert found == pytest.approx(1.0 / 0.95, rel=1e-12)
    # The ends, where the rows hold the limit, are left so much less of it, but for 0.4 of the slack.
    assert rows.share[0, 0, 0] == pytest.approx(max(second[0, 0], second[0, 2]) * 1.0002, rel=1e-12)


def test_what_three_values_of_the_third_derivative_hide_adds_to_the_jerk_at_the_speed_there_is() -> None:
    """At v² = 4 throughout, x''' = 0.05 at the ends and 0.1 in the middle is a jerk of 0.4 and 0.8; 0.01 more, of 0.08."""
    third = np.array([0.05, 0.1, 0.05])[None, :]

    def largest(x3_excess: float, limit: float) -> float:
        rows = small(np.zeros((1, 3)), third, limit, x3_excess)
        rows.c[:] = 4.0
        least_time_matrix.survey(rows)
        return least_time_between.tighten(rows, 5e-4, 0, True)

    assert largest(0.0, 1.0) == pytest.approx(0.8, rel=1e-12)
    # At the quarter points 0.7 + 0.08, and the parabola through the largest three values has its top in the middle still.
    assert largest(0.01, 1.0) == pytest.approx(0.8, rel=1e-12)
    # 0.7 + 0.24 there, and 0.8 between: the top of the parabola through the end, the quarter point and the middle.
    bend, slope = 2.0 * 0.94 - 0.4 - 0.8, 0.8 - 0.4
    assert largest(0.03, 1.0) == pytest.approx(0.94 + slope**2 / (8.0 * bend), rel=1e-12)
    # Beside a cusp it is no more than 0.3 of the limit.
    bend = 2.0 * 1.0 - 0.4 - 0.8
    assert largest(10.0, 1.0) == pytest.approx(1.0 + slope**2 / (8.0 * bend), rel=1e-12)
