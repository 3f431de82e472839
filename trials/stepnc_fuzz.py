"""Mutate STEP-NC files and read, check and execute each: no exception, no hang, no unbounded memory.

    python -m trials.stepnc_fuzz [--count 100000] [--seed 1] [--seconds 20] [FILE...]

Without files: NIST's two and small ones of our own. Says every file that failed (kept in the folder --keep).
"""

import argparse
import io
import random
import resource
import signal
import sys
import time
import traceback
import warnings
from pathlib import Path

from cncgen.diagnostics import CncgenError
from cncgen.stepnc import read, tree, write_ap238
from cncgen.toolpath.reading import ReadOptions
from trials.generators.stepnc_mutants import mutate, samples
from trials.seeds import first_for_tuning

#: Files between two lines that say how far it is.
PROGRESS = 5000


def run(data: bytes) -> None:
    """Read, execute, write and list one file; faults of the file are diagnostics."""
    program = read(data, "fuzz.stp", ReadOptions(chunk_rows=4096, max_steps=20_000))
    chunks = list(program.chunks())
    if not program.diagnostics.has_errors:
        write_ap238(chunks, io.StringIO())
    if len(data) < 20_000:
        for _ in tree(data, "fuzz.stp", ReadOptions(max_steps=2_000)):
            pass


def main() -> int:
    """Run the mutations; return 1 where one failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*")
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=first_for_tuning("stepnc_fuzz"))
    parser.add_argument("--seconds", type=int, default=20, help="of CPU per file, before it counts as a hang")
    parser.add_argument("--memory-gb", type=float, default=2.0)
    parser.add_argument("--keep", default="")
    options = parser.parse_args()
    limit = int(options.memory_gb * 2**30)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    warnings.simplefilter("ignore")
    signal.signal(signal.SIGPROF, _hang)
    if options.keep:
        Path(options.keep).mkdir(parents=True, exist_ok=True)
    sources = samples(options.files)
    chance, failed, begin, slowest = random.Random(options.seed), 0, time.time(), 0.0
    for k in range(options.count):
        data = mutate(chance.choice(sources), chance)
        signal.setitimer(signal.ITIMER_PROF, options.seconds)
        now = time.time()
        try:
            run(data)
        except CncgenError:
            pass
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt):
                raise
            failed += 1
            place = traceback.extract_tb(error.__traceback__)[-1]
            print(
                f"{k}: {type(error).__name__}: {error} at {Path(place.filename).name}:{place.lineno}",
                flush=True,
            )
            if options.keep:
                Path(options.keep, f"{k}.stp").write_bytes(data)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        slowest = max(slowest, time.time() - now)
        if (k + 1) % PROGRESS == 0:
            print(f"{k + 1} files, {failed} failed, {time.process_time():.0f} s of CPU", flush=True)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{options.count} files, {failed} failed, {time.time() - begin:.0f} s, slowest {slowest:.2f} s, {peak:.0f} MB"
    )
    return 1 if failed else 0


def _hang(number: int, frame: object) -> None:
    raise TimeoutError("hang")


if __name__ == "__main__":
    sys.exit(main())
