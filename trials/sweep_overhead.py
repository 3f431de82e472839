"""What a sweep costs beside its jobs of about a second: on processes and on a dask cluster, beside a plain pool of processes.

    python -m trials.sweep_overhead --jobs 60 --workers 2

The program is a zigzag of so many lines that one job takes a second of processor time in this process. The same jobs are
then computed by the standard library's pool with nothing around it, by a sweep on processes, and by a sweep on a local cluster.
Workers add up the processor time of their jobs; all else that they and the driver used is overhead, the start of processes among it, that of the cluster not. Times by the
clock mean something where the machine does nothing else.
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path

from cncgen.sweep.cluster import ClusterWorkers
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
        self._running[self._started_pool().submit(timed_batch, code_version(), batch, self.log)] = batch


class TimedCluster(ClusterWorkers):
    """Workers of a cluster that log so."""

    log = ""

    def submit(self, batch: tuple[SweepJob, ...]) -> None:
        """Hand over a batch."""
        key = f"timed-{batch[0].key}"
        future = self._client.submit(timed_batch, code_version(), batch, self.log, key=key, pure=False)
        self._running[future] = batch


def sweep_of(lines: int, jobs: int) -> SweepDefinition:
    """Return a sweep of a zigzag of so many lines, in the working directory."""
    rows = (f"G1 X{k * 0.5 % 200:g} Y{10 * (k % 2)}" for k in range(1, lines))
    Path("part.nc").write_text("\n".join(["G21 G17 G90 G61 F6000", *rows, "M2\n"]))
    Path("sweep.toml").write_text(SWEEP.format(jobs=jobs))
    return load_sweep("sweep.toml")


def calibrated(jobs: int) -> SweepDefinition:
    """Return a sweep of which a job takes a second, or a tenth more."""
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
        lines = int(lines * max(1.05, min(8.0, 1.05 / spent[1])))


def children_s() -> float:
    """Return the processor time of children that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def in_a_pool(sweep: SweepDefinition, workers: int) -> float:
    """Compute the jobs in the standard library's pool, one at a time."""
    bundles = list(sweep.programs.values())
    jobs = [(job,) for _, job in jobs_of(sweep).jobs.values()]
    with ProcessPoolExecutor(workers, get_context("spawn"), take_bundles, (bundles,)) as pool:
        list(pool.map(timed_batch, repeat(code_version()), jobs, repeat("spent")))
    return 0.0


def on_processes(sweep: SweepDefinition, workers: int) -> float:
    """Run the sweep on processes."""
    TimedWorkers.log = os.path.abspath("spent")
    swept(sweep, "processes", TimedWorkers(workers, list(sweep.programs.values())))
    return 0.0


def on_a_cluster(sweep: SweepDefinition, workers: int) -> float:
    """Run the sweep on a local cluster, whose scheduler is a thread of this process; return what it used before, s."""
    from distributed import Client, LocalCluster

    begun = time.process_time()
    TimedCluster.log = os.path.abspath("spent")
    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0") as cluster:
        address = cluster.scheduler_address
        with Client(address, set_as_default=False) as client:
            before = time.process_time() - begun + sum(client.run(time.process_time).values())
        swept(sweep, "cluster", TimedCluster(address, list(sweep.programs.values())))
    return before


def swept(sweep: SweepDefinition, results: str, workers: TimedWorkers | TimedCluster) -> None:
    """Run the sweep and let the workers go."""
    try:
        end = run_sweep(sweep, results, workers)
    finally:
        workers.close()
    if end.failed:
        raise SystemExit(f"{end.failed} jobs failed")


def main() -> None:
    """Run the trial."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=60)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    ways = {
        "a plain pool": in_a_pool,
        "a sweep on processes": on_processes,
        "a sweep on a cluster": on_a_cluster,
    }
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        sweep = calibrated(given.jobs)
        plain_s = 0.0
        for way, run in ways.items():
            Path("spent").write_text("")
            used, wall = children_s() + time.process_time(), time.monotonic()
            before = run(sweep, given.workers)
            wall, used = time.monotonic() - wall, children_s() + time.process_time() - used - before
            rows = [line.split() for line in Path("spent").read_text().splitlines()]
            if sum(int(row[1]) for row in rows) != given.jobs:
                raise SystemExit(f"{way}: {sum(int(row[1]) for row in rows)} of {given.jobs} jobs were done")
            jobs = sum(float(row[0]) for row in rows)
            plain_s = plain_s or wall
            beside = f"{used - jobs:.2f} s of processors beside them, {100 * (used - jobs) / jobs:.2f} %"
            clock = f"{wall:.1f} s by the clock, {100 * (wall / plain_s - 1):+.1f} %"
            print(f"{way}: {given.jobs} jobs of {jobs / given.jobs:.2f} s; {beside}; {clock}", flush=True)
        os.chdir("/")


if __name__ == "__main__":
    main()
