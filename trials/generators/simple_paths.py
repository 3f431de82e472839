"""Simple paths in a plane, with limits, on which one limit can be raised step by step.

Zigzags, polygons, stars, polylines that turn at random, lines with arcs, a NURBS, a cusp; periods of 0.25 to 4 ms.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.record import Axis, Machine
from cncgen.pipeline import plan, read_text

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Line:
    """A straight move to a place."""

    end: tuple[float, float]


@dataclass(frozen=True)
class Arc:
    """An arc: centre, and by how much it turns."""

    centre: tuple[float, float]
    sweep: float


@dataclass(frozen=True)
class Curve:
    """A cubic NURBS: control points and weights as rows (x, y, w), the first one at the present place, and knots."""

    points: tuple[tuple[float, float, float], ...]
    knots: tuple[float, ...]


Move = Line | Arc | Curve


@dataclass(frozen=True)
class Case:
    """A path in X Y from the origin, and limits.

    Attributes:
        name: Of its kind.
        moves: In order.
        limits: Shape (3, 2): velocity, acceleration and jerk of X and Y.
        feed: mm/s.
        chord: Chord tolerance, mm.
        period: s.
        mode: G61, G61.1, G64 P…
    """

    name: str
    moves: tuple[Move, ...]
    limits: tuple[tuple[float, float], ...]
    feed: float
    chord: float
    period: float
    mode: str

    @property
    def machine(self) -> Machine:
        """The machine with these limits."""
        velocity, acceleration, jerk = self.limits
        axes = {a: Axis(a, velocity[i], acceleration[i], jerk[i]) for i, a in enumerate("XY")}
        return Machine(
            name="ladder",
            axes=MappingProxyType(axes),
            period_s=self.period,
            chord_tolerance_mm=self.chord,
            path_tolerance_mm=0.01,
        )

    @property
    def text(self) -> str:
        """The program."""
        rows = [f"G21 G17 G90 G94 {self.mode} F{60.0 * self.feed:.9f}"]
        at = np.zeros(2)
        for move in self.moves:
            rows += _blocks(at, move)
            at = end_of(at, move)
        return "\n".join([*rows, "M2", ""])

    @property
    def time(self) -> float:
        """Least time, s."""
        return float(list(plan(read_text(self.text), self.machine))[-1].profile.t[-1])

    def __repr__(self) -> str:
        """Print what reproduces it."""
        limits = ", ".join(
            f"{name} {'/'.join(f'{x:.9g}' for x in row)}"
            for name, row in zip(("velocity", "acceleration", "jerk"), self.limits, strict=True)
        )
        return (
            f"{self.name}: {limits}, chord {self.chord:.9g} mm, period {1e3 * self.period:g} ms\n{self.text}"
        )


def _words(letters: str, values: Floats) -> str:
    return " ".join(f"{letter}{value:.15f}" for letter, value in zip(letters, values, strict=True))


def end_of(at: Floats, move: Move) -> Floats:
    """Return where a move ends."""
    if isinstance(move, Line):
        return np.array(move.end)
    if isinstance(move, Curve):
        return np.array(move.points[-1][:2])
    centre = np.array(move.centre)
    cos, sin = math.cos(move.sweep), math.sin(move.sweep)
    return centre + np.array([[cos, -sin], [sin, cos]]) @ (at - centre)


def _blocks(at: Floats, move: Move) -> list[str]:
    """Return the blocks of a move."""
    end = end_of(at, move)
    if isinstance(move, Line):
        return ["G1 " + _words("XY", end)]
    if isinstance(move, Arc):
        code = "G3 " if move.sweep > 0.0 else "G2 "
        return [code + _words("XY", end) + " " + _words("IJ", np.array(move.centre) - at)]
    rows = [
        f"K{knot:.15f} {_words('XYR', np.array(point))}"
        for knot, point in zip(move.knots, move.points, strict=False)
    ]
    rows[0] = "G6.2 P4 " + rows[0]
    return rows + [f"K{knot:.15f}" for knot in move.knots[len(move.points) :]]


# --- paths ----------------------------------------------------------------------------------------------------------


def _polyline(turns: Floats, lengths: Floats) -> tuple[Move, ...]:
    angle = np.cumsum(turns)
    points = np.cumsum(lengths[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1), axis=0)
    return tuple(Line((float(x), float(y))) for x, y in points)


def _polylines(draw: np.random.Generator) -> tuple[str, tuple[Move, ...]]:
    """Return a zigzag, polygon, star, or lines that turn at random."""
    length = 10.0 ** draw.uniform(-0.5, 1.5)
    kind = draw.choice(["zigzag", "polygon", "star", "random"])
    if kind == "zigzag":
        turn = math.radians(10.0 ** draw.uniform(-0.5, 2.2))
        return kind, _polyline(np.array([0.0, *[turn, -turn] * 4]), np.full(9, length))
    if kind == "polygon":
        sides = int(draw.integers(3, 60))
        return kind, _polyline(np.full(sides, 2.0 * math.pi / sides), np.full(sides, length))
    if kind == "star":
        return kind, _polyline(np.full(5, math.radians(144.0)), np.full(5, length))
    count = int(draw.integers(2, 40))
    turns = draw.normal(0.0, 10.0 ** draw.uniform(-3.0, 0.3), count)
    return kind, _polyline(turns, length * np.exp(draw.normal(0.0, 0.7, count)))


def _arcs(draw: np.random.Generator) -> tuple[str, tuple[Move, ...]]:
    """Return a slot, arcs that touch, or a small circle before a line."""
    r = 10.0 ** draw.uniform(-0.7, 1.0)
    kind = draw.choice(["slot", "waves", "circle"])
    if kind == "slot":
        a = 10.0 ** draw.uniform(-0.5, 1.5)
        around = Line((a, 0.0)), Arc((a, r), math.pi), Line((0.0, 2.0 * r)), Arc((0.0, r), math.pi)
        return kind, around
    if kind == "waves":
        turn = draw.uniform(0.5, 3.1)
        moves: list[Move] = [Line((r, 0.0))]
        at, angle = np.array([r, 0.0]), 0.0
        for k in range(4):
            side = 1.0 if k % 2 else -1.0
            centre = at + side * r * np.array([-math.sin(angle), math.cos(angle)])
            moves.append(Arc((float(centre[0]), float(centre[1])), side * turn))
            at, angle = end_of(at, moves[-1]), angle + side * turn
        return kind, tuple(moves)
    return kind, (Arc((r, 0.0), -2.0 * math.pi), Line((5.0, 0.0)))


def _curves(draw: np.random.Generator) -> tuple[str, tuple[Move, ...]]:
    """Return a NURBS with inner knots, after a line half of the time, or one that comes near to a cusp."""
    if draw.integers(3) == 0:
        points = ((0.0, 0.0), (20.0, 20.0), (float(draw.uniform(-0.2, 3.0)), 20.0), (20.0, 0.0))
        return "cusp", (Curve(tuple((*p, 1.0) for p in points), (0.0,) * 4 + (1.0,) * 4),)
    moves: list[Move] = []
    start = (0.0, 0.0)
    if draw.integers(2):
        start = (5.0, 0.0)
        moves.append(Line(start))
    count = int(draw.integers(4, 8))
    rest = [
        (*draw.uniform(-15.0, 15.0, 2).tolist(), float(draw.choice([0.5, 1.0, 2.0])))
        for _ in range(count - 1)
    ]
    inner = sorted(draw.uniform(0.05, 0.95, count - 4).tolist())
    moves.append(Curve(((*start, 1.0), *rest), (0.0,) * 4 + tuple(inner) + (1.0,) * 4))
    return "NURBS", tuple(moves)


def drawn(draw: np.random.Generator, mode: str) -> Case:
    """Return a random path on a random machine."""
    shapes: list[Callable[[np.random.Generator], tuple[str, tuple[Move, ...]]]] = [
        _polylines,
        _polylines,
        _arcs,
        _curves,
    ]
    name, moves = shapes[int(draw.integers(4))](draw)
    base = 10.0 ** np.array([draw.uniform(1.0, 3.0), draw.uniform(2.0, 4.5), draw.uniform(3.5, 6.5)])
    weak = np.array([1.0, draw.choice([1.0, 1.0, 1.0, 0.3])])
    return Case(
        name,
        moves,
        tuple(map(tuple, (base[:, None] * weak).tolist())),
        10.0 ** draw.uniform(0.5, 3.0),
        10.0 ** draw.uniform(-4.0, -1.0),
        float(draw.choice([0.25e-3, 0.5e-3, 1e-3, 2e-3, 4e-3])),
        mode,
    )


def train(draw: np.random.Generator, mode: str) -> Case:
    """Return 3 to 40 lines of 1/50 to 10 J T³ each, which turn at random: about a period from corner to corner."""
    period, jerk = float(draw.choice([0.5e-3, 1e-3, 2e-3, 4e-3])), 10.0 ** draw.uniform(3.5, 6.5)
    acceleration = jerk * period * 10.0 ** draw.uniform(-0.5, 1.2)
    velocity = acceleration * period * 10.0 ** draw.uniform(0.0, 2.0)
    count, size = int(draw.integers(3, 40)), jerk * period**3 * 10.0 ** draw.uniform(-1.7, 1.0)
    turns = draw.normal(0.0, 10.0 ** draw.uniform(-2.0, 0.3), count)
    moves = _polyline(turns, size * np.exp(draw.normal(0.0, 0.5, count)))
    weak = float(draw.choice([1.0, 1.0, 0.3]))
    limits = tuple((limit, limit * weak) for limit in (velocity, acceleration, jerk))
    chord = max(2e-9, size * 10.0 ** draw.uniform(-2.5, 0.5))
    return Case("train", moves, limits, 10.0 * velocity, chord, period, mode)
