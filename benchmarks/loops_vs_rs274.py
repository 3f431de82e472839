"""Speed of a program that computes: 100,000 blocks executed by nested O-word loops and expressions.

    python benchmarks/loops_vs_rs274.py [--lines N] [--repeat N]

`cncgen check` and LinuxCNC's `rs274 -g` on the same file, whole processes by turns; needs `rs274`
(``apt-get install linuxcnc-uspace``).
"""

from __future__ import annotations

from pathlib import Path

from check_vs_rs274 import compare

#: Blocks executed in one round of the inner loop.
INNER = 7

PROGRAM = """G21 G90 G94 F1000
o<point> sub
#<r> = [#1 * 0.5 + #2]
o<point> endsub [#<r> * 2]
#1 = 0
o100 while [#1 LT {outer}]
#2 = 0
#3 = [10 + 5 * SIN[#1 / 10]]
o101 while [#2 LT 100]
#4 = [#3 + 0.01 * #2]
o102 if [#2 MOD 2 EQ 0]
G1 X[#4 * COS[#2 * 3.6]] Y[#4 * SIN[#2 * 3.6]] Z[-#2 / 100]
o102 else
X[#4 + 1] Y[ABS[#4 - 5]] F[500 + #2]
o102 endif
#2 = [#2 + 1]
o101 endwhile
o<point> call [#1] [#2]
#1 = [#1 + 1]
o100 endwhile
M2
"""


def write_program(path: Path, lines: int) -> None:
    """Write the program whose loops execute about `lines` blocks."""
    path.write_text(PROGRAM.format(outer=max(1, lines // (100 * INNER))))


if __name__ == "__main__":
    compare(__doc__ or "", write_program, 100_000)
