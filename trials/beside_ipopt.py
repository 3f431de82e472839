"""G64 on random paths beside the least time that IPOPT finds within the same tolerance.

    pip install "cncgen[bench]"
    python -m trials.beside_ipopt 40 --seed 2000                # two and three axes
    python -m trials.beside_ipopt 40 --seed 2000 --axes XYZAC   # lines over these, a degree as a millimetre

Direct multiple shooting, which shares nothing with the planner: each row of the program is a phase of free duration, in
steps of some 1 ms of constant jerk. Positions, velocities and accelerations of the axes go on where phases meet. Within a
phase the motion is within P of its row, and where phases meet within P of the joint, so the tolerance holds both ways and
in order. The rows of a NURBS are chords with a sag of a hundredth of P. The planned motion is the first guess. What IPOPT
finds is a local optimum, the true one is this or shorter. It holds the tolerance at its steps alone, and P itself, where a
plan leaves room for the chords of setpoints. A search ends after four minutes.
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

import cncgen
from cncgen.machine.reading import machine_from_toml
from cncgen.units import ORDER_NAMES, file_unit, is_rotary, to_file
from trials.seeds import first_for_tuning

Floats = NDArray[np.float64]
Point = tuple[float, ...]

#: Velocity, acceleration and jerk of each axis, in mm or degrees, and s.
LIMITS = {
    "X": (250.0, 2500.0, 5e4), "Y": (250.0, 2500.0, 5e4), "Z": (150.0, 1200.0, 3e4),
    "A": (120.0, 1500.0, 3e4), "B": (120.0, 1500.0, 3e4), "C": (200.0, 2000.0, 4e4),
}  # fmt: skip
PERIOD_S = 1e-3
#: Steps of a row at least, and of a chord of a NURBS.
_LEAST_STEPS, _STEPS_OF_A_CHORD = 12, 2
#: A chord of a NURBS leaves it by this part of P.
_SAG = 0.01
#: Parts of a period between which a motion is looked at for the place nearest to a joint.
_PARTS = 10
#: How searches end that found a motion: others do not count.
_FOUND = ("Solve_Succeeded", "Solved_To_Acceptable_Level")
#: A ratio that the issue of the method allows at most.
ALLOWED = 1.015


@dataclass(frozen=True)
class Row:
    """A line, or an arc counterclockwise (`turn` 1) or clockwise (-1) about `centre` in the plane of X and Y."""

    begin: Point
    end: Point
    centre: Point = ()
    turn: int = 0


@dataclass(frozen=True)
class Curve:
    """A NURBS of `points`, shape (n, axes), with `weights`, shape (n,), over `knots`, shape (n + degree + 1,)."""

    degree: int
    knots: Floats
    points: Floats
    weights: Floats

    def chords(self, sag: float) -> list[Row]:
        """Return the curve as lines that leave it by about `sag` at most."""
        curve = BSpline(self.knots, np.c_[self.points * self.weights[:, None], self.weights], self.degree)
        fine = curve(np.linspace(0.0, self.knots[-1], 20_001))
        at = fine[:, :-1] / fine[:, -1:]
        steps = np.linalg.norm(np.diff(at, axis=0), axis=1)
        bends = np.linalg.norm(np.diff(np.diff(at, axis=0) / steps[:, None], axis=0), axis=1)
        # A chord of the length l has a sag of l²/8 times the curvature: the integral of the root of curvature counts chords.
        curvature = np.r_[bends[0], np.maximum(bends[1:], bends[:-1]), bends[-1]] / steps
        counted = np.r_[0.0, np.cumsum(steps * np.sqrt(curvature / (8.0 * sag) + 1.0))]
        whole = np.searchsorted(counted, np.linspace(0.0, counted[-1], math.ceil(counted[-1]) + 1)[1:-1])
        return _lines(at[np.r_[0, whole, -1]])

    def words(self, letters: str) -> list[str]:
        """Return the curve as blocks of G6.2 over axes: a knot and a point each, then the other knots."""
        points = zip(self.knots, self.points.tolist(), self.weights, strict=False)
        lines = [f"K{knot:.9f} {_words(point, letters)} R{weight:.9f}" for knot, point, weight in points]
        lines[0] = f"G6.2 P{self.degree + 1} {lines[0]}"
        return [*lines, *(f"K{knot:.9f}" for knot in self.knots[len(self.points) :])]


@dataclass(frozen=True)
class Case:
    """A path over the axes `letters`, its tolerance in mm, and its feed in mm/min, along X Y Z."""

    letters: str
    rows: list[Row]
    tolerance: float
    feed: float
    curve: Curve | None = None

    @property
    def axes(self) -> int:
        """Return how many axes move."""
        return len(self.letters)

    def program(self) -> str:
        """Return the path as G-code."""
        lines = [
            f"(START, {_words(self.rows[0].begin, self.letters)})",
            f"G21 G90 G94 G17 G64 P{self.tolerance} F{self.feed}",
        ]
        if self.curve is not None:
            return "\n".join([*lines, *self.curve.words(self.letters), "M2", ""])
        for row in self.rows:
            code = {0: "G1", 1: "G3", -1: "G2"}[row.turn]
            middle = [
                f"{letter}{c - b:.9f}" for letter, c, b in zip("IJ", row.centre, row.begin, strict=False)
            ]
            lines.append(" ".join([code, _words(row.end, self.letters), *middle]))
        return "\n".join([*lines, "M2", ""])

    def machine(self) -> str:
        """Return a machine with these axes as TOML."""
        text = (
            f'name = "ipopt"\nperiod_s = {PERIOD_S}\nchord_tolerance_mm = 0.001\npath_tolerance_mm = 0.01\n'
        )
        for letter in self.letters:
            text += f"[axes.{letter.lower()}]\n"
            for name, unit, limit in zip(ORDER_NAMES, ("s", "s2", "s3"), LIMITS[letter], strict=True):
                text += f"max_{name}_{file_unit(letter)}_{unit} = {limit}\n"
        return text


def _words(point: Sequence[float], letters: str) -> str:
    return " ".join(f"{letter}{value:.9f}" for letter, value in zip(letters, point, strict=True))


# Paths.


def _lines(points: Any) -> list[Row]:
    at = [tuple(map(float, point)) for point in points]
    return [Row(a, b) for a, b in itertools.pairwise(at)]


def _rotation(rng: np.random.Generator, axes: int) -> Floats:
    """Return a random rotation, shape (axes, axes)."""
    q, r = np.linalg.qr(rng.normal(size=(axes, axes)))
    return np.asarray(q * np.sign(np.diag(r)))


def _walk(rng: np.random.Generator, axes: int, lengths: Floats, bend: float) -> list[Row]:
    """Return lines of these lengths, each leaning from the one before by a random vector of about the length `bend`."""
    heading, points = _rotation(rng, axes)[0], [np.zeros(axes)]
    for length in lengths:
        points.append(points[-1] + length * heading)
        heading = heading + bend * rng.normal(size=axes)
        heading = heading / np.linalg.norm(heading)
    return _lines(points)


def _chain(rng: np.random.Generator, axes: int, tolerance: float) -> list[Row]:
    return _walk(rng, axes, np.exp(rng.uniform(math.log(0.5), math.log(12.0), rng.integers(3, 9))), 1.5)


def _near_corners(rng: np.random.Generator, axes: int, tolerance: float) -> list[Row]:
    between = tolerance * np.exp(rng.uniform(math.log(3.0), math.log(80.0), 2))
    return _walk(rng, axes, np.array([7.0, *between, 7.0]), 0.9)


def _corner(rng: np.random.Generator, axes: int, tolerance: float) -> list[Row]:
    angle, turned = rng.uniform(0.1, 2.8), _rotation(rng, axes)[:2]
    return _lines(
        np.array([(0, 0), (10, 0), (10 + 10 * math.cos(angle), 10 * math.sin(angle))]) @ turned,
    )


def _zigzag(rng: np.random.Generator, axes: int, tolerance: float) -> list[Row]:
    along, across = rng.uniform(0.5, 4.0, 2)
    points = [(along * k, across * (k % 2)) for k in range(rng.integers(4, 9))]
    return _lines(np.array(points) @ _rotation(rng, axes)[:2])


def _stairs(rng: np.random.Generator, axes: int, tolerance: float) -> list[Row]:
    steps = np.diag(rng.uniform(0.3, 3.0, axes))
    return _lines(np.cumsum([np.zeros(axes), *(steps[k % axes] for k in range(rng.integers(4, 10)))], axis=0))


def _short_rows(rng: np.random.Generator, axes: int, tolerance: float) -> list[Row]:
    s = np.linspace(0.0, 1.0, rng.integers(12, 28) + 1)
    waves = [rng.uniform(0.5, 4.0) * np.sin(2.0 * np.pi * rng.uniform(0.4, 2.2) * s) for _ in range(axes - 1)]
    return _lines(np.stack([rng.uniform(8.0, 28.0) * s, *waves], axis=1) @ _rotation(rng, axes))


def _u_turn(rng: np.random.Generator, axes: int, tolerance: float) -> list[Row]:
    """Return line, half circle, line; in three axes with a plunge before and a way out behind."""
    r, length, low = rng.uniform(1.0, 10.0), rng.uniform(3.0, 20.0), (0.0,) * (axes - 2)
    ahead, back = (length, 0.0, *low), (length, 2.0 * r, *low)
    rows = [
        Row((0.0, 0.0, *low), ahead),
        Row(ahead, back, (length, r), 1),
        Row(back, (0.0, 2.0 * r, *low)),
    ]
    if low:
        above = rng.uniform(0.5, 4.0)
        rows = [Row((0.0, 0.0, above), rows[0].begin), *rows, Row(rows[-1].end, (0.0, 2.0 * r, above))]
    return rows


def _bent_arc(rng: np.random.Generator, axes: int, tolerance: float) -> list[Row]:
    """Return a line, a tangential arc, and a line at an angle to it; in three axes one that rises."""
    r, length, swept = rng.uniform(2.0, 8.0), rng.uniform(4.0, 15.0), rng.uniform(0.4, 2.5)
    low = (0.0,) * (axes - 2)
    joint, end = (length, 0.0, *low), (length + r * math.sin(swept), r - r * math.cos(swept), *low)
    heading, reach = swept + rng.uniform(-1.5, 1.5), rng.uniform(4.0, 15.0)
    last = (
        end[0] + reach * math.cos(heading),
        end[1] + reach * math.sin(heading),
        *(rng.uniform(-4, 4) for _ in low),
    )
    return [Row((0.0, 0.0, *low), joint), Row(joint, end, (length, r), 1), Row(end, last)]


def _nurbs(rng: np.random.Generator, axes: int, tolerance: float) -> Curve:
    """Return a NURBS of degree 2 or 3: its knots simple or double, some of its weights far from 1."""
    degree, count = int(rng.integers(2, 4)), int(rng.integers(6, 12))
    inner: list[float] = []
    while len(inner) < count - degree - 1:
        inner += [len(inner) + 1.0] * int(rng.integers(1, max(degree, 2)))
    inner = inner[: count - degree - 1]
    knots = np.r_[[0.0] * (degree + 1), inner, [inner[-1] + 1.0] * (degree + 1)]
    heading = 0.7 * rng.normal(size=(count, axes)) + _rotation(rng, axes)[0]
    points = np.cumsum(
        heading / np.linalg.norm(heading, axis=1)[:, None] * rng.uniform(0.5, 8.0, (count, 1)), axis=0
    )
    weights = np.where(rng.random(count) < 0.3, np.exp(rng.uniform(-1.2, 1.2, count)), 1.0)
    return Curve(degree, knots, points, np.r_[1.0, weights[1:-1], 1.0])


#: The kinds of paths: lines over any axes, and what lies in the plane of X and Y, or is a curve.
LINES: tuple[Callable[[np.random.Generator, int, float], list[Row]], ...] = (
    _chain, _near_corners, _corner, _zigzag, _stairs, _short_rows,
)  # fmt: skip
KINDS: tuple[Callable[[np.random.Generator, int, float], list[Row] | Curve], ...] = (
    *LINES, _u_turn, _bent_arc, _nurbs,
)  # fmt: skip


def cases(count: int, seed: int, letters: str | None = None) -> Iterator[tuple[str, Case]]:
    """Draw cases with their kinds: each kind in turn, over two axes and three; or lines over the axes that are named."""
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        tolerance = float(np.exp(rng.uniform(math.log(0.005), math.log(0.2))))
        kinds = KINDS if letters is None else LINES
        axes = letters or "XYZ"[: 2 + k // len(KINDS) % 2]
        kind = kinds[k % len(kinds)]
        drawn = kind(rng, len(axes), tolerance)
        curve = drawn if isinstance(drawn, Curve) else None
        rows = drawn.chords(_SAG * tolerance) if isinstance(drawn, Curve) else drawn
        feed = float(rng.choice([2000, 4000, 6000, 9000]))
        yield kind.__name__.strip("_"), Case(axes, rows, tolerance, feed, curve)


# The optimum.


class _Problem:
    """Unknowns, constraints and their bounds, as they are added."""

    def __init__(self, casadi: Any) -> None:
        self.casadi = casadi
        self.unknowns: list[Any] = []
        self.first: list[Floats] = []
        self.low: list[Floats] = []
        self.high: list[Floats] = []
        self.rows: list[Any] = []
        self.least: list[Floats] = []
        self.most: list[Floats] = []

    def unknown(self, first: Any, low: float, high: float) -> Any:
        start = np.atleast_1d(np.asarray(first, float))
        symbol = self.casadi.MX.sym(f"u{len(self.unknowns)}", start.size)
        self.unknowns.append(symbol)
        self.first.append(np.clip(start, low, high))
        self.low.append(np.full(start.size, low))
        self.high.append(np.full(start.size, high))
        return symbol

    def hold(self, row: Any, least: float, most: float) -> None:
        self.rows.append(self.casadi.reshape(row, -1, 1))
        self.least.append(np.full(row.numel(), least))
        self.most.append(np.full(row.numel(), most))

    def least_of(self, cost: Any) -> tuple[float, str]:
        """Return the least cost, and how the search ended."""
        ca = self.casadi
        quiet = {"ipopt.print_level": 0, "print_time": 0, "ipopt.max_cpu_time": 240.0, "ipopt.sb": "yes"}
        tight = {
            "ipopt.max_iter": 1500,
            "ipopt.tol": 1e-7,
            "ipopt.constr_viol_tol": 1e-8,
            "ipopt.mu_strategy": "adaptive",
        }
        what = {"x": ca.vertcat(*self.unknowns), "f": cost, "g": ca.vertcat(*self.rows)}
        solver = ca.nlpsol("least", "ipopt", what, quiet | tight)
        found = solver(
            x0=np.concatenate(self.first), lbx=np.concatenate(self.low), ubx=np.concatenate(self.high),
            lbg=np.concatenate(self.least), ubg=np.concatenate(self.most),
        )  # fmt: skip
        return float(found["f"]), str(solver.stats()["return_status"])


def optimum(case: Case, guess: Floats) -> tuple[float, str]:
    """Return the least time that IPOPT finds from a motion, shape (n, axes), at setpoints; and how it ended."""
    import casadi

    v, a, j = np.array([LIMITS[letter] for letter in case.letters]).T
    t = PERIOD_S * np.arange(len(guess))
    rates = [guess]
    for limit in (v, a, j):
        before = rates[-1] * (1.0 if len(rates) == 1 else (v, a)[len(rates) - 2])
        rates.append(np.gradient(before, PERIOD_S, axis=0) / limit)
    problem, total, before_states = _Problem(casadi), 0.0, None
    least = _LEAST_STEPS if case.curve is None else _STEPS_OF_A_CHORD
    for row, (first, last) in zip(case.rows, _cuts(case, guess), strict=True):
        steps = max(least, math.ceil((last - first) / PERIOD_S - 1e-6))
        h = problem.unknown((last - first) / steps, 1e-7, 0.05)
        total = total + h * steps
        at = np.linspace(first, last, steps + 1)
        states = []
        for k in range(case.axes):
            p = problem.unknown(np.interp(at, t, guess[:, k]), -1e4, 1e4)
            w, b = (problem.unknown(np.interp(at, t, rates[n][:, k]), -1.0, 1.0) for n in (1, 2))
            u = problem.unknown(np.interp((at[1:] + at[:-1]) / 2.0, t, rates[3][:, k]), -1.0, 1.0)
            problem.hold(
                p[1:] - p[:-1] - h * (v[k] * w[:-1] + h * (a[k] / 2 * b[:-1] + h * j[k] / 6 * u)), 0, 0
            )
            problem.hold((w[1:] - w[:-1]) * v[k] / 10 - h * (a[k] * b[:-1] + h * j[k] / 2 * u) / 10, 0, 0)
            problem.hold((b[1:] - b[:-1]) * a[k] / 100 - h * j[k] * u / 100, 0, 0)
            states.append((p, w, b))
        along = _along(case.letters, row)
        problem.hold(sum((states[k][1] * v[k]) ** 2 for k in along) / (case.feed / 60.0) ** 2, -np.inf, 1)
        _keep_near(problem, row, [state[0] for state in states], case.tolerance)
        for k, state in enumerate(states):
            for order in range(3):
                known = row.begin[k] if order == 0 else 0.0
                problem.hold(
                    state[order][0] - (before_states[k][order][-1] if before_states else known), 0, 0
                )
        if before_states:
            away = sum((states[k][0][0] - row.begin[k]) ** 2 for k in range(case.axes))
            problem.hold(away / case.tolerance**2, -np.inf, 1)
        before_states = states
    for k, state in enumerate(before_states or ()):
        for order in range(3):
            problem.hold(state[order][-1] - (case.rows[-1].end[k] if order == 0 else 0.0), 0, 0)
    return problem.least_of(total)


def _along(letters: str, row: Row) -> list[int]:
    """Return the axes that the feed of a row is along: X Y Z where they move, else those that turn."""
    moved = [k for k in range(len(letters)) if row.turn or row.end[k] != row.begin[k]]
    linear = any(not is_rotary(letters[k]) for k in moved)
    return [k for k, letter in enumerate(letters) if is_rotary(letter) is not linear]


def _cuts(case: Case, guess: Floats) -> list[tuple[float, float]]:
    """Return when each row begins and ends, s: a joint is where the motion comes nearest to it."""
    t = PERIOD_S * np.arange(len(guess))
    fine = np.arange(0.0, t[-1], PERIOD_S / _PARTS)
    motion = np.stack([np.interp(fine, t, axis) for axis in guess.T], axis=1)
    cuts, k = [0.0], 0
    for row in case.rows[:-1]:
        away = np.linalg.norm(motion[k:] - np.array(row.end), axis=1)
        n = int(np.flatnonzero(away < max(3.0 * case.tolerance, 2.0 * away.min() + 1e-6))[0])
        while n + 1 < len(away) and away[n + 1] < away[n]:
            n += 1
        k = min(k + max(n, 1), len(fine) - 1)
        cuts.append(float(fine[k]))
    return list(itertools.pairwise([*cuts, float(t[-1])]))


def _keep_near(problem: _Problem, row: Row, places: list[Any], tolerance: float) -> None:
    """Hold a motion within the tolerance of a row; of a line also between its ends."""
    away = [p - b for p, b in zip(places, row.begin, strict=True)]
    if row.turn:
        radius = math.dist(row.begin[:2], row.centre)
        x, y, *rest = (p - c for p, c in zip(places, [*row.centre, *row.begin[2:]], strict=True))
        aside = (problem.casadi.sqrt(x**2 + y**2) - radius) ** 2 + sum(z**2 for z in rest)
        problem.hold(aside / tolerance**2, -np.inf, 1)
        return
    length = math.dist(row.begin, row.end)
    unit = [(e - b) / length for b, e in zip(row.begin, row.end, strict=True)]
    along = sum(u * d for u, d in zip(unit, away, strict=True))
    aside = sum((d - u * along) ** 2 for u, d in zip(unit, away, strict=True))
    problem.hold(aside / tolerance**2, -np.inf, 1)
    problem.hold(along, -tolerance, length + tolerance)


def ratio(case: Case) -> tuple[float, str]:
    """Return the time of our plan over the least time that IPOPT finds, and how it ended."""
    machine = machine_from_toml(case.machine().encode(), "ipopt.toml")
    setpoints, summary = cncgen.plan_with_summary(cncgen.read_text(case.program()), machine)
    guess = np.concatenate([chunk.position for chunk in setpoints.chunks])
    guess = guess * [to_file(letter) for letter in case.letters]
    least, ended = optimum(case, guess)
    return summary.as_json()["motion_time_s"] / least, ended


def main() -> None:
    """Print the ratio of each case, then their mean and the largest."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("count", type=int, nargs="?", default=32)
    parser.add_argument("--seed", type=int, default=first_for_tuning("beside_ipopt"))
    parser.add_argument("--axes", help="letters, X first: lines over these alone")
    given = parser.parse_args()
    ratios = []
    for k, (kind, case) in enumerate(cases(given.count, given.seed, given.axes)):
        found, ended = ratio(case)
        if ended in _FOUND:
            ratios.append(found)
        print(
            f"{given.seed}:{k} {kind}, {case.letters}, P{case.tolerance:.4g} F{case.feed:g}: {found:.4f} ({ended})",
            flush=True,
        )
    above = sum(found > ALLOWED for found in ratios)
    print(
        f"{len(ratios)} of {given.count} cases: mean {np.mean(ratios):.4f}, largest {max(ratios):.4f}, {above} above {ALLOWED}"
    )


if __name__ == "__main__":
    main()
