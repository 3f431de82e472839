"""Random G64 programs: does the motion stay within P of the path, both ways, and within the limits?

    python -m trials.g64_tolerance 300 --seed 7
    python -m trials.g64_tolerance --only 7:41

Lines, arcs, helices, NURBS and rotary axes; cusps, reversals, retraced paths, plunges, moves of no length, waits; P from
1e-5 to ten times the moves, changed within the program, left out, with Q. The path is known here from what wrote the
program, and distances come from scipy: nothing of `cncgen.verify`, and of the planner's geometry, is used.
"""

from __future__ import annotations

import argparse
import signal
import sys
import time
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree

from cncgen.diagnostics import CncgenError
from cncgen.machine.record import Axis, Machine
from cncgen.pipeline import plan, read_text, sample
from cncgen.setpoints.columns import file_units
from cncgen.units import DEGREE

Floats = NDArray[np.float64]

AXES = "XYZAC"
CHORD_MM = 1e-3
#: A tolerance, or a limit, is broken beyond this part of it.
MARGIN = 1.001
#: Seconds of a plan.
PATIENCE_S = 120


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
        axes[letter] = Axis(letter, *(unit * limit for limit in limits))
    return Machine(
        "random", axes, period_s=float(rng.choice([0.0005, 0.001, 0.001, 0.004])), chord_tolerance_mm=CHORD_MM
    )


def to_segments(points: Floats, starts: Floats, ends: Floats, spacing: float) -> Floats:
    """Return the distance of points from segments: the segments' places at most `spacing` apart find the nearest ones."""
    parts = np.maximum(np.ceil(np.linalg.norm(ends - starts, axis=1) / spacing), 1).astype(int)
    owner = np.repeat(np.arange(len(parts)), parts)
    f = (np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts) + 0.5) / parts[owner]
    tree = cKDTree(starts[owner] + f[:, None] * (ends - starts)[owner])
    _, near = tree.query(points, k=min(4, len(owner)), workers=1)
    best = np.full(len(points), np.inf)
    for k in np.atleast_2d(near.T):
        best = np.minimum(best, to_each(points, starts[owner[k]], ends[owner[k]]))
    return best


def to_each(points: Floats, a: Floats, b: Floats) -> Floats:
    """Return the distance of each point from its segment."""
    d = b - a
    f = np.clip(((points - a) * d).sum(1) / np.maximum((d**2).sum(1), 1e-300), 0, 1)
    return np.linalg.norm(points - a - f[:, None] * d, axis=1)


