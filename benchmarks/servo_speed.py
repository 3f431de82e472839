"""Speed of the servo bench: python benchmarks/servo_speed.py [SAMPLES] [GAIN SETS].

Closed-loop simulation of two axes under each controller with its contour error, on 1,000,000 samples unless said
otherwise; then a search of 1,000 gain sets on one process and on one a core. CPU seconds are of the process (best of three),
wall seconds beside them: on a machine with other work the ratio of the two says how much of it this had.
"""

from __future__ import annotations

import argparse
import os
import time

import numpy as np

from cncgen.machine import load_servos
from cncgen.servo.named_schemes import scheme_maker
from cncgen.servo.simulate import simulate_scheme
from cncgen.servo.tuning.search import search
from cncgen.setpoints.record import Setpoints

PERIOD = 0.001


def curve(samples: int) -> np.ndarray:
    """Return a Lissajous figure that fills some 60 mm at up to 140 mm/s, shape (samples, 2)."""
    t = np.arange(samples) * PERIOD
    ease = np.minimum(t / 0.5, 1.0)
    return np.column_stack([30.0 * np.sin(2.0 * t * ease), 30.0 * np.sin(3.0 * t * ease)])


def stream(rows: np.ndarray) -> list[Setpoints]:
    """Return rows as chunks of a setpoint stream."""
    return [Setpoints("XY", PERIOD, k, rows[k : k + 8192]) for k in range(0, len(rows), 8192)]


def simulated(name: str, machine: str, setpoints: list[Setpoints]) -> tuple[float, float, float]:
    """Return CPU seconds, wall seconds and largest contour error (µm) of a run under a controller."""
    maker = scheme_maker(name, load_servos(machine))
    wall, cpu, largest = time.perf_counter(), time.process_time(), 0.0
    for part in simulate_scheme(iter(setpoints), maker):
        largest = max(largest, float(part.contour_error_mm.max()))
    return time.process_time() - cpu, time.perf_counter() - wall, 1e3 * largest


def main() -> None:
    """Print both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("samples", type=int, nargs="?", default=1_000_000, help="[default: %(default)s]")
    parser.add_argument("sets", type=int, nargs="?", default=1000, help="gain sets [default: %(default)s]")
    samples, sets = vars(parser.parse_args()).values()
    setpoints = stream(curve(samples))
    print(f"{samples} samples of two axes")
    for machine, names in (("dyna-1007", ("p", "zpetc", "ccc", "zpetc+ccc", "tcf")), ("xy-table", ("p", "ccc", "tcf")),
                           ("die-bonder", ("p",))):  # fmt: skip
        for name in names:
            best = min(simulated(name, machine, setpoints) for _ in range(3))
            print(
                f"  {machine:12} {name:10} {best[0]:6.2f} s CPU {best[1]:6.2f} s wall, error {best[2]:.4g} µm"
            )
    short = stream(curve(4000))
    servos = load_servos("xy-table")
    cores = len(os.sched_getaffinity(0))
    walls = []
    for workers in (1, cores):
        start, spent = time.perf_counter(), cpu_seconds()
        search(short, servos, sets=sets, workers=workers)
        walls.append(time.perf_counter() - start)
        spent = cpu_seconds() - spent
        print(
            f"{sets} gain sets on 4000 samples, {workers} process(es): {walls[-1]:.2f} s wall, {spent:.2f} s CPU in all"
        )
    print(
        f"  {cores} processes are {walls[0] / walls[-1]:.2f} times as fast as one (where the cores are otherwise idle)"
    )


def cpu_seconds() -> float:
    """Return the CPU time of this process and of those that it has ended."""
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system


if __name__ == "__main__":
    main()
