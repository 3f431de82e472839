"""Random bodies of O-words, run in every way, through our interpreter and LinuxCNC's.

``python -m trials.bodies_beside_rs274 [COUNT [SEED]]`` prints the seed, each disagreement and the first body that shows it.
"""

from __future__ import annotations

import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from trials.generators.gcode_bodies import body, ways
from trials.peer_cases import FILES
from trials.peer_comparison import difference, ours
from trials.rs274 import Setup, installed, run_once, without_reset
from trials.seeds import first_for_tuning

#: Bodies of one program: the peer takes longer to start than to run one.
TOGETHER = 8
_FILE = "random_body"


def disagreements(bodies: list[list[str]], folder: Path, again: bool) -> Iterator[tuple[str, str, str]]:
    """Yield the ways of running bodies on which the two disagree: name, what differs, program."""
    for name, text, called in ways(bodies, _FILE, again):
        program = folder / "random.ngc"
        program.write_text(text)
        (folder / f"{_FILE}.ngc").write_text(called)
        setup = Setup(tools=FILES / "mill.tbl", include=(folder,))
        try:
            peer = run_once(program, setup)
        except subprocess.TimeoutExpired:
            yield name, "the peer does not come to an end", text
            continue
        if peer.error is not None:
            peer.calls = without_reset(peer.calls)
            peer.partial = min(2, len(peer.calls))
        found = difference(program, ours(program, setup), peer)
        if found is not None:
            yield name, found, text


def main(count: int, seed: int) -> int:
    """Run so many bodies, in programs of `TOGETHER`; return how many disagreed, as an exit code."""
    if not installed():
        print("rs274 is not installed (apt-get install linuxcnc-uspace)", file=sys.stderr)
        return 2
    dice = random.Random(seed)
    faults, begin = 0, time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        for done in range(0, count, TOGETHER):
            does, again = dice.random() < 0.5, dice.random() < 0.5
            bodies = [body(dice, number, does, again) for number in range(min(TOGETHER, count - done))]
            for name, found, text in disagreements(bodies, Path(folder), again):
                faults += 1
                print(f"seed {seed}, bodies from {done} on, {name}: {found}\n{text if faults == 1 else ''}")
    print(
        f"seed {seed}: {count} bodies in 5 or 7 ways, {faults} disagreements, {time.perf_counter() - begin:.0f} s"
    )
    return int(faults > 0)


if __name__ == "__main__":
    arguments = [int(argument) for argument in sys.argv[1:]]
    sys.exit(main(*(arguments + [500, first_for_tuning("bodies_beside_rs274")][len(arguments) :])))
