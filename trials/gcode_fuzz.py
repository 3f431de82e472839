"""Fuzzing of the G-code reader: mutated programs in a child process of bounded memory, each against a clock.

By hand, for as long as wanted: ``python -m trials.gcode_fuzz --minutes 60 [--seed N] [--keep DIR]``.

A mutant is a program of ours (or words put together at random) with bytes flipped, tokens swapped in, lines doubled,
cut or taken from another program. The reader may say anything about it, but not crash, take more than a second, or
more memory than it is given.
"""

from __future__ import annotations

import argparse
import io
import resource
import sys
import time
import traceback
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from cncgen.diagnostics import CncgenError, Diagnostics
from cncgen.gcode import canon, check, read
from cncgen.toolpath.reading import ReadOptions
from trials.generators.gcode_mutants import DIALECTS, corpus, mutants
from trials.seeds import first_for_tuning

#: Bounds of one input.
SECONDS = 1.0
MEMORY = 512 * 2**20
#: Blocks that an input may execute: a second's worth on a slow machine, so that endless loops end in a diagnostic.
MAX_STEPS = 5_000


@dataclass
class Outcome:
    """The result of a run of inputs; `faults` are (seed, index, what, input)."""

    inputs: int = 0
    slowest: float = 0.0
    kinds: Counter[str] = field(default_factory=Counter)
    faults: list[tuple[int, int, str, bytes]] = field(default_factory=list)


def try_one(data: bytes, dialect: str) -> str:
    """Read an input to its toolpath, check it, print its calls; return what was said about it."""
    options = ReadOptions(dialect=dialect, max_steps=MAX_STEPS, chunk_rows=4096)
    program = read(io.BytesIO(data), "fuzz.ngc", options)
    for _ in program.chunks():
        pass
    checked = Diagnostics()
    check(io.BytesIO(data), "fuzz.ngc", options, checked)
    # Columns are a matter of reading alone.
    said = [diagnostic.render() for diagnostic in program.diagnostics if diagnostic.code != "late-axis"]
    if said != [diagnostic.render() for diagnostic in checked]:
        raise AssertionError("a check says something else than reading")
    for _ in canon(io.BytesIO(data), "fuzz.ngc", options, program.diagnostics):
        pass
    for diagnostic in program.diagnostics:
        diagnostic.render()
    first = next(iter(program.diagnostics), None)
    return first.code if first else "clean"


def run(seed: int, seconds: float, most: int = sys.maxsize) -> Outcome:
    """Try mutants for so many seconds, or so many of them."""
    sources = corpus()
    outcome = Outcome()
    end = time.monotonic() + seconds
    for index, data in enumerate(mutants(seed, sources)):
        if index >= most or time.monotonic() >= end:
            return outcome
        begin = time.process_time()
        try:
            said = try_one(data, DIALECTS[index % len(DIALECTS)])
        except CncgenError as error:
            said = error.diagnostics[0].code
        except Exception:
            said = traceback.format_exc(limit=-3)
            outcome.faults.append((seed, index, said, data))
        took = time.process_time() - begin
        if took > SECONDS:
            outcome.faults.append((seed, index, f"{took:.2f} s", data))
        outcome.inputs += 1
        outcome.slowest = max(outcome.slowest, took)
        outcome.kinds[said if len(said) < 60 else "crash"] += 1
    return outcome


def bound_memory() -> None:
    """Let this process have no more memory than an input may take."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY + _mapped_now(), MEMORY + _mapped_now()))


def _mapped_now() -> int:
    """Return the address space in use: libraries count, the input's share comes on top."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


def main() -> int:
    """Fuzz for as long as the arguments say and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=first_for_tuning("gcode_fuzz"))
    parser.add_argument("--keep", type=Path, help="folder for inputs that show a fault")
    arguments = parser.parse_args()
    bound_memory()
    outcome = run(arguments.seed, 60.0 * arguments.minutes)
    print(f"{outcome.inputs} inputs, slowest {outcome.slowest:.3f} s, {len(outcome.faults)} faults")
    print(f"{len(outcome.kinds)} different outcomes: {outcome.kinds.most_common(12)}")
    for seed, index, what, data in outcome.faults:
        print(f"--- seed {seed}, input {index}: {what}")
        if arguments.keep:
            arguments.keep.mkdir(parents=True, exist_ok=True)
            (arguments.keep / f"{seed}-{index}.ngc").write_bytes(data)
    return 1 if outcome.faults else 0


if __name__ == "__main__":
    raise SystemExit(main())
