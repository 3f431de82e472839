"""List the programs that do not agree yet: ``python tests/peer/pending.py [-v]`` writes pending.txt anew.

The list may only shrink: a program that agrees and still stands in it fails its test.
"""

from __future__ import annotations

import sys
from pathlib import Path

from comparison import CHOICES, PEER_FAULTS, difference, ours
from rs274 import EXPECTED, Output, programs

HEAD = "# Programs that the interpreter does not run as LinuxCNC does yet, each with the first thing that differs.\n"


def main(verbose: bool) -> int:
    """Compare every program and write those that differ with what differs first."""
    rows = []
    for program in programs():
        peer = Output.parse((EXPECTED / f"{program.stem}.canon").read_text())
        try:
            found = difference(program, ours(program), peer)
        except Exception as error:
            found = f"{type(error).__name__}: {error}"
        if found and program.stem not in PEER_FAULTS and program.stem not in CHOICES:
            rows.append(f"{program.stem}: {found.splitlines()[0]:.150}\n")
            if verbose:
                print(rows[-1], end="")
    (Path(__file__).parent / "pending.txt").write_text(HEAD + "".join(rows))
    print(f"{len(rows)} of {len(programs())} differ")
    return 0


if __name__ == "__main__":
    raise SystemExit(main("-v" in sys.argv[1:]))