def dense(points: Floats, spacing: float) -> Floats:
    """Return places on a polyline at most `spacing` apart (a million at most)."""
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    spacing = max(spacing, length.sum() / 3e5)
    parts = np.maximum(np.ceil(length / spacing), 1).astype(int)
    owner = np.repeat(np.arange(len(parts)), parts)
    f = (np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[owner]
    return np.concatenate([points[owner] + f[:, None] * np.diff(points, axis=0)[owner], points[-1:]])


def exactly(points: Floats, starts: Floats, ends: Floats) -> Floats:
    """Return the distance of a few points from all segments."""
    return np.array([to_each(np.repeat(p[None], len(starts), 0), starts, ends).min() for p in points])


def over(points: Floats, starts: Floats, ends: Floats, allowed: float) -> float:
    """Return by what factor of `allowed` the worst of the points is away from the segments, 0 where none is over it."""
    spacing = max(allowed, np.linalg.norm(ends - starts, axis=1).sum() / 3e5)
    far = np.flatnonzero(to_segments(points, starts, ends, spacing) > allowed)
    if not len(far):
        return 0.0
    some = far[:: max(len(far) // 300, 1)]
    return float((exactly(points[some], starts, ends) / allowed).max())


def distances(part: Part, setpoints: Floats) -> tuple[float, float]:
    """Return by what factor the motion leaves the path, and the path the motion; up to 1 where neither is over.

    A place of the motion has to be within the tolerance of some piece.
    """
    worst_out, worst_back = 0.0, 0.0
    tolerance = np.array(part.tolerance)
    left = dense(setpoints, tolerance.min())
    for value in np.unique(tolerance)[::-1]:
        mine = [p for p, t in zip(part.pieces, part.tolerance, strict=True) if t == value]
        starts, ends = np.concatenate([p[:-1] for p in mine]), np.concatenate([p[1:] for p in mine])
        allowed = value * MARGIN + 2e-3 * value + 1e-8
        # At its ends a piece may be as far away as its neighbour allows.
        inner = np.concatenate(
            [_inner(p, tolerance, k) for k, p in enumerate(part.pieces) if tolerance[k] == value]
        )
        if len(inner):
            worst_back = max(worst_back, over(inner, setpoints[:-1], setpoints[1:], allowed))
        if len(left):
            spacing = max(value, np.linalg.norm(ends - starts, axis=1).sum() / 3e5)
            gap = to_segments(left, starts, ends, spacing)
            far = gap > allowed
            if len(np.unique(tolerance)) == 1 and far.any():
                worst_out = over(left[far], starts, ends, allowed)
            left = left[far]
    if len(np.unique(tolerance)) > 1 and len(left):
        some = left[:: max(len(left) // 300, 1)]
        factor = np.full(len(some), np.inf)
        for value in np.unique(tolerance):
            mine = [p for p, t in zip(part.pieces, part.tolerance, strict=True) if t == value]
            starts, ends = np.concatenate([p[:-1] for p in mine]), np.concatenate([p[1:] for p in mine])
            factor = np.minimum(factor, exactly(some, starts, ends) / (value * (MARGIN + 2e-3) + 1e-8))
        worst_out = float(factor.max())
    return worst_out, worst_back


def _inner(points: Floats, tolerance: Floats, k: int) -> Floats:
    """Return dense places of a piece, without an end at which a neighbour of wider tolerance begins."""
    places = dense(points, tolerance[k])
    first = k > 0 and tolerance[k - 1] > tolerance[k]
    last = k + 1 < len(tolerance) and tolerance[k + 1] > tolerance[k]
    return places[int(first) : len(places) - int(last)]


def limits(setpoints: Floats, machine: Machine) -> float:
    """Return the largest finite difference as a part of its limit, rest before and after."""
    padded = np.concatenate([np.repeat(setpoints[:1], 3, 0), setpoints, np.repeat(setpoints[-1:], 3, 0)])
    worst = 0.0
    for column, letter in enumerate(machine.axes):
        axis = machine.axes[letter]
        unit = DEGREE if letter in "AC" else 1.0
        for k, limit in enumerate((axis.max_velocity, axis.max_acceleration, axis.max_jerk), start=1):
            size = np.abs(np.diff(padded[:, column], k)).max() / machine.period_s**k * unit
            worst = max(worst, (size - 2.0**k * 1e-12 / machine.period_s**k) / limit)
    return worst


def judge(seed: int, index: int) -> str:
    """Plan one program; return what is wrong with it, or nothing."""
    part = random_part(seed, index)
    machine = random_machine(part.rng)
    text = "\n".join(part.lines) + "\n"
    try:
        signal.alarm(PATIENCE_S)
        stream = sample(plan(read_text(text), machine))
        chunk = stream.collect()
    except CncgenError as error:
        return f"refused: {error}"
    except TimeoutError:
        return f"not done in {PATIENCE_S} s"
    finally:
        signal.alarm(0)
    position = np.zeros((len(chunk), len(AXES)))
    given = file_units(chunk.position, chunk.axes)
    for column, letter in enumerate(chunk.axes):
        position[:, AXES.index(letter)] = given[:, column]
    found = []
    if (ratio := limits(position, machine)) > MARGIN:
        found.append(f"limit x {ratio:.4f}")
    out, back = distances(part, position)
    if out > 1.0:
        found.append(f"motion leaves the path by {out:.3f} of the tolerance")
    if back > 1.0:
        found.append(f"path is missed by {back:.3f} of the tolerance")
    return "; ".join(found)


def _too_long(*_: object) -> None:
    raise TimeoutError


def main() -> int:
    """Run the programs; exit 1 where something is wrong."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("count", type=int, nargs="?", default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", metavar="SEED:INDEX", help="print this program, and judge it")
    options = parser.parse_args()
    signal.signal(signal.SIGALRM, _too_long)
    if options.only:
        seed, index = map(int, options.only.split(":"))
        print("\n".join(random_part(seed, index).lines))
        print(judge(seed, index) or "holds", file=sys.stderr)
        return 0
    wrong, begun = 0, time.process_time()
    for index in range(options.count):
        start = time.process_time()
        fault = judge(options.seed, index)
        spent = time.process_time() - start
        if fault or spent > 30:
            wrong += bool(fault)
            print(f"{options.seed}:{index}: {fault or 'slow'} ({spent:.1f} s)", flush=True)
    print(f"{options.count} programs, {wrong} wrong, {time.process_time() - begun:.0f} s")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
