"""Derivatives of `cncgen why` beside finite differences of other steps, over random programs.

    python -m trials.shortening                    # 40 programs from seed 0
    python -m trials.shortening 40 --seed 1000

A program cuts a few outlines (polygons, rounded pockets, waves of short lines) and drills holes, in G61 or G64 P, with rapids,
tool changes and dwells, on a machine of random limits. Each derivative that `why` gives is compared with the odd cubic that fits
plans with the quantity changed by `STEPS` best (by half of these where `why` says that the time is smooth so far only): sixteen plans, none of which `why` has made, so that their own scatter (some 10⁻⁵ of
the time) counts little. Asked is agreement to 2 %. Derivatives that are 0, and quantities that have none, are counted by what `why` says of them.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

import cncgen
from cncgen.machine.record import Machine
from cncgen.planner import PlanOptions
from cncgen.report.shortening import CHANGE, Case, SlopeKind, planned_times, quantities, shortenings
from trials.seeds import first_for_tuning

FIRST = first_for_tuning("shortening")
#: Relative changes up and down of the differences that are compared with.
STEPS = (0.017, 0.029, 0.041, 0.048, 0.059, 0.068, 0.079, 0.091)
ASKED = 0.02


class Part:
    """A program that is written.

    Attributes:
        lines: Its blocks.
    """

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        mode = self.random.choice(("G61", "G64 P0.01", "G64 P0.02", "G64 P0.05"))
        self.lines = [f"G21 G90 G17 G94 {mode} F{self.random.randint(500, 8000)}"]

    def number(self, low: float, high: float) -> float:
        return round(self.random.uniform(low, high), 3)

    def outline(self) -> None:
        """A polygon round a place, in a plane below it."""
        x, y, size = self.number(10, 80), self.number(10, 60), self.number(5, 25)
        count, first = self.random.randint(3, 8), self.number(0, 6)
        corners = [
            (
                x + size * math.cos(first + k * 2 * math.pi / count),
                y + size * math.sin(first + k * 2 * math.pi / count),
            )
            for k in range(count + 1)
        ]
        self.lines += [f"G0 X{corners[0][0]:.3f} Y{corners[0][1]:.3f}", "G0 Z1", "G1 Z-2"]
        self.lines += [f"G1 X{x:.3f} Y{y:.3f}" for x, y in corners[1:]] + ["G0 Z5"]

    def pocket(self) -> None:
        """A rectangle with round corners."""
        x, y = self.number(5, 60), self.number(5, 40)
        w, h, r = self.number(8, 40), self.number(8, 30), self.number(1, 4)
        self.lines += [f"G0 X{x + r:.3f} Y{y:.3f}", "G0 Z1", "G1 Z-2"]
        for dx, dy, ex, ey, i, j in (
            (w - r, 0, w, r, 0, r),
            (w, h - r, w - r, h, -r, 0),
            (r, h, 0, h - r, 0, -r),
            (0, r, r, 0, r, 0),
        ):
            self.lines.append(f"G1 X{x + dx:.3f} Y{y + dy:.3f}")
            self.lines.append(f"G3 X{x + ex:.3f} Y{y + ey:.3f} I{i:.3f} J{j:.3f}")
        self.lines.append("G0 Z5")

    def wave(self) -> None:
        """Short lines along a sine."""
        x, y, high, long = self.number(5, 40), self.number(10, 50), self.number(1, 6), self.number(10, 30)
        self.lines += [f"G0 X{x:.3f} Y{y:.3f}", "G0 Z1", "G1 Z-1"]
        for k in range(1, 25):
            self.lines.append(
                f"G1 X{x + 1.5 * k:.3f} Y{y + high * math.sin(2 * math.pi * 1.5 * k / long):.4f}"
            )
        self.lines.append("G0 Z5")

    def holes(self) -> None:
        """A row of holes with a dwell, after a tool change."""
        tool = self.random.randint(1, 9)
        self.lines += [f"T{tool} M6", f"S{self.random.randint(1, 12)}000 M3"]
        for k in range(self.random.randint(1, 3)):
            self.lines.append(f"G0 X{10 + 7 * k} Y{self.number(0, 50):.3f}")
            self.lines += ["G0 Z1", f"G1 Z-{self.number(2, 8):.3f}", "G4 P0.1", "G0 Z5"]

    def written(self) -> str:
        """Return the program."""
        for _ in range(self.random.randint(1, 3)):
            self.random.choice((self.outline, self.pocket, self.wave, self.holes))()
        return "\n".join([*self.lines, "M2", ""])


def machine_for(seed: int) -> Machine:
    """Return a machine of three axes with random limits, and times of its tool changer and spindle."""
    rng = random.Random(7919 * seed + 3)
    base = cncgen.load_machine("generic-mill")
    axes = {}
    for letter in "XYZ":
        velocity = rng.uniform(150.0, 800.0)
        acceleration = velocity * rng.uniform(4.0, 15.0)
        jerk = acceleration * rng.uniform(10.0, 60.0)
        axes[letter] = replace(
            base.axes[letter], max_velocity=velocity, max_acceleration=acceleration, max_jerk=jerk
        )
    times = {"tool_change_s": round(rng.uniform(1.0, 6.0), 1), "spindle_acceleration_rpm_s": 6000.0}
    return replace(
        base, name=f"random-{seed}", axes=MappingProxyType(axes), settings={**base.settings, "times": times}
    )


@dataclass(frozen=True)
class Compared:
    """A quantity of a program: seconds that the change saves by `why` (None: no derivative) and by differences."""

    seed: int
    name: str
    cycle_s: float
    kind: SlopeKind
    given_s: float | None
    differences_s: float = 0.0

    @property
    def off(self) -> float:
        """Relative difference."""
        return abs(self.differences_s / self.given_s - 1.0) if self.given_s else 0.0


def compared(seed: int) -> list[Compared]:
    """Return all quantities of a program."""
    program = cncgen.read_text(Part(seed).written())
    case = Case(program.chunks, machine_for(seed), PlanOptions())
    now, found = shortenings(case, "XYZ")
    known = {each.name: each for each in found}
    result = []
    for quantity in quantities(case, "XYZ"):
        slope = known[quantity.name].slope
        given = slope.derivative
        if not given:
            result.append(Compared(seed, quantity.name, now.cycle_s, slope.kind, given))
            continue
        odd = []
        steps = np.array(STEPS) * slope.reach / CHANGE
        for step in steps:
            high, low = (planned_times(quantity.scaled(case, 1.0 + sign * step)) for sign in (1, -1))
            rise = (
                high.parts[quantity.part] - low.parts[quantity.part]
                if quantity.part
                else high.cycle_s - low.cycle_s
            )
            odd.append(rise / 2.0)
        fit, *_ = np.linalg.lstsq(np.stack([steps, steps**3], axis=1), np.array(odd), rcond=None)
        result.append(
            Compared(
                seed, quantity.name, now.cycle_s, slope.kind, given, -quantity.sign * CHANGE * float(fit[0])
            )
        )
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("programs", type=int, nargs="?", default=40)
    parser.add_argument("--seed", type=int, default=FIRST)
    given = parser.parse_args(arguments)
    counts: Counter[str] = Counter()
    worst = 0.0
    for seed in range(given.seed, given.seed + given.programs):
        for each in compared(seed):
            counts["given" if each.given_s else each.kind] += 1
            worst = max(worst, each.off)
            if each.off > ASKED:
                counts["off"] += 1
                print(
                    f"seed {seed}, {each.name}: {each.given_s:.6f} s, by differences {each.differences_s:.6f} s,"
                    f" {100 * each.off:.1f} % off; cycle {each.cycle_s:.3f} s",
                    flush=True,
                )
    others = ", ".join(f"{count} {kind}" for kind, count in counts.items() if kind not in ("given", "off"))
    print(
        f"{given.programs} programs: {counts['given']} derivatives, the worst {100 * worst:.2f} % off, {counts['off']} by more than"
        f" {100 * ASKED:.0f} %; others: {others}"
    )
    return 1 if counts["off"] else 0


if __name__ == "__main__":
    sys.exit(main())
