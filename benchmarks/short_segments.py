"""Whole-process throughput of `cncgen plan` on programs of many short segments, of several kinds.

    python benchmarks/short_segments.py                         # every kind, 10⁴ and 10⁵ segments
    python benchmarks/short_segments.py butterfly 1000000       # one kind and size
    python benchmarks/short_segments.py corners 1000000 --effort fast
    python benchmarks/short_segments.py surface 100000 --write surface.nc

Each program is planned in a fresh process, `G64 P0.01` to setpoints in ``f64``. Printed are wall and CPU seconds, peak
memory, segments a second, the motion's time, and how the CPU time grew with the tenfold program (10 is linear).
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Length of a segment, mm.
STEP = 0.2
#: Feed, mm/min.
FEED = 6000


def resampled(points: Floats, count: int, step: float = STEP) -> Floats:
    """Return `count` + 1 points a distance `step` apart along a polyline, as far as it goes."""
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = step * np.arange(count + 1)
    return np.stack([np.interp(at[at <= s[-1]], s, column) for column in points.T], axis=1)


def butterfly(count: int) -> Floats:
    """Return the butterfly r = e^sin t − 2 cos 4t + sin⁵((2t − π)/24), again and again."""
    turn = np.linspace(0.0, 24.0 * np.pi, 400_000)
    r = np.exp(np.sin(turn)) - 2.0 * np.cos(4.0 * turn) + np.sin((2.0 * turn - np.pi) / 24.0) ** 5
    once = 12.0 * np.stack([r * np.sin(turn), r * np.cos(turn)], axis=1)
    length = np.linalg.norm(np.diff(once, axis=0), axis=1).sum()
    times = int(np.ceil(count * STEP / length)) + 1
    once = resampled(once, int(length / STEP))
    return np.concatenate([once] * times)[: count + 1]


def surface(count: int) -> Floats:
    """Return zigzag passes over a smooth random surface, 60 mm long and 0.3 mm apart, with square ends."""
    rng = np.random.default_rng(1)
    waves = rng.normal(size=(12, 2)) / 12.0
    height, phase = rng.uniform(0.2, 1.2, 12), rng.uniform(0.0, 6.28, 12)
    points = int(60.0 / STEP)
    passes = count // (points + 2) + 2
    x = np.linspace(0.0, 60.0, points + 1)
    zigzag = np.concatenate([x if n % 2 == 0 else x[::-1] for n in range(passes)])
    y = np.repeat(0.3 * np.arange(passes), len(x))
    z = sum(h * np.sin(w[0] * zigzag + w[1] * y + p) for h, w, p in zip(height, waves, phase, strict=True))
    return np.stack([zigzag, y, z], axis=1)[: count + 1]


def spiral(count: int) -> Floats:
    """Return an Archimedean spiral, 0.5 mm a turn, from 2 mm outwards."""
    turn = np.sqrt(2.0 * STEP * np.arange(count + 1) / (0.5 / (2.0 * np.pi)) + (4.0 * 2.0 * np.pi) ** 2)
    r = 0.5 / (2.0 * np.pi) * turn
    return np.stack([r * np.cos(turn), r * np.sin(turn)], axis=1)


def wander(count: int) -> Floats:
    """Return a smooth random curve in space whose curvature changes all along, radii from 0.5 mm up."""
    rng = np.random.default_rng(2)
    s = STEP * np.arange(count + 1)
    bend = sum(a * np.sin(s / w + p) for a, w, p in zip(
        rng.uniform(0.1, 0.5, 5), rng.uniform(1.5, 20.0, 5), rng.uniform(0.0, 6.28, 5), strict=True
    ))  # fmt: skip
    heading = np.cumsum(bend) * STEP
    rise = 0.3 * np.sin(s / 7.0)
    steps = STEP * np.stack(
        [np.cos(heading) * np.cos(rise), np.sin(heading) * np.cos(rise), np.sin(rise)], axis=1
    )
    return np.cumsum(steps, axis=0)


def noisy(count: int) -> Floats:
    """Return what a CAM system makes of a smooth curve: chords of 0.05 to 0.5 mm whose ends lie 2 µm beside it."""
    rng = np.random.default_rng(3)
    s = np.cumsum(rng.uniform(0.05, 0.35, count + 1))
    fine = wander(int(s[-1] / STEP) + 2)
    at = STEP * np.arange(len(fine))
    clean = np.stack([np.interp(s, at, column) for column in fine.T], axis=1)
    return clean + rng.normal(scale=0.002, size=clean.shape).clip(-0.004, 0.004)


def corners(count: int) -> Floats:
    """Return rows of squares, triangles and stars of a few mm: sharp corners every 10 to 40 segments."""
    rng = np.random.default_rng(4)
    angle = np.cumsum(rng.choice([0.5, 0.7, 1.57, -1.57, 2.1, -1.0], size=count // 10 + 2))
    length = rng.uniform(2.0, 8.0, len(angle))
    vertices = np.cumsum(length[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1), axis=0)
    number = np.maximum((length[1:] / STEP).astype(int), 1)
    edge = np.repeat(np.arange(len(number)), number)
    part = (np.arange(len(edge)) - np.repeat(np.cumsum(number) - number, number)) / number[edge]
    return (vertices[edge] + part[:, None] * np.diff(vertices, axis=0)[edge])[: count + 1]


def zigzag(count: int) -> Floats:
    """Return finishing passes: lines of 60 mm, 0.3 mm apart, square at their ends."""
    k = np.arange(count + 1)
    return np.stack([60.0 * ((k + 1) // 2 % 2), 0.3 * (k // 2)], axis=1)


def teeth(count: int) -> Floats:
    """Return a zigzag of 0.3 mm: a turn of 127° at every point."""
    k = np.arange(count + 1)
    return np.stack([0.13 * k, 0.27 * (k % 2)], axis=1)


def infill(count: int) -> Floats:
    """Return layers of a printed part: rings about a lobed outline, then diagonal lines 0.4 mm apart across it."""
    layer: list[Floats] = []
    angle = np.linspace(0.0, 2.0 * np.pi, 240, endpoint=False)
    for inset in (0.2, 0.6, 1.0):
        r = 14.0 + 2.0 * np.cos(5.0 * angle) - inset
        layer.append(np.stack([r * np.cos(angle), r * np.sin(angle)], axis=1))
    across = np.arange(-13.0, 13.0, 0.4)
    half = np.sqrt(11.0**2 - (across.clip(-10.9, 10.9)) ** 2)
    ends = np.where(np.arange(len(across)) % 2 == 0, half, -half)
    lines = np.stack([np.repeat(across, 2), np.stack([-ends, ends], axis=1).ravel()], axis=1)
    layer.append(lines @ np.array([[0.7071, 0.7071], [-0.7071, 0.7071]]))
    once = np.concatenate(layer)
    times = count // len(once) + 1
    height = 0.2 * np.repeat(np.arange(times), len(once))
    return np.column_stack([np.tile(once, (times, 1)), height])[: count + 1]


KINDS: dict[str, Callable[[int], Floats]] = {
    f.__name__: f for f in (butterfly, surface, spiral, wander, noisy, corners, zigzag, teeth, infill)
}


def adaptive(count: int) -> list[str]:
    """Return adaptive clearing: an arc that cuts, another back, a line ahead; 200 times in a lane, then deeper."""
    rows = ["G0 X0 Y0"]
    for k in range(count // 3):
        if k % 200 == 0:
            rows += ["G0 Z5", "G0 X0 Y0", f"G1 Z{-0.5 * (k // 200 % 20):.3f}"]
        x = 0.35 * (k % 200)
        rows += [f"G3 X{x:.3f} Y5 R2.6", f"G3 X{x:.3f} Y0 R4", f"G1 X{x + 0.35:.3f} Y0"]
    return rows


def rounded_square(x: float, y: float, half: float, radius: float) -> list[str]:
    """Return the rows of a square with round corners, from its lower right corner on."""
    a, b = half, half - radius
    ends = [(a, b), (b, a), (-b, a), (-a, b), (-a, -b), (-b, -a), (b, -a), (a, -b)]
    words = ["G1", "G3"] * 4
    return [
        f"{word} X{x + dx:.3f} Y{y + dy:.3f}" + (f" R{radius:.3f}" if word == "G3" else "")
        for word, (dx, dy) in zip(words, ends, strict=True)
    ]


def pockets(count: int) -> list[str]:
    """Return pockets cut from the middle by rounded squares, 2 mm apart, with rapids between the pockets."""
    rows: list[str] = []
    for k in range(count // 66 + 1):
        x, y = 40.0 * (k % 10), 40.0 * (k // 10 % 10)
        rows += ["G0 Z5", f"G0 X{x:.3f} Y{y:.3f}", "G1 Z-2"]
        for n in range(7):
            half, radius = 1.5 + 2.0 * n, 1.0 + 0.5 * n
            rows.append(f"G1 X{x + half:.3f} Y{y - half + radius:.3f}")
            rows += rounded_square(x, y, half, radius)
    return rows[:count]


def drilling(count: int) -> list[str]:
    """Return holes: rapids there, a plunge and a rapid out, three rows a hole."""
    rows: list[str] = []
    for k in range(count // 3):
        rows += [f"G0 X{4.0 * (k % 100):.3f} Y{4.0 * (k // 100 % 100):.3f} Z2", "G1 Z-6", "G0 Z2"]
    return rows


#: Kinds that are no polylines: their rows as they are written.
ROWS: dict[str, Callable[[int], list[str]]] = {f.__name__: f for f in (adaptive, pockets, drilling)}


def write(kind: str, count: int, path: str | os.PathLike[str]) -> None:
    """Write a program of `count` segments of a kind, coordinates with three decimals."""
    if kind in ROWS:
        rows = "\n".join(ROWS[kind](count))
        Path(path).write_text(f"(START, X0 Y0 Z5)\nG21 G17 G90 G94 G64 P0.01\nF{FEED}\n{rows}\nM2\n")
        return
    points = np.round(KINDS[kind](count), 3) + 0.0
    names = "XYZ"[: points.shape[1]]
    row = "G1 " + " ".join(f"{name}%.3f" for name in names)
    rows = list(map(row.__mod__, map(tuple, points.tolist())))
    start = " ".join(f"{name}{value:.3f}" for name, value in zip(names, points[0], strict=True))
    head = f"(START, {start})\nG21 G17 G90 G94 G64 P0.01\nF{FEED}\n"
    Path(path).write_text(head + "\n".join(rows[1:]) + "\nM2\n")


@dataclass(frozen=True, slots=True)
class Run:
    """What a process took: seconds, MiB, and the seconds that its setpoints last."""

    wall_s: float
    cpu_s: float
    memory_mib: float
    motion_s: float


def spent(*words: str | os.PathLike[str]) -> tuple[float, float, float]:
    """Run `cncgen` with these words in a fresh process; return its wall and CPU seconds, and its peak memory in MiB.

    Raises:
        subprocess.CalledProcessError: The process failed.
    """
    command = [sys.executable, "-P", "-m", "cncgen", *map(str, words)]
    begin = time.perf_counter()
    child = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    wall = time.perf_counter() - begin
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise subprocess.CalledProcessError(child.returncode, command)
    return wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0


def measure(program: Path, machine: str, effort: str) -> Run:
    """Plan a program in a fresh process with an effort.

    Raises:
        subprocess.CalledProcessError: The process failed.
    """
    output, summary = program.with_suffix(".f64"), program.with_suffix(".json")
    used = spent("plan", program, "-m", machine, "--effort", effort, "-o", output, "--summary", summary)
    motion = float(json.loads(summary.read_text())["motion_time_s"])
    output.unlink()
    return Run(*used, motion)


def table(kinds: Sequence[str], counts: Sequence[int], machine: str, effort: str) -> None:
    """Print a row for each kind and size."""
    print(
        f"{'kind':10} {'segments':>9} {'wall s':>8} {'CPU s':>8} {'MiB':>6} {'segments/s':>11} {'motion s':>10} growth"
    )
    with tempfile.TemporaryDirectory() as folder:
        for kind in kinds:
            before: Run | None = None
            for count in counts:
                program = Path(folder) / "program.nc"
                # Written by another process: what this one holds would count as the planner's.
                subprocess.run(
                    [sys.executable, __file__, kind, str(count), "--write", str(program)], check=True
                )
                run = measure(program, machine, effort)
                growth = f"{run.cpu_s / before.cpu_s:6.1f}" if before else ""
                print(
                    f"{kind:10} {count:9d} {run.wall_s:8.2f} {run.cpu_s:8.2f} {run.memory_mib:6.0f} "
                    f"{count / run.wall_s:11.0f} {run.motion_s:10.2f} {growth}",
                    flush=True,
                )
                before = run


def main() -> None:
    """Write one program, or measure."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("kind", nargs="?", default="all", choices=["all", *KINDS, *ROWS])
    parser.add_argument("counts", nargs="*", type=int, help="segments (10000 100000)")
    parser.add_argument("-m", "--machine", default="generic-mill")
    parser.add_argument("--effort", default="best", choices=["best", "fast"], help="as of cncgen plan (best)")
    parser.add_argument("--write", metavar="FILE", help="write the program of that kind and size instead")
    asked = parser.parse_args()
    if asked.write:
        write(asked.kind, asked.counts[0], asked.write)
        return
    table(
        [*KINDS, *ROWS] if asked.kind == "all" else [asked.kind],
        asked.counts or [10_000, 100_000],
        asked.machine,
        asked.effort,
    )


if __name__ == "__main__":
    main()
