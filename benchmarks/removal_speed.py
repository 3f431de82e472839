"""Cut a block of 200 x 200 x 20 mm along many short lines: seconds of CPU and peak memory of the whole command, a tool after the other.

    python benchmarks/removal_speed.py [--lines 1000000] [--cell 0.1] [--leaning] [TOOL ...]

The lines, 0.2 mm long, go to and fro over a wavy surface at most 5 mm deep. `--leaning` swings the tool by B up to 15 degrees, on a
machine whose head turns about the tip. TOOL is a form of ``--tool``.
"""

import argparse
import math
import os
import subprocess
import sys
import tempfile
from importlib import resources
from pathlib import Path

TOOLS = ("flat:6", "ball:6", "bull:6,1", "ball:20", "bull:12,2", "bull:20,4")
#: Lines in a row, and rows over the block, whose side is as long, mm.
ROW, SIDE = 1000, 200.0
KINEMATICS = '\n[kinematics]\nmodel = "head-head"\naxes = ["c", "b"]\npivot_mm = 0.0\n'


def write(path: Path, lines: int, leaning: bool) -> None:
    """Write the first lines of a million."""
    with path.open("w", encoding="ascii") as stream:
        stream.write(f"G21 G90 G94\nS1000 M3\nG0 X0 Y0 Z10{' B15' if leaning else ''}\nF3000\n")
        for k in range(lines):
            row, column = divmod(k, ROW)
            x = SIDE / (ROW - 1) * (column if row % 2 == 0 else ROW - 1 - column)
            y = SIDE / ROW * row
            z = -2 - 1.5 * math.sin(x / 15) - 1.5 * math.cos(y / 20)
            turn = f" B{15 * math.cos(x / 40):.3f}" if leaning else ""
            stream.write(f"G1 X{x:.3f} Y{y:.4f} Z{z:.3f}{turn}\n")
        stream.write("M2\n")


def main() -> None:
    """Write the program and cut it with each tool, in processes of their own."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lines", type=int, default=1_000_000)
    parser.add_argument("--cell", type=float, default=0.1)
    parser.add_argument("--leaning", action="store_true")
    parser.add_argument("tools", nargs="*", default=TOOLS, metavar="TOOL")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        program, machine = Path(folder, "wave.nc"), Path(folder, "head.toml")
        write(program, options.lines, options.leaning)
        mill = resources.files("cncgen.machine.profiles") / "generic-mill.toml"
        machine.write_text(mill.read_text() + KINEMATICS)
        block = f"box:0,0,-20,{SIDE:g},{SIDE:g},0"
        call = [sys.executable, "-P", "-m", "cncgen", "cut", str(program), "--stock", block, "--quiet"]
        call += ["--cell", str(options.cell)]
        call += ["--machine", str(machine)] if options.leaning else []
        for tool in options.tools:
            child = subprocess.Popen([*call, "--tool", f"*={tool}"], stdout=subprocess.DEVNULL)
            _, status, used = os.wait4(child.pid, 0)
            cpu, peak = used.ru_utime + used.ru_stime, used.ru_maxrss / 1024
            ended = "" if os.waitstatus_to_exitcode(status) == 0 else "  failed"
            print(f"{tool:10} {options.lines:8d} lines  {cpu:7.2f} s CPU  {peak:6.0f} MiB{ended}", flush=True)


if __name__ == "__main__":
    main()
