"""Reading speed on a program like a shop's: 100,000 lines, comments on every tenth block, arcs and feeds.

    python benchmarks/language_vs_rs274.py [--lines N] [--repeat N]

`cncgen check` and LinuxCNC's `rs274 -g` on the same file, whole processes by turns; needs `rs274`
(``apt-get install linuxcnc-uspace``).
"""

from __future__ import annotations

import math
from pathlib import Path

from check_vs_rs274 import compare


def write_program(path: Path, lines: int) -> None:
    """Write pockets: straight cuts, arcs in and out of them, a feed each, a comment on every tenth block."""
    with path.open("w") as file:
        file.write("%\nG21 G90 G17 G94\nT1 M6\nS12000 M3\nM8\nG0 X0 Y0 Z5\nF1500\n")
        x = y = 0.0
        for k in range(lines):
            note = f" (row {k // 10})" if k % 10 == 0 else ""
            kind = k % 5
            if kind == 0:
                x, y = 20.0 + 10.0 * math.cos(0.01 * k), 20.0 + 10.0 * math.sin(0.01 * k)
                file.write(f"G1 X{x:.4f} Y{y:.4f} F{800 + k % 700}{note}\n")
            elif kind in (1, 3):
                sense = "G2" if kind == 1 else "G3"
                x, y = x + 1.2, y + 0.8
                file.write(f"{sense} X{x:.4f} Y{y:.4f} R1.5{note}\n")
            elif kind == 2:
                x, y = x - 2.0, y
                file.write(f"G3 X{x:.4f} Y{y:.4f} I-1.0000 J0.0000{note}\n")
            else:
                file.write(f"G1 Z{-0.001 * (k % 1000):.4f}{note}\n")
        file.write("G0 Z50\nM30\n%\n")


if __name__ == "__main__":
    compare(__doc__ or "", write_program, 100_000)
