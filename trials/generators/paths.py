"""Random paths of all kinds of motion, with machines for them, as hypothesis strategies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st
from numpy.typing import NDArray

from cncgen.machine.record import Axis, Machine
from cncgen.pipeline import read_text, sound
from cncgen.toolpath.record import Toolpath
from cncgen.units import DEGREE

Floats = NDArray[np.float64]

PERIOD = 1e-3
LETTERS = "XYZA"


@dataclass(frozen=True)
class Line:
    """A straight move, mm and degrees."""

    by: tuple[float, float, float, float]


@dataclass(frozen=True)
class Arc:
    """An arc (helix) in X Y: radius, angle of the start seen from the centre, sweep, rise."""

    radius: float
    start: float
    sweep: float
    rise: float


@dataclass(frozen=True)
class Curve:
    """A cubic NURBS in X Y Z: control points from the present position, weights, inner knots."""

    points: tuple[tuple[float, float, float], ...]
    weights: tuple[float, ...]
    knots: tuple[float, ...]


@dataclass(frozen=True)
class Dwell:
    """A wait, s."""

    seconds: float


Move = Line | Arc | Curve | Dwell


@dataclass(frozen=True)
class Case:
    """A program and a machine.

    Attributes:
        moves: In order.
        feed: mm/min; where `inverse`, 1/min of each move.
        mode: ``G61``, ``G61.1`` or ``G64 P…``.
        limits: Velocity, acceleration and jerk of each axis of `LETTERS`, mm or degrees.
        chord: Chord tolerance, mm.
        scale: Factor on all lengths but the rotary axis's.
        period: Time between setpoints, s; None for `PERIOD`.
    """

    moves: tuple[Move, ...]
    feed: float
    inverse: bool
    mode: str
    limits: tuple[tuple[float, float, float], ...]
    chord: float = 1e-3
    scale: float = 1.0
    period: float | None = None

    @property
    def machine(self) -> Machine:
        """The machine with these limits."""
        axes = {}
        for letter, limits in zip(LETTERS, self.limits, strict=True):
            unit = DEGREE if letter == "A" else self.scale
            velocity, acceleration, jerk = (limit * unit for limit in limits)
            axes[letter] = Axis(letter, velocity, acceleration, jerk)
        return Machine(
            name="random",
            axes=MappingProxyType(axes),
            period_s=self.period or PERIOD,
            chord_tolerance_mm=self.chord * self.scale,
            path_tolerance_mm=0.01 * self.scale,
        )

    @property
    def text(self) -> str:
        """The program."""
        lines = ["G21 G17 G90 " + ("G93 " if self.inverse else "G94 ") + self._mode()]
        at = np.zeros(4)
        for move in self.moves:
            at, blocks = _blocks(move, at, self.scale, self.feed * (1.0 if self.inverse else self.scale))
            lines += blocks
        return "\n".join([*lines, "M2", ""])

    def _mode(self) -> str:
        if self.mode.startswith("G64"):
            return f"G64 P{float(self.mode[5:]) * self.scale:.12g}"
        return self.mode

    @property
    def toolpaths(self) -> list[Toolpath]:
        """The program as it is read."""
        return [chunk for chunk in sound(read_text(self.text, "random.nc")) if len(chunk)]

    def __repr__(self) -> str:
        """Print what reproduces it."""
        limits = "".join(
            f"\n    {letter}: velocity {v:.9g}, acceleration {a:.9g}, jerk {j:.9g}"
            for letter, (v, a, j) in zip(LETTERS, self.limits, strict=True)
        )
        period = f", period {self.period:g} s" if self.period else ""
        return f"Case, chord {self.chord:g} mm{period}{limits}\n{self.text}"


def _number(x: float) -> str:
    """Write a number with all its digits."""
    return np.format_float_positional(x, trim="-")


def _words(x: Sequence[float] | Floats) -> str:
    return " ".join(f"{letter}{_number(value)}" for letter, value in zip(LETTERS, x, strict=False))


def _blocks(move: Move, at: Floats, scale: float, feed: float) -> tuple[Floats, list[str]]:
    """Return where a move from `at` ends, and its blocks."""
    if isinstance(move, Dwell):
        return at, [f"G4 P{move.seconds:.6f}"]
    if isinstance(move, Line):
        end = at + np.array(move.by) * [scale, scale, scale, 1.0]
        return end, [f"G1 {_words(end)} F{_number(feed)}"]
    if isinstance(move, Arc):
        out = np.array([math.cos(move.start), math.sin(move.start)]) * move.radius * scale
        turned = move.start + move.sweep
        end = at.copy()
        if abs(abs(move.sweep) - 2.0 * math.pi) > 1e-9:
            end[:2] += np.array([math.cos(turned), math.sin(turned)]) * move.radius * scale - out
        end[2] += move.rise * scale
        code = "G3" if move.sweep > 0 else "G2"
        return end, [f"{code} {_words(end[:3])} I{_number(-out[0])} J{_number(-out[1])} F{_number(feed)}"]
    points = at[:3] + np.array([(0.0, 0.0, 0.0), *move.points]) * scale
    knots = [0.0] * 4 + list(move.knots) + [1.0] * 4
    blocks = []
    for i, (point, weight) in enumerate(zip(points, move.weights, strict=True)):
        head = "G6.2 P4 " if i == 0 else ""
        blocks.append(
            f"{head}K{_number(knots[i])} {_words(point)} R{_number(weight)}"
            + (f" F{_number(feed)}" if i == 0 else "")
        )
    blocks += [f"K{_number(knot)}" for knot in knots[len(points) :]]
    return np.concatenate([points[-1], at[3:]]), blocks


# --- random cases ---------------------------------------------------------------------------------------------------


def _logarithmic(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(math.log10(low), math.log10(high)).map(lambda x: float(f"{10.0**x:.6g}"))


_signs = st.sampled_from([-1.0, 1.0])
_length = st.one_of(_logarithmic(0.1, 30.0), _logarithmic(0.1, 30.0), _logarithmic(1e-7, 0.1), st.just(1e-7))
_angle = st.one_of(st.sampled_from([0.0, 0.5 * math.pi, math.pi]), st.floats(-3.1, 3.1))


@st.composite
def _line(draw: st.DrawFn) -> Line:
    length, angle = draw(_length), draw(_angle)
    lift = draw(st.sampled_from([0.0, 0.0, 0.3]))
    turn = draw(st.sampled_from([0.0, 0.0, 0.0, 1.0]))
    return Line(
        (
            length * math.cos(angle),
            length * math.sin(angle),
            lift * length,
            turn * draw(_logarithmic(0.01, 90.0)) * draw(_signs) if turn else 0.0,
        )
    )


@st.composite
def _rotary(draw: st.DrawFn) -> Line:
    return Line((0.0, 0.0, 0.0, draw(_logarithmic(1e-5, 180.0)) * draw(_signs)))


@st.composite
def _arc(draw: st.DrawFn) -> Arc:
    sweep = draw(st.one_of(st.just(2.0 * math.pi), st.floats(0.05, 6.2))) * draw(_signs)
    return Arc(
        draw(_logarithmic(0.02, 30.0)), draw(_angle), sweep, draw(st.sampled_from([0.0, 0.0, 1.0, -3.0]))
    )


@st.composite
def _curve(draw: st.DrawFn) -> Curve:
    n = draw(st.integers(4, 8))
    coordinate = st.integers(-15, 15).map(float)
    points: list[tuple[float, float, float]] = []
    for _ in range(n - 1):
        again = points and draw(st.integers(0, 4)) == 0
        points.append(points[-1] if again else (draw(coordinate), draw(coordinate), draw(coordinate) / 5.0))
    weights = tuple(draw(st.sampled_from([1.0, 1.0, 2.0, 0.5])) for _ in range(n))
    knots = tuple(
        sorted(draw(st.lists(st.integers(1, 9).map(lambda k: k / 10.0), min_size=n - 4, max_size=n - 4)))
    )
    assume(len(set(knots)) > 1 or len(knots) < 4)  # four equal knots part the curve
    return Curve(tuple(points), weights, knots)


def _back(move: Move) -> Move:
    return Line(tuple(-x for x in move.by)) if isinstance(move, Line) else move  # type: ignore[arg-type]


def _turned(length: Sequence[float], turn: Sequence[float] | Floats) -> tuple[Move, ...]:
    """Return lines in the plane, each turned by an angle against the one before."""
    heading = np.cumsum(turn)
    return tuple(
        Line((size * math.cos(angle), size * math.sin(angle), 0.0, 0.0))
        for size, angle in zip(length, heading, strict=True)
    )


@st.composite
def _outline(draw: st.DrawFn) -> tuple[Move, ...]:
    """Draw a square, a zigzag, a star or any polyline."""
    kind = draw(st.sampled_from(["square", "zigzag", "star", "polyline", "polyline", "short"]))
    size = draw(_logarithmic(0.3, 60.0))
    if kind == "square":
        return _turned([size] * 4, [0.5 * math.pi] * 4)
    count = draw(st.integers(3, 9))
    if kind == "zigzag":
        turn = draw(st.floats(0.1, 3.0))
        return _turned([size] * count, [turn * (-1.0) ** k for k in range(count)])
    if kind == "star":
        points = draw(st.sampled_from([5, 7, 9]))
        return _turned([size] * points, [2.0 * math.pi * (points // 2) / points] * points)
    low, high = (0.3 * size, 3.0 * size) if kind == "polyline" else (0.02, 20.0)
    length = [draw(_logarithmic(low, high)) for _ in range(count)]
    return _turned(length, [math.radians(draw(st.floats(5.0, 175.0))) * draw(_signs) for _ in range(count)])


@st.composite
def outlines(draw: st.DrawFn) -> Case:
    """Draw the outline of a simple shape and a common machine for it; the mode is left to the property."""
    limits = (
        draw(_logarithmic(50.0, 500.0)),
        draw(_logarithmic(500.0, 5000.0)),
        draw(_logarithmic(1e4, 1e6)),
    )
    slower = draw(st.sampled_from([1.0, 1.0, 1.0, 0.3]))
    return Case(
        draw(_outline()),
        60.0 * draw(_logarithmic(5.0, 500.0)),
        False,
        "G61",
        (limits, tuple(slower * x for x in limits), limits, limits),  # type: ignore[arg-type]
        chord=draw(st.sampled_from([1e-3, 1e-3, 1e-4, 5e-3])),
        period=draw(st.sampled_from([0.25e-3, 0.5e-3, 1e-3, 2e-3, 4e-3])),
    )


@st.composite
def chains(draw: st.DrawFn) -> Case:
    """Draw a wave of short lines whose ends lie a little beside it, or an outline, under G64."""
    case = draw(outlines())
    if draw(st.integers(0, 2)):
        count, step = draw(st.integers(5, 40)), draw(_logarithmic(0.02, 2.0))
        noise, wave = draw(_logarithmic(1e-5, 1e-1)), draw(st.floats(0.0, 1.0))
        beside = [noise * draw(st.floats(-1.0, 1.0)) for _ in range(count)]
        turn = np.diff([wave * math.sin(0.3 * k) + beside[k] for k in range(count)], prepend=0.0)
        case = replace(case, moves=_turned([step] * count, turn))
    return replace(case, mode=f"G64 P{draw(_logarithmic(1e-3, 0.2)):g}")


@st.composite
def cases(draw: st.DrawFn, lines_only: bool = False, modes: Sequence[str] = ("G61", "G61.1", "G64")) -> Case:
    """Draw a program of one to eight moves and a machine for it."""
    inverse = draw(st.integers(0, 5)) == 0
    kinds: list[st.SearchStrategy[Move]] = [_line(), _line(), _rotary(), st.just(Dwell(0.05))]
    if not lines_only:
        kinds.append(_arc())
        if not inverse:
            kinds.append(_curve())
    moves: list[Move] = []
    for move in draw(st.lists(st.one_of(kinds), min_size=1, max_size=8)):
        moves.append(move)
        special = draw(st.integers(0, 9))
        if special == 0:
            moves.append(_back(move))
        elif special == 1:
            moves.append(Line((0.0, 0.0, 0.0, 0.0)))
    mode = draw(st.sampled_from(list(modes)))
    if mode == "G64":
        mode = f"G64 P{draw(st.sampled_from([0.001, 0.01, 0.1]))}"
    base = (
        draw(_logarithmic(20.0, 1000.0)),
        draw(_logarithmic(200.0, 20000.0)),
        draw(_logarithmic(5e3, 1e6)),
    )
    limits = []
    for _ in LETTERS:
        factor = draw(st.sampled_from([1.0, 1.0, 0.3, 0.03]))
        limits.append(tuple(float(f"{value * factor:.6g}") for value in base))
    feed = draw(_logarithmic(2.0, 600.0)) if inverse else draw(_logarithmic(100.0, 200_000.0))
    return Case(tuple(moves), feed, inverse, mode, tuple(limits))  # type: ignore[arg-type]
