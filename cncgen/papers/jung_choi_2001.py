"""Paper 002 (Jung and Choi): interpolators of the second stage, and the stateline at a corner and on random paths."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.papers.reproduction import Row, Table
from cncgen.servo.controllers.stateline import Rule, StatelineAxis, interpolate, run_stateline

Floats = NDArray[np.float64]

#: Master and control period, s.
MASTER, CONTROL = 0.016, 0.0005
PARTS = round(MASTER / CONTROL)
AXES = (StatelineAxis(60.0, 0.004), StatelineAxis(60.0, 0.004))


def circle_figures(kind: int) -> tuple[float, float]:
    """Return radial error (µm) and velocity jump at the master's points (mm/s): R = 20 mm, 100 mm/s."""
    radius, speed = 20.0, 100.0
    angle = np.arange(200) * speed * MASTER / radius
    master = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    off = np.hypot(*interpolate(master, PARTS, kind)[10 * PARTS : -10 * PARTS].T) - radius
    rates = np.diff(interpolate(master, PARTS, kind), axis=0) / CONTROL
    knots = np.arange(10, 190) * PARTS
    after, before = (
        1.5 * rates[knots] - 0.5 * rates[knots + 1],
        1.5 * rates[knots - 1] - 0.5 * rates[knots - 2],
    )
    return float(off[np.abs(off).argmax()]) * 1e3, float(np.hypot(*(after - before).T).max())


def corner(speed: float = 50.0, length: float = 25.0) -> Floats:
    """Return the master's points along a right angle, mm."""
    s = np.arange(0.0, length + 1e-9, speed * MASTER)
    return np.concatenate([np.column_stack([s, 0 * s]), np.column_stack([0 * s[1:] + s[-1], s[1:]])])


def corner_figures(rule: Rule, kind: int = 2, bound: float = 0.05) -> tuple[float, float]:
    """Return how near the axes come to the corner (µm) and how long they take (s)."""
    master = corner()
    run = run_stateline(interpolate(master, PARTS, kind), AXES, rule, bound)
    apex = np.array([master[:, 0].max(), 0.0])
    return float(np.hypot(*(run.position - apex).T).min()) * 1e3, run.time_s


def deadlocks(count: int = 1000, seed: int = 1) -> int:
    """Return how many of that many random paths, gains, rules and bounds do not end, or only by a forced step."""
    rng = np.random.default_rng(seed)
    stuck = 0
    for _ in range(count):
        master = np.cumsum(rng.normal(size=(rng.integers(2, 12), 2)) * rng.uniform(0.05, 2.0), axis=0)
        axes = [StatelineAxis(min(rng.uniform(5, 200), 0.8 / lag), lag) for lag in rng.uniform(5e-4, 0.02, 2)]
        reference = interpolate(master, PARTS, int(rng.integers(2, 5)))
        run = run_stateline(reference, axes, Rule(int(rng.integers(1, 4))), 10.0 ** rng.uniform(-3, 0))
        stuck += run.place[-1] != len(reference) - 1 or run.forced > 0
    return stuck


def tables(programs: str | None = None) -> list[Table]:
    """Return the interpolators on the circle and the stateline at the corner."""
    expected = {2: (-16.0, 7.996), 3: (-0.0192, 0.0128), 4: (-0.0256, 0.320)}
    rows = []
    for kind, (radial, jump) in expected.items():
        off, step = circle_figures(kind)
        rows.append(Row(f"eq. {kind}: radial error", off, radial, "µm", within=0.005))
        rows.append(Row(f"eq. {kind}: velocity jump", step, jump, "mm/s", within=0.005))
    free, time = corner_figures(Rule.NONE)
    held = [Row("90° corner, no stateline: miss", free, unit="µm")]
    for rule, name in ((Rule.ERROR, "eq. 7"), (Rule.RULE_2, "Rule 2"), (Rule.JERK, "jerk rule")):
        miss, longer = corner_figures(rule)
        held.append(Row(f"90° corner, {name}: miss is smaller by", free / miss, unit="×", at_least=8.0))
        held.append(Row(f"90° corner, {name}: time", 100 * (longer / time - 1), unit="% more", at_most=5.0))
    held.append(Row("deadlocks in 1,000 random runs", deadlocks(), unit="", at_most=0.0))
    return [
        Table(
            "Paper 002, interpolators (2) to (4) on a circle of 20 mm at 100 mm/s",
            tuple(rows),
            _INTERPOLATION,
        ),
        Table("Paper 002, stateline", tuple(held), _STATELINE),
    ]


_INTERPOLATION = (
    "the paper shows figures without numbers; the printed column is the closed form: a²R/8 and a V, a³V/4, a²V/2 with a = VΔt/R",
)
_STATELINE = (
    "P loops with Kv = 60/s and a lag of 4 ms, 50 mm/s, δ = 50 µm; the paper's machine is not in its text",
    "an axis pulls the line only while its error exceeds δ, our progress rule (docs/controllers.md); with it the jerk rule adds nothing",
)
