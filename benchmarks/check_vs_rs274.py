"""Reading speed: `cncgen check` and LinuxCNC's `rs274 -g` on the same million lines ``G1 X Y Z``, in one run.

    python benchmarks/check_vs_rs274.py [--lines N] [--repeat N] [--keep FILE]

Prints lines a second of both whole processes, their ratio (the best of each), and peak memory. Needs `rs274`
(``apt-get install linuxcnc-uspace``) for the comparison.
"""

from __future__ import annotations

import argparse
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Measured:
    """One whole process: wall and processor time, s, and peak resident memory, MiB."""

    wall_s: float
    cpu_s: float
    peak_mib: float


def write_program(path: Path, lines: int) -> None:
    """Write a spiral of short segments, three axes in each line."""
    with path.open("w") as file:
        file.write("G21 G90 G64 P0.01 F6000\n")
        for k in range(lines):
            angle = 0.004 * k
            radius = 20.0 + 1e-5 * k
            x, y, z = radius * math.cos(angle), radius * math.sin(angle), 1e-5 * k
            file.write(f"G1 X{x:.4f} Y{y:.4f} Z{z:.4f}\n")
        file.write("M2\n")


def measure(command: list[str]) -> Measured:
    """Run a command with its output thrown away."""
    begin = time.perf_counter()
    # Compiled modules are kept between runs, as where the program is installed.
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=kept)
    assert process.stderr is not None
    said = process.stderr.read()
    _, status, used = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"{' '.join(command)} failed:\n{said.decode()[-2000:]}")
    return Measured(time.perf_counter() - begin, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)


def compare(description: str, write: Callable[[Path, int], None], lines: int) -> None:
    """Write a program of so many lines, run both by turns, print the table."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--lines", type=int, default=lines)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--keep", type=Path, help="write the program here and keep it")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = asked.keep or Path(folder) / "segments.ngc"
        write(path, asked.lines)
        commands = {"cncgen check": [sys.executable, "-m", "cncgen", "check", str(path)]}
        if shutil.which("rs274"):
            commands["rs274 -g"] = [
                "rs274",
                "-g",
                "-n",
                "0",
                "-v",
                str(Path(folder) / "rs274.var"),
                str(path),
            ]
        else:
            print("rs274 is not installed: no comparison")
        best: dict[str, Measured] = {}
        for _ in range(asked.repeat):
            for name, command in commands.items():
                run = measure(command)
                if name not in best or run.cpu_s < best[name].cpu_s:
                    best[name] = run
    print(f"{asked.lines} lines, best of {asked.repeat} by processor time, whole process")
    for name, run in best.items():
        rate = asked.lines / run.cpu_s
        print(
            f"  {name:13} cpu {run.cpu_s:6.3f} s  wall {run.wall_s:6.3f} s  {rate:10.0f} lines/s  {run.peak_mib:6.0f} MiB"
        )
    if len(best) == 2:
        ours, theirs = best["cncgen check"], best["rs274 -g"]
        print(
            f"  ratio: {theirs.cpu_s / ours.cpu_s:.1f} x by processor time, {theirs.wall_s / ours.wall_s:.1f} x by wall time"
        )


if __name__ == "__main__":
    compare(__doc__ or "", write_program, 1_000_000)
