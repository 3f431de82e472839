"""Random programs through our interpreter and LinuxCNC's.

``python -m trials.language_beside_rs274 [COUNT [SEED]] [--stages STAGE …]`` prints after each batch how many were run, and each disagreement shrunk to the smallest program that shows it.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from hypothesis import HealthCheck, given, seed, settings

from trials.generators.gcode_language import STAGES, programs
from trials.peer_comparison import disagreement
from trials.rs274 import installed
from trials.seeds import first_for_tuning

#: Examples between two seeds: a run of them ends at its first disagreement.
BATCH = 100


def batch(number: int, examples: int, stages: tuple[str, ...], folder: Path) -> tuple[int, str | None]:
    """Run examples of one seed; return how many ran, and the shrunk disagreement, or None."""
    ran = 0
    last: list[str] = []

    @seed(number)
    @settings(max_examples=examples, database=None, deadline=None, suppress_health_check=list(HealthCheck))
    @given(text=programs(stages))
    def check(text: str) -> None:
        nonlocal ran
        ran += 1
        found = disagreement(text, folder)
        if found is not None:
            last[:] = [f"{text}\n  {found}"]
            raise AssertionError(found)

    try:
        check()
    except AssertionError:
        return ran, last[0]
    return ran, None


def main(total: int, first_seed: int, stages: tuple[str, ...]) -> int:
    """Run batches until `total` programs were compared."""
    if not installed():
        print("rs274 is not installed (apt-get install linuxcnc-uspace)", file=sys.stderr)
        return 2
    ran, number, faults = 0, first_seed, 0
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        while ran < total:
            count, fault = batch(number, min(BATCH, total - ran), stages, Path(folder))
            ran, number = ran + count, number + 1
            if fault is not None:
                faults += 1
                print(f"--- seed {number - 1}\n{fault}\n")
            elapsed = time.perf_counter() - begin
            print(f"{ran} programs, {faults} disagreements (shrunk), {elapsed:.0f} s", flush=True)
    return min(faults, 1)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Random programs through our interpreter and LinuxCNC's.")
    parser.add_argument("count", type=int, nargs="?", default=10_000, help="programs [default: %(default)s]")
    parser.add_argument(
        "seed",
        type=int,
        nargs="?",
        default=first_for_tuning("language_beside_rs274"),
        help="first seed, one a batch [default: %(default)s]",
    )
    parser.add_argument(
        "--stages",
        nargs="+",
        choices=STAGES,
        default=tuple(STAGES),
        help="what programs are made of [default: all]",
    )
    chosen = parser.parse_args()
    raise SystemExit(main(chosen.count, chosen.seed, tuple(chosen.stages)))
