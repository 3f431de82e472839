"""Paper 002 (Jung and Choi): interpolators of the second stage, and the stateline at a corner and on random paths."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cncgen.papers.printed import ARITHMETIC, Basis, Row, RowKind, Table, absent, drawing, given
from cncgen.report.drawing import (
    BLUE,
    GREEN,
    ORANGE,
    RED,
    legend,
    line,
    new_figure,
    plane,
    ticks,
)
from cncgen.servo.controllers.stateline import Rule, StatelineAxis, run_stateline
from cncgen.setpoints.two_stage import second_stage

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cncgen.report.drawing import Figures

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
    off = np.hypot(*second_stage(master, PARTS, kind)[10 * PARTS : -10 * PARTS].T) - radius
    rates = np.diff(second_stage(master, PARTS, kind), axis=0) / CONTROL
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
    run = run_stateline(second_stage(master, PARTS, kind), AXES, rule, bound)
    apex = np.array([master[:, 0].max(), 0.0])
    return float(np.hypot(*(run.position - apex).T).min()) * 1e3, run.time_s


def deadlocks(count: int = 1000, seed: int = 1) -> int:
    """Return how many of that many random paths, gains, rules and bounds do not end, or only by a forced step."""
    rng = np.random.default_rng(seed)
    stuck = 0
    for _ in range(count):
        master = np.cumsum(rng.normal(size=(rng.integers(2, 12), 2)) * rng.uniform(0.05, 2.0), axis=0)
        axes = [StatelineAxis(min(rng.uniform(5, 200), 0.8 / lag), lag) for lag in rng.uniform(5e-4, 0.02, 2)]
        reference = second_stage(master, PARTS, int(rng.integers(2, 5)))
        run = run_stateline(reference, axes, Rule(int(rng.integers(1, 4))), 10.0 ** rng.uniform(-3, 0))
        stuck += run.place[-1] != len(reference) - 1 or run.forced > 0
    return stuck


def tables(programs: str | None = None) -> list[Table]:
    """Return given values, claims of the abstract, the figures, and our checks of interpolators and stateline."""
    return [_given(), _claims(), _figures(), _circle(), _progress()]


def _given() -> Table:
    rows = (
        given("period of the master", "16ms", 1e3 * MASTER, "ms"),
        given("period of the second stage", "0.5ms", 1e3 * CONTROL, "ms"),
        Row("rate of the master", 1.0 / MASTER, "63Hz", "Hz", within=ARITHMETIC, basis=Basis.PRINTED),
        Row(
            "rate of the second stage", 1.0 / CONTROL, "2,000Hz", "Hz", within=ARITHMETIC, basis=Basis.PRINTED
        ),
        Row("steps of the second stage in one of the master", PARTS, "32", within=0.0, basis=Basis.PRINTED),
    )
    return Table("Paper 002, section 2.3: the two stages", rows)


def _claims() -> Table:
    """Claims of the abstract."""
    without, with_jerk = (corner_figures(rule)[0] for rule in (Rule.RULE_2, Rule.JERK))
    others = [
        (f"δ {1e3 * bound:g} µm", corner_figures(Rule.RULE_2, bound=bound)[0] / corner_figures(Rule.JERK, bound=bound)[0])
        for bound in (0.01, 0.2)
    ]  # fmt: skip
    off = {kind: circle_figures(kind)[1] for kind in (2, 3, 4)}
    rows = (
        Row("Figs 3 and 4: miss of a corner under Rule 2 over that with the jerk term", without / with_jerk,
            "a slight improvement was achieved by applying jerk", "×", at_least=1.005, sensitivity=tuple(others),
            reason="the rules as printed can hold for ever; under the rule that keeps them from it the jerk term changes nothing"),
        Row("Figs 8 to 10: velocity jump of eq. 3 over that of eq. 2, circle", off[3] / off[2],
            "spline interpolation yields stable result", at_most=1.0, sensitivity=(("eq. 4 over eq. 2", off[4] / off[2]),)),
    )  # fmt: skip
    return Table("Paper 002, abstract", rows, _STATELINE)


def _figures() -> Table:
    """Figs 1 to 10, which have axes without numbers in our copy."""
    rows = [drawing("Fig. 1: architecture"), drawing("Fig. 2: block diagram")]
    shown = (
        "Fig. 3 (a): corner under Rule 2",
        "Fig. 3 (b): corner with the jerk term",
        "Fig. 4 (a): axis error under Rule 2",
        "Fig. 4 (b): axis error with the jerk term",
        *(f"Fig. {n}: corner under eq. {k}" for n, k in ((5, 2), (6, 3), (7, 4))),
        *(f"Fig. {n}: circle under eq. {k}" for n, k in ((8, 2), (9, 3), (10, 4))),
    )
    reason = (
        "speed, gains, lag, δ and the scale of the plot are not in our copy, which has lost its Korean text"
    )
    return Table(
        "Paper 002, figures",
        (*rows, *(absent(what, "", reason) for what in shown)),
        (
            "`--plots` draws each with our loops; `cncgen compare --interpolators stateline` takes your program",
        ),
    )


def _circle() -> Table:
    """Eqs 2 to 4 on a circle, against their closed forms."""
    expected = {2: (-16.0, 7.996), 3: (-0.0192, 0.0128), 4: (-0.0256, 0.320)}
    rows = []
    for kind, values in expected.items():
        for what, ours, unit, value in zip(
            ("radial error", "velocity jump"), circle_figures(kind), ("µm", "mm/s"), values, strict=True
        ):
            rows.append(
                Row(f"eq. {kind}: {what}", ours, unit=unit, within=0.005, kind=RowKind.OURS, expected=value)
            )
    title = "Paper 002, eqs 2 to 4 on a circle of 20 mm at 100 mm/s (not in the paper)"
    return Table(title, tuple(rows), _CLOSED)


def _progress() -> Table:
    """The stateline at a corner, and its progress on random paths."""
    free, time = corner_figures(Rule.NONE)
    held = []
    for rule, name in ((Rule.ERROR, "eq. 7"), (Rule.RULE_2, "Rule 2"), (Rule.JERK, "jerk rule")):
        miss, longer = corner_figures(rule)
        held.append(
            Row(
                f"90° corner, {name}: miss is smaller by",
                free / miss,
                unit="×",
                at_least=8.0,
                kind=RowKind.OURS,
            )
        )
        share = 100.0 * (longer / time - 1.0)
        held.append(Row(f"90° corner, {name}: time", share, unit="% more", at_most=5.0, kind=RowKind.OURS))
    held.append(Row("deadlocks in 1,000 random runs", deadlocks(), at_most=0.0, kind=RowKind.OURS))
    return Table("Paper 002, stateline at a corner (not in the paper)", tuple(held), _STATELINE)


_CLOSED = (
    "in brackets the closed forms: radial error a²R/8 of eq. 2; velocity jumps a V, a³V/4 and a²V/2 with a = VΔt/R",
)
_STATELINE = (
    "P loops with Kv = 60/s and a lag of 4 ms, 50 mm/s, δ = 50 µm; the paper's machine is not in its text",
    "an axis pulls the line only while its error exceeds δ, our progress rule (docs/controllers.md)",
)


def figures(programs: str | None = None) -> Figures:
    """Figs 3 to 10: a sharp corner under the rules, and the interpolators at a corner and on a circle."""
    yield "fig3_corner", _stateline_corner()
    yield "fig4_corner_errors", _stateline_errors()
    yield "fig5_to_7_interpolators", _interpolators_at_the_corner()
    radius, angle = 20.0, np.arange(40) * 0.08
    circle = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    figure, grid = new_figure(
        "Paper 002, Figs 8 to 10: radial error on a circle of 20 mm at 100 mm/s", 3, height=1.9
    )
    for part, kind in zip(grid[:, 0], (2, 3, 4), strict=True):
        rows = second_stage(circle, PARTS, kind)[320 : 320 + 10 * PARTS]
        line(part, ticks(len(rows), CONTROL), 1e3 * (np.hypot(*rows.T) - radius))
        part.set_ylabel(f"eq. {kind}\nradial error (µm)")
    grid[-1, 0].set_xlabel("time (s): ten periods of the master")
    yield "fig8_to_10_circle", figure


def _interpolators_at_the_corner() -> Figure:
    """Figs 5 to 7: points of the master, the second stage between them, and the response of the axes."""
    master = corner()
    x = master[:, 0].max()
    figure, grid = new_figure(
        "Paper 002, Figs 5 to 7: interpolators at a corner", 1, 3, height=4.2, width=12.0
    )
    for part, kind in zip(grid[0], (2, 3, 4), strict=True):
        rows = second_stage(master, PARTS, kind)
        actual = run_stateline(rows, AXES, Rule.NONE, 0.05).position
        part.plot(rows[:, 0], rows[:, 1], linewidth=1.0, color=BLUE, label="second stage")
        part.plot(actual[:, 0], actual[:, 1], linewidth=1.0, color=ORANGE, label="axes, no stateline")
        part.plot(master[:, 0], master[:, 1], "ko", markersize=4, fillstyle="none", label="master")
        plane(part, [np.array([[x - 2.0, -0.3], [x + 0.3, 2.0]])], ("X (mm)", "Y (mm)"))
        part.set_title(f"eq. {kind}", fontsize=9)
    legend(grid[0, 0], "upper left")
    return figure


def _stateline_corner() -> Figure:
    """Fig. 3, the paths that a corner leaves; the rules' paths lie on each other, so they differ in width."""
    reference = second_stage(corner(), PARTS, 2)
    figure, ((part,),) = new_figure(
        "Paper 002, Fig. 3: sharp corner under the stateline", height=5.5, width=6.5
    )
    part.plot(reference[:, 0], reference[:, 1], color="black", linewidth=0.6, label="reference")
    looks = {
        Rule.NONE: ("no stateline", RED, 1.2),
        Rule.ERROR: ("eq. 7", ORANGE, 5.0),
        Rule.RULE_2: ("Rule 2", GREEN, 2.8),
        Rule.JERK: ("jerk rule", BLUE, 1.0),
    }
    for rule, (name, color, width) in looks.items():
        run = run_stateline(reference, AXES, rule, 0.05)
        part.plot(run.position[:, 0], run.position[:, 1], linewidth=width, color=color, label=name)
    x = reference[:, 0].max()
    plane(part, [np.array([[x - 1.1, -0.2], [x + 0.2, 1.1]])], ("X (mm)", "Y (mm)"))
    legend(part, "upper left")
    return figure


def _stateline_errors() -> Figure:
    """Fig. 4: following errors of both axes round the corner, under Rule 2 and under the jerk rule."""
    reference = second_stage(corner(), PARTS, 2)
    figure, grid = new_figure("Paper 002, Fig. 4: following errors at the corner", 3, height=1.9)
    for part, (rule, name) in zip(
        grid[:, 0],
        ((Rule.NONE, "no stateline"), (Rule.RULE_2, "Rule 2"), (Rule.JERK, "jerk rule")),
        strict=True,
    ):
        run = run_stateline(reference, AXES, rule, 0.05)
        error = reference[np.minimum(run.place, len(reference) - 1)] - run.position
        times = ticks(len(error), CONTROL)
        line(part, times, error[:, 0], label="X")
        line(part, times, error[:, 1], color=ORANGE, label="Y")
        part.set_ylabel(f"{name}\nerror (mm)")
    legend(grid[0, 0], "center right")
    grid[-1, 0].set_xlabel("time (s)")
    return figure
