"""Random programs of thousands of motions, planned and judged: they reach the borders of blocks.

    python -m trials.long_programs                       # seeds 0 to 9, 7000 motions each, on generic-mill
    python -m trials.long_programs --seeds 40 60 --rotary
    python -m trials.long_programs --seeds 0 60 --motions 1000 --machine random
    python -m trials.long_programs --seeds 32 33 --write bad.nc

Each is a row of wandering lines, straight runs, staircases, chains of arcs, drilled holes and zigzags, under changing feeds
and path modes, with dwells and spindle and coolant events between them. A random machine differs by the seed too: limits
over a hundred to one between axes, setpoints every 0.1 to 10 ms, chord tolerances of 0.1 to 10 µm. A line is printed for
each: seconds of planning, seconds of motion, and what `cncgen.judge` finds broken.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import cncgen
from trials.generators.rough_parts import Writer, random_machine
from trials.seeds import first_for_tuning

FIRST = first_for_tuning("long_programs")


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--seeds", type=int, nargs=2, default=(FIRST, FIRST + 10), metavar=("FIRST", "STOP"))
    parser.add_argument("--motions", type=int, default=7000)
    parser.add_argument("--machine", default="generic-mill", help="a profile or file, or 'random'")
    parser.add_argument("--rotary", action="store_true", help="lines turn A as well")
    parser.add_argument("--write", type=Path, help="keep the last program here")
    given = parser.parse_args(arguments)
    bad = 0
    for seed in range(*given.seeds):
        machine = random_machine(seed) if given.machine == "random" else cncgen.load_machine(given.machine)
        text = Writer(seed, given.rotary).written(given.motions)
        if given.write:
            given.write.write_text(text)
        begun = time.process_time()
        program = cncgen.read_text(text)
        setpoints = cncgen.sample(cncgen.plan(program, machine)).collect()
        spent = time.process_time() - begun
        verdict = cncgen.judge(setpoints, program, machine)
        bad += not verdict.holds
        seconds = setpoints.time_s[-1]
        print(f"seed {seed}: {spent:.1f} s of work for {seconds:.1f} s of motion", flush=True)
        for breach in verdict.breaches:
            print(f"  {breach.message}", flush=True)
    print(f"{bad} of {len(range(*given.seeds))} broken")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
