"""Paper 001 (Chen and Hsu): RMS errors under modified reference commands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cncgen.papers.printed import Row, Table
from cncgen.report.drawing import (
    GREY,
    ORANGE,
    legend,
    line,
    new_figure,
    ticks,
)
from cncgen.servo.inversion import held_response, modified_reference, root_mean_square
from cncgen.servo.reference_profiles import BELL_EXACT, ReferenceProfile, bell, exponential, linear

if TYPE_CHECKING:
    from cncgen.report.drawing import Figures

PERIOD = 0.001
#: Tables 1 and 2: numerator, denominator, RMS in µm for the linear, exponential and bell-shaped profile.
PRINTED = (
    (1, (1, 8), (1, 3), (3.25, 2.34, 3.17)),
    (1, (1, 1), (1, 2, 3), (5.59, 4.45, 5.72)),
    (2, (1, -8), (1, 3), (2680, 4680, 2420)),
    (2, (1, -2), (1, 5), (46.7, 57.9, 46.6)),
    (2, (1, -1), (1, 2, 3), (5.59, 4.48, 5.71)),
    (2, (1, -2), (1, 3, 8), (5.60, 4.51, 5.66)),
    (2, (1, -5), (1, 3, 8), (5.69, 4.55, 5.74)),
)
PROFILES: tuple[tuple[str, ReferenceProfile], ...] = (
    ("linear", linear()),
    ("exponential", exponential()),
    ("bell", bell()),
)


def rms_um(
    numerator: tuple[float, ...],
    denominator: tuple[float, ...],
    profile: ReferenceProfile,
    before_s: float = 0.0,
) -> float:
    """Return eq. 9 of the command of eq. 8, held over 1 ms, µm; with `before_s` of the bounded inverse instead."""
    ticks = np.arange(-round(before_s / PERIOD), round(1.0 / PERIOD) + 1)
    times = np.asarray(ticks * PERIOD, np.float64)
    above, below = np.array(numerator, float), np.array(denominator, float)
    command = modified_reference(above, below, profile, times, stable=before_s > 0.0)
    error = held_response(above, below, command, PERIOD) - profile.value(times)
    return 1e3 * root_mean_square(error, PERIOD)


def shown(numerator: tuple[float, ...], denominator: tuple[float, ...]) -> str:
    """Return a ratio of polynomials as text."""
    return f"({_polynomial(numerator)})/({_polynomial(denominator)})"


def _polynomial(coefficients: tuple[float, ...]) -> str:
    n = len(coefficients) - 1
    terms = []
    for k, c in enumerate(coefficients):
        power = ("", "s", "s²")[n - k] if n - k < 3 else f"s^{n - k}"
        size = "" if abs(c) == 1 and power else f"{abs(c):g}"
        terms.append(("-" if c < 0 else "+" if k else "") + size + power)
    return "".join(terms)


def tables(programs: str | None = None) -> list[Table]:
    """Return Tables 1 and 2 and what stable inversion makes of the two systems that grow."""
    found = []
    for number in (1, 2):
        rows = [
            Row(f"{shown(above, below)} {name}", rms_um(above, below, profile), value, "µm", within=0.025)
            for table, above, below, values in PRINTED
            if table == number
            for (name, profile), value in zip(PROFILES, values, strict=True)
        ]
        found.append(Table(f"Paper 001, Table {number}: RMS error", tuple(rows), _ASSUMPTIONS))
    rows = [
        Row(f"{shown(above, below)} {name}", rms_um(above, below, profile, 8.0), unit="µm", at_most=bound)
        for above, below, bound in (((1, -8), (1, 3), 10.0), ((1, -2), (1, 5), None))
        for name, profile in (PROFILES[0], PROFILES[1], ("bell", bell(BELL_EXACT)))
    ]
    title = "Paper 001, the same by stable inversion with pre-actuation"
    return [*found, Table(title, tuple(rows), ("not in the paper, which leaves these systems open",))]


_ASSUMPTIONS = (
    "exact convolution, sampled at 1 ms and held: nearly all of the error is that half sample of delay",
    "Table 1 prints the inverse of its first system: the text's (s+8)/(s+3) gives its figures, (s+3)/(s+8) does not",
    "the bell has the paper's rounded constants; the exponential is normalised to end at rest, with 3.84 and 8.84",
)


def figures(programs: str | None = None) -> Figures:
    """The tracking errors behind Table 1, and the causal against the bounded inverse of (s − 8)/(s + 3)."""
    times = ticks(1001)
    figure, grid = new_figure(
        "Paper 001, Figs 3 to 5: tracking error under the modified reference, (s+1)/(s²+2s+3)", 3, height=1.9
    )
    profiles = {"linear": linear(), "exponential": exponential(), "bell": bell()}
    for part, (name, profile) in zip(grid[:, 0], profiles.items(), strict=True):
        above, below = np.array([1.0, 1.0]), np.array([1.0, 2.0, 3.0])
        command = modified_reference(above, below, profile, times)
        error = held_response(above, below, command, 0.001) - profile.value(times)
        rms = 1e3 * root_mean_square(error, 0.001)
        line(part, times, 1e3 * error, label=f"{name} profile, rms {rms:.2f} µm")
        part.set_ylabel("error (µm)")
        legend(part, "upper center")
    grid[-1, 0].set_xlabel("time (s)")
    yield "fig3_to_5_tracking_errors", figure
    long = ticks(2501, first=-1500)
    above, below = np.array([1.0, -8.0]), np.array([1.0, 3.0])
    figure, grid = new_figure("Paper 001: commands for (s−8)/(s+3), linear profile", 2, height=2.6)
    line(
        grid[0, 0],
        times,
        modified_reference(above, below, linear(), times),
        color=ORANGE,
        label="causal command",
    )
    stable = modified_reference(above, below, linear(), long, stable=True)
    line(grid[1, 0], long, stable, label="command with pre-actuation")
    for part in grid[:, 0]:
        line(part, long, linear().value(long), color=GREY, linestyle="--", label="wanted position")
        part.set_ylabel("position (mm)")
        legend(part, "upper left")
    grid[-1, 0].set_xlabel("time (s)")
    yield "inversion", figure
