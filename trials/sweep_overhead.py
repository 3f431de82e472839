"""What a sweep costs beside its jobs: processor time of the driver and of a worker, at jobs of about a second.

    python -m trials.sweep_overhead --jobs 60

The program is a zigzag whose lines are doubled until one job takes a second of processor time in this process. Then the
sweep runs on one process. Its worker adds up the time of its jobs; all else that driver and worker used is overhead.
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from cncgen.sweep.definition import SweepDefinition, load_sweep
from cncgen.sweep.driver import run_sweep
from cncgen.sweep.jobs import JobOutcome, SweepJob, code_version, compute, compute_batch, take_bundles
from cncgen.sweep.local_workers import LocalWorkers
from cncgen.sweep.varying import jobs_of

SWEEP = """
programs = ["part.nc"]
machine = "xy-table"
[vary]
"axes.*.max_jerk_mm_s3" = {{ log = [2e4, 2e5] }}
[draw]
design = "latin_hypercube"
points = {jobs}
seed = 1
[keep]
figures = ["cycle_time_s", "contour_error_max_mm"]
"""


def timed_batch(version: str, batch: Sequence[SweepJob], log: str) -> tuple[list[JobOutcome], float]:
    """Compute a batch; append its processor time and the number of its jobs to a file."""
    begun = time.process_time()
    result = compute_batch(version, batch)
    with open(log, "a", encoding="ascii") as file:
        file.write(f"{time.process_time() - begun!r} {len(batch)}\n")
    return result


class TimedWorkers(LocalWorkers):
    """Local workers that log the processor time of each batch."""

    log = ""

    def submit(self, batch: tuple[SweepJob, ...]) -> None:
        """Hand over a batch."""
        self._running[self._pool.submit(timed_batch, code_version(), batch, self.log)] = batch


def sweep_of(lines: int, jobs: int) -> SweepDefinition:
    """Return a sweep of a zigzag of so many lines, in the working directory."""
    rows = (f"G1 X{k * 0.5 % 200:g} Y{10 * (k % 2)}" for k in range(1, lines))
    Path("part.nc").write_text("\n".join(["G21 G17 G90 G61 F6000", *rows, "M2\n"]))
    Path("sweep.toml").write_text(SWEEP.format(jobs=jobs))
    return load_sweep("sweep.toml")


def calibrated(jobs: int) -> SweepDefinition:
    """Return a sweep of which a job takes a second at least."""
    lines = 64
    while True:
        sweep = sweep_of(lines, jobs)
        take_bundles(list(sweep.programs.values()))
        _, job = next(iter(jobs_of(sweep).jobs.values()))
        spent = []
        for _ in range(2):
            begun = time.process_time()
            outcome = compute(job)
            spent.append(time.process_time() - begun)
            if outcome.code:
                raise SystemExit(outcome.error)
        if spent[1] >= 1.0:
            return sweep
        lines *= 2


def children_s() -> float:
    """Return the processor time of children that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Run the trial."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=60)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        sweep = calibrated(given.jobs)
        TimedWorkers.log = f"{folder}/spent"
        before, begun = children_s(), time.process_time()
        workers = TimedWorkers(1, list(sweep.programs.values()))
        try:
            end = run_sweep(sweep, "R", workers)
        finally:
            workers.close()
        driver, worker = time.process_time() - begun, children_s() - before
        rows = [line.split() for line in Path("spent").read_text().splitlines()]
        jobs = sum(float(row[0]) for row in rows)
        count = sum(int(row[1]) for row in rows)
        os.chdir("/")
    if end.failed or count != given.jobs:
        raise SystemExit(f"{end.failed} of {count} jobs failed")
    print(f"{count} jobs: {jobs:.2f} s, {jobs / count:.2f} s each")
    print(f"driver: {driver:.2f} s, {100 * driver / jobs:.2f} % of the jobs")
    print(
        f"worker beside its jobs, its start among it: {worker - jobs:.2f} s, {100 * (worker - jobs) / jobs:.2f} %"
    )


if __name__ == "__main__":
    main()
