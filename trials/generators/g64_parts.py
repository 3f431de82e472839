"""Random G64 programs with the path that they mean, and machines for them.

Lines, arcs, helices, NURBS and rotary axes; cusps, reversals, retraced paths, plunges, moves of no length, waits; P from
1e-5 to ten times the moves, changed within the program, left out, with Q.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from cncgen.machine.record import Axis, Machine
from cncgen.units import DEGREE

Floats = NDArray[np.float64]

AXES = "XYZAC"
CHORD_MM = 1e-3


@dataclass
class Part:
    """A random program with its path.

    Attributes:
        lines: Blocks.
        pieces: Points of each motion, shape (n, 5), mm and degrees, its start included.
        tolerance: How far the motion may be from each piece.
        unit: Size of the moves, mm.
    """

    rng: np.random.Generator
    unit: float
    tolerance_now: float
    lines: list[str] = field(default_factory=list)
    pieces: list[Floats] = field(default_factory=list)
    tolerance: list[float] = field(default_factory=list)
    at: Floats = field(default_factory=lambda: np.zeros(5))
    heading: float = 0.0
    rotary: bool = False
    inverse: bool = False

    def feed(self, points: Floats) -> str:
        """Return the F word of a motion."""
        if not self.inverse:
            return ""
        length = max(np.linalg.norm(np.diff(points, axis=0), axis=1).sum(), 1e-4)
        return f" F{60.0 * self.rng.uniform(5, 80) / length:.6f}"

    def add(self, block: str, points: Floats) -> None:
        """Append a motion."""
        self.lines.append(block + self.feed(points))
        self.pieces.append(points)
        self.tolerance.append(max(self.tolerance_now, CHORD_MM))
        self.at = points[-1].copy()

    def line(self, by: Floats) -> None:
        """Append a straight move to what its words say."""
        words = [
            f"{letter}{self.at[k] + by[k]:.7f}"
            for k, letter in enumerate(AXES)
            if by[k] or (k < 2 and not by.any())
        ]
        end = self.at.copy()
        for word in words:
            end[AXES.index(word[0])] = float(word[1:])
        self.add("G1 " + " ".join(words), np.array([self.at, end]))

    def step(self, turn: float, length: float) -> Floats:
        """Return a step in the plane after a turn, with some Z and rotary motion."""
        self.heading += turn
        by = np.zeros(5)
        by[:2] = length * np.cos(self.heading), length * np.sin(self.heading)
        if self.rng.random() < 0.2:
            by[2] = self.rng.normal() * 0.3 * length
        if self.rotary:
            by[3:] = self.rng.normal(size=2) * self.rng.choice([0.0, 0.3, 1.0, 5.0]) * length
        return by

    def arc(self, radius: float, sweep: float, rise: float) -> None:
        """Append an arc or helix that begins along the heading, more or less."""
        sign = 1.0 if sweep > 0 else -1.0
        tangent = self.heading + self.rng.choice([0.0, 0.0, self.rng.normal() * 0.5])
        centre = self.at[:2] + radius * sign * np.array([-np.sin(tangent), np.cos(tangent)])
        i, j = np.round(centre - self.at[:2], 7)
        if not np.hypot(i, j) > 1e-3:
            return
        centre = self.at[:2] + np.array([i, j])
        first = np.arctan2(-j, -i)
        full = abs(sweep) >= 2 * np.pi - 1e-9
        exact = centre + np.hypot(i, j) * np.array([np.cos(first + sweep), np.sin(first + sweep)])
        end = self.at[:2].copy() if full else np.round(exact, 7)
        z = round(self.at[2] + rise, 7)
        count = int(np.clip(abs(sweep) / np.sqrt(8e-3 * self.fine / radius), 16, 40_000))
        f = np.linspace(0, 1, count + 1)
        angle = first + f * sweep
        points = np.repeat(self.at[None, :], count + 1, axis=0)
        points[:, 0] = centre[0] + np.hypot(i, j) * np.cos(angle)
        points[:, 1] = centre[1] + np.hypot(i, j) * np.sin(angle)
        points[:, 2] = self.at[2] + f * (z - self.at[2])
        points[-1, :2] = end
        block = f"{'G3' if sweep > 0 else 'G2'} X{end[0]:.7f} Y{end[1]:.7f} Z{z:.7f} I{i:.7f} J{j:.7f}"
        self.add(block, points)
        self.heading = tangent + sweep

    @property
    def fine(self) -> float:
        return max(self.tolerance_now, CHORD_MM)

    def curve(self, length: float) -> None:
        """Append a cubic NURBS of one to three spans."""
        spans = int(self.rng.integers(1, 4))
        count = spans + 3
        control = np.repeat(self.at[None, :], count, axis=0)
        steps = length * self.rng.normal(size=(count - 1, 2))
        if self.rng.random() < 0.5:
            steps = 0.4 * steps + length * np.array([np.cos(self.heading), np.sin(self.heading)])
        control[1:, :2] += np.cumsum(steps, axis=0)
        control = np.round(control, 7)
        weight = np.round(self.rng.uniform(0.5, 2.0, count), 4)
        inner = np.round(np.sort(self.rng.uniform(0.2, 0.8, spans - 1)), 4)
        knots = np.concatenate([np.zeros(4), inner, np.ones(4)])
        u = np.linspace(0, 1, 8001)
        homogeneous = BSpline(knots, np.column_stack([control * weight[:, None], weight]), 3)(u)
        points = homogeneous[:, :-1] / homogeneous[:, -1:]
        rows = [
            f"K{knots[k]:g} X{control[k, 0]:.7f} Y{control[k, 1]:.7f} R{weight[k]:g}" for k in range(count)
        ]
        self.lines += ["G6.2 P4 " + rows[0], *rows[1:]]
        self.add("\n".join(f"K{k:g}" for k in knots[count:]) + "\nG1", points)
        # The feed of a NURBS stands in its first block; the line after the last knot only ends it.
        last = self.lines.pop()
        self.lines.append(last.split("\nG1")[0])
        d = control[-1, :2] - control[-2, :2]
        self.heading = float(np.arctan2(d[1], d[0]))


def choose(part: Part) -> None:
    """Append something nasty."""
    rng, unit = part.rng, part.unit
    size = unit * 10 ** rng.uniform(-1.5, 0.7)
    kind = rng.choice(
        [
            "short",
            "line",
            "zigzag",
            "back",
            "arc",
            "circle",
            "helix",
            "curve",
            "null",
            "tiny",
            "wait",
            "code",
            "p",
            "plunge",
            "retrace",
            "star",
        ],
        p=[0.16, 0.13, 0.08, 0.06, 0.13, 0.04, 0.04, 0.06, 0.03, 0.04, 0.03, 0.03, 0.06, 0.04, 0.04, 0.03],
    )
    if kind == "short":
        turn = rng.normal() * 0.3
        for _ in range(int(rng.integers(5, 40))):
            part.line(part.step(turn * rng.random(), 0.05 * size * rng.uniform(0.2, 1)))
    elif kind == "line":
        part.line(part.step(rng.uniform(-np.pi, np.pi), size))
    elif kind == "zigzag":
        for k in range(int(rng.integers(4, 16))):
            part.line(part.step((-1) ** k * rng.uniform(2.5, np.pi), 0.1 * size * rng.uniform(0.5, 1)))
    elif kind == "back":
        by = part.step(0.0, size)
        part.line(by)
        part.line(-by * rng.choice([1.0, 0.5, 0.01]))
    elif kind == "arc" and not part.inverse:
        part.arc(size * 10 ** rng.uniform(-1, 0.3), rng.uniform(-6, 6), 0.0)
    elif kind == "circle" and not part.inverse:
        part.arc(size * 10 ** rng.uniform(-1.5, 0), rng.choice([-2, 2]) * np.pi, 0.0)
    elif kind == "helix" and not part.inverse:
        part.arc(size, rng.uniform(-6, 6), rng.normal() * size)
    elif kind == "curve" and not part.inverse and not part.rotary:
        part.curve(0.4 * size)
    elif kind == "null":
        part.line(np.zeros(5))
    elif kind == "tiny":
        part.line(part.step(rng.uniform(-3, 3), 10 ** rng.uniform(-7, -4)))
    elif kind == "wait":
        part.lines.append(f"G4 P{rng.uniform(0.001, 0.05):.4f}")
    elif kind == "code":
        part.lines.append(str(rng.choice(["M8", "M9", "S1000 M3", "M5", "M1"])))
    elif kind == "p":
        part.lines.append(mode(part))
    elif kind == "plunge":
        down = np.array([0, 0, -size, 0, 0])
        part.line(down)
        part.line(part.step(rng.normal(), 0.2 * size) * [1, 1, 0, 1, 1])
        part.line(-down)
    elif kind == "retrace":
        steps = [part.step(rng.normal(), 0.2 * size) for _ in range(int(rng.integers(2, 8)))]
        for by in (*steps, *(-s for s in reversed(steps))):
            part.line(by)
    elif kind == "star":
        for _ in range(int(rng.integers(5, 12))):
            part.line(part.step(np.pi * 0.8, 0.5 * size))


def mode(part: Part) -> str:
    """Choose a path mode, and note its tolerance."""
    rng = part.rng
    p = round(part.unit * 10 ** rng.uniform(-4, 1.0) if rng.random() < 0.6 else 10 ** rng.uniform(-5, -1), 6)
    p = max(p, 1e-5)
    kind = rng.random()
    if kind < 0.08:
        part.tolerance_now = 0.0
        return str(rng.choice(["G61", "G61.1"]))
    if kind < 0.18:
        part.tolerance_now = 0.01
        return "G64"
    part.tolerance_now = p
    return f"G64 P{p:.6f}" + (f" Q{p / 2:.6f}" if kind < 0.3 else "")


def random_part(seed: int, index: int) -> Part:
    """Return the program of a number."""
    rng = np.random.default_rng((seed, index))
    part = Part(rng, float(10 ** rng.uniform(-0.5, 1.3)), 0.0)
    part.rotary = bool(rng.random() < 0.3)
    part.inverse = bool(part.rotary and rng.random() < 0.5)
    part.lines += [
        f"G21 G17 G90 {'G93' if part.inverse else 'G94'} F{10 ** rng.uniform(2, 4.3):.0f}",
        mode(part),
    ]
    part.line(part.step(0.0, part.unit))
    for _ in range(int(rng.integers(3, 25))):
        choose(part)
    part.lines.append("M2")
    return part


def random_machine(rng: np.random.Generator) -> Machine:
    """Return a machine with limits of its own."""
    axes = {}
    for letter in AXES:
        unit = DEGREE if letter in "AC" else 1.0
        limits = (10 ** rng.uniform(1.3, 2.7), 10 ** rng.uniform(2.5, 4), 10 ** rng.uniform(4, 6))
        velocity, acceleration, jerk = (unit * limit for limit in limits)
        axes[letter] = Axis(letter, velocity, acceleration, jerk)
    return Machine(
        "random", axes, period_s=float(rng.choice([0.0005, 0.001, 0.001, 0.004])), chord_tolerance_mm=CHORD_MM
    )
