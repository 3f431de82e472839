"""Derivatives of `cncgen why` beside finite differences by other plans, over random programs.

    python -m trials.shortening                    # 40 programs from seed 0
    python -m trials.shortening 40 --seed 1000

A program cuts a few outlines (polygons, rounded pockets, waves of short lines) and drills holes, in G61 or G64 P, with rapids,
tool changes and dwells, on a machine of random limits. One rule judges all quantities. Each is planned with the relative changes
±`STEPS`, all within 5 %, none of which `why` plans; the finite difference is the straight line through the odd parts
(t(+h) - t(-h)) / 2 of these times, by least squares. It is for the change that `why` prints seconds of, 10 %.

- A derivative that is printed may differ from it by 2 %.
- Of "no effect" no change may change the time by more than the bound that is stated with it, of "does not bind" none up to 2.5 %.
  The largest change is told, as a part of the cycle.
- A kink is true where the slopes at 0 of parabolas through the plans of either side differ by more than 2 % of the larger.
- Scatter is true where the plans leave twice the standard error of the difference above 1 % of it; its bound holds where the
  difference lies within. A bend is true where differences of ±2 and ±5 %, by a parabola through the odd parts, differ by more
  than 2 %; its bound holds where both lie within.
- The bound of few plans holds where the difference lies within.
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
from numpy.typing import NDArray

import cncgen
from cncgen.machine.record import Machine
from cncgen.planner import PlanOptions
from cncgen.report.shortening import (
    CHANGE,
    Case,
    Quantity,
    Slope,
    SlopeKind,
    planned_times,
    quantities,
    shortenings,
)
from trials.seeds import first_for_tuning

Floats = NDArray[np.float64]
FIRST = first_for_tuning("shortening")
#: Relative changes up and down.
STEPS = np.array((0.009, 0.016, 0.021, 0.027, 0.033, 0.039, 0.044, 0.048))
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
    """What `why` says of a quantity of a program, and what other plans say of it.

    Attributes:
        seed, name: The program and the quantity.
        slope: What `why` says.
        rises_s: Seconds that each of `STEPS` lengthens the cycle, or the part that counts.
        falls_s: The same of the opposite changes.
        cycle_s: Cycle time.
        sign: +1 where a rise of the quantity shortens.
    """

    seed: int
    name: str
    slope: Slope
    rises_s: Floats
    falls_s: Floats
    cycle_s: float
    sign: int

    def differences_s(self, seconds: Floats, *powers: int) -> float:
        """Return what the whole change saves by a least-squares curve of these powers through 0."""
        fit, *_ = np.linalg.lstsq(np.stack([STEPS**k for k in powers], axis=1), seconds, rcond=None)
        return -self.sign * CHANGE * float(fit[0])

    @property
    def by_differences_s(self) -> float:
        """What the whole change saves by the finite difference."""
        return self.differences_s((self.rises_s - self.falls_s) / 2.0, 1)

    def by_steps_s(self, step: float) -> float:
        """Return what the whole change saves by a difference of ±`step`, by a parabola through the odd parts."""
        terms = np.stack([STEPS, STEPS**2], axis=1)
        (first, turn), *_ = np.linalg.lstsq(terms, (self.rises_s - self.falls_s) / 2.0, rcond=None)
        return -self.sign * CHANGE * float(first + turn * step)

    @property
    def changed_s(self) -> float:
        """By how much the time changes at most where it is said not to."""
        near = (0.025 if self.slope.kind is SlopeKind.SLACK else CHANGE) >= STEPS
        return float(max(np.abs(self.rises_s[near]).max(), np.abs(self.falls_s[near]).max()))

    @property
    def off(self) -> float:
        """Relative difference of a derivative that is printed."""
        given = self.slope.seconds
        return (
            abs(self.by_differences_s / given - 1.0) if self.slope.kind is SlopeKind.SMOOTH and given else 0.0
        )

    @property
    def true(self) -> bool:
        """Whether what `why` says holds by the rule above."""
        slope = self.slope
        if slope.kind is SlopeKind.ENOUGH:
            return abs(self.by_differences_s - slope.seconds) <= slope.bound
        if slope.kind is SlopeKind.KINK:
            sides = self.differences_s(self.rises_s, 1, 2), -self.differences_s(self.falls_s, 1, 2)
            return abs(sides[0] - sides[1]) > ASKED * max(map(abs, sides))
        if slope.kind is SlopeKind.SCATTER:
            found = self.by_differences_s
            rest = (self.rises_s - self.falls_s) / 2.0 + self.sign * found * STEPS / CHANGE
            error = CHANGE * np.sqrt(rest @ rest / (len(STEPS) - 1) / (STEPS @ STEPS))
            return bool(2.0 * error > 0.01 * abs(found)) and abs(found - slope.seconds) <= slope.bound
        if slope.kind is SlopeKind.BEND:
            small, large = self.by_steps_s(0.02), self.by_steps_s(0.05)
            within = max(abs(small - slope.seconds), abs(large - slope.seconds)) <= slope.bound
            return within and abs(large - small) > ASKED * abs(slope.seconds)
        if slope.kind is SlopeKind.SMOOTH and slope.seconds:
            return self.off <= ASKED
        return self.changed_s <= max(slope.bound, 1e-6 * self.cycle_s)


def compared(seed: int) -> list[Compared]:
    """Return all quantities of a program."""
    program = cncgen.read_text(Part(seed).written())
    case = Case(program.chunks, machine_for(seed), PlanOptions())
    now, found = shortenings(case, "XYZ")
    known = {each.name: each for each in found}
    result = []
    for quantity in quantities(case, "XYZ"):

        def longer(step: float, quantity: Quantity = quantity) -> float:
            times = planned_times(quantity.scaled(case, 1.0 + step))
            part = quantity.part
            return times.parts[part] - now.parts[part] if part else times.cycle_s - now.cycle_s

        rises, falls = (np.array([longer(sign * step) for step in STEPS]) for sign in (1.0, -1.0))
        slope = known[quantity.name].slope
        result.append(Compared(seed, quantity.name, slope, rises, falls, now.cycle_s, quantity.sign))
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("programs", type=int, nargs="?", default=40)
    parser.add_argument("--seed", type=int, default=FIRST)
    given = parser.parse_args(arguments)
    counts: Counter[str] = Counter()
    false: Counter[str] = Counter()
    worst = none = 0.0
    for seed in range(given.seed, given.seed + given.programs):
        for each in compared(seed):
            counts[each.slope.kind] += 1
            worst = max(worst, each.off)
            if each.slope.derivative == 0.0:
                none = max(none, each.changed_s / each.cycle_s)
            if not each.true:
                false[each.slope.kind] += 1
                print(
                    f"seed {seed}, {each.name}: {each.slope.kind}, {each.slope.seconds:.6f} s ± {each.slope.bound:.6f},"
                    f" by differences {each.by_differences_s:.6f} s, {100 * each.off:.1f} % off; cycle {each.cycle_s:.3f} s;"
                    f" longer by {np.round(each.rises_s, 6).tolist()}, {np.round(each.falls_s, 6).tolist()}",
                    flush=True,
                )
    print(
        f"{given.programs} programs: the worst derivative {100 * worst:.2f} % off; no effect is {none:.1e} of the cycle at most"
    )
    print("\n".join(f"{kind}: {count}, {false[kind]} of them false" for kind, count in counts.items()))
    return 1 if false else 0


if __name__ == "__main__":
    sys.exit(main())
