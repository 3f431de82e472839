"""Random programs of thousands of motions, and machines whose limits differ by a hundred to one.

A program is a row of wandering lines, straight runs, staircases, chains of arcs, drilled holes and zigzags, under changing
feeds and path modes, with dwells and spindle and coolant events between them.
"""

from __future__ import annotations

import math
import random
from dataclasses import replace
from types import MappingProxyType

import cncgen
from cncgen.machine.record import Machine
from cncgen.units import DEGREE

MODES = ("G61", "G61.1", "G64 P0.01", "G64 P0.05 Q0.01", "G64 P0.001", "G64")
EVENTS = ("G4 P0.05", "M3 S1000", "M8", "M9")
#: How far from the start a stretch may begin, mm.
ROOM = 150.0


class Writer:
    """A program that is written, and where it has led."""

    def __init__(self, seed: int, rotary: bool) -> None:
        self.random = random.Random(seed)
        self.rotary = rotary
        self.at = [0.0, 0.0, 0.0, 0.0]
        self.motions = 0
        self.lines = ["G21 G90 G17 G94", f"F{self.random.choice((800, 3000, 12000))}", "G61"]

    def move(self, code: str = "G1", words: str = "", **step: float) -> None:
        """Write a motion by so many mm (degrees) of the axes named."""
        for letter, by in step.items():
            place = "XYZA".index(letter)
            self.at[place] = round(self.at[place] + by, 4)
        ends = "".join(f" {letter}{self.at['XYZA'.index(letter)]:.4f}" for letter in step)
        self.lines.append(f"{code}{ends}{words}")
        self.motions += 1

    def wander(self, step: float, count: int) -> None:
        """Lines whose direction changes smoothly, with a little noise."""
        heading, bend = self.random.uniform(0.0, 2.0 * math.pi), self.random.uniform(-0.15, 0.15)
        for _ in range(count):
            heading += bend * step + self.random.gauss(0.0, 0.01)
            way = {"X": math.cos(heading), "Y": math.sin(heading), "Z": 0.1 * math.sin(2.0 * heading)}
            if self.rotary:
                way["A"] = self.random.uniform(0.2, 0.4)
            self.move("G1", "", **{letter: step * part for letter, part in way.items()})

    def straight(self, step: float, count: int) -> None:
        for _ in range(count):
            self.move(X=step)

    def stairs(self, step: float, count: int) -> None:
        for _ in range(count // 4):
            self.move(X=step)
            self.move(Y=self.random.choice((-step, step)))

    def arcs(self, step: float, count: int) -> None:
        """Half circles, left and right in turn."""
        radius = 3.0 * step + 0.05
        for k in range(count // 4):
            self.move(f"G{2 + k % 2}", f" R{radius + 1e-4:.5f}", X=2.0 * radius, Y=0.0)

    def holes(self, step: float, count: int) -> None:
        for _ in range(count // 20 + 1):
            self.move("G0", X=5.0 * step)
            self.move("G0", Z=2.0)
            self.move(Z=-2.0)

    def zigzag(self, step: float, count: int) -> None:
        for k in range(count // 4):
            self.move(Y=0.3)
            self.move(X=5.0 * (-1) ** k)

    def written(self, motions: int) -> str:
        """Write until there are so many motions, and return the program."""
        shapes = (self.wander, self.wander, self.straight, self.stairs, self.arcs, self.holes, self.zigzag)
        while self.motions < motions:
            draw = self.random.random()
            if draw < 0.12:
                self.lines.append(self.random.choice(MODES))
            elif draw < 0.2:
                self.lines.append(self.random.choice((*EVENTS, "F500", "F2000", "F6000", "F20000")))
            else:
                step = self.random.choice((0.001, 0.01, 0.05, 0.2, 0.2, 1.0, 5.0))
                self.random.choice(shapes)(step, self.random.randint(1, 400))
            if max(map(abs, self.at[:3])) > ROOM:
                self.at[:3] = [0.0, 0.0, 0.0]
                self.move("G0", X=0.0, Y=0.0, Z=0.0)
        return "\n".join([*self.lines, "M2", ""])


def random_machine(seed: int) -> Machine:
    """Return a machine of four axes whose limits differ by two powers of ten and more."""
    rng = random.Random(7919 * seed + 1)
    base = cncgen.load_machine("generic-mill")
    axes = {}
    for letter in "XYZA":
        velocity = 10.0 ** rng.uniform(1.0, 3.0) * (DEGREE if letter == "A" else 1.0)
        acceleration = velocity * 10.0 ** rng.uniform(0.3, 1.7)
        jerk = acceleration * 10.0 ** rng.uniform(0.7, 2.5)
        axes[letter] = replace(
            base.axes[letter], max_velocity=velocity, max_acceleration=acceleration, max_jerk=jerk
        )
    return replace(
        base,
        name=f"random-{seed}",
        axes=MappingProxyType(axes),
        period_s=rng.choice((1e-4, 2.5e-4, 5e-4, 1e-3, 2e-3, 4e-3, 1e-2)),
        chord_tolerance_mm=rng.choice((1e-4, 1e-3, 1e-3, 1e-2)),
    )
